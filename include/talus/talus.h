#pragma once
/*
  Talus - implicit material point method on PETSc.

  The model has PETSc's life cycle: Create, SetFromOptions, Run, Destroy; Destroy takes the address and sets NULL. All
  calls are collective. The examples use SI units; the engine itself does not know units. Tension is positive.

  A step, as data flows through it:

    MpmParticlesMigrate   points go to the ranks that own their cells; the partition follows the points
    MpmTermsSetUpSpace    shape weights, groups of points that touch the same nodes, active nodes and their numbers
    SNESSolve             residual and Jacobian from the pointwise kernel; MpmTermsResidual, MpmTermsTangent
    MpmCommitLocal        converged: history, positions and domains become those of n+1; otherwise nothing has changed
    history, output
*/
#include <petscdmswarm.h>
#include <petscsf.h>
#include <petscsnes.h>
#include "talus/compat.h"
#include "talus/point/tables.h"

#define MPM_VERSION "0.1.0"

/* Exit statuses of the program. */
#define MPM_EXIT_INPUT  2 /* the scene or an option is wrong: nothing was written */
#define MPM_EXIT_GAVEUP 3 /* the run gave up: results so far, a checkpoint and the summary are there */
#define MPM_EXIT_FILE   4 /* a file could not be written: results so far and the last checkpoint are there */

/*
  One field of a physics: its unknowns at the nodes and what the kernel sees of it at a point.

  An increment field (the displacement) restarts at zero each step. Any other field is solved for as a total. With
  `rate` the engine keeps the field's value at the points, hands it to the kernel as value_n, and starts the step from
  its projection to the nodes.
*/
typedef struct {
  const char *name;
  PetscInt    components; /* 0: as many as the space has dimensions */
  PetscBool   value;      /* is the value an input of the kernel? */
  PetscBool   gradient;   /* is the gradient? */
  PetscBool   increment;
  PetscBool   rate;
} MpmField;

/*
  A physics: its fields, in the order of their unknowns at a node, and its kernel. Inputs of the kernel, in this order:
  for every field, for every component, its value (if used) and then its derivatives along the axes (if used).

  The first field must be the displacement increment with as many components as dimensions: it moves the points.
*/
typedef struct {
  const char     *name;
  const char     *summary;
  PetscInt        field_count;
  const MpmField *fields;
  MpmKernelSet    kernels[4]; /* [2] and [3] are used */
  PetscInt        parameter_count;
  const double   *parameters;
} MpmPhysics;

/* How the Jacobian is made; the names are the values of -mpm_jacobian. */
typedef enum {
  MPM_JACOBIAN_AUTO,
  MPM_JACOBIAN_LOCAL,
  MPM_JACOBIAN_COLORING,
  MPM_JACOBIAN_MATFREE,
  MPM_JACOBIAN_DENSE,
  MPM_JACOBIAN_FD
} MpmJacobianType;
extern const char *const MpmJacobianTypes[];

typedef struct _p_MpmModel *MpmModel;

/*
  A body force: N per m3 of the initial volume, at a point that stood at X in the initial state. Both have `dim`
  components.
*/
typedef PetscErrorCode (*MpmBodyForce)(PetscInt dim, PetscReal time, const PetscReal X[], PetscReal force[], void *ctx);

/*@
  MpmModelCreate - an empty model

  MpmModelSetPhysics - use a physics that is not built in; before MpmModelSetFromOptions(), the struct is borrowed

  MpmModelSetBodyForce - a body force besides the scene's loads; before MpmModelRun()

  MpmModelSetFromOptions - read the whole scene from the options database and build grid, bodies and conditions

  Fails with MPM_ERR_INPUT and one line that names the option.

  MpmModelRun - all steps; writes the results; status is 0, or MPM_EXIT_GAVEUP with the reason printed and in the
  summary
@*/
PetscErrorCode MpmModelCreate(MPI_Comm comm, MpmModel *model);
PetscErrorCode MpmModelSetPhysics(MpmModel model, const MpmPhysics *physics);
PetscErrorCode MpmModelSetBodyForce(MpmModel model, MpmBodyForce force, void *ctx);
PetscErrorCode MpmModelSetFromOptions(MpmModel model);
PetscErrorCode MpmModelRun(MpmModel model, int *status);
PetscErrorCode MpmModelDestroy(MpmModel *model);

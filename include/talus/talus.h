#pragma once
/*
  Talus - implicit material point method on PETSc.

  A model has PETSc's life cycle:

    MpmModelCreate
    MpmModelSetOptions, ...SetOptionsPrefix, ...SetPhysics, ...SetBodyForce      as wanted
    MpmModelSetFromOptions   the scene is read
    MpmModelSetUp            points, grid and solver are made; Step and Run do it where it has not been done
    MpmModelStep             one step and no files, as often as wanted; or MpmModelRun: all of them, with results
    MpmModelDestroy          takes the address and sets NULL

  Any number of models live side by side in one process, each with options of its own. Unless a docstring says
  otherwise, a call is collective on the model's communicator. An error is an error code, and nothing is printed but by
  PETSc's error handler: MPM_ERR_INPUT for a scene or an option that is wrong, with one line that names it;
  PETSC_ERR_FILE_WRITE for a file; PETSC_ERR_ARG_... for a call that does not fit.

  The examples use SI units; the engine itself does not know units. Tension is positive.

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

/* How the Jacobian is made; the names are the values of -mpm_jacobian. */
typedef enum {
  MPM_JACOBIAN_AUTO,
  MPM_JACOBIAN_LOCAL,
  MPM_JACOBIAN_COLORING,
  MPM_JACOBIAN_MATFREE,
  MPM_JACOBIAN_DENSE,
  MPM_JACOBIAN_FD
} MpmJacobianType;
typedef struct _p_MpmModel *MpmModel;

/*
  A body force: N per m3 of the initial volume, at a point that stood at X in the initial state. Both have `dim`
  components. Of a physics without displacement: the source of each of its first `dim` unknowns.
*/
typedef PetscErrorCode (*MpmBodyForce)(PetscInt dim, PetscReal time, const PetscReal X[], PetscReal force[], void *ctx);

/* Values that a condition prescribes at a node at X, one for each of its components, in their unit. */
typedef PetscErrorCode (*MpmConditionValue)(PetscInt dim, const PetscReal X[], PetscReal value[], void *ctx);

/* How a model stands after a step. */
typedef enum {
  MPM_RUNNING,   /* there is more to do */
  MPM_COMPLETED, /* the end of the last stage has been reached */
  MPM_STOPPED,   /* MpmModelStop() was called; the next step goes on */
  MPM_GAVE_UP    /* no step that was tried has converged: the state is that before it */
} MpmStatus;

/* Called before or after a step. */
typedef PetscErrorCode (*MpmStepHook)(MpmModel model, void *ctx);

/* The shared library shows what stands between push and pop. */
#pragma GCC visibility push(default)

extern const char *const MpmJacobianTypes[];

/* ---- what is there besides what was compiled in ---- */

/*@
  MpmLawRegister - offers constitutive laws to the models of this process, under -mpm_material_NAME_type

  Not collective, but all ranks must register the same; before MpmModelSetFromOptions() of those who use them

  Input Parameters:
+ count     - number of instances
- instances - for each law all that the build compiles: each MpmForm in 2D and in 3D. Names and functions
              are borrowed until PetscFinalize()

  Notes:
  The registry is the process', and stays: registering the same law again does nothing. Fails with MPM_ERR_INPUT where
  another law has the name, or where an instance is missing.
@*/
PetscErrorCode MpmLawRegister(PetscInt count, const MpmLawInstance instances[]);

/*@
  MpmPhysicsRegister - offers a physics under -mpm_physics; else as MpmLawRegister()

  The struct is copied; what its pointers point to is borrowed until PetscFinalize().
@*/
PetscErrorCode MpmPhysicsRegister(const MpmPhysics *physics);

/* ---- life ---- */

/*@
  MpmModelCreate - an empty model

  MpmModelDestroy - frees all of it; not in a hook

  Arrays that MpmModelGetPoints() has lent must have been restored.
@*/
PetscErrorCode MpmModelCreate(MPI_Comm comm, MpmModel *model);
PetscErrorCode MpmModelDestroy(MpmModel *model);

/*@
  MpmModelView - writes what the model consists of: scene, grid, space of the last step, solver

  Collective; after MpmModelSetUp(). The viewer must be one for text. -mpm_view does it at the end of a run.
@*/
PetscErrorCode MpmModelView(MpmModel model, PetscViewer viewer);

/*@
  MpmModelSetOptions - the model's options, as they would stand on a command line; before MpmModelSetFromOptions()

  Input Parameter:
. options - `-mpm_dim 2 -snes_rtol 1e-8 -options_file scene.yaml ...`; later options override earlier ones. Words
            are split at blanks, so a value with blanks needs a file

  Notes: The model then looks at nothing else: not at the program's command line, nor at PETSC_OPTIONS. Several calls
  add up. Without this call the model copies the options database that is in force at MpmModelSetFromOptions(): later
  changes there do not reach the model. Fails with MPM_ERR_INPUT for a file that cannot be read.
@*/
PetscErrorCode MpmModelSetOptions(MpmModel model, const char options[]);

/*@
  MpmModelSetOptionsPrefix - the model takes those options that begin with a prefix; before MpmModelSetFromOptions()

  Input Parameter:
. prefix - without a dash: with `left_` the model's -mpm_dim is -left_mpm_dim, and its -snes_rtol -left_snes_rtol

  Notes:
  Options without the prefix are not the model's. Its messages name options without the prefix.
@*/
PetscErrorCode MpmModelSetOptionsPrefix(MpmModel model, const char prefix[]);

/*@
  MpmModelSetPhysics - use a physics that is not built in; before MpmModelSetFromOptions()

  The struct is copied; what its pointers point to is borrowed until MpmModelDestroy().
@*/
PetscErrorCode MpmModelSetPhysics(MpmModel model, const MpmPhysics *physics);

/*@
  MpmModelSetBodyForce - a body force besides the scene's loads, N/m3 of the initial volume; NULL: none
@*/
PetscErrorCode MpmModelSetBodyForce(MpmModel model, MpmBodyForce force, void *ctx);

/*@
  MpmModelUseTerminal - progress and warnings go to stdout and stderr, as the program `talus` shows them

  Without this call a model prints nothing.
@*/
PetscErrorCode MpmModelUseTerminal(MpmModel model);

/*@
  MpmModelSetFromOptions - reads the whole scene from the model's options

  Fails with MPM_ERR_INPUT and one line that names the option.
@*/
PetscErrorCode MpmModelSetFromOptions(MpmModel model);

/*@
  MpmModelSetUp - makes points, discretization and solver of the scene that has been read, or takes up a checkpoint

  Does nothing where it has been done.
@*/
PetscErrorCode MpmModelSetUp(MpmModel model);

/* ---- steps ---- */

/*@
  MpmModelRun - all remaining steps; writes the results

  Output Parameter:
. status - 0, or MPM_EXIT_GAVEUP with the reason in the summary and at MpmModelGetReason()

  Once a model: a run that has ended is closed. A scene of one point (physics stress_point) is run or set up, not
  stepped, and lends no points.
@*/
PetscErrorCode MpmModelRun(MpmModel model, int *status);

/*@
  MpmModelStep - one step, cut as often as it takes; a stage that has ended gives way to the next one before

  Output Parameter:
. status - see MpmStatus. A model that has given up may be stepped again, under other loads for example

  Note:
  Writes no files. A geostatic stage is one step.
@*/
PetscErrorCode MpmModelStep(MpmModel model, MpmStatus *status);

/*@
  MpmModelStop - asks for the end of the run after the step under way, or before the next one; from a hook, for example

  Not collective, but all ranks of the model must call it. A run that is stopped writes its results and a checkpoint.
@*/
PetscErrorCode MpmModelStop(MpmModel model);

/*@
  MpmModelGetReason - why the last step was given up; NULL where it was not. Lent until the next step. Not collective
@*/
PetscErrorCode MpmModelGetReason(MpmModel model, const char **why);

/*@
  MpmModelGetTime - time, s, and number of the last step that has been taken; either may be NULL. Not collective

  MpmModelGetTimeStep - the length of the next step, s, as it will be tried first. Not collective

  MpmModelSetTimeStep - another one, > 0. A scene without adaptive steps still meets all multiples of its step, and
  grows back to it
@*/
PetscErrorCode MpmModelGetTime(MpmModel model, PetscReal *time, PetscInt *step);
PetscErrorCode MpmModelGetTimeStep(MpmModel model, PetscReal *dt);
PetscErrorCode MpmModelSetTimeStep(MpmModel model, PetscReal dt);

/*@
  MpmModelSetBeforeStep - a function that is called before each step, once however often it is cut; NULL: none

  MpmModelSetAfterStep - and one that is called after each that has been accepted, before it is reported

  Notes:
  A hook may look at and change points and loads, and step other models; not set up, step, run or destroy its own. An
  error that it returns ends the step.
@*/
PetscErrorCode MpmModelSetBeforeStep(MpmModel model, MpmStepHook hook, void *ctx);
PetscErrorCode MpmModelSetAfterStep(MpmModel model, MpmStepHook hook, void *ctx);

/* ---- loads and reactions ---- */

/*@
  MpmModelSetLoadFactor - the factor of a load from the next step on, in place of its ramp

  MpmModelSetLoadValue - the vector of a load from the next step on, `dim` components: N in total for a force, m/s2 for
  gravity, Pa for a traction

  Not collective, but all ranks must set the same. Fails with PETSC_ERR_ARG_OUTOFRANGE where there is no load of this
  name. Neither stands in a checkpoint.
@*/
PetscErrorCode MpmModelSetLoadFactor(MpmModel model, const char name[], PetscReal factor);
PetscErrorCode MpmModelSetLoadValue(MpmModel model, const char name[], const PetscReal value[]);

/*@
  MpmModelSetConditionValue - values of a condition by place, in place of its `value`, times its ramp

  After MpmModelSetFromOptions(), before the first step. Not collective, but all ranks must set the same

  Input Parameters:
+ name  - of the condition
. value - called at each of its nodes, once a step; NULL: `value` again
- ctx   - borrowed until MpmModelDestroy()

  Note:
  For unknowns other than a displacement: fails with PETSC_ERR_SUP where the condition prescribes one, and with
  PETSC_ERR_ARG_OUTOFRANGE where there is no condition of this name. Does not stand in a checkpoint.
@*/
PetscErrorCode MpmModelSetConditionValue(MpmModel model, const char name[], MpmConditionValue value, void *ctx);

/*@
  MpmModelGetReaction - force of a condition, a motion or a boundary on the material at the end of the last step

  Not collective: all ranks have the sum.

  Output Parameter:
. reaction - `dim` components along the axes, N (2D: N per metre); of a condition no more than a node has unknowns
@*/
PetscErrorCode MpmModelGetReaction(MpmModel model, const char name[], PetscReal reaction[]);

/* ---- points ---- */

/*@
  MpmModelGetPointCount - how many points this rank and all ranks hold; either may be NULL. Not collective
@*/
PetscErrorCode MpmModelGetPointCount(MpmModel model, PetscInt *local, PetscInt *total);

/*@
  MpmModelGetPoints - borrows a field of this rank's points as an array

  MpmModelRestorePoints - returns it: before the next step, or before the hook returns

  Not collective

  Input Parameter:
. name - position, position0 (m; now and at the start, `dim`), F (dim x dim, row-major), stress (Cauchy, Pa; xx, yy, zz,
         xy (, yz, xz)), volume0 (m3), state (history of the material, see MpmModelFindState()), own (history of the
         physics), value (of fields with a rate)

  Output Parameters:
+ components - numbers a point; may be NULL
- array      - components of point 0, of point 1, ...; points change their order and their rank from step to step

  Notes: Values written become the state from which the next step starts. F, stress and state belong together: a change
  of one requires changes of the others by the material's law. Fails with PETSC_ERR_ARG_OUTOFRANGE where the model has
  no such field.
@*/
PetscErrorCode MpmModelGetPoints(MpmModel model, const char name[], PetscInt *components, PetscReal **array);
PetscErrorCode MpmModelRestorePoints(MpmModel model, const char name[], PetscInt *components, PetscReal **array);

/*@
  MpmModelGetPointIds - borrows the numbers of this rank's points: they stay with the points, from 0 on over all bodies

  MpmModelGetPointMaterials - borrows the index of each point's material in -mpm_materials

  Not collective. Not to be written to.
@*/
PetscErrorCode MpmModelGetPointIds(MpmModel model, const PetscInt **id);
PetscErrorCode MpmModelRestorePointIds(MpmModel model, const PetscInt **id);
PetscErrorCode MpmModelGetPointMaterials(MpmModel model, const PetscInt **material);
PetscErrorCode MpmModelRestorePointMaterials(MpmModel model, const PetscInt **material);

/*@
  MpmModelFindState - place of a history variable of a material in the field `state`, or of the physics in `own`

  Not collective

  Input Parameters:
+ material - the name of its block; NULL: the physics
- variable - the name that its law, or the physics, gives it

  Output Parameters:
+ first      - of its components among those of a point
- components - how many; may be NULL
@*/
PetscErrorCode MpmModelFindState(MpmModel model, const char material[], const char variable[], PetscInt *first,
                                 PetscInt *components);

/* ---- check ---- */

/* How far apart the Jacobian's forms are, relative to the form `local` in the Frobenius norm. */
typedef struct {
  PetscReal coloring, dense; /* assembled by block colours, and column by column */
  PetscReal matfree[2];      /* actions on a vector, with points' tangents kept and without */
  PetscReal differences;     /* finite ones: of the order of 1e-7, or the kernel's derivatives are wrong */
} MpmJacobianCheck;

/*@
  MpmModelCheckJacobian - compares the Jacobian's forms for the next step, for who has written a law or a physics

  Input Parameter:
. cells - size of the random increment at which they are taken: of a displacement in cells, of another field in its own
          unit; 0.01 is a good value

  Note:
  The state stays as it is. Costs as many residuals as there are unknowns: for small models.
@*/
PetscErrorCode MpmModelCheckJacobian(MpmModel model, PetscReal cells, MpmJacobianCheck *check);

#pragma GCC visibility pop

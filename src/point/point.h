#pragma once
/*
  Registries of constitutive laws and physics, the layout of a physics' unknowns and inputs, and states with a wanted stress.
*/
#include "base/base.h"
#include "talus/talus.h"

typedef struct MpmOptions MpmOptions;

#define MPM_MAX_BLOCK  8    /* unknowns a node: displacement, pressure, damage, ... */
#define MPM_MAX_INPUTS 24   /* inputs of a kernel */
#define MPM_NU_LOCKS   0.45 /* Poisson's ratio above which material is nearly incompressible */

/* ---- material.c ---- */

/* One material of the scene: a law, its parameters' values, and the law compiled for each form. */
typedef struct MpmMaterial {
  char        *name;
  MpmLawInfo   info;
  double      *parameter;
  double      *physics_parameter; /* what the physics takes of this material */
  MpmLawTable *table;             /* by parameter */
  MpmFunction  law[MPM_FORM_COUNT];
  PetscReal    density, nu; /* nu: Poisson's ratio, 0 where the law has none */
  PetscReal    stiffness;   /* at rest, Pa */
  PetscReal    penalty; /* scale of penalties: E where the law has it; a constrained modulus locks as nu goes to 1/2 */
  PetscReal    spacing; /* most cells from point to point on an axis at the start; 0: unknown */
  PetscInt     state_size;
} MpmMaterial;

/* Materials, with the names of their blocks. */
typedef struct {
  PetscInt     count;
  char       **names;
  MpmMaterial *at;
} MpmMaterials;

/* Finds a law by name, as compiled for a form. Returns PETSC_FALSE where there is none. */
PetscBool      MpmLawFind(const char *name, PetscInt dim, MpmForm form, MpmLawInfo *info);
PetscErrorCode MpmMaterialCreate(const MpmOptions *options, const char *name, PetscInt dim, MpmMaterial *material);
/* The parameters of the physics, which stand in the material's block too. */
PetscErrorCode MpmMaterialReadPhysics(const MpmOptions *options, const MpmPhysics *physics, MpmMaterial *material);
PetscErrorCode MpmMaterialDestroy(MpmMaterial *material);
/* The law's stiffness at a state, Pa, as MpmLawInfo has it; `state` and `F` may be NULL: at rest. */
PetscReal MpmMaterialStiffness(const MpmMaterial *material, const PetscReal state[], const PetscReal F[]);
/*
  The law's answer and its derivative in a direction of anything that it depends on; `input` without parameters and
  tables, which are the material's. Non-zero where the law has no answer.
*/
int MpmMaterialSensitivity(const MpmMaterial *material, const MpmLawInput *input, const MpmLawInput *direction,
                           const MpmLawOutput *value, const MpmLawOutput *derivative);
/* Components of one history variable. */
PetscInt MpmStateComponents(const MpmStateVariable *variable, PetscInt dim);
/* Initial history of a material, after the tables of its law. */
void MpmMaterialStateAtRest(const MpmMaterial *material, PetscInt dim, PetscReal state[]);

/* ---- parameter.c ---- */

/*
  Reads one parameter of a law into a number, or into a table that MpmTablesDestroy() frees, or PetscFree() its `value`.
  The other of the two is zero. Collective.
*/
PetscErrorCode MpmParameterRead(const MpmOptions *block, const MpmParameter *parameter, double *value,
                                MpmLawTable *table);
PetscErrorCode MpmTablesDestroy(size_t count, MpmLawTable **table);

/* ---- physics.c ---- */

/*
  The layout that follows from a physics' fields: block size, and which basis function and component each kernel input
  takes.
*/
typedef struct MpmLayout {
  PetscInt  dim, block, inputs, rates;
  PetscInt  component_first[MPM_MAX_BLOCK + 1]; /* inputs of component c: [component_first[c], component_first[c+1]) */
  PetscInt  basis_first[MPM_MAX_BLOCK];         /* their basis functions start here: 0 weight, 1.. derivatives */
  PetscInt  component_of[MPM_MAX_INPUTS], basis_of[MPM_MAX_INPUTS];
  PetscInt  rate_component[MPM_MAX_BLOCK]; /* the nodal component of each value with a rate */
  PetscInt  means;                         /* 1: the kernel has one input more, the mean over the cell; otherwise 0 */
  PetscBool increment[MPM_MAX_BLOCK];
  const char *component_name[MPM_MAX_BLOCK], *component_symbol[MPM_MAX_BLOCK]; /* symbol: NULL where it has none */
  MpmNearNull near_null[MPM_MAX_BLOCK];                                        /* of the field of each component */
  PetscBool   solid; /* the displacement's gradient is all that the kernel sees */
  const MpmKernelSet *kernel;
} MpmLayout;

/* Components of a symmetric tensor at a point: in plane strain xx, yy, zz, xy. */
static inline PetscInt MpmSymSize(PetscInt dim)
{
  return dim == 2 ? 4 : 6;
}

/* A built-in physics with its compiled kernels. */
PetscErrorCode MpmPhysicsCreate(const char *name, MpmPhysics *physics, PetscBool *found);
/* Appends the names of all physics that scenes may ask for. */
PetscErrorCode MpmPhysicsList(char **words);
PetscErrorCode MpmLayoutCreate(const MpmPhysics *physics, PetscInt dim, MpmLayout *layout);
/* Do any of the kernel's inputs need the weights, not only their derivatives? */
PetscBool MpmLayoutUsesValues(const MpmLayout *layout);
typedef int (*MpmStretch)(const double *F, double *diagonal);
/* The function that gives the diagonal of U = sqrt(F^T F). */
MpmStretch MpmStretchFind(PetscInt dim);

/* ---- registry.c ---- */

/* What has been registered besides what was compiled in; NULL behind the last. */
const MpmLawInstance *MpmLawRegistered(PetscInt k);
const MpmPhysics     *MpmPhysicsRegistered(PetscInt k);
/* Loads the files of -mpm_plugin; they stay loaded, and a second time does nothing. Collective. */
PetscErrorCode MpmPluginsLoad(const MpmOptions *options);

/* ---- stress_inversion.c ---- */

/*
  States of one material with a wanted stress. Where the law's stress follows from its state alone (`stateful`), F
  stays the identity and all six components are met; otherwise F carries the stress, in plane strain without the
  component across the plane.
*/
typedef struct {
  const MpmMaterial *material;
  MpmKernelSet       kernel;
  MpmFunction        law[MPM_FORM_COUNT];
  PetscInt           dim, model_dim; /* of the kernel, and of the model */
  int (*history)(const double *parameter, const MpmLawTable *table, const double *stress, double *state);
  PetscBool stateful;
} MpmInitial;

#define MPM_INITIAL_STATE 64 /* most values of a history in 3D */
PetscErrorCode MpmInitialCreate(const MpmMaterial *material, PetscInt dim, MpmInitial *initial);
/*
  F and state with the Cauchy stress `stress` (xx, yy, zz, xy (, yz, xz); on exit the stress of that state), from the
  history state_n on. Returns 0; 1 where the stress is outside the yield surface and the law's return has moved it; 2
  where there is no such state.
*/
int MpmInitialFind(const MpmInitial *initial, const PetscReal state_n[], PetscReal stress[], PetscReal F[],
                   PetscReal state[]);

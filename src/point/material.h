#pragma once
/*
  The materials of a scene: laws with their parameters' values.
*/
#include "base/base.h"
#include "base/types.h"
#include "talus/talus.h"

#define MPM_NU_LOCKS      0.45 /* Poisson's ratio above which material is nearly incompressible */
#define MPM_DILATION_FREE 2.5  /* dilation angle, degrees, from which splines follow plastic flow without F-bar */

/*
  One material of the scene: a law, its parameters' values, and the law compiled for each form. Of parameters that vary
  `parameter` has the largest value, and a point has a row of its own: the law's, then the physics' (MpmPointOwn() in
  particles/point_mass.h). Functions with an argument `own` take that row, or NULL: the material's values.
*/
typedef struct MpmMaterial {
  char              *name;
  MpmLawInfo         info;
  double            *parameter;         /* in force; strengths may be reduced */
  double            *given;             /* as the scene has them */
  int               *set;               /* given by the scene */
  double            *physics_parameter; /* parameters of the physics, of this material and of the whole scene */
  MpmLawTable       *table;             /* by parameter */
  MpmFunction        law[MPM_FORM_COUNT];
  const MpmBasalLaw *basal;     /* of the bed, in depth-averaged flow; or NULL */
  MpmDilatancy       dilatancy; /* of the law, where F-bar leaves dilation to the points; or NULL */
  PetscReal          density;
  struct {
    PetscReal least, most; /* of the dilation angle and the residual one, degrees; 0 where the law has none */
  } dilation;
  struct {
    PetscReal stiffness, shear; /* at rest, Pa; the latter is 0 where the law has none */
    PetscReal penalty; /* scale of penalties: E where the law has it; a constrained modulus locks as nu goes to 1/2 */
    PetscReal nu;      /* Poisson's ratio, 0 where the law has none */
  } moduli;
  PetscReal      spacing; /* most cells from point to point on an axis at the start; 0: unknown */
  PetscInt       state_size;
  int            kinematics; /* MpmKinematics that the law is compiled for */
  MpmVariations *varies;     /* NULL: uniform */
} MpmMaterial;

/* Materials, with the names of their blocks. */
typedef struct MpmMaterials {
  PetscInt     count;
  char       **names;
  MpmMaterial *at;
  MpmGrounds  *grounds; /* fields of numbers of theirs; NULL: none */
} MpmMaterials;

/* `kinematics`: an MpmKinematics; `grounds`: the scene's fields, or NULL. Column: its law is one of a bed. */
PetscErrorCode MpmMaterialCreateColumn(const MpmOptions *options, const char *name, const MpmGrounds *grounds,
                                       MpmMaterial *material);
PetscErrorCode MpmMaterialCreate(const MpmOptions *options, const char *name, PetscInt kinematics,
                                 const MpmGrounds *grounds, MpmMaterial *material);
/* The parameters of the physics, which stand in the material's block too, and behind them those of the whole scene. */
PetscErrorCode MpmMaterialReadPhysics(const MpmOptions *options, const MpmPhysics *physics, PetscInt dim,
                                      const MpmGrounds *grounds, MpmMaterial *material);
/* How many places a physics' parameter takes among its values. */
PetscInt MpmParameterPlaces(const MpmParameter *parameter);
/* A material as its physics sees it. */
MpmPhysicsMaterial MpmMaterialForPhysics(const MpmMaterial *material, const double own[], PetscInt dim);
/* Values of the physics' parameters. */
static inline const double *MpmMaterialPhysicsValues(const MpmMaterial *material, const double own[])
{
  return own ? own + material->info.parameter_count : material->physics_parameter;
}
/* Numbers in a point's row; and that of a place of the initial state, strengths reduced. */
PetscInt MpmMaterialOwnSize(const MpmMaterial *material);
void     MpmMaterialOwn(const MpmMaterial *material, const MpmPlace *place, double own[]);
/* True where the law's parameter in this place of its table varies. */
PetscBool MpmMaterialVaries(const MpmMaterial *material, PetscInt place);
/* "E, cohesion": names of the parameters that vary. Free with PetscFree(). */
PetscErrorCode MpmMaterialVaryingText(const MpmMaterial *material, char **text);
/* Derives the physics' parameters, once the scene's gravity, m/s2, is known. */
PetscErrorCode MpmMaterialPrepare(const MpmPhysics *physics, PetscInt dim, PetscReal gravity, MpmMaterial *material);
PetscErrorCode MpmMaterialDestroy(MpmMaterial *material);
/* Divides all strengths that the scene gives by a factor > 0, angles by their tangents; the other parameters stay. */
void MpmMaterialReduce(MpmMaterial *material, PetscReal factor);
/* A value for the parameter at a place of the law's table, and for those that have its value as long as the scene gives
   them none; direction[place*stride] and so on. */
void MpmMaterialDirection(const MpmMaterial *material, PetscInt place, PetscReal value, PetscInt stride,
                          double direction[]);
/* True where it has a strength that can be reduced: neither zero nor infinite. */
PetscBool MpmMaterialHasStrength(const MpmMaterial *material);
/* True where the parameters in force are out of range, or contradictory; `why` then names one: "dilation 40: must be
   ...". */
#define MPM_FAULT_TEXT 512
PetscBool MpmMaterialIsFaulty(const MpmMaterial *material, char why[MPM_FAULT_TEXT]);
/* MpmMaterialIsFaulty() with another value of the parameter of this name; false where the law has no such number. */
PetscBool MpmMaterialIsFaultyWith(const MpmMaterial *material, const char *parameter, PetscReal value,
                                  char why[MPM_FAULT_TEXT]);
/* Initial density, kg/m3; of a material where it varies the least. */
PetscReal MpmMaterialDensity(const MpmMaterial *material, const double own[]);
/* Scale of penalties, Pa. */
PetscReal MpmMaterialPenalty(const MpmMaterial *material, const double own[]);
/* Largest shear stress that the material carries at a state, Pa; infinite where the law sets no limit of that kind. */
PetscReal MpmMaterialShearStrength(const MpmMaterial *material, const double own[], const PetscReal state[]);
/* The law's stiffness at a state, Pa, as MpmLawInfo has it; `state` and `F` may be NULL: at rest. */
PetscReal MpmMaterialStiffness(const MpmMaterial *material, const double own[], const PetscReal state[],
                               const PetscReal F[]);
/* The law's shear modulus at a state, Pa; 0 where it has none. */
PetscReal MpmMaterialShearModulus(const MpmMaterial *material, const double own[], const PetscReal state[],
                                  const PetscReal F[]);
/* Both for loops over points: no call where all states and points have the same. */
static inline PetscReal MpmMaterialStiffnessAt(const MpmMaterial *material, const double own[], const PetscReal state[],
                                               const PetscReal F[])
{
  if (!own && material->info.traits & MPM_LAW_FIXED_MODULI) return material->moduli.stiffness;
  return MpmMaterialStiffness(material, own, state, F);
}
static inline PetscReal MpmMaterialShearModulusAt(const MpmMaterial *material, const double own[],
                                                  const PetscReal state[], const PetscReal F[])
{
  if (!own && material->info.traits & MPM_LAW_FIXED_MODULI) return material->moduli.shear;
  return MpmMaterialShearModulus(material, own, state, F);
}
/*
  A bound on the speed of elastic waves at a state, m/s, by present lengths; `stress` is the Cauchy stress, in the
  components of `dim`. Infinite without density. `state`, `F` and `stress` may be NULL: at rest.
*/
PetscReal MpmMaterialWaveSpeed(const MpmMaterial *material, const double own[], PetscInt dim, const PetscReal state[],
                               const PetscReal F[], const PetscReal stress[]);
/* The law's longitudinal viscosity, Pa s, as MpmLawInfo has it; 0 where it has none. */
PetscReal MpmMaterialViscosity(const MpmMaterial *material, const double own[]);
/*
  The law's answer and its derivative in a direction of anything that it depends on; `input` without tables, which are
  the material's, and with a point's own parameters, or NULL: the material's. Non-zero where the law has no answer.
*/
int MpmMaterialSensitivity(const MpmMaterial *material, const MpmLawInput *input, const MpmLawInput *direction,
                           const MpmLawOutput *value, const MpmLawOutput *derivative);
/* Components of one history variable. */
PetscInt MpmStateComponents(const MpmStateVariable *variable, PetscInt dim);
/* Initial values of history variables, all of them side by side; those of a material after the table of its law. */
void MpmStatesAtRest(size_t count, const MpmStateVariable variables[], PetscInt dim, PetscReal state[]);
void MpmMaterialStateAtRest(const MpmMaterial *material, PetscInt dim, PetscReal state[]);

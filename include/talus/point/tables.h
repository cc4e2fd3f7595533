#pragma once
/*
  The tables through which a constitutive law or a physics presents itself to the engine. Plain C, no PETSc.
*/
#include <stddef.h>

/* A function pointer of any type; cast back to its own type before it is called. */
typedef void (*MpmFunction)(void);

/* One parameter of a law: an option -mpm_material_<name>_<parameter>. A parameter without a default is required. */
typedef struct {
  const char *name;
  const char *unit;
  double      fallback; /* default value, used when `required` is 0 */
  int         required;
  double      lower, upper; /* accepted range */
  int         open;         /* 1: bounds themselves are not accepted */
  const char *help;
  const char *choices; /* NULL, or names separated by '|': the option is a word and the value its index */
} MpmParameter;

typedef enum { MPM_STATE_SCALAR, MPM_STATE_SYM } MpmStateKind;

/*
  One history variable of a law. A symmetric tensor takes 4 components in plane strain and 6 in 3D, and starts as
  initial * identity.
*/
typedef struct {
  const char  *name; /* as it appears in the results */
  MpmStateKind kind;
  double       initial;
  const char  *unit;
} MpmStateVariable;

/*
  MPM_LAW_SYMMETRIC     the law derives from a potential, so its Jacobian is symmetric
  MPM_LAW_SMALL_STRAIN  the stress is linear in the displacement gradient and is not objective: the physics then leaves
                        the geometry of the step alone, and a step takes one Newton iteration
  MPM_LAW_INTERNAL      the engine's own, not offered to scenes
  MPM_LAW_PLASTIC       the law flows: its volume then follows from its shear, and low-order shapes lock without F-bar
*/
typedef enum { MPM_LAW_SYMMETRIC = 1, MPM_LAW_SMALL_STRAIN = 2, MPM_LAW_INTERNAL = 4, MPM_LAW_PLASTIC = 8 } MpmLawTrait;

/* A constitutive law as the registry sees it; `law` holds one entry per compiled instance. */
typedef struct {
  const char             *name;
  const char             *summary; /* one line for -help */
  const MpmParameter     *parameters;
  size_t                  parameter_count;
  const MpmStateVariable *states;
  size_t                  state_count;
  unsigned                traits;                          /* MpmLawTrait values, or-ed */
  int (*check)(const double *parameter, const char **why); /* NULL, or 0 where parameters contradict each other */
  double (*stiffness)(const double *parameter); /* constrained modulus at rest, Pa: scales penalties and tolerances */
  MpmFunction law;
} MpmLawInfo;

/* A law as compiled for one dimension and number of derivative directions: its constructor, which MPM_LAW() makes. */
typedef struct {
  const char *name;
  int         dim, directions;
  void (*create)(MpmLawInfo *info);
} MpmLawInstance;

/* The forms in which a kernel is compiled; a law pointer table is indexed by them. */
typedef enum { MPM_FORM_RESIDUAL, MPM_FORM_DIRECTION, MPM_FORM_TANGENT, MPM_FORM_COUNT } MpmForm;

/*
  What a physics kernel is told about one point. The last three are where the step's end goes, should it turn out to be
  it; NULL when nobody asks: in Jacobians, and in residuals with one in the same pass.
*/
typedef struct {
  const double      *parameter;         /* of the point's material */
  const double      *physics_parameter; /* of the physics */
  const double      *state_n;           /* history at the step's start */
  const double      *F_n;               /* deformation gradient at the step's start, row-major, dim x dim */
  const double      *value_n;           /* values at the step's start of the fields with a rate, in field order */
  const double      *stress_n;          /* Cauchy stress there, where nothing moves and the law is not asked; or NULL */
  double             volume0;           /* initial volume, m3 (2D: m2 per metre of thickness) */
  double             dt;                /* s */
  unsigned           traits;            /* of the law, MpmLawTrait */
  const MpmFunction *law;               /* the material's law, by MpmForm */
  double            *state;             /* history at the step's end */
  double            *F;
  double            *stress; /* Cauchy, Pa */
} MpmKernelPoint;

/*
  A physics' compiled kernel in one dimension, plain doubles in and out, one function a form; each returns non-zero for
  a domain error.

  residual    flux[inputs]
  direction   flux and dflux = (d flux / d input) dinput
  tangent     flux and tangent[k*inputs + l] = d flux_k / d input_l; with a mean d flux_k / d input_l of the others, then d
              flux_k / d mean, then d flux_mean / d input_k, then d flux_mean / d mean
  mean        NULL, or m, of whose mean over the points of the cell the last input is the value, and its derivatives by
              the other inputs. Where the residual derives from an energy, so must the flux of the mean, and the engine
              adds what the points' own m do to it to the other fluxes.
  mean_tangent  the same, and the second derivatives too: ddm[k*(inputs - 1) + l], which `mean` leaves alone
*/
typedef struct {
  int inputs;
  int (*residual)(const MpmKernelPoint *point, const double *input, double *flux);
  int (*direction)(const MpmKernelPoint *point, const double *input, const double *dinput, double *flux, double *dflux);
  int (*tangent)(const MpmKernelPoint *point, const double *input, double *flux, double *tangent);
  int (*mean)(const MpmKernelPoint *point, const double *input, double *m, double *dm, double *ddm);
  int (*mean_tangent)(const MpmKernelPoint *point, const double *input, double *m, double *dm, double *ddm);
} MpmKernelSet;

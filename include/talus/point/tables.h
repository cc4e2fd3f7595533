#pragma once
/*
  The tables through which a constitutive law or a physics presents itself to the engine. Plain C, no PETSc.
*/
#include <stddef.h>
#include "dense.h"

/* A function pointer of any type; cast back to its own type before it is called. */
typedef void (*MpmFunction)(void);

/*
  Kind of a law's parameter.

  MPM_NUMBER          a number, in the parameter's unit and range
  MPM_STRENGTH        a number that bounds the stress, the slope of such a bound, or how it grows or falls: a stage that
                      reduces strength divides it by its factor
  MPM_STRENGTH_ANGLE  an angle, degrees: such a stage divides its tangent
  MPM_WORD            one of `choices`; the law sees its index
  MPM_TABLE           rows x, y with growing x: text "x:y,x:y" in the scene, or the name of a file with two columns; the
                      range is that of y
  MPM_DATA            numbers, each in the range, in a file
  MPM_AXES            of a physics alone: one number, or one an axis; takes three places among its values
*/
typedef enum { MPM_NUMBER, MPM_STRENGTH, MPM_STRENGTH_ANGLE, MPM_WORD, MPM_TABLE, MPM_DATA, MPM_AXES } MpmParameterKind;

/*
  One parameter of a law: an option -mpm_material_<name>_<parameter>. A parameter without a default is required; without
  either, a table or data has no rows. The default may be the value of another parameter, `same_as`, that stands before
  it in the table.
*/
typedef struct {
  MpmParameterKind kind;
  const char      *name;
  const char      *unit;     /* a table has two, "x:y" */
  double           fallback; /* default value of a number or word, used when `required` is 0 */
  int              required;
  double           lower, upper; /* accepted range */
  int              open;         /* 1: bounds themselves are not accepted */
  const char      *help;
  const char      *choices; /* of a word: names separated by '|'; otherwise NULL */
  double           typical; /* a common value, about which tests draw; 0: they go by range and unit */
  const char      *same_as; /* name of the parameter whose value is the default, instead of `fallback`; or NULL */
} MpmParameter;

/*
  Contents of a table or data parameter: `count` rows of x and y one after the other, or `count` numbers. A law has one
  a parameter, in the order of its parameter table, empty where the parameter is a number or a word.
*/
typedef struct {
  long          count;
  const double *value;
} MpmLawTable;

typedef enum { MPM_STATE_SCALAR, MPM_STATE_SYM, MPM_STATE_VECTOR } MpmStateKind;

/*
  One history variable of a law. A symmetric tensor takes 4 components in plane strain and 6 in 3D, and starts as
  initial * identity; a vector, which only a physics may have, takes as many as there are dimensions.
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
  MPM_LAW_LAGGED        strength is that of the step's start: a point may go on flowing though nothing moves
  MPM_LAW_VISCOUS       stress depends on how fast the step deforms; the viscous part is gone once nothing moves
  MPM_LAW_FIXED_MODULI  stiffness and shear modulus are those at rest at every state: one evaluation suffices
  MPM_LAW_VOLUME        of F_n the law uses the determinant only, its shape is in the history: a point that has flowed
                        far may get another F of equal determinant
*/
typedef enum {
  MPM_LAW_SYMMETRIC    = 1,
  MPM_LAW_SMALL_STRAIN = 2,
  MPM_LAW_INTERNAL     = 4,
  MPM_LAW_PLASTIC      = 8,
  MPM_LAW_LAGGED       = 16,
  MPM_LAW_VISCOUS      = 32,
  MPM_LAW_FIXED_MODULI = 64,
  MPM_LAW_VOLUME       = 128
} MpmLawTrait;

/*
  Contradiction of parameters: the one that is refused, by its place in the parameter table, with the range that
  the others leave it. A negative place: no particular one.
*/
typedef struct {
  int         parameter;
  double      lower, upper; /* in the parameter's unit; infinite: no limit */
  int         open;         /* 1: bounds themselves are not accepted */
  const char *why;          /* "dilation must not exceed friction" */
} MpmLawFault;

/*
  Dilation of a law when it is sheared in plane strain from a state: the volume strain over the shear strain of plastic
  flow, in logarithmic strains, shear being the difference of the two principal values in the plane. 0 where the state
  lies well inside the yield surface, and continuous in the state up to it. `elastic` becomes the elastic left
  Cauchy-Green tensor in the plane, xx, yy, xy.
*/
typedef double (*MpmDilatancy)(const double *parameter, const MpmLawTable *table, const double *state,
                               double elastic[3]);

/* MpmDilatancy, behind it `elastic`, and their derivatives in directions of parameters and state_n, in rows. */
struct MpmLawInput;
typedef void (*MpmDilatancySensitivity)(const struct MpmLawInput *input, const struct MpmLawInput *direction,
                                        double value[4], double *derivative);

/*
  The shear modulus at a state and F, then shear modulus and stiffness at rest, Pa, with their derivatives in directions
  of parameters, state_n and F_n, in rows.
*/
typedef void (*MpmModuliSensitivity)(const struct MpmLawInput *input, const struct MpmLawInput *direction,
                                     double value[3], double *derivative);

/*
  A constitutive law as the registry sees it; `law` is of one compiled form. Functions may be NULL, but for `stiffness`.

  check      0 where parameters contradict each other, with the contradiction in `fault`
  stiffness  constrained modulus at a state, Pa: the largest slope of the Kirchhoff stress over a uniaxial strain from
             there, elastic unloading included, or a bound on it; scale of penalties, tolerances and time steps. `state`
             NULL: as the state table has it; `F` NULL: not deformed; either alone is possible. Plus the largest
             principal compression of the Kirchhoff stress it bounds J times the acoustic tensor's principal values, and
             over the density of the initial volume the square of the wave speed, by present lengths at that state
  viscosity  longitudinal viscosity, Pa s: (4/3) mu of a fluid; NULL: none. An explicit step of a viscous stress alone
             is stable up to density times length^2/(2 viscosity)
  shear_modulus  elastic shear modulus at a state, Pa, > 0: the slope of a Kirchhoff shear stress over its shear strain
             in unloading from there, the mean over all planes where they differ; `state` and `F` as for `stiffness`,
             which bounds it. Scale of the stabilization of a pressure field; NULL: a physics with one refuses the law
  symmetric  whether the law derives from a potential with these parameters, such as dilation = friction: it then has
             MPM_LAW_SYMMETRIC in that material. NULL: as `traits` has it
  history    history with a given stress, where the law knows it better than a Newton iteration from rest. `state` is on
             entry the state before, with values from the scene, such as a preconsolidation; on exit it is changed as
             far as the stress requires, so that dF = I, F_n = I gives the Kirchhoff stress, Pa, in the components of
             this instance's dimension. A stress outside the yield surface is the elastic one: the law's return moves
             it. Non-zero where there is no such state
  k0         ratio of horizontal to vertical stress in ground at rest where the vertical stress is `weight`, Pa,
             positive in compression, by the law's friction and its earlier loads: (1 - sin phi) OCR^sin phi (Jaky;
             Mayne and Kulhawy 1982). `state` has the values from the scene
  dilatancy  the law's MpmDilatancy, with which F-bar leaves to each point the dilation of its own shear
  dilatancy_sensitivity  its derivatives; NULL: runs in which it acts have none
  moduli_sensitivity  the law's MpmModuliSensitivity; NULL: runs of a physics with a deviation have no derivatives
  shear_strength  largest shear stress, Pa, that the material carries at a state, where no pressure changes it: bound of
             the traction of a surface that sticks to the material
  energy     elastic energy stored per initial volume, J/m3, at a Kirchhoff stress, Pa, and a deformation gradient, of
             laws whose stress is a derivative of it in elastic steps. NULL: that of linear elasticity with the bulk and
             shear modulus at the state, which is Hencky's and Hooke's
  volumetric  of a law with `energy` the part of it that depends on J alone, J/m3, the Kirchhoff pressure that it gives,
             tension positive, Pa, and the slope of that by J. NULL: the law does not divide its energy so
*/
typedef struct {
  const char             *name;
  const char             *summary; /* one line for -help */
  const MpmParameter     *parameters;
  size_t                  parameter_count;
  const MpmStateVariable *states;
  size_t                  state_count;
  unsigned                traits; /* MpmLawTrait values, or-ed */
  int (*check)(const double *parameter, const MpmLawTable *table, MpmLawFault *fault);
  double (*stiffness)(const double *parameter, const MpmLawTable *table, const double *state, const double *F);
  double (*shear_modulus)(const double *parameter, const MpmLawTable *table, const double *state, const double *F);
  double (*viscosity)(const double *parameter, const MpmLawTable *table);
  int (*symmetric)(const double *parameter, const MpmLawTable *table);
  int (*history)(const double *parameter, const MpmLawTable *table, const double *stress, double *state);
  double (*k0)(const double *parameter, const MpmLawTable *table, const double *state, double weight);
  double (*shear_strength)(const double *parameter, const double *state);
  struct { /* stored */
    double (*energy)(const double *parameter, const MpmLawTable *table, const double *tau, const double *F);
    void (*volumetric)(const double *parameter, const MpmLawTable *table, double J, double value[3]);
  };
  MpmDilatancy            dilatancy;
  MpmDilatancySensitivity dilatancy_sensitivity;
  MpmModuliSensitivity    moduli_sensitivity;
  MpmFunction             law;
} MpmLawInfo;

/*
  The forms in which a law is compiled; a law pointer table is indexed by them. Physics have all but the last, in which
  a law's function is an MpmSensitivity; in the others it takes Scalars, and physics call it.
*/
typedef enum { MPM_FORM_RESIDUAL, MPM_FORM_DIRECTION, MPM_FORM_TANGENT, MPM_FORM_SENSITIVITY, MPM_FORM_COUNT } MpmForm;

/* Directions that are differentiated by at once */
#define MPM_PACK 8

/*
  All that a law's answer depends on, or directions in which it changes. There NULL stands for what does not change; of
  a table's values all may change, x and y.

  Up to MPM_PACK directions: of each number the arrays have `stride` derivatives, of which `count` are read. Zeros
  stand for one direction.
*/
typedef struct MpmLawInput {
  const double      *parameter; /* in the order of the law's parameter table; words do not change */
  const MpmLawTable *table;
  const double      *state_n; /* history at the step's start */
  const double      *F_n;     /* deformation gradient there, MpmKinematicsF() components */
  const double      *dF;      /* F_{n+1} F_n^{-1}, likewise */
  double             dt;      /* s; among directions it changes in the first */
  int                count, stride;
} MpmLawInput;

/* Result of a law, or the derivatives of it, in rows as those of the directions. `state` may be NULL: not needed. */
typedef struct {
  double *tau;   /* Kirchhoff stress, Pa: xx, yy, zz, xy (, yz, xz) */
  double *state; /* history at the step's end */
} MpmLawOutput;

/*
  A law's answer and its derivatives in directions. `derivative->state` is wanted with `value->state` or not at all.
  Non-zero where the law has no answer.
*/
typedef int (*MpmSensitivity)(const MpmLawInput *input, const MpmLawInput *direction, const MpmLawOutput *value,
                              const MpmLawOutput *derivative);

/*
  How points deform: what a gradient, F and a symmetric tensor consist of, and what a point's volume is. With axial
  symmetry x is the radius, y the axis, zz the hoop direction; volumes, masses and forces are those of a full turn.
*/
typedef enum { MPM_PLANE_STRAIN = 2, MPM_SPATIAL = 3, MPM_AXISYMMETRY = 4, MPM_KINEMATICS_COUNT } MpmKinematics;

/* Axes of the grid */
MPM_FN int MpmKinematicsDim(int kinematics)
{
  return kinematics == MPM_SPATIAL ? 3 : 2;
}
MPM_FN const char *MpmKinematicsName(int kinematics)
{
  return kinematics == MPM_SPATIAL ? "3D" : kinematics == MPM_AXISYMMETRY ? "axial symmetry" : "plane strain";
}
/* Components of F: 4, 9 or 5, as dense.h has them */
MPM_FN int MpmKinematicsF(int kinematics)
{
  return kinematics == MPM_AXISYMMETRY ? 5 : kinematics * kinematics;
}

/* A law as compiled for one kinematics and form: its constructor, which MPM_LAW() makes. */
typedef struct {
  const char *name;
  int         kinematics;
  MpmForm     form;
  void (*create)(MpmLawInfo *info);
} MpmLawInstance;

/*
  The first stage of a step of two (scheme `second`), to which the kernel's stored quantities refer: where a step of one
  stage takes s - s_n, the second stage takes s - s_n - theta (s_1 - s_n).
*/
typedef struct {
  const double *F;         /* deformation gradient that the first stage found */
  const double *value;     /* as value_n, */
  const double *deviation; /* and deviation_n */
  double        theta;
  double        span; /* s, from the step's start to its end, what laws take for the step's length */
} MpmKernelStage;

/* The material of a point, as a physics kernel takes it. */
typedef struct {
  const MpmLawInfo  *info;
  const double      *parameter; /* of the law, in force at the point */
  const MpmLawTable *table;
  const MpmFunction *law;       /* by MpmForm */
  unsigned           traits;    /* of the law, MpmLawTrait */
  MpmDilatancy       dilatancy; /* where the mean over the cell is to leave dilation to the points; or NULL */
} MpmKernelMaterial;

/* Trait of a point's material: the tangent that the fields of MPM_PHYSICS_ALTERNATE are solved by in turn. */
#define MPM_POINT_ALTERNATE (1u << 30)

/* Destinations of a point's state at the step's end. */
typedef struct {
  double *state; /* history */
  double *own;   /* states of the physics' own */
  double *F;
  double *stress; /* Cauchy, Pa */
} MpmKernelEnd;

/* Data of one point for a physics kernel. `end` has NULL in Jacobians, and in residuals with one in the same pass. */
typedef struct {
  MpmKernelMaterial material;
  const double     *physics_parameter; /* of the physics, for that material: in the order of its parameter table */
  const double     *state_n;           /* history at the step's start */
  const double     *F_n;               /* deformation gradient at the step's start, MpmKinematicsF() components */
  const double     *value_n;           /* values at the step's start of the fields with a rate, in field order */
  const double *deviation_n;   /* the deviations there, field by field, of what the points' values make at the nodes */
  const double *own_n;         /* states of the physics' own there, or NULL */
  const double *stress_n;      /* Cauchy stress there, in a stage without motion, where the law is not asked; or NULL */
  const double *gravity;       /* at the step's end, m/s2, `dim` components */
  const double *cell;          /* the grid's cell, m, `dim` components; or NULL */
  const MpmKernelStage *stage; /* the first one, in the second of two; or NULL */
  double                volume0; /* initial volume, m3 (2D: m2 per metre of thickness) */
  double                dt;      /* s */
  MpmKernelEnd          end;
} MpmKernelPoint;

/*
  Directions in which all that a kernel depends on at a point changes; NULL: that does not. Numbers of tables and of
  time do not change.

  Up to MPM_PACK directions: of each number the arrays, and those of derivatives, have a row of `count`; 0: one.
*/
typedef struct {
  const double  *input;     /* of the kernel */
  const double  *parameter; /* of the law, in the order of its table */
  const double  *state_n, *F_n;
  const double  *physics_parameter, *value_n, *deviation_n, *own_n, *gravity; /* as those of MpmKernelPoint */
  MpmKernelStage stage;                                                       /* of its arrays */
  int            count;
} MpmKernelDirection;

/*
  A physics' compiled kernel of one kinematics, plain doubles in and out, one function a form; each returns non-zero for
  a domain error.

  residual    flux[inputs]
  direction   flux and dflux = (d flux / d input) dinput
  tangent     flux and tangent[k*inputs + l] = d flux_k / d input_l; with a mean d flux_k / d input_l of the others,
              then d flux_k / d mean, then d flux_mean / d input_k, then d flux_mean / d mean
  mean        NULL, or m, of whose mean over the points of the cell the last input is the value, and its derivatives by
              the other inputs. Where the residual derives from an energy, so must the flux of the mean, and the engine
              adds the contribution of the points' own m to the other fluxes.
  mean_tangent  as `mean`, and the second derivatives too: ddm[k*(inputs - 1) + l]
  sensitivity   flux and point->end, and their derivatives in directions, dflux and `derivative`, in rows of
                direction->count; NULL: the physics has no derivatives beyond those by its inputs
  mean_sensitivity  m[0] and dm, and their derivatives in directions, from m[1] on and ddm; with `sensitivity`
*/
typedef struct {
  int inputs;
  int (*residual)(const MpmKernelPoint *point, const double *input, double *flux);
  int (*direction)(const MpmKernelPoint *point, const double *input, const double *dinput, double *flux, double *dflux);
  int (*tangent)(const MpmKernelPoint *point, const double *input, double *flux, double *tangent);
  int (*mean)(const MpmKernelPoint *point, const double *input, double *m, double *dm, double *ddm);
  int (*mean_tangent)(const MpmKernelPoint *point, const double *input, double *m, double *dm, double *ddm);
  int (*sensitivity)(const MpmKernelPoint *point, const double *input, const MpmKernelDirection *direction,
                     double *flux, double *dflux, const MpmKernelEnd *derivative);
  int (*mean_sensitivity)(const MpmKernelPoint *point, const double *input, const MpmKernelDirection *direction,
                          double *m, double *dm, double *ddm);
} MpmKernelSet;

/*
  Unit of a field's values: the size of a cell, a stiffness of the material, or one. Equations of prescribed
  unknowns are scaled so that they stand beside the others: K h^dim / scale^2.
*/
typedef enum { MPM_SCALE_LENGTH, MPM_SCALE_STRESS, MPM_SCALE_ONE } MpmScale;

/* A field's modes of little energy, for multigrid. */
typedef enum { MPM_NEAR_NULL_NONE, MPM_NEAR_NULL_RIGID, MPM_NEAR_NULL_CONSTANT } MpmNearNull;

/* At most so many unknowns a node has (displacement, pressure, damage, ...), inputs a kernel, and shapes a physics. */
#define MPM_MAX_BLOCK  8
#define MPM_MAX_INPUTS 24
#define MPM_MAX_SHAPES 3

/*
  One field of a physics: its unknowns at the nodes and the kernel's inputs from it at a point.

  An increment field (the displacement) restarts at zero each step. Any other field is solved for as a total. With
  `rate` the engine keeps the field's value and gradient at the points, passes the value to the kernel as value_n, and
  starts the step from their projection to the nodes.

  The deviation is the value less its mean over the cell: interpolated with the weights less their means over the cell,
  where a point's domain lies in several cells less the domain's share in each times that cell's mean. A deviation needs
  `rate`.

  Fields have the scene's shape unless they specify B-splines of another degree, or a coarser lattice of nodes; the
  displacement always has the scene's. Where the scene's shape averages over the points' domains, so do degrees 1 and 2.
*/
typedef struct {
  const char *name;
  int         components; /* 0: as many as the space has dimensions */
  int         degree;     /* of its shape, 1 to 3; 0: the scene's */
  int         spacing;    /* its nodes stand so many cells apart; 0: one */
  int         value;      /* the value is an input of the kernel */
  int         gradient;   /* the gradient is */
  int         deviation;  /* the value less its mean over the cell is */
  int         increment;
  int         rate;
  int         negative; /* its equations are taken times -1; reactions are reported without this factor */
  const char *symbol;   /* in lists of components, for a field of one; NULL: by its name alone */
  const char *unit;     /* of the value; NULL: none is told */
  MpmNearNull near_null;
  MpmScale    scale;
} MpmField;

/*
  MPM_PHYSICS_SYMMETRIC  with laws that derive from a potential, the Jacobian is symmetric
  MPM_PHYSICS_INTERNAL   takes another physics' place where needed, and is not offered to scenes
  MPM_PHYSICS_SADDLE     the Jacobian is that of a saddle point, with as many negative eigenvalues as another field than
                         the displacement has unknowns: not for solvers that need a definite one
  MPM_PHYSICS_STAGES     storage and flow of a step stand in its equations as amounts, the second times dt, and the
                         kernel takes `stage`: the scheme `second` is possible. With dt = 0 nothing flows
  MPM_PHYSICS_BIOT       two fields of the scene's shape, the displacement by its gradient and one unknown p by value,
                         gradient and deviation. The flux of the displacement's gradient depends on neither grad p nor
                         the deviation, that of p on neither, that of grad p not on p nor the deviation, that of the
                         deviation on itself alone: other entries of the tangent are ignored
  MPM_PHYSICS_STRESS     one field, the displacement, whose flux is that of the stress which the points keep: an
                         explicit step takes forces from that stress and does not call the kernel for them
  MPM_PHYSICS_ALTERNATE  two fields, in each of which the energy is convex while the other stays, but not in both:
                         Newton's method falls back on minimising by one after the other. With MPM_POINT_ALTERNATE among
                         a point's traits the tangent leaves out what the displacement does to the other field's fluxes
*/
typedef enum {
  MPM_PHYSICS_SYMMETRIC = 1,
  MPM_PHYSICS_INTERNAL  = 2,
  MPM_PHYSICS_STAGES    = 16,
  MPM_PHYSICS_SADDLE    = 32,
  MPM_PHYSICS_BIOT      = 64,
  MPM_PHYSICS_STRESS    = 128,
  MPM_PHYSICS_ALTERNATE = 512
} MpmPhysicsTrait;

/* A number of the scene, -mpm_<block>_<name>, that a physics' kernel needs at every point. */
typedef struct {
  const char  *block;
  MpmParameter parameter;
} MpmCommonParameter;

/* A material as a physics sees it. */
typedef struct {
  const MpmLawInfo  *info;
  const double      *parameter; /* the law's, */
  const int         *set;       /* and whether the scene gives them */
  const MpmLawTable *table;
  int                dim;
} MpmPhysicsMaterial;

/*
  A physics: its fields, in the order of their unknowns at a node, and its kernel. Inputs of the kernel, in this order:
  for every field, for every component, its value (if used), then its derivatives along the axes (if used), then its
  deviation (if used). With axial symmetry the hoop strain u_x/x stands behind those of the displacement. Functions may
  be NULL.

  prepare  derives further values from those that a material's block has, once they are read, with the scene's gravity,
           or that of the Earth, m/s2; returns NULL, or a fault of one of them: "porosity is missing: must be > 0 and <
           1"
  change   derivatives of all values, as `prepare` has left them, by the number that a place of the table had before;
           they are 0 on entry. NULL: 1 at that place
  initial  the physics' states of a point at the start, beside the table of states
  initial_change  derivatives of these states by the number at a place; NULL: they are 0
  ghost  factor of the ghost penalty on the one component beside the displacement, in the sign of its equation, where
         Young's modulus stands for the displacement: of a material, for a step dt in cells of h
  symmetric  whether MPM_PHYSICS_SYMMETRIC holds with these values of a material

  The first field is the displacement increment, a component a dimension, which moves the points; or no field is one.
*/
typedef struct {
  const char         *name;
  const char         *summary;
  int                 field_count;
  const MpmField     *fields;
  MpmKernelSet        kernels[MPM_KINEMATICS_COUNT]; /* by MpmKinematics */
  int                 parameter_count;
  const MpmParameter *parameters; /* numbers and words, options of every material: -mpm_material_<name>_<parameter> */
  int                 common_count;
  const MpmCommonParameter *common; /* numbers of the whole scene, behind those of the material */
  int                       state_count;
  const MpmStateVariable   *states; /* of each point, beside the law's */
  unsigned                  traits; /* MpmPhysicsTrait values, or-ed */
  const char               *fbar;   /* the physics that takes its place with F-bar; NULL: none */
  int taken_up; /* 1 + place, in `common`, of the density of what a point takes up with its volume; 0: nothing */
  struct {
    const char *(*prepare)(const MpmPhysicsMaterial *material, double gravity, double *value);
    void (*change)(const double *value, int place, double *derivative);
    void (*initial)(const MpmPhysicsMaterial *material, const double *value, const double *state, double *own);
    void (*initial_change)(int place, double *own);
  };
  int (*symmetric)(const MpmPhysicsMaterial *material, const double *value);
  double (*ghost)(const MpmPhysicsMaterial *material, const double *value, double dt, double h);
} MpmPhysics;

#pragma once
/*
  A scene as read.
*/
#include "base/base.h"
#include "base/types.h"
#include "transfer/transfer.h"
#include "talus/talus.h"

/* The value of -mpm_physics for a scene of one material point. */
#define MPM_STRESS_POINT "stress_point"

typedef enum {
  MPM_QUASISTATIC,
  MPM_BACKWARD_EULER,
  MPM_NEWMARK,
  MPM_GENERALIZED_ALPHA,
  MPM_EXPLICIT
} MpmIntegratorType;

/* When explicit steps update the stress (explicit.c). */
typedef enum { MPM_UPDATE_MUSL, MPM_UPDATE_USL, MPM_UPDATE_USF } MpmStressUpdate;

/* Damping of the material (damping.c). */
typedef struct {
  PetscReal mass, stiffness;   /* Rayleigh's, 1/s and s */
  PetscReal linear, quadratic; /* coefficients of the bulk viscosity */
} MpmDampingControl;

/* How inertia takes part (dynamics.c, explicit.c). */
typedef struct {
  MpmIntegratorType type;
  PetscReal         rho_inf;     /* of the generalised-alpha method: spectral radius at infinite frequency */
  PetscReal         beta, gamma; /* Newmark's */
  PetscBool         lumped;      /* mass, in implicit steps */
  MpmDampingControl damping;
  MpmTransfer       transfer;
  PetscReal         cfl; /* of explicit steps: in parts of the time that a wave takes through a cell */
  MpmStressUpdate   update;
  PetscReal         rest; /* an explicit stage ends below this share of its largest kinetic energy; 0: it does not */
} MpmMotionControl;

/* How time is cut into steps. */
typedef struct {
  PetscReal        end, step, step_min, step_max, growth; /* step 0: explicit steps as long as they may be */
  PetscBool        adaptive;
  PetscReal        limit;  /* the step_max that is given; 0: none */
  PetscBool        second; /* steps of two stages (sdirk.c) */
  PetscReal        error;  /* largest error in time of a step, relative; 0: it is not looked at */
  MpmMotionControl motion;
  PetscBool        rescue; /* a relaxation goes on where a quasi-static step gives up (rescue.c) */
} MpmTimeControl;

typedef enum { MPM_GEOSTATIC_NONE, MPM_GEOSTATIC_GRAVITY, MPM_GEOSTATIC_K0 } MpmGeostaticMethod;

#define MPM_K0_OCR (-1.)

/* The search for a geostatic state: stress in equilibrium without displacement. */
typedef struct {
  MpmGeostaticMethod method;
  PetscReal         *k0;        /* by the model's bodies; MPM_K0_OCR: the law says it */
  PetscReal          tolerance; /* largest displacement that remains, in heights of the material */
  PetscInt           iterations;
} MpmGeostatic;

/* Explicit steps that come to rest (relaxation.c). */
typedef enum { MPM_DAMPING_KINETIC, MPM_DAMPING_VISCOUS, MPM_DAMPING_LOCAL } MpmRelaxationDamping;
typedef struct {
  PetscBool            on;
  MpmRelaxationDamping damping;
  PetscReal            tolerance, hold; /* the criteria hold below it, for so long, s; -1: by the damping */
  PetscReal            xi, factor;      /* xi in 1/s, of viscous damping; factor: of local */
  PetscBool            scaled;          /* nodes have the masses required by a long step (relaxation.c) */
  PetscBool            felt;            /* K_F is that of the forces on the points (relaxation.c) */
  MpmMotionControl     motion;          /* of a rescue */
  PetscInt             steps;           /* of a rescue: largest number of steps */
} MpmRelaxation;

/* Strengths are divided by the ramp's factor, over the stage's time; no ramp: they are not (strength_reduction.c). */
typedef struct {
  MpmRamp ramp;
  PetscReal
    limit; /* displacement of a point, in heights of the slope, that defines the factor of safety; 0: by elasticity */
  PetscReal tolerance; /* of the bracket of that factor, relative */
  PetscBool slide;     /* the stage goes on once the factor is found */
} MpmReduction;

/*
  One stage of a scene: active conditions and loads, control of time, and changes of the bodies at its start. A scene
  without stages is one stage without a name.
*/
typedef struct MpmStage {
  char          *name;
  MpmTimeControl time;
  PetscBool     *bcs, *motions, *loads, *surfaces; /* by the model's lists: true where active */
  PetscBool     *removed, *adds;                   /* by the model's bodies */
  MpmRamp        removal;       /* removed fraction of bodies, over the stage's time; NULL: at once */
  PetscInt      *material;      /* by the model's bodies: of its points from here on, or -1 */
  MpmRamp        change;        /* of these, over the stage's time; NULL: at once */
  PetscBool      reset;         /* displacements start at zero again */
  PetscBool      drained;       /* the water's pressure is that of a steady flow */
  PetscReal      consolidation; /* degree at which the stage ends; 0: none */
  MpmGeostatic   geostatic;
  MpmReduction   reduction;
  MpmRelaxation  relaxation;
} MpmStage;

typedef enum { MPM_FOLLOW_NOTHING, MPM_FOLLOW_MOTION, MPM_FOLLOW_BOUNDARY, MPM_FOLLOW_BODY } MpmFollowed;

/* Object that the grid follows, and mode (moving_grid.c). */
typedef struct {
  MpmFollowed what;
  PetscInt    index;             /* into the scene's list of its kind */
  PetscBool   axis[MPM_MAX_DIM]; /* the grid moves along it */
  PetscBool   stretch; /* one side stays, and the cells change their size; otherwise the grid moves as a whole */
  PetscInt    fixed[MPM_MAX_DIM]; /* the side that stays: -1 lower, 1 upper, 0: the further one at the start */
  PetscBool   has_at;
  PetscReal   at
    [MPM_MAX_DIM]; /* plane that moves with the followed object, in the grid as it was read; default: the other side */
} MpmFollow;

/* Choices against cuts, locking and points drawn apart (stabilization.c). */
typedef struct {
  PetscReal filled; /* share of the fullest piece beside it that makes a piece well filled; 0: no node follows others */
  PetscBool ghost_auto; /* a ghost penalty where points are sparse */
  PetscReal interior;   /* factor of the ghost penalty on all faces, but in geostatic stages; 0: none */
  PetscReal smooth;     /* share of means over pieces in the strain of a solid */
  PetscReal divide;     /* cells over which a point's domain is drawn before it is divided; 0: it never is */
  PetscBool divide_auto;
  PetscBool fbar, fbar_auto;
  PetscBool fbar_plain;  /* F-bar averages dilation by shear, too */
  PetscBool fbar_spread; /* its means are by shares of the points' domains */
  MpmPhysics  plain;     /* physics that F-bar has replaced, where surfaces need it */
  const char *fbar_why;  /* reason of the choice of `auto`, or NULL */
} MpmStabilization;

/* Title, for the log, and the prefix of all files of results. */
typedef struct {
  char *title, *prefix;
} MpmSceneName;

/* How points deform, and the function for the stretch of their domains. */
typedef struct {
  MpmKinematics kinematics;
  MpmStretch    stretch;
  MpmBed       *bed; /* of columns; NULL: they are none */
} MpmDeformation;

/* Shape functions, and their ends at the grid's edges. */
typedef struct {
  MpmShapeType type;
  MpmEdgeType  edge;
} MpmShapeChoice;

/* A body force of the caller's. */
typedef struct {
  MpmBodyForce function;
  void        *ctx;
} MpmForceField;

/* Steps of given lengths: when they end, s; `count` 0: none are given. */
typedef struct {
  PetscInt   count;
  PetscReal *time;
  PetscBool  taken; /* by a run beside this one, which has judged their errors and ways */
} MpmGivenSteps;

/* Stages in their order; at least one. */
typedef struct {
  PetscInt      count;
  MpmStage     *at;
  MpmGivenSteps given;
} MpmStages;

/* The scene as read: constant from then on. */
typedef struct {
  MpmSceneName     name;
  MpmPhysics       physics;
  MpmDeformation   deformation;
  MpmShapeChoice   shape;
  MpmMaterials    *materials;
  MpmBodies       *bodies;
  MpmConditions   *bcs;
  MpmBodyMotions  *motions;
  MpmBoundaries   *boundaries;
  MpmPairs        *pairs; /* contacts of bodies */
  MpmLoads        *loads;
  MpmBodySurfaces *surfaces; /* of bodies */
  MpmWaterTable   *water;
  MpmAddedTerms   *terms; /* of types from outside the tree */
  MpmFollow        follow;
  MpmForceField    body_force;
  MpmStabilization stabilization;
  MpmStages        stages;
} MpmScene;

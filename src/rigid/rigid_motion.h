#pragma once
/*
  Rigid boundaries whose place is solved for: options (rigid_freedom.c), and motion of body and attached places
  (rigid_motion.c).
*/
#include "base/base.h"
#include "base/types.h"
#include "rigid/facet.h"
#include "rigid/rigid.h"
#include "geometry/rotations.h"

/* Unknowns and loads of a body; about the reference point. */
typedef struct MpmFreedom {
  PetscInt  free[2];                                /* a bit for each axis: translations, rotations */
  PetscReal load[MPM_MAX_DIM], moment[MPM_MAX_DIM]; /* N and N m (2D: per metre; z), times ramp */
  PetscReal size;                                   /* m: a rotation's unknown is the angle times this */
  PetscReal mass, inertia, velocity[MPM_MAX_DIM];   /* kg, kg m2 about any axis; m/s as the scene begins */
  MpmRamp   ramp;
  PetscReal still; /* end of geostatic stages at the run's start, s: no motion before it, and time 0 of the ramp */
} MpmFreedom;

/* How far a body has come besides its prescribed motion: x -> c + shift + Q (x - c), c the reference point; Q a
   quaternion. */
struct MpmPlacement {
  PetscReal shift[MPM_MAX_DIM], turn[4];
  PetscReal last[6];                      /* the unknowns of the last step, without the way to the material */
  PetscReal velocity[6], acceleration[6]; /* of the unknowns, where the body has a mass */
};

/* Rows of the state (base/rows.h) of the free ones among a scene's boundaries. */
PetscErrorCode MpmRigidAddRows(const MpmBoundaries *boundaries, MpmPlacement placements[], MpmRows *rows);

/* An increment of a body's place, as the unknowns have it: translation, Rodrigues' parameters and their rotation. */
typedef struct {
  PetscReal shift[3], r[3], R[3][3], scale; /* scale: 2/(1 + r.r) */
} MpmRigidIncrement;

/* A free body in a step. */
struct MpmRigidBody {
  const MpmFreedom *freedom;    /* NULL: its motion is prescribed, and the members below are unused */
  MpmPlacement     *placement;  /* at the step's start */
  PetscInt          free[2];    /* a bit for each unknown of the step: of translations, of rotations */
  PetscInt  dim, extra, node;   /* its first extra node, and that one's local number: translation, then rotation */
  PetscReal Q[3][3];            /* the turn at the step's start */
  PetscReal pivot[3];           /* reference point at the step's start by the prescribed motion alone */
  PetscReal travel[3];          /* increment of the prescribed motion in the step */
  PetscReal load[3], moment[3]; /* of the step's balance */
  PetscReal more;               /* factor of the ramp's load and moment, from those to the mean of start and end */
  PetscReal guess[6];           /* unknowns from which Newton starts */
  PetscReal dt;                 /* s, in a step in which the body's inertia counts; otherwise 0 */
  PetscInt  spins;              /* a bit for each rotation that nothing ends while the material is at rest */
};

/* Of a facet by itself: the force on the material, and minus its derivative by the facet's own displacement. */
typedef struct {
  PetscReal force[MPM_MAX_DIM], stiffness[MPM_MAX_DIM][MPM_MAX_DIM];
} MpmFacetLaw;

/* Action of a facet on the nodes (0), the body's translation (1) and its rotation (2): residuals and their
   derivatives. */
typedef struct {
  PetscReal residual[3][3], derivative[3][3][3][3]; /* [of][component][by][component] */
} MpmRigidAnswer;

PetscErrorCode MpmFreedomRead(const MpmOptions *block, const MpmBoundary *boundary, MpmFreedom **freedom);
PetscErrorCode MpmFreedomDestroy(MpmFreedom **freedom);
/* True where its loads have a potential. A moment of constant direction has none where a body turns about several
   axes. */
PetscBool MpmFreedomIsSymmetric(const MpmFreedom *freedom);
/* True where it turns about two of three axes. The moment about the third is then not balanced. */
PetscBool MpmFreedomTurnsInPart(const MpmFreedom *freedom);

/* ---- how they move ---- */

void MpmRigidRotation(const PetscReal turn[4], PetscReal Q[3][3]);
/* The reference point where the prescribed motion alone has it. */
void MpmBoundaryReference(const MpmBoundary *boundary, const MpmPose *pose, PetscReal x[]);
/* Where the prescribed motion and, of a free boundary, the placement carry a place x of the boundary at rest; in place.
   */
void MpmRigidCarry(const MpmBoundary *boundary, const MpmPose *pose, const MpmPlacement *placement, PetscReal x[]);
/* Where they carry the middle of its solid. */
void MpmBoundaryMiddle(const MpmBoundary *boundary, const MpmPose *pose, const MpmPlacement *placement,
                       PetscReal place[]);
/* Distance and normal at the step's start of a body with its placement. */
void MpmRigidDistance(const MpmRigidBody *body, const MpmBoundary *boundary, const MpmPose *pose, const PetscReal x[],
                      MpmSurface *surface);
/* The increment that the local unknowns are; or from six numbers, translation first. */
void MpmRigidIncrementAt(const MpmRigidBody *body, PetscInt block, const PetscReal u[], MpmRigidIncrement *q);
void MpmRigidIncrementMake(const MpmRigidBody *body, const PetscReal values[6], MpmRigidIncrement *q);
/* The placement after an increment. */
void MpmRigidMove(const MpmRigidIncrement *q, MpmPlacement *placement);
/*
  A facet in the frame of its body: its place and normal at the step's start are put there once. `arm` is its distance
  from the reference point along the axes, at the step's start, or at its end where its displacement is u.
*/
void MpmRigidPull(const MpmRigidBody *body, MpmFacet *facet);
void MpmRigidPullVector(const MpmRigidBody *body, PetscReal vector[3]);
/* Where the facet stands at the step's start along the axes. */
void MpmRigidPush(const MpmRigidBody *body, const MpmFacet *facet, PetscReal place[]);
void MpmRigidArm(const MpmRigidBody *body, const MpmFacet *facet, PetscReal arm[3]);
void MpmRigidArmAfter(const MpmRigidBody *body, const MpmFacet *facet, const MpmRigidIncrement *q, const PetscReal u[],
                      PetscReal y[3]);
/* Its displacement u in the body's frame, and the rotation of the body's answers back to the axes. */
void MpmRigidSee(const MpmRigidBody *body, const MpmFacet *facet, const MpmRigidIncrement *q, const PetscReal u[],
                 PetscReal seen[]);
void MpmRigidAxes(const MpmRigidBody *body, const MpmRigidIncrement *q, PetscReal A[3][3]);
void MpmRigidTurn(const MpmRigidBody *body, const MpmRigidIncrement *q, MpmFacetLaw *answer);
/* Action of the facet on nodes and body; `derivative`: derivatives too. */
void MpmRigidCouple(const MpmRigidBody *body, const MpmFacet *facet, const MpmRigidIncrement *q, const PetscReal u[],
                    const MpmFacetLaw *answer, PetscBool derivative, MpmRigidAnswer *coupled);
/*
  Derivative of c . (relative displacement) by the body's translation and rotation; c along the axes, at the arm y. With
  `rows`: c in their rows, which differs where some rotations are fixed.
*/
void MpmRigidCovector(const MpmRigidBody *body, const MpmRigidIncrement *q, const PetscReal y[3], const PetscReal c[3],
                      PetscBool rows, PetscReal by[2][3]);
/* Residual of a body's loads, and its derivative by the rotation. */
void MpmRigidLoad(const MpmRigidBody *body, const MpmRigidIncrement *q, PetscReal residual[2][3],
                  PetscReal derivative[3][3]);

/* A rigid motion of all, as the body's two nodes have it: translation `along`, and rotation by `turn` about the origin.
   */
void MpmRigidMode(const MpmRigidBody *body, const PetscReal origin[], const PetscReal along[3], const PetscReal turn[3],
                  PetscReal mode[2][3]);

#pragma once
/*
  Boundaries whose place is solved for together with the grid: what is read of them (rigid_freedom.c), how they move
  (rigid_motion.c), what adds to the residual (rigid_body.c), and where they settle before Newton starts (rigid_settle.c).
*/
#include "base/base.h"
#include "base/types.h"
#include "terms/contact.h"
#include "terms/rigid.h"

/* What is solved for, and what pushes; about the reference point. */
typedef struct MpmFreedom {
  PetscInt  free[2];                                /* a bit for each axis: translations, rotations */
  PetscReal load[MPM_MAX_DIM], moment[MPM_MAX_DIM]; /* N and N m (2D: per metre; z), times ramp */
  PetscReal size;                                   /* m: a rotation's unknown is the angle times this */
  PetscReal mass, inertia, velocity[MPM_MAX_DIM];   /* kg, kg m2 about any axis; m/s as the scene begins */
  MpmRamp   ramp;
} MpmFreedom;

/* How far a body has come besides its prescribed motion: x -> c + shift + Q (x - c), c the reference point; Q a quaternion. */
struct MpmPlacement {
  PetscReal shift[MPM_MAX_DIM], turn[4];
  PetscReal last[6];                      /* the unknowns of the last step, without the way to the material */
  PetscReal velocity[6], acceleration[6]; /* of the unknowns, where the body has a mass */
};

/* An increment of a body's place, as the unknowns have it: translation, Rodrigues' parameters and their rotation. */
typedef struct {
  PetscReal shift[3], r[3], R[3][3], scale; /* scale: 2/(1 + r.r) */
} MpmRigidIncrement;

/* A free body in a step. */
struct MpmRigidBody {
  const MpmFreedom *freedom;    /* NULL: its motion is prescribed, and it has nothing of what follows */
  MpmPlacement     *placement;  /* at the step's start */
  PetscInt  dim, extra, node;   /* its first extra node, and that one's local number: translation, then rotation */
  PetscReal Q[3][3];            /* the turn at the step's start */
  PetscReal pivot[3];           /* the reference point at the step's start, where the prescribed motion alone has it, */
  PetscReal travel[3];          /* and what that motion adds in the step */
  PetscReal load[3], moment[3]; /* at the step's end */
  PetscReal guess[6];           /* unknowns from which Newton starts */
  PetscReal dt;                 /* s, in a step in which the body's inertia counts; otherwise 0 */
  PetscInt  spins;              /* a bit for each rotation that nothing ends while the material is at rest */
};

/* Of a facet by itself: the force on the material, and minus its derivative by the facet's own displacement. */
typedef struct {
  PetscReal force[MPM_MAX_DIM], stiffness[MPM_MAX_DIM][MPM_MAX_DIM];
} MpmFacetLaw;

/* What a facet does to the nodes (0), the body's translation (1) and its rotation (2): residuals and their derivatives. */
typedef struct {
  PetscReal residual[3][3], derivative[3][3][3][3]; /* [of][component][by][component] */
} MpmRigidAnswer;

/* A length of the body's order, m: a radius, half a diagonal; 1 where it has none. */
PetscReal      MpmBoundarySize(const MpmBoundary *boundary);
PetscErrorCode MpmFreedomRead(const MpmOptions *block, const MpmBoundary *boundary, MpmFreedom **freedom);
PetscErrorCode MpmFreedomDestroy(MpmFreedom **freedom);
/* Has what pushes it a potential? A moment that keeps its direction has none where a body turns about several axes. */
PetscBool MpmFreedomIsSymmetric(const MpmFreedom *freedom);
/* Does it turn about two of three axes? The moment about the third is no part of their balance. */
PetscBool MpmFreedomTurnsInPart(const MpmFreedom *freedom);

/* ---- rigid_motion.c ---- */

void MpmRigidRotation(const PetscReal turn[4], PetscReal Q[3][3]);
/* The reference point where the prescribed motion alone has it. */
void MpmBoundaryReference(const MpmBoundary *boundary, const MpmPose *pose, PetscReal x[]);
/* Where the prescribed motion and, of a free boundary, the placement carry a place x of the boundary at rest; in place. */
void MpmRigidCarry(const MpmBoundary *boundary, const MpmPose *pose, const MpmPlacement *placement, PetscReal x[]);
/* Distance and normal at the step's start of a body with its placement. */
void MpmRigidDistance(const MpmRigidBody *body, const MpmBoundary *boundary, const MpmPose *pose, const PetscReal x[],
                      MpmSurface *surface);
/* The increment that the local unknowns are; or from six numbers, translation first. */
void MpmRigidIncrementAt(const MpmRigidBody *body, PetscInt block, const PetscReal u[], MpmRigidIncrement *q);
void MpmRigidIncrementMake(const MpmRigidBody *body, const PetscReal values[6], MpmRigidIncrement *q);
/* The placement after an increment. */
void MpmRigidMove(const MpmRigidIncrement *q, MpmPlacement *placement);
/*
  A facet in the frame of its body: its place and normal at the step's start are put there once. `arm` is what it stands away
  from the reference point along the axes, at the step's start, or at its end where its displacement is u.
*/
void MpmRigidPull(const MpmRigidBody *body, MpmFacet *facet);
void MpmRigidPullVector(const MpmRigidBody *body, PetscReal vector[3]);
/* Where the facet stands at the step's start along the axes. */
void MpmRigidPush(const MpmRigidBody *body, const MpmFacet *facet, PetscReal place[]);
void MpmRigidArm(const MpmRigidBody *body, const MpmFacet *facet, PetscReal arm[3]);
void MpmRigidArmAfter(const MpmRigidBody *body, const MpmFacet *facet, const MpmRigidIncrement *q, const PetscReal u[],
                      PetscReal y[3]);
/* Its displacement u as the body sees it, and what turns the body's answers back to the axes. */
void MpmRigidSee(const MpmRigidBody *body, const MpmFacet *facet, const MpmRigidIncrement *q, const PetscReal u[],
                 PetscReal seen[]);
void MpmRigidAxes(const MpmRigidBody *body, const MpmRigidIncrement *q, PetscReal A[3][3]);
void MpmRigidTurn(const MpmRigidBody *body, const MpmRigidIncrement *q, MpmFacetLaw *answer);
/* What the facet does to nodes and body; `derivative`: derivatives too. */
void MpmRigidCouple(const MpmRigidBody *body, const MpmFacet *facet, const MpmRigidIncrement *q, const PetscReal u[],
                    const MpmFacetLaw *answer, PetscBool derivative, MpmRigidAnswer *coupled);
/*
  How c . (displacement seen) changes with the body's translation and rotation; c along the axes, at the arm y. With `rows`: what c
  is in their rows, which differs where some rotations are held.
*/
void MpmRigidCovector(const MpmRigidBody *body, const MpmRigidIncrement *q, const PetscReal y[3], const PetscReal c[3],
                      PetscBool rows, PetscReal by[2][3]);
/* Residual of what pushes a body, and its derivative by the rotation. */
void MpmRigidLoad(const MpmRigidBody *body, const MpmRigidIncrement *q, PetscReal residual[2][3],
                  PetscReal derivative[3][3]);

/* A rigid motion of all, as the body's two nodes have it: translation `along`, and rotation by `turn` about the origin. */
void MpmRigidMode(const MpmRigidBody *body, const PetscReal origin[], const PetscReal along[3], const PetscReal turn[3],
                  PetscReal mode[2][3]);

/* ---- rigid_body.c, rigid_settle.c ---- */

/* Takes over the places of the bodies, which are the state's; borrowed. */
PetscErrorCode MpmRigidCreate(MpmContacts *contacts, MpmPlacement *placements);
/*
  Where bodies stand as a step to `time` begins; before its contacts are looked for. dt: its length, where inertia counts in it,
  otherwise 0; gravity in m/s2.
*/
void MpmRigidBegin(MpmContacts *contacts, PetscReal time, PetscReal dt, const PetscReal gravity[]);
/*
  Bodies with a mass: their extra nodes among the nodes' masses, velocities and accelerations, dim values each; and back, from what is
  not NULL. Rest: they stand still.
*/
void MpmRigidToNodes(const MpmContacts *contacts, PetscReal mass[], PetscReal velocity[], PetscReal acceleration[]);
void MpmRigidFromNodes(MpmContacts *contacts, const PetscReal velocity[], const PetscReal acceleration[]);
void MpmRigidRest(MpmContacts *contacts);
/* How boundaries begin, by boundary; and the kinetic energy of those with a mass, J. */
void      MpmRigidStart(PetscInt count, const MpmBoundary boundaries[], MpmPlacement placements[]);
PetscReal MpmRigidKinetic(PetscInt count, const MpmBoundary boundaries[], const MpmPlacement placements[]);
/* The work of what pushes free bodies in a step at the local unknowns u, J, on the rank that owns these. */
PetscReal MpmRigidPushWork(const MpmContacts *contacts, const MpmSum *sum, const PetscReal u[]);

/* Room for one patch of a free body: its facets' displacements along the axes, what the law says, and the mean's derivatives. */
typedef struct {
  MpmPatchWork   law;
  MpmPatchAnswer answer;
  PetscReal (*u)[MPM_MAX_DIM];
  PetscReal *left, *right; /* sum_m left_m right_m^T over [n nodes, translation, rotation][3] */
} MpmRigidWork;
PetscErrorCode MpmRigidWorkCreate(const MpmContacts *contacts, const MpmSum *sum, MpmRigidWork *work);
PetscErrorCode MpmRigidWorkDestroy(MpmRigidWork *work);
/* The patch at work->u and the increment. */
void MpmRigidPatch(const MpmContacts *contacts, const MpmPatch *patch, const MpmRigidIncrement *q, MpmRigidWork *work);
/* One of its facets by itself. */
void MpmRigidFacet(const MpmContacts *contacts, const MpmPatch *patch, PetscInt f, const MpmRigidIncrement *q,
                   const MpmRigidWork *work, PetscBool derivative, MpmRigidAnswer *coupled);
/* left and right of the mean; n: nodes of the patch's box, or 0: those of the body alone. */
void MpmRigidMean(const MpmContacts *contacts, const MpmPatch *patch, const MpmRigidIncrement *q, PetscInt n,
                  MpmRigidWork *work);
/* For the report of a step: a patch at the local unknowns u, a facet's force and arm along the axes, a slip likewise. */
void MpmRigidEvaluate(const MpmContacts *contacts, const MpmPatch *patch, const MpmSum *sum, const PetscReal u[],
                      MpmPatchWork *work, MpmPatchAnswer *answer);
void MpmRigidForce(const MpmContacts *contacts, const MpmPatch *patch, PetscInt f, const MpmSum *sum,
                   const PetscReal u[], PetscReal force[], PetscReal arm[]);
void MpmRigidSlip(const MpmRigidBody *body, PetscInt block, const PetscReal u[], PetscReal slip[]);
/* Newton's start at the owned unknowns; `factor` times the last increment where a body has not settled anew. */
void MpmRigidGuess(const MpmContacts *contacts, const MpmSpace *space, PetscInt block, PetscReal factor,
                   PetscScalar x[]);
/*
  Brings bodies that nothing holds to where they come to rest on the material as it is, and puts that into their guess;
  contacts are those about the guess so far. `moved`: they have to be looked for again.
*/
PetscErrorCode MpmRigidSettle(MpmContacts *contacts, const MpmGrid *grid, PetscBool *moved);
/* Of a body that is adrift: what it does in place of coming to rest; it is as long as the message that it goes into needs. */
PetscErrorCode MpmRigidDescribeDrift(const MpmContacts *contacts, PetscInt b, size_t length, char text[]);
/*
  The same for bodies far from balance at the local unknowns u, the material staying as it is there; in the owned x their
  unknowns are changed. With `follows` they go a part of a cell at most from `last`, the owned unknowns before. Collective.
*/
PetscErrorCode MpmRigidRelax(const MpmContacts *contacts, const MpmSum *sum, const PetscReal u[], PetscBool follows,
                             const PetscScalar last[], PetscScalar x[]);
/*
  After Newton's method failed at the local unknowns u: a free body that contact lets go on in one component of its motion, or -1; `held`: it
  resists. Collective.
*/
PetscErrorCode MpmRigidUnheld(const MpmContacts *contacts, const MpmSum *sum, const PetscReal u[], PetscInt *unheld,
                              PetscInt *component, PetscBool *held);
/* A body that has left the place about which its contacts were looked for, or -1. */
PetscInt MpmRigidStray(const MpmContacts *contacts, PetscInt block, const PetscReal u[]);
/*
  Of a free body: its reference point, m, and its rotation vector (2D: z), degrees, besides what is prescribed; returns how
  many numbers that are.
*/
PetscInt MpmRigidReport(const MpmContacts *contacts, PetscInt b, PetscReal values[]);
/* The largest body residual over what acts there, of the owned unknowns' residual; 0 without bodies. */
PetscErrorCode MpmRigidImbalance(const MpmContacts *contacts, const MpmSpace *space, PetscInt block,
                                 const PetscScalar residual[], MPI_Comm comm, PetscReal *imbalance);

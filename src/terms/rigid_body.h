#pragma once
/*
  Boundaries whose place is solved for together with the grid: what is read of them (rigid_freedom.c), how they move
  (rigid_motion.c), what adds to the residual (rigid_body.c), and where they settle before Newton starts (rigid_settle.c).
*/
#include "base/base.h"
#include "base/types.h"
#include "terms/contact.h"
#include "terms/rigid.h"
#include "terms/terms.h"

/* What is solved for, and what pushes; about the reference point. */
typedef struct MpmFreedom {
  PetscInt  free[2];                                /* a bit for each axis: translations, rotations */
  PetscReal load[MPM_MAX_DIM], moment[MPM_MAX_DIM]; /* N and N m (2D: per metre; z), times ramp */
  PetscReal size;                                   /* m: a rotation's unknown is the angle times this */
  MpmRamp   ramp;
} MpmFreedom;

/* How far a body has come besides its prescribed motion: x -> c + shift + Q (x - c), c the reference point; Q a quaternion. */
struct MpmPlacement {
  PetscReal shift[MPM_MAX_DIM], turn[4];
  PetscReal last[6]; /* the unknowns of the last step */
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
};

/* What a contact does to the nodes (0), the body's translation (1) and its rotation (2): residuals and their derivatives. */
typedef struct {
  PetscReal residual[3][3], derivative[3][3][3][3]; /* [of][component][by][component] */
} MpmRigidAnswer;

PetscErrorCode MpmFreedomRead(const MpmOptions *block, const MpmBoundary *boundary, MpmFreedom **freedom);
PetscErrorCode MpmFreedomDestroy(MpmFreedom **freedom);
/* Has what pushes it a potential? A moment that keeps its direction has none where a body turns about several axes. */
PetscBool MpmFreedomIsSymmetric(const MpmFreedom *freedom);

/* ---- rigid_motion.c ---- */

void MpmRigidRotation(const PetscReal turn[4], PetscReal Q[3][3]);
/* The reference point where the prescribed motion alone has it. */
void MpmBoundaryReference(const MpmBoundary *boundary, const MpmPose *pose, PetscReal x[]);
/* Distance and normal at the step's start of a body with its placement. */
void MpmRigidDistance(const MpmRigidBody *body, const MpmBoundary *boundary, const MpmPose *pose, const PetscReal x[],
                      MpmSurface *surface);
/* The increment that the local unknowns are; or from six numbers, translation first. */
void MpmRigidIncrementAt(const MpmRigidBody *body, PetscInt block, const PetscReal u[], MpmRigidIncrement *q);
void MpmRigidIncrementMake(const MpmRigidBody *body, const PetscReal values[6], MpmRigidIncrement *q);
/* The placement after an increment. */
void MpmRigidMove(const MpmRigidIncrement *q, MpmPlacement *placement);
/*
  A contact in the frame of its body: the place and the vectors of the contact, at the step's start, are put there once;
  `arm` is what its face stands away from the reference point along the axes.
*/
void MpmRigidPull(const MpmRigidBody *body, MpmContact *contact);
void MpmRigidArm(const MpmRigidBody *body, const MpmContact *contact, PetscReal arm[3]);
/* Its displacement u as the body sees it, and the law's answer there turned back to the axes. */
void MpmRigidSee(const MpmRigidBody *body, const MpmContact *contact, const MpmRigidIncrement *q, const PetscReal u[],
                 PetscReal seen[]);
void MpmRigidTurn(const MpmRigidBody *body, const MpmRigidIncrement *q, MpmContactAnswer *answer);
/* What it does to nodes and body; `derivative`: derivatives too. */
void MpmRigidCouple(const MpmRigidBody *body, const MpmContact *contact, const MpmRigidIncrement *q,
                    const PetscReal u[], const MpmContactAnswer *answer, PetscBool derivative, MpmRigidAnswer *coupled);
/* Where the reference point and the contact's face stand at the step's end; `value`: the face's displacement. */
void MpmRigidPlace(const MpmRigidBody *body, PetscInt block, const MpmContact *contact, const PetscReal u[],
                   const PetscReal value[], PetscReal reference[], PetscReal face[]);
/* Residual of what pushes a body, and its derivative by the rotation. */
void MpmRigidLoad(const MpmRigidBody *body, const MpmRigidIncrement *q, PetscReal residual[2][3],
                  PetscReal derivative[3][3]);

/* A rigid motion of all, as the body's two nodes have it: translation `along`, and rotation by `turn` about the origin. */
void MpmRigidMode(const MpmRigidBody *body, const PetscReal origin[], const PetscReal along[3], const PetscReal turn[3],
                  PetscReal mode[2][3]);

/* ---- rigid_body.c, rigid_settle.c ---- */

/* Takes over the places of the bodies, which are the state's; borrowed. */
PetscErrorCode MpmRigidCreate(MpmContacts *contacts, MpmPlacement *placements);
/* Where bodies stand as a step begins; before its contacts are looked for. */
void MpmRigidBegin(MpmContacts *contacts, const MpmTermStep *step);
/* A contact of a free body at the local unknowns u; PETSC_FALSE: it does not act. */
PetscBool MpmContactAnswerFree(const MpmContacts *contacts, const MpmSum *sum, const MpmContact *contact,
                               const PetscReal u[], PetscBool derivative, MpmContactAnswer *answer,
                               MpmRigidAnswer *coupled);
/* The same with the face's displacement and the increment given. */
PetscBool MpmContactAnswerAt(const MpmContacts *contacts, const MpmContact *contact, const MpmRigidIncrement *q,
                             const PetscReal value[], PetscBool derivative, MpmContactAnswer *answer,
                             MpmRigidAnswer *coupled);
/* Newton's start at the owned unknowns; `factor` times the last increment where a body has not settled anew. */
void MpmRigidGuess(const MpmContacts *contacts, const MpmSpace *space, PetscInt block, PetscReal factor,
                   PetscScalar x[]);
/*
  Brings bodies that nothing holds to where they come to rest on the material as it is, and puts that into their guess;
  contacts are those about the guess so far. `moved`: they have to be looked for again.
*/
PetscErrorCode MpmRigidSettle(MpmContacts *contacts, const MpmSum *sum, PetscBool *moved);
/*
  The same for bodies far from balance at the local unknowns u, the material staying as it is there; in the owned x their
  unknowns are changed. Where `last`, the owned unknowns before, is not NULL they go a part of a cell at most from there.
  Collective.
*/
PetscErrorCode MpmRigidRelax(const MpmContacts *contacts, const MpmSum *sum, const PetscReal u[],
                             const PetscScalar last[], PetscScalar x[]);
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

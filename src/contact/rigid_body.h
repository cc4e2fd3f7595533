#pragma once
/*
  Boundaries whose place is solved for together with the grid: what adds to the residual (rigid_body.c), and where they settle before
  Newton starts (rigid_settle.c).
*/
#include "base/base.h"
#include "base/types.h"
#include "rigid/rigid_motion.h"
#include "contact/contact.h"

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

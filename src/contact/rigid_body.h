#pragma once
/*
  Boundaries whose place is solved for together with the grid: their terms in the residual (rigid_body.c), and their
  settling before Newton's method starts (rigid_settle.c).
*/
#include "base/base.h"
#include "base/types.h"
#include "rigid/rigid_motion.h"
#include "contact/contact.h"

/* Takes over the places of the bodies, which are the state's; borrowed. */
PetscErrorCode MpmRigidCreate(MpmContacts *contacts, MpmPlacement *placements);
/*
  Places and loads of the bodies as a step begins, loads by the integrator's weights; before the search for contacts.
*/
void MpmRigidBegin(MpmContacts *contacts, const MpmRules *rules);
/* Initial placements, by boundary. */
void MpmRigidStart(PetscInt count, const MpmBoundary boundaries[], MpmPlacement placements[]);
/* Operations of the term in steps with inertia, of bodies with a mass (MpmTermMotion; rigid_inertia.c). */
void      MpmRigidRest(void *ctx);
void      MpmRigidLend(const void *ctx, PetscReal mass[], PetscReal velocity[], PetscReal acceleration[]);
void      MpmRigidTake(void *ctx, const PetscReal velocity[], const PetscReal acceleration[]);
PetscReal MpmRigidKinetic(const void *ctx);

/* Room for one patch of a free body: its facets' displacements along the axes, the answer, the mean's derivatives. */
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
/*
  Brings unsupported bodies to their place of rest on the present material, as the start of Newton's method; contacts
  are those about the start so far. `moved`: contacts have to be searched again.
*/
PetscErrorCode MpmRigidSettle(MpmContacts *contacts, const MpmGrid *grid, PetscBool *moved);
/* A body that is adrift: motion in place of rest (a term's `refuses`). */
PetscErrorCode MpmRigidRefuses(const void *ctx, MpmOutcome *outcome);
/*
  MpmRigidSettle() for bodies far from balance at the local unknowns u; changes their unknowns in the owned x. With
  `follows` they go a fraction of a cell at most from `last`, the owned unknowns before. Collective.
*/
PetscErrorCode MpmRigidRelax(const void *ctx, const MpmSum *sum, const PetscReal u[], PetscBool follows,
                             const PetscScalar last[], PetscScalar x[]);
/* Reports a free body with a component of motion that contact does not support (a term's `unheld`). Collective. */
PetscErrorCode MpmRigidUnheld(const void *ctx, const MpmSum *sum, const PetscReal u[], MpmOutcome *outcome);
/* True where a body has left the place about which its contacts were searched. */
PetscBool MpmRigidStray(const void *ctx, const MpmSum *sum, const PetscReal u[]);
/*
  Of a free body: its reference point, m, and its rotation vector (2D: z), degrees, besides the prescribed ones; returns
  the number of values.
*/
PetscInt MpmRigidReport(const MpmContacts *contacts, PetscInt b, PetscReal values[]);

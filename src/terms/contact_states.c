/*
  What patches do from one of Newton's iterates to the next.

  The first iterate is extrapolated from the last step. Where a die that came down starts to go sideways, or a roller to turn, that leaves the
  surface, and Newton's method would start from a body without contact. So what touched at the step's start, and does not at the
  first iterate, is held for the first iteration: it sticks, and is pulled back where it has gone.

  While patches go on to touch, part, stick, slide or turn round from one iterate to the next, the derivative of what slides is its secant
  (contact_law.c). When nothing has changed in an iteration, it is the exact one.
*/
#include "grid/grid.h"
#include "space/sum.h"
#include "terms/contact.h"
#include "terms/rigid_body.h"

#define TURNED 0.5 /* cosine of the angle by which what slides has turned */
#define RESTED 0.5 /* of the slip that slides now: what was less did not slide */

/* What a patch does at u. */
static MpmPatchState StateOf(const MpmContacts *contacts, const MpmPatch *patch, const MpmSum *sum, const PetscReal u[],
                             MpmPatchWork *work, MpmPatchAnswer *answer)
{
  if (MpmContactsBody(contacts, patch->boundary)) MpmRigidEvaluate(contacts, patch, sum, u, work, answer);
  else MpmPatchEvaluateAt(contacts, patch, sum, u, work, answer);
  if (!answer->active) return MPM_PATCH_OPEN;
  return answer->slides ? MPM_PATCH_SLIDES : MPM_PATCH_STICKS;
}

/* Did it touch at the step's start, by where its facets stand there? */
static PetscBool Touched(const MpmContacts *contacts, const MpmPatch *patch)
{
  PetscReal gap = -patch->shift;

  for (PetscInt f = patch->begin; f < patch->end; f++) {
    const MpmFacet *facet = &contacts->facet[f];
    MpmSurface      surface;

    MpmContactsDistance(contacts, patch->boundary, facet->place, &surface);
    gap += facet->area / patch->area * ((facet->side ? facet->distance : surface.distance) - facet->touches);
  }
  return (PetscBool)(gap <= contacts->touch);
}

/* Does it slide another way than the slip that is kept of the last step, or from rest? */
static PetscBool Turned(const MpmContacts *contacts, const MpmPatch *patch, const MpmPatchAnswer *answer)
{
  PetscReal slip[MPM_MAX_DIM] = {0., 0., 0.}, along = 0., square = 0., before = 0.;

  for (PetscInt f = patch->begin; f < patch->end; f++)
    for (PetscInt a = 0; a < MPM_MAX_DIM; a++)
      slip[a] += contacts->facet[f].area / patch->area * contacts->facet[f].slip[a];
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    along += slip[a] * answer->slip[a];
    square += PetscSqr(answer->slip[a]);
    before += PetscSqr(slip[a]);
  }
  return (PetscBool)(along < TURNED * PetscSqrtReal(square * before) || before < PetscSqr(RESTED) * square);
}

PetscErrorCode MpmContactsBegin(MpmContacts *contacts, const MpmSum *sum, const PetscReal u[])
{
  MpmPatchWork work;

  PetscFunctionBeginUser;
  MpmContactsEnd(contacts);
  if (!contacts->boundary_count) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmPatchWorkCreate(contacts, &work));
  for (PetscInt k = 0; k < contacts->patch_count; k++) {
    MpmPatch      *patch = &contacts->patch[k];
    MpmPatchAnswer answer;

    patch->state = StateOf(contacts, patch, sum, u, &work, &answer);
    for (PetscInt a = 0; a < MPM_MAX_DIM; a++) patch->traction[a] = answer.traction[a];
    patch->held = (PetscBool)(patch->state == MPM_PATCH_OPEN && !MpmContactsBody(contacts, patch->boundary) &&
                              Touched(contacts, patch));
    if (patch->held) contacts->holds = PETSC_TRUE;
    if (patch->held || (patch->state == MPM_PATCH_SLIDES && Turned(contacts, patch, &answer)))
      contacts->secant = PETSC_TRUE;
  }
  PetscCall(MpmPatchWorkDestroy(&work));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &contacts->holds, 1, MPM_MPI_BOOL, MPI_LOR, sum->grid->comm));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &contacts->secant, 1, MPM_MPI_BOOL, MPI_LOR, sum->grid->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmContactsFollow(MpmContacts *contacts, const MpmSum *sum, const PetscReal u[])
{
  PetscBool    changed = PETSC_FALSE;
  MpmPatchWork work;

  PetscFunctionBeginUser;
  contacts->holds = PETSC_FALSE;
  PetscCall(MpmPatchWorkCreate(contacts, &work));
  for (PetscInt k = 0; k < contacts->patch_count; k++) {
    MpmPatch           *patch = &contacts->patch[k];
    const MpmPatchState last  = patch->held ? MPM_PATCH_STICKS : patch->state;
    PetscReal           along = 0.;
    MpmPatchAnswer      answer;

    patch->held  = PETSC_FALSE;
    patch->state = StateOf(contacts, patch, sum, u, &work, &answer);
    for (PetscInt a = 0; a < MPM_MAX_DIM; a++) along += answer.traction[a] * patch->traction[a];
    for (PetscInt a = 0; a < MPM_MAX_DIM; a++) patch->traction[a] = answer.traction[a];
    if (patch->state != last || (patch->state == MPM_PATCH_SLIDES && along < 0.)) changed = PETSC_TRUE;
  }
  PetscCall(MpmPatchWorkDestroy(&work));
  PetscCall(MPIU_Allreduce(&changed, &contacts->secant, 1, MPM_MPI_BOOL, MPI_LOR, sum->grid->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MpmContactsEnd(MpmContacts *contacts)
{
  contacts->secant = contacts->holds = PETSC_FALSE;
  for (PetscInt k = 0; k < contacts->patch_count; k++) contacts->patch[k].held = PETSC_FALSE;
}

/*
  Patches between bodies from one of Newton's iterates to the next, and between its solutions.

  Bodies that slide over one another have come to other facets as a step starts, by more than the depth of a stiff
  contact. Where nothing touches at the first iterate, patches that slid in the last step stay closed for one iteration.
*/
#include "point/layout.h"
#include "space/sum.h"
#include "pairs/body_contact.h"
#include "pairs/body_patch.h"
#include "facets/contact_law.h"

PetscErrorCode MpmPairsAddSquares(const void *ctx, const MpmSum *sum, const PetscReal u[], PetscReal *squares)
{
  const MpmPairContacts *contacts = (const MpmPairContacts *)ctx;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < contacts->patch_count; k++) {
    PetscReal     w[MPM_PAIR_ROWS];
    MpmPairAnswer answer;

    MpmPairRelative(contacts, &contacts->patch[k], sum, u, w);
    MpmPairEvaluate(contacts, &contacts->patch[k], sum->layout->dim, w, &answer);
    for (PetscInt a = 0; a < sum->layout->dim; a++) *squares += PetscSqr(answer.force[a]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPairsAugment(void *ctx, const MpmSum *sum, const PetscReal u[], PetscBool first, PetscReal *worst)
{
  MpmPairContacts *contacts = (MpmPairContacts *)ctx;
  PetscReal       *shift;
  PetscBool        any = PETSC_FALSE;

  PetscFunctionBeginUser;
  (void)first;
  *worst = 0.;
  for (PetscInt p = 0; p < contacts->pairs->count; p++) any = (PetscBool)(any || contacts->pairs->at[p].augmented);
  if (!any) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(contacts->patch_count, &shift));
  for (PetscInt k = 0; k < contacts->patch_count; k++) {
    const MpmPairPatch *patch = &contacts->patch[k];
    const MpmPair      *pair  = &contacts->pairs->at[patch->pair];
    PetscReal           w[MPM_PAIR_ROWS];
    MpmPairAnswer       answer;

    shift[k] = 0.;
    if (!pair->augmented) continue;
    MpmPairRelative(contacts, patch, sum, u, w);
    MpmPairEvaluate(contacts, patch, sum->layout->dim, w, &answer);
    if (answer.active) shift[k] = -answer.gap;
    if (answer.active || patch->shift > 0.)
      *worst = PetscMax(*worst, PetscAbsReal(shift[k] - patch->shift) / (pair->penetration * contacts->cell));
  }
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, worst, 1, MPIU_REAL, MPIU_MAX, contacts->comm));
  for (PetscInt k = 0; *worst > 1. && k < contacts->patch_count; k++) contacts->patch[k].shift = shift[k];
  PetscCall(PetscFree(shift));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- at the first of Newton's iterates ---- */

#define NEAR 0.1 /* of a cell: distance beyond which contact is open */

/* True where any patch of the pair touches at u, on any rank. */
static PetscErrorCode Touches(const MpmPairContacts *contacts, PetscInt pair, const MpmSum *sum, const PetscReal u[],
                              PetscBool *touches)
{
  PetscFunctionBeginUser;
  *touches = PETSC_FALSE;
  for (PetscInt k = 0; k < contacts->patch_count && !*touches; k++) {
    PetscReal     w[MPM_PAIR_ROWS];
    MpmPairAnswer answer;

    if (contacts->patch[k].pair != pair) continue;
    MpmPairRelative(contacts, &contacts->patch[k], sum, u, w);
    MpmPairEvaluate(contacts, &contacts->patch[k], sum->layout->dim, w, &answer);
    *touches = answer.active;
  }
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, touches, 1, MPM_MPI_BOOL, MPI_LOR, contacts->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPairsBegin(void *ctx, const MpmSum *sum, const PetscReal u[], PetscBool careful)
{
  MpmPairContacts *contacts = (MpmPairContacts *)ctx;
  const PetscInt   dim      = sum->layout->dim;

  PetscFunctionBeginUser;
  (void)careful;
  MpmPairsEnd(contacts);
  contacts->newton.least = MPM_CONTACT_LEAST;
  for (PetscInt p = 0; p < contacts->pairs->count; p++) {
    const MpmPair *pair    = &contacts->pairs->at[p];
    PetscBool      touches = PETSC_TRUE;

    if (pair->friction > 0. && !pair->barrier) PetscCall(Touches(contacts, p, sum, u, &touches));
    for (PetscInt k = 0; !touches && k < contacts->patch_count; k++) {
      MpmPairPatch *patch = &contacts->patch[k];
      PetscReal     size  = 0., w[MPM_PAIR_ROWS];
      MpmPairAnswer answer;

      for (PetscInt a = 0; a < dim; a++) size += PetscSqr(patch->slip[a]);
      if (patch->pair != p || !(size > 0.)) continue;
      MpmPairRelative(contacts, patch, sum, u, w);
      MpmPairEvaluate(contacts, patch, dim, w, &answer);
      if (answer.gap > NEAR * contacts->cell) continue;
      patch->held = contacts->newton.holds = PETSC_TRUE;
      for (PetscInt a = 0; a < dim; a++) patch->way[a] = patch->slip[a] / PetscSqrtReal(size);
    }
  }
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &contacts->newton.holds, 1, MPM_MPI_BOOL, MPI_LOR, contacts->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MpmPairsGive(void *ctx, PetscReal give)
{
  MpmPairContacts *contacts = (MpmPairContacts *)ctx;

  for (PetscInt k = 0; k < contacts->patch_count; k++)
    for (PetscInt a = 0; a < MPM_MAX_DIM && !contacts->pairs->at[contacts->patch[k].pair].stick; a++)
      contacts->patch[k].slip[a] *= give / contacts->newton.give;
  contacts->newton.give = give;
}

static void Release(MpmPairContacts *contacts)
{
  contacts->newton.holds = PETSC_FALSE;
  for (PetscInt k = 0; k < contacts->patch_count; k++) contacts->patch[k].held = PETSC_FALSE;
}

PetscErrorCode MpmPairsRelease(void *ctx, const MpmSum *sum, const PetscReal u[], PetscBool *changed)
{
  PetscFunctionBeginUser;
  (void)sum, (void)u, (void)changed;
  Release((MpmPairContacts *)ctx);
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MpmPairsEnd(void *ctx)
{
  MpmPairContacts *contacts = (MpmPairContacts *)ctx;

  Release(contacts);
  contacts->newton.least = 0.;
}

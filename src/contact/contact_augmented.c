/*
  Method augmented: after Newton's method has converged, the pressures of patches are corrected until their depths are
  below the accepted one. The penalty is raised where that takes too long.
*/
#include "grid/grid.h"
#include "space/sum.h"
#include "contact/contact.h"
#include "contact/rigid_body.h"

#define SLOW  0.1  /* of the depth that a correction leaves at most, or the penalty is raised */
#define RAISE 10.  /* by this, and */
#define MOST  100. /* by no more than this in all: multigrid gives up beyond 1000 */

PetscBool MpmPatchIsCorrected(const MpmContacts *contacts, const MpmPatch *patch)
{
  const MpmFacet *facet = &contacts->facets.at[patch->begin];

  return (PetscBool)(contacts->facets.boundaries[patch->boundary].augmented && !(facet->key.single && facet->askew));
}

/* Depths over the accepted ones, the worst of all, and the shifts that would remove them. */
static PetscErrorCode FindShifts(const MpmContacts *contacts, const MpmSum *sum, const PetscReal u[], PetscReal shift[],
                                 PetscReal *worst)
{
  MpmPatchWork work;

  PetscFunctionBeginUser;
  *worst = 0.;
  PetscCall(MpmPatchWorkCreate(contacts, &work));
  for (PetscInt k = 0; k < contacts->patch_count; k++) {
    const MpmPatch    *patch    = &contacts->patch[k];
    const MpmBoundary *boundary = &contacts->facets.boundaries[patch->boundary];
    MpmPatchAnswer     answer;

    shift[k] = 0.;
    if (!MpmPatchIsCorrected(contacts, patch)) continue;
    MpmPatchFrame(contacts, patch)->evaluate(contacts, patch, sum, u, &work, &answer);
    if (!answer.active) continue;
    shift[k] = -answer.gap;
    *worst   = PetscMax(*worst, PetscAbsReal(answer.gap + patch->shift) / boundary->bounds.penetration);
  }
  PetscCall(MpmPatchWorkDestroy(&work));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, worst, 1, MPIU_REAL, MPIU_MAX, sum->grid->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmContactsAugment(void *ctx, const MpmSum *sum, const PetscReal u[], PetscBool first, PetscReal *worst)
{
  MpmContacts *contacts = (MpmContacts *)ctx;
  PetscReal   *shift;
  PetscBool    any = PETSC_FALSE, raise;

  PetscFunctionBeginUser;
  *worst = 0.;
  for (PetscInt b = 0; b < contacts->facets.boundary_count; b++)
    any = (PetscBool)(any || contacts->facets.boundaries[b].augmented);
  if (!any) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(contacts->patch_count, &shift));
  PetscCall(FindShifts(contacts, sum, u, shift, worst));
  raise =
    (PetscBool)(*worst > 1. && !first && *worst >= SLOW * contacts->newton.deepest && contacts->newton.raised < MOST);
  contacts->newton.deepest = *worst;
  if (raise) contacts->newton.raised *= RAISE;
  for (PetscInt k = 0; *worst > 1. && k < contacts->patch_count; k++) {
    MpmPatch          *patch    = &contacts->patch[k];
    const MpmBoundary *boundary = &contacts->facets.boundaries[patch->boundary];

    patch->shift = shift[k];
    if (!raise || !boundary->augmented || boundary->tangential) continue; /* slips are measured by it */
    patch->stiffness *= RAISE;
    patch->shift /= RAISE;
  }
  PetscCall(PetscFree(shift));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  States of patches from one of Newton's iterates to the next.

  The first iterate is extrapolated from the last step. This iterate leaves the surface by more than the depth of a
  stiff contact, where facets have come into other patches, and where a die that came down starts to go sideways, or a
  roller to turn. Newton's method would then start with a fraction of the contact only, and the remainder would spring
  back, deep into the surface. Therefore contacts that are closed at the step's start and open at the first iterate are
  kept closed for the first iteration. Such contacts glide where this step's slip is far beyond the limit of their
  pressure at the start, and stick elsewhere.

  With care, while patches close, open, stick, slide or reverse from one iterate to the next, the derivative of sliding
  is its secant (contact_law.c). When nothing has changed in an iteration, it is the exact one.
*/
#include "grid/grid.h"
#include "space/sum.h"
#include "contact/contact.h"
#include "facets/contact_law.h"
#include "contact/rigid_body.h"

#define TURNED 0.5 /* cosine of the angle between successive directions of sliding */
#define RESTED 0.5 /* of the slip that slides now: below it contact did not slide */
#define FAR    2.  /* times the limit of friction at the step's start: a slip that is far beyond it */

/* State of a patch at u. */
static MpmPatchState StateOf(const MpmContacts *contacts, const MpmPatch *patch, const MpmSum *sum, const PetscReal u[],
                             MpmPatchWork *work, MpmPatchAnswer *answer)
{
  MpmPatchFrame(contacts, patch)->evaluate(contacts, patch, sum, u, work, answer);
  if (!answer->active) return MPM_PATCH_OPEN;
  return answer->slides ? MPM_PATCH_SLIDES : MPM_PATCH_STICKS;
}

PetscReal MpmPatchStartGap(const MpmContacts *contacts, const MpmPatch *patch)
{
  PetscReal gap = -patch->shift;

  for (PetscInt f = patch->begin; f < patch->end; f++) {
    const MpmFacet *facet = &contacts->facets.at[f];
    MpmSurface      surface;

    MpmFacetsDistance(&contacts->facets, patch->boundary, facet->place, &surface);
    gap += facet->area / patch->area * ((facet->key.side ? facet->distance : surface.distance) - facet->touches);
  }
  return gap;
}

/* True where it slides in another direction than the slip kept of the last step, or from rest. */
static PetscBool Turned(const MpmContacts *contacts, const MpmPatch *patch, const MpmPatchAnswer *answer)
{
  PetscReal slip[MPM_MAX_DIM] = {0., 0., 0.}, along = 0., square = 0., before = 0.;

  for (PetscInt f = patch->begin; f < patch->end; f++)
    for (PetscInt a = 0; a < MPM_MAX_DIM; a++)
      slip[a] += contacts->facets.at[f].area / patch->area * contacts->facets.at[f].slip[a];
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    along += slip[a] * answer->slip[a];
    square += PetscSqr(answer->slip[a]);
    before += PetscSqr(slip[a]);
  }
  return (PetscBool)(along < TURNED * PetscSqrtReal(square * before) || before < PetscSqr(RESTED) * square);
}

/* Keeps a patch that is open at u closed where required, sticking or gliding. */
static void Hold(const MpmContacts *contacts, MpmPatch *patch, const MpmSum *sum, const PetscReal u[],
                 MpmPatchWork *work)
{
  const MpmBoundary *boundary = &contacts->facets.boundaries[patch->boundary];
  const PetscReal    gap      = MpmPatchStartGap(contacts, patch);
  const PetscReal    limit    = patch->stiffness * boundary->friction * PetscMax(-gap, 0.) + boundary->adhesion;
  PetscReal          size     = 0.;
  MpmPatchAnswer     answer;

  if (MpmFacetsBody(&contacts->facets, patch->boundary) || gap > contacts->facets.touch) return;
  patch->hold.on = PETSC_TRUE;
  if (!boundary->tangential || boundary->stick) return;
  (void)StateOf(contacts, patch, sum, u, work, &answer); /* sticks: the whole slip */
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) size += PetscSqr(answer.slip[a]);
  size               = PetscSqrtReal(size);
  patch->hold.glides = (PetscBool)(MpmPatchAlong(contacts, patch) * patch->stiffness * size > FAR * limit);
  for (PetscInt a = 0; patch->hold.glides && a < MPM_MAX_DIM; a++) patch->hold.way[a] = answer.slip[a] / size;
}

PetscErrorCode MpmContactsBegin(void *ctx, const MpmSum *sum, const PetscReal u[], PetscBool careful)
{
  MpmContacts *contacts = (MpmContacts *)ctx;
  MpmPatchWork work;

  PetscFunctionBeginUser;
  MpmContactsEnd(contacts);
  if (!contacts->facets.boundary_count) PetscFunctionReturn(PETSC_SUCCESS);
  contacts->newton.careful = careful;
  contacts->newton.least   = MPM_CONTACT_LEAST;
  PetscCall(MpmPatchWorkCreate(contacts, &work));
  for (PetscInt k = 0; k < contacts->patch_count; k++) {
    MpmPatch      *patch = &contacts->patch[k];
    MpmPatchAnswer answer;

    patch->state = StateOf(contacts, patch, sum, u, &work, &answer);
    for (PetscInt a = 0; a < MPM_MAX_DIM; a++) patch->traction[a] = answer.traction[a];
    if (patch->state == MPM_PATCH_OPEN) Hold(contacts, patch, sum, u, &work);
    if (patch->hold.on) contacts->newton.holds = PETSC_TRUE;
    if (careful && (patch->hold.on || (patch->state == MPM_PATCH_SLIDES && Turned(contacts, patch, &answer))))
      contacts->newton.secant = PETSC_TRUE;
  }
  PetscCall(MpmPatchWorkDestroy(&work));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &contacts->newton.holds, 1, MPM_MPI_BOOL, MPI_LOR, sum->grid->comm));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &contacts->newton.secant, 1, MPM_MPI_BOOL, MPI_LOR, sum->grid->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmContactsFollow(void *ctx, const MpmSum *sum, const PetscReal u[], PetscBool *changed)
{
  MpmContacts    *contacts = (MpmContacts *)ctx;
  const PetscBool secant   = contacts->newton.secant;
  PetscBool       other    = PETSC_FALSE;
  MpmPatchWork    work;

  PetscFunctionBeginUser;
  if (!contacts->newton.careful && !contacts->newton.holds) PetscFunctionReturn(PETSC_SUCCESS);
  contacts->newton.holds = PETSC_FALSE;
  PetscCall(MpmPatchWorkCreate(contacts, &work));
  for (PetscInt k = 0; k < contacts->patch_count; k++) {
    MpmPatch           *patch = &contacts->patch[k];
    const MpmPatchState held  = patch->hold.glides ? MPM_PATCH_SLIDES : MPM_PATCH_STICKS;
    const MpmPatchState last  = patch->hold.on ? held : patch->state;
    PetscReal           along = 0.;
    MpmPatchAnswer      answer;

    patch->hold.on = patch->hold.glides = PETSC_FALSE;
    patch->state                        = StateOf(contacts, patch, sum, u, &work, &answer);
    for (PetscInt a = 0; a < MPM_MAX_DIM; a++) along += answer.traction[a] * patch->traction[a];
    for (PetscInt a = 0; a < MPM_MAX_DIM; a++) patch->traction[a] = answer.traction[a];
    if (patch->state != last || (patch->state == MPM_PATCH_SLIDES && along < 0.)) other = PETSC_TRUE;
  }
  PetscCall(MpmPatchWorkDestroy(&work));
  other = (PetscBool)(other && contacts->newton.careful);
  PetscCall(MPIU_Allreduce(&other, &contacts->newton.secant, 1, MPM_MPI_BOOL, MPI_LOR, sum->grid->comm));
  if (contacts->newton.secant != secant) *changed = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MpmContactsGive(void *ctx, PetscReal give)
{
  MpmContacts *contacts = (MpmContacts *)ctx;

  for (PetscInt k = 0; k < contacts->facets.count; k++)
    for (PetscInt a = 0; a < MPM_MAX_DIM && !contacts->facets.boundaries[contacts->facets.at[k].boundary].stick; a++)
      contacts->facets.at[k].slip[a] *= give / contacts->newton.give;
  contacts->newton.give = give;
}

void MpmContactsEnd(void *ctx)
{
  MpmContacts *contacts = (MpmContacts *)ctx;

  contacts->newton.careful = contacts->newton.secant = contacts->newton.holds = PETSC_FALSE;
  contacts->newton.least                                                      = 0.;
  for (PetscInt k = 0; k < contacts->patch_count; k++)
    contacts->patch[k].hold.on = contacts->patch[k].hold.glides = PETSC_FALSE;
}

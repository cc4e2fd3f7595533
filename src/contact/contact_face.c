/*
  Pressure on a face, and run-up: what a wall is designed for.

  Pressure: the largest of the patches, which are as large as a cell's part of the surface. Contact of material that
  flows comes and goes from step to step: its pressure is the mean over time

    p <- (1 - a) p + a p_n ,   a = 0.05 ,

  p_n of the step, 0 where it does not touch, which the points keep. Of other material it is that of the step.

  Run-up: from the lowest place of contact to the highest one, along the last axis, the domains of the points included.
  Contact is where other material touches in the step, and where points that flow have a mean pressure of at least a
  hundredth of the largest.
*/
#include "grid/grid.h"
#include "particles/particles.h"
#include "particles/points.h"
#include "space/space.h"
#include "space/sum.h"
#include "contact/contact.h"

#define LEAST 0.01 /* of the largest pressure */

/* Half of the height of a point's domain, m. */
static PetscReal Half(const MpmPoints *points, PetscInt dim, PetscInt p)
{
  const PetscReal *F    = &MpmPointF(points, p)[(dim - 1) * dim];
  PetscReal        half = 0.;

  for (PetscInt a = 0; points->domain.half_length && a < dim; a++)
    half += PetscAbsReal(F[a]) * points->domain.half_length[p * dim + a];
  return half;
}

/* Takes a height of contact into the ends. */
static void Extend(PetscReal place, PetscReal half, PetscReal ends[2])
{
  ends[0] = PetscMax(ends[0], place + half);
  ends[1] = PetscMax(ends[1], half - place);
}

/* True where a patch has its pressure from the points' means. */
static PetscBool HasMean(const MpmContacts *contacts, const MpmPatch *patch)
{
  return (PetscBool)(MpmPatchFlows(contacts, patch) && !contacts->facets.boundaries[patch->boundary].augmented);
}

/* Pressure on a patch, Pa. */
static PetscReal Pressure(const MpmContacts *contacts, const MpmPatch *patch, const MpmPatchAnswer *answer)
{
  const PetscReal now = answer->active ? -patch->stiffness * answer->gap : 0.;

  if (!HasMean(contacts, patch)) return now;
  if (contacts->facets.boundaries[patch->boundary].basal && !(patch->mean > 0.)) return now;
  return (1. - MPM_CONTACT_RECENT) * patch->mean + MPM_CONTACT_RECENT * now;
}

/* The highest place of contact with a boundary and the negative of the lowest one, of this rank, m. */
static PetscErrorCode FindEnds(const MpmContacts *contacts, PetscInt b, const MpmSum *sum,
                               const MpmPatchAnswer answers[], MpmParticles *particles, PetscReal ends[2])
{
  const PetscInt dim  = sum->space->dim;
  PetscReal      most = contacts->face[b].pressure, *mean;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < contacts->patch_count; k++) {
    const MpmPatch *patch = &contacts->patch[k];

    if (patch->boundary != b || !answers[k].active || HasMean(contacts, patch)) continue;
    for (PetscInt f = patch->begin; f < patch->end; f++) {
      const MpmFacet *facet = &contacts->facets.at[f];

      Extend(facet->place[dim - 1], facet->point >= 0 ? Half(sum->points, dim, facet->point) : 0., ends);
    }
  }
  if (contacts->facets.boundaries[b].augmented || !(most > 0.)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmParticlesGetField(particles, contacts->facets.boundaries[b].fields.pressure, &mean));
  for (PetscInt p = 0; p < sum->points->count; p++)
    if (mean[p] > LEAST * most) Extend(sum->points->x[p * dim + dim - 1], Half(sum->points, dim, p), ends);
  PetscCall(MpmParticlesRestoreField(particles, &mean));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmContactsFindFaces(MpmContacts *contacts, const MpmSum *sum, const MpmPatchAnswer answers[],
                                    MpmParticles *particles)
{
  const PetscMPIInt count = (PetscMPIInt)contacts->facets.boundary_count;
  PetscReal        *most, (*ends)[2];

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(count, &most));
  PetscCall(PetscMalloc1(count, &ends));
  for (PetscInt k = 0; k < contacts->patch_count; k++) {
    const PetscInt b = contacts->patch[k].boundary;

    if (contacts->facets.boundaries[b].fields.face)
      most[b] = PetscMax(most[b], Pressure(contacts, &contacts->patch[k], &answers[k]));
  }
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, most, count, MPIU_REAL, MPIU_MAX, sum->grid->comm));
  for (PetscInt b = 0; b < count; b++) {
    contacts->face[b].pressure = most[b];
    ends[b][0] = ends[b][1] = PETSC_NINFINITY;
    if (contacts->facets.boundaries[b].fields.face) PetscCall(FindEnds(contacts, b, sum, answers, particles, ends[b]));
  }
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, ends, 2 * count, MPIU_REAL, MPIU_MAX, sum->grid->comm));
  for (PetscInt b = 0; b < count; b++)
    contacts->face[b].high = ends[b][0] > PETSC_NINFINITY ? ends[b][0] + ends[b][1] : 0.;
  PetscCall(PetscFree(most));
  PetscCall(PetscFree(ends));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Values that the points beside boundaries keep from step to step: slips, gaps, pressures. Here they are written into
  the patches at a step's start.
*/
#include "particles/particles.h"
#include "assembly/terms.h"
#include "contact/contact.h"
#include "contact/rigid_body.h"

/* A number that a facet's point keeps. */
static PetscReal Kept(const MpmContacts *contacts, PetscInt f, const PetscReal field[], MpmPieceSlot slot)
{
  const MpmFacet *facet = &contacts->facet[f];

  return facet->piece ? contacts->piece[facet->piece - 1].kept[slot] : field[facet->point];
}

/*
  Kept numbers of the points, at the facets of a boundary. Where these are pieces of its surface, points that have come
  to it since take the mean of the others in their patch: those that kept a gap.
*/
static PetscErrorCode Load(const MpmContacts *contacts, PetscInt b, const char *field, MpmPieceSlot slot,
                           MpmParticles *particles, PetscReal value[])
{
  const MpmBoundary *boundary = &contacts->boundaries[b];
  PetscReal         *kept, *gap = NULL;

  PetscFunctionBeginUser;
  PetscCall(MpmParticlesGetField(particles, field, &kept));
  for (PetscInt f = 0; f < contacts->facet_count; f++)
    if (contacts->facet[f].boundary == b) value[f] = Kept(contacts, f, kept, slot);
  PetscCall(MpmParticlesRestoreField(particles, &kept));
  if (!contacts->drawn[b]) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmParticlesGetField(particles, boundary->gap_field, &gap));
  for (PetscInt k = 0; k < contacts->patch_count; k++) {
    const MpmPatch *patch = &contacts->patch[k];
    PetscReal       sum = 0., area = 0.;

    if (patch->boundary != b) continue;
    for (PetscInt f = patch->begin; f < patch->end; f++) {
      if (Kept(contacts, f, gap, MPM_PIECE_GAP) == 0.) continue;
      sum += contacts->facet[f].area * value[f];
      area += contacts->facet[f].area;
    }
    for (PetscInt f = patch->begin; area > 0. && f < patch->end; f++)
      if (Kept(contacts, f, gap, MPM_PIECE_GAP) == 0.) value[f] = sum / area;
  }
  PetscCall(MpmParticlesRestoreField(particles, &gap));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Slip at the step's start, put into the tangent plane there. */
static PetscErrorCode LoadSlips(MpmContacts *contacts, MpmParticles *particles, PetscInt dim)
{
  PetscReal *value;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(contacts->facet_count, &value));
  for (PetscInt b = 0; b < contacts->boundary_count; b++) {
    for (PetscInt a = 0; contacts->boundaries[b].tangential && a < dim; a++) {
      PetscCall(
        Load(contacts, b, contacts->boundaries[b].slip_field[a], (MpmPieceSlot)(MPM_PIECE_SLIP + a), particles, value));
      for (PetscInt k = 0; k < contacts->facet_count; k++)
        if (contacts->facet[k].boundary == b) contacts->facet[k].slip[a] = value[k];
    }
  }
  PetscCall(PetscFree(value));
  for (PetscInt k = 0; k < contacts->facet_count; k++) {
    MpmFacet           *facet = &contacts->facet[k];
    const MpmRigidBody *body  = MpmContactsBody(contacts, facet->boundary);
    PetscReal           dot   = 0.;

    if (body) MpmRigidPullVector(body, facet->slip);
    for (PetscInt a = 0; a < dim; a++) dot += facet->slip[a] * facet->normal[a];
    for (PetscInt a = 0; a < dim; a++) facet->slip[a] -= dot * facet->normal[a];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Pieces of the surface start with the gap that their points had in their last patch: their place does not show the
  distance of the material.
*/
static PetscErrorCode LoadGaps(MpmContacts *contacts, MpmParticles *particles)
{
  PetscReal *gap;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(contacts->facet_count, &gap));
  for (PetscInt b = 0; b < contacts->boundary_count; b++) {
    if (!contacts->drawn[b]) continue;
    PetscCall(Load(contacts, b, contacts->boundaries[b].gap_field, MPM_PIECE_GAP, particles, gap));
    for (PetscInt k = 0; k < contacts->facet_count; k++) {
      MpmFacet  *facet = &contacts->facet[k];
      MpmSurface surface;

      if (facet->boundary != b) continue;
      MpmBoundaryDistance(&contacts->boundaries[b], &contacts->before[b], facet->place, &surface);
      facet->touches = surface.distance - gap[k] - MpmPieceWayBack(contacts, facet);
    }
  }
  PetscCall(PetscFree(gap));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The pressures with which the step starts, of boundaries with method augmented: those of the patches' points. */
static PetscErrorCode LoadPressures(MpmContacts *contacts, MpmParticles *particles)
{
  PetscReal *pressure;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(contacts->facet_count, &pressure));
  for (PetscInt b = 0; b < contacts->boundary_count; b++) {
    if (!contacts->boundaries[b].augmented) continue;
    PetscCall(Load(contacts, b, contacts->boundaries[b].pressure_field, MPM_PIECE_PRESSURE, particles, pressure));
    for (PetscInt k = 0; k < contacts->patch_count; k++) {
      MpmPatch *patch = &contacts->patch[k];

      if (patch->boundary != b) continue;
      patch->shift = 0.;
      for (PetscInt f = patch->begin; f < patch->end; f++)
        patch->shift += contacts->facet[f].area / patch->area * pressure[f] / patch->stiffness;
    }
  }
  PetscCall(PetscFree(pressure));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Patches of which most has let go */
static PetscErrorCode LoadBroken(MpmContacts *contacts, MpmParticles *particles)
{
  PetscReal *broken;

  PetscFunctionBeginUser;
  for (PetscInt b = 0; b < contacts->boundary_count; b++) {
    if (!contacts->boundaries[b].broken_field) continue;
    PetscCall(MpmParticlesGetField(particles, contacts->boundaries[b].broken_field, &broken));
    for (PetscInt k = 0; k < contacts->patch_count; k++) {
      MpmPatch *patch = &contacts->patch[k];
      PetscReal area  = 0.;

      for (PetscInt f = patch->begin; patch->boundary == b && f < patch->end; f++) {
        const PetscInt p = contacts->facet[f].point;

        if (p >= 0 && broken[p] > 0.) area += contacts->facet[f].area;
      }
      patch->broken = (PetscBool)(area > 0.5 * patch->area);
    }
    PetscCall(MpmParticlesRestoreField(particles, &broken));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmContactsBreak(MpmContacts *contacts, const MpmPatchAnswer answers[], MpmParticles *particles)
{
  PetscReal *broken;

  PetscFunctionBeginUser;
  for (PetscInt b = 0; b < contacts->boundary_count; b++) {
    if (!contacts->boundaries[b].broken_field) continue;
    PetscCall(MpmParticlesGetField(particles, contacts->boundaries[b].broken_field, &broken));
    for (PetscInt k = 0; k < contacts->patch_count; k++) {
      const MpmPatch *patch = &contacts->patch[k];
      const PetscBool tears =
        (PetscBool)(patch->broken || patch->stiffness * answers[k].gap > contacts->boundaries[b].tension);

      for (PetscInt f = patch->begin; patch->boundary == b && tears && f < patch->end; f++) {
        const PetscInt p = contacts->facet[f].point;

        if (p >= 0) broken[p] = 1.;
      }
    }
    PetscCall(MpmParticlesRestoreField(particles, &broken));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmContactsLoad(MpmContacts *contacts, const MpmTermStep *step)
{
  PetscFunctionBeginUser;
  contacts->newton.give = 1.;
  if (!contacts->facet_count) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(LoadSlips(contacts, step->particles, contacts->boundaries[0].dim));
  PetscCall(LoadPressures(contacts, step->particles));
  PetscCall(LoadGaps(contacts, step->particles));
  PetscCall(LoadBroken(contacts, step->particles));
  PetscFunctionReturn(PETSC_SUCCESS);
}

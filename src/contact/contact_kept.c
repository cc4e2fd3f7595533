/*
  Values that the points beside boundaries keep from step to step: slips, gaps, pressures, and whether they have let go.
  A step's patches start with them, and leave them to their points.
*/
#include "point/layout.h"
#include "particles/particles.h"
#include "particles/points.h"
#include "space/rules.h"
#include "space/sum.h"
#include "assembly/terms.h"
#include "contact/contact.h"
#include "contact/rigid_body.h"

/* ---- from the points ---- */

/* A number that a facet's point keeps. */
static PetscReal Kept(const MpmContacts *contacts, PetscInt f, const PetscReal field[], MpmPieceSlot slot)
{
  const MpmFacet *facet = &contacts->facets.at[f];

  return facet->piece ? contacts->facets.pieces.at[facet->piece - 1].kept[slot] : field[facet->point];
}

/*
  Kept numbers of the points, at the facets of a boundary. Where these are pieces of its surface, points that have come
  to it since take the mean of the others in their patch: those that kept a gap.
*/
static PetscErrorCode Load(const MpmContacts *contacts, PetscInt b, const char *field, MpmPieceSlot slot,
                           MpmParticles *particles, PetscReal value[])
{
  const MpmBoundary *boundary = &contacts->facets.boundaries[b];
  PetscReal         *kept, *gap = NULL;

  PetscFunctionBeginUser;
  PetscCall(MpmParticlesGetField(particles, field, &kept));
  for (PetscInt f = 0; f < contacts->facets.count; f++)
    if (contacts->facets.at[f].boundary == b) value[f] = Kept(contacts, f, kept, slot);
  PetscCall(MpmParticlesRestoreField(particles, &kept));
  if (!contacts->facets.drawn[b]) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmParticlesGetField(particles, boundary->fields.gap, &gap));
  for (PetscInt k = 0; k < contacts->patch_count; k++) {
    const MpmPatch *patch = &contacts->patch[k];
    PetscReal       sum = 0., area = 0.;

    if (patch->boundary != b) continue;
    for (PetscInt f = patch->begin; f < patch->end; f++) {
      if (Kept(contacts, f, gap, MPM_PIECE_GAP) == 0.) continue;
      sum += contacts->facets.at[f].area * value[f];
      area += contacts->facets.at[f].area;
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
  PetscCall(PetscMalloc1(contacts->facets.count, &value));
  for (PetscInt b = 0; b < contacts->facets.boundary_count; b++) {
    for (PetscInt a = 0; contacts->facets.boundaries[b].tangential && a < dim; a++) {
      PetscCall(Load(contacts, b, contacts->facets.boundaries[b].fields.slip[a], (MpmPieceSlot)(MPM_PIECE_SLIP + a),
                     particles, value));
      for (PetscInt k = 0; k < contacts->facets.count; k++)
        if (contacts->facets.at[k].boundary == b) contacts->facets.at[k].slip[a] = value[k];
    }
  }
  PetscCall(PetscFree(value));
  for (PetscInt k = 0; k < contacts->facets.count; k++) {
    MpmFacet           *facet = &contacts->facets.at[k];
    const MpmRigidBody *body  = MpmFacetsBody(&contacts->facets, facet->boundary);
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
  PetscCall(PetscMalloc1(contacts->facets.count, &gap));
  for (PetscInt b = 0; b < contacts->facets.boundary_count; b++) {
    if (!contacts->facets.drawn[b]) continue;
    PetscCall(Load(contacts, b, contacts->facets.boundaries[b].fields.gap, MPM_PIECE_GAP, particles, gap));
    for (PetscInt k = 0; k < contacts->facets.count; k++) {
      MpmFacet  *facet = &contacts->facets.at[k];
      MpmSurface surface;

      if (facet->boundary != b) continue;
      MpmBoundaryDistance(&contacts->facets.boundaries[b], &contacts->facets.before[b], facet->place, &surface);
      facet->touches = surface.distance - gap[k] - MpmPieceWayBack(&contacts->facets, facet);
    }
  }
  PetscCall(PetscFree(gap));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  The pressures with which the step starts: those of the patches' points. Of boundaries with method augmented, and where
  friction is by a law of the bed their means over time.
*/
static PetscErrorCode LoadPressures(MpmContacts *contacts, MpmParticles *particles)
{
  PetscReal *pressure;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(contacts->facets.count, &pressure));
  for (PetscInt b = 0; b < contacts->facets.boundary_count; b++) {
    if (!contacts->facets.boundaries[b].fields.pressure) continue;
    PetscCall(
      Load(contacts, b, contacts->facets.boundaries[b].fields.pressure, MPM_PIECE_PRESSURE, particles, pressure));
    for (PetscInt k = 0; k < contacts->patch_count; k++) {
      MpmPatch *patch = &contacts->patch[k];

      if (patch->boundary != b) continue;
      patch->mean = patch->shift = 0.;
      for (PetscInt f = patch->begin; f < patch->end; f++)
        patch->mean += contacts->facets.at[f].area / patch->area * pressure[f];
      if (contacts->facets.boundaries[b].augmented) patch->shift = patch->mean / patch->stiffness;
    }
  }
  PetscCall(PetscFree(pressure));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Pressures of patches in a geostatic state, in which the material stands where it was drawn. After a step whose points
  went back the faces stand as the step has turned them.
*/
static PetscErrorCode LoadRest(MpmContacts *contacts, const MpmTermStep *step)
{
  PetscReal *rest;

  PetscFunctionBeginUser;
  for (PetscInt b = 0; b < contacts->facets.boundary_count; b++) {
    if (!contacts->facets.boundaries[b].fields.rest) continue;
    PetscCall(MpmParticlesGetField(step->particles, contacts->facets.boundaries[b].fields.rest, &rest));
    for (PetscInt k = 0; k < contacts->patch_count; k++) {
      MpmPatch *patch = &contacts->patch[k];

      if (patch->boundary != b) continue;
      patch->rest = 0.;
      for (PetscInt f = patch->begin; f < patch->end; f++) {
        const MpmFacet *facet = &contacts->facets.at[f];

        if (!facet->piece) patch->rest += facet->area / patch->area * rest[facet->point];
      }
      patch->shift = 0.;
      if (step->rules->put_back && patch->rest != 0.)
        patch->rest += patch->stiffness * MpmPatchStartGap(contacts, patch);
      patch->shift = patch->rest / patch->stiffness;
    }
    PetscCall(MpmParticlesRestoreField(step->particles, &rest));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Patches of which most has let go */
static PetscErrorCode LoadBroken(MpmContacts *contacts, MpmParticles *particles)
{
  PetscReal *broken;

  PetscFunctionBeginUser;
  for (PetscInt b = 0; b < contacts->facets.boundary_count; b++) {
    if (!contacts->facets.boundaries[b].fields.broken) continue;
    PetscCall(MpmParticlesGetField(particles, contacts->facets.boundaries[b].fields.broken, &broken));
    for (PetscInt k = 0; k < contacts->patch_count; k++) {
      MpmPatch *patch = &contacts->patch[k];
      PetscReal area  = 0.;

      for (PetscInt f = patch->begin; patch->boundary == b && f < patch->end; f++) {
        const PetscInt p = contacts->facets.at[f].point;

        if (p >= 0 && broken[p] > 0.) area += contacts->facets.at[f].area;
      }
      patch->broken = (PetscBool)(area > 0.5 * patch->area);
    }
    PetscCall(MpmParticlesRestoreField(particles, &broken));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmContactsLoad(MpmContacts *contacts, const MpmTermStep *step)
{
  PetscFunctionBeginUser;
  contacts->newton.give = 1.;
  if (!contacts->facets.count) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(LoadSlips(contacts, step->particles, contacts->facets.boundaries[0].dim));
  PetscCall(LoadPressures(contacts, step->particles));
  PetscCall(LoadGaps(contacts, step->particles));
  PetscCall(LoadRest(contacts, step));
  PetscCall(LoadBroken(contacts, step->particles));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- to the points ---- */

/* A facet's point keeps a number of its patch: where it belongs to several, the mean over them. */
static void Keep(const MpmFacet *facet, PetscReal value, PetscReal kept[])
{
  if (facet->point < 0) return;
  if (facet->piece || facet->key.round || facet->key.single) kept[facet->point] += facet->portion * value;
  else kept[facet->point] = value;
}

/* Portions by area of a boundary's round and single facets that touch, among those of the same point. */
static PetscErrorCode ShareParts(const MpmContacts *contacts, PetscInt b, const MpmSum *sum,
                                 const MpmPatchAnswer answers[])
{
  const MpmBoundary *boundary = &contacts->facets.boundaries[b];
  const PetscBool    keeps    = (PetscBool)(boundary->tangential || boundary->augmented || boundary->fields.rest);
  PetscBool          any      = PETSC_FALSE;
  PetscReal         *area;

  PetscFunctionBeginUser;
  for (PetscInt f = 0; keeps && f < contacts->facets.count && !any; f++)
    any = (PetscBool)(contacts->facets.at[f].boundary == b &&
                      (contacts->facets.at[f].key.round || contacts->facets.at[f].key.single));
  if (!any) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscCalloc1(sum->points->count, &area));
  for (PetscInt k = 0; k < 2 * contacts->patch_count; k++) {
    const PetscInt  at    = k % contacts->patch_count;
    const MpmPatch *patch = &contacts->patch[at];

    for (PetscInt f = patch->begin; patch->boundary == b && answers[at].active && f < patch->end; f++) {
      MpmFacet *facet = &contacts->facets.at[f];

      if (!facet->key.round && !facet->key.single) continue;
      if (k < contacts->patch_count) area[facet->point] += facet->area;
      else facet->portion = facet->area / area[facet->point];
    }
  }
  PetscCall(PetscFree(area));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A number of a patch and its answer, which the point of a facet keeps; false: it keeps none. */
typedef PetscBool (*PatchNumber)(const MpmContacts *contacts, const MpmPatch *patch, const MpmPatchAnswer *answer,
                                 const MpmFacet *facet, PetscInt axis, PetscReal *value);

/* Slip while it touches: a corner may not touch as its faces do. */
static PetscBool SlipOf(const MpmContacts *contacts, const MpmPatch *patch, const MpmPatchAnswer *answer,
                        const MpmFacet *facet, PetscInt axis, PetscReal *value)
{
  (void)facet;
  *value = answer->slip[axis] / (patch->slips > 0. ? patch->slips : 1.);
  return (PetscBool)(answer->active && !MpmPatchFlows(contacts, patch));
}

/* Explicit steps correct no pressure: summed up over steps, depths would excite the contact. */
static PetscBool PressureOf(const MpmContacts *contacts, const MpmPatch *patch, const MpmPatchAnswer *answer,
                            const MpmFacet *facet, PetscInt axis, PetscReal *value)
{
  const PetscReal kept = answer->active ? patch->mean : 0.;

  (void)contacts;
  (void)facet;
  (void)axis;
  *value = patch->direct ? kept : -patch->stiffness * answer->gap;
  return PETSC_TRUE;
}

/* Gap of a bilateral boundary. */
static PetscBool GapOf(const MpmContacts *contacts, const MpmPatch *patch, const MpmPatchAnswer *answer,
                       const MpmFacet *facet, PetscInt axis, PetscReal *value)
{
  (void)contacts;
  (void)facet;
  (void)axis;
  *value = answer->gap + patch->shift;
  return PETSC_TRUE;
}

/* Pressure of a geostatic state: of faces, not of pieces of a surface. */
static PetscBool RestOf(const MpmContacts *contacts, const MpmPatch *patch, const MpmPatchAnswer *answer,
                        const MpmFacet *facet, PetscInt axis, PetscReal *value)
{
  (void)answer;
  (void)axis;
  *value = patch->rest;
  return (PetscBool)(!facet->piece && !MpmPatchFlows(contacts, patch));
}

/* A source of numbers for the points. */
typedef struct {
  const MpmContacts    *contacts;
  const MpmPatchAnswer *answers; /* of every patch; NULL with RestOf(): unused */
  PetscInt              points;
  MpmParticles         *particles;
} Source;

/* The points of boundary b keep a number of their patches in a field. */
static PetscErrorCode KeepNumber(const Source *source, PetscInt b, const char *field, PatchNumber number, PetscInt axis)
{
  const MpmContacts *contacts = source->contacts;
  PetscReal         *kept;

  PetscFunctionBeginUser;
  PetscCall(MpmParticlesGetField(source->particles, field, &kept));
  PetscCall(MpmPointsClear(source->points, kept));
  for (PetscInt k = 0; k < contacts->patch_count; k++) {
    const MpmPatch       *patch  = &contacts->patch[k];
    const MpmPatchAnswer *answer = source->answers ? &source->answers[k] : NULL;

    for (PetscInt f = patch->begin; patch->boundary == b && f < patch->end; f++) {
      PetscReal value;

      if (number(contacts, patch, answer, &contacts->facets.at[f], axis, &value))
        Keep(&contacts->facets.at[f], value, kept);
    }
  }
  PetscCall(MpmParticlesRestoreField(source->particles, &kept));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Slips, pressures and gaps. */
static PetscErrorCode KeepNumbers(const Source *source, PetscInt dim)
{
  PetscFunctionBeginUser;
  for (PetscInt b = 0; b < source->contacts->facets.boundary_count; b++) {
    const MpmBoundary *boundary = &source->contacts->facets.boundaries[b];

    for (PetscInt a = 0; boundary->tangential && a < dim; a++)
      PetscCall(KeepNumber(source, b, boundary->fields.slip[a], SlipOf, a));
    if (boundary->augmented) PetscCall(KeepNumber(source, b, boundary->fields.pressure, PressureOf, 0));
    if (boundary->bilateral) PetscCall(KeepNumber(source, b, boundary->fields.gap, GapOf, 0));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode KeepRest(const Source *source)
{
  PetscFunctionBeginUser;
  for (PetscInt b = 0; b < source->contacts->facets.boundary_count; b++) {
    const char *field = source->contacts->facets.boundaries[b].fields.rest;

    if (field) PetscCall(KeepNumber(source, b, field, RestOf, 0));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Means of the pressure over time, of friction by a law of the bed and of faces (contact_face.c): contact that comes and
  goes from step to step has its pressure in some of them only.
*/
static PetscErrorCode KeepMeans(const MpmContacts *contacts, const MpmSum *sum, const MpmPatchAnswer answers[],
                                MpmParticles *particles)
{
  PetscFunctionBeginUser;
  for (PetscInt b = 0; b < contacts->facets.boundary_count; b++) {
    const MpmBoundary *boundary = &contacts->facets.boundaries[b];
    const PetscReal    first    = boundary->basal ? 1. : MPM_CONTACT_RECENT;
    PetscReal         *pressure;

    if ((!boundary->basal && !boundary->fields.face) || boundary->augmented) continue;
    PetscCall(MpmParticlesGetField(particles, contacts->facets.boundaries[b].fields.pressure, &pressure));
    for (PetscInt p = 0; p < sum->points->count; p++) pressure[p] *= 1. - MPM_CONTACT_RECENT;
    for (PetscInt k = 0; k < contacts->patch_count; k++) {
      const MpmPatch *patch = &contacts->patch[k];
      const PetscReal value = -patch->stiffness * answers[k].gap;

      for (PetscInt f = patch->begin;
           patch->boundary == b && MpmPatchFlows(contacts, patch) && answers[k].active && f < patch->end; f++) {
        PetscReal *mean = &pressure[contacts->facets.at[f].point];

        *mean += (*mean > 0. ? MPM_CONTACT_RECENT : first) * value;
      }
    }
    PetscCall(MpmParticlesRestoreField(particles, &pressure));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Points of bilateral boundaries with a tension let go for good where a patch is pulled by more. */
static PetscErrorCode Break(const MpmContacts *contacts, const MpmPatchAnswer answers[], MpmParticles *particles)
{
  PetscReal *broken;

  PetscFunctionBeginUser;
  for (PetscInt b = 0; b < contacts->facets.boundary_count; b++) {
    if (!contacts->facets.boundaries[b].fields.broken) continue;
    PetscCall(MpmParticlesGetField(particles, contacts->facets.boundaries[b].fields.broken, &broken));
    for (PetscInt k = 0; k < contacts->patch_count; k++) {
      const MpmPatch *patch = &contacts->patch[k];
      const PetscBool tears =
        (PetscBool)(patch->broken || patch->stiffness * answers[k].gap > contacts->facets.boundaries[b].bounds.tension);

      for (PetscInt f = patch->begin; patch->boundary == b && tears && f < patch->end; f++) {
        const PetscInt p = contacts->facets.at[f].point;

        if (p >= 0) broken[p] = 1.;
      }
    }
    PetscCall(MpmParticlesRestoreField(particles, &broken));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmContactsPutBack(const void *ctx, PetscInt points, MpmParticles *particles)
{
  const Source source = {(const MpmContacts *)ctx, NULL, points, particles};

  PetscFunctionBeginUser;
  PetscCall(KeepRest(&source));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmContactsBalance(void *ctx, const MpmSum *sum, const PetscReal u[], MpmParticles *particles)
{
  MpmContacts    *contacts = (MpmContacts *)ctx;
  const Source    source   = {contacts, NULL, sum->points->count, particles};
  MpmPatchAnswer *answers;
  MpmPatchWork    work;

  PetscFunctionBeginUser;
  PetscCall(MpmPatchWorkCreate(contacts, &work));
  PetscCall(PetscMalloc1(contacts->patch_count, &answers));
  for (PetscInt k = 0; k < contacts->patch_count; k++) {
    MpmPatch *patch = &contacts->patch[k];

    answers[k] = (MpmPatchAnswer){.active = PETSC_FALSE};
    if (u) MpmPatchFrame(contacts, patch)->evaluate(contacts, patch, sum, u, &work, &answers[k]);
    patch->rest = -patch->stiffness * answers[k].gap;
  }
  for (PetscInt b = 0; b < contacts->facets.boundary_count; b++) PetscCall(ShareParts(contacts, b, sum, answers));
  PetscCall(KeepRest(&source));
  PetscCall(PetscFree(answers));
  PetscCall(MpmPatchWorkDestroy(&work));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmContactsKeep(const MpmContacts *contacts, const MpmSum *sum, const MpmPatchAnswer answers[],
                               MpmParticles *particles)
{
  const Source source = {contacts, answers, sum->points->count, particles};

  PetscFunctionBeginUser;
  if (!contacts->newton.near && contacts->newton.bare && !contacts->face) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt b = 0; b < contacts->facets.boundary_count; b++) PetscCall(ShareParts(contacts, b, sum, answers));
  PetscCall(KeepNumbers(&source, sum->layout->dim));
  PetscCall(KeepMeans(contacts, sum, answers, particles));
  PetscCall(KeepRest(&source));
  PetscCall(Break(contacts, answers, particles));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Values that the first bodies' points keep of their contacts from step to step: the gap at which a patch touches, its
  slip, and its pressure. A step's patches start with their means, and leave them to the points.
*/
#include "point/layout.h"
#include "point/material.h"
#include "particles/particles.h"
#include "space/rules.h"
#include "space/sum.h"
#include "assembly/terms.h"
#include "pairs/body_facets.h"

#define ALIGNED 1e-6 /* off an axis: the surface is no cut through a lattice */
#define UNKNOWN 1e30 /* m: a gap; so large that means with others are so, too */
#define PASSES  100. /* where water passes: conductance over that of a cell, by the less permeable body */
#define CLOSED  1e-3 /* of a cell: bodies that are no farther apart touch, for water */

/* The mean of a field over the first body's facets of each patch of a pair. */
static PetscErrorCode LoadField(const MpmPairContacts *contacts, PetscInt pair, const char *name, PetscInt dim,
                                MpmParticles *particles, PetscReal mean[])
{
  PetscReal *value;

  PetscFunctionBeginUser;
  PetscCall(MpmParticlesGetField(particles, name, &value));
  for (PetscInt k = 0; k < contacts->patch_count; k++) {
    const MpmPairPatch *patch = &contacts->patch[k];

    if (patch->pair != pair) continue;
    mean[k] = 0.;
    for (PetscInt f = patch->side[0].begin; f < patch->side[0].end; f++) {
      const MpmPairFacet *facet = &contacts->facets.at[contacts->facets.list[f]];
      PetscReal           area  = 0.;

      for (PetscInt a = 0; a < dim; a++) area += patch->normal[a] * facet->area[a];
      mean[k] += PetscAbsReal(area) / patch->side[0].area * value[facet->point];
    }
  }
  PetscCall(MpmParticlesRestoreField(particles, &value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Gap at which a patch touches when the run starts: that of an overlap, or of rounding; and, where an unknown surface
  cut the lattice, any one that is less than a facet's size.
*/
static PetscReal TouchesAtStart(PetscInt dim, const MpmPairContacts *contacts, const MpmPairPatch *patch)
{
  const PetscReal size = contacts->facets.at[contacts->facets.list[patch->side[0].begin]].size;
  PetscReal       within;
  PetscBool       cut = PETSC_TRUE;

  if (contacts->pairs->at[patch->pair]
        .barrier) /* needs a gap: half of its reach, where it bears, or all, where its energy would be set free */
    return PetscMin(patch->gap - (contacts->dynamic ? 1. : 0.5) * MPM_BARRIER * contacts->cell, 0.);
  for (PetscInt a = 0; a < dim; a++)
    if (PetscAbsReal(patch->normal[a]) > 1. - ALIGNED) cut = PETSC_FALSE;
  MPM_PAIR_SIDES(patch, f, s) if (contacts->facets.at[contacts->facets.list[f]].placed) cut = PETSC_FALSE;
  within = cut ? size : MPM_TOLERANCE * contacts->cell;
  return patch->gap < within ? patch->gap : 0.;
}

/* True where the body of a barrier, behind which there is always a gap, has joined without one. */
static PetscBool Joins(const MpmPair *pair, PetscReal cell, const MpmPairPatch *patch)
{
  return (PetscBool)(pair->barrier && patch->gap - patch->touches < MPM_TOLERANCE * cell);
}

/* Conductance for water as the step starts, of the pair's open contacts. */
static void OpenPatch(const MpmPairContacts *contacts, const MpmSum *sum, MpmPairPatch *patch)
{
  const MpmPair  *pair     = &contacts->pairs->at[patch->pair];
  const PetscReal reach    = pair->barrier ? MPM_BARRIER : CLOSED;
  PetscReal       mobility = PETSC_INFINITY;

  patch->through = 0.;
  if (!pair->open || patch->gap - patch->touches > reach * contacts->cell) return;
  MPM_PAIR_SIDES(patch, f, s)
  {
    const MpmMaterial       *material = &sum->materials[contacts->facets.at[contacts->facets.list[f]].material.index];
    const MpmPhysicsMaterial of       = MpmMaterialForPhysics(material, NULL, sum->layout->dim);

    /* over a length of zero: conductance of a step of a second */
    mobility =
      PetscMin(mobility, PetscAbsReal(sum->layout->ghost(&of, material->physics_parameter, 1., 1e-9 * contacts->cell)));
  }
  patch->through = PASSES * mobility / contacts->cell;
}

PetscErrorCode MpmPairPatchesPrepare(void *ctx, const MpmTermStep *step)
{
  MpmPairContacts *contacts = (MpmPairContacts *)ctx;
  const PetscInt   dim      = step->sum->layout->dim;
  PetscReal       *mean;

  PetscFunctionBeginUser;
  contacts->newton.give = 1.;
  if (!contacts->patch_count) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(contacts->patch_count, &mean));
  for (PetscInt p = 0; p < contacts->pairs->count; p++) {
    const MpmPair *pair = &contacts->pairs->at[p];

    PetscCall(LoadField(contacts, p, pair->gap_field, dim, step->particles, mean));
    for (PetscInt k = 0; k < contacts->patch_count; k++) {
      MpmPairPatch *patch = &contacts->patch[k];

      if (patch->pair != p) continue;
      patch->touches = mean[k];
      if (step->rules->put_back) patch->touches = mean[k] < 0.5 * UNKNOWN ? patch->gap - mean[k] : 0.;
      if (contacts->starts || Joins(pair, contacts->cell, patch)) patch->touches = TouchesAtStart(dim, contacts, patch);
    }
    if (pair->rest_field) PetscCall(LoadField(contacts, p, pair->rest_field, dim, step->particles, mean));
    for (PetscInt k = 0; pair->rest_field && k < contacts->patch_count; k++)
      if (contacts->patch[k].pair == p) contacts->patch[k].rest = mean[k];
    if (pair->augmented) PetscCall(LoadField(contacts, p, pair->pressure_field, dim, step->particles, mean));
    for (PetscInt k = 0; pair->augmented && k < contacts->patch_count; k++)
      if (contacts->patch[k].pair == p) contacts->patch[k].shift = mean[k] / contacts->patch[k].stiffness;
    for (PetscInt a = 0; pair->tangential && a < dim; a++) {
      PetscCall(LoadField(contacts, p, pair->slip_field[a], dim, step->particles, mean));
      for (PetscInt k = 0; k < contacts->patch_count; k++)
        if (contacts->patch[k].pair == p) contacts->patch[k].slip[a] = mean[k];
    }
  }
  PetscCall(PetscFree(mean));
  for (PetscInt k = 0; k < contacts->patch_count; k++) {
    MpmPairPatch *patch = &contacts->patch[k];
    PetscReal     dot   = 0.;

    OpenPatch(contacts, step->sum, patch);
    for (PetscInt a = 0; a < dim; a++) dot += patch->slip[a] * patch->normal[a];
    for (PetscInt a = 0; a < dim; a++) patch->slip[a] -= dot * patch->normal[a];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPairPatchesKeep(const MpmPairContacts *contacts, PetscReal (*slip)[MPM_MAX_DIM],
                                  MpmParticles          *particles)
{
  PetscInt points;

  PetscFunctionBeginUser;
  PetscCall(DMSwarmGetLocalSize(particles->swarm, &points));
  for (PetscInt p = 0; p < contacts->pairs->count; p++) {
    const MpmPair *pair = &contacts->pairs->at[p];

    for (PetscInt a = 0; a < MPM_MAX_DIM + 3; a++) { /* the slip, the gap, the pressures */
      const char *const names[] = {pair->slip_field[0], pair->slip_field[1],  pair->slip_field[2],
                                   pair->gap_field,     pair->pressure_field, pair->rest_field};
      const char *const name    = names[a];
      PetscReal        *value;

      if (!name) continue;
      PetscCall(MpmParticlesGetField(particles, name, &value));
      if (a != MPM_MAX_DIM) PetscCall(MpmPointsClear(points, value));
      for (PetscInt k = 0; k < contacts->patch_count; k++) {
        const MpmPairPatch *patch = &contacts->patch[k];
        const PetscReal kept[] = {slip[k][0], slip[k][1], slip[k][2], patch->touches, patch->shift * patch->stiffness,
                                  patch->rest};

        for (PetscInt f = patch->side[0].begin; patch->pair == p && f < patch->side[0].end; f++)
          value[contacts->facets.at[contacts->facets.list[f]].point] = kept[a];
      }
      PetscCall(MpmParticlesRestoreField(particles, &value));
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The points of a patch keep its own number, others `none`. */
static PetscErrorCode KeepEach(const MpmPairContacts *contacts, PetscInt pair, const char *name, PetscReal none,
                               PetscReal (*number)(const MpmPairPatch *patch), PetscInt points, MpmParticles *particles)
{
  PetscReal *value;

  PetscFunctionBeginUser;
  PetscCall(MpmParticlesGetField(particles, name, &value));
  for (PetscInt k = 0; k < points; k++) value[k] = none;
  for (PetscInt k = 0; k < contacts->patch_count; k++) {
    const MpmPairPatch *patch = &contacts->patch[k];

    for (PetscInt f = patch->side[0].begin; patch->pair == pair && f < patch->side[0].end; f++)
      value[contacts->facets.at[contacts->facets.list[f]].point] = number(patch);
  }
  PetscCall(MpmParticlesRestoreField(particles, &value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscReal EndGap(const MpmPairPatch *patch)
{
  return patch->gap - patch->touches - patch->closed;
}

static PetscReal EndPressure(const MpmPairPatch *patch)
{
  return patch->rest;
}

PetscErrorCode MpmPairsPutBack(const void *ctx, PetscInt points, MpmParticles *particles)
{
  const MpmPairContacts *contacts = (const MpmPairContacts *)ctx;

  PetscFunctionBeginUser;
  for (PetscInt p = 0; p < contacts->pairs->count; p++) {
    const MpmPair *pair = &contacts->pairs->at[p];

    PetscCall(KeepEach(contacts, p, pair->gap_field, UNKNOWN, EndGap, points, particles));
    if (pair->rest_field) PetscCall(KeepEach(contacts, p, pair->rest_field, 0., EndPressure, points, particles));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

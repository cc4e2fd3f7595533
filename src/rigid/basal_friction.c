/*
  Friction of a boundary by a law of the bed, in explicit steps: laws of depth-averaged flow, with the pressure of the
  contact, the depth of a layer that weighs as much, and the speed along the surface:

    k (s* - s) = tau(h, p, s/dt) ,   h = p/(rho g n_z) ,

  s* the way along the surface in the step without friction, s the one that remains, k the stiffness by which a traction
  shortens it; s = 0 where tau(0) >= k s*.
*/
#include "options/options.h"
#include "talus/point/basal.h"
#include "point/basal_map.h"
#include "point/material.h"
#include "point/resisted_speed.h"
#include "rigid/basal_friction.h"
#include "rigid/rigid.h"

#define UPRIGHT 0.1 /* least cosine for the depth */

PetscErrorCode MpmBasalFrictionRead(const MpmOptions *options, const MpmOptions *block, MpmBoundary *boundary)
{
  char      *name, prefix[256];
  MpmOptions of = {options->comm, prefix, options->record};
  PetscBool  friction, adhesion;

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsText(block, "basal",
                           "in place of friction, in explicit steps: material whose block has a law of the bed "
                           "(docs/terrain.md)",
                           NULL, MPM_OPTIONAL, &name));
  if (!name || MpmOptionsHelp()) PetscFunctionReturn(PetscFree(name));
  PetscCall(MpmOptionsHas(block, "friction", &friction));
  PetscCall(MpmOptionsHas(block, "adhesion", &adhesion));
  MpmCheckInput(!friction && !adhesion, "-%sbasal %s: not with friction or adhesion, which it replaces", block->prefix,
                name);
  PetscCall(PetscNew(&boundary->basal));
  PetscCall(MpmMaterialCreateColumn(options, name, NULL, boundary->basal));
  PetscCall(PetscSNPrintf(prefix, sizeof(prefix), "mpm_material_%s_", name));
  for (size_t k = MPM_BASAL_OWN; k < boundary->basal->info.parameter_count; k++) {
    MpmMap    map = {0};
    PetscBool is;

    PetscCall(MpmBasalMapRead(&of, &boundary->basal->info.parameters[k], &map, &is));
    MpmCheckInput(!is, "-%s%s: must be a number where the law is that of a boundary", prefix,
                  boundary->basal->info.parameters[k].name);
  }
  PetscCall(PetscFree(name));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmBasalFrictionDestroy(MpmBoundary *boundary)
{
  PetscFunctionBeginUser;
  if (boundary->basal) PetscCall(MpmMaterialDestroy(boundary->basal));
  PetscCall(PetscFree(boundary->basal));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A law, and where its layer stands. */
typedef struct {
  const MpmMaterial *material;
  MpmBasalPoint      point;
} Layer;

static PetscReal Resistance(const void *of, PetscReal speed)
{
  const Layer  *layer = (const Layer *)of;
  MpmBasalPoint point = layer->point;

  point.speed = speed;
  return layer->material->basal->resistance(layer->material->parameter, &point);
}

PetscReal MpmBasalFriction(const MpmBoundary *boundary, PetscReal pressure, PetscReal upright, PetscReal size,
                           PetscReal stiffness, PetscReal dt)
{
  const double   *parameter = boundary->basal->parameter;
  const PetscReal weight    = parameter[MPM_BASAL_DENSITY] * parameter[MPM_BASAL_GRAVITY];
  const Layer     layer     = {boundary->basal,
                               {.pressure = pressure, .depth = pressure / (weight * PetscMax(upright, UPRIGHT))}};
  PetscReal       speed;

  if (!(pressure > 0.) || !(dt > 0.)) return 0.;
  speed = MpmResistedSpeed(stiffness * dt, 1., size / dt, Resistance, &layer);
  return speed > 0. ? Resistance(&layer, speed) : stiffness * size;
}

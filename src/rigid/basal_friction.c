/*
  Friction of a boundary by a law of the bed, in explicit steps: laws of depth-averaged flow, with the pressure of the
  contact, the depth of a layer that weighs as much, and the speed along the surface:

    k (s* - s) = tau(h, p, s/dt) ,   h = p/(rho g n_z) ,

  s* the way along the surface in the step without friction, s the one that remains, k the stiffness by which a traction
  shortens it. The left side falls with s, and tau does not: a bisection finds the root, s = 0 where tau(0) >= k s*.
*/
#include "options/options.h"
#include "talus/point/basal.h"
#include "point/basal_map.h"
#include "point/material.h"
#include "rigid/basal_friction.h"
#include "rigid/rigid.h"

#define HALVINGS 40
#define UPRIGHT  0.1 /* least cosine for the depth */

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

PetscReal MpmBasalFriction(const MpmBoundary *boundary, PetscReal pressure, PetscReal upright, PetscReal size,
                           PetscReal stiffness, PetscReal dt)
{
  const double      *parameter = boundary->basal->parameter;
  const MpmBasalLaw *law       = boundary->basal->basal;
  const PetscReal    weight    = parameter[MPM_BASAL_DENSITY] * parameter[MPM_BASAL_GRAVITY];
  MpmBasalPoint      point     = {.pressure = pressure, .depth = pressure / (weight * PetscMax(upright, UPRIGHT))};
  PetscReal          lower = 0., upper = size;

  if (!(pressure > 0.) || !(dt > 0.)) return 0.;
  if (law->resistance(parameter, &point) >= stiffness * size) return stiffness * size;
  for (PetscInt k = 0; k < HALVINGS; k++) {
    const PetscReal middle = 0.5 * (lower + upper);

    point.speed = middle / dt;
    if (law->resistance(parameter, &point) < stiffness * (size - middle)) lower = middle;
    else upper = middle;
  }
  point.speed = lower / dt;
  return law->resistance(parameter, &point);
}

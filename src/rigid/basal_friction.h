#pragma once
/*
  Friction of a boundary by a law of the bed (basal/).
*/
#include "options/options.h"
#include "base/base.h"
#include "base/types.h"

typedef struct MpmBoundary MpmBoundary;

/*
  Reads -<prefix>basal, the name of a material whose block -mpm_material_NAME has a law of the bed. Fails where the
  boundary has a friction as well, and for parameters by maps.
*/
PetscErrorCode MpmBasalFrictionRead(const MpmOptions *options, const MpmOptions *block, MpmBoundary *boundary);
PetscErrorCode MpmBasalFrictionDestroy(MpmBoundary *boundary);
/*
  Resistance, Pa, of a boundary that has such a law: under a pressure, Pa, along a way of `size` m without friction in
  the time dt, where a traction of `stiffness` times a way shortens this one by as much. Implicit: at the speed that
  remains. `upright`: cosine between the surface's normal and the vertical, for the depth.
*/
PetscReal MpmBasalFriction(const MpmBoundary *boundary, PetscReal pressure, PetscReal upright, PetscReal size,
                           PetscReal stiffness, PetscReal dt);

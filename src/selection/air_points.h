#pragma once
/*
  Points of air, which loads, surfaces, contacts and tracks leave out.
*/
#include "particles/points.h"
#include "point/air.h"

static inline PetscBool MpmPointIsAir(const MpmMaterial *materials, const MpmPoints *points, PetscInt p)
{
  return MpmMaterialIsAir(&materials[points->material[p]]);
}

#pragma once
/*
  Masses and parameters of points, for loops over them.
*/
#include "point/material.h"
#include "point/variation.h"
#include "particles/points.h"

/* A point's own parameters, of its law and physics; NULL: those of its material, which is uniform. */
static inline const double *MpmPointOwn(const MpmPoints *points, const MpmMaterial *material, PetscInt p)
{
  return material->varies ? &points->parameter[p * material->varies->stride] : NULL;
}
/* A point's mass at the start, kg, which gravity's load takes. */
static inline PetscReal MpmPointMass(const MpmPoints *points, const MpmMaterial *materials, PetscInt p)
{
  const MpmMaterial *material = &materials[points->material[p]];

  if (points->mass) return points->mass[p];
  return points->volume0[p] *
         (material->varies ? MpmMaterialDensity(material, MpmPointOwn(points, material, p)) : material->density);
}

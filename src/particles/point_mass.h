#pragma once
/*
  Masses of points, for loops over them.
*/
#include "point/material.h"
#include "particles/points.h"

/* A point's mass at the start, kg, which gravity's load takes. */
static inline PetscReal MpmPointMass(const MpmPoints *points, const MpmMaterial *materials, PetscInt p)
{
  return points->mass ? points->mass[p] : points->volume0[p] * materials[points->material[p]].density;
}

#pragma once
/*
  Means over a cell by polynomials (mean_modes.c).
*/
#include "space/space.h"

/* Polynomials of degree 3 in space. */
#define MPM_MAX_MODES 20

/*
  MpmModesMake - shares of the points in the volume of their cells, and orthonormal polynomials at the points

  With elements of order p the means are polynomials of degree p - 1; of order 1 one number a cell, and no values are
  kept.
*/
PetscErrorCode MpmModesMake(const MpmGrid *grid, const MpmPoints *points, MpmSpace *space);

/* sums[i] += value phi_i at a point: the sums over the points of a cell */
static inline void MpmModesAdd(const MpmCells *cells, PetscInt point, PetscReal value, PetscReal sums[])
{
  if (cells->modes == 1) sums[0] += value;
  else
    for (PetscInt i = 0; i < cells->modes; i++) sums[i] += value * cells->mode[point * cells->modes + i];
}
/* sum_i sums[i] phi_i at a point */
static inline PetscReal MpmModesAt(const MpmCells *cells, PetscInt point, const PetscReal sums[])
{
  PetscReal value = 0.;

  if (cells->modes == 1) return sums[0];
  for (PetscInt i = 0; i < cells->modes; i++) value += sums[i] * cells->mode[point * cells->modes + i];
  return value;
}
static inline PetscReal MpmModeValue(const MpmCells *cells, PetscInt point, PetscInt i)
{
  return cells->modes == 1 ? 1. : cells->mode[point * cells->modes + i];
}

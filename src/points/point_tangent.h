#pragma once
/*
  The tangent of one point, for the sums of tangent.c and tangent_diagonal.c, into whose loops it is inlined.
*/
#include "space/kernel_point.h"
#include "space/unit.h"
#include "assembly/sparsity.h"
#include "points/coupling.h"
#include "points/point_term.h"

/* A point as the sums over a group take it; where there is a mean the passes over its cell have made it. */
typedef struct {
  PetscReal        flux_here[MPM_MAX_INPUTS], tangent_here[MPM_MAX_INPUTS * MPM_MAX_INPUTS];
  const PetscReal *flux, *tangent;
  MpmBasis         basis;
} Point;

/* PETSC_FALSE where it has no answer. */
MPM_INLINE PetscBool PointTangent(const MpmKnown known, const MpmSum *sum, PetscInt s, const MpmWorkspace *work,
                                  const MpmCoupling *coupling, Point *at)
{
  const PetscInt  p       = sum->space->order[s];
  const PetscBool weights = work->weights;
  MpmKernelPoint  point;
  PetscReal       input[MPM_MAX_INPUTS];

  if (sum->layout->means && coupling->spread) {
    const MpmSpreadWork *spread = coupling->spread;

    MpmSumBasis(known, sum->space, p, weights, &work->basis);
    at->flux    = &spread->flux[s * (known.inputs + 1)];
    at->tangent = &spread->tangent[s * MpmTangentSize(sum->layout)];
    at->basis   = work->basis;
    return PETSC_TRUE;
  }
  if (sum->layout->means) {
    const MpmCellPoint *made = &coupling->cell.point[s - coupling->cell.begin];

    at->flux    = made->flux;
    at->tangent = made->tangent.by_input;
    at->basis   = made->basis;
    return PETSC_TRUE;
  }
  MpmSumFetch(known, sum, s);
  MpmSumBasis(known, sum->space, p, weights, &work->basis);
  MpmSumInputs(known, sum->layout, work->values, &work->basis, input);
  MpmSumPoint(sum, p, &point);
  at->flux    = at->flux_here;
  at->tangent = at->tangent_here;
  at->basis   = work->basis;
  return (PetscBool)!sum->layout->kernel->tangent(&point, input, at->flux_here, at->tangent_here);
}

/* Destinations of the sums over a group's points; `residual` may be NULL. */
typedef struct {
  PetscReal  *element, *residual;
  PetscReal  *rows;   /* room for MpmSumAddBlock() */
  PetscReal  *blocks; /* the diagonal blocks of all nodes, in place of elements */
  MpmCoupling coupling;
} Target;

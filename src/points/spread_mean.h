#pragma once
/*
  Means over cells by shares of the points' domains (spread_mean.c): the passes over all points that make fluxes and
  tangents, and the Jacobian from them.
*/
#include "points/cell_mean.h"
#include "space/point_loop.h"
#include "space/rules.h"

/* Boxes of nodes, and shares of the points (spread_shares.c). */
PetscErrorCode MpmSpreadBoxes(const MpmRules *rules, const MpmPoints *points, MpmSpace *space);

/* The cells that a point's domain lies in: their lower nodes, and shares in them. */
#define MPM_SPREAD_MOST 729 /* nine an axis: twice MPM_SPRAY_HALF_LENGTH */
typedef struct {
  PetscInt  count, node[MPM_SPREAD_MOST];
  PetscInt  at[MPM_SPREAD_MOST]; /* place of that node in the group's box */
  PetscReal share[MPM_SPREAD_MOST];
} MpmSpreadCells;
void MpmSpreadFindCells(const MpmSpace *space, const MpmGroup *group, PetscInt p, MpmSpreadCells *cells);
static inline PetscReal MpmSpreadMean(const MpmSpreadCells *cells, const PetscReal values[])
{
  PetscReal mean = 0.;

  for (PetscInt k = 0; k < cells->count; k++) mean += cells->share[k] * values[cells->node[k]];
  return mean;
}
static inline void MpmSpreadAdd(const MpmSpreadCells *cells, PetscReal value, PetscReal sums[])
{
  for (PetscInt k = 0; k < cells->count; k++) sums[cells->node[k]] += cells->share[k] * value;
}

/*
  An evaluation of all points, and its derivatives unless `tangent` is NULL; numbers of points by their places in the
  points' order, those of cells at their lower nodes.
*/
typedef struct {
  const MpmSum *sum;
  PetscReal    *input, *flux; /* of the kernel, those of the mean last */
  PetscReal    *dm;           /* of the point's own m by the other inputs */
  PetscReal    *back;         /* of each point: what the flux of the means is times dm in its own fluxes */
  PetscReal    *tangent;      /* MpmTangent, with dm as above */
  PetscReal    *ddm;          /* second derivatives of m of one point at a time */
  PetscReal    *volume, *mean, *mean_flux;
  MpmWorkspace  work;
} MpmSpreadWork;
PetscErrorCode MpmSpreadWorkCreate(const MpmSum *sum, PetscBool derivatives, MpmSpreadWork *work);
PetscErrorCode MpmSpreadWorkDestroy(MpmSpreadWork *work);
/* Fluxes at u, with the means' contribution, and tangents; the step's end into `trial` unless NULL. Collective. */
PetscErrorCode MpmSpreadEvaluate(MpmSpreadWork *work, const PetscReal u[], const MpmTrial *trial, PetscInt *failed);
/* Fluxes to nodal forces. */
PetscErrorCode MpmSpreadScatter(MpmSpreadWork *work, PetscReal force[]);
/* Sums over ranks of numbers of cells. */
PetscErrorCode MpmSpreadSum(const MpmSpace *space, PetscInt block, PetscReal sums[]);
/* V_p, at the step's start. */
static inline PetscReal MpmSpreadVolume(const MpmSum *sum, PetscInt p)
{
  return sum->points->volume0[p] * MpmPointJ(sum->points, p);
}

/* Products of the cells' vectors, added to the pattern after the points' own blocks (spread_tangent.c). */
PetscErrorCode MpmSpreadTangent(const MpmSum *sum, const PetscReal u[], MpmPattern *pattern, PetscReal residual[],
                                PetscInt *failed);
/*
  y += J du, or J^T du, from kept tangents (spread_action.c); with `differences` by those of the plain kernel. The
  evaluation stays as it is. Collective.
*/
PetscErrorCode MpmSpreadApply(MpmSpreadWork *work, PetscBool transposed, PetscBool differences, const PetscReal du[],
                              PetscReal y[], PetscInt *failed);

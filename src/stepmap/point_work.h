#pragma once
/*
  One point of a step's derivatives: its basis functions, its inputs, and the change of its weights.

  Visits go over groups of points that share their nodes: u, and another vector, are gathered for each.
*/
#include "space/kernel_point.h"
#include "space/point_loop.h"
#include "space/point_slopes.h"
#include "stepmap/step_map.h"

/* Room for one point's numbers. */
typedef struct {
  MpmKnown       known;
  MpmPointSlopes slopes;
  MpmBasis       basis, slope;
  PetscReal     *u, *other, *force; /* at the group's nodes, by component */
  PetscReal      input[MPM_MAX_INPUTS], other_input[MPM_MAX_INPUTS], flux[MPM_MAX_INPUTS];
  PetscReal      F[MPM_F_MAX], stress[6], *state, *own;
} MpmPointWork;

PetscErrorCode MpmPointWorkCreate(const MpmStepMap *map, MpmPointWork *work);
PetscErrorCode MpmPointWorkDestroy(MpmPointWork *work);
/* A group's points follow: values of u, and of `other` unless it is NULL, at its nodes; forces are 0. */
void MpmPointWorkGather(const MpmStepMap *map, const MpmGroup *group, const PetscReal other[], MpmPointWork *work);
/* The point, its basis functions and inputs; `other` at the nodes has inputs, too. */
void MpmPointEnter(const MpmStepMap *map, PetscInt p, PetscBool other, MpmPointWork *work, MpmKernelPoint *point);
/* The point as its kernel takes it, alone. */
void MpmPointMake(const MpmStepMap *map, PetscInt p, MpmPointWork *work, MpmKernelPoint *point);
/* True where a parameter acts on the law of point p. */
PetscBool MpmPointHasParameter(const MpmStepMap *map, const MpmSceneParameter *parameter, PetscInt p);
/* The law's states of point p. */
static inline PetscInt MpmPointStates(const MpmStepMap *map, PetscInt p)
{
  return map->sum->materials[map->sum->points->material[p]].state_size;
}
/* sum += factor row, of MPM_PACK numbers */
static inline void MpmPackAdd(PetscReal factor, const PetscReal row[], PetscReal sum[])
{
  for (PetscInt j = 0; j < MPM_PACK; j++) sum[j] += factor * row[j];
}

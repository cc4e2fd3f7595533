#pragma once
/*
  A point as the physics' kernel takes it.
*/
#include "point/layout.h"
#include "point/material.h"
#include "particles/point_mass.h"
#include "particles/points.h"
#include "space/space.h"
#include "space/sum.h"
#include "talus/point/flow.h"

/* Gravity of the water at point p. */
MPM_INLINE const PetscReal *MpmSumGravity(const MpmSum *sum, PetscInt p)
{
  return sum->still.gravity ? &sum->still.gravity[p * sum->space->dim] : sum->step.gravity;
}

/* The kernel's view of point p. */
MPM_INLINE void MpmSumPoint(const MpmSum *sum, PetscInt p, MpmKernelPoint *point)
{
  const MpmPoints   *points   = sum->points;
  const MpmMaterial *material = &sum->materials[points->material[p]];
  const double      *own      = MpmPointOwn(points, material, p);
  const PetscInt     dim      = sum->space->dim;

  point->material.parameter = own ? own : material->parameter;
  point->physics_parameter  = MpmMaterialPhysicsValues(material, own);
  point->state_n            = points->state ? &points->state[p * sum->kept.state] : NULL;
  point->F_n                = MpmPointF(points, p);
  point->own_n              = points->physics.own ? &points->physics.own[p * sum->kept.own] : NULL;
  point->value_n            = points->physics.value ? &points->physics.value[p * sum->layout->rate.count] : NULL;
  point->deviation_n        = sum->deviation_n ? &sum->deviation_n[p * sum->layout->deviation.count] : NULL;
  point->gravity            = MpmSumGravity(sum, p);
  point->cell               = sum->cell;
  point->material.info      = &material->info;
  point->stage              = sum->step.first ? &sum->step.first[p] : NULL;
  point->volume0            = sum->step.part * points->volume0[p];
  point->dt                 = sum->step.dt;
  point->material.traits    = material->info.traits | (sum->step.drained ? MPM_POINT_DRAINED : 0u) |
                           (sum->step.alternate ? MPM_POINT_ALTERNATE : 0u);
  point->material.law       = material->law;
  point->material.table     = material->table;
  point->material.dilatancy = material->dilatancy;
  point->end.state          = NULL;
  point->end.own            = NULL;
  point->end.F              = NULL;
  point->end.stress         = NULL;
  point->stress_n           = sum->mode == MPM_MODE_START ? &points->stress[p * MpmSymSize(dim)] : NULL;
}

/* Destinations of the kernel's candidate of the step's end; `trial` NULL: none. */
MPM_INLINE void MpmSumTrial(const MpmSum *sum, const MpmTrial *trial, PetscInt p, MpmKernelPoint *point)
{
  const PetscInt dim = sum->space->dim;

  if (!trial) return;
  if (sum->kept.own) point->end.own = &trial->own[p * sum->kept.own];
  point->end.F      = &trial->F[p * sum->points->F_size];
  point->end.stress = &trial->stress[p * MpmSymSize(dim)];
  if (sum->materials[sum->points->material[p]].state_size) point->end.state = &trial->state[p * sum->kept.state];
}

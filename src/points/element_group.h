#pragma once
/*
  The element block of a group of points.
*/
#include "points/point_tangent.h"

/*
  The element block of one group into to->element, and its forces into to->residual unless that is NULL; `failed` counts
  the points without an answer.
*/
PetscErrorCode MpmElementGroup_2d(const MpmSum *sum, const MpmGroup *group, const PetscReal u[], MpmWorkspace *work,
                                  Target *to, PetscInt *failed);
PetscErrorCode MpmElementGroup_3d(const MpmSum *sum, const MpmGroup *group, const PetscReal u[], MpmWorkspace *work,
                                  Target *to, PetscInt *failed);
static inline PetscErrorCode MpmElementGroup(const MpmSum *sum, const MpmGroup *group, const PetscReal u[],
                                             MpmWorkspace *work, Target *to, PetscInt *failed)
{
  return sum->layout->dim == 2 ? MpmElementGroup_2d(sum, group, u, work, to, failed)
                               : MpmElementGroup_3d(sum, group, u, work, to, failed);
}

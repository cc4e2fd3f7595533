#pragma once
/*
  The units of a sum over points.
*/
#include "point/layout.h"
#include "space/space.h"
#include "space/sum.h"

/* True where the points of a cell have one mean, and make a unit. */
static inline PetscBool MpmSumHasCells(const MpmSum *sum)
{
  return (PetscBool)(sum->layout->means && !sum->space->cells.spread);
}
/* Units, the smallest blocks of the Jacobian: groups, or cells where the physics has a mean; the box of their nodes. */
static inline PetscInt MpmUnitCount(const MpmSum *sum)
{
  return MpmSumHasCells(sum) ? sum->space->cells.count : sum->space->group_count;
}
static inline MpmCell MpmUnitGroups(const MpmSum *sum, PetscInt unit)
{
  return MpmSumHasCells(sum) ? sum->space->cells.at[unit] : (MpmCell){unit, unit + 1, unit};
}

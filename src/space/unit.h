#pragma once
/*
  The units of a sum over points.
*/
#include "point/layout.h"
#include "space/space.h"
#include "space/sum.h"

/* Units, the smallest blocks of the Jacobian: groups, or cells where the physics has a mean; the box of their nodes. */
static inline PetscInt MpmUnitCount(const MpmSum *sum)
{
  return sum->layout->means ? sum->space->cells.count : sum->space->group_count;
}
static inline MpmCell MpmUnitGroups(const MpmSum *sum, PetscInt unit)
{
  return sum->layout->means ? sum->space->cells.at[unit] : (MpmCell){unit, unit + 1, unit};
}

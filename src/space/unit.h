#pragma once
/*
  The units of a sum over points.
*/
#include "point/layout.h"
#include "space/space.h"
#include "space/sum.h"

/*
  A unit is the smallest block of the Jacobian: a group, or a cell where the physics has a mean. Its groups, and the box
  of their nodes.
*/
static inline PetscInt MpmUnitCount(const MpmSum *sum)
{
  return sum->layout->means ? sum->space->cell_count : sum->space->group_count;
}
static inline MpmCell MpmUnitGroups(const MpmSum *sum, PetscInt unit)
{
  return sum->layout->means ? sum->space->cells[unit] : (MpmCell){unit, unit + 1, unit};
}

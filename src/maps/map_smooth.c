/*
  Maps averaged over pixels, along rows and then along columns.
*/
#include "maps/map_smooth.h"

#define REACH 3. /* standard deviations */

PetscInt MpmMapSmoothReach(PetscReal deviation)
{
  return (PetscInt)PetscCeilReal(REACH * deviation);
}

/* One row or column of `count` values at a stride; pixels without data stay without. */
static void Average(PetscInt count, PetscInt64 stride, PetscInt reach, const PetscReal weight[], PetscReal value[],
                    PetscReal line[])
{
  for (PetscInt i = 0; i < count; i++) line[i] = value[i * stride];
  for (PetscInt i = 0; i < count; i++) {
    PetscReal sum = 0., all = 0.;

    if (PetscIsNanReal(line[i])) continue;
    for (PetscInt k = PetscMax(i - reach, 0); k <= PetscMin(i + reach, count - 1); k++) {
      if (PetscIsNanReal(line[k])) continue;
      sum += weight[PetscAbsInt(k - i)] * line[k];
      all += weight[PetscAbsInt(k - i)];
    }
    value[i * stride] = sum / all;
  }
}

PetscErrorCode MpmMapSmooth(PetscReal deviation, MpmMap *map)
{
  const PetscInt reach = MpmMapSmoothReach(deviation);
  PetscReal     *weight, *line;

  PetscFunctionBeginUser;
  if (!reach) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc2(reach + 1, &weight, PetscMax(map->columns, map->rows), &line));
  for (PetscInt k = 0; k <= reach; k++) weight[k] = PetscExpReal(-0.5 * PetscSqr((PetscReal)k / deviation));
  for (PetscInt j = 0; j < map->rows; j++)
    Average(map->columns, 1, reach, weight, &map->value[(PetscInt64)j * map->columns], line);
  for (PetscInt i = 0; i < map->columns; i++) Average(map->rows, map->columns, reach, weight, &map->value[i], line);
  PetscCall(PetscFree2(weight, line));
  PetscFunctionReturn(PETSC_SUCCESS);
}

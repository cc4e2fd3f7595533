/*
  Maps in memory.
*/
#include "maps/map.h"

PetscErrorCode MpmMapDestroy(MpmMap *map)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(map->value));
  PetscCall(PetscFree(map->system));
  PetscCall(PetscMemzero(map, sizeof(*map)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmMapLike(const MpmMap *like, MpmMap *map)
{
  PetscFunctionBeginUser;
  *map        = *like;
  map->value  = NULL;
  map->system = NULL;
  PetscCall(PetscStrallocpy(like->system, &map->system));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The pixel below a coordinate, and the part of the way to the next one. */
static PetscInt Pixel(PetscReal s, PetscInt count, PetscReal *part)
{
  const PetscReal held = PetscClipInterval(s, 0., (PetscReal)(count - 1));
  const PetscInt  k    = count < 2 ? 0 : PetscMin((PetscInt)held, count - 2);

  *part = held - (PetscReal)k;
  return k;
}

PetscReal MpmMapAt(const MpmMap *map, const PetscReal x[])
{
  PetscReal      part[2], height = 0.;
  const PetscInt i = Pixel((x[0] - map->x0) / map->cell[0], map->columns, &part[0]);
  const PetscInt j = Pixel((x[1] - map->y0) / map->cell[1], map->rows, &part[1]);

  for (PetscInt k = 0; k < 4; k++) {
    const PetscInt  a = PetscMin(i + k % 2, map->columns - 1), b = PetscMin(j + k / 2, map->rows - 1);
    const PetscReal weight = (k % 2 ? part[0] : 1. - part[0]) * (k / 2 ? part[1] : 1. - part[1]);

    if (weight != 0.) height += weight * map->value[(PetscInt64)b * map->columns + a];
  }
  return height;
}

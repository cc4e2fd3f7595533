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

void MpmMapPatch(const MpmMap *map, const PetscReal x[], PetscReal *value, PetscReal slope[2], PetscReal *twist)
{
  const PetscReal s[2] = {(x[0] - map->x0) / map->cell[0], (x[1] - map->y0) / map->cell[1]};
  const PetscInt  n[2] = {map->columns, map->rows};
  PetscReal       part[2], z[4];
  const PetscInt  i = Pixel(s[0], n[0], &part[0]), j = Pixel(s[1], n[1], &part[1]);

  for (PetscInt k = 0; k < 4; k++) {
    const PetscInt a = PetscMin(i + k % 2, n[0] - 1), b = PetscMin(j + k / 2, n[1] - 1);

    z[k] = map->value[(PetscInt64)b * n[0] + a];
  }
  *twist   = (z[3] - z[2] - z[1] + z[0]) / (map->cell[0] * map->cell[1]);
  slope[0] = ((1. - part[1]) * (z[1] - z[0]) + part[1] * (z[3] - z[2])) / map->cell[0];
  slope[1] = ((1. - part[0]) * (z[2] - z[0]) + part[0] * (z[3] - z[1])) / map->cell[1];
  *value =
    (1. - part[1]) * ((1. - part[0]) * z[0] + part[0] * z[1]) + part[1] * ((1. - part[0]) * z[2] + part[0] * z[3]);
  for (PetscInt a = 0; a < 2; a++) {
    if (s[a] >= 0. && s[a] <= (PetscReal)(n[a] - 1)) continue;
    slope[a] = 0.;
    *twist   = 0.;
  }
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

/*
  Pixels without data, filled in rings from their edges inward.
*/
#include "maps/map_fill.h"

#define NOWHERE -1

/* Pixel k's neighbour in one of eight directions, or NOWHERE. */
static PetscInt64 Neighbour(const MpmMap *map, PetscInt64 k, PetscInt direction)
{
  const PetscInt d = direction < 4 ? direction : direction + 1; /* 4 is the pixel itself */
  const PetscInt i = (PetscInt)(k % map->columns) + d % 3 - 1, j = (PetscInt)(k / map->columns) + d / 3 - 1;

  return i < 0 || i >= map->columns || j < 0 || j >= map->rows ? NOWHERE : (PetscInt64)j * map->columns + i;
}

/* Mean of the neighbours whose ring is before this one; rings count from 1, pixels with data have 0. */
static PetscReal Mean(const MpmMap *map, const PetscInt ring[], PetscInt64 k)
{
  PetscReal sum   = 0.;
  PetscInt  count = 0;

  for (PetscInt d = 0; d < 8; d++) {
    const PetscInt64 n = Neighbour(map, k, d);

    if (n == NOWHERE || ring[n] < 0 || ring[n] >= ring[k]) continue;
    sum += map->value[n];
    count++;
  }
  return sum / (PetscReal)count;
}

/* Pixels in the order of their rings; returns their number. */
static PetscInt64 Order(const MpmMap *map, PetscInt ring[], PetscInt64 queue[])
{
  const PetscInt64 total = (PetscInt64)map->columns * map->rows;
  PetscInt64       count = 0;

  for (PetscInt64 k = 0; k < total; k++) {
    if (ring[k] >= 0) continue;
    for (PetscInt d = 0; d < 8 && ring[k] == NOWHERE; d++) {
      const PetscInt64 n = Neighbour(map, k, d);

      if (n != NOWHERE && ring[n] == 0) ring[k] = 1;
    }
    if (ring[k] == 1) queue[count++] = k;
  }
  for (PetscInt64 at = 0; at < count; at++) {
    for (PetscInt d = 0; d < 8; d++) {
      const PetscInt64 n = Neighbour(map, queue[at], d);

      if (n == NOWHERE || ring[n] != NOWHERE) continue;
      ring[n]        = ring[queue[at]] + 1;
      queue[count++] = n;
    }
  }
  return count;
}

PetscErrorCode MpmMapFill(MpmMap *map, char **missing)
{
  const PetscInt64 total = (PetscInt64)map->columns * map->rows;
  PetscInt64       none  = 0, count, *queue;
  PetscInt        *ring;

  PetscFunctionBeginUser;
  *missing = NULL;
  for (PetscInt64 k = 0; k < total; k++) none += PetscIsNanReal(map->value[k]);
  if (!none || none == total) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscCalloc1((size_t)total, missing));
  PetscCall(PetscMalloc2((size_t)total, &ring, (size_t)none, &queue));
  for (PetscInt64 k = 0; k < total; k++) {
    (*missing)[k] = (char)PetscIsNanReal(map->value[k]);
    ring[k]       = (*missing)[k] ? NOWHERE : 0;
  }
  count = Order(map, ring, queue);
  for (PetscInt64 at = 0; at < count; at++) map->value[queue[at]] = Mean(map, ring, queue[at]);
  PetscCall(PetscFree2(ring, queue));
  PetscFunctionReturn(PETSC_SUCCESS);
}

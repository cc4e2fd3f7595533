/*
  Parts of polygons in rectangles, and integrals of maps over them.

  Rings are cut along lines one after the other (Sutherland and Hodgman 1974, doi:10.1145/360767.360802). Integrals are
  sums over triangles from the first vertex of each ring, with the sign of their direction: holes count against outer
  rings. Between four pixels a map is bilinear, a polynomial of second degree, which the mean over the middles of a
  triangle's edges integrates exactly.
*/
#include "maps/polygon_part.h"

PetscErrorCode MpmRingsDestroy(MpmRings *rings)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(rings->start));
  PetscCall(PetscFree(rings->at));
  PetscCall(PetscMemzero(rings, sizeof(*rings)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Reserve(MpmRings *rings, PetscInt ring_count, PetscInt vertex_count)
{
  PetscFunctionBeginUser;
  if (rings->ring_room <= ring_count) {
    rings->ring_room = 2 * ring_count + 2;
    PetscCall(PetscRealloc((size_t)rings->ring_room * sizeof(*rings->start), &rings->start));
  }
  if (rings->vertex_room < vertex_count) {
    rings->vertex_room = 2 * vertex_count;
    PetscCall(PetscRealloc((size_t)rings->vertex_room * 2 * sizeof(*rings->at), &rings->at));
  }
  rings->rings    = 0;
  rings->start[0] = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmRingsTake(const MpmOutline *outline, PetscInt feature, MpmRings *rings)
{
  const PetscInt first = outline->feature[feature].first, end = outline->feature[feature].end;
  const PetscInt from = outline->start[first], count = outline->start[end] - from;

  PetscFunctionBeginUser;
  PetscCall(Reserve(rings, end - first, count));
  PetscCall(PetscArraycpy(rings->at, &outline->at[2 * from], 2 * count));
  for (PetscInt k = first; k < end; k++) rings->start[++rings->rings] = outline->start[k + 1] - from;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscInt MpmRingCut(PetscInt count, const PetscReal v[], PetscInt axis, PetscReal sign, PetscReal at, PetscReal kept[])
{
  PetscInt n = 0;

  for (PetscInt i = 0; i < count; i++) {
    const PetscReal *a = &v[2 * i], *b = &v[2 * (i + 1 < count ? i + 1 : 0)];
    const PetscReal  da = sign * (a[axis] - at), db = sign * (b[axis] - at);

    if (da >= 0.) {
      kept[2 * n]     = a[0];
      kept[2 * n + 1] = a[1];
      n++;
    }
    if ((da > 0. && db < 0.) || (da < 0. && db > 0.)) {
      const PetscReal s = da / (da - db);

      kept[2 * n]        = a[0] + s * (b[0] - a[0]);
      kept[2 * n + 1]    = a[1] + s * (b[1] - a[1]);
      kept[2 * n + axis] = at;
      n++;
    }
  }
  return n;
}

PetscErrorCode MpmRingsCut(const MpmRings *rings, PetscInt axis, PetscReal lower, PetscReal upper, MpmRings *part)
{
  const PetscInt total = rings->start[rings->rings];

  PetscFunctionBeginUser;
  PetscCall(Reserve(part, rings->rings, 8 * total)); /* a cut doubles the vertices at most; its source lies behind */
  for (PetscInt k = 0; k < rings->rings; k++) {
    const PetscInt   count = rings->start[k + 1] - rings->start[k], begin = part->start[part->rings];
    const PetscReal *from  = &rings->at[2 * rings->start[k]];
    PetscReal        least = PETSC_INFINITY, most = PETSC_NINFINITY, *to = &part->at[2 * begin];
    PetscInt         n = count;

    for (PetscInt i = 0; i < count; i++) {
      least = PetscMin(least, from[2 * i + axis]);
      most  = PetscMax(most, from[2 * i + axis]);
    }
    if (most <= lower || least >= upper) continue;
    if (least < lower && most > upper) {
      PetscReal *middle = &to[8 * count];

      n = MpmRingCut(count, from, axis, 1., lower, middle);
      n = MpmRingCut(n, middle, axis, -1., upper, to);
    } else if (least < lower) n = MpmRingCut(count, from, axis, 1., lower, to);
    else if (most > upper) n = MpmRingCut(count, from, axis, -1., upper, to);
    else PetscCall(PetscArraycpy(to, from, 2 * count));
    if (n < 3) continue;
    part->start[part->rings + 1] = begin + n;
    part->rings++;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- integrals ---- */

/* The pixel below a place along an axis, -1 before the first; and where it and the next one stand. */
static PetscInt Interval(const MpmMap *map, PetscInt axis, PetscReal x)
{
  const PetscInt  count = axis ? map->rows : map->columns;
  const PetscReal s     = PetscFloorReal((x - (axis ? map->y0 : map->x0)) / map->cell[axis]);

  return (PetscInt)PetscClipInterval(s, -1., (PetscReal)(count - 1));
}

static PetscReal Centre(const MpmMap *map, PetscInt axis, PetscInt k)
{
  return (axis ? map->y0 : map->x0) + (PetscReal)k * map->cell[axis];
}

/* A map within an interval of pixels on each axis: value + slope u + slope v + twist u v, constant beyond the outer. */
typedef struct {
  PetscReal at[2], scale[2]; /* u = scale (x - at) */
  PetscReal value, slope[2], twist;
} Bilinear;

static Bilinear BilinearOf(const MpmMap *map, PetscInt i, PetscInt j)
{
  const PetscInt   a = PetscMax(i, 0), b = PetscMax(j, 0);
  const PetscReal *row   = &map->value[(PetscInt64)b * map->columns + a];
  const PetscBool  in[2] = {(PetscBool)(i >= 0 && i < map->columns - 1), (PetscBool)(j >= 0 && j < map->rows - 1)};
  Bilinear         here  = {.at = {Centre(map, 0, a), Centre(map, 1, b)}, .value = row[0]};

  for (PetscInt axis = 0; axis < 2; axis++) {
    if (!in[axis]) continue;
    here.scale[axis] = 1. / map->cell[axis];
    here.slope[axis] = row[axis ? map->columns : 1] - row[0];
  }
  if (in[0] && in[1]) here.twist = row[map->columns + 1] - row[map->columns] - here.slope[0];
  return here;
}

static PetscReal At(const Bilinear *map, PetscReal x, PetscReal y)
{
  const PetscReal u = map->scale[0] * (x - map->at[0]), v = map->scale[1] * (y - map->at[1]);

  return map->value + map->slope[0] * u + map->slope[1] * v + map->twist * u * v;
}

/* Adds a ring, over which the map is one bilinear function; NULL: the depth. */
static void AddRing(PetscInt count, const PetscReal v[], const Bilinear *map, PetscReal depth, MpmPart *part)
{
  for (PetscInt i = 1; i + 1 < count; i++) {
    const PetscReal *a = v, *b = &v[2 * i], *c = &v[2 * i + 2];
    const PetscReal  area = 0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]));

    part->area += area;
    for (PetscInt k = 0; k < 2; k++) part->moment[k] += area / 3. * (a[k] + b[k] + c[k]);
    if (!map) part->volume += area * depth;
    else
      part->volume +=
        area / 3. *
        (At(map, 0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])) + At(map, 0.5 * (b[0] + c[0]), 0.5 * (b[1] + c[1])) +
         At(map, 0.5 * (c[0] + a[0]), 0.5 * (c[1] + a[1])));
  }
}

static void AddRings(const MpmRings *rings, const Bilinear *map, PetscReal depth, MpmPart *part)
{
  for (PetscInt k = 0; k < rings->rings; k++)
    AddRing(rings->start[k + 1] - rings->start[k], &rings->at[2 * rings->start[k]], map, depth, part);
}

/* Between the centres of pixels, column by column of them. */
static PetscErrorCode AddByPixels(const MpmRings *rings, const PetscReal lower[2], const PetscReal upper[2],
                                  const MpmMap *map, MpmRings spare[2], MpmPart *part)
{
  const PetscInt first[2] = {Interval(map, 0, lower[0]), Interval(map, 1, lower[1])};
  const PetscInt last[2]  = {Interval(map, 0, upper[0]), Interval(map, 1, upper[1])};

  PetscFunctionBeginUser;
  for (PetscInt i = first[0]; i <= last[0]; i++) {
    const PetscReal left  = i == first[0] ? lower[0] : Centre(map, 0, i);
    const PetscReal right = i == last[0] ? upper[0] : Centre(map, 0, i + 1);

    PetscCall(MpmRingsCut(rings, 0, left, right, &spare[0]));
    for (PetscInt j = first[1]; j <= last[1] && spare[0].rings; j++) {
      const Bilinear  here = BilinearOf(map, i, j);
      const PetscReal low  = j == first[1] ? lower[1] : Centre(map, 1, j);
      const PetscReal high = j == last[1] ? upper[1] : Centre(map, 1, j + 1);

      PetscCall(MpmRingsCut(&spare[0], 1, low, high, &spare[1]));
      AddRings(&spare[1], &here, 0., part);
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPartAdd(const MpmRings *rings, const PetscReal lower[2], const PetscReal upper[2], const MpmMap *map,
                          PetscReal depth, MpmRings spare[2], MpmPart *part)
{
  PetscFunctionBeginUser;
  if (!rings->rings) PetscFunctionReturn(PETSC_SUCCESS);
  if (map->value) {
    PetscCall(AddByPixels(rings, lower, upper, map, spare, part));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(MpmRingsCut(rings, 0, lower[0], upper[0], &spare[0]));
  if (!spare[0].rings) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmRingsCut(&spare[0], 1, lower[1], upper[1], &spare[1]));
  AddRings(&spare[1], NULL, depth, part);
  PetscFunctionReturn(PETSC_SUCCESS);
}

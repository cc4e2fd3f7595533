/*
  Lines of ground, y over x.

  The lower one of two lines is linear between neighbouring places x of either's vertices, with one vertex more where
  the lines cross in between.
*/
#include "options/options.h"
#include "maps/polyline.h"

PetscErrorCode MpmPolylineRead(const MpmOptions *options, const char *name, const char *help, MpmPolyline *line)
{
  const char *prefix = options->prefix ? options->prefix : "";
  PetscInt    count;
  PetscReal  *at;

  PetscFunctionBegin;
  PetscCall(MpmOptionsRealList(options, name, "m", help, MPM_OPTIONAL, &count, &at));
  if (count == 1) {
    const PetscReal level = at[0];

    PetscCall(PetscRealloc(2 * sizeof(*at), &at));
    at[0] = 0.;
    at[1] = level;
    count = 2;
  }
  MpmCheckInput(count % 2 == 0, "-%s%s: has %lld numbers, must have two a vertex, or one for a level", prefix, name,
                (long long)count);
  for (PetscInt i = 1; i < count / 2; i++) {
    MpmCheckInput(at[2 * i] >= at[2 * i - 2], "-%s%s: x of vertex %lld must be >= %g, that of the vertex before",
                  prefix, name, (long long)i + 1, (double)at[2 * i - 2]);
    MpmCheckInput(at[2 * i] > at[2 * i - 2] || at[2 * i + 1] != at[2 * i - 1],
                  "-%s%s: vertices %lld and %lld are the same", prefix, name, (long long)i, (long long)i + 1);
  }
  line->count = count / 2;
  line->at    = at;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPolylineDestroy(MpmPolyline *line)
{
  PetscFunctionBegin;
  PetscCall(PetscFree(line->at));
  line->count = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscReal MpmPolylineHeight(const MpmPolyline *line, PetscReal x, PetscInt side)
{
  const PetscReal *at = line->at;
  PetscInt         i  = 0; /* the first vertex beyond x */

  if (!line->count) return PETSC_NINFINITY;
  while (i < line->count && (side > 0 ? at[2 * i] <= x : at[2 * i] < x)) i++;
  if (i == 0) return at[1];
  if (i == line->count) return at[2 * i - 1];
  return at[2 * i - 1] + (x - at[2 * i - 2]) / (at[2 * i] - at[2 * i - 2]) * (at[2 * i + 1] - at[2 * i - 1]);
}

void MpmPolylineBounds(const MpmPolyline *line, PetscReal *least, PetscReal *most)
{
  *least = *most = line->count ? line->at[1] : PETSC_NINFINITY;
  for (PetscInt i = 1; i < line->count; i++) {
    *least = PetscMin(*least, line->at[2 * i + 1]);
    *most  = PetscMax(*most, line->at[2 * i + 1]);
  }
}

/* Adds a vertex, unless the line ends there. */
static void AddVertex(MpmPolyline *line, PetscReal x, PetscReal y)
{
  PetscReal *at = &line->at[2 * line->count];

  if (line->count && at[-2] == x && at[-1] == y) return;
  at[0] = x;
  at[1] = y;
  line->count++;
}

/* The crossing of two lines between neighbouring places, where there is one. */
static void AddCrossing(const MpmPolyline *one, const MpmPolyline *other, PetscReal left, PetscReal right,
                        MpmPolyline *lower)
{
  const PetscReal before = MpmPolylineHeight(one, left, 1) - MpmPolylineHeight(other, left, 1),
                  after  = MpmPolylineHeight(one, right, -1) - MpmPolylineHeight(other, right, -1);
  PetscReal x;

  if (!(before * after < 0.)) return;
  x = left + before / (before - after) * (right - left);
  AddVertex(lower, x, PetscMin(MpmPolylineHeight(one, x, 1), MpmPolylineHeight(other, x, 1)));
}

PetscErrorCode MpmPolylineLower(const MpmPolyline *one, const MpmPolyline *other, MpmPolyline *lower)
{
  const PetscInt most = one->count + other->count;
  PetscInt       n    = 0;
  PetscReal     *x;

  PetscFunctionBegin;
  lower->count = 0;
  lower->at    = NULL;
  if (!one->count || !other->count) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(most, &x));
  for (PetscInt i = 0; i < one->count; i++) x[n++] = one->at[2 * i];
  for (PetscInt i = 0; i < other->count; i++) x[n++] = other->at[2 * i];
  PetscCall(PetscSortRemoveDupsReal(&n, x));
  PetscCall(PetscMalloc1((2 * 3 * most), &lower->at)); /* two a place, and a crossing */
  for (PetscInt k = 0; k < n; k++) {
    for (PetscInt side = -1; side <= 1; side += 2)
      AddVertex(lower, x[k], PetscMin(MpmPolylineHeight(one, x[k], side), MpmPolylineHeight(other, x[k], side)));
    if (k + 1 < n) AddCrossing(one, other, x[k], x[k + 1], lower);
  }
  PetscCall(PetscFree(x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

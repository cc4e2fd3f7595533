/*
  Boxes around the points of each part, against what is found by looking at every point.
*/
#include "particles/points.h"
#include "facets/contact_search.h"
#include "unit.h"

#define MOST  300
#define PARTS 3

static PetscReal Random(PetscReal lower, PetscReal upper)
{
  return lower + (upper - lower) * ((PetscReal)rand() / RAND_MAX);
}

/* Points whose parts follow one another in runs of so many. */
static void Scatter(PetscInt dim, PetscInt run, MpmPoints *points)
{
  for (PetscInt p = 0; p < points->count; p++) points->domain.part[p] = p / run % PARTS;
  for (PetscInt k = 0; k < points->count * dim; k++) {
    points->x[k]                  = Random(-3., 2.);
    points->domain.half_length[k] = Random(0.01, 0.3);
  }
  for (PetscInt k = 0; k < points->count * dim * dim; k++) points->F[k] = Random(-2., 2.);
}

/* Of this part: as wide as its points, and with a square that none of them is above. */
static void Check(PetscInt dim, const MpmPoints *points, PetscInt part, const MpmFaceBox *box)
{
  PetscReal lower[MPM_MAX_DIM], upper[MPM_MAX_DIM], most = 0., each = 0., longest = 0.;
  PetscInt  found = 0;

  for (PetscInt a = 0; a < dim; a++) {
    lower[a] = PETSC_INFINITY;
    upper[a] = PETSC_NINFINITY;
  }
  for (PetscInt p = 0; p < points->count; p++) {
    PetscReal square = 0., half = 0.;

    if (points->domain.part[p] != part) continue;
    found++;
    for (PetscInt a = 0; a < dim; a++) {
      lower[a] = PetscMin(lower[a], points->x[p * dim + a]);
      upper[a] = PetscMax(upper[a], points->x[p * dim + a]);
      half     = PetscMax(half, points->domain.half_length[p * dim + a]);
    }
    for (PetscInt k = 0; k < dim * dim; k++) {
      square += PetscSqr(points->F[p * dim * dim + k]);
      each = PetscMax(each, PetscSqr(points->F[p * dim * dim + k]));
    }
    most    = PetscMax(most, square * PetscSqr(half));
    longest = PetscMax(longest, half);
  }
  if (!found) {
    ck_assert_double_gt(box->lower[0], box->upper[0]);
    return;
  }
  for (PetscInt a = 0; a < dim; a++) {
    ck_assert_double_eq(box->lower[a], lower[a]);
    ck_assert_double_eq(box->upper[a], upper[a]);
  }
  ck_assert_double_ge(box->square, most * (1. - 1e-14));
  ck_assert_double_le(box->square, (PetscReal)(dim * dim) * each * PetscSqr(longest) * (1. + 1e-14));
}

START_TEST(boxes_hold_their_parts)
{
  const PetscInt counts[] = {0, 1, 2, 15, 16, 17, 31, 63, 64, 65, 127, 129, MOST}, runs[] = {1, 5, 64, 70, MOST};
  PetscInt       part[MOST];
  PetscReal      x[MOST * 3], half[MOST * 3], F[MOST * 9];
  MpmPoints      points = {.domain.part = part, .x = x, .domain.half_length = half, .F = F};

  for (PetscInt dim = 2; dim <= 3; dim++) {
    for (size_t c = 0; c < PETSC_STATIC_ARRAY_LENGTH(counts); c++) {
      for (size_t r = 0; r < PETSC_STATIC_ARRAY_LENGTH(runs); r++) {
        MpmFaceBox boxes[PARTS];

        points.count  = counts[c];
        points.F_size = dim * dim;
        Scatter(dim, runs[r], &points);
        MpmFaceBoxesOfParts(dim, PARTS, &points, boxes);
        for (PetscInt k = 0; k < PARTS; k++) Check(dim, &points, k, &boxes[k]);
      }
    }
  }
}
END_TEST

int main(int argc, char **argv)
{
  const TTest *const tests[] = {boxes_hold_their_parts};

  return UnitRun(&argc, &argv, "contact_search", PETSC_STATIC_ARRAY_LENGTH(tests), tests);
}

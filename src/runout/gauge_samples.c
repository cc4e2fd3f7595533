/*
  Samples that gauges take of the flow, half a cell apart.
*/
#include "runout/runout_impl.h"

#define APART 0.5 /* cells between samples */

/* Room for more samples. */
static PetscErrorCode Grow(MpmGauge *gauge, PetscInt more)
{
  PetscFunctionBeginUser;
  PetscCall(PetscRealloc((size_t)(gauge->count + more) * sizeof(*gauge->sample), &gauge->sample));
  PetscCall(PetscArrayzero(&gauge->sample[gauge->count], more));
  gauge->count += more;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscReal Spacing(const MpmGrid *grid)
{
  return APART * PetscMin(grid->h[0], grid->h[1]);
}

/* Pieces of a line from s on, each with its middle. */
static PetscErrorCode AddPiece(const MpmGrid *grid, const PetscReal from[], const PetscReal to[], PetscReal *s,
                               MpmGauge *gauge)
{
  const PetscReal along[2] = {to[0] - from[0], to[1] - from[1]};
  const PetscReal length   = PetscSqrtReal(along[0] * along[0] + along[1] * along[1]);
  const PetscInt  pieces = PetscMax((PetscInt)PetscCeilReal(length / Spacing(grid)), 1), begin = gauge->count;

  PetscFunctionBeginUser;
  PetscCall(Grow(gauge, pieces));
  for (PetscInt k = 0; k < pieces; k++) {
    const PetscReal part   = ((PetscReal)k + 0.5) / (PetscReal)pieces;
    MpmSample      *sample = &gauge->sample[begin + k];

    for (PetscInt a = 0; a < 2; a++) sample->x[a] = from[a] + part * along[a];
    sample->normal[0] = along[1] / (PetscReal)pieces;
    sample->normal[1] = -along[0] / (PetscReal)pieces;
    sample->s         = *s + part * length;
  }
  *s += length;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* By the rule of even and odd crossings. */
static PetscBool Inside(PetscInt count, const PetscReal vertex[], const PetscReal x[])
{
  PetscBool in = PETSC_FALSE;

  for (PetscInt k = 0; k < count; k++) {
    const PetscReal *a = &vertex[2 * k], *b = &vertex[2 * ((k + 1) % count)];

    if ((a[1] > x[1]) != (b[1] > x[1]) && x[0] < a[0] + (b[0] - a[0]) * (x[1] - a[1]) / (b[1] - a[1]))
      in = (PetscBool)!in;
  }
  return in;
}

/* The corners of an outline, and places inside. */
static PetscErrorCode AddOutline(const MpmGrid *grid, PetscInt count, const PetscReal vertex[], MpmGauge *gauge)
{
  const PetscReal apart    = Spacing(grid);
  PetscReal       lower[2] = {vertex[0], vertex[1]}, upper[2] = {vertex[0], vertex[1]}, x[2];

  PetscFunctionBeginUser;
  PetscCall(Grow(gauge, count));
  for (PetscInt k = 0; k < 2 * count; k++) {
    gauge->sample[gauge->count - count + k / 2].x[k % 2] = vertex[k];
    lower[k % 2]                                         = PetscMin(lower[k % 2], vertex[k]);
    upper[k % 2]                                         = PetscMax(upper[k % 2], vertex[k]);
  }
  for (x[1] = lower[1] + 0.5 * apart; x[1] < upper[1]; x[1] += apart) {
    for (x[0] = lower[0] + 0.5 * apart; x[0] < upper[0]; x[0] += apart) {
      if (!Inside(count, vertex, x)) continue;
      PetscCall(Grow(gauge, 1));
      for (PetscInt a = 0; a < 2; a++) gauge->sample[gauge->count - 1].x[a] = x[a];
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscBool InGrid(const MpmGrid *grid, const PetscReal x[])
{
  for (PetscInt a = 0; a < 2; a++)
    if (!(x[a] >= grid->lower[a] && x[a] <= grid->upper[a])) return PETSC_FALSE;
  return PETSC_TRUE;
}

PetscErrorCode MpmGaugeAddSamples(const MpmGrid *grid, PetscInt count, const PetscReal vertex[], MpmGauge *gauge)
{
  PetscReal s      = gauge->count ? gauge->sample[gauge->count - 1].s : 0.;
  PetscInt  inside = 0;

  PetscFunctionBeginUser;
  if (gauge->kind == MPM_GAUGE_PLACE) {
    PetscCall(Grow(gauge, 1));
    for (PetscInt a = 0; a < 2; a++) gauge->sample[gauge->count - 1].x[a] = vertex[a];
  } else if (gauge->kind == MPM_GAUGE_OUTLINE) PetscCall(AddOutline(grid, count, vertex, gauge));
  else
    for (PetscInt k = 0; k + 1 < count; k++) PetscCall(AddPiece(grid, &vertex[2 * k], &vertex[2 * k + 2], &s, gauge));
  for (PetscInt k = 0; k < gauge->count; k++)
    if (InGrid(grid, gauge->sample[k].x)) gauge->sample[inside++] = gauge->sample[k];
  gauge->count = inside;
  PetscFunctionReturn(PETSC_SUCCESS);
}

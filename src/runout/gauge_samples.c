/*
  Samples that gauges take of the flow, half a cell apart.
*/
#include "runout/runout_impl.h"

#define APART 0.5  /* cells between samples */
#define SLACK 1e-6 /* of a cell */

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

/* True where x is within `slack` of the line from a to b. */
static PetscBool Beside(const PetscReal a[], const PetscReal b[], const PetscReal x[], PetscReal slack)
{
  const PetscReal along[2] = {b[0] - a[0], b[1] - a[1]}, square = PetscSqr(along[0]) + PetscSqr(along[1]);
  const PetscReal way  = (x[0] - a[0]) * along[0] + (x[1] - a[1]) * along[1];
  const PetscReal part = square > 0. ? PetscClipInterval(way / square, 0., 1.) : 0.;

  return (PetscBool)(PetscSqr(x[0] - a[0] - part * along[0]) + PetscSqr(x[1] - a[1] - part * along[1]) <=
                     PetscSqr(slack));
}

/* By the rule of even and odd crossings, or on an edge. */
static PetscBool Inside(PetscInt count, const PetscReal vertex[], const PetscReal x[], PetscReal slack)
{
  PetscBool in = PETSC_FALSE;

  for (PetscInt k = 0; k < count; k++) {
    const PetscReal *a = &vertex[2 * k], *b = &vertex[2 * ((k + 1) % count)];

    if (Beside(a, b, x, slack)) return PETSC_TRUE;
    if ((a[1] > x[1]) != (b[1] > x[1]) && x[0] < a[0] + (b[0] - a[0]) * (x[1] - a[1]) / (b[1] - a[1]))
      in = (PetscBool)!in;
  }
  return in;
}

/*
  The corners of an outline, and the places inside that are on lines through nodes or midway between these: values are
  bilinear between nodes, where their maxima are.
*/
static PetscErrorCode AddOutline(const MpmGrid *grid, PetscInt count, const PetscReal vertex[], MpmGauge *gauge)
{
  PetscReal lower[2] = {PETSC_INFINITY, PETSC_INFINITY}, upper[2] = {PETSC_NINFINITY, PETSC_NINFINITY};
  PetscInt  at[2], begin[2], end[2];

  PetscFunctionBeginUser;
  PetscCall(Grow(gauge, count));
  for (PetscInt k = 0; k < 2 * count; k++) {
    gauge->sample[gauge->count - count + k / 2].x[k % 2] = vertex[k];
    lower[k % 2]                                         = PetscMin(lower[k % 2], vertex[k]);
    upper[k % 2]                                         = PetscMax(upper[k % 2], vertex[k]);
  }
  for (PetscInt a = 0; a < 2; a++) {
    const PetscReal apart = APART * grid->h[a], last = (PetscReal)grid->cells[a] / APART;

    begin[a] = (PetscInt)PetscMax(PetscCeilReal((lower[a] - grid->lower[a]) / apart - SLACK), 0.);
    end[a]   = (PetscInt)PetscMin(PetscFloorReal((upper[a] - grid->lower[a]) / apart + SLACK), last) + 1;
  }
  for (at[1] = begin[1]; at[1] < end[1]; at[1]++) {
    for (at[0] = begin[0]; at[0] < end[0]; at[0]++) {
      PetscReal x[2];

      for (PetscInt a = 0; a < 2; a++) x[a] = grid->lower[a] + APART * grid->h[a] * (PetscReal)at[a];
      if (!Inside(count, vertex, x, SLACK * PetscMin(grid->h[0], grid->h[1]))) continue;
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

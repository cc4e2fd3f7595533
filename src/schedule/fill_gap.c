/*
  The gap between a body that joins a stage and the ground that has settled beneath it since both were drawn.

  Columns of the body's lattice of points, across gravity's axis: in each the gap goes from the lower face of the body's
  lowest point down to the highest domain beneath it. The gap is filled with points of the lattice's spacing s to within
  a half: n = round(gap/s) of height gap/n, with mass by density; where n is 0 the lowest point grows by the gap. New
  points start with the history of the column's lowest point, at rest.

  `fill: true` fills all columns. Without `fill` those are looked at whose face was drawn on a body that is there, of
  the same part of the material: gaps from half a row of points to a cell are filled, and beyond a cell the body is
  refused. `fill: false` leaves the body as it was drawn.
*/
#include "geometry/geometry.h"
#include "particles/body.h"
#include "particles/particles.h"
#include "particles/points.h"
#include "loads/load.h"
#include "query/model.h"
#include "schedule/reduction.h"
#include "schedule/stage.h"

#define CLOSED  1e-3 /* gap over spacing that rounding and the solver's tolerance leave */
#define MISSING 0.5  /* gap over spacing from which a row of points is missing */
#define FOUND   1e-6 /* of the spacing: heights of one point */

/* Columns of one body. */
typedef struct {
  MpmBodyLattice lattice;
  PetscInt       axis, up, count; /* vertical axis and way, columns */
  PetscReal     *bottom, *top;    /* heights up the axis: of the body's lower face, of the ground beneath */
  PetscReal     *gap;             /* to be filled, m */
  PetscReal      largest, volume; /* of all gaps, m; m3 */
  PetscInt       wanted, *above;  /* points of this rank: so many, and the lowest of the body's above each */
} Columns;

/* The number of lattice cells along an axis, one along the vertical. */
static PetscInt Across(const Columns *columns, PetscInt a)
{
  return a == columns->axis ? 1 : columns->lattice.count[a];
}

/* The column of sub-lattice numbers. */
static PetscInt Column(const Columns *columns, const PetscInt k[])
{
  return (k[2] * Across(columns, 1) + k[1]) * Across(columns, 0) + k[0];
}

/* The columns whose centres lie within `half` of x; false where there are none. */
static PetscBool Cover(const Columns *columns, PetscInt dim, const PetscReal x[], const PetscReal half[],
                       PetscInt first[], PetscInt end[])
{
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    first[a] = 0;
    end[a]   = 1;
    if (a == columns->axis || a >= dim) continue;
    const PetscReal at = (x[a] - columns->lattice.lower[a]) / columns->lattice.spacing[a] - 0.5,
                    r  = half[a] / columns->lattice.spacing[a] + FOUND;

    first[a] = (PetscInt)PetscMax(PetscCeilReal(at - r), 0.);
    end[a]   = (PetscInt)PetscMin(PetscFloorReal(at + r) + 1., (PetscReal)columns->lattice.count[a]);
    if (first[a] >= end[a]) return PETSC_FALSE;
  }
  return PETSC_TRUE;
}

/* The column of a point of the body. */
static PetscInt ColumnOf(const Columns *columns, PetscInt dim, const PetscReal x[])
{
  PetscInt k[MPM_MAX_DIM] = {0, 0, 0};

  for (PetscInt a = 0; a < dim; a++)
    if (a != columns->axis)
      k[a] = PetscMin(
        PetscMax((PetscInt)PetscFloorReal((x[a] - columns->lattice.lower[a]) / columns->lattice.spacing[a]), 0),
        columns->lattice.count[a] - 1);
  return Column(columns, k);
}

/* Lower faces of the body, and the ground's highest domains beneath. */
static PetscErrorCode FindFaces(MpmModel model, PetscInt body, const MpmPoints *points, Columns *columns)
{
  const PetscInt  dim  = model->disc.dim;
  const PetscReal half = 0.5 * columns->lattice.spacing[columns->axis];

  PetscFunctionBeginUser;
  for (PetscInt p = 0; p < points->count; p++) {
    PetscReal *bottom;

    if (MpmBodyNumber(model->scene.bodies, points, p) != body) continue;
    bottom  = &columns->bottom[ColumnOf(columns, dim, &points->x[p * dim])];
    *bottom = PetscMin(*bottom, (PetscReal)columns->up * points->x[p * dim + columns->axis] - half);
  }
  PetscCall(
    MPIU_Allreduce(MPI_IN_PLACE, columns->bottom, (PetscMPIInt)columns->count, MPIU_REAL, MPIU_MIN, model->comm));
  for (PetscInt p = 0; p < points->count; p++) {
    const PetscInt  b      = MpmBodyNumber(model->scene.bodies, points, p);
    const PetscReal height = (PetscReal)columns->up * points->x[p * dim + columns->axis];
    PetscReal       reach[MPM_MAX_DIM], U[MPM_MAX_DIM];
    PetscInt        first[MPM_MAX_DIM], end[MPM_MAX_DIM];

    if (b == body || b >= model->scene.bodies->count || model->scene.deformation.stretch(MpmPointF(points, p), U))
      continue;
    MpmBodyHalfLengths(model->scene.bodies->at[b], model->disc.grid, reach);
    for (PetscInt a = 0; a < dim; a++)
      reach[a] = U[a] * (points->domain.half_length ? points->domain.half_length[p * dim + a] : reach[a]);
    if (!Cover(columns, dim, &points->x[p * dim], reach, first, end)) continue;
    for (PetscInt z = first[2]; z < end[2]; z++) {
      for (PetscInt y = first[1]; y < end[1]; y++) {
        for (PetscInt x = first[0]; x < end[0]; x++) {
          const PetscInt c = Column(columns, (const PetscInt[]){x, y, z});

          if (height < columns->bottom[c]) columns->top[c] = PetscMax(columns->top[c], height + reach[columns->axis]);
        }
      }
    }
  }
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, columns->top, (PetscMPIInt)columns->count, MPIU_REAL, MPIU_MAX, model->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Columns without a centre of a domain, where domains have been drawn apart, take the higher ground beside them. */
static PetscErrorCode CloseHoles(Columns *columns)
{
  PetscReal *top;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(columns->count, &top));
  PetscCall(PetscArraycpy(top, columns->top, columns->count));
  for (PetscInt c = 0; c < columns->count; c++) {
    PetscInt stride = 1;

    for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
      const PetscInt n = Across(columns, a), k = c / stride % n;

      if (columns->top[c] <= PETSC_NINFINITY && k > 0) top[c] = PetscMax(top[c], columns->top[c - stride]);
      if (columns->top[c] <= PETSC_NINFINITY && k < n - 1) top[c] = PetscMax(top[c], columns->top[c + stride]);
      stride *= n;
    }
  }
  PetscCall(PetscFree(columns->top));
  columns->top = top;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscBool SamePart(const MpmModel model, PetscInt one, PetscInt other)
{
  const MpmBodies *bodies = model->scene.bodies;

  return (PetscBool)(model->disc.material.parts == 1 || bodies->part[one] == bodies->part[other]);
}

/* True where the body was drawn there on a present body of its part. */
static PetscBool WasDrawnOnGround(const MpmModel model, const Columns *columns, const PetscBool there[], PetscInt body,
                                  PetscInt c)
{
  PetscReal x[MPM_MAX_DIM] = {0., 0., 0.};
  PetscInt  stride         = 1;

  for (PetscInt a = 0; a < model->disc.dim; a++) {
    const PetscReal s = columns->lattice.spacing[a];

    if (a == columns->axis) x[a] = (PetscReal)columns->up * (columns->bottom[c] - 0.5 * s);
    else x[a] = columns->lattice.lower[a] + s * ((PetscReal)(c / stride % Across(columns, a)) + 0.5);
    stride *= Across(columns, a);
  }
  for (PetscInt b = 0; b < model->scene.bodies->count; b++)
    if (b != body && there[b] && SamePart(model, b, body) && MpmBodyReaches(model->scene.bodies->at[b], x))
      return PETSC_TRUE;
  return PETSC_FALSE;
}

/* The gap of each column that is to be filled. */
static PetscErrorCode FindGaps(MpmModel model, PetscInt body, const MpmPoints *points, Columns *columns)
{
  const PetscReal s    = columns->lattice.spacing[columns->axis];
  const MpmFill   fill = MpmBodyFills(model->scene.bodies->at[body]);
  PetscBool      *there;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(model->scene.bodies->count + 1, &there));
  for (PetscInt p = 0; p < points->count; p++) there[MpmBodyNumber(model->scene.bodies, points, p)] = PETSC_TRUE;
  PetscCall(
    MPIU_Allreduce(MPI_IN_PLACE, there, (PetscMPIInt)model->scene.bodies->count, MPIU_BOOL, MPI_LOR, model->comm));
  for (PetscInt c = 0; c < columns->count; c++) {
    const PetscReal gap = columns->bottom[c] - columns->top[c];

    columns->gap[c] = 0.;
    if (!(columns->bottom[c] < PETSC_INFINITY && columns->top[c] > PETSC_NINFINITY)) continue;
    if (gap <= (fill == MPM_FILL_YES ? CLOSED : MISSING) * s) continue;
    if (fill != MPM_FILL_YES && !WasDrawnOnGround(model, columns, there, body, c)) continue;
    columns->gap[c]  = gap;
    columns->largest = PetscMax(columns->largest, gap);
  }
  PetscCall(PetscFree(there));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Without `fill`, a gap beyond a cell */
static PetscErrorCode Refuse(MpmModel model, PetscInt body, const char stage[], const Columns *columns)
{
  const PetscReal cell = model->disc.h[columns->axis];
  const char     *name = model->scene.bodies->names[body];

  PetscFunctionBeginUser;
  MpmCheckInput(
    MpmBodyFills(model->scene.bodies->at[body]) == MPM_FILL_YES || columns->largest <= cell * (1. + FOUND),
    "-mpm_body_%s_fill is missing: in stage %s the body stands %.3g m above the settled ground, more than a "
    "cell, %g m; true fills the gap, false leaves it",
    name, stage, (double)columns->largest, (double)cell);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Lowest points of their columns on this rank, once for each new point beneath; the others grow. */
static PetscErrorCode Grow(MpmModel model, PetscInt body, MpmPoints *points, Columns *columns)
{
  const PetscInt  dim = model->disc.dim, axis = columns->axis;
  const PetscReal s        = columns->lattice.spacing[axis];
  PetscInt        capacity = 0;

  PetscFunctionBeginUser;
  for (PetscInt p = 0; p < points->count; p++) {
    const PetscInt c =
      MpmBodyNumber(model->scene.bodies, points, p) == body ? ColumnOf(columns, dim, &points->x[p * dim]) : -1;
    const PetscReal height = (PetscReal)columns->up * points->x[p * dim + axis], gap = c < 0 ? 0. : columns->gap[c];
    const PetscInt  n = (PetscInt)PetscFloorReal(gap / s + 0.5);

    if (!(gap > 0.) || PetscAbsReal(height - 0.5 * s - columns->bottom[c]) > FOUND * s) continue;
    columns->volume += points->volume0[p] * gap / s;
    if (!n) {
      points->volume0[p] *= 1. + gap / s;
      if (points->mass) points->mass[p] *= 1. + gap / s;
      if (points->domain.half_length) points->domain.half_length[p * dim + axis] += 0.5 * gap;
      if (points->domain.drawn != points->domain.half_length) points->domain.drawn[p * dim + axis] += 0.5 * gap;
      points->x[p * dim + axis] -= 0.5 * gap * (PetscReal)columns->up;
      points->x0[p * dim + axis] = points->origin[p * dim + axis] = points->x[p * dim + axis];
    }
    if (columns->wanted + n > capacity) {
      capacity = 2 * (columns->wanted + n) + 64;
      PetscCall(PetscRealloc((size_t)capacity * sizeof(*columns->above), &columns->above));
    }
    for (PetscInt k = 0; k < n; k++) columns->above[columns->wanted++] = p;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Copies from `first` on become the points of the gaps: place, domain, volume, mass, id. */
static void Place(MpmModel model, PetscInt body, const Columns *columns, const PetscReal amount[], PetscInt first,
                  MpmPoints *points)
{
  const PetscInt  dim = model->disc.dim, axis = columns->axis;
  const PetscReal s = columns->lattice.spacing[axis];

  for (PetscInt i = 0, row = 0; i < columns->wanted; i++) {
    const PetscInt  p = columns->above[i], q = first + i, c = ColumnOf(columns, dim, &points->x[p * dim]);
    const PetscReal gap = columns->gap[c], n = PetscFloorReal(gap / s + 0.5), height = gap / n;

    row                        = i && columns->above[i - 1] == p ? row + 1 : 0;
    points->id[q]              = MpmBodyFillId(model->scene.bodies->at[body], points, c, row);
    points->x[q * dim + axis]  = (PetscReal)columns->up * (columns->bottom[c] - ((PetscReal)row + 0.5) * height);
    points->x0[q * dim + axis] = points->origin[q * dim + axis] = points->x[q * dim + axis];
    points->volume0[p]                                          = amount[2 * i];
    points->volume0[q]                                          = amount[2 * i] * height / s;
    if (points->mass) points->mass[p] = amount[2 * i + 1];
    if (points->mass) points->mass[q] = amount[2 * i + 1] * height / s;
    if (points->domain.half_length)
      points->domain.drawn[q * dim + axis] = points->domain.half_length[q * dim + axis] = 0.5 * height;
    for (PetscInt a = 0; points->domain.cut && a <= dim; a++) points->domain.cut[q * (dim + 1) + a] = 0.;
  }
}

/* New points down to the ground. */
static PetscErrorCode Fill(MpmModel model, PetscInt body, MpmPoints *points, const char stage[], Columns *columns)
{
  PetscInt   first;
  PetscInt64 count;
  PetscReal *amount;

  PetscFunctionBeginUser;
  PetscCall(Grow(model, body, points, columns));
  count = columns->wanted;
  PetscCall(PetscMalloc1(2 * (size_t)columns->wanted + 1, &amount));
  for (PetscInt i = 0; i < columns->wanted; i++) {
    amount[2 * i]     = points->volume0[columns->above[i]];
    amount[2 * i + 1] = points->mass ? points->mass[columns->above[i]] : 0.;
  }
  first = points->count;
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, points));
  PetscCall(MpmParticlesHalve(model->state.particles, columns->wanted, columns->above));
  PetscCall(MpmParticlesGetArrays(model->state.particles, points));
  Place(model, body, columns, amount, first, points);
  PetscCall(PetscFree(amount));
  PetscCall(PetscFree(columns->above));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &count, 1, MPIU_INT64, MPI_SUM, model->comm));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &columns->volume, 1, MPIU_REAL, MPIU_SUM, model->comm));
  PetscCall(MpmMonitorLine(
    &model->monitor,
    "stage %s: body %s filled down to the settled ground: a gap of up to %.3g m, %.4g m3, %" PetscInt64_FMT
    " points more",
    stage, model->scene.bodies->names[body], (double)columns->largest, (double)columns->volume, count));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmGapClose(MpmModel model, PetscInt body, const char stage[])
{
  const MpmBody of      = model->scene.bodies->at[body];
  Columns       columns = {.count = 1};
  MpmPoints     points;

  PetscFunctionBeginUser;
  if (MpmBodyIsImported(of) || MpmBodyFills(of) == MPM_FILL_NO) PetscFunctionReturn(PETSC_SUCCESS);
  MpmBodyGetLattice(of, &columns.lattice);
  MpmLoadsGetVertical(model->scene.loads, model->disc.dim, &columns.axis, &columns.up);
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) columns.count *= Across(&columns, a);
  PetscCall(PetscMalloc1(columns.count, &columns.bottom));
  PetscCall(PetscMalloc1(columns.count, &columns.top));
  PetscCall(PetscMalloc1(columns.count, &columns.gap));
  for (PetscInt c = 0; c < columns.count; c++) {
    columns.bottom[c] = PETSC_INFINITY;
    columns.top[c]    = PETSC_NINFINITY;
  }
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  PetscCall(FindFaces(model, body, &points, &columns));
  PetscCall(CloseHoles(&columns));
  PetscCall(FindGaps(model, body, &points, &columns));
  PetscCall(Refuse(model, body, stage, &columns));
  if (columns.largest > 0.) PetscCall(Fill(model, body, &points, stage, &columns));
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  PetscCall(MpmModelSetOwn(model));
  PetscCall(PetscFree(columns.bottom));
  PetscCall(PetscFree(columns.top));
  PetscCall(PetscFree(columns.gap));
  PetscFunctionReturn(PETSC_SUCCESS);
}

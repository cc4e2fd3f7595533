/*
  Division of points whose domains have been drawn out.

  A point represents the parallelepiped with the edges 2 l_a F e_a about x. Where the longest of them exceeds the bound,
  the point becomes two, side by side along it: each at x +- (l_a/2) F e_a with half of the volume and of l_a, and with
  F, stress and state unchanged. Together they fill the old parallelepiped, so that a flow which draws points apart
  leaves no cells empty. Halves that would leave the grid stand nearer to one another.

  A point that cannot be divided again, and would become a thread across many cells, keeps its edges at the bound: the
  domain alone is cut; volume, mass, stress and history are whole. Where its law depends on F by the determinant only
  (MPM_LAW_VOLUME) and slip has made columns of F nearly parallel, F is straightened before, and so is that of points
  that are still too long after a division:

    F' = Q diag(R),   F = Q R,   columns of F by the lengths of their edges, longest first

  is a box with the longest edge, its faces and det F unchanged. Slip along that edge then does not lengthen it any
  more. With nearly parallel columns det F would be a difference of ever larger numbers.

  Ids have room between them, 2^MPM_DIVISIONS for a point, and a half takes the middle of the remaining room: ids stay
  in the range of their body and do not depend on ranks.

  Sources: Ma, Zhang, Lian and Zhou (2009), CMES 39, 101 (particles that split where they are drawn out); Sadeghirad,
  Brannon and Burghardt (2011), doi:10.1002/nme.3110 (the parallelepiped).
*/
#include "point/material.h"
#include "grid/grid.h"
#include "particles/particles.h"
#include "particles/points.h"

/* Edges over this many cells are divided once drawn out by a factor, however long they were at the start. */
typedef struct {
  PetscReal longest, drawn;
} Bound;

#define SKEWED 0.1 /* F is skewed where its determinant is less than this part of the product of its columns' lengths */

/* How often it has been divided. */
static PetscInt Divisions(const MpmPoints *points, PetscInt dim, PetscInt p)
{
  PetscInt sum = 0;

  for (PetscInt a = 0; a < dim; a++) sum += MpmPointDivisions(points, p, a);
  return sum;
}

/* An edge of a point's domain, in cells; 0 where it has hardly been drawn out. */
static PetscReal DrawnEdge(const MpmGrid *grid, const MpmPoints *points, PetscInt p, PetscInt axis, PetscReal drawn)
{
  const PetscInt dim   = grid->dim;
  PetscReal      cells = 0., stretch = 0.;

  for (PetscInt i = 0; i < dim; i++) {
    const PetscReal F = MpmPointF(points, p)[i * dim + axis];

    stretch += PetscSqr(F);
    cells += PetscSqr(2. * points->domain.half_length[p * dim + axis] * F / grid->h[i]);
  }
  return stretch > PetscSqr(drawn) ? PetscSqrtReal(cells) : 0.;
}

/* The axis of the longest of the edges that are longer than this, or -1. */
static PetscInt LongestAxis(const MpmGrid *grid, const MpmPoints *points, PetscInt p, Bound bound)
{
  PetscReal longest = bound.longest;
  PetscInt  axis    = -1;

  for (PetscInt a = 0; a < grid->dim; a++) {
    const PetscReal cells = DrawnEdge(grid, points, p, a, bound.drawn);

    if (!(cells > longest)) continue;
    longest = cells;
    axis    = a;
  }
  return axis;
}

/* The half of a point on this side; halves its extensive values. */
static void MakeHalf(const MpmGrid *grid, const MpmPoints *points, PetscInt p, PetscInt axis, PetscReal side)
{
  const PetscInt  dim    = grid->dim;
  const PetscReal by     = 0.5 * side * points->domain.half_length[p * dim + axis];
  const PetscReal radius = points->x[p * dim];
  PetscReal       way[MPM_MAX_DIM];

  for (PetscInt i = 0; i < dim; i++) {
    const PetscReal x = points->x[p * dim + i], room = PetscMin(x - grid->lower[i], grid->upper[i] - x);

    way[i] = by * MpmPointF(points, p)[i * dim + axis];
    if (PetscAbsReal(way[i]) > room) way[i] = way[i] > 0. ? room : -room;
    points->x[p * dim + i] = PetscMin(PetscMax(x + way[i], grid->lower[i]), grid->upper[i]);
  }
  if (grid->axial) { /* the outer half of a ring is the larger one */
    points->volume0[p] *= points->x[p * dim] / radius;
    if (points->mass) points->mass[p] *= points->x[p * dim] / radius;
  }
  points->x0[p * dim + axis] += by;
  if (points->origin != points->x0) points->origin[p * dim + axis] += by;
  points->domain.half_length[p * dim + axis] *= 0.5;
  if (points->domain.drawn != points->domain.half_length) points->domain.drawn[p * dim + axis] *= 0.5;
  points->domain.divisions[p] += 1 << (MPM_DIVISION_BITS * axis);
  if (points->domain.cut) points->domain.cut[p * (dim + 1) + dim] -= by * points->domain.cut[p * (dim + 1) + axis];
  if (points->domain.faces)
    points->domain.faces[p] &= ~(1 << (2 * axis + (side > 0. ? 0 : 1))); /* its other half is there */
  for (PetscInt step = 0; points->motion.increment && step < 2; step++) {
    PetscReal *increment = &points->motion.increment[p * MPM_INCREMENT(dim) + step * dim * (dim + 1)];

    for (PetscInt i = 0; i < dim; i++)
      for (PetscInt j = 0; j < dim; j++) increment[i] += increment[dim + i * dim + j] * way[j];
  }
}

/* How far the columns of F are from parallel: 1 where they are at right angles. */
static PetscReal Openness(PetscInt dim, const PetscReal F[])
{
  PetscReal product = 1.;

  for (PetscInt a = 0; a < dim; a++) {
    PetscReal square = 0.;

    for (PetscInt i = 0; i < dim; i++) square += PetscSqr(F[i * dim + a]);
    product *= square;
  }
  return MpmDeterminant(dim * dim, F) / PetscSqrtReal(product);
}

/* Axes by the lengths of their edges, longest first. */
static void SortAxes(PetscInt dim, const PetscReal F[], const PetscReal half[], PetscInt axes[])
{
  PetscReal length[MPM_MAX_DIM] = {0.};

  for (PetscInt a = 0; a < dim; a++) {
    PetscInt k = a;

    for (PetscInt i = 0; i < dim; i++) length[a] += PetscSqr(half[a] * F[i * dim + a]);
    for (; k > 0 && length[axes[k - 1]] < length[a]; k--) axes[k] = axes[k - 1];
    axes[k] = a;
  }
}

/* Removes from each column of F its component along the columns of longer edges: det F stays. */
static void Straighten(PetscInt dim, const PetscReal half[], PetscReal F[])
{
  PetscInt axes[MPM_MAX_DIM] = {0};

  SortAxes(dim, F, half, axes);
  for (PetscInt k = 1; k < dim; k++)
    for (PetscInt l = 0; l < k; l++) {
      const PetscInt a = axes[k], b = axes[l];
      PetscReal      along = 0., square = 0.;

      for (PetscInt i = 0; i < dim; i++) {
        along += F[i * dim + a] * F[i * dim + b];
        square += PetscSqr(F[i * dim + b]);
      }
      for (PetscInt i = 0; i < dim; i++) F[i * dim + a] -= along / square * F[i * dim + b];
    }
}

/* Points divided as often as allowed keep their edges at this length. */
static void CutThreads(const MpmGrid *grid, const MpmMaterial *materials, const MpmPoints *points, Bound bound)
{
  const PetscInt dim = grid->dim;

  for (PetscInt p = 0; p < points->count; p++) {
    const PetscBool last = (PetscBool)(Divisions(points, dim, p) >= MPM_DIVISIONS);
    PetscReal      *F    = MpmPointF(points, p);

    if (!last && LongestAxis(grid, points, p, bound) < 0) continue;
    if (materials[points->material[p]].info.traits & MPM_LAW_VOLUME && Openness(dim, F) <= SKEWED)
      Straighten(dim, &points->domain.half_length[p * dim], F);
    for (PetscInt a = 0; last && a < dim; a++) {
      const PetscReal cells = DrawnEdge(grid, points, p, a, bound.drawn);

      if (cells > bound.longest) points->domain.half_length[p * dim + a] *= bound.longest / cells;
    }
  }
}

PetscErrorCode MpmParticlesDivide(MpmParticles *particles, const MpmGrid *grid, const MpmMaterial *materials,
                                  PetscReal longest, PetscReal drawn, PetscInt *divided)
{
  const Bound bound = {longest, drawn};
  MpmPoints   points;
  PetscInt   *axis, *index, first;

  PetscFunctionBeginUser;
  *divided = 0;
  PetscCall(MpmParticlesGetArrays(particles, &points));
  first = points.count;
  PetscCall(PetscMalloc2(first, &axis, first, &index));
  for (PetscInt p = 0; p < first; p++) {
    if (Divisions(&points, grid->dim, p) >= MPM_DIVISIONS) continue;
    axis[*divided] = LongestAxis(grid, &points, p, bound);
    if (axis[*divided] >= 0) index[(*divided)++] = p;
  }
  PetscCall(MpmParticlesRestoreArrays(particles, &points));
  PetscCall(MpmParticlesHalve(particles, *divided, index));
  PetscCall(MpmParticlesGetArrays(particles, &points));
  for (PetscInt k = 0; k < *divided; k++) {
    points.id[first + k] += 1 << (MPM_DIVISIONS - 1 - Divisions(&points, grid->dim, index[k]));
    MakeHalf(grid, &points, index[k], axis[k], -1.);
    MakeHalf(grid, &points, first + k, axis[k], 1.);
  }
  CutThreads(grid, materials, &points, bound);
  PetscCall(MpmParticlesRestoreArrays(particles, &points));
  PetscCall(PetscFree2(axis, index));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, divided, 1, MPIU_INT, MPI_SUM, grid->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

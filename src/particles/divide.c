/*
  Points whose domains have been drawn out are divided.

  A point stands for the parallelepiped with the edges 2 l_a F e_a about x. Where the longest of them is longer than it may be, the
  point becomes two, side by side along it: each at x +- (l_a/2) F e_a with half of the volume and of l_a, and F, stress and state
  as they were. Together they fill what it filled, so that a flow which draws points apart leaves no cells without any.

  Ids have room between them, 2^MPM_DIVISIONS for a point, and a half takes the middle of the room that is left: ids stay in the
  range of their body and do not depend on ranks.

  Sources: Ma, Zhang, Lian and Zhou (2009), CMES 39, 101 (particles that split where they are drawn out); Sadeghirad, Brannon and
  Burghardt (2011), doi:10.1002/nme.3110 (the parallelepiped).
*/
#include "grid/grid.h"
#include "particles/particles.h"
#include "particles/points.h"

#define DRAWN 1.25 /* by less than this factor an edge has not been drawn out, however long it was at the start */

/* How often it has been divided. */
static PetscInt Divisions(const MpmPoints *points, PetscInt dim, PetscInt p)
{
  PetscInt sum = 0;

  for (PetscInt a = 0; a < dim; a++) sum += MpmPointDivisions(points, p, a);
  return sum;
}

/* Are both halves of a point in the grid? */
static PetscBool HalvesInGrid(const MpmGrid *grid, const MpmPoints *points, PetscInt p, PetscInt axis)
{
  const PetscInt dim = grid->dim;

  for (PetscInt i = 0; i < dim; i++) {
    const PetscReal x = points->x[p * dim + i];
    const PetscReal by =
      0.5 * PetscAbsReal(points->F[(p * dim + i) * dim + axis]) * points->half_length[p * dim + axis];

    if (!(x - by >= grid->lower[i] && x + by <= grid->upper[i])) return PETSC_FALSE;
  }
  return PETSC_TRUE;
}

/* The axis across which to divide a point, or -1. */
static PetscInt AxisToDivide(const MpmGrid *grid, const MpmPoints *points, PetscInt p, PetscReal longest)
{
  const PetscInt dim  = grid->dim;
  PetscInt       axis = -1;

  if (Divisions(points, dim, p) >= MPM_DIVISIONS) return -1;
  for (PetscInt a = 0; a < dim; a++) {
    PetscReal cells = 0., stretch = 0.;

    for (PetscInt i = 0; i < dim; i++) {
      const PetscReal F = points->F[(p * dim + i) * dim + a];

      stretch += PetscSqr(F);
      cells += PetscSqr(2. * points->half_length[p * dim + a] * F / grid->h[i]);
    }
    if (!(cells > PetscSqr(longest) && stretch > PetscSqr(DRAWN))) continue;
    longest = PetscSqrtReal(cells);
    axis    = a;
  }
  return axis >= 0 && HalvesInGrid(grid, points, p, axis) ? axis : -1;
}

/* Of a point, which has half of what it had: the half on this side. */
static void MakeHalf(const MpmPoints *points, PetscInt dim, PetscInt p, PetscInt axis, PetscReal side)
{
  const PetscReal by = 0.5 * side * points->half_length[p * dim + axis];
  PetscReal       way[MPM_MAX_DIM];

  for (PetscInt i = 0; i < dim; i++) {
    way[i] = by * points->F[(p * dim + i) * dim + axis];
    points->x[p * dim + i] += way[i];
  }
  points->x0[p * dim + axis] += by;
  points->half_length[p * dim + axis] *= 0.5;
  points->divisions[p] += 1 << (MPM_DIVISION_BITS * axis);
  if (points->cut) points->cut[p * (dim + 1) + dim] -= by * points->cut[p * (dim + 1) + axis];
  if (points->faces) points->faces[p] &= ~(1 << (2 * axis + (side > 0. ? 0 : 1))); /* its other half is there */
  for (PetscInt step = 0; points->increment && step < 2; step++) {
    PetscReal *increment = &points->increment[p * MPM_INCREMENT(dim) + step * dim * (dim + 1)];

    for (PetscInt i = 0; i < dim; i++)
      for (PetscInt j = 0; j < dim; j++) increment[i] += increment[dim + i * dim + j] * way[j];
  }
}

PetscErrorCode MpmParticlesDivide(MpmParticles *particles, const MpmGrid *grid, PetscReal longest, PetscInt *divided)
{
  MpmPoints points;
  PetscInt *axis, *index, first;

  PetscFunctionBeginUser;
  *divided = 0;
  PetscCall(MpmParticlesGetArrays(particles, &points));
  first = points.count;
  PetscCall(PetscMalloc2(first, &axis, first, &index));
  for (PetscInt p = 0; p < first; p++) {
    axis[*divided] = AxisToDivide(grid, &points, p, longest);
    if (axis[*divided] >= 0) index[(*divided)++] = p;
  }
  PetscCall(MpmParticlesRestoreArrays(particles, &points));
  PetscCall(MpmParticlesHalve(particles, *divided, index));
  PetscCall(MpmParticlesGetArrays(particles, &points));
  for (PetscInt k = 0; k < *divided; k++) {
    points.id[first + k] += 1 << (MPM_DIVISIONS - 1 - Divisions(&points, grid->dim, index[k]));
    MakeHalf(&points, grid->dim, index[k], axis[k], -1.);
    MakeHalf(&points, grid->dim, first + k, axis[k], 1.);
  }
  PetscCall(MpmParticlesRestoreArrays(particles, &points));
  PetscCall(PetscFree2(axis, index));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, divided, 1, MPIU_INT, MPI_SUM, grid->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

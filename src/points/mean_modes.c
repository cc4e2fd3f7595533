/*
  Polynomials of the means over a cell. With the points' shares w_q in its volume, phi_0 = 1, phi_1, ... are monomials
  of growing degree, made orthonormal by Gram and Schmidt over the points: sum_q w_q phi_i(q) phi_j(q) = delta_ij. The
  mean of m at a point is its projection,

    m_bar_p = sum_i phi_i(p) sum_q w_q phi_i(q) m_q .

  Elements of order p take degree p - 1, whose pair with displacements of order p is stable and as accurate as they are;
  a constant would leave volume changes that vary over a cell without any stress. Source: Boffi, Brezzi and Fortin
  (2013), Mixed Finite Element Methods and Applications, 8.6.3, doi:10.1007/978-3-642-36519-5.

  A polynomial to which fewer than two points belong is no mean: a cell takes a degree where two points belong to each
  polynomial of lower degree and to one of its own. None is taken that others make up at the cell's points.
*/
#include "points/mean_modes.h"
#include "grid/grid.h"
#include "particles/points.h"

/* Share of a polynomial's square that must remain beside those of lower degree. */
#define INDEPENDENT 1e-4

/* Degrees of the monomials along the axes, by growing total degree. Returns their number. */
static PetscInt ListMonomials(PetscInt dim, PetscInt degree, PetscInt power[][MPM_MAX_DIM])
{
  PetscInt count = 0;

  for (PetscInt total = 0; total <= degree; total++)
    for (PetscInt k = dim == MPM_MAX_DIM ? total : 0; k >= 0; k--)
      for (PetscInt j = total - k; j >= 0; j--, count++) {
        const PetscInt set[MPM_MAX_DIM] = {total - k - j, j, k};

        for (PetscInt a = 0; power && a < MPM_MAX_DIM; a++) power[count][a] = set[a];
      }
  return count;
}

/* Takes the part of phi_j from phi_i, over the points of [begin, end). */
static void Remove(const MpmSpace *space, PetscInt begin, PetscInt end, PetscInt i, PetscInt j)
{
  const MpmCells *cells   = &space->cells;
  PetscReal       product = 0.;

  for (PetscInt s = begin; s < end; s++) {
    const PetscReal *phi = &cells->mode[space->order[s] * cells->modes];

    product += cells->share[space->order[s]] * phi[i] * phi[j];
  }
  for (PetscInt s = begin; s < end; s++) {
    PetscReal *phi = &cells->mode[space->order[s] * cells->modes];

    phi[i] -= product * phi[j];
  }
}

/* sum_q w_q phi_i^2 */
static PetscReal Square(const MpmSpace *space, PetscInt begin, PetscInt end, PetscInt i)
{
  PetscReal sum = 0.;

  for (PetscInt s = begin; s < end; s++)
    sum += space->cells.share[space->order[s]] * PetscSqr(space->cells.mode[space->order[s] * space->cells.modes + i]);
  return sum;
}

/*
  Makes the monomials at the points of a cell orthonormal; those that are not independent are zero, and all those of a
  degree of which not one has two points to it: a part of a degree would depend on the order of the axes.
*/
static void Orthonormalise(const MpmSpace *space, PetscInt dim, PetscInt begin, PetscInt end)
{
  const MpmCells *cells = &space->cells;
  PetscBool       room  = PETSC_TRUE;

  for (PetscInt i = 0, kept = 0, degree = 0, behind = 0; i < cells->modes; i++) {
    const PetscReal before = Square(space, begin, end, i);
    PetscReal       after, factor = 0.;

    if (i == behind) { /* another degree */
      behind = ListMonomials(dim, degree++, NULL);
      room   = (PetscBool)(!i || 2 * (kept + 1) <= end - begin);
    }
    for (PetscInt pass = 0; pass < 2; pass++)
      for (PetscInt j = 0; j < i; j++) Remove(space, begin, end, i, j);
    after = Square(space, begin, end, i);
    if (!i || (room && after > INDEPENDENT * before)) {
      factor = 1. / PetscSqrtReal(after);
      kept++;
    }
    for (PetscInt s = begin; s < end; s++) cells->mode[space->order[s] * cells->modes + i] *= factor;
  }
}

/* Monomials of the place in its cell, -1 to 1. */
static void EvaluateMonomials(const MpmGrid *grid, const PetscReal x[], PetscInt count,
                              const PetscInt power[][MPM_MAX_DIM], PetscReal phi[])
{
  PetscInt cell[MPM_MAX_DIM];

  MpmGridFindCell(grid, x, cell);
  for (PetscInt i = 0; i < count; i++) {
    phi[i] = 1.;
    for (PetscInt a = 0; a < grid->dim; a++) {
      const PetscReal t = 2. * ((x[a] - grid->lower[a]) / grid->h[a] - (PetscReal)cell[a]) - 1.;

      for (PetscInt k = 0; k < power[i][a]; k++) phi[i] *= t;
    }
  }
}

/* w_p */
static void ShareCell(const MpmPoints *points, PetscInt begin, PetscInt end, MpmSpace *space)
{
  PetscReal total = 0.;

  for (PetscInt s = begin; s < end; s++) {
    const PetscInt p = space->order[s];

    space->cells.share[p] = points->volume0[p] * MpmPointJ(points, p);
    total += space->cells.share[p];
  }
  for (PetscInt s = begin; s < end; s++) space->cells.share[space->order[s]] /= total;
}

PetscErrorCode MpmModesMake(const MpmGrid *grid, const MpmPoints *points, MpmSpace *space)
{
  MpmCells *cells = &space->cells;
  PetscInt  power[MPM_MAX_MODES][MPM_MAX_DIM];

  PetscFunctionBeginUser;
  cells->modes = ListMonomials(grid->dim, grid->order - 1, power);
  PetscCall(PetscMalloc1(space->point_count, &cells->share));
  if (cells->modes > 1) PetscCall(PetscMalloc1((space->point_count * cells->modes), &cells->mode));
  for (PetscInt p = 0; cells->modes > 1 && p < space->point_count; p++)
    EvaluateMonomials(grid, &points->x[p * grid->dim], cells->modes, power, &cells->mode[p * cells->modes]);
  for (PetscInt c = 0; c < cells->count; c++) {
    const PetscInt begin = space->groups[cells->at[c].group_begin].point_begin;
    const PetscInt end   = space->groups[cells->at[c].group_end - 1].point_end;

    ShareCell(points, begin, end, space);
    if (cells->modes > 1) Orthonormalise(space, grid->dim, begin, end);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

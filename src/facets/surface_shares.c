/*
  The surface of a boundary, divided among the points beside it.

  Material in contact with a bilateral boundary may flow along it without bound. The faces that bounded the material at
  the start are drawn out before a pipe that is pulled through clay, and crowd behind it, until others lie at the
  surface. Where the surface cut the lattice of points, whose faces do not follow it anyway, the facets are therefore
  pieces of the surface itself. A piece is the portion nearest to a point: its area A, its middle y, and its normal.

  The surface is sampled on a lattice with DIVISIONS a cell: a place x at the distance d, on either side, represents the
  area

    dA = delta(d) det(I - d grad n) dV   at   x - d n ,   delta(d) = (1 + cos(pi d/eps))/(2 eps) ,  |d| < eps

  with eps twice the lattice's spacing along n, sum_a |n_a| dx_a. The areas change smoothly as the surface moves through
  the lattice.

  Sources: Engquist, Tornberg and Tsai (2005), doi:10.1016/j.jcp.2004.09.018; Kublik, Tanushev and Tsai (2013),
  doi:10.1016/j.jcp.2013.03.049.
*/
#include "geometry/geometry.h"
#include "grid/grid.h"
#include "particles/points.h"
#include "selection/air_points.h"
#include "space/rules.h"
#include "space/space.h"
#include "facets/facets.h"

#define DIVISIONS 4  /* samples a cell and axis */
#define WIDTH     2. /* eps over the samples' spacing */
#define NEAR \
  3. /* of a whole point's half-length, but no more than a cell: so near the surface a point may have a share */
#define AROUND 2 /* cells about a point's, in which samples of its share may lie */

/* A point that may have a share. */
typedef struct {
  PetscReal  x[MPM_MAX_DIM], near;
  PetscInt64 cell;
  PetscInt   id, point; /* point: -1 on another rank */
} Candidate;

/* Values of a point: area, and area times place. */
typedef struct {
  PetscReal area, moment[MPM_MAX_DIM];
} Share;

typedef struct {
  const MpmFacets *facets;
  const MpmGrid   *grid;
  PetscInt         boundary, count, own;
  Candidate       *candidate;
  Share           *share; /* of the own ones, by point */
} Shares;

/* Cells are numbered with a rim around the grid, where samples of the surface inside may lie. */
static PetscInt64 Number(const MpmGrid *grid, const PetscInt cell[])
{
  PetscInt64 number = 0;

  for (PetscInt a = grid->dim - 1; a >= 0; a--) number = number * (grid->cells[a] + 2 * AROUND) + cell[a] + AROUND;
  return number;
}

static void CellOf(const MpmGrid *grid, PetscInt64 number, PetscInt cell[])
{
  for (PetscInt a = 0; a < grid->dim; a++) {
    const PetscInt64 cells = grid->cells[a] + 2 * AROUND;

    cell[a] = (PetscInt)(number % cells) - AROUND;
    number /= cells;
  }
}

static int CompareCandidates(const void *a, const void *b)
{
  const Candidate *p = (const Candidate *)a, *q = (const Candidate *)b;

  if (p->cell != q->cell) return p->cell < q->cell ? -1 : 1;
  return p->id < q->id ? -1 : p->id > q->id;
}

static int CompareCells(const void *a, const void *b)
{
  const PetscInt64 p = *(const PetscInt64 *)a, q = *(const PetscInt64 *)b;

  return p < q ? -1 : p > q;
}

/* The points beside the surface, of this rank and those that are rivals on others, by cells. */
static PetscErrorCode FindCandidates(Shares *shares, const MpmMaterial *materials, const MpmPoints *points)
{
  const MpmGrid     *grid     = shares->grid;
  const MpmBoundary *boundary = &shares->facets->boundaries[shares->boundary];
  const PetscInt     dim      = grid->dim;
  PetscInt          *boxes, cell[MPM_MAX_DIM];

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(points->count, &shares->candidate));
  for (PetscInt p = 0; p < points->count; p++) {
    Candidate *candidate = &shares->candidate[shares->count];
    MpmSurface surface;

    if (MpmPointIsAir(materials, points, p)) continue;
    if (!MpmRegionContains(boundary->region, &points->origin[p * dim])) continue;
    *candidate = (Candidate){.near = 0., .id = points->id[p], .point = p};
    for (PetscInt a = 0; a < dim; a++) {
      candidate->x[a] = points->x[p * dim + a];
      candidate->near = PetscMax(candidate->near, NEAR * MpmPointHalfWhole(points, dim, p, a));
    }
    candidate->near = PetscMin(candidate->near, shares->facets->cell);
    MpmFacetsDistance(shares->facets, shares->boundary, candidate->x, &surface);
    if (PetscAbsReal(surface.distance) > candidate->near) continue;
    MpmGridFindCell(grid, candidate->x, cell);
    candidate->cell = Number(grid, cell);
    shares->count++;
  }
  shares->own = shares->count;
  PetscCall(PetscCalloc1((2 * MPM_MAX_DIM * shares->count), &boxes));
  for (PetscInt k = 0; k < shares->count; k++) {
    MpmGridFindCell(grid, shares->candidate[k].x, cell);
    for (PetscInt a = 0; a < dim; a++) {
      boxes[2 * MPM_MAX_DIM * k + a]               = PetscMax(cell[a] - AROUND - 1, 0);
      boxes[2 * MPM_MAX_DIM * k + MPM_MAX_DIM + a] = PetscMin(cell[a] + AROUND + 2, grid->cells[a]);
    }
  }
  PetscCall(MpmGridShare(grid, sizeof(Candidate), boxes, &shares->count, (void **)&shares->candidate));
  for (PetscInt k = shares->own; k < shares->count; k++) shares->candidate[k].point = -1;
  PetscCall(PetscFree(boxes));
  qsort(shares->candidate, (size_t)shares->count, sizeof(Candidate), CompareCandidates);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The first candidate that is not before a cell. */
static PetscInt FirstOf(const Shares *shares, PetscInt64 cell)
{
  PetscInt low = 0, high = shares->count;

  while (low < high) {
    const PetscInt middle = (low + high) / 2;

    if (shares->candidate[middle].cell < cell) low = middle + 1;
    else high = middle;
  }
  return low;
}

/* The candidate nearest to a place in a cell, or NULL. */
static const Candidate *Nearest(const Shares *shares, const PetscReal y[])
{
  const PetscInt   dim               = shares->grid->dim;
  const Candidate *best              = NULL;
  PetscReal        least             = PETSC_INFINITY;
  PetscInt         cell[MPM_MAX_DIM] = {0, 0, 0}, at[MPM_MAX_DIM];

  MpmGridFindCell(shares->grid, y, cell);
  for (PetscInt k = 0; k < PetscPowInt(3, dim); k++) {
    PetscInt64 number;

    for (PetscInt a = 0, rest = k; a < dim; a++, rest /= 3) at[a] = cell[a] + rest % 3 - 1;
    number = Number(shares->grid, at);
    for (PetscInt c = FirstOf(shares, number); c < shares->count && shares->candidate[c].cell == number; c++) {
      const Candidate *candidate = &shares->candidate[c];
      PetscReal        square    = 0.;

      for (PetscInt a = 0; a < dim; a++) square += PetscSqr(candidate->x[a] - y[a]);
      if (square > PetscSqr(candidate->near) || square > least) continue;
      if (square == least && best && best->id < candidate->id) continue;
      least = square;
      best  = candidate;
    }
  }
  return best;
}

/* The area that a sample stands for, at the place y of the surface; 0 where it is too far off. */
static PetscReal SampleArea(const Shares *shares, const PetscReal x[], const PetscReal spacing[], PetscReal y[])
{
  const PetscInt dim = shares->grid->dim;
  PetscReal      M[MPM_MAX_DIM * MPM_MAX_DIM], width = 0., area = 1.;
  MpmSurface     surface;

  MpmFacetsDistance(shares->facets, shares->boundary, x, &surface);
  for (PetscInt a = 0; a < dim; a++) width += WIDTH * PetscAbsReal(surface.normal[a]) * spacing[a];
  if (PetscAbsReal(surface.distance) >= width) return 0.;
  for (PetscInt a = 0; a < dim; a++) {
    y[a] = x[a] - surface.distance * surface.normal[a];
    area *= spacing[a];
    if (!(y[a] >= shares->grid->lower[a] && y[a] <= shares->grid->upper[a])) return 0.;
    for (PetscInt c = 0; c < dim; c++) M[a * dim + c] = (a == c ? 1. : 0.) - surface.distance * surface.second[a][c];
  }
  return PetscMax(MpmDeterminant(dim * dim, M), 0.) * area * (1. + cos(PETSC_PI * surface.distance / width)) /
         (2. * width);
}

/* Adds the samples of a cell to the shares of the points. */
static void SampleCell(Shares *shares, const PetscInt cell[])
{
  const MpmGrid *grid  = shares->grid;
  const PetscInt dim   = grid->dim;
  PetscReal      reach = 0., spacing[MPM_MAX_DIM], x[MPM_MAX_DIM] = {0., 0., 0.}, y[MPM_MAX_DIM] = {0., 0., 0.};
  MpmSurface     surface;

  for (PetscInt a = 0; a < dim; a++) {
    spacing[a] = grid->h[a] / DIVISIONS;
    x[a]       = grid->lower[a] + ((PetscReal)cell[a] + 0.5) * grid->h[a];
    reach += (0.5 * DIVISIONS + WIDTH) * spacing[a];
  }
  MpmFacetsDistance(shares->facets, shares->boundary, x, &surface);
  if (PetscAbsReal(surface.distance) > reach) return;
  for (PetscInt k = 0; k < PetscPowInt(DIVISIONS, dim); k++) {
    const Candidate *nearest;
    PetscReal        area;

    for (PetscInt a = 0, rest = k; a < dim; a++, rest /= DIVISIONS)
      x[a] = grid->lower[a] + (PetscReal)cell[a] * grid->h[a] + ((PetscReal)(rest % DIVISIONS) + 0.5) * spacing[a];
    area    = SampleArea(shares, x, spacing, y);
    nearest = area > 0. ? Nearest(shares, y) : NULL;
    if (!nearest || nearest->point < 0) continue;
    shares->share[nearest->point].area += area;
    for (PetscInt a = 0; a < dim; a++) shares->share[nearest->point].moment[a] += area * y[a];
  }
}

/* All cells about those of the own candidates, each once, in ascending order. */
static PetscErrorCode Sample(Shares *shares)
{
  const PetscInt dim = shares->grid->dim, around = PetscPowInt(2 * AROUND + 1, dim);
  PetscInt64    *cells, last                     = -1;
  PetscInt       count = 0, cell[MPM_MAX_DIM], at[MPM_MAX_DIM];

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1((shares->own * around), &cells));
  for (PetscInt k = 0; k < shares->count; k++) {
    if (shares->candidate[k].point < 0 || shares->candidate[k].cell == last) continue;
    last = shares->candidate[k].cell;
    CellOf(shares->grid, last, cell);
    for (PetscInt n = 0; n < around; n++) {
      for (PetscInt a = 0, rest = n; a < dim; a++, rest /= 2 * AROUND + 1)
        at[a] = cell[a] + rest % (2 * AROUND + 1) - AROUND;
      cells[count++] = Number(shares->grid, at);
    }
  }
  qsort(cells, (size_t)count, sizeof(PetscInt64), CompareCells);
  for (PetscInt k = 0; k < count; k++) {
    if (k && cells[k] == cells[k - 1]) continue;
    CellOf(shares->grid, cells[k], cell);
    SampleCell(shares, cell);
  }
  PetscCall(PetscFree(cells));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmFacetsAddShares(MpmFacets *facets, PetscInt boundary, const MpmRules *rules, const MpmSpace *space,
                                  const MpmPoints *points)
{
  const MpmGrid *grid   = rules->grid;
  const PetscInt dim    = grid->dim;
  Shares         shares = {.facets = facets, .grid = grid, .boundary = boundary};

  PetscFunctionBeginUser;
  PetscCall(FindCandidates(&shares, rules->materials, points));
  PetscCall(PetscCalloc1(points->count, &shares.share));
  PetscCall(Sample(&shares));
  for (PetscInt g = 0; g < space->group_count; g++) {
    for (PetscInt s = space->groups[g].point_begin; s < space->groups[g].point_end; s++) {
      const PetscInt p     = space->order[s];
      const Share   *share = &shares.share[p];
      MpmFacet       facet = {.boundary = boundary, .point = p, .group = g, .area = share->area};
      MpmSurface     surface;

      if (!(share->area > 0.)) continue;
      for (PetscInt a = 0; a < dim; a++) facet.place[a] = share->moment[a] / share->area;
      MpmFacetsDistance(facets, boundary, facet.place, &surface);
      for (PetscInt a = 0; a < dim; a++) {
        facet.normal[a] = surface.normal[a];
        facet.place[a] -= surface.distance * surface.normal[a];
      }
      facet.key.cell = MpmFacetCell(grid, &points->x[p * dim], points->domain.part ? points->domain.part[p] : 0);
      PetscCall(MpmFacetsAdd(facets, &facet));
    }
  }
  PetscCall(PetscFree(shares.share));
  PetscCall(PetscFree(shares.candidate));
  PetscFunctionReturn(PETSC_SUCCESS);
}

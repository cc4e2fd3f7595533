/*
  Background stiffness: linear elasticity of the grid's cells in a region, beside the material and where there is none,

    E = sum_cells int_cell 1/2 eps(U) : C : eps(U) dV ,    U = U_n + u ,

  with u the step's increment and U_n the displacement that each node has had so far. Cells of a grid that moves with
  the material have the size with which they were read: a closed loop of the nodes leaves no stress.

  The shape functions are those of the grid at Gauss points. The matrix of a cell is made of products over the
  axes of one-dimensional matrices int N_i N_j, int N_i' N_j and int N_i' N_j'. Other fields than the displacement are
  zero at nodes that no point touches.

  A node's displacement belongs to its owner. The partition follows the points, so that displacements go to their
  nodes' owners before each step.

  Source of the use, soft stiffness in place of void: Duster, Parvizian, Yang and Rank (2008), Comput. Methods Appl.
  Mech. Engrg. 197, 3768-3782, doi:10.1016/j.cma.2008.02.036.
*/
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include "point/layout.h"
#include "grid/grid.h"
#include "space/rules.h"
#include "space/space.h"
#include "space/sum.h"
#include "assembly/sparsity.h"
#include "volume/background.h"

#define NODES  5 /* of a cell along an axis, at most: quadratic splines have knots in the middle of cells */
#define PLACES 6 /* Gauss points along an axis, at most */
#define DEGREE 4 /* of the shape functions, at most */

/* Gauss points and weights on [-1, 1] */
static const PetscReal gauss[DEGREE][DEGREE + 1] = {
  {-0.5773502691896257, 0.5773502691896257},
  {-0.7745966692414834, 0., 0.7745966692414834},
  {-0.8611363115940526, -0.3399810435848563, 0.3399810435848563, 0.8611363115940526},
  {-0.9061798459386640, -0.5384693101056831, 0., 0.5384693101056831, 0.9061798459386640}};
static const PetscReal weight[DEGREE][DEGREE + 1] = {
  {1., 1.},
  {0.5555555555555556, 0.8888888888888888, 0.5555555555555556},
  {0.3478548451374538, 0.6521451548625461, 0.6521451548625461, 0.3478548451374538},
  {0.2369268850561891, 0.4786286704993665, 0.5688888888888889, 0.4786286704993665, 0.2369268850561891}};

/* Nodes of a cell along an axis and their matrices. */
typedef struct {
  PetscInt  first, count;
  PetscReal mass[NODES * NODES], mixed[NODES * NODES], slope[NODES * NODES]; /* N N, N' N, N' N' */
} Line;

struct MpmCellKind {
  PetscInt   background, nodes;
  Line       lines[MPM_MAX_DIM]; /* `first` unset */
  PetscReal *matrix;
};

/* Of cell `cell` along axis a, between the edges. */
static void LineOf(const MpmRules *rules, PetscInt a, PetscInt cell, PetscInt lower, PetscInt upper, Line *line)
{
  const PetscInt  degree = MpmShapeDegree(rules->shape), n = degree + 1;
  const PetscInt  parts = degree % 2 || MpmShapeOrder(rules->shape) > 1 ? 1 : 2;
  const PetscReal h     = rules->grid->start_h[a];
  PetscReal       w[PLACES][MPM_MAX_WIDTH], g[PLACES][MPM_MAX_WIDTH], dV[PLACES];
  PetscInt        first[PLACES], count[PLACES], last = 0;

  *line = (Line){.first = PETSC_INT_MAX};
  for (PetscInt q = 0; q < parts * n; q++) {
    MpmShapeLine    at   = {.weight = w[q], .gradient = g[q]};
    const PetscReal half = 0.5 / (PetscReal)parts;

    dV[q] = half * h * weight[degree - 1][q % n];
    MpmShapeEvaluate(rules->shape, rules->edge,
                     (PetscReal)cell + half * ((PetscReal)(2 * (q / n) + 1) + gauss[degree - 1][q % n]), 0., lower,
                     upper, &at);
    first[q]    = at.first;
    count[q]    = at.count;
    line->first = PetscMin(line->first, at.first);
    last        = PetscMax(last, at.first + at.count);
  }
  line->count = last - line->first;
  for (PetscInt q = 0; q < parts * n; q++) {
    for (PetscInt i = 0; i < count[q]; i++) {
      for (PetscInt j = 0; j < count[q]; j++) {
        const PetscInt k = (i + first[q] - line->first) * line->count + j + first[q] - line->first;

        line->mass[k] += dV[q] * w[q][i] * w[q][j];
        line->mixed[k] += dV[q] / h * g[q][i] * w[q][j];
        line->slope[k] += dV[q] / (h * h) * g[q][i] * g[q][j];
      }
    }
  }
}

/* The lines of a cell. */
static void LinesOf(const MpmRules *rules, const PetscInt cell[], Line lines[])
{
  const MpmGrid *grid               = rules->grid;
  PetscInt       lower[MPM_MAX_DIM] = {0}, upper[MPM_MAX_DIM] = {0};
  PetscReal      x[MPM_MAX_DIM];

  for (PetscInt a = 0; a < grid->dim; a++) x[a] = grid->lower[a] + grid->h[a] * ((PetscReal)cell[a] + 0.5);
  MpmSpaceEdges(rules, x, lower, upper);
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    if (a < grid->dim) LineOf(rules, a, cell[a], lower[a], upper[a], &lines[a]);
    else lines[a] = (Line){.count = 1, .mass = {1.}};
  }
}

/* int N_i,a N_j,b */
static PetscReal Product(PetscInt dim, const Line lines[], PetscInt i, PetscInt j, PetscInt a, PetscInt b)
{
  PetscReal value = 1.;

  for (PetscInt c = 0; c < dim; c++) {
    const Line    *line = &lines[c];
    const PetscInt n = line->count, k = i % n, l = j % n;

    if (a == b) value *= c == a ? line->slope[k * n + l] : line->mass[k * n + l];
    else value *= c == a ? line->mixed[k * n + l] : c == b ? line->mixed[l * n + k] : line->mass[k * n + l];
    i /= n;
    j /= n;
  }
  return value;
}

/* Stiffness of a cell: component c of node i by component d of node j at [((i*dim + c)*dim + d)*n + j]. */
static void CellMatrix(PetscInt dim, PetscInt n, const Line lines[], const MpmBackground *background,
                       PetscReal matrix[])
{
  for (PetscInt i = 0; i < n; i++) {
    for (PetscInt j = 0; j < n; j++) {
      PetscReal D[MPM_MAX_DIM][MPM_MAX_DIM], trace = 0.;

      for (PetscInt a = 0; a < dim; a++)
        for (PetscInt b = 0; b < dim; b++) D[a][b] = Product(dim, lines, i, j, a, b);
      for (PetscInt a = 0; a < dim; a++) trace += D[a][a];
      for (PetscInt c = 0; c < dim; c++)
        for (PetscInt d = 0; d < dim; d++)
          matrix[((i * dim + c) * dim + d) * n + j] =
            background->lambda * D[c][d] + background->mu * (D[d][c] + (c == d ? trace : 0.));
    }
  }
}

/* ---- the term ---- */

PetscErrorCode MpmBackgroundCellsList(const MpmBackground *background, const MpmGrid *grid, PetscInt *count,
                                      PetscInt cells[])
{
  PetscInt  first[MPM_MAX_DIM] = {0, 0, 0}, end[MPM_MAX_DIM] = {1, 1, 1}, cell[MPM_MAX_DIM];
  PetscReal lower[MPM_MAX_DIM], upper[MPM_MAX_DIM], x[MPM_MAX_DIM] = {0.};

  PetscFunctionBeginUser;
  PetscCall(PetscArraycpy(lower, grid->start_lower, MPM_MAX_DIM));
  PetscCall(PetscArraycpy(upper, grid->start_upper, MPM_MAX_DIM));
  PetscCall(MpmRegionGetBounds(background->region, lower, upper));
  for (PetscInt a = 0; a < grid->dim; a++) {
    first[a] = PetscMax((PetscInt)PetscFloorReal((lower[a] - grid->start_lower[a]) / grid->start_h[a]) - 1, 0);
    end[a] =
      PetscMin((PetscInt)PetscCeilReal((upper[a] - grid->start_lower[a]) / grid->start_h[a]) + 1, grid->cells[a]);
  }
  *count = 0;
  for (cell[2] = first[2]; cell[2] < end[2]; cell[2]++) {
    for (cell[1] = first[1]; cell[1] < end[1]; cell[1]++) {
      for (cell[0] = first[0]; cell[0] < end[0]; cell[0]++) {
        for (PetscInt a = 0; a < grid->dim; a++)
          x[a] = grid->start_lower[a] + grid->start_h[a] * ((PetscReal)cell[a] + 0.5);
        if (!MpmRegionContains(background->region, x)) continue;
        if (grid->splits && MpmGridCellOwner(grid, cell) != grid->rank) continue;
        if (cells) PetscCall(PetscArraycpy(&cells[*count * MPM_MAX_DIM], cell, MPM_MAX_DIM));
        ++*count;
      }
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmBackgroundKindsDestroy(MpmBackgrounds *all)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < all->kind_count; k++) PetscCall(PetscFree(all->kind[k].matrix));
  PetscCall(PetscFree(all->kind));
  all->kind_count = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscBool SameLines(const Line one[], const Line other[])
{
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++)
    if (one[a].count != other[a].count || memcmp(one[a].mass, other[a].mass, sizeof(Line) - offsetof(Line, mass)))
      return PETSC_FALSE;
  return PETSC_TRUE;
}

/* Place of the kind of a cell among them; a new one is added. */
static PetscErrorCode FindKind(MpmBackgrounds *all, PetscInt background, PetscInt dim, const Line lines[],
                               PetscInt *place)
{
  struct MpmCellKind *kind;
  PetscInt            n = 1;

  PetscFunctionBeginUser;
  for (*place = all->kind_count - 1; *place >= 0; --*place)
    if (all->kind[*place].background == background && SameLines(all->kind[*place].lines, lines))
      PetscFunctionReturn(PETSC_SUCCESS);
  *place = all->kind_count++;
  PetscCall(PetscRealloc((size_t)all->kind_count * sizeof(*kind), &all->kind));
  kind = &all->kind[*place];
  for (PetscInt a = 0; a < MPM_MAX_DIM; n *= lines[a].count, a++) kind->lines[a] = lines[a];
  kind->background = background;
  kind->nodes      = n;
  PetscCall(PetscMalloc1((size_t)(n * n * dim * dim), &kind->matrix));
  CellMatrix(dim, n, lines, &all->at[background], kind->matrix);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Boxes(void *ctx, const MpmRules *rules, const MpmPoints *points, MpmSpace *space)
{
  MpmBackgrounds     *all   = (MpmBackgrounds *)ctx;
  MpmBackgroundCells *cells = &all->cells;
  PetscInt           *count, *cell;
  MpmGroup           *boxes;
  Line                lines[MPM_MAX_DIM];

  PetscFunctionBeginUser;
  (void)points;
  *cells = (MpmBackgroundCells){.begin = space->boxes.count, .kind = cells->kind};
  PetscCall(PetscMalloc1(all->count, &count));
  for (PetscInt k = 0; k < all->count; cells->count += count[k], k++)
    PetscCall(MpmBackgroundCellsList(&all->at[k], rules->grid, &count[k], NULL));
  PetscCall(PetscMalloc1(cells->count * MPM_MAX_DIM, &cell));
  PetscCall(PetscFree(cells->kind));
  PetscCall(PetscMalloc1(cells->count, &cells->kind));
  PetscCall(MpmBackgroundKindsDestroy(all));
  PetscCall(MpmSpaceAppendBoxes(space, cells->count, &boxes));
  for (PetscInt k = 0, i = 0; k < all->count; k++) {
    PetscCall(MpmBackgroundCellsList(&all->at[k], rules->grid, &count[k], &cell[i * MPM_MAX_DIM]));
    for (const PetscInt end = i + count[k]; i < end; i++) {
      LinesOf(rules, &cell[i * MPM_MAX_DIM], lines);
      PetscCall(FindKind(all, k, space->dim, lines, &cells->kind[i]));
      boxes[i].node_count = all->kind[cells->kind[i]].nodes;
      for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
        boxes[i].first[a] = lines[a].first;
        boxes[i].count[a] = lines[a].count;
      }
    }
  }
  PetscCall(PetscFree(cell));
  PetscCall(PetscFree(count));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Displacements to the owners of their nodes, by the present partition. */
static PetscErrorCode ToOwners(MpmBackgrounds *all, const MpmGrid *grid)
{
  PetscInt *boxes, kept = 0;

  PetscFunctionBeginUser;
  if (grid->size == 1) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1((2 * MPM_MAX_DIM * all->way_count), &boxes));
  for (PetscInt k = 0; k < 2 * all->way_count; k++)
    for (PetscInt a = 0; a < MPM_MAX_DIM; a++)
      boxes[k * MPM_MAX_DIM + a] = all->way[k / 2].node[a] / PetscMax(grid->order, 1); /* vertices */
  PetscCall(MpmGridShare(grid, sizeof(*all->way), boxes, &all->way_count, (void **)&all->way));
  PetscCall(PetscFree(boxes));
  for (PetscInt k = 0; k < all->way_count; k++)
    if (MpmGridNodeOwner(grid, all->way[k].node) == grid->rank) all->way[kept++] = all->way[k];
  all->way_count = kept;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Order of nodes in the lattice. */
static int CompareWays(const void *one, const void *other)
{
  const PetscInt *a = ((const MpmNodeWay *)one)->node, *b = ((const MpmNodeWay *)other)->node;

  for (PetscInt k = MPM_MAX_DIM - 1; k >= 0; k--)
    if (a[k] != b[k]) return a[k] < b[k] ? -1 : 1;
  return 0;
}

static MpmNodeWay *FindWay(const MpmBackgrounds *all, const PetscInt node[], PetscInt dim)
{
  MpmNodeWay at = {{0}, {0.}};

  for (PetscInt a = 0; a < dim; a++) at.node[a] = node[a];
  return all->way_count ? (MpmNodeWay *)bsearch(&at, all->way, (size_t)all->way_count, sizeof(*all->way), CompareWays)
                        : NULL;
}

/* Marks the nodes that points of any rank touch. */
static PetscErrorCode MarkTouched(const MpmSpace *space, PetscReal touch[])
{
  PetscFunctionBeginUser;
  for (PetscInt g = 0; g < space->group_count; g++) {
    const MpmGroup *group = &space->groups[g];

    if (group->point_begin == group->point_end) continue;
    for (PetscInt i = 0; i < group->node_count; i++)
      if (space->group_nodes[group->node_offset + i] >= 0) touch[space->group_nodes[group->node_offset + i]] = 1.;
  }
  PetscCall(MpmSpaceAddToOwners(space, 1, touch));
  PetscCall(MpmSpaceToGhosts(space, 1, touch));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Prepare(void *ctx, const MpmTermStep *step)
{
  MpmBackgrounds *all   = (MpmBackgrounds *)ctx;
  const MpmSpace *space = step->sum->space;
  const PetscInt  dim   = space->dim;

  PetscFunctionBeginUser;
  PetscCall(ToOwners(all, step->rules->grid));
  if (all->way_count) qsort(all->way, (size_t)all->way_count, sizeof(*all->way), CompareWays);
  PetscCall(PetscFree2(all->u_n, all->touch));
  PetscCall(PetscCalloc2((space->local * dim), &all->u_n, space->local, &all->touch));
  for (PetscInt i = 0; i < space->owned; i++) {
    const MpmNodeWay *way = MpmSpaceIsExtra(space, i) ? NULL : FindWay(all, &space->node[i * dim], dim);

    for (PetscInt a = 0; way && a < dim; a++) all->u_n[i * dim + a] = way->u[a];
  }
  PetscCall(MpmSpaceToGhosts(space, dim, all->u_n));
  PetscCall(MarkTouched(space, all->touch));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Stiffness of other fields at a node of a cell that no point touches. */
static PetscReal Hold(const struct MpmCellKind *kind, PetscInt i, PetscInt dim)
{
  return kind->matrix[i * dim * dim * kind->nodes + i];
}

/* y += K (u + `rest` U_n), with du in place of u for the action. */
static void AddForces(const MpmBackgrounds *all, const MpmSum *sum, const PetscReal u[], PetscReal rest, PetscReal y[])
{
  const MpmSpace *space = sum->space;
  const PetscInt  bs = sum->block, dim = space->dim;

  for (PetscInt k = 0; k < all->cells.count; k++) {
    const struct MpmCellKind *kind  = &all->kind[all->cells.kind[k]];
    const PetscInt            n     = kind->nodes;
    const PetscInt           *nodes = &space->group_nodes[space->groups[all->cells.begin + k].node_offset];

    for (PetscInt i = 0; i < n; i++) {
      for (PetscInt c = 0; c < dim; c++) {
        PetscReal force = 0.;

        for (PetscInt d = 0; d < dim; d++) {
          const PetscReal *row = &kind->matrix[((i * dim + c) * dim + d) * n];

          for (PetscInt j = 0; j < n; j++)
            force += row[j] * (u[nodes[j] * bs + d] + rest * all->u_n[nodes[j] * dim + d]);
        }
        y[nodes[i] * bs + c] += force;
      }
      for (PetscInt c = dim; c < bs && all->touch[nodes[i]] == 0.; c++)
        y[nodes[i] * bs + c] += Hold(kind, i, dim) * u[nodes[i] * bs + c];
    }
  }
}

static PetscErrorCode Residual(const void *ctx, const MpmSum *sum, const PetscReal u[], PetscReal residual[],
                               PetscInt *failed)
{
  PetscFunctionBeginUser;
  (void)failed;
  AddForces((const MpmBackgrounds *)ctx, sum, u, 1., residual);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Apply(const void *ctx, const MpmSum *sum, const PetscReal u[], const PetscReal du[],
                            PetscReal y[])
{
  PetscFunctionBeginUser;
  (void)u;
  AddForces((const MpmBackgrounds *)ctx, sum, du, 0., y);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Tangent(const void *ctx, const MpmSum *sum, const PetscReal u[], MpmPattern *pattern,
                              PetscReal residual[], PetscInt *failed)
{
  const MpmBackgrounds *all   = (const MpmBackgrounds *)ctx;
  const MpmSpace       *space = sum->space;
  const PetscInt        bs = sum->block, dim = space->dim, most = PetscPowInt(NODES, dim) * bs;
  PetscReal            *element;

  PetscFunctionBeginUser;
  if (residual) PetscCall(Residual(ctx, sum, u, residual, failed));
  PetscCall(PetscMalloc1((size_t)most * (size_t)most, &element));
  for (PetscInt k = 0; k < all->cells.count; k++) {
    const struct MpmCellKind *kind  = &all->kind[all->cells.kind[k]];
    const PetscInt            n     = kind->nodes;
    const MpmGroup           *box   = &space->groups[all->cells.begin + k];
    const PetscInt           *nodes = &space->group_nodes[box->node_offset];

    PetscCall(PetscArrayzero(element, n * n * bs * bs));
    for (PetscInt i = 0; i < n; i++) {
      for (PetscInt c = 0; c < dim; c++)
        for (PetscInt d = 0; d < dim; d++)
          PetscCall(
            PetscArraycpy(&element[((i * bs + c) * bs + d) * n], &kind->matrix[((i * dim + c) * dim + d) * n], n));
      for (PetscInt c = dim; c < bs && all->touch[nodes[i]] == 0.; c++)
        element[((i * bs + c) * bs + c) * n + i] = Hold(kind, i, dim);
    }
    MpmPatternAddBlock(pattern, space, box, element);
  }
  PetscCall(PetscFree(element));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Keeps the displacements at the step's end. */
static PetscErrorCode Commit(void *ctx, const MpmSum *sum, const PetscReal u[], MpmParticles *particles)
{
  MpmBackgrounds *all   = (MpmBackgrounds *)ctx;
  const MpmSpace *space = sum->space;
  const PetscInt  bs = sum->block, dim = space->dim;
  PetscInt        added = 0;

  PetscFunctionBeginUser;
  (void)particles;
  PetscCall(PetscRealloc((size_t)(all->way_count + space->owned) * sizeof(*all->way), &all->way));
  for (PetscInt i = 0; i < space->owned; i++) {
    MpmNodeWay *way = MpmSpaceIsExtra(space, i) ? NULL : FindWay(all, &space->node[i * dim], dim);

    if (MpmSpaceIsExtra(space, i)) continue;
    if (!way) {
      way  = &all->way[all->way_count + added++];
      *way = (MpmNodeWay){{0}, {0.}};
      PetscCall(PetscArraycpy(way->node, &space->node[i * dim], dim));
    }
    for (PetscInt a = 0; a < dim; a++) way->u[a] += u[i * bs + a];
  }
  all->way_count += added;
  PetscFunctionReturn(PETSC_SUCCESS);
}

const MpmTerm MpmTermBackground = {.name             = "background",
                                   .boxes            = Boxes,
                                   .prepare          = Prepare,
                                   .residual         = Residual,
                                   .tangent          = Tangent,
                                   .apply            = Apply,
                                   .energy.quadratic = MpmTermIsQuadratic,
                                   .step.commit      = Commit};

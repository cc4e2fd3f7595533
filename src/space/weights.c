/*
  Weights of every point with the shapes of the physics' fields.

  A field may have splines of another degree than the scene's shape, or nodes on a coarser lattice: of spacing r, whose
  nodes are those of the grid with indices that are multiples of r. Weights of such a shape are spread over the grid's
  nodes, with zeros between, and all shapes of a point over the smallest box that holds the nodes of each.
*/
#include "base/outcome.h"
#include "point/fluid_stretch.h"
#include "point/layout.h"
#include "grid/grid.h"
#include "grid/walls.h"
#include "particles/points.h"
#include "space/rules.h"
#include "space/space.h"

/* True where a wall, which goes with the grid, stands beside this point: the point projects into the wall's extent. */
static PetscBool WallFaces(const MpmWall *wall, const MpmGrid *grid, const PetscReal x[])
{
  PetscReal start[MPM_MAX_DIM];

  MpmGridAtStart(grid, x, start);
  for (PetscInt a = 0; a < grid->dim; a++) {
    if (a != wall->axis && (start[a] < wall->lower[a] || start[a] > wall->upper[a])) return PETSC_FALSE;
  }
  return PETSC_TRUE;
}

void MpmSpaceEdges(const MpmRules *rules, const PetscReal x[], PetscInt lower[], PetscInt upper[])
{
  const MpmGrid *grid  = rules->grid;
  const MpmWall *walls = rules->walls.at;

  for (PetscInt a = 0; a < grid->dim; a++) {
    lower[a] = 0;
    upper[a] = grid->cells[a];
  }
  for (PetscInt w = 0; w < rules->walls.count; w++) {
    const PetscInt  a  = walls[w].axis;
    const PetscReal xi = (x[a] - grid->lower[a]) / grid->h[a];

    if (walls[w].side > 0) {
      if (xi >= (PetscReal)walls[w].node && walls[w].node > lower[a] && WallFaces(&walls[w], grid, x))
        lower[a] = walls[w].node;
    } else {
      if (xi <= (PetscReal)walls[w].node && walls[w].node < upper[a] && WallFaces(&walls[w], grid, x))
        upper[a] = walls[w].node;
    }
  }
}

/* A half-length in cells, clipped. */
static inline PetscReal Clipped(const MpmRules *rules, PetscReal l, PetscReal xi, PetscInt lower, PetscInt upper)
{
  const PetscReal room = PetscMin(xi - (PetscReal)lower, (PetscReal)upper - xi);

  return PetscMax(PetscMin(rules->longest > 0. ? PetscMin(l, rules->longest) : l, room), 0.);
}

PetscBool MpmSpaceHalfLengths(const MpmRules *rules, const MpmPoints *points, PetscInt p, PetscReal half[])
{
  const MpmGrid   *grid = rules->grid;
  const PetscInt   dim  = grid->dim;
  const PetscReal *x    = &points->x[p * dim];
  PetscInt         lower[MPM_MAX_DIM], upper[MPM_MAX_DIM];
  PetscReal        U[MPM_MAX_DIM] = {1., 1., 1.};
  const PetscBool  good =
    (PetscBool)!MpmDomainStretch(MpmFluidsAmong(rules->materials, rules->longest > 0. ? rules->material_count : 0),
                                 points->material[p], rules->stretch, dim, MpmPointF(points, p), U);

  MpmSpaceEdges(rules, x, lower, upper);
  for (PetscInt a = 0; a < dim; a++) {
    const PetscReal xi = (x[a] - grid->lower[a]) / grid->h[a];

    half[a] = Clipped(rules, points->domain.half_length[p * dim + a] * U[a] / grid->h[a], xi, lower[a], upper[a]);
  }
  return good;
}

/* ---- blocks of points: divisions are done for a block at a time, number by number of each point and axis ---- */
#define BLOCK   32
#define NUMBERS (BLOCK * MPM_MAX_DIM)

typedef struct {
  PetscReal lower[NUMBERS], h[NUMBERS];    /* of the grid, on the number's axis */
  PetscReal xi[NUMBERS];                   /* places of the points, in cells */
  PetscInt  first[NUMBERS], last[NUMBERS]; /* edges that bound the material around them */
} Block;

static void BlockCreate(const MpmRules *rules, Block *block)
{
  const MpmGrid *grid = rules->grid;
  const PetscInt dim  = grid->dim;

  for (PetscInt k = 0; k < BLOCK * dim; k++) {
    block->lower[k] = grid->lower[k % dim];
    block->h[k]     = grid->h[k % dim];
    block->first[k] = 0;
    block->last[k]  = grid->cells[k % dim];
  }
}

/* Of the points from `from` on. Returns how many: all that are left, or a full block. */
static PetscInt BlockPlace(const MpmRules *rules, const MpmPoints *points, PetscInt from, Block *block)
{
  const PetscInt   dim = rules->grid->dim, count = PetscMin(BLOCK, points->count - from);
  const PetscReal *x = &points->x[from * dim];

  for (PetscInt k = 0; k < count * dim; k++) block->xi[k] = (x[k] - block->lower[k]) / block->h[k];
  for (PetscInt p = 0; rules->walls.count && p < count; p++)
    MpmSpaceEdges(rules, &x[p * dim], &block->first[p * dim], &block->last[p * dim]);
  return count;
}

/* The half-lengths of all points, and the longest: infinite when a point has no stretch. */
static void HalfLengths(const MpmRules *rules, const MpmPoints *points, PetscReal half[], PetscReal *longest)
{
  const PetscInt     dim    = rules->grid->dim;
  const MpmMaterial *fluids = MpmFluidsAmong(rules->materials, rules->longest > 0. ? rules->material_count : 0);
  Block              block;
  PetscReal          U[NUMBERS], most[NUMBERS];

  *longest = 0.;
  BlockCreate(rules, &block);
  for (PetscInt k = 0; k < NUMBERS; k++) most[k] = 0.;
  for (PetscInt from = 0; from < points->count; from += BLOCK) {
    const PetscInt   count  = BlockPlace(rules, points, from, &block);
    const PetscReal *length = &points->domain.half_length[from * dim], *F = MpmPointF(points, from);
    PetscReal       *to = &half[from * dim];

    for (PetscInt k = 0; k < count * dim; k++) U[k] = 1.;
    for (PetscInt p = 0; p < count; p++)
      if (MpmDomainStretch(fluids, points->material[from + p], rules->stretch, dim, &F[p * points->F_size],
                           &U[p * dim]))
        *longest = PETSC_INFINITY;
    for (PetscInt k = 0; k < count * dim; k++) {
      to[k]   = Clipped(rules, length[k] * U[k] / block.h[k], block.xi[k], block.first[k], block.last[k]);
      most[k] = PetscMax(most[k], to[k]);
    }
  }
  for (PetscInt k = 0; k < NUMBERS; k++) *longest = PetscMax(*longest, most[k]);
}

/* The nodes that points touch with one shape, and their weights: per point and axis `width` values. */
typedef struct {
  PetscInt   width;
  PetscBool  mean; /* means over the cell are needed */
  PetscInt  *first, *count;
  MpmWeights values;
} Lines;

/* A shape on the lattice of its nodes. */
typedef struct {
  MpmShapeType type;
  PetscInt     spacing;
} Shape;

/* Weights of a point on one axis with nodes on a coarser lattice, gradients by xi; edges and nodes of the grid. */
static void EvaluateCoarse(const Shape *shape, MpmEdgeType edge, PetscReal xi, PetscReal half, PetscInt lower,
                           PetscInt upper, MpmShapeLine *line)
{
  const PetscInt r = shape->spacing;

  /* the lattice's nodes on the edges, or next behind them */
  MpmShapeEvaluate(shape->type, edge, xi / (PetscReal)r, half / (PetscReal)r, lower / r, (upper + r - 1) / r, line);
  for (PetscInt i = line->count - 1; i >= 0; i--) {
    const PetscReal weight = line->weight[i], gradient = line->gradient[i] / (PetscReal)r;

    for (PetscInt k = 0; k < r && (k == 0 || i + 1 < line->count); k++)
      line->weight[i * r + k] = line->gradient[i * r + k] = 0.;
    line->weight[i * r]   = weight;
    line->gradient[i * r] = gradient;
  }
  line->first *= r;
  line->count = (line->count - 1) * r + 1;
}

/* One block's, derivatives by xi. */
static void EvaluateBlock(const MpmRules *rules, const Shape *shape, const Block *block, PetscInt count,
                          const PetscReal half[], const MpmShapeLines *lines)
{
  const PetscInt width = lines->width;

  if (shape->spacing == 1) {
    MpmShapeEvaluateAll(shape->type, rules->edge, count,
                        &(MpmShapePlaces){block->xi, half ? half : block->xi, block->first, block->last, rules->touch},
                        lines);
    return;
  }
  for (PetscInt k = 0; k < count; k++) {
    MpmShapeLine line = {.weight = &lines->weight[k * width], .gradient = &lines->gradient[k * width]};

    EvaluateCoarse(shape, rules->edge, block->xi[k], half ? half[k] : 0., block->first[k], block->last[k], &line);
    for (PetscInt i = line.count; i < width; i++) line.gradient[i] = 0.;
    lines->first[k] = line.first;
    lines->count[k] = line.count;
  }
}

/* Means over the cell of a block's lines. */
static void AverageBlock(const MpmRules *rules, const Shape *shape, const Block *block, PetscInt count,
                         const PetscReal half[], const MpmShapeLines *lines, PetscReal mean[])
{
  for (PetscInt k = 0; k < count; k++) {
    const MpmShapeLine line = {.first    = lines->first[k],
                               .count    = lines->count[k],
                               .weight   = &lines->weight[k * lines->width],
                               .gradient = &lines->gradient[k * lines->width],
                               .mean     = &mean[k * lines->width]};

    MpmShapeMean(shape->type, rules->edge, block->xi[k], half ? half[k] : 0., block->first[k], block->last[k], &line);
  }
}

/* Along the radius, with axial symmetry. */
static void AverageByVolume(const MpmRules *rules, const Shape *shape, const Block *block, PetscInt count,
                            const PetscReal half[], const MpmShapeLines *lines)
{
  const MpmGrid *grid = rules->grid;

  for (PetscInt k = 0; k < count; k += grid->dim) {
    const MpmShapeLine line = {.first    = lines->first[k],
                               .count    = lines->count[k],
                               .weight   = &lines->weight[k * lines->width],
                               .gradient = &lines->gradient[k * lines->width]};

    const MpmRadialPlace at = {block->xi[k], half[k], block->xi[k] + grid->lower[0] / grid->h[0], block->first[k],
                               block->last[k]};

    MpmShapeAverageByVolume(shape->type, rules->edge, &at, &line);
  }
}

static PetscErrorCode EvaluateLines(const MpmRules *rules, const MpmPoints *points, const Shape *shape,
                                    const PetscReal half[], Lines *lines)
{
  const PetscInt dim = rules->grid->dim, width = lines->width, count = points->count * dim;
  MpmWeights    *values = &lines->values;
  PetscReal     *h;
  Block          block;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc2(count, &lines->first, count, &lines->count));
  PetscCall(PetscMalloc3((count * width), &values->weight, (count * width), &values->gradient,
                         (lines->mean ? count * width : 0), &values->mean));
  if (!lines->mean) values->mean = NULL;
  values->cross = values->slope = values->hoop = NULL;
  if (rules->smooth > 0.) PetscCall(PetscMalloc2((count * width), &values->cross, (count * width), &values->slope));
  PetscCall(PetscMalloc1((BLOCK * dim * width), &h));
  BlockCreate(rules, &block);
  for (PetscInt k = 0; k < BLOCK * dim * width; k++) h[k] = block.h[k / width];
  for (PetscInt from = 0; from < points->count; from += BLOCK) {
    const PetscInt here = BlockPlace(rules, points, from, &block) * dim, k = from * dim;
    MpmShapeLines  to = {.width    = width,
                         .first    = &lines->first[k],
                         .count    = &lines->count[k],
                         .weight   = &values->weight[k * width],
                         .gradient = &values->gradient[k * width]};

    if (rules->smooth > 0.) {
      to.smooth = rules->smooth;
      to.cross  = &values->cross[k * width];
      to.slope  = &values->slope[k * width];
    }

    EvaluateBlock(rules, shape, &block, here, half ? &half[k] : NULL, &to);
    if (rules->grid->axial && half && shape->spacing == 1) AverageByVolume(rules, shape, &block, here, &half[k], &to);
    for (PetscInt i = 0; i < here * width; i++) to.gradient[i] /= h[i];
    for (PetscInt i = 0; to.slope && i < here * width; i++) to.slope[i] /= h[i];
    if (lines->mean) AverageBlock(rules, shape, &block, here, half ? &half[k] : NULL, &to, &values->mean[k * width]);
  }
  PetscCall(PetscFree(h));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* All shapes over one box a point, which becomes the space's width. */
static PetscErrorCode Unite(MpmSpace *space, PetscInt count, Lines lines[], PetscInt **box_first, PetscInt **box_count)
{
  PetscInt *first, *size;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc2(count, &first, count, &size));
  space->width = 1;
  for (PetscInt k = 0; k < count; k++) {
    PetscInt end = 0;

    first[k] = PETSC_INT_MAX;
    for (PetscInt s = 0; s < space->shapes.count; s++) {
      first[k] = PetscMin(first[k], lines[s].first[k]);
      end      = PetscMax(end, lines[s].first[k] + lines[s].count[k]);
    }
    size[k]      = end - first[k];
    space->width = PetscMax(space->width, size[k]);
  }
  for (PetscInt s = 0; s < space->shapes.count; s++) {
    MpmWeights *to = &space->shapes.at[s];

    PetscCall(PetscCalloc3((count * space->width), &to->weight, (count * space->width), &to->gradient,
                           (lines[s].mean ? count * space->width : 0), &to->mean));
    if (!lines[s].mean) to->mean = NULL;
    for (PetscInt k = 0; k < count; k++) {
      const PetscInt place = k * space->width + lines[s].first[k] - first[k], from = k * lines[s].width;

      PetscCall(PetscArraycpy(&to->weight[place], &lines[s].values.weight[from], lines[s].count[k]));
      PetscCall(PetscArraycpy(&to->gradient[place], &lines[s].values.gradient[from], lines[s].count[k]));
      if (to->mean) PetscCall(PetscArraycpy(&to->mean[place], &lines[s].values.mean[from], lines[s].count[k]));
    }
    PetscCall(PetscFree3(lines[s].values.weight, lines[s].values.gradient, lines[s].values.mean));
    if (s) PetscCall(PetscFree2(lines[s].first, lines[s].count));
  }
  *box_first = first;
  *box_count = size;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Shapes of the fields, and most nodes of a point with each on an axis; PETSC_FALSE where there are too many. */
static PetscBool ListShapes(const MpmRules *rules, PetscReal longest, Shape shapes[], Lines lines[])
{
  PetscInt sum = 0;

  if (!(longest < MPM_MAX_WIDTH)) return PETSC_FALSE;
  for (PetscInt s = 0; s < rules->layout->shape_count; s++) {
    const MpmFieldShape *wanted = &rules->layout->shape[s];

    shapes[s].type    = wanted->degree ? MpmShapeOfDegree(rules->shape, wanted->degree) : rules->shape;
    shapes[s].spacing = wanted->spacing;
    lines[s].mean     = MpmLayoutUsesDeviation(rules->layout, s);
    lines[s].width    = (MpmShapeWidth(shapes[s].type, longest / (PetscReal)wanted->spacing) - 1) * wanted->spacing + 1;
    sum += lines[s].width;
  }
  return (PetscBool)(sum <= MPM_MAX_WIDTH);
}

#define LEAST_RADIUS 1e-12 /* of a cell: for a point on the axis itself, where a radius is divided by */

PetscErrorCode MpmSpaceEvaluateShapes(MpmSpace *space, const MpmRules *rules, const MpmPoints *points,
                                      PetscInt **box_first, PetscInt **box_count, MpmOutcome *outcome)
{
  const PetscInt dim     = rules->grid->dim;
  PetscReal      longest = 0.;
  Shape          shapes[MPM_MAX_SHAPES];
  Lines          lines[MPM_MAX_SHAPES];

  PetscFunctionBeginUser;
  space->dim          = dim;
  space->point_count  = points->count;
  space->shapes.count = rules->layout->shape_count;
  space->parts.count  = PetscMax(rules->parts, 1);
  space->parts.spans  = rules->parts > 1 ? rules->grid->cells[dim - 1] + 1 + MPM_PART_GAP : 0;
  space->parts.stride = rules->grid->order * space->parts.spans;
  if (MpmShapeHasDomain(rules->shape)) {
    PetscCall(PetscMalloc1((points->count * dim), &space->shapes.half));
    HalfLengths(rules, points, space->shapes.half, &longest);
    /* the Jacobian's window, and with it the colours, must be the same on all ranks */
    PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &longest, 1, MPIU_REAL, MPIU_MAX, rules->grid->comm));
  }
  if (rules->means == MPM_MEANS_SPREAD && rules->longest <= 0. && longest > MPM_SPREAD_HALF_LENGTH) {
    PetscCall(MpmOutcomeFail(outcome, MPM_OUTCOME_INADMISSIBLE,
                             "a point's domain spans too many cells for -mpm_stabilization_fbar spread"));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (!ListShapes(rules, longest, shapes, lines)) {
    PetscCall(MpmOutcomeFail(outcome, MPM_OUTCOME_INADMISSIBLE, "a point%sdomain spans too many cells",
                             longest < MPM_MAX_WIDTH ? "'s " : " has no stretch, or its "));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  for (PetscInt s = 0; s < space->shapes.count; s++)
    PetscCall(EvaluateLines(rules, points, &shapes[s], space->shapes.half, &lines[s]));
  if (rules->grid->axial) {
    PetscCall(PetscMalloc1(points->count, &space->shapes.at[0].hoop));
    for (PetscInt p = 0; p < points->count; p++)
      space->shapes.at[0].hoop[p] = 1. / PetscMax(points->x[p * dim], LEAST_RADIUS * rules->grid->h[0]);
  }
  space->touched.first = lines[0].first;
  space->touched.count = lines[0].count;
  if (space->shapes.count > 1) {
    PetscCall(Unite(space, points->count * dim, lines, box_first, box_count));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  space->width         = lines[0].width;
  lines[0].values.hoop = space->shapes.at[0].hoop;
  space->shapes.at[0]  = lines[0].values;
  *box_first           = space->touched.first;
  *box_count           = space->touched.count;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Nanoseconds an unknown of the action of CEED's problems BP1 to BP4 and of a hyperelastic solid at rest, on the cells of
  a box, in four forms:

    at_points  Talus' action without a matrix, at points of the cells
    tensor     tensor quadrature at Gauss points, by this file
    dense      a dense matrix for each cell, by this file
    baij       the assembled matrix, in blocks of a node's unknowns

    bench_bps -bench_problem bp1|bp2|bp3|bp4|solid -bps_points gauss [-bench_rounds 7] [-bench_sample 0.05] SCENE

  The scene (scripts/bench/bps.py) has as many points an axis in a cell as there are quadrature points, p + 2, no
  conditions, and cubes as cells. All forms are compiled with the same options and have the same unknowns; `tensor` and
  `dense` number them along the axes. Seconds are those of this process; a form's number is the median of the rounds, in
  which the forms take turns. Data at quadrature points are kept for any cell and operator: 1, 6 or 45 numbers. A matrix
  of a cell serves all components of BP2 and BP4.

  Lines on the terminal: a form and its number, `unknowns`, and `difference`: the largest relative difference of x . A x
  among the forms, for x a function of the place. With Gauss points it is a rounding error.
*/
#include <math.h>
#include <time.h>
#include "space/space.h"
#include "step/step.h"
#include "schedule/schedule.h"
#include "particles/particles.h"
#include "query/model.h"
#include "bps/places.h"

typedef double Lanes __attribute__((vector_size(32)));
#define LANES 4

/* 1-D functions at quadrature points, q by n, and derivatives from quadrature points to these, q by q, of [0, 1]. */
typedef struct {
  double value[64], slope[64];
} Tables;

#define BP_N 3
#define BP_Q 4
#include "bps/tensor.h"
#define BP_N 4
#define BP_Q 5
#include "bps/tensor.h"
#define BP_N 5
#define BP_Q 6
#include "bps/tensor.h"

typedef void (*CellAction)(const Tables *tables, const Lanes *data, const Lanes *u, Lanes *y);

enum { BP1, BP2, BP3, BP4, SOLID };
static const char *const problems[] = {"bp1", "bp2", "bp3", "bp4", "solid"};
enum { AT_POINTS, TENSOR, DENSE, BAIJ, FORMS };
static const char *const forms[] = {"at_points", "tensor", "dense", "baij"};

typedef struct {
  PetscInt   problem, rounds, p, n, q, cells, side; /* side: nodes an axis of the box */
  PetscInt   components, numbers;                   /* numbers: of data a quadrature point */
  PetscReal  sample;
  Lattice    lattice;
  Tables     tables;
  CellAction action;
  Lanes     *data;   /* by four cells and quadrature point */
  double    *matrix; /* by cell, column by column */
  double    *x, *y;  /* by node along the axes, then by component */
  Mat        at_points, baij;
  Vec        from, to;
  MpmModel   model[2];
} Bench;

/* ---- one-dimensional functions ---- */

/* Gauss-Lobatto points of [0, 1] for orders 2 to 4. */
static void Nodes(PetscInt p, double node[])
{
  const double inner[] = {0., 0., 0.5, 0.5 - 0.5 / sqrt(5.), 0.5 - 0.5 * sqrt(3. / 7.)};

  for (PetscInt i = 0; i <= p; i++) node[i] = i == 0 ? 0. : i == p ? 1. : 0.5;
  node[1]     = inner[p];
  node[p - 1] = 1. - inner[p];
}

/* Lagrange function i of the nodes at t, and its derivative. */
static void Lagrange(PetscInt n, const double node[], PetscInt i, double t, double *value, double *slope)
{
  *value = 1.;
  *slope = 0.;
  for (PetscInt k = 0; k < n; k++) {
    if (k == i) continue;
    *slope = (*slope * (t - node[k]) + *value) / (node[i] - node[k]);
    *value *= (t - node[k]) / (node[i] - node[k]);
  }
}

static void MakeTables(Bench *bench)
{
  double node[8], unused;

  Nodes(bench->p, node);
  for (PetscInt k = 0; k < bench->q; k++) {
    for (PetscInt i = 0; i < bench->n; i++)
      Lagrange(bench->n, node, i, bench->lattice.gauss[k], &bench->tables.value[k * bench->n + i], &unused);
    for (PetscInt i = 0; i < bench->q; i++)
      Lagrange(bench->q, bench->lattice.gauss, i, bench->lattice.gauss[k], &unused,
               &bench->tables.slope[k * bench->q + i]);
  }
}

/* ---- data and matrices of cells ---- */

/* Component pair (k, l) of Hooke's tangent at rest, k = 3 c + a for the derivative of component c along axis a. */
static double Hooke(PetscInt k, PetscInt l)
{
  const double   E = 1., nu = 0.3, lame = E * nu / ((1. + nu) * (1. - 2. * nu)), mu = 0.5 * E / (1. + nu);
  const PetscInt c = k / 3, a = k % 3, d = l / 3, b = l % 3;

  return (c == a && d == b ? lame : 0.) + (c == d && a == b ? mu : 0.) + (c == b && a == d ? mu : 0.);
}

static PetscErrorCode MakeData(Bench *bench)
{
  const PetscInt q = bench->q, all = q * q * q, groups = bench->cells * bench->cells * bench->cells / LANES;
  const double   h = bench->lattice.h[0];

  PetscFunctionBeginUser;
  bench->data = (Lanes *)aligned_alloc(64, sizeof(Lanes) * (size_t)(groups * all * bench->numbers));
  PetscCheck(bench->data, PETSC_COMM_SELF, PETSC_ERR_MEM, "no memory");
  for (PetscInt g = 0; g < groups; g++) {
    for (PetscInt k = 0; k < all; k++) {
      const double *w = bench->lattice.weight, weight = w[k % q] * w[k / q % q] * w[k / (q * q)] * h * h * h;
      Lanes        *d = &bench->data[(g * all + k) * bench->numbers];
      PetscInt      m = 0;

      if (bench->problem <= BP2) d[0] = weight + (Lanes){0., 0., 0., 0.};
      for (PetscInt r = 0; bench->numbers == 6 && r < 3; r++)
        for (PetscInt c = r; c < 3; c++) d[m++] = (r == c ? weight / (h * h) : 0.) + (Lanes){0., 0., 0., 0.};
      for (PetscInt r = 0; bench->numbers == 45 && r < 9; r++)
        for (PetscInt c = r; c < 9; c++) d[m++] = Hooke(r, c) * weight / (h * h) + (Lanes){0., 0., 0., 0.};
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Unknowns of a cell that its matrix couples. */
static PetscInt MatrixSize(const Bench *bench)
{
  return bench->n * bench->n * bench->n * (bench->problem == SOLID ? 3 : 1);
}

/* The columns of one cell's matrix are its action on unit vectors; the cells are alike, and each has its own copy. */
static PetscErrorCode MakeMatrices(Bench *bench)
{
  const PetscInt size = MatrixSize(bench), cells = bench->cells * bench->cells * bench->cells;
  Lanes         *u, *y;

  PetscFunctionBeginUser;
  u = (Lanes *)aligned_alloc(64, sizeof(Lanes) * (size_t)size);
  y = (Lanes *)aligned_alloc(64, sizeof(Lanes) * (size_t)size);
  PetscCall(PetscMalloc1((size_t)cells * (size_t)(size * size), &bench->matrix));
  for (PetscInt j = 0; j < size; j++) {
    for (PetscInt i = 0; i < size; i++) u[i] = (Lanes){i == j ? 1. : 0., 0., 0., 0.};
    bench->action(&bench->tables, bench->data, u, y);
    for (PetscInt i = 0; i < size; i++) bench->matrix[j * size + i] = y[i][0];
  }
  for (PetscInt e = 1; e < cells; e++)
    PetscCall(PetscArraycpy(&bench->matrix[(size_t)e * (size_t)(size * size)], bench->matrix, size * size));
  free(u);
  free(y);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- actions ---- */

/* First node of a cell. */
static size_t CellStart(const Bench *bench, PetscInt cell)
{
  const PetscInt c = bench->cells, i = cell % c, j = cell / c % c, k = cell / (c * c);

  return (size_t)(bench->p * ((k * bench->side + j) * bench->side + i));
}

static inline size_t NodeOf(const Bench *bench, size_t start, PetscInt i)
{
  const PetscInt n = bench->n;

  return start + (size_t)((i / (n * n) * bench->side + i / n % n) * bench->side + i % n);
}

static void ApplyTensor(Bench *bench, PetscInt n)
{
  const PetscInt nodes = n * n * n, c = bench->components, cells = bench->cells * bench->cells * bench->cells;
  const PetscInt stride = bench->q * bench->q * bench->q * bench->numbers;
  Lanes          u[3 * 125], y[3 * 125];

  for (PetscInt e = 0; e < cells; e += LANES) {
    const Lanes *data = &bench->data[(size_t)(e / LANES) * (size_t)stride];
    size_t       start[LANES];

    for (PetscInt l = 0; l < LANES; l++) start[l] = CellStart(bench, e + l);
    for (PetscInt i = 0; i < nodes; i++)
      for (PetscInt l = 0; l < LANES; l++) {
        const double *from = &bench->x[NodeOf(bench, start[l], i) * (size_t)c];

        for (PetscInt k = 0; k < c; k++) u[k * nodes + i][l] = from[k];
      }
    if (bench->problem == SOLID) bench->action(&bench->tables, data, u, y);
    else
      for (PetscInt k = 0; k < c; k++) bench->action(&bench->tables, data, &u[k * nodes], &y[k * nodes]);
    for (PetscInt i = 0; i < nodes; i++)
      for (PetscInt l = 0; l < LANES; l++) {
        double *to = &bench->y[NodeOf(bench, start[l], i) * (size_t)c];

        for (PetscInt k = 0; k < c; k++) to[k] += y[k * nodes + i][l];
      }
  }
}

/* y += A x for `count` vectors side by side in rows of y and x. */
static inline __attribute__((always_inline)) void Columns(PetscInt size, PetscInt count, const double *restrict matrix,
                                                          const double *restrict x, double *restrict y)
{
  for (PetscInt j = 0; j < size; j++)
    for (PetscInt k = 0; k < count; k++) {
      const double f = x[k * size + j];

      for (PetscInt i = 0; i < size; i++) y[k * size + i] += matrix[j * size + i] * f;
    }
}

static void ApplyDense(Bench *bench, PetscInt n)
{
  const PetscInt nodes = n * n * n, c = bench->components, cells = bench->cells * bench->cells * bench->cells;
  const PetscInt size = MatrixSize(bench);
  double         u[3 * 125], y[3 * 125];

  for (PetscInt e = 0; e < cells; e++) {
    const double *matrix = &bench->matrix[(size_t)e * (size_t)(size * size)];
    const size_t  start  = CellStart(bench, e);

    for (PetscInt i = 0; i < nodes; i++)
      for (PetscInt k = 0; k < c; k++) {
        u[k * nodes + i] = bench->x[NodeOf(bench, start, i) * (size_t)c + (size_t)k];
        y[k * nodes + i] = 0.;
      }
    if (bench->problem == SOLID) Columns(3 * nodes, 1, matrix, u, y);
    else if (c == 3) Columns(nodes, 3, matrix, u, y);
    else Columns(nodes, 1, matrix, u, y);
    for (PetscInt i = 0; i < nodes; i++)
      for (PetscInt k = 0; k < c; k++) bench->y[NodeOf(bench, start, i) * (size_t)c + (size_t)k] += y[k * nodes + i];
  }
}

static PetscErrorCode Apply(Bench *bench, PetscInt form)
{
  const size_t size = (size_t)(bench->side * bench->side * bench->side * bench->components);

  PetscFunctionBeginUser;
  if (form == AT_POINTS || form == BAIJ) {
    PetscCall(MatMult(form == BAIJ ? bench->baij : bench->at_points, bench->from, bench->to));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  memset(bench->y, 0, size * sizeof(double));
  if (form == TENSOR) {
    if (bench->n == 3) ApplyTensor(bench, 3);
    else if (bench->n == 4) ApplyTensor(bench, 4);
    else ApplyTensor(bench, 5);
  } else {
    if (bench->n == 3) ApplyDense(bench, 3);
    else if (bench->n == 4) ApplyDense(bench, 4);
    else ApplyDense(bench, 5);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the model's operator ---- */

/* A function of the place that no operator takes to zero. */
static double Trial(const double place[], PetscInt component)
{
  return sin(2. * place[0] + 0.3) * cos(1.5 * place[1] - 0.2 * component) + place[2] * place[2] * (1. + component);
}

static PetscErrorCode CreateModel(Bench *bench, const char *jacobian, MpmModel *out)
{
  MpmModel   model;
  MpmOutcome outcome;
  PetscReal *x, *x0, *volume;
  PetscInt   count;

  PetscFunctionBeginUser;
  PetscCall(PetscOptionsSetValue(NULL, "-mpm_jacobian", jacobian));
  PetscCall(MpmModelCreate(PETSC_COMM_SELF, &model));
  PetscCall(MpmModelSetFromOptions(model));
  PetscCall(MpmModelSetUp(model));
  PetscCall(MpmModelGetPointCount(model, &count, NULL));
  PetscCall(MpmModelGetPoints(model, "position", NULL, &x));
  PetscCall(MpmModelGetPoints(model, "position0", NULL, &x0));
  PetscCall(MpmModelGetPoints(model, "volume0", NULL, &volume));
  for (PetscInt p = 0; p < count; p++) {
    Place(&bench->lattice, &x[3 * p], &volume[p]);
    PetscCall(PetscArraycpy(&x0[3 * p], &x[3 * p], 3));
  }
  PetscCall(MpmModelRestorePoints(model, "volume0", NULL, &volume));
  PetscCall(MpmModelRestorePoints(model, "position0", NULL, &x0));
  PetscCall(MpmModelRestorePoints(model, "position", NULL, &x));
  PetscCall(MpmParticlesMigrate(model->state.particles, model->disc.grid));
  PetscCall(MpmStepPrepare(model, 1., 1., PETSC_FALSE, &outcome));
  PetscCheck(!outcome.code, PETSC_COMM_SELF, PETSC_ERR_PLIB, "%s", outcome.text);
  *out = model;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode MakeOperators(Bench *bench)
{
  const PetscInt c = bench->components;
  PetscScalar   *values;
  PetscInt       owned;

  PetscFunctionBeginUser;
  PetscCall(CreateModel(bench, "matfree", &bench->model[0]));
  PetscCall(CreateModel(bench, "local", &bench->model[1]));
  for (PetscInt k = 0; k < 2; k++) {
    MpmSolver *solver = &bench->model[k]->solver;
    Mat        J      = solver->jacobian.shell ? solver->jacobian.shell : solver->jacobian.assembled;

    PetscCall(SNESComputeFunction(solver->snes, solver->x, solver->f));
    PetscCall(
      SNESComputeJacobian(solver->snes, solver->x, J, solver->jacobian.assembled ? solver->jacobian.assembled : J));
  }
  bench->at_points = bench->model[0]->solver.jacobian.shell;
  PetscCall(MatConvert(bench->model[1]->solver.jacobian.assembled, MATSEQBAIJ, MAT_INITIAL_MATRIX, &bench->baij));
  PetscCall(MatCreateVecs(bench->baij, &bench->from, &bench->to));
  owned = MpmNodesOwned(&bench->model[0]->disc);
  PetscCheck(owned == bench->side * bench->side * bench->side, PETSC_COMM_SELF, PETSC_ERR_PLIB,
             "%" PetscInt_FMT " nodes", owned);
  PetscCall(VecGetArray(bench->from, &values));
  for (PetscInt i = 0; i < owned; i++) {
    PetscReal place[MPM_MAX_DIM];

    MpmNodePosition(&bench->model[0]->disc, i, place);
    for (PetscInt k = 0; k < c; k++) values[i * c + k] = Trial(place, k);
  }
  PetscCall(VecRestoreArray(bench->from, &values));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The same function at the nodes along the axes. */
static PetscErrorCode MakeVectors(Bench *bench)
{
  const PetscInt c = bench->components, side = bench->side, count = side * side * side;
  double         node[8];

  PetscFunctionBeginUser;
  Nodes(bench->p, node);
  PetscCall(PetscMalloc2((count * c), &bench->x, (count * c), &bench->y));
  for (PetscInt i = 0; i < count; i++) {
    const PetscInt at[3] = {i % side, i / side % side, i / (side * side)};
    double         place[3];

    for (PetscInt a = 0; a < 3; a++)
      place[a] = bench->lattice.lower[a] + bench->lattice.h[a] * ((double)(at[a] / bench->p) + node[at[a] % bench->p]);
    for (PetscInt k = 0; k < c; k++) bench->x[i * c + k] = Trial(place, k);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* x . A x */
static PetscErrorCode Product(Bench *bench, PetscInt form, PetscReal *product)
{
  const PetscInt count = bench->side * bench->side * bench->side * bench->components;

  PetscFunctionBeginUser;
  PetscCall(Apply(bench, form));
  *product = 0.;
  if (form == AT_POINTS || form == BAIJ) PetscCall(VecDot(bench->from, bench->to, product));
  else
    for (PetscInt k = 0; k < count; k++) *product += bench->x[k] * bench->y[k];
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode PrintDifference(Bench *bench)
{
  PetscReal product[FORMS], largest = 0.;

  PetscFunctionBeginUser;
  for (PetscInt f = 0; f < FORMS; f++) {
    PetscCall(Product(bench, f, &product[f]));
    largest = PetscMax(largest, PetscAbsReal(product[f] / product[0] - 1.));
  }
  PetscCall(PetscPrintf(PETSC_COMM_SELF, "difference %.3e\n", (double)largest));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- times ---- */

static PetscReal Processor(void)
{
  struct timespec now;

  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return (PetscReal)now.tv_sec + 1e-9 * (PetscReal)now.tv_nsec;
}

/* Seconds of the processor for one action, the mean over `repeat` of them. */
static PetscErrorCode Sample(Bench *bench, PetscInt form, PetscInt repeat, PetscReal *seconds)
{
  const PetscReal begin = Processor();

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < repeat; k++) PetscCall(Apply(bench, form));
  *seconds = (Processor() - begin) / (PetscReal)repeat;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Measure(Bench *bench)
{
  const PetscInt unknowns = bench->side * bench->side * bench->side * bench->components;
  PetscInt       repeat[FORMS];
  PetscReal     *seconds, first = 0.;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1((FORMS * bench->rounds), &seconds));
  for (PetscInt f = 0; f < FORMS; f++) {
    PetscCall(Sample(bench, f, 2, &first));
    repeat[f] = 1 + (PetscInt)(bench->sample / PetscMax(first, 1e-6));
  }
  for (PetscInt r = 0; r < bench->rounds; r++)
    for (PetscInt f = 0; f < FORMS; f++) PetscCall(Sample(bench, f, repeat[f], &seconds[f * bench->rounds + r]));
  for (PetscInt f = 0; f < FORMS; f++) {
    PetscCall(PetscSortReal(bench->rounds, &seconds[f * bench->rounds]));
    PetscCall(PetscPrintf(PETSC_COMM_SELF, "%s %.4f\n", forms[f],
                          (double)(1e9 * seconds[f * bench->rounds + bench->rounds / 2] / (PetscReal)unknowns)));
  }
  PetscCall(PetscPrintf(PETSC_COMM_SELF, "unknowns %" PetscInt_FMT "\n", unknowns));
  PetscCall(PetscFree(seconds));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadBench(Bench *bench)
{
  static const CellAction actions[3][3] = {
    {Mass_3_4, Diffusion_3_4, Solid_3_4}, {Mass_4_5, Diffusion_4_5, Solid_4_5}, {Mass_5_6, Diffusion_5_6, Solid_5_6}};
  PetscInt kind = GAUSS;

  PetscFunctionBeginUser;
  bench->rounds = 7;
  bench->sample = 0.05;
  PetscCall(PetscOptionsGetEList(NULL, NULL, "-bench_problem", problems, 5, &bench->problem, NULL));
  PetscCall(PetscOptionsGetInt(NULL, NULL, "-bench_rounds", &bench->rounds, NULL));
  PetscCall(PetscOptionsGetReal(NULL, NULL, "-bench_sample", &bench->sample, NULL));
  PetscCall(PetscOptionsGetEList(NULL, NULL, "-bps_points", kinds, 4, &kind, NULL));
  PetscCall(PetscOptionsGetInt(NULL, NULL, "-mpm_order", &bench->p, NULL));
  PetscCall(ReadLattice((PointKind)kind, &bench->lattice));
  bench->cells      = bench->lattice.cells[0];
  bench->n          = bench->p + 1;
  bench->q          = bench->p + 2;
  bench->side       = bench->cells * bench->p + 1;
  bench->components = bench->problem == BP1 || bench->problem == BP3 ? 1 : 3;
  bench->numbers    = bench->problem <= BP2 ? 1 : bench->problem <= BP4 ? 6 : 45;
  PetscCheck(bench->p >= 2 && bench->p <= 4 && bench->lattice.m == bench->q && bench->cells % 2 == 0, PETSC_COMM_WORLD,
             PETSC_ERR_USER_INPUT, "order must be 2 to 4, points an axis order + 2, cells an axis even");
  bench->action = actions[bench->p - 2][bench->problem <= BP2 ? 0 : bench->problem <= BP4 ? 1 : 2];
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Destroy(Bench *bench)
{
  PetscFunctionBeginUser;
  PetscCall(VecDestroy(&bench->from));
  PetscCall(VecDestroy(&bench->to));
  PetscCall(MatDestroy(&bench->baij));
  for (PetscInt k = 0; k < 2; k++) PetscCall(MpmModelDestroy(&bench->model[k]));
  PetscCall(PetscFree2(bench->x, bench->y));
  PetscCall(PetscFree(bench->matrix));
  free(bench->data);
  PetscFunctionReturn(PETSC_SUCCESS);
}

int main(int argc, char **argv)
{
  Bench bench;

  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  PetscCall(PetscMemzero(&bench, sizeof(bench)));
  PetscCall(ReadBench(&bench));
  MakeTables(&bench);
  PetscCall(MakeData(&bench));
  PetscCall(MakeMatrices(&bench));
  PetscCall(MakeVectors(&bench));
  PetscCall(MakeOperators(&bench));
  PetscCall(PrintDifference(&bench));
  PetscCall(Measure(&bench));
  PetscCall(Destroy(&bench));
  PetscCall(PetscFinalize());
  return 0;
}

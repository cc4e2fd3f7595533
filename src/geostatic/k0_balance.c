/*
  The stress of k0, start of a geostatic stage: the vertical stress is the weight above (overburden.c), the horizontal
  ones k0 times that, point by point.

  On level ground this is to be the geostatic stress, to rounding. But it need not be in balance over the grid: splines
  sum it to forces that are not quite the weights, least of all where layers differ in their points a cell, and so do
  points that leave gaps. Balancing by the materials would change the ratio. Therefore a stress with both properties is
  sought: of all in balance, with the ratio k0 and any shear, the one nearest to that of the weight above, in the sum of
  volume times the square of the difference. This is the equilibrium of a linear law whose stress keeps the ratio
  whatever the strain (k0_law.c): one linear solve, and others that remove the regularisation of the matrix. The points
  do not move in them. Ground that is not level has no such stress of use: there the materials find the balance.
*/
#include "point/layout.h"
#include "point/material.h"
#include "point/registry.h"
#include "point/stress_inversion.h"
#include "particles/body.h"
#include "query/overburden.h"
#include "particles/particles.h"
#include "particles/point_mass.h"
#include "particles/points.h"
#include "space/sum.h"
#include "assembly/terms.h"
#include "loads/body_surface.h"
#include "loads/load.h"
#include "loads/water_table.h"
#include "solve/iterate.h"
#include "query/model.h"
#include "query/query.h"
#include "step/step.h"
#include "geostatic/geostatic.h"

/* Solves for a balance, and what the stress may still change in the last one, relative to the largest. */
#define BALANCE_LIMIT     24
#define BALANCE_TOLERANCE 1e-10
/* Ground is not level where the balance needs more shear, or is further from the weight above, in parts of the vertical
   stress and in root mean square: a surface of about 6 degrees has that much shear, layers that overlap by a point that
   much distance. */
#define BALANCE_SHEAR    0.06
#define BALANCE_DISTANCE 0.5
/* The auxiliary law's modulus, in largest stresses, and its fraction that keeps the matrix regular: for a direct
   solver, and for others, which take fewer iterations and more solves with it. */
#define BALANCE_MODULUS      1e3
#define BALANCE_REGULAR      1e-8
#define BALANCE_REGULAR_MORE 1e-4

/* ---- the weight above ---- */

/* Which way the stage's gravity points: along one axis, as the scene's check has it. */
static MpmVertical FindVertical(MpmModel model)
{
  MpmVertical vertical = {.axis = model->disc.dim - 1, .up = 1};

  for (PetscInt a = 0; a < model->disc.dim; a++) {
    PetscReal gravity = 0.;

    for (PetscInt l = 0; l < model->scene.loads->count; l++)
      if (model->scene.loads->at[l].type == MPM_LOAD_GRAVITY)
        gravity += MpmModelLoadFactor(model, l, model->state.period.end) * model->scene.loads->at[l].value[a];
    if (gravity != 0.)
      vertical = (MpmVertical){.axis = a, .up = gravity < 0. ? 1 : -1, .gravity = PetscAbsReal(gravity)};
  }
  return vertical;
}

/* Gives point p the stress; MpmInitialFind()'s result. */
static int SetStress(MpmModel model, const MpmInitial *initial, const MpmRest *rest, MpmPoints *points, PetscInt p,
                     PetscReal stress[])
{
  const PetscInt dim = model->disc.dim, size = model->state.particles->state_size, own = initial->material->state_size;
  PetscReal      state[MPM_INITIAL_STATE], U[MPM_MAX_DIM], *F                          = MpmPointF(points, p);
  const int      answer = MpmInitialFind(initial, size ? &points->state[p * size] : NULL, stress, F, state,
                                    points->across ? &points->across[p] : NULL);

  if (answer == 2 || model->scene.deformation.stretch(F, U)) return 2;
  for (PetscInt k = 0; k < own; k++) points->state[p * size + k] = state[k];
  for (PetscInt a = 0; a < dim; a++) points->domain.half_length[p * dim + a] = rest->domain[p * dim + a] / U[a];
  points->volume0[p] = rest->volume[p] / MpmPointJ(points, p);
  for (PetscInt c = 0; c < model->state.particles->stress_size; c++)
    points->stress[p * model->state.particles->stress_size + c] = stress[c];
  return answer;
}

/*
  Gives all points their stress, `stress_size` components each; counts those that the yield surface moved, and those
  that cannot have theirs.
*/
static PetscErrorCode SetStresses(MpmModel model, MpmRest *rest, const PetscReal goal[], PetscInt64 *without)
{
  const PetscInt size     = model->state.particles->stress_size;
  PetscInt64     count[2] = {0, 0};
  MpmInitial    *initial;
  MpmPoints      points;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(model->scene.materials->count, &initial));
  for (PetscInt m = 0; m < model->scene.materials->count; m++)
    PetscCall(MpmInitialCreate(&model->scene.materials->at[m], model->disc.dim, &initial[m]));
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  for (PetscInt p = 0; p < rest->n; p++) {
    PetscReal stress[6] = {0.};
    int       answer;

    for (PetscInt c = 0; c < size; c++) stress[c] = goal[p * size + c];
    initial[points.material[p]].own = MpmPointOwn(&points, &model->scene.materials->at[points.material[p]], p);
    answer                          = SetStress(model, &initial[points.material[p]], rest, &points, p, stress);
    if (answer) count[answer - 1]++;
  }
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  PetscCall(PetscFree(initial));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, count, 2, MPIU_INT64, MPI_SUM, model->comm));
  rest->outside = count[0];
  *without      = count[1];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The ratio of every point under the weight above it: that of its body, or its law's. */
static PetscErrorCode FindRatios(MpmModel model, const MpmPoints *points, const PetscReal pressure[], PetscReal ratio[])
{
  const PetscReal *k0   = model->scene.stages.at[model->state.stage].geostatic.k0;
  const PetscInt   size = model->state.particles->state_size;
  PetscInt        *body;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(points->count, &body));
  MpmBodiesOfPoints(model->scene.bodies->count, model->scene.bodies->at, points, body);
  for (PetscInt p = 0; p < points->count; p++) {
    const MpmMaterial *material = &model->scene.materials->at[points->material[p]];

    const double *own = MpmPointOwn(points, material, p);

    ratio[p] = k0[body[p]];
    if (ratio[p] == MPM_K0_OCR && material->info.k0)
      ratio[p] = material->info.k0(own ? own : material->parameter, material->table,
                                   size ? &points->state[p * size] : NULL, pressure[p]);
  }
  PetscCall(PetscFree(body));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Vertical stress of each point by the weight above, less the pressure of the water where there is some: with open
   water's weight. */
static PetscErrorCode FindVerticalStress(MpmModel model, const MpmRest *rest, const MpmPoints *points,
                                         PetscReal pressure[])
{
  const MpmWaterTable *table    = model->scene.water;
  const PetscInt       dim      = model->disc.dim;
  MpmVertical          vertical = FindVertical(model);
  MpmPoints            heavy    = *points;
  PetscReal           *ground;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc2(points->count, &ground, points->count, &heavy.mass));
  for (PetscInt p = 0; p < points->count; p++)
    heavy.mass[p] = MpmPointMassNow(points, model->scene.materials->at, model->disc.layout, p);
  PetscCall(MpmOverburden(model->disc.grid, &heavy, &vertical, rest->domain, pressure));
  if (MpmPressureComponent(model->disc.layout) >= 0) {
    vertical.gravity = 1.;
    PetscCall(PetscArraycpy(heavy.mass, rest->volume, points->count));
    PetscCall(MpmOverburden(model->disc.grid, &heavy, &vertical, rest->domain, ground));
    for (PetscInt p = 0; p < points->count; p++) {
      if (table->there && MpmSurfacesOpen(model->scene.surfaces))
        pressure[p] +=
          table->weight * PetscMax(MpmWaterTableDepth(table, model->state.time, &points->x[p * dim]) - ground[p], 0.);
      pressure[p] -= points->physics.value[p * model->disc.layout->rate.count];
    }
  }
  PetscCall(PetscFree2(ground, heavy.mass));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The stress of k0 from the weight above, and its ratio, for all points. */
static PetscErrorCode FindK0(MpmModel model, MpmRest *rest, PetscReal stress[], PetscReal ratio[])
{
  const PetscInt size = model->state.particles->stress_size;
  const PetscInt axis = FindVertical(model).axis;
  PetscReal     *pressure;
  MpmPoints      points;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(rest->n, &pressure));
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  PetscCall(FindVerticalStress(model, rest, &points, pressure));
  PetscCall(FindRatios(model, &points, pressure, ratio));
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  for (PetscInt p = 0; p < rest->n; p++) {
    for (PetscInt c = 0; c < size; c++) stress[p * size + c] = c < 3 ? -pressure[p] * (c == axis ? 1. : ratio[p]) : 0.;
    rest->largest = PetscMax(rest->largest, PetscMax(1., ratio[p]) * pressure[p]);
  }
  PetscCall(PetscFree(pressure));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &rest->largest, 1, MPIU_REAL, MPIU_MAX, model->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscBool IsSmallStrain(const MpmModel model, PetscInt material)
{
  return (PetscBool)((model->scene.materials->at[material].info.traits & MPM_LAW_SMALL_STRAIN) != 0);
}

static PetscBool AnySmallStrain(const MpmModel model)
{
  for (PetscInt m = 0; m < model->scene.materials->count; m++)
    if (IsSmallStrain(model, m)) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* Corrections of a small-strain law's stress; each leaves about a strain times the error of the last one. */
#define SMALL_STRAIN_ROUNDS 4

/*
  Small-strain laws, whose forces are those of sigma F^T/J in the shape as it stands: up the axis v their stress must be
  J/F_vv times the weight above, and the others by as much.
*/
static PetscErrorCode CorrectSmallStrain(MpmModel model, MpmRest *rest, PetscReal stress[])
{
  const PetscInt dim = model->disc.dim, size = model->state.particles->stress_size, v = FindVertical(model).axis;
  PetscReal     *goal;
  PetscInt64     without;
  MpmPoints      points;

  PetscFunctionBeginUser;
  if (!AnySmallStrain(model)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1((rest->n * size), &goal));
  PetscCall(PetscArraycpy(goal, stress, rest->n * size));
  for (PetscInt k = 0; k < SMALL_STRAIN_ROUNDS; k++) {
    PetscCall(SetStresses(model, rest, stress, &without));
    PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
    for (PetscInt p = 0; p < rest->n; p++) {
      const PetscReal *F = MpmPointF(&points, p);

      if (!IsSmallStrain(model, points.material[p])) continue;
      for (PetscInt c = 0; c < size; c++)
        stress[p * size + c] = goal[p * size + c] * MpmPointJ(&points, p) / F[v * (dim + 1)];
    }
    PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  }
  PetscCall(PetscFree(goal));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- in balance ---- */

/* The search: the stress so far, and the problem that the auxiliary law makes of the points. */
typedef struct {
  MpmModel     model;
  MpmProblem   problem; /* with the auxiliary law, on the model's grid */
  MpmRest     *rest;
  MpmMaterial *auxiliaries; /* one for each material */
  MpmMaterials materials;   /* the scene's, with these in place of its own */
  PetscReal   *ratio;       /* k0 of each point */
  PetscInt     axis;        /* vertical one */
  PetscReal   *stress;      /* Cauchy, `stress_size` components a point */
  PetscReal   *history;     /* of the auxiliary law: stress and ratio */
  PetscReal   *F, *volume0;
  PetscReal    change; /* largest of the last solve, Pa */
  PetscBool    level;  /* stress of level ground */
} Balance;

static PetscErrorCode BalanceCreate(Balance *balance)
{
  MpmModel model = balance->model;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc4(model->scene.materials->count, &balance->auxiliaries,
                         (balance->rest->n * model->state.particles->F_size), &balance->F, balance->rest->n,
                         &balance->volume0, (balance->rest->n * (model->state.particles->stress_size + 1)),
                         &balance->history));
  for (PetscInt m = 0; m < model->scene.materials->count; m++) {
    MpmMaterial *auxiliary = &balance->auxiliaries[m];

    *auxiliary            = model->scene.materials->at[m];
    auxiliary->state_size = 0; /* a step would write it */
    auxiliary->table      = NULL;
    auxiliary->varies     = NULL;
    PetscCheck(MpmLawFindAll("k0_law", (PetscInt)model->scene.deformation.kinematics, auxiliary->law, &auxiliary->info),
               PETSC_COMM_SELF, PETSC_ERR_PLIB, "law k0 is not compiled");
    PetscCall(PetscMalloc1(auxiliary->info.parameter_count, &auxiliary->parameter));
    auxiliary->moduli.stiffness = auxiliary->moduli.penalty = BALANCE_MODULUS * balance->rest->largest;
    PetscCall(
      PetscArraycpy(auxiliary->parameter,
                    ((const PetscReal[]){auxiliary->density, auxiliary->moduli.stiffness, (PetscReal)balance->axis,
                                         model->solver.preset.factorises ? BALANCE_REGULAR : BALANCE_REGULAR_MORE}),
                    auxiliary->info.parameter_count));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A discretization and a solver of their own, with the settings of the model's. */
static PetscErrorCode ProblemCreate(Balance *balance)
{
  const MpmModel model = balance->model;
  MpmProblem    *own   = &balance->problem; /* once they have changed places */

  PetscFunctionBeginUser;
  balance->materials         = *model->scene.materials;
  balance->materials.at      = balance->auxiliaries;
  balance->problem.materials = &balance->materials;
  MpmModelExchange(model, &balance->problem);
  PetscCall(MpmDiscretizationCreate(model->comm, own->disc.grid, own->disc.layout, &model->disc));
  PetscCall(MpmDiscretizationSize(&model->disc));
  model->disc.matrix.diagonal = MpmNodeStiffness(&model->disc, balance->auxiliaries[0].moduli.stiffness);
  PetscCall(MpmDiscretizationSetUp(&model->disc, model->scene.materials, model->scene.boundaries, model->scene.bodies,
                                   model->scene.pairs, model->state.placements,
                                   model->state.particles->stress_size + 1));
  PetscCall(MpmDiscretizationAddSurfaces(&model->disc, model->scene.surfaces,
                                         &model->state.acting.loads[model->scene.loads->count],
                                         own->disc.context.surfaces->kernel));
  PetscCall(MpmSolverDuplicate(&own->solver, &model->disc, &model->monitor, &model->solver));
  model->solver.definite.may_be_lost = PETSC_FALSE;
  MpmModelExchange(model, &balance->problem);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Iterations count as the model's. */
static PetscErrorCode ProblemDestroy(Balance *balance)
{
  const MpmModel model = balance->model;
  MpmProblem    *own   = &balance->problem;

  PetscFunctionBeginUser;
  MpmModelExchange(model, &balance->problem);
  own->solver.iterations.newton       = model->solver.iterations.newton;
  own->solver.iterations.linear       = model->solver.iterations.linear;
  own->solver.iterations.newton_total = model->solver.iterations.newton_total;
  own->solver.iterations.linear_total = model->solver.iterations.linear_total;
  PetscCall(MpmSolverDestroy(&model->solver));
  PetscCall(MpmDiscretizationDestroy(&model->disc));
  MpmModelExchange(model, &balance->problem);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode BalanceDestroy(Balance *balance)
{
  PetscFunctionBeginUser;
  for (PetscInt m = 0; m < balance->model->scene.materials->count; m++)
    PetscCall(PetscFree(balance->auxiliaries[m].parameter));
  PetscCall(PetscFree4(balance->auxiliaries, balance->F, balance->volume0, balance->history));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  The shape in which the auxiliary law gives the forces that the material will give: the volume as it stands, but for
  small-strain laws the initial one and F, which follow from the stress.
*/
static PetscErrorCode TakeShape(Balance *balance)
{
  MpmModel       model = balance->model;
  const PetscInt dim   = model->disc.dim;
  PetscInt64     without;
  MpmPoints      points;

  PetscFunctionBeginUser;
  if (AnySmallStrain(model)) PetscCall(SetStresses(model, balance->rest, balance->stress, &without));
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  for (PetscInt p = 0; p < balance->rest->n; p++) {
    const PetscBool small = IsSmallStrain(model, points.material[p]);

    balance->volume0[p] = small ? points.volume0[p] : balance->rest->volume[p];
    for (PetscInt k = 0; k < points.F_size; k++)
      balance->F[p * points.F_size + k] = small                             ? points.F[p * points.F_size + k]
                                          : k % (dim + 1) && k != dim * dim ? 0.
                                                                            : 1.;
  }
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* While the problem is in force: takes the solved stress, without its regularising share. */
static PetscErrorCode TakeStress(Balance *balance)
{
  const MpmModel model = balance->model;
  const PetscInt dim = model->disc.dim, size = model->state.particles->stress_size, v = balance->axis;
  PetscReal      sum[3] = {0., 0., 0.};

  PetscFunctionBeginUser;
  balance->change = 0.;
  for (PetscInt p = 0; p < balance->rest->n; p++) {
    const PetscReal *solved = &model->disc.trial->stress[p * size], *start = &balance->rest->start[p * size];
    const PetscReal  k0     = balance->ratio[p];
    PetscReal       *stress = &balance->stress[p * size], vertical = solved[v], square = 1.;

    for (PetscInt a = 0; a < dim; a++) {
      if (a == v) continue;
      vertical += k0 * solved[a];
      square += PetscSqr(k0);
    }
    for (PetscInt c = 0; c < size; c++) {
      const PetscReal value = c >= 3 ? solved[c] : vertical / square * (c == v ? 1. : k0);

      balance->change = PetscMax(balance->change, PetscAbsReal(value - stress[c]));
      stress[c]       = value;
    }
    sum[0] += PetscSqr(stress[v] - start[v]);
    for (PetscInt c = 3; c < size; c++) sum[1] += PetscSqr(stress[c]);
    sum[2] += PetscSqr(start[v]);
  }
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &balance->change, 1, MPIU_REAL, MPIU_MAX, model->comm));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, sum, 3, MPIU_REAL, MPIU_SUM, model->comm));
  balance->level =
    (PetscBool)(sum[0] <= PetscSqr(BALANCE_DISTANCE) * sum[2] && sum[1] <= PetscSqr(BALANCE_SHEAR) * sum[2]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* One solve, with the auxiliary law as every material; without a solution the stress stays. */
static PetscErrorCode SolveBalance(Balance *balance, PetscBool *solved)
{
  const MpmModel      model    = balance->model;
  const PetscInt      size     = model->state.particles->stress_size;
  const PetscBool     put_back = model->state.scheme.put_back;
  PetscInt            failed   = 0;
  MpmOutcome          outcome;
  MpmPoints           lent;
  SNESConvergedReason reason = SNES_CONVERGED_ITERATING;

  PetscFunctionBeginUser;
  for (PetscInt p = 0; p < balance->rest->n; p++) {
    for (PetscInt c = 0; c < size; c++) balance->history[p * (size + 1) + c] = balance->stress[p * size + c];
    balance->history[p * (size + 1) + size] = balance->ratio[p];
  }
  MpmModelExchange(model, &balance->problem);
  model->state.scheme.put_back = PETSC_FALSE;
  PetscCall(MpmStepPrepare(model, model->state.period.end, model->state.period.end - model->state.period.start,
                           PETSC_FALSE, &outcome));
  if (!outcome.code) {
    lent                          = *model->disc.points;
    model->disc.points->F         = balance->F;
    model->disc.points->volume0   = balance->volume0;
    model->disc.points->state     = balance->history;
    model->solver.cache.reference = 0.;
    PetscCall(MpmSolverSolve(&model->solver, &reason));
    PetscCall(MpmSumResidual(&model->solver, NULL, MPM_MODE_END, &failed));
    *model->disc.points = lent;
  }
  *solved = (PetscBool)(!outcome.code && reason > 0);
  if (*solved) PetscCall(TakeStress(balance));
  PetscCall(MpmTermsBalance(model->disc.terms, model->disc.sum, *solved && balance->level ? model->disc.nodal.u : NULL,
                            model->state.particles));
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, model->disc.points));
  model->state.scheme.put_back = put_back;
  MpmModelExchange(model, &balance->problem);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Brings the stress of k0 into balance where ground is level, and leaves it as it is where it is not. */
static PetscErrorCode BalanceK0(MpmModel model, MpmRest *rest, PetscReal ratio[], PetscReal stress[])
{
  PetscBool solved = PETSC_TRUE;
  Balance balance  = {.model = model, .rest = rest, .ratio = ratio, .axis = FindVertical(model).axis, .stress = stress};

  PetscFunctionBeginUser;
  PetscCall(BalanceCreate(&balance));
  PetscCall(ProblemCreate(&balance));
  for (PetscInt it = 0; it < BALANCE_LIMIT && solved; it++) {
    if (it && (!balance.level || balance.change <= BALANCE_TOLERANCE * rest->largest)) break;
    PetscCall(TakeShape(&balance));
    PetscCall(SolveBalance(&balance, &solved));
  }
  if (!balance.level) PetscCall(PetscArraycpy(stress, rest->start, rest->n * model->state.particles->stress_size));
  PetscCall(ProblemDestroy(&balance));
  PetscCall(BalanceDestroy(&balance));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmRestSetK0(MpmModel model, MpmRest *rest)
{
  const PetscInt size = model->state.particles->stress_size;
  PetscInt64     without;
  PetscReal     *stress, *ratio;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc2((rest->n * size), &stress, rest->n, &ratio));
  PetscCall(FindK0(model, rest, stress, ratio));
  PetscCall(CorrectSmallStrain(model, rest, stress));
  PetscCall(PetscMalloc1((rest->n * size + 1), &rest->start));
  PetscCall(PetscArraycpy(rest->start, stress, rest->n * size));
  if (rest->largest > 0.) PetscCall(BalanceK0(model, rest, ratio, stress));
  PetscCall(SetStresses(model, rest, stress, &without));
  MpmCheckInput(!without, "-mpm_stage_%s_geostatic_k0: %" PetscInt64_FMT " points cannot have that stress",
                model->scene.stages.at[model->state.stage].name, without);
  PetscCall(PetscFree2(stress, ratio));
  PetscCall(MpmRestKeepMass(model, rest));
  PetscFunctionReturn(PETSC_SUCCESS);
}

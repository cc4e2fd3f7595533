/*
  The stress of k0, which a geostatic stage starts from: the vertical stress is the weight above (overburden.c), the
  horizontal ones k0 times that.

  On level ground this is to be the stress at rest, to rounding. But it need not be in balance over the grid: splines sum
  it to forces that are not quite the weights, least of all where layers differ in their points a cell, and so do points
  that leave gaps. And what a material does to balance it would spoil the ratio. So a stress is looked for that has both.

  Stresses with the ratio k0 are a plane in the space of all points' stresses; those in balance are another. Elastic
  equilibrium goes from a stress to the nearest one in balance, in the norm of the elastic energy (stand-ins with Hencky's
  law); Nearest goes to the nearest one with the ratio, in the same norm. The two in turn come to a stress in both if there
  is one (von Neumann 1950, Functional Operators II), and Anderson's mixing (1965, J. ACM 12, 547), PETSc's SNESANDERSON,
  takes them there sooner: in ten rounds or so over a few cells. With more cells it takes more rounds than are made for
  plain splines over unequal layers, and the ratio is then left with errors of 1e-4 to 1e-3 near where layers meet. Ground
  that is not level has no such stress of use: there the materials find the balance.
*/
#include "mpmimpl.h"

/* Balance of k0: steps to rest, what may be left of the motion in them, and Poisson's ratio of the stand-ins. */
#define BALANCE_LIMIT     12
#define BALANCE_TOLERANCE 1e-9
#define BALANCE_NU        0.45
/* What may be left of the ratio's error (relative to the vertical stress, but to this part of the largest at least). */
#define BALANCE_RATIO 1e-9
#define BALANCE_FLOOR 1e-3
/* Ground whose first balance is further from the ratio than this part of it, in root mean square, is not level. */
#define BALANCE_LEVEL 0.15
/* Most rounds of the search; from so many on, the error must have come down by this factor a round to go on. */
#define BALANCE_ROUNDS 60
#define BALANCE_TRIES  20
#define BALANCE_GAIN   0.7
/* Rounds that Anderson's mixing remembers, two vectors each. */
#define BALANCE_MEMORY "10"

/* ---- the weight above ---- */

/* Which way the stage's gravity points: along one axis, as the scene's check has it. */
static MpmVertical FindVertical(MpmModel model)
{
  MpmVertical vertical = {.axis = model->grid.dim - 1, .up = 1};

  for (PetscInt a = 0; a < model->grid.dim; a++) {
    PetscReal gravity = 0.;

    for (PetscInt l = 0; l < model->load_count; l++)
      if (model->loads[l].type == MPM_LOAD_GRAVITY)
        gravity += MpmModelLoadFactor(model, l, model->time_end) * model->loads[l].value[a];
    if (gravity != 0.)
      vertical = (MpmVertical){.axis = a, .up = gravity < 0. ? 1 : -1, .gravity = PetscAbsReal(gravity)};
  }
  return vertical;
}

/* Gives point p the stress; what MpmInitialFind says. */
static int SetStress(MpmModel model, const MpmInitial *initial, const MpmRest *rest, MpmPoints *points, PetscInt p,
                     PetscReal stress[])
{
  const PetscInt dim = model->grid.dim, size = model->particles.state_size, own = initial->material->state_size;
  PetscReal      state[MPM_INITIAL_STATE], U[MPM_MAX_DIM], *F                   = &points->F[p * dim * dim];
  const int      answer = MpmInitialFind(initial, size ? &points->state[p * size] : NULL, stress, F, state);

  if (answer == 2 || model->stretch(F, U)) return 2;
  for (PetscInt k = 0; k < own; k++) points->state[p * size + k] = state[k];
  for (PetscInt a = 0; a < dim; a++) points->half_length[p * dim + a] = rest->domain[p * dim + a] / U[a];
  points->volume0[p] = rest->volume[p] / MpmDeterminant(dim, F);
  for (PetscInt c = 0; c < model->particles.stress_size; c++)
    points->stress[p * model->particles.stress_size + c] = stress[c];
  return answer;
}

/*
  Gives all points their stress, `stress_size` components each; counts those that the yield surface moved, and those that
  cannot have theirs.
*/
static PetscErrorCode SetStresses(MpmModel model, MpmRest *rest, const PetscReal goal[], PetscInt64 *without)
{
  const PetscInt size     = model->particles.stress_size;
  PetscInt64     count[2] = {0, 0};
  MpmInitial    *initial;
  MpmPoints      points;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(model->material_count, &initial));
  for (PetscInt m = 0; m < model->material_count; m++)
    PetscCall(MpmInitialCreate(&model->materials[m], model->grid.dim, &initial[m]));
  PetscCall(MpmParticlesGetArrays(&model->particles, &points));
  for (PetscInt p = 0; p < rest->n; p++) {
    PetscReal stress[6] = {0.};
    int       answer;

    for (PetscInt c = 0; c < size; c++) stress[c] = goal[p * size + c];
    answer = SetStress(model, &initial[points.material[p]], rest, &points, p, stress);
    if (answer) count[answer - 1]++;
  }
  PetscCall(MpmParticlesRestoreArrays(&model->particles, &points));
  PetscCall(PetscFree(initial));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, count, 2, MPIU_INT64, MPI_SUM, model->comm));
  rest->outside = count[0];
  *without      = count[1];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The stress of k0 from the weight above, for all points. */
static PetscErrorCode FindK0(MpmModel model, MpmRest *rest, PetscReal stress[])
{
  const PetscReal   k0       = model->stages[model->stage].geostatic.k0;
  const PetscInt    size     = model->particles.stress_size;
  const MpmVertical vertical = FindVertical(model);
  PetscReal        *pressure;
  MpmPoints         points;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(rest->n, &pressure));
  PetscCall(MpmParticlesGetArrays(&model->particles, &points));
  PetscCall(MpmOverburden(&model->grid, &points, &vertical, rest->domain, pressure));
  PetscCall(MpmParticlesRestoreArrays(&model->particles, &points));
  for (PetscInt p = 0; p < rest->n; p++) {
    for (PetscInt c = 0; c < size; c++)
      stress[p * size + c] = c < 3 ? -pressure[p] * (c == vertical.axis ? 1. : k0) : 0.;
    rest->largest = PetscMax(rest->largest, PetscMax(1., k0) * pressure[p]);
  }
  PetscCall(PetscFree(pressure));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &rest->largest, 1, MPIU_REAL, MPIU_MAX, model->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Corrections of a small-strain law's stress; each leaves a strain's part of what the last one left. */
#define SMALL_STRAIN_ROUNDS 4

/*
  Small-strain laws, whose forces are those of sigma F^T/J in the shape as it stands: up the axis v their stress must be
  J/F_vv times the weight above, and the others by as much.
*/
static PetscErrorCode CorrectSmallStrain(MpmModel model, MpmRest *rest, PetscReal stress[])
{
  const PetscInt dim = model->grid.dim, size = model->particles.stress_size, v = FindVertical(model).axis;
  PetscReal     *goal;
  PetscInt64     without;
  PetscBool      any = PETSC_FALSE;
  MpmPoints      points;

  PetscFunctionBeginUser;
  for (PetscInt m = 0; m < model->material_count; m++)
    if (model->materials[m].info.traits & MPM_LAW_SMALL_STRAIN) any = PETSC_TRUE;
  if (!any) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1((rest->n * size), &goal));
  PetscCall(PetscArraycpy(goal, stress, rest->n * size));
  for (PetscInt k = 0; k < SMALL_STRAIN_ROUNDS; k++) {
    PetscCall(SetStresses(model, rest, stress, &without));
    PetscCall(MpmParticlesGetArrays(&model->particles, &points));
    for (PetscInt p = 0; p < rest->n; p++) {
      const PetscReal *F = &points.F[p * dim * dim];

      if (!(model->materials[points.material[p]].info.traits & MPM_LAW_SMALL_STRAIN)) continue;
      for (PetscInt c = 0; c < size; c++)
        stress[p * size + c] = goal[p * size + c] * MpmDeterminant(dim, F) / F[v * (dim + 1)];
    }
    PetscCall(MpmParticlesRestoreArrays(&model->particles, &points));
  }
  PetscCall(PetscFree(goal));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Stand-ins for the materials: Hencky's law, but for small-strain laws, which are elastic and whose forces differ. */
static PetscErrorCode StandInsCreate(MpmModel model, PetscReal nu, MpmMaterial **standins)
{
  const PetscInt directions[MPM_FORM_COUNT] = {0, 1, model->layout.kernel->inputs};

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(model->material_count, standins));
  for (PetscInt m = 0; m < model->material_count; m++) {
    MpmMaterial *standin = &(*standins)[m];

    *standin = model->materials[m];
    if (standin->info.traits & MPM_LAW_SMALL_STRAIN) {
      PetscCall(PetscMalloc1(standin->info.parameter_count, &standin->parameter));
      PetscCall(PetscArraycpy(standin->parameter, model->materials[m].parameter, standin->info.parameter_count));
      continue;
    }
    standin->state_size = 0;
    for (PetscInt form = 0; form < MPM_FORM_COUNT; form++) {
      PetscCheck(MpmLawFind("hencky", model->grid.dim, directions[form], &standin->info), PETSC_COMM_SELF,
                 PETSC_ERR_PLIB, "law hencky is not compiled");
      standin->law[form] = standin->info.law;
    }
    PetscCall(PetscMalloc1(standin->info.parameter_count, &standin->parameter)); /* density, E, nu */
    standin->parameter[0] = standin->density;
    standin->parameter[1] = standin->penalty;
    standin->parameter[2] = nu;
    standin->stiffness    = standin->info.stiffness(standin->parameter);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode StandInsDestroy(MpmModel model, MpmMaterial **standins)
{
  PetscFunctionBeginUser;
  for (PetscInt m = 0; m < model->material_count; m++) PetscCall(PetscFree((*standins)[m].parameter));
  PetscCall(PetscFree(*standins));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- in balance ---- */

/* The search. */
typedef struct {
  MpmModel   model;
  MpmRest   *rest;
  PetscReal  k0;
  PetscInt   axis;         /* vertical one */
  PetscReal *balanced;     /* the last stresses in balance */
  PetscReal  error, start; /* of the ratio at a point: the last largest one, and the first */
  PetscReal  distance;     /* root mean square of the last errors */
  PetscInt   rounds;
} Balance;

/* Poisson's ratio of an isotropic law with the constrained modulus M and Young's modulus E. */
static PetscReal PoissonRatio(PetscReal M, PetscReal E)
{
  return (PetscSqrtReal(PetscMax((M - E) * (9. * M - E), 0.)) - (M - E)) / (4. * M);
}

/* Nearest stress with the ratio k0, in the energy of isotropic elasticity; zz in 2D follows from the others. */
static void Nearest(const Balance *balance, PetscReal nu, const PetscReal stress[], PetscReal nearest[])
{
  const PetscInt  dim = balance->model->grid.dim, v = balance->axis, size = balance->model->particles.stress_size;
  const PetscReal k0 = balance->k0, across = k0 - nu * (1. + k0);
  const PetscReal up       = dim == 3 ? 1. - 2. * nu * k0 : 1. - nu * (1. + k0);
  PetscReal       vertical = up * stress[v], sum = up;

  for (PetscInt a = 0; a < dim; a++) {
    if (a == v) continue;
    vertical += across * stress[a];
    sum += across * k0;
  }
  vertical /= sum;
  for (PetscInt c = 0; c < size; c++) nearest[c] = c >= 3 ? stress[c] : vertical * (c == v ? 1. : k0);
}

/* How far the stress in balance is from the ratio: largest error of a point, and distance in the space of stresses. */
static PetscErrorCode MeasureError(Balance *balance)
{
  const PetscInt  dim = balance->model->grid.dim, size = balance->model->particles.stress_size, v = balance->axis;
  const PetscReal floor = BALANCE_FLOOR * balance->rest->largest;
  PetscReal       error = 0., square[2] = {0., 0.};

  PetscFunctionBeginUser;
  for (PetscInt p = 0; p < balance->rest->n; p++) {
    const PetscReal *stress = &balance->balanced[p * size];

    for (PetscInt a = 0; a < dim; a++) {
      const PetscReal away = PetscAbsReal(stress[a] - balance->k0 * stress[v]);

      if (a == v) continue;
      error = PetscMax(error, away / (PetscAbsReal(stress[v]) + floor));
      square[0] += PetscSqr(away);
      square[1] += PetscSqr(stress[v]);
    }
  }
  PetscCall(MPIU_Allreduce(&error, &balance->error, 1, MPIU_REAL, MPIU_MAX, balance->model->comm));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, square, 2, MPIU_REAL, MPIU_SUM, balance->model->comm));
  balance->distance = PetscSqrtReal(square[0] / PetscMax(square[1], PETSC_SMALL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Steps until the stand-ins are at rest, from the stresses `goal`. */
static PetscErrorCode SettleStandIns(Balance *balance, const PetscReal goal[], const char **why)
{
  MpmModel   model = balance->model;
  MpmRest   *rest  = balance->rest;
  PetscInt64 without;
  PetscBool  hopeless;
  MpmPoints  points;

  PetscFunctionBeginUser;
  PetscCall(SetStresses(model, rest, goal, &without));
  *why = without ? "points cannot have their stress" : NULL;
  for (PetscInt it = 0; it < BALANCE_LIMIT && !*why && (!it || rest->moved > BALANCE_TOLERANCE * rest->height); it++)
    PetscCall(MpmRestSettle(model, rest, 1., why, &hopeless));
  PetscCall(MpmParticlesRestoreArrays(&model->particles, &model->points)); /* a failed step has kept them */
  PetscCall(MpmParticlesGetArrays(&model->particles, &points));
  if (!*why) PetscCall(PetscArraycpy(balance->balanced, points.stress, rest->n * model->particles.stress_size));
  PetscCall(MpmParticlesRestoreArrays(&model->particles, &points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* x, the points' stresses with the ratio k0, less the nearest ones to their balance. */
static PetscErrorCode FormBalance(SNES snes, Vec x, Vec f, void *context)
{
  Balance         *balance = (Balance *)context;
  MpmModel         model   = balance->model;
  const PetscInt   n = balance->rest->n, size = model->particles.stress_size;
  const PetscReal *goal;
  PetscReal       *away, nearest[6];
  const char      *why;
  MpmPoints        points;

  PetscFunctionBeginUser;
  PetscCall(VecGetArrayRead(x, &goal));
  PetscCall(SettleStandIns(balance, goal, &why));
  PetscCall(VecGetArrayWrite(f, &away));
  PetscCall(MpmParticlesGetArrays(&model->particles, &points));
  for (PetscInt p = 0; p < n; p++) {
    const MpmMaterial *standin = &model->materials[points.material[p]];

    Nearest(balance, PoissonRatio(standin->stiffness, standin->penalty), &balance->balanced[p * size], nearest);
    for (PetscInt c = 0; c < size; c++) away[p * size + c] = goal[p * size + c] - nearest[c];
  }
  PetscCall(MpmParticlesRestoreArrays(&model->particles, &points));
  PetscCall(VecRestoreArrayWrite(f, &away));
  PetscCall(VecRestoreArrayRead(x, &goal));
  PetscCall(MeasureError(balance));
  if (why) PetscCall(SNESSetFunctionDomainError(snes));
  else if (!balance->rounds++) balance->start = balance->error;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TestBalance(SNES snes, PetscInt it, PetscReal xnorm, PetscReal ynorm, PetscReal fnorm,
                                  SNESConvergedReason *reason, void *context)
{
  const Balance *balance = (const Balance *)context;

  PetscFunctionBeginUser;
  (void)snes;
  (void)xnorm;
  (void)ynorm;
  *reason = SNES_CONVERGED_ITERATING;
  if (PetscIsInfOrNanReal(fnorm)) *reason = SNES_DIVERGED_FNORM_NAN;
  else if (balance->error <= BALANCE_RATIO) *reason = SNES_CONVERGED_FNORM_ABS;
  else if (!it && balance->distance > BALANCE_LEVEL * PetscMax(balance->k0, 0.1)) *reason = SNES_DIVERGED_DTOL;
  else if (it >= BALANCE_TRIES && balance->error > PetscPowRealInt(BALANCE_GAIN, it) * balance->start)
    *reason = SNES_DIVERGED_DTOL;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Runs the search from `stress`; `found` says whether the ratio holds in balance->balanced. */
static PetscErrorCode SearchBalance(Balance *balance, const PetscReal stress[], PetscBool *found)
{
  const PetscInt      n = balance->rest->n * balance->model->particles.stress_size;
  SNESConvergedReason reason;
  SNES                snes;
  PetscScalar        *array;
  PetscBool           chosen;
  Vec                 x;

  PetscFunctionBeginUser;
  PetscCall(VecCreateMPI(balance->model->comm, n, PETSC_DETERMINE, &x));
  PetscCall(VecGetArrayWrite(x, &array));
  PetscCall(PetscArraycpy(array, stress, n));
  PetscCall(VecRestoreArrayWrite(x, &array));
  PetscCall(SNESCreate(balance->model->comm, &snes));
  PetscCall(SNESSetType(snes, SNESANDERSON));
  PetscCall(SNESSetOptionsPrefix(snes, "k0_"));
  PetscCall(PetscOptionsHasName(NULL, NULL, "-k0_snes_anderson_m", &chosen));
  if (!chosen) PetscCall(PetscOptionsSetValue(NULL, "-k0_snes_anderson_m", BALANCE_MEMORY));
  PetscCall(SNESSetFunction(snes, NULL, FormBalance, balance));
  PetscCall(SNESSetConvergenceTest(snes, TestBalance, balance, NULL));
  PetscCall(SNESSetTolerances(snes, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT, BALANCE_ROUNDS, 10 * BALANCE_ROUNDS));
  PetscCall(SNESSetFromOptions(snes));
  PetscCall(SNESSolve(snes, NULL, x));
  PetscCall(SNESGetConvergedReason(snes, &reason));
  *found = (PetscBool)(reason > 0);
  PetscCall(SNESDestroy(&snes));
  PetscCall(VecDestroy(&x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Brings the stress of k0 into balance by elastic stand-ins. Where no stress with that ratio is in balance, splines start
  from the last balance that was found, near that stress, and other shapes from the stress itself.
*/
static PetscErrorCode BalanceK0(MpmModel model, MpmRest *rest, PetscReal stress[])
{
  const PetscReal k0        = model->stages[model->stage].geostatic.k0;
  const PetscInt  n         = rest->n * model->particles.stress_size;
  MpmMaterial    *materials = model->materials, *standins;
  PetscBool      *remembers = rest->remembers, found = PETSC_FALSE;
  Balance         balance = {.model = model, .rest = rest, .k0 = k0, .axis = FindVertical(model).axis};

  PetscFunctionBeginUser;
  PetscCall(StandInsCreate(model, PetscMin(k0 / (1. + k0), BALANCE_NU), &standins));
  PetscCall(PetscCalloc1(n, &balance.balanced));
  PetscCall(PetscCalloc1(model->material_count, &rest->remembers));
  model->materials = standins;
  PetscCall(SearchBalance(&balance, stress, &found));
  if (found || (balance.rounds && MpmShapeDegree(model->shape) > 1))
    PetscCall(PetscArraycpy(stress, balance.balanced, n));
  PetscCall(StandInsDestroy(model, &standins));
  PetscCall(PetscFree(rest->remembers));
  PetscCall(PetscFree(balance.balanced));
  model->materials = materials;
  rest->remembers  = remembers;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmRestSetK0(MpmModel model, MpmRest *rest)
{
  const PetscInt size = model->particles.stress_size;
  PetscInt64     without;
  PetscReal     *stress;
  MpmPoints      points;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1((rest->n * size), &stress));
  PetscCall(FindK0(model, rest, stress));
  PetscCall(CorrectSmallStrain(model, rest, stress));
  PetscCall(PetscMalloc1((rest->n * size), &rest->start));
  PetscCall(PetscArraycpy(rest->start, stress, rest->n * size));
  PetscCall(BalanceK0(model, rest, stress));
  PetscCall(SetStresses(model, rest, stress, &without));
  MpmCheckInput(!without, "-mpm_stage_%s_geostatic_k0 %g: %" PetscInt64_FMT " points cannot have that stress",
                model->stages[model->stage].name, (double)model->stages[model->stage].geostatic.k0, without);
  PetscCall(PetscFree(stress));
  PetscCall(MpmParticlesGetArrays(&model->particles, &points));
  for (PetscInt p = 0; p < rest->n; p++) { /* a law without history has its own stress across the plane */
    if (size == 4 && !rest->remembers[points.material[p]]) rest->start[4 * p + 2] = points.stress[4 * p + 2];
  }
  PetscCall(MpmParticlesRestoreArrays(&model->particles, &points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

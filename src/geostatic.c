/*
  A geostatic stage: the state of stress under which the ground is at rest in the very shape in which it was drawn.

  Start. `gravity`: no stress, and the loads grow in the stage's steps. `k0`: the vertical stress is the weight above
  (overburden.c), the horizontal ones k0 times that, and the loads act in full at once; history, and F where a law needs
  it, follow from the stress (initial.c).

  Equilibrium. The sums over points depend on where the points stand over the grid, so that equilibrium must be found in
  the shape that the next stage starts from: a step is solved, its stress and history are kept, and the points are put
  back. What is then out of balance is the stress times the step's strain, so that each such step is shorter than the
  last by about a strain, until the largest displacement is below the tolerance. Putting back leaves volume and domain
  where they were: a law whose history holds its stress gets its old F and the Kirchhoff stress J sigma; for any other law
  F stays that of the step, and the initial volume becomes V/det F, the initial domain that over the stretch.
*/
#include "mpmimpl.h"

/* Balance of k0 for splines: most steps, what may be left of the motion, and the largest k0 it is found for. */
#define BALANCE_LIMIT     12
#define BALANCE_TOLERANCE 1e-9
#define BALANCE_MOST      0.95

/* What the points return to, and what the report needs. */
typedef struct {
  PetscInt   n;
  PetscReal *x, *volume, *domain; /* position, volume, half lengths of the domain */
  PetscReal *F;                   /* before the step under way */
  PetscReal *start;               /* the stress that k0 gave, or NULL */
  PetscReal  height;
  PetscBool *remembers; /* per material */
  PetscReal  moved;     /* largest displacement of the last step */
  PetscReal  correction, largest;
  PetscInt64 outside; /* points that the yield surface moved */
} Rest;

static PetscErrorCode RestCreate(MpmModel model, MpmPoints *points, Rest *rest)
{
  const PetscInt dim = model->grid.dim;
  PetscReal      reach[2 * MPM_MAX_DIM];

  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(rest, sizeof(*rest)));
  rest->n = points->count;
  PetscCall(PetscMalloc4((rest->n * dim), &rest->x, rest->n, &rest->volume, (rest->n * dim), &rest->domain,
                         (rest->n * dim * dim), &rest->F));
  PetscCall(PetscCalloc1(model->material_count, &rest->remembers));
  for (PetscInt k = 0; k < 2 * MPM_MAX_DIM; k++) reach[k] = PETSC_NINFINITY;
  for (PetscInt p = 0; p < rest->n; p++) {
    const PetscReal *F = &points->F[p * dim * dim];
    PetscReal        U[MPM_MAX_DIM];

    PetscCheck(!model->stretch(F, U), PETSC_COMM_SELF, PETSC_ERR_FP, "point %" PetscInt_FMT " has no stretch",
               points->id[p]);
    rest->volume[p] = points->volume0[p] * MpmDeterminant(dim, F);
    for (PetscInt a = 0; a < dim; a++) {
      const PetscReal x = points->x[p * dim + a];

      rest->x[p * dim + a]      = x;
      rest->domain[p * dim + a] = points->half_length[p * dim + a] * U[a];
      reach[a]                  = PetscMax(reach[a], x + rest->domain[p * dim + a]);
      reach[MPM_MAX_DIM + a]    = PetscMax(reach[MPM_MAX_DIM + a], rest->domain[p * dim + a] - x);
    }
  }
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, reach, 2 * MPM_MAX_DIM, MPIU_REAL, MPIU_MAX, model->comm));
  rest->height = reach[dim - 1] + reach[MPM_MAX_DIM + dim - 1];
  for (PetscInt m = 0; m < model->material_count; m++) {
    MpmInitial initial;

    PetscCall(MpmInitialCreate(&model->materials[m], dim, &initial));
    rest->remembers[m] = initial.remembers;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode RestDestroy(Rest *rest)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree4(rest->x, rest->volume, rest->domain, rest->F));
  PetscCall(PetscFree(rest->start));
  PetscCall(PetscFree(rest->remembers));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- a step, and back ---- */

/* The points go back to where they were; stress and history stay. */
static PetscErrorCode PutBack(MpmModel model, Rest *rest)
{
  const PetscInt dim = model->grid.dim, size = model->particles.stress_size;
  PetscReal      largest[2] = {0., 0.};
  MpmPoints      points;

  PetscFunctionBeginUser;
  PetscCall(MpmParticlesGetArrays(&model->particles, &points));
  for (PetscInt p = 0; p < rest->n; p++) {
    PetscReal *F = &points.F[p * dim * dim], *stress = &points.stress[p * size], U[MPM_MAX_DIM], distance = 0.;

    for (PetscInt a = 0; a < dim; a++) {
      distance += PetscSqr(points.x[p * dim + a] - rest->x[p * dim + a]);
      points.x[p * dim + a] = rest->x[p * dim + a];
    }
    largest[0] = PetscMax(largest[0], PetscSqrtReal(distance));
    if (rest->remembers[points.material[p]]) {
      const PetscReal J = MpmDeterminant(dim, F) / MpmDeterminant(dim, &rest->F[p * dim * dim]);

      for (PetscInt k = 0; k < dim * dim; k++) F[k] = rest->F[p * dim * dim + k];
      for (PetscInt c = 0; c < size; c++) stress[c] *= J;
    } else {
      PetscCheck(!model->stretch(F, U), PETSC_COMM_SELF, PETSC_ERR_FP, "point %" PetscInt_FMT " has no stretch",
                 points.id[p]);
      points.volume0[p] = rest->volume[p] / MpmDeterminant(dim, F);
      for (PetscInt a = 0; a < dim; a++) points.half_length[p * dim + a] = rest->domain[p * dim + a] / U[a];
    }
    for (PetscInt c = 0; rest->start && c < size; c++)
      largest[1] = PetscMax(largest[1], PetscAbsReal(stress[c] - rest->start[p * size + c]));
  }
  PetscCall(MpmParticlesRestoreArrays(&model->particles, &points));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, largest, 2, MPIU_REAL, MPIU_MAX, model->comm));
  rest->moved      = largest[0];
  rest->correction = largest[1];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* One step under `scale` times the loads, and back. */
static PetscErrorCode Settle(MpmModel model, Rest *rest, PetscReal scale, const char **why, PetscBool *hopeless)
{
  MpmPoints points;

  PetscFunctionBeginUser;
  PetscCall(MpmParticlesRestoreArrays(&model->particles, &model->points)); /* a failed step has kept them */
  PetscCall(MpmParticlesGetArrays(&model->particles, &points));
  PetscCall(PetscArraycpy(rest->F, points.F, rest->n * model->grid.dim * model->grid.dim));
  PetscCall(MpmParticlesRestoreArrays(&model->particles, &points));
  model->load_scale = scale;
  model->dt_last    = 0.;
  PetscCall(MpmStep(model, model->time_end, model->time_end - model->time_start, PETSC_FALSE, why, hopeless));
  if (!*why) PetscCall(PutBack(model, rest));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the stress of k0 ---- */

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

/* Corrections of a small-strain law's stress; each leaves a strain's part of what the last one left. */
#define SMALL_STRAIN_ROUNDS 4

/*
  The stress that holds the weight. A small-strain law's forces are those of sigma F^T/J in the shape as it stands, so
  that up the axis v the stress must be J/F_vv times the weight above, and the others by as much.
*/
static int FindStress(MpmModel model, const MpmInitial *initial, const PetscReal state_n[], PetscInt axis,
                      PetscReal stress[], PetscReal F[], PetscReal state[])
{
  const PetscInt dim    = model->grid.dim,
                 rounds = initial->material->info.traits & MPM_LAW_SMALL_STRAIN ? SMALL_STRAIN_ROUNDS : 0;
  PetscReal goal[6];
  int       answer;

  for (PetscInt c = 0; c < 6; c++) goal[c] = stress[c];
  answer = MpmInitialFind(initial, state_n, stress, F, state);
  for (PetscInt k = 0; k < rounds && !answer; k++) {
    for (PetscInt c = 0; c < 6; c++) stress[c] = goal[c] * MpmDeterminant(dim, F) / F[axis * (dim + 1)];
    answer = MpmInitialFind(initial, state_n, stress, F, state);
  }
  return answer;
}

/* Gives point p the stress; what MpmInitialFind says. */
static int SetStress(MpmModel model, const MpmInitial *initial, const Rest *rest, MpmPoints *points, PetscInt p,
                     PetscInt axis, PetscReal stress[])
{
  const PetscInt dim = model->grid.dim, size = model->particles.state_size, own = initial->material->state_size;
  PetscReal      state[MPM_INITIAL_STATE], U[MPM_MAX_DIM], *F                   = &points->F[p * dim * dim];
  const int      answer = FindStress(model, initial, size ? &points->state[p * size] : NULL, axis, stress, F, state);

  if (answer == 2 || model->stretch(F, U)) return 2;
  for (PetscInt k = 0; k < own; k++) points->state[p * size + k] = state[k];
  for (PetscInt a = 0; a < dim; a++) points->half_length[p * dim + a] = rest->domain[p * dim + a] / U[a];
  points->volume0[p] = rest->volume[p] / MpmDeterminant(dim, F);
  for (PetscInt c = 0; c < model->particles.stress_size; c++)
    points->stress[p * model->particles.stress_size + c] = stress[c];
  return answer;
}

/* Gives all points their stress, `stress_size` components each; counts those that the yield surface moved. */
static PetscErrorCode SetStresses(MpmModel model, Rest *rest, const PetscReal goal[])
{
  const PetscInt size = model->particles.stress_size, axis = FindVertical(model).axis;
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
    answer = SetStress(model, &initial[points.material[p]], rest, &points, p, axis, stress);
    if (answer) count[answer - 1]++;
  }
  PetscCall(MpmParticlesRestoreArrays(&model->particles, &points));
  PetscCall(PetscFree(initial));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, count, 2, MPIU_INT64, MPI_SUM, model->comm));
  rest->outside = count[0];
  MpmCheckInput(!count[1], "-mpm_stage_%s_geostatic_k0 %g: %" PetscInt64_FMT " points cannot have that stress",
                model->stages[model->stage].name, (double)model->stages[model->stage].geostatic.k0, count[1]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The stress of k0 from the weight above, for all points. */
static PetscErrorCode FindK0(MpmModel model, Rest *rest, PetscReal stress[])
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

/* Elastic stand-ins for the materials, with Poisson's ratio k0/(1 + k0). */
static PetscErrorCode StandInsCreate(MpmModel model, PetscReal k0, MpmMaterial **standins)
{
  const PetscInt directions[MPM_FORM_COUNT] = {0, 1, model->layout.kernel->inputs};

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(model->material_count, standins));
  for (PetscInt m = 0; m < model->material_count; m++) {
    MpmMaterial *standin = &(*standins)[m];

    *standin            = model->materials[m];
    standin->state_size = 0;
    for (PetscInt form = 0; form < MPM_FORM_COUNT; form++) {
      PetscCheck(MpmLawFind("hencky", model->grid.dim, directions[form], &standin->info), PETSC_COMM_SELF,
                 PETSC_ERR_PLIB, "law hencky is not compiled");
      standin->law[form] = standin->info.law;
    }
    PetscCall(PetscMalloc1(standin->info.parameter_count, &standin->parameter)); /* density, E, nu */
    standin->parameter[0] = standin->density;
    standin->parameter[1] = standin->penalty;
    standin->parameter[2] = k0 / (1. + k0);
    standin->stiffness    = standin->info.stiffness(standin->parameter);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Splines sum the exact stress of level ground to forces that are not quite the weights, and what balances them would
  spoil k0. Elasticity under the ratio k0/(1 + k0) answers a vertical stress with k0 times that sideways, so the balance
  is found with it first; the materials then start from that stress.
*/
static PetscErrorCode BalanceK0(MpmModel model, Rest *rest, PetscReal stress[])
{
  const PetscReal k0        = model->stages[model->stage].geostatic.k0;
  MpmMaterial    *materials = model->materials, *standins;
  PetscBool      *remembers = rest->remembers, hopeless;
  const char     *why       = NULL;
  MpmPoints       points;

  PetscFunctionBeginUser;
  PetscCall(StandInsCreate(model, k0, &standins));
  model->materials = standins;
  PetscCall(PetscCalloc1(model->material_count, &rest->remembers));
  PetscCall(SetStresses(model, rest, stress));
  for (PetscInt it = 0; it < BALANCE_LIMIT && !why && (!it || rest->moved > BALANCE_TOLERANCE * rest->height); it++)
    PetscCall(Settle(model, rest, 1., &why, &hopeless));
  PetscCall(MpmParticlesRestoreArrays(&model->particles, &model->points)); /* a failed step has kept them */
  PetscCall(MpmParticlesGetArrays(&model->particles, &points));
  if (!why) PetscCall(PetscArraycpy(stress, points.stress, rest->n * model->particles.stress_size));
  PetscCall(MpmParticlesRestoreArrays(&model->particles, &points));
  for (PetscInt m = 0; m < model->material_count; m++) PetscCall(PetscFree(standins[m].parameter));
  PetscCall(PetscFree(standins));
  PetscCall(PetscFree(rest->remembers));
  model->materials = materials;
  rest->remembers  = remembers;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SetK0(MpmModel model, Rest *rest)
{
  const PetscReal k0   = model->stages[model->stage].geostatic.k0;
  const PetscInt  size = model->particles.stress_size;
  PetscReal      *stress;
  MpmPoints       points;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1((rest->n * size), &stress));
  PetscCall(FindK0(model, rest, stress));
  PetscCall(PetscMalloc1((rest->n * size), &rest->start));
  PetscCall(PetscArraycpy(rest->start, stress, rest->n * size));
  if (model->shape != MPM_SHAPE_LINEAR && model->shape != MPM_SHAPE_GIMP && k0 < BALANCE_MOST)
    PetscCall(BalanceK0(model, rest, stress));
  PetscCall(SetStresses(model, rest, stress));
  PetscCall(PetscFree(stress));
  PetscCall(MpmParticlesGetArrays(&model->particles, &points));
  for (PetscInt p = 0; p < rest->n; p++) { /* a law without history has its own stress across the plane */
    if (size == 4 && !rest->remembers[points.material[p]]) rest->start[4 * p + 2] = points.stress[4 * p + 2];
  }
  PetscCall(MpmParticlesRestoreArrays(&model->particles, &points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- equilibrium ---- */

/* After a failed step: is there something to try? The ghost penalty, then a smaller part of the loads. */
static PetscErrorCode TryAgain(MpmModel model, PetscReal part, PetscReal *grow, const char *why, PetscBool *again)
{
  const PetscReal duration = model->time_end - model->time_start;

  PetscFunctionBeginUser;
  *again = PETSC_TRUE;
  if (model->ghost_rescue) {
    PetscCall(MpmModelSwitchGhostOn(model, why));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  *grow *= 0.5;
  *again = (PetscBool)(part < 1. && *grow * duration >= model->dt_min);
  model->cuts++;
  model->cuts_total++;
  if (*again) PetscCall(MpmTerminalNote(model, "%s; the loads grow by parts of %.4g", why, (double)*grow));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Steps until the points stay where they are; `solved` counts those under the full loads. */
static PetscErrorCode FindEquilibrium(MpmModel model, Rest *rest, PetscInt *solved, const char **why)
{
  const MpmGeostatic *geostatic = &model->stages[model->stage].geostatic;
  PetscReal           part      = geostatic->method == MPM_GEOSTATIC_K0 ? 1. : 0.; /* of the loads that act */
  PetscReal           grow      = PetscMin(model->dt_nominal / (model->time_end - model->time_start), 1.);
  PetscInt            newton = 0, linear = 0;
  PetscBool           hopeless, again;

  PetscFunctionBeginUser;
  *solved     = 0;
  model->cuts = 0;
  while (!*solved || rest->moved > geostatic->tolerance * rest->height) {
    const PetscReal next = part + grow > 1. - 1e-9 ? 1. : part + grow;

    if (*solved == geostatic->iterations) {
      PetscCall(PetscSNPrintf(model->lost, sizeof(model->lost),
                              "no equilibrium in %" PetscInt_FMT " iterations: points still move by %.3g m", *solved,
                              (double)rest->moved));
      *why = model->lost;
      break;
    }
    PetscCall(Settle(model, rest, next, why, &hopeless));
    newton += model->newton;
    linear += model->linear;
    if (*why) {
      again = PETSC_FALSE;
      if (!hopeless) PetscCall(TryAgain(model, part, &grow, *why, &again));
      if (!again) break;
      continue;
    }
    part = next;
    if (part == 1.) ++*solved;
  }
  model->newton     = newton;
  model->linear     = linear;
  model->load_scale = 1.;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode PrintRest(MpmModel model, const Rest *rest, PetscInt solved)
{
  PetscFunctionBeginUser;
  if (model->quiet) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscPrintf(model->comm, "  geostatic: at rest after %" PetscInt_FMT " iteration%s, to %.3g m", solved,
                        solved > 1 ? "s" : "", (double)rest->moved));
  if (rest->start)
    PetscCall(PetscPrintf(model->comm, "; the stress of k0 was corrected by up to %.4g Pa (largest: %.4g Pa)",
                          (double)rest->correction, (double)rest->largest));
  if (rest->outside)
    PetscCall(PetscPrintf(model->comm, ", at %" PetscInt64_FMT " points by the yield surface", rest->outside));
  PetscCall(PetscPrintf(model->comm, "\n"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmGeostaticRun(MpmModel model, const char **why)
{
  PetscInt  solved;
  MpmPoints points;
  Rest      rest;

  PetscFunctionBeginUser;
  PetscCall(MpmParticlesDistribute(&model->particles, &model->grid, why));
  if (*why) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmParticlesGetArrays(&model->particles, &points));
  PetscCall(RestCreate(model, &points, &rest));
  PetscCall(MpmParticlesRestoreArrays(&model->particles, &points));
  if (model->stages[model->stage].geostatic.method == MPM_GEOSTATIC_K0) PetscCall(SetK0(model, &rest));
  PetscCall(FindEquilibrium(model, &rest, &solved, why));
  if (!*why) {
    PetscCall(PrintRest(model, &rest, solved));
    model->time = model->time_end;
    model->step++;
  }
  PetscCall(RestDestroy(&rest));
  PetscFunctionReturn(PETSC_SUCCESS);
}

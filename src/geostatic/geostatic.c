/*
  A geostatic stage: the state of stress in equilibrium in the very shape in which the ground was drawn.

  Start. `gravity`: no stress, and the loads grow in the stage's steps. `k0`: the vertical stress is the weight above
  (overburden.c), the horizontal ones k0 times that, and the loads act in full at once (k0_balance.c); history, and F
  where a law needs it, follow from the stress (stress_inversion.c).

  Equilibrium. The sums over points depend on where the points stand over the grid, so that equilibrium must be found in
  the shape that the next stage starts from: a step is solved, its stress and history are kept, and the points are
  returned to their places. The residual is then the stress times the step's strain, so that each such step is shorter
  than the last by about a strain, until the largest displacement is below the tolerance. Volume and domain are restored
  as well: a law whose history holds its stress gets its old F and the Kirchhoff stress J sigma; for any other law F
  stays that of the step, and the initial volume becomes V/det F, the initial domain that over the stretch.
*/
#include "point/layout.h"
#include "point/material.h"
#include "point/stress_inversion.h"
#include "grid/shape.h"
#include "particles/particles.h"
#include "particles/points.h"
#include "space/rules.h"
#include "assembly/terms.h"
#include "query/model.h"
#include "step/energy.h"
#include "step/moving_grid.h"
#include "schedule/schedule.h"
#include "geostatic/geostatic.h"

static PetscErrorCode RestCreate(MpmModel model, MpmPoints *points, MpmRest *rest)
{
  const PetscInt dim = model->disc.dim, rates = model->disc.layout->rate.count, own = model->disc.layout->own.size;
  PetscReal      reach[2 * MPM_MAX_DIM];

  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(rest, sizeof(*rest)));
  rest->n = points->count;
  PetscCall(PetscMalloc4((rest->n * dim), &rest->x, rest->n, &rest->volume, (rest->n * dim), &rest->domain,
                         (rest->n * points->F_size), &rest->F));
  PetscCall(PetscMalloc4(rest->n, &rest->mass, (rest->n * rates), &rest->value, (rest->n * rates * dim),
                         &rest->value_gradient, (rest->n * own), &rest->own));
  PetscCall(PetscArraycpy(rest->value, points->physics.value, rest->n * rates));
  PetscCall(PetscArraycpy(rest->value_gradient, points->physics.value_gradient, rest->n * rates * dim));
  PetscCall(PetscArraycpy(rest->own, points->physics.own, rest->n * own));
  for (PetscInt p = 0; p < rest->n; p++)
    rest->mass[p] = MpmPointMassNow(points, model->scene.materials->at, model->disc.layout, p);
  PetscCall(PetscCalloc1(model->scene.materials->count, &rest->stateful));
  for (PetscInt k = 0; k < 2 * MPM_MAX_DIM; k++) reach[k] = PETSC_NINFINITY;
  for (PetscInt p = 0; p < rest->n; p++) {
    const PetscReal *F = MpmPointF(points, p);
    PetscReal        U[MPM_MAX_DIM];

    PetscCheck(!model->scene.deformation.stretch(F, U), PETSC_COMM_SELF, PETSC_ERR_FP,
               "point %" PetscInt_FMT " has no stretch", points->id[p]);
    rest->volume[p] = points->volume0[p] * MpmPointJ(points, p);
    for (PetscInt a = 0; a < dim; a++) {
      const PetscReal x = points->x[p * dim + a];

      rest->x[p * dim + a]      = x;
      rest->domain[p * dim + a] = points->domain.half_length[p * dim + a] * U[a];
      reach[a]                  = PetscMax(reach[a], x + rest->domain[p * dim + a]);
      reach[MPM_MAX_DIM + a]    = PetscMax(reach[MPM_MAX_DIM + a], rest->domain[p * dim + a] - x);
    }
  }
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, reach, 2 * MPM_MAX_DIM, MPIU_REAL, MPIU_MAX, model->comm));
  rest->height = reach[dim - 1] + reach[MPM_MAX_DIM + dim - 1];
  for (PetscInt m = 0; m < model->scene.materials->count; m++) {
    MpmInitial initial;

    PetscCall(MpmInitialCreate(&model->scene.materials->at[m], dim, &initial));
    rest->stateful[m] = initial.stateful;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode RestDestroy(MpmRest *rest)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree4(rest->x, rest->volume, rest->domain, rest->F));
  PetscCall(PetscFree4(rest->mass, rest->value, rest->value_gradient, rest->own));
  PetscCall(PetscFree(rest->start));
  PetscCall(PetscFree(rest->stateful));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmRestKeepMass(MpmModel model, const MpmRest *rest)
{
  MpmPoints points;

  PetscFunctionBeginUser;
  if (model->disc.layout->own.taken_up < 0) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  for (PetscInt p = 0; p < rest->n; p++)
    points.mass[p] += rest->mass[p] - MpmPointMassNow(&points, model->scene.materials->at, model->disc.layout, p);
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The water's pressure, a part of it while the loads grow. */
static PetscErrorCode SetWater(MpmModel model, const MpmRest *rest, PetscReal part)
{
  const PetscInt rates = model->disc.layout->rate.count, dim = model->disc.dim;
  MpmPoints      points;

  PetscFunctionBeginUser;
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  for (PetscInt k = 0; k < rest->n * rates; k++) points.physics.value[k] = part * rest->value[k];
  for (PetscInt k = 0; k < rest->n * rates * dim; k++)
    points.physics.value_gradient[k] = part * rest->value_gradient[k];
  PetscCall(PetscArraycpy(points.physics.own, rest->own, rest->n * model->disc.layout->own.size));
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- a step, and back ---- */

/* The points go back to where they were; stress and history stay. */
static PetscErrorCode PutBack(MpmModel model, MpmRest *rest)
{
  const PetscInt dim = model->disc.dim, size = model->state.particles->stress_size;
  PetscReal      largest[2] = {0., 0.};
  MpmPoints      points;

  PetscFunctionBeginUser;
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  for (PetscInt p = 0; p < rest->n; p++) {
    PetscReal *F = MpmPointF(&points, p), *stress = &points.stress[p * size], U[MPM_MAX_DIM], distance = 0.;

    for (PetscInt a = 0; a < dim; a++) {
      distance += PetscSqr(points.x[p * dim + a] - rest->x[p * dim + a]);
      points.x[p * dim + a] = rest->x[p * dim + a];
    }
    largest[0] = PetscMax(largest[0], PetscSqrtReal(distance));
    if (rest->stateful[points.material[p]]) {
      const PetscReal J = MpmPointJ(&points, p) / MpmDeterminant(points.F_size, &rest->F[p * points.F_size]);

      for (PetscInt k = 0; k < points.F_size; k++) F[k] = rest->F[p * points.F_size + k];
      for (PetscInt c = 0; c < size; c++) stress[c] *= J;
    } else {
      PetscCheck(!model->scene.deformation.stretch(F, U), PETSC_COMM_SELF, PETSC_ERR_FP,
                 "point %" PetscInt_FMT " has no stretch", points.id[p]);
      points.volume0[p] = rest->volume[p] / MpmPointJ(&points, p);
      for (PetscInt a = 0; a < dim; a++) points.domain.half_length[p * dim + a] = rest->domain[p * dim + a] / U[a];
    }
    for (PetscInt c = 0; rest->start && c < size; c++)
      largest[1] = PetscMax(largest[1], PetscAbsReal(stress[c] - rest->start[p * size + c]));
  }
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  PetscCall(SetWater(model, rest, 1.));
  PetscCall(MpmRestKeepMass(model, rest));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, largest, 2, MPIU_REAL, MPIU_MAX, model->comm));
  rest->moved      = largest[0];
  rest->correction = largest[1];
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmRestSettle(MpmModel model, MpmRest *rest, PetscReal scale, MpmOutcome *outcome)
{
  MpmPoints points;

  PetscFunctionBeginUser;
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, model->disc.points)); /* a failed step has kept them */
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  PetscCall(PetscArraycpy(rest->F, points.F, rest->n * points.F_size));
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  PetscCall(SetWater(model, rest, scale));
  model->state.scheme.load_scale = scale;
  model->state.dt.last           = 0.;
  PetscCall(
    MpmStep(model, model->state.period.end, model->state.period.end - model->state.period.start, PETSC_FALSE, outcome));
  if (!outcome->code) {
    PetscCall(PutBack(model, rest));
    PetscCall(MpmTermsPutBack(model->disc.terms, rest->n, model->state.particles));
    model->state.scheme.put_back = PETSC_TRUE;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- equilibrium ---- */

/* After a failed step: halves the fraction of the loads, `again` where a smaller one is left to try. */
static PetscErrorCode TryAgain(MpmModel model, PetscReal part, PetscReal *grow, const char *why, PetscBool *again)
{
  const PetscReal duration = model->state.period.end - model->state.period.start;

  PetscFunctionBeginUser;
  *grow *= 0.5;
  *again = (PetscBool)(part < 1. && *grow * duration >= model->state.dt.least);
  model->state.cuts.step++;
  model->state.cuts.total++;
  if (*again) PetscCall(MpmMonitorNote(&model->monitor, "%s; the loads grow by parts of %.4g", why, (double)*grow));
  PetscFunctionReturn(PETSC_SUCCESS);
}

#define SLOWS    0.5  /* of the way half of the iterations ago: with less it converges */
#define COLLAPSE 0.01 /* of the first displacement under the full loads: ground that moves on by more does not stand */

/* True where elements have fewer points a cell than they need. */
static PetscBool AreFew(const MpmModel model)
{
  const MpmShapeType shape = model->scene.shape.type;

  for (PetscInt m = 0; MpmShapeOrder(shape) > 1 && m < model->scene.materials->count; m++)
    if (MpmShapeSpacing(shape, model->scene.materials->at[m].spacing) >= 1.) return PETSC_TRUE;
  return PETSC_FALSE;
}

/*
  Reason for which no equilibrium was found in the allowed iterations: slow convergence, few points, collapse, or
  oscillation of points. The ghost penalty on increments holds modes that few points do not strain, and puts no lasting
  force against their loads. `first` and `half`: the largest displacements in the first iteration and after half of
  them, m.
*/
static void ExplainIterations(MpmModel model, const MpmRest *rest, PetscInt solved, PetscReal first, PetscReal half,
                              MpmOutcome *outcome)
{
  const MpmStage *stage = &model->scene.stages.at[model->state.stage];
  const PetscReal most = stage->geostatic.tolerance * rest->height, moved = rest->moved;
  char            text[256];

  if (AreFew(model))
    (void)PetscSNPrintf(text, sizeof(text), "%s needs %" PetscInt_FMT " points a cell on each axis to come to rest",
                        MpmShapeName(model->scene.shape.type), MpmShapeOrder(model->scene.shape.type) + 1);
  else if (moved < SLOWS * half) {
    const PetscReal rate = PetscPowReal(moved / half, 1. / PetscMax(1., (PetscReal)(solved - solved / 2)));

    (void)PetscSNPrintf(text, sizeof(text),
                        "it converges slowly, by %.3g an iteration; -mpm_stage_%.40s_geostatic_iterations %d should do",
                        (double)rate, stage->name,
                        (int)(solved + PetscCeilReal(1.2 * PetscLogReal(most / moved) / PetscLogReal(rate))));
  } else if (moved > COLLAPSE * first)
    (void)PetscSNPrintf(text, sizeof(text),
                        "the ground collapses under its loads: it moves by %.3g of its first way in each",
                        (double)(moved / first));
  else
    (void)PetscSNPrintf(text, sizeof(text),
                        "points go to and fro; -mpm_stage_%.40s_geostatic_tolerance %.2g would take that for rest",
                        stage->name, (double)(2. * moved / rest->height));
  (void)MpmOutcomeFail(outcome, MPM_OUTCOME_NO_SOLUTION,
                       "no equilibrium in %" PetscInt_FMT " iterations: points still move by %.3g m; %s", solved,
                       (double)moved, text);
}

/* Says how much of the loads the ground bears, where they grow, and what may be wrong with the scene. */
static void ExplainPart(const MpmModel model, PetscReal part, MpmOutcome *outcome)
{
  const MpmGeostatic *geostatic = &model->scene.stages.at[model->state.stage].geostatic;
  const char         *hint      = "";

  if (part <= 0.) return;
  if (outcome->code == MPM_OUTCOME_NO_SOLUTION && MpmShapeDegree(model->scene.shape.type) == 3 &&
      model->scene.stabilization.fbar)
    hint = "; below a surface on a row of nodes bspline3 with F-bar may need tension: try gimp, or "
           "-mpm_stabilization_fbar false";
  else if (outcome->code == MPM_OUTCOME_NO_SOLUTION && geostatic->method == MPM_GEOSTATIC_K0)
    hint = "; with the method gravity the line says which part of them the ground bears";
  if (part >= 1.) (void)MpmOutcomeExplain(outcome, "no equilibrium under the loads: %s%s", outcome->text, hint);
  else
    (void)MpmOutcomeExplain(outcome, "the ground collapses under its loads: it bears %.4g of them; beyond that %s%s",
                            (double)part, outcome->text, hint);
}

/* Steps until the points are in equilibrium; `solved` counts those under the full loads. */
static PetscErrorCode FindEquilibrium(MpmModel model, MpmRest *rest, PetscInt *solved, MpmOutcome *outcome)
{
  const MpmGeostatic *geostatic = &model->scene.stages.at[model->state.stage].geostatic;
  PetscReal           part      = geostatic->method == MPM_GEOSTATIC_K0 ? 1. : 0.; /* of the loads that act */
  PetscReal grow  = PetscMin(model->state.dt.nominal / (model->state.period.end - model->state.period.start), 1.);
  PetscReal first = 0., half = 0.;
  PetscInt  newton = 0, linear = 0;
  PetscBool again;

  PetscFunctionBeginUser;
  *solved                = 0;
  model->state.cuts.step = 0;
  while (!*solved || rest->moved > geostatic->tolerance * rest->height) {
    const PetscReal next = part + grow > 1. - 1e-9 ? 1. : part + grow;

    if (*solved == geostatic->iterations) {
      ExplainIterations(model, rest, *solved, first, half, outcome);
      break;
    }
    PetscCall(MpmRestSettle(model, rest, next, outcome));
    newton += model->solver.iterations.newton;
    linear += model->solver.iterations.linear;
    if (outcome->code) {
      again = PETSC_FALSE;
      if (outcome->retryable) PetscCall(TryAgain(model, part, &grow, outcome->text, &again));
      if (!again && outcome->retryable) ExplainPart(model, part, outcome);
      if (!again) break;
      continue;
    }
    part = next;
    if (part == 1. && !(*solved)++) first = half = rest->moved;
    if (*solved == geostatic->iterations / 2) half = rest->moved;
  }
  model->solver.iterations.newton = newton;
  model->solver.iterations.linear = linear;
  model->state.scheme.load_scale  = 1.;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode PrintRest(MpmModel model, const MpmRest *rest, PetscInt solved)
{
  char corrected[128] = "", outside[96] = "";

  PetscFunctionBeginUser;
  if (rest->start)
    PetscCall(PetscSNPrintf(corrected, sizeof(corrected),
                            "; the stress of k0 was corrected by up to %.4g Pa (largest: %.4g Pa)",
                            (double)rest->correction, (double)rest->largest));
  if (rest->outside)
    PetscCall(
      PetscSNPrintf(outside, sizeof(outside), ", at %" PetscInt64_FMT " points by the yield surface", rest->outside));
  PetscCall(MpmMonitorLine(&model->monitor,
                           "geostatic: in equilibrium after %" PetscInt_FMT " iteration%s, to %.3g m%s%s", solved,
                           solved > 1 ? "s" : "", (double)rest->moved, corrected, outside));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmGeostaticAddRows(MpmModel model)
{
  const MpmRow rows[] = {
    {"points_put_back", MPM_ROW_BOOL, MPM_ROW_STATE, &model->state.scheme.put_back, 0, 0},
  };

  PetscFunctionBeginUser;
  PetscCall(MpmRowsAdd(model->state.rows, NULL, PETSC_STATIC_ARRAY_LENGTH(rows), rows));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmGeostaticRun(MpmModel model, MpmOutcome *outcome)
{
  PetscInt  solved;
  MpmPoints points;
  MpmRest   rest;

  PetscFunctionBeginUser;
  PetscCall(MpmMovingGridFollow(model, outcome));
  if (outcome->code) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmParticlesDistribute(model->state.particles, model->disc.grid, outcome));
  if (outcome->code) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmEnergyMark(model));
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  PetscCall(RestCreate(model, &points, &rest));
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  model->state.scheme.water_held = PETSC_TRUE;
  if (model->scene.stages.at[model->state.stage].geostatic.method == MPM_GEOSTATIC_K0)
    PetscCall(MpmRestSetK0(model, &rest));
  PetscCall(FindEquilibrium(model, &rest, &solved, outcome));
  model->state.scheme.water_held = PETSC_FALSE;
  if (!outcome->code) {
    PetscCall(PrintRest(model, &rest, solved));
    model->state.time = model->state.period.end;
    model->state.step++;
  }
  PetscCall(RestDestroy(&rest));
  PetscCall(MpmEnergyRebase(model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

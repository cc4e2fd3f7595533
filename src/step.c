/*
  One step: space, conditions and loads, Newton, commit.
*/
#include "mpmimpl.h"

/* Values of fields with a rate at the nodes, from the points: the start of Newton and of the step. */
static PetscErrorCode ProjectRates(MpmModel model, PetscReal u[])
{
  const PetscInt rates = model->layout.rates, bs = model->layout.block;
  PetscReal     *nodal;

  PetscFunctionBeginUser;
  if (!rates) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1((model->space.owned * rates), &nodal));
  PetscCall(MpmProjectToNodes(&model->sum, rates, rates, model->points.value, NULL, nodal));
  for (PetscInt k = 0; k < model->space.owned * rates; k++)
    u[k / rates * bs + model->layout.rate_component[k % rates]] = nodal[k];
  PetscCall(PetscFree(nodal));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* How much of the change of the rate from step to step is taken to go on: all of it would let errors grow. */
#define PREDICTED_CHANGE 0.9

/*
  The increment that the last two steps let expect, at the nodes: loads and motions go on much as before from step to
  step, and Newton needs an iteration less. It comes from the points, for the material moves over the grid.
*/
static PetscErrorCode Predict(MpmModel model, PetscReal u[])
{
  const PetscInt  dim = model->grid.dim, bs = model->layout.block, size = dim * (dim + 1);
  const PetscReal change = model->dt_before > 0. ? PREDICTED_CHANGE * model->sum.dt / model->dt_last : 0.;
  const PetscReal last   = (1. + change) * model->sum.dt / model->dt_last;
  const PetscReal before = change > 0. ? change * model->sum.dt / model->dt_before : 0.;
  PetscReal      *nodal, *expected;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc2((model->space.owned * dim), &nodal, (model->points.count * size), &expected));
  for (PetscInt p = 0; p < model->points.count; p++) {
    const PetscReal *increment = &model->points.increment[p * MPM_INCREMENT(dim)];

    for (PetscInt k = 0; k < size; k++) expected[p * size + k] = last * increment[k] - before * increment[size + k];
  }
  PetscCall(MpmProjectToNodes(&model->sum, dim, size, expected, expected + dim, nodal));
  for (PetscInt k = 0; k < model->space.owned * dim; k++) u[k / dim * bs + k % dim] = nodal[k];
  PetscCall(PetscFree2(nodal, expected));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The start of Newton: nothing moves, or all goes on as before; totals stay, held unknowns take their values. */
static PetscErrorCode InitialGuess(MpmModel model, PetscBool predict)
{
  const PetscInt n = model->space.owned * model->layout.block;
  PetscScalar   *x;

  PetscFunctionBeginUser;
  PetscCall(VecZeroEntries(model->x));
  PetscCall(VecGetArray(model->x, &x));
  PetscCall(ProjectRates(model, x));
  if (predict) PetscCall(Predict(model, x));
  MpmFramesToUnknowns(&model->constraints, model->layout.block, model->space.owned, x);
  for (PetscInt k = 0; k < n; k++)
    if (model->constraints.condition[k] >= 0) x[k] = model->constraints.value[k];
  PetscCall(VecRestoreArray(model->x, &x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static MpmRules Rules(MpmModel model)
{
  return (MpmRules){.grid       = &model->grid,
                    .shape      = model->shape,
                    .edge       = model->edge,
                    .wall_count = model->wall_count,
                    .walls      = model->walls,
                    .stretch    = model->stretch,
                    .materials  = model->materials,
                    .ghost      = model->ghost,
                    .sparse     = model->ghost_auto ? MPM_GHOST_SPARSE : 0.,
                    .mean       = (PetscBool)(model->layout.means > 0)};
}

PetscErrorCode MpmTrialReset(MpmTrial *trial)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree4(trial->F, trial->stress, trial->state, trial->u));
  trial->made = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* What does not depend on the step's length: arrays, space, pattern, solver. */
static PetscErrorCode PrepareSpace(MpmModel model, const MpmRules *rules, const char **why)
{
  const PetscInt bs = model->layout.block, dim = model->grid.dim;

  PetscFunctionBeginUser;
  model->committed = PETSC_FALSE;
  PetscCall(MpmParticlesRestoreArrays(&model->particles, &model->points));
  PetscCall(MpmParticlesGetArrays(&model->particles, &model->points));
  PetscCall(MpmSpaceSetUp(&model->space, rules, &model->points, why));
  if (*why) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscFree3(model->u, model->residual, model->force));
  PetscCall(PetscMalloc3((model->space.local * bs), &model->u, (model->space.local * bs), &model->residual,
                         (model->space.local * bs), &model->force));
  PetscCall(MpmTrialReset(&model->trial));
  PetscCall(PetscMalloc4((model->points.count * dim * dim), &model->trial.F,
                         (model->points.count * model->particles.stress_size), &model->trial.stress,
                         (model->points.count * model->particles.state_size), &model->trial.state,
                         (model->space.local * bs), &model->trial.u));
  model->active_dofs_max = PetscMax(model->active_dofs_max, (PetscInt64)model->space.global_count * bs);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmStepSpace(MpmModel model, const char **why)
{
  const MpmRules rules = Rules(model);

  PetscFunctionBeginUser;
  *why = NULL;
  PetscCall(PrepareSpace(model, &rules, why));
  PetscCall(MpmParticlesRestoreArrays(&model->particles, &model->points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Conditions and loads at the step's end. */
static PetscErrorCode PrepareConditions(MpmModel model, const MpmRules *rules, PetscReal time)
{
  PetscFunctionBeginUser;
  PetscCall(MpmConstraintsSetUp(&model->constraints, model->bc_count, model->bcs, &model->grid, &model->layout,
                                &model->space, model->time, time));
  PetscCall(
    MpmContactsSetUp(&model->contacts, rules, &model->space, &model->points, &model->particles, model->time, time));
  PetscCall(PetscArrayzero(model->force, model->space.local * model->layout.block));
  for (PetscInt l = 0; l < model->load_count; l++) {
    PetscCall(MpmLoadApply(&model->loads[l], MpmModelLoadFactor(model, l, time), rules, &model->sum, &model->particles,
                           model->force));
  }
  if (model->body_force) {
    PetscCall(MpmBodyForceApply(model->body_force, model->body_force_ctx, time, &model->sum, model->force));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmStepPrepare(MpmModel model, PetscReal time, PetscReal dt, PetscBool again, const char **why)
{
  const MpmRules rules = Rules(model);
  PetscLogDouble since;

  PetscFunctionBeginUser;
  *why = NULL;
  PetscCall(PetscTime(&since));
  if (!again) PetscCall(PrepareSpace(model, &rules, why));
  if (*why) PetscFunctionReturn(PETSC_SUCCESS);
  model->sum = (MpmSum){.grid              = &model->grid,
                        .space             = &model->space,
                        .layout            = &model->layout,
                        .materials         = model->materials,
                        .points            = &model->points,
                        .constraints       = &model->constraints,
                        .physics_parameter = model->physics.parameters,
                        .state_size        = model->particles.state_size,
                        .dt                = dt,
                        .contacts          = &model->contacts};
  if (!again) PetscCall(MpmSolverSetUp(model));
  PetscCall(PrepareConditions(model, &rules, time));
  PetscCall(InitialGuess(model, PETSC_FALSE));
  MpmClock(model, MPM_TIME_TRANSFER, since);
  PetscCall(MpmSolverSetNearNullSpace(model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Is a place in the grid? Rounding at the edge is forgiven. */
static PetscBool IsInside(const MpmGrid *grid, const PetscReal x[])
{
  for (PetscInt a = 0; a < grid->dim; a++) {
    const PetscReal slack = 1e-9 * grid->h[a];

    if (!(x[a] >= grid->lower[a] - slack && x[a] <= grid->upper[a] + slack)) return PETSC_FALSE;
  }
  return PETSC_TRUE;
}

/*
  Can no point of a group reach the grid's edge? They lie between its nodes, and none moves further than three times what
  a node does, by any shape.
*/
static PetscBool FarFromEdge(const MpmModel model, const MpmGroup *group)
{
  const MpmGrid *grid = &model->grid;
  const PetscInt bs   = model->layout.block;

  for (PetscInt a = 0; a < grid->dim; a++) {
    PetscReal reach = 0.;

    for (PetscInt i = 0; i < group->node_count; i++)
      reach = PetscMax(reach, PetscAbsReal(model->u[model->space.group_nodes[group->node_offset + i] * bs + a]));
    reach *= 3. / grid->h[a];
    if (!(reach < (PetscReal)group->first[a])) return PETSC_FALSE;
    if (!((PetscReal)(group->first[a] + group->count[a] - 1) + reach < (PetscReal)grid->cells[a])) return PETSC_FALSE;
  }
  return PETSC_TRUE;
}

/* Would the converged increment carry a point out of the grid? The reason names the first such point of the lowest rank. */
static PetscErrorCode FindLost(MpmModel model, const char **why)
{
  const PetscInt dim = model->grid.dim, bs = model->layout.block, most = PetscPowInt(model->space.width, dim);
  PetscMPIInt    rank = model->size;
  PetscReal     *storage;
  MpmBasis       basis;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1((most * (MPM_MAX_DIM + 1)), &storage));
  for (PetscInt b = 0; b <= MPM_MAX_DIM; b++) basis.basis[b] = storage + most * b;
  for (PetscInt g = 0; g < model->space.group_count && rank == model->size; g++) {
    const MpmGroup *group = &model->space.groups[g];
    const PetscInt *nodes = &model->space.group_nodes[group->node_offset];

    if (FarFromEdge(model, group)) continue;
    for (PetscInt s = group->point_begin; s < group->point_end && rank == model->size; s++) {
      const PetscInt p              = model->space.order[s];
      PetscReal      x[MPM_MAX_DIM] = {0.};

      MpmSpaceEvaluate(&model->space, group, p, &basis);
      for (PetscInt a = 0; a < dim; a++) {
        x[a] = model->points.x[p * dim + a];
        for (PetscInt i = 0; i < group->node_count; i++) x[a] += basis.basis[0][i] * model->u[nodes[i] * bs + a];
      }
      if (IsInside(&model->grid, x)) continue;
      rank = model->rank;
      PetscCall(PetscSNPrintf(model->lost, sizeof(model->lost),
                              dim > 2 ? "point %" PetscInt_FMT " left the grid at (%g, %g, %g)"
                                      : "point %" PetscInt_FMT " left the grid at (%g, %g)",
                              model->points.id[p], (double)x[0], (double)x[1], (double)x[2]));
    }
  }
  PetscCall(PetscFree(storage));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &rank, 1, MPI_INT, MPI_MIN, model->comm));
  if (rank == model->size) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCallMPI(MPI_Bcast(model->lost, (PetscMPIInt)sizeof(model->lost), MPI_CHAR, rank, model->comm));
  *why = model->lost;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The trial and the residual of the converged displacement: those of the last evaluation, where it was made there. */
static PetscErrorCode FindTrial(MpmModel model)
{
  const PetscInt bs = model->layout.block, count = model->space.local * bs;
  PetscBool      same = model->trial.made;
  PetscInt       failed;

  PetscFunctionBeginUser;
  if (same) PetscCall(PetscArraycmp(model->trial.u, model->u, count, &same));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &same, 1, MPIU_BOOL, MPI_LAND, model->comm));
  if (same) {
    MpmFramesToAxes(&model->constraints, bs, model->space.owned, model->residual);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(MpmSumResidual(model, &failed));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &failed, 1, MPIU_INT, MPI_SUM, model->comm));
  PetscCheck(!failed, model->comm, PETSC_ERR_PLIB, "a converged step has %" PetscInt_FMT " points without an answer",
             failed);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The converged step becomes the state; reactions are what the held nodes lack in balance. */
static PetscErrorCode Commit(MpmModel model)
{
  const PetscInt bs  = model->layout.block;
  const PetscInt dim = model->grid.dim;
  PetscLogDouble since;

  PetscFunctionBeginUser;
  PetscCall(PetscTime(&since));
  PetscCall(FindTrial(model));
  PetscCall(MpmCommitLocal(&model->sum, model->u));
  model->trial.made = PETSC_FALSE;
  PetscCall(MpmContactsCommit(&model->contacts, &model->sum, model->u, &model->particles));
  PetscCall(PetscArrayzero(model->reaction, model->bc_count * bs));
  MpmConstraintsAddReactions(&model->constraints, bs, model->space.owned, model->residual, model->reaction);
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, model->reaction, (PetscMPIInt)(model->bc_count * bs), MPIU_REAL, MPIU_SUM,
                           model->comm));
  for (PetscInt k = 0; k < model->points.count * dim; k++)
    model->points.x[k] = PetscMin(PetscMax(model->points.x[k], model->grid.lower[k % dim]), model->grid.upper[k % dim]);
  MpmClock(model, MPM_TIME_TRANSFER, since);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static const char *ReasonText(SNESConvergedReason reason)
{
  switch (reason) {
  case SNES_DIVERGED_FUNCTION_DOMAIN:
    return "a point had no stress (domain error)";
  case MPM_SNES_DIVERGED_NAN:
    return "the residual was not finite";
  case SNES_DIVERGED_LINEAR_SOLVE:
    return "the linear solver failed";
  case SNES_DIVERGED_MAX_IT:
    return "Newton reached its iteration limit";
  case SNES_DIVERGED_LINE_SEARCH:
    return "the line search failed";
  case SNES_DIVERGED_LOCAL_MIN:
    return "Newton's step does not lower the residual";
  case SNES_DIVERGED_DTOL:
    return "the residual grew without bound";
  default:
    return "Newton did not converge";
  }
}

/* The residual at the step's start, which the tolerance refers to. */
static PetscErrorCode FindReference(MpmModel model)
{
  PetscReal motion;

  PetscFunctionBeginUser;
  PetscCall(VecNorm(model->x, NORM_INFINITY, &motion)); /* held nodes may move */
  model->sum.rest = (PetscBool)(motion == 0. && !model->layout.means);
  PetscCall(SNESComputeFunction(model->snes, model->x, model->f));
  model->sum.rest = PETSC_FALSE;
  PetscCall(VecNorm(model->f, NORM_2, &model->reference));
  if (PetscIsInfOrNanReal(model->reference)) model->reference = 0.;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Newton from the prediction; where that fails, or there is none, from rest. */
static PetscErrorCode Solve(MpmModel model, SNESConvergedReason *reason)
{
  PetscFunctionBeginUser;
  model->reference = 0.;
  model->newton = model->linear = 0;
  if (model->predict && model->dt_last > 0.) {
    PetscCall(FindReference(model));
    PetscCall(InitialGuess(model, PETSC_TRUE));
    PetscCall(MpmSolverSolve(model, reason));
    if (*reason >= 0) PetscFunctionReturn(PETSC_SUCCESS);
    PetscCall(InitialGuess(model, PETSC_FALSE));
  }
  {
    const PetscBool before = model->indefinite;

    PetscCall(MpmSolverSolve(model, reason));
    if (model->indefinite == before) PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(InitialGuess(model, PETSC_FALSE)); /* the Krylov method has been changed: once more */
  PetscCall(MpmSolverSolve(model, reason));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmStep(MpmModel model, PetscReal time, PetscReal dt, PetscBool again, const char **why,
                       PetscBool *hopeless)
{
  SNESConvergedReason reason;

  PetscFunctionBeginUser;
  *hopeless = PETSC_TRUE;
  PetscCall(MpmStepPrepare(model, time, dt, again, why));
  if (*why) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Solve(model, &reason));
  if (reason < 0) {
    *hopeless = PETSC_FALSE;
    *why      = ReasonText(reason);
    PetscCall(MpmHeldExplain(model, why, hopeless));
    if (*why == ReasonText(reason)) PetscCall(MpmStabilityExplain(model, why));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(MpmStabilityCheck(model, why));
  if (*why) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(FindLost(model, why));
  if (*why) {
    *hopeless = PETSC_FALSE;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(Commit(model));
  model->dt_before = model->dt_last;
  model->dt_last   = dt;
  model->committed = PETSC_TRUE;
  PetscCall(MpmParticlesRestoreArrays(&model->particles, &model->points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  One step: space, conditions and loads, Newton, commit.
*/
#include "base/newton_reason.h"
#include "point/layout.h"
#include "point/registry.h"
#include "grid/grid.h"
#include "particles/particles.h"
#include "particles/points.h"
#include "space/rules.h"
#include "space/space.h"
#include "space/sum.h"
#include "bc/bc.h"
#include "bc/body_motion.h"
#include "terms/body_contact.h"
#include "terms/body_surface.h"
#include "terms/damping.h"
#include "terms/inertia.h"
#include "terms/load.h"
#include "terms/rigid.h"
#include "terms/rigid_body.h"
#include "terms/section.h"
#include "terms/terms.h"
#include "time/energy.h"
#include "time/integrator.h"
#include "time/model.h"
#include "time/step.h"
#include "time/time.h"
#include "time/water_state.h"

/* The deviations that go with what the points' values have made at the nodes. */
static PetscErrorCode KeepDeviations(MpmModel model, const PetscReal u[])
{
  const MpmSpace *space = model->disc.space;
  const PetscInt  bs = model->disc.block, count = model->disc.points->count * model->disc.layout->deviations;
  PetscReal      *local;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1((space->local * bs), &local));
  PetscCall(PetscArraycpy(local, u, space->owned * bs));
  PetscCall(MpmSpaceToGhosts(space, bs, local));
  PetscCall(PetscFree(model->disc.deviation_n));
  PetscCall(PetscMalloc1(count, &model->disc.deviation_n));
  PetscCall(MpmDeviationsAtPoints(model->disc.sum, local, model->disc.deviation_n));
  model->disc.sum->deviation_n = model->disc.deviation_n;
  PetscCall(PetscFree(local));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Values of fields with a rate at the nodes, from the points: the start of Newton and of the step. */
static PetscErrorCode ProjectRates(MpmModel model, PetscReal u[])
{
  const MpmLayout *layout = model->disc.layout;
  const PetscInt   rates = layout->rates, bs = layout->block, owned = model->disc.space->owned;
  PetscReal       *nodal;

  PetscFunctionBeginUser;
  if (!rates) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1((owned * rates), &nodal));
  for (PetscInt s = 0; s < layout->shape_count; s++) {
    const MpmPointValues values = {
      s, rates, rates, model->disc.points->value, model->disc.points->value_gradient, rates * model->disc.dim};

    PetscCall(MpmProjectToNodes(model->disc.sum, &values, nodal));
    for (PetscInt k = 0; k < owned * rates; k++) {
      const PetscInt c = layout->rate_component[k % rates];

      if (layout->shape_of[c] == s) u[k / rates * bs + c] = nodal[k];
    }
  }
  PetscCall(PetscFree(nodal));
  if (layout->deviations) PetscCall(KeepDeviations(model, u));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  How much of the change of the rate from step to step is taken to go on: all of it would let errors grow. Nothing where there is
  contact, whose facets come into other patches.
*/
#define PREDICTED_CHANGE 0.9

/*
  The increment extrapolated from the last steps, at the nodes: loads and motions go on much as before from step to
  step, and Newton needs an iteration less. It comes from the points, for the material moves over the grid.
*/
static PetscErrorCode Predict(MpmModel model, PetscReal u[])
{
  const PetscInt  dim = model->disc.dim, bs = model->disc.block, size = dim * (dim + 1);
  const PetscBool smooth = (PetscBool)(model->state.dt_before > 0. && !MpmSolverHasContact(&model->solver));
  const PetscReal change = smooth ? PREDICTED_CHANGE * model->disc.sum->span / model->state.dt_last : 0.;
  const PetscReal last   = (1. + change) * model->disc.sum->span / model->state.dt_last;
  const PetscReal before = change > 0. ? change * model->disc.sum->span / model->state.dt_before : 0.;
  PetscReal      *nodal, *expected;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc2((model->disc.space->owned * dim), &nodal, (model->disc.points->count * size), &expected));
  for (PetscInt p = 0; p < model->disc.points->count; p++) {
    const PetscReal *increment = &model->disc.points->increment[p * MPM_INCREMENT(dim)];

    for (PetscInt k = 0; k < size; k++) expected[p * size + k] = last * increment[k] - before * increment[size + k];
  }
  PetscCall(MpmProjectToNodes(model->disc.sum, &(MpmPointValues){0, dim, size, expected, expected + dim, size}, nodal));
  for (PetscInt k = 0; k < model->disc.space->owned * dim; k++) u[k / dim * bs + k % dim] = nodal[k];
  PetscCall(PetscFree2(nodal, expected));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The start of Newton: zero, or the increment extrapolated from the last steps; totals stay, prescribed unknowns
   take their values. */
static PetscErrorCode InitialGuess(MpmModel model, PetscBool predict)
{
  const PetscInt n = model->disc.space->owned * model->disc.block;
  PetscScalar   *x;

  PetscFunctionBeginUser;
  PetscCall(VecZeroEntries(model->solver.x));
  PetscCall(VecGetArray(model->solver.x, &x));
  PetscCall(ProjectRates(model, x));
  if (predict) PetscCall(Predict(model, x));
  MpmRigidGuess(model->disc.contacts, model->disc.space, model->disc.block,
                predict ? model->disc.sum->span / model->state.dt_last : 0., x);
  MpmFramesToUnknowns(model->disc.constraints, model->disc.block, model->disc.space->owned, x);
  MpmUnitsOver(model->disc.constraints, n, x);
  MpmConstraintsPrescribe(model->disc.constraints, n, x);
  PetscCall(VecRestoreArray(model->solver.x, &x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  The ghost penalty's factor. It is a part of Young's modulus, on increments, so that a slope that slides feels it in proportion to
  stiffness and step: while the factor of safety is sought, `auto` takes less.
*/
static PetscReal GhostFactor(const MpmModel model)
{
  const PetscBool seeks = (PetscBool)(model->state.rescue.ghost && MpmReductionSeeks(model));

  return seeks ? PetscMin(model->disc.ghost, MPM_GHOST_SAFETY) : model->disc.ghost;
}

/* How much of the strain is its mean over pieces (docs/stabilization.md). */
static PetscReal SmoothShare(const MpmModel model)
{
  return model->state.rescue.smooth && MpmReductionSeeks(model) ? MPM_SMOOTH_SAFETY : model->scene.smooth;
}

/* The factor of a load or surface in a step to `time`: that of its end, or with a part of that of its start. */
static PetscReal StepLoadFactor(const MpmModel model, PetscInt load, PetscReal time)
{
  const PetscReal part = model->state.scheme.load_at_start, end = MpmModelLoadFactor(model, load, time);

  return part > 0. ? (1. - part) * end + part * MpmModelLoadFactor(model, load, model->state.time) : end;
}

/* The ghost penalty is for matrices: a step that solves for nothing has none. */
static MpmRules Rules(MpmModel model, PetscReal time)
{
  const MpmIntegratorType motion = model->scene.stages[model->state.stage].time.motion.type;
  const PetscBool         solves = (PetscBool)!model->state.scheme.integrator->length;
  MpmRules                rules;

  rules = (MpmRules){.grid       = model->disc.grid,
                     .shape      = model->scene.shape,
                     .edge       = model->scene.edge,
                     .layout     = model->disc.layout,
                     .wall_count = model->state.walls.count,
                     .walls      = model->state.walls.at,
                     .stretch    = solves ? model->scene.stretch : MpmStretchFindQuick(model->disc.dim),
                     .longest    = solves ? 0. : MPM_SPRAY_HALF_LENGTH,
                     .parts      = model->disc.parts,
                     .materials  = model->disc.sum->materials,
                     .ghost      = solves ? GhostFactor(model) : 0.,
                     .sparse     = solves && model->state.rescue.ghost_auto ? MPM_GHOST_SPARSE : 0.,
                     .smooth     = SmoothShare(model),
                     .mean       = (PetscBool)(model->disc.layout->means > 0),
                     .put_back   = model->disc.put_back,
                     .time_n     = model->state.time,
                     .time       = time,
                     .dynamic    = (PetscBool)(motion != MPM_QUASISTATIC && solves)};
  for (PetscInt l = 0; l < model->scene.loads->count; l++) {
    const MpmLoad *load = &model->scene.loads->at[l];

    for (PetscInt a = 0; load->type == MPM_LOAD_GRAVITY && a < model->disc.dim; a++)
      rules.gravity[a] += StepLoadFactor(model, l, time) * load->value[a];
  }
  return rules;
}

/* What does not depend on the step's length: arrays, space, pattern, solver. */
static PetscErrorCode PrepareSpace(MpmModel model, const MpmRules *rules, const char **why)
{
  const PetscInt      bs = model->disc.block, dim = model->disc.dim;
  const MpmParticles *particles = model->state.particles;
  MpmTrial           *trial     = model->disc.trial;

  PetscFunctionBeginUser;
  model->disc.committed = PETSC_FALSE;
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, model->disc.points));
  PetscCall(MpmParticlesGetArrays(model->state.particles, model->disc.points));
  PetscCall(MpmTermsSetUpSpace(model->disc.terms, model->disc.space, rules, model->disc.points, why));
  if (*why) PetscFunctionReturn(PETSC_SUCCESS);
  const PetscInt count = model->disc.points->count;

  PetscCall(PetscFree3(model->disc.u, model->disc.residual, model->disc.force));
  PetscCall(PetscMalloc3((model->disc.space->local * bs), &model->disc.u, (model->disc.space->local * bs),
                         &model->disc.residual, (model->disc.space->local * bs), &model->disc.force));
  PetscCall(MpmTrialReset(trial));
  PetscCall(PetscMalloc5((count * dim * dim), &trial->F, (count * particles->stress_size), &trial->stress,
                         (count * particles->state_size), &trial->state, (count * particles->own_size), &trial->own,
                         (model->disc.space->local * bs), &trial->u));
  model->state.active_dofs_max = PetscMax(model->state.active_dofs_max, (PetscInt64)model->disc.space->unknown_count);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmStepSpace(MpmModel model, const char **why)
{
  const MpmRules rules = Rules(model, model->state.time);

  PetscFunctionBeginUser;
  *why = NULL;
  PetscCall(PrepareSpace(model, &rules, why));
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, model->disc.points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static MpmPrescription Prescription(const MpmModel model, PetscReal time)
{
  return (MpmPrescription){.conditions = model->scene.bcs,
                           .motions    = model->scene.motions,
                           .acting     = model->state.bcs,
                           .particles  = model->state.particles,
                           .time_n     = model->state.time,
                           .time       = time,
                           .diagonal   = model->disc.diagonal};
}

PetscErrorCode MpmModelPrescribe(MpmModel model, PetscReal time, const char **why)
{
  const MpmPrescription step = Prescription(model, time);
  PetscInt              contradicts;

  PetscFunctionBeginUser;
  *why = NULL;
  PetscCall(MpmConstraintsSetUp(model->disc.constraints, &step, model->disc.grid, model->disc.layout, model->disc.space,
                                &contradicts));
  PetscCall(MpmWaterHold(model, time));
  if (contradicts < 0) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscSNPrintf(model->solver.lost, sizeof(model->solver.lost),
                          "motion %s meets nodes that a condition or another motion moves otherwise",
                          model->scene.motions->names[contradicts]));
  *why = model->solver.lost;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Does any condition that acts prescribe a displacement other than 0? */
static PetscBool AnyMoves(const MpmModel model)
{
  for (PetscInt b = 0; b < model->scene.bcs->count; b++)
    if (model->state.bcs[b].active && MpmConditionMoves(&model->scene.bcs->at[b], model->disc.dim)) return PETSC_TRUE;
  return (PetscBool)(model->scene.motions->count > 0);
}

PetscErrorCode MpmStepPrescribedRate(MpmModel model, PetscReal time, PetscInt rate, PetscReal values[])
{
  MpmPrescription step        = Prescription(model, time);
  MpmConstraints  constraints = {0};
  PetscInt        contradicts;

  PetscFunctionBeginUser;
  PetscCall(PetscArrayzero(values, model->disc.space->local * model->disc.block));
  if (!AnyMoves(model)) PetscFunctionReturn(PETSC_SUCCESS);
  step.rate = rate;
  PetscCall(
    MpmConstraintsSetUp(&constraints, &step, model->disc.grid, model->disc.layout, model->disc.space, &contradicts));
  PetscCall(PetscArraycpy(values, constraints.value, model->disc.space->local * model->disc.block));
  PetscCall(MpmConstraintsReset(&constraints));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Conditions that move what they no longer hold. */
static PetscErrorCode FindLostMaterial(MpmModel model, PetscReal time, const char **why)
{
  const MpmPrescription step = Prescription(model, time);
  PetscInt              lost;
  PetscReal             left;

  PetscFunctionBeginUser;
  PetscCall(MpmConditionsFindLost(&step, model->state.bcs, model->scene.bodies, model->disc.sum, &lost, &left));
  if (lost < 0) PetscFunctionReturn(PETSC_SUCCESS);
  if (left > 0.)
    PetscCall(PetscSNPrintf(model->solver.lost, sizeof(model->solver.lost),
                            "condition %s has lost the material that it moves: its nodes hold %.2g %% of what they "
                            "held; a motion follows a body's points",
                            model->scene.bcs->names[lost], (double)(100. * left)));
  else
    PetscCall(PetscSNPrintf(model->solver.lost, sizeof(model->solver.lost),
                            "condition %s prescribes a displacement where there is no material; a motion follows a "
                            "body's points",
                            model->scene.bcs->names[lost]));
  *why = model->solver.lost;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Waves that come in through absorbing conditions in a step to `time`, like other loads. */
static PetscErrorCode AddIncoming(MpmModel model, PetscReal time, PetscReal end, PetscReal start, PetscReal force[])
{
  const MpmDamping *damping = model->disc.damping;

  PetscFunctionBeginUser;
  if (!damping->conditions) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmAbsorbingLoad(damping, model->disc.sum, time, end, force));
  if (start != 0.) PetscCall(MpmAbsorbingLoad(damping, model->disc.sum, model->state.time, start, force));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmStepMeanLoads(MpmModel model, PetscReal time, PetscReal part, PetscReal force[])
{
  const MpmRules  rules = Rules(model, time);
  const PetscReal start = 0.5 - part;

  PetscFunctionBeginUser;
  if (start == 0.) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt l = 0; l < model->scene.loads->count; l++) {
    const PetscReal change = MpmModelLoadFactor(model, l, model->state.time) - MpmModelLoadFactor(model, l, time);

    if (model->scene.loads->at[l].type == MPM_LOAD_GRAVITY && model->state.scheme.integrator->length) continue;
    PetscCall(
      MpmLoadApply(&model->scene.loads->at[l], start * change, &rules, model->disc.sum, model->state.particles, force));
  }
  PetscCall(AddIncoming(model, time, -start, start, force));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Conditions and loads at the step's end. */
static PetscErrorCode PrepareConditions(MpmModel model, const MpmRules *rules, PetscReal time, const char **why)
{
  PetscFunctionBeginUser;
  PetscCall(MpmModelPrescribe(model, time, why));
  if (!*why) PetscCall(FindLostMaterial(model, time, why));
  if (*why) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt k = 0; k < model->scene.surfaces->count; k++) {
    model->disc.surfaces->factor[k]   = StepLoadFactor(model, model->scene.loads->count + k, time);
    model->disc.surfaces->pressure[k] = MpmModelSurfacePressure(model, k, time);
  }
  model->disc.surfaces->still = model->state.scheme.water_held;
  model->disc.surfaces->table = model->scene.water;
  model->disc.surfaces->open  = model->state.scheme.load_scale;
  model->disc.sum->dry        = MpmWaterDry(model, time);
  PetscCall(MpmTermsPrepare(model->disc.terms, &(MpmTermStep){rules, model->disc.sum, model->state.particles}));
  PetscCall(PetscArrayzero(model->disc.force, model->disc.space->local * model->disc.block));
  PetscCall(PetscArraycpy(model->disc.sum->gravity, rules->gravity, MPM_MAX_DIM));
  for (PetscInt l = 0; l < model->scene.loads->count; l++) {
    const MpmLoad *load = &model->scene.loads->at[l];

    if (load->type != MPM_LOAD_GRAVITY || !model->state.scheme.integrator->length)
      PetscCall(MpmLoadApply(load, StepLoadFactor(model, l, time), rules, model->disc.sum, model->state.particles,
                             model->disc.force));
  }
  PetscCall(AddIncoming(model, time, 1. - model->state.scheme.load_at_start, model->state.scheme.load_at_start,
                        model->disc.force));
  if (model->scene.body_force) {
    const PetscReal at = time - model->state.scheme.load_at_start * model->disc.sum->span;

    PetscCall(
      MpmBodyForceApply(model->scene.body_force, model->scene.body_force_ctx, at, model->disc.sum, model->disc.force));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* NULL, or a line on a free body that met nothing. */
static const char *Adrift(MpmModel model)
{
  const MpmContacts *contacts = model->disc.contacts;

  if (!contacts->bodies || contacts->adrift < 0) return NULL;
  (void)PetscSNPrintf(model->solver.lost, sizeof(model->solver.lost),
                      "nothing holds boundary %s against its load: it met no material on its way",
                      contacts->boundaries[contacts->adrift].name);
  return model->solver.lost;
}

/* The solver and the start of Newton; what free bodies, and bodies in contact, may touch is part of the sparsity. */
static PetscErrorCode PrepareSolver(MpmModel model, PetscBool again, const char **why)
{
  const PetscBool links = (PetscBool)(model->disc.contacts->bodies || model->disc.parts > 1);

  PetscFunctionBeginUser;
  if (links) PetscCall(MpmTermsLink(model->disc.terms, model->disc.space));
  if (!again || links) PetscCall(MpmSolverSetUp(&model->solver));
  PetscCall(InitialGuess(model, PETSC_FALSE));
  *why = Adrift(model);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmStepBegin(MpmModel model, PetscReal time, PetscReal dt, PetscBool again, const char **why)
{
  const MpmRules rules = Rules(model, time);
  PetscLogDouble since;

  PetscFunctionBeginUser;
  *why = NULL;
  PetscCall(MpmMonitorBegin(&model->monitor, MPM_TIME_TRANSFER, &since));
  if (!again) PetscCall(PrepareSpace(model, &rules, why));
  if (!*why) {
    model->disc.sum->dt = model->disc.sum->span = dt;
    PetscCall(PrepareConditions(model, &rules, time, why));
  }
  PetscCall(MpmMonitorEnd(&model->monitor, MPM_TIME_TRANSFER, since));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmStepPrepare(MpmModel model, PetscReal time, PetscReal dt, PetscBool again, const char **why)
{
  PetscLogDouble since;

  PetscFunctionBeginUser;
  PetscCall(MpmStepBegin(model, time, dt, again, why));
  PetscCall(MpmMonitorBegin(&model->monitor, MPM_TIME_TRANSFER, &since));
  if (!*why) PetscCall(PrepareSolver(model, again, why));
  PetscCall(MpmMonitorEnd(&model->monitor, MPM_TIME_TRANSFER, since));
  if (*why) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmSolverSetNearNullSpace(&model->solver));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Is a place in the grid? Rounding at the edge is forgiven. */
static PetscBool IsInside(const MpmGrid *grid, const PetscReal x[])
{
  for (PetscInt a = 0; a < grid->dim; a++) {
    const PetscReal slack = MPM_GRID_SLACK * grid->h[a];

    if (!(x[a] >= grid->lower[a] - slack && x[a] <= grid->upper[a] + slack)) return PETSC_FALSE;
  }
  return PETSC_TRUE;
}

/* The longest displacement of any local node along each axis, m; infinite where one is no number. */
static void FindLongest(const MpmModel model, PetscReal longest[])
{
  const PetscInt dim = model->disc.dim, bs = model->disc.block;

  for (PetscInt a = 0; a < dim; a++) longest[a] = 0.;
  for (PetscInt i = 0; i < model->disc.space->local; i++)
    for (PetscInt a = 0; a < dim; a++) {
      const PetscReal u = PetscAbsReal(model->disc.u[i * bs + a]);

      if (!(u <= longest[a])) longest[a] = u <= PETSC_MAX_REAL ? u : PETSC_INFINITY;
    }
}

/*
  Can no point of a group reach the grid's edge? They lie between its nodes, and none moves further than three times what
  a node does, by any shape. `longest` bounds that for all nodes.
*/
static PetscBool FarFromEdge(const MpmModel model, const MpmGroup *group, const PetscReal longest[])
{
  const MpmGrid *grid = model->disc.grid;
  const PetscInt bs = model->disc.block, *nodes = &model->disc.space->group_nodes[group->node_offset];
  PetscInt       first[MPM_MAX_DIM];

  MpmSpaceAt(model->disc.space, group->first, first);
  for (PetscInt a = 0; a < grid->dim; a++) {
    const PetscReal room  = PetscMin((PetscReal)first[a], (PetscReal)(grid->cells[a] - first[a] - group->count[a] + 1));
    PetscReal       reach = 0.;

    if (3. / grid->h[a] * longest[a] < room) continue;
    for (PetscInt i = 0; i < group->node_count; i++)
      reach = PetscMax(reach, PetscAbsReal(model->disc.u[nodes[i] * bs + a]));
    if (!(3. / grid->h[a] * reach < room)) return PETSC_FALSE;
  }
  return PETSC_TRUE;
}

PetscErrorCode MpmStepFindLost(MpmModel model, const char **why)
{
  const PetscInt dim = model->disc.dim, bs = model->disc.block, most = PetscPowInt(model->disc.space->width, dim);
  PetscMPIInt    rank = model->size;
  PetscReal     *storage;
  MpmBasis       basis;
  PetscReal      longest[MPM_MAX_DIM];
  MpmGrid        next;

  PetscFunctionBeginUser;
  PetscCall(MpmMovingGridNext(model, &next));
  FindLongest(model, longest);
  PetscCall(PetscMalloc1((most * (MPM_MAX_DIM + 1)), &storage));
  for (PetscInt b = 0; b <= MPM_MAX_DIM; b++) basis.basis[b] = storage + most * b;
  for (PetscInt g = 0; g < model->disc.space->group_count && rank == model->size; g++) {
    const MpmGroup *group = &model->disc.space->groups[g];
    const PetscInt *nodes = &model->disc.space->group_nodes[group->node_offset];

    if (model->scene.follow.what == MPM_FOLLOW_NOTHING && FarFromEdge(model, group, longest)) continue;
    for (PetscInt s = group->point_begin; s < group->point_end && rank == model->size; s++) {
      const PetscInt p              = model->disc.space->order[s];
      PetscReal      x[MPM_MAX_DIM] = {0.};

      MpmSpaceEvaluate(model->disc.space, group, p, &basis);
      for (PetscInt a = 0; a < dim; a++) {
        x[a] = model->disc.points->x[p * dim + a];
        for (PetscInt i = 0; i < group->node_count; i++) x[a] += basis.basis[0][i] * model->disc.u[nodes[i] * bs + a];
      }
      if (IsInside(&next, x)) continue;
      rank = model->rank;
      PetscCall(PetscSNPrintf(model->solver.lost, sizeof(model->solver.lost),
                              dim > 2 ? "point %" PetscInt_FMT " left the grid at (%g, %g, %g)"
                                      : "point %" PetscInt_FMT " left the grid at (%g, %g)",
                              model->disc.points->id[p], (double)x[0], (double)x[1], (double)x[2]));
    }
  }
  PetscCall(PetscFree(storage));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &rank, 1, MPI_INT, MPI_MIN, model->comm));
  if (rank == model->size) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCallMPI(MPI_Bcast(model->solver.lost, (PetscMPIInt)sizeof(model->solver.lost), MPI_CHAR, rank, model->comm));
  *why = model->solver.lost;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Those of the last evaluation, where it was made there. */
PetscErrorCode MpmStepFindTrial(MpmModel model)
{
  const PetscInt bs = model->disc.block, count = model->disc.space->local * bs;
  PetscBool      same = model->disc.trial->made;
  PetscInt       failed;

  PetscFunctionBeginUser;
  if (same) PetscCall(PetscArraycmp(model->disc.trial->u, model->disc.u, count, &same));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &same, 1, MPM_MPI_BOOL, MPI_LAND, model->comm));
  if (same) {
    if (model->disc.trial->framed)
      MpmFramesToAxes(model->disc.constraints, bs, model->disc.space->owned, model->disc.residual);
    model->disc.trial->framed = PETSC_FALSE;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(MpmSumResidual(&model->solver, &failed));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &failed, 1, MPIU_INT, MPI_SUM, model->comm));
  PetscCheck(!failed, model->comm, PETSC_ERR_PLIB, "a converged step has %" PetscInt_FMT " points without an answer",
             failed);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The residual at the constrained nodes. */
PetscErrorCode MpmStepFindReactions(MpmModel model)
{
  const PetscInt bs    = model->disc.block;
  const PetscInt count = (model->scene.bcs->count + model->scene.motions->count) * bs; /* of reactions */

  PetscFunctionBeginUser;
  PetscCall(PetscArrayzero(model->disc.reaction, count));
  MpmConstraintsAddReactions(model->disc.constraints, bs, model->disc.space->owned, model->disc.residual,
                             model->disc.reaction);
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, model->disc.reaction, (PetscMPIInt)count, MPIU_REAL, MPIU_SUM, model->comm));
  for (PetscInt k = 0; k < count; k++)
    if (model->disc.layout->negative[k % bs]) model->disc.reaction[k] *= -1.;
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MpmStepClip(MpmModel model)
{
  const PetscInt   dim = model->disc.dim, count = model->disc.points->count * dim;
  const PetscReal *lower = model->disc.grid->lower, *upper = model->disc.grid->upper;
  PetscReal       *x = model->disc.points->x;

  if (model->scene.follow.what != MPM_FOLLOW_NOTHING) return;
  for (PetscInt k = 0; k < count; k += dim)
    for (PetscInt a = 0; a < dim; a++) x[k + a] = PetscMin(PetscMax(x[k + a], lower[a]), upper[a]);
}

/* The converged step becomes the state. */
static PetscErrorCode Commit(MpmModel model)
{
  PetscLogDouble since;

  PetscFunctionBeginUser;
  PetscCall(MpmMonitorBegin(&model->monitor, MPM_TIME_TRANSFER, &since));
  PetscCall(MpmStepFindTrial(model));
  if (model->disc.sections)
    PetscCall(MpmSectionsEvaluate(model->disc.sections, model->disc.sum, model->disc.u, model->state.particles));
  PetscCall(MpmSurfaceFlowCommit(model->disc.surfaces, model->disc.sum, model->disc.u));
  PetscCall(MpmCommitLocal(model->disc.sum, model->disc.u));
  model->disc.trial->made = PETSC_FALSE;
  PetscCall(MpmTermsCommit(model->disc.terms, model->disc.sum, model->disc.u, model->state.particles));
  PetscCall(MpmStepFindReactions(model));
  if (!MpmStepMayLeave(model)) MpmStepClip(model);
  PetscCall(MpmMonitorEnd(&model->monitor, MPM_TIME_TRANSFER, since));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmStepFindReference(MpmModel model)
{
  PetscReal motion;

  PetscFunctionBeginUser;
  PetscCall(VecNorm(model->solver.x, NORM_INFINITY, &motion)); /* constrained nodes may move */
  model->disc.sum->rest = (PetscBool)(motion == 0. && !model->disc.layout->means);
  PetscCall(SNESComputeFunction(model->solver.snes, model->solver.x, model->solver.f));
  model->disc.sum->rest = PETSC_FALSE;
  PetscCall(MpmSolverSetReference(&model->solver, model->solver.f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Newton from the start at hand; from rest once more where the Krylov method had to be changed. */
static PetscErrorCode SolveFrom(MpmModel model, PetscBool rest, SNESConvergedReason *reason)
{
  const PetscBool before = model->solver.indefinite;

  PetscFunctionBeginUser;
  PetscCall(MpmSolverSolve(&model->solver, reason));
  if (!rest || model->solver.indefinite == before) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(InitialGuess(model, PETSC_FALSE));
  PetscCall(MpmSolverSolve(&model->solver, reason));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Newton from the prediction and, where that fails or there is none, from rest. With contact it is taken with care, and without, from
  each, but not where loads push along what nothing resists; and all but the last of these are given up when they get nowhere. What
  succeeded is how the next step starts.
*/
static PetscErrorCode Solve(MpmModel model, SNESConvergedReason *reason)
{
  MpmSolver      *solver    = &model->solver;
  const PetscBool predicted = solver->cache.predicted, contact = MpmSolverHasContact(solver);
  PetscBool       turns = contact;

  PetscFunctionBeginUser;
  solver->newton = solver->linear = 0;
  for (PetscInt k = 0; k < (predicted ? 4 : 2); k++) {
    const PetscBool rest = (PetscBool)(!predicted || k >= 2);

    if (k % 2 && !turns) continue;
    if (k) {
      if (turns) solver->careful = (PetscBool)!solver->careful;
      PetscCall(InitialGuess(model, (PetscBool)!rest));
      if (!rest) PetscCall(MpmRelaxBodies(solver, NULL, solver->x));
    }
    solver->cache.hasty = (PetscBool)(contact && k < (predicted ? 3 : 1));
    PetscCall(SolveFrom(model, rest, reason));
    if (*reason >= 0) break;
    if (!k && contact) {
      PetscCall(MpmUnconstrainedIsPushed(model, &turns));
      turns = (PetscBool)!turns;
    }
  }
  solver->cache.hasty = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

#define TRUST 0.1 /* of the residual at rest: where bodies may slide or part, a prediction that leaves more is none */

/*
  May any body slide on another? What sticks now may slide in the next step. Or may they part where no energy tells how to close
  them again?
*/
static PetscBool Rubs(const MpmModel model)
{
  if (model->scene.pairs->count && model->disc.layout->saddle) return PETSC_TRUE;
  for (PetscInt k = 0; k < model->scene.pairs->count; k++)
    if (model->scene.pairs->at[k].tangential) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* The start of Newton, and the residual that its tolerance refers to. */
static PetscErrorCode PredictStep(MpmModel model)
{
  PetscReal norm;

  PetscFunctionBeginUser;
  model->solver.cache.reference = 0.;
  model->solver.cache.predicted = (PetscBool)(model->state.predict && model->state.dt_last > 0.);
  if (!model->solver.cache.predicted) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmStepFindReference(model));
  PetscCall(InitialGuess(model, PETSC_TRUE));
  PetscCall(MpmRelaxBodies(&model->solver, NULL, model->solver.x));
  if (!Rubs(model)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SNESComputeFunction(model->solver.snes, model->solver.x, model->solver.f));
  PetscCall(VecNorm(model->solver.f, NORM_2, &norm));
  if (norm <= TRUST * model->solver.cache.reference) PetscFunctionReturn(PETSC_SUCCESS);
  model->solver.cache.predicted = PETSC_FALSE;
  PetscCall(InitialGuess(model, PETSC_FALSE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

#define AUGMENTATIONS 40 /* of one step */

/* The pressures of boundaries and pairs with method augmented, corrected between solutions until what touches has no depth. */
static PetscErrorCode Augment(MpmModel model, SNESConvergedReason *reason)
{
  PetscReal worst = PETSC_INFINITY, pairs;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < AUGMENTATIONS && *reason >= 0; k++) {
    PetscCall(MpmContactsAugment(model->disc.contacts, model->disc.sum, model->disc.u, &worst));
    PetscCall(MpmPairsAugment(model->disc.pairs, model->disc.sum, model->disc.u, &pairs));
    if (PetscMax(worst, pairs) <= 1.) PetscFunctionReturn(PETSC_SUCCESS);
    PetscCall(MpmSolverSolve(&model->solver, reason));
  }
  if (*reason >= 0) *reason = SNES_DIVERGED_MAX_IT;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SolveStep(MpmModel model, const char **why, PetscBool *retryable)
{
  SNESConvergedReason reason;

  PetscFunctionBeginUser;
  *why = NULL;
  PetscCall(Solve(model, &reason));
  PetscCall(Augment(model, &reason));
  if (reason < 0) {
    *retryable = PETSC_TRUE;
    *why       = MpmNewtonReason(reason);
    PetscCall(MpmUnconstrainedExplain(model, why, retryable));
    if (*why == MpmNewtonReason(reason)) PetscCall(MpmStabilityExplain(&model->solver, why));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  *retryable = PETSC_FALSE;
  PetscCall(MpmStabilityCheck(&model->solver, why));
  if (*why) PetscFunctionReturn(PETSC_SUCCESS);
  *retryable = PETSC_TRUE;
  if (MpmRigidStray(model->disc.contacts, model->disc.block, model->disc.u) >= 0)
    *why = "a free boundary moved by more than its contacts were looked for";
  else if (!MpmStepMayLeave(model)) PetscCall(MpmStepFindLost(model, why));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The work of a step without inertia, in scenes that keep account of it. */
static PetscErrorCode AddWork(MpmModel model)
{
  const PetscInt count = model->disc.space->local * model->disc.block;
  PetscReal     *loads;

  PetscFunctionBeginUser;
  if (!model->disc.inertia->dynamic || model->state.scheme.integrator != &MpmIntegratorQuasistatic)
    PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmStepFindTrial(model));
  PetscCall(PetscMalloc1(count, &loads));
  PetscCall(PetscArraycpy(loads, model->disc.force, count));
  PetscCall(MpmStepMeanLoads(model, model->state.time + model->disc.sum->span, 0., loads));
  PetscCall(MpmEnergyAdd(model, &(MpmStepWork){model->disc.u, NULL, loads, model->disc.residual}));
  PetscCall(PetscFree(loads));
  model->disc.trial->made = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Supports that move do their work by the mean of their forces over the step: those of the balance are of a time further on, by
  (1/2 - alpha_f) of the step, and a condition's force went there from what it was a step before.
*/
static void CorrectSupports(MpmModel model)
{
  const PetscReal       part = 0.5 - model->state.scheme.load_at_start;
  const MpmPrescription step = Prescription(model, model->state.time + model->disc.sum->span);

  if (!model->disc.inertia->dynamic) return;
  for (PetscInt b = 0; b < model->scene.bcs->count; b++) {
    const MpmCondition *bc       = &model->scene.bcs->at[b];
    const PetscReal    *reaction = &model->disc.reaction[b * model->disc.block];
    PetscReal          *before   = model->state.bcs[b].force, factor;

    if (!model->state.bcs[b].active || bc->absorbing) continue;
    factor = part * MpmStepFactor(&step, b, PETSC_TRUE);
    for (PetscInt a = 0; a < model->disc.dim; a++) {
      const PetscReal change = reaction[a] - before[a];

      for (PetscInt k = 0; !bc->inclined && k < bc->component_count; k++)
        if (bc->component[k] == a) model->state.scheme.energy.external -= factor * change * bc->value[k];
      if (bc->inclined) model->state.scheme.energy.external -= factor * change * bc->value[0] * bc->normal[a];
      before[a] = reaction[a];
    }
  }
}

static PetscErrorCode AcceptStep(MpmModel model)
{
  PetscFunctionBeginUser;
  PetscCall(AddWork(model));
  PetscCall(Commit(model));
  CorrectSupports(model);
  model->disc.put_back   = PETSC_FALSE;
  model->state.dt_before = model->state.dt_last;
  model->state.dt_last   = model->disc.sum->span;
  model->disc.committed  = PETSC_TRUE;
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, model->disc.points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The points are untouched until a step is accepted: only what was tried is forgotten. */
static PetscErrorCode RollBackStep(MpmModel model)
{
  PetscFunctionBeginUser;
  model->disc.trial->made = PETSC_FALSE;
  PetscCall(VecZeroEntries(model->solver.x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

const MpmIntegrator MpmIntegratorQuasistatic = {.name      = "quasistatic",
                                                .begin     = MpmStepPrepare,
                                                .predict   = PredictStep,
                                                .solve     = SolveStep,
                                                .accept    = AcceptStep,
                                                .roll_back = RollBackStep};

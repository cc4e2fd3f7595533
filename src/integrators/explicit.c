/*
  Explicit dynamics: symplectic Euler, which is the leapfrog method, without a matrix or a solver.

    m_i = sum_p w_ip m_p ,   v_i = sum_p w_ip m_p (v_p + C_p (x_i - x_p)) / m_i
    f_i = f_ext,i - sum_p V_p sigma_p grad w_ip + contact
    v*_i = v_i + k f_i/m_i ,   x_p += dt sum_i w_ip v*_i ,   v_p by FLIP or APIC

  The velocities of a step are those of its middle: a velocity increment spans the time k from the middle of the last
  step to that of this one. At a stage's start velocities are those of that time, and the first k is dt/2; at its end
  another half brings them up to time. A relaxation has k = dt throughout, as it was published.

  The stress is that of the velocities v**, gradient by gradient, through the same kernel of the physics as implicit
  steps: with the displacement dt v** of the nodes. musl: v** are the points' new velocities, mapped once more; usl: v*;
  usf: v** = v_i of the last step's middle, for as long as that was, and the stress that follows makes f_i.

  A force on a node without mass moves nothing. Prescribed unknowns follow their conditions.

  Sources: Sulsky, Zhou, Schreyer (1995), Comput. Phys. Commun. 87, 236-252, doi:10.1016/0010-4655(94)00170-7 (musl);
  Bardenhagen (2002), J. Comput. Phys. 180, 383-403, doi:10.1006/jcph.2002.7103 (usf, usl).
*/
#include "talus/point/basal.h"
#include "point/fluid_stretch.h"
#include "point/layout.h"
#include "point/material.h"
#include "grid/grid.h"
#include "grid/shape.h"
#include "particles/particles.h"
#include "particles/points.h"
#include "space/space.h"
#include "space/sum.h"
#include "transfer/momentum.h"
#include "transfer/motion.h"
#include "bc/bc.h"
#include "assembly/terms.h"
#include "points/point_terms.h"
#include "terrain/bed_flow.h"
#include "volume/damping.h"
#include "volume/inertia.h"
#include "loads/body_surface.h"
#include "loads/load.h"
#include "entrainment/entrainment.h"
#include "problem/section.h"
#include "query/model.h"
#include "query/query.h"
#include "step/energy.h"
#include "step/step.h"
#include "integrators/dynamics.h"
#include "integrators/explicit.h"
#include "integrators/integrators.h"
#include "integrators/relaxation.h"

/* For how long forces act in the step, s. */
static PetscReal KickLength(const MpmModel model)
{
  return MpmModelRelaxes(model) ? model->disc.sum->step.dt
                                : model->state.scheme.behind + 0.5 * model->disc.sum->step.dt;
}

/* For how long they would if the step were one of many: contact stops what comes near in such a one. */
static PetscReal WholeKick(const MpmModel model)
{
  return model->state.scheme.behind > 0. ? KickLength(model) : model->disc.sum->step.dt;
}

/* Room for the points' velocities. */
static PetscErrorCode Resize(MpmModel model)
{
  const PetscInt moves = model->disc.points->count * model->disc.dim;
  MpmDynamics   *dynamics;

  PetscFunctionBeginUser;
  PetscCall(MpmDynamicsResize(model));
  dynamics = model->state.scheme.dynamics;
  if (moves > dynamics->moves_room) {
    PetscCall(PetscFree(dynamics->moves));
    PetscCall(PetscMalloc1(moves, &dynamics->moves));
    dynamics->moves_room = moves;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* True where other terms than the points' have forces in this step: contact that is near, pressures on surfaces,
   damping. */
static PetscBool HasOthers(const MpmModel model)
{
  return (PetscBool)(MpmTermsNear(model->disc.terms, MPM_TERM_CONTACT) || model->scene.surfaces->count ||
                     MpmDampingAny(model->disc.context.damping));
}

static PetscErrorCode Begin(MpmModel model, PetscReal time, PetscReal dt, PetscBool again, MpmOutcome *outcome)
{
  PetscFunctionBeginUser;
  model->disc.context.inertia->active = PETSC_FALSE;
  model->disc.context.damping->active = PETSC_FALSE;
  model->state.scheme.load_at_start   = 1.; /* an increment's middle is the step's start */
  PetscCall(MpmStepBegin(model, time, dt, again, outcome));
  if (!outcome->code) PetscCall(Resize(model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Predict(MpmModel model)
{
  PetscFunctionBeginUser;
  model->solver.iterations.newton = model->solver.iterations.linear = 0;
  model->disc.trial->of.id                                          = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* True where the physics takes the points one by one, with the forces of their stress alone. */
static PetscBool IsPlain(const MpmModel model)
{
  return (PetscBool)(!model->disc.layout->means && (model->scene.physics.traits & MPM_PHYSICS_STRESS));
}

/* True where points are columns without stress, whose state needs no kernel. */
static PetscBool IsColumns(const MpmModel model)
{
  return (PetscBool)(IsPlain(model) && (model->scene.physics.traits & MPM_PHYSICS_COLUMNS) &&
                     !model->disc.space->shapes.at[0].cross);
}

/*
  State of the points at displacements u of the nodes, into the trial; `force`: NULL, or their forces there. `still`: in
  the stress of the step's start, and the trial stays as it is.
*/
static PetscErrorCode EvaluatePoints(MpmModel model, const PetscReal u[], PetscBool still, PetscReal *force,
                                     MpmOutcome *outcome)
{
  MpmSum         sum    = *model->disc.sum;
  MpmTrial      *trial  = still ? NULL : model->disc.trial;
  PetscInt       failed = 0;
  PetscLogDouble since;

  PetscFunctionBeginUser;
  PetscCall(MpmMonitorBegin(&model->monitor, MPM_TIME_RESIDUAL, &since));
  sum.mode = still ? MPM_MODE_START : MPM_MODE_END;
  if (!force && IsColumns(model)) PetscCall(MpmBedUpdateColumns(&sum, u, trial, &failed));
  else if (!force && !model->disc.layout->means) PetscCall(MpmPointsUpdate(&sum, u, trial, &failed));
  else {
    PetscReal *to = force ? force : model->state.scheme.dynamics->a_rest;

    PetscCall(PetscArrayzero(to, model->disc.space->local * model->disc.block));
    PetscCall(MpmTermsResidualPoints(model->disc.terms, &sum, u, trial, to, &failed));
  }
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &failed, 1, MPIU_INT, MPI_SUM, model->comm));
  if (failed) PetscCall(MpmOutcomeFail(outcome, MPM_OUTCOME_NO_ANSWER, "a point's law has no answer"));
  PetscCall(MpmMonitorEnd(&model->monitor, MPM_TIME_RESIDUAL, since));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* u = dt v, at all local nodes */
static void Displace(const MpmModel model, const PetscReal velocity[], PetscReal u[])
{
  for (PetscInt k = 0; k < model->disc.space->local * model->disc.dim; k++)
    u[k] = model->disc.sum->step.dt * velocity[k];
}

/* Displacement of the last step, by its velocities; none where a stage begins. */
static void DisplaceLast(const MpmModel model, const PetscReal velocity[], PetscReal u[])
{
  const PetscReal dt = MpmModelRelaxes(model) ? model->disc.sum->step.dt : 2. * model->state.scheme.behind;

  for (PetscInt k = 0; k < model->disc.space->local * model->disc.dim; k++) u[k] = dt * velocity[k];
}

/*
  Masses and velocities of the nodes at the step's start, and the forces of points and loads, into disc.nodal.residual:
  in one pass over the points where their stress is known and the physics is a solid's.
*/
static PetscErrorCode SumNodes(MpmModel model, MpmOutcome *outcome)
{
  const MpmTransfer *transfer = &MpmModelMotion(model)->transfer;
  const PetscBool    first    = (PetscBool)(MpmModelMotion(model)->update == MPM_UPDATE_USF);
  const PetscInt     dim = model->disc.dim, local = model->disc.space->local;
  MpmDynamics       *dynamics = model->state.scheme.dynamics;
  PetscReal         *force = model->disc.nodal.residual, *mass = model->disc.context.inertia->mass;

  PetscFunctionBeginUser;
  PetscCall(MpmEnergyOpen(model));
  if (first || !IsPlain(model)) {
    PetscCall(MpmMomentumToNodes(model->disc.sum, transfer, mass, dynamics->v_old, NULL));
    PetscCall(MpmExplicitPrescribeStart(model, dynamics->v_old));
    if (first) DisplaceLast(model, dynamics->v_old, model->disc.trial->u);
    else PetscCall(PetscArrayzero(model->disc.trial->u, local * dim));
    PetscCall(EvaluatePoints(model, model->disc.trial->u, (PetscBool)!first, force, outcome));
    for (PetscInt k = 0; k < local * dim; k++) force[k] = model->disc.nodal.force[k] - force[k];
    PetscCall(MpmSpaceAddToOwners(model->disc.space, dim, force));
    PetscCall(MpmSpaceToGhosts(model->disc.space, dim, force));
  } else if (IsColumns(model)) {
    PetscCall(MpmMomentumToNodes(model->disc.sum, transfer, mass, dynamics->v_old, NULL));
    PetscCall(MpmExplicitPrescribeStart(model, dynamics->v_old));
    PetscCall(PetscArraycpy(force, model->disc.nodal.force, local * dim));
    PetscCall(MpmSpaceAddToOwners(model->disc.space, dim, force));
    PetscCall(MpmSpaceToGhosts(model->disc.space, dim, force));
  } else {
    PetscCall(PetscArraycpy(force, model->disc.nodal.force, local * dim));
    PetscCall(MpmMotionToNodes(model->disc.sum, transfer, mass, dynamics->v_old, force));
    PetscCall(
      MpmExplicitPrescribeStart(model, dynamics->v_old)); /* velocities of supports do not come from the points */
  }
  for (PetscInt i = 0; i < local; i++)
    for (PetscInt a = 0; a < dim; a++) force[i * dim + a] += mass[i] * model->disc.sum->step.gravity[a];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Mass accelerated by a force, kg: dashpots act with the mean of the velocities before and after, m (v_new - v_old) = k
  (f - c (v_old + v_new)/2), k the time of the increment, of which f - c v_old is the force.
*/
static PetscReal MovedMass(const MpmModel model, PetscReal kick, PetscInt k)
{
  const MpmDamping *damping = model->disc.context.damping;
  const PetscReal   mass    = model->disc.context.inertia->mass[k / model->disc.dim];

  return damping->active ? mass + 0.5 * kick * damping->dashpot[k] : mass;
}

/* v_new = v_old + k f/m, less what terms resist; zero change without mass */
static PetscErrorCode Accelerate(MpmModel model, PetscReal kick, const PetscReal force[])
{
  MpmDynamics     *dynamics = model->state.scheme.dynamics;
  const PetscReal *mass     = model->disc.context.inertia->mass;
  const PetscInt   dim = model->disc.dim, count = model->disc.space->local * dim;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < count; k++) {
    const PetscReal by = mass[k / dim] > 0. ? kick / MovedMass(model, kick, k) : 0.;

    dynamics->v_new[k] = dynamics->v_old[k] + by * force[k];
  }
  MpmExplicitPrescribe(model, dynamics->v_new);
  if (MpmTermsResistAny(model->disc.terms)) {
    PetscReal *resisted = dynamics->a_rest; /* change of the velocities, for FindSupports() */

    for (PetscInt k = 0; k < count; k++) resisted[k] = -dynamics->v_new[k];
    PetscCall(MpmTermsResist(model->disc.terms, model->disc.sum, mass, kick, dynamics->v_new));
    for (PetscInt k = 0; k < count; k++) resisted[k] += dynamics->v_new[k];
    MpmExplicitPrescribe(model, dynamics->v_new);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Velocities that forces and contact of a geostatic state give, before contact is found. */
static PetscErrorCode AccelerateToContact(MpmModel model, PetscReal force[])
{
  const PetscInt count = model->disc.space->local * model->disc.dim;
  PetscReal     *bears = model->state.scheme.dynamics->a_start;

  PetscFunctionBeginUser;
  if (!MpmStagesAreGeostatic(model)) {
    PetscCall(Accelerate(model, WholeKick(model), force));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(PetscArrayzero(bears, count));
  PetscCall(MpmTermsBear(model->disc.terms, model->disc.sum, bears));
  PetscCall(MpmSpaceAddToOwners(model->disc.space, model->disc.dim, bears));
  PetscCall(MpmSpaceToGhosts(model->disc.space, model->disc.dim, bears));
  for (PetscInt k = 0; k < count; k++) force[k] -= bears[k];
  PetscCall(Accelerate(model, WholeKick(model), force));
  for (PetscInt k = 0; k < count; k++) force[k] += bears[k];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds to `force` the other terms' forces at the displacement that the step would have without them, which stays in
   a_start. */
static PetscErrorCode AddOthers(MpmModel model, PetscReal force[])
{
  MpmDynamics   *dynamics = model->state.scheme.dynamics;
  const PetscInt count    = model->disc.space->local * model->disc.dim;
  PetscReal     *other    = dynamics->a_rest;
  /* use the nominal step, so a shortened one does not stiffen contact */
  const PetscReal dt     = PetscMax(PetscMax(model->disc.sum->step.dt, model->state.dt.wanted), WholeKick(model));
  PetscInt        failed = 0;

  PetscFunctionBeginUser;
  PetscCall(MpmLightNodesLimitContact(model, dt));
  if (MpmDampingAny(model->disc.context.damping)) {
    PetscCall(
      MpmDampingSet(model->disc.context.damping, model->disc.space, model->disc.context.inertia, 0., dynamics->v_old));
    model->disc.context.damping->active = PETSC_TRUE;
  }
  Displace(model, dynamics->v_new, dynamics->a_start);
  MpmLightNodesLimit(model, model->disc.sum->step.dt, dynamics->a_start);
  PetscCall(PetscArrayzero(other, count));
  PetscCall(MpmTermsResidualRest(model->disc.terms, model->disc.sum, dynamics->a_start, other, &failed));
  PetscCall(MpmSpaceAddToOwners(model->disc.space, model->disc.dim, other));
  PetscCall(MpmSpaceToGhosts(model->disc.space, model->disc.dim, other));
  for (PetscInt k = 0; k < count; k++) force[k] -= other[k];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reactions of supports, into disc.nodal.residual, which has the forces; 0 where nothing is prescribed. */
static void FindSupports(MpmModel model, PetscReal kick)
{
  const MpmConstraints *constraints = model->disc.constraints;
  const MpmDynamics    *dynamics    = model->state.scheme.dynamics;
  const PetscInt        dim         = model->disc.dim;
  const PetscReal      *resisted    = MpmTermsResistAny(model->disc.terms) ? dynamics->a_rest : NULL;

  for (PetscInt i = 0; i < model->disc.space->owned; i++) {
    PetscReal *f   = &model->disc.nodal.residual[i * dim];
    PetscBool  any = PETSC_FALSE;

    for (PetscInt a = 0; constraints->any && a < dim; a++)
      any = (PetscBool)(any || !MpmConstraintsFree(constraints, i * dim + a));
    for (PetscInt a = 0; a < dim; a++)
      f[a] = any ? MovedMass(model, kick, i * dim + a) / kick *
                       (dynamics->v_new[i * dim + a] - dynamics->v_old[i * dim + a] -
                        (resisted ? resisted[i * dim + a] : 0.)) -
                     f[a]
                 : 0.;
  }
}

/* Adds gravity's force to the loads at the local nodes, of which each rank has its part. */
static void AddGravity(const MpmModel model, const PetscReal gravity[], PetscReal loads[])
{
  const PetscInt dim = model->disc.dim;

  for (PetscInt i = 0; i < model->disc.space->owned; i++)
    for (PetscInt a = 0; a < dim; a++) loads[i * dim + a] += model->disc.context.inertia->mass[i] * gravity[a];
}

/* Half of gravity's increment in the step: from that of its start to the mean. */
static void GravityGain(const MpmModel model, PetscReal gain[])
{
  const PetscReal end = model->state.time + model->disc.sum->step.span;

  for (PetscInt a = 0; a < model->disc.dim; a++) gain[a] = 0.;
  for (PetscInt l = 0; l < model->scene.loads->count; l++) {
    const MpmLoad  *load   = &model->scene.loads->at[l];
    const PetscReal change = MpmModelLoadFactor(model, l, end) - MpmModelLoadFactor(model, l, model->state.time);

    for (PetscInt a = 0; load->type == MPM_LOAD_GRAVITY && a < model->disc.dim; a++)
      gain[a] += 0.5 * change * load->value[a];
  }
}

/* The forces at the nodes, into disc.nodal.residual. */
static PetscErrorCode FindForces(MpmModel model, MpmOutcome *outcome)
{
  PetscReal *force = model->disc.nodal.residual;

  PetscFunctionBeginUser;
  PetscCall(SumNodes(model, outcome));
  if (outcome->code) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmTermsPush(model->disc.terms, model->disc.sum, force));
  if (HasOthers(model)) {
    PetscCall(AccelerateToContact(model, force));
    PetscCall(AddOthers(model, force));
  }
  AddGravity(model, model->disc.sum->step.gravity, model->disc.nodal.force);
  if (MpmModelRelaxes(model)) PetscCall(MpmRelaxationDamp(model, model->disc.nodal.force, force));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The points' velocities after an increment; `again` becomes those at the nodes that follow from them, or is NULL. */
static PetscErrorCode MovePoints(MpmModel model, PetscReal kick, PetscReal *again)
{
  MpmDynamics     *dynamics = model->state.scheme.dynamics;
  const PetscReal *mass     = model->disc.context.inertia->mass;
  const PetscInt   dim = model->disc.dim, count = model->disc.space->local * dim;
  MpmMotionStep step = {.v_old = dynamics->v_old, .v_new = dynamics->v_new, .moves = dynamics->moves, .again = again};

  PetscFunctionBeginUser;
  if (model->disc.points->motion.acceleration) {
    for (PetscInt k = 0; k < count; k++) dynamics->a_new[k] = (dynamics->v_new[k] - dynamics->v_old[k]) / kick;
    step.a_new = dynamics->a_new;
  }
  if (again) PetscCall(PetscArrayzero(again, count));
  if (MpmModelMotion(model)->transfer.type == MPM_TRANSFER_APIC && MpmShapeDegree(model->scene.shape.type) < 2 &&
      MpmLightNodesExist(model)) {
    PetscCall(PetscArraycpy(dynamics->a_rest, dynamics->v_new, count));
    MpmLightNodesLimitGradients(model, kick, 1., dynamics->a_rest);
    step.affine = dynamics->a_rest;
    step.thin   = MpmShapeHasDomain(model->scene.shape.type);
  }
  PetscCall(MpmMotionToPoints(model->disc.sum, &MpmModelMotion(model)->transfer, &step));
  if (!again) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmSpaceAddToOwners(model->disc.space, dim, again));
  PetscCall(MpmSpaceToGhosts(model->disc.space, dim, again));
  for (PetscInt i = 0; i < model->disc.space->local; i++)
    for (PetscInt a = 0; a < dim; a++) again[i * dim + a] = mass[i] > 0. ? again[i * dim + a] / mass[i] : 0.;
  MpmExplicitPrescribe(model, again);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The stress that follows from the nodes' new velocities, or the points', into the trial. */
static PetscErrorCode UpdateStress(MpmModel model, const PetscReal *again, MpmOutcome *outcome)
{
  PetscFunctionBeginUser;
  if (MpmModelMotion(model)->update == MPM_UPDATE_USF) PetscFunctionReturn(PETSC_SUCCESS);
  Displace(model, again ? again : model->state.scheme.dynamics->v_new, model->disc.trial->u);
  if (!again && MpmExplicitIsLinear(model))
    MpmLightNodesLimitGradients(model, KickLength(model), model->disc.sum->step.dt, model->disc.trial->u);
  PetscCall(EvaluatePoints(model, model->disc.trial->u, PETSC_FALSE, NULL, outcome));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A relaxation stops the points past a peak of their energy, and looks whether they are at rest. */
static PetscErrorCode Relax(MpmModel model, PetscReal *again)
{
  MpmDynamics *dynamics = model->state.scheme.dynamics;
  PetscBool    stopped;

  PetscFunctionBeginUser;
  if (!MpmModelRelaxes(model)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmRelaxationObserve(model, &stopped));
  if (stopped) {
    PetscCall(PetscArrayzero(dynamics->v_new, model->disc.space->local * model->disc.dim));
    PetscCall(PetscArrayzero(dynamics->v_old, model->disc.space->local * model->disc.dim));
    PetscCall(PetscArrayzero(dynamics->moves, model->disc.points->count * model->disc.dim));
    if (again) PetscCall(PetscArrayzero(again, model->disc.space->local * model->disc.dim));
    Displace(model, dynamics->v_new, model->disc.nodal.u);
  }
  PetscCall(MpmRelaxationFinish(model, model->disc.nodal.force));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Solve(MpmModel model, MpmOutcome *outcome)
{
  const PetscReal kick     = KickLength(model);
  MpmDynamics    *dynamics = model->state.scheme.dynamics;
  PetscReal      *again    = MpmModelMotion(model)->update == MPM_UPDATE_MUSL ? dynamics->v_rest : NULL;

  PetscFunctionBeginUser;
  MpmOutcomeClear(outcome);
  PetscCall(FindForces(model, outcome));
  if (outcome->code) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Accelerate(model, kick, model->disc.nodal.residual));
  FindSupports(model, kick);
  Displace(model, dynamics->v_new, model->disc.nodal.u);
  PetscCall(MpmStepFindLost(model, outcome));
  if (outcome->code) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MovePoints(model, kick, again));
  PetscCall(Relax(model, again));
  PetscCall(UpdateStress(model, again, outcome));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Work of supports, contact and damping in a velocity increment, by the mean of the velocities before and after it:
  times the force that is exactly the change of the nodes' kinetic energy. `work` has the step's terms, or none.
*/
static PetscErrorCode AddWork(MpmModel model, PetscReal kick, MpmStepWork *work)
{
  const MpmDamping *damping = model->disc.context.damping;
  MpmDynamics      *of      = model->state.scheme.dynamics;
  const PetscInt    dim     = model->disc.dim;

  PetscFunctionBeginUser;
  work->at       = HasOthers(model) ? of->a_start : NULL;
  work->supports = model->disc.nodal.residual;
  work->local    = model->disc.space->local;
  work->owned    = model->disc.space->owned;
  if (!MpmModelRelaxes(model)) {
    work->kick = of->v_start;
    work->part = kick / model->disc.sum->step.dt;
    for (PetscInt k = 0; k < work->local * dim; k++)
      of->v_start[k] = 0.5 * model->disc.sum->step.dt * (of->v_old[k] + of->v_new[k]);
    MpmLightNodesLimit(model, model->disc.sum->step.dt, of->v_start);
    for (PetscInt k = 0; damping->active && k < work->owned * dim; k++) /* besides that of the velocities before */
      work->taken += 0.5 * damping->dashpot[k] * (of->v_new[k] - of->v_old[k]) * of->v_start[k];
  }
  PetscCall(MpmEnergyAdd(model, work));
  PetscCall(MpmEntrainmentAddIncrement(model, model->disc.context.inertia->mass, of->v_old, of->v_new));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The account of energy, and the forces in sections. */
static PetscErrorCode Observe(MpmModel model)
{
  const PetscInt count    = model->disc.space->local * model->disc.dim;
  MpmDynamics   *dynamics = model->state.scheme.dynamics;
  PetscReal      gain[MPM_MAX_DIM];

  PetscFunctionBeginUser;
  if (model->disc.sections)
    PetscCall(MpmSectionsEvaluate(model->disc.sections, model->disc.constraints, model->disc.sum, model->disc.trial->u,
                                  model->state.particles));
  PetscCall(PetscArraycpy(dynamics->loads, model->disc.nodal.force, count));
  PetscCall(MpmStepMeanLoads(model, model->state.time + model->disc.sum->step.span, 1., dynamics->loads));
  GravityGain(model, gain);
  AddGravity(model, gain, dynamics->loads);
  PetscCall(
    AddWork(model, KickLength(model),
            &(MpmStepWork){.u = model->disc.nodal.u, .loads = dynamics->loads, .unstrained = IsColumns(model)}));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Stress and history become the points', and the points go with the nodes' new velocities. */
static PetscErrorCode Accept(MpmModel model)
{
  const MpmSum    *sum      = model->disc.sum;
  MpmDynamics     *dynamics = model->state.scheme.dynamics;
  const PetscReal *at       = HasOthers(model) ? dynamics->a_start : model->disc.nodal.u; /* where contact acted */
  PetscLogDouble   since;

  PetscFunctionBeginUser;
  PetscCall(MpmMonitorBegin(&model->monitor, MPM_TIME_TRANSFER, &since));
  PetscCall(Observe(model));
  if (MpmFluidsAmong(model->scene.materials->at, model->scene.materials->count))
    MpmMotionConvect(sum, &MpmModelMotion(model)->transfer, model->disc.trial);
  if (model->disc.points->motion.increment) PetscCall(MpmCommitLocal(sum, model->disc.trial, model->disc.nodal.u));
  else PetscCall(MpmCommitMoves(sum, model->disc.trial, sum->step.dt, dynamics->moves));
  if (HasOthers(model)) {
    Displace(model, dynamics->v_new, dynamics->v_start);
    MpmLightNodesLimit(model, sum->step.dt, dynamics->v_start);
    MpmTermsArrive(model->disc.terms, dynamics->v_start);
  }
  PetscCall(MpmTermsCommit(model->disc.terms, sum, at, model->state.particles));
  MpmTermsArrive(model->disc.terms, NULL);
  PetscCall(MpmStepFindReactions(model));
  MpmStepClip(model);
  PetscCall(MpmMonitorEnd(&model->monitor, MPM_TIME_TRANSFER, since));
  model->state.scheme.put_back        = PETSC_FALSE;
  model->disc.context.damping->active = PETSC_FALSE;
  model->state.dt.before = model->state.dt.last = 0.;
  model->state.scheme.behind                    = MpmModelRelaxes(model) ? 0. : 0.5 * sum->step.dt;
  model->disc.nodal.committed                   = PETSC_TRUE;
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, model->disc.points));
  PetscCall(MpmStepRemoveGone(model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode RollBack(MpmModel model)
{
  PetscFunctionBeginUser;
  model->disc.trial->of.id            = 0;
  model->disc.context.damping->active = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  The half increment at the end of a stage, by the forces with which another step would begin, as long as the last one.
  Without such a step the velocities stay where they are.
*/
static PetscErrorCode CatchUp(MpmModel model)
{
  const PetscReal behind = model->state.scheme.behind, dt = 2. * behind;
  const PetscBool first = (PetscBool)(MpmModelMotion(model)->update == MPM_UPDATE_USF);
  MpmOutcome      outcome;
  MpmDynamics    *dynamics;
  MpmStepWork     work = {.unstrained = (PetscBool)!first};

  PetscFunctionBeginUser;
  if (!(behind > 0.)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Begin(model, model->state.time + dt, dt, PETSC_FALSE, &outcome));
  dynamics = model->state.scheme.dynamics; /* a run that goes on at a stage's end has it from here on */
  if (!outcome.code) PetscCall(FindForces(model, &outcome));
  if (!outcome.code) {
    PetscCall(Accelerate(model, behind, model->disc.nodal.residual));
    PetscCall(MpmExplicitPrescribeAt(model, model->state.time, dynamics->v_new));
    FindSupports(model, behind);
    Displace(model, dynamics->v_new, model->disc.nodal.u);
    work.u = model->disc.nodal.u;
    PetscCall(AddWork(model, behind, &work));
    PetscCall(MovePoints(model, behind, NULL));
    PetscCall(PetscArrayzero(dynamics->moves, model->disc.points->count * model->disc.dim));
    if (first) PetscCall(MpmCommitMoves(model->disc.sum, model->disc.trial, 0., dynamics->moves));
    model->state.scheme.behind = 0.;
  }
  PetscCall(RollBack(model));
  model->disc.nodal.committed = (PetscBool)!outcome.code;
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, model->disc.points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

const MpmIntegrator MpmIntegratorExplicit = {.name      = "explicit",
                                             .begin     = Begin,
                                             .predict   = Predict,
                                             .solve     = Solve,
                                             .accept    = Accept,
                                             .roll_back = RollBack,
                                             .length    = MpmExplicitLength,
                                             .finish    = CatchUp};

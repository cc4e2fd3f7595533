/*
  Implicit steps with inertia: backward Euler, Newmark's method and the generalised-alpha method.

  With the displacement u of the step as unknown,

    a_new = (u - dt v)/(beta dt^2) - (1/(2 beta) - 1) a ,     v_new = v + dt ((1 - gamma) a + gamma a_new)

  and the balance

    M ((1 - alpha_m) a_new + alpha_m a) + (1 - alpha_f) f(u) + alpha_f f(0) = (1 - alpha_f) f_ext + alpha_f f_ext,n

  where f(0) are the points' forces in the stress of the step's start. Newmark's method has alpha_m = alpha_f = 0, or 1
  - gamma once contact has been near in a stage, see below; generalised alpha

    alpha_m = (2 rho - 1)/(rho + 1) ,   alpha_f = rho/(rho + 1) ,   gamma = 1/2 - alpha_m + alpha_f ,
    beta = (1 - alpha_m + alpha_f)^2/4 ;

  backward Euler v_new = u/dt, a_new = (v_new - v)/dt. Boundaries and bodies in contact, whose forces a step begins
  anew, take part as they are at its end; surfaces of bodies, too, by the mean of the load's factors.

  Newmark's balance with alpha_m = alpha_f = 1 - gamma is that of two times, weighted as accelerations are for the
  velocity: where nothing touches and the first acceleration is in balance steps are the same. With contact as at the
  end the change of momentum is dt times the contact's force there, the work of a step that of a force which the penalty
  has reached, never less than what the penalty then stores: no energy comes from contact. In the balance at the end
  half the force of a contact that has opened would still push in the step after.

  Velocities and accelerations at the step's start are the points', weighted by mass. At the end the points take them by
  the weights of the step's start, and then move with u.

  Sources: Newmark (1959), J. Eng. Mech. Div. ASCE 85, 67-94; Chung, Hulbert (1993), J. Appl. Mech. 60, 371-375,
  doi:10.1115/1.2900803; Kane, Repetto, Ortiz, Marsden (1999), Comput. Meth. Appl. Mech. Eng. 180, 1-26,
  doi:10.1016/S0045-7825(99)00034-1 (contact's forces as at a step's end in Newmark's method); Guilkey, Weiss
  (2003), Int. J. Numer. Meth. Eng. 57, 1323-1338, doi:10.1002/nme.729 (implicit dynamics with material points).
*/
#include "point/layout.h"
#include "grid/grid.h"
#include "particles/particles.h"
#include "space/space.h"
#include "space/sum.h"
#include "transfer/momentum.h"
#include "transfer/motion.h"
#include "bc/bc.h"
#include "assembly/terms.h"
#include "volume/damping.h"
#include "volume/inertia.h"
#include "solve/iterate.h"
#include "query/model.h"
#include "query/query.h"
#include "scene/integrator_read.h"
#include "step/energy.h"
#include "step/step.h"
#include "integrators/dynamics.h"
#include "integrators/integrators.h"

static PetscErrorCode Reset(MpmDynamics *dynamics)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(dynamics->loads));
  PetscCall(PetscFree7(dynamics->v_old, dynamics->v_start, dynamics->a_start, dynamics->a_rest, dynamics->v_rest,
                       dynamics->v_new, dynamics->a_new));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmDynamicsDestroy(MpmDynamics **dynamics)
{
  PetscFunctionBeginUser;
  if (!*dynamics) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Reset(*dynamics));
  PetscCall(PetscFree((*dynamics)->moves));
  PetscCall(PetscFree(*dynamics));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MpmDynamicsSetStage(MpmModel model)
{
  const MpmMotionControl *motion  = MpmModelMotion(model);
  const PetscBool         moves   = (PetscBool)(motion->type != MPM_QUASISTATIC);
  MpmDamping             *damping = model->disc.context.damping;

  damping->active     = PETSC_FALSE;
  damping->mass       = moves ? motion->damping.mass : 0.;
  damping->stiffness  = moves ? motion->damping.stiffness : 0.;
  damping->linear     = moves ? motion->damping.linear : 0.;
  damping->quadratic  = moves ? motion->damping.quadratic : 0.;
  damping->conditions = moves && !model->state.scheme.rescuing.on ? model->scene.bcs : NULL;
  damping->acting     = model->state.acting.bcs;
}

/* Outside of a step the balance has neither inertia nor damping. */
static void Stop(MpmModel model)
{
  model->disc.context.inertia->active = model->disc.context.damping->active = PETSC_FALSE;
}

PetscErrorCode MpmDynamicsBegin(MpmModel model)
{
  const PetscInt last = model->state.stage - 1;

  PetscFunctionBeginUser;
  Stop(model);
  if (!MpmStagesAreDynamic(model) || last < 0) PetscFunctionReturn(PETSC_SUCCESS);
  if (model->scene.stages.at[last].time.motion.type != MPM_QUASISTATIC &&
      model->scene.stages.at[last + 1].time.motion.type != MPM_QUASISTATIC)
    PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmParticlesRest(model->state.particles));
  if (model->scene.stages.at[last].time.motion.type != MPM_QUASISTATIC) model->state.dt.before = -1.;
  MpmTermsRest(model->disc.terms);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- a step ---- */

PetscErrorCode MpmDynamicsResize(MpmModel model)
{
  MpmDynamics *dynamics;
  PetscInt     count;

  PetscFunctionBeginUser;
  if (!model->state.scheme.dynamics) PetscCall(PetscNew(&model->state.scheme.dynamics));
  dynamics = model->state.scheme.dynamics;
  PetscCall(MpmInertiaResize(model->disc.context.inertia, model->disc.space));
  dynamics->local = model->disc.context.inertia->local;
  count           = dynamics->local * model->disc.dim + 1;
  if (dynamics->loads && dynamics->local <= dynamics->capacity) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Reset(dynamics));
  PetscCall(PetscMalloc7(count, &dynamics->v_old, count, &dynamics->v_start, count, &dynamics->a_start, count,
                         &dynamics->a_rest, count, &dynamics->v_rest, count, &dynamics->v_new, count,
                         &dynamics->a_new));
  PetscCall(PetscMalloc1(count, &dynamics->loads));
  dynamics->capacity = dynamics->local;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Nodal values at the step's start. */
static PetscErrorCode Project(MpmModel model)
{
  MpmDynamics *dynamics;

  PetscFunctionBeginUser;
  PetscCall(MpmDynamicsResize(model));
  dynamics = model->state.scheme.dynamics;
  PetscCall(MpmEnergyOpen(model));
  PetscCall(MpmMomentumToNodes(model->disc.sum, &MpmModelMotion(model)->transfer, model->disc.context.inertia->mass,
                               dynamics->v_old, dynamics->a_start));
  MpmTermsLend(model->disc.terms, model->disc.context.inertia->mass, dynamics->v_old, dynamics->a_start);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Of one of the integrator's arrays, prescribed unknowns become `values` plus `factor` times their displacement. */
static void SetConstrained(MpmModel model, const PetscReal values[], PetscReal factor, PetscReal array[])
{
  const MpmConstraints *constraints = model->disc.constraints;
  const PetscInt        dim = model->disc.dim, local = model->state.scheme.dynamics->local;

  MpmFramesToUnknowns(constraints, dim, local, array);
  for (PetscInt k = 0; k < local * dim; k++)
    if (!MpmConstraintsCounts(constraints, k)) array[k] = values[k] + factor * constraints->value[k];
  MpmFramesToAxes(constraints, dim, local, array);
}

/* Prescribed velocities and accelerations of unknowns, at the step's start */
static PetscErrorCode StartConstrained(MpmModel model)
{
  MpmDynamics *dynamics = model->state.scheme.dynamics;
  PetscReal   *values;

  PetscFunctionBeginUser;
  if (!MpmStepPrescribes(model)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1((dynamics->local * model->disc.dim), &values));
  PetscCall(MpmStepPrescribedRate(model, model->state.time, 1, values));
  SetConstrained(model, values, 0., dynamics->v_start);
  PetscCall(MpmStepPrescribedRate(model, model->state.time, 2, values));
  SetConstrained(model, values, 0., dynamics->a_start);
  PetscCall(PetscFree(values));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* and at its end, whatever the method makes of their displacement. */
static PetscErrorCode EndConstrained(MpmModel model, PetscReal time)
{
  MpmDynamics *dynamics = model->state.scheme.dynamics;
  PetscReal   *values;

  PetscFunctionBeginUser;
  if (!MpmStepPrescribes(model)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1((dynamics->local * model->disc.dim), &values));
  PetscCall(MpmStepPrescribedRate(model, time, 1, values));
  SetConstrained(model, values, -dynamics->v_factor, dynamics->v_rest);
  PetscCall(MpmStepPrescribedRate(model, time, 2, values));
  SetConstrained(model, values, -dynamics->a_factor, dynamics->a_rest);
  PetscCall(PetscFree(values));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Nodal values of elements from the points' momentum; of nodes with a mass of their own from the values themselves. */
static PetscErrorCode SolveMass(MpmModel model, const PetscReal momentum[], PetscReal values[])
{
  const MpmInertia *inertia = model->disc.context.inertia;
  const PetscInt    dim = model->disc.dim, count = inertia->local * dim, extra = model->disc.space->extra.begin;
  PetscReal        *right;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(count, &right));
  for (PetscInt k = 0; k < count; k++)
    right[k] = momentum[k] * (k / dim >= extra && k / dim < inertia->owned ? inertia->mass[k / dim] : 1.);
  PetscCall(MpmInertiaSolve(inertia, model->disc.sum, model->disc.constraints, model->comm, right, values));
  PetscCall(PetscFree(right));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  The step's mass. Where points get changes alone, all changes must reach them: otherwise the nodes' velocities, which
  are means of theirs, would be smoothed in each step anew, and lag by a fraction dt (w h)^2.
*/
static PetscErrorCode SetMass(MpmModel model)
{
  MpmDynamics            *dynamics = model->state.scheme.dynamics;
  MpmInertia             *inertia  = model->disc.context.inertia;
  const MpmMotionControl *motion   = MpmModelMotion(model);

  PetscFunctionBeginUser;
  inertia->consistent = (PetscBool)!motion->lumped;
  inertia->solved     = (PetscBool)(model->disc.grid->order > 1);
  if (!inertia->consistent) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmMassMatrixSetUp(&inertia->matrix, model->disc.sum));
  if (inertia->solved) {
    PetscCall(SolveMass(model, dynamics->v_old, dynamics->v_start));
    PetscCall(SolveMass(model, dynamics->a_start, dynamics->a_start));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (motion->transfer.type != MPM_TRANSFER_FLIP) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmInertiaSharpen(inertia, model->disc.sum, model->disc.constraints, dynamics->v_start));
  PetscCall(MpmInertiaSharpen(inertia, model->disc.sum, model->disc.constraints, dynamics->a_start));
  PetscFunctionReturn(PETSC_SUCCESS);
}

MpmTimeMethod MpmTimeMethodOf(const MpmModel model)
{
  const MpmMotionControl *motion = MpmModelMotion(model);
  MpmTimeMethod           method = {.beta = motion->beta, .gamma = motion->gamma};

  if (motion->type == MPM_NEWMARK && model->state.scheme.met) method.alpha_m = method.alpha_f = 1. - motion->gamma;
  if (motion->type == MPM_GENERALIZED_ALPHA) {
    const PetscReal rho = motion->rho_inf;

    method.alpha_m = (2. * rho - 1.) / (rho + 1.);
    method.alpha_f = rho / (rho + 1.);
    method.gamma   = 0.5 - method.alpha_m + method.alpha_f;
    method.beta    = 0.25 * PetscSqr(1. - method.alpha_m + method.alpha_f);
  }
  return method;
}

/* Velocity and acceleration from the displacement. */
static void SetRates(MpmModel model, const MpmTimeMethod *method, PetscReal dt)
{
  MpmDynamics    *dynamics = model->state.scheme.dynamics;
  const PetscBool euler    = (PetscBool)(MpmModelMotion(model)->type == MPM_BACKWARD_EULER);
  const PetscReal beta = method->beta, gamma = method->gamma;

  dynamics->a_factor = euler ? 1. / (dt * dt) : 1. / (beta * dt * dt);
  dynamics->v_factor = euler ? 1. / dt : gamma / (beta * dt);
  for (PetscInt k = 0; k < dynamics->local * model->disc.dim; k++) {
    const PetscReal v = dynamics->v_start[k], a = dynamics->a_start[k];

    dynamics->a_rest[k] = euler ? -v / dt : -v / (beta * dt) - (0.5 / beta - 1.) * a;
    dynamics->v_rest[k] = euler ? 0. : v + dt * ((1. - gamma) * a + gamma * dynamics->a_rest[k]);
  }
}

/* The inertia and the damping that follow. */
static PetscErrorCode SetForces(MpmModel model, const MpmTimeMethod *method)
{
  MpmDynamics    *dynamics = model->state.scheme.dynamics;
  MpmInertia     *inertia  = model->disc.context.inertia;
  const PetscInt  count    = dynamics->local * model->disc.dim;
  const PetscReal end      = 1. - method->alpha_f;
  PetscReal      *rest;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < count; k++)
    inertia->at_rest[k] = (1. - method->alpha_m) * dynamics->a_rest[k] + method->alpha_m * dynamics->a_start[k];
  inertia->factor = (1. - method->alpha_m) * dynamics->a_factor;
  inertia->active = PETSC_TRUE;
  PetscCall(PetscMalloc1(count, &rest));
  for (PetscInt k = 0; k < count; k++) rest[k] = end * dynamics->v_rest[k] + method->alpha_f * dynamics->v_start[k];
  PetscCall(MpmDampingSet(model->disc.context.damping, model->disc.space, inertia, end * dynamics->v_factor, rest));
  PetscCall(PetscFree(rest));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The part of the points' forces that is the step's start's stands among the loads. */
static PetscErrorCode AddStart(MpmModel model, PetscReal alpha_f, MpmOutcome *outcome)
{
  const PetscInt count  = model->disc.context.inertia->local * model->disc.block;
  MpmSum         start  = *model->disc.sum;
  MpmSumStep     step   = start.step;
  PetscInt       failed = 0;
  PetscReal     *still, *force;

  PetscFunctionBeginUser;
  step.part = 1. - alpha_f;
  MpmDiscretizationSetStep(&model->disc, &step);
  if (!(alpha_f > 0.)) PetscFunctionReturn(PETSC_SUCCESS);
  start.step.part = 1.;
  start.mode      = model->disc.layout->means ? MPM_MODE_END : MPM_MODE_START;
  PetscCall(PetscCalloc2(count, &still, count, &force));
  PetscCall(MpmTermsResidualPoints(model->disc.terms, &start, still, NULL, force, &failed));
  for (PetscInt k = 0; k < count; k++) model->disc.nodal.force[k] -= alpha_f * force[k];
  PetscCall(PetscFree2(still, force));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &failed, 1, MPIU_INT, MPI_SUM, model->comm));
  if (failed)
    PetscCall(MpmOutcomeFail(outcome, MPM_OUTCOME_NO_ANSWER, "a point's law has no answer at the step's start"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmDynamicsAddRows(MpmModel model)
{
  const MpmRow rows[] = {
    {"contact_met", MPM_ROW_BOOL, MPM_ROW_STATE, &model->state.scheme.met, 0, 0},
    {"velocities_behind", MPM_ROW_REAL, MPM_ROW_STATE, &model->state.scheme.behind, 0, 0},
  };

  PetscFunctionBeginUser;
  PetscCall(MpmRowsAdd(model->state.rows, NULL, PETSC_STATIC_ARRAY_LENGTH(rows), rows));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Lumped masses of the unknowns, those of the nodes that follow them included: masses of gathered forces. */
static PetscErrorCode GatherMass(MpmModel model, PetscReal mass[])
{
  const MpmSpace *space = model->disc.space;
  const PetscInt  dim = model->disc.dim, owned = space->owned * dim;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < space->local * dim; k++)
    mass[k] = k < owned ? model->disc.context.inertia->mass[k / dim] : 0.;
  MpmConstraintsGather(model->disc.constraints, space, mass);
  PetscCall(MpmSpaceAddToOwners(space, dim, mass));
  PetscCall(MpmSpaceToGhosts(space, dim, mass));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* a_new of the residual, by lumped masses. */
static PetscErrorCode AccelerateLumped(MpmModel model)
{
  MpmDynamics   *dynamics = model->state.scheme.dynamics;
  const PetscInt dim = model->disc.dim, count = dynamics->local * dim;
  PetscReal     *mass = dynamics->v_new;

  PetscFunctionBeginUser;
  MpmFramesToUnknowns(model->disc.constraints, dim, dynamics->local, model->disc.nodal.residual);
  PetscCall(GatherMass(model, mass));
  for (PetscInt k = 0; k < count; k++) {
    const PetscBool free = MpmConstraintsFree(model->disc.constraints, k);

    dynamics->a_new[k] = free && mass[k] > 0. ? -model->disc.nodal.residual[k] / mass[k] : 0.;
  }
  MpmFramesToAxes(model->disc.constraints, dim, dynamics->local, dynamics->a_new);
  MpmConstraintsExtend(model->disc.constraints, model->disc.space, dynamics->a_new);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* and by the consistent mass. */
static PetscErrorCode AccelerateConsistent(MpmModel model)
{
  MpmDynamics   *dynamics = model->state.scheme.dynamics;
  const PetscInt count    = dynamics->local * model->disc.dim;
  PetscReal     *force    = dynamics->v_new;

  PetscFunctionBeginUser;
  model->disc.context.inertia->consistent = PETSC_TRUE;
  PetscCall(MpmMassMatrixSetUp(&model->disc.context.inertia->matrix, model->disc.sum));
  for (PetscInt k = 0; k < count; k++) {
    force[k]           = -model->disc.nodal.residual[k];
    dynamics->a_new[k] = 0.;
  }
  PetscCall(MpmInertiaSolve(model->disc.context.inertia, model->disc.sum, model->disc.constraints, model->comm, force,
                            dynamics->a_new));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  A stage's first acceleration is that of the forces at its beginning; it goes to the nodes by way of the points, for
  nearly massless nodes.
*/
static PetscErrorCode FindAcceleration(MpmModel model)
{
  const MpmTransfer only     = {.type = MPM_TRANSFER_FLIP};
  MpmDynamics      *dynamics = model->state.scheme.dynamics;
  PetscInt          failed;

  PetscFunctionBeginUser;
  PetscCall(PetscArrayzero(model->disc.nodal.u, model->disc.context.inertia->local * model->disc.block));
  PetscCall(MpmSumResidual(&model->solver, NULL, MPM_MODE_END, &failed));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &failed, 1, MPIU_INT, MPI_SUM, model->comm));
  if (failed) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmNodesToGhosts(&model->disc, model->disc.dim, model->disc.nodal.residual));
  if (model->disc.grid->order > 1) PetscCall(AccelerateConsistent(model));
  else PetscCall(AccelerateLumped(model));
  MpmTermsTake(model->disc.terms, NULL, dynamics->a_new);
  PetscCall(
    MpmMotionToPoints(model->disc.sum, &only,
                      &(MpmMotionStep){.v_old = dynamics->v_old, .v_new = dynamics->v_old, .a_new = dynamics->a_new}));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* For the account of energy. */
static PetscErrorCode KeepLoads(MpmModel model, PetscReal time, PetscReal alpha_f)
{
  MpmDynamics *dynamics = model->state.scheme.dynamics;

  PetscFunctionBeginUser;
  PetscCall(PetscArraycpy(dynamics->loads, model->disc.nodal.force, dynamics->local * model->disc.dim));
  PetscCall(MpmStepMeanLoads(model, time, alpha_f, dynamics->loads));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The space, loads and solver of a step, and by which method it is taken: that depends on whether contact is near. */
static PetscErrorCode PrepareStep(MpmModel model, PetscReal time, PetscReal dt, PetscBool first, PetscBool again,
                                  MpmTimeMethod *method, MpmOutcome *outcome)
{
  PetscReal before;

  PetscFunctionBeginUser;
  if (first) model->state.scheme.met = PETSC_FALSE;
  *method = MpmTimeMethodOf(model);
  before = model->state.scheme.load_at_start = first ? 1. : method->alpha_f;
  PetscCall(MpmStepPrepare(model, time, dt, again, outcome));
  if (outcome->code || !MpmTermsNear(model->disc.terms, MPM_TERM_CONTACT)) PetscFunctionReturn(PETSC_SUCCESS);
  model->state.scheme.met = PETSC_TRUE;
  *method                 = MpmTimeMethodOf(model);
  if (method->alpha_f == before || first) PetscFunctionReturn(PETSC_SUCCESS);
  model->state.scheme.load_at_start = method->alpha_f;
  PetscCall(MpmStepPrepare(model, time, dt, PETSC_TRUE, outcome));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Begin(MpmModel model, PetscReal time, PetscReal dt, PetscBool again, MpmOutcome *outcome)
{
  const PetscBool first = (PetscBool)(model->state.dt.last == 0. && MpmModelMotion(model)->type != MPM_BACKWARD_EULER);
  MpmTimeMethod   method;

  PetscFunctionBeginUser;
  Stop(model);
  PetscCall(PrepareStep(model, time, dt, first, again, &method, outcome));
  if (outcome->code) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Project(model));
  if (first) {
    PetscCall(FindAcceleration(model));
    model->state.scheme.load_at_start = method.alpha_f;
    PetscCall(MpmStepPrepare(model, time, dt, PETSC_TRUE, outcome));
    if (outcome->code) PetscFunctionReturn(PETSC_SUCCESS);
    PetscCall(Project(model));
  }
  PetscCall(PetscArraycpy(model->state.scheme.dynamics->v_start, model->state.scheme.dynamics->v_old,
                          model->disc.context.inertia->local * model->disc.dim));
  PetscCall(StartConstrained(model));
  PetscCall(SetMass(model));
  SetRates(model, &method, dt);
  PetscCall(EndConstrained(model, time));
  PetscCall(SetForces(model, &method));
  PetscCall(
    MpmTermsTurn(model->disc.terms, model->disc.sum, model->state.scheme.dynamics->v_start, 1. - method.alpha_f));
  PetscCall(KeepLoads(model, time, method.alpha_f));
  PetscCall(AddStart(model, method.alpha_f, outcome));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Newton starts where velocity and acceleration lead. */
static PetscErrorCode Predict(MpmModel model)
{
  const MpmDynamics *dynamics = model->state.scheme.dynamics;
  const PetscInt     n        = model->disc.context.inertia->owned * model->disc.dim;
  const PetscReal    dt       = model->disc.sum->step.dt;
  PetscScalar       *x;

  PetscFunctionBeginUser;
  PetscCall(MpmStepFindReference(model));
  model->solver.cache.predicted = PETSC_TRUE;
  PetscCall(VecGetArray(model->solver.x, &x));
  for (PetscInt k = 0; k < n; k++)
    x[k] = model->disc.context.inertia->mass[k / model->disc.dim] > 0.
             ? dt * dynamics->v_start[k] + 0.5 * dt * dt * dynamics->a_start[k]
             : 0.;
  MpmFramesToUnknowns(model->disc.constraints, model->disc.block, model->disc.context.inertia->owned, x);
  MpmUnitsOver(model->disc.constraints, n, x);
  MpmConstraintsPrescribe(model->disc.constraints, n, x);
  PetscCall(VecRestoreArray(model->solver.x, &x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Solve(MpmModel model, MpmOutcome *outcome)
{
  return MpmIntegratorQuasistatic.solve(model, outcome);
}

/* Points take velocity and acceleration before they move. */
static PetscErrorCode Accept(MpmModel model)
{
  MpmDynamics     *dynamics = model->state.scheme.dynamics;
  const PetscReal *u        = model->disc.nodal.u;

  PetscFunctionBeginUser;
  PetscCall(MpmStepFindTrial(model));
  for (PetscInt k = 0; k < dynamics->local * model->disc.dim; k++) {
    dynamics->v_new[k] = dynamics->v_factor * u[k] + dynamics->v_rest[k];
    dynamics->a_new[k] = dynamics->a_factor * u[k] + dynamics->a_rest[k];
  }
  MpmTermsTake(model->disc.terms, dynamics->v_new, dynamics->a_new);
  PetscCall(MpmEnergyAdd(model, &(MpmStepWork){.u        = u,
                                               .loads    = dynamics->loads,
                                               .supports = model->disc.nodal.residual,
                                               .local    = model->disc.context.inertia->local,
                                               .owned    = model->disc.context.inertia->owned}));
  PetscCall(MpmMotionToPoints(
    model->disc.sum, &MpmModelMotion(model)->transfer,
    &(MpmMotionStep){.v_old = dynamics->v_start, .v_new = dynamics->v_new, .a_new = dynamics->a_new}));
  PetscCall(MpmIntegratorQuasistatic.accept(model));
  PetscCall(MpmStepRemoveGone(model));
  if (model->state.scheme.error.accepted > 0.) model->state.scheme.error.largest = model->state.scheme.error.trial;
  Stop(model);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode RollBack(MpmModel model)
{
  PetscFunctionBeginUser;
  Stop(model);
  PetscCall(MpmIntegratorQuasistatic.roll_back(model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

const MpmIntegrator MpmIntegratorImplicit = {.name      = "implicit dynamics",
                                             .begin     = Begin,
                                             .predict   = Predict,
                                             .solve     = Solve,
                                             .error     = MpmDynamicsError,
                                             .accept    = Accept,
                                             .roll_back = RollBack};

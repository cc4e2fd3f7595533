/*
  Explicit dynamics: symplectic Euler, without a matrix or a solver.

    m_i = sum_p w_ip m_p ,   v_i = sum_p w_ip m_p (v_p + C_p (x_i - x_p)) / m_i
    f_i = f_ext,i - sum_p V_p sigma_p grad w_ip + contact
    v*_i = v_i + dt f_i/m_i ,   x_p += dt sum_i w_ip v*_i ,   v_p by FLIP or APIC

  and the stress of the velocities v**, gradient by gradient, through the same kernel of the physics as implicit steps: with
  the displacement dt v** of the nodes. musl: v** are the points' new velocities, mapped once more; usl: v*; usf: v** = v_i,
  and the stress that follows makes f_i.

  What pushes on a node without mass finds nothing to move. Prescribed unknowns move as they are told to.

  A step may take the part `cfl` of the time in which a wave crosses a cell, the shortest h_a/(c + |v_a|) of all points and axes,
  with c the speed of waves at the point's state and stress; the viscosity of a law shortens it.

  Sources: Sulsky, Zhou, Schreyer (1995), Comput. Phys. Commun. 87, 236-252, doi:10.1016/0010-4655(94)00170-7 (musl); Bardenhagen
  (2002), J. Comput. Phys. 180, 383-403, doi:10.1006/jcph.2002.7103 (usf, usl).
*/
#include "particles/particles.h"
#include "particles/points.h"
#include "point/layout.h"
#include "point/material.h"
#include "grid/grid.h"
#include "space/space.h"
#include "space/sum.h"
#include "bc/bc.h"
#include "terms/damping.h"
#include "terms/inertia.h"
#include "terms/section.h"
#include "terms/terms.h"
#include "time/dynamics.h"
#include "time/energy.h"
#include "time/integrator.h"
#include "time/model.h"
#include "time/relaxation.h"
#include "time/step.h"
#include "time/time.h"

/* ---- how long a step may be ---- */

/*
  The time in which a wave crosses a cell, the shortest over all points, s; with a law's viscosity nu = eta J/rho_0, m2/s, what
  is stable: h/(sqrt(c^2 + (nu/h)^2) + nu/h), h^2/(2 nu) where nothing but it acts.
*/
static PetscErrorCode FindCrossing(MpmModel model, PetscReal *crossing)
{
  const MpmSum  *sum = model->disc.sum;
  const PetscInt dim = model->disc.dim;
  MpmPoints      points;

  PetscFunctionBeginUser;
  *crossing = PETSC_MAX_REAL;
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  for (PetscInt p = 0; p < points.count; p++) {
    const MpmMaterial *material = &sum->materials[points.material[p]];
    const PetscReal *state = points.state ? &points.state[p * sum->state_size] : NULL, *F = &points.F[p * dim * dim];
    const PetscReal  c  = MpmMaterialWaveSpeed(material, dim, state, F, &points.stress[p * MpmSymSize(dim)]);
    const PetscReal  nu = MpmMaterialViscosity(material) * MpmPointVolumeRatio(material, dim, F) / material->density;

    for (PetscInt a = 0; a < dim; a++) {
      const PetscReal h     = model->disc.grid->h[a];
      const PetscReal speed = c + PetscAbsReal(points.velocity[p * dim + a]), spread = nu / h;

      *crossing = PetscMin(*crossing, h / (PetscSqrtReal(speed * speed + spread * spread) + spread));
    }
  }
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, crossing, 1, MPIU_REAL, MPIU_MIN, model->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* What damping leaves of a stable step: sqrt(1 + xi^2) - xi, xi the part of critical damping of the fastest oscillation, 2/crossing. */
static PetscReal Shortened(const MpmDampingControl *damping, PetscReal crossing)
{
  const PetscReal xi = damping->stiffness / crossing + 0.25 * damping->mass * crossing + damping->linear;

  return crossing * (PetscSqrtReal(1. + xi * xi) - xi);
}

static PetscErrorCode Length(MpmModel model, const char **why)
{
  const MpmTimeControl *control = &model->scene.stages[model->state.stage].time;
  PetscReal             crossing;

  PetscFunctionBeginUser;
  PetscCall(FindCrossing(model, &crossing));
  if (crossing > 0.) crossing = Shortened(&control->motion.damping, crossing);
  model->state.dt_wanted = control->motion.cfl * crossing;
  if (!(crossing > 0.)) *why = "a point has no finite wave speed";
  if (*why || !(control->step > 0.)) PetscFunctionReturn(PETSC_SUCCESS);
  if (control->step > crossing * (1. + PETSC_SQRT_MACHINE_EPSILON)) {
    PetscCall(PetscSNPrintf(model->solver.lost, sizeof(model->solver.lost),
                            "the step %.4g is longer than a wave takes through a cell, %.4g", (double)control->step,
                            (double)crossing));
    *why = model->solver.lost;
  }
  model->state.dt_wanted = control->step;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- a step ---- */

static PetscErrorCode Begin(MpmModel model, PetscReal time, PetscReal dt, PetscBool again, const char **why)
{
  PetscFunctionBeginUser;
  model->disc.inertia->active       = PETSC_FALSE;
  model->disc.sum->part             = 1.;
  model->state.scheme.load_at_start = 0.;
  PetscCall(MpmStepBegin(model, time, dt, again, why));
  if (*why) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmDynamicsResize(model));
  PetscCall(MpmMomentumToNodes(model->disc.sum, &MpmModelMotion(model)->transfer, model->disc.inertia->mass,
                               model->state.scheme.dynamics->v_old, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Predict(MpmModel model)
{
  PetscFunctionBeginUser;
  model->solver.newton = model->solver.linear = 0;
  model->disc.trial->made                     = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prescribed unknowns take the velocities that bring them to their places. */
static void Prescribe(const MpmModel model, PetscReal velocity[])
{
  const MpmConstraints *constraints = model->disc.constraints;
  const PetscInt        dim = model->disc.dim, local = model->disc.space->local;
  const PetscReal       dt = model->disc.sum->dt;

  if (!constraints->any) return;
  MpmFramesToUnknowns(constraints, dim, local, velocity);
  for (PetscInt k = 0; k < local * dim; k++)
    if (!MpmConstraintsFree(constraints, k)) velocity[k] = constraints->value[k] / dt;
  MpmFramesToAxes(constraints, dim, local, velocity);
}

/* Before the step they moved as they were told to half a step before its start: what carries them from there is their reaction. */
static PetscErrorCode PrescribeStart(MpmModel model, PetscReal velocity[])
{
  const MpmConstraints *constraints = model->disc.constraints;
  const PetscInt        dim = model->disc.dim, local = model->disc.space->local;
  PetscReal            *rate;

  PetscFunctionBeginUser;
  if (!constraints->any) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1((local * dim), &rate));
  PetscCall(MpmStepPrescribedRate(model, model->state.time - 0.5 * model->disc.sum->dt, 1, rate));
  MpmFramesToUnknowns(constraints, dim, local, velocity);
  for (PetscInt k = 0; k < local * dim; k++)
    if (!MpmConstraintsFree(constraints, k)) velocity[k] = rate[k];
  MpmFramesToAxes(constraints, dim, local, velocity);
  PetscCall(PetscFree(rate));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The points' forces at displacements u of the nodes; with `keep` what the points would be there goes into the trial. */
static PetscErrorCode PointForces(MpmModel model, const PetscReal u[], PetscBool still, PetscBool keep,
                                  PetscReal force[], const char **why)
{
  const MpmTerm *points = model->disc.terms->term[0];
  MpmSum        *sum    = model->disc.sum;
  PetscInt       failed = 0;
  PetscLogDouble since;

  PetscFunctionBeginUser;
  PetscCall(MpmMonitorBegin(&model->monitor, MPM_TIME_RESIDUAL, &since));
  sum->rest  = (PetscBool)(still && !model->disc.layout->means);
  sum->trial = keep ? model->disc.trial : NULL;
  PetscCall(PetscArrayzero(force, model->disc.space->local * model->disc.block));
  PetscCall(points->residual(model->disc.terms->ctx[0], sum, u, force, &failed));
  sum->rest  = PETSC_FALSE;
  sum->trial = NULL;
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &failed, 1, MPIU_INT, MPI_SUM, model->comm));
  if (failed) *why = "a point's law has no answer";
  PetscCall(MpmMonitorEnd(&model->monitor, MPM_TIME_RESIDUAL, since));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* u = dt v, at all local nodes */
static void Displace(const MpmModel model, const PetscReal velocity[], PetscReal u[])
{
  for (PetscInt k = 0; k < model->disc.space->local * model->disc.dim; k++) u[k] = model->disc.sum->dt * velocity[k];
}

/* The forces of contact and of whatever else adds to the balance, where the nodes would come without them. */
static PetscErrorCode OtherForces(MpmModel model, const PetscReal u[], PetscReal force[])
{
  const MpmTerms *terms  = model->disc.terms;
  PetscInt        failed = 0;

  PetscFunctionBeginUser;
  for (PetscInt k = 1; k < terms->count; k++)
    PetscCall(terms->term[k]->residual(terms->ctx[k], model->disc.sum, u, force, &failed));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* v* = v + dt f/m, the accelerations with it, and the residual that supports have to carry. */
static void Accelerate(MpmModel model)
{
  MpmDynamics     *dynamics = model->state.scheme.dynamics;
  const PetscReal *mass     = model->disc.inertia->mass;
  const PetscReal  dt       = model->disc.sum->dt;
  const PetscInt   dim = model->disc.dim, count = model->disc.space->local * dim;

  for (PetscInt k = 0; k < count; k++) {
    const PetscReal m = mass[k / dim];

    dynamics->v_new[k] = dynamics->v_old[k] + (m > 0. ? dt * model->disc.residual[k] / m : 0.);
  }
  Prescribe(model, dynamics->v_new);
  for (PetscInt k = 0; k < count; k++) {
    dynamics->a_new[k]      = (dynamics->v_new[k] - dynamics->v_old[k]) / dt;
    model->disc.residual[k] = mass[k / dim] * dynamics->a_new[k] - model->disc.residual[k];
  }
}

/* The forces at the nodes, into disc.residual, and the velocities that they make. */
static PetscErrorCode MoveNodes(MpmModel model, const char **why)
{
  const PetscInt  count    = model->disc.space->local * model->disc.block;
  MpmDynamics    *dynamics = model->state.scheme.dynamics;
  PetscReal      *force    = model->disc.residual;
  const PetscBool first    = (PetscBool)(MpmModelMotion(model)->update == MPM_UPDATE_USF);

  PetscFunctionBeginUser;
  PetscCall(PrescribeStart(model, dynamics->v_old)); /* what they move at does not come from the points */
  if (first) Displace(model, dynamics->v_old, model->disc.trial->u);
  else PetscCall(PetscArrayzero(model->disc.trial->u, count));
  PetscCall(PointForces(model, model->disc.trial->u, (PetscBool)!first, first, force, why));
  if (*why) PetscFunctionReturn(PETSC_SUCCESS);
  Displace(model, dynamics->v_old, model->disc.u);
  PetscCall(MpmDampingSet(model->disc.damping, model->disc.space, model->disc.inertia->mass, 0., dynamics->v_old));
  PetscCall(OtherForces(model, model->disc.u, force));
  for (PetscInt k = 0; k < count; k++) force[k] = model->disc.force[k] - force[k];
  PetscCall(MpmSpaceAddToOwners(model->disc.space, model->disc.block, force));
  PetscCall(MpmSpaceToGhosts(model->disc.space, model->disc.block, force));
  if (MpmModelRelaxes(model)) PetscCall(MpmRelaxationDamp(model, model->disc.force, force));
  Accelerate(model);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The stress that follows from the nodes' new velocities, or the points', into the trial. */
static PetscErrorCode UpdateStress(MpmModel model, const char **why)
{
  const MpmMotionControl *motion   = MpmModelMotion(model);
  MpmDynamics            *dynamics = model->state.scheme.dynamics;
  PetscReal              *velocity = dynamics->v_new;

  PetscFunctionBeginUser;
  if (motion->update == MPM_UPDATE_USF) PetscFunctionReturn(PETSC_SUCCESS);
  if (motion->update == MPM_UPDATE_MUSL) {
    velocity = dynamics->v_rest;
    PetscCall(MpmMomentumToNodes(model->disc.sum, &motion->transfer, model->disc.inertia->mass, velocity, NULL));
    Prescribe(model, velocity);
  }
  Displace(model, velocity, model->disc.trial->u);
  PetscCall(PointForces(model, model->disc.trial->u, PETSC_FALSE, PETSC_TRUE, dynamics->a_rest, why));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Solve(MpmModel model, const char **why, PetscBool *retryable)
{
  MpmDynamics *dynamics = model->state.scheme.dynamics;

  PetscFunctionBeginUser;
  *why       = NULL;
  *retryable = PETSC_FALSE;
  PetscCall(MoveNodes(model, why));
  if (*why) PetscFunctionReturn(PETSC_SUCCESS);
  Displace(model, dynamics->v_new, model->disc.u);
  PetscCall(MpmStepFindLost(model, why));
  if (*why) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmMomentumToPoints(model->disc.sum, &MpmModelMotion(model)->transfer, dynamics->v_old, dynamics->v_new,
                                model->disc.points->acceleration ? dynamics->a_new : NULL));
  if (MpmModelRelaxes(model)) {
    PetscCall(MpmRelaxationObserve(model));
    Displace(model, dynamics->v_new, model->disc.u);
    PetscCall(MpmRelaxationFinish(model, model->disc.force));
  }
  PetscCall(UpdateStress(model, why));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* What the step has done: the other forces acted where the nodes would have come without them. */
static PetscErrorCode AddWork(MpmModel model)
{
  MpmDynamics *dynamics = model->state.scheme.dynamics;

  PetscFunctionBeginUser;
  Displace(model, dynamics->v_old, dynamics->a_rest);
  PetscCall(
    MpmEnergyAdd(model, &(MpmStepWork){model->disc.u, dynamics->a_rest, model->disc.force, model->disc.residual}));
  model->disc.damping->active = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Stress and history become the points', and the points go with v*. */
static PetscErrorCode Accept(MpmModel model)
{
  MpmSum        *sum = model->disc.sum;
  PetscLogDouble since;

  PetscFunctionBeginUser;
  PetscCall(MpmMonitorBegin(&model->monitor, MPM_TIME_TRANSFER, &since));
  if (model->disc.sections)
    PetscCall(MpmSectionsEvaluate(model->disc.sections, sum, model->disc.trial->u, model->state.particles));
  PetscCall(AddWork(model));
  sum->trial = model->disc.trial;
  PetscCall(MpmCommitLocal(sum, model->disc.u));
  sum->trial = NULL;
  PetscCall(MpmTermsCommit(model->disc.terms, sum, model->disc.u, model->state.particles));
  PetscCall(MpmStepFindReactions(model));
  MpmStepClip(model);
  PetscCall(MpmMonitorEnd(&model->monitor, MPM_TIME_TRANSFER, since));
  model->disc.put_back   = PETSC_FALSE;
  model->state.dt_before = model->state.dt_last = 0.;
  model->disc.committed                         = PETSC_TRUE;
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, model->disc.points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode RollBack(MpmModel model)
{
  PetscFunctionBeginUser;
  model->disc.trial->made     = PETSC_FALSE;
  model->disc.damping->active = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

const MpmIntegrator MpmIntegratorExplicit = {.name      = "explicit",
                                             .begin     = Begin,
                                             .predict   = Predict,
                                             .solve     = Solve,
                                             .accept    = Accept,
                                             .roll_back = RollBack,
                                             .length    = Length};

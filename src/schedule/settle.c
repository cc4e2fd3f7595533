/*
  Settling: where Newton's method finds no state of rest under a smaller strength, the ground moves to one.

    f_int(u) - f_ext + M u/tau^2 = 0

  are steps that begin at rest, M the consistent mass: backward Euler without the velocity that the last step has left.
  The term stiffens a body most of whose points flow; without it Newton's method alternates between yield surfaces for
  ever. As forces come into balance u vanishes, and the term with it. tau doubles after a step and is halved where
  Newton's method fails, and then kept for HELD steps: a stable slope is at rest after a few, an unstable one slides
  further in each.

  At rest: the norm of M u/tau^2 is below REST of that of loads and reactions. Loads, supports and strengths are those
  of the end, from the first step on. Where the ground passes the limit of the reduction, or tau gets too short, the
  points go back to where they began.

  Order of calls: MpmSettle() in place of a step; within its steps MpmSettleSet().

  Source: pseudo-transient continuation; Kelley and Keyes (1998), SIAM J. Numer. Anal. 35, 508-523,
  doi:10.1137/S0036142996304796. Damped motion to rest under reduced strength: Dawson, Roth and Drescher (1999),
  Geotechnique 49, 835-840, doi:10.1680/geot.1999.49.6.835.
*/
#include "point/material.h"
#include "particles/particles.h"
#include "particles/points.h"
#include "particles/point_mass.h"
#include "space/space.h"
#include "space/sum.h"
#include "bc/bc.h"
#include "volume/inertia.h"
#include "contact/contact.h"
#include "problem/discretization.h"
#include "query/model.h"
#include "integrators/integrators.h"
#include "schedule/reduction.h"
#include "schedule/schedule.h"
#include "schedule/settle.h"

#define REST     1e-4
#define LONGER   2.
#define HELD     3
#define STEPS    60   /* for one state of rest, at most */
#define SHORTEST 1e-3 /* of the time in which a wave crosses the material */

/* The time in which the slowest wave crosses the material along its longest side, s. */
static PetscErrorCode FindCrossing(MpmModel model, PetscReal *crossing)
{
  const PetscInt dim = model->disc.dim;
  PetscReal      lower[MPM_MAX_DIM], upper[MPM_MAX_DIM], slowest = PETSC_MAX_REAL, longest = 0.;
  MpmPoints      points;

  PetscFunctionBeginUser;
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  PetscCall(MpmParticlesGetExtents(model->state.particles, &points, lower, upper));
  for (PetscInt p = 0; p < points.count; p++) {
    const MpmMaterial *material = &model->disc.sum->materials[points.material[p]];
    const PetscReal   *state    = points.state ? &points.state[p * model->disc.sum->kept.state] : NULL;

    slowest = PetscMin(slowest, MpmMaterialWaveSpeed(material, MpmPointOwn(&points, material, p), dim, state,
                                                     MpmPointF(&points, p), &points.stress[p * MpmSymSize(dim)]));
  }
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &slowest, 1, MPIU_REAL, MPIU_MIN, model->comm));
  for (PetscInt a = 0; a < dim; a++) longest = PetscMax(longest, upper[a] - lower[a]);
  *crossing = longest / slowest;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Norm of the term over that of loads and reactions, after a step. */
static PetscErrorCode FindUnrest(MpmModel model, PetscReal *unrest)
{
  const MpmDiscretization *disc  = &model->disc;
  const PetscInt           count = disc->space->local * disc->block, owned = disc->space->owned * disc->block;
  PetscReal               *force, *load, squares[2] = {0., 0.};
  PetscInt                 failed = 0;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc2(count, &force, count, &load));
  PetscCall(MpmTermInertia.residual(disc->context.inertia, disc->sum, disc->nodal.u, force, &failed));
  MpmConstraintsGather(disc->constraints, disc->space, force);
  PetscCall(MpmSpaceAddToOwners(disc->space, disc->block, force));
  PetscCall(PetscArraycpy(load, disc->nodal.force, count));
  MpmConstraintsGather(disc->constraints, disc->space, load);
  PetscCall(MpmSpaceAddToOwners(disc->space, disc->block, load));
  for (PetscInt k = 0; k < owned; k++) {
    if (MpmConstraintsFree(disc->constraints, k)) squares[0] += PetscSqr(force[k]);
    squares[1] += PetscSqr(MpmConstraintsFree(disc->constraints, k) ? load[k] : disc->nodal.residual[k]);
  }
  PetscCall(PetscFree2(force, load));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, squares, 2, MPIU_REAL, MPIU_SUM, model->comm));
  *unrest = squares[1] > 0. ? PetscSqrtReal(squares[0] / squares[1]) : 0.;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The state of the step's start again. */
static PetscErrorCode GoBack(MpmModel model, MpmStateKept *start)
{
  PetscFunctionBeginUser;
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, model->disc.points));
  PetscCall(MpmStateReturn(&model->state, start));
  PetscCall(MpmReductionApply(model, model->state.time));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Steps to `next` until one leaves the ground at rest; those that fail are taken with a shorter tau. */
static PetscErrorCode Move(MpmModel model, PetscReal next, PetscReal dt, PetscReal crossing, MpmOutcome *outcome)
{
  MpmSettling *settling = &model->state.scheme.settling;
  PetscReal    unrest = 1., most = PETSC_MAX_REAL;
  PetscInt     held = 0;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < STEPS; k++) {
    PetscCall(MpmStepArrange(model, outcome));
    if (outcome->code) PetscFunctionReturn(PETSC_SUCCESS);
    PetscCall(MpmStep(model, next, dt, PETSC_FALSE, outcome));
    settling->newton += model->solver.iterations.newton;
    settling->steps++;
    if (outcome->code && (model->state.safety.beyond > 0. || settling->tau < SHORTEST * crossing))
      PetscFunctionReturn(PETSC_SUCCESS);
    if (outcome->code) {
      settling->tau /= LONGER;
      most = settling->tau;
      held = 0;
      continue;
    }
    model->state.time = next;
    PetscCall(FindUnrest(model, &unrest));
    PetscCall(PetscInfo(model->solver.snes, "settling with tau %g s: %d iterations, %g of the loads out of balance\n",
                        (double)settling->tau, (int)model->solver.iterations.newton, (double)unrest));
    if (unrest <= REST) PetscFunctionReturn(PETSC_SUCCESS);
    if (settling->tau < most) settling->tau *= LONGER;
    else if (++held == HELD) {
      most = PETSC_MAX_REAL;
      held = 0;
    }
  }
  PetscCall(MpmOutcomeFail(outcome, MPM_OUTCOME_NO_SOLUTION,
                           "the ground has not come to rest in %d steps, %.2g of the loads are out of balance", STEPS,
                           (double)unrest));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSettleAddRows(MpmModel model)
{
  MpmSettling *settling = &model->state.scheme.settling;
  const MpmRow rows[]   = {
      {"settles", MPM_ROW_BOOL, MPM_ROW_RUN, &settling->needed, 0, 0},
      {"settling_time", MPM_ROW_REAL, MPM_ROW_RUN, &settling->tau, 0, 0},
  };

  PetscFunctionBeginUser;
  PetscCall(MpmRowsAdd(model->state.rows, NULL, PETSC_STATIC_ARRAY_LENGTH(rows), rows));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSettle(MpmModel model, PetscReal next, PetscReal dt, MpmOutcome *outcome)
{
  MpmSettling    *settling = &model->state.scheme.settling;
  const PetscBool predict  = model->state.predict;
  PetscReal       crossing;
  MpmStateKept    start;

  PetscFunctionBeginUser;
  PetscCall(FindCrossing(model, &crossing));
  PetscCall(MpmStateCopy(&model->state, &start));
  MpmOutcomeClear(outcome);
  settling->on     = PETSC_TRUE;
  settling->newton = 0;
  if (!(settling->tau > SHORTEST * crossing)) settling->tau = crossing;
  model->state.predict = PETSC_FALSE;
  PetscCall(Move(model, next, dt, crossing, outcome));
  model->state.predict = predict;
  settling->on         = PETSC_FALSE;
  PetscCall(MpmSettleSet(model));
  if (outcome->code) PetscCall(GoBack(model, &start));
  else PetscCall(MpmStateForget(&start));
  model->solver.iterations.newton = settling->newton;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  The scheme `second`: steps of two sub-steps for physics with a rate (SDIRK2).

    s_1 - s_n = gamma dt k(t_n + gamma dt) ,     s_{n+1} - s_n = (1 - gamma) dt k(t_n + gamma dt) + gamma dt k(t_{n+1})

  with gamma = 1 - 1/sqrt(2), s the storage of the physics, k its inflow, and the momentum balance at the time of each
  sub-step. Of order 2 with steps of any lengths, L-stable, and stiffly accurate: the solution at the step's end obeys
  all equations of that time, so that a sudden load leaves no trace in them.

  Source: Alexander (1977), SIAM J. Numer. Anal. 14, 1006-1021, doi:10.1137/0714068.

  Both sub-steps start from one state of the points on one grid. The first is a step of length gamma dt by itself, so
  that at the nodes gamma dt k_1 = s_1 - s_n, and the second may take

    s_{n+1} - s_n - theta (s_1 - s_n) = gamma dt k(t_{n+1}) ,     theta = (1 - gamma)/gamma

  which needs of the first only s_1 at the points (MpmKernelStage). Only the second becomes the state; history goes from
  the step's start to its end at once. The flow through constrained nodes is theta times the first sub-step's and the
  second's.
*/
#include "point/layout.h"
#include "particles/particles.h"
#include "space/sum.h"
#include "bc/bc.h"
#include "bc/body_motion.h"
#include "assembly/terms.h"
#include "problem/discretization.h"
#include "query/model.h"
#include "step/step.h"
#include "integrators/integrators.h"
#include "integrators/sdirk.h"
#include "integrators/time_error.h"

#define GAMMA MPM_SDIRK_GAMMA
#define THETA MPM_SDIRK_THETA

PetscErrorCode MpmSdirkDestroy(MpmSdirk **sdirk)
{
  PetscFunctionBeginUser;
  if (!*sdirk) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscFree4((*sdirk)->F, (*sdirk)->value, (*sdirk)->deviation, (*sdirk)->stage));
  PetscCall(PetscFree((*sdirk)->reaction));
  PetscCall(PetscFree((*sdirk)->first));
  PetscCall(PetscFree(*sdirk));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The sums over points are those of the second sub-step, after the first; NULL: of the first. */
static void SetFirst(MpmModel model, const MpmKernelStage *first)
{
  MpmSumStep step = model->disc.sum->step;

  step.first = first;
  MpmDiscretizationSetStep(&model->disc, &step);
}

static PetscErrorCode Begin(MpmModel model, PetscReal time, PetscReal dt, PetscBool again, MpmOutcome *outcome)
{
  MpmSdirk *sdirk;

  PetscFunctionBeginUser;
  if (!model->state.scheme.sdirk) PetscCall(PetscNew(&model->state.scheme.sdirk));
  sdirk       = model->state.scheme.sdirk;
  sdirk->time = time;
  sdirk->dt   = dt;

  SetFirst(model, NULL);
  PetscCall(MpmStepPrepare(model, model->state.time + GAMMA * dt, GAMMA * dt, again, outcome));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscInt ReactionCount(const MpmModel model)
{
  return (model->scene.bcs->count + model->scene.motions->count) * model->disc.block;
}

/* Data of the first sub-step for the second. */
static PetscErrorCode KeepFirst(MpmModel model)
{
  const MpmLayout *layout = model->disc.layout;
  const PetscInt   size   = model->state.particles->F_size;
  PetscInt         count;
  MpmSdirk        *sdirk = model->state.scheme.sdirk;

  PetscFunctionBeginUser;
  PetscCall(DMSwarmGetLocalSize(model->state.particles->swarm, &count));
  PetscCall(MpmStepFindTrial(model));
  PetscCall(MpmStepFindReactions(model));
  PetscCall(PetscFree4(sdirk->F, sdirk->value, sdirk->deviation, sdirk->stage));
  PetscCall(PetscMalloc4((count * size), &sdirk->F, (count * layout->rate.count), &sdirk->value,
                         (count * layout->deviation.count), &sdirk->deviation, (count + 1), &sdirk->stage));
  PetscCall(PetscFree(sdirk->reaction));
  PetscCall(PetscMalloc1(ReactionCount(model), &sdirk->reaction));
  PetscCall(PetscArraycpy(sdirk->F, model->disc.trial->F, count * size));
  PetscCall(PetscArraycpy(sdirk->reaction, model->disc.nodal.reaction, ReactionCount(model)));
  PetscCall(MpmRatesAtPoints(model->disc.sum, model->disc.nodal.u, sdirk->value));
  PetscCall(MpmDeviationsAtPoints(model->disc.sum, model->disc.nodal.u, sdirk->deviation));
  for (PetscInt p = 0; p < count; p++)
    sdirk->stage[p] = (MpmKernelStage){.F         = &sdirk->F[p * size],
                                       .value     = &sdirk->value[p * layout->rate.count],
                                       .deviation = &sdirk->deviation[p * layout->deviation.count],
                                       .theta     = THETA,
                                       .span      = sdirk->dt};
  PetscCall(MpmTermsKeepStage(model->disc.terms, model->disc.sum, model->disc.nodal.u, THETA));
  model->disc.trial->of.id = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Start of Newton's method in the second sub-step: the result of the first, with increments in proportion where that
   is nearer. */
static PetscErrorCode StartSecond(MpmModel model, Vec first)
{
  const PetscInt bs = model->disc.block;
  PetscInt       n;
  PetscReal      norm = PETSC_INFINITY;
  Vec            start;

  PetscFunctionBeginUser;
  PetscCall(MpmStepFindReference(model));
  PetscCall(VecGetLocalSize(first, &n));
  PetscCall(VecDuplicate(first, &start));
  for (PetscInt k = 0; k < 2; k++) {
    PetscScalar *x;
    PetscReal    of;

    if (k) {
      PetscCall(VecGetArray(first, &x));
      for (PetscInt i = 0; i < n; i++)
        if (model->disc.layout->component[i % bs].increment) x[i] /= GAMMA;
      PetscCall(VecRestoreArray(first, &x));
    }
    PetscCall(VecGetArray(first, &x));
    MpmConstraintsPrescribe(model->disc.constraints, n, x);
    PetscCall(VecRestoreArray(first, &x));
    PetscCall(VecCopy(model->solver.x, start));
    PetscCall(VecCopy(first, model->solver.x));
    PetscCall(SNESComputeFunction(model->solver.snes, model->solver.x, model->solver.f));
    PetscCall(VecNorm(model->solver.f, NORM_2, &of));
    if (!(of < norm)) PetscCall(VecCopy(start, model->solver.x));
    else norm = of;
  }
  PetscCall(VecDestroy(&start));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode BeginSecond(MpmModel model, MpmOutcome *outcome)
{
  MpmSdirk  *sdirk = model->state.scheme.sdirk;
  MpmSumStep step;

  PetscFunctionBeginUser;
  PetscCall(KeepFirst(model));
  SetFirst(model, sdirk->stage);
  PetscCall(MpmStepPrepare(model, sdirk->time, GAMMA * sdirk->dt, PETSC_TRUE, outcome));
  outcome->retryable = PETSC_TRUE;
  step               = model->disc.sum->step;
  step.span          = sdirk->dt;
  MpmDiscretizationSetStep(&model->disc, &step);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The solution of the first sub-step is kept for the derivatives of a run. */
static PetscErrorCode KeepSolution(MpmModel model, Vec first)
{
  MpmSdirk          *sdirk = model->state.scheme.sdirk;
  const PetscScalar *x;
  PetscInt           n;

  PetscFunctionBeginUser;
  if (!model->gradient) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecGetLocalSize(first, &n));
  PetscCall(PetscFree(sdirk->first));
  PetscCall(PetscMalloc1((n + 1), &sdirk->first));
  PetscCall(VecGetArrayRead(first, &x));
  PetscCall(PetscArraycpy(sdirk->first, x, n));
  PetscCall(VecRestoreArrayRead(first, &x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SolveStages(MpmModel model, MpmOutcome *outcome)
{
  PetscInt newton, linear;
  Vec      first;

  PetscFunctionBeginUser;
  PetscCall(MpmIntegratorQuasistatic.solve(model, outcome));
  if (outcome->code) PetscFunctionReturn(PETSC_SUCCESS);
  newton = model->solver.iterations.newton;
  linear = model->solver.iterations.linear;
  PetscCall(VecDuplicate(model->solver.x, &first));
  PetscCall(VecCopy(model->solver.x, first));
  PetscCall(KeepSolution(model, first));
  PetscCall(BeginSecond(model, outcome));
  if (!outcome->code) {
    PetscCall(StartSecond(model, first));
    PetscCall(MpmIntegratorQuasistatic.solve(model, outcome));
  }
  PetscCall(VecDestroy(&first));
  model->solver.iterations.newton =
    PetscMax(model->solver.iterations.newton, newton); /* of a solution; all of them count in the totals */
  model->solver.iterations.linear += linear;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Of the flow, the first sub-step has its share in the step; forces are those of the step's end. */
static PetscErrorCode Accept(MpmModel model)
{
  const MpmLayout *layout = model->disc.layout;

  PetscFunctionBeginUser;
  PetscCall(MpmIntegratorQuasistatic.accept(model));
  if (model->state.scheme.error.accepted > 0.) model->state.scheme.error.largest = model->state.scheme.sdirk->change;
  for (PetscInt k = 0; k < ReactionCount(model); k++)
    if (!layout->component[k % model->disc.block].increment)
      model->disc.nodal.reaction[k] += THETA * model->state.scheme.sdirk->reaction[k];
  SetFirst(model, NULL);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode RollBack(MpmModel model)
{
  PetscFunctionBeginUser;
  SetFirst(model, NULL);
  PetscCall(MpmIntegratorQuasistatic.roll_back(model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Predict(MpmModel model)
{
  return MpmIntegratorQuasistatic.predict(model);
}

const MpmIntegrator MpmIntegratorSdirk = {.name      = "second",
                                          .begin     = Begin,
                                          .predict   = Predict,
                                          .error     = MpmTimeError,
                                          .solve     = SolveStages,
                                          .second    = BeginSecond,
                                          .accept    = Accept,
                                          .roll_back = RollBack};

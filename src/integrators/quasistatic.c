/*
  A step without inertia: Newton's method from its start, and the commit.
*/
#include "particles/particles.h"
#include "space/space.h"
#include "space/sum.h"
#include "assembly/terms.h"
#include "volume/inertia.h"
#include "loads/body_surface.h"
#include "problem/section.h"
#include "query/model.h"
#include "step/energy.h"
#include "step/step.h"
#include "integrators/integrators.h"

/* The converged step becomes the state. */
static PetscErrorCode Commit(MpmModel model)
{
  PetscLogDouble since;

  PetscFunctionBeginUser;
  PetscCall(MpmMonitorBegin(&model->monitor, MPM_TIME_TRANSFER, &since));
  PetscCall(MpmStepFindTrial(model));
  if (model->disc.sections)
    PetscCall(MpmSectionsEvaluate(model->disc.sections, model->disc.constraints, model->disc.sum, model->disc.nodal.u,
                                  model->state.particles));
  PetscCall(MpmSurfaceFlowCommit(model->disc.context.surfaces, model->disc.sum, model->disc.nodal.u));
  PetscCall(MpmCommitLocal(model->disc.sum, model->disc.trial, model->disc.nodal.u));
  model->disc.trial->of.id = 0;
  PetscCall(MpmTermsCommit(model->disc.terms, model->disc.sum, model->disc.nodal.u, model->state.particles));
  PetscCall(MpmStepFindReactions(model));
  MpmStepClip(model);
  PetscCall(MpmMonitorEnd(&model->monitor, MPM_TIME_TRANSFER, since));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The work of a step without inertia, in scenes that keep account of it. */
static PetscErrorCode AddWork(MpmModel model)
{
  const PetscInt count = model->disc.space->local * model->disc.block;
  PetscReal     *loads;

  PetscFunctionBeginUser;
  if (!model->disc.context.inertia->dynamic || model->state.scheme.integrator != &MpmIntegratorQuasistatic)
    PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmStepFindTrial(model));
  PetscCall(PetscMalloc1(count, &loads));
  PetscCall(PetscArraycpy(loads, model->disc.nodal.force, count));
  PetscCall(MpmStepMeanLoads(model, model->state.time + model->disc.sum->step.span, 0., loads));
  PetscCall(MpmEnergyAdd(model, &(MpmStepWork){.u        = model->disc.nodal.u,
                                               .loads    = loads,
                                               .supports = model->disc.nodal.residual,
                                               .local    = model->disc.space->local,
                                               .owned    = model->disc.space->owned}));
  PetscCall(PetscFree(loads));
  model->disc.trial->of.id = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Supports that move do their work by the mean of their forces over the step. Those of the balance are of a time further
  on, by (1/2 - alpha_f) of the step, and a condition's force went there from its value a step before.
*/
static void CorrectSupports(MpmModel model)
{
  const PetscReal       part = 0.5 - model->state.scheme.load_at_start;
  const MpmPrescription step = MpmStepPrescription(model, model->state.time + model->disc.sum->step.span);

  if (!model->disc.context.inertia->dynamic) return;
  for (PetscInt b = 0; b < model->scene.bcs->count; b++) {
    const MpmCondition *bc       = &model->scene.bcs->at[b];
    const PetscReal    *reaction = &model->disc.nodal.reaction[b * model->disc.block];
    PetscReal          *before   = model->state.acting.bcs[b].force, factor;

    if (!model->state.acting.bcs[b].active || bc->absorbing) continue;
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
  const PetscReal last = model->state.dt.last;

  PetscFunctionBeginUser;
  PetscCall(AddWork(model));
  PetscCall(Commit(model));
  CorrectSupports(model);
  model->state.scheme.put_back = PETSC_FALSE;
  model->state.dt.last         = model->state.dt.before < 0. ? 0. : model->disc.sum->step.span;
  model->state.dt.before       = last;
  model->disc.nodal.committed  = PETSC_TRUE;
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, model->disc.points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The points are untouched until a step is accepted: only the trial is forgotten. */
static PetscErrorCode RollBackStep(MpmModel model)
{
  PetscFunctionBeginUser;
  model->disc.trial->of.id = 0;
  PetscCall(VecZeroEntries(model->solver.x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSettleSet(MpmModel model)
{
  MpmInertia *inertia = model->disc.context.inertia;

  PetscFunctionBeginUser;
  if (!model->state.scheme.settling.on) {
    inertia->active = PETSC_FALSE;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(MpmInertiaResize(inertia, model->disc.space));
  PetscCall(MpmMassMatrixSetUp(&inertia->matrix, model->disc.sum));
  inertia->consistent = inertia->active = PETSC_TRUE;
  inertia->factor                       = 1. / PetscSqr(model->state.scheme.settling.tau);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Begin(MpmModel model, PetscReal time, PetscReal dt, PetscBool again, MpmOutcome *outcome)
{
  PetscFunctionBeginUser;
  PetscCall(MpmStepPrepare(model, time, dt, again, outcome));
  if (!outcome->code) PetscCall(MpmSettleSet(model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

const MpmIntegrator MpmIntegratorQuasistatic = {.name      = "quasistatic",
                                                .begin     = Begin,
                                                .predict   = MpmStepPredict,
                                                .solve     = MpmStepSolve,
                                                .accept    = AcceptStep,
                                                .roll_back = RollBackStep};

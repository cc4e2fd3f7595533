/*
  Observation of a flow over terrain, state by state.
*/
#include "space/space.h"
#include "volume/inertia.h"
#include "query/query.h"
#include "integrators/dynamics.h"
#include "runout/runout_impl.h"

/* Ends the stage where the kinetic energy has fallen below its share of the largest. */
static PetscErrorCode LookForRest(MpmModel model)
{
  const PetscReal  share = model->scene.stages.at[model->state.stage].time.motion.rest;
  const PetscReal *v = model->state.scheme.dynamics->v_new, *mass = model->disc.context.inertia->mass;
  MpmRunout       *runout = model->runout;
  PetscReal        energy = 0.;

  PetscFunctionBeginUser;
  if (!(share > 0.)) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt i = 0; i < model->disc.space->owned; i++)
    energy += 0.5 * mass[i] * (PetscSqr(v[i * model->disc.block]) + PetscSqr(v[i * model->disc.block + 1]));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &energy, 1, MPIU_REAL, MPIU_SUM, model->comm));
  runout->energy = PetscMax(runout->energy, energy);
  if (!(energy < share * runout->energy) || model->state.time >= model->state.period.end)
    PetscFunctionReturn(PETSC_SUCCESS);
  runout->rest   = model->state.time;
  runout->energy = 0.;
  MpmStageEndHere(model);
  PetscCall(MpmMonitorNote(&model->monitor, "at rest: the kinetic energy is below %g of its largest", (double)share));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A state with this number, of the run's time, that lasts for dt. */
static PetscErrorCode Observe(MpmModel model, PetscInt step, PetscReal time, PetscReal dt)
{
  MpmRunout *runout = model->runout;

  PetscFunctionBeginUser;
  if (step <= runout->seen || !model->disc.nodal.committed) PetscFunctionReturn(PETSC_SUCCESS);
  runout->seen = step;
  if (runout->peaks.largest) PetscCall(MpmPeaksObserve(model, time));
  if (runout->gauges.count) PetscCall(MpmGaugesObserve(model, dt));
  if (runout->every && step % runout->every == 0) {
    PetscLogDouble since;

    PetscCall(MpmMonitorBegin(&model->monitor, MPM_TIME_OUTPUT, &since));
    PetscCall(MpmRunoutWriteState(model));
    PetscCall(MpmMonitorEnd(&model->monitor, MPM_TIME_OUTPUT, since));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmRunoutObserve(MpmModel model, PetscReal dt)
{
  PetscFunctionBeginUser;
  if (!model->runout) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Observe(model, model->state.step - 1, model->state.time - dt, dt));
  PetscCall(LookForRest(model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmRunoutFinish(MpmModel model)
{
  PetscFunctionBeginUser;
  if (model->runout) PetscCall(Observe(model, model->state.step, model->state.time, 0.));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmRunoutWrite(MpmModel model)
{
  MpmRunout     *runout = model->runout;
  PetscLogDouble since;

  PetscFunctionBeginUser;
  if (!runout || runout->seen < 0 || !model->disc.nodal.committed) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmMonitorBegin(&model->monitor, MPM_TIME_OUTPUT, &since));
  if (runout->every && runout->seen % runout->every) PetscCall(MpmRunoutWriteState(model));
  if (runout->maps) PetscCall(MpmRunoutWritePeaks(model));
  PetscCall(MpmGaugesWrite(model));
  PetscCall(MpmMonitorEnd(&model->monitor, MPM_TIME_OUTPUT, since));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmRunoutDestroy(MpmModel model)
{
  PetscFunctionBeginUser;
  if (!model->runout) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmPeaksDestroy(&model->runout->peaks));
  PetscCall(MpmGaugesDestroy(&model->runout->gauges));
  PetscCall(PetscFree(model->runout));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  A relaxation in place of a quasi-static step that gave up.

    time: {rescue: relaxation}

  The integrator changes meanwhile: explicit steps, damped by the stage's block `relaxation`, from the last accepted
  state to the end of the nominal step, dt_nominal long or the remainder of it. The run's time, by which loads,
  supports, boundaries and strengths go, gets there in the time in which a wave crosses the material four times, and
  then stands still; the motion has a clock of its own. Once its criteria hold (relaxation.c) the points are left at
  rest, and quasi-static steps go on.

  For the results all of it is one step. Checkpoints may stand within, signals and wall time permitting: points have
  their velocities there, and the numbers of MpmRescuing.

  Order of calls: Begin(); then for each step of the motion the integrator's, to NextTime(), and Over().
*/
#include "grid/grid.h"
#include "particles/particles.h"
#include "space/sum.h"
#include "query/model.h"
#include "query/query.h"
#include "integrators/dynamics.h"
#include "integrators/integrators.h"
#include "integrators/relaxation.h"
#include "schedule/rescue.h"
#include "schedule/schedule.h"

#define RAMP 4. /* ways of a wave through the material: the period of a bar */

PetscBool MpmRescueServes(const MpmModel model)
{
  return (PetscBool)(model->scene.stages.at[model->state.stage].time.rescue && MpmCouldRelax(model));
}

/* Extents of the material over cells, the largest of all axes. */
static PetscErrorCode CountCells(MpmModel model, PetscReal *cells)
{
  PetscReal lower[MPM_MAX_DIM], upper[MPM_MAX_DIM];

  PetscFunctionBeginUser;
  PetscCall(MpmParticlesGetExtents(model->state.particles, model->disc.points, lower, upper));
  *cells = 1.;
  for (PetscInt a = 0; a < model->disc.dim; a++)
    *cells = PetscMax(*cells, (upper[a] - lower[a]) / model->disc.grid->h[a]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MpmRescueResume(MpmModel model)
{
  if (!model->state.scheme.rescuing.on) return;
  model->state.scheme.integrator = &MpmIntegratorExplicit;
  MpmDynamicsSetStage(model);
}

PetscErrorCode MpmRescueBegin(MpmModel model, const char *why)
{
  const MpmRelaxing before   = model->state.relaxing;
  MpmRescuing      *rescuing = &model->state.scheme.rescuing;
  PetscReal         dt;

  PetscFunctionBeginUser;
  *rescuing             = (MpmRescuing){.on    = PETSC_TRUE,
                                        .start = model->state.time,
                                        .end   = MpmNextTime(model, model->state.dt.nominal, &dt),
                                        .work  = model->state.scheme.energy.external,
                                        .first = before.first,
                                        .since = before.since,
                                        .count = rescuing->count};
  model->state.relaxing = (MpmRelaxing){.first = -1., .since = -1., .ended = before.ended};
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, model->disc.points));
  PetscCall(MpmParticlesRest(model->state.particles));
  MpmRescueResume(model);
  PetscCall(MpmMonitorNote(&model->monitor, "%s; a relaxation goes on to time %.6g", why, (double)rescuing->end));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmRescueNextTime(MpmModel model, PetscReal *time)
{
  const MpmMotionControl *motion   = MpmModelMotion(model);
  MpmRescuing            *rescuing = &model->state.scheme.rescuing;
  PetscReal               part;

  PetscFunctionBeginUser;
  if (!(rescuing->ramp > 0.)) {
    PetscCall(CountCells(model, &rescuing->ramp));
    rescuing->ramp *= RAMP * model->state.dt.wanted / motion->cfl;
  }
  part  = (rescuing->clock + model->state.dt.wanted) / rescuing->ramp;
  *time = part < 1. ? rescuing->start + part * (rescuing->end - rescuing->start) : rescuing->end;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The quasi-static steps go on. */
static PetscErrorCode Finish(MpmModel model)
{
  MpmRescuing *rescuing = &model->state.scheme.rescuing;
  MpmRelaxing *relaxing = &model->state.relaxing;

  PetscFunctionBeginUser;
  PetscCall(MpmMonitorNote(&model->monitor,
                           "rescued by relaxation at time %.6g: at rest after %" PetscInt_FMT
                           " steps, %.4g s of motion "
                           "with %" PetscInt_FMT " reset%s; K_F %.3g, K_E %.3g",
                           (double)rescuing->end, rescuing->steps, (double)rescuing->clock, relaxing->resets,
                           relaxing->resets == 1 ? "" : "s", (double)relaxing->force, (double)relaxing->energy));
  rescuing->on = PETSC_FALSE;
  rescuing->count++;
  relaxing->first                   = rescuing->first;
  relaxing->since                   = rescuing->since;
  model->state.scheme.integrator    = &MpmIntegratorQuasistatic;
  model->state.scheme.load_at_start = 0.;
  MpmDynamicsSetStage(model);
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, model->disc.points));
  PetscCall(MpmParticlesRest(model->state.particles));
  model->state.dt.wanted = model->state.dt.nominal;
  model->state.dt.before = -1.;
  model->state.step++;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmRescueAddRows(MpmModel model)
{
  MpmRescuing *rescuing = &model->state.scheme.rescuing;
  const MpmRow rows[]   = {
      {"rescue_on", MPM_ROW_BOOL, MPM_ROW_RUN, &rescuing->on, 0, 0},
      {"rescue_start", MPM_ROW_REAL, MPM_ROW_RUN, &rescuing->start, 0, 0},
      {"rescue_end", MPM_ROW_REAL, MPM_ROW_RUN, &rescuing->end, 0, 0},
      {"rescue_clock", MPM_ROW_REAL, MPM_ROW_RUN, &rescuing->clock, 0, 0},
      {"rescue_ramp", MPM_ROW_REAL, MPM_ROW_RUN, &rescuing->ramp, 0, 0},
      {"rescue_work", MPM_ROW_REAL, MPM_ROW_RUN, &rescuing->work, 0, 0},
      {"rescue_first", MPM_ROW_REAL, MPM_ROW_RUN, &rescuing->first, 0, 0},
      {"rescue_since", MPM_ROW_REAL, MPM_ROW_RUN, &rescuing->since, 0, 0},
      {"rescue_steps", MPM_ROW_INT, MPM_ROW_RUN, &rescuing->steps, 0, 0},
      {"rescues", MPM_ROW_INT, MPM_ROW_RUN, &rescuing->count, 0, 0},
  };

  PetscFunctionBeginUser;
  PetscCall(MpmRowsAdd(model->state.rows, NULL, PETSC_STATIC_ARRAY_LENGTH(rows), rows));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmRescueOver(MpmModel model, PetscReal *dt, MpmOutcome *outcome)
{
  MpmRescuing       *rescuing = &model->state.scheme.rescuing;
  const MpmRelaxing *relaxing = &model->state.relaxing;
  const PetscInt     most     = model->scene.stages.at[model->state.stage].relaxation.steps;

  PetscFunctionBeginUser;
  rescuing->clock += model->disc.sum->step.dt;
  rescuing->steps++;
  if (relaxing->rests) {
    *dt = rescuing->end - rescuing->start;
    PetscCall(Finish(model));
  } else if (rescuing->steps >= most) {
    PetscCall(MpmOutcomeFail(outcome, MPM_OUTCOME_NO_SOLUTION,
                             "the relaxation that goes on to time %.6g has not come to rest in %" PetscInt_FMT
                             " steps: K_F is %.3g and K_E %.3g, with a tolerance of %g",
                             (double)rescuing->end, rescuing->steps, (double)relaxing->force, (double)relaxing->energy,
                             (double)model->scene.stages.at[model->state.stage].relaxation.tolerance));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

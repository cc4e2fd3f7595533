/*
  Times and lengths of steps.
*/
#include "query/model.h"
#include "integrators/time_error.h"
#include "schedule/schedule.h"

/* Relative rounding errors, in units of the machine's, that are taken out of times. */
#define ROUNDING 4
/* Relative distance of times that are equal. */
#define SAME_TIME 1e-12

/*
  A decimal number within the rounding errors of a sum of steps. A time is then independent of the number of steps that
  led to it, and of whether a run ends there or passes it.
*/
PetscReal MpmTimeRound(PetscReal time)
{
  char      text[32];
  PetscReal decimal;

  (void)snprintf(text, sizeof(text), "%.12e", (double)time);
  decimal = (PetscReal)strtod(text, NULL);
  return PetscAbsReal(decimal - time) <= ROUNDING * PETSC_MACHINE_EPSILON * PetscAbsReal(time) ? decimal : time;
}

/* The end of the first given step behind the present time. */
static PetscReal GivenTime(const MpmModel model)
{
  const MpmGivenSteps *given = &model->scene.stages.given;
  PetscReal            next;
  PetscInt             first = 0, last = given->count - 1;

  while (first < last) {
    const PetscInt middle = (first + last) / 2;

    if (given->time[middle] > model->state.time * (1. + SAME_TIME)) last = middle;
    else first = middle + 1;
  }
  next = given->time[first];
  return PetscAbsReal(next - model->state.period.end) <= SAME_TIME * next ? model->state.period.end : next;
}

PetscReal MpmNextTime(MpmModel model, PetscReal dt, PetscReal *step)
{
  const PetscReal small  = 1e-9 * model->state.dt.nominal;
  PetscReal       target = model->state.period.end, next;

  if (model->scene.stages.given.count) {
    next  = GivenTime(model);
    *step = next - model->state.time;
    return next;
  }
  if (!model->state.dt.adaptive) {
    target = MpmTimeRound(
      model->state.period.start +
      model->state.dt.nominal *
        PetscFloorReal((model->state.time - model->state.period.start + small) / model->state.dt.nominal + 1.));
    if (target > model->state.period.end - small) target = model->state.period.end;
  }
  next  = MpmTimeRound(model->state.time + dt);
  next  = next > target - PetscMax(small, 1e-3 * dt) ? target : next;
  *step = next - model->state.time;
  return next;
}

#define EASY 6 /* iterations */

PetscReal MpmNextLength(MpmModel model, PetscReal dt, PetscReal wanted)
{
  if (!model->state.dt.adaptive) return PetscMin(wanted * model->state.dt.growth, model->state.dt.nominal);
  if (dt < 0.99 * wanted) return wanted; /* the end of the run cut it short */
  if (model->solver.iterations.newton <= EASY) {
    const PetscReal factor = PetscMin(model->state.dt.growth, MpmTimeErrorFactor(model));

    return PetscMax(PetscMin(MpmTimeErrorLength(model, wanted * factor), model->state.dt.most), model->state.dt.least);
  }
  return wanted;
}

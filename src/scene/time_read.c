/*
  Options of time: how a scene's and its stages' time is cut into steps.
*/
#include "options/options.h"
#include "point/layout.h"
#include "point/material.h"
#include "rigid/rigid.h"
#include "grid/shape.h"
#include "query/model.h"
#include "scene/integrator_read.h"
#include "scene/time_read.h"

#define MOST_STEPS    1e9
#define SHORTEST_STEP 1e-12 /* of the run's time */

/* Refuses more steps than can be counted, and steps that are lost in rounding. */
static PetscErrorCode CheckSteps(const MpmOptions *block, PetscReal end, PetscReal step, PetscReal step_min)
{
  PetscFunctionBeginUser;
  if (MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  MpmCheckInput(end < MOST_STEPS * step, "-%sstep %g: -%send, %g, must not be more than %g steps away", block->prefix,
                (double)step, block->prefix, (double)end, MOST_STEPS);
  MpmCheckInput(step_min >= SHORTEST_STEP * end,
                "-%sstep_min %g: must be at least %g of -%send, %g: shorter steps are lost in rounding", block->prefix,
                (double)step_min, SHORTEST_STEP, block->prefix, (double)end);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  The length of a step, optional for explicit stages, which do not take that of a stage which solves either. `ratio` is
  the shortest over it.
*/
static PetscErrorCode ReadStep(const MpmOptions *block, PetscBool solved, MpmTimeControl *control, PetscReal ratio)
{
  const PetscBool explicit = (PetscBool)(control->motion.type == MPM_EXPLICIT);

  PetscFunctionBeginUser;
  if (explicit && solved) control->step = 0.;
  PetscCall(MpmOptionsReal(block, "step", "s", "length of a step; explicit: by default as long as cfl allows",
                           MPM_RANGE_POSITIVE, explicit || control->step > 0. ? MPM_OPTIONAL : MPM_REQUIRED,
                           &control->step, NULL));
  control->step_min = ratio * control->step;
  if (explicit) control->adaptive = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* `control` holds the defaults on entry; a step of 0 is none. */
PetscErrorCode MpmTimeControlRead(const MpmOptions *options, const char *prefix, MpmTimeControl *control)
{
  const MpmOptions block   = {options->comm, prefix, options->record};
  const PetscReal  ratio   = control->step > 0. ? control->step_min / control->step : 1. / 1024.;
  const PetscBool  solved  = (PetscBool)(control->motion.type != MPM_EXPLICIT);
  PetscReal        longest = 0.;
  PetscBool        given;

  PetscFunctionBeginUser;
  PetscCall(
    MpmOptionsReal(&block, "end", "s", "how long it takes", MPM_RANGE_POSITIVE, MPM_OPTIONAL, &control->end, NULL));
  PetscCall(MpmIntegratorRead(&block, control));
  PetscCall(ReadStep(&block, solved, control, ratio));
  if (control->motion.type == MPM_EXPLICIT && !MpmOptionsHelp()) {
    if (control->step > 0.) PetscCall(CheckSteps(&block, control->end, control->step, control->step_min));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(MpmOptionsReal(&block, "step_max", "s", "longest step when adaptive; by default end/4", MPM_RANGE_POSITIVE,
                           MPM_OPTIONAL, &longest, &given));
  if (given) control->limit = longest;
  if (given && longest > control->step) control->adaptive = PETSC_TRUE;
  PetscCall(MpmOptionsBool(&block, "adaptive",
                           "lengthen easy steps up to step_max; the default is true where error, or a step_max longer "
                           "than the step, is given",
                           &control->adaptive, NULL));
  control->step_max = control->step;
  if (control->adaptive)
    control->step_max =
      given ? longest : PetscMax(control->limit > 0. ? control->limit : control->end / 4., control->step);
  PetscCall(MpmOptionsReal(&block, "step_min", "s", "a step is not cut below this; by default step/1024",
                           MPM_RANGE_POSITIVE, MPM_OPTIONAL, &control->step_min, NULL));
  PetscCall(MpmOptionsReal(&block, "growth", "-", "factor by which a step grows again",
                           ((MpmRange){1., 100., PETSC_FALSE}), MPM_OPTIONAL, &control->growth, NULL));
  PetscCall(CheckSteps(&block, control->end, control->step, control->step_min));
  MpmCheckInput(control->step_min <= control->step || MpmOptionsHelp(), "-%sstep_min %g: must not exceed -%sstep, %g",
                prefix, (double)control->step_min, prefix, (double)control->step);
  MpmCheckInput(!control->adaptive || control->step_max >= control->step || MpmOptionsHelp(),
                "-%sstep_max %g: must not be below -%sstep, %g", prefix, (double)control->step_max, prefix,
                (double)control->step);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  True where steps are predicted from the last. Plastic flow under loads is not: measured, Newton's method then needs
  more iterations, not fewer. Flow driven by a boundary's motion is.
*/
static PetscBool IsForetold(const MpmModel model)
{
  PetscBool history = (PetscBool)!model->disc.layout->motion;

  for (PetscInt m = 0; m < model->scene.materials->count; m++)
    if (model->scene.materials->at[m].state_size) history = PETSC_TRUE;
  for (PetscInt b = 0; history && b < model->scene.boundaries->count && model->scene.boundaries->at; b++)
    if (MpmMotionMoves(&model->scene.boundaries->at[b].motion)) return PETSC_TRUE;
  return (PetscBool)!history;
}

/* The scene's own block. Where all stages have a step of their own, the scene needs none. */
PetscErrorCode MpmSceneTimeRead(MpmModel model, const MpmOptions *options, MpmTimeControl *control)
{
  const MpmOptions block = {options->comm, "mpm_time_", options->record};
  PetscBool        given;

  PetscFunctionBeginUser;
  *control = (MpmTimeControl){.end = 1., .growth = 2.};
  MpmMotionDefaults(&control->motion);
  if (MpmShapeOrder(model->scene.shape.type) > 1) control->motion.transfer.type = MPM_TRANSFER_FLIP;
  PetscCall(MpmOptionsHeading(&block, "Time"));
  PetscCall(MpmOptionsHas(&block, "step", &given));
  if (given || !model->scene.stages.at[0].name || MpmOptionsHelp())
    PetscCall(MpmTimeControlRead(options, "mpm_time_", control));
  else {
    PetscCall(
      MpmOptionsReal(&block, "end", "s", "how long it takes", MPM_RANGE_POSITIVE, MPM_OPTIONAL, &control->end, NULL));
    PetscCall(MpmIntegratorRead(&block, control));
  }
  model->state.predict = IsForetold(model);
  PetscCall(MpmOptionsBool(
    &block, "predict",
    "start each step from the increment extrapolated from the last ones; the default is true where no material has "
    "history, or a boundary moves in a given way",
    &model->state.predict, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

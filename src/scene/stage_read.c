/*
  Reading of stages: options of their blocks, and checks that these are possible.
*/
#include "options/options.h"
#include "geometry/geometry.h"
#include "point/layout.h"
#include "point/material.h"
#include "particles/body.h"
#include "particles/particles.h"
#include "bc/body_motion.h"
#include "query/model.h"
#include "scene/integrator_read.h"
#include "scene/stage_lists.h"
#include "scene/schedule_read.h"
#include "scene/stage_read.h"
#include "scene/time_read.h"

/* ---- ramps by which bodies and materials go ---- */

static PetscErrorCode ReadRemoval(MpmModel model, const MpmOptions *block, MpmStage *stage)
{
  PetscReal least, most;
  PetscBool given, removes = MpmOptionsHelp();
  char      fallback[64], number[MPM_NUMBER_TEXT];

  PetscFunctionBeginUser;
  MpmRealText(PetscMin(stage->time.end, 1.), number);
  PetscCall(PetscSNPrintf(fallback, sizeof(fallback), "0:0,%s:1", number));
  PetscCall(MpmOptionsHas(block, "removal", &given));
  for (PetscInt b = 0; b < model->scene.bodies->count; b++) removes = (PetscBool)(removes || stage->removed[b]);
  MpmCheckInput(!given || removes, "-%sremoval: the stage removes nothing", block->prefix);
  if (MpmOptionsHelp()) {
    char *text;

    PetscCall(MpmOptionsText(block, "removal",
                             "part of the removed bodies that is gone, over the stage's time, time:factor pairs (s:-); "
                             "default without inertia: 0:0,1:1; with inertia, and in geostatic stages: at once",
                             NULL, MPM_OPTIONAL, &text));
    PetscCall(PetscFree(text));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  MpmCheckInput(!given || stage->geostatic.method == MPM_GEOSTATIC_NONE,
                "-%sremoval: a geostatic stage removes bodies at once", block->prefix);
  if (!removes || stage->geostatic.method != MPM_GEOSTATIC_NONE) PetscFunctionReturn(PETSC_SUCCESS);
  if (!given && stage->time.motion.type != MPM_QUASISTATIC) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmRampCreate(block, "removal", fallback, &stage->removal));
  MpmRampBounds(stage->removal, &least, &most);
  MpmCheckInput(least >= 0. && most <= 1., "-%sremoval: factors must be in [0, 1]", block->prefix);
  MpmCheckInput(MpmRampEvaluate(stage->removal, PETSC_MAX_REAL) == 1., "-%sremoval: the last factor must be 1",
                block->prefix);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadChange(const MpmOptions *block, PetscBool changes, MpmStage *stage)
{
  PetscReal least, most;
  PetscBool given;
  char      fallback[64], number[MPM_NUMBER_TEXT];

  PetscFunctionBeginUser;
  if (MpmOptionsHelp()) {
    char *text;

    PetscCall(MpmOptionsText(block, "change",
                             "part of the change of materials that has come, over the stage's time, time:factor pairs "
                             "(s:-); default without inertia: 0:0,1:1; with inertia, and in geostatic stages: at once",
                             NULL, MPM_OPTIONAL, &text));
    PetscCall(PetscFree(text));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(MpmOptionsHas(block, "change", &given));
  MpmCheckInput(!given || changes, "-%schange: the stage changes no material", block->prefix);
  if (stage->geostatic.method != MPM_GEOSTATIC_NONE || stage->time.motion.type != MPM_QUASISTATIC) {
    MpmCheckInput(!given, "-%schange: a stage with inertia, or a geostatic one, changes materials at once",
                  block->prefix);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (!changes) PetscFunctionReturn(PETSC_SUCCESS);
  MpmRealText(PetscMin(stage->time.end, 1.), number);
  PetscCall(PetscSNPrintf(fallback, sizeof(fallback), "0:0,%s:1", number));
  PetscCall(MpmRampCreate(block, "change", fallback, &stage->change));
  MpmRampBounds(stage->change, &least, &most);
  MpmCheckInput(least >= 0. && most <= 1., "-%schange: factors must be in [0, 1]", block->prefix);
  MpmCheckInput(MpmRampEvaluate(stage->change, stage->time.end) == 1., "-%schange: must be 1 at the stage's end, %g s",
                block->prefix, (double)stage->time.end);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- materials ---- */

/* "body:material" pairs. */
static PetscErrorCode ReadMaterials(MpmModel model, const MpmOptions *block, MpmStage *stage)
{
  char    *text, **pair;
  PetscInt count;

  PetscFunctionBeginUser;
  for (PetscInt b = 0; b < model->scene.bodies->count; b++) stage->material[b] = -1;
  PetscCall(MpmOptionsText(block, "materials", "body:material pairs: what bodies are made of from here on", NULL,
                           MPM_OPTIONAL, &text));
  PetscCall(ReadChange(block, (PetscBool)(text != NULL), stage));
  if (!text || MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmTextSplit(text, &count, &pair));
  MpmCheckInput(count > 0, "-%smaterials: the list is empty; body:material pairs are wanted", block->prefix);
  for (PetscInt k = 0; k < count; k++) {
    char    *colon = strchr(pair[k], ':');
    PetscInt body, material;

    MpmCheckInput(colon, "-%smaterials %s: must be body:material pairs, separated by commas", block->prefix, text);
    *colon   = '\0';
    body     = MpmStageFindName(model->scene.bodies->count, model->scene.bodies->names, pair[k]);
    material = MpmStageFindName(model->scene.materials->count, model->scene.materials->names, colon + 1);
    MpmCheckInput(body >= 0, "-%smaterials %s: there is no body %s in -mpm_bodies", block->prefix, text, pair[k]);
    MpmCheckInput(material >= 0, "-%smaterials %s: there is no material %s in -mpm_materials", block->prefix, text,
                  colon + 1);
    MpmCheckInput(stage->material[body] < 0, "-%smaterials %s: body %s stands there twice", block->prefix, text,
                  pair[k]);
    stage->material[body] = material;
    model->scene.materials->at[material].spacing =
      PetscMax(model->scene.materials->at[material].spacing, MpmBodySpacing(model->scene.bodies->at[body]));
  }
  PetscCall(MpmNamesDestroy(count, &pair));
  PetscCall(PetscFree(text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Both ends of the ramp must leave every law parameters that it accepts. */
static PetscErrorCode CheckReduced(MpmModel model, const MpmStage *stage)
{
  PetscReal ends[2];
  char      why[MPM_FAULT_TEXT], factor[MPM_NUMBER_TEXT];

  PetscFunctionBeginUser;
  MpmRampBounds(stage->reduction.ramp, &ends[0], &ends[1]);
  for (PetscInt m = 0; m < model->scene.materials->count; m++) {
    MpmMaterial *material = &model->scene.materials->at[m];

    for (PetscInt k = 0; k < 2; k++) {
      MpmMaterialReduce(material, ends[k]);
      MpmRealText(ends[k], factor);
      MpmCheckInput(!MpmMaterialIsFaulty(material, why), "-mpm_stage_%s_reduction: %s leaves material %s %s",
                    stage->name, factor, material->name, why);
    }
    MpmMaterialReduce(material, 1.);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadReduction(MpmModel model, const MpmOptions *block, MpmStage *stage)
{
  PetscReal least, most;
  PetscBool given, any = PETSC_FALSE;
  char     *text, number[MPM_NUMBER_TEXT];

  PetscFunctionBeginUser;
  stage->reduction.tolerance = 1e-3;
  PetscCall(MpmOptionsHas(block, "reduction", &given));
  if (MpmOptionsHelp()) {
    PetscCall(MpmOptionsText(block, "reduction",
                             "what cohesion, tan(friction) and other strengths are divided by, over the stage's time, "
                             "time:factor pairs (s:-); default: 1",
                             NULL, MPM_OPTIONAL, &text));
    PetscCall(PetscFree(text));
  } else if (!given) PetscFunctionReturn(PETSC_SUCCESS);
  else PetscCall(MpmRampCreate(block, "reduction", NULL, &stage->reduction.ramp));
  PetscCall(
    MpmOptionsReal(block, "reduction_limit", "-",
                   "how far a point has moved in the stage, in heights of the slope, where the reduction is "
                   "taken as the factor of safety; default: the strain by the weight of a layer of that height, "
                   "from 0.001 to 0.01",
                   MPM_RANGE_POSITIVE, MPM_OPTIONAL, &stage->reduction.limit, NULL));
  PetscCall(MpmOptionsReal(block, "reduction_tolerance", "-",
                           "steps without inertia that fail are halved until the factor of safety is known to this "
                           "part",
                           ((MpmRange){0., 1., PETSC_TRUE}), MPM_OPTIONAL, &stage->reduction.tolerance, NULL));
  PetscCall(MpmOptionsBool(block, "reduction_slide",
                           "steps without inertia go on into the slide once the factor of safety is known; otherwise "
                           "the stage ends in the last state that stood",
                           &stage->reduction.slide, NULL));
  if (MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  MpmRampBounds(stage->reduction.ramp, &least, &most);
  MpmRealText(least, number);
  MpmCheckInput(least > 0., "-%sreduction: the factor %s must be > 0", block->prefix, number);
  MpmCheckInput(stage->geostatic.method == MPM_GEOSTATIC_NONE,
                "-%sreduction: a geostatic stage does not reduce strength; one that follows can", block->prefix);
  for (PetscInt m = 0; m < model->scene.materials->count; m++)
    if (MpmMaterialHasStrength(&model->scene.materials->at[m])) any = PETSC_TRUE;
  MpmCheckInput(any, "-%sreduction: no material has a strength that it could reduce", block->prefix);
  PetscCall(CheckReduced(model, stage));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The block of a stage, or without a name that of the scene, whose options are the stages' defaults. */
static PetscErrorCode ReadRelaxation(const MpmOptions *options, const char *name, PetscBool rescue,
                                     MpmRelaxation *relaxation)
{
  char             prefix[256];
  const MpmOptions block = {options->comm, prefix, options->record};

  PetscFunctionBeginUser;
  PetscCall(PetscSNPrintf(prefix, sizeof(prefix), "mpm_%s%s%srelaxation_", name ? "stage_" : "", name ? name : "",
                          name ? "_" : ""));
  PetscCall(MpmRelaxationRead(&block, rescue, relaxation));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A stage that is a relaxation takes explicit steps; by default velocities keep all that the nodes do not change. */
static PetscErrorCode ReadRelaxationStage(const MpmOptions *options, MpmStage *stage, PetscBool on)
{
  PetscFunctionBeginUser;
  PetscCall(ReadRelaxation(options, stage->name, PETSC_FALSE, &stage->relaxation));
  stage->relaxation.on = on;
  if (!on) PetscFunctionReturn(PETSC_SUCCESS);
  if (stage->time.motion.type != MPM_EXPLICIT) stage->time.step = 0.;
  stage->time.motion.type          = MPM_EXPLICIT;
  stage->time.motion.transfer.type = MPM_TRANSFER_FLIP;
  stage->time.motion.transfer.pic  = 0.;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A geostatic stage has ways of its own. */
static PetscErrorCode RefuseRescue(const MpmOptions *options, const char *time_prefix, MpmStage *stage)
{
  const MpmOptions block = {options->comm, time_prefix, options->record};
  PetscBool        given;

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsHas(&block, "rescue", &given));
  MpmCheckInput(!given || !stage->time.rescue || MpmOptionsHelp(), "-%srescue: not in a geostatic stage", time_prefix);
  stage->time.rescue = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Water that leaves at once, or until it has left. */
static PetscErrorCode ReadDrainage(MpmModel model, const MpmOptions *options, MpmStage *stage)
{
  char             prefix[256], until[256];
  const MpmOptions block = {options->comm, prefix, options->record}, end = {options->comm, until, options->record};
  const PetscBool  water = (PetscBool)(MpmPressureComponent(model->disc.layout) >= 0);
  PetscBool        given, wanted;

  PetscFunctionBeginUser;
  PetscCall(PetscSNPrintf(prefix, sizeof(prefix), "mpm_stage_%s_", stage->name));
  PetscCall(PetscSNPrintf(until, sizeof(until), "mpm_stage_%s_until_", stage->name));
  PetscCall(MpmOptionsBool(&block, "drained",
                           "water leaves and enters at once: its pressure is that of the steady flow, without excess",
                           &stage->drained, &given));
  PetscCall(
    MpmOptionsReal(&end, "consolidation", "-",
                   "degree of consolidation at which the stage ends: the part of the largest mean excess pressure "
                   "that has gone",
                   ((MpmRange){0., 1., PETSC_TRUE}), MPM_OPTIONAL, &stage->consolidation, &wanted));
  if (MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  MpmCheckInput(water || !given, "-%sdrained: there is no water in the scene's physics", prefix);
  MpmCheckInput(water || !wanted, "-%sconsolidation: there is no water in the scene's physics", until);
  MpmCheckInput(!wanted || stage->geostatic.method == MPM_GEOSTATIC_NONE,
                "-%sconsolidation: a geostatic stage has no excess pressure", until);
  MpmCheckInput(!wanted || !stage->drained, "-%sconsolidation: the stage is drained and has no excess pressure", until);
  if (stage->drained || wanted) model->solver.definite.symmetric = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadStage(MpmModel model, const MpmOptions *options, const MpmTimeControl *scene, MpmStage *stage)
{
  static const char *const types[] = {"load", "geostatic", "relaxation", NULL};
  char                     prefix[256], time_prefix[256];
  const MpmOptions         block  = {options->comm, prefix, options->record};
  PetscInt                 type   = 0;
  const MpmNameList        bodies = {&model->scene.bodies->count, &model->scene.bodies->names, PETSC_FALSE};
  PetscBool                given;

  PetscFunctionBeginUser;
  PetscCall(PetscSNPrintf(prefix, sizeof(prefix), "mpm_stage_%s_", stage->name));
  PetscCall(PetscSNPrintf(time_prefix, sizeof(time_prefix), "mpm_stage_%s_time_", stage->name));
  PetscCall(MpmOptionsWord(&block, "type",
                           "load: steps in time; geostatic: a state of stress in equilibrium; relaxation: explicit "
                           "steps, damped until all is at rest",
                           types, MPM_OPTIONAL, &type, NULL));
  if (type == 1 || MpmOptionsHelp()) PetscCall(MpmGeostaticRead(model, options, stage->name, &stage->geostatic));
  stage->time = *scene;
  if (type == 1) stage->time.motion.type = MPM_QUASISTATIC;
  if (type == 1 && !(scene->step > 0.)) stage->time.step = stage->time.step_min = 0.1 * scene->end;
  if (type == 2 || MpmOptionsHelp()) PetscCall(ReadRelaxationStage(options, stage, (PetscBool)(type == 2)));
  PetscCall(MpmTimeControlRead(options, time_prefix, &stage->time));
  if (type == 1) PetscCall(RefuseRescue(options, time_prefix, stage));
  if (stage->time.rescue && !MpmOptionsHelp())
    PetscCall(ReadRelaxation(options, stage->name, PETSC_TRUE, &stage->relaxation));
  MpmCheckInput(type != 2 || stage->time.motion.type == MPM_EXPLICIT || MpmOptionsHelp(),
                "-%sintegrator %s: a stage of type relaxation takes explicit steps", time_prefix,
                MpmIntegratorTypes[stage->time.motion.type]);
  PetscCall(MpmStageMarkList(&block, "remove", "bodies that are taken away", bodies, &stage->removed, &given));
  PetscCall(MpmStageMarkList(&block, "bodies", "bodies that join here and were not there before", bodies, &stage->adds,
                             &given));
  PetscCall(ReadRemoval(model, &block, stage));
  PetscCall(ReadMaterials(model, &block, stage));
  PetscCall(ReadReduction(model, &block, stage));
  PetscCall(MpmOptionsBool(&block, "reset_displacement", "displacements start at zero again", &stage->reset, NULL));
  PetscCall(ReadDrainage(model, options, stage));
  PetscCall(MpmGeostaticCheck(model, stage));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The motions of a stage need their bodies. */
static PetscErrorCode CheckMoved(const MpmModel model, const MpmStage *stage, const PetscBool there[])
{
  const MpmBodyMotions *motions = model->scene.motions;

  PetscFunctionBeginUser;
  for (PetscInt m = 0; m < motions->count; m++)
    MpmCheckInput(!stage->motions[m] || there[motions->at[m].body], "-mpm_motion_%s_body %s: the body is not there%s%s",
                  motions->names[m], model->scene.bodies->names[motions->at[m].body], stage->name ? " in stage " : "",
                  stage->name ? stage->name : "");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Two stages need a physics that knows of the first one. */
static PetscErrorCode CheckScheme(const MpmModel model)
{
  const MpmPhysics *physics = &model->scene.physics;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < model->scene.stages.count; k++)
    MpmCheckInput(!model->scene.stages.at[k].time.second || (physics->traits & MPM_PHYSICS_STAGES),
                  "-mpm_time_scheme second: physics %s has nothing that it could do better, must be euler",
                  physics->name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Every stage must find the bodies that it removes, changes or moves, and leave one at least. */
static PetscErrorCode CheckBodies(const MpmModel model)
{
  PetscBool *there, *was;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc2((model->scene.bodies->count + 1), &there, (model->scene.bodies->count + 1), &was));
  for (PetscInt b = 0; b < model->scene.bodies->count; b++) {
    was[b]   = PETSC_FALSE;
    there[b] = PETSC_TRUE;
    for (PetscInt k = 0; k < model->scene.stages.count; k++)
      if (model->scene.stages.at[k].adds[b]) there[b] = PETSC_FALSE;
  }
  for (PetscInt k = 0; k < model->scene.stages.count; k++) {
    const MpmStage *stage = &model->scene.stages.at[k];
    PetscInt        left  = 0;

    for (PetscInt b = 0; b < model->scene.bodies->count; b++) {
      const char *body = model->scene.bodies->names[b];

      MpmCheckInput(!stage->adds[b] || (!there[b] && !was[b]),
                    "-mpm_stage_%s_bodies %s: the body was there before; one joins once", stage->name, body);
      if (stage->adds[b]) there[b] = PETSC_TRUE;
      MpmCheckInput(!stage->removed[b] || there[b], "-mpm_stage_%s_remove %s: the body is not there", stage->name,
                    body);
      was[b] = (PetscBool)(was[b] || there[b]);
      if (stage->removed[b]) there[b] = PETSC_FALSE;
      MpmCheckInput(stage->material[b] < 0 || there[b], "-mpm_stage_%s_materials %s: the body is not there",
                    stage->name, body);
      MpmCheckInput(
        !there[b] || stage->geostatic.method != MPM_GEOSTATIC_K0 || !MpmBodyIsStressed(model->scene.bodies->at[b]),
        "-mpm_body_%s_initial_stress: not in the geostatic stage %s, whose stress is that of k0", body, stage->name);
      left += there[b] ? 1 : 0;
    }
    MpmCheckInput(left, "-mpm_stage_%s_%s: no body is left", stage->name ? stage->name : "",
                  stage->name ? "remove" : "bodies");
    PetscCall(CheckMoved(model, stage, there));
  }
  PetscCall(PetscFree2(there, was));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmStagesRead(MpmModel model, const MpmOptions *options)
{
  MpmTimeControl scene;
  MpmRelaxation  relaxation;

  PetscFunctionBeginUser;
  PetscCall(MpmSceneTimeRead(model, options, &scene));
  MpmRelaxationDefaults(&relaxation);
  if (scene.rescue || MpmOptionsHelp()) PetscCall(ReadRelaxation(options, NULL, PETSC_TRUE, &relaxation));
  PetscCall(PetscCalloc1(model->scene.bodies->count, &model->state.scheme.parked));
  PetscCall(PetscCalloc1(model->scene.bodies->count, &model->state.scheme.fading));
  PetscCall(PetscMalloc1(model->scene.stages.count, &model->state.relaxing.ended));
  for (PetscInt k = 0; k < model->scene.stages.count; k++) model->state.relaxing.ended[k] = -1.;
  model->state.relaxing.first = model->state.relaxing.since = -1.;
  for (PetscInt k = 0; k < model->scene.stages.count; k++) {
    MpmStage *stage = &model->scene.stages.at[k];

    PetscCall(PetscMalloc1((model->scene.bodies->count + 1), &stage->material));
    stage->time       = scene;
    stage->relaxation = relaxation;
    if (stage->name) PetscCall(ReadStage(model, options, &scene, stage));
    else {
      PetscCall(PetscCalloc1((model->scene.bodies->count + 1), &stage->removed));
      PetscCall(PetscCalloc1((model->scene.bodies->count + 1), &stage->adds));
      for (PetscInt b = 0; b < model->scene.bodies->count; b++) stage->material[b] = -1;
    }
    model->state.period.run_end += stage->time.end;
  }
  PetscCall(MpmScheduleRead(options, model->state.period.run_end, &model->scene.stages));
  if (!MpmOptionsHelp()) PetscCall(CheckBodies(model));
  if (!MpmOptionsHelp()) PetscCall(CheckScheme(model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

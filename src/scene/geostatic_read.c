/*
  Reading of geostatic stages.
*/
#include "options/options.h"
#include "point/layout.h"
#include "point/material.h"
#include "particles/body.h"
#include "bc/bc.h"
#include "bc/body_motion.h"
#include "pairs/body_contact.h"
#include "rigid/rigid.h"
#include "rigid/rigid_motion.h"
#include "loads/load.h"
#include "query/model.h"
#include "query/query.h"
#include "scene/stage_lists.h"
#include "scene/stage_read.h"

#define K0_MOST 100.

/* A number, or `ocr`. */
static PetscErrorCode ParseK0(const MpmOptions *block, const char *text, const char *word, PetscReal *k0)
{
  PetscFunctionBeginUser;
  *k0 = MPM_K0_OCR;
  if (!strcmp(word, "ocr")) PetscFunctionReturn(PETSC_SUCCESS);
  MpmCheckInput(MpmParseReal(word, k0) && *k0 >= 0. && *k0 <= K0_MOST,
                "-%sk0 %s: must be a number in [0, %g], ocr, or body:value pairs of them", block->prefix, text,
                K0_MOST);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* One "name:value" pair: of a body, or of all bodies of a material. */
static PetscErrorCode TakeK0(MpmModel model, const MpmOptions *block, const char *text, char *pair, PetscReal k0[])
{
  char     *colon = strchr(pair, ':');
  PetscInt  body, material;
  PetscReal value;

  PetscFunctionBeginUser;
  MpmCheckInput(colon, "-%sk0 %s: must be a number, ocr, or body:value pairs", block->prefix, text);
  *colon   = '\0';
  body     = MpmStageFindName(model->scene.bodies->count, model->scene.bodies->names, pair);
  material = MpmStageFindName(model->scene.materials->count, model->scene.materials->names, pair);
  MpmCheckInput(body >= 0 || material >= 0, "-%sk0 %s: there is no body or material %s", block->prefix, text, pair);
  PetscCall(ParseK0(block, text, colon + 1, &value));
  for (PetscInt b = 0; b < model->scene.bodies->count; b++) {
    if (body >= 0 ? b != body : !MpmBodyHasMaterial(model->scene.bodies->at[b], material)) continue;
    MpmCheckInput(body >= 0 || !MpmBodyIsMixed(model->scene.bodies->at[b]),
                  "-%sk0 %s: body %s has points of several materials: name the body", block->prefix, text,
                  model->scene.bodies->names[b]);
    MpmCheckInput(PetscIsNanReal(k0[b]), "-%sk0 %s: body %s stands there twice", block->prefix, text,
                  model->scene.bodies->names[b]);
    k0[b] = value;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadK0(MpmModel model, const MpmOptions *block, MpmNeed need, MpmGeostatic *geostatic)
{
  char    *text, **pair;
  PetscInt count;

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsText(block, "k0",
                           "horizontal over vertical stress, for the method k0: a number, ocr (from friction and "
                           "overconsolidation), or pairs of these with names of bodies or materials, body:value",
                           NULL, need, &text));
  if (!text || MpmOptionsHelp()) PetscFunctionReturn(PetscFree(text));
  PetscCall(PetscMalloc1(model->scene.bodies->count, &geostatic->k0));
  for (PetscInt b = 0; b < model->scene.bodies->count; b++) geostatic->k0[b] = NAN;
  PetscCall(MpmTextSplit(text, &count, &pair));
  if (count == 1 && !strchr(pair[0], ':')) {
    PetscCall(ParseK0(block, text, pair[0], &geostatic->k0[0]));
    for (PetscInt b = 1; b < model->scene.bodies->count; b++) geostatic->k0[b] = geostatic->k0[0];
  } else
    for (PetscInt k = 0; k < count; k++) PetscCall(TakeK0(model, block, text, pair[k], geostatic->k0));
  for (PetscInt b = 0; b < model->scene.bodies->count; b++) {
    MpmCheckInput(!PetscIsNanReal(geostatic->k0[b]), "-%sk0 %s: body %s has none", block->prefix, text,
                  model->scene.bodies->names[b]);
    for (PetscInt m = 0; geostatic->k0[b] == MPM_K0_OCR && m < model->scene.materials->count; m++)
      MpmCheckInput(model->scene.materials->at[m].info.k0 || !MpmBodyHasMaterial(model->scene.bodies->at[b], m),
                    "-%sk0 %s: %s does not know the ratio of material %s, body %s: must be a number", block->prefix,
                    text, model->scene.materials->at[m].info.name, model->scene.materials->names[m],
                    model->scene.bodies->names[b]);
  }
  PetscCall(MpmNamesDestroy(count, &pair));
  PetscCall(PetscFree(text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmGeostaticRead(MpmModel model, const MpmOptions *options, const char *name, MpmGeostatic *geostatic)
{
  static const char *const methods[] = {"gravity", "k0", NULL};
  char                     prefix[256];
  const MpmOptions         block = {options->comm, prefix, options->record};
  PetscBool                ratio;
  PetscInt                 method;

  PetscFunctionBeginUser;
  PetscCall(PetscSNPrintf(prefix, sizeof(prefix), "mpm_stage_%s_geostatic_", name));
  PetscCall(MpmOptionsHas(&block, "k0", &ratio));
  method = ratio ? 1 : 0;
  PetscCall(MpmOptionsWord(&block, "method",
                           "gravity: the loads grow from nothing; k0, the default where there is a ratio: the stress "
                           "follows from the weight above",
                           methods, MPM_OPTIONAL, &method, NULL));
  geostatic->method     = method ? MPM_GEOSTATIC_K0 : MPM_GEOSTATIC_GRAVITY;
  geostatic->tolerance  = 1e-9;
  geostatic->iterations = 50;
  PetscCall(ReadK0(model, &block, method ? MPM_REQUIRED : MPM_OPTIONAL, geostatic));
  PetscCall(MpmOptionsReal(&block, "tolerance", "-", "largest displacement that remains, in heights of the material",
                           ((MpmRange){0., 1., PETSC_TRUE}), MPM_OPTIONAL, &geostatic->tolerance, NULL));
  PetscCall(MpmOptionsInt(&block, "iterations", "most solutions under the full loads", 1, 100000, MPM_OPTIONAL,
                          &geostatic->iterations, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The stress of k0 needs a vertical axis: that of gravity. */
static PetscErrorCode CheckGravity(MpmModel model, const MpmStage *stage)
{
  PetscInt axes = 0;

  PetscFunctionBeginUser;
  for (PetscInt a = 0; a < model->disc.dim; a++) {
    PetscReal along = 0.;

    for (PetscInt l = 0; l < model->scene.loads->count; l++)
      if (stage->loads[l] && model->scene.loads->at[l].type == MPM_LOAD_GRAVITY)
        along += model->scene.loads->at[l].value[a];
    axes += along != 0. ? 1 : 0;
  }
  MpmCheckInput(axes == 1, "-mpm_stage_%s_geostatic_method k0: gravity must act along one axis, here along %d",
                stage->name, (int)axes);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Time of a stage's start, and true where it is one of the geostatic stages with which the run begins. */
static PetscBool IsLeading(const MpmModel model, const MpmStage *stage, PetscReal *start)
{
  *start = 0.;
  for (const MpmStage *other = model->scene.stages.at; other < stage; other++) *start += other->time.end;
  return (PetscBool)(*start < MpmGeostaticEnd(model));
}

/*
  A geostatic stage is solved at its end, from the places at its start: boundaries must stand still between the two. At
  the run's start a ramp that would move one, and one that the scene does not give, begins behind such stages; so do the
  motion and the load of a body whose place is solved for.
*/
static PetscErrorCode CheckBoundary(const MpmModel model, const MpmStage *stage, MpmBoundary *boundary)
{
  const MpmMotion *motion = &boundary->motion;
  PetscReal        start, end;
  const PetscBool  leading = IsLeading(model, stage, &start);

  PetscFunctionBeginUser;
  MpmCheckInput(
    !boundary->freedom || leading,
    "-mpm_boundary_%s_free: its place is solved for, and the geostatic stage %s is an equilibrium without motion",
    boundary->name, stage->name);
  end = start + stage->time.end;
  if (boundary->freedom) boundary->freedom->still = end;
  for (int pass = 0; pass < 2; pass++) {
    const MpmPose   before = MpmBoundaryPose(boundary, start), after = MpmBoundaryPose(boundary, end);
    const PetscBool moves = (PetscBool) !!memcmp(&before, &after, sizeof(after));

    MpmCheckInput(!moves || (!pass && leading && !motion->rows),
                  "-mpm_boundary_%s_%s: the boundary moves from %g to %g s, in the geostatic stage %s, an equilibrium "
                  "without motion; %s from the run's start",
                  boundary->name, motion->rows ? "motion_table" : "ramp", (double)start, (double)end, stage->name,
                  motion->rows ? "its times count" : "its ramp counts");
    if (leading && (moves || !motion->given)) boundary->motion.delay = end;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A displacement prescribed by a ramp from 0 begins behind geostatic stages at the run's start. */
static PetscBool StandsStill(const MpmModel model, const MpmStage *stage, MpmRamp ramp)
{
  PetscReal start;

  return (PetscBool)(IsLeading(model, stage, &start) && ramp && MpmRampEvaluate(ramp, 0.) == 0.);
}

PetscErrorCode MpmGeostaticCheck(MpmModel model, const MpmStage *stage)
{
  PetscFunctionBeginUser;
  if (MpmOptionsHelp() || stage->geostatic.method == MPM_GEOSTATIC_NONE) PetscFunctionReturn(PETSC_SUCCESS);
  MpmCheckInput(model->disc.layout->traits.solid || model->disc.layout->own.taken_up >= 0,
                "-mpm_stage_%s_type geostatic: not available for physics %s", stage->name, model->scene.physics.name);
  for (PetscInt b = 0; b < model->scene.bcs->count; b++) {
    const MpmCondition *bc = &model->scene.bcs->at[b];

    for (PetscInt k = 0; k < bc->component_count && !bc->absorbing; k++)
      MpmCheckInput(!stage->bcs[b] || !model->disc.layout->component[bc->component[k]].increment ||
                      bc->value[k] == 0. || StandsStill(model, stage, bc->ramp),
                    "-mpm_bc_%s_value %g: must be 0, or have a ramp from 0, in the geostatic stage %s, an equilibrium "
                    "without motion",
                    model->scene.bcs->names[b], (double)bc->value[k], stage->name);
  }
  for (PetscInt b = 0; b < model->scene.boundaries->count; b++) {
    PetscCall(CheckBoundary(model, stage, &model->scene.boundaries->at[b]));
    PetscCall(MpmBoundaryKeepRest(&model->scene.boundaries->at[b]));
  }
  for (PetscInt p = 0; p < model->scene.pairs->count; p++) PetscCall(MpmPairKeepRest(&model->scene.pairs->at[p]));
  for (PetscInt m = 0; m < model->scene.motions->count; m++) {
    for (PetscInt k = 0; k < model->scene.motions->at[m].component_count; k++)
      MpmCheckInput(!stage->motions[m] || model->scene.motions->at[m].value[k] == 0. ||
                      StandsStill(model, stage, model->scene.motions->at[m].ramp),
                    "-mpm_motion_%s_value %g: must be 0, or have a ramp from 0, in the geostatic stage %s, an "
                    "equilibrium without motion",
                    model->scene.motions->names[m], (double)model->scene.motions->at[m].value[k], stage->name);
  }
  if (stage->geostatic.method == MPM_GEOSTATIC_K0) PetscCall(CheckGravity(model, stage));
  PetscFunctionReturn(PETSC_SUCCESS);
}

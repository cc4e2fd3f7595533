/*
  Options of the integrators: how a stage's steps are taken.
*/
#include "options/options.h"
#include "point/layout.h"
#include "point/material.h"
#include "grid/shape.h"
#include "particles/body.h"
#include "bc/bc.h"
#include "volume/added_term.h"
#include "volume/inertia.h"
#include "rigid/rigid.h"
#include "loads/load.h"
#include "pairs/body_contact.h"
#include "problem/potential.h"
#include "query/model.h"
#include "query/query.h"
#include "scene/integrator_read.h"

const char *const MpmIntegratorTypes[] = {"quasistatic",       "backward_euler", "newmark",
                                          "generalized_alpha", "explicit",       NULL};

/* The error in time that lets steps grow and shrink; and how fields with a rate go on. */
static PetscErrorCode ReadScheme(const MpmOptions *block, MpmTimeControl *control)
{
  static const char *const schemes[] = {"euler", "second", NULL};
  const PetscBool          dynamic   = (PetscBool)(control->motion.type != MPM_QUASISTATIC);
  PetscInt                 scheme;
  PetscBool                controlled;

  PetscFunctionBeginUser;
  PetscCall(
    MpmOptionsReal(block, "error", "-",
                   "largest error in time of a step, relative to the largest change since the stage's start, in "
                   "dynamics per length of the step to the largest velocity: it chooses the steps, up to "
                   "step_max; without inertia it needs scheme second",
                   MPM_RANGE_POSITIVE, MPM_OPTIONAL, &control->error, &controlled));
  if (controlled) control->adaptive = PETSC_TRUE;
  if (controlled && !dynamic) control->second = PETSC_TRUE;
  if (dynamic && !MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  scheme = control->second ? 1 : 0;
  PetscCall(MpmOptionsWord(block, "scheme",
                           "how fields with a rate go on in time: euler, of order 1; second, of order 2, two solutions "
                           "a step. The default is second where error is given, otherwise euler",
                           schemes, MPM_OPTIONAL, &scheme, NULL));
  control->second = (PetscBool)(scheme == 1);
  if (!control->second && !controlled) control->error = 0.;
  MpmCheckInput(control->second || !(control->error > 0.) || MpmOptionsHelp(),
                "-%sscheme euler: -%serror %g needs -%sscheme second", block->prefix, block->prefix,
                (double)control->error, block->prefix);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Options of explicit stages. */
static PetscErrorCode ReadExplicit(const MpmOptions *block, MpmMotionControl *motion)
{
  static const char *const updates[] = {"musl", "usl", "usf", NULL};
  PetscInt                 update    = (PetscInt)motion->update;

  PetscFunctionBeginUser;
  PetscCall(
    MpmOptionsReal(block, "cfl", "-",
                   "of explicit steps: their length over the time in which a wave, with the material's own speed, "
                   "crosses a cell; the smallest over all points counts",
                   ((MpmRange){0., 1., PETSC_FALSE}), MPM_OPTIONAL, &motion->cfl, NULL));
  MpmCheckInput(motion->cfl > 0. || MpmOptionsHelp(), "-%scfl %g: must lie in (0, 1]", block->prefix,
                (double)motion->cfl);
  PetscCall(MpmOptionsWord(block, "update",
                           "when an explicit step updates the stress: musl, last, by velocities mapped from the points "
                           "once more; usl, last, by the nodes' own; usf, first",
                           updates, MPM_OPTIONAL, &update, NULL));
  motion->update = (MpmStressUpdate)update;
  PetscCall(MpmOptionsReal(block, "rest", "-",
                           "an explicit stage ends once its kinetic energy has fallen below this share of its largest; "
                           "0: at its end alone",
                           ((MpmRange){0., 1., PETSC_FALSE}), MPM_OPTIONAL, &motion->rest, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Options of damping. */
static PetscErrorCode ReadDamping(const MpmOptions *block, MpmDampingControl *damping)
{
  PetscFunctionBeginUser;
  PetscCall(MpmOptionsReal(block, "damping_mass", "1/s", "Rayleigh's damping by mass", MPM_RANGE_NON_NEGATIVE,
                           MPM_OPTIONAL, &damping->mass, NULL));
  PetscCall(MpmOptionsReal(block, "damping_stiffness", "s", "Rayleigh's damping by the law's elastic stiffness",
                           MPM_RANGE_NON_NEGATIVE, MPM_OPTIONAL, &damping->stiffness, NULL));
  PetscCall(MpmOptionsReal(block, "viscosity_linear", "-",
                           "coefficient of the bulk viscosity that goes with the rate of compression; 0.06 is usual in "
                           "shocks",
                           MPM_RANGE_NON_NEGATIVE, MPM_OPTIONAL, &damping->linear, NULL));
  PetscCall(MpmOptionsReal(block, "viscosity_quadratic", "-",
                           "coefficient of the bulk viscosity that goes with its square; 1.2 to 2 in shocks",
                           MPM_RANGE_NON_NEGATIVE, MPM_OPTIONAL, &damping->quadratic, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* An option of one method says nothing to another. */
static PetscErrorCode CheckMethod(const MpmOptions *block, const char *option, PetscBool has, const char *with)
{
  PetscBool given;

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsHas(block, option, &given));
  MpmCheckInput(!given || has || MpmOptionsHelp(), "-%s%s: is an option of %s alone", block->prefix, option, with);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode CheckMethods(const MpmOptions *block, PetscInt type)
{
  const PetscBool newmark = (PetscBool)(type == MPM_NEWMARK), moves = (PetscBool)(type == MPM_EXPLICIT);

  PetscFunctionBeginUser;
  PetscCall(CheckMethod(block, "rho_inf", (PetscBool)(type == MPM_GENERALIZED_ALPHA), "integrator generalized_alpha"));
  PetscCall(CheckMethod(block, "beta", newmark, "integrator newmark"));
  PetscCall(CheckMethod(block, "gamma", newmark, "integrator newmark"));
  PetscCall(CheckMethod(block, "cfl", moves, "integrator explicit"));
  PetscCall(CheckMethod(block, "update", moves, "integrator explicit"));
  PetscCall(CheckMethod(block, "error", (PetscBool)!moves, "steps that are not explicit"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Further options of dynamic stages. */
static PetscErrorCode ReadMotion(const MpmOptions *block, MpmMotionControl *motion)
{
  static const char *const masses[] = {"consistent", "lumped", NULL};
  PetscInt                 type = (PetscInt)motion->type, transfer = (PetscInt)motion->transfer.type;
  PetscInt                 mass = motion->lumped ? 1 : 0;

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsWord(block, "integrator",
                           "how a step is taken: quasistatic, without inertia; implicit dynamics by one of three "
                           "methods; or explicit, symplectic Euler",
                           MpmIntegratorTypes, MPM_OPTIONAL, &type, NULL));
  motion->type = (MpmIntegratorType)type;
  PetscCall(CheckMethods(block, type));
  if (type == MPM_QUASISTATIC && !MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  if (type == MPM_GENERALIZED_ALPHA || MpmOptionsHelp())
    PetscCall(MpmOptionsReal(block, "rho_inf", "-",
                             "of generalized_alpha: what a step leaves of the fastest oscillations, 1: all, 0: nothing",
                             ((MpmRange){0., 1., PETSC_FALSE}), MPM_OPTIONAL, &motion->rho_inf, NULL));
  if (type == MPM_NEWMARK || MpmOptionsHelp()) {
    PetscCall(MpmOptionsReal(block, "beta", "-", "Newmark's, for displacement; 0.25: the trapezoidal rule",
                             ((MpmRange){0., 0.5, PETSC_TRUE}), MPM_OPTIONAL, &motion->beta, NULL));
    PetscCall(MpmOptionsReal(block, "gamma", "-", "Newmark's, for velocity; above 0.5 it damps, of order 1",
                             ((MpmRange){0.5, 1., PETSC_FALSE}), MPM_OPTIONAL, &motion->gamma, NULL));
    MpmCheckInput(2. * motion->beta >= motion->gamma || MpmOptionsHelp(),
                  "-%sbeta %g: must be at least half of -%sgamma, %g: otherwise long steps are unstable", block->prefix,
                  (double)motion->beta, block->prefix, (double)motion->gamma);
  }
  if (type == MPM_EXPLICIT || MpmOptionsHelp()) PetscCall(ReadExplicit(block, motion));
  if (type != MPM_EXPLICIT || MpmOptionsHelp())
    PetscCall(MpmOptionsWord(block, "mass",
                             "in implicit dynamics: consistent (the default), that of the points; lumped at the nodes, "
                             "cheaper, with more inertia against rotation",
                             masses, MPM_OPTIONAL, &mass, NULL));
  motion->lumped = (PetscBool)(mass == 1);
  PetscCall(
    MpmOptionsWord(block, "transfer",
                   "of velocities between points and nodes: apic (the default) keeps angular momentum, flip the most "
                   "energy; elements of order 2 and more have flip",
                   MpmTransferTypes, MPM_OPTIONAL, &transfer, NULL));
  motion->transfer.type = (MpmTransferType)transfer;
  PetscCall(CheckMethod(block, "pic", (PetscBool)(transfer == MPM_TRANSFER_FLIP), "transfer flip"));
  if (transfer == MPM_TRANSFER_FLIP || MpmOptionsHelp())
    PetscCall(MpmOptionsReal(block, "pic", "-", "share of PIC in flip, which damps what the nodes do not see",
                             ((MpmRange){0., 1., PETSC_FALSE}), MPM_OPTIONAL, &motion->transfer.pic, NULL));
  PetscCall(ReadDamping(block, &motion->damping));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Options of the rescue of a quasi-static step. */
static PetscErrorCode ReadRescue(const MpmOptions *block, MpmTimeControl *control)
{
  static const char *const rescues[] = {"none", "relaxation", NULL};
  const PetscBool          serves    = (PetscBool)(control->motion.type == MPM_QUASISTATIC);
  PetscInt                 rescue    = control->rescue ? 1 : 0;

  PetscFunctionBeginUser;
  PetscCall(CheckMethod(block, "rescue", serves, "integrator quasistatic"));
  control->rescue = PETSC_FALSE;
  if (!serves && !MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(
    MpmOptionsWord(block, "rescue",
                   "what goes on where a quasi-static step gives up: nothing, or a relaxation (block relaxation) "
                   "until there is rest",
                   rescues, MPM_OPTIONAL, &rescue, NULL));
  control->rescue = (PetscBool)(rescue == 1);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmIntegratorRead(const MpmOptions *block, MpmTimeControl *control)
{
  PetscFunctionBeginUser;
  PetscCall(ReadMotion(block, &control->motion));
  PetscCall(ReadRescue(block, control));
  if (control->motion.type != MPM_QUASISTATIC) control->second = PETSC_FALSE;
  PetscCall(ReadScheme(block, control));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MpmMotionDefaults(MpmMotionControl *motion)
{
  *motion = (MpmMotionControl){.rho_inf = 0.9, .beta = 0.25, .gamma = 0.5, .cfl = 0.5};
}

PetscBool MpmStagesSolve(const MpmModel model)
{
  for (PetscInt k = 0; k < model->scene.stages.count; k++)
    if (model->scene.stages.at[k].time.motion.type != MPM_EXPLICIT) return PETSC_TRUE;
  return PETSC_FALSE;
}

PetscBool MpmStagesAreImplicit(const MpmModel model)
{
  for (PetscInt k = 0; k < model->scene.stages.count; k++) {
    const MpmIntegratorType type = model->scene.stages.at[k].time.motion.type;

    if (type != MPM_QUASISTATIC && type != MPM_EXPLICIT) return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* True where any stage begins with inertia. */
static PetscBool AnyMoves(const MpmModel model)
{
  for (PetscInt k = 0; k < model->scene.stages.count; k++)
    if (model->scene.stages.at[k].time.motion.type != MPM_QUASISTATIC) return PETSC_TRUE;
  return PETSC_FALSE;
}

PetscBool MpmStagesAreDynamic(const MpmModel model)
{
  for (PetscInt k = 0; k < model->scene.stages.count; k++)
    if (model->scene.stages.at[k].time.rescue) return PETSC_TRUE;
  return AnyMoves(model);
}

/* True where points carry the fields of their transfer. */
PetscBool MpmStagesAreAffine(const MpmModel model)
{
  for (PetscInt k = 0; k < model->scene.stages.count; k++) {
    const MpmMotionControl *motion = &model->scene.stages.at[k].time.motion;

    if (motion->type != MPM_QUASISTATIC && motion->transfer.type == MPM_TRANSFER_APIC) return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* True where a body starts with points of the material. */
static PetscBool IsOfBody(const MpmModel model, PetscInt material)
{
  for (PetscInt b = 0; b < model->scene.bodies->count; b++)
    if (MpmBodyHasMaterial(model->scene.bodies->at[b], material)) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* A fixed explicit step must not be longer than a wave allows in material at rest, unless nodes take the scaled
   masses. */
static PetscErrorCode CheckExplicit(const MpmModel model, const MpmStage *stage)
{
  const MpmTimeControl *time = &stage->time;
  PetscReal             cell = PETSC_MAX_REAL;

  PetscFunctionBeginUser;
  for (PetscInt b = 0; time->motion.type != MPM_EXPLICIT && b < model->scene.boundaries->count; b++)
    MpmCheckInput(!model->scene.boundaries->at[b].basal,
                  "-mpm_boundary_%s_basal: friction by a law of the bed needs explicit steps in all stages",
                  model->scene.boundaries->names[b]);
  if (time->motion.type != MPM_EXPLICIT && !time->rescue) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt k = 0; k < model->scene.pairs->count; k++)
    MpmCheckInput(!model->scene.pairs->at[k].barrier,
                  "-mpm_contact_%s_method barrier: needs steps that are not explicit%s; they take penalty",
                  model->scene.pairs->names[k], time->rescue ? ", as those of -mpm_time_rescue relaxation are" : "");
  MpmCheckInput(!model->scene.terms->count, "-mpm_terms: need steps that are not explicit%s",
                time->rescue ? ", as those of -mpm_time_rescue relaxation are" : "");
  for (PetscInt b = 0; b < model->scene.boundaries->count; b++)
    MpmCheckInput(!model->scene.boundaries->at[b].freedom,
                  "-mpm_boundary_%s_free: its place is solved for; explicit steps%s solve for nothing",
                  model->scene.boundaries->names[b], time->rescue ? ", as those of -mpm_time_rescue relaxation," : "");
  if (time->rescue) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt a = 0; a < model->disc.dim; a++) cell = PetscMin(cell, model->disc.h[a]);
  for (PetscInt m = 0; !stage->relaxation.scaled && m < model->scene.materials->count; m++) {
    const MpmMaterial *material = &model->scene.materials->at[m];
    const PetscReal    crossing =
      MpmExplicitPart(&time->motion) * cell / PetscSqrtReal(material->moduli.stiffness / material->density);

    MpmCheckInput(
      !IsOfBody(model, m) || time->step <= crossing * (1. + PETSC_SQRT_MACHINE_EPSILON),
      "-mpm_%s%s%stime_step %g: must not exceed %.6g, s: the time in which a wave in material %s crosses a cell%s",
      stage->name ? "stage_" : "", stage->name ? stage->name : "", stage->name ? "_" : "", (double)time->step,
      (double)crossing, material->name, time->motion.update == MPM_UPDATE_USL ? ", by sqrt(2) for usl" : "");
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Velocities and accelerations, and waves, need inertia in every stage in which their conditions act. */
static PetscErrorCode CheckConditions(const MpmModel model)
{
  static const char *const quantities[] = {"displacement", "velocity", "acceleration"};

  PetscFunctionBeginUser;
  for (PetscInt b = 0; b < model->scene.bcs->count; b++) {
    const MpmCondition *bc   = &model->scene.bcs->at[b];
    const char         *name = model->scene.bcs->names[b];
    PetscBool           any  = PETSC_FALSE;

    for (PetscInt k = 0; k < model->scene.stages.count; k++) {
      const MpmStage *stage = &model->scene.stages.at[k];
      const PetscBool moves = (PetscBool)(stage->time.motion.type != MPM_QUASISTATIC);

      any = (PetscBool)(any || (moves && stage->bcs[b]));
      MpmCheckInput(moves || !stage->bcs[b] || bc->absorbing || bc->quantity == MPM_DISPLACEMENT,
                    "-mpm_bc_%s_quantity %s: must be displacement %s%s, which is quasi-static; -mpm_time_integrator "
                    "names one with inertia",
                    name, quantities[bc->quantity], stage->name ? "in stage " : "in this scene",
                    stage->name ? stage->name : "");
    }
    MpmCheckInput(!bc->absorbing || any,
                  "-mpm_bc_%s_absorbing: acts in no stage with inertia; -mpm_time_integrator names one", name);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmDynamicsRead(MpmModel model, const MpmOptions *options)
{
  const PetscBool dynamic = MpmStagesAreDynamic(model);

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < model->scene.stages.count; k++) {
    MpmStage *stage = &model->scene.stages.at[k];

    stage->time.motion.transfer.degree = stage->relaxation.motion.transfer.degree =
      MpmShapeDegree(model->scene.shape.type);
  }
  for (PetscInt l = 0; l < model->scene.loads->count; l++) {
    MpmLoad *load = &model->scene.loads->at[l];

    load->at_ends = (PetscBool)(load->type == MPM_LOAD_GRAVITY && !AnyMoves(model) &&
                                model->scene.shape.type == MPM_SHAPE_GIMP_BSPLINE2);
  }
  for (PetscInt b = 0; b < model->scene.bodies->count; b++) {
    const char *name = model->scene.bodies->names[b], *file;
    const char *given;
    PetscBool   run;

    PetscCall(
      MpmBodyReadVelocity(options, name, model->scene.shape.type, model->scene.bodies->at[b], &given, &file, &run));
    if (AnyMoves(model) || MpmOptionsHelp()) continue;
    MpmCheckInput(!given, "-mpm_body_%s_%s: no stage has inertia; -mpm_time_integrator names one", name, given);
    MpmCheckInput(!file || run,
                  "-mpm_body_%s_file %s: has velocities, and no stage has inertia; -mpm_time_integrator names one",
                  name, file);
    if (file)
      PetscCall(
        MpmMonitorLine(&model->monitor, "body %s: velocities of %s are not used, no stage has inertia", name, file));
  }
  model->disc.context.inertia->dynamic = dynamic;
  for (PetscInt k = 0; k < model->scene.stages.count; k++)
    if (model->disc.layout->traits.solid && MpmStageSettles(&model->scene.stages.at[k]))
      model->disc.context.inertia->settles = PETSC_TRUE;
  if (!MpmStagesSolve(model)) model->state.predict = PETSC_FALSE;
  if (!MpmOptionsHelp()) PetscCall(CheckConditions(model));
  if (!dynamic || MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  MpmCheckInput(model->disc.layout->traits.solid, "-mpm_time_%s: physics %s has no inertia; solid has",
                AnyMoves(model) ? "integrator" : "rescue", model->scene.physics.name);
  for (PetscInt m = 0; m < model->scene.materials->count; m++)
    MpmCheckInput(model->scene.materials->at[m].density > 0.,
                  "-mpm_material_%s_density: must be > 0, kg/m3, in dynamics", model->scene.materials->names[m]);
  for (PetscInt k = 0; k < model->scene.stages.count; k++) PetscCall(CheckExplicit(model, &model->scene.stages.at[k]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscBool MpmStagesMinimise(const MpmModel model)
{
  if (!MpmStagesSolve(model) || model->scene.stabilization.smooth > 0. || !MpmPotentialExists(&model->disc))
    return PETSC_FALSE;
  for (PetscInt k = 0; k < model->scene.stages.count; k++) {
    const MpmMotionControl  *motion  = &model->scene.stages.at[k].time.motion;
    const MpmDampingControl *damping = &motion->damping;

    if (motion->type == MPM_QUASISTATIC || motion->type == MPM_EXPLICIT) continue;
    if (damping->mass > 0. || damping->stiffness > 0. || damping->linear > 0. || damping->quadratic > 0.)
      return PETSC_FALSE;
    for (PetscInt b = 0; b < model->scene.bcs->count; b++)
      if (model->scene.bcs->at[b].absorbing) return PETSC_FALSE;
  }
  return PETSC_TRUE;
}

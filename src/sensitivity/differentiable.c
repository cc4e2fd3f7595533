/*
  Parts of a scene whose derivatives are not there in closed form yet: they are taken by twins.
*/
#include <string.h>
#include "point/layout.h"
#include "point/material.h"
#include "grid/grid.h"
#include "grid/shape.h"
#include "particles/body.h"
#include "particles/particles.h"
#include "particles/points.h"
#include "space/space.h"
#include "bc/bc.h"
#include "bc/body_motion.h"
#include "volume/added_term.h"
#include "rigid/rigid.h"
#include "pairs/body_contact.h"
#include "loads/body_surface.h"
#include "loads/load.h"
#include "query/query.h"
#include "loads/water_table.h"
#include "stepmap/rates_end.h"
#include "sensitivity/gradient.h"

/* A part, and whether the scene has it. */
typedef struct {
  const char *name;
  PetscBool   there;
} Part;

/* The first load of a kind that has no derivative, or NULL. */
static const char *FindLoad(const MpmScene *scene)
{
  for (PetscInt l = 0; l < scene->loads->count; l++) {
    const MpmLoad *load = &scene->loads->at[l];

    if (load->type == MPM_LOAD_FLUX) return "sources of water (-mpm_load_..._type flux)";
  }
  return NULL;
}

static PetscBool AnyInclined(const MpmConditions *conditions)
{
  for (PetscInt b = 0; b < conditions->count; b++)
    if (conditions->at[b].inclined || conditions->at[b].absorbing) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* True where any body begins with stress, or masses of its own. */
static PetscBool AnyStressed(const MpmBodies *bodies)
{
  for (PetscInt b = 0; b < bodies->count; b++)
    if (MpmBodyIsImported(bodies->at[b]) || MpmBodyIsStressed(bodies->at[b])) return PETSC_TRUE;
  return PETSC_FALSE;
}

PetscBool MpmGradientStartDiffers(const MpmModel model)
{
  return (PetscBool)(MpmStagesAreGeostatic(model) || AnyStressed(model->scene.bodies) ||
                     model->state.particles->has_mass);
}

/* True where any stage changes materials; takes up the geostatic state after others; has bodies join with a state that
   is not that of rest. */
static PetscBool AnyChange(const MpmScene *scene)
{
  for (PetscInt k = 0; k < scene->stages.count; k++)
    for (PetscInt b = 0; scene->stages.at[k].name && b < scene->bodies->count; b++)
      if (scene->stages.at[k].material[b] >= 0) return PETSC_TRUE;
  return PETSC_FALSE;
}

static PetscBool AnyLateRest(const MpmScene *scene)
{
  for (PetscInt k = 1; k < scene->stages.count; k++)
    if (scene->stages.at[k].geostatic.method != MPM_GEOSTATIC_NONE) return PETSC_TRUE;
  return PETSC_FALSE;
}

static PetscBool AnyStressedLater(const MpmScene *scene)
{
  for (PetscInt k = 1; k < scene->stages.count; k++)
    for (PetscInt b = 0; b < scene->bodies->count; b++)
      if (scene->stages.at[k].adds[b] &&
          (MpmBodyIsImported(scene->bodies->at[b]) || MpmBodyIsStressed(scene->bodies->at[b])))
        return PETSC_TRUE;
  return PETSC_FALSE;
}

/* True where bodies that join grow down to the settled ground. */
static PetscBool AnyFills(const MpmBodies *bodies)
{
  for (PetscInt b = 0; b < bodies->count; b++)
    if (MpmBodyFills(bodies->at[b]) == MPM_FILL_YES) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* True where any stage has inertia, or relaxes where it fails. */
static PetscBool AnyMotion(const MpmScene *scene)
{
  for (PetscInt k = 0; k < scene->stages.count; k++)
    if (scene->stages.at[k].time.motion.type != MPM_QUASISTATIC) return PETSC_TRUE;
  return PETSC_FALSE;
}

static PetscBool AnyRescue(const MpmScene *scene)
{
  for (PetscInt k = 0; k < scene->stages.count; k++)
    if (scene->stages.at[k].time.rescue) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* True where the penalty across faces goes with more than the materials' E: their constrained modulus, or the flow of
   water. */
static PetscBool PenaltyIsOpen(const MpmModel model)
{
  for (PetscInt m = 0; m < model->scene.materials->count; m++) {
    const MpmLawInfo *info = &model->scene.materials->at[m].info;
    size_t            k    = 0;

    while (k < info->parameter_count && strcmp(info->parameters[k].name, "E")) k++;
    if (k == info->parameter_count) return PETSC_TRUE;
  }
  return (PetscBool)(model->disc.layout->ghost != NULL);
}

/* True where surfaces have a part that surfaces.c does not differentiate. */
static PetscBool SurfacesAreOpen(const MpmModel model)
{
  const MpmScene *scene = &model->scene;

  for (PetscInt k = 0; k < scene->stages.count; k++)
    if (scene->surfaces->count && scene->stages.at[k].removal) return PETSC_TRUE;
  for (PetscInt k = 0; k < scene->surfaces->count; k++)
    if (scene->surfaces->at[k].cut) return PETSC_TRUE;
  return (PetscBool)(scene->surfaces->count &&
                     (!MpmShapeHasDomain(scene->shape.type) || scene->deformation.kinematics == MPM_AXISYMMETRY));
}

/* The first part without, or NULL. */
static const char *FindPart(const MpmModel model)
{
  const MpmScene *scene   = &model->scene;
  const Part      parts[] = {
         {"inertia (-mpm_time_integrator)", AnyMotion(scene)},
         {"a geostatic stage behind others", AnyLateRest(scene)},
         {"a change of material", AnyChange(scene)},
         {"bodies with initial stress, or from files, that join later", AnyStressedLater(scene)},
         {"bodies that fill the gap beneath as they join", AnyFills(scene->bodies)},
         {"a reduction of strength", MpmStagesReduce(model)},
         {"a relaxation", (PetscBool)(MpmStagesRelax(model) || AnyRescue(scene))},
         {"boundaries", (PetscBool)(scene->boundaries->count > 0)},
         {"contacts", (PetscBool)(scene->pairs->count > 0)},
         {"motions", (PetscBool)(scene->motions->count > 0)},
         {"surfaces with a shape without domains, in axial symmetry, at cut edges, or while bodies are taken away by a "
               "ramp",
          SurfacesAreOpen(model)},
         {"F-bar with elements of order 2 and more", (PetscBool)(model->disc.layout->means && model->disc.grid->order > 1)},
         {"backgrounds", (PetscBool)(scene->terms->backgrounds != NULL)},
         {"terms from plugins", (PetscBool)(scene->terms->count > 0)},
         {"conditions along a normal, and absorbing ones", AnyInclined(scene->bcs)},
         {"a body force of the caller", (PetscBool)(scene->body_force.function != NULL)},
         {"the ghost penalty of water, or of a material without E",
          (PetscBool)((model->disc.matrix.ghost > 0. || scene->stabilization.interior > 0.) && PenaltyIsOpen(model))},
         {"smoothed strains (-mpm_stabilization_smooth)", (PetscBool)(scene->stabilization.smooth > 0.)},
         {"a level of water", scene->water->there},
         {"rates of this physics", (PetscBool)!MpmRatesAreClosed(model->disc.layout)},
         {"a moving grid", (PetscBool)(scene->follow.what != MPM_FOLLOW_NOTHING)},
  };

  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(parts); k++)
    if (parts[k].there) return parts[k].name;
  return FindLoad(scene);
}

PetscErrorCode MpmGradientFindOpen(const MpmModel model, char text[MPM_OPEN_TEXT])
{
  const char *part = FindPart(model);

  PetscFunctionBeginUser;
  text[0] = '\0';
  for (PetscInt m = 0; m < model->scene.materials->count; m++)
    if (model->disc.layout->deviation.count && !model->scene.materials->at[m].info.moduli_sensitivity)
      PetscCall(PetscSNPrintf(text, MPM_OPEN_TEXT, "water in material %s, whose law has none of its shear modulus",
                              model->scene.materials->names[m]));
  for (PetscInt m = 0; m < model->scene.materials->count; m++)
    if (model->scene.materials->at[m].dilatancy && !model->scene.materials->at[m].info.dilatancy_sensitivity)
      PetscCall(PetscSNPrintf(text, MPM_OPEN_TEXT, "F-bar of material %s, whose law has none of its dilation",
                              model->scene.materials->names[m]));
  if (!model->disc.layout->kernel->sensitivity)
    PetscCall(PetscSNPrintf(text, MPM_OPEN_TEXT, "-mpm_physics %s", model->scene.physics.name));
  if (part) PetscCall(PetscStrncpy(text, part, MPM_OPEN_TEXT));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* True where points are there that no step has moved: parts of divided ones, and those in a gap beneath a body. */
static PetscErrorCode AnyNewPoints(const MpmModel model, PetscBool *any)
{
  MpmPoints points;

  PetscFunctionBeginUser;
  *any = PETSC_FALSE;
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  for (PetscInt p = 0; points.domain.divisions && p < points.count; p++)
    if (points.domain.divisions[p]) *any = PETSC_TRUE;
  for (PetscInt b = 0; model->scene.stages.count > 1 && b < model->scene.bodies->count; b++) {
    PetscInt first, end;

    MpmBodyGetIds(model->scene.bodies->at[b], &first, &end);
    first = MpmBodyFillId(model->scene.bodies->at[b], &points, 0, 0);
    for (PetscInt p = 0; p < points.count; p++)
      if (points.id[p] >= first && points.id[p] < end) *any = PETSC_TRUE;
  }
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, any, 1, MPM_MPI_BOOL, MPI_LOR, model->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmGradientFindOpened(const MpmModel model, char text[MPM_OPEN_TEXT])
{
  PetscInt  faces = model->disc.space->boxes.faces.count;
  PetscBool made;

  PetscFunctionBeginUser;
  text[0] = '\0';
  PetscCall(AnyNewPoints(model, &made));
  if (made)
    PetscCall(
      PetscStrncpy(text, "points that have been divided, or fill a gap beneath a body that has joined", MPM_OPEN_TEXT));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &faces, 1, MPIU_INT, MPI_MAX, model->comm));
  if (faces && PenaltyIsOpen(model))
    PetscCall(
      PetscStrncpy(text, "the penalty that holds sparse points, for water or a material without E", MPM_OPEN_TEXT));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmGradientCheckRun(const MpmModel model, MpmOutcome *outcome)
{
  const PetscInt *changes = model->monitor.changes;

  PetscFunctionBeginUser;
  if (changes[MPM_CHANGE_DILATION] || changes[MPM_CHANGE_SETTLING] || model->state.scheme.rescuing.count)
    PetscCall(
      MpmOutcomeFail(outcome, MPM_OUTCOME_INADMISSIBLE,
                     "the run has settled, relaxed or averaged dilation by itself, and there are no derivatives "
                     "yet with that"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* True where points are of the material, from the start or from a stage on. */
static PetscBool IsUsed(const MpmScene *scene, PetscInt material)
{
  for (PetscInt b = 0; b < scene->bodies->count; b++) {
    if (MpmBodyHasMaterial(scene->bodies->at[b], material)) return PETSC_TRUE;
    for (PetscInt k = 0; k < scene->stages.count; k++)
      if (scene->stages.at[k].name && scene->stages.at[k].material[b] == material) return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

PetscErrorCode MpmGradientCheckUse(const MpmModel model)
{
  const MpmSceneParameters *parameters = &model->gradient->parameters;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < parameters->count; k++)
    MpmCheckInput((parameters->at[k].kind != MPM_OF_LAW && parameters->at[k].kind != MPM_OF_PHYSICS) ||
                    parameters->at[k].index < 0 || IsUsed(&model->scene, parameters->at[k].index),
                  "-mpm_parameters %s: no result depends on it: no body is of the material", parameters->at[k].name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

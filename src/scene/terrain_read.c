/*
  Scenes of depth-averaged flow.
*/
#include "talus/point/basal.h"
#include "options/options.h"
#include "grid/grid.h"
#include "bc/bc.h"
#include "loads/body_surface.h"
#include "loads/load.h"
#include "pairs/body_contact.h"
#include "rigid/rigid.h"
#include "terrain/bed_flow.h"
#include "terrain/forest.h"
#include "point/basal_map.h"
#include "query/model.h"
#include "scene/terrain_read.h"

PetscErrorCode MpmTerrainRead(MpmModel model, const MpmOptions *options)
{
  const MpmScene *scene = &model->scene;
  PetscReal      *drag;
  MpmBed         *bed;
  PetscBool       viscous;

  PetscFunctionBeginUser;
  if (!(scene->physics.traits & MPM_PHYSICS_COLUMNS) && !MpmOptionsHelp()) {
    PetscCall(MpmOptionsHas(options, "terrain_viscosity", &viscous));
    MpmCheckInput(!viscous, "-mpm_terrain_viscosity: is an option of -mpm_physics depth_averaged");
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(PetscNew(&bed));
  PetscCall(MpmBedRead(options, model->disc.grid->lower, model->disc.grid->upper, bed));
  if (MpmOptionsHelp()) PetscCall(MpmForestsRead(options, model->disc.grid, &drag));
  if (MpmOptionsHelp() && !(scene->physics.traits & MPM_PHYSICS_COLUMNS)) {
    PetscCall(MpmBedDestroy(bed));
    PetscCall(PetscFree(bed));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  model->scene.deformation.bed = bed;
  PetscCall(PetscNew(&model->disc.context.bed));
  model->disc.context.bed->bed              = bed;
  model->disc.context.bed->mixed.dissipated = &model->state.scheme.energy.dissipated;
  if (bed->dams.count) PetscCall(PetscCalloc1(bed->dams.count, &model->disc.context.bed->on_bed.dams));
  if (MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  if (bed->outflow) model->disc.grid->outflow = PETSC_TRUE;
  if (options->record && bed->map.value)
    MpmRecordSetPlane(options->record, &(MpmPlane){bed->project, bed->map.system, {0., 0.}});
  MpmCheckInput(scene->deformation.kinematics == MPM_PLANE_STRAIN,
                "-mpm_physics %s: -mpm_dim must be 2, without axial symmetry: x and y are horizontal",
                scene->physics.name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTerrainReadParameters(MpmModel model, const MpmOptions *options)
{
  const MpmMaterials *materials = model->scene.materials;
  MpmBedFlow         *flow      = model->disc.context.bed;
  MpmMap              map       = {0};
  PetscBool           is;

  PetscFunctionBeginUser;
  if (!model->scene.deformation.bed || MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmForestsRead(options, model->disc.grid, &flow->drag));
  for (PetscInt m = 0; m < materials->count; m++) {
    const MpmLawInfo *law = &materials->at[m].info;
    char              prefix[256];

    PetscCall(PetscSNPrintf(prefix, sizeof(prefix), "mpm_material_%s_", materials->names[m]));
    for (PetscInt k = MPM_BASAL_OWN; k < (PetscInt)law->parameter_count; k++) {
      PetscCall(MpmBasalMapRead(&(MpmOptions){options->comm, prefix, options->record}, &law->parameters[k], &map, &is));
      if (!is) continue;
      PetscCheck(law->parameter_count <= MPM_BED_PARAMETERS, options->comm, PETSC_ERR_PLIB, "%s has %zu parameters",
                 law->name, law->parameter_count);
      PetscCall(PetscRealloc(sizeof(*flow->by_map.at) * (size_t)(flow->by_map.count + 1), &flow->by_map.at));
      flow->by_map.at[flow->by_map.count++] = (MpmBedParameter){m, k, map};
      map                                   = (MpmMap){0};
    }
  }
  if (flow->by_map.count) PetscCall(PetscCalloc1(materials->count * MPM_BED_PARAMETERS, &flow->own));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTerrainCheck(const MpmModel model)
{
  const MpmScene *scene = &model->scene;

  PetscFunctionBeginUser;
  if (!scene->deformation.bed || MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt k = 0; k < scene->stages.count; k++) {
    const MpmStage *stage = &scene->stages.at[k];

    MpmCheckInput(stage->time.motion.type == MPM_EXPLICIT && !stage->relaxation.on &&
                    stage->geostatic.method == MPM_GEOSTATIC_NONE,
                  "-mpm_physics %s: -mpm_time_integrator must be explicit in all stages", scene->physics.name);
  }
  MpmCheckInput(!scene->boundaries->count && !scene->pairs->count && !scene->surfaces->count,
                "-mpm_%s: there are none yet with -mpm_physics %s",
                scene->boundaries->count ? "boundaries"
                : scene->pairs->count    ? "contacts"
                                         : "surfaces",
                scene->physics.name);
  for (PetscInt m = 0; m < scene->materials->count; m++)
    for (PetscInt k = 0; scene->materials->at[m].varies && k < (PetscInt)scene->materials->at[m].info.parameter_count;
         k++)
      MpmCheckInput(!MpmMaterialVaries(&scene->materials->at[m], k),
                    "-mpm_material_%s_%s: must be a number or a map with -mpm_physics %s", scene->materials->names[m],
                    scene->materials->at[m].info.parameters[k].name, scene->physics.name);
  for (PetscInt b = 0; b < scene->bcs->count; b++)
    MpmCheckInput(!scene->bcs->at[b].absorbing, "-mpm_bc_%s_absorbing: not available with -mpm_physics %s",
                  scene->bcs->names[b], scene->physics.name);
  for (PetscInt l = 0; l < scene->loads->count; l++)
    MpmCheckInput(scene->loads->at[l].type != MPM_LOAD_GRAVITY,
                  "-mpm_load_%s_type gravity: weight is there already, by the materials' gravity",
                  scene->loads->at[l].name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTerrainDestroy(MpmModel model)
{
  PetscFunctionBeginUser;
  if (!model->scene.deformation.bed) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmBedFlowDestroy(&model->disc.context.bed));
  PetscCall(MpmBedDestroy(model->scene.deformation.bed));
  PetscCall(PetscFree(model->scene.deformation.bed));
  PetscFunctionReturn(PETSC_SUCCESS);
}

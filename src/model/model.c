/*
  The model: its life, settings of the library's caller, and its set-up.
*/
#include "options/record.h"
#include "point/layout.h"
#include "ground/ground.h"
#include "point/material.h"
#include "grid/grid.h"
#include "particles/body.h"
#include "particles/particles.h"
#include "bc/bc.h"
#include "bc/body_motion.h"
#include "volume/added_term.h"
#include "contact/rigid_body.h"
#include "pairs/body_contact.h"
#include "loads/body_surface.h"
#include "loads/load.h"
#include "loads/water_table.h"
#include "query/model.h"
#include "scene/integrator_read.h"
#include "scene/scene_read.h"
#include "scene/stage_read.h"
#include "scene/terrain_read.h"
#include "integrators/dynamics.h"
#include "integrators/integrators.h"
#include "integrators/sdirk.h"
#include "schedule/stage.h"
#include "observe/results.h"
#include "entrainment/entrainment.h"
#include "runout/runout.h"
#include "sensitivity/gradient.h"
#include "checkpoint/checkpoint.h"
#include "ensemble/ensemble.h"
#include "model/build.h"
#include "laboratory/laboratory.h"
#include "model/program.h"

/* The parts that the model holds by pointers, empty. */
static PetscErrorCode CreateParts(MpmModel model)
{
  MpmGrid   *grid;
  MpmLayout *layout;

  PetscFunctionBeginUser;
  PetscCall(PetscNew(&model->scene.materials));
  PetscCall(PetscNew(&model->scene.bodies));
  PetscCall(PetscNew(&model->scene.bcs));
  PetscCall(PetscNew(&model->scene.motions));
  PetscCall(PetscNew(&model->scene.boundaries));
  PetscCall(PetscNew(&model->scene.pairs));
  PetscCall(PetscNew(&model->scene.loads));
  PetscCall(PetscNew(&model->scene.water));
  PetscCall(PetscNew(&model->scene.surfaces));
  PetscCall(PetscNew(&model->scene.terms));
  PetscCall(MpmStateCreate(&model->state));
  PetscCall(PetscNew(&grid));
  PetscCall(PetscNew(&layout));
  PetscCall(MpmDiscretizationCreate(model->comm, grid, layout, &model->disc));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmModelCreate(MPI_Comm comm, MpmModel *model)
{
  PetscFunctionBeginUser;
  PetscCall(PetscNew(model));
  PetscCall(PetscCommDuplicate(comm, &(*model)->comm, NULL));
  PetscCallMPI(MPI_Comm_rank(comm, &(*model)->rank));
  PetscCallMPI(MPI_Comm_size(comm, &(*model)->size));
  PetscCall(MpmRecordCreate(&(*model)->record));
  PetscCall(PetscNew(&(*model)->results));
  (*model)->solver.disc    = &(*model)->disc;
  (*model)->solver.monitor = &(*model)->monitor;
  PetscCall(MpmDatabaseCreate(&(*model)->database));
  (*model)->solver.database = (*model)->database;
  PetscCall(MpmMonitorCreate(&(*model)->monitor));
  (*model)->monitor.message         = MpmTerminalMessage;
  (*model)->monitor.ctx             = *model;
  (*model)->state.scheme.integrator = &MpmIntegratorQuasistatic;
  PetscCall(CreateParts(*model));
  {
    PetscLogDouble now;

    PetscCall(PetscTime(&now));
    (*model)->results->start = now;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- settings of the caller ---- */

PetscBool MpmModelHasScene(const MpmModel model)
{
  return (PetscBool)(model->scene.stages.at || model->laboratory);
}

PetscErrorCode MpmModelSetOptions(MpmModel model, const char options[])
{
  PetscFunctionBeginUser;
  PetscCheck(!MpmModelHasScene(model), model->comm, PETSC_ERR_ARG_WRONGSTATE, "the scene has been read");
  PetscCall(MpmDatabaseInsert(model->database, model->comm, options));
  model->caller.own = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmModelSetOptionsPrefix(MpmModel model, const char prefix[])
{
  PetscFunctionBeginUser;
  PetscCheck(!MpmModelHasScene(model), model->comm, PETSC_ERR_ARG_WRONGSTATE, "the scene has been read");
  PetscCheck(!prefix || prefix[0] != '-', model->comm, PETSC_ERR_ARG_WRONG, "%s: a prefix has no dash", prefix);
  PetscCall(PetscFree(model->caller.prefix));
  PetscCall(PetscStrallocpy(prefix, &model->caller.prefix));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmModelSetPhysics(MpmModel model, const MpmPhysics *physics)
{
  PetscFunctionBeginUser;
  model->scene.physics = *physics;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmModelSetBodyForce(MpmModel model, MpmBodyForce force, void *ctx)
{
  PetscFunctionBeginUser;
  model->scene.body_force.function = force;
  model->scene.body_force.ctx      = ctx;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmModelUseTerminal(MpmModel model)
{
  PetscFunctionBeginUser;
  model->caller.terminal = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MpmModelSetSources(MpmModel model, MpmSources sources)
{
  model->record->sources = sources;
}

PetscErrorCode MpmModelEnter(MpmModel model)
{
  PetscFunctionBeginUser;
  PetscCheck(!model->caller.busy, model->comm, PETSC_ERR_ARG_WRONGSTATE,
             "a hook must not set up, step or run its own model");
  PetscCall(MpmDatabaseEnter(model->database));
  model->caller.busy = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmModelLeave(MpmModel model)
{
  PetscFunctionBeginUser;
  model->caller.busy = PETSC_FALSE;
  PetscCall(MpmDatabaseLeave(model->database));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- its end ---- */

static PetscErrorCode DestroyScene(MpmScene *scene)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; scene->materials->at && k < scene->materials->count; k++)
    PetscCall(MpmMaterialDestroy(&scene->materials->at[k]));
  for (PetscInt k = 0; scene->bodies->at && k < scene->bodies->count; k++)
    PetscCall(MpmBodyDestroy(&scene->bodies->at[k]));
  for (PetscInt k = 0; scene->bcs->at && k < scene->bcs->count; k++) PetscCall(MpmConditionDestroy(&scene->bcs->at[k]));
  for (PetscInt k = 0; scene->motions->at && k < scene->motions->count; k++)
    PetscCall(MpmBodyMotionDestroy(&scene->motions->at[k]));
  for (PetscInt k = 0; scene->boundaries->at && k < scene->boundaries->count; k++)
    PetscCall(MpmBoundaryDestroy(&scene->boundaries->at[k]));
  for (PetscInt k = 0; scene->loads->at && k < scene->loads->count; k++)
    PetscCall(MpmLoadDestroy(&scene->loads->at[k]));
  PetscCall(PetscFree(scene->materials->at));
  PetscCall(PetscFree(scene->bodies->at));
  PetscCall(PetscFree(scene->bodies->part));
  PetscCall(PetscFree(scene->bcs->at));
  PetscCall(PetscFree(scene->boundaries->at));
  PetscCall(PetscFree(scene->loads->at));
  PetscCall(MpmNamesDestroy(scene->materials->count, &scene->materials->names));
  PetscCall(MpmGroundsDestroy(&scene->materials->grounds));
  PetscCall(PetscFree(scene->materials));
  PetscCall(MpmNamesDestroy(scene->bodies->count, &scene->bodies->names));
  PetscCall(PetscFree(scene->bodies));
  PetscCall(MpmNamesDestroy(scene->bcs->count, &scene->bcs->names));
  PetscCall(PetscFree(scene->bcs));
  PetscCall(MpmNamesDestroy(scene->motions->count, &scene->motions->names));
  PetscCall(PetscFree(scene->motions->at));
  PetscCall(PetscFree(scene->motions));
  PetscCall(MpmNamesDestroy(scene->boundaries->count, &scene->boundaries->names));
  PetscCall(PetscFree(scene->boundaries));
  PetscCall(MpmPairsDestroy(scene->pairs));
  PetscCall(PetscFree(scene->pairs));
  PetscCall(MpmNamesDestroy(scene->loads->count, &scene->loads->names));
  PetscCall(PetscFree(scene->loads));
  PetscCall(MpmWaterTableDestroy(scene->water));
  PetscCall(PetscFree(scene->water));
  PetscCall(MpmBodySurfacesDestroy(scene->surfaces));
  PetscCall(PetscFree(scene->surfaces));
  PetscCall(MpmAddedTermsDestroy(scene->terms));
  PetscCall(PetscFree(scene->terms));
  PetscCall(PetscFree(scene->name.title));
  PetscCall(PetscFree(scene->name.prefix));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmModelDestroy(MpmModel *handle)
{
  MpmModel model = *handle;

  PetscFunctionBeginUser;
  if (!model) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCheck(!model->caller.busy, model->comm, PETSC_ERR_ARG_WRONGSTATE, "a hook must not destroy its own model");
  if (model->state.particles->swarm) PetscCall(MpmParticlesRestoreArrays(model->state.particles, model->disc.points));
  PetscCall(MpmGradientDestroy(&model->gradient));
  PetscCall(MpmEnsembleDestroy(model));
  PetscCall(MpmLaboratoryDestroy(&model->laboratory));
  PetscCall(MpmSolverDestroy(&model->solver));
  PetscCall(MpmRunoutDestroy(model));
  PetscCall(MpmEntrainmentDestroy(model));
  PetscCall(MpmTerrainDestroy(model));
  PetscCall(MpmDiscretizationDestroy(&model->disc));
  PetscCall(MpmResultsDestroy(model));
  PetscCall(MpmCheckpointDestroy(&model->results->checkpoint));
  PetscCall(MpmGridDestroy(model->disc.grid));
  PetscCall(PetscFree(model->disc.grid));
  PetscCall(PetscFree(model->disc.layout));
  PetscCall(MpmSdirkDestroy(&model->state.scheme.sdirk));
  PetscCall(MpmDynamicsDestroy(&model->state.scheme.dynamics));
  PetscCall(MpmStagesDestroy(model));
  PetscCall(MpmStateDestroy(&model->state));
  PetscCall(DestroyScene(&model->scene));
  PetscCall(MpmRecordDestroy(&model->record));
  PetscCall(MpmDatabaseDestroy(&model->database));
  PetscCall(PetscFree(model->caller.prefix));
  PetscCall(PetscCommDestroy(&model->comm));
  PetscCall(PetscFree(model->results));
  PetscCall(PetscFree(*handle));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- set-up ---- */

/* About how many unknowns the material needs: the cells that its volume fills, with order^dim nodes each. */
static PetscErrorCode EstimateUnknowns(MpmModel model, PetscReal *unknowns)
{
  PetscReal volume = 0., *volume0;
  PetscInt  count;

  PetscFunctionBeginUser;
  PetscCall(DMSwarmGetLocalSize(model->state.particles->swarm, &count));
  PetscCall(MpmParticlesGetField(model->state.particles, "volume0", &volume0));
  for (PetscInt p = 0; p < count; p++) volume += volume0[p];
  PetscCall(MpmParticlesRestoreField(model->state.particles, &volume0));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &volume, 1, MPIU_REAL, MPIU_SUM, model->comm));
  for (PetscInt a = 0; a < model->disc.dim; a++) volume *= (PetscReal)model->disc.grid->order;
  for (PetscInt a = 0; a < model->disc.dim; a++) volume /= model->disc.h[a];
  *unknowns = volume * (PetscReal)model->disc.block;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Points, discretization and solver of the scene that has been read. */
static PetscErrorCode SetUp(MpmModel model)
{
  const MpmOptions options = {model->comm, "mpm_", model->record};
  PetscLogDouble   since;
  PetscReal        unknowns = 0.;

  PetscFunctionBeginUser;
  PetscCall(MpmMonitorBegin(&model->monitor, MPM_TIME_SETUP, &since));
  PetscCall(MpmRestartOpen(model));
  PetscCall(MpmPointFieldsCreate(model));
  PetscCall(MpmDiscretizationSetUp(&model->disc, model->scene.materials, model->scene.boundaries, model->scene.bodies,
                                   model->scene.pairs, model->state.placements, model->state.particles->state_size));
  PetscCall(MpmPointsCreate(model));
  PetscCall(MpmSurfacesAdd(model));
  PetscCall(MpmEntrainmentAddTerm(model));
  PetscCall(MpmDiscretizationAddTerms(&model->disc, model->scene.terms));
  model->solver.cache.minimisation.on = MpmStagesMinimise(model);
  PetscCall(MpmCheckpointKeepOptions(model, &options));
  PetscCall(EstimateUnknowns(model, &unknowns));
  if (MpmStagesSolve(model)) PetscCall(MpmSolverChoose(&model->solver, unknowns, MpmStagesAreImplicit(model)));
  else {
    PetscCall(PetscFree(model->solver.preset.name));
    PetscCall(PetscStrallocpy("none", &model->solver.preset.name));
  }
  PetscCall(MpmRestartApply(model));
  PetscCall(MpmModelWarnCoarse(model));
  PetscCall(MpmModelWarnUnused(model));
  model->caller.set_up = PETSC_TRUE;
  PetscCall(MpmMonitorEnd(&model->monitor, MPM_TIME_SETUP, since));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmModelSetUp(MpmModel model)
{
  PetscFunctionBeginUser;
  if (model->caller.set_up) PetscFunctionReturn(PETSC_SUCCESS);
  if (model->laboratory) {
    MpmModelCall(model, MpmLaboratorySetUp(model));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCheck(model->scene.stages.at, model->comm, PETSC_ERR_ARG_WRONGSTATE, "MpmModelSetFromOptions() comes first");
  MpmModelCall(model, SetUp(model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

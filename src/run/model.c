/*
  The model: the scene read from options, and the loop over steps.
*/
#include "options/options.h"
#include "terms/sparsity.h"
#include "terms/terms.h"
#include "run/run.h"

const char *const MpmJacobianTypes[] = {"auto", "local", "coloring", "matfree", "dense", "fd", NULL};

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
  PetscCall(MpmMonitorCreate(&(*model)->monitor));
  (*model)->monitor.message  = MpmTerminalMessage;
  (*model)->monitor.ctx      = *model;
  (*model)->state.integrator = &MpmIntegratorQuasistatic;
  {
    PetscLogDouble now;

    PetscCall(PetscTime(&now));
    (*model)->results->start = now;
  }
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
  model->scene.body_force     = force;
  model->scene.body_force_ctx = ctx;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmModelDestroy(MpmModel *handle)
{
  MpmModel model = *handle;

  PetscFunctionBeginUser;
  if (!model) PetscFunctionReturn(PETSC_SUCCESS);
  if (model->state.particles.swarm) PetscCall(MpmParticlesRestoreArrays(&model->state.particles, &model->disc.points));
  PetscCall(MpmSolverDestroy(&model->solver));
  PetscCall(MpmDiscretizationDestroy(&model->disc));
  PetscCall(PetscFree(model->results->history_row));
  PetscCall(MpmCheckpointDestroy(&model->results->checkpoint));
  PetscCall(MpmOutputDestroy(&model->results->output));
  PetscCall(MpmHistoryDestroy(&model->results->history));
  PetscCall(MpmParticlesDestroy(&model->state.particles));
  PetscCall(MpmGridDestroy(&model->disc.grid));
  for (PetscInt k = 0; model->scene.materials.at && k < model->scene.materials.count; k++)
    PetscCall(MpmMaterialDestroy(&model->scene.materials.at[k]));
  for (PetscInt k = 0; model->scene.bodies.at && k < model->scene.bodies.count; k++)
    PetscCall(MpmBodyDestroy(&model->scene.bodies.at[k]));
  for (PetscInt k = 0; model->scene.bcs.at && k < model->scene.bcs.count; k++)
    PetscCall(MpmConditionDestroy(&model->scene.bcs.at[k]));
  for (PetscInt k = 0; model->scene.boundaries.at && k < model->scene.boundaries.count; k++)
    PetscCall(MpmBoundaryDestroy(&model->scene.boundaries.at[k]));
  for (PetscInt k = 0; model->scene.loads.at && k < model->scene.loads.count; k++)
    PetscCall(MpmLoadDestroy(&model->scene.loads.at[k]));
  for (PetscInt k = 0; model->results->tracks.at && k < model->results->tracks.count; k++)
    PetscCall(MpmTrackDestroy(&model->results->tracks.at[k]));
  PetscCall(PetscFree(model->scene.materials.at));
  PetscCall(PetscFree(model->scene.bodies.at));
  PetscCall(PetscFree(model->scene.bcs.at));
  PetscCall(PetscFree(model->scene.boundaries.at));
  PetscCall(PetscFree(model->scene.loads.at));
  PetscCall(PetscFree(model->results->tracks.at));
  PetscCall(PetscFree(model->scene.walls.at));
  PetscCall(MpmStagesDestroy(model));
  PetscCall(MpmNamesDestroy(model->scene.materials.count, &model->scene.materials.names));
  PetscCall(MpmNamesDestroy(model->scene.bodies.count, &model->scene.bodies.names));
  PetscCall(MpmNamesDestroy(model->scene.bcs.count, &model->scene.bcs.names));
  PetscCall(MpmNamesDestroy(model->scene.boundaries.count, &model->scene.boundaries.names));
  PetscCall(MpmNamesDestroy(model->scene.loads.count, &model->scene.loads.names));
  PetscCall(MpmNamesDestroy(model->results->tracks.count, &model->results->tracks.names));
  PetscCall(MpmNamesDestroy(model->results->output_field_count, &model->results->output_fields));
  PetscCall(PetscFree(model->scene.title));
  PetscCall(PetscFree(model->scene.prefix));
  PetscCall(MpmRecordDestroy(&model->record));
  PetscCall(PetscCommDestroy(&model->comm));
  PetscCall(PetscFree(model->results));
  PetscCall(PetscFree(*handle));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the scene ---- */

/* The physics of that name, and the layout of its unknowns. */
static PetscErrorCode CreatePhysics(MpmModel model, const char *name, PetscInt dim)
{
  PetscBool found = PETSC_TRUE, solid;

  PetscFunctionBeginUser;
  PetscCall(PetscStrcmp(name, "solid", &solid));
  if (!model->scene.physics.name) {
    MpmCheckInput(solid, "-mpm_physics %s: must be one of solid", name);
    PetscCall(MpmPhysicsCreate(name, &model->scene.physics, &found));
    PetscCheck(found, model->comm, PETSC_ERR_PLIB, "physics %s is not compiled in", name);
  }
  PetscCall(MpmLayoutCreate(&model->scene.physics, dim, &model->disc.layout));
  model->scene.stretch = MpmStretchFind(dim);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Dimension, physics, shape: what everything else depends on. */
static PetscErrorCode ReadKind(MpmModel model, const MpmOptions *options)
{
  char    *name;
  PetscInt dim = 2, shape = MPM_SHAPE_GIMP, edge = MPM_EDGE_LINEAR, jacobian = MPM_JACOBIAN_AUTO;

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsHeading(options, "Scene"));
  PetscCall(MpmOptionsText(options, "title", "free text for the log", "", MPM_OPTIONAL, &model->scene.title));
  PetscCall(MpmOptionsInt(options, "dim", "dimension: 2 (plane strain) or 3", 2, 3, MPM_REQUIRED, &dim, NULL));
  PetscCall(MpmOptionsText(options, "physics", "what is solved: solid", "solid", MPM_OPTIONAL, &name));
  PetscCall(MpmOptionsWord(options, "shape", "shape functions", MpmShapeTypes, MPM_OPTIONAL, &shape, NULL));
  model->scene.shape = (MpmShapeType)shape;
  PetscCall(MpmOptionsWord(options, "shape_edge", "how splines end at the grid's edges and at walls", MpmEdgeTypes,
                           MPM_OPTIONAL, &edge, NULL));
  model->scene.edge = (MpmEdgeType)edge;
  PetscCall(
    MpmOptionsWord(options, "jacobian", "how the Jacobian is made", MpmJacobianTypes, MPM_OPTIONAL, &jacobian, NULL));
  model->solver.jacobian_type = jacobian == MPM_JACOBIAN_AUTO ? MPM_JACOBIAN_LOCAL : (MpmJacobianType)jacobian;
  PetscCall(MpmStabilizationRead(model, options));
  PetscCall(CreatePhysics(model, name, dim));
  PetscCall(PetscFree(name));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The results' folder must be there and take files. */
static PetscErrorCode CheckPrefix(MpmModel model)
{
  char      folder[PETSC_MAX_PATH_LEN] = ".", *slash;
  PetscBool there;
  size_t    length;

  PetscFunctionBeginUser;
  if (MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  MpmCheckInput(model->scene.prefix[0] && strlen(model->scene.prefix) < sizeof(folder) - 64,
                "-mpm_output_prefix: must be a name of 1 to %d characters", (int)sizeof(folder) - 65);
  slash  = strrchr(model->scene.prefix, '/');
  length = strlen(slash ? slash + 1 : model->scene.prefix);
  MpmCheckInput(length > 0 && length <= 200,
                "-mpm_output_prefix: the name behind the folder has %d characters, must have 1 to 200", (int)length);
  if (slash) PetscCall(PetscStrncpy(folder, model->scene.prefix, (size_t)(slash - model->scene.prefix) + 2));
  PetscCall(PetscTestDirectory(folder, 'w', &there));
  MpmCheckInput(there, "-mpm_output_prefix %s: the folder %s is not there or cannot be written", model->scene.prefix,
                folder);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadOutput(MpmModel model, const MpmOptions *options)
{
  const MpmOptions block = {options->comm, "mpm_output_", options->record};

  PetscFunctionBeginUser;
  model->results->output_every = 1;
  PetscCall(MpmOptionsHeading(&block, "Output"));
  PetscCall(
    MpmOptionsText(&block, "prefix", "results are named after it", "talus", MPM_OPTIONAL, &model->scene.prefix));
  PetscCall(CheckPrefix(model));
  PetscCall(MpmOptionsInt(&block, "every", "steps between written states; 0: none but the history and the summary", 0,
                          PETSC_INT_MAX, MPM_OPTIONAL, &model->results->output_every, NULL));
  PetscCall(MpmOutputSetFromOptions(model, &block));
  PetscCall(MpmOptionsBool(options, "quiet", "no lines but errors on the terminal", &model->results->quiet, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadMaterialsAndBodies(MpmModel model, const MpmOptions *options)
{
  PetscReal stiffest = 0.;

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsBlocks(options, "materials", "names of the material blocks", MPM_REQUIRED,
                             &model->scene.materials.count, &model->scene.materials.names));
  PetscCall(PetscCalloc1(model->scene.materials.count, &model->scene.materials.at));
  model->solver.symmetric = PETSC_TRUE;
  for (PetscInt m = 0; m < model->scene.materials.count; m++) {
    PetscCall(
      MpmMaterialCreate(options, model->scene.materials.names[m], model->disc.grid.dim, &model->scene.materials.at[m]));
    if (!(model->scene.materials.at[m].info.traits & MPM_LAW_SYMMETRIC)) model->solver.symmetric = PETSC_FALSE;
    stiffest = PetscMax(stiffest, model->scene.materials.at[m].stiffness);
  }
  if (model->scene.physics.field_count > 1) model->solver.symmetric = PETSC_FALSE;
  model->disc.diagonal = stiffest * PetscPowRealInt(model->disc.grid.h[0], model->disc.grid.dim - 2);
  PetscCall(MpmOptionsBlocks(options, "bodies",
                             "names of the body blocks; bodies must not overlap, and are welded where they share "
                             "nodes",
                             MPM_REQUIRED, &model->scene.bodies.count, &model->scene.bodies.names));
  PetscCall(PetscCalloc1(model->scene.bodies.count, &model->scene.bodies.at));
  for (PetscInt b = 0; b < model->scene.bodies.count; b++) {
    PetscCall(MpmBodyCreate(options, model->scene.bodies.names[b], &model->disc.grid, model->scene.materials.count,
                            model->scene.materials.at, &model->scene.bodies.at[b]));
    MpmMaterial *material = &model->scene.materials.at[MpmBodyMaterial(model->scene.bodies.at[b])];

    material->spacing = PetscMax(material->spacing, MpmBodySpacing(model->scene.bodies.at[b]));
  }
  PetscCall(MpmMemoryCheck(options, &model->disc.grid, model->scene.bodies.count, model->scene.bodies.at,
                           model->scene.bodies.names));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reactions are columns by name: a boundary must not be called like a condition. */
static PetscErrorCode ReadBoundaries(MpmModel model, const MpmOptions *options)
{
  PetscFunctionBeginUser;
  PetscCall(MpmOptionsBlocks(options, "boundaries", "names of the boundaries that do not follow the grid", MPM_OPTIONAL,
                             &model->scene.boundaries.count, &model->scene.boundaries.names));
  PetscCall(PetscCalloc1(model->scene.boundaries.count, &model->scene.boundaries.at));
  for (PetscInt k = 0; k < model->scene.boundaries.count; k++) {
    for (PetscInt b = 0; b < model->scene.bcs.count && !MpmOptionsHelp(); b++) {
      MpmCheckInput(strcmp(model->scene.boundaries.names[k], model->scene.bcs.names[b]),
                    "-mpm_boundaries %s: there is a condition of this name", model->scene.boundaries.names[k]);
    }
    PetscCall(
      MpmBoundaryCreate(options, model->scene.boundaries.names[k], &model->disc.grid, &model->scene.boundaries.at[k]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadConditions(MpmModel model, const MpmOptions *options)
{
  PetscFunctionBeginUser;
  PetscCall(MpmOptionsBlocks(options, "bcs", "names of the conditions on nodes", MPM_OPTIONAL, &model->scene.bcs.count,
                             &model->scene.bcs.names));
  PetscCall(MpmOptionsBlocks(options, "loads", "names of the loads", MPM_OPTIONAL, &model->scene.loads.count,
                             &model->scene.loads.names));
  PetscCall(MpmStagesReadLists(model, options));
  PetscCall(PetscCalloc1(model->scene.bcs.count, &model->scene.bcs.at));
  PetscCall(PetscMalloc1((model->scene.bcs.count * 2 * MPM_MAX_BLOCK), &model->scene.walls.at));
  for (PetscInt b = 0; b < model->scene.bcs.count; b++)
    PetscCall(MpmConditionCreate(options, model->scene.bcs.names[b], &model->disc.grid, &model->disc.layout,
                                 &model->scene.bcs.at[b]));
  PetscCall(PetscCalloc1((model->scene.bcs.count * model->disc.layout.block), &model->disc.reaction));
  PetscCall(ReadBoundaries(model, options));
  PetscCall(PetscCalloc1(model->scene.loads.count, &model->scene.loads.at));
  for (PetscInt l = 0; l < model->scene.loads.count; l++) {
    PetscCall(MpmLoadCreate(options, model->scene.loads.names[l], &model->disc.grid, &model->scene.loads.at[l]));
    for (PetscInt m = 0;
         model->scene.loads.at[l].type == MPM_LOAD_GRAVITY && m < model->scene.materials.count && !MpmOptionsHelp();
         m++) {
      MpmCheckInput(model->scene.materials.at[m].density > 0.,
                    "-mpm_material_%s_density is missing: load %s is gravity", model->scene.materials.names[m],
                    model->scene.loads.names[l]);
    }
  }
  PetscCall(MpmOptionsBlocks(options, "tracks", "names of the followed sets of points", MPM_OPTIONAL,
                             &model->results->tracks.count, &model->results->tracks.names));
  PetscCall(PetscCalloc1(model->results->tracks.count, &model->results->tracks.at));
  for (PetscInt t = 0; t < model->results->tracks.count; t++) {
    PetscCall(
      MpmTrackCreate(options, model->results->tracks.names[t], &model->disc.grid, &model->results->tracks.at[t]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes the points, hands them to their ranks, and finds those that carry loads and are tracked. */
static PetscErrorCode CreateParticles(MpmModel model)
{
  PetscInt  state_size = 0, extra = 0;
  PetscBool half_length =
    (PetscBool)(MpmShapeHasDomain(model->scene.shape) || model->scene.boundaries.count || MpmStagesAreGeostatic(model));
  const char *why;
  char      **fields;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(
    (model->scene.loads.count + model->results->tracks.count + model->scene.boundaries.count * MPM_MAX_DIM), &fields));
  for (PetscInt m = 0; m < model->scene.materials.count; m++)
    state_size = PetscMax(state_size, model->scene.materials.at[m].state_size);
  for (PetscInt l = 0; l < model->scene.loads.count; l++) {
    if (model->scene.loads.at[l].type == MPM_LOAD_TRACTION) half_length = PETSC_TRUE;
    if (model->scene.loads.at[l].share_field) fields[extra++] = model->scene.loads.at[l].share_field;
  }
  for (PetscInt t = 0; t < model->results->tracks.count; t++)
    fields[extra++] = model->results->tracks.at[t].share_field;
  for (PetscInt k = 0; k < model->scene.boundaries.count; k++)
    for (PetscInt a = 0; model->scene.boundaries.at[k].stick && a < model->disc.grid.dim; a++)
      fields[extra++] = model->scene.boundaries.at[k].slip_field[a];

  model->state.particles.has_mass = MpmStagesKeepMass(model);
  for (PetscInt b = 0; b < model->scene.bodies.count; b++)
    if (MpmBodyIsImported(model->scene.bodies.at[b])) model->state.particles.has_mass = PETSC_TRUE;
  PetscCall(MpmParticlesCreate(
    &model->disc.grid,
    &(MpmParticleFields){state_size, model->disc.layout.rates, half_length, model->state.predict, extra, fields},
    &model->state.particles));
  PetscCall(PetscFree(fields));
  /* a run that goes on needs the bodies only where later stages bring or change them */
  if (model->results->checkpoint.restart && !model->scene.stages[0].name) {
    PetscCall(MpmRestartReadPoints(model));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(MpmBodiesShareEdges(model));
  PetscCall(MpmBodiesGenerate(model->scene.bodies.count, model->scene.bodies.at, model->scene.materials.at,
                              &model->disc.grid, &model->state.particles));
  PetscCall(MpmParticlesDistribute(&model->state.particles, &model->disc.grid, &why));
  MpmCheckInput(!why, "-mpm_bodies: %s", why);
  PetscCall(MpmBodiesCheckOverlap(model));
  for (PetscInt k = 0; k < model->scene.boundaries.count; k++)
    PetscCall(MpmBoundaryCheck(&model->scene.boundaries.at[k], &model->disc.grid, &model->state.particles));
  for (PetscInt t = 0; t < model->results->tracks.count; t++)
    PetscCall(MpmTrackSelect(&model->results->tracks.at[t], &model->disc.grid, &model->state.particles));
  PetscCall(MpmStagesSelect(model));
  if (model->results->checkpoint.restart) PetscCall(MpmRestartReadPoints(model));
  else PetscCall(MpmStageBegin(model, 0));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* About how many unknowns the material needs: the cells that its volume fills, and as many nodes. */
static PetscErrorCode EstimateUnknowns(MpmModel model, PetscReal *unknowns)
{
  PetscReal volume = 0.;
  MpmPoints points;

  PetscFunctionBeginUser;
  PetscCall(MpmParticlesGetArrays(&model->state.particles, &points));
  for (PetscInt p = 0; p < points.count; p++) volume += points.volume0[p];
  PetscCall(MpmParticlesRestoreArrays(&model->state.particles, &points));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &volume, 1, MPIU_REAL, MPIU_SUM, model->comm));
  for (PetscInt a = 0; a < model->disc.grid.dim; a++) volume /= model->disc.grid.h[a];
  *unknowns = volume * (PetscReal)model->disc.layout.block;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmModelSetFromOptions(MpmModel model)
{
  const MpmOptions options = {model->comm, "mpm_", model->record};
  PetscLogDouble   since;
  PetscReal        unknowns;

  PetscFunctionBeginUser;
  PetscCall(MpmMonitorBegin(&model->monitor, MPM_TIME_SETUP, &since));
  PetscCall(ReadKind(model, &options));
  PetscCall(MpmGridSetFromOptions(&model->disc.grid, &options, model->disc.layout.dim));
  PetscCall(ReadMaterialsAndBodies(model, &options));
  PetscCall(ReadConditions(model, &options));
  PetscCall(MpmStagesRead(model, &options));
  PetscCall(MpmStabilizationSettle(model));
  PetscCall(ReadOutput(model, &options));
  PetscCall(MpmCheckpointSetFromOptions(model, &options));
  PetscCall(MpmSolverSetFromOptions(&model->solver, &options));
  if (MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmOptionsCheckUnknown(&options));
  PetscCall(MpmSignalsCatch());
  PetscCall(MpmRestartOpen(model));
  PetscCall(CreateParticles(model));
  PetscCall(MpmDiscretizationSetUp(&model->disc, &model->scene.materials, &model->scene.boundaries,
                                   model->scene.physics.parameters, model->state.particles.state_size));
  PetscCall(MpmCheckpointKeepOptions(model, &options));
  PetscCall(EstimateUnknowns(model, &unknowns));
  PetscCall(MpmSolverChoose(&model->solver, unknowns));
  PetscCall(MpmRestartApply(model));
  PetscCall(MpmMonitorEnd(&model->monitor, MPM_TIME_SETUP, since));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the run ---- */

/* Result files, new or those of the run that goes on; a new one starts with the present state. */
static PetscErrorCode OpenResults(MpmModel model)
{
  PetscFunctionBeginUser;
  if (model->results->output_every) {
    PetscCall(MpmOutputCreate(model->comm, model->scene.prefix, &model->results->output));
    PetscCall(MpmOutputSetSingle(model->results->output, model->results->output_single));
  }
  if (model->results->output && model->results->checkpoint.restart) PetscCall(MpmRestartOutput(model, PETSC_FALSE));
  PetscCall(MpmModelCreateHistory(model));
  if (model->results->output && model->results->checkpoint.restart) PetscCall(MpmRestartOutput(model, PETSC_TRUE));
  if (model->results->output && !MpmOutputStarted(model->results->output)) PetscCall(MpmModelWriteOutput(model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode WarnUnused(MpmModel model, MpmMoment moment)
{
  const MpmOptions options = {model->comm, NULL, model->record};

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsWarnUnused(&options, moment));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* What a converged step leaves: its row, its line, and at times the points. */
static PetscErrorCode Report(MpmModel model, PetscReal dt)
{
  PetscFunctionBeginUser;
  PetscCall(MpmModelWriteHistory(model, dt));
  PetscCall(MpmTerminalStep(model, dt));
  if (model->solver.linear_total) PetscCall(WarnUnused(model, MPM_AFTER_SOLVE));
  if (model->results->output_every && (model->state.step % model->results->output_every == 0))
    PetscCall(MpmModelWriteOutput(model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* What is left of the stage under way; a geostatic one is a single step for the results. `stop`: by a signal. */
static PetscErrorCode RunStage(MpmModel model, PetscBool *stop, const char **why)
{
  const MpmStage *stage = &model->scene.stages[model->state.stage];
  PetscReal       dt    = 0.;

  PetscFunctionBeginUser;
  while (!*stop && model->state.time < model->state.time_end * (1. - 1e-12)) {
    if (stage->name && model->state.time == model->state.time_start)
      PetscCall(MpmMonitorNote(&model->monitor, "stage %s", stage->name));
    if (stage->geostatic.method != MPM_GEOSTATIC_NONE) {
      PetscCall(MpmGeostaticRun(model, why));
      dt = model->state.time - model->state.time_start;
    } else PetscCall(MpmAdvance(model, &dt, why));
    if (*why) break;
    PetscCall(Report(model, dt));
    PetscCall(MpmCheckpointStep(model, stop));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmModelRun(MpmModel model, int *status)
{
  const char *why = NULL;
  PetscBool   stop;

  PetscFunctionBeginUser;
  *status = 0;
  PetscCall(MpmTerminalBegin(model));
  PetscCall(OpenResults(model));
  PetscCall(MpmCheckpointStep(model, &stop));
  PetscCall(RunStage(model, &stop, &why));
  while (!why && !stop && model->state.stage + 1 < model->scene.stage_count) {
    PetscCall(MpmStageBegin(model, model->state.stage + 1));
    PetscCall(RunStage(model, &stop, &why));
  }
  PetscCall(MpmParticlesRestoreArrays(&model->state.particles, &model->disc.points));
  if (why && !model->state.particles.gone) PetscCall(MpmCheckpointWrite(model));
  if (!stop && model->results->output_every && model->results->output_step != model->state.step &&
      !model->state.particles.gone)
    PetscCall(MpmModelWriteOutput(model));
  if (why) {
    *status = MPM_EXIT_GAVEUP;
    PetscCall(PetscFPrintf(model->comm, stderr, "talus: gave up after step %" PetscInt_FMT " at time %g: %s\n",
                           model->state.step, (double)model->state.time, why));
  }
  PetscCall(MpmModelWriteSummary(model, why ? why : stop ? "interrupted" : "completed"));
  PetscCall(WarnUnused(model, MPM_AT_END));
  PetscCall(MpmSignalsRelease());
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  The model: the scene read from options, and the loop over steps.
*/
#include "mpmimpl.h"
#include "optionsimpl.h"

const char *const MpmJacobianTypes[] = {"auto", "local", "coloring", "matfree", "dense", "fd", NULL};

PetscErrorCode MpmModelCreate(MPI_Comm comm, MpmModel *model)
{
  PetscFunctionBeginUser;
  PetscCall(PetscNew(model));
  PetscCall(PetscCommDuplicate(comm, &(*model)->comm, NULL));
  PetscCallMPI(MPI_Comm_rank(comm, &(*model)->rank));
  PetscCallMPI(MPI_Comm_size(comm, &(*model)->size));
  PetscCall(MpmRecordCreate(&(*model)->record));
  {
    PetscLogDouble now;

    PetscCall(PetscTime(&now));
    (*model)->start = now;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmModelSetPhysics(MpmModel model, const MpmPhysics *physics)
{
  PetscFunctionBeginUser;
  model->physics = *physics;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmModelSetBodyForce(MpmModel model, MpmBodyForce force, void *ctx)
{
  PetscFunctionBeginUser;
  model->body_force     = force;
  model->body_force_ctx = ctx;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmModelDestroy(MpmModel *handle)
{
  MpmModel model = *handle;

  PetscFunctionBeginUser;
  if (!model) PetscFunctionReturn(PETSC_SUCCESS);
  if (model->particles.swarm) PetscCall(MpmParticlesRestoreArrays(&model->particles, &model->points));
  PetscCall(MpmSolverDestroy(model));
  PetscCall(MpmPatternReset(&model->pattern));
  PetscCall(MpmSpaceReset(&model->space));
  PetscCall(MpmConstraintsReset(&model->constraints));
  PetscCall(PetscFree3(model->u, model->residual, model->force));
  PetscCall(MpmTrialReset(&model->trial));
  PetscCall(PetscFree(model->reaction));
  PetscCall(PetscFree(model->history_row));
  PetscCall(MpmCheckpointDestroy(&model->checkpoint));
  PetscCall(MpmOutputDestroy(&model->output));
  PetscCall(MpmHistoryDestroy(&model->history));
  PetscCall(MpmParticlesDestroy(&model->particles));
  PetscCall(MpmGridDestroy(&model->grid));
  for (PetscInt k = 0; model->materials && k < model->material_count; k++)
    PetscCall(MpmMaterialDestroy(&model->materials[k]));
  for (PetscInt k = 0; model->bodies && k < model->body_count; k++) PetscCall(MpmBodyDestroy(&model->bodies[k]));
  for (PetscInt k = 0; model->bcs && k < model->bc_count; k++) PetscCall(MpmConditionDestroy(&model->bcs[k]));
  for (PetscInt k = 0; model->boundaries && k < model->boundary_count; k++)
    PetscCall(MpmBoundaryDestroy(&model->boundaries[k]));
  PetscCall(MpmContactsDestroy(&model->contacts));
  for (PetscInt k = 0; model->loads && k < model->load_count; k++) PetscCall(MpmLoadDestroy(&model->loads[k]));
  for (PetscInt k = 0; model->tracks && k < model->track_count; k++) PetscCall(MpmTrackDestroy(&model->tracks[k]));
  PetscCall(PetscFree(model->materials));
  PetscCall(PetscFree(model->bodies));
  PetscCall(PetscFree(model->bcs));
  PetscCall(PetscFree(model->boundaries));
  PetscCall(PetscFree(model->loads));
  PetscCall(PetscFree(model->tracks));
  PetscCall(PetscFree(model->walls));
  PetscCall(MpmStagesDestroy(model));
  PetscCall(MpmNamesDestroy(model->material_count, &model->material_names));
  PetscCall(MpmNamesDestroy(model->body_count, &model->body_names));
  PetscCall(MpmNamesDestroy(model->bc_count, &model->bc_names));
  PetscCall(MpmNamesDestroy(model->boundary_count, &model->boundary_names));
  PetscCall(MpmNamesDestroy(model->load_count, &model->load_names));
  PetscCall(MpmNamesDestroy(model->track_count, &model->track_names));
  PetscCall(MpmNamesDestroy(model->output_field_count, &model->output_fields));
  PetscCall(PetscFree(model->title));
  PetscCall(PetscFree(model->prefix));
  PetscCall(MpmRecordDestroy(&model->record));
  PetscCall(PetscCommDestroy(&model->comm));
  PetscCall(PetscFree(*handle));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the scene ---- */

PetscErrorCode MpmModelReadNames(const MpmOptions *options, const char *list, const char *help, MpmNeed need,
                                 PetscInt *count, char ***names)
{
  PetscFunctionBeginUser;
  PetscCall(MpmOptionsHeading(options, list));
  PetscCall(MpmOptionsNames(options, list, help, need, count, names));
  if (*count || !MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  *count = 1;
  PetscCall(PetscMalloc1(1, names));
  PetscCall(PetscStrallocpy("NAME", *names));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The physics of that name, and the layout of its unknowns. */
static PetscErrorCode CreatePhysics(MpmModel model, const char *name, PetscInt dim)
{
  PetscBool found = PETSC_TRUE, solid;

  PetscFunctionBeginUser;
  PetscCall(PetscStrcmp(name, "solid", &solid));
  if (!model->physics.name) {
    MpmCheckInput(solid, "-mpm_physics %s: must be one of solid", name);
    PetscCall(MpmPhysicsCreate(name, &model->physics, &found));
    PetscCheck(found, model->comm, PETSC_ERR_PLIB, "physics %s is not compiled in", name);
  }
  PetscCall(MpmLayoutCreate(&model->physics, dim, &model->layout));
  model->stretch = MpmStretchFind(dim);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Dimension, physics, shape: what everything else depends on. */
static PetscErrorCode ReadKind(MpmModel model, const MpmOptions *options)
{
  char    *name;
  PetscInt dim = 2, shape = MPM_SHAPE_GIMP, edge = MPM_EDGE_LINEAR, jacobian = MPM_JACOBIAN_AUTO;

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsHeading(options, "Scene"));
  PetscCall(MpmOptionsText(options, "title", "free text for the log", "", MPM_OPTIONAL, &model->title));
  PetscCall(MpmOptionsInt(options, "dim", "dimension: 2 (plane strain) or 3", 2, 3, MPM_REQUIRED, &dim, NULL));
  PetscCall(MpmOptionsText(options, "physics", "what is solved: solid", "solid", MPM_OPTIONAL, &name));
  PetscCall(MpmOptionsWord(options, "shape", "shape functions", MpmShapeTypes, MPM_OPTIONAL, &shape, NULL));
  model->shape = (MpmShapeType)shape;
  PetscCall(MpmOptionsWord(options, "shape_edge", "how splines end at the grid's edges and at walls", MpmEdgeTypes,
                           MPM_OPTIONAL, &edge, NULL));
  model->edge = (MpmEdgeType)edge;
  PetscCall(
    MpmOptionsWord(options, "jacobian", "how the Jacobian is made", MpmJacobianTypes, MPM_OPTIONAL, &jacobian, NULL));
  model->jacobian_type = jacobian == MPM_JACOBIAN_AUTO ? MPM_JACOBIAN_LOCAL : (MpmJacobianType)jacobian;
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
  MpmCheckInput(model->prefix[0] && strlen(model->prefix) < sizeof(folder) - 64,
                "-mpm_output_prefix: must be a name of 1 to %d characters", (int)sizeof(folder) - 65);
  slash  = strrchr(model->prefix, '/');
  length = strlen(slash ? slash + 1 : model->prefix);
  MpmCheckInput(length > 0 && length <= 200,
                "-mpm_output_prefix: the name behind the folder has %d characters, must have 1 to 200", (int)length);
  if (slash) PetscCall(PetscStrncpy(folder, model->prefix, (size_t)(slash - model->prefix) + 2));
  PetscCall(PetscTestDirectory(folder, 'w', &there));
  MpmCheckInput(there, "-mpm_output_prefix %s: the folder %s is not there or cannot be written", model->prefix, folder);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadOutput(MpmModel model, const MpmOptions *options)
{
  const MpmOptions block = {options->comm, "mpm_output_", options->record};

  PetscFunctionBeginUser;
  model->output_every = 1;
  PetscCall(MpmOptionsHeading(&block, "Output"));
  PetscCall(MpmOptionsText(&block, "prefix", "results are named after it", "talus", MPM_OPTIONAL, &model->prefix));
  PetscCall(CheckPrefix(model));
  PetscCall(MpmOptionsInt(&block, "every", "steps between written states; 0: none but the history and the summary", 0,
                          PETSC_INT_MAX, MPM_OPTIONAL, &model->output_every, NULL));
  PetscCall(MpmOutputSetFromOptions(model, &block));
  PetscCall(MpmOptionsBool(options, "quiet", "no lines but errors on the terminal", &model->quiet, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadMaterialsAndBodies(MpmModel model, const MpmOptions *options)
{
  PetscReal stiffest = 0.;

  PetscFunctionBeginUser;
  PetscCall(MpmModelReadNames(options, "materials", "names of the material blocks", MPM_REQUIRED,
                              &model->material_count, &model->material_names));
  PetscCall(PetscCalloc1(model->material_count, &model->materials));
  model->symmetric = PETSC_TRUE;
  for (PetscInt m = 0; m < model->material_count; m++) {
    PetscCall(MpmMaterialCreate(options, model->material_names[m], model->grid.dim, &model->materials[m]));
    if (!(model->materials[m].info.traits & MPM_LAW_SYMMETRIC)) model->symmetric = PETSC_FALSE;
    stiffest = PetscMax(stiffest, model->materials[m].stiffness);
  }
  if (model->physics.field_count > 1) model->symmetric = PETSC_FALSE;
  model->diagonal = stiffest * PetscPowRealInt(model->grid.h[0], model->grid.dim - 2);
  PetscCall(MpmModelReadNames(options, "bodies",
                              "names of the body blocks; bodies must not overlap, and are welded where they share "
                              "nodes",
                              MPM_REQUIRED, &model->body_count, &model->body_names));
  PetscCall(PetscCalloc1(model->body_count, &model->bodies));
  for (PetscInt b = 0; b < model->body_count; b++) {
    PetscCall(MpmBodyCreate(options, model->body_names[b], &model->grid, model->material_count, model->materials,
                            &model->bodies[b]));
    MpmMaterial *material = &model->materials[MpmBodyMaterial(model->bodies[b])];

    material->spacing = PetscMax(material->spacing, MpmBodySpacing(model->bodies[b]));
  }
  PetscCall(MpmMemoryCheck(options, &model->grid, model->body_count, model->bodies, model->body_names));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reactions are columns by name: a boundary must not be called like a condition. */
static PetscErrorCode ReadBoundaries(MpmModel model, const MpmOptions *options)
{
  PetscFunctionBeginUser;
  PetscCall(MpmModelReadNames(options, "boundaries", "names of the boundaries that do not follow the grid",
                              MPM_OPTIONAL, &model->boundary_count, &model->boundary_names));
  PetscCall(PetscCalloc1(model->boundary_count, &model->boundaries));
  for (PetscInt k = 0; k < model->boundary_count; k++) {
    for (PetscInt b = 0; b < model->bc_count && !MpmOptionsHelp(); b++) {
      MpmCheckInput(strcmp(model->boundary_names[k], model->bc_names[b]),
                    "-mpm_boundaries %s: there is a condition of this name", model->boundary_names[k]);
    }
    PetscCall(MpmBoundaryCreate(options, model->boundary_names[k], &model->grid, &model->boundaries[k]));
  }
  PetscCall(MpmContactsCreate(model->boundary_count, model->boundaries, &model->contacts));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadConditions(MpmModel model, const MpmOptions *options)
{
  PetscFunctionBeginUser;
  PetscCall(MpmModelReadNames(options, "bcs", "names of the conditions on nodes", MPM_OPTIONAL, &model->bc_count,
                              &model->bc_names));
  PetscCall(
    MpmModelReadNames(options, "loads", "names of the loads", MPM_OPTIONAL, &model->load_count, &model->load_names));
  PetscCall(MpmStagesReadLists(model, options));
  PetscCall(PetscCalloc1(model->bc_count, &model->bcs));
  PetscCall(PetscMalloc1((model->bc_count * 2 * MPM_MAX_BLOCK), &model->walls));
  for (PetscInt b = 0; b < model->bc_count; b++)
    PetscCall(MpmConditionCreate(options, model->bc_names[b], &model->grid, &model->layout, &model->bcs[b]));
  PetscCall(PetscCalloc1((model->bc_count * model->layout.block), &model->reaction));
  PetscCall(ReadBoundaries(model, options));
  PetscCall(PetscCalloc1(model->load_count, &model->loads));
  for (PetscInt l = 0; l < model->load_count; l++) {
    PetscCall(MpmLoadCreate(options, model->load_names[l], &model->grid, &model->loads[l]));
    for (PetscInt m = 0; model->loads[l].type == MPM_LOAD_GRAVITY && m < model->material_count && !MpmOptionsHelp();
         m++) {
      MpmCheckInput(model->materials[m].density > 0., "-mpm_material_%s_density is missing: load %s is gravity",
                    model->material_names[m], model->load_names[l]);
    }
  }
  PetscCall(MpmModelReadNames(options, "tracks", "names of the followed sets of points", MPM_OPTIONAL,
                              &model->track_count, &model->track_names));
  PetscCall(PetscCalloc1(model->track_count, &model->tracks));
  for (PetscInt t = 0; t < model->track_count; t++) {
    PetscCall(MpmTrackCreate(options, model->track_names[t], &model->grid, &model->tracks[t]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes the points, hands them to their ranks, and finds those that carry loads and are tracked. */
static PetscErrorCode CreateParticles(MpmModel model)
{
  PetscInt  state_size = 0, extra = 0;
  PetscBool half_length =
    (PetscBool)(MpmShapeHasDomain(model->shape) || model->boundary_count || MpmStagesAreGeostatic(model));
  const char *why;
  char      **fields;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1((model->load_count + model->track_count + model->boundary_count * MPM_MAX_DIM), &fields));
  for (PetscInt m = 0; m < model->material_count; m++)
    state_size = PetscMax(state_size, model->materials[m].state_size);
  for (PetscInt l = 0; l < model->load_count; l++) {
    if (model->loads[l].type == MPM_LOAD_TRACTION) half_length = PETSC_TRUE;
    if (model->loads[l].share_field) fields[extra++] = model->loads[l].share_field;
  }
  for (PetscInt t = 0; t < model->track_count; t++) fields[extra++] = model->tracks[t].share_field;
  for (PetscInt k = 0; k < model->boundary_count; k++)
    for (PetscInt a = 0; model->boundaries[k].stick && a < model->grid.dim; a++)
      fields[extra++] = model->boundaries[k].slip_field[a];

  model->particles.has_mass = MpmStagesKeepMass(model);
  for (PetscInt b = 0; b < model->body_count; b++)
    if (MpmBodyIsImported(model->bodies[b])) model->particles.has_mass = PETSC_TRUE;
  PetscCall(MpmParticlesCreate(&model->grid, state_size, model->layout.rates, half_length, model->predict, extra,
                               fields, &model->particles));
  PetscCall(PetscFree(fields));
  /* a run that goes on needs the bodies only where later stages bring or change them */
  if (model->checkpoint.restart && !model->stages[0].name) {
    PetscCall(MpmRestartReadPoints(model));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(MpmBodiesShareEdges(model));
  PetscCall(MpmBodiesGenerate(model->body_count, model->bodies, model->materials, &model->grid, &model->particles));
  PetscCall(MpmParticlesDistribute(&model->particles, &model->grid, &why));
  MpmCheckInput(!why, "-mpm_bodies: %s", why);
  PetscCall(MpmBodiesCheckOverlap(model));
  for (PetscInt k = 0; k < model->boundary_count; k++)
    PetscCall(MpmBoundaryCheck(&model->boundaries[k], &model->grid, &model->particles));
  for (PetscInt t = 0; t < model->track_count; t++)
    PetscCall(MpmTrackSelect(&model->tracks[t], &model->grid, &model->particles));
  PetscCall(MpmStagesSelect(model));
  if (model->checkpoint.restart) PetscCall(MpmRestartReadPoints(model));
  else PetscCall(MpmStageBegin(model, 0));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmModelSetFromOptions(MpmModel model)
{
  const MpmOptions options = {model->comm, "mpm_", model->record};
  PetscLogDouble   since;

  PetscFunctionBeginUser;
  PetscCall(PetscTime(&since));
  PetscCall(ReadKind(model, &options));
  PetscCall(MpmGridSetFromOptions(&model->grid, &options, model->layout.dim));
  PetscCall(ReadMaterialsAndBodies(model, &options));
  PetscCall(ReadConditions(model, &options));
  PetscCall(MpmStagesRead(model, &options));
  PetscCall(MpmStabilizationSettle(model));
  PetscCall(ReadOutput(model, &options));
  PetscCall(MpmCheckpointSetFromOptions(model, &options));
  PetscCall(MpmSolverSetFromOptions(model, &options));
  if (MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmOptionsCheckUnknown(&options));
  PetscCall(MpmSignalsCatch());
  PetscCall(MpmRestartOpen(model));
  PetscCall(CreateParticles(model));
  PetscCall(MpmCheckpointKeepOptions(model, &options));
  PetscCall(MpmSolverChoose(model));
  PetscCall(MpmRestartApply(model));
  MpmClock(model, MPM_TIME_SETUP, since);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the run ---- */

/* The end of the step that starts now: multiples of the nominal step are met exactly, and so is the end of the run. */
static PetscReal NextTime(MpmModel model, PetscReal dt, PetscReal *step)
{
  const PetscReal small  = 1e-9 * model->dt_nominal;
  PetscReal       target = model->time_end, next;

  if (!model->adaptive) {
    target = model->time_start +
             model->dt_nominal * PetscFloorReal((model->time - model->time_start + small) / model->dt_nominal + 1.);
    if (target > model->time_end - small) target = model->time_end;
  }
  next  = model->time + dt > target - PetscMax(small, 1e-3 * dt) ? target : model->time + dt;
  *step = next - model->time;
  return next;
}

/* After an easy step the next one is longer; after a hard one, when adaptive, it stays. */
static PetscReal NextLength(MpmModel model, PetscReal dt, PetscReal wanted)
{
  if (!model->adaptive) return PetscMin(wanted * model->growth, model->dt_nominal);
  if (dt < 0.99 * wanted) return wanted; /* the end of the run cut it short */
  return model->newton <= 6 ? PetscMin(wanted * model->growth, model->dt_max) : wanted;
}

/* One step, cut as often as needed. `why` tells the reason when it was given up. */
static PetscErrorCode Advance(MpmModel model, PetscReal *dt, const char **why)
{
  PetscReal      next;
  PetscBool      hopeless, again = PETSC_FALSE;
  PetscLogDouble since;

  PetscFunctionBeginUser;
  PetscCall(PetscTime(&since));
  PetscCall(MpmParticlesDistribute(&model->particles, &model->grid, why));
  MpmClock(model, MPM_TIME_MIGRATE, since);
  if (*why) PetscFunctionReturn(PETSC_SUCCESS);
  model->cuts = 0;
  for (;;) {
    next = NextTime(model, model->dt_wanted, dt);
    PetscCall(MpmStep(model, next, *dt, again, why, &hopeless));
    if (!*why) break;
    if (hopeless) PetscFunctionReturn(PETSC_SUCCESS);
    again = (PetscBool)(0.5 * *dt >= model->dt_min);
    if (!again) {
      if (!model->ghost_rescue) PetscFunctionReturn(PETSC_SUCCESS);
      PetscCall(MpmStabilizationRaiseGhost(model, *why));
      model->dt_wanted = model->dt_nominal;
      continue;
    }
    model->dt_wanted = 0.5 * *dt;
    model->cuts++;
    model->cuts_total++;
    PetscCall(MpmTerminalNote(model, "%s; the step is cut to %.4g", *why, (double)model->dt_wanted));
  }
  model->time = next;
  model->step++;
  model->dt_wanted = NextLength(model, *dt, model->dt_wanted);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Result files, new or those of the run that goes on; a new one starts with the present state. */
static PetscErrorCode OpenResults(MpmModel model)
{
  PetscFunctionBeginUser;
  if (model->output_every) {
    PetscCall(MpmOutputCreate(model->comm, model->prefix, &model->output));
    PetscCall(MpmOutputSetSingle(model->output, model->output_single));
  }
  if (model->output && model->checkpoint.restart) PetscCall(MpmRestartOutput(model, PETSC_FALSE));
  PetscCall(MpmModelCreateHistory(model));
  if (model->output && model->checkpoint.restart) PetscCall(MpmRestartOutput(model, PETSC_TRUE));
  if (model->output && !MpmOutputStarted(model->output)) PetscCall(MpmModelWriteOutput(model));
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
  if (model->linear_total) PetscCall(WarnUnused(model, MPM_AFTER_SOLVE));
  if (model->output_every && (model->step % model->output_every == 0)) PetscCall(MpmModelWriteOutput(model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* What is left of the stage under way; a geostatic one is a single step for the results. `stop`: by a signal. */
static PetscErrorCode RunStage(MpmModel model, PetscBool *stop, const char **why)
{
  const MpmStage *stage = &model->stages[model->stage];
  PetscReal       dt    = 0.;

  PetscFunctionBeginUser;
  while (!*stop && model->time < model->time_end * (1. - 1e-12)) {
    if (stage->name && model->time == model->time_start) PetscCall(MpmTerminalNote(model, "stage %s", stage->name));
    if (stage->geostatic.method != MPM_GEOSTATIC_NONE) {
      PetscCall(MpmGeostaticRun(model, why));
      dt = model->time - model->time_start;
    } else PetscCall(Advance(model, &dt, why));
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
  while (!why && !stop && model->stage + 1 < model->stage_count) {
    PetscCall(MpmStageBegin(model, model->stage + 1));
    PetscCall(RunStage(model, &stop, &why));
  }
  PetscCall(MpmParticlesRestoreArrays(&model->particles, &model->points));
  if (why && !model->particles.gone) PetscCall(MpmCheckpointWrite(model));
  if (!stop && model->output_every && model->output_step != model->step && !model->particles.gone)
    PetscCall(MpmModelWriteOutput(model));
  if (why) {
    *status = MPM_EXIT_GAVEUP;
    PetscCall(PetscFPrintf(model->comm, stderr, "talus: gave up after step %" PetscInt_FMT " at time %g: %s\n",
                           model->step, (double)model->time, why));
  }
  PetscCall(MpmModelWriteSummary(model, why ? why : stop ? "interrupted" : "completed"));
  PetscCall(WarnUnused(model, MPM_AT_END));
  PetscCall(MpmSignalsRelease());
  PetscFunctionReturn(PETSC_SUCCESS);
}

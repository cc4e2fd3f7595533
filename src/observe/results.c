/*
  Data of the model for its writers: points, history, summary.
*/
#include "options/options.h"
#include "point/layout.h"
#include "grid/grid.h"
#include "grid/shape.h"
#include "particles/body.h"
#include "particles/particles.h"
#include "bc/bc.h"
#include "bc/body_motion.h"
#include "pairs/body_contact.h"
#include "contact/contact.h"
#include "contact/rigid_body.h"
#include "loads/body_surface.h"
#include "loads/load.h"
#include "query/model.h"
#include "query/query.h"
#include "observe/lines.h"
#include "observe/motion_columns.h"
#include "observe/results.h"
#include "observe/tracks.h"

static PetscErrorCode ResultPath(MpmModel model, const char *suffix, char path[], size_t size)
{
  PetscFunctionBeginUser;
  PetscCall(PetscSNPrintf(path, size, "%s%s", model->scene.prefix, suffix));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- states ---- */

PetscErrorCode MpmOutputSetFromOptions(MpmModel model, const MpmOptions *block)
{
  static const char *const words[]   = {"double", "single", NULL};
  const MpmRow             row       = {"output_step", MPM_ROW_INT, MPM_ROW_RUN, &model->results->output_step, 0, 0};
  PetscInt                 precision = 0;

  PetscFunctionBeginUser;
  PetscCall(MpmRowsAdd(model->state.rows, NULL, 1, &row));
  PetscCall(MpmOptionsBool(block, "grid", "write the grid too: its active nodes and cells",
                           &model->results->output_grid, NULL));
  PetscCall(MpmOptionsWord(block, "precision", "of the reals that are written", words, MPM_OPTIONAL, &precision, NULL));
  model->results->output_single = (PetscBool)(precision == 1);
  PetscCall(MpmOptionsNames(block, "fields",
                            "fields of the points that are written besides id and position; default: all", MPM_OPTIONAL,
                            &model->results->output_field_count, &model->results->output_fields));
  if (!MpmOptionsHelp()) PetscCall(MpmFieldsCheck(model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmModelWriteGrid(MpmModel model)
{
  PetscLogDouble since;

  PetscFunctionBeginUser;
  if (!model->results->output_grid) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmMonitorBegin(&model->monitor, MPM_TIME_OUTPUT, &since));
  PetscCall(MpmLatticeWrite(model));
  PetscCall(MpmMonitorEnd(&model->monitor, MPM_TIME_OUTPUT, since));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmModelWriteState(MpmModel model)
{
  PetscLogDouble since;

  PetscFunctionBeginUser;
  PetscCall(MpmMonitorBegin(&model->monitor, MPM_TIME_OUTPUT, &since));
  PetscCall(MpmFieldsWrite(model));
  model->results->output_step = model->state.step;
  PetscCall(MpmMonitorEnd(&model->monitor, MPM_TIME_OUTPUT, since));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- history ---- */

/* "moment_pile_z" */
static PetscErrorCode AddColumn(const char *quantity, const char *of, PetscInt axis, PetscInt *count, char **names)
{
  char name[512];

  PetscFunctionBeginUser;
  PetscCall(PetscSNPrintf(name, sizeof(name), "%s_%s_%c", quantity, of, "xyz"[axis]));
  PetscCall(PetscStrallocpy(name, &names[(*count)++]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A component of a condition as columns name it. */
static const char *ComponentName(const MpmLayout *layout, PetscInt component)
{
  return layout->component[component].symbol ? layout->component[component].symbol : layout->component[component].name;
}

PetscErrorCode MpmHistoryResume(MpmModel model, const char *path, PetscInt number, PetscInt columns,
                                const char *const names[], MpmHistory *table)
{
  const char     *restart = model->results->checkpoint.path;
  MpmHistoryPlace place   = {0, 0};
  const char     *line    = model->results->checkpoint.histories;
  MpmOutcome      outcome;
  char           *end;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < number && *line; k++) line += strcspn(line, "\n") + 1;
  MpmCheckInput(*line, "-mpm_restart %s: it does not know %s", restart, path);
  place.length = (PetscInt64)strtoll(line, &end, 10);
  place.hash   = (PetscInt64)strtoll(end, NULL, 10);
  PetscCall(MpmHistoryContinue(model->comm, path, columns, names, &place, table, &outcome));
  MpmCheckInput(!outcome.code,
                "-mpm_restart %s: %s cannot be continued: %s; move it away or choose another -mpm_output_prefix",
                restart, path, outcome.text);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Columns of the forces of conditions, motions and boundaries, and of bodies on one another. */
static PetscErrorCode AddReactionNames(MpmModel model, char *names[], PetscInt *count)
{
  const PetscInt dim = model->disc.dim;
  char           name[512];

  PetscFunctionBeginUser;
  for (PetscInt b = 0; b < model->scene.bcs->count; b++) {
    for (PetscInt k = 0; k < model->scene.bcs->at[b].component_count; k++) {
      PetscCall(PetscSNPrintf(name, sizeof(name), "reaction_%s_%s", model->scene.bcs->names[b],
                              ComponentName(model->disc.layout, model->scene.bcs->at[b].component[k])));
      PetscCall(PetscStrallocpy(name, &names[(*count)++]));
    }
    if (model->scene.bcs->at[b].inclined) { /* along the normal */
      PetscCall(PetscSNPrintf(name, sizeof(name), "reaction_%s_n", model->scene.bcs->names[b]));
      PetscCall(PetscStrallocpy(name, &names[(*count)++]));
    }
  }
  for (PetscInt m = 0; m < model->scene.motions->count; m++) {
    for (PetscInt k = 0; k < model->scene.motions->at[m].component_count; k++) {
      PetscCall(PetscSNPrintf(name, sizeof(name), "reaction_%s_%c", model->scene.motions->names[m],
                              "xyz"[model->scene.motions->at[m].component[k]]));
      PetscCall(PetscStrallocpy(name, &names[(*count)++]));
    }
  }
  for (PetscInt b = 0; b < model->scene.boundaries->count; b++) {
    for (PetscInt a = 0; a < dim; a++) {
      PetscCall(PetscSNPrintf(name, sizeof(name), "reaction_%s_%c", model->scene.boundaries->names[b], "xyz"[a]));
      PetscCall(PetscStrallocpy(name, &names[(*count)++]));
    }
    PetscCall(PetscSNPrintf(name, sizeof(name), "depth_%s", model->scene.boundaries->names[b]));
    PetscCall(PetscStrallocpy(name, &names[(*count)++]));
    for (PetscInt a = dim == 2 ? 2 : 0; a < 3; a++)
      PetscCall(AddColumn("moment", model->scene.boundaries->names[b], a, count, names));
    for (PetscInt a = 0; model->scene.boundaries->at[b].freedom && a < dim; a++)
      PetscCall(AddColumn("position", model->scene.boundaries->names[b], a, count, names));
    for (PetscInt a = dim == 2 ? 2 : 0; model->scene.boundaries->at[b].freedom && a < 3; a++)
      PetscCall(AddColumn("rotation", model->scene.boundaries->names[b], a, count, names));
  }
  for (PetscInt k = 0; k < model->scene.pairs->count * dim; k++)
    PetscCall(AddColumn("force", model->scene.pairs->names[k / dim], k % dim, count, names));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Names the columns; returns how many there are. Names are allocated. */
static PetscErrorCode HistoryColumns(MpmModel model, PetscInt *count, char ***names)
{
  static const char *const first[]    = {"step", "time", "dt", "newton", "linear", "cuts", "load"};
  static const char *const relaxing[] = {"K_F", "K_E", "resets"};
  const PetscInt           dim = model->disc.dim, fixed = (PetscInt)PETSC_STATIC_ARRAY_LENGTH(first);
  PetscInt capacity = fixed + model->results->tracks.count * dim + model->scene.bcs->count * (model->disc.block + 1) +
                      model->scene.boundaries->count * (3 * dim + 4) + model->scene.pairs->count * dim +
                      model->scene.motions->count * dim + model->scene.surfaces->count + MpmLinesColumnCount(model) +
                      2 * dim + 6 + MpmMotionColumnCount(model);
  char name[512];

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(capacity, names));
  *count = 0;
  for (PetscInt k = 0; k < fixed; k++) PetscCall(PetscStrallocpy(first[k], &(*names)[(*count)++]));
  PetscCall(AddReactionNames(model, *names, count));
  for (PetscInt k = 0; k < model->scene.surfaces->count && MpmPressureComponent(model->disc.layout) >= 0; k++) {
    PetscCall(PetscSNPrintf(name, sizeof(name), "outflow_%s", model->scene.surfaces->names[k]));
    PetscCall(PetscStrallocpy(name, &(*names)[(*count)++]));
  }
  for (PetscInt t = 0; t < model->results->tracks.count; t++) {
    for (PetscInt a = 0; a < dim; a++) {
      PetscCall(PetscSNPrintf(name, sizeof(name), "track_%s_u%c", model->results->tracks.names[t], "xyz"[a]));
      PetscCall(PetscStrallocpy(name, &(*names)[(*count)++]));
    }
  }
  PetscCall(MpmLinesAddColumns(model, *names, count));
  for (PetscInt k = 0; k < 2 * dim; k++) {
    if (!model->scene.follow.axis[k / 2]) continue;
    PetscCall(PetscSNPrintf(name, sizeof(name), "grid_%s_%c", k % 2 ? "upper" : "lower", "xyz"[k / 2]));
    PetscCall(PetscStrallocpy(name, &(*names)[(*count)++]));
  }
  if (model->scene.stages[0].name) PetscCall(PetscStrallocpy("stage", &(*names)[(*count)++]));
  if (MpmStagesReduce(model)) PetscCall(PetscStrallocpy("reduction", &(*names)[(*count)++]));
  if (MpmStagesConsolidate(model)) PetscCall(PetscStrallocpy("consolidation", &(*names)[(*count)++]));
  PetscCall(MpmMotionAddColumns(model, *names, count));
  for (PetscInt k = 0; MpmStagesRelax(model) && k < 3; k++)
    PetscCall(PetscStrallocpy(relaxing[k], &(*names)[(*count)++]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmModelCreateHistory(MpmModel model)
{
  const MpmOptions options = {model->comm, "mpm_", model->record};
  char             path[PETSC_MAX_PATH_LEN], **names;
  PetscLogDouble   since;

  PetscFunctionBeginUser;
  PetscCall(MpmMonitorBegin(&model->monitor, MPM_TIME_OUTPUT, &since));
  PetscCall(HistoryColumns(model, &model->results->history_columns, &names));
  PetscCall(ResultPath(model, "_history.csv", path, sizeof(path)));
  if (model->results->checkpoint.restart)
    PetscCall(MpmHistoryResume(model, path, 0, model->results->history_columns, (const char *const *)names,
                               &model->results->history));
  else {
    PetscCall(MpmHistoryCreate(model->comm, path, model->results->history_columns, (const char *const *)names,
                               &model->results->history));
  }
  PetscCall(PetscMalloc1(model->results->history_columns, &model->results->history_row));
  PetscCall(MpmNamesDestroy(model->results->history_columns, &names));
  PetscCall(MpmLinesOpen(model));
  PetscCall(ResultPath(model, "_options.yaml", path, sizeof(path)));
  PetscCall(MpmOptionsWriteYAML(&options, path));
  PetscCall(MpmMonitorEnd(&model->monitor, MPM_TIME_OUTPUT, since));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Whether bodies wait for the stage that they join. */
static PetscErrorCode AnyWaits(MpmModel model, PetscBool *any)
{
  PetscFunctionBeginUser;
  *any = PETSC_FALSE;
  if (!model->results->tracks.count || !model->scene.stages[0].name) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt b = 0; b < model->scene.bodies->count; b++)
    if (model->state.scheme.parked[b].count) *any = PETSC_TRUE;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, any, 1, MPM_MPI_BOOL, MPI_LOR, model->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode AddTracks(MpmModel model, PetscReal row[], PetscInt *k)
{
  PetscBool waiting;

  PetscFunctionBeginUser;
  PetscCall(AnyWaits(model, &waiting));
  for (PetscInt t = 0; t < model->results->tracks.count; t++, *k += model->disc.dim) {
    MpmTrack *track = &model->results->tracks.at[t];
    PetscBool fewer;

    PetscCall(MpmTrackEvaluate(track, model->state.particles, waiting, &row[*k], &fewer));
    if (fewer && track->gone)
      PetscCall(MpmMonitorNote(&model->monitor, "track %s is nan: its points are gone", track->name));
    else if (fewer)
      PetscCall(
        MpmMonitorNote(&model->monitor, "track %s: points are gone, it is the mean of the others", track->name));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The values of AddReactionNames() from row[k] on; where they end. */
static PetscInt AddReactions(const MpmModel model, PetscReal row[], PetscInt k)
{
  for (PetscInt b = 0; b < model->scene.bcs->count; b++) {
    const PetscReal *reaction = &model->disc.nodal.reaction[b * model->disc.block];

    for (PetscInt c = 0; c < model->scene.bcs->at[b].component_count; c++)
      row[k++] = reaction[model->scene.bcs->at[b].component[c]];
    if (!model->scene.bcs->at[b].inclined) continue;
    row[k] = 0.;
    for (PetscInt a = 0; a < model->disc.dim; a++) row[k] += reaction[a] * model->scene.bcs->at[b].normal[a];
    k++;
  }
  for (PetscInt m = 0; m < model->scene.motions->count; m++) {
    const PetscReal *reaction = &model->disc.nodal.reaction[(model->scene.bcs->count + m) * model->disc.block];

    for (PetscInt c = 0; c < model->scene.motions->at[m].component_count; c++)
      row[k++] = reaction[model->scene.motions->at[m].component[c]];
  }
  for (PetscInt b = 0; b < model->scene.boundaries->count; b++) {
    for (PetscInt a = 0; a < model->disc.dim; a++) row[k++] = model->disc.context.contacts->reaction[b][a];
    row[k++] = model->disc.context.contacts->depth[b];
    for (PetscInt a = model->disc.dim == 2 ? 2 : 0; a < 3; a++) row[k++] = model->disc.context.contacts->moment[b][a];
    k += MpmRigidReport(model->disc.context.contacts, b, &row[k]);
  }
  for (PetscInt p = 0; p < model->scene.pairs->count * model->disc.dim; p++)
    row[k++] = model->disc.context.pairs->force[p / model->disc.dim][p % model->disc.dim];
  return k;
}

PetscErrorCode MpmModelWriteHistory(MpmModel model, PetscReal dt)
{
  PetscReal     *row = model->results->history_row;
  PetscInt       k   = 0;
  PetscLogDouble since;

  PetscFunctionBeginUser;
  PetscCall(MpmMonitorBegin(&model->monitor, MPM_TIME_OUTPUT, &since));
  row[k++] = (PetscReal)model->state.step;
  row[k++] = model->state.time;
  row[k++] = dt;
  row[k++] = (PetscReal)model->solver.iterations.newton;
  row[k++] = (PetscReal)model->solver.iterations.linear;
  row[k++] = (PetscReal)model->state.cuts;
  row[k++] =
    model->scene.loads->count + model->scene.surfaces->named ? MpmModelLoadFactor(model, 0, model->state.time) : 0.;
  k = AddReactions(model, row, k);
  for (PetscInt s = 0; s < model->scene.surfaces->count && MpmPressureComponent(model->disc.layout) >= 0; s++)
    row[k++] = model->state.loads[model->scene.loads->count + s].outflow;
  PetscCall(AddTracks(model, row, &k));
  PetscCall(MpmLinesAddValues(model, row, &k));
  for (PetscInt a = 0; a < model->disc.dim; a++) {
    if (!model->scene.follow.axis[a]) continue;
    row[k++] = model->disc.grid->lower[a];
    row[k++] = model->disc.grid->upper[a];
  }
  if (model->scene.stages[0].name) row[k++] = (PetscReal)model->state.stage + 1.;
  if (MpmStagesReduce(model)) row[k++] = MpmReductionFactor(model, model->state.time);
  if (MpmStagesConsolidate(model)) row[k++] = model->state.scheme.water.degree;
  PetscCall(MpmMotionAddValues(model, row, &k));
  if (MpmStagesRelax(model)) {
    row[k++] = model->state.relaxing.force;
    row[k++] = model->state.relaxing.energy;
    row[k++] = (PetscReal)model->state.relaxing.resets;
  }
  PetscCall(MpmHistoryAppend(model->results->history, row));
  PetscCall(MpmMonitorEnd(&model->monitor, MPM_TIME_OUTPUT, since));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- summary ---- */

PetscErrorCode MpmModelWriteSummary(MpmModel model, const char *status)
{
  MpmSummary     summary = {.status            = status,
                            .dim               = model->disc.dim,
                            .title             = model->scene.title,
                            .physics           = model->scene.physics.name,
                            .shape             = MpmShapeTypes[model->scene.shape],
                            .jacobian          = MpmJacobianTypes[model->solver.jacobian.form],
                            .solver            = model->solver.preset.name,
                            .points            = model->state.particles->total,
                            .cells             = 1,
                            .active_dofs_max   = model->state.active_dofs_max,
                            .steps             = model->state.step,
                            .step_cuts         = model->state.cuts_total,
                            .newton_iterations = model->solver.iterations.newton_total,
                            .linear_iterations = model->solver.iterations.linear_total,
                            .imbalance         = model->state.particles->imbalance,
                            .rebalances        = model->state.particles->rebalances,
                            .reduces           = MpmStagesReduce(model),
                            .factor_of_safety  = model->state.safety.factor,
                            .relaxes           = MpmStagesRelax(model),
                            .criteria          = {model->state.relaxing.first, model->state.relaxing.since}};
  char           path[PETSC_MAX_PATH_LEN];
  PetscLogDouble now;

  PetscFunctionBeginUser;
  if (!(summary.factor_of_safety > 0.) && model->caller.outcome.code && MpmReductionSeeks(model))
    summary.factor_of_safety = model->state.safety.reduced; /* a lower bound */
  PetscCall(PetscArraycpy(summary.changes, model->monitor.changes, MPM_CHANGE_COUNT));
  for (PetscInt a = 0; a < model->disc.dim; a++) summary.cells *= model->disc.grid->cells[a];
  if (model->laboratory) {
    summary.physics  = MPM_STRESS_POINT;
    summary.shape    = NULL;
    summary.jacobian = MpmJacobianTypes[MPM_JACOBIAN_LOCAL];
    summary.solver   = "direct";
    summary.points   = 1;
  }
  PetscCall(PetscTime(&now));
  summary.time_total = now - model->results->start;
  PetscCall(PetscArraycpy(summary.time, model->monitor.seconds, MPM_TIME_COUNT));
  PetscCall(MpmSummaryReduce(model->comm, &summary));
  PetscCall(ResultPath(model, "_summary.json", path, sizeof(path)));
  PetscCall(MpmSummaryWrite(model->comm, path, MPM_VERSION, &summary));
  if (MpmTerminalShows(model)) PetscCall(MpmTerminalSummary(model->comm, &summary));
  PetscFunctionReturn(PETSC_SUCCESS);
}

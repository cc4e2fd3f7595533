/*
  The history: its columns, which the owners of their numbers register, and its rows.
*/
#include <stdlib.h>
#include <string.h>
#include "base/columns.h"
#include "options/options.h"
#include "loads/body_surface.h"
#include "loads/load.h"
#include "query/model.h"
#include "query/query.h"
#include "step/energy.h"
#include "step/moving_grid.h"
#include "integrators/consolidation.h"
#include "integrators/relaxation.h"
#include "schedule/reduction.h"
#include "schedule/stage.h"
#include "entrainment/entrainment.h"
#include "runout/runout.h"
#include "observe/history.h"
#include "observe/lines.h"
#include "observe/results.h"
#include "observe/tracks.h"

/* ---- columns ---- */

static PetscErrorCode FillStep(MpmModel model, const MpmColumn *column, PetscReal values[])
{
  (void)column;
  PetscFunctionBeginUser;
  values[0] = (PetscReal)model->state.step;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode FillTime(MpmModel model, const MpmColumn *column, PetscReal values[])
{
  (void)column;
  PetscFunctionBeginUser;
  values[0] = model->state.time;
  values[1] = model->results->dt;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode FillCounts(MpmModel model, const MpmColumn *column, PetscReal values[])
{
  (void)column;
  PetscFunctionBeginUser;
  values[0] = (PetscReal)model->solver.iterations.newton;
  values[1] = (PetscReal)model->solver.iterations.linear;
  values[2] = (PetscReal)model->state.cuts.step;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmStepAddColumns(MpmModel model, MpmColumns *columns)
{
  static const char *const times[] = {"time", "dt"}, *const counts[] = {"newton", "linear", "cuts"};
  const MpmColumn rows[] = {
    {.name = "step", .unit = "-", .fill = FillStep},
    {.unit = "s", .count = PETSC_STATIC_ARRAY_LENGTH(times), .parts = times, .fill = FillTime},
    {.unit = "-", .count = PETSC_STATIC_ARRAY_LENGTH(counts), .parts = counts, .fill = FillCounts},
  };

  (void)model;
  PetscFunctionBeginUser;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(rows); k++) PetscCall(MpmColumnsAdd(columns, NULL, &rows[k]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The first load, or the first surface where there is none. */
static PetscErrorCode FillLoad(MpmModel model, const MpmColumn *column, PetscReal values[])
{
  (void)column;
  PetscFunctionBeginUser;
  values[0] =
    model->scene.loads->count + model->scene.surfaces->named ? MpmModelLoadFactor(model, 0, model->state.time) : 0.;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode AddLoad(MpmModel model, MpmColumns *columns)
{
  const MpmColumn row = {.name = "load", .unit = "-", .fill = FillLoad};

  (void)model;
  PetscFunctionBeginUser;
  PetscCall(MpmColumnsAdd(columns, NULL, &row));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Parts of the program with columns, in the order of these. */
static PetscErrorCode (*const parts[])(MpmModel, MpmColumns *) = {MpmStepAddColumns,        AddLoad,
                                                                  MpmReactionsAddColumns,   MpmOutflowAddColumns,
                                                                  MpmTracksAddColumns,      MpmLinesAddColumns,
                                                                  MpmMovingGridAddColumns,  MpmStagesAddColumns,
                                                                  MpmReductionAddColumns,   MpmConsolidationAddColumns,
                                                                  MpmTracksAddVelocities,   MpmEnergyAddColumns,
                                                                  MpmRelaxationAddColumns,  MpmRunoutAddColumns,
                                                                  MpmEntrainmentAddColumns, MpmDamageAddColumns,
                                                                  MpmDamsAddColumns,        MpmSignatureAddColumns};

/* Columns of the library's caller follow the scene's. */
static PetscErrorCode AddCallers(MpmModel model, MpmColumns *columns)
{
  const MpmColumns *added = &model->results->added.columns;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < added->name_count; k++)
    PetscCheck(!MpmColumnsHave(columns, added->names[k]), model->comm, PETSC_ERR_ARG_OUTOFRANGE,
               "the history has a column %s of the scene's", added->names[k]);
  for (PetscInt k = 0; k < added->count; k++) PetscCall(MpmColumnsAdd(columns, NULL, &added->at[k]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmHistoryAddColumns(MpmModel model, MpmColumns *columns)
{
  PetscFunctionBeginUser;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(parts); k++) PetscCall((*parts[k])(model, columns));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the file ---- */

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

PetscErrorCode MpmHistoryOpen(MpmModel model)
{
  MpmResults        *results = model->results;
  const MpmOptions   options = {model->comm, "mpm_", model->record};
  const char *const *names;
  char               path[PETSC_MAX_PATH_LEN];

  PetscFunctionBeginUser;
  PetscCall(AddCallers(model, &results->columns));
  names = (const char *const *)results->columns.names;
  PetscCall(PetscSNPrintf(path, sizeof(path), "%s_history.csv", model->scene.name.prefix));
  if (results->checkpoint.restart)
    PetscCall(MpmHistoryResume(model, path, 0, results->columns.name_count, names, &results->history));
  else PetscCall(MpmHistoryCreate(model->comm, path, results->columns.name_count, names, &results->history));
  PetscCall(PetscMalloc1(results->columns.name_count, &results->history_row));
  PetscCall(PetscSNPrintf(path, sizeof(path), "%s_options.yaml", model->scene.name.prefix));
  PetscCall(MpmOptionsWriteYAML(&options, path));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmModelCreateHistory(MpmModel model)
{
  PetscLogDouble since;

  PetscFunctionBeginUser;
  PetscCall(MpmMonitorBegin(&model->monitor, MPM_TIME_OUTPUT, &since));
  PetscCall(MpmHistoryAddColumns(model, &model->results->columns));
  PetscCall(MpmHistoryOpen(model));
  PetscCall(MpmLinesOpen(model));
  PetscCall(MpmMonitorEnd(&model->monitor, MPM_TIME_OUTPUT, since));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmModelWriteHistory(MpmModel model)
{
  MpmResults    *results = model->results;
  PetscLogDouble since;

  PetscFunctionBeginUser;
  PetscCall(MpmMonitorBegin(&model->monitor, MPM_TIME_OUTPUT, &since));
  PetscCall(MpmColumnsFill(&results->columns, model, results->history_row));
  PetscCall(MpmHistoryAppend(results->history, results->history_row));
  results->history_step = model->state.step;
  PetscCall(MpmMonitorEnd(&model->monitor, MPM_TIME_OUTPUT, since));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Objectives: columns of the history against data.
*/
#include "base/columns.h"
#include "options/options.h"
#include "sensitivity/objective.h"

/* A data file: columns time and the objective's own, or two columns. */
static PetscErrorCode ReadData(const MpmOptions *block, const char path[], MpmObjective *objective)
{
  char message[MPM_CSV_MESSAGE] = "";

  PetscFunctionBeginUser;
  PetscCall(MpmCsvTableRead(path, &objective->data, message));
  MpmCheckInput(!message[0], "-%sdata %s: %s", block->prefix, path, message);
  objective->time  = MpmCsvTableFind(&objective->data, "time");
  objective->value = MpmCsvTableFind(&objective->data, objective->column);
  if (objective->data.columns == 2 && objective->value < 0) objective->value = objective->time == 0 ? 1 : 0;
  MpmCheckInput(objective->time >= 0, "-%sdata %s: has no column time", block->prefix, path);
  MpmCheckInput(objective->value >= 0 && objective->value != objective->time, "-%sdata %s: has no column %s",
                block->prefix, path, objective->column);
  MpmCheckInput(objective->data.rows > 0, "-%sdata %s: has no rows", block->prefix, path);
  for (PetscInt64 k = 1; k < objective->data.rows; k++) {
    const PetscReal *row = &objective->data.value[k * objective->data.columns + objective->time];

    MpmCheckInput(row[0] > row[-objective->data.columns], "-%sdata %s: times must ascend", block->prefix, path);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadOne(const MpmOptions *options, const char name[], MpmObjective *objective)
{
  static const char *const kinds[] = {"misfit", "value", NULL}, *const ends[] = {"end", NULL};
  char       prefix[256], *path;
  MpmOptions block = {options->comm, prefix, options->record};
  PetscInt   kind = 0, end = 0;
  PetscBool  given, target, weighted;
  PetscReal  weight = 1.;

  PetscFunctionBeginUser;
  PetscCall(PetscSNPrintf(prefix, sizeof(prefix), "mpm_objective_%s_", name));
  PetscCall(PetscStrallocpy(name, &objective->name));
  PetscCall(MpmOptionsHeading(&block, "Objective"));
  PetscCall(MpmOptionsText(&block, "column", "column of the history", NULL, MPM_REQUIRED, &objective->column));
  PetscCall(MpmOptionsWord(&block, "kind", "misfit: distance from data, or from a target; value: the last value itself",
                           kinds, MPM_OPTIONAL, &kind, NULL));
  objective->kind = (MpmObjectiveKind)kind;
  PetscCall(MpmOptionsPath(&block, "data", "file with columns time and the objective's", MPM_OPTIONAL, &path));
  PetscCall(MpmOptionsWord(&block, "at", "end: the last value alone", ends, MPM_OPTIONAL, &end, &objective->at_end));
  PetscCall(MpmOptionsReal(&block, "target", "", "for the last value, in the column's unit", MPM_RANGE_ANY,
                           MPM_OPTIONAL, &objective->target, &target));
  objective->deviation = 1.;
  PetscCall(MpmOptionsReal(&block, "deviation", "", "standard deviation of the data, in the column's unit",
                           MPM_RANGE_POSITIVE, MPM_OPTIONAL, &objective->deviation, &given));
  PetscCall(MpmOptionsReal(&block, "weight", "", "instead of the deviation: factor of the square", MPM_RANGE_POSITIVE,
                           MPM_OPTIONAL, &weight, &weighted));
  if (MpmOptionsHelp()) PetscFunctionReturn(PetscFree(path));
  MpmCheckInput(!given || !weighted, "-%sweight: the deviation is given, too", prefix);
  if (weighted) objective->deviation = 1. / PetscSqrtReal(weight);
  MpmCheckInput(kind || path || target, "-%sdata is missing: or a target, or kind: value", prefix);
  MpmCheckInput(!target || !path, "-%starget: the data are given, too", prefix);
  if (path) PetscCall(ReadData(&block, path, objective));
  PetscCall(PetscFree(path));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmObjectivesRead(MpmModel model, const MpmOptions *options, MpmObjectives *objectives)
{
  (void)model;
  PetscFunctionBeginUser;
  PetscCall(MpmOptionsBlocks(options, "objectives", "names of the numbers whose sum is differentiated", MPM_OPTIONAL,
                             &objectives->count, &objectives->names));
  PetscCall(PetscCalloc1(objectives->count, &objectives->at));
  for (PetscInt k = 0; k < objectives->count; k++)
    PetscCall(ReadOne(options, objectives->names[k], &objectives->at[k]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmObjectivesDestroy(MpmObjectives *objectives)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < objectives->count; k++) {
    PetscCall(PetscFree(objectives->at[k].name));
    PetscCall(PetscFree(objectives->at[k].column));
    PetscCall(MpmCsvTableDestroy(&objectives->at[k].data));
  }
  PetscCall(PetscFree(objectives->at));
  PetscCall(MpmNamesDestroy(objectives->count, &objectives->names));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmObjectivesFind(const MpmColumns *columns, MpmObjectives *objectives)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < objectives->count; k++) {
    MpmObjective *objective = &objectives->at[k];

    objective->row = MpmColumnsFind(columns, objective->column, &objective->part);
    MpmCheckInput(objective->row >= 0, "-mpm_objective_%s_column %s: the history has no such column", objective->name,
                  objective->column);
    MpmCheckInput(columns->map[objective->row],
                  "-mpm_objective_%s_column %s: there is no derivative of this column yet", objective->name,
                  objective->column);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmObjectiveEvaluate(const MpmObjective *objective, const MpmCurve *curve, PetscReal *value,
                                    PetscReal weight[])
{
  const PetscInt   last   = curve->count - 1;
  const PetscReal  square = objective->deviation * objective->deviation;
  const PetscReal *data   = objective->data.value;

  PetscFunctionBeginUser;
  *value = objective->kind == MPM_OBJECTIVE_VALUE ? curve->value[last] : 0.;
  for (PetscInt n = 0; n < curve->count; n++) weight[n] = 0.;
  weight[last] = objective->kind == MPM_OBJECTIVE_VALUE ? 1. : 0.;
  if (objective->kind == MPM_OBJECTIVE_VALUE) PetscFunctionReturn(PETSC_SUCCESS);
  if (!data) {
    const PetscReal gap = curve->value[last] - objective->target;

    *value       = 0.5 * gap * gap / square;
    weight[last] = gap / square;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  for (PetscInt64 k = 0, n = 0; k < objective->data.rows; k++, data += objective->data.columns) {
    const PetscReal time = data[objective->time], slack = 1e-9 * curve->time[last];
    PetscReal       part, gap;

    MpmCheckInput(time >= curve->time[0] - slack && time <= curve->time[last] + slack,
                  "-mpm_objective_%s_data: time %g lies outside of the run's steps, %g to %g", objective->name,
                  (double)time, (double)curve->time[0], (double)curve->time[last]);
    while (n + 2 < curve->count && curve->time[n + 1] < time) n++;
    part = last ? PetscClipInterval((time - curve->time[n]) / (curve->time[n + 1] - curve->time[n]), 0., 1.) : 0.;
    gap  = (1. - part) * curve->value[n] + (last ? part * curve->value[n + 1] : 0.) - data[objective->value];
    *value += 0.5 * gap * gap / square;
    weight[n] += (1. - part) * gap / square;
    if (last) weight[n + 1] += part * gap / square;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

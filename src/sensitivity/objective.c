/*
  Objectives: columns of the history against data.
*/
#include <string.h>
#include "base/columns.h"
#include "options/options.h"
#include "sensitivity/objective.h"

/* The column of this name, which the data must have. */
static PetscErrorCode FindInData(const MpmOptions *block, const char path[], const MpmCsvTable *data, const char name[],
                                 PetscInt *column)
{
  char names[MPM_CSV_MESSAGE] = "";

  PetscFunctionBeginUser;
  *column = MpmCsvTableFind(data, name);
  if (*column < 0) PetscCall(MpmCsvTableNames(data, names));
  MpmCheckInput(*column >= 0, "-%sdata %s: has no column %s%s", block->prefix, path, name, names);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Places in ascending order; over another column than the time they may descend. Deviations must be positive. */
static PetscErrorCode CheckData(const MpmOptions *block, const char path[], const MpmObjective *objective,
                                PetscReal end)
{
  const MpmCsvTable *data = &objective->data;
  PetscReal          sign = 1.;

  PetscFunctionBeginUser;
  for (PetscInt64 k = 0; k < data->rows; k++) {
    const PetscReal *row = &data->value[k * data->columns];

    if (k == 1 && objective->over && row[objective->place] < row[objective->place - data->columns]) sign = -1.;
    if (k)
      MpmCheckInput(sign * row[objective->place] > sign * row[objective->place - data->columns],
                    "-%sdata %s: %s must ascend", block->prefix, path, objective->over ? objective->over : "times");
    MpmCheckInput(objective->spread < 0 || row[objective->spread] > 0., "-%sdata %s: a deviation of %g: must be > 0",
                  block->prefix, path, objective->spread < 0 ? 0. : (double)row[objective->spread]);
    MpmCheckInput(objective->over || end <= 0. ||
                    (row[objective->place] >= 0. && row[objective->place] <= end * (1. + 1e-9)),
                  "-%sdata %s: time %g lies outside of the run, 0 to %g", block->prefix, path,
                  (double)row[objective->place], (double)end);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A data file: columns time, or another abscissa, and the objective's own; or two columns. */
static PetscErrorCode ReadData(const MpmOptions *block, const char path[], PetscBool given, MpmObjective *objective)
{
  MpmCsvTable *data                     = &objective->data;
  char         message[MPM_CSV_MESSAGE] = "";

  PetscFunctionBeginUser;
  PetscCall(MpmCsvTableRead(path, data, message));
  MpmCheckInput(!message[0], "-%sdata %s: %s", block->prefix, path, message);
  MpmCheckInput(data->rows > 0, "-%sdata %s: has no rows", block->prefix, path);
  PetscCall(FindInData(block, path, data, objective->over ? objective->over : "time", &objective->place));
  objective->value = data->columns == 2 ? 1 - objective->place : -1;
  if (objective->value < 0) PetscCall(FindInData(block, path, data, objective->column, &objective->value));
  MpmCheckInput(objective->value != objective->place, "-%sdata %s: %s is its own abscissa", block->prefix, path,
                objective->column);
  objective->spread = given ? -1 : MpmCsvTableFind(data, "deviation");
  if (objective->spread == objective->value || objective->spread == objective->place) objective->spread = -1;
  PetscCall(MpmCsvTableFinite(data, objective->place, message));
  PetscCall(MpmCsvTableFinite(data, objective->value, message));
  if (objective->spread >= 0) PetscCall(MpmCsvTableFinite(data, objective->spread, message));
  MpmCheckInput(!message[0], "-%sdata %s: %s", block->prefix, path, message);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Standard deviation, or the factor of the square in its place. */
static PetscErrorCode ReadDeviation(const MpmOptions *block, MpmObjective *objective, PetscBool *given)
{
  PetscBool weighted;
  PetscReal weight = 1.;

  PetscFunctionBeginUser;
  objective->deviation = 1.;
  PetscCall(
    MpmOptionsReal(block, "deviation", "",
                   "standard deviation of the data, in the column's unit; default: their column deviation, or 1",
                   MPM_RANGE_POSITIVE, MPM_OPTIONAL, &objective->deviation, given));
  PetscCall(MpmOptionsReal(block, "weight", "", "instead of the deviation: factor of the square", MPM_RANGE_POSITIVE,
                           MPM_OPTIONAL, &weight, &weighted));
  MpmCheckInput(!*given || !weighted, "-%sweight: the deviation is given, too", block->prefix);
  if (weighted) objective->deviation = 1. / PetscSqrtReal(weight);
  if (weighted) *given = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* An objective with a column of the history. */
static PetscErrorCode ReadColumn(const MpmOptions *options, const char name[], PetscReal end, MpmObjective *objective)
{
  static const char *const ends[] = {"end", NULL};
  const char *const        prefix = options->prefix;
  const MpmOptions         block  = *options;
  const PetscInt           kind   = (PetscInt)objective->kind;
  char                    *path;
  PetscInt                 at = 0;
  PetscBool                given, target;

  PetscFunctionBeginUser;
  PetscCall(PetscStrallocpy(name, &objective->name));
  objective->over_curve = -1;
  PetscCall(MpmOptionsText(&block, "column", "column of the history", NULL, MPM_REQUIRED, &objective->column));
  PetscCall(MpmOptionsPath(&block, "data", "file with columns time and the objective's", MPM_OPTIONAL, &path));
  PetscCall(MpmOptionsText(&block, "over", "column of the history and of the data that stands for the time", NULL,
                           MPM_OPTIONAL, &objective->over));
  PetscCall(MpmOptionsWord(&block, "at", "end: the last value alone", ends, MPM_OPTIONAL, &at, &objective->at_end));
  PetscCall(MpmOptionsReal(&block, "target", "", "for the last value, in the column's unit", MPM_RANGE_ANY,
                           MPM_OPTIONAL, &objective->target, &target));
  PetscCall(ReadDeviation(&block, objective, &given));
  if (MpmOptionsHelp()) PetscFunctionReturn(PetscFree(path));
  if (objective->over && !strcmp(objective->over, "time")) PetscCall(PetscFree(objective->over));
  MpmCheckInput(kind || path || target, "-%sdata is missing: or a target, or kind: value", prefix);
  MpmCheckInput(!target || !path, "-%starget: the data are given, too", prefix);
  MpmCheckInput(!objective->over || path, "-%sover %s: only data have an abscissa", prefix, objective->over);
  if (path) {
    PetscCall(ReadData(&block, path, given, objective));
    PetscCall(CheckData(&block, path, objective, end));
  }
  PetscCall(PetscFree(path));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* An objective or a regularization by its kind. */
static PetscErrorCode ReadOne(const MpmOptions *options, const char name[], PetscReal end, MpmObjectives *objectives)
{
  static const char *const kinds[] = {"misfit", "value", "tikhonov", "total_variation", "prior", NULL};
  const PetscInt           others  = 2; /* kinds that have a column */
  char                     prefix[256];
  MpmOptions               block = {options->comm, prefix, options->record};
  PetscInt                 kind  = 0;

  PetscFunctionBeginUser;
  PetscCall(PetscSNPrintf(prefix, sizeof(prefix), "mpm_objective_%s_", name));
  PetscCall(MpmOptionsHeading(&block, "Objective"));
  PetscCall(MpmOptionsWord(&block, "kind",
                           "misfit: distance from data, or from a target; value: the last value itself; of a field's "
                           "values in an inverse analysis: tikhonov: squared differences of neighbour cells; "
                           "total_variation: their size, for edges; prior: distance from a mean, with correlation",
                           kinds, MPM_OPTIONAL, &kind, NULL));
  if (kind < others || MpmOptionsHelp()) {
    MpmObjective *objective = &objectives->at[objectives->count++];

    objective->kind = (MpmObjectiveKind)kind;
    PetscCall(ReadColumn(&block, name, end, objective));
  }
  if (kind >= others || MpmOptionsHelp())
    PetscCall(MpmRegularizationRead(&block, name, (MpmRegularizationKind)PetscMax(kind - others, 0),
                                    &objectives->regular[objectives->regular_count++]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A number of the run's end that data do not reach. */
static PetscErrorCode ReadPrediction(const MpmOptions *options, const char name[], MpmObjective *objective)
{
  static const char *const ends[] = {"end", NULL};
  char                     prefix[256];
  MpmOptions               block = {options->comm, prefix, options->record};
  PetscInt                 at    = 0;

  PetscFunctionBeginUser;
  PetscCall(PetscSNPrintf(prefix, sizeof(prefix), "mpm_prediction_%s_", name));
  PetscCall(PetscStrallocpy(name, &objective->name));
  objective->kind       = MPM_OBJECTIVE_PREDICTION;
  objective->over_curve = -1;
  PetscCall(MpmOptionsHeading(&block, "Prediction"));
  PetscCall(MpmOptionsText(&block, "column", "column of the history", NULL, MPM_REQUIRED, &objective->column));
  PetscCall(MpmOptionsWord(&block, "at", "end: the last value", ends, MPM_OPTIONAL, &at, &objective->at_end));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A curve for each abscissa. */
static PetscErrorCode AddAbscissae(MpmObjectives *objectives)
{
  PetscInt count = objectives->count;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < objectives->asked; k++) {
    MpmObjective *objective = &objectives->at[k], *added = &objectives->at[count];

    if (!objective->over) continue;
    objective->over_curve = count++;
    added->kind           = MPM_OBJECTIVE_ABSCISSA;
    added->over_curve     = -1;
    PetscCall(PetscStrallocpy(objective->name, &added->name));
    PetscCall(PetscStrallocpy(objective->over, &added->column));
  }
  objectives->count = count;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmObjectivesRead(const MpmOptions *options, PetscReal end, MpmObjectives *objectives)
{
  PetscFunctionBeginUser;
  PetscCall(MpmOptionsBlocks(options, "objectives", "names of the numbers whose sum is differentiated", MPM_OPTIONAL,
                             &objectives->name_count, &objectives->names));
  PetscCall(MpmOptionsBlocks(options, "predictions", "names of numbers whose bounds an inverse analysis gives",
                             MPM_OPTIONAL, &objectives->predicted, &objectives->predictions));
  PetscCall(PetscCalloc1((2 * objectives->name_count + objectives->predicted), &objectives->at));
  PetscCall(PetscCalloc1(objectives->name_count, &objectives->regular));
  for (PetscInt k = 0; k < objectives->name_count; k++)
    PetscCall(ReadOne(options, objectives->names[k], end, objectives));
  objectives->asked = objectives->count;
  for (PetscInt k = 0; k < objectives->predicted; k++)
    PetscCall(ReadPrediction(options, objectives->predictions[k], &objectives->at[objectives->count++]));
  PetscCall(AddAbscissae(objectives));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmObjectivesDestroy(MpmObjectives *objectives)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < objectives->count; k++) {
    PetscCall(PetscFree(objectives->at[k].name));
    PetscCall(PetscFree(objectives->at[k].column));
    PetscCall(PetscFree(objectives->at[k].over));
    PetscCall(MpmCsvTableDestroy(&objectives->at[k].data));
  }
  PetscCall(PetscFree(objectives->at));
  for (PetscInt k = 0; k < objectives->regular_count; k++) PetscCall(MpmRegularizationDestroy(&objectives->regular[k]));
  PetscCall(PetscFree(objectives->regular));
  PetscCall(MpmNamesDestroy(objectives->name_count, &objectives->names));
  PetscCall(MpmNamesDestroy(objectives->predicted, &objectives->predictions));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The option that names the column. */
static const char *OptionOf(const MpmObjective *objective)
{
  return objective->kind == MPM_OBJECTIVE_ABSCISSA ? "over" : "column";
}

/* Columns of decisions, which derivatives hold. */
static const char *const counted[] = {"step", "time", "dt", "newton", "linear", "cuts", "stage", "resets"};

PetscErrorCode MpmObjectivesFind(const MpmColumns *columns, MpmObjectives *objectives)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < objectives->count; k++) {
    MpmObjective *objective = &objectives->at[k];
    const char   *block     = objective->kind == MPM_OBJECTIVE_PREDICTION ? "prediction" : "objective";
    const char   *nearest   = MpmTextNearest(objective->column, columns->name_count, columns->names, PETSC_INT_MAX);

    objective->row = MpmColumnsFind(columns, objective->column, &objective->part);
    MpmCheckInput(objective->row >= 0, "-mpm_%s_%s_%s %s: the history has no such column; the nearest is %s", block,
                  objective->name, OptionOf(objective), objective->column, nearest ? nearest : "none");
    for (size_t c = 0; c < PETSC_STATIC_ARRAY_LENGTH(counted); c++)
      MpmCheckInput(objective->kind == MPM_OBJECTIVE_ABSCISSA || strcmp(objective->column, counted[c]),
                    "-mpm_%s_%s_%s %s: there is no derivative of this column", block, objective->name,
                    OptionOf(objective), objective->column);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Iterations of an inverse analysis as a table, from which an interrupted one goes on.
*/
#include <string.h>
#include "inverse/analysis.h"
#include "inverse/discrepancy.h"

#define OBJECTIVE 1 /* columns: iteration, objective, the parameters, evaluations, start */
#define FIRST     2

static PetscErrorCode Names(const MpmInverse *inverse, const char ***names)
{
  const PetscInt count = inverse->problem.count;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1((count + 4), names));
  (*names)[0]         = "iteration";
  (*names)[OBJECTIVE] = "objective";
  for (PetscInt k = 0; k < count; k++) (*names)[FIRST + k] = inverse->problem.ranges->at[k].name;
  (*names)[FIRST + count]     = "evaluations";
  (*names)[FIRST + count + 1] = "start";
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Path(const MpmInverse *inverse, size_t size, char path[])
{
  PetscFunctionBeginUser;
  PetscCall(PetscSNPrintf(path, size, "%s_inverse.csv", inverse->problem.prefix));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Transformed parameters of a row. */
static PetscErrorCode TakeRow(const MpmInverse *inverse, const PetscReal row[], PetscReal **t)
{
  PetscFunctionBeginUser;
  if (!*t) PetscCall(PetscMalloc1(inverse->problem.count, t));
  for (PetscInt k = 0; k < inverse->problem.count; k++)
    (*t)[k] = MpmRangeTransform(&inverse->problem.ranges->at[k], row[FIRST + k]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTraceRead(MpmInverse *inverse)
{
  MpmEarlierRows *earlier                  = &inverse->earlier;
  MpmCsvTable    *table                    = &earlier->table;
  const PetscInt  count                    = inverse->problem.count;
  char            message[MPM_CSV_MESSAGE] = "", path[PETSC_MAX_PATH_LEN];
  const char    **names;
  PetscBool       there;

  PetscFunctionBeginUser;
  earlier->start = earlier->iteration = -1;
  earlier->least                      = PETSC_INFINITY;
  PetscCall(Path(inverse, sizeof(path), path));
  PetscCall(PetscTestFile(path, 'r', &there));
  if (!inverse->settings->restart || !there) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmCsvTableRead(path, table, message));
  MpmCheckInput(!message[0], "-mpm_inverse_restart: %s: %s", path, message);
  PetscCall(Names(inverse, &names));
  for (PetscInt k = 0; k < count + 4; k++)
    MpmCheckInput(table->columns == count + 4 && !strcmp(table->name[k], names[k]),
                  "-mpm_inverse_restart: %s is of an analysis with other parameters", path);
  PetscCall(PetscFree(names));
  for (PetscInt64 n = 0; n < table->rows; n++) {
    const PetscReal *row = &table->value[n * table->columns];

    if (row[OBJECTIVE] < earlier->least) {
      PetscCall(TakeRow(inverse, row, &earlier->best));
      earlier->least = row[OBJECTIVE];
    }
    if (n + 1 < table->rows) continue;
    PetscCall(TakeRow(inverse, row, &earlier->t));
    earlier->iteration           = (PetscInt)row[0];
    earlier->start               = (PetscInt)row[FIRST + count + 1];
    inverse->problem.evaluations = (PetscInt)row[FIRST + count];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Open(MpmInverse *inverse)
{
  const MpmCsvTable *table = &inverse->earlier.table;
  char               path[PETSC_MAX_PATH_LEN];
  const char       **names;

  PetscFunctionBeginUser;
  PetscCall(Path(inverse, sizeof(path), path));
  PetscCall(MpmFolderMake(inverse->problem.comm, inverse->problem.prefix));
  PetscCall(Names(inverse, &names));
  PetscCall(MpmHistoryCreate(inverse->problem.comm, path, inverse->problem.count + 4, names, &inverse->trace));
  PetscCall(PetscFree(names));
  for (PetscInt64 n = 0; n < table->rows; n++)
    PetscCall(MpmHistoryAppend(inverse->trace, &table->value[n * table->columns]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTraceClose(MpmInverse *inverse)
{
  PetscFunctionBeginUser;
  PetscCall(MpmHistoryDestroy(&inverse->trace));
  PetscCall(MpmCsvTableDestroy(&inverse->earlier.table));
  PetscCall(PetscFree(inverse->earlier.t));
  PetscCall(PetscFree(inverse->earlier.best));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscInt MpmInverseFirst(const MpmInverse *inverse)
{
  return inverse->start == inverse->earlier.start ? inverse->earlier.iteration : 0;
}

static PetscErrorCode Print(const MpmInverse *inverse, PetscInt iteration, const MpmEvaluation *at)
{
  const MpmInverseProblem *problem = &inverse->problem;

  PetscFunctionBeginUser;
  if (!problem->shows) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(
    PetscPrintf(problem->comm, "%7d %14.7g %6d ", (int)iteration, (double)at->objective, (int)problem->evaluations));
  for (PetscInt k = 0; k < PetscMin(problem->ranges->numbers, 8); k++)
    PetscCall(PetscPrintf(problem->comm, " %s %.8g", problem->ranges->at[k].name,
                          (double)MpmRangeValue(&problem->ranges->at[k], at->t[k])));
  if (MpmInverseLevel(inverse, at) > 0.)
    PetscCall(PetscPrintf(problem->comm, " squared residuals %.5g of %d data", (double)MpmInverseSquares(at),
                          (int)at->data.count));
  PetscCall(PetscPrintf(problem->comm, "\n"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmInverseReport(MpmInverse *inverse, PetscInt iteration, const MpmEvaluation *at, PetscBool *stop)
{
  const MpmInverseProblem *problem = &inverse->problem;
  PetscReal               *row;
  PetscBool                met;

  PetscFunctionBeginUser;
  PetscCall(MpmDiscrepancyFind(inverse, at, &met));
  inverse->iteration = iteration;
  *stop              = (PetscBool)(inverse->interrupted || met || iteration >= inverse->settings->iterations);
  if (!inverse->trace) PetscCall(Open(inverse));
  PetscCall(Print(inverse, iteration, at));
  if (inverse->start == inverse->earlier.start && iteration <= inverse->earlier.iteration)
    PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1((problem->count + 4), &row));
  row[0]         = (PetscReal)iteration;
  row[OBJECTIVE] = at->objective;
  for (PetscInt k = 0; k < problem->count; k++) row[FIRST + k] = MpmRangeValue(&problem->ranges->at[k], at->t[k]);
  row[FIRST + problem->count]     = (PetscReal)problem->evaluations;
  row[FIRST + problem->count + 1] = (PetscReal)inverse->start;
  PetscCall(MpmHistoryAppend(inverse->trace, row));
  PetscCall(PetscFree(row));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  The account of a run: as JSON for programs, as a table for people.
*/
#include <math.h>
#include <sys/resource.h>
#include "base/base.h"
#include "io/io.h"

PetscReal MpmProcessMemory(void)
{
  struct rusage usage;

  if (getrusage(RUSAGE_SELF, &usage)) return 0.;
#if defined(__APPLE__)
  return (PetscReal)usage.ru_maxrss;
#else
  return 1024. * (PetscReal)usage.ru_maxrss;
#endif
}

PetscErrorCode MpmSummaryReduce(MPI_Comm comm, MpmSummary *summary)
{
  const PetscReal memory = MpmProcessMemory();

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, summary->time, MPM_TIME_COUNT, MPIU_REAL, MPIU_MAX, comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &summary->time_total, 1, MPIU_REAL, MPIU_MAX, comm));
  PetscCallMPI(MPI_Allreduce(&memory, &summary->memory_max, 1, MPIU_REAL, MPIU_SUM, comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A JSON string: quotes, backslashes and control characters escaped, other bytes (UTF-8) as they are; NULL becomes
   null. */
static PetscErrorCode AppendString(MpmTextFile *text, const char *key, const char *value)
{
  PetscFunctionBeginUser;
  if (!value) {
    PetscCall(MpmTextFileAppend(text, "  \"%s\": null,\n", key));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(MpmTextFileAppend(text, "  \"%s\": \"", key));
  for (const char *c = value; *c; ++c) {
    unsigned char byte = (unsigned char)*c;
    if (byte == '"' || byte == '\\') PetscCall(MpmTextFileAppend(text, "\\%c", *c));
    else if (byte < 0x20) PetscCall(MpmTextFileAppend(text, "\\u%04x", (unsigned)byte));
    else PetscCall(MpmTextFileAppend(text, "%c", *c));
  }
  PetscCall(MpmTextFileAppend(text, "\",\n"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode AppendCount(MpmTextFile *text, const char *key, PetscInt64 value)
{
  PetscFunctionBeginUser;
  PetscCall(MpmTextFileAppend(text, "  \"%s\": %lld,\n", key, (long long)value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* JSON knows neither infinity nor not-a-number. */
static PetscErrorCode AppendNumber(MpmTextFile *text, PetscReal value)
{
  PetscFunctionBeginUser;
  if (isfinite(value)) PetscCall(MpmTextFileAppend(text, "%.9g", (double)value));
  else PetscCall(MpmTextFileAppend(text, "null"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* An objective and its gradient, to the last digit. */
static PetscErrorCode AppendDerivatives(MpmTextFile *text, const MpmSummary *summary)
{
  const PetscInt count = summary->derivatives.count;

  PetscFunctionBeginUser;
  if (summary->derivatives.inverse)
    PetscCall(MpmTextFileAppend(text, "  \"inverse\": %s,\n", summary->derivatives.inverse));
  if (!count && !summary->derivatives.fields) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(
    MpmTextFileAppend(text, "  \"objective\": %.17g,\n  \"parameters\": [", (double)summary->derivatives.objective));
  for (PetscInt k = 0; k < count; k++)
    PetscCall(MpmTextFileAppend(text, "%s\"%s\"", k ? ", " : "", summary->derivatives.names[k]));
  PetscCall(MpmTextFileAppend(text, "],\n  \"gradient\": ["));
  for (PetscInt k = 0; k < count; k++)
    PetscCall(MpmTextFileAppend(text, "%s%.17g", k ? ", " : "", (double)summary->derivatives.values[k]));
  PetscCall(MpmTextFileAppend(text, "],\n  \"gradient_method\": ["));
  for (PetscInt k = 0; k < count; k++)
    PetscCall(MpmTextFileAppend(text, "%s\"%s\"", k ? ", " : "", summary->derivatives.methods[k]));
  PetscCall(MpmTextFileAppend(text, "],\n  \"gradient_error\": ["));
  for (PetscInt k = 0; k < count; k++)
    PetscCall(MpmTextFileAppend(text, "%s%.3g", k ? ", " : "", (double)summary->derivatives.errors[k]));
  PetscCall(MpmTextFileAppend(text, "],\n"));
  if (summary->derivatives.fields)
    PetscCall(MpmTextFileAppend(text, "  \"gradient_fields\": {%s},\n", summary->derivatives.fields));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode AppendSummary(MpmTextFile *text, PetscMPIInt ranks, const char *version,
                                    const MpmSummary *summary)
{
  PetscFunctionBeginUser;
  PetscCall(MpmTextFileAppend(text, "{\n"));
  PetscCall(AppendString(text, "status", summary->status));
  PetscCall(AppendString(text, "version", version));
  PetscCall(AppendString(text, "title", summary->scene.title));
  PetscCall(AppendCount(text, "ranks", ranks));
  PetscCall(AppendCount(text, "dim", summary->dim));
  PetscCall(AppendString(text, "physics", summary->scene.physics));
  PetscCall(AppendString(text, "shape", summary->scene.shape));
  PetscCall(AppendString(text, "jacobian", summary->solution.jacobian));
  PetscCall(AppendString(text, "solver", summary->solution.solver));
  PetscCall(AppendCount(text, "points", summary->points));
  PetscCall(AppendCount(text, "cells", summary->cells));
  PetscCall(AppendCount(text, "active_dofs_max", summary->active_dofs_max));
  PetscCall(AppendCount(text, "steps", summary->effort.steps));
  PetscCall(AppendCount(text, "step_cuts", summary->effort.step_cuts));
  PetscCall(AppendCount(text, "newton_iterations", summary->effort.newton_iterations));
  PetscCall(AppendCount(text, "linear_iterations", summary->effort.linear_iterations));
  if (summary->effort.levels) {
    PetscCall(AppendCount(text, "iterations_multigrid", summary->effort.linear_iterations));
    PetscCall(AppendCount(text, "levels", summary->effort.levels));
  }
  PetscCall(MpmTextFileAppend(text, "  \"changes\": {"));
  for (PetscInt k = 0, any = 0; k < MPM_CHANGE_COUNT; k++) {
    if (!summary->changes[k]) continue;
    PetscCall(MpmTextFileAppend(text, "%s\"%s\": %d", any ? ", " : "", MpmChanges[k], (int)summary->changes[k]));
    any = 1;
  }
  PetscCall(MpmTextFileAppend(text, "},\n"));
  PetscCall(AppendDerivatives(text, summary));
  if (summary->terrain) PetscCall(MpmTextFileAppend(text, "%s", summary->terrain));
  PetscCall(MpmTextFileAppend(text, "  \"imbalance\": "));
  PetscCall(AppendNumber(text, summary->imbalance));
  PetscCall(MpmTextFileAppend(text, ",\n"));
  PetscCall(AppendCount(text, "rebalances", summary->rebalances));
  if (summary->reduces) {
    PetscCall(MpmTextFileAppend(text, "  \"factor_of_safety\": "));
    PetscCall(AppendNumber(text, summary->factor_of_safety > 0. ? summary->factor_of_safety : HUGE_VAL));
    PetscCall(MpmTextFileAppend(text, ",\n"));
  }
  for (int i = 0; summary->relaxes && i < 2; i++) {
    PetscCall(MpmTextFileAppend(text, "  \"criteria_%s\": ", i ? "since" : "first"));
    PetscCall(AppendNumber(text, summary->criteria[i] >= 0. ? summary->criteria[i] : HUGE_VAL));
    PetscCall(MpmTextFileAppend(text, ",\n"));
  }
  PetscCall(MpmTextFileAppend(text, "  \"time_total_s\": "));
  PetscCall(AppendNumber(text, summary->time_total));
  PetscCall(MpmTextFileAppend(text, ",\n  \"time\": {"));
  for (int i = 0; i < MPM_TIME_COUNT; ++i) {
    PetscCall(MpmTextFileAppend(text, "%s\"%s\": ", i ? ", " : "", MpmTimers[i]));
    PetscCall(AppendNumber(text, summary->time[i]));
  }
  PetscCall(MpmTextFileAppend(text, "},\n  \"memory_max_bytes\": "));
  PetscCall(MpmTextFileAppend(text, "%.0f\n}\n", (double)summary->memory_max));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSummaryWrite(MPI_Comm comm, const char *path, const char *version, const MpmSummary *summary)
{
  PetscMPIInt        rank, size;
  MpmTextFile        text    = MPM_TEXT_FILE_EMPTY;
  const MpmTextFile *texts[] = {&text};
  PetscErrorCode     written;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCallMPI(MPI_Comm_size(comm, &size));
  if (rank == 0) PetscCall(AppendSummary(&text, size, version, summary));
  written = MpmTextFileWrite(comm, path, 1, texts);
  PetscCall(MpmTextFileDestroy(&text));
  PetscCall(written);
  PetscFunctionReturn(PETSC_SUCCESS);
}

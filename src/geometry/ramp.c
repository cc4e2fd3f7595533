/*
  MpmRamp - a piecewise linear factor of time from "time:factor" pairs, constant before the first and after the last.

  Two pairs at one time make a jump; at that very time the later pair counts. Thus "0:0,1:0,1:1" is 0 until just before
  1, and 1 at 1.
*/
#include "options/options.h"
#include "files/csv_table.h"
#include "geometry/geometry.h"

#include <stdlib.h>
#include <string.h>

struct _p_MpmRamp {
  PetscInt   count;
  PetscReal *time, *factor;
  PetscReal *first, *second; /* integrals from the first row on to each; NULL: not needed yet */
};

static PetscErrorCode SetIntegrals(MpmRamp ramp);

/* Parses one pair in place; returns its fault, or NULL. */
static const char *ParsePair(MpmRamp ramp, char pair[])
{
  const PetscInt i     = ramp->count;
  char          *colon = strchr(pair, ':');

  if (!colon) return "must be time:factor pairs, separated by commas";
  *colon = '\0';
  if (!MpmParseReal(pair, &ramp->time[i]) || !MpmParseReal(colon + 1, &ramp->factor[i]))
    return "must be time:factor pairs of numbers";
  if (i && ramp->time[i] < ramp->time[i - 1]) return "times must not decrease";
  ramp->count++;
  return NULL;
}

static PetscErrorCode ParsePairs(MpmRamp ramp, const char text[], const char **wrong)
{
  PetscInt pairs = 1;
  char    *copy, *next;

  PetscFunctionBegin;
  *wrong = NULL;
  for (const char *c = text; *c; c++) pairs += (*c == ',');
  PetscCall(PetscMalloc2((size_t)pairs, &ramp->time, (size_t)pairs, &ramp->factor));
  PetscCall(PetscStrallocpy(text, &copy));
  for (char *pair = copy; pair && !*wrong; pair = next) {
    next = strchr(pair, ',');
    if (next) *next++ = '\0';
    *wrong = ParsePair(ramp, pair);
  }
  PetscCall(PetscFree(copy));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmRampCreate(const MpmOptions *options, const char *name, const char *fallback, MpmRamp *ramp)
{
  MpmRamp     r;
  const char *wrong;
  char       *text, *quoted;

  PetscFunctionBegin;
  *ramp = NULL;
  PetscCall(MpmOptionsText(options, name, "factor over time, time:factor pairs (s:-)", fallback, MPM_OPTIONAL, &text));
  PetscCall(PetscNew(&r));
  PetscCall(ParsePairs(r, text ? text : "", &wrong));
  if (wrong) {
    PetscCall(MpmRampDestroy(&r));
    PetscCall(MpmTextQuote(text ? text : "", &quoted));
    MpmCheckInput(PETSC_FALSE, "-%s%s %s: %s", options->prefix ? options->prefix : "", name, quoted, wrong);
  }
  PetscCall(PetscFree(text));
  PetscCall(SetIntegrals(r));
  *ramp = r;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmRampDestroy(MpmRamp *ramp)
{
  PetscFunctionBegin;
  if (!*ramp) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscFree2((*ramp)->time, (*ramp)->factor));
  PetscCall(PetscFree2((*ramp)->first, (*ramp)->second));
  PetscCall(PetscFree(*ramp));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The number of rows that are not later than a time. */
static PetscInt RowsUntil(MpmRamp ramp, PetscReal time)
{
  PetscInt low = 0, high = ramp->count;

  while (low < high) {
    const PetscInt middle = low + (high - low) / 2;

    if (ramp->time[middle] <= time) low = middle + 1;
    else high = middle;
  }
  return low;
}

PetscReal MpmRampEvaluate(MpmRamp ramp, PetscReal time)
{
  const PetscInt after = RowsUntil(ramp, time);

  if (after == 0) return ramp->factor[0];
  if (after == ramp->count) return ramp->factor[after - 1];
  /* time[after - 1] <= time < time[after], so the difference is not zero */
  const PetscReal along = (time - ramp->time[after - 1]) / (ramp->time[after] - ramp->time[after - 1]);
  return (1. - along) * ramp->factor[after - 1] + along * ramp->factor[after];
}

/* ---- integrals ---- */

/* Slope behind a row, 1/s; 0 behind the last one and in a jump. */
static PetscReal Slope(MpmRamp ramp, PetscInt row)
{
  const PetscReal length = row + 1 < ramp->count ? ramp->time[row + 1] - ramp->time[row] : 0.;

  return length > 0. ? (ramp->factor[row + 1] - ramp->factor[row]) / length : 0.;
}

/* From the first row's time on; before it the factor is the first row's. */
static PetscReal FromFirstRow(MpmRamp ramp, PetscReal time, PetscInt order)
{
  const PetscInt  row   = PetscMax(RowsUntil(ramp, time) - 1, 0);
  const PetscReal t     = time - ramp->time[row];
  const PetscReal slope = t < 0. ? 0. : Slope(ramp, row);

  if (order == 1) return ramp->first[row] + t * (ramp->factor[row] + t * slope / 2.);
  return ramp->second[row] + t * (ramp->first[row] + t * (ramp->factor[row] / 2. + t * slope / 6.));
}

static PetscErrorCode SetIntegrals(MpmRamp ramp)
{
  PetscFunctionBegin;
  PetscCall(PetscCalloc2((size_t)ramp->count, &ramp->first, (size_t)ramp->count, &ramp->second));
  for (PetscInt row = 0; row + 1 < ramp->count; row++) {
    const PetscReal t = ramp->time[row + 1] - ramp->time[row], slope = Slope(ramp, row);

    ramp->first[row + 1]  = ramp->first[row] + t * (ramp->factor[row] + t * slope / 2.);
    ramp->second[row + 1] = ramp->second[row] + t * (ramp->first[row] + t * (ramp->factor[row] / 2. + t * slope / 6.));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The slope that leads to a time. */
static PetscReal SlopeBefore(MpmRamp ramp, PetscReal time)
{
  PetscInt row = 0;

  while (row < ramp->count && ramp->time[row] < time) row++;
  return row ? Slope(ramp, row - 1) : 0.;
}

PetscReal MpmRampIntegral(MpmRamp ramp, PetscReal time, PetscInt order)
{
  if (order == 0) return MpmRampEvaluate(ramp, time);
  if (order == -1) return SlopeBefore(ramp, time);
  if (order < -1) return 0.;
  if (order == 1) return FromFirstRow(ramp, time, 1) - FromFirstRow(ramp, 0., 1);
  return FromFirstRow(ramp, time, 2) - FromFirstRow(ramp, 0., 2) - time * FromFirstRow(ramp, 0., 1);
}

/* ---- tables ---- */

#define UNEVEN 1.5 /* a longer interval of a record, in those that are most frequent, is a hole */

static int CompareReals(const void *a, const void *b)
{
  const PetscReal x = *(const PetscReal *)a, y = *(const PetscReal *)b;

  return (x > y) - (x < y);
}

/* Rows must grow in time; those of a record must be even: the middle one of the intervals says how. */
static PetscErrorCode CheckTimes(const PetscReal time[], PetscInt rows, PetscBool record, char message[MPM_CSV_MESSAGE])
{
  PetscReal *interval;
  char       text[2][MPM_NUMBER_TEXT];

  PetscFunctionBegin;
  PetscCall(PetscMalloc1((size_t)rows, &interval));
  for (PetscInt k = 0; k + 1 < rows && !message[0]; k++) {
    interval[k] = time[k + 1] - time[k];
    if (interval[k] > 0.) continue;
    MpmRealText(time[k + 1], text[0]);
    MpmRealText(time[k], text[1]);
    PetscCall(PetscSNPrintf(message, MPM_CSV_MESSAGE,
                            "time must grow from row to row: %s s of row %" PetscInt_FMT " follows %s s", text[0],
                            k + 2, text[1]));
  }
  if (record && rows > 2 && !message[0]) {
    PetscReal usual;

    qsort(interval, (size_t)(rows - 1), sizeof(*interval), CompareReals);
    usual = interval[(rows - 2) / 2];
    for (PetscInt k = 0; k + 1 < rows && !message[0]; k++) {
      if (time[k + 1] - time[k] <= UNEVEN * usual) continue;
      MpmRealText(time[k], text[0]);
      MpmRealText(time[k + 1], text[1]);
      PetscCall(PetscSNPrintf(message, MPM_CSV_MESSAGE,
                              "a hole in time: nothing between %s s and %s s, where rows are %g s apart", text[0],
                              text[1], (double)usual));
    }
  }
  PetscCall(PetscFree(interval));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads the ramp from a file, on one rank. */
static PetscErrorCode TakeTable(const char *path, PetscBool record, MpmRamp ramp, char message[MPM_CSV_MESSAGE])
{
  MpmCsvTable table = {0};
  PetscInt    time, value, first = record ? 1 : 0;

  PetscFunctionBegin;
  PetscCall(MpmCsvTableRead(path, &table, message));
  time  = MpmCsvTableFind(&table, "time");
  value = MpmCsvTableFind(&table, "value");
  if (!message[0] && (time < 0 || value < 0 || table.columns != 2)) {
    PetscCall(PetscSNPrintf(message, MPM_CSV_MESSAGE, "must have the columns time and value"));
    PetscCall(MpmCsvTableNames(&table, message));
  }
  if (!message[0] && !table.rows) PetscCall(PetscSNPrintf(message, MPM_CSV_MESSAGE, "has no rows"));
  if (!message[0] && record && table.rows < 2)
    PetscCall(PetscSNPrintf(message, MPM_CSV_MESSAGE, "has a single row: a record has two at least"));
  PetscCall(MpmCsvTableFinite(&table, -1, message));
  if (!message[0]) {
    const PetscInt rows = (PetscInt)table.rows;

    ramp->count = rows + 2 * first;
    PetscCall(PetscCalloc2((size_t)ramp->count, &ramp->time, (size_t)ramp->count, &ramp->factor));
    for (PetscInt k = 0; k < rows; k++) {
      ramp->time[first + k]   = table.value[2 * k + time];
      ramp->factor[first + k] = table.value[2 * k + value];
    }
    PetscCall(CheckTimes(&ramp->time[first], rows, record, message));
    ramp->time[0]               = ramp->time[first];
    ramp->time[ramp->count - 1] = ramp->time[first + rows - 1];
  }
  PetscCall(MpmCsvTableDestroy(&table));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmRampReadTable(const MpmOptions *options, const char *name, PetscBool record, MpmRamp *ramp)
{
  char        message[MPM_CSV_MESSAGE] = "", *path;
  MpmRamp     r;
  PetscMPIInt rank;

  PetscFunctionBegin;
  *ramp = NULL;
  PetscCall(
    MpmOptionsPath(options, name,
                   "in place of ramp, a CSV file with the columns time (s) and value, the factor; of a velocity or an "
                   "acceleration a record with even intervals, 0 outside of it",
                   MPM_OPTIONAL, &path));
  if (!path || MpmOptionsHelp()) {
    PetscCall(PetscFree(path));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(PetscNew(&r));
  PetscCallMPI(MPI_Comm_rank(options->comm, &rank));
  if (!rank) PetscCall(TakeTable(path, record, r, message));
  PetscCallMPI(MPI_Bcast(message, MPM_CSV_MESSAGE, MPI_CHAR, 0, options->comm));
  if (message[0]) PetscCall(MpmRampDestroy(&r));
  MpmCheckInput(!message[0], "-%s%s %s: %s", options->prefix, name, path, message);
  PetscCallMPI(MPI_Bcast(&r->count, 1, MPIU_INT, 0, options->comm));
  if (rank) PetscCall(PetscMalloc2((size_t)r->count, &r->time, (size_t)r->count, &r->factor));
  PetscCallMPI(MPI_Bcast(r->time, (PetscMPIInt)r->count, MPIU_REAL, 0, options->comm));
  PetscCallMPI(MPI_Bcast(r->factor, (PetscMPIInt)r->count, MPIU_REAL, 0, options->comm));
  PetscCall(SetIntegrals(r));
  PetscCall(PetscFree(path));
  *ramp = r;
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MpmRampBounds(MpmRamp ramp, PetscReal *least, PetscReal *most)
{
  *least = *most = ramp->factor[0];
  for (PetscInt k = 1; k < ramp->count; k++) {
    *least = PetscMin(*least, ramp->factor[k]);
    *most  = PetscMax(*most, ramp->factor[k]);
  }
}

PetscReal MpmRampLastChange(MpmRamp ramp)
{
  for (PetscInt k = ramp->count - 1; k > 0; k--)
    if (ramp->factor[k] != ramp->factor[k - 1]) return ramp->time[k];
  return PETSC_NINFINITY;
}

/*
  Tables of members and their statistics, and the summary.

  PREFIX_members.csv     a row a member: number, status, draws, results; not-a-number where it was not completed
  PREFIX_statistics.csv  a row a draw and a result over the members that were completed, with Spearman's correlation of
                         ranks with each draw
*/
#include <math.h>
#include <string.h>
#include "ensemble/ensemble.h"

/* Columns of the table: draws, then results by the names of the first member that has them. */
typedef struct {
  PetscInt     rows, count;  /* members that were completed, columns */
  const char **names;        /* borrowed */
  PetscReal   *values;       /* [column*rows + row] */
  PetscReal   *ranks, *work; /* of two columns; one */
} Table;

PetscReal MpmQuantileOf(PetscInt count, const PetscReal sorted[], PetscReal share)
{
  const PetscReal place = share * (PetscReal)(count - 1);
  const PetscInt  first = PetscMin((PetscInt)place, PetscMax(count - 2, 0)), next = PetscMin(first + 1, count - 1);

  return sorted[first] + (place - (PetscReal)first) * (sorted[next] - sorted[first]);
}

static PetscBool IsDone(const MpmMember *member)
{
  return (PetscBool)(member->run && member->status == MPM_MEMBER_DONE);
}

static const MpmMember *FirstDone(const MpmEnsemble *ensemble, const MpmMember members[])
{
  for (PetscInt m = 0; m < ensemble->members; m++)
    if (IsDone(&members[m])) return &members[m];
  return NULL;
}

/* A result by its name; not-a-number where the member has none. */
static PetscReal ResultOf(const MpmMember *member, PetscInt place, const char name[])
{
  if (place < member->count && !strcmp(member->names[place], name)) return member->values[place];
  for (PetscInt k = 0; k < member->count; k++)
    if (!strcmp(member->names[k], name)) return member->values[k];
  return (PetscReal)NAN;
}

/* ---- members ---- */

static PetscErrorCode AppendNumber(MpmTextFile *text, PetscReal value)
{
  PetscFunctionBeginUser;
  if (PetscIsNanReal(value)) PetscCall(MpmTextFileAppend(text, ",nan"));
  else PetscCall(MpmTextFileAppend(text, ",%.17g", (double)value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode AppendMembers(const MpmEnsemble *ensemble, const MpmMember members[], MpmTextFile *text)
{
  const MpmMember *first = FirstDone(ensemble, members);

  PetscFunctionBeginUser;
  PetscCall(MpmTextFileAppend(text, "member,status%s", ensemble->terrain ? ",noise_seed" : ""));
  for (PetscInt k = 0; k < ensemble->draw_count; k++) PetscCall(MpmTextFileAppend(text, ",%s", ensemble->names[k]));
  for (PetscInt k = 0; first && k < first->count; k++) PetscCall(MpmTextFileAppend(text, ",%s", first->names[k]));
  PetscCall(MpmTextFileAppend(text, "\n"));
  for (PetscInt m = 0; m < ensemble->members; m++) {
    if (!members[m].run) continue;
    PetscCall(MpmTextFileAppend(text, "%d,%d", (int)m, (int)members[m].status));
    if (ensemble->terrain) PetscCall(MpmTextFileAppend(text, ",%d", (int)MpmTerrainSeed(ensemble, m)));
    for (PetscInt k = 0; k < ensemble->draw_count; k++) PetscCall(AppendNumber(text, MpmDrawValue(ensemble, k, m)));
    for (PetscInt k = 0; first && k < first->count; k++)
      PetscCall(AppendNumber(text, ResultOf(&members[m], k, first->names[k])));
    PetscCall(MpmTextFileAppend(text, "\n"));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- statistics ---- */

static PetscErrorCode TableCreate(const MpmEnsemble *ensemble, const MpmMember members[], Table *table)
{
  const MpmMember *first = FirstDone(ensemble, members);
  PetscInt         row   = 0;

  PetscFunctionBeginUser;
  *table = (Table){.count = ensemble->draw_count + (first ? first->count : 0)};
  for (PetscInt m = 0; m < ensemble->members; m++) table->rows += IsDone(&members[m]) ? 1 : 0;
  PetscCall(PetscMalloc4(table->count, &table->names, (size_t)table->count * (size_t)table->rows, &table->values,
                         2 * (size_t)table->rows, &table->ranks, table->rows, &table->work));
  for (PetscInt k = 0; k < table->count; k++)
    table->names[k] = k < ensemble->draw_count ? ensemble->names[k] : first->names[k - ensemble->draw_count];
  for (PetscInt m = 0; m < ensemble->members; m++) {
    if (!IsDone(&members[m])) continue;
    for (PetscInt k = 0; k < table->count; k++)
      table->values[k * table->rows + row] = k < ensemble->draw_count
                                               ? MpmDrawValue(ensemble, k, m)
                                               : ResultOf(&members[m], k - ensemble->draw_count, table->names[k]);
    row++;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Ranks of the values from 0 on, equal ones with the mean of theirs. */
static PetscErrorCode FindRanks(PetscInt count, const PetscReal values[], PetscReal work[], PetscReal ranks[])
{
  PetscInt *order;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(count, &order));
  PetscCall(PetscArraycpy(work, values, count));
  for (PetscInt m = 0; m < count; m++) order[m] = m;
  PetscCall(PetscSortRealWithArrayInt(count, work, order));
  for (PetscInt from = 0, to; from < count; from = to) {
    for (to = from + 1; to < count && work[to] == work[from];) to++;
    for (PetscInt m = from; m < to; m++) ranks[order[m]] = 0.5 * (PetscReal)(from + to - 1);
  }
  PetscCall(PetscFree(order));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Correlation of the ranks of two columns over the rows that have both. */
static PetscErrorCode Correlate(const Table *table, PetscInt a, PetscInt b, PetscReal *value)
{
  PetscReal *pair, sums[3] = {0., 0., 0.}, mean;
  PetscInt   count = 0;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(2 * (size_t)table->rows, &pair));
  for (PetscInt m = 0; m < table->rows; m++) {
    const PetscReal x = table->values[a * table->rows + m], y = table->values[b * table->rows + m];

    if (PetscIsNanReal(x) || PetscIsNanReal(y)) continue;
    pair[count]                 = x;
    pair[table->rows + count++] = y;
  }
  PetscCall(FindRanks(count, pair, table->work, table->ranks));
  PetscCall(FindRanks(count, &pair[table->rows], table->work, &table->ranks[table->rows]));
  mean = 0.5 * (PetscReal)(count - 1);
  for (PetscInt m = 0; m < count; m++) {
    const PetscReal x = table->ranks[m] - mean, y = table->ranks[table->rows + m] - mean;

    sums[0] += x * x;
    sums[1] += x * y;
    sums[2] += y * y;
  }
  *value = sums[0] > 0. && sums[2] > 0. ? sums[1] / PetscSqrtReal(sums[0] * sums[2]) : (PetscReal)NAN;
  PetscCall(PetscFree(pair));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The values of a column that are there, sorted. */
static PetscErrorCode SortColumn(const Table *table, PetscInt k, PetscInt *count)
{
  PetscFunctionBeginUser;
  *count = 0;
  for (PetscInt m = 0; m < table->rows; m++)
    if (!PetscIsNanReal(table->values[k * table->rows + m]))
      table->work[(*count)++] = table->values[k * table->rows + m];
  PetscCall(PetscSortReal(*count, table->work));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode AppendColumn(const MpmEnsemble *ensemble, const Table *table, PetscInt k, MpmTextFile *text)
{
  PetscReal mean = 0., square = 0.;
  PetscInt  count;

  PetscFunctionBeginUser;
  PetscCall(SortColumn(table, k, &count));
  for (PetscInt m = 0; m < count; m++) mean += table->work[m];
  mean /= (PetscReal)PetscMax(count, 1);
  for (PetscInt m = 0; m < count; m++) square += PetscSqr(table->work[m] - mean);
  PetscCall(MpmTextFileAppend(text, "%s,%d", table->names[k], (int)count));
  PetscCall(AppendNumber(text, count ? mean : (PetscReal)NAN));
  PetscCall(AppendNumber(text, count > 1 ? PetscSqrtReal(square / (PetscReal)(count - 1)) : (PetscReal)NAN));
  PetscCall(AppendNumber(text, count ? table->work[0] : (PetscReal)NAN));
  PetscCall(AppendNumber(text, count ? table->work[count - 1] : (PetscReal)NAN));
  for (PetscInt q = 0; q < ensemble->ask.quantile_count; q++)
    PetscCall(
      AppendNumber(text, count ? MpmQuantileOf(count, table->work, ensemble->ask.quantiles[q]) : (PetscReal)NAN));
  for (PetscInt d = 0; d < ensemble->draw_count; d++) {
    PetscReal value = 0.;

    PetscCall(Correlate(table, d, k, &value));
    PetscCall(AppendNumber(text, value));
  }
  PetscCall(MpmTextFileAppend(text, "\n"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode AppendStatistics(const MpmEnsemble *ensemble, const MpmMember members[], MpmTextFile *text)
{
  Table table;

  PetscFunctionBeginUser;
  PetscCall(TableCreate(ensemble, members, &table));
  PetscCall(MpmTextFileAppend(text, "name,count,mean,deviation,least,largest"));
  for (PetscInt q = 0; q < ensemble->ask.quantile_count; q++)
    PetscCall(MpmTextFileAppend(text, ",quantile_%g", (double)ensemble->ask.quantiles[q]));
  for (PetscInt k = 0; k < ensemble->draw_count; k++)
    PetscCall(MpmTextFileAppend(text, ",rank_%s", ensemble->names[k]));
  PetscCall(MpmTextFileAppend(text, "\n"));
  for (PetscInt k = 0; k < table.count; k++) PetscCall(AppendColumn(ensemble, &table, k, text));
  PetscCall(PetscFree4(table.names, table.values, table.ranks, table.work));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- files ---- */

/* The file PREFIX_NAME. */
static PetscErrorCode Write(const MpmModel model, const char name[], MpmTextFile *text)
{
  const MpmTextFile *texts[] = {text};
  char               path[PETSC_MAX_PATH_LEN];

  PetscFunctionBeginUser;
  PetscCall(PetscSNPrintf(path, sizeof(path), "%s_%s", model->scene.name.prefix, name));
  PetscCall(MpmTextFileWrite(model->comm, path, 1, texts));
  PetscCall(MpmTextFileDestroy(text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmEnsembleWriteTables(MpmModel model, const MpmMember members[])
{
  MpmTextFile text = MPM_TEXT_FILE_EMPTY;

  PetscFunctionBeginUser;
  if (!model->rank) PetscCall(AppendMembers(model->ensemble, members, &text));
  PetscCall(Write(model, "members.csv", &text));
  if (!model->rank) PetscCall(AppendStatistics(model->ensemble, members, &text));
  PetscCall(Write(model, "statistics.csv", &text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Members of a status with their reasons, as a list. */
static PetscErrorCode AppendFaults(const MpmEnsemble *ensemble, const MpmMember members[], MpmMemberStatus status,
                                   const char key[], MpmTextFile *text)
{
  const char *between = "";

  PetscFunctionBeginUser;
  PetscCall(MpmTextFileAppend(text, ",\n  \"%s\": [", key));
  for (PetscInt m = 0; m < ensemble->members; m++) {
    if (!members[m].run || members[m].status != status) continue;
    PetscCall(MpmTextFileAppend(text, "%s{\"member\": %d, \"why\": \"", between, (int)m));
    for (const char *c = members[m].why; *c; c++) {
      if (*c == '"' || *c == '\\') PetscCall(MpmTextFileAppend(text, "\\"));
      PetscCall(MpmTextFileAppend(text, "%c", (unsigned char)*c < ' ' ? ' ' : *c));
    }
    PetscCall(MpmTextFileAppend(text, "\"}"));
    between = ", ";
  }
  PetscCall(MpmTextFileAppend(text, "]"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmEnsembleWriteSummary(MpmModel model, const MpmMember members[], const MpmEnsembleTimes *times,
                                       PetscBool interrupted)
{
  const MpmEnsemble *ensemble = model->ensemble;
  MpmTextFile        text     = MPM_TEXT_FILE_EMPTY;
  PetscInt           done     = 0;

  PetscFunctionBeginUser;
  for (PetscInt m = 0; m < ensemble->members; m++) done += IsDone(&members[m]) ? 1 : 0;
  if (!model->rank) {
    PetscCall(MpmTextFileAppend(&text, "{\n  \"status\": \"%s\",\n  \"version\": \"%s\",\n  \"task\": \"ensemble\"",
                                interrupted ? "interrupted"
                                : done      ? "completed"
                                            : "no member was completed",
                                MPM_VERSION));
    PetscCall(MpmTextFileAppend(&text,
                                ",\n  \"ranks\": %d,\n  \"groups\": %d,\n  \"members\": %d,\n  \"completed\": %d",
                                (int)model->size, (int)ensemble->groups, (int)ensemble->members, (int)done));
    PetscCall(AppendFaults(ensemble, members, MPM_MEMBER_REFUSED, "refused", &text));
    PetscCall(AppendFaults(ensemble, members, MPM_MEMBER_FAILED, "failed", &text));
    PetscCall(MpmTextFileAppend(&text,
                                ",\n  \"time_total_s\": %.6g,\n  \"time_members_s\": %.6g,\n  \"time_own_s\": %.6g"
                                "\n}\n",
                                (double)times->all, (double)times->members, (double)times->own));
  }
  PetscCall(Write(model, "summary.json", &text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

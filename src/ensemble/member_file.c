/*
  Files of members: numbers of a run that has ended, and the row that says so.

  PREFIX_members/0007_member.csv has scene, number, status and seconds, and in a remark the reason of a member that was
  refused or failed. A file that is there is whole: a run that was killed has left none, and its member runs again.
*/
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include "files/csv_table.h"
#include "maps/json.h"
#include "ensemble/ensemble.h"

#define FACTOR "factor_of_safety"

/* Columns of the history that are no results: they count steps and work. */
static const char *const work[] = {"step", "dt", "newton", "linear", "cuts", "load", NULL};

void MpmMemberPrefix(const MpmModel model, PetscInt member, char prefix[PETSC_MAX_PATH_LEN])
{
  (void)snprintf(prefix, PETSC_MAX_PATH_LEN, "%s_members/%04d", model->scene.name.prefix, (int)member);
}

static void Path(const MpmModel model, PetscInt member, char path[PETSC_MAX_PATH_LEN])
{
  (void)snprintf(path, PETSC_MAX_PATH_LEN, "%s_members/%04d_member.csv", model->scene.name.prefix, (int)member);
}

PetscErrorCode MpmMemberRemove(const MpmModel model, PetscInt number)
{
  char path[PETSC_MAX_PATH_LEN];

  PetscFunctionBeginUser;
  Path(model, number, path);
  (void)unlink(path);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmMemberDestroy(MpmMember *member)
{
  PetscFunctionBeginUser;
  PetscCall(MpmNamesDestroy(member->count, &member->names));
  PetscCall(PetscFree(member->values));
  *member = (MpmMember){0};
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Add(MpmMember *member, const char name[], PetscReal value)
{
  PetscFunctionBeginUser;
  PetscCall(PetscRealloc((size_t)(member->count + 1) * sizeof(*member->names), &member->names));
  PetscCall(PetscRealloc((size_t)(member->count + 1) * sizeof(*member->values), &member->values));
  PetscCall(PetscStrallocpy(name, &member->names[member->count]));
  member->values[member->count++] = value;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- numbers of a run ---- */

/* The first line of a file and the last whole one, without their ends; NULL where there are none. Free with free(). */
static void ReadEnds(const char path[], char **first, char **last)
{
  FILE  *file = fopen(path, "r");
  size_t room = 0, count = 0;
  long   end  = 0;
  char  *tail = NULL, *begin;

  *first = *last = NULL;
  if (!file) return;
  if (getline(first, &room, file) > 0 && !fseek(file, 0, SEEK_END)) end = ftell(file);
  if (end > 0) {
    const size_t back = PetscMin((size_t)end, 40 * strlen(*first) + 4096);

    tail = (char *)calloc(back + 1, 1);
    if (tail && !fseek(file, end - (long)back, SEEK_SET)) count = fread(tail, 1, back, file);
  }
  while (count && tail[count - 1] != '\n') count--; /* a row that is not whole */
  if (count) tail[count - 1] = '\0';
  begin = count ? strrchr(tail, '\n') : NULL;
  *last = begin ? strdup(begin + 1) : NULL;
  free(tail);
  (void)fclose(file);
}

/* The last row of a history, without the columns of work. */
static PetscErrorCode ReadHistory(const char prefix[], MpmMember *all)
{
  char  path[PETSC_MAX_PATH_LEN];
  char *names, *values, *name, *kept;

  PetscFunctionBeginUser;
  (void)snprintf(path, sizeof(path), "%s_history.csv", prefix);
  ReadEnds(path, &names, &values);
  if (names && values) {
    char *value = values;

    for (name = strtok_r(names, ",\n", &kept); name; name = strtok_r(NULL, ",\n", &kept)) {
      const PetscReal number = (PetscReal)strtod(value, &value);
      PetscInt        w      = 0;

      value += *value == ',';
      while (work[w] && strcmp(work[w], name)) w++;
      if (!work[w]) PetscCall(Add(all, name, number));
    }
  }
  free(names);
  free(values);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A number of the summary, by its key, or keys at points; false where it is none, not-a-number where it is null. */
static PetscBool FindNumber(const MpmJson *json, const char name[], PetscReal *value)
{
  char     key[MPM_MEMBER_TEXT], *kept;
  PetscInt node = 0;

  (void)snprintf(key, sizeof(key), "%s", name);
  for (char *part = strtok_r(key, ".", &kept); part && node >= 0; part = strtok_r(NULL, ".", &kept))
    node = MpmJsonMember(json, node, part);
  if (node < 0) return PETSC_FALSE;
  *value = json->node[node].type == MPM_JSON_NUMBER ? json->node[node].number : (PetscReal)NAN;
  return (PetscBool)(json->node[node].type == MPM_JSON_NUMBER || !strcmp(json->node[node].text, "null"));
}

static PetscErrorCode ReadSummary(const char prefix[], MpmJson *json, char message[])
{
  char  path[PETSC_MAX_PATH_LEN], fault[MPM_CSV_MESSAGE] = "";
  char *text = NULL;

  PetscFunctionBeginUser;
  (void)snprintf(path, sizeof(path), "%s_summary.json", prefix);
  PetscCall(MpmTextRead(path, &text, fault));
  if (fault[0] || MpmJsonParse(text, json) >= 0)
    (void)snprintf(message, MPM_MEMBER_TEXT, "%.300s: %.100s", path, fault[0] ? fault : "is no JSON");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* One result by its name; a fault goes into the message. */
static PetscErrorCode AddResult(const char name[], const MpmMember *history, const MpmJson *summary, MpmMember *member,
                                char message[])
{
  PetscReal value = (PetscReal)NAN;
  PetscBool found = PETSC_FALSE;
  char     *names = NULL;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < history->count && !found; k++) {
    found = (PetscBool)!strcmp(history->names[k], name);
    if (found) value = history->values[k];
    PetscCall(MpmTextAppend(&names, "%s%s", names ? ", " : "", history->names[k]));
  }
  if (!found && !FindNumber(summary, name, &value))
    (void)snprintf(message, MPM_MEMBER_TEXT,
                   "-mpm_ensemble_results %s: the history has no such column, nor the summary such a number; there are "
                   "%s",
                   name, names ? names : "none");
  PetscCall(PetscFree(names));
  PetscCall(Add(member, name, value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmMemberCollect(const MpmEnsemble *ensemble, const char prefix[], MpmMember *member,
                                char message[MPM_MEMBER_TEXT])
{
  const MpmEnsembleAsk *ask     = &ensemble->ask;
  MpmMember             history = {0};
  MpmJson               summary = {0};
  PetscReal             factor;

  PetscFunctionBeginUser;
  PetscCall(ReadHistory(prefix, &history));
  PetscCall(ReadSummary(prefix, &summary, message));
  for (PetscInt k = 0; k < ask->result_count && !message[0]; k++)
    PetscCall(AddResult(ask->results[k], &history, &summary, member, message));
  for (PetscInt k = 0; k < history.count && !ask->result_count; k++)
    PetscCall(Add(member, history.names[k], history.values[k]));
  if (!ask->result_count && !message[0] && FindNumber(&summary, FACTOR, &factor))
    PetscCall(Add(member, FACTOR, factor));
  MpmJsonDestroy(&summary);
  PetscCall(MpmMemberDestroy(&history));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the row ---- */

PetscErrorCode MpmMemberWrite(MPI_Comm group, const MpmModel model, PetscInt number, const MpmMember *member)
{
  MpmTextFile        text    = MPM_TEXT_FILE_EMPTY;
  const MpmTextFile *texts[] = {&text};
  char               path[PETSC_MAX_PATH_LEN];

  PetscFunctionBeginUser;
  Path(model, number, path);
  PetscCall(MpmTextFileAppend(&text, "scene,member,status,seconds\n%lld,%d,%d,%.6g\n",
                              (long long)model->ensemble->scene, (int)number, (int)member->status,
                              (double)member->seconds));
  if (member->why[0]) PetscCall(MpmTextFileAppend(&text, "# %s\n", member->why));
  PetscCall(MpmTextFileWrite(group, path, 1, texts));
  PetscCall(MpmTextFileDestroy(&text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmMemberRead(const MpmModel model, PetscInt number, MpmMember *member, PetscBool *there)
{
  char        path[PETSC_MAX_PATH_LEN], message[MPM_CSV_MESSAGE] = "";
  char       *text = NULL, *why;
  const char *row  = NULL;
  long long   scene;
  int         at, status;

  PetscFunctionBeginUser;
  *there = PETSC_FALSE;
  Path(model, number, path);
  PetscCall(MpmTextRead(path, &text, message));
  if (!message[0]) row = strchr(text, '\n');
  *there = (PetscBool)(row && sscanf(row, "%lld,%d,%d,%lf", &scene, &at, &status, &member->seconds) == 4 &&
                       scene == (long long)model->ensemble->scene && at == (int)number);
  if (*there) {
    member->status = (MpmMemberStatus)status;
    why            = strstr(row, "\n# ");
    if (why) {
      why[strcspn(why + 1, "\n") + 1] = '\0';
      (void)snprintf(member->why, sizeof(member->why), "%s", why + 3);
    }
  }
  PetscCall(PetscFree(text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

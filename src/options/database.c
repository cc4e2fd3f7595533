/*
  Options databases: looking options up by their exact names, and the database that each model has to itself.

  A model copies the options that are meant for it. Its own defaults and presets then go into the copy, and other models
  do not see them. Options used by the model are also marked as used at their origin, so that PETSc's -options_left
  lists unused ones only.
*/
#include "options/database.h"
#include "options/options.h"
#include "options/scene_file.h"

#include <stdlib.h>
#include <string.h>

typedef MpmDatabaseOption Pair;

/* ---- look-up ---- */

/*
  PetscOptionsFindPair() is the only look-up, and it marks its results as used, in a fallback too. Presence therefore
  follows from the two calls that go by exact names: the used options, and the list of unused ones.
*/
PetscErrorCode MpmDatabaseHas(const char name[], PetscBool *has)
{
  PetscInt count;
  char   **names, **values;

  PetscFunctionBegin;
  PetscCall(PetscOptionsUsed(NULL, name, has));
  if (*has) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscOptionsLeftGet(NULL, &count, &names, &values));
  for (PetscInt i = 0; i < count && !*has; i++) PetscCall(PetscStrcasecmp(names[i], name, has));
  PetscCall(PetscOptionsLeftRestore(NULL, &count, &names, &values));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmDatabaseFind(const char name[], const char **value, PetscBool *given)
{
  char *key = NULL;

  PetscFunctionBegin;
  *value = NULL;
  PetscCall(MpmDatabaseHas(name, given));
  if (!*given) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmTextAppend(&key, "-%s", name));
  PetscCall(PetscOptionsFindPair(NULL, NULL, key, value, given));
  PetscCall(PetscFree(key));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmDatabaseDefault(const char name[], const char value[])
{
  PetscBool set;

  PetscFunctionBegin;
  PetscCall(MpmDatabaseHas(name + 1, &set));
  if (!set) PetscCall(PetscOptionsSetValue(NULL, name, value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static int ComparePairs(const void *a, const void *b)
{
  return strcmp(((const Pair *)a)->name, ((const Pair *)b)->name);
}

static PetscErrorCode PairsAdd(PetscInt *count, Pair *pairs, const char name[], const char value[])
{
  PetscBool same = PETSC_FALSE;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < *count && !same; i++) PetscCall(PetscStrcasecmp(pairs[i].name, name, &same));
  if (!same) pairs[(*count)++] = (Pair){name, value};
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* PetscOptionsGetAll() returns one string without distinction of values and names, so that its words only serve as
   candidates. */
PetscErrorCode MpmDatabaseGet(PetscInt *count, Pair **pairs, char **text)
{
  PetscInt  left, words = 0;
  char    **names, **values;
  PetscBool used;

  PetscFunctionBegin;
  PetscCall(PetscOptionsGetAll(NULL, text));
  PetscCall(PetscOptionsLeftGet(NULL, &left, &names, &values));
  for (const char *c = *text; *c; c++) words += (*c == '-');
  PetscCall(PetscMalloc1((size_t)(left + words + 1), pairs));
  *count = 0;
  for (PetscInt i = 0; i < left; i++) PetscCall(PairsAdd(count, *pairs, names[i], values[i]));
  PetscCall(PetscOptionsLeftRestore(NULL, &left, &names, &values));
  for (char *word = strtok(*text, " "); word; word = strtok(NULL, " ")) {
    const char *value;

    if (word[0] != '-' || !word[1]) continue;
    PetscCall(PetscOptionsUsed(NULL, word + 1, &used));
    if (!used) continue;
    PetscCall(PetscOptionsFindPair(NULL, NULL, word, &value, &used));
    PetscCall(PairsAdd(count, *pairs, word + 1, value));
  }
  if (*count) qsort(*pairs, (size_t)*count, sizeof(Pair), ComparePairs);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmDatabaseIsOurs(const char name[], PetscBool *ours)
{
  char head[5];

  PetscFunctionBegin;
  while (*name == '-') name++; /* --mpm_dim, to PETSc, is the option -mpm_dim of one dash more, which is never used */
  PetscCall(PetscStrncpy(head, name, sizeof(head)));
  PetscCall(PetscStrcasecmp(head, "mpm_", ours));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmDatabaseGetForeign(PetscInt *count, MpmDatabaseOption **options, char **text)
{
  PetscInt all;

  PetscFunctionBegin;
  PetscCall(MpmDatabaseGet(&all, options, text));
  *count = 0;
  for (PetscInt i = 0; i < all; i++) {
    PetscBool ours;

    PetscCall(MpmDatabaseIsOurs((*options)[i].name, &ours));
    if (!ours) (*options)[(*count)++] = (*options)[i];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- a model's own ---- */

/* Marks the option as used: only a look-up does. */
static PetscErrorCode Mark(PetscOptions options, const char name[])
{
  char       *key = NULL;
  const char *value;
  PetscBool   given;

  PetscFunctionBegin;
  PetscCall(MpmTextAppend(&key, "-%s", name));
  PetscCall(PetscOptionsFindPair(options, NULL, key, &value, &given));
  PetscCall(PetscFree(key));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Takes over one option of the caller's, whose name there is `pair->name`, as `name`. */
static PetscErrorCode TakeOne(MpmDatabase *database, const Pair *pair, const char name[])
{
  MpmTakenOption *taken = &database->taken[database->count++];
  char           *key   = NULL;

  PetscFunctionBegin;
  PetscCall(MpmTextAppend(&key, "-%s", name));
  PetscCall(PetscOptionsSetValue(database->options, key, pair->value));
  PetscCall(PetscFree(key));
  PetscCall(PetscStrallocpy(pair->name, &taken->there));
  taken->here = taken->there + (strlen(pair->name) - strlen(name));
  PetscCall(PetscOptionsUsed(NULL, pair->name, &taken->used));
  if (taken->used) PetscCall(Mark(database->options, name));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmDatabaseCreate(MpmDatabase **database)
{
  PetscFunctionBegin;
  PetscCall(PetscNew(database));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmDatabaseTake(MpmDatabase *database, const char prefix[])
{
  const size_t length = prefix ? strlen(prefix) : 0;
  PetscInt     count;
  Pair        *pairs;
  char        *text;

  PetscFunctionBegin;
  if (database->options) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscOptionsCreate(&database->options));
  PetscCall(MpmDatabaseGet(&count, &pairs, &text));
  PetscCall(PetscCalloc1(count, &database->taken));
  for (PetscInt k = 0; k < count; k++) {
    PetscBool meant = PETSC_TRUE;

    if (length) PetscCall(PetscStrncmp(pairs[k].name, prefix, length, &meant));
    if (meant && pairs[k].name[length]) PetscCall(TakeOne(database, &pairs[k], &pairs[k].name[length]));
  }
  PetscCall(PetscFree(pairs));
  PetscCall(PetscFree(text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* One file of options; by every rank for itself, for not all ranks of the program need be the model's. */
static PetscErrorCode InsertFile(MpmDatabase *database, MPI_Comm comm, const char option[], const char path[])
{
  const PetscBool yaml = (PetscBool)!strcmp(option, "-options_file_yaml");
  PetscBool       readable;

  PetscFunctionBegin;
  PetscCall(PetscTestFile(path, 'r', &readable));
  MpmCheckInput(readable, "%s %s: the file cannot be read", option, path);
  PetscCall(MpmOptionsCheckFile(comm, option, path, yaml));
  PetscCall(MpmSourcesInsertFile(database->sources, PETSC_COMM_SELF, database->options, path, yaml));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* One option, which is a source of its own. */
static PetscErrorCode InsertOption(MpmDatabase *database, const char name[], const char value[])
{
  PetscOptions alone;

  PetscFunctionBegin;
  PetscCall(PetscOptionsSetValue(database->options, name, value));
  PetscCall(PetscOptionsCreate(&alone));
  PetscCall(PetscOptionsSetValue(alone, name, value));
  PetscCall(MpmSourcesAdd(database->sources, NULL, alone));
  PetscCall(PetscOptionsDestroy(&alone));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmDatabaseInsert(MpmDatabase *database, MPI_Comm comm, const char text[])
{
  char *copy, **words;
  int   count;

  PetscFunctionBegin;
  if (!database->options) PetscCall(PetscOptionsCreate(&database->options));
  if (!database->sources) PetscCall(MpmSourcesCreate(&database->sources));
  PetscCall(PetscStrallocpy(text, &copy));
  for (char *c = copy; *c; c++)
    if (strchr("\t\r\n", *c)) *c = ' ';
  PetscCall(PetscStrToArray(copy, ' ', &count, &words));
  for (int k = 0; k < count; k++) {
    const PetscBool last = (PetscBool)(k + 1 == count);

    if (!strcmp(words[k], "-options_file") || !strcmp(words[k], "-options_file_yaml")) {
      MpmCheckInput(!last, "%s: a file must follow", words[k]);
      PetscCall(InsertFile(database, comm, words[k], words[k + 1]));
      k++;
      continue;
    }
    MpmCheckInput(words[k][0] == '-', "%.100s: the name of an option, with its dash, was expected", words[k]);
    /* a value may begin with a dash where it is a number's */
    if (!last && (words[k + 1][0] != '-' || strspn(words[k + 1], "-.0123456789") > 1)) {
      PetscCall(InsertOption(database, words[k], words[k + 1]));
      k++;
    } else PetscCall(InsertOption(database, words[k], NULL));
  }
  PetscCall(PetscStrToArrayDestroy(count, words));
  PetscCall(PetscFree(copy));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmDatabaseEnter(MpmDatabase *database)
{
  PetscFunctionBegin;
  if (database->options && !database->depth++) PetscCall(PetscOptionsPush(database->options));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmDatabaseLeave(MpmDatabase *database)
{
  PetscFunctionBegin;
  if (!database->options || --database->depth) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscOptionsPop());
  for (PetscInt k = 0; k < database->count; k++) {
    MpmTakenOption *taken = &database->taken[k];
    PetscBool       there;

    if (taken->used) continue;
    PetscCall(PetscOptionsUsed(database->options, taken->here, &taken->used));
    if (!taken->used) continue;
    PetscCall(MpmDatabaseHas(taken->there, &there));
    if (there) PetscCall(Mark(NULL, taken->there));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmDatabaseDestroy(MpmDatabase **database)
{
  PetscFunctionBegin;
  if (!*database) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt k = 0; k < (*database)->count; k++) PetscCall(PetscFree((*database)->taken[k].there));
  PetscCall(PetscFree((*database)->taken));
  PetscCall(MpmSourcesDestroy(&(*database)->sources));
  if ((*database)->options) PetscCall(PetscOptionsDestroy(&(*database)->options));
  PetscCall(PetscFree(*database));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  The typed readers of options.h: numbers, words and switches.

  A reader describes its option in an MpmOptionSpec; MpmItemRead() derives from it the line of -help, the entry in the
  record and the complaint about a missing option, so that the three cannot disagree. Then the reader parses all of the
  given text and checks it.

  With -help a required option that is missing is no error: the run only prints its manual and ends. The reader then
  leaves the value as it was on entry (lists, texts and names: empty), so callers initialise all values, required or
  not.

  A refusal ends the run, so memory allocated before it is not freed.
*/
#include "options/help.h"
#include "options/item.h"
#include "options/options.h"

#include <ctype.h>
#include <stdio.h>
#include <string.h>

static void IntRangeText(PetscInt lower, PetscInt upper, char text[MPM_RANGE_TEXT])
{
  const long long low = (long long)lower, high = (long long)upper;

  text[0] = '\0';
  if (lower > PETSC_INT_MIN && upper < PETSC_INT_MAX) snprintf(text, MPM_RANGE_TEXT, "in [%lld, %lld]", low, high);
  else if (lower > PETSC_INT_MIN) snprintf(text, MPM_RANGE_TEXT, ">= %lld", low);
  else if (upper < PETSC_INT_MAX) snprintf(text, MPM_RANGE_TEXT, "<= %lld", high);
}

/* Accepted values of a list of `count`: "2 values, each > 0"; no text for one value, nor for a number unknown to
   -help. */
static void ListText(PetscInt count, const char range[], char text[2 * MPM_RANGE_TEXT])
{
  if (count <= 1) snprintf(text, 2 * MPM_RANGE_TEXT, "%s", range);
  else if (*range) snprintf(text, 2 * MPM_RANGE_TEXT, "%lld values, each %s", (long long)count, range);
  else snprintf(text, 2 * MPM_RANGE_TEXT, "%lld values", (long long)count);
}

PetscBool MpmOptionsHelp(void)
{
  PetscBool help = PETSC_FALSE;

  (void)PetscOptionsHasHelp(NULL, &help);
  return help;
}

PetscErrorCode MpmOptionsHeading(const MpmOptions *options, const char *title)
{
  PetscBool help;

  PetscFunctionBegin;
  PetscCall(MpmRecordAddBlock(options->record, options->prefix));
  PetscCall(PetscOptionsHasHelp(NULL, &help));
  if (help && !strcmp(title, "bcs")) title = "conditions";
  if (help) PetscCall(MpmHelpHeading(options->comm, title));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmOptionsHas(const MpmOptions *options, const char *name, PetscBool *has)
{
  char           *full;
  MpmRecordEntry *entry;

  PetscFunctionBegin;
  PetscCall(MpmItemFullName(options, name, &full));
  PetscCall(MpmDatabaseHas(full, has));
  if (options->record) {
    PetscCall(MpmRecordGet(options->record, full, &entry));
    entry->presence = PETSC_TRUE;
  }
  PetscCall(PetscFree(full));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmOptionsOwnValue(const MpmOptions *options, const char *name, const char **value)
{
  char           *full;
  MpmRecordEntry *entry = NULL;

  PetscFunctionBegin;
  PetscCall(MpmItemFullName(options, name, &full));
  if (options->record) PetscCall(MpmRecordFind(options->record, full, &entry));
  *value = entry && entry->differs ? entry->value : NULL;
  PetscCall(PetscFree(full));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmOptionsReadReals(const MpmOptions *options, const MpmNumberOption *option, PetscInt count,
                                   PetscReal values[], PetscBool *set)
{
  char      interval[MPM_RANGE_TEXT], accepts[2 * MPM_RANGE_TEXT], number[MPM_NUMBER_TEXT];
  char     *fallback = NULL, **parts;
  PetscInt  part_count;
  PetscBool lasting = PETSC_TRUE;
  MpmItem   item;

  PetscFunctionBegin;
  MpmRangeText(option->range, interval);
  ListText(count, interval, accepts);
  for (PetscInt i = 0; i < count && option->need == MPM_OPTIONAL; i++) {
    MpmRealText(values[i], number);
    PetscCall(MpmTextAppend(&fallback, "%s%s", i ? "," : "", number));
    if (!MpmRangeHolds(option->range, values[i])) lasting = PETSC_FALSE;
  }
  const MpmOptionSpec spec = {option->name,      option->help, option->unit, accepts,
                              fallback,          option->need, lasting,      set ? PETSC_TRUE : PETSC_FALSE,
                              MPM_OPTION_NUMBER, count,        option->range};
  PetscCall(MpmItemRead(options, &spec, &item));
  if (item.given) {
    PetscCall(MpmTextSplit(item.raw ? item.raw : "", &part_count, &parts));
    if (part_count == 0) PetscCall(MpmItemRefuse(&item, &spec, "a value must follow"));
    PetscCall(MpmItemCheckCount(&item, &spec, count, part_count));
    for (PetscInt i = 0; i < count; i++) {
      PetscReal value;

      if (!MpmParseReal(parts[i], &value))
        PetscCall(MpmItemRefuseForm(&item, &spec, count == 1 ? "not a number" : "not a list of numbers"));
      if (!MpmRangeHolds(option->range, value)) PetscCall(MpmItemRefuseRange(&item, &spec, count, interval));
      values[i] = value;
    }
    PetscCall(MpmNamesDestroy(part_count, &parts));
  }
  PetscCall(PetscFree(fallback));
  PetscCall(MpmItemDestroy(&item, set));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmOptionsReadInts(const MpmOptions *options, const MpmNumberOption *option, PetscInt count,
                                  PetscInt values[], PetscBool *set)
{
  const PetscInt lower = option->lower, upper = option->upper;
  char           interval[MPM_RANGE_TEXT], accepts[2 * MPM_RANGE_TEXT];
  char          *fallback = NULL, **parts;
  PetscInt       part_count;
  PetscBool      lasting = PETSC_TRUE;
  MpmItem        item;

  PetscFunctionBegin;
  IntRangeText(lower, upper, interval);
  ListText(count, interval, accepts);
  for (PetscInt i = 0; i < count && option->need == MPM_OPTIONAL; i++) {
    PetscCall(MpmTextAppend(&fallback, "%s%lld", i ? "," : "", (long long)values[i]));
    if (values[i] < lower || values[i] > upper) lasting = PETSC_FALSE;
  }
  const MpmRange bounds = {lower > PETSC_INT_MIN ? (PetscReal)lower : PETSC_NINFINITY,
                           upper < PETSC_INT_MAX ? (PetscReal)upper : PETSC_INFINITY, PETSC_FALSE};
  const MpmOptionSpec spec = {option->name,       option->help, "-",     accepts,
                              fallback,           option->need, lasting, set ? PETSC_TRUE : PETSC_FALSE,
                              MPM_OPTION_INTEGER, count,        bounds};
  PetscCall(MpmItemRead(options, &spec, &item));
  if (item.given) {
    PetscCall(MpmTextSplit(item.raw ? item.raw : "", &part_count, &parts));
    if (part_count == 0) PetscCall(MpmItemRefuse(&item, &spec, "a value must follow"));
    PetscCall(MpmItemCheckCount(&item, &spec, count, part_count));
    for (PetscInt i = 0; i < count; i++) {
      PetscInt value;

      if (!MpmParseInt(parts[i], &value)) {
        PetscCall(MpmItemRefuseForm(&item, &spec, count == 1 ? "not a whole number" : "not a list of whole numbers"));
      }
      if (value < lower || value > upper) PetscCall(MpmItemRefuseRange(&item, &spec, count, interval));
      values[i] = value;
    }
    PetscCall(MpmNamesDestroy(part_count, &parts));
  }
  PetscCall(PetscFree(fallback));
  PetscCall(MpmItemDestroy(&item, set));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmOptionsRealList(const MpmOptions *options, const char *name, const char *unit, const char *help,
                                  MpmNeed need, PetscInt *count, PetscReal **values)
{
  const MpmOptionSpec spec = {name, help,         unit, "", NULL, need, PETSC_FALSE, PETSC_TRUE, MPM_OPTION_NUMBER,
                              0,    MPM_RANGE_ANY};
  char              **parts;
  MpmItem             item;

  PetscFunctionBegin;
  *count  = 0;
  *values = NULL;
  PetscCall(MpmItemRead(options, &spec, &item));
  if (item.given) {
    PetscCall(MpmTextSplit(item.raw ? item.raw : "", count, &parts));
    if (*count == 0) PetscCall(MpmItemRefuse(&item, &spec, "a value must follow"));
    PetscCall(PetscMalloc1((size_t)*count, values));
    for (PetscInt i = 0; i < *count; i++) {
      if (!MpmParseReal(parts[i], &(*values)[i])) PetscCall(MpmItemRefuseForm(&item, &spec, "not a list of numbers"));
    }
    PetscCall(MpmNamesDestroy(*count, &parts));
  }
  PetscCall(MpmItemDestroy(&item, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Index of `word` in the list, case aside; -1 where it is none of them. */
static PetscErrorCode FindWord(const char *const choices[], const char word[], PetscInt *index)
{
  PetscFunctionBegin;
  *index = -1;
  for (PetscInt i = 0; choices[i] && *index < 0; i++) {
    PetscBool same;

    PetscCall(PetscStrcasecmp(choices[i], word, &same));
    if (same) *index = i;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmOptionsWord(const MpmOptions *options, const char *name, const char *help,
                              const char *const choices[], MpmNeed need, PetscInt *value, PetscBool *set)
{
  char    *accepts = NULL, *refusal = NULL;
  PetscInt index;
  MpmItem  item;

  PetscFunctionBegin;
  for (PetscInt i = 0; choices[i]; i++) PetscCall(MpmTextAppend(&accepts, "%s%s", i ? ", " : "one of ", choices[i]));
  const MpmOptionSpec spec = {name,
                              help,
                              NULL,
                              accepts,
                              *value < 0 ? NULL : choices[*value],
                              need,
                              PETSC_TRUE,
                              set ? PETSC_TRUE : PETSC_FALSE,
                              MPM_OPTION_WORD,
                              1,
                              MPM_RANGE_ANY};
  PetscCall(MpmItemRead(options, &spec, &item));
  if (item.given) {
    PetscCall(FindWord(choices, item.raw ? item.raw : "", &index));
    if (index < 0) {
      PetscCall(MpmTextAppend(&refusal, "must be %s", accepts));
      PetscCall(MpmItemRefuse(&item, &spec, refusal));
    }
    *value = index;
  }
  PetscCall(PetscFree(accepts));
  PetscCall(MpmItemDestroy(&item, set));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmOptionsBool(const MpmOptions *options, const char *name, const char *help, PetscBool *value,
                              PetscBool *set)
{
  /* PETSc's own words, false and true in turn */
  static const char *const words[] = {"false", "true", "no", "yes", "0", "1", "off", "on", NULL};
  const MpmOptionSpec      spec    = {name,
                                      help,
                                      NULL,
                                      "true or false",
                              *value ? "true" : "false",
                                      MPM_OPTIONAL,
                                      PETSC_TRUE,
                              set ? PETSC_TRUE : PETSC_FALSE,
                                      MPM_OPTION_BOOLEAN,
                                      1,
                                      MPM_RANGE_ANY};
  PetscInt                 index;
  MpmItem                  item;

  PetscFunctionBegin;
  PetscCall(MpmItemRead(options, &spec, &item));
  if (item.given) {
    PetscCall(FindWord(words, item.raw ? item.raw : "true", &index));
    if (index < 0) PetscCall(MpmItemRefuse(&item, &spec, "must be true or false"));
    *value = index % 2 ? PETSC_TRUE : PETSC_FALSE;
  }
  PetscCall(MpmItemDestroy(&item, set));
  PetscFunctionReturn(PETSC_SUCCESS);
}

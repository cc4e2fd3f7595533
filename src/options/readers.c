/*
  The typed readers of options.h.

  A reader describes its option in an MpmOptionSpec; ItemRead() derives from it the line of -help, the entry in the
  record and the complaint about a missing option, so that the three cannot disagree. Then the reader parses all of the
  given text and checks it.

  With -help a required option that is missing is no error: the run only prints its manual and ends. The reader then
  leaves the value as it was on entry (lists, texts and names: empty), so callers initialise all values, required or
  not.

  A refusal ends the run, so memory allocated before it is not freed.
*/
#include "options/help.h"
#include "options/options.h"
#include "options/record.h"

#include <ctype.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

/* Text given by the user. */
typedef struct {
  char       *name; /* in full, no dash */
  const char *raw;  /* NULL when the option is absent or has no value; lent by PETSc */
  PetscBool   given;
} Item;

/* ---- one option ---- */

static PetscErrorCode FullName(const MpmOptions *options, const char name[], char **full)
{
  PetscFunctionBegin;
  *full = NULL;
  PetscCall(MpmTextAppend(full, "%s%s", options->prefix ? options->prefix : "", name));
  /* PETSc cuts longer names, and then finds the wrong option or none. */
  MpmCheckInput(strlen(*full) < PETSC_MAX_OPTION_NAME - 2, "-%.100s...: the name has more than %d characters", *full,
                PETSC_MAX_OPTION_NAME - 3);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* "Young's modulus (Pa), > 0" */
static PetscErrorCode ItemMeaning(const MpmOptionSpec *spec, char **text)
{
  PetscFunctionBegin;
  *text = NULL;
  PetscCall(MpmTextAppend(text, "%s", spec->help));
  if (spec->unit) PetscCall(MpmTextAppend(text, " (%s)", spec->unit));
  if (*spec->accepts) PetscCall(MpmTextAppend(text, ", %s", spec->accepts));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ItemRecord(MpmRecord record, const Item *item, const MpmOptionSpec *spec, PetscBool *first)
{
  MpmRecordEntry *entry;
  const char     *value = item->given ? (item->raw ? item->raw : "") : (spec->lasting ? spec->fallback : NULL);

  PetscFunctionBegin;
  *first = PETSC_TRUE;
  if (!record) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmRecordGet(record, item->name, &entry));
  *first       = entry->known ? PETSC_FALSE : PETSC_TRUE;
  entry->known = PETSC_TRUE;
  entry->given = item->given;
  if (spec->presence) entry->presence = PETSC_TRUE;
  PetscCall(PetscFree(entry->value));
  if (value) PetscCall(PetscStrallocpy(value, &entry->value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Looks an option up; ItemDestroy() when done. */
static PetscErrorCode ItemRead(const MpmOptions *options, const MpmOptionSpec *spec, Item *item)
{
  PetscBool help, first;
  char     *meaning = NULL;

  PetscFunctionBegin;
  PetscCall(FullName(options, spec->name, &item->name));
  PetscCall(MpmDatabaseFind(item->name, &item->raw, &item->given));
  PetscCall(ItemRecord(options->record, item, spec, &first));
  PetscCall(PetscOptionsHasHelp(NULL, &help));
  if (help && first) PetscCall(MpmHelpOption(options->comm, item->name, spec));
  if (!item->given && spec->need == MPM_REQUIRED && !help) {
    PetscCall(ItemMeaning(spec, &meaning));
    MpmCheckInput(PETSC_FALSE, "-%s is missing: %s", item->name, meaning);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ItemDestroy(Item *item, PetscBool *set)
{
  PetscFunctionBegin;
  if (set) *set = item->given;
  PetscCall(PetscFree(item->name));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Ends the run: "-name value: must ..." */
static PetscErrorCode ItemRefuse(const Item *item, const MpmOptionSpec *spec, const char verb[])
{
  char *value = NULL, *meaning;

  PetscFunctionBegin;
  if (!item->raw) {
    PetscCall(ItemMeaning(spec, &meaning));
    MpmCheckInput(PETSC_FALSE, "-%s: a value must follow: %s", item->name, meaning);
  }
  PetscCall(MpmTextQuote(item->raw, &value));
  MpmCheckInput(PETSC_FALSE, "-%s %s: %s", item->name, value, verb);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Ends the run, with the option's meaning: "-name value: must ...: Young's modulus (Pa), > 0". */
static PetscErrorCode ItemRefuseForm(const Item *item, const MpmOptionSpec *spec, const char verb[])
{
  char *text = NULL, *meaning;

  PetscFunctionBegin;
  PetscCall(ItemMeaning(spec, &meaning));
  PetscCall(MpmTextAppend(&text, "%s: %s", verb, meaning));
  PetscCall(ItemRefuse(item, spec, text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- ranges and lists ---- */

void MpmRangeText(MpmRange range, char text[MPM_RANGE_TEXT])
{
  const PetscBool below = range.lower > PETSC_NINFINITY ? PETSC_TRUE : PETSC_FALSE,
                  above = range.upper < PETSC_INFINITY ? PETSC_TRUE : PETSC_FALSE;
  char lower[MPM_NUMBER_TEXT], upper[MPM_NUMBER_TEXT];

  MpmRealText(range.lower, lower);
  MpmRealText(range.upper, upper);
  text[0] = '\0';
  if (below && above) snprintf(text, MPM_RANGE_TEXT, range.open ? "in (%s, %s)" : "in [%s, %s]", lower, upper);
  else if (below) snprintf(text, MPM_RANGE_TEXT, "%s %s", range.open ? ">" : ">=", lower);
  else if (above) snprintf(text, MPM_RANGE_TEXT, "%s %s", range.open ? "<" : "<=", upper);
}

PetscBool MpmRangeHolds(MpmRange range, PetscReal value)
{
  const PetscBool infinite = (value <= PETSC_NINFINITY || value >= PETSC_INFINITY) ? PETSC_TRUE : PETSC_FALSE;

  if (infinite) return PETSC_FALSE;
  if (range.open) return (value > range.lower && value < range.upper) ? PETSC_TRUE : PETSC_FALSE;
  return (value >= range.lower && value <= range.upper) ? PETSC_TRUE : PETSC_FALSE;
}

static void IntRangeText(PetscInt lower, PetscInt upper, char text[MPM_RANGE_TEXT])
{
  const long long low = (long long)lower, high = (long long)upper;

  text[0] = '\0';
  if (lower > PETSC_INT_MIN && upper < PETSC_INT_MAX) snprintf(text, MPM_RANGE_TEXT, "in [%lld, %lld]", low, high);
  else if (lower > PETSC_INT_MIN) snprintf(text, MPM_RANGE_TEXT, ">= %lld", low);
  else if (upper < PETSC_INT_MAX) snprintf(text, MPM_RANGE_TEXT, "<= %lld", high);
}

void MpmMustText(const char range[], const char unit[], char text[MPM_MUST_TEXT])
{
  const PetscBool named = (PetscBool)(unit && unit[0] && strcmp(unit, "-"));

  snprintf(text, MPM_MUST_TEXT, "must %s %s%s%s", strncmp(range, "in ", 3) ? "be" : "lie", range, named ? " " : "",
           named ? unit : "");
}

/* "must lie in (-1, 0.5)", "each must be > 0 Pa" */
static PetscErrorCode ItemRefuseRange(const Item *item, const MpmOptionSpec *spec, PetscInt count, const char range[])
{
  char must[MPM_MUST_TEXT], text[MPM_MUST_TEXT + 8];

  PetscFunctionBegin;
  MpmMustText(range, spec->unit, must);
  snprintf(text, sizeof(text), "%s%s", count == 1 ? "" : "each ", must);
  PetscCall(ItemRefuse(item, spec, text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Accepted values of a list of `count`: "2 values, each > 0"; no text for one value, nor for a number unknown to
   -help. */
static void ListText(PetscInt count, const char range[], char text[2 * MPM_RANGE_TEXT])
{
  if (count <= 1) snprintf(text, 2 * MPM_RANGE_TEXT, "%s", range);
  else if (*range) snprintf(text, 2 * MPM_RANGE_TEXT, "%lld values, each %s", (long long)count, range);
  else snprintf(text, 2 * MPM_RANGE_TEXT, "%lld values", (long long)count);
}

static PetscErrorCode CheckCount(const Item *item, const MpmOptionSpec *spec, PetscInt wanted, PetscInt count)
{
  char text[MPM_RANGE_TEXT];

  PetscFunctionBegin;
  if (wanted == count) PetscFunctionReturn(PETSC_SUCCESS);
  snprintf(text, sizeof(text), "must have %lld value%s, has %lld", (long long)wanted, wanted == 1 ? "" : "s",
           (long long)count);
  PetscCall(ItemRefuseForm(item, spec, text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- readers ---- */

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
  PetscCall(FullName(options, name, &full));
  PetscCall(MpmDatabaseHas(full, has));
  if (options->record) {
    PetscCall(MpmRecordGet(options->record, full, &entry));
    entry->presence = PETSC_TRUE;
  }
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
  Item      item;

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
  PetscCall(ItemRead(options, &spec, &item));
  if (item.given) {
    PetscCall(MpmTextSplit(item.raw ? item.raw : "", &part_count, &parts));
    if (part_count == 0) PetscCall(ItemRefuse(&item, &spec, "a value must follow"));
    PetscCall(CheckCount(&item, &spec, count, part_count));
    for (PetscInt i = 0; i < count; i++) {
      PetscReal value;

      if (!MpmParseReal(parts[i], &value))
        PetscCall(ItemRefuseForm(&item, &spec, count == 1 ? "not a number" : "not a list of numbers"));
      if (!MpmRangeHolds(option->range, value)) PetscCall(ItemRefuseRange(&item, &spec, count, interval));
      values[i] = value;
    }
    PetscCall(MpmNamesDestroy(part_count, &parts));
  }
  PetscCall(PetscFree(fallback));
  PetscCall(ItemDestroy(&item, set));
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
  Item           item;

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
  PetscCall(ItemRead(options, &spec, &item));
  if (item.given) {
    PetscCall(MpmTextSplit(item.raw ? item.raw : "", &part_count, &parts));
    if (part_count == 0) PetscCall(ItemRefuse(&item, &spec, "a value must follow"));
    PetscCall(CheckCount(&item, &spec, count, part_count));
    for (PetscInt i = 0; i < count; i++) {
      PetscInt value;

      if (!MpmParseInt(parts[i], &value)) {
        PetscCall(ItemRefuseForm(&item, &spec, count == 1 ? "not a whole number" : "not a list of whole numbers"));
      }
      if (value < lower || value > upper) PetscCall(ItemRefuseRange(&item, &spec, count, interval));
      values[i] = value;
    }
    PetscCall(MpmNamesDestroy(part_count, &parts));
  }
  PetscCall(PetscFree(fallback));
  PetscCall(ItemDestroy(&item, set));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmOptionsRealList(const MpmOptions *options, const char *name, const char *unit, const char *help,
                                  MpmNeed need, PetscInt *count, PetscReal **values)
{
  const MpmOptionSpec spec = {name, help,         unit, "", NULL, need, PETSC_FALSE, PETSC_TRUE, MPM_OPTION_NUMBER,
                              0,    MPM_RANGE_ANY};
  char              **parts;
  Item                item;

  PetscFunctionBegin;
  *count  = 0;
  *values = NULL;
  PetscCall(ItemRead(options, &spec, &item));
  if (item.given) {
    PetscCall(MpmTextSplit(item.raw ? item.raw : "", count, &parts));
    if (*count == 0) PetscCall(ItemRefuse(&item, &spec, "a value must follow"));
    PetscCall(PetscMalloc1((size_t)*count, values));
    for (PetscInt i = 0; i < *count; i++) {
      if (!MpmParseReal(parts[i], &(*values)[i])) PetscCall(ItemRefuseForm(&item, &spec, "not a list of numbers"));
    }
    PetscCall(MpmNamesDestroy(*count, &parts));
  }
  PetscCall(ItemDestroy(&item, NULL));
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
  Item     item;

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
  PetscCall(ItemRead(options, &spec, &item));
  if (item.given) {
    PetscCall(FindWord(choices, item.raw ? item.raw : "", &index));
    if (index < 0) {
      PetscCall(MpmTextAppend(&refusal, "must be %s", accepts));
      PetscCall(ItemRefuse(&item, &spec, refusal));
    }
    *value = index;
  }
  PetscCall(PetscFree(accepts));
  PetscCall(ItemDestroy(&item, set));
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
  Item                     item;

  PetscFunctionBegin;
  PetscCall(ItemRead(options, &spec, &item));
  if (item.given) {
    PetscCall(FindWord(words, item.raw ? item.raw : "true", &index));
    if (index < 0) PetscCall(ItemRefuse(&item, &spec, "must be true or false"));
    *value = index % 2 ? PETSC_TRUE : PETSC_FALSE;
  }
  PetscCall(ItemDestroy(&item, set));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Free text, or the name of a file. */
static PetscErrorCode ReadText(const MpmOptions *options, const MpmOptionSpec *spec, char **value)
{
  const char *fallback = spec->fallback;
  Item        item;

  PetscFunctionBegin;
  *value = NULL;
  PetscCall(ItemRead(options, spec, &item));
  if (item.given && !item.raw && spec->need == MPM_REQUIRED) PetscCall(ItemRefuse(&item, spec, "a value must follow"));
  if (item.given) PetscCall(PetscStrallocpy(item.raw ? item.raw : "", value));
  else if (fallback) PetscCall(PetscStrallocpy(fallback, value));
  PetscCall(ItemDestroy(&item, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmOptionsText(const MpmOptions *options, const char *name, const char *help, const char *fallback,
                              MpmNeed need, char **value)
{
  const MpmOptionSpec spec = {
    name, help, NULL, "text", fallback, need, PETSC_TRUE, PETSC_FALSE, MPM_OPTION_TEXT, 1, MPM_RANGE_ANY};

  PetscFunctionBegin;
  PetscCall(ReadText(options, &spec, value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Whether there is such a file, and another one than the second. */
static int IsOther(const char path[], const char second[])
{
  struct stat one, two;

  if (stat(path, &one)) return 0;
  return stat(second, &two) || one.st_dev != two.st_dev || one.st_ino != two.st_ino;
}

PetscErrorCode MpmOptionsResolve(const MpmOptions *options, const char *name, char **path)
{
  MpmRecord   record = options->record;
  char       *full, *beside = NULL;
  const char *scene, *slash;
  PetscMPIInt rank;
  int         found = 0;

  PetscFunctionBegin;
  if (!record || !*path || !**path || **path == '/') PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(FullName(options, name, &full));
  scene = MpmSourcesFile(record->sources, full);
  slash = scene ? strrchr(scene, '/') : NULL;
  if (slash) {
    PetscCall(MpmTextAppend(&beside, "%.*s%s", (int)(slash - scene) + 1, scene, *path));
    PetscCallMPI(MPI_Comm_rank(options->comm, &rank));
    if (!rank) found = IsOther(beside, *path);
    PetscCallMPI(MPI_Bcast(&found, 1, MPI_INT, 0, options->comm));
  }
  PetscCall(PetscFree(full));
  if (!found) PetscFunctionReturn(PetscFree(beside));
  PetscCall(PetscFree(*path));
  *path = beside;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmOptionsPath(const MpmOptions *options, const char *name, const char *help, MpmNeed need, char **value)
{
  const MpmOptionSpec spec = {name, help,         NULL, "text", NULL, need, PETSC_TRUE, PETSC_FALSE, MPM_OPTION_FILE,
                              1,    MPM_RANGE_ANY};
  MpmRecordEntry     *entry;
  char               *full;

  PetscFunctionBegin;
  PetscCall(ReadText(options, &spec, value));
  if (!*value || !options->record || MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmOptionsResolve(options, name, value));
  PetscCall(FullName(options, name, &full));
  PetscCall(MpmRecordGet(options->record, full, &entry));
  PetscCall(PetscFree(entry->value));
  PetscCall(PetscStrallocpy(*value, &entry->value));
  PetscCall(PetscFree(full));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Options are looked up case aside, so names that differ in case only would share their block. */
static PetscErrorCode CheckName(const Item *item, const MpmOptionSpec *spec, PetscInt index, char *const names[])
{
  const char *name = names[index];

  PetscFunctionBegin;
  for (const char *c = name; *c; c++) {
    if (!isalnum((unsigned char)*c) && *c != '_')
      PetscCall(ItemRefuse(item, spec, "names consist of letters, digits and underscores"));
  }
  if (!*name) PetscCall(ItemRefuse(item, spec, "a name is empty"));
  for (PetscInt i = 0; i < index; i++) {
    PetscBool same;

    PetscCall(PetscStrcasecmp(names[i], name, &same));
    if (same) PetscCall(ItemRefuse(item, spec, "two names are alike (upper and lower case are not told apart)"));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadNames(const MpmOptions *options, const char *name, const char *help, MpmOptionType type,
                                MpmNeed need, PetscInt *count, char ***names)
{
  const char *accepted     = type == MPM_OPTION_BLOCKS ? "names of blocks, comma-separated" : "names, comma-separated";
  const MpmOptionSpec spec = {name, help, NULL, accepted, NULL, need, PETSC_FALSE, PETSC_FALSE, type, 0, MPM_RANGE_ANY};
  Item                item;

  PetscFunctionBegin;
  *count = 0;
  *names = NULL;
  PetscCall(ItemRead(options, &spec, &item));
  if (item.given) {
    PetscCall(MpmTextSplit(item.raw ? item.raw : "", count, names));
    if (*count == 0 && need == MPM_REQUIRED) PetscCall(ItemRefuse(&item, &spec, "a value must follow"));
    for (PetscInt i = 0; i < *count; i++) PetscCall(CheckName(&item, &spec, i, *names));
    if (*count == 0) PetscCall(PetscFree(*names));
  }
  PetscCall(ItemDestroy(&item, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmOptionsNames(const MpmOptions *options, const char *name, const char *help, MpmNeed need,
                               PetscInt *count, char ***names)
{
  PetscFunctionBegin;
  PetscCall(ReadNames(options, name, help, MPM_OPTION_NAMES, need, count, names));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmOptionsBlocks(const MpmOptions *options, const char *list, const char *help, MpmNeed need,
                                PetscInt *count, char ***names)
{
  PetscFunctionBegin;
  PetscCall(MpmOptionsHeading(options, list));
  PetscCall(ReadNames(options, list, help, MPM_OPTION_BLOCKS, need, count, names));
  if (options->record) {
    MpmRecordEntry *entry;
    char           *full;

    PetscCall(FullName(options, list, &full));
    PetscCall(MpmRecordGet(options->record, full, &entry));
    entry->list = PETSC_TRUE;
    PetscCall(PetscFree(full));
  }
  if (*count || !MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  *count = 1;
  PetscCall(PetscMalloc1(1, names));
  PetscCall(PetscStrallocpy("NAME", *names));
  PetscFunctionReturn(PETSC_SUCCESS);
}

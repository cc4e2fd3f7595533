/*
  Parameters as options of the scene: soil.E is a number of -mpm_material_soil_E, gravity.factor one of all gravity
  loads.

  A name BLOCK.KEY means every option that has been read whose name is mpm_BLOCK_KEY, or mpm_WORD_BLOCK_KEY where WORD
  is that of a list of blocks: material, load, stage; or mpm_WORD_NAME_BLOCK_KEY within one of these. KEY:2 and KEY:y
  are the second number of an option with several.
*/
#include <string.h>
#include "options/database.h"
#include "options/options.h"
#include "options/record.h"
#include "loads/load.h"
#include "query/scene_parameter.h"

#define MOST_EDITS 2        /* of a slip that a name is suggested for */
#define TEXT       256      /* of names */
#define PARTS      ",:; \t" /* between the numbers of an option */
/* Option by which messages name the parameter. */
#define OPTION(parameter) ((parameter)->option ? (parameter)->option : "-mpm_parameters")

/* Options that a block's factor multiplies. */
static const struct {
  const char *word;
  const char *key[4];
} factors[] = {
  {"load", {"value"}},
  {"bc", {"value"}},
  {"motion", {"value"}},
  {"surface", {"traction", "normal", "pressure"}},
  {"boundary", {"motion", "rotation"}},
};

/* A name in its parts. */
typedef struct {
  char     block[TEXT], key[TEXT];
  PetscInt place; /* -1: none is named */
} Name;

/* ---- numbers in a text ---- */

/* The next number from `text` on, of `length` characters; NULL at the end. */
static const char *NextNumber(const char text[], size_t *length)
{
  const char *start = text + strspn(text, PARTS);

  *length = strcspn(start, PARTS);
  return *start ? start : NULL;
}

/* The number at a place in a text; false where there is none. */
static PetscBool NumberAt(const char text[], PetscInt place, PetscReal *value)
{
  size_t      length;
  const char *start = NextNumber(text, &length);

  for (PetscInt k = 0; start && k < place; k++) start = NextNumber(&start[length], &length);
  if (start) {
    char part[MPM_NUMBER_TEXT * 2];

    if (length >= sizeof(part)) return PETSC_FALSE;
    memcpy(part, start, length);
    part[length] = '\0';
    return MpmParseReal(part, value);
  }
  return PETSC_FALSE;
}

static PetscInt CountNumbers(const char text[])
{
  PetscReal value;
  PetscInt  count = 0;

  while (NumberAt(text, count, &value)) count++;
  return count;
}

/* The text in force with a number replaced, or the scene's with all of them times the value. */
static PetscErrorCode Replace(const MpmParameterOption *option, double value, char **text)
{
  const char *start = option->text, *present;
  PetscBool   given;
  size_t      length;
  PetscInt    at = 0;

  PetscFunctionBeginUser;
  *text = NULL;
  PetscCall(MpmDatabaseFind(&option->name[1], &present, &given));
  if (present && option->place >= 0) start = present;
  for (const char *next = NextNumber(start, &length); next; next = NextNumber(start, &length), at++) {
    PetscReal number = 0.;

    PetscCall(MpmTextAppend(text, "%.*s", (int)(next - start), start));
    (void)NumberAt(next, 0, &number);
    if (option->place < 0) PetscCall(MpmTextAppend(text, "%.17g", (double)(value * number)));
    else if (option->place == at) PetscCall(MpmTextAppend(text, "%.17g", value));
    else PetscCall(MpmTextAppend(text, "%.*s", (int)length, next));
    start = next + length;
  }
  PetscCall(MpmTextAppend(text, "%s", start));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSceneParameterSet(const MpmSceneParameter *parameter, double value)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < parameter->option_count; k++) {
    char *text;

    PetscCall(Replace(&parameter->options[k], value, &text));
    PetscCall(PetscOptionsSetValue(NULL, parameter->options[k].name, text));
    PetscCall(PetscFree(text));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSceneParameterReset(const MpmSceneParameter *parameter)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < parameter->option_count; k++) {
    const MpmParameterOption *option = &parameter->options[k];

    if (option->given) PetscCall(PetscOptionsSetValue(NULL, option->name, option->text));
    else PetscCall(PetscOptionsClearValue(NULL, option->name));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- names ---- */

/* BLOCK.KEY and the place behind a colon; `gravity` alone has a factor. */
static PetscErrorCode Split(const MpmSceneParameter *parameter, Name *name)
{
  const char  *text = parameter->name, *dot = strchr(text, '.'), *colon = dot ? strchr(dot, ':') : NULL;
  const size_t length = dot ? (size_t)(dot - text) : strlen(text);
  long         number;

  PetscFunctionBeginUser;
  name->place = -1;
  MpmCheckInput((dot && length && dot[1] && dot + 1 != colon) || !strcmp(text, "gravity"),
                "%s %s: must be NAME.KEY, a block by its name and a number of it", OPTION(parameter), text);
  MpmCheckInput(strlen(text) < TEXT, "%s %.100s...: is too long", OPTION(parameter), text);
  PetscCall(PetscSNPrintf(name->block, TEXT, "%.*s", (int)length, text));
  PetscCall(PetscSNPrintf(name->key, TEXT, "%.*s", (int)(colon ? colon - dot - 1 : TEXT), dot ? dot + 1 : "factor"));
  for (char *c = name->key; *c; c++)
    if (*c == '.') *c = '_';
  if (!colon) PetscFunctionReturn(PETSC_SUCCESS);
  number      = strtol(colon + 1, NULL, 10);
  name->place = colon[1] >= 'x' && colon[1] <= 'z' && !colon[2] ? colon[1] - 'x' : (PetscInt)number - 1;
  MpmCheckInput(name->place >= 0, "%s %s: behind the colon must stand x, y, z, or a number from 1 on",
                OPTION(parameter), text);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* True where a scope's head is a list's word, or a block of a list: stage_, stage_rest_. */
static PetscBool IsOfList(MpmRecord record, const char head[], size_t length)
{
  for (PetscInt i = 0; i < record->count; i++) {
    char   prefix[PETSC_MAX_OPTION_NAME];
    size_t word;

    if (!record->entries[i].list) continue;
    MpmRecordBlockPrefix(record->entries[i].name, prefix);
    word = strlen(prefix) - strlen("mpm_");
    if (word > length || strncmp(&prefix[strlen("mpm_")], head, word)) continue;
    if (word == length || memchr(&head[word], '_', length - word) == &head[length - 1]) return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* True where options mpm_<scope>_ are those of a block of this name: soil of material_soil, geostatic of
   stage_rest_geostatic. */
static PetscBool IsBlock(MpmRecord record, const char scope[], size_t length, const char block[])
{
  const size_t whole = strlen(block);

  if (length == whole) return (PetscBool)!strncmp(scope, block, length);
  if (length < whole + 2 || strncmp(&scope[length - whole], block, whole) || scope[length - whole - 1] != '_')
    return PETSC_FALSE;
  return IsOfList(record, scope, length - whole);
}

/* The scope of an option with this key, material_soil of mpm_material_soil_E, and its length; 0: it has another key. */
static size_t Scope(const char option[], const char key[], const char **scope)
{
  const size_t head = strlen("mpm_"), whole = strlen(option), tail = strlen(key) + 1;

  *scope = &option[head];
  if (strncmp(option, "mpm_", head) || whole <= head + tail || option[whole - tail] != '_') return 0;
  return strcmp(&option[whole - tail + 1], key) ? 0 : whole - head - tail;
}

/* The next entry from `at` on of an option that the name means. */
static const MpmRecordEntry *NextMeant(MpmRecord record, const char block[], const char key[], PetscInt *at)
{
  while (*at < record->count) {
    const MpmRecordEntry *entry = &record->entries[(*at)++];
    const char           *scope;
    const size_t          length = Scope(entry->name, key, &scope);

    if (entry->known && entry->numbers && entry->value && length && IsBlock(record, scope, length, block)) return entry;
  }
  return NULL;
}

/* ---- refusals ---- */

/* Refuses a number that the scene does not give, and that has no default. */
static PetscErrorCode RefuseAbsent(MpmRecord record, const MpmSceneParameter *parameter, const Name *name)
{
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < record->count; i++) {
    const char  *scope;
    const size_t length = Scope(record->entries[i].name, name->key, &scope);

    MpmCheckInput(!length || record->entries[i].value || !record->entries[i].known ||
                    !IsBlock(record, scope, length, name->block),
                  "%s %s: the scene does not give it, and it has no default", OPTION(parameter), parameter->name);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Refuses a name that means nothing, with the nearest one. */
static PetscErrorCode RefuseUnknown(MpmRecord record, const MpmSceneParameter *parameter, const Name *name)
{
  char    *keys = NULL, *near = NULL;
  PetscInt best = MOST_EDITS + 1;

  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < record->count; i++) {
    const MpmRecordEntry *entry = &record->entries[i];
    const size_t          block = strlen(name->block);
    const char           *place = strstr(entry->name, name->block);
    PetscReal             value;
    PetscInt              distance;

    if (!entry->known || !entry->numbers || !entry->value || !NumberAt(entry->value, 0, &value)) continue;
    if (!place || place[block] != '_' ||
        !IsBlock(record, &entry->name[4], (size_t)(&place[block] - entry->name) - 4, name->block))
      continue;
    distance = MpmTextDistance(&place[block + 1], name->key);
    PetscCall(MpmTextAppend(&keys, "%s%s", keys ? ", " : "", &place[block + 1]));
    if (distance >= best) continue;
    best = distance;
    PetscCall(PetscFree(near));
    PetscCall(MpmTextAppend(&near, "%s", &place[block + 1]));
  }
  MpmCheckInput(!near, "%s %s: %s has no number %s; did you mean %s.%s?", OPTION(parameter), parameter->name,
                name->block, name->key, name->block, near);
  MpmCheckInput(!keys, "%s %s: %s has no number %s; it has %s", OPTION(parameter), parameter->name, name->block,
                name->key, keys);
  for (PetscInt i = 0; i < record->count; i++) {
    const MpmRecordEntry *entry = &record->entries[i];
    PetscInt              count;
    char                **names;

    if (!entry->list || !entry->value) continue;
    PetscCall(MpmTextSplit(entry->value, &count, &names));
    MpmCheckInput(!MpmTextNearest(name->block, count, names, MOST_EDITS),
                  "%s %s: no block has this name; did you mean %s.%s?", OPTION(parameter), parameter->name,
                  MpmTextNearest(name->block, count, names, MOST_EDITS), name->key);
    PetscCall(MpmNamesDestroy(count, &names));
  }
  MpmCheckInput(PETSC_FALSE, "%s %s: no block has this name", OPTION(parameter), parameter->name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds a candidate's name, material_soil.E, to those of an ambiguous one. */
static PetscErrorCode AddCandidate(const char scope[], size_t length, const char key[], char **candidates)
{
  PetscFunctionBeginUser;
  PetscCall(MpmTextAppend(candidates, "%s%.*s.%s", *candidates ? " or " : "", (int)length, scope, key));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- options of a name ---- */

static PetscErrorCode AddOption(const MpmRecordEntry *entry, PetscInt place, MpmSceneParameter *parameter)
{
  MpmParameterOption *option;

  PetscFunctionBeginUser;
  PetscCall(PetscRealloc((size_t)(parameter->option_count + 1) * sizeof(*option), &parameter->options));
  option  = &parameter->options[parameter->option_count++];
  *option = (MpmParameterOption){.given = entry->given, .place = place};
  PetscCall(MpmTextAppend(&option->name, "-%s", entry->name));
  PetscCall(PetscStrallocpy(entry->value, &option->text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Options of a block's magnitudes. */
static PetscErrorCode FindFactor(MpmRecord record, const Name *name, char **candidates, MpmSceneParameter *parameter)
{
  PetscFunctionBeginUser;
  for (size_t f = 0; f < PETSC_STATIC_ARRAY_LENGTH(factors); f++) {
    const size_t          head  = strlen(factors[f].word);
    PetscBool             found = PETSC_FALSE;
    const MpmRecordEntry *entry;

    for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(factors[f].key) && factors[f].key[k]; k++) {
      for (PetscInt at = 0; (entry = NextMeant(record, name->block, factors[f].key[k], &at));) {
        const char  *scope;
        const size_t length = Scope(entry->name, factors[f].key[k], &scope);

        if (strncmp(scope, factors[f].word, head) || scope[head] != '_' || !entry->given) continue;
        PetscCall(AddOption(entry, -1, parameter));
        if (!found) PetscCall(AddCandidate(scope, length, name->key, candidates));
        found = PETSC_TRUE;
      }
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* All gravity loads, by their common factor. */
static PetscErrorCode FindGravity(MpmRecord record, const MpmLoads *loads, MpmSceneParameter *parameter)
{
  PetscFunctionBeginUser;
  for (PetscInt l = 0; l < loads->count; l++) {
    char            name[PETSC_MAX_OPTION_NAME];
    MpmRecordEntry *entry;

    if (loads->at[l].type != MPM_LOAD_GRAVITY) continue;
    PetscCall(PetscSNPrintf(name, sizeof(name), "mpm_load_%s_value", loads->at[l].name));
    PetscCall(MpmRecordFind(record, name, &entry));
    if (entry) PetscCall(AddOption(entry, -1, parameter));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The one number that the name means. */
static PetscErrorCode FindNumber(MpmRecord record, const Name *name, char **candidates, MpmSceneParameter *parameter)
{
  const MpmRecordEntry *entry;

  PetscFunctionBeginUser;
  for (PetscInt at = 0; (entry = NextMeant(record, name->block, name->key, &at));) {
    const PetscInt count = CountNumbers(entry->value), place = PetscMax(name->place, 0);
    const char    *scope;
    const size_t   length = Scope(entry->name, name->key, &scope);
    PetscReal      value;

    if (!count) continue;
    PetscCall(AddCandidate(scope, length, name->key, candidates));
    if (parameter->option_count) continue;
    MpmCheckInput(place<count, "%s %s: -%s %s has %" PetscInt_FMT " number%s", OPTION(parameter), parameter->name,
                        entry->name, entry->value, count, count> 1
                    ? "s"
                    : "");
    MpmCheckInput(count == 1 || name->place >= 0,
                  "%s %s: -%s %s has %" PetscInt_FMT " numbers; %s:1 is the first, %s:2 the second", OPTION(parameter),
                  parameter->name, entry->name, entry->value, count, parameter->name, parameter->name);
    MpmCheckInput(entry->given || !entry->presence || !strncmp(scope, "material_", strlen("material_")),
                  "%s %s: -%s is not given, and would change its meaning with a value", OPTION(parameter),
                  parameter->name, entry->name);
    PetscCall(AddOption(entry, place, parameter));
    (void)NumberAt(entry->value, place, &value);
    parameter->value = (double)value;
    parameter->range = entry->range;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmParameterFindOptions(MpmRecord record, const MpmLoads *loads, MpmSceneParameter *parameter)
{
  char *candidates = NULL;
  Name  name;

  PetscFunctionBeginUser;
  PetscCall(Split(parameter, &name));
  parameter->kind  = MPM_OF_OPTION;
  parameter->range = MPM_RANGE_ANY;
  parameter->value = 1.;
  if (strcmp(name.key, "factor")) PetscCall(FindNumber(record, &name, &candidates, parameter));
  else if (!strcmp(name.block, "gravity")) PetscCall(FindGravity(record, loads, parameter));
  if (!parameter->option_count && !strcmp(name.key, "factor"))
    PetscCall(FindFactor(record, &name, &candidates, parameter));
  if (!parameter->option_count) PetscCall(RefuseAbsent(record, parameter, &name));
  if (!parameter->option_count) PetscCall(RefuseUnknown(record, parameter, &name));
  MpmCheckInput(!candidates || !strstr(candidates, " or "), "%s %s: must be %s: several blocks have this name",
                OPTION(parameter), parameter->name, candidates);
  PetscCall(PetscFree(candidates));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscBool MpmSceneParametersMeet(const MpmSceneParameter *a, const MpmSceneParameter *b)
{
  for (PetscInt i = 0; i < a->option_count; i++) {
    const MpmParameterOption *of = &a->options[i];

    for (PetscInt j = 0; j < b->option_count; j++) {
      const PetscInt place = b->options[j].place;

      if (!strcmp(of->name, b->options[j].name) && (of->place == place || of->place < 0 || place < 0))
        return PETSC_TRUE;
    }
  }
  return PETSC_FALSE;
}

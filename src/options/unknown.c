/*
  Options that nobody has asked for, once the scene has been read.

  A block is what has a prefix of its own, such as mpm_body_beam_; a slip is looked for in the option's own block.
  Blocks with names stand in lists: mpm_bodies names the blocks mpm_body_<name>_. An option of a block that is in no
  list ends the run, unless the list was given later than the block: it leaves the block out then, and a warning says
  so.
*/
#include "options/options.h"
#include "options/record.h"

#include <stdio.h>
#include <string.h>
#include <strings.h>

#define MOST_EDITS 2 /* of a slip that a name is suggested for */

typedef MpmDatabaseOption Pair;

/* ---- blocks ---- */

PetscErrorCode MpmRecordAddBlock(MpmRecord record, const char prefix[])
{
  PetscFunctionBegin;
  if (!record || !prefix) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt k = 0; k < record->block_count; k++)
    if (!strcmp(record->blocks[k], prefix)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscRealloc(sizeof(*record->blocks) * (size_t)(record->block_count + 1), &record->blocks));
  PetscCall(PetscStrallocpy(prefix, &record->blocks[record->block_count++]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The length of the prefix of the block that an option is in: the longest that it begins with. */
static size_t BlockLength(MpmRecord record, const char name[])
{
  size_t longest = strlen("mpm_");

  for (PetscInt k = 0; k < record->block_count; k++) {
    const size_t length = strlen(record->blocks[k]);

    if (length > longest && !strncasecmp(name, record->blocks[k], length)) longest = length;
  }
  return longest;
}

/*
  The option of the same block that was asked or looked for whose name is nearest; NULL where all need more edits, or
  as many as half a name has.
*/
static const char *NearestKnown(MpmRecord record, const char name[])
{
  const size_t   block = BlockLength(record, name), length = strlen(&name[block]);
  const PetscInt most    = PetscMin(MOST_EDITS, (PetscInt)length / 2);
  const char    *nearest = NULL;
  PetscInt       best    = most + 1;

  for (PetscInt i = 0; i < record->count; i++) {
    const char     *other = record->entries[i].name;
    const PetscBool asked = (PetscBool)(record->entries[i].known || record->entries[i].presence);
    PetscInt        distance;

    if (!asked || strncasecmp(name, other, block) || BlockLength(record, other) != block) continue;
    distance = MpmTextDistance(&name[block], &other[block]);
    if (distance >= best || (!distance && !record->entries[i].known)) continue; /* looked for and not taken: itself */
    best    = distance;
    nearest = other;
  }
  return nearest;
}

/* ---- lists ---- */

#define WITHIN "mpm_ensemble_"

void MpmRecordBlockPrefix(const char list[], char prefix[PETSC_MAX_OPTION_NAME])
{
  const int    within = !strncmp(list, WITHIN, strlen(WITHIN)); /* a list in a block, of blocks beside it */
  const char  *name   = &list[strlen(within ? WITHIN : "mpm_")];
  const size_t length = strlen(name);
  const int    ies    = length > 3 && !strcmp(&name[length - 3], "ies");

  (void)snprintf(prefix, PETSC_MAX_OPTION_NAME, "mpm_%.*s%s_", (int)(length - (ies ? 3 : 1)), name, ies ? "y" : "");
}

/* The list that an option's block would have to stand in, where the option is in none that has been read; or NULL. */
static const MpmRecordEntry *ListOf(MpmRecord record, const char name[])
{
  const size_t block = BlockLength(record, name);
  char         prefix[PETSC_MAX_OPTION_NAME];

  for (PetscInt i = 0; i < record->count; i++) {
    const MpmRecordEntry *entry = &record->entries[i];

    if (!entry->list) continue;
    MpmRecordBlockPrefix(entry->name, prefix);
    if (strlen(prefix) > block && !strncasecmp(name, prefix, strlen(prefix)) && name[strlen(prefix)]) return entry;
  }
  return NULL;
}

/* Whether an option is a stage's list of this kind, like loads. */
static PetscBool EndsWithList(const char name[], const char list[])
{
  const size_t length = strlen(list), whole = strlen(name);

  return (PetscBool)(whole > length && name[whole - length - 1] == '_' && !strcmp(&name[whole - length], list));
}

/* Whether a list that could name the block is later than the option: its own, one of a stage, or that of stages. */
static PetscBool IsLeftOut(MpmRecord record, const char name[], const MpmRecordEntry *list)
{
  const PetscInt order = MpmSourcesOrder(record->sources, name);

  for (PetscInt i = 0; i < record->count && order; i++) {
    const MpmRecordEntry *entry = &record->entries[i];

    if (!entry->given || !entry->known) continue;
    if (entry != list && strcmp(entry->name, "mpm_stages") && !EndsWithList(entry->name, &list->name[strlen("mpm_")]))
      continue;
    if (MpmSourcesOrder(record->sources, entry->name) > order) return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* ---- refusals and warnings ---- */

/* Why the option is refused. */
static PetscErrorCode Describe(MpmRecord record, const char name[], const MpmRecordEntry *list, char **text)
{
  const char *nearest = NearestKnown(record, &name[strspn(name, "-")]);

  PetscFunctionBegin;
  *text = NULL;
  if (nearest) PetscCall(MpmTextAppend(text, "-%.200s: unknown option; did you mean -%.200s?", name, nearest));
  else if (list && list->given)
    PetscCall(MpmTextAppend(text, "-%.200s: unknown option; its block is not in -%s %.100s", name, list->name,
                            list->value ? list->value : ""));
  else if (list)
    PetscCall(MpmTextAppend(text, "-%.200s: unknown option; the list -%s is missing, which names such blocks", name,
                            list->name));
  else PetscCall(MpmTextAppend(text, "-%.200s: unknown option", name));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The warning about options that are left out, `count` of one list from `first` on. */
static PetscErrorCode Warn(const MpmRecordEntry *list, const char first[], PetscInt count, char **warning)
{
  char others[64] = "";

  PetscFunctionBegin;
  if (!count) PetscFunctionReturn(PETSC_SUCCESS);
  if (count > 1) snprintf(others, sizeof(others), " and %lld more", (long long)count - 1);
  PetscCall(MpmTextAppend(warning, "%s-%.200s%s: left out, since a later list does not name the block (-%s%s%.100s)",
                          *warning ? "; " : "", first, others, list->name, list->value ? " " : "",
                          list->value ? list->value : ""));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Options neither used nor refused are left out: the run's options are without them. */
static PetscErrorCode SetAside(MpmRecord record, PetscInt count, const Pair pairs[])
{
  PetscFunctionBegin;
  for (PetscInt i = 0; i < count; i++) {
    MpmRecordEntry *entry;
    PetscBool       ours;

    PetscCall(MpmDatabaseIsOurs(pairs[i].name, &ours));
    if (!ours) continue;
    PetscCall(MpmRecordGet(record, pairs[i].name, &entry));
    entry->aside = (PetscBool)!entry->known;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmOptionsCheckUnknown(const MpmOptions *options, char **warning)
{
  const MpmRecordEntry *left  = NULL; /* the list of the options that are left out, and how many there are in a row */
  const char           *first = NULL;
  PetscInt              count, row = 0;
  Pair                 *pairs;
  char                 *text, *unknown = NULL;

  PetscFunctionBegin;
  *warning = NULL;
  PetscCall(MpmForeignOptionsCheck());
  PetscCall(MpmDatabaseGet(&count, &pairs, &text));
  for (PetscInt i = 0; i < count && !unknown; i++) {
    const MpmRecordEntry *list;
    MpmRecordEntry       *entry;
    PetscBool             ours;

    PetscCall(MpmDatabaseIsOurs(pairs[i].name, &ours));
    if (!ours) continue;
    PetscCall(MpmRecordFind(options->record, pairs[i].name, &entry));
    if (entry && entry->known) continue;
    list = ListOf(options->record, pairs[i].name);
    if (!list || !IsLeftOut(options->record, pairs[i].name, list)) {
      PetscCall(Describe(options->record, pairs[i].name, list, &unknown));
      continue;
    }
    if (list != left) {
      PetscCall(Warn(left, first, row, warning));
      left  = list;
      first = pairs[i].name;
      row   = 0;
    }
    row++;
  }
  PetscCall(Warn(left, first, row, warning));
  PetscCall(SetAside(options->record, count, pairs));
  PetscCall(PetscFree(pairs));
  PetscCall(PetscFree(text));
  MpmCheckInput(!unknown, "%s", unknown);
  PetscCall(MpmForeignOptionsKeep(options->record));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  One option: its line of -help, its entry in the record, and its refusals.
*/
#include <stdio.h>
#include <string.h>
#include <strings.h>
#include "options/help.h"
#include "options/item.h"
#include "options/options.h"
#include "options/record.h"

/* ---- one option ---- */

PetscErrorCode MpmItemFullName(const MpmOptions *options, const char name[], char **full)
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

static PetscErrorCode ItemRecord(MpmRecord record, const MpmItem *item, const MpmOptionSpec *spec, PetscBool *first)
{
  MpmRecordEntry *entry;
  const char     *value = item->given ? (item->raw ? item->raw : "") : (spec->lasting ? spec->fallback : NULL);

  PetscFunctionBegin;
  *first = PETSC_TRUE;
  if (!record) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmRecordGet(record, item->name, &entry));
  *first         = entry->known ? PETSC_FALSE : PETSC_TRUE;
  entry->known   = PETSC_TRUE;
  entry->given   = item->given;
  entry->differs = (PetscBool)(item->given && !(item->raw && spec->fallback && !strcasecmp(item->raw, spec->fallback)));
  if (spec->presence) entry->presence = PETSC_TRUE;
  entry->numbers = (PetscBool)(spec->type == MPM_OPTION_NUMBER || spec->type == MPM_OPTION_TEXT);
  entry->range   = spec->type == MPM_OPTION_NUMBER ? spec->range : MPM_RANGE_ANY;
  PetscCall(PetscFree(entry->value));
  if (value) PetscCall(PetscStrallocpy(value, &entry->value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmItemRead(const MpmOptions *options, const MpmOptionSpec *spec, MpmItem *item)
{
  PetscBool help, first;
  char     *meaning = NULL;

  PetscFunctionBegin;
  PetscCall(MpmItemFullName(options, spec->name, &item->name));
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

PetscErrorCode MpmItemDestroy(MpmItem *item, PetscBool *set)
{
  PetscFunctionBegin;
  if (set) *set = item->given;
  PetscCall(PetscFree(item->name));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmItemRefuse(const MpmItem *item, const MpmOptionSpec *spec, const char verb[])
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

PetscErrorCode MpmItemRefuseForm(const MpmItem *item, const MpmOptionSpec *spec, const char verb[])
{
  char *text = NULL, *meaning;

  PetscFunctionBegin;
  PetscCall(ItemMeaning(spec, &meaning));
  PetscCall(MpmTextAppend(&text, "%s: %s", verb, meaning));
  PetscCall(MpmItemRefuse(item, spec, text));
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

void MpmMustText(const char range[], const char unit[], char text[MPM_MUST_TEXT])
{
  const PetscBool named = (PetscBool)(unit && unit[0] && strcmp(unit, "-"));

  snprintf(text, MPM_MUST_TEXT, "must %s %s%s%s", strncmp(range, "in ", 3) ? "be" : "lie", range, named ? " " : "",
           named ? unit : "");
}

PetscErrorCode MpmItemRefuseRange(const MpmItem *item, const MpmOptionSpec *spec, PetscInt count, const char range[])
{
  char must[MPM_MUST_TEXT], text[MPM_MUST_TEXT + 8];

  PetscFunctionBegin;
  MpmMustText(range, spec->unit, must);
  snprintf(text, sizeof(text), "%s%s", count == 1 ? "" : "each ", must);
  PetscCall(MpmItemRefuse(item, spec, text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmItemCheckCount(const MpmItem *item, const MpmOptionSpec *spec, PetscInt wanted, PetscInt count)
{
  char text[MPM_RANGE_TEXT];

  PetscFunctionBegin;
  if (wanted == count) PetscFunctionReturn(PETSC_SUCCESS);
  snprintf(text, sizeof(text), "must have %lld value%s, has %lld", (long long)wanted, wanted == 1 ? "" : "s",
           (long long)count);
  PetscCall(MpmItemRefuseForm(item, spec, text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

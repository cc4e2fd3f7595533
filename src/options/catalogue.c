/*
  A catalogue of options: the manual as data, for parts of it and for other programs.
*/
#include <ctype.h>
#include <string.h>
#include "options/help.h"

PetscErrorCode MpmCatalogueCreate(MpmCatalogue *catalogue)
{
  PetscFunctionBegin;
  PetscCall(PetscNew(catalogue));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmCatalogueDestroy(MpmCatalogue *catalogue)
{
  PetscFunctionBegin;
  if (!*catalogue) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt i = 0; i < (*catalogue)->item_count; i++) {
    MpmCatalogueItem *item = &(*catalogue)->items[i];

    PetscCall(PetscFree(item->name));
    PetscCall(PetscFree(item->help));
    PetscCall(PetscFree(item->unit));
    PetscCall(PetscFree(item->accepts));
    PetscCall(PetscFree(item->fallback));
  }
  for (PetscInt s = 0; s < (*catalogue)->section_count; s++) PetscCall(PetscFree((*catalogue)->sections[s]));
  for (PetscInt s = 0; s < (*catalogue)->scope_count; s++) PetscCall(PetscFree((*catalogue)->scopes[s]));
  PetscCall(PetscFree((*catalogue)->sections));
  PetscCall(PetscFree((*catalogue)->items));
  PetscCall(PetscFree(*catalogue));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmCatalogueSetScope(MpmCatalogue catalogue, const char name[])
{
  PetscFunctionBegin;
  for (catalogue->scope = 0; catalogue->scope < catalogue->scope_count; catalogue->scope++)
    if (!strcmp(catalogue->scopes[catalogue->scope], name)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCheck(catalogue->scope_count < MPM_SCOPES_MAX, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE, "Too many scopes");
  PetscCall(PetscStrallocpy(name, &catalogue->scopes[catalogue->scope_count++]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The option of this name in the current section, or NULL. */
static MpmCatalogueItem *Find(MpmCatalogue catalogue, const char name[])
{
  for (PetscInt i = 0; i < catalogue->item_count; i++) {
    MpmCatalogueItem *item = &catalogue->items[i];

    if (item->section == catalogue->section && !strcmp(item->name, name)) return item;
  }
  return NULL;
}

PetscErrorCode MpmCatalogueAddSection(MpmCatalogue catalogue, const char title[])
{
  char *heading;

  PetscFunctionBegin;
  PetscCall(PetscStrallocpy(title, &heading));
  heading[0] = (char)toupper((unsigned char)heading[0]);
  for (catalogue->section = 0; catalogue->section < catalogue->section_count; catalogue->section++)
    if (!strcmp(catalogue->sections[catalogue->section], heading)) break;
  if (catalogue->section < catalogue->section_count) PetscFunctionReturn(PetscFree(heading));
  if (catalogue->section_count == catalogue->section_capacity) {
    catalogue->section_capacity += 64;
    PetscCall(PetscRealloc((size_t)catalogue->section_capacity * sizeof(char *), &catalogue->sections));
  }
  catalogue->sections[catalogue->section_count++] = heading;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmCatalogueAdd(MpmCatalogue catalogue, const MpmCatalogueItem *item)
{
  const unsigned    scope = 1u << catalogue->scope;
  MpmCatalogueItem *own;

  PetscFunctionBegin;
  if (!catalogue->section_count) PetscCall(MpmCatalogueAddSection(catalogue, "Scene"));
  own = Find(catalogue, item->name);
  if (own) {
    own->scopes |= scope;
    if (own->count != item->count) own->count = MPM_COUNT_AXES;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (catalogue->item_count == catalogue->item_capacity) {
    catalogue->item_capacity += 256;
    PetscCall(PetscRealloc((size_t)catalogue->item_capacity * sizeof(*own), &catalogue->items));
  }
  own          = &catalogue->items[catalogue->item_count++];
  *own         = *item;
  own->section = catalogue->section;
  own->scopes  = scope;
  PetscCall(PetscStrallocpy(item->name, &own->name));
  PetscCall(PetscStrallocpy(item->help, &own->help));
  PetscCall(PetscStrallocpy(item->unit, &own->unit));
  PetscCall(PetscStrallocpy(item->accepts, &own->accepts));
  PetscCall(PetscStrallocpy(item->fallback, &own->fallback));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A word of capitals in a catalogue's name stands for any name. */
static size_t PlaceholderLength(const char name[])
{
  static const char *const words[] = {"NAME", "BLOCK"};

  for (size_t w = 0; w < PETSC_STATIC_ARRAY_LENGTH(words); w++)
    if (!strncmp(name, words[w], strlen(words[w]))) return strlen(words[w]);
  return 0;
}

static PetscBool Matches(const char pattern[], const char name[])
{
  const size_t placeholder = PlaceholderLength(pattern);

  if (!*pattern) return (PetscBool) !*name;
  if (!placeholder)
    return (PetscBool)(*name && tolower((unsigned char)*pattern) == tolower((unsigned char)*name) &&
                       Matches(&pattern[1], &name[1]));
  for (const char *rest = name; *rest; rest++)
    if (Matches(&pattern[placeholder], &rest[1])) return PETSC_TRUE;
  return PETSC_FALSE;
}

PetscBool MpmCatalogueItemIs(const MpmCatalogueItem *item, const char name[])
{
  return Matches(item->name, name);
}

/* ---- JSON ---- */

static PetscErrorCode AppendString(const char value[], MpmTextFile *text)
{
  PetscFunctionBegin;
  if (!value) PetscFunctionReturn(MpmTextFileAppend(text, "null"));
  PetscCall(MpmTextFileAppend(text, "\""));
  for (const char *c = value; *c; c++) {
    if (*c == '"' || *c == '\\') PetscCall(MpmTextFileAppend(text, "\\%c", *c));
    else if ((unsigned char)*c < 0x20) PetscCall(MpmTextFileAppend(text, "\\u%04x", (unsigned)*c));
    else PetscCall(MpmTextFileAppend(text, "%c", *c));
  }
  PetscCall(MpmTextFileAppend(text, "\""));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode AppendPair(const char key[], const char value[], MpmTextFile *text)
{
  PetscFunctionBegin;
  PetscCall(MpmTextFileAppend(text, ", \"%s\": ", key));
  PetscCall(AppendString(value, text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Bounds that are there: "minimum", "exclusiveMaximum" and so on. */
static PetscErrorCode AppendRange(const MpmCatalogueItem *item, MpmTextFile *text)
{
  const char *lower = item->range.open ? "exclusiveMinimum" : "minimum",
             *upper = item->range.open ? "exclusiveMaximum" : "maximum";
  char number[MPM_NUMBER_TEXT];

  PetscFunctionBegin;
  if (item->type > MPM_OPTION_INTEGER) PetscFunctionReturn(PETSC_SUCCESS);
  if (item->range.lower > PETSC_NINFINITY) {
    MpmRealText(item->range.lower, number);
    PetscCall(MpmTextFileAppend(text, ", \"%s\": %s", lower, number));
  }
  if (item->range.upper < PETSC_INFINITY) {
    MpmRealText(item->range.upper, number);
    PetscCall(MpmTextFileAppend(text, ", \"%s\": %s", upper, number));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The words of "one of a, b". */
static PetscErrorCode AppendChoices(const MpmCatalogueItem *item, MpmTextFile *text)
{
  const char *words = strncmp(item->accepts, "one of ", 7) ? item->accepts : &item->accepts[7];
  char      **parts;
  PetscInt    count;

  PetscFunctionBegin;
  PetscCall(MpmTextSplit(words, &count, &parts));
  PetscCall(MpmTextFileAppend(text, ", \"choices\": ["));
  for (PetscInt k = 0; k < count; k++) {
    if (k) PetscCall(MpmTextFileAppend(text, ", "));
    PetscCall(AppendString(parts[k], text));
  }
  PetscCall(MpmTextFileAppend(text, "]"));
  PetscCall(MpmNamesDestroy(count, &parts));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode AppendItem(MpmCatalogue catalogue, const MpmCatalogueItem *item, MpmTextFile *text)
{
  static const char *const types[] = {"number", "integer", "boolean", "word", "text", "file", "names", "blocks"};
  const char              *gap     = "";

  PetscFunctionBegin;
  PetscCall(MpmTextFileAppend(text, "{\"option\": "));
  PetscCall(AppendString(item->name, text));
  PetscCall(AppendPair("section", catalogue->sections[item->section], text));
  PetscCall(AppendPair("type", types[item->type], text));
  if (item->count == MPM_COUNT_AXES) PetscCall(AppendPair("count", "axes", text));
  else if (item->count) PetscCall(MpmTextFileAppend(text, ", \"count\": %lld", (long long)item->count));
  else PetscCall(AppendPair("count", "any", text));
  PetscCall(AppendPair("unit", item->unit && strcmp(item->unit, "-") ? item->unit : NULL, text));
  PetscCall(AppendRange(item, text));
  if (item->type == MPM_OPTION_WORD) PetscCall(AppendChoices(item, text));
  PetscCall(AppendPair("default", item->fallback && *item->fallback ? item->fallback : NULL, text));
  PetscCall(MpmTextFileAppend(text, ", \"required\": %s", item->required ? "true" : "false"));
  PetscCall(MpmTextFileAppend(text, ", \"physics\": ["));
  for (PetscInt s = 0; s < catalogue->scope_count; s++) {
    if (!(item->scopes & (1u << s))) continue;
    PetscCall(MpmTextFileAppend(text, "%s", gap));
    PetscCall(AppendString(catalogue->scopes[s], text));
    gap = ", ";
  }
  PetscCall(MpmTextFileAppend(text, "]"));
  PetscCall(AppendPair("help", item->help, text));
  PetscCall(MpmTextFileAppend(text, "}"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmCatalogueJSON(MpmCatalogue catalogue, MpmTextFile *text)
{
  PetscFunctionBegin;
  PetscCall(MpmTextFileAppend(text, "[\n"));
  for (PetscInt i = 0; i < catalogue->item_count; i++) {
    PetscCall(MpmTextFileAppend(text, "  "));
    PetscCall(AppendItem(catalogue, &catalogue->items[i], text));
    PetscCall(MpmTextFileAppend(text, i + 1 < catalogue->item_count ? ",\n" : "\n"));
  }
  PetscCall(MpmTextFileAppend(text, "]\n"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

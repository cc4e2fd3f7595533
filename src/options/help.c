/*
  The manual that -help prints, as the readers of options say it of themselves.
*/
#include <ctype.h>
#include <string.h>
#include "options/help.h"

#define HELP_NAME  36  /* columns for an option's name; its text starts behind them */
#define HELP_WIDTH 118 /* columns of a line */

static MpmCatalogue collecting = NULL;

void MpmCatalogueCollect(MpmCatalogue catalogue)
{
  collecting = catalogue;
}

/* Where a line of at most `width` characters ends: at the last blank before, or where there is none, at the first one
   behind. */
static size_t BreakLine(const char text[], size_t width)
{
  size_t end = strlen(text), last = 0;

  if (end <= width) return end;
  for (size_t i = 1; i < end; i++) {
    if (text[i] != ' ') continue;
    if (i > width) return last ? last : i;
    last = i;
  }
  return last && end > width ? last : end;
}

/* "Young's modulus (Pa; > 0; required)" */
static PetscErrorCode Describe(const MpmCatalogueItem *item, char **text)
{
  PetscFunctionBegin;
  *text = NULL;
  PetscCall(MpmTextAppend(text, "%s (", item->help));
  if (item->unit && strcmp(item->unit, "-")) PetscCall(MpmTextAppend(text, "%s; ", item->unit));
  if (*item->accepts) PetscCall(MpmTextAppend(text, "%s; ", item->accepts));
  if (item->required) PetscCall(MpmTextAppend(text, "required)"));
  else if (!item->fallback) PetscCall(MpmTextAppend(text, "optional)"));
  else PetscCall(MpmTextAppend(text, "default %s)", *item->fallback ? item->fallback : "none"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmCatalogueItemText(const MpmCatalogueItem *item, char **text)
{
  const size_t column = strlen(item->name) + 4; /* blanks, dash, and one blank behind */
  char        *meaning;

  PetscFunctionBegin;
  PetscCall(Describe(item, &meaning));
  PetscCall(MpmTextAppend(text, "  -%s", item->name));
  if (column > HELP_NAME) PetscCall(MpmTextAppend(text, "\n%*s", HELP_NAME + 2, ""));
  else PetscCall(MpmTextAppend(text, "%*s", (int)(HELP_NAME + 3 - column), ""));
  for (const char *rest = meaning; *rest;) {
    const size_t length = BreakLine(rest, HELP_WIDTH - HELP_NAME - 2);

    PetscCall(MpmTextAppend(text, "%.*s\n", (int)length, rest));
    rest += length;
    while (*rest == ' ') rest++;
    if (*rest) PetscCall(MpmTextAppend(text, "%*s", HELP_NAME + 2, ""));
  }
  PetscCall(PetscFree(meaning));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The option as an item; its texts are borrowed. */
static MpmCatalogueItem ItemOf(const char name[], const MpmOptionSpec *spec)
{
  const PetscBool optional = (PetscBool)(spec->need == MPM_REQUIRED || spec->presence || !spec->lasting);

  return (MpmCatalogueItem){.type     = spec->type,
                            .count    = spec->count,
                            .required = (PetscBool)(spec->need == MPM_REQUIRED),
                            .range    = spec->range,
                            .name     = (char *)name,
                            .help     = (char *)spec->help,
                            .unit     = (char *)spec->unit,
                            .accepts  = (char *)spec->accepts,
                            .fallback = optional ? NULL : (char *)(spec->fallback ? spec->fallback : "")};
}

PetscErrorCode MpmHelpOption(MPI_Comm comm, const char name[], const MpmOptionSpec *spec)
{
  const MpmCatalogueItem item = ItemOf(name, spec);
  char                  *text = NULL;

  PetscFunctionBegin;
  if (collecting) PetscFunctionReturn(MpmCatalogueAdd(collecting, &item));
  PetscCall(MpmCatalogueItemText(&item, &text));
  PetscCall((*PetscHelpPrintf)(comm, "%s", text));
  PetscCall(PetscFree(text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmHelpHeading(MPI_Comm comm, const char title[])
{
  PetscFunctionBegin;
  if (collecting) PetscFunctionReturn(MpmCatalogueAddSection(collecting, title));
  PetscCall((*PetscHelpPrintf)(comm, "\n%c%s\n", toupper((unsigned char)title[0]), title + 1));
  PetscFunctionReturn(PETSC_SUCCESS);
}

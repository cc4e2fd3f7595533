/*
  One option of the manual that -help prints, as the readers of options say it of themselves.
*/
#include <string.h>
#include "options/help.h"

#define HELP_NAME  36  /* columns for an option's name; its text starts behind them */
#define HELP_WIDTH 118 /* columns of a line */

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

PetscErrorCode MpmHelpEntry(MPI_Comm comm, const char name[], const char text[])
{
  const size_t column = strlen(name) + 4; /* blanks, dash, and one blank behind */

  PetscFunctionBegin;
  PetscCall((*PetscHelpPrintf)(comm, "  -%s", name));
  if (column > HELP_NAME) PetscCall((*PetscHelpPrintf)(comm, "\n%*s", HELP_NAME + 2, ""));
  else PetscCall((*PetscHelpPrintf)(comm, "%*s", (int)(HELP_NAME + 3 - column), ""));
  while (*text) {
    const size_t length = BreakLine(text, HELP_WIDTH - HELP_NAME - 2);

    PetscCall((*PetscHelpPrintf)(comm, "%.*s\n", (int)length, text));
    text += length;
    while (*text == ' ') text++;
    if (*text) PetscCall((*PetscHelpPrintf)(comm, "%*s", HELP_NAME + 2, ""));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

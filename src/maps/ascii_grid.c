/*
  Grids of numbers in ESRI ASCII files.
*/
#include <ctype.h>
#include <errno.h>
#include <string.h>
#include <strings.h>
#include "maps/ascii_grid.h"
#include "io/csv_table.h"

#define MOST 2e9 /* pixels */

/* Names of the header, and what was read. */
enum { COLUMNS, ROWS, X_CENTRE, X_CORNER, Y_CENTRE, Y_CORNER, CELL, NONE, HEADS };
static const char *const heads[HEADS] = {"ncols",     "nrows",     "xllcenter", "xllcorner",
                                         "yllcenter", "yllcorner", "cellsize",  "nodata_value"};

typedef struct {
  PetscBool there[HEADS];
  PetscReal value[HEADS];
} Header;

/* The lines that begin with a word; returns what follows them. */
static const char *ReadHeader(const char *text, Header *header, char message[])
{
  for (;;) {
    size_t length;
    char  *end;
    int    k = 0;

    text += strspn(text, " \t\r\n");
    if (!isalpha((unsigned char)*text)) return text;
    length = strcspn(text, " \t\r\n");
    while (k < HEADS && (strlen(heads[k]) != length || strncasecmp(heads[k], text, length))) k++;
    if (k == HEADS) {
      (void)snprintf(message, MPM_ASCII_MESSAGE, "%.*s is no word of an ASCII grid", (int)PetscMin(length, 40), text);
      return text;
    }
    header->value[k] = strtod(text + length, &end);
    if (end == text + length) {
      (void)snprintf(message, MPM_ASCII_MESSAGE, "%s has no number", heads[k]);
      return text;
    }
    header->there[k] = PETSC_TRUE;
    text             = end;
  }
}

static const char *CheckHeader(const Header *header)
{
  if (!header->there[COLUMNS] || !header->there[ROWS]) return "ncols or nrows is missing";
  if (!header->there[CELL] || !(header->value[CELL] > 0.)) return "cellsize is missing, or not > 0";
  if (header->there[X_CENTRE] == header->there[X_CORNER] || header->there[Y_CENTRE] == header->there[Y_CORNER])
    return "one of xllcenter and xllcorner must be there, and one of yllcenter and yllcorner";
  if (!(header->value[COLUMNS] >= 1.) || !(header->value[ROWS] >= 1.) ||
      header->value[COLUMNS] * header->value[ROWS] > MOST)
    return "ncols or nrows is out of range";
  return NULL;
}

PetscErrorCode MpmAsciiGridRead(const char *path, MpmAsciiGrid *grid, char message[MPM_ASCII_MESSAGE])
{
  Header      header = {0};
  char       *text   = NULL, *end;
  const char *at, *wrong;
  PetscInt64  count;

  PetscFunctionBeginUser;
  PetscCall(MpmTextRead(path, &text, message));
  if (message[0]) PetscFunctionReturn(PETSC_SUCCESS);
  at    = ReadHeader(text, &header, message);
  wrong = message[0] ? NULL : CheckHeader(&header);
  if (wrong) (void)snprintf(message, MPM_ASCII_MESSAGE, "%s", wrong);
  if (message[0]) PetscFunctionReturn(PetscFree(text));
  grid->columns = (PetscInt)header.value[COLUMNS];
  grid->rows    = (PetscInt)header.value[ROWS];
  grid->cell    = header.value[CELL];
  grid->none    = header.there[NONE] ? header.value[NONE] : -9999.;
  grid->x0      = header.there[X_CENTRE] ? header.value[X_CENTRE] : header.value[X_CORNER] + 0.5 * grid->cell;
  grid->y0      = header.there[Y_CENTRE] ? header.value[Y_CENTRE] : header.value[Y_CORNER] + 0.5 * grid->cell;
  count         = (PetscInt64)grid->columns * grid->rows;
  PetscCall(PetscMalloc1((size_t)count, &grid->value));
  for (PetscInt64 k = 0; k < count; k++, at = end) {
    const PetscInt64 j = grid->rows - 1 - k / grid->columns;

    grid->value[j * grid->columns + k % grid->columns] = strtod(at, &end);
    if (end != at) continue;
    (void)snprintf(message, MPM_ASCII_MESSAGE, "has %" PetscInt64_FMT " numbers in place of %" PetscInt64_FMT, k,
                   count);
    break;
  }
  PetscCall(PetscFree(text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmAsciiGridDestroy(MpmAsciiGrid *grid)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(grid->value));
  PetscCall(PetscMemzero(grid, sizeof(*grid)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

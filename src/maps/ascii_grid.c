/*
  Grids of numbers in ESRI ASCII files.
*/
#include <ctype.h>
#include <errno.h>
#include <string.h>
#include <strings.h>
#include "files/csv_table.h"
#include "maps/ascii_grid.h"
#include "maps/map_read.h"

#define MOST 2147483647. /* pixels */

/* Names of the header, and what was read. */
enum { COLUMNS, ROWS, X_CENTRE, X_CORNER, Y_CENTRE, Y_CORNER, CELL, CELL_X, CELL_Y, NONE, HEADS };
static const char *const heads[HEADS] = {"ncols",     "nrows",    "xllcenter", "xllcorner", "yllcenter",
                                         "yllcorner", "cellsize", "dx",        "dy",        "nodata_value"};

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
      (void)snprintf(message, MPM_MAP_MESSAGE, "%.*s is no word of an ASCII grid", (int)PetscMin(length, 40), text);
      return text;
    }
    header->value[k] = strtod(text + length, &end);
    if (end == text + length) {
      (void)snprintf(message, MPM_MAP_MESSAGE, "%s has no number", heads[k]);
      return text;
    }
    header->there[k] = PETSC_TRUE;
    text             = end;
  }
}

static const char *CheckHeader(const Header *header)
{
  if (!header->there[COLUMNS] || !header->there[ROWS]) return "ncols or nrows is missing";
  for (PetscInt k = CELL; k <= CELL_Y; k++)
    if (header->there[k] && !(header->value[k] > 0.)) return "cellsize must be > 0";
  if (header->there[CELL] == header->there[CELL_X] || header->there[CELL_X] != header->there[CELL_Y])
    return "cellsize is missing, or dx and dy";
  if (header->there[X_CENTRE] == header->there[X_CORNER] || header->there[Y_CENTRE] == header->there[Y_CORNER])
    return "one of xllcenter and xllcorner must be there, and one of yllcenter and yllcorner";
  if (!(header->value[COLUMNS] >= 1.) || !(header->value[ROWS] >= 1.) ||
      header->value[COLUMNS] * header->value[ROWS] > MOST)
    return "ncols or nrows is out of range";
  return NULL;
}

PetscBool MpmAsciiGridIs(const char *path)
{
  char  word[16] = "";
  FILE *file     = fopen(path, "r");
  int   got      = file ? fscanf(file, "%15s", word) : 0;

  if (file) (void)fclose(file);
  for (PetscInt k = 0; got == 1 && k < HEADS; k++)
    if (!strcasecmp(word, heads[k])) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* The numbers of the pixels that are asked for; all are gone through. */
static PetscErrorCode ReadNumbers(const char *at, const Header *header, const MpmMapRange range[2], MpmMap *map,
                                  char message[])
{
  const PetscInt   columns = (PetscInt)header->value[COLUMNS], rows = (PetscInt)header->value[ROWS];
  const PetscInt64 count = (PetscInt64)columns * rows;
  char            *end;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1((size_t)map->columns * (size_t)map->rows, &map->value));
  for (PetscInt64 k = 0; k < count; k++, at = end) {
    const PetscInt j      = rows - 1 - (PetscInt)(k / columns) - range[1].first,
                   i      = (PetscInt)(k % columns) - range[0].first;
    const PetscReal value = strtod(at, &end);

    if (end == at) {
      (void)snprintf(message, MPM_MAP_MESSAGE, "has %" PetscInt64_FMT " numbers in place of %" PetscInt64_FMT, k,
                     count);
      break;
    }
    if (i < 0 || i >= map->columns || j < 0 || j >= map->rows) continue;
    map->value[(PetscInt64)j * map->columns + i] = value == map->none || PetscIsInfReal(value) ? NAN : value;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmAsciiGridRead(const char *path, const MpmMapAsk *ask, MpmMap *map, char message[MPM_MAP_MESSAGE])
{
  Header      header = {0};
  MpmMapRange range[2];
  char       *text = NULL;
  const char *at, *wrong;

  PetscFunctionBeginUser;
  PetscCall(MpmTextRead(path, &text, message));
  if (message[0]) PetscFunctionReturn(PETSC_SUCCESS);
  at    = ReadHeader(text, &header, message);
  wrong = message[0] ? NULL : CheckHeader(&header);
  if (!message[0] && !wrong && ask->band > 1) wrong = "an ASCII grid has one band";
  if (wrong) (void)snprintf(message, MPM_MAP_MESSAGE, "%s", wrong);
  if (message[0]) PetscFunctionReturn(PetscFree(text));
  for (PetscInt a = 0; a < 2; a++) {
    const PetscInt total = (PetscInt)header.value[a ? ROWS : COLUMNS], centre = a ? Y_CENTRE : X_CENTRE;

    map->cell[a]   = header.there[CELL] ? header.value[CELL] : header.value[CELL_X + a];
    map->origin[a] = ask->origin[a];
    if (!MpmMapRangeFind((header.there[centre] ? header.value[centre] : header.value[centre + 1] + 0.5 * map->cell[a]) -
                           ask->origin[a],
                         map->cell[a], total, ask, a, &range[a]))
      (void)snprintf(message, MPM_MAP_MESSAGE, "lies outside the grid");
  }
  if (message[0]) PetscFunctionReturn(PetscFree(text));
  map->columns = range[0].count;
  map->rows    = range[1].count;
  map->x0      = range[0].start;
  map->y0      = range[1].start;
  map->none    = header.there[NONE] ? header.value[NONE] : -9999.;
  if (!ask->frame) PetscCall(ReadNumbers(at, &header, range, map, message));
  PetscCall(PetscFree(text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

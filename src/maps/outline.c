/*
  Outlines in memory.
*/
#include <stdlib.h>
#include <string.h>
#include "maps/map.h"
#include "maps/outline_build.h"

/* ---- making ---- */

/* Room for one entry more: arrays double where their count is a power of two. */
static PetscErrorCode Grow(PetscInt count, size_t size, void *array)
{
  PetscFunctionBeginUser;
  if (count & (count - 1)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscRealloc(size * (size_t)PetscMax(2 * count, 1), (void **)array));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmOutlineAddFeature(MpmOutline *outline, MpmOutlineType type)
{
  const PetscInt count = outline->features, names = outline->names;

  PetscFunctionBeginUser;
  PetscCall(Grow(count, sizeof(*outline->feature), &outline->feature));
  outline->feature[count] = (MpmFeature){type, outline->paths, outline->paths};
  outline->features++;
  PetscCall(PetscRealloc(sizeof(char *) * (size_t)PetscMax(outline->features * names, 1), (void **)&outline->value));
  for (PetscInt k = 0; k < names; k++) outline->value[count * names + k] = NULL;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmOutlineAddPath(MpmOutline *outline)
{
  PetscFunctionBeginUser;
  if (!outline->paths) PetscCall(PetscCalloc1(1, &outline->start));
  PetscCall(Grow(outline->paths + 1, sizeof(*outline->start), &outline->start));
  outline->start[outline->paths + 1]          = outline->start[outline->paths];
  outline->feature[outline->features - 1].end = ++outline->paths;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmOutlineAddVertex(MpmOutline *outline, PetscReal x, PetscReal y)
{
  const PetscInt count = outline->start[outline->paths];

  PetscFunctionBeginUser;
  PetscCall(Grow(count, 2 * sizeof(*outline->at), &outline->at));
  outline->at[2 * count]     = x;
  outline->at[2 * count + 1] = y;
  outline->start[outline->paths]++;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The number of a name; a new one widens the table of values. */
static PetscErrorCode FindName(MpmOutline *outline, const char *name, PetscInt *number)
{
  const PetscInt names = outline->names;
  char         **wider;

  PetscFunctionBeginUser;
  for (*number = 0; *number < names; (*number)++)
    if (!strcmp(outline->name[*number], name)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Grow(names, sizeof(*outline->name), &outline->name));
  PetscCall(PetscStrallocpy(name, &outline->name[names]));
  PetscCall(PetscCalloc1((size_t)(outline->features * (names + 1)), &wider));
  for (PetscInt f = 0; f < outline->features; f++)
    for (PetscInt k = 0; k < names; k++) wider[f * (names + 1) + k] = outline->value[f * names + k];
  PetscCall(PetscFree(outline->value));
  outline->value = wider;
  outline->names++;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmOutlineAddAttribute(MpmOutline *outline, const char *name, const char *value)
{
  PetscInt number;
  char   **at;

  PetscFunctionBeginUser;
  PetscCall(FindName(outline, name, &number));
  at = &outline->value[(outline->features - 1) * outline->names + number];
  PetscCall(PetscFree(*at));
  PetscCall(PetscStrallocpy(value, at));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Twice the area of a ring, positive where it turns left. */
static PetscReal TwiceArea(PetscInt count, const PetscReal at[])
{
  PetscReal sum = 0.;

  for (PetscInt i = 1; i + 1 < count; i++)
    sum += (at[2 * i] - at[0]) * (at[2 * i + 3] - at[1]) - (at[2 * i + 1] - at[1]) * (at[2 * i + 2] - at[0]);
  return sum;
}

PetscErrorCode MpmOutlineEndRing(MpmOutline *outline, PetscBool outer, char message[])
{
  const PetscInt first = outline->start[outline->paths - 1];
  PetscInt       count = outline->start[outline->paths] - first;
  PetscReal     *at    = &outline->at[2 * first];

  PetscFunctionBeginUser;
  if (count > 1 && at[0] == at[2 * count - 2] && at[1] == at[2 * count - 1]) count--;
  outline->start[outline->paths] = first + count;
  if (count < 3) {
    (void)snprintf(message, MPM_MAP_MESSAGE, "has a polygon of %" PetscInt_FMT " vertices", count);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if ((TwiceArea(count, at) > 0.) == (outer == PETSC_TRUE)) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt i = 0, j = count - 1; i < j; i++, j--) {
    for (PetscInt a = 0; a < 2; a++) {
      const PetscReal kept = at[2 * i + a];

      at[2 * i + a] = at[2 * j + a];
      at[2 * j + a] = kept;
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmOutlineDestroy(MpmOutline *outline)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < outline->features * outline->names; k++) PetscCall(PetscFree(outline->value[k]));
  for (PetscInt k = 0; k < outline->names; k++) PetscCall(PetscFree(outline->name[k]));
  PetscCall(PetscFree(outline->name));
  PetscCall(PetscFree(outline->value));
  PetscCall(PetscFree(outline->feature));
  PetscCall(PetscFree(outline->start));
  PetscCall(PetscFree(outline->at));
  PetscCall(PetscFree(outline->system));
  PetscCall(PetscMemzero(outline, sizeof(*outline)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- reading a file of any format ---- */

/* GeoJSON begins with a brace. */
static PetscErrorCode ReadText(const char *path, char **text)
{
  FILE *file      = fopen(path, "rb");
  char  begin[64] = "";
  long  length    = -1;

  PetscFunctionBeginUser;
  *text = NULL;
  if (!file) PetscFunctionReturn(PETSC_SUCCESS);
  begin[fread(begin, 1, sizeof(begin) - 1, file)] = '\0';
  if (begin[strspn(begin, " \t\r\n\xef\xbb\xbf")] == '{' && !fseek(file, 0, SEEK_END)) length = ftell(file);
  if (length > 0 && !fseek(file, 0, SEEK_SET)) {
    PetscCall(PetscMalloc1(length + 1, text));
    (*text)[fread(*text, 1, (size_t)length, file)] = '\0';
  }
  (void)fclose(file);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmOutlineRead(const char *path, const MpmOutlineAsk *ask, MpmOutline *outline, char message[])
{
  char     *text;
  PetscBool there;
  MpmGdal   gdal;

  PetscFunctionBeginUser;
  PetscCall(PetscTestFile(path, 'r', &there));
  PetscCall(ReadText(path, &text));
  if (!there) {
    (void)snprintf(message, MPM_MAP_MESSAGE, "cannot be read");
  } else if (text) {
    PetscCall(MpmGeoJsonRead(text, outline, message));
  } else if (!MpmGdalOpen(&gdal)) {
    (void)snprintf(message, MPM_MAP_MESSAGE,
                   "GDAL, which reads all outlines but GeoJSON, is not there (TALUS_GDAL may name it)");
  } else {
    gdal.CPLPushErrorHandler(gdal.CPLQuietErrorHandler);
    PetscCall(MpmOutlineReadByGdal(&gdal, path, outline, message));
    gdal.CPLPopErrorHandler();
  }
  if (!message[0] && !outline->features) (void)snprintf(message, MPM_MAP_MESSAGE, "has no point, line or polygon");
  if (!message[0]) PetscCall(MpmOutlineProject(ask, outline, message));
  if (!message[0]) PetscCall(MpmOutlineCheck(outline, message));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- questions ---- */

/* Crossings of a ring with the half-line from x to the east, odd inside. */
static PetscInt Crossings(PetscInt count, const PetscReal at[], const PetscReal x[])
{
  PetscInt crossings = 0;

  for (PetscInt i = 0, j = count - 1; i < count; j = i++) {
    const PetscReal *a = &at[2 * j], *b = &at[2 * i];

    if ((a[1] > x[1]) != (b[1] > x[1]) && x[0] < a[0] + (x[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0])) crossings++;
  }
  return crossings;
}

PetscBool MpmOutlineHolds(const MpmOutline *outline, PetscInt feature, const PetscReal x[])
{
  for (PetscInt f = feature < 0 ? 0 : feature; f < (feature < 0 ? outline->features : feature + 1); f++) {
    const MpmFeature *here      = &outline->feature[f];
    PetscInt          crossings = 0;

    if (here->type != MPM_OUTLINE_POLYGON) continue;
    for (PetscInt k = here->first; k < here->end; k++)
      crossings += Crossings(outline->start[k + 1] - outline->start[k], &outline->at[2 * outline->start[k]], x);
    if (crossings % 2) return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* Square of the distance from x to the edge from a to b. */
static PetscReal EdgeDistance(const PetscReal a[], const PetscReal b[], const PetscReal x[])
{
  const PetscReal e[2] = {b[0] - a[0], b[1] - a[1]}, d[2] = {x[0] - a[0], x[1] - a[1]};
  const PetscReal length = e[0] * e[0] + e[1] * e[1];
  const PetscReal along  = length > 0. ? PetscClipInterval((d[0] * e[0] + d[1] * e[1]) / length, 0., 1.) : 0.;

  return PetscSqr(d[0] - along * e[0]) + PetscSqr(d[1] - along * e[1]);
}

PetscReal MpmOutlineDistance(const MpmOutline *outline, const PetscReal x[])
{
  PetscReal least = PETSC_MAX_REAL;

  for (PetscInt f = 0; f < outline->features; f++) {
    const MpmFeature *feature = &outline->feature[f];

    for (PetscInt k = feature->first; k < feature->end; k++) {
      const PetscInt   count = outline->start[k + 1] - outline->start[k];
      const PetscReal *at    = &outline->at[2 * outline->start[k]];

      for (PetscInt i = 0; i < count; i++) {
        const PetscInt next = i + 1 < count ? i + 1 : feature->type == MPM_OUTLINE_POLYGON ? 0 : i;

        least = PetscMin(least, EdgeDistance(&at[2 * i], &at[2 * next], x));
      }
    }
  }
  return PetscSqrtReal(least);
}

const char *MpmOutlineText(const MpmOutline *outline, PetscInt feature, const char *name)
{
  for (PetscInt k = 0; k < outline->names; k++)
    if (!strcmp(outline->name[k], name)) return outline->value[feature * outline->names + k];
  return NULL;
}

PetscBool MpmOutlineNumber(const MpmOutline *outline, PetscInt feature, const char *name, PetscReal *number)
{
  const char *text = MpmOutlineText(outline, feature, name);
  char       *end;

  if (!text) return PETSC_FALSE;
  *number = strtod(text, &end);
  return (PetscBool)(end != text && !*end && !PetscIsInfOrNanReal(*number));
}

void MpmOutlineBounds(const MpmOutline *outline, PetscReal lower[2], PetscReal upper[2])
{
  for (PetscInt a = 0; a < 2; a++) {
    lower[a] = PETSC_INFINITY;
    upper[a] = PETSC_NINFINITY;
    for (PetscInt v = 0; v < outline->start[outline->paths]; v++) {
      lower[a] = PetscMin(lower[a], outline->at[2 * v + a]);
      upper[a] = PetscMax(upper[a], outline->at[2 * v + a]);
    }
  }
}

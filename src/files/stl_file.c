/*
  STL files.

    binary  80 bytes of remark, the number of triangles (4 bytes), and 50 bytes a triangle: its normal and three corners
            as floats, two bytes more; little-endian
    ASCII   solid NAME / facet normal x y z / outer loop / vertex x y z (three times) / endloop / endfacet / endsolid

  A file is binary when it is as long as its number of triangles makes it; many of those begin with "solid", too.
*/
#include "files/stl_file.h"

#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#define HEADER   84
#define TRIANGLE 50
#define MOST     100000000 /* triangles: 7 GB of coordinates, and still an int in messages of MPI */

/* The whole file and a closing zero, or NULL and a complaint. */
static PetscErrorCode ReadBytes(const char *path, char **bytes, size_t *length, char message[MPM_STL_MESSAGE])
{
  FILE *stream = fopen(path, "rb");
  long  size   = -1;

  PetscFunctionBeginUser;
  *bytes  = NULL;
  *length = 0;
  if (stream && !fseek(stream, 0, SEEK_END)) size = ftell(stream);
  if (size == LONG_MAX) { /* a folder */
    errno = EISDIR;
    size  = -1;
  }
  if (size < 0) PetscCall(PetscSNPrintf(message, MPM_STL_MESSAGE, "cannot be read: %s", strerror(errno)));
  else {
    rewind(stream);
    *length = (size_t)size;
    PetscCall(PetscCalloc1(*length + 1, bytes));
    if (fread(*bytes, 1, *length, stream) != *length)
      PetscCall(PetscSNPrintf(message, MPM_STL_MESSAGE, "cannot be read"));
  }
  if (stream) (void)fclose(stream);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static uint32_t LittleEndian(const char bytes[4])
{
  uint32_t value = 0;

  for (int k = 3; k >= 0; k--) value = value << 8 | (unsigned char)bytes[k];
  return value;
}

static PetscErrorCode TakeBinary(const char *bytes, PetscInt count, PetscReal corners[], char message[MPM_STL_MESSAGE])
{
  PetscFunctionBeginUser;
  for (PetscInt t = 0; t < count && !message[0]; t++) {
    const char *corner = bytes + HEADER + (size_t)t * TRIANGLE + 12;

    for (PetscInt k = 0; k < 9; k++) {
      const uint32_t word = LittleEndian(corner + 4 * k);
      float          value;

      memcpy(&value, &word, sizeof(value));
      corners[9 * (PetscInt64)t + k] = (PetscReal)value;
      if (PetscIsInfOrNanReal((PetscReal)value))
        PetscCall(
          PetscSNPrintf(message, MPM_STL_MESSAGE, "a corner of triangle %" PetscInt_FMT " is no finite number", t + 1));
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The three numbers behind a word. */
static PetscBool ParsePlace(const char *text, PetscReal place[3])
{
  for (PetscInt a = 0; a < 3; a++) {
    char *end;

    place[a] = (PetscReal)strtod(text, &end);
    if (end == text || PetscIsInfOrNanReal(place[a])) return PETSC_FALSE;
    text = end;
  }
  return (PetscBool)!text[strspn(text, " \t\r")];
}

/* The text behind the word where the line, blanks aside, begins with it; otherwise NULL. */
static const char *Behind(const char *line, const char *word)
{
  const size_t length = strlen(word);

  line += strspn(line, " \t\r");
  return strncasecmp(line, word, length) || !strchr(" \t\r\n", line[length]) ? NULL : line + length;
}

/* Line by line, in place: corners are counted within their facet. */
static PetscErrorCode TakeAscii(char *text, PetscInt *count, PetscReal corners[], char message[MPM_STL_MESSAGE])
{
  static const char *const others[] = {"solid", "endsolid", "outer", "endloop"};
  PetscInt                 number = 0, in_facet = -1; /* its corners so far; -1: outside of any */
  char                    *next, *quoted;

  PetscFunctionBeginUser;
  for (char *line = text; line && !message[0]; line = next) {
    PetscBool   known;
    const char *rest;

    number++;
    next = strchr(line, '\n');
    if (next) *next++ = '\0';
    known = (PetscBool)!line[strspn(line, " \t\r")];
    for (size_t k = 0; k < sizeof(others) / sizeof(others[0]); k++)
      if (Behind(line, others[k])) known = PETSC_TRUE;
    if (Behind(line, "facet") && in_facet < 0) {
      known    = PETSC_TRUE;
      in_facet = 0;
    } else if (Behind(line, "endfacet") && in_facet == 3) {
      known    = PETSC_TRUE;
      in_facet = -1;
      (*count)++;
    } else if ((rest = Behind(line, "vertex")) && in_facet >= 0 && in_facet < 3) {
      known = ParsePlace(rest, &corners[9 * (PetscInt64)*count + 3 * in_facet]);
      in_facet++;
    }
    if (known) continue;
    PetscCall(MpmTextQuote(line, &quoted));
    PetscCall(PetscSNPrintf(message, MPM_STL_MESSAGE,
                            "line %" PetscInt_FMT ", '%.60s', is not what an ASCII STL file has there", number,
                            quoted));
    PetscCall(PetscFree(quoted));
  }
  if (!message[0] && in_facet >= 0)
    PetscCall(PetscSNPrintf(message, MPM_STL_MESSAGE, "ends within triangle %" PetscInt_FMT, *count + 1));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmStlRead(const char *path, PetscInt *count, PetscReal **corners, char message[MPM_STL_MESSAGE])
{
  size_t length, lines = 1;
  char  *bytes;

  PetscFunctionBeginUser;
  *count   = 0;
  *corners = NULL;
  PetscCall(ReadBytes(path, &bytes, &length, message));
  const uint32_t  told   = length >= HEADER ? LittleEndian(bytes + HEADER - 4) : 0;
  const PetscBool binary = (PetscBool)(length >= HEADER && length == HEADER + (size_t)told * TRIANGLE);

  if (message[0]) goto done;
  if (binary && told <= MOST) {
    *count = (PetscInt)told;
    PetscCall(PetscMalloc1(9 * (size_t)told, corners));
    PetscCall(TakeBinary(bytes, *count, *corners, message));
  } else if (!binary && Behind(bytes, "solid")) {
    for (const char *c = bytes; *c; c++) lines += *c == '\n';
    PetscCall(PetscMalloc1(9 * (lines / 5 + 1), corners)); /* no facet has fewer lines, and the last may break off */
    PetscCall(TakeAscii(bytes, count, *corners, message));
  } else if (binary)
    PetscCall(PetscSNPrintf(message, MPM_STL_MESSAGE, "has %u triangles, at most %d are read", told, MOST));
  else
    PetscCall(PetscSNPrintf(message, MPM_STL_MESSAGE,
                            "is no STL file: it does not begin with 'solid', and its %zu bytes are not the %zu of a "
                            "binary one with %u triangles",
                            length, HEADER + (size_t)told * TRIANGLE, told));
  if (!message[0] && !*count) PetscCall(PetscSNPrintf(message, MPM_STL_MESSAGE, "has no triangles"));
done:
  PetscCall(PetscFree(bytes));
  PetscFunctionReturn(PETSC_SUCCESS);
}

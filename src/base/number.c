/*
  Numbers from and to text: strict where a user wrote it, round-trip safe where the program writes it.
*/
#include "base/base.h"

#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MPM_QUOTE_LENGTH 80 /* characters of a value that a message repeats */

void MpmRealText(PetscReal value, char text[MPM_NUMBER_TEXT])
{
  for (int digits = 15; digits <= 17; digits++) {
    snprintf(text, MPM_NUMBER_TEXT, "%.*g", digits, (double)value);
    if (strtod(text, NULL) == value) return;
  }
}

/* True where only blanks follow. */
static PetscBool OnlyBlanks(const char text[])
{
  while (isspace((unsigned char)*text)) text++;
  return *text ? PETSC_FALSE : PETSC_TRUE;
}

PetscBool MpmParseReal(const char text[], PetscReal *value)
{
  char        *end;
  const double number = strtod(text, &end);

  /* Overflow reads as infinity and is refused with it; underflow to a tiny number or zero is accepted. */
  if (end == text || !OnlyBlanks(end) || !isfinite(number)) return PETSC_FALSE;
  *value = (PetscReal)number;
  return PETSC_TRUE;
}

PetscBool MpmParseInt(const char text[], PetscInt *value)
{
  char     *end;
  long long number;

  errno  = 0;
  number = strtoll(text, &end, 10);
  if (end == text || !OnlyBlanks(end) || errno == ERANGE) return PETSC_FALSE;
  if (number < (long long)PETSC_INT_MIN || number > (long long)PETSC_INT_MAX) return PETSC_FALSE;
  *value = (PetscInt)number;
  return PETSC_TRUE;
}

PetscErrorCode MpmTextAppend(char **text, const char format[], ...)
{
  va_list arguments;
  size_t  old = 0;
  int     extra;
  char   *longer;

  PetscFunctionBegin;
  if (*text) old = strlen(*text);
  va_start(arguments, format);
  extra = vsnprintf(NULL, 0, format, arguments);
  va_end(arguments);
  PetscCheck(extra >= 0, PETSC_COMM_SELF, PETSC_ERR_LIB, "vsnprintf() failed on \"%s\"", format);
  PetscCall(PetscMalloc1(old + (size_t)extra + 1, &longer));
  if (*text) memcpy(longer, *text, old);
  va_start(arguments, format);
  vsnprintf(longer + old, (size_t)extra + 1, format, arguments);
  va_end(arguments);
  PetscCall(PetscFree(*text));
  *text = longer;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTextQuote(const char value[], char **quoted)
{
  PetscFunctionBegin;
  while (isspace((unsigned char)value[0]) && value[1]) value++;
  *quoted = NULL;
  PetscCall(MpmTextAppend(quoted, "%.*s%s", MPM_QUOTE_LENGTH, value, strlen(value) > MPM_QUOTE_LENGTH ? "..." : ""));
  for (char *c = *quoted; *c; c++) {
    if (iscntrl((unsigned char)*c)) *c = ' ';
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTextSplit(const char text[], PetscInt *count, char ***parts)
{
  PetscInt n = 0, commas = 0;

  PetscFunctionBegin;
  for (const char *c = text; *c; c++) commas += (*c == ',');
  PetscCall(PetscCalloc1((size_t)commas + 1, parts));
  while (isspace((unsigned char)*text)) text++;
  while (*text || n > 0) {
    const char *end = text + strcspn(text, ","), *next = *end ? end + 1 : NULL;

    while (isspace((unsigned char)*text) && text < end) text++;
    while (end > text && isspace((unsigned char)end[-1])) end--;
    PetscCall(MpmTextAppend(&(*parts)[n++], "%.*s", (int)(end - text), text));
    if (!next) break;
    text = next;
  }
  *count = n;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmNamesDestroy(PetscInt count, char ***names)
{
  PetscFunctionBegin;
  if (!*names) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt i = 0; i < count; i++) PetscCall(PetscFree((*names)[i]));
  PetscCall(PetscFree(*names));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscInt MpmTextDistance(const char a[], const char b[])
{
  const size_t length = strlen(b);
  PetscInt     distance, *row = (PetscInt *)malloc((length + 1) * sizeof(*row));

  if (!row) return PETSC_INT_MAX;
  for (size_t j = 0; j <= length; j++) row[j] = (PetscInt)j;
  for (size_t i = 0; a[i]; i++) {
    PetscInt diagonal = row[0];

    row[0] = (PetscInt)i + 1;
    for (size_t j = 0; j < length; j++) {
      const PetscInt above  = row[j + 1];
      const int      differ = tolower((unsigned char)a[i]) != tolower((unsigned char)b[j]);

      row[j + 1] = PetscMin(PetscMin(above, row[j]) + 1, diagonal + differ);
      diagonal   = above;
    }
  }
  distance = row[length];
  free(row);
  return distance;
}

const char *MpmTextNearest(const char text[], PetscInt count, char *const names[], PetscInt most)
{
  const char *nearest = NULL;

  for (PetscInt k = 0; k < count; k++) {
    const PetscInt distance = MpmTextDistance(text, names[k]);

    if (distance > most || (nearest && distance == most)) continue;
    most    = distance;
    nearest = names[k];
  }
  return nearest;
}

int MpmDecodeUTF8(const unsigned char s[], unsigned *code)
{
  static const unsigned least[] = {0, 0, 0x80, 0x800, 0x10000}; /* longer forms than needed are not UTF-8 */
  const int size = s[0] < 0x80 ? 1 : s[0] < 0xC0 ? 0 : s[0] < 0xE0 ? 2 : s[0] < 0xF0 ? 3 : s[0] < 0xF8 ? 4 : 0;

  *code = size < 2 ? s[0] : s[0] & (0x7Fu >> size);
  for (int i = 1; i < size; i++) {
    if ((s[i] & 0xC0) != 0x80) return 0;
    *code = (*code << 6) | (s[i] & 0x3Fu);
  }
  if (*code < least[size] || *code > 0x10FFFF || (*code >= 0xD800 && *code < 0xE000)) return 0;
  return size;
}

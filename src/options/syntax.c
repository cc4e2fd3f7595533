/*
  A check of a scene's text before PETSc reads it, whose messages say little of a fault and which takes minutes over
  some files.
*/
#include "options/scene_file.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define DEEPEST 100 /* maps in braces, one in the other */

/* Fault of a line; NULL for none. `depth` counts open braces and brackets from line to line. */
static const char *LineFault(const char line[], size_t length, PetscBool yaml, PetscInt *depth)
{
  const size_t indent = strspn(line, " \t");

  if (strlen(line) < length) return "holds a byte of value 0: not a text";
  for (const char *c = line; *c; c++) {
    if (iscntrl((unsigned char)*c) && !strchr("\t\n\r\f", *c)) return "holds a control character: not a text";
    if (*c == '{' || *c == '[') (*depth)++;
    else if (*c == '}' || *c == ']') (*depth)--;
    if (*depth > DEEPEST) return "is nested more than 100 deep";
  }
  if (yaml && memchr(line, '\t', indent) && !strchr("#\r\n", line[indent]))
    return "is indented by a tab: YAML takes blanks";
  return NULL;
}

static const char *FileFault(const char path[], PetscBool yaml, long long *number)
{
  const char *fault = NULL;
  char       *line  = NULL;
  size_t      size  = 0;
  PetscInt    depth = 0;
  FILE       *file  = fopen(path, "r");

  *number = 0;
  if (!file) return "cannot be read";
  while (!fault) {
    const ssize_t length = getline(&line, &size, file);

    if (length < 0) break;
    (*number)++;
    fault = LineFault(line, (size_t)length, yaml, &depth);
  }
  free(line);
  fclose(file);
  return fault;
}

PetscErrorCode MpmOptionsCheckFile(MPI_Comm comm, const char option[], const char path[], PetscBool yaml)
{
  const char *ending    = strrchr(path, '.');
  char        text[256] = "";
  PetscMPIInt rank;

  PetscFunctionBegin;
  if (ending && (!strcmp(ending, ".yaml") || !strcmp(ending, ".yml"))) yaml = PETSC_TRUE;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  if (rank == 0) {
    long long   line;
    const char *fault = FileFault(path, yaml, &line);

    if (fault) snprintf(text, sizeof(text), "line %lld %s", line, fault);
    else if (yaml) PetscCall(MpmYAMLCheck(path, text, sizeof(text)));
  }
  PetscCallMPI(MPI_Bcast(text, (int)sizeof(text), MPI_CHAR, 0, comm));
  MpmCheckInput(!*text, "%s %s: %s", option, path, text);
  PetscFunctionReturn(PETSC_SUCCESS);
}

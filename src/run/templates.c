/*
  `talus new`: scenes to start from.
*/
#include <errno.h>
#include <stdio.h>
#include <string.h>
#include "run/templates.h"

/* Names and texts, compiled in from templates/. */
static const struct {
  const char *name, *text;
} templates[] = {
#include "mpm_templates.h"
};

/* First line of a template, after its "# ". */
static PetscErrorCode PrintTitle(MPI_Comm comm, const char name[], const char text[])
{
  PetscFunctionBegin;
  PetscCall(PetscPrintf(comm, "  %-12s %.*s\n", name, (int)strcspn(&text[2], "\n"), &text[2]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes a new file; 0 or errno. */
static int WriteNew(const char path[], const char text[])
{
  FILE *file = fopen(path, "wx");
  int   failure;

  if (!file) return errno;
  failure = fputs(text, file) < 0 ? errno : 0;
  return fclose(file) && !failure ? errno : failure;
}

static PetscErrorCode Find(const char name[], const char **text)
{
  char *names = NULL;

  PetscFunctionBegin;
  *text = NULL;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(templates); k++) {
    if (!strcmp(name, templates[k].name)) *text = templates[k].text;
    PetscCall(MpmTextAppend(&names, "%s%s", names ? ", " : "", templates[k].name));
  }
  MpmCheckInput(*text, "new %s: there is no such scene; must be one of %s", name, names);
  PetscCall(PetscFree(names));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTemplateWrite(MPI_Comm comm, const MpmCommandLine *line)
{
  char        path[PETSC_MAX_PATH_LEN];
  const char *text;
  int         failure = 0;
  PetscMPIInt rank;

  PetscFunctionBegin;
  if (!line->topic) {
    PetscCall(PetscPrintf(comm, "talus new NAME [FILE] writes a scene with comments, to NAME.yaml if no FILE is given; "
                                "-: to standard output.\n\n"));
    for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(templates); k++)
      PetscCall(PrintTitle(comm, templates[k].name, templates[k].text));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(Find(line->topic, &text));
  MpmCheckInput(line->count == 1, "new %s: %s is one word too many; one FILE may follow", line->topic,
                line->words[line->count - 1]);
  if (line->file && !strcmp(line->file, "-")) {
    PetscCall(PetscPrintf(comm, "%s", text));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(
    PetscSNPrintf(path, sizeof(path), "%s%s", line->file ? line->file : line->topic, line->file ? "" : ".yaml"));
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  if (!rank) failure = WriteNew(path, text);
  PetscCallMPI(MPI_Bcast(&failure, 1, MPI_INT, 0, comm));
  MpmCheckInput(!failure, "new %s: %s cannot be written: %s", line->topic, path, strerror(failure));
  PetscCall(
    PetscPrintf(comm, "%s written; `talus check %s` says what is in it, `talus %s` runs it\n", path, path, path));
  PetscFunctionReturn(PETSC_SUCCESS);
}

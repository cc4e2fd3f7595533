#pragma once
/*
  The words of the command line, before PETSc reads them.
*/
#include "base/base.h"

typedef enum {
  MPM_TASK_RUN,
  MPM_TASK_CHECK,
  MPM_TASK_HELP,
  MPM_TASK_TOPIC,
  MPM_TASK_JSON,
  MPM_TASK_VERSION,
  MPM_TASK_NEW
} MpmTask;

/* The task that the command line asks for, with its options. */
typedef struct {
  MpmTask     task;
  const char *topic;   /* of MPM_TASK_TOPIC and MPM_TASK_NEW; NULL: all */
  const char *file;    /* of MPM_TASK_NEW; NULL: none */
  const char *picture; /* file that MPM_TASK_CHECK draws the scene into; empty: it is missing; NULL: none */
  int         count;   /* of words, the program's name first */
  char      **words;   /* with -options_file before each scene; allocated, its texts borrowed */
  int         scenes;  /* files named without an option; they stand first */
  int         owns_input;
  char        input[PETSC_MAX_PATH_LEN]; /* file that holds the standard input; empty: none */
} MpmCommandLine;

/*
  Reads `talus SCENE... -option value ...`, `talus help TOPIC`, `talus new NAME FILE` and the options that ask for a
  page. Called before PetscInitialize(); returns nonzero where memory is short.
*/
int  MpmCommandLineRead(int argc, char **argv, MpmCommandLine *line);
void MpmCommandLineFree(MpmCommandLine *line);
/* Keeps the standard input of rank 0 as a file, whose name replaces the word "-" behind -options_file. Collective. */
PetscErrorCode MpmStandardInputKeep(MPI_Comm comm, MpmCommandLine *line);
/* Removes that file, on the rank that made it. */
void MpmStandardInputRemove(MpmCommandLine *line);

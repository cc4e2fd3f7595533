#pragma once
/*
  Commands that a script in Python carries out: `talus plot`, `talus view`, and the picture of `talus check`.
*/
#include "base/base.h"

/* Path of the first of some files, given from the program's folder or one above it; empty where there is none. */
void MpmFileFindBeside(PetscInt count, const char *const places[], char path[PETSC_MAX_PATH_LEN]);
/* Exit status of a command, 127 where there is no such program; its output is dropped where `silent`. */
int MpmCommandCall(char *const words[], PetscBool silent);
/* True where the first word of the command line asks for a script. */
PetscBool MpmScriptNamed(int argc, char **argv);
/* Replaces the program by the script. Returns the exit status where that fails, after a line on stderr. */
int MpmScriptRun(int argc, char **argv);
/* Runs the script for a picture of the scene whose first state has this prefix; its exit status. */
int MpmScriptDraw(const char prefix[], const char picture[]);

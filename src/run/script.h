#pragma once
/*
  Commands that a script in Python carries out: `talus plot`, `talus view`, and the picture of `talus check`.
*/
#include "base/base.h"

/* True where the first word of the command line asks for a script. */
PetscBool MpmScriptNamed(int argc, char **argv);
/* Replaces the program by the script. Returns the exit status where that fails, after a line on stderr. */
int MpmScriptRun(int argc, char **argv);
/* Runs the script for a picture of the scene whose first state has this prefix; its exit status. */
int MpmScriptDraw(const char prefix[], const char picture[]);

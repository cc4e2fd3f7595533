#pragma once
/*
  `talus check-law PLUGIN.so NAME`: the conformance tests of the laws, for a law of a plugin.
*/
#include "base/base.h"

/* True where the first word of the command line asks for the tests. */
PetscBool MpmLawCheckNamed(int argc, char **argv);
/* Runs the tests in plane strain and in 3D, which are programs of their own; exit status. */
int MpmLawCheckRun(int argc, char **argv);

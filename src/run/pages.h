#pragma once
/*
  Pages in place of a run: parts of the manual, the manual as data, the version.
*/
#include "run/command_line.h"

/* Prints the page that the command line asks for. Collective. */
PetscErrorCode MpmPagePrint(MPI_Comm comm, const MpmCommandLine *line);

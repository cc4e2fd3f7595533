#pragma once
#include "base/base.h"

/* One option of the manual: its name, and its text in a column of its own. */
PetscErrorCode MpmHelpEntry(MPI_Comm comm, const char name[], const char text[]);

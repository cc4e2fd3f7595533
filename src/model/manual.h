#pragma once
/*
  Text of -help before and after the options.
*/
#include <petscsys.h>
#include "talus/compat.h"

/* How the program is called, in four lines. */
PetscErrorCode MpmHelpUsage(MPI_Comm comm, FILE *file);
/* Text before the options, and behind them. */
PetscErrorCode MpmHelpBegin(MPI_Comm comm);
PetscErrorCode MpmHelpEnd(MPI_Comm comm);
/* PETSc's own options for Newton's method and linear solvers, as PETSc prints them. */
PetscErrorCode MpmHelpPetsc(MPI_Comm comm);

#pragma once
/*
  The manual that -help prints, besides what the readers of options print themselves.
*/
#include <petscsys.h>
#include <stdio.h>

/* How the program is called, in four lines. */
PetscErrorCode MpmHelpUsage(MPI_Comm comm, FILE *file);
/* What stands before the options, and behind them. */
PetscErrorCode MpmHelpBegin(MPI_Comm comm);
PetscErrorCode MpmHelpEnd(MPI_Comm comm);
/* PETSc's own options for Newton's method and linear solvers, as PETSc prints them. */
PetscErrorCode MpmHelpPetsc(MPI_Comm comm);

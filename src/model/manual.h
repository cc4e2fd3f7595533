#pragma once
/*
  Text of -help before and after the options.
*/
#include "options/help.h"

/* How the program is called, in a few lines, and at most 60 of them with what a user needs first. */
PetscErrorCode MpmHelpUsage(MPI_Comm comm, FILE *file);
PetscErrorCode MpmHelpShort(MPI_Comm comm);
/* All options of all physics in 2D and 3D; the names of the physics are the scopes. Collective. */
PetscErrorCode MpmHelpCollect(MPI_Comm comm, MpmCatalogue catalogue);
/* Text before the options, and behind them. */
PetscErrorCode MpmHelpBegin(MPI_Comm comm);
PetscErrorCode MpmHelpEnd(MPI_Comm comm);
/* PETSc's own options for Newton's method and linear solvers, as PETSc prints them. */
PetscErrorCode MpmHelpPetsc(MPI_Comm comm);

#pragma once
/*
  One header hides the differences between the PETSc releases that Talus builds with, 3.18 to 3.25. Written for the
  newer names; this file supplies what the older release lacks.
*/
#include <petscsys.h>

/* An enumerator, not a macro, from 3.19 on: #ifdef would not see it. */
#if PETSC_VERSION_LT(3, 19, 0)
#define PETSC_SUCCESS 0
#endif

/* Renamed in 3.22; the old names draw deprecation warnings there. */
#if PETSC_VERSION_LT(3, 22, 0)
#define PETSC_INT_MIN            PETSC_MIN_INT
#define PETSC_INT_MAX            PETSC_MAX_INT
#define PetscOptionsCreateViewer PetscOptionsGetViewer
#endif

/* PetscBool in messages: an enumeration before 3.24, C's bool from there on. */
#if PETSC_VERSION_LT(3, 24, 0)
#define MPM_MPI_BOOL MPIU_BOOL
#else
#define MPM_MPI_BOOL MPI_C_BOOL
#endif

/* The shell line search's setter was renamed in 3.21. */
#include <petscsnes.h>
#if PETSC_VERSION_LT(3, 21, 0)
#define MpmLineSearchShellSet SNESLineSearchShellSetUserFunc
#else
#define MpmLineSearchShellSet SNESLineSearchShellSetApply
#endif

/* A residual that is not a number: renamed in 3.25. */
#if PETSC_VERSION_LT(3, 25, 0)
#define MPM_SNES_DIVERGED_NAN SNES_DIVERGED_FNORM_NAN
#else
#define MPM_SNES_DIVERGED_NAN SNES_DIVERGED_FUNCTION_NANORINF
#endif

/* The error code of a scene or an option that is wrong. */
#define MPM_ERR_INPUT PETSC_ERR_USER_INPUT

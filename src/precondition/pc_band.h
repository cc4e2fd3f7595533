#pragma once
/*
  The order of unknowns for the PC type `band` (pc_band.c), and where the matrix's entries go in it.
*/
#include "talus/compat.h"
#include <petscksp.h>

/*
  Places count the rank's n unknowns of the band, then the `count` ones of all ranks' borders. The factors' storage is
  one array: the band's lower triangle by columns of width + 1, the border's rows from `first` on by columns, and the
  corner, count x count.
*/
typedef struct {
  PetscBool fits; /* the band and the borders are narrow enough on all ranks; if not, nothing else is set */
  PetscInt  owned, n, width, count, first;
  PetscInt  border, corner, size; /* where the parts of the storage begin, and its end */
  PetscInt *place;                /* of the owned unknowns */
  PetscInt  entries[2];           /* numbers in the matrix's diagonal and off-diagonal blocks */
  PetscInt *to[2];                /* their places in the band; -1: none, for the transposed entry has one */
} MpmBandOrder;

/* The rank's rows: columns that it owns, and the others or NULL; with the global numbers of the others' columns. */
PetscErrorCode MpmBandParts(Mat A, Mat part[2], const PetscInt *columns[]);
PetscErrorCode MpmBandOrderCreate(Mat A, MpmBandOrder *order);
PetscErrorCode MpmBandOrderDestroy(MpmBandOrder *order);

/* Makes the type known to PETSc; true for a solver of that type. */
PetscErrorCode MpmBandRegister(void);
PetscErrorCode MpmBandIs(PC pc, PetscBool *is);
/* MUMPS, where it has taken over; NULL where the band's Cholesky has done, so that the matrix is positive definite. */
PetscErrorCode MpmBandGetWhole(PC pc, PC *whole);

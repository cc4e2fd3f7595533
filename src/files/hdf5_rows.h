#pragma once
/*
  HDF5 files: opening, and reading of the rows of datasets. Not collective. Failures return a negative id or false,
  without messages of HDF5.
*/
#include <hdf5.h>
#include <petscsys.h>
#include "talus/compat.h"

/* Objects left open go with the file; a viewer that holds the file open must not end the run. To be closed. */
hid_t MpmHdf5Access(void);
/* A file that is only read. */
hid_t MpmHdf5Open(const char *path);

/* The types of numbers in memory, and in our files. */
hid_t MpmHdf5Real(void);
hid_t MpmHdf5Integer(void);

/* Rows and columns of a dataset; -1 where there is none of that name, 0 where it has neither one nor two dimensions. */
void MpmHdf5Extent(hid_t group, const char *name, PetscInt64 extent[2]);
/* Rows [first, first + rows) of a dataset of so many columns. */
PetscBool MpmHdf5ReadRows(hid_t group, const char *name, hid_t type, PetscInt64 first, PetscInt64 rows,
                          PetscInt columns, void *values);

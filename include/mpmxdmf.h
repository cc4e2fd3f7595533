#pragma once
/*
  The XDMF index of point states: one temporal collection, one Polyvertex grid a state, numbers by reference into an
  HDF5 file.
*/
#include "mpmoutput.h"
#include "mpmtextfile.h"

/* One state as the index describes it; the datasets' arrays are not looked at. */
typedef struct {
  const char       *file;  /* the HDF5 file, relative to the index */
  const char       *group; /* where in it, like /points/000050 */
  PetscReal         time;
  PetscInt64        points;
  PetscInt          dataset_count;
  const MpmDataset *datasets; /* with one called position, of 2 or 3 components */
  const PetscBool  *integer;  /* of each dataset: integers or reals? */
} MpmXdmfState;

/* Appends the grid of one state. Not collective. */
PetscErrorCode MpmXdmfAppend(MpmTextFile *grids, const MpmXdmfState *state);
/* Writes the index around the grids, which count on rank 0. Collective. */
PetscErrorCode MpmXdmfWrite(MPI_Comm comm, const char *path, const MpmTextFile *grids);

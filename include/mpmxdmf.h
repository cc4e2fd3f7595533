#pragma once
/*
  The XDMF index of states: temporal collections of points (Polyvertex) and of grids (quadrilaterals or hexahedra),
  numbers by reference into an HDF5 file.
*/
#include "mpmoutput.h"
#include "mpmtextfile.h"

/* Where symmetric tensors stand in XDMF's order of components, under the path of the group that holds them. */
#define MPM_XDMF_TENSORS "/tensors"

/* A table as the index describes it; the datasets' arrays are not looked at. */
typedef struct {
  PetscInt64        rows; /* over all ranks */
  PetscInt          dataset_count;
  const MpmDataset *datasets;
  const PetscBool  *integer; /* of each dataset: integers or reals? */
} MpmXdmfTable;

/* One state as the index describes it. */
typedef struct {
  const char  *file;  /* the HDF5 file, relative to the index */
  const char  *group; /* where in it, like /points/000050 */
  const char  *cell_group;
  PetscReal    time;
  size_t       real_size; /* bytes of a real in the file */
  MpmXdmfTable nodes;     /* with one called position, of 2 or 3 components */
  MpmXdmfTable cells;     /* with one called nodes; no datasets: points */
} MpmXdmfState;

/* Appends the grid of one state. Not collective. */
PetscErrorCode MpmXdmfAppend(MpmTextFile *grids, const MpmXdmfState *state);
/* Writes the index of some collections, whose texts count on rank 0; one without text is left out. Collective. */
PetscErrorCode MpmXdmfWrite(MPI_Comm comm, const char *path, PetscInt count, const char *const names[],
                            const MpmTextFile *const grids[]);

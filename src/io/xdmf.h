#pragma once
/*
  The XDMF index of states: temporal collections of points (Polyvertex) and of grids (quadrilaterals or hexahedra),
  numbers by reference into an HDF5 file.
*/
#include "base/base.h"
#include "io/io.h"

/*
  Where symmetric tensors stand with all nine components, under the path of the group that holds them. XDMF's Tensor6 is
  of no use: one of ParaView's two readers takes its six numbers for another order.
*/
#define MPM_XDMF_TENSORS "/tensors"
static inline PetscBool MpmXdmfIsTensor(PetscInt components, PetscBool integer)
{
  return (PetscBool)(components == 6 && !integer);
}

/* A table as the index describes it; the datasets' arrays are not looked at. */
typedef struct {
  PetscInt64        rows; /* over all ranks */
  PetscInt          dataset_count;
  const MpmDataset *datasets;
  const PetscBool  *integer; /* of each dataset: true for integers, false for reals */
} MpmXdmfTable;

/* One state as the index describes it. */
typedef struct {
  const char  *file;  /* the HDF5 file, relative to the index */
  const char  *group; /* where in it, like /points/000050 */
  const char  *cell_group;
  PetscReal    time;
  size_t       real_size; /* bytes of a real in the file */
  const char  *numbers;   /* of points: the path of a column of the numbers of their rows, 0, 1, ... */
  MpmXdmfTable nodes;     /* with one called position, of 2 or 3 components */
  MpmXdmfTable cells;     /* with one called nodes; no datasets: points */
} MpmXdmfState;

/* Appends the grid of one state; without points it is left out: readers open no empty mesh. Not collective. */
PetscErrorCode MpmXdmfAppend(MpmTextFile *grids, const MpmXdmfState *state);
/* Writes the index of one state alone, without its time, which meshio does not read in such a file. Collective. */
PetscErrorCode MpmXdmfWriteAlone(MPI_Comm comm, const char *path, const MpmXdmfState *state);
/* Writes the index of some collections, whose texts count on rank 0; one without text is left out. Collective. */
PetscErrorCode MpmXdmfWrite(MPI_Comm comm, const char *path, PetscInt count, const char *const names[],
                            const MpmTextFile *const grids[]);

#pragma once
/*
  The states of a results file as one file for VTK.
*/
#include "base/base.h"

/*
  Rank 0 writes a VTKHDF file at `path` of all states of the points in the results file beside it. Its arrays refer to
  those of the results file, so that no number is stored twice. Without points there is no file. Collective; fails with
  PETSC_ERR_FILE_WRITE and one line.
*/
PetscErrorCode MpmVtkHdfWrite(MPI_Comm comm, const char *path, const char *h5_path);

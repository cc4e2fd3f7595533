/*
  Voxels: what stands where, by labels of a lattice.

    file    labels (voxels_file.c)
    labels  a name by label or range of labels (labels.c); none: nothing is there
    lower   corners of the lattice
    upper
    size    voxels by axis, as a check of the file
*/
#include "options/options.h"
#include "voxels/voxels.h"

/* Labels on all ranks. */
static PetscErrorCode ReadLabels(const MpmOptions *options, const char path[], const PetscInt size[], MpmVoxels *voxels)
{
  char        message[512] = "";
  PetscMPIInt rank;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(options->comm, &rank));
  if (!rank) PetscCall(MpmVoxelsReadFile(path, voxels->dim, voxels->size, &voxels->count, &voxels->label, message));
  PetscCallMPI(MPI_Bcast(message, (PetscMPIInt)sizeof(message), MPI_CHAR, 0, options->comm));
  MpmCheckInput(!message[0], "-%sfile %s: %s", options->prefix, path, message);
  PetscCallMPI(MPI_Bcast(voxels->size, MPM_MAX_DIM, MPIU_INT, 0, options->comm));
  PetscCallMPI(MPI_Bcast(&voxels->count, 1, MPIU_INT, 0, options->comm));
  for (PetscInt a = 0; a < voxels->dim; a++)
    MpmCheckInput(!size[a] || size[a] == voxels->size[a],
                  "-%ssize: %" PetscInt_FMT " voxels on axis %c, and the file %s has %" PetscInt_FMT, options->prefix,
                  size[a], "xyz"[a], path, voxels -> size[a]);
  if (rank) PetscCall(PetscMalloc1(voxels->count, &voxels->label));
  PetscCallMPI(MPI_Bcast(voxels->label, (PetscMPIInt)voxels->count, MPI_INT, 0, options->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

#define RECENT 4096 /* labels whose places are at hand */

/* Places among the ranges instead of labels. */
static PetscErrorCode FindRanges(const MpmOptions *options, const char path[], MpmVoxels *voxels)
{
  struct {
    int label, place;
  } * recent;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(RECENT, &recent));
  for (PetscInt k = 0; k < RECENT; k++) recent[k].place = -1;
  for (PetscInt k = 0; k < voxels->count; k++) {
    const int    label = voxels->label[k];
    const size_t at    = (size_t)(unsigned)label % RECENT;

    if (recent[at].place < 0 || recent[at].label != label) {
      recent[at].label = label;
      recent[at].place = (int)MpmLabelsFind(&voxels->labels, label);
      MpmCheckInput(recent[at].place >= 0,
                    "-%slabels: %s has the label %d, which no entry names; %d:none leaves it empty", options->prefix,
                    path, label, label);
      voxels->labels.range[recent[at].place].met = PETSC_TRUE;
    }
    voxels->label[k] = recent[at].place;
  }
  PetscCall(PetscFree(recent));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmVoxelsRead(const MpmOptions *options, PetscInt dim, MpmVoxels **handle)
{
  MpmVoxels *voxels;
  PetscInt   size[MPM_MAX_DIM] = {0, 0, 0};
  char      *path;

  PetscFunctionBegin;
  PetscCall(PetscNew(&voxels));
  *handle     = voxels;
  voxels->dim = dim;
  PetscCall(MpmOptionsPath(options, "file",
                           "region voxels: labels, as MetaImage (.mhd, or .raw with its .mhd beside it), CSV with "
                           "columns i, j (, k), label, or HDF5 with the dataset labels, x fastest",
                           MPM_REQUIRED, &path));
  PetscCall(MpmOptionsReals(options, "lower", "m", "lower corner of the voxels", MPM_RANGE_ANY, MPM_REQUIRED, dim,
                            voxels->lower, NULL));
  PetscCall(MpmOptionsReals(options, "upper", "m", "upper corner of the voxels", MPM_RANGE_ANY, MPM_REQUIRED, dim,
                            voxels->upper, NULL));
  PetscCall(MpmOptionsInts(options, "size", "voxels by axis that the file must have", 1, PETSC_INT_MAX, MPM_OPTIONAL,
                           dim, size, NULL));
  PetscCall(MpmLabelsRead(options,
                          "region voxels: materials by label, \"0:none,1:binder,2-900:grain\"; none: no points",
                          PETSC_TRUE, &voxels->labels));
  if (MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt a = 0; a < dim; a++)
    MpmCheckInput(voxels->lower[a] < voxels->upper[a], "-%supper %g on axis %c: must be > -%slower, which is %g",
                  options->prefix, (double)voxels->upper[a], "xyz"[a], options -> prefix, (double)voxels -> lower[a]);
  PetscCall(ReadLabels(options, path, size, voxels));
  PetscCall(FindRanges(options, path, voxels));
  PetscCall(PetscFree(path));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmVoxelsDestroy(MpmVoxels **voxels)
{
  PetscFunctionBegin;
  if (!*voxels) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmLabelsDestroy(&(*voxels)->labels));
  PetscCall(PetscFree((*voxels)->label));
  PetscCall(PetscFree(*voxels));
  PetscFunctionReturn(PETSC_SUCCESS);
}

const MpmLabelRange *MpmVoxelsAt(const MpmVoxels *voxels, const PetscReal x[])
{
  PetscInt at = 0;

  for (PetscInt a = voxels->dim - 1; a >= 0; a--) {
    const PetscReal part = (x[a] - voxels->lower[a]) / (voxels->upper[a] - voxels->lower[a]);
    const PetscInt  k    = (PetscInt)PetscFloorReal(part * (PetscReal)voxels->size[a]);

    at = at * voxels->size[a] + PetscMax(PetscMin(k, voxels->size[a] - 1), 0);
  }
  return &voxels->labels.range[voxels->label[at]];
}

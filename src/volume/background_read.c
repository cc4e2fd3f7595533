/*
  Reading of backgrounds, and their part in checkpoints.
*/
#include "options/options.h"
#include "io/io.h"
#include "grid/grid.h"
#include "volume/background.h"

/* ---- reading ---- */

static PetscErrorCode BackgroundRead(const MpmOptions *options, const char name[], const MpmGrid *grid,
                                     MpmBackground *background)
{
  char      *prefix = NULL;
  MpmOptions block  = {options->comm, NULL, options->record};
  PetscReal  tolerance[MPM_MAX_DIM], E = 0., nu = 0.;
  PetscInt   cells = 0;

  PetscFunctionBeginUser;
  PetscCall(MpmTextAppend(&prefix, "mpm_background_%s_", name));
  block.prefix = prefix;
  PetscCall(MpmOptionsHeading(&block, "Background stiffness of the grid's cells"));
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) tolerance[a] = MPM_TOLERANCE * grid->h[a];
  PetscCall(MpmRegionCreate(&block, grid->dim, tolerance, &background->region));
  PetscCall(MpmOptionsReal(&block, "E", "Pa", "Young's modulus in every cell whose centre lies in the region",
                           MPM_RANGE_POSITIVE, MPM_REQUIRED, &E, NULL));
  PetscCall(
    MpmOptionsReal(&block, "nu", "-", "Poisson's ratio", ((MpmRange){-1., 0.5, PETSC_TRUE}), MPM_OPTIONAL, &nu, NULL));
  background->mu     = E / (2. * (1. + nu));
  background->lambda = E * nu / ((1. + nu) * (1. - 2. * nu));
  if (!MpmOptionsHelp()) {
    PetscCall(MpmBackgroundCellsList(background, grid, &cells, NULL));
    MpmCheckInput(cells, "-%sregion: has the centre of no cell of the grid", prefix);
  }
  PetscCall(PetscFree(prefix));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmBackgroundsRead(const MpmOptions *options, const MpmGrid *grid, MpmBackgrounds **backgrounds)
{
  MpmBackgrounds read = {0};

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsBlocks(options, "backgrounds",
                             "names of regions whose cells have a stiffness beside the material", MPM_OPTIONAL,
                             &read.count, &read.names));
  if (!read.count) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscNew(backgrounds));
  PetscCall(PetscCalloc1(read.count, &read.at));
  **backgrounds = read;
  for (PetscInt k = 0; k < read.count; k++) PetscCall(BackgroundRead(options, read.names[k], grid, &read.at[k]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmBackgroundsDestroy(MpmBackgrounds **address)
{
  MpmBackgrounds *backgrounds = *address;

  PetscFunctionBeginUser;
  if (!backgrounds) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt k = 0; k < backgrounds->count; k++) PetscCall(MpmRegionDestroy(&backgrounds->at[k].region));
  PetscCall(PetscFree(backgrounds->at));
  PetscCall(MpmNamesDestroy(backgrounds->count, &backgrounds->names));
  PetscCall(MpmBackgroundKindsDestroy(backgrounds));
  PetscCall(PetscFree(backgrounds->cells.kind));
  PetscCall(PetscFree(backgrounds->way));
  PetscCall(PetscFree2(backgrounds->u_n, backgrounds->touch));
  PetscCall(PetscFree(*address));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- checkpoints ---- */

PetscErrorCode MpmBackgroundsSave(const MpmBackgrounds *backgrounds, MPI_Comm comm, MpmTextFile *bytes)
{
  const int   mine = (int)((size_t)backgrounds->way_count * sizeof(*backgrounds->way));
  PetscMPIInt rank, size;
  int        *length, *offset, all = 0;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCallMPI(MPI_Comm_size(comm, &size));
  PetscCall(PetscMalloc2(size, &length, size, &offset));
  PetscCallMPI(MPI_Gather(&mine, 1, MPI_INT, length, 1, MPI_INT, 0, comm));
  for (PetscMPIInt r = 0; r < size && !rank; all += length[r], r++) offset[r] = all;
  PetscCall(MpmTextFileReserve(bytes, (size_t)all));
  PetscCallMPI(MPI_Gatherv(backgrounds->way, mine, MPI_BYTE, rank ? NULL : bytes->data + bytes->length, length, offset,
                           MPI_BYTE, 0, comm));
  bytes->length += (size_t)all;
  PetscCall(PetscFree2(length, offset));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmBackgroundsLoad(MpmBackgrounds *backgrounds, MPI_Comm comm, const MpmTextFile *bytes)
{
  PetscMPIInt rank;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  if (rank) PetscFunctionReturn(PETSC_SUCCESS);
  backgrounds->way_count = (PetscInt)(bytes->length / sizeof(*backgrounds->way));
  PetscCall(PetscMalloc1(backgrounds->way_count, &backgrounds->way));
  PetscCall(PetscMemcpy(backgrounds->way, bytes->data, (size_t)backgrounds->way_count * sizeof(*backgrounds->way)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

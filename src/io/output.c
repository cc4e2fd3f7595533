/*
  MpmOutput - states in HDF5, one group a state, their XDMF index, and a VTKHDF file.

  Create, Write once a state, Finish, Destroy.
*/
#include <errno.h>
#include <string.h>
#include <unistd.h>
#include "base/base.h"
#include "io/io.h"
#include "io/vtkhdf.h"
#include "io/xdmf.h"

struct _p_MpmOutput {
  MPI_Comm    comm;
  char       *h5_path, *xdmf_path, *grid_path, *vtk_path;
  MpmTextFile grids;      /* rank 0: the index of points so far */
  MpmTextFile lattices;   /* and of the background grid */
  PetscBool   started;    /* the files exist */
  PetscBool   single;     /* reals in single precision */
  char       *state_path; /* head of the names of indices of one state; NULL: there are none */
  PetscReal   behind;     /* s, how far the next state's velocities are behind its places */
  PetscInt64  collective; /* bytes from which on all ranks write */
  PetscInt64  slab;       /* most bytes that go to HDF5 at once */
};

#define COLLECTIVE_BYTES (64 << 20)

static PetscErrorCode CreatePath(const char *prefix, const char *suffix, char **path)
{
  size_t length = strlen(prefix) + strlen(suffix) + 1;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(length, path));
  PetscCall(PetscSNPrintf(*path, length, "%s%s", prefix, suffix));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmOutputCreate(MPI_Comm comm, const char *prefix, MpmOutput *output)
{
  PetscFunctionBeginUser;
  PetscCall(PetscNew(output));
  (*output)->comm       = comm;
  (*output)->collective = COLLECTIVE_BYTES;
  (*output)->slab       = MPM_STATE_SLAB;
  PetscCall(CreatePath(prefix, ".h5", &(*output)->h5_path));
  PetscCall(CreatePath(prefix, ".xdmf", &(*output)->xdmf_path));
  PetscCall(CreatePath(prefix, "_grid.xdmf", &(*output)->grid_path));
  PetscCall(CreatePath(prefix, ".vtkhdf", &(*output)->vtk_path));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmOutputSetCollective(MpmOutput output, PetscInt64 bytes)
{
  PetscFunctionBeginUser;
  output->collective = bytes;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmOutputSetSlab(MpmOutput output, PetscInt64 bytes)
{
  PetscFunctionBeginUser;
  output->slab = bytes;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmOutputSetSingle(MpmOutput output, PetscBool single)
{
  PetscFunctionBeginUser;
  output->single = single;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmOutputSetStateFiles(MpmOutput output, const char *prefix)
{
  PetscFunctionBeginUser;
  PetscCall(CreatePath(prefix, "_", &output->state_path));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmOutputSetBehind(MpmOutput output, PetscReal behind)
{
  PetscFunctionBeginUser;
  output->behind = behind;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmOutputDestroy(MpmOutput *output)
{
  PetscFunctionBeginUser;
  if (!*output) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmTextFileDestroy(&(*output)->grids));
  PetscCall(MpmTextFileDestroy(&(*output)->lattices));
  PetscCall(PetscFree((*output)->grid_path));
  PetscCall(PetscFree((*output)->h5_path));
  PetscCall(PetscFree((*output)->xdmf_path));
  PetscCall(PetscFree((*output)->vtk_path));
  PetscCall(PetscFree((*output)->state_path));
  PetscCall(PetscFree(*output));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Refuses the file unless a dataset of this name has one of two numbers of components. */
static PetscErrorCode CheckDatasets(MPI_Comm comm, PetscInt dataset_count, const MpmDataset datasets[],
                                    const char *name, PetscInt one, PetscInt other)
{
  PetscBool found = PETSC_FALSE;

  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < dataset_count; ++i) {
    PetscCheck(datasets[i].components > 0, comm, PETSC_ERR_ARG_OUTOFRANGE, "dataset %s has no components",
               datasets[i].name);
    if (strcmp(datasets[i].name, name)) continue;
    PetscCheck(datasets[i].components == one || datasets[i].components == other, comm, PETSC_ERR_ARG_OUTOFRANGE,
               "dataset %s has %" PetscInt_FMT " components, not %" PetscInt_FMT " or %" PetscInt_FMT, name,
               datasets[i].components, one, other);
    found = PETSC_TRUE;
  }
  PetscCheck(found, comm, PETSC_ERR_ARG_WRONG, "there is no dataset called %s", name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Removes the VTKHDF file of an earlier run, whose states the results file does not have. */
static PetscErrorCode RemoveStale(MpmOutput output)
{
  PetscMPIInt rank;
  int         failure = 0;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(output->comm, &rank));
  if (!rank && unlink(output->vtk_path) && errno != ENOENT) failure = errno;
  PetscCall(MpmFileCheck(output->comm, output->vtk_path, failure));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Rows as a group of the file; `vertices`: each is a cell of its own in the index. */
static PetscErrorCode WriteTable(MpmOutput output, const char *group, PetscInt step, PetscReal time, PetscBool vertices,
                                 const MpmTable *table, MpmStateView *view)
{
  const PetscInt64   number       = step;
  const MpmAttribute attributes[] = {
    {"time", &time, NULL}, {"step", NULL, &number}, {"velocities_behind", &output->behind, NULL}};
  const MpmStateFile state = {.path            = output->h5_path,
                              .group           = group,
                              .append          = output->started,
                              .collective      = output->collective,
                              .attribute_count = output->behind > 0. ? 3 : 2,
                              .attributes      = attributes,
                              .single          = output->single,
                              .vertices        = vertices,
                              .slab            = output->slab};

  PetscFunctionBeginUser;
  *view = (MpmStateView){0};
  if (!output->started) PetscCall(RemoveStale(output));
  PetscCall(MpmStateWrite(output->comm, &state, table, view));
  output->started = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static MpmXdmfTable Indexed(const MpmStateView *view, const MpmTable *table)
{
  return (MpmXdmfTable){view->rows, table->dataset_count, table->datasets, view->integer};
}

static const char *FileName(const char *path)
{
  const char *slash = strrchr(path, '/');

  return slash ? slash + 1 : path;
}

/* The files of the index; `grid`: the grid's own too. */
static PetscErrorCode WriteIndices(MpmOutput output, PetscBool grid)
{
  const char *const        names[] = {"grids", "states"};
  const MpmTextFile *const texts[] = {&output->lattices, &output->grids};

  PetscFunctionBeginUser;
  PetscCall(MpmXdmfWrite(output->comm, output->xdmf_path, 2, names, texts));
  if (grid) PetscCall(MpmXdmfWrite(output->comm, output->grid_path, 1, names, texts));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The index of one state, where the run has such. */
static PetscErrorCode WriteStateFile(MpmOutput output, PetscInt step, const MpmXdmfState *state, PetscBool grid)
{
  char path[PETSC_MAX_PATH_LEN];

  PetscFunctionBeginUser;
  if (!output->state_path) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(
    PetscSNPrintf(path, sizeof(path), "%s%s%06" PetscInt_FMT ".xdmf", output->state_path, grid ? "grid_" : "", step));
  PetscCall(MpmXdmfWriteAlone(output->comm, path, state));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  The state goes into one of the two indices, on rank 0; then the files are rewritten. The points come last: some
  programs read the last collection of a file, and no other.
*/
static PetscErrorCode WriteIndex(MpmOutput output, MpmXdmfState *state, MpmTextFile *index)
{
  PetscMPIInt rank;

  PetscFunctionBeginUser;
  state->file = FileName(output->h5_path);
  PetscCallMPI(MPI_Comm_rank(output->comm, &rank));
  if (rank == 0) PetscCall(MpmXdmfAppend(index, state));
  PetscCall(WriteIndices(output, (PetscBool)(index == &output->lattices)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmOutputWrite(MpmOutput output, PetscInt step, PetscReal time, PetscInt count, const PetscInt id[],
                              PetscInt dataset_count, const MpmDataset datasets[])
{
  const MpmTable points = {count, id, dataset_count, datasets};
  MpmStateView   view;
  char           group[64];
  PetscErrorCode failure;

  PetscFunctionBeginUser;
  PetscCall(CheckDatasets(output->comm, dataset_count, datasets, "position", 2, 3));
  PetscCall(PetscSNPrintf(group, sizeof(group), "/points/%06" PetscInt_FMT, step));
  failure = WriteTable(output, group, step, time, PETSC_TRUE, &points, &view);
  if (!failure) {
    MpmXdmfState state = {.group     = group,
                          .time      = time,
                          .real_size = view.real_size,
                          .numbers   = view.numbers,
                          .nodes     = Indexed(&view, &points)};

    failure = WriteIndex(output, &state, &output->grids);
    if (!failure) failure = WriteStateFile(output, step, &state, PETSC_FALSE);
  }
  PetscCall(PetscFree(view.integer));
  PetscCall(failure);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmOutputWriteGrid(MpmOutput output, PetscInt step, PetscReal time, const MpmTable *nodes,
                                  const MpmTable *cells)
{
  MpmStateView   node_view, cell_view = {0};
  char           group[64], cell_group[64];
  PetscErrorCode failure;

  PetscFunctionBeginUser;
  PetscCall(CheckDatasets(output->comm, nodes->dataset_count, nodes->datasets, "position", 2, 3));
  PetscCall(CheckDatasets(output->comm, cells->dataset_count, cells->datasets, "nodes", 4, 8));
  PetscCall(PetscSNPrintf(group, sizeof(group), "/grid/%06" PetscInt_FMT "/nodes", step));
  PetscCall(PetscSNPrintf(cell_group, sizeof(cell_group), "/grid/%06" PetscInt_FMT "/cells", step));
  failure = WriteTable(output, group, step, time, PETSC_FALSE, nodes, &node_view);
  if (!failure) failure = WriteTable(output, cell_group, step, time, PETSC_FALSE, cells, &cell_view);
  if (!failure) {
    MpmXdmfState state = {.group      = group,
                          .cell_group = cell_group,
                          .time       = time,
                          .real_size  = node_view.real_size,
                          .nodes      = Indexed(&node_view, nodes),
                          .cells      = Indexed(&cell_view, cells)};

    failure = WriteIndex(output, &state, &output->lattices);
    if (!failure) failure = WriteStateFile(output, step, &state, PETSC_TRUE);
  }
  PetscCall(PetscFree(node_view.integer));
  PetscCall(PetscFree(cell_view.integer));
  PetscCall(failure);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmOutputFinish(MpmOutput output)
{
  PetscFunctionBeginUser;
  if (output->started) PetscCall(MpmVtkHdfWrite(output->comm, output->vtk_path, output->h5_path));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- continuing files that exist ---- */

PetscBool MpmOutputStarted(MpmOutput output)
{
  return (PetscBool)(output && output->started);
}

PetscErrorCode MpmOutputGetFiles(MpmOutput output, const char **h5_path, const MpmTextFile **index,
                                 const MpmTextFile **grid_index)
{
  PetscFunctionBeginUser;
  *h5_path    = output->h5_path;
  *index      = &output->grids;
  *grid_index = &output->lattices;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmOutputContinue(MpmOutput output, const char *index, const char *grid_index)
{
  PetscBool grid = (PetscBool)(grid_index && *grid_index);

  PetscFunctionBeginUser;
  output->started = PETSC_TRUE;
  PetscCall(RemoveStale(output));
  PetscCallMPI(MPI_Bcast(&grid, 1, MPM_MPI_BOOL, 0, output->comm));
  if (index) PetscCall(MpmTextFileAppend(&output->grids, "%s", index));
  if (grid_index) PetscCall(MpmTextFileAppend(&output->lattices, "%s", grid_index));
  PetscCall(WriteIndices(output, grid));
  PetscFunctionReturn(PETSC_SUCCESS);
}

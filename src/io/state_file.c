/*
  MpmStateWrite - rows as a group of an HDF5 file.

  Rows come in any order on any rank and travel to contiguous blocks of ids, one block a rank, and each rank writes its
  block as one slab through MPI-IO, collectively. A small state makes one block on rank 0, which writes alone: opening a
  file together takes longer than that. The file is opened and closed in each write, so that results of a killed run can
  be read.
*/
#include <string.h>
#include <petscsf.h>
#include "files/hdf5_rows.h"
#include "io/io.h"
#include "io/xdmf.h"

#define REASON_LENGTH 256
#define NAME_LENGTH   512 /* of a dataset with its groups */

/*
  One write under way. A failure anywhere is agreed upon by all ranks and sticks: later tasks are skipped, everything
  opened is closed, and the error is raised once, at the end.
*/
typedef struct {
  MPI_Comm        comm;
  PetscInt64      points;   /* over all ranks */
  const PetscInt *id;       /* of the local points */
  PetscBool       together; /* all ranks write, otherwise rank 0 alone */
  PetscBool       writes;   /* this rank writes */
  PetscBool      *integer;  /* of each dataset: the same answer on all ranks */
  PetscBool       numbered; /* are the ids the numbers of the rows, 0, 1, ...? */
  PetscLayout     layout;   /* rows to ranks */
  PetscSF         sf;       /* leaves: local points; roots: this rank's block of rows */
  void           *buffer;   /* this rank's block of one dataset */
  PetscReal      *made;     /* where this rank's points' values of one are made */
  hid_t           file, group, transfer;
  PetscInt64      slab;
  PetscBool       failed;
  char            reason[REASON_LENGTH];
} Writer;

/* ---- failures ---- */

/* Keeps the last description, HDF5's innermost and most specific; of it the system's words, if there are any. */
static herr_t KeepDescription(unsigned depth, const H5E_error2_t *error, void *context)
{
  static const char words[] = "error message = '";
  Writer           *writer  = (Writer *)context;
  const char       *from    = error->desc ? strstr(error->desc, words) : NULL;

  (void)depth;
  if (!error->desc || !error->desc[0]) return 0;
  from = from ? from + sizeof(words) - 1 : error->desc;
  strncpy(writer->reason, from, REASON_LENGTH - 1);
  if (from != error->desc) writer->reason[strcspn(writer->reason, "'")] = 0;
  for (char *c = writer->reason; *c; ++c)
    if (*c == '\n' || *c == '\r') *c = ' ';
  return 0;
}

/* To be called right where something failed: the next call of HDF5, be it a close, forgets why. */
static PetscBool Worked(Writer *writer, PetscBool worked)
{
  if (!worked && !writer->reason[0]) {
    (void)H5Ewalk2(H5E_DEFAULT, H5E_WALK_DOWNWARD, KeepDescription, writer);
    if (!writer->reason[0]) strcpy(writer->reason, "HDF5 gives no reason");
  }
  return worked;
}

/* Success on all ranks that write; otherwise the reason of the lowest rank that failed. */
static PetscErrorCode Agree(Writer *writer, PetscBool worked)
{
  PetscMPIInt rank, size, first;

  PetscFunctionBeginUser;
  (void)Worked(writer, worked);
  if (!writer->together) {
    writer->failed = (PetscBool)(writer->failed || !worked);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCallMPI(MPI_Comm_rank(writer->comm, &rank));
  PetscCallMPI(MPI_Comm_size(writer->comm, &size));
  first = worked ? size : rank;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &first, 1, MPI_INT, MPI_MIN, writer->comm));
  if (first < size) {
    PetscCallMPI(MPI_Bcast(writer->reason, REASON_LENGTH, MPI_CHAR, first, writer->comm));
    writer->failed = PETSC_TRUE;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- rows to blocks ---- */

/* A rank without rows has no arrays, so the kind of numbers comes from the others. */
static PetscErrorCode AgreeOnKinds(Writer *writer, PetscInt dataset_count, const MpmDataset datasets[])
{
  PetscMPIInt count;

  PetscFunctionBeginUser;
  PetscCall(PetscMPIIntCast(dataset_count, &count));
  PetscCall(PetscMalloc1(dataset_count, &writer->integer));
  for (PetscInt i = 0; i < dataset_count; ++i) writer->integer[i] = (PetscBool)(datasets[i].integer != NULL);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, writer->integer, count, MPM_MPI_BOOL, MPI_LOR, writer->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Who writes, and so the layout: a block of rows on each rank, or all rows on rank 0. */
static PetscErrorCode ChooseWriters(Writer *writer, PetscInt64 collective, PetscInt dataset_count,
                                    const MpmDataset datasets[])
{
  PetscMPIInt rank, size;
  PetscInt64  columns = 1;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(writer->comm, &rank));
  PetscCallMPI(MPI_Comm_size(writer->comm, &size));
  for (PetscInt i = 0; i < dataset_count; ++i) columns += datasets[i].components;
  writer->together = (PetscBool)(size > 1 && writer->points * columns * (PetscInt64)sizeof(PetscReal) >= collective);
#if !defined(H5_HAVE_PARALLEL)
  writer->together = PETSC_FALSE;
#endif
  writer->writes = (PetscBool)(writer->together || rank == 0);
  PetscCall(PetscLayoutCreateFromSizes(writer->comm,
                                       writer->together ? PETSC_DECIDE : (rank == 0 ? (PetscInt)writer->points : 0),
                                       (PetscInt)writer->points, 1, &writer->layout));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Layout, graph and a buffer that holds the block of the widest dataset. */
static PetscErrorCode WriterSetUp(Writer *writer, PetscInt64 collective, PetscInt count, const PetscInt id[],
                                  PetscInt dataset_count, const MpmDataset datasets[])
{
  PetscInt rows, widest = 1, widest_made = 0, largest = 0, *row;

  PetscFunctionBeginUser;
  writer->points = count;
  writer->id     = id;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &writer->points, 1, MPIU_INT64, MPI_SUM, writer->comm));
  PetscCheck(writer->points <= PETSC_INT_MAX, writer->comm, PETSC_ERR_SUP,
             "%lld points need a PETSc with 64-bit indices", (long long)writer->points);
  PetscCall(ChooseWriters(writer, collective, dataset_count, datasets));
  PetscCall(PetscSFCreate(writer->comm, &writer->sf));
  PetscCall(PetscMalloc1(count, &row));
  PetscCall(MpmNumberRows(writer->comm, count, id, row, &largest));
  writer->numbered = (PetscBool)(largest < PetscMax(writer->points, 1));
  PetscCall(PetscSFSetGraphLayout(writer->sf, writer->layout, count, NULL, PETSC_COPY_VALUES, row));
  PetscCall(PetscFree(row));
  PetscCall(AgreeOnKinds(writer, dataset_count, datasets));
  PetscCall(PetscLayoutGetLocalSize(writer->layout, &rows));
  for (PetscInt i = 0; i < dataset_count; ++i) {
    widest = PetscMax(widest, datasets[i].components);
    if (datasets[i].fill) widest_made = PetscMax(widest_made, datasets[i].components);
  }
  PetscCall(PetscMalloc1(((size_t)count * (size_t)widest_made + 1), &writer->made));
  PetscCall(
    PetscMalloc((size_t)(rows + 1) * (size_t)widest * PetscMax(sizeof(PetscReal), sizeof(PetscInt)), &writer->buffer));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* buffer = the rows of this rank's block, from wherever they are. */
static PetscErrorCode GatherBlock(Writer *writer, PetscBool integer, const MpmDataset *dataset)
{
  const void  *rows = integer ? (const void *)dataset->integer : (const void *)dataset->real;
  MPI_Datatype unit = integer ? MPIU_INT : MPIU_REAL;
  PetscMPIInt  components;

  PetscFunctionBeginUser;
  if (dataset->fill) {
    PetscCall(dataset->fill(dataset->ctx, writer->made));
    rows = writer->made;
  }
  PetscCall(PetscMPIIntCast(dataset->components, &components));
  if (components > 1) {
    PetscCallMPI(MPI_Type_contiguous(components, unit, &unit));
    PetscCallMPI(MPI_Type_commit(&unit));
  }
  PetscCall(PetscSFReduceBegin(writer->sf, unit, rows, writer->buffer, MPI_REPLACE));
  PetscCall(PetscSFReduceEnd(writer->sf, unit, rows, writer->buffer, MPI_REPLACE));
  if (components > 1) PetscCallMPI(MPI_Type_free(&unit));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The buffer's reals become floats in place: HDF5 itself would convert them in small pieces, and not collectively. */
static PetscErrorCode NarrowBlock(Writer *writer, PetscInt components)
{
  const PetscReal *from = (const PetscReal *)writer->buffer;
  PetscInt         rows;

  PetscFunctionBeginUser;
  PetscCall(PetscLayoutGetLocalSize(writer->layout, &rows));
  for (size_t i = 0; i < (size_t)rows * (size_t)components; ++i) {
    const float value = (float)from[i];

    memcpy((char *)writer->buffer + i * sizeof(value), &value, sizeof(value));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- HDF5 ---- */

/* Access to the file, together or alone. */
static hid_t CreateFileAccess(const Writer *writer)
{
  hid_t access = MpmHdf5Access();

#if defined(H5_HAVE_PARALLEL)
  if (writer->together) (void)H5Pset_fapl_mpio(access, writer->comm, MPI_INFO_NULL);
#else
  (void)writer;
#endif
  return access;
}

static PetscErrorCode OpenFile(Writer *writer, const MpmStateFile *state)
{
  hid_t access, creation;

  PetscFunctionBeginUser;
  if (!writer->writes) PetscFunctionReturn(PETSC_SUCCESS);
  access           = CreateFileAccess(writer);
  writer->transfer = H5Pcreate(H5P_DATASET_XFER);
#if defined(H5_HAVE_PARALLEL)
  if (writer->together) (void)H5Pset_dxpl_mpio(writer->transfer, H5FD_MPIO_COLLECTIVE);
#endif
  creation = H5Pcreate(H5P_FILE_CREATE);
  (void)H5Pset_userblock(creation, (hsize_t)state->head);
  writer->file = state->append ? H5Fopen(state->path, H5F_ACC_RDWR, access)
                               : H5Fcreate(state->path, H5F_ACC_TRUNC, creation, access);
  PetscCall(Agree(writer, (PetscBool)(writer->file >= 0)));
  (void)H5Pclose(creation);
  (void)H5Pclose(access);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A number at the group; false when it could not be written. */
static PetscBool WriteAttribute(Writer *writer, const MpmAttribute *attribute)
{
  const double    real    = attribute->real ? (double)*attribute->real : 0.;
  const long long integer = attribute->integer ? (long long)*attribute->integer : 0;
  const hid_t     type    = attribute->real ? H5T_NATIVE_DOUBLE : H5T_NATIVE_LLONG;
  hid_t           space   = H5Screate(H5S_SCALAR);
  hid_t           id      = H5Acreate2(writer->group, attribute->name, type, space, H5P_DEFAULT, H5P_DEFAULT);
  const void     *value   = attribute->real ? (const void *)&real : (const void *)&integer;
  PetscBool       worked  = Worked(writer, (PetscBool)(id >= 0 && H5Awrite(id, type, value) >= 0));

  if (id >= 0) (void)H5Aclose(id);
  (void)H5Sclose(space);
  return worked;
}

static PetscErrorCode OpenGroup(Writer *writer, const MpmStateFile *state)
{
  hid_t creation;

  PetscFunctionBeginUser;
  if (!writer->writes || writer->failed) PetscFunctionReturn(PETSC_SUCCESS);
  creation = H5Pcreate(H5P_LINK_CREATE);
  (void)H5Pset_create_intermediate_group(creation, 1);
  writer->group = H5Gcreate2(writer->file, state->group, creation, H5P_DEFAULT, H5P_DEFAULT);
  PetscCall(Agree(writer, (PetscBool)(writer->group >= 0)));
  (void)H5Pclose(creation);
  for (PetscInt i = 0; i < state->attribute_count && !writer->failed; ++i)
    PetscCall(Agree(writer, WriteAttribute(writer, &state->attributes[i])));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Bytes at the group, from rank 0. */
static PetscErrorCode WriteBytes(Writer *writer, const MpmBytes *bytes)
{
  const hsize_t size = (hsize_t)bytes->size;
  PetscMPIInt   rank;
  hid_t         space, dataset;
  PetscBool     worked = PETSC_TRUE;

  PetscFunctionBeginUser;
  if (!writer->writes || writer->failed) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCallMPI(MPI_Comm_rank(writer->comm, &rank));
  space   = H5Screate_simple(1, &size, NULL);
  dataset = H5Dcreate2(writer->group, bytes->name, H5T_NATIVE_UCHAR, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
  PetscCall(Agree(writer, (PetscBool)(dataset >= 0)));
  if (!writer->failed && size) {
    if (rank) (void)H5Sselect_none(space);
    worked =
      (PetscBool)(H5Dwrite(dataset, H5T_NATIVE_UCHAR, space, space, writer->transfer, rank ? "" : bytes->data) >= 0);
    PetscCall(Agree(writer, worked));
  }
  (void)H5Sclose(space);
  if (dataset >= 0) (void)H5Dclose(dataset);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Writes some rows of the buffer, from row `skip` of it, to row `first` of a dataset that exists; false when it could
  not.
*/
static PetscBool WriteSlab(Writer *writer, hid_t dataset, hid_t type, size_t skip, hsize_t first,
                           const hsize_t extent[2])
{
  hid_t       space = H5Dget_space(dataset), memory = H5Screate_simple(2, extent, NULL);
  hsize_t     start[2] = {first, 0};
  const char *from     = (const char *)writer->buffer + skip * (size_t)extent[1] * H5Tget_size(type);
  herr_t      status;
  PetscBool   worked;

  if (extent[0]) {
    status = H5Sselect_hyperslab(space, H5S_SELECT_SET, start, NULL, extent, NULL);
  } else {
    (void)H5Sselect_none(memory);
    status = H5Sselect_none(space);
  }
  if (status >= 0) status = H5Dwrite(dataset, type, memory, space, writer->transfer, from);
  worked = Worked(writer, (PetscBool)(status >= 0));
  (void)H5Sclose(memory);
  if (space >= 0) (void)H5Sclose(space);
  return worked;
}

static size_t RealSize(PetscBool single)
{
  return single ? sizeof(float) : sizeof(PetscReal);
}

static hid_t RealType(PetscBool single)
{
  return RealSize(single) == sizeof(double) ? H5T_NATIVE_DOUBLE : H5T_NATIVE_FLOAT;
}

/* The buffer, this rank's block, slab by slab; as many slabs on every rank. */
static PetscErrorCode WriteBlock(Writer *writer, hid_t dataset, hid_t type, PetscInt components)
{
  const PetscInt64 wide = (PetscInt64)components * (PetscInt64)H5Tget_size(type);
  const PetscInt   most = (PetscInt)PetscMin(PetscMax(writer->slab / wide, 1), PETSC_INT_MAX);
  const PetscInt  *ranges;
  PetscInt         rows, first;

  PetscFunctionBeginUser;
  PetscCall(PetscLayoutGetLocalSize(writer->layout, &rows));
  PetscCall(PetscLayoutGetRange(writer->layout, &first, NULL));
  PetscCall(PetscLayoutGetRanges(writer->layout, &ranges)); /* rank 0 has most rows */
  for (PetscInt64 done = 0; done < ranges[1] && !writer->failed; done += most) {
    const PetscInt skip      = (PetscInt)PetscMin(done, rows);
    const hsize_t  extent[2] = {(hsize_t)PetscMin(most, rows - skip), (hsize_t)components};

    PetscCall(Agree(writer, WriteSlab(writer, dataset, type, (size_t)skip, (hsize_t)(first + skip), extent)));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The virtual dataset /tensors/<group>/<name>: a symmetric tensor row by row; false when it failed. */
static PetscBool WriteTensor(Writer *writer, const char *group, const char *name, hid_t type)
{
  static const hsize_t column[] = {0, 3, 5, 3, 1, 4, 5, 4, 2}; /* of ours, for each of the nine */
  char                 source[NAME_LENGTH], path[NAME_LENGTH + sizeof(MPM_XDMF_TENSORS)];
  const hsize_t        ours[2] = {(hsize_t)writer->points, 6}, full[2] = {ours[0], 9}, block[2] = {ours[0], 1};
  hid_t                from = H5Screate_simple(2, ours, NULL), to = H5Screate_simple(2, full, NULL), dataset;
  hid_t                creation = H5Pcreate(H5P_DATASET_CREATE), links = H5Pcreate(H5P_LINK_CREATE);
  herr_t               status = 0;
  PetscBool            worked;

  snprintf(source, sizeof(source), "%s/%s", group, name);
  snprintf(path, sizeof(path), MPM_XDMF_TENSORS "%s", source);
  (void)H5Pset_create_intermediate_group(links, 1);
  for (hsize_t k = 0; k < 9 && ours[0] && status >= 0; ++k) {
    const hsize_t into[2] = {0, k}, out_of[2] = {0, column[k]};

    (void)H5Sselect_hyperslab(to, H5S_SELECT_SET, into, NULL, block, NULL);
    (void)H5Sselect_hyperslab(from, H5S_SELECT_SET, out_of, NULL, block, NULL);
    status = H5Pset_virtual(creation, to, ".", source, from);
  }
  (void)H5Sselect_all(to);
  dataset = H5Dcreate2(writer->file, path, type, to, links, creation, H5P_DEFAULT);
  worked  = Worked(writer, (PetscBool)(status >= 0 && dataset >= 0));
  if (dataset >= 0) (void)H5Dclose(dataset);
  (void)H5Pclose(links);
  (void)H5Pclose(creation);
  (void)H5Sclose(to);
  (void)H5Sclose(from);
  return worked;
}

/* The virtual dataset of one column, (points x 1), of an array of numbers; false when it failed. */
static PetscBool WriteColumn(Writer *writer, const char *source, const char *path)
{
  const hsize_t rows[2] = {(hsize_t)writer->points, 1};
  hid_t         from = H5Screate_simple(1, rows, NULL), to = H5Screate_simple(2, rows, NULL), dataset;
  hid_t         creation = H5Pcreate(H5P_DATASET_CREATE), links = H5Pcreate(H5P_LINK_CREATE);
  herr_t        status;
  PetscBool     worked;

  (void)H5Pset_create_intermediate_group(links, 1);
  status  = H5Pset_virtual(creation, to, ".", source, from);
  dataset = H5Dcreate2(writer->file, path, MpmHdf5Integer(), to, links, creation, H5P_DEFAULT);
  worked  = Worked(writer, (PetscBool)(status >= 0 && dataset >= 0));
  if (dataset >= 0) (void)H5Dclose(dataset);
  (void)H5Pclose(links);
  (void)H5Pclose(creation);
  (void)H5Sclose(to);
  (void)H5Sclose(from);
  return worked;
}

/* One dataset out of the buffer: (points) or (points x components) numbers, by the number of its axes, in the machine's
   own types, so that nothing is converted. */
static PetscErrorCode WriteShaped(Writer *writer, const char *name, int axes, PetscInt components, hid_t type)
{
  const hsize_t extent[2] = {(hsize_t)writer->points, (hsize_t)components};
  hid_t         space, creation, links, dataset;

  PetscFunctionBeginUser;
  if (!writer->writes || writer->failed) PetscFunctionReturn(PETSC_SUCCESS);
  space    = H5Screate_simple(axes, extent, NULL);
  creation = H5Pcreate(H5P_DATASET_CREATE);
  links    = H5Pcreate(H5P_LINK_CREATE);
  (void)H5Pset_fill_time(creation, H5D_FILL_TIME_NEVER); /* every row is written */
  (void)H5Pset_create_intermediate_group(links, 1);
  dataset = H5Dcreate2(writer->group, name, type, space, links, creation, H5P_DEFAULT);
  PetscCall(Agree(writer, (PetscBool)(dataset >= 0)));
  (void)H5Pclose(links);
  (void)H5Pclose(creation);
  (void)H5Sclose(space);
  if (!writer->failed && writer->points) PetscCall(WriteBlock(writer, dataset, type, components));
  if (dataset >= 0) (void)H5Dclose(dataset);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode WriteDataset(Writer *writer, const char *name, PetscInt components, hid_t type)
{
  PetscFunctionBeginUser;
  PetscCall(WriteShaped(writer, name, components > 1 ? 2 : 1, components, type));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  The numbers 0, 1, ... of the rows in a column, which a viewer takes for the corners of cells: one dataset for all
  states of as many rows. The ids are these numbers, until points have gone.
*/
static PetscErrorCode WriteNumbers(Writer *writer, const char *group, char path[MPM_STATE_PATH])
{
  PetscInt first, end;

  PetscFunctionBeginUser;
  PetscCall(PetscSNPrintf(path, MPM_STATE_PATH, "/rows/%lld", (long long)writer->points));
  if (!writer->writes || writer->failed) PetscFunctionReturn(PETSC_SUCCESS);
  if (H5Lexists(writer->file, "/rows", H5P_DEFAULT) > 0 && H5Lexists(writer->file, path, H5P_DEFAULT) > 0)
    PetscFunctionReturn(PETSC_SUCCESS);
  if (writer->numbered && writer->points) {
    char ids[MPM_STATE_PATH];

    PetscCall(PetscSNPrintf(ids, sizeof(ids), "%s/id", group));
    PetscCall(Agree(writer, WriteColumn(writer, ids, path)));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(PetscLayoutGetRange(writer->layout, &first, &end));
  for (PetscInt i = first; i < end; i++) ((PetscInt *)writer->buffer)[i - first] = i;
  PetscCall(WriteShaped(writer, path, 2, 1, MpmHdf5Integer()));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Closes all that is open, the file last. */
static PetscErrorCode CloseFile(Writer *writer)
{
  PetscFunctionBeginUser;
  if (writer->group >= 0) (void)H5Gclose(writer->group);
  if (writer->transfer >= 0) (void)H5Pclose(writer->transfer);
  if (writer->file >= 0) {
    PetscBool closed;

    /* other ranks' data may still be in the memory of their machines */
    if (writer->together && !writer->failed)
      PetscCall(Agree(writer, (PetscBool)(H5Fflush(writer->file, H5F_SCOPE_GLOBAL) >= 0)));
    closed = (PetscBool)(H5Fclose(writer->file) >= 0);
    if (!writer->failed) PetscCall(Agree(writer, closed));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sends the result of rank 0 to all ranks, where it wrote alone. */
static PetscErrorCode ShareFailure(Writer *writer)
{
  PetscFunctionBeginUser;
  if (writer->together) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCallMPI(MPI_Bcast(&writer->failed, 1, MPM_MPI_BOOL, 0, writer->comm));
  PetscCallMPI(MPI_Bcast(writer->reason, REASON_LENGTH, MPI_CHAR, 0, writer->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode WriterDestroy(Writer *writer)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(writer->buffer));
  PetscCall(PetscFree(writer->made));
  PetscCall(PetscFree(writer->integer));
  PetscCall(PetscSFDestroy(&writer->sf));
  PetscCall(PetscLayoutDestroy(&writer->layout));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The state into the HDF5 file. HDF5 itself stays silent meanwhile. */
static PetscErrorCode WriteState(Writer *writer, const MpmStateFile *state, PetscInt dataset_count,
                                 const MpmDataset datasets[], MpmStateView *view)
{
  const MpmDataset ids = {.name = "id", .components = 1, .integer = writer->id};
  H5E_auto2_t      report;
  void            *context;

  PetscFunctionBeginUser;
  (void)H5Eget_auto2(H5E_DEFAULT, &report, &context);
  (void)H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
  writer->slab = state->slab ? state->slab : MPM_STATE_SLAB;
  PetscCall(OpenFile(writer, state));
  PetscCall(OpenGroup(writer, state));
  for (PetscInt i = 0; i < state->bytes_count; ++i) PetscCall(WriteBytes(writer, &state->bytes[i]));
  PetscCall(GatherBlock(writer, PETSC_TRUE, &ids));
  PetscCall(WriteDataset(writer, ids.name, 1, MpmHdf5Integer()));
  for (PetscInt i = 0; i < dataset_count; ++i) {
    const PetscInt components = datasets[i].components;
    const hid_t    type       = writer->integer[i] ? MpmHdf5Integer() : RealType(state->single);

    PetscCall(GatherBlock(writer, writer->integer[i], &datasets[i]));
    if (state->single && !writer->integer[i]) PetscCall(NarrowBlock(writer, components));
    PetscCall(WriteDataset(writer, datasets[i].name, components, type));
    if (view && MpmXdmfIsTensor(components, writer->integer[i]) && writer->writes && !writer->failed)
      PetscCall(Agree(writer, WriteTensor(writer, state->group, datasets[i].name, type)));
  }
  if (view && state->vertices) PetscCall(WriteNumbers(writer, state->group, view->numbers));
  PetscCall(CloseFile(writer));
  PetscCall(ShareFailure(writer));
  (void)H5Eset_auto2(H5E_DEFAULT, report, context);
  PetscCheck(!writer->failed, writer->comm, PETSC_ERR_FILE_WRITE, "cannot write %s: %s", state->path, writer->reason);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmStateWrite(MPI_Comm comm, const MpmStateFile *state, const MpmTable *table, MpmStateView *view)
{
  Writer writer = {.comm = comm, .file = H5I_INVALID_HID, .group = H5I_INVALID_HID, .transfer = H5I_INVALID_HID};
  PetscErrorCode failure;

  PetscFunctionBeginUser;
  if (view) *view = (MpmStateView){0};
  failure = WriterSetUp(&writer, state->collective, table->count, table->id, table->dataset_count, table->datasets);
  if (!failure) failure = WriteState(&writer, state, table->dataset_count, table->datasets, view);
  if (view && !failure) {
    view->rows      = writer.points;
    view->real_size = RealSize(state->single);
    view->integer   = writer.integer;
    writer.integer  = NULL;
  }
  PetscCall(WriterDestroy(&writer));
  PetscCall(failure);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  MpmOutput - point states in HDF5, one group a state, and their XDMF index.

  Create, Write once a state, Destroy. Rows come in any order on any rank. They travel to contiguous blocks of ids, one
  block a rank, and each rank writes its block as one slab through MPI-IO, collectively. A small state makes one block
  on rank 0, which writes alone: to open a file together takes longer than that. The file is opened and closed in each
  write: what a killed run had written can be read.
*/
#include <string.h>
#include <hdf5.h>
#include <petscsf.h>
#include "mpmoutput.h"
#include "mpmtextfile.h"
#include "mpmxdmf.h"

struct _p_MpmOutput {
  MPI_Comm    comm;
  char       *h5_path, *xdmf_path, *grid_path;
  MpmTextFile grids;      /* rank 0: the index of points so far */
  MpmTextFile lattices;   /* and of the background grid */
  PetscBool   started;    /* do the files exist? */
  PetscBool   single;     /* reals in single precision? */
  PetscInt64  collective; /* bytes from which on all ranks write */
  PetscInt64  slab;       /* most bytes that go to HDF5 at once */
};

#define REASON_LENGTH    256
#define NAME_LENGTH      512 /* of a dataset with its groups */
#define COLLECTIVE_BYTES (64 << 20)
#define SLAB_BYTES       (1 << 30)

/*
  One write under way. A failure anywhere is agreed upon by all ranks and sticks: what follows is skipped, everything
  opened is closed, and the error is raised once, at the end.
*/
typedef struct {
  MPI_Comm        comm;
  PetscInt64      points;   /* over all ranks */
  const PetscInt *id;       /* of the local points */
  PetscBool       together; /* do all ranks write, or rank 0 alone? */
  PetscBool       writes;   /* does this one? */
  PetscBool      *integer;  /* of each dataset: the same answer on all ranks */
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

/* Keeps the last description it is shown, HDF5's innermost, which tells most; of it the system's words, if it has them. */
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

/* Did it work on all ranks that write? The reason comes from the lowest rank on which it did not. */
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

/*
  Rows go by ascending id: row[i] is the number of ids below id[i], over all ranks. Ids are dealt to the ranks in blocks
  for that, whatever holes there are between them.
*/
static PetscErrorCode NumberRows(MPI_Comm comm, PetscInt count, const PetscInt id[], PetscInt row[])
{
  PetscInt ends[2] = {0, 0}, size, first, below = 0,
           *found; /* ends: the negative of the smallest id, and the largest */
  PetscBool   once = PETSC_TRUE;
  PetscLayout layout;
  PetscSF     sf;

  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < count; ++i) {
    ends[0] = PetscMax(ends[0], -id[i]);
    ends[1] = PetscMax(ends[1], id[i]);
    row[i]  = 1;
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, ends, 2, MPIU_INT, MPI_MAX, comm));
  PetscCheck(ends[0] <= 0, comm, PETSC_ERR_ARG_OUTOFRANGE, "an id of a point is negative: %lld", -(long long)ends[0]);
  PetscCall(PetscLayoutCreateFromSizes(comm, PETSC_DECIDE, ends[1] + 1, 1, &layout));
  PetscCall(PetscLayoutGetLocalSize(layout, &size));
  PetscCall(PetscSFCreate(comm, &sf));
  PetscCall(PetscSFSetGraphLayout(sf, layout, count, NULL, PETSC_COPY_VALUES, id));
  PetscCall(PetscCalloc1(size, &found));
  PetscCall(PetscSFReduceBegin(sf, MPIU_INT, row, found, MPI_SUM));
  PetscCall(PetscSFReduceEnd(sf, MPIU_INT, row, found, MPI_SUM));
  for (PetscInt i = 0; i < size; ++i) {
    once = (PetscBool)(once && found[i] <= 1);
    below += found[i];
  }
  PetscCallMPI(MPI_Scan(&below, &first, 1, MPIU_INT, MPI_SUM, comm));
  first -= below;
  for (PetscInt i = 0; i < size; ++i) {
    const PetscInt here = found[i];

    found[i] = first;
    first += here;
  }
  PetscCall(PetscSFBcastBegin(sf, MPIU_INT, found, row, MPI_REPLACE));
  PetscCall(PetscSFBcastEnd(sf, MPIU_INT, found, row, MPI_REPLACE));
  PetscCall(PetscFree(found));
  PetscCall(PetscSFDestroy(&sf));
  PetscCall(PetscLayoutDestroy(&layout));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &once, 1, MPIU_BOOL, MPI_LAND, comm));
  PetscCheck(once, comm, PETSC_ERR_ARG_WRONG, "two points have the same id");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A rank without rows has no arrays and so cannot tell what kind of numbers the others write. */
static PetscErrorCode AgreeOnKinds(Writer *writer, PetscInt dataset_count, const MpmDataset datasets[])
{
  PetscMPIInt count;

  PetscFunctionBeginUser;
  PetscCall(PetscMPIIntCast(dataset_count, &count));
  PetscCall(PetscMalloc1(dataset_count, &writer->integer));
  for (PetscInt i = 0; i < dataset_count; ++i) writer->integer[i] = (PetscBool)(datasets[i].integer != NULL);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, writer->integer, count, MPIU_BOOL, MPI_LOR, writer->comm));
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
  PetscInt rows, widest = 1, widest_made = 0, *row;

  PetscFunctionBeginUser;
  writer->points = count;
  writer->id     = id;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &writer->points, 1, MPIU_INT64, MPI_SUM, writer->comm));
  PetscCheck(writer->points <= PETSC_INT_MAX, writer->comm, PETSC_ERR_SUP,
             "%lld points need a PETSc with 64-bit indices", (long long)writer->points);
  PetscCall(ChooseWriters(writer, collective, dataset_count, datasets));
  PetscCall(PetscSFCreate(writer->comm, &writer->sf));
  PetscCall(PetscMalloc1(count, &row));
  PetscCall(NumberRows(writer->comm, count, id, row));
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

/* Access to the file: objects left open go with it; a viewer that holds the file open must not end the run. */
static hid_t CreateFileAccess(const Writer *writer)
{
  hid_t access = H5Pcreate(H5P_FILE_ACCESS);

  (void)H5Pset_fclose_degree(access, H5F_CLOSE_STRONG);
#if H5_VERSION_GE(1, 10, 7)
  (void)H5Pset_file_locking(access, 0, 1);
#endif
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

static hid_t IntegerType(void)
{
  return sizeof(PetscInt) == sizeof(long long) ? H5T_NATIVE_LLONG : H5T_NATIVE_INT;
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

/* The virtual dataset /tensors/<group>/<name>: columns of a symmetric tensor in XDMF's order; false when it failed. */
static PetscBool WriteTensor(Writer *writer, const char *group, const char *name, hid_t type)
{
  static const hsize_t column[] = {0, 3, 5, 1, 4, 2}; /* of ours, for each of XDMF's */
  char                 source[NAME_LENGTH], path[NAME_LENGTH + sizeof(MPM_XDMF_TENSORS)];
  const hsize_t        extent[2] = {(hsize_t)writer->points, 6}, block[2] = {extent[0], 1};
  hid_t                from = H5Screate_simple(2, extent, NULL), to = H5Screate_simple(2, extent, NULL), dataset;
  hid_t                creation = H5Pcreate(H5P_DATASET_CREATE), links = H5Pcreate(H5P_LINK_CREATE);
  herr_t               status = 0;
  PetscBool            worked;

  snprintf(source, sizeof(source), "%s/%s", group, name);
  snprintf(path, sizeof(path), MPM_XDMF_TENSORS "%s", source);
  (void)H5Pset_create_intermediate_group(links, 1);
  for (hsize_t k = 0; k < 6 && extent[0] && status >= 0; ++k) {
    const hsize_t start[2] = {0, k}, ours[2] = {0, column[k]};

    (void)H5Sselect_hyperslab(to, H5S_SELECT_SET, start, NULL, block, NULL);
    (void)H5Sselect_hyperslab(from, H5S_SELECT_SET, ours, NULL, block, NULL);
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

/* One dataset out of the buffer: (points) or (points x components) numbers, in the machine's own types, so that
   nothing is converted. */
static PetscErrorCode WriteDataset(Writer *writer, const char *name, PetscInt components, hid_t type)
{
  const hsize_t extent[2] = {(hsize_t)writer->points, (hsize_t)components};
  hid_t         space, creation, dataset;

  PetscFunctionBeginUser;
  if (!writer->writes || writer->failed) PetscFunctionReturn(PETSC_SUCCESS);
  space    = H5Screate_simple(components > 1 ? 2 : 1, extent, NULL);
  creation = H5Pcreate(H5P_DATASET_CREATE);
  (void)H5Pset_fill_time(creation, H5D_FILL_TIME_NEVER); /* every row is written */
  dataset = H5Dcreate2(writer->group, name, type, space, H5P_DEFAULT, creation, H5P_DEFAULT);
  PetscCall(Agree(writer, (PetscBool)(dataset >= 0)));
  (void)H5Pclose(creation);
  (void)H5Sclose(space);
  if (!writer->failed && writer->points) PetscCall(WriteBlock(writer, dataset, type, components));
  if (dataset >= 0) (void)H5Dclose(dataset);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Closes what is open, the file last. */
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

/* All ranks learn what rank 0 knows, where it wrote alone. */
static PetscErrorCode ShareFailure(Writer *writer)
{
  PetscFunctionBeginUser;
  if (writer->together) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCallMPI(MPI_Bcast(&writer->failed, 1, MPIU_BOOL, 0, writer->comm));
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
                                 const MpmDataset datasets[])
{
  const MpmDataset ids = {.name = "id", .components = 1, .integer = writer->id};
  H5E_auto2_t      report;
  void            *context;

  PetscFunctionBeginUser;
  (void)H5Eget_auto2(H5E_DEFAULT, &report, &context);
  (void)H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
  writer->slab = state->slab ? state->slab : SLAB_BYTES;
  PetscCall(OpenFile(writer, state));
  PetscCall(OpenGroup(writer, state));
  for (PetscInt i = 0; i < state->bytes_count; ++i) PetscCall(WriteBytes(writer, &state->bytes[i]));
  PetscCall(GatherBlock(writer, PETSC_TRUE, &ids));
  PetscCall(WriteDataset(writer, ids.name, 1, IntegerType()));
  for (PetscInt i = 0; i < dataset_count; ++i) {
    const PetscInt components = datasets[i].components;
    const hid_t    type       = writer->integer[i] ? IntegerType() : RealType(state->single);

    PetscCall(GatherBlock(writer, writer->integer[i], &datasets[i]));
    if (state->single && !writer->integer[i]) PetscCall(NarrowBlock(writer, components));
    PetscCall(WriteDataset(writer, datasets[i].name, components, type));
    if (state->tensors && components == 6 && !writer->integer[i] && writer->writes && !writer->failed)
      PetscCall(Agree(writer, WriteTensor(writer, state->group, datasets[i].name, type)));
  }
  PetscCall(CloseFile(writer));
  PetscCall(ShareFailure(writer));
  (void)H5Eset_auto2(H5E_DEFAULT, report, context);
  PetscCheck(!writer->failed, writer->comm, PETSC_ERR_FILE_WRITE, "cannot write %s: %s", state->path, writer->reason);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- object ---- */

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
  (*output)->slab       = SLAB_BYTES;
  PetscCall(CreatePath(prefix, ".h5", &(*output)->h5_path));
  PetscCall(CreatePath(prefix, ".xdmf", &(*output)->xdmf_path));
  PetscCall(CreatePath(prefix, "_grid.xdmf", &(*output)->grid_path));
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

PetscErrorCode MpmOutputDestroy(MpmOutput *output)
{
  PetscFunctionBeginUser;
  if (!*output) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmTextFileDestroy(&(*output)->grids));
  PetscCall(MpmTextFileDestroy(&(*output)->lattices));
  PetscCall(PetscFree((*output)->grid_path));
  PetscCall(PetscFree((*output)->h5_path));
  PetscCall(PetscFree((*output)->xdmf_path));
  PetscCall(PetscFree(*output));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Is a dataset of this name there, of one of two numbers of components? */
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

/* Nothing is open yet. */
static Writer NoWriter(MPI_Comm comm)
{
  return (Writer){.comm = comm, .file = H5I_INVALID_HID, .group = H5I_INVALID_HID, .transfer = H5I_INVALID_HID};
}

/* Rows as a group of the file. The writer is the caller's to destroy, whatever happens. */
static PetscErrorCode WriteTable(MpmOutput output, const char *group, PetscInt step, PetscReal time,
                                 const MpmTable *table, Writer *writer)
{
  const PetscInt64   number       = step;
  const MpmAttribute attributes[] = {{"time", &time, NULL}, {"step", NULL, &number}};
  const MpmStateFile state        = {.path            = output->h5_path,
                                     .group           = group,
                                     .append          = output->started,
                                     .collective      = output->collective,
                                     .attribute_count = 2,
                                     .attributes      = attributes,
                                     .single          = output->single,
                                     .tensors         = PETSC_TRUE,
                                     .slab            = output->slab};

  PetscFunctionBeginUser;
  *writer = NoWriter(output->comm);
  PetscCall(WriterSetUp(writer, output->collective, table->count, table->id, table->dataset_count, table->datasets));
  PetscCall(WriteState(writer, &state, table->dataset_count, table->datasets));
  output->started = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static MpmXdmfTable Indexed(const Writer *writer, const MpmTable *table)
{
  return (MpmXdmfTable){writer->points, table->dataset_count, table->datasets, writer->integer};
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

/*
  The state goes into one of the two indices, on rank 0; then the files are written anew. The points come last: some
  programs read the last collection of a file, and no other.
*/
static PetscErrorCode WriteIndex(MpmOutput output, MpmXdmfState *state, MpmTextFile *index)
{
  PetscMPIInt rank;

  PetscFunctionBeginUser;
  state->file      = FileName(output->h5_path);
  state->real_size = RealSize(output->single);
  PetscCallMPI(MPI_Comm_rank(output->comm, &rank));
  if (rank == 0) PetscCall(MpmXdmfAppend(index, state));
  PetscCall(WriteIndices(output, (PetscBool)(index == &output->lattices)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmStateWrite(MPI_Comm comm, const MpmStateFile *state, PetscInt count, const PetscInt id[],
                             PetscInt dataset_count, const MpmDataset datasets[])
{
  Writer         writer = NoWriter(comm);
  PetscErrorCode failure;

  PetscFunctionBeginUser;
  failure = WriterSetUp(&writer, state->collective, count, id, dataset_count, datasets);
  if (!failure) failure = WriteState(&writer, state, dataset_count, datasets);
  PetscCall(WriterDestroy(&writer));
  PetscCall(failure);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmOutputWrite(MpmOutput output, PetscInt step, PetscReal time, PetscInt count, const PetscInt id[],
                              PetscInt dataset_count, const MpmDataset datasets[])
{
  const MpmTable points = {count, id, dataset_count, datasets};
  Writer         writer;
  char           group[64];
  PetscErrorCode failure;

  PetscFunctionBeginUser;
  PetscCall(CheckDatasets(output->comm, dataset_count, datasets, "position", 2, 3));
  PetscCall(PetscSNPrintf(group, sizeof(group), "/points/%06" PetscInt_FMT, step));
  failure = WriteTable(output, group, step, time, &points, &writer);
  if (!failure) {
    MpmXdmfState state = {.group = group, .time = time, .nodes = Indexed(&writer, &points)};

    failure = WriteIndex(output, &state, &output->grids);
  }
  PetscCall(WriterDestroy(&writer));
  PetscCall(failure);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmOutputWriteGrid(MpmOutput output, PetscInt step, PetscReal time, const MpmTable *nodes,
                                  const MpmTable *cells)
{
  Writer         node_writer, cell_writer = {0};
  char           group[64], cell_group[64];
  PetscErrorCode failure;

  PetscFunctionBeginUser;
  PetscCall(CheckDatasets(output->comm, nodes->dataset_count, nodes->datasets, "position", 2, 3));
  PetscCall(CheckDatasets(output->comm, cells->dataset_count, cells->datasets, "nodes", 4, 8));
  PetscCall(PetscSNPrintf(group, sizeof(group), "/grid/%06" PetscInt_FMT "/nodes", step));
  PetscCall(PetscSNPrintf(cell_group, sizeof(cell_group), "/grid/%06" PetscInt_FMT "/cells", step));
  failure = WriteTable(output, group, step, time, nodes, &node_writer);
  if (!failure) failure = WriteTable(output, cell_group, step, time, cells, &cell_writer);
  if (!failure) {
    MpmXdmfState state = {.group      = group,
                          .cell_group = cell_group,
                          .time       = time,
                          .nodes      = Indexed(&node_writer, nodes),
                          .cells      = Indexed(&cell_writer, cells)};

    failure = WriteIndex(output, &state, &output->lattices);
  }
  PetscCall(WriterDestroy(&node_writer));
  PetscCall(WriterDestroy(&cell_writer));
  PetscCall(failure);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- going on with files that exist ---- */

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
  PetscCallMPI(MPI_Bcast(&grid, 1, MPIU_BOOL, 0, output->comm));
  if (index) PetscCall(MpmTextFileAppend(&output->grids, "%s", index));
  if (grid_index) PetscCall(MpmTextFileAppend(&output->lattices, "%s", grid_index));
  PetscCall(WriteIndices(output, grid));
  PetscFunctionReturn(PETSC_SUCCESS);
}

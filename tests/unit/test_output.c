/*
  Files of a run: points as HDF5 and XDMF, history as CSV, summary as JSON.

  Ids are distributed over the ranks at random, with rank 1 left empty; every value of a row can be computed from its
  id, so that the file alone shows whether each row arrived where it belongs.

  Ranks: 1 2 4
*/
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <check.h>
#include <hdf5.h>
#include "io/io.h"

#define CALL(call)  ck_assert_int_eq((int)(call), 0)
#define PATH_LENGTH 256

static char        directory[PATH_LENGTH];
static PetscMPIInt my_rank, rank_count;
static PetscInt64  collective_bytes = 0; /* 0: all ranks write, whatever the size */
static PetscInt64  slab_bytes       = 1 << 30;
static PetscBool   single_precision = PETSC_FALSE;
static char        message[1024]; /* of the last error that was raised */

/* ------------------------------------------------------------------------------------------------------------
   helpers */

static const char *PathOf(const char *name)
{
  static char path[PATH_LENGTH];
  snprintf(path, sizeof(path), "%.200s/%s", directory, name);
  return path;
}

/* The file's text on every rank; free() it. */
static char *ReadFile(const char *path)
{
  FILE  *file = fopen(path, "r");
  char  *text;
  size_t length;

  ck_assert_msg(file != NULL, "cannot read %s", path);
  fseek(file, 0, SEEK_END);
  length = (size_t)ftell(file);
  rewind(file);
  text = (char *)calloc(length + 1, 1);
  ck_assert_uint_eq(fread(text, 1, length, file), length);
  fclose(file);
  return text;
}

static PetscInt CountOf(const char *text, const char *word)
{
  PetscInt count = 0;
  for (const char *at = strstr(text, word); at; at = strstr(at + 1, word)) count++;
  return count;
}

static PetscErrorCode KeepMessage(MPI_Comm comm, int line, const char *function, const char *file, PetscErrorCode code,
                                  PetscErrorType type, const char *text, void *context)
{
  (void)comm, (void)line, (void)function, (void)file, (void)context;
  if (type == PETSC_ERROR_INITIAL) snprintf(message, sizeof(message), "%s", text);
  return code;
}

/* Whatever happens, a write leaves no file, group, dataset or attribute open. */
static void CheckNothingOpen(void)
{
  ck_assert_int_eq(H5Fget_obj_count((hid_t)H5F_OBJ_ALL, H5F_OBJ_ALL), 0);
}

/* The rank that holds an id: anywhere but on rank 1, if there is another. */
static PetscMPIInt HolderOf(PetscInt id, unsigned salt)
{
  unsigned    hash   = ((unsigned)id + salt) * 2654435761u;
  PetscMPIInt holder = (PetscMPIInt)((hash >> 8) % (unsigned)rank_count);
  return holder == 1 ? 0 : holder;
}

/*
  Every number of the test state follows from what it is and whose. Not inlined: it must round alike wherever it is
  called from.
*/
static __attribute__((noinline)) PetscReal RealOf(PetscInt step, PetscInt id, PetscInt component)
{
  return 1e3 * (PetscReal)step + (PetscReal)id + 0.1 * (PetscReal)component + 1. / 3.;
}

typedef struct {
  PetscInt   count;
  PetscInt  *id, *material;
  PetscReal *position, *stress, *F, *volume;
} State;

/* The state's rows on this rank, in the reverse order of ids. */
static void StateCreate(PetscInt step, PetscInt points, PetscInt dim, State *state)
{
  state->count = 0;
  for (PetscInt id = 0; id < points; ++id) state->count += HolderOf(id, (unsigned)step) == my_rank;
  CALL(PetscMalloc6(state->count, &state->id, state->count, &state->material, (size_t)(dim * state->count),
                    &state->position, (size_t)(6 * state->count), &state->stress, (size_t)(9 * state->count), &state->F,
                    state->count, &state->volume));
  for (PetscInt id = points - 1, row = 0; id >= 0; --id) {
    if (HolderOf(id, (unsigned)step) != my_rank) continue;
    state->id[row]       = id;
    state->material[row] = 7 * id + step;
    state->volume[row]   = RealOf(step, id, 0);
    for (PetscInt c = 0; c < dim; ++c) state->position[dim * row + c] = RealOf(step, id, c);
    for (PetscInt c = 0; c < 6; ++c) state->stress[6 * row + c] = RealOf(step, id, c);
    for (PetscInt c = 0; c < 9; ++c) state->F[9 * row + c] = RealOf(step, id, c);
    row++;
  }
}

static void StateDestroy(State *state)
{
  CALL(PetscFree6(state->id, state->material, state->position, state->stress, state->F, state->volume));
}

/* Volumes are made when they are written. */
static PetscErrorCode FillVolume(const void *ctx, PetscReal values[])
{
  const State *state = (const State *)ctx;

  for (PetscInt row = 0; row < state->count; ++row) values[row] = state->volume[row];
  return PETSC_SUCCESS;
}

#define STATE_DATASETS(state, dim) \
  { \
    {.name = "material", .components = 1, .integer = (state).material}, \
      {.name = "position", .components = dim, .real = (state).position}, \
      {.name = "stress", .components = 6, .real = (state).stress}, {.name = "F", .components = 9, .real = (state).F}, \
      {.name = "volume", .components = 1, .fill = FillVolume, .ctx = &(state)}, \
  }
#define STATE_DATASET_COUNT 5

static PetscErrorCode CreateOutput(const char *prefix, MpmOutput *output)
{
  PetscFunctionBeginUser;
  PetscCall(MpmOutputCreate(PETSC_COMM_WORLD, prefix, output));
  PetscCall(MpmOutputSetCollective(*output, collective_bytes));
  PetscCall(MpmOutputSetSlab(*output, slab_bytes));
  PetscCall(MpmOutputSetSingle(*output, single_precision));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode WriteState(MpmOutput output, PetscInt step, PetscInt points, PetscInt dim)
{
  State          state;
  PetscErrorCode code;

  StateCreate(step, points, dim, &state);
  {
    const MpmDataset datasets[] = STATE_DATASETS(state, dim);
    code = MpmOutputWrite(output, step, 0.1 * (PetscReal)step, state.count, state.id, STATE_DATASET_COUNT, datasets);
  }
  StateDestroy(&state);
  return code;
}

/* --------------------------------------------------------------------------------------------------------- reading
   back */

/* A dataset of a state as doubles, converted by HDF5; also checks its shape. free() it. */
static double *ReadDataset(hid_t group, const char *name, PetscInt points, PetscInt components)
{
  hid_t   dataset = H5Dopen2(group, name, H5P_DEFAULT), space = H5Dget_space(dataset);
  hsize_t extent[2] = {0, 1};
  double *values    = (double *)calloc((size_t)(points * components) + 1, sizeof(double));

  ck_assert_msg(dataset >= 0, "no dataset %s", name);
  ck_assert_int_eq(H5Sget_simple_extent_ndims(space), components > 1 || !strncmp(name, "/rows", 5) ? 2 : 1);
  H5Sget_simple_extent_dims(space, extent, NULL);
  ck_assert_int_eq((PetscInt)extent[0], points);
  ck_assert_int_eq((PetscInt)extent[1], components);
  ck_assert_int_ge(H5Dread(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values), 0);
  H5Sclose(space);
  H5Dclose(dataset);
  return values;
}

/* A real as the file holds it. */
static double Written(PetscReal value)
{
  return single_precision ? (double)(float)value : (double)value;
}

static void CheckReals(hid_t group, const char *name, PetscInt step, PetscInt points, PetscInt components)
{
  double *values = ReadDataset(group, name, points, components);
  for (PetscInt id = 0; id < points; ++id)
    for (PetscInt c = 0; c < components; ++c)
      ck_assert_msg(values[components * id + c] == Written(RealOf(step, id, c)), "%s[%d,%d]", name, (int)id, (int)c);
  free(values);
}

static void CheckIntegers(hid_t group, const char *name, PetscInt factor, PetscInt offset, PetscInt points)
{
  double *values = ReadDataset(group, name, points, 1);
  for (PetscInt id = 0; id < points; ++id)
    ck_assert_msg(values[id] == (double)(factor * id + offset), "%s[%d]", name, (int)id);
  free(values);
}

/* The stress row by row: xx, xy, xz, yx, ... out of xx, yy, zz, xy, yz, xz. */
static void CheckTensors(hid_t file, PetscInt step, PetscInt points)
{
  static const PetscInt column[] = {0, 3, 5, 3, 1, 4, 5, 4, 2};
  char                  name[64];
  double               *values;

  snprintf(name, sizeof(name), "/tensors/points/%06d/stress", (int)step);
  values = ReadDataset(file, name, points, 9);
  for (PetscInt id = 0; id < points; ++id)
    for (PetscInt c = 0; c < 9; ++c)
      ck_assert_msg(values[9 * id + c] == Written(RealOf(step, id, column[c])), "tensor [%d,%d]", (int)id, (int)c);
  free(values);
}

static double ReadNumber(hid_t group, const char *name)
{
  hid_t  attribute = H5Aopen(group, name, H5P_DEFAULT);
  double value     = -1.;

  ck_assert_msg(attribute >= 0, "no attribute %s", name);
  H5Aread(attribute, H5T_NATIVE_DOUBLE, &value);
  H5Aclose(attribute);
  return value;
}

static void CheckState(const char *path, PetscInt step, PetscInt points, PetscInt dim)
{
  char  name[32];
  hid_t file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT), group;

  ck_assert_msg(file >= 0, "cannot open %s", path);
  snprintf(name, sizeof(name), "/points/%06d", (int)step);
  group = H5Gopen2(file, name, H5P_DEFAULT);
  ck_assert_msg(group >= 0, "no group %s", name);
  ck_assert(ReadNumber(group, "time") == (double)(0.1 * (PetscReal)step));
  ck_assert(ReadNumber(group, "step") == (double)step);
  CheckIntegers(group, "id", 1, 0, points);
  CheckIntegers(group, "material", 7, step, points);
  CheckReals(group, "position", step, points, dim);
  CheckReals(group, "stress", step, points, 6);
  CheckReals(group, "F", step, points, 9);
  CheckReals(group, "volume", step, points, 1);
  H5Gclose(group);
  CheckTensors(file, step, points);
  H5Fclose(file);
  MPI_Barrier(PETSC_COMM_WORLD); /* nobody writes while somebody reads */
}

/* ---------------------------------------------------------------------------------------------------------------
   points */

START_TEST(test_rows_follow_their_ids)
{
  const PetscInt sizes[] = {1, 3, 1000, 4099};
  PetscInt       points = sizes[_i], dim = _i % 2 ? 3 : 2;
  char           name[32];
  MpmOutput      output;

  snprintf(name, sizeof(name), "rows%d", _i);
  CALL(CreateOutput(PathOf(name), &output));
  strcat(name, ".h5");
  CALL(WriteState(output, 0, points, dim));
  CheckState(PathOf(name), 0, points, dim);
  CALL(WriteState(output, 50, points, dim));
  CheckState(PathOf(name), 0, points, dim); /* the earlier state is still there */
  CheckState(PathOf(name), 50, points, dim);
  CALL(MpmOutputDestroy(&output));
  ck_assert_ptr_null(output);
}
END_TEST

/* Slabs of a row or a few, the last one shorter, ranks with fewer rows than others. */
START_TEST(test_slabs)
{
  const PetscInt64 whole = slab_bytes;

  for (PetscInt64 bytes = 8; bytes < 1000; bytes = 3 * bytes + 1) {
    MpmOutput output;

    slab_bytes = bytes;
    CALL(CreateOutput(PathOf("slabs"), &output));
    CALL(WriteState(output, 7, 23, 3));
    CheckState(PathOf("slabs.h5"), 7, 23, 3);
    CALL(MpmOutputDestroy(&output));
  }
  slab_bytes = whole;
}
END_TEST

START_TEST(test_single_precision)
{
  MpmOutput output;
  hid_t     file, dataset, type;
  char     *text;

  single_precision = PETSC_TRUE;
  CALL(CreateOutput(PathOf("single"), &output));
  CALL(WriteState(output, 1, 500, 3));
  CALL(MpmOutputDestroy(&output));
  CheckState(PathOf("single.h5"), 1, 500, 3);
  single_precision = PETSC_FALSE;
  file             = H5Fopen(PathOf("single.h5"), H5F_ACC_RDONLY, H5P_DEFAULT);
  dataset          = H5Dopen2(file, "/points/000001/F", H5P_DEFAULT);
  type             = H5Dget_type(dataset);
  ck_assert_uint_eq(H5Tget_size(type), sizeof(float));
  ck_assert_uint_eq(H5Dget_storage_size(dataset), 500 * 9 * sizeof(float));
  H5Tclose(type);
  H5Dclose(dataset);
  /* a tensor in full takes no room */
  dataset = H5Dopen2(file, "/tensors/points/000001/stress", H5P_DEFAULT);
  ck_assert_uint_eq(H5Dget_storage_size(dataset), 0);
  H5Dclose(dataset);
  H5Fclose(file);
  text = ReadFile(PathOf("single.xdmf"));
  ck_assert_int_eq(CountOf(text, "NumberType=\"Float\" Precision=\"4\""), 5);
  free(text);
}
END_TEST

/* A row of cells along x, distributed like points: nodes 2i and 2i + 1 lie below and above each other. */
static PetscErrorCode WriteGrid(MpmOutput output, PetscInt step, PetscInt columns)
{
  PetscInt      *id, *cell_id, *corners, nodes = 0, cells = 0;
  PetscReal     *position;
  PetscErrorCode code;

  CALL(PetscMalloc4((size_t)(2 * columns), &id, (size_t)(4 * columns), &position, (size_t)columns, &cell_id,
                    (size_t)(4 * columns), &corners));
  for (PetscInt i = 0; i < 2 * columns; ++i) {
    if (HolderOf(i, 5) != my_rank) continue;
    id[nodes]               = i;
    position[2 * nodes]     = (PetscReal)(i / 2);
    position[2 * nodes + 1] = (PetscReal)(i % 2);
    nodes++;
  }
  for (PetscInt i = 0; i + 1 < columns; ++i) {
    const PetscInt around[] = {2 * i, 2 * i + 2, 2 * i + 3, 2 * i + 1};

    if (HolderOf(i, 6) != my_rank) continue;
    cell_id[cells] = i;
    for (PetscInt c = 0; c < 4; ++c) corners[4 * cells + c] = around[c];
    cells++;
  }
  {
    const MpmDataset sets[]     = {{.name = "position", .components = 2, .real = position}};
    const MpmDataset cell_set   = {.name = "nodes", .components = 4, .integer = corners};
    const MpmTable   node_table = {nodes, id, 1, sets}, cell_table = {cells, cell_id, 1, &cell_set};

    code = MpmOutputWriteGrid(output, step, 0.1 * (PetscReal)step, &node_table, &cell_table);
  }
  CALL(PetscFree4(id, position, cell_id, corners));
  return code;
}

START_TEST(test_grid)
{
  MpmOutput output;
  hid_t     file;
  double   *values;
  char     *text;

  CALL(CreateOutput(PathOf("lattice"), &output));
  CALL(WriteState(output, 0, 10, 2));
  CALL(WriteGrid(output, 0, 4));
  CALL(WriteState(output, 5, 10, 2));
  CALL(WriteGrid(output, 5, 6));
  CALL(MpmOutputDestroy(&output));
  CheckState(PathOf("lattice.h5"), 5, 10, 2);
  file   = H5Fopen(PathOf("lattice.h5"), H5F_ACC_RDONLY, H5P_DEFAULT);
  values = ReadDataset(file, "/grid/000005/nodes/position", 12, 2);
  for (PetscInt i = 0; i < 12; ++i) ck_assert(values[2 * i] == (double)(i / 2) && values[2 * i + 1] == (double)(i % 2));
  free(values);
  values = ReadDataset(file, "/grid/000005/cells/nodes", 5, 4);
  for (PetscInt i = 0; i < 5; ++i) {
    ck_assert(values[4 * i] == 2. * i && values[4 * i + 1] == 2. * i + 2.);
    ck_assert(values[4 * i + 2] == 2. * i + 3. && values[4 * i + 3] == 2. * i + 1.);
  }
  free(values);
  H5Fclose(file);
  text = ReadFile(PathOf("lattice.xdmf"));
  ck_assert_int_eq(CountOf(text, "CollectionType=\"Temporal\""), 2);
  ck_assert_int_eq(CountOf(text, "<Time Value=\"0.5\"/>"), 2);
  ck_assert_ptr_nonnull(strstr(text, "TopologyType=\"Quadrilateral\" NumberOfElements=\"5\""));
  ck_assert_ptr_nonnull(strstr(text, "Dimensions=\"5 4\">lattice.h5:/grid/000005/cells/nodes<"));
  ck_assert_msg(strstr(text, "Polyvertex") > strstr(text, "Quadrilateral"), "the points must come last");
  free(text);
  text = ReadFile(PathOf("lattice_grid.xdmf"));
  ck_assert_int_eq(CountOf(text, "CollectionType=\"Temporal\""), 1);
  ck_assert_int_eq(CountOf(text, "TopologyType"), 2);
  free(text);
}
END_TEST

START_TEST(test_no_points_at_all)
{
  char     *text;
  MpmOutput output;

  CALL(CreateOutput(PathOf("none"), &output));
  CALL(WriteState(output, 3, 0, 2));
  CheckState(PathOf("none.h5"), 3, 0, 2);
  CALL(WriteState(output, 1234567, 5, 2)); /* steps beyond six digits keep theirs */
  CheckState(PathOf("none.h5"), 1234567, 5, 2);
  CALL(MpmOutputDestroy(&output));
  text = ReadFile(PathOf("none.xdmf"));
  ck_assert_int_eq(CountOf(text, "<Grid Name=\"points\""), 1);
  free(text);
}
END_TEST

START_TEST(test_a_new_run_truncates)
{
  hid_t     file;
  MpmOutput output;

  for (PetscInt run = 0; run < 2; ++run) {
    CALL(CreateOutput(PathOf("again"), &output));
    CALL(WriteState(output, run, 10, 2));
    CALL(MpmOutputDestroy(&output));
  }
  CheckState(PathOf("again.h5"), 1, 10, 2);
  file = H5Fopen(PathOf("again.h5"), H5F_ACC_RDONLY, H5P_DEFAULT);
  ck_assert_int_eq(H5Lexists(file, "/points/000000", H5P_DEFAULT), 0);
  H5Fclose(file);
}
END_TEST

START_TEST(test_index_lists_every_state)
{
  char     *text;
  MpmOutput output;

  CALL(CreateOutput(PathOf("index"), &output));
  for (PetscInt step = 0; step < 3; ++step) CALL(WriteState(output, 10 * step, 20, step ? 3 : 2));
  CALL(MpmOutputDestroy(&output));
  text = ReadFile(PathOf("index.xdmf"));
  ck_assert_int_eq(CountOf(text, "CollectionType=\"Temporal\""), 1);
  ck_assert_int_eq(CountOf(text, "<Grid Name=\"points\""), 3);
  ck_assert_int_eq(CountOf(text, "<Time Value=\"2\"/>"), 1);
  ck_assert_int_eq(CountOf(text, "NumberOfElements=\"20\""), 3);
  ck_assert_int_eq(CountOf(text, "GeometryType=\"XY\""), 1);
  ck_assert_int_eq(CountOf(text, "GeometryType=\"XYZ\""), 2);
  ck_assert_int_eq(CountOf(text, "Dimensions=\"20 9\">index.h5:/tensors/points/000010/stress<"), 1);
  ck_assert_int_eq(CountOf(text, "Dimensions=\"20 1\">index.h5:/rows/20<"), 3);
  ck_assert_int_eq(CountOf(text, "Name=\"stress\" AttributeType=\"Tensor\""), 3);
  ck_assert_int_eq(CountOf(text, "Name=\"F\" AttributeType=\"Tensor\""), 3);
  ck_assert_int_eq(CountOf(text, "Name=\"volume\" AttributeType=\"Scalar\""), 3);
  ck_assert_int_eq(CountOf(text, "<Grid"), CountOf(text, "</Grid>"));
  ck_assert_ptr_nonnull(strstr(text, "</Xdmf>"));
  free(text);
  ck_assert_int_ne(access(PathOf("index.xdmf.tmp"), F_OK), 0);
}
END_TEST

/* Points whose ids begin with `first` and leave every second number out. */
static void WriteSparse(MpmOutput output, PetscInt step, PetscInt first, PetscInt points)
{
  PetscInt  *id, count = 0;
  PetscReal *position;
  MpmDataset dataset = {.name = "position", .components = 2};

  CALL(PetscMalloc2(points, &id, (size_t)(2 * points), &position));
  for (PetscInt k = points - 1; k >= 0; --k) {
    if (HolderOf(k, 0) != my_rank) continue;
    position[2 * count] = position[2 * count + 1] = RealOf(step, k, 0);
    id[count++]                                   = first + 2 * k;
  }
  dataset.real = position;
  CALL(MpmOutputWrite(output, step, 0.1 * (PetscReal)step, count, id, 1, &dataset));
  CALL(PetscFree2(id, position));
}

/* The rows' numbers stand in the file in a column, once for all states of as many points; by reference to ids that are
   these numbers. */
START_TEST(test_index_of_ids_with_holes)
{
  char     *text;
  double   *numbers;
  hid_t     file;
  MpmOutput output;

  CALL(CreateOutput(PathOf("holes"), &output));
  WriteSparse(output, 0, 0, 1); /* a single point, id 0 */
  WriteSparse(output, 1, 0, 30);
  WriteSparse(output, 2, 5, 30);
  WriteSparse(output, 3, 1, 1);
  CALL(MpmOutputDestroy(&output));
  text = ReadFile(PathOf("holes.xdmf"));
  ck_assert_int_eq(CountOf(text, "Dimensions=\"30 1\">holes.h5:/rows/30<"), 2);
  ck_assert_int_eq(CountOf(text, "Dimensions=\"1 1\">holes.h5:/rows/1<"), 2);
  free(text);
  file    = H5Fopen(PathOf("holes.h5"), H5F_ACC_RDONLY, H5P_DEFAULT);
  numbers = ReadDataset(file, "/rows/30", 30, 1);
  for (PetscInt row = 0; row < 30; ++row) ck_assert_msg(numbers[row] == (double)row, "row %d", (int)row);
  free(numbers);
  numbers = ReadDataset(file, "/rows/1", 1, 1);
  ck_assert(numbers[0] == 0.);
  free(numbers);
  H5Fclose(file);
}
END_TEST

START_TEST(test_bad_rows_are_refused)
{
  PetscReal position[4] = {0., 0., 1., 1.};
  PetscInt  id[2]       = {0, 0};
  PetscInt  count       = my_rank == 0 ? 2 : 0;

  const MpmDataset good[] = {{.name = "position", .components = 2, .real = position}};
  const MpmDataset lost[] = {{.name = "stress", .components = 2, .real = position}};
  MpmOutput        output;

  CALL(CreateOutput(PathOf("bad"), &output));
  CALL(PetscPushErrorHandler(KeepMessage, NULL));
  ck_assert_int_eq(MpmOutputWrite(output, 0, 0., count, id, 1, good), PETSC_ERR_ARG_WRONG);
  ck_assert_ptr_nonnull(strstr(message, "same id"));
  id[1] = -1;
  ck_assert_int_eq(MpmOutputWrite(output, 0, 0., count, id, 1, good), PETSC_ERR_ARG_OUTOFRANGE);
  id[1] = 1;
  ck_assert_int_eq(MpmOutputWrite(output, 0, 0., count, id, 1, lost), PETSC_ERR_ARG_WRONG);
  ck_assert_ptr_nonnull(strstr(message, "position"));
  CALL(PetscPopErrorHandler());
  CALL(MpmOutputWrite(output, 0, 0., count, id, 1, good));
  CALL(MpmOutputDestroy(&output));
}
END_TEST

/* ------------------------------------------------------------------------------------------------------ failing
   writes */

/* One line that names the file, on every rank, and HDF5 itself says nothing. */
static void CheckFailure(PetscErrorCode code, const char *path)
{
  ck_assert_int_eq((int)code, PETSC_ERR_FILE_WRITE);
  ck_assert_msg(strstr(message, path) != NULL, "message does not name %s: %s", path, message);
  ck_assert_ptr_null(strchr(message, '\n'));
}

START_TEST(test_unwritable_place)
{
  MpmOutput   output;
  MpmHistory  history;
  MpmSummary  summary = {.status = "completed"};
  const char *names[] = {"step"};

  CALL(PetscPushErrorHandler(KeepMessage, NULL));
  CALL(CreateOutput("/nowhere/run", &output));
  CheckFailure(WriteState(output, 0, 10, 2), "/nowhere/run.h5");
  CALL(MpmOutputDestroy(&output));
  CheckFailure(MpmHistoryCreate(PETSC_COMM_WORLD, "/nowhere/run.csv", 1, names, &history), "/nowhere/run.csv");
  CALL(MpmHistoryDestroy(&history));
  CheckFailure(MpmSummaryWrite(PETSC_COMM_WORLD, "/nowhere/run.json", "0", &summary), "/nowhere/run.json");
  CALL(PetscPopErrorHandler());
}
END_TEST

START_TEST(test_failure_amid_a_write_keeps_earlier_states)
{
  State     state;
  MpmOutput output;

  CALL(CreateOutput(PathOf("amid"), &output));
  CALL(WriteState(output, 0, 10, 2));
  StateCreate(1, 10, 2, &state);
  {
    MpmDataset datasets[] = STATE_DATASETS(state, 2);
    datasets[3].name      = "stress"; /* a second dataset of this name */
    CALL(PetscPushErrorHandler(KeepMessage, NULL));
    CheckFailure(MpmOutputWrite(output, 1, 0.1, state.count, state.id, STATE_DATASET_COUNT, datasets),
                 PathOf("amid.h5"));
    CALL(PetscPopErrorHandler());
  }
  StateDestroy(&state);
  CheckState(PathOf("amid.h5"), 0, 10, 2);
  CALL(WriteState(output, 2, 10, 2));
  CheckState(PathOf("amid.h5"), 2, 10, 2);
  CALL(MpmOutputDestroy(&output));
}
END_TEST

START_TEST(test_full_disk)
{
  const char     *names[]  = {"step"};
  const PetscReal values[] = {1.};
  MpmHistory      history;

  if (access("/dev/full", W_OK)) return;
  CALL(PetscPushErrorHandler(KeepMessage, NULL));
  CheckFailure(MpmHistoryCreate(PETSC_COMM_WORLD, "/dev/full", 1, names, &history), "/dev/full");
  CheckFailure(MpmHistoryAppend(history, values), "/dev/full");
  CALL(MpmHistoryDestroy(&history));
  CALL(PetscPopErrorHandler());
}
END_TEST

/* ------------------------------------------------------------------------------------------------- history and
   summary */

START_TEST(test_history_parses_back)
{
  const char     *names[]   = {"step", "time", "reaction_root_x", "track_tip_uy"};
  const PetscReal rows[][4] = {{1., 0.1, -1.2345678901234567e-30, 1. / 3.},
                               {20000000., 0.30000000000000004, 1e300, -0.}};
  char           *text, *at;
  MpmHistory      history;

  CALL(MpmHistoryCreate(PETSC_COMM_WORLD, PathOf("history.csv"), 4, names, &history));
  for (int row = 0; row < 2; ++row) {
    CALL(MpmHistoryAppend(history, rows[row]));
    text = ReadFile(PathOf("history.csv")); /* flushed: it can be read while the run goes on */
    ck_assert_int_eq(CountOf(text, "\n"), row + 2);
    free(text);
    MPI_Barrier(PETSC_COMM_WORLD);
  }
  CALL(MpmHistoryDestroy(&history));
  text = ReadFile(PathOf("history.csv"));
  ck_assert_int_eq(strncmp(text, "step,time,reaction_root_x,track_tip_uy\n1,", 41), 0);
  ck_assert_ptr_nonnull(strstr(text, "\n20000000,"));
  at = strchr(text, '\n') + 1;
  for (int row = 0; row < 2; ++row)
    for (int column = 0; column < 4; ++column) {
      ck_assert(strtod(at, &at) == (double)rows[row][column]);
      ck_assert_int_eq(*at++, column < 3 ? ',' : '\n');
    }
  ck_assert_int_eq(*at, 0);
  free(text);
}
END_TEST

START_TEST(test_summary_has_its_keys)
{
  const char *keys[]  = {"status",
                         "version",
                         "title",
                         "ranks",
                         "dim",
                         "physics",
                         "shape",
                         "jacobian",
                         "solver",
                         "points",
                         "cells",
                         "steps",
                         "active_dofs_max",
                         "time",
                         "time_total_s",
                         "step_cuts",
                         "setup",
                         "transfer",
                         "residual",
                         "newton_iterations",
                         "memory_max_bytes",
                         "solve",
                         "migrate",
                         "output",
                         "linear_iterations"};
  MpmSummary  summary = {.status            = "completed",
                         .dim               = 3,
                         .scene.title       = "a \"quoted\\ \n title",
                         .scene.physics     = "solid",
                         .scene.shape       = "gimp",
                         .solution.jacobian = "local",
                         .points            = 5000000000,
                         .effort.steps      = 40,
                         .time_total        = 1.5};
  char       *text, key[64];

  summary.time[MPM_TIME_SOLVE] = 1. + my_rank;
  summary.time[MPM_TIME_SETUP] = (PetscReal)INFINITY;
  CALL(MpmSummaryReduce(PETSC_COMM_WORLD, &summary));
  ck_assert(summary.time[MPM_TIME_SOLVE] == (PetscReal)rank_count);
  ck_assert(summary.memory_max > 1e6 * rank_count);
  CALL(MpmSummaryWrite(PETSC_COMM_WORLD, PathOf("summary.json"), "0.1.0", &summary));
  text = ReadFile(PathOf("summary.json"));
  for (size_t i = 0; i < sizeof(keys) / sizeof(keys[0]); ++i) {
    snprintf(key, sizeof(key), "\"%s\": ", keys[i]);
    ck_assert_msg(CountOf(text, key) == (strcmp(keys[i], "jacobian") ? 1 : 2), "key %s", keys[i]); /* and its time */
  }
  ck_assert_ptr_nonnull(strstr(text, "\"title\": \"a \\\"quoted\\\\ \\u000a title\""));
  ck_assert_ptr_nonnull(strstr(text, "\"points\": 5000000000,"));
  ck_assert_ptr_nonnull(strstr(text, "\"solver\": null,"));
  ck_assert_ptr_nonnull(strstr(text, "\"setup\": null,"));
  free(text);
}
END_TEST

/* ----------------------------------------------------------------------------------------------------------------
   main */

static void WriteTogether(void)
{
  collective_bytes = 0;
}

static void WriteAlone(void)
{
  collective_bytes = PETSC_INT_MAX;
}

/* Tests of points, once with all ranks writing and once with rank 0 alone. */
static void AddPoints(Suite *suite, const char *name, void (*choose)(void))
{
  TCase *points = tcase_create(name);

  tcase_add_checked_fixture(points, choose, CheckNothingOpen);
  tcase_add_loop_test(points, test_rows_follow_their_ids, 0, 4);
  tcase_add_test(points, test_slabs);
  tcase_add_test(points, test_single_precision);
  tcase_add_test(points, test_grid);
  tcase_add_test(points, test_no_points_at_all);
  tcase_add_test(points, test_a_new_run_truncates);
  tcase_add_test(points, test_index_lists_every_state);
  tcase_add_test(points, test_index_of_ids_with_holes);
  tcase_add_test(points, test_bad_rows_are_refused);
  tcase_add_test(points, test_unwritable_place);
  tcase_add_test(points, test_failure_amid_a_write_keeps_earlier_states);
  suite_add_tcase(suite, points);
}

static Suite *OutputSuite(void)
{
  Suite *suite = suite_create("output");
  TCase *text  = tcase_create("text");

  AddPoints(suite, "together", WriteTogether);
  AddPoints(suite, "alone", WriteAlone);
  tcase_add_test(text, test_full_disk);
  tcase_add_test(text, test_history_parses_back);
  tcase_add_test(text, test_summary_has_its_keys);
  suite_add_tcase(suite, text);
  return suite;
}

/* One scratch directory for all ranks. */
static PetscErrorCode MakeDirectory(void)
{
  PetscFunctionBeginUser;
  strcpy(directory, "/tmp/talus_output_XXXXXX");
  if (my_rank == 0 && !mkdtemp(directory)) directory[0] = 0;
  PetscCallMPI(MPI_Bcast(directory, sizeof(directory), MPI_CHAR, 0, PETSC_COMM_WORLD));
  PetscCheck(directory[0], PETSC_COMM_WORLD, PETSC_ERR_FILE_WRITE, "cannot make a directory in /tmp");
  PetscFunctionReturn(PETSC_SUCCESS);
}

int main(int argc, char **argv)
{
  SRunner *runner;
  int      failed;

  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  PetscCallMPI(MPI_Comm_rank(PETSC_COMM_WORLD, &my_rank));
  PetscCallMPI(MPI_Comm_size(PETSC_COMM_WORLD, &rank_count));
  PetscCall(MakeDirectory());
  runner = srunner_create(OutputSuite());
  srunner_set_fork_status(runner, CK_NOFORK);
  srunner_run_all(runner, CK_NORMAL);
  failed = srunner_ntests_failed(runner);
  srunner_free(runner);
  PetscCallMPI(MPI_Barrier(PETSC_COMM_WORLD));
  if (my_rank == 0) PetscCall(PetscRMTree(directory));
  PetscCall(PetscFinalize());
  return failed ? EXIT_FAILURE : EXIT_SUCCESS;
}

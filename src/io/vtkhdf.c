/*
  VTKHDF: the states of the points for VTK and ParaView.

  A file of type PolyData with steps: a vertex for each point, and an array for each field, in which the rows of all
  states stand one below the other. The arrays are virtual datasets: HDF5 reads the numbers from the results file, whose
  name is relative to the folder of both. Cells are those of the largest state, of which each state uses the first.

  Format: https://docs.vtk.org/en/latest/vtk_file_formats/vtkhdf_file_format/
*/
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include "files/hdf5_rows.h"
#include "io/io.h"
#include "io/vtkhdf.h"

#define ROOT        "/VTKHDF"
#define POINT_DATA  ROOT "/PointData/"
#define OFFSETS     ROOT "/Steps/PointOffsets"
#define PATH_LENGTH 512 /* of a dataset with its groups */

/* A state in the results file. */
typedef struct {
  long long step, rows, first; /* rows; first: its first row where those of all states are one array */
  double    time;              /* s */
  char      group[MPM_STATE_PATH];
} State;

/* The file under way; a failure sticks. */
typedef struct {
  hid_t      results, file;
  char       name[2 * PETSC_MAX_PATH_LEN]; /* of the results file, for HDF5 */
  PetscInt   count;
  State     *states;
  long long  rows, most;       /* of all states, and of the largest */
  long long *integers, *first; /* room for a number of each state; the first row of each */
  PetscBool  failed;
} View;

static hid_t Checked(View *view, hid_t result)
{
  if (result < 0) view->failed = PETSC_TRUE;
  return result;
}

/* ---- states of the results file ---- */

static PetscBool ReadAttribute(hid_t group, const char *name, hid_t type, void *value)
{
  hid_t     attribute = H5Aopen(group, name, H5P_DEFAULT);
  PetscBool read      = (PetscBool)(attribute >= 0 && H5Aread(attribute, type, value) >= 0);

  if (attribute >= 0) (void)H5Aclose(attribute);
  return read;
}

/* True for a group that is a state. */
static PetscBool ReadState(hid_t points, hsize_t number, State *state)
{
  char       name[64];
  hid_t      group;
  PetscInt64 extent[2];
  PetscBool  read;

  if (H5Lget_name_by_idx(points, ".", H5_INDEX_NAME, H5_ITER_INC, number, name, sizeof(name), H5P_DEFAULT) < 0)
    return PETSC_FALSE;
  group = H5Gopen2(points, name, H5P_DEFAULT);
  if (group < 0) return PETSC_FALSE;
  (void)snprintf(state->group, sizeof(state->group), "/points/%s", name);
  read = (PetscBool)(ReadAttribute(group, "step", H5T_NATIVE_LLONG, &state->step) &&
                     ReadAttribute(group, "time", H5T_NATIVE_DOUBLE, &state->time));
  MpmHdf5Extent(group, "id", extent);
  state->rows = extent[0];
  (void)H5Gclose(group);
  return (PetscBool)(read && state->rows >= 0);
}

static int CompareStates(const void *a, const void *b)
{
  const long long one = ((const State *)a)->step, other = ((const State *)b)->step;

  return one < other ? -1 : one > other;
}

/* All states, by ascending step: the order of their names differs from step 1000000 on. */
static PetscErrorCode FindStates(View *view)
{
  hid_t      points = H5Gopen2(view->results, "/points", H5P_DEFAULT);
  H5G_info_t info   = {.nlinks = 0};

  PetscFunctionBeginUser;
  if (points >= 0) (void)H5Gget_info(points, &info);
  PetscCall(PetscCalloc1(info.nlinks + 1, &view->states));
  PetscCall(PetscCalloc1(info.nlinks + 1, &view->integers));
  PetscCall(PetscCalloc1(info.nlinks + 1, &view->first));
  for (hsize_t k = 0; k < info.nlinks; k++)
    if (ReadState(points, k, &view->states[view->count])) view->count++;
  if (points >= 0) (void)H5Gclose(points);
  qsort(view->states, (size_t)view->count, sizeof(State), CompareStates);
  for (PetscInt k = 0; k < view->count; k++) {
    view->first[k] = view->states[k].first = view->rows;
    view->rows += view->states[k].rows;
    view->most = PetscMax(view->most, view->states[k].rows);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- what is stored ---- */

static void WriteAttribute(View *view, const char *group, const char *name, hid_t type, hsize_t count,
                           const void *values)
{
  hid_t space = count ? H5Screate_simple(1, &count, NULL) : H5Screate(H5S_SCALAR);
  hid_t attribute =
    Checked(view, H5Acreate_by_name(view->file, group, name, type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));

  if (attribute >= 0) {
    (void)Checked(view, H5Awrite(attribute, type, values));
    (void)H5Aclose(attribute);
  }
  (void)H5Sclose(space);
}

/* A dataset, with the groups of its path; it is closed again. */
static void CreateDataset(View *view, const char *path, hid_t type, hid_t space, hid_t creation, const void *values)
{
  hid_t links = H5Pcreate(H5P_LINK_CREATE), dataset;

  (void)H5Pset_create_intermediate_group(links, 1);
  dataset = Checked(view, H5Dcreate2(view->file, path, type, space, links, creation, H5P_DEFAULT));
  if (dataset >= 0 && values) (void)Checked(view, H5Dwrite(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values));
  if (dataset >= 0) (void)H5Dclose(dataset);
  (void)H5Pclose(links);
}

/* Numbers, 0 where there are no values: these take no room. */
static void WriteArray(View *view, const char *path, hid_t type, long long rows, long long columns, const void *values)
{
  const hsize_t extent[2] = {(hsize_t)rows, (hsize_t)columns};
  hid_t         space     = H5Screate_simple(columns > 1 ? 2 : 1, extent, NULL);

  CreateDataset(view, path, type, space, H5P_DEFAULT, rows ? values : NULL);
  (void)H5Sclose(space);
}

static void WriteIntegers(View *view, const char *path, long long rows, long long columns, const long long *values)
{
  WriteArray(view, path, H5T_NATIVE_LLONG, rows, columns, values);
}

static void Link(View *view, const char *from, const char *to)
{
  hid_t links = H5Pcreate(H5P_LINK_CREATE);

  (void)H5Pset_create_intermediate_group(links, 1);
  (void)Checked(view, H5Lcreate_hard(view->file, from, view->file, to, links, H5P_DEFAULT));
  (void)H5Pclose(links);
}

/* A part of each state, and where its numbers begin. */
static PetscErrorCode WriteSteps(View *view)
{
  double *times;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(view->count, &times));
  for (PetscInt k = 0; k < view->count; k++) times[k] = view->states[k].time;
  WriteArray(view, ROOT "/Steps/Values", H5T_NATIVE_DOUBLE, view->count, 1, times);
  PetscCall(PetscFree(times));
  for (PetscInt k = 0; k < view->count; k++) view->integers[k] = k;
  WriteIntegers(view, ROOT "/Steps/PartOffsets", view->count, 1, view->integers);
  for (PetscInt k = 0; k < view->count; k++) view->integers[k] = 1;
  WriteIntegers(view, ROOT "/Steps/NumberOfParts", view->count, 1, view->integers);
  WriteIntegers(view, OFFSETS, view->count, 1, view->first);
  WriteIntegers(view, ROOT "/Steps/CellOffsets", view->count, 4, NULL);
  WriteIntegers(view, ROOT "/Steps/ConnectivityIdOffsets", view->count, 4, NULL);
  for (PetscInt k = 0; k < view->count; k++) view->integers[k] = view->states[k].rows;
  WriteIntegers(view, ROOT "/NumberOfPoints", view->count, 1, view->integers);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The corner of vertex i is point i: the corners are the offsets 0, 1, ... without the last. */
static PetscErrorCode WriteVertices(View *view)
{
  const hsize_t corners = (hsize_t)view->most, offsets = corners + 1, begin = 0;
  hid_t         from = H5Screate_simple(1, &offsets, NULL), to = H5Screate_simple(1, &corners, NULL);
  hid_t         creation = H5Pcreate(H5P_DATASET_CREATE);
  long long    *numbers;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(view->most + 1, &numbers));
  for (long long i = 0; i <= view->most; i++) numbers[i] = i;
  WriteIntegers(view, ROOT "/Vertices/Offsets", view->most + 1, 1, numbers);
  PetscCall(PetscFree(numbers));
  (void)H5Sselect_hyperslab(from, H5S_SELECT_SET, &begin, NULL, &corners, NULL);
  (void)Checked(view, H5Pset_virtual(creation, to, ".", ROOT "/Vertices/Offsets", from));
  CreateDataset(view, ROOT "/Vertices/Connectivity", H5T_NATIVE_LLONG, to, creation, NULL);
  Link(view, ROOT "/NumberOfPoints", ROOT "/Vertices/NumberOfCells");
  Link(view, ROOT "/NumberOfPoints", ROOT "/Vertices/NumberOfConnectivityIds");
  (void)H5Pclose(creation);
  (void)H5Sclose(to);
  (void)H5Sclose(from);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The format wants all kinds of cells. */
static void WriteNoCells(View *view, const char *kind)
{
  static const char *const names[] = {"NumberOfCells", "NumberOfConnectivityIds", "Offsets", "Connectivity"};
  const PetscInt           rows[]  = {view->count, view->count, 1, 0};
  char                     path[PATH_LENGTH];

  for (int k = 0; k < 4; k++) {
    (void)snprintf(path, sizeof(path), ROOT "/%s/%s", kind, names[k]);
    WriteIntegers(view, path, rows[k], 1, NULL);
  }
}

/* ---- what refers to the results file ---- */

/* The rows of one state, in the first columns of the virtual dataset; none where the state is without the field. */
static void MapState(View *view, const State *state, const char *field, hsize_t columns, hid_t to, hid_t creation)
{
  const hsize_t begin[2] = {(hsize_t)state->first, 0}, extent[2] = {(hsize_t)state->rows, columns};
  char          source[PATH_LENGTH];
  PetscInt64    found[2];
  hid_t         from;

  (void)snprintf(source, sizeof(source), "%s/%s", state->group, field);
  MpmHdf5Extent(view->results, source, found);
  if (!state->rows || found[0] != state->rows || found[1] != (PetscInt64)columns) return;
  from = H5Screate_simple(columns > 1 ? 2 : 1, extent, NULL);
  (void)H5Sselect_hyperslab(to, H5S_SELECT_SET, begin, NULL, extent, NULL);
  (void)Checked(view, H5Pset_virtual(creation, to, view->name, source, from));
  (void)H5Sclose(from);
}

/* The field of all states, from the first one that has it; two components get a third, 0. */
static void WriteField(View *view, PetscInt first, const char *field, const char *path)
{
  char       source[PATH_LENGTH];
  PetscInt64 found[2];
  hsize_t    extent[2] = {(hsize_t)view->rows, 1};
  hid_t      dataset, type, space, creation = H5Pcreate(H5P_DATASET_CREATE);

  (void)snprintf(source, sizeof(source), "%s/%s", view->states[first].group, field);
  MpmHdf5Extent(view->results, source, found);
  extent[1] = found[1] == 2 ? 3 : (hsize_t)found[1];
  dataset   = Checked(view, H5Dopen2(view->results, source, H5P_DEFAULT));
  type      = Checked(view, H5Dget_type(dataset));
  space     = H5Screate_simple(extent[1] > 1 ? 2 : 1, extent, NULL);
  for (PetscInt k = first; k < view->count && !view->failed; k++)
    MapState(view, &view->states[k], field, (hsize_t)found[1], space, creation);
  (void)H5Sselect_all(space);
  CreateDataset(view, path, type, space, creation, NULL);
  (void)H5Sclose(space);
  (void)H5Tclose(type);
  (void)H5Dclose(dataset);
  (void)H5Pclose(creation);
}

/* The fields of a state that no earlier one has. */
static void WriteFields(View *view, PetscInt k)
{
  hid_t      group = Checked(view, H5Gopen2(view->results, view->states[k].group, H5P_DEFAULT));
  H5G_info_t info  = {.nlinks = 0};

  (void)Checked(view, H5Gget_info(group, &info));
  for (hsize_t i = 0; i < info.nlinks && view->states[k].rows && !view->failed; i++) {
    char       field[PATH_LENGTH / 2], path[PATH_LENGTH], offsets[PATH_LENGTH];
    PetscBool  geometry;
    PetscInt64 extent[2];

    (void)Checked(
      view, (hid_t)H5Lget_name_by_idx(group, ".", H5_INDEX_NAME, H5_ITER_INC, i, field, sizeof(field), H5P_DEFAULT));
    geometry = (PetscBool)!strcmp(field, "position");
    (void)snprintf(path, sizeof(path), "%s%s", geometry ? ROOT "/" : POINT_DATA, geometry ? "Points" : field);
    (void)snprintf(offsets, sizeof(offsets), ROOT "/Steps/PointDataOffsets/%s", field);
    if (H5Oexists_by_name(view->file, path, H5P_DEFAULT) > 0) continue;
    MpmHdf5Extent(group, field, extent);
    if (extent[0] != view->states[k].rows) continue;
    WriteField(view, k, field, path);
    if (!geometry) Link(view, OFFSETS, offsets);
  }
  (void)H5Gclose(group);
}

/* ---- the file ---- */

/* The file of the states that have been found. */
static PetscErrorCode WriteFile(View *view, const char *path)
{
  static const long long version[] = {2, 0};
  const long long        count     = view->count;
  hid_t                  access = MpmHdf5Access(), type = H5Tcopy(H5T_C_S1);

  PetscFunctionBeginUser;
  (void)H5Pset_libver_bounds(access, H5F_LIBVER_V18, H5F_LIBVER_LATEST); /* half of the headers */
  view->file = Checked(view, H5Fcreate(path, H5F_ACC_TRUNC, H5P_DEFAULT, access));
  (void)H5Pclose(access);
  (void)H5Tset_size(type, strlen("PolyData"));
  (void)H5Tset_strpad(type, H5T_STR_NULLPAD);
  if (!view->failed) {
    PetscCall(WriteSteps(view));
    WriteAttribute(view, ROOT, "Version", H5T_NATIVE_LLONG, 2, version);
    WriteAttribute(view, ROOT, "Type", type, 0, "PolyData");
    WriteAttribute(view, ROOT "/Steps", "NSteps", H5T_NATIVE_LLONG, 0, &count);
    PetscCall(WriteVertices(view));
    WriteNoCells(view, "Lines");
    WriteNoCells(view, "Polygons");
    WriteNoCells(view, "Strips");
    for (PetscInt k = 0; k < view->count; k++) WriteFields(view, k);
    (void)Checked(view, H5Fclose(view->file));
  }
  (void)H5Tclose(type);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Name of the results file beside the view. HDF5 takes % for the start of a pattern, and %% for the sign itself. */
static void NameResults(View *view, const char *path)
{
  const char *slash = strrchr(path, '/');
  char       *to    = view->name;

  for (const char *c = slash ? slash + 1 : path; *c && to < view->name + sizeof(view->name) - 2; c++) {
    if (*c == '%') *to++ = '%';
    *to++ = *c;
  }
}

/* Rank 0: a new file takes the place of the old one when it is whole. Returns 0 or errno. */
static PetscErrorCode WriteAlone(const char *path, const char *h5_path, int *failure)
{
  View view = {.results = MpmHdf5Open(h5_path)};
  char temporary[PETSC_MAX_PATH_LEN];

  PetscFunctionBeginUser;
  errno       = 0;
  view.failed = (PetscBool)(view.results < 0);
  NameResults(&view, h5_path);
  PetscCall(PetscSNPrintf(temporary, sizeof(temporary), "%s.tmp", path));
  if (!view.failed) PetscCall(FindStates(&view));
  if (view.rows) {
    PetscCall(WriteFile(&view, temporary));
    if (!view.failed && rename(temporary, path)) view.failed = PETSC_TRUE;
  } else (void)unlink(path);
  *failure = !view.failed ? 0 : errno ? errno : EIO;
  if (view.failed) (void)unlink(temporary);
  if (view.results >= 0) (void)H5Fclose(view.results);
  PetscCall(PetscFree(view.first));
  PetscCall(PetscFree(view.integers));
  PetscCall(PetscFree(view.states));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmVtkHdfWrite(MPI_Comm comm, const char *path, const char *h5_path)
{
  PetscMPIInt rank;
  int         failure = 0;
  H5E_auto2_t report;
  void       *context;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  (void)H5Eget_auto2(H5E_DEFAULT, &report, &context);
  (void)H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
  if (!rank) PetscCall(WriteAlone(path, h5_path, &failure));
  (void)H5Eset_auto2(H5E_DEFAULT, report, context);
  PetscCall(MpmFileCheck(comm, path, failure));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Seconds for one state of many points: written by the program's own writer, brought to the disk, read back and compared.

    bench_output -bench_prefix /tmp/bench/run [-bench_points 10000000] [-bench_rounds 3] [-bench_single]

  Points as in 3D: 24 reals and 2 integers each, made from their ids, distributed over the ranks in blocks that are not those
  of the file. Lines on the terminal, for a program to read: a key and a number.
*/
#include <fcntl.h>
#include <hdf5.h>
#include <math.h>
#include <unistd.h>
#include "base/base.h"
#include "io/io.h"

typedef struct {
  PetscInt  count;
  PetscInt *id, *material;
} Points;

typedef struct {
  const Points *points;
  PetscInt      components;
} Field;

/* Component c of a point's value: exact in single precision, too. */
static inline double ValueOf(PetscInt id, PetscInt c)
{
  return (double)(id % 2000000) + 0.125 * (double)c;
}

static PetscErrorCode Fill(const void *ctx, PetscReal values[])
{
  const Field *field = (const Field *)ctx;

  for (PetscInt p = 0; p < field->points->count; p++)
    for (PetscInt c = 0; c < field->components; c++)
      values[p * field->components + c] = ValueOf(field->points->id[p], c);
  return PETSC_SUCCESS;
}

/* Rows that travel: each rank holds every size-th run of 1000 ids. */
static PetscErrorCode PointsCreate(PetscInt total, Points *points)
{
  PetscMPIInt rank, size;
  PetscInt    k = 0;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(PETSC_COMM_WORLD, &rank));
  PetscCallMPI(MPI_Comm_size(PETSC_COMM_WORLD, &size));
  points->count = 0;
  for (PetscInt id = 0; id < total; id++) points->count += (id / 1000) % size == rank;
  PetscCall(PetscMalloc2(points->count, &points->id, points->count, &points->material));
  for (PetscInt id = 0; id < total; id++) {
    if ((id / 1000) % size != rank) continue;
    points->material[k] = id % 7;
    points->id[k++]     = id;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static const struct {
  const char *name;
  PetscInt    components;
} fields[] = {{"position", 3}, {"displacement", 3}, {"stress", 6}, {"volume", 1}, {"mass", 1},
              {"F", 9},        {"plastic", 1}};
#define FIELD_COUNT ((PetscInt)PETSC_STATIC_ARRAY_LENGTH(fields))

static PetscErrorCode WriteState(MpmOutput output, PetscInt step, const Points *points)
{
  Field      sources[PETSC_STATIC_ARRAY_LENGTH(fields)];
  MpmDataset sets[PETSC_STATIC_ARRAY_LENGTH(fields) + 1];

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < FIELD_COUNT; k++) {
    sources[k] = (Field){points, fields[k].components};
    sets[k] =
      (MpmDataset){.name = fields[k].name, .components = fields[k].components, .fill = Fill, .ctx = &sources[k]};
  }
  sets[FIELD_COUNT] = (MpmDataset){.name = "material", .components = 1, .integer = points->material};
  PetscCall(MpmOutputWrite(output, step, 0., points->count, points->id, FIELD_COUNT + 1, sets));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Until the file is on the disk; all ranks wait. */
static PetscErrorCode Sync(const char *path)
{
  int file;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Barrier(PETSC_COMM_WORLD));
  file = open(path, O_RDONLY);
  PetscCheck(file >= 0 && !fsync(file), PETSC_COMM_WORLD, PETSC_ERR_FILE_WRITE, "cannot sync %s", path);
  close(file);
  PetscCallMPI(MPI_Barrier(PETSC_COMM_WORLD));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Rank 0 reads rows piece by piece and counts those numbers that are not what was written. */
static PetscErrorCode CountWrong(hid_t group, const char *name, PetscInt components, PetscBool integer, PetscInt total,
                                 PetscInt64 *wrong)
{
  const hsize_t piece   = 1000000;
  hid_t         dataset = H5Dopen2(group, name, H5P_DEFAULT), space = H5Dget_space(dataset);
  double       *values;

  PetscFunctionBeginUser;
  PetscCheck(dataset >= 0, PETSC_COMM_SELF, PETSC_ERR_FILE_READ, "no dataset %s", name);
  PetscCall(PetscMalloc1((piece * (hsize_t)components), &values));
  for (hsize_t first = 0; first < (hsize_t)total; first += piece) {
    const hsize_t rows = PetscMin(piece, (hsize_t)total - first), start[2] = {first, 0};
    const hsize_t extent[2] = {rows, (hsize_t)components};
    hid_t         memory    = H5Screate_simple(2, extent, NULL);

    (void)H5Sselect_hyperslab(space, H5S_SELECT_SET, start, NULL, extent, NULL);
    PetscCheck(H5Dread(dataset, H5T_NATIVE_DOUBLE, memory, space, H5P_DEFAULT, values) >= 0, PETSC_COMM_SELF,
               PETSC_ERR_FILE_READ, "cannot read %s", name);
    for (hsize_t i = 0; i < rows; i++) {
      for (PetscInt c = 0; c < components; c++) {
        const PetscInt id = (PetscInt)(first + i);

        *wrong += values[i * (hsize_t)components + (hsize_t)c] != (integer ? (double)(id % 7) : ValueOf(id, c));
      }
    }
    (void)H5Sclose(memory);
  }
  PetscCall(PetscFree(values));
  (void)H5Sclose(space);
  (void)H5Dclose(dataset);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadBack(const char *path, PetscInt total, PetscInt64 *wrong)
{
  hid_t file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT), group = H5Gopen2(file, "/points/000000", H5P_DEFAULT);

  PetscFunctionBeginUser;
  PetscCheck(group >= 0, PETSC_COMM_SELF, PETSC_ERR_FILE_READ, "cannot open %s", path);
  for (PetscInt k = 0; k < FIELD_COUNT; k++)
    PetscCall(CountWrong(group, fields[k].name, fields[k].components, PETSC_FALSE, total, wrong));
  PetscCall(CountWrong(group, "material", 1, PETSC_TRUE, total, wrong));
  (void)H5Gclose(group);
  (void)H5Fclose(file);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Run(void)
{
  PetscInt       total = 10000000, rounds = 3;
  char           prefix[PETSC_MAX_PATH_LEN] = "bench", path[PETSC_MAX_PATH_LEN + 8];
  PetscBool      single                     = PETSC_FALSE;
  PetscMPIInt    rank;
  Points         points;
  PetscInt64     wrong = 0;
  PetscLogDouble since, written, synced, now;

  PetscFunctionBeginUser;
  PetscCall(PetscOptionsGetInt(NULL, NULL, "-bench_points", &total, NULL));
  PetscCall(PetscOptionsGetInt(NULL, NULL, "-bench_rounds", &rounds, NULL));
  PetscCall(PetscOptionsGetString(NULL, NULL, "-bench_prefix", prefix, sizeof(prefix), NULL));
  PetscCall(PetscOptionsHasName(NULL, NULL, "-bench_single", &single));
  PetscCallMPI(MPI_Comm_rank(PETSC_COMM_WORLD, &rank));
  snprintf(path, sizeof(path), "%s.h5", prefix);
  PetscCall(PointsCreate(total, &points));
  for (PetscInt k = 0; k < rounds; k++) {
    MpmOutput output;

    if (!rank) (void)unlink(path);
    PetscCall(MpmOutputCreate(PETSC_COMM_WORLD, prefix, &output));
    PetscCall(MpmOutputSetSingle(output, single));
    PetscCallMPI(MPI_Barrier(PETSC_COMM_WORLD));
    PetscCall(PetscTime(&since));
    PetscCall(WriteState(output, 0, &points));
    PetscCallMPI(MPI_Barrier(PETSC_COMM_WORLD));
    PetscCall(PetscTime(&written));
    PetscCall(Sync(path));
    PetscCall(PetscTime(&synced));
    PetscCall(MpmOutputDestroy(&output));
    PetscCall(PetscPrintf(PETSC_COMM_WORLD, "write_s %.6f\nwrite_and_sync_s %.6f\n", written - since, synced - since));
  }
  PetscCall(PetscTime(&since));
  if (!rank) PetscCall(ReadBack(path, total, &wrong));
  PetscCall(PetscTime(&now));
  PetscCall(PetscPrintf(PETSC_COMM_WORLD, "read_s %.6f\nwrong %lld\n", now - since, (long long)wrong));
  PetscCall(PetscFree2(points.id, points.material));
  PetscFunctionReturn(PETSC_SUCCESS);
}

int main(int argc, char **argv)
{
  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  PetscCall(Run());
  PetscCall(PetscFinalize());
  return 0;
}

/*
  Files of points: HDF5 or CSV, asked for one quantity after the other. Each rank gets its share of the rows.

  HDF5: datasets of one row a point, in the group /points/<step> where the file has a group /points, as this program
  writes them, or at its root. Every rank reads its own rows.
  CSV: a table as of csv_table.h, a row a point. A quantity of several components has a column each: stress_xx, F_xy,
  half_length_x; the position's are x, y and z. Rank 0 reads.
*/
#include <stdio.h>
#include <string.h>
#include <strings.h>
#include "options/options.h"
#include "files/csv_table.h"
#include "files/hdf5_rows.h"
#include "files/point_table.h"

#define MESSAGE_LENGTH MPM_CSV_MESSAGE
#define MATERIAL       "material"

struct _p_MpmPointFile {
  MPI_Comm    comm;
  PetscMPIInt rank, size;
  PetscInt    dim;
  const char *prefix; /* of the block that named the file, and the file's name: borrowed */
  char       *path;
  PetscInt64  total, first; /* rows over all ranks, and this rank's first one */
  PetscInt    count;
  hid_t       file, group; /* HDF5, or negative; it stays silent while the file is open */
  H5E_auto2_t report;
  void       *context;
  PetscBool   run;
  MpmCsvTable csv; /* rank 0 */
  PetscInt    known_count;
  char      **known; /* columns and datasets in use */
};

/* A complaint that rank 0 has, or an empty one: all ranks end with it, or none. */
static PetscErrorCode Share(MpmPointFile file, char message[MESSAGE_LENGTH])
{
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Bcast(message, MESSAGE_LENGTH, MPI_CHAR, 0, file->comm));
  MpmCheckInput(!message[0], "-%sfile %s: %s", file->prefix, file->path, message);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode DealRows(MpmPointFile file)
{
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Bcast(&file->total, 1, MPIU_INT64, 0, file->comm));
  file->first = file->total * file->rank / file->size;
  file->count = (PetscInt)(file->total * (file->rank + 1) / file->size - file->first);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- CSV ---- */

/* In the plane a tensor may come without its components across it: they are 0, and F_zz is 1. */
static PetscBool MayBeAbsent(const char *name)
{
  const char *component = strrchr(name, '_');
  PetscBool   one, other;

  if (!component || strlen(component) != 3) return PETSC_FALSE;
  one   = (PetscBool)(component[1] == 'z');
  other = (PetscBool)(component[2] == 'z');
  return (PetscBool)(one != other || (one && other && !strcmp(name, "F_zz")));
}

/* values = the named columns of this rank's rows; `found` how many of them there are. */
static PetscErrorCode GetColumns(MpmPointFile file, PetscInt components, char *const names[], PetscInt *found,
                                 PetscReal values[])
{
  PetscMPIInt *counts, *starts, mine = (PetscMPIInt)(file->count * components);
  PetscInt    *column;
  PetscReal   *all = NULL;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc3(file->size, &counts, file->size, &starts, components, &column));
  *found = 0;
  for (PetscInt k = 0; k < components; k++) {
    column[k] = MpmCsvTableFind(&file->csv, names[k]);
    *found += column[k] >= 0;
  }
  for (PetscInt k = 0; *found && k < components; k++)
    if (column[k] < 0 && file->dim == 2 && MayBeAbsent(names[k])) ++*found;
  PetscCallMPI(MPI_Bcast(found, 1, MPIU_INT, 0, file->comm));
  if (*found == components) {
    for (PetscMPIInt r = 0; r < file->size; r++) {
      starts[r] = (PetscMPIInt)(file->total * r / file->size * components);
      counts[r] = (PetscMPIInt)(file->total * (r + 1) / file->size * components) - starts[r];
    }
    if (!file->rank) {
      PetscCall(PetscMalloc1((file->total * components), &all));
      for (PetscInt64 i = 0; i < file->total; i++)
        for (PetscInt k = 0; k < components; k++) {
          const PetscReal absent = strcmp(names[k], "F_zz") ? 0. : 1.;

          all[i * components + k] = column[k] < 0 ? absent : file->csv.value[i * file->csv.columns + column[k]];
        }
    }
    PetscCallMPI(MPI_Scatterv(all, counts, starts, MPIU_REAL, values, mine, MPIU_REAL, 0, file->comm));
    PetscCall(PetscFree(all));
  }
  PetscCall(PetscFree3(counts, starts, column));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- HDF5 ---- */

/* The last group of /points by name, which is by step. */
static herr_t KeepLast(hid_t group, const char *name, const H5L_info_t *info, void *context)
{
  char *last = (char *)context;

  (void)group;
  (void)info;
  if (strlen(name) < 64 && strcmp(name, last) > 0) (void)strcpy(last, name);
  return 0;
}

/* The name of the group that holds the points; a complaint where there is none. */
static PetscErrorCode FindGroup(MpmPointFile file, const char *step, char group[128], char message[MESSAGE_LENGTH])
{
  char name[64] = "";

  PetscFunctionBeginUser;
  PetscCall(PetscStrncpy(group, "/", 128));
  if (H5Lexists(file->file, "points", H5P_DEFAULT) <= 0) PetscFunctionReturn(PETSC_SUCCESS);
  if (!strcmp(step, "latest")) {
    hid_t points = H5Gopen2(file->file, "points", H5P_DEFAULT);

    if (points >= 0) {
      (void)H5Literate(points, H5_INDEX_NAME, H5_ITER_NATIVE, NULL, KeepLast, name);
      (void)H5Gclose(points);
    }
  } else PetscCall(PetscSNPrintf(name, sizeof(name), "%06lld", strtoll(step, NULL, 10)));
  PetscCall(PetscSNPrintf(group, 128, "/points/%s", name));
  if (!name[0] || H5Lexists(file->file, group, H5P_DEFAULT) <= 0)
    PetscCall(PetscSNPrintf(message, MESSAGE_LENGTH, "has no step %s in /points", step));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode GetDataset(MpmPointFile file, const char *name, PetscInt components, PetscInt *found,
                                 PetscReal values[])
{
  char       message[MESSAGE_LENGTH] = "";
  PetscInt64 extent[2]               = {0, 0};
  PetscBool  worked;

  PetscFunctionBeginUser;
  if (!file->rank) {
    MpmHdf5Extent(file->group, name, extent);
    if (extent[0] >= 0 && (extent[0] != file->total || extent[1] != components))
      PetscCall(PetscSNPrintf(
        message, sizeof(message), "dataset %s has %lld x %lld numbers, must have %lld x %lld, a row a point", name,
        (long long)extent[0], (long long)extent[1], (long long)file->total, (long long)components));
  }
  PetscCall(Share(file, message));
  PetscCallMPI(MPI_Bcast(extent, 2, MPIU_INT64, 0, file->comm));
  *found = extent[0] >= 0 ? components : 0;
  if (!*found) PetscFunctionReturn(PETSC_SUCCESS);
  worked = MpmHdf5ReadRows(file->group, name, MpmHdf5Real(), file->first, file->count, components, values);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &worked, 1, MPM_MPI_BOOL, MPI_LAND, file->comm));
  MpmCheckInput(worked, "-%sfile %s: dataset %s cannot be read", file->prefix, file->path, name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Opens the file and its group on every rank; rank 0 complains. HDF5 itself is silent. */
static PetscErrorCode OpenHDF5(MpmPointFile file, const char *step)
{
  char       message[MESSAGE_LENGTH] = "", group[128] = "";
  PetscInt64 extent[2] = {0, 0};

  PetscFunctionBeginUser;
  file->file = MpmHdf5Open(file->path);
  if (!file->rank) {
    if (file->file < 0) PetscCall(PetscSNPrintf(message, sizeof(message), "cannot be opened"));
    else PetscCall(FindGroup(file, step, group, message));
  }
  PetscCall(Share(file, message));
  PetscCallMPI(MPI_Bcast(group, (PetscMPIInt)sizeof(group), MPI_CHAR, 0, file->comm));
  PetscCheck(file->file >= 0, PETSC_COMM_SELF, PETSC_ERR_FILE_OPEN, "rank %d cannot open %s", (int)file->rank,
             file->path);
  file->run   = (PetscBool)(strcmp(group, "/") != 0);
  file->group = H5Gopen2(file->file, group, H5P_DEFAULT);
  MpmHdf5Extent(file->group, "position", extent);
  file->total = PetscMax(extent[0], 0);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- either ---- */

PetscErrorCode MpmPointFileOpen(const MpmOptions *block, PetscInt dim, const char *path, const char *step,
                                MpmPointFile *handle)
{
  char         message[MESSAGE_LENGTH] = "";
  int          hdf5                    = 0;
  MpmPointFile file;

  PetscFunctionBeginUser;
  PetscCall(PetscNew(handle));
  file         = *handle;
  file->comm   = block->comm;
  file->prefix = block->prefix;
  file->dim    = dim;
  file->file = file->group = H5I_INVALID_HID;
  PetscCall(PetscStrallocpy(path, &file->path));
  PetscCallMPI(MPI_Comm_rank(file->comm, &file->rank));
  PetscCallMPI(MPI_Comm_size(file->comm, &file->size));
  (void)H5Eget_auto2(H5E_DEFAULT, &file->report, &file->context);
  (void)H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
  if (!file->rank) hdf5 = H5Fis_hdf5(path) > 0;
  PetscCallMPI(MPI_Bcast(&hdf5, 1, MPI_INT, 0, file->comm));
  if (hdf5) PetscCall(OpenHDF5(file, step));
  else if (!file->rank) {
    file->csv.of_words = MATERIAL;
    PetscCall(MpmCsvTableRead(file->path, &file->csv, message));
    file->total = file->csv.rows;
  }
  PetscCall(Share(file, message));
  PetscCall(DealRows(file));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPointFileClose(MpmPointFile *handle)
{
  MpmPointFile file = *handle;

  PetscFunctionBeginUser;
  if (!file) PetscFunctionReturn(PETSC_SUCCESS);
  if (file->group >= 0) (void)H5Gclose(file->group);
  if (file->file >= 0) (void)H5Fclose(file->file);
  (void)H5Eset_auto2(H5E_DEFAULT, file->report, file->context);
  PetscCall(MpmCsvTableDestroy(&file->csv));
  PetscCall(MpmNamesDestroy(file->known_count, &file->known));
  PetscCall(PetscFree(file->path));
  PetscCall(PetscFree(*handle));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscInt MpmPointFileCount(MpmPointFile file)
{
  return file->count;
}

/* The name of a column. */
static PetscErrorCode ColumnName(const char *quantity, PetscInt components, PetscInt k, char name[256])
{
  static const char *const axes[] = {"x", "y", "z"}, *const sym[] = {"xx", "yy", "zz", "xy", "yz", "xz"};
  const char row = "xyz"[k / 3], column = "xyz"[k % 3];

  PetscFunctionBeginUser;
  if (!strcmp(quantity, "position")) PetscCall(PetscStrncpy(name, axes[k], 256));
  else if (components == 1) PetscCall(PetscStrncpy(name, quantity, 256));
  else if (components == 6) PetscCall(PetscSNPrintf(name, 256, "%s_%s", quantity, sym[k]));
  else if (components == 9) PetscCall(PetscSNPrintf(name, 256, "%s_%c%c", quantity, row, column));
  else PetscCall(PetscSNPrintf(name, 256, "%s_%s", quantity, axes[k]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Every number must be one. */
static PetscErrorCode CheckFinite(MpmPointFile file, const char *quantity, PetscInt components,
                                  const PetscReal values[])
{
  PetscInt64 bad = PETSC_MAX_INT;

  PetscFunctionBeginUser;
  for (PetscInt k = file->count * components - 1; k >= 0; k--)
    if (PetscIsInfOrNanReal(values[k])) bad = file->first + k / components;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &bad, 1, MPIU_INT64, MPI_MIN, file->comm));
  MpmCheckInput(bad == PETSC_MAX_INT, "-%sfile %s: %s of point %lld is not a finite number", file->prefix, file->path,
                quantity, (long long)bad);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Know(MpmPointFile file, const char *name)
{
  PetscFunctionBeginUser;
  PetscCall(PetscRealloc(sizeof(*file->known) * (size_t)(file->known_count + 1), &file->known));
  PetscCall(PetscStrallocpy(name, &file->known[file->known_count++]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPointFileGet(MpmPointFile file, const char *quantity, PetscInt components, MpmNeed need,
                               PetscReal **values)
{
  char     there[MESSAGE_LENGTH] = "";
  PetscInt found;
  char   **names;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1((file->count * components + 1), values));
  PetscCall(PetscMalloc1(components, &names));
  for (PetscInt k = 0; k < components; k++) {
    char name[256];

    PetscCall(ColumnName(quantity, components, k, name));
    PetscCall(PetscStrallocpy(name, &names[k]));
    if (file->group < 0) PetscCall(Know(file, name));
  }
  if (file->group >= 0) PetscCall(Know(file, quantity));
  if (file->group >= 0) PetscCall(GetDataset(file, quantity, components, &found, *values));
  else {
    PetscCall(GetColumns(file, components, names, &found, *values));
    MpmCheckInput(!found || found == components, "-%sfile %s: %s needs the columns %s to %s, %d of the %d are there",
                  file->prefix, file->path, quantity, names[0], names[components - 1], (int)found, (int)components);
  }
  if (!found && need == MPM_REQUIRED) {
    PetscCall(MpmCsvTableNames(&file->csv, there));
    PetscCallMPI(MPI_Bcast(there, MESSAGE_LENGTH, MPI_CHAR, 0, file->comm));
  }
  MpmCheckInput(found || need == MPM_OPTIONAL, "-%sfile %s: there is no %s%s", file->prefix, file->path,
                file->group >= 0 ? quantity : names[0], there);
  for (PetscInt k = 0; k < components; k++) PetscCall(PetscFree(names[k]));
  PetscCall(PetscFree(names));
  if (found) PetscCall(CheckFinite(file, quantity, components, *values));
  else PetscCall(PetscFree(*values));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPointFileGetMaterial(MpmPointFile file, PetscInt *count, char ***word, PetscReal **values)
{
  PetscFunctionBeginUser;
  PetscCall(MpmPointFileGet(file, MATERIAL, 1, MPM_OPTIONAL, values));
  PetscCall(MpmCsvTableShareWords(file->comm, &file->csv));
  *count = file->csv.word_count;
  *word  = file->csv.word;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscBool MpmPointFileIsRun(MpmPointFile file)
{
  return file->run;
}

/* ---- unused columns and datasets ---- */

static PetscErrorCode CheckName(MpmPointFile file, const char *name, char message[MESSAGE_LENGTH])
{
  static const char *const aside[] = {"id", "material", "displacement", "position0"};
  const char              *nearest = MpmTextNearest(name, file->known_count, file->known, PETSC_INT_MAX);

  PetscFunctionBeginUser;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(aside); k++) {
    const size_t length = strlen(aside[k]);
    const char  *axis   = &name[length];

    if (strncasecmp(name, aside[k], length)) continue;
    if (!*axis || (axis[0] == '_' && axis[1] && strchr("xyzXYZ", axis[1]) && !axis[2]))
      PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (nearest && !strcasecmp(nearest, name)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscSNPrintf(message, MESSAGE_LENGTH, "%s %.60s is unknown%s%s", file->group < 0 ? "column" : "dataset",
                          name, nearest ? ": the nearest that is known is " : "", nearest ? nearest : ""));
  PetscFunctionReturn(PETSC_SUCCESS);
}

typedef struct {
  MpmPointFile file;
  char        *message;
} Look;

static herr_t CheckDataset(hid_t group, const char *name, const H5L_info_t *info, void *context)
{
  const Look *look = (const Look *)context;

  (void)group;
  (void)info;
  if (!look->message[0]) (void)CheckName(look->file, name, look->message);
  return 0;
}

PetscErrorCode MpmPointFileCheck(MpmPointFile file)
{
  char message[MESSAGE_LENGTH] = "";
  Look look                    = {file, message};

  PetscFunctionBeginUser;
  for (PetscInt c = 0; c < file->csv.columns && !message[0]; c++)
    PetscCall(CheckName(file, file->csv.name[c], message));
  if (!file->rank && file->group >= 0 && !file->run)
    (void)H5Literate(file->group, H5_INDEX_NAME, H5_ITER_NATIVE, NULL, CheckDataset, &look);
  PetscCall(Share(file, message));
  PetscFunctionReturn(PETSC_SUCCESS);
}

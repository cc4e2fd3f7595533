/*
  Files of labels of voxels, whole numbers, x fastest, then y, then z.

    .mhd   MetaImage: a header of lines "key = value", DimSize, ElementType, ElementDataFile and, where it differs, byte
           order and HeaderSize; the numbers in a file of their own
    .raw   such numbers, with the header beside it under the same name with .mhd
    .csv   columns i, j (, k) from 0 on, and label; each voxel once
    other  HDF5, dataset `labels` of as many dimensions, z slowest
*/
#include <ctype.h>
#include <string.h>
#include "files/csv_table.h"
#include "files/hdf5_rows.h"
#include "voxels/voxels.h"

#define FAULT(...) PetscFunctionReturn(PetscSNPrintf(message, 512, __VA_ARGS__))

static PetscBool EndsWith(const char text[], const char tail[])
{
  const size_t length = strlen(text), end = strlen(tail);

  return (PetscBool)(length >= end && !strcmp(text + length - end, tail));
}

/* Numbers of a lattice of this size, or 0 where it has none or too many. */
static PetscInt CountOf(PetscInt dim, const PetscInt size[])
{
  PetscInt64 count = 1;

  for (PetscInt a = 0; a < dim; a++) {
    if (size[a] < 1) return 0;
    count *= size[a];
    if (count > 2000000000) return 0;
  }
  return (PetscInt)count;
}

/* ---- MetaImage ---- */

/* Value of a key of the header, in place, or NULL. */
static char *HeaderValue(char text[], const char key[])
{
  for (char *line = text; line; line = strchr(line, '\n') ? strchr(line, '\n') + 1 : NULL) {
    const size_t length = strlen(key);
    char        *at     = line + length;

    if (strncmp(line, key, length)) continue;
    while (*at == ' ' || *at == '\t') at++;
    if (*at++ != '=') continue;
    while (*at == ' ' || *at == '\t') at++;
    return at;
  }
  return NULL;
}

static PetscBool HeaderSays(char text[], const char key[], const char word[])
{
  const char *value = HeaderValue(text, key);

  return (PetscBool)(value && !strncmp(value, word, strlen(word)));
}

/* Bytes of a number and whether it is signed; 0: another type. */
static size_t NumberBytes(char text[], PetscBool *has_sign)
{
  static const struct {
    const char *name;
    size_t      bytes;
    PetscBool   has_sign;
  } types[] = {{"MET_UCHAR", 1, PETSC_FALSE}, {"MET_CHAR", 1, PETSC_TRUE},  {"MET_USHORT", 2, PETSC_FALSE},
               {"MET_SHORT", 2, PETSC_TRUE},  {"MET_UINT", 4, PETSC_FALSE}, {"MET_INT", 4, PETSC_TRUE}};

  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(types); k++) {
    if (!HeaderSays(text, "ElementType", types[k].name)) continue;
    *has_sign = types[k].has_sign;
    return types[k].bytes;
  }
  return 0;
}

/* A whole number of so many bytes; `msb`: the highest comes first. */
static int NumberOf(const unsigned char bytes[], size_t count, PetscBool has_sign, PetscBool msb)
{
  unsigned value = 0;

  for (size_t k = 0; k < count; k++) value |= (unsigned)bytes[k] << 8 * (msb ? count - 1 - k : k);
  if (has_sign && count < 4 && value >> (8 * count - 1) & 1) return (int)value - (int)(1u << 8 * count);
  return (int)value;
}

/* The numbers behind `skip` bytes of a file that must end with them; -1: right before its end. */
static PetscErrorCode ReadNumbers(const char path[], char header[], long skip, PetscInt count, int label[],
                                  char message[512])
{
  const PetscBool msb =
    (PetscBool)(HeaderSays(header, "ElementByteOrderMSB", "T") || HeaderSays(header, "BinaryDataByteOrderMSB", "T"));
  PetscBool      has_sign = PETSC_FALSE;
  const size_t   bytes = NumberBytes(header, &has_sign), wanted = bytes * (size_t)count;
  FILE          *file = fopen(path, "rb");
  unsigned char *data;
  long           length;

  PetscFunctionBegin;
  if (!file) FAULT("its numbers, %s, cannot be opened", path);
  (void)fseek(file, 0, SEEK_END);
  length = ftell(file);
  if (skip < 0) skip = length - (long)wanted;
  if (skip < 0 || length - skip != (long)wanted) {
    (void)fclose(file);
    FAULT("%s has %ld bytes, and %lld voxels of %d bytes are %lld", path, length - PetscMax(skip, 0), (long long)count,
          (int)bytes, (long long)wanted);
  }
  PetscCall(PetscMalloc1(wanted, &data));
  (void)fseek(file, skip, SEEK_SET);
  if (fread(data, 1, wanted, file) != wanted) (void)snprintf(message, 512, "%.400s cannot be read", path);
  (void)fclose(file);
  for (PetscInt k = 0; k < count; k++) label[k] = NumberOf(&data[(size_t)k * bytes], bytes, has_sign, msb);
  PetscCall(PetscFree(data));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* `text`: the header. */
static PetscErrorCode ReadMetaText(const char path[], char text[], PetscInt dim, PetscInt size[], PetscInt *count,
                                   int **label, char message[512])
{
  char       *value = HeaderValue(text, "DimSize"), *end, numbers[PETSC_MAX_PATH_LEN];
  const char *slash = strrchr(path, '/'), *skip = HeaderValue(text, "HeaderSize");
  PetscBool   has_sign = PETSC_FALSE;
  PetscInt    found    = 0;

  PetscFunctionBegin;
  for (long k; value && (k = strtol(value, &end, 10), end > value); value = end, found++)
    if (found < dim && k > 0 && k < PETSC_INT_MAX) size[found] = (PetscInt)k;
  *count = found == dim ? CountOf(dim, size) : 0;
  if (!*count) FAULT("its header has no DimSize of %d numbers", (int)dim);
  if (!NumberBytes(text, &has_sign))
    FAULT("its header has no ElementType of MET_UCHAR, MET_CHAR, MET_USHORT, MET_SHORT, MET_UINT or MET_INT");
  if (HeaderSays(text, "CompressedData", "T")) FAULT("its numbers are compressed, and must not be");
  value = HeaderValue(text, "ElementDataFile");
  if (!value || HeaderSays(text, "ElementDataFile", "LOCAL") || HeaderSays(text, "ElementDataFile", "LIST"))
    FAULT("its header has no ElementDataFile with one other file");
  end = value + strcspn(value, "\r\n");
  while (end > value && isspace((unsigned char)end[-1])) end--;
  (void)snprintf(numbers, sizeof(numbers), "%.*s%.*s", *value == '/' || !slash ? 0 : (int)(slash - path + 1), path,
                 (int)(end - value), value);
  PetscCall(PetscMalloc1(*count, label));
  PetscCall(ReadNumbers(numbers, text, skip ? strtol(skip, NULL, 10) : 0, *count, *label, message));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadMeta(const char path[], PetscInt dim, PetscInt size[], PetscInt *count, int **label,
                               char message[512])
{
  char  header[PETSC_MAX_PATH_LEN], *text = NULL;
  char *end;

  PetscFunctionBegin;
  PetscCall(PetscStrncpy(header, path, sizeof(header)));
  end = strrchr(header, '.');
  if (end) (void)memcpy(end, ".mhd", 4);
  PetscCall(MpmTextRead(header, &text, message));
  if (message[0]) {
    PetscCall(PetscFree(text));
    FAULT("its header, %s, cannot be read", header);
  }
  PetscCall(ReadMetaText(header, text, dim, size, count, label, message));
  PetscCall(PetscFree(text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- CSV ---- */

static PetscErrorCode TakeTable(const MpmCsvTable *table, PetscInt dim, PetscInt size[], PetscInt *count, int **label,
                                char message[512])
{
  static const char *const names[]         = {"i", "j", "k"};
  const PetscInt           column          = MpmCsvTableFind(table, "label");
  PetscInt                 at[MPM_MAX_DIM] = {-1, -1, -1};

  PetscFunctionBegin;
  for (PetscInt a = 0; a < dim; a++) at[a] = MpmCsvTableFind(table, names[a]);
  for (PetscInt a = 0; a < dim; a++)
    if (at[a] < 0 || column < 0) FAULT("must have the columns i, j%s and label", dim == MPM_MAX_DIM ? ", k" : "");
  for (PetscInt64 r = 0; r < table->rows; r++) {
    for (PetscInt a = 0; a < dim; a++) {
      const PetscReal k = table->value[r * table->columns + at[a]];

      if (!(k >= 0. && k < 1e9) || k != PetscFloorReal(k))
        FAULT("row %lld: %s must be a whole number from 0 on", (long long)r + 1, names[a]);
      size[a] = PetscMax(size[a], (PetscInt)k + 1);
    }
  }
  *count = CountOf(dim, size);
  if (!*count || *count != table->rows)
    FAULT("has %lld rows, and its largest places make %lld voxels: each must be there once", (long long)table->rows,
          (long long)*count);
  PetscCall(PetscMalloc1(*count, label));
  for (PetscInt k = 0; k < *count; k++) (*label)[k] = INT_MIN;
  for (PetscInt64 r = 0; r < table->rows; r++) {
    const PetscReal *row   = &table->value[r * table->columns];
    PetscInt         place = 0;

    for (PetscInt a = dim - 1; a >= 0; a--) place = place * size[a] + (PetscInt)row[at[a]];
    if ((*label)[place] != INT_MIN) FAULT("row %lld: the voxel is there twice", (long long)r + 1);
    if (!(PetscAbsReal(row[column]) <= 1e9) || row[column] != PetscFloorReal(row[column]))
      FAULT("row %lld: label must be a whole number", (long long)r + 1);
    (*label)[place] = (int)row[column];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- HDF5 ---- */

static PetscErrorCode ReadDataset(const char path[], PetscInt dim, PetscInt size[], PetscInt *count, int **label,
                                  char message[512])
{
  const hid_t file = MpmHdf5Open(path);
  hid_t       set = H5I_INVALID_HID, space = H5I_INVALID_HID;
  hsize_t     extent[MPM_MAX_DIM] = {0, 0, 0};

  PetscFunctionBegin;
  if (file >= 0 && H5Lexists(file, "labels", H5P_DEFAULT) > 0) set = H5Dopen2(file, "labels", H5P_DEFAULT);
  if (set >= 0) space = H5Dget_space(set);
  if (space >= 0 && H5Sget_simple_extent_ndims(space) == (int)dim) (void)H5Sget_simple_extent_dims(space, extent, NULL);
  for (PetscInt a = 0; a < dim; a++) size[a] = (PetscInt)PetscMin(extent[dim - 1 - a], (hsize_t)PETSC_INT_MAX);
  *count = CountOf(dim, size);
  if (*count) {
    PetscCall(PetscMalloc1(*count, label));
    if (H5Dread(set, H5T_NATIVE_INT, H5S_ALL, H5S_ALL, H5P_DEFAULT, *label) < 0) *count = 0;
  }
  if (space >= 0) (void)H5Sclose(space);
  if (set >= 0) (void)H5Dclose(set);
  if (file >= 0) (void)H5Fclose(file);
  if (!*count) FAULT("cannot be read as HDF5 with a dataset `labels` of %d dimensions", (int)dim);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmVoxelsReadFile(const char path[], PetscInt dim, PetscInt size[], PetscInt *count, int **label,
                                 char message[512])
{
  PetscFunctionBegin;
  if (EndsWith(path, ".mhd") || EndsWith(path, ".raw")) PetscCall(ReadMeta(path, dim, size, count, label, message));
  else if (EndsWith(path, ".csv")) {
    MpmCsvTable table = {0};

    PetscCall(MpmCsvTableRead(path, &table, message));
    if (!message[0]) PetscCall(TakeTable(&table, dim, size, count, label, message));
    PetscCall(MpmCsvTableDestroy(&table));
  } else PetscCall(ReadDataset(path, dim, size, count, label, message));
  PetscFunctionReturn(PETSC_SUCCESS);
}

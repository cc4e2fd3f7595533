/*
  HDF5 files.
*/
#include "files/hdf5_rows.h"

hid_t MpmHdf5Access(void)
{
  hid_t access = H5Pcreate(H5P_FILE_ACCESS);

  (void)H5Pset_fclose_degree(access, H5F_CLOSE_STRONG);
#if H5_VERSION_GE(1, 10, 7)
  (void)H5Pset_file_locking(access, 0, 1);
#endif
  return access;
}

hid_t MpmHdf5Open(const char *path)
{
  hid_t access = MpmHdf5Access(), file;

  H5E_BEGIN_TRY
  {
    file = H5Fopen(path, H5F_ACC_RDONLY, access);
  }
  H5E_END_TRY;
  (void)H5Pclose(access);
  return file;
}

hid_t MpmHdf5Real(void)
{
  return sizeof(PetscReal) == sizeof(double) ? H5T_NATIVE_DOUBLE : H5T_NATIVE_FLOAT;
}

hid_t MpmHdf5Integer(void)
{
  return sizeof(PetscInt) == sizeof(long long) ? H5T_NATIVE_LLONG : H5T_NATIVE_INT;
}

/* A dataset of a group, negative where there is none of that name. */
static hid_t OpenDataset(hid_t group, const char *name)
{
  hid_t dataset = H5I_INVALID_HID;

  H5E_BEGIN_TRY
  {
    if (H5Lexists(group, name, H5P_DEFAULT) > 0) dataset = H5Dopen2(group, name, H5P_DEFAULT);
  }
  H5E_END_TRY;
  return dataset;
}

void MpmHdf5Extent(hid_t group, const char *name, PetscInt64 extent[2])
{
  const hid_t dataset = OpenDataset(group, name);
  hsize_t     size[2] = {0, 1};
  hid_t       space;
  int         dimensions;

  extent[0] = extent[1] = dataset < 0 ? -1 : 0;
  if (dataset < 0) return;
  space      = H5Dget_space(dataset);
  dimensions = H5Sget_simple_extent_ndims(space);
  if (dimensions == 1 || dimensions == 2) {
    (void)H5Sget_simple_extent_dims(space, size, NULL);
    extent[0] = (PetscInt64)size[0];
    extent[1] = (PetscInt64)size[1];
  }
  (void)H5Sclose(space);
  (void)H5Dclose(dataset);
}

PetscBool MpmHdf5ReadRows(hid_t group, const char *name, hid_t type, PetscInt64 first, PetscInt64 rows,
                          PetscInt columns, void *values)
{
  const hsize_t start[2] = {(hsize_t)first, 0}, extent[2] = {(hsize_t)rows, (hsize_t)columns};
  hid_t         dataset, space, memory;
  herr_t        status;

  if (!rows || !columns) return PETSC_TRUE;
  dataset = OpenDataset(group, name);
  if (dataset < 0) return PETSC_FALSE;
  space  = H5Dget_space(dataset);
  memory = H5Screate_simple(H5Sget_simple_extent_ndims(space), extent, NULL);
  H5E_BEGIN_TRY
  {
    status = H5Sselect_hyperslab(space, H5S_SELECT_SET, start, NULL, extent, NULL);
    if (status >= 0) status = H5Dread(dataset, type, memory, space, H5P_DEFAULT, values);
  }
  H5E_END_TRY;
  (void)H5Sclose(memory);
  (void)H5Sclose(space);
  (void)H5Dclose(dataset);
  return (PetscBool)(status >= 0);
}

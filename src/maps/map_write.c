/*
  Maps into files.
*/
#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>
#include "maps/gdal.h"
#include "maps/map.h"

/* One band of values as rows from north to south, with the mark of no data. */
static void Turn(const MpmMap *like, const PetscReal value[], PetscInt row, double line[])
{
  const PetscReal *from = &value[(PetscInt64)(like->rows - 1 - row) * like->columns];

  for (PetscInt i = 0; i < like->columns; i++) line[i] = PetscIsNanReal(from[i]) ? like->none : from[i];
}

/* Band by band, row by row; PETSC_FALSE where GDAL has failed. */
static PetscBool WriteBands(const MpmGdal *gdal, void *file, const MpmMap *like, const char *const names[],
                            const PetscReal *const values[], double line[])
{
  const int count = gdal->GDALGetRasterCount(file);

  for (int b = 0; b < count; b++) {
    void *band = gdal->GDALGetRasterBand(file, b + 1);

    gdal->GDALSetDescription(band, names[b]);
    if (gdal->GDALSetRasterNoDataValue(band, like->none)) return PETSC_FALSE;
  }
  for (PetscInt j = 0; j < like->rows; j++) { /* rows of all bands lie together in the file */
    for (int b = 0; b < count; b++) {
      Turn(like, values[b], j, line);
      if (gdal->GDALRasterIO(gdal->GDALGetRasterBand(file, b + 1), MPM_GDAL_WRITE, 0, (int)j, (int)like->columns, 1,
                             line, (int)like->columns, 1, MPM_GDAL_FLOAT64, 0, 0))
        return PETSC_FALSE;
    }
  }
  return PETSC_TRUE;
}

/* Returns 0 or a number of errno. */
static int WriteTiff(const MpmGdal *gdal, const char *path, const MpmMap *like, PetscInt count,
                     const char *const names[], const PetscReal *const values[])
{
  char    deflate[] = "COMPRESS=DEFLATE", predictor[] = "PREDICTOR=3", big[] = "BIGTIFF=IF_SAFER";
  char    apart[]      = "INTERLEAVE=BAND"; /* a band is read without the others */
  char   *options[]    = {deflate, predictor, big, apart, NULL};
  double  transform[6] = {like->origin[0] + like->x0 - 0.5 * like->cell[0],
                          like->cell[0],
                          0.,
                          like->origin[1] + like->y0 + ((PetscReal)like->rows - 0.5) * like->cell[1],
                          0.,
                          -like->cell[1]};
  void   *driver       = gdal->GDALGetDriverByName("GTiff"), *file;
  double *line;
  int     failure = 0;

  if (PetscMalloc1(like->columns, &line)) return ENOMEM;
  gdal->CPLPushErrorHandler(gdal->CPLQuietErrorHandler);
  gdal->CPLErrorReset();
  errno = 0;
  file  = driver
            ? gdal->GDALCreate(driver, path, (int)like->columns, (int)like->rows, (int)count, MPM_GDAL_FLOAT64, options)
            : NULL;
  if (!file || gdal->GDALSetGeoTransform(file, transform) ||
      (like->system && gdal->GDALSetProjection(file, like->system)) ||
      !WriteBands(gdal, file, like, names, values, line))
    failure = errno ? errno : EIO;
  if (file) gdal->GDALClose(file);
  if (!failure && gdal->CPLGetLastErrorType() >= MPM_GDAL_FAILURE) failure = errno ? errno : EIO;
  gdal->CPLPopErrorHandler();
  (void)PetscFree(line);
  return failure;
}

/* One band; returns 0 or a number of errno. */
static int WriteAscii(const char *path, const MpmMap *like, const PetscReal value[])
{
  double *line;
  FILE   *file    = fopen(path, "w");
  int     failure = 0;

  if (!file) return errno;
  if (PetscMalloc1(like->columns, &line)) failure = ENOMEM;
  fprintf(file, "ncols %" PetscInt_FMT "\nnrows %" PetscInt_FMT "\nxllcenter %.17g\nyllcenter %.17g\n", like->columns,
          like->rows, (double)(like->origin[0] + like->x0), (double)(like->origin[1] + like->y0));
  if (like->cell[0] == like->cell[1]) fprintf(file, "cellsize %.17g\n", (double)like->cell[0]);
  else fprintf(file, "dx %.17g\ndy %.17g\n", (double)like->cell[0], (double)like->cell[1]);
  fprintf(file, "NODATA_value %.17g\n", (double)like->none);
  for (PetscInt j = 0; j < like->rows && !failure; j++) {
    Turn(like, value, j, line);
    for (PetscInt i = 0; i < like->columns; i++) fprintf(file, "%s%.15g", i ? " " : "", line[i]);
    if (fprintf(file, "\n") < 0) failure = errno ? errno : EIO;
  }
  if (fclose(file) && !failure) failure = errno ? errno : EIO;
  (void)PetscFree(line);
  return failure;
}

/* A file under another name first. */
static int WriteWhole(const MpmGdal *gdal, const char *path, const MpmMap *like, PetscInt count,
                      const char *const names[], const PetscReal *const values[])
{
  char *temporary = NULL;
  int   failure   = 0;

  if (MpmTextAppend(&temporary, "%s.tmp", path)) return ENOMEM;
  failure = gdal ? WriteTiff(gdal, temporary, like, count, names, values) : WriteAscii(temporary, like, values[0]);
  errno   = 0;
  if (!failure && rename(temporary, path)) failure = errno ? errno : EIO;
  if (failure) (void)unlink(temporary);
  (void)PetscFree(temporary);
  return failure;
}

PetscErrorCode MpmMapWrite(MPI_Comm comm, const char *stem, const MpmMap *like, PetscInt count,
                           const char *const names[], const PetscReal *const values[])
{
  MpmGdal     gdal;
  PetscMPIInt rank;
  int         tiff = 0;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  if (!rank) tiff = MpmGdalOpen(&gdal);
  PetscCallMPI(MPI_Bcast(&tiff, 1, MPI_INT, 0, comm));
  for (PetscInt b = 0; b < (tiff ? 1 : count); b++) {
    char *path    = NULL;
    int   failure = 0;

    PetscCall(tiff ? MpmTextAppend(&path, "%s.tif", stem) : MpmTextAppend(&path, "%s_%s.asc", stem, names[b]));
    if (!rank) failure = WriteWhole(tiff ? &gdal : NULL, path, like, count, &names[b], &values[b]);
    PetscCall(MpmFileCheck(comm, path, failure));
    PetscCall(PetscFree(path));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  States of a run's file: their times, and those after a given one.
*/
#include "files/hdf5_rows.h"
#include "handover/columns.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define STATE_NAME 64

typedef struct {
  long long after; /* -1: none yet */
  PetscInt  count;
  PetscInt *steps; /* NULL: counted alone */
  long long last;
} Walk;

/* A group of /points, by name and thus by step. */
static herr_t Visit(hid_t group, const char *name, const H5L_info_t *info, void *context)
{
  Walk           *walk = (Walk *)context;
  const long long step = strtoll(name, NULL, 10);

  (void)group;
  (void)info;
  walk->last = PetscMax(walk->last, step);
  if (step <= walk->after) return 0;
  if (walk->steps) walk->steps[walk->count] = (PetscInt)step;
  walk->count++;
  return 0;
}

/* The attribute `time` of a state. */
static PetscReal ReadTime(hid_t points, long long step)
{
  char   name[STATE_NAME];
  double time = 0.;

  (void)snprintf(name, sizeof(name), "%06lld", step);
  if (H5Lexists(points, name, H5P_DEFAULT) > 0 && H5Aexists_by_name(points, name, "time", H5P_DEFAULT) > 0) {
    const hid_t attribute = H5Aopen_by_name(points, name, "time", H5P_DEFAULT, H5P_DEFAULT);

    if (attribute >= 0 && H5Aread(attribute, H5T_NATIVE_DOUBLE, &time) < 0) time = 0.;
    if (attribute >= 0) (void)H5Aclose(attribute);
  }
  return (PetscReal)time;
}

/* On rank 0. */
static PetscErrorCode Look(const char *path, const char *step, PetscReal *time, Walk *walk)
{
  hid_t file, points;

  PetscFunctionBeginUser;
  if (H5Fis_hdf5(path) <= 0) PetscFunctionReturn(PETSC_SUCCESS);
  file = MpmHdf5Open(path);
  if (file < 0) PetscFunctionReturn(PETSC_SUCCESS);
  if (H5Lexists(file, "points", H5P_DEFAULT) > 0 && (points = H5Gopen2(file, "points", H5P_DEFAULT)) >= 0) {
    (void)H5Literate(points, H5_INDEX_NAME, H5_ITER_NATIVE, NULL, Visit, walk);
    walk->after = strcmp(step, "latest") ? strtoll(step, NULL, 10) : walk->last;
    *time       = ReadTime(points, walk->after);
    PetscCall(PetscMalloc1((size_t)walk->count + 1, &walk->steps));
    walk->count = 0;
    (void)H5Literate(points, H5_INDEX_NAME, H5_ITER_NATIVE, NULL, Visit, walk);
    (void)H5Gclose(points);
  }
  (void)H5Fclose(file);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmColumnsSteps(MPI_Comm comm, const char *path, const char *step, PetscReal *time, PetscInt *count,
                               PetscInt **steps)
{
  Walk        walk = {.after = -1, .last = -1};
  PetscReal   at   = 0.;
  PetscMPIInt rank;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  if (!rank) PetscCall(Look(path, step, &at, &walk));
  PetscCallMPI(MPI_Bcast(&at, 1, MPIU_REAL, 0, comm));
  PetscCallMPI(MPI_Bcast(&walk.count, 1, MPIU_INT, 0, comm));
  if (rank) PetscCall(PetscMalloc1((size_t)walk.count + 1, &walk.steps));
  if (walk.count) PetscCallMPI(MPI_Bcast(walk.steps, (PetscMPIInt)walk.count, MPIU_INT, 0, comm));
  if (time) *time = at;
  if (count) *count = walk.count;
  if (steps) *steps = walk.steps;
  else PetscCall(PetscFree(walk.steps));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  centre OPTIONS - runs a scene in the plane; its history has further columns: the centre of the initial volume as it
  is now, m, and the longest displacement of a point, m
*/
#include <math.h>
#include "run_scene.h"

static PetscErrorCode FillCentre(MpmModel model, const MpmColumn *column, PetscReal values[])
{
  PetscInt   count, dim;
  PetscReal *x, *volume, sum[3] = {0., 0., 0.};

  PetscFunctionBeginUser;
  PetscCall(MpmModelGetPointCount(model, &count, NULL));
  PetscCall(MpmModelGetPoints(model, "position", &dim, &x));
  PetscCall(MpmModelGetPoints(model, "volume0", NULL, &volume));
  for (PetscInt p = 0; p < count; p++) {
    for (PetscInt a = 0; a < dim; a++) sum[a] += volume[p] * x[p * dim + a];
    sum[dim] += volume[p];
  }
  PetscCall(MpmModelRestorePoints(model, "volume0", NULL, &volume));
  PetscCall(MpmModelRestorePoints(model, "position", NULL, &x));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, 3, MPIU_REAL, MPIU_SUM, PETSC_COMM_WORLD));
  for (PetscInt a = 0; a < column->count; a++) values[a] = sum[a] / sum[column->count];
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode FillLongest(MpmModel model, const MpmColumn *column, PetscReal values[])
{
  PetscInt   count, dim;
  PetscReal *x, *x0;

  (void)column;
  PetscFunctionBeginUser;
  PetscCall(MpmModelGetPointCount(model, &count, NULL));
  PetscCall(MpmModelGetPoints(model, "position", &dim, &x));
  PetscCall(MpmModelGetPoints(model, "position0", NULL, &x0));
  values[0] = 0.;
  for (PetscInt p = 0; p < count; p++)
    values[0] = PetscMax(values[0], hypot(x[p * dim] - x0[p * dim], x[p * dim + 1] - x0[p * dim + 1]));
  PetscCall(MpmModelRestorePoints(model, "position0", NULL, &x0));
  PetscCall(MpmModelRestorePoints(model, "position", NULL, &x));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, values, 1, MPIU_REAL, MPIU_MAX, PETSC_COMM_WORLD));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Add(MpmModel model)
{
  static const char *const parts[] = {"x", "y"};
  const MpmColumn          centre  = {.name = "centre", .unit = "m", .count = 2, .parts = parts, .fill = FillCentre};
  const MpmColumn          longest = {.name = "longest", .unit = "m", .fill = FillLongest};

  PetscFunctionBeginUser;
  PetscCall(MpmModelAddColumn(model, &centre));
  PetscCall(MpmModelAddColumn(model, &longest));
  PetscFunctionReturn(PETSC_SUCCESS);
}

int main(int argc, char **argv)
{
  int status = 0;

  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  PetscCall(RunScene(argc, argv, Add, &status));
  PetscCall(PetscFinalize());
  return status;
}

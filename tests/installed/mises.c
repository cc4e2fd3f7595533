/*
  mises OPTIONS - runs a scene; its results have a further field of the points, von Mises' equivalent stress

    q = sqrt(3/2 s : s) ,     s the deviator of the Cauchy stress
*/
#include <math.h>
#include "run_scene.h"

static PetscErrorCode FillMises(MpmModel model, const MpmPointColumn *column, PetscReal values[])
{
  PetscInt   count, size;
  PetscReal *stress;

  (void)column;
  PetscFunctionBeginUser;
  PetscCall(MpmModelGetPointCount(model, &count, NULL));
  PetscCall(MpmModelGetPoints(model, "stress", &size, &stress));
  for (PetscInt p = 0; p < count; p++) {
    const PetscReal *s = &stress[p * size], mean = (s[0] + s[1] + s[2]) / 3.;
    PetscReal        square = 0.;

    for (PetscInt c = 0; c < size; c++) square += c < 3 ? (s[c] - mean) * (s[c] - mean) : 2. * s[c] * s[c];
    values[p] = sqrt(1.5 * square);
  }
  PetscCall(MpmModelRestorePoints(model, "stress", &size, &stress));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Add(MpmModel model)
{
  const MpmPointColumn mises = {.name = "mises", .unit = "Pa", .components = 1, .fill = FillMises};

  PetscFunctionBeginUser;
  PetscCall(MpmModelAddPointColumn(model, &mises));
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

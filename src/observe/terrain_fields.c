/*
  Fields of columns on a bed in the results.
*/
#include "maps/bed.h"
#include "particles/particles.h"
#include "particles/points.h"
#include "query/model.h"
#include "observe/point_columns.h"

static PetscErrorCode FillBed(MpmModel model, const MpmPointColumn *column, PetscReal values[])
{
  MpmPoints points;

  (void)column;
  PetscFunctionBeginUser;
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  for (PetscInt p = 0; p < points.count; p++)
    values[p] = MpmBedHeight(model->scene.deformation.bed, &points.x[p * model->disc.dim]);
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTerrainAddFields(MpmModel model, MpmPointColumns *columns)
{
  const MpmPointColumn bed = {.name = "bed", .unit = "m", .components = 1, .fill = FillBed};

  PetscFunctionBeginUser;
  if (model->scene.deformation.bed) PetscCall(MpmPointColumnsAdd(columns, &bed));
  PetscFunctionReturn(PETSC_SUCCESS);
}

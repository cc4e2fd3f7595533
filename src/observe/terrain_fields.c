/*
  Fields of columns on a bed in the results.
*/
#include "maps/bed.h"
#include "grid/grid.h"
#include "grid/shape.h"
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

static PetscErrorCode FillSlope(MpmModel model, const MpmPointColumn *column, PetscReal values[])
{
  MpmBedPatch patch;
  MpmPoints   points;

  (void)column;
  PetscFunctionBeginUser;
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  for (PetscInt p = 0; p < points.count; p++) {
    MpmBedPatchAt(model->scene.deformation.bed, &points.x[p * model->disc.dim], &patch);
    for (PetscInt a = 0; a < 2; a++) values[2 * p + a] = patch.slope[a];
  }
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Of the velocity within a point, by its affine field; 0 without one. */
static PetscErrorCode FillGradient(MpmModel model, const MpmPointColumn *column, PetscReal values[])
{
  const PetscInt  degree   = MpmShapeDegree(model->scene.shape.type);
  const PetscBool averaged = MpmShapeHasDomain(model->scene.shape.type);
  MpmPoints       points;

  (void)column;
  PetscFunctionBeginUser;
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  for (PetscInt k = 0; k < 4 * points.count; k++) {
    const PetscReal h = model->disc.grid->h[k % 2];
    const PetscReal l = averaged && points.domain.half_length ? points.domain.half_length[2 * (k / 4) + k % 2] : 0.;
    const PetscReal moment = degree < 2 ? 1. : (PetscReal)(degree + 1) * h * h / 12. + l * l / 3.;

    values[k] = points.motion.affine ? points.motion.affine[k] / moment : 0.;
  }
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTerrainAddFields(MpmModel model, MpmPointColumns *columns)
{
  const MpmPointColumn fields[] = {
    {.name = "bed", .unit = "m", .components = 1, .fill = FillBed},
    {.name = "bed_slope", .unit = "-", .components = 2, .fill = FillSlope},
    {.name = "velocity_gradient", .unit = "1/s", .components = 4, .fill = FillGradient},
  };

  PetscFunctionBeginUser;
  for (size_t k = 0; model->scene.deformation.bed && k < PETSC_STATIC_ARRAY_LENGTH(fields); k++)
    PetscCall(MpmPointColumnsAdd(columns, &fields[k]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

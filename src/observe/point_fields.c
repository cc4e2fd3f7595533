/*
  Fields of the points' kinematics, stress and mass in the results.
*/
#include "point/layout.h"
#include "point/material.h"
#include "point/strain_measure.h"
#include "grid/shape.h"
#include "particles/particles.h"
#include "particles/point_mass.h"
#include "particles/points.h"
#include "volume/inertia.h"
#include "query/model.h"
#include "observe/point_columns.h"

void MpmPointDeformation(PetscInt dim, const MpmPoints *points, PetscInt p, PetscReal F[9])
{
  const PetscReal *from = MpmPointF(points, p);

  for (PetscInt a = 0; a < 3; a++)
    for (PetscInt b = 0; b < 3; b++) F[3 * a + b] = a < dim && b < dim ? from[a * dim + b] : a == b ? 1. : 0.;
  if (points->F_size > dim * dim) F[8] = from[dim * dim];
}

static PetscErrorCode FillDisplacement(MpmModel model, const MpmPointColumn *column, PetscReal values[])
{
  MpmPoints points;

  PetscFunctionBeginUser;
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  for (PetscInt k = 0; k < points.count * column->components; k++) values[k] = points.x[k] - points.x0[k];
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode FillStress(MpmModel model, const MpmPointColumn *column, PetscReal values[])
{
  const PetscInt size = model->state.particles->stress_size;
  MpmPoints      points;

  (void)column;
  PetscFunctionBeginUser;
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  for (PetscInt p = 0; p < points.count; p++) MpmSymToSpace(size, &points.stress[p * size], &values[6 * p]);
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* In saturated ground the volume of the water's balance: of laws of small strain 1 + tr(F - I), the change of which is
   the flow. */
static PetscErrorCode FillVolume(MpmModel model, const MpmPointColumn *column, PetscReal values[])
{
  MpmPoints points;

  (void)column;
  PetscFunctionBeginUser;
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  for (PetscInt p = 0; p < points.count; p++) {
    const PetscReal *F = MpmPointF(&points, p);

    values[p] = points.volume0[p];
    if (model->scene.deformation.bed) continue; /* a column keeps its volume */
    values[p] *=
      (model->disc.layout->own.taken_up < 0 ? MpmPointJ(&points, p)
                                            : MpmPointVolumeRatio(&model->scene.materials->at[points.material[p]], F));
  }
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode FillMass(MpmModel model, const MpmPointColumn *column, PetscReal values[])
{
  MpmPoints points;

  (void)column;
  PetscFunctionBeginUser;
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  for (PetscInt p = 0; p < points.count; p++)
    values[p] = MpmPointMassNow(&points, model->scene.materials->at, model->disc.layout, p);
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode FillF(MpmModel model, const MpmPointColumn *column, PetscReal values[])
{
  MpmPoints points;

  (void)column;
  PetscFunctionBeginUser;
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  for (PetscInt p = 0; p < points.count; p++) MpmPointDeformation(model->disc.dim, &points, p, &values[9 * p]);
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ln V in the plane, V V = F F^T */
static void PlaneLogStrain(const PetscReal F[4], PetscReal strain[6])
{
  const PetscReal xx = F[0] * F[0] + F[1] * F[1], yy = F[2] * F[2] + F[3] * F[3], xy = F[0] * F[2] + F[1] * F[3],
                  J = F[0] * F[3] - F[1] * F[2], mean = 0.5 * (xx + yy), half = 0.5 * (xx - yy);
  const PetscReal radius = PetscSqrtReal(half * half + xy * xy), large = PetscLogReal(mean + radius);
  const PetscReal volume = PetscLogReal(J),
                  shear  = 0.5 * large - 0.5 * volume; /* half of the principal strains' difference */
  const PetscReal by     = radius > PETSC_SQRT_MACHINE_EPSILON * mean ? shear / radius : 0.5 / mean;

  for (PetscInt k = 0; k < 6; k++) strain[k] = 0.;
  strain[0] = 0.5 * volume + by * half;
  strain[1] = 0.5 * volume - by * half;
  strain[3] = by * xy;
}

/* The total strain: ln V, or of laws of small strain sym(F) - I. */
static PetscErrorCode FillStrain(MpmModel model, const MpmPointColumn *column, PetscReal values[])
{
  const PetscInt dim = model->disc.dim;
  MpmPoints      points;

  (void)column;
  PetscFunctionBeginUser;
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  for (PetscInt p = 0; p < points.count; p++) {
    const unsigned traits = model->scene.materials->at[points.material[p]].info.traits;
    PetscReal      F[9];

    if (model->scene.deformation.kinematics != MPM_SPATIAL && !(traits & MPM_LAW_SMALL_STRAIN)) {
      PlaneLogStrain(MpmPointF(&points, p), &values[6 * p]);
      if (points.F_size == 5) values[6 * p + 2] = PetscLogReal(MpmPointF(&points, p)[4]);
      continue;
    }
    MpmPointDeformation(dim, &points, p, F);
    PetscCall(MpmStrainFromDeformation(traits & MPM_LAW_SMALL_STRAIN ? MPM_STRAIN_ENGINEERING : MPM_STRAIN_LOG, F,
                                       &values[6 * p]));
  }
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPointsAddColumns(MpmModel model, MpmPointColumns *columns)
{
  const PetscInt       dim         = model->disc.dim;
  const MpmPointColumn always[]    = {{.name = "material", .unit = "-", .components = 1},
                                      {"displacement", "m", dim, FillDisplacement, NULL, 0},
                                      {"stress", "Pa", 6, FillStress, NULL, 0},
                                      {"strain", "-", 6, FillStrain, NULL, 0},
                                      {"volume", "m3", 1, FillVolume, NULL, 0},
                                      {"mass", "kg", 1, FillMass, NULL, 0},
                                      {"F", "-", 9, FillF, NULL, 0}};
  const MpmPointColumn half_length = {.name = "half_length", .unit = "m", .components = dim};
  const MpmPointColumn velocity    = {.name = "velocity", .unit = "m/s", .components = dim};

  PetscFunctionBeginUser;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(always); k++) PetscCall(MpmPointColumnsAdd(columns, &always[k]));
  if (MpmShapeHasDomain(model->scene.shape.type)) PetscCall(MpmPointColumnsAdd(columns, &half_length));
  if (model->disc.context.inertia->dynamic) PetscCall(MpmPointColumnsAdd(columns, &velocity));
  PetscFunctionReturn(PETSC_SUCCESS);
}

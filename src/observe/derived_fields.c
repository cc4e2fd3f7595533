/*
  Fields of the points that are made from F, stress and pressure, written on request alone. Strain and stress are
  positive in tension, pressure of water in compression; in saturated ground the stress is the effective one.

  The mobilised friction angle is that of the largest of Mohr's circles about the origin,
  sin phi = (s1 - s3)/(-(s1 + s3)): 90 degrees where a principal stress is a tension, 0 without stress.
*/
#include <string.h>
#include "point/layout.h"
#include "point/strain_measure.h"
#include "particles/particles.h"
#include "particles/points.h"
#include "loads/water_table.h"
#include "query/model.h"
#include "observe/point_columns.h"

static PetscErrorCode GreenLagrange(const PetscReal F[9], const PetscReal stress[6], PetscReal value[])
{
  (void)stress;
  PetscFunctionBeginUser;
  for (PetscInt s = 0; s < MPM_SPACE_SYM; s++) {
    const PetscInt i = MpmSpacePairs[s][0], j = MpmSpacePairs[s][1];

    value[s] = 0.5 * (F[i] * F[j] + F[3 + i] * F[3 + j] + F[6 + i] * F[6 + j] - (i == j ? 1. : 0.));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Logarithmic(const PetscReal F[9], const PetscReal stress[6], PetscReal value[])
{
  (void)stress;
  PetscFunctionBeginUser;
  PetscCall(MpmStrainFromDeformation(MPM_STRAIN_LOG, F, value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Volumetric(const PetscReal F[9], const PetscReal stress[6], PetscReal value[])
{
  (void)stress;
  PetscFunctionBeginUser;
  value[0] = MpmVolumeStrain(MPM_STRAIN_LOG, F);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Deviatoric(const PetscReal F[9], const PetscReal stress[6], PetscReal value[])
{
  PetscReal strain[MPM_SPACE_SYM];

  (void)stress;
  PetscFunctionBeginUser;
  PetscCall(MpmStrainFromDeformation(MPM_STRAIN_LOG, F, strain));
  value[0] = 2. / 3. * MpmDeviatorSize(strain);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Principal(const PetscReal F[9], const PetscReal stress[6], PetscReal value[])
{
  PetscReal ascending[3];

  (void)F;
  PetscFunctionBeginUser;
  PetscCall(MpmPrincipalValues(stress, ascending));
  for (PetscInt a = 0; a < 3; a++) value[a] = ascending[2 - a];
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Mean(const PetscReal F[9], const PetscReal stress[6], PetscReal value[])
{
  (void)F;
  PetscFunctionBeginUser;
  value[0] = (stress[0] + stress[1] + stress[2]) / 3.;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode VonMises(const PetscReal F[9], const PetscReal stress[6], PetscReal value[])
{
  (void)F;
  PetscFunctionBeginUser;
  value[0] = MpmDeviatorSize(stress);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode MobilisedFriction(const PetscReal F[9], const PetscReal stress[6], PetscReal value[])
{
  PetscReal s[3], radius, center;

  (void)F;
  PetscFunctionBeginUser;
  PetscCall(MpmPrincipalValues(stress, s));
  radius   = s[2] - s[0];
  center   = -(s[2] + s[0]);
  value[0] = !(radius > 0.) ? 0. : radius >= center ? 90. : 180. / PETSC_PI * PetscAsinReal(radius / center);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Fields of a point's F and stress. */
static const struct {
  const char *name, *unit;
  PetscInt    components;
  PetscErrorCode (*evaluate)(const PetscReal F[9], const PetscReal stress[6], PetscReal value[]);
} derived[] = {
  {"green_lagrange_strain", "-", 6, GreenLagrange},
  {"logarithmic_strain", "-", 6, Logarithmic},
  {"volumetric_strain", "-", 1, Volumetric},
  {"deviatoric_strain", "-", 1, Deviatoric},
  {"principal_stress", "Pa", 3, Principal},
  {"p", "Pa", 1, Mean},
  {"q", "Pa", 1, VonMises},
  {"mobilised_friction", "degrees", 1, MobilisedFriction},
};

static PetscErrorCode FillDerived(MpmModel model, const MpmPointColumn *column, PetscReal values[])
{
  const PetscInt size = model->state.particles->stress_size;
  MpmPoints      points;

  PetscFunctionBeginUser;
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  for (PetscInt p = 0; p < points.count; p++) {
    PetscReal F[9], stress[6];

    MpmPointDeformation(model->disc.dim, &points, p, F);
    MpmSymToSpace(size, &points.stress[p * size], stress);
    PetscCall((*derived[column->index].evaluate)(F, stress, &values[p * column->components]));
  }
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Pressure over that of water at rest below the level; all of it in a scene without one. */
static PetscErrorCode FillExcess(MpmModel model, const MpmPointColumn *column, PetscReal values[])
{
  const MpmWaterTable *table = model->scene.water;
  const PetscInt       rates = model->disc.layout->rate.count, dim = model->disc.dim;
  MpmPoints            points;

  PetscFunctionBeginUser;
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  for (PetscInt p = 0; p < points.count; p++) {
    const PetscReal depth = table->there ? MpmWaterTableDepth(table, model->state.time, &points.x[p * dim]) : 0.;

    values[p] = points.physics.value[p * rates + column->index];
    if (table->there) values[p] -= table->weight * (table->suction ? depth : PetscMax(depth, 0.));
  }
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmDerivedAddColumns(MpmModel model, MpmPointColumns *columns)
{
  const MpmLayout *layout = model->disc.layout;

  PetscFunctionBeginUser;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(derived); k++) {
    const MpmPointColumn row = {derived[k].name, derived[k].unit, derived[k].components, FillDerived, NULL,
                                (PetscInt)k};

    PetscCall(MpmPointColumnsAdd(columns, &row));
  }
  for (PetscInt r = 0; r < layout->rate.count; r++) {
    const MpmPointColumn row = {"excess_pressure", "Pa", 1, FillExcess, NULL, r};

    if (!strcmp(layout->component[layout->rate.component[r]].name, "pressure"))
      PetscCall(MpmPointColumnsAdd(columns, &row));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

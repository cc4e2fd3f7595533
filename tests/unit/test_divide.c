/*
  A point that is divided again and again, and its halves: what is kept, and how long their domains become.
*/
#include "scene.h"

#define LONGEST 0.5  /* cells */
#define CELL    0.25 /* m */
#define PLACE   0.01 /* m: how far from the grid's lower edge the point stands */

/* One point of half a cell, drawn out along x by `stretch` and sheared by `slip`, near the grid's edge. */
static PetscErrorCode CreatePoint(const char *law, PetscReal stretch, PetscReal slip, MpmModel *model)
{
  char      options[1024];
  MpmPoints points;

  PetscFunctionBeginUser;
  PetscCall(PetscSNPrintf(
    options, sizeof(options),
    "-mpm_dim 2 -mpm_grid_lower 0,0 -mpm_grid_upper 25,5 -mpm_grid_cells 100,20 -mpm_materials m "
    "-mpm_material_m_type %s -mpm_material_m_E 1e6 -mpm_material_m_nu 0.3 %s -mpm_bodies b "
    "-mpm_body_b_material m -mpm_body_b_region box -mpm_body_b_lower 0,0 -mpm_body_b_upper 0.125,0.125 "
    "-mpm_body_b_points_per_cell 2,2 -mpm_shape gimp -mpm_time_step 1 -mpm_time_end 1 -mpm_stabilization_divide %g",
    law, strcmp(law, "j2") ? "" : "-mpm_material_m_yield_stress 1e4", LONGEST));
  PetscCall(SceneCreate(PETSC_COMM_SELF, NULL, options, model));
  PetscCall(MpmParticlesGetArrays((*model)->state.particles, &points));
  PetscCheck(points.count == 1, PETSC_COMM_SELF, PETSC_ERR_PLIB, "%" PetscInt_FMT " points", points.count);
  points.x[0] = points.x[1] = PLACE;
  points.F[0]               = stretch;
  points.F[1]               = slip;
  points.F[2]               = 0.;
  points.F[3]               = 1. / stretch;
  PetscCall(MpmParticlesRestoreArrays((*model)->state.particles, &points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode DivideAll(MpmModel model)
{
  PetscInt divided = 1;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; divided && k < 2 * MPM_DIVISIONS; k++)
    PetscCall(MpmParticlesDivide(model->state.particles, model->disc.grid, model->scene.materials->at,
                                 model->scene.stabilization.divide, 1.25, &divided));
  PetscCheck(!divided, PETSC_COMM_SELF, PETSC_ERR_PLIB, "it does not end");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The length of an edge in cells. */
static PetscReal Edge(const MpmPoints *points, PetscInt p, PetscInt axis)
{
  const PetscReal *F = &points->F[4 * p];

  return 2. * points->domain.half_length[2 * p + axis] * PetscSqrtReal(PetscSqr(F[axis]) + PetscSqr(F[2 + axis])) /
         CELL;
}

/* Drawn out to thirty cells, then divided as often as may be. */
START_TEST(threads)
{
  const char *const laws[] = {"j2", "hencky"};

  for (PetscInt k = 0; k < 4; k++) {
    const PetscBool flows  = (PetscBool)(k < 2);
    const PetscReal slip   = k % 2 ? 30. : 0.;
    PetscReal       volume = 0., place[2] = {0., 0.};
    MpmModel        model;
    MpmPoints       points;

    SCENE_CALL(CreatePoint(laws[k / 2], 60., slip, &model));
    SCENE_CALL(DivideAll(model));
    SCENE_CALL(MpmParticlesGetArrays(model->state.particles, &points));
    ck_assert_int_eq((int)points.count, 1 << MPM_DIVISIONS);
    for (PetscInt p = 0; p < points.count; p++) {
      const PetscReal *F = &points.F[4 * p];

      volume += points.volume0[p];
      for (PetscInt i = 0; i < 2; i++) {
        place[i] += points.x[2 * p + i] / (PetscReal)points.count;
        ck_assert(Edge(&points, p, i) <= LONGEST * (1. + 1e-12));
        ck_assert(points.x[2 * p + i] >= 0.);
      }
      ck_assert(PetscAbsReal(MpmDeterminant(4, F) - 1.) <= 1e-12);
      if (flows) ck_assert(PetscAbsReal(F[0] * F[1] + F[2] * F[3]) <= 1e-9);
      else ck_assert(F[0] == 60. && F[1] == slip);
    }
    ck_assert(PetscAbsReal(volume - PetscSqr(0.5 * CELL)) <= 1e-15);
    ck_assert(PetscAbsReal(place[0] - PLACE) + PetscAbsReal(place[1] - PLACE) <= 1e-14);
    SCENE_CALL(MpmParticlesRestoreArrays(model->state.particles, &points));
    SCENE_CALL(SceneDestroy(&model));
  }
}
END_TEST

/* Halves that would not fit between the point and the grid's edge. */
START_TEST(beside_the_edge)
{
  MpmModel  model;
  MpmPoints points;

  SCENE_CALL(CreatePoint("j2", 1.5, 0., &model));
  SCENE_CALL(DivideAll(model));
  SCENE_CALL(MpmParticlesGetArrays(model->state.particles, &points));
  ck_assert_int_eq((int)points.count, 2);
  for (PetscInt p = 0; p < 2; p++) {
    ck_assert(PetscAbsReal(Edge(&points, p, 0) - 0.375) <= 1e-15);
    ck_assert(points.F[4 * p] == 1.5 && points.x[2 * p + 1] == PLACE);
    ck_assert(PetscAbsReal(points.x[2 * p] - (p ? 2. * PLACE : 0.)) <= 1e-15);
  }
  SCENE_CALL(MpmParticlesRestoreArrays(model->state.particles, &points));
  SCENE_CALL(SceneDestroy(&model));
}
END_TEST

int main(int argc, char **argv)
{
  const TTest *const tests[] = {threads, beside_the_edge};

  return UnitRun(&argc, &argv, "divide", sizeof(tests) / sizeof(tests[0]), tests);
}

/*
  The state as an object: a copy of it returns with the points, and a step taken twice from it ends at the same place;
  numbers of a checkpoint by name.

  Ranks: 1 3
*/
#include "base/rows.h"
#include "scene.h"

static const char *const scene =
  "-mpm_dim 2 -mpm_grid_lower 0,0 -mpm_grid_upper 3,2 -mpm_grid_cells 6,5 -mpm_materials m -mpm_material_m_density 10 "
  "-mpm_material_m_type hencky -mpm_material_m_E 1e3 -mpm_material_m_nu 0.3 -mpm_bodies b -mpm_body_b_material m "
  "-mpm_body_b_region box -mpm_body_b_lower 0.5,0.4 -mpm_body_b_upper 2.5,1.6 -mpm_bcs floor -mpm_bc_floor_region box "
  "-mpm_bc_floor_lower 0,0.4 -mpm_bc_floor_upper 3,0.4 -mpm_bc_floor_components x,y -mpm_bc_floor_value 0,0 "
  "-mpm_loads weight -mpm_load_weight_type gravity -mpm_load_weight_value 1,-9 -mpm_time_step 0.1 -mpm_time_end 1 "
  "-mpm_output_prefix /tmp/talus_state -mpm_quiet ";

/* Positions of all points, by id. */
static PetscErrorCode Step(MpmModel model, PetscReal **x)
{
  const PetscReal next = model->state.time + 0.1;
  MpmOutcome      outcome;

  PetscFunctionBeginUser;
  PetscCall(MpmStep(model, next, 0.1, PETSC_FALSE, &outcome));
  PetscCheck(!outcome.code, PETSC_COMM_WORLD, PETSC_ERR_NOT_CONVERGED, "%s", outcome.text);
  model->state.time = next;
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, model->disc.points));
  PetscCall(SceneById(model, 2, "position", x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

START_TEST(copy)
{
  MpmModel     model;
  MpmStateKept kept;
  PetscReal   *first, *second, *again, *back;
  PetscInt     count;
  PetscBool    equal, moved;

  SCENE_CALL(SceneCreate(PETSC_COMM_WORLD, NULL, scene, &model));
  SCENE_CALL(MpmParticlesMigrate(model->state.particles, model->disc.grid));
  count = 2 * (PetscInt)model->state.particles->total;
  SCENE_CALL(Step(model, &first));
  SCENE_CALL(MpmStateCopy(&model->state, &kept));
  model->state.step = 7;
  SCENE_CALL(Step(model, &second));
  SCENE_CALL(MpmStateReturn(&model->state, &kept));
  SCENE_CALL(SceneById(model, 2, "position", &back));
  SCENE_CALL(PetscArraycmp(first, second, count, &moved));
  SCENE_CALL(PetscArraycmp(first, back, count, &equal));
  ck_assert(!moved);
  ck_assert(equal);
  ck_assert(PetscAbsReal(model->state.time - 0.1) < 1e-15);
  ck_assert_int_eq((int)model->state.step, 7); /* the account of the run goes on */
  SCENE_CALL(Step(model, &again));
  for (PetscInt k = 0; k < count; k++) ck_assert(PetscAbsReal(second[k] - again[k]) < 1e-12);
  SCENE_CALL(PetscFree(first));
  SCENE_CALL(PetscFree(second));
  SCENE_CALL(PetscFree(again));
  SCENE_CALL(PetscFree(back));
  SCENE_CALL(SceneDestroy(&model));
}
END_TEST

START_TEST(numbers)
{
  MpmModel     model;
  MpmRowValues values;
  PetscReal    own[2]  = {1., 2.};
  PetscBool    flag    = PETSC_TRUE;
  const MpmRow added[] = {{"array", MPM_ROW_REAL, MPM_ROW_STATE, own, 2, 3},
                          {"flag", MPM_ROW_BOOL, MPM_ROW_RUN, &flag, 0, 0}};
  PetscInt     found   = 0;

  SCENE_CALL(SceneCreate(PETSC_COMM_WORLD, NULL, scene, &model));
  SCENE_CALL(MpmRowsAdd(model->state.rows, "own_", 2, added));
  SCENE_CALL(MpmStateSave(&model->state, &values));
  for (PetscInt k = 0; k < values.count; k++) {
    for (PetscInt j = 0; j < k; j++) ck_assert_str_ne(values.name[j], values.name[k]);
    if (!strcmp(values.name[k], "own_array_3") || !strcmp(values.name[k], "own_array_4")) found++;
  }
  ck_assert_int_eq((int)found, 2);
  own[0] = own[1] = 0.;
  flag            = PETSC_FALSE;
  SCENE_CALL(MpmStateLoad(&model->state, &values, "own_array"));
  ck_assert(own[0] == 1. && own[1] == 2. && !flag);
  SCENE_CALL(MpmStateLoad(&model->state, &values, ""));
  ck_assert(flag);
  SCENE_CALL(MpmRowValuesDestroy(&values));
  SCENE_CALL(SceneDestroy(&model));
}
END_TEST

int main(int argc, char **argv)
{
  const TTest *const tests[] = {copy, numbers};

  return UnitRun(&argc, &argv, "state", sizeof(tests) / sizeof(tests[0]), tests);
}

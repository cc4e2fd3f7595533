/*
  Time left: of stages whose steps grow, are short or explicit, and cost each its own, within a factor of 1.5 after a
  tenth of each stage once steps of all kinds are known.
*/
#include "schedule/stage.h"
#include "observe/results.h"
#include "scene.h"

#define STAGES 4
#define MOST   2000 /* steps */
#define FACTOR 1.5

static const char options[] =
  "-mpm_dim 2 -mpm_grid_lower 0,0 -mpm_grid_upper 2,2 -mpm_grid_cells 2,2 -mpm_bodies b -mpm_body_b_region box "
  "-mpm_body_b_lower 0,0 -mpm_body_b_upper 2,1 -mpm_body_b_material m -mpm_materials m -mpm_material_m_type hencky "
  "-mpm_material_m_E 1e6 -mpm_material_m_nu 0.3 -mpm_material_m_density 1000 -mpm_bcs base -mpm_bc_base_region box "
  "-mpm_bc_base_lower 0,0 -mpm_bc_base_upper 2,0 -mpm_bc_base_components x,y -mpm_time_end 1 -mpm_time_step 1 "
  "-mpm_stages shake,load,wait,fall -mpm_stage_shake_time_end 2 -mpm_stage_shake_time_integrator explicit "
  "-mpm_stage_shake_time_step 0.004 -mpm_stage_load_time_end 1 -mpm_stage_load_time_step 0.02 "
  "-mpm_stage_wait_time_end 1e8 -mpm_stage_wait_time_step 1e3 -mpm_stage_wait_time_growth 1.3 "
  "-mpm_stage_wait_time_step_max 4e6 -mpm_stage_fall_time_end 1 -mpm_stage_fall_time_integrator explicit "
  "-mpm_stage_fall_time_step 0.004";

/* A step of the run that is played: its stage, end, length and cost; and the estimate after it. */
typedef struct {
  PetscInt  stage;
  PetscReal time, dt, seconds, left;
} Step;

static void Play(MpmModel model, PetscInt *count, Step steps[])
{
  *count = 0;
  for (PetscInt k = 0; k < STAGES; k++) {
    const PetscBool explicit_steps = (PetscBool)(k == 0 || k == 3);

    if (k) UNIT_CALL(MpmStageBegin(model, k));
    while (model->state.time < model->state.period.end * (1. - 1e-12) && *count < MOST) {
      const PetscReal dt   = PetscMin(model->state.dt.wanted, model->state.period.end - model->state.time);
      Step           *step = &steps[(*count)++];

      model->state.time += dt;
      if (!explicit_steps)
        model->state.dt.wanted = PetscMin(model->state.dt.wanted * model->state.dt.growth, model->state.dt.most);
      step->stage   = k;
      step->time    = model->state.time;
      step->dt      = dt;
      step->seconds = (explicit_steps ? 0.01 : 2.) * (1. + 0.3 * SceneRandom(1, *count, k));
      step->left    = MpmTimeLeftAfter(model, dt, step->seconds);
    }
  }
}

START_TEST(test_stages)
{
  PetscInt  count, of[STAGES] = {0}, seen[STAGES] = {0};
  PetscReal left = 0.;
  MpmModel  model;
  Step     *steps;

  UNIT_CALL(SceneCreate(PETSC_COMM_WORLD, NULL, options, &model));
  UNIT_CALL(PetscCalloc1(MOST, &steps));
  Play(model, &count, steps);
  ck_assert_int_lt(count, MOST);
  for (PetscInt i = 0; i < count; i++) of[steps[i].stage]++;
  for (PetscInt i = count - 1; i >= 0; i--) {
    const PetscInt k = steps[i].stage, after = of[k] - ++seen[k];

    /* in the first stage nobody knows what an implicit step costs */
    if (k && 10 * after >= of[k] && left > 0.)
      ck_assert_msg(steps[i].left < FACTOR * left && steps[i].left > left / FACTOR,
                    "step %d of stage %d, %g s left: estimated %g s", (int)after, (int)k, (double)left,
                    (double)steps[i].left);
    left += steps[i].seconds;
  }
  ck_assert_double_eq(steps[count - 1].left, 0.);
  ck_assert_int_gt(of[2], 40);
  UNIT_CALL(PetscFree(steps));
  UNIT_CALL(SceneDestroy(&model));
}
END_TEST

int main(int argc, char **argv)
{
  const TTest *const tests[] = {test_stages};

  return UnitRun(&argc, &argv, "time left", PETSC_STATIC_ARRAY_LENGTH(tests), tests);
}

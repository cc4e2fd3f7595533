/*
  The error in time of steps of two stages: that of a change which is uniform in a block does not depend on the block's
  place in its cells, nodes that follow others included.

  Ranks: 1 2
*/
#include "block.h"
#include "integrators/sdirk.h"
#include "integrators/time_error.h"

#define SWELLING 1e-4

/* The estimate where the first stage has swollen the block evenly and the step's end is its start. */
static PetscErrorCode Estimate(MpmModel model, PetscReal *estimate)
{
  const PetscInt dim = model->disc.dim, size = dim * dim, count = model->disc.points->count;
  MpmSdirk      *sdirk;

  PetscFunctionBeginUser;
  PetscCall(PetscNew(&sdirk));
  PetscCall(PetscMalloc4((count * size), &sdirk->F, count, &sdirk->value, (count * model->disc.layout->deviation.count),
                         &sdirk->deviation, (count + 1), &sdirk->stage));
  PetscCall(PetscArrayzero(sdirk->value, count));
  PetscCall(PetscArrayzero(sdirk->deviation, count * model->disc.layout->deviation.count));
  for (PetscInt p = 0; p < count; p++) {
    for (PetscInt k = 0; k < size; k++) sdirk->F[p * size + k] = k % (dim + 1) ? 0. : 1. + SWELLING;
    sdirk->stage[p] = (MpmKernelStage){.F         = &sdirk->F[p * size],
                                       .value     = &sdirk->value[p],
                                       .deviation = &sdirk->deviation[p * model->disc.layout->deviation.count],
                                       .span      = 0.25};
  }
  model->state.scheme.sdirk         = sdirk;
  model->state.scheme.error.largest = SWELLING;
  PetscCall(PetscArrayzero(model->disc.nodal.u, model->disc.space->local * model->disc.block));
  PetscCall(MpmTimeError(model, estimate));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Pressures that follow, of all ranks. */
static PetscErrorCode Followers(MpmModel model, PetscInt *followers)
{
  const PetscInt bs = model->disc.block;

  PetscFunctionBeginUser;
  *followers = 0;
  for (PetscInt i = 0; i < model->disc.space->owned; i++)
    *followers += model->disc.constraints->condition[i * bs + bs - 1] == MPM_FOLLOWS;
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, followers, 1, MPIU_INT, MPI_SUM, model->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

START_TEST(place_in_cells)
{
  for (PetscInt dim = 2; dim <= 3; dim++) {
    for (size_t s = 0; s < BLOCK_SHAPES; s++) {
      PetscReal estimate[2];
      PetscInt  followers[2];

      for (PetscInt k = 0; k < 2; k++) {
        MpmModel model;

        SCENE_CALL(BlockCreate(dim, block_shapes[s], BLOCK_WET,
                               k ? "-mpm_time_error 1e-3 -mpm_stabilization_filled 0.45"
                                 : "-mpm_time_error 1e-3 -mpm_stabilization_filled 0",
                               &model));
        SCENE_CALL(BlockShift(model, 0.3));
        SCENE_CALL(SceneBegin(model, 0.25));
        SCENE_CALL(Followers(model, &followers[k]));
        SCENE_CALL(Estimate(model, &estimate[k]));
        SCENE_CALL(SceneDestroy(&model));
      }
      printf("%dD %s: estimates %.12g and, with %d followers, %.12g\n", (int)dim, block_shapes[s], (double)estimate[0],
             (int)followers[1], (double)estimate[1]);
      ck_assert_int_eq(followers[0], 0);
      ck_assert_msg(estimate[0] > 0. && PetscAbsReal(estimate[1] / estimate[0] - 1.) <= 1e-12,
                    "%dD %s: %g, %g where nodes follow", (int)dim, block_shapes[s], (double)estimate[0],
                    (double)estimate[1]);
    }
  }
}
END_TEST

int main(int argc, char **argv)
{
  const TTest *const tests[] = {place_in_cells};

  return UnitRun(&argc, &argv, "error in time", sizeof(tests) / sizeof(tests[0]), tests);
}

/*
  impulse OPTIONS - runs a scene in the plane; prints the sum over its steps of the force of the condition `floor` times
  their lengths, N s, which the checkpoints of the run hold
*/
#include "run_scene.h"

static struct {
  PetscReal sum[2], time; /* time: of the last step's end, s */
  PetscInt  steps;
} impulse;

static PetscErrorCode AddStep(MpmModel model, void *ctx)
{
  const PetscReal before = impulse.time;
  PetscReal       reaction[2];

  (void)ctx;
  PetscFunctionBeginUser;
  PetscCall(MpmModelGetReaction(model, "floor", reaction));
  PetscCall(MpmModelGetTime(model, &impulse.time, NULL));
  for (int a = 0; a < 2; a++) impulse.sum[a] += reaction[a] * (impulse.time - before);
  impulse.steps++;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Add(MpmModel model)
{
  const MpmRow rows[] = {
    {.name = "impulse", .kind = MPM_ROW_REAL, .use = MPM_ROW_RUN, .address = impulse.sum, .count = 2},
    {.name = "impulse_time", .kind = MPM_ROW_REAL, .use = MPM_ROW_RUN, .address = &impulse.time},
    {.name = "impulse_steps", .kind = MPM_ROW_INT, .use = MPM_ROW_RUN, .address = &impulse.steps}};

  PetscFunctionBeginUser;
  for (int k = 0; k < 3; k++) PetscCall(MpmModelAddRow(model, &rows[k]));
  PetscCall(MpmModelSetAfterStep(model, AddStep, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

int main(int argc, char **argv)
{
  int status = 0;

  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  PetscCall(RunScene(argc, argv, Add, &status));
  PetscCall(PetscPrintf(PETSC_COMM_WORLD, "%.15e %.15e %.15e %d\n", (double)impulse.sum[0], (double)impulse.sum[1],
                        (double)impulse.time, (int)impulse.steps));
  PetscCall(PetscFinalize());
  return status;
}

/*
  tied PLUGIN - two blocks, each a model of its own, with a spring between their tops. One is pushed; before each step a hook
  sets what the spring does to its model, from where the points of both are. A line tells of the end: the push; what the
  spring has done to each; the reactions of both floors; and how far each top has gone.
*/
#include <talus/talus.h>

#define STIFFNESS 1e3 /* of the spring, N/m */
#define PUSH      300.

static const char *const block =
  "-mpm_dim 2 -mpm_grid_lower 0,0 -mpm_grid_upper 6,4 -mpm_grid_cells 12,8 -mpm_bodies b -mpm_body_b_material m "
  "-mpm_body_b_region box -mpm_body_b_lower 2,0 -mpm_body_b_upper 4,3 -mpm_materials m -mpm_material_m_E 1e5 "
  "-mpm_material_m_nu 0.3 -mpm_bcs floor -mpm_bc_floor_region box -mpm_bc_floor_lower 0,0 -mpm_bc_floor_upper 6,0 "
  "-mpm_bc_floor_components x,y -mpm_load_tie_type force -mpm_load_tie_region box -mpm_load_tie_lower 2,2.5 "
  "-mpm_load_tie_upper 4,3 -mpm_load_tie_value 1,0 -mpm_time_step 0.05 ";
static const char *const pushed =
  "-mpm_material_m_type hencky -mpm_loads push,tie -mpm_load_push_type force -mpm_load_push_region box "
  "-mpm_load_push_lower 2,2.5 -mpm_load_push_upper 4,3 -mpm_load_push_value 300,0 -mpm_load_push_ramp 0:0,0.2:1 ";
static const char *const follows = "-mpm_loads tie -mpm_material_m_type fung -mpm_plugin ";

/* What a hook knows: both ends of the spring, its own first. */
typedef struct {
  MpmModel  self, other;
  PetscReal force;
} Spring;

/* The mean displacement along x of a model's points that stood above 2.5 m. */
static PetscErrorCode Top(MpmModel model, PetscReal *displacement)
{
  PetscInt   count, dim;
  PetscReal *x, *x0, sum[2] = {0., 0.};

  PetscFunctionBeginUser;
  PetscCall(MpmModelGetPointCount(model, &count, NULL));
  PetscCall(MpmModelGetPoints(model, "position", &dim, &x));
  PetscCall(MpmModelGetPoints(model, "position0", NULL, &x0));
  for (PetscInt p = 0; p < count; p++) {
    if (x0[p * dim + 1] < 2.5) continue;
    sum[0] += x[p * dim] - x0[p * dim];
    sum[1] += 1.;
  }
  PetscCall(MpmModelRestorePoints(model, "position0", NULL, &x0));
  PetscCall(MpmModelRestorePoints(model, "position", NULL, &x));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, 2, MPIU_REAL, MPIU_SUM, PETSC_COMM_WORLD));
  *displacement = sum[0] / sum[1];
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Pull(MpmModel model, void *ctx)
{
  Spring   *spring = (Spring *)ctx;
  PetscReal here, there;

  PetscFunctionBeginUser;
  PetscCall(Top(spring->self, &here));
  PetscCall(Top(spring->other, &there));
  spring->force = STIFFNESS * (there - here);
  PetscCall(MpmModelSetLoadFactor(model, "tie", spring->force));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Create(const char *more, MpmModel *model)
{
  PetscFunctionBeginUser;
  PetscCall(MpmModelCreate(PETSC_COMM_WORLD, model));
  PetscCall(MpmModelSetOptions(*model, block));
  PetscCall(MpmModelSetOptions(*model, more));
  PetscCall(MpmModelSetFromOptions(*model));
  PetscCall(MpmModelSetUp(*model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The models in turn; the spring's force is that of the points before the step. */
static PetscErrorCode Tie(MpmModel model[2], Spring spring[2])
{
  MpmStatus status = MPM_RUNNING;

  PetscFunctionBeginUser;
  for (int k = 0; k < 2; k++) {
    spring[k] = (Spring){model[k], model[1 - k], 0.};
    PetscCall(MpmModelSetBeforeStep(model[k], Pull, &spring[k]));
  }
  while (status == MPM_RUNNING) {
    for (int k = 0; k < 2 && status != MPM_GAVE_UP; k++) PetscCall(MpmModelStep(model[k], &status));
  }
  PetscCheck(status == MPM_COMPLETED, PETSC_COMM_WORLD, PETSC_ERR_NOT_CONVERGED, "a model has given up");
  PetscFunctionReturn(PETSC_SUCCESS);
}

int main(int argc, char **argv)
{
  MpmModel  model[2];
  Spring    spring[2];
  PetscReal reaction[2][2], top[2];
  char      text[PETSC_MAX_PATH_LEN];

  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  PetscCall(PetscSNPrintf(text, sizeof(text), "%s%s", follows, argv[1]));
  PetscCall(Create(pushed, &model[0]));
  PetscCall(Create(text, &model[1]));
  PetscCall(Tie(model, spring));
  for (int k = 0; k < 2; k++) {
    PetscCall(MpmModelGetReaction(model[k], "floor", reaction[k]));
    PetscCall(Top(model[k], &top[k]));
  }
  PetscCall(PetscPrintf(PETSC_COMM_WORLD, "%.9e %.9e %.9e %.9e %.9e %.9e %.9e\n", PUSH, (double)spring[0].force,
                        (double)spring[1].force, (double)reaction[0][0], (double)reaction[1][0], (double)top[0],
                        (double)top[1]));
  for (int k = 0; k < 2; k++) PetscCall(MpmModelDestroy(&model[k]));
  PetscCall(PetscFinalize());
  return 0;
}

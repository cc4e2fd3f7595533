/*
  Evaluations of a step at given unknowns: residual, trial, energy and derivative are those of Newton's method, and
  nothing of the problem changes.

  Ranks: 1 3
*/
#include "problem/evaluation.h"
#include "scene.h"

#define SCENE \
  "-mpm_dim 2 -mpm_grid_lower 0,0 -mpm_grid_upper 3,2 -mpm_grid_cells 6,5 -mpm_bodies b -mpm_body_b_region box " \
  "-mpm_body_b_lower 0.5,0.4 -mpm_body_b_upper 2.5,1.6 -mpm_body_b_material m -mpm_materials m " \
  "-mpm_material_m_type neo_hookean -mpm_material_m_E 1e3 -mpm_material_m_nu 0.3 -mpm_material_m_density 10 " \
  "-mpm_bcs floor,edge -mpm_bc_floor_region box -mpm_bc_floor_lower 0,0.4 -mpm_bc_floor_upper 3,0.4 " \
  "-mpm_bc_floor_components x,y -mpm_bc_floor_value 0.01,-0.006 -mpm_bc_edge_region box -mpm_bc_edge_lower 2.5,0.6 " \
  "-mpm_bc_edge_upper 2.5,2 -mpm_bc_edge_normal 1,0.4 -mpm_loads w -mpm_load_w_type gravity -mpm_load_w_value 1,-9 " \
  "-mpm_time_step 0.1 -mpm_time_end 1 -mpm_stabilization_fbar false -mpm_solver direct -mpm_quiet "

/* |a - b| over |b|; a is lost. */
static PetscErrorCode Distance(Vec a, Vec b, PetscReal *distance)
{
  PetscReal norm;

  PetscFunctionBeginUser;
  PetscCall(VecNorm(b, NORM_2, &norm));
  PetscCall(VecAXPY(a, -1., b));
  PetscCall(VecNorm(a, NORM_2, distance));
  *distance /= norm;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A step that has been committed, and the next one up to Newton, with unknowns at random. */
static PetscErrorCode Begin(MpmModel *model)
{
  const PetscReal amplitude[] = {0.02, 0.02};

  PetscFunctionBeginUser;
  PetscCall(SceneCreate(PETSC_COMM_WORLD, NULL, SCENE, model));
  PetscCall(SceneBegin(*model, 0.1));
  PetscCall(SceneFill(*model, 3, amplitude, PETSC_FALSE, (*model)->solver.x));
  PetscCall(SceneCommit(*model, (*model)->solver.x));
  PetscCall(SceneBegin(*model, 0.1));
  PetscCall(SceneFill(*model, 1, amplitude, PETSC_FALSE, (*model)->solver.x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Residual and trial against Newton's; the problem's own nodal values and trial stay as they are. */
static PetscErrorCode CompareResidual(MpmModel model, PetscReal *distance, PetscReal *trial, PetscBool *kept)
{
  const MpmDiscretization *disc   = &model->disc;
  MpmEvaluation            at     = MpmEvaluationAt(disc, model->solver.x);
  MpmTrial                 own    = {NULL};
  MpmEvaluated             result = {.trial = &own};
  MpmVersion               version;
  PetscReal                first;
  Vec                      f;

  PetscFunctionBeginUser;
  PetscCall(MpmTrialCreate(disc->sum, &own));
  PetscCall(VecDuplicate(at.u, &f));
  PetscCall(VecDuplicate(at.u, &result.f));
  PetscCall(SNESComputeFunction(model->solver.snes, at.u, f));
  first = disc->nodal.residual[0];
  PetscCall(MpmEvaluateResidual(disc, at, &result));
  PetscCall(MpmVersionGet(at.u, &version));
  *kept  = (PetscBool)(first == disc->nodal.residual[0] && !result.failed && MpmVersionIsSame(&version, &result.of));
  *trial = 0.;
  for (PetscInt k = 0; k < disc->points->count * disc->points->F_size; k++)
    *trial = PetscMax(*trial, PetscAbsReal(own.F[k] - disc->trial->F[k]));
  PetscCall(Distance(result.f, f, distance));
  PetscCall(VecScale(at.u, 0.5));
  PetscCall(MpmVersionGet(at.u, &version));
  *kept = (PetscBool)(*kept && !MpmVersionIsSame(&version, &result.of));
  PetscCall(MpmTrialReset(&own));
  PetscCall(VecDestroy(&result.f));
  PetscCall(VecDestroy(&f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

START_TEST(test_residual)
{
  MpmModel  model;
  PetscReal distance = 1., trial = 1.;
  PetscBool kept = PETSC_FALSE;

  SCENE_CALL(Begin(&model));
  SCENE_CALL(CompareResidual(model, &distance, &trial, &kept));
  ck_assert_msg(SceneAll((PetscBool)(distance <= 1e-15)), "residual: %g", (double)distance);
  ck_assert_msg(SceneAll((PetscBool)(trial == 0.)), "trial: %g", (double)trial);
  ck_assert_msg(SceneAll(kept), "the problem, or the version of the unknowns");
  SCENE_CALL(SceneDestroy(&model));
}
END_TEST

/* The stress of the step's start is that of the laws where nothing has moved; conditions that move are not wanted. */
START_TEST(test_start)
{
  MpmModel      model;
  PetscReal     distance = 1.;
  MpmEvaluation at;
  MpmEvaluated  end = {NULL}, start = {NULL};

  SCENE_CALL(Begin(&model));
  at = MpmEvaluationAt(&model->disc, model->solver.x);
  SCENE_CALL(VecZeroEntries(at.u));
  SCENE_CALL(VecDuplicate(at.u, &end.f));
  SCENE_CALL(VecDuplicate(at.u, &start.f));
  SCENE_CALL(MpmEvaluateResidual(&model->disc, at, &end));
  at.mode = MPM_MODE_START;
  SCENE_CALL(MpmEvaluateResidual(&model->disc, at, &start));
  SCENE_CALL(Distance(start.f, end.f, &distance));
  ck_assert_msg(SceneAll((PetscBool)(distance <= 1e-13)), "%g", (double)distance);
  SCENE_CALL(VecDestroy(&end.f));
  SCENE_CALL(VecDestroy(&start.f));
  SCENE_CALL(SceneDestroy(&model));
}
END_TEST

START_TEST(test_energy)
{
  MpmModel     model;
  PetscReal    objective = 0.;
  MpmEvaluated result    = {NULL};

  SCENE_CALL(Begin(&model));
  SCENE_CALL(SNESComputeObjective(model->solver.snes, model->solver.x, &objective));
  SCENE_CALL(MpmEvaluateEnergy(&model->disc, MpmEvaluationAt(&model->disc, model->solver.x), &result));
  ck_assert_msg(SceneAll((PetscBool)(!result.failed && PetscAbsReal(result.energy - objective) <= 1e-13 * objective)),
                "%.16g %.16g", (double)result.energy, (double)objective);
  SCENE_CALL(SceneDestroy(&model));
}
END_TEST

/* J v against differences of residuals, and a solve with J^T by the solver's own factors. */
static PetscErrorCode CompareDerivative(MpmModel model, PetscReal *slope, PetscReal *transposed)
{
  const PetscReal amplitude[] = {1., 1.}, eps = 1e-5;
  MpmEvaluation   at = MpmEvaluationAt(&model->disc, model->solver.x);
  MpmEvaluated    side[2];
  Vec             v, w, Jv;
  Mat             J;
  KSP             ksp;

  PetscFunctionBeginUser;
  PetscCall(MpmSolverLinearise(&model->solver, at.u, &J, &ksp));
  PetscCall(VecDuplicate(at.u, &v));
  PetscCall(VecDuplicate(at.u, &w));
  PetscCall(VecDuplicate(at.u, &Jv));
  PetscCall(SceneFill(model, 2, amplitude, PETSC_TRUE, v));
  PetscCall(MatMult(J, v, Jv));
  for (PetscInt k = 0; k < 2; k++) {
    PetscCall(VecDuplicate(at.u, &side[k].f));
    side[k].trial = NULL;
    PetscCall(VecWAXPY(w, k ? eps : -eps, v, model->solver.x));
    at.u = w;
    PetscCall(MpmEvaluateResidual(&model->disc, at, &side[k]));
  }
  PetscCall(VecAXPBY(side[1].f, -0.5 / eps, 0.5 / eps, side[0].f));
  PetscCall(Distance(side[1].f, Jv, slope));
  PetscCall(MatMultTranspose(J, v, Jv));
  PetscCall(KSPSolveTranspose(ksp, Jv, w));
  PetscCall(Distance(w, v, transposed));
  for (PetscInt k = 0; k < 2; k++) PetscCall(VecDestroy(&side[k].f));
  PetscCall(VecDestroy(&v));
  PetscCall(VecDestroy(&w));
  PetscCall(VecDestroy(&Jv));
  PetscFunctionReturn(PETSC_SUCCESS);
}

START_TEST(test_derivative)
{
  MpmModel  model;
  PetscReal slope = 1., transposed = 1.;

  SCENE_CALL(Begin(&model));
  SCENE_CALL(CompareDerivative(model, &slope, &transposed));
  ck_assert_msg(SceneAll((PetscBool)(slope <= 1e-8)), "slope: %g", (double)slope);
  ck_assert_msg(SceneAll((PetscBool)(transposed <= 1e-6)), "transposed: %g", (double)transposed);
  SCENE_CALL(SceneDestroy(&model));
}
END_TEST

int main(int argc, char **argv)
{
  const TTest *const tests[] = {test_residual, test_start, test_energy, test_derivative};

  return UnitRun(&argc, &argv, "evaluation", sizeof(tests) / sizeof(tests[0]), tests);
}

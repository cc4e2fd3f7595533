/*
  A step of the tape at its solution: data for the sums of its derivatives, and solves with its Jacobian.
*/
#include "particles/particles.h"
#include "particles/points.h"
#include "space/space.h"
#include "bc/bc.h"
#include "problem/evaluation.h"
#include "step/step.h"
#include "sensitivity/replayed_step.h"

#define RTOL 1e-12 /* of solves with the Jacobian, unless -gradient_ksp_rtol has another */

static PetscBool AnyResets(const MpmModel model)
{
  for (PetscInt k = 0; k < model->scene.stages.count; k++)
    if (model->scene.stages.at[k].reset) return PETSC_TRUE;
  return PETSC_FALSE;
}

PetscErrorCode MpmReplayedStepCreate(MpmModel model, PetscInt n, MpmReplayedStep *step)
{
  const MpmDiscretization *disc  = &model->disc;
  const PetscInt           count = disc->space->local * disc->block, loads = model->scene.loads->count;
  MpmRules                *rules;

  PetscFunctionBeginUser;
  PetscCall(PetscNew(&rules));
  *rules = MpmStepRules(model, model->gradient->tape.step[n].time);
  PetscCall(PetscMalloc2((count + 1), &step->u, (loads + 1), &step->factors));
  PetscCall(PetscArraycpy(step->u, disc->nodal.u, count));
  for (PetscInt l = 0; l < loads; l++) step->factors[l] = MpmStepLoadFactor(model, l, rules->time.end);
  step->map = (MpmStepMap){.rules      = rules,
                           .sum        = disc->sum,
                           .particles  = model->state.particles,
                           .parameters = &model->gradient->parameters,
                           .u          = step->u,
                           .constants  = {AnyResets(model), model->gradient->start.differs},
                           .load_count = loads,
                           .loads      = model->scene.loads->at,
                           .factors    = step->factors};
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmReplayedStepDestroy(MpmReplayedStep *step)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(step->map.rules));
  PetscCall(PetscFree2(step->u, step->factors));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmReplayedSolveSetUp(MpmModel model)
{
  Mat J;
  KSP ksp;

  PetscFunctionBeginUser;
  PetscCall(MpmSolverLinearise(&model->solver, model->solver.x, &J, &ksp));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A Krylov method of its own around the solver's preconditioner. */
static PetscErrorCode CreateSolver(MpmModel model, KSP *ksp)
{
  KSP own;
  PC  pc;
  Mat J, P;

  PetscFunctionBeginUser;
  PetscCall(SNESGetKSP(model->solver.snes, &own));
  PetscCall(KSPGetOperators(own, &J, &P));
  PetscCall(KSPGetPC(own, &pc));
  PetscCall(KSPCreate(model->comm, ksp));
  PetscCall(KSPSetOptionsPrefix(*ksp, "gradient_"));
  PetscCall(KSPSetPC(*ksp, pc));
  PetscCall(KSPSetOperators(*ksp, J, P));
  PetscCall(KSPSetType(*ksp, KSPGMRES));
  PetscCall(KSPGMRESSetRestart(*ksp, 100));
  PetscCall(KSPSetTolerances(*ksp, RTOL, PETSC_DEFAULT, PETSC_DEFAULT, 1000));
  PetscCall(KSPSetFromOptions(*ksp));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Forces at the nodes, a rank's part, to the owners' equations. */
static PetscErrorCode ToEquations(MpmModel model, PetscReal nodal[], Vec vec)
{
  const MpmConstraints *constraints = model->disc.constraints;
  const PetscInt        count       = model->disc.space->owned * model->disc.block;
  PetscScalar          *values;

  PetscFunctionBeginUser;
  MpmConstraintsGather(constraints, model->disc.space, nodal);
  PetscCall(MpmSpaceAddToOwners(model->disc.space, model->disc.block, nodal));
  MpmFramesToUnknowns(constraints, model->disc.block, model->disc.space->owned, nodal);
  PetscCall(VecGetArrayWrite(vec, &values));
  PetscCall(PetscArraycpy(values, nodal, count));
  MpmUnitsTimes(constraints, count, values);
  MpmConstraintsZero(constraints, count, values);
  PetscCall(VecRestoreArrayWrite(vec, &values));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmReplayedSolve(MpmModel model, PetscBool transposed, PetscReal b[], PetscReal y[])
{
  Vec                right, solution;
  KSP                ksp;
  KSPConvergedReason reason;

  PetscFunctionBeginUser;
  PetscCall(VecDuplicate(model->solver.x, &right));
  PetscCall(VecDuplicate(model->solver.x, &solution));
  PetscCall(CreateSolver(model, &ksp));
  PetscCall(ToEquations(model, b, right));
  if (transposed && !model->solver.definite.symmetric) PetscCall(KSPSolveTranspose(ksp, right, solution));
  else PetscCall(KSPSolve(ksp, right, solution));
  PetscCall(KSPGetConvergedReason(ksp, &reason));
  PetscCheck(reason > 0, model->comm, PETSC_ERR_NOT_CONVERGED, "a linear solve of the gradient did not converge: %s",
             KSPConvergedReasons[reason]);
  PetscCall(MpmEvaluationNodes(&model->disc, solution, y));
  PetscCall(KSPDestroy(&ksp));
  PetscCall(VecDestroy(&right));
  PetscCall(VecDestroy(&solution));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Evaluations of a step's equations at given unknowns and state.
*/
#include "point/layout.h"
#include "particles/points.h"
#include "space/space.h"
#include "space/sum.h"
#include "bc/bc.h"
#include "assembly/terms.h"
#include "points/point_terms.h"
#include "problem/discretization.h"
#include "problem/evaluation.h"
#include "problem/potential.h"

MpmEvaluation MpmEvaluationAt(const MpmDiscretization *disc, Vec u)
{
  const MpmSum *sum = disc->sum;

  return (MpmEvaluation){
    .points = sum->points, .u = u, .dt = sum->step.dt, .span = sum->step.span, .part = sum->step.part};
}

void MpmEvaluationSum(const MpmDiscretization *disc, MpmEvaluation at, MpmSum *sum)
{
  *sum           = *disc->sum;
  sum->points    = at.points;
  sum->step.dt   = at.dt;
  sum->step.span = at.span;
  sum->step.part = at.part;
  sum->mode      = at.mode;
}

PetscErrorCode MpmTrialCreate(const MpmSum *sum, MpmTrial *trial)
{
  const PetscInt count = sum->space->point_count;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc5((count * sum->points->F_size), &trial->F, (count * MpmSymSize(sum->space->dim)),
                         &trial->stress, (count * sum->kept.state), &trial->state, (count * sum->kept.own), &trial->own,
                         (sum->space->local * sum->block), &trial->u));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTrialReset(MpmTrial *trial)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree5(trial->F, trial->stress, trial->state, trial->own, trial->u));
  trial->of.id = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmEvaluationNodes(const MpmDiscretization *disc, Vec u, PetscReal local[])
{
  const PetscInt     owned = disc->space->owned * disc->block;
  const PetscScalar *values;

  PetscFunctionBeginUser;
  PetscCall(VecGetArrayRead(u, &values));
  PetscCall(PetscArraycpy(local, values, owned));
  PetscCall(VecRestoreArrayRead(u, &values));
  MpmUnitsTimes(disc->constraints, owned, local);
  PetscCall(MpmSpaceToGhosts(disc->space, disc->block, local));
  MpmFramesToAxes(disc->constraints, disc->block, disc->space->local, local);
  MpmConstraintsExtend(disc->constraints, disc->space, local);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmEvaluateForces(const MpmDiscretization *disc, const MpmSum *sum, const PetscReal u[],
                                 const MpmTrial *trial, PetscReal residual[], PetscInt *failed)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < disc->space->local * disc->block; k++) residual[k] = -disc->nodal.force[k];
  PetscCall(MpmTermsResidual(disc->terms, sum, u, trial, residual, failed));
  MpmConstraintsGather(disc->constraints, disc->space, residual);
  PetscCall(MpmSpaceAddToOwners(disc->space, disc->block, residual));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmEvaluationEquations(const MpmDiscretization *disc, Vec u, const PetscReal residual[], Vec f)
{
  const PetscInt     owned = disc->space->owned * disc->block;
  const PetscScalar *at;
  PetscScalar       *values;

  PetscFunctionBeginUser;
  PetscCall(VecGetArrayRead(u, &at));
  PetscCall(VecGetArrayWrite(f, &values));
  PetscCall(PetscArraycpy(values, residual, owned));
  MpmFramesToUnknowns(disc->constraints, disc->block, disc->space->owned, values);
  MpmUnitsTimes(disc->constraints, owned, values);
  MpmConstraintsResidual(disc->constraints, owned, at, values);
  PetscCall(VecRestoreArrayWrite(f, &values));
  PetscCall(VecRestoreArrayRead(u, &at));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmEvaluateResidual(const MpmDiscretization *disc, MpmEvaluation at, MpmEvaluated *result)
{
  const PetscInt count = disc->space->local * disc->block;
  PetscReal     *u, *residual;
  MpmSum         sum;

  PetscFunctionBeginUser;
  MpmEvaluationSum(disc, at, &sum);
  PetscCall(PetscMalloc2(count, &u, count, &residual));
  PetscCall(MpmEvaluationNodes(disc, at.u, u));
  PetscCall(MpmEvaluateForces(disc, &sum, u, result->trial, residual, &result->failed));
  if (result->f) PetscCall(MpmEvaluationEquations(disc, at.u, residual, result->f));
  PetscCall(PetscFree2(u, residual));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &result->failed, 1, MPIU_INT, MPI_SUM, disc->comm));
  PetscCall(MpmVersionGet(at.u, &result->of));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmEvaluateEnergy(const MpmDiscretization *disc, MpmEvaluation at, MpmEvaluated *result)
{
  MpmTrial  own = {NULL}, *trial = result->trial ? result->trial : &own;
  PetscReal size = 0., *u;
  MpmSum    sum;

  PetscFunctionBeginUser;
  MpmEvaluationSum(disc, at, &sum);
  if (trial == &own) PetscCall(MpmTrialCreate(&sum, trial));
  PetscCall(PetscMalloc1((disc->space->local * disc->block + 1), &u));
  PetscCall(MpmEvaluationNodes(disc, at.u, u));
  result->failed = 0;
  PetscCall(MpmPointsUpdate(&sum, u, trial, &result->failed));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &result->failed, 1, MPIU_INT, MPI_SUM, disc->comm));
  if (!result->failed) PetscCall(MpmPotentialEvaluate(disc, &sum, u, trial, &result->energy, &size));
  PetscCall(MpmTrialReset(&own));
  PetscCall(PetscFree(u));
  PetscCall(MpmVersionGet(at.u, &result->of));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Convergence test of a step with several fields.

  A residual of several fields has forces and, say, volumes; in the solver's units (MpmUnitsTimes()) both are forces.
  Each field has to fall below snes_rtol of its own reference: the residual at the step's start, or the action of the
  others on it in the step, if that is more. Where a load comes at once on sealed ground the volumes start in balance,
  and where water flows out under a constant load the forces do. The scale is then set by the mutual action of the
  fields in Newton's first iteration,

    J_fg (x_g - x_g at the step's start) ,   g the other fields

  The floor is the rounding of strains, as for one field, and that of the field's own values times its diagonal, which
  counts where a step is long against the time that the pressure takes to spread over a cell.
*/
#include "point/layout.h"
#include "bc/bc.h"
#include "problem/discretization.h"
#include "solve/solve.h"

PetscErrorCode MpmFieldNorms(const MpmSolver *solver, Vec v, PetscReal norm[])
{
  const MpmLayout   *layout = solver->disc->layout;
  const PetscInt     bs = layout->block, fields = layout->field_count;
  const PetscScalar *values;
  PetscInt           n;

  PetscFunctionBeginUser;
  PetscCall(PetscArrayzero(norm, fields));
  PetscCall(VecGetLocalSize(v, &n));
  PetscCall(VecGetArrayRead(v, &values));
  for (PetscInt k = 0; k < n; k++) norm[layout->component[k % bs].field] += PetscSqr(PetscRealPart(values[k]));
  PetscCall(VecRestoreArrayRead(v, &values));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, norm, (PetscMPIInt)fields, MPIU_REAL, MPIU_SUM, solver->disc->comm));
  for (PetscInt f = 0; f < fields; f++) norm[f] = PetscSqrtReal(norm[f]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmFieldsSetReference(MpmSolver *solver, Vec f)
{
  MpmFieldNormsKept *kept = &solver->cache.fields;

  PetscFunctionBeginUser;
  if (solver->disc->layout->field_count < 2) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmFieldNorms(solver, f, kept->reference));
  for (PetscInt i = 0; i < solver->disc->layout->field_count; i++) {
    if (PetscIsInfOrNanReal(kept->reference[i])) kept->reference[i] = 0.;
    kept->rounding[i] = 0.;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* v without one of the fields, or without all but that one; without constrained unknowns. */
static PetscErrorCode Mask(const MpmSolver *solver, PetscInt field, PetscBool without, Vec v)
{
  const MpmLayout *layout = solver->disc->layout;
  const PetscInt   bs     = layout->block;
  PetscScalar     *values;
  PetscInt         n;

  PetscFunctionBeginUser;
  PetscCall(VecGetLocalSize(v, &n));
  PetscCall(VecGetArray(v, &values));
  for (PetscInt k = 0; k < n; k++) {
    const PetscBool is = (PetscBool)(layout->component[k % bs].field == field);

    if (is == without || !MpmConstraintsFree(solver->disc->constraints, k)) values[k] = 0.;
  }
  PetscCall(VecRestoreArray(v, &values));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Mutual action of the fields from the first iteration, from x along -y: increments are counted from zero, totals from
  x, their start.
*/
PetscErrorCode MpmFieldsLearn(MpmSolver *solver, Vec x, Vec y)
{
  const MpmLayout   *layout = solver->disc->layout;
  MpmFieldNormsKept *kept   = &solver->cache.fields;
  const PetscInt     bs     = layout->block;
  PetscInt           n;
  PetscReal          norm[MPM_MAX_BLOCK];
  PetscScalar       *values;
  const PetscScalar *at;
  Vec                change, part, result;
  Mat                J;

  PetscFunctionBeginUser;
  if (layout->field_count < 2) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecGetLocalSize(x, &n));
  PetscCall(SNESGetJacobian(solver->snes, &J, NULL, NULL, NULL));
  PetscCall(VecDuplicate(y, &change));
  PetscCall(VecDuplicate(y, &part));
  PetscCall(VecDuplicate(y, &result));
  PetscCall(VecCopy(y, change));
  PetscCall(VecGetArray(change, &values));
  PetscCall(VecGetArrayRead(x, &at));
  for (PetscInt k = 0; k < n; k++)
    if (layout->component[k % bs].increment) values[k] -= at[k];
  PetscCall(VecRestoreArrayRead(x, &at));
  PetscCall(VecRestoreArray(change, &values));
  for (PetscInt f = 0; f < layout->field_count; f++) {
    PetscCall(VecCopy(change, part));
    PetscCall(Mask(solver, f, PETSC_TRUE, part));
    PetscCall(MatMult(J, part, result));
    PetscCall(Mask(solver, f, PETSC_FALSE, result));
    PetscCall(VecNorm(result, NORM_2, &norm[f]));
    if (!PetscIsInfOrNanReal(norm[f])) kept->reference[f] = PetscMax(kept->reference[f], norm[f]);
  }
  PetscCall(MatGetDiagonal(J, part));
  PetscCall(VecPointwiseMult(result, part, x));
  PetscCall(MpmFieldNorms(solver, result, norm));
  PetscCall(VecPointwiseMult(result, part, y));
  PetscCall(MpmFieldNorms(solver, result, kept->rounding));
  for (PetscInt f = 0; f < layout->field_count; f++) kept->rounding[f] += norm[f];
  PetscCall(VecDestroy(&change));
  PetscCall(VecDestroy(&part));
  PetscCall(VecDestroy(&result));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmFieldsConverged(MpmSolver *solver, Vec f, PetscReal rtol, PetscReal floor, PetscReal *excess)
{
  MpmFieldNormsKept *kept = &solver->cache.fields;
  PetscReal          norm[MPM_MAX_BLOCK];

  PetscFunctionBeginUser;
  *excess = 0.;
  PetscCall(MpmFieldNorms(solver, f, norm));
  for (PetscInt i = 0; i < solver->disc->layout->field_count; i++) {
    const PetscReal own = floor + 2. * PETSC_MACHINE_EPSILON * kept->rounding[i];

    *excess = PetscMax(*excess, norm[i] / PetscMax(rtol * kept->reference[i], own));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

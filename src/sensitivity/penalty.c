/*
  Values and derivatives of regularizations.
*/
#include "sensitivity/penalty.h"
#include <petscblaslapack.h>

/* ---- neighbours ---- */

/* The value of the next cell along an axis, or -1. */
static PetscInt NextAlong(const MpmGround *ground, const PetscInt at[], PetscInt axis)
{
  const MpmGroundGrid *grid = &ground->grid;
  PetscInt             cell = 0;

  if (at[axis] + 1 >= grid->cells[axis]) return -1;
  for (PetscInt a = grid->dim - 1; a >= 0; a--) cell = cell * grid->cells[a] + at[a] + (a == axis);
  return ground->cell[cell];
}

/* Pairs of cells that share a face. */
static PetscErrorCode FindPairs(const MpmGround *ground, MpmPenalty *penalty)
{
  const MpmGroundGrid *grid  = &ground->grid;
  PetscInt             cells = 1;

  PetscFunctionBeginUser;
  for (PetscInt a = 0; a < grid->dim; a++) cells *= grid->cells[a];
  PetscCall(PetscMalloc1((size_t)(2 * ground->count * grid->dim), &penalty->pair));
  for (PetscInt cell = 0; cell < cells; cell++) {
    PetscInt at[MPM_MAX_DIM] = {0}, rest = cell;

    if (ground->cell[cell] < 0) continue;
    for (PetscInt a = 0; a < grid->dim; rest /= grid->cells[a++]) at[a] = rest % grid->cells[a];
    for (PetscInt a = 0; a < grid->dim; a++) {
      const PetscInt next = NextAlong(ground, at, a);

      if (next < 0) continue;
      penalty->pair[2 * penalty->rows]       = ground->cell[cell];
      penalty->pair[2 * penalty->rows++ + 1] = next;
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- priors ---- */

static PetscErrorCode Factorize(const MpmGround *ground, MpmPenalty *penalty)
{
  const PetscInt count = ground->count, dim = ground->dim;
  PetscBLASInt   n, info;

  PetscFunctionBeginUser;
  PetscCall(PetscBLASIntCast(count, &n));
  PetscCall(PetscCalloc1((size_t)count * (size_t)count, &penalty->factor));
  for (PetscInt k = 0; k < count; k++) {
    for (PetscInt i = k; i < count; i++) {
      PetscReal square = 0.;

      for (PetscInt a = 0; a < dim; a++)
        square += PetscSqr((ground->at[i * dim + a] - ground->at[k * dim + a]) / penalty->regular->length[a]);
      penalty->factor[k * count + i] = PetscExpReal(-PetscSqrtReal(square));
    }
  }
  PetscCallBLAS("LAPACKpotrf", LAPACKpotrf_("L", &n, penalty->factor, &n, &info));
  PetscCheck(!info, PETSC_COMM_SELF, PETSC_ERR_LIB, "LAPACK potrf failed with %d", (int)info);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* y becomes L^-1 y, or L^-T y, over the deviation. */
static PetscErrorCode Solve(const MpmPenalty *penalty, const char transposed[], PetscReal y[])
{
  const PetscReal unit = 1.;
  PetscBLASInt    n, one = 1;

  PetscFunctionBeginUser;
  PetscCall(PetscBLASIntCast(penalty->count, &n));
  PetscCallBLAS("BLAStrsm", BLAStrsm_("L", "L", transposed, "N", &n, &one, &unit, penalty->factor, &n, y, &n));
  for (PetscInt k = 0; k < penalty->count; k++) y[k] /= penalty->regular->deviation;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPenaltySpread(const MpmPenalty *penalty, PetscBool transposed, PetscReal z[])
{
  const PetscInt   count  = penalty->count;
  const PetscReal *factor = penalty->factor;

  PetscFunctionBeginUser;
  for (PetscInt n = 0; n < count; n++) {
    const PetscInt k   = transposed ? n : count - 1 - n; /* in place: what is read is not yet written */
    PetscReal      sum = 0.;

    if (transposed)
      for (PetscInt i = k; i < count; i++) sum += factor[k * count + i] * z[i];
    else
      for (PetscInt i = 0; i <= k; i++) sum += factor[i * count + k] * z[i];
    z[k] = penalty->regular->deviation * sum;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- life ---- */

PetscErrorCode MpmPenaltyCreate(const MpmRegularization *regular, const MpmGround *ground, PetscInt first,
                                const MpmParameterRange ranges[], MpmPenalty *penalty)
{
  PetscFunctionBeginUser;
  *penalty = (MpmPenalty){.regular = regular, .first = first, .count = ground->count};
  if (regular->kind != MPM_FIELD_PRIOR) PetscFunctionReturn(FindPairs(ground, penalty));
  penalty->rows = ground->count;
  PetscCall(PetscMalloc1(ground->count, &penalty->mean));
  for (PetscInt k = 0; k < ground->count; k++) {
    penalty->mean[k] = MpmRangeTransform(&ranges[k], regular->has_mean ? regular->mean : ranges[k].start);
    MpmCheckInput(!PetscIsInfOrNanReal(penalty->mean[k]),
                  "-mpm_objective_%s_mean %g: the transform of the parameter does not take it", regular->name,
                  (double)regular->mean);
  }
  PetscCall(Factorize(ground, penalty));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPenaltyDestroy(MpmPenalty *penalty)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(penalty->pair));
  PetscCall(PetscFree(penalty->mean));
  PetscCall(PetscFree(penalty->factor));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- values and derivatives ---- */

/* The factor of the differences of the rows from n on that are of one cell, and the row after them. */
static PetscReal FactorOf(const MpmPenalty *penalty, const PetscReal t[], PetscInt n, PetscInt *end)
{
  const MpmRegularization *regular = penalty->regular;
  PetscReal                square  = PetscSqr(regular->smoothing);

  *end = n;
  do {
    square += PetscSqr(t[penalty->pair[2 * *end]] - t[penalty->pair[2 * *end + 1]]);
    ++*end;
  } while (*end < penalty->rows && penalty->pair[2 * *end] == penalty->pair[2 * n]);
  if (regular->kind == MPM_TIKHONOV) return 1. / regular->deviation;
  return 1. / PetscSqrtReal(regular->deviation * PetscSqrtReal(square));
}

PetscErrorCode MpmPenaltyEvaluate(const MpmPenalty *penalty, const PetscReal t[], PetscReal *value,
                                  PetscReal residual[])
{
  const MpmRegularization *regular = penalty->regular;

  PetscFunctionBeginUser;
  t += penalty->first;
  *value = 0.;
  if (penalty->factor) {
    for (PetscInt k = 0; k < penalty->count; k++) residual[k] = t[k] - penalty->mean[k];
    PetscCall(Solve(penalty, "N", residual));
  }
  for (PetscInt n = 0, end; !penalty->factor && n < penalty->rows; n = end) {
    const PetscReal factor = FactorOf(penalty, t, n, &end);

    for (PetscInt i = n; i < end; i++) residual[i] = factor * (t[penalty->pair[2 * i]] - t[penalty->pair[2 * i + 1]]);
    if (regular->kind == MPM_TOTAL_VARIATION)
      *value += 1. / PetscSqr(factor * regular->deviation) - regular->smoothing / regular->deviation;
  }
  for (PetscInt n = 0; n < penalty->rows && regular->kind != MPM_TOTAL_VARIATION; n++)
    *value += 0.5 * PetscSqr(residual[n]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPenaltyPull(const MpmPenalty *penalty, const PetscReal t[], const PetscReal residual[],
                              PetscReal gradient[])
{
  PetscReal *y;

  PetscFunctionBeginUser;
  t += penalty->first;
  gradient += penalty->first;
  for (PetscInt n = 0, end; !penalty->factor && n < penalty->rows; n = end) {
    const PetscReal factor = FactorOf(penalty, t, n, &end);

    for (PetscInt i = n; i < end; i++) {
      gradient[penalty->pair[2 * i]] += factor * residual[i];
      gradient[penalty->pair[2 * i + 1]] -= factor * residual[i];
    }
  }
  if (!penalty->factor) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(penalty->count, &y));
  PetscCall(PetscArraycpy(y, residual, penalty->count));
  PetscCall(Solve(penalty, "T", y));
  for (PetscInt k = 0; k < penalty->count; k++) gradient[k] += y[k];
  PetscCall(PetscFree(y));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPenaltyFillJacobian(const MpmPenalty *penalty, const PetscReal t[], PetscInt columns,
                                      PetscReal jacobian[])
{
  PetscReal *y;

  PetscFunctionBeginUser;
  t += penalty->first;
  jacobian += penalty->first;
  for (PetscInt n = 0, end; !penalty->factor && n < penalty->rows; n = end) {
    const PetscReal factor = FactorOf(penalty, t, n, &end);

    for (PetscInt i = n; i < end; i++) {
      jacobian[i * columns + penalty->pair[2 * i]]     = factor;
      jacobian[i * columns + penalty->pair[2 * i + 1]] = -factor;
    }
  }
  if (!penalty->factor) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(penalty->count, &y));
  for (PetscInt k = 0; k < penalty->count; k++) {
    PetscCall(PetscArrayzero(y, penalty->count));
    y[k] = 1.;
    PetscCall(Solve(penalty, "N", y));
    for (PetscInt i = 0; i < penalty->count; i++) jacobian[i * columns + k] = y[i];
  }
  PetscCall(PetscFree(y));
  PetscFunctionReturn(PETSC_SUCCESS);
}

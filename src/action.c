/*
  The Jacobian's action on a displacement, without a matrix: each point takes one direction through the kernel, or
  through its own tangent where tangents are kept. The coloured, dense and differenced Jacobians are made of actions on
  seeds.
*/
#include "sum.h"

/* Central differences: the step that balances truncation and rounding for inputs of order one. */
#define FD_STEP 6e-6

/* Values that a point keeps: its tangent, and the change of its cell's mean with its inputs. */
static PetscInt StoredSize(const MpmLayout *layout)
{
  const PetscInt all = layout->inputs + layout->means;

  return all * all + layout->means * layout->inputs;
}

PetscErrorCode MpmActionCreate(const MpmSum *sum, PetscBool stored, MpmAction *action)
{
  const PetscInt n = PetscPowInt(sum->space->width, sum->space->dim), bs = sum->layout->block;

  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(action, sizeof(*action)));
  action->sum = sum;
  PetscCall(PetscMalloc1((sum->space->local * bs), &action->u));
  PetscCall(PetscMalloc1((n * (3 * bs + MPM_MAX_DIM + 1)), &action->storage));
  action->values  = action->storage;
  action->dvalues = action->values + n * bs;
  action->force   = action->dvalues + n * bs;
  for (PetscInt b = 0; b <= MPM_MAX_DIM; b++) action->basis.basis[b] = action->force + n * (bs + b);
  if (stored)
    PetscCall(PetscMalloc1(((size_t)sum->space->point_count * (size_t)StoredSize(sum->layout)), &action->tangent));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmActionDestroy(MpmAction *action)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(action->u));
  PetscCall(PetscFree(action->storage));
  PetscCall(PetscFree(action->tangent));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Basis, inputs and the kernel's view of one point of a group whose nodal values are gathered. */
MPM_INLINE void LookAtPoint(const MpmKnown known, MpmAction *action, const MpmGroup *group, PetscInt p,
                            MpmKernelPoint *point, PetscReal input[])
{
  MpmSumInputs(known, action->sum->layout, action->values, &action->basis, input);
  MpmSumPoint(action->sum, p, point);
  MpmSumMean(action->sum, group, p, point, input);
}

/* share dm at one point */
static int MeanByInput(const MpmAction *action, PetscInt p, const MpmKernelPoint *point, const PetscReal input[],
                       PetscReal dm[])
{
  PetscReal m;

  if (action->sum->layout->kernel->mean(point, input, &m, dm)) return 1;
  for (PetscInt k = 0; k < action->sum->layout->inputs; k++) dm[k] *= action->sum->space->share[p];
  return 0;
}

/* Keeps the tangents of one group's points. */
MPM_INLINE PetscErrorCode StoreGroup(const MpmKnown known, MpmAction *action, const MpmGroup *group, PetscBool weights,
                                     PetscInt *failed)
{
  const MpmSum  *sum  = action->sum;
  const PetscInt size = StoredSize(sum->layout), all = known.inputs + sum->layout->means;

  MpmSumGather(known, sum, group, action->u, action->values);
  for (PetscInt s = group->point_begin; s < group->point_end; s++) {
    const PetscInt p       = sum->space->order[s];
    PetscReal     *tangent = &action->tangent[s * size];
    MpmKernelPoint point;
    PetscReal      input[MPM_MAX_INPUTS], flux[MPM_MAX_INPUTS];

    MpmSumFetch(known, sum, s);
    MpmSumBasis(known, sum->space, p, weights, &action->basis);
    LookAtPoint(known, action, group, p, &point, input);
    if (sum->layout->kernel->tangent(&point, input, flux, tangent)) (*failed)++;
    else if (sum->layout->means && MeanByInput(action, p, &point, input, &tangent[all * all])) (*failed)++;
  }
  return PETSC_SUCCESS;
}

PetscErrorCode MpmActionSetState(MpmAction *action, const PetscReal u[], PetscInt *failed)
{
  const MpmSum   *sum     = action->sum;
  const PetscBool weights = MpmLayoutUsesValues(sum->layout);

  PetscFunctionBeginUser;
  *failed = 0;
  PetscCall(PetscArraycpy(action->u, u, sum->space->local * sum->layout->block));
  PetscCall(MpmMeanEvaluate(sum, action->u, failed));
  for (PetscInt g = 0; action->tangent && g < sum->space->group_count; g++) {
    const MpmGroup *group = &sum->space->groups[g];

    MPM_DISPATCH(sum->layout, group, StoreGroup, action, group, weights, failed);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Derivative of the flux along dinput, by duals or by central differences. */
static int Direction(const MpmAction *action, const MpmKernelPoint *point, const PetscReal input[],
                     const PetscReal dinput[], PetscReal dflux[])
{
  const MpmKernelSet *kernel = action->sum->layout->kernel;
  const PetscInt      N      = action->sum->layout->inputs + action->sum->layout->means;
  PetscReal flux[MPM_MAX_INPUTS], forward[MPM_MAX_INPUTS], backward[MPM_MAX_INPUTS], shifted[MPM_MAX_INPUTS], size = 0.;

  if (!action->differences) return kernel->direction(point, input, dinput, flux, dflux);
  for (PetscInt k = 0; k < N; k++) size = PetscMax(size, PetscAbsReal(dinput[k]));
  for (PetscInt k = 0; k < N; k++) dflux[k] = 0.;
  if (size == 0.) return 0;
  for (PetscInt k = 0; k < N; k++) shifted[k] = input[k] + FD_STEP * dinput[k] / size;
  if (kernel->residual(point, shifted, forward)) return 1;
  for (PetscInt k = 0; k < N; k++) shifted[k] = input[k] - FD_STEP * dinput[k] / size;
  if (kernel->residual(point, shifted, backward)) return 1;
  for (PetscInt k = 0; k < N; k++) dflux[k] = (forward[k] - backward[k]) * size / (2. * FD_STEP);
  return 0;
}

/* The three sweeps over a unit with a mean; without one only the middle sweep is made. */
typedef enum { SWEEP_MEAN, SWEEP_FLUX, SWEEP_MEAN_FLUX } Sweep;

/* What a unit's sweeps hand on: the change of the mean, and of the flux conjugate to it. */
typedef struct {
  PetscReal dmean, dmean_flux;
} MeanChange;

/* dflux of one point in the sweep; non-zero where it has no answer. */
MPM_INLINE int SweepPoint(const MpmKnown known, MpmAction *action, const MpmGroup *group, PetscInt s, Sweep sweep,
                          PetscReal dinput[], MeanChange *change, PetscReal dflux[])
{
  const MpmSum    *sum = action->sum;
  const PetscInt   N = known.inputs, means = sum->layout->means, all = N + means, p = sum->space->order[s];
  const PetscReal *stored = action->tangent ? &action->tangent[s * StoredSize(sum->layout)] : NULL;
  MpmKernelPoint   point;
  PetscReal        input[MPM_MAX_INPUTS], dm[MPM_MAX_INPUTS];

  if (!stored) LookAtPoint(known, action, group, p, &point, input);
  if (sweep != SWEEP_FLUX) {
    if (stored) {
      for (PetscInt k = 0; k < N; k++) dm[k] = stored[all * all + k];
    } else if (MeanByInput(action, p, &point, input, dm)) return 1;
    if (sweep == SWEEP_MEAN) {
      for (PetscInt k = 0; k < N; k++) change->dmean += dm[k] * dinput[k];
    } else {
      for (PetscInt k = 0; k < N; k++) dflux[k] = change->dmean_flux * dm[k];
    }
    return 0;
  }
  if (means) dinput[N] = change->dmean;
  if (!stored) {
    if (Direction(action, &point, input, dinput, dflux)) return 1;
  } else {
    for (PetscInt k = 0; k < all; k++) {
      PetscReal sum_k = 0.;

      for (PetscInt l = 0; l < all; l++) sum_k += stored[k * all + l] * dinput[l];
      dflux[k] = sum_k;
    }
  }
  if (means) change->dmean_flux += dflux[N];
  return 0;
}

/* One sweep over a group's points. */
MPM_INLINE PetscErrorCode SweepGroup(const MpmKnown known, MpmAction *action, const MpmGroup *group, PetscBool weights,
                                     Sweep sweep, const PetscReal du[], MeanChange *change, PetscReal y[],
                                     PetscInt *failed)
{
  const MpmSum *sum = action->sum;

  if (!action->tangent) MpmSumGather(known, sum, group, action->u, action->values);
  MpmSumGather(known, sum, group, du, action->dvalues);
  for (PetscInt k = 0; k < known.n * known.block; k++) action->force[k] = 0.;
  for (PetscInt s = group->point_begin; s < group->point_end; s++) {
    PetscReal dinput[MPM_MAX_INPUTS], dflux[MPM_MAX_INPUTS];

    MpmSumFetch(known, sum, s);
    MpmSumBasis(known, sum->space, sum->space->order[s], weights, &action->basis);
    MpmSumInputs(known, sum->layout, action->dvalues, &action->basis, dinput);
    if (SweepPoint(known, action, group, s, sweep, dinput, change, dflux)) (*failed)++;
    else if (sweep != SWEEP_MEAN) MpmSumAddFlux(known, sum->layout, &action->basis, dflux, action->force);
  }
  if (sweep != SWEEP_MEAN) MpmSumScatter(known, sum, group, action->force, y);
  return PETSC_SUCCESS;
}

PetscErrorCode MpmActionApplyUnit(MpmAction *action, PetscInt unit, const PetscReal du[], PetscReal y[],
                                  PetscInt *failed)
{
  const MpmSum   *sum     = action->sum;
  const PetscBool weights = MpmLayoutUsesValues(sum->layout);
  const MpmCell   groups  = MpmUnitGroups(sum, unit);
  const Sweep     last    = sum->layout->means ? SWEEP_MEAN_FLUX : SWEEP_FLUX;
  MeanChange      change  = {0., 0.};

  PetscFunctionBeginUser;
  for (int sweep = sum->layout->means ? SWEEP_MEAN : SWEEP_FLUX; sweep <= (int)last; sweep++) {
    for (PetscInt g = groups.group_begin; g < groups.group_end; g++) {
      const MpmGroup *group = &sum->space->groups[g];

      MPM_DISPATCH(sum->layout, group, SweepGroup, action, group, weights, (Sweep)sweep, du, &change, y, failed);
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmActionApply(MpmAction *action, const PetscReal du[], PetscReal y[], PetscInt *failed)
{
  PetscFunctionBeginUser;
  *failed = 0;
  for (PetscInt unit = 0; unit < MpmUnitCount(action->sum); unit++)
    PetscCall(MpmActionApplyUnit(action, unit, du, y, failed));
  PetscCall(MpmGhostResidual(action->sum, du, y));
  MpmContactsApply(action->sum, action->u, du, y);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  The Jacobian's action on a displacement, without a matrix: each point takes one direction through the kernel, or
  through its own tangent where tangents are kept. The coloured, dense and differenced Jacobians are made of actions on
  seeds.
*/
#include "space/kernel_point.h"
#include "space/unit.h"
#include "assembly/terms.h"
#include "points/action.h"
#include "points/point_difference.h"
#include "points/point_term.h"

/* Central differences: the step that balances truncation and rounding for inputs of order one. */
#define FD_STEP 6e-6

/* True where all laws of this rank's points have symmetric tangents. */
static PetscBool LawsAreSymmetric(const MpmSum *sum)
{
  for (PetscInt p = 0; p < sum->points->count; p++)
    if (!(sum->materials[sum->points->material[p]].info.traits & MPM_LAW_SYMMETRIC)) return PETSC_FALSE;
  return PETSC_TRUE;
}

PetscErrorCode MpmActionCreate(const MpmTerms *terms, const MpmSum *sum, PetscBool stored, PetscBool single,
                               MpmAction *action)
{
  const PetscInt n = PetscPowInt(sum->space->width, sum->space->dim), bs = sum->block;

  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(action, sizeof(*action)));
  action->sum    = sum;
  action->terms  = terms;
  action->single = single;
  PetscCall(PetscMalloc1((sum->space->local * bs), &action->u));
  PetscCall(PetscMalloc1((n * (3 * bs + MpmBasisCount(sum->space))), &action->storage));
  action->values  = action->storage;
  action->dvalues = action->values + n * bs;
  action->force   = action->dvalues + n * bs;
  MpmBasisPlace(sum->space, n, action->force + n * bs, &action->basis);
  if (sum->space->cells.spread) {
    PetscCall(MpmSpreadWorkCreate(sum, PETSC_TRUE, &action->spread));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (stored && MpmFactoredServes(sum))
    PetscCall(MpmFactoredCreate(sum, LawsAreSymmetric(sum), single, &action->factored));
  else if (stored)
    PetscCall(
      PetscMalloc1(((size_t)sum->space->point_count * (size_t)MpmTangentSize(sum->layout) + 1), &action->tangent));
  PetscCall(MpmCellWorkCreate(sum, &action->cell));
  if (sum->layout->means) PetscCall(PetscMalloc1(sum->space->point_count, &action->mean_flux));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmActionDestroy(MpmAction *action)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(action->u));
  PetscCall(PetscFree(action->storage));
  PetscCall(PetscFree(action->tangent));
  PetscCall(MpmFactoredDestroy(&action->factored));
  PetscCall(PetscFree(action->mean_flux));
  PetscCall(MpmCellWorkDestroy(&action->cell));
  if (action->spread.sum) PetscCall(MpmSpreadWorkDestroy(&action->spread));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* y = A x */
MPM_INLINE void Times(PetscInt n, const PetscReal A[], const PetscReal x[], PetscReal y[])
{
  for (PetscInt k = 0; k < n; k++) {
    PetscReal sum = 0.;

    for (PetscInt l = 0; l < n; l++) sum += A[k * n + l] * x[l];
    y[k] = sum;
  }
}

/* y = A^T x */
MPM_INLINE void TransposeTimes(PetscInt n, const PetscReal A[], const PetscReal x[], PetscReal y[])
{
  for (PetscInt l = 0; l < n; l++) y[l] = 0.;
  for (PetscInt k = 0; k < n; k++)
    for (PetscInt l = 0; l < n; l++) y[l] += A[k * n + l] * x[k];
}

/* Keeps the tangents of one group's points; `halves` becomes false where one of them is not symmetric. */
MPM_INLINE PetscErrorCode StoreGroup(const MpmKnown known, MpmAction *action, const MpmGroup *group, PetscBool *halves,
                                     PetscInt *failed)
{
  const MpmSum   *sum     = action->sum;
  const PetscBool weights = MpmLayoutUsesValues(sum->layout);

  MpmSumGather(known, sum, group, action->u, action->values);
  for (PetscInt s = group->point_begin; s < group->point_end; s++) {
    const PetscInt p = sum->space->order[s];
    MpmKernelPoint point;
    PetscReal  input[MPM_MAX_INPUTS], flux[MPM_MAX_INPUTS], here[MPM_MAX_DIM * MPM_MAX_DIM * MPM_MAX_DIM * MPM_MAX_DIM];
    PetscReal *tangent = action->factored ? here : &action->tangent[s * MpmTangentSize(sum->layout)];

    MpmSumFetch(known, sum, s);
    MpmSumBasis(known, sum->space, p, weights, &action->basis);
    MpmSumInputs(known, sum->layout, action->values, &action->basis, input);
    MpmSumPoint(sum, p, &point);
    if (sum->layout->kernel->tangent(&point, input, flux, tangent)) (*failed)++;
    else if (action->factored && !MpmFactoredSetTangent(action->factored, s, tangent)) *halves = PETSC_FALSE;
  }
  return PETSC_SUCCESS;
}

/* Keeps the tangents of a cell's points, and the flux conjugate to its mean at each. */
static PetscErrorCode StoreCell(MpmAction *action, PetscInt c, PetscInt *failed)
{
  const MpmCell *cell = &action->sum->space->cells.at[c];
  const PetscInt size = MpmTangentSize(action->sum->layout), begin = MpmCellBegin(action->sum, cell);
  const MpmSum  *sum = action->sum;

  PetscFunctionBeginUser;
  if (action->tangent) PetscCall(MpmCellTangent(sum, cell, action->u, &action->cell, failed));
  else PetscCall(MpmCellResidual(sum, cell, action->u, NULL, &action->cell, failed));
  for (PetscInt s = begin; s < MpmCellEnd(sum, cell); s++)
    action->mean_flux[s] = MpmModesAt(&sum->space->cells, sum->space->order[s], action->cell.mean_flux);
  for (PetscInt s = begin; action->tangent && s < MpmCellEnd(sum, cell); s++)
    PetscCall(PetscArraycpy(&action->tangent[s * size], action->cell.point[s - begin].tangent.by_input, size));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Keeps the tangents of all points without means. */
static PetscErrorCode StorePoints(MpmAction *action, PetscBool *halves, PetscInt *failed)
{
  const MpmSum *sum = action->sum;

  PetscFunctionBeginUser;
  for (PetscInt g = 0; g < sum->space->group_count; g++) {
    const MpmGroup *group = &sum->space->groups[g];

    MPM_DISPATCH(sum->layout, group, StoreGroup, action, group, halves, failed);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmActionSetState(MpmAction *action, const PetscReal u[], PetscInt *failed)
{
  const MpmSum *sum    = action->sum;
  PetscBool     halves = PETSC_TRUE;

  PetscFunctionBeginUser;
  *failed = 0;
  PetscCall(PetscArraycpy(action->u, u, sum->space->local * sum->block));
  if (action->spread.sum) PetscFunctionReturn(MpmSpreadEvaluate(&action->spread, u, NULL, failed));
  if (sum->layout->means) {
    for (PetscInt c = 0; c < sum->space->cells.count; c++) PetscCall(StoreCell(action, c, failed));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (!action->tangent && !action->factored) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(StorePoints(action, &halves, failed));
  if (!halves) { /* a law with another tangent than that of its potential */
    *failed = 0;
    PetscCall(MpmFactoredDestroy(&action->factored));
    PetscCall(MpmFactoredCreate(sum, PETSC_FALSE, action->single, &action->factored));
    PetscCall(StorePoints(action, &halves, failed));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The flux at an input; f: flux conjugate to the mean at this point. */
static int WholeFlux(const MpmLayout *layout, const MpmKernelPoint *point, const PetscReal input[], PetscReal f,
                     PetscReal flux[])
{
  PetscReal m, dm[MPM_MAX_INPUTS];

  if (layout->kernel->residual(point, input, flux)) return 1;
  if (!layout->means) return 0;
  if (layout->kernel->mean(point, input, &m, dm, NULL)) return 1;
  for (PetscInt k = 0; k < layout->input.count; k++) flux[k] += f * dm[k];
  return 0;
}

int MpmPointDifference(const MpmLayout *layout, const MpmKernelPoint *point, const PetscReal input[],
                       const PetscReal dinput[], PetscReal f, PetscReal dflux[])
{
  const PetscInt N = layout->input.count + layout->means;
  PetscReal      forward[MPM_MAX_INPUTS], backward[MPM_MAX_INPUTS], shifted[MPM_MAX_INPUTS], size = 0.;

  for (PetscInt k = 0; k < N; k++) size = PetscMax(size, PetscAbsReal(dinput[k]));
  for (PetscInt k = 0; k < N; k++) dflux[k] = 0.;
  if (size == 0.) return 0;
  for (PetscInt k = 0; k < N; k++) shifted[k] = input[k] + FD_STEP * dinput[k] / size;
  if (WholeFlux(layout, point, shifted, f, forward)) return 1;
  for (PetscInt k = 0; k < N; k++) shifted[k] = input[k] - FD_STEP * dinput[k] / size;
  if (WholeFlux(layout, point, shifted, f, backward)) return 1;
  for (PetscInt k = 0; k < N; k++) dflux[k] = (forward[k] - backward[k]) * size / (2. * FD_STEP);
  return 0;
}

/* The action on the points of one group; `transposed`: from kept tangents. */
MPM_INLINE PetscErrorCode ApplyGroup(const MpmKnown known, MpmAction *action, const MpmGroup *group,
                                     PetscBool transposed, const PetscReal du[], PetscReal y[], PetscInt *failed)
{
  const MpmSum   *sum     = action->sum;
  const PetscInt  N       = known.inputs;
  const PetscBool weights = MpmLayoutUsesValues(sum->layout);

  if (!action->tangent) MpmSumGather(known, sum, group, action->u, action->values);
  MpmSumGather(known, sum, group, du, action->dvalues);
  for (PetscInt k = 0; k < known.n * known.block; k++) action->force[k] = 0.;
  for (PetscInt s = group->point_begin; s < group->point_end; s++) {
    const PetscInt p = sum->space->order[s];
    PetscReal      input[MPM_MAX_INPUTS], dinput[MPM_MAX_INPUTS], dflux[MPM_MAX_INPUTS];

    MpmSumFetch(known, sum, s);
    MpmSumBasis(known, sum->space, p, weights, &action->basis);
    MpmSumInputs(known, sum->layout, action->dvalues, &action->basis, dinput);
    if (transposed) TransposeTimes(N, &action->tangent[s * N * N], dinput, dflux);
    else if (action->tangent) Times(N, &action->tangent[s * N * N], dinput, dflux);
    else {
      MpmKernelPoint point;
      PetscReal      flux[MPM_MAX_INPUTS];

      MpmSumInputs(known, sum->layout, action->values, &action->basis, input);
      MpmSumPoint(sum, p, &point);
      if (action->differences ? MpmPointDifference(sum->layout, &point, input, dinput, 0., dflux)
                              : sum->layout->kernel->direction(&point, input, dinput, flux, dflux)) {
        (*failed)++;
        continue;
      }
    }
    MpmSumAddFlux(known, sum->layout, &action->basis, dflux, action->force);
  }
  MpmSumScatter(known, sum, group, action->force, y);
  return PETSC_SUCCESS;
}

/* The tangent of the point at place s of the order, of a cell: kept, or as far as it is there. */
MPM_INLINE MpmTangent TangentOf(const PetscInt N, const MpmAction *action, PetscBool transposed, PetscInt s)
{
  MpmTangent tangent = action->tangent ? MpmTangentAt(N, &action->tangent[s * MpmTangentSize(action->sum->layout)])
                                       : action->cell.point[s - action->cell.begin].tangent;
  PetscReal *by_mean = tangent.by_mean;

  if (!transposed) return tangent;
  tangent.by_mean = tangent.of_mean;
  tangent.of_mean = by_mean;
  return tangent;
}

/*
  The change of a cell point's fluxes, that of the mean's flux f last, without the latter's effect on the others. With

    J = sum A + b M^T + M o^T + sigma M M^T ,

  b the fluxes' derivatives by the mean, o those of its flux by the inputs and M those of the mean, the transposed
  action exchanges b and o.
*/
MPM_INLINE void ChangeByTangent(const PetscInt N, PetscBool transposed, const MpmTangent *tangent,
                                const PetscReal dinput[], PetscReal dflux[])
{
  if (transposed) TransposeTimes(N, tangent->by_input, dinput, dflux);
  else Times(N, tangent->by_input, dinput, dflux);
  dflux[N] = tangent->second[0] * dinput[N];
  for (PetscInt k = 0; k < N; k++) dflux[k] += tangent->by_mean[k] * dinput[N];
  for (PetscInt k = 0; k < N; k++) dflux[N] += tangent->of_mean[k] * dinput[k];
}

/* The change without a tangent; f: flux of the mean at this point. */
static int ChangeByKernel(const MpmAction *action, PetscReal f, const MpmCellPoint *at)
{
  const MpmLayout *layout = action->sum->layout;
  const PetscInt   N      = layout->input.count;
  PetscReal        flux[MPM_MAX_INPUTS];

  if (action->differences) return MpmPointDifference(layout, &at->point, at->input, at->dinput, f, at->flux);
  if (layout->kernel->direction(&at->point, at->input, at->dinput, flux, at->flux)) return 1;
  for (PetscInt k = 0; k < N; k++)
    for (PetscInt l = 0; l < N; l++) at->flux[k] += f * at->ddm[k * N + l] * at->dinput[l];
  return 0;
}

/* The change of a cell's mean from that of its points' inputs, of all fluxes, and the effect of the mean's flux on
   them. */
MPM_INLINE PetscErrorCode ChangeCell(const PetscInt N, const MpmAction *action, PetscInt c, PetscBool transposed,
                                     PetscInt *failed)
{
  const MpmCellWork *work  = &action->cell;
  const PetscInt    *order = action->sum->space->order;
  const MpmCells    *cells = &action->sum->space->cells;
  const PetscInt     begin = work->begin, end = MpmCellEnd(action->sum, &cells->at[c]);
  PetscReal          dmean[MPM_MAX_MODES] = {0.}, dmean_flux[MPM_MAX_MODES] = {0.};

  for (PetscInt s = begin; s < end; s++) {
    const MpmTangent tangent = TangentOf(N, action, transposed, s);
    PetscReal        dm      = 0.;

    for (PetscInt k = 0; k < N; k++) dm += tangent.dm[k] * work->point[s - begin].dinput[k];
    MpmModesAdd(cells, order[s], dm, dmean);
  }
  for (PetscInt s = begin; s < end; s++) {
    const MpmTangent    tangent = TangentOf(N, action, transposed, s);
    const MpmCellPoint *at      = &work->point[s - begin];

    at->dinput[N] = MpmModesAt(cells, order[s], dmean);
    if (action->tangent) ChangeByTangent(N, transposed, &tangent, at->dinput, at->flux);
    else if (ChangeByKernel(action, action->mean_flux[s] * cells->share[order[s]], at)) {
      (*failed)++;
      for (PetscInt k = 0; k <= N; k++) at->flux[k] = 0.;
    }
    MpmModesAdd(cells, order[s], at->flux[N], dmean_flux);
  }
  for (PetscInt s = begin; s < end; s++) {
    const MpmTangent tangent = TangentOf(N, action, transposed, s);

    const PetscReal df = MpmModesAt(cells, order[s], dmean_flux);

    for (PetscInt k = 0; k < N; k++) work->point[s - begin].flux[k] += df * tangent.dm[k];
  }
  return PETSC_SUCCESS;
}

/* The action on the points of one cell. */
static PetscErrorCode ApplyCell(MpmAction *action, PetscInt c, PetscBool transposed, const PetscReal du[],
                                PetscReal y[], PetscInt *failed)
{
  const MpmSum  *sum  = action->sum;
  const MpmCell *cell = &sum->space->cells.at[c];

  PetscFunctionBeginUser;
  PetscCall(MpmCellInputs(sum, cell, action->tangent ? NULL : action->u, du, &action->cell));
  if (!action->tangent) PetscCall(MpmCellMean(sum, cell, PETSC_TRUE, &action->cell, failed));
  MPM_DISPATCH_INPUTS(sum->layout, ChangeCell, action, c, transposed, failed);
  PetscCall(MpmCellScatter(sum, cell, &action->cell, y));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The action, or its transpose, on one unit of the points. */
static PetscErrorCode ActUnit(MpmAction *action, PetscInt unit, PetscBool transposed, const PetscReal du[],
                              PetscReal y[], PetscInt *failed)
{
  const MpmSum   *sum   = action->sum;
  const MpmGroup *group = &sum->space->groups[unit];

  PetscFunctionBeginUser;
  if (sum->layout->means) PetscCall(ApplyCell(action, unit, transposed, du, y, failed));
  else MPM_DISPATCH(sum->layout, group, ApplyGroup, action, group, transposed, du, y, failed);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmActionApplyUnit(MpmAction *action, PetscInt unit, const PetscReal du[], PetscReal y[],
                                  PetscInt *failed)
{
  return ActUnit(action, unit, PETSC_FALSE, du, y, failed);
}

/* The action, or its transpose, on all points. */
static PetscErrorCode ActPoints(MpmAction *action, PetscBool transposed, const PetscReal du[], PetscReal y[],
                                PetscInt *failed)
{
  PetscFunctionBeginUser;
  if (action->spread.sum)
    PetscFunctionReturn(MpmSpreadApply(&action->spread, transposed, action->differences, du, y, failed));
  if (action->factored) {
    MpmFactoredApply(action->factored, transposed, du, y);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  for (PetscInt unit = 0; unit < MpmUnitCount(action->sum); unit++)
    PetscCall(ActUnit(action, unit, transposed, du, y, failed));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmActionApplyPoints(MpmAction *action, const PetscReal du[], PetscReal y[], PetscInt *failed)
{
  return ActPoints(action, PETSC_FALSE, du, y, failed);
}

PetscErrorCode MpmActionApply(MpmAction *action, const PetscReal du[], PetscReal y[], PetscInt *failed)
{
  PetscFunctionBeginUser;
  *failed = 0;
  PetscCall(ActPoints(action, PETSC_FALSE, du, y, failed));
  for (PetscInt k = 0; k < action->terms->count; k++)
    if (!action->terms->term[k]->points) PetscCall(MpmTermsApplyOne(action->terms, k, action->sum, action->u, du, y));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmActionTranspose(MpmAction *action, const PetscReal v[], PetscReal y[], PetscInt *failed)
{
  const MpmTerms *terms = action->terms;
  const PetscBool kept  = (PetscBool)(action->tangent || action->factored || action->spread.sum);

  PetscFunctionBeginUser;
  *failed = 0;
  if (kept) PetscCall(ActPoints(action, PETSC_TRUE, v, y, failed));
  for (PetscInt k = 0; k < terms->count; k++)
    if (!terms->term[k]->points || !kept) PetscCall(MpmTermsTransposeOne(terms, k, action->sum, action->u, v, y));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmActionDiagonal(const MpmAction *action, PetscReal blocks[], PetscInt *failed)
{
  const MpmTerms *terms = action->terms;

  PetscFunctionBeginUser;
  *failed = 0;
  if (action->factored) MpmFactoredDiagonal(action->factored, blocks);
  for (PetscInt k = 0; k < terms->count; k++)
    if (!terms->term[k]->points || !action->factored)
      PetscCall(MpmTermsDiagonalOne(terms, k, action->sum, action->u, blocks, failed));
  PetscFunctionReturn(PETSC_SUCCESS);
}

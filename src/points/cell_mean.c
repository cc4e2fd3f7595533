/*
  Means over cells: services of the engine for a kernel that averages a scalar m of its points.

    m_bar = sum_p w_p m_p ,   w_p = V_p / sum_q V_q over the points whose centres lie in the cell

  V_p is the volume at the step's start. All points of a cell belong to one rank, so nothing is sent. With f the flux
  conjugate to m_bar, summed over the cell, the work f delta m_bar adds f w_p dm_p to the fluxes of each point, and f
  w_p ddm_p to their derivatives. The passes over a cell make m_bar, then fluxes and f, then these additions.

  Elements of order p take polynomials of degree p - 1 in place of one mean (mean_modes.c): with values phi_i at the
  points, a sum over the cell has one value a polynomial, and what a point takes of it is theirs at its place.
*/
#include "space/kernel_point.h"
#include "points/cell_mean.h"
#include "points/point_term.h"
#include "points/spread_mean.h"

/* The box that holds the nodes of the groups of a cell. */
static void BoxOfGroups(const MpmSpace *space, const MpmCell *cell, MpmGroup *box)
{
  *box             = space->groups[cell->group_begin];
  box->point_begin = box->point_end = 0;
  box->node_count                   = 1;
  box->holes                        = PETSC_TRUE; /* a corner that no group touches */
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    PetscInt end = 0;

    for (PetscInt g = cell->group_begin; g < cell->group_end; g++) {
      const MpmGroup *group = &space->groups[g];

      box->first[a] = PetscMin(box->first[a], group->first[a]);
      end           = PetscMax(end, group->first[a] + group->count[a]);
    }
    box->count[a] = end - box->first[a];
    box->node_count *= box->count[a];
  }
}

PetscErrorCode MpmCellsBoxes(void *ctx, const MpmRules *rules, const MpmPoints *points, MpmSpace *space)
{
  MpmGroup *boxes;

  PetscFunctionBeginUser;
  (void)ctx;
  if (rules->means == MPM_MEANS_SPREAD) PetscFunctionReturn(MpmSpreadBoxes(rules, points, space));
  space->cells.count = space->group_count ? space->groups[space->group_count - 1].cell + 1 : 0;
  PetscCall(PetscMalloc1(space->cells.count, &space->cells.at));
  for (PetscInt g = 0; g < space->group_count; g++) {
    MpmCell *cell = &space->cells.at[space->groups[g].cell];

    if (!g || space->groups[g].cell != space->groups[g - 1].cell) cell->group_begin = g;
    cell->group_end = g + 1;
  }
  for (PetscInt c = 0; c < space->cells.count; c++) space->cells.at[c].box = space->boxes.count + c;
  PetscCall(MpmSpaceAppendBoxes(space, space->cells.count, &boxes));
  for (PetscInt c = 0; c < space->cells.count; c++) BoxOfGroups(space, &space->cells.at[c], &boxes[c]);
  PetscCall(MpmModesMake(rules->grid, points, space));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmCellWorkCreate(const MpmSum *sum, MpmCellWork *work)
{
  const MpmSpace *space = sum->space;
  const PetscInt  n = PetscPowInt(space->width, space->dim), bs = sum->block, all = sum->layout->input.count + 1;
  const PetscInt  size = MpmBasisCount(space) * n + 3 * all + all * all + MpmTangentSize(sum->layout);
  PetscInt        most = 0;

  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(work, sizeof(*work)));
  if (!sum->layout->means) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt c = 0; c < space->cells.count; c++)
    most = PetscMax(most, MpmCellEnd(sum, &space->cells.at[c]) - MpmCellBegin(sum, &space->cells.at[c]));
  PetscCall(PetscMalloc5(most, &work->point, (most * size), &work->storage, (n * bs), &work->values, (n * bs),
                         &work->dvalues, (n * bs), &work->force));
  for (PetscInt k = 0; k < most; k++) {
    MpmCellPoint *at = &work->point[k];

    MpmBasisPlace(space, n, &work->storage[k * size], &at->basis);
    at->input   = &work->storage[k * size + MpmBasisCount(space) * n];
    at->dinput  = at->input + all;
    at->flux    = at->dinput + all;
    at->ddm     = at->flux + all;
    at->tangent = MpmTangentAt(sum->layout->input.count, at->ddm + all * all);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmCellWorkDestroy(MpmCellWork *work)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree5(work->point, work->storage, work->values, work->dvalues, work->force));
  PetscFunctionReturn(PETSC_SUCCESS);
}

MPM_INLINE PetscErrorCode InputsGroup(const MpmKnown known, const MpmSum *sum, const MpmGroup *group, PetscBool weights,
                                      const PetscReal u[], const PetscReal du[], MpmCellWork *work)
{
  if (u) MpmSumGather(known, sum, group, u, work->values);
  if (du) MpmSumGather(known, sum, group, du, work->dvalues);
  for (PetscInt s = group->point_begin; s < group->point_end; s++) {
    const MpmCellPoint *at = &work->point[s - work->begin];

    MpmSumFetch(known, sum, s);
    MpmSumBasis(known, sum->space, sum->space->order[s], weights, &at->basis);
    if (u) MpmSumInputs(known, sum->layout, work->values, &at->basis, at->input);
    if (du) MpmSumInputs(known, sum->layout, work->dvalues, &at->basis, at->dinput);
  }
  return PETSC_SUCCESS;
}

PetscErrorCode MpmCellInputs(const MpmSum *sum, const MpmCell *cell, const PetscReal u[], const PetscReal du[],
                             MpmCellWork *work)
{
  const PetscBool weights = MpmLayoutUsesValues(sum->layout);

  PetscFunctionBeginUser;
  work->begin = MpmCellBegin(sum, cell);
  for (PetscInt g = cell->group_begin; g < cell->group_end; g++) {
    const MpmGroup *group = &sum->space->groups[g];

    MPM_DISPATCH(sum->layout, group, InputsGroup, sum, group, weights, u, du, work);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

MPM_INLINE PetscErrorCode CellMean(const PetscInt N, const MpmSum *sum, const MpmCell *cell, PetscBool second,
                                   MpmCellWork *work, PetscInt *failed)
{
  const MpmKernelSet *kernel = sum->layout->kernel;
  const MpmCells     *cells  = &sum->space->cells;
  const PetscInt      end    = MpmCellEnd(sum, cell);
  PetscReal           mean[MPM_MAX_MODES];

  for (PetscInt i = 0; i < cells->modes; i++) mean[i] = 0.;
  for (PetscInt s = work->begin; s < end; s++) {
    MpmCellPoint   *at = &work->point[s - work->begin];
    const PetscReal w  = cells->share[sum->space->order[s]];
    PetscReal       m;

    MpmSumPoint(sum, sum->space->order[s], &at->point);
    if ((second ? kernel->mean_tangent : kernel->mean)(&at->point, at->input, &m, at->tangent.dm, at->ddm)) (*failed)++;
    MpmModesAdd(cells, sum->space->order[s], w * m, mean);
    for (PetscInt k = 0; k < N; k++) at->tangent.dm[k] *= w;
  }
  for (PetscInt s = work->begin; s < end; s++)
    work->point[s - work->begin].input[N] = MpmModesAt(cells, sum->space->order[s], mean);
  return PETSC_SUCCESS;
}

PetscErrorCode MpmCellMean(const MpmSum *sum, const MpmCell *cell, PetscBool second, MpmCellWork *work,
                           PetscInt *failed)
{
  PetscFunctionBeginUser;
  MPM_DISPATCH_INPUTS(sum->layout, CellMean, sum, cell, second, work, failed);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmCellResidual(const MpmSum *sum, const MpmCell *cell, const PetscReal u[], const MpmTrial *trial,
                               MpmCellWork *work, PetscInt *failed)
{
  const PetscInt end = MpmCellEnd(sum, cell), N = sum->layout->input.count, before = *failed;

  PetscFunctionBeginUser;
  PetscCall(MpmCellInputs(sum, cell, u, NULL, work));
  PetscCall(MpmCellMean(sum, cell, PETSC_FALSE, work, failed));
  for (PetscInt i = 0; i < sum->space->cells.modes; i++) work->mean_flux[i] = 0.;
  for (PetscInt s = work->begin; s < end && *failed == before; s++) {
    MpmCellPoint *at = &work->point[s - work->begin];

    MpmSumTrial(sum, trial, sum->space->order[s], &at->point);
    if (sum->layout->kernel->residual(&at->point, at->input, at->flux)) (*failed)++;
    MpmModesAdd(&sum->space->cells, sum->space->order[s], at->flux[N], work->mean_flux);
  }
  for (PetscInt s = work->begin; s < end && *failed == before; s++) {
    const MpmCellPoint *at = &work->point[s - work->begin];
    const PetscReal     f  = MpmModesAt(&sum->space->cells, sum->space->order[s], work->mean_flux);

    for (PetscInt k = 0; k < N; k++) at->flux[k] += f * at->tangent.dm[k];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

MPM_INLINE PetscErrorCode CellTangent(const PetscInt N, const MpmSum *sum, const MpmCell *cell, MpmCellWork *work,
                                      PetscInt *failed)
{
  const PetscInt end = MpmCellEnd(sum, cell), before = *failed;

  for (PetscInt i = 0; i < sum->space->cells.modes; i++) work->mean_flux[i] = 0.;
  for (PetscInt s = work->begin; s < end && *failed == before; s++) {
    const MpmCellPoint *at = &work->point[s - work->begin];

    if (sum->layout->kernel->tangent(&at->point, at->input, at->flux, at->tangent.by_input)) (*failed)++;
    MpmModesAdd(&sum->space->cells, sum->space->order[s], at->flux[N], work->mean_flux);
  }
  for (PetscInt s = work->begin; s < end && *failed == before; s++) {
    const MpmCellPoint *at = &work->point[s - work->begin];
    const PetscReal     f  = MpmModesAt(&sum->space->cells, sum->space->order[s], work->mean_flux);
    const PetscReal     fw = f * sum->space->cells.share[sum->space->order[s]];

    for (PetscInt k = 0; k < N; k++) at->flux[k] += f * at->tangent.dm[k];
    for (PetscInt k = 0; k < N * N; k++) at->tangent.by_input[k] += fw * at->ddm[k];
  }
  return PETSC_SUCCESS;
}

PetscErrorCode MpmCellTangent(const MpmSum *sum, const MpmCell *cell, const PetscReal u[], MpmCellWork *work,
                              PetscInt *failed)
{
  PetscFunctionBeginUser;
  PetscCall(MpmCellInputs(sum, cell, u, NULL, work));
  PetscCall(MpmCellMean(sum, cell, PETSC_TRUE, work, failed));
  MPM_DISPATCH_INPUTS(sum->layout, CellTangent, sum, cell, work, failed);
  PetscFunctionReturn(PETSC_SUCCESS);
}

MPM_INLINE PetscErrorCode ScatterGroup(const MpmKnown known, const MpmSum *sum, const MpmGroup *group,
                                       const MpmCellWork *work, PetscReal force[])
{
  for (PetscInt k = 0; k < known.n * known.block; k++) work->force[k] = 0.;
  for (PetscInt s = group->point_begin; s < group->point_end; s++) {
    const MpmCellPoint *at = &work->point[s - work->begin];

    MpmSumAddFlux(known, sum->layout, &at->basis, at->flux, work->force);
  }
  MpmSumScatter(known, sum, group, work->force, force);
  return PETSC_SUCCESS;
}

PetscErrorCode MpmCellScatter(const MpmSum *sum, const MpmCell *cell, const MpmCellWork *work, PetscReal force[])
{
  PetscFunctionBeginUser;
  for (PetscInt g = cell->group_begin; g < cell->group_end; g++) {
    const MpmGroup *group = &sum->space->groups[g];

    MPM_DISPATCH(sum->layout, group, ScatterGroup, sum, group, work, force);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

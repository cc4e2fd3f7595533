/*
  Means over cells by shares of the points' domains: F-bar whose results do not jump where a point changes its cell.

    m_bar_p = sum_c f_pc m_c ,   m_c = sum_q f_qc V_q m_q / V_c ,   V_c = sum_q f_qc V_q

  with f_pc the share of point p's domain in cell c (spread_shares.c) and V_p its volume at the step's start. With F_p
  the flux conjugate to m_bar_p the work sum_p F_p delta m_bar_p adds

    B_q dm_q ,   B_q = V_q sum_c f_qc g_c/V_c ,   g_c = sum_p f_pc F_p

  to the fluxes of each point, and B_q ddm_q to their derivatives. Where each domain lies in one cell the mean is that
  of cell_mean.c. Cells whose points belong to several ranks are summed over these.
*/
#include "space/kernel_point.h"
#include "points/point_term.h"
#include "points/spread_mean.h"

void MpmSpreadFindCells(const MpmSpace *space, const MpmGroup *group, PetscInt p, MpmSpreadCells *cells)
{
  const MpmSpread *spread = space->cells.spread;
  const PetscInt  *nodes = &space->group_nodes[group->node_offset], dim = space->dim;
  PetscInt         first[MPM_MAX_DIM] = {0, 0, 0}, count[MPM_MAX_DIM] = {1, 1, 1}, n = 0, at[MPM_MAX_DIM];
  const PetscReal *part[MPM_MAX_DIM] = {&MpmLineOne, &MpmLineOne, &MpmLineOne};

  MpmSpaceGroupAt(space, group, at);
  for (PetscInt a = 0; a < dim; a++) {
    first[a] = spread->first[p * dim + a] - at[a];
    count[a] = spread->count[p * dim + a];
    part[a]  = &spread->part[(p * dim + a) * spread->width];
  }
  for (PetscInt l = 0; l < count[2]; l++) {
    for (PetscInt j = 0; j < count[1]; j++) {
      for (PetscInt i = 0; i < count[0]; i++, n++) {
        cells->at[n]    = ((first[2] + l) * group->count[1] + first[1] + j) * group->count[0] + first[0] + i;
        cells->node[n]  = nodes[cells->at[n]];
        cells->share[n] = part[0][i] * part[1][j] * part[2][l];
      }
    }
  }
  cells->count = n;
}

PetscErrorCode MpmSpreadWorkCreate(const MpmSum *sum, PetscBool derivatives, MpmSpreadWork *work)
{
  const size_t count = (size_t)sum->space->point_count, N = (size_t)sum->layout->input.count,
               cells = (size_t)sum->space->local;

  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(work, sizeof(*work)));
  work->sum = sum;
  PetscCall(PetscMalloc4((count * (N + 1) + 1), &work->input, (count * (N + 1) + 1), &work->flux, (count * N + 1),
                         &work->dm, (count + 1), &work->back));
  PetscCall(PetscMalloc3((2 * cells + 1), &work->volume, (cells + 1), &work->mean, (cells + 1), &work->mean_flux));
  if (derivatives)
    PetscCall(
      PetscMalloc2((count * (size_t)MpmTangentSize(sum->layout) + 1), &work->tangent, (count * N * N + 1), &work->ddm));
  PetscCall(MpmWorkspaceCreate(sum, &work->work));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSpreadWorkDestroy(MpmSpreadWork *work)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree4(work->input, work->flux, work->dm, work->back));
  PetscCall(PetscFree3(work->volume, work->mean, work->mean_flux));
  PetscCall(PetscFree2(work->tangent, work->ddm));
  PetscCall(PetscFree(work->work.storage));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSpreadSum(const MpmSpace *space, PetscInt block, PetscReal sums[])
{
  PetscFunctionBeginUser;
  PetscCall(MpmSpaceAddToOwners(space, block, sums));
  PetscCall(MpmSpaceToGhosts(space, block, sums));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Inputs of one group's points, and their m; volumes and moments are added to those of the cells. */
MPM_INLINE PetscErrorCode MeanGroup(const MpmKnown known, MpmSpreadWork *work, const MpmGroup *group,
                                    const PetscReal u[], PetscReal sums[], PetscInt *failed)
{
  const MpmSum       *sum    = work->sum;
  const MpmKernelSet *kernel = sum->layout->kernel;
  const PetscInt      N      = known.inputs;
  MpmSpreadCells      cells;

  MpmSumGather(known, sum, group, u, work->work.values);
  for (PetscInt s = group->point_begin; s < group->point_end; s++) {
    const PetscInt  p      = sum->space->order[s];
    const PetscReal volume = MpmSpreadVolume(sum, p);
    PetscReal       m, *dm = &work->dm[s * N], *input = &work->input[s * (N + 1)];
    MpmKernelPoint  point;

    MpmSumFetch(known, sum, s);
    MpmSumBasis(known, sum->space, p, work->work.weights, &work->work.basis);
    MpmSumInputs(known, sum->layout, work->work.values, &work->work.basis, input);
    MpmSumPoint(sum, p, &point);
    if (work->tangent ? kernel->mean_tangent(&point, input, &m, dm, &work->ddm[s * N * N])
                      : kernel->mean(&point, input, &m, dm, NULL))
      (*failed)++;
    MpmSpreadFindCells(sum->space, group, p, &cells);
    for (PetscInt k = 0; k < cells.count; k++) {
      sums[2 * cells.node[k]] += cells.share[k] * volume;
      sums[2 * cells.node[k] + 1] += cells.share[k] * volume * m;
    }
  }
  return PETSC_SUCCESS;
}

/* The means of all cells, from sums in `volume`. */
static PetscErrorCode FinishMeans(MpmSpreadWork *work)
{
  const PetscInt local = work->sum->space->local;

  PetscFunctionBeginUser;
  PetscCall(MpmSpreadSum(work->sum->space, 2, work->volume));
  for (PetscInt i = 0; i < local; i++) {
    const PetscReal volume = work->volume[2 * i], moment = work->volume[2 * i + 1];

    work->mean[i]   = volume > 0. ? moment / volume : 0.;
    work->volume[i] = volume;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Fluxes of one group's points, with their derivatives; those of the means are added to the cells' sums. */
static PetscErrorCode FluxGroup(MpmSpreadWork *work, const MpmGroup *group, const MpmTrial *trial, PetscInt *failed)
{
  const MpmSum       *sum    = work->sum;
  const MpmKernelSet *kernel = sum->layout->kernel;
  const PetscInt      N = sum->layout->input.count, size = MpmTangentSize(sum->layout);
  MpmSpreadCells      cells;

  PetscFunctionBeginUser;
  for (PetscInt s = group->point_begin; s < group->point_end; s++) {
    PetscReal     *input = &work->input[s * (N + 1)], *flux = &work->flux[s * (N + 1)];
    MpmKernelPoint point;

    MpmSumPoint(sum, sum->space->order[s], &point);
    MpmSumTrial(sum, trial, sum->space->order[s], &point);
    MpmSpreadFindCells(sum->space, group, sum->space->order[s], &cells);
    input[N] = MpmSpreadMean(&cells, work->mean);
    if (work->tangent ? kernel->tangent(&point, input, flux, &work->tangent[s * size])
                      : kernel->residual(&point, input, flux)) {
      (*failed)++;
      PetscCall(PetscArrayzero(flux, N + 1));
      if (work->tangent) PetscCall(PetscArrayzero(&work->tangent[s * size], size));
    }
    MpmSpreadAdd(&cells, flux[N], work->mean_flux);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The contribution of the means to the fluxes of one group's points. */
static PetscErrorCode FinishGroup(MpmSpreadWork *work, const MpmGroup *group)
{
  const MpmSum  *sum = work->sum;
  const PetscInt N = sum->layout->input.count, size = MpmTangentSize(sum->layout);
  MpmSpreadCells cells;

  PetscFunctionBeginUser;
  for (PetscInt s = group->point_begin; s < group->point_end; s++) {
    MpmSpreadFindCells(sum->space, group, sum->space->order[s], &cells);
    work->back[s] = MpmSpreadVolume(sum, sum->space->order[s]) * MpmSpreadMean(&cells, work->mean_flux);
    for (PetscInt k = 0; k < N; k++) work->flux[s * (N + 1) + k] += work->back[s] * work->dm[s * N + k];
    if (!work->tangent) continue;
    const MpmTangent tangent = MpmTangentAt(N, &work->tangent[s * size]);

    for (PetscInt k = 0; k < N * N; k++) tangent.by_input[k] += work->back[s] * work->ddm[s * N * N + k];
    for (PetscInt k = 0; k < N; k++) tangent.dm[k] = work->dm[s * N + k];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSpreadEvaluate(MpmSpreadWork *work, const PetscReal u[], const MpmTrial *trial, PetscInt *failed)
{
  const MpmSum   *sum   = work->sum;
  const MpmSpace *space = sum->space;

  PetscFunctionBeginUser;
  PetscCall(PetscArrayzero(work->volume, 2 * space->local));
  PetscCall(PetscArrayzero(work->mean_flux, space->local));
  for (PetscInt g = 0; g < space->group_count; g++) {
    const MpmGroup *group = &space->groups[g];

    MPM_DISPATCH(sum->layout, group, MeanGroup, work, group, u, work->volume, failed);
  }
  PetscCall(FinishMeans(work));
  for (PetscInt g = 0; g < space->group_count; g++) PetscCall(FluxGroup(work, &space->groups[g], trial, failed));
  PetscCall(MpmSpreadSum(space, 1, work->mean_flux));
  for (PetscInt i = 0; i < space->local; i++)
    if (work->volume[i] > 0.) work->mean_flux[i] /= work->volume[i];
  for (PetscInt g = 0; g < space->group_count; g++) PetscCall(FinishGroup(work, &space->groups[g]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

MPM_INLINE PetscErrorCode ScatterGroup(const MpmKnown known, MpmSpreadWork *work, const MpmGroup *group,
                                       PetscReal force[])
{
  const MpmSum *sum = work->sum;

  for (PetscInt k = 0; k < known.n * known.block; k++) work->work.force[k] = 0.;
  for (PetscInt s = group->point_begin; s < group->point_end; s++) {
    MpmSumBasis(known, sum->space, sum->space->order[s], work->work.weights, &work->work.basis);
    MpmSumAddFlux(known, sum->layout, &work->work.basis, &work->flux[s * (known.inputs + 1)], work->work.force);
  }
  MpmSumScatter(known, sum, group, work->work.force, force);
  return PETSC_SUCCESS;
}

PetscErrorCode MpmSpreadScatter(MpmSpreadWork *work, PetscReal force[])
{
  const MpmSum *sum = work->sum;

  PetscFunctionBeginUser;
  for (PetscInt g = 0; g < sum->space->group_count; g++) {
    const MpmGroup *group = &sum->space->groups[g];

    MPM_DISPATCH(sum->layout, group, ScatterGroup, work, group, force);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

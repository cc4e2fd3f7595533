/*
  The Jacobian's action, and its transpose, where means are by shares of the points' domains.

    d m_c = sum_q f_qc V_q dm_q . dH_q / V_c ,   d m_bar_p = sum_c f_pc d m_c
    d g_c = sum_p f_pc dF_p ,   and B_q changes with d g_c as with g_c (spread_mean.c)

  The transposed action exchanges the fluxes' derivatives by the mean with those of its flux by the inputs.
*/
#include "space/kernel_point.h"
#include "points/point_difference.h"
#include "points/spread_mean.h"

/* Changes of the inputs and fluxes, by place in the order, and of the cells. */
typedef struct {
  MpmSpreadWork *work;
  PetscBool      transposed, differences;
  PetscReal     *input, *flux, *mean, *mean_flux;
} Change;

MPM_INLINE PetscErrorCode MeanGroup(const MpmKnown known, const Change *change, const MpmGroup *group,
                                    const PetscReal du[])
{
  MpmSpreadWork *work = change->work;
  const MpmSum  *sum  = work->sum;
  const PetscInt N    = known.inputs;
  MpmSpreadCells cells;

  MpmSumGather(known, sum, group, du, work->work.values);
  for (PetscInt s = group->point_begin; s < group->point_end; s++) {
    const PetscInt p      = sum->space->order[s];
    PetscReal     *dinput = &change->input[s * (N + 1)], m = 0.;

    MpmSumBasis(known, sum->space, p, work->work.weights, &work->work.basis);
    MpmSumInputs(known, sum->layout, work->work.values, &work->work.basis, dinput);
    for (PetscInt k = 0; k < N; k++) m += work->dm[s * N + k] * dinput[k];
    MpmSpreadFindCells(sum->space, group, p, &cells);
    MpmSpreadAdd(&cells, MpmSpreadVolume(sum, p) * m, change->mean);
  }
  return PETSC_SUCCESS;
}

/* The change of a point's fluxes, that of the mean's last. */
static void ChangeFlux(PetscInt N, PetscBool transposed, const MpmTangent *tangent, const PetscReal dinput[],
                       PetscReal dflux[])
{
  const PetscReal *by_mean = transposed ? tangent->of_mean : tangent->by_mean;
  const PetscReal *of_mean = transposed ? tangent->by_mean : tangent->of_mean;

  dflux[N] = tangent->second[0] * dinput[N];
  for (PetscInt k = 0; k < N; k++) {
    dflux[k] = by_mean[k] * dinput[N];
    dflux[N] += of_mean[k] * dinput[k];
    for (PetscInt l = 0; l < N; l++) dflux[k] += tangent->by_input[transposed ? l * N + k : k * N + l] * dinput[l];
  }
}

static PetscErrorCode FluxGroup(const Change *change, const MpmGroup *group, PetscInt *failed)
{
  const MpmSpreadWork *work = change->work;
  const MpmSum        *sum  = work->sum;
  const PetscInt       N    = sum->layout->input.count;
  MpmSpreadCells       cells;

  PetscFunctionBeginUser;
  for (PetscInt s = group->point_begin; s < group->point_end; s++) {
    const MpmTangent tangent = MpmTangentAt(N, &work->tangent[s * MpmTangentSize(sum->layout)]);
    const PetscInt   p       = sum->space->order[s];
    PetscReal       *dinput = &change->input[s * (N + 1)], *dflux = &change->flux[s * (N + 1)];
    MpmKernelPoint   point;

    MpmSpreadFindCells(sum->space, group, p, &cells);
    dinput[N] = MpmSpreadMean(&cells, change->mean);
    if (change->differences) {
      MpmSumPoint(sum, p, &point);
      if (MpmPointDifference(sum->layout, &point, &work->input[s * (N + 1)], dinput, work->back[s], dflux)) {
        (*failed)++;
        PetscCall(PetscArrayzero(dflux, N + 1));
      }
    } else ChangeFlux(N, change->transposed, &tangent, dinput, dflux);
    MpmSpreadAdd(&cells, dflux[N], change->mean_flux);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

MPM_INLINE PetscErrorCode ScatterGroup(const MpmKnown known, const Change *change, const MpmGroup *group, PetscReal y[])
{
  MpmSpreadWork *work = change->work;
  const MpmSum  *sum  = work->sum;
  const PetscInt N    = known.inputs;
  MpmSpreadCells cells;

  for (PetscInt k = 0; k < known.n * known.block; k++) work->work.force[k] = 0.;
  for (PetscInt s = group->point_begin; s < group->point_end; s++) {
    const PetscInt p     = sum->space->order[s];
    PetscReal     *dflux = &change->flux[s * (N + 1)], back;

    MpmSpreadFindCells(sum->space, group, p, &cells);
    back = MpmSpreadVolume(sum, p) * MpmSpreadMean(&cells, change->mean_flux);
    for (PetscInt k = 0; k < N; k++) dflux[k] += back * work->dm[s * N + k];
    MpmSumBasis(known, sum->space, p, work->work.weights, &work->work.basis);
    MpmSumAddFlux(known, sum->layout, &work->work.basis, dflux, work->work.force);
  }
  MpmSumScatter(known, sum, group, work->work.force, y);
  return PETSC_SUCCESS;
}

/* Sums over ranks, over the cells' volumes. */
static PetscErrorCode Divide(const MpmSpreadWork *work, PetscReal sums[])
{
  PetscFunctionBeginUser;
  PetscCall(MpmSpreadSum(work->sum->space, 1, sums));
  for (PetscInt i = 0; i < work->sum->space->local; i++)
    if (work->volume[i] > 0.) sums[i] /= work->volume[i];
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSpreadApply(MpmSpreadWork *work, PetscBool transposed, PetscBool differences, const PetscReal du[],
                              PetscReal y[], PetscInt *failed)
{
  const MpmSum   *sum    = work->sum;
  const MpmSpace *space  = sum->space;
  const size_t    count  = (size_t)space->point_count * (size_t)(sum->layout->input.count + 1) + 1;
  Change          change = {.work = work, .transposed = transposed, .differences = differences};

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc2(count, &change.input, count, &change.flux));
  PetscCall(PetscCalloc2((space->local + 1), &change.mean, (space->local + 1), &change.mean_flux));
  for (PetscInt g = 0; g < space->group_count; g++) {
    const MpmGroup *group = &space->groups[g];

    MPM_DISPATCH(sum->layout, group, MeanGroup, &change, group, du);
  }
  PetscCall(Divide(work, change.mean));
  for (PetscInt g = 0; g < space->group_count; g++) PetscCall(FluxGroup(&change, &space->groups[g], failed));
  PetscCall(Divide(work, change.mean_flux));
  for (PetscInt g = 0; g < space->group_count; g++) {
    const MpmGroup *group = &space->groups[g];

    MPM_DISPATCH(sum->layout, group, ScatterGroup, &change, group, y);
  }
  PetscCall(PetscFree2(change.input, change.flux));
  PetscCall(PetscFree2(change.mean, change.mean_flux));
  PetscFunctionReturn(PETSC_SUCCESS);
}

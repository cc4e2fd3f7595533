/*
  Means over cells: what a kernel that averages a scalar m of its points needs of the engine.

    m_bar = sum_p w_p m_p ,   w_p = V_p / sum_q V_q over the points whose centres lie in the cell

  V_p is the volume at the step's start. All points of a cell belong to one rank, so nothing is sent. The flux conjugate
  to m_bar is summed over the cell; a point's own share of it is the kernel's to add (mean_flux).
*/
#include "sum.h"

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

/* w_p */
static PetscErrorCode Shares(MpmSpace *space, const MpmPoints *points)
{
  const PetscInt dim = space->dim;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(space->point_count, &space->share));
  for (PetscInt c = 0; c < space->cell_count; c++) {
    const PetscInt begin = space->groups[space->cells[c].group_begin].point_begin;
    const PetscInt end   = space->groups[space->cells[c].group_end - 1].point_end;
    PetscReal      total = 0.;

    for (PetscInt s = begin; s < end; s++) {
      const PetscInt p = space->order[s];

      space->share[p] = points->volume0[p] * MpmDeterminant(dim, &points->F[p * dim * dim]);
      total += space->share[p];
    }
    for (PetscInt s = begin; s < end; s++) space->share[space->order[s]] /= total;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmMeanCells(MpmSpace *space, const MpmPoints *points)
{
  MpmGroup *boxes;

  PetscFunctionBeginUser;
  space->cell_count = space->group_count ? space->groups[space->group_count - 1].cell + 1 : 0;
  PetscCall(PetscMalloc1(space->cell_count, &space->cells));
  for (PetscInt g = 0; g < space->group_count; g++) {
    MpmCell *cell = &space->cells[space->groups[g].cell];

    if (!g || space->groups[g].cell != space->groups[g - 1].cell) cell->group_begin = g;
    cell->group_end = g + 1;
  }
  for (PetscInt c = 0; c < space->cell_count; c++) space->cells[c].box = space->box_count + c;
  PetscCall(MpmSpaceAppendBoxes(space, space->cell_count, &boxes));
  for (PetscInt c = 0; c < space->cell_count; c++) BoxOfGroups(space, &space->cells[c], &boxes[c]);
  PetscCall(Shares(space, points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* One group's part of its cell's mean or, with the mean known, of the flux conjugate to it. */
MPM_INLINE PetscErrorCode MeanGroup(const MpmKnown known, const MpmSum *sum, const MpmGroup *group, PetscBool weights,
                                    PetscBool flux_wanted, const PetscReal u[], MpmWorkspace *work, PetscInt *failed)
{
  PetscReal *total = flux_wanted ? &sum->mean.flux[group->cell] : &sum->mean.value[group->cell];

  MpmSumGather(known, sum, group, u, work->values);
  for (PetscInt s = group->point_begin; s < group->point_end; s++) {
    const PetscInt p = sum->space->order[s];
    MpmKernelPoint point;
    PetscReal      input[MPM_MAX_INPUTS], flux[MPM_MAX_INPUTS], m;

    MpmSumBasis(known, sum->space, p, weights, &work->basis);
    MpmSumInputs(known, sum->layout, work->values, &work->basis, input);
    MpmSumPoint(sum, p, &point);
    if (flux_wanted) {
      input[known.inputs] = sum->mean.value[group->cell];
      if (sum->layout->kernel->residual(&point, input, flux)) (*failed)++;
      else *total += flux[known.inputs];
    } else if (sum->layout->kernel->mean(&point, input, &m, flux)) (*failed)++;
    else *total += sum->space->share[p] * m;
  }
  return PETSC_SUCCESS;
}

PetscErrorCode MpmMeanEvaluate(const MpmSum *sum, const PetscReal u[], PetscInt *failed)
{
  const MpmSpace *space   = sum->space;
  const PetscBool weights = MpmLayoutUsesValues(sum->layout);
  MpmWorkspace    work;

  PetscFunctionBeginUser;
  if (!sum->layout->means) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscArrayzero(sum->mean.value, space->cell_count));
  PetscCall(PetscArrayzero(sum->mean.flux, space->cell_count));
  PetscCall(MpmWorkspaceCreate(sum, &work));
  for (PetscInt c = 0; c < space->cell_count; c++) {
    for (PetscInt pass = 0; pass < 2 && !*failed; pass++) {
      for (PetscInt g = space->cells[c].group_begin; g < space->cells[c].group_end; g++) {
        const MpmGroup *group = &space->groups[g];

        MPM_DISPATCH(sum->layout, group, MeanGroup, sum, group, weights, (PetscBool)(pass == 1), u, &work, failed);
      }
    }
  }
  PetscCall(PetscFree(work.storage));
  PetscFunctionReturn(PETSC_SUCCESS);
}

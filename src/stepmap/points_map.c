/*
  The points' part of a step's derivatives.

  With H = sum_i u_i grad w_i of a point's inputs and K = sum_i lam_i grad w_i, a kernel's flux q(H, F, z, p), and F'
  and z' of the step's end, a point's part of L is

    L = xbar . (x + sum_i w_i u_i) + Fbar : F' + zbar . z' - q . K

  w and grad w depend on the place x and the half-lengths l(x, F) of the domain (space/point_slopes.h), all else on H,
  F, the history z and parameters p through the kernel's sensitivity form.
*/
#include "stepmap/point_table.h"

PetscErrorCode MpmStateVectorCreate(const MpmSum *sum, const MpmPoints *points, MpmStepConstants constants,
                                    MpmPointVector *vector)
{
  const PetscInt dim = sum->space->dim, rates = sum->layout->rate.count;
  const PetscInt size[MPM_VECTOR_FIELDS] = {[MPM_VECTOR_X]        = dim,
                                            [MPM_VECTOR_F]        = points->F_size,
                                            [MPM_VECTOR_STATE]    = sum->kept.state,
                                            [MPM_VECTOR_VALUE]    = rates,
                                            [MPM_VECTOR_GRADIENT] = rates * dim,
                                            [MPM_VECTOR_OWN]      = sum->kept.own,
                                            [MPM_VECTOR_ORIGIN]   = constants.resets ? dim : 0,
                                            [MPM_VECTOR_VOLUME]   = constants.shapes ? 1 : 0,
                                            [MPM_VECTOR_LENGTH] =
                                              constants.shapes && points->domain.half_length ? dim : 0,
                                            [MPM_VECTOR_MASS] = points->mass ? 1 : 0};

  PetscFunctionBeginUser;
  PetscCall(MpmPointVectorCreate(points, size, vector));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmStepVectorCreate(const MpmStepMap *map, MpmPointVector *vector)
{
  PetscFunctionBeginUser;
  PetscCall(MpmStateVectorCreate(map->sum, map->sum->points, map->constants, vector));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- along ---- */

static PetscErrorCode PointAlong(const MpmStepMap *map, const MpmGroup *group, PetscInt p,
                                 const MpmStepDirection *direction, MpmPointWork *work)
{
  const MpmPointVector    *start     = direction->start;
  const MpmSum            *sum       = map->sum;
  const PetscReal         *dF        = &start->F[p * start->F_size];
  const MpmSceneParameter *parameter = direction->parameter < 0 ? NULL : &map->parameters->at[direction->parameter];
  PetscBool                acts      = (PetscBool)(parameter && MpmPointHasParameter(map, parameter, p));
  MpmKernelPoint           point;
  PetscReal                dinput[MPM_MAX_INPUTS];

  PetscFunctionBeginUser;
  MpmPointEnter(map, p, (PetscBool)(direction->du != NULL), work, &point);
  PetscCall(MpmPointWeightsAlong(map, group, p, start, work));
  MpmSumInputs(work->known, sum->layout, work->u, &work->slope, dinput);
  for (PetscInt k = 0; direction->du && k < work->known.inputs; k++) dinput[k] += work->other_input[k];
  if (acts) MpmPointSetDirection(map, parameter, 1., work);
  if (direction->ground) acts = MpmPointGroundEnter(map, direction->ground, p, work);
  PetscCall(MpmPointDifferentiate(map, &point,
                                  &(MpmKernelDirection){.input     = dinput,
                                                        .parameter = acts ? work->parameter : NULL,
                                                        .state_n   = &start->state[p * start->state_size],
                                                        .F_n       = dF},
                                  work));
  if (parameter && acts) MpmPointSetDirection(map, parameter, 0., work);
  if (direction->ground) MpmPointGroundForget(map, direction->ground, work);
  MpmPointVolumeAlong(start, p, work);
  MpmSumAddFlux(work->known, sum->layout, &work->slope, work->flux, work->force);
  MpmSumAddFlux(work->known, sum->layout, &work->basis, work->dflux, work->force);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPointsAlong(const MpmStepMap *map, const MpmStepDirection *direction, PetscReal residual[],
                              MpmPointVector *end)
{
  const MpmSum   *sum   = map->sum;
  const MpmSpace *space = sum->space;
  MpmPointWork    work;

  PetscFunctionBeginUser;
  if (space->cells.spread) PetscFunctionReturn(MpmSpreadAlong(map, direction, residual, end));
  if (sum->layout->means) PetscFunctionReturn(MpmCellsAlong(map, direction, residual, end));
  PetscCall(MpmPointWorkCreate(map, &work));
  for (PetscInt g = 0; g < space->group_count; g++) {
    const MpmGroup *group = &space->groups[g];

    MpmPointWorkGather(map, group, direction->du, &work);
    for (PetscInt s = group->point_begin; s < group->point_end; s++) {
      PetscCall(PointAlong(map, group, space->order[s], direction, &work));
      if (end) MpmPointEndAlong(map, space->order[s], direction, &work, end);
    }
    MpmSumScatter(work.known, sum, group, work.force, residual);
  }
  PetscCall(MpmPointWorkDestroy(&work));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- pull ---- */

PetscErrorCode MpmPointsPullSolution(const MpmStepMap *map, const MpmPointVector *end, const PetscReal lam[],
                                     PetscReal u[])
{
  const MpmSum      *sum   = map->sum;
  const MpmSpace    *space = sum->space;
  const MpmPointPull pull  = {.end = end};
  MpmPointWork       work;

  PetscFunctionBeginUser;
  if (map->table) PetscFunctionReturn(MpmTablePullSolution(map, end, lam, u));
  if (space->cells.spread) PetscFunctionReturn(MpmSpreadPullSolution(map, end, lam, u));
  if (sum->layout->means) PetscFunctionReturn(MpmCellsPullSolution(map, end, lam, u));
  PetscCall(MpmPointWorkCreate(map, &work));
  for (PetscInt g = 0; g < space->group_count; g++) {
    const MpmGroup *group = &space->groups[g];

    MpmPointWorkGather(map, group, lam, &work);
    for (PetscInt s = group->point_begin; s < group->point_end; s++) {
      const PetscInt p = space->order[s], n = work.known.n;
      PetscReal      by_input[MPM_MAX_INPUTS];
      MpmKernelPoint point;

      MpmPointEnter(map, p, PETSC_TRUE, &work, &point);
      PetscCall(MpmPointPullInputs(map, p, &point, &pull, by_input, &work));
      MpmSumAddFlux(work.known, sum->layout, &work.basis, by_input, work.force);
      for (PetscInt a = 0; a < end->dim; a++)
        MpmBasisAddForce(&work.basis, n, end->x[p * end->dim + a], &work.force[a * n]);
    }
    MpmSumScatter(work.known, sum, group, work.force, u);
  }
  PetscCall(MpmPointWorkDestroy(&work));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPointsPullStart(const MpmStepMap *map, const MpmPointVector *end, const PetscReal lam[],
                                  MpmPointVector *start, PetscReal gradient[])
{
  const MpmSum      *sum   = map->sum;
  const MpmSpace    *space = sum->space;
  const MpmPointPull pull  = {.end = end};
  MpmPointWork       work;

  PetscFunctionBeginUser;
  if (map->table) PetscFunctionReturn(MpmTablePullStart(map, end, lam, start, gradient));
  if (space->cells.spread) PetscFunctionReturn(MpmSpreadPullStart(map, end, lam, start, gradient));
  if (sum->layout->means) PetscFunctionReturn(MpmCellsPullStart(map, end, lam, start, gradient));
  PetscCall(MpmPointWorkCreate(map, &work));
  for (PetscInt g = 0; g < space->group_count; g++) {
    const MpmGroup *group = &space->groups[g];

    MpmPointWorkGather(map, group, lam, &work);
    for (PetscInt s = group->point_begin; s < group->point_end; s++) {
      const PetscInt p = space->order[s];
      PetscReal      by_input[MPM_MAX_INPUTS];
      MpmKernelPoint point;

      MpmPointEnter(map, p, PETSC_TRUE, &work, &point);
      PetscCall(MpmPointPullInputs(map, p, &point, &pull, by_input, &work));
      PetscCall(MpmPointPullKernel(map, p, &point, &pull, start, gradient, &work));
      MpmPointPullVolume(work.flux, p, &work, start);
      PetscCall(MpmPointPullWeights(map, group, p, end, by_input, start, &work));
    }
  }
  PetscCall(MpmPointWorkDestroy(&work));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  One point of a step's derivatives.
*/
#include "stepmap/point_work.h"

PetscErrorCode MpmPointWorkCreate(const MpmStepMap *map, MpmPointWork *work)
{
  const MpmSum  *sum = map->sum;
  const PetscInt n   = PetscPowInt(sum->space->width, sum->space->dim) * sum->block;

  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(work, sizeof(*work)));
  PetscCall(MpmPointSlopesCreate(sum->space, &work->slopes));
  PetscCall(MpmBasisCreate(sum->space, &work->basis));
  PetscCall(MpmBasisCreate(sum->space, &work->slope));
  PetscCall(PetscCalloc5(n, &work->u, n, &work->other, n, &work->force, (sum->kept.state + 1), &work->state,
                         (sum->kept.own + 1), &work->own));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPointWorkDestroy(MpmPointWork *work)
{
  PetscFunctionBeginUser;
  PetscCall(MpmPointSlopesDestroy(&work->slopes));
  PetscCall(MpmBasisDestroy(&work->basis));
  PetscCall(MpmBasisDestroy(&work->slope));
  PetscCall(PetscFree5(work->u, work->other, work->force, work->state, work->own));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MpmPointWorkGather(const MpmStepMap *map, const MpmGroup *group, const PetscReal other[], MpmPointWork *work)
{
  work->known = KnownGeneral(map->sum->layout, group);
  MpmSumGather(work->known, map->sum, group, map->u, work->u);
  if (other) MpmSumGather(work->known, map->sum, group, other, work->other);
  for (PetscInt k = 0; k < work->known.n * work->known.block; k++) work->force[k] = 0.;
}

void MpmPointEnter(const MpmStepMap *map, PetscInt p, PetscBool other, MpmPointWork *work, MpmKernelPoint *point)
{
  const MpmSum *sum = map->sum;

  MpmSumBasis(work->known, sum->space, p, PETSC_TRUE, &work->basis);
  MpmSumInputs(work->known, sum->layout, work->u, &work->basis, work->input);
  if (other) MpmSumInputs(work->known, sum->layout, work->other, &work->basis, work->other_input);
  MpmPointMake(map, p, work, point);
}

void MpmPointMake(const MpmStepMap *map, PetscInt p, MpmPointWork *work, MpmKernelPoint *point)
{
  MpmSumPoint(map->sum, p, point);
  point->end.state  = MpmPointStates(map, p) ? work->state : NULL;
  point->end.own    = map->sum->kept.own ? work->own : NULL;
  point->end.F      = work->F;
  point->end.stress = work->stress;
}

PetscBool MpmPointHasParameter(const MpmStepMap *map, const MpmSceneParameter *parameter, PetscInt p)
{
  return (PetscBool)(parameter->kind == MPM_OF_LAW && parameter->index == map->sum->points->material[p]);
}

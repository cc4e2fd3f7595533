/*
  Prescribed velocities in explicit steps.
*/
#include "space/space.h"
#include "space/sum.h"
#include "bc/bc.h"
#include "query/model.h"
#include "query/query.h"
#include "step/step.h"
#include "integrators/explicit.h"

void MpmExplicitPrescribe(const MpmModel model, PetscReal velocity[])
{
  const MpmConstraints *constraints = model->disc.constraints;
  const PetscInt        dim = model->disc.dim, local = model->disc.space->local;
  const PetscReal       dt = model->disc.sum->step.dt;

  if (!constraints->any) return;
  MpmFramesToUnknowns(constraints, dim, local, velocity);
  for (PetscInt k = 0; k < local * dim; k++)
    if (!MpmConstraintsFree(constraints, k)) velocity[k] = constraints->value[k] / dt;
  MpmFramesToAxes(constraints, dim, local, velocity);
}

PetscErrorCode MpmExplicitPrescribeAt(MpmModel model, PetscReal time, PetscReal velocity[])
{
  const MpmConstraints *constraints = model->disc.constraints;
  const PetscInt        dim = model->disc.dim, local = model->disc.space->local;
  const PetscReal       by =
    model->disc.sum->step.span / model->disc.sum->step.dt; /* the run's time goes on as fast; 1: it is the motion's */
  PetscReal *rate;

  PetscFunctionBeginUser;
  if (!MpmStepPrescribes(model)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1((local * dim), &rate));
  PetscCall(MpmStepPrescribedRate(model, time, 1, rate));
  MpmFramesToUnknowns(constraints, dim, local, velocity);
  for (PetscInt k = 0; k < local * dim; k++)
    if (!MpmConstraintsFree(constraints, k)) velocity[k] = by * rate[k];
  MpmFramesToAxes(constraints, dim, local, velocity);
  PetscCall(PetscFree(rate));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmExplicitPrescribeStart(MpmModel model, PetscReal velocity[])
{
  const PetscReal behind = MpmModelRelaxes(model) ? 0.5 * model->disc.sum->step.span : model->state.scheme.behind;

  PetscFunctionBeginUser;
  PetscCall(MpmExplicitPrescribeAt(model, model->state.time - behind, velocity));
  PetscFunctionReturn(PETSC_SUCCESS);
}

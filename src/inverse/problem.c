/*
  Parameters of an inverse analysis as options of a scene.
*/
#include <string.h>
#include "options/record.h"
#include "observe/results.h"
#include "sensitivity/gradient.h"
#include "inverse/problem.h"
#include "inverse/twin.h"

const MpmGround *MpmInverseField(const MpmInverseProblem *problem, PetscInt f)
{
  return problem->scene->gradient->grounds.at[f].ground;
}

PetscReal MpmInverseSquares(const MpmEvaluation *evaluation)
{
  PetscReal sum = 0.;

  for (PetscInt i = 0; i < evaluation->data.count; i++) sum += PetscSqr(evaluation->residual[i]);
  return sum;
}

static PetscErrorCode CreatePenalties(MpmInverseProblem *problem)
{
  const MpmFieldParameters *grounds = &problem->scene->gradient->grounds;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(problem->objectives->regular_count, &problem->penalty));
  for (PetscInt n = 0; n < problem->objectives->regular_count; n++) {
    const MpmRegularization *regular = &problem->objectives->regular[n];
    PetscInt                 f       = 0, first;

    while (strcmp(grounds->at[f].ground->name, regular->field)) f++;
    first = problem->ranges->numbers + grounds->at[f].first;
    PetscCall(MpmPenaltyCreate(regular, grounds->at[f].ground, first, &problem->ranges->at[first],
                               &problem->penalty[problem->penalties++]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmInverseProblemDestroy(MpmInverseProblem *problem)
{
  PetscFunctionBeginUser;
  for (PetscInt n = 0; n < problem->penalties; n++) PetscCall(MpmPenaltyDestroy(&problem->penalty[n]));
  PetscCall(PetscFree(problem->penalty));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmInverseProblemCreate(MpmModel scene, MpmInverseProblem *problem)
{
  PetscFunctionBeginUser;
  *problem = (MpmInverseProblem){.scene      = scene,
                                 .comm       = scene->comm,
                                 .prefix     = scene->scene.name.prefix,
                                 .shows      = MpmTerminalShows(scene),
                                 .objectives = &scene->gradient->objectives,
                                 .ranges     = &scene->gradient->ranges,
                                 .count      = scene->gradient->ranges.count};
  PetscCall(CreatePenalties(problem));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The values of field f. */
static PetscErrorCode SetField(const MpmInverseProblem *problem, PetscInt f, const PetscReal t[])
{
  const PetscInt   first  = problem->ranges->numbers + problem->scene->gradient->grounds.at[f].first;
  const MpmGround *ground = MpmInverseField(problem, f);
  PetscReal       *value;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(ground->count, &value));
  for (PetscInt k = 0; k < ground->count; k++) value[k] = MpmRangeValue(&problem->ranges->at[first + k], t[first + k]);
  PetscCall(MpmFieldSetValues(ground, value));
  PetscCall(PetscFree(value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmInverseSetOptions(const MpmInverseProblem *problem, const PetscReal t[])
{
  const MpmSceneParameter *parameters = problem->scene->gradient->parameters.at;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < problem->count; k++) {
    const MpmParameterRange *range = &problem->ranges->at[k];

    for (PetscInt i = 0; i < range->count; i++)
      PetscCall(MpmSceneParameterSet(&parameters[range->of[i]], (double)MpmRangeValue(range, t[k])));
  }
  for (PetscInt f = 0; f < problem->scene->gradient->grounds.count; f++) PetscCall(SetField(problem, f, t));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmInverseModelCreate(const MpmInverseProblem *problem, MpmModel *model)
{
  PetscFunctionBeginUser;
  PetscCall(MpmModelCreate(problem->scene->comm, model));
  (*model)->record->sources = problem->scene->record->sources;
  PetscFunctionReturn(PETSC_SUCCESS);
}

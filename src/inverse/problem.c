/*
  Parameters of an inverse analysis as options of a scene.
*/
#include "options/record.h"
#include "observe/results.h"
#include "sensitivity/gradient.h"
#include "inverse/problem.h"

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
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmInverseModelCreate(const MpmInverseProblem *problem, MpmModel *model)
{
  PetscFunctionBeginUser;
  PetscCall(MpmModelCreate(problem->scene->comm, model));
  (*model)->record->sources = problem->scene->record->sources;
  PetscFunctionReturn(PETSC_SUCCESS);
}

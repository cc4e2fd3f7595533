/*
  Is a scene's Jacobian symmetric, as far as its physics knows? Laws and contacts say so for themselves.
*/
#include "point/material.h"
#include "loads/load.h"
#include "time/model.h"
#include "time/scene.h"
#include "run/run.h"

PetscBool MpmSceneIsSymmetric(MpmModel model)
{
  const MpmPhysics *physics = &model->scene.physics;

  if (!physics->symmetric) return (PetscBool)((physics->traits & MPM_PHYSICS_SYMMETRIC) != 0);
  for (PetscInt l = 0; l < model->scene.loads->count && physics->taken_up; l++)
    if (model->scene.loads->at[l].type == MPM_LOAD_GRAVITY) return PETSC_FALSE; /* what points take up has weight */
  for (PetscInt m = 0; m < model->scene.materials->count; m++) {
    const MpmMaterial       *material = &model->scene.materials->at[m];
    const MpmPhysicsMaterial of       = MpmMaterialForPhysics(material, NULL, model->disc.dim);

    if (!physics->symmetric(&of, material->physics_parameter)) return PETSC_FALSE;
  }
  return PETSC_TRUE;
}

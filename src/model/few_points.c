/*
  Warning of bodies with too few points for the scene's shape.
*/
#include "grid/shape.h"
#include "particles/body.h"
#include "query/model.h"
#include "observe/results.h"
#include "model/build.h"

PetscErrorCode MpmModelWarnFewPoints(MpmModel model)
{
  const MpmShapeType shape = model->scene.shape.type;

  PetscFunctionBeginUser;
  for (PetscInt b = 0; MpmShapeOrder(shape) > 1 && b < model->scene.bodies->count; b++) {
    const PetscReal spacing = MpmBodySpacing(model->scene.bodies->at[b]);

    if (MpmShapeSpacing(shape, spacing) < 1.) continue;
    PetscCall(MpmTerminalWarn(model,
                              "warning: body %s has %g points a cell on an axis, fewer than the %" PetscInt_FMT
                              " that %s needs: the ghost penalty stabilizes it",
                              model->scene.bodies->names[b], (double)(1. / spacing), MpmShapeOrder(shape) + 1,
                              MpmShapeName(shape)));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

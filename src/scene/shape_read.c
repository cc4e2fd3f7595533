/*
  The scene's shape: its words, the order of elements, and what elements of higher order do not serve.
*/
#include "options/options.h"
#include "point/layout.h"
#include "grid/grid.h"
#include "grid/shape.h"
#include "query/model.h"
#include "scene/integrator_read.h"
#include "scene/scene_read.h"

#define ORDER 2 /* of elements, where none is given */

PetscErrorCode MpmShapeRead(MpmModel model, const MpmOptions *options)
{
  PetscInt  shape = MPM_SHAPE_GIMP, edge = MPM_EDGE_LINEAR, order = ORDER;
  PetscBool given;

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsWord(options, "shape", "shape functions", MpmShapeWords, MPM_OPTIONAL, &shape, NULL));
  PetscCall(
    MpmOptionsInt(options, "order",
                  "element, gimp_element: degree of the polynomials in a cell, of which each has order + 1 nodes "
                  "on an axis (1: the same as linear, gimp)",
                  1, 4, MPM_OPTIONAL, &order, &given));
  MpmCheckInput(!given || MpmShapeWordIsElement(shape) || MpmOptionsHelp(),
                "-mpm_order %" PetscInt_FMT ": must not be given with -mpm_shape %s, only with element or gimp_element",
                order, MpmShapeWords[shape]);
  model->scene.shape.type = MpmShapeOfWord(shape, order);
  PetscCall(MpmOptionsWord(options, "shape_edge", "how splines end at the grid's edges and at walls", MpmEdgeTypes,
                           MPM_OPTIONAL, &edge, NULL));
  model->scene.shape.edge = (MpmEdgeType)edge;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmShapeCheck(const MpmModel model)
{
  const MpmShapeType shape = model->scene.shape.type;
  const char        *name  = MpmShapeName(shape);

  PetscFunctionBeginUser;
  if (MpmShapeOrder(shape) == 1 || MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  MpmCheckInput(model->disc.layout->traits.solid, "-mpm_shape %s: not available for physics %s, must be of order 1",
                name, model->scene.physics.name);
  MpmCheckInput(
    !MpmStagesAreDynamic(model),
    "-mpm_shape %s: not available with inertia, where its nodes may have negative masses; must be of order 1", name);
  MpmCheckInput(model->scene.stabilization.smooth == 0.,
                "-mpm_stabilization_smooth %g: must be auto or 0 with -mpm_shape %s",
                (double)model->scene.stabilization.smooth, name);
  MpmCheckInput(!model->scene.stabilization.fbar_spread,
                "-mpm_stabilization_fbar spread: must be auto, true, false or plain with -mpm_shape %s", name);
  MpmCheckInput(!model->gradient, "-mpm_shape %s: not available with derivatives of a run, must be of order 1", name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

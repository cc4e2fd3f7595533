/*
  The scene's shape: its words, the order of elements, and the parts without elements of higher order.
*/
#include "options/options.h"
#include "point/layout.h"
#include "bc/bc.h"
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

#define REASON "whose lumped masses are negative in cells that material fills in part; needs order 1, or implicit steps"

/* Inertia with elements of order 2 and more, in the stages and where the step may be rescued. */
static PetscErrorCode CheckInertia(const MpmModel model, const char *name)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < model->scene.stages.count; k++) {
    const MpmStage         *stage  = &model->scene.stages.at[k];
    const MpmTimeControl   *time   = &stage->time;
    const MpmMotionControl *motion = &time->motion;

    MpmCheckInput(!stage->relaxation.on || time->rescue,
                  "-mpm_stage_%s_type relaxation: not available with -mpm_shape %s, " REASON, stage->name, name);
    MpmCheckInput(motion->type != MPM_EXPLICIT && !time->rescue,
                  "-mpm_time_%s: not available with -mpm_shape %s, " REASON,
                  time->rescue ? "rescue relaxation" : "integrator explicit", name);
    if (motion->type == MPM_QUASISTATIC) continue;
    MpmCheckInput(!motion->lumped, "-mpm_time_mass lumped: must be consistent with -mpm_shape %s", name);
    MpmCheckInput(motion->transfer.type == MPM_TRANSFER_FLIP,
                  "-mpm_time_transfer apic: must be flip with -mpm_shape %s", name);
    MpmCheckInput(time->error == 0., "-mpm_time_error %g: not available with inertia and -mpm_shape %s",
                  (double)time->error, name);
    for (PetscInt b = 0; b < model->scene.bcs->count; b++)
      MpmCheckInput(!model->scene.bcs->at[b].absorbing, "-mpm_bc_%s_absorbing: not available with -mpm_shape %s",
                    model->scene.bcs->names[b], name);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmShapeCheck(const MpmModel model)
{
  const MpmShapeType shape = model->scene.shape.type;
  const char        *name  = MpmShapeName(shape);

  PetscFunctionBeginUser;
  if (MpmShapeOrder(shape) == 1 || MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  MpmCheckInput(model->disc.layout->traits.solid || model->disc.layout->traits.biot ||
                  model->disc.layout->traits.alternate || !model->disc.layout->motion,
                "-mpm_shape %s: not available for physics %s, must be of order 1", name, model->scene.physics.name);
  PetscCall(CheckInertia(model, name));
  MpmCheckInput(model->scene.stabilization.smooth == 0.,
                "-mpm_stabilization_smooth %g: must be auto or 0 with -mpm_shape %s",
                (double)model->scene.stabilization.smooth, name);
  MpmCheckInput(!model->scene.stabilization.fbar_spread,
                "-mpm_stabilization_fbar spread: must be auto, true, false or plain with -mpm_shape %s", name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

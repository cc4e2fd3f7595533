/*
  -mpm_view: contents of a model, in PETSc's manner: the model itself, its grid, the space of the last step, and the
  solver's objects, which view themselves.
*/
#include "base/columns.h"
#include "point/layout.h"
#include "point/material.h"
#include "grid/grid.h"
#include "grid/shape.h"
#include "particles/body.h"
#include "particles/particles.h"
#include "space/space.h"
#include "bc/bc.h"
#include "bc/body_motion.h"
#include "assembly/terms.h"
#include "rigid/rigid.h"
#include "loads/load.h"
#include "query/model.h"
#include "query/query.h"
#include "step/integrator.h"
#include "observe/results.h"
#include "model/build.h"

static PetscErrorCode ViewScene(const MpmModel model, PetscViewer viewer)
{
  const MpmScene *scene = &model->scene;

  PetscFunctionBeginUser;
  PetscCall(PetscViewerASCIIPrintf(viewer, "Model: %s\n", scene->name.title ? scene->name.title : "without a title"));
  PetscCall(PetscViewerASCIIPushTab(viewer));
  PetscCall(PetscViewerASCIIPrintf(viewer, "physics %s, %s, shape %s, integrator %s\n", scene->physics.name,
                                   MpmKindText(model), MpmShapeName(scene->shape.type),
                                   model->state.scheme.integrator->name));
  PetscCall(PetscViewerASCIIPrintf(viewer, "unknowns of a node:"));
  PetscCall(PetscViewerASCIIUseTabs(viewer, PETSC_FALSE));
  for (PetscInt c = 0; c < model->disc.block; c++)
    PetscCall(PetscViewerASCIIPrintf(viewer, " %s", model->disc.layout->component[c].name));
  PetscCall(PetscViewerASCIIPrintf(viewer, "\n"));
  PetscCall(PetscViewerASCIIUseTabs(viewer, PETSC_TRUE));
  for (PetscInt m = 0; m < scene->materials->count; m++)
    PetscCall(PetscViewerASCIIPrintf(viewer, "material %s: %s, constrained modulus %g, density %g\n",
                                     scene->materials->at[m].name, scene->materials->at[m].info.name,
                                     (double)scene->materials->at[m].moduli.stiffness,
                                     (double)scene->materials->at[m].density));
  PetscCall(PetscViewerASCIIPrintf(
    viewer,
    "%" PetscInt64_FMT " points of %" PetscInt_FMT " bodies, %" PetscInt_FMT " conditions, %" PetscInt_FMT
    " motions, %" PetscInt_FMT " boundaries, %" PetscInt_FMT " loads, %" PetscInt_FMT " stages\n",
    model->state.particles->total, scene->bodies->count, scene->bcs->count, scene->motions->count,
    scene->boundaries->count, scene->loads->count, scene->stages.count));
  PetscCall(PetscViewerASCIIPrintf(viewer, "terms:"));
  PetscCall(PetscViewerASCIIUseTabs(viewer, PETSC_FALSE));
  for (PetscInt k = 0; k < model->disc.terms->count; k++)
    PetscCall(PetscViewerASCIIPrintf(viewer, "%s %s", k ? "," : "", model->disc.terms->term[k]->name));
  PetscCall(PetscViewerASCIIPrintf(viewer, "\n"));
  PetscCall(PetscViewerASCIIUseTabs(viewer, PETSC_TRUE));
  PetscCall(PetscViewerASCIIPopTab(viewer));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ViewGrid(const MpmModel model, PetscViewer viewer)
{
  const MpmGrid *grid = model->disc.grid;

  PetscFunctionBeginUser;
  PetscCall(PetscViewerASCIIPrintf(viewer, "Grid\n"));
  PetscCall(PetscViewerASCIIPushTab(viewer));
  for (PetscInt a = 0; a < grid->dim; a++)
    PetscCall(PetscViewerASCIIPrintf(viewer, "%c: %" PetscInt_FMT " cells of %g from %g to %g\n", "xyz"[a],
                                     grid -> cells[a], (double)grid -> h[a], (double)grid -> lower[a],
                                     (double)grid -> upper[a]));
  PetscCall(PetscViewerASCIIPrintf(
    viewer, "points on the fullest rank over their mean %.3g, partition moved %" PetscInt_FMT " times\n",
    (double)model->state.particles->imbalance, model->state.particles->rebalances));
  PetscCall(PetscViewerASCIIPopTab(viewer));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The space of the last step; one line a rank. */
static PetscErrorCode ViewSpace(const MpmModel model, PetscViewer viewer)
{
  const MpmSpace *space = model->disc.space;

  PetscFunctionBeginUser;
  PetscCall(PetscViewerASCIIPrintf(viewer, "Space of the last step\n"));
  PetscCall(PetscViewerASCIIPushTab(viewer));
  PetscCall(PetscViewerASCIIPrintf(viewer,
                                   "%" PetscInt_FMT " active nodes, %" PetscInt_FMT " unknowns, at most %" PetscInt_FMT
                                   " nodes a point and axis\n",
                                   space->number.count, space->number.unknowns, space->width));
  PetscCall(PetscViewerASCIIPushSynchronized(viewer));
  PetscCall(PetscViewerASCIISynchronizedPrintf(
    viewer,
    "[%d] %" PetscInt_FMT " points in %" PetscInt_FMT " groups, %" PetscInt_FMT " nodes and %" PetscInt_FMT
    " ghosts, %" PetscInt_FMT " faces of the ghost penalty, %" PetscInt_FMT " cells with a mean\n",
    model->rank, space->point_count, space->group_count, space->owned, space->local - space->owned,
    space->boxes.faces.count, space->cells.count));
  PetscCall(PetscViewerFlush(viewer));
  PetscCall(PetscViewerASCIIPopSynchronized(viewer));
  PetscCall(PetscViewerASCIIPopTab(viewer));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Fields of the points and columns of the history, with their units. */
static PetscErrorCode ViewResults(const MpmModel model, PetscViewer viewer)
{
  const MpmPointColumns *fields  = &model->results->states.fields;
  const MpmColumns      *columns = &model->results->columns;
  PetscInt               name    = 0;

  PetscFunctionBeginUser;
  PetscCall(PetscViewerASCIIPrintf(viewer, "Results\n"));
  PetscCall(PetscViewerASCIIPushTab(viewer));
  for (PetscInt k = 0; k < fields->count; k++)
    PetscCall(PetscViewerASCIIPrintf(viewer, "field %s: %" PetscInt_FMT " components, %s\n", fields->at[k].name,
                                     fields->at[k].components, fields->at[k].unit ? fields->at[k].unit : "-"));
  for (PetscInt r = 0; r < columns->count; r++)
    for (PetscInt k = 0; k < PetscMax(columns->at[r].count, 1); k++)
      PetscCall(PetscViewerASCIIPrintf(viewer, "column %s: %s\n", columns->names[name++], columns->at[r].unit));
  PetscCall(PetscViewerASCIIPopTab(viewer));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmModelView(MpmModel model, PetscViewer viewer)
{
  PetscBool ascii;

  PetscFunctionBeginUser;
  PetscCheck(model->caller.set_up, model->comm, PETSC_ERR_ARG_WRONGSTATE, "MpmModelSetUp() comes first");
  PetscCall(PetscObjectTypeCompare((PetscObject)viewer, PETSCVIEWERASCII, &ascii));
  PetscCheck(ascii, model->comm, PETSC_ERR_SUP, "a model is viewed as text only");
  PetscCall(ViewScene(model, viewer));
  PetscCall(ViewGrid(model, viewer));
  if (model->disc.space->number.count) PetscCall(ViewSpace(model, viewer));
  PetscCall(ViewResults(model, viewer));
  PetscCall(PetscViewerASCIIPrintf(viewer, "Solver: %s, Jacobian %s\n", model->solver.preset.name,
                                   MpmJacobianTypes[model->solver.jacobian.form]));
  PetscCall(PetscViewerASCIIPushTab(viewer));
  if (model->solver.snes) PetscCall(SNESView(model->solver.snes, viewer));
  PetscCall(PetscViewerASCIIPopTab(viewer));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmModelViewFromOptions(MpmModel model)
{
  PetscViewer       viewer;
  PetscViewerFormat format;
  PetscBool         set;

  PetscFunctionBeginUser;
  PetscCall(PetscOptionsCreateViewer(model->comm, NULL, NULL, "-mpm_view", &viewer, &format, &set));
  if (!set) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscViewerPushFormat(viewer, format));
  PetscCall(MpmModelView(model, viewer));
  PetscCall(PetscViewerPopFormat(viewer));
  PetscCall(PetscViewerDestroy(&viewer));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Bodies that share nodes move as one there: nothing slides or opens between them. The run's header says which do.
*/
#include "grid/grid.h"
#include "grid/shape.h"
#include "particles/body.h"
#include "particles/particles.h"
#include "particles/points.h"
#include "space/space.h"
#include "bc/body_motion.h"
#include "query/model.h"
#include "step/step.h"
#include "observe/results.h"

#define MOST_PAIRS 3 /* in the line */

/* The lowest and the highest of the bodies with points at each owned node. */
static PetscErrorCode BodiesAtNodes(MpmModel model, const PetscInt body_of[], PetscInt low[], PetscInt high[])
{
  const MpmSpace *space = model->disc.space;

  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < space->local; i++) {
    low[i]  = PETSC_INT_MAX;
    high[i] = -1;
  }
  for (PetscInt g = 0; g < space->group_count; g++) {
    const MpmGroup *group = &space->groups[g];

    for (PetscInt s = group->point_begin; s < group->point_end; s++) {
      const PetscInt b = body_of[space->order[s]];

      for (PetscInt i = 0; i < group->node_count; i++) {
        const PetscInt node = space->group_nodes[group->node_offset + i];

        if (node < 0) continue;
        low[node]  = PetscMin(low[node], b);
        high[node] = PetscMax(high[node], b);
      }
    }
  }
  if (!space->number.sf) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscSFReduceBegin(space->number.sf, MPIU_INT, low, low, MPI_MIN));
  PetscCall(PetscSFReduceEnd(space->number.sf, MPIU_INT, low, low, MPI_MIN));
  PetscCall(PetscSFReduceBegin(space->number.sf, MPIU_INT, high, high, MPI_MAX));
  PetscCall(PetscSFReduceEnd(space->number.sf, MPIU_INT, high, high, MPI_MAX));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* welded[b*n + c], b < c: true where both have points at one node. Of three at one node the two outer ones count. */
static PetscErrorCode FindWelded(MpmModel model, PetscBool welded[])
{
  const PetscInt n = model->scene.bodies->count;
  PetscInt      *body_of, *low, *high;
  MpmPoints      points;

  PetscFunctionBeginUser;
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  PetscCall(PetscMalloc3(points.count, &body_of, model->disc.space->local, &low, model->disc.space->local, &high));
  MpmBodiesOfPoints(model->scene.bodies->count, model->scene.bodies->at, &points, body_of);
  PetscCall(BodiesAtNodes(model, body_of, low, high));
  for (PetscInt i = 0; i < model->disc.space->owned; i++)
    if (low[i] < high[i]) welded[low[i] * n + high[i]] = PETSC_TRUE;
  PetscCall(PetscFree3(body_of, low, high));
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, welded, (PetscMPIInt)(n * n), MPM_MPI_BOOL, MPI_LOR, model->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  A motion prescribes nodes. The first free ones are a cell from the body's edge with linear functions, two cells with
  splines, and material between goes along by half on average: limit loads are those of a body as much wider.
*/
static PetscErrorCode PrintWidths(MpmModel model, const PetscBool welded[])
{
  const MpmBodyMotions *motions = model->scene.motions;
  const PetscInt        n = model->scene.bodies->count, dim = model->disc.dim;
  const PetscReal       cells = MpmShapeIsSpline(model->scene.shape.type) ? 1.5 : 0.5;
  PetscReal             h     = 0.;

  PetscFunctionBeginUser;
  for (PetscInt a = 0; a < dim; a++) h = PetscMax(h, model->disc.grid->h[a]);
  for (PetscInt m = 0; m < motions->count; m++) {
    const PetscInt b     = motions->at[m].body;
    PetscBool      meets = PETSC_FALSE;

    for (PetscInt c = 0; c < n; c++) meets = (PetscBool)(meets || welded[PetscMin(b, c) * n + PetscMax(b, c)]);
    if (meets)
      PetscCall(PetscPrintf(model->comm,
                            "  motion %s holds nodes that body %s shares: it acts as if up to %g cells, %.3g m, "
                            "wider on each side\n",
                            motions->names[m], model->scene.bodies->names[b], (double)cells, (double)(cells * h)));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmWeldsPrint(MpmModel model)
{
  const PetscInt n     = model->scene.bodies->count;
  PetscInt       count = 0;
  MpmOutcome     outcome;
  char          *text = NULL;
  PetscBool     *welded;

  PetscFunctionBeginUser;
  if (n < 2 || model->results->checkpoint.restart) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmStepSpace(model, &outcome));
  if (outcome.code) PetscFunctionReturn(PETSC_SUCCESS); /* the first step will say so */
  PetscCall(PetscCalloc1((n * n), &welded));
  PetscCall(FindWelded(model, welded));
  for (PetscInt k = 0; k < n * n; k++) {
    if (!welded[k] || ++count > MOST_PAIRS) continue;
    PetscCall(MpmTextAppend(&text, "%s%.40s and %.40s", count > 1 ? ", " : "", model->scene.bodies->names[k / n],
                            model->scene.bodies->names[k % n]));
  }
  if (count > MOST_PAIRS) PetscCall(MpmTextAppend(&text, ", and %d more", (int)(count - MOST_PAIRS)));
  if (count) PetscCall(PetscPrintf(model->comm, "  bodies that share nodes are welded there: %s\n", text));
  PetscCall(PrintWidths(model, welded));
  PetscCall(PetscFree(text));
  PetscCall(PetscFree(welded));
  PetscFunctionReturn(PETSC_SUCCESS);
}

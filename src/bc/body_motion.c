/*
  Motions of bodies: the displacement of a body's points, or of some of them, is prescribed wherever they go.

  In each step the nodes that these points touch with their shape functions take the increment of the motion. The nodes
  are found anew from the points' places. Since the weights sum to one and their derivatives to zero, the points then
  move by that increment and do not deform along its axes, to rounding. Other material that shares those nodes goes with
  them, for a cell at most with linear functions, for the support of a spline otherwise.

  A node that a domain only grazes is not touched: where faces stand on grid lines, rounding must not decide which nodes
  move.
*/
#include "options/options.h"
#include "geometry/geometry.h"
#include "grid/grid.h"
#include "particles/body.h"
#include "particles/particles.h"
#include "particles/points.h"
#include "space/basis.h"
#include "space/space.h"
#include "bc/bc.h"
#include "bc/body_motion.h"

#define GRAZE 1e-9 /* a weight, and a derivative by cells, of a node that is not touched */

/* The axes along which it moves, and by how much. */
static PetscErrorCode ReadValue(const MpmOptions *block, PetscInt dim, MpmBodyMotion *motion)
{
  char   **components;
  PetscInt count;

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsNames(block, "components", "axes along which the displacement is prescribed: x, y, z",
                            MPM_REQUIRED, &count, &components));
  MpmCheckInput(count <= dim, "-%scomponents: %" PetscInt_FMT " given, there are %" PetscInt_FMT " axes", block->prefix,
                count, dim);
  for (PetscInt k = 0; k < count; k++) {
    motion->component[k] = (PetscInt)(components[k][0] - 'x');
    MpmCheckInput(!components[k][1] && motion->component[k] >= 0 && motion->component[k] < dim,
                  "-%scomponents %s: must be among %.*s", block->prefix, components[k], (int)(3 * dim - 2), "x, y, z");
  }
  motion->component_count = count;
  PetscCall(MpmNamesDestroy(count, &components));
  PetscCall(MpmOptionsReals(block, "value", "m", "displacement in total, one number a component", MPM_RANGE_ANY,
                            MPM_OPTIONAL, PetscMax(count, 1), motion->value, NULL));
  PetscCall(MpmRampCreate(block, "ramp", "0:0,1:1", &motion->ramp));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmBodyMotionCreate(const MpmOptions *options, const char *name, const MpmGrid *grid,
                                   const MpmBodies *bodies, MpmBodyMotion *motion)
{
  char       prefix[256], field[256], *body;
  MpmOptions block = {options->comm, prefix, options->record};
  PetscReal  tolerance[MPM_MAX_DIM];

  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(motion, sizeof(*motion)));
  PetscCall(PetscSNPrintf(prefix, sizeof(prefix), "mpm_motion_%s_", name));
  PetscCall(PetscSNPrintf(field, sizeof(field), "motion_%s", name));
  PetscCall(PetscStrallocpy(name, &motion->name));
  PetscCall(PetscStrallocpy(field, &motion->share_field));
  PetscCall(MpmOptionsHeading(&block, "Motion"));
  PetscCall(MpmOptionsText(&block, "body", "body whose points are moved", NULL, MPM_REQUIRED, &body));
  motion->body = -1;
  for (PetscInt b = 0; b < bodies->count && body; b++)
    if (!strcmp(bodies->names[b], body)) motion->body = b;
  MpmCheckInput(motion->body >= 0 || MpmOptionsHelp(), "-%sbody %s: there is no such body in -mpm_bodies", prefix,
                body ? body : "");
  PetscCall(PetscFree(body));
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) tolerance[a] = MPM_TOLERANCE * grid->h[a];
  PetscCall(MpmRegionCreate(&block, grid->dim, tolerance, &motion->region));
  MpmCheckInput(MpmOptionsHelp() || MpmRegionGetType(motion->region) < MPM_REGION_FILE,
                "-%sregion file: only bodies are read from files", prefix);
  PetscCall(ReadValue(&block, grid->dim, motion));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmBodyMotionDestroy(MpmBodyMotion *motion)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(motion->name));
  PetscCall(PetscFree(motion->share_field));
  PetscCall(MpmRegionDestroy(&motion->region));
  PetscCall(MpmRampDestroy(&motion->ramp));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmBodyMotionSelect(const MpmBodyMotion *motion, const MpmBodies *bodies, MpmParticles *particles)
{
  PetscInt   first, end;
  PetscInt64 found = 0;
  PetscReal *share;
  MpmPoints  points;

  PetscFunctionBeginUser;
  MpmBodyGetIds(bodies->at[motion->body], &first, &end);
  PetscCall(MpmParticlesGetArrays(particles, &points));
  PetscCall(MpmParticlesGetField(particles, motion->share_field, &share));
  for (PetscInt p = 0; p < points.count; p++) {
    const PetscBool ours = (PetscBool)(points.id[p] >= first && points.id[p] < end &&
                                       MpmRegionContains(motion->region, &points.x0[p * particles->dim]));

    share[p] = ours ? 1. : 0.;
    found += ours;
  }
  PetscCall(MpmParticlesRestoreField(particles, &share));
  PetscCall(MpmParticlesRestoreArrays(particles, &points));
  PetscCall(
    MPIU_Allreduce(MPI_IN_PLACE, &found, 1, MPIU_INT64, MPI_SUM, PetscObjectComm((PetscObject)particles->swarm)));
  MpmCheckInput(found, "-mpm_motion_%s_region: there is no point of body %s in it", motion->name,
                bodies->names[motion->body]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- nodes ---- */

static void TouchNodes(const MpmSpace *space, const PetscReal h[], const MpmGroup *group, const PetscReal share[],
                       PetscInt stride, PetscReal marks[])
{
  const PetscInt *nodes = &space->group_nodes[group->node_offset];

  for (PetscInt s = group->point_begin; s < group->point_end; s++) {
    const PetscInt p = space->order[s];

    if (share[p] == 0.) continue;
    for (PetscInt i = 0; i < group->node_count; i++)
      if (nodes[i] >= 0 && MpmSpaceTouches(space, group, p, i, h, GRAZE)) marks[nodes[i] * stride] = 1.;
  }
}

PetscErrorCode MpmBodyMotionsTouch(const MpmBodyMotions *motions, const MpmActing *acting, const MpmGrid *grid,
                                   const MpmSpace *space, MpmParticles *particles, PetscReal **marks)
{
  PetscBool any = PETSC_FALSE;

  PetscFunctionBeginUser;
  *marks = NULL;
  for (PetscInt m = 0; m < motions->count; m++) any = (PetscBool)(any || acting[m].active);
  if (!any) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscCalloc1((space->local * motions->count + 1), marks));
  for (PetscInt m = 0; m < motions->count; m++) {
    PetscReal *share;

    if (!acting[m].active) continue;
    PetscCall(MpmParticlesGetField(particles, motions->at[m].share_field, &share));
    for (PetscInt g = 0; g < space->group_count; g++)
      TouchNodes(space, grid->h, &space->groups[g], share, motions->count, &(*marks)[m]);
    PetscCall(MpmParticlesRestoreField(particles, &share));
  }
  PetscCall(MpmSpaceAddToOwners(space, motions->count, *marks));
  PetscCall(MpmSpaceToGhosts(space, motions->count, *marks));
  PetscFunctionReturn(PETSC_SUCCESS);
}

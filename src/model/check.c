/*
  `talus check`: what a scene comes to. The first step is taken in memory, without any file, for its unknowns, its time
  and whether it converges.
*/
#include "options/options.h"
#include "io/io.h"
#include "geometry/geometry.h"
#include "grid/grid.h"
#include "particles/body.h"
#include "particles/particles.h"
#include "particles/points.h"
#include "point/material.h"
#include "space/space.h"
#include "bc/bc.h"
#include "rigid/rigid.h"
#include "loads/load.h"
#include "query/model.h"
#include "observe/results.h"
#include "model/build.h"
#include "model/program.h"

#define NAME_WIDTH 24 /* columns of a line's first words */

/* ---- counts ---- */

/* Points of all ranks with a share in a field. */
static PetscErrorCode CountShares(MpmModel model, const char field[], PetscInt64 *points)
{
  PetscReal *share;
  PetscInt   count;

  PetscFunctionBeginUser;
  *points = 0;
  PetscCall(DMSwarmGetLocalSize(model->state.particles->swarm, &count));
  PetscCall(MpmParticlesGetField(model->state.particles, field, &share));
  for (PetscInt p = 0; p < count; p++) *points += share[p] != 0.;
  PetscCall(MpmParticlesRestoreField(model->state.particles, &share));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, points, 1, MPIU_INT64, MPI_SUM, model->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Nodes of the material in the region of a condition. */
static PetscErrorCode CountNodes(const MpmModel model, MpmRegion region, PetscInt64 *nodes)
{
  const MpmSpace *space = model->disc.space;

  PetscFunctionBeginUser;
  *nodes = 0;
  for (PetscInt i = 0; i < space->owned; i++) {
    PetscInt  at[MPM_MAX_DIM];
    PetscReal x[MPM_MAX_DIM];

    if (MpmSpaceIsExtra(space, i)) continue;
    MpmSpaceAt(space, &space->node[i * space->dim], at);
    MpmGridNodeAtStart(model->disc.grid, at, x);
    *nodes += MpmRegionContains(region, x);
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, nodes, 1, MPIU_INT64, MPI_SUM, model->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Steps of all stages, where they keep their first length; `dt` is that of steps as long as they may be. */
static PetscReal PlannedSteps(const MpmModel model, PetscReal dt)
{
  PetscReal steps = 0.;

  for (PetscInt k = 0; k < model->scene.stages.count; k++) {
    const MpmStage *stage = &model->scene.stages.at[k];
    const PetscReal step  = stage->time.step > 0. ? stage->time.step : dt;

    if (stage->geostatic.method != MPM_GEOSTATIC_NONE || step <= 0.) steps += 1.;
    else steps += PetscCeilReal(stage->time.end / step * (1. - 1e-12));
  }
  return steps;
}

/* ---- lines ---- */

/* "body clay               400 points" */
static PetscErrorCode PrintLine(MPI_Comm comm, const char kind[], const char name[], const char text[])
{
  char head[256];

  PetscFunctionBeginUser;
  PetscCall(PetscSNPrintf(head, sizeof(head), "%s%s%s", kind, *name ? " " : "", name));
  PetscCall(PetscPrintf(comm, "%-*s %s\n", NAME_WIDTH, head, text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode PrintCount(MPI_Comm comm, const char kind[], const char name[], PetscInt64 count,
                                 const char what[])
{
  char text[128];

  PetscFunctionBeginUser;
  PetscCall(PetscSNPrintf(text, sizeof(text), "%" PetscInt64_FMT " %s%s%s", count, what, count == 1 ? "" : "s",
                          count ? "" : ": has no effect at the start"));
  PetscCall(PrintLine(comm, kind, name, text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

#define NAMED 8 /* materials of a body by name; of more, how many */

static PetscErrorCode AppendMaterials(MpmModel model, MpmBody body, char **text)
{
  PetscInt count = 0;

  PetscFunctionBeginUser;
  for (PetscInt m = 0; m < model->scene.materials->count; m++) {
    if (!MpmBodyHasMaterial(body, m) || count++ >= NAMED) continue;
    PetscCall(MpmTextAppend(text, "%s%s", count > 1 ? ", " : "material ", model->scene.materials->names[m]));
  }
  if (count > NAMED) PetscCall(MpmTextAppend(text, " and %d others", (int)(count - NAMED)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Points, volume, mass and box of each body. */
static PetscErrorCode PrintBodies(MpmModel model)
{
  const MpmBodies *bodies = model->scene.bodies;
  const PetscInt   dim    = model->disc.dim;
  MpmPoints        points;

  PetscFunctionBeginUser;
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  for (PetscInt b = 0; b < bodies->count; b++) {
    PetscReal sums[2] = {0., 0.}, ends[2 * MPM_MAX_DIM];
    char     *text    = NULL;

    for (PetscInt a = 0; a < 2 * dim; a++) ends[a] = PETSC_INFINITY;
    for (PetscInt p = 0; p < points.count; p++) {
      if (MpmBodyNumber(bodies, &points, p) != b) continue;
      sums[0] += 1.;
      sums[1] += points.volume0[p];
      for (PetscInt a = 0; a < dim; a++) {
        ends[a]       = PetscMin(ends[a], points.x[p * dim + a]);
        ends[dim + a] = PetscMin(ends[dim + a], -points.x[p * dim + a]);
      }
    }
    PetscCall(MPIU_Allreduce(MPI_IN_PLACE, sums, 2, MPIU_REAL, MPIU_SUM, model->comm));
    PetscCall(MPIU_Allreduce(MPI_IN_PLACE, ends, (PetscMPIInt)(2 * dim), MPIU_REAL, MPI_MIN, model->comm));
    PetscCall(MpmTextAppend(&text, "%.0f points, %.6g m%d, ", (double)sums[0], (double)sums[1],
                            dim == 3 || model->disc.grid->axial ? 3 : 2));
    PetscCall(AppendMaterials(model, bodies->at[b], &text));
    for (PetscInt a = 0; a < dim; a++)
      PetscCall(MpmTextAppend(&text, ", %c %.4g to %.4g", "xyz"[a], (double)ends[a], -(double)ends[dim + a]));
    PetscCall(PrintLine(model->comm, "body", bodies->names[b], sums[0] > 0. ? text : "joins a stage"));
    PetscCall(PetscFree(text));
  }
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Distance of each boundary, where it starts, from the nearest point. */
static PetscErrorCode PrintBoundaries(MpmModel model)
{
  MpmPoints points;
  char      text[128];

  PetscFunctionBeginUser;
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  for (PetscInt b = 0; b < model->scene.boundaries->count; b++) {
    const MpmBoundary *boundary = &model->scene.boundaries->at[b];
    const MpmPose      pose     = MpmBoundaryPose(boundary, 0.);
    PetscReal          nearest  = PETSC_INFINITY;

    for (PetscInt p = 0; p < points.count; p++) {
      MpmSurface surface;

      MpmBoundaryDistance(boundary, &pose, &points.x[p * model->disc.dim], &surface);
      nearest = PetscMin(nearest, surface.distance);
    }
    PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &nearest, 1, MPIU_REAL, MPI_MIN, model->comm));
    PetscCall(PetscSNPrintf(text, sizeof(text), "nearest point %.4g m away", (double)nearest));
    PetscCall(PrintLine(model->comm, "boundary", boundary->name, text));
  }
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode PrintParts(MpmModel model)
{
  const MpmTracks *tracks = &model->results->tracks;
  PetscInt64       count;

  PetscFunctionBeginUser;
  PetscCall(PrintBodies(model));
  for (PetscInt b = 0; b < model->scene.bcs->count; b++) {
    PetscCall(CountNodes(model, model->scene.bcs->at[b].region, &count));
    PetscCall(PrintCount(model->comm, "condition", model->scene.bcs->names[b], count, "node"));
  }
  PetscCall(PrintBoundaries(model));
  for (PetscInt l = 0; l < model->scene.loads->count; l++) {
    const MpmLoad *load = &model->scene.loads->at[l];

    count = model->state.particles->total;
    if (load->type != MPM_LOAD_GRAVITY) PetscCall(CountShares(model, load->share_field, &count));
    PetscCall(PrintCount(model->comm, "load", load->name, count, "point"));
  }
  for (PetscInt t = 0; t < tracks->count; t++) {
    PetscCall(CountShares(model, tracks->at[t].share_field, &count));
    PetscCall(PrintCount(model->comm, "track", tracks->at[t].name, count, "point"));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* "512, 32 x 16" */
static PetscErrorCode PrintCells(const MpmModel model)
{
  const MpmGrid *grid  = model->disc.grid;
  PetscInt64     count = 1;
  char          *text  = NULL;

  PetscFunctionBeginUser;
  for (PetscInt a = 0; a < grid->dim; a++) count *= grid->cells[a];
  PetscCall(MpmTextAppend(&text, "%lld, %lld", (long long)count, (long long)grid->cells[0]));
  for (PetscInt a = 1; a < grid->dim; a++) PetscCall(MpmTextAppend(&text, " x %lld", (long long)grid->cells[a]));
  PetscCall(PrintLine(model->comm, "cells", "", text));
  PetscCall(PetscFree(text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sizes after the first step, which took `seconds`. */
static PetscErrorCode PrintSizes(MpmModel model, PetscReal seconds)
{
  const PetscReal steps = PlannedSteps(model, model->state.time);
  char            text[256], duration[MPM_DURATION_TEXT];
  PetscReal       memory = MpmProcessMemory();

  PetscFunctionBeginUser;
  PetscCall(PetscSNPrintf(text, sizeof(text), "%" PetscInt64_FMT, model->state.particles->total));
  PetscCall(PrintLine(model->comm, "points", "", text));
  PetscCall(PetscSNPrintf(text, sizeof(text), "%" PetscInt_FMT, model->disc.space->number.unknowns));
  PetscCall(PrintLine(model->comm, "unknowns", "", text));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &memory, 1, MPIU_REAL, MPIU_SUM, model->comm));
  PetscCall(PetscSNPrintf(text, sizeof(text), "%.0f MB on %d rank%s", (double)(memory / 1e6), model->size,
                          model->size > 1 ? "s" : ""));
  PetscCall(PrintLine(model->comm, "memory", "", text));
  MpmTerminalDuration(seconds * steps, duration);
  PetscCall(PetscSNPrintf(text, sizeof(text), "about %s: the first step took %.3g s, %.0f are planned", duration,
                          (double)seconds, (double)steps));
  PetscCall(PrintLine(model->comm, "time", "", text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmModelWriteStart(MpmModel model, const char prefix[])
{
  const MpmOptions options = {model->comm, "mpm_", model->record};
  char             path[PETSC_MAX_PATH_LEN];

  PetscFunctionBeginUser;
  PetscCall(MpmModelSetUp(model));
  MpmCheckInput(!model->laboratory, "--picture: a laboratory test has none before its run");
  PetscCall(MpmOutputCreate(model->comm, prefix, &model->results->states.file));
  PetscCall(MpmModelWriteState(model));
  PetscCall(MpmOutputDestroy(&model->results->states.file));
  PetscCall(PetscSNPrintf(path, sizeof(path), "%s_options.yaml", prefix));
  PetscCall(MpmOptionsWriteYAML(&options, path));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmModelCheck(MpmModel model, int *status)
{
  const char    *why;
  MpmStatus      after;
  PetscLogDouble begin, end;

  PetscFunctionBeginUser;
  PetscCall(MpmModelSetUp(model));
  PetscCall(PetscPrintf(model->comm, "talus %s checks %s\n", MPM_VERSION,
                        model->scene.name.title && *model->scene.name.title ? model->scene.name.title
                                                                            : model->scene.name.prefix));
  if (model->laboratory) PetscFunctionReturn(PrintLine(model->comm, "points", "", "1 point, in the laboratory"));
  PetscCall(PetscTime(&begin));
  PetscCall(MpmModelStep(model, &after));
  PetscCall(PetscTime(&end));
  PetscCall(PrintCells(model));
  PetscCall(PrintSizes(model, end - begin));
  PetscCall(PrintParts(model));
  PetscCall(MpmModelGetReason(model, &why));
  PetscCall(PrintLine(model->comm, "first step", "", why ? why : "converged"));
  *status = after == MPM_GAVE_UP ? MPM_EXIT_GAVEUP : 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

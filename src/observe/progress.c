/*
  Output of a run on the terminal: a header, one line a step with the estimated time left, and reasons of cuts.
*/
#include <stdarg.h>
#include "grid/grid.h"
#include "grid/shape.h"
#include "particles/body.h"
#include "particles/particles.h"
#include "point/material.h"
#include "rigid/rigid.h"
#include "query/model.h"
#include "query/query.h"
#include "scene/integrator_read.h"
#include "scene/scene_read.h"
#include "step/integrator.h"
#include "observe/results.h"

#define COARSE        3. /* cells: a boundary with a smaller radius meets too few of them (docs/scene.md) */
#define LINE_SECONDS  1. /* wall time between two lines of explicit steps, s */
#define LINES_A_TITLE 50 /* the columns' titles come again, so that a long log can be read anywhere */

PetscBool MpmTerminalShows(const MpmModel model)
{
  return (PetscBool)(model->caller.terminal && !model->results->quiet);
}

PetscErrorCode MpmTerminalWarn(MpmModel model, const char format[], ...)
{
  char    text[PETSC_MAX_PATH_LEN + 512];
  va_list arguments;

  PetscFunctionBeginUser;
  va_start(arguments, format);
  PetscCall(PetscVSNPrintf(text, sizeof(text), format, NULL, arguments));
  va_end(arguments);
  if (model->caller.terminal) PetscCall(PetscFPrintf(model->comm, stderr, "talus: %s\n", text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode PrintTitles(MpmModel model)
{
  PetscFunctionBeginUser;
  PetscCall(PetscPrintf(model->comm, "%7s %14s %10s %6s %6s %4s %6s %11s\n", "step", "time", "dt", "newton", "linear",
                        "cuts", "done", "time left"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Names the round boundaries that meet too few cells: contact takes means over each. */
static PetscErrorCode PrintCoarse(const MpmModel model)
{
  const MpmGrid *grid = model->disc.grid;

  PetscFunctionBeginUser;
  for (PetscInt b = 0; b < model->scene.boundaries->count; b++) {
    const MpmSolid *solid = &model->scene.boundaries->at[b].solid;
    PetscReal       cells = PETSC_INFINITY;

    for (PetscInt a = 0; a < grid->dim; a++) cells = PetscMin(cells, solid->radius / grid->h[a]);
    if (cells == 0. || cells >= COARSE) continue;
    PetscCall(PetscPrintf(model->comm,
                          "  boundary %.40s is sampled coarsely: its radius is %.2g cells, at least %g are wanted\n",
                          model->scene.boundaries->names[b], (double)cells, COARSE));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The first stage with inertia: how its steps are taken. */
static PetscErrorCode PrintMotion(const MpmModel model)
{
  char text[64] = "";

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < model->scene.stages.count; k++) {
    const MpmMotionControl *motion = &model->scene.stages.at[k].time.motion;

    if (motion->type == MPM_QUASISTATIC) continue;
    if (motion->type == MPM_GENERALIZED_ALPHA)
      PetscCall(PetscSNPrintf(text, sizeof(text), " with rho_inf %g", (double)motion->rho_inf));
    if (motion->type == MPM_NEWMARK && (motion->beta != 0.25 || motion->gamma != 0.5))
      PetscCall(
        PetscSNPrintf(text, sizeof(text), " with beta %g, gamma %g", (double)motion->beta, (double)motion->gamma));
    PetscCall(PetscPrintf(model->comm, "  integrator %s%s, transfer %s, %s mass\n", MpmIntegratorTypes[motion->type],
                          text, MpmTransferTypes[motion->transfer.type],
                          motion->lumped || motion->type == MPM_EXPLICIT ? "lumped" : "consistent"));
    break;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Bodies from maps: volume, mass, and error of the volume. */
static PetscErrorCode PrintReleases(const MpmModel model)
{
  PetscReal exact, volume;

  PetscFunctionBeginUser;
  for (PetscInt b = 0; b < model->scene.bodies->count; b++) {
    const MpmBody      body     = model->scene.bodies->at[b];
    const MpmMaterial *material = &model->scene.materials->at[MpmBodyMaterial(body)];

    if (!MpmBodyVolume(body, &exact, &volume)) continue;
    PetscCall(PetscPrintf(model->comm,
                          "  body %s: %.10g m3, %.6g kg; the integral of its depth is %.10g m3, error %.1e\n",
                          model->scene.bodies->names[b], (double)volume, (double)(volume * material->density),
                          (double)exact, (double)PetscAbsReal(volume / exact - 1.)));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTerminalBegin(MpmModel model, const char *what)
{
  const MpmGrid *grid = model->disc.grid;
  char          *title, text[512];

  PetscFunctionBeginUser;
  PetscCall(PetscTime(&model->results->terminal.since));
  if (!MpmTerminalShows(model)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmTextQuote(model->scene.name.title[0] ? model->scene.name.title : model->scene.name.prefix, &title));
  PetscCall(PetscPrintf(model->comm, "talus %s: %s\n", MPM_VERSION, title));
  PetscCall(PetscFree(title));
  if (what) {
    PetscCall(PetscPrintf(model->comm, "  %s\n", what));
    PetscCall(PrintTitles(model));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(PetscPrintf(model->comm, "  %s, %s, shape %s%s, Jacobian %s, solver %s%s%s%s, %d rank%s\n",
                        model->scene.physics.name, MpmKindText(model), MpmShapeName(model->scene.shape.type),
                        model->scene.shape.edge == MPM_EDGE_OPEN ? " with not-a-knot ends" : "",
                        MpmJacobianTypes[model->solver.jacobian.form], model->solver.preset.name,
                        model->solver.preset.why ? " (" : "", model->solver.preset.why ? model->solver.preset.why : "",
                        model->solver.preset.why ? ")" : "", model->size, model->size > 1 ? "s" : ""));
  PetscCall(PrintMotion(model));
  PetscCall(MpmStabilizationText(model, sizeof(text), text));
  PetscCall(PetscPrintf(model->comm, "  %s\n", text));
  if (model->gradient && model->scene.stabilization.fbar && !model->scene.stabilization.fbar_spread)
    PetscCall(PetscPrintf(model->comm, "  results jump a little where a point changes its cell of F-bar, which "
                                       "derivatives do not see; -mpm_stabilization_fbar spread does without\n"));
  if (model->solver.cache.minimisation.on)
    PetscCall(PetscPrintf(model->comm,
                          "  each step minimises a potential: the materials' energy%s, less the work of the loads\n",
                          MpmStagesAreImplicit(model) ? ", with inertia" : ""));
  PetscCall(PetscPrintf(model->comm, "  %" PetscInt64_FMT " point%s, grid of %" PetscInt_FMT " x %" PetscInt_FMT,
                        model->state.particles->total, model->state.particles->total == 1 ? "" : "s", grid->cells[0],
                        grid->cells[1]));
  if (grid->dim > 2) PetscCall(PetscPrintf(model->comm, " x %" PetscInt_FMT, grid->cells[2]));
  PetscCall(PetscPrintf(model->comm, " cells of %g x %g", (double)grid->h[0], (double)grid->h[1]));
  if (grid->dim > 2) PetscCall(PetscPrintf(model->comm, " x %g", (double)grid->h[2]));
  PetscCall(PetscPrintf(model->comm, " m\n"));
  PetscCall(PrintReleases(model));
  PetscCall(MpmWeldsPrint(model));
  PetscCall(PrintCoarse(model));
  PetscCall(PrintTitles(model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MpmTerminalDuration(PetscReal seconds, char text[MPM_DURATION_TEXT])
{
  const long long whole = seconds < 3.6e8 ? (long long)(seconds + 0.5) : 0, hours = whole / 3600;

  if (!(seconds < 3.6e8)) snprintf(text, MPM_DURATION_TEXT, "> 10 years");
  else if (hours < 100) snprintf(text, MPM_DURATION_TEXT, "%lld:%02lld:%02lld", hours, whole / 60 % 60, whole % 60);
  else snprintf(text, MPM_DURATION_TEXT, "%lld d %lld h", hours / 24, hours % 24);
}

PetscErrorCode MpmTerminalStep(MpmModel model, PetscReal dt)
{
  MpmTerminal   *terminal = &model->results->terminal;
  PetscLogDouble now;
  char           left[MPM_DURATION_TEXT];

  PetscFunctionBeginUser;
  if (!MpmTerminalShows(model)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscTime(&now));
  MpmTerminalDuration(MpmTimeLeftAfter(model, dt, now - terminal->since), left);
  terminal->since = now;
  if (model->state.scheme.integrator->length && terminal->lines && now - terminal->shown < LINE_SECONDS &&
      model->state.time < model->state.period.run_end * (1. - 1e-12))
    PetscFunctionReturn(PETSC_SUCCESS);
  terminal->shown = now;
  if (terminal->lines && terminal->lines % LINES_A_TITLE == 0) PetscCall(PrintTitles(model));
  terminal->lines++;
  PetscCall(PetscPrintf(model->comm,
                        "%7" PetscInt_FMT " %14.8g %10.4g %6" PetscInt_FMT " %6" PetscInt_FMT " %4" PetscInt_FMT
                        " %5.1f%% %11s\n",
                        model->state.step, (double)model->state.time, (double)dt, model->solver.iterations.newton,
                        model->solver.iterations.linear, model->state.cuts.step,
                        PetscFloorReal(1000. * model->state.time / model->state.period.run_end) / 10., left));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTerminalInterrupted(MpmModel model)
{
  const PetscBool goes_on = (PetscBool)(model->results->checkpoint.step >= 0);

  PetscFunctionBeginUser;
  if (MpmTerminalShows(model))
    PetscCall(PetscPrintf(model->comm, "interrupted after step %" PetscInt_FMT " at time %g%s%s%s\n", model->state.step,
                          (double)model->state.time, goes_on ? "; talus " : "", goes_on ? model->scene.name.prefix : "",
                          goes_on ? "_restart.yaml goes on from there" : ""));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTerminalMessage(void *ctx, PetscBool line, const char text[])
{
  const MpmModel model = (MpmModel)ctx;

  PetscFunctionBeginUser;
  if (MpmTerminalShows(model)) PetscCall(PetscPrintf(model->comm, "%s%s\n", line ? "  " : "        ", text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode PrintTime(MPI_Comm comm, const char *name, PetscReal seconds, PetscReal total)
{
  PetscFunctionBeginUser;
  PetscCall(PetscPrintf(comm, "  %-10s %10.3f s %6.1f %%\n", name, (double)seconds,
                        (double)(total > 0. ? 100. * seconds / total : 0.)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTerminalSummary(MPI_Comm comm, const MpmSummary *summary)
{
  PetscMPIInt size;
  PetscReal   other = summary->time_total;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(comm, &size));
  PetscCall(PetscPrintf(comm, "%s: %lld points, %lld cells, at most %lld unknowns, %d rank%s\n",
                        summary->status ? summary->status : "unknown", (long long)summary->points,
                        (long long)summary->cells, (long long)summary->active_dofs_max, (int)size,
                        size == 1 ? "" : "s"));
  PetscCall(PetscPrintf(comm, "%lld steps, %lld cuts, %lld Newton and %lld linear iterations, %.1f MB\n",
                        (long long)summary->effort.steps, (long long)summary->effort.step_cuts,
                        (long long)summary->effort.newton_iterations, (long long)summary->effort.linear_iterations,
                        (double)summary->memory_max / 1e6));
  for (PetscInt k = 0; k < MPM_CHANGE_COUNT; k++)
    if (summary->changes[k])
      PetscCall(PetscPrintf(comm, "changed by itself: %s (%d time%s)\n", MpmChanges[k], (int)summary->changes[k],
                            summary->changes[k] == 1 ? "" : "s"));
  PetscCall(PetscPrintf(comm, "Where the time went (slowest rank of each)\n"));
  for (int i = 0; i < MPM_TIME_COUNT; ++i) {
    if (i != MPM_TIME_GRADIENT || summary->time[i] > 0.)
      PetscCall(PrintTime(comm, MpmTimers[i], summary->time[i], summary->time_total));
    other -= summary->time[i];
  }
  PetscCall(PrintTime(comm, "other", PetscMax(other, 0.), summary->time_total));
  PetscCall(PrintTime(comm, "total", summary->time_total, summary->time_total));
  PetscFunctionReturn(PETSC_SUCCESS);
}

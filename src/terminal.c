/*
  What a run says on the terminal: a header, one line a step with the time to go, and why steps were cut.

  The time to go follows recent speed: wall time and progress are summed with a memory of some twenty steps.
*/
#include <stdarg.h>
#include "mpmimpl.h"
#include "optionsimpl.h"

#define MEMORY        0.95 /* weight of what was summed before this step */
#define LINES_A_TITLE 50   /* the columns' titles come again, so that a long log can be read anywhere */

static PetscErrorCode PrintTitles(MpmModel model)
{
  PetscFunctionBeginUser;
  PetscCall(PetscPrintf(model->comm, "%7s %14s %10s %6s %6s %4s %6s %11s\n", "step", "time", "dt", "newton", "linear",
                        "cuts", "done", "time to go"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTerminalBegin(MpmModel model)
{
  const MpmGrid *grid = &model->grid;
  char          *title, text[512];

  PetscFunctionBeginUser;
  PetscCall(PetscTime(&model->terminal.since));
  if (model->quiet) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmTextQuote(model->title[0] ? model->title : model->prefix, &title));
  PetscCall(PetscPrintf(model->comm, "talus %s: %s\n", MPM_VERSION, title));
  PetscCall(PetscFree(title));
  PetscCall(PetscPrintf(model->comm, "  %s, %" PetscInt_FMT "D, shape %s%s, Jacobian %s, solver %s%s%s%s, %d rank%s\n",
                        model->physics.name, grid->dim, MpmShapeTypes[model->shape],
                        model->edge == MPM_EDGE_OPEN ? " with open edges" : "", MpmJacobianTypes[model->jacobian_type],
                        model->solver, model->solver_why ? " (" : "", model->solver_why ? model->solver_why : "",
                        model->solver_why ? ")" : "", model->size, model->size > 1 ? "s" : ""));
  PetscCall(MpmStabilizationText(model, sizeof(text), text));
  PetscCall(PetscPrintf(model->comm, "  %s\n", text));
  PetscCall(PetscPrintf(model->comm, "  %" PetscInt64_FMT " point%s, grid of %" PetscInt_FMT " x %" PetscInt_FMT,
                        model->particles.total, model->particles.total == 1 ? "" : "s", grid->cells[0],
                        grid->cells[1]));
  if (grid->dim > 2) PetscCall(PetscPrintf(model->comm, " x %" PetscInt_FMT, grid->cells[2]));
  PetscCall(PetscPrintf(model->comm, " cells of %g x %g", (double)grid->h[0], (double)grid->h[1]));
  if (grid->dim > 2) PetscCall(PetscPrintf(model->comm, " x %g", (double)grid->h[2]));
  PetscCall(PetscPrintf(model->comm, " m\n"));
  PetscCall(MpmWeldsPrint(model));
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
  MpmTerminal   *terminal = &model->terminal;
  PetscLogDouble now;
  char           left[MPM_DURATION_TEXT];

  PetscFunctionBeginUser;
  if (model->quiet) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscTime(&now));
  terminal->seconds  = MEMORY * terminal->seconds + (now - terminal->since);
  terminal->progress = MEMORY * terminal->progress + dt;
  terminal->since    = now;
  MpmTerminalDuration(terminal->seconds / terminal->progress * PetscMax(model->run_end - model->time, 0.), left);
  if (terminal->lines && terminal->lines % LINES_A_TITLE == 0) PetscCall(PrintTitles(model));
  terminal->lines++;
  PetscCall(PetscPrintf(model->comm,
                        "%7" PetscInt_FMT " %14.8g %10.4g %6" PetscInt_FMT " %6" PetscInt_FMT " %4" PetscInt_FMT
                        " %5.1f%% %11s\n",
                        model->step, (double)model->time, (double)dt, model->newton, model->linear, model->cuts,
                        PetscFloorReal(1000. * model->time / model->run_end) / 10., left));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTerminalNote(MpmModel model, const char format[], ...)
{
  char    text[512];
  va_list arguments;

  PetscFunctionBeginUser;
  if (model->quiet) PetscFunctionReturn(PETSC_SUCCESS);
  va_start(arguments, format);
  (void)vsnprintf(text, sizeof(text), format, arguments);
  va_end(arguments);
  PetscCall(PetscPrintf(model->comm, "        %s\n", text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

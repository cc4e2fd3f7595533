/*
  Messages and times of the engine.
*/
#include <stdarg.h>
#include "base/base.h"

#define LONGEST_MESSAGE 1024

const char *const MpmTimers[] = {"setup",   "transfer", "residual", "jacobian", "solve",
                                 "migrate", "output",   "gradient", NULL};

const char *const MpmChanges[] = {"F-bar averages dilation", "the ground settles, with inertia", "GMRES in place of CG",
                                  "workspace of MUMPS raised", NULL};

static PetscErrorCode Tell(const MpmMonitor *monitor, PetscBool line, const char format[], va_list arguments)
{
  char text[LONGEST_MESSAGE];

  PetscFunctionBeginUser;
  if (!monitor->message) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscVSNPrintf(text, sizeof(text), format, NULL, arguments));
  PetscCall(monitor->message(monitor->ctx, line, text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmMonitorNote(const MpmMonitor *monitor, const char format[], ...)
{
  va_list arguments;

  PetscFunctionBeginUser;
  va_start(arguments, format);
  PetscCall(Tell(monitor, PETSC_FALSE, format, arguments));
  va_end(arguments);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmMonitorChange(MpmMonitor *monitor, MpmChange change, const char format[], ...)
{
  va_list arguments;

  PetscFunctionBeginUser;
  monitor->changes[change]++;
  va_start(arguments, format);
  PetscCall(Tell(monitor, PETSC_FALSE, format, arguments));
  va_end(arguments);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmMonitorLine(const MpmMonitor *monitor, const char format[], ...)
{
  va_list arguments;

  PetscFunctionBeginUser;
  va_start(arguments, format);
  PetscCall(Tell(monitor, PETSC_TRUE, format, arguments));
  va_end(arguments);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmMonitorCreate(MpmMonitor *monitor)
{
  static const char *const names[] = {"MpmSetup", "MpmTransfer", "MpmResidual", "MpmJacobian",
                                      "MpmSolve", "MpmMigrate",  "MpmOutput",   "MpmGradient"};
  PetscClassId class               = 0;

  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(monitor, sizeof(*monitor)));
  for (PetscInt k = 0; k < MPM_TIME_COUNT; k++) { /* one event for all models of a process */
    PetscCall(PetscLogEventGetId(names[k], &monitor->event[k]));
    if (monitor->event[k] >= 0) continue;
    if (!class) PetscCall(PetscClassIdRegister("Talus", &class));
    PetscCall(PetscLogEventRegister(names[k], class, &monitor->event[k]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmMonitorBegin(MpmMonitor *monitor, MpmTimer timer, PetscLogDouble *since)
{
  PetscFunctionBeginUser;
  PetscCall(PetscLogEventBegin(monitor->event[timer], 0, 0, 0, 0));
  PetscCall(PetscTime(since));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmMonitorEnd(MpmMonitor *monitor, MpmTimer timer, PetscLogDouble since)
{
  PetscLogDouble now;

  PetscFunctionBeginUser;
  PetscCall(PetscTime(&now));
  monitor->seconds[timer] += now - since;
  PetscCall(PetscLogEventEnd(monitor->event[timer], 0, 0, 0, 0));
  PetscFunctionReturn(PETSC_SUCCESS);
}

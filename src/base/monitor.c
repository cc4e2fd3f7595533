/*
  What the engine tells of itself while it works.
*/
#include <stdarg.h>
#include "base/base.h"

#define LONGEST_MESSAGE 1024

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

PetscErrorCode MpmMonitorLine(const MpmMonitor *monitor, const char format[], ...)
{
  va_list arguments;

  PetscFunctionBeginUser;
  va_start(arguments, format);
  PetscCall(Tell(monitor, PETSC_TRUE, format, arguments));
  va_end(arguments);
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MpmMonitorClock(MpmMonitor *monitor, MpmTimer timer, PetscLogDouble since)
{
  PetscLogDouble now;

  (void)PetscTime(&now);
  monitor->seconds[timer] += now - since;
}

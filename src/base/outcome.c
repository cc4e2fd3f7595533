/*
  Outcome of a step: the failure as a code for the program and as a line for people.
*/
#include <stdarg.h>
#include "base/outcome.h"

void MpmOutcomeClear(MpmOutcome *outcome)
{
  outcome->code      = MPM_OUTCOME_DONE;
  outcome->retryable = PETSC_FALSE;
  outcome->text[0]   = '\0';
}

/* The format's arguments may point to the text that is replaced. */
static PetscErrorCode SetText(MpmOutcome *outcome, const char format[], va_list arguments)
{
  char text[MPM_OUTCOME_TEXT];

  PetscFunctionBeginUser;
  PetscCall(PetscVSNPrintf(text, sizeof(text), format, NULL, arguments));
  PetscCall(PetscStrncpy(outcome->text, text, sizeof(outcome->text)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmOutcomeFail(MpmOutcome *outcome, MpmOutcomeCode code, const char format[], ...)
{
  va_list arguments;

  PetscFunctionBeginUser;
  va_start(arguments, format);
  PetscCall(SetText(outcome, format, arguments));
  va_end(arguments);
  outcome->code = code;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmOutcomeExplain(MpmOutcome *outcome, const char format[], ...)
{
  va_list arguments;

  PetscFunctionBeginUser;
  va_start(arguments, format);
  PetscCall(SetText(outcome, format, arguments));
  va_end(arguments);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmOutcomeBroadcast(MPI_Comm comm, PetscMPIInt rank, MpmOutcome *outcome)
{
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Bcast(outcome, (PetscMPIInt)sizeof(*outcome), MPI_BYTE, rank, comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

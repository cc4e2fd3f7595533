/*
  Signals by which batch systems announce the end of a job, and users at a terminal ask for it.

  A handler has no argument of ours and may do next to nothing: the note that it leaves is a global variable, with the
  actions that it replaces the only ones of the program. All ranks look at it together after each step (checkpoint.c),
  for not all of them may be sent the signal.
*/
#include <signal.h>
#include <string.h>
#include "observe/signals.h"

static volatile sig_atomic_t caught;
static struct {
  int              number;
  PetscBool        ignored, once; /* once: a second signal ends at once */
  struct sigaction before;
} actions[] = {
  {.number = SIGTERM},
  {.number = SIGUSR1},
  {.number = SIGINT, .once = PETSC_TRUE},
  {.number = SIGXFSZ, .ignored = PETSC_TRUE} /* a file beyond the limit on its size: the write reports it */
};

static void TakeNote(int number)
{
  (void)number;
  caught = 1;
}

PetscErrorCode MpmSignalsCatch(void)
{
  PetscFunctionBeginUser;
  caught = 0;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(actions); k++) {
    struct sigaction action;

    memset(&action, 0, sizeof(action));
    action.sa_handler = actions[k].ignored ? SIG_IGN : TakeNote;
    action.sa_flags   = actions[k].once ? (int)(SA_RESTART | SA_RESETHAND) : SA_RESTART;
    (void)sigemptyset(&action.sa_mask);
    PetscCheck(!sigaction(actions[k].number, NULL, &actions[k].before), PETSC_COMM_SELF, PETSC_ERR_SYS,
               "signal %d has no action", actions[k].number);
    if (actions[k].once && actions[k].before.sa_handler == SIG_IGN) continue; /* a shell's background job */
    PetscCheck(!sigaction(actions[k].number, &action, NULL), PETSC_COMM_SELF, PETSC_ERR_SYS,
               "signal %d cannot be caught", actions[k].number);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSignalsRelease(void)
{
  PetscFunctionBeginUser;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(actions); k++)
    (void)sigaction(actions[k].number, &actions[k].before, NULL);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscBool MpmSignalsCaught(void)
{
  return (PetscBool)(caught != 0);
}

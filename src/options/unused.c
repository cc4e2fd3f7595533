/*
  Options of PETSc's that the user gave and nobody used; those that PETSc does not have are refused (petsc_names.c).

  The user's options are kept when the scene has been read, before presets add theirs. A name may be asked for late (a
  preconditioner's, when it is set up; a later stage's), so most are told of at the end of the run; Newton's method and
  its linear solver have asked for all of theirs once they have solved.
*/
#include "options/options.h"
#include "options/record.h"

#include <string.h>

/* PETSc uses these when it ends. */
static const char *const at_the_end[] = {
  "citations",   "get_total_flops", "log",          "log_all",      "log_mpe",      "malloc_debug",
  "malloc_dump", "malloc_test",     "malloc_view",  "memory_view",  "mpidump",      "no_signal_handler",
  "nox",         "nox_warning",     "objects_dump", "options_left", "options_view", "x_virtual"};

static PetscErrorCode IsLate(const char name[], PetscBool *late)
{
  PetscFunctionBegin;
  *late = PETSC_FALSE;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(at_the_end) && !*late; k++)
    PetscCall(PetscStrcasecmp(name, at_the_end[k], late));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmForeignOptionsKeep(MpmRecord record)
{
  MpmDatabaseOption *options;
  PetscInt           count;
  char              *text;

  PetscFunctionBegin;
  if (!record || record->foreign) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmDatabaseGetForeign(&count, &options, &text));
  PetscCall(PetscCalloc1(count, &record->foreign));
  for (PetscInt i = 0; i < count; i++) {
    MpmGivenOption *given = &record->foreign[record->foreign_count];
    PetscBool       late;

    PetscCall(IsLate(options[i].name, &late));
    if (late) continue;
    PetscCall(PetscStrallocpy(options[i].name, &given->name));
    PetscCall(MpmTextQuote(options[i].value ? options[i].value : "", &given->value));
    record->foreign_count++;
  }
  PetscCall(PetscFree(options));
  PetscCall(PetscFree(text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmForeignOptionsForget(MpmRecord record)
{
  PetscFunctionBegin;
  for (PetscInt i = 0; i < record->foreign_count; i++) {
    PetscCall(PetscFree(record->foreign[i].name));
    PetscCall(PetscFree(record->foreign[i].value));
  }
  PetscCall(PetscFree(record->foreign));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* True where any rank has used it: block solvers, for example, may be on some ranks only. */
static PetscErrorCode IsUsed(MPI_Comm comm, const char name[], PetscBool *used)
{
  PetscFunctionBegin;
  PetscCall(PetscOptionsUsed(NULL, name, used));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, used, 1, MPM_MPI_BOOL, MPI_LOR, comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmOptionsWarnUnused(const MpmOptions *options, MpmMoment moment)
{
  MpmRecord record = options->record;

  PetscFunctionBegin;
  if (record->moment >= moment) PetscFunctionReturn(PETSC_SUCCESS);
  record->moment = moment;
  for (PetscInt i = 0; i < record->foreign_count; i++) {
    MpmGivenOption *given = &record->foreign[i];
    PetscBool       skip  = given->told;

    if (moment == MPM_AFTER_SOLVE && strncmp(given->name, "snes_", 5) && strncmp(given->name, "ksp_", 4)) continue;
    if (!skip) PetscCall(IsUsed(options->comm, given->name, &skip));
    if (skip) continue;
    given->told = PETSC_TRUE;
    PetscCall(PetscFPrintf(options->comm, stderr,
                           "talus: warning: -%s%s%s: nobody used this option: this run has no solver that takes it\n",
                           given->name, *given->value ? " " : "", given->value));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

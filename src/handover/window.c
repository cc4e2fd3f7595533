/*
  Columns in a window, and those that come in later.

  A column comes in at the time of the first state of the file that has its centre in the window, at the place and with
  the velocity of that state. Columns are known by their ids.
*/
#include "options/options.h"
#include "handover/window.h"

static PetscBool IsInside(const MpmWindow *window, const PetscReal x[2])
{
  for (PetscInt a = 0; a < 2; a++)
    if (x[a] < window->lower[a] || x[a] > window->upper[a]) return PETSC_FALSE;
  return PETSC_TRUE;
}

/* One more than the largest id over all ranks, and marks of the columns in the window. */
static PetscErrorCode Mark(MPI_Comm comm, const MpmFlowColumns *columns, MpmWindow *window)
{
  PetscFunctionBeginUser;
  window->ids = 0;
  for (PetscInt k = 0; k < columns->count; k++) window->ids = PetscMax(window->ids, columns->at[k].id + 1);
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &window->ids, 1, MPIU_INT, MPI_MAX, comm));
  PetscCall(PetscCalloc1((size_t)window->ids + 1, &window->known));
  for (PetscInt k = 0; k < columns->count; k++)
    if (IsInside(window, columns->at[k].x)) window->known[columns->at[k].id] = 1;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, window->known, (PetscMPIInt)window->ids, MPI_CHAR, MPI_MAX, comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmWindowCut(MPI_Comm comm, MpmWindow *window, MpmFlowColumns *columns)
{
  PetscInt kept = 0;

  PetscFunctionBeginUser;
  PetscCall(Mark(comm, columns, window));
  window->time = columns->time;
  for (PetscInt k = 0; k < MPM_WINDOW_MASSES; k++) window->mass[k] = 0.;
  for (PetscInt k = 0; k < columns->count; k++) {
    const PetscBool inside = IsInside(window, columns->at[k].x);

    window->mass[inside ? MPM_WINDOW_INSIDE : MPM_WINDOW_OUTSIDE] += columns->at[k].mass;
    if (inside) columns->at[kept++] = columns->at[k];
  }
  columns->count = kept;
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, window->mass, MPM_WINDOW_MASSES, MPIU_REAL, MPIU_SUM, comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Those of a later state that are in the window for the first time. */
static PetscErrorCode Append(MPI_Comm comm, const MpmFlowColumns *state, MpmWindow *window, MpmFlowColumns *columns,
                             PetscReal *mass)
{
  PetscInt fresh = 0;

  PetscFunctionBeginUser;
  PetscCall(PetscRealloc((size_t)(columns->count + state->count + 1) * sizeof(*columns->at), &columns->at));
  for (PetscInt k = 0; k < state->count; k++) {
    const MpmFlowColumn *column = &state->at[k];

    if (column->id >= window->ids || window->known[column->id] || !IsInside(window, column->x)) continue;
    window->known[column->id]                 = 1;
    columns->at[columns->count + fresh]       = *column;
    columns->at[columns->count + fresh].entry = state->time - window->time;
    *mass += column->mass;
    fresh++;
  }
  columns->count += fresh;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, window->known, (PetscMPIInt)window->ids, MPI_CHAR, MPI_MAX, comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmWindowFollow(const MpmOptions *block, const char *path, const char *step, const MpmBed *bed,
                               MpmWindow *window, MpmFlowColumns *columns)
{
  PetscInt  count, *steps;
  PetscReal mass = 0.;

  PetscFunctionBeginUser;
  PetscCall(MpmColumnsSteps(block->comm, path, step, NULL, &count, &steps));
  MpmCheckInput(count, "-%sinflow: %s has no state after step %s", block->prefix, path, step);
  for (PetscInt k = 0; k < count; k++) {
    MpmFlowColumns state = {0};
    char           name[32];

    PetscCall(PetscSNPrintf(name, sizeof(name), "%" PetscInt_FMT, steps[k]));
    PetscCall(MpmColumnsReadFile(block, path, name, bed, &state));
    PetscCall(Append(block->comm, &state, window, columns, &mass));
    PetscCall(PetscFree(state.at));
  }
  PetscCall(MPIU_Allreduce(&mass, &window->mass[MPM_WINDOW_LATER], 1, MPIU_REAL, MPIU_SUM, block->comm));
  PetscCall(PetscFree(steps));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmWindowDestroy(MpmWindow *window)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(window->known));
  PetscFunctionReturn(PETSC_SUCCESS);
}

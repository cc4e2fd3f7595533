/*
  The state of a run as an object: contents of a checkpoint, and of a roll-back.
*/
#include "particles/particles.h"
#include "query/state.h"

/* The numbers that belong to no part. */
static PetscErrorCode AddRows(MpmState *state)
{
  const MpmRow rows[] = {
    {"time", MPM_ROW_REAL, MPM_ROW_STATE, &state->time, 0, 0},
    {"step_last", MPM_ROW_REAL, MPM_ROW_STATE, &state->dt.last, 0, 0},
    {"step_before_last", MPM_ROW_REAL, MPM_ROW_STATE, &state->dt.before, 0, 0},
    {"step", MPM_ROW_INT, MPM_ROW_RUN, &state->step, 0, 0},
    {"rescue_cuts", MPM_ROW_INT, MPM_ROW_RUN, &state->cuts.step, 0, 0},
    {"step_cuts", MPM_ROW_INT, MPM_ROW_RUN, &state->cuts.total, 0, 0},
    {"step_length", MPM_ROW_REAL, MPM_ROW_RUN, &state->dt.nominal, 0, 0},
    {"step_wanted", MPM_ROW_REAL, MPM_ROW_RUN, &state->dt.wanted, 0, 0},
    {"stage", MPM_ROW_INT, MPM_ROW_RUN, &state->stage, 0, 0},
    {"stage_start", MPM_ROW_REAL, MPM_ROW_RUN, &state->period.start, 0, 0},
    {"active_dofs_max", MPM_ROW_INT64, MPM_ROW_RUN, &state->active_dofs_max, 0, 0},
    {"reference_output", MPM_ROW_BOOL, MPM_ROW_RUN, &state->reference_output, 0, 0},
  };

  PetscFunctionBeginUser;
  PetscCall(MpmRowsAdd(state->rows, NULL, PETSC_STATIC_ARRAY_LENGTH(rows), rows));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmStateCreate(MpmState *state)
{
  PetscFunctionBeginUser;
  PetscCall(PetscNew(&state->particles));
  PetscCall(PetscNew(&state->rows));
  PetscCall(AddRows(state));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmStateDestroy(MpmState *state)
{
  PetscFunctionBeginUser;
  PetscCall(MpmParticlesDestroy(state->particles));
  PetscCall(PetscFree(state->particles));
  PetscCall(PetscFree(state->acting.bcs));
  PetscCall(PetscFree(state->acting.loads));
  PetscCall(PetscFree(state->acting.walls.at));
  PetscCall(PetscFree(state->placements));
  PetscCall(PetscFree(state->scheme.fading));
  PetscCall(PetscFree(state->relaxing.ended));
  PetscCall(MpmRowsDestroy(&state->rows));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmStateSave(const MpmState *state, MpmRowValues *values)
{
  PetscFunctionBeginUser;
  PetscCall(MpmRowsSave(state->rows, values));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmStateLoad(MpmState *state, const MpmRowValues *values, const char begin[])
{
  PetscFunctionBeginUser;
  PetscCall(MpmRowsLoad(state->rows, values, begin, PETSC_FALSE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmStateCopy(const MpmState *state, MpmStateKept *kept)
{
  PetscFunctionBeginUser;
  PetscCall(MpmRowsSave(state->rows, &kept->values));
  PetscCall(PetscNew(&kept->points));
  PetscCall(MpmParticlesKeep(state->particles, kept->points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmStatePutBack(MpmState *state, const MpmStateKept *kept)
{
  PetscFunctionBeginUser;
  PetscCall(MpmParticlesTakeUp(state->particles, kept->points));
  PetscCall(MpmRowsLoad(state->rows, &kept->values, "", PETSC_TRUE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmStateReturn(MpmState *state, MpmStateKept *kept)
{
  PetscFunctionBeginUser;
  PetscCall(MpmStatePutBack(state, kept));
  PetscCall(MpmStateForget(kept));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmStateForget(MpmStateKept *kept)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(kept->points->data));
  PetscCall(PetscFree(kept->points));
  PetscCall(MpmRowValuesDestroy(&kept->values));
  PetscFunctionReturn(PETSC_SUCCESS);
}

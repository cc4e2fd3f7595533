#pragma once
/*
  The steps of a run as its derivatives need them: states, lengths and solutions.
*/
#include "base/base.h"
#include "query/model.h"
#include "sensitivity/tape_store.h"

/* One step. */
typedef struct {
  PetscReal    time, dt; /* s; time of the run at its end */
  PetscInt     stage;
  PetscInt     row;   /* of the collected curves, at its end */
  PetscInt     count; /* owned unknowns */
  PetscScalar *x;     /* the solution, in the solver's units */
  PetscScalar *first; /* of two stages, the first one's; or NULL */
} MpmTapeStep;

typedef struct {
  PetscInt     count, capacity;
  MpmTapeStep *step;
  MpmTapeStore states;
  MpmStateKept end;  /* the state after the last step, as the first replay begins */
  PetscInt     next; /* behind the step at whose solution the model stands; 0: none */
} MpmTape;

/* The run begins. */
PetscErrorCode MpmTapeBegin(MpmModel model, MpmTape *tape);
/* The step that has just been accepted, with its row of the curves. Collective. */
PetscErrorCode MpmTapeRecord(MpmModel model, PetscInt row, MpmTape *tape);
/* The next step starts from the present state, which differs from the last step's end. Nothing before Begin.
   Collective. */
PetscErrorCode MpmTapeRestart(MpmModel model, MpmTape *tape);
/* True where step n is the first one, or the first of its stage. */
PetscBool MpmTapeBeginsStage(const MpmTape *tape, PetscInt n);
/*
  The model stands at the solution of step n, of its last stage, with its space and loads. Replays go forward, or
  backward. The state is kept for another replay. Done: the steps from n on are not replayed any more. Finish: the model
  returns to the run's end, and the tape is empty.
*/
PetscErrorCode MpmTapeReplay(MpmModel model, MpmTape *tape, PetscInt n, PetscBool forward);
/* True where step n has two stages. First: from there to the first one's solution. Second: back, evaluated there. */
PetscBool      MpmTapeHasTwoStages(const MpmTape *tape, PetscInt n);
PetscErrorCode MpmTapeFirstStage(MpmModel model, const MpmTape *tape, PetscInt n);
PetscErrorCode MpmTapeSecondStage(MpmModel model, const MpmTape *tape, PetscInt n);
PetscErrorCode MpmTapeDone(MpmTape *tape, PetscInt n);
PetscErrorCode MpmTapeFinish(MpmModel model, MpmTape *tape);
PetscErrorCode MpmTapeDestroy(MpmTape *tape);

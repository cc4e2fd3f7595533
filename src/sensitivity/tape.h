#pragma once
/*
  The steps of a run as its derivatives need them: states, lengths and solutions.
*/
#include "base/base.h"
#include "query/model.h"

/* One step. */
typedef struct {
  MpmStateKept start;    /* empty while the step is replayed */
  PetscReal    time, dt; /* s; time of the run at its end */
  PetscInt     count;    /* owned unknowns */
  PetscScalar *x;        /* the solution, in the solver's units */
} MpmTapeStep;

typedef struct {
  PetscInt     count, capacity;
  MpmTapeStep *step;
  MpmStateKept end;          /* the state after the last step */
  PetscReal    bytes, limit; /* of this rank; limit: of all ranks */
} MpmTape;

/* The run begins. */
PetscErrorCode MpmTapeBegin(MpmModel model, MpmTape *tape);
/* The step that has just been accepted. Collective. */
PetscErrorCode MpmTapeRecord(MpmModel model, MpmTape *tape);
/*
  The model stands at the solution of step n: space, loads and residual are those of its last evaluation. The state is
  kept for another replay. Finish: the model returns to the run's end, and the tape is empty.
*/
PetscErrorCode MpmTapeReplay(MpmModel model, MpmTape *tape, PetscInt n);
PetscErrorCode MpmTapeFinish(MpmModel model, MpmTape *tape);
PetscErrorCode MpmTapeDestroy(MpmTape *tape);

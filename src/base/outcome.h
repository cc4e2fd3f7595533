#pragma once
/*
  Outcome of a step, of one of its parts or of a check of a file.
*/
#include "base/base.h"
#include "base/types.h"

#define MPM_OUTCOME_TEXT 448

/* Kinds of failure; 0: none. */
typedef enum {
  MPM_OUTCOME_DONE,
  MPM_OUTCOME_NO_SOLUTION,   /* Newton's method without convergence, relaxation without rest */
  MPM_OUTCOME_NO_ANSWER,     /* law without an answer at a point */
  MPM_OUTCOME_OUTSIDE,       /* point outside of the grid */
  MPM_OUTCOME_UNCONSTRAINED, /* motion without resistance */
  MPM_OUTCOME_UNSTABLE,      /* equilibrium without stability */
  MPM_OUTCOME_REFUSED,       /* solution beyond a limit of the scene: error in time, way of a point */
  MPM_OUTCOME_INADMISSIBLE,  /* state or conditions that allow no step */
  MPM_OUTCOME_FILE           /* file that is damaged or of another origin */
} MpmOutcomeCode;

struct MpmOutcome {
  MpmOutcomeCode code;
  PetscBool      retryable;              /* true where a shorter step may succeed */
  char           text[MPM_OUTCOME_TEXT]; /* reason of the failure, one line; empty without failure */
};

/* Success. */
void MpmOutcomeClear(MpmOutcome *outcome);
/* Failure with a reason, which may quote the text of before; `retryable` stays. */
PetscErrorCode MpmOutcomeFail(MpmOutcome *outcome, MpmOutcomeCode code, const char format[], ...)
  PETSC_ATTRIBUTE_FORMAT(3, 4);
/* Another reason for the present failure, which may quote the text of before. */
PetscErrorCode MpmOutcomeExplain(MpmOutcome *outcome, const char format[], ...) PETSC_ATTRIBUTE_FORMAT(2, 3);
/* The outcome of one rank becomes that of all. */
PetscErrorCode MpmOutcomeBroadcast(MPI_Comm comm, PetscMPIInt rank, MpmOutcome *outcome);

#pragma once
/*
  Where the states of a tape's steps are kept: all of them in memory or in a file, or as many as the memory takes.

  While a run is recorded and its states outgrow the memory, every second one is forgotten. Backward, states in between
  are found again by the steps themselves from their solutions, which are all kept: a step then costs an evaluation, and
  gives the very bits that it gave first. Those that are kept on the way are chosen by the binomial rule of Griewank and
  Walther (2000), doi:10.1145/347837.347846.
*/
#include "query/model.h"

typedef enum { MPM_STORE_MEMORY, MPM_STORE_DISK } MpmTapeStoreKind;
extern const char *const MpmTapeStoreKinds[]; /* their names, NULL behind the last */

/* One state: in memory, or where it begins in the file. */
typedef struct {
  PetscBool    there;
  PetscBool    pinned; /* no step leads to it */
  MpmStateKept kept;
  PetscInt64   place, bytes; /* in the file; of this rank's points */
} MpmTapeState;

typedef struct {
  MpmTapeStoreKind kind;
  PetscReal        limit;  /* bytes in memory, over all ranks */
  PetscReal        bytes;  /* of this rank, in memory */
  PetscInt         stride; /* each so-manieth state is kept */
  PetscInt         count, capacity;
  MpmTapeState    *at;   /* by the number of steps before it */
  FILE            *file; /* of this rank, without a name; NULL: none yet */
  PetscInt64       end;  /* of the file */
} MpmTapeStore;

/* Numbers of the tape's own join those of the states. */
PetscErrorCode MpmTapeStoreCount(MpmModel model, PetscReal bytes, MpmTapeStore *store);
/* The state after n steps, which is the model's; states must come in order. Collective. */
PetscErrorCode MpmTapeStoreAdd(MpmModel model, PetscInt n, MpmTapeStore *store);
/* The model's state takes the place of that after n steps, and stays. Collective. */
PetscErrorCode MpmTapeStorePin(MpmModel model, PetscInt n, MpmTapeStore *store);
/* Fails where the memory is too little for another state beside those that are there. Collective. */
PetscErrorCode MpmTapeStoreCheck(MpmModel model, const MpmTapeStore *store);
/* The last state that is there among the first n + 1. */
PetscInt MpmTapeStoreLast(const MpmTapeStore *store, PetscInt n);
/* State n becomes the model's, and stays in the store. Collective. */
PetscErrorCode MpmTapeStoreTake(MpmModel model, PetscInt n, MpmTapeStore *store);
/* On the way from state k to state n: the first state behind k that is to be kept, or n. Collective. */
PetscErrorCode MpmTapeStoreNext(MpmModel model, PetscInt k, PetscInt n, const MpmTapeStore *store, PetscInt *next);
/* The model's state is kept as that after n steps, where Next() says so. Collective. */
PetscErrorCode MpmTapeStoreKeep(MpmModel model, PetscInt n, MpmTapeStore *store);
/* States from n on are not needed any more. */
PetscErrorCode MpmTapeStoreForget(PetscInt n, MpmTapeStore *store);
PetscErrorCode MpmTapeStoreDestroy(MpmTapeStore *store);

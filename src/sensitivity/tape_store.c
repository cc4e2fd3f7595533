/*
  The states of a tape's steps, in memory or in a file.
*/
#include <errno.h>
#include <string.h>
#include "particles/particles.h"
#include "sensitivity/tape_store.h"

const char *const MpmTapeStoreKinds[] = {"memory", "disk", NULL};

/* Bytes over all ranks. */
static PetscErrorCode Total(MpmModel model, PetscReal bytes, PetscReal *total)
{
  PetscFunctionBeginUser;
  *total = bytes;
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, total, 1, MPIU_REAL, MPIU_SUM, model->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- a state ---- */

static PetscErrorCode OpenFile(MpmModel model, MpmTapeStore *store)
{
  char path[PETSC_MAX_PATH_LEN];

  PetscFunctionBeginUser;
  if (store->file) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscSNPrintf(path, sizeof(path), "%s_tape_%d", model->scene.name.prefix, model->rank));
  store->file = fopen(path, "w+b");
  PetscCheck(store->file, PETSC_COMM_SELF, PETSC_ERR_FILE_OPEN, "%s: %s", path, strerror(errno));
  PetscCheck(!remove(path), PETSC_COMM_SELF, PETSC_ERR_FILE_OPEN, "%s: %s", path, strerror(errno));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The points' numbers go to the end of the file. */
static PetscErrorCode Write(MpmModel model, MpmTapeStore *store, MpmTapeState *state)
{
  MpmParked *points = state->kept.points;

  PetscFunctionBeginUser;
  PetscCall(OpenFile(model, store));
  state->place = store->end;
  PetscCheck(!fseeko(store->file, (off_t)store->end, SEEK_SET) &&
               fwrite(points->data, 1, (size_t)state->bytes, store->file) == (size_t)state->bytes,
             PETSC_COMM_SELF, PETSC_ERR_FILE_WRITE, "the states of the steps (-mpm_gradient_store disk): %s",
             strerror(errno));
  store->end += state->bytes;
  PetscCall(PetscFree(points->data));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Read(MpmTapeStore *store, const MpmTapeState *state)
{
  MpmParked *points = state->kept.points;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1((size_t)state->bytes, &points->data));
  PetscCheck(!fseeko(store->file, (off_t)state->place, SEEK_SET) &&
               fread(points->data, 1, (size_t)state->bytes, store->file) == (size_t)state->bytes,
             PETSC_COMM_SELF, PETSC_ERR_FILE_READ, "the states of the steps (-mpm_gradient_store disk): %s",
             strerror(errno));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTapeStoreKeep(MpmModel model, PetscInt n, MpmTapeStore *store)
{
  MpmTapeState *state;

  PetscFunctionBeginUser;
  if (n >= store->capacity) {
    const PetscInt before = store->capacity;

    store->capacity = 2 * n + 16;
    PetscCall(PetscRealloc((size_t)store->capacity * sizeof(*store->at), &store->at));
    PetscCall(PetscArrayzero(&store->at[before], store->capacity - before));
  }
  store->count = PetscMax(store->count, n + 1);
  state        = &store->at[n];
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, model->disc.points));
  PetscCall(MpmStateCopy(&model->state, &state->kept));
  state->there = PETSC_TRUE;
  state->bytes = (PetscInt64)MpmParkedBytes(model->state.particles, state->kept.points);
  if (store->kind == MPM_STORE_DISK) PetscCall(Write(model, store, state));
  else store->bytes += (PetscReal)state->bytes;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Forget(MpmTapeStore *store, MpmTapeState *state)
{
  PetscFunctionBeginUser;
  if (!state->there) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmStateForget(&state->kept));
  if (store->kind == MPM_STORE_MEMORY) store->bytes -= (PetscReal)state->bytes;
  PetscCall(PetscMemzero(state, sizeof(*state)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTapeStoreForget(PetscInt n, MpmTapeStore *store)
{
  PetscFunctionBeginUser;
  for (PetscInt k = n; k < store->count; k++) PetscCall(Forget(store, &store->at[k]));
  store->count = PetscMin(store->count, n);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTapeStoreDestroy(MpmTapeStore *store)
{
  PetscFunctionBeginUser;
  PetscCall(MpmTapeStoreForget(0, store));
  PetscCall(PetscFree(store->at));
  if (store->file) (void)fclose(store->file);
  store->file  = NULL;
  store->end   = 0;
  store->bytes = 0.;
  store->count = store->capacity = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- a run that is recorded ---- */

PetscErrorCode MpmTapeStoreCount(MpmModel model, PetscReal bytes, MpmTapeStore *store)
{
  PetscReal total;

  PetscFunctionBeginUser;
  store->bytes += bytes;
  if (store->kind == MPM_STORE_DISK) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Total(model, store->bytes, &total));
  for (PetscInt stride = store->stride; total > store->limit && stride < store->count; stride = store->stride) {
    store->stride = 2 * stride;
    for (PetscInt k = stride; k < store->count; k += 2 * stride)
      if (!store->at[k].pinned) PetscCall(Forget(store, &store->at[k]));
    PetscCall(Total(model, store->bytes, &total));
  }
  MpmCheckInput(total <= store->limit,
                "-mpm_gradient_memory %g: is too little: the solutions of the steps and one state take %g bytes",
                (double)store->limit, (double)total);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTapeStoreCheck(MpmModel model, const MpmTapeStore *store)
{
  PetscReal total;

  PetscFunctionBeginUser;
  if (store->kind == MPM_STORE_DISK) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Total(model, 2. * store->bytes, &total));
  MpmCheckInput(total <= store->limit, "-mpm_gradient_memory %g: is too little: two states take %g bytes",
                (double)store->limit, (double)total);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTapeStorePin(MpmModel model, PetscInt n, MpmTapeStore *store)
{
  PetscFunctionBeginUser;
  if (n < store->count) PetscCall(Forget(store, &store->at[n]));
  PetscCall(MpmTapeStoreKeep(model, n, store));
  store->at[n].pinned = PETSC_TRUE;
  PetscCall(MpmTapeStoreCount(model, 0., store));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTapeStoreAdd(MpmModel model, PetscInt n, MpmTapeStore *store)
{
  PetscFunctionBeginUser;
  if (n % store->stride == 0) PetscCall(MpmTapeStoreKeep(model, n, store));
  PetscCall(MpmTapeStoreCount(model, 0., store));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- backward ---- */

PetscInt MpmTapeStoreLast(const MpmTapeStore *store, PetscInt n)
{
  PetscInt k = PetscMin(n, store->count - 1);

  while (k > 0 && !store->at[k].there) k--;
  return k;
}

PetscErrorCode MpmTapeStoreTake(MpmModel model, PetscInt n, MpmTapeStore *store)
{
  MpmTapeState *state = &store->at[n];

  PetscFunctionBeginUser;
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, model->disc.points));
  if (store->kind == MPM_STORE_DISK) PetscCall(Read(store, state));
  PetscCall(MpmStatePutBack(&model->state, &state->kept));
  if (store->kind == MPM_STORE_DISK) PetscCall(PetscFree(state->kept.points->data));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* How many steps can be gone back with so many states kept at a time, and none taken more than `times` times. */
static PetscReal Reach(PetscInt states, PetscInt times)
{
  PetscReal reach = times < 0 || states < 0 ? 0. : 1.;

  for (PetscInt k = 1; k <= times; k++) reach *= (PetscReal)(states + k) / (PetscReal)k;
  return reach;
}

PetscErrorCode MpmTapeStoreNext(MpmModel model, PetscInt k, PetscInt n, const MpmTapeStore *store, PetscInt *next)
{
  const PetscInt length = n - k;
  PetscReal      total, each = (PetscReal)store->at[MpmTapeStoreLast(store, k)].bytes;
  PetscInt       states = length, times = 1;

  PetscFunctionBeginUser;
  if (store->kind == MPM_STORE_MEMORY) {
    PetscCall(Total(model, store->bytes, &total));
    PetscCall(Total(model, each, &each));
    states = 1 + (PetscInt)PetscClipInterval((store->limit - total) / PetscMax(each, 1.), 0., (PetscReal)length);
  }
  while (Reach(states, times) < (PetscReal)length) times++;
  *next = k + (PetscInt)PetscMin(Reach(states, times - 1), (PetscReal)length - Reach(states - 1, times - 1));
  *next = states < 2 ? n : PetscClipInterval(*next, k + 1, n);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Largest values of all states at the nodes of the grid. The largest over the ranks is the largest of all, whichever
  rank has owned a node when; the first time of arrival likewise.
*/
#include "space/space.h"
#include "runout/runout_impl.h"

#define SHARE 0.01 /* of the largest depth at the start: the threshold where none is given */

PetscErrorCode MpmPeaksSetUp(const MpmGrid *grid, MpmPeaks *peaks)
{
  PetscFunctionBeginUser;
  peaks->count  = grid->nodes[0] * grid->nodes[1];
  peaks->depths = PetscMax(peaks->depths, 1);
  if (peaks->depth) peaks->least = peaks->depth[0];
  PetscCall(PetscCalloc1((size_t)peaks->count * MPM_PEAK_COUNT, &peaks->largest));
  PetscCall(PetscMalloc1((size_t)peaks->count * (size_t)peaks->depths, &peaks->arrival));
  for (PetscInt k = 0; k < peaks->count * peaks->depths; k++) peaks->arrival[k] = PETSC_MAX_REAL;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPeaksDestroy(MpmPeaks *peaks)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(peaks->depth));
  PetscCall(PetscFree(peaks->largest));
  PetscCall(PetscFree(peaks->arrival));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The threshold that follows from the first state. */
static PetscErrorCode FindLeast(MpmModel model, MpmPeaks *peaks)
{
  PetscReal   deepest = 0.;
  MpmNodeFlow flow;

  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < model->disc.space->owned; i++) {
    MpmRunoutNode(model, i, &flow);
    deepest = PetscMax(deepest, flow.depth);
  }
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &deepest, 1, MPIU_REAL, MPIU_MAX, model->comm));
  peaks->least = SHARE * deepest;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPeaksObserve(MpmModel model, PetscReal time)
{
  MpmPeaks   *peaks = &model->runout->peaks;
  MpmNodeFlow flow;

  PetscFunctionBeginUser;
  if (!(peaks->least > 0.)) PetscCall(FindLeast(model, peaks));
  for (PetscInt i = 0; i < model->disc.space->owned; i++) {
    const PetscInt at      = MpmRunoutLatticeNode(model, i);
    PetscReal     *largest = &peaks->largest[at];

    MpmRunoutNode(model, i, &flow);
    largest[0] = PetscMax(largest[0], flow.depth);
    if (!(flow.depth > peaks->least)) continue;
    largest[MPM_PEAK_SPEED * peaks->count]    = PetscMax(largest[MPM_PEAK_SPEED * peaks->count], flow.speed);
    largest[MPM_PEAK_PRESSURE * peaks->count] = PetscMax(largest[MPM_PEAK_PRESSURE * peaks->count], flow.pressure);
    for (PetscInt k = 0; k < peaks->depths; k++) {
      PetscReal *arrival = &peaks->arrival[k * peaks->count + at];

      if (flow.depth > (peaks->depth ? peaks->depth[k] : peaks->least)) *arrival = PetscMin(*arrival, time);
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* `count` numbers at each node of the grid to rank 0; `to` is allocated there. */
static PetscErrorCode Gather(MpmModel model, MPI_Op op, PetscInt count, const PetscReal from[], PetscReal **to)
{
  const PetscInt nodes = model->runout->peaks.count;

  PetscFunctionBeginUser;
  *to = NULL;
  if (!model->rank) PetscCall(PetscMalloc1((size_t)nodes * (size_t)count, to));
  for (PetscInt k = 0; k < count; k++)
    PetscCallMPI(MPI_Reduce(&from[k * nodes], model->rank ? NULL : *to + k * nodes, (PetscMPIInt)nodes, MPIU_REAL, op,
                            0, model->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPeaksGather(MpmModel model, PetscReal **largest, PetscReal **arrival)
{
  const MpmPeaks *peaks = &model->runout->peaks;

  PetscFunctionBeginUser;
  PetscCall(Gather(model, MPIU_MAX, MPM_PEAK_COUNT, peaks->largest, largest));
  PetscCall(Gather(model, MPIU_MIN, peaks->depths, peaks->arrival, arrival));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- checkpoints ---- */

PetscBool MpmRunoutHasPeaks(const MpmModel model)
{
  return (PetscBool)(model->runout && model->runout->peaks.largest);
}

PetscErrorCode MpmRunoutSave(MpmModel model, MpmTextFile *bytes)
{
  const MpmPeaks *peaks = &model->runout->peaks;
  const size_t    size  = (size_t)peaks->count * sizeof(PetscReal);
  PetscReal      *part[2];

  PetscFunctionBeginUser;
  PetscCall(MpmPeaksGather(model, &part[0], &part[1]));
  for (PetscInt k = 0; k < 2 && !model->rank; k++) {
    const size_t more = size * (size_t)(k ? peaks->depths : MPM_PEAK_COUNT);

    PetscCall(MpmTextFileReserve(bytes, more));
    PetscCall(PetscMemcpy(bytes->data + bytes->length, part[k], more));
    bytes->length += more;
  }
  for (PetscInt k = 0; k < 2; k++) PetscCall(PetscFree(part[k]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmRunoutLoad(MpmModel model, const MpmTextFile *bytes)
{
  MpmPeaks    *peaks  = &model->runout->peaks;
  const size_t size   = (size_t)peaks->count * sizeof(PetscReal);
  PetscBool    differ = PETSC_FALSE;

  PetscFunctionBeginUser;
  if (!model->rank) differ = (PetscBool)(bytes->length != size * (size_t)(MPM_PEAK_COUNT + peaks->depths));
  PetscCallMPI(MPI_Bcast(&differ, 1, MPM_MPI_BOOL, 0, model->comm));
  MpmCheckInput(!differ, "-mpm_restart: its largest values are of other thresholds or nodes");
  if (model->rank) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMemcpy(peaks->largest, bytes->data, size * MPM_PEAK_COUNT));
  PetscCall(PetscMemcpy(peaks->arrival, bytes->data + size * MPM_PEAK_COUNT, size * (size_t)peaks->depths));
  PetscFunctionReturn(PETSC_SUCCESS);
}

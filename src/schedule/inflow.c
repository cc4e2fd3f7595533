/*
  Columns that come in later: their points are made with the others, parked, and returned at the start of the first
  step that does not begin before their time. Copies stay, for states that return. A checkpoint holds how many
  groups have come in.
*/
#include "grid/grid.h"
#include "entrainment/entrainment.h"
#include "handover/handover.h"
#include "particles/body.h"
#include "particles/particles.h"
#include "facets/outer_faces.h"
#include "query/model.h"
#include "step/energy.h"
#include "schedule/stage.h"

struct MpmInflow {
  PetscInt    count, entered; /* groups of one time of entry, ascending; how many are in */
  PetscReal  *time;           /* s */
  MpmParked  *parked;
  PetscReal **entry; /* per body: times by the number of a point; NULL: all at once. While groups are made */
};

PetscBool MpmInflowHas(const MpmModel model)
{
  for (PetscInt b = 0; model->scene.bodies && b < model->scene.bodies->count; b++) {
    const struct MpmHandover *from = MpmBodyHandover(model->scene.bodies->at[b]);

    if (from && from->later) return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* Times of entry of all points of a body, in the order of their ids, on every rank. */
static PetscErrorCode ShareEntries(MPI_Comm comm, MpmBody body, PetscInt *total, PetscReal **entry)
{
  const struct MpmHandover *from   = MpmBodyHandover(body);
  PetscInt                  before = 0;

  PetscFunctionBeginUser;
  *entry = NULL;
  *total = 0;
  if (!from || !from->later) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCallMPI(MPI_Scan(&from->count, &before, 1, MPIU_INT, MPI_SUM, comm));
  before -= from->count;
  PetscCall(MPIU_Allreduce(&from->count, total, 1, MPIU_INT, MPI_SUM, comm));
  PetscCall(PetscCalloc1(*total, entry));
  PetscCall(PetscArraycpy(&(*entry)[before], from->entry, from->count));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, *entry, (PetscMPIInt)*total, MPIU_REAL, MPI_SUM, comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The different times of entry but 0, ascending; `number` has the number of points of each body. */
static PetscErrorCode FindTimes(PetscInt bodies, const PetscInt number[], struct MpmInflow *inflow)
{
  PetscInt length = 0;

  PetscFunctionBeginUser;
  for (PetscInt b = 0; b < bodies; b++) length += number[b];
  PetscCall(PetscMalloc1(length, &inflow->time));
  length = 0;
  for (PetscInt b = 0; b < bodies; b++)
    for (PetscInt k = 0; k < number[b]; k++)
      if (inflow->entry[b][k] > 0.) inflow->time[length++] = inflow->entry[b][k];
  inflow->count = length;
  PetscCall(PetscSortRemoveDupsReal(&inflow->count, inflow->time));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Puts this rank's points of one time aside. */
static PetscErrorCode ParkGroup(MpmModel model, const PetscInt number[], PetscInt group)
{
  struct MpmInflow *inflow = model->state.scheme.inflow;
  PetscInt         *id, *index, local, found = 0;

  PetscFunctionBeginUser;
  PetscCall(DMSwarmGetLocalSize(model->state.particles->swarm, &local));
  PetscCall(PetscMalloc1(local, &index));
  PetscCall(MpmParticlesGetField(model->state.particles, "id", &id));
  for (PetscInt b = 0; b < model->scene.bodies->count; b++) {
    PetscInt first, end, room;

    if (!number[b]) continue;
    MpmBodyGetIds(model->scene.bodies->at[b], &first, &end);
    room = (end - first) / number[b];
    for (PetscInt p = 0; p < local; p++)
      if (id[p] >= first && id[p] < end && inflow->entry[b][(id[p] - first) / room] == inflow->time[group])
        index[found++] = p;
  }
  PetscCall(MpmParticlesRestoreField(model->state.particles, &id));
  PetscCall(PetscSortInt(found, index));
  PetscCall(MpmParticlesTakeOut(model->state.particles, found, index, &inflow->parked[group]));
  PetscCall(PetscFree(index));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmInflowRead(MpmModel model)
{
  PetscFunctionBeginUser;
  if (!MpmInflowHas(model)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscNew(&model->state.scheme.inflow));
  PetscCall(MpmRowsAdd(model->state.rows, "inflow", 1,
                       (const MpmRow[]){{"", MPM_ROW_INT, MPM_ROW_STATE, &model->state.scheme.inflow->entered, 0, 0}}));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmInflowPark(MpmModel model)
{
  const PetscInt    bodies = model->scene.bodies->count;
  struct MpmInflow *inflow = model->state.scheme.inflow;
  PetscInt         *number;

  PetscFunctionBeginUser;
  if (!inflow) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(bodies, &number));
  PetscCall(PetscCalloc1(bodies, &inflow->entry));
  for (PetscInt b = 0; b < bodies; b++)
    PetscCall(ShareEntries(model->comm, model->scene.bodies->at[b], &number[b], &inflow->entry[b]));
  PetscCall(FindTimes(bodies, number, inflow));
  PetscCall(PetscCalloc1(inflow->count, &inflow->parked));
  for (PetscInt k = 0; k < inflow->count; k++) PetscCall(ParkGroup(model, number, k));
  for (PetscInt b = 0; b < bodies; b++) PetscCall(PetscFree(inflow->entry[b]));
  PetscCall(PetscFree(inflow->entry));
  PetscCall(PetscFree(number));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmInflowEnter(MpmModel model, MpmOutcome *outcome)
{
  struct MpmInflow *inflow = model->state.scheme.inflow;

  PetscFunctionBeginUser;
  if (inflow->entered == inflow->count || inflow->time[inflow->entered] > model->state.time)
    PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, model->disc.points));
  PetscCall(MpmEnergyMark(model));
  while (inflow->entered < inflow->count && inflow->time[inflow->entered] <= model->state.time) {
    const MpmParked *parked = &inflow->parked[inflow->entered++];
    const size_t     bytes  = MpmParkedBytes(model->state.particles, parked);
    MpmParked        copy   = *parked;
    PetscInt         first;

    PetscCall(DMSwarmGetLocalSize(model->state.particles->swarm, &first));
    PetscCall(PetscMalloc1(bytes, &copy.data));
    PetscCall(PetscMemcpy(copy.data, parked->data, bytes));
    PetscCall(MpmParticlesReturn(model->state.particles, &copy));
    PetscCall(MpmEntrainmentEnter(model, first, parked->count, inflow->time[inflow->entered - 1]));
  }
  PetscCall(MpmParticlesDistribute(model->state.particles, model->disc.grid, outcome));
  PetscCall(MpmOuterFacesUpdate(model->state.particles, model->scene.materials, model->disc.grid));
  PetscCall(MpmEnergyRebase(model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmInflowDestroy(MpmModel model)
{
  struct MpmInflow *inflow = model->state.scheme.inflow;

  PetscFunctionBeginUser;
  if (!inflow) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt k = 0; k < inflow->count; k++) PetscCall(PetscFree(inflow->parked[k].data));
  PetscCall(PetscFree(inflow->parked));
  PetscCall(PetscFree(inflow->time));
  PetscCall(PetscFree(model->state.scheme.inflow));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  The account of mass, momentum and energy of a flow that exchanges mass: columns of the history.
*/
#include "base/rows.h"
#include "particles/particles.h"
#include "particles/point_mass.h"
#include "particles/points.h"
#include "space/space.h"
#include "transfer/momentum.h"
#include "query/query.h"
#include "entrainment/entrainment_impl.h"

/* Mass and momentum of points of this rank, from `first` on or at `place`, added over all ranks. */
static PetscErrorCode Sum(MpmModel model, PetscInt first, PetscInt count, const PetscInt place[], PetscReal sums[3])
{
  MpmPoints points;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < 3; k++) sums[k] = 0.;
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  for (PetscInt k = 0; k < count; k++) {
    const PetscInt  p    = place ? place[k] : first + k;
    const PetscReal mass = MpmPointMass(&points, model->scene.materials->at, p);

    sums[0] += mass;
    for (PetscInt a = 0; a < 2; a++) sums[1 + a] += mass * points.motion.velocity[2 * p + a];
  }
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, sums, 3, MPIU_REAL, MPIU_SUM, model->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmEntrainmentEnter(MpmModel model, PetscInt first, PetscInt count, PetscReal since)
{
  PetscReal sums[3];
  MpmPoints points;

  PetscFunctionBeginUser;
  if (!model->entrainment) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  for (PetscInt k = 2 * first; k < 2 * (first + count); k++)
    points.x[k] += (model->state.time - since) * points.motion.velocity[k];
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  PetscCall(Sum(model, first, count, NULL, sums));
  model->entrainment->account.in += sums[0];
  for (PetscInt a = 0; a < 2; a++) model->entrainment->account.carried[a] += sums[1 + a];
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmEntrainmentLeave(MpmModel model, PetscInt count, const PetscInt place[])
{
  PetscReal sums[3];

  PetscFunctionBeginUser;
  if (!model->entrainment) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Sum(model, 0, count, place, sums));
  model->entrainment->account.out += sums[0];
  for (PetscInt a = 0; a < 2; a++) model->entrainment->account.carried[a] -= sums[1 + a];
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmEntrainmentAddIncrement(MpmModel model, const PetscReal mass[], const PetscReal before[],
                                          const PetscReal after[])
{
  PetscReal gain = 0.;

  PetscFunctionBeginUser;
  if (!model->entrainment) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt k = 0; k < 2 * model->disc.space->owned; k++)
    gain += 0.5 * mass[k / 2] * (PetscSqr(after[k]) - PetscSqr(before[k]));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &gain, 1, MPIU_REAL, MPIU_SUM, model->comm));
  model->entrainment->account.nodes += gain;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmEntrainmentFindEmpty(MpmModel model, PetscInt *here, PetscInt **empty, PetscInt *count)
{
  PetscInt   local;
  PetscReal *volume;

  PetscFunctionBeginUser;
  *here = *count = 0;
  *empty         = NULL;
  if (!model->entrainment || !model->entrainment->deposits) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(DMSwarmGetLocalSize(model->state.particles->swarm, &local));
  PetscCall(PetscMalloc1(local, empty));
  PetscCall(MpmParticlesGetField(model->state.particles, "volume0", &volume));
  for (PetscInt p = 0; p < local; p++)
    if (volume[p] == 0.) (*empty)[(*here)++] = p;
  PetscCall(MpmParticlesRestoreField(model->state.particles, &volume));
  PetscCall(MPIU_Allreduce(here, count, 1, MPIU_INT, MPI_SUM, model->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- columns ---- */

static const char *const parts[] = {"mass",
                                    "mass_in",
                                    "mass_out",
                                    "mass_eroded",
                                    "mass_deposited",
                                    "impulse_bed_x",
                                    "impulse_bed_y",
                                    "impulse_friction_x",
                                    "impulse_friction_y",
                                    "impulse_carried_x",
                                    "impulse_carried_y",
                                    "energy_exchange",
                                    "energy_transfer"};

static PetscErrorCode Fill(MpmModel model, const MpmColumn *column, PetscReal values[])
{
  const MpmEntrainmentAccount *account = &model->entrainment->account;
  const MpmEnergy             *energy  = &model->state.scheme.energy;
  MpmMotionSums                sums;
  PetscReal                    sum[2];

  (void)column;
  PetscFunctionBeginUser;
  PetscCall(MpmParticlesLendArrays(model->state.particles, model->disc.points));
  PetscCall(MpmMotionSum(model->disc.sum, &MpmModelMotion(model)->transfer, &sums));
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, model->disc.points));
  sum[0] = sums.mass;
  sum[1] = sums.kinetic;
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, sum, 2, MPIU_REAL, MPIU_SUM, model->comm));
  *values++ = sum[0];
  *values++ = account->in;
  *values++ = account->out;
  *values++ = account->eroded;
  *values++ = account->deposited;
  for (PetscInt a = 0; a < 2; a++) *values++ = account->bed[a];
  for (PetscInt a = 0; a < 2; a++) *values++ = account->friction[a];
  for (PetscInt a = 0; a < 2; a++) *values++ = account->carried[a];
  *values++ = account->energy;
  *values   = energy->start - energy->elastic + account->nodes - account->energy - account->mixed - sum[1];
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmEntrainmentAddColumns(MpmModel model, MpmColumns *columns)
{
  const MpmColumn row = {.unit  = "kg; of impulses kg m/s, of energy J",
                         .count = PETSC_STATIC_ARRAY_LENGTH(parts),
                         .parts = parts,
                         .fill  = Fill};

  PetscFunctionBeginUser;
  if (model->entrainment) PetscCall(MpmColumnsAdd(columns, NULL, &row));
  PetscFunctionReturn(PETSC_SUCCESS);
}

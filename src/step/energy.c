/*
  The account of energy, over all points and since the start:

    kinetic + elastic + dissipated - external - (kinetic + elastic at the start) = balance

  kinetic     of the points, with their affine velocities, and of rigid bodies with a mass
  elastic     stored by the points' elastic strain, by the law or by the stress, p^2/(2 K) + s:s/(4 G) a volume
  dissipated  the work of the points' stresses less its stored share, and the losses by contact (the depth of a penalty,
              too, until it opens) and by damping
  external    work of loads, on free boundaries, too, of supports that move and of boundaries that move

  The work of a stress in a step is V_0 tau : d, tau the mean of its start and end and d the strain about the middle,

    d = sym((dF - I) ((dF + I)/2)^{-1}) ,

  of second order in the step. The balance is the loss by the integrator, by the transfer between points and nodes, and
  by the ghost penalty, which falls with the step, and with FLIP.
*/
#include "base/columns.h"
#include "point/material.h"
#include "point/stored_energy.h"
#include "particles/particles.h"
#include "particles/point_mass.h"
#include "particles/points.h"
#include "space/sum.h"
#include "transfer/momentum.h"
#include "bc/bc.h"
#include "assembly/terms.h"
#include "volume/inertia.h"
#include "query/model.h"
#include "query/query.h"
#include "step/energy.h"

/* ---- points ---- */

/* Of this rank's points. */
MPM_INLINE PetscReal Elastic(const PetscInt dim, const MpmModel model, const MpmPoints *points)
{
  const PetscInt sym = MpmSymSize(dim), size = model->state.particles->state_size;
  PetscReal      sum = 0.;

  for (PetscInt p = 0; p < points->count; p++) {
    const MpmMaterial *material = &model->scene.materials->at[points->material[p]];
    const PetscReal   *F        = MpmPointF(points, p);
    PetscReal          stress[6];

    for (PetscInt c = 0; c < sym; c++) stress[c] = points->stress[p * sym + c];
    if (points->across) /* does no work, and is none of the law's */
      stress[2] -= points->across[p] / (material->info.traits & MPM_LAW_SMALL_STRAIN ? 1. : MpmPointJ(points, p));
    sum += points->volume0[p] * MpmStoredEnergy(material, MpmPointOwn(points, material, p), dim, stress,
                                                points->state ? &points->state[p * size] : NULL, F);
  }
  return sum;
}

/* Without the affine part. */
static PetscErrorCode Measure(MpmModel model, PetscReal energy[2])
{
  MpmPoints points;

  PetscFunctionBeginUser;
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  energy[0] = MpmPointsKinetic(&points, model->scene.materials->at, model->disc.dim);
  energy[1] = MPM_BY_DIM(model->disc.dim, Elastic, model, &points);
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, energy, 2, MPIU_REAL, MPIU_SUM, model->comm));
  energy[0] += MpmTermsKinetic(model->disc.terms);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmEnergyMark(MpmModel model)
{
  PetscFunctionBeginUser;
  if (model->disc.context.inertia->dynamic && model->state.scheme.energy.known)
    PetscCall(Measure(model, model->state.scheme.energy.mark));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmEnergyAddAffine(MpmModel model, PetscReal by)
{
  MpmMotionSums sums;
  PetscReal     affine;

  PetscFunctionBeginUser;
  if (!model->disc.context.inertia->dynamic) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmParticlesLendArrays(model->state.particles, model->disc.points));
  PetscCall(MpmMotionSum(model->disc.sum, &MpmModelMotion(model)->transfer, &sums));
  affine = sums.kinetic - MpmPointsKinetic(model->disc.points, model->scene.materials->at, model->disc.dim);
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, model->disc.points));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &affine, 1, MPIU_REAL, MPIU_SUM, model->comm));
  model->state.scheme.energy.start += by * affine;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmEnergyOpen(MpmModel model)
{
  const MpmMotionControl *motion = MpmModelMotion(model);
  MpmEnergy              *energy = &model->state.scheme.energy;
  MpmMotionSums           sums;
  PetscReal               affine;

  PetscFunctionBeginUser;
  if (energy->opened || model->state.time > 0.) PetscFunctionReturn(PETSC_SUCCESS);
  energy->opened = PETSC_TRUE;
  if (motion->type != MPM_EXPLICIT && !motion->lumped) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmMotionSum(model->disc.sum, &motion->transfer, &sums));
  affine = sums.kinetic - MpmPointsKinetic(model->disc.points, model->scene.materials->at, model->disc.dim);
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &affine, 1, MPIU_REAL, MPIU_SUM, model->comm));
  energy->start += affine;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmEnergyRebase(MpmModel model)
{
  MpmEnergy *energy = &model->state.scheme.energy;
  PetscReal  now[2];

  PetscFunctionBeginUser;
  if (!model->disc.context.inertia->dynamic) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Measure(model, now));
  energy->start += now[0] + now[1] - energy->mark[0] - energy->mark[1];
  energy->elastic += now[1] - energy->mark[1];
  energy->known = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- work ---- */

/* sym(G) : S of a gradient G and a symmetric S; plane strain has no part along z. */
MPM_INLINE PetscReal Power(PetscInt dim, const PetscReal G[], const PetscReal S[])
{
  static const PetscInt row[] = {0, 1, 0}, column[] = {1, 2, 2}; /* of the components behind xx, yy, zz */
  PetscReal             sum = 0.;

  for (PetscInt a = 0; a < dim; a++) sum += G[a * dim + a] * S[a];
  for (PetscInt k = 0; k < dim * (dim - 1) / 2; k++)
    sum += (G[row[k] * dim + column[k]] + G[column[k] * dim + row[k]]) * S[3 + k];
  return sum;
}

/* (B - A) ((A + B)/2)^{-1}: with A = F_n and B = F_{n+1} the strain about the middle. */
MPM_INLINE void MiddleStrain(PetscInt dim, const PetscReal A[], const PetscReal B[], PetscReal d[])
{
  PetscReal half[MPM_MAX_DIM * MPM_MAX_DIM], cofactor[MPM_MAX_DIM * MPM_MAX_DIM], by;

  for (PetscInt k = 0; k < dim * dim; k++) half[k] = 0.5 * (A[k] + B[k]);
  by = 1. / MpmCofactors(dim * dim, half, cofactor);
  for (PetscInt i = 0; i < dim; i++) {
    for (PetscInt j = 0; j < dim; j++) {
      d[i * dim + j] = 0.;
      for (PetscInt k = 0; k < dim; k++) d[i * dim + j] += (B[i * dim + k] - A[i * dim + k]) * cofactor[j * dim + k];
      d[i * dim + j] *= by;
    }
  }
}

/* Of the stresses of this rank's points. */
MPM_INLINE PetscReal Internal(const PetscInt dim, const MpmModel model)
{
  const MpmPoints *points = model->disc.points;
  const MpmTrial  *trial  = model->disc.trial;
  const PetscInt   square = dim * dim, sym = MpmSymSize(dim);
  PetscReal        work = 0.;

  for (PetscInt p = 0; p < points->count; p++) {
    const unsigned   traits = model->scene.materials->at[points->material[p]].info.traits;
    const PetscBool  small  = (PetscBool)(traits & MPM_LAW_SMALL_STRAIN ? 1 : 0);
    const PetscReal *A = MpmPointF(points, p), *B = &trial->F[p * points->F_size];
    PetscReal        d[MPM_MAX_DIM * MPM_MAX_DIM], mean[6];
    const PetscReal  before = 0.5 * (small ? 1. : MpmDeterminant(points->F_size, A)),
                    after   = 0.5 * (small ? 1. : MpmDeterminant(points->F_size, B));

    for (PetscInt k = 0; k < sym; k++)
      mean[k] = before * points->stress[p * sym + k] + after * trial->stress[p * sym + k];
    if (!small) MiddleStrain(dim, A, B, d);
    for (PetscInt k = 0; small && k < square; k++) d[k] = B[k] - A[k];
    work += points->volume0[p] * Power(dim, d, mean);
    if (points->F_size > square) /* the hoop direction, which has no shear */
      work += points->volume0[p] * mean[2] * (B[square] - A[square]) / (small ? 1. : 0.5 * (A[square] + B[square]));
  }
  return work;
}

/* Of the forces of some nodes in the step's displacement: components of the latter alone. */
static PetscReal Work(const MpmModel model, PetscInt nodes, const PetscReal force[], const PetscReal u[])
{
  const PetscInt dim = model->disc.dim, bs = model->disc.block;
  PetscReal      work = 0.;

  for (PetscInt i = 0; i < nodes; i++)
    for (PetscInt a = 0; a < dim; a++) work += force[i * bs + a] * u[i * bs + a];
  return work;
}

/* The displacement in which forces do their work, and that at which they are. */
static const PetscReal *Kick(const MpmStepWork *step)
{
  return step->kick ? step->kick : step->u;
}
static const PetscReal *At(const MpmStepWork *step)
{
  return step->at ? step->at : step->u;
}

PetscErrorCode MpmEnergyAdd(MpmModel model, const MpmStepWork *work)
{
  const PetscInt  local  = work->local;
  const PetscReal part   = work->kick ? work->part : 1.;
  MpmEnergy      *energy = &model->state.scheme.energy;
  PetscReal       sum[3] = {0., 0., 0.};
  MpmTermWork     terms;

  PetscFunctionBeginUser;
  if (!model->disc.context.inertia->dynamic) PetscFunctionReturn(PETSC_SUCCESS);
  if (model->scene.stages.at[model->state.stage].geostatic.method != MPM_GEOSTATIC_NONE)
    PetscFunctionReturn(PETSC_SUCCESS);
  if (!work->unstrained) sum[0] = MPM_BY_DIM(model->disc.dim, Internal, model);
  if (work->loads) sum[1] = Work(model, local, work->loads, work->u);
  sum[1] += part * Work(model, work->owned, work->supports, Kick(work));
  PetscCall(MpmTermsWork(model->disc.terms, model->disc.sum, At(work), Kick(work), &terms));
  sum[1] += part * terms.external;
  sum[2] += part * (work->taken + terms.dissipated);
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, sum, 3, MPIU_REAL, MPIU_SUM, model->comm));
  energy->internal += sum[0];
  energy->external += sum[1];
  energy->dissipated += sum[2];
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmEnergyAddRows(MpmModel model)
{
  MpmEnergy   *energy = &model->state.scheme.energy;
  const MpmRow rows[] = {
    {"energy_known", MPM_ROW_BOOL, MPM_ROW_STATE, &energy->known, 0, 0},
    {"energy_internal", MPM_ROW_REAL, MPM_ROW_STATE, &energy->internal, 0, 0},
    {"energy_external", MPM_ROW_REAL, MPM_ROW_STATE, &energy->external, 0, 0},
    {"energy_dissipated", MPM_ROW_REAL, MPM_ROW_STATE, &energy->dissipated, 0, 0},
    {"energy_start", MPM_ROW_REAL, MPM_ROW_STATE, &energy->start, 0, 0},
    {"energy_elastic", MPM_ROW_REAL, MPM_ROW_STATE, &energy->elastic, 0, 0},
  };

  PetscFunctionBeginUser;
  PetscCall(MpmRowsAdd(model->state.rows, NULL, PETSC_STATIC_ARRAY_LENGTH(rows), rows));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- report ---- */

PetscErrorCode MpmEnergyEvaluate(MpmModel model, MpmEnergyReport *report)
{
  const MpmMotionControl *motion   = MpmModelMotion(model);
  const MpmEnergy        *energy   = &model->state.scheme.energy;
  const PetscBool         moves    = (PetscBool)(motion->type != MPM_QUASISTATIC);
  MpmTransfer             transfer = motion->transfer;
  PetscReal               sum[2 + MPM_MAX_DIM + 3];
  MpmMotionSums           sums = {.mass = 0.};

  PetscFunctionBeginUser;
  PetscCall(MpmParticlesLendArrays(model->state.particles, model->disc.points));
  if (motion->type != MPM_EXPLICIT && !motion->lumped) transfer.type = MPM_TRANSFER_FLIP;
  if (moves) PetscCall(MpmMotionSum(model->disc.sum, &transfer, &sums));
  sum[0] = sums.kinetic;
  sum[1] = MPM_BY_DIM(model->disc.dim, Elastic, model, model->disc.points);
  PetscCall(PetscArraycpy(&sum[2], sums.momentum, MPM_MAX_DIM));
  PetscCall(PetscArraycpy(&sum[2 + MPM_MAX_DIM], sums.angular, 3));
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, model->disc.points));
  PetscCall(
    MPIU_Allreduce(MPI_IN_PLACE, sum, (PetscMPIInt)PETSC_STATIC_ARRAY_LENGTH(sum), MPIU_REAL, MPIU_SUM, model->comm));
  *report = (MpmEnergyReport){
    .kinetic = sum[0] + MpmTermsKinetic(model->disc.terms), .elastic = sum[1], .external = energy->external};
  report->dissipated = energy->dissipated + energy->internal - (sum[1] - energy->elastic);
  report->balance    = report->kinetic + report->elastic + report->dissipated - report->external - energy->start;
  PetscCall(PetscArraycpy(report->momentum, &sum[2], MPM_MAX_DIM));
  PetscCall(PetscArraycpy(report->angular, &sum[2 + MPM_MAX_DIM], 3));
  PetscFunctionReturn(PETSC_SUCCESS);
}

#define ENERGIES "energy_kinetic", "energy_elastic", "energy_dissipated", "energy_external", "energy_balance"

/* Columns by the dimension; momentum turns about z alone in the plane. */
static const struct {
  PetscInt    count, turning;
  const char *parts[11];
} columns_of[] = {[2] = {8, 1, {ENERGIES, "momentum_x", "momentum_y", "angular_momentum_z"}},
                  [3] = {11,
                         3,
                         {ENERGIES, "momentum_x", "momentum_y", "momentum_z", "angular_momentum_x",
                          "angular_momentum_y", "angular_momentum_z"}}};

static PetscErrorCode FillEnergies(MpmModel model, const MpmColumn *column, PetscReal values[])
{
  const PetscInt  dim = model->disc.dim, turning = columns_of[dim].turning;
  MpmEnergyReport report;

  (void)column;
  PetscFunctionBeginUser;
  PetscCall(MpmEnergyEvaluate(model, &report));
  *values++ = report.kinetic;
  *values++ = report.elastic;
  *values++ = report.dissipated;
  *values++ = report.external;
  *values++ = report.balance;
  PetscCall(PetscArraycpy(values, report.momentum, dim));
  PetscCall(PetscArraycpy(&values[dim], &report.angular[3 - turning], turning));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmEnergyAddColumns(MpmModel model, MpmColumns *columns)
{
  const PetscInt  dim = model->disc.dim;
  const MpmColumn row = {.unit  = "J; of momenta kg m/s and kg m2/s",
                         .count = columns_of[dim].count,
                         .parts = columns_of[dim].parts,
                         .fill  = FillEnergies};

  PetscFunctionBeginUser;
  if (model->disc.context.inertia->dynamic) PetscCall(MpmColumnsAdd(columns, NULL, &row));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  The error in time of a step of two sub-steps (sdirk.c).

  The storage s of the physics at the step's end also follows from the line through its start and the first sub-step, of
  order 1; the distance of the two is

    e = s_{n+1} - s_n - (s_1 - s_n)/gamma = c (omega dt)^2 ,

  omega being the rate of change. The physics' own equations give e: with dt = 0 nothing flows, and with 1/gamma in
  place of theta they give e at each node (in volumes, over the node's own volume). Nodes with a prescribed value, or
  where water passes a face at a pressure, do not count: the stored amount may jump there. Followers (extension.c) count
  with their masters. The scheme's own error is of the next order, (omega dt)^3, so

    estimate = 1.2 (|e|/|S|)^(3/2)

  |.| is the root mean square over the material. S is the largest change since the stage's start that there has been:
  of the field over the material's stiffness, where it is a stress, as the storage of the ground, and of s in the
  step. The factor is so chosen that consolidation (one-dimensional, finite strain) keeps the requested bound.
  Source for the shape of such estimates: Hairer and Wanner (1996), Solving Ordinary Differential Equations II, IV.8.
*/
#include "point/material.h"
#include "particles/particles.h"
#include "space/point_loop.h"
#include "bc/bc.h"
#include "assembly/terms.h"
#include "loads/body_surface.h"
#include "problem/discretization.h"
#include "query/model.h"
#include "query/query.h"
#include "integrators/sdirk.h"
#include "integrators/time_error.h"

/* The power of the step's length that the estimate goes with. */
#define ORDER  3.
#define FACTOR 1.2
/* A step is chosen for this fraction of the allowed error, for its own will differ; it shrinks by no more at once. */
#define SAFETY   0.5
#define SHORTEST 0.2
/* Lengths of steps between a power of two and the next: an estimate's last digits, which depend on the ranks, do not
   count. */
#define PARTS 1024.

const char *const MpmTimeErrorField = "value_start";

PetscErrorCode MpmTimeErrorAddRows(MpmModel model)
{
  const MpmRow rows[] = {
    {"largest_change", MPM_ROW_REAL, MPM_ROW_STATE, &model->state.scheme.error.largest, 0, 0},
  };

  PetscFunctionBeginUser;
  PetscCall(MpmRowsAdd(model->state.rows, NULL, PETSC_STATIC_ARRAY_LENGTH(rows), rows));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTimeErrorBegin(MpmModel model)
{
  PetscReal *start;
  MpmPoints  points;

  PetscFunctionBeginUser;
  model->state.scheme.error.largest = 0.;
  if (!MpmStagesControlError(model)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  PetscCall(MpmParticlesGetField(model->state.particles, MpmTimeErrorField, &start));
  for (PetscInt p = 0; p < points.count; p++) start[p] = points.physics.value[p * model->disc.layout->rate.count];
  PetscCall(MpmParticlesRestoreField(model->state.particles, &start));
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Volumes of this rank's points at the local unknowns of component c; those of others become 0. */
static PetscErrorCode NodeVolumes(const MpmSum *sum, PetscInt c, PetscReal volume[])
{
  const PetscInt bs = sum->block, basis = sum->layout->component[c].shape * MPM_BASES;
  MpmWorkspace   work;

  PetscFunctionBeginUser;
  PetscCall(PetscArrayzero(volume, sum->space->local * bs));
  PetscCall(MpmWorkspaceCreate(sum, &work));
  for (PetscInt g = 0; g < sum->space->group_count; g++) {
    const MpmGroup *group = &sum->space->groups[g];
    const MpmKnown  known = KnownGeneral(sum->layout, group);
    const PetscInt *nodes = &sum->space->group_nodes[group->node_offset];

    for (PetscInt s = group->point_begin; s < group->point_end; s++) {
      const PetscInt p = sum->space->order[s];

      MpmSumBasis(known, sum->space, p, PETSC_TRUE, &work.basis);
      for (PetscInt i = 0; i < known.n; i++)
        volume[nodes[i] * bs + c] += MpmBasisAt(&work.basis, basis, i) * sum->points->volume0[p];
    }
  }
  PetscCall(PetscFree(work.storage));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sums at the unknowns that are solved for, followers' included but for those of marked nodes, which do not count. */
static PetscErrorCode Gather(const MpmDiscretization *disc, const PetscReal mark[], PetscReal values[])
{
  const PetscInt bs = disc->block;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < disc->space->local * bs; k++)
    if (disc->constraints->condition[k] == MPM_FOLLOWS && mark[k / bs] != 0.) values[k] = 0.;
  MpmConstraintsGather(disc->constraints, disc->space, values);
  PetscCall(MpmSpaceAddToOwners(disc->space, bs, values));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The integral of the square of the storage by the equations of component c, over the nodes where it is solved for. */
static PetscErrorCode StoredSquare(MpmModel model, PetscInt c, const MpmKernelStage *first, PetscReal *square)
{
  MpmDiscretization *disc = &model->disc;
  const PetscInt     bs   = disc->block;
  MpmSum             sum  = *disc->sum;
  PetscReal         *residual, *volume, *mark;
  PetscInt           failed = 0;

  PetscFunctionBeginUser;
  PetscCall(
    PetscMalloc3((disc->space->local * bs), &residual, (disc->space->local * bs), &volume, disc->space->local, &mark));
  PetscCall(PetscArrayzero(residual, disc->space->local * bs));
  sum.step.first = first;
  sum.step.dt    = 0.;
  PetscCall(MpmTermsResidualPoints(disc->terms, &sum, disc->nodal.u, NULL, residual, &failed));
  PetscCall(NodeVolumes(disc->sum, c, volume));
  PetscCall(MpmSurfaceFlowMark(disc->context.surfaces, disc->space, mark));
  PetscCall(MpmSpaceToGhosts(disc->space, 1, mark));
  PetscCall(Gather(disc, mark, residual));
  PetscCall(Gather(disc, mark, volume));
  *square = 0.;
  for (PetscInt i = 0; i < disc->space->owned; i++)
    if (MpmConstraintsFree(disc->constraints, i * bs + c) && volume[i * bs + c] > 0. && mark[i] == 0.)
      *square += PetscSqr(residual[i * bs + c]) / volume[i * bs + c];
  PetscCall(PetscFree3(residual, volume, mark));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, square, 1, MPIU_REAL, MPIU_SUM, model->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The integral of the square of the change of the field since the stage's start, over the stiffness where it is a
   stress. */
static PetscErrorCode ChangeSquare(MpmModel model, PetscInt c, PetscReal *square)
{
  const MpmPoints *points = model->disc.points;
  const PetscInt   rates  = model->disc.layout->rate.count;
  PetscReal       *value, *start;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1((points->count * rates), &value));
  PetscCall(MpmRatesAtPoints(model->disc.sum, model->disc.nodal.u, value));
  PetscCall(MpmParticlesGetField(model->state.particles, MpmTimeErrorField, &start));
  *square = 0.;
  for (PetscInt p = 0; p < points->count; p++) {
    const PetscReal scale = model->disc.layout->component[c].scale == MPM_SCALE_STRESS
                              ? model->disc.sum->materials[points->material[p]].moduli.stiffness
                              : 1.;

    *square += points->volume0[p] * PetscSqr((value[p * rates] - start[p]) / scale);
  }
  PetscCall(MpmParticlesRestoreField(model->state.particles, &start));
  PetscCall(PetscFree(value));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, square, 1, MPIU_REAL, MPIU_SUM, model->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTimeError(MpmModel model, PetscReal *estimate)
{
  const PetscInt  c     = model->disc.layout->rate.component[0];
  MpmSdirk       *sdirk = model->state.scheme.sdirk;
  MpmKernelStage *line;
  PetscReal       error, stored, change;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(model->disc.points->count, &line));
  for (PetscInt p = 0; p < model->disc.points->count; p++) {
    line[p]       = sdirk->stage[p];
    line[p].theta = 1. / MPM_SDIRK_GAMMA;
  }
  PetscCall(StoredSquare(model, c, line, &error));
  PetscCall(StoredSquare(model, c, NULL, &stored));
  PetscCall(ChangeSquare(model, c, &change));
  PetscCall(PetscFree(line));
  sdirk->change = PetscMax(model->state.scheme.error.largest, PetscSqrtReal(stored) + PetscSqrtReal(change));
  *estimate     = error > 0. ? FACTOR * PetscPowReal(PetscSqrtReal(error) / sdirk->change, 0.5 * ORDER) : 0.;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscReal MpmTimeErrorFactor(const MpmModel model)
{
  const MpmScheme *scheme = &model->state.scheme;

  if (!(scheme->error.accepted > 0.)) return PETSC_INFINITY;
  return PetscMax(SHORTEST, PetscPowReal(SAFETY * scheme->error.accepted / PetscMax(scheme->error.estimate, 1e-30),
                                         1. / scheme->error.order));
}

PetscReal MpmTimeErrorLength(const MpmModel model, PetscReal dt)
{
  PetscReal part;
  int       power;

  if (!(model->state.scheme.error.accepted > 0.)) return dt;
  part = frexp(dt, &power);
  return ldexp(PetscFloorReal(2. * PARTS * part) / (2. * PARTS), power);
}

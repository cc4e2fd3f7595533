/*
  From nodes to points: a converged step becomes the points' state.
*/
#include "point/material.h"
#include "space/point_loop.h"

/* Gradient of the increment by the new position, I - F_n F_{n+1}^{-1}; under F-bar with the cell's volume change. */
static void IncrementGradient(PetscInt dim, const PetscReal F_n[], const PetscReal F[], PetscReal gradient[])
{
  PetscReal       cofactor[MPM_MAX_DIM * MPM_MAX_DIM];
  const PetscReal det = MpmCofactors(dim * dim, F, cofactor);

  for (PetscInt i = 0; i < dim; i++) {
    for (PetscInt j = 0; j < dim; j++) {
      PetscReal sum = 0.;

      for (PetscInt k = 0; k < dim; k++) sum += F_n[i * dim + k] * cofactor[j * dim + k];
      gradient[i * dim + j] = (i == j ? 1. : 0.) - sum / det;
    }
  }
}

/* The last increment becomes the one before, with its gradient G by the new position, G F_n F_{n+1}^{-1}. */
static void KeepIncrement(PetscInt dim, const PetscReal du[], const PetscReal F_n[], const PetscReal F[],
                          PetscReal increment[])
{
  const PetscInt size   = dim * (dim + 1);
  PetscReal     *before = increment + size, *gradient = increment + dim;

  for (PetscInt k = 0; k < size; k++) before[k] = increment[k];
  IncrementGradient(dim, F_n, F, gradient);
  for (PetscInt i = 0; i < dim; i++) {
    PetscReal row[MPM_MAX_DIM];

    for (PetscInt j = 0; j < dim; j++) {
      row[j] = before[dim + i * dim + j];
      for (PetscInt k = 0; k < dim; k++) row[j] -= before[dim + i * dim + k] * gradient[k * dim + j];
    }
    for (PetscInt j = 0; j < dim; j++) before[dim + i * dim + j] = row[j];
    increment[i] = du[i];
  }
}

/* The fields at a point from those at its group's nodes, [c][i]. */
MPM_INLINE void Interpolate(const MpmKnown known, const MpmSum *sum, PetscInt p, const PetscReal values[],
                            PetscReal field[])
{
  for (PetscInt c = 0; c < known.block; c++) {
    const MpmWeights *of = &sum->space->shapes.at[known.solid ? 0 : sum->layout->component[c].shape];
    const MpmLines    w  = MpmPointLines(known.dim, sum->space, of->weight, p, &MpmLineOne);
    const PetscReal  *v  = &values[c * known.n];

    field[c] = 0.;
    for (PetscInt l = 0; l < known.count[2]; l++) {
      for (PetscInt j = 0; j < known.count[1]; j++, v += known.count[0]) {
        PetscReal row = 0.;

        for (PetscInt k = 0; k < known.count[0]; k++) row += w.along[0][k] * v[k];
        field[c] += w.along[1][j] * w.along[2][l] * row;
      }
    }
  }
}

/* The values of fields with a rate, and their gradients by the new position, dF^{-T} times those by the old one. */
static void KeepValues(const MpmSum *sum, const MpmGroup *group, PetscInt p, const PetscReal field[],
                       const PetscReal values[], MpmWorkspace *work)
{
  const MpmLayout *layout = sum->layout;
  const MpmKnown   known  = KnownGeneral(layout, group);
  const PetscInt   dim = known.dim, n = known.n, rates = layout->rate.count;
  PetscReal        dF[MPM_MAX_DIM * MPM_MAX_DIM], cofactor[MPM_MAX_DIM * MPM_MAX_DIM], det;

  MpmSumBasis(known, sum->space, p, PETSC_TRUE, &work->basis);
  for (PetscInt i = 0; i < dim; i++) {
    for (PetscInt j = 0; j < dim; j++) {
      dF[i * dim + j] = i == j ? 1. : 0.;
      for (PetscInt k = 0; i < layout->motion && k < n; k++)
        dF[i * dim + j] += work->basis.basis[1 + j][k] * values[i * n + k];
    }
  }
  det = MpmCofactors(dim * dim, dF, cofactor);
  for (PetscInt r = 0; r < rates; r++) {
    const PetscInt    c  = layout->rate.component[r];
    PetscReal *const *by = &work->basis.basis[layout->component[c].shape * MPM_BASES + 1];
    PetscReal         G[MPM_MAX_DIM], *gradient = &sum->points->physics.value_gradient[(p * rates + r) * dim];

    sum->points->physics.value[p * rates + r] = field[c];
    for (PetscInt j = 0; j < dim; j++) {
      G[j] = 0.;
      for (PetscInt k = 0; k < n; k++) G[j] += by[j][k] * values[c * n + k];
    }
    for (PetscInt i = 0; i < dim; i++) {
      gradient[i] = 0.;
      for (PetscInt j = 0; j < dim; j++) gradient[i] += cofactor[i * dim + j] * G[j] / det;
    }
  }
}

/* One group's points go where the displacement at its nodes takes them. */
MPM_INLINE PetscErrorCode CommitGroup(const MpmKnown known, const MpmSum *sum, const MpmTrial *trial,
                                      const MpmGroup *group, const PetscReal u[], MpmWorkspace *work)
{
  PetscReal *const values = work->values;
  const PetscInt   dim    = known.dim;
  const MpmPoints *points = sum->points;

  MpmSumGather(known, sum, group, u, values);
  for (PetscInt s = group->point_begin; s < group->point_end; s++) {
    const PetscInt p = sum->space->order[s], ahead = MpmSumAhead(sum, s);
    PetscReal      field[MPM_MAX_BLOCK];

    MpmSpaceFetch(known, sum->space, ahead);
    MpmFetch(points->x, ahead, dim);
    if (points->motion.increment) {
      MpmFetch(points->motion.increment, ahead, MPM_INCREMENT(dim));
      MpmFetch(points->F, ahead, points->F_size);
      MpmFetch(trial->F, ahead, points->F_size);
    }
    Interpolate(known, sum, p, values, field);
    for (PetscInt a = 0; a < (known.solid ? dim : sum->layout->motion); a++) points->x[p * dim + a] += field[a];
    if (!known.solid && points->physics.value) KeepValues(sum, group, p, field, values, work);
    if (points->motion.increment)
      KeepIncrement(dim, field, MpmPointF(points, p), &trial->F[p * points->F_size],
                    &points->motion.increment[p * MPM_INCREMENT(dim)]);
  }
  return PETSC_SUCCESS;
}

/* Adds the part of stress_zz that F does not carry: a Kirchhoff stress, or of a small-strain law Cauchy's. */
static void AddAcross(const MpmSum *sum)
{
  const MpmPoints *points = sum->points;

  for (PetscInt p = 0; points->across && p < points->count; p++) {
    const unsigned traits = sum->materials[points->material[p]].info.traits;

    points->stress[4 * p + 2] += points->across[p] / (traits & MPM_LAW_SMALL_STRAIN ? 1. : MpmPointJ(points, p));
  }
}

/* F, stress and history become the points'. */
static PetscErrorCode KeepTrial(const MpmSum *sum, const MpmTrial *trial)
{
  const MpmPoints *points = sum->points;
  const PetscInt   dim    = sum->space->dim;

  PetscFunctionBeginUser;
  PetscCall(PetscArraycpy(points->F, trial->F, points->count * points->F_size));
  PetscCall(PetscArraycpy(points->stress, trial->stress, points->count * MpmSymSize(dim)));
  AddAcross(sum);
  PetscCall(PetscArraycpy(points->physics.own, trial->own, points->count * sum->kept.own));
  for (PetscInt p = 0; sum->kept.state && p < points->count; p++)
    PetscCall(PetscArraycpy(&points->state[p * sum->kept.state], &trial->state[p * sum->kept.state],
                            sum->materials[points->material[p]].state_size));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmCommitMoves(const MpmSum *sum, const MpmTrial *trial, PetscReal dt, const PetscReal moves[])
{
  const PetscInt count = sum->points->count * sum->space->dim;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < count; k++) sum->points->x[k] += dt * moves[k];
  PetscCall(KeepTrial(sum, trial));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmCommitLocal(const MpmSum *sum, const MpmTrial *trial, const PetscReal u[])
{
  MpmWorkspace work;

  PetscFunctionBeginUser;
  PetscCall(MpmWorkspaceCreate(sum, &work));
  for (PetscInt g = 0; g < sum->space->group_count; g++) {
    const MpmGroup *group = &sum->space->groups[g];

    MPM_DISPATCH(sum->layout, group, CommitGroup, sum, trial, group, u, &work);
  }
  PetscCall(PetscFree(work.storage));
  PetscCall(KeepTrial(sum, trial));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Latin hypercubes, with correlation of ranks.

  With the scores z of the members, one a draw, and their correlation T = L L^T, y = P L^-1 z has the correlation
  C = P P^T; members then take the shares of each draw in the order of y.
*/
#include "base/random.h"
#include <petscblaslapack.h>
#include "ensemble/distribution.h"

/* Parts of the members in random order (Fisher and Yates; Durstenfeld 1964, doi:10.1145/364520.364540). */
static void Shuffle(uint64_t seed, uint64_t stream, PetscInt members, PetscInt part[])
{
  for (PetscInt m = 0; m < members; m++) part[m] = m;
  for (PetscInt m = members - 1; m > 0; m--) {
    const PetscInt other = (PetscInt)(MpmRandomBits(seed, stream, (uint64_t)m) % (uint64_t)(m + 1));
    const PetscInt kept  = part[m];

    part[m]     = part[other];
    part[other] = kept;
  }
}

/* Cholesky's factor, lower, row by row; false where there is none. */
static PetscErrorCode Factor(PetscInt draws, PetscReal matrix[], PetscBool *positive)
{
  PetscBLASInt n, info;

  PetscFunctionBeginUser;
  PetscCall(PetscBLASIntCast(draws, &n));
  PetscCallBLAS("LAPACKpotrf", LAPACKpotrf_("U", &n, matrix, &n, &info)); /* the upper one by columns */
  *positive = (PetscBool)!info;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Correlation of the scores. */
static void Correlate(PetscInt members, PetscInt draws, const PetscReal score[], PetscReal matrix[])
{
  for (PetscInt k = 0; k < draws; k++) {
    for (PetscInt l = 0; l <= k; l++) {
      PetscReal sum = 0., squares = 0.;

      for (PetscInt m = 0; m < members; m++) {
        sum += score[k * members + m] * score[l * members + m];
        squares += PetscSqr(score[m]); /* those of all draws are a permutation of these */
      }
      matrix[k * draws + l] = matrix[l * draws + k] = sum / squares;
    }
  }
}

/* y of a member, in place of its scores. */
static void Transform(PetscInt members, PetscInt draws, const PetscReal from[], const PetscReal to[], PetscInt m,
                      PetscReal score[], PetscReal work[])
{
  for (PetscInt k = 0; k < draws; k++) {
    work[k] = score[k * members + m];
    for (PetscInt l = 0; l < k; l++) work[k] -= from[k * draws + l] * work[l];
    work[k] /= from[k * draws + k];
  }
  for (PetscInt k = 0; k < draws; k++) {
    score[k * members + m] = 0.;
    for (PetscInt l = 0; l <= k; l++) score[k * members + m] += to[k * draws + l] * work[l];
  }
}

/* The parts of each draw in the order that the correlation asks for. */
static PetscErrorCode Reorder(PetscInt members, PetscInt draws, const PetscReal correlation[], PetscInt part[],
                              PetscBool *positive)
{
  const size_t square = (size_t)draws * (size_t)draws;
  PetscReal   *score, *from, *to, *work;
  PetscInt    *order;

  PetscFunctionBeginUser;
  PetscCall(
    PetscMalloc5((size_t)members * (size_t)draws, &score, square, &from, square, &to, draws, &work, members, &order));
  PetscCall(PetscArraycpy(to, correlation, draws * draws));
  PetscCall(Factor(draws, to, positive));
  if (*positive) {
    for (PetscInt i = 0; i < members * draws; i++)
      score[i] = MpmNormalQuantile(((PetscReal)part[i] + 0.5) / (PetscReal)members);
    Correlate(members, draws, score, from);
    PetscCall(Factor(draws, from, positive));
  }
  for (PetscInt m = 0; m < members && *positive; m++) Transform(members, draws, from, to, m, score, work);
  for (PetscInt k = 0; k < draws && *positive; k++) {
    for (PetscInt m = 0; m < members; m++) order[m] = m;
    PetscCall(PetscSortRealWithArrayInt(members, &score[k * members], order));
    for (PetscInt m = 0; m < members; m++) part[k * members + order[m]] = m;
  }
  PetscCall(PetscFree5(score, from, to, work, order));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmLatinHypercube(uint64_t seed, PetscInt members, PetscInt draws, const uint64_t streams[],
                                 const PetscReal correlation[], PetscReal shares[], PetscBool *positive)
{
  PetscInt *part;

  PetscFunctionBeginUser;
  *positive = PETSC_TRUE;
  PetscCall(PetscMalloc1((size_t)members * (size_t)draws, &part));
  for (PetscInt k = 0; k < draws; k++) Shuffle(seed, streams[k], members, &part[k * members]);
  if (correlation) PetscCall(Reorder(members, draws, correlation, part, positive));
  for (PetscInt k = 0; k < draws; k++) {
    for (PetscInt m = 0; m < members; m++) {
      const PetscReal within = MpmRandomUniform(seed, ~streams[k], (uint64_t)part[k * members + m]);

      shares[k * members + m] = ((PetscReal)part[k * members + m] + within) / (PetscReal)members;
    }
  }
  PetscCall(PetscFree(part));
  PetscFunctionReturn(PETSC_SUCCESS);
}

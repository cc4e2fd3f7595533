#pragma once
/*
  Distributions of numbers, and members that fill them evenly.
*/
#include <stdint.h>
#include "base/base.h"

typedef enum { MPM_UNIFORM, MPM_NORMAL, MPM_LOGNORMAL, MPM_TRIANGULAR } MpmDistributionType;

/* Between bounds, infinite where there are none: a normal or lognormal distribution is cut there. */
typedef struct {
  MpmDistributionType type;
  PetscReal           lower, upper;
  PetscReal           mean, deviation; /* of the number itself, without bounds: normal and lognormal */
  PetscReal           mode;            /* triangular */
} MpmDistribution;

/* The number with that share of the distribution below it, in (0, 1). */
PetscReal MpmDistributionQuantile(const MpmDistribution *distribution, PetscReal share);

/*
  MpmLatinHypercube - shares of members, one in each of as many equal parts of (0, 1), for each draw

  Not collective; equal on all ranks

  Input Parameters:
+ seed        - of the generator
. members     - number of members
. draws       - number of draws
. streams     - of the generator, one a draw: a draw has its numbers whatever others there are
- correlation - of ranks, draws x draws; NULL: parts are paired at random

  Output Parameter:
. shares - [draw*members + member]

  Notes:
  Correlation goes by ranks: normal scores get the correlation asked for, and the shares their order. `positive` is
  false where the matrix is not positive definite; with correlation there must be more members than draws.
  Sources: McKay, Beckman and Conover (1979), doi:10.1080/00401706.1979.10489755; Iman and Conover (1982),
  doi:10.1080/03610918208812265.
*/
PetscErrorCode MpmLatinHypercube(uint64_t seed, PetscInt members, PetscInt draws, const uint64_t streams[],
                                 const PetscReal correlation[], PetscReal shares[], PetscBool *positive);

#pragma once
/*
  Random numbers by counter, and the normal distribution.

  A number depends on seed, stream and counter alone: ranks need no common state, and any part of a sequence can be
  made without the others.
*/
#include <stdint.h>
#include "base/base.h"

/* 64 bits: the generator splitmix64 of Steele, Lea and Flood (2014), doi:10.1145/2660193.2660195, for each stream. */
uint64_t MpmRandomBits(uint64_t seed, uint64_t stream, uint64_t counter);
/* A number in (0, 1), with 53 bits. */
PetscReal MpmRandomUniform(uint64_t seed, uint64_t stream, uint64_t counter);

/* Share of a standard normal distribution below z. */
PetscReal MpmNormalShare(PetscReal z);
/* z with that share below, in (0, 1): to rounding. */
PetscReal MpmNormalQuantile(PetscReal share);

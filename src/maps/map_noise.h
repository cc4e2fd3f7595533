#pragma once
/*
  Correlated noise of maps.
*/
#include "base/types.h"
#include "maps/map.h"

/* A Gaussian random field with the covariance deviation^2 exp(-(d/length)^2) over the distance d; 0: none. */
typedef struct {
  PetscReal deviation, length; /* m */
  PetscInt  seed;
} MpmMapNoise;

/* Reads noise, noise_length and noise_seed of the block. */
PetscErrorCode MpmMapNoiseRead(const MpmOptions *block, MpmMapNoise *noise);
/*
  Adds the field to all pixels with data. A pixel's value depends on its place in the file's frame and the seed alone,
  whatever part of the map is read.
*/
PetscErrorCode MpmMapNoiseAdd(const MpmMapNoise *noise, MpmMap *map);

/*
  Correlated noise of maps: a moving average of independent normal numbers, one a pixel, with Gaussian weights of the
  standard deviation length/2, whose squares have the sum 1.

  Source: Oliver (1995), Mathematical Geology 27, 939-960, doi:10.1007/BF02091660.
*/
#include "base/random.h"
#include "options/options.h"
#include "maps/map_noise.h"

#define REACH 4. /* standard deviations of the weights */

PetscErrorCode MpmMapNoiseRead(const MpmOptions *block, MpmMapNoise *noise)
{
  const MpmRange positive = {0., PETSC_INFINITY, PETSC_FALSE};
  PetscBool      given, length;

  PetscFunctionBeginUser;
  noise->seed = 1;
  PetscCall(MpmOptionsReal(block, "noise", "m", "standard deviation of correlated noise that is added to the heights",
                           positive, MPM_OPTIONAL, &noise->deviation, &given));
  PetscCall(MpmOptionsReal(block, "noise_length", "m", "its correlation length L: covariance exp(-(d/L)^2) over d",
                           MPM_RANGE_POSITIVE, MPM_OPTIONAL, &noise->length, &length));
  PetscCall(MpmOptionsInt(block, "noise_seed", "of the noise; members of an ensemble have seeds of their own", 0,
                          PETSC_INT_MAX, MPM_OPTIONAL, &noise->seed, NULL));
  MpmCheckInput(!given || length || MpmOptionsHelp(), "-%snoise_length is missing: of -%snoise", block->prefix,
                block->prefix);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Weights from 0 to the reach. */
static PetscErrorCode Weights(PetscReal spread, PetscInt *reach, PetscReal **weight)
{
  PetscReal squares = 0.;

  PetscFunctionBeginUser;
  *reach = (PetscInt)PetscCeilReal(REACH * spread);
  PetscCall(PetscMalloc1(*reach + 1, weight));
  for (PetscInt k = 0; k <= *reach; k++) {
    (*weight)[k] = PetscExpReal(-0.5 * PetscSqr((PetscReal)k / spread));
    squares += (k ? 2. : 1.) * PetscSqr((*weight)[k]);
  }
  for (PetscInt k = 0; k <= *reach; k++) (*weight)[k] /= PetscSqrtReal(squares);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sum of 2*reach + 1 values about a place, at a stride. */
static PetscReal Average(const PetscReal *value, PetscInt64 stride, PetscInt reach, const PetscReal weight[])
{
  PetscReal sum = weight[0] * value[0];

  for (PetscInt k = 1; k <= reach; k++) sum += weight[k] * (value[k * stride] + value[-k * stride]);
  return sum;
}

PetscErrorCode MpmMapNoiseAdd(const MpmMapNoise *noise, MpmMap *map)
{
  PetscInt   reach[2], first[2], wide;
  PetscReal *weight[2], *row, *along; /* of one row of white noise; averaged along rows, with rows beyond the map */

  PetscFunctionBeginUser;
  if (!(noise->deviation > 0.)) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt a = 0; a < 2; a++) {
    PetscCall(Weights(0.5 * noise->length / map->cell[a], &reach[a], &weight[a]));
    first[a] = (PetscInt)PetscFloorReal(((a ? map->y0 : map->x0) + map->origin[a]) / map->cell[a] + 0.5) - reach[a];
  }
  wide = map->columns + 2 * reach[0];
  PetscCall(PetscMalloc2(wide, &row, (size_t)map->columns * (size_t)(map->rows + 2 * reach[1]), &along));
  for (PetscInt j = 0; j < map->rows + 2 * reach[1]; j++) {
    for (PetscInt i = 0; i < wide; i++)
      row[i] =
        MpmNormalQuantile(MpmRandomUniform((uint64_t)noise->seed, (uint64_t)(first[1] + j), (uint64_t)(first[0] + i)));
    for (PetscInt i = 0; i < map->columns; i++)
      along[(PetscInt64)j * map->columns + i] = Average(&row[reach[0] + i], 1, reach[0], weight[0]);
  }
  for (PetscInt j = 0; j < map->rows; j++)
    for (PetscInt i = 0; i < map->columns; i++)
      map->value[(PetscInt64)j * map->columns + i] +=
        noise->deviation *
        Average(&along[(PetscInt64)(j + reach[1]) * map->columns + i], map->columns, reach[1], weight[1]);
  PetscCall(PetscFree2(row, along));
  for (PetscInt a = 0; a < 2; a++) PetscCall(PetscFree(weight[a]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

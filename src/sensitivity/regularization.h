#pragma once
/*
  Regularizations of an inverse analysis: parts of its objective that depend on the values of a field alone.

  With the transformed values t of the field, neighbours across faces of cells, s the deviation and e the smoothing:

    tikhonov          1/2 sum_pairs ((t_i - t_j)/s)^2
    total_variation   sum_i (sqrt(sum_j (t_i - t_j)^2 + e^2) - e)/s ,   j the next cell along each axis
    prior             1/2 (t - m).C^-1 (t - m)/s^2 ,   C_ij = exp(-|(x_i - x_j)/l|)

  Sources: Tikhonov and Arsenin (1977), Solutions of Ill-posed Problems; Rudin, Osher and Fatemi (1992),
  doi:10.1016/0167-2789(92)90242-F; Tarantola (2005), doi:10.1137/1.9780898717921, section 3.2, for the prior.
*/
#include "base/base.h"
#include "base/types.h"
#include "options/options.h"
#include "ground/ground.h"

typedef enum { MPM_TIKHONOV, MPM_TOTAL_VARIATION, MPM_FIELD_PRIOR } MpmRegularizationKind;

#define MPM_MOST_CORRELATED 4000 /* values of a prior with a full covariance */

/* One of them, as it was read. */
typedef struct {
  char                 *name, *field;
  MpmRegularizationKind kind;
  PetscReal             deviation; /* of t, or of differences of neighbours */
  PetscReal             smoothing; /* e, of t */
  PetscReal             length[MPM_MAX_DIM];
  PetscInt              lengths; /* given: 1, or one an axis */
  PetscBool             has_mean;
  PetscReal             mean; /* of the number itself; without: the start's values */
} MpmRegularization;

/* Reads a block of -mpm_objectives of such a kind. */
PetscErrorCode MpmRegularizationRead(const MpmOptions *block, const char name[], MpmRegularizationKind kind,
                                     MpmRegularization *regular);
PetscErrorCode MpmRegularizationDestroy(MpmRegularization *regular);
/* Refuses a field whose values have no neighbours, or no places. */
PetscErrorCode MpmRegularizationCheck(const MpmRegularization *regular, const MpmGround *ground);

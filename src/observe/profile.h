#pragma once
/*
  Stress along a line, from the points beside it.
*/
#include "base/base.h"
#include "base/types.h"

/* Places along a line, and their last results. */
typedef struct {
  char      *name, *chosen_field; /* 1 at the points that are looked at; NULL: at all */
  PetscInt   body;                /* or -1 */
  PetscReal  first[MPM_MAX_DIM], last[MPM_MAX_DIM];
  PetscReal  axis[MPM_MAX_DIM][MPM_MAX_DIM]; /* the normal, then the directions of shear: right-handed */
  PetscInt   count, size;
  PetscReal *stress; /* Cauchy, `size` components a place; NaN where there is no material */
} MpmProfile;

PetscErrorCode MpmProfileDestroy(MpmProfile *profile);
PetscErrorCode MpmProfileSelect(MpmProfile *profile, const MpmBodies *bodies, MpmParticles *particles);
/* Stress of the present state at the places. */
PetscErrorCode MpmProfileEvaluate(MpmProfile *profile, const MpmGrid *grid, MpmParticles *particles);
/* Where place k stands, and the traction there along the profile's axes. */
void MpmProfilePlace(const MpmProfile *profile, PetscInt dim, PetscInt k, PetscReal x[]);
void MpmProfileTraction(const MpmProfile *profile, PetscInt dim, PetscInt k, PetscReal traction[]);

#pragma once
/*
  Measures of the strain of one point, in space also in plane strain: F has 3 x 3 components, row-major. Strains have
  xx, yy, zz, xy, yz, xz, tension positive, tensorial shear (xy is half of gamma_xy).

    log          ln V,  V = sqrt(F F^T);    the volume strain is ln J, J = det F
    engineering  sym(F) - I;                the volume strain is J - 1
*/
#include "base/base.h"

#define MPM_SPACE_SYM 6 /* components of a symmetric tensor in space */

typedef enum { MPM_STRAIN_LOG, MPM_STRAIN_ENGINEERING } MpmStrainMeasure;
extern const char *const MpmStrainMeasures[]; /* their names, NULL behind the last */

/* Rows and columns of the components. */
extern const PetscInt MpmSpacePairs[MPM_SPACE_SYM][2];

/* The strain of a deformation with det F > 0. */
PetscErrorCode MpmStrainFromDeformation(MpmStrainMeasure measure, const PetscReal F[9],
                                        PetscReal strain[MPM_SPACE_SYM]);
/*
  The stretch of that strain, the deformation without rotation: exp(e), or I + e. In the second measure det F <= 0 is
  possible, which is no stretch.
*/
PetscErrorCode MpmStretchFromStrain(MpmStrainMeasure measure, const PetscReal strain[MPM_SPACE_SYM], PetscReal F[9]);
/* The derivative of that stretch by one component of the strain, xy and yx together. */
PetscErrorCode MpmStretchDerivative(MpmStrainMeasure measure, const PetscReal strain[MPM_SPACE_SYM], PetscInt component,
                                    PetscReal dF[9]);
/* The volume strain: ln J or J - 1. */
PetscReal MpmVolumeStrain(MpmStrainMeasure measure, const PetscReal F[9]);
/* Principal values of a symmetric tensor, ascending. */
PetscErrorCode MpmPrincipalValues(const PetscReal sym[MPM_SPACE_SYM], PetscReal value[3]);
/* sqrt(3/2 dev a : dev a): sqrt(3 J2) of a stress; times 2/3 it is the shear strain sqrt(2/3 dev e : dev e). */
PetscReal MpmDeviatorSize(const PetscReal sym[MPM_SPACE_SYM]);

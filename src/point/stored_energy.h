#pragma once
/*
  The elastic energy of a point, for loops over points.
*/
#include "point/material.h"
#include "talus/point/dense.h"

/* Energy per initial volume, J/m3, at a Cauchy stress and a deformation gradient: the law's, or that of linear
   elasticity. */
MPM_INLINE PetscReal MpmStoredEnergy(const MpmMaterial *material, const double own[], PetscInt dim,
                                     const PetscReal stress[], const PetscReal state[], const PetscReal F[])
{
  const MpmLawInfo *info = &material->info;
  const PetscReal   J =
    info->traits & MPM_LAW_SMALL_STRAIN ? 1. : MpmDeterminant(MpmKinematicsF(material->kinematics), F);
  const PetscInt size = MpmSymSize(dim);
  PetscReal      tau[6], bulk, shear, mean, square = 0.;

  for (PetscInt k = 0; k < size; k++) tau[k] = J * stress[k];
  if (info->energy) return info->energy(own ? own : material->parameter, material->table, tau, F);
  if (!info->shear_modulus) return 0.;
  shear = MpmMaterialShearModulusAt(material, own, state, F);
  bulk  = MpmMaterialStiffnessAt(material, own, state, F) - 4. / 3. * shear;
  mean  = (tau[0] + tau[1] + tau[2]) / 3.;
  for (PetscInt k = 0; k < size; k++) square += k < 3 ? PetscSqr(tau[k] - mean) : 2. * PetscSqr(tau[k]);
  if (!(shear > 0.)) return bulk > 0. ? 0.5 * mean * mean / bulk : 0.;
  return square / (4. * shear) + (bulk > 0. ? 0.5 * mean * mean / bulk : 0.);
}

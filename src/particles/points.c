/*
  Values of points: own parameters, volume and mass, extents; points that come to rest.
*/
#include "point/layout.h"
#include "point/material.h"
#include "particles/particles.h"
#include "particles/point_mass.h"
#include "particles/points.h"

void MpmPointsSetOwn(const MpmMaterial *materials, const PetscInt vertical[2], PetscInt dim, PetscInt first,
                     PetscInt end, const MpmPoints *points)
{
  for (PetscInt p = first; points->parameter && p < end; p++) {
    const MpmMaterial *material = &materials[points->material[p]];
    const PetscReal   *x        = &points->origin[p * dim];

    if (material->varies)
      MpmMaterialOwn(material, &(MpmPlace){(PetscReal)vertical[1] * x[vertical[0]], x, points->id[p]},
                     &points->parameter[p * material->varies->stride]);
  }
}

PetscReal MpmPointVolumeRatio(const MpmMaterial *material, const PetscReal F[])
{
  const PetscInt size = MpmKinematicsF(material->kinematics), dim = MpmKinematicsDim(material->kinematics);
  PetscReal      ratio = 1.;

  if (!(material->info.traits & MPM_LAW_SMALL_STRAIN)) return MpmDeterminant(size, F);
  for (PetscInt a = 0; a < dim; a++) ratio += F[a * dim + a] - 1.;
  return ratio + (size > dim * dim ? F[size - 1] - 1. : 0.);
}

PetscReal MpmPointMassStart(const MpmPoints *points, const MpmMaterial *materials, PetscInt p)
{
  return MpmPointMass(points, materials, p);
}

PetscReal MpmPointMassNow(const MpmPoints *points, const MpmMaterial *materials, const MpmLayout *layout, PetscInt p)
{
  const MpmMaterial *material = &materials[points->material[p]];
  PetscReal          mass     = MpmPointMass(points, materials, p);

  if (layout->own.taken_up < 0) return mass;
  return mass + MpmMaterialPhysicsValues(material, MpmPointOwn(points, material, p))[layout->own.taken_up] *
                  points->volume0[p] * (MpmPointVolumeRatio(material, MpmPointF(points, p)) - 1.);
}

PetscErrorCode MpmParticlesStartHere(MpmParticles *particles)
{
  MpmPoints points;

  PetscFunctionBeginUser;
  PetscCall(MpmParticlesGetArrays(particles, &points));
  PetscCall(PetscArraycpy(points.x0, points.x, points.count * particles->dim));
  PetscCall(MpmParticlesRestoreArrays(particles, &points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPointsStop(const MpmPoints *points, PetscInt dim)
{
  PetscFunctionBeginUser;
  PetscCall(PetscArrayzero(points->motion.velocity, points->count * dim));
  if (points->motion.affine) PetscCall(PetscArrayzero(points->motion.affine, points->count * dim * dim));
  if (points->motion.acceleration) PetscCall(PetscArrayzero(points->motion.acceleration, points->count * dim));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPointsClear(PetscInt count, PetscReal value[])
{
  const unsigned char *byte = (const unsigned char *)value; /* whatever they stand for, -0 is not 0 */
  unsigned char        any  = 0;

  PetscFunctionBeginUser;
  for (size_t k = 0; k < (size_t)count * sizeof(*value); k++) any |= byte[k];
  if (any) PetscCall(PetscArrayzero(value, count));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmParticlesGetExtents(MpmParticles *particles, MpmPoints *points, PetscReal lower[], PetscReal upper[])
{
  const PetscInt dim                    = particles->dim;
  PetscReal      reach[2 * MPM_MAX_DIM] = {0.};

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < 2 * dim; k++) reach[k] = PETSC_NINFINITY;
  PetscCall(MpmParticlesLendArrays(particles, points));
  for (PetscInt k = 0; k < points->count * dim; k++) {
    reach[k % dim]       = PetscMax(reach[k % dim], points->x[k]);
    reach[dim + k % dim] = PetscMax(reach[dim + k % dim], -points->x[k]);
  }
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, reach, (PetscMPIInt)(2 * dim), MPIU_REAL, MPIU_MAX,
                           PetscObjectComm((PetscObject)particles->swarm)));
  for (PetscInt a = 0; a < dim; a++) {
    upper[a] = reach[a];
    lower[a] = -reach[dim + a];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmParticlesRest(MpmParticles *particles)
{
  MpmPoints points;

  PetscFunctionBeginUser;
  PetscCall(MpmParticlesGetArrays(particles, &points));
  PetscCall(MpmPointsStop(&points, particles->dim));
  PetscCall(MpmParticlesRestoreArrays(particles, &points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscReal MpmPointsKinetic(const MpmPoints *points, const MpmMaterial *materials, PetscInt dim)
{
  PetscReal sum = 0.;

  for (PetscInt k = 0; k < points->count * dim; k++)
    sum += 0.5 * MpmPointMass(points, materials, k / dim) * PetscSqr(points->motion.velocity[k]);
  return sum;
}

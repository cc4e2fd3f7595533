#pragma once
/*
  The points' fields as arrays.
*/
#include "base/base.h"
#include "base/types.h"
#include "talus/point/dense.h"

#define MPM_INCREMENT(dim) (2 * (dim) * ((dim) + 1)) /* numbers of the last two steps' increments */

/* The points' fields, lent by MpmParticlesGetArrays(); NULL where a field is not registered. */
typedef struct MpmPoints {
  PetscBool  lent;
  PetscInt   count;
  PetscInt   F_size; /* components of F, MpmKinematicsF() */
  PetscInt  *id, *material;
  PetscReal *x, *x0; /* position now and at the start, or where displacements began anew, m */
  PetscReal *origin; /* at the start, whatever began anew, m */
  PetscReal *F;      /* dim x dim, row-major, and with axial symmetry the hoop component */
  struct {
    PetscReal *half_length; /* of the initial domain, m; shapes with a domain and tractions only */
    PetscReal *drawn;     /* half the domain's lengths at the start, m: half_length, unless an initial stress is an F */
    PetscInt  *faces;     /* bits of those that bound the material (outer_faces.h); with boundaries only */
    PetscInt  *divisions; /* how often it has been divided across each axis, MPM_DIVISION_BITS each; or NULL */
    PetscInt  *part;      /* of the material; parts have nodes of their own. With more parts than one only */
    PetscReal *cut; /* at the start: normal of the surface that cut the lattice of points there, and depth below it, m;
                       or zeros. With more parts than one only */
  } domain;
  PetscReal *volume0;
  PetscReal *mass;      /* kg; where a point's mass is not its density times volume0: initial stress, other materials */
  PetscReal *stress;    /* Cauchy, xx, yy, zz, xy (, yz, xz) */
  PetscReal *across;    /* part of stress_zz that F does not carry, Pa; plane strain with initial stresses only */
  PetscReal *state;     /* state_size values */
  PetscReal *parameter; /* of law and physics at the point, where any varies; at the reduction of strength in force */
  struct {
    PetscReal *own;            /* own_size values: states of the physics' own */
    PetscReal *value;          /* of fields with a rate */
    PetscReal *value_gradient; /* their derivatives by x */
  } physics;
  struct {
    PetscReal *velocity;     /* m/s; where a stage of the scene is dynamic */
    PetscReal *affine;       /* affine velocity, dim x dim, as momentum.c has it */
    PetscReal *acceleration; /* m/s2; where a stage of the scene is dynamic */
    PetscReal *increment;    /* of the last step's displacement, dim values, and its gradient by x, row-major; the one
                                before */
  } motion;
} MpmPoints;

/* F of point p, and its determinant. */
static inline PetscReal *MpmPointF(const MpmPoints *points, PetscInt p)
{
  return &points->F[p * points->F_size];
}
static inline PetscReal MpmPointJ(const MpmPoints *points, PetscInt p)
{
  return MpmDeterminant(points->F_size, MpmPointF(points, p));
}
/* Area of a point's domain in the plane, m2; its volume in 3D, m3. */
static inline PetscReal MpmPointExtent(const MpmPoints *points, PetscInt dim, PetscInt p)
{
  return points->volume0[p] * MpmPointJ(points, p) / MpmTurn(points->F_size, points->x[p * dim]);
}

/* How often a point has been divided across an axis (divide.c). */
#define MPM_DIVISION_BITS 4
static inline PetscInt MpmPointDivisions(const MpmPoints *points, PetscInt p, PetscInt axis)
{
  return points->domain.divisions
           ? (points->domain.divisions[p] >> (MPM_DIVISION_BITS * axis)) & ((1 << MPM_DIVISION_BITS) - 1)
           : 0;
}
/* half_length of the point that it was before. */
static inline PetscReal MpmPointHalfWhole(const MpmPoints *points, PetscInt dim, PetscInt p, PetscInt axis)
{
  return points->domain.half_length[p * dim + axis] * (PetscReal)(1 << MpmPointDivisions(points, p, axis));
}
/* A length along an axis in the state that F deforms, over that at the start: of points with domains. */
static inline PetscReal MpmPointReference(const MpmPoints *points, PetscInt dim, PetscInt p, PetscInt axis)
{
  return points->domain.half_length[p * dim + axis] / points->domain.drawn[p * dim + axis];
}

/*
  Own parameters of points [first, end) of materials that vary, by their places in the initial state, with heights up an
  axis: `up` is 1 or -1. Nothing where no material varies.
*/
void MpmPointsSetOwn(const MpmMaterial *materials, const PetscInt vertical[2], PetscInt dim, PetscInt first,
                     PetscInt end, const MpmPoints *points);
/* J of a point for the water taken up: det F, or 1 + tr(F - I) at small strain. */
PetscReal MpmPointVolumeRatio(const MpmMaterial *material, const PetscReal F[]);
/* A point's mass at the start, kg: MpmPointMass() (point_mass.h) for files without materials. */
PetscReal MpmPointMassStart(const MpmPoints *points, const MpmMaterial *materials, PetscInt p);
/* Its mass now, with the water that it has taken up since the start. */
PetscReal MpmPointMassNow(const MpmPoints *points, const MpmMaterial *materials, const MpmLayout *layout, PetscInt p);

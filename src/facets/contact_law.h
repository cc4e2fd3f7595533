#pragma once
/*
  The law of contact of a patch, with rigid surfaces or other bodies: pressure by gap, traction by slip and pressure.
*/
#include "base/base.h"

/* During Newton's method: the derivative of sliding along its direction, over the stiffness across. */
#define MPM_CONTACT_LEAST 1e-8

/* Parameters between two surfaces. */
typedef struct {
  PetscReal stiffness;          /* across, Pa/m */
  PetscReal along;              /* stiffness along the surface over that across */
  PetscReal friction, adhesion; /* Coulomb's coefficient; Pa */
  PetscReal strength;           /* of the material itself in shear, Pa; or infinite */
  PetscBool stick;              /* the strength bounds the traction */
  PetscBool parts;              /* without a strength: a multiple of the pressure bounds the traction */
  PetscBool secant;             /* the derivative by the slip when sliding is its secant, t/s */
  PetscReal least;              /* least stiffness of sliding, over that across */
} MpmContactLaw;

/* Along the surface; the traction is the first body's on the second. */
typedef struct {
  PetscReal traction[MPM_MAX_DIM], by_slip[MPM_MAX_DIM][MPM_MAX_DIM], by_pressure[MPM_MAX_DIM];
} MpmContactFriction;

/* True where nothing can slide: contact that sticks, to a material whose strength has no bound. */
static inline PetscBool MpmContactSticks(PetscBool stick, PetscReal strength)
{
  return (PetscBool)(stick && strength >= 0.5 * PETSC_INFINITY);
}

/* v less its part along n. */
static inline void MpmContactAcross(PetscInt dim, const PetscReal n[], PetscReal v[])
{
  PetscReal dot = 0.;

  for (PetscInt a = 0; a < dim; a++) dot += v[a] * n[a];
  for (PetscInt a = 0; a < dim; a++) v[a] -= dot * n[a];
}
/*
  Traction at a slip and a pressure, and its derivatives; the slip becomes the kept one: the elastic slip of the
  traction. True where it slides.
*/
PetscBool MpmContactSlide(const MpmContactLaw *law, PetscInt dim, PetscReal pressure, PetscReal slip[],
                          MpmContactFriction *friction);
/* A barrier's pressure at a gap, 0 from `reach` on, and its fall with the gap; PETSC_FALSE where the gap is closed. */
PetscBool MpmContactBarrier(const MpmContactLaw *law, PetscReal reach, PetscReal gap, PetscReal *pressure,
                            PetscReal *rate);

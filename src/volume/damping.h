#pragma once
/*
  Damping of the material: Rayleigh's damping, bulk viscosity, and dashpots at nodes (damping.c).
*/
#include "base/base.h"
#include "base/types.h"
#include "transfer/motion.h"
#include "assembly/terms.h"

extern const MpmTerm MpmTermDamping; /* damping of motion (damping.c); ctx: MpmDamping */

/*
  The velocity of a step is v = factor u + rest, u its displacement. Dashpots are those of absorbing conditions
  (absorbing.c) and, times the nodes' mass, Rayleigh's `mass`.
*/
struct MpmDamping {
  PetscBool            active;            /* in the step */
  PetscReal            mass, stiffness;   /* Rayleigh's, 1/s and s */
  PetscReal            linear, quadratic; /* coefficients of the bulk viscosity */
  const MpmConditions *conditions;        /* of the scene, with those that are active */
  const MpmActing     *acting;
  PetscReal            factor;         /* 1/s */
  PetscReal           *rest, *dashpot; /* m/s and N s/m, dim values a local node */
  PetscReal           *viscosity;      /* MPM_VISCOSITIES values a point; NULL: none */
  const MpmMassMatrix *mass_matrix; /* where the mass is consistent dashpots of planes are spread as it is; or NULL */
  PetscReal *spread; /* 1/s, of these dashpots over the mass in their plane, dim values a local node; or NULL */
};

/* Of lambda tr d, of 2 mu d, and of the bulk viscosity's D and D^2, each times a volume. */
#define MPM_VISCOSITIES 4

PetscErrorCode MpmDampingReset(MpmDamping *damping);
/* True where any damping acts. */
PetscBool MpmDampingAny(const MpmDamping *damping);
/*
  The step's velocities at the local nodes, factor u + rest, and the dashpots of its inertia; once the term is prepared.
  An explicit step has the factor 0. Collective.
*/
PetscErrorCode MpmDampingSet(MpmDamping *damping, const MpmSpace *space, const MpmInertia *inertia, PetscReal factor,
                             const PetscReal rest[]);
/* Adds the dashpots of the absorbing conditions that act, at the local nodes (absorbing.c). Collective. */
PetscErrorCode MpmAbsorbingDashpots(const MpmDamping *damping, const MpmSum *sum, PetscReal dashpot[]);
/*
  Spreads dashpots over the nodes of their plane as the consistent mass M is,

    c_ij = M_ij (s_i + s_j)/2 ,   s_i = c_i / sum_j M_ij over the plane's nodes j,

  and has `spread` s in their place. Their sum stays. With a spread mass and dashpots that are not, waves along the
  plane, as those at an angle are, would meet another impedance than their own. Collective (absorbing.c).
*/
PetscErrorCode MpmAbsorbingSpread(MpmDamping *damping, const MpmSpace *space, const MpmMassMatrix *mass);
/* Forces of incoming waves, each rank's share, with velocities of the time `time`, times `scale`. */
PetscErrorCode MpmAbsorbingLoad(const MpmDamping *damping, const MpmSum *sum, PetscReal time, PetscReal scale,
                                PetscReal force[]);

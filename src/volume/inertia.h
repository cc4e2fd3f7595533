#pragma once
/*
  The forces of inertia in an implicit step.
*/
#include "base/base.h"
#include "base/types.h"
#include "space/motion.h"
#include "assembly/terms.h"

extern const MpmTerm MpmTermInertia; /* of the points' mass (inertia.c); ctx: MpmInertia */

/*
  A step's inertia is M (factor u + at_rest), where M is the mass, lumped at the nodes or consistent, u the step's
  displacement, and at_rest what the integrator makes of velocities and accelerations at the step's start (dynamics.c).
*/
struct MpmInertia {
  PetscBool  dynamic;      /* does a stage of the scene have inertia? */
  PetscBool  settles;      /* may one settle? */
  PetscBool  active;       /* does the step have it? */
  PetscBool  consistent;   /* is its mass? */
  PetscReal  factor;       /* 1/s2 */
  PetscInt   local, owned; /* nodes of the step's space */
  PetscReal *mass;         /* kg, lumped, of all local nodes; */
  PetscReal *at_rest;      /* m/s2, dim values a node */

  MpmMassMatrix matrix; /* where it is consistent */
};

PetscErrorCode MpmInertiaReset(MpmInertia *inertia);
/* Room for the local nodes of the space. */
PetscErrorCode MpmInertiaResize(MpmInertia *inertia, const MpmSpace *space);
/*
  Of values at the local nodes that are means of the points', weighted by mass, free components come closer to those that have the
  points' momentum with the consistent mass, M v = sum_p m_p w_p v_p: the first correction of Richardson's iteration,
  v += v - M_l^{-1} M v with the lumped mass M_l. What is left of a mean's smoothing is of fourth order in the cell.
  Source: Hammerquist, Nairn (2017), Comput. Meth. Appl. Mech. Eng. 318, 724-738, doi:10.1016/j.cma.2017.01.035 (XPIC, which
  iterates the same).
*/
PetscErrorCode MpmInertiaSharpen(const MpmInertia *inertia, const MpmSum *sum, const MpmConstraints *constraints,
                                 PetscReal values[]);

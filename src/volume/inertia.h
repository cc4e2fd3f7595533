#pragma once
/*
  The forces of inertia in an implicit step.
*/
#include "base/base.h"
#include "base/types.h"
#include "transfer/motion.h"
#include "assembly/terms.h"

extern const MpmTerm MpmTermInertia; /* of the points' mass (inertia.c); ctx: MpmInertia */

/*
  A step's inertia is M (factor u + at_rest), where M is the mass, lumped at the nodes or consistent, u the step's
  displacement, and at_rest what the integrator makes of velocities and accelerations at the step's start (dynamics.c).
*/
struct MpmInertia {
  PetscBool  dynamic;      /* a stage of the scene has inertia */
  PetscBool  settles;      /* a stage may settle */
  PetscBool  active;       /* the step has inertia */
  PetscBool  consistent;   /* its mass is consistent */
  PetscBool  solved;       /* nodal velocities come from the consistent mass: lumped masses may be negative */
  PetscReal  factor;       /* 1/s2 */
  PetscInt   local, owned; /* nodes of the step's space */
  PetscReal *mass;         /* kg, lumped, of all local nodes */
  PetscReal *at_rest;      /* m/s2, dim values a local node */

  MpmMassMatrix matrix; /* where it is consistent */
};

PetscErrorCode MpmInertiaReset(MpmInertia *inertia);
/* Room for the local nodes of the space. */
PetscErrorCode MpmInertiaResize(MpmInertia *inertia, const MpmSpace *space);
/* y += M a, of values at the local nodes, dim a node; the rows of ghosts have this rank's contribution. */
PetscErrorCode MpmInertiaTimes(const MpmInertia *inertia, const MpmSum *sum, const PetscReal a[], PetscReal y[]);
/* Adds the diagonal of M, likewise. */
PetscErrorCode MpmInertiaDiagonal(const MpmInertia *inertia, const MpmSum *sum, PetscReal diagonal[]);
/*
  Nodal velocities or accelerations from momentum or forces, where lumped masses may be negative (mass_solve.c)

  Collective on `comm`

  Input Parameters:
+ inertia     - with a consistent mass
. right       - sums over the points, kg m/s or N, dim values a local node; those of the owned ones are taken
- constraints - of the step

  Input and output parameter:
. values - m/s or m/s2, dim a local node: constrained unknowns keep theirs
*/
PetscErrorCode MpmInertiaSolve(const MpmInertia *inertia, const MpmSum *sum, const MpmConstraints *constraints,
                               MPI_Comm comm, const PetscReal right[], PetscReal values[]);
/*
  Corrects nodal values that are means of the points', weighted by mass: free components come closer to those with the
  points' momentum by the consistent mass, M v = sum_p m_p w_p v_p. This is the first correction of Richardson's
  iteration, v += v - M_l^{-1} M v with the lumped mass M_l. The remaining smoothing of a mean is of fourth order in the
  cell. Source: Hammerquist, Nairn (2017), Comput. Meth. Appl. Mech. Eng. 318, 724-738, doi:10.1016/j.cma.2017.01.035
  (XPIC, which repeats this).
*/
PetscErrorCode MpmInertiaSharpen(const MpmInertia *inertia, const MpmSum *sum, const MpmConstraints *constraints,
                                 PetscReal values[]);

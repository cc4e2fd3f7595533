#pragma once
/*
  The forces of inertia in an implicit step.
*/
#include "base/base.h"
#include "base/types.h"
#include "space/motion.h"

/*
  A step's inertia is M (factor u + at_rest), where M is the mass, lumped at the nodes or consistent, u the step's
  displacement, and at_rest what the integrator makes of velocities and accelerations at the step's start (dynamics.c).
*/
struct MpmInertia {
  PetscBool  dynamic;      /* does a stage of the scene have inertia? */
  PetscBool  active;       /* does the step? */
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
/* y += M a, of values at the local nodes, dim a node; the rows of ghosts hold what this rank adds to them. */
PetscErrorCode MpmInertiaMultiply(const MpmInertia *inertia, const MpmSum *sum, const PetscReal a[], PetscReal y[]);

#pragma once
/*
  Dynamics: shared by the integrators with inertia (dynamics.c).
*/
#include "base/base.h"
#include "base/types.h"
#include "transfer/transfer.h"
#include "talus/talus.h"
#include "query/scene.h"

/*
  Velocities and accelerations at the local nodes in the step that is tried, dim values a node; the masses are
  disc.context.inertia's. `old`: of the points, weighted by mass; `start`: the same as the formulae of the integrator
  take them, where prescribed unknowns move as they are told to.

    a_new = a_factor u + a_rest ,     v_new = v_factor u + v_rest
*/
struct MpmDynamics {
  PetscInt   local, capacity;
  PetscReal  a_factor, v_factor;
  PetscReal  alpha_f; /* fraction of the points' forces and the loads that is the step's start's */
  PetscReal *v_old, *v_start, *a_start, *a_rest, *v_rest, *v_new, *a_new;
  PetscReal *loads; /* the mean of the loads over the step, N */
  PetscInt   moves_room;
  PetscReal *moves; /* of explicit steps: the points' velocities, m/s */
};

/* Coefficients of a method with inertia. */
typedef struct {
  PetscReal beta, gamma, alpha_m, alpha_f;
} MpmTimeMethod;

/* Coefficients of the stage's method. */
MpmTimeMethod MpmTimeMethodOf(const MpmModel model);
/* Error of an implicit step (dynamics_error.c), as in MpmIntegrator. */
PetscErrorCode MpmDynamicsError(MpmModel model, PetscReal *estimate);
/* Damping of the stage under way; SetTime() of a stage calls it. */
void MpmDynamicsSetStage(MpmModel model);
/* As a stage begins: points that come to it from one without inertia are at rest. */
PetscErrorCode MpmDynamicsBegin(MpmModel model);
/* Room for the nodes of the step's space, in model->state.scheme.dynamics and in the inertia's arrays. */
PetscErrorCode MpmDynamicsResize(MpmModel model);
PetscErrorCode MpmDynamicsDestroy(MpmDynamics **dynamics);
/* Rows of the state (base/rows.h). */
PetscErrorCode MpmDynamicsAddRows(MpmModel model);
/* Finds how long the next explicit step may be; `outcome` as in MpmIntegrator. */
PetscErrorCode MpmExplicitLength(MpmModel model, MpmOutcome *outcome);

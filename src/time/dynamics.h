#pragma once
/*
  Dynamics: what the integrators with inertia share (dynamics.c) and their options (integrator_read.c).
*/
#include "base/base.h"
#include "base/types.h"
#include "space/momentum.h"
#include "talus/talus.h"
#include "time/scene.h"

/*
  Velocities and accelerations at the local nodes in the step that is tried, dim values a node; the masses are
  disc.inertia's. `old`: of the points, weighted by mass; `start`: the same as the formulae of the integrator take them,
  where prescribed unknowns move as they are told to.

    a_new = a_factor u + a_rest ,     v_new = v_factor u + v_rest
*/
struct MpmDynamics {
  PetscInt   local, capacity;
  PetscReal  a_factor, v_factor;
  PetscReal  alpha_f; /* what of the points' forces and the loads is the step's start's */
  PetscReal *v_old, *v_start, *a_start, *a_rest, *v_rest, *v_new, *a_new;
  PetscReal *loads; /* the mean of the loads over the step, N */
  PetscInt   moves_room;
  PetscReal *moves; /* of explicit steps: the points' velocities, m/s */
};

extern const char *const MpmIntegratorTypes[];
/* A stage's integrator, and how steps of fields with a rate go on; `control` holds the defaults on entry. */
PetscErrorCode MpmIntegratorRead(const MpmOptions *block, MpmTimeControl *control);
void           MpmMotionDefaults(MpmMotionControl *motion);
/* After the stages have been read: what bodies and materials say for dynamics. */
PetscErrorCode MpmDynamicsRead(MpmModel model, const MpmOptions *options);
/* Does any stage of the scene solve equations; has any inertia in them? */
PetscBool MpmStagesSolve(const MpmModel model);
PetscBool MpmStagesAreImplicit(const MpmModel model);
/* Are the steps that are solved for minimisations (problem/potential.h)? Once the discretization is set up. */
PetscBool MpmStagesMinimise(const MpmModel model);
/* Does any stage of the scene have inertia, and do its points carry affine velocities? */
PetscBool MpmStagesAreDynamic(const MpmModel model);
PetscBool MpmStagesAreAffine(const MpmModel model);
/* What the stage under way takes from motion; SetTime() of a stage calls it. */
void MpmDynamicsSetStage(MpmModel model);
/* As a stage begins: points that come to it from one without inertia are at rest. */
PetscErrorCode MpmDynamicsBegin(MpmModel model);
/* Room for the nodes of the step's space, in model->state.scheme.dynamics and in the inertia's arrays. */
PetscErrorCode MpmDynamicsResize(MpmModel model);
PetscErrorCode MpmDynamicsDestroy(MpmDynamics **dynamics);
/* An explicit step's longest, over the time in which a wave crosses a cell (explicit_length.c). */
PetscReal MpmExplicitPart(const MpmMotionControl *motion);
/* Finds how long the next explicit step may be; `why` as in MpmIntegrator. */
PetscErrorCode MpmExplicitLength(MpmModel model, const char **why);
/* Of the stage under way. */
const MpmMotionControl *MpmModelMotion(const MpmModel model);

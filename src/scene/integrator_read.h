#pragma once
/*
  Integrators of stages: their options (integrator_read.c), and their demands on the scene.
*/
#include "base/base.h"
#include "base/types.h"
#include "talus/talus.h"
#include "query/scene.h"

extern const char *const MpmIntegratorTypes[];
/* A stage's integrator, and how steps of fields with a rate go on; `control` holds the defaults on entry. */
PetscErrorCode MpmIntegratorRead(const MpmOptions *block, MpmTimeControl *control);
void           MpmMotionDefaults(MpmMotionControl *motion);
/* After the stages have been read: options of bodies and materials for dynamics. */
PetscErrorCode MpmDynamicsRead(MpmModel model, const MpmOptions *options);
/* True where any stage of the scene solves equations; where any of these has inertia. */
PetscBool MpmStagesSolve(const MpmModel model);
PetscBool MpmStagesAreImplicit(const MpmModel model);
/* True where the implicit steps are minimisations (problem/potential.h). Once the discretization is set up. */
PetscBool MpmStagesMinimise(const MpmModel model);
/* True where any stage of the scene has inertia; where its points carry affine velocities. */
PetscBool MpmStagesAreDynamic(const MpmModel model);
PetscBool MpmStagesAreAffine(const MpmModel model);

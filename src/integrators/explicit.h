#pragma once
/*
  Parts of an explicit step.
*/
#include "base/base.h"
#include "base/types.h"
#include "talus/talus.h"

/*
  Prescribed velocities (explicit_supports.c): those that bring nodes to their places; those at a time; those before the
  step, from which the change is the reaction.
*/
void           MpmExplicitPrescribe(const MpmModel model, PetscReal velocity[]);
PetscErrorCode MpmExplicitPrescribeAt(MpmModel model, PetscReal time, PetscReal velocity[]);
PetscErrorCode MpmExplicitPrescribeStart(MpmModel model, PetscReal velocity[]);

/* True where the scene's shape functions are linear, without domains of points. */
PetscBool MpmExplicitIsLinear(const MpmModel model);
/*
  Nearly massless nodes (explicit_light.c). Exist: those whose gradients do not fall with their mass. Limit: the
  displacement of a step with nodal mass bounded below, dt times the velocities, or with dt = 1 of these.
  LimitGradients: the displacement for gradients; the velocity change of light nodes beside the free fall of all is
  limited, after an increment of `kick`, s. LimitContact: stiffness of contact, by the masses that it sees.
*/
PetscBool      MpmLightNodesExist(const MpmModel model);
void           MpmLightNodesLimit(const MpmModel model, PetscReal dt, PetscReal u[]);
void           MpmLightNodesLimitGradients(const MpmModel model, PetscReal kick, PetscReal dt, PetscReal u[]);
PetscErrorCode MpmLightNodesLimitContact(MpmModel model, PetscReal dt);

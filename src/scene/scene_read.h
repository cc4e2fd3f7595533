#pragma once
/*
  Reading of contacts, surfaces and stabilization.
*/
#include "base/types.h"
#include "query/model.h"

/* True where the pressure bounds the traction along a surface that may part. A material's strength may bound it
   instead where it sticks. */
PetscBool MpmPressureBounds(const MpmModel model, PetscReal friction, PetscBool stick);
/* Contacts of bodies with one another, and the parts of the material that they make (contacts_read.c); `water`: ground
   is saturated. */
PetscErrorCode MpmContactsRead(MpmModel model, PetscBool water, const MpmOptions *options);
/*
  Surfaces of bodies (surfaces_read.c): their blocks, behind the boundaries'; which points are those of their bodies,
  once they are there; and their part in the discretization, once that is set up.
*/
PetscErrorCode MpmSurfacesRead(MpmModel model, const MpmOptions *options);
void           MpmSurfacesSetBodies(MpmModel model);
PetscErrorCode MpmSurfacesAdd(MpmModel model);
/* Lines on faces of surfaces on all sides that are left out in the stage that begins. Collective. */
PetscErrorCode MpmSurfacesTellHeld(MpmModel model);
/* The shape and the order of its elements, before the grid; and what it must not be combined with, once all else is
   read (shape_read.c). */
PetscErrorCode MpmShapeRead(MpmModel model, const MpmOptions *options);
PetscErrorCode MpmShapeCheck(const MpmModel model);
/* Refuses what air and backgrounds do not go with (voids_check.c). Once stages and contacts are read. */
PetscErrorCode MpmVoidsCheck(const MpmModel model);
/* Refuses what needs a displacement where the physics has none (in_place_check.c). Once all of the scene is read. */
PetscErrorCode MpmInPlaceCheck(MpmModel model);
/*
  Ghost penalty and F-bar (stabilization.c): Read takes the options, Settle makes the choice of `auto` once materials,
  bodies, conditions and stages are known.
*/
PetscErrorCode MpmStabilizationRead(MpmModel model, const MpmOptions *options);
PetscErrorCode MpmStabilizationSettle(MpmModel model, const MpmOptions *options);
PetscErrorCode MpmStabilizationText(const MpmModel model, size_t length, char text[]);

#pragma once
/*
  The step's end of a field with a rate at a point: its value p' and gradient g' by the new position,

    p' = p ,   g' = dF^{-T} G ,   dF = I + H

  with H and G the gradients of the displacement and of the field, and p its value, all of them inputs of the kernel. At
  the end of the first of two stages also its deviation, an input as well.
*/
#include "stepmap/step_map.h"

/* The kernel's input of a component by a basis function, or -1. */
PetscInt MpmInputOf(const MpmLayout *layout, PetscInt component, PetscInt basis);

/* With dinput the change of the inputs, in rows of MPM_PACK numbers. Nothing without a rate. */
void MpmRatesEndAlong(const MpmStepMap *map, PetscInt p, const PetscReal input[], const PetscReal dinput[],
                      MpmPointVector *end);
/* The derivative of pbar p' + gbar . g' by the inputs, added, with the bars of `end`. */
void MpmRatesPullInputs(const MpmStepMap *map, PetscInt p, const PetscReal input[], const MpmPointVector *end,
                        PetscReal by_input[]);
/* True where the physics has at most one rate, of a field with value, gradient and deviation in the scene's shape. */
PetscBool MpmRatesAreClosed(const MpmLayout *layout);

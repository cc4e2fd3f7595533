#pragma once
/*
  Properties of the block of fields that a problem solves for, which follow from the physics (point/layout.h). Solvers
  and steps ask for these alone, not for the number of fields.
*/
#include "point/layout.h"

/* True where unknowns and equations are conjugate, as displacements and forces: their product is a work. */
static inline PetscBool MpmFieldsDoWork(const MpmLayout *layout)
{
  return (PetscBool)(layout->field_count == 1);
}
/* True where fields have units, norms and tolerances of their own. */
static inline PetscBool MpmFieldsHaveNorms(const MpmLayout *layout)
{
  return (PetscBool)!MpmFieldsDoWork(layout);
}
/* True where a node's displacement is all that is solved for. */
static inline PetscBool MpmFieldsAreMotion(const MpmLayout *layout)
{
  return (PetscBool)(layout->block == layout->dim && layout->component[0].increment);
}
/* True where the points' forces derive from a stored energy, if their laws have one. */
static inline PetscBool MpmFieldsHaveEnergy(const MpmLayout *layout)
{
  return (PetscBool)(MpmFieldsAreMotion(layout) && layout->traits.solid && !layout->means);
}

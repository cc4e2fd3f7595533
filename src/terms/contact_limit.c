/*
  Contact in explicit steps: a penalty stays stable only while it cannot throw back what it stops.

  A patch sees the mean displacement of its facets, sum_i w_i u_i, behind which is the mass 1/sum_i w_i^2/m_i. With the force k A g at
  the gap g that the step would end with, k A <= m/dt^2 brings it to zero at most. Each node of a surface is shared by 2^(dim - 1)
  patches, whose forces add up: each gets its part.
*/
#include "space/space.h"
#include "space/sum.h"
#include "terms/contact.h"

/* The inverse of the mass that the patch moves, 1/kg; nodes without mass do not count. */
static PetscReal InverseMass(const MpmContacts *contacts, const MpmSum *sum, const MpmPatch *patch,
                             const PetscReal mass[])
{
  const MpmGroup *box   = &sum->space->groups[patch->box];
  const PetscInt *nodes = &sum->space->group_nodes[box->node_offset];
  PetscReal       total = 0.;

  for (PetscInt i = 0; i < box->node_count; i++) {
    PetscReal w = 0.;

    if (nodes[i] < 0) continue;
    for (PetscInt f = patch->begin; f < patch->end; f++)
      w += contacts->facet[f].area / patch->area * MpmFacetWeights(contacts, f)[i];
    if (w != 0. && mass[nodes[i]] > 0.) total += w * w / mass[nodes[i]];
  }
  return total;
}

void MpmContactsLimit(MpmContacts *contacts, const MpmSum *sum, const PetscReal mass[], PetscReal dt)
{
  const PetscReal share = sum->space->dim == 2 ? 0.5 : 0.25;

  for (PetscInt k = 0; k < contacts->patch_count; k++) {
    MpmPatch       *patch   = &contacts->patch[k];
    const PetscReal inverse = InverseMass(contacts, sum, patch, mass);

    if (!(patch->area > 0.) || !(inverse > 0.)) continue;
    patch->stiffness = PetscMin(patch->stiffness, share / (inverse * dt * dt * patch->area));
  }
}

/*
  Patches of material that flows, in explicit steps (facets/flow_facets.c): an inelastic stop at the surface.

  With the mean distance g_0 of the patch's facets at the step's start, and w its change in the step without contact,

    g = g_0 + w           where g_0 >= 0: the approach ends at the surface;
    g = w + max(b g_0, w) where g_0 < 0 and w < 0: the approach ends, and the depth falls by its share b, at most as
                          fast as it came; nothing where the material leaves ,

  and the force k A (-g) makes the change -g of that distance. Material never leaves faster than it came: the
  contact adds no energy, whichever points come to a patch or leave it, or change the pixel of a terrain below them. A
  penalty on the depth instead throws them out of the surface within a step.

  The force acts along the vectors W_i = sum_q (A_q/A) w_qi n_q of the nodes. Patches share nodes: with the sums
  N_i = sum |W_i| over all of them, by components, k A dt^2 sum_i |W_i|.N_i/m_i = 1 stops a uniform approach in one step
  and no other too far: the rows of this system have no larger sum (Jacobi's iteration with lumped rows).

  Source for the stop of velocities: Moreau (1988), Unilateral contact and dry friction in finite freedom dynamics,
  doi:10.1007/978-3-7091-2624-0_1.
*/
#include "space/space.h"
#include "space/sum.h"
#include "contact/contact.h"

#define RECOVER 0.1 /* of the depth, in a step */

PetscBool MpmFlowGap(const MpmContacts *contacts, const MpmPatch *patch, PetscReal *gap)
{
  PetscReal start = 0., way;

  for (PetscInt f = patch->begin; f < patch->end; f++)
    start += contacts->facets.at[f].area / patch->area * contacts->facets.at[f].distance;
  if (start >= 0.) return (PetscBool)(*gap < 0.);
  way  = *gap - start;
  *gap = way + PetscMax(RECOVER * start, way);
  return (PetscBool)(way < 0.);
}

/* Adds |W_i| of a patch to the nodes' sums, or returns sum_i |W_i|.N_i/m_i. */
static PetscReal Visit(const MpmContacts *contacts, const MpmSum *sum, const MpmPatch *patch, const PetscReal mass[],
                       PetscReal sums[], PetscBool add)
{
  const MpmGroup *box   = &sum->space->groups[patch->box];
  const PetscInt *nodes = &sum->space->group_nodes[box->node_offset], dim = sum->space->dim;
  PetscReal       total = 0.;

  for (PetscInt i = 0; i < box->node_count; i++) {
    PetscReal W[MPM_MAX_DIM] = {0., 0., 0.};

    if (nodes[i] < 0 || !(mass[nodes[i]] > 0.)) continue;
    for (PetscInt f = patch->begin; f < patch->end; f++) {
      const MpmFacet *facet = &contacts->facets.at[f];
      const PetscReal w     = facet->area / patch->area * MpmFacetWeights(contacts, f)[i];

      for (PetscInt a = 0; a < dim; a++) W[a] += w * facet->normal[a];
    }
    for (PetscInt a = 0; a < dim; a++) {
      if (add) sums[nodes[i] * dim + a] += PetscAbsReal(W[a]);
      else total += PetscAbsReal(W[a]) * sums[nodes[i] * dim + a] / mass[nodes[i]];
    }
  }
  return total;
}

PetscErrorCode MpmFlowLimit(MpmContacts *contacts, const MpmSum *sum, const PetscReal mass[], PetscReal dt)
{
  const PetscInt dim = sum->space->dim;
  PetscReal     *sums;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1((size_t)(sum->space->local * dim) + 1, &sums));
  for (PetscInt k = 0; k < contacts->patch_count; k++)
    if (MpmPatchFlows(contacts, &contacts->patch[k]))
      (void)Visit(contacts, sum, &contacts->patch[k], mass, sums, PETSC_TRUE);
  PetscCall(MpmSpaceAddToOwners(sum->space, dim, sums));
  PetscCall(MpmSpaceToGhosts(sum->space, dim, sums));
  for (PetscInt k = 0; k < contacts->patch_count; k++) {
    MpmPatch *patch = &contacts->patch[k];
    PetscReal total;

    if (!MpmPatchFlows(contacts, patch)) continue;
    total            = Visit(contacts, sum, patch, mass, sums, PETSC_FALSE);
    patch->direct    = PETSC_TRUE;
    patch->stiffness = total > 0. ? 1. / (total * dt * dt * patch->area) : 0.;
  }
  PetscCall(PetscFree(sums));
  PetscFunctionReturn(PETSC_SUCCESS);
}

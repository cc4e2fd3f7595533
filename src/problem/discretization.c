/*
  The discrete problem of a step: its permanent data, and its end.
*/
#include "point/layout.h"
#include "point/material.h"
#include "grid/grid.h"
#include "particles/points.h"
#include "space/space.h"
#include "space/sum.h"
#include "bc/bc.h"
#include "assembly/sparsity.h"
#include "assembly/terms.h"
#include "points/point_terms.h"
#include "terrain/bed_flow.h"
#include "volume/added_term.h"
#include "volume/background.h"
#include "volume/damping.h"
#include "volume/inertia.h"
#include "volume/irreversible.h"
#include "volume/volume.h"
#include "pairs/body_contact.h"
#include "contact/contact.h"
#include "contact/rigid_body.h"
#include "loads/body_surface.h"
#include "problem/discretization.h"
#include "problem/evaluation.h"

PetscErrorCode MpmDiscretizationCreate(MPI_Comm comm, MpmGrid *grid, MpmLayout *layout, MpmDiscretization *disc)
{
  PetscFunctionBeginUser;
  *disc = (MpmDiscretization){.comm = comm, .grid = grid, .layout = layout, .material.parts = 1};
  PetscCall(PetscNew(&disc->points));
  PetscCall(PetscNew(&disc->space));
  PetscCall(PetscNew(&disc->constraints));
  PetscCall(PetscNew(&disc->context.contacts));
  PetscCall(PetscNew(&disc->context.pairs));
  PetscCall(PetscNew(&disc->context.surfaces));
  PetscCall(PetscNew(&disc->context.inertia));
  PetscCall(PetscNew(&disc->context.damping));
  PetscCall(PetscNew(&disc->trial));
  PetscCall(PetscNew(&disc->set));
  *disc->set = (MpmSum){
    .grid = grid, .cell = grid->h, .space = disc->space, .layout = layout, .points = disc->points, .step.part = 1.};
  disc->sum = disc->set;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmDiscretizationSize(MpmDiscretization *disc)
{
  PetscFunctionBeginUser;
  disc->dim        = disc->grid->dim;
  disc->block      = disc->layout->block;
  disc->set->block = disc->layout->block;
  PetscCall(PetscArraycpy(disc->h, disc->grid->h, MPM_MAX_DIM));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmDiscretizationSetUp(MpmDiscretization *disc, const MpmMaterials *materials,
                                      const MpmBoundaries *boundaries, const MpmBodies *bodies, const MpmPairs *pairs,
                                      MpmPlacement *placements, PetscInt state_size)
{
  PetscFunctionBeginUser;
  disc->material.count  = materials->count;
  disc->set->materials  = materials->at;
  disc->set->kept.state = state_size;
  disc->set->kept.own   = disc->layout->own.size;
  PetscCall(MpmContactsCreate(boundaries->count, boundaries->at, disc->context.contacts));
  disc->context.contacts->facets.shaped = bodies;
  PetscCall(MpmRigidCreate(disc->context.contacts, placements));
  disc->context.contacts->material_count = materials->count;
  PetscCall(MpmTermsAdd(&disc->terms, disc->layout->means ? &MpmTermCellMeans : &MpmTermPoints, NULL));
  if (disc->layout->own.taken_up >= 0) PetscCall(MpmTermsAdd(&disc->terms, &MpmTermWaterWeight, NULL));
  PetscCall(MpmTermsAdd(&disc->terms, &MpmTermGhost, NULL));
  if (boundaries->count) PetscCall(MpmTermsAdd(&disc->terms, &MpmTermContact, disc->context.contacts));
  PetscCall(MpmPairContactsCreate(disc->comm, pairs, bodies, state_size, MpmPressureComponent(disc->layout),
                                  disc->context.pairs));
  if (pairs->count) PetscCall(MpmTermsAdd(&disc->terms, &MpmTermBodyContact, disc->context.pairs));
  if (disc->context.contacts->facets.bodies)
    PetscCall(MpmTermsAdd(&disc->terms, &MpmTermRigidBodies, disc->context.contacts));
  if (disc->context.inertia->dynamic || disc->context.inertia->settles)
    PetscCall(MpmTermsAdd(&disc->terms, &MpmTermInertia, disc->context.inertia));
  if (disc->context.inertia->dynamic) PetscCall(MpmTermsAdd(&disc->terms, &MpmTermDamping, disc->context.damping));
  if (disc->context.bed) {
    disc->context.bed->materials = materials->count;
    PetscCall(MpmTermsAdd(&disc->terms, &MpmTermBed, disc->context.bed));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmDiscretizationAddSurfaces(MpmDiscretization *disc, const MpmBodySurfaces *surfaces,
                                            MpmLoadActing *acting, const MpmKernelSet *kernel)
{
  PetscFunctionBeginUser;
  if (!surfaces->count) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmSurfaceFacesCreate(surfaces, acting, disc->context.surfaces));
  PetscCall(MpmTermsAdd(&disc->terms, &MpmTermSurfaces, disc->context.surfaces));
  disc->context.surfaces->kernel    = kernel;
  disc->context.surfaces->contacts  = disc->context.contacts;
  disc->context.surfaces->component = MpmPressureComponent(disc->layout);
  if (disc->context.surfaces->any_held)
    PetscCall(MpmTermsAdd(&disc->terms, &MpmTermSurfaceFlow, disc->context.surfaces));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmDiscretizationAddTerms(MpmDiscretization *disc, MpmAddedTerms *added)
{
  PetscFunctionBeginUser;
  if (added->held) PetscCall(MpmTermsAdd(&disc->terms, &MpmTermIrreversible, added->held));
  if (added->backgrounds) PetscCall(MpmTermsAdd(&disc->terms, &MpmTermBackground, added->backgrounds));
  for (PetscInt k = 0; k < added->count; k++) PetscCall(MpmTermsAdd(&disc->terms, &added->at[k].term, &added->at[k]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MpmDiscretizationSetStep(MpmDiscretization *disc, const MpmSumStep *step)
{
  disc->set->step = *step;
}

void MpmDiscretizationSetAlternate(MpmDiscretization *disc, PetscBool alternate)
{
  disc->set->step.alternate = alternate;
}

PetscErrorCode MpmDiscretizationSetDeviations(MpmDiscretization *disc, PetscReal deviation_n[])
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(disc->set->deviation_n));
  disc->set->deviation_n = deviation_n;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmDiscretizationSetWater(MpmDiscretization *disc, const MpmWaterAtRest *still)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree3(disc->set->still.pressure, disc->set->still.bent, disc->set->still.gravity));
  disc->set->still = *still;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscInt MpmNodesLocal(const MpmDiscretization *disc)
{
  return disc->space->local;
}

PetscInt MpmNodesOwned(const MpmDiscretization *disc)
{
  return disc->space->owned;
}

PetscInt MpmNodesTotal(const MpmDiscretization *disc)
{
  return disc->space->number.count;
}

PetscBool MpmNodeInGrid(const MpmDiscretization *disc, PetscInt node)
{
  return (PetscBool)!MpmSpaceIsExtra(disc->space, node);
}

PetscErrorCode MpmNodesToGhosts(const MpmDiscretization *disc, PetscInt block, PetscReal local[])
{
  return MpmSpaceToGhosts(disc->space, block, local);
}

PetscErrorCode MpmNodesToOwners(const MpmDiscretization *disc, PetscInt block, PetscReal local[])
{
  return MpmSpaceAddToOwners(disc->space, block, local);
}

const PetscInt *MpmOwnedNodes(const MpmDiscretization *disc, PetscInt *count)
{
  *count = disc->space->owned;
  return disc->space->node;
}

PetscReal MpmNodeStiffness(const MpmDiscretization *disc, PetscReal modulus)
{
  return modulus * PetscPowRealInt(disc->h[0], disc->dim - 2) * MpmGridTurn(disc->grid, disc->grid->upper[0]);
}

void MpmNodePosition(const MpmDiscretization *disc, PetscInt node, PetscReal x[])
{
  PetscInt at[MPM_MAX_DIM];

  MpmSpaceAt(disc->space, &disc->space->node[node * disc->dim], at);
  for (PetscInt a = 0; a < disc->dim; a++) x[a] = MpmGridNodeAt(disc->grid, a, at[a]);
}

PetscErrorCode MpmDiscretizationDestroy(MpmDiscretization *disc)
{
  PetscFunctionBeginUser;
  PetscCall(MpmPatternDestroy(&disc->matrix.pattern));
  PetscCall(MpmSpaceReset(disc->space));
  PetscCall(MpmConstraintsReset(disc->constraints));
  PetscCall(PetscFree3(disc->nodal.u, disc->nodal.residual, disc->nodal.force));
  PetscCall(PetscFree(disc->set->deviation_n));
  PetscCall(MpmTrialReset(disc->trial));
  PetscCall(PetscFree(disc->nodal.reaction));
  PetscCall(MpmContactsDestroy(disc->context.contacts));
  PetscCall(MpmPairContactsDestroy(disc->context.pairs));
  PetscCall(MpmSurfaceFacesDestroy(disc->context.surfaces));
  PetscCall(MpmTermsDestroy(&disc->terms));
  PetscCall(PetscFree(disc->points));
  PetscCall(PetscFree(disc->space));
  PetscCall(PetscFree(disc->constraints));
  PetscCall(PetscFree(disc->context.contacts));
  PetscCall(PetscFree(disc->context.pairs));
  PetscCall(PetscFree(disc->context.surfaces));
  PetscCall(MpmInertiaReset(disc->context.inertia));
  PetscCall(PetscFree(disc->context.inertia));
  PetscCall(MpmDampingReset(disc->context.damping));
  PetscCall(PetscFree(disc->context.damping));
  PetscCall(PetscFree(disc->trial));
  PetscCall(PetscFree3(disc->set->still.pressure, disc->set->still.bent, disc->set->still.gravity));
  PetscCall(PetscFree(disc->set));
  PetscFunctionReturn(PETSC_SUCCESS);
}

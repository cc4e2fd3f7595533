/*
  Pairs of bodies in contact: their options, and their contacts of a run.
*/
#include "options/options.h"
#include "rigid/rigid.h"
#include "facets/contact_search.h"
#include "pairs/body_facets.h"

#define FIRM 500. /* penalties, unless one is given: as at rigid surfaces on materials that do not flow, */
#define RUBS 100. /* and on these with Coulomb's friction */

PetscErrorCode MpmPairRead(const MpmOptions *block, PetscInt dim, PetscBool water, MpmPair *pair)
{
  static const char *const methods[] = {"penalty", "barrier", "augmented", NULL}, *const waters[] = {"sealed", "open",
                                                                                                     NULL};
  char     field[256];
  PetscInt method = 0, open = 0;

  PetscFunctionBeginUser;
  pair->penalty = FIRM;
  PetscCall(MpmFrictionRead(block, &pair->friction, &pair->adhesion, &pair->stick));
  pair->tangential = (PetscBool)(pair->stick || pair->friction > 0. || pair->adhesion > 0.);
  PetscCall(MpmOptionsWord(
    block, "method", "penalty: bodies push where they overlap; barrier: before they meet; augmented: without overlap",
    methods, MPM_OPTIONAL, &method, NULL));
  pair->barrier     = (PetscBool)(method == 1);
  pair->augmented   = (PetscBool)(method == 2);
  pair->penetration = 1e-8;
  if (pair->augmented || MpmOptionsHelp())
    PetscCall(MpmOptionsReal(block, "penetration", "h", "augmented: mean depth in a cell that may remain, by its size",
                             MPM_RANGE_POSITIVE, MPM_OPTIONAL, &pair->penetration, NULL));
  PetscCall(
    MpmOptionsReal(block, "penalty", "E/h",
                   "pressure by depth, times the softer body's Young's modulus over the cell size; unless given, "
                   "10 where one of them flows, 100 with a coefficient of friction",
                   MPM_RANGE_POSITIVE, MPM_OPTIONAL, &pair->penalty, &pair->firm));
  if (!pair->firm && pair->friction > 0.) pair->penalty = RUBS;
  if (water)
    PetscCall(MpmOptionsWord(block, "water", "physics with water: none passes, or all does where the bodies touch",
                             waters, MPM_OPTIONAL, &open, NULL));
  pair->open = (PetscBool)(open == 1);
  PetscCall(PetscSNPrintf(field, sizeof(field), "gap_%s", pair->name));
  PetscCall(PetscStrallocpy(field, &pair->gap_field));
  PetscCall(PetscSNPrintf(field, sizeof(field), "pressure_%s", pair->name));
  if (pair->augmented) PetscCall(PetscStrallocpy(field, &pair->pressure_field));
  for (PetscInt a = 0; pair->tangential && a < dim; a++) {
    PetscCall(PetscSNPrintf(field, sizeof(field), "slip_%s_%c", pair->name, "xyz"[a]));
    PetscCall(PetscStrallocpy(field, &pair->slip_field[a]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPairKeepRest(MpmPair *pair)
{
  char field[256];

  PetscFunctionBeginUser;
  if (pair->barrier || pair->rest_field) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscSNPrintf(field, sizeof(field), "rest_%s", pair->name));
  PetscCall(PetscStrallocpy(field, &pair->rest_field));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPairsDestroy(MpmPairs *pairs)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < pairs->count; k++) {
    PetscCall(PetscFree(pairs->at[k].name));
    PetscCall(PetscFree(pairs->at[k].gap_field));
    PetscCall(PetscFree(pairs->at[k].pressure_field));
    PetscCall(PetscFree(pairs->at[k].rest_field));
    for (PetscInt a = 0; a < MPM_MAX_DIM; a++) PetscCall(PetscFree(pairs->at[k].slip_field[a]));
  }
  PetscCall(MpmNamesDestroy(pairs->count, &pairs->names));
  PetscCall(PetscFree(pairs->at));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPairContactsCreate(MPI_Comm comm, const MpmPairs *pairs, const MpmBodies *bodies, PetscInt state_size,
                                     PetscInt water, MpmPairContacts *contacts)
{
  PetscFunctionBeginUser;
  contacts->bodies     = bodies;
  contacts->pairs      = pairs;
  contacts->comm       = comm;
  contacts->state_size = state_size;
  contacts->water      = water;
  PetscCall(PetscCalloc1(pairs->count, &contacts->force));
  if (pairs->count) PetscCall(MpmContactSearchRegister(&contacts->facets.search));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPairContactsDestroy(MpmPairContacts *contacts)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(contacts->force));
  PetscCall(PetscFree(contacts->facets.at));
  PetscCall(PetscFree(contacts->facets.list));
  PetscCall(PetscFree(contacts->patch));
  PetscCall(PetscFree(contacts->weights.at));
  PetscFunctionReturn(PETSC_SUCCESS);
}

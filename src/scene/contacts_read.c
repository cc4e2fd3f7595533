/*
  Contacts of bodies with one another: which bodies, and the parts of the material that they make. Parts have nodes of
  their own, so that bodies of different parts are not welded where they meet.
*/
#include "options/options.h"
#include "point/material.h"
#include "particles/body.h"
#include "pairs/body_contact.h"
#include "query/model.h"
#include "scene/scene_read.h"

/* The bodies of a contact, by their numbers. */
static PetscErrorCode ReadPair(const MpmOptions *block, const MpmBodies *bodies, PetscInt pair[2])
{
  PetscInt count;
  char   **names;

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsNames(block, "bodies",
                            "the two bodies that touch, slide and part; others are welded where they meet",
                            MPM_REQUIRED, &count, &names));
  if (MpmOptionsHelp()) {
    PetscCall(MpmNamesDestroy(count, &names));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  MpmCheckInput(count == 2, "-%sbodies: %" PetscInt_FMT " given, must be 2", block->prefix, count);
  for (PetscInt k = 0; k < 2; k++) {
    pair[k] = 0;
    while (pair[k] < bodies->count && strcmp(bodies->names[pair[k]], names[k])) pair[k]++;
    MpmCheckInput(pair[k] < bodies->count, "-%sbodies %s: must be in -mpm_bodies", block->prefix, names[k]);
  }
  MpmCheckInput(pair[0] != pair[1], "-%sbodies %s,%s: must be two bodies", block->prefix, names[0], names[1]);
  PetscCall(MpmNamesDestroy(count, &names));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Two contacts of the same bodies would both push. */
static PetscErrorCode CheckOnce(const MpmPairs *pairs, PetscInt pair, const MpmBodies *bodies)
{
  const PetscInt *body = pairs->at[pair].body;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < pair; k++) {
    const PetscInt *other = pairs->at[k].body;

    MpmCheckInput(!(other[0] == body[0] && other[1] == body[1]) && !(other[0] == body[1] && other[1] == body[0]),
                  "-mpm_contact_%s_bodies %s,%s: contact %s is that of the same bodies", pairs->names[pair],
                  bodies->names[body[0]], bodies->names[body[1]], pairs->names[k]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscBool MpmPressureBounds(const MpmModel model, PetscReal friction, PetscBool stick)
{
  PetscBool bounds = (PetscBool)(friction > 0.);

  for (PetscInt m = 0; stick && m < model->scene.materials->count; m++)
    if (!model->scene.materials->at[m].info.shear_strength) bounds = PETSC_TRUE;
  return bounds;
}

PetscErrorCode MpmContactsRead(MpmModel model, PetscBool water, const MpmOptions *options)
{
  MpmBodies *bodies = model->scene.bodies;
  MpmPairs  *pairs  = model->scene.pairs;

  PetscFunctionBeginUser;
  bodies->parts = 1;
  PetscCall(PetscCalloc1(bodies->count, &bodies->part));
  PetscCall(MpmOptionsBlocks(options, "contacts", "names of the contacts of bodies with one another", MPM_OPTIONAL,
                             &pairs->count, &pairs->names));
  PetscCall(PetscCalloc1(pairs->count, &pairs->at));
  for (PetscInt k = 0; k < pairs->count; k++) {
    char       prefix[256];
    MpmOptions block = {options->comm, prefix, options->record};
    MpmPair   *pair  = &pairs->at[k];

    PetscCall(PetscSNPrintf(prefix, sizeof(prefix), "mpm_contact_%s_", pairs->names[k]));
    PetscCall(PetscStrallocpy(pairs->names[k], &pair->name));
    PetscCall(MpmOptionsHeading(&block, "Contact of bodies"));
    PetscCall(ReadPair(&block, bodies, pair->body));
    if (!MpmOptionsHelp()) PetscCall(CheckOnce(pairs, k, bodies));
    PetscCall(MpmPairRead(&block, model->disc.dim, (PetscBool)(water || MpmOptionsHelp()), pair));
    if (MpmPressureBounds(model, pair->friction, pair->stick)) model->solver.at_rest.serves = PETSC_TRUE;
    /* the first body of each has a part of its own, so the two differ */
    if (!MpmOptionsHelp() && !bodies->part[pair->body[0]]) bodies->part[pair->body[0]] = bodies->parts++;
  }
  for (PetscInt k = 0; k < 2 * pairs->count; k++)
    pairs->at[k / 2].part[k % 2] = bodies->part[pairs->at[k / 2].body[k % 2]];
  model->disc.material.parts = bodies->parts;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  A model's points, loads and reactions for a caller of the library.
*/
#include "point/material.h"
#include "particles/particles.h"
#include "bc/bc.h"
#include "bc/body_motion.h"
#include "pairs/body_contact.h"
#include "contact/contact.h"
#include "loads/load.h"
#include "query/model.h"

/* ---- loads and reactions ---- */

static PetscErrorCode FindLoad(MpmModel model, const char name[], PetscInt *load)
{
  PetscFunctionBeginUser;
  for (*load = 0; *load < model->scene.loads->count; (*load)++)
    if (!strcmp(model->scene.loads->names[*load], name)) break;
  PetscCheck(*load < model->scene.loads->count, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE, "there is no load %s", name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmModelSetLoadFactor(MpmModel model, const char name[], PetscReal factor)
{
  PetscInt load;

  PetscFunctionBeginUser;
  PetscCall(FindLoad(model, name, &load));
  PetscCheck(!PetscIsInfOrNanReal(factor), PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE,
             "load %s: its factor is not finite", name);
  model->state.acting.loads[load].forced = PETSC_TRUE;
  model->state.acting.loads[load].factor = factor;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmModelSetLoadValue(MpmModel model, const char name[], const PetscReal value[])
{
  PetscInt load;

  PetscFunctionBeginUser;
  PetscCall(FindLoad(model, name, &load));
  for (PetscInt a = 0; a < model->disc.dim; a++) {
    PetscCheck(!PetscIsInfOrNanReal(value[a]), PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE,
               "load %s: its value is not finite", name);
    model->scene.loads->at[load].value[a] = value[a];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmModelSetConditionValue(MpmModel model, const char name[], MpmConditionValue value, void *ctx)
{
  MpmCondition *bc = NULL;

  PetscFunctionBeginUser;
  for (PetscInt b = 0; b < model->scene.bcs->count; b++)
    if (!strcmp(model->scene.bcs->names[b], name)) bc = &model->scene.bcs->at[b];
  PetscCheck(bc, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE, "there is no condition %s", name);
  for (PetscInt k = 0; k < bc->component_count; k++)
    PetscCheck(bc->component[k] >= bc->motion, PETSC_COMM_SELF, PETSC_ERR_SUP,
               "condition %s prescribes a displacement, whose value is one for all nodes", name);
  bc->field = (MpmValueField){value, ctx};
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmModelGetReaction(MpmModel model, const char name[], PetscReal reaction[])
{
  const PetscInt   dim  = PetscMin(model->disc.dim, model->disc.block);
  const PetscReal *from = NULL;

  PetscFunctionBeginUser;
  for (PetscInt b = 0; b < model->scene.bcs->count; b++)
    if (!strcmp(model->scene.bcs->names[b], name)) from = &model->disc.nodal.reaction[b * model->disc.block];
  for (PetscInt m = 0; m < model->scene.motions->count; m++)
    if (!strcmp(model->scene.motions->names[m], name))
      from = &model->disc.nodal.reaction[(model->scene.bcs->count + m) * model->disc.block];
  for (PetscInt b = 0; b < model->scene.boundaries->count; b++)
    if (!strcmp(model->scene.boundaries->names[b], name)) from = model->disc.context.contacts->reaction[b];
  for (PetscInt k = 0; k < model->scene.pairs->count; k++)
    if (!strcmp(model->scene.pairs->names[k], name)) from = model->disc.context.pairs->force[k];
  PetscCheck(from, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE, "there is no condition, motion, boundary or contact %s",
             name);
  PetscCall(PetscArraycpy(reaction, from, dim));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- points ---- */

/* The model has been set up, and has points. */
static PetscErrorCode CheckPoints(const MpmModel model)
{
  PetscFunctionBeginUser;
  PetscCheck(!model->laboratory, PETSC_COMM_SELF, PETSC_ERR_SUP, "a stress point has no points of a grid");
  PetscCheck(model->caller.set_up, PETSC_COMM_SELF, PETSC_ERR_ARG_WRONGSTATE, "MpmModelSetUp() comes first");
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmModelGetPointCount(MpmModel model, PetscInt *local, PetscInt *total)
{
  PetscFunctionBeginUser;
  PetscCall(CheckPoints(model));
  if (local) PetscCall(DMSwarmGetLocalSize(model->state.particles->swarm, local));
  if (total) *total = (PetscInt)model->state.particles->total;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Fields that are the caller's business; the others are notes of the engine to itself. */
static PetscErrorCode FindField(MpmModel model, const char name[], PetscInt *components)
{
  static const char *const names[] = {"position", "position0", "F", "volume0", "stress", "state", "own", "value"};
  const MpmParticles      *points  = model->state.particles;
  PetscBool                ours    = PETSC_FALSE;

  PetscFunctionBeginUser;
  PetscCall(CheckPoints(model));
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(names); k++) ours = (PetscBool)(ours || !strcmp(names[k], name));
  *components = 0;
  for (PetscInt k = 0; ours && k < points->field_count; k++)
    if (!strcmp(points->fields[k].name, name)) *components = points->fields[k].components;
  PetscCheck(*components, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE, "the points have no field %s", name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmModelGetPoints(MpmModel model, const char name[], PetscInt *components, PetscReal **array)
{
  PetscInt count;

  PetscFunctionBeginUser;
  PetscCall(FindField(model, name, &count));
  PetscCall(MpmParticlesGetField(model->state.particles, name, array));
  if (components) *components = count;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmModelRestorePoints(MpmModel model, const char name[], PetscInt *components, PetscReal **array)
{
  PetscInt count;

  PetscFunctionBeginUser;
  PetscCall(FindField(model, name, &count));
  PetscCall(MpmParticlesRestoreField(model->state.particles, array));
  if (components) *components = 0;
  *array = NULL;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode GetIntegers(MpmModel model, const char name[], const PetscInt **array)
{
  PetscFunctionBeginUser;
  PetscCall(CheckPoints(model));
  PetscCall(MpmParticlesGetField(model->state.particles, name, array));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode RestoreIntegers(MpmModel model, const PetscInt **array)
{
  PetscFunctionBeginUser;
  PetscCall(MpmParticlesRestoreField(model->state.particles, array));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmModelGetPointIds(MpmModel model, const PetscInt **id)
{
  PetscFunctionBeginUser;
  PetscCall(GetIntegers(model, "id", id));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmModelRestorePointIds(MpmModel model, const PetscInt **id)
{
  PetscFunctionBeginUser;
  PetscCall(RestoreIntegers(model, id));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmModelGetPointMaterials(MpmModel model, const PetscInt **material)
{
  PetscFunctionBeginUser;
  PetscCall(GetIntegers(model, "material", material));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmModelRestorePointMaterials(MpmModel model, const PetscInt **material)
{
  PetscFunctionBeginUser;
  PetscCall(RestoreIntegers(model, material));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmModelFindState(MpmModel model, const char material[], const char variable[], PetscInt *first,
                                 PetscInt *components)
{
  const MpmStateVariable *states = model->scene.physics.states;
  size_t                  count  = (size_t)model->scene.physics.state_count;

  PetscFunctionBeginUser;
  if (material) {
    const MpmMaterial *from = NULL;

    for (PetscInt m = 0; m < model->scene.materials->count; m++)
      if (!strcmp(model->scene.materials->names[m], material)) from = &model->scene.materials->at[m];
    PetscCheck(from, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE, "there is no material %s", material);
    states = from->info.states;
    count  = from->info.state_count;
  }
  *first = 0;
  for (size_t k = 0; k < count; k++) {
    const PetscInt size = MpmStateComponents(&states[k], model->disc.dim);

    if (components) *components = size;
    if (!strcmp(states[k].name, variable)) PetscFunctionReturn(PETSC_SUCCESS);
    *first += size;
  }
  SETERRQ(PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE, "%s%s: there is no history variable %s",
          material ? "material " : "physics ", material ? material : model->scene.physics.name, variable);
}

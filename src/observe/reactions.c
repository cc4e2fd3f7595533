/*
  Columns of the forces on the material: of conditions, motions and boundaries, and of bodies on one another; of those
  of a flow on dams; of the places of boundaries, and the flow out of surfaces.
*/
#include "base/columns.h"
#include "point/layout.h"
#include "bc/bc.h"
#include "bc/body_motion.h"
#include "geometry/rotations.h"
#include "space/space.h"
#include "contact/contact.h"
#include "contact/rigid_body.h"
#include "loads/body_surface.h"
#include "loads/load.h"
#include "pairs/body_contact.h"
#include "terrain/bed_flow.h"
#include "query/model.h"
#include "observe/history.h"

/* ---- conditions and motions ---- */

static PetscErrorCode FillCondition(MpmModel model, const MpmColumn *column, PetscReal values[])
{
  const MpmCondition *condition = &model->scene.bcs->at[column->index];
  const PetscReal    *reaction  = &model->disc.nodal.reaction[column->index * model->disc.block];
  const PetscInt      count     = condition->component_count;

  PetscFunctionBeginUser;
  for (PetscInt c = 0; c < count; c++) values[c] = reaction[condition->component[c]];
  if (!condition->inclined) PetscFunctionReturn(PETSC_SUCCESS);
  values[count] = 0.;
  for (PetscInt a = 0; a < model->disc.dim; a++) values[count] += reaction[a] * condition->normal[a];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Of a component's residual in the reported reaction. */
static PetscReal Sign(const MpmModel model, PetscInt component)
{
  return model->disc.layout->component[component].negative ? -1. : 1.;
}

/* A condition's forces are the residuals of its nodes, of which each owner has all. */
static PetscErrorCode ConditionAlong(MpmModel model, const MpmColumn *column, const MpmPointVector *end,
                                     const PetscReal residual[], PetscReal values[])
{
  const MpmCondition *condition = &model->scene.bcs->at[column->index];
  const PetscInt      bs = model->disc.block, count = model->scene.bcs->count + model->scene.motions->count;
  PetscReal          *forces;

  PetscFunctionBeginUser;
  (void)end;
  PetscCall(PetscCalloc1((count * bs), &forces));
  MpmConstraintsAddReactions(model->disc.constraints, bs, model->disc.space->owned, residual, forces);
  for (PetscInt c = 0; c < condition->component_count; c++)
    values[c] = Sign(model, condition->component[c]) * forces[column->index * bs + condition->component[c]];
  PetscCall(PetscFree(forces));
  PetscCall(
    MPIU_Allreduce(MPI_IN_PLACE, values, (PetscMPIInt)condition->component_count, MPIU_REAL, MPIU_SUM, model->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ConditionPull(MpmModel model, const MpmColumn *column, const PetscReal weight[],
                                    MpmPointVector *end, PetscReal lam[])
{
  const MpmCondition *condition = &model->scene.bcs->at[column->index];
  const PetscInt      bs        = model->disc.block;

  PetscFunctionBeginUser;
  (void)end;
  for (PetscInt k = 0; k < model->disc.space->owned * bs; k++) {
    if (model->disc.constraints->condition[k] != column->index) continue;
    for (PetscInt c = 0; c < condition->component_count; c++)
      if (condition->component[c] == k % bs) lam[k] -= Sign(model, k % bs) * weight[c];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static const MpmColumnMap condition_map = {ConditionAlong, ConditionPull, PETSC_TRUE};

/* By component, and along the normal of an inclined one. */
static PetscErrorCode AddCondition(MpmModel model, PetscInt b, MpmColumns *columns)
{
  const MpmLayout    *layout    = model->disc.layout;
  const MpmCondition *condition = &model->scene.bcs->at[b];
  const char         *parts[MPM_MAX_BLOCK + 1];
  MpmColumn           row = {.name = "reaction", .unit = "N", .fill = FillCondition, .index = b};

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < condition->component_count; k++) {
    const PetscInt c = condition->component[k];

    parts[row.count++] = layout->component[c].symbol ? layout->component[c].symbol : layout->component[c].name;
  }
  if (condition->inclined) parts[row.count++] = "n";
  row.parts = parts;
  if (!row.count) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmColumnsAdd(columns, model->scene.bcs->names[b], &row));
  if (!condition->inclined) MpmColumnsSetMap(columns, &condition_map);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode FillMotion(MpmModel model, const MpmColumn *column, PetscReal values[])
{
  const MpmBodyMotion *motion = &model->scene.motions->at[column->index];
  const PetscReal     *reaction =
    &model->disc.nodal.reaction[(model->scene.bcs->count + column->index) * model->disc.block];

  PetscFunctionBeginUser;
  for (PetscInt c = 0; c < motion->component_count; c++) values[c] = reaction[motion->component[c]];
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode AddMotion(MpmModel model, PetscInt m, MpmColumns *columns)
{
  const MpmBodyMotion *motion = &model->scene.motions->at[m];
  const char          *parts[MPM_MAX_BLOCK];
  const MpmColumn      row = {
         .name  = "reaction",
         .unit  = "N",
         .count = motion->component_count,
         .parts = parts,
         .fill  = FillMotion,
         .index = m,
  };

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < motion->component_count; k++) parts[k] = MpmAxisParts[motion->component[k]];
  if (row.count) PetscCall(MpmColumnsAdd(columns, model->scene.motions->names[m], &row));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- boundaries ---- */

static PetscErrorCode FillBoundary(MpmModel model, const MpmColumn *column, PetscReal values[])
{
  PetscFunctionBeginUser;
  PetscCall(PetscArraycpy(values, model->disc.context.contacts->reaction[column->index], model->disc.dim));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode FillDepth(MpmModel model, const MpmColumn *column, PetscReal values[])
{
  PetscFunctionBeginUser;
  values[0] = model->disc.context.contacts->depth[column->index];
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode FillPressure(MpmModel model, const MpmColumn *column, PetscReal values[])
{
  PetscFunctionBeginUser;
  values[0] = model->disc.context.contacts->face[column->index].pressure;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode FillRunup(MpmModel model, const MpmColumn *column, PetscReal values[])
{
  PetscFunctionBeginUser;
  values[0] = model->disc.context.contacts->face[column->index].high;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode FillMoment(MpmModel model, const MpmColumn *column, PetscReal values[])
{
  const PetscInt count = MpmRotationCount(model->disc.dim);

  PetscFunctionBeginUser;
  PetscCall(PetscArraycpy(values, &model->disc.context.contacts->moment[column->index][3 - count], count));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode FillPosition(MpmModel model, const MpmColumn *column, PetscReal values[])
{
  PetscReal place[2 * MPM_MAX_DIM];

  PetscFunctionBeginUser;
  (void)MpmRigidReport(model->disc.context.contacts, column->index, place);
  PetscCall(PetscArraycpy(values, place, model->disc.dim));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode FillRotation(MpmModel model, const MpmColumn *column, PetscReal values[])
{
  PetscReal place[2 * MPM_MAX_DIM];

  PetscFunctionBeginUser;
  (void)MpmRigidReport(model->disc.context.contacts, column->index, place);
  PetscCall(PetscArraycpy(values, &place[model->disc.dim], MpmRotationCount(model->disc.dim)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode AddBoundary(MpmModel model, PetscInt b, MpmColumns *columns)
{
  const PetscInt           dim = model->disc.dim, turning = MpmRotationCount(dim);
  const char *const *const turns  = &MpmAxisParts[MPM_MAX_DIM - turning];
  const MpmColumn          rows[] = {
             {"reaction", "N", dim, MpmAxisParts, FillBoundary, NULL, b},
             {"depth", "m", 0, NULL, FillDepth, NULL, b},
             {"moment", "N m", turning, turns, FillMoment, NULL, b},
             {"position", "m", dim, MpmAxisParts, FillPosition, NULL, b},
             {"rotation", "degrees", turning, turns, FillRotation, NULL, b},
  };
  const MpmColumn faces[] = {{"pressure_max", "Pa", 0, NULL, FillPressure, NULL, b},
                             {"runup", "m", 0, NULL, FillRunup, NULL, b}};
  const size_t    count   = PETSC_STATIC_ARRAY_LENGTH(rows) - (model->scene.boundaries->at[b].freedom ? 0 : 2);

  PetscFunctionBeginUser;
  for (size_t k = 0; k < count; k++) PetscCall(MpmColumnsAdd(columns, model->scene.boundaries->names[b], &rows[k]));
  for (size_t k = 0; model->scene.boundaries->at[b].fields.face && k < PETSC_STATIC_ARRAY_LENGTH(faces); k++)
    PetscCall(MpmColumnsAdd(columns, model->scene.boundaries->names[b], &faces[k]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- pairs of bodies ---- */

static PetscErrorCode FillPair(MpmModel model, const MpmColumn *column, PetscReal values[])
{
  PetscFunctionBeginUser;
  PetscCall(PetscArraycpy(values, model->disc.context.pairs->force[column->index], model->disc.dim));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmReactionsAddColumns(MpmModel model, MpmColumns *columns)
{
  const PetscInt dim = model->disc.dim;

  PetscFunctionBeginUser;
  for (PetscInt b = 0; b < model->scene.bcs->count; b++) PetscCall(AddCondition(model, b, columns));
  for (PetscInt m = 0; m < model->scene.motions->count; m++) PetscCall(AddMotion(model, m, columns));
  for (PetscInt b = 0; b < model->scene.boundaries->count; b++) PetscCall(AddBoundary(model, b, columns));
  for (PetscInt p = 0; p < model->scene.pairs->count; p++) {
    const MpmColumn row = {"force", "N", dim, MpmAxisParts, FillPair, NULL, p};

    PetscCall(MpmColumnsAdd(columns, model->scene.pairs->names[p], &row));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- dams ---- */

static PetscErrorCode FillDam(MpmModel model, const MpmColumn *column, PetscReal values[])
{
  PetscFunctionBeginUser;
  PetscCall(PetscArraycpy(values, model->disc.context.bed->on_bed.dams[column->index], 3));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmDamsAddColumns(MpmModel model, MpmColumns *columns)
{
  const MpmBed *bed = model->scene.deformation.bed;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; bed && k < bed->dams.count; k++) {
    const MpmColumn row = {"force", "N", 3, MpmAxisParts, FillDam, NULL, k};

    PetscCall(MpmColumnsAdd(columns, bed->dams.name[k], &row));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- surfaces ---- */

static PetscErrorCode FillOutflow(MpmModel model, const MpmColumn *column, PetscReal values[])
{
  PetscFunctionBeginUser;
  values[0] = model->state.acting.loads[model->scene.loads->count + column->index].outflow;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmOutflowAddColumns(MpmModel model, MpmColumns *columns)
{
  PetscFunctionBeginUser;
  for (PetscInt s = 0; s < model->scene.surfaces->count && MpmPressureComponent(model->disc.layout) >= 0; s++) {
    const MpmColumn row = {.name = "outflow", .unit = "m3", .fill = FillOutflow, .index = s};

    PetscCall(MpmColumnsAdd(columns, model->scene.surfaces->names[s], &row));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

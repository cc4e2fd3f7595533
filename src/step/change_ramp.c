/*
  A change of material by a ramp.

    stage_weaken: {materials: "layer:weak", change: "0:0,1:1", time: {end: 1, step: 0.1}}

  A point has its new law and mass m from the stage's beginning on (change_material.c). The part s of its stress that
  these do not bear, since the stress is outside the new yield surface, and the part d of its mass by which it was
  heavier stay as loads that fade: at the factor r

    f = (1 - r) (d m g N - V s grad N)

  with the weights of the points as they stand, so that forces are in balance as they were at r = 0. Shorter steps are
  thus smaller changes.

  Without the option the ramp is 0:0,1:1, or to the end of a shorter stage. Geostatic stages, and those with inertia,
  change at once. Stress in the output is the law's.

  Order of calls: Note() for each point as its material changes; Add() as a step's loads are made.
*/
#include "geometry/geometry.h"
#include "particles/particles.h"
#include "loads/load.h"
#include "query/model.h"
#include "step/change_ramp.h"

const char *const MpmChangeFields[MPM_CHANGE_FIELDS] = {"change_mass", "change_xx", "change_yy", "change_xy",
                                                        "change_zz",   "change_yz", "change_xz"};

/* Where the fields behind the first stand in a point's stress. */
static const PetscInt component[MPM_CHANGE_FIELDS - 1] = {0, 1, 3, 2, 4, 5};

PetscInt MpmChangeFieldCount(const MpmModel model)
{
  const PetscInt dim = model->disc.dim;

  for (PetscInt k = 0; k < model->scene.stages.count; k++)
    if (model->scene.stages.at[k].change)
      return 1 + dim * (dim + 1) / 2 + (model->scene.deformation.kinematics == MPM_AXISYMMETRY ? 1 : 0);
  return 0;
}

PetscErrorCode MpmChangeGet(MpmModel model, PetscReal *field[])
{
  PetscFunctionBeginUser;
  for (PetscInt f = 0; f < MpmChangeFieldCount(model); f++)
    PetscCall(MpmParticlesGetField(model->state.particles, MpmChangeFields[f], &field[f]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmChangeRestore(MpmModel model, PetscReal *field[])
{
  PetscFunctionBeginUser;
  for (PetscInt f = 0; f < MpmChangeFieldCount(model); f++)
    PetscCall(MpmParticlesRestoreField(model->state.particles, &field[f]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MpmChangeNote(const MpmModel model, PetscReal *const field[], PetscInt p, PetscReal mass, const PetscReal stress[])
{
  const PetscInt count = MpmChangeFieldCount(model);

  for (PetscInt f = 0; f < count; f++) field[f][p] = f ? stress[component[f - 1]] : mass;
}

PetscErrorCode MpmChangeAdd(MpmModel model, PetscReal time, PetscReal force[])
{
  const MpmStage *stage = &model->scene.stages.at[model->state.stage];
  PetscReal       left, *field[MPM_CHANGE_FIELDS];

  PetscFunctionBeginUser;
  if (!stage->change) PetscFunctionReturn(PETSC_SUCCESS);
  left = 1. - MpmRampEvaluate(stage->change, time - model->state.period.start);
  if (!(left > 0.)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmChangeGet(model, field));
  PetscCall(MpmLoadApplyPoints(model->disc.sum, left, field[0], (const PetscReal *const *)&field[1], force));
  PetscCall(MpmChangeRestore(model, field));
  PetscFunctionReturn(PETSC_SUCCESS);
}

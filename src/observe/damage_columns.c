/*
  Columns of the history of physics with damage: energy that fracture has dissipated, and the largest damage of a point.
*/
#include "base/columns.h"
#include "point/layout.h"
#include "point/material.h"
#include "particles/particles.h"
#include "particles/points.h"
#include "observe/history.h"
#include "query/model.h"

#include <string.h>

/* Place of `fracture_energy` among the physics' own states, or -1. */
static PetscInt FindState(const MpmModel model)
{
  const MpmStateVariable *states = model->scene.physics.states;
  PetscInt                place  = 0;

  for (int s = 0; s < model->scene.physics.state_count; s++) {
    if (!strcmp(states[s].name, "fracture_energy")) return place;
    place += MpmStateComponents(&states[s], model->disc.dim);
  }
  return -1;
}

static PetscErrorCode FillDamage(MpmModel model, const MpmColumn *column, PetscReal values[])
{
  const MpmLayout *layout = model->disc.layout;
  const PetscInt   place  = FindState(model);
  PetscReal        energy = 0., most = 0.;
  MpmPoints        points;

  (void)column;
  PetscFunctionBeginUser;
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  for (PetscInt p = 0; p < points.count; p++) {
    energy += points.volume0[p] * points.physics.own[p * layout->own.size + place];
    most = PetscMax(most, points.physics.value[p * layout->rate.count]);
  }
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  PetscCall(MPIU_Allreduce(&energy, &values[0], 1, MPIU_REAL, MPIU_SUM, model->comm));
  PetscCall(MPIU_Allreduce(&most, &values[1], 1, MPIU_REAL, MPIU_MAX, model->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmDamageAddColumns(MpmModel model, MpmColumns *columns)
{
  static const char *const parts[] = {"energy_fracture", "damage_max"};
  const MpmColumn          row     = {.unit = "J; of damage -", .count = 2, .parts = parts, .fill = FillDamage};

  PetscFunctionBeginUser;
  if (FindState(model) >= 0) PetscCall(MpmColumnsAdd(columns, NULL, &row));
  PetscFunctionReturn(PETSC_SUCCESS);
}

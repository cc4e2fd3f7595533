/*
  Columns of motion in the history.
*/
#include <stddef.h>
#include "particles/particles.h"
#include "volume/inertia.h"
#include "step/energy.h"
#include "query/model.h"
#include "observe/motion_columns.h"
#include "observe/results.h"
#include "observe/tracks.h"

static const struct {
  const char *name;
  size_t      offset; /* in MpmEnergyReport */
} energies[] = {{"energy_kinetic", offsetof(MpmEnergyReport, kinetic)},
                {"energy_elastic", offsetof(MpmEnergyReport, elastic)},
                {"energy_dissipated", offsetof(MpmEnergyReport, dissipated)},
                {"energy_external", offsetof(MpmEnergyReport, external)},
                {"energy_balance", offsetof(MpmEnergyReport, balance)}};

PetscInt MpmMotionColumnCount(const MpmModel model)
{
  const PetscInt dim = model->disc.dim;

  if (!model->disc.context.inertia->dynamic) return 0;
  return model->results->tracks.count * dim + (PetscInt)PETSC_STATIC_ARRAY_LENGTH(energies) + dim + (dim == 2 ? 1 : 3);
}

static PetscErrorCode Add(const char *head, const char *name, const char *between, PetscInt axis, char **names,
                          PetscInt *count)
{
  char text[512];

  PetscFunctionBeginUser;
  PetscCall(PetscSNPrintf(text, sizeof(text), "%s%s_%s%c", head, name, between, "xyz"[axis]));
  PetscCall(PetscStrallocpy(text, &names[(*count)++]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmMotionAddColumns(MpmModel model, char **names, PetscInt *count)
{
  const PetscInt dim = model->disc.dim;

  PetscFunctionBeginUser;
  if (!model->disc.context.inertia->dynamic) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt k = 0; k < model->results->tracks.count * dim; k++)
    PetscCall(Add("track_", model->results->tracks.names[k / dim], "v", k % dim, names, count));
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(energies); k++)
    PetscCall(PetscStrallocpy(energies[k].name, &names[(*count)++]));
  for (PetscInt a = 0; a < dim; a++) PetscCall(Add("", "momentum", "", a, names, count));
  for (PetscInt a = dim == 2 ? 2 : 0; a < 3; a++) PetscCall(Add("", "angular_momentum", "", a, names, count));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmMotionAddValues(MpmModel model, PetscReal row[], PetscInt *count)
{
  const PetscInt  dim = model->disc.dim;
  MpmEnergyReport report;

  PetscFunctionBeginUser;
  if (!model->disc.context.inertia->dynamic) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt t = 0; t < model->results->tracks.count; t++, *count += dim)
    PetscCall(MpmTrackVelocity(&model->results->tracks.at[t], model->state.particles, &row[*count]));
  PetscCall(MpmEnergyEvaluate(model, &report));
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(energies); k++)
    row[(*count)++] = *(const PetscReal *)((const char *)&report + energies[k].offset);
  for (PetscInt a = 0; a < dim; a++) row[(*count)++] = report.momentum[a];
  for (PetscInt a = dim == 2 ? 2 : 0; a < 3; a++) row[(*count)++] = report.angular[a];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  The level of the water in the ground and above it.

    water: {level: 10, above: dry, ramp: "0:1,86400:0.6"}

  Below the level the pressure starts as that of water at rest. Above it the ground is dry, its pressure held at 0, or it holds
  water by suction. Drained surfaces below the level lie under open water, which presses on them.
*/
#include "options/options.h"
#include "geometry/geometry.h"
#include "terms/load.h"
#include "terms/water_table.h"

#define SLACK 1e-6 /* of gravity, and of the grid's height */

/* Gravity must act along one axis. */
static PetscErrorCode FindVertical(const MpmLoads *loads, PetscInt dim, MpmWaterTable *table, PetscReal *gravity)
{
  PetscReal sum[MPM_MAX_DIM] = {0., 0., 0.};

  PetscFunctionBeginUser;
  for (PetscInt l = 0; l < loads->count; l++)
    for (PetscInt a = 0; loads->at[l].type == MPM_LOAD_GRAVITY && a < dim; a++) sum[a] += loads->at[l].value[a];
  MpmLoadsGetVertical(loads, dim, &table->axis, &table->up);
  *gravity = PetscAbsReal(sum[table->axis]);
  MpmCheckInput(*gravity > 0., "-mpm_water_level: needs a load of type gravity, along an axis");
  for (PetscInt a = 0; a < dim; a++)
    MpmCheckInput(a == table->axis || PetscAbsReal(sum[a]) <= SLACK * *gravity,
                  "-mpm_water_level: needs gravity along an axis");
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmWaterTableCreate(const MpmOptions *options, PetscInt dim, const PetscReal bounds[2 * MPM_MAX_DIM],
                                   const MpmLoads *loads, MpmWaterTable *table)
{
  static const char *const above[] = {"dry", "suction", NULL};
  const MpmOptions         block   = {options->comm, "mpm_water_", options->record};
  PetscReal                least, most, gravity, ends[2];
  PetscInt                 word = 0;
  char                     text[2][MPM_NUMBER_TEXT];

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsReal(&block, "level", "m",
                           "height of the water's level, up gravity's axis: the pressure starts hydrostatic below it",
                           MPM_RANGE_ANY, MPM_OPTIONAL, &table->level, &table->there));
  if (!table->there && !MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmOptionsWord(&block, "above",
                           "the ground above the level is dry, its pressure held at 0, or holds water by suction",
                           above, MPM_OPTIONAL, &word, NULL));
  table->suction = (PetscBool)(word == 1);
  PetscCall(MpmRampCreate(&block, "ramp", "0:1", &table->ramp));
  if (MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(FindVertical(loads, dim, table, &gravity));
  table->weight *= gravity;
  MpmRampBounds(table->ramp, &least, &most);
  ends[0] = table->up > 0 ? bounds[table->axis] : -bounds[MPM_MAX_DIM + table->axis];
  ends[1] = table->up > 0 ? bounds[MPM_MAX_DIM + table->axis] : -bounds[table->axis];
  for (PetscInt k = 0; k < 2; k++) {
    const PetscReal level = table->level * (k ? most : least), slack = SLACK * (ends[1] - ends[0]);

    MpmRealText(ends[0], text[0]);
    MpmRealText(ends[1], text[1]);
    MpmCheckInput(level >= ends[0] - slack && level <= ends[1] + slack,
                  "-mpm_water_level %g: the level, with its ramp, must be in the grid, from %s to %s m up axis %c",
                  (double)table->level, text[0], text[1], "xyz"[table->axis]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmWaterTableDestroy(MpmWaterTable *table)
{
  PetscFunctionBeginUser;
  if (table) PetscCall(MpmRampDestroy(&table->ramp));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscReal MpmWaterTableDepth(const MpmWaterTable *table, PetscReal time, const PetscReal x[])
{
  return table->level * MpmRampEvaluate(table->ramp, time) - (PetscReal)table->up * x[table->axis];
}

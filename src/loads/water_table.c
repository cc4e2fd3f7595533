/*
  The level of the water in the ground and above it.

    water: {level: 10, above: dry, ramp: "0:1,86400:0.6"}
    water: {table: "0,6,20,8,40,5", table_ramp: "0:1", above: dry}

  A table is a line through points, of which place and height are given, level beyond its ends.

  Below the level the pressure starts as that of water at rest. Above it the ground is dry, with a prescribed pressure
  of 0, or has water by suction. Drained surfaces below the level lie under open water, which presses on them.
*/
#include "options/options.h"
#include "geometry/geometry.h"
#include "loads/load.h"
#include "loads/water_table.h"

#define SLACK 1e-6 /* of gravity, and of the grid's height */

/* Reads level or table, above and ramp; the grid's lower and upper bounds are those of its range. `weight` is the
   density. */
static PetscErrorCode FindVertical(const MpmLoads *loads, PetscInt dim, MpmWaterTable *table, PetscReal *gravity)
{
  PetscReal sum[MPM_MAX_DIM] = {0., 0., 0.};

  PetscFunctionBeginUser;
  for (PetscInt l = 0; l < loads->count; l++)
    for (PetscInt a = 0; loads->at[l].type == MPM_LOAD_GRAVITY && a < dim; a++) sum[a] += loads->at[l].value[a];
  MpmLoadsGetVertical(loads, dim, &table->axis, &table->up);
  *gravity = PetscAbsReal(sum[table->axis]);
  MpmCheckInput(*gravity > 0., "-mpm_water_%s: needs a load of type gravity, along an axis",
                table->count ? "table" : "level");
  for (PetscInt a = 0; a < dim; a++)
    MpmCheckInput(a == table->axis || PetscAbsReal(sum[a]) <= SLACK * *gravity,
                  "-mpm_water_%s: needs gravity along an axis", table->count ? "table" : "level");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The pairs of a table, in place of a level. */
static PetscErrorCode ReadLine(const MpmOptions *block, PetscBool *given, MpmWaterTable *table)
{
  PetscInt count;

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsHas(block, "table", given));
  PetscCall(MpmOptionsRealList(
    block, "table", "m", "line in place of the level: pairs of place, along the first horizontal axis, and height",
    MPM_OPTIONAL, &count, &table->line));
  if (MpmOptionsHelp() || !*given) PetscFunctionReturn(PETSC_SUCCESS);
  MpmCheckInput(!table->there, "-mpm_water_table: a level is given, too, must be one of them");
  MpmCheckInput(count >= 2 && count % 2 == 0, "-mpm_water_table: %d numbers; must be pairs of place and height",
                (int)count);
  table->count = count / 2;
  table->there = PETSC_TRUE;
  for (PetscInt k = 1; k < table->count; k++) {
    char text[2][MPM_NUMBER_TEXT];

    MpmRealText(table->line[2 * k], text[0]);
    MpmRealText(table->line[2 * k - 2], text[1]);
    MpmCheckInput(table->line[2 * k] > table->line[2 * k - 2],
                  "-mpm_water_table: place %s follows %s; places must increase", text[0], text[1]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmWaterTableCreate(const MpmOptions *options, PetscInt dim, const PetscReal bounds[2 * MPM_MAX_DIM],
                                   const MpmLoads *loads, MpmWaterTable *table)
{
  static const char *const above[] = {"dry", "suction", NULL};
  const MpmOptions         block   = {options->comm, "mpm_water_", options->record};
  PetscReal                least, most, gravity, ends[2], reach[2];
  PetscBool                line;
  PetscInt                 word = 0;
  char                     text[3][MPM_NUMBER_TEXT];

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsReal(&block, "level", "m",
                           "height of the water's level, up gravity's axis: the pressure starts hydrostatic below it",
                           MPM_RANGE_ANY, MPM_OPTIONAL, &table->level, &table->there));
  PetscCall(ReadLine(&block, &line, table));
  if (!table->there && !MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmOptionsWord(&block, "above",
                           "the ground above the level is dry, its pressure held at 0, or holds water by suction",
                           above, MPM_OPTIONAL, &word, NULL));
  table->suction = (PetscBool)(word == 1);
  if (!line || MpmOptionsHelp()) PetscCall(MpmRampCreate(&block, "ramp", "0:1", &table->ramp));
  if (MpmOptionsHelp()) PetscCall(MpmRampDestroy(&table->ramp));
  if (line || MpmOptionsHelp()) PetscCall(MpmRampCreate(&block, "table_ramp", "0:1", &table->ramp));
  if (MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(FindVertical(loads, dim, table, &gravity));
  table->weight *= gravity;
  table->along = table->axis ? 0 : 1;
  reach[0] = reach[1] = table->count ? table->line[1] : table->level;
  for (PetscInt k = 0; k < table->count; k++) {
    reach[0] = PetscMin(reach[0], table->line[2 * k + 1]);
    reach[1] = PetscMax(reach[1], table->line[2 * k + 1]);
  }
  MpmRampBounds(table->ramp, &least, &most);
  ends[0] = table->up > 0 ? bounds[table->axis] : -bounds[MPM_MAX_DIM + table->axis];
  ends[1] = table->up > 0 ? bounds[MPM_MAX_DIM + table->axis] : -bounds[table->axis];
  for (PetscInt k = 0; k < 4; k++) {
    const PetscReal level = reach[k % 2] * (k / 2 ? most : least), slack = SLACK * (ends[1] - ends[0]);

    MpmRealText(ends[0], text[0]);
    MpmRealText(ends[1], text[1]);
    MpmRealText(reach[k % 2], text[2]);
    MpmCheckInput(level >= ends[0] - slack && level <= ends[1] + slack,
                  "-mpm_water_%s %s: the level, with its ramp, must be in the grid, from %s to %s m up axis %c",
                  line ? "table" : "level", text[2], text[0], text[1], "xyz"[table->axis]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmWaterTableDestroy(MpmWaterTable *table)
{
  PetscFunctionBeginUser;
  if (!table) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmRampDestroy(&table->ramp));
  PetscCall(PetscFree(table->line));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The height of the level or table at a place, without its ramp. */
static PetscReal Height(const MpmWaterTable *table, const PetscReal x[])
{
  const PetscReal at = x[table->along], *line = table->line;
  PetscInt        k = 0;

  if (!table->count) return table->level;
  while (k < table->count && line[2 * k] <= at) k++;
  if (k == 0 || k == table->count) return line[2 * PetscMax(k - 1, 0) + 1];
  return line[2 * k - 1] +
         (at - line[2 * k - 2]) / (line[2 * k] - line[2 * k - 2]) * (line[2 * k + 1] - line[2 * k - 1]);
}

PetscReal MpmWaterTableDepth(const MpmWaterTable *table, PetscReal time, const PetscReal x[])
{
  return Height(table, x) * MpmRampEvaluate(table->ramp, time) - (PetscReal)table->up * x[table->axis];
}

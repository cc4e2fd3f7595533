/*
  Options of forests.
*/
#include "talus/point/tables.h"
#include "geometry/geometry.h"
#include "options/options.h"
#include "point/basal_map.h"
#include "terrain/forest.h"

#define DRAG 1.2 /* of a cylinder in turbulent flow */

typedef struct {
  MpmRegion region;
  PetscReal stems, diameter, drag; /* 1/m2, m, - */
  MpmMap    map;                   /* of stems; without pixels: a number */
} Forest;

static PetscErrorCode ReadStems(const MpmOptions *block, Forest *forest)
{
  static const MpmParameter stems = {
    MPM_NUMBER, "stems", "1/m2", 0., 1, 0., HUGE_VAL, 0, "number of stems on a square metre, or a map of it",
    NULL,       0.05,    NULL};
  PetscBool is;

  PetscFunctionBeginUser;
  PetscCall(MpmBasalMapRead(block, &stems, &forest->map, &is));
  if (!is)
    PetscCall(MpmOptionsReal(block, stems.name, stems.unit, stems.help, MPM_RANGE_NON_NEGATIVE, MPM_REQUIRED,
                             &forest->stems, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadForest(const MpmOptions *options, const char name[], const MpmGrid *grid, Forest *forest)
{
  const PetscReal  tolerance[MPM_MAX_DIM] = {1e-6 * grid->h[0], 1e-6 * grid->h[1], 1.};
  char             prefix[256];
  const MpmOptions block = {options->comm, prefix, options->record};

  PetscFunctionBeginUser;
  *forest = (Forest){.drag = DRAG};
  PetscCall(PetscSNPrintf(prefix, sizeof(prefix), "mpm_forest_%s_", name));
  PetscCall(MpmOptionsHeading(&block, "Forest (-mpm_physics depth_averaged)"));
  PetscCall(MpmRegionCreate(&block, 2, tolerance, &forest->region));
  MpmCheckInput(MpmRegionGetType(forest->region) < MPM_REGION_RASTER || MpmOptionsHelp(),
                "-%sregion: must be a region of places, for bodies alone are raster, file, columns, depth, hydrograph",
                prefix);
  PetscCall(ReadStems(&block, forest));
  PetscCall(
    MpmOptionsReal(&block, "diameter", "m", "of a stem", MPM_RANGE_POSITIVE, MPM_REQUIRED, &forest->diameter, NULL));
  PetscCall(MpmOptionsReal(&block, "drag", "-", "coefficient of drag", MPM_RANGE_NON_NEGATIVE, MPM_OPTIONAL,
                           &forest->drag, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void Plant(const Forest *forest, const MpmGrid *grid, PetscReal drag[])
{
  for (PetscInt j = 0; j < grid->nodes[1]; j++) {
    for (PetscInt i = 0; i < grid->nodes[0]; i++) {
      const PetscInt node[MPM_MAX_DIM] = {i, j, 0};
      PetscReal      x[MPM_MAX_DIM]    = {0.};

      MpmGridNodeAtStart(grid, node, x);
      if (!MpmRegionContains(forest->region, x)) continue;
      drag[(PetscInt64)j * grid->nodes[0] + i] +=
        0.5 * forest->drag * forest->diameter * (forest->map.value ? MpmMapAt(&forest->map, x) : forest->stems);
    }
  }
}

PetscErrorCode MpmForestsRead(const MpmOptions *options, const MpmGrid *grid, PetscReal **drag)
{
  PetscInt count;
  char   **names;

  PetscFunctionBeginUser;
  *drag = NULL;
  PetscCall(MpmOptionsBlocks(options, "forests", "names of forests, which resist flow over terrain", MPM_OPTIONAL,
                             &count, &names));
  if (count && !MpmOptionsHelp()) PetscCall(PetscCalloc1((size_t)grid->nodes[0] * (size_t)grid->nodes[1], drag));
  for (PetscInt k = 0; k < count; k++) {
    Forest forest;

    PetscCall(ReadForest(options, names[k], grid, &forest));
    if (*drag) Plant(&forest, grid, *drag);
    PetscCall(MpmMapDestroy(&forest.map));
    PetscCall(MpmRegionDestroy(&forest.region));
  }
  PetscCall(MpmNamesDestroy(count, &names));
  PetscFunctionReturn(PETSC_SUCCESS);
}

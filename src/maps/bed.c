/*
  The bed of a flow over terrain.
*/
#include "options/options.h"
#include "maps/bed.h"
#include "maps/map_fill.h"
#include "maps/map_noise.h"
#include "maps/map_smooth.h"
#include "maps/raise.h"

#define SLACK 1e-9 /* of a pixel: places so far beyond the outer centres are on them */

/* Fails where the map does not cover a rectangle. */
static PetscErrorCode Cover(const MpmBed *bed, const PetscReal lower[], const PetscReal upper[])
{
  const MpmMap   *map     = &bed->map;
  const PetscReal first[] = {map->x0, map->y0};
  const PetscInt  count[] = {map->columns, map->rows};

  PetscFunctionBeginUser;
  for (PetscInt a = 0; a < 2; a++) {
    const PetscReal last = first[a] + (PetscReal)(count[a] - 1) * map->cell[a], slack = SLACK * map->cell[a];

    MpmCheckInput(
      lower[a] >= first[a] - slack && upper[a] <= last + slack,
      "-mpm_terrain_file %s: covers %.10g to %.10g on axis %c between the centres of its pixels, the grid goes from "
      "%.10g to %.10g",
      bed->file, (double)first[a], (double)last, "xy"[a], (double)lower[a], (double)upper[a]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The map's file, and how it is read. */
static PetscErrorCode ReadFile(const MpmOptions *terrain, MpmMapAsk *ask, MpmBed *bed)
{
  PetscFunctionBeginUser;
  PetscCall(MpmOptionsPath(terrain, "file",
                           "map of the bed's height, m: an ESRI ASCII grid, or a GeoTIFF or other file that GDAL reads",
                           MPM_OPTIONAL, &bed->file));
  if (!bed->file && !MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmOptionsInt(terrain, "band", "band of the file", 1, 65535, MPM_OPTIONAL, &ask->band, NULL));
  PetscCall(MpmOptionsText(terrain, "project",
                           "coordinate system in metres to which maps and outlines are brought, as EPSG:32632", NULL,
                           MPM_OPTIONAL, &bed->project));
  ask->project = bed->project;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmBedExtent(const MpmOptions *options, PetscReal lower[2], PetscReal upper[2])
{
  const MpmOptions terrain                  = {options->comm, "mpm_terrain_", options->record};
  MpmMapAsk        ask                      = {.band = 1, .frame = PETSC_TRUE};
  MpmBed           bed                      = {.file = NULL};
  char             message[MPM_MAP_MESSAGE] = "";

  PetscFunctionBeginUser;
  PetscCall(ReadFile(&terrain, &ask, &bed));
  MpmCheckInput(bed.file, "-mpm_grid_terrain: -mpm_terrain_file is missing");
  PetscCall(MpmMapRead(bed.file, &ask, &bed.map, message));
  MpmCheckInput(!message[0], "-mpm_terrain_file %s: %s", bed.file, message);
  lower[0] = bed.map.x0;
  lower[1] = bed.map.y0;
  upper[0] = bed.map.x0 + (PetscReal)(bed.map.columns - 1) * bed.map.cell[0];
  upper[1] = bed.map.y0 + (PetscReal)(bed.map.rows - 1) * bed.map.cell[1];
  PetscCall(MpmBedDestroy(&bed));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The pixels about the grid. */
static PetscErrorCode ReadMap(const MpmOptions *terrain, const PetscReal lower[], const PetscReal upper[],
                              MpmMapAsk *ask, MpmBed *bed)
{
  PetscReal   smooth                   = 0.;
  char        message[MPM_MAP_MESSAGE] = "";
  MpmMapNoise noise                    = {0};

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsReal(terrain, "smooth", "pixels",
                           "standard deviation of the Gaussian by which heights are averaged",
                           ((MpmRange){0., 1000., PETSC_FALSE}), MPM_OPTIONAL, &smooth, NULL));
  PetscCall(MpmMapNoiseRead(terrain, &noise));
  PetscCall(MpmOptionsBool(terrain, "outflow",
                           "material that comes where the map has no data is gone; otherwise it ends the run",
                           &bed->outflow, NULL));
  if (MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  ask->lower  = lower;
  ask->upper  = upper;
  ask->margin = 1 + MpmMapSmoothReach(smooth);
  PetscCall(MpmMapRead(bed->file, ask, &bed->map, message));
  MpmCheckInput(!message[0], "-mpm_terrain_file %s: %s", bed->file, message);
  PetscCall(MpmMapSmooth(smooth, &bed->map));
  PetscCall(MpmMapNoiseAdd(&noise, &bed->map));
  PetscCall(Cover(bed, lower, upper));
  PetscCall(MpmMapFill(&bed->map, &bed->missing));
  MpmCheckInput(!PetscIsNanReal(bed->map.value[0]), "-mpm_terrain_file %s: has no data in the grid", bed->file);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmBedRead(const MpmOptions *options, const PetscReal lower[], const PetscReal upper[], MpmBed *bed)
{
  static const char *const slopes[]     = {"normal", "vertical", NULL};
  static const char *const curvatures[] = {"none", "path", "pressure", NULL};
  const MpmOptions         terrain      = {options->comm, "mpm_terrain_", options->record};
  MpmMapAsk                ask          = {.band = 1};
  PetscInt                 slope = 0, curvature = 0;
  PetscBool                given;

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsHeading(options, "Terrain (-mpm_physics depth_averaged)"));
  PetscCall(ReadFile(&terrain, &ask, bed));
  PetscCall(MpmOptionsReals(options, "bed", "m, m/m",
                            "without a map the bed is a plane: height at the origin, and its "
                            "slopes along x and y",
                            MPM_RANGE_ANY, MPM_OPTIONAL, 3, bed->plane, &given));
  PetscCall(MpmOptionsWord(options, "slope",
                           "normal: depth and pressure normal to the bed, lengths along it; vertical: shallow water",
                           slopes, MPM_OPTIONAL, &slope, NULL));
  bed->normal = (PetscBool)!slope;
  PetscCall(MpmOptionsWord(options, "curvature",
                           "of the path over the bed, with slope normal: path keeps the speed along the bed where the "
                           "bed bends; pressure has its part of the pressure and of friction, too",
                           curvatures, MPM_OPTIONAL, &curvature, NULL));
  bed->curvature = (MpmBedCurvature)curvature;
  PetscCall(MpmOptionsReal(&terrain, "viscosity", "-",
                           "factor of the friction of columns with the flow about them, as the subgridMixingFactor of "
                           "com1DFA, 100 there",
                           MPM_RANGE_NON_NEGATIVE, MPM_OPTIONAL, &bed->viscosity, NULL));
  MpmCheckInput(bed->normal || !curvature || MpmOptionsHelp(), "-mpm_curvature %s: is an option of -mpm_slope normal",
                curvatures[curvature]);
  MpmCheckInput(!given || !bed->file || MpmOptionsHelp(), "-mpm_bed: -mpm_terrain_file has the bed");
  if (bed->file || MpmOptionsHelp()) {
    PetscCall(ReadMap(&terrain, lower, upper, &ask, bed));
    PetscCall(MpmBedRaise(options, bed));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmBedDestroy(MpmBed *bed)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(bed->file));
  PetscCall(PetscFree(bed->project));
  PetscCall(PetscFree(bed->missing));
  PetscCall(MpmBedDamsDestroy(&bed->dams));
  PetscCall(MpmMapDestroy(&bed->map));
  PetscCall(MpmMapDestroy(&bed->change));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscBool MpmBedIsMissing(const MpmBed *bed, const PetscReal x[])
{
  const MpmMap   *map = &bed->map;
  const PetscReal u = (x[0] - map->x0) / map->cell[0] + 0.5, v = (x[1] - map->y0) / map->cell[1] + 0.5;

  if (!bed->missing) return PETSC_FALSE;
  return (PetscBool)bed->missing[(PetscInt64)PetscClipInterval(v, 0., (PetscReal)(map->rows - 1)) * map->columns +
                                 (PetscInt64)PetscClipInterval(u, 0., (PetscReal)(map->columns - 1))];
}

void MpmBedPatchAt(const MpmBed *bed, const PetscReal x[], MpmBedPatch *patch)
{
  for (PetscInt a = 0; a < 2; a++) patch->at[a] = x[a];
  if (bed->map.value) {
    MpmMapPatch(&bed->map, x, &patch->z, patch->slope, &patch->twist);
    return;
  }
  patch->z = MpmBedHeight(bed, x);
  for (PetscInt a = 0; a < 2; a++) patch->slope[a] = bed->plane[1 + a];
  patch->twist = 0.;
}

PetscReal MpmBedHeight(const MpmBed *bed, const PetscReal x[])
{
  const PetscReal change = bed->change.value ? MpmMapAt(&bed->change, x) : 0.;

  if (bed->map.value) return MpmMapAt(&bed->map, x) + change;
  return bed->plane[0] + bed->plane[1] * x[0] + bed->plane[2] * x[1] + change;
}

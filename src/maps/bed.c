/*
  The bed of a flow over terrain.
*/
#include "options/options.h"
#include "maps/bed.h"

#define SLACK 1e-9 /* of a pixel: places so far beyond the outer centres are on them */

PetscErrorCode MpmBedRead(const MpmOptions *options, MpmBed *bed)
{
  static const char *const slopes[] = {"normal", "vertical", NULL};
  const MpmOptions         terrain  = {options->comm, "mpm_terrain_", options->record};
  PetscInt                 slope    = 0;
  PetscBool                given;
  char                     message[MPM_ASCII_MESSAGE] = "";

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsHeading(options, "Terrain (-mpm_physics depth_averaged)"));
  PetscCall(
    MpmOptionsPath(&terrain, "file", "map of the bed's height, m: an ESRI ASCII grid", MPM_OPTIONAL, &bed->file));
  PetscCall(MpmOptionsReals(options, "bed", "m, m/m",
                            "without a map the bed is a plane: height at the origin, and its "
                            "slopes along x and y",
                            MPM_RANGE_ANY, MPM_OPTIONAL, 3, bed->plane, &given));
  PetscCall(MpmOptionsWord(options, "slope",
                           "normal: depth and pressure normal to the bed, lengths along it; vertical: shallow water",
                           slopes, MPM_OPTIONAL, &slope, NULL));
  bed->normal = (PetscBool)!slope;
  if (!bed->file || MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  MpmCheckInput(!given, "-mpm_bed: -mpm_terrain_file has the bed");
  PetscCall(MpmAsciiGridRead(bed->file, &bed->map, message));
  MpmCheckInput(!message[0], "-mpm_terrain_file %s: %s", bed->file, message);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmBedDestroy(MpmBed *bed)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(bed->file));
  PetscCall(MpmAsciiGridDestroy(&bed->map));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The pixel below a coordinate, and the part of the way to the next one. */
static PetscInt Pixel(PetscReal s, PetscInt count, PetscReal *part)
{
  const PetscReal held = PetscClipInterval(s, 0., (PetscReal)(count - 1));
  const PetscInt  k    = count < 2 ? 0 : PetscMin((PetscInt)held, count - 2);

  *part = held - (PetscReal)k;
  return k;
}

/* The four pixels about a place, and their weights. */
static void Around(const MpmAsciiGrid *map, const PetscReal x[], PetscInt64 pixel[4], PetscReal weight[4])
{
  PetscReal      part[2];
  const PetscInt i = Pixel((x[0] - map->x0) / map->cell, map->columns, &part[0]);
  const PetscInt j = Pixel((x[1] - map->y0) / map->cell, map->rows, &part[1]);

  for (PetscInt k = 0; k < 4; k++) {
    const PetscInt a = PetscMin(i + k % 2, map->columns - 1), b = PetscMin(j + k / 2, map->rows - 1);

    pixel[k]  = (PetscInt64)b * map->columns + a;
    weight[k] = (k % 2 ? part[0] : 1. - part[0]) * (k / 2 ? part[1] : 1. - part[1]);
  }
}

PetscReal MpmBedHeight(const MpmBed *bed, const PetscReal x[])
{
  PetscInt64 pixel[4];
  PetscReal  weight[4], height = 0.;

  if (!bed->map.value) return bed->plane[0] + bed->plane[1] * x[0] + bed->plane[2] * x[1];
  Around(&bed->map, x, pixel, weight);
  for (PetscInt k = 0; k < 4; k++) height += weight[k] == 0. ? 0. : weight[k] * bed->map.value[pixel[k]];
  return height;
}

PetscErrorCode MpmBedCover(const MpmBed *bed, const PetscReal lower[], const PetscReal upper[])
{
  const MpmAsciiGrid *map     = &bed->map;
  const PetscReal     first[] = {map->x0, map->y0}, slack = SLACK * map->cell;
  const PetscInt      count[] = {map->columns, map->rows};

  PetscFunctionBeginUser;
  if (!map->value) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt a = 0; a < 2; a++) {
    const PetscReal last = first[a] + (PetscReal)(count[a] - 1) * map->cell;

    MpmCheckInput(
      lower[a] >= first[a] - slack && upper[a] <= last + slack,
      "-mpm_terrain_file %s: covers %g to %g on axis %c between the centres of its pixels, the grid goes from "
      "%g to %g",
      bed->file, (double)first[a], (double)last, "xy"[a], (double)lower[a], (double)upper[a]);
  }
  for (PetscInt64 k = 0; k < (PetscInt64)map->columns * map->rows; k++) {
    const PetscReal x = map->x0 + (PetscReal)(k % map->columns) * map->cell;
    const PetscReal y = map->y0 + (PetscReal)(k / map->columns) * map->cell;

    if (x < lower[0] - map->cell || x > upper[0] + map->cell || y < lower[1] - map->cell || y > upper[1] + map->cell)
      continue;
    MpmCheckInput(map->value[k] != map->none && !PetscIsInfOrNanReal(map->value[k]),
                  "-mpm_terrain_file %s: has no data at (%g, %g), in the grid", bed->file, (double)x, (double)y);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

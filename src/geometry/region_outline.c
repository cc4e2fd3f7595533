/*
  Regions that are the polygons of a file.

    outline   path; polygons in the coordinate system of the terrain's map, if there is one; in 3D prisms along z

  Regions of type raster may have none. In 3D they are ground between maps (maps/map_layer.h) above these polygons.
*/
#include "options/options.h"
#include "geometry/region_impl.h"
#include "maps/map.h"
#include "maps/polygon_part.h"

static PetscErrorCode ReadFile(const MpmOptions *options, const char path[], MpmRegion region)
{
  const MpmPlane *plane = MpmRecordPlane(options->record);
  MpmOutlineAsk   ask   = {0};
  PetscReal       lower[2], upper[2];
  PetscBool       polygon                  = PETSC_FALSE;
  char            message[MPM_MAP_MESSAGE] = "";

  PetscFunctionBegin;
  if (plane) ask = (MpmOutlineAsk){plane->project, plane->system, {plane->origin[0], plane->origin[1]}};
  PetscCall(MpmOutlineRead(path, &ask, &region->outline, message));
  MpmCheckInput(!message[0], "-%soutline %s: %s", options->prefix, path, message);
  for (PetscInt f = 0; f < region->outline.features; f++)
    polygon = (PetscBool)(polygon || region->outline.feature[f].type == MPM_OUTLINE_POLYGON);
  MpmCheckInput(polygon, "-%soutline %s: has no polygon", options->prefix, path);
  MpmOutlineBounds(&region->outline, lower, upper);
  for (PetscInt a = 0; a < 2; a++) {
    region->lower[a] = lower[a] - region->tolerance[a];
    region->upper[a] = upper[a] + region->tolerance[a];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmRegionOutlineRead(const MpmOptions *options, MpmRegion region)
{
  char *path;

  PetscFunctionBegin;
  PetscCall(MpmOptionsPath(options, "outline",
                           "file of polygons: GeoJSON, or a shapefile, GeoPackage and others by GDAL",
                           region->type == MPM_REGION_OUTLINE ? MPM_REQUIRED : MPM_OPTIONAL, &path));
  if (region->type == MPM_REGION_OUTLINE && region->dim == 3) PetscCall(MpmPrismRead(options, region));
  if (path && !MpmOptionsHelp()) PetscCall(ReadFile(options, path, region));
  PetscCall(PetscFree(path));
  if (region->type == MPM_REGION_RASTER && region->dim > 2) {
    const PetscReal *window[2];
    PetscBool        below;

    PetscCall(MpmMapLayerRead(options, &region->ground));
    MpmRecordWindow(options->record, &window[0], &window[1]);
    for (PetscInt a = 0; window[0] && a < 2; a++) {
      region->lower[a] = PetscMax(region->lower[a], window[0][a] - region->tolerance[a]);
      region->upper[a] = PetscMin(region->upper[a], window[1][a] + region->tolerance[a]);
    }
    PetscCall(MpmOptionsHas(options, "below", &below));
    if (!below && !MpmOptionsHelp()) MpmRegionGroundBound(region);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MpmRegionGroundBound(MpmRegion region)
{
  PetscReal lower[MPM_REGION_DIM], upper[MPM_REGION_DIM];

  for (PetscInt a = 0; a < MPM_REGION_DIM; a++) {
    lower[a] = region->lower[a] + region->tolerance[a];
    upper[a] = region->upper[a] - region->tolerance[a];
  }
  MpmMapLayerBound(region->ground, lower, upper);
  for (PetscInt a = 0; a < MPM_REGION_DIM; a++) {
    region->lower[a] = PetscMax(lower[a], region->clip[0][a]) - region->tolerance[a];
    region->upper[a] = PetscMin(upper[a], region->clip[1][a]) + region->tolerance[a];
  }
}

const MpmOutline *MpmRegionOutline(MpmRegion region)
{
  return region->outline.features ? &region->outline : NULL;
}

PetscBool MpmRegionOutlineHolds(MpmRegion region, const PetscReal x[])
{
  if (!region->outline.features || MpmOutlineHolds(&region->outline, -1, x)) return PETSC_TRUE;
  return (PetscBool)(MpmOutlineDistance(&region->outline, x) <= PetscMin(region->tolerance[0], region->tolerance[1]));
}

PetscReal MpmRegionOutlinePart(MpmRegion region, const PetscReal lower[], const PetscReal upper[], PetscReal centroid[])
{
  const MpmMap none  = {0};
  MpmRings     rings = {0}, spare[2] = {{0}};
  MpmPart      part = {.area = 0.};

  for (PetscInt f = 0; f < region->outline.features; f++) {
    if (region->outline.feature[f].type != MPM_OUTLINE_POLYGON) continue;
    if (MpmRingsTake(&region->outline, f, &rings) || MpmPartAdd(&rings, lower, upper, &none, 0., spare, &part))
      return 0.;
  }
  (void)MpmRingsDestroy(&rings);
  for (PetscInt k = 0; k < 2; k++) (void)MpmRingsDestroy(&spare[k]);
  for (PetscInt a = 0; a < 2 && part.area > 0.; a++) centroid[a] = part.moment[a] / part.area;
  return part.area;
}

/*
  Layers of ground, drawn by their interfaces.

    top       line y over x, from left to right: x0,y0,x1,y1,..., level beyond its ends; or one number, a level
    bottom    line at which the layer ends; without it the layer has no lower end
    lower_z, upper_z   ends of a prism along z, in 3D

  A body's block may have `below` in place of `top` (MpmRegionSetAbove): the lower end of the layer above is this one's
  top. Where its bottom lies above its top a layer thins out: the bottom is cut off at the top, and the next layer
  begins there. A surface that cuts into the ground thus leaves each layer what is left of it, and neighbours share
  their interface exactly.
*/
#include "options/options.h"
#include "geometry/region_impl.h"

/* Ends the bottom at the top, and sets the region's bounds. */
static PetscErrorCode Settle(MpmRegion region)
{
  MpmPolyline lower;
  PetscReal   least, most;

  PetscFunctionBegin;
  PetscCall(MpmPolylineLower(&region->layer.top, &region->layer.bottom, &lower));
  PetscCall(MpmPolylineDestroy(&region->layer.bottom));
  region->layer.bottom = lower;
  MpmPolylineBounds(&region->layer.bottom, &least, &most);
  region->lower[1] = PetscMax(least - region->tolerance[1], region->clip[0][1] - region->tolerance[1]);
  MpmPolylineBounds(&region->layer.top, &least, &most);
  region->upper[1] = PetscMin(most + region->tolerance[1], region->clip[1][1] + region->tolerance[1]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmLayerRead(const MpmOptions *options, MpmRegion region)
{
  const char *prefix = options->prefix ? options->prefix : "";
  PetscBool   below;

  PetscFunctionBegin;
  PetscCall(MpmPolylineRead(options, "top",
                            "surface of a layer: x0,y0,x1,y1,... from left to right, level beyond its ends; or a level",
                            &region->layer.top));
  PetscCall(
    MpmPolylineRead(options, "bottom", "lower end of a layer, a line like top; none if absent", &region->layer.bottom));
  if (region->dim == 3) PetscCall(MpmPrismRead(options, region));
  PetscCall(MpmOptionsHas(options, "below", &below));
  MpmCheckInput(region->layer.top.count || below || MpmOptionsHelp(),
                "-%stop: is missing, must be a line x0,y0,x1,y1,... or a level", prefix);
  MpmCheckInput(!region->layer.top.count || !below || MpmOptionsHelp(),
                "-%stop: must be absent with -%sbelow, which gives the top", prefix, prefix);
  if (region->layer.top.count) PetscCall(Settle(region));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmRegionSetAbove(MpmRegion region, MpmRegion above)
{
  const MpmPolyline *line = &above->layer.bottom;

  PetscFunctionBegin;
  if (region->ground) {
    MpmMapLayerSetAbove(region->ground, above->ground);
    MpmRegionGroundBound(region);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(MpmPolylineDestroy(&region->layer.top));
  region->layer.top.count = line->count;
  PetscCall(PetscMalloc1((2 * line->count + 1), &region->layer.top.at));
  PetscCall(PetscArraycpy(region->layer.top.at, line->at, 2 * line->count));
  PetscCall(Settle(region));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscBool MpmRegionIsLayer(MpmRegion region)
{
  return (PetscBool)(region->type == MPM_REGION_LAYERS || region->ground);
}

PetscBool MpmRegionIsBoundedBelow(MpmRegion region)
{
  return (PetscBool)(region->layer.bottom.count > 0 || (region->ground && MpmMapLayerIsBoundedBelow(region->ground)));
}

PetscBool MpmLayerIsThere(MpmRegion region, PetscReal x, PetscInt side)
{
  return (PetscBool)(MpmPolylineHeight(&region->layer.top, x, side) -
                       MpmPolylineHeight(&region->layer.bottom, x, side) >
                     region->tolerance[1]);
}

PetscBool MpmLayerContains(MpmRegion region, const PetscReal x[])
{
  for (PetscInt k = -1; k <= 1; k++) {
    const PetscReal at   = x[0] + (PetscReal)k * region->tolerance[0];
    const PetscInt  side = k < 0 ? -1 : 1;

    if (MpmLayerIsThere(region, at, side) &&
        x[1] <= MpmPolylineHeight(&region->layer.top, at, side) + region->tolerance[1] &&
        x[1] >= MpmPolylineHeight(&region->layer.bottom, at, side) - region->tolerance[1])
      return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

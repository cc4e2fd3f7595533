#pragma once
/*
  Shared by the files of the object: region.c, region_edge.c and layers.c.
*/
#include "geometry/geometry.h"
#include "voxels/voxels.h"
#include "maps/polyline.h"
#include "maps/map_layer.h"
#include "maps/outline.h"

#define MPM_REGION_DIM 3

struct _p_MpmRegion {
  MpmRegionType type;
  PetscInt      dim;
  PetscReal     tolerance[MPM_REGION_DIM];
  PetscReal     lower[MPM_REGION_DIM],
    upper[MPM_REGION_DIM]; /* bounding box of the inside with its tolerance; infinite where the region is */
  PetscReal   clip[2][MPM_REGION_DIM];
  PetscReal   center[MPM_REGION_DIM]; /* sphere; a cylinder's `point` */
  PetscReal   axis[MPM_REGION_DIM];   /* unit vector */
  PetscReal   radius, length;         /* length < 0: endless */
  PetscInt    vertex_count;
  PetscReal  *vertices; /* in units of the tolerance, so that a distance up to 1 is on the edge */
  MpmVoxels  *voxels;   /* of type voxels */
  MpmOutline  outline;  /* of type outline, and raster where it has a file */
  MpmMapLayer ground;   /* of type raster in 3D; NULL: of another type */
  struct {
    MpmPolyline top, bottom; /* of a layer; the bottom is nowhere above the top */
  } layer;
};

/* Layers (layers.c). */
PetscErrorCode MpmLayerRead(const MpmOptions *options, MpmRegion region);
PetscBool      MpmLayerContains(MpmRegion region, const PetscReal x[]);
/* True where the layer has a thickness at x; side as in MpmPolylineHeight(). */
PetscBool MpmLayerIsThere(MpmRegion region, PetscReal x, PetscInt side);
/* A region of type outline or raster (region_outline.c): reading, and places within the tolerance. */
PetscErrorCode MpmRegionOutlineRead(const MpmOptions *options, MpmRegion region);
PetscBool      MpmRegionOutlineHolds(MpmRegion region, const PetscReal x[]);
/* Area of its polygons in a rectangle, and its centroid. */
PetscReal MpmRegionOutlinePart(MpmRegion region, const PetscReal lower[], const PetscReal upper[],
                               PetscReal centroid[]);
/* Cuts the bounds of a region of ground to those of its maps. */
void MpmRegionGroundBound(MpmRegion region);
/* From a prism's lower_z to upper_z. */
PetscErrorCode MpmPrismRead(const MpmOptions *options, MpmRegion region);

static inline PetscReal MpmTriangleCross(const PetscReal a[2], const PetscReal b[2], const PetscReal c[2])
{
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

#pragma once
/*
  MpmMapLayer - ground between two surfaces over the plane of x and y, each a level or a map, bilinear between the
  centres of its pixels. The upper one may be the lower end of another layer.

  Order of calls: MpmMapLayerRead(), MpmMapLayerSetAbove() where the block has `below`, then all others.
*/
#include "base/base.h"
#include "base/types.h"
#include "maps/outline.h"

typedef struct _p_MpmMapLayer *MpmMapLayer;

/*
  Reads -<prefix>top, a level or a map, m, and -<prefix>bottom or -<prefix>depth, below the top. Without `top` and
  `below` the bed of the scene is the top (maps/bed.h); without the others the layer has no lower end. Only pixels about
  the record's window are read. Collective; fails with MPM_ERR_INPUT and one line.
*/
PetscErrorCode MpmMapLayerRead(const MpmOptions *block, MpmMapLayer *layer);
PetscErrorCode MpmMapLayerDestroy(MpmMapLayer *layer);
/* The layer's top is the lower end of another one, which is borrowed. */
void      MpmMapLayerSetAbove(MpmMapLayer layer, MpmMapLayer above);
PetscBool MpmMapLayerIsBoundedBelow(MpmMapLayer layer);
/*
  Cuts a box to what the layer covers: to the rectangle of its maps, and to its least and largest height there, which
  are infinite where it has no end.
*/
void MpmMapLayerBound(MpmMapLayer layer, PetscReal lower[3], PetscReal upper[3]);
/* True where a place is in the layer, or no more than this height above or below, m; never over pixels without data. */
PetscBool MpmMapLayerHolds(MpmMapLayer layer, const PetscReal x[3], PetscReal tolerance);
/* True where a surface of the layer may come nearer to x than this distance, m. */
PetscBool MpmMapLayerIsNear(MpmMapLayer layer, const PetscReal x[3], PetscReal distance);
/*
  Height and slopes at a place of the upper surface (side 1) or the lower one (side 0); PETSC_FALSE where the layer has
  none there, or no thickness.
*/
PetscBool MpmMapLayerSurface(MpmMapLayer layer, PetscInt side, const PetscReal x[], PetscReal *height,
                             PetscReal slope[2]);
/*
  MpmMapLayerPart - the layer's part of a box

  Input Parameters:
+ layer        - the layer
. outline      - polygons to which it is cut, or NULL
. area         - of these polygons in the box's base, m2, and
. middle       - their centroid
- lower, upper - corners of the box, m

  Output Parameter:
. centroid - of the part

  Returns the volume, m3.

  Notes:
  Heights are taken at middles of pieces into which centres of pixels divide the base. These places do not depend on the
  box's height: the volumes of boxes one above the other add up to the integral over their base, which is exact for
  bilinear surfaces that nowhere cross. A cut box has at least SAMPLES places along each axis.
*/
PetscReal MpmMapLayerPart(MpmMapLayer layer, const MpmOutline *outline, PetscReal area, const PetscReal middle[2],
                          const PetscReal lower[3], const PetscReal upper[3], PetscReal centroid[3]);

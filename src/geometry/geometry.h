#pragma once
/*
  MpmRegion - a part of space, read from options: box, sphere, cylinder, polygon, layers of ground, outline, voxels
              (file regions of bodies are read by the bodies).
  MpmRamp   - a piecewise linear factor of time, read from "time:factor" pairs.
*/
#include "base/base.h"
#include "base/types.h"

typedef enum {
  MPM_REGION_ALL,
  MPM_REGION_BOX,
  MPM_REGION_SPHERE,
  MPM_REGION_CYLINDER,
  MPM_REGION_POLYGON,
  MPM_REGION_LAYERS,
  MPM_REGION_OUTLINE,
  MPM_REGION_RASTER,
  MPM_REGION_VOXELS,
  MPM_REGION_FILE, /* from here on the points of bodies come from files */
  MPM_REGION_COLUMNS,
  MPM_REGION_DEPTH,
  MPM_REGION_HYDROGRAPH
} MpmRegionType;

typedef struct _p_MpmRegion *MpmRegion;
struct MpmOutline;

/* For -help: the options of every type of region. */
PetscErrorCode MpmRegionPrintHelp(MPI_Comm comm);
/*
  Reads -<prefix>region, -<prefix>lower, ...; see region.c. `tolerance` holds one length per axis (1e-6 of a cell):
  places within it of the edge count as inside. Fails with MPM_ERR_INPUT and one line that names the option.
*/
PetscErrorCode MpmRegionCreate(const MpmOptions *options, PetscInt dim, const PetscReal tolerance[], MpmRegion *region);
PetscErrorCode MpmRegionDestroy(MpmRegion *region);
PetscBool      MpmRegionContains(MpmRegion region, const PetscReal x[]);
MpmRegionType  MpmRegionGetType(MpmRegion region);
/*
  Puts a layer beneath another one: its top is the lower end of the layer above, and where that one thins out, its top.
*/
PetscErrorCode MpmRegionSetAbove(MpmRegion region, MpmRegion above);
/* Lends the voxels of a region of type voxels, or NULL. */
struct MpmVoxels *MpmRegionVoxels(MpmRegion region);
/* Lends the outline of a region of type outline or raster, or NULL. */
const struct MpmOutline *MpmRegionOutline(MpmRegion region);
/* True of layers of ground, between lines or between maps. */
PetscBool MpmRegionIsLayer(MpmRegion region);
/* True where a layer has a lower end. */
PetscBool MpmRegionIsBoundedBelow(MpmRegion region);
/*
  The region's bounding box, clipped to the given one on entry: lower and upper hold the domain and return the
  intersection.
*/
PetscErrorCode MpmRegionGetBounds(MpmRegion region, PetscReal lower[], PetscReal upper[]);

/*
  The surface that cut a lattice of boxes of these half-lengths, as found from the middle x of one inside the region:
  the nearest within reach. Returns its outward normal and the depth of x below it, >= 0. Straight surfaces across an
  axis do not count: boxes end there.
*/
PetscBool MpmRegionCut(MpmRegion region, const PetscReal x[], const PetscReal half[], PetscReal normal[],
                       PetscReal *depth);

/*
  Distance from a place x inside along an axis to a side (0 lower, 1 upper), m, where it is less than twice `half`, and
  differs from `half` by more than a ten-thousandth: a lattice of boxes of this half-length was cut there.
*/
PetscBool MpmRegionEnd(MpmRegion region, const PetscReal x[], PetscInt axis, PetscInt side, PetscReal half,
                       PetscReal *end);

/* True where its surface is round: a sphere (2D: a disc) or a cylinder. */
PetscBool MpmRegionIsRound(MpmRegion region);
/* True where the clipping ends a round one, from a place along an axis to a side (0 lower, 1 upper), before its
   surface. */
PetscBool MpmRegionClips(MpmRegion region, const PetscReal x[], PetscInt axis, PetscInt side);
/* Puts a place onto the round surface along its normal, which is returned, outward; returns its former depth, m. */
PetscReal MpmRegionToRound(MpmRegion region, PetscReal at[], PetscReal normal[]);
/* Of a round one, m. */
PetscReal MpmRegionRadius(MpmRegion region);

/*
  Reads -<prefix>vertices, a polygon that does not meet itself: x and y of `count` vertices in order; free with
  PetscFree(). With -help there may be none.
*/
PetscErrorCode MpmPolygonRead(const MpmOptions *options, PetscInt *count, PetscReal **vertices);

/*
  Reads -<prefix><name> "t:f,t:f,..."; `fallback` is the text used when the option is absent. Times must not decrease.
*/
PetscErrorCode MpmRampCreate(const MpmOptions *options, const char *name, const char *fallback, MpmRamp *ramp);
PetscErrorCode MpmRampDestroy(MpmRamp *ramp);
PetscReal      MpmRampEvaluate(MpmRamp ramp, PetscReal time);
/*
  The factor integrated `order` times, 1 or 2, from time 0 on, exactly; of order -1 and -2 its first and second
  derivative, from the left, without a jump at that time.
*/
PetscReal MpmRampIntegral(MpmRamp ramp, PetscReal time, PetscInt order);
/*
  Reads -<prefix><name>, a CSV file with the columns time (s) and value, which grow in time; NULL where it is absent. A
  `record` is a signal sampled evenly, and 0 before its first and after its last row.
*/
PetscErrorCode MpmRampReadTable(const MpmOptions *options, const char *name, PetscBool record, MpmRamp *ramp);
/* The least and the largest factor of all times. */
void MpmRampBounds(MpmRamp ramp, PetscReal *least, PetscReal *most);
/* The time from which on the factor stays; minus infinity where it never changes. */
PetscReal MpmRampLastChange(MpmRamp ramp);

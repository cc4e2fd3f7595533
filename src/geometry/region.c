/*
  MpmRegion - a region of space, read from the options of a block.

    region    all (default) | box | sphere | cylinder | polygon | layers | outline | raster | file, columns, depth (of
              points, which the block's owner reads)
    box       lower, upper: corners; equal ones make a plane, a line or a point
    sphere    center, radius; a disc in 2D
    cylinder  3D only: point, axis (any length, default 0,0,1), radius, length (along the axis from the point;
              endless both ways if absent)
    polygon   vertices: x1,y1,x2,y2,... in order round the boundary, closed by itself; in 3D a prism along z, from
              lower_z to upper_z where they are given
    layers    one layer of ground between the lines top and bottom (layers.c)
    outline   the polygons of a file (region_outline.c)
    raster    of bodies of depth-averaged flow: as outline, or what a map of depths covers; in 3D ground between maps
    voxels    of bodies: a lattice with labels from a file (voxels.c)

  All of them are cut to the box from clip_lower to clip_upper, where these are given: an octant of a sphere.
*/
#include "options/options.h"
#include "geometry/region_impl.h"

#include <math.h>
#include <stdio.h>

static const char *const region_types[] = {"all",    "box",    "sphere", "cylinder", "polygon", "layers",     "outline",
                                           "raster", "voxels", "file",   "columns",  "depth",   "hydrograph", NULL};

static const char *Prefix(const MpmOptions *options)
{
  return options->prefix ? options->prefix : "";
}

/* ---- reading, by type ---- */

static PetscErrorCode ReadBox(const MpmOptions *options, MpmRegion region)
{
  PetscReal lower[MPM_REGION_DIM] = {0., 0., 0.}, upper[MPM_REGION_DIM] = {0., 0., 0.};
  char      low[MPM_NUMBER_TEXT], high[MPM_NUMBER_TEXT];

  PetscFunctionBegin;
  PetscCall(
    MpmOptionsReals(options, "lower", "m", "lower corner", MPM_RANGE_ANY, MPM_REQUIRED, region->dim, lower, NULL));
  PetscCall(
    MpmOptionsReals(options, "upper", "m", "upper corner", MPM_RANGE_ANY, MPM_REQUIRED, region->dim, upper, NULL));
  for (PetscInt a = 0; a < region->dim; a++) {
    MpmRealText(lower[a], low);
    MpmRealText(upper[a], high);
    /* With -help one of the two may be missing, and nothing is compared. */
    if (lower[a] > upper[a]) {
      PetscBool help;

      PetscCall(PetscOptionsHasHelp(NULL, &help));
      MpmCheckInput(help, "-%supper %s on axis %c: must be >= -%slower, which is %s", Prefix(options), high, "xyz"[a],
                    Prefix(options), low);
    }
    region->lower[a] = lower[a] - region->tolerance[a];
    region->upper[a] = upper[a] + region->tolerance[a];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadSphere(const MpmOptions *options, MpmRegion region)
{
  PetscFunctionBegin;
  PetscCall(
    MpmOptionsReals(options, "center", "m", "centre", MPM_RANGE_ANY, MPM_REQUIRED, region->dim, region->center, NULL));
  PetscCall(MpmOptionsReal(options, "radius", "m", "radius", MPM_RANGE_POSITIVE, MPM_REQUIRED, &region->radius, NULL));
  for (PetscInt a = 0; a < region->dim; a++) {
    region->lower[a] = region->center[a] - region->radius - region->tolerance[a];
    region->upper[a] = region->center[a] + region->radius + region->tolerance[a];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A disc of radius r across the unit vector a reaches r sqrt(1 - a_i^2) along axis i. */
static void BoundCylinder(MpmRegion region)
{
  for (PetscInt i = 0; i < 3; i++) {
    const PetscReal slope  = region->axis[i],
                    across = region->radius * sqrt(PetscMax(0., 1. - slope * slope)) + region->tolerance[i];
    const PetscReal along  = PetscMax(region->length, 0.) * slope;

    /* Endless ones are bounded only across axes they run exactly at right angles to. */
    if (region->length < 0. && slope != 0.) continue;
    region->lower[i] = region->center[i] + PetscMin(0., along) - across;
    region->upper[i] = region->center[i] + PetscMax(0., along) + across;
  }
}

static PetscErrorCode ReadCylinder(const MpmOptions *options, MpmRegion region)
{
  PetscReal axis[MPM_REGION_DIM] = {0., 0., 1.}, length = 0., norm;
  PetscBool set;

  PetscFunctionBegin;
  MpmCheckInput(region->dim == 3, "-%sregion cylinder: exists in 3 dimensions only; in 2, a sphere is a disc",
                Prefix(options));
  PetscCall(MpmOptionsReals(options, "point", "m", "a point of the axis, where `length` starts", MPM_RANGE_ANY,
                            MPM_REQUIRED, 3, region->center, NULL));
  PetscCall(MpmOptionsReals(options, "axis", "-", "direction of the axis, of any length but 0", MPM_RANGE_ANY,
                            MPM_OPTIONAL, 3, axis, NULL));
  PetscCall(MpmOptionsReal(options, "radius", "m", "radius", MPM_RANGE_POSITIVE, MPM_REQUIRED, &region->radius, NULL));
  PetscCall(MpmOptionsReal(options, "length", "m", "length from the point along the axis; endless both ways if absent",
                           MPM_RANGE_POSITIVE, MPM_OPTIONAL, &length, &set));
  region->length = set ? length : -1.;
  norm           = hypot(hypot(axis[0], axis[1]), axis[2]);
  MpmCheckInput(norm > 0. && norm < PETSC_INFINITY, "-%saxis: the direction has no length", Prefix(options));
  for (PetscInt i = 0; i < 3; i++) region->axis[i] = axis[i] / norm;
  BoundCylinder(region);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- polygons ---- */

/* True where c, known to be in line with a and b, is between them. */
static PetscBool Between(const PetscReal a[2], const PetscReal b[2], const PetscReal c[2])
{
  return (c[0] >= PetscMin(a[0], b[0]) && c[0] <= PetscMax(a[0], b[0]) && c[1] >= PetscMin(a[1], b[1]) &&
          c[1] <= PetscMax(a[1], b[1]))
           ? PETSC_TRUE
           : PETSC_FALSE;
}

/* True where the closed segments ab and cd have a point in common. */
static PetscBool SegmentsMeet(const PetscReal a[2], const PetscReal b[2], const PetscReal c[2], const PetscReal d[2])
{
  const PetscReal abc = MpmTriangleCross(a, b, c), abd = MpmTriangleCross(a, b, d), cda = MpmTriangleCross(c, d, a),
                  cdb = MpmTriangleCross(c, d, b);

  if (((abc > 0. && abd < 0.) || (abc < 0. && abd > 0.)) && ((cda > 0. && cdb < 0.) || (cda < 0. && cdb > 0.)))
    return PETSC_TRUE;
  if ((abc == 0. && Between(a, b, c)) || (abd == 0. && Between(a, b, d))) return PETSC_TRUE;
  if ((cda == 0. && Between(c, d, a)) || (cdb == 0. && Between(c, d, b))) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* True where the boundary turns straight back at vertex b, on its way from a to c. */
static PetscBool IsSpike(const PetscReal a[2], const PetscReal b[2], const PetscReal c[2])
{
  const PetscReal dot = (b[0] - a[0]) * (c[0] - b[0]) + (b[1] - a[1]) * (c[1] - b[1]);

  return (MpmTriangleCross(a, b, c) == 0. && dot < 0.) ? PETSC_TRUE : PETSC_FALSE;
}

/* Every pair of edges, once: input, so its cost does not matter. An area of zero needs edges that overlap. */
static PetscErrorCode CheckPolygon(const MpmOptions *options, PetscInt n, const PetscReal v[])
{
  const char *prefix = Prefix(options);

  PetscFunctionBegin;
  for (PetscInt i = 0; i < n; i++) {
    const PetscReal *a = v + 2 * i, *b = v + 2 * ((i + 1) % n), *c = v + 2 * ((i + 2) % n);

    MpmCheckInput(a[0] != b[0] || a[1] != b[1], "-%svertices: vertices %lld and %lld are the same", prefix,
                  (long long)i + 1, (long long)(i + 1) % n + 1);
    MpmCheckInput(!IsSpike(a, b, c), "-%svertices: the boundary turns back on itself at vertex %lld", prefix,
                  (long long)(i + 1) % n + 1);
  }
  for (PetscInt i = 0; i < n; i++) {
    for (PetscInt j = i + 2; j < n; j++) {
      if (i == 0 && j == n - 1) continue; /* neighbours, round the end */
      MpmCheckInput(!SegmentsMeet(v + 2 * i, v + 2 * (i + 1), v + 2 * j, v + 2 * ((j + 1) % n)),
                    "-%svertices: the edges from vertex %lld and from vertex %lld cross or touch", prefix,
                    (long long)i + 1, (long long)j + 1);
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPrismRead(const MpmOptions *options, MpmRegion region)
{
  PetscReal lower = 0., upper = 0.;
  PetscBool set_lower, set_upper;

  PetscFunctionBegin;
  PetscCall(MpmOptionsReal(options, "lower_z", "m", "lower end of the prism; endless if absent", MPM_RANGE_ANY,
                           MPM_OPTIONAL, &lower, &set_lower));
  PetscCall(MpmOptionsReal(options, "upper_z", "m", "upper end of the prism; endless if absent", MPM_RANGE_ANY,
                           MPM_OPTIONAL, &upper, &set_upper));
  MpmCheckInput(!set_lower || !set_upper || lower <= upper, "-%supper_z: must be >= -%slower_z", Prefix(options),
                Prefix(options));
  if (set_lower) region->lower[2] = lower - region->tolerance[2];
  if (set_upper) region->upper[2] = upper + region->tolerance[2];
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPolygonRead(const MpmOptions *options, PetscInt *count, PetscReal **vertices)
{
  PetscInt   numbers, n;
  PetscReal *v;

  PetscFunctionBegin;
  PetscCall(MpmOptionsRealList(options, "vertices", "m", "x1,y1,x2,y2,... round the boundary, 3 vertices at least",
                               MPM_REQUIRED, &numbers, &v));
  *count    = 0;
  *vertices = v;
  if (numbers == 0) PetscFunctionReturn(PETSC_SUCCESS); /* missing, with -help */
  MpmCheckInput(numbers % 2 == 0, "-%svertices: has %lld numbers, must have two a vertex", Prefix(options),
                (long long)numbers);
  n = numbers / 2;
  if (n > 1 && v[0] == v[numbers - 2] && v[1] == v[numbers - 1]) n--; /* closed by hand */
  MpmCheckInput(n >= 3, "-%svertices: has %lld vertices, must have 3 at least", Prefix(options), (long long)n);
  PetscCall(CheckPolygon(options, n, v));
  *count = n;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadPolygon(const MpmOptions *options, MpmRegion region)
{
  PetscInt   n;
  PetscReal *v;

  PetscFunctionBegin;
  PetscCall(MpmPolygonRead(options, &n, &v));
  if (region->dim == 3) PetscCall(MpmPrismRead(options, region));
  if (n == 0) {
    PetscCall(PetscFree(v));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  for (PetscInt a = 0; a < 2; a++) {
    region->lower[a] = PETSC_INFINITY;
    region->upper[a] = PETSC_NINFINITY;
    for (PetscInt i = 0; i < n; i++) {
      region->lower[a] = PetscMin(region->lower[a], v[2 * i + a] - region->tolerance[a]);
      region->upper[a] = PetscMax(region->upper[a], v[2 * i + a] + region->tolerance[a]);
      v[2 * i + a] /= region->tolerance[a];
    }
  }
  region->vertex_count = n;
  region->vertices     = v;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- region ---- */

/* Geometry without a type is a slip that would otherwise fill the grid. */
static PetscErrorCode CheckNoGeometry(const MpmOptions *options)
{
  static const char *const names[] = {"lower", "upper", "center", "radius", "vertices", "top", "outline"};

  PetscFunctionBegin;
  for (size_t i = 0; i < sizeof(names) / sizeof(names[0]); i++) {
    PetscBool has;

    PetscCall(MpmOptionsHas(options, names[i], &has));
    MpmCheckInput(!has,
                  "-%sregion is missing, but -%s%s is given: one of box, sphere, cylinder, polygon, layers, outline",
                  Prefix(options), Prefix(options), names[i]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadGeometry(const MpmOptions *options, MpmRegion region)
{
  PetscFunctionBegin;
  switch (region->type) {
  case MPM_REGION_BOX:
    PetscCall(ReadBox(options, region));
    break;
  case MPM_REGION_SPHERE:
    PetscCall(ReadSphere(options, region));
    break;
  case MPM_REGION_CYLINDER:
    PetscCall(ReadCylinder(options, region));
    break;
  case MPM_REGION_POLYGON:
    PetscCall(ReadPolygon(options, region));
    break;
  case MPM_REGION_LAYERS:
    PetscCall(MpmLayerRead(options, region));
    break;
  case MPM_REGION_OUTLINE:
  case MPM_REGION_RASTER:
    PetscCall(MpmRegionOutlineRead(options, region));
    break;
  case MPM_REGION_VOXELS:
    PetscCall(MpmVoxelsRead(options, region->dim, &region->voxels));
    for (PetscInt a = 0; a < region->dim; a++) {
      region->lower[a] = region->voxels->lower[a] - region->tolerance[a];
      region->upper[a] = region->voxels->upper[a] + region->tolerance[a];
    }
    break;
  case MPM_REGION_ALL:
    PetscCall(CheckNoGeometry(options));
    break;
  default: /* its block's owner reads the points */
    break;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Everywhere, before options are read. */
static void Unbound(MpmRegion region)
{
  for (PetscInt a = 0; a < MPM_REGION_DIM; a++) {
    region->lower[a] = region->clip[0][a] = PETSC_NINFINITY;
    region->upper[a] = region->clip[1][a] = PETSC_INFINITY;
  }
}

/* Keeps the box between two corners, of which either may be missing. */
static PetscErrorCode ReadClip(const MpmOptions *options, MpmRegion region)
{
  PetscFunctionBegin;
  if (region->type >= MPM_REGION_FILE || (region->type == MPM_REGION_RASTER && !region->ground))
    PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmOptionsReals(options, "clip_lower", "m", "the region ends at this lower corner", MPM_RANGE_ANY,
                            MPM_OPTIONAL, region->dim, region->clip[0], NULL));
  PetscCall(MpmOptionsReals(options, "clip_upper", "m", "the region ends at this upper corner", MPM_RANGE_ANY,
                            MPM_OPTIONAL, region->dim, region->clip[1], NULL));
  for (PetscInt a = 0; a < region->dim; a++) {
    MpmCheckInput(region->clip[0][a] <= region->clip[1][a],
                  "-%sclip_upper %g on axis %c: must be >= -%sclip_lower, which is %g", Prefix(options),
                  (double)region->clip[1][a], "xyz"[a], Prefix(options), (double)region -> clip[0][a]);
    region->lower[a] = PetscMax(region->lower[a], region->clip[0][a] - region->tolerance[a]);
    region->upper[a] = PetscMin(region->upper[a], region->clip[1][a] + region->tolerance[a]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmRegionCreate(const MpmOptions *options, PetscInt dim, const PetscReal tolerance[], MpmRegion *region)
{
  MpmRegion r;
  PetscInt  type = MPM_REGION_ALL;

  PetscFunctionBegin;
  *region = NULL;
  PetscCheck(dim >= 2 && dim <= MPM_REGION_DIM, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE,
             "A region has 2 or 3 dimensions, not %lld", (long long)dim);
  PetscCall(PetscNew(&r));
  r->dim = dim;
  Unbound(r);
  for (PetscInt a = 0; a < MPM_REGION_DIM; a++) {
    if (a < dim) r->tolerance[a] = tolerance[a];
    PetscCheck(a >= dim || tolerance[a] > 0., PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE,
               "A region's tolerance must be positive");
  }
  PetscCall(MpmOptionsWord(options, "region", "which part of space", region_types, MPM_OPTIONAL, &type, NULL));
  r->type = (MpmRegionType)type;
  PetscCall(ReadGeometry(options, r));
  PetscCall(ReadClip(options, r));
  *region = r;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmRegionPrintHelp(MPI_Comm comm)
{
  static const struct {
    MpmRegionType type;
    PetscInt      dim;
    const char   *title;
  } kinds[] = {{MPM_REGION_BOX, 2, "Regions of type box (BLOCK: body_NAME, bc_NAME, load_NAME, track_NAME)"},
               {MPM_REGION_SPHERE, 2, "Regions of type sphere; in 2D, a disc"},
               {MPM_REGION_CYLINDER, 3, "Regions of type cylinder, in 3D"},
               {MPM_REGION_POLYGON, 3, "Regions of type polygon; in 3D, a prism along z"},
               {MPM_REGION_OUTLINE, 3, "Regions of type outline: polygons of a file; in 3D, prisms along z"},
               {MPM_REGION_RASTER, 3, "Regions of type raster in 3D: ground between maps"},
               {MPM_REGION_VOXELS, 3, "Regions of type voxels, of bodies: a lattice with labels"},
               {MPM_REGION_LAYERS, 3, "Regions of type layers; in 3D, a prism along z"}};
  const MpmOptions options = {comm, "mpm_BLOCK_", NULL};

  PetscFunctionBegin;
  for (size_t k = 0; k < sizeof(kinds) / sizeof(kinds[0]); k++) {
    struct _p_MpmRegion region = {.type = kinds[k].type, .dim = kinds[k].dim};

    PetscCall(MpmOptionsHeading(&options, kinds[k].title));
    Unbound(&region);
    PetscCall(ReadGeometry(&options, &region));
    PetscCall(ReadClip(&options, &region));
    PetscCall(MpmVoxelsDestroy(&region.voxels));
    PetscCall(MpmMapLayerDestroy(&region.ground));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmRegionDestroy(MpmRegion *region)
{
  PetscFunctionBegin;
  if (!*region) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscFree((*region)->vertices));
  PetscCall(MpmVoxelsDestroy(&(*region)->voxels));
  PetscCall(MpmOutlineDestroy(&(*region)->outline));
  PetscCall(MpmMapLayerDestroy(&(*region)->ground));
  PetscCall(MpmPolylineDestroy(&(*region)->layer.top));
  PetscCall(MpmPolylineDestroy(&(*region)->layer.bottom));
  PetscCall(PetscFree(*region));
  PetscFunctionReturn(PETSC_SUCCESS);
}

MpmRegionType MpmRegionGetType(MpmRegion region)
{
  return region->type;
}

PetscErrorCode MpmRegionGetBounds(MpmRegion region, PetscReal lower[], PetscReal upper[])
{
  PetscFunctionBegin;
  for (PetscInt a = 0; a < region->dim; a++) {
    lower[a] = PetscMax(lower[a], region->lower[a]);
    upper[a] = PetscMin(upper[a], region->upper[a]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

struct MpmVoxels *MpmRegionVoxels(MpmRegion region)
{
  return region->voxels;
}

/*
  The part of a region in a box.

  Boxes are cut to the region's bounding box first. Polygons and layers are cut along the four sides of a rectangle one
  after the other (Sutherland and Hodgman 1974, doi:10.1145/360767.360802); area and first moments are sums over the
  edges of what is left. A disc of radius R is integrated over the angle t of x = R sin t, in which its chords are
  smooth, between the places where the circle enters or leaves the rectangle. Spheres are integrated over slices.
*/
#include "maps/polygon_part.h"
#include "geometry/region_part.h"
#include "geometry/region_impl.h"

/* Area and its first moments about the origin. */
typedef struct {
  PetscReal area, moment[2];
} Moments;

/* Five nodes and weights on [-1, 1]. */
static const PetscReal gauss[2][5] = {{-0.906179845938663992797626878299, -0.538469310105683091036314420700, 0.,
                                       0.538469310105683091036314420700, 0.906179845938663992797626878299},
                                      {0.236926885056189087514264040720, 0.478628670499366468041291514836,
                                       0.568888888888888888888888888889, 0.478628670499366468041291514836,
                                       0.236926885056189087514264040720}};

/* ---- polygons ---- */

/* Area of a polygon, with the sign of its direction, and moments, by triangles from its first vertex. */
static Moments PolygonMoments(PetscInt count, const PetscReal v[])
{
  Moments sum = {0., {0.}};

  for (PetscInt i = 1; i + 1 < count; i++) {
    const PetscReal twice = MpmTriangleCross(v, &v[2 * i], &v[2 * i + 2]);

    sum.area += 0.5 * twice;
    for (PetscInt a = 0; a < 2; a++) sum.moment[a] += twice / 6. * (v[a] + v[2 * i + a] + v[2 * i + 2 + a]);
  }
  return sum;
}

/* The part of a polygon in a rectangle; `room` holds 24 numbers for each vertex, and 128 more. */
static Moments PolygonPart(PetscInt count, const PetscReal v[], const PetscReal lower[], const PetscReal upper[],
                           PetscReal room[])
{
  PetscReal *from = room, *to = &room[12 * count + 64];
  Moments    part;

  for (PetscInt i = 0; i < 2 * count; i++) from[i] = v[i];
  for (PetscInt k = 0; k < 4; k++) {
    PetscReal *swap = from;

    count = MpmRingCut(count, from, k / 2, k % 2 ? -1. : 1., k % 2 ? upper[k / 2] : lower[k / 2], to);
    from  = to;
    to    = swap;
  }
  part = PolygonMoments(count, from);
  if (part.area < 0.) part = (Moments){-part.area, {-part.moment[0], -part.moment[1]}};
  return part;
}

/* ---- layers ---- */

/* Adds a line's vertices from left to right, or back; ends are heights at the rectangle's sides, and `least` without
   a line. */
static PetscInt AddLine(const MpmPolyline *line, PetscReal left, PetscReal right, PetscReal least, PetscBool back,
                        PetscReal v[])
{
  PetscInt n = 0;

  for (PetscInt k = -1; k <= line->count; k++) {
    const PetscInt  i  = back ? line->count - 1 - k : k;
    const PetscReal at = i < 0 ? left : i == line->count ? right : line->at[2 * i];

    if (i >= 0 && i < line->count && (at <= left || at >= right)) continue;
    v[2 * n] = at;
    if (i >= 0 && i < line->count) v[2 * n + 1] = line->at[2 * i + 1];
    else v[2 * n + 1] = line->count ? MpmPolylineHeight(line, at, at > left ? -1 : 1) : least;
    n++;
  }
  return n;
}

/* ---- discs ---- */

static PetscReal Clamp(PetscReal x, PetscReal lower, PetscReal upper)
{
  return PetscMin(PetscMax(x, lower), upper);
}

/* The part of a disc about the origin in a rectangle, by angles between its crossings. */
static Moments DiscPart(PetscReal radius, const PetscReal lower[], const PetscReal upper[])
{
  const PetscReal left = Clamp(lower[0], -radius, radius), right = Clamp(upper[0], -radius, radius);
  PetscReal       ends[6];
  PetscInt        n   = 0;
  Moments         sum = {0., {0.}};

  if (!(left < right)) return sum;
  ends[n++] = left;
  ends[n++] = right;
  for (PetscInt k = 0; k < 2; k++) {
    const PetscReal y = k ? upper[1] : lower[1];

    for (PetscInt side = -1; side <= 1 && PetscAbsReal(y) < radius; side += 2)
      ends[n++] = Clamp((PetscReal)side * PetscSqrtReal(radius * radius - y * y), left, right);
  }
  (void)PetscSortReal(n, ends);
  for (PetscInt k = 0; k + 1 < n; k++) {
    const PetscReal from = PetscAsinReal(Clamp(ends[k] / radius, -1., 1.)),
                    to = PetscAsinReal(Clamp(ends[k + 1] / radius, -1., 1.)), half = 0.5 * (to - from);

    for (PetscInt q = 0; q < 5 && half > 0.; q++) {
      const PetscReal t = 0.5 * (from + to) + half * gauss[0][q], chord = radius * PetscCosReal(t);
      const PetscReal low = PetscMax(lower[1], -chord), high = PetscMin(upper[1], chord);
      const PetscReal area = high > low ? gauss[1][q] * half * chord * (high - low) : 0.;

      sum.area += area;
      sum.moment[0] += area * radius * PetscSinReal(t);
      sum.moment[1] += area * 0.5 * (low + high);
    }
  }
  return sum;
}

/* ---- regions ---- */

/* The part of a polygon or a layer in the plane of x and y. */
static Moments PlanePart(MpmRegion region, const PetscReal lower[], const PetscReal upper[])
{
  const PetscInt lines = region->layer.top.count + region->layer.bottom.count + 4,
                 most  = region->type == MPM_REGION_POLYGON ? region->vertex_count : lines;
  PetscInt   n         = 0;
  PetscReal *v, *room;
  Moments    part = {0., {0.}};

  if (PetscMalloc2((2 * most), &v, (24 * most + 128), &room)) return part;
  if (region->type == MPM_REGION_POLYGON) {
    for (; n < most; n++)
      for (PetscInt a = 0; a < 2; a++) v[2 * n + a] = region->vertices[2 * n + a] * region->tolerance[a];
  } else {
    n += AddLine(&region->layer.top, lower[0], upper[0], lower[1], PETSC_FALSE, v);
    n += AddLine(&region->layer.bottom, lower[0], upper[0], lower[1], PETSC_TRUE, &v[2 * n]);
  }
  part = PolygonPart(n, v, lower, upper, room);
  (void)PetscFree2(v, room);
  return part;
}

#define SLICES 3 /* of five nodes each */

/* The part of a sphere, by discs along z. */
static PetscReal SpherePart(MpmRegion region, const PetscReal lower[], const PetscReal upper[], PetscReal centroid[])
{
  const PetscReal *c = region->center, low[2] = {lower[0] - c[0], lower[1] - c[1]},
                  high[2] = {upper[0] - c[0], upper[1] - c[1]}, bottom = lower[2] - c[2], height = upper[2] - lower[2];
  PetscReal volume = 0., moment[3] = {0.};

  for (PetscInt k = 0; k < 5 * SLICES; k++) {
    const PetscReal z      = bottom + height * ((PetscReal)(k / 5) + 0.5 * (1. + gauss[0][k % 5])) / (PetscReal)SLICES;
    const PetscReal square = region->radius * region->radius - z * z, weight = 0.5 * gauss[1][k % 5] * height / SLICES;
    const Moments   disc    = square > 0. ? DiscPart(PetscSqrtReal(square), low, high) : (Moments){0., {0.}};
    const PetscReal about[] = {disc.moment[0], disc.moment[1], disc.area * z};

    volume += weight * disc.area;
    for (PetscInt a = 0; a < 3; a++) moment[a] += weight * about[a];
  }
  for (PetscInt a = 0; a < 3; a++) centroid[a] = volume > 0. ? c[a] + moment[a] / volume : 0.;
  return volume;
}

static PetscBool Contains(const void *set, const PetscReal x[])
{
  return MpmRegionContains(*(const MpmRegion *)set, x);
}

#define SAMPLES 16  /* along each axis */
#define SLICE   1e4 /* a box so thin has one across it */

PetscReal MpmSampledPart(PetscInt dim, PetscBool (*contains)(const void *set, const PetscReal x[]), const void *set,
                         const PetscReal lower[], const PetscReal upper[], PetscReal centroid[])
{
  PetscInt  total = 1, inside = 0, most[MPM_REGION_DIM] = {1, 1, 1};
  PetscReal size = 1., sum[MPM_REGION_DIM] = {0.}, longest = 0.;

  for (PetscInt a = 0; a < dim; a++) longest = PetscMax(longest, upper[a] - lower[a]);
  for (PetscInt a = 0; a < dim; a++) total *= most[a] = upper[a] - lower[a] < longest / SLICE ? 1 : SAMPLES;
  for (PetscInt k = 0; k < total; k++) {
    const PetscInt sub[MPM_REGION_DIM] = {k % most[0], k / most[0] % most[1], k / (most[0] * most[1])};
    PetscReal      x[MPM_REGION_DIM];

    for (PetscInt a = 0; a < dim; a++)
      x[a] = lower[a] + (upper[a] - lower[a]) * ((PetscReal)sub[a] + 0.5) / (PetscReal)most[a];
    if (!contains(set, x)) continue;
    inside++;
    for (PetscInt a = 0; a < dim; a++) sum[a] += x[a];
  }
  for (PetscInt a = 0; a < dim; a++) {
    size *= upper[a] - lower[a];
    centroid[a] = inside ? sum[a] / (PetscReal)inside : 0.;
  }
  return size * (PetscReal)inside / (PetscReal)total;
}

/* The axis that a cylinder runs along, or -1. */
static PetscInt CylinderAxis(MpmRegion region)
{
  for (PetscInt a = 0; a < 3; a++)
    if (PetscAbsReal(region->axis[a]) > 1. - 1e-12) return a;
  return -1;
}

/* The part of a disc or of a cylinder along an axis of the grid; that axis is the third one of a disc. */
static PetscReal RoundPart(MpmRegion region, PetscInt axis, const PetscReal lower[], const PetscReal upper[],
                           PetscReal centroid[])
{
  const PetscInt  p = (axis + 1) % 3, q = (axis + 2) % 3;
  const PetscReal low[2]  = {lower[p] - region->center[p], lower[q] - region->center[q]},
                  high[2] = {upper[p] - region->center[p], upper[q] - region->center[q]};
  const Moments part      = DiscPart(region->radius, low, high);

  if (!(part.area > 0.)) return 0.;
  centroid[p] = region->center[p] + part.moment[0] / part.area;
  centroid[q] = region->center[q] + part.moment[1] / part.area;
  if (axis < region->dim) centroid[axis] = 0.5 * (lower[axis] + upper[axis]);
  return part.area * (upper[axis] - lower[axis]);
}

PetscReal MpmRegionPart(MpmRegion region, const PetscReal lower[], const PetscReal upper[], PetscReal centroid[])
{
  PetscReal low[MPM_REGION_DIM] = {0.}, high[MPM_REGION_DIM] = {0., 0., 1.}, size = 1.; /* 2D: 1 thick */

  for (PetscInt a = 0; a < region->dim; a++) {
    low[a]      = PetscMax(lower[a], region->lower[a] + region->tolerance[a]);
    high[a]     = PetscMin(upper[a], region->upper[a] - region->tolerance[a]);
    centroid[a] = 0.5 * (low[a] + high[a]);
    if (!(low[a] < high[a])) return 0.;
    size *= high[a] - low[a];
  }
  if (region->ground) {
    const MpmOutline *outline   = MpmRegionOutline(region);
    PetscReal         middle[2] = {0., 0.}, area = outline ? MpmRegionOutlinePart(region, low, high, middle) : 0.;

    return MpmMapLayerPart(region->ground, outline, area, middle, low, high, centroid);
  }
  if (region->type == MPM_REGION_OUTLINE) return MpmRegionOutlinePart(region, low, high, centroid) * (high[2] - low[2]);
  if (region->type == MPM_REGION_POLYGON || region->type == MPM_REGION_LAYERS) {
    const Moments part = PlanePart(region, low, high);

    for (PetscInt a = 0; a < 2 && part.area > 0.; a++) centroid[a] = part.moment[a] / part.area;
    return part.area * (high[2] - low[2]);
  }
  if (region->type == MPM_REGION_SPHERE)
    return region->dim == 2 ? RoundPart(region, 2, low, high, centroid) : SpherePart(region, low, high, centroid);
  if (region->type != MPM_REGION_CYLINDER) return size;
  if (CylinderAxis(region) >= 0) return RoundPart(region, CylinderAxis(region), low, high, centroid);
  return MpmSampledPart(3, Contains, &region, low, high, centroid);
}

/* ---- edges ---- */

/* True where an edge of a polygon or a line is as near to x as the distance. */
static PetscBool IsNearLine(PetscInt count, const PetscReal v[], PetscBool closed, const PetscReal unit[],
                            const PetscReal x[], PetscReal distance)
{
  for (PetscInt i = 0; i < (closed ? count : count - 1); i++) {
    const PetscReal *a = &v[2 * i], *b = &v[2 * ((i + 1) % count)];
    const PetscReal  e[2] = {(b[0] - a[0]) * unit[0], (b[1] - a[1]) * unit[1]},
                    d[2]  = {x[0] - a[0] * unit[0], x[1] - a[1] * unit[1]};
    const PetscReal along = Clamp((d[0] * e[0] + d[1] * e[1]) / (e[0] * e[0] + e[1] * e[1]), 0., 1.);

    if (PetscSqr(d[0] - along * e[0]) + PetscSqr(d[1] - along * e[1]) <= distance * distance) return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

static PetscBool IsNearRound(MpmRegion region, const PetscReal x[], PetscReal distance)
{
  PetscReal along = 0., square = 0.;

  for (PetscInt a = 0; a < region->dim; a++) along += (x[a] - region->center[a]) * region->axis[a];
  for (PetscInt a = 0; a < region->dim; a++) square += PetscSqr(x[a] - region->center[a] - along * region->axis[a]);
  if (region->type == MPM_REGION_CYLINDER && region->length >= 0. &&
      PetscMin(PetscAbsReal(along), PetscAbsReal(along - region->length)) <= distance)
    return PETSC_TRUE;
  return (PetscBool)(PetscAbsReal(PetscSqrtReal(square) - region->radius) <= distance);
}

PetscBool MpmRegionIsNearEdge(MpmRegion region, const PetscReal x[], PetscReal distance)
{
  const PetscReal one[2] = {1., 1.};

  for (PetscInt a = 0; a < region->dim; a++)
    if (PetscAbsReal(x[a] - region->lower[a]) <= distance || PetscAbsReal(x[a] - region->upper[a]) <= distance)
      return PETSC_TRUE;
  switch (region->type) {
  case MPM_REGION_POLYGON:
    return IsNearLine(region->vertex_count, region->vertices, PETSC_TRUE, region->tolerance, x, distance);
  case MPM_REGION_OUTLINE:
  case MPM_REGION_RASTER:
    return (PetscBool)((region->outline.features && MpmOutlineDistance(&region->outline, x) <= distance) ||
                       (region->ground && MpmMapLayerIsNear(region->ground, x, distance)));
  case MPM_REGION_LAYERS:
    for (PetscInt k = 0; k < 2; k++) {
      const MpmPolyline *line = k ? &region->layer.top : &region->layer.bottom;

      if (PetscAbsReal(x[1] - MpmPolylineHeight(line, x[0], 1)) <= distance ||
          IsNearLine(line->count, line->at, PETSC_FALSE, one, x, distance))
        return PETSC_TRUE;
    }
    return PETSC_FALSE;
  case MPM_REGION_SPHERE:
  case MPM_REGION_CYLINDER:
    return IsNearRound(region, x, distance);
  default:
    return PETSC_FALSE;
  }
}

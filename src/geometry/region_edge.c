/*
  Inside and edge of a region.

  A place within the tolerance of the edge counts as inside. The tolerance is one length per axis; at an angle it is the
  reach of the ellipsoid with these semi-axes.
*/
#include "geometry/region_impl.h"

#include <math.h>

/* ---- inside ---- */

/* How far the ellipsoid of tolerances reaches along d, |d| = norm. */
static PetscReal ToleranceAlong(MpmRegion region, const PetscReal d[], PetscReal norm)
{
  PetscReal sum = 0.;

  if (norm <= 0.) return 0.;
  for (PetscInt a = 0; a < region->dim; a++) sum += PetscSqr(d[a] / norm * region->tolerance[a]);
  return sqrt(sum);
}

static PetscReal Norm(PetscInt dim, const PetscReal d[])
{
  PetscReal sum = 0.;

  for (PetscInt a = 0; a < dim; a++) sum += d[a] * d[a];
  return sqrt(sum);
}

static PetscBool InSphere(MpmRegion region, const PetscReal x[])
{
  PetscReal d[MPM_REGION_DIM], norm;

  for (PetscInt a = 0; a < region->dim; a++) d[a] = x[a] - region->center[a];
  norm = Norm(region->dim, d);
  return norm <= region->radius + ToleranceAlong(region, d, norm) ? PETSC_TRUE : PETSC_FALSE;
}

static PetscBool InCylinder(MpmRegion region, const PetscReal x[])
{
  PetscReal d[MPM_REGION_DIM], along = 0., end, norm;

  for (PetscInt a = 0; a < 3; a++) d[a] = x[a] - region->center[a];
  for (PetscInt a = 0; a < 3; a++) along += d[a] * region->axis[a];
  for (PetscInt a = 0; a < 3; a++) d[a] -= along * region->axis[a];
  end = ToleranceAlong(region, region->axis, 1.);
  if (region->length >= 0. && (along < -end || along > region->length + end)) return PETSC_FALSE;
  norm = Norm(3, d);
  return norm <= region->radius + ToleranceAlong(region, d, norm) ? PETSC_TRUE : PETSC_FALSE;
}

/* Square of the distance from p to the segment ab. */
static PetscReal SegmentDistance2(const PetscReal a[2], const PetscReal b[2], const PetscReal p[2])
{
  const PetscReal e[2] = {b[0] - a[0], b[1] - a[1]}, d[2] = {p[0] - a[0], p[1] - a[1]};
  const PetscReal along = PetscMax(0., PetscMin(1., (d[0] * e[0] + d[1] * e[1]) / (e[0] * e[0] + e[1] * e[1])));

  return PetscSqr(d[0] - along * e[0]) + PetscSqr(d[1] - along * e[1]);
}

/* Crossings of the ray from x towards +x, each edge with its lower end and without its upper one; the edges themselves
   come first. */
static PetscBool InPolygon(MpmRegion region, const PetscReal x[])
{
  const PetscReal  p[2] = {x[0] / region->tolerance[0], x[1] / region->tolerance[1]};
  const PetscReal *v    = region->vertices;
  PetscBool        in   = PETSC_FALSE;

  for (PetscInt i = 0, j = region->vertex_count - 1; i < region->vertex_count; j = i++) {
    const PetscReal *a = v + 2 * j, *b = v + 2 * i;

    if (SegmentDistance2(a, b, p) <= 1.) return PETSC_TRUE;
    if ((a[1] > p[1]) == (b[1] > p[1])) continue;
    if (p[0] < a[0] + (p[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0])) in = in ? PETSC_FALSE : PETSC_TRUE;
  }
  return in;
}

PetscBool MpmRegionContains(MpmRegion region, const PetscReal x[])
{
  for (PetscInt a = 0; a < region->dim; a++) {
    /* Written so that not-a-number is outside. */
    if (!(x[a] >= region->lower[a] && x[a] <= region->upper[a])) return PETSC_FALSE;
  }
  switch (region->type) {
  case MPM_REGION_SPHERE:
    return InSphere(region, x);
  case MPM_REGION_CYLINDER:
    return InCylinder(region, x);
  case MPM_REGION_POLYGON:
    return InPolygon(region, x);
  case MPM_REGION_LAYERS:
    return MpmLayerContains(region, x);
  case MPM_REGION_OUTLINE:
  case MPM_REGION_RASTER:
    return (PetscBool)(MpmRegionOutlineHolds(region, x) &&
                       (!region->ground || MpmMapLayerHolds(region->ground, x, region->tolerance[2])));
  case MPM_REGION_VOXELS:
    return (PetscBool)(MpmVoxelsAt(region->voxels, x)->value >= 0);
  default:
    return PETSC_TRUE;
  }
}

/* ---- edge ---- */

#define ALIGNED 1e-6  /* sine of the angle to an axis */
#define MORE    1.001 /* a box right on the edge may be another region's */

/* A piece of the surface, where it is nearer than the one that was found before. */
typedef struct {
  const PetscReal *half;
  PetscReal        depth, normal[MPM_REGION_DIM];
} Cut;

/* Keeps the cut if the middle of the next box on some axis is beyond the surface, and it is the nearest so far. */
static void Nearer(MpmRegion region, const PetscReal normal[], PetscReal depth, PetscBool straight, Cut *cut)
{
  PetscReal reach = 0., across = 1.;

  for (PetscInt a = 0; a < region->dim; a++) {
    reach  = PetscMax(reach, 2. * cut->half[a] * PetscAbsReal(normal[a]));
    across = PetscMin(across, 1. - PetscAbsReal(normal[a]));
  }
  if (depth > MORE * reach || depth < -2. * ToleranceAlong(region, normal, 1.) || depth >= cut->depth) return;
  if (straight && across < 0.5 * PetscSqr(ALIGNED)) return;
  cut->depth = PetscMax(depth, 0.);
  for (PetscInt a = 0; a < region->dim; a++) cut->normal[a] = normal[a];
}

/* The edge from a to b, m, that x stands before, or just beside; outside is on its right, or on its left: sign -1. */
static void CutByEdge(MpmRegion region, const PetscReal a[2], const PetscReal b[2], PetscReal sign, const PetscReal x[],
                      Cut *cut)
{
  const PetscReal e[2] = {b[0] - a[0], b[1] - a[1]}, d[2] = {x[0] - a[0], x[1] - a[1]};
  const PetscReal length = hypot(e[0], e[1]), along = (d[0] * e[0] + d[1] * e[1]) / length;
  const PetscReal normal[3] = {sign * e[1] / length, -sign * e[0] / length, 0.};
  PetscReal       beside    = 0.;

  for (PetscInt k = 0; k < 2; k++) beside += 2. * cut->half[k];
  if (along > -beside && along < length + beside)
    Nearer(region, normal, -(d[0] * normal[0] + d[1] * normal[1]), PETSC_TRUE, cut);
}

static void CutByPolygon(MpmRegion region, const PetscReal x[], Cut *cut)
{
  const PetscInt n    = region->vertex_count;
  PetscReal      turn = 0.;

  for (PetscInt i = 1; i + 1 < n; i++)
    turn += MpmTriangleCross(region->vertices, &region->vertices[2 * i], &region->vertices[2 * i + 2]);
  for (PetscInt i = 0; i < n; i++) {
    const PetscReal *a = &region->vertices[2 * i], *b = &region->vertices[2 * ((i + 1) % n)], *unit = region->tolerance;

    CutByEdge(region, (const PetscReal[]){a[0] * unit[0], a[1] * unit[1]},
              (const PetscReal[]){b[0] * unit[0], b[1] * unit[1]}, turn > 0. ? 1. : -1., x, cut);
  }
}

/* Top and bottom, where the layer has not thinned out. */
static void CutByLayer(MpmRegion region, const PetscReal x[], Cut *cut)
{
  const MpmPolyline *lines[2] = {&region->layer.bottom, &region->layer.top};

  for (PetscInt k = 0; k < 2; k++) {
    for (PetscInt i = 0; i + 1 < lines[k]->count; i++) {
      const PetscReal *a = &lines[k]->at[2 * i], *b = a + 2;

      if (MpmLayerIsThere(region, a[0], a[0] < b[0] ? 1 : -1) || MpmLayerIsThere(region, b[0], a[0] < b[0] ? -1 : 1))
        CutByEdge(region, a, b, k ? -1. : 1., x, cut);
    }
  }
}

/* Surfaces of ground between maps. */
static void CutByGround(MpmRegion region, const PetscReal x[], Cut *cut)
{
  for (PetscInt side = 0; side < 2; side++) {
    const PetscReal sign = side ? 1. : -1.;
    PetscReal       height, slope[2], length;

    if (!MpmMapLayerSurface(region->ground, side, x, &height, slope)) continue;
    length = sqrt(1. + slope[0] * slope[0] + slope[1] * slope[1]);
    Nearer(region, (const PetscReal[]){-sign * slope[0] / length, -sign * slope[1] / length, sign / length},
           sign * (height - x[2]) / length, PETSC_TRUE, cut);
  }
}

PetscBool MpmRegionCut(MpmRegion region, const PetscReal x[], const PetscReal half[], PetscReal normal[],
                       PetscReal *depth)
{
  const PetscInt dim               = region->dim;
  PetscReal      d[MPM_REGION_DIM] = {0., 0., 0.}, along = 0., norm;
  Cut            cut = {.half = half, .depth = PETSC_INFINITY};

  for (PetscInt a = 0; a < dim; a++) {
    d[a] = x[a] - region->center[a];
    along += d[a] * region->axis[a];
  }
  if (region->type == MPM_REGION_POLYGON) CutByPolygon(region, x, &cut);
  if (region->type == MPM_REGION_LAYERS) CutByLayer(region, x, &cut);
  if (region->ground) CutByGround(region, x, &cut);
  if (region->type == MPM_REGION_CYLINDER) {
    for (PetscInt a = 0; a < dim; a++) {
      d[a] -= along * region->axis[a];
      normal[a] = -region->axis[a];
    }
    if (region->length >= 0.) {
      Nearer(region, normal, along, PETSC_TRUE, &cut);
      Nearer(region, region->axis, region->length - along, PETSC_TRUE, &cut);
    }
  }
  if (region->type == MPM_REGION_SPHERE || region->type == MPM_REGION_CYLINDER) {
    norm = Norm(dim, d);
    for (PetscInt a = 0; a < dim; a++) normal[a] = norm > 0. ? d[a] / norm : 0.;
    if (norm > 0.) Nearer(region, normal, region->radius - norm, PETSC_FALSE, &cut);
  }
  for (PetscInt a = 0; a < dim; a++) normal[a] = cut.normal[a];
  *depth = cut.depth;
  return (PetscBool)(cut.depth < PETSC_INFINITY);
}

#define CLOSE  1e-4 /* of a half-length */
#define HALVES 52

PetscBool MpmRegionEnd(MpmRegion region, const PetscReal x[], PetscInt axis, PetscInt side, PetscReal half,
                       PetscReal *end)
{
  const PetscReal sign               = side ? 1. : -1.;
  PetscReal       at[MPM_REGION_DIM] = {0., 0., 0.}, inside = 0., outside = 2. * half * (1. + CLOSE);
  PetscBool       near, far, beyond;

  for (PetscInt a = 0; a < region->dim; a++) at[a] = x[a];
  at[axis] = x[axis] + sign * half * (1. - CLOSE);
  near     = MpmRegionContains(region, at);
  at[axis] = x[axis] + sign * half * (1. + CLOSE);
  far      = MpmRegionContains(region, at);
  at[axis] = x[axis] + sign * outside;
  beyond   = MpmRegionContains(region, at);
  if (beyond || (near && !far)) return PETSC_FALSE;
  for (PetscInt k = 0; k < HALVES; k++) {
    const PetscReal middle = 0.5 * (inside + outside);

    at[axis] = x[axis] + sign * middle;
    if (MpmRegionContains(region, at)) inside = middle;
    else outside = middle;
  }
  *end = inside - region->tolerance[axis];
  return PETSC_TRUE;
}

PetscBool MpmRegionIsRound(MpmRegion region)
{
  return (PetscBool)(region->type == MPM_REGION_SPHERE || region->type == MPM_REGION_CYLINDER);
}

PetscBool MpmRegionClips(MpmRegion region, const PetscReal x[], PetscInt axis, PetscInt side)
{
  PetscReal at[MPM_REGION_DIM] = {0., 0., 0.}, normal[MPM_REGION_DIM];

  for (PetscInt a = 0; a < region->dim; a++) at[a] = x[a];
  at[axis] = region->clip[side][axis];
  return (PetscBool)(PetscAbsReal(at[axis]) < PETSC_INFINITY &&
                     MpmRegionToRound(region, at, normal) > region->tolerance[axis]);
}

PetscReal MpmRegionToRound(MpmRegion region, PetscReal at[], PetscReal normal[])
{
  const PetscInt dim               = region->dim;
  PetscReal      d[MPM_REGION_DIM] = {0., 0., 0.}, along = 0., norm;

  for (PetscInt a = 0; a < dim; a++) {
    d[a] = at[a] - region->center[a];
    along += d[a] * region->axis[a];
  }
  for (PetscInt a = 0; region->type == MPM_REGION_CYLINDER && a < dim; a++) d[a] -= along * region->axis[a];
  norm = Norm(dim, d);
  for (PetscInt a = 0; a < dim; a++) {
    normal[a] = norm > 0. ? d[a] / norm : 0.;
    at[a] += (region->radius - norm) * normal[a];
  }
  return region->radius - norm;
}

PetscReal MpmRegionRadius(MpmRegion region)
{
  return region->radius;
}

/*
  Distances from the shapes that need no search (triangles: triangles.c).
*/
#include "maps/bed.h"
#include "geometry/solid.h"
#include "geometry/solid_types.h"
#include "geometry/triangles.h"

#include <math.h>

#define STRAIGHT 1e-9  /* sine of the angle between two edges that are one */
#define NOISE    1e-15 /* of a place's distance from an axis, over that from a point of the axis */
#define TIE      1e-10 /* of sizes: smaller differences of distance are ties, of which the first counts */

/* Component of r across an axis, and along; rounding errors become 0. */
static PetscReal SplitAlong(PetscInt dim, const PetscReal axis[], PetscReal r[])
{
  PetscReal along = 0., square = 0., across = 0.;

  for (PetscInt a = 0; a < dim; a++) along += r[a] * axis[a];
  for (PetscInt a = 0; a < dim; a++) {
    square += r[a] * r[a];
    r[a] -= along * axis[a];
    across += r[a] * r[a];
  }
  for (PetscInt a = 0; across <= NOISE * NOISE * square && a < dim; a++) r[a] = 0.;
  return along;
}

/* ---- box ---- */

/*
  With q = |x - centre| - half lengths: outside, the distance from the nearest place of a face (one q > 0), an edge
  (two) or a corner, round the latter two; inside, the nearest face counts. A symmetric load puts places on the
  diagonals inside and on the edges: rounding must not choose there, since it differs between ranks.
*/
static void BoxDistance(const MpmSolid *solid, const PetscReal r[], MpmSurface *surface)
{
  const PetscInt dim            = solid->dim;
  PetscReal      q[MPM_MAX_DIM] = {0., 0., 0.}, beyond[MPM_MAX_DIM] = {0., 0., 0.};
  PetscInt       outside = 0, nearest = 0;

  for (PetscInt a = 0; a < dim; a++) {
    const PetscReal tie = TIE * (solid->half[a] + solid->half[nearest]);

    q[a] = PetscAbsReal(r[a]) - solid->half[a];
    if (q[a] > q[nearest] + tie) nearest = a;
    if (q[a] <= tie) continue;
    outside++;
    beyond[a] = r[a] < 0. ? -q[a] : q[a];
  }
  if (outside < 2) {
    surface->distance        = q[nearest];
    surface->normal[nearest] = r[nearest] < 0. ? -1. : 1.;
    return;
  }
  MpmSurfaceRound(dim, beyond, 0., NULL, surface);
  for (PetscInt a = 0; a < dim; a++) /* along an edge it is straight */
    if (beyond[a] == 0.) surface->second[a][a] = 0.;
}

/* ---- cone ---- */

/* The nearest feature in the plane through the axis: the tip, the flank, the shoulder where the shaft begins, the
   shaft. */
typedef struct {
  PetscReal distance, across, along, curvature; /* the gradient's parts; curvature in this plane */
} Profile;

/*
  The profile in (rho, s), distance from the axis and along it from the tip: a flank from (0, 0) to (R, H), then a shaft
  of radius R. The profile is convex: inside, the nearer of flank and shaft counts; outside, corners are round.
*/
static Profile ConeProfile(const MpmSolid *solid, PetscReal rho, PetscReal s)
{
  const PetscReal sine = solid->slope[0], cosine = solid->slope[1], R = solid->radius, H = R * cosine / sine;
  const PetscReal up = rho * sine + s * cosine, off = rho * cosine - s * sine;
  const Profile   flank = {off, cosine, -sine, 0.}, shaft = {rho - R, 1., 0., 0.};
  PetscReal       corner[2] = {rho, s}, length;

  if (rho == 0. && s == 0.) return (Profile){0., 0., -1., 0.}; /* the tip looks along the axis */
  if (off <= 0. && rho <= R) return off > rho - R ? flank : shaft;
  if (s >= H) return shaft;
  if (up > 0. && up < R / sine) return flank;
  if (up > 0.) {
    corner[0] = rho - R;
    corner[1] = s - H;
  }
  length = hypot(corner[0], corner[1]);
  return (Profile){length, corner[0] / length, corner[1] / length, 1. / length};
}

/*
  A cone with a shaft above, endless; in 2D a wedge. With the profile's distance d(rho, s), e the direction away from
  the axis, a the axis and, in 3D, t the direction round it:

    grad d = d_rho e + d_s a ,   second derivative = curvature (I - n n^T) in the plane of e and a + d_rho/rho t t^T .

  On the axis d_rho/rho is the curvature below the tip, and 0 within.
*/
static void ConeDistance(const MpmSolid *solid, PetscReal r[], MpmSurface *surface)
{
  const PetscInt   dim  = solid->dim;
  const PetscReal *axis = solid->direction, s = SplitAlong(dim, axis, r);
  MpmSurface       away = {0}; /* from the axis */
  Profile          profile;
  PetscReal        round;

  MpmSurfaceRound(dim, r, 0., axis, &away);
  profile           = ConeProfile(solid, away.distance, s);
  round             = away.distance > 0. ? profile.across / away.distance : profile.curvature;
  surface->distance = profile.distance;
  for (PetscInt a = 0; a < dim; a++) surface->normal[a] = profile.across * away.normal[a] + profile.along * axis[a];
  for (PetscInt a = 0; a < dim; a++) {
    for (PetscInt b = 0; b < dim; b++) {
      const PetscReal plane = away.normal[a] * away.normal[b] + axis[a] * axis[b];

      surface->second[a][b] = profile.curvature * (plane - surface->normal[a] * surface->normal[b]);
      if (dim == 3) surface->second[a][b] += round * ((a == b ? 1. : 0.) - plane);
    }
  }
}

/* ---- polygon ---- */

/* True where the place is inside the polygon: an odd number of edges cross the ray from it along +x. */
static PetscBool InPolygon(PetscInt n, const PetscReal v[], const PetscReal x[])
{
  PetscBool inside = PETSC_FALSE;

  for (PetscInt i = 0; i < n; i++) {
    const PetscReal *p = &v[2 * i], *q = &v[2 * ((i + 1) % n)];

    if ((p[1] > x[1]) != (q[1] > x[1]) && x[0] < p[0] + (q[0] - p[0]) * (x[1] - p[1]) / (q[1] - p[1])) inside = !inside;
  }
  return inside;
}

/* The mean of the normals of the edges that meet at a vertex; a vertex within a straight edge is not round. */
static void VertexNormal(const MpmSolid *solid, PetscInt vertex, const PetscReal r[], MpmSurface *surface)
{
  const PetscInt   n = solid->vertex_count;
  const PetscReal *v = solid->vertices, *p = &v[2 * ((vertex + n - 1) % n)], *q = &v[2 * vertex],
                  *s = &v[2 * ((vertex + 1) % n)];
  const PetscReal in = hypot(q[0] - p[0], q[1] - p[1]), out = hypot(s[0] - q[0], s[1] - q[1]);
  const PetscReal edge[2][2] = {{(q[0] - p[0]) / in, (q[1] - p[1]) / in}, {(s[0] - q[0]) / out, (s[1] - q[1]) / out}};
  const PetscReal turn       = edge[0][0] * edge[1][1] - edge[0][1] * edge[1][0];

  if (PetscAbsReal(turn) < STRAIGHT) {
    for (PetscInt a = 0; a < 2; a++)
      for (PetscInt b = 0; b < 2; b++) surface->second[a][b] = 0.;
  }
  if (r[0] != 0. || r[1] != 0.) return;
  const PetscReal length = hypot(edge[0][0] + edge[1][0], edge[0][1] + edge[1][1]);

  surface->normal[0] = (edge[0][1] + edge[1][1]) / length;
  surface->normal[1] = -(edge[0][0] + edge[1][0]) / length;
}

/* The nearest edge counts; beyond its ends, the vertex, which is round. */
static void PolygonDistance(const MpmSolid *solid, const PetscReal x[], MpmSurface *surface)
{
  const PetscInt   n       = solid->vertex_count;
  const PetscReal *v       = solid->vertices;
  PetscInt         nearest = -1;
  PetscReal        best    = PETSC_INFINITY;

  for (PetscInt i = 0; i < n; i++) {
    const PetscReal *p = &v[2 * i], *q = &v[2 * ((i + 1) % n)], dx = q[0] - p[0], dy = q[1] - p[1];
    const PetscReal  length = hypot(dx, dy), along = ((x[0] - p[0]) * dx + (x[1] - p[1]) * dy) / length;
    const PetscReal  across = ((x[0] - p[0]) * dy - (x[1] - p[1]) * dx) / length,
                    corner  = hypot(x[0] - p[0], x[1] - p[1]);

    if (corner < best) {
      best    = corner;
      nearest = i;
    }
    if (along > 0. && along < length && PetscAbsReal(across) <= best - (nearest < 0 ? TIE * length : 0.)) {
      best               = PetscAbsReal(across);
      nearest            = -1;
      surface->distance  = across;
      surface->normal[0] = dy / length;
      surface->normal[1] = -dx / length;
    }
  }
  if (nearest < 0) return;
  const PetscReal r[MPM_MAX_DIM] = {x[0] - v[2 * nearest], x[1] - v[2 * nearest + 1], 0.};

  MpmSurfaceRound(2, r, 0., NULL, surface);
  if (best > 0. && InPolygon(n, v, x)) MpmSurfaceFlip(2, surface);
  VertexNormal(solid, nearest, r, surface);
}

/* ---- from outside the tree ---- */

static void AddedDistance(const MpmAddedBody *added, const PetscReal x[], MpmSurface *surface)
{
  MpmContactDistance seen = {0};

  added->type->distance(&added->body, x, &seen);
  surface->distance = seen.distance;
  for (PetscInt a = 0; a < added->body.dim; a++) {
    surface->normal[a] = seen.normal[a];
    for (PetscInt b = 0; b < added->body.dim; b++) surface->second[a][b] = seen.second[a][b];
  }
}

/* ---- all ---- */

void MpmSolidDistance(const MpmSolid *solid, PetscReal growth, const PetscReal x[], MpmSurface *surface)
{
  const PetscInt dim            = solid->dim;
  PetscReal      r[MPM_MAX_DIM] = {0., 0., 0.}, along = 0.;

  *surface = (MpmSurface){0};
  for (PetscInt a = 0; a < dim; a++) {
    r[a] = x[a] - solid->point[a];
    along += r[a] * solid->direction[a];
  }
  switch (solid->type) {
  case MPM_SOLID_PLANE:
    surface->distance = along;
    for (PetscInt a = 0; a < dim; a++) surface->normal[a] = solid->direction[a];
    break;
  case MPM_SOLID_BOX:
    BoxDistance(solid, r, surface);
    break;
  case MPM_SOLID_SPHERE:
    MpmSurfaceRound(dim, r, solid->radius + growth, NULL, surface);
    break;
  case MPM_SOLID_CYLINDER:
    (void)SplitAlong(dim, solid->direction, r);
    MpmSurfaceRound(dim, r, solid->radius + growth, solid->direction, surface);
    break;
  case MPM_SOLID_CONE:
    ConeDistance(solid, r, surface);
    break;
  case MPM_SOLID_POLYGON:
    PolygonDistance(solid, x, surface);
    break;
  case MPM_SOLID_STL:
    MpmTrianglesDistance(solid->triangles, x, surface);
    break;
  case MPM_SOLID_TERRAIN:
    MpmBedDistance(solid->bed, x, &surface->distance, surface->normal, surface->second);
    break;
  case MPM_SOLID_ADDED:
    AddedDistance(solid->added, x, surface);
    break;
  }
  if (solid->side < 0.) MpmSurfaceFlip(dim, surface);
}

PetscBool MpmSolidHasFaces(const MpmSolid *solid)
{
  switch (solid->type) {
  case MPM_SOLID_BOX:
  case MPM_SOLID_POLYGON:
  case MPM_SOLID_STL:
    return PETSC_TRUE;
  case MPM_SOLID_CONE:
    return (PetscBool)(solid->dim == 2);
  default:
    return PETSC_FALSE;
  }
}

/*
  Distance from a closed surface of triangles.

  The nearest place of the surface is within a triangle, on an edge or at a vertex. The side of x follows from the
  triangle's normal, from the sum of those of the edge's two triangles, or from that of all at the vertex, each times
  its angle there (Baerentzen and Aanaes 2005, doi:10.1109/TVCG.2005.49). triangles_check.c verifies that the surface is
  closed.
*/
#include "geometry/triangles.h"
#include "geometry/triangles_impl.h"

#include <math.h>

#define FLAT  1e-6 /* angle within which a direction is that of a normal, or at right angles to an edge */
#define NOISE 8.   /* rounding of a place, in units of the last digit of the largest coordinate */

PetscBool MpmTrianglesSupported(void)
{
  return MpmNearestSupported();
}

PetscErrorCode MpmTrianglesDestroy(MpmTriangles *triangles)
{
  PetscFunctionBeginUser;
  if (!*triangles) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmNearestDestroy(&(*triangles)->nearest));
  PetscCall(PetscFree((*triangles)->vertex));
  PetscCall(PetscFree((*triangles)->corner));
  PetscCall(PetscFree((*triangles)->twin));
  PetscCall(PetscFree((*triangles)->normal));
  PetscCall(PetscFree((*triangles)->vertex_normal));
  PetscCall(PetscFree(*triangles));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- set-up ---- */

/* Angle at a half-edge's start, from this edge to the one before. */
static PetscReal CornerAngle(MpmTriangles triangles, PetscInt half)
{
  PetscReal along[3], back[3], across[3];

  MpmTrianglesEdge(triangles, half, along);
  MpmTrianglesEdge(triangles, MpmHalfNext(MpmHalfNext(half)), back);
  MpmCross3(along, back, across);
  return PetscAtan2Real(MpmNorm3(across), -MpmDot3(along, back));
}

static PetscErrorCode SetVertexNormals(MpmTriangles triangles)
{
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(3 * (size_t)triangles->vertex_count, &triangles->vertex_normal));
  for (PetscInt half = 0; half < 3 * triangles->count; half++) {
    const PetscReal angle = CornerAngle(triangles, half);

    for (PetscInt a = 0; a < 3; a++)
      triangles->vertex_normal[3 * triangles->corner[half] + a] += angle * triangles->normal[3 * (half / 3) + a];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SetSearch(MpmTriangles triangles)
{
  PetscReal *boxes;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(6 * (size_t)triangles->count, &boxes));
  for (PetscInt t = 0; t < triangles->count; t++) {
    for (PetscInt a = 0; a < 3; a++) {
      const PetscReal p = MpmTrianglesCorner(triangles, 3 * t)[a], q = MpmTrianglesCorner(triangles, 3 * t + 1)[a],
                      r = MpmTrianglesCorner(triangles, 3 * t + 2)[a];

      boxes[6 * (size_t)t + (size_t)a]     = PetscMin(p, PetscMin(q, r));
      boxes[6 * (size_t)t + 3 + (size_t)a] = PetscMax(p, PetscMax(q, r));
    }
  }
  PetscCall(MpmNearestCreate(triangles->count, boxes, &triangles->nearest));
  PetscCall(PetscFree(boxes));
  for (PetscInt k = 0; k < 3 * triangles->vertex_count; k++)
    triangles->noise = PetscMax(triangles->noise, NOISE * PETSC_MACHINE_EPSILON * PetscAbsReal(triangles->vertex[k]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTrianglesCreate(PetscInt count, const PetscReal corners[], MpmTriangles *triangles, char message[])
{
  MpmTriangles made;

  PetscFunctionBeginUser;
  PetscCall(PetscNew(&made));
  PetscCall(MpmTrianglesConnect(made, count, corners, message));
  if (message[0]) PetscCall(MpmTrianglesDestroy(&made));
  else {
    PetscCall(SetVertexNormals(made));
    PetscCall(SetSearch(made));
  }
  *triangles = made;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Of the tetrahedra from one of the vertices. */
void MpmTrianglesCentroid(MpmTriangles triangles, PetscReal centroid[MPM_MAX_DIM])
{
  const PetscReal *from  = triangles->vertex;
  PetscReal        total = 0., moment[3] = {0., 0., 0.};

  for (PetscInt t = 0; t < triangles->count; t++) {
    PetscReal arm[3][3], area[3], volume;

    for (PetscInt k = 0; k < 3; k++)
      for (PetscInt a = 0; a < 3; a++) arm[k][a] = MpmTrianglesCorner(triangles, 3 * t + k)[a] - from[a];
    MpmCross3(arm[0], arm[1], area);
    volume = MpmDot3(area, arm[2]);
    total += volume;
    for (PetscInt a = 0; a < 3; a++) moment[a] += volume * (arm[0][a] + arm[1][a] + arm[2][a]) / 4.;
  }
  for (PetscInt a = 0; a < 3; a++) centroid[a] = from[a] + moment[a] / total;
}

/* ---- one triangle ---- */

typedef enum { FACE, EDGE, VERTEX } Kind;

/* The nearest place of a triangle: of its face, on an edge or at the vertex where that edge begins; r from it to x. */
typedef struct {
  Kind      kind;
  PetscInt  half;
  PetscReal r[3], square;
} Place;

/* On one edge of the triangle, ends included. */
static Place OnEdge(MpmTriangles triangles, PetscInt half, const PetscReal x[])
{
  const PetscReal *p     = MpmTrianglesCorner(triangles, half);
  Place            place = {.kind = VERTEX, .half = half};
  PetscReal        edge[3], along;

  MpmTrianglesEdge(triangles, half, edge);
  for (PetscInt a = 0; a < 3; a++) place.r[a] = x[a] - p[a];
  along = MpmDot3(place.r, edge) / MpmDot3(edge, edge);
  if (along >= 1.) {
    place.half = MpmHalfNext(half);
    p          = MpmTrianglesCorner(triangles, place.half);
    for (PetscInt a = 0; a < 3; a++) place.r[a] = x[a] - p[a];
  } else if (along > 0.) {
    place.kind = EDGE;
    for (PetscInt a = 0; a < 3; a++) place.r[a] -= along * edge[a];
  }
  place.square = MpmDot3(place.r, place.r);
  return place;
}

static Place OnTriangle(MpmTriangles triangles, PetscInt t, const PetscReal x[])
{
  const PetscReal *normal = &triangles->normal[3 * t];
  Place            place  = {.kind = FACE, .half = 3 * t, .square = PETSC_INFINITY};
  PetscReal        r[3], height;

  for (PetscInt half = 3 * t; half < 3 * t + 3; half++) {
    PetscReal edge[3], inward[3];

    MpmTrianglesEdge(triangles, half, edge);
    MpmCross3(normal, edge, inward);
    for (PetscInt a = 0; a < 3; a++) r[a] = x[a] - MpmTrianglesCorner(triangles, half)[a];
    if (MpmDot3(inward, r) >= 0.) continue;
    const Place other = OnEdge(triangles, half, x);

    if (other.square < place.square) place = other;
  }
  if (place.kind != FACE) return place;
  height = MpmDot3(normal, r);
  for (PetscInt a = 0; a < 3; a++) place.r[a] = height * normal[a];
  place.square = height * height;
  return place;
}

static PetscReal SquareOf(const void *ctx, PetscInt t, const PetscReal x[MPM_MAX_DIM])
{
  return OnTriangle((MpmTriangles)ctx, t, x).square;
}

/* ---- the surface there ---- */

/* True where this is the direction of the triangle's normal, either way. */
static PetscBool IsNormal(MpmTriangles triangles, PetscInt half, const PetscReal n[])
{
  PetscReal across[3];

  MpmCross3(&triangles->normal[3 * (half / 3)], n, across);
  return (PetscBool)(MpmNorm3(across) <= FLAT);
}

/*
  Round directions at an edge or a vertex, for a place in the direction n: 0 (the place stands above a face as well), 1
  (round an edge, whose direction is returned) or 2 (round the vertex).
*/
static PetscInt Roundness(MpmTriangles triangles, const Place *place, const PetscReal n[], PetscReal along[])
{
  PetscInt half = place->half, round = 2;

  if (place->kind == EDGE) {
    MpmTrianglesEdge(triangles, half, along);
    return IsNormal(triangles, half, n) || IsNormal(triangles, triangles->twin[half], n) ? 0 : 1;
  }
  do {
    PetscReal edge[3];

    if (IsNormal(triangles, half, n)) return 0;
    MpmTrianglesEdge(triangles, half, edge);
    if (PetscAbsReal(MpmDot3(edge, n)) <= FLAT * MpmNorm3(edge)) {
      round = 1;
      for (PetscInt a = 0; a < 3; a++) along[a] = edge[a];
    }
    half = MpmHalfNext(triangles->twin[half]);
  } while (half != place->half);
  return round;
}

/* The direction outwards at the nearest place, of any length: its product with r has the sign of the distance. */
static void PseudoNormal(MpmTriangles triangles, const Place *place, PetscReal pseudo[])
{
  const PetscInt one = place->half / 3, other = triangles->twin[place->half] / 3;

  for (PetscInt a = 0; a < 3; a++) {
    pseudo[a] = triangles->normal[3 * one + a];
    if (place->kind == EDGE) pseudo[a] += triangles->normal[3 * other + a];
    if (place->kind == VERTEX) pseudo[a] = triangles->vertex_normal[3 * triangles->corner[place->half] + a];
  }
}

void MpmTrianglesDistance(MpmTriangles triangles, const PetscReal x[MPM_MAX_DIM], MpmSurface *surface)
{
  const PetscInt t = MpmNearestFind(triangles->nearest, SquareOf, triangles, x);
  PetscReal      pseudo[3], along[3] = {0., 0., 0.}, length;
  PetscInt       round;

  *surface = (MpmSurface){0};
  if (t < 0) { /* x is no place */
    surface->distance = x[0] + x[1] + x[2];
    return;
  }
  const Place place = OnTriangle(triangles, t, x);

  PseudoNormal(triangles, &place, pseudo);
  length = PetscSqrtReal(place.square);
  if (place.kind == FACE ||
      length <= triangles->noise) { /* the direction of r is that of the normal, or rounding alone */
    length = MpmNorm3(pseudo);
    for (PetscInt a = 0; a < 3; a++) surface->normal[a] = pseudo[a] / length;
    surface->distance = MpmDot3(place.r, surface->normal);
    return;
  }
  if (MpmDot3(place.r, pseudo) < 0.) length = -length;
  surface->distance = length;
  for (PetscInt a = 0; a < 3; a++) surface->normal[a] = place.r[a] / length;
  round = Roundness(triangles, &place, surface->normal, along);
  for (PetscInt a = 0; round && a < 3; a++)
    for (PetscInt b = 0; b < 3; b++) {
      surface->second[a][b] = ((a == b ? 1. : 0.) - surface->normal[a] * surface->normal[b]) / length;
      if (round == 1) surface->second[a][b] -= along[a] * along[b] / (MpmDot3(along, along) * length);
    }
}

#pragma once
/*
  Shared by triangles.c and triangles_check.c: vertices and half-edges.

  A half-edge h runs from corner h to the next corner of triangle h/3, counterclockwise as seen from outside; its twin
  is that edge in the neighbouring triangle, in the other direction.
*/
#include "geometry/nearest.h"
#include "geometry/triangles.h"

struct _p_MpmTriangles {
  PetscInt   count, vertex_count;
  PetscReal *vertex;        /* places, m */
  PetscInt  *corner, *twin; /* by half-edge */
  PetscReal *normal;        /* of triangles, unit vectors */
  PetscReal *vertex_normal; /* sums of those times angles */
  PetscReal  noise;         /* rounding of places, m */
  MpmNearest nearest;
};

/* Vertices, half-edges and normals, from the corners of triangles; or their fault. */
PetscErrorCode MpmTrianglesConnect(MpmTriangles triangles, PetscInt count, const PetscReal corners[], char message[]);

static inline PetscInt MpmHalfNext(PetscInt half)
{
  return half % 3 == 2 ? half - 2 : half + 1;
}

static inline const PetscReal *MpmTrianglesCorner(MpmTriangles triangles, PetscInt half)
{
  return &triangles->vertex[3 * triangles->corner[half]];
}

/* The vector along a half-edge. */
static inline void MpmTrianglesEdge(MpmTriangles triangles, PetscInt half, PetscReal edge[3])
{
  const PetscReal *p = MpmTrianglesCorner(triangles, half), *q = MpmTrianglesCorner(triangles, MpmHalfNext(half));

  for (PetscInt a = 0; a < 3; a++) edge[a] = q[a] - p[a];
}

static inline PetscReal MpmDot3(const PetscReal a[3], const PetscReal b[3])
{
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline PetscReal MpmNorm3(const PetscReal a[3])
{
  return PetscSqrtReal(MpmDot3(a, a));
}

static inline void MpmCross3(const PetscReal a[3], const PetscReal b[3], PetscReal c[3])
{
  c[0] = a[1] * b[2] - a[2] * b[1];
  c[1] = a[2] * b[0] - a[0] * b[2];
  c[2] = a[0] * b[1] - a[1] * b[0];
}

#pragma once
/*
  MpmTriangles - a closed surface of triangles, and the distance from it.

  Order of calls: MpmTrianglesCreate(), MpmTrianglesDistance(), MpmTrianglesDestroy().
*/
#include "geometry/surface.h"

typedef struct _p_MpmTriangles *MpmTriangles;

/* True where this build has the library that searches them. */
PetscBool MpmTrianglesSupported(void);

#define MPM_TRIANGLES_MESSAGE 512
/*@
  MpmTrianglesCreate - make a closed surface of triangles, and the data of its distances

  Not collective; with equal triangles all ranks have equal results

  Input Parameters:
+ count   - number of triangles
- corners - nine coordinates a triangle, m; seen from outside, corners go round counterclockwise

  Output Parameters:
+ triangles - the surface
- message   - a fault, naming triangle and places; MPM_TRIANGLES_MESSAGE bytes, left as they are without a fault

  Notes: Corners are one vertex where their coordinates are equal. Refused are: a triangle without area; an edge that
  belongs to one triangle (the surface is open), to two that disagree about the outside, or to more; a vertex where
  parts of the surface touch; and a closed part whose inside is not the inside of the whole (turned inside out, or
  within another part; a cavity is fine). Triangles that cross one another are not detected.
@*/
PetscErrorCode MpmTrianglesCreate(PetscInt count, const PetscReal corners[], MpmTriangles *triangles, char message[]);
PetscErrorCode MpmTrianglesDestroy(MpmTriangles *triangles);
/* Of the enclosed volume. */
void MpmTrianglesCentroid(MpmTriangles triangles, PetscReal centroid[MPM_MAX_DIM]);
/*
  Distance of x, positive outside; exact in double precision. Edges and vertices are round, and so is the second
  derivative; zero on flat parts, triangulated as they may be.
*/
void MpmTrianglesDistance(MpmTriangles triangles, const PetscReal x[MPM_MAX_DIM], MpmSurface *surface);

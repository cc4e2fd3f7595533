#pragma once
/*
  Parts of polygons in rectangles, and integrals of maps over them.
*/
#include "maps/map.h"
#include "maps/outline.h"

/* Area, its first moments, and the volume of depth over it: m2, m3, m3. */
typedef struct {
  PetscReal area, moment[2], volume;
} MpmPart;

/* Vertices of rings one after the other: ring k has those from start[k] to start[k + 1] - 1. Start from zeros. */
typedef struct {
  PetscInt   rings, ring_room, vertex_room;
  PetscInt  *start;
  PetscReal *at;
} MpmRings;

/* Keeps of a ring what has sign (x[axis] - at) >= 0, m; returns the number of vertices, at most twice as many. */
PetscInt MpmRingCut(PetscInt count, const PetscReal v[], PetscInt axis, PetscReal sign, PetscReal at, PetscReal kept[]);

PetscErrorCode MpmRingsDestroy(MpmRings *rings);
/* The rings of a polygon of an outline. */
PetscErrorCode MpmRingsTake(const MpmOutline *outline, PetscInt feature, MpmRings *rings);
/* Parts of rings between two places along an axis; edges that run back and forth at a cut enclose nothing. */
PetscErrorCode MpmRingsCut(const MpmRings *rings, PetscInt axis, PetscReal lower, PetscReal upper, MpmRings *part);

/*
  Adds the part in a rectangle of the rings of one polygon: area, moments, and volume, the exact integral of the
  map between the centres of its pixels, or of the depth where the map has no pixels. Spare rings give room.
*/
PetscErrorCode MpmPartAdd(const MpmRings *rings, const PetscReal lower[2], const PetscReal upper[2], const MpmMap *map,
                          PetscReal depth, MpmRings spare[2], MpmPart *part);

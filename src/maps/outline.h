#pragma once
/*
  Outlines: points, lines and polygons in the plane, with attributes.

  GeoJSON is read by this program. Shapefiles, GeoPackages and other formats go through GDAL's library.
*/
#include "base/base.h"

typedef enum { MPM_OUTLINE_POINT, MPM_OUTLINE_LINE, MPM_OUTLINE_POLYGON } MpmOutlineType;

/* One or several points, lines or polygons that have attributes together. */
typedef struct {
  MpmOutlineType type;
  PetscInt       first, end; /* paths [first, end): points, lines, or rings */
} MpmFeature;

/*
  Start from zeros. Path k has the vertices start[k] to start[k + 1] - 1, with x and y of vertex v in at[2 v] and
  at[2 v + 1]. Rings end before their first vertex comes again; outer ones turn left, holes right, and no two edges
  cross.
*/
typedef struct MpmOutline {
  PetscInt    features, paths, names;
  MpmFeature *feature;
  PetscInt   *start;
  PetscReal  *at;     /* m, less the local origin */
  char      **name;   /* of attributes */
  char      **value;  /* [feature*names + name]; NULL: the feature has none */
  char       *system; /* coordinate system as text; NULL: unknown */
} MpmOutline;

/* System in which an outline must be, and how it gets there. */
typedef struct {
  const char *project;   /* brought to this system; NULL: as the file has it */
  const char *system;    /* of the map beside it; NULL: unknown */
  PetscReal   origin[2]; /* local origin, taken off */
} MpmOutlineAsk;

/*
  Reads all features of a file, in all layers. Not collective. A fault of the file goes into `message` (of
  MPM_MAP_MESSAGE bytes), which stays as it is where there is none: other systems than the map's without `project`,
  degrees, rings of fewer than three vertices, and edges of polygons that cross are refused.
*/
PetscErrorCode MpmOutlineRead(const char *path, const MpmOutlineAsk *ask, MpmOutline *outline, char message[]);
PetscErrorCode MpmOutlineDestroy(MpmOutline *outline);
/* True where a polygon of the feature holds the place, outside its holes; feature -1: any one. */
PetscBool MpmOutlineHolds(const MpmOutline *outline, PetscInt feature, const PetscReal x[]);
/* Distance from a place to the nearest edge, line or point, m. */
PetscReal MpmOutlineDistance(const MpmOutline *outline, const PetscReal x[]);
/* An attribute, or NULL; and as a number, PETSC_FALSE where it is none. */
const char *MpmOutlineText(const MpmOutline *outline, PetscInt feature, const char *name);
PetscBool   MpmOutlineNumber(const MpmOutline *outline, PetscInt feature, const char *name, PetscReal *number);
/* Least rectangle about all vertices. */
void MpmOutlineBounds(const MpmOutline *outline, PetscReal lower[2], PetscReal upper[2]);

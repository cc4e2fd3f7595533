#pragma once
/*
  Shared by the readers of outlines.
*/
#include "maps/gdal.h"
#include "maps/outline.h"

/* Adds a feature without paths; to the last feature a path or an attribute; to the last path a vertex. */
PetscErrorCode MpmOutlineAddFeature(MpmOutline *outline, MpmOutlineType type);
PetscErrorCode MpmOutlineAddPath(MpmOutline *outline);
PetscErrorCode MpmOutlineAddVertex(MpmOutline *outline, PetscReal x, PetscReal y);
PetscErrorCode MpmOutlineAddAttribute(MpmOutline *outline, const char *name, const char *value);
/* Closes the last path, of a polygon: the first ring is the outer one. */
PetscErrorCode MpmOutlineEndRing(MpmOutline *outline, PetscBool outer, char message[]);
/* Brings the vertices to the system that is asked for (outline_system.c). */
PetscErrorCode MpmOutlineProject(const MpmOutlineAsk *ask, MpmOutline *outline, char message[]);
/* Complains where edges of polygons cross (outline_check.c). */
PetscErrorCode MpmOutlineCheck(const MpmOutline *outline, char message[]);

/* The file as GeoJSON, or by GDAL. */
PetscErrorCode MpmGeoJsonRead(char *text, MpmOutline *outline, char message[]);
PetscErrorCode MpmOutlineReadByGdal(const MpmGdal *gdal, const char *path, MpmOutline *outline, char message[]);

#pragma once
/*
  Lines of ground in a vertical plane, y over x: a surface or an interface of layers. A line goes on level beyond its
  ends, and may rise or fall at one x.
*/
#include "base/base.h"
#include "base/types.h"

typedef struct {
  PetscInt   count; /* vertices; 0: no line, at minus infinity */
  PetscReal *at;    /* x and y of each, m; x does not decrease */
} MpmPolyline;

/*
  Reads -<prefix><name>: "x0,y0,x1,y1,...", or one number, a level. Fails with MPM_ERR_INPUT where x decreases or a
  vertex is repeated; no line where the option is absent.
*/
PetscErrorCode MpmPolylineRead(const MpmOptions *options, const char *name, const char *help, MpmPolyline *line);
PetscErrorCode MpmPolylineDestroy(MpmPolyline *line);
/* Height at x, m; side -1: as x is reached from the left, 1: from the right. */
PetscReal MpmPolylineHeight(const MpmPolyline *line, PetscReal x, PetscInt side);
/* Least and largest height, m. */
void MpmPolylineBounds(const MpmPolyline *line, PetscReal *least, PetscReal *most);
/* The lower one of two lines at each x; the result is to be destroyed. */
PetscErrorCode MpmPolylineLower(const MpmPolyline *one, const MpmPolyline *other, MpmPolyline *lower);

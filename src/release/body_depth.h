#pragma once
/*
  Depths of a body's columns, in depth-averaged flow.
*/
#include "base/base.h"
#include "base/types.h"
#include "maps/bed.h"

typedef struct _p_MpmBodyDepth *MpmBodyDepth;
/*
  Reads -<prefix>depth, a number or a map, or -<prefix>level, the height to which the ground is filled. Heights of the
  bed are those that a point's own weights interpolate, by the shape and its edge.
*/
PetscErrorCode MpmBodyDepthCreate(const MpmOptions *block, const MpmBed *bed, MpmShapeType shape, MpmEdgeType edge,
                                  MpmBodyDepth *depth);
PetscErrorCode MpmBodyDepthDestroy(MpmBodyDepth *depth);
/* Vertical depth at a point with a domain of these half-lengths, m; not > 0: there is none. */
PetscReal MpmBodyDepthAt(MpmBodyDepth depth, const MpmGrid *grid, const PetscReal x[], const PetscReal half[]);

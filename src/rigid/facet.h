#pragma once
/*
  Facets: faces that bound the material and may touch a rigid surface in a step.
*/
#include "base/base.h"
#include "base/types.h"

/* A face that meets an edge of a boundary is cut into so many slices on each axis. */
#define MPM_SLICES 4

/* Facets at one boundary whose keys agree but for `slice` form a patch; round and single ones are one each. */
typedef struct {
  PetscInt64 cell;   /* of the point's centre */
  PetscInt   corner; /* 0, or the id of the point whose edge or corner it is, and 1 */
  PetscInt   side;   /* 0, or of a flat face, which counts in this step, the axis and sense of its normal at rest */
  PetscInt   round;  /* on the round surface that cut its body's lattice (round_facets.c) */
  PetscInt   single; /* a patch by itself: an edge of the boundary is near (edge_facets.c) */
  PetscInt   slice;  /* 0, or 1 + its index, of a slice of a face that meets an edge */
  PetscInt   flows;  /* a point of material that flows (flow_facets.c) */
} MpmFacetKey;

/* A face of a point's domain that bounds the material and may touch a boundary in this step. */
typedef struct {
  PetscInt    boundary, point, group, weight; /* weight: where its weights at the nodes of the patch's box stand */
  MpmFacetKey key;
  PetscReal place[MPM_MAX_DIM], normal[MPM_MAX_DIM], slip[MPM_MAX_DIM]; /* at the step's start; the boundary's normal */
  PetscReal distance;                                                   /* at the step's start */
  PetscReal area;                                                       /* projected on the boundary, m^(dim-1) */
  PetscBool askew;   /* nearly perpendicular to the boundary; its area is faded out */
  PetscBool facing;  /* slice at the flat side that its face looked at before any deformation */
  PetscInt  piece;   /* index + 1 of the surface piece, 0: none */
  PetscReal portion; /* fraction of the piece's area; of round and single facets, of the touching area of its point */
  PetscReal touches; /* distance at which it touches, m: not 0 where the lattice of points was cut by the surface */
  PetscReal arm[MPM_MAX_DIM],
    turn; /* round: from the surface's centre; contribution of turning to its distance (Turn), m */
} MpmFacet;

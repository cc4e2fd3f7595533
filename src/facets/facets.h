#pragma once
/*
  The facets of a step: faces of the points, places on round surfaces, and shares of a boundary's own surface, that may
  touch rigid surfaces in it.
*/
#include "base/base.h"
#include "base/types.h"
#include "rigid/facet.h"
#include "rigid/rigid.h"

/* Angle to a face's normal below which a direction is along it: no step of a lattice. */
#define MPM_ALIGNED 1e-6

/* Values that a piece's point keeps from step to step. */
typedef enum {
  MPM_PIECE_GAP,
  MPM_PIECE_SLIP,
  MPM_PIECE_PRESSURE = MPM_PIECE_SLIP + MPM_MAX_DIM,
  MPM_PIECE_STRENGTH,
  MPM_PIECE_SLOTS
} MpmPieceSlot;

/* A piece of a boundary's surface along which material slides (surface_pieces.c). */
typedef struct {
  PetscInt  boundary, point, part, material; /* point: -1 on another rank */
  PetscInt  first[MPM_MAX_DIM], count[MPM_MAX_DIM];
  PetscReal line[MPM_MAX_DIM][16]; /* weights by axis, at these nodes */
  PetscReal area, place[MPM_MAX_DIM], normal[MPM_MAX_DIM];
  PetscReal modulus; /* scale of its penalty, Pa */
  PetscReal astray;  /* distance of the point from where it should be beside the surface, m */
  PetscReal kept[MPM_PIECE_SLOTS];
} MpmPiece;

/* This rank's pieces, and behind them those of the neighbours. */
typedef struct {
  PetscInt  own, count;
  MpmPiece *at;
} MpmPieces;

typedef struct MpmFaceBoxes MpmFaceBoxes; /* contact_search.h */

/* The boundaries as they stand in a step, and the facets of this rank's points. */
typedef struct {
  PetscInt           boundary_count;
  const MpmBoundary *boundaries;
  MpmPose           *before, *after; /* the boundaries' at the step's start and end */
  MpmRigidBody      *bodies;         /* those whose place is solved for, by boundary; NULL: there is none */
  const MpmBodies   *shaped;         /* the material's, or NULL */
  PetscBool         *cut;            /* by boundary: it cut the lattice of points at the start; NULL: not known yet */
  PetscBool         *drawn; /* in this step bilateral facets are pieces of the boundary's surface (surface_shares.c) */
  PetscReal          cell;  /* the smallest size of one, m */
  PetscReal          touch; /* distance below which a face touches: rounding, m */
  PetscInt           count, capacity;
  MpmFacet          *at;
  MpmPieces          pieces;
  MpmFaceBoxes      *boxes; /* of the step's points */
} MpmFacets;

/* The boundaries are borrowed. */
PetscErrorCode MpmFacetsCreate(PetscInt count, const MpmBoundary boundaries[], MpmFacets *facets);
PetscErrorCode MpmFacetsDestroy(MpmFacets *facets);
/* Poses of the boundaries at the start and the end of a step, s. */
void MpmFacetsSetPoses(MpmFacets *facets, PetscReal time_n, PetscReal time);
/* A step of these points begins. Collective. */
PetscErrorCode MpmFacetsBegin(MpmFacets *facets, const MpmGrid *grid, const MpmPoints *points);
/* Finds the facets anew, about where free bodies are expected to go (facets.c). Collective. */
PetscErrorCode MpmFacetsFind(MpmFacets *facets, const MpmRules *rules, const MpmPoints *points, const MpmSpace *space);
PetscErrorCode MpmFacetsAdd(MpmFacets *facets, const MpmFacet *facet);
/* The body whose place is solved for, or NULL. */
const MpmRigidBody *MpmFacetsBody(const MpmFacets *facets, PetscInt boundary);
/* The number of the cell of a place, of a part of the material; a cell of elements of order p counts as p^dim. */
PetscInt64 MpmFacetCell(const MpmGrid *grid, const PetscReal x[], PetscInt part);
/* Distance from a boundary as it stands at the step's start, or is expected to stand where it is free. */
void MpmFacetsDistance(const MpmFacets *facets, PetscInt boundary, const PetscReal x[], MpmSurface *surface);
/* As a facet with this outward area sees it; sets the facet's side and, of a boundary with faces, its distance. */
void MpmFacetStartDistance(const MpmFacets *facets, const PetscReal outward[], MpmFacet *facet, MpmSurface *surface);

/*
  Faces as they stood at the start (cut_lattice.c). FindCuts: which boundaries cut the lattice of points; collective.
  FindDrawn: whether faces in contact with a bilateral boundary that cut it have been drawn out or crowded; collective.
  TouchedAtStart: true where a face touched the boundary, with the distance that it keeps.
*/
PetscErrorCode MpmFacetsFindCuts(MpmFacets *facets, const MpmGrid *grid, const MpmPoints *points);
PetscErrorCode MpmFacetsFindDrawn(MpmFacets *facets, PetscInt boundary, const MpmGrid *grid, const MpmPoints *points);
PetscBool      MpmFaceTouchedAtStart(const MpmFacets *facets, PetscInt boundary, const MpmPoints *points, PetscInt p,
                                     PetscInt face, PetscReal *touches);

/* Faces of the point of `start` (face_facets.c), no farther from the boundary than `margin`; also round ones. */
PetscErrorCode MpmFacetsAddFaces(MpmFacets *facets, PetscReal margin, const MpmGrid *grid, const MpmPoints *points,
                                 const MpmFacet *start);
/*
  Round bodies of the material (round_facets.c). See: true where a face belongs to a round surface that the boundary
  accepts. Add then adds its facets, where they are no farther from the boundary than `margin`.
*/
PetscBool      MpmFacetsSeeRound(const MpmFacets *facets, const MpmPoints *points, PetscInt boundary, PetscInt p,
                                 PetscInt face);
PetscErrorCode MpmFacetsAddRound(MpmFacets *facets, PetscReal margin, const MpmPoints *points, PetscInt face,
                                 const MpmFacet *start);
/*
  A step whose forces balance at `part` of it: round facets of boundaries whose motion is prescribed touch where they
  are then, by the nodes' velocities v at the step's start, m/s, dim a node, as they turn until its end.
*/
PetscErrorCode MpmFacetsTurn(MpmFacets *facets, const MpmSum *sum, const PetscReal v[], PetscReal part);

/*
  Points of material that flows, in explicit steps (flow_facets.c). Flow: true of such a point, which has no other
  facets. AddFlowing: those that touch in this step; `all`: all materials flow.
*/
PetscBool      MpmFacetsFlow(const MpmRules *rules, const MpmPoints *points, PetscInt p);
PetscErrorCode MpmFacetsAddFlowing(MpmFacets *facets, PetscInt boundary, const MpmRules *rules, const MpmPoints *points,
                                   const MpmSpace *space, PetscBool *all);

/*
  Faces near an edge of the boundary (edge_facets.c), in cells of sizes h, m; `sides`: the vectors of half of a face's
  dim - 1 sides. AtEdge: marks a single facet, and returns the number of slices of its face, or 0. SlicePlace: from the
  face's middle to the slice's.
*/
PetscInt MpmFacetAtEdge(const MpmFacets *facets, const PetscReal h[], PetscReal (*sides)[MPM_MAX_DIM],
                        const MpmSurface *surface, MpmFacet *facet);
void     MpmFacetSlicePlace(PetscInt dim, PetscReal (*sides)[MPM_MAX_DIM], MpmFacet *slice);

/* Adds the shares of the points in the boundary's own surface as facets (surface_shares.c). Collective. */
PetscErrorCode MpmFacetsAddShares(MpmFacets *facets, PetscInt boundary, const MpmRules *rules, const MpmSpace *space,
                                  const MpmPoints *points);
/*
  Pieces of surfaces along which material slides (surface_pieces.c). Spread: the facets that are such pieces are
  replaced by those at the nodes, with those of neighbouring ranks. Boxes: of the neighbours' nodes. Load: what their
  points keep. All but boxes collective.
*/
PetscBool      MpmFacetsAreSpread(const MpmFacets *facets, PetscInt boundary);
PetscErrorCode MpmPiecesSpread(MpmFacets *facets, const MpmRules *rules, const MpmPoints *points,
                               const MpmSpace *space);
PetscErrorCode MpmPiecesAppendBoxes(const MpmFacets *facets, MpmSpace *space);
PetscErrorCode MpmPiecesLoad(MpmFacets *facets, const MpmTermStep *step);
/* By so much the material comes nearer in this step, m. */
PetscReal MpmPieceWayBack(const MpmFacets *facets, const MpmFacet *facet);
/* The nodes that a facet touches: those of its point's group, or of its piece. */
MpmGroup MpmFacetBox(const MpmFacets *facets, const MpmSpace *space, const MpmFacet *facet);

/* By axis, at the nodes of its point's group (facet_weights.c); `line` has room for MPM_MAX_WIDTH of them on each. */
void MpmFacetLines(const MpmRules *rules, const MpmSpace *space, const MpmPoints *points, const MpmFacet *facet,
                   PetscReal (*line)[16]);
/*
  Derivatives of these lines, for shapes with a domain and a facet that is no corner, slice or round: by the facet's
  place and by that of its point, the other one fixed, and by the half-length of the point's domain, all in cells.
*/
typedef struct {
  PetscReal by_place[MPM_MAX_DIM][16], by_point[MPM_MAX_DIM][16], by_length[MPM_MAX_DIM][16];
} MpmFacetSlopes;
void MpmFacetLineSlopes(const MpmRules *rules, const MpmSpace *space, const MpmPoints *points, const MpmFacet *facet,
                        MpmFacetSlopes *slopes);
/* Weights of a facet at the nodes of a box. */
void MpmFacetBoxWeights(const MpmFacets *facets, const MpmRules *rules, const MpmSpace *space, const MpmPoints *points,
                        const MpmFacet *facet, const MpmGroup *box, PetscReal weight[]);

#pragma once
/*
  Contact of the faces that bound the material with rigid surfaces: facets and patches of a step (contact_patches.c),
  and the term (rigid_contact.c).
*/
#include "base/base.h"
#include "base/types.h"
#include "rigid/facet.h"
#include "rigid/rigid.h"

extern const MpmTerm MpmTermContact;     /* rigid surfaces (rigid_contact.c); ctx: MpmContacts */
extern const MpmTerm MpmTermRigidBodies; /* those whose place is solved for (rigid_body.c); ctx: MpmContacts */

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

/* State of a patch. */
typedef enum { MPM_PATCH_OPEN, MPM_PATCH_STICKS, MPM_PATCH_SLIDES } MpmPatchState;

/* The facets of one cell at one boundary: one mean gap, one mean slip, one traction. */
typedef struct {
  PetscInt      boundary, begin, end, box; /* its facets, and the group that holds the nodes of them all */
  PetscReal     area, stiffness;           /* m^(dim-1), Pa/m */
  PetscReal     strength;                  /* in shear, of the material there at the step's start, Pa; or infinite */
  PetscBool     foreign; /* some of its facets are pieces of other ranks, which add their forces there */
  PetscBool     round;   /* a facet on a round surface, which touches by itself */
  PetscBool     direct;  /* in an explicit step: no equations are solved */
  PetscBool     broken;  /* of a bilateral boundary, which has let go: it pushes only */
  PetscBool     held;    /* touches whatever the law says (contact_states.c), and sticks, or */
  PetscBool     glides;  /* slides this way with the traction that goes with its pressure */
  PetscReal     way[MPM_MAX_DIM];
  MpmPatchState state;
  PetscReal     traction[MPM_MAX_DIM]; /* of Newton's last iterate */
  PetscReal     shift; /* augmented: so far behind, m, the penalty gives the pressure that holds it at 0 */
} MpmPatch;

/* Treatment of sliding by Newton's method (contact_states.c). */
typedef struct {
  PetscBool careful, secant; /* may take, and takes now, the secants of sliding patches */
  PetscBool holds;           /* and it holds patches, of any rank */
  PetscReal least;           /* stiffness of sliding along its direction, over that across (contact_law.h) */
  PetscReal raised;          /* augmented: stiffness in this step over that of the penalty */
  PetscReal deepest;         /* augmented: depth of the last correction over its tolerance */
  PetscReal give;            /* factor on the elastic slip of sticking patches in this attempt */
  PetscBool near;            /* in this step there are patches, of any rank */
  PetscBool bare;            /* there were none in the last step that was taken: points keep nothing of contact */
} MpmContactNewton;

typedef struct MpmFaceBoxes MpmFaceBoxes; /* contact_search.h */

/* Facets of this rank's points, and their patches. */
typedef struct MpmContacts {
  PetscInt           boundary_count;
  const MpmBoundary *boundaries;
  MpmPose           *before, *after; /* the boundaries' at the step's start and end */
  MpmRigidBody      *bodies;         /* those whose place is solved for, by boundary; NULL: there is none */
  const MpmBodies   *shaped;         /* the material's, or NULL */
  PetscInt           material_count;
  PetscInt           adrift; /* a body that met nothing on its way, or -1 */
  PetscReal (*reaction)[MPM_MAX_DIM],
    *depth;                         /* of the last step: forces on the material; deepest mean gaps behind, m */
  PetscReal (*moment)[MPM_MAX_DIM]; /* of those forces about the boundary's reference point */
  PetscBool *cut;                   /* by boundary: it cut the lattice of points at the start; NULL: not known yet */
  PetscBool *drawn; /* in this step bilateral facets are pieces of the boundary's surface (surface_shares.c) */
  PetscReal  cell;  /* the smallest size of one, m */
  PetscReal  touch,
    tilt; /* a patch no further away touches; so far may facets be off the surface where their patch is on it */
  const PetscReal *moved; /* explicit steps: displacements, contact having acted at others; or NULL */
  MpmContactNewton newton;
  PetscInt         facet_count, capacity, patch_count, most; /* most: facets of a patch */
  MpmFacet        *facet;
  MpmPatch        *patch;
  PetscInt         piece_own, piece_count; /* this rank's, and with the neighbours' */
  MpmPiece        *piece;
  PetscReal       *weight;
  MpmFaceBoxes    *boxes;   /* of the step's points */
  PetscBool        weighed; /* the weights are those of the facets that were found last */
} MpmContacts;

/*
  For explicit steps dt: patches become so soft that none pushes further than out of its surface in a step, by the
  masses of the local nodes (contact_patch.c).
*/
PetscErrorCode MpmContactsLimit(void *ctx, const MpmSum *sum, const PetscReal mass[], PetscReal dt);
/* The body whose place is solved for, or NULL. */
const MpmRigidBody *MpmContactsBody(const MpmContacts *contacts, PetscInt boundary);
/* The placement of such a boundary, `block` values a node, goes on by the step's unknowns u; that of others stays. */
void MpmBoundaryAdvance(const MpmContacts *contacts, PetscInt boundary, PetscInt block, const PetscReal u[],
                        MpmPlacement *placement);

/* Answer of a patch to displacements of its facets, relative to the body where its boundary is free. */
typedef struct {
  PetscBool active, any, slides;                                    /* the mean acts; a facet does */
  PetscReal stiffness;                                              /* of the mean: 0 where it does not act */
  PetscReal gap, slip[MPM_MAX_DIM];                                 /* slip: to be kept */
  PetscReal traction[MPM_MAX_DIM];                                  /* along the surface */
  PetscReal by_slip[MPM_MAX_DIM][MPM_MAX_DIM], by_gap[MPM_MAX_DIM]; /* its derivatives */
} MpmPatchAnswer;

/* Room for the facets of a patch. */
typedef struct {
  PetscReal (*value)[MPM_MAX_DIM]; /* their displacements */
  MpmSurface *surface;             /* at the step's end */
  PetscReal  *beyond; /* distance beyond the tilt of the patch: < 0 too deep; > 0, of a bilateral one, too far */
} MpmPatchWork;

/*
  States of patches from one of Newton's iterates to the next (contact_states.c). Begin: at the first one, with the
  local unknowns u; with care, secants are taken. Follow: at another one, which has been accepted. End: all by the law,
  with its derivative. Collective.
*/
PetscErrorCode MpmContactsBegin(void *ctx, const MpmSum *sum, const PetscReal u[], PetscBool careful);
PetscErrorCode MpmContactsFollow(void *ctx, const MpmSum *sum, const PetscReal u[], PetscBool *changed);
void           MpmContactsEnd(void *ctx);

/*
  For another attempt at a step: factor `give` on the elastic slip of sticking contact, from the tractions at the step's
  start; the next `prepare` ends it (contact_states.c).
*/
void MpmContactsGive(void *ctx, PetscReal give);
/* By how much a boundary gives. */
static inline PetscReal MpmContactsGiving(const MpmContacts *contacts, PetscInt boundary)
{
  return contacts->boundaries[boundary].stick ? 1. : contacts->newton.give;
}

/* One patch (contact_patch.c): k' of contact that may slide, over the stiffness across. */
PetscReal      MpmPatchAlong(const MpmContacts *contacts, const MpmPatch *patch);
PetscErrorCode MpmPatchWorkCreate(const MpmContacts *contacts, MpmPatchWork *work);
PetscErrorCode MpmPatchWorkDestroy(MpmPatchWork *work);
/* At work->value. */
void MpmPatchEvaluate(const MpmContacts *contacts, const MpmPatch *patch, MpmPatchWork *work, MpmPatchAnswer *answer);
/* At displacements u of the local nodes; of a boundary whose motion is prescribed. */
void MpmPatchEvaluateAt(const MpmContacts *contacts, const MpmPatch *patch, const MpmSum *sum, const PetscReal u[],
                        MpmPatchWork *work, MpmPatchAnswer *answer);
/* The kept slip becomes that at displacements u, where contact acted at others; at most the elastic slip. */
void MpmPatchKeepSlip(const MpmContacts *contacts, const MpmPatch *patch, const MpmSum *sum, const PetscReal u[],
                      MpmPatchWork *work, MpmPatchAnswer *answer);
/* The force on the material at a facet. */
void MpmFacetForce(const MpmContacts *contacts, const MpmPatch *patch, PetscInt f, const MpmPatchWork *work,
                   const MpmPatchAnswer *answer, PetscReal force[]);
/* Own contribution of facet f to the tangent, of directions c and d: its curvature, and terms beyond the tilt. */
PetscReal MpmFacetStiffness(const MpmContacts *contacts, const MpmPatch *patch, PetscInt f, const MpmPatchWork *work,
                            const MpmPatchAnswer *answer, PetscInt c, PetscInt d);
/* Its weights at the nodes of the patch's box, sum_i w_i u_i over them, and y_i += factor w_i force. */
static inline const PetscReal *MpmFacetWeights(const MpmContacts *contacts, PetscInt facet)
{
  return &contacts->weight[contacts->facet[facet].weight];
}
/* By axis, at the nodes of its point's group (facet_weights.c); `line` has room for MPM_MAX_WIDTH of them on each. */
void MpmFacetLines(const MpmRules *rules, const MpmSpace *space, const MpmPoints *points, const MpmFacet *facet,
                   PetscReal (*line)[16]);
/* A nodal field of `dim` components, at a facet: by the nodes of its patch's box, or of another one. */
void MpmPatchValue(const MpmContacts *contacts, const MpmSum *sum, const MpmPatch *patch, PetscInt facet,
                   const PetscReal u[], PetscReal value[]);
void MpmFacetValue(const MpmSum *sum, const MpmGroup *box, const PetscReal weight[], const PetscReal u[],
                   PetscReal value[]);
void MpmFacetAddForce(const MpmSum *sum, const MpmGroup *box, const PetscReal weight[], PetscReal factor,
                      const PetscReal force[], PetscReal y[]);

/* Room for the boundaries' poses and reactions; the boundaries are borrowed. */
PetscErrorCode MpmContactsCreate(PetscInt count, const MpmBoundary boundaries[], MpmContacts *contacts);
PetscErrorCode MpmContactsDestroy(MpmContacts *contacts);
/* Refuses points of the scene that do not suit a boundary. */
PetscErrorCode MpmBoundaryCheck(const MpmBoundary *boundary, const MpmGrid *grid, MpmParticles *particles);
/* Finds the step's patches and appends their boxes to the space (a term's `boxes`). */
PetscErrorCode MpmContactsFind(void *ctx, const MpmRules *rules, const MpmPoints *points, MpmSpace *space);
/* Distance from a facet's boundary as it stands at the step's start, or is expected to stand where it is free. */
void MpmContactsStartDistance(const MpmContacts *contacts, const PetscReal outward[], MpmFacet *facet,
                              MpmSurface *surface);
/*
  Round bodies of the material (round_facets.c). Sees: true where a face belongs to a round surface that the boundary
  accepts. Add then adds its facets, where they are no farther from the boundary than `margin`.
*/
PetscBool      MpmContactsSeesRound(const MpmContacts *contacts, const MpmPoints *points, PetscInt boundary, PetscInt p,
                                    PetscInt face);
PetscErrorCode MpmContactsAddRound(MpmContacts *contacts, PetscReal margin, const MpmPoints *points, PetscInt face,
                                   const MpmFacet *start);
/*
  Faces near an edge of the boundary (edge_facets.c), in cells of sizes h, m; `sides`: the vectors of half of a face's
  dim - 1 sides. AtEdge: marks a single facet, and returns the number of slices of its face, or 0. SlicePlace: from the
  face's middle to the slice's.
*/
PetscInt       MpmContactsAtEdge(const MpmContacts *contacts, const PetscReal h[], PetscReal (*sides)[MPM_MAX_DIM],
                                 const MpmSurface *surface, MpmFacet *facet);
void           MpmContactsSlicePlace(PetscInt dim, PetscReal (*sides)[MPM_MAX_DIM], MpmFacet *slice);
PetscErrorCode MpmContactsAddFacet(MpmContacts *contacts, const MpmFacet *facet);
/*
  A step whose forces balance at `part` of it: round facets of boundaries whose motion is prescribed touch where they
  are then, by the nodes' velocities v at the step's start, m/s, dim a node, as they turn until its end.
*/
PetscErrorCode MpmContactsTurn(void *ctx, const MpmSum *sum, const PetscReal v[], PetscReal part);
/* The number of the cell of a place, of a part of the material. */
PetscInt64 MpmContactsCell(const MpmGrid *grid, const PetscReal x[], PetscInt part);
/* Distance from a boundary as it stands at the step's start, or is expected to stand where it is free. */
void MpmContactsDistance(const MpmContacts *contacts, PetscInt boundary, const PetscReal x[], MpmSurface *surface);
/* Adds the shares of the points in the boundary's own surface as facets (surface_shares.c). Collective. */
PetscErrorCode MpmSurfaceShares(MpmContacts *contacts, PetscInt boundary, const MpmGrid *grid, const MpmSpace *space,
                                const MpmPoints *points);
/*
  Pieces of surfaces along which material slides (surface_pieces.c). Spread: the facets that are such pieces are
  replaced by those at the nodes, with those of neighbouring ranks. Boxes: of the neighbours' nodes. Load: what their
  points keep. All but boxes collective.
*/
PetscBool      MpmContactsSpreads(const MpmContacts *contacts, PetscInt boundary);
PetscErrorCode MpmPiecesSpread(MpmContacts *contacts, const MpmRules *rules, const MpmPoints *points,
                               const MpmSpace *space);
PetscErrorCode MpmPiecesAppendBoxes(const MpmContacts *contacts, MpmSpace *space);
PetscErrorCode MpmPiecesLoad(MpmContacts *contacts, const MpmTermStep *step);
/* Slips, pressures and gaps with which the step starts, from those that points keep (contact_kept.c). */
PetscErrorCode MpmContactsLoad(MpmContacts *contacts, const MpmTermStep *step);
/* Points of bilateral boundaries with a tension let go for good where a patch is pulled by more. */
PetscErrorCode MpmContactsBreak(MpmContacts *contacts, const MpmPatchAnswer answers[], MpmParticles *particles);
/* By so much the material comes nearer in this step, m. */
PetscReal MpmPieceWayBack(const MpmContacts *contacts, const MpmFacet *facet);
/* The nodes that a facet touches: those of its point's group, or of its piece. */
MpmGroup MpmFacetBox(const MpmContacts *contacts, const MpmSpace *space, const MpmFacet *facet);
/* Weights of the facets, and their slips at the step's start (a term's `prepare`). */
PetscErrorCode MpmContactsPrepare(void *ctx, const MpmTermStep *step);

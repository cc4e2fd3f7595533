#pragma once
/*
  Contact of the faces that bound the material with rigid surfaces: facets and patches of a step (contact_patches.c),
  and the term (rigid_contact.c).
*/
#include "base/base.h"
#include "base/types.h"
#include "facets/facets.h"

extern const MpmTerm MpmTermContact;     /* rigid surfaces (rigid_contact.c); ctx: MpmContacts */
extern const MpmTerm MpmTermRigidBodies; /* those whose place is solved for (rigid_body.c); ctx: MpmContacts */

/* State of a patch. */
typedef enum { MPM_PATCH_OPEN, MPM_PATCH_STICKS, MPM_PATCH_SLIDES } MpmPatchState;

/* A patch that Newton's method keeps closed whatever the law says (contact_states.c). */
typedef struct {
  PetscBool on;
  PetscBool glides; /* slides this way with the traction that goes with its pressure; else it sticks */
  PetscReal way[MPM_MAX_DIM];
} MpmPatchHold;

/* The facets of one cell at one boundary: one mean gap, one mean slip, one traction. */
typedef struct {
  PetscInt      boundary, begin, end, box; /* its facets, and the group that holds the nodes of them all */
  PetscReal     area, stiffness;           /* m^(dim-1), Pa/m */
  PetscReal     strength;                  /* in shear, of the material there at the step's start, Pa; or infinite */
  PetscBool     foreign; /* some of its facets are pieces of other ranks, which add their forces there */
  PetscBool     round;   /* a facet on a round surface, which touches by itself */
  PetscBool     direct;  /* in an explicit step: no equations are solved */
  PetscBool     broken;  /* of a bilateral boundary, which has let go: it pushes only */
  MpmPatchHold  hold;
  MpmPatchState state;
  PetscReal     traction[MPM_MAX_DIM]; /* of Newton's last iterate */
  PetscReal     shift; /* depth of the pressure at a gap of 0, m: where augmented, or in a geostatic state */
  PetscReal     mean;  /* pressure in the last steps, Pa, of friction by a law of the bed; or 0 */
  PetscReal     slips; /* in an explicit step from a geostatic state: slip over the one that points keep; or 0 */
  PetscReal     rest;  /* pressure of a geostatic state; once the step has converged, its own: Pa */
} MpmPatch;

/* Treatment of sliding by Newton's method (contact_states.c). */
typedef struct {
  PetscBool careful, secant; /* may take, and takes now, the secants of sliding patches */
  PetscBool holds;           /* and it holds patches, of any rank */
  PetscReal least;           /* stiffness of sliding along its direction, over that across (contact_law.h) */
  PetscReal raised;          /* augmented: stiffness in this step over that of the penalty */
  PetscReal deepest;         /* augmented: depth of the last correction over its tolerance */
  PetscReal give;            /* factor on the elastic slip of sticking patches; 1 but for a first iterate */
  PetscBool near;            /* in this step there are patches, of any rank */
  PetscBool bare;            /* there were none in the last step that was taken: points keep nothing of contact */
} MpmContactNewton;

/* Largest mean pressure on a patch, Pa, and height of the highest contact above the lowest one, m. */
typedef struct {
  PetscReal pressure, high;
} MpmContactFace;

#define MPM_CONTACT_RECENT 0.05 /* of a step in means of pressures over time */

/* Facets of this rank's points, and their patches. */
typedef struct MpmContacts {
  MpmFacets facets;
  PetscInt  material_count;
  PetscInt  adrift; /* a body that met nothing on its way, or -1 */
  PetscReal (*reaction)[MPM_MAX_DIM],
    *depth;                         /* of the last step: forces on the material; deepest mean gaps behind, m */
  PetscReal (*moment)[MPM_MAX_DIM]; /* of those forces about the boundary's reference point */
  MpmContactFace  *face;            /* by boundary, of the last step; NULL: none asks for it */
  PetscReal        tilt;            /* distance that facets may have from the surface where their patch is on it, m */
  const PetscReal *moved;           /* explicit steps: displacements, contact having acted at others; or NULL */
  MpmContactNewton newton;
  PetscInt         patch_count, most; /* most: facets of a patch */
  MpmPatch        *patch;
  PetscReal       *weight;
  PetscReal        dt;      /* of an explicit step, s */
  PetscBool        weighed; /* the weights are those of the facets that were found last */
} MpmContacts;

/*
  For explicit steps dt: patches become so soft that none pushes further than out of its surface in a step, by the
  masses of the local nodes (contact_patch.c).
*/
PetscErrorCode MpmContactsLimit(void *ctx, const MpmSum *sum, const PetscReal mass[], PetscReal dt);
/* Adds the forces of a geostatic state, as a residual (an operation of the term in explicit steps). */
PetscErrorCode MpmContactsBear(const void *ctx, const MpmSum *sum, PetscReal residual[]);
/*
  The placement of a boundary whose place is solved for goes on by the step's unknowns u, `block` values a node; that of
  others stays.
*/
void MpmBoundaryAdvance(const MpmContacts *contacts, PetscInt boundary, PetscInt block, const PetscReal u[],
                        MpmPlacement *placement);

/*
  Patches of material that flows (flow_patch.c). Gap: from that at the step's end without contact the one by which the
  force pushes, and whether it does. Limit: their stiffness, collective. Flows: true of such a patch.
*/
static inline PetscBool MpmPatchFlows(const MpmContacts *contacts, const MpmPatch *patch)
{
  return (PetscBool)contacts->facets.at[patch->begin].key.flows;
}
PetscBool      MpmFlowGap(const MpmContacts *contacts, const MpmPatch *patch, PetscReal *gap);
PetscErrorCode MpmFlowLimit(MpmContacts *contacts, const MpmSum *sum, const PetscReal mass[], PetscReal dt);

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
  Factor `give` on the elastic slip of sticking contact, from the tractions at the step's start (contact_states.c): for
  a first iterate alone, 1 before the answer.
*/
void MpmContactsGive(void *ctx, PetscReal give);
/* By how much a boundary gives. */
static inline PetscReal MpmContactsGiving(const MpmContacts *contacts, PetscInt boundary)
{
  return contacts->facets.boundaries[boundary].stick ? 1. : contacts->newton.give;
}

/* Gap of a patch at the step's start, by where its facets stand there. */
PetscReal MpmPatchStartGap(const MpmContacts *contacts, const MpmPatch *patch);
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
/*
  A boundary's body as its patches see it: its motion is prescribed (contact_patch.c), or solved for (rigid_patch.c).

  evaluate  a patch at displacements u of the local nodes; forces and slips are those in the body's frame
  turn      a facet's force along the axes, and its arm from the boundary's reference point, m
  keep      the slip to be kept, along the axes at the step's end
*/
typedef struct {
  void (*evaluate)(const MpmContacts *contacts, const MpmPatch *patch, const MpmSum *sum, const PetscReal u[],
                   MpmPatchWork *work, MpmPatchAnswer *answer);
  void (*turn)(const MpmContacts *contacts, const MpmPatch *patch, PetscInt f, const MpmSum *sum, const PetscReal u[],
               PetscReal force[3], PetscReal arm[3]);
  void (*keep)(const MpmContacts *contacts, const MpmPatch *patch, const MpmSum *sum, const PetscReal u[],
               PetscReal slip[]);
} MpmContactFrame;
extern const MpmContactFrame         MpmFramePrescribed, MpmFrameSolved;
static inline const MpmContactFrame *MpmPatchFrame(const MpmContacts *contacts, const MpmPatch *patch)
{
  return MpmFacetsBody(&contacts->facets, patch->boundary) ? &MpmFrameSolved : &MpmFramePrescribed;
}
/* The force on the material at a facet. */
void MpmFacetForce(const MpmContacts *contacts, const MpmPatch *patch, PetscInt f, const MpmPatchWork *work,
                   const MpmPatchAnswer *answer, PetscReal force[]);
/* Own contribution of facet f to the tangent, of directions c and d: its curvature, and terms beyond the tilt. */
PetscReal MpmFacetStiffness(const MpmContacts *contacts, const MpmPatch *patch, PetscInt f, const MpmPatchWork *work,
                            const MpmPatchAnswer *answer, PetscInt c, PetscInt d);
/* Its weights at the nodes of the patch's box, sum_i w_i u_i over them, and y_i += factor w_i force. */
static inline const PetscReal *MpmFacetWeights(const MpmContacts *contacts, PetscInt facet)
{
  return &contacts->weight[contacts->facets.at[facet].weight];
}
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
/* Finds the step's patches and appends their boxes to the space (a term's `boxes`). */
PetscErrorCode MpmContactsFind(void *ctx, const MpmRules *rules, const MpmPoints *points, MpmSpace *space);
/* Slips, pressures and gaps with which the step starts, from those that points keep (contact_kept.c). */
PetscErrorCode MpmContactsLoad(MpmContacts *contacts, const MpmTermStep *step);
/* The points keep the converged step's: slips, pressures and gaps, and where they have let go (contact_kept.c). */
PetscErrorCode MpmContactsKeep(const MpmContacts *contacts, const MpmSum *sum, const MpmPatchAnswer answers[],
                               MpmParticles *particles);
/*
  For points returned to their places at the step's start with their stress: patches that touch shall do so there under
  the pressure of the step, which the points keep.
*/
PetscErrorCode MpmContactsPutBack(const void *ctx, PetscInt points, MpmParticles *particles);
/* The points keep the pressures at u, with which the material is in balance where it stands; NULL: none. */
PetscErrorCode MpmContactsBalance(void *ctx, const MpmSum *sum, const PetscReal u[], MpmParticles *particles);
/*
  Method augmented (contact_augmented.c). Augment: where the largest error of depth over its tolerance is above 1, the
  pressures become those of the patches at u; collective. IsCorrected: true where a patch's depth is corrected: not for
  a single facet nearly perpendicular to the boundary.
*/
PetscErrorCode MpmContactsAugment(void *ctx, const MpmSum *sum, const PetscReal u[], PetscBool first, PetscReal *worst);
PetscBool      MpmPatchIsCorrected(const MpmContacts *contacts, const MpmPatch *patch);
/* Pressures and heights of the converged step, where `face` asks for them (contact_face.c). Collective. */
PetscErrorCode MpmContactsFindFaces(MpmContacts *contacts, const MpmSum *sum, const MpmPatchAnswer answers[],
                                    MpmParticles *particles);
/* Weights of the facets, and their slips at the step's start (a term's `prepare`). */
PetscErrorCode MpmContactsPrepare(void *ctx, const MpmTermStep *step);

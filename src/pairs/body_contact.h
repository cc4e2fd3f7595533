#pragma once
/*
  Contact of bodies with one another: the pairs of a scene, and the patches of a step (body_patches.c, body_contact.c).
*/
#include "base/base.h"
#include "base/types.h"

/* Two bodies that touch, slide and part. */
typedef struct {
  char *name, *slip_field[MPM_MAX_DIM], *gap_field, *pressure_field,
    *rest_field;              /* fields of the particles; slip: where tangential; pressure: augmented; rest: pressure
                                     of a geostatic state, where the scene has one */
  PetscInt  body[2], part[2]; /* the first one's facets make the patches */
  PetscReal penalty, friction, adhesion; /* -, Coulomb's coefficient, Pa */
  PetscBool firm, stick, tangential;     /* firm: the penalty holds for all materials */
  PetscBool barrier, augmented;          /* pressure before they touch; without depth */
  PetscBool open;                        /* water passes */
  PetscReal penetration;                 /* augmented: depth that may remain, in cells */
} MpmPair;

/* Contacts, with the names of their blocks. */
struct MpmPairs {
  PetscInt count;
  char   **names;
  MpmPair *at;
};

/* In explicit steps: the mean of a side as that of a place beside its own (body_impact.c). In 2D rotation about z. */
typedef struct {
  PetscBool turns;                             /* its rotation follows from its nodes */
  PetscReal middle[MPM_MAX_DIM];               /* where the mean of the nodes stands, m */
  PetscReal offset[MPM_MAX_DIM];               /* from there to where the patch's force acts, m */
  PetscReal inverse[MPM_MAX_DIM][MPM_MAX_DIM]; /* turning by moment of the nodes' displacements, 1/m2 */
} MpmPairLever;

/* The facets of one side of a patch: the nodes of a box, and the weights of the mean over the facets at them. */
typedef struct {
  PetscInt     begin, end, box, weight;  /* begin, end: in the contacts' list of facets */
  PetscReal    area, place[MPM_MAX_DIM]; /* projected; mean place */
  MpmPairLever lever;
} MpmPatchSide;

/* The facets of the first body in one cell, or part of one (MpmGridFindPart), and those of the second across. */
typedef struct {
  PetscInt  pair;
  PetscReal normal[MPM_MAX_DIM], gap,
    slip[MPM_MAX_DIM];                       /* at the step's start; the normal is outward of the first body */
  PetscReal    touches, stiffness, strength; /* gap at which it touches, m; Pa/m; Pa */
  PetscReal    closed;                       /* by so much the last step closed the gap where it touches, m */
  PetscReal    shift;  /* augmented: so deep, m, the penalty gives the pressure that holds it at 0 */
  PetscReal    rest;   /* pressure of a geostatic state; once the step has converged, its own: Pa */
  PetscReal    slips;  /* in an explicit step from a geostatic state: slip over the one that points keep; or 0 */
  PetscBool    direct; /* in an explicit step: no equations are solved, and sides have levers */
  PetscBool    held;   /* kept closed for an iteration */
  PetscReal    way[MPM_MAX_DIM]; /* direction of sliding while kept closed */
  PetscReal    through;          /* water that passes by area, time and difference of pressure, m/(Pa s); 0: none */
  MpmPatchSide side[2];
} MpmPairPatch;

/* A facet as exchanged between ranks. */
typedef struct MpmPairFacet MpmPairFacet;

/* Facets near a contact, of this rank and copies of others', by cells; `list`: theirs by patches and their sides. */
typedef struct {
  PetscInt      count, list_count;
  MpmPairFacet *at;
  PetscInt     *list;
  PetscLogEvent search;
} MpmPairFacets;

/* Treatment of patches by Newton's method (body_states.c); members as at boundaries (MpmContactNewton). */
typedef struct {
  PetscBool holds; /* patches of some rank are kept closed */
  PetscBool near, bare;
  PetscReal least, give;
} MpmPairNewton;

/* Weights of the means of all patches' sides, one behind the other. */
typedef struct {
  PetscInt   count;
  PetscReal *at;
} MpmPairWeights;

/* Those of this rank. */
struct MpmPairContacts {
  const MpmPairs  *pairs;
  const MpmBodies *bodies;
  PetscReal (*force)[MPM_MAX_DIM]; /* of the last step, on the first body of each pair */
  PetscReal        cell, touch;    /* the smallest size of a cell; a patch no further away touches */
  PetscBool        starts;         /* the step is the run's first: overlapping bodies touch from now on */
  PetscBool        dynamic;        /* the step has inertia */
  MpmPairNewton    newton;
  const PetscReal *moved; /* explicit steps: displacements, contact having acted at others; or NULL */
  MPI_Comm         comm;
  PetscInt         state_size; /* of a point's history */
  PetscInt         water;      /* the unknown that is water's pressure, or -1 */
  MpmPairFacets    facets;
  PetscInt         patch_count, most; /* most: nodes of a patch */
  MpmPairPatch    *patch;
  MpmPairWeights   weights;
};

/* Reads friction, penalty and method of a pair's block, and whether water passes where there is any. */
PetscErrorCode MpmPairRead(const MpmOptions *block, PetscInt dim, PetscBool water, MpmPair *pair);
/* For scenes with a geostatic stage: points keep the pressure of its state, for explicit steps. */
PetscErrorCode MpmPairKeepRest(MpmPair *pair);
PetscErrorCode MpmPairsDestroy(MpmPairs *pairs);
/* Pairs and bodies are borrowed. `water`: the unknown that is water's pressure, or -1. */
PetscErrorCode MpmPairContactsCreate(MPI_Comm comm, const MpmPairs *pairs, const MpmBodies *bodies, PetscInt state_size,
                                     PetscInt water, MpmPairContacts *contacts);
#define MPM_BARRIER 0.1 /* of a cell: so near a barrier begins to push */
PetscErrorCode MpmPairContactsDestroy(MpmPairContacts *contacts);
/* Finds the step's patches and appends their boxes to the space (a term's `boxes`); collective. */
PetscErrorCode MpmPairPatchesFind(void *ctx, const MpmRules *rules, const MpmPoints *points, MpmSpace *space);
/* Their weights, and their kept values from the first bodies' points (a term's `prepare`). */
PetscErrorCode MpmPairPatchesPrepare(void *ctx, const MpmTermStep *step);
PetscErrorCode MpmPairPatchesLink(void *ctx, MpmSpace *space);
/*
  Patches at the first of Newton's iterates (body_states.c). Begin: where nothing touches at u, keeps those that slid in
  the last step closed for one iteration: until Release. End: all by the law, with its derivative. Collective.
*/
PetscErrorCode MpmPairsBegin(void *ctx, const MpmSum *sum, const PetscReal u[], PetscBool careful);
PetscErrorCode MpmPairsRelease(void *ctx, const MpmSum *sum, const PetscReal u[], PetscBool *changed);
void           MpmPairsEnd(void *ctx);
/* As at boundaries (MpmContactsGive). */
void MpmPairsGive(void *ctx, PetscReal give);
/* Adds the squares of the forces, N2, that this rank's patches have at the local unknowns u. */
PetscErrorCode MpmPairsAddSquares(const void *ctx, const MpmSum *sum, const PetscReal u[], PetscReal *squares);
/*
  Method augmented, after Newton's: where the largest error of depth over its tolerance is above 1, the pressures become
  those of the patches at u. Collective.
*/
PetscErrorCode MpmPairsAugment(void *ctx, const MpmSum *sum, const PetscReal u[], PetscBool first, PetscReal *worst);
/*
  For points returned to their places at the step's start with their stress: patches that touch shall do so there under
  the pressure of the step. The points keep the gap that the step left in place of that at which they touch, and the
  next step sets that from it (MpmRules.put_back).
*/
PetscErrorCode MpmPairsPutBack(const void *ctx, PetscInt points, MpmParticles *particles);
/*
  For explicit steps dt: patches become so soft that none reverses the motion that it stops, by the masses of the local
  nodes, and their forces have no moment (body_impact.c). Collective.
*/
PetscErrorCode MpmPairsLimit(void *ctx, const MpmSum *sum, const PetscReal mass[], PetscReal dt);
/* Adds the forces of a geostatic state, as a residual (an operation of the term in explicit steps). */
PetscErrorCode MpmPairsBear(const void *ctx, const MpmSum *sum, PetscReal residual[]);
/* From the mean of a side to node i of its box, m; 3 numbers. */
void MpmPairArm(const MpmPairPatch *patch, PetscInt s, const MpmSum *sum, PetscInt i, PetscReal arm[]);
/* Share of a node, by its weight, in a force on a side, 3 numbers, at this arm. */
void MpmPairNodeForce(const MpmPairLever *lever, const PetscReal force[], const PetscReal arm[], PetscReal at_node[]);
/* Adds the contribution of turning to the mean w, 3 numbers: `moment` is sum_i w_i r_i x u_i. */
void MpmPairAddTurning(const MpmPairLever *lever, const PetscReal moment[], PetscReal sign, PetscReal w[]);
/* The points of a patch keep its slip and the gap at which it touches. */
PetscErrorCode       MpmPairPatchesKeep(const MpmPairContacts *contacts, PetscReal (*slip)[MPM_MAX_DIM],
                                        MpmParticles          *particles);
extern const MpmTerm MpmTermBodyContact; /* ctx: MpmPairContacts */

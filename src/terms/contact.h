#pragma once
/*
  Contact of the faces that bound the material with rigid surfaces: facets and patches of a step (contact_patches.c), and
  the term (rigid_contact.c).
*/
#include "base/base.h"
#include "base/types.h"
#include "terms/rigid.h"
#include "terms/terms.h"

/* A face of a point's domain that bounds the material and may touch a boundary in this step. */
typedef struct {
  PetscInt   boundary, point, group, weight; /* weight: where its weights at the nodes of the patch's box stand */
  PetscInt64 cell;                           /* of the point's centre */
  PetscReal place[MPM_MAX_DIM], normal[MPM_MAX_DIM], slip[MPM_MAX_DIM]; /* at the step's start; the boundary's normal */
  PetscReal area;                                                       /* projected on the boundary, m^(dim-1) */
  PetscReal touches; /* distance at which it touches, m: not 0 where the lattice of points was cut by the surface */
} MpmFacet;

/* The facets of one cell at one boundary: one mean gap, one mean slip, one traction. */
typedef struct {
  PetscInt  boundary, begin, end, box; /* its facets, and the group that holds the nodes of them all */
  PetscReal area, stiffness;           /* m^(dim-1), Pa/m */
} MpmPatch;

/* Those of this rank's points, and what they do. */
typedef struct MpmContacts {
  PetscInt           boundary_count;
  const MpmBoundary *boundaries;
  MpmPose           *before, *after;          /* the boundaries' at the step's start and end */
  PetscReal (*reaction)[MPM_MAX_DIM], *depth; /* of the last step: forces on the body; deepest mean gaps behind, m */
  PetscReal touch,
    tilt; /* a patch no further away touches; so far may facets be off the surface where their patch is on it */
  PetscInt   facet_count, capacity, patch_count, most; /* most: facets of a patch */
  MpmFacet  *facet;
  MpmPatch  *patch;
  PetscReal *weight;
} MpmContacts;

/* Room for the boundaries' poses and reactions; the boundaries are borrowed. */
PetscErrorCode MpmContactsCreate(PetscInt count, const MpmBoundary boundaries[], MpmContacts *contacts);
PetscErrorCode MpmContactsDestroy(MpmContacts *contacts);
/* Finds the step's patches and appends their boxes to the space (a term's `boxes`). */
PetscErrorCode MpmContactsFind(void *ctx, const MpmRules *rules, const MpmPoints *points, MpmSpace *space);
/* Weights of the facets, and their slips at the step's start (a term's `prepare`). */
PetscErrorCode MpmContactsPrepare(void *ctx, const MpmTermStep *step);

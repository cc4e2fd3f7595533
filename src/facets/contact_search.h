#pragma once
/*
  Boxes around the points whose faces bound the material: a test, before any facet is made, whether contact may be near
  at all (contact_search.c).
*/
#include "facets/facets.h"

/*
  Around points with an outer face, at least: their extent, m, and a bound on the square of half edges |F e_a| l_a of a
  domain, m2: the largest l_a^2 times |F|^2 = sum_ab F_ab^2. None: lower is above upper.
*/
typedef struct {
  PetscReal lower[MPM_MAX_DIM], upper[MPM_MAX_DIM], square;
} MpmFaceBox;

/* Boxes of points that stand side by side in storage, made on request, and the one around them all. */
struct MpmFaceBoxes {
  PetscBool     made;
  PetscInt      count, capacity;
  MpmFaceBox   *box, all;
  PetscBool    *far; /* of the last boundary of a request */
  PetscLogEvent search;
};

/* Boxes by part that hold all points with outer faces. */
void MpmFaceBoxesOfParts(PetscInt dim, PetscInt parts, const MpmPoints *points, MpmFaceBox boxes[]);

PetscErrorCode MpmFaceBoxesCreate(MpmFaceBoxes **boxes);
/* A step's points are these; nothing is done where all boundaries are bilateral. */
PetscErrorCode MpmFaceBoxesBegin(MpmFacets *facets, const MpmPoints *points);
PetscErrorCode MpmFaceBoxesDestroy(MpmFaceBoxes **boxes);
/* True where all points are too far from a boundary that is not bilateral; else MpmFaceBoxIsFar() says where. */
PetscErrorCode MpmFaceBoxesFind(const MpmFacets *facets, PetscInt boundary, const MpmGrid *grid,
                                const MpmPoints *points, PetscBool *far);
PetscBool      MpmFaceBoxIsFar(const MpmFacets *facets, PetscInt boundary, PetscInt p);

/*
  Reach of the search for a boundary from a place, m: the largest approach of material and surface in the step. The
  second function is true where all of a point's domain is farther than this margin, and the round region before its
  faces less than a length of the domain.
*/
PetscReal MpmFacetsMargin(const MpmFacets *facets, const MpmGrid *grid, PetscInt boundary, const PetscReal x[]);
PetscBool MpmFacetsAreFar(const MpmFacets *facets, PetscInt boundary, PetscReal margin, const MpmPoints *points,
                          PetscInt p);

/* Counted in -log_view as MpmContactSearch: a look at faces, which boxes could not spare. */
PetscErrorCode MpmContactSearchRegister(PetscLogEvent *event);

#pragma once
/*
  Facets of bodies in contact with one another: those of a rank and copies of others' that are near (body_facets.c).
*/
#include "pairs/body_contact.h"

/* The material behind a facet. */
typedef struct {
  PetscInt  index;
  PetscReal modulus, strength, plastic; /* Pa, Pa, plastic flow */
} MpmPairMaterial;

struct MpmPairFacet {
  PetscInt part, id, face, point,
    across; /* id: of its point, which is `point` on this rank, -1: a copy; across: one of the other body is */
  PetscInt  first[MPM_MAX_DIM], count[MPM_MAX_DIM]; /* its nodes */
  PetscReal place[MPM_MAX_DIM], area[MPM_MAX_DIM], size,
    cell[MPM_MAX_DIM];                     /* size: half the edge of a face; cell: of its point (MpmGridFindPart) */
  PetscReal       look[MPM_MAX_DIM], seen; /* outward normal of the surface; area along it, 0: of a step */
  PetscReal       line[MPM_MAX_DIM][MPM_MAX_WIDTH]; /* weights by axis */
  MpmPairMaterial material;
  PetscInt        placed; /* on the surface that cut the lattice */
};

/* Finds them, in one order: by cell, then by id; those of points in no contact are left out. Collective. */
PetscErrorCode MpmPairFacetsFind(MpmPairContacts *contacts, const MpmRules *rules, const MpmPoints *points,
                                 const MpmSpace *space);
/* Cells, or parts of those of elements, around a facet, `reach` sizes of the smallest on each side. */
void MpmPairFacetCells(const MpmGrid *grid, const MpmPairFacet *facet, PetscReal reach, PetscInt lower[],
                       PetscInt upper[]);
/* The facets of a cell, [first, end) in their order. */
void MpmPairFacetsOfCell(const MpmPairContacts *contacts, const PetscInt cell[], PetscInt *first, PetscInt *end);
#define MPM_PAIR_SEARCH 1.5 /* cells: no facet across is looked for farther away */

/* Each facet of either side with its side's number. */
#define MPM_PAIR_SIDES(patch, f, s) \
  for (PetscInt s = 0; s < 2; s++) \
    for (PetscInt f = (patch)->side[s].begin; f < (patch)->side[s].end; f++)

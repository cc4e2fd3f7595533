#pragma once
/*
  Places of points in cells: the options -bps_points, for the programs bps and bench_bps.

    gauss    Gauss points of each cell, with their weights as volumes
    uniform  as the body has them
    random   a place in the cell at random for each, of equal volume
    cloud    centres of subcells, moved by up to 0.45 of a subcell along each axis by a sequence of low discrepancy, of
             equal volume

  Source of the sequence: Roberts (2018), The unreasonable effectiveness of quasirandom sequences; its number in 3D is
  the real root of g^4 = g + 1.
*/
#include <math.h>
#include "talus/talus.h"

typedef enum { GAUSS, UNIFORM, RANDOM, CLOUD } PointKind;
static const char *const kinds[] = {"gauss", "uniform", "random", "cloud"};

#define MOST 16 /* points an axis in a cell */

/* Gauss points of [0, 1] and their weights: roots of Legendre's polynomial by Newton's method. */
static void Gauss(PetscInt m, PetscReal place[], PetscReal weight[])
{
  for (PetscInt i = 0; i < m; i++) {
    PetscReal x = -PetscCosReal(PETSC_PI * ((PetscReal)i + 0.75) / ((PetscReal)m + 0.5)), slope = 1.;

    for (PetscInt it = 0; it < 20; it++) {
      PetscReal before = 1., now = x;

      for (PetscInt k = 1; k < m; k++) {
        const PetscReal next = ((PetscReal)(2 * k + 1) * x * now - (PetscReal)k * before) / (PetscReal)(k + 1);

        before = now;
        now    = next;
      }
      slope = (PetscReal)m * (x * now - before) / (x * x - 1.);
      x -= now / slope;
    }
    place[i]  = 0.5 * (1. + x);
    weight[i] = 1. / ((1. - x * x) * slope * slope);
  }
}

/* The lattice of the points as the body makes them. */
typedef struct {
  PetscInt  dim, cells[3], m; /* m: points an axis in a cell */
  PetscReal lower[3], h[3];
  PointKind kind;
  PetscReal gauss[MOST], weight[MOST];
} Lattice;

static PetscReal Fraction(PetscReal x)
{
  return x - PetscFloorReal(x);
}

/* A number of [0, 1) that follows from k. Source: Steele, Lea and Flood (2014), doi:10.1145/2660193.2660195 */
static PetscReal Random(PetscInt64 k)
{
  uint64_t z = ((uint64_t)k + 1u) * 0x9E3779B97F4A7C15u;

  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
  return (PetscReal)((z ^ (z >> 31)) >> 11) * 0x1p-53;
}

/* Moves a point to its place in the cell, and gives it its volume. */
static void Place(const Lattice *lattice, PetscReal x[], PetscReal *volume)
{
  const PetscReal g     = 1. / 1.22074408460575947536;
  PetscInt        at[3] = {0, 0, 0}, sub[3] = {0, 0, 0};
  PetscInt64      cell = 0, place = 0, j = 1;

  *volume = 1.;
  for (PetscInt a = lattice->dim - 1; a >= 0; a--) {
    const PetscReal xi = (x[a] - lattice->lower[a]) / lattice->h[a];

    at[a]  = (PetscInt)PetscFloorReal(xi);
    sub[a] = (PetscInt)PetscFloorReal((xi - (PetscReal)at[a]) * (PetscReal)lattice->m);
    cell   = cell * lattice->cells[a] + at[a];
    place  = place * lattice->m + sub[a];
  }
  for (PetscInt a = 0; a < lattice->dim; a++) j *= lattice->m;
  j = 1 + cell * j + place;
  for (PetscInt a = 0; a < lattice->dim; a++) {
    PetscReal t = ((PetscReal)sub[a] + 0.5) / (PetscReal)lattice->m, w = 1. / (PetscReal)lattice->m;

    if (lattice->kind == GAUSS) {
      t = lattice->gauss[sub[a]];
      w = lattice->weight[sub[a]];
    } else if (lattice->kind == RANDOM) t = Random(3 * j + a);
    else if (lattice->kind == CLOUD)
      t += 0.9 / (PetscReal)lattice->m * (Fraction(0.5 + (PetscReal)j * pow(g, (double)(a + 1))) - 0.5);
    x[a] = lattice->lower[a] + lattice->h[a] * ((PetscReal)at[a] + t);
    *volume *= w * lattice->h[a];
  }
}

/* The grid and the points in a cell, as the scene has them. */
static PetscErrorCode ReadLattice(PointKind kind, Lattice *lattice)
{
  PetscInt  points[3], count = 3, refine = 1;
  PetscReal upper[3];
  char      name[64], option[128];

  PetscFunctionBeginUser;
  lattice->kind = kind;
  PetscCall(PetscOptionsGetInt(NULL, NULL, "-mpm_dim", &lattice->dim, NULL));
  PetscCall(PetscOptionsGetIntArray(NULL, NULL, "-mpm_grid_cells", lattice->cells, &count, NULL));
  count = 3;
  PetscCall(PetscOptionsGetRealArray(NULL, NULL, "-mpm_grid_lower", lattice->lower, &count, NULL));
  count = 3;
  PetscCall(PetscOptionsGetRealArray(NULL, NULL, "-mpm_grid_upper", upper, &count, NULL));
  PetscCall(PetscOptionsGetInt(NULL, NULL, "-mpm_grid_refine", &refine, NULL));
  PetscCall(PetscOptionsGetString(NULL, NULL, "-mpm_bodies", name, sizeof(name), NULL));
  PetscCall(PetscSNPrintf(option, sizeof(option), "-mpm_body_%s_points_per_cell", name));
  count = 3;
  PetscCall(PetscOptionsGetIntArray(NULL, NULL, option, points, &count, NULL));
  lattice->m = points[0];
  for (PetscInt a = 0; a < lattice->dim; a++) {
    PetscCheck(points[a] == lattice->m && lattice->m <= MOST, PETSC_COMM_WORLD, PETSC_ERR_USER_INPUT,
               "%s: must have the same number on all axes, at most %d", option, MOST);
    lattice->cells[a] *= refine;
    lattice->h[a] = (upper[a] - lattice->lower[a]) / (PetscReal)lattice->cells[a];
  }
  Gauss(lattice->m, lattice->gauss, lattice->weight);
  PetscFunctionReturn(PETSC_SUCCESS);
}

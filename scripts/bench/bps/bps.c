/*
  bps OPTIONS - a CEED problem at points: a scene of physics projection or poisson, and their forms _vector

    u_c = (c + 1) prod_a W(x_a) ,    W(x) = sum_{n=0}^{2} 2^-n cos((3/2)^n pi x) ,    Weierstrass' function, three terms

  Options of its own:

    -bps_points  gauss    Gauss points of each cell, with their weights as volumes
                 uniform  as the body has them
                 random   a place in the cell at random for each, of equal volume
                 cloud    centres of subcells, moved by up to 0.45 of a subcell along each axis by a sequence of low
                          discrepancy (Roberts 2018), of equal volume
    -bps_load    value    f at the points: u, or -lap u
                 flux     grad u at the points as load_x, ... (poisson)

  The grid is a box of the same number of points an axis in each cell, from one body with points_per_cell. Conditions
  named `edge` take u at their nodes.
*/
#include <math.h>
#include "talus/talus.h"
#include "places.h"

static const char *const loads[] = {"value", "flux"};

#define TERMS 3 /* of W */

/* W or its derivative of order k. */
static PetscReal W(PetscReal x, PetscInt k)
{
  PetscReal sum = 0.;

  for (PetscInt n = 0; n < TERMS; n++) {
    const PetscReal a = pow(1.5, (double)n) * PETSC_PI;

    sum += pow(0.5, (double)n) * pow(a, (double)k) * PetscCosReal(a * x + 0.5 * PETSC_PI * (PetscReal)k);
  }
  return sum;
}

static PetscReal Exact(PetscInt dim, const PetscReal x[])
{
  PetscReal u = 1.;

  for (PetscInt a = 0; a < dim; a++) u *= W(x[a], 0);
  return u;
}

static PetscReal Derivative(PetscInt dim, const PetscReal x[], PetscInt axis, PetscInt k)
{
  PetscReal u = 1.;

  for (PetscInt a = 0; a < dim; a++) u *= W(x[a], a == axis ? k : 0);
  return u;
}

static PetscErrorCode Value(PetscInt dim, PetscReal time, const PetscReal X[], PetscReal force[], void *ctx)
{
  (void)time, (void)ctx;
  for (PetscInt c = 0; c < dim; c++) force[c] = (PetscReal)(c + 1) * Exact(dim, X);
  return PETSC_SUCCESS;
}

static PetscErrorCode Source(PetscInt dim, PetscReal time, const PetscReal X[], PetscReal force[], void *ctx)
{
  PetscReal f = 0.;

  (void)time, (void)ctx;
  for (PetscInt a = 0; a < dim; a++) f -= Derivative(dim, X, a, 2);
  for (PetscInt c = 0; c < dim; c++) force[c] = (PetscReal)(c + 1) * f;
  return PETSC_SUCCESS;
}

/* The condition has the first components, in their order. */
static PetscErrorCode Edge(PetscInt dim, const PetscReal X[], PetscReal value[], void *ctx)
{
  const PetscInt components = *(const PetscInt *)ctx;

  for (PetscInt c = 0; c < components; c++) value[c] = (PetscReal)(c + 1) * Exact(dim, X);
  return PETSC_SUCCESS;
}

/* Moves the points; with `flux` they take the gradients of u as loads. */
static PetscErrorCode SetPoints(MpmModel model, const Lattice *lattice, PetscBool flux, PetscInt components)
{
  const PetscInt dim = lattice->dim;
  PetscReal     *x, *x0, *volume, *own = NULL;
  PetscInt       count, size = 0;

  PetscFunctionBeginUser;
  PetscCall(MpmModelGetPointCount(model, &count, NULL));
  PetscCall(MpmModelGetPoints(model, "position", NULL, &x));
  PetscCall(MpmModelGetPoints(model, "position0", NULL, &x0));
  PetscCall(MpmModelGetPoints(model, "volume0", NULL, &volume));
  if (flux) PetscCall(MpmModelGetPoints(model, "own", &size, &own));
  for (PetscInt p = 0; p < count; p++) {
    Place(lattice, &x[p * dim], &volume[p]);
    for (PetscInt a = 0; a < dim; a++) x0[p * dim + a] = x[p * dim + a];
    for (PetscInt k = 0; flux && k < components * dim; k++)
      own[p * size + k] = (PetscReal)(k / dim + 1) * Derivative(dim, &x[p * dim], k % dim, 1);
  }
  if (flux) PetscCall(MpmModelRestorePoints(model, "own", &size, &own));
  PetscCall(MpmModelRestorePoints(model, "volume0", NULL, &volume));
  PetscCall(MpmModelRestorePoints(model, "position0", NULL, &x0));
  PetscCall(MpmModelRestorePoints(model, "position", NULL, &x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Run(MpmModel model, int *status)
{
  PetscInt  kind = GAUSS, load = 0, components = 1, count = 8;
  char      physics[64] = "", *names[8];
  PetscBool poisson, vector, edge = PETSC_FALSE, found;
  Lattice   lattice;

  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(&lattice, sizeof(lattice)));
  PetscCall(PetscOptionsGetEList(NULL, NULL, "-bps_points", kinds, 4, &kind, NULL));
  PetscCall(PetscOptionsGetEList(NULL, NULL, "-bps_load", loads, 2, &load, NULL));
  PetscCall(ReadLattice((PointKind)kind, &lattice));
  PetscCall(PetscOptionsGetString(NULL, NULL, "-mpm_physics", physics, sizeof(physics), NULL));
  PetscCall(PetscStrbeginswith(physics, "poisson", &poisson));
  PetscCall(PetscStrendswith(physics, "_vector", &vector));
  if (vector) components = lattice.dim;
  if (!poisson || !load) PetscCall(MpmModelSetBodyForce(model, poisson ? Source : Value, NULL));
  PetscCall(PetscOptionsClearValue(NULL, "-bps_points")); /* not the model's */
  PetscCall(PetscOptionsClearValue(NULL, "-bps_load"));
  PetscCall(MpmModelUseTerminal(model));
  PetscCall(MpmModelSetFromOptions(model));
  PetscCall(PetscOptionsGetStringArray(NULL, NULL, "-mpm_bcs", names, &count, &found));
  for (PetscInt b = 0; found && b < count; b++) {
    PetscCall(PetscStrbeginswith(names[b], "edge", &edge));
    if (edge) PetscCall(MpmModelSetConditionValue(model, names[b], Edge, &components));
    PetscCall(PetscFree(names[b]));
  }
  PetscCall(MpmModelSetUp(model));
  PetscCall(SetPoints(model, &lattice, (PetscBool)(poisson && load), components));
  PetscCall(MpmModelRun(model, status));
  PetscFunctionReturn(PETSC_SUCCESS);
}

int main(int argc, char **argv)
{
  MpmModel model;
  int      status = 0;

  PetscCall(PetscInitialize(&argc, &argv, NULL, "bps -options_file examples/bps/case.yaml\n"));
  PetscCall(MpmModelCreate(PETSC_COMM_WORLD, &model));
  PetscCall(Run(model, &status));
  PetscCall(MpmModelDestroy(&model));
  PetscCall(PetscFinalize());
  return status;
}

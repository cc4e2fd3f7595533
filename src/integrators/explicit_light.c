/*
  Nearly massless nodes. A domain that reaches by a distance d into a cell gives a node there a mass proportional to d^2
  and forces proportional to d: its velocity has no bound as d goes to 0. The points take little of that, and the node's
  next velocity is theirs again. A face at the domain's end, however, has a weight proportional to d there, and would
  seem to slip, step by step, by the difference of the stress in the domain and the friction on the face. Other terms
  than the points' therefore see a free node's change since the step's start with at least a certain mass. The forces,
  and with them momentum, are unchanged.

  Light nodes whose gradients do not fall with their mass: all of linear functions; of other shapes those of points on
  an edge of the grid. Such a node, of mass m, that one point touches vibrates with (c/h) sqrt(rho h^dim/m), faster than
  steps can follow, where the point takes its gradient unchanged: in the affine velocity, and in the stress of usl. The
  point's momentum is kept.

  A column's mass goes with its depth, and that is not the cell's: nodes of columns are light by the area about them.
*/
#include "grid/grid.h"
#include "grid/shape.h"
#include "point/material.h"
#include "space/space.h"
#include "space/sum.h"
#include "bc/bc.h"
#include "assembly/terms.h"
#include "terrain/bed_flow.h"
#include "volume/inertia.h"
#include "query/model.h"
#include "integrators/dynamics.h"
#include "integrators/explicit.h"

#define LIGHT        1e-2 /* of the mass of the lightest material in a cell, or of its area: lower bound of nodes, */
#define LIGHT_AFFINE 0.25 /* and for affine velocities: a step of cfl 1 is then stable */

/* Least mass of a node, kg. */
static PetscReal LeastMass(const MpmModel model, PetscReal part)
{
  PetscReal least = PETSC_MAX_REAL;

  for (PetscInt m = 0; m < model->scene.materials->count; m++)
    least = PetscMin(least, part * model->scene.materials->at[m].density);
  for (PetscInt a = 0; a < model->disc.dim; a++) least *= model->disc.grid->h[a];
  return least * MpmGridTurn(model->disc.grid, model->disc.grid->lower[0] + 0.5 * model->disc.grid->h[0]);
}

/* A number of each local node, and the part of a full cell below which a node is light, in its unit. */
typedef struct {
  const PetscReal *of;
  PetscInt         apart;
  PetscReal        least;
} Weights;

static Weights FindWeights(const MpmModel model, PetscReal part)
{
  const MpmBedFlow *bed = model->disc.context.bed;
  const PetscReal  *h   = model->disc.grid->h;

  if (bed) return (Weights){&bed->sums[MPM_BED_AREA], MPM_BED_SUMS, part * h[0] * h[1]};
  return (Weights){model->disc.context.inertia->mass, 1, LeastMass(model, part)};
}

PetscBool MpmExplicitIsLinear(const MpmModel model)
{
  return (PetscBool)(!MpmShapeHasDomain(model->scene.shape.type) && MpmShapeDegree(model->scene.shape.type) < 2);
}

PetscBool MpmLightNodesExist(const MpmModel model)
{
  const Weights weights = FindWeights(model, LIGHT_AFFINE);

  if (MpmExplicitIsLinear(model)) return PETSC_TRUE;
  for (PetscInt i = 0; i < model->disc.space->local; i++)
    if (weights.of[i * weights.apart] < weights.least && weights.of[i * weights.apart] > 0.) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* Of nodes with less than `light` of a full cell. */
static void Limit(const MpmModel model, PetscReal light, PetscReal dt, PetscReal u[])
{
  const MpmConstraints *constraints = model->disc.constraints;
  const PetscReal      *v_old       = model->state.scheme.dynamics->v_old;
  const PetscInt        dim         = model->disc.dim;
  const Weights         weights     = FindWeights(model, light);

  for (PetscInt k = 0; k < model->disc.space->local * dim; k++) {
    const PetscReal part = weights.of[k / dim * weights.apart] / weights.least;

    if (part < 1. && MpmConstraintsFree(constraints, k)) u[k] = part * u[k] + (1. - part) * dt * v_old[k];
  }
}

void MpmLightNodesLimit(const MpmModel model, PetscReal dt, PetscReal u[])
{
  Limit(model, LIGHT, dt, u);
}

void MpmLightNodesLimitGradients(const MpmModel model, PetscReal kick, PetscReal dt, PetscReal u[])
{
  const PetscInt dim = model->disc.dim, count = model->disc.space->local * dim;

  for (PetscInt k = 0; k < count; k++) u[k] -= dt * kick * model->disc.sum->step.gravity[k % dim];
  Limit(model, LIGHT_AFFINE, dt, u);
  for (PetscInt k = 0; k < count; k++) u[k] += dt * kick * model->disc.sum->step.gravity[k % dim];
}

PetscErrorCode MpmLightNodesLimitContact(MpmModel model, PetscReal dt)
{
  const PetscReal least = LeastMass(model, LIGHT);
  PetscReal      *mass;

  PetscFunctionBeginUser;
  if (!(MpmTermsTraits(model->disc.terms) & MPM_TERM_CONTACT)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(model->disc.space->local, &mass));
  for (PetscInt i = 0; i < model->disc.space->local; i++)
    mass[i] = model->disc.context.inertia->mass[i] > 0. ? PetscMax(model->disc.context.inertia->mass[i], least) : 0.;
  PetscCall(MpmTermsLimit(model->disc.terms, model->disc.sum, mass, dt));
  PetscCall(PetscFree(mass));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Absorbing conditions: dashpots at the nodes of a plane where the material ends, with the impedance of material beyond
  it,

    t = -rho c_p v_n n - rho c_s v_t ,     c_p = sqrt(M/rho) ,  c_s = sqrt(G/rho)

  with the moduli of the points in the cells beside the plane, at their states. Shapes have the value of their edge at
  the nodes on it: a node's area is the sum of V_p/h, over the points of the first cells, times their weights along the
  plane. An incoming wave with the velocity v through the plane has the force 2 rho c v.

  Waves of normal incidence are absorbed wholly; others less, by their angle.

  Source: Lysmer, Kuhlemeyer (1969), J. Eng. Mech. Div. ASCE 95, 859-877; Joyner, Chen (1975), Bull. Seism. Soc. Am. 65,
  1315-1336, for incoming waves.
*/
#include "geometry/geometry.h"
#include "point/material.h"
#include "grid/grid.h"
#include "particles/point_mass.h"
#include "particles/points.h"
#include "space/basis.h"
#include "space/space.h"
#include "space/sum.h"
#include "bc/bc.h"
#include "volume/damping.h"

/* sqrt(m V M) of a point, which is V rho c, of waves across and along the plane. */
static void Impedances(const MpmSum *sum, PetscInt p, PetscReal impedance[2])
{
  const MpmPoints   *points   = sum->points;
  const MpmMaterial *material = &sum->materials[points->material[p]];
  const double      *own      = MpmPointOwn(points, material, p);
  const PetscReal   *state = points->state ? &points->state[p * sum->kept.state] : NULL, *F = MpmPointF(points, p);
  const PetscReal    mass = MpmPointMass(points, sum->materials, p), volume = points->volume0[p];
  const PetscReal    shear = MpmMaterialShearModulus(material, own, state, F);

  impedance[0] = PetscSqrtReal(mass * volume * PetscMax(MpmMaterialStiffness(material, own, state, F), 0.));
  impedance[1] = PetscSqrtReal(mass * volume * PetscMax(shear, 0.));
}

/* Which local nodes are the condition's. */
static void MarkNodes(const MpmCondition *bc, const MpmSum *sum, PetscBool mark[])
{
  for (PetscInt i = 0; i < sum->space->local; i++) {
    PetscInt  at[MPM_MAX_DIM];
    PetscReal x[MPM_MAX_DIM];

    mark[i] = PETSC_FALSE;
    if (MpmSpaceIsExtra(sum->space, i)) continue;
    MpmSpaceAt(sum->space, &sum->space->node[i * sum->space->dim], at);
    MpmGridNodeAtStart(sum->grid, at, x);
    mark[i] = MpmRegionContains(bc->region, x);
  }
}

/* One point's share of the dashpots of the marked nodes of its group. */
static void AddPoint(const MpmCondition *bc, const MpmSum *sum, const MpmGroup *group, PetscInt p,
                     const PetscBool mark[], PetscReal dashpot[])
{
  const MpmSpace *space = sum->space;
  const MpmGrid  *grid  = sum->grid;
  const PetscInt  dim = space->dim, axis = bc->across, *nodes = &space->group_nodes[group->node_offset];
  PetscReal       impedance[2] = {-1., 0.};

  for (PetscInt n = 0; n < group->node_count; n++) {
    PetscInt  at[MPM_MAX_DIM];
    PetscReal weight;

    if (nodes[n] < 0 || !mark[nodes[n]]) continue;
    MpmSpaceAt(space, &space->node[nodes[n] * dim], at);
    if (PetscAbsReal(sum->points->x[p * dim + axis] - grid->lower[axis] -
                     grid->h[axis] * MpmGridNodeXi(grid, at[axis])) >= grid->h[axis])
      continue;
    if (impedance[0] < 0.) Impedances(sum, p, impedance);
    weight = MpmSpaceWeightAcross(space, group, p, axis, n) / grid->h[axis];
    for (PetscInt c = 0; c < bc->component_count; c++) {
      const PetscInt component = bc->component[c];

      dashpot[nodes[n] * dim + component] += weight * impedance[component == axis ? 0 : 1];
    }
  }
}

/* Adds the dashpots of a condition; all ranks know all of those at their local nodes. */
static PetscErrorCode AddCondition(const MpmCondition *bc, const MpmSum *sum, PetscReal dashpot[])
{
  const MpmSpace *space = sum->space;
  const PetscInt  count = space->local * space->dim;
  PetscBool      *mark;
  PetscReal      *own;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(space->local, &mark));
  PetscCall(PetscCalloc1(count, &own));
  MarkNodes(bc, sum, mark);
  for (PetscInt g = 0; g < space->group_count; g++) {
    const MpmGroup *group = &space->groups[g];
    PetscBool       any   = PETSC_FALSE;

    for (PetscInt n = 0; n < group->node_count && !any; n++) {
      const PetscInt node = space->group_nodes[group->node_offset + n];

      any = (PetscBool)(node >= 0 && mark[node]);
    }
    for (PetscInt s = group->point_begin; any && s < group->point_end; s++)
      AddPoint(bc, sum, group, space->order[s], mark, own);
  }
  PetscCall(MpmSpaceAddToOwners(space, space->dim, own));
  PetscCall(MpmSpaceToGhosts(space, space->dim, own));
  for (PetscInt k = 0; k < count; k++) dashpot[k] += own[k];
  PetscCall(PetscFree(own));
  PetscCall(PetscFree(mark));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmAbsorbingDashpots(const MpmDamping *damping, const MpmSum *sum, PetscReal dashpot[])
{
  PetscFunctionBeginUser;
  for (PetscInt b = 0; b < damping->conditions->count; b++)
    if (damping->conditions->at[b].absorbing && damping->acting[b].active)
      PetscCall(AddCondition(&damping->conditions->at[b], sum, dashpot));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmAbsorbingSpread(MpmDamping *damping, const MpmSpace *space, const MpmMassMatrix *mass)
{
  const PetscInt dim = space->dim;
  PetscReal     *plane;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1((space->local * dim + 1), &plane));
  for (PetscInt i = 0; i < mass->nodes; i++)
    for (PetscInt k = mass->start[i]; k < mass->start[i + 1]; k++)
      for (PetscInt c = 0; c < dim; c++)
        if (damping->dashpot[mass->column[k] * dim + c] > 0.) plane[i * dim + c] += mass->value[k];
  PetscCall(MpmSpaceAddToOwners(space, dim, plane));
  PetscCall(MpmSpaceToGhosts(space, dim, plane));
  for (PetscInt k = 0; k < space->local * dim; k++) {
    plane[k]            = plane[k] > 0. ? damping->dashpot[k] / plane[k] : 0.;
    damping->dashpot[k] = 0.;
  }
  damping->mass_matrix = mass;
  damping->spread      = plane;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmAbsorbingLoad(const MpmDamping *damping, const MpmSum *sum, PetscReal time, PetscReal scale,
                                PetscReal force[])
{
  const PetscInt dim = sum->space->dim, bs = sum->block;
  PetscReal     *dashpot;

  PetscFunctionBeginUser;
  for (PetscInt b = 0; b < damping->conditions->count; b++) {
    const MpmCondition *bc = &damping->conditions->at[b];
    PetscReal           factor, size = 0.;

    if (!bc->absorbing || !damping->acting[b].active) continue;
    factor = 2. * scale * MpmRampIntegral(bc->ramp, time - damping->acting[b].start, (PetscInt)bc->quantity - 1);
    for (PetscInt c = 0; c < bc->component_count; c++) size += PetscAbsReal(bc->value[c]);
    if (factor * size == 0.) continue;
    PetscCall(PetscCalloc1((sum->space->local * dim), &dashpot));
    PetscCall(AddCondition(bc, sum, dashpot));
    for (PetscInt i = 0; i < sum->space->owned; i++)
      for (PetscInt c = 0; c < bc->component_count; c++)
        force[i * bs + bc->component[c]] += factor * dashpot[i * dim + bc->component[c]] * bc->value[c];
    PetscCall(PetscFree(dashpot));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Resistance of the bed at the nodes, implicit: after the velocity increment of a step over the time k a node has the
  speed u that solves

    m (u - u*) + k F(u) = 0 ,   F = sum of m_k tau_k(q u)/(rho_k h_k) times q' over its materials k ,

  u* the speed without resistance, and 0 where k F(0) >= m u*: what the bed can hold is at rest to the last digit. q is
  the speed along the bed over the horizontal one; area of the bed over its plan and the horizontal part of a stress
  along the motion make q' = sqrt(1 + s^2)/q. With -mpm_slope vertical both are 1.

  In a forest F has the sum of m_k a (u/q)^2, too: vertical stems resist horizontally with m a u^2 (forest.h), of which
  the bed takes the part normal to it.

  With -mpm_curvature pressure the pressure normal to the bed is rho h c (g + b u^2), at least 0, with b = n . H n along
  the motion n, of the second differences H of the bed at the nodes.
*/
#include "talus/point/basal.h"
#include "point/material.h"
#include "point/resisted_speed.h"
#include "grid/grid.h"
#include "space/space.h"
#include "space/sum.h"
#include "terrain/bed_flow.h"

/* A node that flows: geometry of its bed, and its materials. */
typedef struct {
  const MpmBedFlow *flow;
  const MpmSum     *sum;
  PetscInt          node;
  PetscReal         cosine2, along, part; /* c, q and q' */
  PetscReal         bend;                 /* of the bed along the motion, 1/m: b */
  PetscReal         drag;                 /* of a forest, 1/m: a */
} Node;

/* F at a speed, N. */
static PetscReal Resistance(const void *of, PetscReal speed)
{
  const Node    *node      = (const Node *)of;
  const PetscInt materials = node->flow->materials;
  PetscReal      force     = 0.;

  for (PetscInt k = 0; k < materials; k++) {
    const MpmMaterial *material  = &node->sum->materials[k];
    const PetscReal   *share     = &node->flow->shares[(node->node * materials + k) * MPM_BED_SHARES];
    const double      *parameter = MpmBedParameters(node->flow, node->sum->materials, k);
    const PetscReal    density = parameter[MPM_BASAL_DENSITY], g = parameter[MPM_BASAL_GRAVITY];
    const PetscReal    heavy = PetscMax(g + node->bend * speed * speed, 0.);
    PetscReal          depth;
    MpmBasalPoint      point;

    if (!(share[MPM_BED_SHARE] > 0.)) continue;
    depth = share[MPM_BED_SHARE] / share[MPM_BED_OVER_DEPTH];
    point = (MpmBasalPoint){.depth    = depth * PetscSqrtReal(node->cosine2),
                            .pressure = density * heavy * depth * node->cosine2,
                            .speed    = node->along * speed};
    force += share[MPM_BED_SHARE] * node->part * material->basal->resistance(parameter, &point) / (density * depth);
    force += share[MPM_BED_SHARE] * node->drag * PetscSqr(speed / node->along);
  }
  return force;
}

/* Shear stress at a speed, the mean over the areas of the materials, Pa. */
static PetscReal Shear(const Node *node, PetscReal speed)
{
  const PetscInt materials = node->flow->materials;
  Node           bare      = *node;
  PetscReal      area      = 0.;

  bare.drag = 0.;
  for (PetscInt k = 0; k < materials; k++)
    area += node->flow->shares[(node->node * materials + k) * MPM_BED_SHARES + MPM_BED_OVER_DEPTH] /
            node->sum->materials[k].parameter[MPM_BASAL_DENSITY];
  return Resistance(&bare, speed) / (area * node->part);
}

/* Parameters of all materials at a node. */
static void TakeParameters(const MpmSum *sum, PetscInt node, MpmBedFlow *flow)
{
  PetscReal x[MPM_MAX_DIM];

  MpmGridNodeAtStart(sum->grid, &sum->space->node[node * 2], x);
  for (PetscInt k = 0; k < flow->materials; k++)
    for (size_t i = 0; i < sum->materials[k].info.parameter_count; i++)
      flow->own[k * MPM_BED_PARAMETERS + (PetscInt)i] = sum->materials[k].parameter[i];
  for (PetscInt k = 0; k < flow->by_map.count; k++)
    flow->own[flow->by_map.at[k].material * MPM_BED_PARAMETERS + flow->by_map.at[k].place] =
      MpmMapAt(&flow->by_map.at[k].map, x);
}

/* n . H n at a node; at an edge of the grid that of the next node inside. */
static PetscReal Bend(const MpmSum *sum, const MpmBed *bed, PetscInt i, const PetscReal n[])
{
  const MpmGrid  *grid            = sum->grid;
  const PetscReal part[2]         = {n[0] / grid->h[0], n[1] / grid->h[1]};
  PetscInt        at[MPM_MAX_DIM] = {0};
  PetscReal       z[3][3];

  for (PetscInt a = 0; a < 2; a++)
    at[a] = PetscClipInterval(sum->space->node[i * 2 + a], 1, PetscMax(grid->nodes[a] - 2, 1));
  for (PetscInt k = 0; k < 9; k++) {
    PetscInt  node[MPM_MAX_DIM] = {0};
    PetscReal x[MPM_MAX_DIM];

    for (PetscInt a = 0; a < 2; a++) {
      node[a] = at[a] + (a ? k / 3 : k % 3) - 1;
      if (grid->nodes[a] < 3) node[a] = 0; /* an axis of one cell has no curvature */
    }
    MpmGridNodeAtStart(grid, node, x);
    z[k % 3][k / 3] = MpmBedHeight(bed, x);
  }
  return part[0] * part[0] * (z[0][1] - 2. * z[1][1] + z[2][1]) +
         part[1] * part[1] * (z[1][0] - 2. * z[1][1] + z[1][2]) +
         0.5 * part[0] * part[1] * (z[2][2] - z[0][2] - z[2][0] + z[0][0]);
}

/* Place of a node on the grid's lattice, x fastest. */
static PetscInt Place(const MpmSum *sum, PetscInt i)
{
  PetscInt at[MPM_MAX_DIM];

  MpmSpaceAt(sum->space, &sum->space->node[i * 2], at);
  return at[0] + sum->grid->nodes[0] * at[1];
}

PetscErrorCode MpmBedResist(void *ctx, const MpmSum *sum, const PetscReal mass[], PetscReal kick, PetscReal velocity[])
{
  MpmBedFlow *flow = ctx;

  PetscFunctionBeginUser;
  PetscCall(PetscArrayzero(flow->friction, sum->space->local * sum->block));
  if (flow->on_bed.shear) PetscCall(PetscArrayzero(flow->on_bed.shear, sum->space->local));
  for (PetscInt i = 0; i < sum->space->local; i++) {
    const PetscReal *sums = &flow->sums[i * MPM_BED_SUMS];
    PetscReal *v = &velocity[i * sum->block], speed = PetscSqrtReal(v[0] * v[0] + v[1] * v[1]), slope[2], along, to;
    const PetscReal before[2] = {v[0], v[1]};
    Node            node      = {.flow = flow, .sum = sum, .node = i, .cosine2 = 1., .along = 1., .part = 1.};

    if (!(mass[i] > 0.) || !(speed > 0.)) continue;
    if (flow->bed->normal) {
      for (PetscInt a = 0; a < 2; a++) slope[a] = sums[MPM_BED_SLOPE + a] / sums[MPM_BED_MASS];
      node.cosine2 = MpmBedCosine2(flow->bed, slope);
      if (flow->bed->curvature == MPM_BED_PRESSURE) node.bend = Bend(sum, flow->bed, i, v) / (speed * speed);
      along      = (v[0] * slope[0] + v[1] * slope[1]) / speed;
      node.along = PetscSqrtReal(1. + along * along);
      node.part  = 1. / (PetscSqrtReal(node.cosine2) * node.along);
    }
    if (flow->own) TakeParameters(sum, i, flow);
    if (flow->drag) node.drag = flow->drag[Place(sum, i)];
    to = MpmResistedSpeed(mass[i], kick, speed, Resistance, &node);
    if (flow->on_bed.shear && to > 0.) flow->on_bed.shear[i] = (MpmBedShear){Shear(&node, to), node.along * to};
    for (PetscInt a = 0; a < 2; a++) {
      v[a]                               = to == 0. ? 0. : v[a] * to / speed;
      flow->friction[i * sum->block + a] = mass[i] * (v[a] - before[a]) / kick;
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmBedWork(const void *ctx, const MpmSum *sum, const PetscReal at[], const PetscReal u[],
                          MpmTermWork *work)
{
  const MpmBedFlow *flow = ctx;

  (void)at;
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < sum->space->owned * sum->block; k++) {
    work->external += flow->force[k] * u[k];
    work->dissipated -= flow->friction[k] * u[k];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

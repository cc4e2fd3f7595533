/*
  Force of the flow on dams that have been raised on the bed, from the points p and the nodes i of a step:

    F = sum_p rho g c V (s_R + m s_G, -m) - sum_i m_i (f_i, f_i.s_i) + sum_p m_p (impulse where the path turns)/dt

  the pressure normal to the bed under the slope s = s_R + s_G (bed_flow.h), and the resistance f_i of the bed. s_R is
  the slope of the height R that the dam has added, s_G that of all else, as the weights of the point see them. m is 1
  for points on the dam, m_i at nodes there; both are R over the sum of heights where dams lie on one another. A dam's
  slope counts wherever a point has it: on level ground the horizontal force is all that the bed exerts. c goes to 1
  where points are in balance with water at rest, whose pressure is rho g h. With -mpm_curvature, points that turn at
  a dam leave it their change of momentum (bed_turn.c).
*/
#include "talus/point/basal.h"
#include "point/material.h"
#include "grid/grid.h"
#include "particles/point_mass.h"
#include "particles/points.h"
#include "space/lanes.h"
#include "space/space.h"
#include "space/sum.h"
#include "terrain/dam_force.h"

/* Height of a dam at a place, m. */
static PetscReal HeightAt(const MpmMap *height, const PetscReal x[])
{
  const PetscReal last[] = {height->x0 + (PetscReal)(height->columns - 1) * height->cell[0],
                            height->y0 + (PetscReal)(height->rows - 1) * height->cell[1]};

  if (!height->value || x[0] < height->x0 || x[1] < height->y0 || x[0] > last[0] || x[1] > last[1]) return 0.;
  return MpmMapAt(height, x);
}

/* Share of a dam in a place: 1 on it, or by heights where there are several. */
static PetscReal ShareOf(const MpmBedDams *dams, PetscInt dam, const PetscReal x[])
{
  PetscReal own = 0., all = 0.;

  for (PetscInt k = 0; k < dams->count; k++) {
    const PetscReal height = PetscAbsReal(HeightAt(&dams->height[k], x));

    all += height;
    if (k == dam) own = height;
  }
  return own > 0. ? own / all : 0.;
}

/* Of each dam at the local nodes: its height, m, and the share of the node. */
typedef struct {
  PetscReal height, share;
} AtNode;

static PetscBool FindNodes(const MpmBedDams *dams, const MpmSum *sum, AtNode nodes[])
{
  PetscBool any = PETSC_FALSE;

  for (PetscInt i = 0; i < sum->space->local; i++) {
    PetscReal x[MPM_MAX_DIM];

    MpmGridNodeAtStart(sum->grid, &sum->space->node[i * 2], x);
    for (PetscInt k = 0; k < dams->count; k++) {
      nodes[i * dams->count + k] = (AtNode){HeightAt(&dams->height[k], x), ShareOf(dams, k, x)};
      any                        = (PetscBool)(any || nodes[i * dams->count + k].share > 0.);
    }
  }
  return any;
}

/* Pressure of a group's points on one dam. */
MPM_INLINE PetscErrorCode AddGroup(const MpmKnown known, const MpmSum *sum, const MpmGroup *group, PetscInt dam,
                                   const AtNode at[], const MpmBasis *room, const MpmBedFlow *flow)
{
  const PetscInt *nodes = &sum->space->group_nodes[group->node_offset], count = flow->bed->dams.count;
  MpmBasis        basis = *room;
  PetscBool       any   = PETSC_FALSE;

  for (PetscInt i = 0; i < known.n && !any; i++) any = (PetscBool)(at[nodes[i] * count + dam].share > 0.);
  for (PetscInt s = group->point_begin; any && s < group->point_end; s++) {
    const PetscInt   p     = sum->space->order[s];
    const PetscReal *slope = flow->point[p].slope, c = MpmBedCosine2(flow->bed, slope);
    const PetscReal  share = ShareOf(&flow->bed->dams, dam, &sum->points->x[p * 2]);
    PetscReal        push  = MpmPointMass(sum->points, sum->materials, p) *
                     sum->materials[sum->points->material[p]].parameter[MPM_BASAL_GRAVITY];
    PetscReal own[2] = {0., 0.}, level = 0.;

    MpmSumBasis(known, sum->space, p, PETSC_TRUE, &basis);
    for (PetscInt i = 0; i < known.n; i++) {
      level += MpmBasisAt(&basis, 0, i) * flow->level[nodes[i] * MPM_LEVEL_COUNT + MPM_LEVEL_PART];
      for (PetscInt a = 0; a < 2; a++) own[a] += MpmBasisAt(&basis, 1 + a, i) * at[nodes[i] * count + dam].height;
    }
    push *= c + level * (1. - c);
    for (PetscInt a = 0; a < 2; a++) flow->on_bed.dams[dam][a] += push * (own[a] + share * (slope[a] - own[a]));
    flow->on_bed.dams[dam][2] -= push * share;
  }
  return PETSC_SUCCESS;
}

/* Resistance of the bed on its dams. */
static void AddResistance(const MpmSum *sum, const AtNode at[], const MpmBedFlow *flow)
{
  const PetscInt count = flow->bed->dams.count;

  for (PetscInt i = 0; i < sum->space->owned; i++) {
    const PetscReal *sums = &flow->sums[i * MPM_BED_SUMS], *f = &flow->friction[i * sum->block];

    if (!(sums[MPM_BED_MASS] > 0.)) continue;
    for (PetscInt k = 0; k < count; k++) {
      const PetscReal share = at[i * count + k].share;

      for (PetscInt a = 0; a < 2; a++) {
        flow->on_bed.dams[k][a] -= share * f[a];
        if (flow->bed->normal) flow->on_bed.dams[k][2] -= share * f[a] * sums[MPM_BED_SLOPE + a] / sums[MPM_BED_MASS];
      }
    }
  }
}

PetscErrorCode MpmDamsBegin(const MpmBedFlow *flow, const MpmSum *sum)
{
  const MpmBedDams *dams = &flow->bed->dams;
  AtNode           *at;
  MpmBasis          basis;

  PetscFunctionBeginUser;
  if (!dams->count) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscArrayzero(flow->on_bed.dams, dams->count));
  PetscCall(PetscCalloc1((size_t)(sum->space->local * dams->count) + 1, &at));
  if (FindNodes(dams, sum, at)) {
    PetscCall(MpmBasisCreate(sum->space, &basis));
    for (PetscInt k = 0; k < dams->count; k++)
      for (PetscInt g = 0; g < sum->space->group_count; g++)
        MPM_DISPATCH(sum->layout, &sum->space->groups[g], AddGroup, sum, &sum->space->groups[g], k, at, &basis, flow);
    PetscCall(MpmBasisDestroy(&basis));
    AddResistance(sum, at, flow);
  }
  PetscCall(PetscFree(at));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MpmDamsTurn(const MpmBedFlow *flow, const MpmSum *sum, PetscInt p, const PetscReal impulse[3])
{
  const MpmBedDams *dams = &flow->bed->dams;

  for (PetscInt k = 0; k < dams->count; k++) {
    PetscReal share = 0.;

    /* a bed bends over a cell about its kinks */
    for (PetscInt i = 0; i < 5; i++) {
      PetscReal x[] = {sum->points->x[p * 2], sum->points->x[p * 2 + 1]};

      if (i) x[(i - 1) / 2] += (i % 2 ? 0.5 : -0.5) * sum->grid->h[(i - 1) / 2];
      share = PetscMax(share, ShareOf(dams, k, x));
    }
    for (PetscInt a = 0; a < 3; a++) flow->on_bed.dams[k][a] += share * impulse[a] / sum->step.dt;
  }
}

PetscErrorCode MpmDamsEnd(const MpmBedFlow *flow, const MpmSum *sum)
{
  const PetscMPIInt count = (PetscMPIInt)(3 * flow->bed->dams.count);

  PetscFunctionBeginUser;
  if (!count) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, flow->on_bed.dams, count, MPIU_REAL, MPIU_SUM, sum->grid->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Forces of depth and slope at the nodes.
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

#define MOST_KNOWN 16   /* nodes of a group with a loop of its own */
#define FAILS      0.25 /* of the weights of a point's nodes: a front on a slope leaves that many without balance */

/* g of a column's material, m/s2. */
static PetscReal Gravity(const MpmSum *sum, PetscInt point)
{
  return sum->materials[sum->points->material[point]].parameter[MPM_BASAL_GRAVITY];
}

PetscErrorCode MpmBedFlowDestroy(MpmBedFlow **flow)
{
  PetscFunctionBeginUser;
  if (!*flow) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscFree((*flow)->point));
  PetscCall(PetscFree((*flow)->gentle.group));
  for (PetscInt k = 0; k < (*flow)->by_map.count; k++) PetscCall(MpmMapDestroy(&(*flow)->by_map.at[k].map));
  PetscCall(PetscFree((*flow)->by_map.at));
  PetscCall(PetscFree((*flow)->own));
  PetscCall(PetscFree7((*flow)->height, (*flow)->sums, (*flow)->shares, (*flow)->level, (*flow)->steep, (*flow)->failed,
                       (*flow)->force));
  PetscCall(PetscFree((*flow)->friction));
  PetscCall(PetscFree((*flow)->on_bed.shear));
  PetscCall(PetscFree((*flow)->drag));
  PetscCall(PetscFree((*flow)->on_bed.dams));
  PetscCall(PetscFree(*flow));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Room for a step's points and nodes; sums are 0. */
static PetscErrorCode Resize(const MpmSum *sum, MpmBedFlow *flow)
{
  const PetscInt nodes = sum->space->local, shares = flow->materials * MPM_BED_SHARES;

  PetscFunctionBeginUser;
  if (sum->points->count > flow->room.points) {
    flow->room.points = sum->points->count + sum->points->count / 8;
    PetscCall(PetscFree(flow->point));
    PetscCall(PetscMalloc1(flow->room.points, &flow->point));
  }
  if (nodes > flow->room.nodes) {
    flow->room.nodes = nodes + nodes / 8;
    PetscCall(PetscFree7(flow->height, flow->sums, flow->shares, flow->level, flow->steep, flow->failed, flow->force));
    PetscCall(PetscMalloc7(flow->room.nodes, &flow->height, (flow->room.nodes * MPM_BED_SUMS), &flow->sums,
                           (flow->room.nodes * shares), &flow->shares, (flow->room.nodes * MPM_LEVEL_COUNT),
                           &flow->level, (flow->room.nodes * MPM_STEEP_COUNT), &flow->steep, flow->room.nodes,
                           &flow->failed, (flow->room.nodes * sum->block), &flow->force));
    PetscCall(PetscRealloc(sizeof(PetscReal) * (size_t)(flow->room.nodes * sum->block), &flow->friction));
    if (flow->on_bed.shear)
      PetscCall(PetscRealloc(sizeof(*flow->on_bed.shear) * (size_t)flow->room.nodes, &flow->on_bed.shear));
  }
  PetscCall(PetscArrayzero(flow->sums, nodes * MPM_BED_SUMS));
  PetscCall(PetscArrayzero(flow->shares, nodes * shares));
  PetscCall(PetscArrayzero(flow->steep, nodes * MPM_STEEP_COUNT));
  PetscCall(PetscArrayzero(flow->failed, nodes));
  PetscCall(PetscArrayzero(flow->force, nodes * sum->block));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The bed at the local nodes. */
static void FindHeights(const MpmSum *sum, MpmBedFlow *flow)
{
  for (PetscInt i = 0; i < sum->space->local; i++) {
    PetscReal x[MPM_MAX_DIM];

    MpmGridNodeAtStart(sum->grid, &sum->space->node[i * 2], x);
    flow->height[i] = MpmBedHeight(flow->bed, x);
  }
}

/* Area of a point's domain, m2: of thin points at a front, whose bases grow on, less than the volume over the depth. */
static PetscReal Covered(const MpmSum *sum, PetscInt p, PetscReal area)
{
  const PetscReal *half = sum->space->shapes.half;

  return half ? PetscMin(area, 4. * half[p * 2] * half[p * 2 + 1] * sum->cell[0] * sum->cell[1]) : area;
}

/* A point's forces where no node is in balance with water at rest. */
typedef struct {
  PetscReal weight, c, pressure, lean; /* rho g V, N; cos^2; along the bed, and its part c (1 - c)/s^2, N m */
} Forces;

MPM_INLINE Forces FindForces(const MpmSum *sum, PetscInt p, const MpmBedFlow *flow)
{
  const MpmOnBed *at     = &flow->point[p];
  const PetscReal weight = MpmPointMass(sum->points, sum->materials, p) * Gravity(sum, p);
  const PetscReal c      = MpmBedCosine2(flow->bed, at->slope);
  const PetscReal push   = 0.5 * c * weight * at->depth * MpmBedEarthPressure(sum, p, at->depth, c);

  return (Forces){weight, c, push, flow->bed->normal ? c * push : 0.};
}

/* A point and its bed; its part of the sums at its nodes, and its forces where the surface is not level. */
MPM_INLINE void AddPoint(const MpmKnown known, const MpmSum *sum, const PetscInt nodes[], PetscInt p,
                         const MpmBasis *basis, MpmBedFlow *flow)
{
  const MpmPoints *points   = sum->points;
  const PetscInt   material = points->material[p];
  const PetscReal  volume = points->volume0[p], depth = points->state[p * sum->kept.state];
  const PetscReal  mass = MpmPointMass(points, sum->materials, p), covered = Covered(sum, p, volume / depth);
  PetscReal        bed = 0., slope[2] = {0., 0.};
  Slim             first, by, second;
  Forces           of;
  MpmTwo           shared = {mass, mass / depth};

  for (PetscInt i = 0; i < known.n; i++) {
    const PetscReal Z = flow->height[nodes[i]];

    bed += MpmBasisAt(basis, 0, i) * Z;
    slope[0] += MpmBasisAt(basis, 1, i) * Z;
    slope[1] += MpmBasisAt(basis, 2, i) * Z;
  }
  flow->point[p] = (MpmOnBed){.area = volume / depth, .depth = depth, .bed = bed, .slope = {slope[0], slope[1]}};
  first          = (Slim){volume, volume * depth, 0., volume * 0.5 * PetscSqrtReal(covered)};
  by             = (Slim){0., volume, volume, 0.};
  second         = (Slim){covered, mass, mass * slope[0], mass * slope[1]};
  of             = FindForces(sum, p, flow);
  for (PetscInt i = 0; i < known.n; i++) {
    const MpmTwo    gradient = {MpmBasisAt(basis, 1, i), MpmBasisAt(basis, 2, i)}, down = {slope[0], slope[1]};
    const PetscReal w    = MpmBasisAt(basis, 0, i);
    Slim           *sums = (Slim *)&flow->sums[nodes[i] * MPM_BED_SUMS];

    sums[0] += (first + by * (bed - flow->height[nodes[i]])) * w;
    sums[1] += second * w;
    *(MpmTwo *)&flow->shares[(nodes[i] * flow->materials + material) * MPM_BED_SHARES] += shared * w;
    *(MpmTwo *)&flow->force[nodes[i] * 2] +=
      gradient * of.pressure -
      down * (of.c * w * of.weight + of.lean * (gradient[0] * slope[0] + gradient[1] * slope[1]));
  }
}

/* A point's part of the slopes at its nodes. */
MPM_INLINE void AddSlopes(const MpmKnown known, const PetscInt nodes[], PetscInt p, const MpmBasis *basis,
                          MpmBedFlow *flow)
{
  const MpmOnBed *at     = &flow->point[p];
  const PetscReal volume = at->area * at->depth, level = at->depth + at->bed;
  PetscReal       slope[2] = {0., 0.};
  MpmTwo          squares;

  for (PetscInt i = 0; i < known.n; i++) {
    const PetscReal above = flow->level[nodes[i] * MPM_LEVEL_COUNT + MPM_LEVEL] - level;

    for (PetscInt a = 0; a < 2; a++) slope[a] += MpmBasisAt(basis, 1 + a, i) * above;
  }
  squares = (MpmTwo){PetscSqr(slope[0]) + PetscSqr(slope[1]), PetscSqr(at->slope[0]) + PetscSqr(at->slope[1])} * volume;
  for (PetscInt i = 0; i < known.n; i++)
    *(MpmTwo *)&flow->steep[nodes[i] * MPM_STEEP_COUNT] += squares * MpmBasisAt(basis, 0, i);
}

/* Where the balance fails at a share of a point's nodes, it fails at all of them: the point's part of that. */
MPM_INLINE void AddFailures(const MpmKnown known, const PetscInt nodes[], PetscInt p, const MpmBasis *basis,
                            MpmBedFlow *flow)
{
  const PetscReal volume = flow->point[p].area * flow->point[p].depth;
  PetscReal       fails  = 0.;

  for (PetscInt i = 0; i < known.n; i++)
    fails += MpmBasisAt(basis, 0, i) * (1. - flow->level[nodes[i] * MPM_LEVEL_COUNT + MPM_LEVEL_PART]);
  for (PetscInt i = 0; i < known.n; i++)
    flow->failed[nodes[i]] += MpmBasisAt(basis, 0, i) * volume * PetscMin(fails / FAILS, 1.);
}

/* True where forces are other than those of AddPoint(): the surface is level, or points fill what a level wets. */
static PetscBool IsLevel(const MpmBedFlow *flow, PetscInt node)
{
  const PetscReal *level = &flow->level[node * MPM_LEVEL_COUNT];

  return (PetscBool)(level[MPM_LEVEL_PART] != 0. || (flow->bed->normal && level[MPM_LEVEL_TILT] != 1. &&
                                                     flow->steep[node * MPM_STEEP_COUNT + MPM_STEEP_BED] > 0.));
}

/*
  A point's forces on those of its nodes that have them in place of AddPoint()'s. 1 - c is s^2 c on slopes s, so that M
  is c (I - k c s s^T).
*/
MPM_INLINE void AddForce(const MpmKnown known, const MpmSum *sum, const PetscInt nodes[], PetscInt p,
                         const MpmBasis *basis, MpmBedFlow *flow)
{
  const MpmOnBed *at    = &flow->point[p];
  const Forces    of    = FindForces(sum, p, flow);
  const MpmTwo    slope = {at->slope[0], at->slope[1]};

  for (PetscInt i = 0; i < known.n; i++) {
    const PetscReal *level    = &flow->level[nodes[i] * MPM_LEVEL_COUNT];
    const MpmTwo     gradient = {MpmBasisAt(basis, 1, i), MpmBasisAt(basis, 2, i)};
    const PetscReal  d = level[MPM_LEVEL] - at->bed, D = level[MPM_LEVEL] - level[MPM_LEVEL_BED];
    const PetscReal  rest = level[MPM_LEVEL_PART] * of.weight / at->depth;
    const PetscReal  push = of.pressure - 0.5 * rest * (of.c * d * d - level[MPM_LEVEL_WET] * D * D);
    const PetscReal  pull = of.c * MpmBasisAt(basis, 0, i) * (of.weight - rest * d) +
                           of.lean * level[MPM_LEVEL_TILT] * (gradient[0] * slope[0] + gradient[1] * slope[1]);

    if (IsLevel(flow, nodes[i])) *(MpmTwo *)&flow->force[nodes[i] * 2] += gradient * push - slope * pull;
  }
}

typedef enum { POINTS, SLOPES, FAILURES, FORCES } Visit;

/* True where the part of the balance is this number at all nodes of a group. */
static PetscBool HasPart(const MpmGroup *group, const PetscInt nodes[], PetscReal part, const MpmBedFlow *flow)
{
  for (PetscInt i = 0; i < group->node_count; i++)
    if (flow->level[nodes[i] * MPM_LEVEL_COUNT + MPM_LEVEL_PART] != part) return PETSC_FALSE;
  return PETSC_TRUE;
}

/* True where forces of a group's points are other than those of AddPoint() at any of their nodes. */
static PetscBool HasLevel(const MpmGroup *group, const PetscInt nodes[], const MpmBedFlow *flow)
{
  for (PetscInt i = 0; i < group->node_count; i++)
    if (IsLevel(flow, nodes[i])) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* The points of a group. */
MPM_INLINE PetscErrorCode VisitGroup(const MpmKnown known, Visit visit, const MpmSum *sum, const MpmGroup *group,
                                     const MpmBasis *room, MpmBedFlow *flow)
{
  const PetscInt *nodes = &sum->space->group_nodes[group->node_offset];
  PetscReal       storage[MPM_BASES * MOST_KNOWN];
  MpmBasis        basis;

  /* where the balance fails nowhere or everywhere a point's part changes nothing */
  if (visit == FAILURES && (HasPart(group, nodes, 0., flow) || HasPart(group, nodes, 1., flow))) return PETSC_SUCCESS;
  if (visit == FORCES && !HasLevel(group, nodes, flow)) return PETSC_SUCCESS;
  if (known.solid) MpmBasisPlace(sum->space, known.n, storage, &basis);
  else basis = *room;
  for (PetscInt s = group->point_begin; s < group->point_end; s++) {
    const PetscInt p = sum->space->order[s];

    MpmSumFetch(known, sum, s);
    MpmSumBasis(known, sum->space, p, PETSC_TRUE, &basis);
    if (visit == POINTS) AddPoint(known, sum, nodes, p, &basis, flow);
    else if (visit == SLOPES) AddSlopes(known, nodes, p, &basis, flow);
    else if (visit == FAILURES) AddFailures(known, nodes, p, &basis, flow);
    else AddForce(known, sum, nodes, p, &basis, flow);
  }
  return PETSC_SUCCESS;
}

/* A pass over the points of all groups or of the gentle ones, and the sums at the nodes of all ranks: `count` numbers a
   node. */
#define PASS(name, visit) \
  static PetscErrorCode name(const MpmSum *sum, const MpmBasis *room, PetscInt count, PetscReal sums[], \
                             MpmBedFlow *flow) \
  { \
    const MpmSpace *space  = sum->space; \
    const PetscInt  groups = (visit) == POINTS ? space->group_count : flow->gentle.count; \
\
    PetscFunctionBeginUser; \
    for (PetscInt k = 0; k < groups; k++) { \
      const MpmGroup *group = &space->groups[(visit) == POINTS ? k : flow->gentle.group[k]]; \
\
      MPM_DISPATCH(sum->layout, group, VisitGroup, visit, sum, group, room, flow); \
    } \
    PetscCall(MpmSpaceAddToOwners(space, count, sums)); \
    PetscCall(MpmSpaceToGhosts(space, count, sums)); \
    PetscFunctionReturn(PETSC_SUCCESS); \
  }
PASS(PassPoints, POINTS)
PASS(PassSlopes, SLOPES)
PASS(PassFailures, FAILURES)
PASS(PassForces, FORCES)

static PetscErrorCode Push(void *ctx, const MpmSum *sum, PetscReal force[])
{
  MpmBedFlow    *flow   = ctx;
  const PetscInt shares = flow->materials * MPM_BED_SHARES;
  MpmBasis       basis;

  PetscFunctionBeginUser;
  PetscCall(Resize(sum, flow));
  FindHeights(sum, flow);
  PetscCall(MpmBasisCreate(sum->space, &basis));
  PetscCall(PassPoints(sum, &basis, MPM_BED_SUMS, flow->sums, flow));
  PetscCall(MpmSpaceAddToOwners(sum->space, shares, flow->shares));
  PetscCall(MpmSpaceToGhosts(sum->space, shares, flow->shares));
  MpmBedFindMeans(sum, flow);
  PetscCall(MpmBedFindGentle(sum, flow));
  PetscCall(PassSlopes(sum, &basis, MPM_STEEP_COUNT, flow->steep, flow));
  MpmBedFindLevels(sum, flow);
  PetscCall(PetscArrayzero(flow->failed, sum->space->local));
  PetscCall(PassFailures(sum, &basis, 1, flow->failed, flow));
  for (PetscInt i = 0; i < sum->space->local; i++)
    flow->level[i * MPM_LEVEL_COUNT + MPM_LEVEL_PART] *=
      PetscMax(1. - flow->failed[i] / (FAILS * flow->sums[i * MPM_BED_SUMS + MPM_BED_VOLUME]), 0.);
  for (PetscInt i = 0; i < sum->space->local; i++)
    if (IsLevel(flow, i)) flow->force[i * 2] = flow->force[i * 2 + 1] = 0.;
  PetscCall(PassForces(sum, &basis, sum->block, flow->force, flow));
  for (PetscInt k = 0; k < sum->space->local * sum->block; k++) force[k] += flow->force[k];
  PetscCall(MpmBasisDestroy(&basis));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Commit(void *ctx, const MpmSum *sum, const PetscReal u[], MpmParticles *particles)
{
  const MpmBedFlow *flow = ctx;

  (void)particles;
  PetscFunctionBeginUser;
  PetscCall(MpmDamsBegin(flow, sum));
  PetscCall(MpmBedCalm(flow, sum));
  if (flow->bed->viscosity > 0.) PetscCall(MpmBedMix(flow, sum, u));
  if (flow->bed->curvature) MpmBedTurn(flow, sum);
  PetscCall(MpmDamsEnd(flow, sum));
  PetscCall(MpmBedStraighten(sum));
  PetscFunctionReturn(PETSC_SUCCESS);
}

const MpmTerm MpmTermBed = {
  .name = "bed", .energy.work = MpmBedWork, .motion.push = Push, .motion.resist = MpmBedResist, .step.commit = Commit};

/*
  The level of the points about a node, and how far they fill what it would wet.
*/
#include "grid/grid.h"
#include "space/space.h"
#include "space/sum.h"
#include "terrain/bed_flow.h"

#define HALF 8 /* places in a cell, an axis, that tell how much of it a level wets */
/* Filled parts of what a level would wet between which its balance begins to count: the domains of a lake's points fill
   all of it, those at a front a half or less. */
#define BALANCE_FROM  0.85
#define BALANCE_WHOLE 0.95
/* Slope of the surface over that of the bed, about a node: up to which it is level, and from which it is not. A flow of
   even depth has 1, a lake 0. */
#define LEVEL_TO  0.02
#define TILT_FROM 0.05

/* The bed at a node and its neighbours, z[1 + dx][1 + dy]; beyond the grid that of the edge. */
static void Around(const MpmGrid *grid, const MpmBed *bed, const PetscInt node[], PetscReal z[3][3])
{
  for (PetscInt i = -1; i <= 1; i++) {
    for (PetscInt j = -1; j <= 1; j++) {
      const PetscInt at[MPM_MAX_DIM] = {PetscClipInterval(node[0] + i, 0, grid->nodes[0] - 1),
                                        PetscClipInterval(node[1] + j, 0, grid->nodes[1] - 1), 0};
      PetscReal      x[MPM_MAX_DIM];

      MpmGridNodeAtStart(grid, at, x);
      z[1 + i][1 + j] = MpmBedHeight(bed, x);
    }
  }
}

/* The lowest and the highest of four heights. */
static void Range(const PetscReal z[4], PetscReal *lowest, PetscReal *highest)
{
  *lowest = *highest = z[0];
  for (PetscInt k = 1; k < 4; k++) {
    *lowest  = PetscMin(*lowest, z[k]);
    *highest = PetscMax(*highest, z[k]);
  }
}

/*
  Share of a linear support in one of its four cells that lies below a level by what the bed rises over half a point's
  width, parts of the cell; z of the node, beside it on either axis, and across. Continuous in the level: about each of
  the places the bed rises by its rise in the cell over their number.
*/
static PetscReal WetCell(const PetscReal z[4], PetscReal level, const PetscReal half[2])
{
  PetscReal lowest, highest, wet = 0., all = 0., rise;

  Range(z, &lowest, &highest);
  rise = (highest - lowest) / (PetscReal)HALF;
  if (level >= highest + rise + (half[0] + half[1]) * (highest - lowest)) return 1.;
  if (level <= lowest - rise) return 0.;
  for (PetscInt k = 0; k < HALF * HALF; k++) {
    const PetscReal p      = ((PetscReal)(k % HALF) + 0.5) / (PetscReal)HALF;
    const PetscReal q      = ((PetscReal)(k / HALF) + 0.5) / (PetscReal)HALF;
    const PetscReal height = (1. - q) * ((1. - p) * z[0] + p * z[1]) + q * ((1. - p) * z[2] + p * z[3]) +
                             half[0] * PetscAbsReal((1. - q) * (z[1] - z[0]) + q * (z[3] - z[2])) +
                             half[1] * PetscAbsReal((1. - p) * (z[2] - z[0]) + p * (z[3] - z[1]));

    all += (1. - p) * (1. - q);
    wet += (1. - p) * (1. - q) * PetscClipInterval(0.5 + (level - height) / rise, 0., 1.);
  }
  return wet / all;
}

/* Share of a node's linear support in the grid that lies so far below a level, of the bed that is bilinear between
   nodes. */
static PetscReal WetPart(const MpmGrid *grid, const PetscInt node[], PetscReal z[3][3], PetscReal level, PetscReal half)
{
  const PetscReal part[2] = {half / grid->h[0], half / grid->h[1]};
  PetscReal       wet = 0., count = 0.;

  for (PetscInt k = 0; k < 4; k++) {
    const PetscInt  a = 2 * (k % 2), b = 2 * (k / 2);
    const PetscReal cell[4] = {z[1][1], z[a][1], z[1][b], z[a][b]};

    if (node[0] + a - 1 < 0 || node[0] + a - 1 >= grid->nodes[0]) continue;
    if (node[1] + b - 1 < 0 || node[1] + b - 1 >= grid->nodes[1]) continue;
    wet += WetCell(cell, level, part);
    count += 1.;
  }
  return wet / count;
}

/* Area of a node's linear support in the grid, weighted, m2. */
static PetscReal Area(const MpmGrid *grid, const PetscInt node[])
{
  PetscReal area = 1.;

  for (PetscInt a = 0; a < 2; a++) area *= (node[a] == 0 || node[a] == grid->nodes[a] - 1 ? 0.5 : 1.) * grid->h[a];
  return area;
}

/* From 0 at one end to 1 at the other. */
static PetscReal Blend(PetscReal value, PetscReal from, PetscReal to)
{
  return PetscClipInterval((value - from) / (to - from), 0., 1.);
}

/*
  phi_i: how far points fill what the level would wet. Points of a lake have whole domains about centres beneath the
  level: at a shore they may leave as much of it as lies by half a point's width below the level.
*/
static PetscReal Balance(const MpmGrid *grid, const PetscInt node[], PetscReal z[3][3], PetscReal level,
                         const PetscReal sums[])
{
  const PetscReal half = sums[MPM_BED_HALF] / sums[MPM_BED_VOLUME];
  const PetscReal wet  = WetPart(grid, node, z, level, half);

  return wet > 0. ? Blend(sums[MPM_BED_AREA] / (Area(grid, node) * wet), BALANCE_FROM, BALANCE_WHOLE) : 1.;
}

/*
  r_i: 1 where all points that touch the node are there, also where their centres lie half a point's width beyond its
  neighbours; 0 where any may be missing, for then the sum of area times grad w, which it multiplies, is not 0.
*/
static PetscReal Whole(const MpmGrid *grid, PetscReal z[3][3], PetscReal level, PetscReal half)
{
  PetscReal highest = z[1][1], rise[2] = {0., 0.}, more;

  for (PetscInt i = 0; i < 3; i++) {
    for (PetscInt j = 0; j < 3; j++) {
      highest = PetscMax(highest, z[i][j]);
      if (i < 2) rise[0] = PetscMax(rise[0], PetscAbsReal(z[i + 1][j] - z[i][j]));
      if (j < 2) rise[1] = PetscMax(rise[1], PetscAbsReal(z[i][j + 1] - z[i][j]));
    }
  }
  more = 2. * half * (rise[0] / grid->h[0] + rise[1] / grid->h[1]);
  return more > 0. ? PetscClipInterval((level - highest) / more - 1., 0., 1.) : 1.;
}

void MpmBedFindMeans(const MpmSum *sum, MpmBedFlow *flow)
{
  for (PetscInt i = 0; i < sum->space->local; i++) {
    const PetscReal *sums  = &flow->sums[i * MPM_BED_SUMS];
    PetscReal       *level = &flow->level[i * MPM_LEVEL_COUNT];

    for (PetscInt k = 0; k < MPM_LEVEL_COUNT; k++) level[k] = 0.;
    if (!(sums[MPM_BED_VOLUME] > 0.)) continue;
    level[MPM_LEVEL]     = flow->height[i] + sums[MPM_BED_SURFACE] / sums[MPM_BED_VOLUME];
    level[MPM_LEVEL_BED] = flow->height[i] + sums[MPM_BED_HEIGHT] / sums[MPM_BED_VOLUME];
  }
}

/* Differences of the level and of the bed along an axis of a group, m. */
typedef struct {
  PetscReal least, most, bed; /* of the level, signed; the largest of the bed */
} Edges;

/* From each node of a group to the next one `stride` on, on an axis with `count` nodes. */
static Edges FindEdges(const MpmGroup *group, const PetscInt nodes[], PetscInt stride, PetscInt count,
                       const MpmBedFlow *flow)
{
  Edges edges = {PETSC_MAX_REAL, -PETSC_MAX_REAL, 0.};

  for (PetscInt i = 0; i + stride < group->node_count; i++) {
    const PetscInt  from = nodes[i], to = nodes[i + stride];
    const PetscReal rise =
      flow->level[to * MPM_LEVEL_COUNT + MPM_LEVEL] - flow->level[from * MPM_LEVEL_COUNT + MPM_LEVEL];

    if (stride == 1 && i % count == count - 1) continue;
    edges.least = PetscMin(edges.least, rise);
    edges.most  = PetscMax(edges.most, rise);
    edges.bed   = PetscMax(edges.bed, PetscAbsReal(flow->height[to] - flow->height[from]));
  }
  return edges;
}

/*
  True where the mean surface at all points of a group has more than TILT_FROM of the slope of the bed: gradients at a
  point are means of differences between its nodes.
*/
static PetscBool IsTilted(const MpmSum *sum, const MpmGroup *group, const MpmBedFlow *flow)
{
  const PetscInt *nodes = &sum->space->group_nodes[group->node_offset];
  const Edges     x     = FindEdges(group, nodes, 1, group->count[0], flow);
  const Edges     y     = FindEdges(group, nodes, group->count[0], group->count[0], flow);
  const PetscReal slope =
    PetscMax(PetscMax(x.least, -x.most) / sum->cell[0], PetscMax(y.least, -y.most) / sum->cell[1]);

  return (PetscBool)(slope > 0. && PetscSqr(slope) > PetscSqr(1.01 * TILT_FROM) * (PetscSqr(x.bed / sum->cell[0]) +
                                                                                   PetscSqr(y.bed / sum->cell[1])));
}

PetscErrorCode MpmBedFindGentle(const MpmSum *sum, MpmBedFlow *flow)
{
  const MpmSpace *space = sum->space;

  PetscFunctionBeginUser;
  if (space->group_count > flow->room.groups) {
    flow->room.groups = space->group_count + space->group_count / 8;
    PetscCall(PetscFree(flow->gentle.group));
    PetscCall(PetscMalloc1(flow->room.groups, &flow->gentle.group));
  }
  for (PetscInt g = 0; g < space->group_count; g++) {
    const MpmGroup *group = &space->groups[g];

    if (IsTilted(sum, group, flow)) continue;
    for (PetscInt i = 0; i < group->node_count; i++) flow->failed[space->group_nodes[group->node_offset + i]] = 1.;
  }
  PetscCall(MpmSpaceAddToOwners(space, 1, flow->failed));
  PetscCall(MpmSpaceToGhosts(space, 1, flow->failed));
  flow->gentle.count = 0;
  for (PetscInt g = 0; g < space->group_count; g++) {
    const PetscInt *nodes = &space->group_nodes[space->groups[g].node_offset];
    PetscInt        i     = 0;

    while (i < space->groups[g].node_count && !(flow->failed[nodes[i]] > 0.)) i++;
    if (i < space->groups[g].node_count) flow->gentle.group[flow->gentle.count++] = g;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MpmBedFindLevels(const MpmSum *sum, MpmBedFlow *flow)
{
  for (PetscInt i = 0; i < sum->space->local; i++) {
    const PetscReal *sums = &flow->sums[i * MPM_BED_SUMS], *steep = &flow->steep[i * MPM_STEEP_COUNT];
    const PetscInt  *node  = &sum->space->node[i * 2];
    PetscReal       *level = &flow->level[i * MPM_LEVEL_COUNT], z[3][3], slope[2], even;

    if (!(sums[MPM_BED_VOLUME] > 0.)) continue;
    even = flow->failed[i] > 0. ? 1. : 0.;
    if (even > 0. && steep[MPM_STEEP_BED] > 0.)
      even = Blend(PetscSqrtReal(steep[MPM_STEEP_SURFACE] / steep[MPM_STEEP_BED]), TILT_FROM, LEVEL_TO);
    if (flow->bed->normal) level[MPM_LEVEL_TILT] = 1. - even;
    if (even == 0.) continue;
    for (PetscInt a = 0; a < 2; a++) slope[a] = sums[MPM_BED_SLOPE + a] / sums[MPM_BED_MASS];
    Around(sum->grid, flow->bed, node, z);
    level[MPM_LEVEL_PART] = Balance(sum->grid, node, z, level[MPM_LEVEL], sums) * even;
    level[MPM_LEVEL_WET]  = Whole(sum->grid, z, level[MPM_LEVEL], sums[MPM_BED_HALF] / sums[MPM_BED_VOLUME]) *
                           MpmBedCosine2(flow->bed, slope);
  }
}

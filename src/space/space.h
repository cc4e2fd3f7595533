#pragma once
/*
  The step's discrete space: active nodes, weights, groups of points.
*/
#include "base/base.h"
#include "base/types.h"
#include "talus/point/tables.h"

/* Points that touch the same nodes, a box of count[a] nodes an axis from first[a]; order[] has them side by side. */
typedef struct MpmGroup {
  PetscInt  first[MPM_MAX_DIM];
  PetscInt  count[MPM_MAX_DIM];
  PetscInt  node_count;
  PetscInt  node_offset;            /* into group_nodes */
  PetscInt  point_begin, point_end; /* into order */
  PetscInt  cell;                   /* into cells, where the physics has a mean */
  PetscInt  part;                   /* of its points; unset for boxes without points */
  PetscBool holes;                  /* some of its nodes may be inactive: local node -1 */
  PetscInt  margin[MPM_MAX_DIM];    /* layers of nodes at both ends of an axis that are not coupled with each other */
} MpmGroup;

/* The points over which a mean is taken: those whose centres lie in one cell of the grid, in whole groups. */
typedef struct {
  PetscInt group_begin, group_end;
  PetscInt box; /* into groups: one without points that holds the nodes of them all */
} MpmCell;

/*
  Shares of the points' domains in cells: products over the axes of parts, `width` numbers a point and axis from the
  cell `first` on. Numbers of a cell stand at its lower node. The nodes that points in a cell touch lie in a window
  about that node, and other cells of those points within `range` of it on each axis.
*/
typedef struct {
  PetscInt   width;
  PetscInt  *first, *count; /* dim values a point */
  PetscReal *part;
  PetscInt   lower[MPM_MAX_DIM], upper[MPM_MAX_DIM], range[MPM_MAX_DIM]; /* equal on all ranks */
  PetscInt   box_begin, box_count; /* into groups: windows of this rank's cells, wider by `range`; 0: none is needed */
} MpmSpread;

/* Cells with a mean, if the physics has one: their boxes come last. */
typedef struct {
  PetscInt   count;
  MpmCell   *at;
  PetscReal *share;  /* of each point in the mean of its cell */
  PetscInt   modes;  /* polynomials of the mean */
  PetscReal *mode;   /* their values at each point; NULL: one that is 1 */
  MpmSpread *spread; /* in place of these; or NULL */
} MpmCells;

/* Faces of the ghost penalty: groups without points, behind the others. */
typedef struct {
  PetscInt   begin, count; /* into groups */
  MpmFace   *face;         /* details are private to the ghost penalty */
  PetscReal *matrix;       /* room for theirs */
} MpmFaces;

/*
  Weights of a shape: per point and axis `width` values, from the first node of the point's group on; gradients by x;
  means over the cell, NULL where no field asks for its deviation; and NULL where nothing is smoothed, what makes the
  derivatives of fields in their place: weights across an axis, and gradients along it.
*/
typedef struct {
  PetscReal *weight, *gradient, *mean, *cross, *slope;
  PetscReal *hoop; /* of each point, 1 over its radius, 1/m: of the first shape; NULL without axial symmetry */
} MpmWeights;

/*
  Extra nodes have no place on the lattice: terms append them for unknowns of their own (rigid bodies). The last rank
  owns them, behind its others, and all ranks have them among their local nodes, from `begin` on. Fields of the points
  and conditions do not use them.
*/
typedef struct {
  PetscInt box, first, count; /* the box's nodes (-1: none) and these extra nodes are coupled */
} MpmLink;
typedef struct {
  PetscInt  count, begin;
  PetscInt *free; /* a bit for each component that is solved for; the others are zero */
  PetscInt  link_count, link_capacity;
  MpmLink  *link;
} MpmExtraNodes;

/*
  Parts of the material have nodes of their own, also where they stand at one place: nodes and boxes of part k have
  lattice indices that are k strides higher on the last axis, and knot spans k strides of theirs. MpmSpaceAt() subtracts
  that. Between the parts' lattices lie so many indices, half of which count to each.
*/
typedef struct {
  PetscInt box[2]; /* whose nodes are coupled, beside those of each box with one another */
} MpmCouple;
typedef struct {
  PetscInt   count, stride, spans; /* strides of nodes and of knot spans; 0: there is one part */
  PetscInt   couple_count, couple_capacity;
  MpmCouple *couple;
} MpmParts;
#define MPM_PART_GAP 16

/*
  Nodes whose values follow from others': u_s = sum_k e_sk u_k. Local nodes; masters of a rank's local nodes are local
  (extension/extension.h).
*/
typedef struct {
  PetscInt   count;    /* of followers */
  PetscInt  *follower; /* local node of each */
  PetscInt  *offset;   /* count + 1, into the next two */
  PetscInt  *master;   /* local nodes */
  PetscReal *weight;   /* e_sk */
  PetscInt  *of;       /* per local node: its place among the followers, or -1; NULL: there are none on this rank */
} MpmExtension;

/* Nodes touched by each point with the scene's shape, as they stand on the grid, dim values a point. */
typedef struct {
  PetscInt *first, *count;
} MpmTouchedNodes;

/* The shapes of the physics' fields. */
typedef struct {
  PetscInt   count;
  MpmWeights at[MPM_MAX_SHAPES];
  PetscInt  *support; /* per local node: a bit for each shape with which points touch it; NULL where there is one */
  PetscReal *half;    /* half-lengths of the points' domains, cells, dim values a point; NULL: shapes without domains */
} MpmShapes;

/* All boxes: groups, faces and cells. */
typedef struct {
  PetscInt count;
  PetscInt reach; /* no box has more than reach + 1 nodes on an axis, on any rank */
  MpmFaces faces;
} MpmBoxes;

/* Numbers of the nodes over all ranks, and the scatter between owners and ghosts. */
typedef struct {
  PetscInt *global;   /* of local nodes */
  PetscInt  begin;    /* of the first owned node */
  PetscInt  count;    /* nodes */
  PetscInt  unknowns; /* over all ranks */
  PetscSF   sf;       /* roots: owned nodes; leaves: ghosts; NULL on one rank */
} MpmNumbers;

/*
  The step's discrete spaces, one for each shape of the physics' fields: weights of every point, and the active nodes.
  The nodes are numbered together, so that all unknowns of a node make one block; a node that no point touches with a
  field's shape has no unknown of that field. Local nodes are those that this rank's points touch or that it owns: first
  the owned ones, in lattice order, then ghosts. Unknowns are numbered over active nodes only.
*/
typedef struct MpmSpace {
  PetscInt        dim, width; /* most nodes on an axis */
  PetscInt        point_count;
  PetscInt       *order; /* points by group */
  MpmTouchedNodes touched;
  MpmShapes       shapes;
  PetscInt        group_count;
  MpmGroup       *groups;
  PetscInt       *group_nodes; /* local nodes of each group, x fastest */
  MpmBoxes        boxes;
  MpmCells        cells;
  PetscInt        owned, local; /* active nodes owned by this rank, and with ghosts */
  PetscInt       *node;         /* lattice indices of local nodes, dim each */
  MpmNumbers      number;
  MpmExtraNodes   extra;
  MpmParts        parts;
  MpmExtension    extension;
} MpmSpace;

/*
  Set-up of a space, in halves between which others may append boxes of nodes: Begin evaluates the shapes and finds the
  groups, End numbers the nodes. `outcome`: whether these points have a space, the same on all ranks.
*/
PetscErrorCode MpmSpaceBegin(MpmSpace *space, const MpmRules *rules, const MpmPoints *points, MpmOutcome *outcome);
PetscErrorCode MpmSpaceEnd(MpmSpace *space, const MpmRules *rules);
PetscErrorCode MpmSpaceReset(MpmSpace *space);
/*
  Removes points at these places, in ascending order: from the last one on, the last of all points takes a removed one's
  place. Weights and groups are those of the remaining points; nodes, boxes and means over cells stay as they are.
*/
PetscErrorCode MpmSpaceRemovePoints(MpmSpace *space, PetscInt count, const PetscInt removed[]);
/*
  The weights of all points (weights.c); `box_first` and `box_count`, dim values a point, are the nodes touched with any
  of the shapes, the space's own where there is one shape; `outcome` as above.
*/
PetscErrorCode MpmSpaceEvaluateShapes(MpmSpace *space, const MpmRules *rules, const MpmPoints *points,
                                      PetscInt **box_first, PetscInt **box_count, MpmOutcome *outcome);
/* Room for `count` boxes more, without points, behind the others. */
PetscErrorCode MpmSpaceAppendBoxes(MpmSpace *space, PetscInt count, MpmGroup **boxes);
/*
  Appends extra nodes, equal on all ranks, before the nodes are numbered; `first` is the index among them of the first
  one. The second function, afterwards, couples them with boxes of this rank: the sparsity has room for that.
*/
PetscErrorCode          MpmSpaceAppendNodes(MpmSpace *space, PetscInt count, const PetscInt free[], PetscInt *first);
PetscErrorCode          MpmSpaceLink(MpmSpace *space, PetscInt box, PetscInt first, PetscInt count);
static inline PetscBool MpmSpaceIsExtra(const MpmSpace *space, PetscInt node)
{
  return (PetscBool)(node >= space->extra.begin && node < space->extra.begin + space->extra.count);
}
/* Couples all nodes of two of this rank's boxes: the sparsity has room for that. To be called like MpmSpaceLink(). */
PetscErrorCode MpmSpaceCouple(MpmSpace *space, PetscInt one, PetscInt other);
/* Offset of the last axis' indices of the nodes of point p; `part`: the points' field. */
static inline PetscInt MpmSpaceShift(const MpmSpace *space, const PetscInt part[], PetscInt p)
{
  return space->parts.stride ? space->parts.stride * part[p] : 0;
}
/* The part that a node or box with these lattice indices belongs to. */
static inline PetscInt MpmSpacePart(const MpmSpace *space, const PetscInt node[])
{
  return space->parts.stride ? (node[space->dim - 1] + MPM_PART_GAP / 2) / space->parts.stride : 0;
}
/* The part of a knot span, and where one stands among the spans of the grid. */
static inline PetscInt MpmSpaceSpanPart(const MpmSpace *space, const PetscInt span[])
{
  return space->parts.stride ? (span[space->dim - 1] + MPM_PART_GAP / 2) / space->parts.spans : 0;
}
static inline void MpmSpaceSpanAt(const MpmSpace *space, const PetscInt span[], PetscInt at[])
{
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) at[a] = a < space->dim ? span[a] : 0;
  at[space->dim - 1] -= space->parts.spans * MpmSpaceSpanPart(space, span);
}
/* Where a node or box stands on the grid: the grid's own indices, 0 on unused axes. */
static inline void MpmSpaceAt(const MpmSpace *space, const PetscInt node[], PetscInt at[])
{
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) at[a] = a < space->dim ? node[a] : 0;
  at[space->dim - 1] -= space->parts.stride * MpmSpacePart(space, node);
}
/* Lattice indices of the first node of a group of points, without a division. */
static inline void MpmSpaceGroupAt(const MpmSpace *space, const MpmGroup *group, PetscInt at[])
{
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) at[a] = group->first[a];
  at[space->dim - 1] -= space->parts.stride * group->part;
}
/* Numbers the nodes that the groups touch and builds the scatter (active_nodes.c). */
PetscErrorCode MpmSpaceNumberNodes(MpmSpace *space, const MpmGrid *grid);
/* Ghost values from their owners, and sums of ghost values to their owners; `block` values a node. */
PetscErrorCode MpmSpaceToGhosts(const MpmSpace *space, PetscInt block, PetscReal local[]);
PetscErrorCode MpmSpaceAddToOwners(const MpmSpace *space, PetscInt block, PetscReal local[]);

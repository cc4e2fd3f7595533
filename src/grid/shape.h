#pragma once
/*
  Shape functions: one-dimensional weights and gradients of a material point on a regular grid; tensor products make 2D
  and 3D.

  One formula serves every shape: the basis is the cardinal B-spline of degree p (1: linear basis functions, 2, 3),
  evaluated at the point or averaged over the point's domain [x - l, x + l]. Averages are taken knot interval by knot
  interval, so that they are exact for any l, keep a partition of unity to rounding, and need no case distinction on
  l/h.
*/
#include "base/base.h"
#include "base/types.h"

/* Names of the shapes whose nodes are the grid's vertices, and of MpmEdgeType (base/types.h) */
extern const char *const MpmShapeTypes[], *const MpmEdgeTypes[];
/* Words of -mpm_shape: those names, then elements without and with domains; the shape of a word. Orders of words that
   are no elements are not used. */
extern const char *const MpmShapeWords[];
MpmShapeType             MpmShapeOfWord(PetscInt word, PetscInt order);
PetscBool                MpmShapeWordIsElement(PetscInt word);
/* Name for messages and results. */
const char *MpmShapeName(MpmShapeType type);

/* True where the shape averages over the point's domain, so that domains must be followed. */
PetscBool MpmShapeHasDomain(MpmShapeType type);
/* Degree of the polynomials between knots: 1 for linear basis functions, under GIMP too. */
PetscInt MpmShapeDegree(MpmShapeType type);
/* Nodes a cell on an axis: the order of elements, 1 for splines. */
PetscInt MpmShapeOrder(MpmShapeType type);
/* True where derivatives are continuous from cell to cell, so that functions end at edges in a way of their own. */
static inline PetscBool MpmShapeIsSpline(MpmShapeType type)
{
  return (PetscBool)(MpmShapeDegree(type) > MpmShapeOrder(type));
}
/* Cells between points that are `spacing` cells apart, as linear functions with as many points a node would have them:
   from 1 on points are sparse. Elements of order p need p + 1 points a cell and axis. */
PetscReal MpmShapeSpacing(MpmShapeType type, PetscReal spacing);
/* The shape without its domains. */
MpmShapeType MpmShapeSampled(MpmShapeType type);
/* The spline of another degree, 1 to 3, that averages where `type` does, if there is such a one. */
MpmShapeType MpmShapeOfDegree(MpmShapeType type, PetscInt degree);

/* Nodes that a point touches on one axis at most, for domains of half-length up to half_length (in cells). */
PetscInt MpmShapeWidth(MpmShapeType type, PetscReal half_length);

/* The edge of a spline of this degree where so many cells lie between it and the next: not-a-knot ends need more cells
   than the degree. */
MpmEdgeType MpmEdgeOf(MpmEdgeType edge, PetscInt degree, PetscInt cells);
/* Share of the k-th node from an edge inwards (0: on it) in the coefficient of the node on it (beyond 0) or of the one
   beyond it (1), for a spline of degree 2 or 3; k up to the degree. */
PetscReal MpmEdgeCoefficient(MpmEdgeType edge, PetscInt degree, PetscInt beyond, PetscInt k);

/* The nodes of one axis that a point touches. */
typedef struct {
  PetscInt   first, count; /* the first node with a weight, and how many, <= MpmShapeWidth() */
  PetscReal *weight;
  PetscReal *gradient; /* derivatives by xi (divide by h for d/dx) */
  PetscReal *mean;     /* means over the cell, which MpmShapeMean() makes */
  PetscReal  smooth;   /* share of the means over knot spans in the weights below, 0: none is made */
  PetscReal *cross;    /* weights in gradients along other axes, smoothed */
  PetscReal *slope;    /* gradients, smoothed */
} MpmShapeLine;

/* Overlaps with an interval that are smaller than this part of the domain are rounding. */
#define MPM_SHAPE_TOUCH 1e-9
/* In explicit steps of columns under their own pressure: while overlaps do not count, a body whose points fill whole
   cells has half of its pressure's stiffness, and modes without any that grow. */
#define MPM_SHAPE_TOUCH_COLUMNS 1e-14
/* Distance, in cells, that points on a face or an edge count as inside: no node has a gradient without a weight. */
#define MPM_SHAPE_INSIDE PETSC_MACHINE_EPSILON
/* Domains shorter than this count as points: their inverse length would overflow. */
#define MPM_SHAPE_POINT 1e-100

/*
  MpmShapeEvaluate - weights and gradients on one axis

  Input Parameters:
+ type        - the shape
. edge        - how splines end at the edges
. xi          - the point, (x - lower)/h: vertex i stands at xi = i
. half_length - half the length of the point's domain over h, clipped by the caller to stay between the edges; unused by
                shapes without a domain
. edge_lower  - first vertex of the axis, or of the wall that bounds the material
- edge_upper  - last vertex

  Output Parameter:
. line - the nodes, and their weights in arrays of the caller's: room for MpmShapeWidth() of them; `smooth` is input

  With `smooth` the weights and gradients of a displacement's gradient are a mean: 1 - smooth times those of the point,
  plus smooth times the means over the spline's knot spans (the cells, for even degrees the cells around nodes) in which
  the domain lies. Linear fields keep their gradients.

  Nodes beyond the edges do not exist. With MPM_EDGE_LINEAR their coefficients are the linear extension u_{-k} = 2 u_0 -
  u_k. With either type the edge node carries the edge's value to rounding, and a linear field has its nodal values as
  coefficients.
*/
void MpmShapeEvaluate(MpmShapeType type, MpmEdgeType edge, PetscReal xi, PetscReal half_length, PetscInt edge_lower,
                      PetscInt edge_upper, MpmShapeLine *line);
/* Arguments and results of MpmShapeEvaluate() for many points and axes, in arrays. */
typedef struct {
  const PetscReal *xi, *half_length;
  const PetscInt  *edge_lower, *edge_upper;
  PetscReal        touch; /* MPM_SHAPE_TOUCH, or another */
} MpmShapePlaces;
typedef struct {
  PetscInt   width; /* numbers a line; gradients and slopes behind its nodes become 0 */
  PetscInt  *first, *count;
  PetscReal *weight, *gradient;
  PetscReal  smooth;
  PetscReal *cross, *slope;
} MpmShapeLines;
void MpmShapeEvaluateAll(MpmShapeType type, MpmEdgeType edge, PetscInt count, const MpmShapePlaces *at,
                         const MpmShapeLines *lines);
/*
  The weights at xi + by of the polynomials of the knot interval of xi, also beyond that interval; domains are left out
  of account.
*/
void MpmShapeExtend(MpmShapeType type, MpmEdgeType edge, PetscReal xi, PetscReal by, PetscInt edge_lower,
                    PetscInt edge_upper, MpmShapeLine *line);
/*
  Derivatives of a line from MpmShapeEvaluate(), without smoothing, by the point's place and by the half-length of its
  domain, both in cells (shape_slopes.c). On a knot, and where a domain ends on one, they are those of the intervals
  that the line itself takes.
*/
typedef struct {
  PetscReal xi, half_length;
  PetscInt  edge_lower, edge_upper;
} MpmShapePlace;
typedef struct {
  PetscReal *bend;               /* of the gradients by the place; weights have the gradients themselves */
  PetscReal *weight_by_length;   /* 0 for shapes without domains */
  PetscReal *gradient_by_length; /* likewise */
} MpmShapeSlopes;
void MpmShapeDifferentiate(MpmShapeType type, MpmEdgeType edge, const MpmShapePlace *at, const MpmShapeLine *line,
                           const MpmShapeSlopes *slopes);
/*
  Means over the cell of the nodal weights of a line from MpmShapeEvaluate() (shape_mean.c); where the domain lies in
  several cells, each counts by its share. Arguments as above.
*/
void MpmShapeMean(MpmShapeType type, MpmEdgeType edge, PetscReal xi, PetscReal half_length, PetscInt edge_lower,
                  PetscInt edge_upper, const MpmShapeLine *line);
/* Derivatives of these means by the place and by the half-length, in cells; the nodes of the line stay. */
void MpmShapeMeanSlopes(MpmShapeType type, MpmEdgeType edge, const MpmShapePlace *at, const MpmShapeLine *line,
                        PetscReal by_place[], PetscReal by_length[]);
/*
  The cells of an axis that a point's domain lies in, low to high, and the part of the domain in cell c of these, with
  its derivatives by the place and by the half-length, in cells, unless `slope` is NULL. Parts add up to 1.
*/
void MpmShapeCells(PetscReal xi, PetscReal half_length, PetscInt edge_lower, PetscInt edge_upper, PetscInt *low,
                   PetscInt *high);
static inline PetscReal MpmShapePart(PetscInt c, PetscInt low, PetscInt high, PetscReal xi, PetscReal half_length,
                                     PetscReal slope[])
{
  const PetscReal from = c == low ? xi - half_length : (PetscReal)c,
                  to   = c == high ? xi + half_length : (PetscReal)(c + 1);
  const PetscReal part = low == high ? 1. : (to - from) / (2. * half_length);

  if (slope) {
    slope[0] = low == high ? 0. : ((c == high) - (c == low)) / (2. * half_length);
    slope[1] = low == high ? 0. : ((c == high) + (c == low) - 2. * part) / (2. * half_length);
  }
  return part;
}
/*
  With axial symmetry and domains, the derivative by the radius averaged by volume (shape_radial.c), in place of that
  over the length of the domain, of the line along the radius. `radius` is that of the point over h.
*/
typedef struct {
  PetscReal xi, half_length, radius;
  PetscInt  edge_lower, edge_upper;
} MpmRadialPlace;
void MpmShapeAverageByVolume(MpmShapeType type, MpmEdgeType edge, const MpmRadialPlace *at, const MpmShapeLine *line);
/* The way back; and what the average by volume adds to the derivatives of such a line, MpmShapeDifferentiate(). */
void MpmShapeAverageByLength(MpmShapeType type, MpmEdgeType edge, const MpmRadialPlace *at, const MpmShapeLine *line);
void MpmShapeVolumeSlopes(MpmShapeType type, MpmEdgeType edge, const MpmRadialPlace *at, const MpmShapeLine *line,
                          const MpmShapeSlopes *slopes);

#pragma once
/*
  The inner loops of sums over points, inlined so that the number of nodes of a group and the layout of the commonest
  physics are constants where it pays: a point of a solid touches 4 to 9 nodes in 2D and 8 to 27 in 3D, and loops that
  short must be unrolled.
*/
#include "point/layout.h"
#include "particles/points.h"
#include "space/basis.h"
#include "space/space.h"
#include "space/sum.h"

/*
  Loop bounds known at compile time: the layout of a solid, whose block is dim and whose inputs are all derivatives, or
  of Biot's fields (MPM_PHYSICS_BIOT), and the nodes of a group on each axis.
*/
typedef struct {
  PetscInt  dim, block, inputs;
  PetscBool solid, biot;
  PetscInt  count[MPM_MAX_DIM], n; /* n: their product */
} MpmKnown;

MPM_INLINE PetscInt KnownComponent(const MpmKnown known, const MpmLayout *layout, PetscInt k)
{
  if (known.biot) return k < known.dim * known.dim ? k / known.dim : known.dim;
  return known.solid ? k / known.dim : layout->input.component[k];
}
MPM_INLINE PetscInt KnownBasis(const MpmKnown known, const MpmLayout *layout, PetscInt k)
{
  if (known.biot) return k < known.dim * known.dim ? 1 + k % known.dim : k - known.dim * known.dim;
  return known.solid ? 1 + k % known.dim : layout->input.basis[k];
}

/* Nothing is constant. */
MPM_INLINE MpmKnown KnownGeneral(const MpmLayout *layout, const MpmGroup *group)
{
  const PetscInt *count = group->count;
  const MpmKnown  known = {.dim    = layout->dim,
                           .block  = layout->block,
                           .inputs = layout->input.count,
                           .biot   = (PetscBool)(layout->traits.biot && layout->kinematics != MPM_AXISYMMETRY),
                           .count  = {count[0], count[1], count[2]},
                           .n      = group->node_count};
  return known;
}

/*
  Dimensions whose usual cases have loops of their own. A source with loops that are slow to compile is compiled once
  for each dimension, MPM_LOOPS, and names its functions by it. Under the sanitizers all loops are general:
  MPM_LOOPS_GENERAL.
*/
#if !defined(MPM_LOOPS_GENERAL) && (!defined(MPM_LOOPS) || MPM_LOOPS == 2)
#define MPM_CASES_2D(f, ...) \
  MPM_CASE(f, 2, 2, 2, 1, __VA_ARGS__); \
  MPM_CASE(f, 2, 3, 2, 1, __VA_ARGS__); \
  MPM_CASE(f, 2, 2, 3, 1, __VA_ARGS__); \
  MPM_CASE(f, 2, 3, 3, 1, __VA_ARGS__); \
  MPM_CASE(f, 2, 4, 2, 1, __VA_ARGS__); \
  MPM_CASE(f, 2, 2, 4, 1, __VA_ARGS__); \
  MPM_CASE(f, 2, 4, 3, 1, __VA_ARGS__); \
  MPM_CASE(f, 2, 3, 4, 1, __VA_ARGS__); \
  MPM_CASE(f, 2, 4, 4, 1, __VA_ARGS__)
#define MPM_BIOT_CASES_2D(f, ...) \
  MPM_BIOT_CASE(f, 2, 2, 2, 1, __VA_ARGS__); \
  MPM_BIOT_CASE(f, 2, 3, 2, 1, __VA_ARGS__); \
  MPM_BIOT_CASE(f, 2, 2, 3, 1, __VA_ARGS__); \
  MPM_BIOT_CASE(f, 2, 3, 3, 1, __VA_ARGS__)
#else
#define MPM_CASES_2D(f, ...)
#define MPM_BIOT_CASES_2D(f, ...)
#endif
#if !defined(MPM_LOOPS_GENERAL) && (!defined(MPM_LOOPS) || MPM_LOOPS == 3)
#define MPM_CASES_3D(f, ...) \
  MPM_CASE(f, 3, 2, 2, 2, __VA_ARGS__); \
  MPM_CASE(f, 3, 3, 2, 2, __VA_ARGS__); \
  MPM_CASE(f, 3, 2, 3, 2, __VA_ARGS__); \
  MPM_CASE(f, 3, 3, 3, 2, __VA_ARGS__); \
  MPM_CASE(f, 3, 2, 2, 3, __VA_ARGS__); \
  MPM_CASE(f, 3, 3, 2, 3, __VA_ARGS__); \
  MPM_CASE(f, 3, 2, 3, 3, __VA_ARGS__); \
  MPM_CASE(f, 3, 3, 3, 3, __VA_ARGS__)
#define MPM_BIOT_CASES_3D(f, ...) \
  MPM_BIOT_CASE(f, 3, 2, 2, 2, __VA_ARGS__); \
  MPM_BIOT_CASE(f, 3, 3, 2, 2, __VA_ARGS__); \
  MPM_BIOT_CASE(f, 3, 2, 3, 2, __VA_ARGS__); \
  MPM_BIOT_CASE(f, 3, 3, 3, 2, __VA_ARGS__); \
  MPM_BIOT_CASE(f, 3, 2, 2, 3, __VA_ARGS__); \
  MPM_BIOT_CASE(f, 3, 3, 2, 3, __VA_ARGS__); \
  MPM_BIOT_CASE(f, 3, 2, 3, 3, __VA_ARGS__); \
  MPM_BIOT_CASE(f, 3, 3, 3, 3, __VA_ARGS__)
#else
#define MPM_CASES_3D(f, ...)
#define MPM_BIOT_CASES_3D(f, ...)
#endif
#if defined(MPM_LOOPS) && MPM_LOOPS == 2
#define MPM_LOOPS_NAME(function) function##_2d
#elif defined(MPM_LOOPS)
#define MPM_LOOPS_NAME(function) function##_3d
#endif

/*
  Calls f(known, ...) with constants for the usual cases: a solid whose points touch two, three or, in 2D, four nodes an
  axis; in 3D the loops over four are long enough as they are. The general case is the same code with variables.
*/
#define MPM_SOLID(dim, i, j, k) \
  ((MpmKnown){dim, dim, (dim) * (dim), PETSC_TRUE, PETSC_FALSE, {i, j, k}, (i) * (j) * (k)})
#define MPM_CASE(f, dim, i, j, k, ...) \
  case ((k)*5 + (j)) * 5 + (i): \
    PetscCall(f(MPM_SOLID(dim, i, j, k), __VA_ARGS__)); \
    break
#define MPM_DISPATCH(layout, group, f, ...) \
  do { \
    const PetscInt *const count_ = (group)->count; \
    const PetscInt        most_  = PetscMax(PetscMax(count_[0], count_[1]), count_[2]); \
    switch ((layout)->traits.solid && (layout)->kinematics != MPM_AXISYMMETRY && most_ <= 4 \
              ? (count_[2] * 5 + count_[1]) * 5 + count_[0] \
              : -1) { \
      MPM_CASES_2D(f, __VA_ARGS__); \
      MPM_CASES_3D(f, __VA_ARGS__); \
    default: \
      PetscCall(f(KnownGeneral(layout, group), __VA_ARGS__)); \
      break; \
    } \
  } while (0)

/* Dispatch of a loop that pays for Biot's fields, too, of two or three nodes an axis. */
#define MPM_BIOT(dim, i, j, k) \
  ((MpmKnown){dim, (dim) + 1, (dim) * (dim) + (dim) + 2, PETSC_FALSE, PETSC_TRUE, {i, j, k}, (i) * (j) * (k)})
#define MPM_BIOT_CASE(f, dim, i, j, k, ...) \
  case (((dim)*5 + (k)) * 5 + (j)) * 5 + (i): \
    PetscCall(f(MPM_BIOT(dim, i, j, k), __VA_ARGS__)); \
    break
#define MPM_DISPATCH_BIOT(layout, group, f, ...) \
  do { \
    const PetscInt *const nodes_ = (group)->count; \
    const PetscInt        size_  = PetscMax(PetscMax(nodes_[0], nodes_[1]), nodes_[2]); \
    switch ((layout)->traits.biot && (layout)->kinematics != MPM_AXISYMMETRY && size_ <= 3 \
              ? (((layout)->dim * 5 + nodes_[2]) * 5 + nodes_[1]) * 5 + nodes_[0] \
              : -1) { \
      MPM_BIOT_CASES_2D(f, __VA_ARGS__); \
      MPM_BIOT_CASES_3D(f, __VA_ARGS__); \
    default: \
      MPM_DISPATCH(layout, group, f, __VA_ARGS__); \
      break; \
    } \
  } while (0)

/* Calls f(N, ...) with the number of inputs, a constant for a solid. */
#define MPM_DISPATCH_INPUTS(layout, f, ...) \
  PetscCall((layout)->traits.solid && (layout)->kinematics != MPM_AXISYMMETRY \
              ? (layout)->input.count == 4 ? f(4, __VA_ARGS__) : f(9, __VA_ARGS__) \
              : f((layout)->input.count, __VA_ARGS__))

/* Room for one group's work: nodal values and forces by component, and the basis functions of one point. */
typedef struct {
  PetscReal *values, *force, *storage;
  PetscBool  weights; /* the kernel takes values, too, not only derivatives */
  MpmBasis   basis;
} MpmWorkspace;

static inline PetscErrorCode MpmWorkspaceCreate(const MpmSum *sum, MpmWorkspace *work)
{
  const PetscInt n = PetscPowInt(sum->space->width, sum->space->dim), bs = sum->block;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1((n * (2 * bs + MpmBasisCount(sum->space))), &work->storage));
  work->weights = MpmLayoutUsesValues(sum->layout);
  work->values  = work->storage;
  work->force   = work->values + n * bs;
  MpmBasisPlace(sum->space, n, work->force + n * bs, &work->basis);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* values[c*n + i] = u at the group's nodes */
MPM_INLINE void MpmSumGather(const MpmKnown known, const MpmSum *sum, const MpmGroup *group, const PetscReal u[],
                             PetscReal values[])
{
  const PetscInt  n     = known.n;
  const PetscInt *nodes = &sum->space->group_nodes[group->node_offset];

  for (PetscInt i = 0; i < n; i++)
    for (PetscInt c = 0; c < known.block; c++) values[c * n + i] = u[nodes[i] * known.block + c];
}

/* residual += force at the group's nodes */
MPM_INLINE void MpmSumScatter(const MpmKnown known, const MpmSum *sum, const MpmGroup *group, const PetscReal force[],
                              PetscReal residual[])
{
  const PetscInt  n     = known.n;
  const PetscInt *nodes = &sum->space->group_nodes[group->node_offset];

  for (PetscInt i = 0; i < n; i++)
    for (PetscInt c = 0; c < known.block; c++) residual[nodes[i] * known.block + c] += force[c * n + i];
}

/* The kernel's inputs: input_k = sum_i phi_k(i) u_i,c(k) */
MPM_INLINE void MpmSumInputs(const MpmKnown known, const MpmLayout *layout, const PetscReal values[],
                             const MpmBasis *basis, PetscReal input[])
{
  const PetscInt n = known.n;
  for (PetscInt k = 0; k < known.inputs; k++) {
    const PetscReal *phi = basis->basis[KnownBasis(known, layout, k)],
                    *v   = &values[KnownComponent(known, layout, k) * n];
    PetscReal s          = 0.;

    for (PetscInt i = 0; i < n; i++) s += phi[i] * v[i];
    input[k] = s;
  }
}

/* force_c(k),i += phi_k(i) flux_k */
MPM_INLINE void MpmSumAddFlux(const MpmKnown known, const MpmLayout *layout, const MpmBasis *basis,
                              const PetscReal flux[], PetscReal force[])
{
  const PetscInt n = known.n;
  for (PetscInt k = 0; k < known.inputs; k++) {
    const PetscReal *restrict phi = basis->basis[KnownBasis(known, layout, k)];
    PetscReal *restrict f         = &force[KnownComponent(known, layout, k) * n];
    const PetscReal value         = flux[k];

    for (PetscInt i = 0; i < n; i++) f[i] += phi[i] * value;
  }
}

/*
  Points lie in memory in the order in which they were made or came, which the processor cannot predict when they are
  visited by groups. Data of the point so many places ahead are therefore prefetched.
*/
#define MPM_AHEAD 4
#define MPM_LINE  8 /* numbers in a line of the cache */
MPM_INLINE PetscInt MpmSumAhead(const MpmSum *sum, PetscInt s)
{
  return sum->space->order[PetscMin(s + MPM_AHEAD, sum->points->count - 1)];
}
MPM_INLINE void MpmFetch(const PetscReal array[], PetscInt p, PetscInt size)
{
  for (PetscInt k = 0; k < size; k += MPM_LINE) __builtin_prefetch(&array[p * size + k]);
  __builtin_prefetch(&array[p * size + size - 1]);
}
/* Prefetches the weights of a point in the scene's shape. */
MPM_INLINE void MpmSpaceFetch(const MpmKnown known, const MpmSpace *space, PetscInt p)
{
  MpmFetch(space->shapes.at[0].weight, p, known.dim * space->width);
}
/* Prefetches the data of the kernel and its inputs. */
MPM_INLINE void MpmSumFetch(const MpmKnown known, const MpmSum *sum, PetscInt s)
{
  const PetscInt p = MpmSumAhead(sum, s);

  MpmSpaceFetch(known, sum->space, p);
  MpmFetch(sum->space->shapes.at[0].gradient, p, known.dim * sum->space->width);
  MpmFetch(sum->points->F, p, known.solid ? known.dim * known.dim : sum->points->F_size);
  MpmFetch(sum->points->volume0, p, 1);
}

/* Values along the three axes; `beyond` along an axis that the grid has not, where a group has one node. */
typedef struct {
  const PetscReal *along[MPM_MAX_DIM];
} MpmLines;
MPM_INLINE MpmLines MpmPointLines(PetscInt dim, const MpmSpace *space, const PetscReal values[], PetscInt point,
                                  const PetscReal *beyond)
{
  const PetscInt W     = space->width;
  MpmLines       lines = {{&values[point * dim * W], &values[(point * dim + 1) * W], beyond}};

  if (dim == MPM_MAX_DIM) lines.along[2] = &values[(point * dim + 2) * W];
  return lines;
}
static const PetscReal MpmLineOne = 1., MpmLineZero = 0.;

/* The weights alone of one point at its group's nodes with the scene's shape, x fastest. */
MPM_INLINE void MpmShapeWeights(const MpmKnown known, const MpmSpace *space, PetscInt point, PetscReal weight[])
{
  const MpmLines w = MpmPointLines(known.dim, space, space->shapes.at[0].weight, point, &MpmLineOne);

  for (PetscInt l = 0; l < known.count[2]; l++) {
    for (PetscInt j = 0; j < known.count[1]; j++, weight += known.count[0]) {
      const PetscReal row = w.along[1][j] * w.along[2][l];

      for (PetscInt k = 0; k < known.count[0]; k++) weight[k] = w.along[0][k] * row;
    }
  }
}

/* MpmShapeBasis() where derivatives are smoothed (basis.c). */
void MpmSpaceSmoothBasis(const MpmSpace *space, const PetscInt count[], PetscInt shape, PetscInt point,
                         PetscReal *const basis[]);
/*
  The weights and derivatives of one point at its group's nodes with one shape: basis[0] weights (if needed),
  basis[1..dim] derivatives; `count` nodes an axis, x fastest.
*/
MPM_INLINE void MpmShapeBasis(const MpmKnown known, const MpmSpace *space, PetscInt shape, PetscInt point,
                              PetscBool weights, PetscReal *const basis[])
{
  const MpmWeights *of   = &space->shapes.at[shape];
  const MpmLines    w    = MpmPointLines(known.dim, space, of->weight, point, &MpmLineOne);
  const MpmLines    g    = MpmPointLines(known.dim, space, of->gradient, point, &MpmLineZero);
  const PetscInt    nx   = known.count[0];
  PetscReal *restrict b0 = basis[0], *restrict b1 = basis[1], *restrict b2 = basis[2], *restrict b3 = basis[3];

  if (of->cross) {
    MpmSpaceSmoothBasis(space, known.count, shape, point, basis);
    return;
  }
  for (PetscInt l = 0; l < known.count[2]; l++) {
    for (PetscInt j = 0; j < known.count[1]; j++) {
      const PetscReal ww = w.along[1][j] * w.along[2][l], gw = g.along[1][j] * w.along[2][l],
                      wg = w.along[1][j] * g.along[2][l];

      for (PetscInt k = 0; k < nx; k++) {
        b1[k] = g.along[0][k] * ww;
        b2[k] = w.along[0][k] * gw;
        if (known.dim == MPM_MAX_DIM) b3[k] = w.along[0][k] * wg;
        if (weights) b0[k] = w.along[0][k] * ww;
      }
      b1 += nx;
      b2 += nx;
      b3 += nx;
      b0 += nx;
    }
  }
}

/* The weights less their means over the cell, from the weights. */
MPM_INLINE void MpmShapeDeviation(const MpmKnown known, const MpmSpace *space, PetscInt shape, PetscInt point,
                                  const PetscReal weight[], PetscReal deviation[])
{
  const MpmLines m = MpmPointLines(known.dim, space, space->shapes.at[shape].mean, point, &MpmLineOne);
  PetscInt       n = 0;

  for (PetscInt l = 0; l < known.count[2]; l++) {
    for (PetscInt j = 0; j < known.count[1]; j++) {
      const PetscReal row = m.along[1][j] * m.along[2][l];

      for (PetscInt k = 0; k < known.count[0]; k++, n++) deviation[n] = weight[n] - m.along[0][k] * row;
    }
  }
}

/* All shapes; a solid has one, and so have Biot's fields. */
MPM_INLINE void MpmSumBasis(const MpmKnown known, const MpmSpace *space, PetscInt point, PetscBool weights,
                            const MpmBasis *basis)
{
  MpmShapeBasis(known, space, 0, point, weights, basis->basis);
  if (!known.solid && !known.biot && space->shapes.at[0].hoop)
    for (PetscInt i = 0; i < known.n; i++)
      basis->basis[MPM_HOOP_BASIS][i] = space->shapes.at[0].hoop[point] * basis->basis[0][i];
  if (known.biot) {
    MpmShapeDeviation(known, space, 0, point, basis->basis[0], basis->basis[MPM_DEVIATION(known.dim)]);
    return;
  }
  for (PetscInt s = 1; !known.solid && s < space->shapes.count; s++)
    MpmShapeBasis(known, space, s, point, weights, &basis->basis[s * MPM_BASES]);
  for (PetscInt s = 0; !known.solid && s < space->shapes.count; s++) {
    PetscReal *const *of = &basis->basis[s * MPM_BASES];

    if (space->shapes.at[s].mean) MpmShapeDeviation(known, space, s, point, of[0], of[MPM_DEVIATION(known.dim)]);
  }
}

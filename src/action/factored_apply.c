/*
  The loops of the sum-factorised action. With weights w and gradients g of a point along the axes,

    du_c/dx = sum_k w_k sum_j w_j sum_i g_i u_cijk ,   du_c/dy = sum_k w_k sum_j g_j sum_i w_i u_cijk , ... ,

  so that the sums over i serve all axes, then the tangent, and the transposed sums with its fluxes.
*/
#include "action/factored_impl.h"

/* Constants of the loops: the dimension, the unknowns of a node and their inputs, and unless 0 the nodes on the first
   axis, on all of them with `cube`. */
typedef struct {
  PetscInt  dim, row;
  PetscBool shared;
  PetscInt  block;
  PetscBool gradient, cube;
} Known;

MPM_INLINE PetscInt NodesAlong(const Known known, const MpmStack *stack, PetscInt axis)
{
  return known.row && (axis == 0 || known.cube) ? known.row : stack->count[axis];
}

MPM_INLINE PetscInt InputsOf(const Known known)
{
  return known.gradient ? known.dim * known.block : known.block;
}

/* Number m of the nodal values: one for all lanes of a shared box. */
MPM_INLINE Lane ValueAt(const Known known, const Lane *values, PetscInt m)
{
  return known.shared ? ((const PetscReal *)values)[m] - (Lane){0.} : values[m];
}

/* Inputs from the nodal values of a batch: gradients at c * dim + a, or values; `w`: its lines. */
MPM_INLINE void TakeInputs(const Known known, const MpmStack *stack, const Lane *restrict w,
                           const Lane *restrict values, Lane  input[])
{
  const PetscInt dim = known.dim, bs = known.block, nx = NodesAlong(known, stack, 0), ny = NodesAlong(known, stack, 1),
                 nz = NodesAlong(known, stack, 2);
  const Lane *gx = w + nx, *wy = gx + nx, *gy = wy + ny, *wz = gy + ny, *gz = wz + nz;
  PetscInt    m = 0;

  for (PetscInt q = 0; q < InputsOf(known); q++) input[q] = (Lane){0.};
  for (PetscInt k = 0; k < nz; k++) {
    Lane x[MPM_MAX_DIM], y[MPM_MAX_DIM], value[MPM_MAX_DIM]; /* of this layer */

    for (PetscInt c = 0; c < bs; c++) x[c] = y[c] = value[c] = (Lane){0.};
    for (PetscInt j = 0; j < ny; j++) {
      Lane along[MPM_MAX_DIM], row[MPM_MAX_DIM];

      for (PetscInt c = 0; c < bs; c++) along[c] = row[c] = (Lane){0.};
      for (PetscInt i = 0; i < nx; i++) {
        for (PetscInt c = 0; c < bs; c++) {
          const Lane u = ValueAt(known, values, m++);

          row[c] += w[i] * u;
          if (known.gradient) along[c] += gx[i] * u;
        }
      }
      for (PetscInt c = 0; c < bs; c++) {
        if (known.gradient) {
          x[c] += wy[j] * along[c];
          y[c] += gy[j] * row[c];
        }
        if (dim == MPM_MAX_DIM || !known.gradient) value[c] += wy[j] * row[c];
      }
    }
    for (PetscInt c = 0; c < bs; c++) {
      if (!known.gradient) input[c] += dim == MPM_MAX_DIM ? wz[k] * value[c] : value[c];
      else if (dim == MPM_MAX_DIM) {
        input[c * dim] += wz[k] * x[c];
        input[c * dim + 1] += wz[k] * y[c];
        input[c * dim + 2] += gz[k] * value[c];
      } else {
        input[c * dim]     = x[c];
        input[c * dim + 1] = y[c];
      }
    }
  }
}

/* force (+)= the fluxes times the basis functions of the inputs; added where the lanes share a box. */
MPM_INLINE void AddForce(const Known known, const MpmStack *stack, const Lane *restrict w, const Lane flux[],
                         Lane *restrict force)
{
  const PetscInt dim = known.dim, bs = known.block, nx = NodesAlong(known, stack, 0), ny = NodesAlong(known, stack, 1),
                 nz = NodesAlong(known, stack, 2);
  const Lane *gx = w + nx, *wy = gx + nx, *gy = wy + ny, *wz = gy + ny, *gz = wz + nz;

  for (PetscInt k = 0; k < nz; k++) {
    for (PetscInt j = 0; j < ny; j++) {
      Lane along[MPM_MAX_DIM], row[MPM_MAX_DIM];

      for (PetscInt c = 0; c < bs; c++) {
        if (!known.gradient) row[c] = dim == MPM_MAX_DIM ? wz[k] * wy[j] * flux[c] : wy[j] * flux[c];
        else if (dim == MPM_MAX_DIM) {
          along[c] = wz[k] * wy[j] * flux[c * dim];
          row[c]   = wz[k] * gy[j] * flux[c * dim + 1] + gz[k] * wy[j] * flux[c * dim + 2];
        } else {
          along[c] = wy[j] * flux[c * dim];
          row[c]   = gy[j] * flux[c * dim + 1];
        }
      }
      for (PetscInt i = 0; i < nx; i++) {
        for (PetscInt c = 0; c < bs; c++, force++) {
          const Lane before = known.shared ? *force : (Lane){0.};

          *force = known.gradient ? before + gx[i] * along[c] + w[i] * row[c] : before + w[i] * row[c];
        }
      }
    }
  }
}

/* flux = D gradient: the upper triangle of D by rows. */
MPM_INLINE void TimesHalf(PetscInt N, const Lane *restrict D, const Lane gradient[], Lane flux[])
{
  for (PetscInt k = 0; k < N; k++) flux[k] = (Lane){0.};
  for (PetscInt k = 0; k < N; k++) {
    flux[k] += *D++ * gradient[k];
    for (PetscInt l = k + 1; l < N; l++, D++) {
      flux[k] += *D * gradient[l];
      flux[l] += *D * gradient[k];
    }
  }
}

/* flux = D gradient, or D^T gradient */
MPM_INLINE void TimesWhole(PetscInt N, PetscBool transposed, const Lane *restrict D, const Lane gradient[], Lane flux[])
{
  for (PetscInt k = 0; k < N; k++) flux[k] = (Lane){0.};
  for (PetscInt k = 0; k < N; k++) {
    for (PetscInt l = 0; l < N; l++, D++) {
      if (transposed) flux[l] += *D * gradient[k];
      else flux[k] += *D * gradient[l];
    }
  }
}

MPM_INLINE void TakeFlux(const Known known, const MpmFactored *factored, PetscBool transposed, PetscInt batch,
                         const Lane gradient[], Lane flux[])
{
  const PetscInt N = InputsOf(known);
  Lane           room[MPM_TANGENT_MOST];
  const Lane    *D = MpmTangentsOf(factored, batch, room);

  if (factored->half) TimesHalf(N, D, gradient, flux);
  else if (transposed) TimesWhole(N, PETSC_TRUE, D, gradient, flux);
  else TimesWhole(N, PETSC_FALSE, D, gradient, flux);
}

/* The nodes of a lane's box, or NULL where it has no point. */
MPM_INLINE const PetscInt *NodesOf(const MpmFactored *factored, PetscInt lane)
{
  const MpmSpace *space = factored->sum->space;

  return factored->group[lane] < 0 ? NULL : &space->group_nodes[space->groups[factored->group[lane]].node_offset];
}

/* Values at the nodes of a shared box, and of each lane's own. */
MPM_INLINE void GatherShared(PetscInt bs, PetscInt n, const PetscInt nodes[], const PetscReal x[], PetscReal values[])
{
  for (PetscInt i = 0; i < n; i++)
    for (PetscInt c = 0; c < bs; c++) *values++ = x[nodes[i] * bs + c];
}
MPM_INLINE void GatherLanes(PetscInt bs, PetscInt n, const MpmFactored *factored, PetscInt batch, const PetscReal x[],
                            Lane values[])
{
  for (PetscInt lane = 0; lane < MPM_LANES; lane++) {
    const PetscInt *nodes = NodesOf(factored, batch * MPM_LANES + lane);
    PetscReal      *to    = (PetscReal *)values + lane;

    for (PetscInt i = 0; i < n; i++)
      for (PetscInt c = 0; c < bs; c++, to += MPM_LANES) *to = nodes ? x[nodes[i] * bs + c] : 0.;
  }
}

/* Sums over the lanes of MPM_LANES vectors, one in each lane. */
#if defined(__clang__) || __GNUC__ >= 12
#define MIX __builtin_shufflevector
#if MPM_LANES == 8
MPM_INLINE Lane SumPairs(const Lane v[])
{
  return MIX(v[0], v[1], 0, 8, 2, 10, 4, 12, 6, 14) + MIX(v[0], v[1], 1, 9, 3, 11, 5, 13, 7, 15);
}
MPM_INLINE Lane SumFours(const Lane v[])
{
  const Lane a = SumPairs(v), b = SumPairs(v + 2);

  return MIX(a, b, 0, 1, 8, 9, 4, 5, 12, 13) + MIX(a, b, 2, 3, 10, 11, 6, 7, 14, 15);
}
MPM_INLINE Lane SumLanes(const Lane v[])
{
  const Lane a = SumFours(v), b = SumFours(v + 4);

  return MIX(a, b, 0, 1, 2, 3, 8, 9, 10, 11) + MIX(a, b, 4, 5, 6, 7, 12, 13, 14, 15);
}
#else
MPM_INLINE Lane SumPairs(const Lane v[])
{
  return MIX(v[0], v[1], 0, 4, 2, 6) + MIX(v[0], v[1], 1, 5, 3, 7);
}
MPM_INLINE Lane SumLanes(const Lane v[])
{
  const Lane a = SumPairs(v), b = SumPairs(v + 2);

  return MIX(a, b, 0, 1, 4, 5) + MIX(a, b, 2, 3, 6, 7);
}
#endif
#else
MPM_INLINE Lane SumLanes(const Lane v[])
{
  Lane sums = {0.};

  for (PetscInt k = 0; k < MPM_LANES; k++)
    for (PetscInt lane = 0; lane < MPM_LANES; lane++) sums[k] += v[k][lane];
  return sums;
}
#endif

/*
  Numbers at the nodes to those of all, `block` a node: the sum over the lanes of a shared box, and each lane's own.
  `from` has room for MPM_LANES numbers more.
*/
MPM_INLINE void ScatterShared(PetscInt block, PetscInt n, const PetscInt nodes[], const Lane from[], PetscReal y[])
{
  for (PetscInt m = 0; m < n * block; m += MPM_LANES) {
    const Lane     sums = SumLanes(&from[m]);
    const PetscInt end  = PetscMin(m + MPM_LANES, n * block);

    for (PetscInt q = m; q < end; q++) y[nodes[q / block] * block + q % block] += sums[q - m];
  }
}
MPM_INLINE void ScatterLanes(PetscInt block, PetscInt n, const MpmFactored *factored, PetscInt batch, const Lane from[],
                             PetscReal y[])
{
  for (PetscInt lane = 0; lane < MPM_LANES; lane++) {
    const PetscInt  *nodes = NodesOf(factored, batch * MPM_LANES + lane);
    const PetscReal *f     = (const PetscReal *)from + lane;

    for (PetscInt i = 0; nodes && i < n; i++)
      for (PetscInt c = 0; c < block; c++, f += MPM_LANES) y[nodes[i] * block + c] += *f;
  }
}

/* Brings the next batch's vectors into the cache, since the processor's own prefetching ends at pages. */
MPM_INLINE void Prefetch(PetscInt count, const Lane *vectors)
{
  for (PetscInt k = 0; k < count; k++) __builtin_prefetch(&vectors[k]);
}

/* The action of one stack. */
MPM_INLINE void ApplyStack(const Known known, const MpmFactored *factored, const MpmStack *stack, PetscBool transposed,
                           const PetscReal x[], PetscReal y[])
{
  const PetscInt dim = known.dim, bs = known.block, nx = NodesAlong(known, stack, 0), ny = NodesAlong(known, stack, 1),
                 nz = NodesAlong(known, stack, 2);
  const PetscInt  n = nx * ny * nz, lines = 2 * (dim == MPM_MAX_DIM ? nx + ny + nz : nx + ny);
  const PetscInt *nodes = NodesOf(factored, stack->begin * MPM_LANES);
  const PetscInt  tangent =
    factored->size * (PetscInt)(factored->single ? sizeof(LaneSingle) : sizeof(Lane)); /* bytes */
  const Lane *w      = &factored->lines[stack->lines];
  Lane       *values = factored->work, *force = values + n * bs;

  if (known.shared) {
    GatherShared(bs, n, nodes, x, (PetscReal *)values);
    for (PetscInt m = 0; m < n * bs; m++) force[m] = (Lane){0.};
  }
  for (PetscInt batch = stack->begin; batch < stack->end; batch++, w += lines) {
    Lane input[MPM_MAX_DIM * MPM_MAX_DIM], flux[MPM_MAX_DIM * MPM_MAX_DIM];

    if (!known.shared) GatherLanes(bs, n, factored, batch, x, values);
    Prefetch(tangent / (PetscInt)sizeof(Lane), (const Lane *)((const char *)factored->tangent + (batch + 1) * tangent));
    Prefetch(lines, w + lines);
    TakeInputs(known, stack, w, values, input);
    TakeFlux(known, factored, transposed, batch, input, flux);
    AddForce(known, stack, w, flux, force);
    if (!known.shared) ScatterLanes(bs, n, factored, batch, force, y);
  }
  if (known.shared) ScatterShared(bs, n, nodes, force, y);
}

/* Calls f(known, ...) with constants for the usual cases. BLOCK: unknowns a node; GRADIENT: inputs are gradients. */
#define KNOWN(DIM, ROW, SHARED, BLOCK, GRADIENT) ((Known){DIM, ROW, SHARED, BLOCK, GRADIENT, PETSC_FALSE})
#ifdef MPM_LOOPS_GENERAL
#define ROWS(f, DIM, SHARED, BLOCK, GRADIENT, ...)
#else
#define ROWS(f, DIM, SHARED, BLOCK, GRADIENT, ...) \
  case 2: \
    f(KNOWN(DIM, 2, SHARED, BLOCK, GRADIENT), __VA_ARGS__); \
    break; \
  case 3: \
    f(KNOWN(DIM, 3, SHARED, BLOCK, GRADIENT), __VA_ARGS__); \
    break; \
  case 4: \
    f(KNOWN(DIM, 4, SHARED, BLOCK, GRADIENT), __VA_ARGS__); \
    break; \
  case 5: \
    f(KNOWN(DIM, 5, SHARED, BLOCK, GRADIENT), __VA_ARGS__); \
    break;
#endif
#define BY_ROW(f, DIM, SHARED, BLOCK, GRADIENT, stack, ...) \
  switch ((stack)->count[0]) { \
    ROWS(f, DIM, SHARED, BLOCK, GRADIENT, __VA_ARGS__) \
  default: \
    f(KNOWN(DIM, 0, SHARED, BLOCK, GRADIENT), __VA_ARGS__); \
    break; \
  }
#define BY_BOX(f, DIM, BLOCK, GRADIENT, stack, ...) \
  if ((stack)->shared) { \
    BY_ROW(f, DIM, PETSC_TRUE, BLOCK, GRADIENT, stack, __VA_ARGS__) \
  } else { \
    BY_ROW(f, DIM, PETSC_FALSE, BLOCK, GRADIENT, stack, __VA_ARGS__) \
  }

#ifdef MPM_LOOPS_GENERAL
#define CUBES(SIZE)
#else
#define CUBE(SIZE, SHARED) \
  ApplyStack(((Known){MPM_MAX_DIM, SIZE, SHARED, MPM_MAX_DIM, PETSC_TRUE, PETSC_TRUE}), factored, stack, transposed, \
             x, y)
#define CUBES(SIZE) \
  case SIZE: \
    CUBE(SIZE, PETSC_TRUE); \
    break; \
  case -(SIZE): \
    CUBE(SIZE, PETSC_FALSE); \
    break;
#endif

/* The action of a stack in DIM dimensions, by the kind of inputs. */
#define APPLY_STACK(DIM, factored, ...) \
  if ((factored)->block > 1 && (factored)->gradient) { \
    BY_BOX(ApplyStack, DIM, DIM, PETSC_TRUE, __VA_ARGS__) \
  } else if ((factored)->block > 1) { \
    BY_BOX(ApplyStack, DIM, DIM, PETSC_FALSE, __VA_ARGS__) \
  } else if ((factored)->gradient) { \
    BY_BOX(ApplyStack, DIM, 1, PETSC_TRUE, __VA_ARGS__) \
  } else { \
    BY_BOX(ApplyStack, DIM, 1, PETSC_FALSE, __VA_ARGS__) \
  }

/* The action of a stack of boxes of equal sides with gradients in 3D, by constants alone. PETSC_FALSE for others. */
static PetscBool ApplyCubes(const MpmFactored *factored, const MpmStack *stack, PetscBool transposed,
                            const PetscReal x[], PetscReal y[])
{
  const PetscInt n = stack->count[0];

  if (!factored->gradient || factored->block != MPM_MAX_DIM || stack->count[1] != n || stack->count[2] != n)
    return PETSC_FALSE;
  switch (stack->shared ? n : -n) {
    CUBES(2)
    CUBES(3)
    CUBES(4)
    CUBES(5)
  default:
    return PETSC_FALSE;
  }
  return PETSC_TRUE;
}

void MpmFactoredApply(const MpmFactored *factored, PetscBool transposed, const PetscReal x[], PetscReal y[])
{
  for (PetscInt k = 0; k < factored->stack_count; k++) {
    const MpmStack *stack = &factored->stack[k];

    if (ApplyCubes(factored, stack, transposed, x, y)) continue;
    if (factored->sum->space->dim == MPM_MAX_DIM) {
      APPLY_STACK(MPM_MAX_DIM, factored, stack, factored, stack, transposed, x, y)
    } else {
      APPLY_STACK(2, factored, stack, factored, stack, transposed, x, y)
    }
  }
}

/* D_kl of a batch. */
MPM_INLINE Lane EntryOf(PetscInt N, PetscBool half, const Lane *D, PetscInt k, PetscInt l)
{
  return half ? D[MpmTriangleAt(N, PetscMin(k, l), PetscMax(k, l))] : D[k * N + l];
}

/*
  blocks_icd (+)= sum_ab g_ia D_ca,db g_ib of one batch, g_i the gradient of node i's function; w_i D_c,d w_i of values.
  Products of two factors stand for both of their orders.
*/
MPM_INLINE void AddBlocks(const Known known, PetscBool half, const MpmStack *stack, const Lane *restrict w,
                          const Lane *D, Lane *restrict blocks)
{
  const PetscInt dim = known.dim, N = InputsOf(known), bs = known.block, axes = known.gradient ? dim : 1;
  const PetscInt nx = stack->count[0], ny = stack->count[1], nz = stack->count[2];
  const Lane    *gx = w + nx, *wy = gx + nx, *gy = wy + ny, *wz = gy + ny, *gz = wz + nz, one = 1. - (Lane){0.};

  for (PetscInt k = 0; k < nz; k++) {
    for (PetscInt j = 0; j < ny; j++) {
      for (PetscInt i = 0; i < nx; i++) {
        const Lane z    = dim == MPM_MAX_DIM ? wz[k] : one;
        Lane       g[3] = {(known.gradient ? gx[i] : w[i]) * wy[j] * z, w[i] * gy[j] * z};

        if (dim == MPM_MAX_DIM) g[2] = w[i] * wy[j] * gz[k];
        for (PetscInt c = 0; c < bs; c++) {
          for (PetscInt d = 0; d < bs; d++, blocks++) {
            for (PetscInt a = 0; a < axes; a++)
              for (PetscInt b = 0; b < axes; b++)
                *blocks += g[a] * g[b] * EntryOf(N, half, D, c * axes + a, d * axes + b);
          }
        }
      }
    }
  }
}

/* Diagonal blocks of one stack. */
MPM_INLINE void DiagonalStack(const Known known, PetscBool half, const MpmFactored *factored, const MpmStack *stack,
                              PetscReal blocks[])
{
  const PetscInt nx = stack->count[0], ny = stack->count[1], nz = stack->count[2], n = nx * ny * nz;
  const PetscInt lines = 2 * (known.dim == MPM_MAX_DIM ? nx + ny + nz : nx + ny), block = known.block * known.block;
  Lane          *sums = factored->work;

  for (PetscInt batch = stack->begin; batch < stack->end; batch++) {
    Lane room[MPM_TANGENT_MOST];

    if (batch == stack->begin || !stack->shared)
      for (PetscInt m = 0; m < n * block; m++) sums[m] = (Lane){0.};
    AddBlocks(known, half, stack, &factored->lines[stack->lines + (size_t)((batch - stack->begin) * lines)],
              MpmTangentsOf(factored, batch, room), sums);
    if (!stack->shared) ScatterLanes(block, n, factored, batch, sums, blocks);
  }
  if (stack->shared) ScatterShared(block, n, NodesOf(factored, stack->begin * MPM_LANES), sums, blocks);
}

void MpmFactoredDiagonal(const MpmFactored *factored, PetscReal blocks[])
{
  const PetscInt dim = factored->sum->space->dim;
  const Known    any = KNOWN(dim, 0, PETSC_FALSE, factored->block, factored->gradient);

  for (PetscInt k = 0; k < factored->stack_count; k++) {
    const MpmStack *stack = &factored->stack[k];

    if (factored->block == 1 || !factored->gradient) DiagonalStack(any, factored->half, factored, stack, blocks);
    else if (dim == MPM_MAX_DIM && factored->half)
      DiagonalStack(KNOWN(MPM_MAX_DIM, 0, PETSC_FALSE, MPM_MAX_DIM, PETSC_TRUE), PETSC_TRUE, factored, stack, blocks);
    else if (dim == MPM_MAX_DIM)
      DiagonalStack(KNOWN(MPM_MAX_DIM, 0, PETSC_FALSE, MPM_MAX_DIM, PETSC_TRUE), PETSC_FALSE, factored, stack, blocks);
    else if (factored->half)
      DiagonalStack(KNOWN(2, 0, PETSC_FALSE, 2, PETSC_TRUE), PETSC_TRUE, factored, stack, blocks);
    else DiagonalStack(KNOWN(2, 0, PETSC_FALSE, 2, PETSC_TRUE), PETSC_FALSE, factored, stack, blocks);
  }
}

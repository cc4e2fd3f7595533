/*
  Products P^T B^T D B P of the points' tangents with coarse functions, box by box: with the share s_mi of coarse node m
  in fine node i, the gradients of the coarse functions are sums of those of the fine ones,

    grad phi_m = sum_i s_mi grad w_i ,   K_mn = sum_p grad phi_m . D_p . grad phi_n .

  In nested spaces phi_m is the coarse shape function itself. An entry of P couples equal components, or components of
  any two where a node has axes of its own.
*/
#include "action/factored_impl.h"

/* Constants of the loops: the dimension, unknowns of a node, and whether their inputs are gradients; `turned`: a coarse
   unknown acts on all components, otherwise on its own alone. */
typedef struct {
  PetscInt  dim, block;
  PetscBool gradient, turned;
} Kind;

/* Work of a box. */
typedef struct {
  const MpmCoarseBox *box;
  Lane               *basis; /* of each coarse unknown: inputs by it, of its component or of all */
  Lane               *sums;  /* its products with all unknowns; the upper triangle where D is symmetric */
} Work;

MPM_INLINE PetscInt AxesOf(const Kind kind)
{
  return kind.gradient ? kind.dim : 1;
}
MPM_INLINE PetscInt BasisSize(const Kind kind)
{
  return kind.turned ? AxesOf(kind) * kind.block : AxesOf(kind);
}

/* Adds a fine node's function to those of its coarse nodes. */
MPM_INLINE void AddFunction(const Kind kind, const Work *work, PetscInt i, const Lane g[])
{
  const MpmCoarseBox *box = work->box;
  const PetscInt      bs = kind.block, axes = AxesOf(kind), size = BasisSize(kind);

  for (PetscInt e = box->begin[i]; e < box->begin[i + 1]; e++) {
    const PetscReal *share = &box->share[e * bs * bs];
    Lane            *to    = &work->basis[box->place[e] * bs * size];

    for (PetscInt d = 0; d < bs; d++, to += size) {
      for (PetscInt c = kind.turned ? 0 : d; c < (kind.turned ? bs : d + 1); c++)
        for (PetscInt a = 0; a < axes; a++) to[(kind.turned ? c * axes : 0) + a] += share[c * bs + d] * g[a];
    }
  }
}

/* Inputs of a batch by the coarse unknowns; `w`: its lines. */
MPM_INLINE void MakeBasis(const Kind kind, const MpmStack *stack, const Lane *restrict w, const Work *work)
{
  const PetscInt nx = stack->count[0], ny = stack->count[1], nz = stack->count[2];
  const Lane    *gx = w + nx, *wy = gx + nx, *gy = wy + ny, *wz = gy + ny, *gz = wz + nz, one = 1. - (Lane){0.};

  for (PetscInt m = 0; m < work->box->count * kind.block * BasisSize(kind); m++) work->basis[m] = (Lane){0.};
  for (PetscInt k = 0, n = 0; k < nz; k++) {
    for (PetscInt j = 0; j < ny; j++) {
      for (PetscInt i = 0; i < nx; i++, n++) {
        const Lane z    = kind.dim == MPM_MAX_DIM ? wz[k] : one;
        Lane       g[3] = {(kind.gradient ? gx[i] : w[i]) * wy[j] * z, w[i] * gy[j] * z};

        if (kind.dim == MPM_MAX_DIM) g[2] = w[i] * wy[j] * gz[k];
        AddFunction(kind, work, n, g);
      }
    }
  }
}

/* Fluxes of an input by each input: D b. */
MPM_INLINE void TimesBasis(const Kind kind, PetscBool half, const Lane *restrict D, PetscInt first, const Lane b[],
                           Lane flux[])
{
  const PetscInt N = AxesOf(kind) * kind.block;

  for (PetscInt q = 0; q < N; q++) {
    flux[q] = (Lane){0.};
    for (PetscInt l = 0; l < BasisSize(kind); l++) {
      const PetscInt r = first + l;

      flux[q] += (half ? D[MpmTriangleAt(N, PetscMin(q, r), PetscMax(q, r))] : D[q * N + r]) * b[l];
    }
  }
}

/* sums += the products of a batch. */
MPM_INLINE void AddProducts(const Kind kind, PetscBool half, const Lane *restrict D, const Work *work)
{
  const PetscInt bs = kind.block, axes = AxesOf(kind), size = BasisSize(kind), nodes = work->box->count;

  for (PetscInt n = 0; n < nodes; n++) {
    for (PetscInt d = 0; d < bs; d++) {
      Lane *restrict sum = &work->sums[(n * bs + d) * nodes * bs];
      Lane flux[MPM_MAX_DIM * MPM_MAX_DIM];

      TimesBasis(kind, half, D, kind.turned ? 0 : d * axes, &work->basis[(n * bs + d) * size], flux);
      for (PetscInt m = 0; m < (half ? n + 1 : nodes); m++) {
        for (PetscInt c = 0; c < bs; c++, sum++) {
          const Lane *b = &work->basis[(m * bs + c) * size];

          for (PetscInt l = 0; l < size; l++) *sum += b[l] * flux[(kind.turned ? 0 : c * axes) + l];
        }
      }
    }
  }
}

/* The sums over the lanes as a block, row-major. */
static void FillBlock(PetscBool half, PetscInt bs, PetscInt width, const Lane sums[], PetscReal block[])
{
  for (PetscInt column = 0; column < width; column++) {
    for (PetscInt row = 0; row < width; row++) {
      const PetscBool other = (PetscBool)(half && row / bs > column / bs);
      const Lane      sum   = sums[other ? row * width + column : column * width + row];
      PetscReal       value = 0.;

      for (PetscInt lane = 0; lane < MPM_LANES; lane++) value += sum[lane];
      block[row * width + column] = value;
    }
  }
}

/* Products of the lanes `first` to `last` - 1 of batches of a stack, which share a box, into `block`. */
MPM_INLINE void ProjectLanes(const Kind kind, PetscBool half, const MpmFactored *factored, const MpmStack *stack,
                             const PetscInt range[2], const Work *work)
{
  const PetscInt lines = 2 * (stack->count[0] + stack->count[1] + (kind.dim == MPM_MAX_DIM ? stack->count[2] : 0));
  const PetscInt begin = range[0] / MPM_LANES, end = (range[1] - 1) / MPM_LANES + 1,
                 width = work->box->count * kind.block;

  for (PetscInt m = 0; m < width * width; m++) work->sums[m] = (Lane){0.};
  for (PetscInt batch = begin; batch < end; batch++) {
    const PetscInt first = batch * MPM_LANES;
    Lane           room[MPM_TANGENT_MOST], masked[MPM_TANGENT_MOST];
    const Lane    *D = MpmTangentsOf(factored, batch, room);

    if (first < range[0] || first + MPM_LANES > range[1]) {
      for (PetscInt q = 0; q < factored->size; q++)
        for (PetscInt lane = 0; lane < MPM_LANES; lane++)
          masked[q][lane] = first + lane >= range[0] && first + lane < range[1] ? D[q][lane] : 0.;
      D = masked;
    }
    MakeBasis(kind, stack, &factored->lines[stack->lines + (size_t)((batch - stack->begin) * lines)], work);
    AddProducts(kind, half, D, work);
  }
}

/* ProjectLanes() with constants for solids. */
static void Project(const Kind kind, const MpmFactored *factored, const MpmStack *stack, const PetscInt range[2],
                    const Work *work)
{
  const Kind solid = {MPM_MAX_DIM, MPM_MAX_DIM, PETSC_TRUE, PETSC_FALSE};

  if (kind.dim == MPM_MAX_DIM && kind.block == MPM_MAX_DIM && kind.gradient && !kind.turned && factored->half)
    ProjectLanes(solid, PETSC_TRUE, factored, stack, range, work);
  else ProjectLanes(kind, factored->half, factored, stack, range, work);
}

/* The box of lanes `range` of a stack, and its products. */
static PetscErrorCode ProjectBox(const MpmFactored *factored, const MpmStack *stack, const PetscInt range[2],
                                 const MpmCoarse *coarse)
{
  const MpmSpace *space = factored->sum->space;
  const PetscInt  bs    = factored->block,
                 *nodes = &space->group_nodes[space->groups[factored->group[range[0]]].node_offset];
  MpmCoarseBox box;
  Work         work = {.box = &box};
  PetscReal   *block;
  PetscInt     width;

  PetscFunctionBeginUser;
  PetscCall(coarse->box(coarse->ctx, stack->count[0] * stack->count[1] * stack->count[2], nodes, &box));
  if (!box.count) PetscFunctionReturn(PETSC_SUCCESS);
  width              = box.count * bs;
  const Kind   kind  = {space->dim, bs, factored->gradient, box.turned};
  const size_t lanes = (size_t)(width * BasisSize(kind)) + (size_t)(width * width);

  work.basis = (Lane *)aligned_alloc(sizeof(Lane), lanes * sizeof(Lane));
  PetscCheck(work.basis, PETSC_COMM_SELF, PETSC_ERR_MEM, "no %zu bytes for a box of the coarse level",
             lanes * sizeof(Lane));
  work.sums = work.basis + width * BasisSize(kind);
  PetscCall(PetscMalloc1((width * width), &block));
  Project(kind, factored, stack, range, &work);
  FillBlock(factored->half, bs, width, work.sums, block);
  PetscCall(coarse->add(coarse->ctx, block));
  PetscCall(PetscFree(block));
  free(work.basis);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmFactoredProject(const MpmFactored *factored, const MpmCoarse *coarse)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < factored->stack_count; k++) {
    const MpmStack *stack = &factored->stack[k];
    PetscInt        range[2], end = stack->end * MPM_LANES;

    while (end > stack->begin * MPM_LANES && factored->group[end - 1] < 0) end--;
    for (range[0] = stack->begin * MPM_LANES; range[0] < end; range[0] = range[1]) {
      range[1] = range[0] + 1;
      while (range[1] < end && factored->group[range[1]] == factored->group[range[0]]) range[1]++;
      PetscCall(ProjectBox(factored, stack, range, coarse));
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MpmFactoredRange(const MpmFactored *factored, PetscReal least[], PetscReal most[])
{
  const PetscInt N = factored->inputs;

  for (PetscInt g = 0; g < factored->sum->space->group_count; g++) {
    least[g] = PETSC_MAX_REAL;
    most[g]  = 0.;
  }
  for (PetscInt lane = 0; lane < factored->batch_count * MPM_LANES; lane++) {
    const PetscInt g = factored->group[lane], first = lane / MPM_LANES * factored->size * MPM_LANES + lane % MPM_LANES;
    PetscReal      trace = 0.;

    if (g < 0) continue;
    for (PetscInt k = 0; k < N; k++) {
      const PetscInt at = first + (factored->half ? MpmTriangleAt(N, k, k) : k * (N + 1)) * MPM_LANES;

      trace += factored->single ? (PetscReal)((const float *)factored->tangent)[at]
                                : ((const PetscReal *)factored->tangent)[at];
    }
    least[g] = PetscMin(least[g], trace);
    most[g]  = PetscMax(most[g], trace);
  }
}

/*
  The forces of inertia in an implicit step, with a mass that is lumped or consistent:

    M_ij = sum_p m_p w_i w_j ,     or its sums over j on the diagonal.

  Nodes that are no grid's, those of rigid bodies, have a mass of their own, which is lumped in any case.
*/
#include "space/motion.h"
#include "space/stencil.h"
#include "terms/inertia.h"
#include "terms/sparsity.h"
#include "terms/terms.h"

PetscErrorCode MpmInertiaReset(MpmInertia *inertia)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree2(inertia->mass, inertia->at_rest));
  inertia->active = PETSC_FALSE;
  inertia->local = inertia->owned = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmInertiaResize(MpmInertia *inertia, const MpmSpace *space)
{
  PetscFunctionBeginUser;
  PetscCall(MpmInertiaReset(inertia));
  PetscCall(PetscCalloc2(space->local, &inertia->mass, (space->local * space->dim), &inertia->at_rest));
  inertia->local = space->local;
  inertia->owned = space->owned;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A point's weights at its group's nodes, x fastest. */
MPM_INLINE void FindWeights(const MpmKnown known, const MpmSpace *space, PetscInt p, PetscReal weight[])
{
  const PetscInt   dim = known.dim, W = space->width;
  const PetscReal *w = &space->shape[0].weight[p * dim * W];

  for (PetscInt l = 0; l < (dim == 2 ? 1 : known.count[2]); l++) {
    for (PetscInt j = 0; j < known.count[1]; j++, weight += known.count[0]) {
      const PetscReal row = dim == 2 ? w[W + j] : w[W + j] * w[2 * W + l];

      for (PetscInt k = 0; k < known.count[0]; k++) weight[k] = w[k] * row;
    }
  }
}

/* The first owned node whose mass is lumped. */
static PetscInt FirstLumped(const MpmInertia *inertia, const MpmSpace *space)
{
  return inertia->consistent ? PetscMin(space->extra.begin, space->owned) : 0;
}

PetscErrorCode MpmInertiaMultiply(const MpmInertia *inertia, const MpmSum *sum, const PetscReal a[], PetscReal y[])
{
  const PetscInt dim = sum->space->dim;

  PetscFunctionBeginUser;
  for (PetscInt i = FirstLumped(inertia, sum->space); i < sum->space->owned; i++)
    for (PetscInt c = 0; c < dim; c++) y[i * dim + c] += inertia->mass[i] * a[i * dim + c];
  if (inertia->consistent) PetscCall(MpmMassMultiply(sum, a, y));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the term ---- */

static PetscErrorCode Residual(const void *ctx, const MpmSum *sum, const PetscReal u[], PetscReal residual[],
                               PetscInt *failed)
{
  const MpmInertia *inertia = (const MpmInertia *)ctx;
  const PetscInt    count   = sum->space->local * sum->space->dim;
  PetscReal        *a;

  PetscFunctionBeginUser;
  (void)failed;
  if (!inertia->active) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(count, &a));
  for (PetscInt k = 0; k < count; k++) a[k] = inertia->factor * u[k] + inertia->at_rest[k];
  PetscCall(MpmInertiaMultiply(inertia, sum, a, residual));
  PetscCall(PetscFree(a));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Apply(const void *ctx, const MpmSum *sum, const PetscReal u[], const PetscReal du[],
                            PetscReal y[])
{
  const MpmInertia *inertia = (const MpmInertia *)ctx;
  const PetscInt    count   = sum->space->local * sum->space->dim;
  PetscReal        *a;

  PetscFunctionBeginUser;
  (void)u;
  if (!inertia->active) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(count, &a));
  for (PetscInt k = 0; k < count; k++) a[k] = inertia->factor * du[k];
  PetscCall(MpmInertiaMultiply(inertia, sum, a, y));
  PetscCall(PetscFree(a));
  PetscFunctionReturn(PETSC_SUCCESS);
}

#define TOGETHER 8 /* points whose products are summed before they go to the element */

/* factor sum_p m_p w_i w_j of one group, added to the blocks of its element. */
MPM_INLINE PetscErrorCode AddElement(const MpmKnown known, const MpmSum *sum, const MpmGroup *group, PetscReal factor,
                                     PetscReal work[], PetscReal element[])
{
  const PetscInt n = known.n, bs = known.block;
  PetscReal *restrict w = work;

  for (PetscInt from = group->point_begin; from < group->point_end; from += TOGETHER) {
    const PetscInt count = PetscMin(TOGETHER, group->point_end - from);
    PetscReal      mass[TOGETHER];

    for (PetscInt q = 0; q < count; q++) {
      const PetscInt p = sum->space->order[from + q];

      mass[q] = factor * MpmPointMass(sum->points, sum->materials, p);
      FindWeights(known, sum->space, p, &w[q * n]);
    }
    for (PetscInt i = 0; i < n; i++) {
      PetscReal *restrict to = &element[i * bs * bs * n];
      PetscReal by[TOGETHER];

      for (PetscInt q = 0; q < count; q++) by[q] = mass[q] * w[q * n + i];
      for (PetscInt j = 0; j + SLIM <= n; j += SLIM) {
        Slim four = by[0] * *(const Slim *)&w[j];

        for (PetscInt q = 1; q < count; q++) four += by[q] * *(const Slim *)&w[q * n + j];
        for (PetscInt c = 0; c < known.dim; c++) *(Slim *)&to[(c * bs + c) * n + j] += four;
      }
      for (PetscInt j = n / SLIM * SLIM; j < n; j++) {
        PetscReal one = by[0] * w[j];

        for (PetscInt q = 1; q < count; q++) one += by[q] * w[q * n + j];
        for (PetscInt c = 0; c < known.dim; c++) to[(c * bs + c) * n + j] += one;
      }
    }
  }
  return PETSC_SUCCESS;
}

PetscInt MpmInertiaWork(PetscInt nodes)
{
  return (TOGETHER + 1) * nodes;
}

PetscErrorCode MpmInertiaAddElement(const MpmSum *sum, const MpmGroup *group, PetscReal factor, PetscReal work[],
                                    PetscReal element[])
{
  PetscFunctionBeginUser;
  MPM_DISPATCH(sum->layout, group, AddElement, sum, group, factor, work, element);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Tangent(const void *ctx, const MpmSum *sum, const PetscReal u[], MpmPattern *pattern,
                              PetscReal residual[], PetscInt *failed)
{
  const MpmInertia *inertia = (const MpmInertia *)ctx;
  const PetscInt    bs = sum->block, most = PetscPowInt(sum->space->width, sum->space->dim);
  PetscReal        *element, *work;

  PetscFunctionBeginUser;
  if (!inertia->active) PetscFunctionReturn(PETSC_SUCCESS);
  if (residual) PetscCall(Residual(ctx, sum, u, residual, failed));
  for (PetscInt i = FirstLumped(inertia, sum->space); i < sum->space->owned; i++) {
    PetscReal block[MPM_MAX_BLOCK * MPM_MAX_BLOCK] = {0.};

    if (inertia->mass[i] == 0.) continue;
    for (PetscInt c = 0; c < sum->space->dim; c++) block[c * bs + c] = inertia->factor * inertia->mass[i];
    MpmPatternAddNodes(pattern, sum->space, 1, &i, block);
  }
  if (!inertia->consistent || sum->mass_factor > 0.) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc2((most * most * bs * bs), &element, MpmInertiaWork(most), &work));
  for (PetscInt g = 0; g < sum->space->group_count; g++) {
    const MpmGroup *group = &sum->space->groups[g];

    PetscCall(PetscArrayzero(element, PetscSqr(group->node_count * bs)));
    PetscCall(MpmInertiaAddElement(sum, group, inertia->factor, work, element));
    MpmPatternAddBlock(pattern, sum->space, group, element);
  }
  PetscCall(PetscFree2(element, work));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Diagonal(const void *ctx, const MpmSum *sum, const PetscReal u[], PetscReal blocks[],
                               PetscInt *failed)
{
  const MpmInertia *inertia = (const MpmInertia *)ctx;
  const PetscInt    bs = sum->block, dim = sum->space->dim;
  MpmWorkspace      work;

  PetscFunctionBeginUser;
  (void)u, (void)failed;
  if (!inertia->active) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt i = FirstLumped(inertia, sum->space); i < sum->space->owned; i++)
    for (PetscInt c = 0; c < dim; c++) blocks[(i * bs + c) * bs + c] += inertia->factor * inertia->mass[i];
  if (!inertia->consistent) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmWorkspaceCreate(sum, &work));
  for (PetscInt g = 0; g < sum->space->group_count; g++) {
    const MpmGroup *group = &sum->space->groups[g];
    const PetscInt *nodes = &sum->space->group_nodes[group->node_offset];

    for (PetscInt s = group->point_begin; s < group->point_end; s++) {
      const PetscInt  p    = sum->space->order[s];
      const PetscReal mass = inertia->factor * MpmPointMass(sum->points, sum->materials, p);

      FindWeights(KnownGeneral(sum->layout, group), sum->space, p, work.basis.basis[0]);
      for (PetscInt i = 0; i < group->node_count; i++)
        for (PetscInt c = 0; c < dim; c++)
          blocks[(nodes[i] * bs + c) * bs + c] += mass * PetscSqr(work.basis.basis[0][i]);
    }
  }
  PetscCall(PetscFree(work.storage));
  PetscFunctionReturn(PETSC_SUCCESS);
}

const MpmTerm MpmTermInertia = {
  .name = "inertia", .residual = Residual, .tangent = Tangent, .apply = Apply, .diagonal = Diagonal};

/*
  The forces of inertia in an implicit step, with a mass that is lumped or consistent:

    M_ij = sum_p m_p w_i w_j ,     or its sums over j on the diagonal.

  Nodes that are no grid's, those of rigid bodies, have a mass of their own, which is lumped in any case.
*/
#include "space/point_loop.h"
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

/* One group's part of M a with a consistent mass; `work->values` and `force` hold [c][i]. */
MPM_INLINE PetscErrorCode MultiplyGroup(const MpmKnown known, const MpmSum *sum, const MpmGroup *group,
                                        const PetscReal a[], MpmWorkspace *work, PetscReal y[])
{
  const PetscInt n = known.n;

  MpmSumGather(known, sum, group, a, work->values);
  for (PetscInt k = 0; k < n * known.block; k++) work->force[k] = 0.;
  for (PetscInt s = group->point_begin; s < group->point_end; s++) {
    const PetscInt   p    = sum->space->order[s];
    const PetscReal  mass = MpmPointMass(sum->points, sum->materials, p);
    const PetscReal *w    = work->basis.basis[0];

    MpmSumBasis(known, sum->space, p, PETSC_TRUE, &work->basis);
    for (PetscInt c = 0; c < known.dim; c++) {
      PetscReal value = 0.;

      for (PetscInt i = 0; i < n; i++) value += w[i] * work->values[c * n + i];
      for (PetscInt i = 0; i < n; i++) work->force[c * n + i] += mass * value * w[i];
    }
  }
  MpmSumScatter(known, sum, group, work->force, y);
  return PETSC_SUCCESS;
}

/* The first owned node whose mass is lumped. */
static PetscInt FirstLumped(const MpmInertia *inertia, const MpmSpace *space)
{
  return inertia->consistent ? PetscMin(space->extra.begin, space->owned) : 0;
}

PetscErrorCode MpmInertiaMultiply(const MpmInertia *inertia, const MpmSum *sum, const PetscReal a[], PetscReal y[])
{
  const PetscInt dim = sum->space->dim;
  MpmWorkspace   work;

  PetscFunctionBeginUser;
  for (PetscInt k = FirstLumped(inertia, sum->space) * dim; k < sum->space->owned * dim; k++)
    y[k] += inertia->mass[k / dim] * a[k];
  if (!inertia->consistent) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmWorkspaceCreate(sum, &work));
  for (PetscInt g = 0; g < sum->space->group_count; g++)
    MPM_DISPATCH(sum->layout, &sum->space->groups[g], MultiplyGroup, sum, &sum->space->groups[g], a, &work, y);
  PetscCall(PetscFree(work.storage));
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

/* The element block of a group's consistent mass. */
MPM_INLINE PetscErrorCode AddGroup(const MpmKnown known, const MpmInertia *inertia, const MpmSum *sum,
                                   const MpmGroup *group, MpmWorkspace *work, PetscReal mass[], PetscReal element[])
{
  const PetscInt n = known.n, bs = known.block;

  for (PetscInt k = 0; k < n * n; k++) mass[k] = 0.;
  for (PetscInt s = group->point_begin; s < group->point_end; s++) {
    const PetscInt   p  = sum->space->order[s];
    const PetscReal  by = inertia->factor * MpmPointMass(sum->points, sum->materials, p);
    const PetscReal *w  = work->basis.basis[0];

    MpmSumBasis(known, sum->space, p, PETSC_TRUE, &work->basis);
    for (PetscInt i = 0; i < n; i++)
      for (PetscInt j = 0; j < n; j++) mass[i * n + j] += by * w[i] * w[j];
  }
  for (PetscInt k = 0; k < n * n * bs * bs; k++) element[k] = 0.;
  for (PetscInt i = 0; i < n; i++)
    for (PetscInt c = 0; c < known.dim; c++)
      for (PetscInt j = 0; j < n; j++) element[((i * bs + c) * bs + c) * n + j] = mass[i * n + j];
  return PETSC_SUCCESS;
}

/* Of lumped masses; the points' tangents hold the consistent one (tangent.c). */
static PetscErrorCode Tangent(const void *ctx, const MpmSum *sum, const PetscReal u[], MpmPattern *pattern,
                              PetscReal residual[], PetscInt *failed)
{
  const MpmInertia *inertia = (const MpmInertia *)ctx;
  const PetscInt    bs      = sum->block;

  PetscFunctionBeginUser;
  if (!inertia->active) PetscFunctionReturn(PETSC_SUCCESS);
  if (residual) PetscCall(Residual(ctx, sum, u, residual, failed));
  for (PetscInt i = FirstLumped(inertia, sum->space); i < sum->space->owned; i++) {
    PetscReal block[MPM_MAX_BLOCK * MPM_MAX_BLOCK] = {0.};

    if (inertia->mass[i] == 0.) continue;
    for (PetscInt c = 0; c < sum->space->dim; c++) block[c * bs + c] = inertia->factor * inertia->mass[i];
    MpmPatternAddNodes(pattern, sum->space, 1, &i, block);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* With a consistent mass, too. */
static PetscErrorCode TangentAlone(const void *ctx, const MpmSum *sum, const PetscReal u[], MpmPattern *pattern,
                                   PetscInt *failed)
{
  const MpmInertia *inertia = (const MpmInertia *)ctx;
  const PetscInt    bs = sum->block, most = PetscPowInt(sum->space->width, sum->space->dim);
  PetscReal        *mass, *element;
  MpmWorkspace      work;

  PetscFunctionBeginUser;
  PetscCall(Tangent(ctx, sum, u, pattern, NULL, failed));
  if (!inertia->active || !inertia->consistent) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmWorkspaceCreate(sum, &work));
  PetscCall(PetscMalloc2((most * most), &mass, (most * most * bs * bs), &element));
  for (PetscInt g = 0; g < sum->space->group_count; g++) {
    const MpmGroup *group = &sum->space->groups[g];

    MPM_DISPATCH(sum->layout, group, AddGroup, inertia, sum, group, &work, mass, element);
    MpmPatternAddBlock(pattern, sum->space, group, element);
  }
  PetscCall(PetscFree2(mass, element));
  PetscCall(PetscFree(work.storage));
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

      MpmSumBasis(KnownGeneral(sum->layout, group), sum->space, p, PETSC_TRUE, &work.basis);
      for (PetscInt i = 0; i < group->node_count; i++)
        for (PetscInt c = 0; c < dim; c++)
          blocks[(nodes[i] * bs + c) * bs + c] += mass * PetscSqr(work.basis.basis[0][i]);
    }
  }
  PetscCall(PetscFree(work.storage));
  PetscFunctionReturn(PETSC_SUCCESS);
}

const MpmTerm MpmTermInertia = {.name          = "inertia",
                                .residual      = Residual,
                                .tangent       = Tangent,
                                .tangent_alone = TangentAlone,
                                .apply         = Apply,
                                .diagonal      = Diagonal};

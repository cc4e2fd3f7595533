/*
  The forces of inertia in an implicit step, with a mass that is lumped or consistent:

    M_ij = sum_p m_p w_i w_j ,     or its sums over j on the diagonal.

  Nodes that are no grid's, those of rigid bodies, have a mass of their own, which is lumped in any case.
*/
#include "space/space.h"
#include "space/sum.h"
#include "bc/bc.h"
#include "assembly/sparsity.h"
#include "assembly/terms.h"
#include "volume/inertia.h"

PetscErrorCode MpmInertiaReset(MpmInertia *inertia)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree2(inertia->mass, inertia->at_rest));
  PetscCall(MpmMassMatrixReset(&inertia->matrix));
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

/* The first owned node whose mass is lumped. */
static PetscInt FirstLumped(const MpmInertia *inertia, const MpmSpace *space)
{
  return inertia->consistent ? PetscMin(space->extra.begin, space->owned) : 0;
}

/* y += M a */
MPM_INLINE void Multiply(PetscInt dim, const MpmMassMatrix *mass, const PetscReal *restrict a, PetscReal *restrict y)
{
  for (PetscInt i = 0; i < mass->nodes; i++) {
    PetscReal total[MPM_MAX_DIM] = {0., 0., 0.};

    for (PetscInt k = mass->start[i]; k < mass->start[i + 1]; k++)
      for (PetscInt c = 0; c < dim; c++) total[c] += mass->value[k] * a[mass->column[k] * dim + c];
    for (PetscInt c = 0; c < dim; c++) y[i * dim + c] += total[c];
  }
}

PetscErrorCode MpmInertiaTimes(const MpmInertia *inertia, const MpmSum *sum, const PetscReal a[], PetscReal y[])
{
  const PetscInt dim = sum->space->dim;

  PetscFunctionBeginUser;
  for (PetscInt i = FirstLumped(inertia, sum->space); i < sum->space->owned; i++)
    for (PetscInt c = 0; c < dim; c++) y[i * dim + c] += inertia->mass[i] * a[i * dim + c];
  if (inertia->consistent) MPM_BY_DIM(dim, Multiply, &inertia->matrix, a, y);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmInertiaDiagonal(const MpmInertia *inertia, const MpmSum *sum, PetscReal diagonal[])
{
  const MpmMassMatrix *mass = &inertia->matrix;
  const PetscInt       dim  = sum->space->dim;

  PetscFunctionBeginUser;
  for (PetscInt i = FirstLumped(inertia, sum->space); i < sum->space->owned; i++)
    for (PetscInt c = 0; c < dim; c++) diagonal[i * dim + c] += inertia->mass[i];
  for (PetscInt i = 0; inertia->consistent && i < mass->nodes; i++)
    for (PetscInt k = mass->start[i]; k < mass->start[i + 1]; k++)
      for (PetscInt c = 0; c < dim && mass->column[k] == i; c++) diagonal[i * dim + c] += mass->value[k];
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmInertiaSharpen(const MpmInertia *inertia, const MpmSum *sum, const MpmConstraints *constraints,
                                 PetscReal values[])
{
  const PetscInt dim = sum->space->dim, count = inertia->local * dim;
  PetscReal     *moved;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(count, &moved));
  PetscCall(MpmInertiaTimes(inertia, sum, values, moved));
  PetscCall(MpmSpaceAddToOwners(sum->space, dim, moved));
  PetscCall(MpmSpaceToGhosts(sum->space, dim, moved));
  for (PetscInt k = 0; k < count; k++) {
    const PetscReal mass = inertia->mass[k / dim];

    moved[k] = mass > 0. ? values[k] - moved[k] / mass : 0.;
  }
  MpmFramesToUnknowns(constraints, dim, inertia->local, moved);
  MpmConstraintsZero(constraints, count, moved);
  MpmFramesToAxes(constraints, dim, inertia->local, moved);
  for (PetscInt k = 0; k < count; k++) values[k] += moved[k];
  PetscCall(PetscFree(moved));
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
  PetscCall(MpmInertiaTimes(inertia, sum, a, residual));
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
  PetscCall(MpmInertiaTimes(inertia, sum, a, y));
  PetscCall(PetscFree(a));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* An entry between two nodes as an element block. */
static void AddEntry(const MpmSpace *space, const PetscInt nodes[2], PetscReal value, MpmPattern *pattern)
{
  const PetscInt bs                                     = pattern->block;
  PetscReal      element[4 * MPM_MAX_DIM * MPM_MAX_DIM] = {0.};

  for (PetscInt c = 0; c < bs; c++) element[(c * bs + c) * 2 + 1] = value;
  MpmPatternAddNodes(pattern, space, 2, nodes, element);
}

MPM_INLINE void AddRows(PetscInt dim, const MpmMassMatrix *mass, const MpmSpace *space, PetscReal factor,
                        const PetscInt at[], MpmPattern *pattern)
{
  const MpmConstraints *constraints = pattern->constraints;

  for (PetscInt i = 0; i < mass->nodes; i++) {
    const PetscInt width = (pattern->row[i + 1] - pattern->row[i]) * dim, *slot = &pattern->slot[i * pattern->window];

    for (PetscInt k = mass->start[i]; k < mass->start[i + 1]; k++) {
      const PetscInt  j     = mass->column[k];
      const PetscReal value = factor * mass->value[k];
      PetscReal      *to    = pattern->value[i] + slot[at[mass->place[k]]] * dim;

      if (i != j && (MpmConstraintsFrame(constraints, i) || MpmConstraintsFrame(constraints, j))) {
        AddEntry(space, (const PetscInt[]){i, j}, value, pattern); /* no multiple of the identity in a frame */
        continue;
      }
      for (PetscInt c = 0; c < dim; c++)
        if (MpmConstraintsCounts(constraints, i * dim + c) && MpmConstraintsCounts(constraints, j * dim + c))
          to[c * (width + 1)] += value;
    }
  }
}

/* Adds factor M to the Jacobian, whose block is dim. */
static PetscErrorCode AddMatrix(const MpmMassMatrix *mass, const MpmSpace *space, PetscReal factor, MpmPattern *pattern)
{
  const PetscInt dim = space->dim, side = 2 * mass->reach + 1, size = PetscPowInt(side, dim);
  PetscInt      *at; /* where the places of this window are in the pattern's */

  PetscFunctionBeginUser;
  for (PetscInt i = 0; pattern->action && i < mass->nodes; i++)
    for (PetscInt k = mass->start[i]; k < mass->start[i + 1]; k++)
      AddEntry(space, (const PetscInt[]){i, mass->column[k]}, factor * mass->value[k], pattern);
  if (pattern->action) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(size, &at));
  for (PetscInt k = 0; k < size; k++) {
    PetscInt stride = 1, rest = k;

    at[k] = (pattern->window - 1) / 2;
    for (PetscInt a = 0; a < dim; a++, rest /= side, stride *= 2 * pattern->reach + 1)
      at[k] += (rest % side - mass->reach) * stride;
  }
  MPM_BY_DIM(dim, AddRows, mass, space, factor, at, pattern);
  PetscCall(PetscFree(at));
  PetscFunctionReturn(PETSC_SUCCESS);
}

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
  if (inertia->consistent) PetscCall(AddMatrix(&inertia->matrix, sum->space, inertia->factor, pattern));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Its diagonal to diagonal blocks, dim^2 values a local node. */
static void AddDiagonal(const MpmMassMatrix *mass, PetscInt dim, PetscReal factor, PetscReal blocks[])
{
  for (PetscInt i = 0; i < mass->nodes; i++)
    for (PetscInt k = mass->start[i]; k < mass->start[i + 1]; k++)
      for (PetscInt c = 0; c < dim && mass->column[k] == i; c++)
        blocks[(i * dim + c) * dim + c] += factor * mass->value[k];
}

static PetscErrorCode Diagonal(const void *ctx, const MpmSum *sum, const PetscReal u[], PetscReal blocks[],
                               PetscInt *failed)
{
  const MpmInertia *inertia = (const MpmInertia *)ctx;
  const PetscInt    bs = sum->block, dim = sum->space->dim;

  PetscFunctionBeginUser;
  (void)u, (void)failed;
  if (!inertia->active) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt i = FirstLumped(inertia, sum->space); i < sum->space->owned; i++)
    for (PetscInt c = 0; c < dim; c++) blocks[(i * bs + c) * bs + c] += inertia->factor * inertia->mass[i];
  if (inertia->consistent) AddDiagonal(&inertia->matrix, dim, inertia->factor, blocks);
  PetscFunctionReturn(PETSC_SUCCESS);
}

const MpmTerm MpmTermInertia = {.name             = "inertia",
                                .residual         = Residual,
                                .tangent          = Tangent,
                                .apply            = Apply,
                                .diagonal         = Diagonal,
                                .energy.quadratic = MpmTermIsQuadratic};

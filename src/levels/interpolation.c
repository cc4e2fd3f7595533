/*
  Interpolation between levels: products of the two-scale relations of the axes, for the unknowns of the finer level,
  and for displacements of all local nodes of the finest one.
*/
#include "space/space.h"
#include "bc/bc.h"
#include "levels/level_impl.h"

/* Rows of the interpolation that this rank owns. */
typedef struct {
  PetscInt    *begin, *column;
  PetscScalar *value;
} Rows;

/* The rows of fine node i, component by component: a node with a frame has its components along the axes of that. */
static void FillRows(const Coarsening *to, PetscInt i, const MpmFrame *frame, PetscInt dim, Rows *rows)
{
  const Parents  of = ParentsOf(to, i);
  const PetscInt bs = to->rules->block;
  PetscInt       at[NUMBERS];

  for (PetscInt c = 0; c < bs; c++) {
    const PetscBool turned = (PetscBool)(frame && c < dim), free = (PetscBool)(to->fine->free[i] >> c & 1);
    PetscInt        fill = rows->begin[i * bs + c];

    for (PetscInt k = 0; k < of.total; k++) {
      const PetscReal share = free ? ParentAt(&of, k, at) : (ParentAt(&of, k, at), 0.);
      const PetscInt  node  = *MapAt(&to->named, at) - 1;

      for (PetscInt d = turned ? 0 : c; d < (turned ? dim : c + 1); d++) {
        rows->column[fill]  = node * bs + d;
        rows->value[fill++] = turned ? frame->axis[c][d] * share : share;
      }
    }
    rows->begin[i * bs + c + 1] = fill;
  }
}

/* Unknowns of the k-th node without a place stay on all levels. */
static void FillExtraRows(const Coarsening *to, PetscInt i, PetscInt k, Rows *rows)
{
  const PetscInt bs = to->rules->block, node = to->coarse->count - to->rules->extra + k;

  for (PetscInt c = 0; c < bs; c++) {
    const PetscInt at = rows->begin[i * bs + c];

    rows->column[at]            = node * bs + c;
    rows->value[at]             = to->fine->free[i] >> c & 1 ? 1. : 0.;
    rows->begin[i * bs + c + 1] = at + 1;
  }
}

/* Clears the columns of unknowns that are not solved for on the coarse level. */
static PetscErrorCode ClearHeld(const Coarsening *to, Mat interpolation)
{
  const PetscInt bs = to->rules->block;
  PetscScalar   *value;
  Vec            keep;

  PetscFunctionBeginUser;
  PetscCall(MatCreateVecs(interpolation, &keep, NULL));
  PetscCall(VecGetArrayWrite(keep, &value));
  for (PetscInt k = 0; k < to->coarse->owned * bs; k++) value[k] = to->coarse->free[k / bs] >> k % bs & 1 ? 1. : 0.;
  PetscCall(VecRestoreArrayWrite(keep, &value));
  PetscCall(MatDiagonalScale(interpolation, NULL, keep));
  PetscCall(VecDestroy(&keep));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmMakeInterpolation(const Coarsening *to, const MpmConstraints *constraints, Mat *interpolation)
{
  const PetscInt bs = to->rules->block, owned = to->fine->owned * bs, dim = constraints ? constraints->dim : bs;
  size_t         entries = 0;
  PetscInt       extra   = 0;
  Rows           rows;

  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < to->fine->owned; i++) {
    const PetscBool turned = (PetscBool)(constraints && MpmConstraintsFrame(constraints, i));

    entries += (size_t)((HasPlace(to->fine, i) ? ParentsOf(to, i).total : 1) * (turned ? dim * dim + bs - dim : bs));
  }
  PetscCall(PetscMalloc3((owned + 1), &rows.begin, entries, &rows.column, entries, &rows.value));
  rows.begin[0] = 0;
  for (PetscInt i = 0; i < to->fine->owned; i++) {
    if (HasPlace(to->fine, i)) FillRows(to, i, constraints ? MpmConstraintsFrame(constraints, i) : NULL, dim, &rows);
    else FillExtraRows(to, i, extra++, &rows);
  }
  PetscCall(MatCreate(to->rules->comm, interpolation));
  PetscCall(MatSetSizes(*interpolation, owned, to->coarse->owned * bs, to->fine->count * bs, to->coarse->count * bs));
  PetscCall(MatSetBlockSizes(*interpolation, bs, bs));
  PetscCall(MatSetType(*interpolation, MATAIJ));
  PetscCall(MatSeqAIJSetPreallocationCSR(*interpolation, rows.begin, rows.column, rows.value));
  PetscCall(MatMPIAIJSetPreallocationCSR(*interpolation, rows.begin, rows.column, rows.value));
  PetscCall(PetscFree3(rows.begin, rows.column, rows.value));
  PetscCall(ClearHeld(to, *interpolation));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- local nodes ---- */

/* The share of coarse component d in component c of a node; components along the axes, free ones alone. */
static PetscReal ShareOf(const MpmFrame *frame, PetscInt dim, PetscInt free, PetscInt c, PetscInt d)
{
  PetscReal share = 0.;

  if (!frame || c >= dim || d >= dim) return c == d && free >> c & 1 ? 1. : 0.;
  for (PetscInt r = 0; r < dim; r++)
    if (free >> r & 1) share += frame->axis[r][c] * frame->axis[r][d];
  return share;
}

static PetscErrorCode Reserve(PetscInt more, MpmLocalRows *rows, PetscInt *capacity)
{
  PetscFunctionBeginUser;
  if (rows->entries + more <= *capacity) PetscFunctionReturn(PETSC_SUCCESS);
  *capacity = 2 * *capacity + more + 64;
  PetscCall(PetscRealloc((size_t)*capacity * sizeof(*rows->node), &rows->node));
  PetscCall(PetscRealloc((size_t)(*capacity * rows->block * rows->block) * sizeof(*rows->share), &rows->share));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds a node's sum over coarse nodes, times `factor` by component, to node `row`. */
static PetscErrorCode AddParents(const Coarsening *to, const MpmConstraints *constraints, PetscInt i,
                                 const PetscReal factor[], MpmLocalRows *rows, PetscInt *capacity)
{
  const MpmFrame *frame = MpmConstraintsFrame(constraints, i);
  const PetscInt  bs    = to->rules->block;
  const Parents   of    = ParentsOf(to, i);
  PetscInt        at[NUMBERS];

  PetscFunctionBeginUser;
  PetscCall(Reserve(of.total, rows, capacity));
  for (PetscInt k = 0; k < of.total; k++) {
    const PetscReal share = ParentAt(&of, k, at);

    for (PetscInt e = 0; e < bs * bs; e++)
      rows->share[rows->entries * bs * bs + e] =
        factor[e / bs] * share * ShareOf(frame, constraints->dim, to->fine->free[i], e / bs, e % bs);
    rows->node[rows->entries++] = *MapAt(&to->named, at) - 1;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Values along the axes of local node i: its own, and for components that follow those of its masters. */
static PetscErrorCode FillLocal(const Coarsening *to, const MpmFinest *finest, PetscInt i, PetscInt *capacity)
{
  const MpmExtension   *extension   = &finest->space->extension;
  const MpmConstraints *constraints = finest->constraints;
  const PetscInt        bs = to->rules->block, f = extension->of ? extension->of[i] : -1;
  PetscReal             factor[MPM_MAX_BLOCK];

  PetscFunctionBeginUser;
  for (PetscInt c = 0; c < bs; c++) factor[c] = 1.;
  PetscCall(AddParents(to, constraints, i, factor, finest->rows, capacity));
  for (PetscInt k = f < 0 ? 0 : extension->offset[f]; f >= 0 && k < extension->offset[f + 1]; k++) {
    for (PetscInt c = 0; c < bs; c++)
      factor[c] = constraints->condition[i * bs + c] == MPM_FOLLOWS ? extension->weight[k] : 0.;
    PetscCall(AddParents(to, constraints, extension->master[k], factor, finest->rows, capacity));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmMakeLocalRows(const Coarsening *to, const MpmFinest *finest)
{
  const PetscInt bs       = to->rules->block;
  MpmLocalRows  *rows     = finest->rows;
  PetscInt       capacity = 0, extra = 0;

  PetscFunctionBeginUser;
  *rows = (MpmLocalRows){.block = bs};
  PetscCall(PetscMalloc1((to->fine->local + 1), &rows->begin));
  for (PetscInt i = 0; i < to->fine->local; i++) {
    rows->begin[i] = rows->entries;
    if (HasPlace(to->fine, i)) {
      PetscCall(FillLocal(to, finest, i, &capacity));
      continue;
    }
    PetscCall(Reserve(1, rows, &capacity));
    for (PetscInt e = 0; e < bs * bs; e++)
      rows->share[rows->entries * bs * bs + e] = ShareOf(NULL, bs, to->fine->free[i], e / bs, e % bs);
    rows->node[rows->entries++] = to->coarse->count - to->rules->extra + extra++;
  }
  rows->begin[to->fine->local] = rows->entries;
  if (!rows->entries) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscRealloc((size_t)rows->entries * sizeof(*rows->node), &rows->node));
  PetscCall(PetscRealloc((size_t)(rows->entries * bs * bs) * sizeof(*rows->share), &rows->share));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmLocalRowsDestroy(MpmLocalRows *rows)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(rows->begin));
  PetscCall(PetscFree(rows->node));
  PetscCall(PetscFree(rows->share));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  PC type `cells`. In a cell with few stiff points among soft ones the stiff ones hold the diagonal of all of its nodes,
  but not all displacements of these: elements of order 2 have 81 unknowns a cell, a point has six strains. The others
  are as soft as the soft points, far below the diagonal, and too rough for a coarser level. In such cells the block A_k
  of the nodes is inverted,

    z = D^-1 r at unknowns of no such cell  +  sum_k R_k^T A_k^-1 R_k r .

  Nodes with axes of their own, those that follow others or are followed, and those that several ranks see keep D.

  Source: de Prenter, Verhoosel and van Brummelen (2019), doi:10.1016/j.cma.2019.01.030 (additive Schwarz by cut cells).
*/
#include <petscpc.h>
#include <petscblaslapack.h>
#include "space/space.h"
#include "bc/bc.h"
#include "assembly/sparsity.h"
#include "levels/patches.h"

/* Stiffest over softest tangent of a cell, from which on Jacobi's method does not serve (docs/solver.md). */
#define CONTRAST 1e3

static const char composed[] = "mpm_cells";

/* Cells with their unknowns on this rank, of nodes: `block` unknowns each, those that are not solved for included. */
typedef struct {
  const MpmLevelsStep *step;
  PetscInt             count, block;
  PetscInt            *begin, *node;    /* local nodes of each cell */
  size_t              *place;           /* of each cell's matrix */
  PetscReal           *matrix;          /* its entries, later its factors */
  PetscBLASInt        *pivot;           /* `block` a node */
  PetscInt            *of_begin, *of;   /* cells of each local node */
  PetscInt            *at;              /* place of the local nodes in the cell at hand, or -1 */
  PetscInt            *box, *identity;  /* nodes of the box at hand, and 0, 1, 2, ... */
  PetscInt             box_count, most; /* its nodes, and those of the largest */
  PetscReal           *share;           /* identity blocks */
} Patches;

static PetscErrorCode Destroy(void *ctx)
{
  Patches *patches = (Patches *)ctx;

  PetscFunctionBeginUser;
  PetscCall(PetscFree(patches->begin));
  PetscCall(PetscFree(patches->node));
  PetscCall(PetscFree(patches->place));
  PetscCall(PetscFree(patches->matrix));
  PetscCall(PetscFree(patches->pivot));
  PetscCall(PetscFree2(patches->of_begin, patches->of));
  PetscCall(PetscFree(patches->at));
  PetscCall(PetscFree2(patches->identity, patches->share));
  PetscCall(PetscFree(patches));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscBool IsPlain(const MpmLevelsStep *step, const PetscReal joined[], PetscInt i)
{
  return (PetscBool)(i < step->space->owned && joined[i] == 0. && !MpmConstraintsFrame(step->constraints, i));
}

/* The cells, and their nodes. */
static PetscErrorCode FindCells(Patches *patches, const MpmFactored *factored)
{
  const MpmSpace     *space     = patches->step->space;
  const MpmExtension *extension = &space->extension;
  PetscReal          *least, *most;
  PetscReal          *joined; /* not zero: nodes with other than their own points' entries on this rank */
  PetscInt            nodes = 0;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc2(space->group_count, &least, space->group_count, &most));
  PetscCall(PetscCalloc1(space->local, &joined));
  for (PetscInt f = 0; f < extension->count; f++) {
    joined[extension->follower[f]] = 1.;
    for (PetscInt k = extension->offset[f]; k < extension->offset[f + 1]; k++) joined[extension->master[k]] = 1.;
  }
  for (PetscInt i = space->owned; i < space->local; i++) joined[i] = 1.;
  PetscCall(MpmSpaceAddToOwners(space, 1, joined));
  MpmFactoredRange(factored, least, most);
  for (PetscInt pass = 0; pass < 2; pass++) {
    if (pass) {
      PetscCall(PetscMalloc1((patches->count + 1), &patches->begin));
      PetscCall(PetscMalloc1(nodes, &patches->node));
      patches->count = nodes = 0;
    }
    for (PetscInt g = 0; g < space->group_count; g++) {
      const MpmGroup *group = &space->groups[g];

      if (!(most[g] > CONTRAST * least[g])) continue;
      if (pass) patches->begin[patches->count] = nodes;
      patches->count++;
      patches->most = PetscMax(patches->most, group->node_count);
      for (PetscInt k = 0; k < group->node_count; k++) {
        const PetscInt i = space->group_nodes[group->node_offset + k];

        if (i < 0 || !IsPlain(patches->step, joined, i)) continue;
        if (pass) patches->node[nodes] = i;
        nodes++;
      }
    }
  }
  patches->begin[patches->count] = nodes;
  PetscCall(PetscFree2(least, most));
  PetscCall(PetscFree(joined));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Room for matrices, and the cells of each node. */
static PetscErrorCode MakeRoom(Patches *patches)
{
  const PetscInt local = patches->step->space->local, bs = patches->block, end = patches->begin[patches->count];
  PetscInt       most = 0;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1((patches->count + 1), &patches->place));
  PetscCall(PetscCalloc2((local + 2), &patches->of_begin, end, &patches->of));
  PetscCall(PetscMalloc1((end * bs), &patches->pivot));
  PetscCall(PetscMalloc1(local, &patches->at));
  for (PetscInt i = 0; i < local; i++) patches->at[i] = -1;
  patches->place[0] = 0;
  for (PetscInt p = 0; p < patches->count; p++)
    patches->place[p + 1] = patches->place[p] + (size_t)PetscSqr((patches->begin[p + 1] - patches->begin[p]) * bs);
  PetscCall(PetscCalloc1(patches->place[patches->count], &patches->matrix));
  for (PetscInt k = 0; k < end; k++) patches->of_begin[patches->node[k] + 2]++;
  for (PetscInt i = 0; i < local; i++) patches->of_begin[i + 2] += patches->of_begin[i + 1];
  for (PetscInt p = 0; p < patches->count; p++)
    for (PetscInt k = patches->begin[p]; k < patches->begin[p + 1]; k++)
      patches->of[patches->of_begin[patches->node[k] + 1]++] = p;
  for (PetscInt g = 0; g < patches->step->space->group_count; g++)
    most = PetscMax(most, patches->step->space->groups[g].node_count);
  PetscCall(PetscMalloc2((most + 1), &patches->identity, (most * bs * bs), &patches->share));
  for (PetscInt k = 0; k <= most; k++) patches->identity[k] = k;
  for (PetscInt k = 0; k < most * bs * bs; k++) patches->share[k] = k % (bs * bs) % (bs + 1) ? 0. : 1.;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- sums of blocks ---- */

/* Adds a block of n nodes to cell p; `stride`: of node and component of the rows, then of the columns. */
static void AddToCell(Patches *patches, PetscInt p, PetscInt n, const PetscInt nodes[], const PetscReal block[],
                      const PetscInt stride[4])
{
  const PetscInt begin = patches->begin[p], bs = patches->block, size = (patches->begin[p + 1] - begin) * bs;
  PetscReal     *to = &patches->matrix[patches->place[p]];

  for (PetscInt k = begin; k < patches->begin[p + 1]; k++) patches->at[patches->node[k]] = k - begin;
  for (PetscInt i = 0; i < n; i++) {
    const PetscInt row = nodes[i] < 0 ? -1 : patches->at[nodes[i]];

    for (PetscInt j = 0; row >= 0 && j < n; j++) {
      const PetscInt column = nodes[j] < 0 ? -1 : patches->at[nodes[j]];

      for (PetscInt e = 0; column >= 0 && e < bs * bs; e++)
        to[(column * bs + e % bs) * size + row * bs + e / bs] +=
          block[i * stride[0] + e / bs * stride[1] + j * stride[2] + e % bs * stride[3]];
    }
  }
  for (PetscInt k = begin; k < patches->begin[p + 1]; k++) patches->at[patches->node[k]] = -1;
}

/* Adds a block to all cells that have one of its nodes. */
static void AddToCells(Patches *patches, PetscInt n, const PetscInt nodes[], const PetscReal block[],
                       const PetscInt stride[4])
{
  for (PetscInt i = 0; i < n; i++) {
    for (PetscInt k = nodes[i] < 0 ? 0 : patches->of_begin[nodes[i]];
         nodes[i] >= 0 && k < patches->of_begin[nodes[i] + 1]; k++) {
      const PetscInt p     = patches->of[k];
      PetscBool      first = PETSC_TRUE;

      for (PetscInt j = 0; j < i && first; j++)
        for (PetscInt l = nodes[j] < 0 ? 0 : patches->of_begin[nodes[j]];
             nodes[j] >= 0 && l < patches->of_begin[nodes[j] + 1]; l++)
          if (patches->of[l] == p) first = PETSC_FALSE;
      if (first) AddToCell(patches, p, n, nodes, block, stride);
    }
  }
}

static void Take(void *ctx, PetscInt n, const PetscInt nodes[], const PetscReal element[])
{
  Patches       *patches = (Patches *)ctx;
  const PetscInt bs = patches->block, stride[4] = {bs * bs * n, bs * n, 1, n};

  AddToCells(patches, n, nodes, element, stride);
}

/* The box itself in place of coarse nodes, where one of its nodes is in a cell. */
static PetscErrorCode DescribeBox(void *ctx, PetscInt n, const PetscInt nodes[], MpmCoarseBox *box)
{
  Patches *patches = (Patches *)ctx;

  PetscFunctionBeginUser;
  *box = (MpmCoarseBox){.begin = patches->identity, .place = patches->identity, .share = patches->share};
  for (PetscInt i = 0; i < n && !box->count; i++)
    if (patches->of_begin[nodes[i] + 1] > patches->of_begin[nodes[i]]) box->count = n;
  patches->box       = (PetscInt *)nodes;
  patches->box_count = n;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode AddBox(void *ctx, const PetscReal block[])
{
  Patches       *patches = (Patches *)ctx;
  const PetscInt bs = patches->block, n = patches->box_count, stride[4] = {bs * bs * n, bs * n, bs, 1};

  PetscFunctionBeginUser;
  AddToCells(patches, n, patches->box, block, stride);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Factors of the cells' matrices, with the diagonal alone at unknowns that are not solved for. */
static PetscErrorCode Factorise(Patches *patches)
{
  const MpmConstraints *constraints = patches->step->constraints;
  const PetscInt        bs          = patches->block;

  PetscFunctionBeginUser;
  for (PetscInt p = 0; p < patches->count; p++) {
    PetscReal   *matrix = &patches->matrix[patches->place[p]];
    PetscBLASInt size, info;

    PetscCall(PetscBLASIntCast((patches->begin[p + 1] - patches->begin[p]) * bs, &size));
    for (PetscInt k = 0; k < size; k++) {
      const PetscInt unknown = patches->node[patches->begin[p] + k / bs] * bs + k % bs;

      for (PetscInt l = 0; constraints->condition[unknown] != MPM_FREE && l < size; l++)
        matrix[k * size + l] = matrix[l * size + k] = l == k ? constraints->diagonal : 0.;
    }
    if (!size) continue;
    PetscCallBLAS("LAPACKgetrf",
                  LAPACKgetrf_(&size, &size, matrix, &size, &patches->pivot[patches->begin[p] * bs], &info));
    PetscCheck(info >= 0, PETSC_COMM_SELF, PETSC_ERR_LIB, "LAPACK getrf: argument %d", -info);
    if (info > 0) { /* a block without an inverse: identity */
      for (PetscInt k = 0; k < size * size; k++) matrix[k] = k % (size + 1) ? 0. : constraints->diagonal;
      for (PetscInt k = 0; k < size; k++) patches->pivot[patches->begin[p] * bs + k] = (PetscBLASInt)k + 1;
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPatchesCompose(const MpmLevelsStep *step, const MpmFactored *factored, Mat A)
{
  const MpmFactored *points;
  PetscContainer     container;
  Patches           *patches;

  PetscFunctionBeginUser;
  PetscCall(PetscNew(&patches));
  patches->step  = step;
  patches->block = step->constraints->block;
  PetscCall(FindCells(patches, factored));
  PetscCall(MakeRoom(patches));
  const MpmElementAction action = {.take = Take, .ctx = patches};
  const MpmCoarse        boxes  = {.ctx = patches, .box = DescribeBox, .add = AddBox};

  PetscCall(step->tangent(step->ctx, &action, &points));
  PetscCall(MpmFactoredProject(factored, &boxes));
  PetscCall(Factorise(patches));
  PetscCall(PetscContainerCreate(PETSC_COMM_SELF, &container));
  PetscCall(PetscContainerSetPointer(container, patches));
  PetscCall(PetscContainerSetUserDestroy(container, Destroy));
  PetscCall(PetscObjectCompose((PetscObject)A, composed, (PetscObject)container));
  PetscCall(PetscContainerDestroy(&container));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the preconditioner ---- */

typedef struct {
  Vec        inverse; /* of the diagonal; zero at unknowns of cells */
  Patches   *patches; /* of the matrix, or NULL */
  PetscReal *r;       /* of a cell */
} Cells;

static PetscErrorCode SetUp(PC pc)
{
  Cells         *cells;
  Mat            A;
  PetscContainer container;
  PetscScalar   *inverse;
  PetscInt       n;

  PetscFunctionBeginUser;
  PetscCall(PCShellGetContext(pc, &cells));
  PetscCall(PCGetOperators(pc, NULL, &A));
  if (!cells->inverse) PetscCall(MatCreateVecs(A, NULL, &cells->inverse));
  PetscCall(MatGetDiagonal(A, cells->inverse));
  PetscCall(VecGetLocalSize(cells->inverse, &n));
  PetscCall(VecGetArray(cells->inverse, &inverse));
  for (PetscInt k = 0; k < n; k++) inverse[k] = inverse[k] == 0. ? 1. : 1. / inverse[k];
  PetscCall(PetscObjectQuery((PetscObject)A, composed, (PetscObject *)&container));
  cells->patches = NULL;
  if (container) PetscCall(PetscContainerGetPointer(container, (void **)&cells->patches));
  PetscCall(PetscFree(cells->r));
  if (cells->patches) {
    const PetscInt bs = cells->patches->block;

    PetscCall(PetscMalloc1((cells->patches->most * bs), &cells->r));
    for (PetscInt k = 0; k < cells->patches->begin[cells->patches->count] * bs; k++)
      inverse[cells->patches->node[k / bs] * bs + k % bs] = 0.;
  }
  PetscCall(VecRestoreArray(cells->inverse, &inverse));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ApplyCells(PC pc, PetscBool transposed, Vec r, Vec z)
{
  const PetscBLASInt one = 1;
  const PetscScalar *from;
  PetscScalar       *to;
  Cells             *cells;

  PetscFunctionBeginUser;
  PetscCall(PCShellGetContext(pc, &cells));
  PetscCall(VecPointwiseMult(z, cells->inverse, r));
  if (!cells->patches || !cells->patches->count) PetscFunctionReturn(PETSC_SUCCESS);
  const Patches *patches = cells->patches;
  const PetscInt bs      = patches->block;

  PetscCall(VecGetArrayRead(r, &from));
  PetscCall(VecGetArray(z, &to));
  for (PetscInt p = 0; p < patches->count; p++) {
    const PetscInt  *node   = &patches->node[patches->begin[p]];
    const PetscReal *matrix = &patches->matrix[patches->place[p]];
    PetscBLASInt     size, info;

    PetscCall(PetscBLASIntCast((patches->begin[p + 1] - patches->begin[p]) * bs, &size));
    if (!size) continue;
    for (PetscInt k = 0; k < size; k++) cells->r[k] = from[node[k / bs] * bs + k % bs];
    PetscCallBLAS("LAPACKgetrs", LAPACKgetrs_(transposed ? "T" : "N", &size, &one, matrix, &size,
                                              &patches->pivot[patches->begin[p] * bs], cells->r, &size, &info));
    for (PetscInt k = 0; k < size; k++) to[node[k / bs] * bs + k % bs] += cells->r[k];
  }
  PetscCall(VecRestoreArray(z, &to));
  PetscCall(VecRestoreArrayRead(r, &from));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Apply(PC pc, Vec r, Vec z)
{
  return ApplyCells(pc, PETSC_FALSE, r, z);
}

static PetscErrorCode ApplyTranspose(PC pc, Vec r, Vec z)
{
  return ApplyCells(pc, PETSC_TRUE, r, z);
}

static PetscErrorCode DestroyCells(PC pc)
{
  Cells *cells;

  PetscFunctionBeginUser;
  PetscCall(PCShellGetContext(pc, &cells));
  PetscCall(VecDestroy(&cells->inverse));
  PetscCall(PetscFree(cells->r));
  PetscCall(PetscFree(cells));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Create(PC pc)
{
  Cells *cells;

  PetscFunctionBeginUser;
  PetscCall(PetscNew(&cells));
  PetscCall(PCSetType(pc, PCSHELL));
  PetscCall(PCShellSetName(pc, "Jacobi, and inverses of cells"));
  PetscCall(PCShellSetContext(pc, cells));
  PetscCall(PCShellSetSetUp(pc, SetUp));
  PetscCall(PCShellSetApply(pc, Apply));
  PetscCall(PCShellSetApplyTranspose(pc, ApplyTranspose));
  PetscCall(PCShellSetDestroy(pc, DestroyCells));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPatchesRegister(void)
{
  PetscFunctionBeginUser;
  PetscCall(PCRegister("cells", Create));
  PetscFunctionReturn(PETSC_SUCCESS);
}

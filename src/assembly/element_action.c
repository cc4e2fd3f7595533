/*
  Element blocks without a matrix: their product with a vector, or with their transpose, and their diagonal.

  A term provides its tangent as element blocks. Without a matrix their action on a vector at the local nodes is used,

    y_ic += K_icjd x_jd ,   y_jd += K_icjd x_ic (transposed) ,   blocks_icd += K_icid ,

  prescribed unknowns included.
*/
#include "point/layout.h"
#include "space/sum.h"
#include "assembly/sparsity_impl.h"
#include "assembly/terms.h"

void MpmElementActNodes(const MpmElementAction *action, PetscInt bs, PetscInt n, const PetscInt nodes[],
                        const PetscReal element[])
{
  if (action->take) {
    action->take(action->ctx, n, nodes, element);
    return;
  }
  for (PetscInt k = 0; k < n * bs * bs; k++) {
    const PetscInt i = k / (bs * bs), c = k / bs % bs, d = k % bs;

    for (PetscInt j = 0; nodes[i] >= 0 && j < n; j++) {
      const PetscReal value = element[k * n + j];

      if (nodes[j] < 0 || value == 0.) continue;
      if (action->blocks && nodes[i] == nodes[j]) action->blocks[(nodes[i] * bs + c) * bs + d] += value;
      if (!action->x) continue;
      if (action->transposed) action->y[nodes[j] * bs + d] += value * action->x[nodes[i] * bs + c];
      else action->y[nodes[i] * bs + c] += value * action->x[nodes[j] * bs + d];
    }
  }
}

/* left right^T */
static void ActProduct(const MpmElementAction *action, PetscInt bs, PetscInt n, const PetscInt nodes[],
                       const PetscReal left[], const PetscReal right[])
{
  const PetscReal *from = action->transposed ? left : right, *to = action->transposed ? right : left;
  PetscReal        dot = 0.;

  for (PetscInt k = 0; action->x && k < n * bs; k++)
    if (nodes[k / bs] >= 0) dot += from[k] * action->x[nodes[k / bs] * bs + k % bs];
  for (PetscInt k = 0; action->x && k < n * bs; k++)
    if (nodes[k / bs] >= 0) action->y[nodes[k / bs] * bs + k % bs] += to[k] * dot;
  for (PetscInt k = 0; action->blocks && k < n * bs; k++)
    for (PetscInt d = 0; nodes[k / bs] >= 0 && d < bs; d++)
      action->blocks[(nodes[k / bs] * bs + k % bs) * bs + d] += left[k] * right[k / bs * bs + d];
}

/* a b^T + b c^T as a block. */
static void TakePair(const MpmElementAction *action, PetscInt bs, PetscInt n, const PetscInt nodes[],
                     const PetscReal *const pair[3])
{
  PetscReal *element;

  if (PetscMalloc1((n * bs * n * bs), &element)) return;
  for (PetscInt k = 0; k < n * bs * n * bs; k++) {
    const PetscInt row = k / (bs * n), column = k % n * bs + k / n % bs;

    element[k] = pair[0][row] * pair[1][column] + pair[1][row] * pair[2][column];
  }
  action->take(action->ctx, n, nodes, element);
  (void)PetscFree(element);
}

void MpmElementActPair(const MpmElementAction *action, PetscInt bs, PetscInt n, const PetscInt nodes[],
                       const PetscReal a[], const PetscReal b[], const PetscReal c[])
{
  if (action->take) {
    TakePair(action, bs, n, nodes, (const PetscReal *const[3]){a, b, c});
    return;
  }
  ActProduct(action, bs, n, nodes, a, b);
  ActProduct(action, bs, n, nodes, b, c);
}

/* Action of the blocks of term k. */
static PetscErrorCode Act(const MpmTerms *terms, PetscInt k, const MpmSum *sum, const PetscReal u[],
                          const MpmElementAction *action, PetscInt *failed)
{
  MpmPattern pattern = {.block = sum->block, .dim = sum->layout->dim, .action = action};

  PetscFunctionBeginUser;
  if (!MpmTermsIdle(terms, k)) PetscCall(terms->term[k]->tangent(terms->ctx[k], sum, u, &pattern, NULL, failed));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTermsApplyOne(const MpmTerms *terms, PetscInt k, const MpmSum *sum, const PetscReal u[],
                                const PetscReal du[], PetscReal y[])
{
  const MpmElementAction action = {.x = du, .y = y};
  PetscInt               failed = 0;

  PetscFunctionBeginUser;
  if (!terms->term[k]->apply) PetscCall(Act(terms, k, sum, u, &action, &failed));
  else if (!MpmTermsIdle(terms, k)) PetscCall(terms->term[k]->apply(terms->ctx[k], sum, u, du, y));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTermsTransposeOne(const MpmTerms *terms, PetscInt k, const MpmSum *sum, const PetscReal u[],
                                    const PetscReal v[], PetscReal y[])
{
  const MpmElementAction action = {.x = v, .y = y, .transposed = PETSC_TRUE};
  PetscInt               failed = 0;

  PetscFunctionBeginUser;
  PetscCall(Act(terms, k, sum, u, &action, &failed));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTermsDiagonalOne(const MpmTerms *terms, PetscInt k, const MpmSum *sum, const PetscReal u[],
                                   PetscReal blocks[], PetscInt *failed)
{
  const MpmElementAction action = {.blocks = blocks};

  PetscFunctionBeginUser;
  if (!terms->term[k]->diagonal) PetscCall(Act(terms, k, sum, u, &action, failed));
  else if (!MpmTermsIdle(terms, k)) PetscCall(terms->term[k]->diagonal(terms->ctx[k], sum, u, blocks, failed));
  PetscFunctionReturn(PETSC_SUCCESS);
}

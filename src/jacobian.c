/*
  The Jacobian, point by point: the kernel on duals that are seeded with the point's inputs gives the point's D, and the element block of
  a group is the sum of B^T D B over its points.
*/
#include "mpmimpl.h"

/* row[j] += sum_l t[l] phi_l[j] over `count` consecutive basis functions; the count is known where it is called from */
static inline void AddRow(PetscInt n, PetscInt count, const PetscReal t[], PetscReal *const phi[], PetscReal row[])
{
  for (PetscInt j = 0; j < n; j++) {
    PetscReal s = 0.;

    for (PetscInt l = 0; l < count; l++) s += t[l] * phi[l][j];
    row[j] += s;
  }
}

/* element[i][c][d][j] += sum_{k in c, l in d} phi_k(i) D_kl phi_l(j) */
static void AddElement(const MpmLayout *layout, PetscInt n, const MpmBasis *basis, const PetscReal D[], PetscReal element[])
{
  const PetscInt bs = layout->block, N = layout->inputs;

  for (PetscInt i = 0; i < n; i++) {
    for (PetscInt c = 0; c < bs; c++) {
      const PetscInt first = layout->component_first[c], last = layout->component_first[c + 1];
      PetscReal      t[MPM_MAX_INPUTS];

      for (PetscInt l = 0; l < N; l++) t[l] = 0.;
      for (PetscInt k = first; k < last; k++) {
        const PetscReal phi = basis->basis[layout->basis_of[k]][i];

        for (PetscInt l = 0; l < N; l++) t[l] += phi * D[k * N + l];
      }
      for (PetscInt d = 0; d < bs; d++) {
        const PetscInt    l0 = layout->component_first[d], count = layout->component_first[d + 1] - l0;
        PetscReal *const *phi = &basis->basis[layout->basis_first[d]];
        PetscReal        *row = &element[((i * bs + c) * bs + d) * n];

        switch (count) {
        case 1: AddRow(n, 1, &t[l0], phi, row); break;
        case 2: AddRow(n, 2, &t[l0], phi, row); break;
        case 3: AddRow(n, 3, &t[l0], phi, row); break;
        default: AddRow(n, count, &t[l0], phi, row); break;
        }
      }
    }
  }
}

PetscErrorCode MpmJacobianLocal(const MpmSum *sum, const PetscReal u[], MpmPattern *pattern, PetscInt *failed)
{
  const MpmSpace  *space  = sum->space;
  const MpmLayout *layout = sum->layout;
  const PetscBool  values = MpmLayoutUsesValues(layout);
  const PetscInt   most = PetscPowInt(space->width, space->dim), bs = layout->block;
  PetscReal       *nodal, *element;
  MpmBasis         basis;

  PetscFunctionBeginUser;
  *failed = 0;
  PetscCall(PetscArrayzero(pattern->value, pattern->row[pattern->local] * bs * bs));
  PetscCall(PetscMalloc2((most * (bs + MPM_MAX_DIM + 1)), &nodal, (most * most * bs * bs), &element));
  for (PetscInt b = 0; b <= MPM_MAX_DIM; b++) basis.basis[b] = nodal + most * (bs + b);
  for (PetscInt g = 0; g < space->group_count; g++) {
    const MpmGroup *group = &space->groups[g];
    const PetscInt  n     = group->node_count;

    MpmSumGather(sum, group, u, nodal);
    PetscCall(PetscArrayzero(element, n * n * bs * bs));
    for (PetscInt s = group->point_begin; s < group->point_end; s++) {
      MpmKernelPoint point;
      PetscReal      input[MPM_MAX_INPUTS], flux[MPM_MAX_INPUTS], tangent[MPM_MAX_INPUTS * MPM_MAX_INPUTS];

      MpmSpaceEvaluate(space, space->order[s], values, &basis);
      MpmSumInputs(sum, n, nodal, &basis, input);
      MpmSumPoint(sum, space->order[s], &point);
      if (layout->kernel->tangent(&point, input, flux, tangent)) {
        (*failed)++;
        continue;
      }
      AddElement(layout, n, &basis, tangent, element);
    }
    MpmPatternAddBlock(pattern, space, group, sum->constraints, element);
  }
  PetscCall(PetscFree2(nodal, element));
  PetscFunctionReturn(PETSC_SUCCESS);
}

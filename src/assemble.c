/*
  Sums over points: the residual, and the commit of a converged step.
*/
#include "mpmimpl.h"

/* Room for one group's work: nodal values and forces by component, and basis functions. */
typedef struct {
  PetscReal *u, *force, *storage;
  MpmBasis   basis;
} Workspace;

static PetscErrorCode WorkspaceCreate(const MpmSum *sum, Workspace *work)
{
  const PetscInt n = PetscPowInt(sum->space->width, sum->space->dim);

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1((n * (2 * sum->layout->block + MPM_MAX_DIM + 1)), &work->storage));
  work->u     = work->storage;
  work->force = work->u + n * sum->layout->block;
  for (PetscInt b = 0; b <= MPM_MAX_DIM; b++) work->basis.basis[b] = work->force + n * (sum->layout->block + b);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscBool MpmLayoutUsesValues(const MpmLayout *layout)
{
  for (PetscInt k = 0; k < layout->inputs; k++)
    if (!layout->basis_of[k]) return PETSC_TRUE;
  return PETSC_FALSE;
}

void MpmSumGather(const MpmSum *sum, const MpmGroup *group, const PetscReal u[], PetscReal values[])
{
  const PetscInt *nodes = &sum->space->group_nodes[group->node_offset], bs = sum->layout->block, n = group->node_count;

  for (PetscInt c = 0; c < bs; c++)
    for (PetscInt i = 0; i < n; i++) values[c * n + i] = u[nodes[i] * bs + c];
}

void MpmSumInputs(const MpmSum *sum, PetscInt n, const PetscReal values[], const MpmBasis *basis, PetscReal input[])
{
  const MpmLayout *layout = sum->layout;

  for (PetscInt k = 0; k < layout->inputs; k++) {
    const PetscReal *phi = basis->basis[layout->basis_of[k]], *v = &values[layout->component_of[k] * n];
    PetscReal        s   = 0.;

    for (PetscInt i = 0; i < n; i++) s += phi[i] * v[i];
    input[k] = s;
  }
}

void MpmSumPoint(const MpmSum *sum, PetscInt p, MpmKernelPoint *point)
{
  const MpmPoints   *points   = sum->points;
  const MpmMaterial *material = &sum->materials[points->material[p]];
  const PetscInt     dim      = sum->space->dim;

  point->parameter         = material->parameter;
  point->physics_parameter = sum->physics_parameter;
  point->state_n           = points->state ? &points->state[p * sum->state_size] : NULL;
  point->F_n               = &points->F[p * dim * dim];
  point->value_n           = points->value ? &points->value[p * sum->layout->rates] : NULL;
  point->volume0           = points->volume0[p];
  point->dt                = sum->dt;
  point->traits            = material->info.traits;
  point->law               = material->law;
  point->state             = NULL;
  point->F                 = NULL;
  point->stress            = NULL;
}

/* Adds phi_k(i) flux_k to the group's forces. */
static void AddFlux(const MpmLayout *layout, PetscInt n, const MpmBasis *basis, const PetscReal flux[], PetscReal force[])
{
  for (PetscInt k = 0; k < layout->inputs; k++) {
    const PetscReal *phi = basis->basis[layout->basis_of[k]], value = flux[k];
    PetscReal       *f = &force[layout->component_of[k] * n];

    for (PetscInt i = 0; i < n; i++) f[i] += phi[i] * value;
  }
}

static void Scatter(const MpmSum *sum, const MpmGroup *group, const PetscReal force[], PetscReal residual[])
{
  const PetscInt *nodes = &sum->space->group_nodes[group->node_offset], bs = sum->layout->block, n = group->node_count;

  for (PetscInt i = 0; i < n; i++)
    for (PetscInt c = 0; c < bs; c++) residual[nodes[i] * bs + c] += force[c * n + i];
}

PetscErrorCode MpmResidualLocal(const MpmSum *sum, const PetscReal u[], PetscReal residual[], PetscInt *failed)
{
  const MpmSpace *space  = sum->space;
  const PetscBool values = MpmLayoutUsesValues(sum->layout);
  Workspace       work;

  PetscFunctionBeginUser;
  *failed = 0;
  PetscCall(WorkspaceCreate(sum, &work));
  for (PetscInt g = 0; g < space->group_count; g++) {
    const MpmGroup *group = &space->groups[g];
    const PetscInt  n     = group->node_count;

    MpmSumGather(sum, group, u, work.u);
    PetscCall(PetscArrayzero(work.force, n * sum->layout->block));
    for (PetscInt s = group->point_begin; s < group->point_end; s++) {
      MpmKernelPoint point;
      PetscReal      input[MPM_MAX_INPUTS], flux[MPM_MAX_INPUTS];

      MpmSpaceEvaluate(space, space->order[s], values, &work.basis);
      MpmSumInputs(sum, n, work.u, &work.basis, input);
      MpmSumPoint(sum, space->order[s], &point);
      if (sum->layout->kernel->residual(&point, input, flux)) {
        (*failed)++;
        continue;
      }
      AddFlux(sum->layout, n, &work.basis, flux, work.force);
    }
    Scatter(sum, group, work.force, residual);
  }
  PetscCall(PetscFree(work.storage));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Moves a point by the increment at its nodes and takes over its new values of fields with a rate. */
static void MovePoint(const MpmSum *sum, PetscInt p, PetscInt n, const PetscReal values[], const MpmBasis *basis)
{
  const MpmLayout *layout = sum->layout;
  const PetscInt   dim    = sum->space->dim;

  for (PetscInt a = 0; a < dim; a++) {
    PetscReal du = 0.;

    for (PetscInt i = 0; i < n; i++) du += basis->basis[0][i] * values[a * n + i];
    sum->points->x[p * dim + a] += du;
  }
  for (PetscInt r = 0; r < layout->rates; r++) {
    PetscReal value = 0.;

    for (PetscInt i = 0; i < n; i++) value += basis->basis[0][i] * values[layout->rate_component[r] * n + i];
    sum->points->value[p * layout->rates + r] = value;
  }
}

PetscErrorCode MpmCommitLocal(const MpmSum *sum, const PetscReal u[], PetscReal residual[], PetscInt *failed)
{
  const MpmSpace *space = sum->space;
  const PetscInt  dim   = space->dim;
  PetscReal       F[MPM_MAX_DIM * MPM_MAX_DIM], *state;
  Workspace       work;

  PetscFunctionBeginUser;
  *failed = 0;
  PetscCall(WorkspaceCreate(sum, &work));
  PetscCall(PetscMalloc1((sum->state_size + 1), &state));
  for (PetscInt g = 0; g < space->group_count; g++) {
    const MpmGroup *group = &space->groups[g];
    const PetscInt  n     = group->node_count;

    MpmSumGather(sum, group, u, work.u);
    PetscCall(PetscArrayzero(work.force, n * sum->layout->block));
    for (PetscInt s = group->point_begin; s < group->point_end; s++) {
      const PetscInt p = space->order[s], size = sum->materials[sum->points->material[p]].state_size;
      MpmKernelPoint point;
      PetscReal      input[MPM_MAX_INPUTS], flux[MPM_MAX_INPUTS];

      MpmSpaceEvaluate(space, p, PETSC_TRUE, &work.basis);
      MpmSumInputs(sum, n, work.u, &work.basis, input);
      MpmSumPoint(sum, p, &point);
      /* the kernel reads state n while it writes n+1 */
      if (size) point.state = state;
      point.F      = F;
      point.stress = &sum->points->stress[p * (dim == 2 ? 4 : 6)];
      if (sum->layout->kernel->residual(&point, input, flux)) {
        (*failed)++;
        continue;
      }
      AddFlux(sum->layout, n, &work.basis, flux, work.force);
      MovePoint(sum, p, n, work.u, &work.basis);
      PetscCall(PetscArraycpy(&sum->points->F[p * dim * dim], F, dim * dim));
      if (size) PetscCall(PetscArraycpy(&sum->points->state[p * sum->state_size], state, size));
    }
    Scatter(sum, group, work.force, residual);
  }
  PetscCall(PetscFree(state));
  PetscCall(PetscFree(work.storage));
  PetscFunctionReturn(PETSC_SUCCESS);
}

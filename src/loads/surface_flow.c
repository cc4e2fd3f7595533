/*
  Flow of water through surfaces of bodies, where its pressure is prescribed weakly, by Nitsche's method.

  With Q the kernel's flux of grad p at a face's point, which is dt V_n J dF^{-1} q for Darcy's velocity q and the
  volume V_n at the step's start, the outflow through the face of area a is, with e = p - p_wanted at the face and beta
  a penalty,

    O = Q . a/V_n + beta |a| e .

  The water's equation, which is that of the mass times -1, gets at the nodes

    -phi_i O - e (S a/V_n) . grad phi_i ,   S = d Q/d grad p at the step's start .

  The first term is consistent: without the penalty's share a pressure that is linear, hydrostatic say, has the flow of
  Darcy's law. The second one makes the terms symmetric where the kernel is. The second term does not change sums over
  the nodes, so the flow through all surfaces is the material's loss. Source: Nitsche (1971), doi:10.1007/BF02995904.

  The bulk has the term grad p . S grad p at the very point, so with

    beta |a| = 2 dim a . (-S) a/V_n^2

  the sum is definite however little of a cell is filled, and for all lengths of a step. The pressure beside the face is
  then that of water which flows in over the distance from the point to the face, over 2 dim: a fraction of a point's
  spacing. A larger penalty would fix the pressure at each face of a staircase, at the outer and the inner ones, and
  with it the gradient between them: the body would drain as a smaller one.
*/
#include "grid/grid.h"
#include "space/kernel_point.h"
#include "space/point_loop.h"
#include "space/rules.h"
#include "assembly/sparsity.h"
#include "assembly/terms.h"
#include "loads/body_surface.h"
#include "loads/load.h"
#include "loads/water_table.h"

#define MOBILITY 2. /* of the least penalty, an axis */

/* A face's point, and the flow through the face with its derivatives: by the kernel's inputs, and by the pressure at
   the face. */
typedef struct {
  MpmWorkspace     work;
  const MpmGroup  *group;
  const PetscReal *weight; /* at the face */
  PetscReal        input[MPM_MAX_INPUTS], excess, outflow, by_input[MPM_MAX_INPUTS];
} Flow;

/* The first of the kernel's inputs that are the pressure's gradient. */
static PetscInt GradientInput(const MpmLayout *layout, PetscInt component)
{
  PetscInt k = layout->input.by_component.first[component];

  while (layout->input.basis[layout->input.by_component.input[k]] != 1) k++;
  return layout->input.by_component.input[k];
}

/* The kernel's inputs at the face's point and the pressure beyond the prescribed one. */
static void Begin(const MpmSurfaceFaces *faces, const MpmSurfaceFace *face, const MpmSum *sum, const PetscReal u[],
                  Flow *flow)
{
  const MpmGroup *group = &sum->space->groups[face->group];
  const MpmKnown  known = KnownGeneral(sum->layout, group);

  flow->group  = group;
  flow->weight = &faces->list.weight[face->weight];
  MpmSumGather(known, sum, group, u, flow->work.values);
  MpmSumBasis(known, sum->space, face->point, PETSC_TRUE, &flow->work.basis);
  MpmSumInputs(known, sum->layout, flow->work.values, &flow->work.basis, flow->input);
  flow->excess = 0.;
  for (PetscInt i = 0; i < known.n; i++)
    flow->excess += flow->weight[i] * flow->work.values[faces->component * known.n + i];
}

/* Flow through a face; PETSC_FALSE where the point has no answer. */
static PetscBool Outflow(const MpmSurfaceFaces *faces, const MpmSurfaceFace *face, const MpmSum *sum, Flow *flow)
{
  const PetscInt first = GradientInput(sum->layout, faces->component);
  MpmKernelPoint point;
  PetscReal      flux[MPM_MAX_INPUTS];

  MpmSumPoint(sum, face->point, &point);
  if (faces->kernel->residual(&point, flow->input, flux)) return PETSC_FALSE;
  flow->outflow = face->penalty * flow->excess;
  for (PetscInt b = 0; b < sum->space->dim; b++) flow->outflow += flux[first + b] * face->per_area[b];
  return PETSC_TRUE;
}

/* Likewise the derivatives by the inputs. */
static PetscBool OutflowTangent(const MpmSurfaceFaces *faces, const MpmSurfaceFace *face, const MpmSum *sum, Flow *flow)
{
  const PetscInt first = GradientInput(sum->layout, faces->component), inputs = sum->layout->input.count;
  MpmKernelPoint point;
  PetscReal      flux[MPM_MAX_INPUTS], tangent[MPM_MAX_INPUTS * MPM_MAX_INPUTS];

  MpmSumPoint(sum, face->point, &point);
  if (faces->kernel->tangent(&point, flow->input, flux, tangent)) return PETSC_FALSE;
  for (PetscInt l = 0; l < inputs; l++) {
    flow->by_input[l] = 0.;
    for (PetscInt b = 0; b < sum->space->dim; b++)
      flow->by_input[l] += face->per_area[b] * tangent[(first + b) * inputs + l];
  }
  return PETSC_TRUE;
}

/* (S a/V_n) . grad phi_i */
static PetscReal Adjoint(const MpmSurfaceFace *face, const MpmSum *sum, const Flow *flow, PetscInt i)
{
  PetscReal value = 0.;

  for (PetscInt b = 0; b < sum->space->dim; b++) value += face->adjoint[b] * MpmBasisAt(&flow->work.basis, 1 + b, i);
  return value;
}

/* y_i -= phi_i outflow + excess (S a/V_n) . grad phi_i */
static void AddFlow(const MpmSurfaceFaces *faces, const MpmSurfaceFace *face, const MpmSum *sum, const Flow *flow,
                    PetscReal y[])
{
  const PetscInt *nodes = &sum->space->group_nodes[flow->group->node_offset];

  for (PetscInt i = 0; i < flow->group->node_count; i++)
    y[nodes[i] * sum->block + faces->component] -=
      flow->weight[i] * flow->outflow + flow->excess * Adjoint(face, sum, flow, i);
}

/* How the outflow changes with the unknown c of the group's node j, and the excess; y's change is as in AddFlow(). */
static PetscReal Change(const MpmSurfaceFaces *faces, const MpmSurfaceFace *face, const MpmSum *sum, const Flow *flow,
                        PetscInt c, PetscInt j, PetscReal *excess)
{
  const MpmLayout *layout = sum->layout;
  PetscReal        value;

  *excess = c == faces->component ? flow->weight[j] : 0.;
  value   = face->penalty * *excess;
  for (PetscInt k = layout->input.by_component.first[c]; k < layout->input.by_component.first[c + 1]; k++) {
    const PetscInt l = layout->input.by_component.input[k];

    value += flow->by_input[l] * MpmBasisAt(&flow->work.basis, layout->input.basis[l], j);
  }
  return value;
}

/* ---- the step's start ---- */

/* The face's adjoint weights and penalty, from the kernel at rest. */
static PetscErrorCode PrepareFace(const MpmSurfaceFaces *faces, const MpmSum *sum, MpmSurfaceFace *face)
{
  const MpmLayout *layout = sum->layout;
  const PetscInt   dim = sum->space->dim, first = GradientInput(layout, faces->component), inputs = layout->input.count;
  MpmKernelPoint   point;
  PetscReal        input[MPM_MAX_INPUTS] = {0.}, flux[MPM_MAX_INPUTS], tangent[MPM_MAX_INPUTS * MPM_MAX_INPUTS];
  const PetscReal  none[MPM_MAX_BLOCK]   = {0.};
  PetscReal        passes                = 0.;

  PetscFunctionBeginUser;
  MpmSumPoint(sum, face->point, &point);
  point.deviation_n = none; /* not known yet */
  for (PetscInt r = 0; r < layout->rate.count; r++)
    if (layout->rate.component[r] == faces->component &&
        first > layout->input.by_component.input[layout->input.by_component.first[faces->component]])
      input[first - 1] = point.value_n[r];
  PetscCheck(!faces->kernel->tangent(&point, input, flux, tangent), PETSC_COMM_SELF, PETSC_ERR_FP,
             "point %" PetscInt_FMT " has no answer at rest", sum->points->id[face->point]);
  for (PetscInt b = 0; b < dim; b++) {
    face->adjoint[b] = 0.;
    for (PetscInt a = 0; a < dim; a++)
      face->adjoint[b] += tangent[(first + b) * inputs + first + a] * face->per_area[a];
    passes -= face->adjoint[b] * face->per_area[b];
  }
  face->penalty = MOBILITY * (PetscReal)dim * passes;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscBool IsHeld(const MpmSurfaceFaces *faces, const MpmSurfaceFace *face)
{
  return (PetscBool)(faces->surfaces->at[face->surface].held && !faces->still);
}

/* The pressure of the open water that presses on a drained face. */
static PetscReal OpenWater(const MpmSurfaceFaces *faces, const MpmSurfaceFace *face, PetscReal time)
{
  const MpmWaterTable *table = faces->table;

  if (!table->there || !faces->surfaces->at[face->surface].drained) return 0.;
  return faces->open * table->weight * PetscMax(MpmWaterTableDepth(table, time, face->place), 0.);
}

/* Pressure of water at rest at a drained face, by its weights; without a level 0. */
static PetscReal AtRest(const MpmSurfaceFaces *faces, const MpmSurfaceFace *face, const MpmSum *sum)
{
  const MpmGroup *group    = &sum->space->groups[face->group];
  PetscReal       pressure = 0.;

  if (!sum->still.pressure || !faces->surfaces->at[face->surface].drained) return 0.;
  for (PetscInt i = 0; i < group->node_count; i++)
    pressure +=
      faces->list.weight[face->weight + i] * sum->still.pressure[sum->space->group_nodes[group->node_offset + i]];
  return faces->open * pressure;
}

static PetscErrorCode Prepare(void *ctx, const MpmTermStep *step)
{
  MpmSurfaceFaces *faces = (MpmSurfaceFaces *)ctx;

  PetscFunctionBeginUser;
  if (!step->sum->step.first) PetscCall(PetscArrayzero(faces->first, faces->surfaces->count));
  for (PetscInt k = 0; k < faces->list.count; k++) {
    faces->list.at[k].water = OpenWater(faces, &faces->list.at[k], step->rules->time.end);
    faces->list.at[k].rest  = AtRest(faces, &faces->list.at[k], step->sum);
    if (IsHeld(faces, &faces->list.at[k])) PetscCall(PrepareFace(faces, step->sum, &faces->list.at[k]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- sums ---- */

static PetscErrorCode Residual(const void *ctx, const MpmSum *sum, const PetscReal u[], PetscReal residual[],
                               PetscInt *failed)
{
  const MpmSurfaceFaces *faces = (const MpmSurfaceFaces *)ctx;
  Flow                   flow;

  PetscFunctionBeginUser;
  if (!faces->list.count) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmWorkspaceCreate(sum, &flow.work));
  for (PetscInt k = 0; k < faces->list.count; k++) {
    const MpmSurfaceFace *face = &faces->list.at[k];

    if (!IsHeld(faces, face)) continue;
    Begin(faces, face, sum, u, &flow);
    flow.excess -= faces->pressure[face->surface] + face->rest;
    if (Outflow(faces, face, sum, &flow)) AddFlow(faces, face, sum, &flow, residual);
    else (*failed)++;
  }
  PetscCall(PetscFree(flow.work.storage));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Apply(const void *ctx, const MpmSum *sum, const PetscReal u[], const PetscReal du[],
                            PetscReal y[])
{
  const MpmSurfaceFaces *faces = (const MpmSurfaceFaces *)ctx;
  Flow                   flow;

  PetscFunctionBeginUser;
  if (!faces->list.count) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmWorkspaceCreate(sum, &flow.work));
  for (PetscInt k = 0; k < faces->list.count; k++) {
    const MpmSurfaceFace *face = &faces->list.at[k];

    if (!IsHeld(faces, face)) continue;
    Begin(faces, face, sum, u, &flow);
    if (!OutflowTangent(faces, face, sum, &flow)) continue;
    Begin(faces, face, sum, du, &flow); /* the change of inputs and excess */
    flow.outflow = face->penalty * flow.excess;
    for (PetscInt l = 0; l < sum->layout->input.count; l++) flow.outflow += flow.by_input[l] * flow.input[l];
    AddFlow(faces, face, sum, &flow, y);
  }
  PetscCall(PetscFree(flow.work.storage));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Diagonal(const void *ctx, const MpmSum *sum, const PetscReal u[], PetscReal blocks[],
                               PetscInt *failed)
{
  const MpmSurfaceFaces *faces = (const MpmSurfaceFaces *)ctx;
  const PetscInt         bs    = sum->block;
  Flow                   flow;

  PetscFunctionBeginUser;
  (void)failed;
  if (!faces->list.count) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmWorkspaceCreate(sum, &flow.work));
  for (PetscInt k = 0; k < faces->list.count; k++) {
    const MpmSurfaceFace *face  = &faces->list.at[k];
    const PetscInt       *nodes = &sum->space->group_nodes[sum->space->groups[face->group].node_offset];

    if (!IsHeld(faces, face)) continue;
    Begin(faces, face, sum, u, &flow);
    if (!OutflowTangent(faces, face, sum, &flow)) continue;
    for (PetscInt i = 0; i < flow.group->node_count; i++) {
      for (PetscInt c = 0; c < bs; c++) {
        PetscReal       excess;
        const PetscReal outflow = Change(faces, face, sum, &flow, c, i, &excess);

        blocks[(nodes[i] * bs + faces->component) * bs + c] -=
          flow.weight[i] * outflow + excess * Adjoint(face, sum, &flow, i);
      }
    }
  }
  PetscCall(PetscFree(flow.work.storage));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The face's block of the tangent, [i][c][c'][j]. */
static void Element(const MpmSurfaceFaces *faces, const MpmSurfaceFace *face, const MpmSum *sum, const Flow *flow,
                    PetscReal element[])
{
  const PetscInt n = flow->group->node_count, bs = sum->block;

  for (PetscInt k = 0; k < n * n * bs * bs; k++) element[k] = 0.;
  for (PetscInt c = 0; c < bs; c++) {
    for (PetscInt j = 0; j < n; j++) {
      PetscReal       excess;
      const PetscReal outflow = Change(faces, face, sum, flow, c, j, &excess);

      for (PetscInt i = 0; i < n; i++)
        element[((i * bs + faces->component) * bs + c) * n + j] =
          -flow->weight[i] * outflow - excess * Adjoint(face, sum, flow, i);
    }
  }
}

static PetscErrorCode Tangent(const void *ctx, const MpmSum *sum, const PetscReal u[], MpmPattern *pattern,
                              PetscReal residual[], PetscInt *failed)
{
  const MpmSurfaceFaces *faces = (const MpmSurfaceFaces *)ctx;
  const PetscInt         most  = PetscPowInt(sum->space->width, sum->space->dim) * sum->block;
  PetscReal             *element;
  Flow                   flow;

  PetscFunctionBeginUser;
  if (!faces->list.count) PetscFunctionReturn(PETSC_SUCCESS);
  if (residual) PetscCall(Residual(ctx, sum, u, residual, failed));
  PetscCall(MpmWorkspaceCreate(sum, &flow.work));
  PetscCall(PetscMalloc1((most * most), &element));
  for (PetscInt k = 0; k < faces->list.count; k++) {
    const MpmSurfaceFace *face = &faces->list.at[k];

    if (!IsHeld(faces, face)) continue;
    Begin(faces, face, sum, u, &flow);
    if (!OutflowTangent(faces, face, sum, &flow)) {
      (*failed)++;
      continue;
    }
    Element(faces, face, sum, &flow, element);
    MpmPatternAddBlock(pattern, sum->space, flow.group, element);
  }
  PetscCall(PetscFree(element));
  PetscCall(PetscFree(flow.work.storage));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode FindOutflow(MpmSurfaceFaces *faces, const MpmSum *sum, const PetscReal u[])
{
  Flow flow;

  PetscFunctionBeginUser;
  PetscCall(PetscArrayzero(faces->outflow, faces->surfaces->count));
  PetscCall(MpmWorkspaceCreate(sum, &flow.work));
  for (PetscInt k = 0; k < faces->list.count; k++) {
    const MpmSurfaceFace *face = &faces->list.at[k];

    if (!IsHeld(faces, face)) continue;
    Begin(faces, face, sum, u, &flow);
    flow.excess -= faces->pressure[face->surface] + face->rest;
    if (Outflow(faces, face, sum, &flow)) faces->outflow[face->surface] += flow.outflow;
  }
  PetscCall(PetscFree(flow.work.storage));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, faces->outflow, (PetscMPIInt)faces->surfaces->count, MPIU_REAL, MPIU_SUM,
                           sum->grid->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode KeepStage(void *ctx, const MpmSum *sum, const PetscReal u[], PetscReal theta)
{
  MpmSurfaceFaces *faces = (MpmSurfaceFaces *)ctx;

  PetscFunctionBeginUser;
  if (!faces->any_held) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(FindOutflow(faces, sum, u));
  for (PetscInt k = 0; k < faces->surfaces->count; k++) faces->first[k] = theta * faces->outflow[k];
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSurfaceFlowCommit(MpmSurfaceFaces *faces, const MpmSum *sum, const PetscReal u[])
{
  PetscFunctionBeginUser;
  if (!faces->any_held) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(FindOutflow(faces, sum, u));
  for (PetscInt k = 0; k < faces->surfaces->count; k++) {
    faces->acting[k].outflow += faces->outflow[k] + faces->first[k];
    faces->first[k] = 0.;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSurfaceFlowMark(const MpmSurfaceFaces *faces, const MpmSpace *space, PetscReal mark[])
{
  PetscFunctionBeginUser;
  PetscCall(PetscArrayzero(mark, space->local));
  for (PetscInt k = 0; k < faces->list.count; k++) {
    const MpmSurfaceFace *face  = &faces->list.at[k];
    const MpmGroup       *group = &space->groups[face->group];

    for (PetscInt i = 0; IsHeld(faces, face) && i < group->node_count; i++)
      if (faces->list.weight[face->weight + i] != 0.) mark[space->group_nodes[group->node_offset + i]] = 1.;
  }
  PetscCall(MpmSpaceAddToOwners(space, 1, mark));
  PetscFunctionReturn(PETSC_SUCCESS);
}

const MpmTerm MpmTermSurfaceFlow = {.name       = "water through surfaces",
                                    .prepare    = Prepare,
                                    .residual   = Residual,
                                    .tangent    = Tangent,
                                    .apply      = Apply,
                                    .diagonal   = Diagonal,
                                    .step.stage = KeepStage};

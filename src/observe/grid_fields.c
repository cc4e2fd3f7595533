/*
  The background grid as it is written: the active nodes with the fields of the last step, and the cells that the
  points' shape functions span.
*/
#include "point/layout.h"
#include "grid/grid.h"
#include "particles/particles.h"
#include "particles/points.h"
#include "space/basis.h"
#include "space/space.h"
#include "space/sum.h"
#include "bc/bc.h"
#include "query/model.h"
#include "step/step.h"
#include "observe/results.h"

#define MAX_CORNERS 8

/* Corners of a cell in the order of XDMF's quadrilateral and hexahedron, in steps along the axes. */
static const PetscInt corner_step[MAX_CORNERS][MPM_MAX_DIM] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                                                               {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};

/* Each cell stands at its lowest node. */
typedef struct {
  PetscInt  corners;
  PetscInt  count, *id; /* cells of this rank, and their numbers */
  PetscInt *nodes;      /* of each cell: numbers of its corners */
} Cells;

/* nodes[i]: the cell above local node i, or -1 first, from the boxes of nodes that this rank's points touch. */
static PetscErrorCode ListSpanned(const MpmSpace *space, PetscInt corners, PetscInt **nodes)
{
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1((space->local * corners), nodes));
  for (PetscInt k = 0; k < space->local * corners; k++) (*nodes)[k] = -1;
  for (PetscInt g = 0; g < space->group_count; g++) {
    const MpmGroup *group   = &space->groups[g];
    const PetscInt *touched = &space->group_nodes[group->node_offset], *n = group->count;
    const PetscInt  layers = space->dim > 2 ? n[2] - 1 : 1;

    if (group->point_begin == group->point_end) continue;
    for (PetscInt k = 0; k < layers; k++) {
      for (PetscInt j = 0; j < n[1] - 1; j++) {
        for (PetscInt i = 0; i < n[0] - 1; i++) {
          PetscInt *cell = &(*nodes)[touched[(k * n[1] + j) * n[0] + i] * corners];

          for (PetscInt c = 0; c < corners; c++) {
            const PetscInt *step = corner_step[c];

            cell[c] = space->number.global[touched[((k + step[2]) * n[1] + j + step[1]) * n[0] + i + step[0]]];
          }
        }
      }
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Cells whose lowest node is another rank's are sent to it: several ranks may span one. */
static PetscErrorCode HandOver(const MpmSpace *space, const MpmGrid *grid, PetscInt corners, PetscInt nodes[])
{
  MpmLists     sent = {0}, received = {0};
  PetscInt    *length, *fill;
  PetscMPIInt *owner;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc2(grid->size, &length, grid->size, &fill));
  PetscCall(PetscMalloc1((space->local - space->owned), &owner));
  for (PetscInt i = space->owned; i < space->local; i++) {
    PetscInt node[MPM_MAX_DIM];

    MpmSpaceAt(space, &space->node[i * space->dim], node);
    owner[i - space->owned] = MpmGridNodeOwner(grid, node);
    if (nodes[i * corners] >= 0) length[owner[i - space->owned]] += corners;
  }
  for (PetscMPIInt r = 0; r < grid->size; r++) sent.count += length[r] > 0;
  PetscCall(PetscMalloc1(sent.count, &sent.rank));
  PetscCall(PetscCalloc1((sent.count + 1), &sent.offset));
  for (PetscMPIInt r = 0, k = 0; r < grid->size; r++) {
    if (!length[r]) continue;
    sent.rank[k]       = r;
    fill[r]            = sent.offset[k];
    sent.offset[k + 1] = sent.offset[k] + length[r];
    k++;
  }
  PetscCall(PetscMalloc1(sent.offset[sent.count], &sent.data));
  for (PetscInt i = space->owned; i < space->local; i++) {
    for (PetscInt c = 0; c < corners && nodes[i * corners] >= 0; c++)
      sent.data[fill[owner[i - space->owned]]++] = nodes[i * corners + c];
  }
  PetscCall(MpmListsExchange(grid->comm, &sent, &received));
  for (PetscInt k = 0; k < received.offset[received.count]; k += corners)
    PetscCall(PetscArraycpy(&nodes[(received.data[k] - space->number.begin) * corners], &received.data[k], corners));
  PetscCall(MpmListsDestroy(&sent));
  PetscCall(MpmListsDestroy(&received));
  PetscCall(PetscFree2(length, fill));
  PetscCall(PetscFree(owner));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode CellsCreate(const MpmSpace *space, const MpmGrid *grid, Cells *cells)
{
  const PetscInt corners = space->dim == 2 ? 4 : 8;
  PetscInt      *nodes, begin;

  PetscFunctionBeginUser;
  PetscCall(ListSpanned(space, corners, &nodes));
  if (grid->size > 1) PetscCall(HandOver(space, grid, corners, nodes));
  *cells = (Cells){.corners = corners};
  for (PetscInt i = 0; i < space->owned; i++) cells->count += nodes[i * corners] >= 0;
  PetscCallMPI(MPI_Scan(&cells->count, &begin, 1, MPIU_INT, MPI_SUM, grid->comm));
  begin -= cells->count;
  PetscCall(PetscMalloc2(cells->count, &cells->id, (cells->count * corners), &cells->nodes));
  for (PetscInt i = 0, k = 0; i < space->owned; i++) {
    if (nodes[i * corners] < 0) continue;
    PetscCall(PetscArraycpy(&cells->nodes[k * corners], &nodes[i * corners], corners));
    cells->id[k] = begin + k;
    k++;
  }
  PetscCall(PetscFree(nodes));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- fields at the nodes ---- */

/* Values of the owned nodes: `components` of the unknowns from `first`, out of `value`, or zero without one. */
typedef struct {
  const PetscReal *value;
  PetscInt         owned, block, first, components;
} Nodal;

static PetscErrorCode FillNodal(const void *ctx, PetscReal values[])
{
  const Nodal *nodal = (const Nodal *)ctx;

  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < nodal->owned; i++) {
    for (PetscInt c = 0; c < nodal->components; c++)
      values[i * nodal->components + c] = nodal->value ? nodal->value[i * nodal->block + nodal->first + c] : 0.;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Mass of the points at the local nodes, kg: a small-cut node has little. */
static PetscErrorCode NodalMass(MpmModel model, const MpmPoints *points, PetscReal mass[])
{
  const MpmSpace *space = model->disc.space;
  const PetscInt  most  = PetscPowInt(space->width, space->dim);
  PetscReal      *at;
  MpmBasis        basis;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(most, &at));
  PetscCall(MpmBasisCreate(space, &basis));
  PetscCall(PetscArrayzero(mass, space->local));
  for (PetscInt g = 0; g < space->group_count; g++) {
    const MpmGroup *group = &space->groups[g];

    for (PetscInt s = group->point_begin; s < group->point_end; s++) {
      const PetscInt  p  = space->order[s];
      const PetscReal mp = MpmPointMassNow(points, model->disc.sum->materials, model->disc.layout, p);

      MpmSpaceEvaluate(space, group, p, &basis);
      PetscCall(PetscArrayzero(at, group->node_count));
      MpmBasisAddForce(&basis, group->node_count, mp, at);
      for (PetscInt i = 0; i < group->node_count; i++) mass[space->group_nodes[group->node_offset + i]] += at[i];
    }
  }
  PetscCall(MpmBasisDestroy(&basis));
  PetscCall(PetscFree(at));
  PetscCall(MpmSpaceAddToOwners(space, 1, mass));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Nodes of this rank that are written: extra nodes, its last ones, have no place. */
static PetscInt WrittenCount(const MpmSpace *space)
{
  return PetscMin(space->owned, space->extra.begin);
}

/* All that is written; arrays of the owned nodes. */
typedef struct {
  PetscReal *position, *mass, *load;
  PetscInt  *held, *rank, *part;
} NodeArrays;

static PetscErrorCode NodeArraysCreate(MpmModel model, NodeArrays *arrays)
{
  const MpmSpace *space = model->disc.space;
  const PetscInt  dim = space->dim, block = model->disc.block;
  MpmPoints       points;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc6((space->owned * dim), &arrays->position, space->local, &arrays->mass, (space->local * block),
                         &arrays->load, space->owned, &arrays->held, space->owned, &arrays->rank, space->owned,
                         &arrays->part));
  PetscCall(PetscArrayzero(arrays->load, space->local * block));
  if (model->disc.nodal.committed)
    PetscCall(PetscArraycpy(arrays->load, model->disc.nodal.force, space->local * block));
  PetscCall(MpmSpaceAddToOwners(space, block, arrays->load));
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  PetscCall(NodalMass(model, &points, arrays->mass));
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  for (PetscInt i = 0; i < space->owned; i++) {
    MpmNodePosition(&model->disc, i, &arrays->position[i * dim]);
    arrays->rank[i] = model->rank;
    arrays->part[i] = MpmSpacePart(space, &space->node[i * dim]);
    arrays->held[i] = 0;
    for (PetscInt c = 0; c < block; c++)
      if (!MpmConstraintsCounts(model->disc.constraints, i * block + c)) arrays->held[i] |= 1 << c;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode WriteNodesAndCells(MpmModel model, const NodeArrays *arrays, const Cells *cells)
{
  const MpmSpace *space = model->disc.space;
  const PetscInt  dim = space->dim, block = model->disc.block, motion = model->disc.layout->motion;
  const Nodal moved    = {model->disc.nodal.committed ? model->disc.nodal.u : NULL, WrittenCount(space), block, 0, dim};
  const Nodal reaction = {model->disc.nodal.committed ? model->disc.nodal.residual : NULL, WrittenCount(space), block,
                          0, dim};
  const Nodal load     = {arrays->load, WrittenCount(space), block, 0, dim};
  Nodal       others[MPM_MAX_BLOCK];
  PetscInt    count                   = 0;
  MpmDataset  sets[8 + MPM_MAX_BLOCK] = {{.name = "position", .components = dim, .real = arrays->position}};
  const MpmDataset corners            = {.name = "nodes", .components = cells->corners, .integer = cells->nodes};
  const MpmTable   cell_table         = {cells->count, cells->id, 1, &corners};

  PetscFunctionBeginUser;
  count = 1;
  if (motion) {
    sets[count++] = (MpmDataset){.name = "displacement_increment", .components = dim, .fill = FillNodal, .ctx = &moved};
    sets[count++] = (MpmDataset){.name = "reaction", .components = dim, .fill = FillNodal, .ctx = &reaction};
    sets[count++] = (MpmDataset){.name = "load", .components = dim, .fill = FillNodal, .ctx = &load};
  }
  sets[count++] = (MpmDataset){.name = "mass", .components = 1, .real = arrays->mass};
  sets[count++] = (MpmDataset){.name = "held", .components = 1, .integer = arrays->held};
  sets[count++] = (MpmDataset){.name = "rank", .components = 1, .integer = arrays->rank};
  if (model->disc.material.parts > 1)
    sets[count++] = (MpmDataset){.name = "part", .components = 1, .integer = arrays->part};
  for (PetscInt c = motion; c < block; c++) {
    others[c]     = (Nodal){moved.value, WrittenCount(space), block, c, 1};
    sets[count++] = (MpmDataset){
      .name = model->disc.layout->component[c].name, .components = 1, .fill = FillNodal, .ctx = &others[c]};
  }
  {
    const MpmTable node_table = {WrittenCount(space), space->number.global, count, sets};

    PetscCall(
      MpmOutputWriteGrid(model->results->states.file, model->state.step, model->state.time, &node_table, &cell_table));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  MpmLatticeWrite - append the active nodes and cells to the output

  Collective

  Notes: After a step the nodes are those of its solution, with its fields: the increment of the displacement (m), the
  internal minus the external force (N; the reaction where the node is constrained, Newton's residual elsewhere) and the
  external force (N). These fields are zero in the initial state, in that from which a completed run goes on, and after
  a step that failed. `mass` is the points' (kg), `held` the sum of 1, 2, 4 where the displacement along x, y, z is
  prescribed, `rank` the rank that owns the node. Where bodies are in contact, `part` is the node's part: parts have
  nodes and cells of their own, also at equal places. Further unknowns follow by name.
@*/
PetscErrorCode MpmLatticeWrite(MpmModel model)
{
  MpmOutcome outcome;
  NodeArrays arrays;
  Cells      cells;

  PetscFunctionBeginUser;
  if (!model->disc.nodal.committed) {
    PetscCall(MpmStepSpace(model, &outcome));
    if (outcome.code) PetscFunctionReturn(PETSC_SUCCESS);             /* the step will say so */
    PetscCall(MpmModelPrescribe(model, model->state.time, &outcome)); /* a contradiction, reported by the step */
  }
  PetscCall(NodeArraysCreate(model, &arrays));
  PetscCall(CellsCreate(model->disc.space, model->disc.grid, &cells));
  PetscCall(MpmOutputSetBehind(model->results->states.file, model->state.scheme.behind));
  PetscCall(WriteNodesAndCells(model, &arrays, &cells));
  PetscCall(PetscFree2(cells.id, cells.nodes));
  PetscCall(PetscFree6(arrays.position, arrays.mass, arrays.load, arrays.held, arrays.rank, arrays.part));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Shares of the points' domains in cells, and the boxes of nodes that means by shares couple.

    f_pc = prod_a f_pc,a ,   f_pc,a the part of the domain [x - l, x + l] in the cell along axis a

  Domains are those of the weights, at the step's start: clipped at walls and at the grid's edges. Shares add up to 1.
*/
#include "grid/grid.h"
#include "space/rules.h"
#include "points/spread_mean.h"

/* Cells and parts of all points. */
static PetscErrorCode FindParts(const MpmRules *rules, const MpmPoints *points, const MpmSpace *space,
                                MpmSpread *spread)
{
  const MpmGrid *grid = rules->grid;
  const PetscInt dim = space->dim, count = space->point_count * dim;

  PetscFunctionBeginUser;
  spread->width = space->width;
  PetscCall(
    PetscMalloc3((count + 1), &spread->first, (count + 1), &spread->count, (count * spread->width + 1), &spread->part));
  for (PetscInt k = 0; k < count; k++) {
    const PetscInt  p = k / dim, a = k % dim;
    const PetscReal xi = (points->x[k] - grid->lower[a]) / grid->h[a], half = space->shapes.half[k];
    PetscInt        lower[MPM_MAX_DIM], upper[MPM_MAX_DIM], low, high;

    MpmSpaceEdges(rules, &points->x[p * dim], lower, upper);
    MpmShapeCells(xi, half, lower[a], upper[a], &low, &high);
    spread->first[k] = low;
    spread->count[k] = high - low + 1;
    for (PetscInt c = low; c <= high; c++)
      spread->part[k * spread->width + c - low] = MpmShapePart(c, low, high, xi, half, NULL);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The window of nodes about a cell, on any rank. */
static PetscErrorCode FindWindow(const MpmRules *rules, const MpmSpace *space, MpmSpread *spread)
{
  const PetscInt dim                   = space->dim;
  PetscInt       most[3 * MPM_MAX_DIM] = {0};

  PetscFunctionBeginUser;
  for (PetscInt g = 0; g < space->group_count; g++) {
    const MpmGroup *group = &space->groups[g];
    PetscInt        first[MPM_MAX_DIM];

    MpmSpaceGroupAt(space, group, first);
    for (PetscInt k = group->point_begin * dim; k < group->point_end * dim; k++) {
      const PetscInt a = k % dim, i = space->order[k / dim] * dim + a, low = spread->first[i] - first[a];
      const PetscInt apart = spread->count[i] - 1;

      most[a]                   = PetscMax(most[a], low + apart);
      most[MPM_MAX_DIM + a]     = PetscMax(most[MPM_MAX_DIM + a], group->count[a] - 1 - low);
      most[2 * MPM_MAX_DIM + a] = PetscMax(most[2 * MPM_MAX_DIM + a], apart);
    }
  }
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, most, 3 * MPM_MAX_DIM, MPIU_INT, MPI_MAX, rules->grid->comm));
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    spread->lower[a] = most[a];
    spread->upper[a] = most[MPM_MAX_DIM + a];
    spread->range[a] = most[2 * MPM_MAX_DIM + a];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A box of nodes that points of some rank touch; whole integers. */
typedef struct {
  PetscInt first[MPM_MAX_DIM], count[MPM_MAX_DIM], part, node_count;
} Touched;

/* Nodes touched by other ranks' points beside this rank's cells become ghosts here. */
static PetscErrorCode AddForeign(const MpmRules *rules, const MpmSpread *spread, MpmSpace *space)
{
  const MpmGrid *grid  = rules->grid;
  const PetscInt own   = space->group_count;
  PetscInt       count = own, *around;
  Touched       *touched;
  MpmGroup      *boxes;

  PetscFunctionBeginUser;
  if (grid->size == 1) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(own, &touched));
  PetscCall(PetscMalloc1((2 * MPM_MAX_DIM * own + 1), &around));
  for (PetscInt g = 0; g < own; g++) {
    const MpmGroup *group = &space->groups[g];
    PetscInt        at[MPM_MAX_DIM];

    touched[g] = (Touched){.part = group->part, .node_count = group->node_count};
    MpmSpaceGroupAt(space, group, at);
    for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
      const PetscInt reach = spread->lower[a] + spread->upper[a] + 2 * spread->range[a], last = grid->nodes[a] - 1;
      PetscInt      *box = &around[2 * MPM_MAX_DIM * g];

      touched[g].first[a]  = group->first[a];
      touched[g].count[a]  = group->count[a];
      box[a]               = PetscClipInterval(at[a] - reach, 0, last);
      box[MPM_MAX_DIM + a] = PetscClipInterval(at[a] + group->count[a] - 1 + reach, 0, last);
    }
  }
  PetscCall(MpmGridShare(grid, sizeof(Touched), around, &count, (void **)&touched));
  PetscCall(MpmSpaceAppendBoxes(space, count - own, &boxes));
  for (PetscInt k = own; k < count; k++) {
    MpmGroup *box = &boxes[k - own];

    PetscCall(PetscArraycpy(box->first, touched[k].first, MPM_MAX_DIM));
    PetscCall(PetscArraycpy(box->count, touched[k].count, MPM_MAX_DIM));
    box->node_count = touched[k].node_count;
    box->part       = touched[k].part;
  }
  PetscCall(PetscFree(around));
  PetscCall(PetscFree(touched));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The bounds of this rank's cells, on the lattice of the nodes. */
typedef struct {
  PetscInt lower[MPM_MAX_DIM], count[MPM_MAX_DIM];
} Bounds;

/* The cells that the points lie in, each once, as places in the bounds; room is allocated. */
static PetscErrorCode ListCells(const MpmSpace *space, const MpmSpread *spread, Bounds *bounds, PetscInt *count,
                                PetscInt **list)
{
  const PetscInt dim = space->dim;
  PetscInt       end[MPM_MAX_DIM], fill = 0, first[MPM_MAX_DIM];

  PetscFunctionBeginUser;
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    bounds->lower[a] = a < dim ? PETSC_INT_MAX : 0;
    end[a]           = a < dim ? 0 : 1;
  }
  *count = 0;
  for (PetscInt pass = 0; pass < 2; pass++) {
    for (PetscInt g = 0; g < space->group_count; g++) {
      const PetscInt shift = space->parts.stride * space->groups[g].part;

      for (PetscInt s = space->groups[g].point_begin; s < space->groups[g].point_end; s++) {
        const PetscInt *cells = &spread->count[space->order[s] * dim];
        PetscInt        n     = 1;

        for (PetscInt a = 0; a < dim; a++) {
          first[a] = spread->first[space->order[s] * dim + a] + (a == dim - 1 ? shift : 0);
          n *= cells[a];
          if (pass) continue;
          bounds->lower[a] = PetscMin(bounds->lower[a], first[a]);
          end[a]           = PetscMax(end[a], first[a] + cells[a]);
        }
        for (PetscInt k = 0; pass && k < n; k++) {
          const PetscInt at[MPM_MAX_DIM] = {k % cells[0], k / cells[0] % cells[1], k / (cells[0] * cells[1])};
          PetscInt       place           = 0;

          for (PetscInt a = dim - 1; a >= 0; a--)
            place = place * bounds->count[a] + first[a] + at[a] - bounds->lower[a];
          (*list)[fill++] = place;
        }
        *count += pass ? 0 : n;
      }
    }
    for (PetscInt a = 0; a < MPM_MAX_DIM; a++) bounds->count[a] = end[a] - bounds->lower[a];
    if (!pass) PetscCall(PetscMalloc1((*count + 1), list));
  }
  PetscCall(PetscSortRemoveDupsInt(count, *list));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A window for each cell, with those of the cells within its range. */
static PetscErrorCode AddWindows(MpmSpread *spread, MpmSpace *space)
{
  const PetscInt dim = space->dim;
  PetscInt       count, *list;
  Bounds         bounds;
  MpmGroup      *boxes;

  PetscFunctionBeginUser;
  PetscCall(ListCells(space, spread, &bounds, &count, &list));
  spread->box_begin = space->boxes.count;
  spread->box_count = count;
  PetscCall(MpmSpaceAppendBoxes(space, count, &boxes));
  for (PetscInt k = 0; k < count; k++) {
    const PetscInt *n               = bounds.count;
    const PetscInt  at[MPM_MAX_DIM] = {list[k] % n[0], list[k] / n[0] % n[1], list[k] / (n[0] * n[1])};

    boxes[k].holes      = PETSC_TRUE;
    boxes[k].node_count = 1;
    for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
      boxes[k].margin[a] = spread->range[a];
      boxes[k].first[a]  = a < dim ? bounds.lower[a] + at[a] - spread->lower[a] - spread->range[a] : 0;
      boxes[k].count[a]  = a < dim ? spread->lower[a] + spread->upper[a] + 1 + 2 * spread->range[a] : 1;
      boxes[k].node_count *= boxes[k].count[a];
    }
  }
  PetscCall(PetscFree(list));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSpreadBoxes(const MpmRules *rules, const MpmPoints *points, MpmSpace *space)
{
  MpmSpread *spread;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(1, &spread));
  space->cells.spread = spread;
  PetscCall(FindParts(rules, points, space, spread));
  if (rules->longest > 0.) PetscFunctionReturn(PETSC_SUCCESS); /* explicit steps have no Jacobian */
  PetscCall(FindWindow(rules, space, spread));
  PetscCall(AddForeign(rules, spread, space));
  PetscCall(AddWindows(spread, space));
  PetscFunctionReturn(PETSC_SUCCESS);
}

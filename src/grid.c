/*
  The background grid: a regular lattice, cut among the ranks by planes between its nodes.

  Cuts nest: the first divides the lattice among two halves of the ranks, the next ones divide each part again, across
  whichever axis balances its points best (Berger and Bokhari 1987, doi:10.1109/TC.1987.1676942). So the parts are
  boxes, of any number of ranks, and follow the points also where a product of cuts per axis could not: along a slope,
  for instance.
*/
#include "mpmimpl.h"

/* What a point beside a cut costs, in points. */
#define BESIDE_CUT 0.25

PetscErrorCode MpmGridSetFromOptions(MpmGrid *grid, const MpmOptions *options, PetscInt dim)
{
  const MpmOptions block  = {options->comm, "mpm_grid_", options->record};
  PetscInt         refine = 1;

  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(grid, sizeof(*grid)));
  grid->comm = options->comm;
  grid->dim  = dim;
  PetscCallMPI(MPI_Comm_rank(grid->comm, &grid->rank));
  PetscCallMPI(MPI_Comm_size(grid->comm, &grid->size));
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    grid->cells[a] = grid->nodes[a] = 1;
    grid->h[a]                      = 1.;
  }
  PetscCall(MpmOptionsHeading(&block, "Background grid"));
  PetscCall(MpmOptionsReals(&block, "lower", "m", "lower corner", MPM_RANGE_ANY, MPM_REQUIRED, dim, grid->lower, NULL));
  PetscCall(MpmOptionsReals(&block, "upper", "m", "upper corner", MPM_RANGE_ANY, MPM_REQUIRED, dim, grid->upper, NULL));
  PetscCall(MpmOptionsInts(&block, "cells", "cells per axis", 1, 999999999, MPM_REQUIRED, dim, grid->cells, NULL));
  PetscCall(MpmOptionsInt(&block, "refine", "multiplies the cells per axis", 1, 1000000, MPM_OPTIONAL, &refine, NULL));
  for (PetscInt a = 0; a < dim && !MpmOptionsHelp(); a++) {
    MpmCheckInput(grid->upper[a] > grid->lower[a],
                  "-mpm_grid_upper: axis %c ends at %g, must lie above -mpm_grid_lower, %g", "xyz"[a],
                  (double)(grid->upper[a]), (double)(grid->lower[a]));
    MpmCheckInput((PetscInt64)grid->cells[a] * refine < 1000000000,
                  "-mpm_grid_refine %" PetscInt_FMT ": too many cells on axis %c", refine, "xyz"[a]);
    grid->cells[a] *= refine;
    grid->nodes[a] = grid->cells[a] + 1;
    grid->h[a]     = (grid->upper[a] - grid->lower[a]) / (PetscReal)grid->cells[a];
    MpmCheckInput(
      grid->h[a] > 1e-300 && grid->h[a] > 1e-12 * PetscMax(PetscAbsReal(grid->lower[a]), PetscAbsReal(grid->upper[a])),
      "-mpm_grid_cells: a cell of %g on axis %c is too small for its coordinates", (double)(grid->h[a]), "xyz"[a]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmGridDestroy(MpmGrid *grid)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(grid->cuts));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MpmGridFindCell(const MpmGrid *grid, const PetscReal x[], PetscInt cell[])
{
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) cell[a] = 0;
  for (PetscInt a = 0; a < grid->dim; a++) {
    const PetscReal xi = PetscFloorReal((x[a] - grid->lower[a]) / grid->h[a]);

    cell[a] = (PetscInt)PetscMin(PetscMax(xi, 0.), (PetscReal)(grid->cells[a] - 1));
  }
}

/*
  The part below a cut goes to the lower half of its ranks. Cuts stand in preorder: right behind one those of the part
  below, then those above, one less than there are ranks in each.
*/
PetscMPIInt MpmGridNodeOwner(const MpmGrid *grid, const PetscInt node[])
{
  const MpmCut *cut   = grid->cuts;
  PetscMPIInt   first = 0, ranks = grid->size;

  while (ranks > 1) {
    const PetscMPIInt below = ranks / 2;

    if (node[cut->axis] < cut->node) {
      cut++;
      ranks = below;
    } else {
      cut += below;
      first += below;
      ranks -= below;
    }
  }
  return first;
}

static PetscInt BoxOwners(const MpmCut *cut, PetscMPIInt first, PetscMPIInt ranks, const PetscInt lower[],
                          const PetscInt upper[], PetscMPIInt owner[])
{
  const PetscMPIInt below = ranks / 2;
  PetscInt          count = 0;

  if (ranks == 1) {
    owner[0] = first;
    return 1;
  }
  if (lower[cut->axis] < cut->node) count += BoxOwners(cut + 1, first, below, lower, upper, owner);
  if (upper[cut->axis] >= cut->node)
    count += BoxOwners(cut + below, first + below, ranks - below, lower, upper, owner + count);
  return count;
}

PetscInt MpmGridBoxOwners(const MpmGrid *grid, const PetscInt lower[], const PetscInt upper[], PetscMPIInt owner[])
{
  return BoxOwners(grid->cuts, 0, grid->size, lower, upper, owner);
}

/* ---- partition ---- */

/* A part of the lattice that is yet to be cut: a box of cells, upper ones excluded. */
typedef struct {
  PetscMPIInt ranks;
  PetscInt    cut; /* into the grid's cuts */
  PetscInt    lower[MPM_MAX_DIM], upper[MPM_MAX_DIM];
  PetscInt    histogram[MPM_MAX_DIM]; /* where its points per layer of cells start, on each axis */
} Part;

/* The box of all cells with points. */
static PetscErrorCode FindBox(const MpmGrid *grid, PetscInt count, const PetscReal x[], Part *box)
{
  PetscInt bound[2 * MPM_MAX_DIM]; /* minima and negated maxima */

  PetscFunctionBeginUser;
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    bound[a]               = grid->cells[a] - 1;
    bound[MPM_MAX_DIM + a] = 0;
  }
  for (PetscInt p = 0; p < count; p++) {
    PetscInt cell[MPM_MAX_DIM];

    MpmGridFindCell(grid, &x[p * grid->dim], cell);
    for (PetscInt a = 0; a < grid->dim; a++) {
      bound[a]               = PetscMin(bound[a], cell[a]);
      bound[MPM_MAX_DIM + a] = PetscMin(bound[MPM_MAX_DIM + a], -cell[a]);
    }
  }
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, bound, 2 * MPM_MAX_DIM, MPIU_INT, MPI_MIN, grid->comm));
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    box->lower[a] = bound[a];
    box->upper[a] = PetscMax(-bound[MPM_MAX_DIM + a], bound[a]) + 1;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Points per layer of cells, for every part and axis; `part` tells which part each point is in. */
static PetscErrorCode Histograms(const MpmGrid *grid, PetscInt count, const PetscReal x[], const PetscInt part[],
                                 PetscInt part_count, Part parts[], PetscInt64 **histogram)
{
  PetscInt size = 0;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < part_count; k++) {
    for (PetscInt a = 0; a < grid->dim; a++) {
      parts[k].histogram[a] = size;
      size += parts[k].upper[a] - parts[k].lower[a];
    }
  }
  PetscCall(PetscCalloc1(size, histogram));
  for (PetscInt p = 0; p < count; p++) {
    PetscInt cell[MPM_MAX_DIM];

    if (part[p] < 0) continue;
    MpmGridFindCell(grid, &x[p * grid->dim], cell);
    for (PetscInt a = 0; a < grid->dim; a++)
      (*histogram)[parts[part[p]].histogram[a] + cell[a] - parts[part[p]].lower[a]]++;
  }
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, *histogram, (PetscMPIInt)size, MPIU_INT64, MPI_SUM, grid->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Chooses the plane at which the fuller side has fewest points for a rank; what lies beside the plane counts as well, for
  it is what ranks have to tell each other. Raises `most` to the points on a rank where a side is one rank's alone.
*/
static void ChooseCut(PetscInt dim, const Part *part, const PetscInt64 histogram[], MpmCut *cut, PetscInt64 *most)
{
  const PetscMPIInt ranks = part->ranks, below = ranks / 2;
  PetscReal         best  = PETSC_MAX_REAL;
  PetscInt64        total = 0, chosen;

  for (PetscInt i = 0; i < part->upper[0] - part->lower[0]; i++) total += histogram[part->histogram[0] + i];
  chosen    = total;
  cut->axis = 0;
  cut->node = part->upper[0]; /* in a single cell there is nothing to share */
  for (PetscInt a = 0; a < dim; a++) {
    const PetscInt64 *layer = &histogram[part->histogram[a]];
    PetscInt64        sum   = 0;

    for (PetscInt i = 1; i < part->upper[a] - part->lower[a]; i++) {
      PetscReal cost;

      sum += layer[i - 1];
      cost = PetscMax((PetscReal)sum / below, (PetscReal)(total - sum) / (ranks - below)) +
             BESIDE_CUT * (PetscReal)PetscMin(layer[i - 1], layer[i]) / ranks;
      if (cost >= best) continue;
      best      = cost;
      chosen    = sum;
      cut->axis = a;
      cut->node = part->lower[a] + i;
    }
  }
  if (below == 1) *most = PetscMax(*most, chosen);
  if (ranks - below == 1) *most = PetscMax(*most, total - chosen);
}

/* The two sides of a cut that more than one rank shares become parts of the next level; returns how many there are. */
static PetscInt Divide(const Part *part, const MpmCut *cut, Part next[], PetscInt index[2], PetscInt first)
{
  const PetscMPIInt below = part->ranks / 2, ranks[2] = {below, part->ranks - below};
  PetscInt          made = 0;

  for (PetscInt side = 0; side < 2; side++) {
    index[side] = ranks[side] > 1 ? first + made : -1;
    if (ranks[side] == 1) continue;
    next[made]       = *part;
    next[made].ranks = ranks[side];
    next[made].cut   = part->cut + (side ? below : 1);
    if (side) next[made].lower[cut->axis] = PetscMin(cut->node, part->upper[cut->axis] - 1);
    else next[made].upper[cut->axis] = cut->node;
    made++;
  }
  return made;
}

/* All cuts, level by level; `most` becomes the points on the fullest rank. */
static PetscErrorCode CutAll(const MpmGrid *grid, PetscInt count, const PetscReal x[], MpmCut cuts[], PetscInt64 *most)
{
  Part    *parts, *next;
  PetscInt part_count = 1, *part, (*index)[2];

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc3(grid->size, &parts, grid->size, &next, grid->size, &index));
  PetscCall(PetscCalloc1(count, &part));
  parts[0] = (Part){.ranks = grid->size};
  PetscCall(FindBox(grid, count, x, &parts[0]));
  while (part_count) {
    PetscInt64 *histogram;
    PetscInt    made = 0;

    PetscCall(Histograms(grid, count, x, part, part_count, parts, &histogram));
    for (PetscInt k = 0; k < part_count; k++) {
      MpmCut *cut = &cuts[parts[k].cut];

      ChooseCut(grid->dim, &parts[k], histogram, cut, most);
      made += Divide(&parts[k], cut, &next[made], index[k], made);
    }
    PetscCall(PetscFree(histogram));
    for (PetscInt p = 0; p < count && made; p++) {
      PetscInt      cell[MPM_MAX_DIM];
      const MpmCut *cut = part[p] < 0 ? NULL : &cuts[parts[part[p]].cut];

      if (!cut) continue;
      MpmGridFindCell(grid, &x[p * grid->dim], cell);
      part[p] = index[part[p]][cell[cut->axis] >= cut->node];
    }
    PetscCall(PetscArraycpy(parts, next, made));
    part_count = made;
  }
  PetscCall(PetscFree(part));
  PetscCall(PetscFree3(parts, next, index));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmGridPartition(MpmGrid *grid, PetscInt count, const PetscReal x[], PetscReal worth, PetscBool *taken)
{
  PetscInt64 most = 0;
  MpmCut    *cuts;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(grid->size, &cuts));
  if (grid->size > 1) PetscCall(CutAll(grid, count, x, cuts, &most));
  *taken = (PetscBool)(!grid->cuts || (PetscReal)most <= worth);
  if (*taken) {
    PetscCall(PetscFree(grid->cuts));
    grid->cuts = cuts;
  } else PetscCall(PetscFree(cuts));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Columns from maps of depth and velocity, on a lattice in the cells of the grid.
*/
#include "options/options.h"
#include "grid/grid.h"
#include "handover/columns.h"

/* A number, or a map. */
typedef struct {
  PetscReal number;
  MpmMap    map;
} Field;

static PetscErrorCode ReadField(const MpmOptions *block, const MpmBed *bed, const char *name, const char *help,
                                MpmNeed need, Field *field)
{
  const MpmMapAsk ask                      = {.project = bed ? bed->project : NULL};
  char            message[MPM_MAP_MESSAGE] = "", *text, *end;

  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(field, sizeof(*field)));
  PetscCall(MpmOptionsText(block, name, help, NULL, need, &text));
  if (!text || MpmOptionsHelp()) PetscFunctionReturn(PetscFree(text));
  field->number = strtod(text, &end);
  if (end == text || *end) {
    PetscCall(MpmOptionsResolve(block, name, &text));
    PetscCall(MpmMapRead(text, &ask, &field->map, message));
    MpmCheckInput(!message[0], "-%s%s %s: %s", block->prefix, name, text, message);
  }
  MpmCheckInput(!PetscIsInfOrNanReal(field->number), "-%s%s %s: must be a number or a map", block->prefix, name, text);
  PetscCall(PetscFree(text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscReal At(const Field *field, const PetscReal x[])
{
  return field->map.value ? MpmMapAt(&field->map, x) : field->number;
}

/* Columns with depth among this rank's share of the grid's rows; written where `at` is given. */
static PetscInt Lattice(const MpmGrid *grid, const PetscInt per_cell[2], const MpmBed *bed, const Field field[3],
                        PetscReal density, MpmFlowColumn *at)
{
  const PetscInt   n[2]    = {grid->cells[0] * per_cell[0], grid->cells[1] * per_cell[1]};
  const PetscInt64 total   = (PetscInt64)n[0] * n[1];
  const PetscReal  size[2] = {grid->h[0] / (PetscReal)per_cell[0], grid->h[1] / (PetscReal)per_cell[1]};
  PetscInt         count   = 0;

  for (PetscInt64 k = total * grid->rank / grid->size; k < total * (grid->rank + 1) / grid->size; k++) {
    MpmFlowColumn column = {.id = (PetscInt)k};
    MpmBedPatch   patch;

    column.x[0]  = grid->lower[0] + ((PetscReal)(k % n[0]) + 0.5) * size[0];
    column.x[1]  = grid->lower[1] + ((PetscReal)(k / n[0]) + 0.5) * size[1];
    column.depth = At(&field[0], column.x);
    if (!(column.depth > 0.)) continue;
    if (at) {
      MpmBedPatchAt(bed, column.x, &patch);
      column.bed    = patch.z;
      column.volume = column.depth * size[0] * size[1];
      column.mass   = density * column.volume;
      for (PetscInt a = 0; a < 2; a++) {
        column.half[a]     = 0.5 * size[a];
        column.slope[a]    = patch.slope[a];
        column.velocity[a] = At(&field[1 + a], column.x);
      }
      at[count] = column;
    }
    count++;
  }
  return count;
}

PetscErrorCode MpmColumnsReadMaps(const MpmOptions *block, const MpmGrid *grid, const MpmBed *bed, PetscReal density,
                                  MpmFlowColumns *columns)
{
  PetscInt   per_cell[2] = {2, 2};
  PetscInt64 total;
  Field      field[3];

  PetscFunctionBeginUser;
  PetscCall(ReadField(block, bed, "depth", "region columns, in place of file: vertical depth, m: a number, or a map",
                      MPM_OPTIONAL, &field[0]));
  PetscCall(
    ReadField(block, bed, "velocity_x", "of columns from a depth: m/s, a number, or a map", MPM_OPTIONAL, &field[1]));
  PetscCall(
    ReadField(block, bed, "velocity_y", "of columns from a depth: m/s, a number, or a map", MPM_OPTIONAL, &field[2]));
  PetscCall(MpmOptionsInts(block, "columns_per_cell",
                           "columns per cell and axis: of region depth, and of region columns from a depth", 1, 64,
                           MPM_OPTIONAL, 2, per_cell, NULL));
  if (MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  columns->count = Lattice(grid, per_cell, bed, field, density, NULL);
  total          = columns->count;
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &total, 1, MPIU_INT64, MPI_SUM, grid->comm));
  MpmCheckInput(total, "-%sdepth: is nowhere positive in the grid", block->prefix);
  PetscCall(PetscMalloc1((size_t)columns->count + 1, &columns->at));
  (void)Lattice(grid, per_cell, bed, field, density, columns->at);
  for (PetscInt k = 0; k < 3; k++) PetscCall(MpmMapDestroy(&field[k].map));
  PetscFunctionReturn(PETSC_SUCCESS);
}

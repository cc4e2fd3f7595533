/*
  Columns from the file of a depth-averaged run.
*/
#include "options/options.h"
#include "files/point_table.h"
#include "point/registry.h"
#include "handover/columns.h"

#define OTHER_BED 0.1 /* m: heights of the bed in file and scene that differ by more belong to two beds */

enum { POSITION, DEPTH, BED, SLOPE, VOLUME, MASS, VELOCITY, GRADIENT, HALF_LENGTH, DEFORMATION, ID, QUANTITIES };

static const struct {
  const char *name;
  PetscInt    components;
  MpmNeed     need;
} quantities[QUANTITIES] = {{"position", 2, MPM_REQUIRED},    {"depth", 1, MPM_REQUIRED},
                            {"bed", 1, MPM_REQUIRED},         {"bed_slope", 2, MPM_OPTIONAL},
                            {"volume", 1, MPM_REQUIRED},      {"mass", 1, MPM_REQUIRED},
                            {"velocity", 2, MPM_REQUIRED},    {"velocity_gradient", 4, MPM_OPTIONAL},
                            {"half_length", 2, MPM_OPTIONAL}, {"F", 9, MPM_OPTIONAL},
                            {"id", 1, MPM_OPTIONAL}};

/* Half-lengths of the base: those of the file stretched by F, with the area of volume over depth; or a square. */
static void Base(PetscReal *const value[], PetscInt p, MpmFlowColumn *column)
{
  const PetscReal  area           = column->volume / column->depth;
  const PetscReal *F              = value[DEFORMATION] ? &value[DEFORMATION][9 * p] : NULL;
  PetscReal        U[MPM_MAX_DIM] = {1., 1., 1.}, scale;

  for (PetscInt a = 0; a < 2; a++) column->half[a] = value[HALF_LENGTH] ? value[HALF_LENGTH][2 * p + a] : 1.;
  if (F && value[HALF_LENGTH] && !MpmStretchFind(2)((const PetscReal[]){F[0], F[1], F[3], F[4]}, U))
    for (PetscInt a = 0; a < 2; a++) column->half[a] *= U[a];
  scale = PetscSqrtReal(area / (4. * column->half[0] * column->half[1]));
  for (PetscInt a = 0; a < 2; a++) column->half[a] *= scale;
}

static void Fill(PetscReal *const value[], PetscInt p, MpmFlowColumn *column)
{
  *column =
    (MpmFlowColumn){.id = value[ID] ? (PetscInt)value[ID][p] : 0, .depth = value[DEPTH][p], .bed = value[BED][p]};
  column->volume = value[VOLUME][p];
  column->mass   = value[MASS][p];
  for (PetscInt a = 0; a < 2; a++) {
    column->x[a]        = value[POSITION][2 * p + a];
    column->velocity[a] = value[VELOCITY][2 * p + a];
    column->slope[a]    = value[SLOPE] ? value[SLOPE][2 * p + a] : 0.;
  }
  for (PetscInt k = 0; value[GRADIENT] && k < 4; k++) column->gradient[k] = value[GRADIENT][4 * p + k];
  if (column->depth > 0. && column->volume > 0.) Base(value, p, column);
}

/* True where the scene has read its bed: of a map, about its grid. A column elsewhere keeps the file's. */
static PetscBool Knows(const MpmBed *bed, const PetscReal x[2])
{
  const MpmMap   *map    = &bed->map;
  const PetscReal far[2] = {map->x0 + (PetscReal)(map->columns - 1) * map->cell[0],
                            map->y0 + (PetscReal)(map->rows - 1) * map->cell[1]};

  return (PetscBool)(!map->value || (x[0] >= map->x0 && x[1] >= map->y0 && x[0] <= far[0] && x[1] <= far[1]));
}

/* The scene's bed below a column; `differs`: the most by which the file's is another, m. */
static void Stand(const MpmBed *bed, MpmFlowColumn *column, PetscReal *differs)
{
  MpmBedPatch patch;

  if (!Knows(bed, column->x)) return;
  MpmBedPatchAt(bed, column->x, &patch);
  if (!PetscIsInfOrNanReal(patch.z)) *differs = PetscMax(*differs, PetscAbsReal(patch.z - column->bed));
  column->bed = patch.z;
  for (PetscInt a = 0; a < 2; a++) column->slope[a] = patch.slope[a];
}

/* Fails for columns without depth, and for those of another bed. */
static PetscErrorCode Check(const MpmOptions *block, const char *path, const MpmFlowColumns *columns, PetscReal differs)
{
  PetscReal worst[2] = {differs, 0.};

  PetscFunctionBeginUser;
  for (PetscInt p = 0; p < columns->count; p++)
    if (!(columns->at[p].depth > 0. && columns->at[p].volume > 0. && columns->at[p].mass > 0.)) worst[1] = 1.;
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, worst, 2, MPIU_REAL, MPIU_MAX, block->comm));
  MpmCheckInput(worst[1] == 0., "-%sfile %s: has columns whose depth, volume or mass is not positive", block->prefix,
                path);
  MpmCheckInput(worst[0] <= OTHER_BED,
                "-%sfile %s: its bed differs from the scene's by %g m; at most %g m are accepted", block->prefix, path,
                (double)worst[0], OTHER_BED);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmColumnsReadFile(const MpmOptions *block, const char *path, const char *step, const MpmBed *bed,
                                  MpmFlowColumns *columns)
{
  PetscReal   *value[QUANTITIES], differs = 0.;
  MpmPointFile file;

  PetscFunctionBeginUser;
  PetscCall(MpmPointFileOpen(block, 2, path, step, &file));
  columns->count = MpmPointFileCount(file);
  for (PetscInt q = 0; q < QUANTITIES; q++)
    PetscCall(MpmPointFileGet(file, quantities[q].name, quantities[q].components,
                              q == SLOPE && !bed ? MPM_REQUIRED : quantities[q].need, &value[q]));
  PetscCall(MpmPointFileClose(&file));
  PetscCall(MpmColumnsSteps(block->comm, path, step, &columns->time, NULL, NULL));
  PetscCall(PetscMalloc1((size_t)columns->count + 1, &columns->at));
  for (PetscInt p = 0; p < columns->count; p++) {
    Fill(value, p, &columns->at[p]);
    if (bed) Stand(bed, &columns->at[p], &differs);
  }
  for (PetscInt q = 0; q < QUANTITIES; q++) PetscCall(PetscFree(value[q]));
  PetscCall(Check(block, path, columns, differs));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Points in three dimensions from columns.
*/
#include "options/options.h"
#include "grid/grid.h"
#include "handover/columns.h"
#include "handover/handover.h"
#include "handover/hydrograph.h"
#include "handover/window.h"

#define GRAVITY 9.81 /* m/s2, in a scene without loads of gravity */

typedef struct {
  char     *file, *step;
  PetscReal spacing, gravity, window[2][2], longest[2]; /* longest: half-length of a base, m */
  PetscBool weight, inflow;
} Options;

/* The downward acceleration of the scene's gravity loads, m/s2; unchanged where there is none. */
static PetscErrorCode FindGravity(MPI_Comm comm, PetscReal *gravity)
{
  const MpmOptions scene = {comm, "mpm_", NULL};
  PetscInt         count;
  PetscReal        sum = 0.;
  char           **names;

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsNames(&scene, "loads", "", MPM_OPTIONAL, &count, &names));
  for (PetscInt l = 0; l < count; l++) {
    PetscReal  value[MPM_MAX_DIM] = {0., 0., 0.};
    PetscBool  same;
    char       prefix[256], *type;
    MpmOptions load = {comm, prefix, NULL};

    PetscCall(PetscSNPrintf(prefix, sizeof(prefix), "mpm_load_%s_", names[l]));
    PetscCall(MpmOptionsText(&load, "type", "", NULL, MPM_OPTIONAL, &type));
    PetscCall(PetscStrcmp(type ? type : "", "gravity", &same));
    PetscCall(PetscFree(type));
    if (!same) continue;
    PetscCall(MpmOptionsReals(&load, "value", "m/s2", "", MPM_RANGE_ANY, MPM_REQUIRED, MPM_MAX_DIM, value, NULL));
    sum -= value[MPM_MAX_DIM - 1];
  }
  PetscCall(MpmNamesDestroy(count, &names));
  if (sum > 0.) *gravity = sum;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Options of region columns; defaults: half the height of a cell, and the grid's rectangle as window. */
static PetscErrorCode ReadOptions(const MpmOptions *block, const MpmGrid *grid, Options *options)
{
  static const char *const stresses[] = {"weight", "none", NULL};
  PetscInt                 stress     = 0;

  PetscFunctionBeginUser;
  *options = (Options){.spacing = 0.5 * grid->h[MPM_MAX_DIM - 1], .gravity = GRAVITY};
  if (!MpmOptionsHelp() && grid->dim == MPM_MAX_DIM) PetscCall(FindGravity(block->comm, &options->gravity));
  for (PetscInt a = 0; a < 2; a++) {
    options->window[0][a] = grid->lower[a];
    options->window[1][a] = grid->upper[a];
    options->longest[a]   = grid->h[a];
  }
  PetscCall(MpmOptionsReal(block, "spacing", "m",
                           "region columns: height of a column's points; default half that of a grid cell",
                           MPM_RANGE_POSITIVE, MPM_OPTIONAL, &options->spacing, NULL));
  PetscCall(MpmOptionsReals(block, "lower", "m",
                            "region columns: lower corner of the window, x and y; default the grid's", MPM_RANGE_ANY,
                            MPM_OPTIONAL, 2, options->window[0], NULL));
  PetscCall(MpmOptionsReals(block, "upper", "m",
                            "region columns: upper corner of the window, x and y; default the grid's", MPM_RANGE_ANY,
                            MPM_OPTIONAL, 2, options->window[1], NULL));
  PetscCall(
    MpmOptionsWord(block, "stress",
                   "region columns: stress that points start with, by the weight above where the law can have it, "
                   "or none",
                   stresses, MPM_OPTIONAL, &stress, NULL));
  PetscCall(MpmOptionsReal(block, "gravity", "m/s2",
                           "region columns: of that weight; default that of the scene's loads", MPM_RANGE_NON_NEGATIVE,
                           MPM_OPTIONAL, &options->gravity, NULL));
  PetscCall(MpmOptionsBool(block, "inflow",
                           "region columns: columns that enter the window in later states of the file come in then",
                           &options->inflow, NULL));
  options->weight = (PetscBool)!stress;
  for (PetscInt a = 0; a < 2 && !MpmOptionsHelp(); a++)
    MpmCheckInput(options->window[0][a] < options->window[1][a],
                  "-%supper %g on axis %c: must be > -%slower, which is %g", block->prefix,
                  (double)options->window[1][a], "xy"[a], block -> prefix, (double)options -> window[0][a]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The bed of the scene, or without any pixels and plane: `has` is false. */
static PetscErrorCode ReadBed(const MpmOptions *block, const MpmGrid *grid, MpmBed *bed, PetscBool *has)
{
  const MpmOptions scene = {block->comm, "mpm_", block->record};
  PetscBool        plane;

  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(bed, sizeof(*bed)));
  PetscCall(MpmOptionsHas(&scene, "terrain_file", has));
  PetscCall(MpmOptionsHas(&scene, "bed", &plane));
  *has = (PetscBool)(*has || plane);
  if (*has) PetscCall(MpmBedRead(&scene, grid->lower, grid->upper, bed));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscInt Share(const MpmFlowColumn *column, PetscReal spacing)
{
  return PetscMax(1, (PetscInt)PetscFloorReal(column->depth / spacing + 0.5));
}

/* One point, the i-th from below of M of a column. */
static void FillPoint(const MpmFlowColumn *column, const Options *options, PetscInt i, PetscInt M, PetscInt p,
                      MpmHandover *handover)
{
  const PetscReal high = column->depth / (PetscReal)M, above = column->depth - ((PetscReal)i + 0.5) * high;
  const PetscReal steep  = 1. + column->slope[0] * column->slope[0] + column->slope[1] * column->slope[1];
  const PetscReal weight = column->mass / column->volume * options->gravity * above / steep;
  PetscReal      *v = &handover->velocity[3 * p], *gradient = &handover->gradient[9 * p];

  for (PetscInt a = 0; a < 2; a++) {
    handover->position[3 * p + a]    = column->x[a];
    handover->half_length[3 * p + a] = PetscMin(column->half[a], options->longest[a]);
    v[a]                             = column->velocity[a];
  }
  handover->position[3 * p + 2]    = column->bed + ((PetscReal)i + 0.5) * high;
  handover->half_length[3 * p + 2] = 0.5 * high;
  v[2]                             = column->slope[0] * v[0] + column->slope[1] * v[1];
  handover->volume[p]              = column->volume / (PetscReal)M;
  handover->mass[p]                = column->mass / (PetscReal)M;
  handover->entry[p]               = column->entry;
  for (PetscInt k = 0; k < 9; k++) gradient[k] = 0.;
  for (PetscInt b = 0; b < 2; b++) {
    for (PetscInt a = 0; a < 2; a++) {
      gradient[3 * a + b] = column->gradient[2 * a + b];
      gradient[6 + b] += column->slope[a] * column->gradient[2 * a + b];
    }
  }
  for (PetscInt c = 0; handover->stress && c < 6; c++) handover->stress[6 * p + c] = c < 3 ? -weight : 0.;
}

static PetscErrorCode Fill(const MpmFlowColumns *columns, const Options *options, MpmHandover *handover)
{
  PetscInt count = 0;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < columns->count; k++) count += Share(&columns->at[k], options->spacing);
  PetscCall(PetscMalloc1((size_t)count * 3 + 1, &handover->position));
  PetscCall(PetscMalloc1((size_t)count * 3 + 1, &handover->half_length));
  PetscCall(PetscMalloc1((size_t)count * 3 + 1, &handover->velocity));
  PetscCall(PetscMalloc1((size_t)count + 1, &handover->volume));
  PetscCall(PetscMalloc1((size_t)count + 1, &handover->mass));
  PetscCall(PetscMalloc1((size_t)count + 1, &handover->entry));
  PetscCall(PetscMalloc1((size_t)count * 9 + 1, &handover->gradient));
  if (options->weight) PetscCall(PetscMalloc1((size_t)count * 6 + 1, &handover->stress));
  handover->count = 0;
  for (PetscInt k = 0; k < columns->count; k++) {
    const PetscInt M = Share(&columns->at[k], options->spacing);

    for (PetscInt i = 0; i < M; i++) FillPoint(&columns->at[k], options, i, M, handover->count++, handover);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Line of the log and entries of the summary. */
static PetscErrorCode Report(const MpmOptions *block, const MpmWindow *window, PetscInt64 columns,
                             MpmHandover *handover)
{
  PetscInt64 count[2] = {columns, handover->count};
  char       text[512];

  PetscFunctionBeginUser;
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, count, 2, MPIU_INT64, MPI_SUM, block->comm));
  PetscCall(PetscSNPrintf(text, sizeof(text),
                          "%lld columns became %lld points of %g kg; %g kg stayed outside of the window, %g kg come in "
                          "later",
                          (long long)count[0], (long long)count[1], (double)window->mass[MPM_WINDOW_INSIDE],
                          (double)(window->mass[MPM_WINDOW_OUTSIDE] - window->mass[MPM_WINDOW_LATER]),
                          (double)window->mass[MPM_WINDOW_LATER]));
  PetscCall(PetscStrallocpy(text, &handover->line));
  PetscCall(PetscSNPrintf(text, sizeof(text),
                          "\"columns\": %lld, \"points\": %lld, \"mass\": %.17g, \"mass_outside\": %.17g, "
                          "\"mass_later\": %.17g, \"time\": %.17g",
                          (long long)count[0], (long long)count[1], (double)window->mass[MPM_WINDOW_INSIDE],
                          (double)window->mass[MPM_WINDOW_OUTSIDE], (double)window->mass[MPM_WINDOW_LATER],
                          (double)window->time));
  PetscCall(PetscStrallocpy(text, &handover->entries));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmHandoverColumns(const MpmOptions *block, const MpmGrid *grid, PetscReal density,
                                  MpmHandover *handover)
{
  MpmFlowColumns columns = {0};
  MpmWindow      window  = {0};
  Options        options;
  MpmBed         bed;
  PetscBool      has = PETSC_FALSE, from_map = PETSC_FALSE;

  PetscFunctionBeginUser;
  PetscCall(ReadOptions(block, grid, &options));
  if (MpmOptionsHelp()) PetscFunctionReturn(MpmColumnsReadMaps(block, grid, NULL, density, &columns));
  MpmCheckInput(grid->dim == MPM_MAX_DIM, "-%sregion columns: exists in 3 dimensions only", block->prefix);
  PetscCall(MpmOptionsHas(block, "depth", &from_map));
  PetscCall(ReadBed(block, grid, &bed, &has));
  if (from_map) {
    MpmCheckInput(has, "-%sdepth: columns from maps need a bed, -mpm_terrain_file or -mpm_bed", block->prefix);
    MpmCheckInput(!options.inflow, "-%sinflow: is for columns from the file of a run", block->prefix);
    PetscCall(MpmColumnsReadMaps(block, grid, &bed, density, &columns));
  } else {
    PetscCall(MpmOptionsPath(block, "file", "HDF5 file of a depth-averaged run", MPM_REQUIRED, &handover->path));
    PetscCall(MpmOptionsText(block, "step", "which step of the file: a number, or latest", "latest", MPM_OPTIONAL,
                             &options.step));
    PetscCall(MpmColumnsReadFile(block, handover->path, options.step, has ? &bed : NULL, &columns));
  }
  for (PetscInt a = 0; a < 2; a++) {
    window.lower[a] = options.window[0][a];
    window.upper[a] = options.window[1][a];
  }
  PetscCall(MpmWindowCut(block->comm, &window, &columns));
  if (options.inflow)
    PetscCall(MpmWindowFollow(block, handover->path, options.step, has ? &bed : NULL, &window, &columns));
  PetscCall(Fill(&columns, &options, handover));
  handover->later = (PetscBool)(window.mass[MPM_WINDOW_LATER] > 0.);
  PetscCall(Report(block, &window, columns.count, handover));
  PetscCall(MpmWindowDestroy(&window));
  PetscCall(MpmBedDestroy(&bed));
  PetscCall(PetscFree(columns.at));
  PetscCall(PetscFree(options.step));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmHandoverDestroy(MpmHandover *handover)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(handover->position));
  PetscCall(PetscFree(handover->half_length));
  PetscCall(PetscFree(handover->velocity));
  PetscCall(PetscFree(handover->volume));
  PetscCall(PetscFree(handover->mass));
  PetscCall(PetscFree(handover->gradient));
  PetscCall(PetscFree(handover->stress));
  PetscCall(PetscFree(handover->depth));
  PetscCall(PetscFree(handover->entry));
  PetscCall(PetscFree(handover->path));
  PetscCall(PetscFree(handover->line));
  PetscCall(PetscFree(handover->entries));
  PetscCall(MpmInletDestroy(&handover->inlet));
  PetscFunctionReturn(PETSC_SUCCESS);
}

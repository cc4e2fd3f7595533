/*
  Columns by a hydrograph.
*/
#include "options/options.h"
#include "grid/grid.h"
#include "files/csv_table.h"
#include "maps/map.h"
#include "maps/outline.h"
#include "handover/handover.h"
#include "handover/hydrograph.h"

#define MOST_ROWS 1e8  /* rows of columns, more than any run takes */
#define SLIVER    1e-6 /* of a row: what is left of the table goes into the last one */

PetscErrorCode MpmInletDestroy(MpmInlet **inlet)
{
  PetscFunctionBeginUser;
  if (!*inlet) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscFree3((*inlet)->time, (*inlet)->discharge, (*inlet)->volume));
  PetscCall(PetscFree(*inlet));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the table ---- */

/* The interval of the table with a time in it; the last of those that begin at it. */
static PetscInt Interval(const MpmInlet *inlet, PetscReal time)
{
  PetscInt low = 0, high = inlet->count - 1;

  while (low + 1 < high) {
    const PetscInt middle = (low + high) / 2;

    if (inlet->time[middle] <= time) low = middle;
    else high = middle;
  }
  return low;
}

static PetscReal Discharge(const MpmInlet *inlet, PetscReal time)
{
  const PetscInt  k    = Interval(inlet, time);
  const PetscReal part = (time - inlet->time[k]) / (inlet->time[k + 1] - inlet->time[k]);

  if (time < inlet->time[0] || time > inlet->time[inlet->count - 1]) return 0.;
  return (1. - part) * inlet->discharge[k] + part * inlet->discharge[k + 1];
}

/* Volume since the first row, m3. */
static PetscReal Volume(const MpmInlet *inlet, PetscReal time)
{
  const PetscInt  k = Interval(inlet, time);
  const PetscReal t = time - inlet->time[k];

  if (time >= inlet->time[inlet->count - 1]) return inlet->volume[inlet->count - 1];
  return inlet->volume[k] + 0.5 * t * (inlet->discharge[k] + Discharge(inlet, time));
}

PetscReal MpmInletVelocity(const MpmInlet *inlet, PetscReal time)
{
  const PetscReal discharge = Discharge(inlet, time);

  if (!(discharge > 0.)) return 0.;
  return inlet->depth > 0. ? discharge / (inlet->width * inlet->depth) : inlet->velocity;
}

PetscReal MpmInletDepth(const MpmInlet *inlet, PetscReal time)
{
  return inlet->depth > 0. ? inlet->depth : Discharge(inlet, time) / (inlet->width * inlet->velocity);
}

/* When the volume has come in, by bisection: it does not fall in time. */
static PetscReal TimeOf(const MpmInlet *inlet, PetscReal volume)
{
  PetscReal low = inlet->time[0], high = inlet->time[inlet->count - 1];

  for (PetscInt k = 0; k < 100 && high - low > PETSC_MACHINE_EPSILON * high; k++) {
    const PetscReal middle = 0.5 * (low + high);

    if (Volume(inlet, middle) < volume) low = middle;
    else high = middle;
  }
  return high;
}

static PetscErrorCode TakeTable(const MpmOptions *block, const char path[], const MpmCsvTable *table, MpmInlet *inlet)
{
  const PetscInt time = MpmCsvTableFind(table, "time"), discharge = MpmCsvTableFind(table, "discharge");

  PetscFunctionBeginUser;
  MpmCheckInput(time >= 0 && discharge >= 0, "-%stable %s: must have the columns time and discharge", block->prefix,
                path);
  MpmCheckInput(table->rows > 1, "-%stable %s: must have two rows or more", block->prefix, path);
  inlet->count = (PetscInt)table->rows;
  PetscCall(PetscMalloc3(inlet->count, &inlet->time, inlet->count, &inlet->discharge, inlet->count, &inlet->volume));
  for (PetscInt k = 0; k < inlet->count; k++) {
    const PetscReal *row = &table->value[k * table->columns];

    inlet->time[k]      = row[time];
    inlet->discharge[k] = row[discharge];
    MpmCheckInput(row[discharge] >= 0., "-%stable %s: discharge %g must be >= 0", block->prefix, path,
                  (double)row[discharge]);
    MpmCheckInput(row[time] >= 0. && (!k || row[time] > inlet->time[k - 1]),
                  "-%stable %s: time %g must be >= 0 and grow from row to row", block->prefix, path, (double)row[time]);
    inlet->volume[k] = k ? inlet->volume[k - 1] +
                             0.5 * (row[time] - inlet->time[k - 1]) * (inlet->discharge[k - 1] + inlet->discharge[k])
                         : 0.;
  }
  MpmCheckInput(inlet->volume[inlet->count - 1] > 0., "-%stable %s: has no discharge", block->prefix, path);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- options ---- */

static PetscErrorCode TakeLine(const MpmOptions *block, const MpmGrid *grid, const PetscReal line[4], MpmInlet *inlet)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < 4; k++)
    MpmCheckInput(line[k] >= grid->lower[k % 2] && line[k] <= grid->upper[k % 2],
                  "-%sline: its end (%g, %g) is out of the grid", block->prefix, (double)line[k / 2 * 2],
                  (double)line[k / 2 * 2 + 1]);
  for (PetscInt a = 0; a < 2; a++) {
    inlet->from[a]  = line[a];
    inlet->along[a] = line[2 + a] - line[a];
  }
  inlet->width = PetscSqrtReal(PetscSqr(inlet->along[0]) + PetscSqr(inlet->along[1]));
  MpmCheckInput(inlet->width > 0., "-%sline: its ends must differ", block->prefix);
  for (PetscInt a = 0; a < 2; a++) inlet->along[a] /= inlet->width;
  inlet->normal[0] = inlet->along[1];
  inlet->normal[1] = -inlet->along[0];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Ends of the line in a file. */
static PetscErrorCode ReadLineFile(const MpmOptions *block, const char path[], PetscReal line[4])
{
  const MpmPlane *plane                    = MpmRecordPlane(block->record);
  MpmOutlineAsk   ask                      = {0};
  MpmOutline      outline                  = {0};
  char            message[MPM_MAP_MESSAGE] = "";

  PetscFunctionBeginUser;
  if (plane) ask = (MpmOutlineAsk){plane->project, plane->system, {plane->origin[0], plane->origin[1]}};
  PetscCall(MpmOutlineRead(path, &ask, &outline, message));
  MpmCheckInput(!message[0], "-%sfile %s: %s", block->prefix, path, message);
  MpmCheckInput(outline.features == 1 && outline.feature[0].type == MPM_OUTLINE_LINE && outline.paths == 1 &&
                  outline.start[1] - outline.start[0] == 2,
                "-%sfile %s: must have one line, of two vertices", block->prefix, path);
  PetscCall(PetscArraycpy(line, outline.at, 4));
  PetscCall(MpmOutlineDestroy(&outline));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadLine(const MpmOptions *block, PetscReal line[4])
{
  PetscBool given;
  char     *path;

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsReals(block, "line", "m",
                            "region hydrograph: ends of the line, x and y of each; material comes from its left",
                            MPM_RANGE_ANY, MPM_OPTIONAL, 4, line, &given));
  PetscCall(MpmOptionsPath(block, "file", "region hydrograph: file of that line, GeoJSON or what GDAL reads",
                           MPM_OPTIONAL, &path));
  MpmCheckInput(given != (path != NULL) || MpmOptionsHelp(), "-%sline or -%sfile: one of them must be given",
                block->prefix, block->prefix);
  if (path && !MpmOptionsHelp()) PetscCall(ReadLineFile(block, path, line));
  PetscCall(PetscFree(path));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadInlet(const MpmOptions *block, const MpmGrid *grid, PetscInt per_cell[2], char **path,
                                MpmInlet *inlet)
{
  PetscReal   line[4]                  = {0.};
  char        message[MPM_CSV_MESSAGE] = "";
  MpmCsvTable table                    = {0};
  PetscBool   fast, deep;

  PetscFunctionBeginUser;
  PetscCall(ReadLine(block, line));
  PetscCall(MpmOptionsPath(block, "table", "region hydrograph: CSV file with the columns time, s, and discharge, m3/s",
                           MPM_REQUIRED, path));
  PetscCall(MpmOptionsReal(block, "speed", "m/s", "region hydrograph: horizontal speed with which material comes in",
                           MPM_RANGE_POSITIVE, MPM_OPTIONAL, &inlet->velocity, &fast));
  PetscCall(MpmOptionsReal(block, "flow_depth", "m",
                           "region hydrograph: vertical depth of what comes in, in place of the speed",
                           MPM_RANGE_POSITIVE, MPM_OPTIONAL, &inlet->depth, &deep));
  if (MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(
    MpmOptionsInts(block, "points_per_cell", "points per cell and axis", 1, 64, MPM_OPTIONAL, 2, per_cell, NULL));
  MpmCheckInput(fast != deep, "-%sspeed or -%sflow_depth: one of them must be given", block->prefix, block->prefix);
  PetscCall(TakeLine(block, grid, line, inlet));
  PetscCall(MpmCsvTableRead(*path, &table, message));
  MpmCheckInput(!message[0], "-%stable %s: %s", block->prefix, *path, message);
  PetscCall(TakeTable(block, *path, &table, inlet));
  PetscCall(MpmCsvTableDestroy(&table));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- rows of columns ---- */

/* The lattice of the columns: length of a row along the flow, m; columns of a row; rows in all. */
typedef struct {
  PetscReal length, half[2];
  PetscInt  across, rows;
} Lattice;

/* The time at which row k has come in; row -1: when the first one begins. */
static PetscReal RowEnd(const MpmInlet *inlet, const Lattice *lattice, PetscInt k)
{
  const PetscReal first = inlet->time[0], last = inlet->time[inlet->count - 1];

  if (k < 0) return first;
  if (k >= lattice->rows - 1) return last;
  if (inlet->depth > 0.) return TimeOf(inlet, (PetscReal)(k + 1) * inlet->width * inlet->depth * lattice->length);
  return first + (PetscReal)(k + 1) * lattice->length / inlet->velocity;
}

static PetscErrorCode FindLattice(const MpmOptions *block, const MpmGrid *grid, const PetscInt per_cell[2],
                                  const MpmInlet *inlet, Lattice *lattice)
{
  const PetscReal time = inlet->time[inlet->count - 1] - inlet->time[0], volume = inlet->volume[inlet->count - 1];
  PetscReal       spacing[2], rows, across = 0.;

  PetscFunctionBeginUser;
  lattice->length = 0.;
  for (PetscInt a = 0; a < 2; a++) {
    spacing[a] = grid->h[a] / (PetscReal)per_cell[a];
    lattice->length += PetscAbsReal(inlet->normal[a]) * spacing[a];
    across += PetscAbsReal(inlet->along[a]) * spacing[a];
  }
  rows = inlet->depth > 0. ? volume / (inlet->width * inlet->depth * lattice->length)
                           : time * inlet->velocity / lattice->length;
  MpmCheckInput(rows < MOST_ROWS, "-%stable: makes %g rows of columns, too many", block->prefix, (double)rows);
  lattice->rows   = PetscMax((PetscInt)PetscCeilReal(rows - SLIVER), 1);
  lattice->across = PetscMax((PetscInt)PetscFloorReal(inlet->width / across + 0.5), 1);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Column j of a row that comes in between two times, unless it has no volume. */
static void MakeColumn(const MpmInlet *inlet, const Lattice *lattice, const PetscReal time[2], PetscInt j,
                       PetscReal density, MpmHandover *handover)
{
  const PetscInt  p      = handover->count;
  const PetscReal volume = Volume(inlet, time[1]) - Volume(inlet, time[0]), lasts = time[1] - time[0];
  const PetscReal length  = inlet->depth > 0. ? volume / (inlet->width * inlet->depth) : inlet->velocity * lasts;
  const PetscReal breadth = inlet->width / (PetscReal)lattice->across, at = breadth * ((PetscReal)j + 0.5);
  const PetscReal mean = 0.5 * PetscSqrtReal(length * breadth);

  if (!(volume > 0.)) return;
  for (PetscInt a = 0; a < 2; a++) {
    const PetscReal n = PetscAbsReal(inlet->normal[a]);

    handover->position[2 * p + a]    = inlet->from[a] + at * inlet->along[a] + 0.5 * length * inlet->normal[a];
    handover->velocity[2 * p + a]    = length / lasts * inlet->normal[a];
    handover->half_length[2 * p + a] = n > 1. - SLIVER ? 0.5 * length : n < SLIVER ? 0.5 * breadth : mean;
  }
  handover->volume[p] = volume / (PetscReal)lattice->across;
  handover->mass[p]   = density * handover->volume[p];
  handover->depth[p]  = volume / (inlet->width * length);
  handover->entry[p]  = time[1];
  handover->count++;
}

/* This rank's share of the columns, row by row. */
static PetscErrorCode Fill(const MpmGrid *grid, const MpmInlet *inlet, const Lattice *lattice, PetscReal density,
                           MpmHandover *handover)
{
  const PetscInt64 all   = (PetscInt64)lattice->rows * lattice->across;
  const PetscInt64 first = all * grid->rank / grid->size, end = all * (grid->rank + 1) / grid->size;
  const size_t     room    = (size_t)(end - first + 1);
  PetscReal        time[2] = {0., 0.};

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(2 * room, &handover->position));
  PetscCall(PetscMalloc1(2 * room, &handover->half_length));
  PetscCall(PetscMalloc1(2 * room, &handover->velocity));
  PetscCall(PetscMalloc1(room, &handover->volume));
  PetscCall(PetscMalloc1(room, &handover->mass));
  PetscCall(PetscMalloc1(room, &handover->depth));
  PetscCall(PetscMalloc1(room, &handover->entry));
  for (PetscInt64 k = first; k < end; k++) {
    const PetscInt row = (PetscInt)(k / lattice->across), column = (PetscInt)(k % lattice->across);

    for (PetscInt e = 0; e < 2 && (k == first || !column); e++) time[e] = RowEnd(inlet, lattice, row - 1 + e);
    MakeColumn(inlet, lattice, time, column, density, handover);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmHandoverHydrograph(const MpmOptions *block, const MpmGrid *grid, PetscReal density,
                                     MpmHandover *handover)
{
  PetscInt   per_cell[2] = {2, 2};
  PetscInt64 count;
  Lattice    lattice;
  MpmInlet  *inlet;
  PetscReal  volume;
  char       text[256];

  PetscFunctionBeginUser;
  MpmCheckInput(grid->dim < MPM_MAX_DIM || MpmOptionsHelp(),
                "-%sregion hydrograph: exists with -mpm_physics depth_averaged only", block->prefix);
  PetscCall(PetscNew(&inlet));
  handover->inlet = inlet;
  PetscCall(ReadInlet(block, grid, per_cell, &handover->path, inlet));
  if (MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(FindLattice(block, grid, per_cell, inlet, &lattice));
  PetscCall(Fill(grid, inlet, &lattice, density, handover));
  handover->later = PETSC_TRUE;
  count           = handover->count;
  volume          = inlet->volume[inlet->count - 1];
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &count, 1, MPIU_INT64, MPI_SUM, block->comm));
  PetscCall(PetscSNPrintf(text, sizeof(text), "%lld columns come in with %g m3 until %g s", (long long)count,
                          (double)volume, (double)inlet->time[inlet->count - 1]));
  PetscCall(PetscStrallocpy(text, &handover->line));
  PetscCall(
    PetscSNPrintf(text, sizeof(text), "\"columns\": %lld, \"volume\": %.17g", (long long)count, (double)volume));
  PetscCall(PetscStrallocpy(text, &handover->entries));
  PetscFunctionReturn(PETSC_SUCCESS);
}

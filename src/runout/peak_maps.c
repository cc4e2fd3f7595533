/*
  Maps of flow on the terrain's pixels, or on the cells of the grid where the bed is a plane: bilinear between the nodes
  at the centres of the pixels. Where a pixel is larger than a cell, the largest values are those of all nodes in it.
*/
#include "maps/bed.h"
#include "space/space.h"
#include "runout/runout_impl.h"

#define MOST_BANDS 40
#define BAND_NAME  40

/* Bands of a map in the making. Rank 0 has the pixels, other ranks none. */
typedef struct {
  MpmMap     like;
  PetscInt   count, pixels;
  char       name[MOST_BANDS][BAND_NAME];
  PetscReal *value[MOST_BANDS];
} Bands;

PetscBool MpmLatticeCorners(const MpmGrid *grid, const PetscReal x[], PetscInt *first, PetscReal weight[4])
{
  PetscReal part[2];
  PetscInt  cell[2];

  for (PetscInt a = 0; a < 2; a++) {
    const PetscReal s = (x[a] - grid->lower[a]) / grid->h[a];

    if (s < -MPM_GRID_SLACK || s > (PetscReal)grid->cells[a] + MPM_GRID_SLACK) return PETSC_FALSE;
    cell[a] = PetscClipInterval((PetscInt)s, 0, grid->cells[a] - 1);
    part[a] = s - (PetscReal)cell[a];
  }
  *first = cell[0] + grid->nodes[0] * cell[1];
  for (PetscInt k = 0; k < 4; k++) weight[k] = (k % 2 ? part[0] : 1. - part[0]) * (k / 2 ? part[1] : 1. - part[1]);
  return PETSC_TRUE;
}

PetscReal MpmLatticeAt(const MpmGrid *grid, const PetscReal field[], const PetscReal x[])
{
  PetscReal weight[4], value = 0.;
  PetscInt  first;

  if (!MpmLatticeCorners(grid, x, &first, weight)) return NAN;
  for (PetscInt k = 0; k < 4; k++) value += weight[k] * field[first + k % 2 + grid->nodes[0] * (k / 2)];
  return value;
}

/* Mean time at the nodes about a place that have been reached. */
static PetscReal ArrivalAt(const MpmGrid *grid, const PetscReal arrival[], const PetscReal x[])
{
  PetscReal weight[4], sum = 0., time = 0.;
  PetscInt  first;

  if (!MpmLatticeCorners(grid, x, &first, weight)) return NAN;
  for (PetscInt k = 0; k < 4; k++) {
    const PetscReal at = arrival[first + k % 2 + grid->nodes[0] * (k / 2)];

    if (at == PETSC_MAX_REAL) continue;
    sum += weight[k];
    time += weight[k] * at;
  }
  return sum > 0. ? time / sum : NAN;
}

/* The largest value at a pixel's centre and at the nodes in it. */
static PetscReal LargestAt(const MpmGrid *grid, const PetscReal field[], const MpmMap *map, const PetscReal x[])
{
  PetscReal largest = MpmLatticeAt(grid, field, x);
  PetscInt  from[2], to[2];

  if (PetscIsNanReal(largest)) return largest;
  for (PetscInt a = 0; a < 2; a++) {
    const PetscReal s = (x[a] - grid->lower[a]) / grid->h[a], half = 0.5 * map->cell[a] / grid->h[a];

    if (half <= 0.5 + MPM_GRID_SLACK) return largest;
    from[a] = PetscMax((PetscInt)PetscCeilReal(s - half), 0);
    to[a]   = PetscMin((PetscInt)PetscFloorReal(s + half), grid->cells[a]);
  }
  for (PetscInt j = from[1]; j <= to[1]; j++)
    for (PetscInt i = from[0]; i <= to[0]; i++) largest = PetscMax(largest, field[i + grid->nodes[0] * j]);
  return largest;
}

static void Centre(const MpmMap *map, PetscInt k, PetscReal x[2])
{
  x[0] = map->x0 + (PetscReal)(k % map->columns) * map->cell[0];
  x[1] = map->y0 + (PetscReal)(k / map->columns) * map->cell[1];
}

/* The pixels, without bands. */
static PetscErrorCode BandsCreate(MpmModel model, Bands *bands)
{
  const MpmBed  *bed  = model->scene.deformation.bed;
  const MpmGrid *grid = model->disc.grid;

  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(bands, sizeof(*bands)));
  if (bed->map.value) PetscCall(MpmMapLike(&bed->map, &bands->like));
  else {
    bands->like = (MpmMap){.columns = grid->cells[0],
                           .rows    = grid->cells[1],
                           .x0      = grid->lower[0] + 0.5 * grid->h[0],
                           .y0      = grid->lower[1] + 0.5 * grid->h[1],
                           .cell    = {grid->h[0], grid->h[1]},
                           .none    = -9999.};
  }
  bands->pixels = model->rank ? 0 : bands->like.columns * bands->like.rows;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode BandsDestroy(Bands *bands)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < bands->count; k++) PetscCall(PetscFree(bands->value[k]));
  PetscCall(MpmMapDestroy(&bands->like));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode AddBand(Bands *bands, const char name[], PetscReal **value)
{
  PetscFunctionBeginUser;
  PetscCall(PetscStrncpy(bands->name[bands->count], name, BAND_NAME));
  PetscCall(PetscMalloc1(bands->pixels, value));
  bands->value[bands->count++] = *value;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A field of the grid's nodes; or the largest of it. */
static PetscErrorCode AddField(const MpmGrid *grid, const char name[], PetscBool largest, const PetscReal field[],
                               Bands *bands)
{
  PetscReal *value;

  PetscFunctionBeginUser;
  PetscCall(AddBand(bands, name, &value));
  for (PetscInt k = 0; k < bands->pixels; k++) {
    PetscReal x[2];

    Centre(&bands->like, k, x);
    value[k] = largest ? LargestAt(grid, field, &bands->like, x) : MpmLatticeAt(grid, field, x);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The bed, and its change where there is erosion or deposition. */
static PetscErrorCode AddBed(const MpmBed *bed, Bands *bands)
{
  PetscReal *value, *change = NULL, x[2];

  PetscFunctionBeginUser;
  PetscCall(AddBand(bands, "bed", &value));
  if (bed->change.value) PetscCall(AddBand(bands, "bed_change", &change));
  for (PetscInt k = 0; k < bands->pixels; k++) {
    Centre(&bands->like, k, x);
    value[k] = MpmBedHeight(bed, x);
    if (change) change[k] = MpmMapAt(&bed->change, x);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The last band, a vertical depth, once more, normal to the bed. */
static PetscErrorCode AddNormal(const MpmBed *bed, const char name[], Bands *bands)
{
  const PetscReal *depth = bands->value[bands->count - 1];
  PetscReal       *value, x[2];

  PetscFunctionBeginUser;
  PetscCall(AddBand(bands, name, &value));
  for (PetscInt k = 0; k < bands->pixels; k++) {
    PetscReal steep = 0.;

    Centre(&bands->like, k, x);
    for (PetscInt a = 0; a < 2; a++) {
      const PetscReal way = bands->like.cell[a], at = x[a];
      PetscReal       rise;

      x[a] = at + 0.5 * way;
      rise = MpmBedHeight(bed, x);
      x[a] = at - 0.5 * way;
      rise -= MpmBedHeight(bed, x);
      x[a] = at;
      if (!PetscIsNanReal(rise)) steep += PetscSqr(rise / way);
    }
    value[k] = depth[k] / PetscSqrtReal(1. + steep);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Field k of several; NULL of none. */
static const PetscReal *Part(const PetscReal fields[], PetscInt k, PetscInt count)
{
  return fields ? &fields[k * count] : NULL;
}

static PetscErrorCode Write(MpmModel model, const char stem[], Bands *bands)
{
  const char    *names[MOST_BANDS];
  PetscReal     *values[MOST_BANDS];
  PetscErrorCode written;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < bands->count; k++) {
    names[k]  = bands->name[k];
    values[k] = bands->value[k];
  }
  written = MpmMapWrite(model->comm, stem, &bands->like, bands->count, names, (const PetscReal *const *)values);
  PetscCall(BandsDestroy(bands));
  PetscCall(written);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Fields of the state that was observed last, at the grid's nodes, on rank 0. To be freed. */
enum { STATE_DEPTH, STATE_SPEED, STATE_X, STATE_Y, STATE_PRESSURE, STATE_COUNT };

static PetscErrorCode GatherState(MpmModel model, PetscReal **fields)
{
  const PetscInt nodes = model->disc.grid->nodes[0] * model->disc.grid->nodes[1];
  PetscReal     *own;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1((size_t)nodes * STATE_COUNT, &own));
  for (PetscInt i = 0; i < model->disc.space->owned; i++) {
    PetscReal  *at = &own[MpmRunoutLatticeNode(model, i)];
    MpmNodeFlow flow;

    MpmRunoutNode(model, i, &flow);
    at[STATE_DEPTH * nodes]    = flow.depth;
    at[STATE_SPEED * nodes]    = flow.speed;
    at[STATE_X * nodes]        = flow.velocity[0];
    at[STATE_Y * nodes]        = flow.velocity[1];
    at[STATE_PRESSURE * nodes] = flow.pressure;
  }
  for (PetscInt k = 0; k < STATE_COUNT; k++)
    PetscCallMPI(MPI_Reduce(model->rank ? &own[k * nodes] : MPI_IN_PLACE, &own[k * nodes], (PetscMPIInt)nodes,
                            MPIU_REAL, MPIU_SUM, 0, model->comm));
  *fields = own;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmRunoutWriteState(MpmModel model)
{
  static const char *const names[STATE_COUNT] = {"depth", "speed", "velocity_x", "velocity_y", "pressure"};
  const MpmBed            *bed                = model->scene.deformation.bed;
  const MpmGrid           *grid               = model->disc.grid;
  const PetscInt           nodes              = grid->nodes[0] * grid->nodes[1];
  PetscReal               *fields;
  Bands                    bands;
  char                     stem[PETSC_MAX_PATH_LEN];

  PetscFunctionBeginUser;
  PetscCall(GatherState(model, &fields));
  PetscCall(BandsCreate(model, &bands));
  for (PetscInt k = 0; k < STATE_COUNT; k++) {
    PetscCall(AddField(grid, names[k], PETSC_FALSE, &fields[k * nodes], &bands));
    if (!k) PetscCall(AddNormal(bed, "depth_normal", &bands));
  }
  PetscCall(AddBed(bed, &bands));
  PetscCall(PetscFree(fields));
  PetscCall(PetscSNPrintf(stem, sizeof(stem), "%s_%06" PetscInt_FMT, model->scene.name.prefix, model->runout->seen));
  PetscCall(Write(model, stem, &bands));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Times of arrival where the largest depth, the first band, is beyond a threshold. */
static PetscErrorCode AddArrival(const MpmGrid *grid, PetscReal threshold, const PetscReal arrival[], Bands *bands)
{
  char       name[BAND_NAME];
  PetscReal *value, x[2];

  PetscFunctionBeginUser;
  PetscCall(PetscSNPrintf(name, sizeof(name), "arrival_%g", (double)threshold));
  PetscCall(AddBand(bands, name, &value));
  for (PetscInt k = 0; k < bands->pixels; k++) {
    Centre(&bands->like, k, x);
    value[k] = bands->value[0][k] > threshold ? ArrivalAt(grid, arrival, x) : NAN;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmRunoutWritePeaks(MpmModel model)
{
  static const char *const names[MPM_PEAK_COUNT] = {"depth", "speed", "pressure"};
  const MpmPeaks          *peaks                 = &model->runout->peaks;
  const MpmBed            *bed                   = model->scene.deformation.bed;
  const MpmGrid           *grid                  = model->disc.grid;
  PetscReal               *largest, *arrival, *last;
  Bands                    bands;
  char                     stem[PETSC_MAX_PATH_LEN];

  PetscFunctionBeginUser;
  PetscCall(MpmPeaksGather(model, &largest, &arrival));
  PetscCall(GatherState(model, &last));
  PetscCall(BandsCreate(model, &bands));
  for (PetscInt k = 0; k < MPM_PEAK_COUNT; k++) {
    PetscCall(AddField(grid, names[k], PETSC_TRUE, Part(largest, k, peaks->count), &bands));
    if (!k) PetscCall(AddNormal(bed, "depth_normal", &bands));
  }
  for (PetscInt k = 0; k < peaks->depths; k++)
    PetscCall(AddArrival(grid, peaks->depth ? peaks->depth[k] : peaks->least, Part(arrival, k, peaks->count), &bands));
  PetscCall(AddField(grid, "deposit", PETSC_FALSE, last, &bands));
  PetscCall(AddNormal(bed, "deposit_normal", &bands));
  PetscCall(AddBed(bed, &bands));
  PetscCall(PetscFree(largest));
  PetscCall(PetscFree(arrival));
  PetscCall(PetscFree(last));
  PetscCall(PetscSNPrintf(stem, sizeof(stem), "%s_peak", model->scene.name.prefix));
  PetscCall(Write(model, stem, &bands));
  PetscFunctionReturn(PETSC_SUCCESS);
}

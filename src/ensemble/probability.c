/*
  Maps of probabilities and quantiles, from the maps of the largest values that the members have written.

  PREFIX_probability  share of members whose largest value is above a threshold, a band for each
  PREFIX_quantiles    quantiles of the largest values over the members, pixel by pixel

  Rows of pixels are worked on in bands of them that fit a given memory, with all members at once.
*/
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>
#include "maps/map.h"
#include "ensemble/ensemble.h"

#define MEMORY     256e6 /* bytes of values of all members */
#define QUANTITIES 3
#define BAND_NAME  64

const char *const     MpmMapQuantities[]   = {"depth", "speed", "pressure", NULL};
static const PetscInt bands_of[QUANTITIES] = {1, 3, 4}; /* in the members' maps of peaks */

/* Maps in the making, on the first rank. */
typedef struct {
  const MpmEnsemble *ensemble;
  MpmMap             like;
  PetscInt           done; /* members with maps */
  char (*path)[PETSC_MAX_PATH_LEN];
  PetscReal  *values;      /* [pixel*done + member], of a stripe */
  PetscReal **probability; /* by threshold */
  PetscReal **quantile;    /* [quantity*quantiles + k] */
  char        message[MPM_MAP_MESSAGE];
  char        fault[MPM_MAP_MESSAGE]; /* with the name of the file */
} Maps;

/* The file that has a quantity of a member; false where there is none. */
static PetscBool FindFile(const MpmModel model, PetscInt member, PetscInt quantity, char path[PETSC_MAX_PATH_LEN])
{
  char prefix[PETSC_MAX_PATH_LEN];

  MpmMemberPrefix(model, member, prefix);
  (void)snprintf(path, PETSC_MAX_PATH_LEN, "%.4000s_peak.tif", prefix);
  if (!access(path, R_OK)) return PETSC_TRUE;
  (void)snprintf(path, PETSC_MAX_PATH_LEN, "%.4000s_peak_%s.asc", prefix, MpmMapQuantities[quantity]);
  return (PetscBool)!access(path, R_OK);
}

/* Band and margin of a file. */
static MpmMapAsk Ask(const char path[], PetscInt quantity)
{
  const size_t length = strlen(path);

  return (MpmMapAsk){.band = strcmp(&path[length - 4], ".tif") ? 1 : bands_of[quantity], .margin = 1};
}

/* Files of all members, and the pixels of the first. */
static PetscErrorCode FindFiles(const MpmModel model, const MpmMember members[], PetscInt quantity, Maps *maps)
{
  PetscFunctionBeginUser;
  maps->done = 0;
  for (PetscInt m = 0; m < model->ensemble->members; m++)
    if (members[m].run && !members[m].status && FindFile(model, m, quantity, maps->path[maps->done])) maps->done++;
  if (maps->done && !maps->like.columns) {
    MpmMapAsk ask = Ask(maps->path[0], quantity);

    ask.frame = PETSC_TRUE;
    PetscCall(MpmMapRead(maps->path[0], &ask, &maps->like, maps->message));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Rows of one member's map into the values. */
static PetscErrorCode ReadStripe(PetscInt quantity, PetscInt first, PetscInt rows, PetscInt member, Maps *maps)
{
  const MpmMap   *like     = &maps->like;
  const PetscReal lower[2] = {like->x0, like->y0 + (PetscReal)first * like->cell[1]};
  const PetscReal upper[2] = {like->x0 + (PetscReal)(like->columns - 1) * like->cell[0],
                              like->y0 + (PetscReal)(first + rows - 1) * like->cell[1]};
  MpmMapAsk       ask      = Ask(maps->path[member], quantity);
  MpmMap          map      = {0};
  PetscInt        shift;

  PetscFunctionBeginUser;
  ask.lower = lower;
  ask.upper = upper;
  PetscCall(MpmMapRead(maps->path[member], &ask, &map, maps->message));
  if (maps->message[0]) PetscFunctionReturn(MpmMapDestroy(&map));
  shift = (PetscInt)PetscFloorReal((lower[1] - map.y0) / map.cell[1] + 0.5);
  if (map.columns != like->columns || PetscAbsReal(map.x0 - like->x0) > 0.01 * like->cell[0] || shift < 0 ||
      shift + rows > map.rows)
    (void)snprintf(maps->message, MPM_MAP_MESSAGE, "has other pixels than the first member's map");
  for (PetscInt k = 0; k < rows * like->columns && !maps->message[0]; k++)
    maps->values[(size_t)k * (size_t)maps->done + (size_t)member] =
      map.value[(size_t)shift * (size_t)map.columns + (size_t)k];
  PetscCall(MpmMapDestroy(&map));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Members that have data at a pixel, sorted; their number. */
static PetscErrorCode SortPixel(PetscInt count, PetscReal values[], PetscInt *there)
{
  PetscFunctionBeginUser;
  *there = 0;
  for (PetscInt m = 0; m < count; m++)
    if (!PetscIsNanReal(values[m])) values[(*there)++] = values[m];
  PetscCall(PetscSortReal(*there, values));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Share of sorted values above a threshold. */
static PetscReal ShareAbove(PetscInt count, const PetscReal sorted[], PetscReal threshold)
{
  PetscInt below = 0;

  while (below < count && sorted[below] <= threshold) below++;
  return (PetscReal)(count - below) / (PetscReal)count;
}

/* Bands of a quantity at pixels from `first` on. */
static PetscErrorCode Evaluate(PetscInt quantity, size_t first, PetscInt pixels, Maps *maps)
{
  const MpmEnsembleAsk *ask = &maps->ensemble->ask;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < pixels; k++) {
    PetscReal *values = &maps->values[(size_t)k * (size_t)maps->done];
    PetscInt   there;

    PetscCall(SortPixel(maps->done, values, &there));
    for (PetscInt t = 0; t < ask->threshold_count; t++)
      if (ask->thresholds[t].quantity == quantity)
        maps->probability[t][first + (size_t)k] =
          there ? ShareAbove(there, values, ask->thresholds[t].value) : (PetscReal)NAN;
    for (PetscInt q = 0; q < ask->quantile_count; q++)
      maps->quantile[quantity * ask->quantile_count + q][first + (size_t)k] =
        there ? MpmQuantileOf(there, values, ask->quantiles[q]) : (PetscReal)NAN;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* All rows of a quantity, stripe by stripe. */
static PetscErrorCode FindQuantity(PetscInt quantity, Maps *maps)
{
  const PetscReal row    = (PetscReal)maps->like.columns * (PetscReal)maps->done * (PetscReal)sizeof(PetscReal);
  const PetscInt  stripe = (PetscInt)PetscClipInterval(MEMORY / row, 1., (PetscReal)maps->like.rows);

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1((size_t)stripe * (size_t)maps->like.columns * (size_t)maps->done, &maps->values));
  for (PetscInt first = 0; first < maps->like.rows && !maps->message[0]; first += stripe) {
    const PetscInt rows = PetscMin(stripe, maps->like.rows - first);

    for (PetscInt m = 0; m < maps->done && !maps->message[0]; m++) {
      PetscCall(ReadStripe(quantity, first, rows, m, maps));
      if (maps->message[0]) PetscCall(PetscStrncpy(maps->path[0], maps->path[m], PETSC_MAX_PATH_LEN));
    }
    if (!maps->message[0])
      PetscCall(Evaluate(quantity, (size_t)first * (size_t)maps->like.columns, rows * maps->like.columns, maps));
  }
  PetscCall(PetscFree(maps->values));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Room for the bands. */
static PetscErrorCode MapsSetUp(Maps *maps)
{
  const MpmEnsembleAsk *ask    = &maps->ensemble->ask;
  const size_t          pixels = (size_t)maps->like.columns * (size_t)maps->like.rows;

  PetscFunctionBeginUser;
  for (PetscInt t = 0; t < ask->threshold_count; t++) PetscCall(PetscMalloc1(pixels, &maps->probability[t]));
  for (PetscInt q = 0; q < QUANTITIES * ask->quantile_count; q++) PetscCall(PetscMalloc1(pixels, &maps->quantile[q]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* All bands, on the first rank. */
static PetscErrorCode FindBands(const MpmModel model, const MpmMember members[], Maps *maps)
{
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(model->ensemble->members, &maps->path));
  for (PetscInt k = 0; k < QUANTITIES && !maps->message[0]; k++) {
    PetscCall(FindFiles(model, members, k, maps));
    if (!maps->done || maps->message[0]) break;
    if (!k) PetscCall(MapsSetUp(maps));
    PetscCall(FindQuantity(k, maps));
  }
  if (maps->message[0]) (void)snprintf(maps->fault, sizeof(maps->fault), "%.300s %.200s", maps->path[0], maps->message);
  PetscCall(PetscFree(maps->path));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes the bands of either kind under their names. */
static PetscErrorCode WriteBands(const MpmModel model, const Maps *maps, const char kind[], PetscInt count,
                                 char (*names)[BAND_NAME], PetscReal *const values[])
{
  const char **list;
  char         stem[PETSC_MAX_PATH_LEN];

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(count, &list));
  for (PetscInt k = 0; k < count; k++) list[k] = names[k];
  PetscCall(PetscSNPrintf(stem, sizeof(stem), "%s_%s", model->scene.name.prefix, kind));
  PetscCall(MpmMapWrite(model->comm, stem, &maps->like, count, list, (const PetscReal *const *)values));
  PetscCall(PetscFree(list));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode WriteAll(const MpmModel model, const Maps *maps)
{
  const MpmEnsembleAsk *ask   = &maps->ensemble->ask;
  const PetscInt        count = QUANTITIES * ask->quantile_count;
  char(*names)[BAND_NAME];

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(PetscMax(count, ask->threshold_count), &names));
  for (PetscInt t = 0; t < ask->threshold_count; t++)
    (void)snprintf(names[t], BAND_NAME, "%s_above_%g", MpmMapQuantities[ask->thresholds[t].quantity],
                   (double)ask->thresholds[t].value);
  if (ask->threshold_count)
    PetscCall(WriteBands(model, maps, "probability", ask->threshold_count, names, maps->probability));
  for (PetscInt k = 0; k < count; k++)
    (void)snprintf(names[k], BAND_NAME, "%s_%g", MpmMapQuantities[k / ask->quantile_count],
                   (double)ask->quantiles[k % ask->quantile_count]);
  PetscCall(WriteBands(model, maps, "quantiles", count, names, maps->quantile));
  PetscCall(PetscFree(names));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmEnsembleWriteMaps(MpmModel model, const MpmMember members[])
{
  const MpmEnsembleAsk *ask  = &model->ensemble->ask;
  Maps                  maps = {.ensemble = model->ensemble};

  PetscFunctionBeginUser;
  if (!model->scene.deformation.bed) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(
    PetscCalloc2(ask->threshold_count, &maps.probability, QUANTITIES * (size_t)ask->quantile_count, &maps.quantile));
  if (!model->rank) PetscCall(FindBands(model, members, &maps));
  PetscCallMPI(MPI_Bcast(&maps.done, 1, MPIU_INT, 0, model->comm));
  PetscCallMPI(MPI_Bcast(maps.fault, sizeof(maps.fault), MPI_CHAR, 0, model->comm));
  MpmCheckInput(!maps.fault[0], "-mpm_task ensemble: %s", maps.fault);
  if (maps.done) PetscCall(WriteAll(model, &maps));
  for (PetscInt t = 0; t < ask->threshold_count; t++) PetscCall(PetscFree(maps.probability[t]));
  for (PetscInt q = 0; q < QUANTITIES * ask->quantile_count; q++) PetscCall(PetscFree(maps.quantile[q]));
  PetscCall(PetscFree2(maps.probability, maps.quantile));
  PetscCall(MpmMapDestroy(&maps.like));
  PetscFunctionReturn(PETSC_SUCCESS);
}

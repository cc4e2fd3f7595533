/*
  Restarting from a checkpoint, on any number of ranks.

  On as many ranks as before every point goes back to its rank and its place there, and the partition is as it was: sums
  are made in the same order. On another number the points are redistributed and stand by their ids.
*/
#include <stdlib.h>
#include <strings.h>
#include "files/hdf5_rows.h"
#include "io/io.h"
#include "grid/partition.h"
#include "particles/particles.h"
#include "space/rules.h"
#include "volume/added_term.h"
#include "volume/background.h"
#include "query/model.h"
#include "step/moving_grid.h"
#include "schedule/reduction.h"
#include "schedule/rescue.h"
#include "schedule/schedule.h"
#include "schedule/stage.h"
#include "entrainment/entrainment.h"
#include "runout/runout.h"
#include "observe/results.h"
#include "checkpoint/checkpoint.h"

struct _p_MpmRestart {
  char        *path;
  PetscBool    together; /* all ranks read the points, otherwise rank 0 alone */
  PetscInt     points;
  MpmRowValues values;
  MpmTextFile  scene, partition, history, results, index, grid_index; /* the last three: rank 0 */
};

PetscErrorCode MpmRestartDestroy(MpmRestart *handle)
{
  MpmRestart restart = *handle;

  PetscFunctionBeginUser;
  if (!restart) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscFree(restart->path));
  PetscCall(MpmRowValuesDestroy(&restart->values));
  PetscCall(MpmTextFileDestroy(&restart->scene));
  PetscCall(MpmTextFileDestroy(&restart->partition));
  PetscCall(MpmTextFileDestroy(&restart->results));
  PetscCall(MpmTextFileDestroy(&restart->index));
  PetscCall(MpmTextFileDestroy(&restart->grid_index));
  PetscCall(MpmTextFileDestroy(&restart->history));
  PetscCall(PetscFree(*handle));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- HDF5 ---- */

/* The group of the points in a file that is only read; negative where there is none. Both are to be closed. */
static hid_t OpenPoints(const char *path, hid_t *file)
{
  *file = MpmHdf5Open(path);
  return *file >= 0 && H5Lexists(*file, "points", H5P_DEFAULT) > 0 ? H5Gopen2(*file, "points", H5P_DEFAULT)
                                                                   : H5I_INVALID_HID;
}

static PetscBool ReadAttribute(hid_t group, const char *name, hid_t type, void *value)
{
  hid_t     attribute;
  PetscBool read;

  if (H5Aexists(group, name) <= 0) return PETSC_FALSE;
  attribute = H5Aopen(group, name, H5P_DEFAULT);
  read      = (PetscBool)(attribute >= 0 && H5Aread(attribute, type, value) >= 0);
  if (attribute >= 0) (void)H5Aclose(attribute);
  return read;
}

/* Bytes that rank 0 reads, and all get where they are `shared`. */
static PetscErrorCode ReadBytes(MpmModel model, hid_t group, const char *name, PetscBool shared, MpmTextFile *text)
{
  PetscInt64 extent[2] = {0, 0}, size;

  PetscFunctionBeginUser;
  if (!model->rank) MpmHdf5Extent(group, name, extent);
  size = extent[0];
  PetscCallMPI(MPI_Bcast(&size, 1, MPIU_INT64, 0, model->comm));
  MpmCheckInput(size >= 0, "-mpm_restart %s: it has no %s", model->results->checkpoint.restart->path, name);
  if (model->rank && !shared) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmTextFileReserve(text, (size_t)size));
  if (!model->rank && !MpmHdf5ReadRows(group, name, H5T_NATIVE_UCHAR, 0, size, 1, text->data)) size = 0;
  if (shared) PetscCallMPI(MPI_Bcast(text->data, (PetscMPIInt)size, MPI_CHAR, 0, model->comm));
  text->data[size] = 0;
  text->length     = (size_t)size;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Data of parts of the model beside points and numbers. */
static PetscErrorCode ReadParts(MpmModel model, hid_t group)
{
  PetscFunctionBeginUser;
  if (MpmRunoutHasPeaks(model)) {
    MpmTextFile peaks = MPM_TEXT_FILE_EMPTY;

    PetscCall(ReadBytes(model, group, "peaks", PETSC_FALSE, &peaks));
    PetscCall(MpmRunoutLoad(model, &peaks));
    PetscCall(MpmTextFileDestroy(&peaks));
  }
  if (MpmEntrainmentHasChange(model)) {
    MpmTextFile bed = MPM_TEXT_FILE_EMPTY;

    PetscCall(ReadBytes(model, group, "bed", PETSC_FALSE, &bed));
    PetscCall(MpmEntrainmentLoad(model, &bed));
    PetscCall(MpmTextFileDestroy(&bed));
  }
  if (model->scene.terms->backgrounds) {
    MpmTextFile bytes = MPM_TEXT_FILE_EMPTY;

    PetscCall(ReadBytes(model, group, "backgrounds", PETSC_FALSE, &bytes));
    PetscCall(MpmBackgroundsLoad(model->scene.terms->backgrounds, model->comm, &bytes));
    PetscCall(MpmTextFileDestroy(&bytes));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* All but the points. */
static PetscErrorCode ReadBeside(MpmModel model, MpmRestart restart)
{
  MpmRowValues *values    = &restart->values;
  PetscInt64    extent[2] = {-1, -1}, points;
  hid_t         file = H5I_INVALID_HID, group = H5I_INVALID_HID;

  PetscFunctionBeginUser;
  PetscCall(MpmStateSave(&model->state, values));
  if (!model->rank) {
    group = OpenPoints(restart->path, &file);
    if (group >= 0) MpmHdf5Extent(group, "id", extent);
    for (PetscInt k = 0; k < values->count && group >= 0; k++) {
      double    real;
      long long integer;

      values->there[k] = ReadAttribute(group, values->name[k], values->real[k] ? H5T_NATIVE_DOUBLE : H5T_NATIVE_LLONG,
                                       values->real[k] ? (void *)&real : (void *)&integer);
      if (values->there[k] && values->real[k]) values->value[k] = (PetscReal)real;
      if (values->there[k] && !values->real[k]) values->number[k] = (PetscInt64)integer;
    }
  }
  points = extent[0];
  PetscCallMPI(MPI_Bcast(&points, 1, MPIU_INT64, 0, model->comm));
  MpmCheckInput(points > 0 && points <= PETSC_INT_MAX, "-mpm_restart %s: its points cannot be read", restart->path);
  restart->points = (PetscInt)points;
  PetscCallMPI(MPI_Bcast(values->there, (PetscMPIInt)values->count, MPM_MPI_BOOL, 0, model->comm));
  PetscCallMPI(MPI_Bcast(values->value, (PetscMPIInt)values->count, MPIU_REAL, 0, model->comm));
  PetscCallMPI(MPI_Bcast(values->number, (PetscMPIInt)values->count, MPIU_INT64, 0, model->comm));
  PetscCall(ReadBytes(model, group, "scene", PETSC_TRUE, &restart->scene));
  PetscCall(ReadBytes(model, group, "partition", PETSC_TRUE, &restart->partition));
  PetscCall(ReadBytes(model, group, "history", PETSC_TRUE, &restart->history));
  model->results->checkpoint.path      = restart->path;
  model->results->checkpoint.histories = restart->history.data;
  PetscCall(ReadBytes(model, group, "results", PETSC_FALSE, &restart->results));
  PetscCall(ReadBytes(model, group, "results_index", PETSC_FALSE, &restart->index));
  PetscCall(ReadBytes(model, group, "results_grid_index", PETSC_FALSE, &restart->grid_index));
  PetscCall(ReadParts(model, group));
  if (group >= 0) (void)H5Gclose(group);
  if (file >= 0) (void)H5Fclose(file);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- choice of the checkpoint, and comparison with this scene ---- */

/* The newest that is whole; each that is not is reported. */
static PetscErrorCode FindLatest(MpmModel model, char path[PETSC_MAX_PATH_LEN], MpmCheckpointHead *head)
{
  const PetscInt64 collective = (PetscInt64)PetscMin(model->results->checkpoint.collective, 1e18);
  PetscInt         count, found                    = -1;
  char           **paths, reason[MPM_OUTCOME_TEXT] = "";
  MpmOutcome       outcome;

  PetscFunctionBeginUser;
  PetscCall(MpmCheckpointList(model->comm, model->scene.name.prefix, &count, &paths));
  for (PetscInt k = 0; k < count && found < 0; k++) {
    PetscCall(MpmCheckpointVerify(model->comm, paths[k], collective, head, &outcome));
    if (!outcome.code) found = k;
    else if (k + 1 < count)
      PetscCall(MpmTerminalWarn(model, "%s: %s; the one before it is tried", paths[k], outcome.text));
    PetscCall(PetscStrncpy(path, paths[k], PETSC_MAX_PATH_LEN));
    PetscCall(PetscStrncpy(reason, outcome.text, sizeof(reason)));
  }
  PetscCall(MpmNamesDestroy(count, &paths));
  MpmCheckInput(count, "-mpm_restart latest: there is no checkpoint %s_checkpoint.h5", model->scene.name.prefix);
  MpmCheckInput(found >= 0, "-mpm_restart latest: %s: %s", path, reason);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The value of an option in a scene's text, or NULL; `length` is that of the name. */
static const char *SceneValue(const char *scene, const char *name, size_t length, size_t *value_length)
{
  for (const char *line = scene; *line; line = strchr(line, '\n') + 1) {
    if (strncasecmp(line, name, length) || line[length] != ' ') continue;
    *value_length = strcspn(line + length + 1, "\n");
    return line + length + 1;
  }
  return NULL;
}

/* Every option of one scene must have its value in the other. */
static PetscErrorCode CompareScenes(const char *path, const char *saved, const char *present)
{
  PetscFunctionBeginUser;
  for (const char *line = saved; *line; line = strchr(line, '\n') + 1) {
    const size_t name = strcspn(line, " "), before = strcspn(line + name + 1, "\n");
    size_t       now   = 0;
    const char  *value = SceneValue(present, line, name, &now);

    MpmCheckInput(value, "-mpm_restart %s: it is of another scene: it has -%.*s, which is not given here", path,
                  (int)name, line);
    MpmCheckInput(now == before && !strncmp(value, line + name + 1, now),
                  "-mpm_restart %s: it is of another scene: -%.*s is %.*s there and %.*s here", path, (int)name, line,
                  (int)before, line + name + 1, (int)now, value);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Options that are given here and have no value there; defaults of a newer version do not count. */
static PetscErrorCode CheckScene(MpmModel model, MpmRestart restart)
{
  MpmTextFile present;

  PetscFunctionBeginUser;
  PetscCall(MpmCheckpointScene(model, PETSC_FALSE, &present));
  PetscCall(CompareScenes(restart->path, restart->scene.data, present.data));
  PetscCall(MpmTextFileDestroy(&present));
  PetscCall(MpmCheckpointScene(model, PETSC_TRUE, &present));
  for (const char *line = present.data; *line; line = strchr(line, '\n') + 1) {
    const size_t name = strcspn(line, " ");
    size_t       length;

    MpmCheckInput(SceneValue(restart->scene.data, line, name, &length),
                  "-mpm_restart %s: it is of another scene: it does not have -%.*s", restart->path, (int)name, line);
  }
  PetscCall(MpmTextFileDestroy(&present));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmRestartOpen(MpmModel model)
{
  const PetscInt64  collective = (PetscInt64)PetscMin(model->results->checkpoint.collective, 1e18);
  const char       *from       = model->results->checkpoint.from;
  char              path[PETSC_MAX_PATH_LEN];
  MpmOutcome        outcome;
  MpmCheckpointHead head;
  MpmRestart        restart;

  PetscFunctionBeginUser;
  if (!from) PetscFunctionReturn(PETSC_SUCCESS);
  if (!strcmp(from, "latest")) PetscCall(FindLatest(model, path, &head));
  else {
    PetscCall(PetscStrncpy(path, from, sizeof(path)));
    PetscCall(MpmCheckpointVerify(model->comm, path, collective, &head, &outcome));
    MpmCheckInput(!outcome.code, "-mpm_restart %s: %s", path, outcome.text);
  }
  PetscCall(PetscNew(&restart));
  model->results->checkpoint.restart = restart;
  restart->together                  = (PetscBool)(head.size >= collective && model->size > 1);
  PetscCall(PetscStrallocpy(path, &restart->path));
  PetscCall(ReadBeside(model, restart));
  PetscCall(CheckScene(model, restart));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- points ---- */

/* The partition as it was; `same`: as many ranks as then. */
static PetscErrorCode RestorePartition(MpmModel model, PetscBool *same)
{
  const char *text  = model->results->checkpoint.restart->partition.data;
  PetscInt    count = 0, *numbers;
  char       *end;

  PetscFunctionBeginUser;
  for (const char *c = text; *c; c++) count += *c == '\n';
  PetscCall(PetscMalloc1(count, &numbers));
  for (PetscInt k = 0; k < count; k++, text = end) numbers[k] = (PetscInt)strtoll(text, &end, 10);
  PetscCall(MpmGridSetPartition(model->disc.grid, count, numbers, same));
  PetscCall(PetscFree(numbers));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* This rank's rows of one dataset into an array that has room for them. */
static PetscBool ReadField(MpmRestart restart, hid_t group, const MpmPointField *field, PetscInt first, PetscInt rows,
                           void *array)
{
  PetscInt64 extent[2];

  MpmHdf5Extent(group, field->name, extent);
  if (extent[0] < 0 && !strcmp(field->name, "increment")) {
    memset(array, 0, (size_t)rows * (size_t)field->components * sizeof(PetscReal));
    return PETSC_TRUE;
  }
  if (extent[0] != restart->points || extent[1] != field->components) return PETSC_FALSE;
  return MpmHdf5ReadRows(group, field->name, field->integer ? MpmHdf5Integer() : MpmHdf5Real(), first, rows,
                         field->components, array);
}

/* Fills the swarm with this rank's block of rows; `rank` and `place` are those of before. */
static PetscErrorCode ReadBlock(MpmModel model, PetscInt first, PetscInt rows, PetscInt place[])
{
  MpmRestart    restart   = model->results->checkpoint.restart;
  MpmParticles *particles = model->state.particles;
  PetscInt      bad       = particles->field_count + 2;
  MpmPointField before[]  = {{.name = (char[]){"rank"}, .components = 1, .integer = PETSC_TRUE},
                             {.name = (char[]){"place"}, .components = 1, .integer = PETSC_TRUE}};
  void         *array, *to[] = {NULL, place};
  hid_t         file = H5I_INVALID_HID, group = H5I_INVALID_HID;

  PetscFunctionBeginUser;
  if (rows) group = OpenPoints(restart->path, &file);
  PetscCall(DMSwarmGetField(particles->swarm, DMSwarmField_rank, NULL, NULL, &to[0]));
  for (PetscInt k = 0; k < particles->field_count + 2 && rows; k++) {
    const PetscInt       own   = k - particles->field_count;
    const MpmPointField *field = own < 0 ? &particles->fields[k] : &before[own];

    if (own >= 0) array = to[own];
    else PetscCall(MpmParticlesGetField(particles, field->name, &array));
    if (!ReadField(restart, group, field, first, rows, array)) bad = PetscMin(bad, k);
    if (own < 0) PetscCall(MpmParticlesRestoreField(particles, &array));
  }
  PetscCall(DMSwarmRestoreField(particles->swarm, DMSwarmField_rank, NULL, NULL, &to[0]));
  if (group >= 0) (void)H5Gclose(group);
  if (file >= 0) (void)H5Fclose(file);
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &bad, 1, MPIU_INT, MPI_MIN, model->comm));
  MpmCheckInput(bad == particles->field_count + 2, "-mpm_restart %s: its points' %s cannot be read", restart->path,
                bad < particles->field_count ? particles->fields[bad].name : before[bad - particles->field_count].name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The key by which the points of this rank are ordered: the place that each had, from the rank that read its row. */
static PetscErrorCode FetchPlaces(MpmModel model, PetscInt rows, const PetscInt place[], PetscInt count,
                                  const PetscInt id[], PetscInt key[])
{
  PetscInt    largest, *row;
  PetscLayout layout;
  PetscSF     sf;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(count, &row));
  PetscCall(MpmNumberRows(model->comm, count, id, row, &largest));
  PetscCall(PetscLayoutCreateFromSizes(model->comm, rows, model->results->checkpoint.restart->points, 1, &layout));
  PetscCall(PetscSFCreate(model->comm, &sf));
  PetscCall(PetscSFSetGraphLayout(sf, layout, count, NULL, PETSC_COPY_VALUES, row));
  PetscCall(PetscFree(row));
  PetscCall(PetscSFBcastBegin(sf, MPIU_INT, place, key, MPI_REPLACE));
  PetscCall(PetscSFBcastEnd(sf, MPIU_INT, place, key, MPI_REPLACE));
  PetscCall(PetscSFDestroy(&sf));
  PetscCall(PetscLayoutDestroy(&layout));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Puts the points of this rank in the order of their keys. */
static PetscErrorCode OrderPoints(MpmParticles *particles, PetscInt count, PetscInt key[])
{
  PetscInt *from;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(count, &from));
  for (PetscInt p = 0; p < count; p++) from[p] = p;
  PetscCall(PetscSortIntWithArray(count, key, from));
  for (PetscInt k = 0; k < particles->field_count; k++) {
    const MpmPointField *field = &particles->fields[k];
    const size_t         size  = (size_t)field->components * (field->integer ? sizeof(PetscInt) : sizeof(PetscReal));
    char                *copy;
    void                *array;

    PetscCall(PetscMalloc1(((size_t)count * size), &copy));
    PetscCall(MpmParticlesGetField(particles, field->name, &array));
    for (PetscInt p = 0; p < count; p++) memcpy(copy + (size_t)p * size, (char *)array + (size_t)from[p] * size, size);
    if (count) memcpy(array, copy, (size_t)count * size);
    PetscCall(MpmParticlesRestoreField(particles, &array));
    PetscCall(PetscFree(copy));
  }
  PetscCall(PetscFree(from));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmRestartReadPoints(MpmModel model)
{
  MpmRestart    restart   = model->results->checkpoint.restart;
  MpmParticles *particles = model->state.particles;
  PetscInt      rows = restart->points, first = 0, count, *place, *id, *key;
  PetscBool     same, moved;
  MpmOutcome    outcome; /* reported by the next step */

  PetscFunctionBeginUser;
  PetscCall(MpmStateLoad(&model->state, &restart->values, "grid_")); /* the points are on the grid of their time */
  PetscCall(MpmStateLoad(&model->state, &restart->values, "time"));
  PetscCall(MpmStateLoad(&model->state, &restart->values, "place_"));
  if (restart->together) {
    first = (PetscInt)((PetscInt64)restart->points * model->rank / model->size);
    rows  = (PetscInt)((PetscInt64)restart->points * (model->rank + 1) / model->size) - first;
  } else if (model->rank) rows = 0;
  PetscCall(PetscMalloc1(rows, &place));
  PetscCall(MpmParticlesRelease(particles));
  PetscCall(DMSwarmSetLocalSizes(particles->swarm, rows, MPM_PARTICLES_SPARE));
  PetscCall(ReadBlock(model, first, rows, place));
  particles->total = restart->points;
  PetscCall(RestorePartition(model, &same));
  PetscCall(MpmParticlesRelease(particles));
  if (same && model->size > 1) PetscCall(DMSwarmMigrate(particles->swarm, PETSC_TRUE));
  PetscCall(MpmMovingGridFollow(model, &outcome));
  if (!same) {
    PetscCall(MpmParticlesRebalance(particles, model->disc.grid, PETSC_TRUE, &moved));
    PetscCall(MpmParticlesMigrate(particles, model->disc.grid));
  }
  PetscCall(DMSwarmGetLocalSize(particles->swarm, &count));
  PetscCall(PetscMalloc1(count, &key));
  PetscCall(MpmParticlesGetField(particles, "id", &id));
  if (same) PetscCall(FetchPlaces(model, rows, place, count, id, key));
  else PetscCall(PetscArraycpy(key, id, count));
  PetscCall(MpmParticlesRestoreField(particles, &id));
  PetscCall(OrderPoints(particles, count, key));
  PetscCall(PetscFree(key));
  PetscCall(PetscFree(place));
  PetscCall(MpmModelSetOwn(model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- numbers and results ---- */

/* The solver's choice stays, but for changes that the run has made: a rescue that was needed stays on. */
PetscErrorCode MpmRestartApply(MpmModel model)
{
  MpmRestart      restart           = model->results->checkpoint.restart;
  const PetscBool may_be_indefinite = model->solver.definite.may_be_lost;
  const PetscBool leaves_dilation   = model->state.rescue.dilation;
  PetscReal       dt_nominal, start;

  PetscFunctionBeginUser;
  if (!restart) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmStateLoad(&model->state, &restart->values, ""));
  if (leaves_dilation && !model->state.rescue.dilation) MpmStepAverageDilation(model, PETSC_TRUE);
  model->state.rescue.dilation       = (PetscBool)(leaves_dilation && model->state.rescue.dilation);
  model->solver.definite.lost        = (PetscBool)(model->solver.definite.lost && may_be_indefinite);
  model->solver.definite.may_be_lost = (PetscBool)(may_be_indefinite && !model->solver.definite.lost);
  dt_nominal                         = model->state.dt.nominal;
  start                              = model->state.period.start;
  PetscCall(MpmStageResume(model));
  MpmRescueResume(model);
  MpmCheckInput(
    PetscAbsReal(model->state.period.start - start) <= 1e-12 * start, /* earlier versions did not round it */
    "-mpm_time_end: stage %s of the checkpoint %s begins at %g, not at %g",
    model->scene.stages.at[model->state.stage].name, restart->path, (double)start, (double)model->state.period.start);
  if (model->state.dt.nominal != dt_nominal) model->state.dt.wanted = model->state.dt.nominal; /* changed by the user */
  if (!strcmp(model->results->checkpoint.from, "latest"))
    model->results->checkpoint.step = model->state.step; /* one of the kept files */
  MpmCheckInput(model->state.period.end >= model->state.time * (1. - 1e-12),
                "-mpm_time_end %g: the checkpoint %s stands at %g already", (double)model->state.period.end,
                restart->path, (double)model->state.time);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmRestartOutput(MpmModel model, PetscBool apply)
{
  MpmRestart         restart = model->results->checkpoint.restart;
  const char        *h5;
  MpmOutcome         outcome;
  const MpmTextFile *index, *grid_index;
  PetscBool          there;

  PetscFunctionBeginUser;
  PetscCall(MpmOutputGetFiles(model->results->states.file, &h5, &index, &grid_index));
  PetscCall(MpmMarkReturn(model->comm, h5, &restart->results, apply, &there, &outcome));
  MpmCheckInput(!outcome.code,
                "-mpm_restart %s: %s cannot be continued: %s; move it away or choose another -mpm_output_prefix",
                restart->path, h5, outcome.text);
  if (there && apply)
    PetscCall(MpmOutputContinue(model->results->states.file, restart->index.data, restart->grid_index.data));
  PetscFunctionReturn(PETSC_SUCCESS);
}

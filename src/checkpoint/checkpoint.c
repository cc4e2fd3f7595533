/*
  Checkpoints: times and contents.

  One group /points: every field of the particles, rows by id, with the rank of each point and its place there, so that
  as many ranks can restart from an identical state; the rows of the state as attributes (query/state.h); and as bytes
  the options that define the scene, the partition, and the places in the result files.
*/
#include <ctype.h>
#include <strings.h>
#include <time.h>
#include <unistd.h>
#include "options/options.h"
#include "options/record.h"
#include "io/io.h"
#include "grid/partition.h"
#include "particles/particles.h"
#include "volume/added_term.h"
#include "volume/background.h"
#include "query/model.h"
#include "entrainment/entrainment.h"
#include "runout/runout.h"
#include "observe/lines.h"
#include "observe/results.h"
#include "observe/signals.h"
#include "checkpoint/checkpoint.h"

#define COLLECTIVE_BYTES (64 << 20)

PetscErrorCode MpmCheckpointSetFromOptions(MpmModel model, const MpmOptions *options)
{
  const MpmOptions block      = {options->comm, "mpm_checkpoint_", options->record};
  MpmCheckpoint   *checkpoint = &model->results->checkpoint;
  const MpmRow     row        = {"run", MPM_ROW_INT64, MPM_ROW_RUN, &checkpoint->run, 0, 0};

  PetscFunctionBeginUser;
  PetscCall(MpmRowsAdd(model->state.rows, NULL, 1, &row));
  checkpoint->keep       = 2;
  checkpoint->step       = -1;
  checkpoint->collective = COLLECTIVE_BYTES;
  checkpoint->since      = model->results->start;
  checkpoint->options    = MPM_TEXT_FILE_EMPTY;
  PetscCall(MpmOptionsHeading(&block, "Checkpoints"));
  PetscCall(MpmOptionsInt(&block, "every",
                          "steps between checkpoints; 0: only on SIGINT, SIGTERM, SIGUSR1 and when the run gives up", 0,
                          PETSC_INT_MAX, MPM_OPTIONAL, &checkpoint->every, NULL));
  PetscCall(MpmOptionsReal(&block, "wall", "s", "wall time between checkpoints; 0: not by wall time",
                           MPM_RANGE_NON_NEGATIVE, MPM_OPTIONAL, &checkpoint->wall, NULL));
  PetscCall(MpmOptionsInt(&block, "keep", "checkpoints that are kept, the newest included", 1, 1000000, MPM_OPTIONAL,
                          &checkpoint->keep, NULL));
  PetscCall(MpmOptionsReal(&block, "collective", "bytes",
                           "size from which all ranks read and write a checkpoint together", MPM_RANGE_NON_NEGATIVE,
                           MPM_OPTIONAL, &checkpoint->collective, NULL));
  PetscCall(MpmOptionsPath(options, "restart",
                           "checkpoint to go on from: a file, or latest for the newest of the results' prefix that is "
                           "whole",
                           MPM_OPTIONAL, &checkpoint->from));
  if (checkpoint->from || MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  if (!model->rank) checkpoint->run = (PetscInt64)time(NULL) * 100000 + getpid() % 100000;
  PetscCallMPI(MPI_Bcast(&checkpoint->run, 1, MPIU_INT64, 0, model->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmCheckpointDestroy(MpmCheckpoint *checkpoint)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(checkpoint->from));
  PetscCall(MpmTextFileDestroy(&checkpoint->options));
  PetscCall(MpmRestartDestroy(&checkpoint->restart));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the scene ---- */

static PetscBool BeginsWith(const char *text, const char *head)
{
  return (PetscBool)!strncasecmp(text, head, strlen(head));
}

static PetscBool EndsWith(const char *text, const char *tail)
{
  const size_t length = strlen(text), end = strlen(tail);

  return (PetscBool)(length >= end && !strcasecmp(text + length - end, tail));
}

/* True where a run may go on with another value: loads, solution and output may change, the scene itself may not. */
static PetscBool MayChange(const char *name)
{
  static const char *const heads[] = {"mpm_title",       "mpm_plugin",
                                      "mpm_time_",       "mpm_output_",
                                      "mpm_checkpoint_", "mpm_restart",
                                      "mpm_quiet",       "mpm_solver",
                                      "mpm_jacobian",    "mpm_mat_type",
                                      "mpm_vec_type",    "mpm_newton_",
                                      "mpm_matfree_",    "mpm_stabilization_ghost",
                                      "mpm_relaxation_", "mpm_stabilization_interior",
                                      "mpm_maps_every"};

  if (EndsWith(name, "time_rescue")) return PETSC_FALSE; /* points have velocities with it */
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(heads); k++)
    if (BeginsWith(name, heads[k])) return PETSC_TRUE;
  if (BeginsWith(name, "mpm_bc_") || BeginsWith(name, "mpm_load_"))
    return (PetscBool)(EndsWith(name, "_value") || EndsWith(name, "_ramp"));
  return PETSC_FALSE;
}

PetscErrorCode MpmCheckpointScene(MpmModel model, PetscBool given, MpmTextFile *scene)
{
  PetscFunctionBeginUser;
  *scene = MPM_TEXT_FILE_EMPTY;
  PetscCall(MpmTextFileAppend(scene, "%s", ""));
  for (PetscInt k = 0; k < model->record->count; k++) {
    const MpmRecordEntry *entry = &model->record->entries[k];
    char                 *value;

    if (!entry->known || !entry->value || MayChange(entry->name) || (given && !entry->given)) continue;
    PetscCall(MpmTextQuote(entry->value, &value));
    PetscCall(MpmTextFileAppend(scene, "%s %s\n", entry->name, value));
    PetscCall(PetscFree(value));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmCheckpointKeepOptions(MpmModel model, const MpmOptions *options)
{
  MpmRecordEntry *entry;
  char            latest[] = "latest", *value;
  PetscBool       given;

  PetscFunctionBeginUser;
  if (model->rank) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmRecordGet(model->record, "mpm_restart", &entry));
  value        = entry->value;
  given        = entry->given;
  entry->value = latest;
  entry->given = PETSC_TRUE;
  PetscCall(MpmOptionsTextYAML(options, &model->results->checkpoint.options));
  PetscCall(MpmRecordGet(model->record, "mpm_restart", &entry));
  entry->value = value;
  entry->given = given;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- writing ---- */

/* Metadata, and the files' places. */
typedef struct {
  MpmTextFile scene, partition, results, index, grid_index, history, peaks, bed, backgrounds;
  PetscInt    count;
  MpmBytes    bytes[9];
} Beside;

static PetscErrorCode AddBytes(MpmModel model, const char *name, const MpmTextFile *text, Beside *beside)
{
  PetscInt64 size = (PetscInt64)text->length;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Bcast(&size, 1, MPIU_INT64, 0, model->comm));
  beside->bytes[beside->count++] = (MpmBytes){name, (size_t)size, text->data};
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Where the result files stand; they are on the disk before the checkpoint is. */
static PetscErrorCode MarkResults(MpmModel model, Beside *beside)
{
  MpmHistoryPlace place;

  PetscFunctionBeginUser;
  PetscCall(MpmHistoryMark(model->results->history, &place));
  PetscCall(MpmTextFileAppend(&beside->history, "%lld %lld\n", (long long)place.length, (long long)place.hash));
  PetscCall(MpmLinesMark(model, &beside->history));
  if (!MpmOutputStarted(model->results->states.file)) PetscFunctionReturn(PETSC_SUCCESS);
  {
    const char        *h5;
    const MpmTextFile *index, *grid_index;

    PetscCall(MpmOutputGetFiles(model->results->states.file, &h5, &index, &grid_index));
    PetscCall(MpmMarkSet(model->comm, h5, &beside->results));
    if (!model->rank && index->length) PetscCall(MpmTextFileAppend(&beside->index, "%s", index->data));
    if (!model->rank && grid_index->length) PetscCall(MpmTextFileAppend(&beside->grid_index, "%s", grid_index->data));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode BesideSetUp(MpmModel model, Beside *beside)
{
  PetscInt count, *numbers;

  PetscFunctionBeginUser;
  memset(beside, 0, sizeof(*beside));
  PetscCall(MpmCheckpointScene(model, PETSC_FALSE, &beside->scene));
  PetscCall(MpmGridGetPartition(model->disc.grid, &count, &numbers));
  for (PetscInt k = 0; k < count; k++)
    PetscCall(MpmTextFileAppend(&beside->partition, "%" PetscInt_FMT "\n", numbers[k]));
  PetscCall(PetscFree(numbers));
  PetscCall(MarkResults(model, beside));
  if (MpmRunoutHasPeaks(model)) {
    PetscCall(MpmRunoutSave(model, &beside->peaks));
    PetscCall(AddBytes(model, "peaks", &beside->peaks, beside));
  }
  if (MpmEntrainmentHasChange(model)) {
    PetscCall(MpmEntrainmentSave(model, &beside->bed));
    PetscCall(AddBytes(model, "bed", &beside->bed, beside));
  }
  if (model->scene.terms->backgrounds) {
    PetscCall(MpmBackgroundsSave(model->scene.terms->backgrounds, model->comm, &beside->backgrounds));
    PetscCall(AddBytes(model, "backgrounds", &beside->backgrounds, beside));
  }
  PetscCall(AddBytes(model, "scene", &beside->scene, beside));
  PetscCall(AddBytes(model, "partition", &beside->partition, beside));
  PetscCall(AddBytes(model, "history", &beside->history, beside));
  PetscCall(AddBytes(model, "results", &beside->results, beside));
  PetscCall(AddBytes(model, "results_index", &beside->index, beside));
  PetscCall(AddBytes(model, "results_grid_index", &beside->grid_index, beside));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode BesideDestroy(Beside *beside)
{
  PetscFunctionBeginUser;
  PetscCall(MpmTextFileDestroy(&beside->scene));
  PetscCall(MpmTextFileDestroy(&beside->partition));
  PetscCall(MpmTextFileDestroy(&beside->peaks));
  PetscCall(MpmTextFileDestroy(&beside->bed));
  PetscCall(MpmTextFileDestroy(&beside->backgrounds));
  PetscCall(MpmTextFileDestroy(&beside->results));
  PetscCall(MpmTextFileDestroy(&beside->index));
  PetscCall(MpmTextFileDestroy(&beside->grid_index));
  PetscCall(MpmTextFileDestroy(&beside->history));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The points into the file; `failed` is the error code of a write that did not work. */
static PetscErrorCode WritePoints(MpmModel model, const MpmStateFile *state, PetscErrorCode *failed)
{
  MpmParticles *particles = model->state.particles;
  PetscInt      count, fields = particles->field_count, *place;
  MpmDataset   *set;
  void        **array;

  PetscFunctionBeginUser;
  PetscCall(DMSwarmGetLocalSize(particles->swarm, &count));
  PetscCall(PetscMalloc3((fields + 1), &set, fields, &array, (2 * count + 1), &place));
  for (PetscInt k = 0; k < fields; k++) {
    const MpmPointField *field = &particles->fields[k];

    PetscCall(MpmParticlesGetField(particles, field->name, &array[k]));
    if (!k) continue; /* rows follow from the ids */
    set[k - 1] = (MpmDataset){.name       = field->name,
                              .components = field->components,
                              .real       = field->integer ? NULL : (const PetscReal *)array[k],
                              .integer    = field->integer ? (const PetscInt *)array[k] : NULL};
  }
  for (PetscInt p = 0; p < count; p++) {
    place[p]         = model->rank;
    place[count + p] = p;
  }
  set[fields - 1] = (MpmDataset){.name = "rank", .components = 1, .real = NULL, .integer = place};
  set[fields]     = (MpmDataset){.name = "place", .components = 1, .real = NULL, .integer = place + count};
  {
    const MpmTable table = {count, (const PetscInt *)array[0], fields + 1, set};

    *failed = MpmStateWrite(model->comm, state, &table, NULL);
  }
  for (PetscInt k = 0; k < fields; k++) PetscCall(MpmParticlesRestoreField(particles, &array[k]));
  PetscCall(PetscFree3(set, array, place));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes points, numbers and metadata into a file of that name. */
static PetscErrorCode WriteFile(MpmModel model, const char *path, PetscErrorCode *failed)
{
  MpmStateFile  state = {.path = path, .group = "/points", .head = MPM_CHECKPOINT_HEAD};
  MpmRowValues  values;
  MpmAttribute *attributes;
  Beside        beside;

  PetscFunctionBeginUser;
  PetscCall(BesideSetUp(model, &beside));
  PetscCall(MpmStateSave(&model->state, &values));
  PetscCall(PetscMalloc1(values.count, &attributes));
  for (PetscInt k = 0; k < values.count; k++) {
    attributes[k] = (MpmAttribute){values.name[k], values.real[k] ? &values.value[k] : NULL,
                                   values.real[k] ? NULL : &values.number[k]};
  }
  state.collective      = (PetscInt64)PetscMin(model->results->checkpoint.collective, 1e18);
  state.attribute_count = values.count;
  state.attributes      = attributes;
  state.bytes_count     = beside.count;
  state.bytes           = beside.bytes;
  PetscCall(WritePoints(model, &state, failed));
  PetscCall(PetscFree(attributes));
  PetscCall(MpmRowValuesDestroy(&values));
  PetscCall(BesideDestroy(&beside));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The options that continue the run, once there is a checkpoint that they can continue from. */
static PetscErrorCode WriteOptions(MpmModel model)
{
  const MpmTextFile *texts[] = {&model->results->checkpoint.options};
  char               path[PETSC_MAX_PATH_LEN];

  PetscFunctionBeginUser;
  PetscCall(PetscSNPrintf(path, sizeof(path), "%s_restart.yaml", model->scene.name.prefix));
  PetscCall(MpmTextFileWrite(model->comm, path, 1, texts));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmCheckpointWrite(MpmModel model)
{
  MpmCheckpoint    *checkpoint = &model->results->checkpoint;
  MpmCheckpointHead head       = {.step = model->state.step, .run = checkpoint->run};
  char              path[PETSC_MAX_PATH_LEN];
  PetscErrorCode    failed = PETSC_SUCCESS;
  PetscLogDouble    since, now;

  PetscFunctionBeginUser;
  if (checkpoint->step == model->state.step) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmMonitorBegin(&model->monitor, MPM_TIME_OUTPUT, &since));
  PetscCall(PetscSNPrintf(path, sizeof(path), "%s_checkpoint.h5.tmp", model->scene.name.prefix));
  PetscCall(WriteFile(model, path, &failed));
  if (!failed) {
    failed = MpmCheckpointPublish(model->comm, model->scene.name.prefix, path, &head, checkpoint->keep,
                                  (PetscInt64)PetscMin(checkpoint->collective, 1e18));
  }
  if (failed && !model->rank) (void)unlink(path);
  PetscCall(failed);
  if (!checkpoint->options_written) PetscCall(WriteOptions(model));
  checkpoint->options_written = PETSC_TRUE;
  checkpoint->step            = model->state.step;
  PetscCall(PetscTime(&now));
  checkpoint->since = now;
  PetscCall(MpmMonitorEnd(&model->monitor, MPM_TIME_OUTPUT, since));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- when ---- */

PetscErrorCode MpmCheckpointStep(MpmModel model, PetscBool *stop)
{
  const MpmCheckpoint *checkpoint = &model->results->checkpoint;
  const PetscBool      rescue     = model->state.scheme.rescuing.on;
  const PetscBool      end        = (PetscBool)(!rescue && model->state.time >= model->state.period.end * (1. - 1e-12));
  PetscBool            due;
  PetscLogDouble       now;
  int                  note[2] = {(int)MpmSignalsCaught(), 0};

  PetscFunctionBeginUser;
  PetscCall(PetscTime(&now));
  if (!model->rank) note[1] = checkpoint->wall > 0. && now - checkpoint->since >= checkpoint->wall;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, note, 2, MPI_INT, MPI_MAX, model->comm));
  due = (PetscBool)(note[0] || note[1]);
  if (checkpoint->every && !rescue && model->state.step && model->state.step % checkpoint->every == 0) due = PETSC_TRUE;
  if (end && (checkpoint->every || checkpoint->wall > 0.)) due = PETSC_TRUE; /* time_end may be moved later */
  if (due) PetscCall(MpmCheckpointWrite(model));
  *stop = (PetscBool)(note[0] && !end);
  PetscFunctionReturn(PETSC_SUCCESS);
}

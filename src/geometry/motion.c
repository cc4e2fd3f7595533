/*
  Prescribed motion, read from the options of a block.

    motion        displacement in total, m, times ramp
    rotation      in total, degrees, times ramp: about z in 2D, a rotation vector in 3D
    pivot         the place about which it turns, as it stands before the motion
    ramp          time:factor pairs
    motion_table  in their place, a CSV file with the columns time (s), ux, uy, uz (m), rx, ry, rz (degrees; 2D: rz);
                  linear between its rows, constant before and after them; a column that is not there is 0
*/
#include "options/options.h"
#include "files/csv_table.h"
#include "geometry/geometry.h"
#include "geometry/motion.h"
#include "geometry/rotations.h"

#include <strings.h>

#define COMPONENTS (2 * MPM_MAX_DIM) /* of a row: displacement, then rotation */
#define DEGREE     (PETSC_PI / 180.)

static const char *const columns[COMPONENTS] = {"ux", "uy", "uz", "rx", "ry", "rz"};
static const char *const column_text[]       = {[2] = "ux, uy or rz", [3] = "ux, uy, uz, rx, ry or rz"};

/* True where the plane has this component. */
static PetscBool InPlane(PetscInt dim, PetscInt component)
{
  if (component < MPM_MAX_DIM) return (PetscBool)(component < dim);
  return (PetscBool)(component - MPM_MAX_DIM >= MpmRotationAxis(dim, 0));
}

/* A slip in a column's name would leave its component at zero. */
static PetscErrorCode CheckNames(const MpmCsvTable *table, PetscInt dim, char message[MPM_CSV_MESSAGE])
{
  PetscInt found = 0;

  PetscFunctionBeginUser;
  if (MpmCsvTableFind(table, "time") < 0) {
    PetscCall(PetscSNPrintf(message, MPM_CSV_MESSAGE, "has no column time"));
    PetscCall(MpmCsvTableNames(table, message));
  }
  for (PetscInt c = 0; c < table->columns && !message[0]; c++) {
    PetscBool known = (PetscBool)!strcasecmp(table->name[c], "time");

    for (PetscInt k = 0; k < COMPONENTS && !known; k++) {
      known = (PetscBool)(InPlane(dim, k) && !strcasecmp(table->name[c], columns[k]));
      if (known) found++;
    }
    if (!known)
      PetscCall(PetscSNPrintf(message, MPM_CSV_MESSAGE, "column %.40s is unknown: must be time, %s", table->name[c],
                              column_text[dim]));
  }
  if (!found && !message[0])
    PetscCall(PetscSNPrintf(message, MPM_CSV_MESSAGE, "has no column that moves anything: %s", column_text[dim]));
  if (!table->rows && !message[0]) PetscCall(PetscSNPrintf(message, MPM_CSV_MESSAGE, "has no rows"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* One row: a time after the last one. */
static PetscErrorCode TakeRow(const MpmCsvTable *table, PetscInt row, MpmMotion *motion, char message[MPM_CSV_MESSAGE])
{
  const PetscReal *number = &table->value[(PetscInt64)row * table->columns];
  char             text[2][MPM_NUMBER_TEXT];

  PetscFunctionBeginUser;
  motion->time[row] = number[MpmCsvTableFind(table, "time")];
  for (PetscInt k = 0; k < COMPONENTS; k++) {
    const PetscInt c = MpmCsvTableFind(table, columns[k]);

    motion->value[row * COMPONENTS + k] = c < 0 ? 0. : k < MPM_MAX_DIM ? number[c] : number[c] * DEGREE;
  }
  if (message[0] || !row || motion->time[row] > motion->time[row - 1]) PetscFunctionReturn(PETSC_SUCCESS);
  MpmRealText(motion->time[row], text[0]);
  MpmRealText(motion->time[row - 1], text[1]);
  PetscCall(PetscSNPrintf(message, MPM_CSV_MESSAGE,
                          "time must grow from row to row: %s s of row %" PetscInt_FMT " follows %s s", text[0],
                          row + 1, text[1]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Rank 0 reads the file for all. */
static PetscErrorCode ReadTable(const MpmOptions *block, const char *path, PetscInt dim, MpmMotion *motion)
{
  MpmCsvTable table                    = {0};
  char        message[MPM_CSV_MESSAGE] = "";
  PetscMPIInt rank;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(block->comm, &rank));
  if (!rank) {
    PetscCall(MpmCsvTableRead(path, &table, message));
    if (!message[0]) PetscCall(CheckNames(&table, dim, message));
    if (!message[0]) PetscCall(MpmCsvTableFinite(&table, -1, message));
    motion->rows = (PetscInt)table.rows;
  }
  PetscCallMPI(MPI_Bcast(&motion->rows, 1, MPIU_INT, 0, block->comm));
  PetscCall(PetscMalloc2(motion->rows, &motion->time, motion->rows * COMPONENTS, &motion->value));
  for (PetscInt row = 0; !rank && row < motion->rows && !message[0]; row++)
    PetscCall(TakeRow(&table, row, motion, message));
  PetscCall(MpmCsvTableDestroy(&table));
  PetscCallMPI(MPI_Bcast(message, MPM_CSV_MESSAGE, MPI_CHAR, 0, block->comm));
  MpmCheckInput(!message[0], "-%smotion_table %s: %s", block->prefix, path, message);
  PetscCallMPI(MPI_Bcast(motion->time, (PetscMPIInt)motion->rows, MPIU_REAL, 0, block->comm));
  PetscCallMPI(MPI_Bcast(motion->value, (PetscMPIInt)(motion->rows * COMPONENTS), MPIU_REAL, 0, block->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A table has all of the motion in it. */
static PetscErrorCode CheckAlone(const MpmOptions *block)
{
  static const char *const others[] = {"motion", "rotation", "growth", "ramp"};

  PetscFunctionBeginUser;
  for (size_t k = 0; k < sizeof(others) / sizeof(others[0]); k++) {
    PetscBool has;

    PetscCall(MpmOptionsHas(block, others[k], &has));
    MpmCheckInput(!has, "-%s%s: must not be given beside -%smotion_table, which has the motion by time", block->prefix,
                  others[k], block->prefix);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmMotionRead(const MpmOptions *block, PetscInt dim, MpmMotion *motion)
{
  const PetscBool help = MpmOptionsHelp();
  PetscReal      *turn = &motion->rotation[MpmRotationAxis(dim, 0)];
  char           *table;

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsReals(block, "motion", "m", "displacement of the surface in total", MPM_RANGE_ANY, MPM_OPTIONAL,
                            dim, motion->translation, NULL));
  PetscCall(MpmOptionsReals(block, "rotation", "degrees",
                            "rotation in total: about z in 2D, its axis times its angle in 3D", MPM_RANGE_ANY,
                            MPM_OPTIONAL, MpmRotationCount(dim), turn, NULL));
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) motion->rotation[a] *= DEGREE;
  PetscCall(MpmOptionsReals(block, "pivot", "m",
                            "place about which it turns, before the motion; the middle of the shape if absent",
                            MPM_RANGE_ANY, MPM_OPTIONAL, dim, motion->pivot, NULL));
  PetscCall(MpmOptionsPath(block, "motion_table",
                           "in place of motion, rotation, growth and ramp, a CSV file: time (s), ux, uy, uz (m), rx, "
                           "ry, rz (degrees)",
                           MPM_OPTIONAL, &table));
  if (table && !help) {
    PetscCall(CheckAlone(block));
    PetscCall(ReadTable(block, table, dim, motion));
  }
  if (!table || help) PetscCall(MpmRampCreate(block, "ramp", "0:0,1:1", &motion->ramp));
  PetscCall(MpmOptionsHas(block, "ramp", &motion->given));
  PetscCall(PetscFree(table));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The table's components at a time. */
static void Interpolate(const MpmMotion *motion, PetscReal time, PetscReal component[])
{
  PetscInt  low = 0, high = motion->rows; /* rows before `low` are not later than `time`, those from `high` on are */
  PetscReal along = 0.;

  while (low < high) {
    const PetscInt middle = low + (high - low) / 2;

    if (motion->time[middle] <= time) low = middle + 1;
    else high = middle;
  }
  const PetscInt after = PetscMin(high, motion->rows - 1), before = PetscMax(high - 1, 0);

  if (after > before) along = (time - motion->time[before]) / (motion->time[after] - motion->time[before]);
  for (PetscInt k = 0; k < COMPONENTS; k++)
    component[k] =
      (1. - along) * motion->value[before * COMPONENTS + k] + along * motion->value[after * COMPONENTS + k];
}

MpmPose MpmMotionPose(const MpmMotion *motion, PetscReal time)
{
  PetscReal component[COMPONENTS], factor;
  MpmPose   pose = {.growth = 0.};

  if (motion->rows) {
    Interpolate(motion, time, component);
    for (PetscInt a = 0; a < MPM_MAX_DIM; a++) pose.translation[a] = component[a];
    MpmPoseSetRotation(&pose, motion->pivot, &component[MPM_MAX_DIM]);
    return pose;
  }
  factor      = MpmRampEvaluate(motion->ramp, time - motion->delay);
  pose.growth = motion->growth * factor;
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    pose.translation[a] = motion->translation[a] * factor;
    component[a]        = motion->rotation[a] * factor;
  }
  MpmPoseSetRotation(&pose, motion->pivot, component);
  return pose;
}

PetscBool MpmMotionMoves(const MpmMotion *motion)
{
  PetscBool moves = (PetscBool)(motion->rows > 0 || motion->growth != 0.);

  for (PetscInt a = 0; a < MPM_MAX_DIM; a++)
    moves = (PetscBool)(moves || motion->translation[a] != 0. || motion->rotation[a] != 0.);
  return moves;
}

PetscErrorCode MpmMotionDestroy(MpmMotion *motion)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree2(motion->time, motion->value));
  PetscCall(MpmRampDestroy(&motion->ramp));
  PetscFunctionReturn(PETSC_SUCCESS);
}

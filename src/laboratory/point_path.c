/*
  Laboratory paths. Axial is yy.

    isotropic           xx, yy and zz go to one pressure; no shear strain
    oedometer           yy is strained, nothing else
    triaxial_drained    yy is strained, xx and zz keep their stress
    triaxial_undrained  yy is strained, xx and zz by as much as keeps the volume
    biaxial_drained     yy is strained, xx keeps its stress, zz its strain of zero
    biaxial_undrained   yy is strained, xx by as much as keeps the volume, zz not
    simple_shear        F = I + gamma e_x (x) e_y, with rotation, so that all of F is prescribed
    table               by its columns

  The pore pressure of an undrained test does not matter: water and grains keep their volume, and the law's stress is
  the effective one.
*/
#include <stdio.h>
#include <string.h>
#include <strings.h>
#include "options/options.h"
#include "files/csv_table.h"
#include "laboratory/point_path.h"

const char *const MpmPathTypes[] = {"isotropic",          "oedometer",       "triaxial_drained",
                                    "triaxial_undrained", "biaxial_drained", "biaxial_undrained",
                                    "simple_shear",       "table",           NULL};

enum { XX, YY, ZZ, XY };

static const char *const component[] = {"xx", "yy", "zz", "xy", "yz", "xz"};

#define SAME_STRAIN 1e-12 /* how near the first row of a table must be to the start */
#define SAME_STRESS 1e-6  /* relative */
#define SAME_END    1e-9  /* relative: an `end` beside a table and its last row; ends of steps of several tests */

/* ---- tables ---- */

/* One component's column: of strain or of stress; a complaint where there are both, or none that must be there. */
static PetscErrorCode TakeComponent(const MpmCsvTable *table, PetscInt dim, PetscInt s, MpmPointPath *path,
                                    char message[MPM_CSV_MESSAGE])
{
  char      strain[16], stress[16];
  PetscBool across = (PetscBool)(MpmSpacePairs[s][1] >= dim);
  PetscInt  e, t;

  PetscFunctionBeginUser;
  PetscCall(PetscSNPrintf(strain, sizeof(strain), "strain_%s", component[s]));
  PetscCall(PetscSNPrintf(stress, sizeof(stress), "stress_%s", component[s]));
  e               = MpmCsvTableFind(table, strain);
  t               = MpmCsvTableFind(table, stress);
  path->stress[s] = (PetscBool)(t >= 0);
  if (e >= 0 && t >= 0)
    PetscCall(PetscSNPrintf(message, MPM_CSV_MESSAGE, "has both %s and %s: one of them is the answer", strain, stress));
  else if (e < 0 && t < 0 && s < XY && !across) {
    PetscCall(PetscSNPrintf(message, MPM_CSV_MESSAGE, "has no column %s and none %s", strain, stress));
    PetscCall(MpmCsvTableNames(table, message));
  } else if (across && t >= 0)
    PetscCall(PetscSNPrintf(message, MPM_CSV_MESSAGE, "%s: plane strain has no strain to meet it", stress));
  for (PetscInt64 r = 0; r < table->rows && !message[0]; r++) {
    const PetscReal value = e < 0 && t < 0 ? 0. : table->value[r * table->columns + (t >= 0 ? t : e)];

    path->value[r * MPM_SPACE_SYM + s] = value;
    if (PetscIsInfOrNanReal(value))
      PetscCall(PetscSNPrintf(message, MPM_CSV_MESSAGE, "%s of row %d is not a finite number", t >= 0 ? stress : strain,
                              (int)r + 1));
    else if (across && value != 0.)
      snprintf(message, MPM_CSV_MESSAGE, "%s of row %d is %g, must be 0 in plane strain", strain, (int)r + 1,
               (double)value);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TakeTime(const MpmCsvTable *table, MpmPointPath *path, char message[MPM_CSV_MESSAGE])
{
  const PetscInt column = MpmCsvTableFind(table, "time");

  PetscFunctionBeginUser;
  for (PetscInt64 r = 0; r < table->rows && !message[0]; r++) {
    path->time[r] = table->value[r * table->columns + column];
    if (PetscIsInfOrNanReal(path->time[r]))
      PetscCall(PetscSNPrintf(message, MPM_CSV_MESSAGE, "time of row %d is not a finite number", (int)r + 1));
    else if (!r && path->time[r] < 0.)
      snprintf(message, MPM_CSV_MESSAGE, "time of row 1 is %g s, must be >= 0", (double)path->time[r]);
    else if (r && !(path->time[r] > path->time[r - 1]))
      snprintf(message, MPM_CSV_MESSAGE, "time must grow from row to row: %g s of row %d follows %g s",
               (double)path->time[r], (int)r + 1, (double)path->time[r - 1]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* There are times; a slip in a column's name would leave its component at zero. */
static PetscErrorCode CheckNames(const MpmCsvTable *table, char message[MPM_CSV_MESSAGE])
{
  PetscFunctionBeginUser;
  if (MpmCsvTableFind(table, "time") < 0) {
    PetscCall(PetscSNPrintf(message, MPM_CSV_MESSAGE, "has no column time"));
    PetscCall(MpmCsvTableNames(table, message));
  }
  for (PetscInt c = 0; c < table->columns && !message[0]; c++) {
    const char *name  = table->name[c];
    PetscBool   known = (PetscBool)!strcasecmp(name, "time");

    for (PetscInt s = 0; s < MPM_SPACE_SYM && !known && strlen(name) == strlen("strain_xx"); s++)
      known = (PetscBool)((!strncasecmp(name, "strain_", 7) || !strncasecmp(name, "stress_", 7)) &&
                          !strcasecmp(name + 7, component[s]));
    if (!known)
      PetscCall(PetscSNPrintf(message, MPM_CSV_MESSAGE,
                              "column %.40s is unknown: must be time, strain_xx to strain_xz or stress_xx to stress_xz",
                              name));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Rank 0: the file as a path, with room for one row more. */
static PetscErrorCode TakeFile(PetscInt dim, MpmPointPath *path, char message[MPM_CSV_MESSAGE])
{
  MpmCsvTable table = {0};

  PetscFunctionBeginUser;
  PetscCall(MpmCsvTableRead(path->file, &table, message));
  path->rows = (PetscInt)table.rows;
  PetscCall(PetscMalloc2(path->rows + 1, &path->time, (path->rows + 1) * MPM_SPACE_SYM, &path->value));
  if (!message[0]) PetscCall(CheckNames(&table, message));
  if (!message[0]) PetscCall(TakeTime(&table, path, message));
  for (PetscInt s = 0; s < MPM_SPACE_SYM && !message[0]; s++) PetscCall(TakeComponent(&table, dim, s, path, message));
  if (!message[0] && !(path->rows && path->time[path->rows - 1] > 0.))
    PetscCall(PetscSNPrintf(message, MPM_CSV_MESSAGE, "has no row with a time > 0"));
  PetscCall(MpmCsvTableDestroy(&table));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadTable(const MpmOptions *block, PetscInt dim, MpmPointPath *path)
{
  char        message[MPM_CSV_MESSAGE] = "";
  PetscMPIInt rank;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(block->comm, &rank));
  if (!rank) PetscCall(TakeFile(dim, path, message));
  PetscCallMPI(MPI_Bcast(message, MPM_CSV_MESSAGE, MPI_CHAR, 0, block->comm));
  MpmCheckInput(!message[0], "-%stable %s: %s", block->prefix, path->file, message);
  PetscCallMPI(MPI_Bcast(&path->rows, 1, MPIU_INT, 0, block->comm));
  if (rank) PetscCall(PetscMalloc2(path->rows + 1, &path->time, (path->rows + 1) * MPM_SPACE_SYM, &path->value));
  PetscCallMPI(MPI_Bcast(path->time, (PetscMPIInt)path->rows, MPIU_REAL, 0, block->comm));
  PetscCallMPI(MPI_Bcast(path->value, (PetscMPIInt)path->rows * MPM_SPACE_SYM, MPIU_REAL, 0, block->comm));
  PetscCallMPI(MPI_Bcast(path->stress, MPM_SPACE_SYM, MPM_MPI_BOOL, 0, block->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- reading ---- */

/* The end of a path with a name. */
static PetscErrorCode ReadEnd(const MpmOptions *block, MpmPointPath *path)
{
  const PetscBool table = (PetscBool)(path->type == MPM_PATH_TABLE);
  const PetscBool strain =
    (PetscBool)(path->type != MPM_PATH_ISOTROPIC && path->type != MPM_PATH_SIMPLE_SHEAR && !table);
  const PetscBool bound = (PetscBool)(strain && path->measure == MPM_STRAIN_ENGINEERING);
  const MpmRange  range = bound ? (MpmRange){-1., PETSC_INFINITY, PETSC_TRUE} : MPM_RANGE_ANY;
  const char     *unit  = MpmOptionsHelp() ? "- or Pa" : path->type == MPM_PATH_ISOTROPIC ? "Pa" : table ? "s" : "-";
  const char     *help  = MpmOptionsHelp() ? "axial (yy) strain, < 0 in compression; isotropic: pressure, > 0 in "
                                             "compression; simple_shear: gamma_xy; with a table none, or the time of its "
                                             "last row"
                          : table          ? "time of the table's last row"
                          : path->type == MPM_PATH_ISOTROPIC    ? "pressure at the end, > 0 in compression"
                          : path->type == MPM_PATH_SIMPLE_SHEAR ? "gamma_xy at the end"
                                                                : "axial (yy) strain at the end, < 0 in compression";

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsReal(block, "end", unit, help, range, MPM_REQUIRED, &path->end, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Beside a table the end is the time of its last row. */
static PetscErrorCode CheckEnd(const MpmOptions *block, const MpmPointPath *path)
{
  const PetscReal last = path->time[path->rows - 1];
  char            text[2][MPM_NUMBER_TEXT];

  PetscFunctionBeginUser;
  MpmRealText(path->end, text[0]);
  MpmRealText(last, text[1]);
  MpmCheckInput(PetscAbsReal(path->end - last) <= SAME_END * last,
                "-%send %s: path table ends where its file does, at %s s", block->prefix, text[0], text[1]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPointPathRead(const MpmOptions *block, PetscInt dim, MpmStrainMeasure measure, MpmPointPath *path)
{
  const PetscBool help = MpmOptionsHelp();
  PetscInt        type = -1;
  PetscBool       has, has_end;

  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(path, sizeof(*path)));
  path->measure = measure;
  PetscCall(MpmOptionsWord(block, "path", "the test; yy is axial", MpmPathTypes, MPM_REQUIRED, &type, NULL));
  path->type = (MpmPathType)PetscMax(type, 0);
  MpmCheckInput(help || dim == 3 || path->type > MPM_PATH_TRIAXIAL_UNDRAINED || path->type == MPM_PATH_OEDOMETER,
                "-%spath %s: needs -mpm_dim 3: in plane strain zz cannot move", block->prefix,
                MpmPathTypes[path->type]);
  path->steps = 100;
  PetscCall(MpmOptionsInt(block, "steps", "equal steps, in which the path is followed; none passes a row of a table", 1,
                          100000000, MPM_OPTIONAL, &path->steps, NULL));
  PetscCall(MpmOptionsHas(block, "end", &has_end));
  if (help || has_end || path->type != MPM_PATH_TABLE) PetscCall(ReadEnd(block, path));
  PetscCall(MpmOptionsHas(block, "table", &has));
  MpmCheckInput(help || path->type == MPM_PATH_TABLE || !has, "-%stable: goes with -%spath table only, which is %s",
                block->prefix, block->prefix, MpmPathTypes[path->type]);
  if (help || path->type == MPM_PATH_TABLE)
    PetscCall(MpmOptionsPath(
      block, "table",
      "of path table: CSV file with a column time (s) and one a component: strain_xx (-) or stress_xx (Pa), ...; "
      "shear that has none is a strain of zero",
      MPM_REQUIRED, &path->file));
  if (help) PetscFunctionReturn(PETSC_SUCCESS);
  if (path->type == MPM_PATH_TABLE) {
    PetscCall(ReadTable(block, dim, path));
    if (has_end) PetscCall(CheckEnd(block, path));
  }
  for (PetscInt s = XX; s <= ZZ && path->type != MPM_PATH_TABLE; s++)
    path->stress[s] =
      (PetscBool)(path->type == MPM_PATH_ISOTROPIC || (path->type == MPM_PATH_TRIAXIAL_DRAINED && s != YY) ||
                  (path->type == MPM_PATH_BIAXIAL_DRAINED && s == XX));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- following it ---- */

PetscReal MpmPointPathEnd(const MpmPointPath *path)
{
  return path->rows ? path->time[path->rows - 1] : 1.;
}

PetscErrorCode MpmPointPathBegin(const MpmOptions *block, MpmPointPath *path, const PetscReal stress[MPM_SPACE_SYM])
{
  char      text[2][MPM_NUMBER_TEXT];
  PetscReal largest = 0.;

  PetscFunctionBeginUser;
  if (path->type != MPM_PATH_TABLE) {
    path->rows = 1;
    PetscCall(PetscMalloc2(2, &path->time, 2 * MPM_SPACE_SYM, &path->value));
    path->time[0] = 1.;
    for (PetscInt s = 0; s < MPM_SPACE_SYM; s++)
      path->value[s] = path->type == MPM_PATH_ISOTROPIC && s < XY ? -path->end : path->stress[s] ? stress[s] : 0.;
    if (path->type == MPM_PATH_SIMPLE_SHEAR) path->value[XY] = path->end;
    else if (path->type != MPM_PATH_ISOTROPIC) path->value[YY] = path->end;
  } else if (path->time[0] == 0.) {
    for (PetscInt s = 0; s < MPM_SPACE_SYM; s++) largest = PetscMax(largest, PetscAbsReal(stress[s]));
    for (PetscInt s = 0; s < MPM_SPACE_SYM; s++) {
      const PetscReal start = path->stress[s] ? stress[s] : 0., limit = path->stress[s] ? SAME_STRESS * largest : 0.;

      MpmRealText(path->value[s], text[0]);
      MpmRealText(start, text[1]);
      MpmCheckInput(PetscAbsReal(path->value[s] - start) <= PetscMax(limit, SAME_STRAIN),
                    "-%stable %s: %s_%s at time 0 is %s, must be that of the start, %s%s", block->prefix, path->file,
                    path->stress[s] ? "stress" : "strain", component[s], text[0], text[1],
                    path->stress[s] ? " Pa" : "");
    }
  }
  if (path->time[0] > 0.) { /* a row for the start */
    PetscCall(PetscArraymove(&path->time[1], path->time, path->rows));
    PetscCall(PetscArraymove(&path->value[MPM_SPACE_SYM], path->value, path->rows * MPM_SPACE_SYM));
    path->rows++;
  }
  path->time[0] = 0.;
  for (PetscInt s = 0; s < MPM_SPACE_SYM; s++) path->value[s] = path->stress[s] ? stress[s] : 0.;
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MpmPointPathAt(const MpmPointPath *path, PetscReal time, MpmPointControl *control)
{
  const PetscReal *before;
  PetscReal       *value = control->value, part;
  PetscInt         row   = 0;

  while (row + 2 < path->rows && path->time[row + 1] < time) row++;
  before = &path->value[row * MPM_SPACE_SYM];
  part   = (time - path->time[row]) / (path->time[row + 1] - path->time[row]);
  memset(control, 0, sizeof(*control));
  for (PetscInt s = 0; s < MPM_SPACE_SYM; s++) {
    control->stress[s] = path->stress[s];
    value[s] = part == 1. ? before[MPM_SPACE_SYM + s] : before[s] + part * (before[MPM_SPACE_SYM + s] - before[s]);
  }
  if (path->type == MPM_PATH_TRIAXIAL_UNDRAINED || path->type == MPM_PATH_BIAXIAL_UNDRAINED) {
    const PetscReal share = path->type == MPM_PATH_BIAXIAL_UNDRAINED ? 1. : 0.5; /* of xx in the volume change */

    value[XX] = path->measure == MPM_STRAIN_LOG ? -share * value[YY] : PetscPowReal(1. + value[YY], -share) - 1.;
    if (path->type == MPM_PATH_TRIAXIAL_UNDRAINED) value[ZZ] = value[XX];
  }
  if (path->type == MPM_PATH_SIMPLE_SHEAR) {
    control->whole = PETSC_TRUE;
    for (PetscInt k = 0; k < 9; k++) control->F[k] = k % 4 ? 0. : 1.;
    control->F[1] = value[XY];
  }
}

/* Into how many steps the time from a row to the next is divided. */
static PetscInt Steps(const MpmPointPath *path, PetscInt row)
{
  const PetscReal whole = path->time[path->rows - 1] - path->time[0];
  const PetscReal steps = (PetscReal)path->steps * (path->time[row + 1] - path->time[row]) / whole;

  return PetscMax(1, (PetscInt)PetscCeilReal(steps * (1. - 1e-9)));
}

PetscReal MpmPointPathTarget(const MpmPointPath *path, PetscReal time, PetscReal *length)
{
  PetscInt  row = 0, steps;
  PetscReal begin, end, step;

  while (row + 2 < path->rows && path->time[row + 1] <= time) row++;
  begin   = path->time[row];
  end     = path->time[row + 1];
  steps   = Steps(path, row);
  step    = (end - begin) / (PetscReal)steps;
  *length = step;
  for (PetscInt k = PetscMax(1, (PetscInt)((time - begin) / step)); k < steps; k++) {
    const PetscReal target = begin + (end - begin) * (PetscReal)k / (PetscReal)steps;

    if (target > time + SAME_END * step) return target;
  }
  return end;
}

PetscErrorCode MpmPointPathDestroy(MpmPointPath *path)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree2(path->time, path->value));
  PetscCall(PetscFree(path->file));
  PetscFunctionReturn(PETSC_SUCCESS);
}

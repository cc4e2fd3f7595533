/*
  The schedule of a run.
*/
#include "files/csv_table.h"
#include "options/options.h"
#include "scene/schedule_read.h"

#define SAME 1e-12 /* of the run's time: times that are equal */

/* The ends of the steps, without the row of the start. */
static PetscErrorCode ReadTimes(const char path[], MpmGivenSteps *given)
{
  char        message[MPM_CSV_MESSAGE] = "";
  MpmCsvTable table                    = {0};
  PetscInt    column;

  PetscFunctionBeginUser;
  PetscCall(MpmCsvTableRead(path, &table, message));
  MpmCheckInput(!message[0], "-mpm_time_schedule %s: %s", path, message);
  column = MpmCsvTableFind(&table, "time");
  MpmCheckInput(column >= 0, "-mpm_time_schedule %s: has no column time", path);
  PetscCall(MpmCsvTableFinite(&table, column, message));
  MpmCheckInput(!message[0], "-mpm_time_schedule %s: %s", path, message);
  PetscCall(PetscMalloc1(((size_t)table.rows + 1), &given->time));
  for (PetscInt64 k = 0; k < table.rows; k++) {
    const PetscReal time   = table.value[k * table.columns + column];
    const PetscReal before = given->count ? given->time[given->count - 1] : 0.;

    if (k == 0 && time == 0.) continue;
    MpmCheckInput(time > before, "-mpm_time_schedule %s: times must ascend: %g comes behind %g", path, (double)time,
                  (double)before);
    given->time[given->count++] = time;
  }
  MpmCheckInput(given->count, "-mpm_time_schedule %s: has no steps", path);
  PetscCall(MpmCsvTableDestroy(&table));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A step must end where a stage does, and stages must end at their times. */
static PetscErrorCode CheckStages(MpmStages *stages, PetscReal run_end, const char path[])
{
  const MpmGivenSteps *given = &stages->given;
  const PetscReal      small = SAME * run_end;
  PetscReal            end   = 0.;
  PetscInt             n     = 0;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < stages->count; k++) {
    const MpmStage *stage = &stages->at[k];
    const char     *name  = stage->name ? stage->name : "the run";

    MpmCheckInput(!(stage->consolidation > 0.) && !stage->relaxation.on && !stage->time.rescue,
                  "-mpm_time_schedule %s: %s ends when its state says so, not at a given time", path, name);
    end += stage->time.end;
    while (n < given->count && given->time[n] < end - small) n++;
    MpmCheckInput(n < given->count && given->time[n] <= end + small,
                  "-mpm_time_schedule %s: is of another scene: no step ends at %g, where %s ends", path, (double)end,
                  name);
    given->time[n] = end;
  }
  MpmCheckInput(n + 1 == given->count,
                "-mpm_time_schedule %s: is of another scene: its steps go on to %g, the run ends at %g", path,
                (double)given->time[given->count - 1], (double)end);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmScheduleRead(const MpmOptions *options, PetscReal run_end, MpmStages *stages)
{
  const MpmOptions block = {options->comm, "mpm_time_", options->record};
  char            *path;

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsPath(&block, "schedule",
                           "file with the ends of the run's steps in a column time: steps of these lengths, none "
                           "other; a history is such a file",
                           MPM_OPTIONAL, &path));
  if (path && !MpmOptionsHelp()) {
    PetscCall(ReadTimes(path, &stages->given));
    PetscCall(CheckStages(stages, run_end, path));
  }
  PetscCall(PetscFree(path));
  PetscFunctionReturn(PETSC_SUCCESS);
}

#pragma once
/*
  The schedule of a run: steps whose lengths are given in a file.
*/
#include "base/base.h"
#include "base/types.h"
#include "query/scene.h"

/*
  Option -mpm_time_schedule: a table with a column `time`, the ends of the steps in seconds since the run began; a
  history is one. Fails where its steps are not those of these stages, which have been read, over `run_end` seconds.
*/
PetscErrorCode MpmScheduleRead(const MpmOptions *options, PetscReal run_end, MpmStages *stages);

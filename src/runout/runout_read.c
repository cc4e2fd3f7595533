/*
  Options of the results of flow over terrain.
*/
#include "base/rows.h"
#include "maps/bed.h"
#include "options/options.h"
#include "runout/runout_impl.h"

/* Options -mpm_maps_*; `asked`: some are given. */
static PetscErrorCode ReadMaps(const MpmModel model, const MpmOptions *options, MpmRunout *runout, PetscBool *asked)
{
  static const char *const names[] = {"every", "thresholds", "pressure"}, *const along[] = {"normal", "vertical", NULL};
  const MpmBed    *bed   = model->scene.deformation.bed;
  const MpmOptions block = {options->comm, "mpm_maps_", options->record};
  MpmPeaks        *peaks = &runout->peaks;
  PetscInt         word  = bed && !bed->normal;

  PetscFunctionBeginUser;
  *asked = PETSC_FALSE;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(names); k++) {
    PetscBool given;

    PetscCall(MpmOptionsHas(&block, names[k], &given));
    *asked = (PetscBool)(*asked || given);
  }
  PetscCall(MpmOptionsHeading(&block, "Maps of results (-mpm_physics depth_averaged)"));
  PetscCall(
    MpmOptionsInt(&block, "every",
                  "maps of the largest values of all steps, PREFIX_peak; and of the state after each of so many "
                  "steps, PREFIX_000100; 0: of the largest values alone",
                  0, PETSC_INT_MAX, MPM_OPTIONAL, &runout->every, NULL));
  PetscCall(MpmOptionsRealList(&block, "thresholds", "m",
                               "depths at which the flow has arrived; speed and pressure count from the least on; by "
                               "default 1 % of the largest depth at the start",
                               MPM_OPTIONAL, &peaks->depths, &peaks->depth));
  PetscCall(MpmOptionsWord(&block, "pressure",
                           "density times the square of the speed along the bed (normal), or of the horizontal one "
                           "(vertical); the default is that of -mpm_slope",
                           along, MPM_OPTIONAL, &word, NULL));
  runout->along = (PetscBool)!word;
  if (MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  MpmCheckInput(peaks->depths <= MPM_MOST_THRESHOLDS,
                "-mpm_maps_thresholds: has %" PetscInt_FMT " numbers, may have %d", peaks->depths, MPM_MOST_THRESHOLDS);
  for (PetscInt k = 0; k < peaks->depths; k++)
    MpmCheckInput(peaks->depth[k] > (k ? peaks->depth[k - 1] : 0.),
                  "-mpm_maps_thresholds: number %" PetscInt_FMT ", %g, must be > %g", k + 1, (double)peaks->depth[k],
                  (double)(k ? peaks->depth[k - 1] : 0.));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* True where some stage ends at rest. */
static PetscBool AnyRests(const MpmModel model)
{
  for (PetscInt k = 0; k < model->scene.stages.count; k++)
    if (model->scene.stages.at[k].time.motion.rest > 0.) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* True where a gauge needs the largest values or the least threshold. */
static PetscBool NeedsPeaks(const MpmGauges *gauges)
{
  for (PetscInt k = 0; k < gauges->count; k++)
    if (gauges->at[k].kind == MPM_GAUGE_PATH || gauges->at[k].kind == MPM_GAUGE_OUTLINE) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* Numbers of checkpoints. */
static PetscErrorCode AddRows(MpmModel model)
{
  MpmRunout   *runout = model->runout;
  const MpmRow rows[] = {{"runout_seen", MPM_ROW_INT, MPM_ROW_STATE, &runout->seen, 0, 0},
                         {"runout_energy", MPM_ROW_REAL, MPM_ROW_STATE, &runout->energy, 0, 0},
                         {"runout_rest", MPM_ROW_REAL, MPM_ROW_STATE, &runout->rest, 0, 0},
                         {"runout_least", MPM_ROW_REAL, MPM_ROW_STATE, &runout->peaks.least, 0, 0}};

  PetscFunctionBeginUser;
  PetscCall(MpmRowsAdd(model->state.rows, "", PETSC_STATIC_ARRAY_LENGTH(rows), rows));
  for (PetscInt k = 0; k < runout->gauges.count; k++) {
    MpmGauge    *gauge = &runout->gauges.at[k];
    const MpmRow row   = {gauge->name, MPM_ROW_REAL, MPM_ROW_STATE, gauge->kept, MPM_GAUGE_NUMBERS, 0};

    PetscCall(MpmRowsAdd(model->state.rows, "gauge_", 1, &row));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmRunoutRead(MpmModel model, const MpmOptions *options)
{
  const PetscBool bed = (PetscBool)(model->scene.deformation.bed != NULL);
  MpmRunout      *runout;

  PetscFunctionBeginUser;
  if (!bed && !MpmOptionsHelp() && !AnyRests(model)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscNew(&runout));
  model->runout = runout;
  runout->seen  = -1;
  runout->rest  = -1.;
  if (bed || MpmOptionsHelp()) {
    PetscCall(ReadMaps(model, options, runout, &runout->maps));
    PetscCall(MpmGaugesRead(model, options));
  }
  if (MpmOptionsHelp() || (!runout->maps && !runout->gauges.count && !AnyRests(model))) {
    PetscCall(MpmRunoutDestroy(model));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (runout->maps || NeedsPeaks(&runout->gauges)) PetscCall(MpmPeaksSetUp(model->disc.grid, &runout->peaks));
  PetscCall(AddRows(model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

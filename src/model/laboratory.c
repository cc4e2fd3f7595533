/*
  A laboratory run: reads the test, follows its path step by step, and writes history and summary as any run does.

  A step that fails is halved and tried again, and steps grow back; each step that converged is a row. All ranks do the
  same, rank 0 writes.
*/
#include "base/columns.h"
#include "options/options.h"
#include "point/material.h"
#include "point/point_path.h"
#include "point/stress_point.h"
#include "query/model.h"
#include "observe/history.h"
#include "observe/results.h"
#include "observe/signals.h"
#include "model/laboratory.h"

#define SHORTEST 0x1p-20 /* of a step as the scene has it: a step is not cut below this */
#define GROWTH   2.      /* of the length of the next step after one that converged */

struct MpmLaboratory {
  PetscInt         dim, material;
  PetscReal        start[MPM_SPACE_SYM]; /* stress there */
  MpmStressMeasure stress_measure;
  MpmStrainMeasure strain_measure;
  MpmPointPath     path;
  MpmStressPoint   point;
  PetscBool        ready;    /* set up */
  PetscReal        fraction; /* length of the next step over that of the scene's own */
};

static const char *const component[] = {"xx", "yy", "zz", "xy", "yz", "xz"};

/* ---- reading ---- */

/* In plane strain yz and xz may be left out, and are 0. */
static PetscErrorCode ReadStress(MpmLaboratory *laboratory, const MpmOptions *block)
{
  const MpmOptions silent = {block->comm, block->prefix, NULL};
  const char      *help   = laboratory->dim == 2
                              ? "at the start, in the measure below: xx, yy, zz, xy (, yz, xz: 0); tension positive"
                              : "at the start, in the measure below: xx, yy, zz, xy, yz, xz; tension positive";
  PetscInt         size   = MpmSymSize(laboratory->dim), count;
  PetscReal       *values;

  PetscFunctionBeginUser;
  if (size < MPM_SPACE_SYM && !MpmOptionsHelp()) {
    PetscCall(MpmOptionsRealList(&silent, "stress", "Pa", help, MPM_OPTIONAL, &count, &values));
    if (count == MPM_SPACE_SYM && values[4] == 0. && values[5] == 0.) size = MPM_SPACE_SYM;
    PetscCall(PetscFree(values));
  }
  PetscCall(MpmOptionsReals(block, "stress", "Pa", help, MPM_RANGE_ANY, MPM_OPTIONAL, size, laboratory->start, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadPoint(MpmLaboratory *laboratory, const MpmOptions *options, PetscInt count,
                                const char *const materials[])
{
  const MpmOptions block   = {options->comm, "mpm_point_", options->record};
  PetscInt         measure = MPM_STRESS_CAUCHY, strain = MPM_STRAIN_LOG;

  PetscFunctionBeginUser;
  laboratory->material = count ? 0 : -1;
  PetscCall(
    MpmOptionsWord(&block, "material", "one of -mpm_materials", materials, MPM_REQUIRED, &laboratory->material, NULL));
  PetscCall(ReadStress(laboratory, &block));
  PetscCall(MpmOptionsWord(&block, "measure", "the stress that is prescribed and reported", MpmStressMeasures,
                           MPM_OPTIONAL, &measure, NULL));
  PetscCall(MpmOptionsWord(&block, "strain", "the strain that is prescribed and reported: ln V or sym F - I",
                           MpmStrainMeasures, MPM_OPTIONAL, &strain, NULL));
  laboratory->stress_measure = (MpmStressMeasure)measure;
  laboratory->strain_measure = (MpmStrainMeasure)strain;
  PetscCall(MpmPointPathRead(&block, laboratory->dim, laboratory->strain_measure, &laboratory->path));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmLaboratoryRead(MpmModel model, const MpmOptions *options, PetscInt dim)
{
  MpmMaterials *materials = model->scene.materials;
  const char  **names;

  PetscFunctionBeginUser;
  MpmCheckInput(model->scene.deformation.kinematics != MPM_AXISYMMETRY || MpmOptionsHelp(),
                "-mpm_kinematics axisymmetric: a stress point has no radius; must be left out, or -mpm_dim 3");
  PetscCall(PetscNew(&model->laboratory));
  model->laboratory->dim = model->disc.dim = dim;
  PetscCall(MpmOptionsBlocks(options, "materials", "names of the material blocks", MPM_REQUIRED, &materials->count,
                             &materials->names));
  PetscCall(PetscCalloc1(materials->count, &materials->at));
  PetscCall(PetscCalloc1(materials->count + 1, &names));
  for (PetscInt m = 0; m < materials->count; m++) {
    PetscCall(MpmMaterialCreate(options, materials->names[m], dim, &materials->at[m]));
    names[m] = materials->names[m];
    if (materials->at[m].varies) {
      char *varying = NULL;

      PetscCall(MpmMaterialVaryingText(&materials->at[m], &varying));
      MpmCheckInput(PETSC_FALSE,
                    "-mpm_material_%s: %s by height or field, must be a number: a single point has no height",
                    materials->names[m], varying);
    }
  }
  PetscCall(MpmOptionsHeading(options, "Point"));
  PetscCall(ReadPoint(model->laboratory, options, materials->count, names));
  PetscCall(PetscFree(names));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmLaboratoryPrintHelp(MpmModel model, const MpmOptions *options)
{
  static const char *const names[]    = {"NAME", NULL};
  MpmLaboratory            laboratory = {.dim = model->disc.dim};

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsHeading(options, "Point, with physics " MPM_STRESS_POINT ": without grid, bodies and time"));
  PetscCall(ReadPoint(&laboratory, options, 0, names));
  PetscCall(MpmPointPathDestroy(&laboratory.path));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- set-up ---- */

PetscErrorCode MpmLaboratorySetUp(MpmModel model)
{
  MpmLaboratory   *laboratory = model->laboratory;
  const MpmOptions block      = {model->comm, "mpm_point_", model->record};
  MpmPointPath    *path       = &laboratory->path;
  MpmOutcome       outcome;

  PetscFunctionBeginUser;
  if (laboratory->ready) PetscFunctionReturn(PETSC_SUCCESS);
  laboratory->ready = PETSC_TRUE;
  PetscCall(MpmStressPointCreate(model->comm, &model->scene.materials->at[laboratory->material], laboratory->dim,
                                 path->stress, &laboratory->point));
  laboratory->point.stress_measure = laboratory->stress_measure;
  laboratory->point.strain_measure = laboratory->strain_measure;
  PetscCall(MpmStressPointStart(&laboratory->point, laboratory->start, &outcome));
  MpmCheckInput(!outcome.code, "-mpm_point_stress: %s", outcome.text);
  PetscCall(MpmPointPathBegin(&block, path, laboratory->start));
  model->state.time            = path->time[0];
  model->state.period.run_end  = path->time[path->rows - 1];
  model->state.active_dofs_max = laboratory->point.equations.count;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* One line on the test. */
static PetscErrorCode Describe(MpmModel model, size_t length, char text[])
{
  const MpmLaboratory *laboratory = model->laboratory;
  const MpmMaterial   *material   = &model->scene.materials->at[laboratory->material];

  PetscFunctionBeginUser;
  PetscCall(PetscSNPrintf(text, length,
                          "%s, %" PetscInt_FMT "D, %s of material %s (%s), %s stress, %s strain, %" PetscInt_FMT
                          " unknown%s, %d rank%s",
                          MPM_STRESS_POINT, laboratory->dim, MpmPathTypes[laboratory->path.type], material->name,
                          material->info.name, MpmStressMeasures[laboratory->stress_measure],
                          MpmStrainMeasures[laboratory->strain_measure], laboratory->point.equations.count,
                          laboratory->point.equations.count == 1 ? "" : "s", model->size, model->size > 1 ? "s" : ""));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- history ---- */

static PetscErrorCode FillLoad(MpmModel model, const MpmColumn *column, PetscReal values[])
{
  (void)column;
  PetscFunctionBeginUser;
  values[0] = model->state.time / model->state.period.run_end;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode FillStrain(MpmModel model, const MpmColumn *column, PetscReal values[])
{
  PetscFunctionBeginUser;
  PetscCall(PetscArraycpy(values, model->laboratory->point.now.strain, column->count));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode FillStress(MpmModel model, const MpmColumn *column, PetscReal values[])
{
  PetscFunctionBeginUser;
  PetscCall(PetscArraycpy(values, model->laboratory->point.now.stress, column->count));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode FillInvariants(MpmModel model, const MpmColumn *column, PetscReal values[])
{
  const MpmLaboratory *laboratory = model->laboratory;
  const MpmPointState *now        = &laboratory->point.now;

  (void)column;
  PetscFunctionBeginUser;
  values[0] = (now->stress[0] + now->stress[1] + now->stress[2]) / 3.;
  values[1] = MpmDeviatorSize(now->stress);
  values[2] = MpmVolumeStrain(laboratory->strain_measure, now->F);
  values[3] = 2. / 3. * MpmDeviatorSize(now->strain);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A history variable, from its place in the point's history on. */
static PetscErrorCode FillVariable(MpmModel model, const MpmColumn *column, PetscReal values[])
{
  PetscFunctionBeginUser;
  PetscCall(
    PetscArraycpy(values, &model->laboratory->point.now.history[column->index], column->count ? column->count : 1));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode AddColumns(MpmModel model, MpmColumns *columns)
{
  static const char *const invariants[] = {"p", "q", "eps_v", "eps_q"};
  const MpmLawInfo        *info         = &model->scene.materials->at[model->laboratory->material].info;
  const MpmColumn          rows[]       = {
                   {"load", "-", 0, NULL, FillLoad, NULL, 0},
                   {"strain", "-", MPM_SPACE_SYM, component, FillStrain, NULL, 0},
                   {"stress", "Pa", MPM_SPACE_SYM, component, FillStress, NULL, 0},
                   {NULL, "Pa, strains -", PETSC_STATIC_ARRAY_LENGTH(invariants), invariants, FillInvariants, NULL, 0},
  };
  PetscInt first = 0;

  PetscFunctionBeginUser;
  PetscCall(MpmStepAddColumns(model, columns));
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(rows); k++) PetscCall(MpmColumnsAdd(columns, NULL, &rows[k]));
  for (size_t v = 0; v < info->state_count; v++) {
    const PetscInt  size = MpmStateComponents(&info->states[v], model->laboratory->dim);
    const MpmColumn row  = {
       info->states[v].name, info->states[v].unit, size > 1 ? size : 0, component, FillVariable, NULL, first};

    PetscCall(MpmColumnsAdd(columns, NULL, &row));
    first += size;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the run ---- */

/* One step that ends at `target` or, where that fails, before it; `nominal` is the scene's own length. */
static PetscErrorCode Advance(MpmModel model, PetscReal target, PetscReal nominal, PetscReal *dt)
{
  MpmLaboratory  *laboratory = model->laboratory;
  MpmOutcome     *outcome    = &model->caller.outcome;
  MpmPointControl control;
  PetscReal       time;
  PetscLogDouble  since;

  PetscFunctionBeginUser;
  model->state.cuts.step = 0;
  for (;;) {
    const PetscReal left = target - model->state.time, wanted = laboratory->fraction * nominal;

    time = wanted > left * (1. - 1e-3) ? target : model->state.time + wanted;
    *dt  = time - model->state.time;
    PetscCall(MpmMonitorBegin(&model->monitor, MPM_TIME_SOLVE, &since));
    MpmPointPathAt(&laboratory->path, time, &control);
    PetscCall(MpmStressPointStep(&laboratory->point, &control, *dt, outcome));
    PetscCall(MpmMonitorEnd(&model->monitor, MPM_TIME_SOLVE, since));
    model->solver.iterations.newton_total += laboratory->point.equations.newton;
    model->solver.iterations.linear_total += laboratory->point.equations.linear;
    if (!outcome->code) break;
    if (0.5 * *dt < SHORTEST * nominal) PetscFunctionReturn(PETSC_SUCCESS);
    laboratory->fraction = 0.5 * *dt / nominal;
    model->state.cuts.step++;
    model->state.cuts.total++;
    PetscCall(MpmMonitorNote(&model->monitor, "%s; the step is cut to %.4g", outcome->text, 0.5 * (double)*dt));
  }
  laboratory->fraction = PetscMin(GROWTH * laboratory->fraction, 1.);
  model->state.time    = time;
  model->state.step++;
  model->solver.iterations.newton = laboratory->point.equations.newton;
  model->solver.iterations.linear = laboratory->point.equations.linear;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* True where a rank has received a signal before the end. */
static PetscErrorCode IsInterrupted(MpmModel model, PetscBool *interrupted)
{
  PetscFunctionBeginUser;
  *interrupted = MpmSignalsCaught();
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, interrupted, 1, MPM_MPI_BOOL, MPI_LOR, model->comm));
  if (model->state.time >= model->state.period.run_end) *interrupted = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* From one row of the path to the next. */
static PetscErrorCode FollowRow(MpmModel model, PetscInt row, PetscBool *interrupted)
{
  MpmLaboratory  *laboratory = model->laboratory;
  const PetscReal begin = laboratory->path.time[row], end = laboratory->path.time[row + 1];
  const PetscInt  steps   = MpmPointPathSteps(&laboratory->path, row);
  const PetscReal nominal = (end - begin) / (PetscReal)steps;
  PetscReal       dt;

  PetscFunctionBeginUser;
  for (PetscInt k = 1; k <= steps; k++) {
    const PetscReal target = k == steps ? end : begin + (end - begin) * (PetscReal)k / (PetscReal)steps;

    while (model->state.time < target) {
      PetscCall(Advance(model, target, nominal, &dt));
      if (model->caller.outcome.code) PetscFunctionReturn(PETSC_SUCCESS);
      model->results->dt = dt;
      PetscCall(MpmModelWriteHistory(model));
      PetscCall(MpmTerminalStep(model, dt));
      PetscCall(IsInterrupted(model, interrupted));
      if (*interrupted) PetscFunctionReturn(PETSC_SUCCESS);
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmLaboratoryRun(MpmModel model, int *status)
{
  const MpmOptions options     = {model->comm, NULL, model->record};
  PetscBool        interrupted = PETSC_FALSE;
  MpmOutcome      *outcome     = &model->caller.outcome;
  char             text[512];

  PetscFunctionBeginUser;
  MpmOutcomeClear(outcome);
  model->laboratory->fraction = 1.;
  PetscCall(Describe(model, sizeof(text), text));
  PetscCall(MpmTerminalBegin(model, text));
  PetscCall(AddColumns(model, &model->results->columns));
  PetscCall(MpmHistoryOpen(model));
  for (PetscInt row = 0; row + 1 < model->laboratory->path.rows && !outcome->code && !interrupted; row++)
    PetscCall(FollowRow(model, row, &interrupted));
  if (outcome->code)
    PetscCall(MpmTerminalWarn(model, "gave up after step %" PetscInt_FMT " at time %g: %s", model->state.step,
                              (double)model->state.time, outcome->text));
  PetscCall(MpmModelWriteSummary(model, outcome->code ? outcome->text : interrupted ? "interrupted" : "completed"));
  if (model->caller.terminal) PetscCall(MpmOptionsWarnUnused(&options, MPM_AT_END));
  if (interrupted) PetscCall(MpmTerminalInterrupted(model));
  *status = outcome->code ? MPM_EXIT_GAVEUP : 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmLaboratoryDestroy(MpmLaboratory **laboratory)
{
  PetscFunctionBeginUser;
  if (!*laboratory) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmStressPointDestroy(&(*laboratory)->point));
  PetscCall(MpmPointPathDestroy(&(*laboratory)->path));
  PetscCall(PetscFree(*laboratory));
  PetscFunctionReturn(PETSC_SUCCESS);
}

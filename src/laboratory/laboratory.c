/*
  A laboratory run: follows the paths of its tests step by step, and writes history and summary as any run does.

  A step that fails in any test is halved and tried again, and steps grow back; each step that converged is a row. All
  ranks do alike, rank 0 writes.
*/
#include "options/options.h"
#include "point/material.h"
#include "laboratory/stress_point_slopes.h"
#include "particles/particles.h"
#include "query/model.h"
#include "observe/history.h"
#include "observe/results.h"
#include "observe/signals.h"
#include "sensitivity/gradient.h"
#include "laboratory/laboratory_impl.h"

#define SHORTEST 0x1p-20 /* of a step as the scene has it: a step is not cut below this */
#define GROWTH   2.      /* of the length of the next step after one that converged */

/* ---- set-up ---- */

static PetscErrorCode SetUpTest(MpmModel model, MpmLaboratoryTest *test)
{
  const MpmOptions block = {model->comm, test->prefix, model->record};
  MpmOutcome       outcome;

  PetscFunctionBeginUser;
  PetscCall(MpmStressPointCreate(model->comm, &model->scene.materials->at[test->material], model->laboratory->dim,
                                 test->path.stress, &test->point));
  test->point.stress_measure = test->stress_measure;
  test->point.strain_measure = test->strain_measure;
  PetscCall(MpmStressPointStart(&test->point, test->start, &outcome));
  MpmCheckInput(!outcome.code, "-%sstress: %s", test->prefix, outcome.text);
  PetscCall(MpmPointPathBegin(&block, &test->path, test->start));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmLaboratorySetUp(MpmModel model)
{
  MpmLaboratory *laboratory = model->laboratory;

  PetscFunctionBeginUser;
  if (laboratory->ready) PetscFunctionReturn(PETSC_SUCCESS);
  laboratory->ready    = PETSC_TRUE;
  laboratory->fraction = 1.;
  for (PetscInt t = 0; t < laboratory->count; t++) {
    MpmLaboratoryTest *test = &laboratory->tests[t];

    PetscCall(SetUpTest(model, test));
    test->first = laboratory->size;
    laboratory->size += MpmStressPointChangeSize(&test->point);
    model->state.active_dofs_max += test->point.equations.count;
  }
  model->caller.set_up          = PETSC_TRUE;
  model->state.particles->total = laboratory->count;
  model->state.time             = laboratory->tests[0].path.time[0];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* One line on the test, or on all of them. */
static PetscErrorCode Describe(MpmModel model, size_t length, char text[])
{
  const MpmLaboratory     *laboratory = model->laboratory;
  const MpmLaboratoryTest *test       = laboratory->tests;
  const MpmMaterial       *material   = &model->scene.materials->at[test->material];
  const PetscInt           unknowns   = (PetscInt)model->state.active_dofs_max;
  char                     what[256];

  PetscFunctionBeginUser;
  if (laboratory->names) PetscCall(PetscSNPrintf(what, sizeof(what), "%" PetscInt_FMT " tests", laboratory->count));
  else
    PetscCall(PetscSNPrintf(what, sizeof(what), "%s of material %s (%s), %s stress, %s strain",
                            MpmPathTypes[test->path.type], material->name, material->info.name,
                            MpmStressMeasures[test->stress_measure], MpmStrainMeasures[test->strain_measure]));
  PetscCall(PetscSNPrintf(text, length, "%s, %" PetscInt_FMT "D, %s, %" PetscInt_FMT " unknown%s, %d rank%s",
                          MPM_STRESS_POINT, laboratory->dim, what, unknowns, unknowns == 1 ? "" : "s", model->size,
                          model->size > 1 ? "s" : ""));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- columns ---- */

static PetscErrorCode FillLoad(MpmModel model, const MpmColumn *column, PetscReal values[])
{
  (void)column;
  PetscFunctionBeginUser;
  values[0] = model->state.time / model->state.period.run_end;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmLaboratoryAddColumns(MpmModel model, MpmColumns *columns)
{
  MpmLaboratory  *laboratory = model->laboratory;
  const MpmColumn load       = {"load", "-", 0, NULL, FillLoad, NULL, 0};

  PetscFunctionBeginUser;
  PetscCall(MpmStepAddColumns(model, columns));
  PetscCall(MpmColumnsAdd(columns, NULL, &load));
  for (PetscInt t = 0; t < laboratory->count; t++) {
    MpmLaboratoryTest *test = &laboratory->tests[t];

    PetscCall(
      MpmLaboratoryTestAddColumns(&model->scene.materials->at[test->material].info, laboratory->dim, test, columns));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the run ---- */

/* A step of all tests to a time; where one fails none has moved. */
static PetscErrorCode StepAll(MpmModel model, PetscReal time, MpmOutcome *outcome)
{
  MpmLaboratory  *laboratory = model->laboratory;
  MpmPointControl control;
  PetscInt        t;

  PetscFunctionBeginUser;
  model->solver.iterations.newton = model->solver.iterations.linear = 0;
  for (t = 0; t < laboratory->count; t++) {
    MpmStressPoint *point = &laboratory->tests[t].point;

    MpmPointPathAt(&laboratory->tests[t].path, time, &control);
    PetscCall(MpmStressPointStep(point, &control, time - model->state.time, outcome));
    model->solver.iterations.newton += point->equations.newton;
    model->solver.iterations.linear += point->equations.linear;
    if (outcome->code) break;
  }
  while (outcome->code && t-- > 0) PetscCall(MpmStressPointRollBack(&laboratory->tests[t].point));
  model->solver.iterations.newton_total += model->solver.iterations.newton;
  model->solver.iterations.linear_total += model->solver.iterations.linear;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* One step that ends at `target` or, where that fails, before it; `nominal` is the scene's own length. */
static PetscErrorCode Advance(MpmModel model, PetscReal target, PetscReal nominal, PetscReal *dt)
{
  MpmLaboratory *laboratory = model->laboratory;
  MpmOutcome    *outcome    = &model->caller.outcome;
  PetscReal      time;
  PetscLogDouble since;

  PetscFunctionBeginUser;
  model->state.cuts.step = 0;
  for (;;) {
    const PetscReal left = target - model->state.time, wanted = laboratory->fraction * nominal;

    time = wanted > left * (1. - 1e-3) ? target : model->state.time + wanted;
    *dt  = time - model->state.time;
    PetscCall(MpmMonitorBegin(&model->monitor, MPM_TIME_SOLVE, &since));
    PetscCall(StepAll(model, time, outcome));
    PetscCall(MpmMonitorEnd(&model->monitor, MPM_TIME_SOLVE, since));
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

/* The next end of a step of any test's own, and how long such a step is. */
static PetscReal FindTarget(const MpmLaboratory *laboratory, PetscReal now, PetscReal *nominal)
{
  PetscReal target = PETSC_INFINITY, length;

  *nominal = 0.;

  for (PetscInt t = 0; t < laboratory->count; t++) {
    const PetscReal end = MpmPointPathTarget(&laboratory->tests[t].path, now, &length);

    if (end >= target) continue;
    target   = end;
    *nominal = length;
  }
  return target;
}

PetscErrorCode MpmLaboratoryStep(MpmModel model)
{
  const PetscReal now = model->state.time, wanted = model->state.dt.wanted, end = model->state.period.run_end;
  PetscReal       nominal, target = FindTarget(model->laboratory, now, &nominal);

  PetscFunctionBeginUser;
  MpmOutcomeClear(&model->caller.outcome);
  if (wanted > 0.) {
    target                      = now + wanted > end * (1. - 1e-12) ? end : now + wanted;
    nominal                     = wanted;
    model->laboratory->fraction = 1.;
  }
  PetscCall(Advance(model, target, nominal, &model->results->dt));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscBool MpmLaboratoryIsAtEnd(const MpmModel model)
{
  return (PetscBool)(model->state.time >= model->state.period.run_end);
}

PetscErrorCode MpmLaboratoryRunSteps(MpmModel model, PetscBool *interrupted)
{
  MpmOutcome *outcome = &model->caller.outcome;
  char        text[512];

  PetscFunctionBeginUser;
  *interrupted = PETSC_FALSE;
  MpmOutcomeClear(outcome);
  PetscCall(Describe(model, sizeof(text), text));
  PetscCall(MpmTerminalBegin(model, text));
  PetscCall(MpmLaboratoryAddColumns(model, &model->results->columns));
  PetscCall(MpmGradientBegin(model));
  PetscCall(MpmHistoryOpen(model));
  if (model->gradient) PetscCall(MpmGradientCollect(model));
  while (!*interrupted && !MpmLaboratoryIsAtEnd(model)) {
    PetscCall(MpmLaboratoryStep(model));
    if (outcome->code) break;
    PetscCall(MpmModelWriteHistory(model));
    PetscCall(MpmTerminalStep(model, model->results->dt));
    PetscCall(MpmGradientRecord(model));
    PetscCall(IsInterrupted(model, interrupted));
  }
  if (outcome->code)
    PetscCall(MpmTerminalWarn(model, "gave up after step %" PetscInt_FMT " at time %g: %s", model->state.step,
                              (double)model->state.time, outcome->text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmLaboratoryDestroy(MpmLaboratory **laboratory)
{
  PetscFunctionBeginUser;
  if (!*laboratory) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt t = 0; t < (*laboratory)->count && (*laboratory)->tests; t++) {
    PetscCall(MpmStressPointDestroy(&(*laboratory)->tests[t].point));
    PetscCall(MpmPointPathDestroy(&(*laboratory)->tests[t].path));
  }
  PetscCall(PetscFree((*laboratory)->tests));
  if ((*laboratory)->names) PetscCall(MpmNamesDestroy((*laboratory)->count, &(*laboratory)->names));
  PetscCall(PetscFree((*laboratory)->states));
  PetscCall(PetscFree(*laboratory));
  PetscFunctionReturn(PETSC_SUCCESS);
}

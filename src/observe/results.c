/*
  Data of the model for its writers: points and summary.
*/
#include "options/options.h"
#include "point/layout.h"
#include "grid/grid.h"
#include "grid/shape.h"
#include "handover/handover.h"
#include "particles/body.h"
#include "particles/particles.h"
#include "query/model.h"
#include "query/query.h"
#include "runout/runout.h"
#include "observe/lines.h"
#include "observe/point_columns.h"
#include "observe/results.h"
#include "observe/tracks.h"

PetscErrorCode MpmResultsDestroy(MpmModel model)
{
  MpmResults *results = model->results;

  PetscFunctionBeginUser;
  PetscCall(MpmLinesDestroy(model));
  for (PetscInt k = 0; results->tracks.at && k < results->tracks.count; k++)
    PetscCall(MpmTrackDestroy(&results->tracks.at[k]));
  PetscCall(PetscFree(results->tracks.at));
  PetscCall(MpmNamesDestroy(results->tracks.count, &results->tracks.names));
  PetscCall(MpmNamesDestroy(results->states.chosen_count, &results->states.chosen));
  PetscCall(MpmNamesDestroy(results->states.derived_count, &results->states.derived));
  PetscCall(PetscFree(results->states.fields.at));
  PetscCall(PetscFree(results->added.fields.at));
  PetscCall(PetscFree2(results->derivatives.names, results->derivatives.methods));
  PetscCall(PetscFree2(results->derivatives.gradient, results->derivatives.errors));
  PetscCall(PetscFree(results->derivatives.tangent));
  PetscCall(PetscFree(results->derivatives.fields));
  PetscCall(MpmColumnsDestroy(&results->columns));
  PetscCall(MpmColumnsDestroy(&results->added.columns));
  PetscCall(PetscFree(results->history_row));
  PetscCall(MpmOutputDestroy(&results->states.file));
  PetscCall(MpmHistoryDestroy(&results->history));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- states ---- */

PetscErrorCode MpmOutputSetFromOptions(MpmModel model, const MpmOptions *block)
{
  static const char *const words[]   = {"double", "single", NULL};
  const MpmRow             row       = {"output_step", MPM_ROW_INT, MPM_ROW_RUN, &model->results->states.step, 0, 0};
  PetscInt                 precision = 0;

  PetscFunctionBeginUser;
  PetscCall(MpmRowsAdd(model->state.rows, NULL, 1, &row));
  PetscCall(MpmOptionsBool(block, "grid", "write the grid too: its active nodes and cells",
                           &model->results->states.grid, NULL));
  PetscCall(MpmOptionsBool(block, "state_files",
                           "write an XDMF index for each state too, PREFIX_000010.xdmf, for programs that read one "
                           "state a file",
                           &model->results->states.alone, NULL));
  PetscCall(MpmOptionsBool(block, "air", "write the points of air, too", &model->results->states.air, NULL));
  PetscCall(MpmOptionsWord(block, "precision", "of the reals that are written", words, MPM_OPTIONAL, &precision, NULL));
  model->results->states.single = (PetscBool)(precision == 1);
  PetscCall(MpmOptionsNames(block, "fields",
                            "fields of the points that are written besides id and position; default: all", MPM_OPTIONAL,
                            &model->results->states.chosen_count, &model->results->states.chosen));
  PetscCall(MpmOptionsNames(block, "derived",
                            "fields of the points made from others, written besides: green_lagrange_strain, "
                            "logarithmic_strain, volumetric_strain, deviatoric_strain, principal_stress, p, q, "
                            "mobilised_friction, excess_pressure; or all",
                            MPM_OPTIONAL, &model->results->states.derived_count, &model->results->states.derived));
  if (!MpmOptionsHelp()) PetscCall(MpmFieldsSetUp(model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmModelWriteGrid(MpmModel model)
{
  PetscLogDouble since;

  PetscFunctionBeginUser;
  if (!model->results->states.grid) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmMonitorBegin(&model->monitor, MPM_TIME_OUTPUT, &since));
  PetscCall(MpmLatticeWrite(model));
  PetscCall(MpmMonitorEnd(&model->monitor, MPM_TIME_OUTPUT, since));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmModelWriteState(MpmModel model)
{
  PetscLogDouble since;

  PetscFunctionBeginUser;
  PetscCall(MpmMonitorBegin(&model->monitor, MPM_TIME_OUTPUT, &since));
  PetscCall(MpmFieldsWrite(model));
  model->results->states.step = model->state.step;
  PetscCall(MpmMonitorEnd(&model->monitor, MPM_TIME_OUTPUT, since));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- summary ---- */

/* Runout, and bodies made from columns or into them; NULL where there are neither. To be freed. */
static PetscErrorCode WriteTerrain(MpmModel model, char **lines)
{
  const char *separator = "";
  char       *runout;

  PetscFunctionBeginUser;
  *lines = NULL;
  PetscCall(MpmRunoutSummary(model, &runout));
  if (runout) PetscCall(MpmTextAppend(lines, "  \"runout\": {%s},\n", runout));
  PetscCall(PetscFree(runout));
  for (PetscInt b = 0; model->scene.bodies && b < model->scene.bodies->count; b++) {
    const struct MpmHandover *from = MpmBodyHandover(model->scene.bodies->at[b]);

    if (!from) continue;
    PetscCall(MpmTextAppend(lines, "%s\"%s\": {%s}", *separator ? separator : "  \"handover\": {",
                            model->scene.bodies->names[b], from->entries));
    separator = ", ";
  }
  if (*separator) PetscCall(MpmTextAppend(lines, "},\n"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmModelWriteSummary(MpmModel model, const char *status)
{
  MpmSummary     summary = {.status                   = status,
                            .dim                      = model->disc.dim,
                            .scene.title              = model->scene.name.title,
                            .scene.physics            = model->scene.physics.name,
                            .scene.shape              = MpmShapeName(model->scene.shape.type),
                            .solution.jacobian        = MpmJacobianTypes[model->solver.jacobian.form],
                            .solution.solver          = model->solver.preset.name,
                            .points                   = model->state.particles->total,
                            .cells                    = 1,
                            .active_dofs_max          = model->state.active_dofs_max,
                            .effort.steps             = model->state.step,
                            .effort.step_cuts         = model->state.cuts.total,
                            .effort.newton_iterations = model->solver.iterations.newton_total,
                            .effort.linear_iterations = model->solver.iterations.linear_total,
                            .imbalance                = model->state.particles->imbalance,
                            .rebalances               = model->state.particles->rebalances,
                            .reduces                  = MpmStagesReduce(model),
                            .factor_of_safety         = model->state.safety.factor,
                            .relaxes                  = MpmStagesRelax(model),
                            .criteria                 = {model->state.relaxing.first, model->state.relaxing.since},
                            .derivatives              = {.count     = model->results->derivatives.count,
                                                         .names     = model->results->derivatives.names,
                                                         .methods   = model->results->derivatives.methods,
                                                         .values    = model->results->derivatives.gradient,
                                                         .errors    = model->results->derivatives.errors,
                                                         .fields    = model->results->derivatives.fields,
                                                         .objective = model->results->derivatives.objective,
                                                         .inverse   = model->results->derivatives.inverse}};
  char           path[PETSC_MAX_PATH_LEN], *terrain;
  PetscLogDouble now;

  PetscFunctionBeginUser;
  PetscCall(MpmMultigridLevels(&model->solver, &summary.effort.levels));
  if (!(summary.factor_of_safety > 0.) && model->caller.outcome.code && MpmReductionSeeks(model))
    summary.factor_of_safety = model->state.safety.reduced; /* a lower bound */
  PetscCall(PetscArraycpy(summary.changes, model->monitor.changes, MPM_CHANGE_COUNT));
  for (PetscInt a = 0; a < model->disc.dim; a++) summary.cells *= model->disc.grid->cells[a];
  if (model->laboratory) {
    summary.scene.physics     = MPM_STRESS_POINT;
    summary.scene.shape       = NULL;
    summary.solution.jacobian = MpmJacobianTypes[MPM_JACOBIAN_LOCAL];
    summary.solution.solver   = "direct";
  }
  PetscCall(WriteTerrain(model, &terrain));
  summary.terrain = terrain;
  PetscCall(PetscTime(&now));
  summary.time_total = now - model->results->start;
  PetscCall(PetscArraycpy(summary.time, model->monitor.seconds, MPM_TIME_COUNT));
  PetscCall(MpmSummaryReduce(model->comm, &summary));
  PetscCall(PetscSNPrintf(path, sizeof(path), "%s_summary.json", model->scene.name.prefix));
  PetscCall(MpmSummaryWrite(model->comm, path, MPM_VERSION, &summary));
  PetscCall(PetscFree(terrain));
  if (MpmTerminalShows(model)) PetscCall(MpmTerminalSummary(model->comm, &summary));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  What the model hands to its writers: points, history, summary.
*/
#include "mpmimpl.h"

static PetscErrorCode ResultPath(MpmModel model, const char *suffix, char path[], size_t size)
{
  PetscFunctionBeginUser;
  PetscCall(PetscSNPrintf(path, size, "%s%s", model->prefix, suffix));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- states ---- */

PetscErrorCode MpmOutputSetFromOptions(MpmModel model, const MpmOptions *block)
{
  static const char *const words[]   = {"double", "single", NULL};
  PetscInt                 precision = 0;

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsBool(block, "grid", "write the grid too: its active nodes and cells", &model->output_grid, NULL));
  PetscCall(MpmOptionsWord(block, "precision", "of the reals that are written", words, MPM_OPTIONAL, &precision, NULL));
  model->output_single = (PetscBool)(precision == 1);
  PetscCall(MpmOptionsNames(block, "fields",
                            "fields of the points that are written besides id and position; default: all", MPM_OPTIONAL,
                            &model->output_field_count, &model->output_fields));
  if (!MpmOptionsHelp()) PetscCall(MpmFieldsCheck(model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmModelWriteOutput(MpmModel model)
{
  PetscLogDouble since;

  PetscFunctionBeginUser;
  PetscCall(PetscTime(&since));
  PetscCall(MpmFieldsWrite(model));
  if (model->output_grid) PetscCall(MpmLatticeWrite(model));
  model->output_step = model->step;
  MpmClock(model, MPM_TIME_OUTPUT, since);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- history ---- */

/* Names the columns; returns how many there are. Names are allocated. */
static PetscErrorCode HistoryColumns(MpmModel model, PetscInt *count, char ***names)
{
  static const char *const first[] = {"step", "time", "dt", "newton", "linear", "cuts", "load"};
  const PetscInt           dim = model->grid.dim, fixed = (PetscInt)PETSC_STATIC_ARRAY_LENGTH(first);
  PetscInt                 capacity = fixed + model->track_count * dim + model->bc_count * (model->layout.block + 1) +
                      model->boundary_count * (dim + 1) + 1;
  char name[512];

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(capacity, names));
  *count = 0;
  for (PetscInt k = 0; k < fixed; k++) PetscCall(PetscStrallocpy(first[k], &(*names)[(*count)++]));
  for (PetscInt b = 0; b < model->bc_count; b++) {
    for (PetscInt k = 0; k < model->bcs[b].component_count; k++) {
      PetscCall(PetscSNPrintf(name, sizeof(name), "reaction_%s_%s", model->bc_names[b],
                              model->layout.component_name[model->bcs[b].component[k]]));
      PetscCall(PetscStrallocpy(name, &(*names)[(*count)++]));
    }
    if (model->bcs[b].inclined) { /* along the normal */
      PetscCall(PetscSNPrintf(name, sizeof(name), "reaction_%s_n", model->bc_names[b]));
      PetscCall(PetscStrallocpy(name, &(*names)[(*count)++]));
    }
  }
  for (PetscInt b = 0; b < model->boundary_count; b++) {
    for (PetscInt a = 0; a < dim; a++) {
      PetscCall(PetscSNPrintf(name, sizeof(name), "reaction_%s_%c", model->boundary_names[b], "xyz"[a]));
      PetscCall(PetscStrallocpy(name, &(*names)[(*count)++]));
    }
    PetscCall(PetscSNPrintf(name, sizeof(name), "depth_%s", model->boundary_names[b]));
    PetscCall(PetscStrallocpy(name, &(*names)[(*count)++]));
  }
  for (PetscInt t = 0; t < model->track_count; t++) {
    for (PetscInt a = 0; a < dim; a++) {
      PetscCall(PetscSNPrintf(name, sizeof(name), "track_%s_u%c", model->track_names[t], "xyz"[a]));
      PetscCall(PetscStrallocpy(name, &(*names)[(*count)++]));
    }
  }
  if (model->stages[0].name) PetscCall(PetscStrallocpy("stage", &(*names)[(*count)++]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmModelCreateHistory(MpmModel model)
{
  const MpmOptions options = {model->comm, "mpm_", model->record};
  char             path[PETSC_MAX_PATH_LEN], **names;
  PetscLogDouble   since;

  PetscFunctionBeginUser;
  PetscCall(PetscTime(&since));
  PetscCall(HistoryColumns(model, &model->history_columns, &names));
  PetscCall(ResultPath(model, "_history.csv", path, sizeof(path)));
  if (model->checkpoint.restart) PetscCall(MpmRestartHistory(model, path, (const char *const *)names));
  else {
    PetscCall(MpmHistoryCreate(model->comm, path, model->history_columns, (const char *const *)names, &model->history));
  }
  PetscCall(PetscMalloc1(model->history_columns, &model->history_row));
  PetscCall(MpmNamesDestroy(model->history_columns, &names));
  PetscCall(ResultPath(model, "_options.yaml", path, sizeof(path)));
  PetscCall(MpmOptionsWriteYAML(&options, path));
  MpmClock(model, MPM_TIME_OUTPUT, since);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmModelWriteHistory(MpmModel model, PetscReal dt)
{
  PetscReal     *row = model->history_row;
  PetscInt       k   = 0;
  PetscLogDouble since;

  PetscFunctionBeginUser;
  PetscCall(PetscTime(&since));
  row[k++] = (PetscReal)model->step;
  row[k++] = model->time;
  row[k++] = dt;
  row[k++] = (PetscReal)model->newton;
  row[k++] = (PetscReal)model->linear;
  row[k++] = (PetscReal)model->cuts;
  row[k++] = model->load_count ? MpmModelLoadFactor(model, 0, model->time) : 0.;
  for (PetscInt b = 0; b < model->bc_count; b++) {
    const PetscReal *reaction = &model->reaction[b * model->layout.block];

    for (PetscInt c = 0; c < model->bcs[b].component_count; c++) row[k++] = reaction[model->bcs[b].component[c]];
    if (!model->bcs[b].inclined) continue;
    row[k] = 0.;
    for (PetscInt a = 0; a < model->grid.dim; a++) row[k] += reaction[a] * model->bcs[b].normal[a];
    k++;
  }
  for (PetscInt b = 0; b < model->boundary_count; b++) {
    for (PetscInt a = 0; a < model->grid.dim; a++) row[k++] = model->contacts.reaction[b][a];
    row[k++] = model->contacts.depth[b];
  }
  for (PetscInt t = 0; t < model->track_count; t++, k += model->grid.dim)
    PetscCall(MpmTrackEvaluate(&model->tracks[t], &model->particles, &row[k]));
  if (model->stages[0].name) row[k] = (PetscReal)model->stage + 1.;
  PetscCall(MpmHistoryAppend(model->history, row));
  MpmClock(model, MPM_TIME_OUTPUT, since);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- summary ---- */

PetscErrorCode MpmModelWriteSummary(MpmModel model, const char *status)
{
  MpmSummary     summary = {.status            = status,
                            .dim               = model->grid.dim,
                            .title             = model->title,
                            .physics           = model->physics.name,
                            .shape             = MpmShapeTypes[model->shape],
                            .jacobian          = MpmJacobianTypes[model->jacobian_type],
                            .solver            = model->solver,
                            .points            = model->particles.total,
                            .cells             = 1,
                            .active_dofs_max   = model->active_dofs_max,
                            .steps             = model->step,
                            .step_cuts         = model->cuts_total,
                            .newton_iterations = model->newton_total,
                            .linear_iterations = model->linear_total,
                            .imbalance         = model->particles.imbalance,
                            .rebalances        = model->particles.rebalances};
  char           path[PETSC_MAX_PATH_LEN];
  PetscLogDouble now;

  PetscFunctionBeginUser;
  for (PetscInt a = 0; a < model->grid.dim; a++) summary.cells *= model->grid.cells[a];
  PetscCall(PetscTime(&now));
  summary.time_total = now - model->start;
  PetscCall(PetscArraycpy(summary.time, model->seconds, MPM_TIME_COUNT));
  PetscCall(MpmSummaryReduce(model->comm, &summary));
  PetscCall(ResultPath(model, "_summary.json", path, sizeof(path)));
  PetscCall(MpmSummaryWrite(model->comm, path, MPM_VERSION, &summary));
  if (!model->quiet) PetscCall(MpmSummaryPrint(model->comm, &summary));
  PetscFunctionReturn(PETSC_SUCCESS);
}

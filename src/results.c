/*
  What the model hands to its writers: points, history, summary.
*/
#include "mpmimpl.h"
#include <sys/resource.h>

static PetscErrorCode ResultPath(MpmModel model, const char *suffix, char path[], size_t size)
{
  PetscFunctionBeginUser;
  PetscCall(PetscSNPrintf(path, size, "%s%s", model->prefix, suffix));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- points ---- */

/* Arrays that are made for one output and freed after it. */
typedef struct {
  PetscInt    count, capacity;
  MpmDataset *set;
  PetscReal **made; /* NULL where the array belongs to the particles */
} Datasets;

static PetscErrorCode AddDataset(Datasets *sets, const char *name, PetscInt components, PetscInt rows, PetscReal **made)
{
  PetscFunctionBeginUser;
  PetscCheck(sets->count < sets->capacity, PETSC_COMM_SELF, PETSC_ERR_PLIB, "too many datasets");
  PetscCall(PetscCalloc1((rows * components + 1), made));
  sets->made[sets->count]  = *made;
  sets->set[sets->count++] = (MpmDataset){name, components, *made, NULL};
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Symmetric tensors are written with six components: xx, yy, zz, xy, yz, xz. */
static void CopySym(PetscInt dim, const PetscReal from[], PetscReal to[])
{
  for (PetscInt c = 0; c < (dim == 2 ? 4 : 6); c++) to[c] = from[c];
}

/* Every history variable by its name; zero where a point's law has no such variable. */
static PetscErrorCode AddStates(MpmModel model, const MpmPoints *points, Datasets *sets)
{
  const PetscInt dim = model->grid.dim;

  PetscFunctionBeginUser;
  for (PetscInt m = 0; m < model->material_count; m++) {
    const MpmLawInfo *info  = &model->materials[m].info;
    PetscInt          first = 0;

    for (size_t v = 0; v < info->state_count; v++) {
      const PetscInt own        = MpmStateComponents(&info->states[v], dim),
                     components = info->states[v].kind == MPM_STATE_SYM ? 6 : 1;
      PetscReal *made           = NULL;

      for (PetscInt k = 0; k < sets->count; k++)
        if (!strcmp(sets->set[k].name, info->states[v].name)) made = sets->made[k];
      if (!made) PetscCall(AddDataset(sets, info->states[v].name, components, points->count, &made));
      for (PetscInt p = 0; p < points->count; p++) {
        const PetscReal *state = &points->state[p * model->particles.state_size + first];

        if (points->material[p] != m) continue;
        if (components == 6) CopySym(dim, state, &made[6 * p]);
        else made[p] = state[0];
      }
      first += own;
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Displacement, stress, F, volume and mass of every point. */
static PetscErrorCode AddKinematics(MpmModel model, const MpmPoints *points, Datasets *sets)
{
  const PetscInt dim = model->grid.dim, n = points->count;
  PetscReal     *displacement, *stress, *volume, *mass, *F;

  PetscFunctionBeginUser;
  PetscCall(AddDataset(sets, "displacement", dim, n, &displacement));
  PetscCall(AddDataset(sets, "stress", 6, n, &stress));
  PetscCall(AddDataset(sets, "volume", 1, n, &volume));
  PetscCall(AddDataset(sets, "mass", 1, n, &mass));
  PetscCall(AddDataset(sets, "F", 9, n, &F));
  for (PetscInt p = 0; p < n; p++) {
    const PetscReal *f  = &points->F[p * dim * dim];
    PetscReal       *f9 = &F[9 * p];

    for (PetscInt a = 0; a < dim; a++) displacement[p * dim + a] = points->x[p * dim + a] - points->x0[p * dim + a];
    CopySym(dim, &points->stress[p * model->particles.stress_size], &stress[6 * p]);
    f9[8] = 1.;
    for (PetscInt a = 0; a < dim; a++)
      for (PetscInt b = 0; b < dim; b++) f9[3 * a + b] = f[a * dim + b];
    volume[p] =
      points->volume0[p] * (f9[0] * (f9[4] * f9[8] - f9[5] * f9[7]) - f9[1] * (f9[3] * f9[8] - f9[5] * f9[6]) +
                            f9[2] * (f9[3] * f9[7] - f9[4] * f9[6]));
    mass[p] = points->volume0[p] * model->materials[points->material[p]].density;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmModelWriteOutput(MpmModel model)
{
  const PetscInt dim  = model->grid.dim;
  Datasets       sets = {.capacity = 12};
  MpmPoints      points;
  PetscLogDouble since;

  PetscFunctionBeginUser;
  PetscCall(PetscTime(&since));
  for (PetscInt m = 0; m < model->material_count; m++) sets.capacity += (PetscInt)model->materials[m].info.state_count;
  for (PetscInt r = 0; r < model->layout.rates; r++) sets.capacity++;
  PetscCall(PetscCalloc2(sets.capacity, &sets.set, sets.capacity, &sets.made));
  if (!model->output) PetscCall(MpmOutputCreate(model->comm, model->prefix, &model->output));
  PetscCall(MpmParticlesGetArrays(&model->particles, &points));
  sets.set[sets.count++] = (MpmDataset){"material", 1, NULL, points.material};
  sets.set[sets.count++] = (MpmDataset){"position", dim, points.x, NULL};
  if (!model->step) sets.set[sets.count++] = (MpmDataset){"position0", dim, points.x0, NULL};
  PetscCall(AddKinematics(model, &points, &sets));
  PetscCall(AddStates(model, &points, &sets));
  for (PetscInt r = 0; r < model->layout.rates; r++) {
    PetscReal *value;

    PetscCall(
      AddDataset(&sets, model->layout.component_name[model->layout.rate_component[r]], 1, points.count, &value));
    for (PetscInt p = 0; p < points.count; p++) value[p] = points.value[p * model->layout.rates + r];
  }
  PetscCall(MpmOutputWrite(model->output, model->step, model->time, points.count, points.id, sets.count, sets.set));
  PetscCall(MpmParticlesRestoreArrays(&model->particles, &points));
  for (PetscInt k = 0; k < sets.count; k++) PetscCall(PetscFree(sets.made[k]));
  PetscCall(PetscFree2(sets.set, sets.made));
  MpmClock(model, MPM_TIME_OUTPUT, since);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- history ---- */

/* Names the columns; returns how many there are. Names are allocated. */
static PetscErrorCode HistoryColumns(MpmModel model, PetscInt *count, char ***names)
{
  static const char *const first[] = {"step", "time", "dt", "newton", "linear", "cuts", "load"};
  const PetscInt           dim = model->grid.dim, fixed = (PetscInt)PETSC_STATIC_ARRAY_LENGTH(first);
  PetscInt                 capacity = fixed + model->track_count * dim + model->bc_count * model->layout.block;
  char                     name[512];

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
  }
  for (PetscInt t = 0; t < model->track_count; t++) {
    for (PetscInt a = 0; a < dim; a++) {
      PetscCall(PetscSNPrintf(name, sizeof(name), "track_%s_u%c", model->track_names[t], "xyz"[a]));
      PetscCall(PetscStrallocpy(name, &(*names)[(*count)++]));
    }
  }
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
  PetscCall(MpmHistoryCreate(model->comm, path, model->history_columns, (const char *const *)names, &model->history));
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
  row[k++] = model->load_count ? MpmRampEvaluate(model->loads[0].ramp, model->time) : 0.;
  for (PetscInt b = 0; b < model->bc_count; b++) {
    for (PetscInt c = 0; c < model->bcs[b].component_count; c++)
      row[k++] = model->reaction[b * model->layout.block + model->bcs[b].component[c]];
  }
  for (PetscInt t = 0; t < model->track_count; t++, k += model->grid.dim)
    PetscCall(MpmTrackEvaluate(&model->tracks[t], &model->particles, &row[k]));
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
  struct rusage  usage;
  PetscLogDouble now;

  PetscFunctionBeginUser;
  for (PetscInt a = 0; a < model->grid.dim; a++) summary.cells *= model->grid.cells[a];
  PetscCall(PetscTime(&now));
  summary.time_total = now - model->start;
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &summary.time_total, 1, MPIU_REAL, MPIU_MAX, model->comm));
  PetscCall(MPIU_Allreduce(model->seconds, summary.time, MPM_TIME_COUNT, MPIU_REAL, MPIU_MAX, model->comm));
  getrusage(RUSAGE_SELF, &usage);
  summary.memory_max = 1024. * (PetscReal)usage.ru_maxrss;
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &summary.memory_max, 1, MPIU_REAL, MPIU_SUM, model->comm));
  PetscCall(ResultPath(model, "_summary.json", path, sizeof(path)));
  PetscCall(MpmSummaryWrite(model->comm, path, MPM_VERSION, &summary));
  if (!model->quiet) PetscCall(MpmSummaryPrint(model->comm, &summary));
  PetscFunctionReturn(PETSC_SUCCESS);
}

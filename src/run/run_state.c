/*
  The numbers of a run that a checkpoint holds besides its points.

  One line of the table below is all that a further one needs. A checkpoint without it, of an earlier version, leaves the
  model's value as it is.
*/
#include <stddef.h>
#include "run/run.h"

typedef enum { KIND_REAL, KIND_INT, KIND_INT64, KIND_BOOL } Kind;

static const struct {
  const char *name;
  Kind        kind;
  PetscBool   results; /* a member of the results, not of the model itself */
  size_t      offset;
} table[] = {
#define MODEL(name, kind, member) \
  { \
    name, KIND_##kind, PETSC_FALSE, offsetof(struct _p_MpmModel, member) \
  }
#define RESULTS(name, kind, member) \
  { \
    name, KIND_##kind, PETSC_TRUE, offsetof(struct MpmResults, member) \
  }
  MODEL("time", REAL, state.time),
  MODEL("step", INT, state.step),
  MODEL("step_cuts", INT, state.cuts_total),
  MODEL("step_length", REAL, state.dt_nominal),
  MODEL("step_wanted", REAL, state.dt_wanted),
  MODEL("step_last", REAL, state.dt_last),
  MODEL("step_before_last", REAL, state.dt_before),
  MODEL("newton_iterations", INT64, solver.newton_total),
  MODEL("linear_iterations", INT64, solver.linear_total),
  MODEL("active_dofs_max", INT64, state.active_dofs_max),
  MODEL("ghost", REAL, disc.ghost),
  MODEL("ghost_rescue", BOOL, state.rescue.ghost),
  MODEL("leaves_dilation", BOOL, state.rescue.dilation),
  MODEL("indefinite", BOOL, solver.indefinite),
  MODEL("jacobians_last", INT, solver.cache.made_count_last),
  RESULTS("output_step", INT, output_step),
  RESULTS("run", INT64, checkpoint.run),
  MODEL("stage", INT, state.stage),
  MODEL("stage_start", REAL, state.time_start),
  MODEL("reference_output", BOOL, state.reference_output),
  MODEL("reduction_height", REAL, state.safety.height),
  MODEL("factor_of_safety", REAL, state.safety.factor),
  MODEL("reduction_moved", REAL, state.safety.moved),
  MODEL("reduction_last", REAL, state.safety.reduced),
  MODEL("grid_known", BOOL, state.grid.known),
  MODEL("grid_start_x", REAL, state.grid.start[0]),
  MODEL("grid_start_y", REAL, state.grid.start[1]),
  MODEL("grid_start_z", REAL, state.grid.start[2]),
  MODEL("grid_moved_x", REAL, state.grid.moved[0]),
  MODEL("grid_moved_y", REAL, state.grid.moved[1]),
  MODEL("grid_moved_z", REAL, state.grid.moved[2]),
#undef MODEL
#undef RESULTS
};

/* Where the number stands in a model. */
static void *Member(MpmModel model, PetscInt k)
{
  return (table[k].results ? (char *)model->results : (char *)model) + table[k].offset;
}

PetscErrorCode MpmScalarsCreate(MpmModel model, MpmScalars *scalars)
{
  const PetscInt count = (PetscInt)PETSC_STATIC_ARRAY_LENGTH(table);

  PetscFunctionBeginUser;
  scalars->count = count;
  PetscCall(PetscCalloc5(count, &scalars->name, count, &scalars->real, count, &scalars->there, count, &scalars->value,
                         count, &scalars->number));
  for (PetscInt k = 0; k < count; k++) {
    const void *member = Member(model, k);

    scalars->name[k]  = table[k].name;
    scalars->real[k]  = (PetscBool)(table[k].kind == KIND_REAL);
    scalars->there[k] = PETSC_TRUE;
    if (table[k].kind == KIND_REAL) scalars->value[k] = *(const PetscReal *)member;
    if (table[k].kind == KIND_INT) scalars->number[k] = *(const PetscInt *)member;
    if (table[k].kind == KIND_INT64) scalars->number[k] = *(const PetscInt64 *)member;
    if (table[k].kind == KIND_BOOL) scalars->number[k] = *(const PetscBool *)member;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmScalarsRestore(const MpmScalars *scalars, const char *begin, MpmModel model)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < scalars->count; k++) {
    void *member = Member(model, k);

    if (!scalars->there[k] || strncmp(scalars->name[k], begin, strlen(begin))) continue;
    if (table[k].kind == KIND_REAL) *(PetscReal *)member = scalars->value[k];
    if (table[k].kind == KIND_INT) *(PetscInt *)member = (PetscInt)scalars->number[k];
    if (table[k].kind == KIND_INT64) *(PetscInt64 *)member = scalars->number[k];
    if (table[k].kind == KIND_BOOL) *(PetscBool *)member = (PetscBool)scalars->number[k];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmScalarsDestroy(MpmScalars *scalars)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree5(scalars->name, scalars->real, scalars->there, scalars->value, scalars->number));
  scalars->count = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

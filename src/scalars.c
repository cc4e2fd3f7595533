/*
  The numbers of a run that a checkpoint holds besides its points.

  One line of the table below is all that a further one needs. A checkpoint without it, of an earlier version, leaves the
  model's value as it is.
*/
#include <stddef.h>
#include "mpmimpl.h"

typedef enum { KIND_REAL, KIND_INT, KIND_INT64, KIND_BOOL } Kind;

static const struct {
  const char *name;
  Kind        kind;
  size_t      offset;
} table[] = {
#define SCALAR(name, kind, member) {name, KIND_##kind, offsetof(struct _p_MpmModel, member)},
  SCALAR("time", REAL, time) SCALAR("step", INT, step) SCALAR("step_cuts", INT, cuts_total)
    SCALAR("step_length", REAL, dt_nominal) SCALAR("step_wanted", REAL, dt_wanted) SCALAR("step_last", REAL, dt_last)
      SCALAR("step_before_last", REAL, dt_before) SCALAR("newton_iterations", INT64, newton_total)
        SCALAR("linear_iterations", INT64, linear_total) SCALAR("active_dofs_max", INT64, active_dofs_max)
          SCALAR("ghost", REAL, ghost) SCALAR("ghost_rescue", BOOL, ghost_rescue) SCALAR("indefinite", BOOL, indefinite)
            SCALAR("jacobians_last", INT, made_count_last) SCALAR("output_step", INT, output_step)
              SCALAR("run", INT64, checkpoint.run) SCALAR("stage", INT, stage) SCALAR("stage_start", REAL, time_start)
                SCALAR("reference_output", BOOL, reference_output)
#undef SCALAR
};

PetscErrorCode MpmScalarsCreate(MpmModel model, MpmScalars *scalars)
{
  const PetscInt count = (PetscInt)PETSC_STATIC_ARRAY_LENGTH(table);

  PetscFunctionBeginUser;
  scalars->count = count;
  PetscCall(PetscCalloc5(count, &scalars->name, count, &scalars->real, count, &scalars->there, count, &scalars->value,
                         count, &scalars->number));
  for (PetscInt k = 0; k < count; k++) {
    const void *member = (const char *)model + table[k].offset;

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

PetscErrorCode MpmScalarsRestore(const MpmScalars *scalars, MpmModel model)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < scalars->count; k++) {
    void *member = (char *)model + table[k].offset;

    if (!scalars->there[k]) continue;
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

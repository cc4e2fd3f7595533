/*
  The numbers of a run that a checkpoint holds besides its points.

  One line of the table below is all that a further one needs. A checkpoint without it, of an earlier version, leaves the
  model's value as it is.
*/
#include <stddef.h>
#include "terms/rigid_body.h"
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
#undef MODEL
#undef RESULTS
};

#define TABLE_COUNT ((PetscInt)PETSC_STATIC_ARRAY_LENGTH(table))

/* Numbers of a place of a free body, and how many bodies there are; the k-th is a boundary of the scene. */
#define PLACE_COUNT ((PetscInt)(sizeof(MpmPlacement) / sizeof(PetscReal)))

static PetscInt FreeBoundary(const MpmModel model, PetscInt k, PetscInt *count)
{
  PetscInt found = -1;

  *count = 0;
  for (PetscInt b = 0; model->scene.boundaries && b < model->scene.boundaries->count; b++)
    if (model->scene.boundaries->at[b].freedom && (*count)++ == k) found = b;
  return found;
}

static Kind KindOf(PetscInt k)
{
  return k < TABLE_COUNT ? table[k].kind : KIND_REAL;
}

/* Where the number stands in a model. */
static void *Member(MpmModel model, PetscInt k)
{
  PetscInt count;

  if (k >= TABLE_COUNT) {
    const PetscInt b = FreeBoundary(model, (k - TABLE_COUNT) / PLACE_COUNT, &count);

    return (PetscReal *)&model->state.placements[b] + (k - TABLE_COUNT) % PLACE_COUNT;
  }
  return (table[k].results ? (char *)model->results : (char *)model) + table[k].offset;
}

PetscErrorCode MpmScalarsCreate(MpmModel model, MpmScalars *scalars)
{
  PetscInt bodies, count;
  char     name[512];

  PetscFunctionBeginUser;
  (void)FreeBoundary(model, 0, &bodies);
  count          = TABLE_COUNT + bodies * PLACE_COUNT;
  scalars->count = count;
  PetscCall(PetscCalloc5(count, &scalars->name, count, &scalars->real, count, &scalars->there, count, &scalars->value,
                         count, &scalars->number));
  for (PetscInt k = 0; k < count; k++) {
    const void *member = Member(model, k);

    if (k < TABLE_COUNT) PetscCall(PetscStrallocpy(table[k].name, &scalars->name[k]));
    else {
      const PetscInt b = FreeBoundary(model, (k - TABLE_COUNT) / PLACE_COUNT, &bodies);

      PetscCall(PetscSNPrintf(name, sizeof(name), "place_%s_%" PetscInt_FMT, model->scene.boundaries->names[b],
                              (k - TABLE_COUNT) % PLACE_COUNT));
      PetscCall(PetscStrallocpy(name, &scalars->name[k]));
    }
    scalars->real[k]  = (PetscBool)(KindOf(k) == KIND_REAL);
    scalars->there[k] = PETSC_TRUE;
    if (KindOf(k) == KIND_REAL) scalars->value[k] = *(const PetscReal *)member;
    if (KindOf(k) == KIND_INT) scalars->number[k] = *(const PetscInt *)member;
    if (KindOf(k) == KIND_INT64) scalars->number[k] = *(const PetscInt64 *)member;
    if (KindOf(k) == KIND_BOOL) scalars->number[k] = *(const PetscBool *)member;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmScalarsRestore(const MpmScalars *scalars, MpmModel model)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < scalars->count; k++) {
    void *member = Member(model, k);

    if (!scalars->there[k]) continue;
    if (KindOf(k) == KIND_REAL) *(PetscReal *)member = scalars->value[k];
    if (KindOf(k) == KIND_INT) *(PetscInt *)member = (PetscInt)scalars->number[k];
    if (KindOf(k) == KIND_INT64) *(PetscInt64 *)member = scalars->number[k];
    if (KindOf(k) == KIND_BOOL) *(PetscBool *)member = (PetscBool)scalars->number[k];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmScalarsDestroy(MpmScalars *scalars)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < scalars->count; k++) PetscCall(PetscFree(scalars->name[k]));
  PetscCall(PetscFree5(scalars->name, scalars->real, scalars->there, scalars->value, scalars->number));
  scalars->count = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

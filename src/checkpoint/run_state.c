/*
  The numbers of a run that a checkpoint holds besides its points.

  One line of the table below is all that a further one needs. A checkpoint without it, of an earlier version, leaves the
  model's value as it is.
*/
#include <stddef.h>
#include "bc/bc.h"
#include "contact/rigid_body.h"
#include "loads/body_surface.h"
#include "loads/load.h"
#include "query/model.h"
#include "checkpoint/checkpoint.h"

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
  MODEL("velocities_behind", REAL, state.scheme.behind),
  MODEL("contact_met", BOOL, state.scheme.met),
  MODEL("largest_change", REAL, state.scheme.largest),
  MODEL("newton_iterations", INT64, solver.newton_total),
  MODEL("linear_iterations", INT64, solver.linear_total),
  MODEL("active_dofs_max", INT64, state.active_dofs_max),
  MODEL("leaves_dilation", BOOL, state.rescue.dilation),
  MODEL("averaged_dilation", INT, state.rescue.averaged),
  MODEL("indefinite", BOOL, solver.indefinite),
  MODEL("careful", BOOL, solver.careful),
  MODEL("touched", BOOL, solver.at_rest.touched),
  MODEL("jacobians_last", INT, solver.cache.needed_count_last),
  RESULTS("output_step", INT, output_step),
  RESULTS("run", INT64, checkpoint.run),
  MODEL("stage", INT, state.stage),
  MODEL("stage_start", REAL, state.time_start),
  MODEL("points_put_back", BOOL, disc.put_back),
  MODEL("reference_output", BOOL, state.reference_output),
  MODEL("reduction_height", REAL, state.safety.height),
  MODEL("reduction_limit", REAL, state.safety.limit),
  MODEL("factor_of_safety", REAL, state.safety.factor),
  MODEL("reduction_moved", REAL, state.safety.moved),
  MODEL("reduction_last", REAL, state.safety.reduced),
  MODEL("consolidation_most", REAL, state.scheme.water.most),
  MODEL("consolidation", REAL, state.scheme.water.degree),
  MODEL("reduction_start", REAL, state.safety.start),
  MODEL("reduction_rate", REAL, state.safety.rate),
  MODEL("reduction_failed", REAL, state.safety.failed),
  MODEL("settles", BOOL, state.scheme.settling.needed),
  MODEL("settling_time", REAL, state.scheme.settling.tau),
  MODEL("slide_ways", REAL, state.scheme.slide.ways),
  MODEL("slide_forces", REAL, state.scheme.slide.forces),
  MODEL("slide_ratio", REAL, state.scheme.slide.ratio),
  MODEL("slide_steady_ways", REAL, state.scheme.slide.steady[0]),
  MODEL("slide_steady_forces", REAL, state.scheme.slide.steady[1]),
  MODEL("slide_steady_time", REAL, state.scheme.slide.steady[2]),
  MODEL("slide_slid", REAL, state.scheme.slide.slid),
  MODEL("slide_end", REAL, state.scheme.slide.end),
  MODEL("slide_span", REAL, state.scheme.slide.span),
  MODEL("slide_way", REAL, state.scheme.slide.way),
  MODEL("relaxation_energy", REAL, state.relaxing.kinetic),
  MODEL("relaxation_work", REAL, state.relaxing.work),
  MODEL("relaxation_first", REAL, state.relaxing.first),
  MODEL("relaxation_since", REAL, state.relaxing.since),
  MODEL("relaxation_reset", REAL, state.relaxing.reset),
  MODEL("relaxation_quarter", REAL, state.relaxing.quarter),
  MODEL("relaxation_resets", INT, state.relaxing.resets),
  MODEL("rescue_on", BOOL, state.scheme.rescuing.on),
  MODEL("rescue_start", REAL, state.scheme.rescuing.start),
  MODEL("rescue_end", REAL, state.scheme.rescuing.end),
  MODEL("rescue_clock", REAL, state.scheme.rescuing.clock),
  MODEL("rescue_ramp", REAL, state.scheme.rescuing.ramp),
  MODEL("rescue_work", REAL, state.scheme.rescuing.work),
  MODEL("rescue_first", REAL, state.scheme.rescuing.first),
  MODEL("rescue_since", REAL, state.scheme.rescuing.since),
  MODEL("rescue_steps", INT, state.scheme.rescuing.steps),
  MODEL("rescue_cuts", INT, state.cuts),
  MODEL("rescues", INT, state.scheme.rescuing.count),
  MODEL("grid_known", BOOL, state.grid.known),
  MODEL("grid_start_x", REAL, state.grid.start[0]),
  MODEL("grid_start_y", REAL, state.grid.start[1]),
  MODEL("grid_start_z", REAL, state.grid.start[2]),
  MODEL("grid_moved_x", REAL, state.grid.moved[0]),
  MODEL("grid_moved_y", REAL, state.grid.moved[1]),
  MODEL("grid_moved_z", REAL, state.grid.moved[2]),
  MODEL("energy_known", BOOL, state.scheme.energy.known),
  MODEL("energy_internal", REAL, state.scheme.energy.internal),
  MODEL("energy_external", REAL, state.scheme.energy.external),
  MODEL("energy_dissipated", REAL, state.scheme.energy.dissipated),
  MODEL("energy_start", REAL, state.scheme.energy.start),
  MODEL("energy_elastic", REAL, state.scheme.energy.elastic),
#undef MODEL
#undef RESULTS
};

#define TABLE ((PetscInt)PETSC_STATIC_ARRAY_LENGTH(table))

/* Numbers of a condition that moves material, behind the table; what stands in their places in the model. */
static const struct {
  const char *name;
  Kind        kind;
  size_t      offset;
} moving[] = {
  {"first", KIND_INT, offsetof(MpmActing, first)},       {"end", KIND_INT, offsetof(MpmActing, end)},
  {"volume", KIND_REAL, offsetof(MpmActing, volume)},    {"force_x", KIND_REAL, offsetof(MpmActing, force[0])},
  {"force_y", KIND_REAL, offsetof(MpmActing, force[1])}, {"force_z", KIND_REAL, offsetof(MpmActing, force[2])}};
#define MOVING ((PetscInt)PETSC_STATIC_ARRAY_LENGTH(moving))

/* Numbers of a surface, behind those. */
static const struct {
  const char *name;
  Kind        kind;
  size_t      offset;
} lasting[] = {{"first", KIND_INT, offsetof(struct MpmLoadActing, first)},
               {"end", KIND_INT, offsetof(struct MpmLoadActing, end)},
               {"outflow", KIND_REAL, offsetof(struct MpmLoadActing, outflow)}};
#define LASTING ((PetscInt)PETSC_STATIC_ARRAY_LENGTH(lasting))

/* Numbers of a place of a free body, behind those. */
#define PLACE ((PetscInt)(sizeof(MpmPlacement) / sizeof(PetscReal)))

/* How many free bodies there are; the k-th is a boundary of the scene. */
static PetscInt FreeBoundary(const MpmModel model, PetscInt k, PetscInt *count)
{
  PetscInt found = -1;

  *count = 0;
  for (PetscInt b = 0; model->scene.boundaries && b < model->scene.boundaries->count; b++)
    if (model->scene.boundaries->at[b].freedom && (*count)++ == k) found = b;
  return found;
}

typedef enum { PART_TABLE, PART_CONDITIONS, PART_SURFACES, PART_PLACES, PART_STAGES } Part;

/* The part in which the number k stands; `of` and `place`: of which condition, surface or boundary it is, and which of its numbers. */
static Part PartOf(const MpmModel model, PetscInt k, PetscInt *of, PetscInt *place)
{
  const PetscInt conditions = TABLE + MOVING * model->scene.bcs->count;
  const PetscInt surfaces   = conditions + LASTING * model->scene.surfaces->count;
  PetscInt       bodies;

  *of    = 0;
  *place = k;
  if (k < TABLE) return PART_TABLE;
  *of    = (k - TABLE) / MOVING;
  *place = (k - TABLE) % MOVING;
  if (k < conditions) return PART_CONDITIONS;
  *of    = (k - conditions) / LASTING;
  *place = (k - conditions) % LASTING;
  if (k < surfaces) return PART_SURFACES;
  *of    = FreeBoundary(model, (k - surfaces) / PLACE, &bodies);
  *place = (k - surfaces) % PLACE;
  if (k < surfaces + PLACE * bodies) return PART_PLACES;
  *of = k - surfaces - PLACE * bodies;
  return PART_STAGES;
}

static Kind KindOf(const MpmModel model, PetscInt k)
{
  PetscInt of, place;

  switch (PartOf(model, k, &of, &place)) {
  case PART_TABLE:
    return table[k].kind;
  case PART_CONDITIONS:
    return moving[place].kind;
  case PART_SURFACES:
    return lasting[place].kind;
  default:
    return KIND_REAL;
  }
}

/* Where the number stands in a model. */
static void *Member(MpmModel model, PetscInt k)
{
  PetscInt of, place;

  switch (PartOf(model, k, &of, &place)) {
  case PART_TABLE:
    return (table[k].results ? (char *)model->results : (char *)model) + table[k].offset;
  case PART_CONDITIONS:
    return (char *)&model->state.bcs[of] + moving[place].offset;
  case PART_SURFACES:
    return (char *)&model->state.loads[model->scene.loads->count + of] + lasting[place].offset;
  case PART_PLACES:
    return (PetscReal *)&model->state.placements[of] + place;
  default:
    return &model->state.relaxing.ended[of];
  }
}

/* Its name in a checkpoint. */
static PetscErrorCode NameOf(MpmModel model, PetscInt k, char **name)
{
  PetscInt of, place;

  PetscFunctionBeginUser;
  *name = NULL;
  switch (PartOf(model, k, &of, &place)) {
  case PART_TABLE:
    PetscCall(MpmTextAppend(name, "%s", table[k].name));
    break;
  case PART_CONDITIONS:
    PetscCall(MpmTextAppend(name, "condition_%s_%s", model->scene.bcs->names[of], moving[place].name));
    break;
  case PART_SURFACES:
    PetscCall(MpmTextAppend(name, "surface_%s_%s", model->scene.surfaces->names[of], lasting[place].name));
    break;
  case PART_PLACES:
    PetscCall(MpmTextAppend(name, "place_%s_%" PetscInt_FMT, model->scene.boundaries->names[of], place));
    break;
  default:
    PetscCall(MpmTextAppend(name, "ended_%" PetscInt_FMT, of));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmScalarsCreate(MpmModel model, MpmScalars *scalars)
{
  PetscInt count, bodies;

  PetscFunctionBeginUser;
  (void)FreeBoundary(model, 0, &bodies);
  count = TABLE + MOVING * model->scene.bcs->count + LASTING * model->scene.surfaces->count + PLACE * bodies +
          model->scene.stage_count;
  scalars->count = count;
  PetscCall(PetscCalloc5(count, &scalars->name, count, &scalars->real, count, &scalars->there, count, &scalars->value,
                         count, &scalars->number));
  for (PetscInt k = 0; k < count; k++) {
    const void *member = Member(model, k);

    PetscCall(NameOf(model, k, &scalars->name[k]));
    scalars->real[k]  = (PetscBool)(KindOf(model, k) == KIND_REAL);
    scalars->there[k] = PETSC_TRUE;
    if (KindOf(model, k) == KIND_REAL) scalars->value[k] = *(const PetscReal *)member;
    if (KindOf(model, k) == KIND_INT) scalars->number[k] = *(const PetscInt *)member;
    if (KindOf(model, k) == KIND_INT64) scalars->number[k] = *(const PetscInt64 *)member;
    if (KindOf(model, k) == KIND_BOOL) scalars->number[k] = *(const PetscBool *)member;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmScalarsRestore(const MpmScalars *scalars, const char *begin, MpmModel model)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < scalars->count; k++) {
    void *member = Member(model, k);

    if (!scalars->there[k] || strncmp(scalars->name[k], begin, strlen(begin))) continue;
    if (KindOf(model, k) == KIND_REAL) *(PetscReal *)member = scalars->value[k];
    if (KindOf(model, k) == KIND_INT) *(PetscInt *)member = (PetscInt)scalars->number[k];
    if (KindOf(model, k) == KIND_INT64) *(PetscInt64 *)member = scalars->number[k];
    if (KindOf(model, k) == KIND_BOOL) *(PetscBool *)member = (PetscBool)scalars->number[k];
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

/*
  Parameters of an inverse analysis: transforms, bounds, priors.
*/
#include <string.h>
#include "ground/ground.h"
#include "options/options.h"
#include "query/parameter_range.h"

PetscReal MpmRangeTransform(const MpmParameterRange *range, PetscReal value)
{
  if (range->transform == MPM_TRANSFORM_LOG) return PetscLogReal(value);
  if (range->transform == MPM_TRANSFORM_LOGIT) return PetscLogReal((value - range->lower) / (range->upper - value));
  return value;
}

PetscReal MpmRangeValue(const MpmParameterRange *range, PetscReal transformed)
{
  if (range->transform == MPM_TRANSFORM_LOG) return PetscExpReal(transformed);
  if (range->transform == MPM_TRANSFORM_LOGIT)
    return range->lower + (range->upper - range->lower) / (1. + PetscExpReal(-transformed));
  return transformed;
}

PetscReal MpmRangeSlope(const MpmParameterRange *range, PetscReal transformed)
{
  const PetscReal value = MpmRangeValue(range, transformed);

  if (range->transform == MPM_TRANSFORM_LOG) return value;
  if (range->transform == MPM_TRANSFORM_LOGIT)
    return (value - range->lower) * (range->upper - value) / (range->upper - range->lower);
  return 1.;
}

void MpmRangeBounds(const MpmParameterRange *range, PetscReal *lower, PetscReal *upper)
{
  *lower = range->lower;
  *upper = range->upper;
  if (range->transform == MPM_TRANSFORM_LOG) {
    *lower = range->lower > 0. ? PetscLogReal(range->lower) : PETSC_NINFINITY;
    *upper = PetscLogReal(range->upper);
  } else if (range->transform == MPM_TRANSFORM_LOGIT) {
    *lower = PETSC_NINFINITY;
    *upper = PETSC_INFINITY;
  }
}

/* ---- reading ---- */

static PetscErrorCode ReadBounds(const MpmOptions *block, MpmParameterRange *range, PetscBool *given)
{
  PetscReal bounds[2] = {PETSC_NINFINITY, PETSC_INFINITY};

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsReals(block, "bounds", "", "of the parameter, in its own unit: least, largest", MPM_RANGE_ANY,
                            MPM_OPTIONAL, 2, bounds, given));
  MpmCheckInput(bounds[0] < bounds[1] || MpmOptionsHelp(), "-%sbounds %g,%g: must ascend", block->prefix,
                (double)bounds[0], (double)bounds[1]);
  range->lower = bounds[0];
  range->upper = bounds[1];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A number that the transform takes, within the bounds. */
static PetscErrorCode CheckNumber(const MpmOptions *block, const char name[], const MpmParameterRange *range,
                                  PetscReal value)
{
  const PetscBool open = (PetscBool)(range->transform == MPM_TRANSFORM_LOGIT);

  PetscFunctionBeginUser;
  MpmCheckInput(value >= range->lower && value <= range->upper &&
                  (!open || (value > range->lower && value < range->upper)),
                "-%s%s: %g lies outside of its bounds, %g to %g", block->prefix, name, (double)value,
                (double)range->lower, (double)range->upper);
  MpmCheckInput(range->transform != MPM_TRANSFORM_LOG || value > 0.,
                "-%s%s: %g has no logarithm, which -%stransform asks for; must be > 0", block->prefix, name,
                (double)value, block->prefix);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadRange(const MpmOptions *block, MpmParameterRange *range, PetscBool *started)
{
  static const char *const transforms[] = {"none", "log", "logit", NULL};
  PetscInt                 transform    = 0;
  PetscBool                bounded, deviates;

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsWord(block, "transform",
                           "of the parameter in an inverse analysis: none; log, its logarithm; logit, between bounds",
                           transforms, MPM_OPTIONAL, &transform, NULL));
  range->transform = (MpmTransform)transform;
  PetscCall(ReadBounds(block, range, &bounded));
  PetscCall(MpmOptionsReal(block, "prior", "", "most likely value before there are data", MPM_RANGE_ANY, MPM_OPTIONAL,
                           &range->prior, &range->has_prior));
  PetscCall(MpmOptionsReal(block, "deviation", "", "standard deviation of the prior, of the transformed value",
                           MPM_RANGE_POSITIVE, MPM_OPTIONAL, &range->deviation, &deviates));
  PetscCall(MpmOptionsReal(block, "start", "", "value to start from; default: the scene's", MPM_RANGE_ANY, MPM_OPTIONAL,
                           &range->start, started));
  if (MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  MpmCheckInput(range->transform != MPM_TRANSFORM_LOGIT || bounded, "-%sbounds is missing: logit is between bounds",
                block->prefix);
  MpmCheckInput(!range->has_prior || deviates, "-%sdeviation is missing: of the prior", block->prefix);
  MpmCheckInput(!deviates || range->has_prior, "-%sprior is missing: the deviation is of it", block->prefix);
  PetscCall(CheckNumber(block, "start", range, range->start));
  if (range->has_prior) PetscCall(CheckNumber(block, "prior", range, range->prior));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A range for each block, and for each number without one. */
static PetscErrorCode Group(const MpmSceneParameters *parameters, MpmParameterRanges *ranges)
{
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(parameters->count + 1, &ranges->at));
  for (PetscInt k = 0; k < parameters->count; k++) {
    const MpmSceneParameter *parameter = &parameters->at[k];
    MpmParameterRange       *range     = ranges->count ? &ranges->at[ranges->count - 1] : NULL;

    if (!k || !parameter->block || !parameter[-1].block || strcmp(parameter->block, parameter[-1].block)) {
      range = &ranges->at[ranges->count++];
      *range =
        (MpmParameterRange){.lower = PETSC_NINFINITY, .upper = PETSC_INFINITY, .start = parameter->value, .field = -1};
      PetscCall(PetscStrallocpy(parameter->block ? parameter->block : parameter->name, &range->name));
    }
    PetscCall(PetscRealloc((size_t)(range->count + 1) * sizeof(*range->of), &range->of));
    range->of[range->count++] = k;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmParameterRangePrintHelp(const MpmOptions *block)
{
  PetscFunctionBeginUser;
  PetscCall(ReadRange(block, &(MpmParameterRange){0}, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmParameterRangesRead(const MpmOptions *options, const MpmSceneParameters *parameters,
                                      MpmParameterRanges *ranges)
{
  char       prefix[256];
  MpmOptions block = {options->comm, prefix, options->record};

  PetscFunctionBeginUser;
  if (MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Group(parameters, ranges));
  for (PetscInt k = 0; k < ranges->count; k++) {
    if (!parameters->at[ranges->at[k].of[0]].block) continue;
    PetscCall(PetscSNPrintf(prefix, sizeof(prefix), "mpm_parameter_%s_", ranges->at[k].name));
    PetscCall(ReadRange(&block, &ranges->at[k], NULL));
  }
  ranges->numbers = ranges->count;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmParameterRangesAddField(const MpmOptions *options, const char *block, PetscInt field,
                                          const MpmGround *ground, PetscBool on, MpmParameterRanges *ranges)
{
  char              prefix[256];
  const MpmOptions  of  = {options->comm, prefix, options->record};
  MpmParameterRange all = {
    .lower = PETSC_NINFINITY, .upper = PETSC_INFINITY, .start = ground->value[0], .field = field};
  PetscBool started = PETSC_FALSE;

  PetscFunctionBeginUser;
  PetscCall(PetscSNPrintf(prefix, sizeof(prefix), "mpm_parameter_%s_", block ? block : ""));
  if (block) PetscCall(ReadRange(&of, &all, &started));
  if (!on) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscRealloc((size_t)(ranges->count + ground->count) * sizeof(*ranges->at), &ranges->at));
  for (PetscInt k = 0; k < ground->count; k++) {
    MpmParameterRange *range = &ranges->at[ranges->count++];
    char               name[PETSC_MAX_OPTION_NAME];

    *range       = all;
    range->place = k;
    if (!started) range->start = ground->value[k];
    PetscCall(CheckNumber(&of, "start", range, range->start));
    PetscCall(PetscSNPrintf(name, sizeof(name), "%s_%" PetscInt_FMT, block ? block : ground->name, k + 1));
    PetscCall(PetscStrallocpy(name, &range->name));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmParameterRangesDestroy(MpmParameterRanges *ranges)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < ranges->count; k++) {
    PetscCall(PetscFree(ranges->at[k].name));
    PetscCall(PetscFree(ranges->at[k].of));
  }
  PetscCall(PetscFree(ranges->at));
  PetscFunctionReturn(PETSC_SUCCESS);
}

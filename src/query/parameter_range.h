#pragma once
/*
  Parameters of an inverse analysis: numbers of a scene with bounds, a prior and a transform.

  The analysis works with t, the transformed value of p: t = p, t = ln p, or t = ln((p - a)/(b - p)) between bounds a
  and b. One parameter may stand for several numbers of the scene, which are equal.
*/
#include "base/base.h"
#include "base/types.h"
#include "query/scene_parameter.h"

typedef enum { MPM_TRANSFORM_NONE, MPM_TRANSFORM_LOG, MPM_TRANSFORM_LOGIT } MpmTransform;

typedef struct {
  char        *name; /* of its block, or of the number where it has none */
  MpmTransform transform;
  PetscReal    lower, upper; /* of p; infinite without bounds */
  PetscReal    start;
  PetscBool    has_prior;
  PetscReal    prior, deviation; /* most likely p, standard deviation of t */
  PetscInt     count, *of;       /* numbers of the scene: among the MpmSceneParameters */
  PetscInt     field, place;     /* of a value of a field: its field among the parameters, its row; field -1: none */
} MpmParameterRange;

typedef struct {
  PetscInt           count;
  MpmParameterRange *at;
  PetscInt           numbers; /* the first ones are no values of fields */
} MpmParameterRanges;

/* For -help: the options of a block. */
PetscErrorCode MpmParameterRangePrintHelp(const MpmOptions *block);
/* Reads transforms and bounds of the blocks of -mpm_parameters, once the parameters are there. */
PetscErrorCode MpmParameterRangesRead(const MpmOptions *options, const MpmSceneParameters *parameters,
                                      MpmParameterRanges *ranges);
/*
  Adds a range for each value of a field, the parameters' number `field`, all of them with the options of one block
  (NULL: none); values of other tasks than an inverse analysis have none. Names are those of the block and the row.
*/
PetscErrorCode MpmParameterRangesAddField(const MpmOptions *options, const char *block, PetscInt field,
                                          const MpmGround *ground, PetscBool on, MpmParameterRanges *ranges);
PetscErrorCode MpmParameterRangesDestroy(MpmParameterRanges *ranges);

/* t of p, p of t, and dp/dt. Bounds of t: infinite where there are none. */
PetscReal MpmRangeTransform(const MpmParameterRange *range, PetscReal value);
PetscReal MpmRangeValue(const MpmParameterRange *range, PetscReal transformed);
PetscReal MpmRangeSlope(const MpmParameterRange *range, PetscReal transformed);
void      MpmRangeBounds(const MpmParameterRange *range, PetscReal *lower, PetscReal *upper);

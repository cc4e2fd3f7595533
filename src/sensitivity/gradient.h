#pragma once
/*
  Derivatives of a whole run: the gradient of objectives by parameters of the scene.
*/
#include "query/model.h"
#include "query/point_vector.h"
#include "query/inverse_settings.h"
#include "sensitivity/measurement.h"
#include "stepmap/ground_parameters.h"
#include "sensitivity/objective.h"
#include "query/parameter_range.h"
#include "sensitivity/parameters.h"
#include "sensitivity/tape.h"

typedef enum { MPM_GRADIENT_ADJOINT, MPM_GRADIENT_TANGENT, MPM_GRADIENT_TWINS } MpmGradientMethod;
extern const char *const MpmGradientMethods[]; /* their words, and NULL */

#define MPM_OPEN_TEXT 256 /* of a part of a scene without derivatives in closed form */

/* How a kind of scene is differentiated; NULL in their place: a scene on a grid. */
typedef struct {
  PetscErrorCode (*check)(MpmModel model);                            /* refuses what has no derivative */
  PetscErrorCode (*add_columns)(MpmModel model, MpmColumns *columns); /* of the history */
  PetscErrorCode (*record)(MpmModel model);                      /* keeps the state at the start, and after each step */
  PetscErrorCode (*find[2])(MpmModel model, PetscReal values[]); /* the gradient, by MpmGradientMethod */
  PetscErrorCode (*finish)(MpmModel model);                      /* frees the states */
} MpmGradientKind;

/*
  State from which steps are differentiated, and its derivatives: that after the scene's set-up, or after the geostatic
  stage that comes first. `rows` of the curves, up to that state, are not of steps.
*/
typedef struct {
  PetscBool       differs; /* depends on parameters */
  PetscInt        rows;
  MpmPointVector *at;     /* by parameter; NULL: they are 0 */
  PetscReal      *slopes; /* [(k*rows + n)*objectives + o], as those of the gradient */
} MpmGradientStart;

struct MpmGradient {
  const MpmGradientKind *kind;
  MpmGradientMethod      method;
  PetscBool              checks; /* both methods are compared, and differences */
  MpmInverseSettings     inverse;
  MpmSceneParameters     parameters;
  MpmParameterRanges     ranges;
  MpmFieldParameters     grounds; /* fields; their values follow the parameters among all numbers */
  MpmObjectives          objectives;
  MpmTape                tape;
  MpmGradientStart       start;
  PetscReal             *curves; /* values of each objective's column: by step, its start first */
  PetscInt               rows;   /* steps so far, and the start */
  PetscReal             *times;
  PetscReal             *weights;             /* derivatives of the objectives' sum by these values */
  PetscReal             *slopes;              /* derivatives of the values by number k: [(k*rows + n)*objectives + o] */
  PetscReal             *signatures;          /* of each step's decisions */
  char                   open[MPM_OPEN_TEXT]; /* part without derivatives in closed form; empty: none */
};

/* Reads -mpm_task and its blocks, behind the other blocks of the scene. */
PetscErrorCode MpmGradientRead(MpmModel model, const MpmOptions *options, const MpmGradientKind *kind);
/* The columns that the history will have. */
PetscErrorCode MpmGradientAddColumns(MpmModel model, MpmColumns *columns);
PetscErrorCode MpmGradientDestroy(MpmGradient **gradient);
/* The part of a scene, and that of the last step, which has no derivatives in closed form; or no text. Collective. */
PetscErrorCode MpmGradientFindOpen(const MpmModel model, char text[MPM_OPEN_TEXT]);
PetscErrorCode MpmGradientFindOpened(const MpmModel model, char text[MPM_OPEN_TEXT]);
/* Refuses a number of a material that no points are of. */
PetscErrorCode MpmGradientCheckUse(const MpmModel model);
/* Fails where the run has changed by itself in a way that has no derivatives. */
PetscErrorCode MpmGradientCheckRun(const MpmModel model, MpmOutcome *outcome);
/* True where the points' state at the first step depends on parameters. */
PetscBool MpmGradientStartDiffers(const MpmModel model);
/* True where the derivative by parameter k, or by any, is taken in closed form, by a run over the tape. */
PetscBool MpmGradientIsClosed(const MpmGradient *gradient, PetscInt k);
PetscBool MpmGradientAnyClosed(const MpmGradient *gradient);
/*
  Begin: before the first step, and before anything is written. Record: after each. Find: after the last one, into the
  results' derivatives; those that have no closed form are left for twins. Nothing where none are asked for. Collective.
*/
PetscErrorCode MpmGradientBegin(MpmModel model);
PetscErrorCode MpmGradientRecord(MpmModel model);
/* A stage has begun. */
PetscErrorCode MpmGradientStage(MpmModel model);
PetscErrorCode MpmGradientFind(MpmModel model);
/* The columns as they have been collected, borrowed. */
MpmCurves MpmGradientCurves(const MpmGradient *gradient);
/* Sums the slopes with the objectives' weights: the gradient of a method that fills them. */
void MpmGradientSumSlopes(const MpmGradient *gradient, PetscReal values[]);
/* Collect: the objectives' columns as they are now. Evaluate: the sum of the objectives of what has been collected. */
PetscErrorCode MpmGradientCollect(MpmModel model);
PetscErrorCode MpmGradientEvaluate(MpmModel model, PetscReal *objective);

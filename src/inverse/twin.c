/*
  A twin: the scene with one parameter changed, which takes steps as long as those of the model's run and solves them to
  rounding.
*/
#include <stdlib.h>
#include "base/columns.h"
#include "io/io.h"
#include "options/database.h"
#include "options/record.h"
#include "observe/results.h"
#include "sensitivity/gradient.h"
#include "inverse/twin.h"

/* Newton's tolerances: errors of a solution count as often as the change of a parameter goes into it. */
static const struct {
  const char *name, *value;
} tolerances[] = {{"-snes_rtol", "1e-13"}, {"-snes_stol", "0"}};

/* ---- options ---- */

/* The scene's value of an option, or NULL; the caller frees it. */
static PetscErrorCode KeepOption(const char name[], char **value)
{
  const char *present;
  PetscBool   given;

  PetscFunctionBeginUser;
  *value = NULL;
  PetscCall(MpmDatabaseFind(name + 1, &present, &given));
  if (given) PetscCall(PetscStrallocpy(present ? present : "", value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReturnOption(const char name[], char **value)
{
  PetscFunctionBeginUser;
  if (*value) PetscCall(PetscOptionsSetValue(NULL, name, *value));
  else PetscCall(PetscOptionsClearValue(NULL, name));
  PetscCall(PetscFree(*value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A tolerance of twins, unless the scene's is smaller. */
static PetscErrorCode Tighten(size_t t, char **value)
{
  PetscFunctionBeginUser;
  PetscCall(KeepOption(tolerances[t].name, value));
  if (!*value || strtod(*value, NULL) > strtod(tolerances[t].value, NULL))
    PetscCall(PetscOptionsSetValue(NULL, tolerances[t].name, tolerances[t].value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the run ---- */

/* A changed scene may be refused, which is no fault of the user's: the text is kept, and nothing is printed. */
static PetscErrorCode HandleError(MPI_Comm comm, int line, const char *function, const char *file, PetscErrorCode code,
                                  PetscErrorType type, const char *message, void *ctx)
{
  MpmTwin *twin = (MpmTwin *)ctx;

  (void)comm;
  (void)line;
  (void)function;
  (void)file;
  if (type == PETSC_ERROR_INITIAL) (void)PetscStrncpy(twin->why, message ? message : "it is refused", MPM_TWIN_TEXT);
  return code;
}

/* The scene as the options in force have it, set up; false where it is refused. */
static PetscErrorCode Create(MpmModel model, MpmTwin *twin, MpmModel *other, PetscBool *made)
{
  PetscErrorCode error;

  PetscFunctionBeginUser;
  PetscCall(MpmModelCreate(model->comm, other));
  (*other)->record->sources = model->record->sources;
  PetscCall(MpmModelSetBodyForce(*other, model->scene.body_force.function, model->scene.body_force.ctx));
  PetscCall(PetscPushErrorHandler(HandleError, twin));
  error = MpmModelSetFromOptions(*other);
  if (!error) error = MpmModelSetUp(*other);
  PetscCall(PetscPopErrorHandler());
  *made = (PetscBool)!error;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Steps of the lengths that the run's have. */
static PetscErrorCode GiveSteps(const MpmGradient *base, MpmGivenSteps *given)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(given->time));
  given->count = base->rows - 1;
  given->taken = PETSC_TRUE;
  PetscCall(PetscMalloc1(given->count, &given->time));
  PetscCall(PetscArraycpy(given->time, &base->times[1], given->count));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* All steps of the model's run. */
static PetscErrorCode RunAlong(MpmModel model, MpmModel other, MpmTwin *twin)
{
  const MpmGradient *base   = model->gradient;
  const PetscInt     rows   = base->rows;
  MpmGradient       *own    = other->gradient;
  MpmStatus          status = MPM_RUNNING;

  PetscFunctionBeginUser;
  PetscCall(GiveSteps(base, &other->scene.stages.given));
  PetscCall(MpmGradientAddColumns(other, &other->results->columns));
  PetscCall(MpmGradientCollect(other));
  for (PetscInt n = 1; n < rows && status == MPM_RUNNING; n++) {
    PetscCall(MpmModelStep(other, &status));
    if (status != MPM_GAVE_UP) PetscCall(MpmGradientCollect(other));
    if (!twin->apart &&
        (own->rows <= n || own->times[n] != base->times[n] || own->signatures[n] != base->signatures[n]))
      twin->apart = n;
  }
  if (status == MPM_GAVE_UP) {
    PetscCall(PetscSNPrintf(twin->why, MPM_TWIN_TEXT, "it gives up at step %" PetscInt_FMT ": %s", own->rows,
                            other->caller.outcome.text));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (own->rows != rows) {
    PetscCall(PetscSNPrintf(twin->why, MPM_TWIN_TEXT, "it ends after step %" PetscInt_FMT, own->rows - 1));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(MpmGradientEvaluate(other, &twin->objective));
  twin->curves = own->curves;
  own->curves  = NULL;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The run of the scene as its options are now. */
static PetscErrorCode Run(MpmModel model, MpmTwin *twin)
{
  char     *kept[PETSC_STATIC_ARRAY_LENGTH(tolerances)];
  PetscBool made = PETSC_FALSE;
  MpmModel  other;

  PetscFunctionBeginUser;
  *twin = (MpmTwin){.objective = NAN};
  for (size_t t = 0; t < PETSC_STATIC_ARRAY_LENGTH(tolerances); t++) PetscCall(Tighten(t, &kept[t]));
  PetscCall(Create(model, twin, &other, &made));
  if (made) PetscCall(RunAlong(model, other, twin));
  PetscCall(MpmModelDestroy(&other));
  for (size_t t = 0; t < PETSC_STATIC_ARRAY_LENGTH(tolerances); t++)
    PetscCall(ReturnOption(tolerances[t].name, &kept[t]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTwinRun(MpmModel model, PetscInt k, double value, MpmTwin *twin)
{
  const MpmSceneParameter *parameter = &model->gradient->parameters.at[k];

  PetscFunctionBeginUser;
  PetscCall(MpmSceneParameterSet(parameter, value));
  PetscCall(Run(model, twin));
  PetscCall(MpmSceneParameterReset(parameter));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTwinRunAll(MpmModel model, const PetscReal value[], MpmTwin *twin)
{
  const MpmSceneParameters *parameters = &model->gradient->parameters;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < parameters->count; k++) PetscCall(MpmSceneParameterSet(&parameters->at[k], value[k]));
  PetscCall(Run(model, twin));
  for (PetscInt k = parameters->count - 1; k >= 0; k--) PetscCall(MpmSceneParameterReset(&parameters->at[k]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode NameValues(const MpmGround *ground, char name[PETSC_MAX_OPTION_NAME])
{
  PetscFunctionBeginUser;
  PetscCall(PetscSNPrintf(name, PETSC_MAX_OPTION_NAME, "-mpm_field_%s_values", ground->name));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmFieldSetValues(const MpmGround *ground, const PetscReal value[])
{
  MpmTextFile text = MPM_TEXT_FILE_EMPTY;
  char        name[PETSC_MAX_OPTION_NAME];

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < ground->count; k++)
    PetscCall(MpmTextFileAppend(&text, "%s%.17g", k ? "," : "", (double)value[k]));
  PetscCall(NameValues(ground, name));
  PetscCall(PetscOptionsSetValue(NULL, name, text.data));
  PetscCall(MpmTextFileDestroy(&text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTwinRunField(MpmModel model, PetscInt d, PetscReal part, MpmTwin *twin)
{
  const MpmFieldParameters *grounds   = &model->gradient->grounds;
  const MpmGroundDirection *direction = &grounds->direction[d];
  const MpmGround          *ground    = grounds->at[direction->index].ground;
  PetscReal                *value;
  char                      name[PETSC_MAX_OPTION_NAME], *kept;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(ground->count, &value));
  for (PetscInt k = 0; k < ground->count; k++) value[k] = ground->value[k] + part * direction->change[k];
  PetscCall(NameValues(ground, name));
  PetscCall(KeepOption(name, &kept));
  PetscCall(MpmFieldSetValues(ground, value));
  PetscCall(Run(model, twin));
  PetscCall(ReturnOption(name, &kept));
  PetscCall(PetscFree(value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTwinDestroy(MpmTwin *twin)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(twin->curves));
  PetscFunctionReturn(PETSC_SUCCESS);
}

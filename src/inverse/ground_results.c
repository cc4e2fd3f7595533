/*
  Derivatives by fields in files of their own, PREFIX_gradient_NAME.csv: a row for each value of the field.
*/
#include "ground/ground.h"
#include "observe/results.h"
#include "sensitivity/gradient.h"
#include "inverse/inverse.h"

/* The header: the values' places or names, if they have any. */
static PetscErrorCode AppendHeader(const MpmGround *ground, MpmTextFile *text)
{
  static const char *const axes[] = {"x", "y", "z"};

  PetscFunctionBeginUser;
  if (ground->names) PetscCall(MpmTextFileAppend(text, "name,"));
  for (PetscInt a = 0; ground->at && a < ground->dim; a++) PetscCall(MpmTextFileAppend(text, "%s,", axes[a]));
  PetscCall(MpmTextFileAppend(text, "value,derivative\n"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode WriteOne(MpmModel model, const MpmGround *ground, const PetscReal derivative[], const char path[])
{
  MpmTextFile              text    = MPM_TEXT_FILE_EMPTY;
  const MpmTextFile *const texts[] = {&text};

  PetscFunctionBeginUser;
  PetscCall(AppendHeader(ground, &text));
  for (PetscInt k = 0; k < ground->count; k++) {
    if (ground->names) PetscCall(MpmTextFileAppend(&text, "%s,", ground->names[k]));
    for (PetscInt a = 0; ground->at && a < ground->dim; a++)
      PetscCall(MpmTextFileAppend(&text, "%.17g,", (double)ground->at[k * ground->dim + a]));
    PetscCall(MpmTextFileAppend(&text, "%.17g,%.17g\n", (double)ground->value[k], (double)derivative[k]));
  }
  PetscCall(MpmTextFileWrite(model->comm, path, 1, texts));
  PetscCall(MpmTextFileDestroy(&text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmGroundResultsWrite(MpmModel model)
{
  MpmDerivatives           *found   = &model->results->derivatives;
  const MpmFieldParameters *grounds = model->gradient ? &model->gradient->grounds : NULL;

  PetscFunctionBeginUser;
  if (!grounds || !grounds->count || !found->gradient || model->caller.outcome.code) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt k = 0; k < grounds->count; k++) {
    const MpmGround *ground     = grounds->at[k].ground;
    const PetscReal *derivative = &found->gradient[model->gradient->parameters.count + grounds->at[k].first];
    char             path[PETSC_MAX_PATH_LEN];
    PetscReal        square = 0.;

    for (PetscInt i = 0; i < ground->count; i++) square += PetscSqr(derivative[i]);
    PetscCall(
      PetscSNPrintf(path, sizeof(path), "%s_gradient_%s.csv", model->scene.name.prefix, grounds->at[k].ground->name));
    PetscCall(WriteOne(model, ground, derivative, path));
    PetscCall(MpmTextAppend(&found->fields, "%s\"%s\": {\"values\": %d, \"norm\": %.17g, \"file\": \"%s\"}",
                            k ? ", " : "", ground->name, (int)ground->count, (double)PetscSqrtReal(square), path));
    PetscCall(MpmMonitorNote(&model->monitor, "derivatives by field %s: %d values, norm %.10g", ground->name,
                             (int)ground->count, (double)PetscSqrtReal(square)));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

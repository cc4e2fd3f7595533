/*
  Options of regularizations.
*/
#include "sensitivity/regularization.h"

#define SMOOTHING 0.1 /* of the deviation */

/* The standard deviation, or the factor of the square in its place. */
static PetscErrorCode ReadDeviation(const MpmOptions *block, MpmRegularization *regular)
{
  PetscReal weight = 1.;
  PetscBool given, weighted;

  PetscFunctionBeginUser;
  regular->deviation = 1.;
  PetscCall(MpmOptionsReal(block, "deviation", "", "standard deviation", MPM_RANGE_POSITIVE, MPM_OPTIONAL,
                           &regular->deviation, &given));
  PetscCall(
    MpmOptionsReal(block, "weight", "", "factor of the square", MPM_RANGE_POSITIVE, MPM_OPTIONAL, &weight, &weighted));
  MpmCheckInput(given || weighted, "-%sdeviation is missing: of the transformed values", block->prefix);
  MpmCheckInput(!given || !weighted, "-%sweight: the deviation is given, too", block->prefix);
  if (weighted) regular->deviation = regular->kind == MPM_TOTAL_VARIATION ? 1. / weight : 1. / PetscSqrtReal(weight);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Correlation length and mean of a prior. */
static PetscErrorCode ReadPrior(const MpmOptions *block, MpmRegularization *regular)
{
  PetscReal *length;

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsRealList(block, "length", "m", "of a prior: correlation length, one or one an axis",
                               MpmOptionsHelp() ? MPM_OPTIONAL : MPM_REQUIRED, &regular->lengths, &length));
  PetscCall(MpmOptionsReal(block, "mean", "", "of a prior, in the number's unit; default: the values of the start",
                           MPM_RANGE_ANY, MPM_OPTIONAL, &regular->mean, &regular->has_mean));
  if (MpmOptionsHelp()) PetscFunctionReturn(PetscFree(length));
  MpmCheckInput(regular->lengths <= MPM_MAX_DIM, "-%slength has %" PetscInt_FMT " numbers: must be one, or one an axis",
                block->prefix, regular->lengths);
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    regular->length[a] = length[PetscMin(a, regular->lengths - 1)];
    MpmCheckInput(regular->length[a] > 0. && regular->length[a] < PETSC_INFINITY, "-%slength: must be > 0 m",
                  block->prefix);
  }
  PetscCall(PetscFree(length));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmRegularizationRead(const MpmOptions *block, const char name[], MpmRegularizationKind kind,
                                     MpmRegularization *regular)
{
  PetscBool smooth = PETSC_TRUE;

  PetscFunctionBeginUser;
  regular->kind = kind;
  PetscCall(PetscStrallocpy(name, &regular->name));
  PetscCall(MpmOptionsText(block, "field", "of a regularization: the field, one of the parameters", NULL,
                           MpmOptionsHelp() ? MPM_OPTIONAL : MPM_REQUIRED, &regular->field));
  if (!MpmOptionsHelp()) PetscCall(ReadDeviation(block, regular));
  if (kind == MPM_FIELD_PRIOR || MpmOptionsHelp()) PetscCall(ReadPrior(block, regular));
  if (kind == MPM_TOTAL_VARIATION || MpmOptionsHelp())
    PetscCall(MpmOptionsReal(block, "smoothing", "",
                             "of total_variation: differences of transformed values below it count by their square; "
                             "default: a tenth of the deviation",
                             MPM_RANGE_POSITIVE, MPM_OPTIONAL, &regular->smoothing, &smooth));
  if (!smooth) regular->smoothing = SMOOTHING * regular->deviation;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmRegularizationDestroy(MpmRegularization *regular)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(regular->name));
  PetscCall(PetscFree(regular->field));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmRegularizationCheck(const MpmRegularization *regular, const MpmGround *ground)
{
  PetscFunctionBeginUser;
  if (regular->kind != MPM_FIELD_PRIOR) {
    MpmCheckInput(ground->kind == MPM_GROUND_CELL,
                  "-mpm_objective_%s_field %s: must be a field by cell, whose values have neighbours", regular->name,
                  regular->field);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  MpmCheckInput(ground->kind == MPM_GROUND_CELL || ground->kind == MPM_GROUND_PILOTS,
                "-mpm_objective_%s_field %s: must be a field by cell or pilots, whose values have places",
                regular->name, regular->field);
  MpmCheckInput(ground->count <= MPM_MOST_CORRELATED,
                "-mpm_objective_%s_kind prior: the field has %" PetscInt_FMT
                " values, must have at most %d; tikhonov takes any number",
                regular->name, ground->count, MPM_MOST_CORRELATED);
  MpmCheckInput(regular->lengths == 1 || regular->lengths == ground->dim,
                "-mpm_objective_%s_length has %" PetscInt_FMT " numbers: must be one, or one an axis", regular->name,
                regular->lengths);
  PetscFunctionReturn(PETSC_SUCCESS);
}

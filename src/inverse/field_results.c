/*
  Fields that an inverse analysis has found, PREFIX_field_NAME.csv, in the format that a field's `file` reads: a row for
  each value in the field's order, with its name, place or id.
*/
#include "sensitivity/gradient.h"
#include "inverse/output.h"

static PetscErrorCode Path(const MpmInverse *inverse, const MpmGround *ground, char path[PETSC_MAX_PATH_LEN])
{
  PetscFunctionBeginUser;
  PetscCall(PetscSNPrintf(path, PETSC_MAX_PATH_LEN, "%s_field_%s.csv", inverse->problem.prefix, ground->name));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Value k of field f. */
static PetscReal Value(const MpmInverse *inverse, PetscInt f, PetscInt k)
{
  const MpmInverseProblem *problem = &inverse->problem;
  const PetscInt           at      = problem->ranges->numbers + problem->scene->gradient->grounds.at[f].first + k;

  return MpmRangeValue(&problem->ranges->at[at], inverse->best.t[at]);
}

static PetscErrorCode WriteOne(const MpmInverse *inverse, PetscInt f)
{
  static const char *const axes[]  = {"x", "y", "z"};
  const MpmGround         *ground  = MpmInverseField(&inverse->problem, f);
  MpmTextFile              text    = MPM_TEXT_FILE_EMPTY;
  const MpmTextFile *const texts[] = {&text};
  char                     path[PETSC_MAX_PATH_LEN];

  PetscFunctionBeginUser;
  if (ground->names) PetscCall(MpmTextFileAppend(&text, "name,"));
  if (ground->kind == MPM_GROUND_POINT) PetscCall(MpmTextFileAppend(&text, "id,"));
  for (PetscInt a = 0; ground->at && a < ground->dim; a++) PetscCall(MpmTextFileAppend(&text, "%s,", axes[a]));
  PetscCall(MpmTextFileAppend(&text, "value\n"));
  for (PetscInt k = 0; k < ground->count; k++) {
    if (ground->names) PetscCall(MpmTextFileAppend(&text, "%s,", ground->names[k]));
    if (ground->kind == MPM_GROUND_POINT) PetscCall(MpmTextFileAppend(&text, "%d,", (int)k));
    for (PetscInt a = 0; ground->at && a < ground->dim; a++)
      PetscCall(MpmTextFileAppend(&text, "%.17g,", (double)ground->at[k * ground->dim + a]));
    PetscCall(MpmTextFileAppend(&text, "%.17g\n", (double)Value(inverse, f, k)));
  }
  PetscCall(Path(inverse, ground, path));
  PetscCall(MpmTextFileWrite(inverse->problem.comm, path, 1, texts));
  PetscCall(MpmTextFileDestroy(&text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmInverseWriteFields(const MpmInverse *inverse)
{
  PetscFunctionBeginUser;
  for (PetscInt f = 0; f < inverse->problem.scene->gradient->grounds.count; f++) PetscCall(WriteOne(inverse, f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmInverseSetFieldFiles(const MpmInverse *inverse)
{
  PetscFunctionBeginUser;
  for (PetscInt f = 0; f < inverse->problem.scene->gradient->grounds.count; f++) {
    const MpmGround *ground = MpmInverseField(&inverse->problem, f);
    char             path[PETSC_MAX_PATH_LEN], name[PETSC_MAX_OPTION_NAME];

    PetscCall(Path(inverse, ground, path));
    PetscCall(PetscSNPrintf(name, sizeof(name), "-mpm_field_%s_file", ground->name));
    PetscCall(PetscOptionsSetValue(NULL, name, path));
    PetscCall(PetscSNPrintf(name, sizeof(name), "-mpm_field_%s_values", ground->name));
    PetscCall(PetscOptionsClearValue(NULL, name));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Least and largest value of field f. */
static void FindBounds(const MpmInverse *inverse, PetscInt f, PetscReal *least, PetscReal *most)
{
  *least = *most = Value(inverse, f, 0);
  for (PetscInt k = 1; k < MpmInverseField(&inverse->problem, f)->count; k++) {
    *least = PetscMin(*least, Value(inverse, f, k));
    *most  = PetscMax(*most, Value(inverse, f, k));
  }
}

PetscErrorCode MpmInverseAppendFields(const MpmInverse *inverse, char **text)
{
  const PetscInt count = inverse->problem.scene->gradient->grounds.count;

  PetscFunctionBeginUser;
  if (!count) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmTextAppend(text, ", \"fields\": {"));
  for (PetscInt f = 0; f < count; f++) {
    const MpmGround *ground = MpmInverseField(&inverse->problem, f);
    char             path[PETSC_MAX_PATH_LEN];
    PetscReal        least, most;

    FindBounds(inverse, f, &least, &most);
    PetscCall(Path(inverse, ground, path));
    PetscCall(MpmTextAppend(text, "%s\"%s\": {\"values\": %d, \"least\": %.17g, \"largest\": %.17g, \"file\": \"%s\"}",
                            f ? ", " : "", ground->name, (int)ground->count, (double)least, (double)most, path));
  }
  PetscCall(MpmTextAppend(text, "}"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmInversePrintFields(const MpmInverse *inverse)
{
  PetscFunctionBeginUser;
  for (PetscInt f = 0; f < inverse->problem.scene->gradient->grounds.count; f++) {
    const MpmGround *ground = MpmInverseField(&inverse->problem, f);
    char             path[PETSC_MAX_PATH_LEN];
    PetscReal        least, most;

    FindBounds(inverse, f, &least, &most);
    PetscCall(Path(inverse, ground, path));
    PetscCall(PetscPrintf(inverse->problem.comm, "  field %-18s %d values, %.6g to %.6g: %s\n", ground->name,
                          (int)ground->count, (double)least, (double)most, path));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

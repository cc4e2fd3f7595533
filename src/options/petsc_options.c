/*
  PETSc's own options, as far as a slip in them would end in a traceback, or be taken without a word.
*/
#include "options/options.h"
#include "options/record.h"

#include <math.h>
#include <petscksp.h>
#include <stdlib.h>
#include <string.h>

/* Options whose numbers PETSc does not check, or complains of too late. */
static const struct {
  const char *name;
  PetscBool   whole;
  const char *accepts;
  double      least;
} numbers[] = {
  {"snes_rtol", PETSC_FALSE, "a number >= 0", 0.},  {"snes_atol", PETSC_FALSE, "a number >= 0", 0.},
  {"snes_stol", PETSC_FALSE, "a number >= 0", 0.},  {"snes_divergence_tolerance", PETSC_FALSE, "a number", -1e300},
  {"snes_max_it", PETSC_TRUE, "a number >= 1", 1.}, {"ksp_rtol", PETSC_FALSE, "a number >= 0", 0.},
  {"ksp_atol", PETSC_FALSE, "a number >= 0", 0.},   {"ksp_divtol", PETSC_FALSE, "a number >= 0", 0.},
  {"ksp_max_it", PETSC_TRUE, "a number >= 1", 1.},  {"ksp_gmres_restart", PETSC_TRUE, "a number >= 1", 1.},
};

static PetscErrorCode CheckNumber(const MpmDatabaseOption *option)
{
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(numbers); i++) {
    PetscReal real  = 0.;
    PetscInt  whole = 0;
    PetscBool same, good;

    PetscCall(PetscStrcasecmp(option->name, numbers[i].name, &same));
    if (!same) continue;
    good = numbers[i].whole ? MpmParseInt(option->value, &whole) : MpmParseReal(option->value, &real);
    if (numbers[i].whole) real = (PetscReal)whole;
    MpmCheckInput(good && real >= numbers[i].least, "-%s %.80s: must be %s", option->name, option->value,
                  numbers[i].accepts);
  }
  return PETSC_SUCCESS;
}

/* An option that names a type has a name to give. */
static PetscErrorCode CheckType(const MpmDatabaseOption *option)
{
  PetscBool type;

  PetscFunctionBegin;
  PetscCall(PetscStrendswith(option->name, "_type", &type));
  MpmCheckInput(!type || (option->value && *option->value), "-%s: names no type", option->name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Refuses a package that has none of the factorisations. */
static PetscErrorCode CheckFactorisation(const MpmDatabaseOption *option)
{
  const char         *package = option->value ? option->value : "";
  const MatFactorType kinds[] = {MAT_FACTOR_LU, MAT_FACTOR_CHOLESKY, MAT_FACTOR_ILU, MAT_FACTOR_ICC};
  PetscBool           same, any = PETSC_FALSE;
  PetscMPIInt         size;

  PetscFunctionBegin;
  PetscCall(PetscStrcasecmp(option->name, "pc_factor_mat_solver_type", &same));
  if (!same) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCallMPI(MPI_Comm_size(PETSC_COMM_WORLD, &size));
  PetscCall(MatInitializePackage());
  for (size_t k = 0; *package && !any && k < PETSC_STATIC_ARRAY_LENGTH(kinds); k++) {
    PetscBool type, mat;

    PetscCall(MatSolverTypeGet(package, size > 1 ? MATMPIAIJ : MATSEQAIJ, kinds[k], &type, &mat, NULL));
    any = (PetscBool)(type && mat);
  }
  MpmCheckInput(any, "-%s %.80s: this PETSc does not have it%s", option->name, package,
                size > 1 ? " for several ranks" : "");
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmForeignOptionsCheck(void)
{
  MpmDatabaseOption *options;
  PetscInt           count;
  PetscBool          left;
  char              *text;

  PetscFunctionBegin;
  /* PETSc reads this one when it ends, with the results written */
  PetscCall(PetscOptionsGetBool(NULL, NULL, "-options_left", &left, NULL));
  PetscCall(MpmDatabaseGetForeign(&count, &options, &text));
  for (PetscInt i = 0; i < count; i++) {
    const char *value = options[i].value;
    char       *end;
    double      number;

    PetscCall(CheckType(&options[i]));
    PetscCall(CheckFactorisation(&options[i]));
    if (!value) continue;
    number = strtod(value, &end);
    MpmCheckInput(end == value || *end || isfinite(number), "-%s %.80s: must be a finite number", options[i].name,
                  value);
    PetscCall(CheckNumber(&options[i]));
  }
  PetscCall(PetscFree(options));
  PetscCall(PetscFree(text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmForeignOptionsFind(const char message[], char name[], size_t size)
{
  MpmDatabaseOption *options;
  PetscInt           count;
  char              *text;
  size_t             longest = 0;

  PetscFunctionBegin;
  name[0] = '\0';
  PetscCall(MpmDatabaseGetForeign(&count, &options, &text));
  for (PetscInt i = 0; i < count; i++) {
    const size_t length = options[i].value ? strlen(options[i].value) : 0;

    if (length <= longest || !strstr(message, options[i].value)) continue;
    longest = length;
    PetscCall(PetscSNPrintf(name, size, "-%.100s %.100s", options[i].name, options[i].value));
  }
  PetscCall(PetscFree(options));
  PetscCall(PetscFree(text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

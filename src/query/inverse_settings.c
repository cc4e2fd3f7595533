/*
  Settings of an inverse analysis.
*/
#include "options/options.h"
#include "query/inverse_settings.h"

PetscErrorCode MpmInverseSettingsRead(const MpmOptions *options, MpmInverseSettings *settings)
{
  static const char *const methods[] = {"gauss_newton", "blmvm", "descent", NULL};
  const MpmOptions         block     = {options->comm, "mpm_inverse_", options->record};
  PetscInt                 method = 0, groups = 1;
  PetscBool                rated, level;

  PetscFunctionBeginUser;
  settings->iterations = 20;
  settings->starts     = 1;
  settings->tolerance  = 1e-8;
  PetscCall(MpmOptionsHeading(&block, "Inverse analysis (-mpm_task inverse)"));
  PetscCall(MpmOptionsWord(&block, "method",
                           "gauss_newton: least squares by the Jacobian, with Levenberg's damping; blmvm: by gradients "
                           "alone, for many parameters; descent: steps along the gradient",
                           methods, MPM_OPTIONAL, &method, NULL));
  settings->method = (MpmInverseMethod)method;
  PetscCall(MpmOptionsInt(&block, "iterations", "at most; 0: derivatives at the start alone", 0, PETSC_INT_MAX,
                          MPM_OPTIONAL, &settings->iterations, NULL));
  PetscCall(MpmOptionsReal(&block, "tolerance", "", "of the change of all parameters, relative", MPM_RANGE_POSITIVE,
                           MPM_OPTIONAL, &settings->tolerance, NULL));
  PetscCall(MpmOptionsReal(&block, "rate", "", "of descent: step over gradient, of the transformed parameters",
                           MPM_RANGE_POSITIVE, MPM_OPTIONAL, &settings->rate, &rated));
  PetscCall(MpmOptionsInt(&block, "starts", "analyses, the first from the start values, further ones within the bounds",
                          1, PETSC_INT_MAX, MPM_OPTIONAL, &settings->starts, NULL));
  PetscCall(MpmOptionsInt(&block, "groups", "of ranks that work side by side; so far 1", 1, PETSC_INT_MAX, MPM_OPTIONAL,
                          &groups, NULL));
  PetscCall(MpmOptionsBool(&block, "restart", "go on from the last row of PREFIX_inverse.csv, where it is there",
                           &settings->restart, NULL));
  PetscCall(MpmOptionsReal(&block, "discrepancy", "",
                           "ends where the squares of the residuals over their deviations are this many times the "
                           "number of data; 0: goes on; default: 1 with more parameters than data, 0 otherwise",
                           MPM_RANGE_NON_NEGATIVE, MPM_OPTIONAL, &settings->discrepancy, &level));
  if (!level) settings->discrepancy = -1.;
  if (MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  MpmCheckInput(groups == 1, "-mpm_inverse_groups %d: must be 1 so far", (int)groups);
  MpmCheckInput(!settings->on || settings->method != MPM_DESCENT || rated,
                "-mpm_inverse_rate is missing: of the method descent");
  PetscFunctionReturn(PETSC_SUCCESS);
}

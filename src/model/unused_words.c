/*
  Warnings of options of ours that were given, are right, and change nothing in the run: those of equations where all
  stages are explicit, those of multigrid where another solver has been chosen.
*/
#include <string.h>
#include "options/database.h"
#include "options/options.h"
#include "scene/integrator_read.h"
#include "solve/solve.h"
#include "query/model.h"
#include "observe/results.h"
#include "model/build.h"

/* Options of the equations of implicit steps. */
static const char *const of_equations[] = {"mpm_jacobian",
                                           "mpm_solver",
                                           "mpm_mat_type",
                                           "mpm_vec_type",
                                           "mpm_newton_lag",
                                           "mpm_matfree_tangents",
                                           "mpm_multigrid_levels",
                                           "mpm_multigrid_order",
                                           "mpm_multigrid_coarsen",
                                           "mpm_multigrid_smoother",
                                           "mpm_multigrid_smooths",
                                           "mpm_multigrid_coarse",
                                           "mpm_multigrid_precision",
                                           "mpm_stabilization_ghost",
                                           "mpm_stabilization_filled",
                                           "mpm_stabilization_interior"};

/* Those of multigrid on coarser lattices; the precision is of all solvers without a matrix. */
static const char multigrid[] = "mpm_multigrid_", precision[] = "mpm_multigrid_precision";

/* True where the option, and its value, call for nothing in any run. */
static PetscBool AsksNothing(const char value[])
{
  return (PetscBool)(!value || !strcasecmp(value, "auto") || !strcasecmp(value, "off") || !strcmp(value, "0"));
}

/* True where the chosen solver has multigrid of ours, for all unknowns or for those of one field. */
static PetscBool HasMultigrid(const char solver[])
{
  return (PetscBool)(MpmMultigridIs(solver) || strstr(solver, "-fieldsplit"));
}

static PetscBool IsUsed(const MpmModel model, const char name[])
{
  const char *solver = model->solver.preset.name;

  if (!MpmStagesSolve(model)) return PETSC_FALSE;
  if (!strcmp(name, precision) && model->solver.jacobian.form == MPM_JACOBIAN_MATFREE) return PETSC_TRUE;
  return (PetscBool)(strncmp(name, multigrid, strlen(multigrid)) || HasMultigrid(solver));
}

PetscErrorCode MpmModelWarnUnused(MpmModel model)
{
  const PetscBool solves  = MpmStagesSolve(model);
  char            why[64] = "all stages are explicit";

  PetscFunctionBeginUser;
  if (solves) PetscCall(PetscSNPrintf(why, sizeof(why), "-mpm_solver is %.30s", model->solver.preset.name));
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(of_equations); k++) {
    const char *value = NULL;
    PetscBool   given;

    if (IsUsed(model, of_equations[k])) continue;
    PetscCall(MpmDatabaseFind(of_equations[k], &value, &given));
    if (given && !AsksNothing(value))
      PetscCall(MpmTerminalWarn(model, "warning: -%s %.80s: not used, %s", of_equations[k], value, why));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

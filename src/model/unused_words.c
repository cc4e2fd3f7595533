/*
  Warnings of options of ours that were given, are right, and change nothing in the run: those of equations where all
  stages are explicit, those of multigrid where another solver has been chosen.
*/
#include <string.h>
#include "options/options.h"
#include "scene/integrator_read.h"
#include "solve/solve.h"
#include "query/model.h"
#include "observe/results.h"
#include "model/build.h"

/* Options of the equations of implicit steps. */
static const char *const of_equations[] = {"jacobian",
                                           "solver",
                                           "mat_type",
                                           "vec_type",
                                           "newton_lag",
                                           "matfree_tangents",
                                           "multigrid_levels",
                                           "multigrid_order",
                                           "multigrid_coarsen",
                                           "multigrid_smoother",
                                           "multigrid_smooths",
                                           "multigrid_coarse",
                                           "multigrid_precision",
                                           "stabilization_ghost",
                                           "stabilization_filled",
                                           "stabilization_interior"};

/* Those of multigrid on coarser lattices; the precision is of all solvers without a matrix. */
static const char multigrid[] = "multigrid_", precision[] = "multigrid_precision";

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
  const MpmOptions options = {model->comm, "mpm_", model->record};
  char             why[64] = "all stages are explicit";

  PetscFunctionBeginUser;
  if (MpmStagesSolve(model))
    PetscCall(PetscSNPrintf(why, sizeof(why), "-mpm_solver is %.30s", model->solver.preset.name));
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(of_equations); k++) {
    const char *value;

    if (IsUsed(model, of_equations[k])) continue;
    PetscCall(MpmOptionsOwnValue(&options, of_equations[k], &value));
    if (value && strcmp(value, "off"))
      PetscCall(MpmTerminalWarn(model, "warning: -mpm_%s %.80s: not used, %s", of_equations[k], value, why));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

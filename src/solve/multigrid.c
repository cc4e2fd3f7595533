/*
  Options of multigrid on coarser lattices (levels/), and PETSc's options that follow from them.
*/
#include "options/database.h"
#include "options/options.h"
#include "assembly/sparsity.h"
#include "assembly/terms.h"
#include "problem/discretization.h"
#include "solve/solve.h"

static const char *const smoothers[] = {"auto", "jacobi", "pbjacobi", "ilu", NULL};
static const char *const coarsest[]  = {"direct", "gamg", NULL};

/* A number, or the word `auto`, which is 0. */
static PetscErrorCode ReadLevels(MpmMultigrid *multigrid, const MpmOptions *options)
{
  char *text;

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsText(options, "multigrid_levels",
                           "levels of solver: hmg, the finest one included; auto: until a level has 3000 unknowns",
                           "auto", MPM_OPTIONAL, &text));
  multigrid->levels.levels = 0;
  if (text && strcmp(text, "auto"))
    MpmCheckInput(MpmParseInt(text, &multigrid->levels.levels) && multigrid->levels.levels >= 2 &&
                    multigrid->levels.levels <= MPM_LEVELS_MOST,
                  "-mpm_multigrid_levels %s: must be auto or a number from 2 to %d", text, MPM_LEVELS_MOST);
  PetscCall(PetscFree(text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmMultigridSetFromOptions(MpmMultigrid *multigrid, const MpmOptions *options)
{
  PetscFunctionBeginUser;
  multigrid->smooths        = 3;
  multigrid->levels.coarsen = 2;
  PetscCall(ReadLevels(multigrid, options));
  PetscCall(
    MpmOptionsInt(options, "multigrid_coarsen",
                  "cells an axis that become one on the next level; with 3 levels of quadratic splines are nested", 2,
                  3, MPM_OPTIONAL, &multigrid->levels.coarsen, NULL));
  PetscCall(MpmOptionsWord(
    options, "multigrid_smoother",
    "preconditioner of Chebyshev's method on the levels; auto: jacobi, or ilu where the Jacobian is not symmetric",
    smoothers, MPM_OPTIONAL, &multigrid->smoother, NULL));
  PetscCall(MpmOptionsInt(options, "multigrid_smooths", "its steps before and after the coarser level", 1, 20,
                          MPM_OPTIONAL, &multigrid->smooths, NULL));
  PetscCall(MpmOptionsWord(options, "multigrid_coarse", "solver of the coarsest level", coarsest, MPM_OPTIONAL,
                           &multigrid->coarse, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Where the Jacobian is not symmetric, `auto` leaves the choice to that of other multigrids (presets.c). */
static PetscErrorCode ApplySmoother(const MpmSolver *solver)
{
  const char *name = smoothers[solver->multigrid.smoother];

  PetscFunctionBeginUser;
  if (!strcmp(name, "ilu")) {
    PetscCall(MpmDatabaseDefault("-mg_levels_pc_type", PCBJACOBI));
    PetscCall(MpmDatabaseDefault("-mg_levels_sub_pc_type", PCILU));
    PetscCall(MpmDatabaseDefault("-mg_levels_sub_pc_factor_shift_type", "inblocks"));
  } else if (strcmp(name, "auto")) PetscCall(MpmDatabaseDefault("-mg_levels_pc_type", name));
  else if (solver->definite.symmetric) PetscCall(MpmDatabaseDefault("-mg_levels_pc_type", PCJACOBI));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmMultigridApply(MpmSolver *solver)
{
  const MpmMultigrid *multigrid = &solver->multigrid;
  char                smooths[16];

  PetscFunctionBeginUser;
  MpmCheckInput(!strcmp(solver->jacobian.mat_type, MATAIJ),
                "-mpm_mat_type %s: not available with -mpm_solver hmg, must be " MATAIJ, solver->jacobian.mat_type);
  PetscCall(PetscSNPrintf(smooths, sizeof(smooths), "%" PetscInt_FMT, multigrid->smooths));
  PetscCall(MpmDatabaseDefault("-mg_levels_ksp_max_it", smooths));
  PetscCall(ApplySmoother(solver));
  if (!strcmp(coarsest[multigrid->coarse], "gamg")) {
    PetscCall(MpmDatabaseDefault("-mg_coarse_pc_type", PCGAMG));
    PetscCall(MpmDatabaseDefault("-mg_coarse_pc_gamg_threshold", "0.02"));
  } else {
    PetscCall(MpmDatabaseDefault("-mg_coarse_pc_type", solver->definite.symmetric ? PCCHOLESKY : PCLU));
    PetscCall(MpmDatabaseDefault("-mg_coarse_pc_factor_mat_solver_type", MATSOLVERMUMPS));
  }
  PetscCall(MpmDatabaseDefault("-mg_coarse_ksp_type", KSPPREONLY));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Element blocks of all terms where the shell has its state. */
static PetscErrorCode SumBlocks(void *ctx, const MpmElementAction *action)
{
  const MpmSolver *solver  = (const MpmSolver *)ctx;
  MpmPattern       pattern = {.block = solver->disc->block, .dim = solver->disc->dim, .action = action};
  const PetscReal *u;
  PetscInt         failed;

  PetscFunctionBeginUser;
  PetscCall(MpmMatfreeGetState(solver->jacobian.shell, &u));
  PetscCall(MpmTermsTangent(solver->disc->terms, solver->disc->sum, u, &pattern, NULL, &failed));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmMultigridAttach(MpmSolver *solver)
{
  const MpmDiscretization *disc = solver->disc;
  KSP                      ksp;
  PC                       pc;

  PetscFunctionBeginUser;
  PetscCall(SNESGetKSP(solver->snes, &ksp));
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(MpmLevelsAttach(pc, &solver->multigrid.levels,
                            &(MpmLevelsStep){.grid        = disc->grid,
                                             .space       = disc->space,
                                             .constraints = disc->constraints,
                                             .tangent     = SumBlocks,
                                             .ctx         = solver}));
  PetscFunctionReturn(PETSC_SUCCESS);
}

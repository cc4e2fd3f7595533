/*
  Options of multigrid on coarser lattices and lower orders (levels/), and PETSc's options that follow from them.
*/
#include "grid/shape.h"
#include "options/database.h"
#include "options/options.h"
#include "assembly/sparsity.h"
#include "assembly/terms.h"
#include "problem/discretization.h"
#include "solve/solve.h"

static const char *const smoothers[]  = {"auto", "jacobi", "pbjacobi", "ilu", "cells", NULL};
static const char *const coarsest[]   = {"direct", "gamg", NULL};
static const char *const precisions[] = {"double", "single", NULL};

/* A number, or the word `auto`, which is 0. */
static PetscErrorCode ReadLevels(MpmMultigrid *multigrid, const MpmOptions *options)
{
  char *text;

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsText(options, "multigrid_levels",
                           "levels of solver: hmg, pmg, the finest one included; auto: until a level has 3000 unknowns",
                           "auto", MPM_OPTIONAL, &text));
  multigrid->levels.levels = 0;
  if (text && strcmp(text, "auto"))
    MpmCheckInput(MpmParseInt(text, &multigrid->levels.levels) && multigrid->levels.levels >= 2 &&
                    multigrid->levels.levels <= MPM_LEVELS_MOST,
                  "-mpm_multigrid_levels %s: must be auto or a number from 2 to %d", text, MPM_LEVELS_MOST);
  PetscCall(PetscFree(text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscBool MpmMultigridIs(const char name[])
{
  return (PetscBool)(!strcmp(name, "hmg") || !strcmp(name, "pmg"));
}

/* Orders from that of the shape down, out of a text such as 4,2,1. */
static PetscErrorCode ParseOrders(const char text[], PetscInt finest, MpmLevelsChoice *levels)
{
  char **word;
  int    words;

  PetscFunctionBeginUser;
  PetscCall(PetscStrToArray(text, ',', &words, &word));
  for (int k = 0; k < words; k++) {
    const PetscInt above = k ? levels->order[k - 1] : finest + 1;
    PetscInt       order;

    MpmCheckInput(
      MpmParseInt(word[k], &order) && order >= 1 && order < above && (k || order == finest),
      "-mpm_multigrid_order %s: must be auto or orders that decrease from that of -mpm_shape, %" PetscInt_FMT
      ", to 1 at least",
      text, finest);
    levels->order[k] = order;
    levels->orders   = k + 1;
  }
  PetscCall(PetscStrToArrayDestroy(words, word));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Orders of the first levels: those given, or halved. */
static PetscErrorCode ReadOrders(MpmSolver *solver, const MpmOptions *options)
{
  MpmLevelsChoice *levels = &solver->multigrid.levels;
  const PetscInt   finest = MpmShapeOrder(levels->shape);
  const PetscBool  hmg    = (PetscBool)!strcmp(solver->preset.name, "hmg"),
                  pmg     = (PetscBool)!strcmp(solver->preset.name, "pmg");
  char *text;

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsText(options, "multigrid_order",
                           "solver: pmg: orders of the elements of the first levels, from that of the shape down; "
                           "auto: halved, 4,2,1 or 3,1 or 2,1",
                           "auto", MPM_OPTIONAL, &text));
  MpmCheckInput(!pmg || finest > 1 || MpmOptionsHelp(),
                "-mpm_solver pmg: needs -mpm_shape element or gimp_element of order 2 to 4, must be hmg with "
                "-mpm_shape %s",
                MpmShapeName(levels->shape));
  levels->order[0] = finest;
  levels->orders   = 1;
  if (text && strcmp(text, "auto")) {
    MpmCheckInput(pmg, "-mpm_multigrid_order %s: must be given with -mpm_solver pmg only", text);
    PetscCall(ParseOrders(text, finest, levels));
  } else {
    for (PetscInt order = finest / 2; !hmg && order >= 1; order /= 2) levels->order[levels->orders++] = order;
  }
  PetscCall(PetscFree(text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmMultigridSetFromOptions(MpmSolver *solver, const MpmOptions *options)
{
  MpmMultigrid *multigrid = &solver->multigrid;

  PetscFunctionBeginUser;
  multigrid->smooths        = 0;
  multigrid->levels.coarsen = 2;
  PetscCall(ReadLevels(multigrid, options));
  PetscCall(ReadOrders(solver, options));
  PetscCall(
    MpmOptionsInt(options, "multigrid_coarsen",
                  "cells an axis that become one on the next level; with 3 levels of quadratic splines are nested", 2,
                  3, MPM_OPTIONAL, &multigrid->levels.coarsen, NULL));
  PetscCall(MpmOptionsWord(
    options, "multigrid_smoother",
    "preconditioner of Chebyshev's method on the levels (ilu: ICC(0) where the Jacobian is symmetric; cells: jacobi, "
    "and "
    "the inverse in cells with stiff and soft points); auto: ilu, jacobi with contact, cells without a matrix",
    smoothers, MPM_OPTIONAL, &multigrid->smoother, NULL));
  PetscCall(MpmOptionsInt(options, "multigrid_smooths",
                          "its steps before and after the coarser level (by default 1 with ICC(0), otherwise 3)", 1, 20,
                          MPM_OPTIONAL, &multigrid->smooths, NULL));
  PetscCall(MpmOptionsWord(options, "multigrid_coarse", "solver of the coarsest level", coarsest, MPM_OPTIONAL,
                           &multigrid->coarse, NULL));
  PetscCall(MpmOptionsWord(options, "multigrid_precision",
                           "of the points' tangents with -mpm_jacobian matfree; single: half of their memory, for laws "
                           "without F-bar",
                           precisions, MPM_OPTIONAL, &multigrid->single, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets an option of the levels with this prefix, unless the user has. */
static PetscErrorCode Default(const char prefix[], const char name[], const char value[])
{
  char option[128];

  PetscFunctionBeginUser;
  PetscCall(PetscSNPrintf(option, sizeof(option), "-%s%s", prefix, name));
  PetscCall(MpmDatabaseDefault(option, value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Chebyshev's method with a smoother on all levels. Incomplete factors reach modes of little stiffness along stiff
  neighbours: cut cells of splines and of elements (docs/solver.md has the table). With ICC(0) one step over the upper
  part of the eigenvalues costs least. The stiff couplings of contacts shift its pivots: Jacobi there. Where the
  Jacobian is not symmetric `auto` leaves the choice to that of other multigrids (presets.c).
*/
static PetscErrorCode ApplySmoother(MpmSolver *solver, const char prefix[], PetscBool contacts)
{
  const PetscBool symmetric = solver->definite.symmetric, block = (PetscBool)(prefix[0] != 0);
  const PetscBool shell = (PetscBool)(solver->jacobian.form == MPM_JACOBIAN_MATFREE && !block);
  const char     *name  = smoothers[solver->multigrid.smoother];
  PetscInt        steps = solver->multigrid.smooths;
  char            smooths[16], own[64];
  PetscBool       chosen;

  PetscFunctionBeginUser;
  PetscCall(PetscSNPrintf(own, sizeof(own), "%smg_levels_pc_type", prefix));
  PetscCall(MpmDatabaseHas(own, &chosen));
  if (chosen) name = "auto";
  else if (!strcmp(name, "auto") && (symmetric || shell || block)) name = shell ? "cells" : contacts ? "jacobi" : "ilu";
  MpmCheckInput(shell || strcmp(name, "cells"),
                "-mpm_multigrid_smoother cells: needs -mpm_jacobian matfree, must be another with a matrix");
  solver->multigrid.levels.cells = (PetscBool)!strcmp(name, "cells");
  if (!strcmp(name, "ilu")) {
    PetscCall(Default(prefix, "mg_levels_pc_type", PCBJACOBI));
    PetscCall(Default(prefix, "mg_levels_sub_pc_type", symmetric ? PCICC : PCILU));
    if (symmetric || block) PetscCall(Default(prefix, "mg_levels_ksp_chebyshev_esteig", "0,0.3,0,1.1"));
    if (!symmetric) PetscCall(Default(prefix, "mg_levels_sub_pc_factor_shift_type", "inblocks"));
    if ((symmetric || block) && !steps) steps = 1;
  } else if (strcmp(name, "auto")) PetscCall(Default(prefix, "mg_levels_pc_type", name));
  PetscCall(PetscSNPrintf(smooths, sizeof(smooths), "%" PetscInt_FMT, steps ? steps : 3));
  PetscCall(Default(prefix, "mg_levels_ksp_max_it", smooths));
  if (symmetric) PetscCall(Default(prefix, "mg_levels_esteig_ksp_type", KSPCG)); /* GMRES keeps twelve vectors */
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmMultigridApply(MpmSolver *solver, const char prefix[], PetscBool contacts)
{
  const MpmMultigrid *multigrid = &solver->multigrid;

  PetscFunctionBeginUser;
  MpmCheckInput(!strcmp(solver->jacobian.mat_type, MATAIJ),
                "-mpm_mat_type %s: not available with -mpm_solver %s, must be " MATAIJ, solver->jacobian.mat_type,
                solver->preset.name);
  PetscCall(ApplySmoother(solver, prefix, contacts));
  if (!strcmp(coarsest[multigrid->coarse], "gamg")) {
    PetscCall(Default(prefix, "mg_coarse_pc_type", PCGAMG));
    PetscCall(Default(prefix, "mg_coarse_pc_gamg_threshold", "0.02"));
  } else {
    PetscCall(Default(prefix, "mg_coarse_pc_type", solver->definite.symmetric ? PCCHOLESKY : PCLU));
    PetscCall(Default(prefix, "mg_coarse_pc_factor_mat_solver_type", MATSOLVERMUMPS));
  }
  PetscCall(Default(prefix, "mg_coarse_ksp_type", KSPPREONLY));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Element blocks of the terms where the shell has its state, without the points where it keeps their tangents. */
static PetscErrorCode SumBlocks(void *ctx, const MpmElementAction *action, const struct MpmFactored **factored)
{
  const MpmSolver *solver  = (const MpmSolver *)ctx;
  MpmPattern       pattern = {.block = solver->disc->block, .dim = solver->disc->dim, .action = action};
  const PetscReal *u;
  PetscInt         failed;

  PetscFunctionBeginUser;
  PetscCall(MpmMatfreeGetState(solver->jacobian.shell, &u, factored));
  if (*factored) PetscCall(MpmTermsTangentRest(solver->disc->terms, solver->disc->sum, u, &pattern, &failed));
  else PetscCall(MpmTermsTangent(solver->disc->terms, solver->disc->sum, u, &pattern, NULL, &failed));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmMultigridAttach(MpmSolver *solver, PC pc, PetscInt components)
{
  const MpmDiscretization *disc = solver->disc;

  PetscFunctionBeginUser;
  PetscCall(MpmLevelsAttach(pc, &solver->multigrid.levels,
                            &(MpmLevelsStep){.grid        = disc->grid,
                                             .space       = disc->space,
                                             .constraints = disc->constraints,
                                             .components  = components,
                                             .tangent     = SumBlocks,
                                             .ctx         = solver}));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmMultigridLevels(const MpmSolver *solver, PetscInt *levels)
{
  KSP ksp;
  PC  pc;

  PetscFunctionBeginUser;
  *levels = 0;
  if (!solver->snes) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SNESGetKSP(solver->snes, &ksp));
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(MpmLevelsCount(pc, levels));
  PetscFunctionReturn(PETSC_SUCCESS);
}

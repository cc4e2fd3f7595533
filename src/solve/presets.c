/*
  Presets of PETSc's options: choice by the size and kind of the problem, and options that depend on it.
*/
#include "grid/shape.h"
#include "options/database.h"
#include "options/options.h"
#include "point/layout.h"
#include "assembly/terms.h"
#include "problem/discretization.h"
#include "problem/fields.h"
#include "solve/solve.h"

/* The presets, embedded by the build from options/: {name, text of the file}. */
static const struct {
  const char *name, *text;
} presets[] = {
#include "mpm_presets.h"
};

/* Sets an option, with another value in steps in which nothing touches; NULL: none. */
static PetscErrorCode OptionAtRest(MpmSolver *solver, const char *name, const char *at_rest, const char *touching)
{
  PetscBool set;

  PetscFunctionBeginUser;
  PetscCall(MpmDatabaseHas(name + 1, &set));
  if (set) PetscFunctionReturn(PETSC_SUCCESS);
  if (touching) PetscCall(PetscOptionsSetValue(NULL, name, touching));
  if (!solver->at_rest.serves) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCheck(solver->at_rest.count < MPM_AT_REST, PETSC_COMM_SELF, PETSC_ERR_PLIB, "MPM_AT_REST is too small");
  solver->at_rest.option[solver->at_rest.count].name       = name;
  solver->at_rest.option[solver->at_rest.count].at_rest    = at_rest;
  solver->at_rest.option[solver->at_rest.count++].touching = touching;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Takes the lines `-name value` of a preset; `#` starts a comment. */
static PetscErrorCode ApplyPreset(const char *text)
{
  char **line;
  int    lines;

  PetscFunctionBeginUser;
  PetscCall(PetscStrToArray(text, '\n', &lines, &line));
  for (int i = 0; i < lines; i++) {
    char **word;
    int    words;

    if (line[i][0] != '-') continue;
    PetscCall(PetscStrToArray(line[i], ' ', &words, &word));
    if (words) PetscCall(MpmDatabaseDefault(word[0], words > 1 ? word[1] : NULL));
    PetscCall(PetscStrToArrayDestroy(words, word));
  }
  PetscCall(PetscStrToArrayDestroy(lines, line));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Direct solvers win below these numbers of unknowns: time and memory grow as their power 3/2 in 2D and 2 in 3D.
  Measured over two steps and more, since points on the lattice make rows half as long as later (docs/solver.md has the
  table).
*/
static const struct {
  PetscReal plain, fbar, poro;
} direct_most[] = {
  [2] = {.plain = 1e6, .fbar = 1e6, .poro = 2e4},
  [3] = {.plain = 5e3, .fbar = 1e5, .poro = 5e3}, /* near incompressibility is hard for multigrid */
};

/* Choice of `auto`, and its reason. */
static PetscErrorCode ChooseSolver(MpmSolver *solver, PetscReal unknowns, const char **name)
{
  const PetscInt dim  = solver->disc->dim;
  PetscReal      most = direct_most[dim].plain;
  char           why[128];

  PetscFunctionBeginUser;
  if (solver->disc->layout->traits.saddle) {
    most = direct_most[dim].poro;
    if (!MpmFieldsplitServes(solver->disc->layout)) most = PETSC_INFINITY;
    *name = unknowns <= most ? "direct" : "poro-fieldsplit";
    PetscCall(PetscSNPrintf(why, sizeof(why),
                            "auto: %" PetscInt_FMT "D, a saddle point of about %.0f unknowns, direct up to %.0f", dim,
                            (double)unknowns, (double)most));
  } else if (solver->jacobian.form == MPM_JACOBIAN_MATFREE) {
    const PetscInt  order = MpmShapeOrder(solver->multigrid.levels.shape);
    const PetscBool pmg =
      (PetscBool)(order > 1 && solver->definite.symmetric && solver->disc->layout->field_count == 1);

    *name = pmg ? "pmg" : "pbjacobi";
    PetscCall(PetscSNPrintf(why, sizeof(why), "auto: no matrix, order %" PetscInt_FMT, order));
  } else {
    const PetscBool fbar = (PetscBool)(solver->disc->layout->means && direct_most[dim].fbar > most);

    if (fbar) most = direct_most[dim].fbar;
    *name = MpmFieldsplitServesDamage(solver->disc->layout) ? "damage-fieldsplit" : "amg";
    if (unknowns <= most) *name = "direct";
    PetscCall(PetscSNPrintf(why, sizeof(why), "auto: %" PetscInt_FMT "D%s, about %.0f unknowns, direct up to %.0f", dim,
                            fbar ? " with F-bar" : "", (double)unknowns, (double)most));
  }
  PetscCall(PetscStrallocpy(why, &solver->preset.why));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Settings of the direct preset that depend on the Jacobian: symmetry and size. Small ones may be narrow enough for the
  band solver (pc_band.c), which tests that; not where the user names a package. Of MUMPS' scalings for symmetric
  matrices that by the diagonal costs least. In 2D, below this size, quasi-dense minimum degree (QAMD) beats nested
  dissection, and the last front is too small to be shared out by ScaLAPACK.
*/
#define SMALL_IN_2D 5e4

static PetscErrorCode TuneDirect(MpmSolver *solver, PetscReal unknowns)
{
  const PetscBool small       = (PetscBool)(unknowns < SMALL_IN_2D);
  const PetscBool saddle      = (PetscBool)!MpmFieldsDoWork(solver->disc->layout);
  char            package[64] = "";
  PetscBool       chosen, packaged;

  PetscFunctionBeginUser;
  PetscCall(PetscOptionsHasName(NULL, NULL, "-pc_type", &chosen));
  PetscCall(PetscOptionsHasName(NULL, NULL, "-pc_factor_mat_solver_type", &packaged));
  if (small && solver->definite.symmetric && !saddle && !chosen && !packaged) {
    PetscCall(MpmDatabaseDefault("-pc_type", "band"));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (!saddle && solver->at_rest.serves) {
    PetscCall(OptionAtRest(solver, "-pc_type", small && !packaged ? "band" : "cholesky", "lu"));
    if (!chosen) PetscCall(OptionAtRest(solver, "-mat_mumps_icntl_8", "1", NULL));
  }
  PetscCall(MpmDatabaseDefault("-pc_factor_mat_solver_type", MATSOLVERMUMPS));
  PetscCall(MpmDatabaseDefault("-pc_type", solver->definite.symmetric ? "cholesky" : "lu"));
  PetscCall(PetscOptionsGetString(NULL, NULL, "-pc_factor_mat_solver_type", package, sizeof(package), NULL));
  if (chosen || strcmp(package, MATSOLVERMUMPS)) PetscFunctionReturn(PETSC_SUCCESS);
  if (solver->definite.symmetric && !saddle) PetscCall(MpmDatabaseDefault("-mat_mumps_icntl_8", "1"));
  if (MpmStabilityWanted(solver))
    PetscCall(MpmDatabaseDefault("-mat_mumps_icntl_13", "1")); /* or not all pivots are counted */
  if (solver->disc->dim == 2 && small) {
    PetscCall(MpmDatabaseDefault("-mat_mumps_icntl_7", "6"));
    PetscCall(MpmDatabaseDefault("-mat_mumps_icntl_13", "1"));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  The amg preset where the Jacobian is not symmetric: ILU(0) in Chebyshev's method, over a range of eigenvalues wide
  enough for the soft modes of perfectly plastic points (docs/solver.md has the table). GMRES is preconditioned from the
  right: it then uses the residual itself, where a Jacobian is almost singular, too. The graph keeps weak couplings,
  since aggregates of one or two nodes make singular blocks; a shift in N/m, far below a node's stiffness, steps over
  those. A smoother or a Krylov method that the user names has its own. The stiff couplings of contacts move Chebyshev's
  method with ILU off its range: SOR smooths there.
*/
static PetscErrorCode TuneMultigrid(MpmSolver *solver, PetscBool contacts)
{
  static const char *const tuned[][2] = {
    {"-pc_gamg_threshold", "0"},
    {"-mg_levels_ksp_max_it", "3"},
    {"-mg_levels_ksp_chebyshev_esteig", "0,0.03,0,1.1"},
    {"-mg_levels_pc_type", "bjacobi"},
    {"-mg_levels_sub_pc_type", "ilu"},
    {"-mg_levels_sub_pc_factor_shift_type", "inblocks"},
    {"-mg_levels_sub_pc_factor_shift_amount", "1"},
  };
  PetscBool method, smoother;

  PetscFunctionBeginUser;
  PetscCall(MpmDatabaseHas("ksp_type", &method));
  if (!method) PetscCall(OptionAtRest(solver, "-ksp_pc_side", NULL, "right"));
  PetscCall(MpmDatabaseHas("mg_levels_pc_type", &smoother));
  if (contacts) PetscCall(MpmDatabaseDefault("-mg_levels_pc_type", "sor"));
  if (smoother || contacts) PetscFunctionReturn(PETSC_SUCCESS);
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(tuned); k++) PetscCall(MpmDatabaseDefault(tuned[k][0], tuned[k][1]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The pressure's multigrid: BoomerAMG where PETSc has it, which jumps of permeability by many orders do not disturb. */
static PetscErrorCode TunePressure(void)
{
  PetscFunctionBeginUser;
#if defined(PETSC_HAVE_HYPRE)
  PetscCall(MpmDatabaseDefault("-fieldsplit_p_pc_type", "hypre"));
#else
  PetscCall(MpmDatabaseDefault("-fieldsplit_p_pc_type", "gamg"));
  PetscCall(MpmDatabaseDefault("-fieldsplit_p_mg_levels_pc_type", "sor"));
#endif
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  The damage's multigrid: BoomerAMG where PETSc has it. With GAMG the first solve of a step takes 40 iterations in place
  of 7 on 128 x 128 cells.
*/
static PetscErrorCode TuneDamage(void)
{
  PetscFunctionBeginUser;
#if defined(PETSC_HAVE_HYPRE)
  PetscCall(MpmDatabaseDefault("-fieldsplit_d_pc_type", "hypre"));
#else
  PetscCall(MpmDatabaseDefault("-fieldsplit_d_pc_type", "gamg"));
#endif
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Presets and preconditioners that a physics of several fields, or of one, cannot take. */
static PetscErrorCode CheckSuits(const MpmSolver *solver)
{
  const MpmLayout *layout  = solver->disc->layout;
  const PetscBool definite = (PetscBool)(strcmp(solver->preset.name, "auto") && strcmp(solver->preset.name, "direct") &&
                                         strcmp(solver->preset.name, "poro-fieldsplit"));
  char            type[64] = "";

  PetscFunctionBeginUser;
  MpmCheckInput(strcmp(solver->preset.name, "poro-fieldsplit") ||
                  (layout->traits.saddle && MpmFieldsplitServes(layout)),
                "-mpm_solver poro-fieldsplit: needs a displacement and a pressure, must be another with this physics");
  MpmCheckInput(!definite || !layout->traits.saddle,
                "-mpm_solver %s: needs a definite Jacobian, must be auto, direct or poro-fieldsplit with this physics",
                solver->preset.name);
  MpmCheckInput(strcmp(solver->preset.name, "damage-fieldsplit") || MpmFieldsplitServesDamage(layout),
                "-mpm_solver damage-fieldsplit: needs a displacement and a damage, must be another with this physics");
  PetscCall(PetscOptionsGetString(NULL, NULL, "-pc_type", type, sizeof(type), NULL));
  MpmCheckInput(strcmp(type, "band") || MpmFieldsDoWork(layout),
                "-pc_type band: is for one field, must be cholesky or lu with this physics");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* True where forces show whether anything touches: not with a bilateral boundary. */
static PetscBool ServesAtRest(const MpmSolver *solver)
{
  if (MpmTermsTraits(solver->disc->terms) & MPM_TERM_BILATERAL) return PETSC_FALSE;
  return (PetscBool)(solver->definite.symmetric && !solver->disc->layout->traits.saddle &&
                     solver->jacobian.form != MPM_JACOBIAN_MATFREE);
}

/*
  Errors of steps of motion add up, and small reactions of a contact stand beside large ones: with PETSc's 1e-8 results
  would differ by 1e-7 with the number of ranks. A direct solver's last iteration goes far below that anyway; with the
  preconditioner kept, another iteration or two of multigrid cost 10 % of a step.
*/
#define RTOL_TIGHT "1e-12"

const char *MpmPresetName(PetscInt k)
{
  return k < (PetscInt)PETSC_STATIC_ARRAY_LENGTH(presets) ? presets[k].name : NULL;
}

PetscErrorCode MpmPresetApply(MpmSolver *solver, PetscReal unknowns, PetscBool inertia)
{
  const PetscBool contacts = (PetscBool)((MpmTermsTraits(solver->disc->terms) & MPM_TERM_CONTACT) > 0);
  const char     *name     = solver->preset.name;
  PetscBool       direct;

  PetscFunctionBeginUser;
  PetscCall(CheckSuits(solver));
  if (solver->at_rest.serves) {
    solver->at_rest.serves     = ServesAtRest(solver);
    solver->definite.symmetric = PETSC_FALSE;
  }
  if (!strcmp(name, "auto")) PetscCall(ChooseSolver(solver, unknowns, &name));
  direct = (PetscBool)!strcmp(name, "direct");
  if (!strcmp(name, "poro-fieldsplit")) PetscCall(TunePressure());
  if (!strcmp(name, "damage-fieldsplit")) PetscCall(TuneDamage());
  if (strstr(name, "-fieldsplit")) PetscCall(MpmFieldsplitTune(solver, contacts));
  if (MpmMultigridIs(name)) PetscCall(MpmMultigridApply(solver, "", contacts));
  if ((!strcmp(name, "amg") || MpmMultigridIs(name)) && !solver->definite.symmetric)
    PetscCall(TuneMultigrid(solver, contacts));
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(presets); k++)
    if (!strcmp(presets[k].name, name)) PetscCall(ApplyPreset(presets[k].text));
  if (name != solver->preset.name) {
    PetscCall(PetscFree(solver->preset.name));
    PetscCall(PetscStrallocpy(name, &solver->preset.name));
  }
  if (direct) PetscCall(TuneDirect(solver, unknowns));
  else {
    PetscBool chosen;

    if ((inertia || contacts) && !solver->disc->layout->traits.saddle)
      PetscCall(MpmDatabaseDefault("-snes_rtol", RTOL_TIGHT));
    PetscCall(PetscOptionsHasName(NULL, NULL, "-ksp_type", &chosen));
    solver->definite.may_be_lost = (PetscBool)((solver->definite.symmetric || solver->at_rest.serves) && !chosen);
    PetscCall(OptionAtRest(solver, "-ksp_type", "cg", solver->definite.symmetric ? "cg" : "gmres"));
    if (!solver->definite.symmetric && !chosen) PetscCall(MpmDatabaseDefault("-ksp_gmres_restart", "100"));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Newton and its linear solver: PETSc's SNES and KSP, set up by presets from options/ that any PETSc option overrides.
*/
#include "base/rows.h"
#include "options/database.h"
#include "options/options.h"
#include "options/record.h"
#include "point/layout.h"
#include "grid/grid.h"
#include "space/space.h"
#include "bc/bc.h"
#include "assembly/sparsity.h"
#include "assembly/terms.h"
#include "problem/discretization.h"
#include "solve/pc_band.h"
#include "solve/solve.h"

/* The presets, embedded by the build from options/: {name, text of the file}. */
static const struct {
  const char *name, *text;
} presets[] = {
#include "mpm_presets.h"
};

const char *const MpmJacobianTypes[] = {"auto", "local", "coloring", "matfree", "dense", "fd", NULL};

/* Sets an option that the user has not set; that is no use of it. */
static PetscErrorCode OptionDefault(const char *name, const char *value)
{
  PetscBool set;

  PetscFunctionBeginUser;
  PetscCall(MpmDatabaseHas(name + 1, &set));
  if (!set) PetscCall(PetscOptionsSetValue(NULL, name, value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The same, with another value in steps in which nothing touches; NULL: none. */
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
    if (words) PetscCall(OptionDefault(word[0], words > 1 ? word[1] : NULL));
    PetscCall(PetscStrToArrayDestroy(words, word));
  }
  PetscCall(PetscStrToArrayDestroy(lines, line));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- set-up ---- */

static PetscErrorCode CreateSNES(MpmSolver *solver)
{
  KSP       ksp;
  PC        pc;
  PetscBool band;

  PetscFunctionBeginUser;
  PetscCall(SNESCreate(solver->disc->comm, &solver->snes));
  PetscCall(MpmNewtonAttach(solver));
  PetscCall(SNESSetFromOptions(solver->snes));
  PetscCall(SNESGetKSP(solver->snes, &ksp));
  if (solver->indefinite) {
    PetscCall(KSPSetType(ksp, KSPGMRES));
    PetscCall(KSPGMRESSetRestart(ksp, 100));
  }
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(PetscObjectTypeCompareAny((PetscObject)pc, &solver->factorises, PCLU, PCCHOLESKY, ""));
  PetscCall(PetscObjectTypeCompareAny((PetscObject)pc, &solver->matrix_unused, PCNONE, PCJACOBI, PCPBJACOBI, PCSHELL,
                                      PCMAT, ""));
  PetscCall(MpmBandIs(pc, &band));
  if (band) {
    solver->factorises    = PETSC_TRUE;
    solver->matrix_unused = PETSC_FALSE;
  }
  solver->matrix_unused = (PetscBool)(solver->matrix_unused && solver->jacobian_type == MPM_JACOBIAN_MATFREE);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Does PETSc know the type? One of the objects is made and thrown away. */
static PetscErrorCode KnowsType(MpmSolver *solver, const char *kind, const char *type, PetscBool *known)
{
  PetscErrorCode error;
  Mat            mat;
  Vec            vec;
  SNES           snes;
  KSP            ksp;
  PC             pc;

  PetscFunctionBeginUser;
  PetscCall(SNESCreate(solver->disc->comm, &snes));
  PetscCall(MatCreate(solver->disc->comm, &mat));
  PetscCall(VecCreate(solver->disc->comm, &vec));
  PetscCall(VecSetSizes(vec, 1, PETSC_DETERMINE));
  PetscCall(KSPCreate(solver->disc->comm, &ksp));
  PetscCall(PCCreate(solver->disc->comm, &pc));
  PetscCall(PetscPushErrorHandler(PetscReturnErrorHandler, NULL));
  if (!strcmp(kind, "mpm_mat_type")) error = MatSetType(mat, type);
  else if (!strcmp(kind, "mpm_vec_type")) error = VecSetType(vec, type);
  else if (!strcmp(kind, "snes_type")) error = SNESSetType(snes, type);
  else if (!strcmp(kind, "ksp_type")) error = KSPSetType(ksp, type);
  else error = PCSetType(pc, type);
  PetscCall(PetscPopErrorHandler());
  *known = (PetscBool)!error;
  PetscCall(MatDestroy(&mat));
  PetscCall(VecDestroy(&vec));
  PetscCall(KSPDestroy(&ksp));
  PetscCall(PCDestroy(&pc));
  PetscCall(SNESDestroy(&snes));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A type that PETSc does not know must end the run with one line, before anything is written. */
static PetscErrorCode CheckTypes(MpmSolver *solver)
{
  static const char *const kinds[] = {"mpm_mat_type", "mpm_vec_type", "snes_type", "ksp_type", "pc_type"};

  PetscFunctionBeginUser;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(kinds); k++) {
    char      name[64], type[64] = "";
    PetscBool set, known         = PETSC_TRUE;

    PetscCall(PetscSNPrintf(name, sizeof(name), "-%s", kinds[k]));
    PetscCall(PetscOptionsGetString(NULL, NULL, name, type, sizeof(type), &set));
    if (set) PetscCall(KnowsType(solver, kinds[k], type, &known));
    MpmCheckInput(known, "%s %s: PETSc does not know this type", name, type);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Direct solvers win below these numbers of unknowns: time and memory grow as their power 3/2 in 2D and 2 in 3D. Measured
  over two steps and more, since points on the lattice make rows half as long as later (docs/solver.md has the table).
*/
#define DIRECT_MOST_2D      1e6
#define DIRECT_MOST_3D      5e3
#define DIRECT_MOST_FBAR_3D 1e5
#define DIRECT_MOST_PORO_2D 2e4
#define DIRECT_MOST_PORO_3D 5e3

/* What `auto` takes, and why. */
static PetscErrorCode ChooseSolver(MpmSolver *solver, PetscReal unknowns, const char **name)
{
  PetscReal most = solver->disc->dim == 2 ? DIRECT_MOST_2D : DIRECT_MOST_3D;
  char      why[128];

  PetscFunctionBeginUser;
  if (solver->disc->layout->saddle) {
    most = solver->disc->dim == 2 ? DIRECT_MOST_PORO_2D : DIRECT_MOST_PORO_3D;
    if (!MpmFieldsplitServes(solver->disc->layout)) most = PETSC_INFINITY;
    *name = unknowns <= most ? "direct" : "poro-fieldsplit";
    PetscCall(PetscSNPrintf(why, sizeof(why),
                            "auto: %" PetscInt_FMT "D, a saddle point of about %.0f unknowns, direct up to %.0f",
                            solver->disc->dim, (double)unknowns, (double)most));
  } else if (solver->jacobian_type == MPM_JACOBIAN_MATFREE) {
    *name = "pbjacobi";
    PetscCall(PetscSNPrintf(why, sizeof(why), "auto: no matrix"));
  } else {
    if (solver->disc->dim == 3 && solver->disc->layout->means)
      most = DIRECT_MOST_FBAR_3D; /* near incompressibility is hard for multigrid */
    *name = unknowns <= most ? "direct" : "amg";
    PetscCall(PetscSNPrintf(
      why, sizeof(why), "auto: %" PetscInt_FMT "D%s, about %.0f unknowns, direct up to %.0f", solver->disc->dim,
      solver->disc->dim == 3 && solver->disc->layout->means ? " with F-bar" : "", (double)unknowns, (double)most));
  }
  PetscCall(PetscStrallocpy(why, &solver->why));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  What the direct preset cannot know: whether the Jacobian is symmetric, and how large. Small ones may be narrow enough
  for the band solver (pc_band.c), which finds out by itself; not where the user names a package. Of MUMPS' scalings for
  symmetric matrices that by the diagonal costs least. In 2D, below this size, quasi-dense minimum degree (QAMD) beats
  nested dissection, and the last front is too small to be shared out by ScaLAPACK.
*/
#define SMALL_IN_2D 5e4

static PetscErrorCode TuneDirect(MpmSolver *solver, PetscReal unknowns)
{
  const PetscBool small       = (PetscBool)(unknowns < SMALL_IN_2D);
  const PetscBool saddle      = (PetscBool)(solver->disc->layout->field_count > 1);
  char            package[64] = "";
  PetscBool       chosen, packaged;

  PetscFunctionBeginUser;
  PetscCall(PetscOptionsHasName(NULL, NULL, "-pc_type", &chosen));
  PetscCall(PetscOptionsHasName(NULL, NULL, "-pc_factor_mat_solver_type", &packaged));
  if (small && solver->symmetric && !saddle && !chosen && !packaged) {
    PetscCall(OptionDefault("-pc_type", "band"));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (!saddle && solver->at_rest.serves) {
    PetscCall(OptionAtRest(solver, "-pc_type", small && !packaged ? "band" : "cholesky", "lu"));
    if (!chosen) PetscCall(OptionAtRest(solver, "-mat_mumps_icntl_8", "1", NULL));
  }
  PetscCall(OptionDefault("-pc_factor_mat_solver_type", MATSOLVERMUMPS));
  PetscCall(OptionDefault("-pc_type", solver->symmetric ? "cholesky" : "lu"));
  PetscCall(PetscOptionsGetString(NULL, NULL, "-pc_factor_mat_solver_type", package, sizeof(package), NULL));
  if (chosen || strcmp(package, MATSOLVERMUMPS)) PetscFunctionReturn(PETSC_SUCCESS);
  if (solver->symmetric && !saddle) PetscCall(OptionDefault("-mat_mumps_icntl_8", "1"));
  if (MpmStabilityWanted(solver))
    PetscCall(OptionDefault("-mat_mumps_icntl_13", "1")); /* or not all pivots are counted */
  if (solver->disc->dim == 2 && small) {
    PetscCall(OptionDefault("-mat_mumps_icntl_7", "6"));
    PetscCall(OptionDefault("-mat_mumps_icntl_13", "1"));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  What the amg preset takes where the Jacobian is not symmetric: ILU(0) in Chebyshev's method, over a range of eigenvalues
  wide enough for the soft modes of perfectly plastic points (docs/solver.md has the table). GMRES is preconditioned from
  the right: it then sees the residual itself, where a Jacobian is almost singular, too. The graph keeps weak couplings,
  since aggregates of one or two nodes make singular blocks; a shift in N/m, far below a node's stiffness, steps over those.
  A smoother or a Krylov method that the user names has its own. The stiff couplings of contacts throw Chebyshev's method with
  ILU off its range: SOR smooths there.
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
  if (contacts) PetscCall(OptionDefault("-mg_levels_pc_type", "sor"));
  if (smoother || contacts) PetscFunctionReturn(PETSC_SUCCESS);
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(tuned); k++) PetscCall(OptionDefault(tuned[k][0], tuned[k][1]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  The pressure's multigrid: BoomerAMG where PETSc has it, which jumps of permeability by many orders do not disturb. And the
  displacement's where there is contact, whose stiff couplings of many nodes Jacobi's method does not smooth: ILU(0), shifted as above.
*/
static PetscErrorCode TuneFieldsplit(PetscBool contacts)
{
  PetscBool smoother;

  PetscFunctionBeginUser;
  PetscCall(MpmDatabaseHas("fieldsplit_u_mg_levels_pc_type", &smoother));
  if (contacts && !smoother) {
    PetscCall(OptionDefault("-fieldsplit_u_mg_levels_pc_type", "bjacobi"));
    PetscCall(OptionDefault("-fieldsplit_u_mg_levels_sub_pc_type", "ilu"));
    PetscCall(OptionDefault("-fieldsplit_u_mg_levels_sub_pc_factor_shift_type", "inblocks"));
    PetscCall(OptionDefault("-fieldsplit_u_mg_levels_sub_pc_factor_shift_amount", "1"));
  }
#if defined(PETSC_HAVE_HYPRE)
  PetscCall(OptionDefault("-fieldsplit_p_pc_type", "hypre"));
#else
  PetscCall(OptionDefault("-fieldsplit_p_pc_type", "gamg"));
  PetscCall(OptionDefault("-fieldsplit_p_mg_levels_pc_type", "sor"));
#endif
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Presets and preconditioners that a physics of several fields, or of one, cannot take. */
static PetscErrorCode CheckSuits(const MpmSolver *solver)
{
  const MpmLayout *layout   = solver->disc->layout;
  const PetscBool  definite = (PetscBool)(strcmp(solver->name, "auto") && strcmp(solver->name, "direct") &&
                                         strcmp(solver->name, "poro-fieldsplit"));
  char             type[64] = "";

  PetscFunctionBeginUser;
  MpmCheckInput(strcmp(solver->name, "poro-fieldsplit") || (layout->saddle && MpmFieldsplitServes(layout)),
                "-mpm_solver poro-fieldsplit: needs a displacement and a pressure, must be another with this physics");
  MpmCheckInput(!definite || !layout->saddle,
                "-mpm_solver %s: needs a definite Jacobian, must be auto, direct or poro-fieldsplit with this physics",
                solver->name);
  PetscCall(PetscOptionsGetString(NULL, NULL, "-pc_type", type, sizeof(type), NULL));
  MpmCheckInput(strcmp(type, "band") || layout->field_count == 1,
                "-pc_type band: is for one field, must be cholesky or lu with this physics");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Do forces show whether anything touches? Not where a boundary holds. */
static PetscBool ServesAtRest(const MpmSolver *solver)
{
  if (MpmTermsTraits(solver->disc->terms) & MPM_TERM_BILATERAL) return PETSC_FALSE;
  return (PetscBool)(solver->symmetric && !solver->disc->layout->saddle &&
                     solver->jacobian_type != MPM_JACOBIAN_MATFREE);
}

/*
  Steps of motion add up what each leaves, and small reactions of a contact stand beside large ones: to PETSc's 1e-8 they would differ by 1e-7 with
  the number of ranks. A direct solver's last iteration goes far below that anyway; with the preconditioner kept, another iteration or two of multigrid
  cost 10 % of a step.
*/
#define RTOL_TIGHT "1e-12"

PetscErrorCode MpmSolverChoose(MpmSolver *solver, PetscReal unknowns, PetscBool inertia)
{
  const PetscBool contacts = (PetscBool)((MpmTermsTraits(solver->disc->terms) & MPM_TERM_CONTACT) > 0);
  const char     *name     = solver->name;
  PetscBool       direct;

  PetscFunctionBeginUser;
  PetscCall(CheckSuits(solver));
  if (solver->at_rest.serves) {
    solver->at_rest.serves = ServesAtRest(solver);
    solver->symmetric      = PETSC_FALSE;
  }
  if (!strcmp(name, "auto")) PetscCall(ChooseSolver(solver, unknowns, &name));
  direct = (PetscBool)!strcmp(name, "direct");
  if (!strcmp(name, "poro-fieldsplit")) PetscCall(TuneFieldsplit(contacts));
  if (!strcmp(name, "amg") && !solver->symmetric) PetscCall(TuneMultigrid(solver, contacts));
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(presets); k++)
    if (!strcmp(presets[k].name, name)) PetscCall(ApplyPreset(presets[k].text));
  if (name != solver->name) {
    PetscCall(PetscFree(solver->name));
    PetscCall(PetscStrallocpy(name, &solver->name));
  }
  if (direct) PetscCall(TuneDirect(solver, unknowns));
  else {
    PetscBool chosen;

    if ((inertia || contacts) && !solver->disc->layout->saddle) PetscCall(OptionDefault("-snes_rtol", RTOL_TIGHT));
    PetscCall(PetscOptionsHasName(NULL, NULL, "-ksp_type", &chosen));
    solver->may_be_indefinite = (PetscBool)((solver->symmetric || solver->at_rest.serves) && !chosen);
    PetscCall(OptionAtRest(solver, "-ksp_type", "cg", solver->symmetric ? "cg" : "gmres"));
    if (!solver->symmetric && !chosen) PetscCall(OptionDefault("-ksp_gmres_restart", "100"));
  }
  PetscCall(CreateSNES(solver));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A PETSc type that the user may choose. */
static PetscErrorCode ReadType(const MpmOptions *options, const char *name, const char *help, const char *fallback,
                               char type[64])
{
  char *text;

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsText(options, name, help, fallback, MPM_OPTIONAL, &text));
  PetscCall(PetscStrncpy(type, text ? text : fallback, 64));
  PetscCall(PetscFree(text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static const char solver_help[] =
  "preset of PETSc solver options; auto takes direct up to 1e6 unknowns in 2D, 5e3 in "
  "3D and 1e5 in 3D with F-bar, then amg; for a displacement with a pore pressure up to "
  "2e4 in 2D and 5e3 in 3D, then poro-fieldsplit "
  "(CPU seconds of two steps in 3D, direct and amg: 1.0 and 1.0 at 4 700 unknowns, 2.8 "
  "and 2.0 at 9 800, 11.5 and 4.6 at "
  "17 000)";

PetscErrorCode MpmSolverSetFromOptions(MpmSolver *solver, const MpmOptions *options)
{
  const char *names[PETSC_STATIC_ARRAY_LENGTH(presets) + 2] = {"auto"};
  PetscInt    choice                                        = 0;

  PetscFunctionBeginUser;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(presets); k++) names[k + 1] = presets[k].name;
  PetscCall(MpmOptionsHeading(options, "Solver"));
  PetscCall(MpmOptionsWord(options, "solver", solver_help, names, MPM_OPTIONAL, &choice, NULL));
  PetscCall(PetscStrallocpy(names[choice], &solver->name));
  PetscCall(ReadType(options, "mat_type", "PETSc type of the Jacobian", MATAIJ, solver->mat_type));
  PetscCall(ReadType(options, "vec_type", "PETSc type of the vectors", VECSTANDARD, solver->vec_type));
  PetscCall(MpmBandRegister());
  PetscCall(CheckTypes(solver));
  solver->cache.lag = solver->keep_tangents = PETSC_TRUE;
  PetscCall(
    MpmOptionsBool(options, "newton_lag", "keep a Jacobian where a new one would not pay", &solver->cache.lag, NULL));
  PetscCall(MpmOptionsBool(options, "matfree_tangents", "keep the points' tangents for jacobian: matfree",
                           &solver->keep_tangents, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Solver, vectors and matrix for a new pattern. GAMG of PETSc 3.18 cannot be reset to another size: all are made again. */
static PetscErrorCode CreateObjects(MpmSolver *solver)
{
  PetscFunctionBeginUser;
  PetscCall(SNESDestroy(&solver->snes));
  PetscCall(CreateSNES(solver));
  PetscCall(MatDestroy(&solver->jacobian));
  PetscCall(VecDestroy(&solver->x));
  PetscCall(VecDestroy(&solver->f));
  if (!solver->matrix_unused)
    PetscCall(MpmPatternCreateMat(solver->disc->pattern, solver->disc->space, solver->disc->comm, solver->mat_type,
                                  &solver->jacobian));
  PetscCall(VecCreate(solver->disc->comm, &solver->x));
  PetscCall(VecSetSizes(solver->x, solver->disc->space->owned * solver->disc->block,
                        solver->disc->space->global_count * solver->disc->block));
  PetscCall(VecSetBlockSize(solver->x, solver->disc->block));
  PetscCall(VecSetType(solver->x, solver->vec_type));
  PetscCall(VecSetFromOptions(solver->x));
  PetscCall(VecDuplicate(solver->x, &solver->f));
  PetscCall(MpmFieldsplitAttach(solver));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSolverDuplicate(const MpmSolver *solver, MpmDiscretization *disc, MpmMonitor *monitor,
                                  MpmSolver *copy)
{
  PetscFunctionBeginUser;
  *copy          = *solver;
  copy->disc     = disc;
  copy->monitor  = monitor;
  copy->cache    = (MpmEvaluations){.lag = solver->cache.lag};
  copy->jacobian = copy->shell = NULL;
  copy->x = copy->f = NULL;
  copy->split       = (MpmFieldsplit){.on = PETSC_FALSE};
  copy->name = copy->why = NULL;
  MpmDatabaseCall(copy->database, CreateSNES(copy));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the options of solves with or without contact, and KSP and PC as they stand. */
static PetscErrorCode Switch(MpmSolver *solver, PetscBool at_rest)
{
  KSP       ksp;
  PC        pc;
  PetscBool gmres = PETSC_FALSE, chosen = PETSC_FALSE;

  PetscFunctionBeginUser;
  if (solver->at_rest.now == at_rest) PetscFunctionReturn(PETSC_SUCCESS);
  solver->at_rest.now = at_rest;
  for (PetscInt k = 0; k < solver->at_rest.count; k++) {
    const char *value = at_rest ? solver->at_rest.option[k].at_rest : solver->at_rest.option[k].touching;

    if (value) PetscCall(PetscOptionsSetValue(NULL, solver->at_rest.option[k].name, value));
    else PetscCall(PetscOptionsClearValue(NULL, solver->at_rest.option[k].name));
    if (!strcmp(solver->at_rest.option[k].name, "-ksp_type")) {
      chosen = PETSC_TRUE;
      gmres  = (PetscBool)!strcmp(value, "gmres");
    }
  }
  PetscCall(SNESGetKSP(solver->snes, &ksp));
  PetscCall(KSPGetPC(ksp, &pc));
  if (solver->factorises) PetscCall(PCSetFromOptions(pc));
  if (chosen && !solver->indefinite) {
    PetscCall(KSPSetType(ksp, gmres ? KSPGMRES : KSPCG));
    if (gmres) PetscCall(KSPGMRESSetRestart(ksp, 100));
    PetscCall(KSPSetPCSide(ksp, gmres ? PC_RIGHT : PC_LEFT));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSolverMindContact(MpmSolver *solver, PetscBool begins)
{
  MpmAtRest *at_rest = &solver->at_rest;
  PetscReal  squares = 0.;

  PetscFunctionBeginUser;
  if (!at_rest->count) PetscFunctionReturn(PETSC_SUCCESS);
  if (begins) {
    MpmDatabaseCall(solver->database, Switch(solver, (PetscBool)!at_rest->touched));
    at_rest->touched = PETSC_FALSE;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (at_rest->touched) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmTermsAddSquares(solver->disc->terms, solver->disc->sum, solver->disc->u, &squares));
  at_rest->touched = (PetscBool)(squares > 0. || MpmTermsHold(solver->disc->terms));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &at_rest->touched, 1, MPM_MPI_BOOL, MPI_LOR, solver->disc->comm));
  if (at_rest->touched) MpmDatabaseCall(solver->database, Switch(solver, PETSC_FALSE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SetUp(MpmSolver *solver)
{
  PetscBool changed = PETSC_TRUE;

  PetscFunctionBeginUser;
  if (!solver->matrix_unused)
    PetscCall(
      MpmPatternSetUp(&solver->disc->pattern, solver->disc->space, solver->disc->comm, solver->disc->block, &changed));
  PetscCall(MpmSolverMindContact(solver, PETSC_TRUE));
  if (changed || !solver->jacobian) PetscCall(CreateObjects(solver));
  PetscCall(MatDestroy(&solver->shell));
  if (solver->jacobian_type == MPM_JACOBIAN_MATFREE)
    PetscCall(MpmMatfreeCreate(solver, solver->keep_tangents, &solver->shell));
  PetscCall(MpmNewtonSetMats(solver));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSolverSetUp(MpmSolver *solver)
{
  PetscFunctionBeginUser;
  MpmDatabaseCall(solver->database, SetUp(solver));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Rigid body mode k at place x: translations, then rotations about the axes. */
static void RigidMode(PetscInt dim, PetscInt k, const PetscReal x[], PetscScalar mode[])
{
  for (PetscInt a = 0; a < dim; a++) mode[a] = a == k ? 1. : 0.;
  if (k < dim) return;
  {
    const PetscInt axis = dim == 2 ? 2 : k - dim, p = (axis + 1) % 3, q = (axis + 2) % 3;

    mode[p] = -x[q];
    mode[q] = x[p];
  }
}

/* Modes that the physics names for its fields: rigid body modes of the displacement, then constants of components. */
static PetscInt CountModes(const MpmLayout *layout)
{
  PetscInt count = 0;

  if (layout->near_null[0] == MPM_NEAR_NULL_RIGID) count = layout->dim == 2 ? 3 : 6;
  for (PetscInt c = 0; c < layout->block; c++) count += layout->near_null[c] == MPM_NEAR_NULL_CONSTANT;
  return count;
}

static void SetMode(const MpmLayout *layout, PetscInt k, const PetscReal x[], PetscScalar mode[])
{
  const PetscInt rigid = layout->near_null[0] != MPM_NEAR_NULL_RIGID ? 0 : layout->dim == 2 ? 3 : 6;
  PetscInt       at    = rigid;

  if (k < rigid) RigidMode(layout->dim, k, x, mode);
  for (PetscInt c = 0; c < layout->block; c++)
    if (layout->near_null[c] == MPM_NEAR_NULL_CONSTANT && at++ == k) mode[c] = 1.;
}

/* The same mode at the terms' own nodes. */
static void SetOwnModes(const MpmSolver *solver, PetscInt k, PetscScalar values[])
{
  const MpmSpace *space = solver->disc->space;
  const PetscInt  dim = solver->disc->dim, bs = solver->disc->block;
  PetscReal       along[3] = {0., 0., 0.}, turn[3] = {0., 0., 0.};

  if (k < dim) along[k] = 1.;
  else turn[dim == 2 ? 2 : (k - dim) % 3] = 1.;
  for (PetscInt i = space->extra.begin; i < PetscMin(space->owned, space->extra.begin + space->extra.count); i++)
    for (PetscInt c = 0; c < bs; c++) values[i * bs + c] = 0.;
  if (solver->disc->layout->near_null[0] != MPM_NEAR_NULL_RIGID || k >= (dim == 2 ? 3 : 6)) return;
  MpmTermsMode(solver->disc->terms, solver->disc->sum, solver->disc->grid->lower, along, turn, values);
}

/*
  Modes of little energy for multigrid. Constrained unknowns do not move, so the modes are zero there; what is left is made
  orthonormal.
*/
PetscErrorCode MpmSolverSetNearNullSpace(MpmSolver *solver)
{
  const MpmLayout *layout = solver->disc->layout;
  const PetscInt   dim = layout->dim, bs = layout->block, modes = CountModes(layout);
  MatNullSpace     space;
  Vec             *mode;
  PetscScalar     *dot;
  PetscInt         kept = 0;

  PetscFunctionBeginUser;
  if (!solver->jacobian || !modes) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MatGetNearNullSpace(solver->jacobian, &space));
  if (solver->factorises || space) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc2(modes, &mode, modes, &dot));
  for (PetscInt k = 0; k < modes; k++) {
    PetscScalar *values;
    PetscReal    norm;

    PetscCall(VecDuplicate(solver->x, &mode[kept]));
    PetscCall(VecZeroEntries(mode[kept]));
    PetscCall(VecGetArray(mode[kept], &values));
    for (PetscInt i = 0; i < solver->disc->space->owned; i++) {
      PetscReal x[MPM_MAX_DIM] = {0., 0., 0.};
      PetscInt  at[MPM_MAX_DIM];

      MpmSpaceAt(solver->disc->space, &solver->disc->space->node[i * dim], at);
      for (PetscInt a = 0; a < dim; a++) x[a] = solver->disc->grid->h[a] * (PetscReal)at[a];
      SetMode(layout, k, x, &values[i * bs]);
    }
    if (solver->disc->space->extra.count) SetOwnModes(solver, k, values);
    MpmFramesToUnknowns(solver->disc->constraints, bs, solver->disc->space->owned, values);
    MpmConstraintsZero(solver->disc->constraints, solver->disc->space->owned * bs, values);
    PetscCall(VecRestoreArray(mode[kept], &values));
    for (PetscInt pass = 0; pass < 2 && kept; pass++) {
      PetscCall(VecMDot(mode[kept], kept, mode, dot));
      for (PetscInt j = 0; j < kept; j++) dot[j] = -dot[j];
      PetscCall(VecMAXPY(mode[kept], kept, dot, mode));
    }
    PetscCall(VecNormalize(mode[kept], &norm));
    if (norm > PETSC_SQRT_MACHINE_EPSILON) kept++;
    else PetscCall(VecDestroy(&mode[kept]));
  }
  PetscCall(MatNullSpaceCreate(solver->disc->comm, PETSC_FALSE, kept, mode, &space));
  PetscCall(MatSetNearNullSpace(solver->jacobian, space));
  PetscCall(MatNullSpaceDestroy(&space));
  for (PetscInt k = 0; k < kept; k++) PetscCall(VecDestroy(&mode[k]));
  PetscCall(PetscFree2(mode, dot));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  After a linear solve has failed: a factorisation that failed must not be used again, and GAMG cannot be reset, so the
  solver is made again; with GMRES where CG met an indefinite Jacobian.
*/
PetscErrorCode MpmSolverRenew(MpmSolver *solver)
{
  KSP                ksp;
  KSPConvergedReason why;

  PetscFunctionBeginUser;
  PetscCall(SNESGetKSP(solver->snes, &ksp));
  PetscCall(KSPGetConvergedReason(ksp, &why));
  if (solver->may_be_indefinite && (why == KSP_DIVERGED_INDEFINITE_MAT || why == KSP_DIVERGED_INDEFINITE_PC)) {
    solver->may_be_indefinite = PETSC_FALSE;
    solver->indefinite        = PETSC_TRUE;
    PetscCall(MpmMonitorChange(solver->monitor, MPM_CHANGE_KRYLOV,
                               "the Jacobian is not positive definite; from here on with GMRES"));
  }
  PetscCall(SNESDestroy(&solver->snes));
  PetscCall(CreateSNES(solver));
  PetscCall(MpmFieldsplitAttach(solver));
  PetscCall(MpmNewtonSetMats(solver));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ICNTL(14), per cent: what MUMPS adds to the workspace that it expects to need. */
#define WORKSPACE      "-mat_mumps_icntl_14"
#define WORKSPACE_MORE 100
#define WORKSPACE_MOST 1600

/*
  MUMPS orders its workspace by an estimate without pivots, and gives up where these need more. Has it, for the first
  time or with less than what may be tried? Then solvers made from here on have four times as much to add.
*/
static PetscErrorCode RaiseWorkspace(MpmSolver *solver, PetscBool *raised)
{
  KSP            ksp;
  PC             pc;
  PCFailedReason why;
  MatSolverType  package = MATSOLVERMUMPS; /* the band solver's, too */
  PetscInt       percent = 0;
  PetscBool      factor;
  char           text[16];

  PetscFunctionBeginUser;
  *raised = PETSC_FALSE;
  PetscCall(SNESGetKSP(solver->snes, &ksp));
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(PCGetFailedReason(pc, &why));
  PetscCall(PetscObjectTypeCompareAny((PetscObject)pc, &factor, PCLU, PCCHOLESKY, ""));
  if (factor) PetscCall(PCFactorGetMatSolverType(pc, &package));
  if (why != PC_FACTOR_OUTMEMORY || !package || strcmp(package, MATSOLVERMUMPS)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscOptionsGetInt(NULL, NULL, WORKSPACE, &percent, NULL));
  percent = PetscMax(4 * percent, WORKSPACE_MORE);
  if (percent > WORKSPACE_MOST) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscSNPrintf(text, sizeof(text), "%" PetscInt_FMT, percent));
  PetscCall(PetscOptionsSetValue(NULL, WORKSPACE, text));
  PetscCall(MpmMonitorChange(solver->monitor, MPM_CHANGE_WORKSPACE,
                             "MUMPS ran out of its workspace and gets more (" WORKSPACE " %s)", text));
  *raised = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Newton's method from x, once more from where it came to if all that the linear solver lacked was workspace. */
static PetscErrorCode Newton(MpmSolver *solver, SNESConvergedReason *reason)
{
  PetscInt  newton, linear;
  PetscBool again;

  PetscFunctionBeginUser;
  do {
    solver->cache.solving = solver->cache.ahead = PETSC_TRUE;
    if (MpmSolverHasContact(solver)) {
      PetscCall(MpmGatherSolution(solver, solver->x));
      PetscCall(MpmTermsNewtonBegin(solver->disc->terms, solver->disc->sum, solver->disc->u, solver->careful));
    }
    PetscCall(SNESSolve(solver->snes, NULL, solver->x));
    MpmTermsNewtonEnd(solver->disc->terms);
    solver->cache.solving = PETSC_FALSE;
    PetscCall(SNESGetConvergedReason(solver->snes, reason));
    PetscCall(SNESGetIterationNumber(solver->snes, &newton));
    PetscCall(SNESGetLinearSolveIterations(solver->snes, &linear));
    solver->newton += newton;
    solver->linear += linear;
    solver->newton_total += newton;
    solver->linear_total += linear;
    again = PETSC_FALSE;
    if (*reason == SNES_DIVERGED_LINEAR_SOLVE) {
      PetscCall(RaiseWorkspace(solver, &again));
      PetscCall(MpmSolverRenew(solver));
    }
  } while (again);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSolverSolve(MpmSolver *solver, SNESConvergedReason *reason)
{
  PetscLogDouble  since, now;
  const PetscReal before = solver->monitor->seconds[MPM_TIME_RESIDUAL] + solver->monitor->seconds[MPM_TIME_JACOBIAN];
  PetscReal       inside;

  PetscFunctionBeginUser;
  PetscCall(PetscTime(&since));
  solver->cache.needed_count = 0;
  MpmDatabaseCall(solver->database, Newton(solver, reason));
  PetscCall(PetscTime(&now));
  inside = solver->monitor->seconds[MPM_TIME_RESIDUAL] + solver->monitor->seconds[MPM_TIME_JACOBIAN] - before;
  solver->monitor->seconds[MPM_TIME_SOLVE] += now - since - inside;
  solver->cache.needed_count_last = *reason > 0 ? solver->cache.needed_count : 0;
  PetscCall(MpmGatherSolution(solver, solver->x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSolverAddRows(MpmSolver *solver, MpmRows *rows)
{
  const MpmRow row[] = {
    {"newton_iterations", MPM_ROW_INT64, MPM_ROW_RUN, &solver->newton_total, 0, 0},
    {"linear_iterations", MPM_ROW_INT64, MPM_ROW_RUN, &solver->linear_total, 0, 0},
    {"indefinite", MPM_ROW_BOOL, MPM_ROW_RUN, &solver->indefinite, 0, 0},
    {"careful", MPM_ROW_BOOL, MPM_ROW_RUN, &solver->careful, 0, 0},
    {"touched", MPM_ROW_BOOL, MPM_ROW_RUN, &solver->at_rest.touched, 0, 0},
    {"jacobians_last", MPM_ROW_INT, MPM_ROW_RUN, &solver->cache.needed_count_last, 0, 0},
  };

  PetscFunctionBeginUser;
  PetscCall(MpmRowsAdd(rows, NULL, PETSC_STATIC_ARRAY_LENGTH(row), row));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSolverDestroy(MpmSolver *solver)
{
  PetscFunctionBeginUser;
  PetscCall(SNESDestroy(&solver->snes));
  PetscCall(MpmExcursionEnd(&solver->excursion));
  PetscCall(MatDestroy(&solver->jacobian));
  PetscCall(MatDestroy(&solver->shell));
  PetscCall(MpmFieldsplitReset(&solver->split));
  PetscCall(VecDestroy(&solver->x));
  PetscCall(VecDestroy(&solver->f));
  PetscCall(PetscFree(solver->name));
  PetscCall(PetscFree(solver->why));
  PetscFunctionReturn(PETSC_SUCCESS);
}

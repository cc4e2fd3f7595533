/*
  Newton and its linear solver: PETSc's SNES and KSP, set up by presets from options/ that any PETSc option overrides.
*/
#include "base/rows.h"
#include "options/database.h"
#include "options/options.h"
#include "options/record.h"
#include "point/layout.h"
#include "bc/bc.h"
#include "assembly/sparsity.h"
#include "assembly/terms.h"
#include "problem/discretization.h"
#include "precondition/pc_band.h"
#include "solve/solve.h"

const char *const MpmJacobianTypes[] = {"auto", "local", "coloring", "matfree", "dense", "fd", NULL};

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
  if (solver->definite.lost) {
    PetscCall(KSPSetType(ksp, KSPGMRES));
    PetscCall(KSPGMRESSetRestart(ksp, 100));
  }
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(PetscObjectTypeCompareAny((PetscObject)pc, &solver->preset.factorises, PCLU, PCCHOLESKY, ""));
  PetscCall(PetscObjectTypeCompareAny((PetscObject)pc, &solver->jacobian.unused, PCNONE, PCJACOBI, PCPBJACOBI, PCSHELL,
                                      PCMAT, ""));
  PetscCall(MpmBandIs(pc, &band));
  if (band) {
    solver->preset.factorises = PETSC_TRUE;
    solver->jacobian.unused   = PETSC_FALSE;
  }
  solver->jacobian.unused = (PetscBool)(solver->jacobian.unused && solver->jacobian.form == MPM_JACOBIAN_MATFREE);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* True where PETSc knows the type: one of the objects is made and destroyed. */
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

PetscErrorCode MpmSolverChoose(MpmSolver *solver, PetscReal unknowns, PetscBool inertia)
{
  PetscFunctionBeginUser;
  PetscCall(MpmPresetApply(solver, unknowns, inertia));
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

static const char solver_help[] = "preset of PETSc solver options; auto takes direct up to 1e6 unknowns in 2D, 5e3 in "
                                  "3D and 1e5 in 3D with F-bar, then amg, or damage-fieldsplit with damage; for a "
                                  "displacement with a pore pressure up to "
                                  "2e4 in 2D and 5e3 in 3D, then poro-fieldsplit "
                                  "(CPU seconds of two steps in 3D, direct and amg: 1.0 and 1.0 at 4 700 unknowns, 2.8 "
                                  "and 2.0 at 9 800, 11.5 and 4.6 at "
                                  "17 000)";

PetscErrorCode MpmSolverSetFromOptions(MpmSolver *solver, const MpmOptions *options)
{
  const char *names[MPM_PRESETS_MOST + 2] = {"auto"};
  PetscInt    choice                      = 0;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < MPM_PRESETS_MOST; k++) names[k + 1] = MpmPresetName(k);
  PetscCall(MpmOptionsHeading(options, "Solver"));
  PetscCall(MpmOptionsWord(options, "solver", solver_help, names, MPM_OPTIONAL, &choice, NULL));
  PetscCall(PetscStrallocpy(names[choice], &solver->preset.name));
  PetscCall(ReadType(options, "mat_type", "PETSc type of the Jacobian", MATAIJ, solver->jacobian.mat_type));
  PetscCall(ReadType(options, "vec_type", "PETSc type of the vectors", VECSTANDARD, solver->jacobian.vec_type));
  PetscCall(MpmBandRegister());
  PetscCall(MpmLevelsRegister());
  PetscCall(CheckTypes(solver));
  solver->cache.reuse.allowed = solver->jacobian.keeps_tangents = PETSC_TRUE;
  PetscCall(MpmOptionsBool(options, "newton_lag", "keep a Jacobian where a new one would not pay",
                           &solver->cache.reuse.allowed, NULL));
  PetscCall(MpmOptionsBool(options, "matfree_tangents", "keep the points' tangents for jacobian: matfree",
                           &solver->jacobian.keeps_tangents, NULL));
  PetscCall(MpmMultigridSetFromOptions(solver, options));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The step's nodes for multigrid of all unknowns. */
static PetscErrorCode AttachLevels(MpmSolver *solver)
{
  KSP ksp;
  PC  pc;

  PetscFunctionBeginUser;
  PetscCall(SNESGetKSP(solver->snes, &ksp));
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(MpmMultigridAttach(solver, pc, solver->disc->block));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Solver, vectors and matrix for a new pattern. GAMG of PETSc 3.18 cannot be reset to another size: all are made
   again. */
static PetscErrorCode CreateObjects(MpmSolver *solver)
{
  PetscFunctionBeginUser;
  PetscCall(SNESDestroy(&solver->snes));
  PetscCall(CreateSNES(solver));
  PetscCall(MatDestroy(&solver->jacobian.assembled));
  PetscCall(VecDestroy(&solver->x));
  PetscCall(VecDestroy(&solver->f));
  if (!solver->jacobian.unused)
    PetscCall(MpmPatternCreateMat(solver->disc->matrix.pattern, solver->disc->space, solver->disc->comm,
                                  solver->jacobian.mat_type, &solver->jacobian.assembled));
  PetscCall(VecCreate(solver->disc->comm, &solver->x));
  PetscCall(VecSetSizes(solver->x, MpmNodesOwned(solver->disc) * solver->disc->block,
                        MpmNodesTotal(solver->disc) * solver->disc->block));
  PetscCall(VecSetBlockSize(solver->x, solver->disc->block));
  PetscCall(VecSetType(solver->x, solver->jacobian.vec_type));
  PetscCall(VecSetFromOptions(solver->x));
  PetscCall(VecDuplicate(solver->x, &solver->f));
  PetscCall(MpmFieldsplitAttach(solver));
  PetscCall(AttachLevels(solver));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSolverDuplicate(const MpmSolver *solver, MpmDiscretization *disc, MpmMonitor *monitor,
                                  MpmSolver *copy)
{
  PetscFunctionBeginUser;
  *copy                    = *solver;
  copy->disc               = disc;
  copy->monitor            = monitor;
  copy->cache              = (MpmEvaluations){.reuse.allowed = solver->cache.reuse.allowed};
  copy->jacobian.assembled = copy->jacobian.shell = NULL;
  copy->x = copy->f = NULL;
  copy->split       = (MpmFieldsplit){.on = PETSC_FALSE};
  copy->preset.name = copy->preset.why = NULL;
  MpmDatabaseCall(copy->database, CreateSNES(copy));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SetUp(MpmSolver *solver)
{
  PetscBool changed = PETSC_TRUE;

  PetscFunctionBeginUser;
  if (!solver->jacobian.unused)
    PetscCall(MpmPatternSetUp(&solver->disc->matrix.pattern, solver->disc->space, solver->disc->comm,
                              solver->disc->block, &changed));
  PetscCall(MpmSolverMindContact(solver, PETSC_TRUE));
  if (changed || !solver->jacobian.assembled) PetscCall(CreateObjects(solver));
  PetscCall(MatDestroy(&solver->jacobian.shell));
  if (solver->jacobian.form == MPM_JACOBIAN_MATFREE)
    PetscCall(MpmMatfreeCreate(solver, solver->jacobian.keeps_tangents, &solver->jacobian.shell));
  PetscCall(MpmNewtonSetMats(solver));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSolverSetUp(MpmSolver *solver)
{
  PetscFunctionBeginUser;
  MpmDatabaseCall(solver->database, SetUp(solver));
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
  if (solver->definite.may_be_lost && (why == KSP_DIVERGED_INDEFINITE_MAT || why == KSP_DIVERGED_INDEFINITE_PC)) {
    solver->definite.may_be_lost = PETSC_FALSE;
    solver->definite.lost        = PETSC_TRUE;
    PetscCall(MpmMonitorChange(solver->monitor, MPM_CHANGE_KRYLOV,
                               "the Jacobian is not positive definite; from here on with GMRES"));
  }
  PetscCall(SNESDestroy(&solver->snes));
  PetscCall(CreateSNES(solver));
  PetscCall(MpmFieldsplitAttach(solver));
  PetscCall(AttachLevels(solver));
  PetscCall(MpmNewtonSetMats(solver));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ICNTL(14), per cent: addition to MUMPS' estimate of its workspace. */
#define WORKSPACE      "-mat_mumps_icntl_14"
#define WORKSPACE_MORE 100
#define WORKSPACE_MOST 1600

/*
  MUMPS orders its workspace by an estimate without pivots, and gives up where these need more. `raised`: it has, for
  the first time or with less than the allowed maximum; solvers made from here on then have four times as much to add.
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
    solver->cache.solving = PETSC_TRUE;
    solver->cache.ahead   = (PetscBool)!solver->disc->layout->traits.alternate;
    if (MpmSolverHasContact(solver)) {
      PetscCall(MpmGatherSolution(solver, solver->x));
      PetscCall(MpmTermsNewtonBegin(solver->disc->terms, solver->disc->sum, solver->disc->nodal.u, solver->careful));
    }
    PetscCall(SNESSolve(solver->snes, NULL, solver->x));
    MpmTermsNewtonEnd(solver->disc->terms);
    solver->cache.solving = PETSC_FALSE;
    MpmDiscretizationSetAlternate(solver->disc, PETSC_FALSE);
    PetscCall(SNESGetConvergedReason(solver->snes, reason));
    PetscCall(SNESGetIterationNumber(solver->snes, &newton));
    PetscCall(SNESGetLinearSolveIterations(solver->snes, &linear));
    solver->iterations.newton += newton;
    solver->iterations.linear += linear;
    solver->iterations.newton_total += newton;
    solver->iterations.linear_total += linear;
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
  solver->cache.reuse.needed = 0;
  MpmDatabaseCall(solver->database, Newton(solver, reason));
  PetscCall(PetscTime(&now));
  inside = solver->monitor->seconds[MPM_TIME_RESIDUAL] + solver->monitor->seconds[MPM_TIME_JACOBIAN] - before;
  solver->monitor->seconds[MPM_TIME_SOLVE] += now - since - inside;
  solver->cache.reuse.needed_last_time = *reason > 0 ? solver->cache.reuse.needed : 0;
  PetscCall(MpmGatherSolution(solver, solver->x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Linearise(MpmSolver *solver, Vec x, Mat *J, KSP *ksp)
{
  Mat P;

  PetscFunctionBeginUser;
  PetscCall(SNESGetJacobian(solver->snes, J, &P, NULL, NULL));
  PetscCall(SNESComputeJacobian(solver->snes, x, *J, P));
  PetscCall(SNESGetKSP(solver->snes, ksp));
  PetscCall(KSPSetOperators(*ksp, *J, P));
  PetscCall(KSPSetUp(*ksp));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSolverLinearise(MpmSolver *solver, Vec x, Mat *J, KSP *ksp)
{
  PetscFunctionBeginUser;
  MpmDatabaseCall(solver->database, Linearise(solver, x, J, ksp));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSolverAddRows(MpmSolver *solver, MpmRows *rows)
{
  const MpmRow row[] = {
    {"newton_iterations", MPM_ROW_INT64, MPM_ROW_RUN, &solver->iterations.newton_total, 0, 0},
    {"linear_iterations", MPM_ROW_INT64, MPM_ROW_RUN, &solver->iterations.linear_total, 0, 0},
    {"indefinite", MPM_ROW_BOOL, MPM_ROW_RUN, &solver->definite.lost, 0, 0},
    {"careful", MPM_ROW_BOOL, MPM_ROW_RUN, &solver->careful, 0, 0},
    {"touched", MPM_ROW_BOOL, MPM_ROW_RUN, &solver->at_rest.touched, 0, 0},
    {"jacobians_last", MPM_ROW_INT, MPM_ROW_RUN, &solver->cache.reuse.needed_last_time, 0, 0},
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
  PetscCall(MatDestroy(&solver->jacobian.assembled));
  PetscCall(MatDestroy(&solver->jacobian.shell));
  PetscCall(MpmFieldsplitReset(&solver->split));
  PetscCall(VecDestroy(&solver->x));
  PetscCall(VecDestroy(&solver->f));
  PetscCall(PetscFree(solver->preset.name));
  PetscCall(PetscFree(solver->preset.why));
  PetscFunctionReturn(PETSC_SUCCESS);
}

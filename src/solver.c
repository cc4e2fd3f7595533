/*
  Newton and its linear solver: PETSc's SNES and KSP, set up by presets from options/ that any PETSc option overrides.
*/
#include "band.h"
#include "mpmimpl.h"
#include "optionsimpl.h"

/* The presets, embedded by the build from options/: {name, text of the file}. */
static const struct {
  const char *name, *text;
} presets[] = {
#include "mpm_presets.h"
};

/* Sets an option that the user has not set; that is no use of it. */
static PetscErrorCode OptionDefault(const char *name, const char *value)
{
  PetscBool set;

  PetscFunctionBeginUser;
  PetscCall(MpmDatabaseHas(name + 1, &set));
  if (!set) PetscCall(PetscOptionsSetValue(NULL, name, value));
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

static PetscErrorCode CreateSNES(MpmModel model)
{
  KSP       ksp;
  PC        pc;
  PetscBool band;

  PetscFunctionBeginUser;
  PetscCall(SNESCreate(model->comm, &model->snes));
  PetscCall(MpmNewtonAttach(model));
  PetscCall(SNESSetFromOptions(model->snes));
  PetscCall(SNESGetKSP(model->snes, &ksp));
  if (model->indefinite) {
    PetscCall(KSPSetType(ksp, KSPGMRES));
    PetscCall(KSPGMRESSetRestart(ksp, 100));
  }
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(PetscObjectTypeCompareAny((PetscObject)pc, &model->factorises, PCLU, PCCHOLESKY, ""));
  PetscCall(PetscObjectTypeCompareAny((PetscObject)pc, &model->matrix_unused, PCNONE, PCJACOBI, PCPBJACOBI, PCSHELL,
                                      PCMAT, ""));
  PetscCall(MpmBandIs(pc, &band));
  if (band) {
    model->factorises    = PETSC_TRUE;
    model->matrix_unused = PETSC_FALSE;
  }
  model->matrix_unused = (PetscBool)(model->matrix_unused && model->jacobian_type == MPM_JACOBIAN_MATFREE);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Does PETSc know the type? One of the objects is made and thrown away. */
static PetscErrorCode KnowsType(MpmModel model, const char *kind, const char *type, PetscBool *known)
{
  PetscErrorCode error;
  Mat            mat;
  Vec            vec;
  SNES           snes;
  KSP            ksp;
  PC             pc;

  PetscFunctionBeginUser;
  PetscCall(SNESCreate(model->comm, &snes));
  PetscCall(MatCreate(model->comm, &mat));
  PetscCall(VecCreate(model->comm, &vec));
  PetscCall(VecSetSizes(vec, 1, PETSC_DETERMINE));
  PetscCall(KSPCreate(model->comm, &ksp));
  PetscCall(PCCreate(model->comm, &pc));
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
static PetscErrorCode CheckTypes(MpmModel model)
{
  static const char *const kinds[] = {"mpm_mat_type", "mpm_vec_type", "snes_type", "ksp_type", "pc_type"};

  PetscFunctionBeginUser;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(kinds); k++) {
    char      name[64], type[64] = "";
    PetscBool set, known         = PETSC_TRUE;

    PetscCall(PetscSNPrintf(name, sizeof(name), "-%s", kinds[k]));
    PetscCall(PetscOptionsGetString(NULL, NULL, name, type, sizeof(type), &set));
    if (set) PetscCall(KnowsType(model, kinds[k], type, &known));
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

/* About how many unknowns the material needs: the cells that its volume fills, and as many nodes. */
static PetscErrorCode EstimateUnknowns(MpmModel model, PetscReal *unknowns)
{
  PetscReal volume = 0.;
  MpmPoints points;

  PetscFunctionBeginUser;
  PetscCall(MpmParticlesGetArrays(&model->particles, &points));
  for (PetscInt p = 0; p < points.count; p++) volume += points.volume0[p];
  PetscCall(MpmParticlesRestoreArrays(&model->particles, &points));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &volume, 1, MPIU_REAL, MPIU_SUM, model->comm));
  for (PetscInt a = 0; a < model->grid.dim; a++) volume /= model->grid.h[a];
  *unknowns = volume * (PetscReal)model->layout.block;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* What `auto` takes, and why. */
static PetscErrorCode ChooseSolver(MpmModel model, PetscReal unknowns, const char **name)
{
  PetscReal most = model->grid.dim == 2 ? DIRECT_MOST_2D : DIRECT_MOST_3D;
  char      why[128];

  PetscFunctionBeginUser;
  if (model->jacobian_type == MPM_JACOBIAN_MATFREE) {
    *name = "pbjacobi";
    PetscCall(PetscSNPrintf(why, sizeof(why), "auto: no matrix"));
  } else {
    if (model->grid.dim == 3 && model->fbar)
      most = DIRECT_MOST_FBAR_3D; /* near incompressibility is hard for multigrid */
    *name = unknowns <= most ? "direct" : "amg";
    PetscCall(PetscSNPrintf(why, sizeof(why), "auto: %" PetscInt_FMT "D%s, about %.0f unknowns, direct up to %.0f",
                            model->grid.dim, model->grid.dim == 3 && model->fbar ? " with F-bar" : "", (double)unknowns,
                            (double)most));
  }
  PetscCall(PetscStrallocpy(why, &model->solver_why));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  What the direct preset cannot know: whether the Jacobian is symmetric, and how large. Small ones may be narrow enough
  for the band solver (band.c), which finds out by itself; not where the user names a package. Of MUMPS' scalings for
  symmetric matrices that by the diagonal costs least. In 2D, below this size, quasi-dense minimum degree (QAMD) beats
  nested dissection, and the last front is too small to be shared out by ScaLAPACK.
*/
#define SMALL_IN_2D 5e4

static PetscErrorCode TuneDirect(MpmModel model, PetscReal unknowns)
{
  const PetscBool small       = (PetscBool)(unknowns < SMALL_IN_2D);
  char            package[64] = "";
  PetscBool       chosen, packaged;

  PetscFunctionBeginUser;
  PetscCall(PetscOptionsHasName(NULL, NULL, "-pc_type", &chosen));
  PetscCall(PetscOptionsHasName(NULL, NULL, "-pc_factor_mat_solver_type", &packaged));
  if (small && model->symmetric && !chosen && !packaged) {
    PetscCall(OptionDefault("-pc_type", "band"));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(OptionDefault("-pc_factor_mat_solver_type", MATSOLVERMUMPS));
  PetscCall(OptionDefault("-pc_type", model->symmetric ? "cholesky" : "lu"));
  PetscCall(PetscOptionsGetString(NULL, NULL, "-pc_factor_mat_solver_type", package, sizeof(package), NULL));
  if (chosen || strcmp(package, MATSOLVERMUMPS)) PetscFunctionReturn(PETSC_SUCCESS);
  if (model->symmetric) PetscCall(OptionDefault("-mat_mumps_icntl_8", "1"));
  if (MpmStabilityWanted(model))
    PetscCall(OptionDefault("-mat_mumps_icntl_13", "1")); /* or not all pivots are counted */
  if (model->grid.dim == 2 && small) {
    PetscCall(OptionDefault("-mat_mumps_icntl_7", "6"));
    PetscCall(OptionDefault("-mat_mumps_icntl_13", "1"));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSolverChoose(MpmModel model)
{
  const char *name     = model->solver;
  PetscReal   unknowns = 0.;
  PetscBool   direct;

  PetscFunctionBeginUser;
  PetscCall(EstimateUnknowns(model, &unknowns));
  if (!strcmp(name, "auto")) PetscCall(ChooseSolver(model, unknowns, &name));
  direct = (PetscBool)!strcmp(name, "direct");
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(presets); k++)
    if (!strcmp(presets[k].name, name)) PetscCall(ApplyPreset(presets[k].text));
  if (name != model->solver) {
    PetscCall(PetscFree(model->solver));
    PetscCall(PetscStrallocpy(name, &model->solver));
  }
  if (direct) PetscCall(TuneDirect(model, unknowns));
  else {
    PetscBool chosen;

    PetscCall(PetscOptionsHasName(NULL, NULL, "-ksp_type", &chosen));
    model->may_be_indefinite = (PetscBool)(model->symmetric && !chosen);
    PetscCall(OptionDefault("-ksp_type", model->symmetric ? "cg" : "gmres"));
    if (!model->symmetric && !chosen) PetscCall(OptionDefault("-ksp_gmres_restart", "100"));
  }
  PetscCall(CreateSNES(model));
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
                                  "3D and 1e5 in 3D with F-bar, then amg "
                                  "(CPU seconds of two steps in 3D, direct and amg: 1.0 and 1.0 at 4 700 unknowns, 2.8 "
                                  "and 2.0 at 9 800, 11.5 and 4.6 at "
                                  "17 000)";

PetscErrorCode MpmSolverSetFromOptions(MpmModel model, const MpmOptions *options)
{
  const char *names[PETSC_STATIC_ARRAY_LENGTH(presets) + 2] = {"auto"};
  PetscInt    choice                                        = 0;

  PetscFunctionBeginUser;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(presets); k++) names[k + 1] = presets[k].name;
  PetscCall(MpmOptionsHeading(options, "Solver"));
  PetscCall(MpmOptionsWord(options, "solver", solver_help, names, MPM_OPTIONAL, &choice, NULL));
  PetscCall(PetscStrallocpy(names[choice], &model->solver));
  PetscCall(ReadType(options, "mat_type", "PETSc type of the Jacobian", MATAIJ, model->mat_type));
  PetscCall(ReadType(options, "vec_type", "PETSc type of the vectors", VECSTANDARD, model->vec_type));
  PetscCall(MpmBandRegister());
  PetscCall(CheckTypes(model));
  model->lag = model->keep_tangents = PETSC_TRUE;
  PetscCall(MpmOptionsBool(options, "newton_lag", "keep a Jacobian where a new one would not pay", &model->lag, NULL));
  PetscCall(MpmOptionsBool(options, "matfree_tangents", "keep the points' tangents for jacobian: matfree",
                           &model->keep_tangents, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Solver, vectors and matrix for a new pattern. GAMG of PETSc 3.18 cannot be reset to another size: all are made anew. */
static PetscErrorCode CreateObjects(MpmModel model)
{
  PetscFunctionBeginUser;
  PetscCall(SNESDestroy(&model->snes));
  PetscCall(CreateSNES(model));
  PetscCall(MatDestroy(&model->jacobian));
  PetscCall(VecDestroy(&model->x));
  PetscCall(VecDestroy(&model->f));
  if (!model->matrix_unused)
    PetscCall(MpmPatternCreateMat(&model->pattern, &model->space, model->comm, model->mat_type, &model->jacobian));
  PetscCall(VecCreate(model->comm, &model->x));
  PetscCall(
    VecSetSizes(model->x, model->space.owned * model->layout.block, model->space.global_count * model->layout.block));
  PetscCall(VecSetBlockSize(model->x, model->layout.block));
  PetscCall(VecSetType(model->x, model->vec_type));
  PetscCall(VecSetFromOptions(model->x));
  PetscCall(VecDuplicate(model->x, &model->f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSolverSetUp(MpmModel model)
{
  PetscBool changed = PETSC_TRUE;

  PetscFunctionBeginUser;
  if (!model->matrix_unused)
    PetscCall(MpmPatternSetUp(&model->pattern, &model->space, model->comm, model->layout.block, &changed));
  if (changed || !model->jacobian) PetscCall(CreateObjects(model));
  PetscCall(MatDestroy(&model->shell));
  if (model->jacobian_type == MPM_JACOBIAN_MATFREE)
    PetscCall(MpmMatfreeCreate(model, model->keep_tangents, &model->shell));
  PetscCall(MpmNewtonSetMats(model));
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

/*
  Rigid body modes for multigrid. Held unknowns do not move, so the modes are zero there; what is left is made
  orthonormal.
*/
PetscErrorCode MpmSolverSetNearNullSpace(MpmModel model)
{
  const PetscInt dim = model->grid.dim, bs = model->layout.block, modes = dim == 2 ? 3 : 6;
  MatNullSpace   space;
  Vec            mode[6];
  PetscScalar    dot[6];
  PetscInt       kept = 0;

  PetscFunctionBeginUser;
  if (!model->jacobian) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MatGetNearNullSpace(model->jacobian, &space));
  if (model->factorises || space) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt k = 0; k < modes; k++) {
    PetscScalar *values;
    PetscReal    norm;

    PetscCall(VecDuplicate(model->x, &mode[kept]));
    PetscCall(VecZeroEntries(mode[kept]));
    PetscCall(VecGetArray(mode[kept], &values));
    for (PetscInt i = 0; i < model->space.owned; i++) {
      PetscReal x[MPM_MAX_DIM] = {0., 0., 0.};

      for (PetscInt a = 0; a < dim; a++) x[a] = model->grid.h[a] * (PetscReal)model->space.node[i * dim + a];
      RigidMode(dim, k, x, &values[i * bs]);
    }
    MpmFramesToUnknowns(&model->constraints, bs, model->space.owned, values);
    for (PetscInt i = 0; i < model->space.owned * bs; i++)
      if (model->constraints.condition[i] >= 0) values[i] = 0.;
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
  PetscCall(MatNullSpaceCreate(model->comm, PETSC_FALSE, kept, mode, &space));
  PetscCall(MatSetNearNullSpace(model->jacobian, space));
  PetscCall(MatNullSpaceDestroy(&space));
  for (PetscInt k = 0; k < kept; k++) PetscCall(VecDestroy(&mode[k]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  After a linear solve has failed: a factorisation that failed must not be used again, and GAMG cannot be reset, so the
  solver is made anew; with GMRES where CG met an indefinite Jacobian.
*/
PetscErrorCode MpmSolverRenew(MpmModel model)
{
  KSP                ksp;
  KSPConvergedReason why;

  PetscFunctionBeginUser;
  PetscCall(SNESGetKSP(model->snes, &ksp));
  PetscCall(KSPGetConvergedReason(ksp, &why));
  if (model->may_be_indefinite && (why == KSP_DIVERGED_INDEFINITE_MAT || why == KSP_DIVERGED_INDEFINITE_PC)) {
    model->may_be_indefinite = PETSC_FALSE;
    model->indefinite        = PETSC_TRUE;
    PetscCall(MpmTerminalNote(model, "the Jacobian is not positive definite; from here on with GMRES"));
  }
  PetscCall(SNESDestroy(&model->snes));
  PetscCall(CreateSNES(model));
  PetscCall(MpmNewtonSetMats(model));
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
static PetscErrorCode RaiseWorkspace(MpmModel model, PetscBool *raised)
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
  PetscCall(SNESGetKSP(model->snes, &ksp));
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
  PetscCall(MpmTerminalNote(model, "MUMPS ran out of its workspace and gets more (" WORKSPACE " %s)", text));
  *raised = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Newton's method from x, once more from where it came to if all that the linear solver lacked was workspace. */
static PetscErrorCode Newton(MpmModel model, SNESConvergedReason *reason)
{
  PetscInt  newton, linear;
  PetscBool again;

  PetscFunctionBeginUser;
  do {
    model->solving = model->ahead = PETSC_TRUE;
    PetscCall(SNESSolve(model->snes, NULL, model->x));
    model->solving = PETSC_FALSE;
    PetscCall(SNESGetConvergedReason(model->snes, reason));
    PetscCall(SNESGetIterationNumber(model->snes, &newton));
    PetscCall(SNESGetLinearSolveIterations(model->snes, &linear));
    model->newton += newton;
    model->linear += linear;
    model->newton_total += newton;
    model->linear_total += linear;
    again = PETSC_FALSE;
    if (*reason == SNES_DIVERGED_LINEAR_SOLVE) {
      PetscCall(RaiseWorkspace(model, &again));
      PetscCall(MpmSolverRenew(model));
    }
  } while (again);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSolverSolve(MpmModel model, SNESConvergedReason *reason)
{
  PetscLogDouble  since, now;
  const PetscReal before = model->seconds[MPM_TIME_RESIDUAL] + model->seconds[MPM_TIME_JACOBIAN];
  PetscReal       inside;

  PetscFunctionBeginUser;
  PetscCall(PetscTime(&since));
  model->made_count = 0;
  PetscCall(Newton(model, reason));
  PetscCall(PetscTime(&now));
  inside = model->seconds[MPM_TIME_RESIDUAL] + model->seconds[MPM_TIME_JACOBIAN] - before;
  model->seconds[MPM_TIME_SOLVE] += now - since - inside;
  model->made_count_last = *reason > 0 ? model->made_count : 0;
  PetscCall(MpmGatherSolution(model, model->x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSolverDestroy(MpmModel model)
{
  PetscFunctionBeginUser;
  PetscCall(SNESDestroy(&model->snes));
  PetscCall(MatDestroy(&model->jacobian));
  PetscCall(MatDestroy(&model->shell));
  PetscCall(VecDestroy(&model->x));
  PetscCall(VecDestroy(&model->f));
  PetscCall(PetscFree(model->solver));
  PetscCall(PetscFree(model->solver_why));
  PetscFunctionReturn(PETSC_SUCCESS);
}

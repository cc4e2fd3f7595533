/*
  Newton and its linear solver: PETSc's SNES and KSP, set up by presets from options/ that any PETSc option overrides.
*/
#include "mpmimpl.h"

/* The presets, embedded by the build from options/: {name, text of the file}. */
static const struct {
  const char *name, *text;
} presets[] = {
#include "mpm_presets.h"
};

/* Sets an option that the user has not set. */
static PetscErrorCode OptionDefault(const char *name, const char *value)
{
  PetscBool set;

  PetscFunctionBeginUser;
  PetscCall(PetscOptionsHasName(NULL, NULL, name, &set));
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

/* ---- residual and Jacobian ---- */

/* Brings the solution vector to the local nodes, ghosts included. */
static PetscErrorCode GatherSolution(MpmModel model, Vec x)
{
  const PetscScalar *values;

  PetscFunctionBeginUser;
  PetscCall(VecGetArrayRead(x, &values));
  PetscCall(PetscArraycpy(model->u, values, model->space.owned * model->layout.block));
  PetscCall(VecRestoreArrayRead(x, &values));
  PetscCall(MpmSpaceToGhosts(&model->space, model->layout.block, model->u));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  f = internal - external force; on held unknowns, diagonal * (u - value). Where a point has no answer f becomes
  infinite and SNES backs off.
*/
static PetscErrorCode FormFunction(SNES snes, Vec x, Vec f, void *ctx)
{
  MpmModel       model = (MpmModel)ctx;
  const PetscInt bs    = model->layout.block;
  PetscScalar   *values;
  PetscLogDouble since;
  PetscInt       failed;

  PetscFunctionBeginUser;
  (void)snes;
  PetscCall(PetscTime(&since));
  PetscCall(GatherSolution(model, x));
  for (PetscInt k = 0; k < model->space.local * bs; k++) model->residual[k] = -model->force[k];
  PetscCall(MpmResidualLocal(&model->sum, model->u, model->residual, &failed));
  PetscCall(MpmSpaceAddToOwners(&model->space, bs, model->residual));
  PetscCall(VecGetArrayWrite(f, &values));
  for (PetscInt k = 0; k < model->space.owned * bs; k++) {
    values[k] = model->constraints.condition[k] < 0 ? model->residual[k]
                                                    : model->diagonal * (model->u[k] - model->constraints.value[k]);
  }
  /* a rank may own no unknown of its failing points: the flag travels apart */
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &failed, 1, MPIU_INT, MPI_MAX, model->comm));
  if (failed && model->space.owned) values[0] = PETSC_INFINITY;
  PetscCall(VecRestoreArrayWrite(f, &values));
  MpmClock(model, MPM_TIME_RESIDUAL, since);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A displacement unknown is weak when its diagonal is below this part of a typical one; it is raised by that part. */
#define WEAK_NODE 1e-3
#define WEAK_LIFT 1e-11

/*
  Nodes that the corner of a single domain touches have more unknowns than the point has strains: a direct solver then
  returns, in modes without energy, whatever rounding gives, and the result depends on the number of ranks. Raising the
  diagonal of weak nodes a little makes these modes zero. Newton's residual is untouched, so what it converges to is.
*/
static PetscErrorCode LiftWeakNodes(MpmModel model, Mat J)
{
  const PetscInt bs = model->layout.block, dim = model->grid.dim;
  Vec            diagonal;
  PetscScalar   *d;

  PetscFunctionBeginUser;
  PetscCall(VecDuplicate(model->x, &diagonal));
  PetscCall(MatGetDiagonal(J, diagonal));
  PetscCall(VecGetArray(diagonal, &d));
  for (PetscInt k = 0; k < model->space.owned * bs; k++) {
    if (k % bs < dim && PetscAbsScalar(d[k]) < WEAK_NODE * model->diagonal) d[k] *= 1. + WEAK_LIFT;
  }
  PetscCall(VecRestoreArray(diagonal, &d));
  PetscCall(MatDiagonalSet(J, diagonal, INSERT_VALUES));
  PetscCall(VecDestroy(&diagonal));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode FormJacobian(SNES snes, Vec x, Mat J, Mat P, void *ctx)
{
  MpmModel       model = (MpmModel)ctx;
  PetscLogDouble since;
  PetscInt       failed;

  PetscFunctionBeginUser;
  (void)snes;
  PetscCall(PetscTime(&since));
  PetscCall(GatherSolution(model, x));
  PetscCall(MpmPatternBegin(&model->pattern, &model->space, P));
  if (model->jacobian_type == MPM_JACOBIAN_LOCAL)
    PetscCall(MpmJacobianLocal(&model->sum, model->u, &model->pattern, &failed));
  else PetscCall(MpmJacobianColoring(&model->sum, model->jacobian_type, model->u, &model->pattern, &failed));
  PetscCall(MpmPatternEnd(&model->pattern, &model->space, &model->constraints, model->diagonal, P));
  if (model->factorises) PetscCall(LiftWeakNodes(model, P));
  if (model->symmetric) PetscCall(MatSetOption(P, MAT_SYMMETRIC, PETSC_TRUE));
  if (J != P) {
    PetscCall(MatAssemblyBegin(J, MAT_FINAL_ASSEMBLY));
    PetscCall(MatAssemblyEnd(J, MAT_FINAL_ASSEMBLY));
  }
  MpmClock(model, MPM_TIME_JACOBIAN, since);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  PETSc's test, and a floor: a residual as small as rounding makes it cannot be reduced. Strains are known to eps and to
  eps |u|/h, the last from the differences of nodal values; times stiffness and a node's share of volume that is eps K
  (h + |u|) a node.
*/
static PetscErrorCode TestConvergence(SNES snes, PetscInt it, PetscReal xnorm, PetscReal snorm, PetscReal fnorm,
                                      SNESConvergedReason *reason, void *ctx)
{
  const MpmModel  model    = (MpmModel)ctx;
  const PetscReal unknowns = (PetscReal)(model->space.global_count * model->layout.block);
  const PetscReal cells    = model->grid.h[0] * PetscSqrtReal(unknowns); /* a cell a node */
  const PetscReal size     = PetscMin(xnorm, 16. * cells); /* a node gone astray must not raise the floor */
  const PetscReal floor    = 2. * PETSC_MACHINE_EPSILON * model->diagonal * (cells + size);

  PetscFunctionBeginUser;
  PetscCall(SNESConvergedDefault(snes, it, xnorm, snorm, fnorm, reason, NULL));
  if (*reason == SNES_CONVERGED_ITERATING && fnorm <= floor) *reason = SNES_CONVERGED_FNORM_ABS;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- line search ---- */

/* a step is too long when it raises both the residual and, this much, the slope's size */
#define LINE_SEARCH_RATIO    2.
#define LINE_SEARCH_TRIALS   8
#define LINE_SEARCH_SHORTEST 0.02

/* Tries X - lambda Y: the residual there, its norm, and the slope G . Y, which is the rate of work for a potential. */
static PetscErrorCode Try(SNESLineSearch search, SNES snes, PetscReal lambda, PetscReal *norm, PetscReal *slope)
{
  Vec         X, F, Y, W, G;
  PetscScalar dot;

  PetscFunctionBeginUser;
  (void)search;
  PetscCall(SNESLineSearchGetVecs(search, &X, &F, &Y, &W, &G));
  PetscCall(VecWAXPY(W, -lambda, Y, X));
  PetscCall(SNESComputeFunction(snes, W, G));
  PetscCall(VecNorm(G, NORM_2, norm));
  *slope = 0.;
  if (PetscIsInfOrNanReal(*norm)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecDot(G, Y, &dot));
  *slope = PetscRealPart(dot);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  The program's own line search: the full step costs one residual and is taken when the residual falls or the slope of
  the work does; otherwise the slope's zero is bracketed by regula falsi. A trial without an answer halves the step.

  A test on the residual alone would throttle bending and rotation, where a good full step raises the residual first.
*/
static PetscErrorCode LineSearch(SNESLineSearch search, void *ctx)
{
  Vec         X, F, Y, W, G;
  SNES        snes;
  PetscReal   xnorm, fnorm, ynorm, norm = 0., slope = 0., lambda = 1., good = 0., slope_good;
  PetscScalar dot;

  PetscFunctionBeginUser;
  (void)ctx;
  PetscCall(SNESLineSearchGetSNES(search, &snes));
  PetscCall(SNESLineSearchGetVecs(search, &X, &F, &Y, &W, &G));
  PetscCall(SNESLineSearchGetNorms(search, &xnorm, &fnorm, &ynorm));
  PetscCall(VecDot(F, Y, &dot));
  const PetscReal start = PetscRealPart(dot);

  slope_good = start;
  for (PetscInt trial = 0;; trial++) {
    PetscCall(Try(search, snes, lambda, &norm, &slope));
    if (PetscIsInfOrNanReal(norm)) {
      if (trial == LINE_SEARCH_TRIALS) {
        PetscCall(SNESLineSearchSetReason(search, SNES_LINESEARCH_FAILED_NANORINF));
        PetscFunctionReturn(PETSC_SUCCESS);
      }
      lambda = 0.5 * (lambda + good);
      continue;
    }
    if (norm <= fnorm || start <= 0. || PetscAbsReal(slope) <= LINE_SEARCH_RATIO * start || trial >= LINE_SEARCH_TRIALS)
      break;
    if (slope > 0.) break; /* still downhill */
    /* overshot: the zero lies between the last good length and this one */
    {
      const PetscReal next = good + (lambda - good) * slope_good / (slope_good - slope);

      if (next < LINE_SEARCH_SHORTEST) break;
      lambda = PetscMin(next, 0.9 * lambda);
    }
  }
  PetscCall(VecNorm(Y, NORM_2, &ynorm));
  PetscCall(VecCopy(W, X));
  PetscCall(VecCopy(G, F));
  PetscCall(VecNorm(X, NORM_2, &xnorm));
  PetscCall(SNESLineSearchSetLambda(search, lambda));
  PetscCall(SNESLineSearchSetNorms(search, xnorm, norm, ynorm));
  PetscCall(SNESLineSearchSetReason(search, SNES_LINESEARCH_SUCCEEDED));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- set-up ---- */

static PetscErrorCode CreateSNES(MpmModel model)
{
  SNESLineSearch search;
  KSP            ksp;
  PC             pc;

  PetscFunctionBeginUser;
  PetscCall(SNESCreate(model->comm, &model->snes));
  PetscCall(SNESSetType(model->snes, SNESNEWTONLS));
  PetscCall(SNESSetTolerances(model->snes, PETSC_DEFAULT, 1e-8, 0., 25, PETSC_DEFAULT));
  PetscCall(SNESSetDivergenceTolerance(model->snes, 1e12));
  PetscCall(SNESGetLineSearch(model->snes, &search));
  PetscCall(SNESLineSearchSetType(search, SNESLINESEARCHSHELL));
  PetscCall(MpmLineSearchShellSet(search, LineSearch, NULL));
  PetscCall(SNESSetConvergenceTest(model->snes, TestConvergence, model, NULL));
  PetscCall(SNESSetFromOptions(model->snes));
  PetscCall(SNESGetKSP(model->snes, &ksp));
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(PetscObjectTypeCompareAny((PetscObject)pc, &model->factorises, PCLU, PCCHOLESKY, ""));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Does PETSc know the type? One of the objects is made and thrown away. */
static PetscErrorCode KnowsType(MpmModel model, const char *kind, const char *type, PetscBool *known)
{
  PetscErrorCode error;
  Mat            mat;
  Vec            vec;
  KSP            ksp;
  PC             pc;

  PetscFunctionBeginUser;
  PetscCall(MatCreate(model->comm, &mat));
  PetscCall(VecCreate(model->comm, &vec));
  PetscCall(VecSetSizes(vec, 1, PETSC_DETERMINE));
  PetscCall(KSPCreate(model->comm, &ksp));
  PetscCall(PCCreate(model->comm, &pc));
  PetscCall(PetscPushErrorHandler(PetscReturnErrorHandler, NULL));
  if (!strcmp(kind, "mpm_mat_type")) error = MatSetType(mat, type);
  else if (!strcmp(kind, "mpm_vec_type")) error = VecSetType(vec, type);
  else if (!strcmp(kind, "ksp_type")) error = KSPSetType(ksp, type);
  else error = PCSetType(pc, type);
  PetscCall(PetscPopErrorHandler());
  *known = (PetscBool)!error;
  PetscCall(MatDestroy(&mat));
  PetscCall(VecDestroy(&vec));
  PetscCall(KSPDestroy(&ksp));
  PetscCall(PCDestroy(&pc));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A type that PETSc does not know must end the run with one line, before anything is written. */
static PetscErrorCode CheckTypes(MpmModel model)
{
  static const char *const kinds[] = {"mpm_mat_type", "mpm_vec_type", "ksp_type", "pc_type"};

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

PetscErrorCode MpmSolverSetFromOptions(MpmModel model, const MpmOptions *options)
{
  const char *names[PETSC_STATIC_ARRAY_LENGTH(presets) + 2] = {"auto"};
  PetscInt    choice                                        = 0;
  size_t      preset                                        = 0;

  PetscFunctionBeginUser;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(presets); k++) names[k + 1] = presets[k].name;
  PetscCall(MpmOptionsWord(options, "solver", "preset of PETSc solver options", names, MPM_OPTIONAL, &choice, NULL));
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(presets); k++) {
    if (choice ? (size_t)choice - 1 == k : !strcmp(presets[k].name, "direct")) preset = k;
  }
  PetscCall(PetscStrallocpy(presets[preset].name, &model->solver));
  PetscCall(ApplyPreset(presets[preset].text));
  /* what a preset cannot know: whether the Jacobian is symmetric */
  if (!strcmp(presets[preset].name, "direct")) {
    PetscCall(OptionDefault("-pc_type", model->symmetric ? "cholesky" : "lu"));
  } else {
    PetscCall(OptionDefault("-ksp_type", model->symmetric ? "cg" : "gmres"));
  }
  if (model->ghost == MPM_GHOST_AUTO) {
    const PetscBool hat    = (PetscBool)(model->shape == MPM_SHAPE_LINEAR || model->shape == MPM_SHAPE_GIMP);
    const PetscBool direct = (PetscBool)!strcmp(presets[preset].name, "direct");

    model->ghost        = hat && !direct ? MPM_GHOST_FACTOR : 0.;
    model->ghost_rescue = (PetscBool)(hat && direct);
  }
  PetscCall(PetscStrncpy(model->mat_type, MATAIJ, sizeof(model->mat_type)));
  PetscCall(PetscStrncpy(model->vec_type, VECSTANDARD, sizeof(model->vec_type)));
  {
    char *type;

    PetscCall(MpmOptionsText(options, "mat_type", "PETSc type of the Jacobian", model->mat_type, MPM_OPTIONAL, &type));
    if (type) PetscCall(PetscStrncpy(model->mat_type, type, sizeof(model->mat_type)));
    PetscCall(PetscFree(type));
    PetscCall(MpmOptionsText(options, "vec_type", "PETSc type of the vectors", model->vec_type, MPM_OPTIONAL, &type));
    if (type) PetscCall(PetscStrncpy(model->vec_type, type, sizeof(model->vec_type)));
    PetscCall(PetscFree(type));
  }
  PetscCall(CheckTypes(model));
  PetscCall(CreateSNES(model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSolverSetUp(MpmModel model)
{
  PetscBool changed;

  PetscFunctionBeginUser;
  PetscCall(MpmPatternSetUp(&model->pattern, &model->space, model->comm, model->layout.block, &changed));
  if (!changed && model->jacobian) PetscFunctionReturn(PETSC_SUCCESS);
  /* GAMG of PETSc 3.18 cannot be reset to another size: a new pattern gets a new solver */
  PetscCall(SNESDestroy(&model->snes));
  PetscCall(CreateSNES(model));
  PetscCall(MatDestroy(&model->jacobian));
  PetscCall(VecDestroy(&model->x));
  PetscCall(VecDestroy(&model->f));
  PetscCall(MpmPatternCreateMat(&model->pattern, &model->space, model->comm, model->mat_type, &model->jacobian));
  PetscCall(VecCreate(model->comm, &model->x));
  PetscCall(
    VecSetSizes(model->x, model->space.owned * model->layout.block, model->space.global_count * model->layout.block));
  PetscCall(VecSetBlockSize(model->x, model->layout.block));
  PetscCall(VecSetType(model->x, model->vec_type));
  PetscCall(VecSetFromOptions(model->x));
  PetscCall(VecDuplicate(model->x, &model->f));
  PetscCall(SNESSetFunction(model->snes, model->f, FormFunction, model));
  PetscCall(SNESSetJacobian(model->snes, model->jacobian, model->jacobian, FormJacobian, model));
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
      for (PetscInt a = 0; a < dim; a++)
        if (model->constraints.condition[i * bs + a] >= 0) values[i * bs + a] = 0.;
    }
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

PetscErrorCode MpmSolverSolve(MpmModel model, SNESConvergedReason *reason)
{
  PetscLogDouble  since, now;
  const PetscReal before = model->seconds[MPM_TIME_RESIDUAL] + model->seconds[MPM_TIME_JACOBIAN];
  PetscReal       inside;

  PetscFunctionBeginUser;
  PetscCall(PetscTime(&since));
  PetscCall(SNESSolve(model->snes, NULL, model->x));
  PetscCall(PetscTime(&now));
  inside = model->seconds[MPM_TIME_RESIDUAL] + model->seconds[MPM_TIME_JACOBIAN] - before;
  model->seconds[MPM_TIME_SOLVE] += now - since - inside;
  PetscCall(SNESGetConvergedReason(model->snes, reason));
  PetscCall(SNESGetIterationNumber(model->snes, &model->newton));
  PetscCall(SNESGetLinearSolveIterations(model->snes, &model->linear));
  model->newton_total += model->newton;
  model->linear_total += model->linear;
  PetscCall(GatherSolution(model, model->x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSolverDestroy(MpmModel model)
{
  PetscFunctionBeginUser;
  PetscCall(SNESDestroy(&model->snes));
  PetscCall(MatDestroy(&model->jacobian));
  PetscCall(VecDestroy(&model->x));
  PetscCall(VecDestroy(&model->f));
  PetscCall(PetscFree(model->solver));
  PetscFunctionReturn(PETSC_SUCCESS);
}

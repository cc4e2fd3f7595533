/*
  PC type `levels`: geometric multigrid for the unknowns on the lattice. Elements of lower order, and coarser lattices,
  lie under the active nodes (level.c); in nested spaces the coarse operator P^T A P is the Jacobian of the coarse shape
  functions at the same points, with all terms and conditions in it. PETSc's PCMG does the cycles: options start with
  -mg_levels_ and -mg_coarse_.

  Interpolation and products stay for as long as the matrix keeps its pattern, and nodes and conditions their places.
*/
#include "levels/pc_levels.h"
#include "grid/shape.h"
#include "grid/grid.h"
#include "point/layout.h"
#include "space/space.h"
#include "bc/bc.h"
#include "assembly/sparsity.h"
#include "levels/level.h"
#include "levels/patches.h"
#include "levels/project.h"

/* Unknowns of a level that a direct solver takes. */
#define COARSEST 3000
/*
  Addition to the coarsest operator's diagonal, as a share of it. Coarse functions may depend on each other at the nodes
  that are solved for, beside rollers at an angle; what the addition leaves of such a combination is zero on the fine
  level.
*/
#define SHIFT 1e-12

static const char shell_name[] = "multigrid on coarser lattices";

typedef struct {
  MpmLevelsChoice  choice;
  MpmLevelsStep    step;
  MpmLevel         finest;  /* of the step whose levels these are */
  PetscObjectId    matrix;  /* matrix of the levels */
  PetscObjectState pattern; /* state of its pattern */
  PC               mg;
  PetscInt         count; /* of coarser levels */
  Mat              P[MPM_LEVELS_MOST], A[MPM_LEVELS_MOST];
  Vec              held[MPM_LEVELS_MOST]; /* diagonal of unknowns that are not solved for */
  PetscBool        shell;                 /* the finest level has no matrix */
  MpmLocalRows     rows;                  /* then: its nodes by those of the next one */
  MpmProjection   *projection;
} Levels;

static PetscErrorCode Reset(Levels *levels)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < levels->count; k++) {
    PetscCall(MatDestroy(&levels->P[k]));
    PetscCall(MatDestroy(&levels->A[k]));
    PetscCall(VecDestroy(&levels->held[k]));
  }
  levels->count = 0;
  PetscCall(MpmProjectionDestroy(&levels->projection));
  PetscCall(MpmLocalRowsDestroy(&levels->rows));
  PetscCall(PCDestroy(&levels->mg));
  PetscCall(MpmLevelDestroy(&levels->finest));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The diagonal of unknowns of a level that are not solved for, otherwise zero. */
static PetscErrorCode MakeHeld(const MpmLevel *level, PetscInt bs, PetscReal diagonal, Mat P, Vec *held)
{
  PetscScalar *value;

  PetscFunctionBeginUser;
  PetscCall(MatCreateVecs(P, held, NULL));
  PetscCall(VecGetArrayWrite(*held, &value));
  for (PetscInt k = 0; k < level->owned * bs; k++) value[k] = level->free[k / bs] >> k % bs & 1 ? 0. : diagonal;
  PetscCall(VecRestoreArrayWrite(*held, &value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Interpolation of all levels; the finest one's nodes stay for comparison. */
static PetscErrorCode MakeLevels(Levels *levels, MPI_Comm comm)
{
  const MpmLevelsStep *step     = &levels->step;
  const PetscInt       bs       = step->components;
  const PetscInt       most     = levels->choice.levels ? levels->choice.levels - 1 : MPM_LEVELS_MOST - 1;
  const PetscInt       last     = levels->choice.orders - 1;
  const PetscBool      elements = (PetscBool)(MpmShapeOrder(levels->choice.shape) > 1);
  const MpmLevelRules  rules    = {.comm    = comm,
                                   .grid    = step->grid,
                                   .block   = bs,
                                   .extra   = step->space->extra.count,
                                   .degree  = elements ? 1 : MpmShapeDegree(levels->choice.shape),
                                   .edge    = levels->choice.edge,
                                   .coarsen = levels->choice.coarsen};
  const MpmFinest      finest   = {step->space, step->constraints, levels->shell ? &levels->rows : NULL};
  MpmLevel             level;

  PetscFunctionBeginUser;
  PetscCall(MpmLevelOfSpace(step->space, step->constraints, step->grid, &levels->finest));
  level = levels->finest;
  for (PetscInt k = 0; k < most; k++) {
    const PetscInt widest = PetscMax(PetscMax(level.last[0], level.last[1]), level.last[2]) / level.order;
    const PetscInt order  = levels->choice.order[PetscMin(k + 1, last)];
    MpmLevel       coarse;

    if (k >= last && (widest < 2 || (k && !levels->choice.levels && level.count * bs <= COARSEST))) break;
    PetscCall(MpmLevelCoarsen(&rules, &level, k ? NULL : &finest, order, &coarse, &levels->P[k]));
    PetscCall(MakeHeld(&coarse, bs, step->constraints->diagonal, levels->P[k], &levels->held[k]));
    if (levels->shell && !k)
      PetscCall(MpmProjectionCreate(&levels->rows, step->space, comm, (const PetscInt[]){coarse.owned, coarse.count},
                                    &levels->projection, &levels->A[0]));
    levels->count++;
    if (k) PetscCall(MpmLevelDestroy(&level));
    level = coarse;
  }
  if (levels->count) PetscCall(MpmLevelDestroy(&level));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* True on all ranks where the levels are those of the matrix, its nodes and conditions. */
static PetscErrorCode Serve(const Levels *levels, Mat A, PetscBool *serve)
{
  const MpmSpace  *space = levels->step.space;
  MpmLevel         now;
  PetscObjectId    matrix;
  PetscObjectState pattern;
  PetscBool        same;

  PetscFunctionBeginUser;
  PetscCall(PetscObjectGetId((PetscObject)A, &matrix));
  PetscCall(MatGetNonzeroState(A, &pattern));
  *serve = (PetscBool)(levels->mg && levels->matrix == matrix && levels->pattern == pattern);
  if (!*serve) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmLevelOfSpace(space, levels->step.constraints, levels->step.grid, &now));
  same = (PetscBool)(now.owned == levels->finest.owned && !levels->step.constraints->frame_of);
  if (same) PetscCall(PetscArraycmp(now.at, levels->finest.at, now.owned * (MPM_MAX_DIM + 1), &same));
  if (same) PetscCall(PetscArraycmp(now.free, levels->finest.free, now.owned, &same));
  PetscCall(MpmLevelDestroy(&now));
  PetscCall(MPIU_Allreduce(&same, serve, 1, MPM_MPI_BOOL, MPI_LAND, PetscObjectComm((PetscObject)A)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* PCMG without operators; it reads the options of its solvers when it is set up. PETSc takes the restriction for an
   interpolation where both levels have as many unknowns, unless it has one of its own. */
static PetscErrorCode CreateCycle(PC pc, Levels *levels)
{
  const char *prefix;

  PetscFunctionBeginUser;
  PetscCall(PCCreate(PetscObjectComm((PetscObject)pc), &levels->mg));
  PetscCall(PCGetOptionsPrefix(pc, &prefix));
  PetscCall(PCSetOptionsPrefix(levels->mg, prefix));
  PetscCall(PCSetType(levels->mg, PCMG));
  PetscCall(PCMGSetLevels(levels->mg, levels->count + 1, NULL));
  PetscCall(PCMGSetGalerkin(levels->mg, PC_MG_GALERKIN_NONE));
  for (PetscInt k = 0; k < levels->count; k++) {
    Mat restriction;

    PetscCall(PCMGSetInterpolation(levels->mg, levels->count - k, levels->P[k]));
    PetscCall(MatCreateTranspose(levels->P[k], &restriction));
    PetscCall(PCMGSetRestriction(levels->mg, levels->count - k, restriction));
    PetscCall(MatDestroy(&restriction));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Shift(Mat A)
{
  Vec diagonal;

  PetscFunctionBeginUser;
  PetscCall(MatCreateVecs(A, &diagonal, NULL));
  PetscCall(MatGetDiagonal(A, diagonal));
  PetscCall(VecScale(diagonal, 1. + SHIFT));
  PetscCall(MatDiagonalSet(A, diagonal, INSERT_VALUES));
  PetscCall(VecDestroy(&diagonal));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The first coarse operator from the points' tangents and from element blocks. */
static PetscErrorCode ProjectFinest(Levels *levels, Mat A)
{
  const MpmElementAction action = {.take = MpmProjectionTake, .ctx = levels->projection};
  const MpmCoarse        coarse = MpmProjectionCoarse(levels->projection);
  const MpmFactored     *factored;
  Vec                    keep;

  PetscFunctionBeginUser;
  PetscCall(MatZeroEntries(levels->A[0]));
  PetscCall(levels->step.tangent(levels->step.ctx, &action, &factored));
  if (factored) PetscCall(MpmFactoredProject(factored, &coarse));
  if (factored && levels->choice.cells) PetscCall(MpmPatchesCompose(&levels->step, factored, A));
  PetscCall(MpmProjectionEnd(levels->projection));
  PetscCall(VecDuplicate(levels->held[0], &keep));
  PetscCall(VecCopy(levels->held[0], keep));
  PetscCall(VecScale(keep, -1. / levels->step.constraints->diagonal));
  PetscCall(VecShift(keep, 1.));
  PetscCall(MatDiagonalScale(levels->A[0], keep, keep));
  PetscCall(VecDestroy(&keep));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Coarse operators P^T A P, and identity where nothing is solved for. */
static PetscErrorCode MakeOperators(Levels *levels, Mat A)
{
  PetscBool symmetric, known;

  PetscFunctionBeginUser;
  PetscCall(MatIsSymmetricKnown(A, &known, &symmetric));
  for (PetscInt k = 0; k < levels->count; k++) {
    Mat fine = k ? levels->A[k - 1] : A;
    KSP smoother;

    if (levels->shell && !k) PetscCall(ProjectFinest(levels, A));
    else
      PetscCall(MatPtAP(fine, levels->P[k], levels->A[k] ? MAT_REUSE_MATRIX : MAT_INITIAL_MATRIX, PETSC_DEFAULT,
                        &levels->A[k]));
    PetscCall(MatDiagonalSet(levels->A[k], levels->held[k], ADD_VALUES));
    if (k == levels->count - 1) PetscCall(Shift(levels->A[k]));
    if (known) PetscCall(MatSetOption(levels->A[k], MAT_SYMMETRIC, symmetric));
    PetscCall(PCMGGetSmoother(levels->mg, levels->count - k - 1, &smoother));
    PetscCall(KSPSetOperators(smoother, levels->A[k], levels->A[k]));
  }
  PetscCall(PCSetOperators(levels->mg, A, A));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SetUp(PC pc)
{
  Levels        *levels;
  Mat            A;
  KSP            smoother;
  PetscBool      serve;
  PCFailedReason reason;

  PetscFunctionBeginUser;
  PetscCall(PCShellGetContext(pc, &levels));
  PetscCall(PCGetOperators(pc, NULL, &A));
  PetscCheck(levels->step.space, PetscObjectComm((PetscObject)pc), PETSC_ERR_ORDER, "PC type levels without a step");
  PetscCall(Serve(levels, A, &serve));
  if (!serve) {
    PetscCall(Reset(levels));
    PetscCall(PetscObjectTypeCompare((PetscObject)A, MATSHELL, &levels->shell));
    PetscCall(MakeLevels(levels, PetscObjectComm((PetscObject)pc)));
    PetscCall(CreateCycle(pc, levels));
    PetscCall(PetscObjectGetId((PetscObject)A, &levels->matrix));
    PetscCall(MatGetNonzeroState(A, &levels->pattern));
  }
  PetscCall(MakeOperators(levels, A));
  PetscCall(PCMGGetSmoother(levels->mg, levels->count, &smoother));
  PetscCall(KSPSetOperators(smoother, A, A));
  PetscCall(PCSetUp(levels->mg));
  PetscCall(PCGetFailedReason(levels->mg, &reason));
  PetscCall(PCSetFailedReason(pc, reason));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Apply(PC pc, Vec f, Vec x)
{
  Levels *levels;

  PetscFunctionBeginUser;
  PetscCall(PCShellGetContext(pc, &levels));
  PetscCall(PCApply(levels->mg, f, x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ApplyTranspose(PC pc, Vec f, Vec x)
{
  Levels *levels;

  PetscFunctionBeginUser;
  PetscCall(PCShellGetContext(pc, &levels));
  PetscCall(PCApplyTranspose(levels->mg, f, x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode View(PC pc, PetscViewer viewer)
{
  Levels *levels;

  PetscFunctionBeginUser;
  PetscCall(PCShellGetContext(pc, &levels));
  if (!levels->mg) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscViewerASCIIPushTab(viewer));
  PetscCall(PCView(levels->mg, viewer));
  PetscCall(PetscViewerASCIIPopTab(viewer));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Destroy(PC pc)
{
  Levels *levels;

  PetscFunctionBeginUser;
  PetscCall(PCShellGetContext(pc, &levels));
  PetscCall(Reset(levels));
  PetscCall(PetscFree(levels));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Create(PC pc)
{
  Levels *levels;

  PetscFunctionBeginUser;
  PetscCall(PetscNew(&levels));
  PetscCall(PCSetType(pc, PCSHELL));
  PetscCall(PCShellSetName(pc, shell_name));
  PetscCall(PCShellSetContext(pc, levels));
  PetscCall(PCShellSetSetUp(pc, SetUp));
  PetscCall(PCShellSetApply(pc, Apply));
  PetscCall(PCShellSetApplyTranspose(pc, ApplyTranspose));
  PetscCall(PCShellSetView(pc, View));
  PetscCall(PCShellSetDestroy(pc, Destroy));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmLevelsRegister(void)
{
  PetscFunctionBeginUser;
  PetscCall(PCRegister("levels", Create));
  PetscCall(MpmPatchesRegister());
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmLevelsIs(PC pc, PetscBool *is)
{
  const char *name = NULL;

  PetscFunctionBeginUser;
  PetscCall(PetscObjectTypeCompare((PetscObject)pc, PCSHELL, is));
  if (*is) PetscCall(PCShellGetName(pc, &name));
  PetscCall(PetscStrcmp(name, shell_name, is));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmLevelsAttach(PC pc, const MpmLevelsChoice *choice, const MpmLevelsStep *step)
{
  Levels   *levels;
  PetscBool is;

  PetscFunctionBeginUser;
  PetscCall(MpmLevelsIs(pc, &is));
  if (!is) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PCShellGetContext(pc, &levels));
  levels->choice = *choice;
  levels->step   = *step;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmLevelsCount(PC pc, PetscInt *count)
{
  Levels   *levels;
  PetscBool is;

  PetscFunctionBeginUser;
  *count = 0;
  PetscCall(MpmLevelsIs(pc, &is));
  if (!is) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PCShellGetContext(pc, &levels));
  if (levels->mg) *count = levels->count + 1;
  PetscFunctionReturn(PETSC_SUCCESS);
}

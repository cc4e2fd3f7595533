/*
  PC type `band`: a direct solver for symmetric positive definite matrices that are narrow once they are ordered well,
  as those of beams, columns and slopes on few ranks are. LAPACK's band Cholesky has less to do there than a
  multifrontal solver has to administer.

  A rank's unknowns that have neighbours on a higher rank are its border; without the borders the ranks' matrices A_r do
  not touch each other. With G the border's unknowns of all ranks, B_r = A_rG and A_r = L_r L_r^T

    W_r = L_r^{-1} B_r ,   S = A_GG - sum_r W_r^T W_r ,

  each rank factorises its band and all of them the small dense S, which is summed by MPI. The order starts at nodes
  that touch the border, which thus come last: W_r is zero but in its last rows.

  Where the band or the border is too wide, or the matrix is not positive definite, Cholesky by MUMPS takes over. Needs
  an AIJ matrix that is symmetric, of which it reads one triangle.

  Sources: Cuthill and McKee (1969), doi:10.1145/800195.805928; Przemieniecki (1963), substructures, AIAA J. 1, 138-147.
*/
#include "precondition/pc_band.h"
#include <petscblaslapack.h>

#define LAPACKpbtrf_ PETSCBLAS(pbtrf, PBTRF)
#define LAPACKtbtrs_ PETSCBLAS(tbtrs, TBTRS)
#define BLAStbsv_    PETSCBLAS(tbsv, TBSV)
BLAS_EXTERN void LAPACKpbtrf_(const char *, const PetscBLASInt *, const PetscBLASInt *, PetscScalar *,
                              const PetscBLASInt *, PetscBLASInt *);
BLAS_EXTERN void LAPACKtbtrs_(const char *, const char *, const char *, const PetscBLASInt *, const PetscBLASInt *,
                              const PetscBLASInt *, const PetscScalar *, const PetscBLASInt *, PetscScalar *,
                              const PetscBLASInt *, PetscBLASInt *);
BLAS_EXTERN void BLAStbsv_(const char *, const char *, const char *, const PetscBLASInt *, const PetscBLASInt *,
                           const PetscScalar *, const PetscBLASInt *, PetscScalar *, const PetscBLASInt *);

static const char shell_name[] = "band Cholesky by LAPACK";

typedef struct {
  MpmBandOrder     order;
  PetscObjectId    matrix;  /* matrix of the order */
  PetscObjectState pattern; /* state of its pattern */
  PetscScalar     *value;   /* band, border, corner, and one more: of the ranks' factors, how many failed */
  PetscScalar     *work;    /* a right-hand side in the band's order, and that of the border */
  PC               whole;   /* the substitute, once needed */
  PetscBool        taken;   /* the substitute serves for the present matrix */
} Band;

static PetscErrorCode Reset(Band *band)
{
  PetscFunctionBeginUser;
  PetscCall(PCDestroy(&band->whole));
  PetscCall(PetscFree2(band->value, band->work));
  PetscCall(MpmBandOrderDestroy(&band->order));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- factors ---- */

/* The entries go to their places. */
static PetscErrorCode Fill(Band *band, Mat A)
{
  const MpmBandOrder *order = &band->order;
  const PetscScalar  *a;
  Mat                 part[2];

  PetscFunctionBeginUser;
  PetscCall(PetscArrayzero(band->value, order->size + 1));
  PetscCall(MpmBandParts(A, part, NULL));
  for (PetscInt k = 0; k < 2; k++) {
    if (!part[k]) continue;
    PetscCall(MatSeqAIJGetArrayRead(part[k], &a));
    for (PetscInt e = 0; e < order->entries[k]; e++)
      if (order->to[k][e] >= 0) band->value[order->to[k][e]] = a[e];
    PetscCall(MatSeqAIJRestoreArrayRead(part[k], &a));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* band = L, border = W, corner = -W^T W added to A_GG; the number of the first pivot that is not positive, or 0 */
static PetscErrorCode FactorBand(Band *band, PetscBLASInt *info)
{
  const MpmBandOrder *order = &band->order;
  const PetscScalar   one = 1., minus = -1.;
  PetscScalar        *border = &band->value[order->border], *corner = &band->value[order->corner];
  PetscBLASInt        n, width, stride, rows, count;

  PetscFunctionBeginUser;
  PetscCall(PetscBLASIntCast(order->n, &n));
  PetscCall(PetscBLASIntCast(order->width, &width));
  PetscCall(PetscBLASIntCast(order->n - order->first, &rows));
  PetscCall(PetscBLASIntCast(order->count, &count));
  stride = width + 1;
  PetscCallBLAS("LAPACKpbtrf", LAPACKpbtrf_("L", &n, &width, band->value, &stride, info));
  if (*info || !rows || !count) PetscFunctionReturn(PETSC_SUCCESS);
  if (rows <= width) { /* these columns of the band are a full triangle, each one further down by 1 */
    PetscCallBLAS("BLAStrsm", BLAStrsm_("L", "L", "N", "N", &rows, &count, &one, &band->value[order->first * stride],
                                        &width, border, &rows));
  } else {
    PetscCallBLAS("LAPACKtbtrs", LAPACKtbtrs_("L", "N", "N", &rows, &width, &count, &band->value[order->first * stride],
                                              &stride, border, &rows, info));
  }
  PetscCallBLAS("BLASsyrk", BLASsyrk_("L", "T", &count, &rows, &minus, border, &rows, &one, corner, &count));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Factor(PC pc, Band *band, Mat A, PetscBool *positive)
{
  const MpmBandOrder *order  = &band->order;
  PetscScalar        *corner = &band->value[order->corner];
  PetscBLASInt        info   = 0, count;
  PetscMPIInt         most;

  PetscFunctionBeginUser;
  PetscCall(Fill(band, A));
  PetscCall(FactorBand(band, &info));
  band->value[order->size] = info ? 1. : 0.;
  PetscCall(PetscMPIIntCast(order->count * order->count + 1, &most));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, corner, most, MPIU_SCALAR, MPIU_SUM, PetscObjectComm((PetscObject)pc)));
  PetscCall(PetscBLASIntCast(order->count, &count));
  if (count && band->value[order->size] == 0.)
    PetscCallBLAS("LAPACKpotrf", LAPACKpotrf_("L", &count, corner, &count, &info));
  *positive = (PetscBool)(band->value[order->size] == 0. && !info); /* S is the same on all ranks */
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A failed factor of MUMPS: PETSc takes no other matrix into it, and solves with it all the same: INFOG(1) = -3. */
static PetscErrorCode DestroyFailed(PC *whole)
{
  PCFailedReason reason;

  PetscFunctionBeginUser;
  if (!*whole) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PCGetFailedReason(*whole, &reason));
  if (reason != PC_NOERROR) PetscCall(PCDestroy(whole));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* MUMPS, for this matrix, tuned for small ones as solver.c has it. */
static PetscErrorCode TakeWhole(PC pc, Band *band, Mat A)
{
  PCFailedReason reason;
  PetscInt       bs;
  Mat            factor;

  PetscFunctionBeginUser;
  PetscCall(DestroyFailed(&band->whole));
  if (!band->whole) {
    PetscCall(PCCreate(PetscObjectComm((PetscObject)pc), &band->whole));
    PetscCall(PCSetType(band->whole, PCCHOLESKY));
    PetscCall(PCFactorSetMatSolverType(band->whole, MATSOLVERMUMPS));
    PetscCall(PCSetErrorIfFailure(band->whole, PETSC_FALSE));
    PetscCall(PCSetOperators(band->whole, A, A));
    PetscCall(PCFactorSetUpMatSolverType(band->whole));
    PetscCall(PCFactorGetMatrix(band->whole, &factor));
    PetscCall(MatGetBlockSize(A, &bs));
    PetscCall(MatMumpsSetIcntl(factor, 8, 1));
    PetscCall(MatMumpsSetIcntl(factor, 13, 1));
    if (bs == 2) PetscCall(MatMumpsSetIcntl(factor, 7, 6));
  }
  PetscCall(PCSetOperators(band->whole, A, A));
  PetscCall(PCSetUp(band->whole));
  PetscCall(PCGetFailedReason(band->whole, &reason));
  PetscCall(PCSetFailedReason(pc, reason));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SetUp(PC pc)
{
  Band            *band;
  Mat              A;
  PetscObjectId    matrix;
  PetscObjectState pattern;
  PetscBool        positive = PETSC_FALSE;

  PetscFunctionBeginUser;
  PetscCall(PCShellGetContext(pc, &band));
  PetscCall(PCGetOperators(pc, NULL, &A));
  PetscCall(PetscObjectGetId((PetscObject)A, &matrix));
  PetscCall(MatGetNonzeroState(A, &pattern));
  if (matrix != band->matrix || pattern != band->pattern) {
    PetscCall(Reset(band));
    PetscCall(MpmBandOrderCreate(A, &band->order));
    band->matrix  = matrix;
    band->pattern = pattern;
    if (band->order.fits)
      PetscCall(PetscMalloc2((band->order.size + 1), &band->value, (band->order.n + band->order.count), &band->work));
  }
  if (band->order.fits) PetscCall(Factor(pc, band, A, &positive));
  band->taken = (PetscBool)!positive;
  if (band->taken) PetscCall(TakeWhole(pc, band, A));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- solve ---- */

/* In the band's order: y = L^{-1} f, g = f_G - W^T y, x_G = S^{-1} g, x = L^{-T} (y - W x_G). */
static PetscErrorCode Solve(PC pc, Band *band)
{
  const MpmBandOrder *order = &band->order;
  const PetscScalar   one = 1., minus = -1.;
  PetscScalar        *y = band->work, *g = &band->work[order->n], *last = &y[order->first];
  PetscScalar        *border = &band->value[order->border], *corner = &band->value[order->corner];
  PetscBLASInt        n, width, stride, rows, count, unit = 1, info;
  PetscMPIInt         most;

  PetscFunctionBeginUser;
  PetscCall(PetscBLASIntCast(order->n, &n));
  PetscCall(PetscBLASIntCast(order->width, &width));
  PetscCall(PetscBLASIntCast(order->n - order->first, &rows));
  PetscCall(PetscBLASIntCast(order->count, &count));
  PetscCall(PetscMPIIntCast(order->count, &most));
  stride = width + 1;
  PetscCallBLAS("BLAStbsv", BLAStbsv_("L", "N", "N", &n, &width, band->value, &stride, y, &unit));
  if (count) {
    if (rows)
      PetscCallBLAS("BLASgemv", BLASgemv_("T", &rows, &count, &minus, border, &rows, last, &unit, &one, g, &unit));
    PetscCall(MPIU_Allreduce(MPI_IN_PLACE, g, most, MPIU_SCALAR, MPIU_SUM, PetscObjectComm((PetscObject)pc)));
    PetscCallBLAS("LAPACKpotrs", LAPACKpotrs_("L", &count, &unit, corner, &count, g, &count, &info));
    if (rows)
      PetscCallBLAS("BLASgemv", BLASgemv_("N", &rows, &count, &minus, border, &rows, g, &unit, &one, last, &unit));
  }
  PetscCallBLAS("BLAStbsv", BLAStbsv_("L", "T", "N", &n, &width, band->value, &stride, y, &unit));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Apply(PC pc, Vec f, Vec x)
{
  Band              *band;
  const PetscScalar *from;
  PetscScalar       *to;

  PetscFunctionBeginUser;
  PetscCall(PCShellGetContext(pc, &band));
  if (band->taken) {
    PetscCall(PCApply(band->whole, f, x));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(PetscArrayzero(&band->work[band->order.n], band->order.count));
  PetscCall(VecGetArrayRead(f, &from));
  for (PetscInt i = 0; i < band->order.owned; i++) band->work[band->order.place[i]] = from[i];
  PetscCall(VecRestoreArrayRead(f, &from));
  PetscCall(Solve(pc, band));
  PetscCall(VecGetArrayWrite(x, &to));
  for (PetscInt i = 0; i < band->order.owned; i++) to[i] = band->work[band->order.place[i]];
  PetscCall(VecRestoreArrayWrite(x, &to));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the type ---- */

static PetscErrorCode View(PC pc, PetscViewer viewer)
{
  Band *band;

  PetscFunctionBeginUser;
  PetscCall(PCShellGetContext(pc, &band));
  if (band->order.fits && !band->taken) {
    PetscCall(PetscViewerASCIIPrintf(viewer,
                                     "  half bandwidth %" PetscInt_FMT ", %" PetscInt_FMT " unknowns of borders\n",
                                     band->order.width, band->order.count));
  } else if (band->taken) {
    PetscCall(PetscViewerASCIIPrintf(viewer, "  too wide, or not positive definite; taken over by:\n"));
    PetscCall(PetscViewerASCIIPushTab(viewer));
    PetscCall(PCView(band->whole, viewer));
    PetscCall(PetscViewerASCIIPopTab(viewer));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Destroy(PC pc)
{
  Band *band;

  PetscFunctionBeginUser;
  PetscCall(PCShellGetContext(pc, &band));
  PetscCall(Reset(band));
  PetscCall(PetscFree(band));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Create(PC pc)
{
  Band *band;

  PetscFunctionBeginUser;
  PetscCall(PetscNew(&band));
  PetscCall(PCSetType(pc, PCSHELL));
  PetscCall(PCShellSetName(pc, shell_name));
  PetscCall(PCShellSetContext(pc, band));
  PetscCall(PCShellSetSetUp(pc, SetUp));
  PetscCall(PCShellSetApply(pc, Apply));
  PetscCall(PCShellSetApplyTranspose(pc, Apply)); /* of symmetric matrices alone */
  PetscCall(PCShellSetView(pc, View));
  PetscCall(PCShellSetDestroy(pc, Destroy));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmBandRegister(void)
{
  PetscFunctionBeginUser;
  PetscCall(PCRegister("band", Create));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmBandIs(PC pc, PetscBool *is)
{
  const char *name = NULL;

  PetscFunctionBeginUser;
  PetscCall(PetscObjectTypeCompare((PetscObject)pc, PCSHELL, is));
  if (*is) PetscCall(PCShellGetName(pc, &name));
  PetscCall(PetscStrcmp(name, shell_name, is));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmBandGetWhole(PC pc, PC *whole)
{
  Band *band;

  PetscFunctionBeginUser;
  PetscCall(PCShellGetContext(pc, &band));
  *whole = band->taken ? band->whole : NULL;
  PetscFunctionReturn(PETSC_SUCCESS);
}

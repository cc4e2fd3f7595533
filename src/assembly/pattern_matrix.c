/*
  The matrix of a pattern: its creation, and the values on their way into it.

  Rows whose columns all belong to this rank are written directly into PETSc's AIJ storage. Others are kept in a buffer:
  owned ones are copied, rows of ghosts go to their owners through the matrix's stash. Matrices of other types than
  PETSc's own on the host (those of GPUs, hypre's) get all rows, ghosts' too, as one list of coordinates and values.
*/
#include "space/space.h"
#include "bc/bc.h"
#include "assembly/sparsity.h"
#include "assembly/sparsity_impl.h"

/* True where values are passed as coordinates: not for types on the host that take blocks of values, or lend their
   arrays. */
static PetscErrorCode TakesCoordinates(Mat mat, PetscBool *takes)
{
  PetscBool host;

  PetscFunctionBeginUser;
  PetscCall(PetscObjectTypeCompareAny((PetscObject)mat, &host, MATSEQAIJ, MATMPIAIJ, MATSEQBAIJ, MATMPIBAIJ,
                                      MATSEQSBAIJ, MATMPISBAIJ, MATSEQDENSE, MATMPIDENSE, MATSEQAIJMKL, MATMPIAIJMKL,
                                      MATSEQAIJPERM, MATMPIAIJPERM, MATSEQAIJSELL, MATMPIAIJSELL, ""));
  *takes = (PetscBool)!host;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Row and column of every value of the buffer when it holds all rows. */
static PetscErrorCode ListCoordinates(const MpmPattern *pattern, const MpmSpace *space, Mat mat)
{
  const PetscInt bs    = pattern->block;
  PetscCount     count = (PetscCount)pattern->row[pattern->local] * bs * bs, fill = 0;
  PetscInt      *i, *j;
  PetscBool      has;
  Mat            diagonal;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc2((size_t)count, &i, (size_t)count, &j));
  for (PetscInt node = 0; node < pattern->local; node++) {
    for (PetscInt c = 0; c < bs; c++) {
      for (PetscInt k = pattern->row[node] * bs; k < pattern->row[node + 1] * bs; k++) {
        i[fill]   = space->number.global[node] * bs + c;
        j[fill++] = pattern->column[k / bs] * bs + k % bs;
      }
    }
  }
  PetscCall(MatSetPreallocationCOO(mat, count, i, j));
  PetscCall(PetscFree2(i, j));
  PetscCall(MatHasOperation(mat, MATOP_GET_DIAGONAL_BLOCK, &has));
  if (has) { /* MPIAIJ makes that matrix again and forgets its blocks, which point-block preconditioners need */
    PetscCall(MatGetDiagonalBlock(mat, &diagonal));
    PetscCall(MatSetBlockSize(diagonal, bs));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPatternCreateMat(MpmPattern *pattern, const MpmSpace *space, MPI_Comm comm, MatType type, Mat *mat)
{
  const PetscInt bs = pattern->block, rows = pattern->owned * bs;
  PetscInt      *i, *j, fill = 0;

  PetscFunctionBeginUser;
  PetscCall(MatCreate(comm, mat));
  PetscCall(MatSetSizes(*mat, rows, rows, space->number.count * bs, space->number.count * bs));
  PetscCall(MatSetBlockSize(*mat, bs));
  PetscCall(MatSetType(*mat, type));
  PetscCall(MatSetFromOptions(*mat));
  PetscCall(TakesCoordinates(*mat, &pattern->coordinates));
  if (pattern->coordinates) {
    PetscCall(ListCoordinates(pattern, space, *mat));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(PetscMalloc1((rows + 1), &i));
  PetscCall(PetscMalloc1((pattern->row[pattern->owned] * bs * bs), &j));
  i[0] = 0;
  for (PetscInt node = 0; node < pattern->owned; node++) {
    for (PetscInt c = 0; c < bs; c++) {
      for (PetscInt k = pattern->row[node]; k < pattern->row[node + 1]; k++)
        for (PetscInt d = 0; d < bs; d++) j[fill++] = pattern->column[k] * bs + d;
      i[node * bs + c + 1] = fill;
    }
  }
  /* only the routine of the matrix's own type acts */
  PetscCall(MatSeqAIJSetPreallocationCSR(*mat, i, j, NULL));
  PetscCall(MatMPIAIJSetPreallocationCSR(*mat, i, j, NULL));
  PetscCall(MatSeqBAIJSetPreallocationCSR(*mat, bs, pattern->row, pattern->column, NULL));
  PetscCall(MatMPIBAIJSetPreallocationCSR(*mat, bs, pattern->row, pattern->column, NULL));
  PetscCall(MatSetUp(*mat));
  PetscCall(PetscFree(i));
  PetscCall(PetscFree(j));
  PetscCall(MatSetOption(*mat, MAT_NEW_NONZERO_LOCATION_ERR, PETSC_TRUE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* True where all columns of an owned row are this rank's own; columns stand in ascending order. */
static PetscBool IsInside(const MpmPattern *pattern, const MpmSpace *space, PetscInt row)
{
  const PetscInt begin = space->number.begin, end = begin + space->owned;

  if (row >= pattern->owned) return PETSC_FALSE;
  return (PetscBool)(pattern->column[pattern->row[row]] >= begin && pattern->column[pattern->row[row + 1] - 1] < end);
}

/* The part of a (MPI)AIJ matrix with this rank's columns, or NULL for other types. */
static PetscErrorCode OwnPart(Mat mat, PetscBool coordinates, Mat *own, Mat *other)
{
  PetscBool seqaij, mpiaij;

  PetscFunctionBeginUser;
  PetscCall(PetscObjectBaseTypeCompare((PetscObject)mat, MATSEQAIJ, &seqaij));
  PetscCall(PetscObjectBaseTypeCompare((PetscObject)mat, MATMPIAIJ, &mpiaij));
  *own = *other = NULL;
  if (coordinates) PetscFunctionReturn(PETSC_SUCCESS);
  if (seqaij) *own = mat;
  else if (mpiaij) PetscCall(MatMPIAIJGetSeqAIJ(mat, own, other, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPatternBegin(MpmPattern *pattern, const MpmSpace *space, const MpmConstraints *constraints, Mat mat)
{
  const PetscInt bs   = pattern->block;
  PetscInt64     size = 0, at = 0;
  Mat            own, other;

  PetscFunctionBeginUser;
  PetscCall(OwnPart(mat, pattern->coordinates, &own, &other));
  if (!pattern->coordinates) PetscCall(MatZeroEntries(mat));
  pattern->constraints = constraints;
  pattern->array       = NULL;
  if (own) PetscCall(MatSeqAIJGetArray(own, &pattern->array));
  for (PetscInt pass = 0; pass < 2; pass++) {
    at = size = 0;
    for (PetscInt i = 0; i < pattern->local; i++) {
      const PetscInt64 values = (PetscInt64)(pattern->row[i + 1] - pattern->row[i]) * bs * bs;
      const PetscBool  inside = (PetscBool)(own && IsInside(pattern, space, i));

      if (pass) pattern->value[i] = inside ? pattern->array + at : pattern->buffer + size;
      if (!inside) size += values;
      if (inside) at += values;
      else if (own && i < pattern->owned) { /* part of it stands in the own part too */
        for (PetscInt k = pattern->row[i]; k < pattern->row[i + 1]; k++) {
          const PetscInt column = pattern->column[k] - space->number.begin;

          if (column >= 0 && column < space->owned) at += bs * bs;
        }
      }
    }
    if (!pass && size > pattern->buffer_size) {
      PetscCall(PetscFree(pattern->buffer));
      PetscCall(PetscMalloc1(size, &pattern->buffer));
      pattern->buffer_size = size;
    }
  }
  PetscCall(PetscArrayzero(pattern->buffer, size));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Copies the owned rows of the buffer to where they stand in the two parts of an MPIAIJ matrix. */
static PetscErrorCode CopyBuffer(const MpmPattern *pattern, const MpmSpace *space, Mat other)
{
  const PetscInt bs = pattern->block, begin = space->number.begin, end = begin + space->owned;
  PetscScalar   *to_a = pattern->array, *b = NULL, *to_b;

  PetscFunctionBeginUser;
  if (other) PetscCall(MatSeqAIJGetArrayWrite(other, &b));
  to_b = b;
  for (PetscInt i = 0; i < pattern->owned; i++) {
    const PetscInt  *column = &pattern->column[pattern->row[i]], count = pattern->row[i + 1] - pattern->row[i];
    const PetscReal *value = pattern->value[i];
    PetscInt         lower = 0, upper = count;

    if (IsInside(pattern, space, i)) {
      to_a += (PetscInt64)count * bs * bs;
      continue;
    }
    while (lower < count && column[lower] < begin) lower++;
    while (upper > lower && column[upper - 1] >= end) upper--;
    for (PetscInt c = 0; c < bs; c++, value += count * bs) {
      PetscCall(PetscArraycpy(to_a, value + lower * bs, (upper - lower) * bs));
      PetscCall(PetscArraycpy(to_b, value, lower * bs));
      PetscCall(PetscArraycpy(to_b + lower * bs, value + upper * bs, (count - upper) * bs));
      to_a += (upper - lower) * bs;
      to_b += (count - upper + lower) * bs;
    }
  }
  if (other) PetscCall(MatSeqAIJRestoreArrayWrite(other, &b));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds rows [first, last) through MatSetValues. */
static PetscErrorCode AddRows(const MpmPattern *pattern, const MpmSpace *space, PetscInt first, PetscInt last, Mat mat)
{
  const PetscInt bs = pattern->block;
  PetscInt      *columns, widest = 0;

  PetscFunctionBeginUser;
  for (PetscInt i = first; i < last; i++) widest = PetscMax(widest, pattern->row[i + 1] - pattern->row[i]);
  PetscCall(PetscMalloc1((widest * bs), &columns));
  for (PetscInt i = first; i < last; i++) {
    const PetscInt count = pattern->row[i + 1] - pattern->row[i];
    PetscInt       rows[MPM_MAX_BLOCK];

    for (PetscInt c = 0; c < bs; c++) rows[c] = space->number.global[i] * bs + c;
    for (PetscInt k = 0; k < count * bs; k++) columns[k] = pattern->column[pattern->row[i] + k / bs] * bs + k % bs;
    PetscCall(MatSetValues(mat, bs, rows, count * bs, columns, pattern->value[i], ADD_VALUES));
  }
  PetscCall(PetscFree(columns));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The diagonal of owned constrained rows. */
static void SetConstrainedDiagonal(MpmPattern *pattern, const MpmConstraints *constraints)
{
  const PetscInt bs = pattern->block;

  for (PetscInt k = 0; constraints->any && k < pattern->owned * bs; k++) {
    const PetscInt i = k / bs, c = k % bs, count = pattern->row[i + 1] - pattern->row[i];

    if (MpmConstraintsFree(constraints, k)) continue;
    pattern->value[i][(c * count + pattern->slot[i * pattern->window + (pattern->window - 1) / 2]) * bs + c] =
      constraints->diagonal;
  }
}

PetscErrorCode MpmPatternEnd(MpmPattern *pattern, const MpmSpace *space, Mat mat)
{
  Mat own, other;

  PetscFunctionBeginUser;
  MpmPatternEliminate(pattern, space);
  for (PetscInt i = 0; i < pattern->local && pattern->constraints->scaled; i++)
    MpmUnitsTimesRows(pattern->constraints, pattern->row[i + 1] - pattern->row[i], pattern->value[i]);
  SetConstrainedDiagonal(pattern, pattern->constraints);
  PetscCall(OwnPart(mat, pattern->coordinates, &own, &other));
  if (own) {
    PetscCall(CopyBuffer(pattern, space, other));
    PetscCall(MatSeqAIJRestoreArray(own, &pattern->array));
  }
  if (pattern->coordinates) {
    PetscCall(MatSetValuesCOO(mat, pattern->buffer, INSERT_VALUES));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(AddRows(pattern, space, own ? pattern->owned : 0, pattern->local, mat));
  PetscCall(MatAssemblyBegin(mat, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(mat, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Marks: how a results file is rolled back.

  A run that is killed while it appends to an HDF5 file may leave it inconsistent, in the structures that states written
  long ago share: the list of groups. The points' numbers themselves are written once and never again. A mark therefore
  holds the file's length and all of its bytes but those numbers. To roll back is to write these bytes again and to cut
  the file to that length: the disk then has the old file, byte for byte.

  A mark in memory: the number of pieces, the file's length, a hash of some of the points' numbers (to detect another
  file); for each piece its place and length; then the pieces' bytes.
*/
#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#include "base/outcome.h"
#include "base/base.h"
#include "files/hdf5_rows.h"
#include "io/io.h"

typedef struct {
  PetscInt64 offset, length;
} Piece;

typedef struct {
  size_t count, capacity;
  Piece *piece;
} Pieces;

static int AddPiece(Pieces *pieces, PetscInt64 offset, PetscInt64 length)
{
  if (pieces->count == pieces->capacity) {
    const size_t capacity = 2 * pieces->capacity + 64;
    Piece       *piece    = (Piece *)realloc(pieces->piece, capacity * sizeof(Piece));

    if (!piece) return -1;
    pieces->piece    = piece;
    pieces->capacity = capacity;
  }
  pieces->piece[pieces->count++] = (Piece){offset, length};
  return 0;
}

/* Adds where a dataset's numbers stand. Those of a layout that is not contiguous count as the file's own. */
static herr_t VisitObject(hid_t file, const char *name, const H5O_info_t *info, void *ctx)
{
  herr_t status = 0;
  hid_t  dataset;

  if (info->type != H5O_TYPE_DATASET) return 0;
  dataset = H5Dopen2(file, name, H5P_DEFAULT);
  if (dataset < 0) return -1;
  {
    const haddr_t offset = H5Dget_offset(dataset);
    const hsize_t size   = H5Dget_storage_size(dataset);

    if (offset != HADDR_UNDEF && size) status = AddPiece((Pieces *)ctx, (PetscInt64)offset, (PetscInt64)size);
  }
  (void)H5Dclose(dataset);
  return status;
}

static int ComparePieces(const void *a, const void *b)
{
  const PetscInt64 one = ((const Piece *)a)->offset, other = ((const Piece *)b)->offset;

  return one < other ? -1 : one > other;
}

/* Where the numbers of all datasets stand, in the file's order; false where HDF5 cannot read the file. */
static PetscBool FindNumbers(const char *path, Pieces *numbers)
{
  herr_t status = -1;
  hid_t  file;

  H5E_auto2_t report;
  void       *context;

  (void)H5Eget_auto2(H5E_DEFAULT, &report, &context);
  (void)H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
  file = MpmHdf5Open(path);
  if (file >= 0) {
#if H5_VERSION_GE(1, 12, 0)
    status = H5Ovisit3(file, H5_INDEX_NAME, H5_ITER_NATIVE, (H5O_iterate2_t)VisitObject, numbers, H5O_INFO_BASIC);
#else
    status = H5Ovisit2(file, H5_INDEX_NAME, H5_ITER_NATIVE, VisitObject, numbers, H5O_INFO_BASIC);
#endif
    (void)H5Fclose(file);
  }
  (void)H5Eset_auto2(H5E_DEFAULT, report, context);
  if (numbers->count) qsort(numbers->piece, numbers->count, sizeof(Piece), ComparePieces);
  return (PetscBool)(status >= 0);
}

/* Bytes between the numbers. */
static int Complement(const Pieces *numbers, PetscInt64 length, Pieces *rest)
{
  PetscInt64 end = 0;

  for (size_t k = 0; k < numbers->count; k++) {
    const Piece *piece = &numbers->piece[k];

    if (piece->offset > end && AddPiece(rest, end, piece->offset - end)) return -1;
    end = PetscMax(end, piece->offset + piece->length);
  }
  return length > end ? AddPiece(rest, end, length - end) : 0;
}

#define SAMPLE_PIECES 16
#define SAMPLE_BYTES  4096

/* A hash of the beginnings of the last gaps between the pieces, which is where the numbers of the last state are. */
static int Sample(int file, size_t count, const Piece piece[], PetscInt64 *hash)
{
  uint64_t sum = 0;

  for (size_t k = count > SAMPLE_PIECES ? count - SAMPLE_PIECES : 0; k + 1 < count; k++) {
    const PetscInt64 begin = piece[k].offset + piece[k].length, gap = piece[k + 1].offset - begin;
    char             bytes[SAMPLE_BYTES];
    const size_t     size = (size_t)PetscMin(gap, SAMPLE_BYTES);

    if (MpmReadAt(file, bytes, size, begin)) return -1;
    sum += MpmHashBytes(bytes, size, (uint64_t)begin);
  }
  *hash = (PetscInt64)sum;
  return 0;
}

static PetscErrorCode AppendBytes(MpmTextFile *mark, const void *bytes, size_t length)
{
  PetscFunctionBeginUser;
  PetscCall(MpmTextFileReserve(mark, length));
  memcpy(mark->data + mark->length, bytes, length);
  mark->length += length;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Head, places and bytes of the pieces; `failure` is errno where the file could not be read. */
static PetscErrorCode CollectPieces(int file, PetscInt64 length, const Pieces *rest, MpmTextFile *mark, int *failure)
{
  PetscInt64 head[3] = {(PetscInt64)rest->count, length, 0};

  PetscFunctionBeginUser;
  errno = 0;
  if (Sample(file, rest->count, rest->piece, &head[2])) *failure = errno ? errno : EIO;
  PetscCall(AppendBytes(mark, head, sizeof(head)));
  PetscCall(AppendBytes(mark, rest->piece, rest->count * sizeof(Piece)));
  for (size_t k = 0; k < rest->count && !*failure; k++) {
    const size_t size = (size_t)rest->piece[k].length;

    PetscCall(MpmTextFileReserve(mark, size));
    errno = 0;
    if (MpmReadAt(file, mark->data + mark->length, size, rest->piece[k].offset)) *failure = errno ? errno : EIO;
    else mark->length += size;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The mark of a file that is there, on rank 0; the file is on the disk afterwards. */
static PetscErrorCode MarkFile(const char *path, MpmTextFile *mark, int *failure)
{
  Pieces      numbers = {0, 0, NULL}, rest = {0, 0, NULL};
  struct stat status;
  int         file = open(path, O_RDONLY | O_CLOEXEC);

  PetscFunctionBeginUser;
  errno = 0;
  if (file < 0 || fstat(file, &status) || fsync(file)) *failure = errno ? errno : EIO;
  if (!*failure && !FindNumbers(path, &numbers)) *failure = EIO;
  if (!*failure && Complement(&numbers, (PetscInt64)status.st_size, &rest)) *failure = ENOMEM;
  if (!*failure) PetscCall(CollectPieces(file, (PetscInt64)status.st_size, &rest, mark, failure));
  if (file >= 0) (void)close(file);
  free(numbers.piece);
  free(rest.piece);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmMarkSet(MPI_Comm comm, const char *path, MpmTextFile *mark)
{
  PetscMPIInt rank;
  int         failure = 0;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  if (rank == 0) PetscCall(MarkFile(path, mark, &failure));
  PetscCallMPI(MPI_Bcast(&failure, 1, MPI_INT, 0, comm));
  PetscCheck(!failure, comm, PETSC_ERR_FILE_WRITE, "cannot mark the state of %s: %s", path, strerror(failure));
  PetscFunctionReturn(PETSC_SUCCESS);
}

enum { RETURN_DONE, RETURN_NONE, RETURN_SHORT, RETURN_OTHER, RETURN_FAILED, RETURN_COUNT };

/* Checks that the pieces can be written again, and does so with `apply`. */
static int ReturnFile(const char *path, const MpmTextFile *mark, PetscBool apply)
{
  PetscInt64   head[3], hash, needed;
  struct stat  status;
  const Piece *piece = (const Piece *)(const void *)(mark->data + sizeof(head));
  const char  *bytes;
  int          file = open(path, O_RDWR | O_CLOEXEC), answer = RETURN_DONE;

  if (file < 0) return errno == ENOENT ? RETURN_NONE : RETURN_FAILED;
  memcpy(head, mark->data, sizeof(head));
  bytes  = (const char *)(piece + head[0]);
  needed = head[1]; /* up to the end of the last numbers */
  if (head[0] && piece[head[0] - 1].offset + piece[head[0] - 1].length == head[1]) needed = piece[head[0] - 1].offset;
  if (fstat(file, &status)) answer = RETURN_FAILED;
  else if (status.st_size < needed) answer = RETURN_SHORT;
  else if (Sample(file, (size_t)head[0], piece, &hash)) answer = RETURN_FAILED;
  else if (hash != head[2]) answer = RETURN_OTHER;
  for (PetscInt64 k = 0; k < head[0] && apply && answer == RETURN_DONE; bytes += piece[k++].length)
    if (MpmWriteAt(file, bytes, (size_t)piece[k].length, piece[k].offset)) answer = RETURN_FAILED;
  if (apply && answer == RETURN_DONE && (ftruncate(file, (off_t)head[1]) || fsync(file))) answer = RETURN_FAILED;
  (void)close(file);
  return answer;
}

PetscErrorCode MpmMarkReturn(MPI_Comm comm, const char *path, const MpmTextFile *mark, PetscBool apply,
                             PetscBool *there, MpmOutcome *outcome)
{
  static const char *const reasons[RETURN_COUNT] = {NULL, NULL, "it is shorter than it was", "it is not what it was",
                                                    "it cannot be read and written"};
  PetscMPIInt              rank;
  int                      answer = RETURN_NONE;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  if (rank == 0 && mark->length) answer = ReturnFile(path, mark, apply);
  PetscCallMPI(MPI_Bcast(&answer, 1, MPI_INT, 0, comm));
  *there = (PetscBool)(answer != RETURN_NONE);
  MpmOutcomeClear(outcome);
  if (reasons[answer]) PetscCall(MpmOutcomeFail(outcome, MPM_OUTCOME_FILE, "%s", reasons[answer]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Checkpoint files: head, hash, names.
*/
#include "base/outcome.h"
#include "io/io.h"
#include <errno.h>
#include <fcntl.h>
#include <glob.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#include "base/base.h"
#include "talus/talus.h"

#define HASH_BLOCK (1 << 20)

/* ---- head ---- */

static void HeadText(const MpmCheckpointHead *head, char text[MPM_CHECKPOINT_HEAD])
{
  memset(text, 0, MPM_CHECKPOINT_HEAD);
  (void)snprintf(text, MPM_CHECKPOINT_HEAD,
                 "talus checkpoint\nformat %lld\nversion %s\nrun %lld\nstep %lld\nsize %lld\nhash %016llx\n",
                 head->format, MPM_VERSION, head->run, head->step, head->size, (unsigned long long)head->hash);
}

/* Where the digits of the hash stand in the text, or NULL. */
static char *HashDigits(char text[MPM_CHECKPOINT_HEAD])
{
  for (size_t k = 0; k + 6 + 16 < MPM_CHECKPOINT_HEAD; k++)
    if (!memcmp(&text[k], "\nhash ", 6)) return &text[k + 6];
  return NULL;
}

/* The reason for which this is not the head of a checkpoint that can be read, or NULL. */
static const char *ParseHead(const char text[MPM_CHECKPOINT_HEAD], MpmCheckpointHead *head)
{
  static const char  first[] = "talus checkpoint\nformat ";
  unsigned long long hash;
  char               copy[MPM_CHECKPOINT_HEAD + 1] = "", digits[17], *at;

  memcpy(copy, text, MPM_CHECKPOINT_HEAD);
  at = HashDigits(copy);
  if (strncmp(copy, first, sizeof(first) - 1) || sscanf(copy + sizeof(first) - 1, "%lld", &head->format) != 1)
    return "it is not a checkpoint of Talus";
  if (head->format != MPM_CHECKPOINT_FORMAT) return "its format is of another version of Talus";
  if (sscanf(copy + sizeof(first) - 1, "%lld version %*s run %lld step %lld size %lld hash %llx", &head->format,
             &head->run, &head->step, &head->size, &hash) != 5)
    return "it is damaged: its head cannot be read";
  head->hash = hash;
  (void)snprintf(digits, sizeof(digits), "%016llx", hash);
  if (!at || memcmp(at, digits, 16)) return "it is damaged: its head cannot be read";
  return NULL;
}

/* ---- hash ---- */

/* This rank's share of the hash of a file: all bytes but the head. Returns 0 or -1. */
static int HashShare(const char *path, PetscInt64 size, PetscMPIInt rank, PetscMPIInt ranks, uint64_t *hash)
{
  const PetscInt64 blocks = (size + HASH_BLOCK - 1) / HASH_BLOCK;
  const PetscInt64 begin = blocks * rank / ranks, end = blocks * (rank + 1) / ranks;
  int              file = open(path, O_RDONLY | O_CLOEXEC), status = file < 0 ? -1 : 0;
  char            *buffer = (char *)malloc(HASH_BLOCK);

  *hash = 0;
  if (!buffer) status = -1;
  for (PetscInt64 block = begin; block < end && !status; block++) {
    const PetscInt64 place = block * HASH_BLOCK, skip = block ? 0 : MPM_CHECKPOINT_HEAD;
    const PetscInt64 length = PetscMin(size - place, HASH_BLOCK) - skip;

    if (length <= 0) continue;
    status = MpmReadAt(file, buffer, (size_t)length, place + skip);
    if (!status) *hash += MpmHashBytes(buffer, (size_t)length, (uint64_t)(place + skip));
  }
  free(buffer);
  if (file >= 0) (void)close(file);
  return status;
}

/* Hash of a file with this head, in which the hash itself is zero; `read`: false where reading failed. Collective. */
static PetscErrorCode HashFile(MPI_Comm comm, const char *path, PetscInt64 bytes, PetscInt64 collective,
                               const char text[MPM_CHECKPOINT_HEAD], uint64_t *hash, PetscBool *read)
{
  const PetscBool together = (PetscBool)(bytes >= collective);
  PetscMPIInt     rank, size;
  int             status = 0;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCallMPI(MPI_Comm_size(comm, &size));
  *hash = 0;
  if (together || !rank) status = HashShare(path, bytes, rank, together ? size : 1, hash);
  if (!rank) *hash += MpmHashBytes(text, MPM_CHECKPOINT_HEAD, 0);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, hash, 1, MPI_UINT64_T, MPI_SUM, comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &status, 1, MPI_INT, MPI_MIN, comm));
  *read = (PetscBool)!status;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Rank 0's part of the check: head and length. */
static const char *VerifyHead(const char *path, MpmCheckpointHead *head, char text[MPM_CHECKPOINT_HEAD],
                              char reason[256])
{
  struct stat status;
  int         file = open(path, O_RDONLY | O_CLOEXEC);
  const char *why  = NULL;

  memset(text, 0, MPM_CHECKPOINT_HEAD);
  if (file < 0 || fstat(file, &status)) {
    (void)snprintf(reason, 256, "%s", strerror(errno));
    why = reason;
  } else if (MpmReadAt(file, text, MPM_CHECKPOINT_HEAD, 0)) {
    why = "it is not a checkpoint of Talus";
  } else {
    why = ParseHead(text, head);
  }
  if (!why && status.st_size != head->size) {
    (void)snprintf(reason, 256, "it is damaged: it has %lld bytes in place of %lld", (long long)status.st_size,
                   head->size);
    why = reason;
  }
  if (file >= 0) (void)close(file);
  return why;
}

PetscErrorCode MpmCheckpointVerify(MPI_Comm comm, const char *path, PetscInt64 collective, MpmCheckpointHead *head,
                                   MpmOutcome *outcome)
{
  char        text[MPM_CHECKPOINT_HEAD], found[256] = "";
  PetscMPIInt rank;
  uint64_t    hash;
  PetscBool   read;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  memset(head, 0, sizeof(*head));
  MpmOutcomeClear(outcome);
  if (!rank) {
    const char *wrong = VerifyHead(path, head, text, found);

    if (wrong) PetscCall(MpmOutcomeFail(outcome, MPM_OUTCOME_FILE, "%s", wrong));
    else memset(HashDigits(text), '0', 16);
  }
  PetscCall(MpmOutcomeBroadcast(comm, 0, outcome));
  if (outcome->code) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCallMPI(MPI_Bcast(head, (PetscMPIInt)sizeof(*head), MPI_BYTE, 0, comm));
  PetscCall(HashFile(comm, path, head->size, collective, text, &hash, &read));
  if (!read) PetscCall(MpmOutcomeFail(outcome, MPM_OUTCOME_FILE, "it cannot be read"));
  else if (hash != head->hash)
    PetscCall(MpmOutcomeFail(outcome, MPM_OUTCOME_FILE, "it is damaged: its checksum does not fit"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- names ---- */

static PetscErrorCode CheckpointPath(const char *prefix, long long step, char path[PETSC_MAX_PATH_LEN])
{
  PetscFunctionBeginUser;
  if (step < 0) PetscCall(PetscSNPrintf(path, PETSC_MAX_PATH_LEN, "%s_checkpoint.h5", prefix));
  else PetscCall(PetscSNPrintf(path, PETSC_MAX_PATH_LEN, "%s_checkpoint_%06lld.h5", prefix, step));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The number in the name of an older checkpoint, or -1 for another file's. */
static long long StepOfName(const char *prefix, const char *path)
{
  const char *digits = path + strlen(prefix) + strlen("_checkpoint_");
  char       *end;
  long long   step = strtoll(digits, &end, 10);

  return end > digits && !strcmp(end, ".h5") ? step : -1;
}

static int CompareSteps(const void *a, const void *b)
{
  const long long one = *(const long long *)a, other = *(const long long *)b;

  return one > other ? -1 : one < other;
}

/* The steps of the older checkpoints of a prefix, the latest first; free() them. Rank 0. */
static PetscErrorCode OlderSteps(const char *prefix, size_t *count, long long **steps)
{
  char   pattern[2 * PETSC_MAX_PATH_LEN], *to = pattern;
  glob_t found;

  PetscFunctionBeginUser;
  for (const char *c = prefix; *c; c++) {
    if (strchr("*?[]\\", *c)) *to++ = '\\';
    *to++ = *c;
  }
  strcpy(to, "_checkpoint_*.h5");
  *count = 0;
  memset(&found, 0, sizeof(found));
  if (glob(pattern, 0, NULL, &found)) found.gl_pathc = 0;
  *steps = (long long *)malloc((found.gl_pathc + 1) * sizeof(long long));
  PetscCheck(*steps, PETSC_COMM_SELF, PETSC_ERR_MEM, "no memory for %zu names", found.gl_pathc);
  for (size_t k = 0; k < found.gl_pathc; k++) {
    const long long step = StepOfName(prefix, found.gl_pathv[k]);

    if (step >= 0) (*steps)[(*count)++] = step;
  }
  globfree(&found);
  if (*count) qsort(*steps, *count, sizeof(long long), CompareSteps);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmCheckpointList(MPI_Comm comm, const char *prefix, PetscInt *count, char ***paths)
{
  char        path[PETSC_MAX_PATH_LEN];
  PetscMPIInt rank;
  size_t      older = 0;
  long long  *steps = NULL;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  if (!rank) PetscCall(OlderSteps(prefix, &older, &steps));
  PetscCall(CheckpointPath(prefix, -1, path));
  *count = (PetscInt)older + (!rank && !access(path, F_OK));
  PetscCallMPI(MPI_Bcast(count, 1, MPIU_INT, 0, comm));
  PetscCall(PetscCalloc1(*count, paths));
  for (PetscInt k = 0; k < *count; k++) {
    if (!rank && (size_t)*count > older && k) PetscCall(CheckpointPath(prefix, steps[k - 1], path));
    else if (!rank && (size_t)*count == older) PetscCall(CheckpointPath(prefix, steps[k], path));
    PetscCallMPI(MPI_Bcast(path, PETSC_MAX_PATH_LEN, MPI_CHAR, 0, comm));
    PetscCall(PetscStrallocpy(path, &(*paths)[k]));
  }
  free(steps);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The newest checkpoint becomes an older one, where it belongs to this run; a newest one exists at any moment. */
static PetscErrorCode KeepOlder(const char *prefix, const char *path, const MpmCheckpointHead *head, PetscInt keep)
{
  MpmCheckpointHead old;
  char              older[PETSC_MAX_PATH_LEN], text[MPM_CHECKPOINT_HEAD], reason[256];
  long long        *steps;
  size_t            count;
  PetscInt          kept = 1;

  PetscFunctionBeginUser;
  if (keep > 1 && !VerifyHead(path, &old, text, reason) && old.run == head->run && old.step < head->step) {
    PetscCall(CheckpointPath(prefix, old.step, older));
    (void)unlink(older);
    if (link(path, older)) (void)rename(path, older); /* a file system without links */
  }
  PetscCall(OlderSteps(prefix, &count, &steps));
  for (size_t k = 0; k < count; k++) {
    PetscCall(CheckpointPath(prefix, steps[k], older));
    if (kept < keep && steps[k] < head->step && !VerifyHead(older, &old, text, reason) && old.run == head->run) kept++;
    else (void)unlink(older);
  }
  free(steps);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Head and disk; 0 or errno. */
static int CompleteFile(const char *path, const MpmCheckpointHead *head)
{
  char text[MPM_CHECKPOINT_HEAD];
  int  file = open(path, O_WRONLY | O_CLOEXEC), failure = 0;

  if (file < 0) return errno;
  HeadText(head, text);
  errno = 0;
  if (MpmWriteAt(file, text, sizeof(text), 0) || fsync(file)) failure = errno ? errno : EIO;
  if (close(file) && !failure) failure = errno;
  return failure;
}

/* 0 or errno. */
static int FileSize(const char *path, long long *size)
{
  struct stat status;

  if (stat(path, &status)) return errno;
  *size = (long long)status.st_size;
  return 0;
}

PetscErrorCode MpmCheckpointPublish(MPI_Comm comm, const char *prefix, const char *temporary, MpmCheckpointHead *head,
                                    PetscInt keep, PetscInt64 collective)
{
  char        path[PETSC_MAX_PATH_LEN], text[MPM_CHECKPOINT_HEAD];
  PetscMPIInt rank;
  PetscBool   read;
  int         failure = 0;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCall(CheckpointPath(prefix, -1, path));
  head->format = MPM_CHECKPOINT_FORMAT;
  if (!rank) failure = FileSize(temporary, &head->size);
  PetscCall(MpmFileCheck(comm, temporary, failure));
  PetscCallMPI(MPI_Bcast(&head->size, 1, MPI_LONG_LONG, 0, comm));
  head->hash = 0;
  HeadText(head, text);
  PetscCall(HashFile(comm, temporary, head->size, collective, text, &head->hash, &read));
  if (!rank) {
    failure = read ? CompleteFile(temporary, head) : EIO;
    if (!failure) PetscCall(KeepOlder(prefix, path, head, keep));
    if (!failure && rename(temporary, path)) failure = errno;
    if (!failure) failure = MpmSyncFolder(path);
  }
  PetscCall(MpmFileCheck(comm, path, failure));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Bytes of files; none of this is collective.
*/
#include "base/base.h"
#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <unistd.h>

int MpmReadAt(int file, void *bytes, size_t size, PetscInt64 offset)
{
  char *at = (char *)bytes;

  while (size) {
    const ssize_t got = pread(file, at, size, (off_t)offset);

    if (got < 0 && errno == EINTR) continue;
    if (got == 0) errno = 0;
    if (got <= 0) return -1;
    at += got;
    size -= (size_t)got;
    offset += got;
  }
  return 0;
}

int MpmWriteAt(int file, const void *bytes, size_t size, PetscInt64 offset)
{
  const char *at = (const char *)bytes;

  while (size) {
    const ssize_t put = pwrite(file, at, size, (off_t)offset);

    if (put < 0 && errno == EINTR) continue;
    if (put <= 0) return -1;
    at += put;
    size -= (size_t)put;
    offset += put;
  }
  return 0;
}

/* The finalizer of SplitMix64 (Steele, Lea and Flood 2014): a bijection, so that no two words mix to the same. */
static uint64_t Mix(uint64_t word)
{
  word = (word ^ (word >> 30)) * 0xbf58476d1ce4e5b9u;
  word = (word ^ (word >> 27)) * 0x94d049bb133111ebu;
  return word ^ (word >> 31);
}

uint64_t MpmHashBytes(const void *bytes, size_t size, uint64_t place)
{
  const char *at  = (const char *)bytes;
  uint64_t    sum = 0, count = place / 8;

  for (; size; at += 8, count++) {
    const size_t part = size < 8 ? size : 8;
    uint64_t     word = 0;

    memcpy(&word, at, part);
    sum += Mix(word + (count + 1) * 0x9e3779b97f4a7c15u);
    size -= part;
  }
  return sum;
}

int MpmSyncFolder(const char *path)
{
  char        folder[PETSC_MAX_PATH_LEN] = ".";
  const char *slash                      = strrchr(path, '/');
  int         file, failure = 0;

  if (slash && (size_t)(slash - path) + 1 < sizeof(folder)) {
    memcpy(folder, path, (size_t)(slash - path) + 1);
    folder[slash - path + 1] = 0;
  }
  file = open(folder, O_RDONLY | O_CLOEXEC);
  if (file < 0) return errno;
  if (fsync(file) && errno != EINVAL) failure = errno; /* not every file system syncs folders */
  (void)close(file);
  return failure;
}

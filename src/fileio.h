#pragma once
/*
  Bytes of files: whole reads and writes at a place, and a hash that does not depend on who reads which part.
*/
#include <stdint.h>
#include <stddef.h>
#include <petscsys.h>

/* 0, or -1 with the reason in errno (0: the file ends before). */
int MpmReadAt(int file, void *bytes, size_t size, PetscInt64 offset);
int MpmWriteAt(int file, const void *bytes, size_t size, PetscInt64 offset);

/*
  A sum over the words of 8 bytes (the last one filled up with zeros) of a mixture of word and place: the parts of a
  file may be summed in any order, and a change of any one word changes the sum. `place` is that of the first byte; parts
  must meet at multiples of 8.
*/
uint64_t MpmHashBytes(const void *bytes, size_t size, uint64_t place);

/* Brings the names in the folder of `path` to the disk; 0 or errno. */
int MpmSyncFolder(const char *path);

#pragma once
/*
  The base of all folders: differences between PETSc's releases, numbers as text, texts that become files, bytes of
  files, and exchange between ranks. Independent of the program's purpose.
*/
#include <stdint.h>
#include <stddef.h>
#include <petscsf.h>
#include "talus/compat.h"
#include "talus/point/dense.h"

/* A loop that is written once and compiled with constants for its usual cases. */
#define MPM_INLINE static inline __attribute__((always_inline))

/* f(dim, ...) with a constant number of axes, for loops that are compiled for each. */
#define MPM_BY_DIM(dim, f, ...) ((dim) == 2 ? f(2, __VA_ARGS__) : f(3, __VA_ARGS__))

#define MPM_MAX_DIM   3
#define MPM_MAX_WIDTH 16 /* nodes of a point on an axis */

#define MPM_TOLERANCE 1e-6 /* of a cell: distance that is still on a region's edge */
/* Basis functions of one shape: weights, then derivatives, then weights less their means. */
#define MPM_BASES          (MPM_MAX_DIM + 2)
#define MPM_DEVIATION(dim) ((dim) + 1)
#define MPM_HOOP_BASIS     (MPM_BASES - 1) /* weights over the radius, with axial symmetry */

/*
  Ends the run with one line: the message names the option, its value and what is accepted. The condition must be the
  same on all ranks.
*/
#define MpmCheckInput(condition, ...) \
  do { \
    if (PetscUnlikely(!(condition))) SETERRQ(PETSC_COMM_SELF, MPM_ERR_INPUT, __VA_ARGS__); \
  } while (0)

/* ---- number.c ---- */

/* Room for a number or a range as text. */
#define MPM_NUMBER_TEXT 64

/* Shortest decimal form that reads back to an equal number. PETSc's own %g turns 1 into "1.", unlike a user. */
void MpmRealText(PetscReal value, char text[MPM_NUMBER_TEXT]);
/* The whole of `text`, blanks around it aside, must be one finite number. */
PetscBool MpmParseReal(const char text[], PetscReal *value);
PetscBool MpmParseInt(const char text[], PetscInt *value);

/* Appends formatted text to an allocated string (NULL to start with); free with PetscFree(). */
PetscErrorCode MpmTextAppend(char **text, const char format[], ...) PETSC_ATTRIBUTE_FORMAT(2, 3);
/* `value` fit for a one-line message: control characters become blanks, and a long one is cut short. Free with
   PetscFree(). */
PetscErrorCode MpmTextQuote(const char value[], char **quoted);

/*
  Splits at commas, blanks around each part dropped; "" has no parts, "a," has an empty second one. Free with
  MpmNamesDestroy().
*/
PetscErrorCode MpmTextSplit(const char text[], PetscInt *count, char ***parts);

PetscErrorCode MpmNamesDestroy(PetscInt count, char ***names);

/* Bytes of the UTF-8 character at s, and its code point; 0 where there is none. */
int MpmDecodeUTF8(const unsigned char s[], unsigned *code);

/*
  Levenshtein distance of two texts, case aside: single-character insertions, deletions and replacements (Levenshtein
  1966, Soviet Physics Doklady 10); and the name at the least distance, at most `most`: NULL where there is none.
*/
PetscInt    MpmTextDistance(const char a[], const char b[]);
const char *MpmTextNearest(const char text[], PetscInt count, char *const names[], PetscInt most);

/* ---- text_buffer.c ---- */

/*
  MpmTextFile - a text that grows and then becomes a file in one go. The file appears under its name complete or not
  at all: it is written under a temporary name beside it and renamed.
*/

/* Start from MPM_TEXT_FILE_EMPTY. `data` ends with a zero byte once anything has been appended. */
typedef struct {
  char  *data;
  size_t length, capacity;
} MpmTextFile;
#define MPM_TEXT_FILE_EMPTY ((MpmTextFile){NULL, 0, 0})

/* Not collective. The format is C's printf's. */
PetscErrorCode MpmTextFileAppend(MpmTextFile *text, const char *format, ...) PETSC_ATTRIBUTE_FORMAT(2, 3);
/* Makes room for `more` bytes and the closing zero. */
PetscErrorCode MpmTextFileReserve(MpmTextFile *text, size_t more);
PetscErrorCode MpmTextFileDestroy(MpmTextFile *text);

/*@
  MpmTextFileWrite - write texts, one after the other, as the file `path`, replacing what was there

  Collective; the texts of rank 0 count

  Input Parameters:
+ comm  - the ranks that wait for the file
. path  - its name
. count - number of texts
- texts - pointers to them

  Notes:
  Fails on all ranks with PETSC_ERR_FILE_WRITE and one line with the name and the system's reason.
@*/
PetscErrorCode MpmTextFileWrite(MPI_Comm comm, const char *path, PetscInt count, const MpmTextFile *const texts[]);

/* Collective: when `failure`, the value of errno on rank 0, is not 0, all ranks fail with PETSC_ERR_FILE_WRITE and
   one line. */
PetscErrorCode MpmFileCheck(MPI_Comm comm, const char *path, int failure);

/* ---- raw_io.c ---- */

/*
  Bytes of files: whole reads and writes at a place, and a hash that does not depend on who reads which part.
*/

/* 0, or -1 with the reason in errno (0: the file ends before). */
int MpmReadAt(int file, void *bytes, size_t size, PetscInt64 offset);
int MpmWriteAt(int file, const void *bytes, size_t size, PetscInt64 offset);

/*
  A sum over the words of 8 bytes (the last one filled up with zeros) of a mixture of word and place: the parts of a
  file may be summed in any order, and a change of any one word changes the sum. `place` is the position of the first
  byte; parts must meet at multiples of 8.
*/
uint64_t MpmHashBytes(const void *bytes, size_t size, uint64_t place);

/* Brings the names in the folder of `path` to the disk; 0 or errno. */
int MpmSyncFolder(const char *path);

/* ---- exchange.c ---- */

/*
  Sends a list of integers to each of some ranks and receives likewise (exchange.c). Received data: from[k] sent
  data[offset[k] .. offset[k+1]).
*/
typedef struct {
  PetscInt     count;
  PetscMPIInt *rank;
  PetscInt    *offset; /* count + 1 */
  PetscInt    *data;
} MpmLists;
PetscErrorCode MpmListsExchange(MPI_Comm comm, const MpmLists *sent, MpmLists *received);
PetscErrorCode MpmListsDestroy(MpmLists *lists);

/* ---- monitor.c ---- */

/* Where wall time went, s (maximum over ranks). */
typedef enum {
  MPM_TIME_SETUP,
  MPM_TIME_TRANSFER,
  MPM_TIME_RESIDUAL,
  MPM_TIME_JACOBIAN,
  MPM_TIME_SOLVE,
  MPM_TIME_MIGRATE,
  MPM_TIME_OUTPUT,
  MPM_TIME_GRADIENT,
  MPM_TIME_COUNT
} MpmTimer;

/* Settings that a run may change by itself. */
typedef enum {
  MPM_CHANGE_DILATION,
  MPM_CHANGE_SETTLING,
  MPM_CHANGE_KRYLOV,
  MPM_CHANGE_WORKSPACE,
  MPM_CHANGE_COUNT
} MpmChange;

/* Messages of the engine while it runs, to a listener; times of its tasks. */
typedef struct MpmMonitor {
  PetscErrorCode (*message)(void *ctx, PetscBool line, const char text[]); /* NULL: no listener */
  void         *ctx;
  PetscReal     seconds[MPM_TIME_COUNT];
  PetscLogEvent event[MPM_TIME_COUNT];     /* the tasks in -log_view */
  PetscInt      changes[MPM_CHANGE_COUNT]; /* how often the run has changed each setting by itself */
} MpmMonitor;
extern const char *const MpmTimers[], *const MpmChanges[]; /* their names */
/* Nobody listens, no time has passed; the tasks' events are made known to PETSc. */
PetscErrorCode MpmMonitorCreate(MpmMonitor *monitor);
/* A note to the step under way, and a line of its own in place of a step's. */
PetscErrorCode MpmMonitorNote(const MpmMonitor *monitor, const char format[], ...) PETSC_ATTRIBUTE_FORMAT(2, 3);
PetscErrorCode MpmMonitorLine(const MpmMonitor *monitor, const char format[], ...) PETSC_ATTRIBUTE_FORMAT(2, 3);
/* Notes a change that the run makes by itself, and counts it. */
PetscErrorCode MpmMonitorChange(MpmMonitor *monitor, MpmChange change, const char format[], ...)
  PETSC_ATTRIBUTE_FORMAT(3, 4);
/* A task begins, and ends: the seconds in between are added to its own. `since` is the caller's. */
PetscErrorCode MpmMonitorBegin(MpmMonitor *monitor, MpmTimer timer, PetscLogDouble *since);
PetscErrorCode MpmMonitorEnd(MpmMonitor *monitor, MpmTimer timer, PetscLogDouble since);

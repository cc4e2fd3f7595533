#pragma once
/*
  Typed reading of -mpm_ options, one line of manual and one line of complaint for each.

  Every reader states name, unit, range and meaning once: the same words make the text of -help, the check of the value,
  and the record of the options in force. Input errors carry MPM_ERR_INPUT; main() turns them into one line and exit
  status 2.
*/
#include <stdio.h>
#include "base/base.h"

#define MPM_ERR_INPUT PETSC_ERR_USER_INPUT

/*
  Ends the run with one line: the message names the option, its value and what is accepted. The condition must be the
  same on all ranks.
*/
#define MpmCheckInput(condition, ...) \
  do { \
    if (PetscUnlikely(!(condition))) SETERRQ(PETSC_COMM_SELF, MPM_ERR_INPUT, __VA_ARGS__); \
  } while (0)

/* What has been read so far, with the values in force. */
typedef struct _p_MpmRecord *MpmRecord;
PetscErrorCode               MpmRecordCreate(MpmRecord *record);
PetscErrorCode               MpmRecordDestroy(MpmRecord *record);

/*
  Where a block of options lives: `prefix` without the leading dash, like "mpm_material_beam_". `record` may be NULL.
*/
typedef struct {
  MPI_Comm    comm;
  const char *prefix;
  MpmRecord   record;
} MpmOptions;

/* Accepted range; `open` excludes the bounds themselves. */
typedef struct {
  PetscReal lower, upper;
  PetscBool open;
} MpmRange;
#define MPM_RANGE_ANY          ((MpmRange){PETSC_NINFINITY, PETSC_INFINITY, PETSC_FALSE})
#define MPM_RANGE_POSITIVE     ((MpmRange){0., PETSC_INFINITY, PETSC_TRUE})
#define MPM_RANGE_NON_NEGATIVE ((MpmRange){0., PETSC_INFINITY, PETSC_FALSE})

/* A range as -help and messages have it: "in (-1, 0.5)", "> 0"; empty where all numbers are accepted. */
#define MPM_RANGE_TEXT (2 * MPM_NUMBER_TEXT + 16)
void      MpmRangeText(MpmRange range, char text[MPM_RANGE_TEXT]);
PetscBool MpmRangeHolds(MpmRange range, PetscReal value);

typedef enum { MPM_OPTIONAL, MPM_REQUIRED } MpmNeed;

/* Is this run only for -help? Then values are not to be relied on, and what follows from them must be skipped. */
PetscBool MpmOptionsHelp(void);

/* Prints the heading of a block when -help asks for it. */
PetscErrorCode MpmOptionsHeading(const MpmOptions *options, const char *title);

/*
  `value` holds the default on entry. `set` (may be NULL) tells whether the option was given. Not-a-number is never
  accepted.
*/
PetscErrorCode MpmOptionsReal(const MpmOptions *options, const char *name, const char *unit, const char *help,
                              MpmRange range, MpmNeed need, PetscReal *value, PetscBool *set);
PetscErrorCode MpmOptionsInt(const MpmOptions *options, const char *name, const char *help, PetscInt lower,
                             PetscInt upper, MpmNeed need, PetscInt *value, PetscBool *set);
PetscErrorCode MpmOptionsBool(const MpmOptions *options, const char *name, const char *help, PetscBool *value,
                              PetscBool *set);
/* `count` values exactly, comma-separated; `values` holds the default on entry when the need is optional. */
PetscErrorCode MpmOptionsReals(const MpmOptions *options, const char *name, const char *unit, const char *help,
                               MpmRange range, MpmNeed need, PetscInt count, PetscReal values[], PetscBool *set);
PetscErrorCode MpmOptionsInts(const MpmOptions *options, const char *name, const char *help, PetscInt lower,
                              PetscInt upper, MpmNeed need, PetscInt count, PetscInt values[], PetscBool *set);
/* Any number of reals; free with PetscFree(). */
PetscErrorCode MpmOptionsRealList(const MpmOptions *options, const char *name, const char *unit, const char *help,
                                  MpmNeed need, PetscInt *count, PetscReal **values);
/* One word out of `choices` (NULL-terminated); `value` is its index and holds the default on entry. */
PetscErrorCode MpmOptionsWord(const MpmOptions *options, const char *name, const char *help,
                              const char *const choices[], MpmNeed need, PetscInt *value, PetscBool *set);
/* Free text; `value` is NULL when the option is absent; free with PetscFree(). */
PetscErrorCode MpmOptionsText(const MpmOptions *options, const char *name, const char *help, const char *fallback,
                              MpmNeed need, char **value);
/*
  A comma-separated list of names of blocks: letters, digits and underscores, no two alike. Free with MpmNamesDestroy().
*/
PetscErrorCode MpmOptionsNames(const MpmOptions *options, const char *name, const char *help, MpmNeed need,
                               PetscInt *count, char ***names);
PetscErrorCode MpmNamesDestroy(PetscInt count, char ***names);
/* Is the option -<prefix><name> there? Does not mark it as used. */
PetscErrorCode MpmOptionsHas(const MpmOptions *options, const char *name, PetscBool *has);

/* Is the file a text that can be options, as far as a look tells? Names the line where it is not. */
PetscErrorCode MpmOptionsCheckFile(MPI_Comm comm, const char option[], const char path[], PetscBool yaml);
/*
  After the whole scene has been read: an -mpm_ option that nobody asked for ends the run, with the nearest known name;
  and so does an option of PETSc's that is not a number where it must be one.
*/
PetscErrorCode MpmOptionsCheckUnknown(const MpmOptions *options);
/* When options are looked through that nobody has used: after the first linear solve, and at the end of the run. */
typedef enum { MPM_BEFORE_SOLVE, MPM_AFTER_SOLVE, MPM_AT_END } MpmMoment;
/*
  Collective. Says on stderr, once for each, which options of PETSc's nobody has used that the user gave and that would
  have been asked for by now. For a record that MpmOptionsCheckUnknown() has seen.
*/
PetscErrorCode MpmOptionsWarnUnused(const MpmOptions *options, MpmMoment moment);
/* The option of PETSc's, "-name value", whose value an error message of PETSc's quotes; empty where there is none. */
PetscErrorCode MpmForeignOptionsFind(const char message[], char name[], size_t size);
/* Writes what was in force, defaults included, and all other PETSc options, as YAML that can be run again (rank 0). */
PetscErrorCode MpmOptionsWriteYAML(const MpmOptions *options, const char *path);
/* The same as text, appended. Not collective. */
PetscErrorCode MpmOptionsTextYAML(const MpmOptions *options, MpmTextFile *text);

/* ---- what the readers, their record and other parsers share ---- */

/* What is wrong with a file in YAML, as "line N ...": no YAML, or an option stands in it twice; empty for nothing. */
PetscErrorCode MpmYAMLCheck(const char path[], char fault[], size_t size);

/*
  Splits at commas, blanks around each part dropped; "" has no parts, "a," has an empty second one. Free with
  MpmNamesDestroy().
*/
PetscErrorCode MpmTextSplit(const char text[], PetscInt *count, char ***parts);

/* One option of the manual: its name, and its text in a column of its own. */
PetscErrorCode MpmHelpEntry(MPI_Comm comm, const char name[], const char text[]);

/*
  The options database. `name` has no leading dash. PETSc's look-up takes -a_b for -a_1_b when the latter is absent,
  meant for levels of multigrid, and it would let one body of a scene inherit from another: these go by the exact name
  (case aside, as PETSc does).
*/
PetscErrorCode MpmDatabaseHas(const char name[], PetscBool *has);
/* Lends the value; NULL for an option without one. Marks the option as used. */
PetscErrorCode MpmDatabaseFind(const char name[], const char **value, PetscBool *given);

/* An option that is not ours, as it stands in the database, which lends both; `value` may be NULL. */
typedef struct {
  const char *name, *value;
} MpmForeignOption;

/* All of them; free `options` and `text` with PetscFree() after use. */
PetscErrorCode MpmDatabaseGetForeign(PetscInt *count, MpmForeignOption **options, char **text);
/* Ends the run where one of them has a value that PETSc would take for a number and fail, or that is not finite. */
PetscErrorCode MpmForeignOptionsCheck(void);

/* Keeps the user's among them for MpmOptionsWarnUnused(), and lets go of them (unused.c). */
PetscErrorCode MpmForeignOptionsKeep(MpmRecord record);
PetscErrorCode MpmForeignOptionsForget(MpmRecord record);

/* One option that a reader has asked for. */
typedef struct {
  char     *name;
  char     *value;    /* in force; NULL when there is none that could be read again */
  PetscBool known;    /* a reader has asked for it, and has not merely looked whether it is there */
  PetscBool given;    /* by the user */
  PetscBool presence; /* somebody asked whether it was given: written as a key it would change its meaning */
} MpmRecordEntry;

/* An option of PETSc's that the user gave. */
typedef struct {
  char     *name, *value; /* fit for a message; empty where it has none */
  PetscBool told;         /* that nobody used it */
} MpmGivenOption;

struct _p_MpmRecord {
  PetscInt        count, capacity;
  MpmRecordEntry *entries;
  PetscInt        foreign_count;
  MpmGivenOption *foreign; /* unused.c */
  MpmMoment       moment;  /* up to which they have been looked through */
};

/* Lends the option's entry, which is made where there is none; it lives until the next call. */
PetscErrorCode MpmRecordGet(MpmRecord record, const char name[], MpmRecordEntry **entry);

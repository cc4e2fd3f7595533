#pragma once
/*
  Typed reading of -mpm_ options, one line of manual and one line of complaint for each.

  Every reader states name, unit, range and meaning once: the same words make the text of -help, the check of the value,
  and the record of the options in force. Input errors carry MPM_ERR_INPUT; main() turns them into one line and exit
  status 2.
*/
#include "base/base.h"
#include "base/range.h"

/* Options read so far, with the values in force. */
typedef struct _p_MpmRecord *MpmRecord;
PetscErrorCode               MpmRecordCreate(MpmRecord *record);
PetscErrorCode               MpmRecordDestroy(MpmRecord *record);

/*
  Coordinates of a scene on a map: its system, borrowed texts or NULL, and a local origin that places are less.
*/
typedef struct {
  const char *project, *system;
  PetscReal   origin[2]; /* m */
} MpmPlane;
/* Copies it, with borrowed texts. */
void MpmRecordSetPlane(MpmRecord record, const MpmPlane *plane);
/* Lends it, or NULL where the scene is on no map. */
const MpmPlane *MpmRecordPlane(MpmRecord record);
/* The rectangle or box that the grid covers, m, about which maps are read; borrowed. */
void MpmRecordSetWindow(MpmRecord record, const PetscReal lower[], const PetscReal upper[]);
/* Lends it; NULL where it is not known. */
void MpmRecordWindow(MpmRecord record, const PetscReal **lower, const PetscReal **upper);

/*
  Where a block of options lives: `prefix` without the leading dash, like "mpm_material_beam_". `record` may be NULL.
*/
typedef struct MpmOptions {
  MPI_Comm    comm;
  const char *prefix;
  MpmRecord   record;
} MpmOptions;

/* A range as -help and messages have it: "in (-1, 0.5)", "> 0"; empty where all numbers are accepted. */
#define MPM_RANGE_TEXT (2 * MPM_NUMBER_TEXT + 16)
void      MpmRangeText(MpmRange range, char text[MPM_RANGE_TEXT]);
PetscBool MpmRangeHolds(MpmRange range, PetscReal value);
/* Text of a range in a refusal: "must lie in [0, 30] degrees", "must be > 0" */
#define MPM_MUST_TEXT (MPM_RANGE_TEXT + 48)
void MpmMustText(const char range[], const char unit[], char text[MPM_MUST_TEXT]);

typedef enum { MPM_OPTIONAL, MPM_REQUIRED } MpmNeed;

/* True where the run is only for -help: values are then not to be relied on, and their consequences must be skipped. */
PetscBool MpmOptionsHelp(void);

/* Prints the heading of a block with -help. */
PetscErrorCode MpmOptionsHeading(const MpmOptions *options, const char *title);

/* One option of numbers, as the manual, the check and the record know it. */
typedef struct {
  const char *name, *unit, *help;
  MpmRange    range;        /* of reals */
  PetscInt    lower, upper; /* of integers */
  MpmNeed     need;
} MpmNumberOption;

/*
  `count` values exactly, comma-separated. `values` holds the default on entry when the need is optional. `set` (may be
  NULL): the option was given. Not-a-number is never accepted.
*/
PetscErrorCode MpmOptionsReadReals(const MpmOptions *options, const MpmNumberOption *option, PetscInt count,
                                   PetscReal values[], PetscBool *set);
PetscErrorCode MpmOptionsReadInts(const MpmOptions *options, const MpmNumberOption *option, PetscInt count,
                                  PetscInt values[], PetscBool *set);
/* MpmOptionsReadReals() in one line a reading, as PETSc has it; a range written out stands in parentheses. */
#define MpmOptionsReals(options, name_, unit_, help_, range_, need_, count, values, set) \
  MpmOptionsReadReals(options, \
                      &(MpmNumberOption){.name = name_, .unit = unit_, .help = help_, .range = range_, .need = need_}, \
                      count, values, set)
#define MpmOptionsInts(options, name_, help_, lower_, upper_, need_, count, values, set) \
  MpmOptionsReadInts( \
    options, &(MpmNumberOption){.name = name_, .help = help_, .lower = lower_, .upper = upper_, .need = need_}, count, \
    values, set)
#define MpmOptionsReal(options, name_, unit_, help_, range_, need_, value, set) \
  MpmOptionsReals(options, name_, unit_, help_, range_, need_, 1, value, set)
#define MpmOptionsInt(options, name_, help_, lower_, upper_, need_, value, set) \
  MpmOptionsInts(options, name_, help_, lower_, upper_, need_, 1, value, set)
PetscErrorCode MpmOptionsBool(const MpmOptions *options, const char *name, const char *help, PetscBool *value,
                              PetscBool *set);
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
  The name of a file to be read, as MpmOptionsText(). A relative one that a scene's file gives is looked for in that
  file's folder first, then in the working directory.
*/
PetscErrorCode MpmOptionsPath(const MpmOptions *options, const char *name, const char *help, MpmNeed need,
                              char **value);
/* As MpmOptionsPath(), for a path out of an option's text; `path` is replaced. */
PetscErrorCode MpmOptionsResolve(const MpmOptions *options, const char *name, char **path);
/*
  A comma-separated list of names: letters, digits and underscores, no two alike. Free with MpmNamesDestroy().
*/
PetscErrorCode MpmOptionsNames(const MpmOptions *options, const char *name, const char *help, MpmNeed need,
                               PetscInt *count, char ***names);
/* As MpmOptionsNames(), for a list of blocks, with its heading: with -help an absent list has one block, NAME. */
PetscErrorCode MpmOptionsBlocks(const MpmOptions *options, const char *list, const char *help, MpmNeed need,
                                PetscInt *count, char ***names);
/* True where the option -<prefix><name> is there; does not mark it as used. */
PetscErrorCode MpmOptionsHas(const MpmOptions *options, const char *name, PetscBool *has);
/* Lends the value of an option that has been read, where the user gave another than its default; NULL elsewhere. */
PetscErrorCode MpmOptionsOwnValue(const MpmOptions *options, const char *name, const char **value);

/*
  After the whole scene has been read: an unused -mpm_ option ends the run, with the nearest known name or the list that
  its block is not in; and so does an option of PETSc's that is not a number where it must be one. `warning` names
  blocks that a later list leaves out, NULL for none; free with PetscFree().
*/
PetscErrorCode MpmOptionsCheckUnknown(const MpmOptions *options, char **warning);
/* Refuses, with the nearest name, a user's option that is none of PETSc's; for a program that has no others. */
PetscErrorCode MpmForeignOptionsCheckNames(MpmRecord record);
/* Times of the search for unused options: after the first linear solve, and at the end of the run. */
typedef enum { MPM_BEFORE_SOLVE, MPM_AFTER_SOLVE, MPM_AT_END } MpmMoment;
/*
  Collective. Lists on stderr, once for each, the user's options of PETSc's that are unused and would have been used by
  now. For a record that MpmOptionsCheckUnknown() has seen.
*/
PetscErrorCode MpmOptionsWarnUnused(const MpmOptions *options, MpmMoment moment);
/* The option of PETSc's, "-name value", whose value an error message of PETSc's quotes; empty where there is none. */
PetscErrorCode MpmForeignOptionsFind(const char message[], char name[], size_t size);
/* Writes the values in force, with defaults, and all other PETSc options, as YAML that can be run again (rank 0). */
PetscErrorCode MpmOptionsWriteYAML(const MpmOptions *options, const char *path);
/* The record as YAML text, appended. Not collective. */
PetscErrorCode MpmOptionsTextYAML(const MpmOptions *options, MpmTextFile *text);

#pragma once
/*
  Shared by the readers of options, their record and other parsers: texts, the database of options, the record's
  entries.
*/
#include "options/database.h"
#include "options/options.h"

/* Ends the run where one of them has a value that PETSc would take for a number and fail, or that is not finite. */
PetscErrorCode MpmForeignOptionsCheck(void);

/* Keeps the user's among them for MpmOptionsWarnUnused(), and drops them (unused.c). */
PetscErrorCode MpmForeignOptionsKeep(MpmRecord record);
PetscErrorCode MpmForeignOptionsForget(MpmRecord record);

/* One option that a reader has used. */
typedef struct {
  char     *name;
  char     *value;    /* in force; NULL when there is none that could be read again */
  PetscBool known;    /* a reader has used it, beyond a test of its presence */
  PetscBool given;    /* by the user */
  PetscBool differs;  /* given, with another value than its default */
  PetscBool presence; /* somebody asked whether it was given: written as a key it would change its meaning */
  PetscBool list;     /* of blocks */
  PetscBool aside;    /* of a block that a later list leaves out */
  PetscBool numbers;  /* its value is reals, or a text that may have some */
  MpmRange  range;    /* of reals */
} MpmRecordEntry;

/* An option of PETSc's that the user gave. */
typedef struct {
  char     *name, *value; /* fit for a message; empty where it has none */
  PetscBool told;         /* warned of as unused */
} MpmGivenOption;

struct _p_MpmRecord {
  PetscInt         count, capacity;
  MpmRecordEntry  *entries;
  PetscInt         block_count;
  char           **blocks;  /* prefixes of the blocks that have been read */
  MpmSources       sources; /* borrowed; NULL: where options were given is not known */
  PetscInt         foreign_count;
  MpmGivenOption  *foreign; /* unused.c */
  MpmMoment        moment;  /* up to which they have been looked through */
  PetscBool        on_map;
  MpmPlane         plane;
  const PetscReal *window[2]; /* corners of the grid, borrowed; NULL: not known */
};

/* The block with this prefix is being read. */
PetscErrorCode MpmRecordAddBlock(MpmRecord record, const char prefix[]);
/* Prefix of the options of a list's blocks: mpm_bodies, mpm_body_. */
void MpmRecordBlockPrefix(const char list[], char prefix[PETSC_MAX_OPTION_NAME]);
/* Lends the option's entry, or NULL. */
PetscErrorCode MpmRecordFind(MpmRecord record, const char name[], MpmRecordEntry **entry);
/* Lends the option's entry, which is made where there is none; it lives until the next call. */
PetscErrorCode MpmRecordGet(MpmRecord record, const char name[], MpmRecordEntry **entry);

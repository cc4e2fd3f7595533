#pragma once
/*
  The options database in force, and those of the models.
*/
#include "base/base.h"

/*
  The options database in force. `name` has no leading dash. PETSc's look-up takes -a_b for -a_1_b when the latter is
  absent, meant for levels of multigrid, and it would let one body of a scene inherit from another: these go by the
  exact name (case aside, as PETSc does).
*/
PetscErrorCode MpmDatabaseHas(const char name[], PetscBool *has);
/* Lends the value; NULL for an option without one. Marks the option as used. */
PetscErrorCode MpmDatabaseFind(const char name[], const char **value, PetscBool *given);

/* Sets an option, "-name", that the user has not set; that is no use of it. */
PetscErrorCode MpmDatabaseDefault(const char name[], const char value[]);

/* An option as it stands in the database, which lends both; `value` may be NULL. */
typedef struct {
  const char *name, *value;
} MpmDatabaseOption;

/* All options, sorted by name; free `options` and `text` with PetscFree() after use. Marks none as used. */
PetscErrorCode MpmDatabaseGet(PetscInt *count, MpmDatabaseOption **options, char **text);
/* Those that do not begin with mpm_. */
PetscErrorCode MpmDatabaseGetForeign(PetscInt *count, MpmDatabaseOption **options, char **text);
PetscErrorCode MpmDatabaseIsOurs(const char name[], PetscBool *ours);

/* ---- sources.c ---- */

/*
  Origins of options: files in their order, then the command line. Names as in the database, case aside. A NULL handle
  contains no option.
*/
typedef struct _p_MpmSources *MpmSources;
PetscErrorCode                MpmSourcesCreate(MpmSources *sources);
PetscErrorCode                MpmSourcesDestroy(MpmSources *sources);
/* The next source, a file of this path or none (NULL), has given these options. */
PetscErrorCode MpmSourcesAdd(MpmSources sources, const char path[], PetscOptions options);
/* Reads a file into a database, as the next source. */
PetscErrorCode MpmSourcesInsertFile(MpmSources sources, MPI_Comm comm, PetscOptions options, const char path[],
                                    PetscBool yaml);
/* The number of the last source that gave the option, from 1 on; 0 where none did. */
PetscInt MpmSourcesOrder(MpmSources sources, const char name[]);
/* The file that it gave it in, or NULL. */
const char *MpmSourcesFile(MpmSources sources, const char name[]);

/* An option that a model has taken from the database in force. */
typedef struct {
  char       *there; /* its name there */
  const char *here;  /* and in the model's: the same without the prefix */
  PetscBool   used;
} MpmTakenOption;

/* The options of one model. */
typedef struct MpmDatabase {
  PetscOptions    options; /* NULL: none yet, the database in force is looked at */
  PetscInt        depth;   /* how often entered */
  PetscInt        count;
  MpmTakenOption *taken;
  MpmSources      sources; /* of options that were inserted as text */
} MpmDatabase;

PetscErrorCode MpmDatabaseCreate(MpmDatabase **database);
/* Copies the options in force that begin with the prefix, without it; all of them where it is NULL. Once only. */
PetscErrorCode MpmDatabaseTake(MpmDatabase *database, const char prefix[]);
/* Adds options as they would stand on a command line, files among them. Collective on the model's communicator. */
PetscErrorCode MpmDatabaseInsert(MpmDatabase *database, MPI_Comm comm, const char text[]);
/*
  Between Enter and Leave the model's options are in force; pairs may be nested. Leave marks options used since as used
  in the database that is in force then.
*/
PetscErrorCode MpmDatabaseEnter(MpmDatabase *database);
PetscErrorCode MpmDatabaseLeave(MpmDatabase *database);
PetscErrorCode MpmDatabaseDestroy(MpmDatabase **database);
/* A call with the model's options in force, which are left also where it fails. */
#define MpmDatabaseCall(database, call) \
  do { \
    PetscErrorCode database_error; \
    PetscCall(MpmDatabaseEnter(database)); \
    database_error = (call); \
    PetscCall(MpmDatabaseLeave(database)); \
    PetscCall(database_error); \
  } while (0)

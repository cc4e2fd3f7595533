#pragma once
/*
  The manual of options: each as its reader describes it, printed at once or collected in a catalogue.
*/
#include "options/options.h"

typedef enum {
  MPM_OPTION_NUMBER,
  MPM_OPTION_INTEGER,
  MPM_OPTION_BOOLEAN,
  MPM_OPTION_WORD,
  MPM_OPTION_TEXT,
  MPM_OPTION_FILE,
  MPM_OPTION_NAMES,
  MPM_OPTION_BLOCKS
} MpmOptionType;

#define MPM_COUNT_AXES -1
#define MPM_SCOPES_MAX 32

/* An option as its reader describes it. */
typedef struct {
  const char   *name; /* without the block's prefix */
  const char   *help;
  const char   *unit;     /* NULL where a unit makes no sense */
  const char   *accepts;  /* "> 0", "in (-1, 0.5)", "one of a, b"; empty for anything */
  const char   *fallback; /* the default as text; NULL for none */
  MpmNeed       need;
  PetscBool     lasting;  /* the default lies in the accepted range */
  PetscBool     presence; /* the caller needs to know whether the option is there */
  MpmOptionType type;
  PetscInt      count; /* of values; 0: any number */
  MpmRange      range; /* of numbers */
} MpmOptionSpec;

/* An option of a catalogue; texts are its own. */
typedef struct {
  PetscInt      section; /* index of its heading */
  unsigned      scopes;  /* bit k: of the scope k */
  MpmOptionType type;
  PetscInt      count; /* of values; 0: any number; MPM_COUNT_AXES: by the dimension */
  PetscBool     required;
  MpmRange      range; /* of numbers */
  char         *name;  /* in full, no dash; NAME and BLOCK stand for the names of blocks */
  char         *help, *unit, *accepts;
  char         *fallback; /* default; NULL: none, or optional */
} MpmCatalogueItem;

/* The options of a manual in the order of their readers, in sections. */
typedef struct _p_MpmCatalogue {
  PetscInt          section_count, item_count, scope_count, section_capacity, item_capacity;
  PetscInt          section, scope;         /* where the next option is added */
  char            **sections;               /* headings */
  char             *scopes[MPM_SCOPES_MAX]; /* names, such as those of physics */
  MpmCatalogueItem *items;
} * MpmCatalogue;

PetscErrorCode MpmCatalogueCreate(MpmCatalogue *catalogue);
PetscErrorCode MpmCatalogueDestroy(MpmCatalogue *catalogue);
/*
  From here on, readers with -help add to this catalogue in place of printing; NULL: they print again. For the whole
  process, as PETSc's PetscHelpPrintf.
*/
void MpmCatalogueCollect(MpmCatalogue catalogue);

/* Options from here on are of the scope of this name: an option may be of several. */
PetscErrorCode MpmCatalogueSetScope(MpmCatalogue catalogue, const char name[]);
PetscErrorCode MpmCatalogueAddSection(MpmCatalogue catalogue, const char title[]);
/* A copy of the item, in the section and the scope of now; one that is there under its name gets the scope. */
PetscErrorCode MpmCatalogueAdd(MpmCatalogue catalogue, const MpmCatalogueItem *item);

/* One option and one heading of the manual: printed, or added to the catalogue. */
PetscErrorCode MpmHelpOption(MPI_Comm comm, const char name[], const MpmOptionSpec *spec);
PetscErrorCode MpmHelpHeading(MPI_Comm comm, const char title[]);
/* An option of a catalogue as text of the manual, appended: its name, and its meaning in a column of its own. */
PetscErrorCode MpmCatalogueItemText(const MpmCatalogueItem *item, char **text);
/* True where the option, "mpm_material_clay_E", is the item's, "mpm_material_NAME_E"; case aside. */
PetscBool MpmCatalogueItemIs(const MpmCatalogueItem *item, const char name[]);
/* The catalogue as JSON, appended: an array of options; the keys stand in docs/manual.md. */
PetscErrorCode MpmCatalogueJSON(MpmCatalogue catalogue, MpmTextFile *text);

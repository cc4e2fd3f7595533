#pragma once
/*
  Columns of a table by name: contents of the history. The owner of a number registers its row.
*/
#include "base/base.h"
#include "base/types.h"
#include "talus/parts.h"

typedef struct MpmColumns {
  PetscInt   count;
  MpmColumn *at;
  PetscInt   name_count;
  char     **names; /* of all columns, in their order */
} MpmColumns;

/* Ends of names along the axes. */
extern const char *const MpmAxisParts[MPM_MAX_DIM];

/* Registers a row, whose names are copied; between the row's own and a part stands `of`, the owner of the numbers, or
   nothing where it is NULL. */
PetscErrorCode MpmColumnsAdd(MpmColumns *columns, const char of[], const MpmColumn *row);
/* True where a column has the name. */
PetscBool MpmColumnsHave(const MpmColumns *columns, const char name[]);
/* Values of all columns. Collective. */
PetscErrorCode MpmColumnsFill(const MpmColumns *columns, MpmModel model, PetscReal values[]);
PetscErrorCode MpmColumnsDestroy(MpmColumns *columns);

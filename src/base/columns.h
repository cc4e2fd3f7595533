#pragma once
/*
  Columns of a table by name: contents of the history. The owner of a number registers its row.
*/
#include "base/base.h"
#include "base/types.h"
#include "talus/parts.h"

typedef struct MpmColumnMap MpmColumnMap;

typedef struct MpmColumns {
  PetscInt             count;
  MpmColumn           *at;
  const MpmColumnMap **map; /* by row; NULL: its values have no derivatives */
  PetscInt             name_count;
  char               **names; /* of all columns, in their order */
} MpmColumns;

/*
  Derivatives of a row's values after a step; ctx is the column's.

  along  changes of the values with the points' state at the step's end, and with the balance at the owned nodes
         (residuals, of `block` components)
  pull   adds to `end` the derivative of the sum of weight[k] times value k by that state, and subtracts from lam that
         by the residuals
*/
struct MpmColumnMap {
  PetscErrorCode (*along)(MpmModel model, const MpmColumn *column, const MpmPointVector *end,
                          const PetscReal residual[], PetscReal values[]);
  PetscErrorCode (*pull)(MpmModel model, const MpmColumn *column, const PetscReal weight[], MpmPointVector *end,
                         PetscReal lam[]);
  PetscBool balance; /* values depend on the residuals */
};

/* Derivatives of the row that has been added last. */
void MpmColumnsSetMap(MpmColumns *columns, const MpmColumnMap *map);
/* The row with the column of this name, and its place in the row; -1 where there is none. */
PetscInt MpmColumnsFind(const MpmColumns *columns, const char name[], PetscInt *part);
/* Columns of a row. */
PetscInt MpmColumnWidth(const MpmColumn *row);

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

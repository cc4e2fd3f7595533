#pragma once
/*
  The parameters of laws, read from options: numbers and tables.
*/
#include "base/base.h"
#include "base/types.h"
#include "talus/talus.h"

/*
  Reads one parameter of a law into a number, or into a table that MpmTablesDestroy() frees, or PetscFree() its `value`.
  The other of the two is zero. Collective.
*/
PetscErrorCode MpmParameterRead(const MpmOptions *block, const MpmParameter *parameter, double *value,
                                MpmLawTable *table);
/*
  Reads `count` of them: numbers, and tables, that PetscFree() and MpmTablesDestroy() free. Print: for -help, of a type
  that shares names of parameters with others; nothing is recorded.
*/
PetscErrorCode MpmParametersRead(const MpmOptions *block, PetscInt count, const MpmParameter parameters[],
                                 double **values, MpmLawTable **tables);
PetscErrorCode MpmParametersPrint(const MpmOptions *block, PetscInt count, const MpmParameter parameters[]);
PetscErrorCode MpmTablesDestroy(size_t count, MpmLawTable **table);
/* Text of a body's option initial_STATE, NULL where it is absent; free with PetscFree(). */
PetscErrorCode MpmStateReadInitial(const MpmOptions *block, const MpmStateVariable *variable, char **text);

#pragma once
/*
  Types of terms that callers and plugins have registered.
*/
#include "talus/term.h"

/* The k-th type, in the order of registration; NULL behind the last. */
const MpmTermType *MpmTermTypeAt(PetscInt k);
/* The type of this name; NULL where there is none. */
const MpmTermType *MpmTermTypeFind(const char name[]);

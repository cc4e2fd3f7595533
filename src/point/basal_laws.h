#pragma once
/*
  Laws of the bed that were compiled in (basal/).
*/
#include "talus/point/basal.h"
#include "talus/talus.h"
#include "base/types.h"

/* The law of this name, or NULL. */
const MpmBasalLaw *MpmBasalFind(const char *name);
/* The names of all, NULL-terminated; free the array only. */
PetscErrorCode MpmBasalNames(const char ***names);
/* For -help: every law with its parameters; `block`: of a material. */
PetscErrorCode MpmBasalPrintHelp(const MpmOptions *block);

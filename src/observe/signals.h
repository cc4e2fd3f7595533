#pragma once
#include <petscsys.h>
#include "talus/compat.h"

/* From Catch to Release, SIGTERM, SIGUSR1 and a first SIGINT only leave a note. */
PetscErrorCode MpmSignalsCatch(void);
PetscErrorCode MpmSignalsRelease(void);
PetscBool      MpmSignalsCaught(void);

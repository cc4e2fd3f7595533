#pragma once
/*
  Checks of an options file before it is read.
*/
#include "base/base.h"

/* Refuses a file that cannot be a text of options, and names the line. */
PetscErrorCode MpmOptionsCheckFile(MPI_Comm comm, const char option[], const char path[], PetscBool yaml);
/* Fault of a file in YAML, as "line N ...": no YAML, or an option that stands in it twice; empty for none. */
PetscErrorCode MpmYAMLCheck(const char path[], char fault[], size_t size);

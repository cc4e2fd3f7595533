#pragma once
/*
  What can be said of an options file before it is read.
*/
#include "base/base.h"

/* Is the file a text that can be options, as far as a look tells? Names the line where it is not. */
PetscErrorCode MpmOptionsCheckFile(MPI_Comm comm, const char option[], const char path[], PetscBool yaml);
/* What is wrong with a file in YAML, as "line N ...": no YAML, or an option stands in it twice; empty for nothing. */
PetscErrorCode MpmYAMLCheck(const char path[], char fault[], size_t size);

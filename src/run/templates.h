#pragma once
/*
  Scenes to start from: those of templates/, compiled in.
*/
#include "run/command_line.h"

/* Writes the scene that `talus new` names, or lists them. An existing file is refused. Collective. */
PetscErrorCode MpmTemplateWrite(MPI_Comm comm, const MpmCommandLine *line);

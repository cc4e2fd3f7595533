#pragma once
/*
  The picture of a scene before any run.
*/
#include "talus/talus.h"

/* Draws the scene into a file, by the script of `talus plot`; the files that it reads are removed. Collective. */
PetscErrorCode MpmPictureDraw(MPI_Comm comm, MpmModel model, const char picture[]);

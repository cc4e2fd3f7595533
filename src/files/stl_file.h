#pragma once
/*
  Triangles of STL files, binary or ASCII. The normals that such a file holds are passed over: the order of a triangle's
  corners says where its outside is.
*/
#include "base/base.h"

#define MPM_STL_MESSAGE 512
/*
  Not collective. Nine coordinates a triangle, in the file's unit; free with PetscFree(). A fault of the file goes into
  `message`, which stays as it is where there is none.
*/
PetscErrorCode MpmStlRead(const char *path, PetscInt *count, PetscReal **corners, char message[MPM_STL_MESSAGE]);

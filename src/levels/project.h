#pragma once
/*
  The first coarse operator from the points' tangents and element blocks, where the finest level has no matrix.
*/
#include "action/factored.h"
#include "levels/level.h"

typedef struct MpmProjection MpmProjection;

/*
  Create makes an empty matrix with room for the products of all boxes of the space with `rows`, both borrowed; `local`
  and `count` are coarse nodes of this rank and of all. Take adds P^T K P of an element block to it, as a member of
  MpmElementAction; Coarse describes the coarse functions for the points' tangents; End assembles the matrix, or fails
  where a block before it did.
*/
PetscErrorCode MpmProjectionCreate(const MpmLocalRows *rows, const MpmSpace *space, MPI_Comm comm,
                                   const PetscInt nodes[2], MpmProjection **projection, Mat *mat);
void           MpmProjectionTake(void *projection, PetscInt n, const PetscInt nodes[], const PetscReal element[]);
MpmCoarse      MpmProjectionCoarse(MpmProjection *projection);
PetscErrorCode MpmProjectionEnd(MpmProjection *projection);
PetscErrorCode MpmProjectionDestroy(MpmProjection **projection);

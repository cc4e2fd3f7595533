#pragma once
/*
  The first coarse operator from element blocks, where the finest level has no matrix.
*/
#include "levels/level.h"

typedef struct MpmProjection MpmProjection;

/*
  Create makes an empty matrix with room for the products of all boxes of the space with `rows`, both borrowed; `local`
  and `count` are coarse nodes of this rank and of all. Take adds P^T K P of an element block to it, as a member of
  MpmElementAction; End assembles it, or fails where a block before it did.
*/
PetscErrorCode MpmProjectionCreate(const MpmLocalRows *rows, const MpmSpace *space, MPI_Comm comm,
                                   const PetscInt nodes[2], MpmProjection **projection, Mat *mat);
void           MpmProjectionTake(void *projection, PetscInt n, const PetscInt nodes[], const PetscReal element[]);
PetscErrorCode MpmProjectionEnd(MpmProjection *projection);
PetscErrorCode MpmProjectionDestroy(MpmProjection **projection);

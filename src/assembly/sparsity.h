#pragma once
/*
  The matrix's sparsity, and where contributions go in it (sparsity.c, pattern_blocks.c, pattern_matrix.c).
*/
#include <petscmat.h>
#include "base/base.h"
#include "base/types.h"

/*
  Substitute of the matrix's values (element_action.c): products of the blocks with x, or of their transposes, added to
  y, and diagonal blocks, block^2 values a node; NULL: none. Arrays at the local nodes. Or `take` gets the blocks
  themselves, stored [i][c][c'][j], of n local nodes, -1 for holes.
*/
typedef struct MpmElementAction {
  const PetscReal *x;
  PetscReal       *y, *blocks;
  PetscBool        transposed;
  void (*take)(void *ctx, PetscInt n, const PetscInt nodes[], const PetscReal element[]);
  void *ctx;
} MpmElementAction;

/* Entries that need not stand in a window, by row. */
typedef struct {
  PetscInt *start;  /* local + 1; NULL: there are none */
  PetscInt *column; /* their local nodes, ascending in a row */
  PetscInt *slot;   /* their positions in the row */
} MpmFarEntries;

/*
  The sparsity pattern, in node blocks, and where this rank's contributions go: rows of owned nodes hold what any rank
  adds to them; rows of ghosts hold this rank's part only. Columns are global node numbers, ascending. A row stands in
  the matrix's own array, or, where its columns are not all this rank's, in a buffer with the same order.
*/
typedef struct MpmPattern {
  PetscInt      block, dim, window, reach; /* a row's columns lie in a window of (2*reach + 1)^dim nodes around it */
  PetscInt      local, owned;
  PetscInt     *row;       /* local + 1: where each row's columns start */
  PetscInt     *column;    /* global node numbers */
  PetscInt     *slot;      /* local * window: position in the row, or -1 */
  PetscInt     *neighbour; /* like slot: local nodes; NULL where no node follows others */
  MpmFarEntries far;
  PetscReal   **value; /* per row, row-major: value[i][(c * columns_i + k)*block + c'] */
  PetscReal    *buffer;
  PetscInt64    buffer_size;
  PetscBool     coordinates; /* all rows are in the buffer, and the matrix takes them as coordinates and values */
  PetscScalar  *array;       /* the matrix's, lent between Begin and End; NULL: all rows are in the buffer */
  const MpmConstraints   *constraints; /* whose unknowns are left out, between Begin and End */
  const MpmElementAction *action;      /* NULL: blocks go to the matrix */
} MpmPattern;

/* The pattern of a space, in place of the last one's; `changed`: the rank's rows or columns are others. */
PetscErrorCode MpmPatternSetUp(MpmPattern **pattern, const MpmSpace *space, MPI_Comm comm, PetscInt block,
                               PetscBool *changed);
PetscErrorCode MpmPatternDestroy(MpmPattern **pattern);
PetscErrorCode MpmPatternCreateMat(MpmPattern *pattern, const MpmSpace *space, MPI_Comm comm, MatType type, Mat *mat);
/* Begin and end of adding blocks. Begin zeroes the matrix; End puts the diagonal on constrained rows and assembles. */
PetscErrorCode MpmPatternBegin(MpmPattern *pattern, const MpmSpace *space, const MpmConstraints *constraints, Mat mat);
PetscErrorCode MpmPatternEnd(MpmPattern *pattern, const MpmSpace *space, Mat mat);
/*
  Adds a box's element block, stored [i][c][c'][j]; rows and columns of constrained unknowns, and those of holes, are
  left out.
*/
void MpmPatternAddBlock(MpmPattern *pattern, const MpmSpace *space, const MpmGroup *group, PetscReal element[]);
/*
  Likewise the block of any local nodes, which must be coupled: those of a box and its extra nodes, or of boxes that are
  coupled (space.h).
*/
void MpmPatternAddNodes(MpmPattern *pattern, const MpmSpace *space, PetscInt n, const PetscInt nodes[],
                        PetscReal element[]);
/* Adds a b^T + b c^T to a box, of vectors stored [i][c], likewise; the vectors are changed. */
void MpmPatternAddPair(MpmPattern *pattern, const MpmSpace *space, const MpmGroup *box, PetscReal a[], PetscReal b[],
                       PetscReal c[]);

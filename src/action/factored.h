#pragma once
/*
  The action of the points' tangents by sum factorisation: y += B^T D B x with one contraction an axis.

  Shape functions are products of functions of one coordinate, averaged ones too. The gradient of a point thus takes
  O(n^(dim + 1)) operations where its basis functions take O(n^dim) each. Points are taken in lanes of the processor's
  vectors. Their values along each axis and their tangents stand side by side in memory, in the order of the loops.
*/
#include "base/base.h"
#include "base/types.h"
#include "space/space.h"
#include "space/sum.h"

/* Private (factored_impl.h). */
typedef struct MpmFactored MpmFactored;

/* True where it serves: of one unknown a node, or one an axis, the kernel takes either the gradients or the values, of
   one shape without smoothing. */
PetscBool MpmFactoredServes(const MpmSum *sum);

/*@
  MpmFactoredCreate - make the action for the points of a prepared step

  Not collective

  Input Parameters:
+ sum  - the points and their space; it must outlive the action
. half - the tangents are symmetric: one triangle is kept
- single - they are kept in single precision

  Output Parameter:
. factored - the action; its tangents are zero

  Notes:
  Takes 8 (2 dim n + N) bytes a point, n nodes an axis, N = I (I + 1)/2 numbers with `half`, otherwise I^2, of I inputs;
  with `single` half as much for the N.
@*/
PetscErrorCode MpmFactoredCreate(const MpmSum *sum, PetscBool half, PetscBool single, MpmFactored **factored);
PetscErrorCode MpmFactoredDestroy(MpmFactored **factored);

/* Tangent of the point at place s of the points' order, D[k][l] by the kernel's inputs; PETSC_FALSE where one triangle
   is kept and D has two that differ. */
PetscBool MpmFactoredSetTangent(MpmFactored *factored, PetscInt s, const PetscReal D[]);

/* y += A x, or A^T x, at the local nodes, a value an unknown each. */
void MpmFactoredApply(const MpmFactored *factored, PetscBool transposed, const PetscReal x[], PetscReal y[]);

/* blocks += the diagonal blocks of A, of the unknowns of each local node, row-major. */
void MpmFactoredDiagonal(const MpmFactored *factored, PetscReal blocks[]);

/* Displacements of a box's nodes by those of `count` coarse nodes. Entry e of node i, begin[i] <= e < begin[i + 1], has
   the share share[(e * block + c) * block + d] of component d at coarse node place[e] in component c. */
typedef struct {
  PetscInt         count;
  const PetscInt  *begin, *place;
  const PetscReal *share;
  PetscBool        turned; /* some share couples different components */
} MpmCoarseBox;

/* Coarse functions: `box` describes a box of n local nodes, lent until its next call, without coarse nodes where the
   box is left out; `add` takes the products of its coarse unknowns, node by node, row-major. */
typedef struct {
  void *ctx;
  PetscErrorCode (*box)(void *ctx, PetscInt n, const PetscInt nodes[], MpmCoarseBox *box);
  PetscErrorCode (*add)(void *ctx, const PetscReal block[]);
} MpmCoarse;

/* P^T A P by boxes: some five times the work of a product. */
PetscErrorCode MpmFactoredProject(const MpmFactored *factored, const MpmCoarse *coarse);

/* Least and largest trace of a tangent of each group's points. */
void MpmFactoredRange(const MpmFactored *factored, PetscReal least[], PetscReal most[]);

/* Bytes that it takes. */
size_t MpmFactoredBytes(const MpmFactored *factored);

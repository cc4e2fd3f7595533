#pragma once
/*
  PC type `levels`: multigrid on coarser lattices, and on elements of lower order.
*/
#include "base/base.h"
#include "base/types.h"
#include <petscksp.h>

/* Most levels. */
#define MPM_LEVELS_MOST 12
/* Highest order of elements. */
#define MPM_ORDER 4

/* Choices of the scene (-mpm_multigrid_...). */
typedef struct {
  PetscInt     levels;                   /* 0: auto */
  PetscInt     coarsen;                  /* cells an axis that become one */
  PetscInt     orders, order[MPM_ORDER]; /* of the first levels, that of the finest one included */
  MpmShapeType shape;
  MpmEdgeType  edge;
  PetscBool cells; /* without a matrix: inverses of cells with stiff and soft points, for smoothers of type `cells` */
} MpmLevelsChoice;

struct MpmElementAction;
struct MpmFactored;

/* The step's nodes and conditions on them. For steps without a matrix a sum of element blocks of the Jacobian; of all
   terms but the points where these keep tangents, `factored`, and otherwise of all, with NULL there. */
typedef struct {
  const MpmGrid        *grid;
  const MpmSpace       *space;
  const MpmConstraints *constraints;
  PetscInt              components; /* of a node that the matrix has: the first ones of the constraints' block */
  PetscErrorCode (*tangent)(void *ctx, const struct MpmElementAction *action, const struct MpmFactored **factored);
  void *ctx;
} MpmLevelsStep;

/* Makes the type known to PETSc; true for a preconditioner of that type. */
PetscErrorCode MpmLevelsRegister(void);
PetscErrorCode MpmLevelsIs(PC pc, PetscBool *is);
/* Levels, the finest one included; 0 for a preconditioner of another type, or without levels yet. */
PetscErrorCode MpmLevelsCount(PC pc, PetscInt *count);
/* Data of the levels, borrowed, where the preconditioner is of that type. */
PetscErrorCode MpmLevelsAttach(PC pc, const MpmLevelsChoice *choice, const MpmLevelsStep *step);

#pragma once
/*
  The Jacobian's action on a vector.
*/
#include "action/factored.h"
#include "points/spread_mean.h"

/*
  The Jacobian's action without a matrix. With `stored` each point keeps its tangent, by sum factorisation where that
  serves; otherwise one dual direction makes each product. With `differences` the plain kernel is differenced in place
  of duals.
*/
typedef struct {
  const MpmSum   *sum;
  const MpmTerms *terms;
  PetscBool       differences;
  PetscReal      *u;         /* at the local nodes: where the derivative is taken */
  PetscReal      *tangent;   /* per place in the points' order, or NULL */
  MpmFactored    *factored;  /* in place of `tangent`, or NULL */
  PetscBool       single;    /* its tangents are kept in single precision */
  PetscReal      *mean_flux; /* conjugate to the mean, at each of the ordered points; or NULL */
  PetscReal      *values, *dvalues, *force, *storage;
  MpmBasis        basis;
  MpmCellWork     cell;
  MpmSpreadWork   spread; /* means by shares of domains; its tangents are always kept */
} MpmAction;
/* `single`: tangents are kept in single precision, where they are kept side by side (action/factored.h). */
PetscErrorCode MpmActionCreate(const MpmTerms *terms, const MpmSum *sum, PetscBool stored, PetscBool single,
                               MpmAction *action);
PetscErrorCode MpmActionSetState(MpmAction *action, const PetscReal u[], PetscInt *failed);
/* y += J du at the local nodes, of one unit of the points, of all points, or of all terms. */
PetscErrorCode MpmActionApplyUnit(MpmAction *action, PetscInt unit, const PetscReal du[], PetscReal y[],
                                  PetscInt *failed);
PetscErrorCode MpmActionApplyPoints(MpmAction *action, const PetscReal du[], PetscReal y[], PetscInt *failed);
PetscErrorCode MpmActionApply(MpmAction *action, const PetscReal du[], PetscReal y[], PetscInt *failed);
/* y += J^T v of all terms: the points' kept tangents where there are some, element blocks otherwise. */
PetscErrorCode MpmActionTranspose(MpmAction *action, const PetscReal v[], PetscReal y[], PetscInt *failed);
/* blocks += the diagonal blocks of all terms, block^2 values a local node, row-major. */
PetscErrorCode MpmActionDiagonal(const MpmAction *action, PetscReal blocks[], PetscInt *failed);
PetscErrorCode MpmActionDestroy(MpmAction *action);

#pragma once
/*
  Residuals of Newton's iterates (iterate.c, newton.c).
*/
#include "problem/evaluation.h"
#include "solve/solve.h"

/*
  Sums the residual of disc->nodal.u over the points, force included; leaves it with the nodes' owners, along the axes,
  and the trial with the version of x, whose values those are; NULL: of no vector.
*/
PetscErrorCode MpmSumResidual(MpmSolver *solver, Vec x, MpmMode mode, PetscInt *failed);
/*
  Newton's residual at x, which stays in the problem with its trial: f = internal - external force; on constrained
  unknowns, diagonal * (u - value). Infinite where a point has no answer.
*/
PetscErrorCode MpmNewtonResidual(MpmSolver *solver, Vec x, MpmMode mode, Vec f);

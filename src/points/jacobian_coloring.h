#pragma once
/*
  The Jacobian by directional derivatives of the sums over points (jacobian_coloring.c).
*/
#include "talus/talus.h"
#include "assembly/terms.h"
#include "space/sum.h"

/* By colours, in blocks or one node a colour, or by differences; `pattern` takes the terms' sum, `failed` the points
   without an answer. */
PetscErrorCode MpmJacobianColoring(const MpmTerms *terms, const MpmSum *sum, MpmJacobianType type, const PetscReal u[],
                                   MpmPattern *pattern, PetscInt *failed);

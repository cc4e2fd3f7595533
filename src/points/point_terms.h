#pragma once
/*
  The two terms of the points, as a problem's list has them.
*/
#include "assembly/terms.h"

extern const MpmTerm MpmTermPoints;    /* the physics at the points (residual.c, tangent.c) */
extern const MpmTerm MpmTermCellMeans; /* the physics with a mean over the cell */

/* State of the points at displacements u, into the trial, without their forces; for a physics without means. */
PetscErrorCode MpmPointsUpdate(const MpmSum *sum, const PetscReal u[], const MpmTrial *trial, PetscInt *failed);

#pragma once
/*
  The two terms of the points: the physics point by point, and with a mean over the cell. Their functions stand in
  residual.c, tangent.c and tangent_diagonal.c.
*/
#include "space/point_loop.h"

/* As MpmTerm.points. */
PetscErrorCode MpmPointsTrial(const MpmSum *sum, const PetscReal u[], const MpmTrial *trial, PetscReal residual[],
                              PetscInt *failed);
PetscErrorCode MpmCellsTrial(const MpmSum *sum, const PetscReal u[], const MpmTrial *trial, PetscReal residual[],
                             PetscInt *failed);
PetscErrorCode MpmPointsResidual(const void *ctx, const MpmSum *sum, const PetscReal u[], PetscReal residual[],
                                 PetscInt *failed);
PetscErrorCode MpmCellsResidual(const void *ctx, const MpmSum *sum, const PetscReal u[], PetscReal residual[],
                                PetscInt *failed);
PetscErrorCode MpmPointsDiagonal(const void *ctx, const MpmSum *sum, const PetscReal u[], PetscReal blocks[],
                                 PetscInt *failed);
/* Boxes of the cells' nodes, and the points' shares in them. */
PetscErrorCode MpmCellsBoxes(void *ctx, const MpmRules *rules, const MpmPoints *points, MpmSpace *space);

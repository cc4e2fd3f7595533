#pragma once
/*
  Shape functions of Lagrange elements of order 2 to 4 (shape_element.c); order 1 is that of linear basis functions.
*/
#include "grid/shape.h"

/* MpmShapeEvaluateAll() and MpmShapeExtend(); second derivatives by the place, in cells, of sampled functions; means of
   the functions over a cell. order + 1 values of a cell. */
void MpmElementEvaluateAll(PetscInt order, PetscBool domain, PetscInt count, const MpmShapePlaces *at,
                           const MpmShapeLines *lines);
void MpmElementExtend(PetscInt order, PetscReal xi, PetscReal by, PetscInt edge_lower, PetscInt edge_upper,
                      MpmShapeLine *line);
void MpmElementBend(PetscInt order, PetscReal xi, PetscInt edge_lower, PetscInt edge_upper, PetscReal bend[]);
void MpmElementMean(PetscInt order, PetscReal weight[]);
/* The k-th derivatives at t from the middle of a cell, by cells; and the mass matrix of a cell of size 1. */
void MpmElementDerivatives(PetscInt order, PetscInt k, PetscReal t, PetscReal value[]);
void MpmElementMass(PetscInt order, PetscReal mass[]);

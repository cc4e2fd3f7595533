#pragma once
/*
  The basis functions of a point at its group's nodes, and sums with them: values and gradients of fields, forces and
  fluxes at the nodes, lines and weights by axis. Other folders evaluate and integrate by these functions.
*/
#include "space/space.h"

/*
  The weights and derivatives of one point at its group's nodes, shape by shape: basis[0] weights, basis[1..dim]
  derivatives by x, y, z, basis[dim + 1] weights less their means over the cell, and in the first shape, with axial
  symmetry, basis[MPM_HOOP_BASIS] weights over the radius; each of node_count values, x fastest.
*/
typedef struct {
  PetscReal *basis[MPM_MAX_SHAPES * MPM_BASES];
} MpmBasis;

/* Basis functions of a space, and their places in `storage`, which has room for so many times `nodes` numbers. */
static inline PetscInt MpmBasisCount(const MpmSpace *space)
{
  return space->shapes.count * MPM_BASES;
}
static inline void MpmBasisPlace(const MpmSpace *space, PetscInt nodes, PetscReal storage[], MpmBasis *basis)
{
  for (PetscInt b = 0; b < MpmBasisCount(space); b++) basis->basis[b] = storage + b * nodes;
}
/* Room for the basis functions of any point. */
PetscErrorCode MpmBasisCreate(const MpmSpace *space, MpmBasis *basis);
PetscErrorCode MpmBasisDestroy(MpmBasis *basis);
/* The scene's shape at a point of a group: weights and derivatives. */
void MpmSpaceEvaluate(const MpmSpace *space, const MpmGroup *group, PetscInt point, MpmBasis *basis);

/* ---- at a point: sums over n nodes, values[i] or forces[i] at the group's nodes ---- */

/* sum_i w_i v_i */
MPM_INLINE PetscReal MpmBasisValue(const MpmBasis *basis, PetscInt n, const PetscReal values[])
{
  PetscReal sum = 0.;

  for (PetscInt i = 0; i < n; i++) sum += basis->basis[0][i] * values[i];
  return sum;
}
/* sum_i d w_i / d x_a v_i */
MPM_INLINE PetscReal MpmBasisDerivative(const MpmBasis *basis, PetscInt n, PetscInt a, const PetscReal values[])
{
  PetscReal sum = 0.;

  for (PetscInt i = 0; i < n; i++) sum += basis->basis[1 + a][i] * values[i];
  return sum;
}
/* sum_i w_i v_i over the radius, with axial symmetry; for basis functions with it (MpmSumBasis()). */
MPM_INLINE PetscReal MpmBasisHoop(const MpmBasis *basis, PetscInt n, const PetscReal values[])
{
  PetscReal sum = 0.;

  for (PetscInt i = 0; i < n; i++) sum += basis->basis[MPM_HOOP_BASIS][i] * values[i];
  return sum;
}
/* Basis function b, in the order of MpmBasis, of node i. */
MPM_INLINE PetscReal MpmBasisAt(const MpmBasis *basis, PetscInt b, PetscInt i)
{
  return basis->basis[b][i];
}
/* f_i += w_i f */
MPM_INLINE void MpmBasisAddForce(const MpmBasis *basis, PetscInt n, PetscReal f, PetscReal forces[])
{
  for (PetscInt i = 0; i < n; i++) forces[i] += basis->basis[0][i] * f;
}

/* f_i += q d w_i / d x_a */
MPM_INLINE void MpmBasisAddFlux(const MpmBasis *basis, PetscInt n, PetscInt a, PetscReal q, PetscReal forces[])
{
  for (PetscInt i = 0; i < n; i++) forces[i] += basis->basis[1 + a][i] * q;
}
/* f_i += q w_i over the radius */
MPM_INLINE void MpmBasisAddHoop(const MpmBasis *basis, PetscInt n, PetscReal q, PetscReal forces[])
{
  for (PetscInt i = 0; i < n; i++) forces[i] += basis->basis[MPM_HOOP_BASIS][i] * q;
}

/* ---- with the arrays of the local nodes, `stride` values a node, of which the first `components` take part ---- */

/* value_c += sum_i w_i u_ic */
void MpmBasisInterpolate(const MpmSpace *space, const MpmGroup *group, const MpmBasis *basis, PetscInt stride,
                         const PetscReal u[], PetscInt components, PetscReal value[]);
/* sum of the weights of the marked nodes */
PetscReal MpmBasisMarked(const MpmSpace *space, const MpmGroup *group, const MpmBasis *basis, const PetscBool mark[]);
/* |grad w_i| of the nodes of a group, 1/m; returns their sum. */
PetscReal MpmBasisGradients(const MpmSpace *space, const MpmGroup *group, const MpmBasis *basis, PetscReal size[]);

/* ---- by component ---- */

/* Weights and derivatives of each component of the physics, c*(dim + 1) and behind (talus/term.h). */
typedef const PetscReal *MpmBases[MPM_MAX_BLOCK * (MPM_MAX_DIM + 1)];
void                     MpmBasisList(const MpmLayout *layout, const MpmBasis *basis, MpmBases list);

/* ---- along an axis ---- */

/* Weight of node i of the group in the plane across an axis, by the other axes alone. */
PetscReal MpmSpaceWeightAcross(const MpmSpace *space, const MpmGroup *group, PetscInt point, PetscInt axis, PetscInt i);
/* True where a point touches node i of its group: a weight, or a derivative in cells of size h, above `graze` on each
   axis. */
PetscBool MpmSpaceTouches(const MpmSpace *space, const MpmGroup *group, PetscInt point, PetscInt i, const PetscReal h[],
                          PetscReal graze);
/* 1 over the radius of a point, 1/m; 0 without axial symmetry. */
static inline PetscReal MpmSpaceHoop(const MpmSpace *space, PetscInt point)
{
  return space->shapes.at[0].hoop ? space->shapes.at[0].hoop[point] : 0.;
}

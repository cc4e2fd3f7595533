#pragma once
/*
  The scene's shape functions of one point, at the nodes of its group: by axis, as displacement gradient, and as the
  forces that go with a body force and a stress (point_shape.c).
*/
#include "base/base.h"
#include "base/types.h"
#include "space/basis.h"

/* Forces of a point: on its own, N; the stress of its domain, Pa, xx, yy, xy, zz, yz, xz (2D: the first three, and the
   hoop stress); volume, m3. */
typedef struct {
  PetscReal body[MPM_MAX_DIM], stress[6], volume;
} MpmPointForce;

/* True where the space has axial symmetry. */
static inline PetscBool MpmSpaceIsAxial(const MpmSpace *space)
{
  return (PetscBool)(space->shapes.at[0].hoop != NULL);
}
/* line[i] = w_i + way grad w_i on an axis, at the group's `count` nodes: displacements go on from the point, m. */
void MpmPointLine(const MpmSpace *space, PetscInt point, PetscInt axis, PetscInt count, PetscReal way,
                  PetscReal line[]);
/* line[i] += way grad w_i */
void MpmPointAddSlope(const MpmSpace *space, PetscInt point, PetscInt axis, PetscInt count, PetscReal way,
                      PetscReal line[]);
/* weight[i] of a group's nodes, the product of those on its axes. */
void MpmLinesMultiply(PetscInt dim, const MpmGroup *group, PetscReal (*line)[MPM_MAX_WIDTH], PetscReal weight[]);

/* The functions themselves, by node. */
static inline PetscReal *MpmBasisWeights(const MpmBasis *basis)
{
  return basis->basis[0];
}
/* gradient[c][d] = sum_i u_i,c grad_d w_i of a group's point, of which `basis` are the functions; 0 elsewhere. */
void MpmBasisGradient(const MpmBasis *basis, const MpmGroup *group, const MpmSum *sum, const PetscReal u[],
                      PetscReal gradient[3][3]);
/* along . grad w_i */
PetscReal MpmBasisSlope(const MpmBasis *basis, PetscInt dim, PetscInt i, const PetscReal along[]);
/* y_i += factor w_i value, of dim components each. */
void MpmWeightsAdd(const PetscReal weight[], const MpmGroup *group, const MpmSum *sum, PetscReal factor,
                   const PetscReal value[], PetscReal y[]);
/* y_i += w_i body - volume stress grad w_i, and the hoop stress times w_i over the radius. */
void MpmPointAddForce(const MpmSum *sum, const MpmBasis *basis, const MpmGroup *group, PetscInt point,
                      const MpmPointForce *force, PetscReal y[]);

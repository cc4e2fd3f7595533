#pragma once
/*
  A block of material within a grid of cells of length 1, and its place in the cells: 6 x 6 of 12 x 12 cells, or
  3 x 3 x 3 of 8 x 8 x 8, with 2 points a cell on each axis.
*/
#include "scene.h"

#define BLOCK_DRY "-mpm_material_m_type hencky -mpm_material_m_E 1e6 -mpm_material_m_nu 0.3 "
#define BLOCK_WET \
  "-mpm_physics poro -mpm_material_m_type linear_elastic -mpm_material_m_E 1e6 -mpm_material_m_nu 0.25 " \
  "-mpm_material_m_porosity 0.4 -mpm_material_m_permeability 1e-9 "

/* All shapes: splines of degree 1 to 3. */
static const char *const block_shapes[] = {"linear", "gimp", "bspline2", "bspline3", "gimp_bspline2"};
#define BLOCK_SHAPES PETSC_STATIC_ARRAY_LENGTH(block_shapes)

/* The block of one of these materials; further options may replace the block's own. */
static inline PetscErrorCode BlockCreate(PetscInt dim, const char *shape, const char *material, const char *further,
                                         MpmModel *model)
{
  char options[2048];

  PetscFunctionBeginUser;
  PetscCall(PetscSNPrintf(
    options, sizeof(options),
    "-mpm_dim %d -mpm_grid_lower %s -mpm_grid_upper %s -mpm_grid_cells %s -mpm_shape %s -mpm_materials m %s "
    "-mpm_bodies b -mpm_body_b_material m -mpm_body_b_region box -mpm_body_b_lower %s -mpm_body_b_upper %s "
    "-mpm_time_step 0.25 -pc_type jacobi %s",
    (int)dim, dim == 2 ? "0,0" : "0,0,0", dim == 2 ? "12,12" : "8,8,8", dim == 2 ? "12,12" : "8,8,8", shape, material,
    dim == 2 ? "3,3" : "2,2,2", dim == 2 ? "9,9" : "5,5,5", further));
  PetscCall(SceneCreate(PETSC_COMM_WORLD, NULL, options, model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* All points move by the same part of a cell. */
static inline PetscErrorCode BlockShift(MpmModel model, PetscReal part)
{
  MpmPoints points;

  PetscFunctionBeginUser;
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  for (PetscInt k = 0; k < points.count * model->disc.dim; k++)
    points.x[k] += part * model->disc.h[k % model->disc.dim];
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static inline PetscReal BlockPower(PetscInt node, PetscInt power)
{
  return PetscPowRealInt(0.2 * ((PetscReal)node - 6.), power);
}

/* Coefficient of a node on one axis in a spline with powers as coefficients; at a not-a-knot end the spline's value. */
static inline PetscReal BlockCoefficient(MpmModel model, PetscInt node, PetscInt cells, PetscInt power)
{
  const PetscInt degree = MpmShapeDegree(model->scene.shape.type);

  if (model->scene.shape.edge == MPM_EDGE_LINEAR || degree == 1 || (node > 0 && node < cells))
    return BlockPower(node, power);
  if (degree == 2)
    return (BlockPower(node - 1, power) + 6. * BlockPower(node, power) + BlockPower(node + 1, power)) / 8.;
  return (BlockPower(node - 1, power) + 4. * BlockPower(node, power) + BlockPower(node + 1, power)) / 6.;
}

/* The coefficient of a local node for sum_a x_a^power. */
static inline PetscReal BlockPolynomial(MpmModel model, PetscInt i, PetscInt power)
{
  const PetscInt dim   = model->disc.dim;
  PetscReal      value = 0.;

  for (PetscInt a = 0; a < dim; a++)
    value += BlockCoefficient(model, model->disc.space->node[i * dim + a], model->disc.grid->cells[a], power);
  return value;
}

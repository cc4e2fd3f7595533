/*
  Dirichlet conditions on nodes, and the walls that they make for the shape functions.
*/
#include "mpmimpl.h"

/* The component of this name in the layout, or -1. */
static PetscInt FindComponent(const MpmLayout *layout, const char *name)
{
  for (PetscInt c = 0; c < layout->block; c++)
    if (!strcmp(layout->component_name[c], name)) return c;
  return -1;
}

/* A region that holds no node of the grid is an error; the search ends at the first node found. */
static PetscErrorCode CheckRegion(const MpmOptions *block, const MpmGrid *grid, MpmRegion region)
{
  PetscReal lower[MPM_MAX_DIM], upper[MPM_MAX_DIM], x[MPM_MAX_DIM];
  PetscInt  first[MPM_MAX_DIM] = {0, 0, 0}, last[MPM_MAX_DIM] = {0, 0, 0}, node[MPM_MAX_DIM];

  PetscFunctionBeginUser;
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    lower[a] = grid->lower[a];
    upper[a] = grid->upper[a];
  }
  PetscCall(MpmRegionGetBounds(region, lower, upper));
  for (PetscInt a = 0; a < grid->dim; a++) {
    first[a] = PetscMax((PetscInt)PetscCeilReal((lower[a] - grid->lower[a]) / grid->h[a] - MPM_TOLERANCE), 0);
    last[a] =
      PetscMin((PetscInt)PetscFloorReal((upper[a] - grid->lower[a]) / grid->h[a] + MPM_TOLERANCE), grid->nodes[a] - 1);
  }
  for (node[2] = first[2]; node[2] <= last[2]; node[2]++) {
    for (node[1] = first[1]; node[1] <= last[1]; node[1]++) {
      for (node[0] = first[0]; node[0] <= last[0]; node[0]++) {
        for (PetscInt a = 0; a < grid->dim; a++) x[a] = grid->lower[a] + grid->h[a] * (PetscReal)node[a];
        if (MpmRegionContains(region, x)) PetscFunctionReturn(PETSC_SUCCESS);
      }
    }
  }
  MpmCheckInput(PETSC_FALSE, "-%sregion: there is no node of the grid in it", block->prefix);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmConditionCreate(const MpmOptions *options, const char *name, const MpmGrid *grid,
                                  const MpmLayout *layout, MpmCondition *bc)
{
  char       prefix[256], **components;
  MpmOptions block = {options->comm, prefix, options->record};
  PetscReal  tolerance[MPM_MAX_DIM];
  PetscInt   count;

  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(bc, sizeof(*bc)));
  PetscCall(PetscSNPrintf(prefix, sizeof(prefix), "mpm_bc_%s_", name));
  PetscCall(PetscStrallocpy(name, &bc->name));
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) tolerance[a] = MPM_TOLERANCE * grid->h[a];
  PetscCall(MpmOptionsHeading(&block, "Condition"));
  PetscCall(MpmRegionCreate(&block, grid->dim, tolerance, &bc->region));
  if (!MpmOptionsHelp()) PetscCall(CheckRegion(&block, grid, bc->region));
  PetscCall(
    MpmOptionsNames(&block, "components", "which unknowns are held: x, y, z, p", MPM_REQUIRED, &count, &components));
  MpmCheckInput(count <= layout->block, "-%scomponents: %" PetscInt_FMT " given, a node has %" PetscInt_FMT " unknowns",
                prefix, count, layout->block);
  for (PetscInt k = 0; k < count; k++) {
    bc->component[k] = FindComponent(layout, components[k]);
    if (bc->component[k] < 0 && !strcmp(components[k], "p")) bc->component[k] = FindComponent(layout, "pressure");
    MpmCheckInput(bc->component[k] >= 0, "-%scomponents %s: this scene has no such unknown", prefix, components[k]);
  }
  bc->component_count = count;
  PetscCall(MpmNamesDestroy(count, &components));
  PetscCall(MpmOptionsReals(&block, "value", "m or Pa", "prescribed values, one a component", MPM_RANGE_ANY,
                            MPM_OPTIONAL, count, bc->value, NULL));
  PetscCall(MpmRampCreate(&block, "ramp", "0:1", &bc->ramp));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmConditionDestroy(MpmCondition *bc)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(bc->name));
  PetscCall(MpmRegionDestroy(&bc->region));
  PetscCall(MpmRampDestroy(&bc->ramp));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmConditionGetWalls(const MpmCondition *bc, const MpmGrid *grid, PetscInt *count, MpmWall walls[])
{
  PetscFunctionBeginUser;
  *count = 0;
  if (MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  if (MpmRegionGetType(bc->region) != MPM_REGION_BOX) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt k = 0; k < bc->component_count; k++) {
    const PetscInt axis = bc->component[k];
    PetscInt       first, last;
    MpmWall        wall = {.axis = axis};

    if (axis >= grid->dim) continue; /* not a displacement */
    for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
      wall.lower[a] = PETSC_NINFINITY;
      wall.upper[a] = PETSC_INFINITY;
    }
    PetscCall(MpmRegionGetBounds(bc->region, wall.lower, wall.upper));
    /* the outermost planes of held nodes; at the grid's edges there is nothing to add */
    first =
      (PetscInt)PetscCeilReal(PetscMax((wall.lower[axis] - grid->lower[axis]) / grid->h[axis], 0.) - MPM_TOLERANCE);
    last = (PetscInt)PetscFloorReal(
      PetscMin((wall.upper[axis] - grid->lower[axis]) / grid->h[axis], (PetscReal)grid->nodes[axis]) + MPM_TOLERANCE);
    if (first > last) continue;
    if (last > 0 && last < grid->nodes[axis] - 1) {
      wall.node         = last;
      wall.side         = 1;
      walls[(*count)++] = wall;
    }
    if (first > 0 && first < grid->nodes[axis] - 1) {
      wall.node         = first;
      wall.side         = -1;
      walls[(*count)++] = wall;
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmConstraintsReset(MpmConstraints *constraints)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(constraints->condition));
  PetscCall(PetscFree(constraints->value));
  constraints->any = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmConstraintsSetUp(MpmConstraints *constraints, PetscInt bc_count, const MpmCondition bcs[],
                                   const MpmGrid *grid, const MpmLayout *layout, const MpmSpace *space,
                                   PetscReal time_n, PetscReal time)
{
  const PetscInt bs = layout->block;

  PetscFunctionBeginUser;
  PetscCall(MpmConstraintsReset(constraints));
  PetscCall(PetscMalloc1((space->local * bs), &constraints->condition));
  PetscCall(PetscCalloc1((space->local * bs), &constraints->value));
  for (PetscInt k = 0; k < space->local * bs; k++) constraints->condition[k] = -1;
  for (PetscInt b = 0; b < bc_count; b++) {
    const PetscReal start = bcs[b].start, now = MpmRampEvaluate(bcs[b].ramp, time - start),
                    before = time_n > start ? MpmRampEvaluate(bcs[b].ramp, time_n - start) : 0.;

    for (PetscInt i = 0; bcs[b].active && i < space->local; i++) {
      PetscReal x[MPM_MAX_DIM];

      for (PetscInt a = 0; a < grid->dim; a++)
        x[a] = grid->lower[a] + grid->h[a] * (PetscReal)space->node[i * grid->dim + a];
      if (!MpmRegionContains(bcs[b].region, x)) continue;
      for (PetscInt k = 0; k < bcs[b].component_count; k++) {
        const PetscInt c = bcs[b].component[k];

        constraints->condition[i * bs + c] = b;
        constraints->value[i * bs + c]     = bcs[b].value[k] * (layout->increment[c] ? now - before : now);
        constraints->any                   = PETSC_TRUE;
      }
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

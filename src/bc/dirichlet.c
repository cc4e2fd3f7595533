/*
  Dirichlet conditions on nodes, and the walls that they make for the shape functions.

  A condition prescribes components of the unknowns at the nodes of its region, or the displacement along a normal,
  where the tangential motion is free. Its value is the total since the start, value times ramp. A step prescribes the
  increment from its beginning to its end, independent of the displacement of the node before. Nodes do not move with
  the material; where the grid moves, regions select nodes by their places in the grid as it was read.
*/
#include "options/options.h"
#include "geometry/geometry.h"
#include "point/layout.h"
#include "grid/grid.h"
#include "grid/walls.h"
#include "bc/bc.h"

/* The component of this name in the layout, or -1. */
static PetscInt FindComponent(const MpmLayout *layout, const char *name)
{
  for (PetscInt c = 0; c < layout->block; c++) {
    if (!strcmp(layout->component[c].name, name)) return c;
    if (layout->component[c].symbol && !strcmp(layout->component[c].symbol, name)) return c;
  }
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
    const PetscInt order = grid->order;

    /* vertices; within cells nodes beside them, too */
    first[a] = (PetscInt)PetscCeilReal((lower[a] - grid->lower[a]) / grid->h[a] - MPM_TOLERANCE) * order - order + 1;
    last[a]  = (PetscInt)PetscFloorReal((upper[a] - grid->lower[a]) / grid->h[a] + MPM_TOLERANCE) * order + order - 1;
    first[a] = PetscMax(first[a], 0);
    last[a]  = PetscMin(last[a], grid->nodes[a] - 1);
  }
  for (node[2] = first[2]; node[2] <= last[2]; node[2]++) {
    for (node[1] = first[1]; node[1] <= last[1]; node[1]++) {
      for (node[0] = first[0]; node[0] <= last[0]; node[0]++) {
        for (PetscInt a = 0; a < grid->dim; a++) x[a] = MpmGridNodeAt(grid, a, node[a]);
        if (MpmRegionContains(region, x)) PetscFunctionReturn(PETSC_SUCCESS);
      }
    }
  }
  MpmCheckInput(PETSC_FALSE, "-%sregion: there is no node of the grid in it", block->prefix);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Which unknowns are prescribed, and their values. */
static PetscErrorCode ReadComponents(const MpmOptions *block, const MpmLayout *layout, MpmCondition *bc)
{
  char   **components;
  PetscInt count;

  PetscFunctionBeginUser;
  PetscCall(
    MpmOptionsNames(block, "components",
                    "which unknowns are prescribed: x, y, z, or those of the physics' other fields (or give a normal)",
                    MPM_REQUIRED, &count, &components));
  MpmCheckInput(count <= layout->block, "-%scomponents: %" PetscInt_FMT " given, a node has %" PetscInt_FMT " unknowns",
                block->prefix, count, layout->block);
  for (PetscInt k = 0; k < count; k++) {
    bc->component[k] = FindComponent(layout, components[k]);
    MpmCheckInput(bc->component[k] >= 0, "-%scomponents %s: this scene has no such unknown", block->prefix,
                  components[k]);
  }
  bc->component_count = count;
  PetscCall(MpmNamesDestroy(count, &components));
  PetscCall(MpmOptionsReals(block, "value", "m or Pa", "prescribed values, one a component, or one along the normal",
                            MPM_RANGE_ANY, MPM_OPTIONAL, count, bc->value, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The normal, and the value along it. */
static PetscErrorCode ReadNormal(const MpmOptions *block, PetscInt dim, MpmCondition *bc)
{
  PetscBool components;
  PetscReal norm;

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsHas(block, "components", &components));
  PetscCall(
    MpmOptionsReals(block, "normal", "-",
                    "direction along which the displacement is prescribed, of any length but 0; across it is free",
                    MPM_RANGE_ANY, MPM_OPTIONAL, dim, bc->normal, &bc->inclined));
  if (MpmOptionsHelp()) bc->inclined = PETSC_FALSE;
  if (!bc->inclined) PetscFunctionReturn(PETSC_SUCCESS);
  MpmCheckInput(!components, "-%snormal and -%scomponents: give one of them, not both", block->prefix, block->prefix);
  norm = hypot(hypot(bc->normal[0], bc->normal[1]), bc->normal[2]);
  MpmCheckInput(norm > 0. && norm < PETSC_INFINITY, "-%snormal: the direction has no length", block->prefix);
  for (PetscInt a = 0; a < dim; a++) {
    bc->normal[a] /= norm;
    bc->component[a] = a;
  }
  bc->component_count = dim;
  PetscCall(MpmOptionsReals(block, "value", "m", "prescribed value along the normal", MPM_RANGE_ANY, MPM_OPTIONAL, 1,
                            bc->value, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The axis along which the region has the least extent: dashpots stand on a plane across it. */
static PetscErrorCode ReadAbsorbing(const MpmOptions *block, const MpmGrid *grid, MpmCondition *bc)
{
  PetscReal lower[MPM_MAX_DIM], upper[MPM_MAX_DIM], thinnest = PETSC_INFINITY;

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsBool(block, "absorbing",
                           "prescribes nothing: the nodes, on a plane where the material ends, have dashpots that take "
                           "waves out; value is then the velocity of a wave that comes in through them",
                           &bc->absorbing, NULL));
  if (!bc->absorbing || MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    lower[a] = grid->lower[a];
    upper[a] = grid->upper[a];
  }
  PetscCall(MpmRegionGetBounds(bc->region, lower, upper));
  for (PetscInt a = 0; a < grid->dim; a++) {
    if ((upper[a] - lower[a]) / grid->h[a] >= thinnest) continue;
    thinnest   = (upper[a] - lower[a]) / grid->h[a];
    bc->across = a;
  }
  MpmCheckInput(thinnest < 1., "-%sabsorbing: the region must be a plane of nodes, and is %g cells thick",
                block->prefix, (double)thinnest);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Components of an absorbing condition: all directions where none is named. */
static PetscErrorCode ReadDirections(const MpmOptions *block, const MpmLayout *layout, MpmCondition *bc)
{
  PetscBool given;

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsHas(block, "components", &given));
  if (given) {
    PetscCall(ReadComponents(block, layout, bc));
    for (PetscInt k = 0; k < bc->component_count; k++)
      MpmCheckInput(bc->component[k] < layout->dim, "-%sabsorbing: its components must be directions, x, y or z",
                    block->prefix);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  bc->component_count = layout->dim;
  for (PetscInt a = 0; a < layout->dim; a++) bc->component[a] = a;
  PetscCall(MpmOptionsReals(block, "value", "m/s", "velocity of the wave that comes in, one a direction", MPM_RANGE_ANY,
                            MPM_OPTIONAL, layout->dim, bc->value, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads the quantity of the values, and their course in time. */
static PetscErrorCode ReadTime(const MpmOptions *block, const MpmLayout *layout, MpmCondition *bc)
{
  static const char *const quantities[] = {"displacement", "velocity", "acceleration", NULL};
  PetscInt                 quantity     = bc->absorbing ? MPM_VELOCITY : MPM_DISPLACEMENT;
  PetscBool                ramp, value;

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsWord(block, "quantity",
                           "what value times ramp is of the prescribed displacement, or of the wave that comes in: "
                           "itself, m; velocity, m/s, or acceleration, m/s2, in stages with inertia",
                           quantities, MPM_OPTIONAL, &quantity, NULL));
  bc->quantity = (MpmQuantity)quantity;
  for (PetscInt k = 0; k < bc->component_count && quantity && !MpmOptionsHelp(); k++)
    MpmCheckInput(bc->component[k] < layout->motion, "-%squantity %s: its components must be directions, x, y or z",
                  block->prefix, quantities[quantity]);
  PetscCall(MpmOptionsHas(block, "ramp", &ramp));
  PetscCall(MpmRampReadTable(block, "table", (PetscBool)(quantity > 0), &bc->ramp));
  MpmCheckInput(!bc->ramp || !ramp || MpmOptionsHelp(),
                "-%sramp: must not be given beside -%stable, which has the factor by time", block->prefix,
                block->prefix);
  PetscCall(MpmOptionsHas(block, "value", &value));
  for (PetscInt k = 0; bc->ramp && !value && k < bc->component_count; k++) bc->value[k] = 1.;
  if (!bc->ramp) PetscCall(MpmRampCreate(block, "ramp", "0:1", &bc->ramp));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Conditions prescribe; friction, adhesion and parting need the faces of the material, which boundaries have. */
static PetscErrorCode RefuseContact(const MpmOptions *block, const char *name)
{
  static const char *const words[] = {"friction", "adhesion", "contact", "unilateral", "stick"};
  PetscBool                has;

  PetscFunctionBeginUser;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(words) && !MpmOptionsHelp(); k++) {
    PetscCall(MpmOptionsHas(block, words[k], &has));
    MpmCheckInput(
      !has,
      "-%s%s: a condition prescribes its nodes' unknowns; a boundary of type plane, -mpm_boundaries %s, has friction "
      "and lets go",
      block->prefix, words[k], name);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmConditionCreate(const MpmOptions *options, const char *name, const MpmGrid *grid,
                                  const MpmLayout *layout, MpmCondition *bc)
{
  char       prefix[256];
  MpmOptions block = {options->comm, prefix, options->record};
  PetscReal  tolerance[MPM_MAX_DIM];

  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(bc, sizeof(*bc)));
  PetscCall(PetscSNPrintf(prefix, sizeof(prefix), "mpm_bc_%s_", name));
  PetscCall(PetscStrallocpy(name, &bc->name));
  bc->motion = layout->motion;
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) tolerance[a] = MPM_TOLERANCE * grid->h[a];
  PetscCall(MpmOptionsHeading(&block, "Condition"));
  PetscCall(RefuseContact(&block, name));
  PetscCall(MpmRegionCreate(&block, grid->dim, tolerance, &bc->region));
  if (!MpmOptionsHelp()) PetscCall(CheckRegion(&block, grid, bc->region));
  PetscCall(ReadAbsorbing(&block, grid, bc));
  PetscCall(ReadNormal(&block, grid->dim, bc));
  MpmCheckInput(!bc->inclined || !bc->absorbing, "-%snormal and -%sabsorbing: give one of them, not both", prefix,
                prefix);
  MpmCheckInput(layout->motion || !(bc->inclined || bc->absorbing), "-%s%s: the physics has no displacement", prefix,
                bc->inclined ? "normal" : "absorbing");
  if (bc->absorbing && !MpmOptionsHelp()) PetscCall(ReadDirections(&block, layout, bc));
  else if (!bc->inclined) PetscCall(ReadComponents(&block, layout, bc));
  PetscCall(ReadTime(&block, layout, bc));
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

/* Least and largest displacement that a condition prescribes along an axis; PETSC_FALSE where it prescribes none. */
static PetscBool MotionAlong(const MpmCondition *bc, PetscInt axis, PetscReal *least, PetscReal *most)
{
  PetscReal value = 0., low, high;
  PetscBool held  = PETSC_FALSE;

  if (bc->absorbing) { /* the material ends on its plane */
    *least = *most = 0.;
    return (PetscBool)(axis == bc->across);
  }
  if (bc->inclined) { /* only where the normal is the axis does it hold the material back */
    held  = (PetscBool)(PetscAbsReal(bc->normal[axis]) == 1.);
    value = bc->value[0] * bc->normal[axis];
  } else {
    for (PetscInt k = 0; k < bc->component_count; k++) {
      if (bc->component[k] != axis || axis >= bc->motion) continue;
      held  = PETSC_TRUE;
      value = bc->value[k];
    }
  }
  if (bc->quantity == MPM_DISPLACEMENT) MpmRampBounds(bc->ramp, &low, &high);
  else {
    low  = PETSC_NINFINITY;
    high = PETSC_INFINITY;
    if (value == 0.) low = high = 0.;
  }
  *least = PetscMin(0., PetscMin(value * low, value * high));
  *most  = PetscMax(0., PetscMax(value * low, value * high));
  return held;
}

PetscBool MpmConditionFixes(const MpmCondition *bc, PetscInt axis)
{
  PetscReal least, most;

  return (PetscBool)(!bc->absorbing && MotionAlong(bc, axis, &least, &most) && least == 0. && most == 0.);
}

PetscErrorCode MpmConditionGetWalls(const MpmCondition *bc, const MpmGrid *grid, PetscBool spline, PetscInt *count,
                                    MpmWall walls[])
{
  PetscFunctionBeginUser;
  *count = 0;
  if (MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  if (MpmRegionGetType(bc->region) != MPM_REGION_BOX) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt axis = 0; axis < grid->dim; axis++) {
    PetscInt  first, last;
    PetscReal least, most, from, to; /* from, to: bounds of the region, cells */
    PetscBool above, below;
    MpmWall   wall = {.axis = axis};

    if (!MotionAlong(bc, axis, &least, &most)) continue;
    for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
      wall.lower[a] = PETSC_NINFINITY;
      wall.upper[a] = PETSC_INFINITY;
    }
    PetscCall(MpmRegionGetBounds(bc->region, wall.lower, wall.upper));
    /* the outermost planes of constrained vertices; at the grid's edges there is nothing to add */
    from  = PetscMax((wall.lower[axis] - grid->start_lower[axis]) / grid->start_h[axis], 0.);
    to    = PetscMin((wall.upper[axis] - grid->start_lower[axis]) / grid->start_h[axis], grid->cells[axis] + 1.);
    first = (PetscInt)PetscCeilReal(from - MPM_TOLERANCE);
    last  = (PetscInt)PetscFloorReal(to + MPM_TOLERANCE);
    if (first > last) continue;
    /* material that is drawn across the plane must not be cut there; splines need the end that a wall gives them */
    above = (PetscBool)(spline || least == 0.);
    below = (PetscBool)(spline || most == 0.);
    if (above && last > 0 && last < grid->cells[axis]) {
      wall.node         = last;
      wall.side         = 1;
      walls[(*count)++] = wall;
    }
    if (below && first > 0 && first < grid->cells[axis]) {
      wall.node         = first;
      wall.side         = -1;
      walls[(*count)++] = wall;
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

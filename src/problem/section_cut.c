/*
  Places of the cuts of sections, and of nodes and points at the step's end.

  The ramp stays within the material: a plane nearer to its end than half the width is moved there, and further where
  the nodes of the end follow: all that these follow lie beyond the ramp.
*/
#include "geometry/geometry.h"
#include "grid/grid.h"
#include "space/point_loop.h"
#include "bc/bc.h"
#include "problem/section_cut.h"

PetscReal MpmCutDistance(const MpmSection *section, PetscInt dim, const PetscReal y[])
{
  PetscReal d = 0.;

  for (PetscInt a = 0; a < dim; a++) d += (y[a] - section->first[a]) * section->axis[0][a];
  return d;
}

PetscBool MpmCutIsChosen(const MpmCutPlane *plane, PetscInt p)
{
  return (PetscBool)(!plane->chosen || plane->chosen[p] != 0.);
}

PetscBool MpmCutAnyChosen(const MpmCutPass *pass, const MpmCutPlane *plane, const MpmGroup *group)
{
  for (PetscInt s = group->point_begin; s < group->point_end; s++)
    if (MpmCutIsChosen(plane, pass->sum->space->order[s])) return PETSC_TRUE;
  return PETSC_FALSE;
}

void MpmCutPlaceNodes(MpmCutPass *pass)
{
  const MpmSpace *space = pass->sum->space;
  const MpmGrid  *grid  = pass->sum->grid;
  const PetscInt  dim   = space->dim;

  for (PetscInt i = 0; i < space->local; i++) {
    PetscInt at[MPM_MAX_DIM];

    if (MpmSpaceIsExtra(space, i)) continue;
    MpmSpaceAt(space, &space->node[i * dim], at);
    for (PetscInt a = 0; a < dim; a++) {
      pass->place[i * dim + a] = MpmGridNodeAt(grid, a, at[a]);
      pass->place[i * dim + a] += pass->u[i * pass->sum->block + a];
    }
  }
}

PetscInt MpmCutFollower(const MpmCutPass *pass, PetscInt node, PetscInt c)
{
  const PetscInt *of = pass->sum->space->extension.of;

  if (!of || of[node] < 0 || pass->constraints->condition[node * pass->sum->block + c] != MPM_FOLLOWS) return -1;
  return of[node];
}

static PetscInt AnyFollower(const MpmCutPass *pass, PetscInt node)
{
  PetscInt f = -1;

  for (PetscInt c = 0; c < pass->sum->space->dim && f < 0; c++) f = MpmCutFollower(pass, node, c);
  return f;
}

static void Widen(const MpmCutPass *pass, const MpmSection *section, PetscInt node, PetscReal range[2])
{
  const PetscInt  dim = pass->sum->space->dim;
  const PetscReal d   = MpmCutDistance(section, dim, &pass->place[node * dim]);

  range[0] = PetscMin(range[0], d);
  range[1] = PetscMax(range[1], d);
}

/* The range of those that lead a follower. */
static void MeasureMasters(const MpmCutPass *pass, const MpmSection *section, PetscInt f, PetscReal range[2])
{
  const MpmExtension *extension = &pass->sum->space->extension;

  for (PetscInt k = extension->offset[f]; k < extension->offset[f + 1]; k++)
    Widen(pass, section, extension->master[k], range);
}

void MpmCutMeasureNodes(const MpmCutPass *pass, const MpmSection *section, const MpmGroup *group, PetscBool own,
                        PetscReal range[2])
{
  range[0] = PETSC_INFINITY;
  range[1] = PETSC_NINFINITY;
  for (PetscInt i = 0; i < group->node_count; i++) {
    const PetscInt node = pass->sum->space->group_nodes[group->node_offset + i], f = AnyFollower(pass, node);

    if (f < 0 || !own) Widen(pass, section, node, range);
    if (f >= 0) MeasureMasters(pass, section, f, range);
  }
}

void MpmCutPlacePoint(const MpmCutPass *pass, const MpmGroup *group, PetscInt p, PetscReal y[])
{
  const MpmSpace *space = pass->sum->space;
  const PetscInt  dim   = space->dim;
  const PetscInt *nodes = &space->group_nodes[group->node_offset];

  for (PetscInt a = 0; a < dim; a++) {
    y[a] = pass->sum->points->x[p * dim + a];
    for (PetscInt i = 0; i < group->node_count; i++)
      y[a] += MpmBasisAt(&pass->basis, 0, i) * pass->u[nodes[i] * pass->sum->block + a];
  }
}

/* ---- the material's extent along the normal ---- */

/* Half of a point's extent along the normal, as that of a square or cube of its volume. */
static PetscReal HalfExtent(const MpmCutPass *pass, const MpmSection *section, PetscInt p)
{
  const PetscInt  dim    = pass->sum->space->dim;
  const PetscReal extent = MpmPointExtent(pass->sum->points, dim, p);
  PetscReal       shadow = 0.;

  for (PetscInt a = 0; a < dim; a++) shadow += PetscAbsReal(section->axis[0][a]);
  return 0.5 * shadow * PetscPowReal(extent, 1. / (PetscReal)dim);
}

/*
  reach: how far the points go along the normal against it and with it, and how far the nodes do that bear their forces.
*/
static PetscErrorCode FindReach(MpmCutPass *pass, MpmCutPlane *plane, PetscReal reach[4])
{
  const MpmSpace *space = pass->sum->space;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < 4; k++) reach[k] = PETSC_NINFINITY;
  for (PetscInt g = 0; g < space->group_count; g++) {
    const MpmGroup *group = &space->groups[g];
    PetscReal       range[2];

    if (!MpmCutAnyChosen(pass, plane, group)) continue;
    MpmCutMeasureNodes(pass, plane->section, group, PETSC_TRUE, range);
    reach[2] = PetscMax(reach[2], -range[0]);
    reach[3] = PetscMax(reach[3], range[1]);
    for (PetscInt s = group->point_begin; s < group->point_end; s++) {
      const PetscInt p = space->order[s];
      PetscReal      y[MPM_MAX_DIM], d, half;

      if (!MpmCutIsChosen(plane, p)) continue;
      MpmSpaceEvaluate(space, group, p, &pass->basis);
      MpmCutPlacePoint(pass, group, p, y);
      d        = MpmCutDistance(plane->section, space->dim, y);
      half     = HalfExtent(pass, plane->section, p);
      reach[0] = PetscMax(reach[0], half - d);
      reach[1] = PetscMax(reach[1], half + d);
    }
  }
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, reach, 4, MPIU_REAL, MPIU_MAX, pass->sum->grid->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Draws the nodes' reach back behind those that lead followers beyond it. */
static PetscErrorCode DrawBack(const MpmCutPass *pass, const MpmCutPlane *plane, PetscReal reach[4])
{
  const MpmSpace *space  = pass->sum->space;
  const PetscReal end[2] = {-reach[2], reach[3]};
  PetscReal       back[2];

  PetscFunctionBeginUser;
  back[0] = end[0];
  back[1] = -end[1];
  for (PetscInt g = 0; g < space->group_count; g++) {
    const MpmGroup *group = &space->groups[g];

    if (!space->extension.of || !MpmCutAnyChosen(pass, plane, group)) continue;
    for (PetscInt i = 0; i < group->node_count; i++) {
      const PetscInt  node = space->group_nodes[group->node_offset + i], f = AnyFollower(pass, node);
      const PetscReal d        = MpmCutDistance(plane->section, space->dim, &pass->place[node * space->dim]);
      PetscReal       range[2] = {PETSC_INFINITY, PETSC_NINFINITY};

      if (f < 0 || (d >= end[0] && d <= end[1])) continue;
      MeasureMasters(pass, plane->section, f, range);
      if (d < end[0]) back[0] = PetscMax(back[0], range[1]);
      else back[1] = PetscMax(back[1], -range[0]);
    }
  }
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, back, 2, MPIU_REAL, MPIU_MAX, pass->sum->grid->comm));
  reach[2] = -back[0];
  reach[3] = -back[1];
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmCutPlaceRamps(MpmCutPass *pass, MpmCutPlane *plane)
{
  const MpmSection *section = plane->section;
  const MpmGrid    *grid    = pass->sum->grid;
  PetscReal         reach[4], width = 0., lower, upper;

  PetscFunctionBeginUser;
  PetscCall(FindReach(pass, plane, reach));
  PetscCall(DrawBack(pass, plane, reach));
  lower = -PetscMin(reach[0], reach[2]);
  upper = PetscMin(reach[1], reach[3]);
  for (PetscInt a = 0; a < grid->dim; a++) width += grid->h[a] * PetscAbsReal(section->axis[0][a]);
  for (PetscInt k = 0; k < section->count; k++) {
    const PetscReal part = section->count > 1 ? (PetscReal)k / (PetscReal)(section->count - 1) : 0.;
    MpmCutRamp     *ramp = &plane->ramps[k];
    PetscReal       d, w = PetscMin(width, upper - lower);

    for (PetscInt a = 0; a < grid->dim; a++)
      ramp->origin[a] = (1. - part) * section->first[a] + part * section->last[a];
    d = MpmCutDistance(section, grid->dim, ramp->origin);
    if (section->follow && upper > lower) {
      d = lower + part * (upper - lower);
      for (PetscInt a = 0; a < grid->dim; a++) ramp->origin[a] = section->first[a] + d * section->axis[0][a];
    }
    if (!(w > 0.) || d < lower - MPM_TOLERANCE * width || d > upper + MPM_TOLERANCE * width) w = 0.;
    ramp->lower = w > 0. ? PetscMin(PetscMax(d - 0.5 * w, lower), upper - w) : d;
    ramp->upper = ramp->lower + w;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

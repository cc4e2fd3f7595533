/*
  Cuts through the material.

  The forces transmitted across a plane are the work of the internal forces in the rigid motion of one side,

    F = sum_i s_i f_i ,   M = sum_i s_i (y_i - c) x f_i ,   f_i = sum_p V_p sigma_p grad phi_i ,   y_i = x_i + u_i

  with s_i a ramp across the plane, from 0 to 1 over the width of a cell: the mean over all parallel planes in that
  width. With the step's own fluxes and shape functions the sum is in equilibrium with loads and reactions beyond, to
  Newton's tolerance. Where no force acts within the width, it does not depend on the points' places. Where the balance
  takes a fraction of the points' forces from the step's start (generalised alpha), so does the sum.

  Small-cut nodes have no balance of their own: forces there belong to the nodes they follow (space/extension.h), and
  the motion is extended likewise, component by component: s_i and s_i (y_i - c) become sum_k e_ik s_k and sum_k e_ik
  s_k (y_k - c).

  The ramp stays within the material: a plane nearer to its end than half the width is moved there, and further where
  the nodes of the end follow: all that these follow lie beyond the ramp.
  Area and centroid are those of int grad s dv.

  Source: the domain form of a boundary flux, as in Carey, Chow and Seager (1985), doi:10.1016/0045-7825(85)90084-2.
*/
#include "geometry/geometry.h"
#include "grid/grid.h"
#include "particles/particles.h"
#include "particles/selection.h"
#include "space/kernel_point.h"
#include "space/point_loop.h"
#include "space/unit.h"
#include "bc/bc.h"
#include "assembly/terms.h"
#include "points/cell_mean.h"
#include "volume/volume.h"
#include "problem/section.h"

PetscErrorCode MpmSectionDestroy(MpmSection *section)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(section->name));
  PetscCall(PetscFree(section->chosen_field));
  PetscCall(PetscFree(section->cuts));
  PetscCall(MpmRegionDestroy(&section->region));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSectionSelect(MpmSection *section, const MpmBodies *bodies, MpmParticles *particles)
{
  PetscInt64 chosen;

  PetscFunctionBeginUser;
  if (!section->chosen_field) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmPointsChoose(bodies, section->body, section->region, section->chosen_field, particles, &chosen));
  MpmCheckInput(chosen, "-mpm_section_%s_%s: there is no point to be cut", section->name,
                section->region ? "region" : "body");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- planes ---- */

/* Ramp of one cut: s = (d - lower)/(upper - lower), between 0 and 1, at a distance d from the section's first place. */
typedef struct {
  PetscReal lower, upper; /* equal: the cut meets no material */
  PetscReal origin[MPM_MAX_DIM];
} Ramp;

/* Sums over the points: force, moment about the ramp's origin, area, and area times place from there. */
enum { SUM_FORCE = 0, SUM_MOMENT = MPM_MAX_DIM, SUM_AREA = 2 * MPM_MAX_DIM, SUM_PLACE, SUMS = SUM_PLACE + MPM_MAX_DIM };

/* One section under way. */
typedef struct {
  const MpmSection *section;
  PetscReal        *chosen; /* of the points, or NULL */
  Ramp             *ramps;
  PetscReal        *sums;
} Plane;

/* All cuts, with places of the local nodes at the step's end, and room for one group: nodal forces, and the ramp. */
typedef struct {
  const MpmSum         *sum;
  const MpmConstraints *constraints;
  const PetscReal      *u, *by; /* displacements that say where nodes go, and by which points have their fluxes */
  PetscBool             areas;  /* areas are summed with the forces */
  PetscInt              count;
  Plane                *planes;
  PetscReal            *place, *ramp, *force, *storage;
  PetscReal             flux[MPM_MAX_INPUTS];
  MpmBasis              basis;
} Pass;

static PetscReal Distance(const MpmSection *section, PetscInt dim, const PetscReal y[])
{
  PetscReal d = 0.;

  for (PetscInt a = 0; a < dim; a++) d += (y[a] - section->first[a]) * section->axis[0][a];
  return d;
}

static PetscBool IsChosen(const Plane *plane, PetscInt p)
{
  return (PetscBool)(!plane->chosen || plane->chosen[p] != 0.);
}

static PetscBool AnyChosen(const Pass *pass, const Plane *plane, const MpmGroup *group)
{
  for (PetscInt s = group->point_begin; s < group->point_end; s++)
    if (IsChosen(plane, pass->sum->space->order[s])) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* Where the local nodes go, [i][a]. */
static void PlaceNodes(Pass *pass)
{
  const MpmSpace *space = pass->sum->space;
  const MpmGrid  *grid  = pass->sum->grid;
  const PetscInt  dim   = space->dim;

  for (PetscInt i = 0; i < space->local; i++) {
    PetscInt at[MPM_MAX_DIM];

    if (MpmSpaceIsExtra(space, i)) continue;
    MpmSpaceAt(space, &space->node[i * dim], at);
    for (PetscInt a = 0; a < dim; a++) {
      pass->place[i * dim + a] = grid->lower[a] + grid->h[a] * (PetscReal)at[a];
      pass->place[i * dim + a] += pass->u[i * pass->sum->block + a];
    }
  }
}

/* A local node's place among the followers where its component c follows, or -1. */
static inline PetscInt FollowerOf(const Pass *pass, PetscInt node, PetscInt c)
{
  const PetscInt *of = pass->sum->space->extension.of;

  if (!of || of[node] < 0 || pass->constraints->condition[node * pass->sum->block + c] != MPM_FOLLOWS) return -1;
  return of[node];
}

static PetscInt AnyFollower(const Pass *pass, PetscInt node)
{
  PetscInt f = -1;

  for (PetscInt c = 0; c < pass->sum->space->dim && f < 0; c++) f = FollowerOf(pass, node, c);
  return f;
}

static void Widen(const Pass *pass, const MpmSection *section, PetscInt node, PetscReal range[2])
{
  const PetscInt  dim = pass->sum->space->dim;
  const PetscReal d   = Distance(section, dim, &pass->place[node * dim]);

  range[0] = PetscMin(range[0], d);
  range[1] = PetscMax(range[1], d);
}

/* The range of those that lead a follower. */
static void MeasureMasters(const Pass *pass, const MpmSection *section, PetscInt f, PetscReal range[2])
{
  const MpmExtension *extension = &pass->sum->space->extension;

  for (PetscInt k = extension->offset[f]; k < extension->offset[f + 1]; k++)
    Widen(pass, section, extension->master[k], range);
}

/* The range of a group's nodes, and of those that lead them; `own`: of nodes that do not follow alone. */
static void MeasureNodes(const Pass *pass, const MpmSection *section, const MpmGroup *group, PetscBool own,
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

/* A point's place at the step's end, from its weights in the pass's basis. */
static void PlacePoint(const Pass *pass, const MpmGroup *group, PetscInt p, PetscReal y[])
{
  const MpmSpace *space = pass->sum->space;
  const PetscInt  dim   = space->dim;
  const PetscInt *nodes = &space->group_nodes[group->node_offset];

  for (PetscInt a = 0; a < dim; a++) {
    y[a] = pass->sum->points->x[p * dim + a];
    for (PetscInt i = 0; i < group->node_count; i++)
      y[a] += pass->basis.basis[0][i] * pass->u[nodes[i] * pass->sum->block + a];
  }
}

/* ---- the material's extent along the normal ---- */

/* Half of a point's extent along the normal, as that of a square or cube of its volume. */
static PetscReal HalfExtent(const Pass *pass, const MpmSection *section, PetscInt p)
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
static PetscErrorCode FindReach(Pass *pass, Plane *plane, PetscReal reach[4])
{
  const MpmSpace *space = pass->sum->space;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < 4; k++) reach[k] = PETSC_NINFINITY;
  for (PetscInt g = 0; g < space->group_count; g++) {
    const MpmGroup *group = &space->groups[g];
    PetscReal       range[2];

    if (!AnyChosen(pass, plane, group)) continue;
    MeasureNodes(pass, plane->section, group, PETSC_TRUE, range);
    reach[2] = PetscMax(reach[2], -range[0]);
    reach[3] = PetscMax(reach[3], range[1]);
    for (PetscInt s = group->point_begin; s < group->point_end; s++) {
      const PetscInt p = space->order[s];
      PetscReal      y[MPM_MAX_DIM], d, half;

      if (!IsChosen(plane, p)) continue;
      MpmSpaceEvaluate(space, group, p, &pass->basis);
      PlacePoint(pass, group, p, y);
      d        = Distance(plane->section, space->dim, y);
      half     = HalfExtent(pass, plane->section, p);
      reach[0] = PetscMax(reach[0], half - d);
      reach[1] = PetscMax(reach[1], half + d);
    }
  }
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, reach, 4, MPIU_REAL, MPIU_MAX, pass->sum->grid->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Draws the nodes' reach back behind those that lead followers beyond it. */
static PetscErrorCode DrawBack(const Pass *pass, const Plane *plane, PetscReal reach[4])
{
  const MpmSpace *space  = pass->sum->space;
  const PetscReal end[2] = {-reach[2], reach[3]};
  PetscReal       back[2];

  PetscFunctionBeginUser;
  back[0] = end[0];
  back[1] = -end[1];
  for (PetscInt g = 0; g < space->group_count; g++) {
    const MpmGroup *group = &space->groups[g];

    if (!space->extension.of || !AnyChosen(pass, plane, group)) continue;
    for (PetscInt i = 0; i < group->node_count; i++) {
      const PetscInt  node = space->group_nodes[group->node_offset + i], f = AnyFollower(pass, node);
      const PetscReal d        = Distance(plane->section, space->dim, &pass->place[node * space->dim]);
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

/* The ramps of a section's cuts: of a cell's width, within the material. */
static PetscErrorCode PlaceRamps(Pass *pass, Plane *plane)
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
    Ramp           *ramp = &plane->ramps[k];
    PetscReal       d, w = PetscMin(width, upper - lower);

    for (PetscInt a = 0; a < grid->dim; a++)
      ramp->origin[a] = (1. - part) * section->first[a] + part * section->last[a];
    d = Distance(section, grid->dim, ramp->origin);
    if (!(w > 0.) || d < lower - MPM_TOLERANCE * width || d > upper + MPM_TOLERANCE * width) w = 0.;
    ramp->lower = w > 0. ? PetscMin(PetscMax(d - 0.5 * w, lower), upper - w) : d;
    ramp->upper = ramp->lower + w;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- sums ---- */

/* True where the ramp rises somewhere between the nodes. */
static PetscBool Crosses(const Ramp *ramp, const PetscReal range[2])
{
  return (PetscBool)(ramp->upper > ramp->lower && range[0] < ramp->upper && range[1] > ramp->lower);
}

/* Motion of one side at component c of a node's force: s, and s (y - c). */
typedef struct {
  PetscReal value, arm[MPM_MAX_DIM];
} Motion;

static void AddMotion(const Pass *pass, const MpmSection *section, const Ramp *ramp, PetscInt node, PetscReal weight,
                      Motion *motion)
{
  const PetscInt   dim  = pass->sum->space->dim;
  const PetscReal *y    = &pass->place[node * dim];
  const PetscReal  s    = (Distance(section, dim, y) - ramp->lower) / (ramp->upper - ramp->lower);
  const PetscReal  part = weight * PetscMin(PetscMax(s, 0.), 1.);

  motion->value += part;
  for (PetscInt a = 0; a < dim; a++) motion->arm[a] += part * (y[a] - ramp->origin[a]);
}

static Motion MotionAt(const Pass *pass, const MpmSection *section, const Ramp *ramp, PetscInt node, PetscInt c)
{
  const MpmExtension *extension = &pass->sum->space->extension;
  const PetscInt      f         = FollowerOf(pass, node, c);
  Motion              motion    = {.value = 0.};

  if (f < 0) AddMotion(pass, section, ramp, node, 1., &motion);
  for (PetscInt k = f < 0 ? 0 : extension->offset[f]; f >= 0 && k < extension->offset[f + 1]; k++)
    AddMotion(pass, section, ramp, extension->master[k], extension->weight[k], &motion);
  return motion;
}

/* sum += y x f, from the origin; in 2D about z, which is first */
static void AddMoment(PetscInt dim, const PetscReal y[], const PetscReal origin[], const PetscReal f[], PetscReal sum[])
{
  PetscReal r[MPM_MAX_DIM];

  for (PetscInt a = 0; a < dim; a++) r[a] = y[a] - origin[a];
  if (dim == 2) sum[0] += r[0] * f[1] - r[1] * f[0];
  else
    for (PetscInt a = 0; a < 3; a++) sum[a] += r[(a + 1) % 3] * f[(a + 2) % 3] - r[(a + 2) % 3] * f[(a + 1) % 3];
}

/* Force and moment of component c of a node's force. */
static void AddComponent(PetscInt dim, const Motion *motion, PetscInt c, PetscReal force, PetscReal sums[])
{
  const PetscReal origin[MPM_MAX_DIM] = {0., 0., 0.};
  PetscReal       f[MPM_MAX_DIM]      = {0., 0., 0.};

  f[c] = force;
  sums[SUM_FORCE + c] += motion->value * force;
  AddMoment(dim, motion->arm, origin, f, &sums[SUM_MOMENT]);
}

/* Contribution of one point to the area, int n . grad s dv = V_n n . cof(dF) grad s, with s by component, and that
   times its place. */
static void AddArea(const Pass *pass, const MpmSection *section, const Ramp *ramp, const MpmGroup *group, PetscInt p,
                    PetscReal sums[])
{
  const MpmSum   *sum = pass->sum;
  const PetscInt  dim = sum->space->dim, n = group->node_count;
  const PetscInt *nodes = &sum->space->group_nodes[group->node_offset];
  PetscReal       dF[MPM_MAX_DIM * MPM_MAX_DIM], cofactor[MPM_MAX_DIM * MPM_MAX_DIM], y[MPM_MAX_DIM], area = 0.;

  for (PetscInt k = 0; k < dim * dim; k++) {
    dF[k] = k / dim == k % dim ? 1. : 0.;
    for (PetscInt i = 0; i < n; i++)
      dF[k] += pass->u[nodes[i] * sum->block + k / dim] * pass->basis.basis[1 + k % dim][i];
  }
  (void)MpmCofactors(dim * dim, dF, cofactor);
  for (PetscInt k = 0; k < dim * dim; k++) {
    PetscReal slope = 0.;

    for (PetscInt i = 0; i < n; i++) slope += pass->ramp[k / dim * n + i] * pass->basis.basis[1 + k % dim][i];
    area += section->axis[0][k / dim] * cofactor[k] * slope;
  }
  area *= sum->points->volume0[p] * MpmPointJ(sum->points, p);
  PlacePoint(pass, group, p, y);
  sums[SUM_AREA] += area;
  for (PetscInt a = 0; a < dim; a++) sums[SUM_PLACE + a] += area * (y[a] - ramp->origin[a]);
}

/* One group's part in one cut; forces of its nodes are there. */
static void AddCut(Pass *pass, Plane *plane, PetscInt cut, const MpmGroup *group)
{
  const MpmSpace *space = pass->sum->space;
  const Ramp     *ramp  = &plane->ramps[cut];
  const PetscInt  dim = space->dim, n = group->node_count;
  PetscReal      *sums = &plane->sums[cut * SUMS];

  for (PetscInt k = 0; k < n * dim; k++) {
    const PetscInt node   = space->group_nodes[group->node_offset + k % n];
    const Motion   motion = MotionAt(pass, plane->section, ramp, node, k / n);

    pass->ramp[k] = motion.value;
    AddComponent(dim, &motion, k / n, pass->force[k], sums);
  }
  for (PetscInt s = group->point_begin; pass->areas && s < group->point_end; s++) {
    const PetscInt p = space->order[s];

    if (!IsChosen(plane, p)) continue;
    MpmSpaceEvaluate(space, group, p, &pass->basis);
    AddArea(pass, plane->section, ramp, group, p, sums);
  }
}

/* A point's fluxes, by a physics without means. */
static void PointFlux(Pass *pass, const PetscReal values[], PetscInt p, const MpmKnown known)
{
  const MpmLayout *layout = pass->sum->layout;
  MpmKernelPoint   point;
  PetscReal        input[MPM_MAX_INPUTS];

  MpmSumInputs(known, layout, values, &pass->basis, input);
  MpmSumPoint(pass->sum, p, &point);
  if (layout->kernel->residual(&point, input, pass->flux)) /* a converged step has no such point */
    for (PetscInt k = 0; k < layout->input.count; k++) pass->flux[k] = 0.;
}

/* Forces of the chosen points at the group's nodes; `cell`: the fluxes of the group's points are there already. */
static void FindForces(Pass *pass, const Plane *plane, const MpmGroup *group, const MpmCellWork *cell,
                       PetscReal values[])
{
  const MpmSum  *sum   = pass->sum;
  const MpmKnown known = KnownGeneral(sum->layout, group);

  for (PetscInt k = 0; k < known.n * known.block; k++) pass->force[k] = 0.;
  if (!cell) MpmSumGather(known, sum, group, pass->by, values);
  for (PetscInt s = group->point_begin; s < group->point_end; s++) {
    const PetscInt p = sum->space->order[s];

    if (!IsChosen(plane, p)) continue;
    MpmSumBasis(known, sum->space, p, PETSC_TRUE, &pass->basis);
    if (!cell) PointFlux(pass, values, p, known);
    MpmSumAddFlux(known, sum->layout, &pass->basis, cell ? cell->point[s - cell->begin].flux : pass->flux, pass->force);
  }
}

/* A group or a cell in all cuts that cross it; its fluxes are made where there is one. */
static PetscErrorCode AddUnit(Pass *pass, const MpmCell *unit, MpmCellWork *cell, PetscReal values[])
{
  PetscBool made   = PETSC_FALSE;
  PetscInt  failed = 0;

  PetscFunctionBeginUser;
  for (PetscInt g = unit->group_begin; g < unit->group_end; g++) {
    const MpmGroup *group = &pass->sum->space->groups[g];

    for (PetscInt k = 0; k < pass->count; k++) {
      Plane    *plane = &pass->planes[k];
      PetscReal range[2];
      PetscBool forces = PETSC_FALSE;

      MeasureNodes(pass, plane->section, group, PETSC_FALSE, range);
      for (PetscInt c = 0; c < plane->section->count; c++) {
        if (!Crosses(&plane->ramps[c], range)) continue;
        if (!forces && !AnyChosen(pass, plane, group)) break;
        if (cell && !made) PetscCall(MpmCellResidual(pass->sum, unit, pass->by, cell, &failed));
        made = PETSC_TRUE;
        if (!forces) FindForces(pass, plane, group, cell, values);
        forces = PETSC_TRUE;
        AddCut(pass, plane, c, group);
      }
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode AddUnits(Pass *pass)
{
  const MpmSum *sum   = pass->sum;
  PetscBool     means = (PetscBool)(sum->layout->means > 0);
  MpmWorkspace  work;
  MpmCellWork   cell;

  PetscFunctionBeginUser;
  PetscCall(MpmWorkspaceCreate(sum, &work));
  if (means) PetscCall(MpmCellWorkCreate(sum, &cell));
  for (PetscInt k = 0; k < MpmUnitCount(sum); k++) {
    const MpmCell unit = MpmUnitGroups(sum, k);

    PetscCall(AddUnit(pass, &unit, means ? &cell : NULL, work.values));
  }
  if (means) PetscCall(MpmCellWorkDestroy(&cell));
  PetscCall(PetscFree(work.storage));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The part of the forces that is in the stress of the step's start: nothing has moved there. */
static PetscErrorCode AddStart(Pass *pass)
{
  const MpmSum *end   = pass->sum;
  MpmSum        start = *end;
  PetscReal    *still;

  PetscFunctionBeginUser;
  if (end->part == 1.) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscCalloc1((end->space->local * end->block), &still));
  start.part  = 1. - end->part;
  start.rest  = (PetscBool)!end->layout->means;
  pass->sum   = &start;
  pass->by    = still;
  pass->areas = PETSC_FALSE;
  PetscCall(AddUnits(pass));
  pass->sum = end;
  PetscCall(PetscFree(still));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the ghost penalty ---- */

/* The chosen points' share of the volume at the local nodes. */
static PetscErrorCode FindShare(Pass *pass, const Plane *plane, PetscReal share[])
{
  const MpmSpace *space = pass->sum->space;
  PetscReal      *volume;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1((2 * space->local), &volume));
  for (PetscInt g = 0; g < space->group_count; g++) {
    const MpmGroup *group = &space->groups[g];

    for (PetscInt s = group->point_begin; s < group->point_end; s++) {
      const PetscInt p = space->order[s];

      MpmSpaceEvaluate(space, group, p, &pass->basis);
      for (PetscInt i = 0; i < group->node_count; i++) {
        const PetscReal part = PetscAbsReal(pass->basis.basis[0][i]) * pass->sum->points->volume0[p];
        PetscReal      *at   = &volume[2 * space->group_nodes[group->node_offset + i]];

        at[0] += part;
        if (IsChosen(plane, p)) at[1] += part;
      }
    }
  }
  PetscCall(MpmSpaceAddToOwners(space, 2, volume));
  PetscCall(MpmSpaceToGhosts(space, 2, volume));
  for (PetscInt i = 0; i < space->local; i++) share[i] = volume[2 * i] > 0. ? volume[2 * i + 1] / volume[2 * i] : 0.;
  PetscCall(PetscFree(volume));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The penalty's forces, `force` at the local nodes, in all cuts of a section. */
static void AddNodes(const Pass *pass, Plane *plane, const PetscReal force[], const PetscReal share[])
{
  const PetscInt dim = pass->sum->space->dim, bs = pass->sum->block;

  for (PetscInt i = 0; i < pass->sum->space->local; i++) {
    PetscReal size = 0.;

    for (PetscInt a = 0; a < dim; a++) size += PetscAbsReal(force[i * bs + a]) * share[i];
    if (size == 0.) continue;
    for (PetscInt k = 0; k < plane->section->count * dim; k++) {
      const Ramp *ramp = &plane->ramps[k / dim];
      Motion      motion;

      if (ramp->upper <= ramp->lower) continue;
      motion = MotionAt(pass, plane->section, ramp, i, k % dim);
      AddComponent(dim, &motion, k % dim, share[i] * force[i * bs + k % dim], &plane->sums[k / dim * SUMS]);
    }
  }
}

/*
  The ghost penalty carries forces over the edges of cells, too, which are internal forces; where only some of the
  points are cut, these have a share by their fraction of the node's volume.
*/
static PetscErrorCode AddGhostPenalty(Pass *pass)
{
  const MpmSpace *space = pass->sum->space;
  PetscInt        faces = space->faces.count, failed = 0;
  PetscReal      *force, *share;

  PetscFunctionBeginUser;
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &faces, 1, MPIU_INT, MPI_SUM, pass->sum->grid->comm));
  if (!faces) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscCalloc1((space->local * pass->sum->block), &force));
  PetscCall(PetscMalloc1(space->local, &share));
  PetscCall(MpmTermGhost.residual(NULL, pass->sum, pass->u, force, &failed));
  for (PetscInt k = 0; k < pass->count; k++) {
    for (PetscInt i = 0; i < space->local; i++) share[i] = 1.;
    if (pass->planes[k].section->chosen_field) PetscCall(FindShare(pass, &pass->planes[k], share));
    AddNodes(pass, &pass->planes[k], force, share);
  }
  PetscCall(PetscFree(force));
  PetscCall(PetscFree(share));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- results ---- */

/* Results of the sums, along the section's axes. */
static void Settle(PetscInt dim, const MpmSection *section, const Ramp *ramp, const PetscReal sums[], MpmCut *cut)
{
  PetscReal moment[MPM_MAX_DIM] = {sums[SUM_MOMENT], sums[SUM_MOMENT + 1], sums[SUM_MOMENT + 2]}, f[MPM_MAX_DIM],
            beside;

  cut->area = sums[SUM_AREA];
  for (PetscInt a = 0; a < dim; a++) {
    cut->place[a] = ramp->origin[a] + (cut->area > 0. ? sums[SUM_PLACE + a] / cut->area : 0.);
    f[a]          = sums[SUM_FORCE + a];
  }
  beside = 0.5 * (ramp->lower + ramp->upper) - Distance(section, dim, cut->place); /* onto the plane itself */
  for (PetscInt a = 0; a < dim; a++) cut->place[a] += beside * section->axis[0][a];
  AddMoment(dim, ramp->origin, section->has_about ? section->about : cut->place, f, moment);
  for (PetscInt k = 0; k < dim; k++) {
    cut->force[k] = cut->moment[k] = 0.;
    for (PetscInt a = 0; a < dim; a++) {
      cut->force[k] += section->axis[k][a] * f[a];
      cut->moment[k] += section->axis[k][a] * moment[a];
    }
  }
  if (dim == 2) {
    cut->moment[0] = moment[0];
    cut->moment[1] = 0.;
  }
}

static PetscErrorCode Begin(MpmSections *sections, MpmParticles *particles, Pass *pass)
{
  const MpmSpace *space = pass->sum->space;
  const PetscInt  n     = PetscPowInt(space->width, space->dim);

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc4((space->local * space->dim), &pass->place, (n * space->dim), &pass->ramp,
                         (n * pass->sum->block), &pass->force, (n * MpmBasisCount(space)), &pass->storage));
  PlaceNodes(pass);
  MpmBasisPlace(space, n, pass->storage, &pass->basis);
  PetscCall(PetscCalloc1(sections->count, &pass->planes));
  for (PetscInt k = 0; k < sections->count; k++) {
    Plane *plane = &pass->planes[k];

    plane->section = &sections->at[k];
    if (plane->section->chosen_field)
      PetscCall(MpmParticlesGetField(particles, plane->section->chosen_field, &plane->chosen));
    PetscCall(PetscCalloc2(plane->section->count, &plane->ramps, (plane->section->count * SUMS), &plane->sums));
    PetscCall(PlaceRamps(pass, plane));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSectionsEvaluate(MpmSections *sections, const MpmConstraints *constraints, const MpmSum *sum,
                                   const PetscReal u[], MpmParticles *particles)
{
  const PetscInt dim   = sum->space->dim;
  MpmSum         still = *sum;
  Pass           pass  = {.sum = &still, .constraints = constraints, .u = u, .by = u, .areas = PETSC_TRUE};

  PetscFunctionBeginUser;
  still.trial = NULL;
  pass.count  = sections->count;
  PetscCall(Begin(sections, particles, &pass));
  PetscCall(AddUnits(&pass));
  PetscCall(AddStart(&pass));
  PetscCall(AddGhostPenalty(&pass));
  for (PetscInt k = 0; k < sections->count; k++) {
    Plane      *plane   = &pass.planes[k];
    MpmSection *section = &sections->at[k];

    PetscCall(MPIU_Allreduce(MPI_IN_PLACE, plane->sums, (PetscMPIInt)(section->count * SUMS), MPIU_REAL, MPIU_SUM,
                             sum->grid->comm));
    for (PetscInt c = 0; c < section->count; c++)
      Settle(dim, section, &plane->ramps[c], &plane->sums[c * SUMS], &section->cuts[c]);
    if (plane->chosen) PetscCall(MpmParticlesRestoreField(particles, &plane->chosen));
    PetscCall(PetscFree2(plane->ramps, plane->sums));
  }
  PetscCall(PetscFree(pass.planes));
  PetscCall(PetscFree4(pass.place, pass.ramp, pass.force, pass.storage));
  sections->made = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

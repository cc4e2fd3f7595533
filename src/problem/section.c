/*
  Cuts through the material.

  The forces transmitted across a plane are the work of the internal forces in the rigid motion of one side,

    F = sum_i s_i f_i ,   M = sum_i s_i (y_i - c) x f_i ,   f_i = sum_p V_p sigma_p grad phi_i ,   y_i = x_i + u_i

  with s_i a ramp across the plane, from 0 to 1 over the width of a cell: the mean over all parallel planes in that
  width. With the step's own fluxes and shape functions the sum is in equilibrium with loads and reactions beyond, to
  Newton's tolerance. Where no force acts within the width, it does not depend on the points' places. Where the balance
  takes a fraction of the points' forces from the step's start (generalised alpha), so does the sum.

  Small-cut nodes have no balance of their own: forces there belong to the nodes they follow (extension/extension.h),
  and the motion is extended likewise, component by component: s_i and s_i (y_i - c) become sum_k e_ik s_k and sum_k
  e_ik s_k (y_k - c).

  Area and centroid are those of int grad s dv.

  Source: the domain form of a boundary flux, as in Carey, Chow and Seager (1985), doi:10.1016/0045-7825(85)90084-2.
*/
#include "geometry/geometry.h"
#include "geometry/rotations.h"
#include "grid/grid.h"
#include "particles/particles.h"
#include "selection/selection.h"
#include "space/kernel_point.h"
#include "space/point_loop.h"
#include "space/unit.h"
#include "bc/bc.h"
#include "points/spread_mean.h"
#include "volume/volume.h"
#include "problem/section_cut.h"

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

/* Sums over the points: force, moment about the ramp's origin, area, and area times place from there. */
enum { SUM_FORCE = 0, SUM_MOMENT = MPM_MAX_DIM, SUM_AREA = 2 * MPM_MAX_DIM, SUM_PLACE, SUMS = SUM_PLACE + MPM_MAX_DIM };

/* True where the ramp rises somewhere between the nodes. */
static PetscBool Crosses(const MpmCutRamp *ramp, const PetscReal range[2])
{
  return (PetscBool)(ramp->upper > ramp->lower && range[0] < ramp->upper && range[1] > ramp->lower);
}

/* Motion of one side at component c of a node's force: s, and s (y - c). */
typedef struct {
  PetscReal value, arm[MPM_MAX_DIM];
} Motion;

static void AddMotion(const MpmCutPass *pass, const MpmSection *section, const MpmCutRamp *ramp, PetscInt node,
                      PetscReal weight, Motion *motion)
{
  const PetscInt   dim  = pass->sum->space->dim;
  const PetscReal *y    = &pass->place[node * dim];
  const PetscReal  s    = (MpmCutDistance(section, dim, y) - ramp->lower) / (ramp->upper - ramp->lower);
  const PetscReal  part = weight * PetscMin(PetscMax(s, 0.), 1.);

  motion->value += part;
  for (PetscInt a = 0; a < dim; a++) motion->arm[a] += part * (y[a] - ramp->origin[a]);
}

static Motion MotionAt(const MpmCutPass *pass, const MpmSection *section, const MpmCutRamp *ramp, PetscInt node,
                       PetscInt c)
{
  const MpmExtension *extension = &pass->sum->space->extension;
  const PetscInt      f         = MpmCutFollower(pass, node, c);
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
  for (PetscInt k = 0; k < MpmRotationCount(dim); k++) {
    const PetscInt p = (MpmRotationAxis(dim, k) + 1) % 3, q = (MpmRotationAxis(dim, k) + 2) % 3;

    sum[k] += r[p] * f[q] - r[q] * f[p];
  }
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
static void AddArea(const MpmCutPass *pass, const MpmSection *section, const MpmCutRamp *ramp, const MpmGroup *group,
                    PetscInt p, PetscReal sums[])
{
  const MpmSum   *sum = pass->sum;
  const PetscInt  dim = sum->space->dim, n = group->node_count;
  const PetscInt *nodes = &sum->space->group_nodes[group->node_offset];
  PetscReal       dF[MPM_MAX_DIM * MPM_MAX_DIM], cofactor[MPM_MAX_DIM * MPM_MAX_DIM], y[MPM_MAX_DIM], area = 0.;

  for (PetscInt k = 0; k < dim * dim; k++) {
    dF[k] = k / dim == k % dim ? 1. : 0.;
    for (PetscInt i = 0; i < n; i++)
      dF[k] += pass->u[nodes[i] * sum->block + k / dim] * MpmBasisAt(&pass->basis, 1 + k % dim, i);
  }
  (void)MpmCofactors(dim * dim, dF, cofactor);
  for (PetscInt k = 0; k < dim * dim; k++) {
    PetscReal slope = 0.;

    for (PetscInt i = 0; i < n; i++) slope += pass->ramp[k / dim * n + i] * MpmBasisAt(&pass->basis, 1 + k % dim, i);
    area += section->axis[0][k / dim] * cofactor[k] * slope;
  }
  area *= sum->points->volume0[p] * MpmPointJ(sum->points, p);
  MpmCutPlacePoint(pass, group, p, y);
  sums[SUM_AREA] += area;
  for (PetscInt a = 0; a < dim; a++) sums[SUM_PLACE + a] += area * (y[a] - ramp->origin[a]);
}

/* One group's part in one cut; forces of its nodes are there. */
static void AddCut(MpmCutPass *pass, MpmCutPlane *plane, PetscInt cut, const MpmGroup *group)
{
  const MpmSpace   *space = pass->sum->space;
  const MpmCutRamp *ramp  = &plane->ramps[cut];
  const PetscInt    dim = space->dim, n = group->node_count;
  PetscReal        *sums = &plane->sums[cut * SUMS];

  for (PetscInt k = 0; k < n * dim; k++) {
    const PetscInt node   = space->group_nodes[group->node_offset + k % n];
    const Motion   motion = MotionAt(pass, plane->section, ramp, node, k / n);

    pass->ramp[k] = motion.value;
    AddComponent(dim, &motion, k / n, pass->force[k], sums);
  }
  for (PetscInt s = group->point_begin; pass->areas && s < group->point_end; s++) {
    const PetscInt p = space->order[s];

    if (!MpmCutIsChosen(plane, p)) continue;
    MpmSpaceEvaluate(space, group, p, &pass->basis);
    AddArea(pass, plane->section, ramp, group, p, sums);
  }
}

/* A point's fluxes, by a physics without means. */
static void PointFlux(MpmCutPass *pass, const PetscReal values[], PetscInt p, const MpmKnown known)
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
static void FindForces(MpmCutPass *pass, const MpmCutPlane *plane, const MpmGroup *group, const MpmCellWork *cell,
                       PetscReal values[])
{
  const PetscBool whole = (PetscBool)(cell || pass->fluxes);
  const MpmSum   *sum   = pass->sum;
  const MpmKnown  known = KnownGeneral(sum->layout, group);

  for (PetscInt k = 0; k < known.n * known.block; k++) pass->force[k] = 0.;
  if (!whole) MpmSumGather(known, sum, group, pass->by, values);
  for (PetscInt s = group->point_begin; s < group->point_end; s++) {
    const PetscInt p = sum->space->order[s];

    if (!MpmCutIsChosen(plane, p)) continue;
    MpmSumBasis(known, sum->space, p, PETSC_TRUE, &pass->basis);
    if (!whole) PointFlux(pass, values, p, known);
    MpmSumAddFlux(known, sum->layout, &pass->basis,
                  cell           ? cell->point[s - cell->begin].flux
                  : pass->fluxes ? &pass->fluxes[s * (known.inputs + 1)]
                                 : pass->flux,
                  pass->force);
  }
}

/* A group or a cell in all cuts that cross it; its fluxes are made where there is one. */
static PetscErrorCode AddUnit(MpmCutPass *pass, const MpmCell *unit, MpmCellWork *cell, PetscReal values[])
{
  PetscBool made   = PETSC_FALSE;
  PetscInt  failed = 0;

  PetscFunctionBeginUser;
  for (PetscInt g = unit->group_begin; g < unit->group_end; g++) {
    const MpmGroup *group = &pass->sum->space->groups[g];

    for (PetscInt k = 0; k < pass->count; k++) {
      MpmCutPlane *plane = &pass->planes[k];
      PetscReal    range[2];
      PetscBool    forces = PETSC_FALSE;

      MpmCutMeasureNodes(pass, plane->section, group, PETSC_FALSE, range);
      for (PetscInt c = 0; c < plane->section->count; c++) {
        if (!Crosses(&plane->ramps[c], range)) continue;
        if (!forces && !MpmCutAnyChosen(pass, plane, group)) break;
        if (cell && !made) PetscCall(MpmCellResidual(pass->sum, unit, pass->by, NULL, cell, &failed));
        made = PETSC_TRUE;
        if (!forces) FindForces(pass, plane, group, cell, values);
        forces = PETSC_TRUE;
        AddCut(pass, plane, c, group);
      }
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode AddUnits(MpmCutPass *pass)
{
  const MpmSum *sum    = pass->sum;
  PetscBool     means  = MpmSumHasCells(sum);
  PetscInt      failed = 0;
  MpmWorkspace  work;
  MpmCellWork   cell;
  MpmSpreadWork spread;

  PetscFunctionBeginUser;
  PetscCall(MpmWorkspaceCreate(sum, &work));
  if (sum->space->cells.spread) {
    PetscCall(MpmSpreadWorkCreate(sum, PETSC_FALSE, &spread));
    PetscCall(MpmSpreadEvaluate(&spread, pass->by, NULL, &failed));
    pass->fluxes = spread.flux;
  }
  if (means) PetscCall(MpmCellWorkCreate(sum, &cell));
  for (PetscInt k = 0; k < MpmUnitCount(sum); k++) {
    const MpmCell unit = MpmUnitGroups(sum, k);

    PetscCall(AddUnit(pass, &unit, means ? &cell : NULL, work.values));
  }
  if (means) PetscCall(MpmCellWorkDestroy(&cell));
  if (pass->fluxes) PetscCall(MpmSpreadWorkDestroy(&spread));
  pass->fluxes = NULL;
  PetscCall(PetscFree(work.storage));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The part of the forces that is in the stress of the step's start: nothing has moved there. */
static PetscErrorCode AddStart(MpmCutPass *pass)
{
  const MpmSum *end   = pass->sum;
  MpmSum        start = *end;
  PetscReal    *still;

  PetscFunctionBeginUser;
  if (end->step.part == 1.) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscCalloc1((end->space->local * end->block), &still));
  start.step.part = 1. - end->step.part;
  start.mode      = end->layout->means ? MPM_MODE_END : MPM_MODE_START;
  pass->sum       = &start;
  pass->by        = still;
  pass->areas     = PETSC_FALSE;
  PetscCall(AddUnits(pass));
  pass->sum = end;
  PetscCall(PetscFree(still));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the ghost penalty ---- */

/* The chosen points' share of the volume at the local nodes. */
static PetscErrorCode FindShare(MpmCutPass *pass, const MpmCutPlane *plane, PetscReal share[])
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
        const PetscReal part = PetscAbsReal(MpmBasisAt(&pass->basis, 0, i)) * pass->sum->points->volume0[p];
        PetscReal      *at   = &volume[2 * space->group_nodes[group->node_offset + i]];

        at[0] += part;
        if (MpmCutIsChosen(plane, p)) at[1] += part;
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
static void AddNodes(const MpmCutPass *pass, MpmCutPlane *plane, const PetscReal force[], const PetscReal share[])
{
  const PetscInt dim = pass->sum->space->dim, bs = pass->sum->block;

  for (PetscInt i = 0; i < pass->sum->space->local; i++) {
    PetscReal size = 0.;

    for (PetscInt a = 0; a < dim; a++) size += PetscAbsReal(force[i * bs + a]) * share[i];
    if (size == 0.) continue;
    for (PetscInt k = 0; k < plane->section->count * dim; k++) {
      const MpmCutRamp *ramp = &plane->ramps[k / dim];
      Motion            motion;

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
static PetscErrorCode AddGhostPenalty(MpmCutPass *pass)
{
  const MpmSpace *space = pass->sum->space;
  PetscInt        faces = space->boxes.faces.count, failed = 0;
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
static void Settle(PetscInt dim, const MpmSection *section, const MpmCutRamp *ramp, const PetscReal sums[], MpmCut *cut)
{
  PetscReal moment[MPM_MAX_DIM] = {sums[SUM_MOMENT], sums[SUM_MOMENT + 1], sums[SUM_MOMENT + 2]}, f[MPM_MAX_DIM],
            beside;

  cut->area = sums[SUM_AREA];
  for (PetscInt a = 0; a < dim; a++) {
    cut->place[a] = ramp->origin[a] + (cut->area > 0. ? sums[SUM_PLACE + a] / cut->area : 0.);
    f[a]          = sums[SUM_FORCE + a];
  }
  beside = 0.5 * (ramp->lower + ramp->upper) - MpmCutDistance(section, dim, cut->place); /* onto the plane itself */
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

static PetscErrorCode Begin(MpmSections *sections, MpmParticles *particles, MpmCutPass *pass)
{
  const MpmSpace *space = pass->sum->space;
  const PetscInt  n     = PetscPowInt(space->width, space->dim);

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc4((space->local * space->dim), &pass->place, (n * space->dim), &pass->ramp,
                         (n * pass->sum->block), &pass->force, (n * MpmBasisCount(space)), &pass->storage));
  MpmCutPlaceNodes(pass);
  MpmBasisPlace(space, n, pass->storage, &pass->basis);
  PetscCall(PetscCalloc1(sections->count, &pass->planes));
  for (PetscInt k = 0; k < sections->count; k++) {
    MpmCutPlane *plane = &pass->planes[k];

    plane->section = &sections->at[k];
    if (plane->section->chosen_field)
      PetscCall(MpmParticlesGetField(particles, plane->section->chosen_field, &plane->chosen));
    PetscCall(PetscCalloc2(plane->section->count, &plane->ramps, (plane->section->count * SUMS), &plane->sums));
    PetscCall(MpmCutPlaceRamps(pass, plane));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSectionsEvaluate(MpmSections *sections, const MpmConstraints *constraints, const MpmSum *sum,
                                   const PetscReal u[], MpmParticles *particles)
{
  const PetscInt dim  = sum->space->dim;
  MpmCutPass     pass = {.sum = sum, .constraints = constraints, .u = u, .by = u, .areas = PETSC_TRUE};

  PetscFunctionBeginUser;
  pass.count = sections->count;
  PetscCall(Begin(sections, particles, &pass));
  PetscCall(AddUnits(&pass));
  PetscCall(AddStart(&pass));
  PetscCall(AddGhostPenalty(&pass));
  for (PetscInt k = 0; k < sections->count; k++) {
    MpmCutPlane *plane   = &pass.planes[k];
    MpmSection  *section = &sections->at[k];

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

/*
  Points picked in the initial state, by place or by region, each with its share of the whole.
*/
#include "options/options.h"
#include "geometry/geometry.h"
#include "grid/grid.h"
#include "particles/body.h"
#include "particles/particles.h"
#include "particles/points.h"
#include "selection/air_points.h"
#include "selection/selection.h"

PetscErrorCode MpmSelectionRead(const MpmOptions *block, const MpmGrid *grid, MpmSelection *selection)
{
  PetscBool has_at, has_region;
  PetscReal tolerance[MPM_MAX_DIM];

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsHas(block, "region", &has_region));
  selection->nearest = 1;
  PetscCall(MpmOptionsReals(block, "at", "m", "a place in the initial state", MPM_RANGE_ANY, MPM_OPTIONAL, grid->dim,
                            selection->at, &has_at));
  if (has_at || MpmOptionsHelp())
    PetscCall(MpmOptionsInt(block, "nearest", "how many points next to the place", 1, 1000000, MPM_OPTIONAL,
                            &selection->nearest, NULL));
  else selection->nearest = 0;
  if (MpmOptionsHelp()) has_at = (PetscBool) !(has_region = PETSC_TRUE);
  MpmCheckInput(!(has_at && has_region), "-%sat and -%sregion: give one of them, not both", block->prefix,
                block->prefix);
  MpmCheckInput(has_at || has_region, "-%sat is missing: give a place and the number of nearest points, or a region",
                block->prefix);
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) tolerance[a] = MPM_TOLERANCE * grid->h[a];
  if (has_region) PetscCall(MpmRegionCreate(block, grid->dim, tolerance, &selection->region));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Distance of a point from the place at the start, in the smallest side of a cell; infinity for air. */
static PetscReal Distance(const MpmSelection *selection, const MpmGrid *grid, const MpmPoints *points,
                          const MpmMaterial *materials, PetscInt p)
{
  PetscReal unit = grid->h[0], square = 0.;

  if (MpmPointIsAir(materials, points, p)) return PETSC_INFINITY;
  for (PetscInt a = 1; a < grid->dim; a++) unit = PetscMin(unit, grid->h[a]);
  for (PetscInt a = 0; a < grid->dim; a++)
    square += PetscSqr((points->x0[p * grid->dim + a] - selection->at[a]) / unit);
  return PetscSqrtReal(square);
}

/* The n-th of the numbers of all ranks, which are sorted on each. Collective. */
static PetscErrorCode FindNth(MPI_Comm comm, PetscInt n, PetscInt count, const PetscReal number[], PetscReal *nth)
{
  const PetscMPIInt mine = (PetscMPIInt)PetscMin(n, count);
  PetscMPIInt       size, *counts, *starts;
  PetscReal        *all;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(comm, &size));
  PetscCall(PetscMalloc2(size, &counts, (size + 1), &starts));
  PetscCallMPI(MPI_Allgather(&mine, 1, MPI_INT, counts, 1, MPI_INT, comm));
  starts[0] = 0;
  for (PetscMPIInt r = 0; r < size; r++) starts[r + 1] = starts[r] + counts[r];
  PetscCall(PetscMalloc1(starts[size], &all));
  PetscCallMPI(MPI_Allgatherv(number, mine, MPIU_REAL, all, counts, starts, MPIU_REAL, comm));
  PetscCall(PetscSortReal(starts[size], all));
  *nth = all[n - 1];
  PetscCall(PetscFree(all));
  PetscCall(PetscFree2(counts, starts));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  share = 1/nearest at the nearest points, 0 elsewhere. Of points that are equally far, but for rounding, those with the
  smaller ids are taken.
*/
static PetscErrorCode ShareNearest(const MpmSelection *selection, const MpmGrid *grid, const MpmPoints *points,
                                   const MpmMaterial *materials, PetscReal share[])
{
  const PetscInt count  = points->count;
  PetscInt       nearer = 0, equal = 0;
  PetscReal     *distance, *sorted, last, last_id;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc2(count, &distance, count, &sorted));
  for (PetscInt p = 0; p < count; p++) sorted[p] = distance[p] = Distance(selection, grid, points, materials, p);
  PetscCall(PetscSortReal(count, sorted));
  PetscCall(FindNth(grid->comm, selection->nearest, count, sorted, &last));
  for (PetscInt p = 0; p < count; p++) {
    if (distance[p] < last - MPM_TOLERANCE) nearer++;
    else if (distance[p] <= last + MPM_TOLERANCE) sorted[equal++] = (PetscReal)points->id[p];
  }
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &nearer, 1, MPIU_INT, MPI_SUM, grid->comm));
  PetscCall(PetscSortReal(equal, sorted));
  PetscCall(FindNth(grid->comm, selection->nearest - nearer, equal, sorted, &last_id));
  for (PetscInt p = 0; p < count; p++) {
    const PetscBool taken = (PetscBool)(distance[p] < last - MPM_TOLERANCE ||
                                        (distance[p] <= last + MPM_TOLERANCE && (PetscReal)points->id[p] <= last_id));

    share[p] = taken ? 1. / (PetscReal)selection->nearest : 0.;
  }
  PetscCall(PetscFree2(distance, sorted));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* How far the place is from the nearest domain, in cells along the axis on which it is farthest. */
static PetscErrorCode DistanceInCells(const MpmSelection *selection, const MpmGrid *grid, const MpmPoints *points,
                                      const MpmMaterial *materials, PetscReal *distance)
{
  const PetscInt dim = grid->dim;

  PetscFunctionBeginUser;
  *distance = PETSC_INFINITY;
  for (PetscInt p = 0; p < points->count; p++) {
    PetscReal far = 0.;

    if (MpmPointIsAir(materials, points, p)) continue;
    for (PetscInt a = 0; a < dim; a++) {
      const PetscReal half = points->domain.half_length
                               ? points->domain.half_length[p * dim + a]
                               : 0.5 * PetscPowReal(MpmPointExtent(points, dim, p), 1. / (PetscReal)dim);

      far = PetscMax(far, (PetscAbsReal(points->x0[p * dim + a] - selection->at[a]) - half) / grid->h[a]);
    }
    *distance = PetscMin(*distance, far);
  }
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, distance, 1, MPIU_REAL, MPIU_MIN, grid->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The place must stand in the material or within a cell of it. */
static PetscErrorCode CheckPlace(const MpmSelection *selection, const MpmGrid *grid, const MpmPoints *points,
                                 const MpmMaterial *materials, const char *prefix, const char *name)
{
  char     *text = NULL, number[MPM_NUMBER_TEXT];
  PetscReal distance;

  PetscFunctionBeginUser;
  PetscCall(DistanceInCells(selection, grid, points, materials, &distance));
  if (distance <= 1. + MPM_TOLERANCE) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt a = 0; a < grid->dim; a++) {
    MpmRealText(selection->at[a], number);
    PetscCall(MpmTextAppend(&text, "%s%s", a ? "," : "", number));
  }
  MpmRealText(PetscCeilReal(10. * distance) / 10., number);
  MpmCheckInput(PETSC_FALSE, "-mpm_%s_%s_at %s: is %s cells from the material, must be within one", prefix, name, text,
                number);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* share = the point's part of the volume of all points in the region */
static PetscErrorCode ShareRegion(MpmRegion region, const MpmGrid *grid, const MpmPoints *points,
                                  const MpmMaterial *materials, PetscReal share[], PetscReal *volume)
{
  PetscFunctionBeginUser;
  *volume = 0.;
  for (PetscInt p = 0; p < points->count; p++) {
    const PetscBool in =
      (PetscBool)(!MpmPointIsAir(materials, points, p) && MpmRegionContains(region, &points->x0[p * grid->dim]));

    share[p] = in ? points->volume0[p] : 0.;
    *volume += share[p];
  }
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, volume, 1, MPIU_REAL, MPIU_SUM, grid->comm));
  for (PetscInt p = 0; p<points->count && * volume> 0.; p++) share[p] /= *volume;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSelectionShare(const MpmSelection *selection, const MpmGrid *grid, const MpmPoints *points,
                                 const MpmMaterials *materials, const char *prefix, const char *name, PetscReal share[])
{
  PetscReal  volume;
  PetscInt64 total = 0;

  PetscFunctionBeginUser;
  if (selection->region) {
    PetscCall(ShareRegion(selection->region, grid, points, materials->at, share, &volume));
    MpmCheckInput(volume > 0., "-mpm_%s_%s_region: there is no point in it", prefix, name);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  for (PetscInt p = 0; p < points->count; p++) total += !MpmPointIsAir(materials->at, points, p);
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &total, 1, MPIU_INT64, MPI_SUM, grid->comm));
  MpmCheckInput(selection->nearest <= total,
                "-mpm_%s_%s_nearest %" PetscInt_FMT ": there are only %" PetscInt64_FMT " points", prefix, name,
                selection->nearest, total);
  PetscCall(CheckPlace(selection, grid, points, materials->at, prefix, name));
  PetscCall(ShareNearest(selection, grid, points, materials->at, share));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmBodyNameRead(const MpmOptions *block, const char *help, const MpmBodies *bodies, PetscInt *body)
{
  char *name, *known = NULL;

  PetscFunctionBeginUser;
  *body = -1;
  PetscCall(MpmOptionsText(block, "body", help, NULL, MPM_OPTIONAL, &name));
  for (PetscInt b = 0; name && b < bodies->count; b++) {
    if (!strcmp(name, bodies->names[b])) *body = b;
    PetscCall(MpmTextAppend(&known, "%s%s", b ? ", " : "", bodies->names[b]));
  }
  MpmCheckInput(!name || *body >= 0 || MpmOptionsHelp(), "-%sbody %.100s: must be one of %.800s", block->prefix, name,
                known);
  PetscCall(PetscFree(known));
  PetscCall(PetscFree(name));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPointsChoose(const MpmBodies *bodies, PetscInt body, MpmRegion region, const char *field,
                               MpmParticles *particles, PetscInt64 *chosen)
{
  const PetscInt dim   = particles->dim;
  PetscInt       first = 0, end = PETSC_INT_MAX;
  MpmPoints      points;
  PetscReal     *choice;

  PetscFunctionBeginUser;
  if (body >= 0) MpmBodyGetIds(bodies->at[body], &first, &end);
  PetscCall(MpmParticlesGetArrays(particles, &points));
  PetscCall(MpmParticlesGetField(particles, field, &choice));
  *chosen = 0;
  for (PetscInt p = 0; p < points.count; p++) {
    const PetscBool in = (PetscBool)(points.id[p] >= first && points.id[p] < end &&
                                     (!region || MpmRegionContains(region, &points.x0[p * dim])));

    choice[p] = in ? 1. : 0.;
    *chosen += in;
  }
  PetscCall(MpmParticlesRestoreField(particles, &choice));
  PetscCall(MpmParticlesRestoreArrays(particles, &points));
  PetscCall(
    MPIU_Allreduce(MPI_IN_PLACE, chosen, 1, MPIU_INT64, MPI_SUM, PetscObjectComm((PetscObject)particles->swarm)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

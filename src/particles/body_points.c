/*
  The points of bodies: their places in cells, initial stress and motion.
*/
#include "geometry/geometry.h"
#include "voxels/voxels.h"
#include "point/material.h"
#include "grid/grid.h"
#include "handover/handover.h"
#include "particles/body.h"
#include "particles/body_data.h"
#include "particles/body_initial.h"
#include "particles/body_stress.h"
#include "particles/particles.h"
#include "particles/ground_points.h"
#include "particles/point_mass.h"
#include "particles/points.h"
#include "release/ground_volume.h"

PetscBool MpmBodyIsTaken(const MpmBody body, const MpmGrid *grid, const PetscReal x[])
{
  for (PetscInt b = 0; b < body->beside.before_count; b++) {
    if (MpmBodyHolds(body->beside.before[b], grid, x) == MPM_HOLD_EDGE && MpmBodyHolds(body, grid, x) == MPM_HOLD_EDGE)
      return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* ---- points ---- */

void MpmBodySetVertical(MpmBody body, PetscInt axis, PetscInt up)
{
  body->vertical.axis = axis;
  body->vertical.up   = up;
}

/* Of a place, up gravity's axis. */
static PetscReal Height(const MpmBody body, const PetscReal x[])
{
  return (PetscReal)body->vertical.up * x[body->vertical.axis];
}

/* A point in a box of the lattice: place, domain, volume. */
static void FillPoint(const MpmBody body, const MpmGrid *grid, const PetscInt at[], PetscInt p, MpmPoints *points)
{
  const PetscInt dim    = grid->dim;
  PetscReal      volume = 1., x[MPM_MAX_DIM] = {0., 0., 0.}, half[MPM_MAX_DIM];

  MpmBodyBoxPlace(body, grid, at, x);
  MpmBodyHalfLengths(body, grid, half);
  for (PetscInt a = 0; a < dim; a++) volume *= grid->h[a] / (PetscReal)body->cells.per_cell[a];
  if (body->cut) volume = MpmBodyCutBox(body, grid, at, x);
  if (body->depth) volume *= MpmBodyDepthAt(body->depth, grid, x, half);
  points->material[p] =
    MpmRegionVoxels(body->region) ? MpmVoxelsAt(MpmRegionVoxels(body->region), x)->value : body->material.first;
  points->volume0[p] = volume * MpmTurn(points->F_size, x[0]);
  for (PetscInt a = 0; a < dim; a++) {
    points->x[p * dim + a] = points->x0[p * dim + a] = points->origin[p * dim + a] = x[a];
    if (points->domain.half_length)
      points->domain.half_length[p * dim + a] = points->domain.drawn[p * dim + a] = half[a];
    for (PetscInt b = 0; b < dim; b++) MpmPointF(points, p)[a * dim + b] = a == b ? 1. : 0.;
  }
  if (points->F_size > dim * dim) MpmPointF(points, p)[dim * dim] = 1.;
}

/*
  Goes through this rank's share of the body's cells; counts the points inside, and writes them from `first` on where
  points is given.
*/
static PetscInt FillCells(const MpmBody body, const MpmGrid *grid, PetscInt64 id, PetscInt first, MpmPoints *points)
{
  PetscInt64 cells    = 1, begin, end;
  PetscInt   per_cell = 1, count = 0, extent[MPM_MAX_DIM];
  PetscReal  x[MPM_MAX_DIM] = {0., 0., 0.}, half[MPM_MAX_DIM];

  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    extent[a] = body->cells.upper[a] - body->cells.lower[a];
    cells *= extent[a];
    per_cell *= body->cells.per_cell[a];
  }
  MpmBodyHalfLengths(body, grid, half);
  begin = cells * grid->rank / grid->size;
  end   = cells * (grid->rank + 1) / grid->size;
  for (PetscInt64 k = begin; k < end; k++) {
    const PetscInt64 cell[MPM_MAX_DIM] = {k % extent[0], (k / extent[0]) % extent[1],
                                          k / ((PetscInt64)extent[0] * extent[1])};

    for (PetscInt q = 0; q < per_cell; q++) {
      const PetscInt *m = body->cells.per_cell, sub[MPM_MAX_DIM] = {q % m[0], (q / m[0]) % m[1], q / (m[0] * m[1])};
      PetscInt        at[MPM_MAX_DIM];

      for (PetscInt a = 0; a < MPM_MAX_DIM; a++) at[a] = (PetscInt)cell[a] * m[a] + sub[a];
      MpmBodyBoxPlace(body, grid, at, x);
      if ((!MpmBodyOwns(body, x) || MpmBodyIsTaken(body, grid, x)) &&
          !(body->cut && MpmBodyIsLeftOver(body, grid, at, x)))
        continue;
      if (body->depth && !(MpmBodyDepthAt(body->depth, grid, x, half) > 0.)) continue;
      if (points) FillPoint(body, grid, at, first + count, points);
      if (points) points->id[first + count] = (PetscInt)(id + count);
      count++;
    }
  }
  return count;
}

/* The surface of the body's region, where it cut the lattice of points. */
static void FillCuts(const MpmBody body, PetscInt dim, PetscInt first, PetscInt end, MpmPoints *points)
{
  for (PetscInt p = first; points->domain.cut && p < end; p++) {
    PetscReal *cut = &points->domain.cut[p * (dim + 1)];

    if (!body->imported &&
        MpmRegionCut(body->region, &points->x[p * dim], &points->domain.half_length[p * dim], cut, &cut[dim]))
      continue;
    for (PetscInt a = 0; a <= dim; a++) cut[a] = 0.;
  }
}

/* Points of bodies on a lattice start without stress, with the history that the scene gives. */
static void FillAtRest(const MpmBody body, const MpmGrid *grid, const MpmMaterial materials[],
                       const MpmParticles *particles, PetscInt first, PetscInt end, MpmPoints *points)
{
  PetscReal half[MPM_MAX_DIM];

  MpmBodyHalfLengths(body, grid, half);
  for (PetscInt p = first; p < end; p++) {
    const MpmMaterial *material = &materials[points->material[p]];

    if (points->state) {
      PetscReal *state = &points->state[p * particles->state_size];

      MpmMaterialStateAtRest(material, particles->dim, state);
      if (body->initial)
        MpmBodyInitialFill(body->initial, particles->dim, Height(body, &points->x[p * particles->dim]), state);
      if (body->depth) state[0] = MpmBodyDepthAt(body->depth, grid, &points->x[p * grid->dim], half);
    }
    if (points->mass)
      points->mass[p] = points->volume0[p] * MpmMaterialDensity(material, MpmPointOwn(points, material, p));
  }
}

/* Columns of a release. */
static void FillRelease(const MpmBody body, const MpmGrid *grid, const MpmMaterial materials[],
                        const MpmParticles *particles, PetscInt64 id, PetscInt *first, MpmPoints *points)
{
  const PetscInt  dim = grid->dim, begin = *first, vertical[2] = {body->vertical.axis, body->vertical.up};
  PetscInt64      cursor = 0;
  MpmReleasePoint point;

  for (PetscInt p = begin; MpmReleaseNext(body->release, &cursor, &point); *first = ++p) {
    points->id[p]       = (PetscInt)(id + p - begin);
    points->material[p] = body->material.first;
    points->volume0[p]  = point.volume;
    for (PetscInt a = 0; a < dim; a++) {
      points->x[p * dim + a] = points->x0[p * dim + a] = points->origin[p * dim + a] = point.x[a];
      if (points->domain.half_length)
        points->domain.half_length[p * dim + a] = points->domain.drawn[p * dim + a] = point.half[a];
      for (PetscInt b = 0; b < dim; b++) MpmPointF(points, p)[a * dim + b] = a == b ? 1. : 0.;
    }
    MpmPointsSetOwn(materials, vertical, dim, p, p + 1, points);
    FillAtRest(body, grid, materials, particles, p, p + 1, points);
    points->state[p * particles->state_size] = point.volume / point.area;
  }
}

/* Volumes of ground between maps, by its columns and by its points. */
static PetscErrorCode MeasureGround(const MpmBody body, const MpmGrid *grid, PetscInt first, PetscInt end,
                                    const MpmPoints *points)
{
  PetscFunctionBeginUser;
  if (grid->dim < 3 || MpmRegionGetType(body->region) != MPM_REGION_RASTER || body->beside.winner_count)
    PetscFunctionReturn(PETSC_SUCCESS);
  body->volume[1] = 0.;
  for (PetscInt p = first; p < end; p++) body->volume[1] += points->volume0[p];
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &body->volume[1], 1, MPIU_REAL, MPIU_SUM, grid->comm));
  PetscCall(MpmGroundVolume(body->region, grid, body->lattice.spacing, &body->volume[0]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Points of a file, or out of columns. */
static PetscErrorCode FillImported(const MpmBody body, const MpmGrid *grid, const MpmMaterial materials[],
                                   const MpmParticles *particles, PetscInt64 id, PetscInt *first, MpmPoints *points)
{
  const PetscInt  begin = *first, vertical[2] = {body->vertical.axis, body->vertical.up};
  const PetscInt *material = MpmImportedMaterial(body->imported);

  PetscFunctionBeginUser;
  *first += MpmImportedCount(body->imported);
  for (PetscInt p = begin; p < *first; p++) {
    points->id[p]       = (PetscInt)(id + p - begin);
    points->material[p] = material ? material[p - begin] : body->material.first;
  }
  for (PetscInt p = begin; p < *first && points->state; p++)
    MpmMaterialStateAtRest(&materials[points->material[p]], grid->dim, &points->state[p * particles->state_size]);
  FillCuts(body, grid->dim, begin, *first, points);
  PetscCall(MpmImportedPlace(body->imported, grid->dim, begin, points));
  MpmPointsSetOwn(materials, vertical, grid->dim, begin, *first, points);
  for (PetscInt p = begin; p < *first && points->state && body->initial; p++)
    MpmBodyInitialFill(body->initial, grid->dim, Height(body, &points->x[p * grid->dim]),
                       &points->state[p * particles->state_size]);
  PetscCall(MpmImportedFill(body->imported, grid, materials, particles->state_size, begin, points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* All points of a body from `first` on; ids from `id` on. Returns where they end. */
static PetscErrorCode FillBody(const MpmBody body, const MpmGrid *grid, const MpmMaterial materials[],
                               const MpmParticles *particles, PetscInt64 id, PetscInt *first, MpmPoints *points)
{
  const PetscInt begin = *first, vertical[2] = {body->vertical.axis, body->vertical.up};

  PetscFunctionBeginUser;
  if (body->release) {
    FillRelease(body, grid, materials, particles, id, first, points);
    FillCuts(body, grid->dim, begin, *first, points);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (!body->imported) {
    *first += FillCells(body, grid, id, begin, points);
    FillCuts(body, grid->dim, begin, *first, points);
    PetscCall(MeasureGround(body, grid, begin, *first, points));
    MpmPointsSetOwn(materials, vertical, grid->dim, begin, *first, points);
    FillAtRest(body, grid, materials, particles, begin, *first, points);
    if (body->start.stress)
      PetscCall(MpmBodyStressFill(&materials[body->material.first], grid->dim, body->start.stress,
                                  particles->state_size, (const PetscInt[]){begin, *first}, points,
                                  &body->start.wrong));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(FillImported(body, grid, materials, particles, id, first, points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* omega x r */
static void Turn(const PetscReal spin[3], PetscInt dim, const PetscReal r[], PetscReal v[])
{
  const PetscReal z = dim == 3 ? r[2] : 0.;

  v[0] = spin[1] * z - spin[2] * r[1];
  v[1] = spin[2] * r[0] - spin[0] * z;
  if (dim == 3) v[2] = spin[0] * r[1] - spin[1] * r[0];
}

/* Affine velocity over its gradient, on an axis: 1, or the second moment of a point's weights, m2. */
static PetscReal Moment(const MpmBody body, const MpmGrid *grid, const MpmPoints *points, PetscInt p, PetscInt b)
{
  const PetscReal h = grid->h[b];
  const PetscReal l =
    body->motion.averaged && points->domain.half_length ? points->domain.half_length[p * grid->dim + b] : 0.;

  return body->motion.degree < 2 ? 1. : (PetscReal)(body->motion.degree + 1) * h * h / 12. + l * l / 3.;
}

/*
  A body that spins about its centre of mass. A point's affine velocity is W D with v = W r: for splines of degree p >=
  2 over a domain of half-length l the second moment is D = (p + 1) h^2/12 + l^2/3; for linear ones W itself is kept.
*/
static PetscErrorCode FillSpin(const MpmBody body, PetscInt number, const MpmGrid *grid, const MpmMaterial materials[],
                               const PetscInt body_of[], const MpmPoints *points)
{
  const PetscInt dim                     = grid->dim;
  PetscReal      centre[MPM_MAX_DIM + 1] = {0.}, v[MPM_MAX_DIM];

  PetscFunctionBeginUser;
  if (!body->motion.spins) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt p = 0; p < points->count; p++) {
    const PetscReal mass = body_of[p] == number ? MpmPointMass(points, materials, p) : 0.;

    for (PetscInt a = 0; a < dim; a++) centre[a] += mass * points->x[p * dim + a];
    centre[MPM_MAX_DIM] += mass;
  }
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, centre, MPM_MAX_DIM + 1, MPIU_REAL, MPIU_SUM, grid->comm));
  for (PetscInt p = 0; p < points->count; p++) {
    PetscReal r[MPM_MAX_DIM] = {0., 0., 0.};

    if (body_of[p] != number) continue;
    for (PetscInt a = 0; a < dim; a++) r[a] = points->x[p * dim + a] - centre[a] / centre[MPM_MAX_DIM];
    Turn(body->motion.spin, dim, r, v);
    for (PetscInt a = 0; a < dim; a++) points->motion.velocity[p * dim + a] += v[a];
    for (PetscInt b = 0; points->motion.affine && b < dim; b++) {
      PetscReal unit[MPM_MAX_DIM] = {0., 0., 0.};

      unit[b] = Moment(body, grid, points, p, b);
      Turn(body->motion.spin, dim, unit, v);
      for (PetscInt a = 0; a < dim; a++) points->motion.affine[(p * dim + a) * dim + b] = v[a];
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* How the points move as they are made. */
static PetscErrorCode FillMotion(PetscInt body_count, const MpmBody bodies[], const MpmMaterial materials[],
                                 const MpmGrid *grid, const MpmPoints *points)
{
  const PetscInt dim = grid->dim;
  PetscInt      *body_of, row = 0;

  PetscFunctionBeginUser;
  if (!points->motion.velocity) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(points->count, &body_of));
  MpmBodiesOfPoints(body_count, bodies, points, body_of);
  for (PetscInt p = 0; p < points->count; p++, row++) {
    const MpmBody    body = bodies[body_of[p]];
    const PetscReal *velocity;

    if (!p || body_of[p] != body_of[p - 1]) row = 0;
    velocity = body->imported && !body->motion.of_block ? MpmImportedVelocity(body->imported) : NULL;
    for (PetscInt a = 0; a < dim; a++)
      points->motion.velocity[p * dim + a] = velocity ? velocity[row * dim + a] : body->motion.velocity[a];
  }
  if (points->motion.affine) PetscCall(PetscArrayzero(points->motion.affine, points->count * dim * dim));
  if (points->motion.acceleration) PetscCall(PetscArrayzero(points->motion.acceleration, points->count * dim));
  for (PetscInt p = 0; p < points->count; p++, row++) {
    const MpmBody             body = bodies[body_of[p]];
    const struct MpmHandover *from = MpmBodyHandover(body);

    if (!p || body_of[p] != body_of[p - 1]) row = 0;
    for (PetscInt k = 0; points->motion.affine && from && from->gradient && k < dim * dim; k++)
      points->motion.affine[p * dim * dim + k] =
        from->gradient[row * dim * dim + k] * Moment(body, grid, points, p, k % dim);
  }
  for (PetscInt b = 0; b < body_count; b++) PetscCall(FillSpin(bodies[b], b, grid, materials, body_of, points));
  PetscCall(PetscFree(body_of));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Room between the ids, where points may be divided. */
static PetscErrorCode MakeRoom(PetscInt body_count, const MpmBody bodies[], const MpmMaterial materials[],
                               MPI_Comm comm, PetscInt64 total, const MpmPoints *points)
{
  const PetscInt64 room = points->domain.divisions ? 1 << MPM_DIVISIONS : 1, ids = room * total;

  PetscFunctionBeginUser;
  PetscCheck(ids < PETSC_INT_MAX, comm, PETSC_ERR_ARG_OUTOFRANGE,
             "ids of points up to %" PetscInt64_FMT " need PETSc with 64-bit indices", ids);
  if (room == 1) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt b = 0; b < body_count; b++) {
    bodies[b]->ids.first *= (PetscInt)room;
    bodies[b]->ids.end *= (PetscInt)room;
  }
  for (PetscInt p = 0; p < points->count; p++) points->id[p] *= (PetscInt)room;
  PetscCall(PetscArrayzero(points->domain.divisions, points->count));
  PetscCall(MpmBodiesSetGrounds(body_count, bodies, materials, (PetscInt)room));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Ids that are left for points with which a body fills the gap beneath: all rows of the grid in each column. */
static PetscInt64 FillIds(MpmBody body, const MpmGrid *grid)
{
  PetscInt64 columns = 1;

  if (!body->filling.joins || MpmBodyIsImported(body) || body->filling.fill == MPM_FILL_NO) return 0;
  for (PetscInt a = 0; a < grid->dim; a++)
    if (a != body->vertical.axis) columns *= body->lattice.count[a];
  body->filling.rows = grid->cells[body->vertical.axis] * body->cells.per_cell[body->vertical.axis];
  return columns * body->filling.rows;
}

/* Points of this rank. */
static PetscInt64 Count(const MpmBody body, const MpmGrid *grid)
{
  if (body->imported) return MpmImportedCount(body->imported);
  return body->release ? MpmReleaseCount(body->release) : FillCells(body, grid, 0, 0, NULL);
}

PetscErrorCode MpmBodiesGenerate(PetscInt body_count, const MpmBody bodies[], const MpmMaterial materials[],
                                 const MpmGrid *grid, MpmParticles *particles)
{
  PetscInt64 *count, *before, *total, id = 0;
  PetscInt    local = 0, first = 0;
  MpmPoints   points;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc3(body_count, &count, body_count, &before, body_count, &total));
  for (PetscInt b = 0; b < body_count; b++) {
    count[b] = Count(bodies[b], grid);
    local += (PetscInt)count[b];
  }
  PetscCallMPI(MPI_Scan(count, before, (PetscMPIInt)body_count, MPIU_INT64, MPI_SUM, grid->comm));
  PetscCall(MPIU_Allreduce(count, total, (PetscMPIInt)body_count, MPIU_INT64, MPI_SUM, grid->comm));
  for (PetscInt b = 0; b < body_count; b++) {
    MpmCheckInput(total[b] > 0, "-mpm_body_%s_region: there is no point in it%s", bodies[b]->name,
                  bodies[b]->beside.winner_count ? "; bodies with priority took all of it" : "");
  }
  particles->total = 0;
  PetscCall(MpmParticlesRelease(particles));
  PetscCall(DMSwarmSetLocalSizes(particles->swarm, local, MPM_PARTICLES_SPARE));
  PetscCall(MpmParticlesGetArrays(particles, &points));
  PetscCall(PetscArrayzero(points.stress, local * particles->stress_size));
  if (points.across) PetscCall(PetscArrayzero(points.across, local));
  if (points.state) PetscCall(PetscArrayzero(points.state, local * particles->state_size));
  for (PetscInt b = 0; b < body_count; b++) {
    bodies[b]->ids.count = (PetscInt)total[b];
    bodies[b]->ids.first = (PetscInt)id;
    id += total[b] + FillIds(bodies[b], grid);
    particles->total += total[b];
    bodies[b]->ids.end = (PetscInt)id;
  }
  PetscCall(MpmBodiesSetGrounds(body_count, bodies, materials, 1));
  for (PetscInt b = 0; b < body_count; b++)
    PetscCall(
      FillBody(bodies[b], grid, materials, particles, bodies[b]->ids.first + before[b] - count[b], &first, &points));
  for (PetscInt b = 0; b < body_count; b++) {
    if (bodies[b]->initial) PetscCall(MpmBodyInitialCheck(bodies[b]->initial, grid->comm));
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &bodies[b]->start.wrong, 1, MPI_INT, MPI_MAX, grid->comm));
    MpmCheckInput(!bodies[b]->start.wrong, "-mpm_body_%s_initial_stress: %s of material %s", bodies[b]->name,
                  bodies[b]->start.wrong == 1 ? "lies outside of the yield surface" : "is none that a state has",
                  materials[bodies[b]->material.first].name);
  }
  if (points.motion.increment) PetscCall(PetscArrayzero(points.motion.increment, local * MPM_INCREMENT(grid->dim)));
  if (points.physics.value) PetscCall(PetscArrayzero(points.physics.value, local * particles->rates));
  if (points.physics.value)
    PetscCall(PetscArrayzero(points.physics.value_gradient, local * particles->rates * grid->dim));
  PetscCall(FillMotion(body_count, bodies, materials, grid, &points));
  PetscCall(MakeRoom(body_count, bodies, materials, grid->comm, id, &points));
  PetscCall(MpmParticlesRestoreArrays(particles, &points));
  PetscCall(PetscFree3(count, before, total));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MpmBodiesOfPoints(PetscInt body_count, const MpmBody bodies[], const MpmPoints *points, PetscInt body_of[])
{
  for (PetscInt p = 0; p < points->count; p++) {
    PetscInt b = 0;

    while (b + 1 < body_count && points->id[p] >= bodies[b]->ids.end) b++;
    body_of[p] = b;
  }
}

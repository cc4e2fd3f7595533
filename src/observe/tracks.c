/*
  Tracks: sets of points whose mean displacement stands in the history. Points are picked in the initial state; each
  point's share travels with it in a field of the particles. Points that are taken away, or leave the grid, are no
  longer in the mean; without any it is not a number, and before the first of them joins a stage 0.
*/
#include "base/columns.h"
#include "options/options.h"
#include "geometry/geometry.h"
#include "particles/particles.h"
#include "query/point_vector.h"
#include "particles/points.h"
#include "selection/selection.h"
#include "particles/body.h"
#include "volume/inertia.h"
#include "query/model.h"
#include "observe/results.h"
#include "observe/tracks.h"

#define ROUNDING 1e-9 /* of the shares' sum, which is 1 while all points are there */

static PetscErrorCode TrackCreate(const MpmOptions *options, const char *name, const MpmGrid *grid, MpmTrack *track)
{
  char       prefix[256], field[256];
  MpmOptions block = {options->comm, prefix, options->record};

  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(track, sizeof(*track)));
  PetscCall(PetscSNPrintf(prefix, sizeof(prefix), "mpm_track_%s_", name));
  PetscCall(PetscSNPrintf(field, sizeof(field), "track_%s", name));
  PetscCall(PetscStrallocpy(name, &track->name));
  PetscCall(PetscStrallocpy(field, &track->share_field));
  PetscCall(MpmOptionsHeading(&block, "Track"));
  PetscCall(MpmSelectionRead(&block, grid, &track->where));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTracksRead(MpmModel model, const MpmOptions *options)
{
  MpmTracks *tracks = &model->results->tracks;

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsBlocks(options, "tracks", "names of the followed sets of points", MPM_OPTIONAL, &tracks->count,
                             &tracks->names));
  PetscCall(PetscCalloc1(tracks->count, &tracks->at));
  for (PetscInt t = 0; t < tracks->count; t++)
    PetscCall(TrackCreate(options, tracks->names[t], model->disc.grid, &tracks->at[t]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTrackDestroy(MpmTrack *track)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(track->name));
  PetscCall(PetscFree(track->share_field));
  PetscCall(MpmRegionDestroy(&track->where.region));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTrackSelect(MpmTrack *track, const MpmGrid *grid, const MpmMaterials *materials,
                              MpmParticles *particles)
{
  MpmPoints  points;
  PetscReal *share;

  PetscFunctionBeginUser;
  PetscCall(MpmParticlesGetArrays(particles, &points));
  PetscCall(MpmParticlesGetField(particles, track->share_field, &share));
  PetscCall(MpmSelectionShare(&track->where, grid, &points, materials, "track", track->name, share));
  PetscCall(MpmParticlesRestoreField(particles, &share));
  PetscCall(MpmParticlesRestoreArrays(particles, &points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  The mean over the points of `field`, less `base` unless that is NULL, and their share of those that were picked. The
  mean is over the points that are there; 0 where there are none.
*/
static PetscErrorCode Mean(const MpmTrack *track, MpmParticles *particles, const char *field, const char *base,
                           PetscReal mean[], PetscReal *there)
{
  const PetscInt dim = particles->dim;
  PetscReal     *share, *x, *x0 = NULL, sum[MPM_MAX_DIM + 1] = {0.};
  PetscInt       count;

  PetscFunctionBeginUser;
  PetscCall(DMSwarmGetLocalSize(particles->swarm, &count));
  PetscCall(MpmParticlesGetField(particles, track->share_field, &share));
  PetscCall(MpmParticlesGetField(particles, field, &x));
  if (base) PetscCall(MpmParticlesGetField(particles, base, &x0));
  for (PetscInt p = 0; p < count; p++) {
    if (share[p] == 0.) continue;
    for (PetscInt a = 0; a < dim; a++) sum[a] += share[p] * (x0 ? x[p * dim + a] - x0[p * dim + a] : x[p * dim + a]);
    sum[dim] += share[p];
  }
  if (base) PetscCall(MpmParticlesRestoreField(particles, &x0));
  PetscCall(MpmParticlesRestoreField(particles, &x));
  PetscCall(MpmParticlesRestoreField(particles, &share));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, sum, (PetscMPIInt)dim + 1, MPIU_REAL, MPIU_SUM,
                           PetscObjectComm((PetscObject)particles->swarm)));
  *there = sum[dim];
  for (PetscInt a = 0; a < dim; a++) mean[a] = *there > 0. && *there < 1. - ROUNDING ? sum[a] / *there : sum[a];
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTrackEvaluate(MpmTrack *track, MpmParticles *particles, PetscBool waiting, PetscReal displacement[],
                                PetscBool *fewer)
{
  PetscReal there;

  PetscFunctionBeginUser;
  PetscCall(Mean(track, particles, "position", "position0", displacement, &there));
  *fewer      = (PetscBool)(there < track->there - ROUNDING);
  track->gone = (PetscBool)(there == 0. && (track->there > 0. || track->gone || !waiting));
  if (track->gone) *fewer = (PetscBool)(*fewer || !track->told);
  if (track->gone) track->told = PETSC_TRUE;
  track->there = there;
  for (PetscInt a = 0; track->gone && a < particles->dim; a++) displacement[a] = NAN;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTrackVelocity(const MpmTrack *track, MpmParticles *particles, PetscReal velocity[])
{
  PetscReal there;

  PetscFunctionBeginUser;
  PetscCall(Mean(track, particles, "velocity", NULL, velocity, &there));
  for (PetscInt a = 0; track->gone && a < particles->dim; a++) velocity[a] = NAN;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- columns ---- */

/* Whether bodies wait for the stage that they join. */
static PetscErrorCode AnyWaits(MpmModel model, PetscBool *any)
{
  PetscFunctionBeginUser;
  *any = PETSC_FALSE;
  if (!model->results->tracks.count || !model->scene.stages.at[0].name) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt b = 0; b < model->scene.bodies->count; b++)
    if (model->state.scheme.parked[b].count) *any = PETSC_TRUE;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, any, 1, MPM_MPI_BOOL, MPI_LOR, model->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode FillTrack(MpmModel model, const MpmColumn *column, PetscReal values[])
{
  MpmTrack *track = &model->results->tracks.at[column->index];
  PetscBool waiting, fewer;

  PetscFunctionBeginUser;
  PetscCall(AnyWaits(model, &waiting));
  PetscCall(MpmTrackEvaluate(track, model->state.particles, waiting, values, &fewer));
  if (fewer && track->gone)
    PetscCall(MpmMonitorNote(&model->monitor, "track %s is nan: its points are gone", track->name));
  else if (fewer)
    PetscCall(MpmMonitorNote(&model->monitor, "track %s: points are gone, it is the mean of the others", track->name));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Factor of the shares in the mean: their sum is less than 1 where points are gone. */
static PetscErrorCode FindFactor(MpmModel model, PetscInt count, const PetscReal share[], PetscReal *factor)
{
  PetscReal there = 0.;

  PetscFunctionBeginUser;
  for (PetscInt p = 0; p < count; p++) there += share[p];
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &there, 1, MPIU_REAL, MPIU_SUM, model->comm));
  *factor = there > 0. && there < 1. - ROUNDING ? 1. / there : 1.;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TrackAlong(MpmModel model, const MpmColumn *column, const MpmPointVector *end,
                                 const PetscReal residual[], PetscReal values[])
{
  const PetscReal *origin = MpmPointNumbersIf(end, MPM_VECTOR_ORIGIN, 0);
  PetscReal       *share, factor;

  PetscFunctionBeginUser;
  (void)residual;
  for (PetscInt a = 0; a < end->dim; a++) values[a] = 0.;
  PetscCall(MpmParticlesGetField(model->state.particles, model->results->tracks.at[column->index].share_field, &share));
  PetscCall(FindFactor(model, end->count, share, &factor));
  for (PetscInt k = 0; k < end->count * end->dim; k++)
    values[k % end->dim] += factor * share[k / end->dim] * (end->x[k] - (origin ? origin[k] : 0.));
  PetscCall(MpmParticlesRestoreField(model->state.particles, &share));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, values, (PetscMPIInt)end->dim, MPIU_REAL, MPIU_SUM, model->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TrackPull(MpmModel model, const MpmColumn *column, const PetscReal weight[], MpmPointVector *end,
                                PetscReal lam[])
{
  PetscReal *share, *origin = MpmPointNumbersIf(end, MPM_VECTOR_ORIGIN, 0), factor;

  PetscFunctionBeginUser;
  (void)lam;
  PetscCall(MpmParticlesGetField(model->state.particles, model->results->tracks.at[column->index].share_field, &share));
  PetscCall(FindFactor(model, end->count, share, &factor));
  for (PetscInt k = 0; k < end->count * end->dim; k++) {
    const PetscReal by = factor * share[k / end->dim] * weight[k % end->dim];

    end->x[k] += by;
    if (origin) origin[k] -= by;
  }
  PetscCall(MpmParticlesRestoreField(model->state.particles, &share));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static const MpmColumnMap track_map = {TrackAlong, TrackPull, PETSC_FALSE};

PetscErrorCode MpmTracksAddColumns(MpmModel model, MpmColumns *columns)
{
  static const char *const parts[] = {"ux", "uy", "uz"};

  PetscFunctionBeginUser;
  for (PetscInt t = 0; t < model->results->tracks.count; t++) {
    const MpmColumn row = {"track", "m", model->disc.dim, parts, FillTrack, NULL, t};

    PetscCall(MpmColumnsAdd(columns, model->results->tracks.names[t], &row));
    MpmColumnsSetMap(columns, &track_map);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode FillVelocity(MpmModel model, const MpmColumn *column, PetscReal values[])
{
  PetscFunctionBeginUser;
  PetscCall(MpmTrackVelocity(&model->results->tracks.at[column->index], model->state.particles, values));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTracksAddVelocities(MpmModel model, MpmColumns *columns)
{
  static const char *const parts[] = {"vx", "vy", "vz"};

  PetscFunctionBeginUser;
  for (PetscInt t = 0; model->disc.context.inertia->dynamic && t < model->results->tracks.count; t++) {
    const MpmColumn row = {"track", "m/s", model->disc.dim, parts, FillVelocity, NULL, t};

    PetscCall(MpmColumnsAdd(columns, model->results->tracks.names[t], &row));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

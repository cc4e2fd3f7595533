/*
  Tracks: sets of points whose mean displacement stands in the history. They are picked in the initial state; each point's
  share travels with it in a field of the particles.
*/
#include "options/options.h"
#include "geometry/geometry.h"
#include "particles/particles.h"
#include "particles/points.h"
#include "particles/selection.h"
#include "run/tracks.h"

PetscErrorCode MpmTrackCreate(const MpmOptions *options, const char *name, const MpmGrid *grid, MpmTrack *track)
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

PetscErrorCode MpmTrackDestroy(MpmTrack *track)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(track->name));
  PetscCall(PetscFree(track->share_field));
  PetscCall(MpmRegionDestroy(&track->where.region));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTrackSelect(MpmTrack *track, const MpmGrid *grid, MpmParticles *particles)
{
  MpmPoints  points;
  PetscReal *share;

  PetscFunctionBeginUser;
  PetscCall(MpmParticlesGetArrays(particles, &points));
  PetscCall(MpmParticlesGetField(particles, track->share_field, &share));
  PetscCall(MpmSelectionShare(&track->where, grid, &points, particles->total, "track", track->name, share));
  PetscCall(MpmParticlesRestoreField(particles, &share));
  PetscCall(MpmParticlesRestoreArrays(particles, &points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The mean over the points of `field`, less `base` unless that is NULL. */
static PetscErrorCode Mean(const MpmTrack *track, MpmParticles *particles, const char *field, const char *base,
                           PetscReal mean[])
{
  const PetscInt dim = particles->dim;
  PetscReal     *share, *x, *x0 = NULL;
  PetscInt       count;

  PetscFunctionBeginUser;
  for (PetscInt a = 0; a < dim; a++) mean[a] = 0.;
  PetscCall(DMSwarmGetLocalSize(particles->swarm, &count));
  PetscCall(MpmParticlesGetField(particles, track->share_field, &share));
  PetscCall(MpmParticlesGetField(particles, field, &x));
  if (base) PetscCall(MpmParticlesGetField(particles, base, &x0));
  for (PetscInt p = 0; p < count; p++) {
    if (share[p] == 0.) continue;
    for (PetscInt a = 0; a < dim; a++) mean[a] += share[p] * (x0 ? x[p * dim + a] - x0[p * dim + a] : x[p * dim + a]);
  }
  if (base) PetscCall(MpmParticlesRestoreField(particles, &x0));
  PetscCall(MpmParticlesRestoreField(particles, &x));
  PetscCall(MpmParticlesRestoreField(particles, &share));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, mean, (PetscMPIInt)dim, MPIU_REAL, MPIU_SUM,
                           PetscObjectComm((PetscObject)particles->swarm)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTrackEvaluate(const MpmTrack *track, MpmParticles *particles, PetscReal displacement[])
{
  PetscFunctionBeginUser;
  PetscCall(Mean(track, particles, "position", "position0", displacement));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTrackVelocity(const MpmTrack *track, MpmParticles *particles, PetscReal velocity[])
{
  PetscFunctionBeginUser;
  PetscCall(Mean(track, particles, "velocity", NULL, velocity));
  PetscFunctionReturn(PETSC_SUCCESS);
}

#pragma once
/*
  The points as a swarm: their fields, and their migration between ranks.
*/
#include <petscdmswarm.h>
#include "base/base.h"
#include "base/types.h"

/* A field of the swarm, by its name there. */
typedef struct {
  char     *name;
  PetscInt  components;
  PetscBool integer;
  PetscBool shared; /* an amount: where a point is divided each half has half of it */
  void     *array;  /* while the swarm's fields are taken; otherwise NULL */
} MpmPointField;

typedef struct MpmParticles {
  DM             swarm;
  PetscInt       field_count;
  MpmPointField *fields; /* all of them, id first */
  PetscInt       dim, F_size, stress_size, state_size, own_size, rates;
  MpmPoints     *held;     /* the fields, from their first use until the number of points changes */
  PetscInt       lent;     /* number of loans not yet restored */
  PetscBool      has_mass; /* set before MpmParticlesCreate() */
  PetscInt64     total;
  PetscReal      imbalance; /* points on the fullest rank over their mean, the most so far */
  PetscInt       rebalances;
  char           lost[192]; /* description of a lost point; empty while all are there */
  PetscBool      gone;      /* missing, not merely in a wrong place */
} MpmParticles;

/* Points that are not there yet, or no longer: all their fields, one point after the other. */
typedef struct MpmParked {
  PetscInt count;
  char    *data;
} MpmParked;

/* Optional fields of the points. */
typedef struct {
  PetscInt  state_size, own_size, rates, parameters;
  PetscBool half_length, increment, faces, part, velocity, affine, acceleration, divisions, origin, across, drawn;
  PetscInt  extra_count, shared; /* fields of one number a point, by name; so many of them, the first, are shared */
  const char *const *extra;
} MpmParticleFields;
PetscErrorCode MpmParticlesCreate(MpmGrid *grid, const MpmParticleFields *fields, MpmParticles *particles);
PetscErrorCode MpmParticlesDestroy(MpmParticles *particles);
/*
  The fields, all of them or one by its name (`array` is the address of a pointer), may be lent several times at once.
  Changing the number of points on a rank is an error while any is. Restore does nothing with arrays that are not lent.
*/
PetscErrorCode MpmParticlesGetArrays(MpmParticles *particles, MpmPoints *points);
PetscErrorCode MpmParticlesRestoreArrays(MpmParticles *particles, MpmPoints *points);
PetscErrorCode MpmParticlesGetField(MpmParticles *particles, const char name[], void *array);
PetscErrorCode MpmParticlesRestoreField(MpmParticles *particles, void *array);
PetscBool      MpmParticlesHaveField(const MpmParticles *particles, const char name[]);
/* Get, unless these arrays are lent already. */
PetscErrorCode MpmParticlesLendArrays(MpmParticles *particles, MpmPoints *points);
/* Returns the fields to the swarm: to be called before the swarm itself changes the number of its points. */
PetscErrorCode MpmParticlesRelease(MpmParticles *particles);
/*
  Sends every point to the rank that owns its cell, however far. Points are counted before and after; one that is
  missing or not in the grid is reported in particles->lost, with equal text on all ranks.
*/
PetscErrorCode MpmParticlesMigrate(MpmParticles *particles, MpmGrid *grid);
/* Takes the points with ids in [first, end) out; `parked` keeps them on this rank, NULL: they are gone. */
PetscErrorCode MpmParticlesRemove(MpmParticles *particles, PetscInt first, PetscInt end, MpmParked *parked);
/* Takes these points of this rank out, ascending. Collective. */
PetscErrorCode MpmParticlesTakeOut(MpmParticles *particles, PetscInt count, const PetscInt index[], MpmParked *parked);
/*
  Points outside of the grid, or where the bed, NULL where there is none, has no data: `here` of this rank, at the
  places `outside`, in ascending order, to be freed; `count` over all ranks. The second function removes points, on all
  ranks: from the last of these places on, the last of all points takes a removed one's place. The arrays are not lent.
*/
PetscErrorCode MpmParticlesFindOutside(MpmParticles *particles, const MpmGrid *grid, const MpmBed *bed, PetscInt *here,
                                       PetscInt **outside, PetscInt *count);
PetscErrorCode MpmParticlesRemoveAt(MpmParticles *particles, PetscInt count, const PetscInt place[]);
/* All points of this rank, copied; the second function replaces the present ones by the copies, which stay. */
PetscErrorCode MpmParticlesKeep(MpmParticles *particles, MpmParked *kept);
PetscErrorCode MpmParticlesTakeUp(MpmParticles *particles, const MpmParked *kept);
/* Size of copies. */
size_t MpmParkedBytes(const MpmParticles *particles, const MpmParked *parked);
/* Puts parked points back; MpmParticlesMigrate() then sends them where they belong. */
PetscErrorCode MpmParticlesReturn(MpmParticles *particles, MpmParked *parked);
/*
  Copies of these points follow the others, in this order; the point and its copy have half each of extensive fields.
  The total is counted anew. Collective.
*/
PetscErrorCode MpmParticlesHalve(MpmParticles *particles, PetscInt count, const PetscInt index[]);
/* Largest number of divisions of a point; room for its halves in the ids (divide.c). */
#define MPM_DIVISIONS 5
/*
  Divides points with an edge over `longest` cells that is `drawn` times as long as at the start, once each, and cuts
  the domains of those divided as often as allowed; `divided`, over all ranks. Collective.
*/
PetscErrorCode MpmParticlesDivide(MpmParticles *particles, const MpmGrid *grid, const MpmMaterial *materials,
                                  PetscReal longest, PetscReal drawn, PetscInt *divided);
/* Spare places of the DMSwarm: without any, it reallocates and clears all fields for each point that leaves. */
#define MPM_PARTICLES_SPARE 16
/* Moves the partition, not the points, when the fullest rank holds too many and another partition has clearly fewer,
   or `always`; `moved`: it has. */
PetscErrorCode MpmParticlesRebalance(MpmParticles *particles, MpmGrid *grid, PetscBool always, PetscBool *moved);
/* Both: points at their ranks, ranks about equally full. Failure: a lost point. */
PetscErrorCode MpmParticlesDistribute(MpmParticles *particles, MpmGrid *grid, MpmOutcome *outcome);
/* Displacements are counted from the points' places as they are. */
PetscErrorCode MpmParticlesStartHere(MpmParticles *particles);
/* Lowest and highest place of all points along each axis, m. Collective. Lends the points' arrays, if not yet lent. */
PetscErrorCode MpmParticlesGetExtents(MpmParticles *particles, MpmPoints *points, PetscReal lower[], PetscReal upper[]);
/* Points come to rest: velocities, their affine fields and accelerations become 0; MpmPointsStop() of lent arrays. */
PetscErrorCode MpmParticlesRest(MpmParticles *particles);
PetscErrorCode MpmPointsStop(const MpmPoints *points, PetscInt dim);
/* Sets a field of one number a point to zero, writing only where it is not zero: contact is mostly far. */
PetscErrorCode MpmPointsClear(PetscInt count, PetscReal value[]);
/* The kinetic energy of this rank's points, J, without that of their affine velocities. */
PetscReal MpmPointsKinetic(const MpmPoints *points, const MpmMaterial *materials, PetscInt dim);

#pragma once
/*
  The points: their fields, migration between ranks, and the bodies that they are made from.
*/
#include <petscdmswarm.h>
#include "geometry/geometry.h"
#include "grid/grid.h"
#include "point/point.h"

#define MPM_INCREMENT(dim) (2 * (dim) * ((dim) + 1)) /* numbers that tell of the last two steps' increments */

/* ---- particles.c ---- */

/* The points' fields, lent by MpmParticlesGetArrays(); NULL where a field is not registered. */
typedef struct {
  PetscInt   count;
  PetscInt  *id, *material;
  PetscReal *x, *x0;      /* position now and at the start, m */
  PetscReal *F;           /* dim x dim, row-major */
  PetscReal *half_length; /* of the initial domain, m; shapes with a domain and tractions only */
  PetscReal *volume0;
  PetscReal *mass;   /* kg; where a point's mass is not its density times volume0: initial stress, other materials */
  PetscReal *stress; /* Cauchy, xx, yy, zz, xy (, yz, xz) */
  PetscReal *state;  /* state_size values */
  PetscReal *value;  /* rate values */
  PetscReal
    *increment; /* of the last step's displacement, dim values, and its gradient by x, row-major; the one before */
} MpmPoints;

/* A field of the swarm, by its name there. */
typedef struct {
  char     *name;
  PetscInt  components;
  PetscBool integer;
} MpmPointField;

typedef struct {
  DM             swarm;
  PetscInt       field_count;
  MpmPointField *fields; /* all of them, id first */
  PetscInt       dim, stress_size, state_size, rates;
  PetscBool      has_half_length, has_increment;
  PetscBool      has_mass; /* set before MpmParticlesCreate() */
  PetscInt64     total;
  PetscReal      imbalance; /* points on the fullest rank over their mean, the most so far */
  PetscInt       rebalances;
  char           lost[192]; /* tells of a point that is lost; empty while all are there */
  PetscBool      gone;      /* it is not merely in a wrong place */
} MpmParticles;

/* Points that are not there yet, or no longer: all their fields, one point after the other. */
typedef struct {
  PetscInt count;
  char    *data;
} MpmParked;

PetscErrorCode MpmParticlesCreate(MpmGrid *grid, PetscInt state_size, PetscInt rates, PetscBool half_length,
                                  PetscBool increment, PetscInt extra_count, char *const extra[],
                                  MpmParticles *particles);
PetscErrorCode MpmParticlesDestroy(MpmParticles *particles);
PetscErrorCode MpmParticlesGetArrays(MpmParticles *particles, MpmPoints *points);
PetscErrorCode MpmParticlesRestoreArrays(MpmParticles *particles, MpmPoints *points);
/*
  Sends every point to the rank that owns its cell, however far. Points are counted before and after; one that is missing
  or not in the grid is told of in particles->lost, the same text on all ranks.
*/
PetscErrorCode MpmParticlesMigrate(MpmParticles *particles, MpmGrid *grid);
/* Takes the points with ids in [first, end) out; `parked` keeps them on this rank, NULL: they are gone. */
PetscErrorCode MpmParticlesRemove(MpmParticles *particles, PetscInt first, PetscInt end, MpmParked *parked);
/* Puts parked points back; MpmParticlesMigrate() then sends them where they belong. */
PetscErrorCode MpmParticlesReturn(MpmParticles *particles, MpmParked *parked);
/* Places that DMSwarm keeps free: with none, it reallocates all fields for each point that leaves; it clears them, too. */
#define MPM_PARTICLES_SPARE 16
/* A point's mass, kg. */
static inline PetscReal MpmPointMass(const MpmPoints *points, const MpmMaterial materials[], PetscInt p)
{
  return points->mass ? points->mass[p] : points->volume0[p] * materials[points->material[p]].density;
}
/*
  Moves the partition, not the points, when the fullest rank holds too many and another partition has a good part fewer,
  or `always`; `moved` tells.
*/
PetscErrorCode MpmParticlesRebalance(MpmParticles *particles, MpmGrid *grid, PetscBool always, PetscBool *moved);
/* Both: points at their ranks, ranks about equally full. `why` is NULL, or tells of a lost point. */
PetscErrorCode MpmParticlesDistribute(MpmParticles *particles, MpmGrid *grid, const char **why);

/* ---- body_file.c ---- */

/* The points of a body that come from a file, this rank's. */
typedef struct _p_MpmImported *MpmImported;
PetscErrorCode MpmImportedCreate(const MpmOptions *block, const MpmGrid *grid, const MpmMaterial *material,
                                 MpmImported *imported);
PetscErrorCode MpmImportedDestroy(MpmImported *imported);
PetscInt       MpmImportedCount(MpmImported imported);
/* Writes them from point `first` on, all but id and material. */
PetscErrorCode MpmImportedFill(MpmImported imported, const MpmGrid *grid, const MpmMaterial *material,
                               PetscInt state_size, PetscInt first, MpmPoints *points);

/* ---- body.c ---- */

typedef struct _p_MpmBody *MpmBody;
/* Bodies, with the names of their blocks. */
typedef struct {
  PetscInt count;
  char   **names;
  MpmBody *at;
} MpmBodies;

PetscErrorCode MpmBodyCreate(const MpmOptions *options, const char *name, const MpmGrid *grid, PetscInt material_count,
                             const MpmMaterial materials[], MpmBody *body);
PetscErrorCode MpmBodyDestroy(MpmBody *body);
/* About how many points the body has; widens the box of cells [lower, upper) to hold its cells. */
PetscErrorCode MpmBodyEstimate(const MpmBody body, const MpmGrid *grid, PetscInt lower[], PetscInt upper[],
                               PetscReal *points);
/* Fills the particles with the points of all bodies; ids do not depend on the number of ranks. */
PetscErrorCode MpmBodiesGenerate(PetscInt body_count, const MpmBody bodies[], const MpmMaterial materials[],
                                 const MpmGrid *grid, MpmParticles *particles);
/* Where a place is to the region of a body; one from a file has none. */
typedef enum { MPM_HOLD_NONE, MPM_HOLD_EDGE, MPM_HOLD_INSIDE } MpmHold;
MpmHold MpmBodyHolds(MpmBody body, const MpmGrid *grid, const PetscReal x[]);
/* Would both have a point at the same places of a cell? */
PetscBool MpmBodiesShareLattice(MpmBody one, MpmBody other);
/* Of the points' domains, in a body that is not from a file. */
void MpmBodyHalfLengths(MpmBody body, const MpmGrid *grid, PetscReal half[]);
/* Points on an edge that the body shares with one of these are theirs. To be called before the points are made. */
PetscErrorCode MpmBodySetBefore(MpmBody body, PetscInt count, const MpmBody before[]);
/* The ids of a body's points, [first, end); known once the points have been made. */
void      MpmBodyGetIds(MpmBody body, PetscInt *first, PetscInt *end);
PetscBool MpmBodyIsImported(MpmBody body);
/* Most cells from point to point on an axis; 0 for bodies from files. */
PetscReal MpmBodySpacing(MpmBody body);
PetscInt  MpmBodyMaterial(MpmBody body);
/* Which body each point belongs to; ids ascend from body to body. */
void MpmBodiesOfPoints(PetscInt body_count, const MpmBody bodies[], const MpmPoints *points, PetscInt body_of[]);

/* ---- memory_estimate.c ---- */

/* Refuses bodies that cannot fit into memory, or whose points PETSc cannot count. */
PetscErrorCode MpmMemoryCheck(const MpmOptions *options, const MpmGrid *grid, PetscInt count, const MpmBody bodies[],
                              char *const names[]);

/* ---- selection.c ---- */

/* Reads `at` and `nearest`, or a region; exactly one of the two ways. */
PetscErrorCode MpmSelectionRead(const MpmOptions *block, const MpmGrid *grid, PetscReal at[], PetscInt *nearest,
                                MpmRegion *region);
/* share = 1/nearest at the nearest points, 0 elsewhere; the option -mpm_<prefix>_<name>_nearest is named in errors. */
PetscErrorCode MpmSelectNearest(const MpmGrid *grid, const MpmPoints *points, PetscInt64 total, const char *prefix,
                                const char *name, const PetscReal at[], PetscInt nearest, PetscReal share[]);
/* share = the point's part of the volume of all points in the region */
PetscErrorCode MpmSelectRegion(const MpmGrid *grid, const MpmPoints *points, const char *prefix, const char *name,
                               MpmRegion region, PetscReal share[]);

/* ---- overburden.c ---- */

/*
  The weight above each point per area of its domain: the integral of the weight density over the vertical column above
  the point's centre, through all domains, averaged over the domain's width. `axis` is the vertical one, `up` +1 or -1
  along it, gravity in m/s2.
*/
typedef struct {
  PetscInt  axis, up;
  PetscReal gravity;
} MpmVertical;
PetscErrorCode MpmOverburden(const MpmGrid *grid, const MpmPoints *points, const MpmVertical *vertical,
                             const PetscReal half_length[], PetscReal pressure[]);

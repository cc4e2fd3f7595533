#pragma once
/*
  The bodies that points are made from.
*/
#include "base/base.h"
#include "base/types.h"
#include "particles/body_file.h"

/* Bodies, with the names of their blocks. */
typedef struct MpmBodies {
  PetscInt  count;
  char    **names;
  MpmBody  *at;
  PetscInt  parts; /* of the material; more than one where bodies are in contact */
  PetscInt *part;  /* part of each body, from 0 on */
} MpmBodies;

/* Makes the b-th of the bodies from its block; those named before it have been made. */
PetscErrorCode MpmBodyCreate(const MpmOptions *options, const MpmGrid *grid, const MpmMaterials *materials,
                             MpmBodies *bodies, PetscInt b);
/* Reads the points of a body whose region is a file, with fields of the physics. */
PetscErrorCode MpmBodyReadFile(const MpmOptions *options, const char *name, const MpmGrid *grid,
                               const MpmMaterials *materials, PetscInt field_count, const MpmFileField fields[],
                               MpmBody body);
/* A field, point by point as they are made, or NULL where the file has none; the water's pressure, which an excess in
   the body's block replaces; and whether the file has masses. */
const PetscReal *MpmBodyFileField(MpmBody body, const char *name);
const PetscReal *MpmBodyFileStart(MpmBody body, const char *name);
PetscBool        MpmBodyFileHasMass(MpmBody body);
/* The passage between columns and points that made its own (handover/handover.h), or NULL. */
const struct MpmHandover *MpmBodyHandover(MpmBody body);
/* The value of the field with a rate that its points start with, `initial_<field>`; of the water's pressure, Pa, the
   excess. */
PetscErrorCode MpmBodyReadStart(const MpmOptions *options, const char *name, const char *field, MpmBody body);
PetscReal      MpmBodyStart(const MpmBody body);
/*
  Initial velocity of its points, the block's or that of its file, and the block's angular velocity about the centre of
  mass, by which points turn, too, as the shape keeps it. `given` is the option in the block, or NULL; `file` the file
  that has a velocity; `run`: another run has written it.
*/
PetscErrorCode MpmBodyReadVelocity(const MpmOptions *options, const char *name, MpmShapeType shape, MpmBody body,
                                   const char **given, const char **file, PetscBool *run);
/* Depths of its columns on a bed, if there is one (body_depth.h, release.h). To be called before points are made. */
PetscErrorCode MpmBodyReadDepth(const MpmOptions *options, const char *name, const MpmGrid *grid, const MpmBed *bed,
                                MpmShapeType shape, MpmEdgeType edge, MpmBody body);
/* Of columns and ground from maps: the integral of their depth, and the sum over points, m3; PETSC_FALSE for other
   bodies, and where another one has priority. */
PetscBool      MpmBodyVolume(MpmBody body, PetscReal *exact, PetscReal *points);
PetscErrorCode MpmBodyDestroy(MpmBody *body);
/* About how many points the body has; widens the box of cells [lower, upper) to hold its cells. */
PetscErrorCode MpmBodyEstimate(const MpmBody body, const MpmGrid *grid, PetscInt lower[], PetscInt upper[],
                               PetscReal *points);
/* Upward direction, 1 or -1 along an axis, for values by height. To be called before the points are made. */
void MpmBodySetVertical(MpmBody body, PetscInt axis, PetscInt up);
/* Fills the particles with the points of all bodies; ids do not depend on the number of ranks. */
PetscErrorCode MpmBodiesGenerate(PetscInt body_count, const MpmBody bodies[], const MpmMaterial *materials,
                                 const MpmGrid *grid, MpmParticles *particles);
/* Where a place is to the region of a body; one from a file has none. */
typedef enum { MPM_HOLD_NONE, MPM_HOLD_EDGE, MPM_HOLD_INSIDE } MpmHold;
MpmHold MpmBodyHolds(MpmBody body, const MpmGrid *grid, const PetscReal x[]);
/* True where the body was drawn as far as to x, and no body with priority there; whatever lattice of points its region
   was filled with. */
PetscBool MpmBodyReaches(MpmBody body, const PetscReal x[]);
/*
  Distance by which the body was drawn farther than a domain of this half-length about a place x in it, along an axis to
  a side (0 lower, 1 upper), m: less than the half-length either way; 0 where the next point of the lattice would be in
  it, and for bodies from files.
*/
PetscReal MpmBodyExcess(MpmBody body, const PetscReal x[], PetscInt axis, PetscInt side, PetscReal half);
/* The body that a point is of; NULL where there is none. */
MpmBody MpmBodyOfPoint(const MpmBodies *bodies, PetscInt id);
/* The number of the body that the p-th of the points is of; as many as there are where it is of none. */
PetscInt MpmBodyNumber(const MpmBodies *bodies, const MpmPoints *points, PetscInt p);
/* True where both would have a point at equal places of a cell. */
PetscBool MpmBodiesShareLattice(MpmBody one, MpmBody other);
/* Of the points' domains, in a body that is not from a file. */
void MpmBodyHalfLengths(MpmBody body, const MpmGrid *grid, PetscReal half[]);
/* Points on an edge that the body shares with one of these are theirs. To be called before the points are made. */
PetscErrorCode MpmBodySetBefore(MpmBody body, PetscInt count, const MpmBody before[]);
/* True where the body replaces others that it overlaps. */
PetscBool MpmBodyHasPriority(MpmBody body);
/* The body gives up what lies within one of these. To be called before the points are made. */
PetscErrorCode MpmBodySetWinners(MpmBody body, PetscInt count, const MpmBody winners[]);
/* The ids of a body's points, [first, end); known once the points have been made. */
void      MpmBodyGetIds(MpmBody body, PetscInt *first, PetscInt *end);
PetscBool MpmBodyIsImported(MpmBody body);
/* True for columns of a map's depth, region raster. */
PetscBool MpmBodyIsReleased(MpmBody body);
/* True where its points start with a uniform stress. Their masses are then fields. */
PetscBool MpmBodyIsStressed(MpmBody body);
/* True where points stand for parts of the lattice's boxes (body_edge.c). */
PetscBool MpmBodyIsCut(MpmBody body);
/* Volume of the body's part of the box between two corners, and its centroid. */
PetscReal MpmBodyPart(const MpmBody body, PetscInt dim, const PetscReal low[], const PetscReal high[],
                      PetscReal centroid[]);
#define MPM_BODY_BOXES 28 /* room for those of a point, and one more */
/* The lattice's boxes of which the point of box `at` has the body's part: itself, and those beside it that it takes.
   The grid is where the body was drawn. */
PetscInt MpmBodyBoxes(const MpmBody body, const MpmGrid *grid, const PetscInt at[], PetscInt boxes[][MPM_MAX_DIM]);
/* The lattice of a body's points: its cells are the points' domains. Not of bodies from files. */
typedef struct {
  PetscReal lower[MPM_MAX_DIM], spacing[MPM_MAX_DIM]; /* m */
  PetscInt  count[MPM_MAX_DIM];
} MpmBodyLattice;
void MpmBodyGetLattice(MpmBody body, MpmBodyLattice *lattice);
/* Filling of the gap down to settled ground where the body joins a stage; AUTO: gaps within a cell. */
typedef enum { MPM_FILL_AUTO, MPM_FILL_YES, MPM_FILL_NO } MpmFill;
MpmFill MpmBodyFills(MpmBody body);
/* The body joins a stage: room is left in the ids. To be called before the points are made. */
void MpmBodySetJoins(MpmBody body);
/* Ids of the points that fill the gap, by column and row. */
PetscInt MpmBodyFillId(MpmBody body, const MpmPoints *points, PetscInt column, PetscInt row);
/* Its region where that is round and cut a lattice of points, or NULL. */
MpmRegion MpmBodyRound(MpmBody body);
/* Most cells from point to point on an axis; 0 for bodies from files. */
PetscReal MpmBodySpacing(MpmBody body);
/* Its material, the first of several; whether its points have their own; and whether one has this. */
PetscInt  MpmBodyMaterial(MpmBody body);
PetscBool MpmBodyIsMixed(MpmBody body);
PetscBool MpmBodyHasMaterial(MpmBody body, PetscInt material);
/* Which body each point belongs to; ids ascend from body to body. */
void MpmBodiesOfPoints(PetscInt body_count, const MpmBody bodies[], const MpmPoints *points, PetscInt body_of[]);

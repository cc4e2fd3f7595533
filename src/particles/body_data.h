#pragma once
/*
  Data of a body, for the files of the object itself: body.c and body_points.c.
*/
#include "base/base.h"
#include "base/types.h"
#include "particles/body.h"
#include "release/body_depth.h"
#include "release/release.h"
#include "particles/body_initial.h"

struct _p_MpmBody {
  char          *name;
  MpmRegion      region;
  MpmImported    imported; /* where the region is a file */
  MpmBodyInitial initial;
  struct {
    PetscReal *stress;    /* Cauchy, with which its points start, Pa; or NULL */
    PetscReal  value;     /* of a field with a rate; of the water's pressure beyond the hydrostatic one */
    PetscBool  own_value; /* the block has it, and it counts for points from a file, too */
    int        wrong;     /* fault of its stress, as MpmBodyStressFill() has it */
  } start;
  struct {
    PetscBool of_block;                       /* the velocity is its block's, and counts for points from a file, too */
    PetscReal velocity[MPM_MAX_DIM], spin[3]; /* m/s; rad/s, 2D: the third */
    PetscBool spins;
    PetscBool averaged; /* the shape is averaged over the points' domains */
    PetscInt  degree;   /* of splines, by which affine velocities are kept (momentum.c) */
  } motion;
  PetscInt dim;
  struct {
    PetscInt   first, last; /* in -mpm_materials, of those that its points have; -1: not known yet */
    PetscBool *has;         /* by material, where points have their own; else NULL */
  } material;
  struct {
    PetscInt axis, up; /* of gravity, and which way is up, 1 or -1 */
  } vertical;
  struct {
    PetscInt first, end, count;
  } ids;
  struct {
    MpmFill   fill;  /* gap down to settled ground where it joins a stage */
    PetscBool joins; /* joins a stage; room for filling points is left behind its ids */
    PetscInt  rows;
  } filling;
  struct {
    PetscInt per_cell[MPM_MAX_DIM];
    PetscInt lower[MPM_MAX_DIM], upper[MPM_MAX_DIM]; /* the cells that the region's bounds meet */
  } cells;
  PetscReal      volume[2]; /* of ground between maps: its integral, and that of its points, m3 */
  MpmBodyLattice lattice;
  MpmBodyDepth   depth;   /* of its columns; NULL: they are none */
  MpmRelease     release; /* its columns, of region raster; or NULL */
  PetscBool      cut; /* points have what the region has of their domains, and of those without a point beside them */
  struct {
    PetscBool priority; /* replaces others that it overlaps */
    PetscInt  before_count, winner_count;
    MpmBody  *before;  /* bodies whose points on a shared edge are not this one's */
    MpmBody  *winners; /* bodies that replace this one */
  } beside;
};

/* Finds the materials of the labels of voxels (body_labels.c). */
PetscErrorCode MpmBodyNameLabels(const MpmOptions *block, const MpmMaterials *materials, MpmBody body);
/* Sets the first and the last of the materials that it has; `none` is the end of the line where there is none. */
PetscErrorCode MpmBodySetMaterials(const MpmOptions *block, PetscInt material_count, const char none[], MpmBody body);
/* True where a place lies in the body's region, and in that of no body that replaces it. */
PetscBool MpmBodyOwns(MpmBody body, const PetscReal x[]);
/* True where the place is on an edge shared with an earlier body that has a point there. */
PetscBool MpmBodyIsTaken(const MpmBody body, const MpmGrid *grid, const PetscReal x[]);
/* Middle of a box of the lattice. */
void MpmBodyBoxPlace(const MpmBody body, const MpmGrid *grid, const PetscInt at[], PetscReal x[]);
/* True where a box without a point has a part of the body that no box beside it takes. */
PetscBool MpmBodyIsLeftOver(const MpmBody body, const MpmGrid *grid, const PetscInt at[], const PetscReal x[]);
/*
  The material of a box of the lattice with a point, and of boxes beside it without one that is nearest to it
  (body_edge.c): its volume, m^dim, and its centroid in place of the box's middle x.
*/
PetscReal MpmBodyCutBox(const MpmBody body, const MpmGrid *grid, const PetscInt at[], PetscReal x[]);

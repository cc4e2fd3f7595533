#pragma once
/*
  Rigid surfaces that hold the material by a penalty (rigid_surface.c), and their contacts with the points (rigid_contact.c).
*/
#include "base/base.h"
#include "base/types.h"

typedef enum { MPM_BOUNDARY_PLANE, MPM_BOUNDARY_SPHERE, MPM_BOUNDARY_CYLINDER, MPM_BOUNDARY_POLYGON } MpmBoundaryType;

/* A surface that holds the material by a penalty. */
typedef struct {
  char           *name, *slip_field[MPM_MAX_DIM]; /* fields of the particles, with stick only */
  MpmBoundaryType type;
  PetscInt        dim;
  PetscReal  point[MPM_MAX_DIM], direction[MPM_MAX_DIM], radius; /* direction: a plane's normal, a cylinder's axis */
  PetscReal  side;                                               /* 1: the material is outside, -1: inside */
  PetscInt   vertex_count;
  PetscReal *vertices, penalty, motion[MPM_MAX_DIM], growth; /* m, times ramp */
  PetscBool  stick, bilateral;
  MpmRegion  region; /* of the contact candidates, at the start */
  MpmRamp    ramp;
} MpmBoundary;

/* Boundaries, with the names of their blocks. */
typedef struct MpmBoundaries {
  PetscInt     count;
  char       **names;
  MpmBoundary *at;
} MpmBoundaries;

/* Where a boundary stands: by how much it has moved, and its radius grown. */
typedef struct {
  PetscReal motion[MPM_MAX_DIM], growth;
} MpmPose;

/* Distance from a boundary, positive where the material is, its gradient and its second derivative. */
typedef struct {
  PetscReal distance, normal[MPM_MAX_DIM], second[MPM_MAX_DIM][MPM_MAX_DIM];
} MpmSurface;

/* A point that may touch a boundary in this step. */
typedef struct {
  PetscInt  point, group, boundary, weight; /* weight: where the face's weights at the group's nodes stand */
  PetscReal face[MPM_MAX_DIM], normal[MPM_MAX_DIM], slip[MPM_MAX_DIM]; /* at the step's start */
  PetscReal stiffness;                                                 /* N/m */
} MpmContact;

/* Those of this rank's points, and what they do. */
typedef struct MpmContacts {
  PetscInt           boundary_count;
  const MpmBoundary *boundaries;
  MpmPose           *before, *after;          /* the boundaries' at the step's start and end */
  PetscReal (*reaction)[MPM_MAX_DIM], *depth; /* of the last step: forces on the body; deepest places behind, m */
  PetscReal   unit, touch;                    /* 1/h; a face that is no further away touches */
  PetscInt    count, capacity;
  MpmContact *contact;
  PetscReal  *weight;
} MpmContacts;

PetscErrorCode MpmBoundaryCreate(const MpmOptions *options, const char *name, const MpmGrid *grid,
                                 MpmBoundary *boundary);
PetscErrorCode MpmBoundaryDestroy(MpmBoundary *boundary);
/* Do the scene's points suit it? */
PetscErrorCode MpmBoundaryCheck(const MpmBoundary *boundary, const MpmGrid *grid, MpmParticles *particles);
/* Where it is about, before it moves: a point of a plane or of an axis, a centre, the middle of the vertices. */
void    MpmBoundaryPlace(const MpmBoundary *boundary, PetscReal x[]);
MpmPose MpmBoundaryPose(const MpmBoundary *boundary, PetscReal time);
void    MpmBoundaryDistance(const MpmBoundary *boundary, const MpmPose *pose, const PetscReal x[], MpmSurface *surface);
/* Room for the boundaries' poses and reactions; the boundaries are borrowed. */
PetscErrorCode MpmContactsCreate(PetscInt count, const MpmBoundary boundaries[], MpmContacts *contacts);
PetscErrorCode MpmContactsDestroy(MpmContacts *contacts);

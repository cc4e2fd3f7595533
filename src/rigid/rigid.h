#pragma once
/*
  Rigid surfaces in contact with the material by a penalty (rigid_surface.c), and their contacts with the points
  (rigid_contact.c).
*/
#include "base/base.h"
#include "base/types.h"
#include "geometry/motion.h"
#include "geometry/solid.h"

/* A surface that holds the material by a penalty. */
typedef struct {
  char       *name, *slip_field[MPM_MAX_DIM]; /* fields of the particles, where tangential */
  PetscInt    dim;
  MpmSolid    solid;
  PetscReal   penalty, friction, adhesion;  /* Coulomb's coefficient; Pa */
  PetscBool   stick, tangential, bilateral; /* tangential: something acts along the surface */
  PetscBool   firm;                         /* the penalty holds for all materials */
  PetscBool   drained, led;                 /* drained to open water; or at `pressure` */
  PetscReal   pressure;                     /* Pa */
  MpmRegion   region;                       /* of the contact candidates, at the start */
  MpmMotion   motion;
  MpmFreedom *freedom;        /* NULL: all of its motion is prescribed */
  PetscBool   augmented;      /* pressures are corrected until the depth is below `penetration` */
  PetscReal   penetration;    /* accepted depth, m */
  char       *pressure_field; /* of the particles, where augmented */
  char       *gap_field;      /* of the particles, where bilateral */
  PetscReal   tension;        /* pull at which a bilateral one opens for good, Pa; 0: none */
  char       *broken_field;   /* of the particles, where it has a tension: 1 where it has let go */
} MpmBoundary;

/* Boundaries, with the names of their blocks. */
typedef struct MpmBoundaries {
  PetscInt     count;
  char       **names;
  MpmBoundary *at;
} MpmBoundaries;

/* The options friction (frictionless, stick, a coefficient or an angle) and adhesion of a block. */
PetscErrorCode MpmFrictionRead(const MpmOptions *block, PetscReal *friction, PetscReal *adhesion, PetscBool *stick);
PetscErrorCode MpmBoundaryCreate(const MpmOptions *options, const char *name, const MpmGrid *grid,
                                 MpmBoundary *boundary);
PetscErrorCode MpmBoundaryDestroy(MpmBoundary *boundary);
MpmPose        MpmBoundaryPose(const MpmBoundary *boundary, PetscReal time);
/* Seen from the place x, the boundary standing there. */
void MpmBoundaryDistance(const MpmBoundary *boundary, const MpmPose *pose, const PetscReal x[], MpmSurface *surface);
/* Refuses points of the scene that do not suit a boundary. */
PetscErrorCode MpmBoundaryCheck(const MpmBoundary *boundary, const MpmGrid *grid, MpmParticles *particles);

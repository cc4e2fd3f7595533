#pragma once
/*
  Rigid surfaces in contact with the material by a penalty (rigid_surface.c), and their contacts with the points
  (rigid_contact.c).
*/
#include "base/base.h"
#include "base/types.h"
#include "geometry/motion.h"
#include "geometry/solid.h"

/* Fields of the points that keep something of a boundary's contact; NULL where there is nothing to keep. */
typedef struct {
  PetscBool face;              /* the history has the largest pressure and the run-up (contact_face.c) */
  char     *slip[MPM_MAX_DIM]; /* where tangential */
  char     *pressure; /* where augmented; its mean over time where friction is by a law of the bed, or `face` */
  char     *rest;     /* pressure of a geostatic state, where the scene has one and the penalty alone acts */
  char     *gap;      /* where bilateral */
  char     *broken;   /* where it has a tension: 1 where it has let go */
} MpmBoundaryFields;

/* Water that passes a boundary where the material touches it. */
typedef struct {
  PetscBool drained, led; /* drained to open water; or at `pressure` */
  PetscReal pressure;     /* Pa */
} MpmBoundaryWater;

/* Bounds of a boundary's contact. */
typedef struct {
  PetscReal penetration; /* accepted depth where augmented, m */
  PetscReal tension;     /* pull at which a bilateral one opens for good, Pa; 0: none */
} MpmBoundaryBounds;

/* A surface that holds the material by a penalty. */
typedef struct MpmBoundary {
  char            *name;
  PetscInt         dim;
  MpmSolid         solid;
  PetscReal        penalty, friction, adhesion;        /* Coulomb's coefficient; Pa */
  PetscBool        stick, tangential, bilateral, firm; /* tangential: something acts along it; firm: penalty is given */
  MpmMaterial     *basal;                              /* friction by a law of the bed; NULL: by the coefficient */
  MpmBoundaryWater water;
  MpmBoundaryFields fields;
  MpmRegion         region; /* of the contact candidates, at the start */
  MpmMotion         motion;
  MpmFreedom       *freedom;   /* NULL: all of its motion is prescribed */
  PetscBool         augmented; /* pressures are corrected until the depth is below `penetration` */
  MpmBoundaryBounds bounds;
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
/* For scenes with a geostatic stage: points keep its depth, so that the material stands where it was drawn. */
PetscErrorCode MpmBoundaryKeepRest(MpmBoundary *boundary);
PetscErrorCode MpmBoundaryDestroy(MpmBoundary *boundary);
MpmPose        MpmBoundaryPose(const MpmBoundary *boundary, PetscReal time);
/* Seen from the place x, the boundary standing there. */
void MpmBoundaryDistance(const MpmBoundary *boundary, const MpmPose *pose, const PetscReal x[], MpmSurface *surface);
/* Refuses points of the scene that do not suit a boundary. */
PetscErrorCode MpmBoundaryCheck(const MpmBoundary *boundary, const MpmMaterials *materials, const MpmGrid *grid,
                                MpmParticles *particles);

#pragma once
/*
  Rigid surfaces that hold the material by a penalty (rigid_surface.c), and their contacts with the points (rigid_contact.c).
*/
#include "base/base.h"
#include "base/types.h"
#include "geometry/motion.h"

typedef enum { MPM_BOUNDARY_PLANE, MPM_BOUNDARY_SPHERE, MPM_BOUNDARY_CYLINDER, MPM_BOUNDARY_POLYGON } MpmBoundaryType;

/* A surface that holds the material by a penalty. */
typedef struct {
  char           *name, *slip_field[MPM_MAX_DIM]; /* fields of the particles, where tangential */
  MpmBoundaryType type;
  PetscInt        dim;
  PetscReal  point[MPM_MAX_DIM], direction[MPM_MAX_DIM], radius; /* direction: a plane's normal, a cylinder's axis */
  PetscReal  side;                                               /* 1: the material is outside, -1: inside */
  PetscInt   vertex_count;
  PetscReal *vertices, penalty;
  PetscReal  friction, adhesion;           /* Coulomb's coefficient; Pa */
  PetscBool  stick, tangential, bilateral; /* tangential: something acts along the surface */
  MpmRegion  region;                       /* of the contact candidates, at the start */
  MpmMotion  motion;
} MpmBoundary;

/* Boundaries, with the names of their blocks. */
typedef struct MpmBoundaries {
  PetscInt     count;
  char       **names;
  MpmBoundary *at;
} MpmBoundaries;

/* Distance from a boundary, positive where the material is, its gradient and its second derivative. */
typedef struct {
  PetscReal distance, normal[MPM_MAX_DIM], second[MPM_MAX_DIM][MPM_MAX_DIM];
} MpmSurface;

PetscErrorCode MpmBoundaryCreate(const MpmOptions *options, const char *name, const MpmGrid *grid,
                                 MpmBoundary *boundary);
PetscErrorCode MpmBoundaryDestroy(MpmBoundary *boundary);
/* Do the scene's points suit it? */
PetscErrorCode MpmBoundaryCheck(const MpmBoundary *boundary, const MpmGrid *grid, MpmParticles *particles);
/* Where it is about, before it moves: a point of a plane or of an axis, a centre, the middle of the vertices. */
void    MpmBoundaryPlace(const MpmBoundary *boundary, PetscReal x[]);
MpmPose MpmBoundaryPose(const MpmBoundary *boundary, PetscReal time);
void    MpmBoundaryDistance(const MpmBoundary *boundary, const MpmPose *pose, const PetscReal x[], MpmSurface *surface);

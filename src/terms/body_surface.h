#pragma once
/*
  Surfaces of bodies, with what acts on them: what is read (body_surface.c), the faces of a step (surface_faces.c) and the
  term (surface_load.c).
*/
#include "base/base.h"
#include "base/types.h"
#include "terms/terms.h"

/* Faces of a body's points that bound the material, on one side of the lattice or on all. */
typedef struct {
  char     *name;
  PetscInt  body, faces;                   /* faces: bits of those that belong to it (outer_faces.h) */
  PetscReal traction[MPM_MAX_DIM], normal; /* Pa on the current faces: a vector; the stress along the outward normal */
  PetscBool loaded;
  MpmRamp   ramp; /* of both */
} MpmBodySurface;

/* Surfaces, with the names of their blocks. */
typedef struct MpmBodySurfaces {
  PetscInt        count;
  char          **names;
  MpmBodySurface *at;
} MpmBodySurfaces;

/* A face that belongs to a surface, as the step starts. */
typedef struct {
  PetscInt  surface, point, group;
  PetscInt  weight;            /* where its weights at the group's nodes stand */
  PetscReal area[MPM_MAX_DIM]; /* outward, m^(dim-1) */
} MpmSurfaceFace;

/* Those of this rank's points. */
typedef struct MpmSurfaceFaces {
  const MpmBodySurfaces *surfaces;
  const MpmLoadActing   *acting; /* by surface */
  PetscReal             *factor; /* by surface, at the step's end */
  PetscInt               face_count, face_capacity, weight_capacity;
  MpmSurfaceFace        *face; /* by groups */
  PetscReal             *weight;
} MpmSurfaceFaces;

PetscErrorCode MpmBodySurfaceCreate(const MpmOptions *options, const char *name, PetscInt dim, const MpmBodies *bodies,
                                    MpmBodySurface *surface);
PetscErrorCode MpmBodySurfacesDestroy(MpmBodySurfaces *surfaces);
/* Surfaces and what acts of them are borrowed; the latter stand one behind the other. */
PetscErrorCode MpmSurfaceFacesCreate(const MpmBodySurfaces *surfaces, const MpmLoadActing *acting,
                                     MpmSurfaceFaces *faces);
PetscErrorCode MpmSurfaceFacesDestroy(MpmSurfaceFaces *faces);
/* Finds the step's faces and their weights (a term's `boxes`). Collective. */
PetscErrorCode MpmSurfaceFacesFind(void *ctx, const MpmRules *rules, const MpmPoints *points, MpmSpace *space);
/* Refuses surfaces that act, and whose bodies are there, without a face. Collective. */
PetscErrorCode       MpmBodySurfacesCheck(const MpmBodySurfaces *surfaces, const MpmLoadActing *acting,
                                          MpmParticles *particles);
extern const MpmTerm MpmTermSurfaces; /* ctx: MpmSurfaceFaces */

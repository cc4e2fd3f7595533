#pragma once
/*
  Loads on the material, which go into the external force.
*/
#include "base/base.h"
#include "base/types.h"
#include "selection/selection.h"
#include "talus/talus.h"

typedef enum { MPM_LOAD_FORCE, MPM_LOAD_GRAVITY, MPM_LOAD_TRACTION, MPM_LOAD_FLUX } MpmLoadType;

/* A load on the material, or a source of water. Forces, fluxes and tractions keep each point's share in a field of the
   particles. */
typedef struct {
  char        *name, *share_field;
  MpmLoadType  type;
  PetscReal    value[MPM_MAX_DIM];   /* of a flux the first one */
  MpmSelection where;                /* forces; of a traction its region */
  PetscInt     face_axis, face_side; /* traction: the face of the points' domains it acts on */
  PetscBool    face_given;
  PetscBool    at_face; /* acts at the face's centre also where shapes have no domain */
  MpmRamp      ramp;
  PetscBool    ramped;  /* by the scene */
  PetscBool    at_ends; /* gravity: acts at both ends of a point's domain (load_weights.c) */
} MpmLoad;

/* Loads, with the names of their blocks. */
typedef struct MpmLoads {
  PetscInt count;
  char   **names;
  MpmLoad *at;
} MpmLoads;

/* Activity of a load, or of a surface's load, in the stage, and its factor. */
struct MpmLoadActing {
  PetscBool active;
  PetscReal start;  /* its ramp counts from here */
  PetscBool forced; /* the caller has set the factor, and the ramp is not asked */
  PetscReal factor;
  PetscInt  first, end; /* of a surface: the ids of its body's points, [first, end) */
  PetscReal outflow;    /* of a surface: outflow of water, m3 so far */
};

PetscErrorCode MpmLoadCreate(const MpmOptions *options, const char *name, const MpmGrid *grid, MpmLoad *load);
PetscErrorCode MpmLoadDestroy(MpmLoad *load);
/* Finds the points that carry the load, in the initial state. */
PetscErrorCode MpmLoadSelect(MpmLoad *load, const MpmGrid *grid, const MpmMaterials *materials,
                             MpmParticles *particles);

/* The axis along which gravity acts most, of all loads, and which way is up on it, 1 or -1; the last axis without any.
   */
void MpmLoadsGetVertical(const MpmLoads *loads, PetscInt dim, PetscInt *axis, PetscInt *up);

/* Adds `factor` times the load to the external force at the local nodes. */
PetscErrorCode MpmLoadApply(const MpmLoad *load, PetscReal factor, const MpmRules *rules, const MpmSum *sum,
                            MpmParticles *particles, PetscReal force[]);
/*
  Adds to the external force `part` times that of `mass`, a share of each point's mass that gravity pulls, less that of
  a Cauchy stress of the points: fields xx, yy, xy (, zz, yz, xz), Pa.
*/
PetscErrorCode MpmLoadApplyPoints(const MpmSum *sum, PetscReal part, const PetscReal mass[],
                                  const PetscReal *const stress[], PetscReal force[]);
/* Adds a body force that is a function of the initial position. */
PetscErrorCode MpmBodyForceApply(MpmBodyForce function, void *ctx, PetscReal time, const MpmSum *sum,
                                 PetscReal force[]);

#pragma once
/*
  Cuts through the material, and the force and moment that it transmits there.
*/
#include "base/base.h"
#include "base/types.h"

/*
  Forces in one cut: those of the material on the side to which the normal points, acting on the other one. Forces in N,
  moments in N m, per metre of thickness in 2D.
*/
typedef struct {
  PetscReal distance;           /* of the place that the scene gives from the section's first one, m */
  PetscReal place[MPM_MAX_DIM]; /* the cut's centroid, m */
  PetscReal area;               /* m2, in 2D m */
  PetscReal force[MPM_MAX_DIM], moment[MPM_MAX_DIM]; /* along the section's axes; 2D: moment[0] about z */
} MpmCut;

/* One cut, or a row of parallel ones, through all points or some of them. */
typedef struct {
  char     *name, *chosen_field; /* 1 at the points that are cut; NULL: all are */
  MpmRegion region;              /* or NULL */
  PetscInt  body;                /* or -1 */
  PetscReal first[MPM_MAX_DIM], last[MPM_MAX_DIM];
  PetscReal axis[MPM_MAX_DIM][MPM_MAX_DIM]; /* the normal, then the directions of shear: right-handed */
  PetscReal about[MPM_MAX_DIM];
  PetscBool has_about; /* otherwise moments are about the cut's centroid */
  PetscBool follow;    /* a row from end to end of the material, wherever it is along the normal */
  PetscInt  count;
  MpmCut   *cuts;
} MpmSection;

/* Sections, with the names of their blocks. */
typedef struct MpmSections {
  PetscInt    count;
  char      **names;
  MpmSection *at;
  PetscBool   made; /* the cuts belong to a step */
} MpmSections;

PetscErrorCode MpmSectionDestroy(MpmSection *section);
/* Finds the points that are cut, in the initial state; the bodies' points have been made. */
PetscErrorCode MpmSectionSelect(MpmSection *section, const MpmBodies *bodies, MpmParticles *particles);
/*
  All cuts at the step's end, from the displacement u at the local nodes; before the step becomes the state.
  `constraints` are read where there are nodes that follow others.
*/
PetscErrorCode MpmSectionsEvaluate(MpmSections *sections, const MpmConstraints *constraints, const MpmSum *sum,
                                   const PetscReal u[], MpmParticles *particles);

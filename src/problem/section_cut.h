#pragma once
/*
  Places of the cuts of sections: shared by section.c and section_cut.c.
*/
#include "space/point_loop.h"
#include "problem/section.h"

/* One cut: s = (d - lower)/(upper - lower), between 0 and 1, at a distance d from the section's first place. */
typedef struct {
  PetscReal lower, upper; /* equal: the cut meets no material */
  PetscReal origin[MPM_MAX_DIM];
} MpmCutRamp;

/* One section under way. */
typedef struct {
  const MpmSection *section;
  PetscReal        *chosen; /* of the points, or NULL */
  MpmCutRamp       *ramps;
  PetscReal        *sums;
} MpmCutPlane;

/* All cuts, with places of the local nodes at the step's end, and room for one group: nodal forces, and the ramp. */
typedef struct {
  const MpmSum         *sum;
  const MpmConstraints *constraints;
  const PetscReal      *u, *by; /* displacements that say where nodes go, and by which points have their fluxes */
  PetscBool             areas;  /* areas are summed with the forces */
  PetscInt              count;
  MpmCutPlane          *planes;
  PetscReal            *place, *ramp, *force, *storage;
  const PetscReal      *fluxes; /* by place in the points' order, where they are made at once; or NULL */
  PetscReal             flux[MPM_MAX_INPUTS];
  MpmBasis              basis;
} MpmCutPass;

/* Distance of a place from the section's first one along its normal, m. */
PetscReal MpmCutDistance(const MpmSection *section, PetscInt dim, const PetscReal y[]);
/* True where a point, or any point of a group, is cut. */
PetscBool MpmCutIsChosen(const MpmCutPlane *plane, PetscInt p);
PetscBool MpmCutAnyChosen(const MpmCutPass *pass, const MpmCutPlane *plane, const MpmGroup *group);
/* Where the local nodes go, [i][a]. */
void MpmCutPlaceNodes(MpmCutPass *pass);
/* The ramps of a section's cuts: of a cell's width, within the material. */
PetscErrorCode MpmCutPlaceRamps(MpmCutPass *pass, MpmCutPlane *plane);
/* A local node's place among the followers where its component c follows, or -1. */
PetscInt MpmCutFollower(const MpmCutPass *pass, PetscInt node, PetscInt c);
/* A point's place at the step's end, from its weights in the pass's basis. */
void MpmCutPlacePoint(const MpmCutPass *pass, const MpmGroup *group, PetscInt p, PetscReal y[]);
/* The range of a group's nodes, and of those that lead them; `own`: of nodes that do not follow alone. */
void MpmCutMeasureNodes(const MpmCutPass *pass, const MpmSection *section, const MpmGroup *group, PetscBool own,
                        PetscReal range[2]);

#pragma once
/*
  Columns of material on a bed, in explicit steps: pressure of their depth, slope of the bed (bed_force.c), balance with
  water at rest (bed_level.c), and resistance of the bed (bed_resistance.c).

  Force on node i, of points p with volume V = A h, area A and depth h; z_p = sum_i w_ip Z_i and its gradient s are of
  the bed as the point's weights see it:

    f_i = sum_p rho g ( (h/2) V M grad w_ip - c V w_ip s )                           depth and slope
        - sum_p phi_i rho g A ( (c d^2 - c_i r_i D_i^2)/2 grad w_ip - c d w_ip s )   the same of water at rest

  with d = e_i - z_p and D_i = e_i - mean z about the level e_i that the points have in the mean at node i. phi_i is 1
  where points fill what that level would wet of the node's support and have a surface that is level beside their bed,
  0 where they fill much less or follow the bed; r_i is 1 where all of the support would be wet. Water at rest up to a
  level has d = h and no force to rounding; a flat bed keeps momentum.

  slope vertical: c = 1, M = I. slope normal: c = cos^2 of the bed's slope, M = c (I - k (1 - c) n n^T), n along the
  horizontal direction of s, k = 1: on a plane bed these are the equations in axes along it. k goes to 0 where the
  surface is level beside the slope, so that a lake rests.

  The pressure of the depth is K times as large in a material with internal friction (bed_earth.c).

  Sources: Gray, Wieland and Hutter (1999), Proc. R. Soc. Lond. A 455, 1841-1874, doi:10.1098/rspa.1999.0383 (axes along
  the bed); Audusse, Bouchut, Bristeau, Klein and Perthame (2004), SIAM J. Sci. Comput. 25, 2050-2065,
  doi:10.1137/S1064827503431090 (balance with water at rest).
*/
#include "assembly/terms.h"
#include "maps/bed.h"
#include "point/material.h"

/* A point and the bed beneath it: m2, m, m, -. */
typedef struct {
  PetscReal area, depth, bed, slope[2];
} MpmOnBed;

/*
  Sums over points at a node: of volume, of it times surface and bed, both above the bed at the node, and times half a
  point's width; of area; of mass, and of it times the bed's slope. Four at a time are a vector in bed_force.c.
*/
enum {
  MPM_BED_VOLUME,
  MPM_BED_SURFACE,
  MPM_BED_HEIGHT,
  MPM_BED_HALF,
  MPM_BED_AREA,
  MPM_BED_MASS,
  MPM_BED_SLOPE,
  MPM_BED_SUMS = MPM_BED_SLOPE + 2
};
/* Those by material: mass, and mass over depth. */
enum { MPM_BED_SHARE, MPM_BED_OVER_DEPTH, MPM_BED_SHARES };
/* The level at a node: e_i, mean bed, its part of phi, r_i times c of the mean slope, k. */
enum { MPM_LEVEL, MPM_LEVEL_BED, MPM_LEVEL_PART, MPM_LEVEL_WET, MPM_LEVEL_TILT, MPM_LEVEL_COUNT };
/* Squares of the slopes of the mean surface and of the bed at the points, sums by volume. */
enum { MPM_STEEP_SURFACE, MPM_STEEP_BED, MPM_STEEP_COUNT };

/* A parameter of a material's law of the bed that a map has. */
typedef struct {
  PetscInt material, place;
  MpmMap   map;
} MpmBedParameter;
typedef struct {
  PetscInt         count;
  MpmBedParameter *at;
} MpmBedByMap;

/* Flow on the bed at a node: shear stress of the law of the bed, Pa, and speed along the bed, m/s. */
typedef struct {
  PetscReal stress, speed;
} MpmBedShear;

/* Forces on the bed in the last increment, each NULL where nobody asks for it. */
typedef struct {
  MpmBedShear *shear;   /* at the nodes */
  PetscReal (*dams)[3]; /* on each dam of the bed, N (dam_force.c) */
} MpmBedForces;

/* Sums of the kinetic energy that lateral friction takes, J: the run's dissipation; and apart, NULL: nobody asks. */
typedef struct {
  PetscReal *dissipated, *apart;
} MpmBedMixed;

/* Points, nodes and groups that arrays have room for. */
typedef struct {
  PetscInt points, nodes, groups;
} MpmBedRoom;

/* Groups about which the mean surface may be level. */
typedef struct {
  PetscInt count, *group;
} MpmBedGentle;

/* Data of the term for a step. */
#define MPM_BED_PARAMETERS 16 /* most of a law */
struct MpmBedFlow {
  const MpmBed *bed;
  PetscInt      materials;
  MpmBedRoom    room;
  MpmOnBed     *point;
  MpmBedGentle  gentle;
  PetscReal    *height; /* of the bed at the local nodes, m */
  PetscReal    *sums, *shares, *level, *steep, *failed, *force;
  PetscReal    *friction; /* force of the resistance in the last increment, N, two a node */
  PetscReal    *drag;     /* of forests at the nodes of the grid (forest.h); NULL: there are none */
  MpmBedForces  on_bed;
  MpmBedMixed   mixed;
  MpmBedByMap   by_map;
  PetscReal    *own; /* [material*MPM_BED_PARAMETERS + place] at a node; NULL: none is by map */
};

/* Two numbers side by side; a pointer to numbers may be taken for one to pairs. */
typedef PetscReal MpmTwo __attribute__((vector_size(2 * sizeof(PetscReal)), aligned(sizeof(PetscReal)), may_alias));

extern const MpmTerm MpmTermBed;
PetscErrorCode       MpmBedFlowDestroy(MpmBedFlow **flow);
/* Parameters of a material's law at the node that they were last found for. */
static inline const double *MpmBedParameters(const MpmBedFlow *flow, const MpmMaterial materials[], PetscInt material)
{
  return flow->own ? &flow->own[material * MPM_BED_PARAMETERS] : materials[material].parameter;
}
/* cos^2 of a slope. */
static inline PetscReal MpmBedCosine2(const MpmBed *bed, const PetscReal slope[])
{
  return bed->normal ? 1. / (1. + slope[0] * slope[0] + slope[1] * slope[1]) : 1.;
}

/* At the local nodes, from the sums there (bed_level.c): the mean level and bed; and what the slopes say of them. */
void MpmBedFindMeans(const MpmSum *sum, MpmBedFlow *flow);
void MpmBedFindLevels(const MpmSum *sum, MpmBedFlow *flow);
/* The groups about which the mean surface may be level; `failed` marks the nodes of those that say so. */
PetscErrorCode MpmBedFindGentle(const MpmSum *sum, MpmBedFlow *flow);
/* Velocities of the nodes after an increment over `kick`, s, with the resistance of the bed (bed_resistance.c). */
PetscErrorCode MpmBedResist(void *ctx, const MpmSum *sum, const PetscReal mass[], PetscReal kick, PetscReal velocity[]);
/* Work of depth, slope and resistance in an increment. */
PetscErrorCode MpmBedWork(const void *ctx, const MpmSum *sum, const PetscReal at[], const PetscReal u[],
                          MpmTermWork *work);
/* State of the points, which are columns, at displacements u of the nodes; adds those without one (bed_columns.c). */
PetscErrorCode MpmBedUpdateColumns(const MpmSum *sum, const PetscReal u[], MpmTrial *trial, PetscInt *failed);
/* Takes energy from oscillations of affine velocities at a step's end (bed_calm.c). */
PetscErrorCode MpmBedCalm(const MpmBedFlow *flow, const MpmSum *sum);
/* Lateral friction of the points with the flow about them, nodes displaced by u (bed_mixing.c). */
PetscErrorCode MpmBedMix(const MpmBedFlow *flow, const MpmSum *sum, const PetscReal u[]);
/* Turns the points' velocities with the bed on their way of the step (bed_turn.c). */
void MpmBedTurn(const MpmBedFlow *flow, const MpmSum *sum);
/* Pressure of a point's depth along the bed over that of a fluid; 1 without internal friction (bed_earth.c). */
PetscReal MpmBedEarthPressure(const MpmSum *sum, PetscInt p, PetscReal depth, PetscReal cosine2);
/* Lengths of a column's domain along the axes over those at the start (bed_stretch.c); not 0: F is no deformation. */
int MpmBedStretch(const double *F, double *V);
/* Takes the shear from F of points where there is much of it; their domains and volumes stay. */
PetscErrorCode MpmBedStraighten(const MpmSum *sum);

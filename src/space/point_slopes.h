#pragma once
/*
  Derivatives of a point's basis functions by its place and by the half-lengths of its domain, and of these by place and
  F: how the weights of a step depend on the state at its start.
*/
#include "space/basis.h"
#include "particles/points.h"
#include "space/rules.h"

#define MPM_F_MAX (MPM_MAX_DIM * MPM_MAX_DIM)

/* Arguments of a point's weights, by axis: its place, or the half-length of its domain. */
typedef enum { MPM_BY_PLACE, MPM_BY_LENGTH, MPM_BY_COUNT } MpmSlopeKind;

/* One point. Lines have `width` numbers an axis. */
typedef struct {
  const MpmSpace *space;
  PetscInt        point, width;
  PetscBool       domain;                               /* weights depend on half-lengths */
  PetscReal       length_by_place[MPM_MAX_DIM];         /* of the half-length on the same axis, cells/m */
  PetscReal       stretch_by_F[MPM_MAX_DIM][MPM_F_MAX]; /* of the half-length before it is clipped, cells */
  PetscReal       length_by_F[MPM_MAX_DIM][MPM_F_MAX];  /* cells */
  PetscReal       stretched[MPM_MAX_DIM];               /* half-length before it is clipped, cells */
  PetscReal       length_by_start[MPM_MAX_DIM];         /* by the relative change of the initial half-length, cells */
  PetscReal      *bend, *weight, *gradient;             /* bend: 1/m2; by half-length: 1/cell and 1/(m cell) */
  PetscReal      *by_place;                             /* of the weights, 1/m */
  PetscReal      *mean[MPM_BY_COUNT];                   /* derivatives of means over the cell, 1/m and 1/cell */
  PetscReal       hoop[2]; /* 1/radius, 1/m, and its derivative by the place; 0 without axial symmetry */
} MpmPointSlopes;

PetscErrorCode MpmPointSlopesCreate(const MpmSpace *space, MpmPointSlopes *slopes);
PetscErrorCode MpmPointSlopesDestroy(MpmPointSlopes *slopes);
/* Of a point of a group, for a space of one shape without smoothing. */
PetscErrorCode MpmPointSlopesFind(const MpmRules *rules, const MpmPoints *points, const MpmGroup *group, PetscInt point,
                                  MpmPointSlopes *slopes);
/*
  Derivatives of weights and gradients, basis[0] to basis[dim], at the group's nodes, along an axis: by the place,
  1/m, or by the half-length, 1/cell.
*/
void MpmPointSlopesBasis(const MpmPointSlopes *slopes, const MpmGroup *group, MpmSlopeKind kind, PetscInt axis,
                         const MpmBasis *basis);
/* Derivatives of the means over the cell at the group's nodes, likewise; where the shape has means. */
void MpmPointSlopesMeans(const MpmPointSlopes *slopes, const MpmGroup *group, MpmSlopeKind kind, PetscInt axis,
                         PetscReal means[]);
/* The sum over the group's nodes i of these derivatives of basis[b] times sums[b][i], b in the order of MpmBasis, but
   for deviations. */
PetscReal MpmPointSlopesSum(const MpmPointSlopes *slopes, const MpmGroup *group, MpmSlopeKind kind, PetscInt axis,
                            PetscReal *const sums[]);
/* The derivative of the weight of a group's node i on an axis, alone. */
PetscReal MpmPointSlopesWeight(const MpmPointSlopes *slopes, PetscInt axis, PetscInt i, MpmSlopeKind kind);
/*
  The change of all half-lengths, in cells, with the place, F and the relative change of the initial half-lengths; and
  the transposed operation, added. `start` may be NULL.
*/
void MpmPointSlopesAlong(const MpmPointSlopes *slopes, PetscInt F_size, const PetscReal dx[], const PetscReal dF[],
                         const PetscReal start[], PetscReal half[]);
void MpmPointSlopesPull(const MpmPointSlopes *slopes, PetscInt F_size, const PetscReal half[], PetscReal x[],
                        PetscReal F[], PetscReal start[]);

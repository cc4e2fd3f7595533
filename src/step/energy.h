#pragma once
/*
  The account of energy in scenes with a dynamic stage (energy.c).
*/
#include "base/base.h"
#include "base/types.h"
#include "talus/talus.h"

/*
  Work of a step, as values at the local nodes, `block` a node, along the axes.

  u         the step's displacement
  at        that at which contact and damping acted; NULL: u
  loads     forces on the material, of which each rank has its share; their mean over the step; NULL: none
  supports  at the owned nodes, forces of prescribed unknowns; 0 at free ones
  local, owned  numbers of nodes
  `kick`    displacement of the work of all but the loads, `part` times; NULL: u, once
  taken     J, other losses by damping, this rank's share, `part` times
  unstrained  there is no trial

  The points, the space and the terms are those of the step; the forces of contact and of damping are evaluated anew.
*/
typedef struct {
  const PetscReal *u, *at, *loads, *supports;
  PetscInt         local, owned;
  const PetscReal *kick;
  PetscReal        part, taken;
  PetscBool        unstrained;
} MpmStepWork;

/* Adds a step, once the trial is found and before the points take it. Collective; without effect in scenes without
   inertia. */
PetscErrorCode MpmEnergyAdd(MpmModel model, const MpmStepWork *work);
/*
  Around changes of the points without a step (a stage's bodies and materials, a geostatic state): Mark before it,
  Rebase after it; the first Rebase opens the account.
*/
PetscErrorCode MpmEnergyMark(MpmModel model);
PetscErrorCode MpmEnergyRebase(MpmModel model);
/*
  Adds `by` times the energy of the affine velocities to that of the start: -1 before and 1 after points are removed,
  in the space of the step.
*/
PetscErrorCode MpmEnergyAddAffine(MpmModel model, PetscReal by);

/*
  At the run's start, in the space of its first step: adds the energy of the affine velocities with which bodies turn,
  where masses are lumped. Collective.
*/
PetscErrorCode MpmEnergyOpen(MpmModel model);

/* Rows of the state (base/rows.h). */
PetscErrorCode MpmEnergyAddRows(MpmModel model);
/* The account as it stands, J, and momenta, kg m/s and kg m2/s about the origin; equal on all ranks. */
typedef struct {
  PetscReal kinetic, elastic, dissipated, external, balance;
  PetscReal momentum[MPM_MAX_DIM], angular[3];
} MpmEnergyReport;
PetscErrorCode MpmEnergyEvaluate(MpmModel model, MpmEnergyReport *report);
/* Its columns of the history. */
PetscErrorCode MpmEnergyAddColumns(MpmModel model, MpmColumns *columns);

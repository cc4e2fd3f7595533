#pragma once
/*
  Shared by the files of this folder.
*/
#include "assembly/terms.h"
#include "entrainment/entrainment.h"
#include "handover/hydrograph.h"
#include "maps/bed.h"
#include "terrain/bed_flow.h"

/* A number, or a map of it: it counts where it has pixels. */
typedef struct {
  PetscReal number;
  MpmMap    map;
} MpmByPlace;

/* Since the start, over all ranks: kg, J, kg m/s. */
typedef struct {
  PetscReal in, out, eroded, deposited;
  PetscReal energy;                          /* kinetic, lost in the exchange with the bed */
  PetscReal mixed;                           /* kinetic, lost by lateral friction of the columns */
  PetscReal nodes;                           /* gain of the nodes' kinetic energy in all increments */
  PetscReal bed[2], friction[2], carried[2]; /* momentum by depth and slope; by resistance; with mass but the eroded */
} MpmEntrainmentAccount;

struct MpmEntrainment {
  MpmBedFlow *flow;
  MpmBed     *bed;
  PetscReal  *dissipated; /* account of the run's energy, J */
  PetscBool   erodes, deposits;
  PetscReal   density; /* of the ground, kg/m3; 0: that of the flow */
  struct {
    PetscBool  distance;        /* by it, otherwise by shear */
    PetscReal  rate;            /* m/(s Pa), or 1/m */
    MpmByPlace depth, strength; /* m, vertical; Pa */
  } erosion;
  struct {
    PetscReal speed, rate; /* m/s */
  } deposition;
  PetscInt                inlets;
  const struct MpmInlet **inlet;
  const PetscReal        *time; /* of the run, s */
  PetscReal              *push; /* of the inlets in the last increment, N, two a local node */
  PetscInt                room; /* nodes */
  MpmEntrainmentAccount   account;
};

/* Inlets hold the velocity of the nodes about them (inlets.c): the force for that, N, into `push`. */
PetscErrorCode MpmInletsHold(MpmEntrainment *of, const MpmSum *sum, const PetscReal mass[], PetscReal kick,
                             PetscReal velocity[]);

extern const MpmTerm MpmTermEntrainment;

/* A step's changes of the bed at owned nodes of the grid: places on its lattice, x fastest, and heights, m. */
typedef struct {
  PetscInt   count;
  PetscInt  *place;
  PetscReal *height;
} MpmBedSteps;
/* Room for the bed's change at all nodes of the grid, which every rank has. */
PetscErrorCode MpmBedChangeCreate(const MpmGrid *grid, MpmBed *bed);
/* Adds the steps of all ranks, on all of them. Collective. */
PetscErrorCode MpmBedChangeAdd(MPI_Comm comm, const MpmBedSteps *steps, MpmBed *bed);

#pragma once
/*
  Mass that a flow over terrain takes from its bed and leaves there, that comes in and goes out, and the account of
  mass, momentum and energy that goes with it.

  Order of calls: MpmEntrainmentRead(), MpmEntrainmentAddTerm() once the terms are there, steps,
  MpmEntrainmentDestroy(). A scene without any of these has model->entrainment NULL, and the calls return at once.

  Erosion. A mass m of the flow at a node grows by

    by shear      dm/dt = rho_g A E/c ,   E = rate (tau - strength) where tau > strength
    by distance   dm/dt = rate |v| m  where tau > strength

  tau the shear stress of the law of the bed, A the area that the points cover, c the cosine of the bed's slope (1
  with slope vertical), |v| the speed along the bed, rho_g the density of the ground. Deposition, below a critical
  speed u:

    dm/dt = -rho_g A rate (1 - v^2/u^2)/c

  Points take part by their mass. Their momentum stays where ground at rest is taken up, so that they slow down; mass
  that is left takes its velocity with it. The bed falls and rises at the nodes by the volume over their area,
  m/(rho_g A_i); ground below the erodible depth stays.

  Sources: Hungr (1995), Can. Geotech. J. 32, 610-623, doi:10.1139/t95-063, and McDougall and Hungr (2005), Can.
  Geotech. J. 42, 1437-1448, doi:10.1139/t05-064 (growth by distance); Fraccarollo and Capart (2002), J. Fluid Mech.
  461, 183-228, doi:10.1017/S0022112002008455, and Iverson (2012), J. Geophys. Res. 117, F03006,
  doi:10.1029/2011JF002189 (ground at rest that enters the flow, by the excess of shear stress); Frank, McArdell,
  Huggel and Vieli (2015), Nat. Hazards Earth Syst. Sci. 15, 2569-2583, doi:10.5194/nhess-15-2569-2015 (a rate in
  proportion to it); Krone (1962), Flume studies of the transport of sediment in estuarial shoaling processes,
  University of California (deposition, with a stress that goes with the square of the speed).
*/
#include "base/base.h"
#include "base/columns.h"
#include "base/types.h"
#include "query/model.h"

/* Options -mpm_erosion_* and -mpm_deposition_*, once the bed and the bodies have been read. */
PetscErrorCode MpmEntrainmentRead(MpmModel model, const MpmOptions *options);
PetscErrorCode MpmEntrainmentDestroy(MpmModel model);
/* The term of the model's problem, behind that of the bed. */
PetscErrorCode MpmEntrainmentAddTerm(MpmModel model);
/* Points [first, first + count) of this rank come in: they go on to their places since this time, s. Collective. */
PetscErrorCode MpmEntrainmentEnter(MpmModel model, PetscInt first, PetscInt count, PetscReal since);
/* Points of this rank at these places are about to be removed. Collective. */
PetscErrorCode MpmEntrainmentLeave(MpmModel model, PetscInt count, const PetscInt place[]);
/* This rank's points without mass, ascending, to be freed; `count` over all ranks. Collective. */
PetscErrorCode MpmEntrainmentFindEmpty(MpmModel model, PetscInt *here, PetscInt **empty, PetscInt *count);

/* The time in which waves on material that comes in now cross a cell, s, with gravity in m/s2; without any the largest
   number. */
PetscReal MpmEntrainmentCrossing(const MpmModel model, PetscReal gravity);

/*
  Adds an increment of the nodes' velocities, m/s, two a local node of this mass, kg. The gain of their kinetic energy
  tells the loss by the transfer between points and nodes from that by the integrator. Collective.
*/
PetscErrorCode MpmEntrainmentAddIncrement(MpmModel model, const PetscReal mass[], const PetscReal before[],
                                          const PetscReal after[]);

/* Columns of the history. */
PetscErrorCode MpmEntrainmentAddColumns(MpmModel model, MpmColumns *columns);
/* True where the bed changes; then bytes of a checkpoint, on rank 0: the change at the nodes; and back. Collective. */
PetscBool      MpmEntrainmentHasChange(const MpmModel model);
PetscErrorCode MpmEntrainmentSave(MpmModel model, MpmTextFile *bytes);
PetscErrorCode MpmEntrainmentLoad(MpmModel model, const MpmTextFile *bytes);

#pragma once
/*
  Force of the flow on dams that have been raised on the bed.
*/
#include "terrain/bed_flow.h"

/*
  Forces of the last step on each dam, N, along x, y and up, in flow->on_bed.dams; nothing where there are no dams.
  Begin: pressure and resistance, from the points at the step's start. Turn: of point p, whose momentum has changed by
  -impulse where it turned with the bed. End: sums over all ranks. Collective, but Turn.
*/
PetscErrorCode MpmDamsBegin(const MpmBedFlow *flow, const MpmSum *sum);
void           MpmDamsTurn(const MpmBedFlow *flow, const MpmSum *sum, PetscInt p, const PetscReal impulse[3]);
PetscErrorCode MpmDamsEnd(const MpmBedFlow *flow, const MpmSum *sum);

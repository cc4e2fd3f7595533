#pragma once
/*
  Small-cut nodes follow well supported ones: aggregated unknowns.
*/
#include "space/space.h"

/*
  Boxes: finds the followers of this rank's nodes and appends boxes that make their masters local. Behind the boxes of
  all terms, before the nodes are numbered. Number: the local numbers, once they are (MpmSpaceEnd()). Collective.
*/
PetscErrorCode MpmExtensionBoxes(const MpmRules *rules, const MpmPoints *points, MpmSpace *space);
PetscErrorCode MpmExtensionNumber(MpmSpace *space);

#pragma once
/*
  Terms of the material's volume without an object of their own.
*/
#include "assembly/terms.h"

extern const MpmTerm MpmTermWaterWeight; /* water taken up by points, where the physics has it (water_weight.c) */
extern const MpmTerm MpmTermGhost;       /* the ghost penalty (ghost_penalty.c) */

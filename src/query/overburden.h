#pragma once
/*
  Weight above a point.
*/
#include "base/base.h"
#include "base/types.h"

/*
  The weight above each point per area of its domain: the integral of the weight density over the vertical column above
  the point's centre, through all domains, averaged over the domain's width. `axis` is the vertical one, `up` +1 or -1
  along it, gravity in m/s2.
*/
typedef struct {
  PetscInt  axis, up;
  PetscReal gravity;
} MpmVertical;
PetscErrorCode MpmOverburden(const MpmGrid *grid, const MpmPoints *points, const MpmVertical *vertical,
                             const PetscReal half_length[], PetscReal pressure[]);

/*
  Domains of columns. Their lengths along the axes grow with the diagonal of the left stretch V = sqrt(F F^T): a flow
  that turns takes what has been drawn out with it, and so must the domain, which stays along the axes of the grid.

  The area of the domain is that of the column's base, l_x l_y det F. V_xx V_yy - det F = V_xy^2 is more than that where
  the base has been sheared. Columns have no memory of shear, which velocities at the scale of a cell add to without
  end; without it the domain would cover many cells in which no material is. The shorter length is therefore at most
  that of a square, and the longer one follows from the area. In a flow along an axis nothing changes.

  Source: Charlton, Coombs and Augarde (2017), doi:10.1016/j.compstruc.2017.05.004 (domains by a stretch).
*/
#include "point/registry.h"
#include "particles/points.h"
#include "space/sum.h"
#include "terrain/bed_flow.h"

#define SKEWED 10.

int MpmBedStretch(const double *F, double *V)
{
  const double area = F[0] * F[3] - F[1] * F[2], transposed[] = {F[0], F[2], F[1], F[3]};
  double       shorter;
  int          a;

  if (MpmStretchFindQuick(2)(transposed, V)) return 1;
  a        = V[0] > V[1] ? 1 : 0;
  shorter  = PetscMin(V[a], PetscSqrtReal(area));
  V[a]     = shorter;
  V[1 - a] = PetscMin(V[1 - a], area / shorter);
  return 0;
}

PetscErrorCode MpmBedStraighten(const MpmSum *sum)
{
  const MpmPoints *points = sum->points;

  PetscFunctionBeginUser;
  for (PetscInt p = 0; p < points->count; p++) {
    PetscReal      *F    = &points->F[p * 4], length[2];
    const PetscReal area = F[0] * F[3] - F[1] * F[2];

    if ((F[0] * F[0] + F[1] * F[1]) * (F[2] * F[2] + F[3] * F[3]) < PetscSqr(SKEWED * area)) continue;
    if (MpmBedStretch(F, length)) continue; /* the next step's space says so */
    F[0] = length[0];
    F[3] = area / length[0];
    F[1] = F[2] = 0.;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

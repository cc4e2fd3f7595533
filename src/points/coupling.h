#pragma once
/*
  Contribution of the mean over a cell to the points' tangents (coupling.c); none where the physics has no mean.
*/
#include "points/spread_mean.h"

/*
  Coupling of the nodes of a cell through its mean m_bar, and f, the flux conjugate to it: one value for each
  unknown of the cell's box, [i][c], and polynomial of the mean (mean_modes.h).

    K_cell += sum_i flux_by_mean_i mean_by_u_i^T + mean_by_u_i (f_by_u_i + sum_j f_by_mean_ij mean_by_u_j)^T
*/
typedef struct {
  PetscReal *flux_by_mean, *mean_by_u, *f_by_u;
} MpmModeCoupling;
typedef struct {
  PetscInt             modes;
  MpmModeCoupling      mode[MPM_MAX_MODES];
  PetscReal            f_by_mean[MPM_MAX_MODES * MPM_MAX_MODES];
  PetscReal           *part[3], *storage; /* those of one group, [c][i] */
  MpmCellWork          cell;
  const MpmSpreadWork *spread; /* means by shares of domains, whose coupling stands elsewhere; or NULL */
} MpmCoupling;

PetscErrorCode MpmCouplingCreate(const MpmSum *sum, MpmCoupling *coupling);
PetscErrorCode MpmCouplingDestroy(MpmCoupling *coupling);
/* A new cell begins: the tangents of its points. */
PetscErrorCode MpmCouplingBegin(const MpmSum *sum, const MpmCell *cell, const PetscReal u[], MpmCoupling *coupling,
                                PetscInt *failed);
/* The vectors of one group's points. */
PetscErrorCode MpmCouplingAddGroup(const MpmSum *sum, const MpmGroup *group, MpmCoupling *coupling);
/* The cell is complete: its products are those of flux_by_mean mean_by_u^T + mean_by_u f_by_u^T from here on. */
void MpmCouplingEnd(const MpmSum *sum, const MpmCell *cell, MpmCoupling *coupling);

#pragma once
/*
  The derivatives of a point's fluxes, and the passes over the cells of a physics that takes a mean over them.
*/
#include "point/layout.h"
#include "points/mean_modes.h"
#include "space/basis.h"
#include "space/space.h"
#include "space/sum.h"

/*
  Derivatives of a point's fluxes, in one row of numbers, as the kernel returns them; N inputs without the mean m_bar.
  All but the first are there with means only.
*/
typedef struct {
  PetscReal *by_input; /* N x N */
  PetscReal *by_mean;  /* of the N fluxes by m_bar */
  PetscReal *of_mean;  /* of the flux conjugate to m_bar by the N inputs */
  PetscReal *second;   /* of that flux by m_bar */
  PetscReal *dm;       /* of the point's share in m_bar by the N inputs */
} MpmTangent;
static inline PetscInt MpmTangentSize(const MpmLayout *layout)
{
  return layout->input.count * layout->input.count + layout->means * (3 * layout->input.count + 1);
}
static inline MpmTangent MpmTangentAt(PetscInt N, PetscReal row[])
{
  return (MpmTangent){row, row + N * N, row + N * (N + 1), row + N * (N + 2), row + N * (N + 2) + 1};
}
/* Data of one point kept by the passes over a cell with a mean. */
typedef struct {
  MpmKernelPoint point;
  MpmBasis       basis;
  PetscReal     *input, *dinput; /* of the kernel, and their change: the mean last */
  PetscReal     *flux;           /* conjugate to them */
  PetscReal     *ddm;            /* second derivatives of the point's own m: N x N */
  MpmTangent     tangent;
} MpmCellPoint;
/* Room for the points of one cell, and the cell's sum of the flux conjugate to m_bar. */
typedef struct {
  MpmCellPoint *point;
  PetscInt      begin; /* where the cell's points begin in the points' order */
  PetscReal    *storage, *values, *dvalues, *force;
  PetscReal     mean_flux[MPM_MAX_MODES];
} MpmCellWork;
PetscErrorCode MpmCellWorkCreate(const MpmSum *sum, MpmCellWork *work);
PetscErrorCode MpmCellWorkDestroy(MpmCellWork *work);
/* The cell's points in the points' order, [begin, end). */
static inline PetscInt MpmCellBegin(const MpmSum *sum, const MpmCell *cell)
{
  return sum->space->groups[cell->group_begin].point_begin;
}
static inline PetscInt MpmCellEnd(const MpmSum *sum, const MpmCell *cell)
{
  return sum->space->groups[cell->group_end - 1].point_end;
}
/* Basis functions, inputs from the nodal values u, and their change from du; either may be NULL. */
PetscErrorCode MpmCellInputs(const MpmSum *sum, const MpmCell *cell, const PetscReal u[], const PetscReal du[],
                             MpmCellWork *work);
/* m_bar from the inputs, and its derivatives; those of m of second order where they are needed. */
PetscErrorCode MpmCellMean(const MpmSum *sum, const MpmCell *cell, PetscBool second, MpmCellWork *work,
                           PetscInt *failed);
/* All of that at u, and the whole fluxes, with the mean's contribution; the step's end into `trial` unless NULL. */
PetscErrorCode MpmCellResidual(const MpmSum *sum, const MpmCell *cell, const PetscReal u[], const MpmTrial *trial,
                               MpmCellWork *work, PetscInt *failed);
/* MpmCellResidual() with tangents in place of the step's end. */
PetscErrorCode MpmCellTangent(const MpmSum *sum, const MpmCell *cell, const PetscReal u[], MpmCellWork *work,
                              PetscInt *failed);
/* Fluxes to nodal forces. */
PetscErrorCode MpmCellScatter(const MpmSum *sum, const MpmCell *cell, const MpmCellWork *work, PetscReal force[]);

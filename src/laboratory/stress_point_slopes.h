#pragma once
/*
  Derivatives of a stress point's start and steps: how its state changes with parameters of its law.

  Order of calls: MpmStressPointStartAlong(); for each step MpmStressPointSlopesCreate(), then
  MpmStressPointSlopesAlong() and MpmStressPointSlopesPull() as often as wanted, MpmStressPointSlopesDestroy().
*/
#include "laboratory/stress_point_impl.h"

/* A change of a point's state, as a row of numbers: places of its parts. Strain and stress are in the test's measures,
   F and what carries the stress at the start are 3 x 3, and the law's history follows. */
enum {
  MPM_CHANGE_STRAIN  = 0,
  MPM_CHANGE_STRESS  = MPM_CHANGE_STRAIN + MPM_SPACE_SYM,
  MPM_CHANGE_F       = MPM_CHANGE_STRESS + MPM_SPACE_SYM,
  MPM_CHANGE_CARRIER = MPM_CHANGE_F + 9,
  MPM_CHANGE_HISTORY = MPM_CHANGE_CARRIER + 9
};
/* Numbers of a change. */
PetscInt MpmStressPointChangeSize(const MpmStressPoint *point);

/* A step of the point from its state now on, at its solution. */
typedef struct {
  const MpmStressPoint *point;
  MpmPointIncrement     increment;
  PetscReal            *by_unknown; /* changes of the end by the unknown strains, a row each */
  PetscReal             jacobian[MPM_SPACE_SYM * MPM_SPACE_SYM], inverse[MPM_SPACE_SYM * MPM_SPACE_SYM];
} MpmStressPointSlopes;

/*
  Of the step of length dt to what `control` prescribes, whose strain at the end is `strain`; the point stands at the
  step's start, and is borrowed.
*/
PetscErrorCode MpmStressPointSlopesCreate(MpmStressPoint *point, const MpmPointControl *control, PetscReal dt,
                                          const PetscReal strain[MPM_SPACE_SYM], MpmStressPointSlopes *slopes);
PetscErrorCode MpmStressPointSlopesDestroy(MpmStressPointSlopes *slopes);
/*
  The change of the step's end with one of its start and a direction of the law's parameters; either may be NULL.
  `outcome`: failure where the law's stress does not change with the strains as the equations need it, at an apex.
*/
PetscErrorCode MpmStressPointSlopesAlong(const MpmStressPointSlopes *slopes, const PetscReal parameter[],
                                         const PetscReal start[], PetscReal end[], MpmOutcome *outcome);
/* The transpose: a derivative of a number by the step's end becomes that by its start. */
PetscErrorCode MpmStressPointSlopesPull(const MpmStressPointSlopes *slopes, const PetscReal end[], PetscReal start[]);
/* The change of the start with the wanted stress, from a point that stands there. */
PetscErrorCode MpmStressPointStartAlong(const MpmStressPoint *point, const PetscReal stress[MPM_SPACE_SYM],
                                        const PetscReal parameter[], PetscReal start[], MpmOutcome *outcome);

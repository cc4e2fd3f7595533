#pragma once
/*
  One material point under prescribed stress and strain: the element test of a laboratory.

  Order of calls: MpmStressPointCreate(), MpmStressPointStart(), MpmStressPointStep() as often as wanted,
  MpmStressPointDestroy(). All are collective, and all ranks have the same state.
*/
#include <petscsnes.h>
#include "base/types.h"
#include "point/strain_measure.h"
#include "talus/talus.h"

typedef enum { MPM_STRESS_CAUCHY, MPM_STRESS_KIRCHHOFF } MpmStressMeasure;
extern const char *const MpmStressMeasures[]; /* their names, NULL behind the last */

/*
  Prescribed values at the end of a step: of each component the stress, Pa, or the strain; or the whole deformation, in
  which case nothing is left to be solved for. In plane strain zz, yz and xz are strains of zero.
*/
typedef struct {
  PetscBool stress[MPM_SPACE_SYM]; /* `value` is the stress, otherwise the strain */
  PetscReal value[MPM_SPACE_SYM];
  PetscBool whole; /* F holds, and nothing else */
  PetscReal F[9];  /* since the start, 3 x 3 */
} MpmPointControl;

/* The point at the end of a step. Strain and F count from the start, not from where the law has no stress. */
typedef struct {
  PetscReal  strain[MPM_SPACE_SYM], stress[MPM_SPACE_SYM]; /* in the measures of the test; - and Pa */
  PetscReal  F[9];                                         /* 3 x 3, row-major */
  PetscReal *history;                                      /* of the law */
} MpmPointState;

/* The equations of a step: prescribed stresses, for strains as unknowns. The unknowns are rank 0's. */
typedef struct {
  PetscInt    count, unknown[MPM_SPACE_SYM]; /* components whose stress is prescribed */
  PetscReal   noise;                         /* residual that rounding leaves */
  SNES        snes;                          /* NULL: nothing to solve for */
  Mat         jacobian;
  Vec         x, f;
  PetscReal   singular[MPM_SPACE_SYM];              /* values of the Jacobian */
  PetscScalar left[MPM_SPACE_SYM * MPM_SPACE_SYM];  /* singular vectors, by columns */
  PetscScalar right[MPM_SPACE_SYM * MPM_SPACE_SYM]; /* by rows */
  PetscInt    newton, linear;                       /* iterations of the last step */
} MpmPointEquations;

typedef struct {
  MPI_Comm           comm;
  PetscMPIInt        rank;
  const MpmMaterial *material;
  PetscInt           dim;
  MpmStressMeasure   stress_measure;
  MpmStrainMeasure   strain_measure;
  MpmKernelSet       kernel;
  PetscReal          F_start[9]; /* the deformation that carries the stress at the start; I where the history does */
  MpmPointState      now, next;
  PetscReal          rate[MPM_SPACE_SYM]; /* of the strain in the last step, 1/s */
  PetscReal          rate_before[MPM_SPACE_SYM];
  PetscReal          stiffness; /* of the law, Pa */
  MpmPointControl    control;   /* of the step under way */
  PetscReal          dt;        /* s */
  MpmPointEquations  equations;
} MpmStressPoint;

/*@
  MpmStressPointCreate - a point of one material

  Input Parameters:
+ comm     - the ranks; SNES and its options live there
. material - borrowed; made for `dim`
. dim      - 2 (plane strain) or 3
- prescribes_stress - of which components the steps will prescribe the stress; NULL: of none

  The measures are fields that the caller sets before MpmStressPointStart().
@*/
PetscErrorCode MpmStressPointCreate(MPI_Comm comm, const MpmMaterial *material, PetscInt dim,
                                    const PetscBool prescribes_stress[MPM_SPACE_SYM], MpmStressPoint *point);
/*@
  MpmStressPointStart - deformation and history with a wanted stress, from the law at rest

  Input Parameter:
. stress - xx, yy, zz, xy, yz, xz in the measure asked for, Pa

  Output Parameter:
. outcome - failure where the law has no such state
@*/
PetscErrorCode MpmStressPointStart(MpmStressPoint *point, const PetscReal stress[MPM_SPACE_SYM], MpmOutcome *outcome);
/*@
  MpmStressPointStep - one step to what is prescribed at its end

  Input Parameters:
+ control - which components are stresses must be as in MpmStressPointCreate()
- dt      - the step's time, s

  Output Parameter:
. outcome - failure where there was no answer: the point then stands where it was
@*/
PetscErrorCode MpmStressPointStep(MpmStressPoint *point, const MpmPointControl *control, PetscReal dt,
                                  MpmOutcome *outcome);
/* Rolls the last step back, once. */
PetscErrorCode MpmStressPointRollBack(MpmStressPoint *point);
PetscErrorCode MpmStressPointDestroy(MpmStressPoint *point);

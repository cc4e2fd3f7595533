#pragma once
/*
  Paths of laboratory tests: prescribed stress and strain of one point, against time.

  A path is a table of stresses and strains by component, linear between its rows; the tests with a name are tables of
  two rows, from time 0 to 1.

  Order of calls: MpmPointPathRead(), MpmPointPathBegin(), MpmPointPathAt(), MpmPointPathDestroy().
*/
#include "base/types.h"
#include "laboratory/stress_point.h"

typedef enum {
  MPM_PATH_ISOTROPIC,
  MPM_PATH_OEDOMETER,
  MPM_PATH_TRIAXIAL_DRAINED,
  MPM_PATH_TRIAXIAL_UNDRAINED,
  MPM_PATH_BIAXIAL_DRAINED,
  MPM_PATH_BIAXIAL_UNDRAINED,
  MPM_PATH_SIMPLE_SHEAR,
  MPM_PATH_TABLE
} MpmPathType;
extern const char *const MpmPathTypes[]; /* their names, NULL behind the last */

typedef struct {
  MpmPathType      type;
  MpmStrainMeasure measure;
  PetscBool        stress[MPM_SPACE_SYM]; /* which components are prescribed as stresses */
  PetscReal        end;                   /* of a path with a name: strain, Pa, or gamma */
  PetscInt         steps;                 /* in all; more where rows of the table make it so */
  PetscInt         rows;
  PetscReal       *time, *value; /* by row; by row and component */
  char            *file;         /* of a table */
} MpmPointPath;

/* The path of a block: path, end, steps, table. Collective. */
PetscErrorCode MpmPointPathRead(const MpmOptions *block, PetscInt dim, MpmStrainMeasure measure, MpmPointPath *path);
/* The time at which it ends. */
PetscReal MpmPointPathEnd(const MpmPointPath *path);
/* Once the stress at the start is known, which is where the path begins: a table must begin there too. */
PetscErrorCode MpmPointPathBegin(const MpmOptions *block, MpmPointPath *path, const PetscReal stress[MPM_SPACE_SYM]);
/* Prescribed values at a time. */
void MpmPointPathAt(const MpmPointPath *path, PetscReal time, MpmPointControl *control);
/* The end of the step after a time before the path's end, and how long steps are there. */
PetscReal      MpmPointPathTarget(const MpmPointPath *path, PetscReal time, PetscReal *length);
PetscErrorCode MpmPointPathDestroy(MpmPointPath *path);

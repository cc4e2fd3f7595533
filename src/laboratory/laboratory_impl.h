#pragma once
/*
  The laboratory of a model, shared by its run, its columns and its derivatives.
*/
#include "base/columns.h"
#include "laboratory/point_path.h"
#include "laboratory/stress_point.h"
#include "laboratory/laboratory.h"

/* One test. */
typedef struct {
  const char      *name;                          /* NULL: the scene's only one, its block `point` */
  char             prefix[PETSC_MAX_OPTION_NAME]; /* of its options */
  PetscInt         material;
  PetscReal        start[MPM_SPACE_SYM]; /* stress there */
  MpmStressMeasure stress_measure;
  MpmStrainMeasure strain_measure;
  MpmPointPath     path;
  MpmStressPoint   point;
  PetscInt         first; /* place of its state among those of all tests */
} MpmLaboratoryTest;

struct MpmLaboratory {
  PetscInt           dim, count;
  char             **names; /* of several tests; NULL: one without */
  MpmLaboratoryTest *tests;
  PetscBool          ready;    /* set up */
  PetscReal          fraction; /* length of the next step over that of the scene's own */
  PetscInt           size;     /* numbers of a state of all tests */
  PetscInt           kept;     /* states that are kept for derivatives: the start's, and each step's */
  PetscReal         *states;
};

/*
  Columns of one test, behind its name where there are several, with their derivatives by a change of the tests' states:
  the row `state` of an MpmPointVector (laboratory_columns.c).
*/
PetscErrorCode MpmLaboratoryTestAddColumns(const MpmLawInfo *info, PetscInt dim, MpmLaboratoryTest *test,
                                           MpmColumns *columns);
/* All columns of the history. */
PetscErrorCode MpmLaboratoryAddColumns(MpmModel model, MpmColumns *columns);

#pragma once
/*
  One option as its reader finds it.
*/
#include "options/options.h"
#include "options/record.h"

/* Text given by the user. */
typedef struct {
  char       *name; /* in full, no dash */
  const char *raw;  /* NULL when the option is absent or has no value; lent by PETSc */
  PetscBool   given;
} MpmItem;

/* Name with the prefix of its block. Free with PetscFree(). */
PetscErrorCode MpmItemFullName(const MpmOptions *options, const char name[], char **full);
/* Looks an option up; MpmItemDestroy() when done. */
PetscErrorCode MpmItemRead(const MpmOptions *options, const MpmOptionSpec *spec, MpmItem *item);
PetscErrorCode MpmItemDestroy(MpmItem *item, PetscBool *set);
/* Ends the run: "-name value: must ..." */
PetscErrorCode MpmItemRefuse(const MpmItem *item, const MpmOptionSpec *spec, const char verb[]);
/* Ends the run, with the option's meaning: "-name value: must ...: Young's modulus (Pa), > 0". */
PetscErrorCode MpmItemRefuseForm(const MpmItem *item, const MpmOptionSpec *spec, const char verb[]);
/* "must lie in (-1, 0.5)", "each must be > 0 Pa" */
PetscErrorCode MpmItemRefuseRange(const MpmItem *item, const MpmOptionSpec *spec, PetscInt count, const char range[]);
/* Ends the run unless a list has as many values as it must. */
PetscErrorCode MpmItemCheckCount(const MpmItem *item, const MpmOptionSpec *spec, PetscInt wanted, PetscInt count);

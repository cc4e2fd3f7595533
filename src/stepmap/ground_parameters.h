#pragma once
/*
  Fields of the scene as parameters: all values of each, whose derivatives an adjoint run finds at the cost of one.
*/
#include "base/base.h"
#include "base/types.h"
#include "ground/ground.h"

#define MPM_GROUND_CHECKS 3    /* directions along which a field's derivatives are checked */
#define MPM_MOST_TANGENTS 1000 /* values of fields that a tangent run takes */

/* One field. */
typedef struct {
  const MpmGround *ground;
  char            *block; /* of the list -mpm_parameters; NULL: of the short form */
  PetscInt         material;
  PetscInt         place_count, *place; /* in the law's parameter table: its number, and those that vary with it */
  PetscBool        density, modulus;    /* the number is the density; E, by whose largest value penalties go */
  PetscInt         largest;             /* of the values */
  PetscReal        by_largest;          /* derivative by it, beside the sums */
  PetscInt         first;               /* of its values among those of all fields */
  PetscReal       *sums;                /* of the adjoint run, MpmGroundAdd() */
} MpmFieldParameter;

/* A direction: of a field, and its room for MpmGroundAlong(). */
typedef struct {
  PetscInt   index;
  PetscReal *along, *change;
} MpmGroundDirection;

/* All of them, and the directions of tangent runs. */
typedef struct MpmFieldParameters {
  PetscInt            count, values;
  MpmFieldParameter  *at;
  PetscInt            direction_count;
  MpmGroundDirection *direction;
} MpmFieldParameters;

/* Adds a field by its name, of a block of -mpm_parameters or NULL. Collective. */
PetscErrorCode MpmFieldParameterAdd(const MpmMaterials *materials, const char name[], const char *block,
                                    MpmFieldParameters *grounds);
PetscErrorCode MpmFieldParametersDestroy(MpmFieldParameters *grounds);
/* Refuses a scene with a part that takes a field's number and has no derivative by it yet. */
PetscErrorCode MpmFieldParametersCheck(const MpmModel model, const MpmFieldParameters *grounds);
/* The directions of a tangent run: by each value, or some at random (`checks`), of the relative size of the values. */
PetscErrorCode MpmGroundDirectionsCreate(PetscBool checks, MpmFieldParameters *grounds);
/* The adjoint run begins; ends: derivatives by the values of all fields, over all ranks. */
PetscErrorCode MpmFieldParametersBegin(MpmFieldParameters *grounds);
PetscErrorCode MpmFieldParametersEnd(MPI_Comm comm, MpmFieldParameters *grounds, PetscReal values[]);
/* The change of a field at point p along a direction (NULL: by 1 there); 0 where the field does not act. */
PetscReal MpmGroundChange(const MpmFieldParameter *parameter, const PetscReal along[], const MpmPoints *points,
                          PetscInt dim, PetscInt p);
/* Directions of a law's numbers, each `stride` from the next, with such a change. */
void MpmGroundDirections(const MpmFieldParameter *parameter, PetscReal change, PetscInt stride, double direction[]);
/* A derivative by the field at point p. */
void MpmGroundTakePoint(const MpmFieldParameter *parameter, const MpmPoints *points, PetscInt dim, PetscInt p,
                        PetscReal by);

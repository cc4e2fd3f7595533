#pragma once
/*
  A number of a scene by its name, and the options that it is of.
*/
#include "base/base.h"
#include "base/range.h"
#include "base/types.h"

/* By what a parameter acts on: numbers of a law, of the physics, a load's magnitude, and numbers of the state from
   which steps start have derivatives in closed form. */
typedef enum { MPM_OF_LAW, MPM_OF_PHYSICS, MPM_OF_LOAD, MPM_OF_START, MPM_OF_OPTION } MpmSceneParameterKind;

/* An option that a parameter is a number of, or a factor of all numbers. */
typedef struct {
  char     *name;  /* with its dash */
  char     *text;  /* in the scene */
  PetscBool given; /* the scene's; otherwise its default */
  PetscInt  place; /* of the number in the text; -1: all of them */
} MpmParameterOption;

/* One number. */
typedef struct {
  char                 *name;   /* "soil.E" */
  char                 *block;  /* of the list -mpm_parameters; NULL: of the short form */
  const char           *option; /* by which messages name it, borrowed; NULL: -mpm_parameters */
  MpmSceneParameterKind kind;
  PetscInt              index;   /* of the material or load; -1: all materials */
  PetscInt              place;   /* in the law's parameter table, or among the physics' values */
  PetscInt              places;  /* of the physics' values that the number is */
  PetscBool             density; /* the law's parameter is the density */
  double                value;   /* in the scene; a factor's is 1 */
  MpmRange              range;   /* of values that its option accepts */
  PetscInt              option_count;
  MpmParameterOption   *options;
} MpmSceneParameter;

typedef struct MpmSceneParameters {
  PetscInt           count;
  MpmSceneParameter *at;
} MpmSceneParameters;

/*
  Options of a parameter. Find: those that its name means, in the record of a scene that has been
  read; refuses a name that means none or several. Set, Reset: another value, and the scene's, in the options in force,
  from which a model may then be made.
*/
PetscErrorCode MpmParameterFindOptions(MpmRecord record, const MpmLoads *loads, MpmSceneParameter *parameter);
PetscErrorCode MpmSceneParameterSet(const MpmSceneParameter *parameter, double value);
PetscErrorCode MpmSceneParameterReset(const MpmSceneParameter *parameter);

/* Whether two parameters are, or are factors of, one number of the scene. */
PetscBool MpmSceneParametersMeet(const MpmSceneParameter *a, const MpmSceneParameter *b);

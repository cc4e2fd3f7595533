#pragma once
/*
  Numbers of a scene by name, by which results are differentiated.
*/
#include "base/base.h"
#include "base/types.h"
#include "talus/talus.h"

typedef enum { MPM_OF_LAW, MPM_OF_LOAD } MpmSceneParameterKind;

/* One number. */
typedef struct {
  char                 *name;  /* "soil.E" */
  char                 *block; /* of the list -mpm_parameters; NULL: of the short form */
  MpmSceneParameterKind kind;
  PetscInt              index;   /* of the material or load */
  PetscInt              place;   /* in the law's parameter table */
  PetscBool             density; /* the law's parameter is the density */
  double                value;
} MpmSceneParameter;

typedef struct MpmSceneParameters {
  PetscInt           count;
  MpmSceneParameter *at;
} MpmSceneParameters;

/* Reads -mpm_parameters and their blocks, or the short form -mpm_gradient_parameters, of a scene that has been read. */
PetscErrorCode MpmSceneParametersRead(MpmModel model, const MpmOptions *options, MpmSceneParameters *parameters);
PetscErrorCode MpmSceneParametersDestroy(MpmSceneParameters *parameters);

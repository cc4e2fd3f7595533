#pragma once
/*
  Numbers of a scene by name, by which results are differentiated.
*/
#include "query/scene.h"
#include "query/scene_parameter.h"
#include "talus/talus.h"
#include "stepmap/ground_parameters.h"

/* Reads -mpm_parameters and their blocks, or the short form -mpm_gradient_parameters, of a scene that has been read. */
PetscErrorCode MpmSceneParametersRead(const MpmOptions *options, const MpmScene *scene, MpmFieldParameters *grounds,
                                      MpmSceneParameters *parameters);
PetscErrorCode MpmSceneParametersDestroy(MpmSceneParameters *parameters);

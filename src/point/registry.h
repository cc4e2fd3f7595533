#pragma once
/*
  Available laws, physics and functions of points, those compiled in and those registered later.
*/
#include "base/base.h"
#include "base/types.h"
#include "talus/talus.h"

/* Finds a law by name, as compiled for a form and an MpmKinematics. Returns PETSC_FALSE where there is none. */
PetscBool MpmLawFind(const char *name, PetscInt kinematics, MpmForm form, MpmLawInfo *info);
/*
  Its functions in all forms. `info` is as compiled for the residual, in plain numbers: stiffness and energy, evaluated
  by steps point by point, take three times as long in the complex ones of the sensitivities.
*/
PetscBool MpmLawFindAll(const char *name, PetscInt kinematics, MpmFunction law[], MpmLawInfo *info);
/* The names of all laws for scenes, NULL-terminated; free the array only. */
PetscErrorCode MpmLawNames(const char ***names);
/* For -help: every law with its own parameters; `block`: of a material. */
PetscErrorCode MpmLawPrintHelp(const MpmOptions *block);
/* A built-in physics with its compiled kernels. */
PetscErrorCode MpmPhysicsCreate(const char *name, MpmPhysics *physics, PetscBool *found);
/* Appends the names of all physics for scenes. */
PetscErrorCode MpmPhysicsList(char **words);
/* The function that gives the diagonal of U = sqrt(F^T F). */
MpmStretch MpmStretchFind(PetscInt dim);
/* MpmStretchFind() to rounding and in less time, for steps that consist of little else. */
MpmStretch MpmStretchFindQuick(PetscInt dim);

/* Entries registered besides those compiled in; NULL behind the last. */
const MpmLawInstance *MpmLawRegistered(PetscInt k);
const MpmPhysics     *MpmPhysicsRegistered(PetscInt k);
/* Loads the files of -mpm_plugin; they stay loaded, and a second time does nothing. Collective. */
PetscErrorCode MpmPluginsLoad(const MpmOptions *options);

#pragma once
#include "base/base.h"

/* The value that Student's t with so many degrees of freedom does not exceed with this probability, in (0.5, 1). */
PetscReal MpmStudentQuantile(PetscReal probability, PetscInt degrees);

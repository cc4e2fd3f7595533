/*
  Directions at right angles.
*/
#include "base/axes.h"

/* To length one; PETSC_FALSE where there is none. */
static PetscBool Normalise(PetscInt dim, PetscReal v[])
{
  PetscReal most = 0., norm = 0.;

  for (PetscInt a = 0; a < dim; a++) most = PetscMax(most, PetscAbsReal(v[a]));
  if (!(most > 0.) || PetscIsInfOrNanReal(most)) return PETSC_FALSE;
  for (PetscInt a = 0; a < dim; a++) norm += PetscSqr(v[a] / most);
  norm = most * PetscSqrtReal(norm);
  for (PetscInt a = 0; a < dim; a++) v[a] /= norm;
  return PETSC_TRUE;
}

PetscBool MpmAxesComplete(PetscInt dim, PetscReal (*axis)[MPM_MAX_DIM])
{
  PetscReal *n = axis[0], *first = axis[1], *second = axis[2];
  PetscInt   longest = 0;

  if (!Normalise(dim, n)) return PETSC_FALSE;
  if (dim == 2) {
    first[0] = -n[1];
    first[1] = n[0];
    return PETSC_TRUE;
  }
  for (PetscInt a = 1; a < 3; a++)
    if (PetscAbsReal(n[a]) > PetscAbsReal(n[longest]) + 1e-9) longest = a;
  for (PetscInt a = 0; a < 3; a++) first[a] = (a == (longest + 1) % 3 ? 1. : 0.) - n[(longest + 1) % 3] * n[a];
  (void)Normalise(3, first);
  for (PetscInt a = 0; a < 3; a++)
    second[a] = n[(a + 1) % 3] * first[(a + 2) % 3] - n[(a + 2) % 3] * first[(a + 1) % 3];
  return PETSC_TRUE;
}

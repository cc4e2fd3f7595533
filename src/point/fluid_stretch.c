/*
  Domains of fluids. With the stretches U = sqrt(F^T F) and V = sqrt(F F^T) the lengths of a domain grow by

    s sqrt(U_aa V_aa) ,   s = (det F / prod_a sqrt(U_aa V_aa))^(1/dim) .

  In a stretch along the axes U = V, and these are its values. Simple shear g turns the one to the material that was
  along an axis, the other to where it has come, with diagonals (2, 2 + g^2)/sqrt(4 + g^2) in one order and in the
  other: their product has no axis, and s takes its growth off. The domain of a solid has the diagonal of U instead;
  in a flow that shears over its bed it would grow across the flow, up to many cells in which no material is.

  Source: Charlton, Coombs and Augarde (2017), doi:10.1016/j.compstruc.2017.05.004 (domains by a stretch).
*/
#include "point/fluid_stretch.h"
#include "point/material.h"

const MpmMaterial *MpmFluidsAmong(const MpmMaterial *materials, PetscInt count)
{
  for (PetscInt m = 0; m < count; m++)
    if (materials[m].info.traits & MPM_LAW_VISCOUS) return materials;
  return NULL;
}

int MpmDomainStretch(const MpmMaterial *fluids, PetscInt m, MpmStretch stretch, PetscInt dim, const PetscReal F[],
                     PetscReal diagonal[])
{
  PetscReal transposed[MPM_MAX_DIM * MPM_MAX_DIM], V[MPM_MAX_DIM], volume;

  if (!fluids || !(fluids[m].info.traits & MPM_LAW_VISCOUS)) return stretch(F, diagonal);
  volume = MpmDeterminant(dim * dim, F);
  for (PetscInt a = 0; a < dim; a++)
    for (PetscInt b = 0; b < dim; b++) transposed[b * dim + a] = F[a * dim + b];
  if (stretch(F, diagonal) || stretch(transposed, V)) return 1;
  for (PetscInt a = 0; a < dim; a++) {
    diagonal[a] = PetscSqrtReal(diagonal[a] * V[a]);
    volume /= diagonal[a];
  }
  volume = PetscPowReal(volume, 1. / (PetscReal)dim);
  for (PetscInt a = 0; a < dim; a++) diagonal[a] *= volume;
  return 0;
}

/*
  The potential of a step: where every material has a stored energy, and nothing acts that has none, an implicit step is
  a minimisation,

    Pi(u) = part sum_p V_p psi(F_p(u)) + 1/2 u . (r(u) + r(0)) + E(u) - f . u ,     d Pi / d u = the residual

  with V_p the points' initial volumes, `part` the weight of the step's end in their forces (generalised-alpha method),
  r the terms that are linear in u with a symmetric matrix, the ghost penalty and inertia, E the energies that other
  terms give by themselves, and f the loads, which are constant in a step. With inertia alone that is (u - u*) . M (u -
  u*)/(2 beta dt^2), but for a constant.

  Sources: Ortiz, Stainier (1999), Comput. Meth. Appl. Mech. Eng. 171, 419-444, doi:10.1016/S0045-7825(98)00219-9; Gast,
  Schroeder, Stomakhin, Jiang, Teran (2015), IEEE Trans. Vis. Comput. Graph. 21, 1103-1115,
  doi:10.1109/TVCG.2015.2459687 (implicit steps as minimisations).
*/
#include "point/layout.h"
#include "point/stored_energy.h"
#include "particles/point_mass.h"
#include "particles/points.h"
#include "space/sum.h"
#include "assembly/terms.h"
#include "volume/inertia.h"
#include "problem/discretization.h"
#include "problem/fields.h"
#include "problem/potential.h"

/* True where the law's stress is the derivative of a known energy, whatever its history. */
static PetscBool HasPotential(const MpmMaterial *material)
{
  const unsigned never = MPM_LAW_PLASTIC | MPM_LAW_VISCOUS | MPM_LAW_LAGGED | MPM_LAW_INTERNAL;

  if (!(material->info.traits & MPM_LAW_SYMMETRIC) || (material->info.traits & never) || material->state_size)
    return PETSC_FALSE;
  return (PetscBool)(material->info.energy ||
                     (material->info.traits & MPM_LAW_FIXED_MODULI && material->info.shear_modulus));
}

PetscBool MpmPotentialExists(const MpmDiscretization *disc)
{
  for (PetscInt m = 0; m < disc->material.count; m++)
    if (!HasPotential(&disc->sum->materials[m])) return PETSC_FALSE;
  return (PetscBool)(MpmTermsHaveEnergy(disc->terms) && MpmFieldsHaveEnergy(disc->layout) && disc->material.parts == 1);
}

/* Energy stored in the points of this rank, in the trial. */
MPM_INLINE PetscReal Stored(const PetscInt dim, const MpmSum *sum, const MpmTrial *trial)
{
  const MpmPoints *points = sum->points;
  PetscReal        total  = 0.;

  for (PetscInt p = 0; p < points->count; p++)
    total +=
      points->volume0[p] * MpmStoredEnergy(&sum->materials[points->material[p]],
                                           MpmPointOwn(points, &sum->materials[points->material[p]], p), dim,
                                           &trial->stress[p * MpmSymSize(dim)], NULL, &trial->F[p * points->F_size]);
  return total;
}

/* 1/2 u . (r(u) + r(0)) of all terms but the points, or the term's own energy, on this rank. */
static PetscErrorCode AddTerms(const MpmDiscretization *disc, const MpmSum *sum, const PetscReal u[], PetscReal *value)
{
  const PetscInt count  = MpmNodesLocal(disc) * disc->block;
  PetscInt       failed = 0;
  PetscReal     *force, *zero;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc2(count, &force, count, &zero));
  PetscCall(MpmTermsResidualQuadratic(disc->terms, sum, u, force, &failed));
  if (disc->context.inertia->active) PetscCall(MpmTermsResidualQuadratic(disc->terms, sum, zero, force, &failed));
  for (PetscInt k = 0; k < count; k++) *value += 0.5 * u[k] * force[k];
  PetscCall(MpmTermsEnergy(disc->terms, sum, u, value, &failed));
  PetscCall(PetscFree2(force, zero));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPotentialEvaluate(const MpmDiscretization *disc, const MpmSum *sum, const PetscReal u[],
                                    const MpmTrial *trial, PetscReal *value, PetscReal *size)
{
  PetscReal part[3] = {0., 0., 0.};

  PetscFunctionBeginUser;
  part[0] = sum->step.part * MPM_BY_DIM(disc->dim, Stored, sum, trial);
  PetscCall(AddTerms(disc, sum, u, &part[1]));
  for (PetscInt k = 0; k < MpmNodesLocal(disc) * disc->block; k++) part[2] -= disc->nodal.force[k] * u[k];
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, part, 3, MPIU_REAL, MPIU_SUM, disc->comm));
  *value = part[0] + part[1] + part[2];
  *size  = PetscAbsReal(part[0]) + PetscAbsReal(part[1]) + PetscAbsReal(part[2]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

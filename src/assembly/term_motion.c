/*
  Steps with inertia over the list of terms, and the work of their forces.
*/
#include "space/space.h"
#include "space/sum.h"
#include "assembly/terms.h"

void MpmTermsRest(const MpmTerms *terms)
{
  for (PetscInt k = 0; k < terms->count; k++)
    if (terms->term[k]->motion.rest) terms->term[k]->motion.rest(terms->ctx[k]);
}

void MpmTermsLend(const MpmTerms *terms, PetscReal mass[], PetscReal velocity[], PetscReal acceleration[])
{
  for (PetscInt k = 0; k < terms->count; k++)
    if (terms->term[k]->motion.lend) terms->term[k]->motion.lend(terms->ctx[k], mass, velocity, acceleration);
}

void MpmTermsTake(const MpmTerms *terms, const PetscReal velocity[], const PetscReal acceleration[])
{
  for (PetscInt k = 0; k < terms->count; k++)
    if (terms->term[k]->motion.take) terms->term[k]->motion.take(terms->ctx[k], velocity, acceleration);
}

PetscReal MpmTermsKinetic(const MpmTerms *terms)
{
  PetscReal kinetic = 0.;

  for (PetscInt k = 0; k < terms->count; k++)
    if (terms->term[k]->motion.kinetic) kinetic += terms->term[k]->motion.kinetic(terms->ctx[k]);
  return kinetic;
}

PetscErrorCode MpmTermsTurn(const MpmTerms *terms, const MpmSum *sum, const PetscReal v[], PetscReal part)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < terms->count; k++)
    if (terms->term[k]->motion.turn) PetscCall(terms->term[k]->motion.turn(terms->ctx[k], sum, v, part));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTermsBear(const MpmTerms *terms, const MpmSum *sum, PetscReal residual[])
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < terms->count; k++)
    if (terms->term[k]->motion.bear) PetscCall(terms->term[k]->motion.bear(terms->ctx[k], sum, residual));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTermsLimit(const MpmTerms *terms, const MpmSum *sum, const PetscReal mass[], PetscReal dt)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < terms->count; k++)
    if (terms->term[k]->motion.limit) PetscCall(terms->term[k]->motion.limit(terms->ctx[k], sum, mass, dt));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MpmTermsArrive(const MpmTerms *terms, const PetscReal u[])
{
  for (PetscInt k = 0; k < terms->count; k++)
    if (terms->term[k]->motion.arrive) terms->term[k]->motion.arrive(terms->ctx[k], u);
}

PetscErrorCode MpmTermsPush(const MpmTerms *terms, const MpmSum *sum, PetscReal force[])
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < terms->count; k++)
    if (terms->term[k]->motion.push) PetscCall(terms->term[k]->motion.push(terms->ctx[k], sum, force));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscBool MpmTermsResistAny(const MpmTerms *terms)
{
  for (PetscInt k = 0; k < terms->count; k++)
    if (terms->term[k]->motion.resist) return PETSC_TRUE;
  return PETSC_FALSE;
}

PetscErrorCode MpmTermsResist(const MpmTerms *terms, const MpmSum *sum, const PetscReal mass[], PetscReal kick,
                              PetscReal velocity[])
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < terms->count; k++)
    if (terms->term[k]->motion.resist)
      PetscCall(terms->term[k]->motion.resist(terms->ctx[k], sum, mass, kick, velocity));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Work of a term's displacement components in u, of the forces at `at`. */
static PetscErrorCode ResidualWork(const MpmTerms *terms, PetscInt k, const MpmSum *sum, const PetscReal at[],
                                   const PetscReal u[], PetscReal *work)
{
  const PetscInt dim = sum->space->dim, bs = sum->block, local = sum->space->local;
  PetscInt       failed = 0;
  PetscReal     *force;

  PetscFunctionBeginUser;
  *work = 0.;
  PetscCall(PetscCalloc1((local * bs), &force));
  PetscCall(terms->term[k]->residual(terms->ctx[k], sum, at, force, &failed));
  for (PetscInt i = 0; i < local; i++)
    for (PetscInt a = 0; a < dim; a++) *work += force[i * bs + a] * u[i * bs + a];
  PetscCall(PetscFree(force));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTermsWork(const MpmTerms *terms, const MpmSum *sum, const PetscReal at[], const PetscReal u[],
                            MpmTermWork *work)
{
  PetscFunctionBeginUser;
  *work = (MpmTermWork){.external = 0.};
  for (PetscInt k = 0; k < terms->count; k++) {
    const MpmTerm *term = terms->term[k];
    PetscReal      taken;

    if (MpmTermsIdle(terms, k)) continue;
    if (term->energy.account != MPM_ACCOUNT_NONE) {
      PetscCall(ResidualWork(terms, k, sum, at, u, &taken));
      if (term->energy.account == MPM_ACCOUNT_EXTERNAL) work->external -= taken;
      else work->dissipated += taken;
    }
    if (term->energy.work) PetscCall(term->energy.work(terms->ctx[k], sum, at, u, work));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

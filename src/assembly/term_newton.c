/*
  Newton's method over the list of terms: each operation of all terms that have it.
*/
#include "assembly/terms.h"

PetscErrorCode MpmTermsNewtonBegin(const MpmTerms *terms, const MpmSum *sum, const PetscReal u[], PetscBool careful)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < terms->count; k++)
    if (terms->term[k]->newton.begin) PetscCall(terms->term[k]->newton.begin(terms->ctx[k], sum, u, careful));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTermsNewtonAccepted(const MpmTerms *terms, const MpmSum *sum, const PetscReal u[], PetscBool *changed)
{
  PetscFunctionBeginUser;
  *changed = PETSC_FALSE;
  for (PetscInt k = 0; k < terms->count; k++)
    if (terms->term[k]->newton.accepted) PetscCall(terms->term[k]->newton.accepted(terms->ctx[k], sum, u, changed));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MpmTermsNewtonEnd(const MpmTerms *terms)
{
  for (PetscInt k = 0; k < terms->count; k++)
    if (terms->term[k]->newton.end) terms->term[k]->newton.end(terms->ctx[k]);
}

PetscBool MpmTermsHold(const MpmTerms *terms)
{
  for (PetscInt k = 0; k < terms->count; k++)
    if (terms->term[k]->newton.holds && terms->term[k]->newton.holds(terms->ctx[k])) return PETSC_TRUE;
  return PETSC_FALSE;
}

void MpmTermsSoften(const MpmTerms *terms, PetscReal factor)
{
  for (PetscInt k = 0; k < terms->count; k++)
    if (terms->term[k]->newton.soften) terms->term[k]->newton.soften(terms->ctx[k], factor);
}

PetscReal MpmTermsFirmness(const MpmTerms *terms)
{
  PetscReal most = 0.;

  for (PetscInt k = 0; k < terms->count; k++)
    if (terms->term[k]->newton.firmness) most = PetscMax(most, terms->term[k]->newton.firmness(terms->ctx[k]));
  return most;
}

PetscErrorCode MpmTermsAddSquares(const MpmTerms *terms, const MpmSum *sum, const PetscReal u[], PetscReal *squares)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < terms->count; k++)
    if (terms->term[k]->newton.squares) PetscCall(terms->term[k]->newton.squares(terms->ctx[k], sum, u, squares));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscReal MpmTermsImbalance(const MpmTerms *terms, const MpmSum *sum, const PetscScalar residual[])
{
  PetscReal most = 0.;

  for (PetscInt k = 0; k < terms->count; k++)
    if (terms->term[k]->newton.imbalance)
      most = PetscMax(most, terms->term[k]->newton.imbalance(terms->ctx[k], sum, residual));
  return most;
}

PetscErrorCode MpmTermsRelax(const MpmTerms *terms, const MpmSum *sum, const PetscReal u[], PetscBool follows,
                             const PetscScalar last[], PetscScalar x[])
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < terms->count; k++)
    if (terms->term[k]->newton.relax) PetscCall(terms->term[k]->newton.relax(terms->ctx[k], sum, u, follows, last, x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MpmTermsGuess(const MpmTerms *terms, const MpmSum *sum, PetscReal factor, PetscScalar x[])
{
  for (PetscInt k = 0; k < terms->count; k++)
    if (terms->term[k]->newton.guess) terms->term[k]->newton.guess(terms->ctx[k], sum, factor, x);
}

void MpmTermsMode(const MpmTerms *terms, const MpmSum *sum, const PetscReal origin[], const PetscReal along[3],
                  const PetscReal turn[3], PetscScalar x[])
{
  for (PetscInt k = 0; k < terms->count; k++)
    if (terms->term[k]->newton.mode) terms->term[k]->newton.mode(terms->ctx[k], sum, origin, along, turn, x);
}

PetscErrorCode MpmTermsAugment(const MpmTerms *terms, const MpmSum *sum, const PetscReal u[], PetscBool first,
                               PetscReal *excess)
{
  PetscFunctionBeginUser;
  *excess = 0.;
  for (PetscInt k = 0; k < terms->count; k++) {
    PetscReal own;

    if (!terms->term[k]->newton.augment) continue;
    PetscCall(terms->term[k]->newton.augment(terms->ctx[k], sum, u, first, &own));
    *excess = PetscMax(*excess, own);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

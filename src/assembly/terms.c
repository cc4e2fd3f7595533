/*
  The list of terms that a problem's residual consists of, and sums over it.
*/
#include "base/outcome.h"
#include "extension/extension.h"
#include "space/space.h"
#include "space/sum.h"
#include "assembly/terms.h"

PetscErrorCode MpmTermsAdd(MpmTerms **handle, const MpmTerm *term, void *ctx)
{
  MpmTerms *terms;

  PetscFunctionBeginUser;
  if (!*handle) PetscCall(PetscNew(handle));
  terms = *handle;
  PetscCall(PetscRealloc((size_t)(terms->count + 1) * sizeof(*terms->term), &terms->term));
  PetscCall(PetscRealloc((size_t)(terms->count + 1) * sizeof(*terms->ctx), &terms->ctx));
  terms->term[terms->count]  = term;
  terms->ctx[terms->count++] = ctx;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTermsDestroy(MpmTerms **terms)
{
  PetscFunctionBeginUser;
  if (!*terms) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscFree((*terms)->term));
  PetscCall(PetscFree((*terms)->ctx));
  PetscCall(PetscFree(*terms));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Answers of terms for their own ranks, made those of all. */
static PetscErrorCode FindNear(const MpmTerms *terms, const MpmSpace *space)
{
  PetscBool **near, *any;
  PetscInt    count = 0;

  PetscFunctionBeginUser;
  if (!space->number.sf) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc2(terms->count, &near, terms->count, &any));
  for (PetscInt k = 0; k < terms->count; k++)
    if (terms->term[k]->near) near[count++] = terms->term[k]->near(terms->ctx[k]);
  for (PetscInt k = 0; k < count; k++) any[k] = *near[k];
  if (count)
    PetscCall(MPIU_Allreduce(MPI_IN_PLACE, any, (PetscMPIInt)count, MPM_MPI_BOOL, MPI_LOR,
                             PetscObjectComm((PetscObject)space->number.sf)));
  for (PetscInt k = 0; k < count; k++) *near[k] = any[k];
  PetscCall(PetscFree2(near, any));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTermsSetUpSpace(const MpmTerms *terms, MpmSpace *space, const MpmRules *rules,
                                  const MpmPoints *points, MpmOutcome *outcome)
{
  PetscFunctionBeginUser;
  PetscCall(MpmSpaceBegin(space, rules, points, outcome));
  if (outcome->code) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt k = 0; k < terms->count; k++)
    if (terms->term[k]->boxes) PetscCall(terms->term[k]->boxes(terms->ctx[k], rules, points, space));
  PetscCall(MpmExtensionBoxes(rules, points, space));
  PetscCall(MpmSpaceEnd(space, rules));
  PetscCall(MpmExtensionNumber(space));
  PetscCall(FindNear(terms, space));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTermsPrepare(const MpmTerms *terms, const MpmTermStep *step)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < terms->count; k++)
    if (terms->term[k]->prepare) PetscCall(terms->term[k]->prepare(terms->ctx[k], step));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTermsLink(const MpmTerms *terms, MpmSpace *space, PetscBool *linked)
{
  PetscBool any = PETSC_FALSE;

  PetscFunctionBeginUser;
  space->extra.link_count = space->parts.couple_count = 0;
  for (PetscInt k = 0; k < terms->count; k++) {
    if (!terms->term[k]->link) continue;
    any = PETSC_TRUE;
    PetscCall(terms->term[k]->link(terms->ctx[k], space));
  }
  if (linked) *linked = any;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTermsKeepStage(const MpmTerms *terms, const MpmSum *sum, const PetscReal u[], PetscReal theta)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < terms->count; k++)
    if (terms->term[k]->step.stage) PetscCall(terms->term[k]->step.stage(terms->ctx[k], sum, u, theta));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTermsCommit(const MpmTerms *terms, const MpmSum *sum, const PetscReal u[], MpmParticles *particles)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < terms->count; k++)
    if (terms->term[k]->step.commit) PetscCall(terms->term[k]->step.commit(terms->ctx[k], sum, u, particles));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTermsPutBack(const MpmTerms *terms, PetscInt points, MpmParticles *particles)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < terms->count; k++)
    if (terms->term[k]->step.put_back) PetscCall(terms->term[k]->step.put_back(terms->ctx[k], points, particles));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTermsBalance(const MpmTerms *terms, const MpmSum *sum, const PetscReal u[], MpmParticles *particles)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < terms->count; k++)
    if (terms->term[k]->step.balance) PetscCall(terms->term[k]->step.balance(terms->ctx[k], sum, u, particles));
  PetscFunctionReturn(PETSC_SUCCESS);
}

unsigned MpmTermsTraits(const MpmTerms *terms)
{
  unsigned traits = 0;

  for (PetscInt k = 0; k < terms->count; k++)
    if (terms->term[k]->traits) traits |= terms->term[k]->traits(terms->ctx[k]);
  return traits;
}

PetscBool MpmTermsNear(const MpmTerms *terms, unsigned traits)
{
  for (PetscInt k = 0; k < terms->count; k++) {
    const MpmTerm *term = terms->term[k];

    if (!term->near || !*term->near(terms->ctx[k])) continue;
    if (!traits || (term->traits && (term->traits(terms->ctx[k]) & traits) == traits)) return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

PetscErrorCode MpmTermsRefuse(const MpmTerms *terms, MpmOutcome *outcome)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < terms->count && !outcome->code; k++)
    if (terms->term[k]->failure.refuses) PetscCall(terms->term[k]->failure.refuses(terms->ctx[k], outcome));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscBool MpmTermsStray(const MpmTerms *terms, const MpmSum *sum, const PetscReal u[])
{
  for (PetscInt k = 0; k < terms->count; k++)
    if (terms->term[k]->failure.stray && terms->term[k]->failure.stray(terms->ctx[k], sum, u)) return PETSC_TRUE;
  return PETSC_FALSE;
}

PetscErrorCode MpmTermsUnheld(const MpmTerms *terms, const MpmSum *sum, const PetscReal u[], MpmOutcome *outcome)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < terms->count; k++)
    if (terms->term[k]->failure.unheld) PetscCall(terms->term[k]->failure.unheld(terms->ctx[k], sum, u, outcome));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscBool MpmTermsIdle(const MpmTerms *terms, PetscInt k)
{
  return (PetscBool)(terms->term[k]->idle && terms->term[k]->idle(terms->ctx[k]));
}

PetscBool MpmTermIsQuadratic(const void *ctx)
{
  (void)ctx;
  return PETSC_TRUE;
}

PetscBool MpmTermsHaveEnergy(const MpmTerms *terms)
{
  for (PetscInt k = 0; k < terms->count; k++) {
    const MpmTerm *term = terms->term[k];

    if (!term->points && !term->energy.stored && !(term->energy.quadratic && term->energy.quadratic(terms->ctx[k])))
      return PETSC_FALSE;
  }
  return PETSC_TRUE;
}

PetscErrorCode MpmTermsEnergy(const MpmTerms *terms, const MpmSum *sum, const PetscReal u[], PetscReal *energy,
                              PetscInt *failed)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < terms->count; k++)
    if (terms->term[k]->energy.stored && !MpmTermsIdle(terms, k))
      PetscCall(terms->term[k]->energy.stored(terms->ctx[k], sum, u, energy, failed));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscBool IsOther(const MpmTerm *term)
{
  return (PetscBool)!term->points;
}

static PetscBool IsQuadratic(const MpmTerm *term)
{
  return (PetscBool)(!term->points && !term->energy.stored);
}

/* Forces of the chosen terms. */
static PetscErrorCode AddResidual(const MpmTerms *terms, PetscBool (*chosen)(const MpmTerm *), const MpmSum *sum,
                                  const PetscReal u[], PetscReal residual[], PetscInt *failed)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < terms->count; k++)
    if (chosen(terms->term[k]) && terms->term[k]->residual && !MpmTermsIdle(terms, k))
      PetscCall(terms->term[k]->residual(terms->ctx[k], sum, u, residual, failed));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTermsResidualPoints(const MpmTerms *terms, const MpmSum *sum, const PetscReal u[],
                                      const MpmTrial *trial, PetscReal residual[], PetscInt *failed)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < terms->count; k++)
    if (terms->term[k]->points) PetscCall(terms->term[k]->points(sum, u, trial, residual, failed));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTermsResidualRest(const MpmTerms *terms, const MpmSum *sum, const PetscReal u[], PetscReal residual[],
                                    PetscInt *failed)
{
  PetscFunctionBeginUser;
  PetscCall(AddResidual(terms, IsOther, sum, u, residual, failed));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTermsResidualQuadratic(const MpmTerms *terms, const MpmSum *sum, const PetscReal u[],
                                         PetscReal residual[], PetscInt *failed)
{
  PetscFunctionBeginUser;
  PetscCall(AddResidual(terms, IsQuadratic, sum, u, residual, failed));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTermsResidual(const MpmTerms *terms, const MpmSum *sum, const PetscReal u[], const MpmTrial *trial,
                                PetscReal residual[], PetscInt *failed)
{
  PetscFunctionBeginUser;
  *failed = 0;
  PetscCall(MpmTermsResidualPoints(terms, sum, u, trial, residual, failed));
  PetscCall(MpmTermsResidualRest(terms, sum, u, residual, failed));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTermsTangent(const MpmTerms *terms, const MpmSum *sum, const PetscReal u[], MpmPattern *pattern,
                               PetscReal residual[], PetscInt *failed)
{
  PetscFunctionBeginUser;
  *failed = 0;
  for (PetscInt k = 0; k < terms->count; k++)
    if (!MpmTermsIdle(terms, k)) PetscCall(terms->term[k]->tangent(terms->ctx[k], sum, u, pattern, residual, failed));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTermsTangentRest(const MpmTerms *terms, const MpmSum *sum, const PetscReal u[], MpmPattern *pattern,
                                   PetscInt *failed)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < terms->count; k++)
    if (!terms->term[k]->points && !MpmTermsIdle(terms, k))
      PetscCall(terms->term[k]->tangent(terms->ctx[k], sum, u, pattern, NULL, failed));
  PetscFunctionReturn(PETSC_SUCCESS);
}

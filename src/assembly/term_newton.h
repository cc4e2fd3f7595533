#pragma once
/*
  Newton's method as terms take part in it: their operations from iterate to iterate, and their measures of a solution.
*/
#include "base/base.h"
#include "base/types.h"

/*
  Optional operations of a term, each collective unless said otherwise; u: displacement at the local unknowns.

  begin      first iterate of a solution; `careful`: secants in place of tangents of sliding contact
  accepted   an iterate that the line search has taken; contacts kept closed are released. `changed`: becomes true where
             the tangent at u is another one than before
  end        end of a solution: exact forces and tangents from here on; not collective
  holds      true where the term, in the iteration under way, keeps contacts closed that its law would open; equal on
             all ranks
  soften     factor on the elastic slip of sticking contact, for a first iterate alone: 1 before the answer; tractions
             at the step's start stay; not collective
  firmness   stiffness against the grid's nodes, over that of the material; 0: nothing is near; not collective
  squares    adds the squares of this rank's forces, N^2; not collective
  imbalance  residual of the term's own unknowns over their loads, from the owned unknowns' residual, on the rank that
             owns them; not collective
  relax      equilibrium of the term's own unknowns, among the owned ones x, while all others stay at u; with `follows`
             within a trust region about `last`, the owned unknowns before
  `guess`    initial values of the term's own unknowns, among the owned ones x: `factor` times the last increment; not
             collective
  mode       values of a rigid motion, translation `along` and rotation `turn` about `origin`, at the term's own
             unknowns, among the owned ones; not collective
  augment    augmented Lagrangian method, after a solution: excess of the violated constraint over its tolerance; above
             1 the multipliers become those at u. `first`: first correction of the step
*/
typedef struct MpmTermNewton {
  PetscErrorCode (*begin)(void *ctx, const MpmSum *sum, const PetscReal u[], PetscBool careful);
  PetscErrorCode (*accepted)(void *ctx, const MpmSum *sum, const PetscReal u[], PetscBool *changed);
  void (*end)(void *ctx);
  PetscBool (*holds)(const void *ctx);
  void (*soften)(void *ctx, PetscReal factor);
  PetscReal (*firmness)(const void *ctx);
  PetscErrorCode (*squares)(const void *ctx, const MpmSum *sum, const PetscReal u[], PetscReal *squares);
  PetscReal (*imbalance)(const void *ctx, const MpmSum *sum, const PetscScalar residual[]);
  PetscErrorCode (*relax)(const void *ctx, const MpmSum *sum, const PetscReal u[], PetscBool follows,
                          const PetscScalar last[], PetscScalar x[]);
  void (*guess)(const void *ctx, const MpmSum *sum, PetscReal factor, PetscScalar x[]);
  void (*mode)(const void *ctx, const MpmSum *sum, const PetscReal origin[], const PetscReal along[3],
               const PetscReal turn[3], PetscScalar x[]);
  PetscErrorCode (*augment)(void *ctx, const MpmSum *sum, const PetscReal u[], PetscBool first, PetscReal *excess);
} MpmTermNewton;

/*
  These operations of all terms (term_newton.c). Hold: true where any term does. Firmness, imbalance, excess: the
  largest. Imbalance, not collective, and excess are 0, relax and `guess` change nothing, where no term has the
  operation.
*/
PetscErrorCode MpmTermsNewtonBegin(const MpmTerms *terms, const MpmSum *sum, const PetscReal u[], PetscBool careful);
PetscErrorCode MpmTermsNewtonAccepted(const MpmTerms *terms, const MpmSum *sum, const PetscReal u[],
                                      PetscBool *changed);
void           MpmTermsNewtonEnd(const MpmTerms *terms);
PetscBool      MpmTermsHold(const MpmTerms *terms);
void           MpmTermsSoften(const MpmTerms *terms, PetscReal factor);
PetscReal      MpmTermsFirmness(const MpmTerms *terms);
PetscErrorCode MpmTermsAddSquares(const MpmTerms *terms, const MpmSum *sum, const PetscReal u[], PetscReal *squares);
PetscReal      MpmTermsImbalance(const MpmTerms *terms, const MpmSum *sum, const PetscScalar residual[]);
PetscErrorCode MpmTermsRelax(const MpmTerms *terms, const MpmSum *sum, const PetscReal u[], PetscBool follows,
                             const PetscScalar last[], PetscScalar x[]);
void           MpmTermsGuess(const MpmTerms *terms, const MpmSum *sum, PetscReal factor, PetscScalar x[]);
void MpmTermsMode(const MpmTerms *terms, const MpmSum *sum, const PetscReal origin[], const PetscReal along[3],
                  const PetscReal turn[3], PetscScalar x[]);
PetscErrorCode MpmTermsAugment(const MpmTerms *terms, const MpmSum *sum, const PetscReal u[], PetscBool first,
                               PetscReal *excess);

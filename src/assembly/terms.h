#pragma once
/*
  Contributions to the residual and to its Jacobian: the table of terms, and the sums over it.
*/
#include "assembly/term_motion.h"
#include "assembly/term_newton.h"
#include "base/base.h"
#include "base/types.h"

/* Properties of a term in a scene, the same in all steps and on all ranks. */
typedef enum {
  MPM_TERM_CONTACT   = 1 << 0, /* forces of surfaces that meet */
  MPM_TERM_BETWEEN   = 1 << 1, /* between bodies of the grid, which both give way */
  MPM_TERM_BILATERAL = 1 << 2, /* some of these forces act wherever the surfaces are */
  MPM_TERM_RELEASES  = 1 << 3, /* some contacts may open */
  MPM_TERM_RUBS      = 1 << 4, /* tractions along the surfaces */
  MPM_TERM_SLIDES    = 1 << 5, /* bounded ones */
  MPM_TERM_AUGMENTED = 1 << 6, /* multipliers, corrected between Newton's solutions */
  MPM_TERM_UNKNOWNS  = 1 << 7  /* unknowns of the term's own */
} MpmTermTrait;

/*
  Optional operations of a term with unknowns of its own, each collective.

  refuses  after `prepare`: fails where there is no state to start from
  stray    true where the solution u is beyond the range of the contact search for it; equal on all ranks
  unheld   after Newton's method failed at u: another reason where an unknown of the term goes on moving
*/
typedef struct {
  PetscErrorCode (*refuses)(const void *ctx, MpmOutcome *outcome);
  PetscBool (*stray)(const void *ctx, const MpmSum *sum, const PetscReal u[]);
  PetscErrorCode (*unheld)(const void *ctx, const MpmSum *sum, const PetscReal u[], MpmOutcome *outcome);
} MpmTermFailure;

/* A step, as terms prepare for it; the particles' arrays are lent to the sum. */
struct MpmTermStep {
  const MpmRules *rules;
  const MpmSum   *sum;
  MpmParticles   *particles;
};

/*
  Optional operations of a term with energy, for the potential of a step and the account of energy.

  account    entry of the work that the term takes from the material
  quadratic  true where the term is linear in u with a symmetric matrix, with an energy of 1/2 u . (r(u) + r(0)) in a
             step. Energy of the points: MpmPotentialExists()
  stored     adds the energy at u whose derivative the residual is, J, this rank's part, in place of `quadratic`; with
             neither the term has no energy
  work       adds other work of the forces at `at` in the displacement u
*/
typedef struct {
  MpmAccount account;
  PetscBool (*quadratic)(const void *ctx);
  PetscErrorCode (*stored)(const void *ctx, const MpmSum *sum, const PetscReal u[], PetscReal *energy,
                           PetscInt *failed);
  PetscErrorCode (*work)(const void *ctx, const MpmSum *sum, const PetscReal at[], const PetscReal u[],
                         MpmTermWork *work);
} MpmTermEnergy;

/*
  Optional operations at the end of a step.

  stage     keeps the first of two sub-steps (sdirk.c), which counts `theta` times in the flow
  commit    keeps the converged step
  put_back  points that return to their places at the step's start, with the stress at its end
  balance   keeps the forces at u of a stress that is in balance where the points stand; NULL: none
*/
typedef struct {
  PetscErrorCode (*stage)(void *ctx, const MpmSum *sum, const PetscReal u[], PetscReal theta);
  PetscErrorCode (*commit)(void *ctx, const MpmSum *sum, const PetscReal u[], MpmParticles *particles);
  PetscErrorCode (*put_back)(const void *ctx, PetscInt points, MpmParticles *particles);
  PetscErrorCode (*balance)(void *ctx, const MpmSum *sum, const PetscReal u[], MpmParticles *particles);
} MpmTermStepEnd;

/*
  A term of the residual, with its derivatives. Arrays hold values at the local nodes; values of ghosts go to their
  owners later. `failed` counts points without an answer on this rank. Any function may be NULL: the term then lacks it.

  idle      true where the term adds nothing in this step, on this rank; residual, tangent, apply and diagonal may then
            be skipped
  boxes     boxes of nodes that the term couples, and extra nodes, added to a space that is not numbered yet
  prepare   data of the term for the step, once the space is there
  residual  residual += term(u); NULL: forces of explicit steps alone, by motion.push
  tangent   element blocks of d term / d u into the pattern; where `residual` is not NULL also the task of residual()
  apply     y += (d term / d u) du; NULL: from the element blocks of `tangent`, and for the points, whose action keeps
            data of its own (MpmAction)
  diagonal  its diagonal blocks, block^2 values a node; NULL: from the element blocks
  link      couples boxes with the term's extra nodes, or with one another, once it is prepared
  traits    MpmTermTrait
  near      the term's note whether its contact is near enough to act in this step: its own rank's answer after `boxes`,
            that of all ranks later; NULL: the scene has none

  points    the physics at the points: first in the list, with forms of the Jacobian of its own. Residual as by
            residual(), and the candidate of their state at the step's end into `trial`, unless NULL; NULL for others
*/
struct MpmTerm {
  const char *name;
  PetscErrorCode (*points)(const MpmSum *sum, const PetscReal u[], const MpmTrial *trial, PetscReal residual[],
                           PetscInt *failed);
  PetscBool (*idle)(const void *ctx);
  PetscErrorCode (*boxes)(void *ctx, const MpmRules *rules, const MpmPoints *points, MpmSpace *space);
  PetscErrorCode (*prepare)(void *ctx, const MpmTermStep *step);
  PetscErrorCode (*link)(void *ctx, MpmSpace *space);
  PetscErrorCode (*residual)(const void *ctx, const MpmSum *sum, const PetscReal u[], PetscReal residual[],
                             PetscInt *failed);
  PetscErrorCode (*tangent)(const void *ctx, const MpmSum *sum, const PetscReal u[], MpmPattern *pattern,
                            PetscReal residual[], PetscInt *failed);
  PetscErrorCode (*apply)(const void *ctx, const MpmSum *sum, const PetscReal u[], const PetscReal du[], PetscReal y[]);
  PetscErrorCode (*diagonal)(const void *ctx, const MpmSum *sum, const PetscReal u[], PetscReal blocks[],
                             PetscInt *failed);
  unsigned (*traits)(const void *ctx);
  PetscBool *(*near)(void *ctx);
  MpmTermEnergy  energy;
  MpmTermStepEnd step;
  MpmTermNewton  newton;
  MpmTermMotion  motion;
  MpmTermFailure failure;
};

/* The terms of a problem; the first one is that of the points. */
typedef struct MpmTerms {
  PetscInt        count;
  const MpmTerm **term;
  void          **ctx;
} MpmTerms;

/* Makes the list with its first term. */
PetscErrorCode MpmTermsAdd(MpmTerms **terms, const MpmTerm *term, void *ctx);
PetscErrorCode MpmTermsDestroy(MpmTerms **terms);
/* The space of the points with the boxes of all terms; `outcome` as for MpmSpaceBegin(). */
PetscErrorCode MpmTermsSetUpSpace(const MpmTerms *terms, MpmSpace *space, const MpmRules *rules,
                                  const MpmPoints *points, MpmOutcome *outcome);
PetscErrorCode MpmTermsPrepare(const MpmTerms *terms, const MpmTermStep *step);
/* `linked`, unless NULL: true where any term links. Then the pattern is that of a prepared step. */
PetscErrorCode MpmTermsLink(const MpmTerms *terms, MpmSpace *space, PetscBool *linked);
PetscErrorCode MpmTermsKeepStage(const MpmTerms *terms, const MpmSum *sum, const PetscReal u[], PetscReal theta);
PetscErrorCode MpmTermsCommit(const MpmTerms *terms, const MpmSum *sum, const PetscReal u[], MpmParticles *particles);
PetscErrorCode MpmTermsPutBack(const MpmTerms *terms, PetscInt points, MpmParticles *particles);
PetscErrorCode MpmTermsBalance(const MpmTerms *terms, const MpmSum *sum, const PetscReal u[], MpmParticles *particles);
/* Traits of any term. */
unsigned MpmTermsTraits(const MpmTerms *terms);
/* True where contact with all of these traits is near enough to act in this step, on any rank. */
PetscBool MpmTermsNear(const MpmTerms *terms, unsigned traits);
/* These operations of all terms; the first refusal counts. */
PetscErrorCode MpmTermsRefuse(const MpmTerms *terms, MpmOutcome *outcome);
PetscBool      MpmTermsStray(const MpmTerms *terms, const MpmSum *sum, const PetscReal u[]);
PetscErrorCode MpmTermsUnheld(const MpmTerms *terms, const MpmSum *sum, const PetscReal u[], MpmOutcome *outcome);
/* True where term k adds nothing on this rank. */
PetscBool MpmTermsIdle(const MpmTerms *terms, PetscInt k);
/* True: `quadratic` of a term that always is. */
PetscBool MpmTermIsQuadratic(const void *ctx);
/* True where all terms but the points have an energy. */
PetscBool MpmTermsHaveEnergy(const MpmTerms *terms);
/* Adds the energies of the terms with `energy`; and, to `residual`, the forces of the others but the points. */
PetscErrorCode MpmTermsEnergy(const MpmTerms *terms, const MpmSum *sum, const PetscReal u[], PetscReal *energy,
                              PetscInt *failed);
PetscErrorCode MpmTermsResidualQuadratic(const MpmTerms *terms, const MpmSum *sum, const PetscReal u[],
                                         PetscReal residual[], PetscInt *failed);
/* Forces of the points alone, and of all others, added to `residual`. */
PetscErrorCode MpmTermsResidualPoints(const MpmTerms *terms, const MpmSum *sum, const PetscReal u[],
                                      const MpmTrial *trial, PetscReal residual[], PetscInt *failed);
PetscErrorCode MpmTermsResidualRest(const MpmTerms *terms, const MpmSum *sum, const PetscReal u[], PetscReal residual[],
                                    PetscInt *failed);
/* Sums over all terms; the points' state at the step's end into `trial`, unless NULL. */
PetscErrorCode MpmTermsResidual(const MpmTerms *terms, const MpmSum *sum, const PetscReal u[], const MpmTrial *trial,
                                PetscReal residual[], PetscInt *failed);
PetscErrorCode MpmTermsTangent(const MpmTerms *terms, const MpmSum *sum, const PetscReal u[], MpmPattern *pattern,
                               PetscReal residual[], PetscInt *failed);
/*
  Of term k alone, added: y += (d term / d u) du, the transposed action y += (d term / d u)^T v, and the diagonal; from
  its element blocks where it has no form of its own (element_action.c). The points' action is MpmAction's.
*/
PetscErrorCode MpmTermsApplyOne(const MpmTerms *terms, PetscInt k, const MpmSum *sum, const PetscReal u[],
                                const PetscReal du[], PetscReal y[]);
PetscErrorCode MpmTermsTransposeOne(const MpmTerms *terms, PetscInt k, const MpmSum *sum, const PetscReal u[],
                                    const PetscReal v[], PetscReal y[]);
PetscErrorCode MpmTermsDiagonalOne(const MpmTerms *terms, PetscInt k, const MpmSum *sum, const PetscReal u[],
                                   PetscReal blocks[], PetscInt *failed);
/* The tangents of all but the points, for forms of the Jacobian that take the points in a way of their own. */
PetscErrorCode MpmTermsTangentRest(const MpmTerms *terms, const MpmSum *sum, const PetscReal u[], MpmPattern *pattern,
                                   PetscInt *failed);

/*
  Fields in turn: Newton's method where the energy is convex in each of two fields, and not in both, as in fracture.

  Where a crack runs no step of Newton's method on both fields leads to the answer, however short the step in time. To
  minimise by d with u fixed, then by u with the new d, lowers the energy each time. One Newton iteration of each is
  that of a Jacobian without what u does to d: a block triangular matrix, solved as any other.

  Each step in time begins so. Once the residual falls from one iteration to the next, Newton's method on both fields is
  tried; an iteration that does not reduce the residual is refused, and twice as many iterations in turn follow.

  Source: Bourdin, Francfort and Marigo (2000), doi:10.1016/S0022-5096(99)00028-9; Farrell and Maurini (2017),
  doi:10.1002/nme.5300, who join both.
*/
#include "problem/discretization.h"
#include "solve/line_search.h"

#define FIRST  2     /* iterations in turn before the first attempt on both fields */
#define MOST   64    /* between two attempts */
#define FALLS  0.9   /* of the residual in an iteration in turn */
#define BEYOND 0.5   /* slope at the end of an iteration in turn, of that at its start, of opposite sign */
#define LEAST  0.1   /* part of a length that the next one is at least */
#define TRIALS 8     /* lengths of an iteration in turn */
#define STANDS 1e-12 /* change of the residual, relative, by iterations in turn that lead nowhere */

void MpmAlternationBegin(MpmSolver *solver, PetscInt it)
{
  MpmAlternation *alternation = &solver->alternation;

  if (!it) *alternation = (MpmAlternation){.in_turn = PETSC_TRUE, .left = FIRST, .again = FIRST};
  MpmDiscretizationSetAlternate(solver->disc, alternation->in_turn);
}

/*
  An iteration in turn is taken as it is, but where it goes beyond the least energy along its way by far: bounds that
  act at one end and not at the other would otherwise alternate for ever. Where the residual no longer changes
  nothing is found.
*/
static PetscErrorCode TakeInTurn(MpmSearch *search, PetscReal start, PetscBool *found)
{
  MpmAlternation *alternation = &search->solver->alternation;
  PetscScalar     down, slope;
  PetscReal       excess;

  PetscFunctionBeginUser;
  PetscCall(VecDot(search->F, search->Y, &down));
  for (PetscInt trial = 0; trial < TRIALS; trial++) {
    if (PetscIsInfOrNanReal(search->norm)) search->lambda *= 0.5;
    else {
      PetscCall(VecDot(search->G, search->Y, &slope));
      if (!(PetscRealPart(down) > 0.) || PetscRealPart(slope) >= -BEYOND * PetscRealPart(down)) break;
      search->lambda *= PetscMax(PetscRealPart(down) / PetscRealPart(down - slope), LEAST);
    }
    PetscCall(MpmSearchTry(search));
  }
  *found = (PetscBool)!PetscIsInfOrNanReal(search->norm);
  if (!*found) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmFieldsExcess(search->solver, search->W, search->G, &excess));
  if (--alternation->left > 0) PetscFunctionReturn(PETSC_SUCCESS);
  if (excess < FALLS * start) alternation->in_turn = PETSC_FALSE;
  else *found = (PetscBool)(PetscAbsReal(excess - start) > STANDS * start);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSearchInTurn(MpmSearch *search, PetscBool *found)
{
  MpmAlternation *alternation = &search->solver->alternation;
  PetscReal       start, excess = PETSC_INFINITY;

  PetscFunctionBeginUser;
  *found = PETSC_TRUE;
  if (!search->it) PetscCall(MpmFieldsLearn(search->solver, search->X, search->Y));
  PetscCall(MpmFieldsExcess(search->solver, search->X, search->F, &start));
  PetscCall(MpmSearchTry(search));
  if (alternation->in_turn) {
    PetscCall(TakeInTurn(search, start, found));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (!PetscIsInfOrNanReal(search->norm)) PetscCall(MpmFieldsExcess(search->solver, search->W, search->G, &excess));
  if (excess <= FALLS * start || excess <= 1.) PetscFunctionReturn(PETSC_SUCCESS);
  alternation->in_turn = PETSC_TRUE;
  alternation->left    = alternation->again;
  alternation->again   = PetscMin(2 * alternation->again, MOST);
  search->lambda       = 0.;
  search->norm         = search->fnorm;
  PetscCall(VecCopy(search->X, search->W));
  PetscCall(VecCopy(search->F, search->G));
  PetscFunctionReturn(PETSC_SUCCESS);
}

#pragma once
/*
  A line search at work (line_search.c), and that of a minimisation (minimise.c).
*/
#include "solve/solve.h"

/* From X along -Y, with F at X; W and G are the step that is tried and the residual there. */
typedef struct {
  MpmSolver *solver;
  Vec        X, F, Y, W, G;
  PetscInt   it;
  PetscReal  fnorm; /* of F */
  PetscReal  lambda, norm;
} MpmSearch;

/* Tries X - lambda Y: the residual there, and its norm. */
PetscErrorCode MpmSearchTry(MpmSearch *search);
/*
  Where the step is a minimisation: the step must not raise the objective; otherwise it is cut, and reversed where
  Newton's direction leads uphill. `found`: a step satisfies this. `taken` keeps the objective for the next iteration.
*/
PetscErrorCode MpmSearchDescend(MpmSearch *search, PetscBool *found);
PetscErrorCode MpmSearchTaken(MpmSearch *search);
/* The search of fields in turn (alternate.c); and what the next Jacobian of iteration `it` is. */
PetscErrorCode MpmSearchInTurn(MpmSearch *search, PetscBool *found);
void           MpmAlternationBegin(MpmSolver *solver, PetscInt it);
/* The objective for SNES; ctx: the solver. */
PetscErrorCode MpmObjective(SNES snes, Vec x, PetscReal *value, void *ctx);
/* The program's own line search, as SNES calls it; ctx: the solver. */
PetscErrorCode MpmLineSearch(SNESLineSearch object, void *ctx);
/* Residual over tolerance where there are several fields (newton.c). */
PetscErrorCode MpmFieldsExcess(MpmSolver *solver, Vec x, Vec f, PetscReal *excess);

/*
  Solver options of steps in which nothing touches.
*/
#include "options/database.h"
#include "assembly/terms.h"
#include "problem/discretization.h"
#include "solve/solve.h"

/* Sets the options of solves with or without contact, and KSP and PC as they stand. */
static PetscErrorCode Switch(MpmSolver *solver, PetscBool at_rest)
{
  KSP       ksp;
  PC        pc;
  PetscBool gmres = PETSC_FALSE, chosen = PETSC_FALSE;

  PetscFunctionBeginUser;
  if (solver->at_rest.now == at_rest) PetscFunctionReturn(PETSC_SUCCESS);
  solver->at_rest.now = at_rest;
  for (PetscInt k = 0; k < solver->at_rest.count; k++) {
    const char *value = at_rest ? solver->at_rest.option[k].at_rest : solver->at_rest.option[k].touching;

    if (value) PetscCall(PetscOptionsSetValue(NULL, solver->at_rest.option[k].name, value));
    else PetscCall(PetscOptionsClearValue(NULL, solver->at_rest.option[k].name));
    if (!strcmp(solver->at_rest.option[k].name, "-ksp_type")) {
      chosen = PETSC_TRUE;
      gmres  = (PetscBool)!strcmp(value, "gmres");
    }
  }
  PetscCall(SNESGetKSP(solver->snes, &ksp));
  PetscCall(KSPGetPC(ksp, &pc));
  if (solver->preset.factorises) PetscCall(PCSetFromOptions(pc));
  if (chosen && !solver->definite.lost) {
    PetscCall(KSPSetType(ksp, gmres ? KSPGMRES : KSPCG));
    if (gmres) PetscCall(KSPGMRESSetRestart(ksp, 100));
    PetscCall(KSPSetPCSide(ksp, gmres ? PC_RIGHT : PC_LEFT));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSolverMindContact(MpmSolver *solver, PetscBool begins)
{
  MpmAtRest *at_rest = &solver->at_rest;
  PetscReal  squares = 0.;

  PetscFunctionBeginUser;
  if (!at_rest->count) PetscFunctionReturn(PETSC_SUCCESS);
  if (begins) {
    MpmDatabaseCall(solver->database, Switch(solver, (PetscBool)!at_rest->touched));
    at_rest->touched = PETSC_FALSE;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (at_rest->touched) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmTermsAddSquares(solver->disc->terms, solver->disc->sum, solver->disc->nodal.u, &squares));
  at_rest->touched = (PetscBool)(squares > 0. || MpmTermsHold(solver->disc->terms));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &at_rest->touched, 1, MPM_MPI_BOOL, MPI_LOR, solver->disc->comm));
  if (at_rest->touched) MpmDatabaseCall(solver->database, Switch(solver, PETSC_FALSE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

#pragma once
/*
  States with a given stress.
*/
#include "base/base.h"
#include "base/types.h"
#include "talus/talus.h"

/*
  States of one material with a wanted stress. Where the law's stress follows from its state alone (`stateful`), F
  stays the identity and all six components are met; otherwise F carries the stress, in plane strain without the
  component across the plane.
*/
typedef struct {
  const MpmMaterial *material;
  const double      *own; /* the point's own parameters; NULL: the material's */
  MpmKernelSet       kernel;
  MpmFunction        law[MPM_FORM_COUNT];
  PetscInt           dim, model_dim; /* of the kernel, and of the model */
  int (*history)(const double *parameter, const MpmLawTable *table, const double *stress, double *state);
  PetscBool stateful;
} MpmInitial;

#define MPM_INITIAL_STATE 64 /* most values of a history in 3D */
PetscErrorCode MpmInitialCreate(const MpmMaterial *material, PetscInt dim, MpmInitial *initial);
/*
  F and state with the Cauchy stress `stress` (xx, yy, zz, xy (, yz, xz); on exit the stress of that state), from the
  history state_n on. Returns 0; 1 where the stress is outside the yield surface and the law's return has moved it; 2
  where there is no such state. `across`, where it is not NULL: the part of stress_zz in plane strain that F cannot
  carry, Kirchhoff's (of a small-strain law Cauchy's), Pa; it stays, for nothing moves across the plane, and the stress
  on exit includes it. NULL: stress_zz is that of F.
*/
int MpmInitialFind(const MpmInitial *initial, const PetscReal state_n[], PetscReal stress[], PetscReal F[],
                   PetscReal state[], PetscReal *across);
/*
  The Cauchy stress (xx, yy, zz, xy (, yz, xz)), Pa, that the law returns from this F and history without any motion; zz
  in plane strain as F carries it. Non-zero, and no stress, where the law has no answer.
*/
int MpmInitialReturn(const MpmInitial *initial, const PetscReal F[], const PetscReal state[], PetscReal stress[]);
/* `across` of a point with this F and history, whose Cauchy stress is `stress`. Non-zero where the law has no answer.
   */
int MpmInitialAcross(const MpmInitial *initial, const PetscReal F[], const PetscReal state[], const PetscReal stress[],
                     PetscReal *across);

/* A direction in which what MpmInitialFind() takes changes; NULL: that does not. */
typedef struct {
  const PetscReal *parameter; /* of the law, by its table */
  const PetscReal *stress;    /* wanted, as MpmInitialFind() takes it */
} MpmInitialDirection;
/*
  The change of what MpmInitialFind() finds from state_n on for the wanted stress: of F, of the history, and of the
  stress of that state. Non-zero where there is no such state, or the law's return has moved it. The law's own history
  of a stress (MpmLawInfo) is differenced: central differences over changes by a few hundredths and parts of them,
  extrapolated, whose error is about 1e-13 of the history.
*/
int MpmInitialAlong(const MpmInitial *initial, const PetscReal state_n[], const PetscReal stress[],
                    const MpmInitialDirection *direction, PetscReal dF[], PetscReal dstate[], PetscReal dstress[]);

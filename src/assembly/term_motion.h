#pragma once
/*
  Motion as terms take part in it: masses beside the points', explicit steps, and the account of energy.
*/
#include "base/base.h"
#include "base/types.h"

/*
  Optional operations of a term in steps with inertia; arrays at the local nodes, `dim` values each.

  rest     velocities and accelerations of the term's own unknowns become 0
  lend     masses, kg, velocities and accelerations of the term's own nodes
  take     new velocities and accelerations of these nodes; NULL: unchanged
  kinetic  kinetic energy of the term's own masses, J; the same on all ranks
  turn     a step whose forces balance at `part` of it: corrections by the nodes' velocities v at its start, m/s
  bear     adds forces of a geostatic state, as a residual: explicit steps find contact at displacements with them
  limit    stiffness bound of an explicit step dt, by the masses of the nodes, kg. Collective
  arrive   displacements in which an explicit step ends, its forces having acted at others; NULL: none
  push     adds forces at the start of an explicit step, N, complete at all local nodes. Collective
  resist   takes from the velocities after an increment over `kick`, s, what the term resists; at all local nodes, of
           masses in kg
*/
typedef struct MpmTermMotion {
  void (*rest)(void *ctx);
  void (*lend)(const void *ctx, PetscReal mass[], PetscReal velocity[], PetscReal acceleration[]);
  void (*take)(void *ctx, const PetscReal velocity[], const PetscReal acceleration[]);
  PetscReal (*kinetic)(const void *ctx);
  PetscErrorCode (*turn)(void *ctx, const MpmSum *sum, const PetscReal v[], PetscReal part);
  PetscErrorCode (*bear)(const void *ctx, const MpmSum *sum, PetscReal residual[]);
  PetscErrorCode (*limit)(void *ctx, const MpmSum *sum, const PetscReal mass[], PetscReal dt);
  void (*arrive)(void *ctx, const PetscReal u[]);
  PetscErrorCode (*push)(void *ctx, const MpmSum *sum, PetscReal force[]);
  PetscErrorCode (*resist)(void *ctx, const MpmSum *sum, const PetscReal mass[], PetscReal kick, PetscReal velocity[]);
} MpmTermMotion;

/* Entries of the account of energy. */
typedef enum {
  MPM_ACCOUNT_NONE,      /* internal or kinetic energy, or work that the term reports by itself */
  MPM_ACCOUNT_EXTERNAL,  /* work from outside, with opposite sign */
  MPM_ACCOUNT_DISSIPATED /* heat */
} MpmAccount;

/* Their work in a step, J, this rank's part. */
typedef struct MpmTermWork {
  PetscReal external, dissipated;
} MpmTermWork;

/* These operations of all terms; kinetic energy and work are sums (term_motion.c). */
void           MpmTermsRest(const MpmTerms *terms);
void           MpmTermsLend(const MpmTerms *terms, PetscReal mass[], PetscReal velocity[], PetscReal acceleration[]);
void           MpmTermsTake(const MpmTerms *terms, const PetscReal velocity[], const PetscReal acceleration[]);
PetscReal      MpmTermsKinetic(const MpmTerms *terms);
PetscErrorCode MpmTermsTurn(const MpmTerms *terms, const MpmSum *sum, const PetscReal v[], PetscReal part);
PetscErrorCode MpmTermsBear(const MpmTerms *terms, const MpmSum *sum, PetscReal residual[]);
PetscErrorCode MpmTermsLimit(const MpmTerms *terms, const MpmSum *sum, const PetscReal mass[], PetscReal dt);
void           MpmTermsArrive(const MpmTerms *terms, const PetscReal u[]);
PetscErrorCode MpmTermsPush(const MpmTerms *terms, const MpmSum *sum, PetscReal force[]);
PetscBool      MpmTermsResistAny(const MpmTerms *terms);
PetscErrorCode MpmTermsResist(const MpmTerms *terms, const MpmSum *sum, const PetscReal mass[], PetscReal kick,
                              PetscReal velocity[]);
/* Work in the displacement u of the forces at `at`. */
PetscErrorCode MpmTermsWork(const MpmTerms *terms, const MpmSum *sum, const PetscReal at[], const PetscReal u[],
                            MpmTermWork *work);

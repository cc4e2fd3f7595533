#pragma once
/*
  The ways to take a step.
*/
#include "step/integrator.h"

extern const MpmIntegrator MpmIntegratorQuasistatic; /* quasistatic.c */
extern const MpmIntegrator MpmIntegratorSdirk;       /* sdirk.c: two stages */
extern const MpmIntegrator MpmIntegratorImplicit;    /* dynamics.c: with inertia */
extern const MpmIntegrator MpmIntegratorExplicit;    /* explicit.c: without a matrix */

/* Within the beginning of a step, once its space stands: the inertia of ground that settles, or none. */
PetscErrorCode MpmSettleSet(MpmModel model);

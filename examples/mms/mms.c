/*
  Method of manufactured solutions: a compressible neo-Hookean square or cube whose displacement is prescribed along the axes,

    u_i(X, t) = t A_i sin(pi X_i),     F_ii = 1 + t A_i pi cos(pi X_i),     J = prod F_ii,

  so that F is diagonal, the boundary slides on rollers, and the first Piola-Kirchhoff stress
  P_ii = mu (F_ii - 1/F_ii) + lambda ln J / F_ii needs the body force, per initial volume,

    b_i = -dP_ii/dX_i = -F_ii' [mu (1 + 1/F_ii^2) + lambda (1 - ln J)/F_ii^2] ,     F_ii' = -t A_i pi^2 sin(pi X_i) .

  A program of its own because a scene file has no body force that varies in space; everything else is in case.yaml.
*/
#include "talus/talus.h"

static const PetscReal amplitude[3] = {0.10, -0.08, 0.06};

typedef struct {
  PetscReal lambda, mu;
} Lame;

static PetscErrorCode BodyForce(PetscInt dim, PetscReal time, const PetscReal X[], PetscReal force[], void *ctx)
{
  const Lame *lame = (const Lame *)ctx;
  PetscReal   ln_J = 0.;

  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < dim; i++)
    ln_J += PetscLogReal(1. + time * amplitude[i] * PETSC_PI * PetscCosReal(PETSC_PI * X[i]));
  for (PetscInt i = 0; i < dim; i++) {
    const PetscReal F     = 1. + time * amplitude[i] * PETSC_PI * PetscCosReal(PETSC_PI * X[i]);
    const PetscReal slope = -time * amplitude[i] * PetscSqr(PETSC_PI) * PetscSinReal(PETSC_PI * X[i]);

    force[i] = -slope * (lame->mu * (1. + 1. / PetscSqr(F)) + lame->lambda * (1. - ln_J) / PetscSqr(F));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

int main(int argc, char **argv)
{
  MpmModel  model;
  PetscReal E = 0., nu = 0.;
  Lame      lame;
  int       status;

  PetscCall(PetscInitialize(&argc, &argv, NULL, "mms -options_file examples/mms/case.yaml\n"));
  PetscCall(PetscOptionsGetReal(NULL, NULL, "-mpm_material_rubber_E", &E, NULL));
  PetscCall(PetscOptionsGetReal(NULL, NULL, "-mpm_material_rubber_nu", &nu, NULL));
  lame.lambda = E * nu / ((1. + nu) * (1. - 2. * nu));
  lame.mu     = E / (2. * (1. + nu));
  PetscCall(MpmModelCreate(PETSC_COMM_WORLD, &model));
  PetscCall(MpmModelUseTerminal(model));
  PetscCall(MpmModelSetBodyForce(model, BodyForce, &lame));
  PetscCall(MpmModelSetFromOptions(model));
  PetscCall(MpmModelRun(model, &status));
  PetscCall(MpmModelDestroy(&model));
  PetscCall(PetscFinalize());
  return status;
}

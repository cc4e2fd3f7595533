/*
  The generalised vortex: a manufactured dynamic solution at large strain. A ring of a neo-Hookean plate, 0.75 < R < 1.25,
  turns about its middle by the angle

    alpha(R, t) = A g(t) h(R) ,     h = (1 - 16 (R - 1)^2)^2 ,     g = (1 - cos(2 pi t/T))/2 ,

  which is a simple shear gamma = R alpha' in the frame that turns with the point. The stress is mu times gamma in that
  shear and mu gamma^2 around the ring, so that radial and tangential equilibrium need, per volume,

    b_r = mu gamma^2/R - rho R (d alpha/dt)^2 ,     b_t = rho R d2 alpha/dt2 - mu (gamma' + 2 gamma/R) .

  Outside of the ring nothing moves. A program of its own because a scene file has no body force that varies in space.
*/
#include "talus/talus.h"

typedef struct {
  PetscReal A, T, mu, density;
} Vortex;

static PetscErrorCode BodyForce(PetscInt dim, PetscReal time, const PetscReal X[], PetscReal force[], void *ctx)
{
  const Vortex   *vortex = (const Vortex *)ctx;
  const PetscReal omega = 2. * PETSC_PI / vortex->T, R = PetscSqrtReal(X[0] * X[0] + X[1] * X[1]), s = R - 1.;
  const PetscReal g = 0.5 * (1. - PetscCosReal(omega * time)), rate = 0.5 * omega * PetscSinReal(omega * time);
  const PetscReal second = 0.5 * omega * omega * PetscCosReal(omega * time);

  PetscFunctionBeginUser;
  for (PetscInt a = 0; a < dim; a++) force[a] = 0.;
  if (PetscAbsReal(s) < 0.25) {
    const PetscReal A = vortex->A, h = PetscSqr(1. - 16. * s * s);
    const PetscReal h1 = -64. * s * (1. - 16. * s * s), h2 = -64. + 3072. * s * s;
    const PetscReal gamma = R * A * g * h1, slope = A * g * (h1 + R * h2);
    const PetscReal radial     = vortex->mu * gamma * gamma / R - vortex->density * R * PetscSqr(A * rate * h);
    const PetscReal tangential = vortex->density * R * A * second * h - vortex->mu * (slope + 2. * gamma / R);
    const PetscReal angle      = PetscAtan2Real(X[1], X[0]) + A * g * h;

    force[0] = radial * PetscCosReal(angle) - tangential * PetscSinReal(angle);
    force[1] = radial * PetscSinReal(angle) + tangential * PetscCosReal(angle);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

int main(int argc, char **argv)
{
  MpmModel  model;
  PetscReal E = 0., nu = 0.;
  Vortex    vortex = {.A = 0.25, .T = 1., .density = 0.};
  int       status;

  PetscCall(PetscInitialize(&argc, &argv, NULL, "vortex -options_file examples/generalized_vortex/case.yaml\n"));
  PetscCall(PetscOptionsGetReal(NULL, NULL, "-vortex_angle", &vortex.A, NULL));
  PetscCall(PetscOptionsGetReal(NULL, NULL, "-vortex_period", &vortex.T, NULL));
  PetscCall(PetscOptionsGetReal(NULL, NULL, "-mpm_material_plate_E", &E, NULL));
  PetscCall(PetscOptionsGetReal(NULL, NULL, "-mpm_material_plate_nu", &nu, NULL));
  PetscCall(PetscOptionsGetReal(NULL, NULL, "-mpm_material_plate_density", &vortex.density, NULL));
  vortex.mu = E / (2. * (1. + nu));
  PetscCall(MpmModelCreate(PETSC_COMM_WORLD, &model));
  PetscCall(MpmModelUseTerminal(model));
  PetscCall(MpmModelSetBodyForce(model, BodyForce, &vortex));
  PetscCall(MpmModelSetFromOptions(model));
  PetscCall(MpmModelRun(model, &status));
  PetscCall(MpmModelDestroy(&model));
  PetscCall(PetscFinalize());
  return status;
}

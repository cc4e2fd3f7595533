#pragma once
/*
  Saturated ground at one point: what the kernels with and without F-bar share. Equations in poro.c.
*/
#include <string.h>
#include "solid.h"
#include "talus/point/flow.h"

/* Places among the physics' values: those of the material, then those of the scene. */
enum {
  PORO_POROSITY,
  PORO_MOBILITY, /* permeability, m2, an axis each; from PoroPrepare() on over viscosity, m2/(Pa s) */
  PORO_CONDUCTIVITY     = PORO_MOBILITY + 3,
  PORO_PERMEABILITY_LAW = PORO_CONDUCTIVITY + 3,
  PORO_DENSITY,
  PORO_VISCOSITY,
  PORO_MODULUS,
  PORO_PPP
};
enum { PORO_CONSTANT, PORO_KOZENY_CARMAN, PORO_UZUOKA_BORJA };

/* Places among the physics' own states. */
enum { PORO_STATE_POROSITY, PORO_STATE_FLUX, PORO_STATES = PORO_STATE_FLUX + MPM_DIM };

/* Inputs */
enum {
  PORO_GRADIENTS = MPM_TENSOR,
  PORO_P         = PORO_GRADIENTS,
  PORO_GRAD_P,
  PORO_DEVIATION = PORO_GRAD_P + MPM_DIM,
  PORO_INPUTS
};

/* tau' - J p I, or sigma' - p I at small strain */
MPM_FN Sym PoroTotalStress(const KernelPoint *point, const Sym *tau, Scalar J, Scalar p)
{
  return SymShift(tau, ScalarNeg(point->material.traits & MPM_LAW_SMALL_STRAIN ? p : ScalarMul(J, p)));
}

/* The part of the initial volume that is grains; it stays. */
MPM_FN Real PoroGrains(const KernelPoint *point)
{
  return (1. - KernelAt(point, own_n, PORO_STATE_POROSITY)) * SolidVolume(point, point->F_n);
}

/* Water that an initial volume has taken up, at the density without pressure: (J - s)(1 + p/K_w) - (1 - s). */
MPM_FN Scalar PoroContent(const KernelPoint *point, Real grains, Scalar J, Scalar p)
{
  const Real compliance = 1. / KernelAt(point, physics_parameter, PORO_MODULUS);

  if (point->material.traits & MPM_LAW_SMALL_STRAIN)
    return ScalarAdd(ScalarShift(J, -1.), ScalarScale((1. - grains) * compliance, p));
  if (RealVanishes(compliance)) return ScalarShift(J, -1.);
  return ScalarShift(ScalarMul(ScalarShift(J, -grains), ScalarShift(ScalarScale(compliance, p), 1.)), grains - 1.);
}

/* The least flow over all axes through a cell, over its volume, for a difference of pressure of one; `factor`
   multiplies the permeability. */
MPM_FN Real PoroThrough(const KernelPoint *point, Real factor)
{
  Real least = HUGE_VAL;

  for (int a = 0; a < MPM_DIM; a++) {
    const Real through =
      KernelAt(point, physics_parameter, PORO_MOBILITY + a) * factor / (point->cell[a] * point->cell[a]);

    if (RealValue(through) < RealValue(least)) least = through;
  }
  return least;
}

#define PORO_KEPT 1e-10 /* of what flows through a cell for a difference of pressure of one */

/*
  Storage by pressure of ground that drains at once: small enough to be negligible, and non-zero so that sealed ground,
  in which any pressure is steady, keeps its own. Over n cells it changes a steady pressure by the fraction n^2
  PORO_KEPT.
*/
MPM_FN Real PoroKept(const KernelPoint *point)
{
  return PORO_KEPT * point->dt * PoroThrough(point, 1.);
}

#if MPM_DIRECTIONS > 1
/* Its derivative by p. */
MPM_FN double PoroContentByPressure(const KernelPoint *point, double J)
{
  const double volume = point->material.traits & MPM_LAW_SMALL_STRAIN ? 1. : J;

  if (point->material.traits & MPM_POINT_DRAINED) return PoroKept(point);
  return (volume - PoroGrains(point)) / point->physics_parameter[PORO_MODULUS];
}
#endif

MPM_FN Real PoroContentReal(const KernelPoint *point, Real grains, const Real *F, Real p)
{
  return ScalarReal(PoroContent(point, grains, ScalarConstant(SolidVolume(point, F)), ScalarConstant(p)));
}

/* Content at the end of the first of two stages. */
MPM_FN Real PoroContentFirst(const KernelPoint *point, Real grains)
{
  Real F[MPM_TENSOR];

  if (!point->stage) return 0.;
  for (int k = 0; k < MPM_TENSOR; k++) F[k] = KernelStageAt(point, F, k);
  return PoroContentReal(point, grains, F, KernelStageAt(point, value, 0));
}

MPM_FN Real PoroDeviationFirst(const KernelPoint *point)
{
  return point->stage ? KernelStageAt(point, deviation, 0) : (Real)0.;
}

/* A quantity that counts from the step's start, or in the second of two stages from that and the first stage's end. */
MPM_FN Real PoroReference(const KernelPoint *point, Real start, Real stage)
{
  return point->stage ? start + point->stage->theta * (stage - start) : start;
}

/* Factor on the permeability. Non-zero where there are no pores. */
MPM_FN int PoroPermeabilityFactor(const KernelPoint *point, Real grains, Scalar J, Scalar *factor)
{
  const Scalar porosity = ScalarShift(ScalarDiv(ScalarConstant(-grains), J), 1.);

  if (!(ScalarValue(porosity) > 0. && ScalarValue(J) > 0.)) return 1;
  switch ((int)RealValue(KernelAt(point, physics_parameter, PORO_PERMEABILITY_LAW))) {
  case PORO_KOZENY_CARMAN: {
    const Scalar ratio = ScalarScale(1. / (1. - grains), porosity);

    *factor = ScalarMul(ScalarMul(ratio, ScalarSquare(ratio)), ScalarSquare(J));
    break;
  }
  case PORO_UZUOKA_BORJA: {
    const Real   mu = KernelModulus(point, 1), modulus = KernelModulus(point, 2);
    const Scalar square = ScalarSquare(J);
    /* J^2 M(J) = mu (1 + J^2) + lambda (1 - ln J) */
    const Scalar scaled = ScalarAdd(ScalarScale(mu, ScalarShift(square, 1.)),
                                    ScalarScale(modulus - 2. * mu, ScalarShift(ScalarNeg(ScalarLog(J)), 1.)));

    if (!(ScalarValue(scaled) > 0.)) return 1;
    *factor = ScalarScale(modulus, ScalarDiv(ScalarMul(J, square), scaled));
    break;
  }
  default:
    *factor = ScalarConstant(1.);
  }
  return 0;
}

/*
  The flux of grad p, -dt V_0 J dF^{-1} m (dF^{-T} grad p - rho_w g), and Darcy's velocity where it is requested; at
  small strain gradients are those by the initial position, the weight being that of a potential, too: water at rest by
  the points' places is at rest. `factor` multiplies the permeability.
*/
MPM_FN void PoroSeepage(const KernelPoint *point, const Tensor *dF, Scalar factor, const Scalar gradient[],
                        Scalar flux[])
{
  const int    small    = point->material.traits & MPM_LAW_SMALL_STRAIN;
  const Real   density  = KernelAt(point, physics_parameter, PORO_DENSITY);
  const Tensor cofactor = TensorCofactor(dF), F_n = TensorFromArray(point->F_n);
  const Scalar inverse = ScalarDiv(ScalarConstant(1.), TensorCofactorDet(dF, &cofactor));
  /* gradients by x or X: a row of `map` for each axis, times `scale` */
  const Tensor map   = small ? TensorTranspose(&F_n) : cofactor;
  const Real   J_n   = small ? 1. : SolidVolume(point, point->F_n);
  const Real   outer = -point->dt * point->volume0 * J_n;

  for (int b = 0; b < MPM_DIM; b++) flux[b] = ScalarConstant(0.);
  for (int a = 0; a < MPM_DIM; a++) {
    Scalar slope = ScalarConstant(0.), q;

    for (int b = 0; b < MPM_DIM; b++) {
      const Real weight = small ? density * KernelAt(point, gravity, b) : (Real)0.;

      slope = ScalarAdd(slope, ScalarMul(map.a[a * MPM_DIM + b], ScalarShift(gradient[b], -weight)));
    }
    q = small ? slope : ScalarShift(ScalarMul(slope, inverse), -density * KernelAt(point, gravity, a));
    q = ScalarScale(KernelAt(point, physics_parameter, PORO_MOBILITY + a), ScalarMul(factor, q));
    for (int b = 0; b < MPM_DIM; b++)
      flux[b] = ScalarAdd(flux[b], ScalarScale(outer, ScalarMul(map.a[a * MPM_DIM + b], q)));
    KernelKeepOwn(point, PORO_STATE_FLUX + a, -ScalarReal(q));
  }
}

#define PORO_FADES 50. /* where a step moves water over a seventh of a cell, half of the stabilisation is left */

/*
  The factor of the pressure projection, c/(2 mu), which fades where the flow itself prevents alternating pressures:
  these have a gradient of 2/h, so that the flow's 4 x, x = 2 mu dt m/h^2, stands beside the projection's 0.3/(1 + 50
  x), and the sum is never less than 3/4 of its value at once after a load.
*/
MPM_FN Real PoroProjection(const KernelPoint *point, Real grains)
{
  const Real mu      = KernelModulus(point, 0);
  const Real J       = SolidVolume(point, point->F_n);
  Real       through = 0.;
  Scalar     factor;

  if (point->cell && !PoroPermeabilityFactor(point, grains, ScalarConstant(J), &factor))
    through = PoroThrough(point, ScalarReal(factor));
  return 0.5 * KernelAt(point, physics_parameter, PORO_PPP) / (mu * (1. + PORO_FADES * 2. * mu * point->dt * through));
}

/* The factor of what the pressure's deviation has changed by, in its flux. */
MPM_FN Real PoroSmoothing(const KernelPoint *point, Real grains)
{
  if (point->material.traits & MPM_POINT_DRAINED) return 0.;
  return -point->volume0 * PoroProjection(point, grains);
}

/* Fluxes of p, of its gradient and of its deviation, from J and dF; non-zero where there are no pores. */
MPM_FN int PoroMass(const KernelPoint *point, const Tensor *dF, Scalar J, const Scalar input[], Scalar flux[])
{
  const Real   grains = PoroGrains(point), value_n = KernelAt(point, value_n, 0);
  const Real   start     = PoroContentReal(point, grains, point->F_n, value_n);
  const Real   deviation = PoroReference(point, KernelAt(point, deviation_n, 0), PoroDeviationFirst(point));
  const Scalar content   = PoroContent(point, grains, J, input[PORO_P]);
  Scalar       factor;

  if (PoroPermeabilityFactor(point, grains, J, &factor)) return 1;
  flux[PORO_P] = point->material.traits & MPM_POINT_DRAINED
                   ? ScalarScale(-point->volume0 * PoroKept(point), ScalarShift(input[PORO_P], -value_n))
                   : ScalarScale(-point->volume0,
                                 ScalarShift(content, -PoroReference(point, start, PoroContentFirst(point, grains))));
  PoroSeepage(point, dF, factor, &input[PORO_GRAD_P], &flux[PORO_GRAD_P]);
  flux[PORO_DEVIATION] = ScalarScale(PoroSmoothing(point, grains), ScalarShift(input[PORO_DEVIATION], -deviation));
  KernelKeepOwn(point, PORO_STATE_POROSITY, 1. - grains / ScalarReal(J));
  return 0;
}

#if MPM_DIRECTIONS > 1
/*
  The tangent: derivatives by the first `count` inputs are the directions of `flux`, the others follow here by hand.
  Fluxes are affine in grad p, with the mobility as its factor, and in the deviation; p is the caller's where `count`
  leaves it out.
*/
MPM_FN void PoroTangent(const KernelPoint *point, const Scalar input[], Scalar J, int count, const Scalar flux[],
                        double tangent[])
{
  const int    small  = point->material.traits & MPM_LAW_SMALL_STRAIN;
  const double grains = PoroGrains(point);
  const Tensor dF     = TensorFromGradient(input);
  double       values[PORO_GRADIENTS], map[PORO_GRADIENTS], outer = -point->dt * point->volume0;
  Scalar       factor = ScalarConstant(1.);

  for (int k = 0; k < PORO_INPUTS; k++) {
    for (int l = 0; l < count; l++) tangent[k * PORO_INPUTS + l] = ScalarDirection(flux[k], l);
    for (int l = count; l < PORO_INPUTS; l++) tangent[k * PORO_INPUTS + l] = 0.;
  }
  TensorStore(values, &dF);
  if (small) {
    for (int k = 0; k < MPM_DIM * MPM_DIM; k++) map[k] = point->F_n[k % MPM_DIM * MPM_DIM + k / MPM_DIM];
  } else {
    outer *= ArrayDetValue(point->F_n) / MpmCofactors(MPM_TENSOR, values, map);
  }
  PoroPermeabilityFactor(point, grains, ScalarConstant(ScalarValue(J)), &factor);
  outer *= ScalarValue(factor);
  for (int a = 0; a < MPM_DIM; a++) {
    for (int b = 0; b < MPM_DIM; b++) {
      const double slope = outer * point->physics_parameter[PORO_MOBILITY + a] * map[a * MPM_DIM + b];

      for (int c = 0; c < MPM_DIM; c++)
        tangent[(PORO_GRAD_P + b) * PORO_INPUTS + PORO_GRAD_P + c] += slope * map[a * MPM_DIM + c];
    }
  }
  tangent[PORO_DEVIATION * PORO_INPUTS + PORO_DEVIATION] = PoroSmoothing(point, grains);
}
#endif

#ifdef MPM_PHYSICS
static const MpmField poro_fields[] = {
  {.name = "displacement", .gradient = 1, .increment = 1, .unit = "m", .near_null = MPM_NEAR_NULL_RIGID},
  {.name       = "pressure",
   .components = 1,
   .value      = 1,
   .gradient   = 1,
   .deviation  = 1,
   .rate       = 1,
   .negative   = 1,
   .symbol     = "p",
   .unit       = "Pa",
   .near_null  = MPM_NEAR_NULL_CONSTANT,
   .scale      = MPM_SCALE_STRESS},
};

/* clang-format off */
static const MpmParameter poro_parameters[] = {
  {MPM_NUMBER, "porosity", "-", -1., 0, 0., 1., 1,
   "initial porosity; without it, where the law has a specific volume v, 1 - 1/v", NULL, 0.4, NULL},
  {MPM_AXES, "permeability", "m2", 0., 0, 0., HUGE_VAL, 1, "permeability, one number or one an axis", NULL, 1e-12, NULL},
  {MPM_AXES, "conductivity", "m/s", 0., 0, 0., HUGE_VAL, 1,
   "hydraulic conductivity in place of the permeability: permeability times density times gravity over viscosity", NULL, 1e-5, NULL},
  {MPM_WORD, "permeability_law", "-", PORO_CONSTANT, 0, 0., 0., 0, "how permeability changes with the volume",
   "constant|kozeny_carman|uzuoka_borja", 0., NULL},
};
static const MpmCommonParameter poro_common[] = {
  {"water", {MPM_NUMBER, "density", "kg/m3", 1000., 0, 0., HUGE_VAL, 0, "density of the water", NULL, 1000., NULL}},
  {"water", {MPM_NUMBER, "viscosity", "Pa s", 1e-3, 0, 0., HUGE_VAL, 1, "dynamic viscosity of the water", NULL, 1e-3, NULL}},
  {"water", {MPM_NUMBER, "modulus", "Pa", HUGE_VAL, 0, 0., HUGE_VAL, 1, "bulk modulus of the water; without it the water is incompressible", NULL, 2.2e9, NULL}},
  {"stabilization", {MPM_NUMBER, "ppp", "-", 1., 0, 0., HUGE_VAL, 0, "factor of the polynomial pressure projection, times 1/(2 mu)", NULL, 1., NULL}},
};
/* clang-format on */
static const MpmStateVariable poro_states[] = {{"porosity", MPM_STATE_SCALAR, 0., "-"},
                                               {"flux", MPM_STATE_VECTOR, 0., "m/s"}};

/* The law's number of this name, or NULL. */
static const double *PoroLawNumber(const MpmPhysicsMaterial *material, const char *name, int *set)
{
  for (size_t k = 0; k < material->info->parameter_count; k++) {
    if (strcmp(material->info->parameters[k].name, name)) continue;
    *set = material->set[k];
    return &material->parameter[k];
  }
  *set = 0;
  return NULL;
}

static const char *PoroPrepare(const MpmPhysicsMaterial *material, double gravity, double *value)
{
  int           set;
  const double *volume       = PoroLawNumber(material, "specific_volume", &set);
  const int     permeability = value[PORO_MOBILITY] > 0., conductivity = value[PORO_CONDUCTIVITY] > 0.;

  if (permeability && conductivity) return "conductivity: permeability is given, too, must be one of them";
  if (!permeability && !conductivity)
    return "permeability is missing: must be given, m2, > 0, or conductivity, m/s, > 0";
  if (value[PORO_POROSITY] > 0. && set) return "porosity: specific_volume is given, too, must be one of them";
  if (value[PORO_POROSITY] < 0. && !volume) return "porosity is missing: must be > 0 and < 1";
  if (conductivity && !(value[PORO_DENSITY] > 0.)) return "conductivity: -mpm_water_density is 0, must be > 0";
  if (value[PORO_POROSITY] < 0.) value[PORO_POROSITY] = 1. - 1. / *volume;
  for (int a = 0; a < 3; a++) {
    if (conductivity) value[PORO_MOBILITY + a] = value[PORO_CONDUCTIVITY + a] / (value[PORO_DENSITY] * gravity);
    else value[PORO_MOBILITY + a] /= value[PORO_VISCOSITY];
  }
  return NULL;
}

/* The porosity of the material is that of its points, unless the law has a specific volume. */
static void PoroInitialChange(int place, double *own)
{
  if (place == PORO_POROSITY) own[PORO_STATE_POROSITY] = 1.;
}

/* With m = k/mu_w, or K/(rho_w g). */
static void PoroChange(const double *value, int place, double *derivative)
{
  const int conductivity = value[PORO_CONDUCTIVITY] > 0., axis = (place - PORO_MOBILITY) % 3;

  derivative[place] = 1.;
  if (place >= PORO_MOBILITY && place < PORO_CONDUCTIVITY) derivative[place] = 1. / value[PORO_VISCOSITY];
  if (place >= PORO_CONDUCTIVITY && place < PORO_PERMEABILITY_LAW)
    derivative[PORO_MOBILITY + axis] = value[PORO_MOBILITY + axis] / value[place];
  for (int a = 0; a < 3 && place == (conductivity ? PORO_DENSITY : PORO_VISCOSITY); a++)
    derivative[PORO_MOBILITY + a] = -value[PORO_MOBILITY + a] / value[place];
}

/* A specific volume of the point's own comes before the material's. */
static void PoroInitial(const MpmPhysicsMaterial *material, const double *value, const double *state, double *own)
{
  own[PORO_STATE_POROSITY] = value[PORO_POROSITY];
  for (size_t k = 0; state && k < material->info->state_count; k++) {
    const MpmStateVariable *variable = &material->info->states[k];

    if (!strcmp(variable->name, "specific_volume") && *state > 1.) own[PORO_STATE_POROSITY] = 1. - 1. / *state;
    state += variable->kind == MPM_STATE_SCALAR ? 1 : material->dim == 2 ? 4 : 6;
  }
}

/*
  Flow and stabilising storage of a step for a pressure whose second difference over a cell is one; the storage fades as
  the projection does.
*/
static double PoroGhost(const MpmPhysicsMaterial *material, const double *value, double dt, double h)
{
  const MpmLawInfo *info = material->info;
  const double      mu   = info->shear_modulus ? info->shear_modulus(material->parameter, material->table, NULL, NULL)
                                               : info->stiffness(material->parameter, material->table, NULL, NULL) / 3.;
  const double      storage  = 0.5 * h * h / mu;
  double            mobility = 0.;

  for (int a = 0; a < material->dim; a++) mobility = fmax(mobility, value[PORO_MOBILITY + a]);
  return -(dt * mobility + storage / (1. + PORO_FADES * dt * mobility / storage));
}

/* Symmetric where geometry and permeability stay: the couplings of water and momentum are then transposed. */
static int PoroSymmetric(const MpmPhysicsMaterial *material, const double *value)
{
  return (material->info->traits & MPM_LAW_SMALL_STRAIN) && (int)value[PORO_PERMEABILITY_LAW] == PORO_CONSTANT;
}

#define PORO_TRAITS (MPM_PHYSICS_STAGES | MPM_PHYSICS_SADDLE | MPM_PHYSICS_SYMMETRIC | MPM_PHYSICS_BIOT)
#define PORO_PHYSICS \
  .field_count = MPM_ROWS(poro_fields), .fields = poro_fields, .parameter_count = MPM_ROWS(poro_parameters), \
  .parameters = poro_parameters, .common_count = MPM_ROWS(poro_common), .common = poro_common, \
  .state_count = MPM_ROWS(poro_states), .states = poro_states, .taken_up = 1, .prepare = PoroPrepare, \
  .change = PoroChange, .initial = PoroInitial, .initial_change = PoroInitialChange, .ghost = PoroGhost, \
  .symmetric = PoroSymmetric
#endif

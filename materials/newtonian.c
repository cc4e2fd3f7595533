/*
  Newtonian fluid, weakly compressible: a pressure by volume and a viscous stress by the step's rate of deformation

    tau = -J p I + 2 mu J_n dev d ,   d = ln V/dt ,   dF = V R the step's polar decomposition, ln V = (1/2) ln(dF dF^T)
    p = (K/gamma) (j^-gamma - 1)     equation: tait, j = rho_0/rho
    p = K (1/j - 1) = c^2 (rho - rho_0)    equation: linear
    p >= pressure_min                0 by default: the fluid parts without tension

  tau  Kirchhoff stress J sigma, tension positive, Pa; p positive in compression
  K    bulk modulus at p = 0: `bulk_modulus`, or density times the square of `sound_speed`
  j    volume over that at p = 0 (history): grows by det dF. An initial stress sets it; J, that of F, starts with 1 for
       any stress, and `density` is that of the initial volume
  J_n  det F at the step's start. With it, not J, both terms derive from a potential over the step; the difference is
       d's trace times dt

  d is the rate whose axes do not turn in the step: exact for any rotation, of second order on curved paths; the viscous
  stress is that of backward Euler. With dt = 0 nothing is viscous.

  j goes on growing where pressure_min acts: the fluid carries pressure again when the gap has closed. There the point
  has no stiffness but the viscous one.

  At rest there is no shear stress: shapes change freely, and a quasi-static stage has an answer only by `viscosity`.
  An initial stress is that of its mean.

  Source: Batchelor (1967), An Introduction to Fluid Dynamics, doi:10.1017/CBO9780511800955, section 3.3; Monaghan
  (1994), doi:10.1006/jcph.1994.1034, for gamma = 7 and a sound speed of ten times the largest velocity.
*/
#include "talus/point/elasticity.h"

enum { DENSITY, BULK_MODULUS, SOUND_SPEED, EQUATION, GAMMA, VISCOSITY, PRESSURE_MIN };

#define TAIT_GAMMA 7.

static const MpmParameter parameters[] = {
  {MPM_NUMBER, "density", "kg/m3", 0., 0, 0., HUGE_VAL, 0, "mass per initial volume", NULL, 1000., NULL},
  {MPM_NUMBER, "bulk_modulus", "Pa", HUGE_VAL, 0, 0., HUGE_VAL, 1, "bulk modulus at pressure 0, or sound_speed", NULL,
   30e6, NULL},
  {MPM_NUMBER, "sound_speed", "m/s", HUGE_VAL, 0, 0., HUGE_VAL, 1,
   "instead of bulk_modulus; ten times the largest velocity keeps changes of density to about 1 per cent", NULL, 100.,
   NULL},
  {MPM_WORD, "equation", "", 0., 0, 0., 1., 0, "pressure by density: Tait's, or in proportion to its change",
   "tait|linear", 0., NULL},
  {MPM_NUMBER, "gamma", "-", TAIT_GAMMA, 0, 1., 100., 0, "exponent of Tait's equation", NULL, 7., NULL},
  {MPM_NUMBER, "viscosity", "Pa s", 0., 0, 0., HUGE_VAL, 0, "dynamic viscosity", NULL, 1e3, NULL},
  {MPM_NUMBER, "pressure_min", "Pa", 0., 0, -HUGE_VAL, 0., 0,
   "least pressure that the fluid takes, tension where negative; far below 0 it bears any", NULL, -0.3e6, NULL}};

static const MpmStateVariable states[] = {{"volume_ratio", MPM_STATE_SCALAR, 1., "-"}};

MPM_FN Real BulkModulus(const Real *parameter)
{
  if (RealValue(parameter[BULK_MODULUS]) <= DBL_MAX) return parameter[BULK_MODULUS];
  return parameter[DENSITY] * parameter[SOUND_SPEED] * parameter[SOUND_SPEED];
}

MPM_FN Real Exponent(const Real *parameter)
{
  const Real one = 1.;

  return RealValue(parameter[EQUATION]) > 0.5 ? one : parameter[GAMMA];
}

/* p of a volume ratio, at least pressure_min */
MPM_FN Scalar Pressure(const Real *parameter, Scalar ratio)
{
  const Real   gamma = Exponent(parameter);
  const Scalar power = ScalarPow(ratio, -gamma);
  const Scalar p     = ScalarScale(BulkModulus(parameter) / gamma, ScalarShift(power, -1.));

  return ScalarValue(p) >= RealValue(parameter[PRESSURE_MIN]) ? p : ScalarConstant(parameter[PRESSURE_MIN]);
}

/* det of an F that does not depend on dF */
MPM_FN Real VolumeBefore(const Real *F_n)
{
  const Tensor F = TensorFromArray(F_n);

  return ScalarReal(TensorDet(&F));
}

MPM_FN int MpmMaterialEvaluate_newtonian(const MpmLawPoint *point, const Tensor *dF, Sym *tau)
{
  const Scalar dJ    = TensorDetByCofactors(dF);
  const Scalar ratio = ScalarScale(point->state_n[0], dJ);
  const Real   J_n   = VolumeBefore(point->F_n);
  Sym          e;

  if (!ElasticIsRegular(point, dF)) return 1;
  if (!(ScalarValue(ratio) > 0. && ScalarValue(ratio) <= DBL_MAX)) return 1;
  *tau = SymZero();
  if (!RealVanishes(point->parameter[VISCOSITY]) && RealValue(point->dt) > 0.) {
    const Sym b = SymLeftCauchyGreen(dF);

    if (ElasticLogStrain(&b, &e)) return 1;
    e    = SymDev(&e);
    *tau = SymScaleBy(2. * point->parameter[VISCOSITY] * J_n / point->dt, &e);
  }
  *tau = SymShift(tau, ScalarScale(-J_n, ScalarMul(dJ, Pressure(point->parameter, ratio))));
  if (point->state) point->state[0] = ScalarReal(ratio);
  return 0;
}

static int MpmMaterialCheck_newtonian(const double *parameter, const MpmLawTable *table, MpmLawFault *fault)
{
  const int         bulk = parameter[BULK_MODULUS] <= DBL_MAX, speed = parameter[SOUND_SPEED] <= DBL_MAX;
  const MpmLawFault both = {-1, 0., 0., 0, "bulk_modulus and sound_speed are given, and one makes the other"};
  const MpmLawFault none = {-1, 0., 0., 0, "bulk_modulus or sound_speed must be given"};
  const MpmLawFault mass = {DENSITY, 0., HUGE_VAL, 1, "the bulk modulus of a sound_speed follows from it"};
  const MpmLawFault line = {GAMMA, TAIT_GAMMA, TAIT_GAMMA, 0, "it is that of equation tait; linear has none"};

  (void)table;
  *fault = both;
  if (bulk && speed) return 0;
  *fault = none;
  if (!bulk && !speed) return 0;
  *fault = mass;
  if (speed && !(parameter[DENSITY] > 0.)) return 0;
  *fault = line;
  return parameter[EQUATION] < 0.5 || parameter[GAMMA] == TAIT_GAMMA;
}

/* -J j dp/dj = J (K + gamma p), and J |p| in tension. Beyond pressure_min the modulus once the gap has closed again */
static double MpmMaterialStiffness_newtonian(const double *parameter, const MpmLawTable *table, const double *state,
                                             const double *F)
{
  const double gamma = parameter[EQUATION] > 0.5 ? 1. : parameter[GAMMA], ratio = state ? state[0] : 1.;
  const double K    = parameter[BULK_MODULUS] <= DBL_MAX
                        ? parameter[BULK_MODULUS]
                        : parameter[DENSITY] * parameter[SOUND_SPEED] * parameter[SOUND_SPEED];
  const double base = 1. + gamma * parameter[PRESSURE_MIN] / K; /* j^-gamma where pressure_min begins */
  const double held = base > 0. ? fmin(ratio, pow(base, -1. / gamma)) : ratio, p = K / gamma * (pow(held, -gamma) - 1.);

  (void)table;
  return (F ? MpmDeterminant(MPM_TENSOR, F) : 1.) * held / ratio * (K + gamma * p + fmax(0., -p));
}

/* (4/3) mu */
static double MpmMaterialViscosity_newtonian(const double *parameter, const MpmLawTable *table)
{
  (void)table;
  return 4. / 3. * parameter[VISCOSITY];
}

/* The volume ratio of the mean stress; non-zero for a tension that no volume has */
static int MpmMaterialHistory_newtonian(const double *parameter, const MpmLawTable *table, const double *stress,
                                        double *state)
{
  const double gamma = parameter[EQUATION] > 0.5 ? 1. : parameter[GAMMA], p = -(stress[0] + stress[1] + stress[2]) / 3.;
  const double K = parameter[BULK_MODULUS] <= DBL_MAX
                     ? parameter[BULK_MODULUS]
                     : parameter[DENSITY] * parameter[SOUND_SPEED] * parameter[SOUND_SPEED];

  (void)table;
  state[0] = pow(1. + gamma * p / K, -1. / gamma);
  return !(state[0] > 0. && state[0] <= DBL_MAX);
}

/* A fluid at rest has the same stress in all directions. */
static double MpmMaterialK0_newtonian(const double *parameter, const MpmLawTable *table, const double *state,
                                      double weight)
{
  (void)parameter, (void)table, (void)state, (void)weight;
  return 1.;
}

MPM_LAW_DEFINE(newtonian, parameters, states, MpmMaterialEvaluate_newtonian,
               .summary = "weakly compressible Newtonian fluid",
               .traits  = MPM_LAW_SYMMETRIC | MPM_LAW_PLASTIC | MPM_LAW_VISCOUS | MPM_LAW_VOLUME,
               .check = MpmMaterialCheck_newtonian, .stiffness = MpmMaterialStiffness_newtonian,
               .viscosity = MpmMaterialViscosity_newtonian, .history = MpmMaterialHistory_newtonian,
               .k0 = MpmMaterialK0_newtonian)

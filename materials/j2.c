/*
  J2 plasticity: Hencky elasticity, von Mises yield, linear isotropic hardening, large strain

    b_trial = dF b_n dF^T,   e = (1/2) ln b,   tau = lambda tr(e) I + 2 mu e
    f = sqrt(3 J2(tau)) - (yield_stress + hardening alpha) <= 0
    flow along n = dev(tau)/|dev(tau)|, associated; alpha grows by sqrt(2/3) times the plastic multiplier dg

  tau    Kirchhoff stress J sigma, tension positive, Pa; f bounds the Kirchhoff stress, not the Cauchy stress
  b      elastic left Cauchy-Green tensor (history)
  alpha  equivalent plastic strain (history)

  Exponential integration of the flow keeps the return map that of small strain, in logarithmic strains, and plastic
  flow isochoric. Linear hardening makes it explicit:

    dg = (|dev tau_trial| - R)/(2 mu + 2 hardening/3),   R = sqrt(2/3) (yield_stress + hardening alpha_n),   e -= dg n

  The step's stress derives from a potential (its tangent is symmetric).

  Source: Simo (1992), doi:10.1016/0045-7825(92)90123-2; de Souza Neto, Peric and Owen (2008),
  doi:10.1002/9780470694626, sections 7.3 and 14.4.
*/
#include "talus/point/elasticity.h"

enum { YIELD_STRESS = ELASTIC_COUNT, HARDENING };

static const MpmParameter parameters[] = {
  ELASTIC_PARAMETERS,
  {MPM_STRENGTH, "yield_stress", "Pa", 0., 1, 0., HUGE_VAL, 1,
   "initial uniaxial yield stress, bound on sqrt(3 J2) of the Kirchhoff stress", NULL, 100e3, NULL},
  {MPM_STRENGTH, "hardening", "Pa", 0., 0, 0., HUGE_VAL, 0, "growth of the yield stress per equivalent plastic strain",
   NULL, 1e6, NULL}};

enum { STATE_B = 0, STATE_ALPHA = MPM_SYM };

static const MpmStateVariable states[] = {{"elastic_left_cauchy_green", MPM_STATE_SYM, 1., "-"},
                                          {"equivalent_plastic_strain", MPM_STATE_SCALAR, 0., "-"}};

MPM_FN int MpmMaterialEvaluate_j2(const MpmLawPoint *point, const Tensor *dF, Sym *tau)
{
  const Lame lame      = LameFromParameters(point->parameter);
  const Real hardening = point->parameter[HARDENING], alpha_n = point->state_n[STATE_ALPHA];
  const Real radius = sqrt(2. / 3.) * (point->parameter[YIELD_STRESS] + hardening * alpha_n) / (2. * lame.mu);
  Sym        b      = SymPush(dF, &point->state_n[STATE_B]);
  Real       alpha  = alpha_n;
  Sym        e, dev;

  if (!ElasticIsRegular(point, dF) || ElasticLogStrain(&b, &e)) return 1;
  dev = SymDev(&e);
  if (SymNormValue(&dev) > RealValue(radius) + ELASTIC_STRAIN_NOISE) {
    const Scalar norm = SymNorm(&dev); /* of the elastic strain's deviator: positive here */
    const Scalar dg   = ScalarScale(lame.mu / (lame.mu + hardening / 3.), ScalarShift(norm, -radius));

    e = SymAxpy(ScalarNeg(ScalarDiv(dg, norm)), &dev, &e);
    alpha += sqrt(2. / 3.) * ScalarReal(dg);
    if (point->state && ElasticLeftCauchyGreen(&e, &b)) return 1;
  }
  *tau = ElasticStress(lame, &e);
  if (point->state) {
    SymStore(&point->state[STATE_B], &b);
    point->state[STATE_ALPHA] = alpha;
  }
  return 0;
}

/* In pure shear sqrt(3 J2) is sqrt(3) times the shear stress. */
static double ShearStrength(const double *parameter, const double *state)
{
  return (parameter[YIELD_STRESS] + parameter[HARDENING] * state[STATE_ALPHA]) / sqrt(3.);
}

MPM_LAW_MODULI(j2, parameters, states, ElasticModuli)

MPM_LAW_DEFINE(j2, parameters, states, MpmMaterialEvaluate_j2,
               .summary   = "von Mises plasticity with linear isotropic hardening",
               .traits    = MPM_LAW_SYMMETRIC | MPM_LAW_PLASTIC | MPM_LAW_FIXED_MODULI | MPM_LAW_VOLUME,
               .stiffness = ElasticStiffness, .shear_modulus = ElasticShearModulus, .shear_strength = ShearStrength,
               MPM_MODULI(j2))

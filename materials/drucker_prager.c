/*
  Drucker-Prager plasticity: Hencky elasticity, a cone in stress space with its apex, optional correction for volume
  gained at the apex

    b_trial = dF b_n dF^T,   e = (1/2) ln b + (v_n/3) I,   tau = lambda tr(e) I + 2 mu e
    f = sqrt(J2(tau)) + eta p - xi c <= 0,   p = tr(tau)/3, tension positive
    flow potential sqrt(J2) + eta_bar p

  tau  Kirchhoff stress J sigma, tension positive, Pa; f bounds the Kirchhoff stress, not the Cauchy stress
  b    elastic left Cauchy-Green tensor (history)
  v    volume correction (history)
  alpha  equivalent plastic strain (history): grows by sqrt(2/3) |dev e_p|, on which nothing depends

  eta and xi follow from the friction angle phi by fitting the Mohr-Coulomb surface, eta_bar from the dilation angle as
  eta from phi:

    compression   meets it in triaxial compression:  eta = 6 sin phi/(sqrt(3) (3 - sin phi)), xi = 6 cos phi/(sqrt(3)
                  (3 - sin phi))
    extension     meets it in triaxial extension:    the same with 3 + sin phi
    plane_strain  same collapse load in plane strain (associated flow):  eta = 3 tan phi/sqrt(9 + 12 tan^2 phi), xi =
                  3/sqrt(9 + 12 tan^2 phi)

  Return to the cone:  dg = f_trial/(mu + K eta eta_bar),  sqrt(J2) -= mu dg,  p -= K eta_bar dg. Where that would make
  sqrt(J2) negative, return to the apex: dev tau = 0, p = xi c/eta. At the apex the point has no stiffness: the
  derivative of its stress is zero.

  A point pulled apart at the apex loses volumetric strain and would, on the way back, resist before the gap has
  closed. Following Tampubolon et al. (2017), v accumulates the volumetric logarithmic strain lost there and is added
  back to the trial strain (a third to each normal component, in plane strain too). Once the point leaves the apex its
  elastic strain holds the correction, and v returns to 0.

  The tangent is not symmetric unless dilation = friction.

  Source: de Souza Neto, Peric and Owen (2008), doi:10.1002/9780470694626, sections 6.4 and 8.3; Tampubolon et al.
  (2017), doi:10.1145/3072959.3073651; Klar et al. (2016), doi:10.1145/2897824.2925906.
*/
#include "talus/point/elasticity.h"

enum { COHESION = ELASTIC_COUNT, FRICTION, DILATION, FIT, VOLUME_CORRECTION };

static const MpmParameter parameters[] = {
  ELASTIC_PARAMETERS,
  {MPM_STRENGTH, "cohesion", "Pa", 0., 1, 0., HUGE_VAL, 0, "c of Mohr-Coulomb", NULL, 5e3, NULL},
  {MPM_STRENGTH_ANGLE, "friction", "degrees", 0., 1, 0., 89., 0, "friction angle of Mohr-Coulomb", NULL, 30., NULL},
  {MPM_STRENGTH_ANGLE, "dilation", "degrees", 0., 0, 0., 89., 0, "dilation angle, at most the friction angle", NULL,
   10., NULL},
  {MPM_WORD, "fit", "", 0., 0, 0., 2., 0, "where the cone meets Mohr-Coulomb", "compression|extension|plane_strain", 0.,
   NULL},
  {MPM_WORD, "volume_correction", "", 1., 0, 0., 1., 0,
   "return volume gained at the apex before compression meets resistance", "off|on", 0., NULL}};

enum { STATE_B = 0, STATE_V = MPM_SYM, STATE_ALPHA };

static const MpmStateVariable states[] = {{"elastic_left_cauchy_green", MPM_STATE_SYM, 1., "-"},
                                          {"volume_correction", MPM_STATE_SCALAR, 0., "-"},
                                          {"equivalent_plastic_strain", MPM_STATE_SCALAR, 0., "-"}};

/* Slope eta and cohesion factor xi of the cone for an angle in degrees and a value of `fit` */
typedef struct {
  Real eta, xi;
} Cone;

MPM_FN Cone ConeFromAngle(Real degrees, Real fit)
{
  const Real angle = degrees * 3.14159265358979323846 / 180.;
  Cone       cone;

  if (RealValue(fit) < 1.5) {
    const Real sine = RealSin(angle), scale = 6. / (sqrt(3.) * (3. + (RealValue(fit) < 0.5 ? -sine : sine)));

    cone.eta = scale * sine;
    cone.xi  = scale * RealCos(angle);
  } else {
    cone.xi  = 3. / RealSqrt(9. + 12. * RealTan(angle) * RealTan(angle));
    cone.eta = cone.xi * RealTan(angle);
  }
  return cone;
}

/* The yield condition in elastic strains, |dev e| + slope tr(e) - size <= 0 */
typedef struct {
  Real slope; /* sqrt(2) eta K/(2 mu) */
  Real size;  /* sqrt(2) xi c/(2 mu) */
} StrainCone;

MPM_FN StrainCone StrainConeFromParameters(const Real *parameter, Lame lame)
{
  const Cone yield = ConeFromAngle(parameter[FRICTION], parameter[FIT]);
  const Real bulk  = lame.lambda + 2. / 3. * lame.mu;
  StrainCone cone;

  cone.slope = yield.eta * bulk / (sqrt(2.) * lame.mu);
  cone.size  = yield.xi * parameter[COHESION] / (sqrt(2.) * lame.mu);
  return cone;
}

/* tr(e) gained per |dev e| lost in plastic flow: sqrt(2) eta_bar */
MPM_FN Real FlowFromParameters(const Real *parameter)
{
  return sqrt(2.) * ConeFromAngle(parameter[DILATION], parameter[FIT]).eta;
}

typedef enum { ELASTIC, ON_CONE, AT_APEX } Regime;

/* Takes a trial strain to the yield surface if it is outside. */
MPM_FN Regime ReturnMap(const Real *parameter, const StrainCone *cone, Sym *e)
{
  const Sym    dev    = SymDev(e);
  const Scalar trace  = SymTrace(e);
  const double norm   = SymNormValue(&dev);
  const double excess = norm + RealValue(cone->slope) * ScalarValue(trace) - RealValue(cone->size);
  Real         flow, denominator;

  if (!(excess > ELASTIC_STRAIN_NOISE)) return ELASTIC;
  flow        = FlowFromParameters(parameter);
  denominator = 1. + cone->slope * flow;
  if (norm * RealValue(denominator) >= excess) {
    /* excess > 0 makes the norm positive here */
    const Scalar length  = SymNorm(&dev);
    const Scalar outside = ScalarAdd(length, ScalarShift(ScalarScale(cone->slope, trace), -cone->size));
    const Scalar dg      = ScalarScale(1. / denominator, outside);

    *e = SymAxpy(ScalarNeg(ScalarDiv(dg, length)), &dev, e);
    *e = SymShift(e, ScalarScale(-flow / 3., dg));
    return ON_CONE;
  }
  /* Only a cone with a slope has an apex: with slope 0 the norm is at least the excess. */
  *e = SymZero();
  *e = SymShift(e, ScalarConstant(cone->size / (3. * cone->slope)));
  return AT_APEX;
}

MPM_FN int MpmMaterialEvaluate_drucker_prager(const MpmLawPoint *point, const Tensor *dF, Sym *tau)
{
  const Real      *parameter = point->parameter;
  const Lame       lame      = LameFromParameters(parameter);
  const StrainCone cone      = StrainConeFromParameters(parameter, lame);
  const Real       v_n       = point->state_n[STATE_V];
  Sym              b         = SymPush(dF, &point->state_n[STATE_B]);
  Real             trace_trial;
  Sym              e, trial;
  Regime           regime;

  if (!ElasticIsRegular(point, dF) || ElasticLogStrain(&b, &e)) return 1;
  if (!RealVanishes(v_n)) e = SymShift(&e, ScalarConstant(v_n / 3.));
  trace_trial = ScalarReal(SymTrace(&e));
  trial       = e;
  regime      = ReturnMap(parameter, &cone, &e);
  *tau        = ElasticStress(lame, &e);
  if (point->state) {
    const int keep = regime == AT_APEX && RealValue(parameter[VOLUME_CORRECTION]) > 0.5;

    if ((regime != ELASTIC || !RealVanishes(v_n)) && ElasticLeftCauchyGreen(&e, &b)) return 1;
    SymStore(&point->state[STATE_B], &b);
    point->state[STATE_V]     = keep ? trace_trial - ScalarReal(SymTrace(&e)) : 0.;
    point->state[STATE_ALPHA] = point->state_n[STATE_ALPHA];
    if (regime != ELASTIC) point->state[STATE_ALPHA] += ElasticPlasticGrowth(&trial, &e);
  }
  return 0;
}

static int MpmMaterialCheck_drucker_prager(const double *parameter, const MpmLawTable *table, MpmLawFault *fault)
{
  const MpmLawFault above = {DILATION, 0., parameter[FRICTION], 0, "dilation must not exceed friction"};

  (void)table;
  *fault = above;
  return parameter[DILATION] <= parameter[FRICTION];
}

/* Jaky: the law does not know what it has borne before. */
static double MpmMaterialK0_drucker_prager(const double *parameter, const MpmLawTable *table, const double *state,
                                           double weight)
{
  (void)table;
  (void)state;
  (void)weight;
  return 1. - sin(parameter[FRICTION] * 3.14159265358979323846 / 180.);
}

MPM_LAW_MODULI(drucker_prager, parameters, states, ElasticModuli)

MPM_LAW_DEFINE(drucker_prager, parameters, states, MpmMaterialEvaluate_drucker_prager,
               .summary = "Drucker-Prager plasticity with cohesion, dilation and volume correction",
               .traits  = MPM_LAW_PLASTIC | MPM_LAW_FIXED_MODULI | MPM_LAW_VOLUME,
               .check = MpmMaterialCheck_drucker_prager, .stiffness = ElasticStiffness,
               .shear_modulus = ElasticShearModulus, .k0 = MpmMaterialK0_drucker_prager, MPM_MODULI(drucker_prager))

/*
  Hypoelasticity with Jaumann's rate of the Cauchy stress, optionally bounded by Mohr-Coulomb: the law of most explicit
  codes

    dsigma/dt = lambda tr(d) I + 2 mu d + w sigma - sigma w ,   d + w = grad v, symmetric and skew

  in steps, with the polar decomposition of the step's dF = V R,

    sigma_trial = R sigma_n R^T + lambda tr(e) I + 2 mu e ,   e = ln V = (1/2) ln(dF dF^T) ,   tau = J sigma

  sigma  Cauchy stress, tension positive, Pa (history)
  J      det F, of the whole deformation

  With `cohesion` the Cauchy stress is returned to Mohr-Coulomb's planes (coulomb.h), without hardening; without it the
  law is elastic.

  A stress beyond the apex or the tension strength is cut, and its volume stays: the point has opened. With `closing` k,
  without dilation, a compression tr e < 0 first closes it: of the opening o >= 0 it takes c = min(o, k |tr e|), and the
  stress is that of e + (c/3) I. With k = 1 an open point carries no pressure, and a point under pressure has only the
  volume of its elastic strain. With 0, the default, openings stay, and points that open and close in turn grow.

  The step is exact for any rotation, before, in or after it, and for any stretch whose axes do not turn; it has a local
  error of third order, so that the path's is of second order in the step. ln V carries half of the step's rotation
  already, as the mid-point rule does; the polar R keeps that exact for turns of any size, which Cayley's form of Hughes
  and Winget's is not.

  No potential: stress depends on the path, and a closed cycle makes or takes energy. Measured by the tests, for stretch
  g, shear g, back from the stretch, back from the shear, in small steps and for any nu: an elastic point has taken up a
  work of (mu/2) g^3 per volume, which for nu = 0.3 is 0.22 g of the largest on the way (2 % at g = 0.1), and is left
  with sigma_yy = -sigma_xx = -sigma_xy = (mu/2) g^3; both are 1 % to 14 % less for g of 0.01 to 0.1. On the way that it
  came it returns to rounding. Simple shear gives sigma_xy = mu sin(gamma), which falls beyond gamma = pi/2.

  The tangent is not symmetric: tau = J sigma is not the stress of this rate.

  Source: Jaumann (1911), Sitzungsberichte der Akademie der Wissenschaften in Wien IIa 120, 385-530; Hughes and Winget
  (1980), doi:10.1002/nme.1620151210, for the step; Simo and Hughes (1998), doi:10.1007/b98904, section 8.3, for
  algorithms that are exact under rotation; Kojic and Bathe (1987), doi:10.1016/0045-7949(87)90247-1, for closed cycles;
  Dienes (1979), doi:10.1007/BF01379008, for simple shear.
*/
#include "talus/point/coulomb.h"

enum { COHESION = ELASTIC_COUNT, FRICTION, DILATION, TENSION, CLOSING };

static const MpmParameter parameters[] = {
  ELASTIC_PARAMETERS,
  {MPM_STRENGTH, "cohesion", "Pa", HUGE_VAL, 0, 0., HUGE_VAL, 0, "c of Mohr-Coulomb; without it the law is elastic",
   NULL, 20e3, NULL},
  {MPM_STRENGTH_ANGLE, "friction", "degrees", 0., 0, 0., 89., 0, "friction angle of Mohr-Coulomb", NULL, 30., NULL},
  {MPM_STRENGTH_ANGLE, "dilation", "degrees", 0., 0, 0., 89., 0, "dilation angle, at most the friction angle", NULL,
   10., NULL},
  {MPM_STRENGTH, "tension", "Pa", HUGE_VAL, 0, 0., HUGE_VAL, 0,
   "largest tension that the material bears, at most c cot(friction); without it, that", NULL, 10e3, NULL},
  {MPM_NUMBER, "closing", "-", 0., 0, 0., 1., 0,
   "part of a compression that closes what tension has opened, and bears nothing; without dilation", NULL, 0., NULL}};

enum { STATE_SIGMA = 0, STATE_KAPPA = MPM_SYM, STATE_OPENING };

static const MpmStateVariable states[] = {{"cauchy_stress", MPM_STATE_SYM, 0., "Pa"},
                                          {"equivalent_plastic_strain", MPM_STATE_SCALAR, 0., "-"},
                                          {"opening", MPM_STATE_SCALAR, 0., "-"}};

/* The closed opening is taken out of both. */
MPM_FN void Close(Real closing, Sym *e, Real *opening)
{
  Scalar closed = ScalarScale(-closing, SymTrace(e));

  if (!(ScalarValue(closed) > 0.)) return;
  if (ScalarValue(closed) > RealValue(*opening)) closed = ScalarConstant(*opening);
  *e = SymShift(e, ScalarScale(1. / 3., closed));
  *opening -= ScalarReal(closed);
}

/* R sigma R^T + C ln V, dF = V R, without what closes; non-zero where dF has no such parts */
MPM_FN int TrialStress(Lame lame, const Tensor *dF, const Real *sigma_n, Real closing, Real *opening, Sym *sigma)
{
  const Sym b = SymLeftCauchyGreen(dF);
  Sym       e, minus, inverse, elastic, turned;
  Tensor    R;

  if (ElasticLogStrain(&b, &e)) return 1;
  minus = SymScaleBy(-1., &e);
  if (SymExp(&minus, &inverse)) return 1;
  R = TensorSymMul(&inverse, dF);
  Close(closing, &e, opening);
  turned  = SymPush(&R, sigma_n);
  elastic = ElasticStress(lame, &e);
  *sigma  = SymAdd(&turned, &elastic);
  return 0;
}

MPM_FN CoulombStrength StrengthFromParameters(const Real *parameter)
{
  const Real      degree = 3.14159265358979323846 / 180.;
  CoulombStrength strength =
    CoulombStrengthCreate(DualConstant(parameter[COHESION]), DualConstant(degree * parameter[FRICTION]));

  strength.cut = 2. * RealValue(parameter[TENSION]) * DualValue(strength.sin_phi) < DualValue(strength.shear) &&
                 RealValue(parameter[TENSION]) <= DBL_MAX; /* below the apex */
  if (strength.cut) strength.tension = DualConstant(parameter[TENSION]);
  return strength;
}

/* As in mohr_coulomb.c, of a stress: by its invariants, then by its principal values, with a margin for their error in
   3D */
MPM_FN int IsSurelyElastic(const CoulombStrength *strength, Lame lame, const Sym *sigma)
{
  const double root = sqrt(0.5) * SymDevNormValue(sigma), p = ScalarValue(SymTrace(sigma)) / 3.;
  double       w[3];

  if (CoulombIsSurelyInside(strength, p, root)) return 1;
  SymPrincipalValues(sigma, w);
  return CoulombExcess(strength, w[0], w[2]) + (MPM_DIM == 3 ? 1e-6 * root : 0.) <= CoulombNoise(lame);
}

/* Returns sigma to the strength where it is outside; kappa is the growth of the equivalent plastic strain, and the
   opening grows. */
MPM_FN int Return(const Real *parameter, Lame lame, Sym *sigma, Real *kappa, Real *opening)
{
  const CoulombStrength strength = StrengthFromParameters(parameter);
  const Sym             outside  = *sigma;
  CoulombFlow           flow;
  SymPrincipal          principal;
  Dual                  trial[3], t[3];

  if (IsSurelyElastic(&strength, lame, sigma)) return 0;
  if (SymPrincipalCreate(sigma, &principal)) return 1;
  if (CoulombExcess(&strength, principal.value[0], principal.value[2]) <= CoulombNoise(lame)) return 0;
  flow = CoulombFlowCreate(lame, &strength, DualSin(DualConstant(3.14159265358979323846 / 180. * parameter[DILATION])));
  for (int a = 0; a < 3; ++a) trial[a] = t[a] = DualSeed(principal.value[a], a);
  if (CoulombReturn(&strength, &flow, t)) return 1;
  *sigma = SymIsotropic(&outside, &principal, t);
  if (RealValue(parameter[CLOSING]) > 0.)
    *opening += ScalarReal(ScalarSub(SymTrace(&outside), SymTrace(sigma))) / (3. * lame.lambda + 2. * lame.mu);
  *kappa = ScalarReal(SymInvariant(&outside, &principal, CoulombPlasticStrain(lame, trial, t)));
  return 0;
}

MPM_FN int MpmMaterialEvaluate_jaumann_elastic(const MpmLawPoint *point, const Tensor *dF, Sym *tau)
{
  const Lame   lame  = LameFromParameters(point->parameter);
  const Tensor F     = TensorMulArray(dF, point->F_n);
  Real         grown = 0., opening = point->state_n[STATE_OPENING];
  Sym          sigma;

  if (!ElasticIsRegular(point, dF) ||
      TrialStress(lame, dF, &point->state_n[STATE_SIGMA], point->parameter[CLOSING], &opening, &sigma))
    return 1;
  if (RealValue(point->parameter[COHESION]) <= DBL_MAX && Return(point->parameter, lame, &sigma, &grown, &opening))
    return 1;
  *tau = SymScale(TensorDetByCofactors(&F), &sigma);
  if (point->state) {
    SymStore(&point->state[STATE_SIGMA], &sigma);
    point->state[STATE_KAPPA]   = point->state_n[STATE_KAPPA] + grown;
    point->state[STATE_OPENING] = opening;
  }
  return 0;
}

static int MpmMaterialCheck_jaumann_elastic(const double *parameter, const MpmLawTable *table, MpmLawFault *fault)
{
  const int         elastic  = !(parameter[COHESION] <= DBL_MAX);
  const double      apex     = parameter[COHESION] / tan(parameter[FRICTION] * 3.14159265358979323846 / 180.);
  const int         cut      = parameter[TENSION] <= DBL_MAX;
  const MpmLawFault limits[] = {
    {FRICTION, 0., elastic ? 0. : 89., 0, "without cohesion, which may be 0, nothing yields"},
    {COHESION, 0., HUGE_VAL, !(parameter[FRICTION] > 0.), "without friction there must be cohesion"},
    {DILATION, 0., parameter[FRICTION], 0, "dilation must not exceed friction"},
    {CLOSING, 0., elastic || parameter[DILATION] > 0. ? 0. : 1., 0,
     "what closes has been opened by tension: that needs cohesion, which may be 0, and no dilation"},
    {TENSION, 0., parameter[FRICTION] > 0. && cut && !elastic ? apex * (1. + 1e-14) : HUGE_VAL, 0,
     "tension must not exceed cohesion cot(friction), where the planes meet"}};

  (void)table;
  fault->parameter = -1;
  fault->why       = "tension is given without cohesion";
  if (elastic && cut) return 0;
  for (size_t k = 0; k < sizeof(limits) / sizeof(limits[0]); ++k) {
    const double value = parameter[limits[k].parameter];

    *fault = limits[k];
    if (!(value >= fault->lower && value <= fault->upper) || (fault->open && value == fault->lower)) return 0;
  }
  return 1;
}

/* J (lambda + 2 mu), J that of F, and J sigma at most, by the largest sum of |sigma| over a row */
static double MpmMaterialStiffness_jaumann_elastic(const double *parameter, const MpmLawTable *table,
                                                   const double *state, const double *F)
{
  double largest = 0.;

  for (int i = 0; state && i < 3; ++i) {
    double sum = fabs(state[STATE_SIGMA + i]);

    for (int j = 0; j < MPM_DIM && i < MPM_DIM; ++j)
      if (j != i) sum += fabs(state[STATE_SIGMA + SymIndex(i, j)]);
    largest = fmax(largest, sum);
  }
  return (F ? MpmDeterminant(MPM_TENSOR, F) : 1.) * (ElasticStiffness(parameter, table, state, F) + largest);
}

/* J mu */
static double MpmMaterialShearModulus_jaumann_elastic(const double *parameter, const MpmLawTable *table,
                                                      const double *state, const double *F)
{
  return (F ? MpmDeterminant(MPM_TENSOR, F) : 1.) * ElasticShearModulus(parameter, table, state, F);
}

/* The stress is the history. */
static int MpmMaterialHistory_jaumann_elastic(const double *parameter, const MpmLawTable *table, const double *stress,
                                              double *state)
{
  double sum = 0.;

  (void)parameter, (void)table;
  for (int i = 0; i < MPM_SYM; ++i) {
    state[STATE_SIGMA + i] = stress[i];
    sum += fabs(stress[i]);
  }
  return !(sum <= DBL_MAX);
}

/* Jaky; without strength that of elasticity at rest, nu/(1 - nu). The law does not know what it has borne before. */
static double MpmMaterialK0_jaumann_elastic(const double *parameter, const MpmLawTable *table, const double *state,
                                            double weight)
{
  (void)table, (void)state, (void)weight;
  if (!(parameter[COHESION] <= DBL_MAX)) return parameter[ELASTIC_NU] / (1. - parameter[ELASTIC_NU]);
  return 1. - sin(parameter[FRICTION] * 3.14159265358979323846 / 180.);
}

MPM_LAW_DEFINE(jaumann_elastic, parameters, states, MpmMaterialEvaluate_jaumann_elastic,
               .summary = "hypoelasticity with Jaumann's rate, optionally with Mohr-Coulomb plasticity",
               .traits = MPM_LAW_PLASTIC | MPM_LAW_VOLUME, .check = MpmMaterialCheck_jaumann_elastic,
               .stiffness     = MpmMaterialStiffness_jaumann_elastic,
               .shear_modulus = MpmMaterialShearModulus_jaumann_elastic, .history = MpmMaterialHistory_jaumann_elastic,
               .k0 = MpmMaterialK0_jaumann_elastic)

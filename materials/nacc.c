/*
  NACC, non-associated Cam-Clay: snow and other brittle foams. Neo-Hookean elasticity, an ellipse with cohesion, flow at
  constant pressure, hardening and softening by the volume

    b_trial = dF b_n dF^T,   J = sqrt(det b),   m = tr(b)/3
    tau = mu J^(-2/3) dev b - p I,   p = -(K/2) (J^2 - 1)
    y = (3/2) (1 + 2 beta) |dev tau|^2 + M^2 (p + beta p_0) (p - p_0) <= 0
    p_0 = K (1e-5 + sinh(xi max(-a, 0))),   a = alpha_0 + v

  tau  Kirchhoff stress J sigma, tension positive, Pa; p is positive in compression, and y bounds the Kirchhoff stress
  b    elastic left Cauchy-Green tensor (history)
  v    logarithmic plastic volume strain since the start (history); a is the hardening variable, more compact below 0
  alpha  equivalent plastic strain (history): grows by sqrt(2/3) |dev e_p|, on which nothing depends
  p_0  compressive strength, beta p_0 that in tension; M is the ellipse's height over half its length for beta = 0, q/p
       at critical state, 6 sin phi/(3 - sin phi)

  Return, with p_0 at the step's start:

    p > p_0        b = J_e^(2/3) I, J_e of p = p_0; v grows by ln(J/J_e)
    p < -beta p_0  likewise with p = -beta p_0: the point has no stiffness there, as at the cap
    y > 0          dev b is scaled down until y = 0 at the trial p and J; tr b stays, and J changes in second order. v
                   grows by ln(J/J_x): J_x is that of p_x, where the ellipse meets the line from its centre p_c = (1 -
                   beta) p_0/2 to the trial state, if that p_x is one that elasticity has, p_x < K/2

  Strength lags by a step: hardening or softening of a step acts from the next on. A point whose strength has fallen
  goes on losing stress though nothing moves, and results depend on the step. The stress of a step is not smooth where
  it goes from the ellipse to one of the tips: it jumps by terms of the order of |dev b|^2; the tangent is that of the
  branch taken, and is not symmetric.

  y is compared with its rounding error, in its own unit.

  The source has other constants in 2D; here plane strain is that of a solid.

  Source: Gaume et al. (2018), doi:10.1038/s41467-018-05181-w; Wolper et al. (2019), doi:10.1145/3306346.3322949.
*/
#include "talus/point/elasticity.h"

enum { CRITICAL = ELASTIC_COUNT, BETA, XI, ALPHA_0 };

static const MpmParameter parameters[] = {
  ELASTIC_PARAMETERS,
  {MPM_STRENGTH, "M", "-", 0., 1, 0., HUGE_VAL, 1, "q/p at critical state, 6 sin phi/(3 - sin phi)", NULL, 2., NULL},
  {MPM_NUMBER, "beta", "-", 0., 0, 0., HUGE_VAL, 0, "strength in isotropic tension over that in compression", NULL, 0.5,
   NULL},
  {MPM_NUMBER, "xi", "-", 0., 1, 0., HUGE_VAL, 0, "hardening factor", NULL, 30., NULL},
  {MPM_NUMBER, "alpha_0", "-", 0., 0, -1., 1., 0,
   "initial logarithmic plastic volume strain: below 0 has strength, the more the denser", NULL, -0.002, NULL}};

enum { STATE_B = 0, STATE_V = MPM_SYM, STATE_ALPHA };

static const MpmStateVariable states[] = {{"elastic_left_cauchy_green", MPM_STATE_SYM, 1., "-"},
                                          {"plastic_volume_strain", MPM_STATE_SCALAR, 0., "-"},
                                          {"equivalent_plastic_strain", MPM_STATE_SCALAR, 0., "-"}};

/* p_0 at rest, over the bulk modulus */
#define LEAST_STRENGTH 1e-5

/* K and p_0 */
typedef struct {
  Lame lame;
  Real bulk, strength;
} Solid;

MPM_FN Solid SolidAt(const Real *parameter, Real v)
{
  const Real a = parameter[ALPHA_0] + v;
  Solid      solid;

  solid.lame     = LameFromParameters(parameter);
  solid.bulk     = solid.lame.lambda + 2. / 3. * solid.lame.mu;
  solid.strength = LEAST_STRENGTH * solid.bulk;
  if (RealValue(a) < 0.)
    solid.strength += 0.5 * solid.bulk * (RealExp(-parameter[XI] * a) - RealExp(parameter[XI] * a));
  return solid;
}

MPM_FN Real StateDet(const Real *b)
{
#if MPM_DIM == 2
  return b[2] * (b[0] * b[1] - b[3] * b[3]);
#else
  return b[0] * (b[1] * b[2] - b[4] * b[4]) - b[3] * (b[3] * b[2] - b[4] * b[5]) + b[5] * (b[3] * b[4] - b[1] * b[5]);
#endif
}

/* The elastic state by what the law needs of it */
typedef struct {
  Sym    dev;
  Scalar mean, det, square; /* tr(b)/3, det b, dev b : dev b */
} Elastic;

MPM_FN Scalar Pressure(const Solid *solid, const Elastic *elastic)
{
  return ScalarScale(-0.5 * solid->bulk, ScalarShift(elastic->det, -1.));
}

/* Scales the deviator by g, the trace stays: det(m I + D) = m^3 - m D:D/2 + det D */
MPM_FN void ScaleDeviator(Scalar g, Elastic *elastic)
{
  const Scalar g2   = ScalarSquare(g);
  const Scalar cube = ScalarMul(elastic->mean, ScalarSquare(elastic->mean));
  const Scalar half = ScalarScale(0.5, ScalarMul(elastic->mean, elastic->square));
  const Scalar detD = ScalarAdd(ScalarSub(elastic->det, cube), half);

  elastic->det    = ScalarAdd(ScalarSub(cube, ScalarMul(g2, half)), ScalarMul(ScalarMul(g, g2), detD));
  elastic->dev    = SymScale(g, &elastic->dev);
  elastic->square = ScalarMul(g2, elastic->square);
}

/* The state without deviator at a pressure p; returns by how much v grows. */
MPM_FN Scalar ReturnToTip(const Solid *solid, Real p, Elastic *elastic)
{
  const Real   det  = 1. - 2. * p / solid->bulk;
  const Scalar grow = ScalarScale(0.5, ScalarLog(ScalarScale(1. / det, elastic->det)));

  elastic->dev  = SymZero();
  elastic->mean = ScalarConstant(RealPow(det, 1. / 3.));
  elastic->det  = ScalarConstant(det);
  return grow;
}

/*
  Takes the state to the ellipse at the pressure p, if it is outside. Returns by how much v grows; 1 in *flows: outside.
*/
MPM_FN Scalar ReturnToEllipse(const Real *parameter, const Solid *solid, Scalar p, Elastic *elastic, int *flows)
{
  const Real   M2 = parameter[CRITICAL] * parameter[CRITICAL], beta = parameter[BETA], p_0 = solid->strength;
  const Real   factor = 1.5 * (1. + 2. * beta), mu2 = solid->lame.mu * solid->lame.mu;
  const Real   centre = 0.5 * (1. - beta) * p_0, radius = 0.5 * (1. + beta) * p_0;
  const Scalar shear = ScalarScale(factor * mu2, ScalarMul(elastic->square, ScalarPow(elastic->det, -2. / 3.)));
  const Scalar bound =
    ScalarScale(-M2, ScalarMul(ScalarShift(p, beta * p_0), ScalarShift(p, -p_0))); /* y = shear - bound */
  const double noise = ELASTIC_STRAIN_NOISE * (RealValue(solid->bulk * M2 * p_0 * (1. + beta)) +
                                               2. * RealValue(factor * mu2) * sqrt(ScalarValue(elastic->square)));
  Scalar       off, t, p_x, det;

  *flows = ScalarValue(shear) - ScalarValue(bound) > noise;
  if (!*flows) return ScalarConstant(0.);
  if (!(ScalarValue(bound) > 0.))
    return ReturnToTip(solid, ScalarValue(p) > RealValue(centre) ? p_0 : -beta * p_0, elastic);
  off = ScalarShift(p, -centre);
  t   = ScalarDiv(ScalarConstant(parameter[CRITICAL] * radius),
                  ScalarSqrt(ScalarAdd(shear, ScalarScale(M2, ScalarSquare(off)))));
  p_x = ScalarShift(ScalarMul(t, off), centre);
  det = ScalarShift(ScalarScale(-2. / solid->bulk, p_x), 1.);
  t   = ScalarConstant(0.);
  if (ScalarValue(det) > 0.) t = ScalarScale(0.5, ScalarLog(ScalarDiv(elastic->det, det)));
  ScaleDeviator(ScalarSqrt(ScalarDiv(bound, shear)), elastic);
  return t;
}

MPM_FN int MpmMaterialEvaluate_nacc(const MpmLawPoint *point, const Tensor *dF, Sym *tau)
{
  const Real *parameter = point->parameter;
  const Solid solid     = SolidAt(parameter, point->state_n[STATE_V]);
  const Real  p_0 = solid.strength, tension = -parameter[BETA] * p_0;
  const Sym   b = SymPush(dF, &point->state_n[STATE_B]);
  Elastic     elastic;
  Scalar      p, grow;
  int         flows = 1;

  if (!ElasticIsRegular(point, dF)) return 1;
  elastic.dev    = SymDev(&b);
  elastic.mean   = ScalarScale(1. / 3., SymTrace(&b));
  elastic.det    = ScalarScale(StateDet(&point->state_n[STATE_B]), ScalarSquare(TensorDet(dF)));
  elastic.square = SymDot(&elastic.dev, &elastic.dev);
  p              = Pressure(&solid, &elastic);
  if (!(ScalarValue(elastic.det) > 0. && ScalarValue(elastic.square) <= DBL_MAX)) return 1;

  if (ScalarValue(p) > RealValue(p_0)) grow = ReturnToTip(&solid, p_0, &elastic);
  else if (ScalarValue(p) < RealValue(tension)) grow = ReturnToTip(&solid, tension, &elastic);
  else grow = ReturnToEllipse(parameter, &solid, p, &elastic, &flows);

  if (!(ScalarValue(elastic.det) > 0.)) return 1;
  *tau = SymScale(ScalarScale(solid.lame.mu, ScalarPow(elastic.det, -1. / 3.)), &elastic.dev);
  *tau = SymShift(tau, ScalarNeg(Pressure(&solid, &elastic)));
  if (point->state) {
    const Sym after = SymShift(&elastic.dev, elastic.mean);

    SymStore(&point->state[STATE_B], flows ? &after : &b);
    point->state[STATE_V]     = point->state_n[STATE_V] + ScalarReal(grow);
    point->state[STATE_ALPHA] = point->state_n[STATE_ALPHA];
    if (flows) {
      Sym trial, end;

      if (ElasticLogStrain(&b, &trial) || ElasticLogStrain(&after, &end)) return 1;
      point->state[STATE_ALPHA] += ElasticPlasticGrowth(&trial, &end);
    }
  }
  return 0;
}

/* K J^2 + (2/3) mu J^(-2/3) (b_xx + tr(b)/3) along the stiffest axis */
static double MpmMaterialStiffness_nacc(const double *parameter, const MpmLawTable *table, const double *state,
                                        const double *F)
{
  const Lame   lame = LameFromValues(parameter);
  const double mu = RealValue(lame.mu), bulk = RealValue(lame.lambda) + 2. / 3. * mu;
  double       det = 1., largest = 1., mean = 1.;
  Real         b[MPM_SYM];

  (void)table, (void)F;
  if (state) {
    for (int i = 0; i < MPM_SYM; ++i) b[i] = state[i];
    det     = RealValue(StateDet(b));
    largest = fmax(state[0], fmax(state[1], state[2]));
    mean    = (state[0] + state[1] + state[2]) / 3.;
  }
  return bulk * det + 2. / 3. * mu * (largest + mean) / cbrt(det);
}

/* d tau_xy/d gamma_xy is mu J^(-2/3) (b_xx + b_yy)/2; mu J^(-2/3) tr(b)/3 over all planes */
static double MpmMaterialShearModulus_nacc(const double *parameter, const MpmLawTable *table, const double *state,
                                           const double *F)
{
  Real b[MPM_SYM];

  (void)table, (void)F;
  if (!state) return RealValue(LameFromValues(parameter).mu);
  for (int i = 0; i < MPM_SYM; ++i) b[i] = state[i];
  return RealValue(LameFromValues(parameter).mu) * (state[0] + state[1] + state[2]) / 3. / cbrt(RealValue(StateDet(b)));
}

MPM_LAW_DEFINE(nacc, parameters, states, MpmMaterialEvaluate_nacc,
               .summary = "snow and brittle foam: non-associated Cam-Clay with cohesion",
               .traits = MPM_LAW_PLASTIC | MPM_LAW_LAGGED | MPM_LAW_VOLUME, .stiffness = MpmMaterialStiffness_nacc,
               .shear_modulus = MpmMaterialShearModulus_nacc)

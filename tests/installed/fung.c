/*
  Fung: a rubber that stiffens exponentially, with the largest stretch that a point has seen for its history

    W = mu/(2 k) (exp(k q) - 1) + (lambda/2) (ln J)^2 ,     q = tr b - 3 - 2 ln J ,     b = F F^T

    tau = mu exp(k q) (b - 1) + lambda ln J 1

  Source: Fung (1967), doi:10.1152/ajplegacy.1967.213.6.1532, made compressible.
*/
#include "talus/point/elasticity.h"

enum { STIFFENING = ELASTIC_COUNT };

static const MpmParameter parameters[] = {
  ELASTIC_PARAMETERS,
  {MPM_NUMBER, "stiffening", "-", 0.5, 0, 0., 2., 0, "exponent k of the stiffening", NULL, 0., NULL}};

static const MpmStateVariable states[] = {{"largest_stretch", MPM_STATE_SCALAR, 3., "-"}};

MPM_FN int MpmMaterialEvaluate_fung(const MpmLawPoint *point, const Tensor *dF, Sym *tau)
{
  const Real   k      = point->parameter[STIFFENING];
  const Lame   lame   = LameFromParameters(point->parameter);
  const Tensor F      = TensorMulArray(dF, point->F_n);
  const Sym    b      = SymLeftCauchyGreen(&F);
  const Sym    strain = SymShift(&b, ScalarConstant(-1.));
  const Scalar ln = ScalarLog(TensorDet(&F)), I = SymTrace(&b);
  const Scalar q = ScalarSub(ScalarShift(I, -3.), ScalarScale(2., ln));
  Sym          stretched;

  if (!ElasticIsRegular(point, dF)) return 1;
  stretched = SymScale(ScalarScale(lame.mu, ScalarExp(ScalarScale(k, q))), &strain);
  *tau      = SymShift(&stretched, ScalarScale(lame.lambda, ln));
  if (point->state) {
    const Real before = point->state_n[0], now = ScalarReal(I);

    point->state[0] = RealValue(now) > RealValue(before) ? now : before;
  }
  return 0;
}

/* tr b; q */
static double Trace(const double *F, double *q)
{
  double trace = MPM_NORMALS == 2 ? 1. : 0.;

  for (int i = 0; i < MPM_TENSOR; i++) trace += F[i] * F[i];
  *q = trace - 3. - 2. * log(MpmDeterminant(MPM_TENSOR, F));
  return trace;
}

/* d tau/d ln(stretch) along a principal axis is lambda + 2 mu exp(k q) (b + k (b - 1)^2), with (b - 1)^2 <= 2 q tr b. */
static double Stiffness(const double *parameter, const MpmLawTable *table, const double *state, const double *F)
{
  const Lame   lame = LameFromValues(parameter);
  const double k = parameter[STIFFENING], lambda = RealValue(lame.lambda), mu = RealValue(lame.mu);
  double       q, trace;

  (void)table, (void)state;
  if (!F) return lambda + 2. * mu;
  trace = Trace(F, &q);
  q     = fmax(q, 0.);
  return lambda + 2. * mu * exp(k * q) * (1. + sqrt(2. * q * trace) + 2. * k * q * trace);
}

/* d tau_xy/d gamma_xy is mu exp(k q) (b_xx + b_yy)/2 near rest: mu exp(k q) tr(b)/3 over all planes. */
static double ShearModulus(const double *parameter, const MpmLawTable *table, const double *state, const double *F)
{
  const double mu = RealValue(LameFromValues(parameter).mu);
  double       q, trace;

  (void)table, (void)state;
  if (!F) return mu;
  trace = Trace(F, &q);
  return mu * exp(parameter[STIFFENING] * q) * trace / 3.;
}

MPM_LAW_DEFINE(fung, parameters, states, MpmMaterialEvaluate_fung, .summary = "rubber that stiffens exponentially",
               .traits = MPM_LAW_SYMMETRIC, .stiffness = Stiffness, .shear_modulus = ShearModulus)

/*
  Fung: a rubber that stiffens exponentially, with the largest stretch that a point has seen for its history

    W = mu/(2 k) (exp(k (I - 3)) - 1) - mu ln J + (lambda/2) (ln J)^2 ,     I = tr b ,     b = F F^T

    tau = mu (exp(k (I - 3)) b - 1) + lambda ln J 1

  Source: Fung (1967), doi:10.1152/ajplegacy.1967.213.6.1532, made compressible.
*/
#include "talus/point/elasticity.h"

static const MpmParameter parameters[] = {
  ELASTIC_PARAMETERS,
  {MPM_NUMBER, "stiffening", "-", 0.5, 0, 0., 100., 0, "exponent k of the stiffening", NULL, 0., NULL}};

static const MpmStateVariable states[] = {{"largest_stretch", MPM_STATE_SCALAR, 3., "-"}};

MPM_FN int MpmMaterialEvaluate_fung(const MpmLawPoint *point, const Tensor *dF, Sym *tau)
{
  const Real   k    = point->parameter[sizeof(parameters) / sizeof(parameters[0]) - 1];
  const Lame   lame = LameFromParameters(point->parameter);
  const Tensor F    = TensorMulArray(dF, point->F_n);
  const Sym    b    = SymLeftCauchyGreen(&F);
  const Scalar J = TensorDet(&F), I = SymTrace(&b);
  Scalar       growth;
  Sym          stretched;

  if (!ElasticIsRegular(point, dF)) return 1;
  growth    = ScalarScale(lame.mu, ScalarExp(ScalarScale(k, ScalarShift(I, -3.))));
  stretched = SymScale(growth, &b);
  *tau      = SymShift(&stretched, ScalarShift(ScalarScale(lame.lambda, ScalarLog(J)), -lame.mu));
  if (point->state) {
    const Real before = point->state_n[0], now = ScalarReal(I);

    point->state[0] = RealValue(now) > RealValue(before) ? now : before;
  }
  return 0;
}

MPM_LAW(fung, MPM_LAW_SYMMETRIC, "rubber that stiffens exponentially", parameters, states, NULL, ElasticStiffness,
        MpmMaterialEvaluate_fung)

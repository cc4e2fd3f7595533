/*
  Compressible neo-Hookean elasticity

    psi = (lambda/2) (ln J)^2 - mu ln J + (mu/2) (I1 - 3),   tau = mu (b - I) + lambda ln(J) I

  tau  Kirchhoff stress J sigma, tension positive, Pa
  b    F F^T, J = det F, I1 = tr b; in plane strain b_zz = 1

  Derives from the potential psi (per initial volume). For rubber-like solids; grows without bound both in tension and
  in compression.

  Source: Simo and Pister (1984), doi:10.1016/0045-7825(84)90062-8; Bonet and Wood (2008),
  doi:10.1017/CBO9780511755446, section 6.4.3.
*/
#include "talus/point/elasticity.h"

static const MpmParameter parameters[] = {ELASTIC_PARAMETERS};

static const MpmStateVariable states[] = MPM_NO_STATE;

MPM_FN int MpmMaterialEvaluate_neo_hookean(const MpmLawPoint *point, const Tensor *dF, Sym *tau)
{
  const Lame   lame     = LameFromParameters(point->parameter);
  const Tensor F        = TensorMulArray(dF, point->F_n);
  const Sym    b        = SymLeftCauchyGreen(&F);
  const Sym    strain   = SymShift(&b, ScalarConstant(-1.));
  const Sym    isotonic = SymScaleBy(lame.mu, &strain);

  if (!ElasticIsRegular(point, dF)) return 1;
  *tau = SymShift(&isotonic, ScalarScale(lame.lambda, ScalarLog(TensorDet(&F))));
  return 0;
}

/* d tau/d ln(stretch) along a principal axis is lambda + 2 mu b; the largest sum of |b| over a row bounds b. */
static double MpmMaterialStiffness_neo_hookean(const double *parameter, const MpmLawTable *table, const double *state,
                                               const double *F)
{
  const Lame lame    = LameFromValues(parameter);
  double     largest = 1.;

  (void)table, (void)state;
  for (int i = 0; F && i < MPM_DIM; i++) {
    double sum = 0.;

    for (int j = 0; j < MPM_DIM; j++) {
      double b = 0.;

      for (int k = 0; k < MPM_DIM; k++) b += F[i * MPM_DIM + k] * F[j * MPM_DIM + k];
      sum += fabs(b);
    }
    largest = fmax(largest, sum);
  }
  return RealValue(lame.lambda + 2. * largest * lame.mu);
}

MPM_LAW(neo_hookean, MPM_LAW_SYMMETRIC, "compressible neo-Hookean elasticity", parameters, states, NULL,
        MpmMaterialStiffness_neo_hookean, MpmMaterialEvaluate_neo_hookean)

/*
  Compressible neo-Hookean elasticity

    psi = (mu/2) (I1 - 3 - 2 ln J) + lambda U,   tau = mu (b - I) + lambda J U' I

  and, with `shear: isochoric`, where only the change of shape gives shear stress and k = lambda + (2/3) mu

    psi = (mu/2) (J^{-2/3} I1 - 3) + k U,        tau = mu J^{-2/3} dev b + k J U' I

  `volumetric` selects U:

    log        U = (ln J)^2/2,             J U' = ln J
    quadratic  U = (J^2 - 1 - 2 ln J)/4,   J U' = (J^2 - 1)/2

  tau  Kirchhoff stress J sigma, tension positive, Pa
  b    F F^T, J = det F, I1 = tr b; in plane strain b_zz = 1

  Derives from the potential psi (per initial volume). For rubber-like solids; grows without bound both in tension and
  in compression, but for the pressure of `quadratic`, which is at most lambda/2 (k/2) as J goes to 0. The pressure of
  `log`, J sigma, is not convex in J beyond e.

  Source: Simo and Pister (1984), doi:10.1016/0045-7825(84)90062-8; Bonet and Wood (2008), doi:10.1017/CBO9780511755446,
  section 6.4.3; Simo and Taylor (1991), doi:10.1016/0045-7825(91)90100-K, for `quadratic`; Flory (1961),
  doi:10.1039/tf9615700829, for `isochoric`.
*/
#include "talus/point/elasticity.h"

enum { VOLUMETRIC = ELASTIC_COUNT, SHEAR };

static const MpmParameter parameters[] = {
  ELASTIC_PARAMETERS,
  {MPM_WORD, "volumetric", "", 0., 0, 0., 1., 0, "stress by volume: ln J or (J^2 - 1)/2", "log|quadratic", 0., NULL},
  {MPM_WORD, "shear", "", 0., 0, 0., 1., 0, "stress by shear: of b or of J^(-2/3) b", "full|isochoric", 0., NULL}};

static const MpmStateVariable states[] = MPM_NO_STATE;

/* J U' */
MPM_FN Scalar Volume(const MpmLawPoint *point, const Tensor *F)
{
  const Scalar J = TensorDet(F);

  if (RealValue(point->parameter[VOLUMETRIC]) > 0.5) return ScalarScale(0.5, ScalarShift(ScalarSquare(J), -1.));
  return ScalarLog(J);
}

/* mu J^{-2/3} dev b + k J U' I */
MPM_FN Sym IsochoricStress(const MpmLawPoint *point, Lame lame, const Tensor *F, const Sym *strain)
{
  const Sym  dev   = SymDev(strain);
  const Sym  shear = SymScale(ScalarScale(lame.mu, ScalarPow(TensorDet(F), -2. / 3.)), &dev);
  const Real bulk  = lame.lambda + 2. / 3. * lame.mu;

  return SymShift(&shear, ScalarScale(bulk, Volume(point, F)));
}

MPM_FN int MpmMaterialEvaluate_neo_hookean(const MpmLawPoint *point, const Tensor *dF, Sym *tau)
{
  const Lame   lame     = LameFromParameters(point->parameter);
  const Tensor F        = TensorMulArray(dF, point->F_n);
  const Sym    b        = SymLeftCauchyGreen(&F);
  const Sym    strain   = SymShift(&b, ScalarConstant(-1.));
  const Sym    isotonic = SymScaleBy(lame.mu, &strain);

  if (!ElasticIsRegular(point, dF)) return 1;
  if (RealValue(point->parameter[SHEAR]) > 0.5) *tau = IsochoricStress(point, lame, &F, &strain);
  else *tau = SymShift(&isotonic, ScalarScale(lame.lambda, Volume(point, &F)));
  return 0;
}

/*
  d tau/d ln(stretch) along a principal axis is lambda (J^2 lambda) + 2 mu b, or k (J^2 k) + mu J^{-2/3} (2/3) (b +
  tr(b)/3) at most; the largest sum of |b| over a row bounds b.
*/
static double MpmMaterialStiffness_neo_hookean(const double *parameter, const MpmLawTable *table, const double *state,
                                               const double *F)
{
  const Lame   lame = LameFromValues(parameter);
  const double J = F ? MpmDeterminant(MPM_TENSOR, F) : 1., lambda = RealValue(lame.lambda), mu = RealValue(lame.mu);
  const double volume  = parameter[VOLUMETRIC] > 0.5 ? J * J : 1.;
  double       largest = 1.;

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
#if defined(MPM_HOOP)
  if (F) largest = fmax(largest, F[MPM_HOOP] * F[MPM_HOOP]);
#endif
  if (parameter[SHEAR] > 0.5) return volume * (lambda + 2. / 3. * mu) + 4. / 3. * largest * mu / pow(J, 2. / 3.);
  return volume * lambda + 2. * largest * mu;
}

/* d tau_xy/d gamma_xy is mu (b_xx + b_yy)/2, `isochoric`: mu J^{-2/3} (b_xx + b_yy)/2; mu tr(b)/3 over all planes */
MPM_FN Real MeanShear(const Real *parameter, const Real *F)
{
  const Tensor stretch = TensorFromArray(F);
  Real         mean    = MPM_NORMALS == 2 ? 1. / 3. : 0.;

  for (int i = 0; i < MPM_TENSOR; i++) mean += F[i] * F[i] / 3.;
  if (RealValue(parameter[SHEAR]) > 0.5) mean /= RealPow(TensorDetReal(&stretch), 2. / 3.);
  return mean * LameFromParameters(parameter).mu;
}

static double MpmMaterialShearModulus_neo_hookean(const double *parameter, const MpmLawTable *table,
                                                  const double *state, const double *F)
{
  Real real[SHEAR + 1], stretch[MPM_TENSOR];

  (void)table, (void)state;
  if (!F) return RealValue(LameFromValues(parameter).mu);
  for (int k = 0; k <= SHEAR; k++) real[k] = parameter[k];
  for (int k = 0; k < MPM_TENSOR; k++) stretch[k] = F[k];
  return RealValue(MeanShear(real, stretch));
}

MPM_FN void Moduli(const Real *parameter, const Real *state, const Real *F, Real moduli[3])
{
  ElasticModuli(parameter, state, F, moduli);
  moduli[0] = MeanShear(parameter, F);
}
MPM_LAW_MODULI(neo_hookean, parameters, states, Moduli)

/* psi */
static double MpmMaterialEnergy_neo_hookean(const double *parameter, const MpmLawTable *table, const double *tau,
                                            const double *F)
{
  const Lame   lame = LameFromValues(parameter);
  const double J = MpmDeterminant(MPM_TENSOR, F), lambda = RealValue(lame.lambda), mu = RealValue(lame.mu), ln = log(J);
  const double U     = parameter[VOLUMETRIC] > 0.5 ? 0.25 * (J * J - 1. - 2. * ln) : 0.5 * ln * ln;
  double       trace = MPM_NORMALS == 2 ? 1. : 0.; /* of b */

  (void)table, (void)tau;
  for (int i = 0; i < MPM_TENSOR; i++) trace += F[i] * F[i];
  if (parameter[SHEAR] > 0.5) return 0.5 * mu * (trace / pow(J, 2. / 3.) - 3.) + (lambda + 2. / 3. * mu) * U;
  return 0.5 * mu * (trace - 3. - 2. * ln) + lambda * U;
}

/* lambda U, or k U */
static void MpmMaterialVolumetric_neo_hookean(const double *parameter, const MpmLawTable *table, double J,
                                              double value[3])
{
  const Lame   lame      = LameFromValues(parameter);
  const double bulk      = RealValue(lame.lambda) + (parameter[SHEAR] > 0.5 ? 2. / 3. * RealValue(lame.mu) : 0.);
  const double ln        = log(J);
  const int    quadratic = parameter[VOLUMETRIC] > 0.5;

  (void)table;
  value[0] = bulk * (quadratic ? 0.25 * (J * J - 1. - 2. * ln) : 0.5 * ln * ln);
  value[1] = bulk * (quadratic ? 0.5 * (J * J - 1.) : ln);
  value[2] = bulk * (quadratic ? J : 1. / J);
}

MPM_LAW_DEFINE(neo_hookean, parameters, states, MpmMaterialEvaluate_neo_hookean,
               .summary = "compressible neo-Hookean elasticity", .traits = MPM_LAW_SYMMETRIC,
               .stiffness = MpmMaterialStiffness_neo_hookean, .shear_modulus = MpmMaterialShearModulus_neo_hookean,
               .energy = MpmMaterialEnergy_neo_hookean, .volumetric = MpmMaterialVolumetric_neo_hookean,
               MPM_MODULI(neo_hookean))

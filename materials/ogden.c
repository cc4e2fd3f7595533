/*
  Ogden: compressible elasticity of rubber in powers of the principal stretches

    psi   = sum_i (mu_i/alpha_i) (lb_1^alpha_i + lb_2^alpha_i + lb_3^alpha_i - 3) + (k/4) (J^2 - 1 - 2 ln J)
    tau_a = sum_i mu_i (lb_a^alpha_i - (lb_1^alpha_i + lb_2^alpha_i + lb_3^alpha_i)/3) + (k/2) (J^2 - 1)

  tau  Kirchhoff stress J sigma, tension positive, Pa; tau_a its principal values, along those of b = F F^T
  lb   isochoric principal stretches J^{-1/3} lambda_a, J = det F; in plane strain lambda_z = 1
  k    bulk modulus, Pa: given, or from Poisson's ratio and the shear modulus mu, k = 2 mu (1 + nu)/(3 (1 - 2 nu)),
       2 mu = sum_i mu_i alpha_i

  Derives from the potential psi (per initial volume). One term with alpha = 2 is the neo-Hookean solid with isochoric
  shear and quadratic volume, terms with 2 and -2 are Mooney's and Rivlin's. mu_i alpha_i > 0 for every term makes the
  law stable at any stretch; only their sum has to be positive here.

  Source: Ogden (1972), doi:10.1098/rspa.1972.0026; Simo and Taylor (1991), doi:10.1016/0045-7825(91)90100-K, for the
  split; Holzapfel (2000), Nonlinear Solid Mechanics, Wiley, section 6.5.
*/
#include "talus/point/elasticity.h"

enum { DENSITY, TERMS, BULK_MODULUS, NU };

#define NU_LEFT_OUT 0.5

static const MpmParameter parameters[] = {
  {MPM_NUMBER, "density", "kg/m3", 0., 0, 0., HUGE_VAL, 0, "mass per initial volume", NULL, 1000., NULL},
  {MPM_TABLE, "terms", "-:Pa", 0., 1, -HUGE_VAL, HUGE_VAL, 0, "alpha:mu of each term, alpha growing", NULL, 0.4e6,
   NULL},
  {MPM_NUMBER, "bulk_modulus", "Pa", HUGE_VAL, 0, 0., HUGE_VAL, 1, "bulk modulus; without it, from nu", NULL, 20e6,
   NULL},
  {MPM_NUMBER, "nu", "-", NU_LEFT_OUT, 0, -1., 0.5, 0,
   "Poisson's ratio at small strain, instead of bulk_modulus; 0.5: none", NULL, 0.48, NULL}};

static const MpmStateVariable states[] = MPM_NO_STATE;

/* mu of small strain */
MPM_FN Real ShearModulus(const MpmLawPoint *point)
{
  Real sum = 0.;

  for (long i = 0; i < TableCount(point, TERMS); i++)
    sum += 0.5 * TableEntry(point, TERMS, 2 * i) * TableEntry(point, TERMS, 2 * i + 1);
  return sum;
}

MPM_FN Real BulkModulus(Real given, Real nu, Real mu)
{
  return RealValue(given) <= DBL_MAX ? given : 2. * mu * (1. + nu) / (3. * (1. - 2. * nu));
}

MPM_FN int MpmMaterialEvaluate_ogden(const MpmLawPoint *point, const Tensor *dF, Sym *tau)
{
  const Real   bulk = BulkModulus(point->parameter[BULK_MODULUS], point->parameter[NU], ShearModulus(point));
  const Tensor F    = TensorMulArray(dF, point->F_n);
  const Sym    b    = SymLeftCauchyGreen(&F);
  SymPrincipal principal;
  Dual         dev[3], y[3], mean; /* 2 ln lb */
  Scalar       J, volume;

  if (!ElasticIsRegular(point, dF) || SymPrincipalCreate(&b, &principal) || !(principal.value[2] > 0.)) return 1;
  for (int a = 0; a < 3; a++) dev[a] = DualLog(DualSeed(principal.value[a], a));
  mean = DualScale(1. / 3., DualAdd(DualAdd(dev[0], dev[1]), dev[2]));
  for (int a = 0; a < 3; a++) {
    dev[a] = DualSub(dev[a], mean);
    y[a]   = DualConstant(0.);
  }
  for (long i = 0; i < TableCount(point, TERMS); i++) {
    const Real half = 0.5 * TableEntry(point, TERMS, 2 * i), mu = TableEntry(point, TERMS, 2 * i + 1);

    for (int a = 0; a < 3; a++) y[a] = DualAdd(y[a], DualScale(mu, DualExpm1(DualScale(half, dev[a]))));
  }
  mean = DualScale(1. / 3., DualAdd(DualAdd(y[0], y[1]), y[2]));
  for (int a = 0; a < 3; a++) y[a] = DualSub(y[a], mean);
  *tau   = SymIsotropic(&b, &principal, y);
  J      = TensorDetByCofactors(&F);
  volume = ScalarScale(0.5 * bulk, ScalarShift(ScalarSquare(J), -1.));
  for (int i = 0; i < 3; i++) tau->a[i] = ScalarAdd(tau->a[i], volume);
  return 0;
}

/* Squares of the principal stretches of F, largest first */
static void SquaredStretches(const double *F, double w[3])
{
  Real values[MPM_TENSOR];
  Sym  b;

  for (int i = 0; i < MPM_TENSOR; i++) values[i] = F[i];
  {
    const Tensor tensor = TensorFromArray(values);

    b = SymLeftCauchyGreen(&tensor);
  }
  SymPrincipalValues(&b, w);
}

/*
  d tau_a/d ln lambda_a = k J^2 + sum_i mu_i alpha_i ((4/9) lb_a^alpha_i + (1/9) (lb_b^alpha_i + lb_c^alpha_i)), bounded
  by the largest of the three powers, or the least where mu_i alpha_i < 0.
*/
static double MpmMaterialStiffness_ogden(const double *parameter, const MpmLawTable *table, const double *state,
                                         const double *F)
{
  const MpmLawPoint point = {.table = table};
  const double      mu = RealValue(ShearModulus(&point)), *row = table[TERMS].value;
  const double      bulk      = RealValue(BulkModulus(parameter[BULK_MODULUS], parameter[NU], mu));
  const double      J         = F ? MpmDeterminant(MPM_TENSOR, F) : 1.;
  double            stiffness = bulk * J * J, w[3] = {1., 1., 1.};

  (void)state;
  if (F) SquaredStretches(F, w);
  for (long i = 0; i < table[TERMS].count; i++, row += 2) {
    const double large = pow(w[0] / pow(J, 2. / 3.), 0.5 * row[0]), small = pow(w[2] / pow(J, 2. / 3.), 0.5 * row[0]);
    const double product = row[0] * row[1];

    stiffness += 2. / 3. * product * (product > 0. ? fmax(large, small) : fmin(large, small));
  }
  return stiffness;
}

/* Least shear modulus, over that at rest: terms with mu_i alpha_i < 0 have none at large stretch. */
#define LEAST_SHEAR 0.01

/* sum_i (mu_i alpha_i/2) lb_a^alpha_i, the mean over the axes a */
static double MpmMaterialShearModulus_ogden(const double *parameter, const MpmLawTable *table, const double *state,
                                            const double *F)
{
  const double *row  = table[TERMS].value;
  double        w[3] = {1., 1., 1.}, rest = 0., modulus = 0.;

  (void)parameter, (void)state;
  if (F) SquaredStretches(F, w);
  for (long i = 0; i < table[TERMS].count; i++, row += 2) {
    rest += 0.5 * row[0] * row[1];
    for (int a = 0; a < 3; a++) modulus += row[0] * row[1] / 6. * pow(w[a] / cbrt(w[0] * w[1] * w[2]), 0.5 * row[0]);
  }
  return fmax(modulus, LEAST_SHEAR * rest);
}

static int MpmMaterialCheck_ogden(const double *parameter, const MpmLawTable *table, MpmLawFault *fault)
{
  const MpmLawPoint point = {.table = table};
  const int         given = parameter[BULK_MODULUS] <= DBL_MAX;
  const double      nu    = parameter[NU];

  fault->parameter = -1;
  fault->why       = "terms: no alpha may be 0";
  for (long i = 0; i < table[TERMS].count; i++)
    if (table[TERMS].value[2 * i] == 0.) return 0;
  fault->why = "terms: the sum of alpha mu, twice the shear modulus, must be positive";
  if (!(RealValue(ShearModulus(&point)) > 0.)) return 0;
  fault->parameter = NU;
  fault->lower     = given ? NU_LEFT_OUT : -1.;
  fault->upper     = NU_LEFT_OUT;
  fault->open      = !given;
  fault->why       = given ? "bulk_modulus is given" : "bulk_modulus is not given";
  return given ? nu == NU_LEFT_OUT : nu > -1. && nu < NU_LEFT_OUT;
}

/* psi */
static double MpmMaterialEnergy_ogden(const double *parameter, const MpmLawTable *table, const double *tau,
                                      const double *F)
{
  const MpmLawPoint point = {.table = table};
  const double      bulk  = RealValue(BulkModulus(parameter[BULK_MODULUS], parameter[NU], ShearModulus(&point)));
  const double      J = MpmDeterminant(MPM_TENSOR, F), *row = table[TERMS].value;
  double            energy = 0.25 * bulk * (J * J - 1. - 2. * log(J)), w[3];

  (void)tau;
  SquaredStretches(F, w);
  for (long i = 0; i < table[TERMS].count; i++, row += 2)
    for (int a = 0; a < 3; a++) energy += row[1] / row[0] * expm1(0.5 * row[0] * (log(w[a]) - 2. / 3. * log(J)));
  return energy;
}

/* (k/4) (J^2 - 1 - 2 ln J) */
static void MpmMaterialVolumetric_ogden(const double *parameter, const MpmLawTable *table, double J, double value[3])
{
  const MpmLawPoint point = {.table = table};
  const double      bulk  = RealValue(BulkModulus(parameter[BULK_MODULUS], parameter[NU], ShearModulus(&point)));

  value[0] = 0.25 * bulk * (J * J - 1. - 2. * log(J));
  value[1] = 0.5 * bulk * (J * J - 1.);
  value[2] = bulk * J;
}

MPM_LAW_DEFINE(ogden, parameters, states, MpmMaterialEvaluate_ogden,
               .summary = "compressible elasticity in powers of the principal stretches", .traits = MPM_LAW_SYMMETRIC,
               .check = MpmMaterialCheck_ogden, .stiffness = MpmMaterialStiffness_ogden,
               .shear_modulus = MpmMaterialShearModulus_ogden, .energy = MpmMaterialEnergy_ogden,
               .volumetric = MpmMaterialVolumetric_ogden)

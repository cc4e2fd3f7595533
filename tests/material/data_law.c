/*
  A law made for the tests: elasticity with coefficients from a file.

    e = (1/2) ln (F F^T),   tau = (sum_i c_i tr(e)^(i+1)) I + 2 G dev e
*/
#include "talus/point/elasticity.h"

enum { DENSITY, G, COEFFICIENTS };

static const MpmParameter parameters[] = {
  {MPM_NUMBER, "density", "kg/m3", 0., 0, 0., HUGE_VAL, 0, "mass per initial volume", NULL, 0., NULL},
  {MPM_NUMBER, "G", "Pa", 0., 1, 0., HUGE_VAL, 1, "shear modulus", NULL, 0., NULL},
  {MPM_DATA, "coefficients", "Pa", 0., 1, 0., HUGE_VAL, 0, "of the pressure in powers of the volumetric strain", NULL,
   0., NULL}};

static const MpmStateVariable states[] = MPM_NO_STATE;

static int MpmMaterialEvaluate_data_law(const MpmLawPoint *point, const Tensor *dF, Sym *tau)
{
  const Tensor F = TensorMulArray(dF, point->F_n);
  const Sym    b = SymLeftCauchyGreen(&F);
  Scalar       p = ScalarConstant(0.), theta;
  Sym          e, dev;

  if (!ElasticIsRegular(point, dF) || ElasticLogStrain(&b, &e)) return 1;
  dev   = SymDev(&e);
  theta = SymTrace(&e);
  for (long i = TableCount(point, COEFFICIENTS) - 1; i >= 0; i--)
    p = ScalarMul(theta, ScalarShift(p, TableEntry(point, COEFFICIENTS, i)));
  *tau = SymScaleBy(2. * point->parameter[G], &dev);
  *tau = SymShift(tau, p);
  return 0;
}

/* 4 G/3 + dp/d(tr e) */
static double Stiffness(const double *parameter, const MpmLawTable *table, const double *state, const double *F)
{
  const double theta = F ? log(MpmDeterminant(MPM_TENSOR, F)) : 0.;
  double       slope = 0.;

  (void)state;
  for (long i = table[COEFFICIENTS].count - 1; i >= 0; i--)
    slope = theta * slope + (double)(i + 1) * table[COEFFICIENTS].value[i];
  return 4. / 3. * parameter[G] + slope;
}

static double ShearModulus(const double *parameter, const MpmLawTable *table, const double *state, const double *F)
{
  (void)table, (void)state, (void)F;
  return parameter[G];
}

MPM_LAW_DEFINE(data_law, parameters, states, MpmMaterialEvaluate_data_law,
               .summary = "elasticity with coefficients from a file", .traits = MPM_LAW_SYMMETRIC,
               .stiffness = Stiffness, .shear_modulus = ShearModulus)

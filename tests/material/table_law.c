/*
  A law made for the tests: elasticity and yield by tables.

    b_trial = dF b_n dF^T,   e = (1/2) ln b,   tau = p(tr e) I + 2 G dev e
    |dev tau| <= sqrt(2/3) Y(alpha_n),   alpha grows by sqrt(2/3) |dev e| lost

  p    pressure, tension positive, over the volumetric logarithmic strain: a table that depends on the increment
  Y    yield stress over the equivalent plastic strain at the step's start: a table that depends on history
*/
#include "talus/point/elasticity.h"

enum { DENSITY, G, PRESSURE, YIELD };

static const MpmParameter parameters[] = {
  {MPM_NUMBER, "density", "kg/m3", 0., 0, 0., HUGE_VAL, 0, "mass per initial volume", NULL, 0., NULL},
  {MPM_NUMBER, "G", "Pa", 0., 1, 0., HUGE_VAL, 1, "shear modulus", NULL, 0., NULL},
  {MPM_TABLE, "pressure", "-:Pa", 0., 1, -HUGE_VAL, HUGE_VAL, 0, "mean stress over the logarithm of J", NULL, 0., NULL},
  {MPM_TABLE, "yield", "-:Pa", 0., 1, 0., HUGE_VAL, 1, "yield stress over the equivalent plastic strain", NULL, 0.,
   NULL}};

enum { STATE_B = 0, STATE_ALPHA = MPM_SYM };

static const MpmStateVariable states[] = {{"elastic_left_cauchy_green", MPM_STATE_SYM, 1., "-"},
                                          {"equivalent_plastic_strain", MPM_STATE_SCALAR, 0., "-"}};

static int MpmMaterialEvaluate_table_law(const MpmLawPoint *point, const Tensor *dF, Sym *tau)
{
  const Real shear = point->parameter[G], alpha_n = point->state_n[STATE_ALPHA];
  const Real radius = sqrt(2. / 3.) * TableReal(point, YIELD, alpha_n) / (2. * shear);
  Sym        b      = SymPush(dF, &point->state_n[STATE_B]);
  Real       alpha  = alpha_n;
  Sym        e, dev;

  if (!ElasticIsRegular(point, dF) || ElasticLogStrain(&b, &e)) return 1;
  dev = SymDev(&e);
  if (SymNormValue(&dev) > RealValue(radius) + ELASTIC_STRAIN_NOISE) {
    const Scalar norm = SymNorm(&dev), lost = ScalarShift(norm, -radius);

    e = SymAxpy(ScalarNeg(ScalarDiv(lost, norm)), &dev, &e);
    alpha += sqrt(2. / 3.) * ScalarReal(lost);
    if (point->state && ElasticLeftCauchyGreen(&e, &b)) return 1;
    dev = SymDev(&e);
  }
  *tau = SymScaleBy(2. * shear, &dev);
  *tau = SymShift(tau, TableScalar(point, PRESSURE, SymTrace(&e)));
  if (point->state) {
    SymStore(&point->state[STATE_B], &b);
    point->state[STATE_ALPHA] = alpha;
  }
  return 0;
}

/* By the steepest part of the table, wherever the state is. */
static double Stiffness(const double *parameter, const MpmLawTable *table, const double *state, const double *F)
{
  const double *value   = table[PRESSURE].value;
  double        largest = 0.;

  (void)state, (void)F;
  for (long i = 1; i < table[PRESSURE].count; i++)
    largest = fmax(largest, (value[2 * i + 1] - value[2 * i - 1]) / (value[2 * i] - value[2 * i - 2]));
  return 4. / 3. * parameter[G] + largest;
}

static double ShearModulus(const double *parameter, const MpmLawTable *table, const double *state, const double *F)
{
  (void)table, (void)state, (void)F;
  return parameter[G];
}

MPM_LAW_DEFINE(table_law, parameters, states, MpmMaterialEvaluate_table_law,
               .summary = "elasticity and yield by tables", .traits = MPM_LAW_SYMMETRIC | MPM_LAW_PLASTIC,
               .stiffness = Stiffness, .shear_modulus = ShearModulus)

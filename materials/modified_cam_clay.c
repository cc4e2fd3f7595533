/*
  Modified Cam-Clay: elasticity that stiffens with the pressure, an ellipse through the origin that grows and shrinks
  with plastic volume, critical state

    b_trial = dF b_n dF^T,   e = (1/2) ln b,   tau = -p I + 2 G dev e
    p = p_ref exp(-tr(e)/kappa) where p >= p_min; below that linear in tr(e), with the value and slope it has there
    f = q^2/M^2 + p (p - p_c) <= 0,   q = sqrt(3/2) |dev tau|,   associated flow
    p_c = p_c,n exp(v/(lambda - kappa)),   v the step's plastic volume strain, positive in compression

  tau  Kirchhoff stress J sigma, tension positive, Pa; f bounds the Kirchhoff stress, not the Cauchy stress
  p    pressure -tr(tau)/3, positive in compression; p_ref, p_min, p_c as well
  b    elastic left Cauchy-Green tensor (history)
  p_c  preconsolidation: the largest pressure on the yield surface (history); 0: not set yet
  v    specific volume, 1 + void ratio (history), which goes with det F and on which nothing depends; 0: not set yet
  alpha  equivalent plastic strain (history): grows by sqrt(2/3) |dev e_p|, on which nothing depends

  kappa and lambda are slopes of ln v over ln p, so that they are slopes of the logarithmic volume strain, too.

  Backward Euler, with g the plastic multiplier and y = 6 G g/M^2:

    v = g (2 p - p_c),   q = q_trial/(1 + y),   f = 0,   p = p(tr(e_trial) + v)

  for v and y. On paths of constant volume this makes no error in p(q). Flow at p = p_c/2 keeps the volume: critical
  state, q = M p. On the dry side of it, p < p_c/2, p_c falls, and where it falls faster than elastic unloading, 12 G
  (p_c - p)/M^2 < (p_c - 2 p) p_c/(lambda - kappa), the stress of a step is no longer a smooth function of it.

  The flow is associated, but its direction at the step's end changes with p_c, which the step's flow has changed: the
  tangent is symmetric only up to terms of the order of the step.

  History from a stress: the elastic strain that has it and, unless the scene has one, p_c = ocr p_y or p_y + pop, where
  p_y = p + q^2/(M^2 p) is that of the ellipse through the stress. At rest without a stress a point is under p_ref.

  Source: Roscoe and Burland (1968), On the generalized stress-strain behaviour of wet clay, in: Engineering Plasticity,
  Cambridge, 535-609; Borja and Tamagnini (1998), doi:10.1016/S0045-7825(97)00141-2, and Callari, Auricchio and Sacco
  (1998), doi:10.1016/S0749-6419(98)00050-3, at finite strain.
*/
#include "talus/point/elasticity.h"
#include "talus/point/implicit.h"

enum {
  DENSITY,
  KAPPA,
  LAMBDA,
  CRITICAL,
  SHEAR,
  REFERENCE_PRESSURE,
  PRESSURE_MIN,
  OCR,
  POP,
  PRECONSOLIDATION,
  SPECIFIC_VOLUME
};

static const MpmParameter parameters[] = {
  {MPM_NUMBER, "density", "kg/m3", 0., 0, 0., HUGE_VAL, 0, "mass per initial volume", NULL, 1800., NULL},
  {MPM_NUMBER, "kappa", "-", 0., 1, 0., HUGE_VAL, 1, "slope of ln v over ln p in unloading, v specific volume", NULL,
   0.02, NULL},
  {MPM_NUMBER, "lambda", "-", 0., 1, 0., HUGE_VAL, 1, "slope of ln v over ln p in virgin compression, above kappa",
   NULL, 0.1, NULL},
  {MPM_STRENGTH, "M", "-", 0., 1, 0., HUGE_VAL, 1, "q/p at critical state", NULL, 1.2, NULL},
  {MPM_NUMBER, "G", "Pa", 0., 1, 0., HUGE_VAL, 1, "shear modulus", NULL, 4e6, NULL},
  {MPM_NUMBER, "reference_pressure", "Pa", 100e3, 0, 0., HUGE_VAL, 1,
   "pressure at which the elastic volume strain is 0", NULL, 100e3, NULL},
  {MPM_NUMBER, "pressure_min", "Pa", 1e3, 0, 0., HUGE_VAL, 1,
   "pressure below which elasticity is linear in the volume strain, at most reference_pressure", NULL, 1e3, NULL},
  {MPM_NUMBER, "ocr", "-", HUGE_VAL, 0, 1., HUGE_VAL, 0,
   "preconsolidation over that with which the initial stress would yield; without it, pop and preconsolidation, 1",
   NULL, 2., NULL},
  {MPM_NUMBER, "pop", "Pa", HUGE_VAL, 0, 0., HUGE_VAL, 0,
   "preconsolidation less that with which the initial stress would yield; instead of ocr", NULL, 100e3, NULL},
  {MPM_NUMBER, "preconsolidation", "Pa", HUGE_VAL, 0, 0., HUGE_VAL, 1,
   "initial size of the yield surface: its largest pressure; instead of ocr", NULL, 200e3, NULL},
  {MPM_NUMBER, "specific_volume", "-", 2., 0, 1., HUGE_VAL, 1, "initial v, 1 + void ratio; nothing depends on it", NULL,
   2., NULL}};

enum { STATE_B = 0, STATE_SIZE = MPM_SYM, STATE_VOLUME, STATE_ALPHA };

/* How many parameters say what the preconsolidation is */
static int SizeCount(const double *parameter)
{
  int count = 0;

  for (int k = OCR; k <= PRECONSOLIDATION; ++k) count += parameter[k] <= DBL_MAX;
  return count;
}

static const MpmStateVariable states[] = {{"elastic_left_cauchy_green", MPM_STATE_SYM, 1., "-"},
                                          {"preconsolidation", MPM_STATE_SCALAR, 0., "Pa"},
                                          {"specific_volume", MPM_STATE_SCALAR, 0., "-"},
                                          {"equivalent_plastic_strain", MPM_STATE_SCALAR, 0., "-"}};

/* ---- elasticity ---- */

/* The elastic volume strain, positive in tension, at pressure_min */
MPM_FN Real StrainAtMinimum(const Real *parameter)
{
  return parameter[KAPPA] * RealLog(parameter[REFERENCE_PRESSURE] / parameter[PRESSURE_MIN]);
}

MPM_FN Dual Pressure(const Real *parameter, Dual strain)
{
  const Real flexibility = -1. / parameter[KAPPA];
  const Dual p           = DualScale(parameter[REFERENCE_PRESSURE], DualExp(DualScale(flexibility, strain)));

  if (DualValue(p) >= RealValue(parameter[PRESSURE_MIN])) return p;
  strain = DualShift(strain, -StrainAtMinimum(parameter));
  return DualScale(parameter[PRESSURE_MIN], DualShift(DualScale(flexibility, strain), 1.));
}

MPM_FN double PressureValue(const Real *parameter, double strain)
{
  return DualValue(Pressure(parameter, DualConstant(strain)));
}

/* ---- return ---- */

typedef struct {
  const Real *parameter;
  Real        size;  /* p_c at the step's start */
  double      scale; /* a size of p_c at its end */
} Problem;

/* Inputs: trace of the trial strain, square of its deviator; unknowns v and y of the docstring */
MPM_FN int Residual(const void *argument, const Dual input[], const Dual x[], Dual r[])
{
  const Problem *problem   = (const Problem *)argument;
  const Real    *parameter = problem->parameter, hardening = parameter[LAMBDA] - parameter[KAPPA];
  const Real     square = parameter[CRITICAL] * parameter[CRITICAL], shear = 6. * parameter[SHEAR];
  const Dual     p      = Pressure(parameter, DualAdd(input[0], x[0]));
  const Dual     size   = DualScale(problem->size, DualExp(DualScale(1. / hardening, x[0])));
  const Dual     normal = DualSub(DualScale(2., p), size);
  const Dual     part   = DualDiv(DualConstant(1.), DualShift(x[1], 1.)); /* q/q_trial */
  const Dual     shape  = DualScale(parameter[SHEAR] * shear / square, DualMul(input[1], DualSquare(part)));

  if (!(DualValue(x[1]) > -1.)) return 1; /* only q^2 counts: do not look for -q */
  r[0] = DualScale(1. / hardening, DualSub(x[0], DualScale(square / shear, DualMul(x[1], normal))));
  r[1] = DualScale(1. / (problem->scale * problem->scale), DualAdd(shape, DualMul(p, DualSub(p, size))));
  return 0;
}

/* A trial state in plain numbers, and its consequences at a trial v */
typedef struct {
  double M2, shear, kappa, hardening; /* M^2, 6 G, slopes of elastic and of plastic volume strain */
  double strain, q2, size;            /* trial volume strain, q_trial^2, p_c at the step's start */
} Trial;

typedef struct {
  double size, normal, inside; /* p_c, 2 p - p_c, p (p_c - p) */
  double R, slope;             /* of FindStart() and its derivative */
} Guess;

MPM_FN Guess GuessAt(const Real *parameter, const Trial *trial, double v)
{
  const double p = PressureValue(parameter, trial->strain + v);
  const double K = fmax(p, RealValue(parameter[PRESSURE_MIN])) / trial->kappa; /* -dp/dv */
  Guess        guess;
  double       H, bottom, ratio;

  guess.size   = trial->size * exp(v / trial->hardening);
  guess.normal = 2. * p - guess.size;
  guess.inside = p * (guess.size - p);
  H            = guess.size / trial->hardening;
  bottom       = trial->M2 * guess.normal + trial->shear * v;
  ratio        = trial->M2 * guess.normal / bottom;
  guess.R      = trial->M2 * guess.inside - trial->q2 * ratio * ratio;
  guess.slope  = trial->M2 * (K * guess.normal + p * H) + 2. * trial->q2 * ratio * trial->M2 * trial->shear *
                                                           ((2. * K + H) * v + guess.normal) / (bottom * bottom);
  return guess;
}

/*
  Where the solution lies, well enough for Newton's method. The one equation

    R(v) = M^2 p (p_c - p) - (q_trial M^2 D/(M^2 D + 6 G v))^2 = 0,   D = 2 p - p_c

  has its root between v = 0, where R < 0, and critical state, D = 0, where R > 0.
*/
MPM_FN void FindStart(const Real *parameter, const Trial *trial, double x[2])
{
  const double slope = 1. / trial->kappa + 1. / trial->hardening, p_min = RealValue(parameter[PRESSURE_MIN]);
  const double linear = RealValue(StrainAtMinimum(parameter)) - trial->strain; /* v from which on the law is linear */
  /* where p = p_c, by the logarithmic law; the linear one has less pressure */
  const double axis =
    (log(RealValue(parameter[REFERENCE_PRESSURE]) / trial->size) - trial->strain / trial->kappa) / slope;
  const int wet   = 2. * PressureValue(parameter, trial->strain) > trial->size;
  double    outer = 0., inner = axis + log(2.) / slope; /* R < 0 and R > 0 */
  double    at, last, before;                           /* v, and the last two steps of it */
  Guess     guess;

  if (wet && axis > 0. && axis <= linear) outer = axis;
  if (!wet && linear < 0. && 2. * p_min >= trial->size * exp(linear / trial->hardening)) inner = linear;
  at   = outer;
  last = before = 2. * fabs(inner - outer);
  for (int iteration = 0; iteration < 60; ++iteration) {
    double next;
    int    beyond; /* critical state */

    guess  = GuessAt(parameter, trial, at);
    beyond = wet ? guess.normal <= 0. : guess.normal >= 0.;
    if (guess.R > 0. || beyond) inner = at;
    else outer = at;
    next = at - guess.R / guess.slope;
    if (beyond || !(next > fmin(inner, outer) && next < fmax(inner, outer)) || fabs(next - at) > 0.5 * before)
      next = 0.5 * (inner + outer);
    if (fabs(next - at) <= 1e-3 * fmin(fabs(at), trial->kappa) || next == inner || next == outer) break;
    before = last;
    last   = fabs(next - at);
    at     = next;
  }
  x[0] = at;
  x[1] = fabs(guess.normal) > 0.5 * guess.size ? trial->shear * at / (trial->M2 * guess.normal)
                                               : sqrt(trial->q2 / (trial->M2 * guess.inside)) - 1.;
}

/* ---- the law ---- */

/* p_c at the step's start */
MPM_FN Real SizeAtStart(const Real *parameter, const Real *state_n)
{
  if (RealValue(state_n[STATE_SIZE]) > 0.) return state_n[STATE_SIZE];
  if (RealValue(parameter[PRECONSOLIDATION]) <= DBL_MAX) return parameter[PRECONSOLIDATION];
  if (RealValue(parameter[OCR]) <= DBL_MAX) return parameter[OCR] * parameter[REFERENCE_PRESSURE];
  if (RealValue(parameter[POP]) <= DBL_MAX) return parameter[REFERENCE_PRESSURE] + parameter[POP];
  return parameter[REFERENCE_PRESSURE];
}

/* Rounding error of f */
MPM_FN double Noise(const Trial *trial, double p, double p_min)
{
  const double K = fmax(p, p_min) / trial->kappa;

  return ELASTIC_STRAIN_NOISE * (K * (fabs(p) + trial->size) + trial->shear * sqrt(trial->q2) / trial->M2);
}

/* From the trial strain's trace and the square of its deviator. */
MPM_FN Trial TrialOf(const Real *parameter, double strain, double square, double size)
{
  const double shear = 6. * RealValue(parameter[SHEAR]);
  const Trial  trial = {.M2        = RealValue(parameter[CRITICAL] * parameter[CRITICAL]),
                        .shear     = shear,
                        .kappa     = RealValue(parameter[KAPPA]),
                        .hardening = RealValue(parameter[LAMBDA] - parameter[KAPPA]),
                        .strain    = strain,
                        .q2        = shear * RealValue(parameter[SHEAR]) * square,
                        .size      = size};

  return trial;
}

/* The unknowns of a step that yields; non-zero where there are none. */
MPM_FN int SolveFlow(const Real *parameter, Real size, const Trial *trial, const Dual input[], Dual x[])
{
  double start[2];

  FindStart(parameter, trial, start);
  {
    const Problem  problem  = {parameter, size, trial->size * exp(start[0] / trial->hardening)};
    const Implicit implicit = {Residual, &problem, input, 2, 2, 1.};

    return ImplicitSystem(&implicit, start, x);
  }
}

MPM_FN int MpmMaterialEvaluate_modified_cam_clay(const MpmLawPoint *point, const Tensor *dF, Sym *tau)
{
  const Real *parameter = point->parameter;
  const Real  shear     = 6. * parameter[SHEAR];
  const Real  hardening = parameter[LAMBDA] - parameter[KAPPA], size = SizeAtStart(parameter, point->state_n);
  Sym         b = SymPush(dF, &point->state_n[STATE_B]), e, dev;
  Scalar      given[2];
  Dual        input[2], x[2], p;
  Trial       trial;
  int         yields;

  if (!ElasticIsRegular(point, dF) || ElasticLogStrain(&b, &e)) return 1;
  dev      = SymDev(&e);
  given[0] = SymTrace(&e);
  given[1] = SymDot(&dev, &dev);
  for (int k = 0; k < 2; ++k) input[k] = DualSeed(ScalarValue(given[k]), k);
  x[0] = x[1] = DualConstant(0.);
  p           = Pressure(parameter, input[0]);

  trial  = TrialOf(parameter, ScalarValue(given[0]), ScalarValue(given[1]), RealValue(size));
  yields = trial.q2 / trial.M2 + DualValue(p) * (DualValue(p) - trial.size) >
           Noise(&trial, DualValue(p), RealValue(parameter[PRESSURE_MIN]));
  dev = SymScaleBy(shear / 3., &dev);
  if (yields) {
    Dual part;

    if (SolveFlow(parameter, size, &trial, input, x)) return 1;
    p    = Pressure(parameter, DualAdd(input[0], x[0]));
    part = DualDiv(DualConstant(1.), DualShift(x[1], 1.));
    dev  = SymScale(ScalarFromDual(part, 2, given), &dev);
  }
  *tau = SymShift(&dev, ScalarNeg(ScalarFromDual(p, 2, given)));
  if (point->state) {
    const Scalar v   = ScalarFromDual(x[0], 2, given);
    const Real   v_n = point->state_n[STATE_VOLUME];
    const Sym    at  = e;

    point->state[STATE_ALPHA] = point->state_n[STATE_ALPHA];
    if (yields) {
      e = SymScaleBy(3. / shear, &dev);
      e = SymShift(&e, ScalarScale(1. / 3., ScalarAdd(given[0], v)));
      if (ElasticLeftCauchyGreen(&e, &b)) return 1;
      point->state[STATE_ALPHA] += ElasticPlasticGrowth(&at, &e);
    }
    SymStore(&point->state[STATE_B], &b);
    point->state[STATE_SIZE]   = size * ScalarReal(ScalarExp(ScalarScale(1. / hardening, v)));
    point->state[STATE_VOLUME] = (RealValue(v_n) > 0. ? v_n : parameter[SPECIFIC_VOLUME]) * ScalarReal(TensorDet(dF));
  }
  return 0;
}

/* Bulk modulus and 4 G/3 */
static double MpmMaterialStiffness_modified_cam_clay(const double *parameter, const MpmLawTable *table,
                                                     const double *state, const double *F)
{
  double strain = 0., p;
  Real   real[SPECIFIC_VOLUME + 1];

  (void)table, (void)F;
  for (int k = 0; k <= SPECIFIC_VOLUME; ++k) real[k] = parameter[k];
  if (state) {
    double det = state[2] * (state[0] * state[1] - state[3] * state[3]);

#if MPM_DIM == 3
    det += 2. * state[3] * state[4] * state[5] - state[0] * state[4] * state[4] - state[1] * state[5] * state[5];
#endif
    strain = 0.5 * log(det);
  }
  p = PressureValue(real, strain);
  return fmax(p, parameter[PRESSURE_MIN]) / parameter[KAPPA] + 4. / 3. * parameter[SHEAR];
}

static int MpmMaterialCheck_modified_cam_clay(const double *parameter, const MpmLawTable *table, MpmLawFault *fault)
{
  const MpmLawFault above  = {KAPPA, 0., parameter[LAMBDA], 1, "kappa must be less than lambda"};
  const MpmLawFault linear = {PRESSURE_MIN, 0., parameter[REFERENCE_PRESSURE], 0,
                              "pressure_min must not exceed reference_pressure"};
  const MpmLawFault both   = {OCR, -HUGE_VAL, HUGE_VAL, 0, "preconsolidation is given, too, and one makes the other"};
  const MpmLawFault excess = {POP, -HUGE_VAL, HUGE_VAL, 0,
                              "ocr or preconsolidation is given, too, and one makes the other"};

  (void)table;
  *fault = above;
  if (!(parameter[KAPPA] < parameter[LAMBDA])) return 0;
  *fault = linear;
  if (!(parameter[PRESSURE_MIN] <= parameter[REFERENCE_PRESSURE])) return 0;
  *fault = parameter[POP] <= DBL_MAX ? excess : both;
  return SizeCount(parameter) <= 1;
}

/* Without a preconsolidation there must be a pressure that it follows from. */
static int MpmMaterialHistory_modified_cam_clay(const double *parameter, const MpmLawTable *table, const double *stress,
                                                double *state)
{
  const double p = -(stress[0] + stress[1] + stress[2]) / 3., kappa = parameter[KAPPA];
  const double p_ref = parameter[REFERENCE_PRESSURE], p_min = parameter[PRESSURE_MIN];
  const double strain = p >= p_min ? -kappa * log(p / p_ref) : kappa * (log(p_ref / p_min) + 1. - p / p_min);
  double       square = 0.; /* q^2 */
  Sym          e, b;

  (void)table;
  for (int i = 0; i < MPM_SYM; ++i) {
    const double s = stress[i] + (i < 3 ? p : 0.);

    square += (i < 3 ? 1.5 : 3.) * s * s;
    e.a[i] = ScalarConstant(0.5 * s / parameter[SHEAR] + (i < 3 ? strain / 3. : 0.));
  }
  if (ElasticLeftCauchyGreen(&e, &b)) return 1;
  SymValues(&state[STATE_B], &b);
  if (!(state[STATE_SIZE] > 0.) && parameter[PRECONSOLIDATION] <= DBL_MAX)
    state[STATE_SIZE] = parameter[PRECONSOLIDATION];
  if (!(state[STATE_SIZE] > 0.)) {
    if (!(p > 0.)) return 1;
    state[STATE_SIZE] = (parameter[OCR] <= DBL_MAX ? parameter[OCR] : 1.) *
                        (p + square / (parameter[CRITICAL] * parameter[CRITICAL] * p));
    if (parameter[POP] <= DBL_MAX) state[STATE_SIZE] += parameter[POP];
  }
  if (!(state[STATE_VOLUME] > 0.)) state[STATE_VOLUME] = parameter[SPECIFIC_VOLUME];
  return 0;
}

/*
  Jaky's ratio with sin(phi) = 3 M/(6 + M), that of triaxial compression, times OCR^sin(phi). OCR is `ocr`, or the size
  p_c, given or larger by `pop`, over that of the ellipse through the stress with Jaky's ratio.
*/
static double MpmMaterialK0_modified_cam_clay(const double *parameter, const MpmLawTable *table, const double *state,
                                              double weight)
{
  const double M = parameter[CRITICAL], sine = 3. * M / (6. + M), jaky = 1. - sine;
  const double p = (1. + 2. * jaky) / 3. * weight, q = (1. - jaky) * weight;
  const double yields = p > 0. ? p + q * q / (M * M * p) : 0.;
  double       size = state ? state[STATE_SIZE] : 0., ocr = 1.;

  (void)table;
  if (!(size > 0.) && parameter[PRECONSOLIDATION] <= DBL_MAX) size = parameter[PRECONSOLIDATION];
  if (!(size > 0.) && parameter[POP] <= DBL_MAX) size = yields + parameter[POP];
  if (size > 0. && p > 0.) ocr = size / yields;
  else if (parameter[OCR] <= DBL_MAX) ocr = parameter[OCR];
  return jaky * pow(fmax(ocr, 1.), sine);
}

static double MpmMaterialShearModulus_modified_cam_clay(const double *parameter, const MpmLawTable *table,
                                                        const double *state, const double *F)
{
  (void)table, (void)state, (void)F;
  return parameter[SHEAR];
}

/* kappa p, energy of volume, 0 at no pressure of the logarithmic law, with the linear range; and that of shear */
static double MpmMaterialEnergy_modified_cam_clay(const double *parameter, const MpmLawTable *table, const double *tau,
                                                  const double *F)
{
  const double minimum = parameter[PRESSURE_MIN];
  double       p, energy = ElasticShearEnergy(tau, parameter[SHEAR], &p);

  (void)table, (void)F;
  energy += parameter[KAPPA] * p;
  if (p < minimum) energy += 0.5 * parameter[KAPPA] * minimum * (1. - p / minimum) * (1. - p / minimum);
  return energy;
}

MPM_LAW_DEFINE(modified_cam_clay, parameters, states, MpmMaterialEvaluate_modified_cam_clay,
               .summary = "Modified Cam-Clay with logarithmic elasticity", .traits = MPM_LAW_PLASTIC | MPM_LAW_VOLUME,
               .check = MpmMaterialCheck_modified_cam_clay, .stiffness = MpmMaterialStiffness_modified_cam_clay,
               .shear_modulus = MpmMaterialShearModulus_modified_cam_clay,
               .history = MpmMaterialHistory_modified_cam_clay, .k0 = MpmMaterialK0_modified_cam_clay,
               .energy = MpmMaterialEnergy_modified_cam_clay)

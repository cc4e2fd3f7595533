/*
  Nor-Sand: critical state plasticity of sand whose state is its density relative to the critical state line; Borja and
  Andrade's form, with pressure-dependent hyperelasticity

    b_trial = dF b_n dF^T,   e = (1/2) ln b,   e_v = tr e,   e_s = sqrt(2/3) |dev e|
    p = -p_ref exp(-e_v/kappa),   q = 3 G e_s,   tau = p I + 2 G dev e
    f = q + eta p <= 0,   eta = (M/N) (1 - (1 - N) (p/p_i)^(N/(1-N))),   N = 0: M (1 + ln(p_i/p))
    flow:  de_v = dg beta df/dp,   df/dp = (eta - M)/(1 - N);   de_s = dg along dev e
    psi_i = v - v_c0 + lambda ln(-p_i/1 kPa),   dp_i = h (p_l - p_i) dg
    p_l = p (1 + 3.5 N psi_i/(beta M))^(-(1-N)/N),   N = 0: p exp(-3.5 psi_i/(beta M))

  tau  Kirchhoff stress J sigma, tension positive, Pa: p = tr(tau)/3 < 0, q = sqrt(3/2) |dev tau|. f bounds it, not the
       Cauchy stress
  b    elastic left Cauchy-Green tensor (history)
  p_i  image pressure, at which flow keeps its volume and q = -M p (history, as -p_i > 0). Its limit p_l follows from
       the density: loose sand hardens and contracts, dense sand dilates, peaks and softens
  v    specific volume (history), proportional to det F
  alpha  equivalent plastic strain (history): grows by sqrt(2/3) |dev e_p|, on which nothing depends

  An image pressure or a specific volume of 0 stands for that of the parameters. With `ocr` or `pop` the image pressure
  follows from the initial stress, or from p_ref where there is none: the yield surface meets the axis of pressure at
  ocr p_y or p_y + pop, where p_y is that of the surface through the stress.

  The step: v, p_i and dg are those of its end, all unknown at once. With y = ln(p/-p_ref) and L = ln(p/p_i) as unknowns
  f = 0 gives dg = e_s,trial - q/(3 G), so that the stress is on the yield surface to rounding, and

    y + (e_v,trial - dg beta df/dp)/kappa = 0,   ln(p_i,n/p_i + h dg p_l/p_i) - ln(1 + h dg) = 0

  At a given dg the second grows with L, y of the first put in: dg decides all. There is one root where the stress falls
  slower, as p_i softens, than by elastic unloading. On the axis of pressure the surface has a tip, q = 0 and eta = 0:
  de_s is then anything up to dg, and dg the unknown of the second residual.

  p_l has a pole at a v below 1; beyond it p_l goes on by its tangent. p < 0 always: in tension the stress vanishes
  while e_v grows, and returns when the volume does.

  The tangent is not symmetric.

  Source: Borja and Andrade (2006), doi:10.1016/j.cma.2005.08.020; Andrade and Ellison (2008),
  doi:10.1061/(ASCE)1090-0241(2008)134:12(1825); Jefferies (1993), doi:10.1680/geot.1993.43.1.91.
*/
#include "talus/point/elasticity.h"
#include "talus/point/implicit.h"
#include "nor_sand_surface.h"

static const MpmParameter parameters[] = {
  {MPM_NUMBER, "density", "kg/m3", 0., 0, 0., HUGE_VAL, 0, "mass per initial volume", NULL, 2000., NULL},
  {MPM_NUMBER, "kappa", "-", 0., 1, 0., HUGE_VAL, 1, "elastic volume strain per ln p", NULL, 0.01, NULL},
  {MPM_NUMBER, "G", "Pa", 0., 1, 0., HUGE_VAL, 1, "shear modulus, the same at all pressures", NULL, 20e6, NULL},
  {MPM_STRENGTH, "M", "-", 0., 1, 0., HUGE_VAL, 1, "q/p at the critical state", NULL, 1.2, NULL},
  {MPM_NUMBER, "N", "-", 0., 0, 0., 0.95, 0, "curvature of the yield surface; 0: that of Cam-Clay", NULL, 0.3, NULL},
  {MPM_NUMBER, "beta", "-", 1., 0, 0., HUGE_VAL, 1, "volume of the flow, over that of associated flow", NULL, 1., NULL},
  {MPM_NUMBER, "lambda", "-", 0., 1, 0., HUGE_VAL, 0, "slope of the critical state line, v over ln p", NULL, 0.02,
   NULL},
  {MPM_NUMBER, "v_c0", "-", 0., 1, 1., HUGE_VAL, 1, "specific volume of the critical state at 1 kPa", NULL, 1.9, NULL},
  {MPM_NUMBER, "h", "-", 0., 1, 0., HUGE_VAL, 1, "hardening: how fast the image pressure goes to its limit", NULL, 100.,
   NULL},
  {MPM_NUMBER, "specific_volume", "-", 0., 1, 1., HUGE_VAL, 1, "1 + void ratio at the start", NULL, 1.8, NULL},
  {MPM_NUMBER, "image_pressure", "Pa", HUGE_VAL, 0, 0., HUGE_VAL, 1, "at the start; or preconsolidation, ocr or pop",
   NULL, 100e3, NULL},
  {MPM_NUMBER, "preconsolidation", "Pa", HUGE_VAL, 0, 0., HUGE_VAL, 1,
   "pressure at which isotropic compression yields at the start; instead of image_pressure", NULL, 215e3, NULL},
  {MPM_NUMBER, "ocr", "-", HUGE_VAL, 0, 1., HUGE_VAL, 0,
   "preconsolidation over that with which the initial stress would yield; instead of image_pressure", NULL, 2., NULL},
  {MPM_NUMBER, "pop", "Pa", HUGE_VAL, 0, 0., HUGE_VAL, 0,
   "preconsolidation less that with which the initial stress would yield; instead of image_pressure", NULL, 100e3,
   NULL},
  {MPM_NUMBER, "reference_pressure", "Pa", 0., 1, 0., HUGE_VAL, 1, "pressure at which elastic strain is zero", NULL,
   100e3, NULL}};

enum { STATE_B = 0, STATE_IMAGE = MPM_SYM, STATE_VOLUME, STATE_ALPHA };

static const MpmStateVariable states[] = {{"elastic_left_cauchy_green", MPM_STATE_SYM, 1., "-"},
                                          {"image_pressure", MPM_STATE_SCALAR, 0., "Pa"},
                                          {"specific_volume", MPM_STATE_SCALAR, 0., "-"},
                                          {"equivalent_plastic_strain", MPM_STATE_SCALAR, 0., "-"}};

#define CRITICAL_PRESSURE 1e3  /* Pa, at which v_c0 is that of the critical state */
#define START_CUTS        50   /* bisections that find a start of the local problem where Newton finds none */
#define NEAR_TIP          0.01 /* eta/M below which the local problem has e_s as an unknown */

/* Common results of both pairs of unknowns */
typedef struct {
  Dual y, L, dilatancy, dg;
} Guess;

MPM_FN int SurfaceResidual(const Step *step, const Dual input[], const Guess *guess, Dual r[2])
{
  const Real *parameter = step->point->parameter;

  if (!(DualValue(guess->dg) > 0.)) return 1;
  r[0] = DualSub(guess->y, LogPressure(parameter, input[IN_VOLUME], guess->dg, guess->dilatancy));
  r[1] = HardeningResidual(step, input[IN_V], guess->dg, guess->y, guess->L);
  return 0;
}

/* Unknowns y and L */
MPM_FN int ByRatio(const void *problem, const Dual input[], const Dual x[], Dual r[])
{
  const Step *step  = (const Step *)problem;
  Guess       guess = {x[0], x[1], Dilatancy(step->point->parameter, x[1]), input[IN_SHEAR]};

  guess.dg = DualSub(guess.dg, ShearOnSurface(step->point->parameter, guess.y, guess.dilatancy));
  return SurfaceResidual(step, input, &guess, r);
}

/* L of y and e_s */
MPM_FN Dual RatioOfShear(const Real *parameter, Dual y, Dual shear)
{
  const Dual inverse = DualScale(3. * parameter[SHEAR] / parameter[REFERENCE_PRESSURE], DualExp(DualNeg(y)));

  return RatioOnSurface(parameter, DualMul(inverse, shear));
}

/* Unknowns y and e_s: where p is so large that L does not tell e_s */
MPM_FN int ByShear(const void *problem, const Dual input[], const Dual x[], Dual r[])
{
  const Step *step  = (const Step *)problem;
  Guess       guess = {x[0], RatioOfShear(step->point->parameter, x[0], x[1]), x[1], DualSub(input[IN_SHEAR], x[1])};

  guess.dilatancy = Dilatancy(step->point->parameter, guess.L);
  return SurfaceResidual(step, input, &guess, r);
}

/* r at a dg and L, y being what the first residual makes it */
MPM_FN Dual FlowResidual(const Step *step, const Dual input[], Dual dg, Dual L)
{
  const Real *parameter = step->point->parameter;
  const Dual  y         = LogPressure(parameter, input[IN_VOLUME], dg, Dilatancy(parameter, L));

  return HardeningResidual(step, input[IN_V], dg, y, L);
}

/* Unknown dg, at the tip */
MPM_FN int AtTip(const void *problem, const Dual input[], const Dual x[], Dual r[])
{
  const Step *step = (const Step *)problem;

  r[0] = FlowResidual(step, input, x[0], TipRatio(step->point->parameter));
  return 0;
}

/* Unknown L at a dg, the last input here */
MPM_FN int AtFlow(const void *problem, const Dual input[], const Dual x[], Dual r[])
{
  r[0] = FlowResidual((const Step *)problem, input, input[INPUTS], x[0]);
  return 0;
}

/* The second residual at the tip */
MPM_FN double TipExcess(const Step *step, const Dual input[], double dg)
{
  const Dual x = DualConstant(dg);
  Dual       r;

  AtTip(step, input, &x, &r);
  return DualValue(r);
}

/* ---- the local problem ---- */

/* dg at the tip, at least e_s of the trial state */
MPM_FN int SolveTip(const Step *step, const Dual input[], Dual *dg)
{
  const double   lower    = DualValue(input[IN_SHEAR]);
  const Implicit implicit = {AtTip, step, input, INPUTS, 1, RealValue(step->point->parameter[KAPPA])};
  double         upper    = lower + RealValue(step->point->parameter[KAPPA]);

  for (int doubling = 0; doubling < 60 && !(TipExcess(step, input, upper) > 0.); ++doubling) upper += upper - lower;
  return ImplicitBracket(&implicit, lower, upper, 0.5 * (lower + upper), dg);
}

/* y and L at a dg; a positive result: f < 0 there, so that dg is too large; 0: it is too small */
MPM_FN int SolveFlow(const Step *step, const Dual input[], double dg, double x[2])
{
  const Real    *parameter = step->point->parameter;
  const double   tip       = DualValue(TipRatio(parameter));
  const Dual     at[]      = {input[IN_VOLUME], input[IN_SHEAR], input[IN_V], DualConstant(dg)};
  const Implicit implicit  = {AtFlow, step, at, INPUTS + 1, 1, 1.};
  double         lower     = fmin(x[1], tip) - 1.;
  Dual           L         = DualConstant(lower), r;

  if (!(TipExcess(step, input, dg) > 0.)) return 0; /* beyond the tip eta < 0 */
  for (int doubling = 0; doubling < 60; ++doubling) {
    L = DualConstant(lower);
    AtFlow(step, at, &L, &r);
    if (DualValue(r) < 0.) break;
    lower -= 2. * (tip - lower);
  }
  if (ImplicitBracket(&implicit, lower, tip, fmin(x[1], tip), &L)) return 0;
  r    = Dilatancy(parameter, L);
  x[0] = DualValue(LogPressure(parameter, input[IN_VOLUME], DualConstant(dg), r));
  x[1] = DualValue(L);
  return log(3. * RealValue(parameter[SHEAR]) * (DualValue(input[IN_SHEAR]) - dg)) <
         log(DualValue(StressRatio(parameter, r)) * RealValue(parameter[REFERENCE_PRESSURE])) + x[0];
}

/* The end of a step */
typedef struct {
  Dual   y, L, shear; /* e_s */
  double ratio;       /* eta */
} End;

/*
  A start near the root, from bisections of dg between 0 and e_s of the trial state: y and, by `by_shear`, L or e_s. The
  last dg that is too large has y and L on the surface's side of the tip.
*/
MPM_FN void FindStart(const Step *step, const Dual input[], double trial, double start[2], int *by_shear)
{
  const double shear = DualValue(input[IN_SHEAR]);
  double       lower = 0., upper = shear, x[2] = {0., trial};

  SolveFlow(step, input, upper, x);
  for (int cut = 0; cut < START_CUTS; ++cut) {
    const double dg = 0.5 * (lower + upper);

    if (SolveFlow(step, input, dg, x)) upper = dg;
    else lower = dg;
  }
  SolveFlow(step, input, upper, x);
  *by_shear = x[1] > 0.;
  start[0]  = x[0];
  start[1]  = *by_shear ? shear - upper : x[1];
}

MPM_FN int SolveFrom(const Step *step, const Dual input[], const double start[2], int by_shear, End *end)
{
  const Real    *parameter = step->point->parameter;
  const Implicit implicit  = {by_shear ? ByShear : ByRatio, step, input, INPUTS, 2, 1.};
  Dual           x[2], dilatancy;

  if (ImplicitSystem(&implicit, start, x)) return 1;
  end->y     = x[0];
  end->L     = by_shear ? RatioOfShear(parameter, x[0], x[1]) : x[1];
  dilatancy  = Dilatancy(parameter, end->L);
  end->shear = by_shear ? x[1] : ShearOnSurface(parameter, x[0], dilatancy);
  end->ratio = DualValue(StressRatio(parameter, dilatancy));
  return !(DualValue(end->shear) >= 0. && DualValue(end->shear) <= DualValue(input[IN_SHEAR]));
}

/*
  Newton's method from the trial state finds most ends off the tip. Where it fails, or L is too coarse near the tip, the
  second residual shows whether the end is at the tip; otherwise bisections give another start.
*/
MPM_FN int Solve(const Step *step, const Dual input[], End *end)
{
  const Real *parameter = step->point->parameter;
  double      trial[2], start[2];
  int         by_shear;
  Dual        dg;

  trial[0] = -DualValue(input[IN_VOLUME]) / RealValue(parameter[KAPPA]);
  trial[1] = trial[0] - RealValue(step->log_image);
  if (!SolveFrom(step, input, trial, 0, end) && end->ratio > NEAR_TIP * RealValue(parameter[CRITICAL_RATIO])) return 0;
  if (TipExcess(step, input, DualValue(input[IN_SHEAR])) > 0.) {
    FindStart(step, input, trial[1], start, &by_shear);
    return SolveFrom(step, input, start, by_shear, end);
  }
  if (SolveTip(step, input, &dg)) return 1;
  end->L     = TipRatio(parameter);
  end->y     = LogPressure(parameter, input[IN_VOLUME], dg, Dilatancy(parameter, end->L));
  end->shear = DualConstant(0.);
  return 0;
}

/* ---- the law ---- */

/*
  Whether a trial state is surely inside, without logarithms: P = -p, q and -p_i. The surface is convex; below p_i it is
  above critical state, q = M P, and beyond above the chord to its tip, which is at e p_i where N = 0 and no nearer than
  (e - (e - 1) N) p_i otherwise.
*/
MPM_FN int IsSurelyInside(const Real *parameter, double P, double q, double image)
{
  const double reach = 1.718 * (1. - RealValue(parameter[CURVATURE])), beyond = P / image - 1.;

  return q <= (1. - 1e-9) * RealValue(parameter[CRITICAL_RATIO]) * (beyond <= 0. ? P : image * (1. - beyond / reach));
}

/* Excess of f over zero that rounding does not explain, at a trial state */
MPM_FN int IsOutside(const Step *step, double volume, double shear)
{
  const Real  *parameter = step->point->parameter;
  const double y = -volume / RealValue(parameter[KAPPA]), stiff = RealValue(parameter[SHEAR]);
  const Dual   L = DualShift(DualConstant(y), -RealValue(step->log_image)), dilatancy = Dilatancy(parameter, L);
  const double slope = DualValue(dilatancy), eta = DualValue(StressRatio(parameter, dilatancy));
  const double P = RealValue(parameter[REFERENCE_PRESSURE]) * exp(fmin(y, LARGEST_LOG));

  return 3. * stiff * shear - eta * P >
         ELASTIC_STRAIN_NOISE * (3. * stiff + fabs(slope) * P / RealValue(parameter[KAPPA]));
}

/* The image pressure that the parameters give a point at rest */
MPM_FN Real ImageAtRest(const Real *parameter)
{
  Real size = parameter[PRECONSOLIDATION];

  if (RealValue(parameter[IMAGE_PRESSURE]) <= DBL_MAX) return parameter[IMAGE_PRESSURE];
  if (RealValue(parameter[OCR]) <= DBL_MAX) size = parameter[OCR] * parameter[REFERENCE_PRESSURE];
  if (RealValue(parameter[POP]) <= DBL_MAX) size = parameter[REFERENCE_PRESSURE] + parameter[POP];
  return size * RealExp(-DualReal(TipRatio(parameter)));
}

/* Data of the point for the local problem */
MPM_FN Step StepCreate(const MpmLawPoint *point, Real image)
{
  const Real *parameter = point->parameter, reference = parameter[REFERENCE_PRESSURE];
  const Step  step = {point, RealLog(image / reference),
                      RealLog(reference / CRITICAL_PRESSURE) * parameter[LAMBDA] - parameter[V_C0]};

  return step;
}

/*
  Takes a trial strain to its end: the factor of its deviator, y, and ln(p_i/-p_ref). `v` is the specific volume of the
  step's end.
*/
MPM_FN int Yield(const Step *step, Scalar volume, const Sym *dev, Scalar v, Scalar *part, Scalar *y, Real *log_image)
{
  const Scalar in[INPUTS] = {volume, ScalarScale(sqrt(2. / 3.), SymNorm(dev)), v};
  Dual         input[INPUTS], shear;
  End          end;

  for (int k = 0; k < INPUTS; ++k) input[k] = DualSeed(ScalarValue(in[k]), k);
  if (Solve(step, input, &end)) return 1;
  shear      = DualValue(end.shear) > 0. ? DualDiv(end.shear, input[IN_SHEAR]) : DualConstant(0.);
  *part      = ScalarFromDual(shear, INPUTS, in);
  *y         = ScalarFromDual(end.y, INPUTS, in);
  *log_image = ScalarReal(ScalarFromDual(DualSub(end.y, end.L), INPUTS, in));
  return 0;
}

/* v of the step's end */
MPM_FN Scalar SpecificVolume(const MpmLawPoint *point, const Tensor *dF)
{
  const Real v = point->state_n[STATE_VOLUME];

  return ScalarScale(RealValue(v) > 0. ? v : point->parameter[SPECIFIC_VOLUME], TensorDetByCofactors(dF));
}

/* Whether a trial strain yields; if so, `step` is ready for it. */
MPM_FN int Yields(const MpmLawPoint *point, Real image, const Sym *e, Step *step)
{
  const Real  *parameter = point->parameter;
  const double volume = ScalarValue(SymTrace(e)), shear = sqrt(2. / 3.) * SymDevNormValue(e);
  const double P = RealValue(parameter[REFERENCE_PRESSURE]) * exp(-volume / RealValue(parameter[KAPPA]));

  if (IsSurelyInside(parameter, P, 3. * RealValue(parameter[SHEAR]) * shear, RealValue(image))) return 0;
  *step = StepCreate(point, image);
  return IsOutside(step, volume, shear);
}

MPM_FN int MpmMaterialEvaluate_nor_sand(const MpmLawPoint *point, const Tensor *dF, Sym *tau)
{
  const Real *parameter = point->parameter, stiff = 2. * parameter[SHEAR];
  const Real  image_n = point->state_n[STATE_IMAGE], given = RealValue(image_n) > 0. ? image_n : ImageAtRest(parameter);
  Real        image = given, growth = 0.;
  Sym         b = SymPush(dF, &point->state_n[STATE_B]), e;
  Scalar      y, p;
  Step        step;

  if (!ElasticIsRegular(point, dF) || ElasticLogStrain(&b, &e)) return 1;
  y = ScalarScale(-1. / parameter[KAPPA], SymTrace(&e));
  p = ScalarScale(-stiff / 3., SymTrace(&e)); /* reduction of the deviator by the strain */
  if (Yields(point, given, &e, &step)) {
    const Scalar volume = SymTrace(&e);
    const Sym    trial  = e;
    Scalar       part;

    e = SymDev(&e);
    if (Yield(&step, volume, &e, SpecificVolume(point, dF), &part, &y, &image)) return 1;
    e     = SymScale(part, &e);
    p     = ScalarConstant(0.);
    image = parameter[REFERENCE_PRESSURE] * RealExp(image);
    if (point->state) {
      const Sym end = SymShift(&e, ScalarScale(-parameter[KAPPA] / 3., y));

      if (ElasticLeftCauchyGreen(&end, &b)) return 1;
      growth = ElasticPlasticGrowth(&trial, &end);
    }
  }
  if (!(fabs(ScalarValue(y)) < LARGEST_LOG)) return 1;
  *tau = SymScaleBy(stiff, &e);
  *tau = SymShift(tau, ScalarSub(p, ScalarScale(parameter[REFERENCE_PRESSURE], ScalarExp(y))));
  if (point->state) {
    SymStore(&point->state[STATE_B], &b);
    point->state[STATE_IMAGE]  = image;
    point->state[STATE_VOLUME] = ScalarReal(SpecificVolume(point, dF));
    point->state[STATE_ALPHA]  = point->state_n[STATE_ALPHA] + growth;
  }
  return 0;
}

/* K + 4/3 G at the state's pressure, K = -p/kappa */
static double MpmMaterialStiffness_nor_sand(const double *parameter, const MpmLawTable *table, const double *state,
                                            const double *F)
{
  const double rest[6] = {1., 1., 1., 0., 0., 0.}, *b = state ? &state[STATE_B] : rest;
#if MPM_DIM == 2
  const double det = (b[0] * b[1] - b[3] * b[3]) * b[2];
#else
  const double det =
    b[0] * (b[1] * b[2] - b[4] * b[4]) - b[3] * (b[3] * b[2] - b[4] * b[5]) + b[5] * (b[3] * b[4] - b[1] * b[5]);
#endif

  (void)table, (void)F;
  return parameter[REFERENCE_PRESSURE] * exp(-0.5 * log(det) / parameter[KAPPA]) / parameter[KAPPA] +
         4. / 3. * parameter[SHEAR];
}

/* The pressure at the tip of the yield surface through a stress of pressure p > 0 and ratio eta = q/p */
static double TipPressure(const double *parameter, double p, double eta)
{
  Real real[REFERENCE_PRESSURE + 1];

  for (int k = 0; k <= REFERENCE_PRESSURE; ++k) real[k] = parameter[k];
  return p * exp(DualValue(TipRatio(real)) - DualValue(RatioOnSurface(real, DualConstant(eta))));
}

static double TipLog(const double *parameter)
{
  const double u = parameter[CURVATURE] / (1. - parameter[CURVATURE]);

  return DualValue(DualLog1pRatio(DualConstant(u)));
}

/*
  Elastic strain of a pressure and a deviator; image pressure by the stress where ocr or pop is given, otherwise, like
  the specific volume, of the parameters
*/
static int MpmMaterialHistory_nor_sand(const double *parameter, const MpmLawTable *table, const double *stress,
                                       double *state)
{
  const double p      = (stress[0] + stress[1] + stress[2]) / 3.;
  const double volume = -parameter[KAPPA] * log(-p / parameter[REFERENCE_PRESSURE]);
  const double ocr    = parameter[OCR] <= DBL_MAX ? parameter[OCR] : 1.,
               pop    = parameter[POP] <= DBL_MAX ? parameter[POP] : 0.;
  double square       = 0.; /* q^2 */
  Sym    e, b;

  (void)table;
  if (!(p < 0.)) return 1;
  for (int i = 0; i < MPM_SYM; ++i) {
    const double s = stress[i] - (i < 3 ? p : 0.);

    square += (i < 3 ? 1.5 : 3.) * s * s;
    e.a[i] = ScalarConstant(s / (2. * parameter[SHEAR]) + (i < 3 ? volume / 3. : 0.));
  }
  if (ElasticLeftCauchyGreen(&e, &b)) return 1;
  SymValues(&state[STATE_B], &b);
  if (!(state[STATE_IMAGE] > 0.) && (parameter[OCR] <= DBL_MAX || parameter[POP] <= DBL_MAX)) {
    state[STATE_IMAGE] = (ocr * TipPressure(parameter, -p, -sqrt(square) / p) + pop) * exp(-TipLog(parameter));
    if (!(state[STATE_IMAGE] > 0. && state[STATE_IMAGE] <= DBL_MAX)) return 1; /* beyond the strength of any */
  }
  return 0;
}

/*
  Jaky's ratio with sin(phi) = 3 M/(6 + M), that of triaxial compression, times OCR^sin(phi). OCR is `ocr`, or the
  pressure at the yield surface's tip, given or larger by `pop`, over that of the surface through the stress with Jaky's
  ratio.
*/
static double MpmMaterialK0_nor_sand(const double *parameter, const MpmLawTable *table, const double *state,
                                     double weight)
{
  const double sine = 3. * parameter[CRITICAL_RATIO] / (6. + parameter[CRITICAL_RATIO]), jaky = 1. - sine;
  const double p = (1. + 2. * jaky) / 3. * weight, eta = 3. * sine / (1. + 2. * jaky);
  const double yields = p > 0. ? TipPressure(parameter, p, eta) : 0., tip = exp(TipLog(parameter));
  double       size = state ? tip * state[STATE_IMAGE] : 0., ocr = 1.;

  (void)table;
  if (!(size > 0.) && parameter[IMAGE_PRESSURE] <= DBL_MAX) size = tip * parameter[IMAGE_PRESSURE];
  if (!(size > 0.) && parameter[PRECONSOLIDATION] <= DBL_MAX) size = parameter[PRECONSOLIDATION];
  if (!(size > 0.) && parameter[POP] <= DBL_MAX) size = yields + parameter[POP];
  if (size > 0. && p > 0.) ocr = size / yields;
  else if (parameter[OCR] <= DBL_MAX) ocr = parameter[OCR];
  return jaky * pow(fmax(ocr, 1.), sine);
}

static int MpmMaterialCheck_nor_sand(const double *parameter, const MpmLawTable *table, MpmLawFault *fault)
{
  const MpmLawFault neither = {
    -1, 0., 0., 0,
    "one of image_pressure (Pa, > 0), preconsolidation (Pa, > 0), ocr (-, >= 1) and pop (Pa, >= 0) is missing"};
  MpmLawFault both  = {-1, -HUGE_VAL, HUGE_VAL, 0,
                       "only one of image_pressure, preconsolidation, ocr and pop can be given"};
  int         count = 0;

  (void)table;
  for (int k = IMAGE_PRESSURE; k <= POP; ++k) {
    if (!(parameter[k] <= DBL_MAX)) continue;
    both.parameter = k;
    ++count;
  }
  *fault = count ? both : neither;
  return count == 1;
}

static double MpmMaterialShearModulus_nor_sand(const double *parameter, const MpmLawTable *table, const double *state,
                                               const double *F)
{
  (void)table, (void)state, (void)F;
  return parameter[SHEAR];
}

/* -kappa p, and that of shear */
static double MpmMaterialEnergy_nor_sand(const double *parameter, const MpmLawTable *table, const double *tau,
                                         const double *F)
{
  double       pressure;
  const double shear = ElasticShearEnergy(tau, parameter[SHEAR], &pressure);

  (void)table, (void)F;
  return shear + parameter[KAPPA] * pressure;
}

MPM_LAW_DEFINE(nor_sand, parameters, states, MpmMaterialEvaluate_nor_sand,
               .summary = "Nor-Sand, critical state plasticity of sand", .traits = MPM_LAW_PLASTIC | MPM_LAW_VOLUME,
               .check = MpmMaterialCheck_nor_sand, .stiffness = MpmMaterialStiffness_nor_sand,
               .shear_modulus = MpmMaterialShearModulus_nor_sand, .history = MpmMaterialHistory_nor_sand,
               .k0 = MpmMaterialK0_nor_sand, .energy = MpmMaterialEnergy_nor_sand)

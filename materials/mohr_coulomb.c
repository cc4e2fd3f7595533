/*
  Mohr-Coulomb plasticity: Hencky elasticity, the six planes of Mohr-Coulomb with exact edges and apex, optional tension
  cut-off, linear softening of all strengths

    b_trial = dF b_n dF^T,   e = (1/2) ln b,   tau = lambda tr(e) I + 2 mu e
    f = t1 - t3 + (t1 + t3) sin phi - 2 c cos phi <= 0,   t1 <= tension,   t1 >= t2 >= t3 principal values of tau
    flow potential of f: f with psi in place of phi; the cut-off's is t1 itself

  tau    Kirchhoff stress J sigma, tension positive, Pa; f bounds the Kirchhoff stress, not the Cauchy stress
  b      elastic left Cauchy-Green tensor (history)
  kappa  equivalent plastic strain (history): grows by sqrt(2/3) |de_p|, where de_p is the step's plastic part of e,
         opening and dilation included

  Softening: c, phi and psi go linearly in kappa from their values to the residual ones at kappa = softening_strain, the
  tension strength in proportion to c. All are those of the step's end.

  Return: that of coulomb.h to planes, edges and corners, in principal values of tau, exact but for the strengths of the
  step's end, which are one equation for the growth of kappa.

  On planes the tangent is not symmetric unless dilation = friction and nothing softens. At a corner the point has no
  stiffness.

  Softening localises in bands whose width is that of the mesh. Where a plane's strength falls faster than elastic
  unloading, in softening_strain of the order of strength over E, a point's stress drops within the step and is no
  longer a smooth function of it.

  Source: de Souza Neto, Peric and Owen (2008), doi:10.1002/9780470694626, sections 8.2 and 14.4; Koiter (1953),
  Quarterly of Applied Mathematics 11, 350-354, for edges.
*/
#include "talus/point/coulomb.h"
#include "talus/point/implicit.h"

enum {
  COHESION = ELASTIC_COUNT,
  FRICTION,
  DILATION,
  TENSION,
  COHESION_RESIDUAL,
  FRICTION_RESIDUAL,
  DILATION_RESIDUAL,
  SOFTENING_STRAIN
};

static const MpmParameter parameters[] = {
  ELASTIC_PARAMETERS,
  {MPM_STRENGTH, "cohesion", "Pa", 0., 1, 0., HUGE_VAL, 0, "c of Mohr-Coulomb", NULL, 20e3, NULL},
  {MPM_STRENGTH_ANGLE, "friction", "degrees", 0., 1, 0., 89., 0, "friction angle of Mohr-Coulomb", NULL, 30., NULL},
  {MPM_STRENGTH_ANGLE, "dilation", "degrees", 0., 0, 0., 89., 0, "dilation angle, at most the friction angle", NULL,
   10., NULL},
  {MPM_STRENGTH, "tension", "Pa", HUGE_VAL, 0, 0., HUGE_VAL, 0,
   "largest tension that the material bears, at most c cot(friction); without it, that", NULL, 10e3, NULL},
  {MPM_STRENGTH, "cohesion_residual", "Pa", 0., 0, 0., HUGE_VAL, 0, "cohesion left at softening_strain", NULL, 1e3,
   "cohesion"},
  {MPM_STRENGTH_ANGLE, "friction_residual", "degrees", 0., 0, 0., 89., 0, "friction angle left at softening_strain",
   NULL, 20., "friction"},
  {MPM_STRENGTH_ANGLE, "dilation_residual", "degrees", 0., 0, 0., 89., 0, "dilation angle left at softening_strain",
   NULL, 1., "dilation"},
  {MPM_NUMBER, "softening_strain", "-", HUGE_VAL, 0, 0., HUGE_VAL, 1,
   "equivalent plastic strain at which the residual strengths are reached; without it nothing softens", NULL, 0.1,
   NULL}};

#define MOBILISED 0.8 /* part of the strength from which on F-bar leaves dilation to the point */

enum { STATE_B = 0, STATE_KAPPA = MPM_SYM };

static const MpmStateVariable states[] = {{"elastic_left_cauchy_green", MPM_STATE_SYM, 1., "-"},
                                          {"equivalent_plastic_strain", MPM_STATE_SCALAR, 0., "-"}};

/* ---- strength ---- */

/* How much of the way to the residual strength an equivalent plastic strain has gone */
MPM_FN Dual SoftPart(const Real *parameter, Dual kappa)
{
  if (!(RealValue(parameter[SOFTENING_STRAIN]) <= DBL_MAX)) return DualConstant(0.);
  if (DualValue(kappa) >= RealValue(parameter[SOFTENING_STRAIN])) return DualConstant(1.);
  return DualDiv(kappa, DualConstant(parameter[SOFTENING_STRAIN]));
}

MPM_FN Dual Soften(const Real *parameter, int peak, int residual, Dual part)
{
  return DualShift(DualScale(parameter[residual] - parameter[peak], part), parameter[peak]);
}

MPM_FN Dual SoftAngle(const Real *parameter, int peak, int residual, Dual part)
{
  return DualScale(3.14159265358979323846 / 180., Soften(parameter, peak, residual, part));
}

MPM_FN CoulombStrength StrengthAt(const Real *parameter, Dual part)
{
  const Dual      c        = Soften(parameter, COHESION, COHESION_RESIDUAL, part);
  CoulombStrength strength = CoulombStrengthCreate(c, SoftAngle(parameter, FRICTION, FRICTION_RESIDUAL, part));

  strength.cut = RealValue(parameter[TENSION]) <= DBL_MAX;
  if (strength.cut && RealValue(parameter[COHESION]) > 0.)
    strength.tension = DualScale(parameter[TENSION] / parameter[COHESION], c);
  else if (strength.cut) strength.tension = DualConstant(parameter[TENSION]);
  return strength;
}

MPM_FN CoulombFlow FlowAt(const Real *parameter, Lame lame, const CoulombStrength *strength, Dual part)
{
  return CoulombFlowCreate(lame, strength, DualSin(SoftAngle(parameter, DILATION, DILATION_RESIDUAL, part)));
}

/* ---- elastic or not ---- */

/* True where the stress of strain e is surely elastic, without principal axes: by its invariants, then by its
   principal values, with a margin for their error in 3D; otherwise the axes can follow from `split` */
MPM_FN int IsSurelyElastic(const CoulombStrength *strength, Lame lame, const Sym *e, SymSplit *split)
{
  const double lambda = RealValue(lame.lambda), mu = RealValue(lame.mu);
  const Sym    dev   = SymDev(e);
  const double trace = ScalarValue(SymTrace(e)), p = (lambda + 2. / 3. * mu) * trace;
  const double root = sqrt(2.) * mu * SymNormValue(&dev), off = MPM_DIM == 3 ? 1e-6 * root : 0.;
  double       w[3];

  if (CoulombIsSurelyInside(strength, p, root)) return 1;
  *split = SymSplitCreate(e);
  SymSplitValues(split, w);
  return CoulombExcess(strength, lambda * trace + 2. * mu * w[0], lambda * trace + 2. * mu * w[2]) + off <=
         CoulombNoise(lame);
}

/* ---- softening ---- */

/* Return with the strength at the end of a growth x of kappa; x becomes what the return makes it. */
MPM_FN int ReturnWith(const MpmLawPoint *point, Lame lame, const Dual trial[3], Dual *x, Dual t[3])
{
  const Dual            part     = SoftPart(point->parameter, DualShift(*x, point->state_n[STATE_KAPPA]));
  const CoulombStrength strength = StrengthAt(point->parameter, part);
  const CoulombFlow     flow     = FlowAt(point->parameter, lame, &strength, part);

  for (int a = 0; a < 3; ++a) t[a] = trial[a];
  if (CoulombReturn(&strength, &flow, t)) return 1;
  *x = CoulombPlasticStrain(lame, trial, t);
  return 0;
}

/*
  Upper bound of any return's growth of kappa: no plane's multiplier exceeds f/(n . C r) <= most/(4 mu), since the
  contribution of the others is never negative, no flow r is longer than 2, and at most four planes meet.
*/
MPM_FN double MostGrowth(Lame lame, const Dual trial[3])
{
  const double t1 = DualValue(trial[0]), t3 = DualValue(trial[2]), most = fmax(t1 - t3, 2. * t1);

  return RealValue(lame.lambda) >= 0. ? 1.64 * most / RealValue(lame.mu) : HUGE_VAL;
}

/* Flow on the plane 13 alone, in plain numbers, to start from. Angles turn with kappa: friction and dilation. */
typedef struct {
  double sine[2], cosine[2], turn[2]; /* at the step's start, and radians by kappa */
  double c, fall, sum, difference, lambda, mu;
} Start;

MPM_FN Start StartCreate(const Real *parameter, Lame lame, const CoulombStrength *strength, double kappa,
                         const Dual trial[3])
{
  const double part = 1. / RealValue(parameter[SOFTENING_STRAIN]), radians = 3.14159265358979323846 / 180.;
  double       angle;
  Start        start;

  start.turn[0]    = radians * part * RealValue(parameter[FRICTION_RESIDUAL] - parameter[FRICTION]);
  start.turn[1]    = radians * part * RealValue(parameter[DILATION_RESIDUAL] - parameter[DILATION]);
  angle            = radians * RealValue(parameter[DILATION]) + kappa * start.turn[1];
  start.sine[0]    = DualValue(strength->sin_phi);
  start.cosine[0]  = sqrt(1. - start.sine[0] * start.sine[0]);
  start.sine[1]    = sin(angle);
  start.cosine[1]  = cos(angle);
  start.fall       = part * RealValue(parameter[COHESION_RESIDUAL] - parameter[COHESION]);
  start.c          = RealValue(parameter[COHESION]) + kappa * start.fall;
  start.sum        = DualValue(trial[0]) + DualValue(trial[2]);
  start.difference = DualValue(trial[0]) - DualValue(trial[2]);
  start.lambda     = RealValue(lame.lambda);
  start.mu         = RealValue(lame.mu);
  return start;
}

/* Growth of kappa with the strength at the end of a growth x, to the third power of the turns, and its slope at 0 */
MPM_FN double StartGrowth(const Start *start, double x, double *slope)
{
  const double both = start->lambda + start->mu, c = start->c + start->fall * x;
  double       sine[2], cosine[2], f, down, length, change;

  for (int i = 0; i < 2; ++i) {
    const double angle = start->turn[i] * x, even = 1. - 0.5 * angle * angle;
    const double odd = angle - angle * angle * angle * (1. / 6.);

    sine[i]   = start->sine[i] * even + start->cosine[i] * odd;
    cosine[i] = start->cosine[i] * even - start->sine[i] * odd;
  }
  f      = start->difference + start->sum * sine[0] - 2. * c * cosine[0];
  down   = 1. / (start->mu + both * sine[0] * sine[1]);
  length = down * sqrt((1. + sine[1] * sine[1]) * (1. / 12.));
  if (!slope) return length * f;
  change = (start->sum * cosine[0] + 2. * c * sine[0]) * start->turn[0] - 2. * start->fall * cosine[0];
  change -= f * down * both * (cosine[0] * start->turn[0] * sine[1] + sine[0] * cosine[1] * start->turn[1]);
  change += f * sine[1] * cosine[1] * start->turn[1] / (1. + sine[1] * sine[1]);
  *slope = length * change;
  return length * f;
}

/* Where that is x: Newton's method, twice with the first slope */
MPM_FN double StartFind(const Start *start)
{
  double       slope;
  const double first = StartGrowth(start, 0., &slope), part = 1. / (1. - slope), x = part * first;

  return x + part * (StartGrowth(start, x, NULL) - x);
}

/* Equation for the growth of kappa, and its last return: stresses and growth with all derivatives, direction 3 that by
   the growth x that it took */
typedef struct {
  const MpmLawPoint *point;
  Lame               lame;
  const Dual        *trial;
  Dual              *t, *grown;
  double            *taken;
} Softening;

MPM_FN int LookAt(const Softening *softening, double x)
{
  *softening->taken = x;
  *softening->grown = DualSeed(x, 3); /* a direction that the stresses have not taken */
  return ReturnWith(softening->point, softening->lame, softening->trial, softening->grown, softening->t);
}

MPM_FN int Growth(const void *problem, const Dual input[], const Dual x[], Dual r[])
{
  const Softening *softening = (const Softening *)problem;

  (void)input;
  if (LookAt(softening, DualValue(x[0]))) return 1;
  r[0] = DualSub(x[0], DualChain(x[0], DualValue(*softening->grown), DualDirection(*softening->grown, 3)));
  return 0;
}

/* Part of the softening strain over which nothing changes by more than the square root of rounding */
#define LAST_GROWTH 1e-9

/* Return of trial stresses outside the yield surface, with the growth of kappa; `strength` is that of the step's
   start. */
MPM_FN int ReturnSoftening(const MpmLawPoint *point, Lame lame, const CoulombStrength *strength, const Dual trial[3],
                           Dual *x, Dual t[3])
{
  const double    kappa = RealValue(point->state_n[STATE_KAPPA]);
  const double    left  = RealValue(point->parameter[SOFTENING_STRAIN]) - kappa;
  const int       soft  = left > 0. && left <= DBL_MAX;
  double          root, taken, slope, step;
  const Softening problem = {point, lame, trial, t, x, &taken};
  const Implicit  growth  = {Growth, &problem, trial, 3, 1, LAST_GROWTH * left / (4. * DBL_EPSILON)};
  Start           start;

  if (!soft || MostGrowth(lame, trial) >= left) {
    *x = DualConstant(soft ? left : 0.);
    if (ReturnWith(point, lame, trial, x, t)) return 1; /* with the residual strength, or one that does not change */
    if (!(soft && DualValue(*x) < left)) return 0;
  }
  start = StartCreate(point->parameter, lame, strength, kappa, trial);
  root  = fmin(fmax(StartFind(&start), 0.), left);
  if (LookAt(&problem, root)) return 1;
  slope = DualDirection(*x, 3);
  step  = (DualValue(*x) - root) / (1. - slope);
  if (fabs(step) <= LAST_GROWTH * left && root + step >= 0. && root + step < left) root += step;
  else if (ImplicitFind(&growth, 0., left, root, &root)) return 1;
  slope = DualDirection(*x, 3);
  *x    = DualChain(*x, root, 1. / (1. - slope)); /* of x - grown(trial, x) = 0 */
  for (int a = 0; a < 3; ++a) {
    const double by_x = DualDirection(t[a], 3);

    t[a] = DualShift(t[a], by_x * (root - taken)); /* Newton's last step */
    DualAddDirections(&t[a], by_x, x);
  }
  return fabs(1. - slope) < DBL_MIN;
}

/* ---- the law ---- */

/* Takes the trial strain e to its stress, and writes the plastic history. */
MPM_FN int Yield(const MpmLawPoint *point, Lame lame, const CoulombStrength *strength, const SymPrincipal *principal,
                 const Sym *e, Sym *tau)
{
  Dual w[3], trial[3], t[3], mean, x;

  for (int a = 0; a < 3; ++a) w[a] = DualSeed(principal->value[a], a);
  mean = DualScale(lame.lambda, DualAdd(DualAdd(w[0], w[1]), w[2]));
  for (int a = 0; a < 3; ++a) trial[a] = DualAdd(mean, DualScale(2. * lame.mu, w[a]));
  if (ReturnSoftening(point, lame, strength, trial, &x, t)) return 1;
  *tau = SymIsotropic(e, principal, t);
  if (point->state) {
    Sym b;

    CoulombPrincipalStrain(lame, t, w);
    for (int a = 0; a < 3; ++a) w[a] = DualExp(DualScale(2., w[a]));
    b = SymIsotropic(e, principal, w);
    SymStore(&point->state[STATE_B], &b);
    point->state[STATE_KAPPA] = point->state_n[STATE_KAPPA] + ScalarReal(SymInvariant(e, principal, x));
  }
  return 0;
}

MPM_FN int MpmMaterialEvaluate_mohr_coulomb(const MpmLawPoint *point, const Tensor *dF, Sym *tau)
{
  const Lame            lame     = LameFromParameters(point->parameter);
  const Dual            part     = SoftPart(point->parameter, DualConstant(point->state_n[STATE_KAPPA]));
  const CoulombStrength strength = StrengthAt(point->parameter, part);
  const Sym             b        = SymPush(dF, &point->state_n[STATE_B]);
  SymPrincipal          principal;
  SymSplit              split;
  Sym                   e;

  if (!ElasticIsRegular(point, dF) || ElasticLogStrain(&b, &e)) return 1;
  if (!IsSurelyElastic(&strength, lame, &e, &split)) {
    double mean = 0.;

    if (SymSplitPrincipal(&split, &principal)) return 1;
    for (int a = 0; a < 3; ++a) mean += RealValue(lame.lambda) * principal.value[a];
    if (CoulombExcess(&strength, mean + 2. * RealValue(lame.mu) * principal.value[0],
                      mean + 2. * RealValue(lame.mu) * principal.value[2]) > CoulombNoise(lame))
      return Yield(point, lame, &strength, &principal, &e, tau);
  }
  *tau = ElasticStress(lame, &e);
  if (point->state) {
    SymStore(&point->state[STATE_B], &b);
    point->state[STATE_KAPPA] = point->state_n[STATE_KAPPA];
  }
  return 0;
}

static int MpmMaterialCheck_mohr_coulomb(const double *parameter, const MpmLawTable *table, MpmLawFault *fault)
{
  const double      apex = parameter[COHESION] / tan(parameter[FRICTION] * 3.14159265358979323846 / 180.);
  const int         soft = parameter[SOFTENING_STRAIN] <= DBL_MAX, cut = parameter[TENSION] <= DBL_MAX;
  const MpmLawFault limits[] = {
    {DILATION, 0., parameter[FRICTION], 0, "dilation must not exceed friction"},
    {TENSION, 0., parameter[FRICTION] > 0. && cut ? apex * (1. + 1e-14) : HUGE_VAL, 0,
     "tension must not exceed cohesion cot(friction), where the planes meet"},
    {COHESION_RESIDUAL, soft ? 0. : parameter[COHESION], parameter[COHESION], 0,
     soft ? "it must not exceed cohesion" : "without softening_strain it must be that of cohesion"},
    {FRICTION_RESIDUAL, soft ? 0. : parameter[FRICTION], parameter[FRICTION], 0,
     soft ? "it must not exceed friction" : "without softening_strain it must be that of friction"},
    {DILATION_RESIDUAL, soft ? 0. : parameter[DILATION], soft ? parameter[FRICTION_RESIDUAL] : parameter[DILATION], 0,
     soft ? "it must not exceed friction_residual" : "without softening_strain it must be that of dilation"}};

  (void)table;
  for (size_t k = 0; k < sizeof(limits) / sizeof(limits[0]); ++k) {
    const double value = parameter[limits[k].parameter];

    *fault = limits[k];
    if (!(value >= fault->lower && value <= fault->upper)) return 0;
  }
  return 1;
}

/* Associated flow, and a strength that does not depend on it */
static int MpmMaterialSymmetric_mohr_coulomb(const double *parameter, const MpmLawTable *table)
{
  (void)table;
  return parameter[DILATION] == parameter[FRICTION] && parameter[COHESION_RESIDUAL] == parameter[COHESION] &&
         parameter[FRICTION_RESIDUAL] == parameter[FRICTION] && parameter[DILATION_RESIDUAL] == parameter[DILATION];
}

/* Jaky: the law does not know what it has borne before. */
static double MpmMaterialK0_mohr_coulomb(const double *parameter, const MpmLawTable *table, const double *state,
                                         double weight)
{
  (void)table;
  (void)state;
  (void)weight;
  return 1. - sin(parameter[FRICTION] * 3.14159265358979323846 / 180.);
}

/*
  On Mohr-Coulomb's plane flow in the plane dilates by sin(psi) of its shear. Inside, dilation fades to 0 where the
  shear is MOBILISED of the plane's strength. If a stress just inside counted as elastic, forces of F-bar would jump
  between steps, and geostatic stages would not come to rest.
*/
static Real MpmMaterialDilatancy_mohr_coulomb(const Real *parameter, const MpmLawTable *table, const Real *state,
                                              Real elastic[3])
{
  const Real  *b = &state[STATE_B], xx = b[0], yy = b[1], xy = b[3];
  const Lame   lame = LameFromParameters(parameter);
  const Real   mean = 0.5 * (xx + yy), half = 0.5 * (xx - yy);
  const double round  = hypot(RealValue(half), RealValue(xy));
  const Real   radius = RealChain(half * half + xy * xy, round, round > 0. ? 0.5 / round : 0.);
  const Real   kappa = state[STATE_KAPPA], soft = parameter[SOFTENING_STRAIN];
  const Real   part = !(RealValue(soft) <= DBL_MAX) ? 0. : RealValue(kappa) / RealValue(soft) >= 1. ? 1. : kappa / soft;
  const double degrees = 3.14159265358979323846 / 180.;
  const Real   c       = parameter[COHESION] + part * (parameter[COHESION_RESIDUAL] - parameter[COHESION]);
  const Real   phi     = degrees * (parameter[FRICTION] + part * (parameter[FRICTION_RESIDUAL] - parameter[FRICTION]));
  const Real   psi     = degrees * (parameter[DILATION] + part * (parameter[DILATION_RESIDUAL] - parameter[DILATION]));
  Real         e[3], trace, high, low, shear, strength;

  (void)table;
  if (!(RealValue(psi) > 0. && RealValue(mean) > RealValue(radius))) return 0.;
  e[0]     = 0.5 * RealLog(mean + radius);
  e[1]     = 0.5 * RealLog(mean - radius);
  e[2]     = 0.5 * RealLog(b[2]);
  trace    = lame.lambda * (e[0] + e[1] + e[2]);
  high     = trace + 2. * lame.mu * (RealValue(e[0]) > RealValue(e[2]) ? e[0] : e[2]);
  low      = trace + 2. * lame.mu * (RealValue(e[1]) < RealValue(e[2]) ? e[1] : e[2]);
  shear    = high - low;
  strength = 2. * c * RealCos(phi) - (high + low) * RealSin(phi);
  if (RealValue(shear) <= MOBILISED * RealValue(strength) || RealValue(shear) <= CoulombNoise(lame)) return 0.;
  elastic[0] = xx;
  elastic[1] = yy;
  elastic[2] = xy;
  return RealValue(shear) < RealValue(strength) ? RealSin(psi) * (shear / strength - MOBILISED) / (1. - MOBILISED)
                                                : RealSin(psi);
}

MPM_LAW_DILATANCY(mohr_coulomb, parameters, states, MpmMaterialDilatancy_mohr_coulomb)

MPM_LAW_MODULI(mohr_coulomb, parameters, states, ElasticModuli)

MPM_LAW_DEFINE(mohr_coulomb, parameters, states, MpmMaterialEvaluate_mohr_coulomb,
               .summary = "Mohr-Coulomb plasticity with dilation, tension cut-off and softening",
               .traits  = MPM_LAW_PLASTIC | MPM_LAW_FIXED_MODULI | MPM_LAW_VOLUME,
               .check = MpmMaterialCheck_mohr_coulomb, .stiffness = ElasticStiffness,
               .shear_modulus = ElasticShearModulus, .symmetric = MpmMaterialSymmetric_mohr_coulomb,
               .history = ElasticHistory, .k0 = MpmMaterialK0_mohr_coulomb,
               MPM_DILATANCY(mohr_coulomb, MpmMaterialDilatancy_mohr_coulomb), MPM_MODULI(mohr_coulomb))

/*
  Phase-field fracture at one point: displacement and damage d at the nodes, 0 sound, 1 broken.

  With psi the law's energy per initial volume, psi = psi+ + psi-, and grad d by the initial position, one step makes

    sum_p V_0 [ g(d) psi+ + psi- + G_c/c_w (w(d)/l + l |grad d|^2) ] ,   g = (1 - eta) (1 - d)^2 + eta

  stationary by the displacement and by d:

    V_0 ((g tau+ + tau-) dF^{-T})_ab                    conjugate to du_a,b
    V_0 (g' psi+ + G_c w'/(c_w l))                      conjugate to d
    V_0 2 G_c l/c_w F_n F_n^T grad d                    conjugate to grad d by the position at the step's start

  `regularisation`: at1, w = d, c_w = 8/3, sound below a stress; at2, w = d^2, c_w = 2. `split`: the energy of a volume
  that shrinks, J < 1, is psi- and does no damage (volumetric); psi- = 0 (none); or, with the principal elastic strains
  e_a of a law that is linear in small or logarithmic strain,

    psi+ = lambda/2 <tr e>^2 + mu sum_a <e_a>^2 ,   <x> = max(x, 0)    (spectral)

  The energy of a law with history is its elastic one.

  Damage does not heal, and is at most 1. With `irreversible: bounds` d of each node stays at least what it is at the
  step's start (volume/irreversible.c). With `history` psi+ in the second equation is the largest that the point has
  had; d is then bounded by 0 and 1 alone. Each bound is a spring of stiffness G_c/(c_w l)/tolerance, which leaves gaps
  of the order of the tolerance. Those at the points: d is at most 1, and with `bounds` at least `initial_damage`, for a
  crack that is there from the start has edges that nodes need not lie on.

  Sources: Bourdin, Francfort and Marigo (2000), doi:10.1016/S0022-5096(99)00028-9 (the energy); Pham and others (2011),
  doi:10.1177/1056789510386852 (AT1, AT2); Amor, Marigo and Maurini (2009), doi:10.1016/j.jmps.2009.04.011 (volumetric
  split); Miehe, Welschinger and Hofacker (2010), doi:10.1002/nme.2861 (spectral split); Miehe, Hofacker and Welschinger
  (2010), doi:10.1016/j.cma.2010.04.011 (history); Gerasimov and De Lorenzis (2019), doi:10.1016/j.cma.2019.05.038
  (bounds by a penalty).
*/
#include "solid.h"

/* Places among the physics' values: those of the material, then those of the scene. */
enum { TOUGHNESS, LENGTH, RESIDUAL, REGULARISATION, SPLIT, SCHEME, IRREVERSIBLE, TOLERANCE, SCALE };
enum { AT1, AT2 };
enum { VOLUMETRIC, NONE, SPECTRAL };
enum { MONOLITHIC, STAGGERED };
enum { BOUNDS, HISTORY };

/* States: the largest psi+ so far and what damage has dissipated, J/m3; d from the start. */
enum { STATE_HISTORY, STATE_FRACTURE, STATE_START };

/* Inputs */
enum { GRADIENTS = MPM_TENSOR, D = GRADIENTS, GRAD_D, INPUTS = GRAD_D + MPM_DIM };

/* Stress and energy that damage takes away, out of the law's. */
typedef struct {
  Sym    tau;   /* of the law */
  Sym    plus;  /* tau+ */
  Scalar drive; /* psi+ */
} Parts;

/* The energy of a law that has a function for it. Its derivative by dF is the flux of the stress. */
MPM_FN int DivideEnergy(const MpmKernelPoint *point, const Tensor *dF, Scalar J, int shrinks, Parts *parts)
{
  const MpmLawInfo *info = point->material.info;
  const Tensor      F_n  = TensorMulArray(dF, point->F_n);
  double            F[MPM_TENSOR], tau[MPM_SYM], volume[3] = {0.};
  Scalar            flux[GRADIENTS];

  TensorStore(F, &F_n);
  SymStore(tau, &parts->tau);
  parts->plus = parts->tau;
  if (shrinks) {
    info->volumetric(point->material.parameter, point->material.table, ScalarValue(J), volume);
    parts->plus = SymShift(&parts->tau, ScalarNeg(ScalarChain(J, volume[1], volume[2])));
  }
  parts->drive = ScalarConstant(info->energy(point->material.parameter, point->material.table, tau, F) - volume[0]);
  SolidFlux(point, &parts->plus, dF, flux);
  for (int k = 0; k < GRADIENTS; k++)
    ScalarAddDirections(&parts->drive, ScalarValue(flux[k]) / point->volume0, &dF->a[k]);
  return 0;
}

/* By the principal strains, from the stress of an elasticity with these moduli. */
MPM_FN int DivideSpectral(double mu, double bulk, Parts *parts)
{
  const Sym    dev = SymDev(&parts->tau), shear = SymScaleBy(0.5 / mu, &dev);
  Scalar       trace  = ScalarScale(1. / (3. * bulk), SymTrace(&parts->tau));
  const Sym    strain = SymShift(&shear, ScalarScale(1. / 3., trace));
  Sym          positive;
  SymPrincipal principal;
  Dual         e[3];

  if (SymPrincipalCreate(&strain, &principal)) return 1;
  for (int a = 0; a < 3; a++) e[a] = principal.value[a] > 0. ? DualSeed(principal.value[a], a) : DualConstant(0.);
  positive = SymIsotropic(&strain, &principal, e);
  if (!(ScalarValue(trace) > 0.)) trace = ScalarConstant(0.);
  parts->plus  = SymScaleBy(2. * mu, &positive);
  parts->plus  = SymShift(&parts->plus, ScalarScale(bulk - 2. / 3. * mu, trace));
  parts->drive = ScalarScale(0.5 * (bulk - 2. / 3. * mu), ScalarSquare(trace));
  parts->drive = ScalarAdd(parts->drive, ScalarScale(mu, SymDot(&positive, &positive)));
  return 0;
}

/* The energy of other laws follows from the stress, by the moduli at the step's start. */
MPM_FN int DivideStress(const MpmKernelPoint *point, int shrinks, Parts *parts)
{
  const MpmLawInfo *info = point->material.info;
  const double mu = info->shear_modulus(point->material.parameter, point->material.table, point->state_n, point->F_n);
  const double bulk =
    info->stiffness(point->material.parameter, point->material.table, point->state_n, point->F_n) - 4. / 3. * mu;
  const Sym    dev  = SymDev(&parts->tau);
  const Scalar mean = ScalarScale(1. / 3., SymTrace(&parts->tau));

  if (!(mu > 0. && bulk > 0.)) return 1;
  if ((int)point->physics_parameter[SPLIT] == SPECTRAL) return DivideSpectral(mu, bulk, parts);
  parts->drive = ScalarScale(0.25 / mu, SymDot(&dev, &dev));
  parts->plus  = shrinks ? dev : parts->tau;
  if (!shrinks) parts->drive = ScalarAdd(parts->drive, ScalarScale(0.5 / bulk, ScalarSquare(mean)));
  return 0;
}

/* Non-zero where the law has no answer. */
MPM_FN int Divide(const MpmKernelPoint *point, const Tensor *dF, Parts *parts)
{
  const Scalar J = SolidNewVolume(point, dF);
  int          shrinks;

  if (!(ScalarValue(J) > 0.) || SolidStress(point, dF, &parts->tau)) return 1;
  shrinks = (int)point->physics_parameter[SPLIT] == VOLUMETRIC && ScalarValue(J) < 1.;
  return point->material.info->energy ? DivideEnergy(point, dF, J, shrinks, parts)
                                      : DivideStress(point, shrinks, parts);
}

/* psi+ as damage sees it. */
MPM_FN Scalar Drive(const MpmKernelPoint *point, Scalar drive)
{
  const double most = point->own_n[STATE_HISTORY];

  if ((int)point->physics_parameter[IRREVERSIBLE] == HISTORY && ScalarValue(drive) < most) return ScalarConstant(most);
  return drive;
}

/* G_c/(c_w l), J/m3 */
MPM_FN double Density(const double *physics)
{
  return physics[TOUGHNESS] / physics[LENGTH] * ((int)physics[REGULARISATION] == AT1 ? 3. / 8. : 0.5);
}

/* d is at least this much, and at most 1: above, the stiffness would come back. Points of the first step have
   dissipated nothing yet. */
MPM_FN double Least(const MpmKernelPoint *point)
{
  if ((int)point->physics_parameter[IRREVERSIBLE] == HISTORY) return 0.;
  return point->own_n[STATE_FRACTURE] > 0. ? point->own_n[STATE_START] : fmin(fmax(point->value_n[0], 0.), 1.);
}

/* Where d is outside of these, the bound and the stiffness of the spring to it; 0 elsewhere. */
MPM_FN double Held(const MpmKernelPoint *point, double d, double *bound)
{
  const double least = Least(point);

  *bound = d < least ? least : 1.;
  return d < least || d > 1. ? Density(point->physics_parameter) / point->physics_parameter[TOLERANCE] : 0.;
}

/* Fluxes of d and of its gradient; the energy of fracture is kept where somebody asks. */
MPM_FN void DamageFlux(const MpmKernelPoint *point, const Scalar input[], Scalar drive, Scalar flux[])
{
  const double *physics = point->physics_parameter, density = Density(physics), scale = physics[SCALE] * point->volume0;
  const double  length = 2. * density * physics[LENGTH] * physics[LENGTH];
  const int     first  = (int)physics[REGULARISATION] == AT1;
  const Scalar  d      = input[D];
  const Scalar  sound  = ScalarShift(ScalarNeg(d), 1.);
  Scalar        sum, initial[MPM_DIM];
  double        held, bound, square = 0.;

  sum     = ScalarScale(-2. * (1. - physics[RESIDUAL]), ScalarMul(sound, drive));
  sum     = ScalarAdd(sum, first ? ScalarConstant(density) : ScalarScale(2. * density, d));
  held    = Held(point, ScalarValue(d), &bound);
  sum     = ScalarAdd(sum, ScalarScale(held, ScalarShift(d, -bound)));
  flux[D] = ScalarScale(scale, sum);
  for (int c = 0; c < MPM_DIM; c++) {
    initial[c] = ScalarConstant(0.);
    for (int b = 0; b < MPM_DIM; b++) ScalarAddScaled(&initial[c], point->F_n[b * MPM_DIM + c], &input[GRAD_D + b]);
    square += ScalarValue(initial[c]) * ScalarValue(initial[c]);
  }
  for (int b = 0; b < MPM_DIM; b++) {
    flux[GRAD_D + b] = ScalarConstant(0.);
    for (int c = 0; c < MPM_DIM; c++)
      ScalarAddScaled(&flux[GRAD_D + b], scale * length * point->F_n[b * MPM_DIM + c], &initial[c]);
  }
  if (point->end.F) {
    const double value = ScalarValue(d);

    point->end.own[STATE_START]    = Least(point);
    point->end.own[STATE_FRACTURE] = density * (first ? value : value * value) + 0.5 * length * square;
  }
}

/* g(d) - 1 */
MPM_FN Scalar Loss(const MpmKernelPoint *point, Scalar d)
{
  return ScalarScale(1. - point->physics_parameter[RESIDUAL], ScalarMul(d, ScalarShift(d, -2.)));
}

MPM_FN int DamageFluxes(const MpmKernelPoint *point, const Scalar input[], Parts *parts, Scalar flux[])
{
  const Tensor dF   = TensorFromGradient(input);
  const Scalar loss = Loss(point, input[D]);
  Sym          total, lost;

  if (Divide(point, &dF, parts)) return 1;
  lost  = SymScale(loss, &parts->plus);
  total = SymAdd(&parts->tau, &lost);
  SolidFlux(point, &total, &dF, flux);
  DamageFlux(point, input, Drive(point, parts->drive), flux);
  SolidKeep(point, &total, &dF);
  if (point->end.F) point->end.own[STATE_HISTORY] = fmax(point->own_n[STATE_HISTORY], ScalarValue(parts->drive));
  return 0;
}

#if MPM_DIRECTIONS < 2
static int DamageKernel(const MpmKernelPoint *point, const Scalar input[], Scalar flux[])
{
  Parts parts;

  return DamageFluxes(point, input, &parts, flux);
}
#else
/*
  With directions for dF alone, which is what laws are compiled for; `staggered` leaves out what dF does to d. On its
  lower bound d has any stiffness from none to the spring's, of which that of AT2 is taken: a body that is sound by AT1
  has no other against one change of d everywhere, and a tangent without it is singular.
*/
static int DamageKernelTangent(const MpmKernelPoint *point, const double input[], double flux[], double tangent[])
{
  const double *physics = point->physics_parameter, density = Density(physics), scale = physics[SCALE] * point->volume0;
  const double  length = 2. * density * physics[LENGTH] * physics[LENGTH], rest = 1. - physics[RESIDUAL];
  const int     coupled = (int)physics[SCHEME] == MONOLITHIC && !(point->material.traits & MPM_POINT_ALTERNATE);
  Scalar        in[INPUTS], out[INPUTS], plus[GRADIENTS];
  double        bend, bound;
  Tensor        dF;
  Parts         parts;

  for (int k = 0; k < INPUTS; k++) in[k] = k < GRADIENTS ? ScalarSeed(input[k], k) : ScalarConstant(input[k]);
  if (DamageFluxes(point, in, &parts, out)) return 1;
  dF = TensorFromGradient(in);
  SolidFlux(point, &parts.plus, &dF, plus);
  for (int k = 0; k < INPUTS; k++) {
    flux[k] = ScalarValue(out[k]);
    for (int l = 0; l < GRADIENTS; l++) tangent[k * INPUTS + l] = k < D || coupled ? ScalarDirection(out[k], l) : 0.;
    for (int l = GRADIENTS; l < INPUTS; l++) tangent[k * INPUTS + l] = 0.;
  }
  for (int k = 0; k < GRADIENTS; k++) tangent[k * INPUTS + D] = 2. * rest * (input[D] - 1.) * ScalarValue(plus[k]);
  bend = 2. * rest * ScalarValue(Drive(point, parts.drive)) + Held(point, input[D], &bound);
  if ((int)physics[REGULARISATION] == AT2 || input[D] == Least(point)) bend += 2. * density;
  tangent[D * INPUTS + D] = scale * bend;
  for (int a = 0; a < MPM_DIM; a++) {
    for (int b = 0; b < MPM_DIM; b++) {
      double sum = 0.;

      for (int c = 0; c < MPM_DIM; c++) sum += point->F_n[a * MPM_DIM + c] * point->F_n[b * MPM_DIM + c];
      tangent[(GRAD_D + a) * INPUTS + GRAD_D + b] = scale * length * sum;
    }
  }
  return 0;
}
#endif

MPM_KERNEL_TANGENT(damage, INPUTS, DamageKernel, DamageKernelTangent)

#ifdef MPM_PHYSICS
static const MpmField fields[] = {
  {.name = "displacement", .gradient = 1, .increment = 1, .unit = "m", .near_null = MPM_NEAR_NULL_RIGID},
  {.name       = "damage",
   .components = 1,
   .value      = 1,
   .gradient   = 1,
   .rate       = 1,
   .symbol     = "d",
   .unit       = "-",
   .near_null  = MPM_NEAR_NULL_CONSTANT,
   .scale      = MPM_SCALE_ONE}};

/* clang-format off */
static const MpmParameter parameters[] = {
  {MPM_NUMBER, "toughness", "J/m2", 0., 1, 0., HUGE_VAL, 1, "critical energy release rate", NULL, 100., NULL},
  {MPM_NUMBER, "length", "m", 0., 1, 0., HUGE_VAL, 1,
   "characteristic length of damage, at least two cells", NULL, 0.5, NULL},
  {MPM_NUMBER, "residual", "-", 1e-6, 0, 0., 1., 0,
   "part of the stiffness that stays where the material is broken", NULL, 1e-6, NULL},
  {MPM_WORD, "regularisation", "-", AT2, 0, 0., 0., 0,
   "sound below a stress, or damage from the first load on", "at1|at2", 0., NULL},
  {MPM_WORD, "split", "-", VOLUMETRIC, 0, 0., 0., 0,
   "energy that does no damage: of compressed volume, none, or that of shortening along principal directions",
   "volumetric|none|spectral", 0., NULL},
};
static const MpmCommonParameter common[] = {
  {"damage", {MPM_WORD, "scheme", "-", MONOLITHIC, 0, 0., 0., 0, "both fields at once, or in turn",
              "monolithic|staggered", 0., NULL}},
  {"damage", {MPM_WORD, "irreversible", "-", BOUNDS, 0, 0., 0., 0, "no healing by a bound, or by the largest energy",
              "bounds|history", 0., NULL}},
  {"damage", {MPM_NUMBER, "tolerance", "-", 1e-6, 0, 0., 1., 1, "gap at bounds of the damage", NULL, 1e-6, NULL}},
  {"damage", {MPM_NUMBER, "scale", "-", 1., 0, 0., HUGE_VAL, 1, "factor of the equation of damage", NULL, 1., NULL}},
};
/* clang-format on */
static const MpmStateVariable states[] = {{"history", MPM_STATE_SCALAR, 0., "J/m3"},
                                          {"fracture_energy", MPM_STATE_SCALAR, 0., "J/m3"},
                                          {"damage_start", MPM_STATE_SCALAR, 0., "-"}};

static const char *DamagePrepare(const MpmPhysicsMaterial *material, double gravity, double *value)
{
  (void)gravity;
  if ((int)value[SPLIT] == SPECTRAL && (material->info->energy || !(material->info->traits & MPM_LAW_FIXED_MODULI)))
    return "split: the law is not linear in small or logarithmic strain, must be volumetric or none";
  if (material->info->energy && !material->info->volumetric && (int)value[SPLIT] == VOLUMETRIC)
    return "split: the law does not divide its energy by volume, must be none";
  if (!material->info->energy && !material->info->shear_modulus) return "toughness: the law has no elastic energy";
  return NULL;
}

/* Energy of a step in d, and of its gradient over a cell. */
static double DamageGhost(const MpmPhysicsMaterial *material, const double *value, double dt, double h)
{
  (void)material, (void)dt;
  return 2. * value[SCALE] * Density(value) * (h * h + value[LENGTH] * value[LENGTH]);
}

MPM_PHYSICS(damage, .summary = "solid that breaks: displacement and damage (phase-field fracture)",
            .field_count = MPM_ROWS(fields), .fields = fields, .parameter_count = MPM_ROWS(parameters),
            .parameters = parameters, .common_count = MPM_ROWS(common), .common = common,
            .state_count = MPM_ROWS(states), .states = states, .traits = MPM_PHYSICS_ALTERNATE,
            .prepare = DamagePrepare, .ghost = DamageGhost)
#endif

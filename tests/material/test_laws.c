/*
  Conformance suite: what every registered law must fulfil, whatever it models. Each test runs over all laws, with
  parameters and states drawn at random from fixed seeds; plastic states are reached by random paths.
*/
#include "laws.h"
#include "../checks.h"
#include "law_plugin.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { SAMPLES = 60 };

Suite *LawValuesSuite(void);
Suite *LawSensitivitySuite(void);

static int IsSmallStrain(const Law *law)
{
  return (law->info[PLAIN].traits & MPM_LAW_SMALL_STRAIN) != 0;
}

/* A law's random point after a random path that leaves some points elastic and takes others far into plasticity */
static void Sample(const Law *law, int sample, Point *point)
{
  PointCreate(law, sample % 2, point);
  PointRandomPath(point, sample % 4, pow(10., RandomUniform(-3.5, -1.5)));
}

#define CHECK_SMALL(value, bound, what) \
  ck_assert_msg((value) <= (bound), "%s, sample %d: %s %.3e, accepted %.3e", law->info[PLAIN].name, sample, what, \
                (double)(value), (double)(bound))

/* Tables that the engine relies on */
START_TEST(test_tables)
{
  const Law        *law     = LawGet(_i);
  const MpmLawInfo *info    = &law->info[PLAIN];
  const int         density = LawParameter(law, "density");
  Point             point;

  ck_assert(info->name && info->summary && info->stiffness && info->law);
  ck_assert(info->shear_modulus || info->traits & MPM_LAW_VISCOUS);
  ck_assert(!info->viscosity || info->traits & MPM_LAW_VISCOUS);
  ck_assert_int_ge(density, 0);
  ck_assert(!info->parameters[density].required && info->parameters[density].fallback == 0.);
  ck_assert(info->parameter_count <= MAX_PARAMETERS && LawStateSize(law) + 1 <= MAX_STATE);
  for (size_t p = 0; p < info->parameter_count; ++p) {
    const MpmParameter *parameter = &info->parameters[p];

    ck_assert(parameter->name && parameter->unit && parameter->help && parameter->lower <= parameter->upper);
    ck_assert((parameter->kind == MPM_WORD) == (parameter->choices != NULL));
    ck_assert(parameter->kind != MPM_TABLE || strchr(parameter->unit, ':'));
    ck_assert(parameter->required || parameter->kind >= MPM_TABLE ||
              (parameter->fallback >= parameter->lower && parameter->fallback <= parameter->upper));
  }
  RandomSeed(1);
  PointCreate(law, 0, &point);
  ck_assert(PointStiffness(&point) > 0.);
}
END_TEST

/* Moduli that are claimed to be the same at all states are */
START_TEST(test_fixed_moduli)
{
  const Law *law = LawGet(_i);

  RandomSeed(16);
  for (int sample = 0; sample < SAMPLES && law->info[PLAIN].traits & MPM_LAW_FIXED_MODULI; ++sample) {
    Point point;

    Sample(law, sample, &point);
    ck_assert(PointStiffnessAt(&point) == PointStiffness(&point));
    ck_assert(PointShearModulus(&point, 0) == PointShearModulus(&point, 1));
  }
}
END_TEST

/* Laws that claim to know of F_n its determinant only answer the same with another one. */
START_TEST(test_volume_alone)
{
  const Law *law = LawGet(_i);

  RandomSeed(17);
  for (int sample = 0; sample < SAMPLES && law->info[PLAIN].traits & MPM_LAW_VOLUME; ++sample) {
    double dF[DIM2], tau[SYM], other[SYM];
    Point  point;

    Sample(law, sample, &point);
    RandomMatrix(1e-3, dF);
    if (PointEvaluate(&point, PLAIN, dF, tau, NULL)) continue;
    for (int i = 0; i < DIM; ++i)
      point.F[i * DIM + 1] += 0.7 * point.F[i * DIM]; /* sheared before all that it has been through */
    ck_assert_int_eq(PointEvaluate(&point, PLAIN, dF, other, NULL), 0);
    CHECK_SMALL(MaxDifference(SYM, tau, other), 1e-12 * PointStiffnessAround(&point, dF), "stress depends on F_n by");
  }
}
END_TEST

/* Central difference of tau by component c of dF, step h */
static void Difference(const Point *point, const double *dF, int c, double h, double *derivative)
{
  double moved[DIM2], plus[SYM], minus[SYM];

  memcpy(moved, dF, sizeof moved);
  moved[c] = dF[c] + h;
  ck_assert_int_eq(PointEvaluate(point, PLAIN, moved, plus, NULL), 0);
  moved[c] = dF[c] - h;
  ck_assert_int_eq(PointEvaluate(point, PLAIN, moved, minus, NULL), 0);
  for (int i = 0; i < SYM; ++i) derivative[i] = (plus[i] - minus[i]) / (2. * h);
}

/* Two Richardson extrapolations from steps h, h/2, h/4; their difference in *doubt tells a kink between the stencil's
   points */
static void Extrapolate(const Point *point, const double *dF, int c, double *derivative, double *doubt)
{
  const double h = 4e-5;
  double       D[3][SYM], coarse[SYM];

  for (int k = 0; k < 3; ++k) Difference(point, dF, c, h / (1 << k), D[k]);
  for (int i = 0; i < SYM; ++i) {
    coarse[i]     = (4. * D[1][i] - D[0][i]) / 3.;
    derivative[i] = (4. * D[2][i] - D[1][i]) / 3.;
  }
  *doubt = MaxDifference(SYM, coarse, derivative);
}

/* Compares the tangent at dF with finite differences, columns with a kink apart, which are counted */
static void CheckTangent(const Point *point, const double *dF, int sample, int *columns, int *kinks)
{
  const Law   *law       = point->law;
  const double stiffness = PointStiffnessAround(point, dF);
  double       tau[SYM], dtau[SYM * DIM2];

  ck_assert_int_eq(PointEvaluate(point, ALL_DIRECTIONS, dF, tau, dtau), 0);
  for (int c = 0; c < DIM2; ++c) {
    double derivative[SYM], column[SYM], doubt;

    Extrapolate(point, dF, c, derivative, &doubt);
    ++*columns;
    if (doubt > 1e-8 * stiffness) {
      ++*kinks;
      continue;
    }
    for (int i = 0; i < SYM; ++i) column[i] = dtau[i * DIM2 + c];
    CHECK_SMALL(MaxDifference(SYM, column, derivative), 2e-8 * stiffness, "tangent minus finite difference");
  }
}

START_TEST(test_tangent_against_differences)
{
  const Law *law     = LawGet(_i);
  int        columns = 0, kinks = 0;

  RandomSeed(2);
  for (int sample = 0; sample < SAMPLES; ++sample) {
    Point  point;
    double dF[DIM2];

    Sample(law, sample, &point);
    RandomMatrix(0.02, dF);
    CheckTangent(&point, dF, sample, &columns, &kinks);
  }
  ck_assert_msg(10 * kinks <= columns, "%s: %d of %d columns left out", law->info[PLAIN].name, kinks, columns);
}
END_TEST

START_TEST(test_instances_agree)
{
  const Law *law = LawGet(_i);

  RandomSeed(3);
  for (int sample = 0; sample < SAMPLES; ++sample) {
    Point  point;
    double dF[DIM2], tau[3][SYM], dtau[3][SYM * DIM2], stiffness;

    Sample(law, sample, &point);
    RandomMatrix(0.02, dF);
    stiffness = PointStiffnessAround(&point, dF);
    for (int k = 0; k < 3; ++k) ck_assert_int_eq(PointEvaluate(&point, k, dF, tau[k], dtau[k]), 0);
    CHECK_SMALL(MaxDifference(SYM, tau[0], tau[2]), 4e-15 * stiffness, "stress, plain minus dual");
    CHECK_SMALL(MaxDifference(SYM, tau[1], tau[2]), 4e-15 * stiffness, "stress, one minus all directions");
    CHECK_SMALL(MaxDifference(SYM * DIM2, dtau[1], dtau[2]), 1e-14 * stiffness, "tangent, one minus all directions");
  }
}
END_TEST

/* History goes to `state` alone, only when it is wanted, and does not change the stress. */
START_TEST(test_history_access)
{
  const Law *law  = LawGet(_i);
  const int  size = LawStateSize(law);

  RandomSeed(4);
  for (int sample = 0; sample < SAMPLES; ++sample) {
    Point       point, before;
    double      dF[DIM2], tau[2][SYM], state[MAX_STATE];
    MpmLawTable table[MAX_PARAMETERS];
    MpmLawInput input;

    Sample(law, sample, &point);
    memset(state, 0, sizeof state);
    for (int i = 0; i < MAX_STATE; ++i) state[i] = -777.;
    memcpy(&before, &point, sizeof point);
    RandomMatrix(0.02, dF);
    ck_assert_int_eq(PointEvaluate(&point, PLAIN, dF, tau[0], NULL), 0);
    input = PointInput(&point, dF, table);
    ck_assert_int_eq(law->tangent[PLAIN](&law->info[PLAIN], &input, state, tau[1], NULL), 0);
    ck_assert_int_eq(memcmp(&before, &point, sizeof point), 0);
    ck_assert_mem_eq(tau[0], tau[1], sizeof tau[0]);
    for (int i = 0; i < size; ++i) ck_assert_msg(state[i] != -777., "state %d is not written", i);
    ck_assert_msg(state[size] == -777., "written beyond the state");
  }
}
END_TEST

/* The largest difference of two histories, pressures by the stiffness */
static double StateDifference(const Point *point, const double *a, const double *b)
{
  double difference[MAX_STATE];

  for (int i = 0; i < LawStateSize(point->law); ++i) difference[i] = (a[i] - b[i]) / PointStateUnit(point, i);
  return MaxNorm(LawStateSize(point->law), difference);
}

/* How much more than dF the history of a step from here changes, in the measure of StateDifference(); at least 1 */
static double StateSlope(const Point *point, const double *dF)
{
  const Law           *law         = point->law;
  const MpmSensitivity sensitivity = (MpmSensitivity)law->info[SENSITIVITY].law;
  MpmLawTable          table[MAX_PARAMETERS];
  const MpmLawInput    input = PointInput(point, dF, table);
  double               tau[2][SYM], state[2][MAX_STATE], largest = 1.;
  const MpmLawOutput   value = {tau[0], state[0]}, derivative = {tau[1], state[1]};

  for (int c = 0; c < DIM2; ++c) {
    double      unit[DIM2] = {0.};
    MpmLawInput direction  = {.dF = unit};

    unit[c] = 1.;
    if (sensitivity(&input, &direction, &value, &derivative)) return 1.;
    for (int i = 0; i < LawStateSize(law); ++i) largest = fmax(largest, fabs(state[1][i]) / PointStateUnit(point, i));
  }
  return largest;
}

static void RotateStates(const Law *law, const double *R, const double *state, double *rotated)
{
  memcpy(rotated, state, (size_t)LawStateSize(law) * sizeof(double));
  for (size_t s = 0, offset = 0; s < law->info[PLAIN].state_count; ++s) {
    const int sym = law->info[PLAIN].states[s].kind == MPM_STATE_SYM;

    if (sym) SymRotate(R, &state[offset], &rotated[offset]);
    offset += sym ? (size_t)SYM : 1;
  }
}

/* A rotation after the step turns stress and history along; one before the step (of F_n and the spatial history) as
   well. */
START_TEST(test_objectivity)
{
  const Law *law = LawGet(_i);

  if (IsSmallStrain(law)) return;
  RandomSeed(5);
  for (int sample = 0; sample < SAMPLES; ++sample) {
    Point  point, after, before;
    double dF[DIM2], R[DIM2], RdF[DIM2], tau[SYM], turned[SYM], stiffness, slope, states[MAX_STATE];

    Sample(law, sample, &point);
    RandomMatrix(0.02, dF);
    stiffness = PointStiffnessAround(&point, dF);
    slope     = StateSlope(&point, dF); /* a softening law's history is more sensitive than its stress */
    RandomRotation(R);
    after = before = point;
    Multiply(R, dF, RdF);
    ck_assert_int_eq(PointStep(&after, RdF, turned), 0);
    Multiply(R, point.F, before.F);
    RotateStates(law, R, point.state, before.state);
    ck_assert_int_eq(PointStep(&point, dF, tau), 0);
    SymRotate(R, tau, tau);
    RotateStates(law, R, point.state, states);
    CHECK_SMALL(MaxDifference(SYM, tau, turned), 1e-13 * stiffness, "stress after a rotated step");
    CHECK_SMALL(StateDifference(&point, states, after.state), 1e-13 * slope, "history after a rotated step");
    for (int i = 0; i < DIM; ++i) /* R dF R^T */
      for (int j = 0; j < DIM; ++j) {
        dF[i * DIM + j] = 0.;
        for (int k = 0; k < DIM; ++k) dF[i * DIM + j] += RdF[i * DIM + k] * R[j * DIM + k];
      }
    ck_assert_int_eq(PointStep(&before, dF, turned), 0);
    CHECK_SMALL(MaxDifference(SYM, tau, turned), 1e-13 * stiffness, "stress from a rotated start");
    CHECK_SMALL(StateDifference(&point, states, before.state), 1e-13 * slope, "history from a rotated start");
  }
}
END_TEST

/* At rest every law with E and nu is Hooke's: the tangent exactly, the stress at a tiny strain up to its square and
   rounding. */
START_TEST(test_elastic_limit)
{
  const Law *law = LawGet(_i);
  const int  E = LawParameter(law, "E"), nu = LawParameter(law, "nu");

  if (E < 0 || nu < 0) return;
  RandomSeed(6);
  for (int sample = 0; sample < SAMPLES; ++sample) {
    const double strains[] = {1e-7, 1e-12};
    double       dF[DIM2], tau[SYM], dtau[SYM * DIM2], hooke[SYM], column[SYM], stiffness;
    Point        point;

    PointCreate(law, 0, &point);
    stiffness = PointStiffness(&point);
    Identity(dF);
    ck_assert_int_eq(PointEvaluate(&point, ALL_DIRECTIONS, dF, tau, dtau), 0);
    CHECK_SMALL(MaxNorm(SYM, tau), 0., "stress at rest");
    for (int c = 0; c < DIM2; ++c) {
      double H[DIM2] = {0.};

      H[c] = 1.;
      Hooke(point.parameter[E], point.parameter[nu], H, hooke);
      for (int i = 0; i < SYM; ++i) column[i] = dtau[i * DIM2 + c];
      CHECK_SMALL(MaxDifference(SYM, column, hooke), 1e-14 * stiffness, "tangent at rest");
    }
    for (int k = 0; k < 2; ++k) {
      RandomMatrix(strains[k], dF);
      ck_assert_int_eq(PointEvaluate(&point, PLAIN, dF, tau, NULL), 0);
      for (int i = 0; i < DIM2; ++i) dF[i] -= i % (DIM + 1) == 0; /* exact */
      Hooke(point.parameter[E], point.parameter[nu], dF, hooke);
      CHECK_SMALL(MaxDifference(SYM, tau, hooke), (5e-15 + 10. * strains[k] * strains[k]) * stiffness, "tiny strain");
    }
  }
}
END_TEST

/* R diag(stretches) */
static void Stretch(const double *R, double x, double y, double z, double *dF)
{
  const double stretches[3] = {x, y, z};

  for (int i = 0; i < DIM2; ++i) dF[i] = R[i] * stretches[i % DIM];
}

/*
  Principal values that are equal, or differ by anything from rounding to 1e-4: the tangent must be finite, close to
  that of the equal ones, and that one right.
*/
START_TEST(test_equal_principal_values)
{
  const Law   *law    = LawGet(_i);
  const double base[] = {1., 0.97, 0.9, 1.002};
  int          sample = 0, columns[2] = {0}, kinks[2] = {0}; /* at rest, where a law may just yield, and elsewhere */

  RandomSeed(7);
  for (int k = 0; k < 8; ++k) {
    const double x = base[k % 4], z = k < 4 ? x : 0.98 * x;
    double       R[DIM2], dF[DIM2], tau[SYM], equal[SYM * DIM2], near[SYM * DIM2], stiffness;
    Point        point;

    PointCreate(law, 0, &point);
    if (k % 2) RandomRotation(R);
    else Identity(R);
    Stretch(R, x, x, z, dF);
    stiffness = PointStiffnessAround(&point, dF);
    ck_assert_int_eq(PointEvaluate(&point, ALL_DIRECTIONS, dF, tau, equal), 0);
    CheckTangent(&point, dF, sample, &columns[x != 1.], &kinks[x != 1.]);
    for (double delta = 1e-16; delta < 2e-4; delta *= 3., ++sample) {
      Stretch(R, x * (1. + delta), x, z * (1. - 0.5 * delta), dF);
      ck_assert_int_eq(PointEvaluate(&point, ALL_DIRECTIONS, dF, tau, near), 0);
      /* a plastic law has a kink where the deviator, 0 at first, reaches its strength */
      if (z == x && delta > 1e-6) continue;
      CHECK_SMALL(MaxDifference(SYM * DIM2, near, equal), (1e-13 + 2000. * delta) * stiffness, "change of the tangent");
      if (sample % 4 == 0 && delta < 1e-6) CheckTangent(&point, dF, sample, &columns[x != 1.], &kinks[x != 1.]);
    }
  }
  ck_assert_int_le(10 * kinks[1], columns[1]);
}
END_TEST

/*
  The stiffness at a state is that at rest there, and bounds the tangent: to 20 per cent, for a principal axis may lie
  askew and a tangent by dF is not one by logarithms.
*/
START_TEST(test_stiffness)
{
  const Law *law = LawGet(_i);

  RandomSeed(12);
  for (int sample = 0; sample < SAMPLES; ++sample) {
    Point  point;
    double dF[DIM2], tau[SYM], dtau[SYM * DIM2], stiffness;

    PointCreate(law, sample % 2, &point);
    stiffness = PointStiffness(&point);
    CHECK_SMALL(fabs(PointStiffnessAt(&point) - stiffness), 4e-15 * stiffness, "stiffness at rest");
    PointRandomPath(&point, 1 + sample % 4, pow(10., RandomUniform(-3.5, -0.8)));
    Identity(dF);
    stiffness = PointStiffnessAt(&point);
    ck_assert_int_eq(PointEvaluate(&point, ALL_DIRECTIONS, dF, tau, dtau), 0);
    for (int a = 0; a < DIM; ++a)
      CHECK_SMALL(dtau[a * DIM2 + a * (DIM + 1)], 1.2 * stiffness, "tangent, by the stiffness at the state");
  }
}
END_TEST

/*
  A small step and back again; 0 where the stress does not come back: not elastic. Where it does, `tau` becomes its change.
*/
static int IsReversible(const Point *point, const double *dF, const double *back, double *tau)
{
  double start[SYM], end[SYM], rest[DIM2];
  Point  moved = *point;

  Identity(rest);
  if (PointEvaluate(point, PLAIN, rest, start, NULL) || PointStep(&moved, dF, tau) || PointStep(&moved, back, end))
    return 0;
  if (MaxDifference(SYM, start, end) > 1e-12 * PointStiffnessAt(point)) return 0;
  for (int i = 0; i < SYM; ++i) tau[i] -= start[i];
  return 1;
}

/* Whether the point keeps its state at rest and answers small changes of volume, both ways, elastically */
static int IsInside(const Point *point)
{
  double dF[DIM2], back[DIM2], tau[SYM];

  for (int k = -1; k <= 1; ++k) {
    const double strain = k * 1e-6;

    Identity(dF);
    Identity(back);
    for (int i = 0; i < DIM; ++i) {
      dF[i * (DIM + 1)]   = 1. + strain;
      back[i * (DIM + 1)] = 1. / (1. + strain);
    }
    if (!IsReversible(point, dF, back, tau)) return 0;
    if (k && !((tau[0] + tau[1] + tau[2]) / strain > 1e-3 * PointStiffnessAt(point))) return 0;
  }
  return 1;
}

/* Slope of the shear stress in the plane i, j over a small shear strain of this sign; 0 where that is not elastic */
static double ShearSlope(const Point *point, int i, int j, double sign)
{
  const double gamma = sign * 1e-6, length = 1. / (1. - 0.25 * gamma * gamma);
  double       dF[DIM2], back[DIM2], tau[SYM];

  Identity(dF);
  Identity(back);
  dF[i * DIM + j] = dF[j * DIM + i] = 0.5 * gamma;
  back[i * DIM + j] = back[j * DIM + i] = -0.5 * gamma * length;
  back[i * DIM + i] = back[j * DIM + j] = length;
  return IsReversible(point, dF, back, tau) ? tau[SymAt(i, j)] / gamma : 0.;
}

/*
  The shear modulus is that at rest, positive, bounded by the stiffness, and the mean slope of shear stresses wherever small
  shears are elastic, up to the square of the strain. Plane strain has one of the three planes only.
*/
START_TEST(test_shear_modulus)
{
  const Law *law        = LawGet(_i);
  const int  exact      = DIM == 3 && !IsSmallStrain(law); /* a small strain is not one from the state's shape */
  int        elastic[2] = {0};

  if (!law->info[PLAIN].shear_modulus) return;
  RandomSeed(13);
  for (int sample = 0; sample < SAMPLES; ++sample) {
    const double amplitude = 5e-4 * (sample % 4);
    double       sum       = 0., modulus;
    int          planes    = 0;
    Point        point;

    PointCreate(law, 0, &point); /* without any strength no shear is elastic */
    modulus = PointShearModulus(&point, 1);
    CHECK_SMALL(fabs(PointShearModulus(&point, 0) - modulus), 4e-15 * modulus, "shear modulus at rest");
    PointRandomPath(&point, amplitude > 0. ? 2 : 0, amplitude);
    modulus = PointShearModulus(&point, 0);
    for (int i = 0; i < DIM && IsInside(&point); ++i)
      for (int j = i + 1; j < DIM; ++j) {
        double slope = ShearSlope(&point, i, j, 1.);

        if (slope == 0.) slope = ShearSlope(&point, i, j, -1.);
        sum += slope;
        planes += slope != 0.;
      }
    if (planes == (DIM == 2 ? 1 : 3)) {
      const double tolerance = exact ? 200. * amplitude * amplitude : 200. * amplitude;

      CHECK_SMALL(fabs(sum / planes - modulus), (1e-5 + tolerance) * modulus + 1e-9 * PointStiffness(&point),
                  "shear modulus minus slope");
      ++elastic[amplitude > 0.];
    }
    PointRandomPath(&point, 2, pow(10., RandomUniform(-3.5, -0.8)));
    modulus = PointShearModulus(&point, 0);
    ck_assert_msg(modulus > 0., "%s, sample %d: shear modulus %g", law->info[PLAIN].name, sample, modulus);
    CHECK_SMALL(modulus, PointStiffnessAt(&point), "shear modulus, by the stiffness");
  }
  ck_assert_msg(elastic[0] >= SAMPLES / 16 && elastic[1] >= SAMPLES / 8, "%s: only %d and %d elastic samples",
                law->info[PLAIN].name, elastic[0], elastic[1]);
}
END_TEST

enum { NEWTON_SIZE = MPM_DIM == 2 ? 3 : 6 };

/* r = tau(I + H) + k H and A = dr/dH for a symmetric H of components xx, yy, xy(, zz, yz, xz) */
static void NewtonSystem(const Point *point, double k, const double *H, double *r, double *A)
{
  const int at[6][2] = {{0, 0}, {1, 1}, {0, 1}, {2, 2}, {1, 2}, {0, 2}};
  double    dF[DIM2], tau[SYM], dtau[SYM * DIM2];

  Identity(dF);
  for (int a = 0; a < NEWTON_SIZE; ++a) {
    const int i = at[a][0], j = at[a][1];

    dF[i * DIM + j] = dF[j * DIM + i] = H[a] + (i == j);
  }
  ck_assert_int_eq(PointEvaluate(point, ALL_DIRECTIONS, dF, tau, dtau), 0);
  for (int a = 0; a < NEWTON_SIZE; ++a) {
    const int component = SymAt(at[a][0], at[a][1]);

    r[a] = tau[component] + k * H[a];
    for (int b = 0; b < NEWTON_SIZE; ++b) {
      const int     i = at[b][0], j = at[b][1];
      const double *row = &dtau[component * DIM2];

      A[a * NEWTON_SIZE + b] = row[i * DIM + j] + (i == j ? 0. : row[j * DIM + i]) + (a == b ? k : 0.);
    }
  }
}

/*
  Newton's method on tau(I + H) + k H = target, k making it solvable where the law has no stiffness. From nearby it
  must converge as a Newton method does: with a tangent wrong by one per cent it needs twice as many iterations.
*/
static int NewtonIterations(const Point *point, const double *solution, double perturbation)
{
  const double k = 0.3 * PointStiffness(point);
  double       H[NEWTON_SIZE], target[NEWTON_SIZE], r[NEWTON_SIZE], A[NEWTON_SIZE * NEWTON_SIZE];

  NewtonSystem(point, k, solution, target, A);
  for (int a = 0; a < NEWTON_SIZE; ++a) H[a] = solution[a] + perturbation * RandomUniform(-1., 1.);
  for (int iteration = 0; iteration < 20; ++iteration) {
    NewtonSystem(point, k, H, r, A);
    for (int a = 0; a < NEWTON_SIZE; ++a) r[a] -= target[a];
    if (MaxNorm(NEWTON_SIZE, r) <= 1e-13 * k) return iteration;
    Solve(NEWTON_SIZE, A, r);
    for (int a = 0; a < NEWTON_SIZE; ++a) H[a] -= r[a];
  }
  return 20;
}

START_TEST(test_newton_rate)
{
  const Law *law  = LawGet(_i);
  int        slow = 0;

  RandomSeed(8);
  for (int sample = 0; sample < SAMPLES; ++sample) {
    Point  point;
    double H[6];

    Sample(law, sample, &point);
    for (int a = 0; a < 6; ++a) H[a] = 0.02 * RandomUniform(-1., 1.);
    slow += NewtonIterations(&point, H, 1e-4) > 4;
  }
  /* a start on the other side of a kink costs iterations without being wrong */
  ck_assert_msg(20 * slow <= SAMPLES, "%s: %d of %d slow", law->info[PLAIN].name, slow, SAMPLES);
}
END_TEST

/* A committed point at rest keeps its stress, but for what is viscous of it, and its history, unless its strength lags behind. */
START_TEST(test_state_round_trip)
{
  const Law *law = LawGet(_i);

  if (law->info[PLAIN].traits & MPM_LAW_LAGGED) return;
  RandomSeed(9);
  for (int sample = 0; sample < SAMPLES; ++sample) {
    Point  point, again;
    double dF[DIM2], tau[2][SYM], stiffness;

    Sample(law, sample, &point);
    RandomMatrix(0.02, dF);
    stiffness = PointStiffnessAround(&point, dF);
    ck_assert_int_eq(PointStep(&point, dF, tau[0]), 0);
    Identity(dF);
    if (law->info[PLAIN].traits & MPM_LAW_VISCOUS) ck_assert_int_eq(PointStep(&point, dF, tau[0]), 0);
    again = point;
    for (int repeat = 0; repeat < 5; ++repeat) ck_assert_int_eq(PointStep(&again, dF, tau[1]), 0);
    CHECK_SMALL(MaxDifference(SYM, tau[0], tau[1]), 2e-14 * stiffness, "stress at rest");
    CHECK_SMALL(StateDifference(&point, point.state, again.state), 1e-13, "history at rest");
  }
}
END_TEST

/* d(tau dF^{-T})/d(dF) of a law that claims a potential; with a small-strain law d tau/d(dF) itself */
static void PiolaTangent(const Law *law, const double *dF, const double *tau, const double *dtau, double *A)
{
  double inverse[DIM2], P[DIM2];

  for (int j = 0; j < DIM; ++j) { /* column j of dF^{-1} */
    double matrix[DIM2], column[DIM] = {0.};

    memcpy(matrix, dF, sizeof matrix);
    column[j] = 1.;
    Solve(DIM, matrix, column);
    for (int i = 0; i < DIM; ++i) inverse[i * DIM + j] = IsSmallStrain(law) ? i == j : column[i];
  }
  memset(P, 0, sizeof P);
  for (int c = 0; c < DIM2; ++c)
    for (int k = 0; k < DIM; ++k) P[c] += tau[SymAt(c / DIM, k)] * inverse[(c % DIM) * DIM + k];
  for (int r = 0; r < DIM2; ++r) {
    for (int c = 0; c < DIM2; ++c) {
      const int i = r / DIM, j = r % DIM, k = c / DIM, l = c % DIM;

      /* d(F^{-T})_{mj}/dF_kl = -F^{-1}_{jk} F^{-1}_{lm} */
      A[r * DIM2 + c] = IsSmallStrain(law) ? 0. : -P[i * DIM + l] * inverse[j * DIM + k];
      for (int m = 0; m < DIM; ++m) A[r * DIM2 + c] += dtau[SymAt(i, m) * DIM2 + c] * inverse[j * DIM + m];
    }
  }
}

/* As Sample(), of a law that is symmetric by its parameters with such ones: associated flow, and what has another's value
   as its default has it. With others it must say that it is not. */
static void SymmetricSample(const Law *law, int sample, Point *point)
{
  const MpmLawInfo *info     = &law->info[PLAIN];
  const int         friction = LawParameter(law, "friction"), dilation = LawParameter(law, "dilation");
  MpmLawTable       table[MAX_PARAMETERS];

  Sample(law, sample, point);
  if (!info->symmetric) return;
  PointCreate(law, sample % 2, point);
  for (size_t p = 0; p < info->parameter_count; ++p)
    if (info->parameters[p].same_as)
      point->parameter[p] = point->parameter[LawParameter(law, info->parameters[p].same_as)];
  PointInput(point, NULL, table);
  if (friction >= 0 && dilation >= 0 && point->parameter[friction] != point->parameter[dilation]) {
    ck_assert(!info->symmetric(point->parameter, table));
    point->parameter[dilation] = point->parameter[friction];
    for (size_t p = 0; p < info->parameter_count; ++p)
      if (info->parameters[p].same_as)
        point->parameter[p] = point->parameter[LawParameter(law, info->parameters[p].same_as)];
  }
  ck_assert(info->symmetric(point->parameter, table));
  PointRandomPath(point, sample % 4, pow(10., RandomUniform(-3.5, -1.5)));
}

START_TEST(test_symmetry)
{
  const Law *law = LawGet(_i);

  if (!(law->info[PLAIN].traits & MPM_LAW_SYMMETRIC) && !law->info[PLAIN].symmetric) return;
  RandomSeed(10);
  for (int sample = 0; sample < SAMPLES; ++sample) {
    Point  point;
    double dF[DIM2], tau[SYM], dtau[SYM * DIM2], A[DIM2 * DIM2], transposed[DIM2 * DIM2];

    SymmetricSample(law, sample, &point);
    if (IsSmallStrain(law)) Identity(point.F);
    RandomMatrix(0.02, dF);
    ck_assert_int_eq(PointEvaluate(&point, ALL_DIRECTIONS, dF, tau, dtau), 0);
    PiolaTangent(law, dF, tau, dtau, A);
    for (int i = 0; i < DIM2 * DIM2; ++i) transposed[i] = A[i % DIM2 * DIM2 + i / DIM2];
    CHECK_SMALL(MaxDifference(DIM2 * DIM2, A, transposed), 1e-13 * PointStiffness(&point), "asymmetry");
  }
}
END_TEST

/* Inverted, flat and non-finite increments have no stress. */
START_TEST(test_no_answer)
{
  const Law   *law     = LawGet(_i);
  const double wrong[] = {-0.5, 0., NAN, HUGE_VAL, -HUGE_VAL};

  RandomSeed(11);
  for (int k = 0; k < 5; ++k) {
    for (int instance = 0; instance < 3; ++instance) {
      double dF[DIM2], tau[SYM], dtau[SYM * DIM2];
      Point  point;

      Sample(law, k, &point);
      Identity(dF);
      dF[0] = wrong[k];
      ck_assert_msg(PointEvaluate(&point, instance, dF, tau, dtau) != 0, "%s accepts %g", law->info[PLAIN].name, dF[0]);
      Identity(dF);
      dF[1] = wrong[2 + k % 3];
      ck_assert_msg(PointEvaluate(&point, instance, dF, tau, dtau) != 0, "%s accepts %g", law->info[PLAIN].name, dF[1]);
    }
  }
}
END_TEST

/* 100 000 increments, 10 000 under the sanitizers, of up to 20 per cent from wherever paths of them lead: an answer that
   is a number, or a refusal, of which there are fewer than 1 in 100. */
START_TEST(test_large_increments)
{
  const Law *law   = LawGet(_i);
  const int  paths = 10000 / FEWER, steps = 10;
  int        refused = 0;

  RandomSeed(13);
  for (int path = 0; path < paths; ++path) {
    Point point;

    PointCreate(law, path % 2, &point);
    for (int step = 0; step < steps; ++step) {
      double dF[DIM2], tau[SYM];

      RandomMatrix(0.2, dF);
      if (PointStep(&point, dF, tau)) {
        ++refused;
        continue;
      }
      if (!(isfinite(MaxNorm(SYM, tau)) &&
            isfinite(MaxNorm(LawStateSize(law), point.state)))) /* asserting takes time */
        ck_abort_msg("%s, path %d, step %d: not a number", law->info[PLAIN].name, path, step);
    }
  }
  ck_assert_msg(100 * refused < paths * steps, "%s: %d of %d refused", law->info[PLAIN].name, refused, paths * steps);
}
END_TEST

/* History that a law gives for a stress has that stress, be it the Kirchhoff or the Cauchy stress that the law bounds. */
START_TEST(test_history_from_stress)
{
  const Law        *law  = LawGet(_i);
  const MpmLawInfo *info = &law->info[PLAIN];

  if (!info->history) return;
  RandomSeed(14);
  for (int sample = 0; sample < SAMPLES; ++sample) {
    Point       point;
    double      dF[DIM2], wanted[SYM], tau[SYM], strange[SYM];
    MpmLawTable table[MAX_PARAMETERS];

    Sample(law, sample, &point);
    RandomMatrix(5e-3, dF);
    ck_assert_int_eq(PointStep(&point, dF, wanted), 0);
    Identity(dF);
    if (info->traits & MPM_LAW_VISCOUS) ck_assert_int_eq(PointStep(&point, dF, wanted), 0);
    for (int i = 0; i < SYM; ++i) wanted[i] /= fmax(1., Determinant(point.F));
    PointInput(&point, NULL, table);
    ck_assert_int_eq(info->history(point.parameter, table, wanted, point.state), 0);
    Identity(dF);
    Identity(point.F);
    ck_assert_int_eq(PointStep(&point, dF, tau), 0);
    CHECK_SMALL(MaxDifference(SYM, tau, wanted), 1e-13 * PointStiffnessAround(&point, dF), "stress off the wanted one");
    memcpy(strange, wanted, sizeof strange);
    strange[0] = NAN;
    ck_assert_int_ne(info->history(point.parameter, table, strange, point.state), 0);
  }
}
END_TEST

/* Elastic logarithmic strain of a point whose axes are its principal ones, after a stretch. */
static void PrincipalElastic(const Point *point, int b, const double *stretch, double e[3])
{
  for (int a = 0; a < 3; ++a)
    e[a] = 0.5 * log(point->state[b + SymAt(a, a)]) + (stretch && a < DIM ? log(stretch[a * DIM + a]) : 0.);
}

/* sqrt(2/3) |d| of principal values, or of their deviator */
static double Equivalent(const double d[3], int deviator)
{
  const double mean = deviator ? (d[0] + d[1] + d[2]) / 3. : 0.;
  double       sum  = 0.;

  for (int a = 0; a < 3; ++a) sum += (d[a] - mean) * (d[a] - mean);
  return sqrt(2. / 3. * sum);
}

/*
  Laws that flow have the equivalent plastic strain, 0 at first, which never falls. Where the elastic strain is known, a
  step adds sqrt(2/3) |de_p|, of the whole plastic strain that it takes or of its deviator.
*/
START_TEST(test_plastic_strain)
{
  const Law *law   = LawGet(_i);
  const int  alpha = LawState(law, "equivalent_plastic_strain"), b = LawState(law, "elastic_left_cauchy_green");
  int        flows = 0;

  if (!(law->info[PLAIN].traits & MPM_LAW_PLASTIC) || law->info[PLAIN].traits & MPM_LAW_VISCOUS) return;
  ck_assert_msg(alpha >= 0, "%s has no equivalent plastic strain", law->info[PLAIN].name);
  RandomSeed(21);
  for (int sample = 0; sample < SAMPLES; ++sample) {
    Point point;

    PointCreate(law, 0, &point);
    ck_assert(point.state[alpha] == 0.);
    for (int step = 0; step < 6; ++step) {
      const double before   = point.state[alpha];
      double       dF[DIM2] = {0.}, trial[3], end[3], taken[3], tau[SYM], growth;

      for (int a = 0; a < DIM; ++a) dF[a * DIM + a] = 1. + RandomUniform(-1., 1.) * pow(10., RandomUniform(-4., -1.7));
      if (b >= 0) PrincipalElastic(&point, b, dF, trial);
      if (PointStep(&point, dF, tau)) break;
      growth = point.state[alpha] - before;
      flows += growth > 0.;
      ck_assert_msg(growth >= 0., "%s: the plastic strain falls by %g", law->info[PLAIN].name, -growth);
      if (b < 0) continue;
      PrincipalElastic(&point, b, NULL, end);
      for (int a = 0; a < 3; ++a) taken[a] = trial[a] - end[a];
      ck_assert_msg(growth >= Equivalent(taken, 1) * (1. - 1e-8) - 1e-13 &&
                      growth <= Equivalent(taken, 0) * (1. + 1e-8) + 1e-13,
                    "%s: the plastic strain grows by %.10g, flow takes %.10g, %.10g of it without volume",
                    law->info[PLAIN].name, growth, Equivalent(taken, 0), Equivalent(taken, 1));
    }
  }
  ck_assert_int_gt(flows, 0);
}
END_TEST

static Suite *LawsSuite(void)
{
  Suite             *suite   = suite_create(DIM == 2 ? "laws in plane strain" : "laws in 3D");
  TCase             *tcase   = tcase_create("every law");
  const TTest *const tests[] = {test_tables,
                                test_tangent_against_differences,
                                test_instances_agree,
                                test_history_access,
                                test_objectivity,
                                test_elastic_limit,
                                test_equal_principal_values,
                                test_newton_rate,
                                test_state_round_trip,
                                test_symmetry,
                                test_no_answer,
                                test_stiffness,
                                test_shear_modulus,
                                test_fixed_moduli,
                                test_volume_alone,
                                test_large_increments,
                                test_history_from_stress,
                                test_plastic_strain};

  for (size_t t = 0; t < sizeof tests / sizeof tests[0]; ++t) tcase_add_loop_test(tcase, tests[t], 0, LawCount());
  tcase_set_timeout(tcase, 60.);
  suite_add_tcase(suite, tcase);
  return suite;
}

/* Without arguments over the laws of the build, with their values; with PLUGIN.so NAME over that law. */
int main(int argc, char **argv)
{
  SRunner *runner;
  int      failed;

  if (argc == 3 && LawPluginUse(argv[1], argv[2])) return 2;
  runner = srunner_create(LawsSuite());
  if (argc == 1) srunner_add_suite(runner, LawValuesSuite());
  srunner_add_suite(runner, LawSensitivitySuite());
  srunner_set_fork_status(runner, CK_NOFORK);
  srunner_run_all(runner, CK_NORMAL);
  failed = srunner_ntests_failed(runner);
  srunner_free(runner);
  return failed ? EXIT_FAILURE : EXIT_SUCCESS;
}

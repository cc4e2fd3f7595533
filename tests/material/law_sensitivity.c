/*
  Derivatives of stress and new history by everything that a law is given, for every registered law: against Richardson
  differences of the plain form.
*/
#include "laws.h"
#include "../checks.h"
#include <math.h>
#include <string.h>

enum { SAMPLES = 40, LEVELS = 3, MAX_ANSWER = SYM + MAX_STATE };

Suite *LawSensitivitySuite(void);

/* All that the answer depends on, or a direction in it */
typedef struct {
  Point  point;
  double dF[DIM2];
} Setting;

typedef enum { PARAMETER, TABLE, STATE, F_N, D_F, KINDS } Kind;

static const char *const kind_names[KINDS] = {"parameter", "table", "history", "F_n", "dF"};

static int Components(const Law *law, Kind kind)
{
  const int parameters   = (int)law->info[PLAIN].parameter_count;
  const int count[KINDS] = {parameters, parameters * MAX_DATA, LawStateSize(law), DIM2, DIM2};

  return count[kind];
}

/* NULL where there is no such number: words, and numbers of what is no table */
static double *Component(Setting *setting, Kind kind, int k)
{
  const MpmParameter *parameters = setting->point.law->info[PLAIN].parameters;

  switch (kind) {
  case PARAMETER:
    return parameters[k].kind < MPM_WORD ? &setting->point.parameter[k] : NULL;
  case TABLE:
    return parameters[k / MAX_DATA].kind >= MPM_TABLE ? &setting->point.data[k / MAX_DATA][k % MAX_DATA] : NULL;
  case STATE:
    return &setting->point.state[k];
  case F_N:
    return &setting->point.F[k];
  default:
    return &setting->dF[k];
  }
}

/* By how much a component may change so that the answer changes by the order of itself */
static double Scale(const Setting *setting, Kind kind, int k, double value)
{
  const Law          *law       = setting->point.law;
  const MpmParameter *parameter = &law->info[PLAIN].parameters[k];
  double              scale     = kind == TABLE && k % 2 == 0 ? 0.01 : fabs(value);

  if (kind == STATE) return 0.005 * PointStateUnit(&setting->point, k);
  if (kind == F_N || kind == D_F) return 0.005;
  if (kind == TABLE) return scale;
  if (scale == 0.) scale = !strcmp(parameter->unit, "Pa") ? 1e-3 * PointStiffness(&setting->point) : 1.;
  if (isfinite(parameter->upper) && value < parameter->upper) scale = fmin(scale, parameter->upper - value);
  return scale;
}

/* Stress over stiffness, then history by its units: numbers of one size */
static int Answer(const Setting *setting, double *answer)
{
  const Law        *law       = setting->point.law;
  const double      stiffness = PointStiffness(&setting->point);
  MpmLawTable       table[MAX_PARAMETERS];
  const MpmLawInput input  = PointInput(&setting->point, setting->dF, table);
  const int         status = law->tangent[PLAIN](&law->info[PLAIN], &input, answer + SYM, answer, NULL);

  for (int i = 0; i < SYM; ++i) answer[i] /= stiffness;
  for (int i = 0; i < LawStateSize(law); ++i) answer[SYM + i] /= PointStateUnit(&setting->point, i);
  return status;
}

/* The law's own derivative along a direction, in the same measure; also the values */
static int Derivative(const Setting *setting, const Setting *along, double *answer, double *derivative)
{
  const Law           *law         = setting->point.law;
  const MpmSensitivity sensitivity = (MpmSensitivity)law->info[SENSITIVITY].law;
  const double         stiffness   = PointStiffness(&setting->point);
  MpmLawTable          table[MAX_PARAMETERS], table_along[MAX_PARAMETERS];
  const MpmLawInput    input     = PointInput(&setting->point, setting->dF, table);
  MpmLawInput          direction = PointInput(&along->point, along->dF, table_along);
  const MpmLawOutput   value = {answer, answer + SYM}, slope = {derivative, derivative + SYM};
  int                  status;

  direction.dt = 0.;
  status       = sensitivity(&input, &direction, &value, &slope);
  for (int i = 0; i < SYM; ++i) {
    answer[i] /= stiffness;
    derivative[i] /= stiffness;
  }
  for (int i = 0; i < LawStateSize(law); ++i) {
    answer[SYM + i] /= PointStateUnit(&setting->point, i);
    derivative[SYM + i] /= PointStateUnit(&setting->point, i);
  }
  return status;
}

/*
  Central differences with steps h, h/2, h/4, twice extrapolated. *doubt is what the last extrapolation changed: a kink
  between the stencil's points shows in it.
*/
static void Difference(const Setting *setting, Kind kind, int k, double scale, int n, double *derivative, double *doubt)
{
  double D[LEVELS][MAX_ANSWER], plus[MAX_ANSWER], minus[MAX_ANSWER], stiffness = PointStiffness(&setting->point);

  for (int level = 0; level < LEVELS; ++level) {
    const double h     = 1e-2 / (1 << level);
    Setting      moved = *setting;
    double      *x = Component(&moved, kind, k), before = *x, ratio[2];

    *x = before + h * scale;
    ck_assert_int_eq(Answer(&moved, plus), 0);
    ratio[0] = PointStiffness(&moved.point) / stiffness;
    *x       = before - h * scale;
    ck_assert_int_eq(Answer(&moved, minus), 0);
    ratio[1] = PointStiffness(&moved.point) / stiffness;
    for (int i = 0; i < n; ++i) {
      const int stress = i < SYM || PointStateUnit(&setting->point, i - SYM) != 1.;

      D[level][i] = ((stress ? ratio[0] : 1.) * plus[i] - (stress ? ratio[1] : 1.) * minus[i]) / (2. * h);
    }
  }
  for (int i = 0; i < n; ++i) {
    const double coarse = (4. * D[1][i] - D[0][i]) / 3., fine = (4. * D[2][i] - D[1][i]) / 3.;

    derivative[i] = (16. * fine - coarse) / 15.;
    D[0][i]       = fine;
  }
  *doubt = MaxDifference(n, derivative, D[0]);
}

/* Counts of derivatives that were looked at, and of those left out for a kink */
typedef struct {
  int looked, kinks;
} Tally;

static void CheckComponent(const Setting *setting, Kind kind, int k, int sample, Tally *tally)
{
  const Law *law   = setting->point.law;
  const int  n     = SYM + LawStateSize(law);
  Setting    along = {0}, copy = *setting;
  double    *x = Component(&copy, kind, k), scale, answer[MAX_ANSWER], derivative[MAX_ANSWER], doubt, size, error;
  double     expected[MAX_ANSWER];

  if (!x) return;
  along.point.law = law;
  scale           = Scale(setting, kind, k, *x);
  if (kind == PARAMETER && *x - 1e-2 * scale < law->info[PLAIN].parameters[k].lower) return; /* no difference there */
  *Component(&along, kind, k) = scale;
  ck_assert_int_eq(Derivative(setting, &along, answer, derivative), 0);
  Difference(setting, kind, k, scale, n, expected, &doubt);
  size = fmax(1e-3, MaxNorm(n, expected));
  ++tally->looked;
  if (doubt > 1e-8 * size) {
    ++tally->kinks;
    return;
  }
  error = MaxDifference(n, derivative, expected);
  ck_assert_msg(error <= 1e-8 * size, "%s, sample %d: derivative by %s %d is off by %.3e of %.3e",
                law->info[PLAIN].name, sample, kind_names[kind], k, error, size);
}

/* At points that random paths leave elastic or take far into plasticity */
static void Sample(const Law *law, int sample, Setting *setting)
{
  PointCreate(law, sample % 2, &setting->point);
  PointRandomPath(&setting->point, sample % 4, pow(10., RandomUniform(-3.5, -1.5)));
  RandomMatrix(sample % 3 ? 0.02 : 2e-3, setting->dF);
}

START_TEST(test_against_differences)
{
  const Law *law = LawGet(_i);

  for (int kind = 0; kind < KINDS; ++kind) {
    Tally tally = {0, 0};

    RandomSeed(20);
    for (int sample = 0; sample < SAMPLES; ++sample) {
      Setting setting;

      Sample(law, sample, &setting);
      for (int k = 0; k < Components(law, (Kind)kind); ++k) CheckComponent(&setting, (Kind)kind, k, sample, &tally);
    }
    ck_assert_msg(5 * tally.kinks <= tally.looked, "%s, by %s: %d of %d left out", law->info[PLAIN].name,
                  kind_names[kind], tally.kinks, tally.looked);
  }
}
END_TEST

/* The tangent along a direction, in units of the stiffness, with dF changed by a part of itself. */
static void Along(const Setting *setting, const double direction[], double part, double stiffness, double along[SYM])
{
  double dF[DIM2], tau[SYM], dtau[SYM * DIM2];

  for (int c = 0; c < DIM2; ++c) dF[c] = setting->dF[c] * (1. + part);
  ck_assert_int_eq(PointEvaluate(&setting->point, ALL_DIRECTIONS, dF, tau, dtau), 0);
  for (int i = 0; i < SYM; ++i) {
    along[i] = 0.;
    for (int c = 0; c < DIM2; ++c) along[i] += dtau[i * DIM2 + c] * direction[c] / stiffness;
  }
}

/* The values are those of the plain form, and along dF the derivative is the tangent's, but for what rounding of dF does
   to that. */
START_TEST(test_against_other_forms)
{
  const Law *law = LawGet(_i);

  RandomSeed(21);
  for (int sample = 0; sample < SAMPLES; ++sample) {
    Setting setting, along = {0};
    double  answer[MAX_ANSWER], derivative[MAX_ANSWER], plain[MAX_ANSWER], expected[SYM], shaken[SYM], stiff, stiffness;

    Sample(law, sample, &setting);
    along.point.law = law;
    RandomMatrix(1., along.dF);
    ck_assert_int_eq(Derivative(&setting, &along, answer, derivative), 0);
    ck_assert_int_eq(Answer(&setting, plain), 0);
    stiffness = PointStiffness(&setting.point);
    Along(&setting, along.dF, 0., stiffness, expected);
    Along(&setting, along.dF, 4. * DBL_EPSILON, stiffness, shaken);
    stiff = PointStiffnessAround(&setting.point, setting.dF) / stiffness;
    ck_assert_double_le(MaxDifference(SYM + LawStateSize(law), answer, plain), 4e-15 * stiff);
    ck_assert_double_le(MaxDifference(SYM, derivative, expected), 1e-13 * stiff + MaxDifference(SYM, expected, shaken));
  }
}
END_TEST

/* One of the pack's directions, column k of rows */
static void AddColumn(int k, int count, const double *direction, double *rows)
{
  for (int i = 0; i < count; ++i) rows[i * MPM_PACK + k] = direction[i];
}

/* A pack of directions gives what each of them gives alone. */
START_TEST(test_packs)
{
  const Law           *law         = LawGet(_i);
  const MpmSensitivity sensitivity = (MpmSensitivity)law->info[SENSITIVITY].law;
  const int            n = SYM + LawStateSize(law), parameters = (int)law->info[PLAIN].parameter_count;

  RandomSeed(23);
  for (int sample = 0; sample < SAMPLES; ++sample) {
    double parameter[MAX_PARAMETERS * MPM_PACK] = {0.}, state[MAX_STATE * MPM_PACK] = {0.}, F[DIM2 * MPM_PACK];
    double dF[DIM2 * MPM_PACK], answer[MAX_ANSWER], rows[MAX_ANSWER * MPM_PACK], single[MPM_PACK][MAX_ANSWER];
    const MpmLawInput along = {
      .parameter = parameter, .state_n = state, .F_n = F, .dF = dF, .count = MPM_PACK - 1, .stride = MPM_PACK};
    const MpmLawOutput value = {answer, answer + SYM}, slope = {rows, rows + SYM * MPM_PACK};
    MpmLawTable        table[MAX_PARAMETERS];
    Setting            setting, direction = {0};
    MpmLawInput        input;

    Sample(law, sample, &setting);
    direction.point.law = law;
    for (int k = 0; k < MPM_PACK; ++k) {
      for (int kind = 0; kind < KINDS; ++kind) {
        for (int c = 0; c < Components(law, (Kind)kind); ++c) {
          double *x = Component(&direction, (Kind)kind, c), *at = Component(&setting, (Kind)kind, c);

          if (x && kind != TABLE) *x = (RandomUniform(-1., 1.)) * Scale(&setting, (Kind)kind, c, *at);
        }
      }
      AddColumn(k, parameters, direction.point.parameter, parameter);
      AddColumn(k, LawStateSize(law), direction.point.state, state);
      AddColumn(k, DIM2, direction.point.F, F);
      AddColumn(k, DIM2, direction.dF, dF);
      ck_assert_int_eq(Derivative(&setting, &direction, answer, single[k]), 0);
    }
    input = PointInput(&setting.point, setting.dF, table);
    ck_assert_int_eq(sensitivity(&input, &along, &value, &slope), 0);
    for (int k = 0; k < MPM_PACK - 1; ++k) {
      double column[MAX_ANSWER];

      for (int i = 0; i < n; ++i)
        column[i] =
          rows[i * MPM_PACK + k] / (i < SYM ? PointStiffness(&setting.point) : PointStateUnit(&setting.point, i - SYM));
      ck_assert_double_le(MaxDifference(n, column, single[k]), 1e-12 * fmax(1e-3, MaxNorm(n, single[k])));
    }
  }
}
END_TEST

/* No stress where there is none, and history only where it is wanted; what does not change may be NULL. */
START_TEST(test_calls)
{
  const Law           *law         = LawGet(_i);
  const MpmSensitivity sensitivity = (MpmSensitivity)law->info[SENSITIVITY].law;
  const MpmLawInput    nothing     = {.dt = 0.};
  double               tau[2][SYM];
  const MpmLawOutput   value = {tau[0], NULL}, derivative = {tau[1], NULL};
  MpmLawTable          table[MAX_PARAMETERS];
  MpmLawInput          input;
  Setting              setting;

  RandomSeed(22);
  Sample(law, 3, &setting);
  input = PointInput(&setting.point, setting.dF, table);
  ck_assert_int_eq(sensitivity(&input, &nothing, &value, &derivative), 0);
  ck_assert(MaxNorm(SYM, tau[0]) > 0.);
  ck_assert(MaxNorm(SYM, tau[1]) == 0.);
  setting.dF[0] = -0.5;
  ck_assert_int_ne(sensitivity(&input, &nothing, &value, &derivative), 0);
  setting.dF[0] = NAN;
  ck_assert_int_ne(sensitivity(&input, &nothing, &value, &derivative), 0);
}
END_TEST

Suite *LawSensitivitySuite(void)
{
  Suite *suite = suite_create("derivatives by what a law is given");
  TCase *tcase = tcase_create("every law");

  tcase_add_loop_test(tcase, test_against_differences, 0, LawCount());
  tcase_add_loop_test(tcase, test_against_other_forms, 0, LawCount());
  tcase_add_loop_test(tcase, test_packs, 0, LawCount());
  tcase_add_loop_test(tcase, test_calls, 0, LawCount());
  tcase_set_timeout(tcase, 60.);
  suite_add_tcase(suite, tcase);
  return suite;
}

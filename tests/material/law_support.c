/* Registry of the laws under test, random parameters, states and rotations, small matrices. */
#include "laws.h"
#include <math.h>
#include <string.h>

/* ---- the registered laws, from the build's list, and those made for the tests ---- */

#define JOIN3(name, dim, directions) name##_##dim##d_##directions
#define JOIN2(name, dim, directions) JOIN3(name, dim, directions)
#define AT_PLAIN(name)               JOIN2(name, MPM_DIM, 0)
#define AT_ONE(name)                 JOIN2(name, MPM_DIM, 1)
#if MPM_DIM == 2
#define AT_ALL(name) JOIN2(name, 2, 4)
#else
#define AT_ALL(name) JOIN2(name, 3, 9)
#endif
#define AT_SENSITIVITY(name) JOIN2(name, MPM_DIM, sensitivity)

#define DECLARE_TANGENT(name) \
  int name(const MpmLawInfo *info, const MpmLawInput *input, double *state, double *tau, double *dtau);
DECLARE_TANGENT(AT_PLAIN(LawTangent))
DECLARE_TANGENT(AT_ONE(LawTangent))
DECLARE_TANGENT(AT_ALL(LawTangent))

#define MPM_MATERIAL(name) \
  void AT_PLAIN(MpmMaterialCreate_##name)(MpmLawInfo * info); \
  void AT_ONE(MpmMaterialCreate_##name)(MpmLawInfo * info); \
  void AT_ALL(MpmMaterialCreate_##name)(MpmLawInfo * info); \
  void AT_SENSITIVITY(MpmMaterialCreate_##name)(MpmLawInfo * info);
#include "mpm_material_list.h"
#include "test_material_list.h"
#undef MPM_MATERIAL

static const Constructor constructors[][INSTANCES] = {
#define MPM_MATERIAL(name) \
  {AT_PLAIN(MpmMaterialCreate_##name), AT_ONE(MpmMaterialCreate_##name), AT_ALL(MpmMaterialCreate_##name), \
   AT_SENSITIVITY(MpmMaterialCreate_##name)},
#include "mpm_material_list.h"
#include "test_material_list.h"
#undef MPM_MATERIAL
};

enum { LAW_COUNT = sizeof(constructors) / sizeof(constructors[0]) };

static const Constructor *only; /* constructors of the only law under test; NULL: those of the build */

void LawUse(const Constructor own[INSTANCES])
{
  only = own;
}

int LawCount(void)
{
  return only ? 1 : LAW_COUNT;
}

const Law *LawGet(int i)
{
  static Law         laws[LAW_COUNT];
  const LawTangent   tangent[TANGENTS] = {AT_PLAIN(LawTangent), AT_ONE(LawTangent), AT_ALL(LawTangent)};
  const Constructor *create            = only ? only : constructors[i];

  for (int k = 0; k < INSTANCES && !laws[i].tangent[PLAIN]; ++k) create[k](&laws[i].info[k]);
  memcpy(laws[i].tangent, tangent, sizeof tangent);
  return &laws[i];
}

const Law *LawFind(const char *name)
{
  for (int i = 0; i < LawCount(); ++i)
    if (!strcmp(LawGet(i)->info[PLAIN].name, name)) return LawGet(i);
  return NULL;
}

static int StateWidth(const MpmStateVariable *variable)
{
  return variable->kind == MPM_STATE_SYM ? SYM : 1;
}

int LawStateSize(const Law *law)
{
  int size = 0;

  for (size_t s = 0; s < law->info[PLAIN].state_count; ++s) size += StateWidth(&law->info[PLAIN].states[s]);
  return size;
}

int LawParameter(const Law *law, const char *name)
{
  for (size_t p = 0; p < law->info[PLAIN].parameter_count; ++p)
    if (!strcmp(law->info[PLAIN].parameters[p].name, name)) return (int)p;
  return -1;
}

int LawState(const Law *law, const char *name)
{
  int offset = 0;

  for (size_t s = 0; s < law->info[PLAIN].state_count; ++s) {
    if (!strcmp(law->info[PLAIN].states[s].name, name)) return offset;
    offset += StateWidth(&law->info[PLAIN].states[s]);
  }
  return -1;
}

/* ---- random numbers: xorshift64*, Vigna (2016), doi:10.1145/2845077 ---- */

static unsigned long long random_state = 1;

void RandomSeed(unsigned seed)
{
  random_state = 0x9e3779b97f4a7c15ULL * (seed + 1ULL);
}

double RandomUniform(double lower, double upper)
{
  random_state ^= random_state >> 12;
  random_state ^= random_state << 25;
  random_state ^= random_state >> 27;
  return lower + (upper - lower) * (double)((random_state * 0x2545f4914f6cdd1dULL) >> 11) * 0x1p-53;
}

void RandomMatrix(double amplitude, double *A)
{
  Identity(A);
  for (int i = 0; i < DIM2; ++i) A[i] += amplitude * RandomUniform(-1., 1.);
}

/* One rotation about each axis */
void RandomRotation(double *R)
{
  Identity(R);
  for (int axis = 0; axis < (DIM == 2 ? 1 : 3); ++axis) {
    const double angle = RandomUniform(-3., 3.);
    const int    p = axis, q = (axis + 1) % 3;
    double       A[DIM2], B[DIM2];

    Identity(A);
    A[p * DIM + p] = A[q * DIM + q] = cos(angle);
    A[p * DIM + q]                  = -sin(angle);
    A[q * DIM + p]                  = sin(angle);
    memcpy(B, R, sizeof B);
    Multiply(A, B, R);
  }
}

/* ---- points ---- */

#define TYPICAL_E 30e6

/*
  About the typical value, stresses and moduli of a law times one factor of 0.1 to 10, by which E is of 3 to 300 MPa.
  Without a typical value by range and unit, strengths 1e-4 to 1e-2 of E, so that paths with strains of a few per cent
  reach them.
*/
static double RandomParameter(const MpmParameter *parameter, double E, int degenerate)
{
  const double upper = isfinite(parameter->upper) ? parameter->upper : 10., typical = parameter->typical;
  double       value;

  if (parameter->kind == MPM_WORD) return floor(RandomUniform(parameter->lower, parameter->upper + 1.));
  if (degenerate && !parameter->open && RandomUniform(0., 1.) < 0.25) return parameter->lower;
  if (isinf(parameter->fallback) && RandomUniform(0., 1.) < 0.25) return parameter->fallback; /* left out */
  if (!strcmp(parameter->name, "E") || (!strcmp(parameter->name, "G") && typical == 0.)) return E;
  if (!strcmp(parameter->name, "nu")) return RandomUniform(-0.3, 0.48);
  if (typical == 0. && !strcmp(parameter->unit, "Pa")) return E * pow(10., RandomUniform(-4., -2.));
  if (typical == 0. && !strcmp(parameter->unit, "degrees"))
    return RandomUniform(fmax(1., parameter->lower), fmin(45., upper));
  if (typical == 0.) return RandomUniform(parameter->lower, upper);
  if (!strcmp(parameter->unit, "Pa")) value = typical * E / TYPICAL_E * pow(10., RandomUniform(-0.5, 0.5));
  else value = typical * RandomUniform(0.5, 1.5);
  return fmin(fmax(value, parameter->lower), parameter->upper);
}

/* Growing numbers, so that no law softens; the x of a table begin on the side of compression, and are of the size of
   strains or, now and then, of numbers such as exponents. */
static void RandomData(const MpmParameter *parameter, double E, double data[MAX_DATA])
{
  MpmParameter y      = *parameter;
  const int    column = parameter->kind == MPM_TABLE;
  const double size   = column && RandomUniform(0., 1.) < 0.5 ? 100. : 1.;

  if (column) y.unit = strchr(parameter->unit, ':') + 1;
  for (int i = 0; i < MAX_DATA; ++i) {
    if (column && i % 2 == 0) data[i] = i ? data[i - 2] + size * RandomUniform(0.01, 0.03) : -0.03 * size;
    else data[i] = RandomParameter(&y, E, 0) + (i > column ? data[i - 1 - column] : 0.);
  }
}

/* Parameters to which the others leave their default alone take it: friction of a law without strength. */
static void TakeForcedValues(Point *point, const MpmLawTable *table)
{
  const MpmLawInfo *info = &point->law->info[PLAIN];
  MpmLawFault       fault;

  for (size_t p = 0; info->check && p < info->parameter_count; ++p) {
    if (info->check(point->parameter, table, &fault) || fault.parameter < 0 || fault.lower != fault.upper) return;
    if (info->parameters[fault.parameter].same_as || info->parameters[fault.parameter].required ||
        info->parameters[fault.parameter].fallback != fault.lower)
      return;
    point->parameter[fault.parameter] = fault.lower;
  }
}

void PointCreate(const Law *law, int degenerate, Point *point)
{
  const MpmLawInfo *info = &law->info[PLAIN];
  MpmLawFault       fault;
  MpmLawTable       table[MAX_PARAMETERS];

  memset(point, 0, sizeof *point);
  point->law = law;
  do {
    const double E    = TYPICAL_E * pow(10., RandomUniform(-1., 1.));
    double       left = 0.; /* the least share of parameters that are the defaults of others: all of it, or 0.3 */

    for (size_t p = 0; p < info->parameter_count; ++p) {
      if (info->parameters[p].kind >= MPM_TABLE) RandomData(&info->parameters[p], E, point->data[p]);
      else if (info->parameters[p].same_as) {
        if (left == 0.) left = RandomUniform(0., 1.) < 0.3 ? 1. : 0.3;
        point->parameter[p] =
          RandomUniform(left, 1.) * point->parameter[LawParameter(law, info->parameters[p].same_as)];
      } else point->parameter[p] = RandomParameter(&info->parameters[p], E, degenerate);
    }
    PointInput(point, NULL, table);
    TakeForcedValues(point, table);
  } while (info->check && !info->check(point->parameter, table, &fault));
  PointReset(point);
}

MpmLawInput PointInput(const Point *point, const double *dF, MpmLawTable table[MAX_PARAMETERS])
{
  const MpmLawInfo *info  = &point->law->info[PLAIN];
  const MpmLawInput input = {point->parameter, table, point->state, point->F, dF, 1., 0, 0};

  for (size_t p = 0; p < info->parameter_count; ++p) {
    const MpmParameterKind kind = info->parameters[p].kind;

    table[p].count = kind == MPM_TABLE ? MAX_DATA / 2 : kind == MPM_DATA ? MAX_DATA : 0;
    table[p].value = table[p].count ? point->data[p] : NULL;
  }
  return input;
}

void PointReset(Point *point)
{
  const MpmLawInfo *info   = &point->law->info[PLAIN];
  double           *target = point->state;

  Identity(point->F);
  for (size_t s = 0; s < info->state_count; ++s)
    for (int i = 0, n = StateWidth(&info->states[s]); i < n; ++i) *target++ = i < 3 ? info->states[s].initial : 0.;
}

int PointStep(Point *point, const double *dF, double *tau)
{
  double            state[MAX_STATE], F[DIM2];
  MpmLawTable       table[MAX_PARAMETERS];
  const MpmLawInput input  = PointInput(point, dF, table);
  const int         status = point->law->tangent[PLAIN](&point->law->info[PLAIN], &input, state, tau, NULL);

  if (status) return status;
  memcpy(point->state, state, (size_t)LawStateSize(point->law) * sizeof(double));
  Multiply(dF, point->F, F);
  memcpy(point->F, F, sizeof F);
  return 0;
}

void PointRandomPath(Point *point, int steps, double amplitude)
{
  for (int step = 0; step < steps; ++step) {
    double dF[DIM2], tau[SYM];

    RandomMatrix(amplitude, dF);
    PointStep(point, dF, tau);
  }
}

int PointEvaluate(const Point *point, int instance, const double *dF, double *tau, double *dtau)
{
  MpmLawTable       table[MAX_PARAMETERS];
  const MpmLawInput input = PointInput(point, dF, table);

  return point->law->tangent[instance](&point->law->info[instance], &input, NULL, tau, dtau);
}

double PointStiffness(const Point *point)
{
  MpmLawTable table[MAX_PARAMETERS];

  PointInput(point, NULL, table);
  return point->law->info[PLAIN].stiffness(point->parameter, table, NULL, NULL);
}

double PointStiffnessAt(const Point *point)
{
  MpmLawTable table[MAX_PARAMETERS];

  PointInput(point, NULL, table);
  return point->law->info[PLAIN].stiffness(point->parameter, table, point->state, point->F);
}

double PointShearModulus(const Point *point, int rest)
{
  MpmLawTable table[MAX_PARAMETERS];

  PointInput(point, NULL, table);
  return point->law->info[PLAIN].shear_modulus(point->parameter, table, rest ? NULL : point->state,
                                               rest ? NULL : point->F);
}

double PointStiffnessAround(const Point *point, const double *dF)
{
  Point  after = *point;
  double tau[SYM], stiffness = fmax(PointStiffness(point), PointStiffnessAt(point));

  return PointStep(&after, dF, tau) ? stiffness : fmax(stiffness, PointStiffnessAt(&after));
}

double PointStateUnit(const Point *point, int i)
{
  const MpmLawInfo *info   = &point->law->info[PLAIN];
  int               offset = 0;

  for (size_t s = 0; s < info->state_count; ++s) {
    offset += StateWidth(&info->states[s]);
    if (i < offset) return strcmp(info->states[s].unit, "Pa") ? 1. : PointStiffness(point);
  }
  return 1.;
}

void PointSet(Point *point, const char *parameter, double value)
{
  point->parameter[LawParameter(point->law, parameter)] = value;
}

void PointSetPrincipal(Point *point, const double *stress)
{
  const double E  = point->parameter[LawParameter(point->law, "E")];
  const double nu = point->parameter[LawParameter(point->law, "nu")];
  double      *b  = &point->state[LawState(point->law, "elastic_left_cauchy_green")];

  for (int i = 0; i < SYM; ++i) {
    const double e = i < 3 ? (stress[i] - nu * (stress[(i + 1) % 3] + stress[(i + 2) % 3])) / E : 0.;

    b[i] = i < 3 ? exp(2. * e) : 0.;
  }
}

/* ---- small matrices ---- */

void Identity(double *A)
{
  for (int i = 0; i < DIM2; ++i) A[i] = i % (DIM + 1) == 0;
}

void Multiply(const double *A, const double *B, double *C)
{
  for (int i = 0; i < DIM; ++i) {
    for (int j = 0; j < DIM; ++j) {
      C[i * DIM + j] = 0.;
      for (int k = 0; k < DIM; ++k) C[i * DIM + j] += A[i * DIM + k] * B[k * DIM + j];
    }
  }
}

double Determinant(const double *A)
{
  double sum = DIM == 2 ? A[0] * A[DIM + 1] - A[1] * A[DIM] : 0.;

  for (int j = 0; j < 3 && DIM == 3; ++j) {
    const int k = (j + 1) % 3, l = (j + 2) % 3;

    sum += A[j] * (A[DIM + k] * A[2 * DIM + l] - A[DIM + l] * A[2 * DIM + k]);
  }
  return sum;
}

double MaxDifference(int n, const double *a, const double *b)
{
  double largest = 0.;

  /* written so that a NaN gives infinity */
  for (int i = 0; i < n; ++i)
    if (!(fabs(a[i] - b[i]) <= largest)) largest = isnan(a[i] - b[i]) ? HUGE_VAL : fabs(a[i] - b[i]);
  return largest;
}

double MaxNorm(int n, const double *a)
{
  const double zero[SYM * DIM2 + MAX_STATE] = {0.};

  return MaxDifference(n, a, zero);
}

int SymAt(int i, int j)
{
  static const int at[3][3] = {{0, 3, 5}, {3, 1, 4}, {5, 4, 2}};

  return at[i][j];
}

void SymRotate(const double *R, const double *b, double *result)
{
  double rotated[SYM];

  memcpy(rotated, b, sizeof rotated);
  for (int i = 0; i < DIM; ++i) {
    for (int j = i; j < DIM; ++j) {
      double sum = 0.;

      for (int k = 0; k < DIM; ++k)
        for (int l = 0; l < DIM; ++l) sum += R[i * DIM + k] * b[SymAt(k, l)] * R[j * DIM + l];
      rotated[SymAt(i, j)] = sum;
    }
  }
  memcpy(result, rotated, sizeof rotated);
}

void Hooke(double E, double nu, const double *H, double *sigma)
{
  const double mu = E / (2. * (1. + nu)), lambda = E * nu / ((1. + nu) * (1. - 2. * nu));
  double       trace = 0.;

  for (int i = 0; i < DIM; ++i) trace += H[i * DIM + i];
  for (int i = 0; i < SYM; ++i) sigma[i] = i < 3 ? lambda * trace : 0.;
  for (int i = 0; i < DIM; ++i)
    for (int j = i; j < DIM; ++j) sigma[SymAt(i, j)] += mu * (H[i * DIM + j] + H[j * DIM + i]);
}

void Solve(int n, double *A, double *b)
{
  for (int k = 0; k < n; ++k) {
    int pivot = k;

    for (int i = k + 1; i < n; ++i)
      if (fabs(A[i * n + k]) > fabs(A[pivot * n + k])) pivot = i;
    for (int j = 0; j <= n; ++j) {
      double      *x = j < n ? &A[k * n + j] : &b[k], *y = j < n ? &A[pivot * n + j] : &b[pivot];
      const double keep = *x;

      *x = *y;
      *y = keep;
    }
    for (int i = k + 1; i < n; ++i) {
      const double factor = A[i * n + k] / A[k * n + k];

      for (int j = k; j < n; ++j) A[i * n + j] -= factor * A[k * n + j];
      b[i] -= factor * b[k];
    }
  }
  for (int i = n - 1; i >= 0; --i) {
    for (int j = i + 1; j < n; ++j) b[i] -= A[i * n + j] * b[j];
    b[i] /= A[i * n + i];
  }
}

double TaylorRemainder(const Point *point, const double *dF, const double *V, double h)
{
  double tau[SYM], dtau[SYM * DIM2], moved[DIM2], after[SYM], largest = 0.;

  if (PointEvaluate(point, ALL_DIRECTIONS, dF, tau, dtau)) return NAN;
  for (int i = 0; i < DIM2; ++i) moved[i] = dF[i] + h * V[i];
  if (PointEvaluate(point, PLAIN, moved, after, NULL)) return NAN;
  for (int i = 0; i < SYM; ++i) {
    double linear = tau[i];

    for (int k = 0; k < DIM2; ++k) linear += h * dtau[i * DIM2 + k] * V[k];
    largest = fmax(largest, fabs(after[i] - linear));
  }
  return largest;
}

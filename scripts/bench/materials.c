/*
  Nanoseconds a point of every registered law, through the solid's kernel.

    bench_materials [-bench_rounds 3] [-bench_sample 2e-3] [-bench_dims 2,3] [-bench_laws j2,ogden]

  rounds  times that each case is measured; the cases take turns
  sample  s: a case is repeated for so long each time
  laws    these alone

  Lines on the terminal, for a program to read: law parameters dim state form nanoseconds; and "local" with the laws whose
  local problem is solved twice, in the program that was built so.

  parameters  default: those that must be given have their typical values, the others their defaults; typical: all have
              typical values. Where the law refuses them, what it names goes from the one to the other.
  state       elastic or plastic: increments of F, at random from one state, after which the way back leads to the same
              stress, or does not. The state is 100 kPa of pressure, if the law takes that.
  form        stress or tangent
*/
#include "point/material.h"
#include "point/registry.h"
#include <petsctime.h>

#define PRESSURE 100e3 /* Pa */
enum { INCREMENTS = 32, ENOUGH = 8, DRAWS = 600, ROWS = 2 };

static const char *const names[] = {
#define MPM_MATERIAL(name) #name,
#include "mpm_material_list.h"
#undef MPM_MATERIAL
};
#define LAW_COUNT ((PetscInt)PETSC_STATIC_ARRAY_LENGTH(names))

typedef enum { DEFAULT, TYPICAL, SETTINGS } Setting;
static const char *const settings[] = {"default", "typical"};

/* A law with its parameters at a state, and increments from there */
typedef struct {
  MpmLawInfo          info;
  const MpmKernelSet *kernels;
  PetscInt            dim;
  Setting             setting;
  const char         *kind; /* elastic or plastic */
  MpmFunction         law[MPM_FORM_COUNT];
  double             *parameter, *state, *value, F[9], increment[INCREMENTS][9];
  MpmLawTable        *table;
  PetscInt            state_size, increments;
} Case;

static double Random(double lower, double upper)
{
  static unsigned long long number = 88172645463325252ULL; /* Marsaglia (2003), doi:10.18637/jss.v008.i14 */

  number ^= number << 13;
  number ^= number >> 7;
  number ^= number << 17;
  return lower + (upper - lower) * (double)(number >> 11) * 0x1p-53;
}

/* ---- parameters ---- */

static double ParameterValue(const Case *one, size_t p, Setting setting)
{
  const MpmParameter *parameter = &one->info.parameters[p];
  const double        typical =
    parameter->typical != 0. || !parameter->required ? parameter->typical : fmax(1., parameter->lower);

  if (parameter->kind == MPM_WORD || !strcmp(parameter->name, "density")) return parameter->fallback;
  if (parameter->required || (setting == TYPICAL && typical != 0.)) return typical;
  for (size_t i = 0; parameter->same_as && i < p; i++)
    if (!strcmp(one->info.parameters[i].name, parameter->same_as)) return one->parameter[i];
  return parameter->fallback;
}

/* Tables of two rows of the typical value; data are as many numbers. */
static void SetParameters(Case *one)
{
  MpmLawFault fault;

  for (size_t p = 0; p < one->info.parameter_count; p++) {
    const MpmParameter *parameter = &one->info.parameters[p];
    double             *value     = &one->value[2 * ROWS * p];

    one->parameter[p] = parameter->kind <= MPM_WORD ? ParameterValue(one, p, one->setting) : 0.;
    if (parameter->kind <= MPM_WORD || (!parameter->required && one->setting == DEFAULT)) continue;
    for (int i = 0; i < 2 * ROWS; i++)
      value[i] = parameter->kind == MPM_TABLE && i % 2 == 0 ? 1. + i / 2 : parameter->typical;
    one->table[p].count = parameter->kind == MPM_TABLE ? ROWS : 2 * ROWS;
    one->table[p].value = value;
  }
  for (size_t turn = 0; one->info.check && turn < one->info.parameter_count; turn++) {
    if (one->info.check(one->parameter, one->table, &fault) || fault.parameter < 0) return;
    one->parameter[fault.parameter] =
      ParameterValue(one, (size_t)fault.parameter, one->setting == DEFAULT ? TYPICAL : DEFAULT);
  }
}

static PetscErrorCode CaseCreate(PetscInt law, PetscInt dim, Setting setting, const MpmPhysics *solid, Case *one)
{
  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(one, sizeof(*one)));
  one->dim     = dim;
  one->setting = setting;
  one->kernels = &solid->kernels[dim];
  for (PetscInt form = 0; form < MPM_FORM_COUNT; form++) {
    PetscCheck(MpmLawFind(names[law], dim, (MpmForm)form, &one->info), PETSC_COMM_SELF, PETSC_ERR_PLIB, "no law %s",
               names[law]);
    one->law[form] = one->info.law;
  }
  for (size_t s = 0; s < one->info.state_count; s++) one->state_size += MpmStateComponents(&one->info.states[s], dim);
  PetscCall(PetscCalloc4(one->info.parameter_count, &one->parameter, one->info.parameter_count, &one->table,
                         2 * ROWS * one->info.parameter_count, &one->value, one->state_size, &one->state));
  SetParameters(one);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscBool SameParameters(const Case *one, const Case *other)
{
  PetscBool same = PETSC_TRUE;

  for (size_t p = 0; p < one->info.parameter_count; p++)
    if (one->parameter[p] != other->parameter[p] || one->table[p].count != other->table[p].count) same = PETSC_FALSE;
  return same;
}

static PetscErrorCode CaseDestroy(Case *one)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree4(one->parameter, one->table, one->value, one->state));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- states ---- */

static MpmKernelPoint PointOf(const Case *one)
{
  MpmKernelPoint point = {.material.parameter = one->parameter,
                          .state_n            = one->state,
                          .F_n                = one->F,
                          .volume0            = 1.,
                          .dt                 = 1.,
                          .material.traits    = one->info.traits,
                          .material.law       = one->law,
                          .material.table     = one->table};

  return point;
}

enum { ROOM = 256 }; /* numbers of a state */

/* A step from a state in place: state, F and stress become those of its end. Non-zero where there is none. */
static int Step(const Case *one, const double *increment, double *state, double *F, double *stress)
{
  MpmKernelPoint point = PointOf(one);
  double         state_n[ROOM], F_n[9], flux[9];

  memcpy(state_n, state, (size_t)one->state_size * sizeof(double));
  memcpy(F_n, F, sizeof F_n);
  point.state_n    = state_n;
  point.F_n        = F_n;
  point.end.state  = state;
  point.end.F      = F;
  point.end.stress = stress;
  return one->kernels->residual(&point, increment, flux);
}

/* 100 kPa of pressure: as history, or by small steps as far as they lead there */
static void Compress(Case *one)
{
  const PetscInt n         = one->dim * one->dim;
  double         wanted[6] = {-PRESSURE, -PRESSURE, -PRESSURE}, stress[6] = {0.}, part[9] = {0.};

  MpmStatesAtRest(one->info.state_count, one->info.states, one->dim, one->state);
  for (PetscInt i = 0; i < n; i++) one->F[i] = i % (one->dim + 1) == 0;
  if (!(one->info.traits & MPM_LAW_PLASTIC)) return;
  if (one->info.history && !one->info.history(one->parameter, one->table, wanted, one->state)) return;
  MpmStatesAtRest(one->info.state_count, one->info.states, one->dim, one->state);
  for (PetscInt i = 0; i < n; i++) part[i] = i % (one->dim + 1) == 0 ? -1e-4 : 0.;
  for (int step = 0; step < 100 && stress[0] + stress[1] + stress[2] > -3. * PRESSURE; step++)
    if (Step(one, part, one->state, one->F, stress)) break;
}

/* The increment that undoes another one: (I + H)^{-1} - I */
static void Inverse(PetscInt dim, const double *increment, double *back)
{
  double dF[9] = {0.}, cofactor[9], det;

  for (PetscInt i = 0; i < dim * dim; i++) dF[i] = increment[i] + (i % (dim + 1) == 0);
  det = MpmCofactors(dim * dim, dF, cofactor);
  for (PetscInt i = 0; i < dim; i++)
    for (PetscInt j = 0; j < dim; j++) back[i * dim + j] = cofactor[j * dim + i] / det - (i == j);
}

/* Whether the way there and back leads to another stress; negative where one of them has none */
static int IsPlastic(const Case *one, const double *increment)
{
  const PetscInt n            = MpmSymSize(one->dim);
  const double   none[9]      = {0.};
  double         stress[3][6] = {{0.}}, state[ROOM], F[9], back[9], moved = 0., left = 0., size = 0.;

  memcpy(state, one->state, (size_t)one->state_size * sizeof(double));
  memcpy(F, one->F, sizeof F);
  Inverse(one->dim, increment, back);
  if (Step(one, none, state, F, stress[0]) || Step(one, increment, state, F, stress[1]) ||
      Step(one, back, state, F, stress[2]))
    return -1;
  for (PetscInt i = 0; i < n; i++) {
    size  = fmax(size, fabs(stress[0][i]) + fabs(stress[1][i]));
    moved = fmax(moved, fabs(stress[1][i] - stress[0][i]));
    left  = fmax(left, fabs(stress[2][i] - stress[0][i]));
  }
  if (!(moved > 0.)) return -1;
  return left > 1e-5 * moved + 1e-12 * size;
}

/* Increments of one kind, mostly of shape, of the first size that has enough of them */
static void Draw(Case *one, PetscBool plastic)
{
  static const double sizes[2][4] = {{1e-4, 1e-5, 1e-6, 1e-7}, {3e-3, 1e-2, 3e-2, 1e-3}};
  const PetscInt      dim         = one->dim;
  MpmLawFault         fault;

  one->kind = plastic ? "plastic" : "elastic";
  if (one->info.check && !one->info.check(one->parameter, one->table, &fault)) return; /* it is no material */
  for (int k = 0; k < 4 && one->increments < ENOUGH; k++) {
    one->increments = 0;
    for (int draw = 0; draw < DRAWS && one->increments < INCREMENTS; draw++) {
      double *increment = one->increment[one->increments], trace = 0.;

      for (PetscInt i = 0; i < dim * dim; i++) increment[i] = sizes[plastic][k] * Random(-1., 1.);
      for (PetscInt i = 0; i < dim; i++) trace += increment[i * (dim + 1)];
      for (PetscInt i = 0; i < dim; i++) increment[i * (dim + 1)] -= 0.9 * trace / (double)dim;
      one->increments += IsPlastic(one, increment) == (plastic ? 1 : 0);
    }
  }
  if (one->increments < ENOUGH) one->increments = 0;
}

/* ---- measurements ---- */

static double Turn(const Case *one, MpmForm form)
{
  const MpmKernelPoint point = PointOf(one);
  double               flux[9], tangent[81], sum = 0.;

  for (PetscInt i = 0; i < one->increments; i++) {
    if (form == MPM_FORM_RESIDUAL) (void)one->kernels->residual(&point, one->increment[i], flux);
    else (void)one->kernels->tangent(&point, one->increment[i], flux, tangent);
    sum += flux[0] + (form == MPM_FORM_RESIDUAL ? 0. : tangent[0]);
  }
  return sum;
}

static PetscErrorCode Measure(const Case *one, MpmForm form, PetscReal sample, double *sink)
{
  PetscLogDouble begin, end;
  PetscInt       turns = 0;

  PetscFunctionBeginUser;
  *sink += Turn(one, form); /* to warm up */
  PetscCall(PetscTime(&begin));
  do {
    for (int k = 0; k < 4; k++) *sink += Turn(one, form);
    turns += 4;
    PetscCall(PetscTime(&end));
  } while (end - begin < sample);
  PetscCall(PetscPrintf(PETSC_COMM_SELF, "%s %s %" PetscInt_FMT " %s %s %.6g\n", one->info.name, settings[one->setting],
                        one->dim, one->kind, form == MPM_FORM_RESIDUAL ? "stress" : "tangent",
                        1e9 * (end - begin) / (double)(turns * one->increments)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Leaves out what -bench_laws, where it is given, does not name. */
static PetscErrorCode Select(PetscInt count, Case cases[])
{
  char    **laws;
  PetscInt  law_count = LAW_COUNT;
  PetscBool given;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(law_count, &laws));
  PetscCall(PetscOptionsGetStringArray(NULL, NULL, "-bench_laws", laws, &law_count, &given));
  for (PetscInt k = 0; k < count && given; k++) {
    PetscBool wanted = PETSC_FALSE;

    for (PetscInt law = 0; law < law_count; law++)
      if (!strcmp(laws[law], cases[k].info.name)) wanted = PETSC_TRUE;
    if (!wanted) cases[k].increments = 0;
  }
  for (PetscInt law = 0; law < (given ? law_count : 0); law++) PetscCall(PetscFree(laws[law]));
  PetscCall(PetscFree(laws));
  PetscFunctionReturn(PETSC_SUCCESS);
}

int main(int argc, char **argv)
{
  MpmPhysics solid;
  Case      *cases;
  PetscInt   rounds = 3, dims[2] = {2, 3}, dim_count = 2, count = 0;
  PetscReal  sample = 2e-3;
  PetscBool  found;
  double     sink = 0.;

  PetscCall(PetscInitialize(&argc, &argv, NULL, "bench_materials\n"));
  PetscCall(PetscOptionsGetInt(NULL, NULL, "-bench_rounds", &rounds, NULL));
  PetscCall(PetscOptionsGetReal(NULL, NULL, "-bench_sample", &sample, NULL));
  PetscCall(PetscOptionsGetIntArray(NULL, NULL, "-bench_dims", dims, &dim_count, &found));
  if (!found) dim_count = 2;
  PetscCall(MpmPhysicsCreate("solid", &solid, &found));
  PetscCall(PetscMalloc1(LAW_COUNT * SETTINGS * 2 * 2, &cases));
  for (PetscInt d = 0; d < dim_count; d++) {
    for (PetscInt law = 0; law < LAW_COUNT; law++) {
      for (int k = 0; k < 2 * SETTINGS; k++, count++) {
        PetscCall(CaseCreate(law, dims[d], (Setting)(k / 2), &solid, &cases[count]));
        if (k / 2 == TYPICAL && SameParameters(&cases[count], &cases[count - 2])) continue;
        Compress(&cases[count]);
        Draw(&cases[count], (PetscBool)(k % 2));
      }
    }
  }
  PetscCall(Select(count, cases));
#if defined(BENCH_LOCAL_LAWS)
  PetscCall(PetscPrintf(PETSC_COMM_SELF, "local " BENCH_LOCAL_LAWS "\n"));
#endif
  for (PetscInt round = 0; round < rounds; round++) {
    for (PetscInt k = 0; k < count; k++) {
      if (!cases[k].increments) continue;
      PetscCall(Measure(&cases[k], MPM_FORM_RESIDUAL, sample, &sink));
      PetscCall(Measure(&cases[k], MPM_FORM_TANGENT, sample, &sink));
    }
  }
  if (sink == 0.) PetscCall(PetscPrintf(PETSC_COMM_SELF, "nothing was computed\n"));
  for (PetscInt k = 0; k < count; k++) PetscCall(CaseDestroy(&cases[k]));
  PetscCall(PetscFree(cases));
  PetscCall(PetscFinalize());
  return 0;
}

/*
  Seconds for one Jacobian of a plane Hencky scene, made in several ways in the same deformed state, and how far the
  matrices are apart.

    bench_jacobian -options_file SCENE [-bench_forms local,hand,...] [-bench_rounds 5] [-bench_steps 10]
                   [-bench_limit 60] [-bench_run]

  forms   local, coloring, dense, fd: values of -mpm_jacobian; hand: as local, with the tangent of hencky_tangent.h
  rounds  times that each form is measured; the forms take turns
  steps   load steps of the scene before; the Jacobians are those at the end of the step after them
  limit   s: dense is left out where it is expected to take longer
  run     runs the scene to its end with the hand-coded tangent instead, and writes results as talus does

  Lines on the terminal, for a program to read: a key, and then a form and a number, or just a number. The hand-coded
  tangent goes in as a physics of its own, whose other functions are the built-in solid's.
*/
#include "point/material.h"
#include "point/registry.h"
#include "particles/particles.h"
#include "particles/points.h"
#include "space/space.h"
#include "step/step.h"
#include "schedule/schedule.h"
#include "query/model.h"
#include "hencky_tangent.h"

#define BENCH_SAMPLE 0.05 /* s: a sample repeats what is shorter */
#define BENCH_POINTS 200000

typedef int (*Tangent)(const MpmKernelPoint *point, const double *input, double *flux, double *tangent);

typedef struct {
  const char     *name;
  MpmJacobianType type;
  PetscBool       by_hand;
} Form;

static const Form forms[] = {
  {"local", MPM_JACOBIAN_LOCAL, PETSC_FALSE},
  {"hand", MPM_JACOBIAN_LOCAL, PETSC_TRUE},
  {"coloring", MPM_JACOBIAN_COLORING, PETSC_FALSE},
  {"dense", MPM_JACOBIAN_DENSE, PETSC_FALSE},
  {"fd", MPM_JACOBIAN_FD, PETSC_FALSE},
};
#define FORM_COUNT ((PetscInt)PETSC_STATIC_ARRAY_LENGTH(forms))
enum { FORM_LOCAL, FORM_HAND, FORM_COLORING, FORM_DENSE, FORM_FD };

typedef struct {
  MpmModel  model;
  Tangent   dual; /* the built-in tangent */
  PetscInt  rounds, steps;
  PetscReal limit;
  PetscBool run, wanted[PETSC_STATIC_ARRAY_LENGTH(forms)];
} Bench;

/* Options that a scene has not are cleared once they are read: the model refuses them. */
static PetscErrorCode ReadOptions(Bench *bench)
{
  static const char *const own[] = {"-bench_rounds", "-bench_steps", "-bench_limit", "-bench_run", "-bench_forms"};

  char     *names[16];
  PetscInt  count = PETSC_STATIC_ARRAY_LENGTH(names);
  PetscBool given;

  PetscFunctionBeginUser;
  bench->rounds = 5;
  bench->steps  = 10;
  bench->limit  = 60.;
  PetscCall(PetscOptionsGetInt(NULL, NULL, "-bench_rounds", &bench->rounds, NULL));
  PetscCall(PetscOptionsGetInt(NULL, NULL, "-bench_steps", &bench->steps, NULL));
  PetscCall(PetscOptionsGetReal(NULL, NULL, "-bench_limit", &bench->limit, NULL));
  PetscCall(PetscOptionsHasName(NULL, NULL, "-bench_run", &bench->run));
  PetscCall(PetscOptionsGetStringArray(NULL, NULL, "-bench_forms", names, &count, &given));
  for (PetscInt k = 0; k < FORM_COUNT; k++) bench->wanted[k] = (PetscBool)!given;
  for (PetscInt i = 0; given && i < count; i++) {
    PetscBool known = PETSC_FALSE;

    for (PetscInt k = 0; k < FORM_COUNT; k++) {
      if (!strcmp(names[i], forms[k].name)) bench->wanted[k] = known = PETSC_TRUE;
    }
    PetscCheck(known, PETSC_COMM_WORLD, PETSC_ERR_USER,
               "-bench_forms %s: must be some of local, hand, coloring, dense, fd", names[i]);
    PetscCall(PetscFree(names[i]));
  }
  bench->wanted[FORM_LOCAL] = PETSC_TRUE;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(own); k++) PetscCall(PetscOptionsClearValue(NULL, own[k]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The scene with the solid's physics, its tangent replaced. */
static PetscErrorCode CreateModel(Bench *bench)
{
  MpmPhysics physics;
  PetscBool  found;

  PetscFunctionBeginUser;
  PetscCall(MpmPhysicsCreate("solid", &physics, &found));
  bench->dual                = physics.kernels[2].tangent;
  physics.kernels[2].tangent = HenckyTangent;
  PetscCall(MpmModelCreate(PETSC_COMM_WORLD, &bench->model));
  PetscCall(MpmModelSetPhysics(bench->model, &physics));
  PetscCall(MpmModelUseTerminal(bench->model));
  PetscCall(MpmModelSetFromOptions(bench->model));
  PetscCall(MpmModelSetUp(bench->model));
  PetscCheck(bench->model->disc.dim == 2, bench->model->comm, PETSC_ERR_SUP, "the scene must be plane");
  for (PetscInt k = 0; k < bench->model->scene.materials->count; k++) {
    PetscCheck(!strcmp(bench->model->scene.materials->at[k].info.name, "hencky"), bench->model->comm, PETSC_ERR_SUP,
               "every material must be hencky");
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Load steps, and one more that is solved and not committed: its solution is where the Jacobians are taken. */
static PetscErrorCode Deform(MpmModel model, PetscInt steps)
{
  SNESConvergedReason reason;
  MpmOutcome          outcome;

  PetscFunctionBeginUser;
  for (model->state.step = 0; model->state.step < steps; model->state.step++) {
    const PetscReal next = model->state.dt.nominal * (PetscReal)(model->state.step + 1);

    PetscCall(MpmParticlesMigrate(model->state.particles, model->disc.grid));
    PetscCall(MpmStep(model, next, next - model->state.time, PETSC_FALSE, &outcome));
    PetscCheck(!outcome.code, model->comm, PETSC_ERR_NOT_CONVERGED, "step %" PetscInt_FMT ": %s", model->state.step,
               outcome.text);
    model->state.time = next;
  }
  PetscCall(MpmParticlesMigrate(model->state.particles, model->disc.grid));
  PetscCall(
    MpmStepPrepare(model, model->state.time + model->state.dt.nominal, model->state.dt.nominal, PETSC_FALSE, &outcome));
  PetscCheck(!outcome.code, model->comm, PETSC_ERR_PLIB, "%s", outcome.text);
  PetscCall(MpmSolverSolve(&model->solver, &reason));
  PetscCheck(reason > 0, model->comm, PETSC_ERR_NOT_CONVERGED, "the last step did not converge");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- one Jacobian ---- */

static PetscErrorCode Assemble(Bench *bench, PetscInt form)
{
  MpmModel model = bench->model;

  PetscFunctionBeginUser;
  model->solver.jacobian.form             = forms[form].type;
  model->scene.physics.kernels[2].tangent = forms[form].by_hand ? HenckyTangent : bench->dual;
  PetscCall(SNESComputeJacobian(model->solver.snes, model->solver.x, model->solver.jacobian.assembled,
                                model->solver.jacobian.assembled));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Seconds for one assembly, the mean over `repeat` of them. */
static PetscErrorCode Sample(Bench *bench, PetscInt form, PetscInt repeat, PetscReal *seconds)
{
  PetscLogDouble begin, end;

  PetscFunctionBeginUser;
  PetscCall(PetscTime(&begin));
  for (PetscInt k = 0; k < repeat; k++) PetscCall(Assemble(bench, form));
  PetscCall(PetscTime(&end));
  *seconds = (end - begin) / (PetscReal)repeat;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* |A - A_local| / |A_local| in the Frobenius norm */
static PetscErrorCode PrintDifference(Bench *bench, PetscInt form, Mat local)
{
  Mat       other;
  PetscReal norm, difference;

  PetscFunctionBeginUser;
  PetscCall(MatDuplicate(bench->model->solver.jacobian.assembled, MAT_COPY_VALUES, &other));
  PetscCall(MatAXPY(other, -1., local, SAME_NONZERO_PATTERN));
  PetscCall(MatNorm(other, NORM_FROBENIUS, &difference));
  PetscCall(MatNorm(local, NORM_FROBENIUS, &norm));
  PetscCall(MatDestroy(&other));
  PetscCall(PetscPrintf(bench->model->comm, "difference %s %.6g\n", forms[form].name, (double)(difference / norm)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Dense differentiation evaluates every point for every column of the box of nodes; colouring, only for the columns of
  the nodes that a point touches. So the time of one tells that of the other.
*/
static PetscReal ExpectDense(MpmModel model, PetscReal coloring)
{
  const MpmSpace *space   = model->disc.space;
  PetscReal       touched = 0., points = 0., box = 1.;

  for (PetscInt g = 0; g < space->group_count; g++) {
    const PetscReal count = (PetscReal)(space->groups[g].point_end - space->groups[g].point_begin);

    points += count;
    touched += count * (PetscReal)space->groups[g].node_count;
  }
  for (PetscInt a = 0; a < space->dim; a++) {
    PetscInt first = PETSC_INT_MAX, last = 0;

    for (PetscInt i = 0; i < space->local; i++) {
      first = PetscMin(first, space->node[i * space->dim + a]);
      last  = PetscMax(last, space->node[i * space->dim + a]);
    }
    box *= (PetscReal)(last - first + 1);
  }
  return coloring * points * box / touched;
}

/* The forms' turns; a form with repeat 0 is left out. The first assembly of each is not counted. */
static PetscErrorCode Compare(Bench *bench)
{
  Mat       local = NULL;
  PetscInt  repeat[PETSC_STATIC_ARRAY_LENGTH(forms)], turns[PETSC_STATIC_ARRAY_LENGTH(forms)];
  PetscReal seconds;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < FORM_COUNT; k++) {
    turns[k] = bench->wanted[k] ? bench->rounds : 0;
    if (turns[k] && k == FORM_DENSE) {
      PetscCall(Sample(bench, FORM_COLORING, 1, &seconds));
      seconds = ExpectDense(bench->model, seconds);
      PetscCall(PetscPrintf(bench->model->comm, "expected dense %.6g\n", (double)seconds));
      turns[k] = seconds > bench->limit ? 0 : PetscMin(turns[k], (PetscInt)PetscMax(bench->limit / seconds, 1.));
    }
    if (!turns[k]) continue;
    PetscCall(Sample(bench, k, 1, &seconds));
    repeat[k] = (PetscInt)PetscCeilReal(BENCH_SAMPLE / seconds);
    if (k == FORM_LOCAL) PetscCall(MatDuplicate(bench->model->solver.jacobian.assembled, MAT_COPY_VALUES, &local));
    else PetscCall(PrintDifference(bench, k, local));
  }
  for (PetscInt round = 0; round < bench->rounds; round++) {
    for (PetscInt k = 0; k < FORM_COUNT; k++) {
      if (round >= turns[k]) continue;
      PetscCall(Sample(bench, k, repeat[k], &seconds));
      PetscCall(PetscPrintf(bench->model->comm, "seconds %s %.6g\n", forms[k].name, (double)seconds));
    }
  }
  PetscCall(MatDestroy(&local));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the tangents at points ---- */

static void PointOf(const MpmModel model, PetscInt p, MpmKernelPoint *point)
{
  const MpmMaterial *material = &model->scene.materials->at[model->disc.points->material[p]];

  *point = (MpmKernelPoint){.material.parameter = material->parameter,
                            .F_n                = &model->disc.points->F[p * 4],
                            .volume0            = model->disc.points->volume0[p],
                            .dt                 = model->state.dt.nominal,
                            .material.traits    = material->info.traits,
                            .material.law       = material->law,
                            .material.table     = material->table};
}

/* Some gradient of the step's displacement, of a given size and different from point to point */
static void InputOf(PetscInt p, PetscReal size, double input[])
{
  for (PetscInt k = 0; k < 4; k++) input[k] = size * PetscSinReal((PetscReal)(p * 4 + k) * (1. + 0.37 * (PetscReal)k));
}

/* Nanoseconds a point of one tangent alone, away from the sums; `sink` keeps the compiler from leaving it out. */
static PetscErrorCode TimeTangent(MpmModel model, Tangent tangent, PetscReal *nanoseconds, PetscReal *sink)
{
  const PetscInt turns = 1 + BENCH_POINTS / PetscMax(model->disc.points->count, 1);
  PetscLogDouble begin, end;
  double         input[4], flux[4], D[16];

  PetscFunctionBeginUser;
  InputOf(1, 0.01, input);
  PetscCall(PetscTime(&begin));
  for (PetscInt turn = 0; turn < turns; turn++) {
    for (PetscInt p = 0; p < model->disc.points->count; p++) {
      MpmKernelPoint point;

      PointOf(model, p, &point);
      (void)tangent(&point, input, flux, D);
      *sink += D[0];
    }
  }
  PetscCall(PetscTime(&end));
  *nanoseconds = 1e9 * (end - begin) / (PetscReal)(turns * model->disc.points->count);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The largest difference of a point's two tangents, relative to its largest entry; steps of any size, none included. */
static PetscReal TangentDifference(const Bench *bench)
{
  static const PetscReal sizes[]     = {0., 1e-15, 1e-12, 1e-9, 1e-6, 1e-3, 0.1, 0.4};
  static const double    identity[4] = {1., 0., 0., 1.};
  PetscReal              difference  = 0.;

  for (PetscInt p = 0; p < bench->model->disc.points->count; p++) {
    MpmKernelPoint point;
    double         input[4], flux[2][4], D[2][16], largest = 0., apart = 0.;

    PointOf(bench->model, p, &point);
    if (p % 3 == 0) point.F_n = identity; /* equal principal values */
    InputOf(p, sizes[p % (PetscInt)PETSC_STATIC_ARRAY_LENGTH(sizes)], input);
    if (bench->dual(&point, input, flux[0], D[0]) || HenckyTangent(&point, input, flux[1], D[1])) continue;
    for (PetscInt k = 0; k < 16; k++) {
      largest = PetscMax(largest, PetscAbsReal(D[0][k]));
      apart   = PetscMax(apart, PetscAbsReal(D[1][k] - D[0][k]));
    }
    for (PetscInt k = 0; k < 4; k++) apart = PetscMax(apart, PetscAbsReal(flux[1][k] - flux[0][k]));
    difference = PetscMax(difference, apart / largest);
  }
  return difference;
}

static PetscErrorCode CompareTangents(Bench *bench)
{
  PetscReal nanoseconds, sink = 0.;

  PetscFunctionBeginUser;
  PetscCall(PetscPrintf(bench->model->comm, "tangent_difference %.6g\n", (double)TangentDifference(bench)));
  for (PetscInt round = 0; round < bench->rounds; round++) {
    PetscCall(TimeTangent(bench->model, bench->dual, &nanoseconds, &sink));
    PetscCall(PetscPrintf(bench->model->comm, "tangent_ns local %.6g\n", (double)nanoseconds));
    PetscCall(TimeTangent(bench->model, HenckyTangent, &nanoseconds, &sink));
    PetscCall(PetscPrintf(bench->model->comm, "tangent_ns hand %.6g\n", (double)nanoseconds));
  }
  if (sink == 0.) PetscCall(PetscPrintf(bench->model->comm, "nothing was computed\n"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

int main(int argc, char **argv)
{
  Bench       bench  = {.model = NULL};
  int         status = 0;
  PetscMPIInt size;

  PetscCall(PetscInitialize(&argc, &argv, NULL, "bench_jacobian -options_file SCENE\n"));
  PetscCallMPI(MPI_Comm_size(PETSC_COMM_WORLD, &size));
  PetscCall(ReadOptions(&bench));
  PetscCheck(size == 1 || bench.run, PETSC_COMM_WORLD, PETSC_ERR_SUP, "the comparison is made on one rank");
  PetscCall(CreateModel(&bench));
  if (bench.run) {
    PetscCall(MpmModelRun(bench.model, &status));
  } else {
    bench.model->scene.physics.kernels[2].tangent = bench.dual;
    PetscCall(Deform(bench.model, bench.steps));
    PetscCall(PetscPrintf(PETSC_COMM_WORLD, "points %" PetscInt_FMT "\nunknowns %" PetscInt_FMT "\n",
                          bench.model->disc.points->count,
                          MpmNodesTotal(&bench.model->disc) * bench.model->disc.block));
    PetscCall(Compare(&bench));
    PetscCall(CompareTangents(&bench));
  }
  PetscCall(MpmModelDestroy(&bench.model));
  PetscCall(PetscFinalize());
  return status;
}

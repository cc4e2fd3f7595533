/*
  Nanoseconds a point for a step of explicit dynamics, and for one residual of a quasi-static step on the same points; or for an
  iteration of Newton's method in a step of implicit dynamics, and in a quasi-static one.

    bench_dynamics -bench_explicit SCENE -bench_static SCENE [-bench_rounds 5] [-bench_steps 10]
    bench_dynamics -bench_implicit SCENE -bench_static SCENE [-bench_rounds 5]

  explicit, implicit, static  the same scene with either integrator; the explicit one must not write states
  rounds                      times that each is measured; they take turns
  steps                       explicit steps, or residuals, in each of them

  A step is all that lies between the starts of two steps of a run: migration, its length, space, motion, stress, the account of
  energy and the row of the history. A residual is what Newton's method asks for once an iteration, with the points' trial state, in a
  quasi-static step from where the points then are. An iteration is what a step's solution takes, over their number: residuals,
  Jacobians and linear solutions, and with them what is made once a step (key step_); the step is always the same one, the second of
  the dynamic model, whose points stand between the cells of the grid. Seconds are those of the processor.

  Lines on the terminal, for a program to read: a key and a number.
*/
#include <time.h>
#include "grid/grid.h"
#include "particles/particles.h"
#include "particles/points.h"
#include "solve/solve.h"
#include "integrators/integrators.h"
#include "query/model.h"
#include "step/step.h"
#include "schedule/schedule.h"

#define BENCH_WARM       5    /* steps before the first round */
#define BENCH_STRAIN     1e-4 /* of the quasi-static step */
#define BENCH_ITERATIONS 2    /* of Newton's method, in steps that it would end after two to four */
#define BENCH_SHIFT      0.15

typedef struct {
  MpmModel  fixed; /* quasi-static */
  Vec       x[2];  /* where its residual is asked for, in turn: one that is known is not made again */
  PetscInt  rounds, steps, step;
  PetscReal since, points;
} Bench;

static PetscReal Now(void)
{
  struct timespec now;

  (void)clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return (PetscReal)now.tv_sec + 1e-9 * (PetscReal)now.tv_nsec;
}

static PetscErrorCode CreateModel(const char option[], MpmModel *model)
{
  char      scene[PETSC_MAX_PATH_LEN], text[PETSC_MAX_PATH_LEN + 32];
  PetscBool given;

  PetscFunctionBeginUser;
  PetscCall(PetscOptionsGetString(NULL, NULL, option, scene, sizeof(scene), &given));
  PetscCheck(given, PETSC_COMM_WORLD, PETSC_ERR_USER, "%s is missing: a scene file", option);
  PetscCall(PetscSNPrintf(text, sizeof(text), "-options_file %s", scene));
  PetscCall(MpmModelCreate(PETSC_COMM_WORLD, model));
  PetscCall(MpmModelSetOptions(*model, text));
  PetscCall(MpmModelSetFromOptions(*model));
  PetscCall(MpmModelSetUp(*model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The points of the explicit model as they are, with their stress and history, in the other one. */
static PetscErrorCode CopyPoints(MpmModel from, MpmModel to)
{
  const MpmParticles *particles = to->state.particles;
  const PetscInt      dim       = to->disc.dim;
  MpmPoints           a, b;

  PetscFunctionBeginUser;
  PetscCall(MpmParticlesRestoreArrays(to->state.particles, to->disc.points));
  PetscCall(MpmParticlesGetArrays(from->state.particles, &a));
  PetscCall(MpmParticlesGetArrays(to->state.particles, &b));
  PetscCheck(a.count == b.count, PETSC_COMM_SELF, PETSC_ERR_USER, "the scenes have different points");
  for (PetscInt p = 0; p < a.count; p++)
    PetscCheck(a.id[p] == b.id[p], PETSC_COMM_SELF, PETSC_ERR_USER, "the scenes have different points");
  PetscCall(PetscArraycpy(b.x, a.x, a.count * dim));
  PetscCall(PetscArraycpy(b.F, a.F, a.count * dim * dim));
  PetscCall(PetscArraycpy(b.stress, a.stress, a.count * particles->stress_size));
  PetscCall(PetscArraycpy(b.state, a.state, a.count * particles->state_size));
  PetscCall(MpmParticlesRestoreArrays(from->state.particles, &a));
  PetscCall(MpmParticlesRestoreArrays(to->state.particles, &b));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A quasi-static step from there, with displacements at which its residual is asked for. */
static PetscErrorCode Prepare(Bench *bench, MpmModel from)
{
  MpmModel   model = bench->fixed;
  MpmOutcome outcome;

  PetscFunctionBeginUser;
  PetscCall(CopyPoints(from, model));
  PetscCall(MpmStepPrepare(model, model->state.dt.nominal, model->state.dt.nominal, PETSC_FALSE, &outcome));
  PetscCheck(!outcome.code, model->comm, PETSC_ERR_PLIB, "%s", outcome.text);
  for (PetscInt k = 0; k < 2; k++) {
    PetscInt     count;
    PetscScalar *u;

    PetscCall(VecDestroy(&bench->x[k]));
    PetscCall(VecDuplicate(model->solver.x, &bench->x[k]));
    PetscCall(VecGetLocalSize(bench->x[k], &count));
    PetscCall(VecGetArrayWrite(bench->x[k], &u));
    for (PetscInt i = 0; i < count; i++)
      u[i] = BENCH_STRAIN * model->disc.grid->h[0] * PetscSinReal((PetscReal)(i + k));
    PetscCall(VecRestoreArrayWrite(bench->x[k], &u));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* So many residuals; what a first one finds cold is not counted. */
static PetscErrorCode Residuals(Bench *bench)
{
  PetscReal since = 0.;

  PetscFunctionBeginUser;
  for (PetscInt k = -1; k < bench->steps; k++) {
    if (!k) since = Now();
    PetscCall(SNESComputeFunction(bench->fixed->solver.snes, bench->x[k & 1], bench->fixed->solver.f));
  }
  PetscCall(PetscPrintf(PETSC_COMM_WORLD, "residual_ns %.6g\n",
                        (double)(1e9 * (Now() - since) / ((PetscReal)bench->steps * bench->points))));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Before each explicit step: at the end of a round the quasi-static model has its turn. */
static PetscErrorCode Before(MpmModel model, void *ctx)
{
  Bench         *bench = (Bench *)ctx;
  const PetscInt step  = bench->step++ - BENCH_WARM; /* of the rounds, from 0 */

  PetscFunctionBeginUser;
  if (step > 0 && step % (bench->steps + 1) == 1) bench->since = Now(); /* a first step is not counted, either */
  if (step < 0 || step % (bench->steps + 1)) PetscFunctionReturn(PETSC_SUCCESS);
  if (step)
    PetscCall(PetscPrintf(PETSC_COMM_WORLD, "explicit_ns %.6g\n",
                          (double)(1e9 * (Now() - bench->since) / ((PetscReal)bench->steps * bench->points))));
  if (step / (bench->steps + 1) == bench->rounds) PetscCall(MpmModelStop(model));
  else {
    PetscCall(Prepare(bench, model));
    PetscCall(Residuals(bench));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- iterations ---- */

/* Points that have moved over the grid: at the start they stand in its cells as they were made. */
static PetscErrorCode ShiftPoints(MpmModel model)
{
  const PetscInt dim = model->disc.dim;
  MpmPoints      points;

  PetscFunctionBeginUser;
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  for (PetscInt p = 0; p < points.count; p++)
    for (PetscInt a = 0; a < dim; a++) points.x[p * dim + a] += BENCH_SHIFT * model->disc.grid->h[a];
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Newton's method has done enough after so many iterations, here as there. */
static PetscErrorCode Enough(SNES snes, PetscInt it, PetscReal xnorm, PetscReal gnorm, PetscReal fnorm,
                             SNESConvergedReason *reason, void *ctx)
{
  (void)snes, (void)xnorm, (void)gnorm, (void)fnorm, (void)ctx;
  *reason = it == BENCH_ITERATIONS ? SNES_CONVERGED_ITS : SNES_CONVERGED_ITERATING;
  return 0;
}

/* A model's next step. It is accepted where it has no name, otherwise timed and taken back. */
static PetscErrorCode Iterations(MpmModel model, const char *name)
{
  const MpmIntegrator *integrator = model->state.scheme.integrator;
  const PetscReal      points = (PetscReal)model->state.particles->total, dt = model->state.dt.nominal, since = Now();
  PetscReal            solve;
  MpmOutcome           outcome;

  PetscFunctionBeginUser;
  PetscCall(integrator->begin(model, model->state.time + dt, dt, PETSC_FALSE, &outcome));
  PetscCheck(!outcome.code, model->comm, PETSC_ERR_PLIB, "%s", outcome.text);
  PetscCall(integrator->predict(model));
  if (name) PetscCall(SNESSetConvergenceTest(model->solver.snes, Enough, NULL, NULL));
  solve = Now();
  PetscCall(integrator->solve(model, &outcome));
  solve = Now() - solve;
  PetscCheck(!outcome.code, model->comm, PETSC_ERR_NOT_CONVERGED, "%s", outcome.text);
  PetscCall((name ? integrator->roll_back : integrator->accept)(model));
  if (!name) {
    model->state.time += dt;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(PetscPrintf(PETSC_COMM_WORLD, "%s_ns %.6g\nstep_%s_ns %.6g\n%s_newton %g\n", name,
                        (double)(1e9 * solve / (points * (PetscReal)model->solver.iterations.newton)), name,
                        (double)(1e9 * (Now() - since) / (points * (PetscReal)model->solver.iterations.newton)), name,
                        (double)model->solver.iterations.newton));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode CompareIterations(Bench *bench)
{
  MpmModel model;

  PetscFunctionBeginUser;
  PetscCall(CreateModel("-bench_implicit", &model));
  PetscCall(PetscPrintf(PETSC_COMM_WORLD, "points %g\n", (double)model->state.particles->total));
  PetscCall(ShiftPoints(model));
  PetscCall(Iterations(model, NULL));
  PetscCall(Iterations(bench->fixed, NULL));
  PetscCall(CopyPoints(model, bench->fixed));
  for (PetscInt round = 0; round < bench->rounds; round++) {
    PetscCall(Iterations(bench->fixed, "static"));
    PetscCall(Iterations(model, "implicit"));
  }
  PetscCall(MpmModelDestroy(&model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode CompareSteps(Bench *bench, int *status)
{
  MpmModel model;

  PetscFunctionBeginUser;
  PetscCall(CreateModel("-bench_explicit", &model));
  bench->points = (PetscReal)model->state.particles->total;
  PetscCall(PetscPrintf(PETSC_COMM_WORLD, "points %g\n", (double)bench->points));
  PetscCall(MpmModelSetBeforeStep(model, Before, bench));
  PetscCall(MpmModelRun(model, status));
  PetscCheck(*status == 0, PETSC_COMM_WORLD, PETSC_ERR_NOT_CONVERGED, "the explicit run gave up");
  PetscCall(MpmModelDestroy(&model));
  for (PetscInt k = 0; k < 2; k++) PetscCall(VecDestroy(&bench->x[k]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

int main(int argc, char **argv)
{
  Bench       bench = {.rounds = 5, .steps = 10};
  PetscBool   implicit;
  PetscMPIInt size;
  int         status = 0;

  PetscCall(PetscInitialize(&argc, &argv, NULL, "bench_dynamics -bench_explicit SCENE -bench_static SCENE\n"));
  PetscCallMPI(MPI_Comm_size(PETSC_COMM_WORLD, &size));
  PetscCheck(size == 1, PETSC_COMM_WORLD, PETSC_ERR_SUP, "the comparison is made on one rank");
  PetscCall(PetscOptionsGetInt(NULL, NULL, "-bench_rounds", &bench.rounds, NULL));
  PetscCall(PetscOptionsGetInt(NULL, NULL, "-bench_steps", &bench.steps, NULL));
  PetscCall(CreateModel("-bench_static", &bench.fixed));
  PetscCall(PetscOptionsHasName(NULL, NULL, "-bench_implicit", &implicit));
  if (implicit) PetscCall(CompareIterations(&bench));
  else PetscCall(CompareSteps(&bench, &status));
  PetscCall(MpmModelDestroy(&bench.fixed));
  PetscCall(PetscFinalize());
  return status;
}

/*
  A step of the tape at its solution: data for the sums of its derivatives, solves with its Jacobian, and derivatives of
  changes without a step, before it.
*/
#include "point/layout.h"
#include "particles/body.h"
#include "particles/particles.h"
#include "particles/points.h"
#include "space/space.h"
#include "space/sum.h"
#include "bc/bc.h"
#include "problem/evaluation.h"
#include "query/point_vector.h"
#include "step/step.h"
#include "integrators/sdirk.h"
#include "sensitivity/replayed_step.h"

#define MOST_OWN 16    /* numbers that a physics keeps of a point */
#define RTOL     1e-12 /* of solves with the Jacobian, unless -gradient_ksp_rtol has another */

static PetscBool AnyResets(const MpmModel model)
{
  for (PetscInt k = 0; k < model->scene.stages.count; k++)
    if (model->scene.stages.at[k].reset) return PETSC_TRUE;
  return PETSC_FALSE;
}

MpmStepConstants MpmGradientConstants(const MpmModel model)
{
  return (MpmStepConstants){AnyResets(model), MpmGradientStartDiffers(model)};
}

/* The solver is a Krylov method of its own around the model's preconditioner. */
PetscErrorCode MpmReplayedStepLinearise(MpmModel model, MpmReplayedStep *step)
{
  KSP *const ksp = &step->ksp;
  KSP        own;
  PC         pc;
  Mat        J, P;

  PetscFunctionBeginUser;
  PetscCall(MpmSolverLinearise(&model->solver, model->solver.x, &J, &own));
  PetscCall(KSPGetOperators(own, &J, &P));
  PetscCall(KSPGetPC(own, &pc));
  PetscCall(KSPCreate(model->comm, ksp));
  PetscCall(KSPSetOptionsPrefix(*ksp, "gradient_"));
  PetscCall(KSPSetPC(*ksp, pc));
  PetscCall(KSPSetOperators(*ksp, J, P));
  PetscCall(KSPSetType(*ksp, KSPGMRES));
  PetscCall(KSPGMRESSetRestart(*ksp, 100));
  PetscCall(KSPSetTolerances(*ksp, RTOL, PETSC_DEFAULT, PETSC_DEFAULT, 1000));
  PetscCall(KSPSetSkipPCSetFromOptions(*ksp, PETSC_TRUE)); /* the preconditioner has its factors */
  PetscCall(KSPSetFromOptions(*ksp));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmReplayedStepCreate(MpmModel model, MpmReplayedStep *step)
{
  const MpmDiscretization *disc  = &model->disc;
  const PetscInt           count = disc->space->local * disc->block, loads = model->scene.loads->count;
  MpmRules                *rules;

  PetscFunctionBeginUser;
  PetscCall(PetscNew(&rules));
  *rules    = MpmStepRules(model, model->state.time + disc->sum->step.span);
  step->ksp = NULL;
  PetscCall(VecDuplicate(model->solver.x, &step->right));
  PetscCall(VecDuplicate(model->solver.x, &step->solution));
  PetscCall(PetscMalloc2((count + 1), &step->u, (loads + 1), &step->factors));
  PetscCall(MpmEvaluationNodes(disc, model->solver.x, step->u));
  for (PetscInt l = 0; l < loads; l++) step->factors[l] = MpmStepLoadFactor(model, l, rules->time.end);
  step->map = (MpmStepMap){.rules      = rules,
                           .sum        = disc->sum,
                           .physics    = &model->scene.physics,
                           .particles  = model->state.particles,
                           .parameters = &model->gradient->parameters,
                           .grounds    = &model->gradient->grounds,
                           .u          = step->u,
                           .constants  = MpmGradientConstants(model),
                           .load_count = loads,
                           .loads      = model->scene.loads->at,
                           .factors    = step->factors,
                           .surfaces   = disc->context.surfaces};
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MpmReplayedAddFlow(const MpmModel model, const PetscReal from[], PetscReal to[])
{
  const PetscInt bs = model->disc.block;

  for (PetscInt k = 0; k < model->disc.space->local * bs; k++)
    if (!model->disc.layout->component[k % bs].increment) to[k] += MPM_SDIRK_THETA * from[k];
}

PetscErrorCode MpmReplayedStepDestroy(MpmReplayedStep *step)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(step->map.rules));
  PetscCall(PetscFree2(step->u, step->factors));
  PetscCall(KSPDestroy(&step->ksp));
  PetscCall(VecDestroy(&step->right));
  PetscCall(VecDestroy(&step->solution));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Forces at the nodes, a rank's part, to the owners' equations. */
static PetscErrorCode ToEquations(MpmModel model, PetscReal nodal[], Vec vec)
{
  const MpmConstraints *constraints = model->disc.constraints;
  const PetscInt        count       = model->disc.space->owned * model->disc.block;
  PetscScalar          *values;

  PetscFunctionBeginUser;
  MpmConstraintsGather(constraints, model->disc.space, nodal);
  PetscCall(MpmSpaceAddToOwners(model->disc.space, model->disc.block, nodal));
  MpmFramesToUnknowns(constraints, model->disc.block, model->disc.space->owned, nodal);
  PetscCall(VecGetArrayWrite(vec, &values));
  PetscCall(PetscArraycpy(values, nodal, count));
  MpmUnitsTimes(constraints, count, values);
  MpmConstraintsZero(constraints, count, values);
  PetscCall(VecRestoreArrayWrite(vec, &values));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmReplayedSolve(MpmModel model, const MpmReplayedStep *step, PetscBool transposed, PetscReal b[],
                                PetscReal y[])
{
  KSPConvergedReason reason;

  PetscFunctionBeginUser;
  PetscCall(ToEquations(model, b, step->right));
  if (transposed && !model->solver.definite.symmetric)
    PetscCall(KSPSolveTranspose(step->ksp, step->right, step->solution));
  else PetscCall(KSPSolve(step->ksp, step->right, step->solution));
  PetscCall(KSPGetConvergedReason(step->ksp, &reason));
  PetscCheck(reason > 0, model->comm, PETSC_ERR_NOT_CONVERGED, "a linear solve of the gradient did not converge: %s",
             KSPConvergedReasons[reason]);
  PetscCall(MpmEvaluationNodes(&model->disc, step->solution, y));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  ---- between steps ----

  Points are the same before and after, but for those that join, whose state has no derivative, and those that are gone.
  Where displacements begin anew the position from which they count becomes that of the points.
*/

/* True where step n is the first one of the run; a geostatic stage, which comes first, has none. */
static PetscBool IsFirst(const MpmTape *tape, PetscInt n)
{
  return (PetscBool)(!n && !tape->step[n].stage);
}

/* True where displacements begin anew at the start of step n. */
static PetscBool Resets(const MpmModel model, PetscInt n, const MpmPointVector *vector)
{
  const MpmTape *tape = &model->gradient->tape;

  return (PetscBool)(vector->size[MPM_VECTOR_ORIGIN] && MpmTapeBeginsStage(tape, n) &&
                     model->scene.stages.at[tape->step[n].stage].reset);
}

/*
  Points that join at the start of step n, where masses are the points' own: the relative change of theirs with a
  density; with a sum its derivative, from the bars in `vector`.
*/
static void Joining(const MpmModel model, PetscInt n, const MpmStepMap *map, PetscInt parameter, PetscReal *sum,
                    MpmPointVector *vector)
{
  const MpmTape           *tape   = &model->gradient->tape;
  const MpmSceneParameter *of     = parameter < 0 ? NULL : &map->parameters->at[parameter];
  const MpmPoints         *points = map->sum->points;
  const PetscBool         *adds   = model->scene.stages.at[tape->step[n].stage].adds;

  if (!vector->size[MPM_VECTOR_MASS] || IsFirst(tape, n) || !MpmTapeBeginsStage(tape, n)) return;
  if (!of || of->kind != MPM_OF_LAW || !of->density) return;
  for (PetscInt b = 0; b < model->scene.bodies->count; b++) {
    PetscInt first, end;

    if (!adds[b]) continue;
    MpmBodyGetIds(model->scene.bodies->at[b], &first, &end);
    for (PetscInt p = 0; p < points->count; p++) {
      PetscReal *mass = &vector->at[MPM_VECTOR_MASS][p];

      if (points->id[p] < first || points->id[p] >= end || points->material[p] != of->index) continue;
      if (sum) *sum += *mass / of->value;
      else *mass += 1. / of->value;
    }
  }
}

/* True where point p begins with the physics' own states of its material at the start of step n. */
static PetscBool BeginsAtRest(const MpmModel model, PetscInt n, const MpmStepMap *map, PetscInt p)
{
  const MpmTape   *tape = &model->gradient->tape;
  const PetscInt   id   = map->sum->points->id[p];
  const PetscBool *adds = model->scene.stages.at[tape->step[n].stage].adds;

  if (IsFirst(tape, n)) return (PetscBool)!model->gradient->start.at;
  for (PetscInt b = 0; MpmTapeBeginsStage(tape, n) && b < model->scene.bodies->count; b++) {
    PetscInt first, end;

    MpmBodyGetIds(model->scene.bodies->at[b], &first, &end);
    if (adds[b] && id >= first && id < end) return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* Their change with a parameter; with a sum its derivative, from the bars in `vector`. */
static void OwnAtRest(const MpmModel model, PetscInt n, const MpmStepMap *map, PetscInt parameter, PetscReal *sum,
                      MpmPointVector *vector)
{
  const MpmSceneParameter *of               = &map->parameters->at[parameter];
  const MpmPoints         *points           = map->sum->points;
  const PetscInt           size             = vector->size[MPM_VECTOR_OWN];
  double                   change[MOST_OWN] = {0.};

  if (!size || of->kind != MPM_OF_PHYSICS || !map->physics->initial_change) return;
  map->physics->initial_change((int)of->place, change);
  for (PetscInt p = 0; p < points->count; p++) {
    if ((of->index >= 0 && points->material[p] != of->index) || !BeginsAtRest(model, n, map, p)) continue;
    for (PetscInt k = 0; k < size; k++) {
      PetscReal *own = &vector->at[MPM_VECTOR_OWN][p * size + k];

      if (sum) *sum += *own * change[k];
      else *own += change[k];
    }
  }
}

void MpmStageAlong(const MpmModel model, PetscInt n, const MpmStepMap *map, PetscInt parameter, MpmPointVector *vector)
{
  PetscReal *origin = vector->at[MPM_VECTOR_ORIGIN];

  if (parameter >= 0) Joining(model, n, map, parameter, NULL, vector);
  if (parameter >= 0) OwnAtRest(model, n, map, parameter, NULL, vector);
  if (!Resets(model, n, vector)) return;
  for (PetscInt k = 0; k < vector->count * vector->dim; k++) origin[k] = vector->x[k];
}

void MpmStagePull(const MpmModel model, PetscInt n, const MpmStepMap *map, PetscReal gradient[], MpmPointVector *vector)
{
  PetscReal *origin = vector->at[MPM_VECTOR_ORIGIN];

  for (PetscInt k = 0; k < map->parameters->count; k++) {
    Joining(model, n, map, k, &gradient[k], vector);
    OwnAtRest(model, n, map, k, &gradient[k], vector);
  }
  if (!Resets(model, n, vector)) return;
  for (PetscInt k = 0; k < vector->count * vector->dim; k++) {
    vector->x[k] += origin[k];
    origin[k] = 0.;
  }
}

/* ---- the run's start ---- */

void MpmStartSlopes(const MpmGradient *gradient, PetscReal slopes[])
{
  const MpmGradientStart *start = &gradient->start;
  const PetscInt          count = gradient->objectives.count;

  for (PetscInt k = 0; start->slopes && k < gradient->parameters.count; k++)
    for (PetscInt i = 0; i < start->rows * count; i++)
      slopes[k * gradient->rows * count + i] = start->slopes[k * start->rows * count + i];
}

/* The sum of products of all fields. */
static PetscReal Dot(const MpmPointVector *one, const MpmPointVector *other)
{
  PetscReal sum = 0.;

  for (PetscInt f = 0; f < MPM_VECTOR_FIELDS; f++)
    for (PetscInt i = 0; i < one->count * one->size[f]; i++) sum += one->at[f][i] * other->at[f][i];
  return sum;
}

PetscErrorCode MpmStartPull(MpmModel model, const MpmPointVector *vector, PetscReal values[])
{
  const MpmGradient      *gradient = model->gradient;
  const MpmGradientStart *start    = &gradient->start;
  const PetscInt          count    = gradient->objectives.count;

  PetscFunctionBeginUser;
  if (!start->at) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt k = 0; k < gradient->parameters.count; k++) {
    MpmPointVector here = {0};

    PetscCall(MpmPointVectorCopy(&start->at[k], PETSC_FALSE, &here));
    PetscCall(MpmPointVectorMove(model->comm, vector, &here));
    values[k] += Dot(&here, &start->at[k]);
    PetscCall(MpmPointVectorDestroy(&here));
    for (PetscInt o = 0; !model->rank && o < count; o++)
      for (PetscInt n = 0; n < start->rows; n++)
        values[k] += gradient->weights[o * gradient->rows + n] * start->slopes[(k * start->rows + n) * count + o];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  The steps of a run, kept in memory and replayed.
*/
#include "particles/particles.h"
#include "space/space.h"
#include "space/sum.h"
#include "step/integrator.h"
#include "schedule/schedule.h"
#include "sensitivity/tape.h"

/* Keeps the present state. */
static PetscErrorCode Keep(MpmModel model, MpmTape *tape, MpmStateKept *kept)
{
  const MpmParticles *particles = model->state.particles;
  PetscInt            count;
  PetscReal           bytes = 0.;

  PetscFunctionBeginUser;
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, model->disc.points));
  PetscCall(MpmStateCopy(&model->state, kept));
  PetscCall(DMSwarmGetLocalSize(particles->swarm, &count));
  for (PetscInt k = 0; k < particles->field_count; k++)
    bytes += (PetscReal)(particles->fields[k].components * count) *
             (particles->fields[k].integer ? (PetscReal)sizeof(PetscInt) : (PetscReal)sizeof(PetscReal));
  tape->bytes += bytes;
  bytes = tape->bytes;
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &bytes, 1, MPIU_REAL, MPIU_SUM, model->comm));
  MpmCheckInput(bytes <= tape->limit,
                "-mpm_gradient_memory %g: is too little: %" PetscInt_FMT " steps with their points take %g bytes",
                (double)tape->limit, tape->count, (double)bytes);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTapeBegin(MpmModel model, MpmTape *tape)
{
  PetscFunctionBeginUser;
  PetscCall(Keep(model, tape, &tape->end));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTapeRecord(MpmModel model, MpmTape *tape)
{
  const PetscScalar *x;
  MpmTapeStep       *step;

  PetscFunctionBeginUser;
  if (tape->count == tape->capacity) {
    tape->capacity = 2 * tape->capacity + 16;
    PetscCall(PetscRealloc((size_t)tape->capacity * sizeof(*tape->step), &tape->step));
  }
  step        = &tape->step[tape->count++];
  step->start = tape->end;
  step->time  = model->state.time;
  step->dt    = model->disc.sum->step.dt;
  step->count = model->disc.space->owned * model->disc.block;
  PetscCall(PetscMalloc1((step->count + 1), &step->x));
  PetscCall(VecGetArrayRead(model->solver.x, &x));
  PetscCall(PetscArraycpy(step->x, x, step->count));
  PetscCall(VecRestoreArrayRead(model->solver.x, &x));
  tape->bytes += (PetscReal)step->count * (PetscReal)sizeof(PetscScalar);
  PetscCall(PetscMemzero(&tape->end, sizeof(tape->end)));
  PetscCall(Keep(model, tape, &tape->end));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTapeReplay(MpmModel model, MpmTape *tape, PetscInt n)
{
  MpmTapeStep *step = &tape->step[n];
  PetscScalar *x;
  MpmOutcome   outcome;

  PetscFunctionBeginUser;
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, model->disc.points));
  PetscCall(MpmStateReturn(&model->state, &step->start));
  PetscCall(MpmStateCopy(&model->state, &step->start));
  PetscCall(MpmStepArrange(model, &outcome));
  if (!outcome.code)
    PetscCall((*model->state.scheme.integrator->begin)(model, step->time, step->dt, PETSC_FALSE, &outcome));
  PetscCheck(!outcome.code && step->count == model->disc.space->owned * model->disc.block, model->comm, PETSC_ERR_PLIB,
             "step %" PetscInt_FMT " cannot be replayed: %s", n + 1, outcome.code ? outcome.text : "other unknowns");
  PetscCall(VecGetArrayWrite(model->solver.x, &x));
  PetscCall(PetscArraycpy(x, step->x, step->count));
  PetscCall(VecRestoreArrayWrite(model->solver.x, &x));
  PetscCall(SNESComputeFunction(model->solver.snes, model->solver.x, model->solver.f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTapeFinish(MpmModel model, MpmTape *tape)
{
  PetscFunctionBeginUser;
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, model->disc.points));
  PetscCall(MpmStateReturn(&model->state, &tape->end));
  PetscCall(PetscMemzero(&tape->end, sizeof(tape->end)));
  PetscCall(MpmTapeDestroy(tape));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTapeDestroy(MpmTape *tape)
{
  PetscFunctionBeginUser;
  for (PetscInt n = 0; n < tape->count; n++) {
    PetscCall(MpmStateForget(&tape->step[n].start));
    PetscCall(PetscFree(tape->step[n].x));
  }
  if (tape->end.points) PetscCall(MpmStateForget(&tape->end));
  PetscCall(PetscFree(tape->step));
  tape->count = tape->capacity = 0;
  tape->bytes                  = 0.;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  The error of an implicit step with inertia.
*/
#include "grid/grid.h"
#include "space/space.h"
#include "space/sum.h"
#include "transfer/momentum.h"
#include "transfer/motion.h"
#include "bc/bc.h"
#include "volume/inertia.h"
#include "query/model.h"
#include "query/query.h"
#include "integrators/dynamics.h"

/*
  Change of the points' accelerations in the step, at the owned nodes, as resolved by the points: M^-1 M_c a_new less
  the points', weighted by mass. Motion of nodes on the scale of cells, which points hardly resolve and do not carry on
  to the next step, does not count: shorter steps do not reduce it. Bodies have no points: there it is a_new - a.
*/
static PetscErrorCode FindChange(MpmModel model, PetscReal change[])
{
  const PetscInt  dim = model->disc.dim, extra = dim * model->disc.space->extra.begin;
  const PetscBool euler    = (PetscBool)(MpmModelMotion(model)->type == MPM_BACKWARD_EULER);
  MpmDynamics    *dynamics = model->state.scheme.dynamics;
  PetscReal      *a        = dynamics->a_new, *mass;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < dynamics->local * dim; k++)
    a[k] = dynamics->a_factor * model->disc.nodal.u[k] + dynamics->a_rest[k];
  PetscCall(MpmMotionFeel(model->disc.sum, a, change));
  for (PetscInt k = 0; k < model->disc.context.inertia->owned * dim; k++) {
    if (k >= extra) change[k] = a[k] - (euler ? 0. : dynamics->a_start[k]);
    else
      change[k] *=
        model->disc.context.inertia->mass[k / dim] > 0. ? 1. / model->disc.context.inertia->mass[k / dim] : 0.;
  }
  if (euler) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(dynamics->local, &mass));
  PetscCall(MpmMomentumToNodes(model->disc.sum, &MpmModelMotion(model)->transfer, mass, dynamics->v_new, a));
  for (PetscInt k = 0; k < PetscMin(model->disc.context.inertia->owned * dim, extra); k++)
    change[k] -= model->disc.grid->order == 1 ? a[k] : mass[k / dim] != 0. ? a[k] / mass[k / dim] : 0.;
  PetscCall(PetscFree(mass));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Error of the step's displacement if the acceleration goes on changing as it has, per length of the step, over the
  largest velocity of the stage; norms are weighted by mass. Source: Zienkiewicz, Xie (1991), Earthq. Eng. Struct. Dyn.
  20, 871-887, doi:10.1002/eqe.4290200907.
*/
PetscErrorCode MpmDynamicsError(MpmModel model, PetscReal *estimate)
{
  const MpmDynamics *dynamics = model->state.scheme.dynamics;
  const PetscBool    euler    = (PetscBool)(MpmModelMotion(model)->type == MPM_BACKWARD_EULER);
  const PetscReal    by = euler ? 0.5 : MpmTimeMethodOf(model).beta - 1. / 6., dt = model->disc.sum->step.dt;
  const PetscInt     dim     = model->disc.dim;
  PetscReal          sums[2] = {0., 0.}, *largest = &model->state.scheme.error.trial;
  PetscReal         *change;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1((model->disc.context.inertia->owned * dim), &change));
  PetscCall(FindChange(model, change));
  for (PetscInt k = 0; k < model->disc.context.inertia->owned * dim; k++) {
    const PetscReal v = dynamics->v_factor * model->disc.nodal.u[k] + dynamics->v_rest[k];
    const PetscReal e = by * dt * change[k];

    if (!MpmConstraintsFree(model->disc.constraints, k)) continue;
    sums[0] += model->disc.context.inertia->mass[k / dim] * e * e;
    sums[1] += model->disc.context.inertia->mass[k / dim] * v * v;
  }
  PetscCall(PetscFree(change));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, sums, 2, MPIU_REAL, MPIU_SUM, model->comm));
  *largest  = PetscMax(model->state.scheme.error.largest, PetscSqrtReal(sums[1]));
  *estimate = *largest > 0. ? PetscSqrtReal(sums[0]) / *largest : 0.;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Inlets of material by a hydrograph. Nodes from a cell behind the line to a cell beyond it have the velocity with which
  material comes in, as long as it does: columns go on through the first cell at that velocity, and press on those ahead
  with their whole depth.
*/
#include "grid/grid.h"
#include "space/space.h"
#include "space/sum.h"
#include "entrainment/entrainment_impl.h"

#define SLACK 1e-6 /* of a cell */

/* True where an inlet sets a node's velocity. */
static PetscBool Holds(const MpmInlet *inlet, const MpmGrid *grid, const PetscReal x[])
{
  PetscReal along = 0., across = 0., reach = 0., slack = SLACK * PetscMin(grid->h[0], grid->h[1]);

  for (PetscInt a = 0; a < 2; a++) {
    along += (x[a] - inlet->from[a]) * inlet->along[a];
    across += (x[a] - inlet->from[a]) * inlet->normal[a];
    reach += PetscAbsReal(inlet->normal[a]) * grid->h[a];
  }
  return (PetscBool)(PetscAbsReal(across) <= reach + slack && along >= -slack && along <= inlet->width + slack);
}

PetscErrorCode MpmInletsHold(MpmEntrainment *of, const MpmSum *sum, const PetscReal mass[], PetscReal kick,
                             PetscReal velocity[])
{
  const PetscInt local = sum->space->local;

  PetscFunctionBeginUser;
  if (local > of->room) {
    of->room = local + local / 8;
    PetscCall(PetscFree(of->push));
    PetscCall(PetscMalloc1((size_t)(2 * of->room), &of->push));
  }
  PetscCall(PetscArrayzero(of->push, 2 * local));
  for (PetscInt k = 0; k < of->inlets; k++) {
    const PetscReal speed = MpmInletVelocity(of->inlet[k], *of->time);

    for (PetscInt i = 0; speed > 0. && i < local; i++) {
      PetscReal x[MPM_MAX_DIM];

      if (!(mass[i] > 0.)) continue;
      MpmGridNodeAtStart(sum->grid, &sum->space->node[i * 2], x);
      if (!Holds(of->inlet[k], sum->grid, x)) continue;
      for (PetscInt a = 0; a < 2; a++) {
        const PetscReal to = speed * of->inlet[k]->normal[a];

        of->push[2 * i + a] += mass[i] * (to - velocity[i * sum->block + a]) / kick;
        velocity[i * sum->block + a] = to;
      }
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscReal MpmEntrainmentCrossing(const MpmModel model, PetscReal gravity)
{
  const PetscReal      *h     = model->disc.grid->h;
  const MpmEntrainment *of    = model->entrainment;
  PetscReal             least = PETSC_MAX_REAL;

  for (PetscInt k = 0; of && k < of->inlets; k++) {
    const PetscReal speed = MpmInletVelocity(of->inlet[k], model->state.time);
    const PetscReal c     = PetscSqrtReal(gravity * MpmInletDepth(of->inlet[k], model->state.time));

    for (PetscInt a = 0; speed > 0. && a < 2; a++)
      least = PetscMin(least, h[a] / (c + speed * PetscAbsReal(of->inlet[k]->normal[a])));
  }
  return least;
}

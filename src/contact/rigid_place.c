/*
  Places of rigid bodies that are solved for: initially, as a step begins, after an increment, and in the report.
*/
#include "geometry/geometry.h"
#include "space/rules.h"
#include "contact/contact.h"
#include "contact/rigid_body.h"

#include <math.h>

void MpmRigidStart(PetscInt count, const MpmBoundary boundaries[], MpmPlacement placements[])
{
  for (PetscInt b = 0; b < count; b++) {
    placements[b].turn[0] = 1.;
    for (PetscInt a = 0; boundaries[b].freedom && a < boundaries[b].dim; a++)
      placements[b].velocity[a] = boundaries[b].freedom->velocity[a];
  }
}

PetscErrorCode MpmRigidCreate(MpmContacts *contacts, MpmPlacement *placements)
{
  PetscBool any = PETSC_FALSE;

  PetscFunctionBeginUser;
  for (PetscInt b = 0; b < contacts->facets.boundary_count; b++)
    any = (PetscBool)(any || contacts->facets.boundaries[b].freedom);
  if (!any) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscCalloc1(contacts->facets.boundary_count, &contacts->facets.bodies));
  for (PetscInt b = 0; b < contacts->facets.boundary_count; b++) {
    contacts->facets.bodies[b].freedom   = contacts->facets.boundaries[b].freedom;
    contacts->facets.bodies[b].placement = &placements[b];
    contacts->facets.bodies[b].dim       = contacts->facets.boundaries[b].dim;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* True in a step that ends within geostatic stages at the run's start: the body keeps its place and has no load. */
static PetscBool StandsStill(const MpmFreedom *freedom, PetscReal time)
{
  return (PetscBool)(freedom->still > 0. && time <= freedom->still * (1. + 1e3 * PETSC_MACHINE_EPSILON));
}

/* Factor of load and moment at a time, which counts from the end of such stages. */
static PetscReal LoadFactor(const MpmFreedom *freedom, PetscReal time)
{
  return StandsStill(freedom, time) ? 0. : MpmRampEvaluate(freedom->ramp, PetscMax(time - freedom->still, 0.));
}

void MpmRigidBegin(MpmContacts *contacts, const MpmRules *rules)
{
  const PetscReal part = rules->time.load_at_start;

  contacts->adrift = -1;
  for (PetscInt b = 0; contacts->facets.bodies && b < contacts->facets.boundary_count; b++) {
    MpmRigidBody      *body     = &contacts->facets.bodies[b];
    const MpmBoundary *boundary = &contacts->facets.boundaries[b];

    if (!body->freedom) continue;
    const PetscBool still  = StandsStill(body->freedom, rules->time.end);
    const PetscReal start  = LoadFactor(body->freedom, rules->time.start);
    const PetscReal end    = LoadFactor(body->freedom, rules->time.end);
    const PetscReal factor = still ? 0. : (1. - part) * end + part * start;

    MpmRigidRotation(body->placement->turn, body->Q);
    MpmBoundaryReference(boundary, &contacts->facets.before[b], body->pivot);
    MpmBoundaryReference(boundary, &contacts->facets.after[b], body->travel);
    for (PetscInt a = 0; a < 3; a++) {
      body->travel[a] -= body->pivot[a];
      body->load[a]   = factor * body->freedom->load[a] + (still ? 0. : body->freedom->mass * rules->gravity[a]);
      body->moment[a] = factor * body->freedom->moment[a];
    }
    body->more = still ? 0. : (0.5 - part) * (start - end);
    for (int n = 0; n < 2; n++) body->free[n] = still ? 0 : body->freedom->free[n];
    body->spins = 0;
    body->dt    = rules->dynamic && body->freedom->mass > 0. ? rules->time.end - rules->time.start : 0.;
    for (PetscInt k = 0; k < 6; k++)
      body->guess[k] = body->dt * (body->placement->velocity[k] + 0.5 * body->dt * body->placement->acceleration[k]);
  }
}

void MpmBoundaryAdvance(const MpmContacts *contacts, PetscInt b, PetscInt block, const PetscReal u[],
                        MpmPlacement *placement)
{
  MpmRigidIncrement q;

  if (!MpmFacetsBody(&contacts->facets, b)) return;
  MpmRigidIncrementAt(&contacts->facets.bodies[b], block, u, &q);
  MpmRigidMove(&q, placement);
}

PetscInt MpmRigidReport(const MpmContacts *contacts, PetscInt b, PetscReal values[])
{
  const MpmBoundary *boundary = &contacts->facets.boundaries[b];
  PetscInt           count    = 0;
  PetscReal          reference[MPM_MAX_DIM];

  if (!boundary->freedom) return 0;
  const MpmPlacement *placement = contacts->facets.bodies[b].placement;
  const PetscReal    *turn      = placement->turn;
  const PetscReal     sine      = hypot(hypot(turn[1], turn[2]), turn[3]);
  const PetscReal     angle     = 2. * atan2(sine, turn[0]) * 180. / PETSC_PI;

  MpmBoundaryReference(boundary, &contacts->facets.after[b], reference);
  for (PetscInt a = 0; a < boundary->dim; a++) values[count++] = reference[a] + placement->shift[a];
  for (PetscInt a = MpmRotationAxis(boundary->dim, 0); a < 3; a++)
    values[count++] = sine > 0. ? angle * turn[1 + a] / sine : 0.;
  return count;
}

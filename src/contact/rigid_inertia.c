/*
  Rigid bodies with a mass: velocities and accelerations of their two extra nodes, and their kinetic energy.

  A body's mass is at the node of its translation, its moment of inertia over its size squared at that of its rotation.
*/
#include "contact/contact.h"
#include "contact/rigid_body.h"

void MpmRigidLend(const void *ctx, PetscReal mass[], PetscReal velocity[], PetscReal acceleration[])
{
  const MpmContacts *contacts = (const MpmContacts *)ctx;

  for (PetscInt b = 0; contacts->facets.bodies && b < contacts->facets.boundary_count; b++) {
    const MpmRigidBody *body = &contacts->facets.bodies[b];
    const PetscInt      dim  = body->dim;

    if (!body->freedom || !(body->freedom->mass > 0.)) continue;
    mass[body->node]     = body->freedom->mass;
    mass[body->node + 1] = body->freedom->inertia / PetscSqr(body->freedom->size);
    for (PetscInt n = 0; n < 2; n++) {
      for (PetscInt a = 0; a < dim; a++) {
        velocity[(body->node + n) * dim + a]     = body->placement->velocity[3 * n + a];
        acceleration[(body->node + n) * dim + a] = body->placement->acceleration[3 * n + a];
      }
    }
  }
}

/* Six numbers of a body from its two nodes; constrained components stay 0. */
static void FromNodes(const MpmRigidBody *body, const PetscReal nodal[], PetscReal values[])
{
  for (PetscInt n = 0; n < 2; n++)
    for (PetscInt a = 0; a < body->dim; a++)
      values[3 * n + a] = body->freedom->free[n] >> a & 1 ? nodal[(body->node + n) * body->dim + a] : 0.;
}

void MpmRigidTake(void *ctx, const PetscReal velocity[], const PetscReal acceleration[])
{
  MpmContacts *contacts = (MpmContacts *)ctx;

  for (PetscInt b = 0; contacts->facets.bodies && b < contacts->facets.boundary_count; b++) {
    const MpmRigidBody *body = &contacts->facets.bodies[b];

    if (!body->freedom || !(body->freedom->mass > 0.)) continue;
    if (velocity) FromNodes(body, velocity, body->placement->velocity);
    if (acceleration) FromNodes(body, acceleration, body->placement->acceleration);
  }
}

void MpmRigidRest(void *ctx)
{
  MpmContacts *contacts = (MpmContacts *)ctx;

  for (PetscInt b = 0; contacts->facets.bodies && b < contacts->facets.boundary_count; b++) {
    MpmPlacement *placement = contacts->facets.bodies[b].placement;

    if (!placement) continue;
    for (PetscInt k = 0; k < 6; k++) placement->velocity[k] = placement->acceleration[k] = 0.;
  }
}

PetscReal MpmRigidKinetic(const void *ctx)
{
  const MpmContacts *contacts = (const MpmContacts *)ctx;
  PetscReal          kinetic  = 0.;

  for (PetscInt b = 0; contacts->facets.bodies && b < contacts->facets.boundary_count; b++) {
    const MpmFreedom *freedom = contacts->facets.bodies[b].freedom;

    if (!freedom || !(freedom->mass > 0.)) continue;
    for (PetscInt k = 0; k < 6; k++)
      kinetic += 0.5 * (k < 3 ? freedom->mass : freedom->inertia / PetscSqr(freedom->size)) *
                 PetscSqr(contacts->facets.bodies[b].placement->velocity[k]);
  }
  return kinetic;
}

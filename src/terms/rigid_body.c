/*
  Rigid bodies that are pushed: boundaries with unknowns of their own, solved for with the grid's.

  A free body appends two extra nodes to the step's space: its translation, and its rotation times its size, so that all
  unknowns are lengths and all residuals forces. What its contacts do to nodes and body, and the derivatives, is in
  rigid_motion.c; here it is summed. Its equations say that the forces of the contacts and what pushes the body are in
  balance. Components that nothing resists (the rotation of a smooth disc) have no stiffness: the matrix, not the
  residual, has LIFT times that of a node on the bodies' diagonal, which keeps them where they are.
*/
#include "geometry/geometry.h"
#include "point/material.h"
#include "grid/grid.h"
#include "space/space.h"
#include "space/sum.h"
#include "terms/contact.h"
#include "terms/rigid_body.h"
#include "terms/sparsity.h"
#include "terms/terms.h"

#include <math.h>

#define LIFT 1e-6 /* of a node's stiffness */

PetscErrorCode MpmRigidCreate(MpmContacts *contacts, MpmPlacement *placements)
{
  PetscBool any = PETSC_FALSE;

  PetscFunctionBeginUser;
  for (PetscInt b = 0; b < contacts->boundary_count; b++) any = (PetscBool)(any || contacts->boundaries[b].freedom);
  if (!any) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscCalloc1(contacts->boundary_count, &contacts->bodies));
  for (PetscInt b = 0; b < contacts->boundary_count; b++) {
    contacts->bodies[b].freedom   = contacts->boundaries[b].freedom;
    contacts->bodies[b].placement = &placements[b];
    contacts->bodies[b].dim       = contacts->boundaries[b].dim;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- before the step ---- */

/* Two nodes a body. */
static PetscErrorCode Boxes(void *ctx, const MpmRules *rules, const MpmPoints *points, MpmSpace *space)
{
  MpmContacts *contacts = (MpmContacts *)ctx;

  PetscFunctionBeginUser;
  (void)rules;
  (void)points;
  for (PetscInt b = 0; b < contacts->boundary_count; b++)
    if (contacts->bodies[b].freedom)
      PetscCall(MpmSpaceAppendNodes(space, 2, contacts->bodies[b].freedom->free, &contacts->bodies[b].extra));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MpmRigidBegin(MpmContacts *contacts, const MpmTermStep *step)
{
  contacts->adrift = -1;
  for (PetscInt b = 0; b < contacts->boundary_count; b++) {
    MpmRigidBody      *body     = &contacts->bodies[b];
    const MpmBoundary *boundary = &contacts->boundaries[b];

    if (!body->freedom) continue;
    const PetscReal factor = MpmRampEvaluate(body->freedom->ramp, step->time);

    body->node = step->sum->space->extra.begin + body->extra;
    MpmRigidRotation(body->placement->turn, body->Q);
    MpmBoundaryReference(boundary, &contacts->before[b], body->pivot);
    MpmBoundaryReference(boundary, &contacts->after[b], body->travel);
    for (PetscInt a = 0; a < 3; a++) {
      body->travel[a] -= body->pivot[a];
      body->load[a]   = factor * body->freedom->load[a];
      body->moment[a] = factor * body->freedom->moment[a];
    }
    for (PetscInt k = 0; k < 6; k++) body->guess[k] = 0.;
  }
}

/* The body's equations meet those of the nodes that its contacts touch. */
static PetscErrorCode Link(void *ctx, MpmSpace *space)
{
  const MpmContacts *contacts = (const MpmContacts *)ctx;

  PetscFunctionBeginUser;
  space->extra.link_count = 0;
  for (PetscInt b = 0; b < contacts->boundary_count; b++)
    if (contacts->bodies[b].freedom) PetscCall(MpmSpaceLink(space, -1, contacts->bodies[b].extra, 2));
  for (PetscInt k = 0; k < contacts->count; k++) {
    const MpmContact *contact = &contacts->contact[k], *last = k ? contact - 1 : NULL;

    if (!contacts->bodies[contact->boundary].freedom) continue;
    if (last && last->group == contact->group && last->boundary == contact->boundary) continue;
    PetscCall(MpmSpaceLink(space, contact->group, contacts->bodies[contact->boundary].extra, 2));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- sums ---- */

/* The unknowns' number of a body at its second node. */
static PetscInt Components(const MpmRigidBody *body, PetscInt node)
{
  return node && body->dim == 2 ? 1 : body->dim;
}

/* N/m: what a body's component without any other stiffness gets. */
static PetscReal Lift(const MpmContacts *contacts, const MpmSum *sum)
{
  PetscReal modulus = 0.;

  for (PetscInt m = 0; m < contacts->material_count; m++) modulus = PetscMax(modulus, sum->materials[m].penalty);
  return LIFT * modulus * PetscPowRealInt(1. / contacts->unit, sum->space->dim - 2);
}

/* Does this rank own the bodies' nodes? */
static PetscBool Owns(const MpmSpace *space)
{
  return (PetscBool)(space->extra.begin < space->owned);
}

PetscBool MpmContactAnswerAt(const MpmContacts *contacts, const MpmContact *contact, const MpmRigidIncrement *q,
                             const PetscReal value[], PetscBool derivative, MpmContactAnswer *answer,
                             MpmRigidAnswer *coupled)
{
  const MpmRigidBody *body = &contacts->bodies[contact->boundary];
  PetscReal           seen[MPM_MAX_DIM];

  MpmRigidSee(body, contact, q, value, seen);
  MpmContactEvaluate(contacts, contact, body->dim, seen, answer);
  if (!answer->active) return PETSC_FALSE;
  MpmRigidTurn(body, q, answer);
  MpmRigidCouple(body, contact, q, value, answer, derivative, coupled);
  return PETSC_TRUE;
}

PetscBool MpmContactAnswerFree(const MpmContacts *contacts, const MpmSum *sum, const MpmContact *contact,
                               const PetscReal u[], PetscBool derivative, MpmContactAnswer *answer,
                               MpmRigidAnswer *coupled)
{
  PetscReal         value[MPM_MAX_DIM];
  MpmRigidIncrement q;

  MpmContactFaceValue(contacts, sum, contact, u, value);
  MpmRigidIncrementAt(&contacts->bodies[contact->boundary], sum->block, u, &q);
  return MpmContactAnswerAt(contacts, contact, &q, value, derivative, answer, coupled);
}

void MpmRigidGuess(const MpmContacts *contacts, const MpmSpace *space, PetscInt block, PetscReal factor,
                   PetscScalar x[])
{
  for (PetscInt b = 0; contacts->bodies && b < contacts->boundary_count && Owns(space); b++) {
    const MpmRigidBody *body    = &contacts->bodies[b];
    PetscBool           settled = PETSC_FALSE;

    if (!body->freedom) continue;
    for (PetscInt k = 0; k < 6; k++) settled = (PetscBool)(settled || body->guess[k] != 0.);
    for (PetscInt n = 0; n < 2; n++)
      for (PetscInt a = 0; a < Components(body, n); a++)
        x[(body->node + n) * block + a] = settled ? body->guess[3 * n + a] : factor * body->placement->last[3 * n + a];
  }
}

static PetscErrorCode Residual(const void *ctx, const MpmSum *sum, const PetscReal u[], PetscReal residual[],
                               PetscInt *failed)
{
  const MpmContacts *contacts = (const MpmContacts *)ctx;
  const PetscInt     bs       = sum->block;

  PetscFunctionBeginUser;
  (void)failed;
  for (PetscInt k = 0; k < contacts->count; k++) {
    const MpmContact   *contact = &contacts->contact[k];
    const MpmRigidBody *body    = &contacts->bodies[contact->boundary];
    MpmContactAnswer    answer;
    MpmRigidAnswer      coupled;

    if (!body->freedom || !MpmContactAnswerFree(contacts, sum, contact, u, PETSC_FALSE, &answer, &coupled)) continue;
    MpmContactAddForce(contacts, sum, contact, 1., coupled.residual[0], residual);
    for (PetscInt n = 0; n < 2; n++)
      for (PetscInt a = 0; a < Components(body, n); a++)
        residual[(body->node + n) * bs + a] += coupled.residual[1 + n][a];
  }
  for (PetscInt b = 0; b < contacts->boundary_count && Owns(sum->space); b++) {
    const MpmRigidBody *body = &contacts->bodies[b];
    MpmRigidIncrement   q;
    PetscReal           load[2][3], unused[3][3];

    if (!body->freedom) continue;
    MpmRigidIncrementAt(body, bs, u, &q);
    MpmRigidLoad(body, &q, load, unused);
    for (PetscInt n = 0; n < 2; n++)
      for (PetscInt a = 0; a < Components(body, n); a++) residual[(body->node + n) * bs + a] += load[n][a];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The matrix of a body's own: what its load does, and the lift. */
static void OwnBlock(const MpmContacts *contacts, const MpmSum *sum, const MpmRigidBody *body, const PetscReal u[],
                     PetscReal block[2][3][3])
{
  const PetscReal   lift = Lift(contacts, sum);
  MpmRigidIncrement q;
  PetscReal         load[2][3];

  MpmRigidIncrementAt(body, sum->block, u, &q);
  for (PetscInt k = 0; k < 9; k++) block[0][k / 3][k % 3] = block[1][k / 3][k % 3] = 0.;
  MpmRigidLoad(body, &q, load, block[1]);
  for (PetscInt a = 0; a < 3; a++) block[0][a][a] += lift;
  for (PetscInt a = 0; a < 3; a++) block[1][a][a] += lift;
}

static PetscErrorCode Apply(const void *ctx, const MpmSum *sum, const PetscReal u[], const PetscReal du[],
                            PetscReal y[])
{
  const MpmContacts *contacts = (const MpmContacts *)ctx;
  const PetscInt     bs = sum->block, dim = sum->space->dim;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < contacts->count; k++) {
    const MpmContact   *contact = &contacts->contact[k];
    const MpmRigidBody *body    = &contacts->bodies[contact->boundary];
    MpmContactAnswer    answer;
    MpmRigidAnswer      coupled;
    PetscReal           change[3][3] = {{0.}}, of[3][3] = {{0.}};

    if (!body->freedom || !MpmContactAnswerFree(contacts, sum, contact, u, PETSC_TRUE, &answer, &coupled)) continue;
    MpmContactFaceValue(contacts, sum, contact, du, change[0]);
    for (PetscInt n = 0; n < 2; n++)
      for (PetscInt a = 0; a < Components(body, n); a++) change[1 + n][a] = du[(body->node + n) * bs + a];
    for (PetscInt i = 0; i < 81; i++) {
      const PetscInt g = i / 27, a = i / 9 % 3, h = i / 3 % 3, c = i % 3;

      if (a < (g < 2 ? dim : Components(body, 1)) && c < (h < 2 ? dim : Components(body, 1)))
        of[g][a] += coupled.derivative[g][a][h][c] * change[h][c];
    }
    MpmContactAddForce(contacts, sum, contact, 1., of[0], y);
    for (PetscInt n = 0; n < 2; n++)
      for (PetscInt a = 0; a < Components(body, n); a++) y[(body->node + n) * bs + a] += of[1 + n][a];
  }
  for (PetscInt b = 0; b < contacts->boundary_count && Owns(sum->space); b++) {
    const MpmRigidBody *body = &contacts->bodies[b];
    PetscReal           block[2][3][3];

    if (!body->freedom) continue;
    OwnBlock(contacts, sum, body, u, block);
    for (PetscInt n = 0; n < 2; n++)
      for (PetscInt a = 0; a < Components(body, n); a++)
        for (PetscInt c = 0; c < Components(body, n); c++)
          y[(body->node + n) * bs + a] += block[n][a][c] * du[(body->node + n) * bs + c];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Diagonal(const void *ctx, const MpmSum *sum, const PetscReal u[], PetscReal blocks[],
                               PetscInt *failed)
{
  const MpmContacts *contacts = (const MpmContacts *)ctx;
  const PetscInt     dim = sum->space->dim, bs = sum->block;

  PetscFunctionBeginUser;
  (void)failed;
  for (PetscInt k = 0; k < contacts->count; k++) {
    const MpmContact   *contact = &contacts->contact[k];
    const MpmRigidBody *body    = &contacts->bodies[contact->boundary];
    const MpmGroup     *group   = &sum->space->groups[contact->group];
    const PetscInt     *nodes   = &sum->space->group_nodes[group->node_offset];
    const PetscReal    *weight  = &contacts->weight[contact->weight];
    MpmContactAnswer    answer;
    MpmRigidAnswer      coupled;

    if (!body->freedom || !MpmContactAnswerFree(contacts, sum, contact, u, PETSC_TRUE, &answer, &coupled)) continue;
    for (PetscInt i = 0; i < group->node_count; i++)
      for (PetscInt a = 0; a < dim; a++)
        for (PetscInt c = 0; c < dim; c++)
          blocks[(nodes[i] * bs + a) * bs + c] += weight[i] * weight[i] * coupled.derivative[0][a][0][c];
    for (PetscInt n = 0; n < 2; n++)
      for (PetscInt a = 0; a < Components(body, n); a++)
        for (PetscInt c = 0; c < Components(body, n); c++)
          blocks[((body->node + n) * bs + a) * bs + c] += coupled.derivative[1 + n][a][1 + n][c];
  }
  for (PetscInt b = 0; b < contacts->boundary_count && Owns(sum->space); b++) {
    const MpmRigidBody *body = &contacts->bodies[b];
    PetscReal           block[2][3][3];

    if (!body->freedom) continue;
    OwnBlock(contacts, sum, body, u, block);
    for (PetscInt n = 0; n < 2; n++)
      for (PetscInt a = 0; a < Components(body, n); a++)
        for (PetscInt c = 0; c < Components(body, n); c++)
          blocks[((body->node + n) * bs + a) * bs + c] += block[n][a][c];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* element[i][c][d][j] += of a contact; the body's nodes are the last two of the n. */
static void AddElement(const MpmContacts *contacts, const MpmSum *sum, const MpmContact *contact,
                       const MpmRigidAnswer *coupled, PetscInt n, PetscReal element[])
{
  const MpmRigidBody *body   = &contacts->bodies[contact->boundary];
  const PetscReal    *weight = &contacts->weight[contact->weight];
  const PetscInt      bs     = sum->block;

  for (PetscInt i = 0; i < n; i++) {
    const PetscInt  g    = i < n - 2 ? 0 : i - n + 3;
    const PetscReal left = g ? 1. : weight[i];

    for (PetscInt j = 0; j < n; j++) {
      const PetscInt  h    = j < n - 2 ? 0 : j - n + 3;
      const PetscReal both = left * (h ? 1. : weight[j]);

      for (PetscInt c = 0; c < Components(body, g == 2); c++)
        for (PetscInt d = 0; d < Components(body, h == 2); d++)
          element[((i * bs + c) * bs + d) * n + j] += both * coupled->derivative[g][c][h][d];
    }
  }
}

/* What the bodies have without contacts. */
static PetscErrorCode OwnTangent(const MpmContacts *contacts, const MpmSum *sum, const PetscReal u[],
                                 MpmPattern *pattern)
{
  const PetscInt bs = sum->block;

  PetscFunctionBeginUser;
  for (PetscInt b = 0; b < contacts->boundary_count && Owns(sum->space); b++) {
    const MpmRigidBody *body = &contacts->bodies[b];
    PetscReal           block[2][3][3], element[MPM_MAX_BLOCK * MPM_MAX_BLOCK] = {0.};

    if (!body->freedom) continue;
    OwnBlock(contacts, sum, body, u, block);
    for (PetscInt n = 0; n < 2; n++) {
      const PetscInt node = body->node + n;

      for (PetscInt a = 0; a < Components(body, n); a++)
        for (PetscInt c = 0; c < Components(body, n); c++) element[a * bs + c] = block[n][a][c];
      MpmPatternAddNodes(pattern, sum->space, 1, &node, element);
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Tangent(const void *ctx, const MpmSum *sum, const PetscReal u[], MpmPattern *pattern,
                              PetscReal residual[], PetscInt *failed)
{
  const MpmContacts *contacts = (const MpmContacts *)ctx;
  const MpmSpace    *space    = sum->space;
  const PetscInt     bs = sum->block, most = PetscPowInt(space->width, space->dim) + 2;
  PetscReal         *element;
  PetscInt          *nodes, end;

  PetscFunctionBeginUser;
  if (residual) PetscCall(Residual(ctx, sum, u, residual, failed));
  PetscCall(PetscMalloc2((most * most * bs * bs), &element, most, &nodes));
  for (PetscInt begin = 0; begin < contacts->count; begin = end) { /* contacts of one group stand side by side */
    const MpmContact   *first = &contacts->contact[begin];
    const MpmGroup     *group = &space->groups[first->group];
    const MpmRigidBody *body  = &contacts->bodies[first->boundary];
    const PetscInt      n     = group->node_count + 2;
    PetscBool           any   = PETSC_FALSE;

    end = begin + 1;
    if (!body->freedom) continue;
    PetscCall(PetscArrayzero(element, n * n * bs * bs));
    for (end = begin; end < contacts->count; end++) {
      const MpmContact *contact = &contacts->contact[end];
      MpmContactAnswer  answer;
      MpmRigidAnswer    coupled;

      if (contact->group != first->group || contact->boundary != first->boundary) break;
      if (!MpmContactAnswerFree(contacts, sum, contact, u, PETSC_TRUE, &answer, &coupled)) continue;
      AddElement(contacts, sum, contact, &coupled, n, element);
      any = PETSC_TRUE;
    }
    if (!any) continue;
    PetscCall(PetscArraycpy(nodes, &space->group_nodes[group->node_offset], n - 2));
    nodes[n - 2] = body->node;
    nodes[n - 1] = body->node + 1;
    MpmPatternAddNodes(pattern, space, n, nodes, element);
  }
  PetscCall(PetscFree2(element, nodes));
  PetscCall(OwnTangent(contacts, sum, u, pattern));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the converged step ---- */

/* The bodies' increments become their places. */
static PetscErrorCode Commit(void *ctx, const MpmSum *sum, const PetscReal u[], MpmParticles *particles)
{
  MpmContacts *contacts = (MpmContacts *)ctx;

  PetscFunctionBeginUser;
  (void)particles;
  for (PetscInt b = 0; b < contacts->boundary_count; b++) {
    MpmRigidBody     *body = &contacts->bodies[b];
    MpmRigidIncrement q;

    if (!body->freedom) continue;
    MpmRigidIncrementAt(body, sum->block, u, &q);
    MpmRigidMove(&q, body->placement);
    for (PetscInt k = 0; k < 6; k++) body->placement->last[k] = 0.;
    for (PetscInt n = 0; n < 2; n++)
      for (PetscInt a = 0; a < Components(body, n); a++)
        body->placement->last[3 * n + a] = u[(body->node + n) * sum->block + a];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscInt MpmRigidReport(const MpmContacts *contacts, PetscInt b, PetscReal values[])
{
  const MpmBoundary *boundary = &contacts->boundaries[b];
  PetscInt           count    = 0;
  PetscReal          reference[MPM_MAX_DIM];

  if (!boundary->freedom) return 0;
  const MpmPlacement *placement = contacts->bodies[b].placement;
  const PetscReal    *turn      = placement->turn;
  const PetscReal     sine      = hypot(hypot(turn[1], turn[2]), turn[3]);
  const PetscReal     angle     = 2. * atan2(sine, turn[0]) * 180. / PETSC_PI;

  MpmBoundaryReference(boundary, &contacts->after[b], reference);
  for (PetscInt a = 0; a < boundary->dim; a++) values[count++] = reference[a] + placement->shift[a];
  for (PetscInt a = boundary->dim == 2 ? 2 : 0; a < 3; a++)
    values[count++] = sine > 0. ? angle * turn[1 + a] / sine : 0.;
  return count;
}

PetscErrorCode MpmRigidImbalance(const MpmContacts *contacts, const MpmSpace *space, PetscInt block,
                                 const PetscScalar residual[], MPI_Comm comm, PetscReal *imbalance)
{
  PetscFunctionBeginUser;
  *imbalance = 0.;
  if (!contacts->bodies) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt b = 0; b < contacts->boundary_count && Owns(space); b++) {
    const MpmRigidBody *body = &contacts->bodies[b];
    PetscReal           load = 0., rest = 0.;

    if (!body->freedom) continue;
    for (PetscInt a = 0; a < body->dim; a++) load = PetscMax(load, PetscAbsReal(body->load[a]));
    for (PetscInt a = 0; a < 3; a++) load = PetscMax(load, PetscAbsReal(body->moment[a]) / body->freedom->size);
    for (PetscInt k = 0; k < 2 * block; k++) rest = PetscMax(rest, PetscAbsScalar(residual[body->node * block + k]));
    if (load > 0.) *imbalance = PetscMax(*imbalance, rest / load);
  }
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, imbalance, 1, MPIU_REAL, MPIU_MAX, comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

const MpmTerm MpmTermRigidBodies = {.name     = "rigid bodies",
                                    .boxes    = Boxes,
                                    .link     = Link,
                                    .residual = Residual,
                                    .tangent  = Tangent,
                                    .apply    = Apply,
                                    .diagonal = Diagonal,
                                    .commit   = Commit};

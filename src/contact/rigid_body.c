/*
  Rigid bodies with unknown position, loaded by forces: boundaries with unknowns of their own, solved for with the
  grid's.

  A free body appends two extra nodes to the step's space: its translation, and its rotation times its size, so that all
  unknowns are lengths and all residuals forces. The action of its contacts on nodes and body, with derivatives, is in
  rigid_motion.c, that of a patch in rigid_patch.c; here it is summed. Its equations are the balance of the contact
  forces and its loads. Components without any resistance (the rotation of a smooth disc) have no stiffness: the matrix,
  not the residual, has LIFT times that of a node on the bodies' diagonal, which keeps them where they are.
*/
#include "geometry/geometry.h"
#include "point/material.h"
#include "space/space.h"
#include "space/sum.h"
#include "assembly/sparsity.h"
#include "assembly/terms.h"
#include "contact/contact.h"
#include "contact/rigid_body.h"

#define LIFT 1e-6 /* of a node's stiffness */

/* ---- before the step ---- */

/* Two nodes a body. */
static PetscErrorCode Boxes(void *ctx, const MpmRules *rules, const MpmPoints *points, MpmSpace *space)
{
  MpmContacts *contacts = (MpmContacts *)ctx;

  PetscFunctionBeginUser;
  (void)rules;
  (void)points;
  for (PetscInt b = 0; b < contacts->facets.boundary_count; b++)
    if (contacts->facets.bodies[b].freedom)
      PetscCall(MpmSpaceAppendNodes(space, 2, contacts->facets.bodies[b].free, &contacts->facets.bodies[b].extra));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The body's equations meet those of the nodes that its contacts touch. */
static PetscErrorCode Link(void *ctx, MpmSpace *space)
{
  MpmContacts *contacts = (MpmContacts *)ctx;

  PetscFunctionBeginUser;
  for (PetscInt b = 0; b < contacts->facets.boundary_count; b++) {
    contacts->facets.bodies[b].node = space->extra.begin + contacts->facets.bodies[b].extra;
    if (contacts->facets.bodies[b].freedom) PetscCall(MpmSpaceLink(space, -1, contacts->facets.bodies[b].extra, 2));
  }
  for (PetscInt k = 0; k < contacts->patch_count; k++) {
    const MpmPatch     *patch = &contacts->patch[k];
    const MpmRigidBody *body  = MpmFacetsBody(&contacts->facets, patch->boundary);

    if (body) PetscCall(MpmSpaceLink(space, patch->box, body->extra, 2));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- sums ---- */

/* The unknowns' number of a body at its second node. */
static PetscInt Components(const MpmRigidBody *body, PetscInt node)
{
  return node ? MpmRotationCount(body->dim) : body->dim;
}

/* N/m: stiffness of a body's component without any other. */
static PetscReal Lift(const MpmContacts *contacts, const MpmSum *sum)
{
  PetscReal modulus = 0.;

  for (PetscInt m = 0; m < contacts->material_count; m++) modulus = PetscMax(modulus, sum->materials[m].moduli.penalty);
  return LIFT * modulus * PetscPowRealInt(contacts->facets.cell, sum->space->dim - 2);
}

/* True where this rank owns the bodies' nodes. */
static PetscBool Owns(const MpmSpace *space)
{
  return (PetscBool)(space->extra.begin < space->owned);
}

/* The patch at the local unknowns; PETSC_FALSE where it does nothing. */
static PetscBool PatchAt(const MpmContacts *contacts, const MpmPatch *patch, const MpmSum *sum, const PetscReal u[],
                         MpmRigidIncrement *q, MpmRigidWork *work)
{
  MpmRigidIncrementAt(&contacts->facets.bodies[patch->boundary], sum->block, u, q);
  for (PetscInt f = patch->begin; f < patch->end; f++)
    MpmPatchValue(contacts, sum, patch, f, u, work->u[f - patch->begin]);
  MpmRigidPatch(contacts, patch, q, work);
  return work->answer.any;
}

/* Initial values of Newton's method; `factor` times the last increment where a body has not settled anew. */
static void Guess(const void *ctx, const MpmSum *sum, PetscReal factor, PetscScalar x[])
{
  const MpmContacts *contacts = (const MpmContacts *)ctx;

  for (PetscInt b = 0; b < contacts->facets.boundary_count && Owns(sum->space); b++) {
    const MpmRigidBody *body    = &contacts->facets.bodies[b];
    PetscBool           settled = PETSC_FALSE;

    if (!body->freedom) continue;
    for (PetscInt k = 0; k < 6; k++) settled = (PetscBool)(settled || body->guess[k] != 0.);
    for (PetscInt n = 0; n < 2; n++)
      for (PetscInt a = 0; a < Components(body, n); a++)
        x[(body->node + n) * sum->block + a] =
          settled ? body->guess[3 * n + a] : factor * body->placement->last[3 * n + a];
  }
}

static void Mode(const void *ctx, const MpmSum *sum, const PetscReal origin[], const PetscReal along[3],
                 const PetscReal turn[3], PetscScalar x[])
{
  const MpmContacts *contacts = (const MpmContacts *)ctx;

  for (PetscInt b = 0; b < contacts->facets.boundary_count && Owns(sum->space); b++) {
    const MpmRigidBody *body = &contacts->facets.bodies[b];
    PetscReal           mode[2][3];

    if (!body->freedom) continue;
    MpmRigidMode(body, origin, along, turn, mode);
    for (PetscInt n = 0; n < 2; n++)
      for (PetscInt a = 0; a < sum->space->dim; a++) x[(body->node + n) * sum->block + a] = mode[n][a];
  }
}

static PetscErrorCode Residual(const void *ctx, const MpmSum *sum, const PetscReal u[], PetscReal residual[],
                               PetscInt *failed)
{
  const MpmContacts *contacts = (const MpmContacts *)ctx;
  const PetscInt     bs       = sum->block;
  MpmRigidIncrement  q;
  MpmRigidWork       work;

  PetscFunctionBeginUser;
  (void)failed;
  PetscCall(MpmRigidWorkCreate(contacts, sum, &work));
  for (PetscInt k = 0; k < contacts->patch_count; k++) {
    const MpmPatch     *patch = &contacts->patch[k];
    const MpmRigidBody *body  = MpmFacetsBody(&contacts->facets, patch->boundary);

    if (!body || !PatchAt(contacts, patch, sum, u, &q, &work)) continue;
    for (PetscInt f = patch->begin; f < patch->end; f++) {
      MpmRigidAnswer coupled;

      MpmRigidFacet(contacts, patch, f, &q, &work, PETSC_FALSE, &coupled);
      MpmFacetAddForce(sum, &sum->space->groups[patch->box], MpmFacetWeights(contacts, f), 1., coupled.residual[0],
                       residual);
      for (PetscInt n = 0; n < 2; n++)
        for (PetscInt a = 0; a < Components(body, n); a++)
          residual[(body->node + n) * bs + a] += coupled.residual[1 + n][a];
    }
  }
  PetscCall(MpmRigidWorkDestroy(&work));
  for (PetscInt b = 0; b < contacts->facets.boundary_count && Owns(sum->space); b++) {
    const MpmRigidBody *body = MpmFacetsBody(&contacts->facets, b);
    PetscReal           load[2][3], unused[3][3];

    if (!body) continue;
    MpmRigidIncrementAt(body, bs, u, &q);
    MpmRigidLoad(body, &q, load, unused);
    for (PetscInt n = 0; n < 2; n++)
      for (PetscInt a = 0; a < Components(body, n); a++) residual[(body->node + n) * bs + a] += load[n][a];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Work of the mean of the bodies' loads, on the rank that owns their nodes; the residual has their remainder after
   contact. */
static PetscErrorCode Work(const void *ctx, const MpmSum *sum, const PetscReal at[], const PetscReal u[],
                           MpmTermWork *account)
{
  const MpmContacts *contacts = (const MpmContacts *)ctx;
  PetscReal          work = 0., more = 0.;

  PetscFunctionBeginUser;
  (void)at;
  for (PetscInt b = 0; b < contacts->facets.boundary_count && Owns(sum->space); b++) {
    const MpmRigidBody *body = MpmFacetsBody(&contacts->facets, b);
    MpmRigidIncrement   q;
    MpmRigidBody        mean;
    PetscReal           load[2][3], unused[3][3];

    if (!body) continue;
    MpmRigidIncrementAt(body, sum->block, u, &q);
    MpmRigidLoad(body, &q, load, unused);
    for (PetscInt n = 0; n < 2; n++)
      for (PetscInt a = 0; a < Components(body, n); a++) work -= load[n][a] * u[(body->node + n) * sum->block + a];
    mean = *body;
    for (PetscInt a = 0; a < 3; a++) {
      mean.load[a]   = body->more * body->freedom->load[a];
      mean.moment[a] = body->more * body->freedom->moment[a];
    }
    MpmRigidLoad(&mean, &q, load, unused);
    for (PetscInt n = 0; n < 2; n++)
      for (PetscInt a = 0; a < Components(body, n); a++) more -= load[n][a] * u[(body->node + n) * sum->block + a];
  }
  account->external += work + more;
  account->dissipated += work;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The matrix of a body's own: its load, and the lift. */
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

/* Tangent of a patch's own nodes and its body's, element[i][a][c][j] of 3 components each; the body's come last. */
static void Element(const MpmContacts *contacts, const MpmPatch *patch, const MpmRigidIncrement *q, PetscInt n,
                    MpmRigidWork *work, PetscReal element[])
{
  const PetscInt N = n + 2, size = 3 * N, means = contacts->facets.boundaries[patch->boundary].tangential ? 4 : 1;

  MpmRigidMean(contacts, patch, q, n, work);
  for (PetscInt k = 0; k < size * size; k++) element[k] = 0.;
  for (PetscInt m = 0; m < means; m++)
    for (PetscInt i = 0; i < size; i++)
      for (PetscInt j = 0; work->left[m * size + i] != 0. && j < size; j++)
        element[(i * 3 + j % 3) * N + j / 3] += work->left[m * size + i] * work->right[m * size + j];
  for (PetscInt f = patch->begin; f < patch->end; f++) {
    const PetscReal *weight = MpmFacetWeights(contacts, f);
    MpmRigidAnswer   coupled;

    memset(&coupled, 0, sizeof(coupled));
    MpmRigidFacet(contacts, patch, f, q, work, PETSC_TRUE, &coupled);
    for (PetscInt i = 0; i < N; i++) {
      const PetscInt  g    = i < n ? 0 : i - n + 1;
      const PetscReal left = g ? 1. : weight[i];

      for (PetscInt j = 0; left != 0. && j < N; j++) {
        const PetscInt  h    = j < n ? 0 : j - n + 1;
        const PetscReal both = left * (h ? 1. : weight[j]);

        for (PetscInt ac = 0; both != 0. && ac < 9; ac++)
          element[((i * 3 + ac / 3) * 3 + ac % 3) * N + j] += both * coupled.derivative[g][ac / 3][h][ac % 3];
      }
    }
  }
}

/* The tangents of patches, one after the other, with the nodes that they are of. */
typedef struct {
  MpmRigidWork work;
  PetscReal   *element, *block; /* with the components of the nodes' blocks */
  PetscInt    *nodes, count;
} Elements;

static PetscErrorCode ElementsCreate(const MpmContacts *contacts, const MpmSum *sum, Elements *elements)
{
  const PetscInt bs   = sum->block;
  PetscInt       most = 0;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < contacts->patch_count; k++)
    most = PetscMax(most, sum->space->groups[contacts->patch[k].box].node_count + 2);
  PetscCall(MpmRigidWorkCreate(contacts, sum, &elements->work));
  PetscCall(PetscMalloc3((most * most * 9), &elements->element, (most * most * bs * bs), &elements->block, most,
                         &elements->nodes));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ElementsDestroy(Elements *elements)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree3(elements->element, elements->block, elements->nodes));
  PetscCall(MpmRigidWorkDestroy(&elements->work));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes that of a patch at the local unknowns u; its count is 0 where it does nothing. */
static PetscErrorCode PatchElement(const MpmContacts *contacts, const MpmPatch *patch, const MpmSum *sum,
                                   const PetscReal u[], Elements *of)
{
  const MpmRigidBody *body = MpmFacetsBody(&contacts->facets, patch->boundary);
  const MpmGroup     *box  = &sum->space->groups[patch->box];
  MpmRigidIncrement   q;

  PetscFunctionBeginUser;
  of->count = 0;
  if (!body || !PatchAt(contacts, patch, sum, u, &q, &of->work)) PetscFunctionReturn(PETSC_SUCCESS);
  of->count = box->node_count + 2;
  Element(contacts, patch, &q, box->node_count, &of->work, of->element);
  PetscCall(PetscArraycpy(of->nodes, &sum->space->group_nodes[box->node_offset], box->node_count));
  of->nodes[of->count - 2] = body->node;
  of->nodes[of->count - 1] = body->node + 1;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The value of (i, a) by (j, c) */
static PetscReal ElementAt(const Elements *of, PetscInt i, PetscInt a, PetscInt c, PetscInt j)
{
  return of->element[((i * 3 + a) * 3 + c) * of->count + j];
}

/* Tangent of the bodies without contacts. */
static PetscErrorCode OwnTangent(const MpmContacts *contacts, const MpmSum *sum, const PetscReal u[],
                                 MpmPattern *pattern)
{
  const PetscInt bs = sum->block;

  PetscFunctionBeginUser;
  for (PetscInt b = 0; b < contacts->facets.boundary_count && Owns(sum->space); b++) {
    const MpmRigidBody *body = &contacts->facets.bodies[b];
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
  const PetscInt     bs = sum->block, dim = sum->space->dim;
  Elements           of;

  PetscFunctionBeginUser;
  if (residual) PetscCall(Residual(ctx, sum, u, residual, failed));
  PetscCall(ElementsCreate(contacts, sum, &of));
  for (PetscInt k = 0; k < contacts->patch_count; k++) {
    PetscCall(PatchElement(contacts, &contacts->patch[k], sum, u, &of));
    const PetscInt n = of.count;

    for (PetscInt i = 0; i < n * n * bs * bs; i++) of.block[i] = 0.;
    for (PetscInt i = 0; i < n; i++)
      for (PetscInt ac = 0; ac < dim * dim; ac++)
        for (PetscInt j = 0; j < n; j++)
          of.block[((i * bs + ac / dim) * bs + ac % dim) * n + j] = ElementAt(&of, i, ac / dim, ac % dim, j);
    if (n) MpmPatternAddNodes(pattern, sum->space, n, of.nodes, of.block);
  }
  PetscCall(ElementsDestroy(&of));
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
  for (PetscInt b = 0; b < contacts->facets.boundary_count; b++) {
    MpmRigidBody     *body = &contacts->facets.bodies[b];
    MpmRigidIncrement q;

    if (!body->freedom) continue;
    MpmRigidIncrementAt(body, sum->block, u, &q);
    MpmRigidMove(&q, body->placement);
    for (PetscInt k = 0; k < 6; k++) body->placement->last[k] = 0.;
    for (PetscInt n = 0; n < 2; n++)
      for (PetscInt a = 0; a < Components(body, n); a++)
        body->placement->last[3 * n + a] = u[(body->node + n) * sum->block + a] - body->guess[3 * n + a];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The largest residual of a body over its forces. */
static PetscReal Imbalance(const void *ctx, const MpmSum *sum, const PetscScalar residual[])
{
  const MpmContacts *contacts  = (const MpmContacts *)ctx;
  const PetscInt     block     = sum->block;
  PetscReal          imbalance = 0.;

  for (PetscInt b = 0; b < contacts->facets.boundary_count && Owns(sum->space); b++) {
    const MpmRigidBody *body = &contacts->facets.bodies[b];
    PetscReal           load = 0., rest = 0.;

    if (!body->freedom) continue;
    for (PetscInt a = 0; a < body->dim; a++) load = PetscMax(load, PetscAbsReal(body->load[a]));
    for (PetscInt a = 0; a < 3; a++) load = PetscMax(load, PetscAbsReal(body->moment[a]) / body->freedom->size);
    for (PetscInt k = 0; k < 2 * block; k++) rest = PetscMax(rest, PetscAbsScalar(residual[body->node * block + k]));
    if (load > 0.) imbalance = PetscMax(imbalance, rest / load);
  }
  return imbalance;
}

/* ---- the term ---- */

static PetscBool Idle(const void *ctx)
{
  return (PetscBool) !((const MpmContacts *)ctx)->facets.bodies;
}

static unsigned Traits(const void *ctx)
{
  return ((const MpmContacts *)ctx)->facets.bodies ? MPM_TERM_UNKNOWNS : 0;
}

const MpmTerm MpmTermRigidBodies = {
  .name           = "rigid bodies",
  .energy.account = MPM_ACCOUNT_DISSIPATED,
  .idle           = Idle,
  .boxes          = Boxes,
  .link           = Link,
  .residual       = Residual,
  .tangent        = Tangent,
  .step.commit    = Commit,
  .traits         = Traits,
  .energy.work    = Work,
  .newton         = {.imbalance = Imbalance, .relax = MpmRigidRelax, .guess = Guess, .mode = Mode},
  .motion         = {.rest = MpmRigidRest, .lend = MpmRigidLend, .take = MpmRigidTake, .kinetic = MpmRigidKinetic},
  .failure        = {.refuses = MpmRigidRefuses, .stray = MpmRigidStray, .unheld = MpmRigidUnheld}};

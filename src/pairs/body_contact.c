/*
  Contact of bodies with one another, which have nodes of their own.

  The facets of the first body in one cell and those of the second across from them (body_patches.c) form a patch with
  one mean gap g, one mean slip s and one traction, as in a mortar method with one multiplier a cell. With w the mean
  displacement of the first body's facets less that of the second's, n the outward normal of the first body, A the area,

    g = g_n - n . w ,   s = s_n + (I - n n^T) w ,   pressure p = -k g where g <= 0 ,   traction t = k' s ,
    k = penalty E/h

  and the law of contact_law.c: |t| <= mu p + adhesion. The first body gets the force -A (p n + t), spread over its
  facets by area, the second the opposite over its own: forces balance to rounding, whatever the two lattices of points.
  n and A are those of the step's start, so the force depends on w alone, and with B = dw/du the tangent is

    B^T A (k n n^T + dt/dw) B .

  With `method: augmented` the pressure is -k (g - shift), and between Newton's solutions the shift becomes that which
  carries the pressure at no depth. With `method: barrier` a barrier of reach d0, a tenth of a cell, replaces the
  penalty: the bodies never meet, for where g <= 0 there is no answer and Newton's step is halved.

  Where bodies touch as the step starts, and the contact is open to water, water passes from the first to the second: dt
  A c (p_1 - p_2), with p the mean pressures of both sides and c a hundred times the conductance of a cell of the less
  permeable one. The pressures then agree but for a hundredth of their fall over a cell.
*/
#include "particles/particles.h"
#include "space/space.h"
#include "space/sum.h"
#include "assembly/sparsity.h"
#include "assembly/terms.h"
#include "pairs/body_contact.h"
#include "pairs/body_patch.h"
#include "facets/contact_law.h"

/* Water that passes by the difference of pressures. */
static PetscReal Conductance(const MpmPairPatch *patch, const MpmSum *sum)
{
  return sum->step.dt * patch->side[0].area * patch->through;
}

/* Adds a patch's force in explicit steps, with the contribution of turning. */
static void AddDirectForce(const MpmPairContacts *contacts, const MpmPairPatch *patch, const MpmSum *sum,
                           const PetscReal force[], PetscReal y[])
{
  for (PetscInt s = 0; s < 2; s++) {
    const MpmGroup  *box    = &sum->space->groups[patch->side[s].box];
    const PetscInt  *nodes  = &sum->space->group_nodes[box->node_offset];
    const PetscReal *weight = &contacts->weights.at[patch->side[s].weight], sign = s ? -1. : 1.;

    for (PetscInt i = 0; i < box->node_count; i++) {
      PetscReal arm[3], at_node[3];

      if (weight[i] == 0.) continue;
      MpmPairArm(patch, s, sum, i, arm);
      MpmPairNodeForce(&patch->side[s].lever, force, arm, at_node);
      for (PetscInt a = 0; a < sum->space->dim; a++) y[nodes[i] * sum->block + a] += sign * weight[i] * at_node[a];
    }
  }
}

/* y_i += w_i force on the first side's nodes, the opposite on the second's, without contribution of turning */
static void AddPlainForce(const MpmPairContacts *contacts, const MpmPairPatch *patch, const MpmSum *sum,
                          const PetscReal force[], PetscReal y[])
{
  for (PetscInt s = 0; s < 2; s++) {
    const MpmGroup  *box    = &sum->space->groups[patch->side[s].box];
    const PetscInt  *nodes  = &sum->space->group_nodes[box->node_offset];
    const PetscReal *weight = &contacts->weights.at[patch->side[s].weight], sign = s ? -1. : 1.;

    for (PetscInt i = 0; i < box->node_count; i++)
      for (PetscInt a = 0; weight[i] != 0. && a < MPM_PAIR_ROWS; a++)
        if (MpmPairActs(patch, sum->space->dim, a))
          y[nodes[i] * sum->block + MpmPairComponent(contacts, a)] += sign * weight[i] * force[a];
  }
}

/* The share of a force that is one of a geostatic state acts as it does in implicit steps. */
static void AddForce(const MpmPairContacts *contacts, const MpmPairPatch *patch, const MpmSum *sum,
                     const PetscReal force[], PetscReal y[])
{
  PetscReal rest[MPM_PAIR_ROWS] = {0.}, other[MPM_PAIR_ROWS], size = 0., square = 0.;

  if (!patch->direct) {
    AddPlainForce(contacts, patch, sum, force, y);
    return;
  }
  MpmPairRestForce(contacts, patch, sum->space->dim, rest);
  for (PetscInt a = 0; a < sum->space->dim; a++) {
    size += PetscSqr(rest[a]);
    square += PetscSqr(force[a]);
  }
  for (PetscInt a = 0; a < MPM_PAIR_ROWS; a++) {
    rest[a]  = square > size ? PetscSqrtReal(size / square) * force[a] : force[a];
    other[a] = force[a] - rest[a];
  }
  if (size > 0.) AddPlainForce(contacts, patch, sum, rest, y);
  AddDirectForce(contacts, patch, sum, other, y);
}

/* The residual of a patch at w, as forces on the first side; the water's equation is that of the mass times -1. */
static PetscBool PatchResidual(const MpmPairPatch *patch, const MpmSum *sum, const PetscReal w[],
                               const MpmPairAnswer *answer, PetscReal force[])
{
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) force[a] = answer->active ? -answer->force[a] : 0.;
  force[MPM_PAIR_WATER] = -Conductance(patch, sum) * w[MPM_PAIR_WATER];
  return (PetscBool)(answer->active || patch->through > 0.);
}

/* Its derivative by rows c and d of w. */
static PetscReal PatchTangent(const MpmPairPatch *patch, const MpmSum *sum, const MpmPairAnswer *answer, PetscInt c,
                              PetscInt d)
{
  if (c == MPM_PAIR_WATER || d == MPM_PAIR_WATER) return c == d ? -Conductance(patch, sum) : 0.;
  return answer->active ? answer->stiffness[c][d] : 0.;
}

static PetscErrorCode Residual(const void *ctx, const MpmSum *sum, const PetscReal u[], PetscReal residual[],
                               PetscInt *failed)
{
  const MpmPairContacts *contacts = (const MpmPairContacts *)ctx;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < contacts->patch_count; k++) {
    const MpmPairPatch *patch = &contacts->patch[k];
    PetscReal           w[MPM_PAIR_ROWS], force[MPM_PAIR_ROWS];
    MpmPairAnswer       answer;

    MpmPairRelative(contacts, patch, sum, u, w);
    MpmPairEvaluate(contacts, patch, sum->space->dim, w, &answer);
    if (answer.refused) (*failed)++;
    if (PatchResidual(patch, sum, w, &answer, force)) AddForce(contacts, patch, sum, force, residual);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Apply(const void *ctx, const MpmSum *sum, const PetscReal u[], const PetscReal du[],
                            PetscReal y[])
{
  const MpmPairContacts *contacts = (const MpmPairContacts *)ctx;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < contacts->patch_count; k++) {
    const MpmPairPatch *patch = &contacts->patch[k];
    PetscReal           w[MPM_PAIR_ROWS], force[MPM_PAIR_ROWS];
    MpmPairAnswer       answer;

    MpmPairRelative(contacts, patch, sum, u, w);
    MpmPairEvaluate(contacts, patch, sum->space->dim, w, &answer);
    if (!answer.active && !(patch->through > 0.)) continue;
    MpmPairRelative(contacts, patch, sum, du, w);
    for (PetscInt a = 0; a < MPM_PAIR_ROWS; a++) {
      force[a] = 0.;
      for (PetscInt c = 0; c < MPM_PAIR_ROWS; c++) force[a] += PatchTangent(patch, sum, &answer, a, c) * w[c];
    }
    AddForce(contacts, patch, sum, force, y);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The nodes of both sides, and B: signed weights; returns how many. */
static PetscInt NodesOf(const MpmPairContacts *contacts, const MpmPairPatch *patch, const MpmSum *sum, PetscInt nodes[],
                        PetscReal weight[])
{
  PetscInt n = 0;

  for (PetscInt s = 0; s < 2; s++) {
    const MpmGroup *box = &sum->space->groups[patch->side[s].box];

    for (PetscInt i = 0; i < box->node_count; i++) {
      const PetscReal w = contacts->weights.at[patch->side[s].weight + i];

      if (w == 0.) continue;
      nodes[n]    = sum->space->group_nodes[box->node_offset + i];
      weight[n++] = s ? -w : w;
    }
  }
  return n;
}

/* The patch's block of the tangent, [i][c][c'][j]. */
static void Element(const MpmPairContacts *contacts, const MpmPairPatch *patch, const MpmSum *sum,
                    const MpmPairAnswer *answer, PetscInt n, const PetscReal weight[], PetscReal element[])
{
  const PetscInt bs = sum->block;

  for (PetscInt k = 0; k < n * n * bs * bs; k++) element[k] = 0.;
  for (PetscInt cd = 0; cd < MPM_PAIR_ROWS * MPM_PAIR_ROWS; cd++) {
    const PetscInt c = cd / MPM_PAIR_ROWS, d = cd % MPM_PAIR_ROWS;

    if (!MpmPairActs(patch, sum->space->dim, c) || !MpmPairActs(patch, sum->space->dim, d)) continue;
    const PetscReal value = PatchTangent(patch, sum, answer, c, d);

    for (PetscInt i = 0; i < n; i++)
      for (PetscInt j = 0; j < n; j++)
        element[((i * bs + MpmPairComponent(contacts, c)) * bs + MpmPairComponent(contacts, d)) * n + j] =
          weight[i] * value * weight[j];
  }
}

static PetscErrorCode Tangent(const void *ctx, const MpmSum *sum, const PetscReal u[], MpmPattern *pattern,
                              PetscReal residual[], PetscInt *failed)
{
  const MpmPairContacts *contacts = (const MpmPairContacts *)ctx;
  const PetscInt         bs = sum->block, most = contacts->most;
  PetscReal             *element, *weight;
  PetscInt              *nodes;

  PetscFunctionBeginUser;
  if (!contacts->patch_count) PetscFunctionReturn(PETSC_SUCCESS);
  if (residual) PetscCall(Residual(ctx, sum, u, residual, failed));
  PetscCall(PetscMalloc3((most * most * bs * bs), &element, most, &weight, most, &nodes));
  for (PetscInt k = 0; k < contacts->patch_count; k++) {
    const MpmPairPatch *patch = &contacts->patch[k];
    PetscReal           w[MPM_PAIR_ROWS];
    MpmPairAnswer       answer;

    MpmPairRelative(contacts, patch, sum, u, w);
    MpmPairEvaluate(contacts, patch, sum->space->dim, w, &answer);
    if (!answer.active && !(patch->through > 0.)) continue;
    const PetscInt n = NodesOf(contacts, patch, sum, nodes, weight);

    Element(contacts, patch, sum, &answer, n, weight, element);
    MpmPatternAddNodes(pattern, sum->space, n, nodes, element);
  }
  PetscCall(PetscFree3(element, weight, nodes));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the step is over ---- */

/*
  Keeps the slip of an explicit step, in which contact acts where the nodes would come without it: that of the places
  they reach; when sliding, at most the elastic slip of the traction.
*/
static void KeepSlip(const MpmPairContacts *contacts, const MpmPairPatch *patch, const MpmSum *sum, PetscReal slip[])
{
  const PetscInt dim = sum->space->dim;
  PetscReal      w[MPM_PAIR_ROWS], square = 0., most = 0., came[MPM_MAX_DIM];

  MpmPairRelative(contacts, patch, sum, contacts->moved, w);
  MpmContactAcross(dim, patch->normal, w);
  for (PetscInt a = 0; a < dim; a++) {
    came[a] = patch->slip[a] + w[a];
    square += PetscSqr(came[a]);
    most += PetscSqr(slip[a]);
  }
  for (PetscInt a = 0; a < dim; a++) slip[a] = came[a] * (square > most ? PetscSqrtReal(most / square) : 1.);
}

/* Forces of the converged step; the points keep the slips. */
static PetscErrorCode Commit(void *ctx, const MpmSum *sum, const PetscReal u[], MpmParticles *particles)
{
  MpmPairContacts *contacts = (MpmPairContacts *)ctx;
  PetscReal       *pressure, (*slip)[MPM_MAX_DIM];

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc2(contacts->patch_count, &slip, contacts->patch_count, &pressure));
  PetscCall(PetscArrayzero(contacts->force, contacts->pairs->count));
  for (PetscInt k = 0; k < contacts->patch_count; k++) {
    PetscReal     w[MPM_PAIR_ROWS];
    MpmPairAnswer answer;

    MpmPairRelative(contacts, &contacts->patch[k], sum, u, w);
    MpmPairEvaluate(contacts, &contacts->patch[k], sum->space->dim, w, &answer);
    if (contacts->moved && answer.active) KeepSlip(contacts, &contacts->patch[k], sum, answer.slip);
    for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
      slip[k][a] = answer.slip[a];
      if (contacts->patch[k].slips > 0.) slip[k][a] /= contacts->patch[k].slips;
      contacts->force[contacts->patch[k].pair][a] += answer.force[a];
    }
    contacts->patch[k].closed = 0.;
    pressure[k]               = answer.active ? answer.pressure : 0.;
    for (PetscInt a = 0; answer.active && a < sum->space->dim; a++)
      contacts->patch[k].closed += contacts->patch[k].normal[a] * w[a];
    if (contacts->pairs->at[contacts->patch[k].pair].augmented)
      contacts->patch[k].shift = answer.pressure / contacts->patch[k].stiffness;
  }
  if (contacts->newton.near || !contacts->newton.bare) PetscCall(MpmPairPatchesKeep(contacts, slip, particles));
  for (PetscInt k = 0; k < contacts->patch_count; k++) contacts->patch[k].rest = pressure[k];
  contacts->newton.bare = (PetscBool)!contacts->newton.near;
  PetscCall(PetscFree2(slip, pressure));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, contacts->force, (PetscMPIInt)(contacts->pairs->count * MPM_MAX_DIM),
                           MPIU_REAL, MPIU_SUM, contacts->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPairsBear(const void *ctx, const MpmSum *sum, PetscReal residual[])
{
  const MpmPairContacts *contacts = (const MpmPairContacts *)ctx;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < contacts->patch_count; k++) {
    PetscReal force[MPM_PAIR_ROWS] = {0.};

    if (contacts->patch[k].rest == 0.) continue;
    MpmPairRestForce(contacts, &contacts->patch[k], sum->space->dim, force);
    for (PetscInt a = 0; a < sum->space->dim; a++) force[a] = -force[a];
    AddPlainForce(contacts, &contacts->patch[k], sum, force, residual);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the term ---- */

static PetscBool Idle(const void *ctx)
{
  return (PetscBool) !((const MpmPairContacts *)ctx)->patch_count;
}

static unsigned Traits(const void *ctx)
{
  const MpmPairs *pairs  = ((const MpmPairContacts *)ctx)->pairs;
  unsigned        traits = 0;

  if (pairs->count) traits = MPM_TERM_CONTACT | MPM_TERM_BETWEEN | MPM_TERM_RELEASES;
  for (PetscInt k = 0; k < pairs->count; k++) {
    if (pairs->at[k].tangential) traits |= MPM_TERM_RUBS;
    if (pairs->at[k].tangential && !pairs->at[k].stick) traits |= MPM_TERM_SLIDES;
    if (pairs->at[k].augmented) traits |= MPM_TERM_AUGMENTED;
  }
  return traits;
}

static PetscBool *Near(void *ctx)
{
  return &((MpmPairContacts *)ctx)->newton.near;
}

static PetscBool Holds(const void *ctx)
{
  return ((const MpmPairContacts *)ctx)->newton.holds;
}

static void Arrive(void *ctx, const PetscReal u[])
{
  ((MpmPairContacts *)ctx)->moved = u;
}

const MpmTerm MpmTermBodyContact = {.name           = "body contact",
                                    .energy.account = MPM_ACCOUNT_DISSIPATED,
                                    .idle           = Idle,
                                    .boxes          = MpmPairPatchesFind,
                                    .prepare        = MpmPairPatchesPrepare,
                                    .link           = MpmPairPatchesLink,
                                    .residual       = Residual,
                                    .tangent        = Tangent,
                                    .apply          = Apply,
                                    .step.commit    = Commit,
                                    .step.put_back  = MpmPairsPutBack,
                                    .traits         = Traits,
                                    .near           = Near,
                                    .newton         = {.begin    = MpmPairsBegin,
                                                       .accepted = MpmPairsRelease,
                                                       .end      = MpmPairsEnd,
                                                       .holds    = Holds,
                                                       .soften   = MpmPairsGive,
                                                       .squares  = MpmPairsAddSquares,
                                                       .augment  = MpmPairsAugment},
                                    .motion         = {.bear = MpmPairsBear, .limit = MpmPairsLimit, .arrive = Arrive}};

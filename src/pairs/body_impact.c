/*
  Contact of bodies in explicit steps.

  Forces act at the displacement that the nodes would have without them. With w = B u the mean relative displacement of
  a patch and M the masses of the nodes, forces k A g of all patches change the gaps by dt^2 B M^-1 B^T k A g.
  Approaching bodies are stopped without being thrown back where no row of that exceeds 1:

    k A <= 1/(dt^2 sum_j |B_k M^-1 B_j^T|) .

  A uniform pressure then stops them in one step, without depth, and the step is as long as the waves allow.

  The means of both sides belong to places x_1 and x_2 of their facets, a fraction of a cell apart: equal and opposite
  forces there have a moment. The means are those at the place between, x = (x_1 + x_2)/2, with the mean
  rotation of each side,

    u(x) = sum_i w_i u_i + omega x (x - x_s) ,   omega = J^-1 sum_i w_i r_i x u_i ,
    r_i = x_i - x_s ,   J = sum_i w_i (r_i.r_i I - r_i r_i^T) ,

  and the conjugate forces have neither resultant nor moment. One node alone does not turn: then x is its side's place.
*/
#include "grid/grid.h"
#include "space/space.h"
#include "space/sum.h"
#include "geometry/rotations.h"
#include "pairs/body_contact.h"
#include "pairs/body_patch.h"

#define TURNS 0.01 /* of a cell squared: a smaller J says nothing of a turn */

static void Cross(const PetscReal a[], const PetscReal b[], PetscReal c[])
{
  for (PetscInt k = 0; k < 3; k++) c[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}

void MpmPairArm(const MpmPairPatch *patch, PetscInt s, const MpmSum *sum, PetscInt i, PetscReal arm[])
{
  const MpmGroup *box             = &sum->space->groups[patch->side[s].box];
  const PetscInt  row             = i / box->count[0];
  const PetscInt  at[MPM_MAX_DIM] = {i % box->count[0], row % box->count[1], row / box->count[1]};
  PetscInt        node[MPM_MAX_DIM], place[MPM_MAX_DIM];

  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) node[a] = box->first[a] + at[a];
  MpmSpaceAt(sum->space, node, place);
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++)
    arm[a] = a < sum->space->dim ? MpmGridNodeAt(sum->grid, a, place[a]) - patch->side[s].lever.middle[a] : 0.;
}

void MpmPairTurn(const MpmPairLever *lever, const PetscReal moment[], PetscReal turn[])
{
  for (PetscInt a = 0; a < 3; a++) {
    turn[a] = 0.;
    for (PetscInt c = 0; c < 3; c++) turn[a] += lever->inverse[a][c] * moment[c];
  }
}

void MpmPairNodeForce(const MpmPairLever *lever, const PetscReal force[], const PetscReal arm[], PetscReal at_node[])
{
  PetscReal moment[3], turn[3], more[3];

  Cross(lever->offset, force, moment);
  MpmPairTurn(lever, moment, turn);
  Cross(turn, arm, more);
  for (PetscInt a = 0; a < 3; a++) at_node[a] = force[a] + more[a];
}

void MpmPairAddTurning(const MpmPairLever *lever, const PetscReal moment[], PetscReal sign, PetscReal w[])
{
  PetscReal turn[3], way[3];

  MpmPairTurn(lever, moment, turn);
  Cross(turn, lever->offset, way);
  for (PetscInt a = 0; a < 3; a++) w[a] += sign * way[a];
}

/* The inverse of a symmetric J, of which a plane has zz alone; PETSC_FALSE where it is not well above 0. */
static PetscBool Invert(PetscInt dim, PetscReal J[3][3], PetscReal least, PetscReal inverse[3][3])
{
  PetscReal largest = 0., det = 0.;

  for (PetscInt a = 0; a < 3; a++)
    for (PetscInt c = 0; c < 3; c++) inverse[a][c] = 0.;
  if (MpmRotationCount(dim) == 1) {
    if (J[2][2] < least) return PETSC_FALSE;
    inverse[2][2] = 1. / J[2][2];
    return PETSC_TRUE;
  }
  for (PetscInt a = 0; a < 3; a++) {
    const PetscInt p = (a + 1) % 3, q = (a + 2) % 3;

    largest = PetscMax(largest, J[a][a]);
    for (PetscInt c = 0; c < 3; c++) {
      const PetscInt r = (c + 1) % 3, t = (c + 2) % 3;

      inverse[c][a] = J[p][r] * J[q][t] - J[p][t] * J[q][r];
    }
    if (J[a][a] < least || inverse[a][a] < least * J[a][a]) return PETSC_FALSE;
  }
  for (PetscInt a = 0; a < 3; a++) det += J[0][a] * inverse[a][0];
  if (det < least * largest * largest) return PETSC_FALSE;
  for (PetscInt a = 0; a < 3; a++)
    for (PetscInt c = 0; c < 3; c++) inverse[a][c] /= det;
  return PETSC_TRUE;
}

/* Where a side's mean stands, and how it turns. */
static void FindLever(const MpmPairContacts *contacts, const MpmSum *sum, MpmPairPatch *patch, PetscInt s)
{
  MpmPairLever    *lever  = &patch->side[s].lever;
  const MpmGroup  *box    = &sum->space->groups[patch->side[s].box];
  const PetscReal *weight = &contacts->weights.at[patch->side[s].weight];
  PetscReal        arm[3], middle[3] = {0., 0., 0.}, J[3][3] = {{0.}};

  *lever = (MpmPairLever){.turns = PETSC_FALSE};
  for (PetscInt i = 0; i < box->node_count; i++) {
    MpmPairArm(patch, s, sum, i, arm);
    for (PetscInt a = 0; a < 3; a++) middle[a] += weight[i] * arm[a];
  }
  for (PetscInt a = 0; a < 3; a++) lever->middle[a] = middle[a];
  for (PetscInt i = 0; i < box->node_count; i++) {
    PetscReal square = 0.;

    MpmPairArm(patch, s, sum, i, arm);
    for (PetscInt a = 0; a < 3; a++) square += arm[a] * arm[a];
    for (PetscInt a = 0; a < 3; a++)
      for (PetscInt c = 0; c < 3; c++) J[a][c] += weight[i] * ((a == c ? square : 0.) - arm[a] * arm[c]);
  }
  lever->turns = Invert(sum->space->dim, J, TURNS * contacts->cell * contacts->cell, lever->inverse);
}

static void SetLevers(const MpmPairContacts *contacts, const MpmSum *sum, MpmPairPatch *patch)
{
  MpmPairLever *one = &patch->side[0].lever, *other = &patch->side[1].lever;

  for (PetscInt s = 0; s < 2; s++) FindLever(contacts, sum, patch, s);
  for (PetscInt a = 0; a < 3; a++) {
    const PetscReal apart = other->middle[a] - one->middle[a];

    if (one->turns && other->turns) {
      one->offset[a]   = 0.5 * apart;
      other->offset[a] = -0.5 * apart;
    } else {
      one->offset[a]   = one->turns ? apart : 0.;
      other->offset[a] = other->turns ? -apart : 0.;
    }
  }
}

/* The size of a node's part in a mean displacement, in any direction. */
static PetscReal Part(const MpmPairContacts *contacts, const MpmPairPatch *patch, PetscInt s, const MpmSum *sum,
                      PetscInt i)
{
  PetscReal arm[3], most = 0.;

  MpmPairArm(patch, s, sum, i, arm);
  for (PetscInt a = 0; a < sum->space->dim; a++) {
    PetscReal unit[3] = {0., 0., 0.}, at_node[3], square = 0.;

    unit[a] = 1.;
    MpmPairNodeForce(&patch->side[s].lever, unit, arm, at_node);
    for (PetscInt c = 0; c < 3; c++) square += at_node[c] * at_node[c];
    most = PetscMax(most, square);
  }
  return PetscAbsReal(contacts->weights.at[patch->side[s].weight + i]) * PetscSqrtReal(most);
}

/* Each node of the patches with its part: */
#define FOR_NODES(contacts, sum, k, s, i, node) \
  for (PetscInt k = 0; k < (contacts)->patch_count; k++) \
    for (PetscInt s = 0; s < 2; s++) \
      for (PetscInt i = 0, node = 0; i < (sum)->space->groups[(contacts)->patch[k].side[s].box].node_count && \
                                     (node = NodeOf(contacts, sum, k, s, i), PETSC_TRUE); \
           i++)

static PetscInt NodeOf(const MpmPairContacts *contacts, const MpmSum *sum, PetscInt k, PetscInt s, PetscInt i)
{
  return sum->space->group_nodes[sum->space->groups[contacts->patch[k].side[s].box].node_offset + i];
}

/*
  The patch takes its stiffness of explicit steps. The pressure of a geostatic state acts at the depth that it left, and
  the traction at its slip.
*/
static void LimitPatch(const MpmPairContacts *contacts, MpmPairPatch *patch, PetscReal most)
{
  const PetscReal depth = contacts->pairs->at[patch->pair].augmented ? 0. : patch->rest / patch->stiffness;
  const PetscReal along = MpmPairAlong(contacts, patch) * patch->stiffness;

  patch->direct    = PETSC_TRUE;
  patch->shift     = 0.;
  patch->stiffness = PetscMin(patch->stiffness, most);
  if (patch->rest == 0.) return;
  patch->shift = patch->rest / patch->stiffness - depth;
  patch->slips = along / (MpmPairAlong(contacts, patch) * patch->stiffness);
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) patch->slip[a] *= patch->slips;
}

PetscErrorCode MpmPairsLimit(void *ctx, const MpmSum *sum, const PetscReal mass[], PetscReal dt)
{
  MpmPairContacts *contacts = (MpmPairContacts *)ctx;
  PetscReal       *parts, *inverse;

  PetscFunctionBeginUser;
  if (!contacts->pairs->count) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscCalloc2(sum->space->local, &parts, contacts->patch_count, &inverse));
  for (PetscInt k = 0; k < contacts->patch_count; k++) SetLevers(contacts, sum, &contacts->patch[k]);
  FOR_NODES(contacts, sum, k, s, i, node)
  {
    if (contacts->weights.at[contacts->patch[k].side[s].weight + i] != 0.)
      parts[node] += Part(contacts, &contacts->patch[k], s, sum, i);
  }
  PetscCall(MpmSpaceAddToOwners(sum->space, 1, parts));
  PetscCall(MpmSpaceToGhosts(sum->space, 1, parts));
  FOR_NODES(contacts, sum, k, s, i, node)
  {
    if (contacts->weights.at[contacts->patch[k].side[s].weight + i] != 0. && mass[node] > 0.)
      inverse[k] += Part(contacts, &contacts->patch[k], s, sum, i) * parts[node] / mass[node];
  }
  for (PetscInt k = 0; k < contacts->patch_count; k++) {
    MpmPairPatch *patch = &contacts->patch[k];

    LimitPatch(contacts, patch, inverse[k] > 0. ? 1. / (inverse[k] * dt * dt * patch->side[0].area) : PETSC_INFINITY);
  }
  PetscCall(PetscFree2(parts, inverse));
  PetscFunctionReturn(PETSC_SUCCESS);
}

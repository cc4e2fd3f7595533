/*
  Contact of bodies with one another, which have nodes of their own.

  The facets of the first body in one cell and those of the second across from them (body_patches.c) form a patch with one
  mean gap g, one mean slip s and one traction, as a mortar method with one multiplier a cell has them. With w the mean
  displacement of the first body's facets less that of the second's, n the outward normal of the first body, A the area,

    g = g_n - n . w ,   s = s_n + (I - n n^T) w ,   pressure p = -k g where g <= 0 ,   traction t = k' s ,   k = penalty E/h

  and the law of contact_law.c: |t| <= mu p + adhesion. The first body gets the force -A (p n + t), spread
  over its facets by area, the second the opposite over its own: forces balance to rounding, whatever the two lattices of points.
  n and A are those of the step's start, so the force depends on w alone, and with B = dw/du the tangent is

    B^T A (k n n^T + dt/dw) B .

  With `method: augmented` the pressure is -k (g - shift), and between Newton's solutions the shift becomes what holds the pressure
  at no depth. With `method: barrier` a barrier of reach d0, a tenth of a cell, stands in place of the penalty: the bodies never
  meet, for where g <= 0 there is no answer and Newton's step is halved.

  Where bodies touch as the step starts, and the contact is open, water passes from the first to the second: dt A c (p_1 - p_2), p the
  mean pressures of both sides and c a hundred times what a cell of the less permeable one lets through, so that the pressures are the same but
  for a hundredth of their fall over a cell.
*/
#include "particles/particles.h"
#include "space/space.h"
#include "space/sum.h"
#include "assembly/sparsity.h"
#include "assembly/terms.h"
#include "contact/body_contact.h"
#include "contact/contact_law.h"

#define SLIDING \
  0.02 /* k'/k of what may slide: both sides give way, and many patches turn from sticking to sliding at once */

#define WATER MPM_MAX_DIM /* place of the water beside the axes: difference of pressures, what passes */
#define ROWS  (MPM_MAX_DIM + 1)

/* What a patch does at a mean relative displacement w. */
typedef struct {
  PetscBool active, refused; /* refused: the barrier has no answer */
  PetscReal gap, pressure;
  PetscReal force[MPM_MAX_DIM];                  /* on the first body */
  PetscReal slip[MPM_MAX_DIM];                   /* what is kept of it */
  PetscReal stiffness[MPM_MAX_DIM][MPM_MAX_DIM]; /* -d force/dw */
} Answer;

/* Pressure and its fall with the gap. */
static void Pressure(const MpmPairContacts *contacts, const MpmPairPatch *patch, const MpmContactLaw *law,
                     Answer *answer, PetscReal *rate)
{
  if (contacts->pairs->at[patch->pair].barrier) {
    answer->refused =
      (PetscBool)!MpmContactBarrier(law, MPM_BARRIER * contacts->cell, answer->gap, &answer->pressure, rate);
    answer->active = (PetscBool)(answer->pressure > 0.);
    return;
  }
  *rate            = patch->stiffness;
  answer->active   = (PetscBool)(patch->held || answer->gap <= contacts->touch);
  answer->pressure = answer->active ? -patch->stiffness * answer->gap : 0.;
}

/* Adds the traction along the surface, its derivative, and what is kept of the slip. */
static void Friction(const MpmPairPatch *patch, const MpmContactLaw *law, PetscInt dim, PetscReal rate, Answer *answer)
{
  const PetscReal   *n = patch->normal, area = patch->side[0].area;
  MpmContactFriction friction = {0};

  if (!patch->held) MpmContactSlide(law, dim, answer->pressure, answer->slip, &friction);
  for (PetscInt a = 0; patch->held && a < dim; a++) {
    friction.traction[a]    = (law->friction * answer->pressure + law->adhesion) * patch->way[a];
    friction.by_pressure[a] = law->friction * patch->way[a];
  }
  for (PetscInt a = 0; a < dim; a++) {
    answer->force[a] -= area * friction.traction[a];
    MpmContactAcross(dim, n, friction.by_slip[a]); /* dt/ds ds/dw, ds/dw = I - n n^T */
    for (PetscInt c = 0; c < dim; c++)
      answer->stiffness[a][c] += area * (friction.by_slip[a][c] + friction.by_pressure[a] * rate * n[c]);
  }
}

/* By how much a patch gives. */
static PetscReal Giving(const MpmPairContacts *contacts, const MpmPairPatch *patch)
{
  return contacts->pairs->at[patch->pair].stick ? 1. : contacts->give;
}

static void Evaluate(const MpmPairContacts *contacts, const MpmPairPatch *patch, PetscInt dim, const PetscReal w[],
                     Answer *answer)
{
  const MpmPair      *pair = &contacts->pairs->at[patch->pair];
  const MpmContactLaw law  = {.stiffness = patch->stiffness,
                              .along     = (patch->direct ? 1. : SLIDING) / Giving(contacts, patch),
                              .friction  = pair->friction,
                              .adhesion  = pair->adhesion,
                              .strength  = patch->strength,
                              .stick     = pair->stick,
                              .parts     = PETSC_TRUE,
                              .least     = contacts->least};
  const PetscReal    *n = patch->normal, area = patch->side[0].area;
  PetscReal           along = 0., rate;

  for (PetscInt a = 0; a < dim; a++) along += n[a] * w[a];
  *answer = (Answer){.gap = patch->gap - patch->touches - patch->shift - along};
  Pressure(contacts, patch, &law, answer, &rate);
  if (!answer->active) return;
  for (PetscInt a = 0; a < dim; a++) {
    answer->force[a] = -area * answer->pressure * n[a];
    for (PetscInt c = 0; c < dim; c++) answer->stiffness[a][c] = area * rate * n[a] * n[c];
    if (pair->tangential) answer->slip[a] = patch->slip[a] + w[a] - along * n[a];
  }
  if (pair->tangential) Friction(patch, &law, dim, rate, answer);
}

/* ---- sums ---- */

/* The unknown of a row. */
static PetscInt Component(const MpmPairContacts *contacts, PetscInt row)
{
  return row == WATER ? contacts->water : row;
}

/* Does the row act? */
static PetscBool Acts(const MpmPairPatch *patch, const MpmSum *sum, PetscInt row)
{
  return (PetscBool)(row == WATER ? patch->through > 0. : row < sum->space->dim);
}

/* Water that passes by the difference of pressures. */
static PetscReal Conductance(const MpmPairPatch *patch, const MpmSum *sum)
{
  return sum->dt * patch->side[0].area * patch->through;
}

/* Adds what turning of a side adds to the mean displacement. */
static void AddTurning(const MpmPairContacts *contacts, const MpmPairPatch *patch, PetscInt s, const MpmSum *sum,
                       const PetscReal u[], PetscReal w[])
{
  const MpmGroup  *box       = &sum->space->groups[patch->side[s].box];
  const PetscInt  *nodes     = &sum->space->group_nodes[box->node_offset];
  const PetscReal *weight    = &contacts->weight[patch->side[s].weight];
  PetscReal        moment[3] = {0., 0., 0.}, arm[3], way[3] = {0., 0., 0.};

  for (PetscInt i = 0; i < box->node_count; i++) {
    if (weight[i] == 0.) continue;
    MpmPairArm(patch, s, sum, i, arm);
    for (PetscInt a = 0; a < sum->space->dim; a++) way[a] = weight[i] * u[nodes[i] * sum->block + a];
    for (PetscInt a = 0; a < 3; a++)
      moment[a] += arm[(a + 1) % 3] * way[(a + 2) % 3] - arm[(a + 2) % 3] * way[(a + 1) % 3];
  }
  MpmPairAddTurning(&patch->side[s].lever, moment, s ? -1. : 1., w);
}

/* sum_i w_i u_i of the first side less that of the second */
static void Relative(const MpmPairContacts *contacts, const MpmPairPatch *patch, const MpmSum *sum, const PetscReal u[],
                     PetscReal w[])
{
  for (PetscInt a = 0; a < ROWS; a++) w[a] = 0.;
  for (PetscInt s = 0; s < 2; s++) {
    const MpmGroup  *box    = &sum->space->groups[patch->side[s].box];
    const PetscInt  *nodes  = &sum->space->group_nodes[box->node_offset];
    const PetscReal *weight = &contacts->weight[patch->side[s].weight], sign = s ? -1. : 1.;

    for (PetscInt i = 0; i < box->node_count; i++)
      for (PetscInt a = 0; weight[i] != 0. && a < ROWS; a++)
        if (Acts(patch, sum, a)) w[a] += sign * weight[i] * u[nodes[i] * sum->block + Component(contacts, a)];
    if (patch->direct) AddTurning(contacts, patch, s, sum, u, w);
  }
}

/* The same in explicit steps, where turning has its part. */
static void AddDirectForce(const MpmPairContacts *contacts, const MpmPairPatch *patch, const MpmSum *sum,
                           const PetscReal force[], PetscReal y[])
{
  for (PetscInt s = 0; s < 2; s++) {
    const MpmGroup  *box    = &sum->space->groups[patch->side[s].box];
    const PetscInt  *nodes  = &sum->space->group_nodes[box->node_offset];
    const PetscReal *weight = &contacts->weight[patch->side[s].weight], sign = s ? -1. : 1.;

    for (PetscInt i = 0; i < box->node_count; i++) {
      PetscReal arm[3], at_node[3];

      if (weight[i] == 0.) continue;
      MpmPairArm(patch, s, sum, i, arm);
      MpmPairNodeForce(&patch->side[s].lever, force, arm, at_node);
      for (PetscInt a = 0; a < sum->space->dim; a++) y[nodes[i] * sum->block + a] += sign * weight[i] * at_node[a];
    }
  }
}

/* y_i += w_i force on the first side's nodes, the opposite on the second's */
static void AddForce(const MpmPairContacts *contacts, const MpmPairPatch *patch, const MpmSum *sum,
                     const PetscReal force[], PetscReal y[])
{
  if (patch->direct) {
    AddDirectForce(contacts, patch, sum, force, y);
    return;
  }
  for (PetscInt s = 0; s < 2; s++) {
    const MpmGroup  *box    = &sum->space->groups[patch->side[s].box];
    const PetscInt  *nodes  = &sum->space->group_nodes[box->node_offset];
    const PetscReal *weight = &contacts->weight[patch->side[s].weight], sign = s ? -1. : 1.;

    for (PetscInt i = 0; i < box->node_count; i++)
      for (PetscInt a = 0; weight[i] != 0. && a < ROWS; a++)
        if (Acts(patch, sum, a)) y[nodes[i] * sum->block + Component(contacts, a)] += sign * weight[i] * force[a];
  }
}

/* The residual of a patch at w, as forces on the first side; the water's equation is that of the mass times -1. */
static PetscBool PatchResidual(const MpmPairPatch *patch, const MpmSum *sum, const PetscReal w[], const Answer *answer,
                               PetscReal force[])
{
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) force[a] = answer->active ? -answer->force[a] : 0.;
  force[WATER] = -Conductance(patch, sum) * w[WATER];
  return (PetscBool)(answer->active || patch->through > 0.);
}

/* Its derivative by rows c and d of w. */
static PetscReal PatchTangent(const MpmPairPatch *patch, const MpmSum *sum, const Answer *answer, PetscInt c,
                              PetscInt d)
{
  if (c == WATER || d == WATER) return c == d ? -Conductance(patch, sum) : 0.;
  return answer->active ? answer->stiffness[c][d] : 0.;
}

static PetscErrorCode Residual(const void *ctx, const MpmSum *sum, const PetscReal u[], PetscReal residual[],
                               PetscInt *failed)
{
  const MpmPairContacts *contacts = (const MpmPairContacts *)ctx;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < contacts->patch_count; k++) {
    const MpmPairPatch *patch = &contacts->patch[k];
    PetscReal           w[ROWS], force[ROWS];
    Answer              answer;

    Relative(contacts, patch, sum, u, w);
    Evaluate(contacts, patch, sum->space->dim, w, &answer);
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
    PetscReal           w[ROWS], force[ROWS];
    Answer              answer;

    Relative(contacts, patch, sum, u, w);
    Evaluate(contacts, patch, sum->space->dim, w, &answer);
    if (!answer.active && !(patch->through > 0.)) continue;
    Relative(contacts, patch, sum, du, w);
    for (PetscInt a = 0; a < ROWS; a++) {
      force[a] = 0.;
      for (PetscInt c = 0; c < ROWS; c++) force[a] += PatchTangent(patch, sum, &answer, a, c) * w[c];
    }
    AddForce(contacts, patch, sum, force, y);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Diagonal(const void *ctx, const MpmSum *sum, const PetscReal u[], PetscReal blocks[],
                               PetscInt *failed)
{
  const MpmPairContacts *contacts = (const MpmPairContacts *)ctx;
  const PetscInt         bs       = sum->block;

  PetscFunctionBeginUser;
  (void)failed;
  for (PetscInt k = 0; k < 2 * contacts->patch_count; k++) {
    const MpmPairPatch *patch  = &contacts->patch[k / 2];
    const MpmGroup     *box    = &sum->space->groups[patch->side[k % 2].box];
    const PetscInt     *nodes  = &sum->space->group_nodes[box->node_offset];
    const PetscReal    *weight = &contacts->weight[patch->side[k % 2].weight];
    PetscReal           w[ROWS];
    Answer              answer;

    Relative(contacts, patch, sum, u, w);
    Evaluate(contacts, patch, sum->space->dim, w, &answer);
    for (PetscInt i = 0; i < box->node_count; i++) {
      for (PetscInt cd = 0; weight[i] != 0. && cd < ROWS * ROWS; cd++) {
        const PetscInt c = cd / ROWS, d = cd % ROWS;

        if (Acts(patch, sum, c) && Acts(patch, sum, d))
          blocks[(nodes[i] * bs + Component(contacts, c)) * bs + Component(contacts, d)] +=
            weight[i] * weight[i] * PatchTangent(patch, sum, &answer, c, d);
      }
    }
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
      const PetscReal w = contacts->weight[patch->side[s].weight + i];

      if (w == 0.) continue;
      nodes[n]    = sum->space->group_nodes[box->node_offset + i];
      weight[n++] = s ? -w : w;
    }
  }
  return n;
}

/* The patch's block of the tangent, [i][c][c'][j]. */
static void Element(const MpmPairContacts *contacts, const MpmPairPatch *patch, const MpmSum *sum, const Answer *answer,
                    PetscInt n, const PetscReal weight[], PetscReal element[])
{
  const PetscInt bs = sum->block;

  for (PetscInt k = 0; k < n * n * bs * bs; k++) element[k] = 0.;
  for (PetscInt cd = 0; cd < ROWS * ROWS; cd++) {
    const PetscInt c = cd / ROWS, d = cd % ROWS;

    if (!Acts(patch, sum, c) || !Acts(patch, sum, d)) continue;
    const PetscReal value = PatchTangent(patch, sum, answer, c, d);

    for (PetscInt i = 0; i < n; i++)
      for (PetscInt j = 0; j < n; j++)
        element[((i * bs + Component(contacts, c)) * bs + Component(contacts, d)) * n + j] =
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
    PetscReal           w[ROWS];
    Answer              answer;

    Relative(contacts, patch, sum, u, w);
    Evaluate(contacts, patch, sum->space->dim, w, &answer);
    if (!answer.active && !(patch->through > 0.)) continue;
    const PetscInt n = NodesOf(contacts, patch, sum, nodes, weight);

    Element(contacts, patch, sum, &answer, n, weight, element);
    MpmPatternAddNodes(pattern, sum->space, n, nodes, element);
  }
  PetscCall(PetscFree3(element, weight, nodes));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MpmPairsAddSquares(const MpmPairContacts *contacts, const MpmSum *sum, const PetscReal u[], PetscReal *squares)
{
  for (PetscInt k = 0; k < contacts->patch_count; k++) {
    PetscReal w[ROWS];
    Answer    answer;

    Relative(contacts, &contacts->patch[k], sum, u, w);
    Evaluate(contacts, &contacts->patch[k], sum->space->dim, w, &answer);
    for (PetscInt a = 0; a < sum->space->dim; a++) *squares += PetscSqr(answer.force[a]);
  }
}

PetscErrorCode MpmPairsAugment(MpmPairContacts *contacts, const MpmSum *sum, const PetscReal u[], PetscReal *worst)
{
  PetscReal *shift;
  PetscBool  any = PETSC_FALSE;

  PetscFunctionBeginUser;
  *worst = 0.;
  for (PetscInt p = 0; p < contacts->pairs->count; p++) any = (PetscBool)(any || contacts->pairs->at[p].augmented);
  if (!any) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(contacts->patch_count, &shift));
  for (PetscInt k = 0; k < contacts->patch_count; k++) {
    const MpmPairPatch *patch = &contacts->patch[k];
    const MpmPair      *pair  = &contacts->pairs->at[patch->pair];
    PetscReal           w[ROWS];
    Answer              answer;

    shift[k] = 0.;
    if (!pair->augmented) continue;
    Relative(contacts, patch, sum, u, w);
    Evaluate(contacts, patch, sum->space->dim, w, &answer);
    if (answer.active) shift[k] = -answer.gap;
    if (answer.active || patch->shift > 0.)
      *worst = PetscMax(*worst, PetscAbsReal(shift[k] - patch->shift) / (pair->penetration * contacts->cell));
  }
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, worst, 1, MPIU_REAL, MPIU_MAX, contacts->comm));
  for (PetscInt k = 0; *worst > 1. && k < contacts->patch_count; k++) contacts->patch[k].shift = shift[k];
  PetscCall(PetscFree(shift));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- at the first of Newton's iterates ---- */

#define NEAR 0.1 /* of a cell: what is farther apart has parted */

/* Does any patch of the pair touch at u, on any rank? */
static PetscErrorCode Touches(const MpmPairContacts *contacts, PetscInt pair, const MpmSum *sum, const PetscReal u[],
                              PetscBool *touches)
{
  PetscFunctionBeginUser;
  *touches = PETSC_FALSE;
  for (PetscInt k = 0; k < contacts->patch_count && !*touches; k++) {
    PetscReal w[ROWS];
    Answer    answer;

    if (contacts->patch[k].pair != pair) continue;
    Relative(contacts, &contacts->patch[k], sum, u, w);
    Evaluate(contacts, &contacts->patch[k], sum->space->dim, w, &answer);
    *touches = answer.active;
  }
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, touches, 1, MPM_MPI_BOOL, MPI_LOR, contacts->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPairsBegin(MpmPairContacts *contacts, const MpmSum *sum, const PetscReal u[])
{
  const PetscInt dim = sum->space->dim;

  PetscFunctionBeginUser;
  MpmPairsEnd(contacts);
  contacts->least = MPM_CONTACT_LEAST;
  for (PetscInt p = 0; p < contacts->pairs->count; p++) {
    const MpmPair *pair    = &contacts->pairs->at[p];
    PetscBool      touches = PETSC_TRUE;

    if (pair->friction > 0. && !pair->barrier) PetscCall(Touches(contacts, p, sum, u, &touches));
    for (PetscInt k = 0; !touches && k < contacts->patch_count; k++) {
      MpmPairPatch *patch = &contacts->patch[k];
      PetscReal     size  = 0., w[ROWS];
      Answer        answer;

      for (PetscInt a = 0; a < dim; a++) size += PetscSqr(patch->slip[a]);
      if (patch->pair != p || !(size > 0.)) continue;
      Relative(contacts, patch, sum, u, w);
      Evaluate(contacts, patch, dim, w, &answer);
      if (answer.gap > NEAR * contacts->cell) continue;
      patch->held = contacts->holds = PETSC_TRUE;
      for (PetscInt a = 0; a < dim; a++) patch->way[a] = patch->slip[a] / PetscSqrtReal(size);
    }
  }
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &contacts->holds, 1, MPM_MPI_BOOL, MPI_LOR, contacts->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MpmPairsGive(MpmPairContacts *contacts, PetscReal give)
{
  for (PetscInt k = 0; k < contacts->patch_count; k++)
    for (PetscInt a = 0; a < MPM_MAX_DIM && !contacts->pairs->at[contacts->patch[k].pair].stick; a++)
      contacts->patch[k].slip[a] *= give / contacts->give;
  contacts->give = give;
}

void MpmPairsRelease(MpmPairContacts *contacts)
{
  contacts->holds = PETSC_FALSE;
  for (PetscInt k = 0; k < contacts->patch_count; k++) contacts->patch[k].held = PETSC_FALSE;
}

void MpmPairsEnd(MpmPairContacts *contacts)
{
  MpmPairsRelease(contacts);
  contacts->least = 0.;
}

/* ---- the step is over ---- */

/*
  The slip that is kept of an explicit step, in which contact acted where the nodes would have come without it: the one they came to; of
  what slides at most what the traction stretches.
*/
static void KeepSlip(const MpmPairContacts *contacts, const MpmPairPatch *patch, const MpmSum *sum, PetscReal slip[])
{
  const PetscInt dim = sum->space->dim;
  PetscReal      w[ROWS], square = 0., most = 0., came[MPM_MAX_DIM];

  Relative(contacts, patch, sum, contacts->moved, w);
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
  PetscReal(*slip)[MPM_MAX_DIM];

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(contacts->patch_count, &slip));
  PetscCall(PetscArrayzero(contacts->force, contacts->pairs->count));
  for (PetscInt k = 0; k < contacts->patch_count; k++) {
    PetscReal w[ROWS];
    Answer    answer;

    Relative(contacts, &contacts->patch[k], sum, u, w);
    Evaluate(contacts, &contacts->patch[k], sum->space->dim, w, &answer);
    if (contacts->moved && answer.active) KeepSlip(contacts, &contacts->patch[k], sum, answer.slip);
    for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
      slip[k][a] = answer.slip[a] / Giving(contacts, &contacts->patch[k]);
      contacts->force[contacts->patch[k].pair][a] += answer.force[a];
    }
    contacts->patch[k].closed = 0.;
    for (PetscInt a = 0; answer.active && a < sum->space->dim; a++)
      contacts->patch[k].closed += contacts->patch[k].normal[a] * w[a];
    if (contacts->pairs->at[contacts->patch[k].pair].augmented)
      contacts->patch[k].shift = answer.pressure / contacts->patch[k].stiffness;
  }
  if (contacts->near || !contacts->bare) PetscCall(MpmPairPatchesKeep(contacts, slip, particles));
  contacts->bare = (PetscBool)!contacts->near;
  PetscCall(PetscFree(slip));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, contacts->force, (PetscMPIInt)(contacts->pairs->count * MPM_MAX_DIM),
                           MPIU_REAL, MPIU_SUM, contacts->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscBool Idle(const void *ctx)
{
  return (PetscBool) !((const MpmPairContacts *)ctx)->patch_count;
}

const MpmTerm MpmTermBodyContact = {.name     = "body contact",
                                    .account  = MPM_ACCOUNT_DISSIPATED,
                                    .idle     = Idle,
                                    .boxes    = MpmPairPatchesFind,
                                    .prepare  = MpmPairPatchesPrepare,
                                    .link     = MpmPairPatchesLink,
                                    .residual = Residual,
                                    .tangent  = Tangent,
                                    .apply    = Apply,
                                    .diagonal = Diagonal,
                                    .commit   = Commit};

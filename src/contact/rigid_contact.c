/*
  Contact of the material with rigid surfaces that do not follow the grid, by a penalty on patches (contact_patches.c).

  With d_q the distance of facet q from the surface at the step's end, less the distance at which it touches, s_q its
  slip along the surface since it touched, and A_q its area, a patch of area A = sum A_q has

    g = sum_q A_q d_q / A ,   s = sum_q A_q s_q / A ,   pressure p = -k g ,   traction t = k' s ,   k = penalty E/h

  and acts where g <= 0 (unilateral), or at the facets that touched at the start (bilateral). For pieces of the surface,
  surface_shares.c, g is that at the end of the last step, plus the change of d. Coulomb friction bounds the traction:
  where |k' s| > L = mu max(p, 0) + adhesion, t = L s/|s|, and the kept slip becomes t/k'. A sticking patch thus has the
  elastic slip t/k', the only regularisation; k' = k where nothing may slide and on round bodies, and k/10 elsewhere. L
  is no more than the material's own shear strength where its law has one that no pressure changes (undrained clay),
  with `stick` as well. The material would otherwise slide on itself right beside the surface, in a layer that no cell
  can resolve, and a pipe would carry half a cell of clay along. Facet q gets the force -A_q (k g n_q + P_q t), P_q = I
  - n n^T at the step's start; the reaction is the sum of these forces.

  Without slip the force has the potential A (k/2) (g^2 + s^2), and the tangent is symmetric:

    A (k B_g B_g^T + B_s^T dt/ds B_s + B_s^T dt/dg B_g^T) + sum_q A_q k g w_q w_q^T grad n_q

  with B_g = dg/du, B_s = ds/du. A pressure p makes a depth of p h/(penalty E), while forces balance as well as Newton's
  method has converged. All forms of the Jacobian take the derivative from here.
*/
#include "grid/grid.h"
#include "particles/particles.h"
#include "particles/points.h"
#include "space/space.h"
#include "space/sum.h"
#include "assembly/sparsity.h"
#include "assembly/terms.h"
#include "contact/contact.h"
#include "facets/contact_law.h"
#include "contact/rigid_body.h"

/* ---- sums ---- */

/* Adds this rank's facets' forces: at prescribed boundaries into the residual or, without one, the squares of all. */
static PetscErrorCode AddForces(const MpmContacts *contacts, const MpmSum *sum, const PetscReal u[],
                                PetscReal residual[], PetscReal *squares)
{
  MpmPatchWork work;

  PetscFunctionBeginUser;
  if (!contacts->patch_count) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmPatchWorkCreate(contacts, &work));
  for (PetscInt k = 0; k < contacts->patch_count; k++) {
    const MpmPatch *patch = &contacts->patch[k];
    MpmPatchAnswer  answer;

    if (residual && MpmFacetsBody(&contacts->facets, patch->boundary)) continue;
    MpmPatchFrame(contacts, patch)->evaluate(contacts, patch, sum, u, &work, &answer);
    for (PetscInt f = patch->begin; answer.any && f < patch->end; f++) {
      PetscReal force[MPM_MAX_DIM];

      if (contacts->facets.at[f].point < 0) continue; /* its rank adds it */
      MpmFacetForce(contacts, patch, f, &work, &answer, force);
      if (residual)
        MpmFacetAddForce(sum, &sum->space->groups[patch->box], MpmFacetWeights(contacts, f), -1., force, residual);
      for (PetscInt a = 0; !residual && a < sum->space->dim; a++) *squares += PetscSqr(force[a]);
    }
  }
  PetscCall(MpmPatchWorkDestroy(&work));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Residual(const void *ctx, const MpmSum *sum, const PetscReal u[], PetscReal residual[],
                               PetscInt *failed)
{
  PetscFunctionBeginUser;
  (void)failed;
  PetscCall(AddForces((const MpmContacts *)ctx, sum, u, residual, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode AddSquares(const void *ctx, const MpmSum *sum, const PetscReal u[], PetscReal *squares)
{
  PetscFunctionBeginUser;
  PetscCall(AddForces((const MpmContacts *)ctx, sum, u, NULL, squares));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* At boundaries with prescribed motion: their own work, less that on the material. */
static PetscErrorCode Work(const void *ctx, const MpmSum *sum, const PetscReal at[], const PetscReal u[],
                           MpmTermWork *account)
{
  const MpmContacts *contacts = (const MpmContacts *)ctx;
  const PetscInt     dim      = sum->space->dim;
  PetscReal          material = 0., boundary = 0.;
  MpmPatchWork       work;

  PetscFunctionBeginUser;
  if (!contacts->patch_count) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmPatchWorkCreate(contacts, &work));
  for (PetscInt k = 0; k < contacts->patch_count; k++) {
    const MpmPatch *patch  = &contacts->patch[k];
    const MpmPose  *before = &contacts->facets.before[patch->boundary],
                  *after   = &contacts->facets.after[patch->boundary];
    MpmPatchAnswer answer;

    if (MpmFacetsBody(&contacts->facets, patch->boundary)) continue;
    MpmPatchEvaluateAt(contacts, patch, sum, at, &work, &answer);
    for (PetscInt f = patch->begin; answer.any && f < patch->end; f++) {
      const MpmFacet *facet = &contacts->facets.at[f];
      PetscReal       force[MPM_MAX_DIM], moved[MPM_MAX_DIM], value[MPM_MAX_DIM];

      MpmFacetForce(contacts, patch, f, &work, &answer, force);
      MpmPatchValue(contacts, sum, patch, f, u, value);
      MpmPoseCarry(dim, before, after, facet->place, moved);
      for (PetscInt a = 0; a < dim; a++) {
        material += force[a] * value[a];
        boundary += force[a] * (moved[a] - facet->place[a]);
      }
    }
  }
  account->external += boundary;
  account->dissipated += boundary - material;
  PetscCall(MpmPatchWorkDestroy(&work));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* How gap and slip change with du. */
static void Change(const MpmContacts *contacts, const MpmPatch *patch, const MpmSum *sum, const PetscReal du[],
                   const MpmPatchWork *work, PetscReal *gap, PetscReal slip[])
{
  const PetscInt dim = sum->space->dim;

  *gap = 0.;
  for (PetscInt a = 0; a < dim; a++) slip[a] = 0.;
  for (PetscInt f = patch->begin; f < patch->end; f++) {
    const MpmFacet *facet = &contacts->facets.at[f];
    const PetscReal share = facet->area / patch->area;
    PetscReal       value[MPM_MAX_DIM];

    MpmPatchValue(contacts, sum, patch, f, du, value);
    for (PetscInt a = 0; a < dim; a++) *gap += share * work->surface[f - patch->begin].normal[a] * value[a];
    MpmContactAcross(dim, facet->normal, value);
    for (PetscInt a = 0; a < dim; a++) slip[a] += share * value[a];
  }
}

static PetscErrorCode Apply(const void *ctx, const MpmSum *sum, const PetscReal u[], const PetscReal du[],
                            PetscReal y[])
{
  const MpmContacts *contacts = (const MpmContacts *)ctx;
  const PetscInt     dim      = sum->space->dim;
  MpmPatchWork       work;

  PetscFunctionBeginUser;
  if (!contacts->patch_count) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmPatchWorkCreate(contacts, &work));
  for (PetscInt k = 0; k < contacts->patch_count; k++) {
    const MpmPatch *patch = &contacts->patch[k];
    const MpmGroup *box   = &sum->space->groups[patch->box];
    PetscReal       gap, slip[MPM_MAX_DIM], traction[MPM_MAX_DIM] = {0., 0., 0.};
    MpmPatchAnswer  answer;

    if (MpmFacetsBody(&contacts->facets, patch->boundary)) continue;
    MpmPatchEvaluateAt(contacts, patch, sum, u, &work, &answer);
    if (!answer.any) continue;
    Change(contacts, patch, sum, du, &work, &gap, slip);
    for (PetscInt a = 0; a < dim; a++) {
      traction[a] = answer.by_gap[a] * gap;
      for (PetscInt c = 0; c < dim; c++) traction[a] += answer.by_slip[a][c] * slip[c];
    }
    for (PetscInt f = patch->begin; f < patch->end; f++) {
      const MpmSurface *surface = &work.surface[f - patch->begin];
      const PetscReal   beyond = work.beyond[f - patch->begin], own = beyond != 0. ? patch->stiffness : 0.;
      const PetscReal   normal = answer.stiffness * answer.gap + patch->stiffness * beyond;
      PetscReal         value[MPM_MAX_DIM], force[MPM_MAX_DIM], along = 0.;

      if (contacts->facets.at[f].point < 0) continue;
      MpmFacetValue(sum, box, MpmFacetWeights(contacts, f), du, value);
      for (PetscInt a = 0; a < dim; a++) along += surface->normal[a] * value[a];
      for (PetscInt a = 0; a < dim; a++) force[a] = traction[a];
      MpmContactAcross(dim, contacts->facets.at[f].normal, force);
      for (PetscInt a = 0; a < dim; a++) {
        force[a] += (answer.stiffness * gap + own * along) * surface->normal[a];
        for (PetscInt c = 0; c < dim; c++) force[a] += normal * surface->second[a][c] * value[c];
      }
      MpmFacetAddForce(sum, box, MpmFacetWeights(contacts, f), contacts->facets.at[f].area, force, y);
    }
  }
  PetscCall(MpmPatchWorkDestroy(&work));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* B_g[i][c] and B_s[e][i][c] of a patch, e the direction of slip; of n dim numbers. `own`: by this rank's facets. */
static void Derivatives(const MpmContacts *contacts, const MpmPatch *patch, const MpmSum *sum, const MpmPatchWork *work,
                        PetscBool own, PetscReal gap[], PetscReal slip[])
{
  const PetscInt  dim = sum->space->dim, n = sum->space->groups[patch->box].node_count;
  const PetscBool tangential = contacts->facets.boundaries[patch->boundary].tangential;

  for (PetscInt i = 0; i < n * dim; i++) gap[i] = 0.;
  for (PetscInt i = 0; i < n * dim * dim; i++) slip[i] = 0.;
  for (PetscInt f = patch->begin; f < patch->end; f++) {
    const MpmFacet  *facet  = &contacts->facets.at[f];
    const PetscReal *weight = MpmFacetWeights(contacts, f), *normal = work->surface[f - patch->begin].normal;

    if (own && facet->point < 0) continue;
    for (PetscInt i = 0; i < n; i++) {
      const PetscReal w = weight[i] * facet->area / patch->area;

      for (PetscInt c = 0; w != 0. && c < dim; c++) {
        gap[i * dim + c] += w * normal[c];
        for (PetscInt e = 0; tangential && e < dim; e++)
          slip[(e * n + i) * dim + c] += w * ((e == c ? 1. : 0.) - facet->normal[e] * facet->normal[c]);
      }
    }
  }
}

/* Tangent of a patch: sum_m left_m right_m^T, of vectors with n dim numbers, and facets' curvature. */
typedef struct {
  PetscReal *left, *right;
} Factors;

/* With left_{1+e} = B_s,e, right_{1+e} = A sum_f dt_e/ds_f B_s,f + A dt_e/dg B_g; left_0 = B_g, right_0 = A k B_g. */
static void FactorsOf(const MpmContacts *contacts, const MpmPatch *patch, const MpmSum *sum, const MpmPatchWork *work,
                      const MpmPatchAnswer *answer, const Factors *factors)
{
  const PetscInt dim = sum->space->dim, size = sum->space->groups[patch->box].node_count * dim;
  PetscReal     *gap = factors->left, *slip = factors->left + size;

  Derivatives(contacts, patch, sum, work, PETSC_FALSE, gap, slip);
  for (PetscInt i = 0; i < size; i++) {
    factors->right[i] = patch->area * answer->stiffness * gap[i];
    for (PetscInt e = 0; e < dim; e++) {
      PetscReal value = answer->by_gap[e] * gap[i];

      for (PetscInt c = 0; c < dim; c++) value += answer->by_slip[e][c] * slip[c * size + i];
      factors->right[(1 + e) * size + i] = patch->area * value;
    }
  }
  if (patch->foreign) Derivatives(contacts, patch, sum, work, PETSC_TRUE, gap, slip); /* forces act on own facets */
}

static PetscErrorCode FactorsCreate(const MpmContacts *contacts, const MpmSum *sum, Factors *factors, PetscInt *nodes)
{
  const PetscInt dim = sum->space->dim;

  PetscFunctionBeginUser;
  *nodes = 0;
  for (PetscInt k = 0; k < contacts->patch_count; k++)
    *nodes = PetscMax(*nodes, sum->space->groups[contacts->patch[k].box].node_count);
  PetscCall(PetscMalloc2(((dim + 1) * *nodes * dim), &factors->left, ((dim + 1) * *nodes * dim), &factors->right));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* element[i][c][d][j], of n^2 block^2 numbers, becomes the patch's tangent. */
static void Element(const MpmContacts *contacts, const MpmPatch *patch, const MpmSum *sum, const MpmPatchWork *work,
                    const MpmPatchAnswer *answer, const Factors *factors, PetscReal element[])
{
  const PetscInt dim = sum->space->dim, bs = sum->block, n = sum->space->groups[patch->box].node_count;
  const PetscInt terms = contacts->facets.boundaries[patch->boundary].tangential ? dim + 1 : 1;

  for (PetscInt k = 0; k < n * n * bs * bs; k++) element[k] = 0.;
  for (PetscInt m = 0; m < terms; m++) {
    for (PetscInt ic = 0; ic < n * dim; ic++) {
      const PetscReal left = factors->left[m * n * dim + ic];

      for (PetscInt jd = 0; left != 0. && jd < n * dim; jd++)
        element[((ic / dim * bs + ic % dim) * bs + jd % dim) * n + jd / dim] += left * factors->right[m * n * dim + jd];
    }
  }
  for (PetscInt f = patch->begin; f < patch->end; f++) {
    const PetscReal *weight = MpmFacetWeights(contacts, f);

    if (contacts->facets.at[f].point < 0) continue;
    for (PetscInt cd = 0; cd < dim * dim; cd++) {
      const PetscReal own = MpmFacetStiffness(contacts, patch, f, work, answer, cd / dim, cd % dim);

      for (PetscInt i = 0; own != 0. && i < n; i++)
        for (PetscInt j = 0; weight[i] != 0. && j < n; j++)
          element[((i * bs + cd / dim) * bs + cd % dim) * n + j] += own * weight[i] * weight[j];
    }
  }
}

static PetscErrorCode Tangent(const void *ctx, const MpmSum *sum, const PetscReal u[], MpmPattern *pattern,
                              PetscReal residual[], PetscInt *failed)
{
  const MpmContacts *contacts = (const MpmContacts *)ctx;
  PetscReal         *element;
  MpmPatchWork       work;
  Factors            factors;
  PetscInt           most;

  PetscFunctionBeginUser;
  if (!contacts->patch_count) PetscFunctionReturn(PETSC_SUCCESS);
  if (residual) PetscCall(Residual(ctx, sum, u, residual, failed));
  PetscCall(MpmPatchWorkCreate(contacts, &work));
  PetscCall(FactorsCreate(contacts, sum, &factors, &most));
  PetscCall(PetscMalloc1((most * most * sum->block * sum->block), &element));
  for (PetscInt k = 0; k < contacts->patch_count; k++) {
    const MpmPatch *patch = &contacts->patch[k];
    MpmPatchAnswer  answer;

    if (MpmFacetsBody(&contacts->facets, patch->boundary)) continue;
    MpmPatchEvaluateAt(contacts, patch, sum, u, &work, &answer);
    if (!answer.any) continue;
    FactorsOf(contacts, patch, sum, &work, &answer, &factors);
    Element(contacts, patch, sum, &work, &answer, &factors, element);
    MpmPatternAddBlock(pattern, sum->space, &sum->space->groups[patch->box], element);
  }
  PetscCall(PetscFree(element));
  PetscCall(PetscFree2(factors.left, factors.right));
  PetscCall(MpmPatchWorkDestroy(&work));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the converged step ---- */

/* Adds a patch of the converged step to its boundary's reaction, moment and depth. */
static void AddReaction(MpmContacts *contacts, const MpmPatch *patch, const MpmSum *sum, const PetscReal u[],
                        MpmPatchWork *work, MpmPatchAnswer *answer)
{
  const PetscInt         b     = patch->boundary;
  const MpmContactFrame *frame = MpmPatchFrame(contacts, patch);
  PetscReal             *depth = &contacts->depth[b];

  frame->evaluate(contacts, patch, sum, u, work, answer);
  if (!answer->any) return;
  for (PetscInt f = patch->begin; f < patch->end; f++) {
    PetscReal force[3] = {0., 0., 0.}, arm[3] = {0., 0., 0.};

    if (contacts->facets.at[f].point < 0) continue;
    MpmFacetForce(contacts, patch, f, work, answer, force);
    frame->turn(contacts, patch, f, sum, u, force, arm);
    for (PetscInt a = 0; a < 3; a++) {
      const PetscInt p = (a + 1) % 3, q = (a + 2) % 3;

      contacts->reaction[b][a] += force[a];
      contacts->moment[b][a] += arm[p] * force[q] - arm[q] * force[p];
    }
    if (work->beyond[f - patch->begin] != 0.)
      *depth = PetscMax(*depth, PetscAbsReal(work->beyond[f - patch->begin]) + contacts->tilt);
  }
  if (MpmPatchIsCorrected(contacts, patch) || !contacts->facets.boundaries[b].augmented)
    *depth = PetscMax(*depth, PetscAbsReal(answer->gap + patch->shift));
  if (contacts->moved) MpmPatchKeepSlip(contacts, patch, sum, contacts->moved, work, answer);
  frame->keep(contacts, patch, sum, u, answer->slip);
}

/* Reactions, moments and depths of the converged step; keeps the slips. */
static PetscErrorCode Commit(void *ctx, const MpmSum *sum, const PetscReal u[], MpmParticles *particles)
{
  MpmContacts      *contacts = (MpmContacts *)ctx;
  const MPI_Comm    comm     = sum->grid->comm;
  const PetscMPIInt count    = (PetscMPIInt)contacts->facets.boundary_count;
  MpmPatchAnswer   *answers;
  MpmPatchWork      work;

  PetscFunctionBeginUser;
  if (!count) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmPatchWorkCreate(contacts, &work));
  PetscCall(PetscMalloc1(contacts->patch_count, &answers));
  PetscCall(PetscArrayzero(contacts->depth, count));
  PetscCall(PetscArrayzero(contacts->reaction, count));
  PetscCall(PetscArrayzero(contacts->moment, count));
  for (PetscInt k = 0; k < contacts->patch_count; k++)
    AddReaction(contacts, &contacts->patch[k], sum, u, &work, &answers[k]);
  PetscCall(MpmContactsKeep(contacts, sum, answers, particles));
  for (PetscInt k = 0; k < contacts->patch_count; k++)
    contacts->patch[k].rest = -contacts->patch[k].stiffness * answers[k].gap;
  if (contacts->face) PetscCall(MpmContactsFindFaces(contacts, sum, answers, particles));
  contacts->newton.bare = (PetscBool)!contacts->newton.near;
  PetscCall(PetscFree(answers));
  PetscCall(MpmPatchWorkDestroy(&work));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, contacts->reaction, count * MPM_MAX_DIM, MPIU_REAL, MPIU_SUM, comm));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, contacts->moment, count * MPM_MAX_DIM, MPIU_REAL, MPIU_SUM, comm));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, contacts->depth, count, MPIU_REAL, MPIU_MAX, comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the term ---- */

static PetscBool Idle(const void *ctx)
{
  return (PetscBool) !((const MpmContacts *)ctx)->patch_count;
}

static unsigned Traits(const void *ctx)
{
  const MpmContacts *contacts = (const MpmContacts *)ctx;
  unsigned           traits   = contacts->facets.boundary_count ? MPM_TERM_CONTACT : 0;

  for (PetscInt b = 0; b < contacts->facets.boundary_count; b++) {
    const MpmBoundary *boundary = &contacts->facets.boundaries[b];

    if (boundary->bilateral) traits |= MPM_TERM_BILATERAL;
    if (!boundary->bilateral || !boundary->tangential) traits |= MPM_TERM_RELEASES;
    if (boundary->tangential) traits |= MPM_TERM_RUBS;
    if (boundary->tangential && !boundary->stick) traits |= MPM_TERM_SLIDES;
    if (boundary->augmented) traits |= MPM_TERM_AUGMENTED;
  }
  return traits;
}

static PetscBool *Near(void *ctx)
{
  return &((MpmContacts *)ctx)->newton.near;
}

static PetscBool Holds(const void *ctx)
{
  return ((const MpmContacts *)ctx)->newton.holds;
}

/* Stiffness of the stiffest boundary. */
static PetscReal Firmness(const void *ctx)
{
  const MpmContacts *contacts = (const MpmContacts *)ctx;
  PetscReal          penalty  = 0.;

  for (PetscInt k = 0; contacts->newton.near && k < contacts->facets.boundary_count; k++)
    penalty = PetscMax(penalty, contacts->newton.raised * contacts->facets.boundaries[k].penalty);
  return penalty;
}

static PetscErrorCode Turn(void *ctx, const MpmSum *sum, const PetscReal v[], PetscReal part)
{
  PetscFunctionBeginUser;
  PetscCall(MpmFacetsTurn(&((MpmContacts *)ctx)->facets, sum, v, part));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void Arrive(void *ctx, const PetscReal u[])
{
  ((MpmContacts *)ctx)->moved = u;
}

const MpmTerm MpmTermContact = {
  .name        = "rigid contact",
  .idle        = Idle,
  .boxes       = MpmContactsFind,
  .prepare     = MpmContactsPrepare,
  .residual    = Residual,
  .tangent     = Tangent,
  .apply       = Apply,
  .step        = {.commit = Commit, .put_back = MpmContactsPutBack, .balance = MpmContactsBalance},
  .traits      = Traits,
  .near        = Near,
  .energy.work = Work,
  .newton      = {.begin    = MpmContactsBegin,
                  .accepted = MpmContactsFollow,
                  .end      = MpmContactsEnd,
                  .holds    = Holds,
                  .soften   = MpmContactsGive,
                  .firmness = Firmness,
                  .squares  = AddSquares,
                  .augment  = MpmContactsAugment},
  .motion      = {.turn = Turn, .bear = MpmContactsBear, .limit = MpmContactsLimit, .arrive = Arrive}};

/*
  Contact of the material with rigid surfaces that do not follow the grid, by a penalty on patches (contact_patches.c).

  With d_q the distance of facet q from the surface at the step's end, less the distance at which it touches, s_q its slip
  along the surface since it touched, and A_q its area, a patch of area A = sum A_q has

    g = sum_q A_q d_q / A ,   s = sum_q A_q s_q / A ,   pressure p = -k g ,   traction t = k s ,   k = penalty E/h

  and acts where g <= 0 (unilateral), or at the facets that touched at the start (bilateral). Coulomb friction bounds the
  traction: where |k s| > L = mu max(p, 0) + adhesion, t = L s/|s|, and the slip that is kept becomes t/k. So a patch that sticks
  gives by t/k, which is all the regularisation there is. Facet q gets the force -A_q (k g n_q + P_q t), P_q = I - n n^T at
  the step's start; the reaction is the sum of these forces.

  Without slip the force has the potential A (k/2) (g^2 + s^2), and the tangent is symmetric:

    A (k B_g B_g^T + B_s^T dt/ds B_s + B_s^T dt/dg B_g^T) + sum_q A_q k g w_q w_q^T grad n_q

  with B_g = dg/du, B_s = ds/du. A pressure p makes a depth of p h/(penalty E), while forces balance as well as Newton's method has
  converged. All forms of the Jacobian take the derivative from here.
*/
#include "grid/grid.h"
#include "particles/particles.h"
#include "particles/points.h"
#include "space/space.h"
#include "space/sum.h"
#include "terms/contact.h"
#include "terms/sparsity.h"
#include "terms/terms.h"

/* ---- one patch ---- */

/* What a patch does at a displacement of its nodes. */
typedef struct {
  PetscBool active, any;                                            /* the mean acts; a facet does */
  PetscReal stiffness;                                              /* of the mean: 0 where it does not act */
  PetscReal gap, slip[MPM_MAX_DIM];                                 /* slip: what is kept of it */
  PetscReal traction[MPM_MAX_DIM];                                  /* along the surface */
  PetscReal by_slip[MPM_MAX_DIM][MPM_MAX_DIM], by_gap[MPM_MAX_DIM]; /* its derivatives */
} Answer;

/* Room for the facets of a patch. */
typedef struct {
  MpmSurface *surface; /* at the step's end */
  PetscReal
    *beyond; /* how far they are beyond what the patch may tilt: < 0 too deep; > 0, of a bilateral one, too far */
} Work;

static PetscErrorCode WorkCreate(const MpmContacts *contacts, Work *work)
{
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc2(contacts->most, &work->surface, contacts->most, &work->beyond));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode WorkDestroy(Work *work)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree2(work->surface, work->beyond));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static const PetscReal *WeightsOf(const MpmContacts *contacts, PetscInt facet)
{
  return &contacts->weight[contacts->facet[facet].weight];
}

/* sum_i w_i u_i over the nodes of a box */
static void FacetValue(const MpmSum *sum, const MpmGroup *box, const PetscReal weight[], const PetscReal u[],
                       PetscReal value[])
{
  const PetscInt *nodes = &sum->space->group_nodes[box->node_offset];

  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) value[a] = 0.;
  for (PetscInt i = 0; i < box->node_count; i++)
    for (PetscInt a = 0; weight[i] != 0. && a < sum->space->dim; a++)
      value[a] += weight[i] * u[nodes[i] * sum->block + a];
}

/* P v, v less its part along n */
static void Project(PetscInt dim, const PetscReal n[], PetscReal v[])
{
  PetscReal dot = 0.;

  for (PetscInt a = 0; a < dim; a++) dot += v[a] * n[a];
  for (PetscInt a = 0; a < dim; a++) v[a] -= dot * n[a];
}

/* The traction along the surface that goes with the mean slip, and its derivatives. */
static void Friction(const MpmBoundary *boundary, PetscReal k, Answer *answer)
{
  const PetscInt dim  = boundary->dim;
  PetscReal      size = 0., limit;

  for (PetscInt a = 0; a < dim; a++) size += PetscSqr(answer->slip[a]);
  size  = PetscSqrtReal(size);
  limit = boundary->friction * PetscMax(-k * answer->gap, 0.) + boundary->adhesion;
  if (boundary->stick || k * size <= limit) {
    for (PetscInt a = 0; a < dim; a++) {
      answer->traction[a]   = k * answer->slip[a];
      answer->by_slip[a][a] = k;
    }
    return;
  }
  for (PetscInt a = 0; a < dim; a++) {
    const PetscReal along = answer->slip[a] / size;

    answer->traction[a] = limit * along;
    answer->by_gap[a]   = answer->gap < 0. ? -boundary->friction * k * along : 0.;
    for (PetscInt c = 0; c < dim; c++)
      answer->by_slip[a][c] = limit / size * ((a == c ? 1. : 0.) - along * answer->slip[c] / size);
  }
  for (PetscInt a = 0; a < dim; a++) answer->slip[a] = answer->traction[a] / k;
}

/* Takes the displacement of a boundary's own place off that of the material there. */
static void Relative(const MpmPose *before, const MpmPose *after, PetscInt dim, const PetscReal place[],
                     PetscReal value[])
{
  PetscReal carried[MPM_MAX_DIM];

  if (before->turned || after->turned) {
    MpmPoseCarry(dim, before, after, place, carried);
    for (PetscInt a = 0; a < dim; a++) value[a] -= carried[a] - place[a];
  } else {
    for (PetscInt a = 0; a < dim; a++) value[a] -= after->translation[a] - before->translation[a];
  }
}

/* How far a facet is beyond what a patch may tilt. */
static PetscReal Beyond(const MpmContacts *contacts, const MpmBoundary *boundary, PetscReal gap)
{
  if (gap < -contacts->tilt) return gap + contacts->tilt;
  return boundary->bilateral && gap > contacts->tilt ? gap - contacts->tilt : 0.;
}

static void Evaluate(const MpmContacts *contacts, const MpmPatch *patch, const MpmSum *sum, const PetscReal u[],
                     Work *work, Answer *answer)
{
  const MpmBoundary *boundary = &contacts->boundaries[patch->boundary];
  const MpmPose     *before = &contacts->before[patch->boundary], *after = &contacts->after[patch->boundary];
  const PetscInt     dim = boundary->dim;

  *answer = (Answer){.active = boundary->bilateral};
  for (PetscInt f = patch->begin; f < patch->end; f++) {
    const MpmFacet *facet   = &contacts->facet[f];
    MpmSurface     *surface = &work->surface[f - patch->begin];
    const PetscReal share   = facet->area / patch->area;
    PetscReal       value[MPM_MAX_DIM], at[MPM_MAX_DIM];

    FacetValue(sum, &sum->space->groups[patch->box], WeightsOf(contacts, f), u, value);
    for (PetscInt a = 0; a < dim; a++) at[a] = facet->place[a] + value[a];
    MpmBoundaryDistance(boundary, after, at, surface);
    work->beyond[f - patch->begin] = Beyond(contacts, boundary, surface->distance - facet->touches);
    if (work->beyond[f - patch->begin] != 0.) answer->any = PETSC_TRUE;
    answer->gap += share * (surface->distance - facet->touches);
    if (!boundary->tangential) continue;
    Relative(before, after, dim, facet->place, value);
    Project(dim, facet->normal, value);
    for (PetscInt a = 0; a < dim; a++) answer->slip[a] += share * (facet->slip[a] + value[a]);
  }
  if (!boundary->bilateral) answer->active = (PetscBool)(answer->gap <= contacts->touch);
  if (!answer->active) {
    answer->gap = 0.;
    for (PetscInt a = 0; a < dim; a++) answer->slip[a] = 0.;
    return;
  }
  answer->any       = PETSC_TRUE;
  answer->stiffness = patch->stiffness;
  if (boundary->tangential) Friction(boundary, patch->stiffness, answer);
}

/* The force on the material at a facet. */
static void FacetForce(const MpmContacts *contacts, const MpmPatch *patch, PetscInt f, const Work *work,
                       const Answer *answer, PetscReal force[])
{
  const MpmFacet *facet  = &contacts->facet[f];
  const PetscReal normal = answer->stiffness * answer->gap + patch->stiffness * work->beyond[f - patch->begin];
  const PetscInt  dim    = contacts->boundaries[patch->boundary].dim;

  for (PetscInt a = 0; a < dim; a++) force[a] = answer->traction[a];
  Project(dim, facet->normal, force);
  for (PetscInt a = 0; a < dim; a++)
    force[a] = -facet->area * (force[a] + normal * work->surface[f - patch->begin].normal[a]);
}

/* ---- sums ---- */

/* y_i += factor w_i force */
static void AddForce(const MpmSum *sum, const MpmGroup *box, const PetscReal weight[], PetscReal factor,
                     const PetscReal force[], PetscReal y[])
{
  const PetscInt *nodes = &sum->space->group_nodes[box->node_offset];

  for (PetscInt i = 0; i < box->node_count; i++)
    for (PetscInt a = 0; weight[i] != 0. && a < sum->space->dim; a++)
      y[nodes[i] * sum->block + a] += factor * weight[i] * force[a];
}

static PetscErrorCode Residual(const void *ctx, const MpmSum *sum, const PetscReal u[], PetscReal residual[],
                               PetscInt *failed)
{
  const MpmContacts *contacts = (const MpmContacts *)ctx;
  Work               work;

  PetscFunctionBeginUser;
  (void)failed;
  if (!contacts->patch_count) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(WorkCreate(contacts, &work));
  for (PetscInt k = 0; k < contacts->patch_count; k++) {
    const MpmPatch *patch = &contacts->patch[k];
    Answer          answer;

    Evaluate(contacts, patch, sum, u, &work, &answer);
    for (PetscInt f = patch->begin; answer.any && f < patch->end; f++) {
      PetscReal force[MPM_MAX_DIM];

      FacetForce(contacts, patch, f, &work, &answer, force);
      AddForce(sum, &sum->space->groups[patch->box], WeightsOf(contacts, f), -1., force, residual);
    }
  }
  PetscCall(WorkDestroy(&work));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* How gap and slip change with du. */
static void Change(const MpmContacts *contacts, const MpmPatch *patch, const MpmSum *sum, const PetscReal du[],
                   const Work *work, PetscReal *gap, PetscReal slip[])
{
  const PetscInt dim = sum->space->dim;

  *gap = 0.;
  for (PetscInt a = 0; a < dim; a++) slip[a] = 0.;
  for (PetscInt f = patch->begin; f < patch->end; f++) {
    const MpmFacet *facet = &contacts->facet[f];
    const PetscReal share = facet->area / patch->area;
    PetscReal       value[MPM_MAX_DIM];

    FacetValue(sum, &sum->space->groups[patch->box], WeightsOf(contacts, f), du, value);
    for (PetscInt a = 0; a < dim; a++) *gap += share * work->surface[f - patch->begin].normal[a] * value[a];
    Project(dim, facet->normal, value);
    for (PetscInt a = 0; a < dim; a++) slip[a] += share * value[a];
  }
}

static PetscErrorCode Apply(const void *ctx, const MpmSum *sum, const PetscReal u[], const PetscReal du[],
                            PetscReal y[])
{
  const MpmContacts *contacts = (const MpmContacts *)ctx;
  const PetscInt     dim      = sum->space->dim;
  Work               work;

  PetscFunctionBeginUser;
  if (!contacts->patch_count) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(WorkCreate(contacts, &work));
  for (PetscInt k = 0; k < contacts->patch_count; k++) {
    const MpmPatch *patch = &contacts->patch[k];
    const MpmGroup *box   = &sum->space->groups[patch->box];
    PetscReal       gap, slip[MPM_MAX_DIM], traction[MPM_MAX_DIM] = {0., 0., 0.};
    Answer          answer;

    Evaluate(contacts, patch, sum, u, &work, &answer);
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

      FacetValue(sum, box, WeightsOf(contacts, f), du, value);
      for (PetscInt a = 0; a < dim; a++) along += surface->normal[a] * value[a];
      for (PetscInt a = 0; a < dim; a++) force[a] = traction[a];
      Project(dim, contacts->facet[f].normal, force);
      for (PetscInt a = 0; a < dim; a++) {
        force[a] += (answer.stiffness * gap + own * along) * surface->normal[a];
        for (PetscInt c = 0; c < dim; c++) force[a] += normal * surface->second[a][c] * value[c];
      }
      AddForce(sum, box, WeightsOf(contacts, f), contacts->facet[f].area, force, y);
    }
  }
  PetscCall(WorkDestroy(&work));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* B_g[i][c] and B_s[e][i][c] of a patch, e the direction of slip; each of n dim numbers. */
static void Derivatives(const MpmContacts *contacts, const MpmPatch *patch, const MpmSum *sum, const Work *work,
                        PetscReal gap[], PetscReal slip[])
{
  const PetscInt  dim = sum->space->dim, n = sum->space->groups[patch->box].node_count;
  const PetscBool tangential = contacts->boundaries[patch->boundary].tangential;

  for (PetscInt i = 0; i < n * dim; i++) gap[i] = 0.;
  for (PetscInt i = 0; i < n * dim * dim; i++) slip[i] = 0.;
  for (PetscInt f = patch->begin; f < patch->end; f++) {
    const MpmFacet  *facet  = &contacts->facet[f];
    const PetscReal *weight = WeightsOf(contacts, f), *normal = work->surface[f - patch->begin].normal;

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

/* What the tangent of a patch consists of: sum_m left_m right_m^T, of vectors with n dim numbers, and facets' curvature. */
typedef struct {
  PetscReal *left, *right;
} Factors;

/* Where `slip` holds B_s, right_{1+e} = A sum_f dt_e/ds_f B_s,f + A dt_e/dg B_g; left_0 = B_g, right_0 = A k B_g. */
static void FactorsOf(const MpmContacts *contacts, const MpmPatch *patch, const MpmSum *sum, const Work *work,
                      const Answer *answer, const Factors *factors)
{
  const PetscInt dim = sum->space->dim, size = sum->space->groups[patch->box].node_count * dim;
  PetscReal     *gap = factors->left, *slip = factors->left + size;

  Derivatives(contacts, patch, sum, work, gap, slip);
  for (PetscInt i = 0; i < size; i++) {
    factors->right[i] = patch->area * answer->stiffness * gap[i];
    for (PetscInt e = 0; e < dim; e++) {
      PetscReal value = answer->by_gap[e] * gap[i];

      for (PetscInt c = 0; c < dim; c++) value += answer->by_slip[e][c] * slip[c * size + i];
      factors->right[(1 + e) * size + i] = patch->area * value;
    }
  }
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

/* What facet f adds on its own to the tangent, of directions c and d: its curvature, and what is beyond the tilt. */
static PetscReal OwnStiffness(const MpmContacts *contacts, const MpmPatch *patch, PetscInt f, const Work *work,
                              const Answer *answer, PetscInt c, PetscInt d)
{
  const MpmSurface *surface = &work->surface[f - patch->begin];
  const PetscReal   beyond  = work->beyond[f - patch->begin];
  PetscReal         value   = (answer->stiffness * answer->gap + patch->stiffness * beyond) * surface->second[c][d];

  if (beyond != 0.) value += patch->stiffness * surface->normal[c] * surface->normal[d];
  return contacts->facet[f].area * value;
}

static PetscErrorCode Diagonal(const void *ctx, const MpmSum *sum, const PetscReal u[], PetscReal blocks[],
                               PetscInt *failed)
{
  const MpmContacts *contacts = (const MpmContacts *)ctx;
  const PetscInt     dim = sum->space->dim, bs = sum->block;
  Work               work;
  Factors            factors;
  PetscInt           most;

  PetscFunctionBeginUser;
  (void)failed;
  if (!contacts->patch_count) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(WorkCreate(contacts, &work));
  PetscCall(FactorsCreate(contacts, sum, &factors, &most));
  for (PetscInt k = 0; k < contacts->patch_count; k++) {
    const MpmPatch *patch = &contacts->patch[k];
    const MpmGroup *box   = &sum->space->groups[patch->box];
    const PetscInt *nodes = &sum->space->group_nodes[box->node_offset], n = box->node_count;
    Answer          answer;

    Evaluate(contacts, patch, sum, u, &work, &answer);
    if (!answer.any) continue;
    FactorsOf(contacts, patch, sum, &work, &answer, &factors);
    for (PetscInt i = 0; i < n; i++) {
      for (PetscInt cd = 0; nodes[i] >= 0 && cd < dim * dim; cd++) {
        const PetscInt c = cd / dim, d = cd % dim;
        PetscReal      value = 0.;

        for (PetscInt m = 0; m <= dim; m++)
          value += factors.left[(m * n + i) * dim + c] * factors.right[(m * n + i) * dim + d];
        for (PetscInt f = patch->begin; f < patch->end; f++)
          value += PetscSqr(WeightsOf(contacts, f)[i]) * OwnStiffness(contacts, patch, f, &work, &answer, c, d);
        blocks[(nodes[i] * bs + c) * bs + d] += value;
      }
    }
  }
  PetscCall(PetscFree2(factors.left, factors.right));
  PetscCall(WorkDestroy(&work));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* element[i][c][d][j], of n^2 block^2 numbers, becomes the patch's tangent. */
static void Element(const MpmContacts *contacts, const MpmPatch *patch, const MpmSum *sum, const Work *work,
                    const Answer *answer, const Factors *factors, PetscReal element[])
{
  const PetscInt dim = sum->space->dim, bs = sum->block, n = sum->space->groups[patch->box].node_count;
  const PetscInt terms = contacts->boundaries[patch->boundary].tangential ? dim + 1 : 1;

  for (PetscInt k = 0; k < n * n * bs * bs; k++) element[k] = 0.;
  for (PetscInt m = 0; m < terms; m++) {
    for (PetscInt ic = 0; ic < n * dim; ic++) {
      const PetscReal left = factors->left[m * n * dim + ic];

      for (PetscInt jd = 0; left != 0. && jd < n * dim; jd++)
        element[((ic / dim * bs + ic % dim) * bs + jd % dim) * n + jd / dim] += left * factors->right[m * n * dim + jd];
    }
  }
  for (PetscInt f = patch->begin; f < patch->end; f++) {
    const PetscReal *weight = WeightsOf(contacts, f);

    for (PetscInt cd = 0; cd < dim * dim; cd++) {
      const PetscReal own = OwnStiffness(contacts, patch, f, work, answer, cd / dim, cd % dim);

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
  Work               work;
  Factors            factors;
  PetscInt           most;

  PetscFunctionBeginUser;
  if (!contacts->patch_count) PetscFunctionReturn(PETSC_SUCCESS);
  if (residual) PetscCall(Residual(ctx, sum, u, residual, failed));
  PetscCall(WorkCreate(contacts, &work));
  PetscCall(FactorsCreate(contacts, sum, &factors, &most));
  PetscCall(PetscMalloc1((most * most * sum->block * sum->block), &element));
  for (PetscInt k = 0; k < contacts->patch_count; k++) {
    const MpmPatch *patch = &contacts->patch[k];
    Answer          answer;

    Evaluate(contacts, patch, sum, u, &work, &answer);
    if (!answer.any) continue;
    FactorsOf(contacts, patch, sum, &work, &answer, &factors);
    Element(contacts, patch, sum, &work, &answer, &factors, element);
    MpmPatternAddBlock(pattern, sum->space, &sum->space->groups[patch->box], element);
  }
  PetscCall(PetscFree(element));
  PetscCall(PetscFree2(factors.left, factors.right));
  PetscCall(WorkDestroy(&work));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the converged step ---- */

/* The points of a patch keep its slip while it touches. */
static PetscErrorCode KeepSlips(const MpmContacts *contacts, const MpmSum *sum, const Answer answers[],
                                MpmParticles *particles)
{

  PetscFunctionBeginUser;
  for (PetscInt b = 0; b < contacts->boundary_count; b++) {
    for (PetscInt a = 0; contacts->boundaries[b].tangential && a < sum->space->dim; a++) {
      PetscReal *slip;

      PetscCall(DMSwarmGetField(particles->swarm, contacts->boundaries[b].slip_field[a], NULL, NULL, (void **)&slip));
      PetscCall(PetscArrayzero(slip, sum->points->count));
      for (PetscInt k = 0; k < contacts->patch_count; k++)
        for (PetscInt f = contacts->patch[k].begin; contacts->patch[k].boundary == b && f < contacts->patch[k].end; f++)
          slip[contacts->facet[f].point] = answers[k].slip[a];
      PetscCall(
        DMSwarmRestoreField(particles->swarm, contacts->boundaries[b].slip_field[a], NULL, NULL, (void **)&slip));
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reactions and depths of the converged step; keeps the slips. */
static PetscErrorCode Commit(void *ctx, const MpmSum *sum, const PetscReal u[], MpmParticles *particles)
{
  MpmContacts   *contacts = (MpmContacts *)ctx;
  const PetscInt dim      = sum->space->dim;
  Answer        *answers;
  Work           work;

  PetscFunctionBeginUser;
  if (!contacts->boundary_count) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(WorkCreate(contacts, &work));
  PetscCall(PetscMalloc1(contacts->patch_count, &answers));
  for (PetscInt b = 0; b < contacts->boundary_count; b++) {
    contacts->depth[b] = 0.;
    for (PetscInt a = 0; a < MPM_MAX_DIM; a++) contacts->reaction[b][a] = 0.;
  }
  for (PetscInt k = 0; k < contacts->patch_count; k++) {
    const MpmPatch *patch = &contacts->patch[k];
    PetscReal      *depth = &contacts->depth[patch->boundary], force[MPM_MAX_DIM];

    Evaluate(contacts, patch, sum, u, &work, &answers[k]);
    if (!answers[k].any) continue;
    for (PetscInt f = patch->begin; f < patch->end; f++) {
      FacetForce(contacts, patch, f, &work, &answers[k], force);
      for (PetscInt a = 0; a < dim; a++) contacts->reaction[patch->boundary][a] += force[a];
    }
    for (PetscInt f = patch->begin; f < patch->end; f++)
      if (work.beyond[f - patch->begin] != 0.)
        *depth = PetscMax(*depth, PetscAbsReal(work.beyond[f - patch->begin]) + contacts->tilt);
    *depth = PetscMax(*depth, PetscAbsReal(answers[k].gap));
    MpmPoseTurn(dim, &contacts->before[patch->boundary], &contacts->after[patch->boundary], answers[k].slip,
                answers[k].slip);
  }
  PetscCall(KeepSlips(contacts, sum, answers, particles));
  PetscCall(PetscFree(answers));
  PetscCall(WorkDestroy(&work));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, contacts->reaction, (PetscMPIInt)(contacts->boundary_count * MPM_MAX_DIM),
                           MPIU_REAL, MPIU_SUM, sum->grid->comm));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, contacts->depth, (PetscMPIInt)contacts->boundary_count, MPIU_REAL, MPIU_MAX,
                           sum->grid->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

const MpmTerm MpmTermContact = {.name     = "rigid contact",
                                .boxes    = MpmContactsFind,
                                .prepare  = MpmContactsPrepare,
                                .residual = Residual,
                                .tangent  = Tangent,
                                .apply    = Apply,
                                .diagonal = Diagonal,
                                .commit   = Commit};

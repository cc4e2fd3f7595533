/*
  Contact of material points with boundaries that do not follow the grid, by a penalty.

  A point meets a boundary with its face, not with its centre: the face stands at y = x - d n, where n is the boundary's
  normal and d how far the point's domain reaches along it, d = min_a l_a/|n_a|. What lies nearer than that at the start
  (a lattice of points cut at an angle) keeps its initial share of d, so that a body that is put on a boundary sits on it.

  With g the distance of the face from the boundary at the step's end, and A the point's area, the energy

    (k A/2) (g^2 + |s|^2) ,   k = penalty E/h ,   s = slip along the tangent plane at the step's start (stick only)

  counts where g < 0 (unilateral), or for all points that touch at the start (bilateral). The force on the body is
  t = -k A (g n + s), its derivative -k A (n n^T + g grad n + I - n n^T (stick)): symmetric. The reaction is the sum of t.
  A pressure p thus makes a depth of p h/(penalty E), while forces balance as well as Newton's method has converged.

  The face's displacement comes from the nodes by the weights of the part of the domain about the face that is in the
  domain: the face's middle across, the domain's mean along. That makes a uniform pressure on an even face consistent with
  uniform stress, in every node. Shapes without a domain take the point's own weights.

  Each contact is pointwise, like the kernel, so all forms of the Jacobian take its derivative from here.
*/
#include "geometry/geometry.h"
#include "point/material.h"
#include "grid/grid.h"
#include "particles/particles.h"
#include "particles/points.h"
#include "space/rules.h"
#include "space/space.h"
#include "space/sum.h"
#include "terms/contact.h"
#include "terms/rigid.h"
#include "terms/rigid_body.h"
#include "terms/sparsity.h"
#include "terms/terms.h"

#define TOUCH 1e-12 /* of a cell: rounding of a face that stands on the boundary */

PetscErrorCode MpmContactsCreate(PetscInt count, const MpmBoundary boundaries[], MpmContacts *contacts)
{
  PetscFunctionBeginUser;
  contacts->boundary_count = count;
  contacts->boundaries     = boundaries;
  PetscCall(PetscCalloc1(count, &contacts->before));
  PetscCall(PetscCalloc1(count, &contacts->after));
  PetscCall(PetscCalloc1(count, &contacts->reaction));
  PetscCall(PetscCalloc1(count, &contacts->depth));
  PetscCall(PetscCalloc1(count, &contacts->moment));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmContactsDestroy(MpmContacts *contacts)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(contacts->before));
  PetscCall(PetscFree(contacts->after));
  PetscCall(PetscFree(contacts->reaction));
  PetscCall(PetscFree(contacts->depth));
  PetscCall(PetscFree(contacts->moment));
  PetscCall(PetscFree(contacts->bodies));
  PetscCall(PetscFree(contacts->contact));
  PetscCall(PetscFree(contacts->weight));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- which points ---- */

/* How far a box of these half-lengths reaches along n. */
static PetscReal Reach(PetscInt dim, const PetscReal half[], const PetscReal n[])
{
  PetscReal reach = PETSC_INFINITY;

  for (PetscInt a = 0; a < dim; a++)
    if (n[a] != 0.) reach = PetscMin(reach, half[a] / PetscAbsReal(n[a]));
  return reach;
}

/* The share of its reach at which the point stands at the start: 1 for all but those that lie nearer. Also its distance. */
static PetscReal InitialShare(const MpmBoundary *boundary, const MpmPoints *points, PetscInt p, PetscReal *distance,
                              PetscReal *reach)
{
  const MpmPose still = {.growth = 0.};
  MpmSurface    surface;

  MpmBoundaryDistance(boundary, &still, &points->x0[p * boundary->dim], &surface);
  *distance = surface.distance;
  *reach    = Reach(boundary->dim, &points->half_length[p * boundary->dim], surface.normal);
  return PetscMin(1., PetscMax(0., *distance / *reach));
}

PetscErrorCode MpmBoundaryCheck(const MpmBoundary *boundary, const MpmGrid *grid, MpmParticles *particles)
{
  PetscInt  count[3] = {0, 0, 0}; /* contact candidates, behind the boundary, at it */
  MpmPoints points;

  PetscFunctionBeginUser;
  PetscCall(MpmParticlesGetArrays(particles, &points));
  for (PetscInt p = 0; p < points.count; p++) {
    PetscReal distance, reach;

    if (!MpmRegionContains(boundary->region, &points.x0[p * grid->dim])) continue;
    (void)InitialShare(boundary, &points, p, &distance, &reach);
    count[0]++;
    count[1] += distance < -MPM_TOLERANCE * reach;
    count[2] += distance <= (1. + MPM_TOLERANCE) * reach;
  }
  PetscCall(MpmParticlesRestoreArrays(particles, &points));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, count, 3, MPIU_INT, MPI_SUM, grid->comm));
  MpmCheckInput(count[0], "-mpm_boundary_%s_points_region: there is no point in it", boundary->name);
  MpmCheckInput(!count[1],
                "-mpm_boundary_%s_type: %" PetscInt_FMT
                " points lie behind it at the start; turn its normal or side, or "
                "choose the contact candidates with its points_region",
                boundary->name, count[1]);
  MpmCheckInput(!boundary->bilateral || count[2],
                "-mpm_boundary_%s_contact bilateral: no point lies at it at the start", boundary->name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* How far a surface that turns comes towards a place, at most: as far as the place would be taken from it. */
static PetscReal TurnMargin(const MpmContacts *contacts, PetscInt b, PetscInt dim, const PetscReal x[])
{
  const MpmPose *before = &contacts->before[b], *after = &contacts->after[b];
  PetscReal      y[MPM_MAX_DIM], square                = 0.;

  if (!before->turned && !after->turned) return 0.;
  MpmPoseCarry(dim, after, before, x, y);
  for (PetscInt a = 0; a < dim; a++) square += PetscSqr(y[a] - x[a]);
  return PetscSqrtReal(square);
}

/* That whose place is solved for, or NULL. */
static const MpmRigidBody *Body(const MpmContacts *contacts, PetscInt b)
{
  return contacts->bodies && contacts->bodies[b].freedom ? &contacts->bodies[b] : NULL;
}

/* Is the point a contact candidate of this step, and where does its face stand? */
static PetscErrorCode Describe(const MpmContacts *contacts, const MpmRules *rules, const MpmPoints *points,
                               PetscReal margin, MpmContact *contact, PetscBool *candidate)
{
  const PetscInt     b = contact->boundary, p = contact->point;
  const MpmBoundary *boundary = &contacts->boundaries[b];
  const PetscInt     dim      = boundary->dim;
  const PetscReal   *half = &points->half_length[p * dim], *F = &points->F[p * dim * dim];
  PetscReal  U[MPM_MAX_DIM] = {1., 1., 1.}, stretched[MPM_MAX_DIM], distance, reach, share, most = 0., length = 0.;
  MpmSurface surface;

  PetscFunctionBeginUser;
  *candidate = PETSC_FALSE;
  if (Body(contacts, b))
    MpmRigidDistance(Body(contacts, b), boundary, &contacts->before[b], &points->x[p * dim], &surface);
  else MpmBoundaryDistance(boundary, &contacts->before[b], &points->x[p * dim], &surface);
  for (PetscInt k = 0; k < dim * dim; k++) most += F[k] * F[k]; /* no stretch is larger */
  for (PetscInt a = 0; a < dim; a++) length += half[a] * half[a];
  margin += TurnMargin(contacts, b, dim, &points->x[p * dim]);
  if (!boundary->bilateral && surface.distance > margin + PetscSqrtReal(most * length))
    PetscFunctionReturn(PETSC_SUCCESS);
  if (!MpmRegionContains(boundary->region, &points->x0[p * dim])) PetscFunctionReturn(PETSC_SUCCESS);
  share = InitialShare(boundary, points, p, &distance, &reach);
  if (boundary->bilateral && distance > (1. + MPM_TOLERANCE) * reach) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCheck(!rules->stretch(F, U), PETSC_COMM_SELF, PETSC_ERR_FP, "point %" PetscInt_FMT " has no stretch",
             points->id[p]);
  for (PetscInt a = 0; a < dim; a++) stretched[a] = half[a] * U[a];
  share *= Reach(dim, stretched, surface.normal);
  for (PetscInt a = 0; a < dim; a++) {
    contact->face[a]   = points->x[p * dim + a] - share * surface.normal[a];
    contact->normal[a] = surface.normal[a];
    contact->slip[a]   = 0.;
  }
  contact->stiffness = boundary->penalty * contacts->unit * rules->materials[points->material[p]].penalty *
                       points->volume0[p] / (2. * Reach(dim, half, surface.normal));
  *candidate = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* All contacts of one boundary, in the order of the groups. */
static PetscErrorCode List(MpmContacts *contacts, PetscInt b, const MpmRules *rules, const MpmSpace *space,
                           const MpmPoints *points)
{
  const MpmPose *before = &contacts->before[b], *after = &contacts->after[b];
  PetscReal      margin = 0.;

  PetscFunctionBeginUser;
  for (PetscInt a = 0; a < space->dim; a++) {
    margin = PetscMax(margin, 2. * rules->grid->h[a]);
    margin += PetscAbsReal(after->translation[a] - before->translation[a]);
  }
  margin += PetscAbsReal(after->growth - before->growth);
  if (Body(contacts, b))
    for (PetscInt k = 0; k < 6; k++) margin += 2. * PetscAbsReal(contacts->bodies[b].guess[k]);
  for (PetscInt g = 0; g < space->group_count; g++) {
    for (PetscInt s = space->groups[g].point_begin; s < space->groups[g].point_end; s++) {
      MpmContact contact = {.point = space->order[s], .group = g, .boundary = b};
      PetscBool  candidate;

      PetscCall(Describe(contacts, rules, points, margin, &contact, &candidate));
      if (!candidate) continue;
      if (contacts->count == contacts->capacity) {
        contacts->capacity = 2 * contacts->capacity + 64;
        PetscCall(PetscRealloc((size_t)contacts->capacity * sizeof(MpmContact), &contacts->contact));
      }
      contacts->contact[contacts->count++] = contact;
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Weights of a contact's face on one axis, at the nodes of its group. */
static void AxisWeights(const MpmRules *rules, const MpmSpace *space, const MpmPoints *points,
                        const MpmContact *contact, PetscInt a, const PetscReal half[], PetscReal line[])
{
  const MpmGrid  *grid  = rules->grid;
  const MpmGroup *group = &space->groups[contact->group];
  const PetscInt  p = contact->point, dim = space->dim, last = group->count[a] - 1;
  PetscInt        lower[MPM_MAX_DIM], upper[MPM_MAX_DIM];
  PetscReal       weight[MPM_MAX_WIDTH], unused[MPM_MAX_WIDTH];
  MpmShapeLine    face = {.weight = weight, .gradient = unused};

  if (!half) {
    for (PetscInt i = 0; i <= last; i++) line[i] = space->shape[0].weight[(p * dim + a) * space->width + i];
    return;
  }
  const PetscReal x  = (points->x[p * dim + a] - grid->lower[a]) / grid->h[a];
  const PetscReal at = PetscMin(PetscMax((contact->face[a] - grid->lower[a]) / grid->h[a], x - half[a]), x + half[a]);

  MpmSpaceEdges(rules, &points->x[p * dim], lower, upper);
  MpmShapeEvaluate(rules->shape, rules->edge, at, PetscMax(half[a] - PetscAbsReal(at - x), 0.), lower[a], upper[a],
                   &face);
  for (PetscInt i = 0; i <= last; i++) line[i] = 0.;
  for (PetscInt i = 0; i < face.count; i++) /* rounding may touch a node more than the domain does */
    line[PetscMin(PetscMax(face.first + i - group->first[a], 0), last)] += weight[i];
}

static PetscErrorCode Weights(MpmContacts *contacts, const MpmRules *rules, const MpmSpace *space,
                              const MpmPoints *points)
{
  PetscInt size = 0;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < contacts->count; k++) {
    contacts->contact[k].weight = size;
    size += space->groups[contacts->contact[k].group].node_count;
  }
  PetscCall(PetscMalloc1(size, &contacts->weight));
  for (PetscInt k = 0; k < contacts->count; k++) {
    const MpmContact *contact = &contacts->contact[k];
    const MpmGroup   *group   = &space->groups[contact->group];
    PetscReal        *weight  = &contacts->weight[contact->weight];
    PetscReal         line[MPM_MAX_DIM][MPM_MAX_WIDTH], half[MPM_MAX_DIM];
    const PetscBool   domain = MpmShapeHasDomain(rules->shape);

    line[2][0] = 1.;
    if (domain) (void)MpmSpaceHalfLengths(rules, points, contact->point, half);
    for (PetscInt a = 0; a < space->dim; a++)
      AxisWeights(rules, space, points, contact, a, domain ? half : NULL, line[a]);
    for (PetscInt i = 0; i < group->node_count; i++) {
      const PetscInt row = i / group->count[0];

      weight[i] = line[0][i % group->count[0]] * line[1][row % group->count[1]] * line[2][row / group->count[1]];
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Slip at the step's start, put into the tangent plane there. */
static PetscErrorCode LoadSlips(MpmContacts *contacts, MpmParticles *particles, PetscInt dim)
{
  PetscFunctionBeginUser;
  for (PetscInt b = 0; b < contacts->boundary_count; b++) {
    for (PetscInt a = 0; contacts->boundaries[b].stick && a < dim; a++) {
      PetscReal *slip;

      PetscCall(DMSwarmGetField(particles->swarm, contacts->boundaries[b].slip_field[a], NULL, NULL, (void **)&slip));
      for (PetscInt k = 0; k < contacts->count; k++)
        if (contacts->contact[k].boundary == b) contacts->contact[k].slip[a] = slip[contacts->contact[k].point];
      PetscCall(
        DMSwarmRestoreField(particles->swarm, contacts->boundaries[b].slip_field[a], NULL, NULL, (void **)&slip));
    }
  }
  for (PetscInt k = 0; k < contacts->count; k++) {
    MpmContact *contact = &contacts->contact[k];
    PetscReal   dot     = 0.;

    for (PetscInt a = 0; a < dim; a++) dot += contact->slip[a] * contact->normal[a];
    for (PetscInt a = 0; a < dim; a++) contact->slip[a] -= dot * contact->normal[a];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The contacts of the step, about the bodies' guess. */
static PetscErrorCode Find(MpmContacts *contacts, const MpmTermStep *step)
{
  const MpmSpace *space = step->sum->space;

  PetscFunctionBeginUser;
  PetscCall(PetscFree(contacts->weight));
  contacts->count = 0;
  for (PetscInt b = 0; b < contacts->boundary_count; b++)
    PetscCall(List(contacts, b, step->rules, space, step->sum->points));
  PetscCall(Weights(contacts, step->rules, space, step->sum->points));
  PetscCall(LoadSlips(contacts, step->particles, space->dim));
  for (PetscInt k = 0; contacts->bodies && k < contacts->count; k++)
    if (Body(contacts, contacts->contact[k].boundary))
      MpmRigidPull(Body(contacts, contacts->contact[k].boundary), &contacts->contact[k]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Prepare(void *ctx, const MpmTermStep *step)
{
  MpmContacts    *contacts = (MpmContacts *)ctx;
  const MpmRules *rules    = step->rules;
  const MpmSpace *space    = step->sum->space;
  PetscReal       h        = rules->grid->h[0];
  PetscBool       moved    = PETSC_FALSE;

  PetscFunctionBeginUser;
  if (!contacts->boundary_count) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt a = 1; a < space->dim; a++) h = PetscMin(h, rules->grid->h[a]);
  contacts->unit  = 1. / h;
  contacts->touch = TOUCH * h;
  for (PetscInt b = 0; b < contacts->boundary_count; b++) {
    contacts->before[b] = (MpmPose){.growth = 0.};
    if (step->time_n > 0.) contacts->before[b] = MpmBoundaryPose(&contacts->boundaries[b], step->time_n);
    contacts->after[b] = MpmBoundaryPose(&contacts->boundaries[b], step->time);
  }
  if (contacts->bodies) MpmRigidBegin(contacts, step);
  do {
    PetscCall(Find(contacts, step));
    if (contacts->bodies) PetscCall(MpmRigidSettle(contacts, step->sum, &moved));
  } while (moved);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- sums ---- */

/* Takes the boundary's own displacement at a face off a vector. */
static void Relative(const MpmContacts *contacts, const MpmContact *contact, PetscInt dim, PetscReal vector[])
{
  const MpmPose *before = &contacts->before[contact->boundary], *after = &contacts->after[contact->boundary];
  PetscReal      carried[MPM_MAX_DIM];

  if (before->turned || after->turned) {
    MpmPoseCarry(dim, before, after, contact->face, carried);
    for (PetscInt a = 0; a < dim; a++) vector[a] -= carried[a] - contact->face[a];
  } else
    for (PetscInt a = 0; a < dim; a++) vector[a] = vector[a] - after->translation[a] + before->translation[a];
}

void MpmContactEvaluate(const MpmContacts *contacts, const MpmContact *contact, PetscInt dim, const PetscReal u[],
                        MpmContactAnswer *answer)
{
  const MpmBoundary *boundary        = &contacts->boundaries[contact->boundary];
  PetscReal          at[MPM_MAX_DIM] = {0., 0., 0.}, relative[MPM_MAX_DIM], along = 0.;
  MpmSurface         surface;

  for (PetscInt a = 0; a < dim; a++) at[a] = contact->face[a] + u[a];
  MpmBoundaryDistance(boundary, &contacts->after[contact->boundary], at, &surface);
  /* what rounding took from the place counts where a body's balance depends on the depths of its contacts */
  for (PetscInt a = 0; a < dim && Body(contacts, contact->boundary); a++)
    surface.distance += surface.normal[a] * (u[a] - (at[a] - contact->face[a]));
  *answer       = (MpmContactAnswer){.active = (PetscBool)(boundary->bilateral || surface.distance <= contacts->touch)};
  answer->depth = boundary->bilateral ? PetscAbsReal(surface.distance) : PetscMax(0., -surface.distance);
  if (!answer->active) return;
  for (PetscInt a = 0; a < dim; a++) {
    relative[a] = u[a];
    if (boundary->stick) answer->slip[a] = contact->slip[a] + u[a];
  }
  Relative(contacts, contact, dim, relative);
  if (boundary->stick) Relative(contacts, contact, dim, answer->slip);
  for (PetscInt a = 0; a < dim; a++) along += contact->normal[a] * relative[a];
  for (PetscInt a = 0; a < dim; a++) {
    if (boundary->stick) answer->slip[a] -= along * contact->normal[a];
    answer->force[a] = -contact->stiffness * (surface.distance * surface.normal[a] + answer->slip[a]);
    for (PetscInt c = 0; c < dim; c++) {
      PetscReal k = surface.normal[a] * surface.normal[c] + surface.distance * surface.second[a][c];

      if (boundary->stick) k += (a == c ? 1. : 0.) - contact->normal[a] * contact->normal[c];
      answer->stiffness[a][c] = contact->stiffness * k;
    }
  }
}

void MpmContactFaceValue(const MpmContacts *contacts, const MpmSum *sum, const MpmContact *contact, const PetscReal u[],
                         PetscReal value[])
{
  const MpmGroup  *group  = &sum->space->groups[contact->group];
  const PetscInt  *nodes  = &sum->space->group_nodes[group->node_offset];
  const PetscReal *weight = &contacts->weight[contact->weight];

  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) value[a] = 0.;
  for (PetscInt i = 0; i < group->node_count; i++)
    for (PetscInt a = 0; a < sum->space->dim; a++) value[a] += weight[i] * u[nodes[i] * sum->block + a];
}

void MpmContactAddForce(const MpmContacts *contacts, const MpmSum *sum, const MpmContact *contact, PetscReal factor,
                        const PetscReal force[], PetscReal y[])
{
  const MpmGroup  *group  = &sum->space->groups[contact->group];
  const PetscInt  *nodes  = &sum->space->group_nodes[group->node_offset];
  const PetscReal *weight = &contacts->weight[contact->weight];
  const PetscInt   dim = sum->space->dim, bs = sum->block;

  for (PetscInt a = 0; a < dim; a++)
    for (PetscInt i = 0; i < group->node_count; i++) y[nodes[i] * bs + a] += factor * weight[i] * force[a];
}

static PetscErrorCode Residual(const void *ctx, const MpmSum *sum, const PetscReal u[], PetscReal residual[],
                               PetscInt *failed)
{
  const MpmContacts *contacts = (const MpmContacts *)ctx;

  PetscFunctionBeginUser;
  (void)failed;
  for (PetscInt k = 0; k < contacts->count; k++) {
    const MpmContact *contact = &contacts->contact[k];
    PetscReal         value[MPM_MAX_DIM];
    MpmContactAnswer  answer;

    if (Body(contacts, contact->boundary)) continue;
    MpmContactFaceValue(contacts, sum, contact, u, value);
    MpmContactEvaluate(contacts, contact, sum->space->dim, value, &answer);
    if (answer.active) MpmContactAddForce(contacts, sum, contact, -1., answer.force, residual);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Apply(const void *ctx, const MpmSum *sum, const PetscReal u[], const PetscReal du[],
                            PetscReal y[])
{
  const MpmContacts *contacts = (const MpmContacts *)ctx;
  const PetscInt     dim      = sum->space->dim;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < contacts->count; k++) {
    const MpmContact *contact = &contacts->contact[k];
    PetscReal         value[MPM_MAX_DIM], force[MPM_MAX_DIM] = {0., 0., 0.};
    MpmContactAnswer  answer;

    if (Body(contacts, contact->boundary)) continue;
    MpmContactFaceValue(contacts, sum, contact, u, value);
    MpmContactEvaluate(contacts, contact, dim, value, &answer);
    if (!answer.active) continue;
    MpmContactFaceValue(contacts, sum, contact, du, value);
    for (PetscInt a = 0; a < dim; a++)
      for (PetscInt c = 0; c < dim; c++) force[a] += answer.stiffness[a][c] * value[c];
    MpmContactAddForce(contacts, sum, contact, 1., force, y);
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
    const MpmContact *contact = &contacts->contact[k];
    const MpmGroup   *group   = &sum->space->groups[contact->group];
    const PetscInt   *nodes   = &sum->space->group_nodes[group->node_offset];
    const PetscReal  *weight  = &contacts->weight[contact->weight];
    PetscReal         value[MPM_MAX_DIM];
    MpmContactAnswer  answer;

    if (Body(contacts, contact->boundary)) continue;
    MpmContactFaceValue(contacts, sum, contact, u, value);
    MpmContactEvaluate(contacts, contact, dim, value, &answer);
    for (PetscInt i = 0; answer.active && i < group->node_count; i++)
      for (PetscInt a = 0; a < dim; a++)
        for (PetscInt c = 0; c < dim; c++)
          blocks[(nodes[i] * bs + a) * bs + c] += weight[i] * weight[i] * answer.stiffness[a][c];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* element[i][c][d][j] += w_i K_cd w_j */
static void AddElement(const MpmContacts *contacts, const MpmSum *sum, const MpmContact *contact,
                       const MpmContactAnswer *answer, PetscReal element[])
{
  const PetscInt   n = sum->space->groups[contact->group].node_count, dim = sum->space->dim, bs = sum->block;
  const PetscReal *weight = &contacts->weight[contact->weight];

  for (PetscInt i = 0; i < n; i++)
    for (PetscInt c = 0; c < dim; c++)
      for (PetscInt d = 0; d < dim; d++)
        for (PetscInt j = 0; j < n; j++)
          element[((i * bs + c) * bs + d) * n + j] += weight[i] * answer->stiffness[c][d] * weight[j];
}

static PetscErrorCode Tangent(const void *ctx, const MpmSum *sum, const PetscReal u[], MpmPattern *pattern,
                              PetscReal residual[], PetscInt *failed)
{
  const MpmContacts *contacts = (const MpmContacts *)ctx;
  const MpmSpace    *space    = sum->space;
  const PetscInt     dim = space->dim, bs = sum->block, most = PetscPowInt(space->width, dim);
  PetscReal         *element;
  PetscInt           end;

  PetscFunctionBeginUser;
  if (!contacts->count) PetscFunctionReturn(PETSC_SUCCESS);
  if (residual) PetscCall(Residual(ctx, sum, u, residual, failed));
  PetscCall(PetscMalloc1((most * most * bs * bs), &element));
  for (PetscInt begin = 0; begin < contacts->count; begin = end) { /* contacts of one group stand side by side */
    const MpmGroup *group = &space->groups[contacts->contact[begin].group];
    PetscBool       any   = PETSC_FALSE;

    PetscCall(PetscArrayzero(element, group->node_count * group->node_count * bs * bs));
    for (end = begin; end < contacts->count && contacts->contact[end].group == contacts->contact[begin].group; end++) {
      PetscReal        value[MPM_MAX_DIM];
      MpmContactAnswer answer;

      if (Body(contacts, contacts->contact[end].boundary)) continue;
      MpmContactFaceValue(contacts, sum, &contacts->contact[end], u, value);
      MpmContactEvaluate(contacts, &contacts->contact[end], dim, value, &answer);
      if (!answer.active) continue;
      AddElement(contacts, sum, &contacts->contact[end], &answer, element);
      any = PETSC_TRUE;
    }
    if (any) MpmPatternAddBlock(pattern, space, group, element);
  }
  PetscCall(PetscFree(element));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the converged step ---- */

/* The slip is kept while a point touches. */
static PetscErrorCode KeepSlips(const MpmContacts *contacts, const MpmSum *sum, const MpmContactAnswer answers[],
                                MpmParticles *particles)
{

  PetscFunctionBeginUser;
  for (PetscInt b = 0; b < contacts->boundary_count; b++) {
    for (PetscInt a = 0; contacts->boundaries[b].stick && a < sum->space->dim; a++) {
      PetscReal *slip;

      PetscCall(DMSwarmGetField(particles->swarm, contacts->boundaries[b].slip_field[a], NULL, NULL, (void **)&slip));
      PetscCall(PetscArrayzero(slip, sum->points->count));
      for (PetscInt k = 0; k < contacts->count; k++)
        if (contacts->contact[k].boundary == b) slip[contacts->contact[k].point] = answers[k].slip[a];
      PetscCall(
        DMSwarmRestoreField(particles->swarm, contacts->boundaries[b].slip_field[a], NULL, NULL, (void **)&slip));
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the moment of a force at a place about a point. */
static void AddMoment(PetscInt dim, const PetscReal x[], const PetscReal about[], const PetscReal f[],
                      PetscReal moment[])
{
  PetscReal y[3] = {0., 0., 0.};

  for (PetscInt a = 0; a < dim; a++) y[a] = x[a] - about[a];
  for (PetscInt a = 0; a < 3; a++) moment[a] += y[(a + 1) % 3] * f[(a + 2) % 3] - y[(a + 2) % 3] * f[(a + 1) % 3];
}

/* What a contact says of the converged step; adds to its boundary's reaction, moment and depth. */
static void AddReaction(MpmContacts *contacts, const MpmSum *sum, const MpmContact *contact, const PetscReal u[],
                        MpmContactAnswer *answer)
{
  const PetscInt      dim = sum->space->dim, b = contact->boundary;
  const MpmRigidBody *body = Body(contacts, b);
  PetscReal           value[MPM_MAX_DIM], about[MPM_MAX_DIM], x[MPM_MAX_DIM];
  MpmRigidAnswer      coupled;

  MpmContactFaceValue(contacts, sum, contact, u, value);
  if (body) {
    MpmRigidPlace(body, sum->block, contact, u, value, about, x);
    (void)MpmContactAnswerFree(contacts, sum, contact, u, PETSC_FALSE, answer, &coupled);
  } else {
    MpmBoundaryReference(&contacts->boundaries[b], &contacts->after[b], about);
    for (PetscInt a = 0; a < dim; a++) x[a] = contact->face[a] + value[a];
    MpmContactEvaluate(contacts, contact, dim, value, answer);
  }
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) contacts->reaction[b][a] += answer->force[a];
  AddMoment(dim, x, about, answer->force, contacts->moment[b]);
  contacts->depth[b] = PetscMax(contacts->depth[b], answer->depth);
}

/* Reactions and depths of the converged step; keeps the slips. */
static PetscErrorCode Commit(void *ctx, const MpmSum *sum, const PetscReal u[], MpmParticles *particles)
{
  MpmContacts      *contacts = (MpmContacts *)ctx;
  const MPI_Comm    comm     = sum->grid->comm;
  const PetscMPIInt count    = (PetscMPIInt)contacts->boundary_count;
  MpmContactAnswer *answers;

  PetscFunctionBeginUser;
  if (!count) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(contacts->count, &answers));
  PetscCall(PetscArrayzero(contacts->depth, count));
  PetscCall(PetscArrayzero(contacts->reaction, count));
  PetscCall(PetscArrayzero(contacts->moment, count));
  for (PetscInt k = 0; k < contacts->count; k++) AddReaction(contacts, sum, &contacts->contact[k], u, &answers[k]);
  PetscCall(KeepSlips(contacts, sum, answers, particles));
  PetscCall(PetscFree(answers));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, contacts->reaction, count * MPM_MAX_DIM, MPIU_REAL, MPIU_SUM, comm));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, contacts->moment, count * MPM_MAX_DIM, MPIU_REAL, MPIU_SUM, comm));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, contacts->depth, count, MPIU_REAL, MPIU_MAX, comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

const MpmTerm MpmTermContact = {.name     = "rigid contact",
                                .prepare  = Prepare,
                                .residual = Residual,
                                .tangent  = Tangent,
                                .apply    = Apply,
                                .diagonal = Diagonal,
                                .commit   = Commit};

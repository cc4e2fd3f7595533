/*
  One patch at a rigid surface: its gap and slip, and its tractions (contact_law.c), as rigid_contact.c has them.
*/
#include "particles/points.h"
#include "space/space.h"
#include "space/sum.h"
#include "contact/contact.h"
#include "facets/contact_law.h"
#include "contact/rigid_body.h"
#include "rigid/basal_friction.h"

PetscErrorCode MpmPatchWorkCreate(const MpmContacts *contacts, MpmPatchWork *work)
{
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc3(contacts->most, &work->value, contacts->most, &work->surface, contacts->most, &work->beyond));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPatchWorkDestroy(MpmPatchWork *work)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree3(work->value, work->surface, work->beyond));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MpmFacetValue(const MpmSum *sum, const MpmGroup *box, const PetscReal weight[], const PetscReal u[],
                   PetscReal value[])
{
  const PetscInt *nodes = &sum->space->group_nodes[box->node_offset];

  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) value[a] = 0.;
  for (PetscInt i = 0; i < box->node_count; i++)
    for (PetscInt a = 0; weight[i] != 0. && a < sum->space->dim; a++)
      value[a] += weight[i] * u[nodes[i] * sum->block + a];
}

void MpmPatchValue(const MpmContacts *contacts, const MpmSum *sum, const MpmPatch *patch, PetscInt facet,
                   const PetscReal u[], PetscReal value[])
{
  MpmFacetValue(sum, &sum->space->groups[patch->box], MpmFacetWeights(contacts, facet), u, value);
}

void MpmFacetAddForce(const MpmSum *sum, const MpmGroup *box, const PetscReal weight[], PetscReal factor,
                      const PetscReal force[], PetscReal y[])
{
  const PetscInt *nodes = &sum->space->group_nodes[box->node_offset];

  for (PetscInt i = 0; i < box->node_count; i++)
    for (PetscInt a = 0; weight[i] != 0. && a < sum->space->dim; a++)
      y[nodes[i] * sum->block + a] += factor * weight[i] * force[a];
}

/*
  k'/k of contacts that may slide; less than 1 for the sake of Newton's method. Rolling contact leaves its slip behind
  where contact opens: it creeps by the elastic slip.
*/
#define SLIDING 0.1
#define EQUAL   1.

PetscReal MpmPatchAlong(const MpmContacts *contacts, const MpmPatch *patch)
{
  const PetscBool sticks = MpmContactSticks(contacts->facets.boundaries[patch->boundary].stick, patch->strength);

  return (sticks || patch->round || patch->direct ? EQUAL : SLIDING) / MpmContactsGiving(contacts, patch->boundary);
}

/* Traction of a patch that is kept closed and glides: no more than its pressure changes it. */
static void Glide(const MpmBoundary *boundary, const MpmPatch *patch, PetscReal pressure, MpmPatchAnswer *answer)
{
  answer->slides = PETSC_TRUE;
  for (PetscInt a = 0; a < boundary->dim; a++) {
    answer->traction[a] = (boundary->friction * pressure + boundary->adhesion) * patch->hold.way[a];
    answer->by_gap[a]   = -patch->stiffness * boundary->friction * patch->hold.way[a];
  }
}

/*
  The bound of the traction by a law of the bed: its resistance under the mean pressure of the last steps, times the
  ratio of the present one to it.
*/
static PetscReal BasalBound(const MpmContacts *contacts, const MpmPatch *patch, const MpmContactLaw *law,
                            PetscReal pressure, const PetscReal slip[])
{
  const MpmBoundary *boundary = &contacts->facets.boundaries[patch->boundary];
  const PetscReal    upright  = contacts->facets.at[patch->begin].normal[boundary->dim - 1];
  const PetscReal    mean = patch->mean > 0. ? patch->mean : pressure, ratio = mean > 0. ? pressure / mean : 0.;
  PetscReal          size = 0.;

  if (!(ratio > 0.)) return 0.;
  for (PetscInt a = 0; a < boundary->dim; a++) size += PetscSqr(slip[a]);
  return ratio * MpmBasalFriction(boundary, mean, PetscAbsReal(upright), PetscSqrtReal(size),
                                  law->along * law->stiffness / ratio, contacts->dt);
}

/* The traction along the surface that goes with the mean slip, and its derivatives. */
static void Friction(const MpmContacts *contacts, const MpmPatch *patch, MpmPatchAnswer *answer)
{
  const MpmBoundary *boundary = &contacts->facets.boundaries[patch->boundary];
  const PetscReal    adhesion = patch->hold.on ? PETSC_INFINITY : boundary->adhesion;
  const PetscReal    strength = patch->hold.on ? PETSC_INFINITY : patch->strength;
  MpmContactLaw      law      = {.stiffness = patch->stiffness,
                                 .along     = MpmPatchAlong(contacts, patch),
                                 .friction  = boundary->friction,
                                 .adhesion  = adhesion,
                                 .strength  = strength,
                                 .stick     = boundary->stick,
                                 .parts     = (PetscBool)((!boundary->bilateral || patch->broken) && !patch->hold.on),
                                 .secant    = contacts->newton.secant,
                                 .least     = contacts->newton.least};
  const PetscReal    pressure = -patch->stiffness * answer->gap;
  MpmContactFriction friction;

  if (boundary->basal) law.adhesion = BasalBound(contacts, patch, &law, pressure, answer->slip);
  if (patch->hold.on && patch->hold.glides) {
    Glide(boundary, patch, pressure, answer);
    return;
  }
  answer->slides = MpmContactSlide(&law, boundary->dim, pressure, answer->slip, &friction);
  for (PetscInt a = 0; a < boundary->dim; a++) {
    answer->traction[a] = friction.traction[a];
    answer->by_gap[a]   = -patch->stiffness * friction.by_pressure[a];
    for (PetscInt c = 0; c < boundary->dim; c++) answer->by_slip[a][c] = friction.by_slip[a][c];
  }
}

/* Takes the displacement of a boundary's own place off that of the material there. */
static void Relative(const MpmPose *before, const MpmPose *after, PetscInt dim, const PetscReal place[],
                     const PetscReal value[], PetscReal relative[])
{
  PetscReal carried[MPM_MAX_DIM];

  if (before->turned || after->turned) {
    MpmPoseCarry(dim, before, after, place, carried);
    for (PetscInt a = 0; a < dim; a++) relative[a] = value[a] - (carried[a] - place[a]);
  } else {
    for (PetscInt a = 0; a < dim; a++) relative[a] = value[a] - (after->translation[a] - before->translation[a]);
  }
}

/* Distance of a facet beyond the tilt of a patch. */
static PetscReal Beyond(const MpmContacts *contacts, PetscBool holds, PetscReal gap)
{
  if (gap < -contacts->tilt) return gap + contacts->tilt;
  return holds && gap > contacts->tilt ? gap - contacts->tilt : 0.;
}

/*
  Distances at the step's end. A flat face stays the one that a facet met at the step's start, as a plane that moves
  with the boundary. Another may be nearer to Newton's iterates, deep inside, and to material squeezed out at edges.
*/
static void Distances(const MpmContacts *contacts, const MpmPatch *patch, MpmPatchWork *work)
{
  const MpmBoundary *boundary = &contacts->facets.boundaries[patch->boundary];
  const MpmPose *before = &contacts->facets.before[patch->boundary], *after = &contacts->facets.after[patch->boundary];
  const PetscInt dim = boundary->dim;

  for (PetscInt f = patch->begin; f < patch->end; f++) {
    const MpmFacet *facet           = &contacts->facets.at[f];
    MpmSurface     *surface         = &work->surface[f - patch->begin];
    PetscReal       at[MPM_MAX_DIM] = {0., 0., 0.}, foot[MPM_MAX_DIM];

    for (PetscInt a = 0; a < dim; a++) at[a] = facet->place[a] + work->value[f - patch->begin][a];
    if (!facet->key.side && !facet->key.flows) {
      MpmBoundaryDistance(boundary, after, at, surface);
      continue;
    }
    *surface = (MpmSurface){.distance = 0.};
    for (PetscInt a = 0; a < dim; a++) foot[a] = facet->place[a] - facet->distance * facet->normal[a];
    MpmPoseCarry(dim, before, after, foot, foot);
    MpmPoseTurn(dim, before, after, facet->normal, surface->normal);
    for (PetscInt a = 0; a < dim; a++) surface->distance += (at[a] - foot[a]) * surface->normal[a];
  }
}

/* The slip at work->value: the mean of the facets. */
static void Slip(const MpmContacts *contacts, const MpmPatch *patch, PetscInt dim, const MpmPatchWork *work,
                 PetscReal slip[])
{
  for (PetscInt a = 0; a < dim; a++) slip[a] = 0.;
  for (PetscInt f = patch->begin; f < patch->end; f++) {
    const MpmFacet *facet = &contacts->facets.at[f];
    PetscReal       way[MPM_MAX_DIM];

    Relative(&contacts->facets.before[patch->boundary], &contacts->facets.after[patch->boundary], dim, facet->place,
             work->value[f - patch->begin], way);
    MpmContactAcross(dim, facet->normal, way);
    for (PetscInt a = 0; a < dim; a++) slip[a] += facet->area / patch->area * (facet->slip[a] + way[a]);
  }
}

void MpmPatchEvaluate(const MpmContacts *contacts, const MpmPatch *patch, MpmPatchWork *work, MpmPatchAnswer *answer)
{
  const MpmBoundary *boundary = &contacts->facets.boundaries[patch->boundary];
  const PetscInt     dim      = boundary->dim;

  const PetscBool holds = (PetscBool)(boundary->bilateral && !patch->broken);

  *answer = (MpmPatchAnswer){.active = holds};
  Distances(contacts, patch, work);
  for (PetscInt f = patch->begin; f < patch->end; f++) {
    const MpmFacet *facet   = &contacts->facets.at[f];
    MpmSurface     *surface = &work->surface[f - patch->begin];
    const PetscReal share   = facet->area / patch->area;
    PetscReal      *value   = work->value[f - patch->begin], at[MPM_MAX_DIM];

    for (PetscInt a = 0; a < dim; a++) at[a] = facet->place[a] + value[a];
    /* rounding of the place counts where a body's balance depends on its depth */

    for (PetscInt a = 0; a < dim && MpmFacetsBody(&contacts->facets, patch->boundary); a++)
      surface->distance += surface->normal[a] * (value[a] - (at[a] - facet->place[a]));
    work->beyond[f - patch->begin] =
      MpmPatchFlows(contacts, patch) ? 0. : Beyond(contacts, holds, surface->distance - facet->touches - facet->turn);
    if (work->beyond[f - patch->begin] != 0.) answer->any = PETSC_TRUE;
    answer->gap += share * (surface->distance - facet->touches - facet->turn);
  }
  answer->gap -= patch->shift;
  if (MpmPatchFlows(contacts, patch)) answer->active = MpmFlowGap(contacts, patch, &answer->gap);
  else if (!holds) answer->active = (PetscBool)(patch->hold.on || answer->gap <= contacts->facets.touch);
  if (!answer->active) {
    answer->gap = 0.;
    return;
  }
  answer->any       = PETSC_TRUE;
  answer->stiffness = patch->stiffness;
  if (!boundary->tangential) return;
  Slip(contacts, patch, dim, work, answer->slip);
  Friction(contacts, patch, answer);
}

/* The facets' displacements. */
static void Values(const MpmContacts *contacts, const MpmPatch *patch, const MpmSum *sum, const PetscReal u[],
                   MpmPatchWork *work)
{
  for (PetscInt f = patch->begin; f < patch->end; f++)
    MpmPatchValue(contacts, sum, patch, f, u, work->value[f - patch->begin]);
}

void MpmPatchEvaluateAt(const MpmContacts *contacts, const MpmPatch *patch, const MpmSum *sum, const PetscReal u[],
                        MpmPatchWork *work, MpmPatchAnswer *answer)
{
  Values(contacts, patch, sum, u, work);
  MpmPatchEvaluate(contacts, patch, work, answer);
}

/* The force is along the axes. */
static void TurnPrescribed(const MpmContacts *contacts, const MpmPatch *patch, PetscInt f, const MpmSum *sum,
                           const PetscReal u[], PetscReal force[3], PetscReal arm[3])
{
  PetscReal value[MPM_MAX_DIM], about[MPM_MAX_DIM];

  (void)force;
  MpmPatchValue(contacts, sum, patch, f, u, value);
  MpmBoundaryReference(&contacts->facets.boundaries[patch->boundary], &contacts->facets.after[patch->boundary], about);
  for (PetscInt a = 0; a < sum->space->dim; a++) arm[a] = contacts->facets.at[f].place[a] + value[a] - about[a];
}

static void KeepPrescribed(const MpmContacts *contacts, const MpmPatch *patch, const MpmSum *sum, const PetscReal u[],
                           PetscReal slip[])
{
  const PetscInt b = patch->boundary;

  (void)u;
  MpmPoseTurn(sum->space->dim, &contacts->facets.before[b], &contacts->facets.after[b], slip, slip);
}

const MpmContactFrame MpmFramePrescribed = {MpmPatchEvaluateAt, TurnPrescribed, KeepPrescribed};

void MpmPatchKeepSlip(const MpmContacts *contacts, const MpmPatch *patch, const MpmSum *sum, const PetscReal u[],
                      MpmPatchWork *work, MpmPatchAnswer *answer)
{
  const PetscInt dim    = sum->space->dim;
  PetscReal      square = 0., most = 0.;

  if (!answer->active || !contacts->facets.boundaries[patch->boundary].tangential) return;
  for (PetscInt a = 0; a < dim; a++) most += PetscSqr(answer->slip[a]);
  Values(contacts, patch, sum, u, work);
  Slip(contacts, patch, dim, work, answer->slip);
  for (PetscInt a = 0; a < dim; a++) square += PetscSqr(answer->slip[a]);
  if (!answer->slides || square <= most) return;
  for (PetscInt a = 0; a < dim; a++) answer->slip[a] *= PetscSqrtReal(most / square);
}

void MpmFacetForce(const MpmContacts *contacts, const MpmPatch *patch, PetscInt f, const MpmPatchWork *work,
                   const MpmPatchAnswer *answer, PetscReal force[])
{
  const MpmFacet *facet  = &contacts->facets.at[f];
  const PetscReal normal = answer->stiffness * answer->gap + patch->stiffness * work->beyond[f - patch->begin];
  const PetscInt  dim    = contacts->facets.boundaries[patch->boundary].dim;

  for (PetscInt a = 0; a < dim; a++) force[a] = answer->traction[a];
  MpmContactAcross(dim, facet->normal, force);
  for (PetscInt a = 0; a < dim; a++)
    force[a] = -facet->area * (force[a] + normal * work->surface[f - patch->begin].normal[a]);
}

PetscReal MpmFacetStiffness(const MpmContacts *contacts, const MpmPatch *patch, PetscInt f, const MpmPatchWork *work,
                            const MpmPatchAnswer *answer, PetscInt c, PetscInt d)
{
  const MpmSurface *surface = &work->surface[f - patch->begin];
  const PetscReal   beyond  = work->beyond[f - patch->begin];
  PetscReal         value   = (answer->stiffness * answer->gap + patch->stiffness * beyond) * surface->second[c][d];

  if (beyond != 0.) value += patch->stiffness * surface->normal[c] * surface->normal[d];
  return contacts->facets.at[f].area * value;
}

/*
  Contact in explicit steps: a penalty stays stable only while it cannot reverse the motion that it stops.

  A patch has the mean displacement of its facets, sum_i w_i u_i, with the mass 1/sum_i w_i^2/m_i. With the force k A g
  at the gap g at the step's end without it, k A <= m/dt^2 brings the gap to zero at most. Each node of a surface is
  shared by 2^(dim - 1) patches, whose forces add up: each gets its share. Facets on round surfaces are patches by
  themselves, many in a cell, with a cell's area together.
*/

/* The inverse of the mass that the patch moves, 1/kg; nodes without mass do not count. */
static PetscReal InverseMass(const MpmContacts *contacts, const MpmSum *sum, const MpmPatch *patch,
                             const PetscReal mass[])
{
  const MpmGroup *box   = &sum->space->groups[patch->box];
  const PetscInt *nodes = &sum->space->group_nodes[box->node_offset];
  PetscReal       total = 0.;

  for (PetscInt i = 0; i < box->node_count; i++) {
    PetscReal w = 0.;

    if (nodes[i] < 0) continue;
    for (PetscInt f = patch->begin; f < patch->end; f++)
      w += contacts->facets.at[f].area / patch->area * MpmFacetWeights(contacts, f)[i];
    if (w != 0. && mass[nodes[i]] > 0.) total += w * w / mass[nodes[i]];
  }
  return total;
}

/* Pressure that acts at no displacement in explicit steps: of a geostatic state, or of the last correction. */
static PetscReal Borne(const MpmContacts *contacts, const MpmPatch *patch)
{
  const MpmBoundary *boundary = &contacts->facets.boundaries[patch->boundary];

  if (boundary->augmented) return patch->mean;
  return boundary->fields.rest ? patch->rest : 0.;
}

PetscErrorCode MpmContactsBear(const void *ctx, const MpmSum *sum, PetscReal residual[])
{
  const MpmContacts *contacts = (const MpmContacts *)ctx;
  const PetscInt     dim      = sum->space->dim;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < contacts->patch_count; k++) {
    const MpmPatch *patch = &contacts->patch[k];
    MpmPatchAnswer  answer;

    const PetscReal pressure = Borne(contacts, patch);

    if (pressure == 0.) continue;
    answer = (MpmPatchAnswer){.gap = -pressure / patch->stiffness};
    for (PetscInt f = patch->begin; f < patch->end; f++)
      for (PetscInt a = 0; a < dim; a++)
        answer.slip[a] += contacts->facets.at[f].area / patch->area * contacts->facets.at[f].slip[a];
    if (contacts->facets.boundaries[patch->boundary].tangential) Friction(contacts, patch, &answer);
    for (PetscInt f = patch->begin; f < patch->end; f++) {
      const MpmFacet *facet = &contacts->facets.at[f];
      PetscReal       force[MPM_MAX_DIM];

      if (facet->point < 0) continue;
      for (PetscInt a = 0; a < dim; a++) force[a] = answer.traction[a];
      MpmContactAcross(dim, facet->normal, force);
      for (PetscInt a = 0; a < dim; a++) force[a] = facet->area * (force[a] - pressure * facet->normal[a]);
      MpmFacetAddForce(sum, &sum->space->groups[patch->box], MpmFacetWeights(contacts, f), 1., force, residual);
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* In explicit steps a borne pressure acts at no displacement, as does the traction of its slip. */
static void BeginAtRest(MpmContacts *contacts, MpmPatch *patch, PetscReal along)
{
  patch->shift = Borne(contacts, patch) / patch->stiffness;
  patch->slips = along / (MpmPatchAlong(contacts, patch) * patch->stiffness);
  for (PetscInt f = patch->begin; f < patch->end; f++)
    for (PetscInt a = 0; a < MPM_MAX_DIM; a++) contacts->facets.at[f].slip[a] *= patch->slips;
}

PetscErrorCode MpmContactsLimit(void *ctx, const MpmSum *sum, const PetscReal mass[], PetscReal dt)
{
  MpmContacts    *contacts = (MpmContacts *)ctx;
  const PetscReal share    = PetscPowRealInt(0.5, sum->space->dim - 1);

  PetscFunctionBeginUser;
  contacts->dt = sum->step.dt;
  PetscCall(MpmFlowLimit(contacts, sum, mass, dt));
  for (PetscInt k = 0; k < contacts->patch_count; k++) {
    MpmPatch       *patch   = &contacts->patch[k];
    const PetscReal inverse = InverseMass(contacts, sum, patch, mass);
    const PetscReal area    = patch->round || contacts->facets.at[patch->begin].key.single
                                ? PetscPowRealInt(contacts->facets.cell, sum->space->dim - 1) *
                                 MpmTurn(sum->points->F_size, contacts->facets.at[patch->begin].place[0])
                                : patch->area;

    const PetscReal along = MpmPatchAlong(contacts, patch) * patch->stiffness;

    if (MpmPatchFlows(contacts, patch) || !(area > 0.) || !(inverse > 0.)) continue;
    patch->direct    = PETSC_TRUE;
    patch->stiffness = PetscMin(patch->stiffness, share / (inverse * dt * dt * area));
    if (Borne(contacts, patch) != 0.) BeginAtRest(contacts, patch, along);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  One patch of contact with a rigid body of unknown place: forces on material and body, and their derivatives.

  A facet's displacement is turned into the frame of the body, where the law of a patch is that at a fixed surface
  (contact_patch.c); forces and stiffnesses are turned back.
*/
#include "space/space.h"
#include "space/sum.h"
#include "contact/contact.h"
#include "contact/rigid_body.h"

PetscErrorCode MpmRigidWorkCreate(const MpmContacts *contacts, const MpmSum *sum, MpmRigidWork *work)
{
  PetscInt most = 0;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; sum && k < contacts->patch_count; k++)
    most = PetscMax(most, sum->space->groups[contacts->patch[k].box].node_count);
  PetscCall(MpmPatchWorkCreate(contacts, &work->law));
  PetscCall(PetscMalloc3(contacts->most, &work->u, (12 * (most + 2)), &work->left, (12 * (most + 2)), &work->right));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmRigidWorkDestroy(MpmRigidWork *work)
{
  PetscFunctionBeginUser;
  PetscCall(MpmPatchWorkDestroy(&work->law));
  PetscCall(PetscFree3(work->u, work->left, work->right));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MpmRigidPatch(const MpmContacts *contacts, const MpmPatch *patch, const MpmRigidIncrement *q, MpmRigidWork *work)
{
  const MpmRigidBody *body = &contacts->facets.bodies[patch->boundary];

  for (PetscInt f = patch->begin; f < patch->end; f++)
    MpmRigidSee(body, &contacts->facets.at[f], q, work->u[f - patch->begin], work->law.value[f - patch->begin]);
  MpmPatchEvaluate(contacts, patch, &work->law, &work->answer);
}

void MpmRigidFacet(const MpmContacts *contacts, const MpmPatch *patch, PetscInt f, const MpmRigidIncrement *q,
                   const MpmRigidWork *work, PetscBool derivative, MpmRigidAnswer *coupled)
{
  const MpmRigidBody *body = &contacts->facets.bodies[patch->boundary];
  MpmFacetLaw         law  = {.force = {0.}};

  MpmFacetForce(contacts, patch, f, &work->law, &work->answer, law.force);
  for (PetscInt c = 0; derivative && c < body->dim; c++)
    for (PetscInt d = 0; d < body->dim; d++)
      law.stiffness[c][d] = MpmFacetStiffness(contacts, patch, f, &work->law, &work->answer, c, d);
  MpmRigidTurn(body, q, &law);
  MpmRigidCouple(body, &contacts->facets.at[f], q, work->u[f - patch->begin], &law, derivative, coupled);
}

/* A body at an increment, and its axes. */
typedef struct {
  const MpmRigidBody      *body;
  const MpmRigidIncrement *q;
  PetscReal                A[3][3];
  PetscBool                rows; /* of the balanced moment */
} Frame;

/* Adds `share` of a covector, in the body's frame, of a facet at the arm y: to its nodes and to the body. */
static void AddCovector(const Frame *frame, const PetscReal y[3], const PetscReal covector[3], PetscReal share,
                        const PetscReal weight[], PetscInt n, PetscReal vector[])
{
  PetscReal c[3], by[2][3];

  for (PetscInt a = 0; a < 3; a++)
    c[a] = frame->A[a][0] * covector[0] + frame->A[a][1] * covector[1] + frame->A[a][2] * covector[2];
  MpmRigidCovector(frame->body, frame->q, y, c, frame->rows, by);
  for (PetscInt i = 0; i < n; i++)
    for (PetscInt a = 0; weight[i] != 0. && a < frame->body->dim; a++) vector[3 * i + a] += share * weight[i] * c[a];
  for (PetscInt k = 0; k < 6; k++) vector[3 * n + k] += share * by[k / 3][k % 3];
}

/* The covectors of a patch's mean gap and of its mean slips, each of 3 (n + 2) numbers. */
static void FillCovectors(const MpmContacts *contacts, const MpmPatch *patch, const Frame *frame, PetscInt n,
                          const MpmRigidWork *work, PetscReal vector[])
{
  const PetscInt dim = frame->body->dim, size = 3 * (n + 2);
  const PetscInt slips = contacts->facets.boundaries[patch->boundary].tangential ? dim : 0;

  for (PetscInt k = 0; k < 4 * size; k++) vector[k] = 0.;
  for (PetscInt f = patch->begin; f < patch->end; f++) {
    const MpmFacet  *facet  = &contacts->facets.at[f];
    const PetscReal *weight = n ? MpmFacetWeights(contacts, f) : NULL, share = facet->area / patch->area;
    PetscReal        y[3];

    MpmRigidArmAfter(frame->body, facet, frame->q, work->u[f - patch->begin], y);
    AddCovector(frame, y, work->law.surface[f - patch->begin].normal, share, weight, n, vector);
    for (PetscInt e = 0; e < slips; e++) {
      PetscReal along[3] = {0., 0., 0.};

      for (PetscInt a = 0; a < dim; a++) along[a] = (e == a ? 1. : 0.) - facet->normal[e] * facet->normal[a];
      AddCovector(frame, y, along, share, weight, n, &vector[(1 + e) * size]);
    }
  }
}

void MpmRigidMean(const MpmContacts *contacts, const MpmPatch *patch, const MpmRigidIncrement *q, PetscInt n,
                  MpmRigidWork *work)
{
  const MpmRigidBody   *body   = &contacts->facets.bodies[patch->boundary];
  const MpmPatchAnswer *answer = &work->answer;
  const PetscInt        dim = body->dim, size = 3 * (n + 2);
  const PetscInt        slips = contacts->facets.boundaries[patch->boundary].tangential ? dim : 0;
  Frame                 frame = {.body = body, .q = q};

  MpmRigidAxes(body, q, frame.A);
  FillCovectors(contacts, patch, &frame, n, work, work->left);
  for (PetscInt k = 0; k < 4 * size; k++) work->right[k] = 0.;
  for (PetscInt k = 0; k < size; k++) {
    work->right[k] = patch->area * answer->stiffness * work->left[k];
    for (PetscInt e = 0; e < slips; e++) {
      PetscReal value = answer->by_gap[e] * work->left[k];

      for (PetscInt c = 0; c < dim; c++) value += answer->by_slip[e][c] * work->left[(1 + c) * size + k];
      work->right[(1 + e) * size + k] = patch->area * value;
    }
  }
  if (!MpmFreedomTurnsInPart(body->freedom)) return;
  frame.rows = PETSC_TRUE;
  FillCovectors(contacts, patch, &frame, n, work, work->left);
}

static void EvaluateSolved(const MpmContacts *contacts, const MpmPatch *patch, const MpmSum *sum, const PetscReal u[],
                           MpmPatchWork *work, MpmPatchAnswer *answer)
{
  const MpmRigidBody *body = &contacts->facets.bodies[patch->boundary];
  MpmRigidIncrement   q;

  MpmRigidIncrementAt(body, sum->block, u, &q);
  for (PetscInt f = patch->begin; f < patch->end; f++) {
    PetscReal value[MPM_MAX_DIM];

    MpmPatchValue(contacts, sum, patch, f, u, value);
    MpmRigidSee(body, &contacts->facets.at[f], &q, value, work->value[f - patch->begin]);
  }
  MpmPatchEvaluate(contacts, patch, work, answer);
}

/* v = A v */
static void TurnVector(const MpmRigidBody *body, const MpmRigidIncrement *q, PetscReal v[])
{
  PetscReal A[3][3], from[3] = {0., 0., 0.};

  MpmRigidAxes(body, q, A);
  for (PetscInt a = 0; a < body->dim; a++) from[a] = v[a];
  for (PetscInt a = 0; a < body->dim; a++) v[a] = A[a][0] * from[0] + A[a][1] * from[1] + A[a][2] * from[2];
}

static void TurnSolved(const MpmContacts *contacts, const MpmPatch *patch, PetscInt f, const MpmSum *sum,
                       const PetscReal u[], PetscReal force[3], PetscReal arm[3])
{
  const MpmRigidBody *body = &contacts->facets.bodies[patch->boundary];
  PetscReal           value[MPM_MAX_DIM];
  MpmRigidIncrement   q;

  MpmRigidIncrementAt(body, sum->block, u, &q);
  MpmPatchValue(contacts, sum, patch, f, u, value);
  MpmRigidArmAfter(body, &contacts->facets.at[f], &q, value, arm);
  TurnVector(body, &q, force);
}

/* By the prescribed motion, and by that which is solved for. */
static void KeepSolved(const MpmContacts *contacts, const MpmPatch *patch, const MpmSum *sum, const PetscReal u[],
                       PetscReal slip[])
{
  const MpmRigidBody *body = &contacts->facets.bodies[patch->boundary];
  MpmRigidIncrement   q;

  MpmFramePrescribed.keep(contacts, patch, sum, u, slip);
  MpmRigidIncrementAt(body, sum->block, u, &q);
  TurnVector(body, &q, slip);
}

const MpmContactFrame MpmFrameSolved = {EvaluateSolved, TurnSolved, KeepSolved};

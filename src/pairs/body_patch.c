/*
  One patch between two bodies: its mean relative displacement, and the conjugate force (contact_law.c), with the
  equations of body_contact.c.
*/
#include "space/space.h"
#include "space/sum.h"
#include "pairs/body_contact.h"
#include "pairs/body_patch.h"
#include "facets/contact_law.h"

/* k'/k of contacts that may slide: both sides yield, and many patches change from sticking to sliding at once */
#define SLIDING 0.02

/* Pressure and its fall with the gap. */
static void Pressure(const MpmPairContacts *contacts, const MpmPairPatch *patch, const MpmContactLaw *law,
                     MpmPairAnswer *answer, PetscReal *rate)
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

/* Adds the traction along the surface, its derivative, and the slip to be kept. */
static void Friction(const MpmPairPatch *patch, const MpmContactLaw *law, PetscInt dim, PetscReal rate,
                     MpmPairAnswer *answer)
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

PetscReal MpmPairGiving(const MpmPairContacts *contacts, const MpmPairPatch *patch)
{
  return contacts->pairs->at[patch->pair].stick ? 1. : contacts->newton.give;
}

PetscReal MpmPairAlong(const MpmPairContacts *contacts, const MpmPairPatch *patch)
{
  const PetscBool sticks = MpmContactSticks(contacts->pairs->at[patch->pair].stick, patch->strength);

  return (sticks || patch->direct ? 1. : SLIDING) / MpmPairGiving(contacts, patch);
}

void MpmPairRestForce(const MpmPairContacts *contacts, const MpmPairPatch *patch, PetscInt dim, PetscReal force[])
{
  const PetscReal area = patch->side[0].area, along = MpmPairAlong(contacts, patch) * patch->stiffness;

  for (PetscInt a = 0; a < dim; a++)
    force[a] = patch->rest > 0. ? -area * (patch->rest * patch->normal[a] + along * patch->slip[a]) : 0.;
}

void MpmPairEvaluate(const MpmPairContacts *contacts, const MpmPairPatch *patch, PetscInt dim, const PetscReal w[],
                     MpmPairAnswer *answer)
{
  const MpmPair      *pair = &contacts->pairs->at[patch->pair];
  const MpmContactLaw law  = {.stiffness = patch->stiffness,
                              .along     = MpmPairAlong(contacts, patch),
                              .friction  = pair->friction,
                              .adhesion  = pair->adhesion,
                              .strength  = patch->strength,
                              .stick     = pair->stick,
                              .parts     = PETSC_TRUE,
                              .least     = contacts->newton.least};
  const PetscReal    *n = patch->normal, area = patch->side[0].area;
  PetscReal           along = 0., rate;

  for (PetscInt a = 0; a < dim; a++) along += n[a] * w[a];
  *answer = (MpmPairAnswer){.gap = patch->gap - patch->touches - patch->shift - along};
  Pressure(contacts, patch, &law, answer, &rate);
  if (!answer->active) return;
  for (PetscInt a = 0; a < dim; a++) {
    answer->force[a] = -area * answer->pressure * n[a];
    for (PetscInt c = 0; c < dim; c++) answer->stiffness[a][c] = area * rate * n[a] * n[c];
    if (pair->tangential) answer->slip[a] = patch->slip[a] + w[a] - along * n[a];
  }
  if (pair->tangential) Friction(patch, &law, dim, rate, answer);
}

/* Adds the contribution of a side's turning to the mean displacement. */
static void AddTurning(const MpmPairContacts *contacts, const MpmPairPatch *patch, PetscInt s, const MpmSum *sum,
                       const PetscReal u[], PetscReal w[])
{
  const MpmGroup  *box       = &sum->space->groups[patch->side[s].box];
  const PetscInt  *nodes     = &sum->space->group_nodes[box->node_offset];
  const PetscReal *weight    = &contacts->weights.at[patch->side[s].weight];
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

void MpmPairRelative(const MpmPairContacts *contacts, const MpmPairPatch *patch, const MpmSum *sum, const PetscReal u[],
                     PetscReal w[])
{
  for (PetscInt a = 0; a < MPM_PAIR_ROWS; a++) w[a] = 0.;
  for (PetscInt s = 0; s < 2; s++) {
    const MpmGroup  *box    = &sum->space->groups[patch->side[s].box];
    const PetscInt  *nodes  = &sum->space->group_nodes[box->node_offset];
    const PetscReal *weight = &contacts->weights.at[patch->side[s].weight], sign = s ? -1. : 1.;

    for (PetscInt i = 0; i < box->node_count; i++)
      for (PetscInt a = 0; weight[i] != 0. && a < MPM_PAIR_ROWS; a++)
        if (MpmPairActs(patch, sum->space->dim, a))
          w[a] += sign * weight[i] * u[nodes[i] * sum->block + MpmPairComponent(contacts, a)];
    if (patch->direct) AddTurning(contacts, patch, s, sum, u, w);
  }
}

/*
  The signature of a step: a number of its discrete decisions, equal for steps that took the same ones on any ranks. A
  sum over points and nodes of scrambled words (Steele, Lea and Flood 2014, doi:10.1145/2660193.2660195): nodes that a
  point touches, the cell of its mean, whether contact keeps numbers of it; nodes that follow others, conditions that
  hold a node, and faces of penalties.
*/
#include "base/columns.h"
#include "options/options.h"
#include "particles/particles.h"
#include "particles/points.h"
#include "space/space.h"
#include "bc/bc.h"
#include "observe/history.h"
#include "observe/results.h"

#define BITS 53 /* of a column's numbers */

static uint64_t Scramble(uint64_t word)
{
  word += 0x9e3779b97f4a7c15u;
  word = (word ^ (word >> 30)) * 0xbf58476d1ce4e5b9u;
  word = (word ^ (word >> 27)) * 0x94d049bb133111ebu;
  return word ^ (word >> 31);
}

static uint64_t Join(uint64_t word, PetscInt count, const PetscInt numbers[])
{
  for (PetscInt k = 0; k < count; k++) word = Scramble(word ^ (uint64_t)numbers[k]);
  return word;
}

/* Points: their nodes, and their cell, or all that their domains lie in. */
static uint64_t SumPoints(const MpmSpace *space, const MpmPoints *points)
{
  const MpmSpread *spread = space->cells.spread;
  const PetscInt   dim    = space->dim;
  uint64_t         sum    = 0;

  for (PetscInt g = 0; g < space->group_count; g++) {
    const MpmGroup *group = &space->groups[g];
    uint64_t        word  = 0;

    if (group->point_begin == group->point_end) continue;
    word = Join(Join(word, space->dim, group->first), space->dim, group->count);
    if (space->cells.count) word = Join(word, space->dim, space->groups[space->cells.at[group->cell].box].first);
    for (PetscInt s = group->point_begin; s < group->point_end; s++) {
      const PetscInt p = space->order[s];
      const uint64_t here =
        spread ? Join(Join(word, dim, &spread->first[p * dim]), dim, &spread->count[p * dim]) : word;

      sum += Scramble(here ^ Scramble((uint64_t)points->id[p]));
    }
  }
  return sum;
}

/* Points whose numbers of contact are not zero: those that touch. */
static PetscErrorCode SumContact(MpmParticles *particles, const MpmPoints *points, uint64_t *sum)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < particles->field_count; k++) {
    const MpmPointField *field = &particles->fields[k];
    PetscBool            contact;
    PetscReal           *value;

    PetscCall(PetscStrbeginswith(field->name, "contact", &contact));
    if (!contact || field->integer) continue;
    PetscCall(MpmParticlesGetField(particles, field->name, &value));
    for (PetscInt p = 0; p < points->count; p++)
      for (PetscInt c = 0; c < field->components; c++)
        if (value[p * field->components + c] != 0.)
          *sum += Scramble(Join((uint64_t)k + 1, 1, &c) ^ Scramble((uint64_t)points->id[p]));
    PetscCall(MpmParticlesRestoreField(particles, &value));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Owned nodes: what holds their unknowns; and this rank's faces. */
static uint64_t SumNodes(const MpmDiscretization *disc)
{
  const MpmSpace       *space       = disc->space;
  const MpmConstraints *constraints = disc->constraints;
  uint64_t              sum         = 0;

  for (PetscInt n = 0; n < space->owned; n++) {
    uint64_t word = Join(0, space->dim, &space->node[n * space->dim]);

    if (MpmSpaceIsExtra(space, n)) continue;
    for (PetscInt c = 0; c < disc->block; c++) word = Join(word, 1, &constraints->condition[n * disc->block + c]);
    sum += Scramble(word);
  }
  for (PetscInt f = space->boxes.faces.begin; f < space->boxes.faces.begin + space->boxes.faces.count; f++) {
    const MpmGroup *face = &space->groups[f];

    sum += Scramble(Join(Join(1, space->dim, face->first), space->dim, face->count));
  }
  return sum;
}

PetscErrorCode MpmSignatureFind(MpmModel model, PetscReal *signature)
{
  uint64_t sum = 0;

  PetscFunctionBeginUser;
  *signature = 0.;
  if (!model->disc.nodal.committed) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmParticlesLendArrays(model->state.particles, model->disc.points));
  sum = SumPoints(model->disc.space, model->disc.points) + SumNodes(&model->disc);
  PetscCall(SumContact(model->state.particles, model->disc.points, &sum));
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, model->disc.points));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_UINT64_T, MPI_SUM, model->comm));
  *signature = (PetscReal)(sum >> (64 - BITS));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Fill(MpmModel model, const MpmColumn *column, PetscReal values[])
{
  PetscFunctionBeginUser;
  (void)column;
  PetscCall(MpmSignatureFind(model, values));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSignatureAddColumns(MpmModel model, MpmColumns *columns)
{
  PetscFunctionBeginUser;
  if (model->results->signature)
    PetscCall(MpmColumnsAdd(columns, NULL, &(MpmColumn){.name = "signature", .unit = "-", .fill = Fill}));
  PetscFunctionReturn(PETSC_SUCCESS);
}

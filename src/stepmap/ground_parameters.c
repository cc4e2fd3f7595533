/*
  Fields of the scene as parameters. A point's number depends on the field's values by the place where it began: the
  derivative by that number, which the points' sums have, is scattered to the values.
*/
#include "point/layout.h"
#include "point/material.h"
#include "point/variation.h"
#include "particles/body.h"
#include "particles/points.h"
#include "query/model.h"
#include "query/query.h"
#include "volume/volume.h"
#include "stepmap/ground_parameters.h"

/* The places of the law's table that have the field's values; -1: one of the physics. */
static PetscErrorCode FindPlaces(const MpmMaterial *material, MpmFieldParameter *parameter, PetscBool *physics)
{
  const MpmVariations *varies = material->varies;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(varies->count, &parameter->place));
  for (PetscInt v = 0; v < varies->count; v++) {
    if (varies->at[v].ground != parameter->ground) continue;
    if (varies->at[v].place < (PetscInt)material->info.parameter_count)
      parameter->place[parameter->place_count++] = varies->at[v].place;
    else *physics = PETSC_TRUE;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmFieldParameterAdd(const MpmMaterials *materials, const char name[], const char *block,
                                    MpmFieldParameters *grounds)
{
  const MpmGrounds  *fields = materials->grounds;
  MpmFieldParameter *parameter;
  PetscInt           f       = 0;
  PetscBool          physics = PETSC_FALSE;

  PetscFunctionBeginUser;
  while (fields && f < fields->count && strcmp(fields->names[f], name)) f++;
  MpmCheckInput(fields && f < fields->count, "-mpm_parameters: there is no field %s in -mpm_fields", name);
  for (PetscInt k = 0; k < grounds->count; k++)
    MpmCheckInput(grounds->at[k].ground != &fields->at[f], "-mpm_parameters: field %s is there twice", name);
  PetscCall(PetscRealloc((size_t)(grounds->count + 1) * sizeof(*grounds->at), &grounds->at));
  parameter = &grounds->at[grounds->count++];
  PetscCall(PetscMemzero(parameter, sizeof(*parameter)));
  parameter->ground = &fields->at[f];
  parameter->first  = grounds->values;
  PetscCall(PetscStrallocpy(block, &parameter->block));
  grounds->values += parameter->ground->count;
  while (strcmp(materials->names[parameter->material], parameter->ground->material)) parameter->material++;
  PetscCall(FindPlaces(&materials->at[parameter->material], parameter, &physics));
  MpmCheckInput(!physics, "-mpm_parameters: there are no derivatives yet by a field of a number of the water, %s.%s",
                parameter->ground->material, parameter->ground->parameter);
  parameter->density = (PetscBool)!strcmp(parameter->ground->parameter, "density");
  parameter->modulus = (PetscBool)!strcmp(parameter->ground->parameter, "E");
  for (PetscInt k = 1; k < parameter->ground->count; k++)
    if (parameter->ground->value[k] > parameter->ground->value[parameter->largest]) parameter->largest = k;
  PetscCall(PetscCalloc1(parameter->ground->count + 1, &parameter->sums));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode DestroyDirections(MpmFieldParameters *grounds)
{
  PetscFunctionBeginUser;
  for (PetscInt d = 0; d < grounds->direction_count; d++)
    PetscCall(PetscFree2(grounds->direction[d].along, grounds->direction[d].change));
  PetscCall(PetscFree(grounds->direction));
  grounds->direction_count = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmFieldParametersDestroy(MpmFieldParameters *grounds)
{
  PetscFunctionBeginUser;
  PetscCall(DestroyDirections(grounds));
  for (PetscInt k = 0; k < grounds->count; k++) {
    PetscCall(PetscFree(grounds->at[k].place));
    PetscCall(PetscFree(grounds->at[k].block));
    PetscCall(PetscFree(grounds->at[k].sums));
  }
  PetscCall(PetscFree(grounds->at));
  grounds->count = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A part of a scene beside the points' and loads' sums that takes numbers of a law. */
typedef struct {
  const char *name;
  PetscBool   there;
} Part;

/* True where any body begins with stress, or masses of its own. */
static PetscBool AnyStressed(const MpmBodies *bodies)
{
  for (PetscInt b = 0; b < bodies->count; b++)
    if (MpmBodyIsImported(bodies->at[b]) || MpmBodyIsStressed(bodies->at[b])) return PETSC_TRUE;
  return PETSC_FALSE;
}

static PetscErrorCode CheckParts(const MpmModel model, const MpmGround *ground)
{
  const MpmScene *scene   = &model->scene;
  const Part      parts[] = {
         {"more than one stage", (PetscBool)(scene->stages.count > 1)},
         {"inertia (-mpm_time_integrator)", (PetscBool)(scene->stages.at[0].time.motion.type != MPM_QUASISTATIC)},
         {"a geostatic stage", MpmStagesAreGeostatic(model)},
         {"a reduction of strength", MpmStagesReduce(model)},
         {"-mpm_physics of water", (PetscBool)(model->disc.layout->rate.count > 0)},
         {"bodies in contact", (PetscBool)(model->disc.material.parts > 1)},
         {"initial stresses and bodies from files", AnyStressed(scene->bodies)},
         {"division of points", (PetscBool)(scene->stabilization.divide > 0.)},
  };

  PetscFunctionBeginUser;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(parts); k++)
    MpmCheckInput(!parts[k].there, "-mpm_parameters: there are no derivatives yet by field %s with %s", ground->name,
                  parts[k].name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmFieldParametersCheck(const MpmModel model, const MpmFieldParameters *grounds)
{
  PetscFunctionBeginUser;
  if (grounds->count) PetscCall(CheckParts(model, grounds->at[0].ground));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- directions ---- */

/* Signs of a sequence of its own: the same on all machines. Source: Marsaglia (2003), doi:10.18637/jss.v008.i14. */
static PetscReal RandomSign(uint64_t *state)
{
  *state ^= *state << 13;
  *state ^= *state >> 7;
  *state ^= *state << 17;
  return *state >> 63 ? 1. : -1.;
}

PetscErrorCode MpmGroundDirectionsCreate(PetscBool checks, MpmFieldParameters *grounds)
{
  uint64_t state = 0x9E3779B97F4A7C15u;

  PetscFunctionBeginUser;
  PetscCall(DestroyDirections(grounds));
  MpmCheckInput(checks || grounds->values <= MPM_MOST_TANGENTS,
                "-mpm_gradient_method tangent: the fields have %" PetscInt_FMT " values; must be adjoint above %d",
                grounds->values, MPM_MOST_TANGENTS);
  PetscCall(PetscCalloc1(checks ? grounds->count * MPM_GROUND_CHECKS : grounds->values, &grounds->direction));
  for (PetscInt k = 0; k < grounds->count; k++) {
    const MpmGround *ground = grounds->at[k].ground;
    const PetscInt   count  = checks ? MPM_GROUND_CHECKS : ground->count;

    for (PetscInt d = 0; d < count; d++) {
      MpmGroundDirection *direction = &grounds->direction[grounds->direction_count++];

      direction->index = k;
      PetscCall(PetscCalloc2(ground->count + 1, &direction->along, ground->count, &direction->change));
      if (!checks) direction->change[d] = 1.;
      for (PetscInt i = 0; checks && i < ground->count; i++)
        direction->change[i] = RandomSign(&state) * ground->value[i];
      PetscCall(MpmGroundDirect(ground, direction->change, direction->along));
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- sums ---- */

PetscErrorCode MpmFieldParametersBegin(MpmFieldParameters *grounds)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < grounds->count; k++) {
    PetscCall(PetscArrayzero(grounds->at[k].sums, grounds->at[k].ground->count + 1));
    grounds->at[k].by_largest = 0.;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmFieldParametersEnd(MPI_Comm comm, MpmFieldParameters *grounds, PetscReal values[])
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < grounds->count; k++) {
    MpmFieldParameter *parameter = &grounds->at[k];
    PetscMPIInt        count;

    PetscCall(PetscMPIIntCast(parameter->ground->count + 1, &count));
    PetscCall(MPIU_Allreduce(MPI_IN_PLACE, parameter->sums, count, MPIU_REAL, MPIU_SUM, comm));
    PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &parameter->by_largest, 1, MPIU_REAL, MPIU_SUM, comm));
    PetscCall(PetscArrayzero(&values[parameter->first], parameter->ground->count));
    PetscCall(MpmGroundPull(parameter->ground, parameter->sums, &values[parameter->first]));
    values[parameter->first + parameter->largest] += parameter->by_largest;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscReal MpmGroundChange(const MpmFieldParameter *parameter, const PetscReal along[], const MpmPoints *points,
                          PetscInt dim, PetscInt p)
{
  if (points->material[p] != parameter->material) return 0.;
  return along ? MpmGroundAlong(parameter->ground, along, &points->origin[p * dim], points->id[p]) : 1.;
}

void MpmGroundDirections(const MpmFieldParameter *parameter, PetscReal change, PetscInt stride, double direction[])
{
  for (PetscInt k = 0; k < parameter->place_count; k++) direction[parameter->place[k] * stride] = change;
}

void MpmGroundTakePoint(const MpmFieldParameter *parameter, const MpmPoints *points, PetscInt dim, PetscInt p,
                        PetscReal by)
{
  MpmGroundAdd(parameter->ground, &points->origin[p * dim], points->id[p], by, parameter->sums);
}

/*
  Points and bodies in fields of the scene's numbers.
*/
#include "ground/ground.h"
#include "point/material.h"
#include "point/variation.h"
#include "particles/body_data.h"
#include "particles/ground_points.h"
#include "particles/points.h"

/* Bodies by their names and ids, for one material. */
static PetscErrorCode SetMaterial(PetscInt count, const MpmBody bodies[], const MpmMaterial *material, PetscInt m,
                                  PetscInt room)
{
  const char    **names;
  PetscInt       *first, *end, *points;
  PetscBool      *own;
  MpmGroundOwners owners = {.count = count, .room = room};

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc5(count, &names, count, &first, count, &end, count, &points, count, &own));
  for (PetscInt b = 0; b < count; b++) {
    names[b]  = bodies[b]->name;
    first[b]  = bodies[b]->ids.first;
    end[b]    = bodies[b]->ids.end;
    points[b] = bodies[b]->ids.count;
    own[b]    = MpmBodyHasMaterial(bodies[b], m);
  }
  owners.names  = names;
  owners.first  = first;
  owners.end    = end;
  owners.points = points;
  owners.own    = own;
  for (PetscInt v = 0; v < material->varies->count; v++)
    if (material->varies->at[v].ground) PetscCall(MpmGroundSetBodies(&owners, material->varies->at[v].ground));
  PetscCall(PetscFree5(names, first, end, points, own));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmBodiesSetGrounds(PetscInt count, const MpmBody bodies[], const MpmMaterial *materials, PetscInt room)
{
  PetscInt most = -1;

  PetscFunctionBeginUser;
  for (PetscInt b = 0; b < count; b++)
    most = PetscMax(most, bodies[b]->material.has ? bodies[b]->material.last : bodies[b]->material.first);
  for (PetscInt m = 0; m <= most; m++)
    if (materials[m].varies) PetscCall(SetMaterial(count, bodies, &materials[m], m, room));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A point at fault. */
typedef struct {
  const MpmGround *ground; /* NULL: none is */
  char             why[MPM_FAULT_TEXT];
} Fault;

/* Fault of fields at a point that began at x; `own`: room for a row of the material. */
static void FindFault(const MpmMaterial *material, const PetscReal x[], PetscInt id, double own[], Fault *fault)
{
  const MpmVariations *varies = material->varies;
  MpmMaterial          here   = *material;

  here.parameter = own;
  for (size_t k = 0; k < material->info.parameter_count; k++) own[k] = material->parameter[k];
  for (PetscInt v = 0; v < varies->count; v++) {
    const MpmGround *ground = varies->at[v].ground;

    if (!ground) continue;
    if (MpmGroundIndex(ground, x, id) < 0) {
      fault->ground = ground;
      (void)snprintf(fault->why, sizeof(fault->why), "has no value");
      return;
    }
    if (varies->at[v].place < (PetscInt)material->info.parameter_count)
      own[varies->at[v].place] = MpmGroundEvaluate(ground, x, id);
  }
  for (PetscInt v = 0; v < varies->count && !fault->ground; v++)
    if (varies->at[v].ground && MpmMaterialIsFaulty(&here, fault->why)) fault->ground = varies->at[v].ground;
}

PetscErrorCode MpmGroundCheckPoints(const MpmMaterial *material, const PetscBool of[], const MpmBodies *bodies,
                                    const MpmPoints *points, PetscInt dim, MPI_Comm comm)
{
  Fault       fault                      = {NULL, ""};
  char        text[MPM_FAULT_TEXT + 256] = "";
  double     *own;
  PetscMPIInt rank, size, first;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCallMPI(MPI_Comm_size(comm, &size));
  PetscCall(PetscMalloc1(material->info.parameter_count + 1, &own));
  first = size;
  for (PetscInt p = 0; p < points->count && !fault.ground; p++) {
    const PetscReal *x = &points->origin[p * dim];
    const PetscInt   b = MpmBodyNumber(bodies, points, p);

    if (b < bodies->count && of[b]) FindFault(material, x, points->id[p], own, &fault);
    if (!fault.ground) continue;
    first = rank;
    (void)snprintf(text, sizeof(text), "-mpm_field_%s_of %s.%s: at x %g, y %g, where a point begins: %s",
                   fault.ground->name, fault.ground->material, fault.ground->parameter, (double)x[0], (double)x[1],
                   fault.why);
  }
  PetscCall(PetscFree(own));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &first, 1, MPI_INT, MPI_MIN, comm));
  if (first == size) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCallMPI(MPI_Bcast(text, (PetscMPIInt)sizeof(text), MPI_CHAR, first, comm));
  MpmCheckInput(PETSC_FALSE, "%s", text);
  PetscFunctionReturn(PETSC_SUCCESS);
}

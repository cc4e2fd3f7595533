/*
  Description of a step without a solution: the place and the body of the largest force out of balance at Newton's last
  iterate, and the share of points that flow there.

  A point flows where a history variable of its plastic flow has changed: an equivalent or volume strain, the size of
  the yield surface.
*/
#include "point/material.h"
#include "particles/body.h"
#include "particles/particles.h"
#include "particles/points.h"
#include "space/sum.h"
#include "bc/bc.h"
#include "problem/discretization.h"
#include "solve/iterate.h"
#include "query/model.h"
#include "step/step.h"

#define FLOW 1e-12 /* of a history variable: less is rounding */

/* The largest free force at an owned node, N, and its place. */
static void FindForce(const MpmModel model, PetscReal *size, PetscReal place[])
{
  const MpmConstraints *constraints = model->disc.constraints;
  const PetscInt        bs = model->disc.block, dim = PetscMin(model->disc.dim, bs);

  *size = 0.;
  for (PetscInt i = 0; i < MpmNodesOwned(&model->disc); i++) {
    PetscReal square = 0.;

    for (PetscInt a = 0; a < dim; a++)
      if (!constraints->any || MpmConstraintsFree(constraints, i * bs + a))
        square += PetscSqr(model->disc.nodal.residual[i * bs + a]);
    if (!(PetscSqrtReal(square) > *size) || PetscIsInfOrNanReal(square)) continue;
    *size = PetscSqrtReal(square);
    MpmNodePosition(&model->disc, i, place);
  }
}

/* The body of the point that is nearest to a place; -1: none. */
static PetscErrorCode FindBody(MpmModel model, const PetscReal place[], PetscInt *body)
{
  const MpmPoints *points = model->disc.points;
  const PetscInt   dim    = model->disc.dim;
  PetscInt         at     = -1;
  struct {
    double distance;
    int    rank;
  } least = {PETSC_MAX_REAL, model->rank};

  PetscFunctionBeginUser;
  for (PetscInt p = 0; p < points->count; p++) {
    PetscReal square = 0.;

    for (PetscInt a = 0; a < dim; a++) square += PetscSqr(points->x[p * dim + a] - place[a]);
    if (square >= least.distance) continue;
    least.distance = square;
    at             = p;
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &least, 1, MPI_DOUBLE_INT, MPI_MINLOC, model->comm));
  *body = -1;
  if (at >= 0 && model->scene.bodies->count == 1) *body = 0;
  for (PetscInt b = 0; at >= 0 && *body < 0 && b < model->scene.bodies->count; b++) {
    PetscInt first, end;

    MpmBodyGetIds(model->scene.bodies->at[b], &first, &end);
    if (points->id[at] >= first && points->id[at] < end) *body = b;
  }
  PetscCallMPI(MPI_Bcast(body, 1, MPIU_INT, least.rank, model->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* True where a history variable measures plastic flow. Others go with the deformation. */
static PetscBool TellsFlow(const MpmStateVariable *variable)
{
  static const char *const names[] = {"equivalent_plastic_strain", "preconsolidation", "image_pressure",
                                      "plastic_volume_strain"};

  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(names); k++)
    if (!strcmp(variable->name, names[k])) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* True where the histories of all laws with plastic flow measure it. */
static PetscBool AllTell(const MpmModel model)
{
  for (PetscInt m = 0; m < model->scene.materials->count; m++) {
    const MpmLawInfo *info  = &model->scene.materials->at[m].info;
    PetscBool         tells = (PetscBool) !(info->traits & MPM_LAW_PLASTIC);

    for (size_t v = 0; v < info->state_count; v++) tells = (PetscBool)(tells || TellsFlow(&info->states[v]));
    if (!tells) return PETSC_FALSE;
  }
  return (PetscBool)(model->state.particles->state_size > 0);
}

/* True where a point flows in the trial. */
static PetscBool Flows(const MpmModel model, PetscInt p)
{
  const MpmPoints   *points   = model->disc.points;
  const MpmMaterial *material = &model->scene.materials->at[points->material[p]];
  const PetscInt     size     = model->state.particles->state_size;
  const PetscReal   *before = &points->state[p * size], *after = &model->disc.trial->state[p * size];

  for (size_t v = 0; v < material->info.state_count; v++) {
    const MpmStateVariable *variable = &material->info.states[v];

    if (TellsFlow(variable) && PetscAbsReal(*after - *before) > FLOW * PetscMax(1., PetscAbsReal(*before)))
      return PETSC_TRUE;
    before += MpmStateComponents(variable, model->disc.dim);
    after += MpmStateComponents(variable, model->disc.dim);
  }
  return PETSC_FALSE;
}

PetscErrorCode MpmStepLocate(MpmModel model, MpmOutcome *outcome)
{
  const PetscInt bs                 = model->disc.block;
  PetscReal      place[MPM_MAX_DIM] = {0.}, count[2] = {0., 0.};
  PetscInt       failed, body;
  PetscBool      tell;
  char           at[96], of[64] = "", flow[64] = "";
  struct {
    double size;
    int    rank;
  } most = {0., model->rank};

  PetscFunctionBeginUser;
  PetscCall(MpmGatherSolution(&model->solver, model->solver.x));
  PetscCall(MpmSumResidual(&model->solver, model->solver.x, MPM_MODE_END, &failed));
  MpmFramesToUnknowns(model->disc.constraints, bs, MpmNodesOwned(&model->disc), model->disc.nodal.residual);
  model->disc.trial->of.id = 0;
  tell                     = (PetscBool)(!failed && AllTell(model));
  FindForce(model, &most.size, place);
  for (PetscInt p = 0; tell && p < model->disc.points->count; p++) count[0] += Flows(model, p) ? 1. : 0.;
  count[1] = tell ? 0. : 1.;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPI_DOUBLE_INT, MPI_MAXLOC, model->comm));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, count, 2, MPIU_REAL, MPIU_SUM, model->comm));
  if (!(most.size > 0.)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCallMPI(MPI_Bcast(place, MPM_MAX_DIM, MPIU_REAL, most.rank, model->comm));
  PetscCall(FindBody(model, place, &body));
  PetscCall(PetscSNPrintf(at, sizeof(at), model->disc.dim > 2 ? "(%.4g, %.4g, %.4g)" : "(%.4g, %.4g)", (double)place[0],
                          (double)place[1], (double)place[2]));
  if (count[1] == 0.)
    PetscCall(PetscSNPrintf(flow, sizeof(flow), "; %.3g %% of the points flow",
                            (double)(100. * count[0] / (PetscReal)model->state.particles->total)));
  if (body >= 0) PetscCall(PetscSNPrintf(of, sizeof(of), " in body %.40s", model->scene.bodies->names[body]));
  PetscCall(
    MpmOutcomeExplain(outcome, "%s, with %.3g N out of balance at %s%s%s", outcome->text, most.size, at, of, flow));
  PetscFunctionReturn(PETSC_SUCCESS);
}

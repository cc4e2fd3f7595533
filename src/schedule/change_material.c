/*
  A body gets another material between stages.

  Strength, hardening and the like change where the law and its elasticity stay: F and history are kept, and the next
  step's return completes the change (strength reduction). Otherwise the Cauchy stress is kept: F and history of the new
  law that give it are searched (stress_inversion.c); history variables that both laws know by name are carried over.
  Volume and domain stay, mass goes with the density.

  Beside it, the fallback of a run for all materials where steps fail.
*/
#include "point/material.h"
#include "point/stress_inversion.h"
#include "particles/body.h"
#include "particles/particles.h"
#include "particles/point_mass.h"
#include "particles/points.h"
#include "loads/load.h"
#include "query/model.h"
#include "step/change_ramp.h"
#include "schedule/schedule.h"
#include "schedule/stage.h"

static PetscBool SameElasticity(const MpmMaterial *one, const double one_own[], const MpmMaterial *other,
                                const double other_own[])
{
  return (PetscBool)(!strcmp(one->info.name, other->info.name) &&
                     MpmMaterialStiffness(one, one_own, NULL, NULL) ==
                       MpmMaterialStiffness(other, other_own, NULL, NULL) &&
                     MpmMaterialPenalty(one, one_own) == MpmMaterialPenalty(other, other_own));
}

/* History variables of `to` from those of `from` with the same name and kind; others as without strain. */
static void CarryState(const MpmMaterial *from, const MpmMaterial *to, PetscInt dim, const PetscReal old[],
                       PetscReal state[])
{
  for (size_t v = 0; v < to->info.state_count; v++) {
    const MpmStateVariable *variable = &to->info.states[v];
    const PetscInt          n        = MpmStateComponents(variable, dim);
    PetscInt                first    = 0;

    for (PetscInt c = 0; c < n; c++) state[c] = c < 3 ? variable->initial : 0.;
    for (size_t w = 0; w < from->info.state_count; w++) {
      const MpmStateVariable *source = &from->info.states[w];

      /* elastic strains belong to the stress, which is searched again */
      if (!strcmp(source->name, variable->name) && source->kind == MPM_STATE_SCALAR &&
          variable->kind == MPM_STATE_SCALAR)
        state[0] = old[first];
      first += MpmStateComponents(source, dim);
    }
    state += n;
  }
}

/* Volume, domain and stress of point p stay, F and history become the new material's; MpmInitialFind()'s result. */
static int ChangePoint(MpmModel model, const MpmMaterial *old, const MpmInitial *initial, MpmPoints *points, PetscInt p)
{
  const PetscInt dim = model->disc.dim, size = model->state.particles->state_size;
  PetscReal      state_n[MPM_INITIAL_STATE], state[MPM_INITIAL_STATE], *F = MpmPointF(points, p), J, U[MPM_MAX_DIM];
  int            answer;

  if (model->scene.deformation.stretch(F, U)) return 2;
  J = MpmPointJ(points, p);
  CarryState(old, initial->material, dim, size ? &points->state[p * size] : NULL, state_n);
  answer = MpmInitialFind(initial, state_n, &points->stress[p * model->state.particles->stress_size], F, state,
                          points->across ? &points->across[p] : NULL);
  if (answer == 2) return 2;
  for (PetscInt k = 0; k < initial->material->state_size; k++) points->state[p * size + k] = state[k];
  for (PetscInt a = 0; points->domain.half_length && a < dim; a++) points->domain.half_length[p * dim + a] *= U[a];
  if (model->scene.deformation.stretch(F, U)) return 2;
  for (PetscInt a = 0; points->domain.half_length && a < dim; a++) points->domain.half_length[p * dim + a] /= U[a];
  points->volume0[p] *= J / MpmPointJ(points, p);
  return answer;
}

/* One point; MpmInitialFind()'s result, and the share of a ramp into `rest` (MpmChangeNote). */
static int ChangeOne(MpmModel model, const MpmMaterial *old, const double before[], const MpmInitial *initial,
                     MpmPoints *points, PetscInt p, PetscReal rest[7])
{
  const MpmMaterial *material = initial->material;
  const PetscInt     size     = model->state.particles->stress_size;
  const PetscInt     states   = model->state.particles->state_size;
  const PetscReal    density = MpmMaterialDensity(old, before), mass = points->mass[p];
  PetscReal         *stress = &points->stress[p * size], now[6] = {0.};
  int                answer = 0;

  for (PetscInt c = 0; c < size; c++) rest[1 + c] = now[c] = stress[c];
  if (density > 0.) points->mass[p] *= MpmMaterialDensity(material, initial->own) / density;
  else points->mass[p] = MpmMaterialDensity(material, initial->own) * points->volume0[p] * MpmPointJ(points, p);
  rest[0] = points->mass[p] > 0. ? mass / points->mass[p] - 1. : 0.;
  if (SameElasticity(old, before, material, initial->own))
    (void)MpmInitialReturn(initial, MpmPointF(points, p), states ? &points->state[p * states] : NULL, now);
  else {
    answer = ChangePoint(model, old, initial, points, p);
    for (PetscInt c = 0; c < size; c++) now[c] = stress[c];
  }
  for (PetscInt c = 0; c < size; c++) rest[1 + c] -= now[c];
  return answer;
}

/* One body; counts points that the new law's yield surface moved, and those without an answer. */
static PetscErrorCode ChangeBody(MpmModel model, PetscInt body, PetscInt to, PetscInt64 count[2])
{
  const MpmMaterial *material = &model->scene.materials->at[to];
  PetscInt           first, end, vertical[2], size = 0;
  MpmInitial         initial;
  MpmPoints          points;
  double            *row; /* own parameters before */
  PetscReal         *field[MPM_CHANGE_FIELDS];

  PetscFunctionBeginUser;
  for (PetscInt m = 0; m < model->scene.materials->count; m++)
    size = PetscMax(size, MpmMaterialOwnSize(&model->scene.materials->at[m]));
  PetscCall(PetscMalloc1(size, &row));
  MpmLoadsGetVertical(model->scene.loads, model->disc.dim, &vertical[0], &vertical[1]);
  PetscCall(MpmInitialCreate(material, model->disc.dim, &initial));
  MpmBodyGetIds(model->scene.bodies->at[body], &first, &end);
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  PetscCall(MpmChangeGet(model, field));
  for (PetscInt p = 0; p < points.count; p++) {
    const MpmMaterial *old;
    const double      *before;
    PetscReal          left[7] = {0.};
    int                answer;

    if (points.id[p] < first || points.id[p] >= end) continue;
    old    = &model->scene.materials->at[points.material[p]];
    before = MpmPointOwn(&points, old, p);
    if (before) PetscCall(PetscArraycpy(row, before, MpmMaterialOwnSize(old)));
    before             = before ? row : NULL;
    points.material[p] = to;
    MpmPointsSetOwn(model->scene.materials->at, vertical, model->disc.dim, p, p + 1, &points);
    initial.own = MpmPointOwn(&points, material, p);
    answer      = ChangeOne(model, old, before, &initial, &points, p, left);
    if (answer) count[answer - 1]++;
    MpmChangeNote(model, field, p, left[0], &left[1]);
  }
  PetscCall(PetscFree(row));
  PetscCall(MpmChangeRestore(model, field));
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* No point has anything left of an earlier change. */
static PetscErrorCode ForgetRests(MpmModel model)
{
  const PetscReal none[6] = {0.};
  PetscReal      *field[MPM_CHANGE_FIELDS];
  PetscInt        count;

  PetscFunctionBeginUser;
  if (!MpmChangeFieldCount(model)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(DMSwarmGetLocalSize(model->state.particles->swarm, &count));
  PetscCall(MpmChangeGet(model, field));
  for (PetscInt p = 0; p < count; p++) MpmChangeNote(model, field, p, 0., none);
  PetscCall(MpmChangeRestore(model, field));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmMaterialsChange(MpmModel model, const MpmStage *stage)
{
  PetscInt64 count[2] = {0, 0};
  PetscBool  any      = PETSC_FALSE;

  PetscFunctionBeginUser;
  PetscCall(ForgetRests(model));
  for (PetscInt b = 0; b < model->scene.bodies->count; b++) {
    if (stage->material[b] < 0) continue;
    PetscCall(ChangeBody(model, b, stage->material[b], count));
    any = PETSC_TRUE;
  }
  if (!any) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, count, 2, MPIU_INT64, MPI_SUM, model->comm));
  MpmCheckInput(!count[1],
                "-mpm_stage_%s_materials: %" PetscInt64_FMT " points have a stress that the new material cannot have",
                stage->name, count[1]);
  if (count[0])
    PetscCall(MpmMonitorNote(&model->monitor,
                             "stage %s: the stress of %" PetscInt64_FMT
                             " points is outside the new yield surface and was moved to it",
                             stage->name, count[0]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- dilation ---- */

void MpmStepAverageDilation(MpmModel model, PetscBool average)
{
  for (PetscInt m = 0; m < model->scene.materials->count; m++) {
    MpmMaterial *material = &model->scene.materials->at[m];

    material->dilatancy = !average && material->dilation.most > 0. ? material->info.dilatancy : NULL;
  }
  model->state.rescue.dilation = (PetscBool)!average;
}

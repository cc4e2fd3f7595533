/*
  Lines on the water of a stage: how its length compares with the time of consolidation, and what no water bears.

  The time factor of a material is T = t c_v/h^2, with the stage's length t, c_v = m M by the mobility m and the constrained modulus M
  at rest, and h the height of the material up gravity's axis. One-dimensional consolidation of a layer that drains at its top
  has come to 11 % at T = 0.01 and to 93 % at T = 1. Source: Terzaghi (1943), doi:10.1002/9780470172766.
*/
#include "point/layout.h"
#include "point/material.h"
#include "particles/particles.h"
#include "particles/points.h"
#include "terms/discretization.h"
#include "terms/load.h"
#include "time/model.h"
#include "time/water_state.h"

#define UNDRAINED 0.01
#define DRAINED   1.
#define LONG      1e20     /* s; in which what flows outweighs what is stored */
#define BOILS     (-100e3) /* Pa; water under the air's pressure parts below it */

/* The largest mobility of a material by axes, m2/(Pa s): what the ghost penalty's flow is in a long step. */
static PetscReal Mobility(const MpmModel model, const MpmMaterial *material)
{
  const MpmPhysicsMaterial of = MpmMaterialForPhysics(material, model->disc.dim);

  return PetscAbsReal(model->disc.layout->ghost(&of, material->physics_parameter, LONG, 1.)) / LONG;
}

/* Heights of the materials up gravity's axis, negative where there is none of it. Collective. */
static PetscErrorCode FindHeights(MpmModel model, PetscReal height[])
{
  const PetscInt count = model->scene.materials->count, dim = model->disc.dim;
  PetscInt       axis, up;
  PetscReal     *reach;
  MpmPoints      points;

  PetscFunctionBeginUser;
  MpmLoadsGetVertical(model->scene.loads, dim, &axis, &up);
  PetscCall(PetscMalloc1((2 * count), &reach));
  for (PetscInt k = 0; k < 2 * count; k++) reach[k] = PETSC_MIN_REAL / 4.;
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  for (PetscInt p = 0; p < points.count; p++) {
    const PetscInt  m    = points.material[p];
    const PetscReal half = points.half_length ? points.half_length[p * dim + axis] : 0., y = points.x[p * dim + axis];

    reach[2 * m]     = PetscMax(reach[2 * m], y + half);
    reach[2 * m + 1] = PetscMax(reach[2 * m + 1], half - y);
  }
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, reach, (PetscMPIInt)(2 * count), MPIU_REAL, MPIU_MAX, model->comm));
  for (PetscInt m = 0; m < count; m++) height[m] = reach[2 * m] + reach[2 * m + 1];
  PetscCall(PetscFree(reach));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmWaterTellStage(MpmModel model)
{
  const MpmMaterials *materials = model->scene.materials;
  const MpmStage     *stage     = &model->scene.stages[model->state.stage];
  const PetscReal     length    = model->state.time_end - model->state.time_start;
  PetscReal          *height, most = 0., least = PETSC_INFINITY;
  PetscInt            quick = -1, slow = -1;
  char                other[160] = "";

  PetscFunctionBeginUser;
  if (MpmPressureComponent(model->disc.layout) < 0 || !model->disc.layout->ghost || model->disc.layout->taken_up < 0)
    PetscFunctionReturn(PETSC_SUCCESS);
  if (stage->geostatic.method != MPM_GEOSTATIC_NONE) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(materials->count, &height));
  PetscCall(FindHeights(model, height));
  for (PetscInt m = 0; m < materials->count; m++) {
    const PetscReal diffusivity = Mobility(model, &materials->at[m]) * materials->at[m].stiffness;
    const PetscReal time        = height[m] > 0. ? PetscSqr(height[m]) / diffusivity : -1.;

    if (!(time > 0.)) continue;
    if (time < least) quick = m;
    if (time > most) slow = m;
    least = PetscMin(least, time);
    most  = PetscMax(most, time);
  }
  if (quick >= 0 && quick != slow)
    PetscCall(PetscSNPrintf(other, sizeof(other), "%.2g s (%s, h %.3g m) to ", (double)least, materials->names[quick],
                            (double)height[quick]));
  if (quick >= 0)
    PetscCall(MpmMonitorLine(&model->monitor, "water: %.4g s, beside h2/c_v of %s%.2g s (%s, h %.3g m): %s",
                             (double)length, other, (double)most, materials->names[slow], (double)height[slow],
                             stage->drained               ? "drained, as the stage says"
                             : length < UNDRAINED * least ? "undrained; where it drains, `drained: true`"
                             : length > DRAINED * most    ? "drained"
                                                          : "partly drained"));
  PetscCall(PetscFree(height));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The value of `least` over all ranks, with the place that goes with it, `dim` numbers behind it. */
static PetscErrorCode FindLeast(MpmModel model, PetscReal least[1 + MPM_MAX_DIM])
{
  PetscReal lowest = least[0];
  PetscInt  rank   = model->rank;

  PetscFunctionBeginUser;
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &lowest, 1, MPIU_REAL, MPIU_MIN, model->comm));
  if (least[0] > lowest) rank = model->size;
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &rank, 1, MPIU_INT, MPI_MIN, model->comm));
  if (rank < model->size) PetscCallMPI(MPI_Bcast(least, 1 + MPM_MAX_DIM, MPIU_REAL, (PetscMPIInt)rank, model->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void PlaceText(const MpmModel model, const PetscReal x[], char text[MPM_WATER_TEXT])
{
  char third[32] = "";

  if (model->disc.dim > 2) (void)PetscSNPrintf(third, sizeof(third), ", %.4g", (double)x[2]);
  (void)PetscSNPrintf(text, MPM_WATER_TEXT, "(%.4g, %.4g%s)", (double)x[0], (double)x[1], third);
}

PetscErrorCode MpmWaterFindTension(MpmModel model, char text[MPM_WATER_TEXT])
{
  const MpmStage *stage = &model->scene.stages[model->state.stage];
  const PetscInt  dim = model->disc.dim, rates = model->disc.layout->rates;
  PetscReal       least[1 + MPM_MAX_DIM] = {PETSC_INFINITY};
  char            place[MPM_WATER_TEXT];
  MpmPoints       points;

  PetscFunctionBeginUser;
  text[0] = '\0';
  if (MpmPressureComponent(model->disc.layout) < 0 || model->disc.layout->taken_up < 0)
    PetscFunctionReturn(PETSC_SUCCESS);
  if (model->state.boiled > model->state.stage) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  for (PetscInt p = 0; p < points.count; p++) {
    if (points.value[p * rates] >= least[0]) continue;
    least[0] = points.value[p * rates];
    for (PetscInt a = 0; a < dim; a++) least[1 + a] = points.x[p * dim + a];
  }
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  PetscCall(FindLeast(model, least));
  if (!(least[0] < BOILS)) PetscFunctionReturn(PETSC_SUCCESS);
  model->state.boiled = model->state.stage + 1;
  PlaceText(model, &least[1], place);
  PetscCall(PetscSNPrintf(text, MPM_WATER_TEXT,
                          "pore pressure %.4g kPa at %s%s%s: water boils below about -100 kPa; ground that drains in "
                          "a stage has `drained: true`",
                          (double)(1e-3 * least[0]), place, stage->name ? ", stage " : "",
                          stage->name ? stage->name : ""));
  PetscFunctionReturn(PETSC_SUCCESS);
}

#define CLOSED 0.01 /* porosity */

PetscErrorCode MpmWaterFindClosed(MpmModel model, const char **why)
{
  const PetscInt dim = model->disc.dim, size = model->disc.layout->own_size;
  PetscReal      least[1 + MPM_MAX_DIM] = {PETSC_INFINITY};
  char           place[MPM_WATER_TEXT];
  PetscInt       first;
  MpmPoints      points;

  PetscFunctionBeginUser;
  if (MpmPressureComponent(model->disc.layout) < 0 || model->disc.layout->taken_up < 0)
    PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmModelFindState(model, NULL, "porosity", &first, NULL));
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  for (PetscInt p = 0; p < points.count; p++) {
    if (points.own[p * size + first] >= least[0]) continue;
    least[0] = points.own[p * size + first];
    for (PetscInt a = 0; a < dim; a++) least[1 + a] = points.x[p * dim + a];
  }
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  PetscCall(FindLeast(model, least));
  if (!(least[0] < CLOSED)) PetscFunctionReturn(PETSC_SUCCESS);
  PlaceText(model, &least[1], place);
  PetscCall(PetscSNPrintf(model->solver.lost, sizeof(model->solver.lost), "pores closed at %s: porosity %.2g", place,
                          (double)least[0]));
  *why = model->solver.lost;
  PetscFunctionReturn(PETSC_SUCCESS);
}

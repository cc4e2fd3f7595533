/*
  Length of an explicit step.

  A step may take the fraction `cfl` of the time in which a wave crosses a cell, the shortest h_a/(c + |v_a|) of all
  points and axes, with c the speed of waves at the point's state and stress; the viscosity of a law shortens it.
*/
#include "talus/point/basal.h"
#include "point/material.h"
#include "point/wave_speed.h"
#include "grid/grid.h"
#include "particles/particles.h"
#include "particles/point_mass.h"
#include "particles/points.h"
#include "space/sum.h"
#include "rigid/rigid.h"
#include "pairs/body_contact.h"
#include "entrainment/entrainment.h"
#include "query/model.h"
#include "query/query.h"
#include "integrators/dynamics.h"

/*
  The time in which a wave crosses a cell, the shortest over all points, s; with a law's viscosity nu = eta J/rho_0,
  m2/s, the stable one: h/(sqrt(c^2 + (nu/h)^2) + nu/h), h^2/(2 nu) where viscosity acts alone.
*/
MPM_INLINE PetscReal Crossing(const PetscInt dim, const MpmModel model, const MpmPoints *points)
{
  const MpmSum    *sum           = model->disc.sum;
  const PetscReal *h             = model->disc.grid->h;
  PetscReal fastest[MPM_MAX_DIM] = {0., 0., 0.}, least = PETSC_MAX_REAL; /* m/s, where there is no viscosity; s */

  for (PetscInt p = 0; p < points->count; p++) {
    const MpmMaterial *material = &sum->materials[points->material[p]];
    const PetscReal   *state = points->state ? &points->state[p * sum->kept.state] : NULL, *F = MpmPointF(points, p);
    const double      *own     = MpmPointOwn(points, material, p);
    const PetscReal    density = own ? MpmMaterialDensity(material, own) : material->density;
    const PetscReal    c       = MpmWaveSpeed(dim, MpmMaterialStiffnessAt(material, own, state, F), density,
                                              MpmPointJ(points, p), &points->stress[p * MpmSymSize(dim)]);
    const PetscReal    eta     = material->info.viscosity ? MpmMaterialViscosity(material, own) : 0.;
    const PetscReal    nu      = eta > 0. ? eta * MpmPointVolumeRatio(material, F) / density : 0.;

    for (PetscInt a = 0; a < dim; a++) {
      const PetscReal speed = c + PetscAbsReal(points->motion.velocity[p * dim + a]);

      if (eta > 0.) least = PetscMin(least, h[a] / (PetscSqrtReal(speed * speed + PetscSqr(nu / h[a])) + nu / h[a]));
      else fastest[a] = PetscMax(fastest[a], speed);
    }
  }
  for (PetscInt a = 0; a < dim; a++) least = PetscMin(least, h[a] / fastest[a]);
  return least;
}

/* Columns at rest on a slope have slow waves where they are thin: the time in which their weight takes them through a
   cell, s; and that of columns that come in in this step. */
static PetscReal Falling(const MpmModel model)
{
  PetscReal h = PETSC_MAX_REAL, g = 0.;

  if (!(model->scene.physics.traits & MPM_PHYSICS_COLUMNS)) return PETSC_MAX_REAL;
  for (PetscInt a = 0; a < model->disc.dim; a++) h = PetscMin(h, model->disc.grid->h[a]);
  for (PetscInt m = 0; m < model->scene.materials->count; m++)
    g = PetscMax(g, model->scene.materials->at[m].parameter[MPM_BASAL_GRAVITY]);
  return PetscMin(PetscSqrtReal(h / g), MpmEntrainmentCrossing(model, g));
}

/* The points' arrays stay lent for the step that follows. */
static PetscErrorCode FindCrossing(MpmModel model, PetscReal *crossing)
{
  const MpmPoints *points = model->disc.points;

  PetscFunctionBeginUser;
  PetscCall(MpmParticlesLendArrays(model->state.particles, model->disc.points));
  *crossing = model->disc.dim == 2 ? Crossing(2, model, points) : Crossing(3, model, points);
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, crossing, 1, MPIU_REAL, MPIU_MIN, model->comm));
  *crossing = PetscMin(*crossing, Falling(model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reduction of a stable step by damping: sqrt(1 + xi^2) - xi, xi the fraction of critical damping of the fastest
   oscillation, 2/crossing. */
static PetscReal Shortened(const MpmDampingControl *damping, PetscReal crossing)
{
  const PetscReal xi = damping->stiffness / crossing + 0.25 * damping->mass * crossing + damping->linear;

  return crossing * (PetscSqrtReal(1. + xi * xi) - xi);
}

/* The stage's step; 0: none is given. */
static PetscReal GivenStep(const MpmModel model)
{
  return model->state.scheme.rescuing.on ? 0. : model->scene.stages.at[model->state.stage].time.step;
}

/* With scaled masses: the stage's step, or `cfl` of the time in which the slowest wave crosses a cell. */
static PetscErrorCode FindScaledStep(MpmModel model)
{
  const MpmMotionControl *motion  = MpmModelMotion(model);
  const MpmSum           *sum     = model->disc.sum;
  const PetscInt          dim     = model->disc.dim;
  PetscReal               slowest = PETSC_MAX_REAL, h = PETSC_MAX_REAL;
  const MpmPoints        *points = model->disc.points;

  PetscFunctionBeginUser;
  model->state.dt.wanted = GivenStep(model);
  if (model->state.dt.wanted > 0.) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmParticlesLendArrays(model->state.particles, model->disc.points));
  for (PetscInt p = 0; p < points->count; p++) {
    const MpmMaterial *material = &sum->materials[points->material[p]];
    const PetscReal   *state    = points->state ? &points->state[p * sum->kept.state] : NULL;

    slowest = PetscMin(slowest, MpmMaterialWaveSpeed(material, MpmPointOwn(points, material, p), dim, state,
                                                     MpmPointF(points, p), &points->stress[p * MpmSymSize(dim)]));
  }
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &slowest, 1, MPIU_REAL, MPIU_MIN, model->comm));
  for (PetscInt a = 0; a < dim; a++) h = PetscMin(h, model->disc.grid->h[a]);
  model->state.dt.wanted = motion->cfl * MpmExplicitPart(motion) * h / slowest;
  PetscFunctionReturn(PETSC_SUCCESS);
}

#define EVEN 10 /* steps at a stage's end that are of one length */

/*
  A step shortened by the stage's end changes contact, since resting bodies press by their displacement under weight in
  a step. Where anything touches the last steps therefore share the remaining time.
*/
static void ShareRest(MpmModel model)
{
  const PetscReal left  = model->state.period.end - model->state.time;
  const PetscReal steps = PetscCeilReal(left / model->state.dt.wanted - 1e-3);

  if (!model->scene.boundaries->count && !model->scene.pairs->count) return;
  if (steps >= 1. && steps <= EVEN) model->state.dt.wanted = PetscMin(model->state.dt.wanted, left / steps);
}

PetscErrorCode MpmExplicitLength(MpmModel model, MpmOutcome *outcome)
{
  const MpmMotionControl *motion = MpmModelMotion(model);
  const PetscReal         given  = GivenStep(model);
  PetscReal               crossing;

  PetscFunctionBeginUser;
  if (MpmModelScales(model)) {
    PetscCall(FindScaledStep(model));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(FindCrossing(model, &crossing));
  crossing *= MpmExplicitPart(motion);
  if (crossing > 0.) crossing = Shortened(&motion->damping, crossing);
  model->state.dt.wanted = motion->cfl * crossing;
  if (!(crossing > 0.))
    PetscCall(MpmOutcomeFail(outcome, MPM_OUTCOME_INADMISSIBLE, "a point has no finite wave speed"));
  if (!outcome->code && !(given > 0.) && !model->state.scheme.rescuing.on) ShareRest(model);
  if (outcome->code || !(given > 0.)) PetscFunctionReturn(PETSC_SUCCESS);
  if (given > crossing * (1. + PETSC_SQRT_MACHINE_EPSILON)) {
    PetscCall(MpmOutcomeFail(outcome, MPM_OUTCOME_INADMISSIBLE,
                             "the step %.4g is longer than a wave allows in a cell, %.4g", (double)given,
                             (double)crossing));
  }
  model->state.dt.wanted = given;
  PetscFunctionReturn(PETSC_SUCCESS);
}

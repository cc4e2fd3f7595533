/*
  Dynamic relaxation: a state at rest, found by explicit steps whose motion is damped.

    kinetic  no damping until the points' kinetic energy falls; then all velocities become zero, and the points stay
             where they are in that step; not while supports move
    viscous  f_i -= 2 xi m_i v_i ; xi is a rate, 1/s, critical for a mode whose angular frequency it is
    local    f_i -= alpha |f_i| sign(v_i), by component

  The stage ends where both criteria have been below the tolerance for long enough, once points have moved and no load,
  condition, boundary or strength changes any more:

    K_F = max_i |f_ext - f_int|_i / max_i |f_ext|_i ,  without prescribed components: there it is the reaction
    K_E = sum_p m_p v_p^2/2 / W ,  W += sum_i f_ext,i . u_i  the work of the loads since the stage began

  With `balance: points` the numerator is that of M_c M^-1 (f_ext - f_int), M_c the consistent mass of the points and M
  the lumped one: of the forces on the points, whose accelerations are sum_j w_jp f_j/m_j. At a surface a few points
  touch more nodes than they can move, and forces that cancel out on each point stay there for good. The damping of
  relaxation is in neither; Rayleigh's is in both, so that creep against it counts as balanced.

  K_F of 1 % at a node says little of a slow mode, whose forces are spread over all of them. Duration of the criteria
  without `hold`:

    kinetic  half a period, and then to the next reset, where vibrations pass their static place; without a reset, in
             creep, a whole period. The periods are 2 and 4 times the time of the first motion from rest to the peak of
             its energy, a quarter of the period of the mode that the loads excite most
    viscous  2/xi: vibrations have decayed to e^-2
    local    as long again as the stage took until they were met: this damping has no rate

  With `nodal_mass: scaled` the nodes move with other masses, and the kinetic energy is theirs. A step dt is stable
  where m_i >= dt^2/4 sum_j |K_ij|, since the sums of rows bound the largest eigenvalue of M^-1 K (Gershgorin), and a
  point adds to a block K_ij no more than V (lambda + 2 mu) |grad w_i| |grad w_j|:

    m'_i = max( m_i , (dt/cfl)^2/4 sum_p m_p c_p^2 |grad w_ip| sum_j |grad w_jp| )

  The step is that of the slowest material; stiff material, and nodes that little material touches, become heavier.

  Sources: Cundall (1976, 1987); Jin, Yin et al., kinetic damping in the material point method, whose criteria these
  are; Barnes (1999), Int. J. Space Struct. 14, 89-104, doi:10.1260/0266351991494722 (kinetic damping); Underwood
  (1983), Dynamic relaxation, in: Belytschko, Hughes (eds.), Computational Methods for Transient Analysis, 245-265
  (masses).
*/
#include "base/columns.h"
#include "geometry/geometry.h"
#include "particles/body.h"
#include "particles/particles.h"
#include "space/sum.h"
#include "transfer/momentum.h"
#include "transfer/motion.h"
#include "bc/bc.h"
#include "bc/body_motion.h"
#include "volume/inertia.h"
#include "rigid/rigid.h"
#include "loads/body_surface.h"
#include "loads/load.h"
#include "loads/water_table.h"
#include "problem/fields.h"
#include "query/model.h"
#include "query/query.h"
#include "integrators/dynamics.h"
#include "integrators/integrators.h"
#include "integrators/relaxation.h"

PetscBool MpmCouldRelax(const MpmModel model)
{
  return (PetscBool)(model->state.scheme.integrator == &MpmIntegratorQuasistatic &&
                     MpmFieldsAreMotion(model->disc.layout));
}

void MpmRelaxationBegin(MpmModel model)
{
  const MpmRelaxing before = model->state.relaxing;

  model->state.relaxing = (MpmRelaxing){.first = before.first, .since = before.since, .ended = before.ended};
  if (MpmModelRelaxes(model)) model->state.relaxing.first = model->state.relaxing.since = -1.;
  model->state.relaxing.reset = model->state.time;
}

void MpmRelaxationForget(MpmModel model)
{
  model->state.relaxing.force = model->state.relaxing.energy = 0.;
  model->state.relaxing.resets                               = 0;
}

/* ---- scaled masses ---- */

/* Masses of the local nodes, ghosts included, in place of the velocities with which an implicit step starts. */
static PetscErrorCode ScaleMasses(MpmModel model, PetscReal **mass)
{
  const MpmMotionControl *motion = MpmModelMotion(model);
  const PetscReal         cfl    = motion->cfl * MpmExplicitPart(motion);
  const PetscReal         by     = 0.25 * PetscSqr(model->disc.sum->step.dt / cfl);
  PetscReal              *to     = model->state.scheme.dynamics->v_start;

  PetscFunctionBeginUser;
  PetscCall(MpmStiffnessRows(model->disc.sum, to));
  for (PetscInt i = 0; i < model->disc.context.inertia->local; i++)
    to[i] = PetscMax(model->disc.context.inertia->mass[i], by * to[i]);
  *mass = to;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Scales the forces at the local nodes, along the axes, by the ratio of the inertia's masses to `mass`, so that the
  accelerations are those of `mass`; not on prescribed unknowns, whose forces are reactions.
*/
static void ScaleForces(const MpmModel model, const PetscReal mass[], PetscReal force[])
{
  const MpmConstraints *constraints = model->disc.constraints;
  const PetscInt        dim = model->disc.dim, local = model->disc.context.inertia->local;

  if (constraints->any) MpmFramesToUnknowns(constraints, dim, local, force);
  for (PetscInt k = 0; k < local * dim; k++)
    if (mass[k / dim] > 0. && (!constraints->any || MpmConstraintsFree(constraints, k)))
      force[k] *= model->disc.context.inertia->mass[k / dim] / mass[k / dim];
  if (constraints->any) MpmFramesToAxes(constraints, dim, local, force);
}

/* Of this rank's nodes, with these masses, at the step's end, J. */
static PetscReal NodesKinetic(const MpmModel model)
{
  const MpmDynamics *dynamics = model->state.scheme.dynamics;
  const PetscInt     dim      = model->disc.dim;
  PetscReal          kinetic  = 0.;

  for (PetscInt k = 0; k < model->disc.context.inertia->owned * dim; k++)
    kinetic += 0.5 * dynamics->v_start[k / dim] * PetscSqr(dynamics->v_new[k]);
  return kinetic;
}

/* ---- a step ---- */

/* The square of a node's force, without prescribed components; `force`, by the frame where the node has one. */
static PetscReal FreeSquare(const MpmModel model, PetscInt node, const PetscReal force[])
{
  const MpmConstraints *constraints = model->disc.constraints;
  const MpmFrame       *frame       = constraints->any ? MpmConstraintsFrame(constraints, node) : NULL;
  const PetscInt        dim         = model->disc.dim;
  PetscReal             square      = 0.;

  for (PetscInt a = 0; a < dim; a++) {
    PetscReal along = 0.;

    if (constraints->any && !MpmConstraintsFree(constraints, node * dim + a)) continue;
    for (PetscInt c = 0; frame && c < dim; c++) along += frame->axis[a][c] * force[c];
    square += PetscSqr(frame ? along : force[a]);
  }
  return square;
}

/*
  K_F, from the whole forces at the owned nodes. Nodes without mass have nothing to balance. Where there are no loads,
  since supports drive the material, their largest force counts.
*/
static PetscErrorCode Compare(MpmModel model, const PetscReal load[], const PetscReal force[])
{
  const PetscInt dim     = model->disc.dim;
  PetscReal      most[3] = {0., 0., 0.};

  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < model->disc.context.inertia->owned; i++) {
    PetscReal square = 0., whole = 0., free;

    if (!(model->disc.context.inertia->mass[i] > 0.)) continue;
    for (PetscInt a = 0; a < dim; a++) square += PetscSqr(load[i * dim + a]);
    for (PetscInt a = 0; a < dim; a++) whole += PetscSqr(force[i * dim + a]);
    free    = FreeSquare(model, i, &force[i * dim]);
    most[0] = PetscMax(most[0], free);
    most[1] = PetscMax(most[1], square);
    most[2] = PetscMax(most[2], whole - free);
  }
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, most, 3, MPIU_REAL, MPIU_MAX, model->comm));
  if (!(most[1] > 0.)) most[1] = most[2];
  model->state.relaxing.force = most[1] > 0. ? PetscSqrtReal(most[0] / most[1]) : (most[0] > 0. ? PETSC_MAX_REAL : 0.);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* M_c M^-1 f at the owned nodes, without prescribed components. */
static PetscErrorCode Feel(MpmModel model, const PetscReal force[], PetscReal felt[])
{
  const MpmConstraints *constraints = model->disc.constraints;
  const PetscReal      *mass        = model->disc.context.inertia->mass;
  const PetscInt        dim = model->disc.dim, local = model->disc.context.inertia->local;
  PetscReal            *a = model->state.scheme.dynamics->a_new;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < local * dim; k++) a[k] = mass[k / dim] > 0. ? force[k] / mass[k / dim] : 0.;
  if (constraints->any) {
    MpmFramesToUnknowns(constraints, dim, local, a);
    for (PetscInt k = 0; k < local * dim; k++)
      if (!MpmConstraintsFree(constraints, k)) a[k] = 0.;
    MpmFramesToAxes(constraints, dim, local, a);
  }
  PetscCall(MpmMotionFeel(model->disc.sum, a, felt));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmRelaxationDamp(MpmModel model, PetscReal load[], PetscReal force[])
{
  const MpmRelaxation *relaxation = &model->scene.stages.at[model->state.stage].relaxation;
  const MpmDynamics   *dynamics   = model->state.scheme.dynamics;
  const PetscReal     *mass = model->disc.context.inertia->mass, *v = dynamics->v_old;
  const PetscInt       dim = model->disc.dim, count = model->disc.context.inertia->local * dim;
  PetscReal           *scaled = NULL;

  PetscFunctionBeginUser;
  if (relaxation->scaled) PetscCall(ScaleMasses(model, &scaled));
  if (scaled) mass = scaled;
  PetscCall(MpmNodesToOwners(&model->disc, dim, load));
  PetscCall(
    PetscArrayzero(&load[model->disc.context.inertia->owned * dim], count - model->disc.context.inertia->owned * dim));
  if (relaxation->felt) PetscCall(Feel(model, force, dynamics->a_rest));
  PetscCall(Compare(model, load, relaxation->felt ? dynamics->a_rest : force));
  for (PetscInt k = 0; relaxation->damping == MPM_DAMPING_VISCOUS && k < count; k++)
    force[k] -= 2. * relaxation->xi * mass[k / dim] * v[k];
  for (PetscInt k = 0; relaxation->damping == MPM_DAMPING_LOCAL && k < count; k++)
    force[k] -= relaxation->factor * PetscAbsReal(force[k]) * (v[k] > 0. ? 1. : v[k] < 0. ? -1. : 0.);
  if (scaled) ScaleForces(model, scaled, force);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Of the step under way, by the clock of the motion. */
static PetscReal End(const MpmModel model)
{
  const MpmRescuing *rescuing = &model->state.scheme.rescuing;

  return rescuing->on ? rescuing->clock + model->disc.sum->step.dt : model->state.time + model->disc.sum->step.span;
}

/* True while supports, or loads in a rescue, move. A support that stopped with the points would lose that fraction of
   a step. */
static PetscErrorCode IsDriven(MpmModel model, PetscBool *driven)
{
  const MpmConstraints *constraints = model->disc.constraints;

  PetscFunctionBeginUser;
  *driven = PETSC_FALSE;
  for (PetscInt k = 0; constraints->any && k < model->disc.context.inertia->owned * model->disc.dim; k++)
    if (!MpmConstraintsFree(constraints, k) && constraints->value[k] != 0.) *driven = PETSC_TRUE;
  if (model->state.scheme.rescuing.on && End(model) < model->state.scheme.rescuing.ramp) *driven = PETSC_TRUE;
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, driven, 1, MPM_MPI_BOOL, MPI_LOR, model->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmRelaxationObserve(MpmModel model, PetscBool *stopped)
{
  MpmRelaxing   *relaxing = &model->state.relaxing;
  const PetscInt dim      = model->disc.dim;
  PetscReal      kinetic =
    MpmModelScales(model) ? NodesKinetic(model) : MpmPointsKinetic(model->disc.points, model->disc.sum->materials, dim);

  PetscFunctionBeginUser;
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &kinetic, 1, MPIU_REAL, MPIU_SUM, model->comm));
  *stopped = (PetscBool)(model->scene.stages.at[model->state.stage].relaxation.damping == MPM_DAMPING_KINETIC &&
                         kinetic < relaxing->kinetic);
  if (*stopped) {
    PetscBool driven;

    PetscCall(IsDriven(model, &driven));
    *stopped = (PetscBool)!driven;
  }
  if (*stopped) {
    kinetic = 0.;
    relaxing->resets++;
    if (!(relaxing->quarter > 0.) && End(model) - relaxing->reset > 2.5 * model->disc.sum->step.dt)
      relaxing->quarter = End(model) - relaxing->reset; /* one that falls at once has begun in motion */
    relaxing->reset = End(model);
    PetscCall(MpmPointsStop(model->disc.points, dim));
  }
  relaxing->kinetic = kinetic;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The later of two times, of which the second counts from a start. */
static PetscReal Later(PetscReal until, MpmRamp ramp, PetscReal start)
{
  return ramp ? PetscMax(until, start + MpmRampLastChange(ramp)) : until;
}

/* The run's time from which on loads, conditions, motions, boundaries, water and strengths of the stage stay as they
   are. */
static PetscReal StillFrom(const MpmModel model)
{
  const MpmScene *scene = &model->scene;
  const MpmState *state = &model->state;
  const PetscInt  loads = scene->loads->count;
  PetscReal       until = Later(PETSC_NINFINITY, scene->stages.at[state->stage].reduction.ramp, state->period.start);

  for (PetscInt l = 0; l < loads; l++)
    if (state->acting.loads[l].active && !state->acting.loads[l].forced)
      until = Later(until, scene->loads->at[l].ramp, state->acting.loads[l].start);
  for (PetscInt s = 0; s < scene->surfaces->count; s++)
    if (state->acting.loads[loads + s].active && !state->acting.loads[loads + s].forced)
      until = Later(until, scene->surfaces->at[s].ramp, state->acting.loads[loads + s].start);
  for (PetscInt b = 0; b < scene->bcs->count; b++)
    if (state->acting.bcs[b].active &&
        (scene->bcs->at[b].absorbing || MpmConditionMoves(&scene->bcs->at[b], model->disc.dim)))
      until = Later(until, scene->bcs->at[b].ramp, state->acting.bcs[b].start);
  for (PetscInt m = 0; m < scene->motions->count; m++)
    if (state->acting.bcs[scene->bcs->count + m].active)
      until = Later(until, scene->motions->at[m].ramp, state->acting.bcs[scene->bcs->count + m].start);
  for (PetscInt b = 0; b < scene->boundaries->count; b++) {
    const MpmMotion *motion = &scene->boundaries->at[b].motion;

    if (motion->rows) until = PetscMax(until, motion->time[motion->rows - 1]);
    else if (MpmMotionMoves(motion)) until = Later(until, motion->ramp, motion->delay);
  }
  for (PetscInt b = 0; b < scene->bodies->count; b++)
    until = Later(until, state->scheme.fading[b].ramp, state->scheme.fading[b].start);
  if (scene->water && scene->water->there) until = Later(until, scene->water->ramp, 0.);
  return until;
}

/* True where the material may be at rest: a point has moved, and all driving is at its end. */
static PetscErrorCode MayRest(MpmModel model, PetscBool *may)
{
  const MpmRelaxing *relaxing = &model->state.relaxing;
  PetscBool          driven;

  PetscFunctionBeginUser;
  *may = PETSC_FALSE;
  if (model->state.scheme.rescuing.on) {
    *may = (PetscBool)(End(model) >= model->state.scheme.rescuing.ramp);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (!(relaxing->kinetic > 0.) && !relaxing->resets) PetscFunctionReturn(PETSC_SUCCESS);
  if (model->state.time == model->state.period.start)
    PetscFunctionReturn(PETSC_SUCCESS); /* K_F is that of the stage's start */
  if (model->state.time < PetscMin(StillFrom(model), model->state.period.end)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(IsDriven(model, &driven));
  *may = (PetscBool)!driven;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* K_F of rounding, with which material drifts and never swings back, and the steps for which it is to last. */
#define ROUNDING 1e-10
#define STEPS    10

/* True where the criteria have been met for long enough. */
static PetscBool HaveHeld(const MpmModel model)
{
  const MpmRelaxation *relaxation = &model->scene.stages.at[model->state.stage].relaxation;
  const MpmRelaxing   *relaxing   = &model->state.relaxing;
  const PetscReal      held       = End(model) - relaxing->since;

  if (relaxing->since < 0.) return PETSC_FALSE;
  if (relaxation->hold >= 0.) return (PetscBool)(held >= relaxation->hold);
  if (relaxation->damping == MPM_DAMPING_VISCOUS) return (PetscBool)(held >= 2. / relaxation->xi);
  if (relaxation->damping == MPM_DAMPING_LOCAL)
    return (PetscBool)(held >= relaxing->since - (model->state.scheme.rescuing.on ? 0. : model->state.period.start));
  if (relaxing->force < ROUNDING && held >= STEPS * model->disc.sum->step.dt) return PETSC_TRUE;
  return (PetscBool)(held >= (relaxing->kinetic > 0. ? 4. : 2.) * relaxing->quarter &&
                     (relaxing->quarter > 0. || !(relaxing->kinetic > 0.)));
}

PetscErrorCode MpmRelaxationFinish(MpmModel model, const PetscReal load[])
{
  const MpmRelaxation *relaxation = &model->scene.stages.at[model->state.stage].relaxation;
  MpmRelaxing         *relaxing   = &model->state.relaxing;
  const MpmRescuing   *rescuing   = &model->state.scheme.rescuing;
  PetscReal            work       = 0., most;
  PetscBool            holds;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < model->disc.context.inertia->owned * model->disc.dim; k++)
    work += load[k] * model->disc.nodal.u[k];
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &work, 1, MPIU_REAL, MPIU_SUM, model->comm));
  relaxing->work   = rescuing->on ? model->state.scheme.energy.external - rescuing->work : relaxing->work + work;
  most             = PetscAbsReal(relaxing->work);
  relaxing->energy = most > 0. ? relaxing->kinetic / most : (relaxing->kinetic > 0. ? PETSC_MAX_REAL : 0.);
  holds            = (PetscBool)(relaxing->force < relaxation->tolerance && relaxing->energy < relaxation->tolerance);
  if (holds) PetscCall(MayRest(model, &holds));
  if (holds && relaxing->first < 0.) relaxing->first = End(model);
  if (!holds) relaxing->since = -1.;
  else if (relaxing->since < 0.) relaxing->since = rescuing->on ? rescuing->clock : model->state.time;
  relaxing->rests = HaveHeld(model);
  if (relaxing->rests && !rescuing->on)
    PetscCall(MpmMonitorNote(&model->monitor,
                             "at rest at %.6g: K_F and K_E are below %g, first at %.6g, without a break since %.6g; "
                             "%" PetscInt_FMT " reset%s",
                             (double)End(model), (double)relaxation->tolerance, (double)relaxing->first,
                             (double)relaxing->since, relaxing->resets, relaxing->resets == 1 ? "" : "s"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode FillCriteria(MpmModel model, const MpmColumn *column, PetscReal values[])
{
  const MpmRelaxing *relaxing = &model->state.relaxing;

  (void)column;
  PetscFunctionBeginUser;
  values[0] = relaxing->force;
  values[1] = relaxing->energy;
  values[2] = (PetscReal)relaxing->resets;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmRelaxationAddColumns(MpmModel model, MpmColumns *columns)
{
  static const char *const parts[] = {"K_F", "K_E", "resets"};
  const MpmColumn row = {.unit = "-", .count = PETSC_STATIC_ARRAY_LENGTH(parts), .parts = parts, .fill = FillCriteria};

  PetscFunctionBeginUser;
  if (MpmStagesRelax(model)) PetscCall(MpmColumnsAdd(columns, NULL, &row));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmRelaxationAddRows(MpmModel model)
{
  MpmRelaxing *relaxing = &model->state.relaxing;
  const MpmRow rows[]   = {
      {"relaxation_energy", MPM_ROW_REAL, MPM_ROW_RUN, &relaxing->kinetic, 0, 0},
      {"relaxation_work", MPM_ROW_REAL, MPM_ROW_RUN, &relaxing->work, 0, 0},
      {"relaxation_first", MPM_ROW_REAL, MPM_ROW_RUN, &relaxing->first, 0, 0},
      {"relaxation_since", MPM_ROW_REAL, MPM_ROW_RUN, &relaxing->since, 0, 0},
      {"relaxation_reset", MPM_ROW_REAL, MPM_ROW_RUN, &relaxing->reset, 0, 0},
      {"relaxation_quarter", MPM_ROW_REAL, MPM_ROW_RUN, &relaxing->quarter, 0, 0},
      {"relaxation_resets", MPM_ROW_INT, MPM_ROW_RUN, &relaxing->resets, 0, 0},
      {"ended", MPM_ROW_REAL, MPM_ROW_RUN, relaxing->ended, model->scene.stages.count, 0},
  };

  PetscFunctionBeginUser;
  PetscCall(MpmRowsAdd(model->state.rows, NULL, PETSC_STATIC_ARRAY_LENGTH(rows), rows));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmRelaxationOver(MpmModel model, MpmOutcome *outcome)
{
  MpmState          *state    = &model->state;
  const MpmRelaxing *relaxing = &state->relaxing;
  PetscReal          still;
  char               cause[96] = "";

  PetscFunctionBeginUser;
  if (relaxing->rests) MpmStageEndHere(model);
  if (relaxing->rests || state->time < state->period.end) PetscFunctionReturn(PETSC_SUCCESS);
  still = StillFrom(model);
  if (!(relaxing->kinetic > 0.) && !relaxing->resets) (void)PetscSNPrintf(cause, sizeof(cause), ": nothing has moved");
  else if (still > state->period.start && state->time - still < 0.1 * (state->period.end - state->period.start))
    (void)PetscSNPrintf(cause, sizeof(cause), ": loads, conditions or strengths change until %.6g", (double)still);
  PetscCall(MpmOutcomeFail(outcome, MPM_OUTCOME_NO_SOLUTION,
                           "the relaxation has not come to rest%s; K_F is %.3g and K_E %.3g, with a tolerance of %g",
                           cause, (double)relaxing->force, (double)relaxing->energy,
                           (double)model->scene.stages.at[state->stage].relaxation.tolerance));
  PetscFunctionReturn(PETSC_SUCCESS);
}

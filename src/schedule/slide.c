/*
  Loss of equilibrium in steps without inertia.

  Where ground loses its equilibrium a solution is a jump: it lies so much further on that the ground has come to rest
  in another shape, however short the step is. A solution is suspected where a point moves by JUMP_WAY cells more than
  any condition, motion or boundary prescribes in the step, and by more than JUMP_RATIO times as much, for the forces
  that drive the step, as in the stage so far:

    C = max |u_p| / |f_ext(t + dt) - f_int(t)| ,    C > JUMP_RATIO sum max |u_p| / sum |f_ext(t + dt) - f_int(t)|

  The sums leave out steps that were as far out of proportion, but those that halving has confirmed. A suspected step is
  halved. A step suspected again after JUMP_HALVES halvings, that ends no later than the first one and moves by more
  than JUMP_SHRINK of its motion, does not shrink with the step: the run ends, and the last line gives body, distance
  and place of the slide. Steps that shrink are accepted: they follow a path of equilibrium. Where the run gives up,
  because no solution is found, a slide is reported if the last step was as far out of proportion.

  Beyond a limit load ground may also slide in short steps, each in equilibrium with ground that has come to lie before
  it: a cut whose toe is buried rises by a third of its limit load. Yielding makes ground softer by a factor of ten or
  so, a mechanism by hundreds. A slide therefore begins with a step that is FAR_RATIO times out of proportion to those
  that were in proportion. The slide lasts while steps are JUMP_RATIO times out of proportion by their forces or by
  their lengths: as points move over the grid a step starts out of balance, by much more than a short step's loads. The
  run ends before the slide, without its prescribed part, is longer than JUMP_WAY cells.

  A stage that seeks a factor of safety, or has found one, slides as it should, and relaxations in place of a step do
  so, too.

  Order of calls: Begin() with a stage; Look() at a solution before it is accepted, Observe() after that; Explain()
  where a run gives up.
*/
#include "point/material.h"
#include "grid/grid.h"
#include "geometry/pose.h"
#include "particles/body.h"
#include "particles/points.h"
#include "space/sum.h"
#include "bc/bc.h"
#include "rigid/rigid.h"
#include "assembly/terms.h"
#include "query/model.h"
#include "query/query.h"
#include "step/step.h"
#include "schedule/schedule.h"

#define JUMP_WAY    0.1
#define JUMP_RATIO  10.
#define FAR_RATIO   100.
#define JUMP_SHRINK 0.25
#define JUMP_HALVES 3

void MpmSlideBegin(MpmModel model)
{
  model->state.scheme.slide = (MpmSlide){.end = -1.};
}

/* True where anything flows or rubs. An elastic body that jumps, as it buckles, is in equilibrium behind that. */
static PetscBool MaySlide(const MpmModel model)
{
  for (PetscInt m = 0; m < model->scene.materials->count; m++)
    if (model->scene.materials->at[m].info.traits & MPM_LAW_PLASTIC) return PETSC_TRUE;
  return (PetscBool)((MpmTermsTraits(model->disc.terms) & MPM_TERM_SLIDES) > 0);
}

/* True where the stage under way may not slide. */
static PetscBool MustStand(const MpmModel model)
{
  const MpmStage *stage = &model->scene.stages.at[model->state.stage];

  return (PetscBool)(MaySlide(model) && stage->time.motion.type == MPM_QUASISTATIC &&
                     stage->geostatic.method == MPM_GEOSTATIC_NONE && !stage->reduction.ramp &&
                     !model->state.scheme.rescuing.on && !stage->time.rescue);
}

/* The number of a point's body; -1: it is not known, as in runs that go on without the bodies. */
static PetscInt BodyOf(const MpmModel model, PetscInt id)
{
  if (model->scene.bodies->count == 1) return 0;
  for (PetscInt b = 0; b < model->scene.bodies->count; b++) {
    PetscInt first, end;

    MpmBodyGetIds(model->scene.bodies->at[b], &first, &end);
    if (id >= first && id < end) return b;
  }
  return -1;
}

/* The longest displacement of a node along an axis, m. */
static PetscErrorCode FindLongest(MpmModel model, PetscReal *way)
{
  const PetscInt bs = model->disc.block;

  PetscFunctionBeginUser;
  *way = 0.;
  for (PetscInt i = 0; i < MpmNodesOwned(&model->disc); i++)
    for (PetscInt a = 0; a < model->disc.dim; a++) *way = PetscMax(*way, PetscAbsReal(model->disc.nodal.u[i * bs + a]));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, way, 1, MPIU_REAL, MPIU_MAX, model->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  The longest displacement, m, that conditions, motions of bodies and translations of boundaries prescribe in the step.
  Material that is dragged along under a constant force moves so far on purpose.
*/
static PetscErrorCode FindDriven(MpmModel model, PetscReal next, PetscReal *driven)
{
  const MpmConstraints *constraints = model->disc.constraints;
  const MpmBoundaries  *boundaries  = model->scene.boundaries;
  const PetscInt        bs = model->disc.block, dim = model->disc.dim;
  const PetscReal       start = model->state.time;

  PetscFunctionBeginUser;
  *driven = 0.;
  for (PetscInt i = 0; i < MpmNodesOwned(&model->disc); i++) {
    PetscReal square = 0.;

    for (PetscInt k = i * bs; k < i * bs + dim; k++)
      if (constraints->condition[k] >= 0) square += PetscSqr(constraints->value[k]);
    *driven = PetscMax(*driven, PetscSqrtReal(square));
  }
  for (PetscInt b = 0; b < boundaries->count; b++) {
    const MpmPose after  = MpmBoundaryPose(&boundaries->at[b], next);
    MpmPose       before = {.growth = 0.};
    PetscReal     square = 0.;

    if (start > 0.) before = MpmBoundaryPose(&boundaries->at[b], start);
    for (PetscInt a = 0; a < dim; a++) square += PetscSqr(after.translation[a] - before.translation[a]);
    *driven = PetscMax(*driven, PetscSqrtReal(square));
  }
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, driven, 1, MPIU_REAL, MPIU_MAX, model->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* True where a point's body is being removed. */
static PetscBool IsFading(const MpmModel model, PetscInt id)
{
  const PetscInt body = BodyOf(model, id);

  return (PetscBool)(body >= 0 && model->state.scheme.fading[body].ramp);
}

/* The longest displacement of a point that stays, m, and on every rank the place and the body of that point. */
static PetscErrorCode FindFastest(MpmModel model, MpmFastest *fastest)
{
  const MpmPoints *points = model->disc.points;
  const PetscInt   dim    = model->disc.dim;
  PetscReal       *moves, send[MPM_MAX_DIM + 1] = {0.};
  const PetscBool  fades = MpmRemovalGoesOn(model);
  PetscInt         at    = -1;
  struct {
    double way;
    int    rank;
  } most = {0., model->rank};

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1((points->count * dim), &moves));
  PetscCall(MpmDisplacementsAtPoints(model->disc.sum, model->disc.nodal.u, moves));
  for (PetscInt p = 0; p < points->count; p++) {
    PetscReal square = 0.;

    if (fades && IsFading(model, points->id[p])) continue;
    for (PetscInt a = 0; a < dim; a++) square += PetscSqr(moves[p * dim + a]);
    if (at >= 0 && !(PetscSqrtReal(square) > most.way)) continue;
    most.way = PetscSqrtReal(square);
    at       = p;
  }
  PetscCall(PetscFree(moves));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPI_DOUBLE_INT, MPI_MAXLOC, model->comm));
  if (most.rank == model->rank && at >= 0) {
    for (PetscInt a = 0; a < dim; a++) send[a] = points->x[at * dim + a];
    send[MPM_MAX_DIM] = (PetscReal)BodyOf(model, points->id[at]);
  }
  PetscCallMPI(MPI_Bcast(send, MPM_MAX_DIM + 1, MPIU_REAL, most.rank, model->comm));
  fastest->way  = most.way;
  fastest->body = (PetscInt)send[MPM_MAX_DIM];
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) fastest->place[a] = send[a];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Failure: body, distance and place of the slide, by a format of a name, a length and a place. */
static void Describe(MpmModel model, const MpmFastest *fastest, const char format[], MpmOutcome *outcome)
{
  const char *body = fastest->body >= 0 ? model->scene.bodies->names[fastest->body] : "a body";
  char        place[96];

  (void)PetscSNPrintf(place, sizeof(place), model->disc.dim > 2 ? "(%.4g, %.4g, %.4g)" : "(%.4g, %.4g)",
                      (double)fastest->place[0], (double)fastest->place[1], (double)fastest->place[2]);
  (void)MpmOutcomeFail(outcome, MPM_OUTCOME_REFUSED, format, body, (double)fastest->way, place);
}

#define SLIDES "the ground slides: %.40s, %.3g m a step whatever the step, fastest at %s"
#define MOVES  "the ground slides: %.40s, %.3g m in steps far out of proportion to their loads, fastest at %s"
#define JUMPS  "body %.40s jumps by %.3g m at %s"

/*
  True where the present solution is so many times out of proportion to the steps that were in proportion. Rounding,
  before a load sets in, is no measure.
*/
static PetscBool Exceeds(const MpmSlide *slide, PetscReal ratio)
{
  const PetscReal way = slide->steady[0], force = slide->steady[1];

  return (PetscBool)(way > 0. && FAR_RATIO * force > slide->force &&
                     slide->now.way * force > ratio * slide->force * way);
}

/* True where a slide goes on in the present solution. */
static PetscBool GoesOn(const MpmSlide *slide)
{
  if (!(slide->slid > 0.)) return PETSC_FALSE;
  return (PetscBool)(Exceeds(slide, JUMP_RATIO) ||
                     slide->now.way * slide->steady[2] > JUMP_RATIO * slide->dt * slide->steady[0]);
}

/* Ends the run where short steps far out of proportion have added up. */
static PetscErrorCode LookAtSum(MpmModel model, MpmOutcome *outcome)
{
  MpmSlide       *slide = &model->state.scheme.slide;
  const PetscReal most  = JUMP_WAY * model->disc.grid->h[0] + slide->driven;
  MpmFastest      sum;

  PetscFunctionBeginUser;
  if (!GoesOn(slide) || slide->slid + slide->now.way <= most) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(FindFastest(model, &slide->now));
  if (!GoesOn(slide) || slide->slid + slide->now.way <= most) PetscFunctionReturn(PETSC_SUCCESS);
  sum = slide->now;
  sum.way += slide->slid;
  outcome->retryable = PETSC_FALSE;
  Describe(model, &sum, MOVES, outcome);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Halves a step whose solution is suspected to be a jump, or ends the run. */
static PetscErrorCode LookAtJump(MpmModel model, PetscReal next, MpmOutcome *outcome)
{
  MpmSlide       *slide = &model->state.scheme.slide;
  const PetscReal span = next - model->state.time, most = JUMP_RATIO * slide->force * slide->ways;

  PetscFunctionBeginUser;
  if (!(slide->ways > 0.) || slide->now.way * slide->forces <= most) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(FindFastest(model, &slide->now));
  if (slide->now.way <= JUMP_WAY * model->disc.grid->h[0] + slide->driven || slide->now.way * slide->forces <= most)
    PetscFunctionReturn(PETSC_SUCCESS);
  if (next > slide->end) {
    slide->end  = next;
    slide->span = span;
    slide->way  = slide->now.way;
  }
  slide->seen = slide->now;
  Describe(model, &slide->now, JUMPS, outcome);
  if (span <= 1.001 * PetscPowRealInt(0.5, JUMP_HALVES) * slide->span && slide->now.way >= JUMP_SHRINK * slide->way) {
    outcome->retryable = PETSC_FALSE;
    Describe(model, &slide->now, SLIDES, outcome);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSlideLook(MpmModel model, PetscReal next, MpmOutcome *outcome)
{
  MpmSlide *slide = &model->state.scheme.slide;

  PetscFunctionBeginUser;
  slide->now = (MpmFastest){.way = 0.};
  if (!MustStand(model)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(FindLongest(model, &slide->now.way));
  slide->force = model->solver.cache.reference;
  slide->dt    = next - model->state.time;
  PetscCall(FindDriven(model, next, &slide->driven));
  PetscCall(LookAtJump(model, next, outcome));
  if (!outcome->code) PetscCall(LookAtSum(model, outcome));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSlideAddRows(MpmModel model)
{
  MpmSlide    *slide  = &model->state.scheme.slide;
  const MpmRow rows[] = {
    {"slide_ways", MPM_ROW_REAL, MPM_ROW_RUN, &slide->ways, 0, 0},
    {"slide_forces", MPM_ROW_REAL, MPM_ROW_RUN, &slide->forces, 0, 0},
    {"slide_ratio", MPM_ROW_REAL, MPM_ROW_RUN, &slide->ratio, 0, 0},
    {"slide_steady_ways", MPM_ROW_REAL, MPM_ROW_RUN, &slide->steady[0], 0, 0},
    {"slide_steady_forces", MPM_ROW_REAL, MPM_ROW_RUN, &slide->steady[1], 0, 0},
    {"slide_steady_time", MPM_ROW_REAL, MPM_ROW_RUN, &slide->steady[2], 0, 0},
    {"slide_slid", MPM_ROW_REAL, MPM_ROW_RUN, &slide->slid, 0, 0},
    {"slide_end", MPM_ROW_REAL, MPM_ROW_RUN, &slide->end, 0, 0},
    {"slide_span", MPM_ROW_REAL, MPM_ROW_RUN, &slide->span, 0, 0},
    {"slide_way", MPM_ROW_REAL, MPM_ROW_RUN, &slide->way, 0, 0},
  };

  PetscFunctionBeginUser;
  PetscCall(MpmRowsAdd(model->state.rows, NULL, PETSC_STATIC_ARRAY_LENGTH(rows), rows));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MpmSlideObserve(MpmModel model)
{
  MpmSlide *slide = &model->state.scheme.slide;

  if (!(slide->now.way > 0.)) return;
  slide->last = slide->now;
  slide->slid =
    GoesOn(slide) || Exceeds(slide, FAR_RATIO) ? slide->slid + PetscMax(slide->now.way - slide->driven, 0.) : 0.;
  if (!(slide->slid > 0.) && !Exceeds(slide, JUMP_RATIO)) {
    slide->steady[0] += slide->now.way;
    slide->steady[1] += slide->force;
    slide->steady[2] += slide->dt;
  }
  slide->ratio =
    slide->ways > 0. && slide->force > 0. ? slide->now.way / slide->ways * slide->forces / slide->force : 0.;
  if (slide->ratio > JUMP_RATIO && model->state.time > slide->end) return;
  slide->ways += slide->now.way;
  slide->forces += slide->force;
}

PetscBool MpmSlideSuspects(const MpmModel model)
{
  return (PetscBool)(model->state.scheme.slide.seen.way > 0. &&
                     model->state.time <= model->state.scheme.slide.end + model->state.dt.nominal);
}

PetscErrorCode MpmSlideExplain(MpmModel model, MpmOutcome *outcome)
{
  const MpmSlide   *slide   = &model->state.scheme.slide;
  const MpmFastest *fastest = MpmSlideSuspects(model) ? &slide->seen : &slide->last;
  char              text[MPM_OUTCOME_TEXT];

  PetscFunctionBeginUser;
  if (!MustStand(model) || (!MpmSlideSuspects(model) && !(slide->ratio > JUMP_RATIO)))
    PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscStrncpy(text, strstr(outcome->text, " jumps by ") ? "" : outcome->text, sizeof(text)));
  Describe(model, fastest, SLIDES, outcome);
  PetscCall(MpmOutcomeExplain(outcome, "%s%s%s", outcome->text, text[0] ? "; " : "", text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

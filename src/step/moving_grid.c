/*
  The moving grid: the lattice of cells rescales or translates, along chosen axes, with a body, a motion or a boundary.

    grid: {follow: pile, axes: "y", mode: stretch, fixed: lower, at: 4}

  With d the displacement of the followed object since it was first there, `shift` moves the whole grid by d, and
  `stretch` keeps the side F where it is and scales the grid about it by 1 + d/(A - F): the lattice's place A, by
  default the other side, moves by d. The cells stay equal on each axis. Follow: Al-Kafaji (2013), Formulation of a
  dynamic material point method for geomechanical problems, University of Stuttgart.

  A step is taken on the grid that goes with its start, since the start is its reference: d is the mean displacement of
  the points then, of those of the motion or of the body, or that of the boundary's middle at the step's start. Nothing
  on the grid is remembered from step to step, so that a failed step has nothing to roll back, and the points find their
  cells again.
*/
#include "base/columns.h"
#include "options/options.h"
#include "grid/grid.h"
#include "particles/body.h"
#include "particles/particles.h"
#include "space/basis.h"
#include "space/space.h"
#include "space/sum.h"
#include "bc/body_motion.h"
#include "rigid/rigid.h"
#include "rigid/rigid_motion.h"
#include "contact/contact.h"
#include "query/model.h"
#include "scene/stage_lists.h"
#include "step/moving_grid.h"

#define FIELD    "follow" /* 1 at the points of a followed body */
#define SMALLEST 0.01     /* of the initial extent of the grid: least remainder */

/* ---- reading ---- */

static void FindFollowed(const MpmModel model, const char *name, MpmFollow *follow)
{
  const MpmScene *scene = &model->scene;

  follow->what  = MPM_FOLLOW_MOTION;
  follow->index = MpmStageFindName(scene->motions->count, scene->motions->names, name);
  if (follow->index >= 0) return;
  follow->what  = MPM_FOLLOW_BOUNDARY;
  follow->index = MpmStageFindName(scene->boundaries->count, scene->boundaries->names, name);
  if (follow->index >= 0) return;
  follow->what  = MPM_FOLLOW_BODY;
  follow->index = MpmStageFindName(scene->bodies->count, scene->bodies->names, name);
}

/* Axes by their letters. */
static PetscErrorCode ReadAxes(const MpmOptions *block, PetscInt dim, MpmFollow *follow, PetscInt *count)
{
  char **axes;

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsNames(block, "axes", "axes along which it follows: x, y, z", MPM_REQUIRED, count, &axes));
  for (PetscInt k = 0; k < *count; k++) {
    const PetscInt a = (PetscInt)(axes[k][0] - 'x');

    MpmCheckInput(!axes[k][1] && a >= 0 && a < dim, "-%saxes %s: must be among %.*s", block->prefix, axes[k],
                  (int)(3 * dim - 2), "x, y, z");
    follow->axis[a] = PETSC_TRUE;
  }
  PetscCall(MpmNamesDestroy(*count, &axes));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Which side stays: one word for all axes, or one an axis. */
static PetscErrorCode ReadFixed(const MpmOptions *block, PetscInt axes, MpmFollow *follow)
{
  static const char *const words[] = {"lower", "auto", "upper"};
  char                    *text, **word;
  PetscInt                 count, k = 0;

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsText(block, "fixed",
                           "side of the grid that stays where it is, in mode stretch: lower, upper, or auto (the one "
                           "further from what is followed at the start); one for all axes, or one an axis",
                           "auto", MPM_OPTIONAL, &text));
  if (!text || MpmOptionsHelp()) PetscFunctionReturn(PetscFree(text));
  PetscCall(MpmTextSplit(text, &count, &word));
  MpmCheckInput(count == 1 || count == axes, "-%sfixed %s: must be one word, or as many as axes, %" PetscInt_FMT,
                block->prefix, text, axes);
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    if (!follow->axis[a]) continue;
    follow->fixed[a] = 2;
    for (PetscInt w = 0; w < 3; w++)
      if (!strcmp(word[count == 1 ? 0 : k], words[w])) follow->fixed[a] = w - 1;
    MpmCheckInput(follow->fixed[a] < 2, "-%sfixed %s: must be lower, upper or auto", block->prefix, text);
    k++;
  }
  PetscCall(MpmNamesDestroy(count, &word));
  PetscCall(PetscFree(text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Plane that moves with the followed object: in the grid, and a cell at least from the side that stays. */
static PetscErrorCode ReadAt(const MpmOptions *block, const MpmGrid *grid, PetscInt axes, MpmFollow *follow)
{
  PetscReal at[MPM_MAX_DIM] = {0., 0., 0.};
  PetscInt  k               = 0;

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsReals(block, "at", "m",
                            "place in the grid that moves as what is followed, in mode stretch, one number an axis; "
                            "default: the side that does not stay",
                            MPM_RANGE_ANY, MPM_OPTIONAL, PetscMax(axes, 1), at, &follow->has_at));
  if (!follow->has_at || MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    if (!follow->axis[a]) continue;
    const PetscReal least = grid->lower[a] + (follow->fixed[a] < 0 ? grid->h[a] * (1. - MPM_TOLERANCE) : 0.),
                    most  = grid->upper[a] - (follow->fixed[a] > 0 ? grid->h[a] * (1. - MPM_TOLERANCE) : 0.);

    follow->at[a] = at[k++];
    MpmCheckInput(follow->at[a] >= least && follow->at[a] <= most,
                  "-%sat %g on axis %c: must be in the grid, [%g, %g], and a cell from the side that stays",
                  block->prefix, (double)follow->at[a], "xyz"[a], (double)grid -> lower[a], (double)grid -> upper[a]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode AddRows(MpmModel model)
{
  MpmGridMotion *motion = &model->state.grid;
  const MpmRow   rows[] = {
      {"grid_known", MPM_ROW_BOOL, MPM_ROW_STATE, &motion->known, 0, 0},
      {"grid_start_x", MPM_ROW_REAL, MPM_ROW_STATE, &motion->start[0], 0, 0},
      {"grid_start_y", MPM_ROW_REAL, MPM_ROW_STATE, &motion->start[1], 0, 0},
      {"grid_start_z", MPM_ROW_REAL, MPM_ROW_STATE, &motion->start[2], 0, 0},
      {"grid_moved_x", MPM_ROW_REAL, MPM_ROW_STATE, &motion->moved[0], 0, 0},
      {"grid_moved_y", MPM_ROW_REAL, MPM_ROW_STATE, &motion->moved[1], 0, 0},
      {"grid_moved_z", MPM_ROW_REAL, MPM_ROW_STATE, &motion->moved[2], 0, 0},
  };

  PetscFunctionBeginUser;
  PetscCall(MpmRowsAdd(model->state.rows, NULL, PETSC_STATIC_ARRAY_LENGTH(rows), rows));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode FillBounds(MpmModel model, const MpmColumn *column, PetscReal values[])
{
  PetscFunctionBeginUser;
  values[0] = model->disc.grid->lower[column->index];
  values[1] = model->disc.grid->upper[column->index];
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmMovingGridAddColumns(MpmModel model, MpmColumns *columns)
{
  static const char *const parts[MPM_MAX_DIM][2] = {
    {"lower_x", "upper_x"}, {"lower_y", "upper_y"}, {"lower_z", "upper_z"}};

  PetscFunctionBeginUser;
  for (PetscInt a = 0; a < model->disc.dim; a++) {
    const MpmColumn row = {"grid", "m", 2, parts[a], FillBounds, NULL, a};

    if (model->scene.follow.axis[a]) PetscCall(MpmColumnsAdd(columns, NULL, &row));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmMovingGridRead(MpmModel model, const MpmOptions *options)
{
  static const char *const modes[] = {"stretch", "shift", NULL};
  const MpmOptions         block   = {options->comm, "mpm_grid_", options->record};
  MpmFollow               *follow  = &model->scene.follow;
  PetscInt                 axes = 0, mode = 0;
  char                    *name;

  PetscFunctionBeginUser;
  PetscCall(AddRows(model));
  PetscCall(
    MpmOptionsText(&block, "follow", "motion, boundary or body that the grid moves with", NULL, MPM_OPTIONAL, &name));
  if (!name && !MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(ReadAxes(&block, model->disc.dim, follow, &axes));
  PetscCall(MpmOptionsWord(&block, "mode",
                           "stretch: one side stays, and the cells change their size; shift: the grid moves as a whole",
                           modes, MPM_OPTIONAL, &mode, NULL));
  follow->stretch = (PetscBool)(mode == 0);
  if (follow->stretch || MpmOptionsHelp()) {
    PetscCall(ReadFixed(&block, axes, follow));
    PetscCall(ReadAt(&block, model->disc.grid, axes, follow));
  }
  if (!MpmOptionsHelp()) {
    FindFollowed(model, name, follow);
    MpmCheckInput(follow->index >= 0, "-mpm_grid_follow %s: there is no motion, boundary or body of this name", name);
  }
  PetscCall(PetscFree(name));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- points ---- */

const char *MpmMovingGridField(const MpmModel model)
{
  return model->scene.follow.what == MPM_FOLLOW_BODY ? FIELD : NULL;
}

PetscErrorCode MpmMovingGridSelect(MpmModel model)
{
  MpmParticles *particles = model->state.particles;
  PetscInt      count, *id, first, end;
  PetscReal    *share;

  PetscFunctionBeginUser;
  if (!MpmMovingGridField(model)) PetscFunctionReturn(PETSC_SUCCESS);
  MpmBodyGetIds(model->scene.bodies->at[model->scene.follow.index], &first, &end);
  PetscCall(DMSwarmGetLocalSize(particles->swarm, &count));
  PetscCall(MpmParticlesGetField(particles, FIELD, &share));
  PetscCall(MpmParticlesGetField(particles, "id", &id));
  for (PetscInt p = 0; p < count; p++) share[p] = id[p] >= first && id[p] < end ? 1. : 0.;
  PetscCall(MpmParticlesRestoreField(particles, &id));
  PetscCall(MpmParticlesRestoreField(particles, &share));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The mean of the marked points' places less `from`; `there`: there are some. */
static PetscErrorCode MeanPlace(MpmModel model, const char *field, const PetscReal from[], PetscReal mean[],
                                PetscBool *there)
{
  const PetscInt dim       = model->disc.dim;
  MpmParticles  *particles = model->state.particles;
  PetscReal     *share, *x, sum[MPM_MAX_DIM + 1] = {0., 0., 0., 0.};
  PetscInt       count;

  PetscFunctionBeginUser;
  PetscCall(DMSwarmGetLocalSize(particles->swarm, &count));
  PetscCall(MpmParticlesGetField(particles, field, &share));
  PetscCall(MpmParticlesGetField(particles, "position", &x));
  for (PetscInt p = 0; p < count; p++) {
    if (share[p] == 0.) continue;
    sum[MPM_MAX_DIM] += 1.;
    for (PetscInt a = 0; a < dim; a++) sum[a] += x[p * dim + a] - from[a];
  }
  PetscCall(MpmParticlesRestoreField(particles, &x));
  PetscCall(MpmParticlesRestoreField(particles, &share));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, sum, MPM_MAX_DIM + 1, MPIU_REAL, MPIU_SUM, model->comm));
  *there = (PetscBool)(sum[MPM_MAX_DIM] > 0.);
  for (PetscInt a = 0; a < dim && *there; a++) mean[a] = sum[a] / sum[MPM_MAX_DIM];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Where the followed boundary's middle is at a time; a free one with its placement, or after the step's unknowns u. */
static void BoundaryPlace(const MpmModel model, PetscReal time, const PetscReal *u, PetscReal place[])
{
  const PetscInt     b         = model->scene.follow.index;
  const MpmBoundary *boundary  = &model->scene.boundaries->at[b];
  const MpmPose      pose      = MpmBoundaryPose(boundary, time);
  MpmPlacement       placement = model->state.placements[b];

  if (u) MpmBoundaryAdvance(model->disc.context.contacts, b, model->disc.block, u, &placement);
  MpmBoundaryMiddle(boundary, &pose, &placement, place);
}

/* The field of the points that are followed. */
static const char *Field(const MpmModel model)
{
  const MpmFollow *follow = &model->scene.follow;

  return follow->what == MPM_FOLLOW_MOTION ? model->scene.motions->at[follow->index].share_field : FIELD;
}

/* Place of the followed object at the step's start, less `from`. */
static PetscErrorCode FindPlace(MpmModel model, const PetscReal from[], PetscReal place[], PetscBool *there)
{
  const MpmFollow *follow = &model->scene.follow;

  PetscFunctionBeginUser;
  *there = PETSC_TRUE;
  if (follow->what == MPM_FOLLOW_BOUNDARY) {
    BoundaryPlace(model, model->state.time, NULL, place);
    for (PetscInt a = 0; a < model->disc.dim; a++) place[a] -= from[a];
  } else PetscCall(MeanPlace(model, Field(model), from, place, there));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The mean displacement of the marked points by the solution of the step. */
static PetscErrorCode MeanIncrement(MpmModel model, PetscReal mean[])
{
  const MpmSpace *space = model->disc.space;
  const PetscInt  dim   = model->disc.dim;
  PetscReal      *share, sum[MPM_MAX_DIM + 1] = {0., 0., 0., 0.};
  MpmBasis        basis;

  PetscFunctionBeginUser;
  PetscCall(MpmBasisCreate(space, &basis));
  PetscCall(MpmParticlesGetField(model->state.particles, Field(model), &share));
  for (PetscInt g = 0; g < space->group_count; g++) {
    const MpmGroup *group = &space->groups[g];

    for (PetscInt s = group->point_begin; s < group->point_end; s++) {
      if (share[space->order[s]] == 0.) continue;
      MpmSpaceEvaluate(space, group, space->order[s], &basis);
      sum[MPM_MAX_DIM] += 1.;
      MpmBasisInterpolate(space, group, &basis, model->disc.block, model->disc.nodal.u, dim, sum);
    }
  }
  PetscCall(MpmParticlesRestoreField(model->state.particles, &share));
  PetscCall(MpmBasisDestroy(&basis));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, sum, MPM_MAX_DIM + 1, MPIU_REAL, MPIU_SUM, model->comm));
  for (PetscInt a = 0; a < dim; a++) mean[a] = sum[MPM_MAX_DIM] > 0. ? sum[a] / sum[MPM_MAX_DIM] : 0.;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the grid ---- */

/* The lattice's plane that moves with the followed object, and the side that stays. */
static void FindEnds(const MpmModel model, PetscInt a, PetscReal *at, PetscReal *fixed)
{
  const MpmFollow *follow = &model->scene.follow;
  const MpmGrid   *grid   = model->disc.grid;
  const PetscReal  place  = follow->has_at ? follow->at[a] : model->state.grid.start[a];
  const PetscReal  slack  = MPM_TOLERANCE * (grid->start_upper[a] - grid->start_lower[a]); /* sums over ranks round */
  PetscInt         side   = follow->fixed[a];

  if (!side) side = grid->start_upper[a] - place <= place - grid->start_lower[a] + slack ? -1 : 1;
  *fixed = side < 0 ? grid->start_lower[a] : grid->start_upper[a];
  *at    = follow->has_at ? follow->at[a] : side < 0 ? grid->start_upper[a] : grid->start_lower[a];
}

/* The grid where the followed object has moved by so much. */
static void PlaceBy(const MpmModel model, const PetscReal moved[], MpmGrid *grid)
{
  const MpmFollow *follow = &model->scene.follow;
  PetscReal        lower[MPM_MAX_DIM], upper[MPM_MAX_DIM];
  PetscBool        any = grid->moved;

  for (PetscInt a = 0; a < grid->dim; a++) {
    const PetscReal d = follow->axis[a] ? moved[a] : 0.;
    PetscReal       at, fixed;

    lower[a] = grid->start_lower[a];
    upper[a] = grid->start_upper[a];
    if (d == 0.) continue;
    any = PETSC_TRUE;
    if (follow->stretch) {
      FindEnds(model, a, &at, &fixed);
      if (fixed == lower[a]) upper[a] += d * (upper[a] - lower[a]) / (at - fixed);
      else lower[a] += d * (lower[a] - upper[a]) / (at - fixed);
    } else {
      lower[a] += d;
      upper[a] += d;
    }
  }
  if (any) MpmGridPlace(grid, lower, upper);
}

PetscErrorCode MpmMovingGridNext(MpmModel model, MpmGrid *next)
{
  const MpmFollow *follow = &model->scene.follow;
  PetscReal        moved[MPM_MAX_DIM];

  PetscFunctionBeginUser;
  *next = *model->disc.grid;
  if (follow->what == MPM_FOLLOW_NOTHING) PetscFunctionReturn(PETSC_SUCCESS);
  if (follow->what == MPM_FOLLOW_BOUNDARY) {
    BoundaryPlace(model, model->state.time + model->disc.sum->step.span, model->disc.nodal.u, moved);
    for (PetscInt a = 0; a < model->disc.dim; a++) moved[a] -= model->state.grid.start[a];
  } else {
    PetscCall(MeanIncrement(model, moved));
    for (PetscInt a = 0; a < model->disc.dim; a++) moved[a] += model->state.grid.moved[a];
  }
  PlaceBy(model, moved, next);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Points that stand on the grid's edge but for rounding are put there. */
static PetscErrorCode ForgiveRounding(MpmModel model)
{
  const MpmGrid *grid      = model->disc.grid;
  MpmParticles  *particles = model->state.particles;
  PetscReal     *x;
  PetscInt       count;

  PetscFunctionBeginUser;
  PetscCall(DMSwarmGetLocalSize(particles->swarm, &count));
  PetscCall(MpmParticlesGetField(particles, "position", &x));
  for (PetscInt k = 0; k < count * grid->dim; k++) {
    const PetscInt  a    = k % grid->dim;
    const PetscReal edge = PetscMin(PetscMax(x[k], grid->lower[a]), grid->upper[a]);

    if (PetscAbsReal(x[k] - edge) <= MPM_GRID_SLACK * grid->h[a]) x[k] = edge;
  }
  PetscCall(MpmParticlesRestoreField(particles, &x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* True where the remaining extent of the grid is too small. */
static PetscBool IsSqueezed(const MpmModel model, PetscInt *axis)
{
  const MpmGrid *grid = model->disc.grid;

  for (*axis = 0; *axis < grid->dim; ++*axis)
    if (!(grid->upper[*axis] - grid->lower[*axis] >= SMALLEST * (grid->start_upper[*axis] - grid->start_lower[*axis])))
      return PETSC_TRUE;
  return PETSC_FALSE;
}

PetscErrorCode MpmMovingGridFollow(MpmModel model, MpmOutcome *outcome)
{
  const PetscReal zero[MPM_MAX_DIM] = {0., 0., 0.};
  MpmGridMotion  *motion            = &model->state.grid;
  PetscReal       place[MPM_MAX_DIM];
  PetscBool       there;
  PetscInt        axis;

  PetscFunctionBeginUser;
  MpmOutcomeClear(outcome);
  if (model->scene.follow.what == MPM_FOLLOW_NOTHING) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(FindPlace(model, motion->known ? motion->start : zero, place, &there));
  if (!there) PetscFunctionReturn(PETSC_SUCCESS); /* a body that is not there yet, or no longer: the grid stays */
  PetscCall(PetscArraycpy(motion->known ? motion->moved : motion->start, place, model->disc.dim));
  motion->known = PETSC_TRUE;
  PlaceBy(model, motion->moved, model->disc.grid);
  PetscCall(ForgiveRounding(model));
  if (!IsSqueezed(model, &axis)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmOutcomeFail(outcome, MPM_OUTCOME_OUTSIDE,
                           "the moving grid is squeezed to less than %g of its extent along %c", SMALLEST,
                           "xyz"[axis]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

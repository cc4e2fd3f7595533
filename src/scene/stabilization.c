/*
  Stabilization of the discrete problem: the ghost penalty against small cuts and, on all faces, against rows of cells
  that shear on their own (ghost_penalty.c), F-bar against volumetric locking (cell_mean.c), smoothed strains
  (grid/shape.h) and division of points (divide.c), and the choice of `auto`.

  Volumetric locking: where material hardly changes its volume, or flows plastically so that its volume follows from its
  shear, a low-order grid has more such conditions than unknowns that could meet them, and is too stiff. Limit loads and
  factors of safety are then too high, on the unsafe side, at any dilation (slope of Griffiths and Lane 1999,
  doi:10.1680/geot.1999.49.3.387, example 1, 20 cells a height: 1.52 to 1.6 without F-bar, 1.36 with it). Therefore
  `auto` takes F-bar where any law flows or has a Poisson's ratio above 0.45.

  Where flow dilates, one volume change for all points of a cell is too much: each would have to grow as the most
  sheared one. Splines of degree 2 and more have unknowns enough for such flow, and need no F-bar where every law that
  flows dilates. With linear basis functions, in plane strain, F-bar leaves to the points the dilation of `mohr_coulomb`
  by shear (physics/solid_fbar.c); where steps fail, as in long slides, it averages all from there on.

  Where material flows round a body in contact, points are drawn apart in its wake, and cells without any carry nothing:
  points are divided there (divide.c).

  Where no more than one component of the displacement is free, as in a column between smooth walls, the volume changes
  with that component alone, nothing can lock, and the mean over a cell would only cost accuracy.
*/
#include "talus/point/basal.h"
#include "options/options.h"
#include "geometry/geometry.h"
#include "point/layout.h"
#include "point/material.h"
#include "point/registry.h"
#include "grid/grid.h"
#include "particles/body.h"
#include "space/rules.h"
#include "bc/bc.h"
#include "rigid/rigid.h"
#include "loads/load.h"
#include "query/model.h"
#include "query/query.h"
#include "scene/integrator_read.h"
#include "scene/scene_read.h"

/* Words for -mpm_stabilization_fbar; behind `auto` true and false in turn, and at last two more for
   true. */
static const char *const fbar_words[] = {"auto", "true", "false", "yes",   "no",     "on",
                                         "off",  "1",    "0",     "plain", "spread", NULL};
#define FBAR_PLAIN  9
#define FBAR_SPREAD 10

/* The share of its mean over pieces in the strain of a point. */
static PetscErrorCode ReadSmooth(MpmModel model, const MpmOptions *block)
{
  char *smooth;

  PetscFunctionBeginUser;
  PetscCall(
    MpmOptionsText(block, "smooth",
                   "solid: share of the mean over cells (splines of even degree: the cells around nodes) in the "
                   "strain of a point: auto (0) or a number in [0, 0.9]",
                   "auto", MPM_OPTIONAL, &smooth));
  model->scene.stabilization.smooth = 0.;
  if (smooth && strcmp(smooth, "auto"))
    MpmCheckInput(MpmParseReal(smooth, &model->scene.stabilization.smooth) && model->scene.stabilization.smooth >= 0. &&
                    model->scene.stabilization.smooth <= 0.9,
                  "-mpm_stabilization_smooth %s: must be auto or a share in [0, 0.9]", smooth);
  PetscCall(PetscFree(smooth));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* How long a point's domain may become. */
static PetscErrorCode ReadDivide(MpmModel model, const MpmOptions *block)
{
  char *divide;

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsText(block, "divide",
                           "solid without inertia, or with elements of order 2 to 4: a point whose domain has been "
                           "drawn out over more cells than this becomes two, side by side: auto (without a load of "
                           "type traction: 0.6 where a boundary has contact bilateral, 1.2/(p + 1) with elements of "
                           "order p where nothing flows plastically, or with inertia; else off), off, or "
                           "a number in [0.1, 10] (pipe pulled through clay by its diameter, 2 x 2 points a cell: "
                           "resistance within 4.5 % of its mean with off, 1.6 % with 0.6)",
                           "auto", MPM_OPTIONAL, &divide));
  model->scene.stabilization.divide_auto = (PetscBool)(!divide || !strcmp(divide, "auto"));
  model->scene.stabilization.divide      = 0.;
  if (!model->scene.stabilization.divide_auto && strcmp(divide, "off"))
    MpmCheckInput(MpmParseReal(divide, &model->scene.stabilization.divide) &&
                    model->scene.stabilization.divide >= 0.1 && model->scene.stabilization.divide <= 10.,
                  "-mpm_stabilization_divide %s: must be auto, off or a number of cells in [0.1, 10]", divide);
  PetscCall(PetscFree(divide));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* MPM_FILLED of elements of order 3 and 4: polynomials of degree 3 tear with less than nearly all of their points. */
#define FILLED_3 0.9

/* True where any stage takes explicit steps, in which no node follows others. */
static PetscBool AnyExplicit(const MpmModel model)
{
  for (PetscInt k = 0; k < model->scene.stages.count; k++)
    if (model->scene.stages.at[k].time.motion.type == MPM_EXPLICIT) return PETSC_TRUE;
  return PETSC_FALSE;
}

/*
  A polynomial of degree p grows as the p-th power of the distance from the part of a cell that points fill. Points of a
  physics without displacement stand anywhere in whole cells, of which they fill less near the grid's edge. Splines of
  degree 2 have a node beyond a surface on a row of nodes, where F-bar leaves the half of a span, and two nodes, one
  volume change: in a geostatic state no stress there without tension is in balance. In explicit steps no node follows
  either way, and the stages before them have the same balance.
*/
static PetscReal DefaultFilled(const MpmModel model)
{
  const MpmShapeType shape = model->scene.shape.type;
  PetscInt           order = MpmShapeOrder(shape);

  if (!model->scene.stabilization.ghost_auto) return 0.;
  if (!model->disc.layout->motion) order = 1;
  else if (model->scene.stabilization.fbar && MpmShapeDegree(shape) == 2 && MpmStagesAreGeostatic(model) &&
           !AnyExplicit(model))
    order = 2;
  return order > 2 ? FILLED_3 : PetscPowReal(MPM_FILLED, 1. / (PetscReal)order);
}

/* Read again once F-bar is settled, for its default. */
static PetscErrorCode ReadFilled(MpmModel model, const MpmOptions *block)
{
  PetscFunctionBeginUser;
  model->scene.stabilization.filled = DefaultFilled(model);
  PetscCall(MpmOptionsReal(
    block, "filled", "-",
    "aggregation of small-cut nodes: those of cells (splines of even degree: cells around nodes) that the material "
    "fills to less than this share of the fullest one beside follow well filled ones by extrapolation; 0.35, "
    "elements of order 2, and splines of degree 2 with F-bar from a geostatic state, its root, elements of more 0.9; "
    "0: no node does, the default where ghost is not auto (bar pulled by its end nodes by 8 % of a cell: reaction "
    "exact to 0.3 %, 19 % less with 0)",
    MPM_RANGE_NON_NEGATIVE, MPM_OPTIONAL, &model->scene.stabilization.filled, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmStabilizationRead(MpmModel model, const MpmOptions *options)
{
  const MpmOptions block = {options->comm, "mpm_stabilization_", options->record};
  PetscInt         word  = 0;
  char            *ghost;

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsHeading(&block, "Stabilization"));
  PetscCall(MpmOptionsText(
    &block, "ghost",
    "penalty on the step's increment across the faces of edge cells: auto (1e-1 on all faces where bodies have "
    "one point a cell, else none), off, or a factor times Young's modulus: a viscosity in steps, in place of "
    "aggregation unless `filled` is set too",
    "auto", MPM_OPTIONAL, &ghost));
  model->scene.stabilization.ghost_auto = (PetscBool)(!ghost || !strcmp(ghost, "auto"));
  model->disc.matrix.ghost              = 0.;
  if (!model->scene.stabilization.ghost_auto && strcmp(ghost, "off")) {
    MpmCheckInput(MpmParseReal(ghost, &model->disc.matrix.ghost) && model->disc.matrix.ghost >= 0.,
                  "-mpm_stabilization_ghost %s: must be auto, off or a factor >= 0", ghost);
  }
  PetscCall(PetscFree(ghost));
  PetscCall(ReadFilled(model, &block));
  PetscCall(
    MpmOptionsReal(&block, "interior", "-",
                   "penalty like ghost on the displacement over all faces between cells, times Young's modulus: "
                   "holds rows of cells that would shear by themselves where dilation is less than friction; 0 "
                   "for none (cavity in sand expanded by a fifth, cells of an eighth of its radius: error of the "
                   "pressure 0.5 % with 0, 0.05 % with 0.1)",
                   MPM_RANGE_NON_NEGATIVE, MPM_OPTIONAL, &model->scene.stabilization.interior, NULL));
  PetscCall(MpmOptionsWord(
    &block, "fbar",
    "average the volume change over cells, against locking: auto (where a law flows "
    "plastically or nu is above 0.45, unless only one component of the displacement is free), "
    "true or false (factor of safety of a slope, 1.35 to 1.40 in publications: 1.52 without, "
    "1.37 with). In plane strain the dilation of mohr_coulomb by shear is left to each point; "
    "plain averages that, too (Nc of a footing, dilation = friction = 30 degrees, exact 30.1: "
    "29.0, 32.5 and rising with plain, 35.1 with false). spread is true with a point's domain in every cell that it "
    "lies in by its share, so that results do not jump where a point changes its cell (shapes "
    "with domains)",
    fbar_words, MPM_OPTIONAL, &word, NULL));
  PetscCall(ReadSmooth(model, &block));
  PetscCall(ReadDivide(model, &block));
  PetscCall(MpmStabilityRead(&model->solver, options));
  model->scene.stabilization.fbar_auto   = (PetscBool)(word == 0);
  model->scene.stabilization.fbar        = (PetscBool)(word % 2 == 1 || word == FBAR_SPREAD);
  model->scene.stabilization.fbar_plain  = (PetscBool)(word == FBAR_PLAIN);
  model->scene.stabilization.fbar_spread = (PetscBool)(word == FBAR_SPREAD);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The box of all bodies' cells; the grid's where points come from a file. */
static PetscErrorCode FindBox(const MpmModel model, PetscReal lower[], PetscReal upper[])
{
  const MpmGrid *grid               = model->disc.grid;
  PetscInt       first[MPM_MAX_DIM] = {PETSC_INT_MAX, PETSC_INT_MAX, PETSC_INT_MAX}, end[MPM_MAX_DIM] = {0, 0, 0};
  PetscReal      points;
  PetscBool      whole = PETSC_FALSE;

  PetscFunctionBeginUser;
  for (PetscInt b = 0; b < model->scene.bodies->count; b++) {
    whole = (PetscBool)(whole || MpmBodyIsImported(model->scene.bodies->at[b]));
    PetscCall(MpmBodyEstimate(model->scene.bodies->at[b], grid, first, end, &points));
  }
  for (PetscInt a = 0; a < grid->dim; a++) {
    lower[a] = whole ? grid->lower[a] : grid->lower[a] + grid->h[a] * (PetscReal)first[a];
    upper[a] = whole ? grid->upper[a] : grid->lower[a] + grid->h[a] * (PetscReal)end[a];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* True where the condition prescribes the component at every node of the box, in all stages. */
static PetscBool Prescribes(const MpmModel model, PetscInt b, PetscInt component, const PetscReal lower[],
                            const PetscReal upper[])
{
  const MpmCondition *bc  = &model->scene.bcs->at[b];
  PetscBool           has = PETSC_FALSE;

  for (PetscInt k = 0; k < bc->component_count && !bc->inclined && !bc->absorbing; k++)
    has = (PetscBool)(has || bc->component[k] == component);
  for (PetscInt k = 0; k < model->scene.stages.count; k++) has = (PetscBool)(has && model->scene.stages.at[k].bcs[b]);
  return (PetscBool)(has && MpmRegionGetType(bc->region) <= MPM_REGION_BOX && MpmRegionContains(bc->region, lower) &&
                     MpmRegionContains(bc->region, upper));
}

/* How many components of the displacement no condition prescribes everywhere. */
static PetscErrorCode CountFree(const MpmModel model, PetscInt *count)
{
  PetscReal lower[MPM_MAX_DIM], upper[MPM_MAX_DIM];

  PetscFunctionBeginUser;
  *count = model->disc.dim;
  PetscCall(FindBox(model, lower, upper));
  for (PetscInt a = 0; a < model->disc.dim; a++) {
    PetscBool prescribed = PETSC_FALSE;

    for (PetscInt b = 0; b < model->scene.bcs->count && !prescribed; b++)
      prescribed = Prescribes(model, b, a, lower, upper);
    if (prescribed) --*count;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Choice of `auto` for F-bar, and its reason. */
static PetscErrorCode ChooseFbar(MpmModel model)
{
  const MpmMaterial *locks   = NULL;
  PetscBool          follows = PETSC_FALSE; /* a spline follows a law's flow without F-bar */
  PetscInt           count;

  PetscFunctionBeginUser;
  for (PetscInt m = 0; m < model->scene.materials->count && !locks; m++) {
    const MpmMaterial *material = &model->scene.materials->at[m];
    const PetscBool    plastic  = (PetscBool)((material->info.traits & MPM_LAW_PLASTIC) != 0);
    const PetscBool    free     = (PetscBool)(plastic && material->dilation.least >= MPM_DILATION_FREE &&
                                       MpmShapeDegree(model->scene.shape.type) > 1);

    follows = (PetscBool)(follows || free);
    if ((plastic && !free) || material->moduli.nu > MPM_NU_LOCKS) locks = material;
  }
  model->scene.stabilization.fbar_why =
    follows ? "splines follow plastic flow that dilates" : "no law flows or is nearly incompressible";
  if (!locks) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(CountFree(model, &count));
  model->scene.stabilization.fbar     = (PetscBool)(count > 1);
  model->scene.stabilization.fbar_why = !model->scene.stabilization.fbar       ? "one free component: nothing locks"
                                        : locks->info.traits & MPM_LAW_PLASTIC ? "plastic flow would lock"
                                                                               : "nu above 0.45 would lock";
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* True where F-bar leaves to the points the material's dilation by shear. */
static PetscBool LeavesDilation(const MpmModel model, const MpmMaterial *material)
{
  return (PetscBool)(model->scene.deformation.kinematics == MPM_PLANE_STRAIN &&
                     !model->scene.stabilization.fbar_plain && material->info.dilatancy &&
                     material->dilation.most > 0.);
}

/*
  Halves have the velocity of the whole, which keeps momentum and energy; water, and affine velocities, are not divided.
  Nothing holds the modes of an element whose points are too far apart against lasting loads: with inertia, and where it
  does not flow, the material tears.
*/
static PetscErrorCode SettleDivide(MpmModel model)
{
  const PetscInt  order   = MpmShapeOrder(model->scene.shape.type);
  const PetscBool dynamic = MpmStagesAreDynamic(model);
  const PetscBool could   = (PetscBool)(model->disc.layout->traits.solid && (!dynamic || order > 1));
  PetscBool       drawn   = (PetscBool)(could && order > 1), wants;

  PetscFunctionBeginUser;
  for (PetscInt m = 0; !dynamic && m < model->scene.materials->count; m++)
    if (model->scene.materials->at[m].info.traits & MPM_LAW_PLASTIC) drawn = PETSC_FALSE;
  MpmCheckInput(could || model->scene.stabilization.divide == 0.,
                "-mpm_stabilization_divide %g: must be auto or off with %s", (double)model->scene.stabilization.divide,
                model->disc.layout->traits.solid ? "inertia" : model->scene.physics.name);
  wants = drawn;
  for (PetscInt b = 0; b < model->scene.boundaries->count; b++)
    if (model->scene.boundaries->at[b].bilateral) wants = could;
  for (PetscInt l = 0; l < model->scene.loads->count; l++)
    if (model->scene.loads->at[l].type == MPM_LOAD_TRACTION) wants = PETSC_FALSE;
  if (wants && model->scene.stabilization.divide_auto)
    model->scene.stabilization.divide = drawn ? 1.2 / (PetscReal)(order + 1) : MPM_DIVIDE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmStabilizationSettle(MpmModel model, const MpmOptions *options)
{
  const MpmOptions block   = {options->comm, "mpm_stabilization_", options->record};
  const MpmPhysics physics = model->scene.physics;
  PetscBool        found;

  PetscFunctionBeginUser;
  if (MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  MpmCheckInput(model->scene.stabilization.smooth == 0. ||
                  (model->disc.layout->traits.solid && !(physics.traits & MPM_PHYSICS_COLUMNS)),
                "-mpm_stabilization_smooth %g: not available for physics %s, must be auto or 0",
                (double)model->scene.stabilization.smooth, model->scene.physics.name);
  PetscCall(SettleDivide(model));
  if (model->scene.stabilization.fbar_auto && physics.fbar) PetscCall(ChooseFbar(model));
  MpmCheckInput(physics.fbar || !model->scene.stabilization.fbar,
                "-mpm_stabilization_fbar %s: not available for physics %s, must be auto or false",
                model->scene.stabilization.fbar_spread ? "spread" : "true", model->scene.physics.name);
  MpmCheckInput(!model->scene.stabilization.fbar_spread || MpmShapeHasDomain(model->scene.shape.type),
                "-mpm_stabilization_fbar spread: must be auto, true, false or plain with -mpm_shape %s, whose points "
                "have no domains",
                MpmShapeName(model->scene.shape.type));
  PetscCall(ReadFilled(model, &block));
  if (!model->scene.stabilization.fbar) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmPhysicsCreate(physics.fbar, &model->scene.physics, &found));
  PetscCheck(found, model->comm, PETSC_ERR_PLIB, "physics %s is not compiled in", physics.fbar);
  model->scene.physics.name = physics.name;
  for (PetscInt m = 0; m < model->scene.materials->count; m++) {
    MpmMaterial *material = &model->scene.materials->at[m];

    if (!LeavesDilation(model, material)) continue;
    material->dilatancy          = material->info.dilatancy;
    model->state.rescue.dilation = PETSC_TRUE;
  }
  PetscCall(MpmLayoutCreate(&model->scene.physics, (PetscInt)model->scene.deformation.kinematics, model->disc.layout));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Active stabilization and its reasons, for the header of a run. */
PetscErrorCode MpmStabilizationText(const MpmModel model, size_t length, char text[])
{
  char      cuts[64] = "no aggregation", ghost[64] = "", interior[64] = "", smooth[80] = "", divide[64] = "";
  PetscBool sparse = PETSC_FALSE;

  PetscFunctionBeginUser;
  for (PetscInt m = 0; m < model->scene.materials->count; m++)
    sparse =
      (PetscBool)(sparse || MpmShapeSpacing(model->scene.shape.type, model->scene.materials->at[m].spacing) >= 1.);
  if (model->scene.stabilization.filled > 0. && MpmStagesSolve(model))
    PetscCall(PetscSNPrintf(cuts, sizeof(cuts), "aggregation of cells filled below %g",
                            (double)model->scene.stabilization.filled));
  if (model->disc.matrix.ghost > 0. && MpmStagesSolve(model))
    PetscCall(PetscSNPrintf(ghost, sizeof(ghost), "; ghost penalty %g", (double)model->disc.matrix.ghost));
  else if (sparse && model->scene.stabilization.ghost_auto && MpmStagesSolve(model))
    PetscCall(PetscSNPrintf(ghost, sizeof(ghost), "; ghost penalty %g (auto: %s)", MPM_GHOST_SPARSE,
                            MpmShapeOrder(model->scene.shape.type) > 1 ? "few points a cell" : "one point a cell"));
  if (model->scene.stabilization.interior > 0. && MpmStagesSolve(model))
    PetscCall(
      PetscSNPrintf(interior, sizeof(interior), "; interior penalty %g", (double)model->scene.stabilization.interior));
  if (model->scene.stabilization.smooth > 0.)
    PetscCall(
      PetscSNPrintf(smooth, sizeof(smooth), "; strains smoothed by %g", (double)model->scene.stabilization.smooth));
  if (model->scene.stabilization.divide > 0.)
    PetscCall(PetscSNPrintf(divide, sizeof(divide), "; points divided over %g cells%s",
                            (double)model->scene.stabilization.divide,
                            model->scene.stabilization.divide_auto ? " (auto)" : ""));
  PetscCall(PetscSNPrintf(text, length, "%s%s%s; F-bar %s%s%s%s%s%s%s", cuts, ghost, interior,
                          !model->scene.stabilization.fbar         ? "off"
                          : model->scene.stabilization.fbar_spread ? "spread"
                                                                   : "on",
                          model->state.rescue.dilation ? " but for dilation" : "",
                          model->scene.stabilization.fbar_why ? " (auto: " : "",
                          model->scene.stabilization.fbar_why ? model->scene.stabilization.fbar_why : "",
                          model->scene.stabilization.fbar_why ? ")" : "", smooth, divide));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  The scene of a model, read from its options.
*/
#include "options/options.h"
#include "options/record.h"
#include "ground/ground.h"
#include "point/layout.h"
#include "point/material.h"
#include "point/registry.h"
#include "grid/grid.h"
#include "grid/shape.h"
#include "grid/walls.h"
#include "particles/body.h"
#include "bc/bc.h"
#include "bc/body_motion.h"
#include "volume/added_term.h"
#include "volume/irreversible.h"
#include "rigid/rigid.h"
#include "contact/rigid_body.h"
#include "pairs/body_contact.h"
#include "loads/body_surface.h"
#include "loads/load.h"
#include "query/model.h"
#include "query/query.h"
#include "scene/integrator_read.h"
#include "scene/scene_read.h"
#include "scene/stage_lists.h"
#include "scene/stage_read.h"
#include "scene/terrain_read.h"
#include "step/energy.h"
#include "step/moving_grid.h"
#include "step/water_state.h"
#include "integrators/consolidation.h"
#include "integrators/dynamics.h"
#include "integrators/relaxation.h"
#include "integrators/time_error.h"
#include "schedule/reduction.h"
#include "schedule/rescue.h"
#include "schedule/schedule.h"
#include "schedule/settle.h"
#include "schedule/stage.h"
#include "geostatic/geostatic.h"
#include "entrainment/entrainment.h"
#include "runout/runout.h"
#include "observe/lines.h"
#include "observe/results.h"
#include "observe/tracks.h"
#include "sensitivity/gradient.h"
#include "checkpoint/checkpoint.h"
#include "ensemble/ensemble.h"
#include "model/build.h"
#include "laboratory/laboratory.h"

/* ---- the scene ---- */

/* The physics of that name, and the layout of its unknowns. */
static PetscErrorCode CreatePhysics(MpmModel model, const char *name, PetscInt dim)
{
  PetscBool found = PETSC_FALSE;
  char     *words = NULL;

  PetscFunctionBeginUser;
  if (!model->scene.physics.name) {
    PetscCall(MpmPhysicsList(&words));
    PetscCall(MpmPhysicsCreate(name, &model->scene.physics, &found));
    MpmCheckInput(found && !(model->scene.physics.traits & MPM_PHYSICS_INTERNAL),
                  "-mpm_physics %s: must be one of %s, " MPM_STRESS_POINT, name, words);
    PetscCall(PetscFree(words));
  }
  PetscCall(MpmLayoutCreate(&model->scene.physics, (PetscInt)model->scene.deformation.kinematics, model->disc.layout));
  model->scene.deformation.stretch = MpmStretchFind(dim);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* How points deform, in 2D. */
static PetscErrorCode ReadKinematics(MpmModel model, const MpmOptions *options, PetscInt dim)
{
  static const char *const words[] = {"plane_strain", "axisymmetric", NULL};
  PetscInt                 word    = 0;
  PetscBool                given;

  PetscFunctionBeginUser;
  PetscCall(
    MpmOptionsWord(options, "kinematics",
                   "with dim 2: plane strain, per metre of thickness, or axial symmetry, x the radius and y the "
                   "axis, forces and masses of a full turn",
                   words, MPM_OPTIONAL, &word, &given));
  MpmCheckInput(!given || dim == 2 || MpmOptionsHelp(), "-mpm_kinematics %s: is a choice with -mpm_dim 2", words[word]);
  model->scene.deformation.kinematics = dim == 3 ? MPM_SPATIAL : word ? MPM_AXISYMMETRY : MPM_PLANE_STRAIN;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Dimension and physics, or the word for a stress point. Free the word. */
static PetscErrorCode ReadKind(MpmModel model, const MpmOptions *options, PetscInt *dim, char **kind)
{
  char *words = NULL, *help = NULL;

  PetscFunctionBeginUser;
  *dim = 2;
  PetscCall(MpmOptionsHeading(options, "Scene"));
  PetscCall(MpmOptionsText(options, "title", "free text for the log", "", MPM_OPTIONAL, &model->scene.name.title));
  PetscCall(MpmPluginsLoad(options));
  PetscCall(MpmOptionsInt(options, "dim", "dimension: 2 (plane strain) or 3", 2, 3, MPM_REQUIRED, dim, NULL));
  PetscCall(ReadKinematics(model, options, *dim));
  PetscCall(MpmPhysicsList(&words));
  PetscCall(MpmTextAppend(&help, "unknown fields: %s, " MPM_STRESS_POINT " (one point in the laboratory)", words));
  PetscCall(MpmOptionsText(options, "physics", help, "solid", MPM_OPTIONAL, kind));
  PetscCall(PetscFree(help));
  PetscCall(PetscFree(words));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* How the grid's equations are made. */
static PetscErrorCode ReadDiscretization(MpmModel model, const MpmOptions *options, PetscInt dim, const char *physics)
{
  PetscInt jacobian = MPM_JACOBIAN_AUTO;

  PetscFunctionBeginUser;
  PetscCall(MpmShapeRead(model, options));
  PetscCall(
    MpmOptionsWord(options, "jacobian", "how the Jacobian is made", MpmJacobianTypes, MPM_OPTIONAL, &jacobian, NULL));
  model->solver.jacobian.form = jacobian == MPM_JACOBIAN_AUTO ? MPM_JACOBIAN_LOCAL : (MpmJacobianType)jacobian;
  PetscCall(CreatePhysics(model, physics, dim));
  PetscCall(MpmStabilizationRead(model, options));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The results' folder must be there and take files. */
static PetscErrorCode CheckPrefix(MpmModel model)
{
  char     *slash;
  PetscBool there;
  size_t    length;

  PetscFunctionBeginUser;
  if (MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  MpmCheckInput(model->scene.name.prefix[0] && strlen(model->scene.name.prefix) < PETSC_MAX_PATH_LEN - 64,
                "-mpm_output_prefix: must be a name of 1 to %d characters", PETSC_MAX_PATH_LEN - 65);
  slash  = strrchr(model->scene.name.prefix, '/');
  length = strlen(slash ? slash + 1 : model->scene.name.prefix);
  MpmCheckInput(length > 0 && length <= 200,
                "-mpm_output_prefix: the name behind the folder has %d characters, must have 1 to 200", (int)length);
  PetscCall(MpmFolderCheck(model->comm, model->scene.name.prefix, &there));
  MpmCheckInput(there, "-mpm_output_prefix %s: its folder cannot be made or takes no files", model->scene.name.prefix);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Options of all runs. */
static PetscErrorCode ReadPrefix(MpmModel model, const MpmOptions *options, const MpmOptions *block)
{
  PetscFunctionBeginUser;
  PetscCall(MpmOptionsHeading(block, "Output"));
  PetscCall(
    MpmOptionsText(block, "prefix", "results are named after it", "talus", MPM_OPTIONAL, &model->scene.name.prefix));
  PetscCall(CheckPrefix(model));
  PetscCall(MpmOptionsBool(options, "quiet", "no lines but errors on the terminal", &model->results->quiet, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadOutput(MpmModel model, const MpmOptions *options)
{
  const MpmOptions block = {options->comm, "mpm_output_", options->record};
  char            *view;

  PetscFunctionBeginUser;
  model->results->states.every  = 1;
  model->results->history_every = 1;
  PetscCall(ReadPrefix(model, options, &block));
  PetscCall(MpmOptionsInt(&block, "every", "steps between written states; 0: none but the history and the summary", 0,
                          PETSC_INT_MAX, MPM_OPTIONAL, &model->results->states.every, NULL));
  if (model->scene.deformation.bed && !model->results->states.every) model->results->states.every = PETSC_INT_MAX;
  PetscCall(MpmOptionsInt(&block, "history", "steps between rows of the history; the last step always has one", 1,
                          PETSC_INT_MAX, MPM_OPTIONAL, &model->results->history_every, NULL));
  PetscCall(MpmOptionsBool(&block, "signature",
                           "the history has a number of the discrete decisions of each step: nodes of points, cells, "
                           "contact, conditions",
                           &model->results->signature, NULL));
  PetscCall(MpmOutputSetFromOptions(model, &block));
  PetscCall(MpmOptionsText(options, "view",
                           "at the end of the run, what the model consists of: alone to the terminal, or ascii:FILE",
                           NULL, MPM_OPTIONAL, &view));
  if (view && *view) {
    PetscBool text, file;

    PetscCall(PetscStrcmp(view, "ascii", &text));
    PetscCall(PetscStrbeginswith(view, "ascii:", &file));
    MpmCheckInput(text || file || MpmOptionsHelp(), "-mpm_view %.100s: must be alone, ascii or ascii:FILE", view);
  }
  PetscCall(PetscFree(view));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Fields whose nodes stand some cells apart need a grid that such a lattice fits. */
static PetscErrorCode CheckLattices(const MpmGrid *grid, const MpmLayout *layout)
{
  PetscFunctionBeginUser;
  for (PetscInt c = 0; c < layout->block && !MpmOptionsHelp(); c++) {
    const PetscInt spacing = layout->shape[layout->component[c].shape].spacing;

    for (PetscInt a = 0; a < grid->dim; a++)
      MpmCheckInput(grid->cells[a] % spacing == 0,
                    "-mpm_grid_cells %" PetscInt_FMT ": the nodes of %s stand %" PetscInt_FMT
                    " cells apart on axis %c, must be a multiple of %" PetscInt_FMT,
                    grid->cells[a], layout->component[c].name, spacing, "xyz"[a], spacing);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadMaterialsAndBodies(MpmModel model, const MpmOptions *options)
{
  PetscFunctionBeginUser;
  PetscCall(MpmReadMaterials(model, options));
  PetscCall(MpmGroundsCheckUsed(model->scene.materials->grounds));
  if (!(model->scene.physics.traits & MPM_PHYSICS_SYMMETRIC)) model->solver.definite.symmetric = PETSC_FALSE;
  PetscCall(MpmOptionsBlocks(options, "bodies",
                             "names of the body blocks; bodies must not overlap, unless one has priority, and are "
                             "welded where they share nodes",
                             MPM_REQUIRED, &model->scene.bodies->count, &model->scene.bodies->names));
  PetscCall(PetscCalloc1(model->scene.bodies->count, &model->scene.bodies->at));
  for (PetscInt b = 0; b < model->scene.bodies->count; b++) {
    PetscCall(MpmBodyCreate(options, model->disc.grid, model->scene.materials, model->scene.bodies, b));
    PetscCall(MpmReadBodyFile(model, options, b));
    PetscCall(MpmBodyReadDepth(options, model->scene.bodies->names[b], model->disc.grid, model->scene.deformation.bed,
                               model->scene.shape.type, model->scene.shape.edge, model->scene.bodies->at[b]));
    for (PetscInt m = 0; m < model->scene.materials->count; m++) {
      MpmMaterial *material = &model->scene.materials->at[m];

      if (MpmBodyHasMaterial(model->scene.bodies->at[b], m))
        material->spacing = PetscMax(material->spacing, MpmBodySpacing(model->scene.bodies->at[b]));
    }
  }
  PetscCall(MpmInflowRead(model));
  PetscCall(MpmContactsRead(model, (PetscBool)(MpmPressureComponent(model->disc.layout) >= 0), options));
  PetscCall(MpmMemoryCheck(options, model->disc.grid, model->scene.bodies->count, model->scene.bodies->at,
                           model->scene.bodies->names));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reactions are columns by name: a boundary must not be called like a condition. */
static PetscErrorCode ReadBoundaries(MpmModel model, const MpmOptions *options)
{
  PetscFunctionBeginUser;
  PetscCall(MpmOptionsBlocks(options, "boundaries", "names of the boundaries that do not follow the grid", MPM_OPTIONAL,
                             &model->scene.boundaries->count, &model->scene.boundaries->names));
  PetscCall(PetscCalloc1(model->scene.boundaries->count, &model->scene.boundaries->at));
  PetscCall(PetscCalloc1(model->scene.boundaries->count, &model->state.placements));
  for (PetscInt k = 0; k < model->scene.boundaries->count; k++) {
    for (PetscInt b = 0; b < model->scene.bcs->count && !MpmOptionsHelp(); b++) {
      MpmCheckInput(strcmp(model->scene.boundaries->names[k], model->scene.bcs->names[b]),
                    "-mpm_boundaries %s: there is a condition of this name", model->scene.boundaries->names[k]);
    }
    for (PetscInt p = 0; p < model->scene.pairs->count && !MpmOptionsHelp(); p++) {
      MpmCheckInput(strcmp(model->scene.boundaries->names[k], model->scene.pairs->names[p]),
                    "-mpm_boundaries %s: there is a contact of this name", model->scene.boundaries->names[k]);
    }
    for (PetscInt m = 0; m < model->scene.motions->count && !MpmOptionsHelp(); m++) {
      MpmCheckInput(strcmp(model->scene.boundaries->names[k], model->scene.motions->names[m]),
                    "-mpm_boundaries %s: there is a motion of this name", model->scene.boundaries->names[k]);
    }
    PetscCall(
      MpmBoundaryCreate(options, model->scene.boundaries->names[k], model->disc.grid, &model->scene.boundaries->at[k]));
    if (model->scene.boundaries->at[k].freedom && !MpmFreedomIsSymmetric(model->scene.boundaries->at[k].freedom))
      model->solver.definite.symmetric = PETSC_FALSE;
    MpmCheckInput((!model->scene.boundaries->at[k].water.drained && !model->scene.boundaries->at[k].water.led) ||
                    MpmPressureComponent(model->disc.layout) >= 0 || MpmOptionsHelp(),
                  "-mpm_boundary_%s_%s: there is no water in the scene's physics", model->scene.boundaries->names[k],
                  model->scene.boundaries->at[k].water.drained ? "drained" : "pressure");
    if (MpmPressureBounds(
          model, model->scene.boundaries->at[k].friction,
          (PetscBool)(model->scene.boundaries->at[k].stick && !model->scene.boundaries->at[k].bilateral)))
      model->solver.at_rest.serves = PETSC_TRUE;
  }
  MpmRigidStart(model->scene.boundaries->count, model->scene.boundaries->at, model->state.placements);
  PetscCall(MpmRigidAddRows(model->scene.boundaries, model->state.placements, model->state.rows));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Their reactions are columns by name, too. */
static PetscErrorCode ReadMotions(MpmModel model, const MpmOptions *options)
{
  MpmBodyMotions *motions = model->scene.motions;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(motions->count, &motions->at));
  for (PetscInt m = 0; m < motions->count; m++) {
    for (PetscInt b = 0; b < model->scene.bcs->count && !MpmOptionsHelp(); b++)
      MpmCheckInput(strcmp(motions->names[m], model->scene.bcs->names[b]),
                    "-mpm_motions %s: there is a condition of this name", motions->names[m]);
    PetscCall(MpmBodyMotionCreate(options, motions->names[m], model->disc.grid, model->scene.bodies, &motions->at[m]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

#define EARTH 9.81

/* The largest of the scene's gravity loads, or that of the Earth, m/s2. */
static PetscReal Gravity(const MpmLoads *loads, PetscInt dim)
{
  PetscReal most = 0.;

  for (PetscInt l = 0; l < loads->count; l++) {
    PetscReal square = 0.;

    for (PetscInt a = 0; loads->at[l].type == MPM_LOAD_GRAVITY && a < dim; a++)
      square += PetscSqr(loads->at[l].value[a]);
    most = PetscMax(most, PetscSqrtReal(square));
  }
  return most > 0. ? most : EARTH;
}

static PetscErrorCode ReadLoads(MpmModel model, const MpmOptions *options)
{
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(model->scene.loads->count, &model->scene.loads->at));
  for (PetscInt l = 0; l < model->scene.loads->count; l++) {
    PetscCall(MpmLoadCreate(options, model->scene.loads->names[l], model->disc.grid, &model->scene.loads->at[l]));
    MpmCheckInput(model->scene.loads->at[l].type != MPM_LOAD_FLUX || MpmPressureComponent(model->disc.layout) >= 0 ||
                    MpmOptionsHelp(),
                  "-mpm_load_%s_type flux: there is no water in the scene's physics", model->scene.loads->names[l]);
    for (PetscInt m = 0;
         model->scene.loads->at[l].type == MPM_LOAD_GRAVITY && m < model->scene.materials->count && !MpmOptionsHelp();
         m++) {
      MpmCheckInput(model->scene.materials->at[m].density > 0.,
                    "-mpm_material_%s_density: must be > 0, kg/m3: load %s is gravity",
                    model->scene.materials->names[m], model->scene.loads->names[l]);
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadConditions(MpmModel model, const MpmOptions *options)
{
  PetscFunctionBeginUser;
  PetscCall(MpmOptionsBlocks(options, "bcs", "names of the conditions on nodes", MPM_OPTIONAL, &model->scene.bcs->count,
                             &model->scene.bcs->names));
  PetscCall(MpmOptionsBlocks(options, "motions", "names of the motions of bodies", MPM_OPTIONAL,
                             &model->scene.motions->count, &model->scene.motions->names));
  PetscCall(MpmOptionsBlocks(options, "loads", "names of the loads", MPM_OPTIONAL, &model->scene.loads->count,
                             &model->scene.loads->names));
  PetscCall(MpmOptionsBlocks(options, "surfaces", "names of the surfaces of bodies on which something acts",
                             MPM_OPTIONAL, &model->scene.surfaces->count, &model->scene.surfaces->names));
  PetscCall(MpmStagesReadLists(&model->scene, options));
  PetscCall(PetscCalloc1(model->scene.bcs->count, &model->scene.bcs->at));
  PetscCall(PetscMalloc1((model->scene.bcs->count * 2 * MPM_MAX_BLOCK), &model->state.acting.walls.at));
  PetscCall(PetscCalloc1((model->scene.bcs->count + model->scene.motions->count), &model->state.acting.bcs));
  PetscCall(MpmConditionsAddRows(model->scene.bcs, model->state.acting.bcs, model->state.rows));
  for (PetscInt b = 0; b < model->scene.bcs->count; b++)
    PetscCall(MpmConditionCreate(options, model->scene.bcs->names[b], model->disc.grid, model->disc.layout,
                                 &model->scene.bcs->at[b]));
  PetscCall(ReadMotions(model, options));
  PetscCall(PetscCalloc1(((model->scene.bcs->count + model->scene.motions->count) * model->disc.block),
                         &model->disc.nodal.reaction));
  PetscCall(ReadBoundaries(model, options));
  PetscCall(ReadLoads(model, options));
  PetscCall(MpmSurfacesRead(model, options));
  PetscCall(MpmAddedTermsRead(options, model->disc.grid, model->scene.terms));
  PetscCall(MpmHeldFieldCreate(&model->scene.physics, model->disc.dim, &model->scene.terms->held));
  if (!MpmAddedTermsAreSymmetric(model->scene.terms)) model->solver.definite.symmetric = PETSC_FALSE;
  for (PetscInt m = 0; m < model->scene.materials->count; m++)
    PetscCall(MpmMaterialPrepare(&model->scene.physics, model->disc.dim, Gravity(model->scene.loads, model->disc.dim),
                                 &model->scene.materials->at[m]));
  if (!MpmSceneIsSymmetric(model)) model->solver.definite.symmetric = PETSC_FALSE;
  PetscCall(MpmWaterReadLevel(model, options));
  PetscCall(MpmTracksRead(model, options));
  PetscCall(MpmLinesRead(model, options));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The options that are the model's, unless they were given as text. */
static PetscErrorCode TakeOptions(MpmModel model)
{
  PetscFunctionBeginUser;
  PetscCheck(!MpmModelHasScene(model), model->comm, PETSC_ERR_ARG_WRONGSTATE, "the scene has been read");
  if (!model->caller.own) PetscCall(MpmDatabaseTake(model->database, model->caller.prefix));
  else model->record->sources = model->database->sources;
  PetscFunctionReturn(PETSC_SUCCESS);
}

#define AXIAL "with -mpm_kinematics axisymmetric"

/* Refuses forces and motions that axial symmetry rules out. */
static PetscErrorCode CheckAxial(const MpmModel model)
{
  const MpmLoads      *loads      = model->scene.loads;
  const MpmBoundaries *boundaries = model->scene.boundaries;

  PetscFunctionBeginUser;
  if (model->scene.deformation.kinematics != MPM_AXISYMMETRY || MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt l = 0; l < loads->count; l++)
    MpmCheckInput(loads->at[l].type != MPM_LOAD_GRAVITY || loads->at[l].value[0] == 0.,
                  "-mpm_load_%s_value: gravity along x, the radius, must be 0 " AXIAL, loads->at[l].name);
  for (PetscInt b = 0; b < boundaries->count; b++) {
    const MpmBoundary *boundary = &boundaries->at[b];

    MpmCheckInput(!boundary->freedom || !(boundary->freedom->free[0] & 1 || boundary->freedom->free[1]),
                  "-mpm_boundary_%s_free: must be y " AXIAL ", along the axis", boundaries->names[b]);
    MpmCheckInput(boundary->motion.rotation[2] == 0.,
                  "-mpm_boundary_%s_rotation: must be 0 " AXIAL ", which nothing turns about z", boundaries->names[b]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Parts whose numbers need no option. */
static PetscErrorCode AddRows(MpmModel model)
{
  PetscErrorCode (*const parts[])(MpmModel) = {MpmEnergyAddRows,        MpmDynamicsAddRows,   MpmTimeErrorAddRows,
                                               MpmConsolidationAddRows, MpmRelaxationAddRows, MpmStepControlAddRows,
                                               MpmRescueAddRows,        MpmSlideAddRows,      MpmReductionAddRows,
                                               MpmSettleAddRows,        MpmGeostaticAddRows};

  PetscFunctionBeginUser;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(parts); k++) PetscCall(parts[k](model));
  PetscCall(MpmSolverAddRows(&model->solver, model->state.rows));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A scene of bodies on a grid. */
static PetscErrorCode ReadBodiesOnGrid(MpmModel model, const MpmOptions *options, PetscInt dim, const char *physics)
{
  PetscBool particular;

  PetscFunctionBeginUser;
  PetscCall(ReadDiscretization(model, options, dim, physics));
  PetscCall(MpmGridSetFromOptions(model->disc.grid, options, model->disc.layout->dim));
  MpmGridSetOrder(model->disc.grid, MpmShapeOrder(model->scene.shape.type));
  model->disc.grid->axial = (PetscBool)(model->scene.deformation.kinematics == MPM_AXISYMMETRY);
  MpmCheckInput(!model->disc.grid->axial || model->disc.grid->lower[0] >= 0. || MpmOptionsHelp(),
                "-mpm_grid_lower: x starts at %g, with -mpm_kinematics axisymmetric it is the radius and must be >= 0",
                (double)model->disc.grid->lower[0]);
  PetscCall(MpmDiscretizationSize(&model->disc));
  MpmRecordSetWindow(options->record, model->disc.grid->lower, model->disc.grid->upper);
  PetscCall(MpmTerrainRead(model, options));
  PetscCall(CheckLattices(model->disc.grid, model->disc.layout));
  PetscCall(ReadMaterialsAndBodies(model, options));
  PetscCall(MpmTerrainReadParameters(model, options));
  PetscCall(ReadConditions(model, options));
  PetscCall(MpmMovingGridRead(model, options));
  PetscCall(MpmStagesRead(model, options));
  PetscCall(CheckAxial(model));
  PetscCall(MpmTerrainCheck(model));
  PetscCall(MpmEntrainmentRead(model, options));
  PetscCall(MpmRunoutRead(model, options));
  PetscCall(MpmDynamicsRead(model, options));
  if (!MpmOptionsHelp()) PetscCall(MpmVoidsCheck(model));
  PetscCall(MpmStabilizationSettle(model, options));
  PetscCall(ReadOutput(model, options));
  PetscCall(MpmCheckpointSetFromOptions(model, options));
  model->solver.multigrid.levels.shape = model->scene.shape.type;
  model->solver.multigrid.levels.edge  = model->scene.shape.edge;
  PetscCall(MpmSolverSetFromOptions(&model->solver, options));
  PetscCall(MpmGradientRead(model, options, NULL));
  PetscCall(MpmShapeCheck(model));
  PetscCall(MpmInPlaceCheck(model));
  PetscCall(AddRows(model));
  PetscCall(MpmOptionsHas(options, "dim", &particular));
  if (MpmOptionsHelp() && !particular) PetscCall(MpmLaboratoryPrintHelp(model, options));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadScene(MpmModel model)
{
  const MpmOptions options = {model->comm, "mpm_", model->record}, output = {model->comm, "mpm_output_", model->record};
  PetscLogDouble   since;
  PetscInt         dim;
  char            *kind, *warning;

  PetscFunctionBeginUser;
  PetscCall(MpmMonitorBegin(&model->monitor, MPM_TIME_SETUP, &since));
  PetscCall(ReadKind(model, &options, &dim, &kind));
  if (!model->scene.physics.name && !strcmp(kind, MPM_STRESS_POINT)) {
    PetscCall(MpmLaboratoryRead(model, &options, dim));
    PetscCall(ReadPrefix(model, &options, &output));
    PetscCall(MpmLaboratoryReadGradient(model, &options));
  } else PetscCall(ReadBodiesOnGrid(model, &options, dim, kind));
  PetscCall(PetscFree(kind));
  PetscCall(MpmEnsembleRead(model));
  if (MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmOptionsCheckUnknown(&options, &warning));
  if (model->caller.terminal) PetscCall(MpmForeignOptionsCheckNames(model->record));
  if (warning) PetscCall(MpmTerminalWarn(model, "warning: %s", warning));
  PetscCall(PetscFree(warning));
  PetscCall(MpmMonitorEnd(&model->monitor, MPM_TIME_SETUP, since));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmModelSetFromOptions(MpmModel model)
{
  PetscFunctionBeginUser;
  PetscCall(TakeOptions(model));
  MpmModelCall(model, ReadScene(model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

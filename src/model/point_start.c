/*
  Initial fields of points besides those of their bodies: the physics' own states, parameters, and the parts of the
  material.
*/
#include "options/options.h"
#include "point/layout.h"
#include "point/material.h"
#include "grid/shape.h"
#include "grid/walls.h"
#include "handover/handover.h"
#include "particles/body.h"
#include "particles/ground_points.h"
#include "particles/particles.h"
#include "particles/point_mass.h"
#include "particles/points.h"
#include "bc/bc.h"
#include "bc/body_motion.h"
#include "volume/inertia.h"
#include "rigid/rigid.h"
#include "pairs/body_contact.h"
#include "contact/contact.h"
#include "contact/rigid_body.h"
#include "loads/body_surface.h"
#include "loads/load.h"
#include "loads/water_table.h"
#include "query/model.h"
#include "query/query.h"
#include "query/scene.h"
#include "scene/integrator_read.h"
#include "scene/scene_read.h"
#include "step/change_ramp.h"
#include "step/moving_grid.h"
#include "step/water_state.h"
#include "integrators/consolidation.h"
#include "integrators/time_error.h"
#include "schedule/reduction.h"
#include "schedule/stage.h"
#include "observe/lines.h"
#include "observe/results.h"
#include "observe/tracks.h"
#include "checkpoint/checkpoint.h"
#include "model/build.h"

/* Contact, regions of surfaces and parameters that vary need initial places, which a stage may overwrite otherwise. */
PetscBool MpmOriginIsKept(const MpmModel model)
{
  PetscBool wanted = (PetscBool)(model->scene.boundaries->count > 0 || model->scene.pairs->count > 0),
            resets = PETSC_FALSE;

  for (PetscInt m = 0; m < model->scene.materials->count; m++)
    wanted = (PetscBool)(wanted || model->scene.materials->at[m].varies);
  for (PetscInt k = 0; k < model->scene.surfaces->count; k++)
    wanted = (PetscBool)(wanted || model->scene.surfaces->at[k].region);
  for (PetscInt s = 0; s < model->scene.stages.count; s++)
    resets = (PetscBool)(resets || model->scene.stages.at[s].reset);
  return (PetscBool)(wanted && resets);
}

/* Numbers that a point has of its own where parameters vary, as many for each. */
PetscInt MpmOwnParametersSize(MpmModel model)
{
  MpmMaterials *materials = model->scene.materials;
  PetscInt      most      = 0;

  for (PetscInt m = 0; m < materials->count; m++) most = PetscMax(most, MpmMaterialOwnSize(&materials->at[m]));
  for (PetscInt m = 0; m < materials->count; m++)
    if (materials->at[m].varies) materials->at[m].varies->stride = most;
  return most;
}

PetscErrorCode MpmBodiesPrepare(MpmModel model)
{
  PetscInt axis, up;

  PetscFunctionBeginUser;
  MpmLoadsGetVertical(model->scene.loads, model->disc.dim, &axis, &up);
  for (PetscInt b = 0; b < model->scene.bodies->count; b++) {
    PetscBool joins = PETSC_FALSE;

    MpmBodySetVertical(model->scene.bodies->at[b], axis, up);
    for (PetscInt k = 1; k < model->scene.stages.count; k++)
      joins = (PetscBool)(joins || model->scene.stages.at[k].adds[b]);
    if (joins) MpmBodySetJoins(model->scene.bodies->at[b]);
    MpmCheckInput(joins || MpmBodyFills(model->scene.bodies->at[b]) != MPM_FILL_YES,
                  "-mpm_body_%s_fill true: the body joins no stage, must be in the list of bodies of a later one",
                  model->scene.bodies->names[b]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmFillOwnStates(MpmModel model)
{
  const MpmPhysics *physics = &model->scene.physics;
  MpmPoints         points;

  PetscFunctionBeginUser;
  if (!model->disc.layout->own.size) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  for (PetscInt p = 0; p < points.count; p++) {
    const MpmMaterial *material   = &model->scene.materials->at[points.material[p]];
    const double      *own_values = MpmPointOwn(&points, material, p);
    PetscReal         *own        = &points.physics.own[p * model->disc.layout->own.size];

    MpmStatesAtRest((size_t)physics->state_count, physics->states, model->disc.dim, own);
    if (physics->initial) {
      const MpmPhysicsMaterial of = MpmMaterialForPhysics(material, own_values, model->disc.dim);

      physics->initial(&of, MpmMaterialPhysicsValues(material, own_values),
                       points.state ? &points.state[p * model->state.particles->state_size] : NULL, own);
    }
  }
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- fields from files ---- */

PetscErrorCode MpmReadBodyFile(MpmModel model, const MpmOptions *options, PetscInt b)
{
  const MpmPhysics *physics = &model->scene.physics;
  const MpmLayout  *layout  = model->disc.layout;
  MpmFileField     *fields;
  PetscInt          count = 0;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1((size_t)(physics->state_count + layout->rate.count + 1), &fields));
  for (PetscInt s = 0; s < physics->state_count; s++) {
    const MpmStateVariable *state = &physics->states[s];

    fields[count++] =
      (MpmFileField){state->name, state->kind == MPM_STATE_SYM ? 6 : MpmStateComponents(state, model->disc.dim)};
  }
  for (PetscInt r = 0; r < layout->rate.count; r++)
    fields[count++] = (MpmFileField){layout->component[layout->rate.component[r]].name, 1};
  PetscCall(MpmBodyReadFile(options, model->scene.bodies->names[b], model->disc.grid, model->scene.materials, count,
                            fields, model->scene.bodies->at[b]));
  PetscCall(PetscFree(fields));
  if (MpmBodyHandover(model->scene.bodies->at[b]))
    PetscCall(MpmMonitorLine(&model->monitor, "body %s: %s", model->scene.bodies->names[b],
                             MpmBodyHandover(model->scene.bodies->at[b])->line));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The row's states of the physics and values with a rate, of point p; its mass is then that of the file. */
static void TakeFields(MpmModel model, MpmBody body, PetscInt row, PetscInt p, MpmPoints *points)
{
  const MpmPhysics *physics = &model->scene.physics;
  const MpmLayout  *layout  = model->disc.layout;
  PetscReal        *own     = points->physics.own ? &points->physics.own[p * layout->own.size] : NULL;

  for (PetscInt s = 0; s < physics->state_count; s++) {
    const PetscInt   size   = MpmStateComponents(&physics->states[s], model->disc.dim);
    const PetscInt   stride = physics->states[s].kind == MPM_STATE_SYM ? 6 : size;
    const PetscReal *value  = MpmBodyFileField(body, physics->states[s].name);

    for (PetscInt c = 0; value && c < size; c++) own[c] = value[row * stride + c];
    own += size;
  }
  for (PetscInt r = 0; r < layout->rate.count; r++) {
    const PetscReal *value = MpmBodyFileStart(body, layout->component[layout->rate.component[r]].name);

    if (value) points->physics.value[p * layout->rate.count + r] = value[row];
  }
  if (layout->own.taken_up >= 0 && MpmBodyFileHasMass(body))
    points->mass[p] += points->mass[p] - MpmPointMassNow(points, model->scene.materials->at, layout, p);
}

PetscErrorCode MpmFillFromFiles(MpmModel model)
{
  const MpmBodies *bodies = model->scene.bodies;
  PetscInt        *body_of, row = 0;
  MpmPoints        points;

  PetscFunctionBeginUser;
  if (!model->disc.layout->rate.count && !model->disc.layout->own.size) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  PetscCall(PetscMalloc1(points.count, &body_of));
  MpmBodiesOfPoints(bodies->count, bodies->at, &points, body_of);
  for (PetscInt p = 0; p < points.count; p++, row++) {
    if (!p || body_of[p] != body_of[p - 1]) row = 0;
    if (MpmBodyIsImported(bodies->at[body_of[p]])) TakeFields(model, bodies->at[body_of[p]], row, p, &points);
  }
  PetscCall(PetscFree(body_of));
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmFillParts(MpmModel model)
{
  const MpmBodies *bodies = model->scene.bodies;
  PetscInt        *body_of;
  MpmPoints        points;

  PetscFunctionBeginUser;
  if (model->disc.material.parts == 1) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  PetscCall(PetscMalloc1(points.count, &body_of));
  MpmBodiesOfPoints(bodies->count, bodies->at, &points, body_of);
  for (PetscInt p = 0; p < points.count; p++) points.domain.part[p] = bodies->part[body_of[p]];
  PetscCall(PetscFree(body_of));
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- points ---- */

/* The first stage of a run that does not go on from a checkpoint. */
static PetscErrorCode BeginStages(MpmModel model)
{
  PetscFunctionBeginUser;
  MpmSurfacesSetBodies(model);
  PetscCall(MpmWaterFillPressure(model, 0, PETSC_MAX_INT));
  PetscCall(MpmStageBegin(model, 0));
  PetscCall(MpmBodySurfacesCheck(model->scene.surfaces, &model->state.acting.loads[model->scene.loads->count],
                                 model->disc.grid, model->state.particles));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the points that are tracked, moved and followed, and those of stages. */
static PetscErrorCode SelectPoints(MpmModel model)
{
  PetscFunctionBeginUser;
  for (PetscInt t = 0; t < model->results->tracks.count; t++)
    PetscCall(
      MpmTrackSelect(&model->results->tracks.at[t], model->disc.grid, model->scene.materials, model->state.particles));
  PetscCall(MpmLinesSelect(model));
  for (PetscInt m = 0; m < model->scene.motions->count; m++)
    PetscCall(MpmBodyMotionSelect(&model->scene.motions->at[m], model->scene.bodies, model->state.particles));
  PetscCall(MpmMovingGridSelect(model));
  PetscCall(MpmStagesSelect(model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Initial fields of points for stages. */
static void AddStageFields(const MpmModel model, const char *fields[], PetscInt *count)
{
  for (PetscInt a = 0; MpmStagesReduce(model) && a < model->disc.dim; a++) fields[(*count)++] = MpmReductionFields[a];
  for (PetscInt f = 0; f < MpmChangeFieldCount(model); f++) fields[(*count)++] = MpmChangeFields[f];
  if (MpmStagesControlError(model)) fields[(*count)++] = MpmTimeErrorField;
  if (MpmStagesConsolidate(model)) fields[(*count)++] = MpmConsolidationField;
}

/* Fields of points for contacts. */
static void AddContactFields(const MpmModel model, const char *fields[], PetscInt *count)
{
  for (PetscInt k = 0; k < model->scene.pairs->count; k++) {
    fields[(*count)++] = model->scene.pairs->at[k].gap_field;
    if (model->scene.pairs->at[k].rest_field) fields[(*count)++] = model->scene.pairs->at[k].rest_field;
    if (model->scene.pairs->at[k].augmented) fields[(*count)++] = model->scene.pairs->at[k].pressure_field;
    for (PetscInt a = 0; model->scene.pairs->at[k].tangential && a < model->disc.dim; a++)
      fields[(*count)++] = model->scene.pairs->at[k].slip_field[a];
  }
  for (PetscInt k = 0; k < model->scene.boundaries->count; k++)
    for (PetscInt a = 0; model->scene.boundaries->at[k].tangential && a < model->disc.dim; a++)
      fields[(*count)++] = model->scene.boundaries->at[k].fields.slip[a];
  for (PetscInt k = 0; k < model->scene.boundaries->count; k++) {
    if (model->scene.boundaries->at[k].fields.pressure)
      fields[(*count)++] = model->scene.boundaries->at[k].fields.pressure;
    if (model->scene.boundaries->at[k].fields.rest) fields[(*count)++] = model->scene.boundaries->at[k].fields.rest;
    if (model->scene.boundaries->at[k].bilateral) fields[(*count)++] = model->scene.boundaries->at[k].fields.gap;
    if (model->scene.boundaries->at[k].fields.broken) fields[(*count)++] = model->scene.boundaries->at[k].fields.broken;
  }
}

/* True where a run that goes on needs the bodies: where later stages add or change them, where contact uses their
   shape, and for fields by body. */
static PetscBool NeedsBodies(const MpmModel model)
{
  return (PetscBool)(!model->results->checkpoint.restart || model->scene.stages.at[0].name ||
                     model->scene.boundaries->count > 0 || model->scene.pairs->count > 0 ||
                     model->scene.materials->grounds || MpmInflowHas(model));
}

/* Fields of one number a point that parts of the scene ask for; the first `shared` are amounts. To be freed. */
static PetscErrorCode NameFields(const MpmModel model, const char ***names, PetscInt *count, PetscInt *shared)
{
  const MpmScene  *scene  = &model->scene;
  const MpmTracks *tracks = &model->results->tracks;
  const char     **fields;

  PetscFunctionBeginUser;
  *count = 0;
  PetscCall(
    PetscMalloc1((scene->loads->count + tracks->count + MpmLinesFieldCount(model) + scene->motions->count +
                  (scene->boundaries->count + scene->pairs->count + 1) * (MPM_MAX_DIM + 4) + 1 + MPM_CHANGE_FIELDS),
                 names));
  fields = *names;
  for (PetscInt l = 0; l < scene->loads->count; l++)
    if (scene->loads->at[l].share_field) fields[(*count)++] = scene->loads->at[l].share_field;
  for (PetscInt t = 0; t < tracks->count; t++) fields[(*count)++] = tracks->at[t].share_field;
  *shared = *count;
  MpmLinesAddFields(model, fields, count);
  AddContactFields(model, fields, count);
  AddStageFields(model, fields, count);
  for (PetscInt m = 0; m < scene->motions->count; m++) fields[(*count)++] = scene->motions->at[m].share_field;
  if (MpmMovingGridField(model)) fields[(*count)++] = MpmMovingGridField(model);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* True where points know the halves of their domains: for shapes, tractions, faces, division, and ways in cells. */
static PetscBool HasDomains(const MpmModel model, PetscBool faces)
{
  for (PetscInt l = 0; l < model->scene.loads->count; l++)
    if (model->scene.loads->at[l].type == MPM_LOAD_TRACTION) return PETSC_TRUE;
  return (PetscBool)(MpmShapeHasDomain(model->scene.shape.type) || faces || MpmStagesAreGeostatic(model) ||
                     MpmStagesReduce(model) || model->scene.stabilization.divide > 0.);
}

/* True where a point's mass is not its density times its initial volume. */
static PetscBool HasMass(const MpmModel model)
{
  for (PetscInt b = 0; b < model->scene.bodies->count; b++)
    if (MpmBodyIsImported(model->scene.bodies->at[b]) || MpmBodyIsStressed(model->scene.bodies->at[b]))
      return PETSC_TRUE;
  return MpmStagesKeepMass(model);
}

PetscErrorCode MpmPointFieldsCreate(MpmModel model)
{
  PetscInt     state_size = 0, extra = 0, shared = 0;
  PetscBool    parts = (PetscBool)(model->disc.material.parts > 1);
  PetscBool    faces = (PetscBool)(model->scene.boundaries->count > 0 || parts || model->scene.surfaces->count > 0);
  const char **fields;

  PetscFunctionBeginUser;
  for (PetscInt m = 0; m < model->scene.materials->count; m++)
    state_size = PetscMax(state_size, model->scene.materials->at[m].state_size);
  PetscCall(NameFields(model, &fields, &extra, &shared));
  model->state.particles->has_mass = HasMass(model);
  PetscCall(MpmParticlesCreate(
    model->disc.grid,
    &(MpmParticleFields){.parameters   = MpmOwnParametersSize(model),
                         .state_size   = state_size,
                         .own_size     = model->disc.layout->own.size,
                         .rates        = model->disc.layout->rate.count,
                         .half_length  = HasDomains(model, faces),
                         .drawn        = (PetscBool)(faces && HasMass(model)),
                         .increment    = model->state.predict,
                         .faces        = faces,
                         .part         = parts,
                         .divisions    = (PetscBool)(model->scene.stabilization.divide > 0.),
                         .origin       = MpmOriginIsKept(model),
                         .across       = (PetscBool)(model->scene.deformation.kinematics == MPM_PLANE_STRAIN &&
                                               model->state.particles->has_mass),
                         .velocity     = model->disc.context.inertia->dynamic,
                         .affine       = MpmStagesAreAffine(model),
                         .acceleration = MpmStagesAreImplicit(model),
                         .extra_count  = extra,
                         .shared       = shared,
                         .extra        = fields},
    model->state.particles));
  PetscCall(PetscFree(fields));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Points are where the fields of their materials have values, and so are those of bodies that change their material. */
static PetscErrorCode CheckGrounds(MpmModel model)
{
  const MpmMaterials *materials = model->scene.materials;
  const MpmBodies    *bodies    = model->scene.bodies;
  PetscBool          *of;
  MpmPoints           points;

  PetscFunctionBeginUser;
  if (!materials->grounds) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(bodies->count, &of));
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  for (PetscInt m = 0; m < materials->count; m++) {
    if (!materials->at[m].varies) continue;
    for (PetscInt b = 0; b < bodies->count; b++) {
      of[b] = MpmBodyHasMaterial(bodies->at[b], m);
      for (PetscInt s = 0; s < model->scene.stages.count; s++)
        of[b] = (PetscBool)(of[b] || model->scene.stages.at[s].material[b] == m);
    }
    PetscCall(MpmGroundCheckPoints(&materials->at[m], of, bodies, &points, model->disc.dim, model->comm));
  }
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  PetscCall(PetscFree(of));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes the points, hands them to their ranks, and finds those that carry loads and are tracked. */
PetscErrorCode MpmPointsCreate(MpmModel model)
{
  MpmOutcome outcome;

  PetscFunctionBeginUser;
  PetscCall(MpmBodiesSettlePriority(model));
  if (!NeedsBodies(model)) {
    PetscCall(MpmRestartReadPoints(model));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(MpmBodiesPrepare(model));
  PetscCall(MpmBodiesShareEdges(model));
  PetscCall(MpmBodiesGenerate(model->scene.bodies->count, model->scene.bodies->at, model->scene.materials->at,
                              model->disc.grid, model->state.particles));
  PetscCall(MpmFillOwnStates(model));
  PetscCall(MpmFillFromFiles(model));
  PetscCall(MpmFillParts(model));
  PetscCall(MpmParticlesDistribute(model->state.particles, model->disc.grid, &outcome));
  MpmCheckInput(!outcome.code, "-mpm_bodies: %s", outcome.text);
  PetscCall(CheckGrounds(model));
  PetscCall(MpmBodiesCheckOverlap(model));
  for (PetscInt k = 0; k < model->scene.boundaries->count; k++)
    PetscCall(MpmBoundaryCheck(&model->scene.boundaries->at[k], model->scene.materials, model->disc.grid,
                               model->state.particles));
  PetscCall(SelectPoints(model));
  PetscCall(MpmInflowPark(model));
  if (model->results->checkpoint.restart) PetscCall(MpmRestartReadPoints(model));
  else PetscCall(BeginStages(model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

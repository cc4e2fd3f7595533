#pragma once
/*
  How a model is built from a scene, and called.
*/
#include "base/types.h"
#include "query/model.h"

/*
  A call that must not be entered again while it is at work, with the model's options in force; both end with it, also
  where it fails.
*/
PetscErrorCode MpmModelEnter(MpmModel model);
PetscErrorCode MpmModelLeave(MpmModel model);
#define MpmModelCall(model, call) \
  do { \
    PetscErrorCode model_error; \
    PetscCall(MpmModelEnter(model)); \
    model_error = (call); \
    PetscCall(MpmModelLeave(model)); \
    PetscCall(model_error); \
  } while (0)

/*
  The two parts of a run, with the model's options in force (steps.c): all steps with their results, and the summary.
  Between them stands whatever follows from the steps.
*/
PetscErrorCode MpmModelRunSteps(MpmModel model, PetscBool *interrupted);
PetscErrorCode MpmModelRunEnd(MpmModel model, PetscBool interrupted);
/* True where the scene has been read. */
PetscBool MpmModelHasScene(const MpmModel model);

/*
  Bodies side by side (body_overlap.c): bodies give way to those with priority; points on edges that two of them share
  are made once; and a scene in which two overlap that are there at the same time is refused, once the points are with
  their ranks.
*/
PetscErrorCode MpmBodiesSettlePriority(MpmModel model);
PetscErrorCode MpmBodiesShareEdges(MpmModel model);
PetscErrorCode MpmBodiesCheckOverlap(MpmModel model);
/* Before points are made: which way is up, and which bodies join a stage. */
PetscErrorCode MpmBodiesPrepare(MpmModel model);
/* Initial fields of points besides those of their bodies: the physics' own states, and parts of the material
   (point_start.c). */
PetscErrorCode MpmFillOwnStates(MpmModel model);
/* Materials by blocks and by a table, and fields of their numbers (read_materials.c). */
PetscErrorCode MpmReadMaterials(MpmModel model, const MpmOptions *options);
/* The file of a body, with fields of the physics; and that into the points, once they have all else. */
PetscErrorCode MpmReadBodyFile(MpmModel model, const MpmOptions *options, PetscInt b);
PetscErrorCode MpmFillFromFiles(MpmModel model);
PetscErrorCode MpmFillParts(MpmModel model);
/* The particles with the fields of the scene, and no points yet. */
PetscErrorCode MpmPointFieldsCreate(MpmModel model);
/* Makes the points, sends them to their ranks, and finds loaded and tracked ones; the discretization is set up. */
PetscErrorCode MpmPointsCreate(MpmModel model);
/* Numbers of the row of parameters that each point has; 0: no material varies. Sets the materials' strides. */
PetscInt MpmOwnParametersSize(MpmModel model);
/* True where points keep their places in the initial state, beside those where displacements began anew. */
PetscBool MpmOriginIsKept(const MpmModel model);
/* Warns of bodies with fewer points a cell than the shape needs, and of lengths below two cells (coarse_warnings.c). */
PetscErrorCode MpmModelWarnCoarse(MpmModel model);
/* Warns of options that change nothing in the run: of implicit steps, of multigrid (unused_words.c). Once set up. */
PetscErrorCode MpmModelWarnUnused(MpmModel model);
/* Views the model where -mpm_view says so. */
PetscErrorCode MpmModelViewFromOptions(MpmModel model);
/* Refuses bodies that cannot fit into memory, or whose points PETSc cannot count (memory_estimate.c). */
PetscErrorCode MpmMemoryCheck(const MpmOptions *options, const MpmGrid *grid, PetscInt count, const MpmBody bodies[],
                              char *const names[]);

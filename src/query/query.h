#pragma once
/*
  Questions of scene and state (query.c).
*/
#include "base/base.h"
#include "base/types.h"
#include "talus/talus.h"
#include "query/scene.h"

/* "2D", "3D" or "axisymmetric". */
const char *MpmKindText(const MpmModel model);
/* True where any stage changes a point's weight per stress-free volume. */
PetscBool MpmStagesKeepMass(const MpmModel model);
PetscBool MpmStagesAreGeostatic(const MpmModel model);
/* End of the geostatic stages with which the run begins, s; 0: none. Ramps of displacements count from there. */
PetscReal MpmGeostaticEnd(const MpmModel model);
/* True where any stage reduces strengths; relaxes; controls the error in time of its steps; ends at a degree of
   consolidation. */
PetscBool MpmStagesReduce(const MpmModel model);
PetscBool MpmStagesRelax(const MpmModel model);
PetscBool MpmStagesControlError(const MpmModel model);
PetscBool MpmStagesConsolidate(const MpmModel model);
/* True where steps of the stage may settle (schedule/settle.h). */
PetscBool MpmStageSettles(const MpmStage *stage);
/* Of the stage under way. */
const MpmMotionControl *MpmModelMotion(const MpmModel model);
/* True where a relaxation is under way; where it raises the masses of nodes, so that a long step is stable. */
PetscBool MpmModelRelaxes(const MpmModel model);
PetscBool MpmModelScales(const MpmModel model);
/* True where a body is removed by a ramp. */
PetscBool MpmRemovalGoesOn(const MpmModel model);
/* Does the stage under way reduce, without a factor of safety so far; and the reduction at a time, 1 where none is. */
PetscBool MpmReductionSeeks(const MpmModel model);
PetscReal MpmReductionFactor(const MpmModel model, PetscReal time);
/* The factor of a load, or of a surface behind them, at a time; 0 where it does not act. */
PetscReal MpmModelLoadFactor(const MpmModel model, PetscInt load, PetscReal time);
/* The water's pressure at a surface, Pa. */
PetscReal MpmModelSurfacePressure(const MpmModel model, PetscInt surface, PetscReal time);
/* An explicit step's longest, over the time in which a wave crosses a cell. */
PetscReal MpmExplicitPart(const MpmMotionControl *motion);
/* The stage under way ends at the present time. */
void MpmStageEndHere(MpmModel model);
/* True where the Jacobian is symmetric, as far as the physics knows. Once materials, loads and surfaces are read. */
PetscBool MpmSceneIsSymmetric(MpmModel model);

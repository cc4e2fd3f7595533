/*
  Scenes of a physics without displacement: the points stay in place, and fields on the grid are all that is solved for.
*/
#include "options/options.h"
#include "point/layout.h"
#include "grid/grid.h"
#include "bc/body_motion.h"
#include "volume/added_term.h"
#include "rigid/rigid.h"
#include "loads/body_surface.h"
#include "loads/load.h"
#include "pairs/body_contact.h"
#include "query/query.h"
#include "scene/integrator_read.h"
#include "scene/scene_read.h"

/* The first part of the scene that acts on a displacement, or NULL. */
static const char *FindPart(const MpmModel model)
{
  const MpmScene *scene = &model->scene;

  if (scene->deformation.kinematics == MPM_AXISYMMETRY) return "kinematics axisymmetric";
  if (scene->loads->count) return "loads";
  if (scene->surfaces->count) return "surfaces";
  if (scene->motions->count) return "motions";
  if (scene->boundaries->count) return "boundaries";
  if (scene->pairs->count) return "contacts";
  if (scene->terms->backgrounds) return "backgrounds";
  if (scene->terms->count) return "terms";
  if (model->disc.sections) return "sections";
  if (scene->follow.what != MPM_FOLLOW_NOTHING) return "grid_follow";
  if (model->disc.matrix.ghost > 0.) return "stabilization_ghost";
  if (scene->stabilization.interior > 0.) return "stabilization_interior";
  if (MpmStagesReduce(model)) return "stage, a reduction of strength";
  if (model->gradient) return "task gradient";
  return model->state.predict ? "time_predict" : NULL;
}

PetscErrorCode MpmInPlaceCheck(MpmModel model)
{
  PetscFunctionBeginUser;
  if (model->disc.layout->motion || MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  MpmCheckInput(!FindPart(model), "-mpm_%s: not available for physics %s, which has no displacement", FindPart(model),
                model->scene.physics.name);
  model->scene.stabilization.ghost_auto = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

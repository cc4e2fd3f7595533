/*
  Scenes that may have air or backgrounds: steps without inertia from the run's start on. The displacement of a
  background's nodes is a history; integrators with inertia and geostatic states have sums of their own over weights.
*/
#include "grid/grid.h"
#include "point/air.h"
#include "volume/added_term.h"
#include "pairs/body_contact.h"
#include "query/query.h"
#include "scene/integrator_read.h"
#include "scene/scene_read.h"

/* The first part that neither goes with, or NULL; with `background`, nor do backgrounds. */
static const char *FindPart(const MpmModel model, PetscBool background)
{
  if (MpmStagesAreDynamic(model)) return "inertia";
  if (MpmStagesAreGeostatic(model)) return "a geostatic stage";
  if (model->disc.context.bed) return "columns on a bed";
  if (!background) return NULL;
  if (MpmStagesReduce(model)) return "a reduction of strength";
  if (model->scene.pairs->count) return "contacts of bodies, which have nodes of their own";
  return model->disc.grid->axial ? "axial symmetry" : NULL;
}

PetscErrorCode MpmVoidsCheck(const MpmModel model)
{
  PetscFunctionBeginUser;
  for (PetscInt m = 0; m < model->scene.materials->count; m++)
    MpmCheckInput(!MpmMaterialIsAir(&model->scene.materials->at[m]) || !FindPart(model, PETSC_FALSE),
                  "-mpm_material_%s_air: not available with %s", model->scene.materials->names[m],
                  FindPart(model, PETSC_FALSE));
  MpmCheckInput(!model->scene.terms->backgrounds || !FindPart(model, PETSC_TRUE),
                "-mpm_backgrounds: not available with %s", FindPart(model, PETSC_TRUE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

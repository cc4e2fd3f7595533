/*
  Reading of a relaxation: of a stage, or in place of steps that give up.
*/
#include "options/options.h"
#include "scene/integrator_read.h"
#include "scene/stage_read.h"

#define RESCUE_STEPS 200000

void MpmRelaxationDefaults(MpmRelaxation *relaxation)
{
  *relaxation = (MpmRelaxation){.tolerance = 0.01, .factor = 0.8, .hold = -1., .steps = RESCUE_STEPS};
  MpmMotionDefaults(&relaxation->motion);
  relaxation->motion.type          = MPM_EXPLICIT;
  relaxation->motion.transfer.type = MPM_TRANSFER_FLIP;
}

PetscErrorCode MpmRelaxationRead(const MpmOptions *block, PetscBool rescue, MpmRelaxation *relaxation)
{
  static const char *const dampings[] = {"kinetic", "viscous", "local", NULL};
  static const char *const masses[]   = {"physical", "scaled", NULL};
  static const char *const places[]   = {"nodes", "points", NULL};
  PetscInt                 damping = (PetscInt)relaxation->damping, mass = relaxation->scaled ? 1 : 0;
  PetscInt                 place = relaxation->felt ? 1 : 0;

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsWord(block, "damping",
                           "kinetic: velocities become zero where the kinetic energy passes a peak; viscous: a force "
                           "2 xi m v; local: a part of each force that drives a node, against its velocity",
                           dampings, MPM_OPTIONAL, &damping, NULL));
  relaxation->damping = (MpmRelaxationDamping)damping;
  PetscCall(
    MpmOptionsReal(block, "tolerance", "-",
                   "the stage ends where the largest force out of balance over the largest load, and the kinetic "
                   "energy over the work of the loads, are below",
                   ((MpmRange){0., 1., PETSC_TRUE}), MPM_OPTIONAL, &relaxation->tolerance, NULL));
  PetscCall(MpmOptionsReal(block, "hold", "s",
                           "for so long without a break: with 0 it ends where they hold first; by default as long as "
                           "the slowest motion asks for",
                           MPM_RANGE_NON_NEGATIVE, MPM_OPTIONAL, &relaxation->hold, NULL));
  PetscCall(
    MpmOptionsWord(block, "nodal_mass",
                   "physical: the material's; scaled: raised where a node would ask for a shorter step than the "
                   "slowest material does",
                   masses, MPM_OPTIONAL, &mass, NULL));
  relaxation->scaled = (PetscBool)(mass == 1);
  PetscCall(
    MpmOptionsWord(block, "balance",
                   "forces out of balance are compared with the loads at the nodes, or as the points feel them: "
                   "nodes that few points touch have some that move no point",
                   places, MPM_OPTIONAL, &place, NULL));
  relaxation->felt = (PetscBool)(place == 1);
  if (damping == MPM_DAMPING_VISCOUS || MpmOptionsHelp())
    PetscCall(
      MpmOptionsReal(block, "xi", "1/s", "of viscous damping; fastest near the angular frequency of the slowest mode",
                     MPM_RANGE_POSITIVE, relaxation->xi > 0. ? MPM_OPTIONAL : MPM_REQUIRED, &relaxation->xi, NULL));
  if (damping == MPM_DAMPING_LOCAL || MpmOptionsHelp())
    PetscCall(MpmOptionsReal(block, "factor", "-", "of local damping", ((MpmRange){0., 1., PETSC_TRUE}), MPM_OPTIONAL,
                             &relaxation->factor, NULL));
  if (rescue || MpmOptionsHelp())
    PetscCall(MpmOptionsInt(block, "steps", "most steps of a rescue (time_rescue)", 1, PETSC_INT_MAX, MPM_OPTIONAL,
                            &relaxation->steps, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  The manual that -help prints, besides the output of the readers of options: an introduction, and an appendix.
*/
#include "geometry/geometry.h"
#include "model/manual.h"
#include "talus/talus.h"

static const char introduction[] =
  "A scene is a file in YAML (or one option a line). Each of its entries is an option: `mpm: grid: cells: \"60,60\"` "
  "is\n"
  "-mpm_grid_cells 60,60. What comes later on the command line overrides what came before.\n"
  "Blocks have names: `materials: clay` announces material_clay, whose modulus is -mpm_material_clay_E. Below, NAME\n"
  "stands for such a name. Lists are separated by commas; vectors have one number an axis, two in 2D and three in 3D.\n"
  "A material's number may be height:value pairs, or a file with columns height or x, y (, z) and the number.\n"
  "Units are SI where the scene is; in brackets: unit, what is accepted, and the default.\n"
  "\n"
  "Exit status: 0 completed; 2 the scene is wrong, nothing was written; 3 gave up, the results so far are there; 4 a\n"
  "file could not be written.\n";

static const char closing[] =
  "\nPETSc's options that are often of use\n"
  "  -snes_monitor                       residual of each Newton iteration\n"
  "  -ksp_monitor                        residual of each linear iteration\n"
  "  -snes_rtol, -snes_atol, -snes_stol  when Newton has converged\n"
  "  -snes_max_it                        Newton iterations after which a step is cut\n"
  "  -ksp_type, -pc_type, -ksp_rtol      the linear solver, instead of what -mpm_solver takes\n"
  "  -log_view                           time and flops by function\n"
  "  -options_left                       options that nobody has used\n"
  "  talus -help_petsc                   prints the others\n";

PetscErrorCode MpmHelpUsage(MPI_Comm comm, FILE *file)
{
  PetscFunctionBegin;
  PetscCall(PetscFPrintf(comm, file,
                         "usage: talus -options_file scene.yaml [options]\n"
                         "       mpiexec -n 4 talus -options_file scene.yaml [options]     in parallel\n"
                         "       talus -options_file scene.yaml -help                      the options of that scene\n"
                         "       talus -help                                               all options\n"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmHelpBegin(MPI_Comm comm)
{
  PetscFunctionBegin;
  PetscCall((*PetscHelpPrintf)(
    comm, "Talus %s: implicit material point method for soils, rocks, snow and structures\n\n", MPM_VERSION));
  PetscCall(MpmHelpUsage(comm, PETSC_STDOUT));
  PetscCall((*PetscHelpPrintf)(comm, "\n%s", introduction));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmHelpEnd(MPI_Comm comm)
{
  PetscFunctionBegin;
  PetscCall(MpmRegionPrintHelp(comm));
  PetscCall((*PetscHelpPrintf)(comm, "%s", closing));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmHelpPetsc(MPI_Comm comm)
{
  SNES snes;
  KSP  ksp;

  PetscFunctionBegin;
  PetscCall(PetscOptionsSetValue(NULL, "-help", NULL));
  PetscCall(SNESCreate(comm, &snes));
  PetscCall(SNESSetFromOptions(snes));
  PetscCall(SNESGetKSP(snes, &ksp));
  PetscCall(KSPSetFromOptions(ksp));
  PetscCall(SNESDestroy(&snes));
  PetscCall(PetscOptionsClearValue(NULL, "-help"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  The manual that -help prints, besides the output of the readers of options: an introduction, and an appendix.
*/
#include "geometry/geometry.h"
#include "model/manual.h"
#include "point/registry.h"
#include "query/scene.h"
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
  PetscCall(
    PetscFPrintf(comm, file,
                 "usage: talus SCENE.yaml [MORE.yaml ...] [-option value ...]      a run; - reads the scene "
                 "from stdin\n"
                 "       mpiexec -n 4 talus SCENE.yaml [-option value ...]         in parallel\n"
                 "       talus check SCENE.yaml [--picture FILE.png]               sizes, time, first step; a picture\n"
                 "       talus plot PREFIX [--help], talus view PREFIX             pictures of results\n"
                 "       talus new [NAME [FILE]]                                   a scene to start from\n"
                 "       talus check-law PLUGIN.so NAME                            tests of a plugin's law\n"
                 "       talus help [TOPIC | -mpm_option]                          part of the manual\n"
                 "       talus SCENE.yaml -help                                    the options of that scene\n"
                 "       talus -help, talus -help=json                             all options\n"
                 "       talus --version                                           version and build\n"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static const char first_steps[] =
  "\nA scene is a file in YAML; each of its entries is an option, too, and what comes later overrides it:\n\n"
  "  mpm:\n"
  "    dim: 2\n"
  "    grid:          {lower: \"0,0\", upper: \"4,2\", cells: \"16,8\"}\n"
  "    materials:     clay\n"
  "    material_clay: {type: mohr_coulomb, E: 1e7, nu: 0.3, cohesion: 5e3, friction: 25, density: 1800}\n"
  "    bodies:        ground\n"
  "    body_ground:   {region: box, lower: \"0,0\", upper: \"4,1\", material: clay}\n"
  "    bcs:           base\n"
  "    bc_base:       {region: box, lower: \"0,0\", upper: \"4,0\", components: \"x,y\"}\n"
  "    loads:         weight\n"
  "    load_weight:   {type: gravity, value: \"0,-9.81\"}\n"
  "    time:          {end: 1, step: 0.1}\n"
  "    output:        {prefix: ground}\n\n"
  "  talus ground.yaml -mpm_grid_refine 2 -snes_monitor\n\n"
  "Results: PREFIX.xdmf and PREFIX.h5 (points, for ParaView), PREFIX_history.csv (a row a step), PREFIX_summary.json,\n"
  "PREFIX_options.yaml (options in force), PREFIX_checkpoint.h5 (after an interruption, for -mpm_restart).\n\n"
  "Exit status: 0 completed; 2 the scene is wrong, nothing was written; 3 gave up, the results so far are there; 4 a\n"
  "file could not be written.\n\n"
  "Topics of `talus help`: scene, grid, material, a law (j2, mohr_coulomb, nor_sand, ...), body, region, condition,\n"
  "load, boundary, contact, surface, stage, time, water, output, track, solver, point; `talus help` lists all.\n";

PetscErrorCode MpmHelpShort(MPI_Comm comm)
{
  PetscFunctionBegin;
  PetscCall(PetscPrintf(comm, "Talus %s: implicit material point method for soils, rocks, snow and structures\n\n",
                        MPM_VERSION));
  PetscCall(MpmHelpUsage(comm, PETSC_STDOUT));
  PetscCall(PetscPrintf(comm, "%s", first_steps));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The options of a scene of this kind, as its reader has them. */
static PetscErrorCode CollectKind(MPI_Comm comm, const char physics[], const char dim[])
{
  MpmModel model;

  PetscFunctionBegin;
  PetscCall(PetscOptionsSetValue(NULL, "-mpm_physics", physics));
  PetscCall(PetscOptionsSetValue(NULL, "-mpm_dim", dim));
  PetscCall(MpmModelCreate(comm, &model));
  PetscCall(MpmModelSetFromOptions(model));
  PetscCall(MpmModelDestroy(&model));
  PetscCall(PetscOptionsClearValue(NULL, "-mpm_physics"));
  PetscCall(PetscOptionsClearValue(NULL, "-mpm_dim"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmHelpCollect(MPI_Comm comm, MpmCatalogue catalogue)
{
  const MpmOptions options = {comm, "mpm_", NULL};
  char            *words   = NULL, **physics;
  PetscInt         count;

  PetscFunctionBegin;
  PetscCall(MpmPluginsLoad(&options));
  PetscCall(MpmPhysicsList(&words));
  PetscCall(MpmTextAppend(&words, ", " MPM_STRESS_POINT));
  PetscCall(MpmTextSplit(words, &count, &physics));
  PetscCall(PetscOptionsSetValue(NULL, "-help", NULL));
  MpmCatalogueCollect(catalogue);
  for (PetscInt k = 0; k < count; k++) {
    PetscCall(MpmCatalogueSetScope(catalogue, physics[k]));
    PetscCall(CollectKind(comm, physics[k], "2"));
    PetscCall(CollectKind(comm, physics[k], "3"));
    if (k + 1 < count) PetscCall(MpmRegionPrintHelp(comm)); /* a stress point has none */
  }
  MpmCatalogueCollect(NULL);
  PetscCall(PetscOptionsClearValue(NULL, "-help"));
  PetscCall(MpmNamesDestroy(count, &physics));
  PetscCall(PetscFree(words));
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

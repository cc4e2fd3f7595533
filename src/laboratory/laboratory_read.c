/*
  The options of a laboratory: one test in the block `point`, or several in blocks of their own.
*/
#include "options/options.h"
#include "point/material.h"
#include "query/model.h"
#include "laboratory/laboratory_impl.h"

/* In plane strain yz and xz may be left out, and are 0. */
static PetscErrorCode ReadStress(const MpmOptions *block, PetscInt dim, PetscReal stress[MPM_SPACE_SYM])
{
  const MpmOptions silent = {block->comm, block->prefix, NULL};
  const char *help = dim == 2 ? "at the start, in the measure below: xx, yy, zz, xy (, yz, xz: 0); tension positive"
                              : "at the start, in the measure below: xx, yy, zz, xy, yz, xz; tension positive";
  PetscInt    size = MpmSymSize(dim), count;
  PetscReal  *values;

  PetscFunctionBeginUser;
  if (size < MPM_SPACE_SYM && !MpmOptionsHelp()) {
    PetscCall(MpmOptionsRealList(&silent, "stress", "Pa", help, MPM_OPTIONAL, &count, &values));
    if (count == MPM_SPACE_SYM && values[4] == 0. && values[5] == 0.) size = MPM_SPACE_SYM;
    PetscCall(PetscFree(values));
  }
  PetscCall(MpmOptionsReals(block, "stress", "Pa", help, MPM_RANGE_ANY, MPM_OPTIONAL, size, stress, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadTest(const MpmOptions *options, PetscInt dim, const char *const materials[],
                               MpmLaboratoryTest *test)
{
  const MpmOptions block   = {options->comm, test->prefix, options->record};
  PetscInt         measure = MPM_STRESS_CAUCHY, strain = MPM_STRAIN_LOG;

  PetscFunctionBeginUser;
  test->material = MpmOptionsHelp() ? -1 : 0;
  PetscCall(
    MpmOptionsWord(&block, "material", "one of -mpm_materials", materials, MPM_REQUIRED, &test->material, NULL));
  PetscCall(ReadStress(&block, dim, test->start));
  PetscCall(MpmOptionsWord(&block, "measure", "the stress that is prescribed and reported", MpmStressMeasures,
                           MPM_OPTIONAL, &measure, NULL));
  PetscCall(MpmOptionsWord(&block, "strain", "the strain that is prescribed and reported: ln V or sym F - I",
                           MpmStrainMeasures, MPM_OPTIONAL, &strain, NULL));
  test->stress_measure = (MpmStressMeasure)measure;
  test->strain_measure = (MpmStrainMeasure)strain;
  PetscCall(MpmPointPathRead(&block, dim, test->strain_measure, &test->path));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The tests of a scene by their names, or the one that has none. */
static PetscErrorCode ReadTests(const MpmOptions *options, const char *const materials[], MpmLaboratory *laboratory)
{
  PetscBool         point;
  MpmLaboratoryTest alone = {.prefix = "mpm_point_"};

  PetscFunctionBeginUser;
  if (MpmOptionsHelp()) PetscCall(ReadTest(options, laboratory->dim, materials, &alone));
  PetscCall(MpmOptionsBlocks(options, "tests",
                             "names of several tests at one time, instead of the block `point`, whose words their "
                             "blocks have; the history's columns have the names",
                             MPM_OPTIONAL, &laboratory->count, &laboratory->names));
  PetscCall(MpmOptionsHas(options, "point_path", &point));
  MpmCheckInput(!laboratory->count || !point || MpmOptionsHelp(),
                "-mpm_tests: the scene has the block point, too: it must be one of the tests");
  if (!laboratory->count) laboratory->count = 1;
  PetscCall(PetscCalloc1(laboratory->count, &laboratory->tests));
  for (PetscInt t = 0; t < laboratory->count; t++) {
    MpmLaboratoryTest *test = &laboratory->tests[t];

    *test = alone;
    if (laboratory->names) {
      test->name = laboratory->names[t];
      PetscCall(PetscSNPrintf(test->prefix, sizeof(test->prefix), "mpm_test_%s_", test->name));
    }
    PetscCall(ReadTest(options, laboratory->dim, materials, test));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* All tests end at one time. */
static PetscErrorCode CheckEnds(const MpmLaboratory *laboratory)
{
  const PetscReal first = MpmPointPathEnd(&laboratory->tests[0].path);

  PetscFunctionBeginUser;
  for (PetscInt t = 1; t < laboratory->count && !MpmOptionsHelp(); t++) {
    const PetscReal end = MpmPointPathEnd(&laboratory->tests[t].path);

    MpmCheckInput(end == first, "-mpm_tests: test %s ends at time %g, and test %s at %g: must end at one time",
                  laboratory->tests[0].name, (double)first, laboratory->tests[t].name, (double)end);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmLaboratoryRead(MpmModel model, const MpmOptions *options, PetscInt dim)
{
  MpmMaterials *materials = model->scene.materials;
  const char  **names;

  PetscFunctionBeginUser;
  MpmCheckInput(model->scene.deformation.kinematics != MPM_AXISYMMETRY || MpmOptionsHelp(),
                "-mpm_kinematics axisymmetric: a stress point has no radius; must be left out, or -mpm_dim 3");
  PetscCall(PetscNew(&model->laboratory));
  model->laboratory->dim = model->disc.dim = dim;
  PetscCall(MpmOptionsBlocks(options, "materials", "names of the material blocks", MPM_REQUIRED, &materials->count,
                             &materials->names));
  PetscCall(PetscCalloc1(materials->count, &materials->at));
  PetscCall(PetscCalloc1(materials->count + 1, &names));
  for (PetscInt m = 0; m < materials->count; m++) {
    PetscCall(MpmMaterialCreate(options, materials->names[m], dim, NULL, &materials->at[m]));
    names[m] = materials->names[m];
    if (materials->at[m].varies) {
      char *varying = NULL;

      PetscCall(MpmMaterialVaryingText(&materials->at[m], &varying));
      MpmCheckInput(PETSC_FALSE,
                    "-mpm_material_%s: %s by height or field, must be a number: a single point has no height",
                    materials->names[m], varying);
    }
  }
  PetscCall(MpmOptionsHeading(options, "Point"));
  PetscCall(ReadTests(options, names, model->laboratory));
  PetscCall(CheckEnds(model->laboratory));
  model->state.period.run_end = MpmPointPathEnd(&model->laboratory->tests[0].path);
  PetscCall(PetscFree(names));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmLaboratoryPrintHelp(MpmModel model, const MpmOptions *options)
{
  static const char *const names[] = {"NAME", NULL};
  MpmLaboratory           *laboratory;

  PetscFunctionBeginUser;
  PetscCall(PetscNew(&laboratory));
  laboratory->dim = model->disc.dim;
  PetscCall(MpmOptionsHeading(options, "Point, with physics " MPM_STRESS_POINT ": without grid, bodies and time"));
  PetscCall(ReadTests(options, names, laboratory));
  PetscCall(MpmLaboratoryDestroy(&laboratory));
  PetscFunctionReturn(PETSC_SUCCESS);
}

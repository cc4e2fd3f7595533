/*
  jacobians PLUGIN - how far apart the forms of the Jacobian are, for the plugin's law, its physics and its term, in 2D and
  3D, with every shape: a line each with the case and the distances of colouring, dense, actions with tangents and without,
  and differences.
*/
#include <talus/talus.h>

static const char *const blocks[] = {
  "-mpm_dim 2 -mpm_grid_lower 0,0 -mpm_grid_upper 3,2 -mpm_grid_cells 6,5 -mpm_body_b_lower 0.5,0.4 "
  "-mpm_body_b_upper 2.5,1.6 -mpm_bc_f_lower 0,0.4 -mpm_bc_f_upper 3,0.4 -mpm_bc_f_components x,y ",
  "-mpm_dim 3 -mpm_grid_lower 0,0,0 -mpm_grid_upper 2,2,1.2 -mpm_grid_cells 4,4,3 -mpm_body_b_lower 0.5,0.5,0.4 "
  "-mpm_body_b_upper 1.5,1.5,0.8 -mpm_bc_f_lower 0,0,0.4 -mpm_bc_f_upper 2,2,0.4 -mpm_bc_f_components x,y,z "};
#define TERM "-mpm_terms t -mpm_term_t_type foundation -mpm_term_t_stiffness 20 -mpm_term_t_stiffening 5e3"
static const struct {
  const char *name, *options;
  PetscBool   own; /* the physics keeps states of its own */
} kinds[] = {
  {"law", "-mpm_material_m_type fung -mpm_material_m_stiffening 0.8", PETSC_FALSE},
  {"physics", "-mpm_physics swelling -mpm_material_m_type neo_hookean", PETSC_TRUE},
  {"both", "-mpm_physics swelling -mpm_material_m_type fung", PETSC_TRUE},
  {"term", "-mpm_material_m_type neo_hookean " TERM, PETSC_FALSE},
  {"all", "-mpm_physics swelling -mpm_material_m_type fung " TERM, PETSC_TRUE},
};

/* What the physics keeps of a point is the largest solvent so far: after one step from none, that of now. */
static PetscErrorCode CheckOwn(MpmModel model)
{
  PetscInt   count, first;
  PetscReal *value, *own;

  PetscFunctionBeginUser;
  PetscCall(MpmModelFindState(model, NULL, "most_solvent", &first, NULL));
  PetscCall(MpmModelGetPointCount(model, &count, NULL));
  PetscCall(MpmModelGetPoints(model, "value", NULL, &value));
  PetscCall(MpmModelGetPoints(model, "own", NULL, &own));
  for (PetscInt p = 0; p < count; p++)
    PetscCheck(value[p] != 0. && PetscAbsReal(own[p + first] - PetscMax(value[p], 0.)) <= 1e-14, PETSC_COMM_SELF,
               PETSC_ERR_PLIB, "point %" PetscInt_FMT " keeps %g of %g", p, (double)own[p + first], (double)value[p]);
  PetscCall(MpmModelRestorePoints(model, "own", NULL, &own));
  PetscCall(MpmModelRestorePoints(model, "value", NULL, &value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static const char *const shapes[] = {"linear", "gimp", "bspline2", "bspline3", "gimp_bspline2"};

static PetscErrorCode Look(const char *plugin, PetscInt dim, size_t kind, const char *shape)
{
  char             options[4096];
  MpmModel         model;
  MpmJacobianCheck check;
  MpmStatus        status;

  PetscFunctionBeginUser;
  PetscCall(PetscSNPrintf(options, sizeof(options),
                          "%s%s -mpm_plugin %s -mpm_materials m -mpm_material_m_E 10 -mpm_material_m_nu 0.3 "
                          "-mpm_bodies b -mpm_body_b_material m -mpm_body_b_region box -mpm_bcs f -mpm_bc_f_region box "
                          "-mpm_material_m_density 1 -mpm_loads g -mpm_load_g_type gravity -mpm_load_g_value %s "
                          "-mpm_time_step 0.25 -mpm_shape %s",
                          blocks[dim - 2], kinds[kind].options, plugin, dim == 2 ? "0.5,-1" : "0.5,0.2,-1", shape));
  PetscCall(MpmModelCreate(PETSC_COMM_WORLD, &model));
  PetscCall(MpmModelSetOptions(model, options));
  PetscCall(MpmModelSetFromOptions(model));
  PetscCall(MpmModelStep(model, &status)); /* the forms are compared for a body that has moved */
  if (kinds[kind].own) PetscCall(CheckOwn(model));
  PetscCall(MpmModelCheckJacobian(model, 0.02, &check));
  PetscCall(PetscPrintf(PETSC_COMM_WORLD, "%s_%" PetscInt_FMT "d_%s %d %.3e %.3e %.3e %.3e %.3e\n", kinds[kind].name,
                        dim, shape, (int)status, (double)check.coloring, (double)check.dense, (double)check.matfree[0],
                        (double)check.matfree[1], (double)check.differences));
  PetscCall(MpmModelDestroy(&model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

int main(int argc, char **argv)
{
  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  for (PetscInt dim = 2; dim <= 3; dim++)
    for (size_t kind = 0; kind < sizeof(kinds) / sizeof(kinds[0]); kind++)
      for (size_t s = 0; s < sizeof(shapes) / sizeof(shapes[0]); s++) PetscCall(Look(argv[1], dim, kind, shapes[s]));
  PetscCall(PetscFinalize());
  return 0;
}

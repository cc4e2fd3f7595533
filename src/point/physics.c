/*
  The physics that are built in, and the layout of unknowns and kernel inputs that follows from a physics' fields.
*/
#include "point/point.h"

#define MPM_KERNEL_INSTANCE(name, dim, directions) \
  void MpmKernelCreate_##name##_##dim##d_##directions(MpmKernelSet *set);
#include "mpm_kernels.h"
#undef MPM_KERNEL_INSTANCE

int MpmStretchDiagonal_2d_0(const double *F, double *diagonal);
int MpmStretchDiagonal_3d_0(const double *F, double *diagonal);

static const struct {
  const char *name;
  PetscInt    dim;
  void (*create)(MpmKernelSet *set);
} kernels[] = {
#define MPM_KERNEL_INSTANCE(name, dim, directions) {#name, dim, MpmKernelCreate_##name##_##dim##d_##directions},
#include "mpm_kernels.h"
#undef MPM_KERNEL_INSTANCE
};

static const MpmField solid_fields[] = {
  {"displacement", 0, PETSC_FALSE, PETSC_TRUE, PETSC_TRUE, PETSC_FALSE},
};

static const MpmPhysics physics_list[] = {
  {.name = "solid", .summary = "quasi-static solid at finite strain", .field_count = 1, .fields = solid_fields},
  {.name        = "solid_fbar",
   .summary     = "quasi-static solid with the volume change averaged over cells",
   .field_count = 1,
   .fields      = solid_fields},
};

PetscErrorCode MpmPhysicsCreate(const char *name, MpmPhysics *physics, PetscBool *found)
{
  PetscFunctionBeginUser;
  *found = PETSC_FALSE;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(physics_list); k++) {
    if (strcmp(physics_list[k].name, name)) continue;
    *physics = physics_list[k];
    *found   = PETSC_TRUE;
  }
  for (PetscInt k = 0; !*found && MpmPhysicsRegistered(k); k++) {
    if (strcmp(MpmPhysicsRegistered(k)->name, name)) continue;
    *physics = *MpmPhysicsRegistered(k);
    *found   = PETSC_TRUE;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  for (size_t k = 0; *found && k < PETSC_STATIC_ARRAY_LENGTH(kernels); k++) {
    if (!strcmp(kernels[k].name, name)) kernels[k].create(&physics->kernels[kernels[k].dim]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

MpmStretch MpmStretchFind(PetscInt dim)
{
  return dim == 2 ? MpmStretchDiagonal_2d_0 : MpmStretchDiagonal_3d_0;
}

PetscErrorCode MpmLayoutCreate(const MpmPhysics *physics, PetscInt dim, MpmLayout *layout)
{
  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(layout, sizeof(*layout)));
  layout->dim    = dim;
  layout->kernel = &physics->kernels[dim];
  for (PetscInt f = 0; f < physics->field_count; f++) {
    const MpmField *field      = &physics->fields[f];
    const PetscInt  components = field->components ? field->components : dim;

    for (PetscInt c = 0; c < components; c++) {
      const PetscInt b = layout->block++;

      PetscCheck(b < MPM_MAX_BLOCK, PETSC_COMM_SELF, PETSC_ERR_SUP, "physics %s has more than %d unknowns a node",
                 physics->name, MPM_MAX_BLOCK);
      layout->component_name[b] = field->increment ? (const char *const[]){"x", "y", "z"}[c] : field->name;
      layout->increment[b]      = field->increment;
      layout->basis_first[b]    = field->value ? 0 : 1;
      if (field->rate) layout->rate_component[layout->rates++] = b;
      for (PetscInt basis = layout->basis_first[b]; basis <= (field->gradient ? dim : 0); basis++) {
        PetscCheck(layout->inputs < MPM_MAX_INPUTS, PETSC_COMM_SELF, PETSC_ERR_SUP,
                   "physics %s has more than %d kernel inputs", physics->name, MPM_MAX_INPUTS);
        layout->component_of[layout->inputs] = b;
        layout->basis_of[layout->inputs++]   = basis;
      }
      layout->component_first[b + 1] = layout->inputs;
    }
  }
  layout->means = layout->kernel->mean ? 1 : 0;
  layout->solid = (PetscBool)(physics->field_count == 1 && layout->inputs == dim * dim && layout->block == dim);
  PetscCheck(layout->kernel->inputs == layout->inputs + layout->means && layout->kernel->residual &&
               layout->kernel->direction && layout->kernel->tangent,
             PETSC_COMM_SELF, PETSC_ERR_PLIB, "physics %s: kernel with %d inputs, fields with %" PetscInt_FMT,
             physics->name, layout->kernel->inputs, layout->inputs);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscBool MpmLayoutUsesValues(const MpmLayout *layout)
{
  for (PetscInt k = 0; k < layout->inputs; k++)
    if (!layout->basis_of[k]) return PETSC_TRUE;
  return PETSC_FALSE;
}

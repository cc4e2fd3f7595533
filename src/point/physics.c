/*
  The physics that are built in, and the layout of unknowns and kernel inputs that follows from a physics' fields.
*/
#include "point/layout.h"
#include "point/material.h"
#include "point/registry.h"

#define MPM_KERNEL_INSTANCE(name, kinematics, kind, directions) \
  void MpmKernelCreate_##name##_##kind##_##directions(MpmKernelSet *set);
#include "mpm_kernels.h"
#undef MPM_KERNEL_INSTANCE

int MpmStretchDiagonal_2d_0(const double *F, double *diagonal);
int MpmStretchDiagonal_3d_0(const double *F, double *diagonal);
int MpmStretchQuick_2d_0(const double *F, double *diagonal);
int MpmStretchQuick_3d_0(const double *F, double *diagonal);

static const struct {
  const char *name;
  int         kinematics;
  void (*create)(MpmKernelSet *set);
} kernels[] = {
#define MPM_KERNEL_INSTANCE(name, kinematics, kind, directions) \
  {#name, kinematics, MpmKernelCreate_##name##_##kind##_##directions},
#include "mpm_kernels.h"
#undef MPM_KERNEL_INSTANCE
};

#define MPM_PHYSICS_NAME(name) void MpmPhysicsDescribe_##name(MpmPhysics *physics);
#include "mpm_physics.h"
#undef MPM_PHYSICS_NAME

static void (*const describe[])(MpmPhysics *physics) = {
#define MPM_PHYSICS_NAME(name) MpmPhysicsDescribe_##name,
#include "mpm_physics.h"
#undef MPM_PHYSICS_NAME
};

PetscErrorCode MpmPhysicsList(char **words)
{
  PetscFunctionBeginUser;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(describe); k++) {
    MpmPhysics physics = {.name = NULL};

    describe[k](&physics);
    if (!(physics.traits & MPM_PHYSICS_INTERNAL))
      PetscCall(MpmTextAppend(words, "%s%s", *words ? ", " : "", physics.name));
  }
  for (PetscInt k = 0; MpmPhysicsRegistered(k); k++)
    PetscCall(MpmTextAppend(words, ", %s", MpmPhysicsRegistered(k)->name));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPhysicsCreate(const char *name, MpmPhysics *physics, PetscBool *found)
{
  PetscFunctionBeginUser;
  *found = PETSC_FALSE;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(describe) && !*found; k++) {
    PetscCall(PetscMemzero(physics, sizeof(*physics)));
    describe[k](physics);
    PetscCall(PetscStrcmp(physics->name, name, found));
  }
  for (PetscInt k = 0; !*found && MpmPhysicsRegistered(k); k++) {
    if (strcmp(MpmPhysicsRegistered(k)->name, name)) continue;
    *physics = *MpmPhysicsRegistered(k);
    *found   = PETSC_TRUE;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  for (size_t k = 0; *found && k < PETSC_STATIC_ARRAY_LENGTH(kernels); k++) {
    if (strcmp(kernels[k].name, name)) continue;
    kernels[k].create(&physics->kernels[kernels[k].kinematics]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

MpmStretch MpmStretchFind(PetscInt dim)
{
  static const MpmStretch stretch[] = {[2] = MpmStretchDiagonal_2d_0, [3] = MpmStretchDiagonal_3d_0};

  return stretch[dim];
}

MpmStretch MpmStretchFindQuick(PetscInt dim)
{
  static const MpmStretch stretch[] = {[2] = MpmStretchQuick_2d_0, [3] = MpmStretchQuick_3d_0};

  return stretch[dim];
}

/* The shape of a field, among those of other fields. */
static PetscErrorCode FindShape(const MpmPhysics *physics, PetscInt f, MpmLayout *layout, PetscInt *shape)
{
  const MpmField     *field  = &physics->fields[f];
  const MpmFieldShape wanted = {field->degree, PetscMax(field->spacing, 1)};

  PetscFunctionBeginUser;
  PetscCheck(wanted.degree >= 0 && wanted.degree <= 3 && field->spacing >= 0, PETSC_COMM_SELF, PETSC_ERR_SUP,
             "physics %s, field %s: degree %d must be 0 to 3, spacing %d at least 0", physics->name, field->name,
             field->degree, field->spacing);
  if (!f) layout->shape[layout->shape_count++] = (MpmFieldShape){0, 1};
  for (*shape = 0; *shape < layout->shape_count; (*shape)++)
    if (layout->shape[*shape].degree == wanted.degree && layout->shape[*shape].spacing == wanted.spacing) break;
  PetscCheck(f || !*shape, PETSC_COMM_SELF, PETSC_ERR_SUP,
             "physics %s, field %s: the first field has the scene's shape", physics->name, field->name);
  PetscCheck(*shape < MPM_MAX_SHAPES, PETSC_COMM_SELF, PETSC_ERR_SUP, "physics %s has fields of more than %d shapes",
             physics->name, MPM_MAX_SHAPES);
  if (*shape == layout->shape_count) layout->shape[layout->shape_count++] = wanted;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscBool UsesBasis(const MpmField *field, PetscInt dim, PetscInt basis)
{
  if (!basis) return (PetscBool)(field->value != 0);
  return (PetscBool)((basis == MPM_DEVIATION(dim) ? field->deviation : basis <= dim && field->gradient) != 0);
}

/* Sets the remaining members of a layout that has its fields, and checks that the kernel takes these. */
static PetscErrorCode SetTraits(const MpmPhysics *physics, MpmLayout *layout)
{
  const PetscInt dim = layout->dim;

  PetscFunctionBeginUser;
  for (PetscInt s = 0; s < physics->state_count; s++) layout->own.size += MpmStateComponents(&physics->states[s], dim);
  layout->own.taken_up = physics->taken_up - 1;
  for (int k = 0; physics->taken_up && k < physics->parameter_count; k++)
    layout->own.taken_up += MpmParameterPlaces(&physics->parameters[k]);
  layout->means         = layout->kernel->mean ? 1 : 0;
  layout->ghost         = physics->ghost;
  layout->traits.saddle = (PetscBool)((physics->traits & MPM_PHYSICS_SADDLE) != 0);
  layout->traits.solid =
    (PetscBool)(physics->field_count == 1 && layout->input.count == MpmKinematicsF((int)layout->kinematics) &&
                layout->block == dim && layout->motion);
  layout->traits.alternate = (PetscBool)((physics->traits & MPM_PHYSICS_ALTERNATE) != 0);
  layout->traits.biot      = (PetscBool)((physics->traits & MPM_PHYSICS_BIOT) != 0);
  PetscCheck(
    !layout->traits.biot || (physics->field_count == 2 && layout->shape_count == 1 && layout->block == dim + 1 &&
                             layout->input.by_component.first[dim] == MpmKinematicsF((int)layout->kinematics) &&
                             layout->input.count == MpmKinematicsF((int)layout->kinematics) + dim + 2),
    PETSC_COMM_SELF, PETSC_ERR_PLIB, "physics %s: its fields are not those of MPM_PHYSICS_BIOT", physics->name);
  PetscCheck(layout->kernel->inputs == layout->input.count + layout->means && layout->kernel->residual &&
               layout->kernel->direction && layout->kernel->tangent,
             PETSC_COMM_SELF, PETSC_ERR_PLIB, "physics %s: kernel with %d inputs, fields with %" PetscInt_FMT,
             physics->name, layout->kernel->inputs, layout->input.count);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Lists the inputs by component. */
static void SortInputs(MpmLayout *layout)
{
  PetscInt count = 0;

  for (PetscInt c = 0; c < layout->block; c++) {
    for (PetscInt k = 0; k < layout->input.count; k++)
      if (layout->input.component[k] == c) layout->input.by_component.input[count++] = k;
    layout->input.by_component.first[c + 1] = count;
  }
}

PetscErrorCode MpmLayoutCreate(const MpmPhysics *physics, PetscInt kinematics, MpmLayout *layout)
{
  static const char *const axes[] = {"x", "y", "z"};
  const PetscInt           dim    = MpmKinematicsDim((int)kinematics);

  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(layout, sizeof(*layout)));
  layout->dim         = dim;
  layout->kinematics  = (MpmKinematics)kinematics;
  layout->kernel      = &physics->kernels[kinematics];
  layout->field_count = physics->field_count;
  layout->motion      = physics->fields[0].increment ? dim : 0;
  for (PetscInt f = 0; f < physics->field_count; f++) {
    const MpmField *field      = &physics->fields[f];
    const PetscInt  components = field->components ? field->components : dim;
    PetscInt        shape;

    PetscCall(FindShape(physics, f, layout, &shape));
    for (PetscInt c = 0; c < components; c++) {
      const PetscInt b = layout->block++;

      PetscCheck(b < MPM_MAX_BLOCK, PETSC_COMM_SELF, PETSC_ERR_SUP, "physics %s has more than %d unknowns a node",
                 physics->name, MPM_MAX_BLOCK);
      layout->component[b].name      = f || field->components ? field->name : axes[c];
      layout->component[b].symbol    = field->symbol;
      layout->component[b].near_null = field->near_null;
      layout->component[b].scale     = field->scale;
      layout->component[b].increment = (PetscBool)field->increment;
      layout->component[b].negative  = (PetscBool)field->negative;
      layout->component[b].shape     = shape;
      layout->component[b].field     = f;
      if (field->rate) layout->rate.component[layout->rate.count++] = b;
      PetscCheck(!field->deviation || (field->rate && field->gradient && layout->shape[shape].spacing == 1),
                 PETSC_COMM_SELF, PETSC_ERR_SUP,
                 "physics %s, field %s: a deviation needs a rate, the gradient, and nodes on the grid's lattice",
                 physics->name, field->name);
      if (field->deviation) layout->deviation.component[layout->deviation.count++] = b;
      for (PetscInt basis = 0; basis < MPM_BASES; basis++) {
        if (!UsesBasis(field, dim, basis)) continue;
        PetscCheck(layout->input.count < MPM_MAX_INPUTS, PETSC_COMM_SELF, PETSC_ERR_SUP,
                   "physics %s has more than %d kernel inputs", physics->name, MPM_MAX_INPUTS);
        layout->input.component[layout->input.count] = b;
        layout->input.basis[layout->input.count++]   = shape * MPM_BASES + basis;
      }
    }
    if (!f && layout->motion && layout->kinematics == MPM_AXISYMMETRY) {
      layout->input.component[layout->input.count] = 0;
      layout->input.basis[layout->input.count++]   = MPM_HOOP_BASIS;
    }
  }
  SortInputs(layout);
  PetscCall(SetTraits(physics, layout));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscBool MpmLayoutUsesValues(const MpmLayout *layout)
{
  for (PetscInt k = 0; k < layout->input.count; k++)
    if (layout->input.basis[k] % MPM_BASES == 0 || layout->input.basis[k] % MPM_BASES == MPM_DEVIATION(layout->dim) ||
        (layout->kinematics == MPM_AXISYMMETRY && layout->input.basis[k] == MPM_HOOP_BASIS))
      return PETSC_TRUE;
  return PETSC_FALSE;
}

PetscBool MpmLayoutUsesDeviation(const MpmLayout *layout, PetscInt shape)
{
  for (PetscInt k = 0; k < layout->deviation.count; k++)
    if (layout->component[layout->deviation.component[k]].shape == shape) return PETSC_TRUE;
  return PETSC_FALSE;
}

PetscInt MpmPressureComponent(const MpmLayout *layout)
{
  for (PetscInt r = 0; r < layout->rate.count; r++) {
    const PetscInt c = layout->rate.component[r];

    if (layout->component[c].scale != MPM_SCALE_STRESS) continue;
    for (PetscInt k = layout->input.by_component.first[c]; k < layout->input.by_component.first[c + 1]; k++)
      if (layout->input.basis[layout->input.by_component.input[k]] == 1) return c;
  }
  return -1;
}

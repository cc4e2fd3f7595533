/*
  Options of a boundary whose place is solved for.

    free       components of its motion that are solved for: x, y, z, rx, ry, rz (2D: x, y, rz); the others follow
               `motion`
    load       force on it, N (2D: per metre), times load_ramp
    moment     about its reference point, N m (2D: one number), times load_ramp
    mass       kg (2D: per metre): its weight where gravity acts, and its inertia in implicit dynamics
    inertia    its moment of inertia, kg m2, about any axis (2D: z, per metre); the reference point is its centre of
               mass
    velocity   as the scene begins, m/s
*/
#include "options/options.h"
#include "geometry/geometry.h"
#include "rigid/rigid_motion.h"

#include <math.h>

/* A component's name as a bit of translations or rotations. */
static PetscErrorCode TakeComponent(const MpmOptions *block, PetscInt dim, const char *name, PetscInt free[2])
{
  static const char *const all[]    = {[2] = "x, y, rz", [3] = "x, y, z, rx, ry, rz"};
  const PetscBool          rotation = (PetscBool)(name[0] == 'r');
  const char               axis     = name[rotation];
  const PetscInt first = rotation ? MpmRotationAxis(dim, 0) : 0, last = rotation ? 2 : dim - 1, at = axis - 'x';

  PetscFunctionBeginUser;
  MpmCheckInput(strlen(name) == 1 + (size_t)rotation && at >= first && at <= last, "-%sfree %s: must be one of %s",
                block->prefix, name, all[dim]);
  free[rotation] |= 1 << (at - first);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Mass, and options that belong to it. */
static PetscErrorCode ReadMass(const MpmOptions *block, PetscInt dim, MpmFreedom *freedom)
{
  PetscFunctionBeginUser;
  PetscCall(MpmOptionsReal(block, "mass", "kg", "its mass (2D: per metre), with `free`: weight and inertia",
                           MPM_RANGE_NON_NEGATIVE, MPM_OPTIONAL, &freedom->mass, NULL));
  PetscCall(
    MpmOptionsReal(block, "inertia", "kg m2",
                   "its moment of inertia about its reference point (2D: per metre), which is its centre of mass",
                   MPM_RANGE_POSITIVE, MPM_OPTIONAL, &freedom->inertia, NULL));
  PetscCall(MpmOptionsReals(block, "velocity", "m/s", "its velocity as the scene begins, with a mass", MPM_RANGE_ANY,
                            MPM_OPTIONAL, dim, freedom->velocity, NULL));
  if (MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  MpmCheckInput(!(freedom->mass > 0.) || !freedom->free[1] || freedom->inertia > 0.,
                "-%sinertia: is missing; a body with a mass that turns has one, kg m2", block->prefix);
  for (PetscInt a = 0; a < dim; a++)
    MpmCheckInput(freedom->velocity[a] == 0. || (freedom->mass > 0. && freedom->free[0] >> a & 1),
                  "-%svelocity: needs a mass, and a component of the motion that is among -%sfree", block->prefix,
                  block->prefix);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Refuses loads without `free`, or along constrained components. */
static PetscErrorCode CheckPush(const MpmOptions *block, const char *option, const PetscReal push[], PetscInt free,
                                PetscInt count)
{
  PetscFunctionBeginUser;
  for (PetscInt a = 0; a < count; a++)
    MpmCheckInput(push[a] == 0. || free >> a & 1,
                  "-%s%s: it acts in a component of the motion that is not among -%sfree", block->prefix, option,
                  block->prefix);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Refuses a motion of a component that is solved for. */
static PetscErrorCode CheckMotion(const MpmOptions *block, const MpmBoundary *boundary, const MpmFreedom *freedom)
{
  const MpmMotion *motion = &boundary->motion;
  const PetscInt   dim    = boundary->dim;

  PetscFunctionBeginUser;
  for (PetscInt a = 0; a < dim; a++)
    MpmCheckInput(boundary->motion.translation[a] == 0. || !(freedom->free[0] >> a & 1),
                  "-%smotion: must be 0 along axis %c, which is among -%sfree", block->prefix, "xyz"[a],
                  block -> prefix);
  for (PetscInt k = 0; k < MpmRotationCount(dim); k++)
    MpmCheckInput(boundary->motion.rotation[MpmRotationAxis(dim, k)] == 0. || !(freedom->free[1] >> k & 1),
                  "-%srotation: must be 0 about axis %c, which is among -%sfree", block->prefix,
                  "xyz"[MpmRotationAxis(dim, k)], block -> prefix);
  for (PetscInt k = 0; k < 6 * motion->rows; k++) {
    const PetscInt a = k % 3, turns = k % 6 / 3, bit = turns ? PetscMax(a - MpmRotationAxis(dim, 0), 0) : a;

    MpmCheckInput(motion->value[k] == 0. || !(freedom->free[turns] >> bit & 1),
                  "-%smotion_table: column %s%c must be 0, for %s%c is among -%sfree", block->prefix, turns ? "r" : "u",
                  "xyz"[a], turns ? "r" : "", "xyz"[a], block -> prefix);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode CheckAbsent(const MpmOptions *block)
{
  static const char *const options[] = {"load", "moment", "load_ramp", "mass", "inertia", "velocity"};

  PetscFunctionBeginUser;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(options); k++) {
    PetscBool has;

    PetscCall(MpmOptionsHas(block, options[k], &has));
    MpmCheckInput(!has, "-%s%s: its motion is prescribed; name what is solved for with -%sfree", block->prefix,
                  options[k], block->prefix);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmFreedomRead(const MpmOptions *block, const MpmBoundary *boundary, MpmFreedom **handle)
{
  const PetscInt dim = boundary->dim;
  MpmFreedom    *freedom;
  PetscInt       count               = 0;
  char         **names               = NULL;
  PetscReal      moment[MPM_MAX_DIM] = {0., 0., 0.};

  PetscFunctionBeginUser;
  *handle = NULL;
  PetscCall(MpmOptionsNames(block, "free",
                            "components of its motion that are solved for, of x, y, z, rx, ry, rz (2D: x, y, rz); the "
                            "others follow its motion",
                            MPM_OPTIONAL, &count, &names));
  if (!count && !MpmOptionsHelp()) {
    PetscCall(CheckAbsent(block));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(PetscNew(handle));
  freedom = *handle;
  for (PetscInt k = 0; k < count; k++) PetscCall(TakeComponent(block, dim, names[k], freedom->free));
  PetscCall(MpmNamesDestroy(count, &names));
  PetscCall(MpmOptionsReals(block, "load", "N", "force on it in total (2D: per metre), with `free`", MPM_RANGE_ANY,
                            MPM_OPTIONAL, dim, freedom->load, NULL));
  PetscCall(MpmOptionsReals(block, "moment", "N m", "moment on it in total (2D: one number, per metre), with `free`",
                            MPM_RANGE_ANY, MPM_OPTIONAL, MpmRotationCount(dim), moment, NULL));
  if (!MpmOptionsHelp()) {
    PetscCall(CheckMotion(block, boundary, freedom));
    PetscCall(CheckPush(block, "load", freedom->load, freedom->free[0], dim));
    PetscCall(CheckPush(block, "moment", moment, freedom->free[1], MpmRotationCount(dim)));
  }
  for (PetscInt k = 0; k < MpmRotationCount(dim); k++) freedom->moment[MpmRotationAxis(dim, k)] = moment[k];
  PetscCall(ReadMass(block, dim, freedom));
  PetscCall(MpmRampCreate(block, "load_ramp", "0:0,1:1", &freedom->ramp));
  freedom->size = MpmSolidSize(&boundary->solid);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmFreedomDestroy(MpmFreedom **freedom)
{
  PetscFunctionBeginUser;
  if (!*freedom) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmRampDestroy(&(*freedom)->ramp));
  PetscCall(PetscFree(*freedom));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscBool MpmFreedomIsSymmetric(const MpmFreedom *freedom)
{
  PetscInt rotations = 0;

  if (MpmFreedomTurnsInPart(freedom)) return PETSC_FALSE;
  for (PetscInt a = 0; a < 3; a++) rotations += freedom->free[1] >> a & 1;
  for (PetscInt a = 0; a < 3; a++)
    if (rotations > 1 && freedom->moment[a] != 0.) return PETSC_FALSE;
  return PETSC_TRUE;
}

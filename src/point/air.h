#pragma once
/*
  Air: a soft material in place of void, without loads, contacts and tracks, and not written.
*/
#include "point/material.h"

#define MPM_MATERIAL_AIR (1u << 28) /* a trait of a material, beside those of its law */

static inline PetscBool MpmMaterialIsAir(const MpmMaterial *material)
{
  return (PetscBool)((material->info.traits & MPM_MATERIAL_AIR) != 0);
}

/* Reads -mpm_material_NAME_air of a material that has been created (material.c). */
PetscErrorCode MpmMaterialReadAir(const MpmOptions *options, MpmMaterial *material);

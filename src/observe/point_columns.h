#pragma once
/*
  Fields of the points that are written: the register (point_columns.c), the parts with rows in it, and the output
  (fields.c).
*/
#include "base/base.h"
#include "base/types.h"
#include "talus/parts.h"

/* A row without `fill` is a field of the points as they have it. */
typedef struct {
  PetscInt        count;
  MpmPointColumn *at;
} MpmPointColumns;

/* Registers a row, unless there is one of the name: several laws have the same history. */
PetscErrorCode MpmPointColumnsAdd(MpmPointColumns *columns, const MpmPointColumn *row);
PetscBool      MpmPointColumnsHave(const MpmPointColumns *columns, const char name[]);
/* Kinematics, stress and mass (point_fields.c); histories, parameters that vary, values of the physics
   (state_fields.c). */
PetscErrorCode MpmPointsAddColumns(MpmModel model, MpmPointColumns *columns);
PetscErrorCode MpmStatesAddColumns(MpmModel model, MpmPointColumns *columns);
PetscErrorCode MpmTerrainAddFields(MpmModel model, MpmPointColumns *columns); /* of columns on a bed */

/* Fields made from others, written on request alone (derived_fields.c). */
PetscErrorCode MpmDerivedAddColumns(MpmModel model, MpmPointColumns *columns);

/* F of a point as the results have it, nine components; in plane strain the third axis does not stretch. */
void MpmPointDeformation(PetscInt dim, const MpmPoints *points, PetscInt p, PetscReal F[9]);
/* A symmetric tensor of 4 or 6 components as the results have it: xx, yy, zz, xy, yz, xz. */
static inline void MpmSymToSpace(PetscInt size, const PetscReal from[], PetscReal to[])
{
  for (PetscInt c = 0; c < 6; c++) to[c] = c < size ? from[c] : 0.;
}

/* Registers all fields of the scene, and the caller's; checks that chosen ones are among them. */
PetscErrorCode MpmFieldsSetUp(MpmModel model);
/* Writes the chosen ones to the output. */
PetscErrorCode MpmFieldsWrite(MpmModel model);

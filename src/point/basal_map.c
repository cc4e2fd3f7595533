/*
  Parameters of laws of the bed by maps.
*/
#include <string.h>
#include "options/database.h"
#include "options/options.h"
#include "maps/map_fill.h"
#include "point/basal_map.h"

/* Numbers, lists and tables have these signs alone; a file's name has others. */
static PetscBool IsName(const char text[])
{
  return (PetscBool)(text[strspn(text, "0123456789+-.eE:, \t")] != '\0' && strchr(text, '.') != NULL);
}

PetscErrorCode MpmBasalMapRead(const MpmOptions *block, const MpmParameter *parameter, MpmMap *map, PetscBool *is)
{
  const MpmPlane *plane                    = MpmRecordPlane(block->record);
  const MpmRange  range                    = {parameter->lower, parameter->upper, (PetscBool)(parameter->open != 0)};
  MpmMapAsk       ask                      = {.band = 1};
  char            message[MPM_MAP_MESSAGE] = "", text[MPM_RANGE_TEXT], name[256], must[MPM_MUST_TEXT];
  const char     *value;
  char           *path, *missing;
  PetscBool       given;

  PetscFunctionBeginUser;
  *is = PETSC_FALSE;
  if (parameter->kind != MPM_NUMBER) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscSNPrintf(name, sizeof(name), "-%s%s", block->prefix, parameter->name));
  PetscCall(MpmDatabaseFind(&name[1], &value, &given));
  if (!given || !value || !IsName(value)) PetscFunctionReturn(PETSC_SUCCESS);
  *is = PETSC_TRUE;
  PetscCall(MpmOptionsPath(block, parameter->name, parameter->help, MPM_REQUIRED, &path));
  if (MpmOptionsHelp()) PetscFunctionReturn(PetscFree(path));
  if (plane) {
    ask.project = plane->project;
    PetscCall(PetscArraycpy(ask.origin, plane->origin, 2));
  }
  PetscCall(MpmMapRead(path, &ask, map, message));
  MpmCheckInput(!message[0], "%s %s: %s", name, path, message);
  PetscCall(MpmMapFill(map, &missing));
  PetscCall(PetscFree(missing));
  MpmRangeText(range, text);
  MpmMustText(text, parameter->unit, must);
  for (PetscInt64 k = 0; k < (PetscInt64)map->columns * map->rows; k++)
    MpmCheckInput(MpmRangeHolds(range, map->value[k]), "%s %s: has %g, %s", name, path, (double)map->value[k], must);
  PetscCall(PetscFree(path));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmBasalMapLeast(const MpmOptions *block, const MpmParameter *parameter, double *least, PetscBool *is)
{
  MpmMap map = {0};

  PetscFunctionBeginUser;
  PetscCall(MpmBasalMapRead(block, parameter, &map, is));
  if (!*is || MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  *least = map.value[0];
  for (PetscInt64 k = 0; k < (PetscInt64)map.columns * map.rows; k++) *least = PetscMin(*least, map.value[k]);
  PetscCall(MpmMapDestroy(&map));
  PetscFunctionReturn(PETSC_SUCCESS);
}

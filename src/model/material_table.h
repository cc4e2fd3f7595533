#pragma once
/*
  Materials by the rows of a table (material_table.c).
*/
#include "files/csv_table.h"
#include "options/database.h"
#include "options/options.h"

typedef struct {
  char              *path;        /* NULL: there is none */
  PetscInt           first, name; /* place of its first material among all; its column of names */
  PetscInt           row;         /* being read */
  MpmCsvTable        csv;
  MpmOptions         options; /* of the row */
  PetscOptions       database;
  PetscInt           given_count;
  MpmDatabaseOption *given; /* all options of the scene, lent by its database */
  char              *given_text;
} MpmMaterialTable;

/* Reads -mpm_materials and -mpm_materials_file: the names of all materials. Collective. Starts from zeros. */
PetscErrorCode MpmMaterialTableRead(const MpmOptions *options, PetscInt *count, char ***names, MpmMaterialTable *table);
/*
  MpmMaterialTableEnter - options from which material m is read

  Output Parameter:
. read - the scene's options; of a material of the table those of its row in a database of their own, until
         MpmMaterialTableLeave(). The scene's options for the material replace cells
*/
PetscErrorCode MpmMaterialTableEnter(const MpmOptions *options, const char name[], PetscInt m, MpmMaterialTable *table,
                                     const MpmOptions **read);
/* Ends that, and passes on a failure in between; a cell that nobody has asked for fails with MPM_ERR_INPUT. */
PetscErrorCode MpmMaterialTableLeave(const MpmOptions *options, PetscErrorCode failed, MpmMaterialTable *table);
PetscErrorCode MpmMaterialTableDestroy(MpmMaterialTable *table);

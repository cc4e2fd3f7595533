#pragma once
/*
  The history's columns, and its file (history.c).
*/
#include "base/base.h"
#include "base/types.h"
#include "io/io.h"
#include "talus/talus.h"

/* Columns that any run has: step, time, dt, newton, linear, cuts. */
PetscErrorCode MpmStepAddColumns(MpmModel model, MpmColumns *columns);
/* Forces of conditions, motions and boundaries, and places of the latter; flow out of surfaces (reactions.c). */
PetscErrorCode MpmReactionsAddColumns(MpmModel model, MpmColumns *columns);
PetscErrorCode MpmDamsAddColumns(MpmModel model, MpmColumns *columns); /* forces of a flow on dams of its bed */
PetscErrorCode MpmOutflowAddColumns(MpmModel model, MpmColumns *columns);

/* Energy that fracture has dissipated, and the largest damage (damage_columns.c). */
PetscErrorCode MpmDamageAddColumns(MpmModel model, MpmColumns *columns);

/* A number of the last step's discrete decisions (signature.c), collective; and column `signature`, where
   -mpm_output_signature asks for it. */
PetscErrorCode MpmSignatureFind(MpmModel model, PetscReal *signature);
PetscErrorCode MpmSignatureAddColumns(MpmModel model, MpmColumns *columns);

/* The scene's columns of the history of a scene on a grid. */
PetscErrorCode MpmHistoryAddColumns(MpmModel model, MpmColumns *columns);
/* Opens the file once the columns of the scene are known, or takes it up where a run goes on; writes the options. */
PetscErrorCode MpmHistoryOpen(MpmModel model);
/* The history (number 0) or a file of the lines, where the checkpoint has it. */
PetscErrorCode MpmHistoryResume(MpmModel model, const char *path, PetscInt number, PetscInt columns,
                                const char *const names[], MpmHistory *table);
/* The history of a scene on a grid, with the files of its lines; and the row of a step. */
PetscErrorCode MpmModelCreateHistory(MpmModel model);
PetscErrorCode MpmModelWriteHistory(MpmModel model);

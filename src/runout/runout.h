#pragma once
/*
  Results of flow over terrain: largest values of all steps as maps, gauges, and the end of a run at rest.

  Order of calls: MpmRunoutRead(); MpmRunoutObserve() after each step, and MpmRunoutFinish() after a stage's end;
  MpmRunoutWrite() at the end; MpmRunoutDestroy(). A scene that asks for none of these has model->runout NULL, and the
  calls return at once.

  A step's numbers at the nodes are those of the state with which it begins; velocities are those of its middle.
*/
#include "base/base.h"
#include "base/columns.h"
#include "base/types.h"
#include "query/model.h"

/* Options -mpm_maps_* and -mpm_gauges, once bed, bodies and stages have been read. */
PetscErrorCode MpmRunoutRead(MpmModel model, const MpmOptions *options);
PetscErrorCode MpmRunoutDestroy(MpmModel model);
/* The state with which the last step, of length dt, began. Collective. */
PetscErrorCode MpmRunoutObserve(MpmModel model, PetscReal dt);
/* The state at a stage's end, once velocities have caught up with it. Collective. */
PetscErrorCode MpmRunoutFinish(MpmModel model);
/* Maps of the largest values and tables of paths, as they stand. Collective; fails with PETSC_ERR_FILE_WRITE. */
PetscErrorCode MpmRunoutWrite(MpmModel model);

/* Columns of the history: gauges. */
PetscErrorCode MpmRunoutAddColumns(MpmModel model, MpmColumns *columns);
/* Entries of the summary, as JSON, or NULL; to be freed. */
PetscErrorCode MpmRunoutSummary(const MpmModel model, char **text);
/* Bytes of a checkpoint, on rank 0: the largest values so far; and back. Collective. */
PetscErrorCode MpmRunoutSave(MpmModel model, MpmTextFile *bytes);
PetscErrorCode MpmRunoutLoad(MpmModel model, const MpmTextFile *bytes);
/* True where a checkpoint has such bytes. */
PetscBool MpmRunoutHasPeaks(const MpmModel model);

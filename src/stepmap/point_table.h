#pragma once
/*
  Derivatives of a step's points by all that their kernels take: inputs, F and history at the step's start, parameters
  of the law and fields of these; found once for a step, in packs of directions, for both halves of a pull.

  A point's record has the kernel's fluxes q and, of a physics with a mean, m and dm/dinput, F' of the
  step's end, then a table for each pack:
  rows of derivatives of the bars' part  Fbar : F' + zbar . z' + ... , of q, of m and of dm/dinput, a column for each
  direction. A new number that kernels take is a new range of columns.
*/
#include "stepmap/rates_map.h"
#include "stepmap/start_deformation.h"

/* Directions of a law's points: inputs, F (all components, F itself, or none), history, numbers of a rate, parameters
   and fields, from these columns on. */
typedef struct {
  MpmStartKind        start;
  PetscInt            F, state, rate[MPM_RATE_NUMBERS], physics, parameter, ground, count, packs;
  PetscInt           *number; /* of the physics' parameters among all */
  PetscInt           *place;  /* of the parameters in the law's table */
  PetscInt           *field;  /* of the fields among all */
  MpmKernelDirection *pack;
  PetscInt            size; /* of the seeds of a pack */
  PetscReal          *seeds;
} MpmPointDirections;

struct MpmPointTable {
  PetscInt            inputs, means;        /* of the kernel; rows of dm */
  PetscInt            end;                  /* numbers before F' */
  PetscInt            values, rows, record; /* numbers before the packs, rows of a pack, numbers of a point */
  PetscInt            material_count;
  PetscInt            widest; /* packs of a point */
  MpmPointDirections *columns;
  PetscReal          *F, *stress, *state, *own, *totals; /* room for one point */
  PetscInt            room;                              /* numbers that `at` has room for */
  PetscReal          *at;
};

/* The means over a point's cells as dL takes them: its volume, dL/dm_bar and the flux f, means of those of the cells,
   and the mean of dm . K. */
typedef struct {
  PetscReal share, by_mean, flux, along;
} MpmMeanPull;

/* Fills a point's record but for the mean, at work->input. */
PetscErrorCode MpmPointTableFill(const MpmStepMap *map, PetscInt p, const MpmKernelPoint *point,
                                 const MpmPointVector *end, MpmPointWork *work);
/* Fills m and dm of a point's record, with their derivatives. */
PetscErrorCode MpmPointTableFillMean(const MpmStepMap *map, PetscInt p, const MpmKernelPoint *point,
                                     MpmPointWork *work);
/*
  The derivatives of a point's part of L in the first `packs` packs of directions, with K in work->other_input; by the
  mean of its cells, too, unless `mean` is NULL.
*/
void MpmPointTableTotals(const MpmStepMap *map, PetscInt p, PetscInt packs, const MpmMeanPull *mean, MpmPointWork *work,
                         PetscReal totals[]);
/* Adds those by F, history, numbers of a rate, parameters and fields; `end` has the bars. */
void MpmPointTableAdd(const MpmStepMap *map, PetscInt p, const MpmPointVector *end, const MpmPointWork *work,
                      const PetscReal totals[], MpmPointVector *start, PetscReal gradient[]);

/* The kernel's fluxes; m and, behind it, dm. */
static inline const PetscReal *MpmPointTableFlux(const MpmPointTable *table, PetscInt p)
{
  return &table->at[p * table->record];
}
static inline const PetscReal *MpmPointTableMean(const MpmPointTable *table, PetscInt p)
{
  return &table->at[p * table->record + table->inputs];
}
/* Packs of a point. */
static inline PetscInt MpmPointTablePacks(const MpmStepMap *map, PetscInt p)
{
  return map->table->columns[map->sum->points->material[p]].packs;
}
/* Packs that hold the inputs' columns. */
static inline PetscInt MpmPointTableInputPacks(const MpmPointTable *table)
{
  return (table->inputs + MPM_PACK - 1) / MPM_PACK;
}

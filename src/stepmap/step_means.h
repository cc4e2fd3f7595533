#pragma once
/*
  Means over cells in a step's derivatives: over whole cells, whose points come in batches of their own, or by shares of
  the points' domains (points/spread_mean.c), where all points are one batch.

    V_c = sum_p f_pc V_p ,   q_c = sum_p f_pc V_p q_p/V_c ,   q_bar_p = sum_c f_pc q_c

  The second sums are those of fluxes over V_c, sum_p f_pc Q_p/V_c. A number has a row: its value and `width` - 1
  changes. Create, then for each batch Begin, Enter and Add for each of its points, Close, the same with the second
  sums; Destroy.
*/
#include "points/spread_mean.h"
#include "stepmap/point_work.h"

typedef struct {
  PetscInt   count, *node; /* the point's cells */
  PetscReal *share;        /* rows */
} MpmMeanCells;

typedef struct {
  const MpmStepMap *map;
  PetscBool         spread;
  PetscInt          width, size[2], cells; /* rows a cell of the first sums, the volume's first, and of the second */
  PetscReal        *sums[2];
  MpmMeanCells      at; /* of the point that has entered */
  MpmSpreadCells   *found;
  PetscReal        *by_share; /* room for a number of each of its cells */
} MpmMeans;

/* Groups that are visited together; `most` points at the most. */
typedef struct {
  PetscInt group_begin, group_end, point_begin;
} MpmBatch;
PetscInt MpmBatchCount(const MpmStepMap *map);
MpmBatch MpmBatchAt(const MpmStepMap *map, PetscInt b);
PetscInt MpmBatchMost(const MpmStepMap *map);

/* For `first` quantities by volume and `second` fluxes. */
PetscErrorCode MpmMeansCreate(const MpmStepMap *map, PetscInt width, PetscInt first, PetscInt second, MpmMeans *means);
PetscErrorCode MpmMeansDestroy(MpmMeans *means);
PetscErrorCode MpmMeansBegin(MpmMeans *means);
/*
  The point's cells and shares. The changes of these go with those of its place, m, and half-lengths, cells: rows of
  MPM_PACK numbers for each axis; NULL: none.
*/
void MpmMeansEnter(MpmMeans *means, const MpmGroup *group, PetscInt p, const PetscReal argument[]);
/* Adds the volume's row and the quantities'; or those of fluxes. */
void MpmMeansAddFirst(MpmMeans *means, const PetscReal volume[], const PetscReal rows[]);
void MpmMeansAddSecond(MpmMeans *means, const PetscReal rows[]);
/* Sums to means, of the first (0) or second (1) kind. Collective where means are spread. */
PetscErrorCode MpmMeansClose(MpmMeans *means, int kind);
/* The row q_bar of quantity k of the point that has entered. */
void MpmMeansAt(const MpmMeans *means, int kind, PetscInt k, PetscReal row[]);
/* Of one of its cells, without changes. */
static inline PetscReal MpmMeansOf(const MpmMeans *means, PetscInt c, int kind, PetscInt k)
{
  return means->sums[kind][means->at.node[c] * means->size[kind] + (kind ? k : k + 1) * means->width];
}
/* Derivatives by place, 1/m, and half-lengths, 1/cell, from those by the shares, added. */
void MpmMeansPullShares(const MpmMeans *means, PetscInt p, const PetscReal by_share[], PetscReal x[], PetscReal half[]);

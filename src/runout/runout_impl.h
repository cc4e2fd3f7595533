#pragma once
/*
  Shared by the files of this folder.
*/
#include "grid/grid.h"
#include "runout/runout.h"

/* Flow at a node: vertical depth, m; horizontal velocity, m/s; speed, m/s, and density times its square, Pa. */
typedef struct {
  PetscReal depth, velocity[2], speed, pressure;
} MpmNodeFlow;

enum { MPM_PEAK_DEPTH, MPM_PEAK_SPEED, MPM_PEAK_PRESSURE, MPM_PEAK_COUNT };
#define MPM_MOST_THRESHOLDS 16

/* Largest values of all states at the nodes of the grid, those that this rank has owned; quantity by quantity. */
typedef struct {
  PetscInt   count;   /* nodes of the grid */
  PetscInt   depths;  /* thresholds */
  PetscReal *depth;   /* m, ascending; NULL: one, a share of the largest depth at the start */
  PetscReal  least;   /* m, the first of them; 0: not known yet */
  PetscReal *largest; /* NULL: nobody asks for them */
  PetscReal *arrival; /* s, by threshold; PETSC_MAX_REAL: not reached */
} MpmPeaks;

/* Place of a sample among values of nodes that gauges need. */
typedef struct {
  PetscReal x[2], normal[2], s; /* m; normal: length of its piece times the direction; distance along the gauge */
  PetscInt  slot[4];
  PetscReal weight[4];
} MpmSample;

typedef enum { MPM_GAUGE_PLACE, MPM_GAUGE_LINE, MPM_GAUGE_OUTLINE, MPM_GAUGE_PATH, MPM_GAUGE_KINDS } MpmGaugeKind;
#define MPM_GAUGE_NUMBERS 3
/*
  place    now: depth, speed, pressure
  line     now: discharge, m3/s; kept: volume passed up to the state, m3, then length, s, and discharge of its step
  outline  kept: largest depth, speed, pressure
  path     kept: distance where the flow began and the furthest that it has reached, m; -1: nowhere yet
*/
typedef struct {
  char        *name;
  MpmGaugeKind kind;
  PetscInt     count;
  MpmSample   *sample;
  PetscReal    now[MPM_GAUGE_NUMBERS], kept[MPM_GAUGE_NUMBERS];
} MpmGauge;

typedef struct {
  PetscInt   count;
  MpmGauge  *at;
  PetscInt  *slot; /* by node of the grid: place among the values, or -1 */
  PetscInt   slots;
  PetscReal *value; /* of each: depth, depth times velocity, speed, pressure */
} MpmGauges;
#define MPM_GAUGE_VALUES 5

struct MpmRunout {
  PetscBool maps, along; /* maps are asked for; speeds count along the bed */
  PetscInt  every;       /* steps between maps of states; 0: none */
  PetscInt  seen;        /* step of the last state that was observed; -1: none */
  PetscReal energy;      /* J, the largest kinetic energy at the nodes */
  PetscReal rest;        /* s, when the run came to rest; -1: it has not */
  MpmPeaks  peaks;
  MpmGauges gauges;
};

/* ---- node_flow.c ---- */

/* Node i of this rank in the last step. */
void MpmRunoutNode(const MpmModel model, PetscInt i, MpmNodeFlow *flow);
/* Its place on the grid's lattice. */
PetscInt MpmRunoutLatticeNode(const MpmModel model, PetscInt i);

/* ---- peaks.c ---- */

PetscErrorCode MpmPeaksSetUp(const MpmGrid *grid, MpmPeaks *peaks);
PetscErrorCode MpmPeaksDestroy(MpmPeaks *peaks);
PetscErrorCode MpmPeaksObserve(MpmModel model, PetscReal time);
/* Those of all ranks, on rank 0; NULL elsewhere. To be freed. */
PetscErrorCode MpmPeaksGather(MpmModel model, PetscReal **largest, PetscReal **arrival);

/* ---- peak_maps.c ---- */

/* The first node of the cell at a place, and weights of its nodes, x fastest; false outside of the grid. */
PetscBool MpmLatticeCorners(const MpmGrid *grid, const PetscReal x[], PetscInt *first, PetscReal weight[4]);
/* Bilinear between the nodes of the grid; not-a-number outside. */
PetscReal MpmLatticeAt(const MpmGrid *grid, const PetscReal field[], const PetscReal x[]);
/* The state of the last observation as a map named by its step; all peaks. Collective. */
PetscErrorCode MpmRunoutWriteState(MpmModel model);
PetscErrorCode MpmRunoutWritePeaks(MpmModel model);

/* ---- gauge_samples.c ---- */

/* Adds the samples of a gauge along these vertices, m, without those outside of the grid. */
PetscErrorCode MpmGaugeAddSamples(const MpmGrid *grid, PetscInt count, const PetscReal vertex[], MpmGauge *gauge);

/* ---- gauges.c, gauges_read.c ---- */

PetscErrorCode MpmGaugesRead(MpmModel model, const MpmOptions *options);
PetscErrorCode MpmGaugesDestroy(MpmGauges *gauges);
PetscErrorCode MpmGaugesObserve(MpmModel model, PetscReal dt);
/* Tables of paths. Collective. */
PetscErrorCode MpmGaugesWrite(MpmModel model);

#pragma once
/*
  Fields: numbers of a material that differ from place to place, one a body, region, cell or point, or at pilot points
  between which they are interpolated.
*/
#include "base/base.h"
#include "base/types.h"
#include "talus/talus.h"

typedef enum { MPM_GROUND_BODY, MPM_GROUND_REGION, MPM_GROUND_CELL, MPM_GROUND_POINT, MPM_GROUND_PILOTS } MpmGroundKind;

/* The background grid as it was read: the cells of fields by cell. */
typedef struct {
  PetscInt  dim;
  PetscReal lower[MPM_MAX_DIM], h[MPM_MAX_DIM];
  PetscInt  cells[MPM_MAX_DIM]; /* 1 on unused axes */
} MpmGroundGrid;

/* Ordinary kriging between places (kriging.c). */
typedef struct _p_MpmKriging *MpmKriging;
PetscErrorCode MpmKrigingCreate(PetscInt dim, PetscInt count, const PetscReal at[], const PetscReal length[],
                                MpmKriging *kriging);
PetscErrorCode MpmKrigingDestroy(MpmKriging *kriging);
/* Coefficients of values z: one a place, and the mean. Evaluate: the value at x. */
PetscErrorCode MpmKrigingFit(const MpmKriging kriging, const PetscReal z[], PetscReal coefficient[]);
PetscReal      MpmKrigingEvaluate(const MpmKriging kriging, const PetscReal coefficient[], const PetscReal x[]);
/* Derivatives by the values of the sum over places x of by times the value at x: Add each, then Pull once. */
void           MpmKrigingAdd(const MpmKriging kriging, const PetscReal x[], PetscReal by, PetscReal sums[]);
PetscErrorCode MpmKrigingPull(const MpmKriging kriging, const PetscReal sums[], PetscReal z[]);

/* Points of bodies by their ids. */
typedef struct {
  PetscInt  count, room;             /* of bodies; ids from point to point */
  PetscInt *first, *end, *of, *most; /* by body: ids, its first value (-1: none), and how many */
} MpmGroundBodies;

/* Interpolation between pilot points. */
typedef struct {
  PetscReal  length[MPM_MAX_DIM]; /* of correlation, m */
  PetscBool  log, log_given;      /* logarithms are interpolated; the scene says so */
  MpmKriging kriging;
  PetscReal *coefficient;
} MpmGroundPilots;

/* One field. */
struct MpmGround {
  char           *name;
  char           *material, *parameter; /* the number of a material that it replaces */
  MpmGroundKind   kind;
  PetscBool       used; /* a material has taken it */
  PetscInt        dim, count;
  PetscReal      *value;
  char          **names; /* of the bodies or regions; or NULL */
  PetscReal      *at;    /* of cells and pilots: their middles, m, dim each; or NULL */
  MpmGroundPilots pilots;
  MpmGroundGrid   grid;
  PetscInt       *cell; /* number of the value of each cell, -1: none; by cell only */
  MpmRegion      *region;
  MpmGroundBodies bodies;
};

/* All fields of a scene, with the names of their blocks. */
struct MpmGrounds {
  PetscInt   count;
  char     **names;
  MpmGround *at;
};

/* Reads -mpm_fields and their blocks; NULL where there are none. Collective. */
PetscErrorCode MpmGroundsRead(const MpmOptions *options, const MpmGroundGrid *grid, MpmGrounds **fields);
PetscErrorCode MpmGroundsDestroy(MpmGrounds **fields);
/* The field of a material's number, or NULL. */
MpmGround *MpmGroundsFind(const MpmGrounds *fields, const char material[], const char parameter[]);
/* Refuses fields of materials that are not there, and, once the materials are read, that none of their numbers took. */
PetscErrorCode MpmGroundsCheckMaterials(const MpmGrounds *fields, PetscInt count, char *const names[]);
PetscErrorCode MpmGroundsCheckUsed(const MpmGrounds *fields);
/* The field becomes that of a number: its values must be in the number's range. Collective. */
PetscErrorCode MpmGroundTake(const MpmParameter *parameter, MpmGround *field);
/*
  Bodies of the field's material, whose points have the ids [first, end), `points` of them in steps of `room`; `own`:
  a body is of the field's material. Every such body must have a value. Collective.
*/
typedef struct {
  PetscInt           count, room;
  const char *const *names;
  const PetscBool   *own;
  const PetscInt    *first, *end, *points;
} MpmGroundOwners;
PetscErrorCode MpmGroundSetBodies(const MpmGroundOwners *owners, MpmGround *field);

/* Number of the value at a point that began at x, -1 where there is none; 0 of pilots, which reach everywhere. */
PetscInt MpmGroundIndex(const MpmGround *field, const PetscReal x[], PetscInt id);
/* The value there; that of number 0 where there is none. */
PetscReal MpmGroundEvaluate(const MpmGround *field, const PetscReal x[], PetscInt id);
/* Least and largest of the values. */
void MpmGroundBounds(const MpmGround *field, PetscReal *least, PetscReal *most);

/*
  Derivatives. Direct: room for the change of the field by a change of its values, count + 1 numbers, from which Along
  finds the change at a point. Add: `by` times the change at a point into sums, count + 1 numbers; Pull: their
  derivatives by the values, added.
*/
PetscErrorCode MpmGroundDirect(const MpmGround *field, const PetscReal change[], PetscReal direction[]);
PetscReal      MpmGroundAlong(const MpmGround *field, const PetscReal direction[], const PetscReal x[], PetscInt id);
void           MpmGroundAdd(const MpmGround *field, const PetscReal x[], PetscInt id, PetscReal by, PetscReal sums[]);
PetscErrorCode MpmGroundPull(const MpmGround *field, const PetscReal sums[], PetscReal gradient[]);

/* ---- ground_table.c ---- */

/* Rows of a file of values. Start from zeros. */
typedef struct {
  PetscInt   rows;
  PetscReal *value;
  PetscReal *at;    /* places, dim each; or NULL */
  PetscReal *cell;  /* numbers of cells by axis, dim each; or NULL */
  PetscReal *id;    /* or NULL */
  char     **names; /* of a table whose first column is text; or NULL */
} MpmGroundTable;
#define MPM_GROUND_MESSAGE 512
/* Reads a CSV or HDF5 file, whose values are in the column or dataset `parameter`, or `value`; a fault goes into
   `message`. `named`: rows begin with a name. */
PetscErrorCode MpmGroundTableRead(const char path[], const char parameter[], PetscInt dim, PetscBool named,
                                  MpmGroundTable *table, char message[MPM_GROUND_MESSAGE]);
PetscErrorCode MpmGroundTableDestroy(MpmGroundTable *table);

#pragma once
/*
  The task `ensemble`: runs of a scene with numbers drawn from distributions, and their statistics.

  Order of calls: MpmEnsembleRead() once the scene has been read; a member's options, its run (members/members.c), and
  the file that says so; tables and maps of all members; MpmEnsembleDestroy().
*/
#include "query/model.h"
#include "sensitivity/parameters.h"
#include "ensemble/distribution.h"

/* A number that is drawn, or several that are equal. */
typedef struct {
  char              *name;   /* borrowed from the list */
  char              *option; /* -mpm_draw_NAME_of */
  MpmSceneParameters of;
  MpmDistribution    distribution;
} MpmDraw;

/* A quantity of the maps and a value: maps have the share of members above it. */
typedef struct {
  PetscInt  quantity;
  PetscReal value;
} MpmThreshold;

/* Contents of statistics. */
typedef struct {
  PetscInt      quantile_count, threshold_count, result_count;
  PetscReal    *quantiles; /* shares, in (0, 1) */
  MpmThreshold *thresholds;
  char        **results; /* names of columns and of numbers of the summary; none: all columns, factor of safety */
} MpmEnsembleAsk;

typedef enum { MPM_MEMBER_DONE = 0, MPM_MEMBER_REFUSED = 2, MPM_MEMBER_FAILED = 3 } MpmMemberStatus;
#define MPM_MEMBER_TEXT 512

/* A member, and results of one that has been completed, by their names. */
typedef struct {
  PetscBool       run;
  MpmMemberStatus status;
  PetscReal       seconds;
  char            why[MPM_MEMBER_TEXT]; /* of one that was refused or failed */
  PetscInt        count;
  char          **names;
  PetscReal      *values;
} MpmMember;

struct MpmEnsemble {
  PetscInt       members, groups, seed, draw_count;
  PetscBool      restart;
  PetscBool      terrain; /* each member has noise of its own */
  PetscBool      sparse;  /* members write no states of points, for which the scene does not ask */
  PetscBool      maps;    /* members write maps of their largest values, which the scene does not ask for */
  char         **names;   /* of the draws */
  MpmDraw       *draws;
  PetscReal     *correlation; /* draws x draws; NULL: none is given */
  PetscReal     *shares;      /* [draw*members + member] */
  MpmEnsembleAsk ask;
  PetscInt64     scene; /* a number of the scene's options: members of other scenes are not taken */
};

/* Reads the blocks -mpm_ensemble_ and -mpm_draw_NAME_ where the task is an ensemble; otherwise nothing. */
PetscErrorCode MpmEnsembleRead(MpmModel model);
PetscErrorCode MpmEnsembleDestroy(MpmModel model);

/* ---- draws.c ---- */

/* The value of a draw in a member, and the seed of its terrain. */
PetscReal MpmDrawValue(const MpmEnsemble *ensemble, PetscInt draw, PetscInt member);
PetscInt  MpmTerrainSeed(const MpmEnsemble *ensemble, PetscInt member);
/* Draws of all members, and the scene's number, with the scene's options in force. */
PetscErrorCode MpmDrawsMake(MpmEnsemble *ensemble);
/* The options of a member, in the database in force, in place of the ensemble's. */
PetscErrorCode MpmDrawsSetOptions(const MpmEnsemble *ensemble, PetscInt member, const char prefix[]);

/* ---- member_file.c ---- */

/* Prefix of a member's files. */
void MpmMemberPrefix(const MpmModel model, PetscInt member, char prefix[PETSC_MAX_PATH_LEN]);
/* Last row of the history and numbers of the summary of a run that was completed. Not collective. A fault goes into
   `message`, which stays as it is where there is none. */
PetscErrorCode MpmMemberCollect(const MpmEnsemble *ensemble, const char prefix[], MpmMember *member,
                                char message[MPM_MEMBER_TEXT]);
/* The file that says that a member has been run; collective on its group. */
PetscErrorCode MpmMemberWrite(MPI_Comm group, const MpmModel model, PetscInt number, const MpmMember *member);
/* Reads it; `there` is false where there is none, or it is of another scene. Not collective. */
PetscErrorCode MpmMemberRead(const MpmModel model, PetscInt number, MpmMember *member, PetscBool *there);
PetscErrorCode MpmMemberRemove(const MpmModel model, PetscInt number);
PetscErrorCode MpmMemberDestroy(MpmMember *member);

/* ---- statistics.c ---- */

/* Quantile of sorted values, linear between them. */
PetscReal MpmQuantileOf(PetscInt count, const PetscReal sorted[], PetscReal share);
/* Wall time, s. */
typedef struct {
  PetscReal all, members, own; /* of the ensemble; of its members, summed; beside those of the slowest group */
} MpmEnsembleTimes;
/* PREFIX_members.csv, PREFIX_statistics.csv, PREFIX_summary.json from the members' files. Collective. */
PetscErrorCode MpmEnsembleWriteTables(MpmModel model, const MpmMember members[]);
PetscErrorCode MpmEnsembleWriteSummary(MpmModel model, const MpmMember members[], const MpmEnsembleTimes *times,
                                       PetscBool interrupted);

/* ---- probability.c ---- */

extern const char *const MpmMapQuantities[];
/* Maps of probabilities and quantiles from those of the members, where they have any. Collective. */
PetscErrorCode MpmEnsembleWriteMaps(MpmModel model, const MpmMember members[]);

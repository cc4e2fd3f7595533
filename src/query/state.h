#pragma once
/*
  The state of a run: its progress, with all that a checkpoint holds. Parts of the program register the rows of their
  numbers with it (base/rows.h), in their own files.
*/
#include "base/base.h"
#include "base/rows.h"
#include "base/types.h"

/* Where strength is reduced. */
typedef struct {
  PetscReal height;  /* of the slope as the stage began, m */
  PetscReal limit;   /* way of a point at which the slope has failed, m */
  PetscReal factor;  /* of safety; 0: not known yet */
  PetscReal moved;   /* the longest way of a point from the stage's beginning to the last step's end, m */
  PetscReal reduced; /* the reduction there */
  PetscReal start;   /* the reduction before the stage; 0: as its ramp begins */
  PetscReal rate;    /* m, of the longest way by the reduction, in the last step */
  PetscReal failed;  /* s, the run's time of the end of a step that failed; 0: none, or it was passed */
  PetscReal beyond;  /* m, the longest way in a solution that passed the limit; 0: it did not */
} MpmSafety;

/* A body that is taken away by a ramp (removal.c). */
typedef struct {
  MpmRamp   ramp;  /* of the stage that removes it; NULL: it does not fade */
  PetscReal start; /* s, the run's time from which on the ramp counts */
  PetscReal left;  /* part of the body */
  PetscBool gone;  /* its points are parked until the step is accepted */
} MpmFading;

/* The point that a solution moves furthest. */
typedef struct {
  PetscReal way, place[MPM_MAX_DIM]; /* m */
  PetscInt  body;                    /* of the scene; -1: none */
} MpmFastest;

/* Whether steps without inertia follow a path of equilibrium (slide.c). */
typedef struct {
  PetscReal  ways, forces;    /* sums over the stage's steps: longest displacements, m, and driving forces, N */
  PetscReal  force, dt;       /* N, s: those of the solution at hand */
  PetscReal  driven;          /* m, the longest prescribed displacement in it */
  PetscReal  ratio;           /* of the last step: its way by force over that of the stage before */
  PetscReal  steady[3];       /* sums over steps in proportion: longest displacements, m, forces, N, and lengths, s */
  PetscReal  slid;            /* m, sum over the last steps in a row that were far out of proportion */
  PetscReal  end, span, way;  /* s, s, m: of the first suspected step, the run's time of its end; end < 0: none */
  MpmFastest now, seen, last; /* in the solution at hand, in the last one that was suspected, in the last step */
} MpmSlide;

/* How far a relaxation has come; the columns K_F, K_E and resets. */
typedef struct {
  PetscReal  force, energy; /* out of balance over the loads; kinetic over their work */
  PetscReal  kinetic, work; /* J; of the points after the last step, and of the loads since the stage began */
  PetscReal  first;         /* s, the run's time when both criteria were met first; -1: never */
  PetscReal  since;         /* s, the run's time since when they are met without a break; -1: they are not */
  PetscReal  reset;         /* s, the run's time when velocities last became zero */
  PetscReal  quarter;       /* s, of the first motion from rest to the peak of its energy; 0: not known yet */
  PetscInt   resets;        /* of all velocities to zero */
  PetscBool  rests;         /* the criteria have been met for long enough */
  PetscReal *ended;         /* by stage: when it ended, where that was before its time was over; otherwise negative */
} MpmRelaxing;

/* A relaxation in place of a quasi-static step that gave up (rescue.c). */
typedef struct {
  PetscBool on;
  PetscReal start, end;  /* s, of the run's time: of that step */
  PetscReal clock, ramp; /* s, of the motion: its duration, and the time in which loads and supports reach their ends */
  PetscReal work;        /* J, that everything had done from outside as it began */
  PetscReal first, since; /* of the last stage that was a relaxation */
  PetscInt  steps;        /* number so far */
  PetscInt  count;        /* of rescues that have come to rest */
} MpmRescuing;

/* Steps that begin at rest and end there (settle.c). */
typedef struct {
  PetscBool on, needed;    /* in the step under way; in one of the stage so far */
  PetscReal tau;           /* s, of the next such step; 0: as a wave crosses the material */
  PetscInt  steps, newton; /* number so far; iterations of the last one */
} MpmSettling;

/* Displacement of the grid with the followed object. */
typedef struct {
  PetscBool known;              /* the followed object has been there */
  PetscReal start[MPM_MAX_DIM]; /* here then */
  PetscReal moved[MPM_MAX_DIM]; /* m, since then, at the step's start */
} MpmGridMotion;

/* Remaining remedies where steps fail again and again. */
typedef struct {
  PetscBool dilation; /* F-bar leaves dilation to the points: it may average that, too */
  PetscInt  averaged; /* steps that did so alone */
} MpmRescue;

typedef struct {
  PetscInt count;
  MpmWall *at;
} MpmWalls;

/* The account of energy, J, in scenes with a dynamic stage (energy.c); sums over all ranks since the start. */
typedef struct {
  PetscBool known;      /* the relaxation has begun */
  PetscBool opened;     /* the energy at the run's start has that of affine velocities */
  PetscReal internal;   /* work of the points' stresses */
  PetscReal external;   /* work of loads, of prescribed motions and of boundaries that move */
  PetscReal dissipated; /* by contact and by damping */
  PetscReal start;      /* kinetic and elastic energy at the start, and additions by stages */
  PetscReal elastic;    /* the elastic part of that */
  PetscReal mark[2];    /* kinetic and elastic energy before a change without a step */
} MpmEnergy;

/* Water in the stage under way (consolidation.c, water_limits.c). */
typedef struct {
  PetscReal most;   /* largest mean size of the excess pressure so far, Pa; -1: unknown */
  PetscReal degree; /* of consolidation at the last step's end */
  PetscInt  boiled; /* stages up to the last with a line on pressures below -100 kPa */
  PetscInt  lost;   /* stages up to the last with a line on water that goes into dry ground */
} MpmWaterRun;

/* Error in time of a step, relative (time_error.c). */
typedef struct {
  PetscReal accepted;            /* largest that is accepted; 0: any */
  PetscReal estimate;            /* of the last step that has converged */
  PetscReal refused, refused_dt; /* error of a step's last trial, where it was too large, and its length; or 0 */
  PetscReal order;               /* the power of a step's length that the estimate goes with */
  PetscReal trial;               /* `largest` if the step is accepted */
  PetscReal largest;             /* reference of errors: the largest change since the stage's start */
} MpmStepError;

/* How a step is taken (sdirk.c), and its error in time. */
typedef struct {
  const MpmIntegrator *integrator;
  MpmDynamics         *dynamics; /* velocities at the nodes; NULL before the first dynamic step */
  MpmSdirk            *sdirk;    /* the first sub-step of `second`; NULL before its first step */
  MpmStepError         error;
  PetscBool            met;        /* contact has been near since the stage began, see dynamics.c */
  PetscReal         load_at_start; /* fraction of a step's loads that is its start's, by the generalised-alpha method */
  PetscReal         behind;        /* s, how far the points' velocities are behind their places: explicit steps */
  PetscBool         water_held;    /* the pressure of the water is not solved for: geostatic stages */
  MpmEnergy         energy;
  MpmSlide          slide;
  MpmFading        *fading;   /* per body: whether it is being taken away */
  MpmParked        *parked;   /* per body: points that a later stage adds */
  struct MpmInflow *inflow;   /* columns that come in later (inflow.c); NULL: there are none */
  PetscBool         put_back; /* the points were restored after the last step, which kept their stress (geostatic.c) */
  MpmRescuing       rescuing;
  MpmSettling       settling;
  MpmWaterRun       water;
  PetscReal         load_scale; /* fraction of its loads that a geostatic stage applies; otherwise 1 */
} MpmScheme;

/* Lengths of steps, s. */
typedef struct {
  PetscReal nominal, least, most;
  PetscReal growth; /* of the next step over one that was easy */
  PetscReal wanted; /* of the next step */
  PetscReal last;   /* of the last step, 0 before the first */
  PetscReal before; /* of the step before that; below 0: the next step brings a motion to rest, without a predictor */
  PetscBool adaptive;
} MpmStepLengths;

/* Variables of a run: points, time, and control of steps. */
typedef struct {
  MpmRows       *rows; /* of the numbers that a checkpoint holds besides the points */
  MpmScheme      scheme;
  MpmParticles  *particles;
  PetscReal      time;
  MpmStepLengths dt;
  struct {
    PetscReal start, end; /* of the stage under way, s */
    PetscReal run_end;
  } period;
  PetscBool predict; /* start from the last step's increment */
  PetscInt  step;
  struct {
    PetscInt step, total; /* of the step under way, and of all */
  } cuts;
  PetscInt stage; /* the one under way */
  struct {
    MpmActing     *bcs;   /* by the scene's lists: active in the stage under way; motions behind conditions */
    MpmLoadActing *loads; /* surfaces behind loads */
    MpmWalls       walls; /* walls of the grid */
  } acting;
  PetscBool     reference_output; /* position0 goes into the next state that is written */
  MpmRescue     rescue;
  PetscInt64    active_dofs_max;
  MpmSafety     safety;
  MpmRelaxing   relaxing;
  MpmGridMotion grid;
  MpmPlacement *placements; /* by the scene's boundaries: how far those have come that move by themselves */
} MpmState;

/* The state at a time, in memory: the points of this rank and the rows of use MPM_ROW_STATE. */
typedef struct {
  MpmParked   *points;
  MpmRowValues values;
} MpmStateKept;

/* An empty state with its own rows. The arrays by the scene's lists are allocated where those are read. */
PetscErrorCode MpmStateCreate(MpmState *state);
PetscErrorCode MpmStateDestroy(MpmState *state);
/* The numbers for a checkpoint, and those of one whose names begin so into the state. */
PetscErrorCode MpmStateSave(const MpmState *state, MpmRowValues *values);
PetscErrorCode MpmStateLoad(MpmState *state, const MpmRowValues *values, const char begin[]);
/* Copy, and return to a copy, which PutBack leaves as it is, while no arrays of the points are lent; Forget frees an
   unneeded copy. */
PetscErrorCode MpmStateCopy(const MpmState *state, MpmStateKept *kept);
PetscErrorCode MpmStateReturn(MpmState *state, MpmStateKept *kept);
PetscErrorCode MpmStatePutBack(MpmState *state, const MpmStateKept *kept);
PetscErrorCode MpmStateForget(MpmStateKept *kept);

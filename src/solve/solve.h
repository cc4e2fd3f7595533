#pragma once
/*
  Newton's method and the linear solvers under it: presets, the forms of the Jacobian, and tests of a solution.
*/
#include "base/base.h"
#include "base/types.h"
#include "base/version.h"
#include "levels/pc_levels.h"
#include "talus/talus.h"

/* Action of a run at an equilibrium that is not stable. */
typedef enum { MPM_UNSTABLE_AUTO, MPM_UNSTABLE_STOP, MPM_UNSTABLE_FOLLOW } MpmUnstable;

/* References of each field's residual in a step of several fields (field_norms.c). */
typedef struct {
  PetscReal reference[MPM_MAX_BLOCK];
  PetscReal rounding[MPM_MAX_BLOCK]; /* diagonal times values: reference of rounding */
  PetscReal excess;                  /* of the last iterate: residual over tolerance, of the field that has most */
} MpmFieldNormsKept;

/* Where a step is a minimisation (minimise.c): its objective where the last line search ended. */
typedef struct {
  PetscBool  on;    /* the step is a minimisation */
  PetscBool  known; /* evaluated by the last line search */
  MpmVersion at;
  PetscReal  value; /* J */
} MpmMinimisation;

/* Reuse of a Jacobian in more than one iteration. */
typedef struct {
  PetscBool allowed;
  PetscBool last;             /* the last Jacobian was a reused one */
  PetscInt  needed;           /* Jacobians of this solution that could not be reused ones */
  PetscInt  needed_last_time; /* of the last solution */
} MpmReuse;

/* Stagnation of Newton's method. */
typedef struct {
  PetscBool stops;    /* another strategy follows */
  PetscReal least;    /* smallest residual norm (to 10 %) */
  PetscInt  least_at; /* iteration at which it was reached */
} MpmStagnation;

/*
  Results shared between Newton's evaluations: residual and Jacobian of one place may come from one pass, and a Jacobian
  may serve for more than one iteration.
*/
typedef struct {
  MpmVersion        summed;    /* where the Jacobian's sums, which wait in the matrix, were made */
  PetscBool         assembled; /* the matrix holds the Jacobian of the last solve */
  PetscReal         reference; /* residual of the step at zero displacement */
  PetscBool         predicted; /* Newton starts from the increment extrapolated from the last steps */
  MpmReuse          reuse;
  PetscBool         solving; /* SNES is running: other callers get a new Jacobian */
  PetscBool         ahead;   /* a Jacobian will follow the next residual at the same place: both in one pass */
  PetscReal         fnorm_last;
  PetscBool         rough; /* this tolerance will do: contact's pressures are yet to be corrected */
  MpmStagnation     stagnation;
  PetscInt          balances; /* extra iterations demanded by the force-balance test */
  MpmFieldNormsKept fields;
  MpmMinimisation   minimisation;
  PetscReal         imbalance; /* of free bodies, at the last iterate */
} MpmEvaluations;

/* The preconditioner of two fields by blocks (fieldsplit.c). */
typedef struct {
  PetscBool     on;
  IS            is[2];  /* unknowns of the displacement and of the other field */
  PetscBool     levels; /* the displacement's preconditioner waits for the step's nodes */
  Mat           schur, mass;
  PetscObjectId modes; /* the near null space that the displacement's comes from */
} MpmFieldsplit;

/* Iterations in which fields are solved for in turn (alternate.c). */
typedef struct {
  PetscBool in_turn;     /* the present Jacobian is that of fields in turn */
  PetscInt  left, again; /* iterations until the next attempt on all fields, and after that if it fails */
} MpmAlternation;

/* A full step that the line search would have cut short was taken. */
typedef struct {
  Vec       x, y;               /* where it started, and its direction; NULL: there is none */
  PetscReal norm, start, slope; /* the residual's norm there, and the slopes there and at its end */
  PetscBool more;               /* another step may follow it in any case */
} MpmExcursion;

#define MPM_AT_REST 4
/*
  Contact alone makes the Jacobian unsymmetric: steps in which nothing touches are solved as those of a scene without
  it. Options that differ then; NULL: none.
*/
typedef struct {
  PetscBool serves, now; /* there is such a contact; the present solver is that of a step at rest */
  PetscBool touched;     /* at one of the step's iterates */
  PetscInt  count;
  struct {
    const char *name, *at_rest, *touching;
  } option[MPM_AT_REST];
} MpmAtRest;

/* A set of solver options, and what follows from it. */
typedef struct {
  char     *name, *why; /* of the set; why `auto` took it, or NULL */
  PetscBool factorises; /* the preconditioner is a direct solver */
} MpmPreset;

/* Symmetry and definiteness of the Jacobian. */
typedef struct {
  PetscBool symmetric;
  PetscBool may_be_lost; /* CG was `auto`'s choice: GMRES takes over where the Jacobian loses definiteness */
  PetscBool lost;        /* definiteness was lost */
} MpmDefiniteness;

/* The Jacobian's matrices. */
typedef struct {
  MpmJacobianType form;
  char            mat_type[64], vec_type[64];
  Mat             assembled; /* NULL when the preconditioner does without it */
  Mat             shell;     /* its action alone, with MPM_JACOBIAN_MATFREE */
  PetscBool       unused;    /* the shell is preconditioner matrix too */
  PetscBool       keeps_tangents;
} MpmJacobian;

/* Multigrid on coarser lattices: levels, smoother and its steps, solver of the coarsest level (multigrid.c). */
typedef struct {
  MpmLevelsChoice levels;
  PetscInt        smoother, smooths, coarse;
  PetscInt        single; /* precision of the points' tangents without a matrix; 0: double */
} MpmMultigrid;

/* Iterations of the last step, and of all steps. */
typedef struct {
  PetscInt   newton, linear;
  PetscInt64 newton_total, linear_total;
} MpmIterations;

/* PETSc's solver objects for the problem of a step, and how they were chosen. */
typedef struct {
  MpmDiscretization *disc;
  MpmMonitor        *monitor;
  MpmDatabase       *database; /* the model's options: presets go there */
  MpmPreset          preset;
  MpmMultigrid       multigrid;
  MpmDefiniteness    definite;
  MpmAtRest          at_rest;
  MpmJacobian        jacobian;
  PetscBool          careful; /* with contact: a line search for kinks, and secants of sliding */
  SNES               snes;
  Vec                x, f;
  MpmFieldsplit      split;
  MpmEvaluations     cache;
  MpmExcursion       excursion;
  MpmAlternation     alternation;
  struct {
    MpmUnstable choice; /* action where the tangent loses definiteness */
    PetscBool   told;   /* a loss was reported */
  } unstable;
  MpmIterations iterations;
} MpmSolver;

/*
  The Jacobian of the present step as a shell matrix, with or without tangents kept (mat_points.c), valid within the
  step's space.
*/
PetscErrorCode MpmMatfreeCreate(MpmSolver *solver, PetscBool stored, Mat *J);
PetscErrorCode MpmMatfreeSetState(Mat J, Vec x);
/* Lends the local unknowns at which the derivative is taken, and the points' kept tangents, NULL without. */
PetscErrorCode MpmMatfreeGetState(Mat J, const PetscReal **u, const struct MpmFactored **factored);
/* Raises the diagonal of an assembled Jacobian where it may have modes without stiffness (jacobian_lift.c). */
PetscErrorCode MpmJacobianLift(MpmSolver *solver, Mat J);
/* Relative to the residual at zero displacement, with a floor; as SNES calls it, ctx: the solver (convergence.c). */
PetscErrorCode MpmNewtonConverged(SNES snes, PetscInt it, PetscReal xnorm, PetscReal snorm, PetscReal fnorm,
                                  SNESConvergedReason *reason, void *ctx);
/* Residual, Jacobian, convergence test and line search, handed to SNES (newton.c). */
PetscErrorCode MpmNewtonAttach(MpmSolver *solver);
PetscErrorCode MpmNewtonSetMats(MpmSolver *solver);
PetscErrorCode MpmExcursionEnd(MpmExcursion *excursion);
/* True where any contact is near enough to act in this step. Equal on all ranks. */
PetscBool MpmSolverHasContact(const MpmSolver *solver);
/* The potential at x, J, and a measure of its rounding, J; the trial becomes that of x. `failed`: of all ranks. */
PetscErrorCode MpmSumPotential(MpmSolver *solver, Vec x, PetscReal *value, PetscReal *size, PetscInt *failed);
/* Brings the solution vector to the local nodes, ghosts included. */
PetscErrorCode MpmGatherSolution(MpmSolver *solver, Vec x);
/* Bodies that the iterate x has left far from balance come to rest on its material; `last`: the one before, or NULL. */
PetscErrorCode MpmRelaxBodies(MpmSolver *solver, Vec last, Vec x);
/*
  Several fields (field_norms.c). Norms: of each field's components of a vector, in the solver's units. SetReference: f
  is the residual at the step's start. Learn: mutual action of the fields from Newton's first iteration, from x along
  -y. Converged: ratio of the residual to the tolerance of the field that is furthest, <= 1: converged; `floor` is the
  rounding error of the displacement's equations.
*/
PetscErrorCode MpmFieldNorms(const MpmSolver *solver, Vec v, PetscReal norm[]);
PetscErrorCode MpmFieldsSetReference(MpmSolver *solver, Vec f);
PetscErrorCode MpmFieldsLearn(MpmSolver *solver, Vec x, Vec y);
PetscErrorCode MpmFieldsConverged(MpmSolver *solver, Vec f, PetscReal rtol, PetscReal floor, PetscReal *excess);
/*
  PCFIELDSPLIT (fieldsplit.c). Serves: true for a displacement and one unknown beside it. ServesDamage: true where that
  is a damage. Tune: options of the displacement's multigrid; `contacts`: some may act. Attach: sets the unknowns of the
  blocks of a new preconditioner of that kind. Update: data that go with a new Jacobian.
*/
PetscBool      MpmFieldsplitServes(const MpmLayout *layout);
PetscBool      MpmFieldsplitServesDamage(const MpmLayout *layout);
PetscErrorCode MpmFieldsplitTune(MpmSolver *solver, PetscBool contacts);
PetscErrorCode MpmFieldsplitAttach(MpmSolver *solver);
PetscErrorCode MpmFieldsplitUpdate(MpmSolver *solver);
PetscErrorCode MpmFieldsplitReset(MpmFieldsplit *split);
/*
  Multigrid on coarser lattices (multigrid.c). Is: true for the name of a preset with it. Apply: PETSc's options that
  follow from those of the scene, for the preconditioner with this prefix; `contacts`: some may act. Attach: nodes of
  the step, for a new preconditioner of that kind and the first `components` of each node. Levels: of the last linear
  solve, 0 with another preconditioner.
*/
PetscBool      MpmMultigridIs(const char name[]);
PetscErrorCode MpmMultigridSetFromOptions(MpmSolver *solver, const MpmOptions *options);
PetscErrorCode MpmMultigridApply(MpmSolver *solver, const char prefix[], PetscBool contacts);
PetscErrorCode MpmMultigridAttach(MpmSolver *solver, PC pc, PetscInt components);
PetscErrorCode MpmMultigridLevels(const MpmSolver *solver, PetscInt *levels);
/* The residual that tolerances refer to: that at the step's start. */
PetscErrorCode MpmSolverSetReference(MpmSolver *solver, Vec f);
/*
  Presets (presets.c). Name: of preset k, NULL beyond the last one. Apply: settles `auto` for about so many unknowns,
  and sets the preset's options.
*/
#define MPM_PRESETS_MOST 16
const char    *MpmPresetName(PetscInt k);
PetscErrorCode MpmPresetApply(MpmSolver *solver, PetscReal unknowns, PetscBool inertia);
/* PETSc's solver objects and their options (solver.c). */
PetscErrorCode MpmSolverSetFromOptions(MpmSolver *solver, const MpmOptions *options);
/* Rows of the state (base/rows.h). */
PetscErrorCode MpmSolverAddRows(MpmSolver *solver, MpmRows *rows);
/* Settles `auto` for about so many unknowns, and applies the preset; `inertia`: some of the steps have it. */
PetscErrorCode MpmSolverChoose(MpmSolver *solver, PetscReal unknowns, PetscBool inertia);
PetscErrorCode MpmSolverSetUp(MpmSolver *solver);
/*
  Selects the solver: as a step `begins`, by that of the last one; otherwise by whether anything touches at the local
  unknowns disc->nodal.u, for whose Jacobian KSP and PC are then prepared. Collective.
*/
PetscErrorCode MpmSolverMindContact(MpmSolver *solver, PetscBool begins);
/* A solver for another problem, with the same settings and objects of its own. */
PetscErrorCode MpmSolverDuplicate(const MpmSolver *solver, MpmDiscretization *disc, MpmMonitor *monitor,
                                  MpmSolver *copy);
PetscErrorCode MpmSolverSetNearNullSpace(MpmSolver *solver);
/*
  Replaces x, which has prescribed values and else zeros, by the solution of the problem linearised at zero
  (linear_start.c); `made`: there is one. One field, nothing in contact.
*/
PetscErrorCode MpmSolverStartLinear(MpmSolver *solver, Vec x, PetscBool *made);
PetscErrorCode MpmSolverSolve(MpmSolver *solver, SNESConvergedReason *reason);
/*
  MpmSolverLinearise - derivative of the residual at given unknowns, and a linear solver with it

  Collective

  Input Parameters:
+ solver - of a problem that is prepared for a step; no Newton's method runs
- x      - unknowns, solver->x for the solution found last

  Output Parameters:
+ J   - the derivative by the unknowns, in the form of -mpm_jacobian; row `diagonal` times identity where prescribed
- ksp - the solver's own, with J and a preconditioner of it: KSPSolve() and, with matrices, KSPSolveTranspose()

  Notes:
  Both are borrowed until the next evaluation of a Jacobian. Contact is that of x. A direct solver's matrix has a raised
  diagonal where modes may lack stiffness (MpmJacobianLift()).
*/
PetscErrorCode MpmSolverLinearise(MpmSolver *solver, Vec x, Mat *J, KSP *ksp);
/* A new solver after a linear solve has failed, with GMRES where CG met an indefinite Jacobian. */
PetscErrorCode MpmSolverRenew(MpmSolver *solver);
PetscErrorCode MpmSolverDestroy(MpmSolver *solver);
/*
  Loss of definiteness (stability.c). Check: tests the stability of the equilibrium just found. If it is unstable, the
  outcome is a failure, with the place, unless the scene follows it. Explain: extends the reason of a failed step, where
  this is one.
*/
PetscErrorCode MpmStabilityRead(MpmSolver *solver, const MpmOptions *options);
PetscBool      MpmStabilityWanted(const MpmSolver *solver);
PetscErrorCode MpmStabilityCheck(MpmSolver *solver, MpmOutcome *outcome);
PetscErrorCode MpmStabilityExplain(MpmSolver *solver, MpmOutcome *outcome);

#pragma once
/*
  What adds to the residual and to its Jacobian: points, ghost penalty, cell means, rigid surfaces and loads; and the
  sparsity of the matrix.
*/
#include "bc/bc.h"

/* ---- rigid_surface.c, rigid_contact.c ---- */

typedef enum { MPM_BOUNDARY_PLANE, MPM_BOUNDARY_SPHERE, MPM_BOUNDARY_CYLINDER, MPM_BOUNDARY_POLYGON } MpmBoundaryType;

/* A surface that holds the material by a penalty. */
typedef struct {
  char           *name, *slip_field[MPM_MAX_DIM]; /* fields of the particles, with stick only */
  MpmBoundaryType type;
  PetscInt        dim;
  PetscReal  point[MPM_MAX_DIM], direction[MPM_MAX_DIM], radius; /* direction: a plane's normal, a cylinder's axis */
  PetscReal  side;                                               /* 1: the material is outside, -1: inside */
  PetscInt   vertex_count;
  PetscReal *vertices, penalty, motion[MPM_MAX_DIM];
  PetscBool  stick, bilateral;
  MpmRegion  region; /* of the points concerned, at the start */
  MpmRamp    ramp;
} MpmBoundary;

/* Boundaries, with the names of their blocks. */
typedef struct {
  PetscInt     count;
  char       **names;
  MpmBoundary *at;
} MpmBoundaries;

/* Distance from a boundary, positive where the material is, its gradient and its second derivative. */
typedef struct {
  PetscReal distance, normal[MPM_MAX_DIM], second[MPM_MAX_DIM][MPM_MAX_DIM];
} MpmSurface;

/* A point that may touch a boundary in this step. */
typedef struct {
  PetscInt  point, group, boundary, weight; /* weight: where the face's weights at the group's nodes stand */
  PetscReal face[MPM_MAX_DIM], normal[MPM_MAX_DIM], slip[MPM_MAX_DIM]; /* at the step's start */
  PetscReal stiffness;                                                 /* N/m */
} MpmContact;

/* Those of this rank's points, and what they do. */
typedef struct {
  PetscInt           boundary_count;
  const MpmBoundary *boundaries;
  PetscReal (*before)[MPM_MAX_DIM], (*after)[MPM_MAX_DIM]; /* the boundaries' motions at the step's start and end */
  PetscReal (*reaction)[MPM_MAX_DIM], *depth; /* of the last step: forces on the body; deepest places behind, m */
  PetscReal   unit, touch;                    /* 1/h; a face that is no further away touches */
  PetscInt    count, capacity;
  MpmContact *contact;
  PetscReal  *weight;
} MpmContacts;

PetscErrorCode MpmBoundaryCreate(const MpmOptions *options, const char *name, const MpmGrid *grid,
                                 MpmBoundary *boundary);
PetscErrorCode MpmBoundaryDestroy(MpmBoundary *boundary);
/* Do the scene's points suit it? */
PetscErrorCode MpmBoundaryCheck(const MpmBoundary *boundary, const MpmGrid *grid, MpmParticles *particles);
void           MpmBoundaryMotion(const MpmBoundary *boundary, PetscReal time, PetscReal motion[]);
void           MpmBoundaryDistance(const MpmBoundary *boundary, const PetscReal motion[], const PetscReal x[],
                                   MpmSurface *surface);
/* Room for the boundaries' motions and reactions; the boundaries are borrowed. */
PetscErrorCode MpmContactsCreate(PetscInt count, const MpmBoundary boundaries[], MpmContacts *contacts);
PetscErrorCode MpmContactsDestroy(MpmContacts *contacts);
/* Finds the contacts of the step from time_n to `time`. */
PetscErrorCode MpmContactsSetUp(MpmContacts *contacts, const MpmRules *rules, const MpmSpace *space,
                                const MpmPoints *points, MpmParticles *particles, PetscReal time_n, PetscReal time);

/* ---- load.c ---- */

typedef enum { MPM_LOAD_FORCE, MPM_LOAD_GRAVITY, MPM_LOAD_TRACTION } MpmLoadType;

/* A load on the material. Forces and tractions keep each point's share in a field of the particles. */
typedef struct {
  char       *name, *share_field;
  MpmLoadType type;
  PetscReal   value[MPM_MAX_DIM];
  PetscReal   at[MPM_MAX_DIM];
  PetscInt    nearest; /* 0: by region */
  MpmRegion   region;
  PetscInt    face_axis, face_side; /* traction: the face of the points' domains it acts on */
  PetscBool   face_given;
  MpmRamp     ramp;
  PetscBool   active; /* in this stage; its ramp counts from `start` */
  PetscReal   start;
  PetscBool   held; /* the caller has set the factor, and the ramp is not asked */
  PetscReal   factor;
} MpmLoad;

/* Loads, with the names of their blocks. */
typedef struct {
  PetscInt count;
  char   **names;
  MpmLoad *at;
} MpmLoads;

PetscErrorCode MpmLoadCreate(const MpmOptions *options, const char *name, const MpmGrid *grid, MpmLoad *load);
PetscErrorCode MpmLoadDestroy(MpmLoad *load);
/* Finds the points that carry the load, in the initial state. */
PetscErrorCode MpmLoadSelect(MpmLoad *load, const MpmGrid *grid, MpmParticles *particles);
/* ---- residual.c, cell_mean.c, tangent.c, tangent_action.c, sparsity.c ---- */

/* Adds `factor` times the load to the external force at the local nodes. */
PetscErrorCode MpmLoadApply(const MpmLoad *load, PetscReal factor, const MpmRules *rules, const MpmSum *sum,
                            MpmParticles *particles, PetscReal force[]);
/* Adds a body force that is a function of the initial position. */
PetscErrorCode MpmBodyForceApply(MpmBodyForce function, void *ctx, PetscReal time, const MpmSum *sum,
                                 PetscReal force[]);

/*
  Derivatives of a point's fluxes, in one row of numbers, as the kernel gives them; N inputs without the mean m_bar. All but
  the first are there with means only.
*/
typedef struct {
  PetscReal *by_input; /* N x N */
  PetscReal *by_mean;  /* of the N fluxes by m_bar */
  PetscReal *of_mean;  /* of the flux conjugate to m_bar by the N inputs */
  PetscReal *second;   /* of that flux by m_bar */
  PetscReal *dm;       /* of m_bar by the N inputs */
} MpmTangent;
static inline PetscInt MpmTangentSize(const MpmLayout *layout)
{
  return layout->inputs * layout->inputs + layout->means * (3 * layout->inputs + 1);
}
static inline MpmTangent MpmTangentAt(PetscInt N, PetscReal row[])
{
  return (MpmTangent){row, row + N * N, row + N * (N + 1), row + N * (N + 2), row + N * (N + 2) + 1};
}
/* What the passes over a cell with a mean keep of one of its points. */
typedef struct {
  MpmKernelPoint point;
  MpmBasis       basis;
  PetscReal     *input, *dinput; /* of the kernel, and their change: the mean last */
  PetscReal     *flux;           /* conjugate to them */
  PetscReal     *ddm;            /* second derivatives of the point's own m: N x N */
  MpmTangent     tangent;
} MpmCellPoint;
/* Room for the points of one cell, and the cell's sums: m_bar and the flux conjugate to it. */
typedef struct {
  MpmCellPoint *point;
  PetscInt      begin; /* where the cell's points begin in the points' order */
  PetscReal    *storage, *values, *dvalues, *force;
  PetscReal     mean, mean_flux;
} MpmCellWork;
PetscErrorCode MpmCellWorkCreate(const MpmSum *sum, MpmCellWork *work);
PetscErrorCode MpmCellWorkDestroy(MpmCellWork *work);
/* The cell's points in the points' order, [begin, end). */
static inline PetscInt MpmCellBegin(const MpmSum *sum, const MpmCell *cell)
{
  return sum->space->groups[cell->group_begin].point_begin;
}
static inline PetscInt MpmCellEnd(const MpmSum *sum, const MpmCell *cell)
{
  return sum->space->groups[cell->group_end - 1].point_end;
}
/* Basis functions, inputs from the nodal values u, and their change from du; either may be NULL. */
PetscErrorCode MpmCellInputs(const MpmSum *sum, const MpmCell *cell, const PetscReal u[], const PetscReal du[],
                             MpmCellWork *work);
/* m_bar from the inputs, and its derivatives; those of m of second order where they are asked for. */
PetscErrorCode MpmCellMean(const MpmSum *sum, const MpmCell *cell, PetscBool second, MpmCellWork *work,
                           PetscInt *failed);
/* All of that at u, and the whole fluxes, the mean's part included; with the step's end where the sum has room for it. */
PetscErrorCode MpmCellResidual(const MpmSum *sum, const MpmCell *cell, const PetscReal u[], MpmCellWork *work,
                               PetscInt *failed);
/* The same with tangents in place of the step's end. */
PetscErrorCode MpmCellTangent(const MpmSum *sum, const MpmCell *cell, const PetscReal u[], MpmCellWork *work,
                              PetscInt *failed);
/* Fluxes to nodal forces. */
PetscErrorCode MpmCellScatter(const MpmSum *sum, const MpmCell *cell, const MpmCellWork *work, PetscReal force[]);
/*
  The sparsity pattern, in node blocks, and where this rank's contributions go: rows of owned nodes hold what any rank
  adds to them; rows of ghosts hold this rank's part only. Columns are global node numbers, ascending. A row stands in
  the matrix's own array, or, where its columns are not all this rank's, in a buffer with the same order.
*/
typedef struct {
  PetscInt     block, dim, window, reach; /* a row's columns lie in a window of (2*reach + 1)^dim nodes around it */
  PetscInt     local, owned;
  PetscInt    *row;    /* local + 1: where each row's columns start */
  PetscInt    *column; /* global node numbers */
  PetscInt    *slot;   /* local * window: position in the row, or -1 */
  PetscReal  **value;  /* per row, row-major: value[i][(c * columns_i + k)*block + c'] */
  PetscReal   *buffer;
  PetscInt64   buffer_size;
  PetscScalar *array;                /* the matrix's, lent between Begin and End; NULL: all rows are in the buffer */
  const MpmConstraints *constraints; /* whose unknowns are left out, between Begin and End */
} MpmPattern;

PetscErrorCode MpmPatternSetUp(MpmPattern *pattern, const MpmSpace *space, MPI_Comm comm, PetscInt block,
                               PetscBool *changed);
PetscErrorCode MpmPatternReset(MpmPattern *pattern);
PetscErrorCode MpmPatternCreateMat(const MpmPattern *pattern, const MpmSpace *space, MPI_Comm comm, MatType type,
                                   Mat *mat);
/* Between these two, blocks are added. Begin zeroes the matrix; End puts `diagonal` on constrained rows and assembles. */
PetscErrorCode MpmPatternBegin(MpmPattern *pattern, const MpmSpace *space, const MpmConstraints *constraints, Mat mat);
PetscErrorCode MpmPatternEnd(MpmPattern *pattern, const MpmSpace *space, PetscReal diagonal, Mat mat);
/*
  Adds a box's element block, stored [i][c][c'][j]; rows and columns of constrained unknowns, and those of holes, are left
  out.
*/
void MpmPatternAddBlock(MpmPattern *pattern, const MpmSpace *space, const MpmGroup *group, PetscReal element[]);
/* Adds a b^T + b c^T to a box, of vectors stored [i][c], likewise; the vectors are changed. */
void MpmPatternAddPair(MpmPattern *pattern, const MpmSpace *space, const MpmGroup *box, PetscReal a[], PetscReal b[],
                       PetscReal c[]);

/* ---- terms.c ---- */

/*
  A term of the residual, with its derivatives. Arrays hold values at the local nodes; what is ghosts' goes to their owners
  later. `failed` counts points without an answer on this rank. Any function may be NULL: the term then has no such part.

  boxes     boxes of nodes that the term couples, added to a space whose nodes are not numbered yet
  residual  residual += term(u)
  tangent   element blocks of d term / d u into the pattern; where `residual` is not NULL it also does what residual() does
  apply     y += (d term / d u) du; NULL for the points, whose action keeps data of its own (MpmAction)
  diagonal  its diagonal blocks, block^2 values a node
*/
typedef struct {
  const char *name;
  PetscErrorCode (*boxes)(void *ctx, const MpmRules *rules, const MpmPoints *points, MpmSpace *space);
  PetscErrorCode (*residual)(const void *ctx, const MpmSum *sum, const PetscReal u[], PetscReal residual[],
                             PetscInt *failed);
  PetscErrorCode (*tangent)(const void *ctx, const MpmSum *sum, const PetscReal u[], MpmPattern *pattern,
                            PetscReal residual[], PetscInt *failed);
  PetscErrorCode (*apply)(const void *ctx, const MpmSum *sum, const PetscReal u[], const PetscReal du[], PetscReal y[]);
  PetscErrorCode (*diagonal)(const void *ctx, const MpmSum *sum, const PetscReal u[], PetscReal blocks[],
                             PetscInt *failed);
} MpmTerm;

extern const MpmTerm MpmTermPoints;    /* the physics at the points (residual.c, tangent.c) */
extern const MpmTerm MpmTermCellMeans; /* the same where it takes a mean over the cell */
extern const MpmTerm MpmTermGhost;     /* the ghost penalty (ghost_penalty.c) */
extern const MpmTerm MpmTermContact;   /* rigid surfaces (rigid_contact.c); ctx: MpmContacts */

/* The terms of a problem; the first one is that of the points. */
typedef struct {
  PetscInt        count;
  const MpmTerm **term;
  void          **ctx;
} MpmTerms;

PetscErrorCode MpmTermsAdd(MpmTerms *terms, const MpmTerm *term, void *ctx);
PetscErrorCode MpmTermsDestroy(MpmTerms *terms);
/* The space of the points with the boxes of all terms; `why` as for MpmSpaceBegin(). */
PetscErrorCode MpmTermsSetUpSpace(const MpmTerms *terms, MpmSpace *space, const MpmRules *rules,
                                  const MpmPoints *points, const char **why);
/* Sums over all terms; `blocks` starts from zero. */
PetscErrorCode MpmTermsResidual(const MpmTerms *terms, const MpmSum *sum, const PetscReal u[], PetscReal residual[],
                                PetscInt *failed);
PetscErrorCode MpmTermsTangent(const MpmTerms *terms, const MpmSum *sum, const PetscReal u[], MpmPattern *pattern,
                               PetscReal residual[], PetscInt *failed);
PetscErrorCode MpmTermsDiagonal(const MpmTerms *terms, const MpmSum *sum, const PetscReal u[], PetscReal blocks[],
                                PetscInt *failed);
/* The tangents of all but the points, for forms of the Jacobian that take the points in a way of their own. */
PetscErrorCode MpmTermsTangentRest(const MpmTerms *terms, const MpmSum *sum, const PetscReal u[], MpmPattern *pattern,
                                   PetscInt *failed);

/* Reactions and depths of the converged step; keeps the slips. */
PetscErrorCode MpmContactsCommit(MpmContacts *contacts, const MpmSum *sum, const PetscReal u[],
                                 MpmParticles *particles);

/*
  The Jacobian's action without a matrix. With `stored` each point keeps its tangent; otherwise one dual direction makes
  the product anew each time. With `differences` the plain kernel is differenced in place of duals.
*/
typedef struct {
  const MpmSum   *sum;
  const MpmTerms *terms;
  PetscBool       differences;
  PetscReal      *u;         /* at the local nodes: where the derivative is taken */
  PetscReal      *tangent;   /* per place in the points' order, or NULL */
  PetscReal      *mean_flux; /* per cell */
  PetscReal      *values, *dvalues, *force, *storage;
  MpmBasis        basis;
  MpmCellWork     cell;
} MpmAction;
PetscErrorCode MpmActionCreate(const MpmTerms *terms, const MpmSum *sum, PetscBool stored, MpmAction *action);
PetscErrorCode MpmActionSetState(MpmAction *action, const PetscReal u[], PetscInt *failed);
/* y += J du at the local nodes, of one unit of the points, or of all terms. */
PetscErrorCode MpmActionApplyUnit(MpmAction *action, PetscInt unit, const PetscReal du[], PetscReal y[],
                                  PetscInt *failed);
PetscErrorCode MpmActionApply(MpmAction *action, const PetscReal du[], PetscReal y[], PetscInt *failed);
PetscErrorCode MpmActionDestroy(MpmAction *action);

/*
  The discrete problem of a step: the points as they are lent to it, its space, what is prescribed, and what the sums over
  points work with. Arrays of nodal values are those of the local nodes, along the axes.
*/
typedef struct {
  MpmGrid        grid;
  MpmLayout      layout;
  PetscInt       material_count; /* of the scene's, sum.materials */
  MpmPoints      points;
  MpmSpace       space;
  MpmConstraints constraints;
  MpmPattern     pattern;
  MpmSum         sum;
  MpmContacts    contacts;
  MpmTerms       terms;
  MpmTrial       trial;
  PetscReal     *u, *residual, *force;
  PetscReal     *reaction;  /* per condition and component of the block */
  PetscBool      committed; /* do these three tell of the last step that has become the state? */
  PetscReal      diagonal;  /* of prescribed unknowns: a typical stiffness */
  PetscReal      ghost;     /* factor of the ghost penalty, 0: none */
} MpmDiscretization;

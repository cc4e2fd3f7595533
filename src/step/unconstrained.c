/*
  Support of the material after a failed step. Rigid body motions that neither conditions nor boundaries resist make the
  Jacobian singular, and the failure of Newton's method is then not the reason.

  A piece is a set of active nodes that points connect, or contacts of bodies, by which one may support the other. With
  c its centre, R its radius and m_k(x) its rigid motions (translations; rotations about c, over R), each prescribed
  displacement q . u = g gives a row r_k = q . m_k(x). Motions in the null space of M = sum r r^T are free. A boundary
  supports along its normal the material that touches it, and fully with stick. A free translation along which the loads
  have a resultant leaves no equilibrium, however short the step.

  Where all is supported in this sense, a piece may slide all the same. Bodies in contact make pieces by themselves:
  motions that neither contact nor friction resists, as a body starts without touching, or without friction, are free.
  Loose pieces are supported along normals only: one that the loads push along a free motion rests on friction alone.
*/
#include "point/layout.h"
#include "particles/body.h"
#include "space/space.h"
#include "space/sum.h"
#include "bc/bc.h"
#include "volume/inertia.h"
#include "assembly/terms.h"
#include "pairs/body_contact.h"
#include "contact/contact.h"
#include "query/model.h"
#include "step/step.h"

#include <petscblaslapack.h>

#define MOTIONS_MOST 6
#define ZERO         1e-10 /* of sums of numbers about 1 */
#define PUSHED       1e-3  /* of a loose piece's loads: normals of facets turn with them, */
#define TURNS        0.05  /* and so does it as it slides: by less, over its radius, that is a translation */

static const PetscReal units[MPM_MAX_DIM][MPM_MAX_DIM] = {{1., 0., 0.}, {0., 1., 0.}, {0., 0., 1.}};

/* ---- pieces ---- */

/* Connections of a piece: contacts of bodies, too; or without them; the latter without friction. */
typedef enum { WHOLE, APART, LOOSE } Kind;

/* Supports and loads of a piece; all numbers, to be summed over the ranks. */
typedef struct {
  PetscReal M[MOTIONS_MOST * MOTIONS_MOST];
  PetscReal load[MOTIONS_MOST], size; /* resultants, and the sum of all nodes' forces without their signs */
} Sums;

typedef struct {
  MpmModel  model;
  Kind      kind;
  PetscInt  dim, motions, count;
  PetscInt *of; /* the piece of each local node */
  PetscReal (*centre)[MPM_MAX_DIM], *radius;
  Sums *sums;
} Pieces;

/* Results for a piece: null vectors of M, its free and loaded motions. */
typedef struct {
  PetscInt  free_count;
  PetscReal free[MOTIONS_MOST][MOTIONS_MOST];
  PetscBool axis[MPM_MAX_DIM],
    pushed; /* free translations along axes; the loads push along one (loose: along any motion) */
} Freedom;

static PetscInt Root(PetscInt parent[], PetscInt i)
{
  while (parent[i] != i) i = parent[i] = parent[parent[i]];
  return i;
}

/* The first active node of a box. */
static PetscInt FirstNode(const MpmSpace *space, PetscInt box)
{
  const PetscInt *node = &space->group_nodes[space->groups[box].node_offset];

  while (*node < 0) node++;
  return *node;
}

/* Gives all nodes of a piece the lowest global number among them. */
static PetscErrorCode LabelPieces(const MpmModel model, Kind kind, PetscInt label[])
{
  const MpmSpace *space = model->disc.space;
  PetscInt       *parent;
  PetscBool       changed = PETSC_TRUE;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(space->local, &parent));
  for (PetscInt i = 0; i < space->local; i++) {
    parent[i] = i;
    label[i]  = space->number.global[i];
  }
  for (PetscInt g = 0; g < space->group_count; g++) {
    const PetscInt *node = &space->group_nodes[space->groups[g].node_offset];

    for (PetscInt k = 1; k < space->groups[g].node_count; k++) parent[Root(parent, node[k])] = Root(parent, node[0]);
  }
  for (PetscInt k = 0; kind == WHOLE && k < space->parts.couple_count; k++) {
    const PetscInt *box = space->parts.couple[k].box;

    parent[Root(parent, FirstNode(space, box[1]))] = Root(parent, FirstNode(space, box[0]));
  }
  while (changed) {
    changed = PETSC_FALSE;
    for (PetscInt i = 0; i < space->local; i++) {
      PetscInt *lowest = &label[Root(parent, i)];

      *lowest = PetscMin(*lowest, label[i]);
    }
    for (PetscInt i = 0; i < space->local; i++) label[i] = label[Root(parent, i)];
    if (!space->number.sf) break;
    PetscCall(PetscSFReduceBegin(space->number.sf, MPIU_INT, label, label, MPI_MIN));
    PetscCall(PetscSFReduceEnd(space->number.sf, MPIU_INT, label, label, MPI_MIN));
    PetscCall(PetscSFBcastBegin(space->number.sf, MPIU_INT, label, label, MPI_REPLACE));
    PetscCall(PetscSFBcastEnd(space->number.sf, MPIU_INT, label, label, MPI_REPLACE));
    for (PetscInt i = 0; i < space->local && !changed; i++) changed = (PetscBool)(label[i] != label[Root(parent, i)]);
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &changed, 1, MPM_MPI_BOOL, MPI_LOR, model->comm));
  }
  PetscCall(PetscFree(parent));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* All ranks know all pieces: their labels are the global numbers of one node each. */
static PetscErrorCode FindPieces(MpmModel model, Kind kind, Pieces *pieces)
{
  const MpmSpace *space = model->disc.space;
  PetscInt       *own, *label;
  PetscMPIInt     mine = 0, *count, *start;

  PetscFunctionBeginUser;
  *pieces = (Pieces){
    .model = model, .kind = kind, .dim = model->disc.dim, .motions = model->disc.dim * (model->disc.dim + 1) / 2};
  PetscCall(PetscMalloc1(space->local, &pieces->of));
  PetscCall(PetscMalloc3(space->owned, &own, model->size, &count, (model->size + 1), &start));
  PetscCall(LabelPieces(model, kind, pieces->of));
  for (PetscInt i = 0; i < space->owned; i++)
    if (pieces->of[i] == space->number.global[i] && !MpmSpaceIsExtra(space, i)) own[mine++] = space->number.global[i];
  PetscCallMPI(MPI_Allgather(&mine, 1, MPI_INT, count, 1, MPI_INT, model->comm));
  start[0] = 0;
  for (PetscMPIInt r = 0; r < model->size; r++) start[r + 1] = start[r] + count[r];
  pieces->count = start[model->size];
  PetscCall(PetscMalloc1(pieces->count, &label));
  PetscCallMPI(MPI_Allgatherv(own, mine, MPIU_INT, label, count, start, MPIU_INT, model->comm));
  PetscCall(PetscSortInt(pieces->count, label));
  for (PetscInt i = 0; i < space->local; i++)
    PetscCall(PetscFindInt(pieces->of[i], pieces->count, label, &pieces->of[i]));
  PetscCall(PetscCalloc3(pieces->count, &pieces->centre, pieces->count, &pieces->radius, pieces->count, &pieces->sums));
  PetscCall(PetscFree(label));
  PetscCall(PetscFree3(own, count, start));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* As many numbers of each piece, summed over the ranks. */
static PetscErrorCode SumPieces(const Pieces *pieces, size_t each, PetscReal values[])
{
  PetscMPIInt count;

  PetscFunctionBeginUser;
  PetscCall(PetscMPIIntCast(pieces->count * (PetscInt)each, &count));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, values, count, MPIU_REAL, MPIU_SUM, pieces->model->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Means over the nodes, and the root of their mean square distance; a cell at least. */
static PetscErrorCode FindCentres(Pieces *pieces)
{
  PetscReal x[MPM_MAX_DIM], *square, *nodes;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc2(pieces->count, &nodes, pieces->count, &square));
  for (PetscInt i = 0; i < pieces->model->disc.space->owned; i++) {
    const PetscInt k = pieces->of[i];

    if (MpmSpaceIsExtra(pieces->model->disc.space, i)) continue;
    MpmNodePosition(&pieces->model->disc, i, x);
    nodes[k] += 1.;
    for (PetscInt a = 0; a < pieces->dim; a++) pieces->centre[k][a] += x[a];
  }
  PetscCall(SumPieces(pieces, 1, nodes));
  PetscCall(SumPieces(pieces, MPM_MAX_DIM, pieces->centre[0]));
  for (PetscInt k = 0; k < pieces->count; k++)
    for (PetscInt a = 0; a < pieces->dim; a++) pieces->centre[k][a] /= nodes[k];
  for (PetscInt i = 0; i < pieces->model->disc.space->owned; i++) {
    const PetscInt k = pieces->of[i];

    if (MpmSpaceIsExtra(pieces->model->disc.space, i)) continue;
    MpmNodePosition(&pieces->model->disc, i, x);
    for (PetscInt a = 0; a < pieces->dim; a++) square[k] += PetscSqr(x[a] - pieces->centre[k][a]);
  }
  PetscCall(SumPieces(pieces, 1, square));
  for (PetscInt k = 0; k < pieces->count; k++)
    pieces->radius[k] = PetscMax(PetscSqrtReal(square[k] / nodes[k]), pieces->model->disc.h[0]);
  PetscCall(PetscFree2(nodes, square));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- supports ---- */

/* q . m_k(x) of all motions: translations, then rotations about the axes (in 2D the one across the plane). */
static void Row(const Pieces *pieces, PetscInt piece, const PetscReal q[], const PetscReal x[], PetscReal row[])
{
  const PetscInt dim  = pieces->dim;
  PetscReal      r[3] = {0., 0., 0.}, d[3] = {0., 0., 0.};

  for (PetscInt a = 0; a < dim; a++) {
    r[a]   = (x[a] - pieces->centre[piece][a]) / pieces->radius[piece];
    row[a] = d[a] = q[a];
  }
  for (PetscInt k = dim; k < pieces->motions; k++) {
    const PetscInt axis = k + 3 - pieces->motions, p = (axis + 1) % 3, s = (axis + 2) % 3;

    row[k] = r[p] * d[s] - r[s] * d[p];
  }
}

static void Hold(const Pieces *pieces, PetscInt piece, const PetscReal q[], const PetscReal x[])
{
  const PetscInt m = pieces->motions;
  PetscReal      row[MOTIONS_MOST];

  Row(pieces, piece, q, x, row);
  for (PetscInt i = 0; i < m; i++)
    for (PetscInt j = 0; j < m; j++) pieces->sums[piece].M[i * m + j] += row[i] * row[j];
}

static void HoldByConditions(Pieces *pieces)
{
  const MpmModel model = pieces->model;
  const PetscInt bs = model->disc.block, dim = pieces->dim;

  for (PetscInt i = 0; i < model->disc.space->owned; i++) {
    const MpmFrame *frame = MpmConstraintsFrame(model->disc.constraints, i);
    PetscReal       x[MPM_MAX_DIM];

    if (MpmSpaceIsExtra(model->disc.space, i)) continue;
    MpmNodePosition(&pieces->model->disc, i, x);
    for (PetscInt a = 0; a < dim; a++) {
      PetscReal unit[MPM_MAX_DIM] = {0., 0., 0.};

      unit[a] = 1.;
      if (!MpmConstraintsCounts(model->disc.constraints, i * bs + a))
        Hold(pieces, pieces->of[i], frame ? frame->axis[a] : unit, x);
    }
  }
}

/* Boundaries support material that touches them at the step's start or, if they move, at its end. */
static void HoldByBoundaries(Pieces *pieces)
{
  const MpmModel     model    = pieces->model;
  const MpmContacts *contacts = model->disc.context.contacts;
  const PetscInt     dim      = pieces->dim;

  for (PetscInt k = 0; k < contacts->facets.count; k++) {
    const MpmFacet    *facet    = &contacts->facets.at[k];
    const MpmBoundary *boundary = &contacts->facets.boundaries[facet->boundary];
    const PetscInt     node     = model->disc.space->group_nodes[model->disc.space->groups[facet->group].node_offset];
    const PetscInt     piece    = pieces->of[node];
    const PetscBool    firm     = (PetscBool)(boundary->bilateral && boundary->stick);
    MpmSurface         before, after;

    MpmBoundaryDistance(boundary, &contacts->facets.before[facet->boundary], facet->place, &before);
    MpmBoundaryDistance(boundary, &contacts->facets.after[facet->boundary], facet->place, &after);
    if (!boundary->bilateral &&
        PetscMin(before.distance, after.distance) - facet->touches > MPM_TOLERANCE * model->disc.h[0])
      continue;
    Hold(pieces, piece, before.normal, facet->place);
    for (PetscInt a = 0; a < dim && boundary->tangential && (pieces->kind != LOOSE || firm); a++) {
      Hold(pieces, piece, units[a], facet->place);
    }
  }
}

/* Pieces that bodies make hold each other where they touch as the step starts. */
static void HoldByPairs(Pieces *pieces)
{
  const MpmModel         model = pieces->model;
  const MpmPairContacts *pairs = model->disc.context.pairs;

  for (PetscInt k = 0; pieces->kind != WHOLE && k < pairs->patch_count; k++) {
    const MpmPairPatch *patch = &pairs->patch[k];
    const MpmPair      *pair  = &pairs->pairs->at[patch->pair];

    if (patch->gap - patch->touches > (pair->barrier ? MPM_BARRIER * pairs->cell : MPM_TOLERANCE * model->disc.h[0]))
      continue;
    for (PetscInt s = 0; s < 2; s++) {
      const PetscInt piece = pieces->of[FirstNode(model->disc.space, patch->side[s].box)];

      Hold(pieces, piece, patch->normal, patch->side[s].place);
      for (PetscInt a = 0; a < pieces->dim && pair->tangential && pieces->kind == APART; a++)
        Hold(pieces, piece, units[a], patch->side[s].place);
    }
  }
}

static void AddLoads(Pieces *pieces)
{
  const MpmModel model = pieces->model;
  const PetscInt bs = model->disc.block, dim = pieces->dim;

  for (PetscInt i = 0; i < model->disc.space->local; i++) {
    const PetscReal *force = &model->disc.nodal.force[i * bs];
    PetscReal        x[MPM_MAX_DIM], row[MOTIONS_MOST];

    if (MpmSpaceIsExtra(model->disc.space, i)) continue;
    Sums *sums = &pieces->sums[pieces->of[i]];

    MpmNodePosition(&pieces->model->disc, i, x);
    Row(pieces, pieces->of[i], force, x, row);
    for (PetscInt k = 0; k < pieces->motions; k++) sums->load[k] += row[k];
    for (PetscInt a = 0; a < dim; a++) sums->size += PetscAbsReal(force[a]);
  }
}

/* ---- free motions ---- */

/* True for a translation. */
static PetscBool IsTranslation(const Pieces *pieces, const PetscReal motion[])
{
  for (PetscInt k = pieces->dim; k < pieces->motions; k++)
    if (PetscAbsReal(motion[k]) > (pieces->kind == WHOLE ? 1e-6 : TURNS)) return PETSC_FALSE;
  return PETSC_TRUE;
}

/* True of a motion that nothing holds, or across bodies' contacts no more than the turn of their faces does. */
static PetscBool IsFree(const Pieces *pieces, PetscReal held, const PetscReal motion[])
{
  return (PetscBool)(held <= ZERO ||
                     (pieces->kind == APART && held <= PetscSqr(TURNS) && IsTranslation(pieces, motion)));
}

static PetscErrorCode FindFreedom(const Pieces *pieces, const Sums *sums, Freedom *freedom)
{
  const PetscInt m = pieces->motions;
  PetscReal      vectors[MOTIONS_MOST * MOTIONS_MOST], value[MOTIONS_MOST], trace = 0.;
  PetscScalar    work[8 * MOTIONS_MOST];
  PetscBLASInt   n, size = 8 * MOTIONS_MOST, info;

  PetscFunctionBeginUser;
  *freedom = (Freedom){.free_count = 0};
  PetscCall(PetscBLASIntCast(m, &n));
  PetscCall(PetscArraycpy(vectors, sums->M, m * m));
  for (PetscInt k = 0; k < m; k++) trace += sums->M[k * m + k];
  PetscCallBLAS("LAPACKsyev", LAPACKsyev_("V", "U", &n, vectors, &n, value, work, &size, &info));
  PetscCheck(!info, PETSC_COMM_SELF, PETSC_ERR_LIB, "LAPACK syev failed with %d", (int)info);
  for (PetscInt k = 0; k < m; k++) {
    if (!IsFree(pieces, trace > 0. ? value[k] / trace : 0., &vectors[k * m])) continue;
    PetscCall(PetscArraycpy(freedom->free[freedom->free_count], &vectors[k * m], m));
    freedom->free_count++;
  }
  for (PetscInt a = 0; a < pieces->dim; a++) {
    PetscReal square = 0.;

    for (PetscInt k = 0; k < freedom->free_count; k++) square += PetscSqr(freedom->free[k][a]);
    freedom->axis[a] = (PetscBool)(square > 1. - (pieces->kind == WHOLE ? 1e-6 : PetscSqr(TURNS)));
    if (freedom->axis[a] && PetscAbsReal(sums->load[a]) > ZERO * sums->size) freedom->pushed = PETSC_TRUE;
  }
  for (PetscInt k = 0; pieces->kind == LOOSE && k < freedom->free_count; k++) {
    PetscReal push = 0.;

    for (PetscInt i = 0; i < m; i++) push += freedom->free[k][i] * sums->load[i];
    if (PetscAbsReal(push) > PUSHED * sums->size) freedom->pushed = PETSC_TRUE;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode DescribeVector(const Pieces *pieces, const char head[], const PetscReal vector[], char **text)
{
  PetscFunctionBeginUser;
  PetscCall(MpmTextAppend(text, "%s(%.4g, %.4g", head, (double)vector[0], (double)vector[1]));
  if (pieces->dim > 2) PetscCall(MpmTextAppend(text, ", %.4g", (double)vector[2]));
  PetscCall(MpmTextAppend(text, ")"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The first body with points in a piece, or none; collective. */
static PetscErrorCode FindBody(const Pieces *pieces, PetscInt piece, const char **name)
{
  const MpmSpace  *space  = pieces->model->disc.space;
  const MpmBodies *bodies = pieces->model->scene.bodies;
  PetscInt         first  = bodies->count;

  PetscFunctionBeginUser;
  for (PetscInt g = 0; g < space->group_count; g++) {
    const MpmGroup *group = &space->groups[g];

    if (group->point_end == group->point_begin || pieces->of[FirstNode(space, g)] != piece) continue;
    first = PetscMin(first, MpmBodyNumber(bodies, pieces->model->disc.sum->points, space->order[group->point_begin]));
  }
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &first, 1, MPIU_INT, MPI_MIN, pieces->model->comm));
  *name = first < bodies->count ? bodies->names[first] : NULL;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* "nothing holds the material against translation in y" */
static PetscErrorCode Describe(const Pieces *pieces, PetscInt piece, const Freedom *freedom, char **text)
{
  const char *name  = NULL;
  PetscInt    named = 0;

  PetscFunctionBeginUser;
  if (pieces->kind != WHOLE) PetscCall(FindBody(pieces, piece, &name));
  PetscCall(MpmTextAppend(text, pieces->kind == LOOSE ? "nothing but friction holds " : "nothing holds "));
  if (name) PetscCall(MpmTextAppend(text, "body %s", name));
  else if (pieces->count == 1) PetscCall(MpmTextAppend(text, "the material"));
  else PetscCall(DescribeVector(pieces, "the piece about ", pieces->centre[piece], text));
  PetscCall(MpmTextAppend(text, " against "));
  for (PetscInt a = 0; a < pieces->dim; a++)
    if (freedom->axis[a]) PetscCall(MpmTextAppend(text, "%s%c", named++ ? ", " : "translation in ", "xyz"[a]));
  if (!named && IsTranslation(pieces, freedom->free[0]))
    PetscCall(DescribeVector(pieces, "translation along ", freedom->free[0], text));
  else if (freedom->free_count > named) PetscCall(MpmTextAppend(text, "%srotation", named ? " and " : ""));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  The piece that loads push along a free motion, or the first that has one (loose: only the former); `worst` is -1 where
  none has. Free `pieces` with Forget().
*/
static PetscErrorCode Examine(MpmModel model, Kind kind, Pieces *pieces, PetscInt *worst, Freedom *freedom)
{
  PetscFunctionBeginUser;
  *worst          = -1;
  freedom->pushed = PETSC_FALSE;
  PetscCall(FindPieces(model, kind, pieces));
  PetscCall(FindCentres(pieces));
  HoldByConditions(pieces);
  HoldByBoundaries(pieces);
  HoldByPairs(pieces);
  AddLoads(pieces);
  PetscCall(SumPieces(pieces, sizeof(Sums) / sizeof(PetscReal), (PetscReal *)pieces->sums));
  for (PetscInt k = 0; k < pieces->count; k++) {
    PetscCall(FindFreedom(pieces, &pieces->sums[k], freedom));
    if (!freedom->free_count || ((kind == LOOSE || *worst >= 0) && !freedom->pushed)) continue;
    *worst = k;
    if (freedom->pushed) break;
  }
  if (*worst >= 0) PetscCall(FindFreedom(pieces, &pieces->sums[*worst], freedom));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Forget(Pieces *pieces)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(pieces->of));
  PetscCall(PetscFree3(pieces->centre, pieces->radius, pieces->sums));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmUnconstrainedIsPushed(MpmModel model, PetscBool *pushed)
{
  Pieces   pieces;
  Freedom  freedom;
  PetscInt worst;

  PetscFunctionBeginUser;
  *pushed = PETSC_FALSE;
  if (!model->disc.layout->traits.solid || model->disc.context.inertia->active) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Examine(model, WHOLE, &pieces, &worst, &freedom));
  *pushed = (PetscBool)(worst >= 0 && freedom.pushed);
  PetscCall(Forget(&pieces));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmUnconstrainedExplain(MpmModel model, MpmOutcome *outcome)
{
  Pieces   pieces;
  Freedom  freedom;
  PetscInt worst;
  char    *text = NULL;

  PetscFunctionBeginUser;
  if (!model->disc.layout->traits.solid || model->disc.context.inertia->active) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt kind = WHOLE; kind <= LOOSE && !text; kind++) {
    if ((kind == APART && !model->scene.pairs->count) ||
        (kind == LOOSE && !model->scene.pairs->count && !model->scene.boundaries->count))
      continue;
    PetscCall(Examine(model, (Kind)kind, &pieces, &worst, &freedom));
    if (worst >= 0) {
      PetscCall(Describe(&pieces, worst, &freedom, &text));
      PetscCall(MpmTextAppend(&text, " (%s)", outcome->text));
      if (kind == LOOSE)
        PetscCall(MpmTextAppend(&text, "; if it slides on, that takes inertia (-mpm_time_integrator)"));
      PetscCall(MpmOutcomeFail(outcome, MPM_OUTCOME_UNCONSTRAINED, "%s", text));
      outcome->retryable =
        (PetscBool)(outcome->retryable && (kind != WHOLE || !freedom.pushed || model->scene.boundaries->count));
    }
    PetscCall(Forget(&pieces));
  }
  if (!text) PetscCall(MpmTermsUnheld(model->disc.terms, model->disc.sum, model->disc.nodal.u, outcome));
  PetscCall(PetscFree(text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

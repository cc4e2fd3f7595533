/*
  Bodies that exist at one time must not overlap: their mass would count twice. A body with priority replaces those that
  it overlaps: they have no points where centres lie within its region, from the start on. A place that a body gave up
  is none of its own any more.

  A point claims the material at its centre. The point overlaps another body when the centre lies inside that body's
  region, not merely on its edge. Bodies from files have no region; their points overlap others when, in one cell of the
  grid, the centre of one lies in the domain of the other. Nothing of this depends on the number of ranks. On an edge
  that two bodies with one lattice share, the points are those of the body that is named first.

  Two points of one file in one place are a row that stands there twice: refused, too.
*/
#include <stdint.h>
#include "grid/grid.h"
#include "particles/body.h"
#include "particles/particles.h"
#include "particles/points.h"
#include "query/model.h"
#include "model/build.h"

#define IN_DOMAIN 0.9 /* of a domain's half-length: nearer than that is not a neighbour's place */

/* ---- which bodies meet ---- */

/* True where the bodies exist in one stage. */
static PetscBool Meet(const MpmModel model, PetscInt one, PetscInt other)
{
  const PetscInt body[2] = {one, other};
  PetscInt       from = 0, until = model->scene.stages.count;

  for (PetscInt k = 0; k < 2 * model->scene.stages.count; k++) {
    const PetscInt stage = k / 2, b = body[k % 2];

    if (model->scene.stages.at[stage].adds[b]) from = PetscMax(from, stage);
    if (model->scene.stages.at[stage].removed[b]) until = PetscMin(until, stage);
  }
  return (PetscBool)(from < until);
}

/* The stage that the body joins, 0: the first. */
static PetscInt Joins(const MpmModel model, PetscInt b)
{
  PetscInt from = 0;

  for (PetscInt stage = 0; stage < model->scene.stages.count; stage++)
    if (model->scene.stages.at[stage].adds[b]) from = stage;
  return from;
}

/* True where the body gives up what it shares with the other: one that joins later would leave a hole until then. */
static PetscBool Yields(const MpmModel model, PetscInt body, PetscInt other)
{
  const MpmBody *at = model->scene.bodies->at;

  if (body == other || !MpmBodyHasPriority(at[other]) || !Meet(model, body, other)) return PETSC_FALSE;
  return (PetscBool)((!MpmBodyHasPriority(at[body]) || other > body) && Joins(model, other) <= Joins(model, body));
}

PetscErrorCode MpmBodiesSettlePriority(MpmModel model)
{
  MpmBody *winners;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(model->scene.bodies->count, &winners));
  for (PetscInt b = 0; b < model->scene.bodies->count; b++) {
    PetscInt count = 0;

    for (PetscInt c = 0; c < model->scene.bodies->count; c++)
      if (Yields(model, b, c)) winners[count++] = model->scene.bodies->at[c];
    if (count) PetscCall(MpmBodySetWinners(model->scene.bodies->at[b], count, winners));
  }
  PetscCall(PetscFree(winners));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmBodiesShareEdges(MpmModel model)
{
  MpmBody *before;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(model->scene.bodies->count, &before));
  for (PetscInt b = 1; b < model->scene.bodies->count; b++) {
    PetscInt count = 0;

    for (PetscInt c = 0; c < b; c++)
      if (Meet(model, b, c)) before[count++] = model->scene.bodies->at[c];
    PetscCall(MpmBodySetBefore(model->scene.bodies->at[b], count, before));
  }
  PetscCall(PetscFree(before));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- which points overlap ---- */

/* The first overlap found: of the first two bodies that do, the one with the lowest id. */
typedef struct {
  const MpmGrid *grid;
  MpmBody       *bodies;
  PetscInt       body_count;
  PetscInt64     ids;     /* where they end */
  PetscBool     *meet;    /* body_count^2 */
  PetscInt      *body_of; /* per point */
  MpmPoints      points;
  PetscInt64     key; /* INT64_MAX: none */
  PetscReal      place[MPM_MAX_DIM];
} Search;

static void Found(Search *search, PetscInt p, PetscInt other)
{
  const PetscInt   one = search->body_of[p], low = PetscMin(one, other), high = PetscMax(one, other);
  const PetscInt64 key = ((PetscInt64)low * search->body_count + high) * search->ids + search->points.id[p];

  if (key >= search->key) return;
  search->key = key;
  for (PetscInt a = 0; a < search->grid->dim; a++) search->place[a] = search->points.x[p * search->grid->dim + a];
}

/* Centres inside other bodies' regions. */
static void SearchRegions(Search *search)
{
  for (PetscInt p = 0; p < search->points.count; p++) {
    const PetscInt   one = search->body_of[p];
    const PetscReal *x   = &search->points.x[p * search->grid->dim];
    const MpmHold    own = MpmBodyHolds(search->bodies[one], search->grid, x);

    for (PetscInt other = 0; other < search->body_count; other++) {
      MpmHold hold;

      if (!search->meet[one * search->body_count + other]) continue;
      hold = MpmBodyHolds(search->bodies[other], search->grid, x);
      if (hold == MPM_HOLD_NONE) continue;
      if (hold == MPM_HOLD_INSIDE ||
          (own == MPM_HOLD_INSIDE && MpmBodiesShareLattice(search->bodies[one], search->bodies[other])))
        Found(search, p, other);
    }
  }
}

/* Half-lengths of a point's domain; a cube of its volume where nothing is known. */
static void Domain(const Search *search, MpmStretch stretch, PetscInt p, PetscReal half[])
{
  const PetscInt   dim  = search->grid->dim;
  const MpmBody    body = search->bodies[search->body_of[p]];
  const PetscReal *F    = MpmPointF(&search->points, p);
  PetscReal        U[MPM_MAX_DIM];

  if (!MpmBodyIsImported(body)) {
    MpmBodyHalfLengths(body, search->grid, half);
  } else if (search->points.domain.half_length && !stretch(F, U)) {
    for (PetscInt a = 0; a < dim; a++) half[a] = U[a] * search->points.domain.half_length[p * dim + a];
  } else {
    for (PetscInt a = 0; a < dim; a++)
      half[a] = 0.5 * PetscPowReal(PetscAbsReal(MpmPointExtent(&search->points, dim, p)), 1. / (PetscReal)dim);
  }
}

/* True where a file has the body's points one by one, as they stand. */
static PetscBool HasRows(MpmBody body)
{
  return (PetscBool)(MpmBodyIsImported(body) && !MpmBodyHandover(body) && !MpmBodyIsReleased(body));
}

/* Two points of one cell and one file: notes them where they are in one place. */
static void SearchTwins(Search *search, PetscInt p, PetscInt q)
{
  const PetscInt dim = search->grid->dim;

  for (PetscInt a = 0; a < dim; a++)
    if (PetscAbsReal(search->points.x[p * dim + a] - search->points.x[q * dim + a]) >
        MPM_TOLERANCE * search->grid->h[a])
      return;
  Found(search, search->points.id[p] < search->points.id[q] ? p : q, search->body_of[p]);
}

/* Two points of one cell: notes an overlap where the centre of one is in the domain of the other. */
static void SearchPair(Search *search, MpmStretch stretch, PetscInt p, PetscInt q)
{
  const PetscInt dim = search->grid->dim, one = search->body_of[p], other = search->body_of[q];
  PetscReal      half[2][MPM_MAX_DIM];
  PetscBool      in[2] = {PETSC_TRUE, PETSC_TRUE};

  if (!search->meet[one * search->body_count + other]) return;
  if (one == other) {
    SearchTwins(search, p, q);
    return;
  }
  if (!MpmBodyIsImported(search->bodies[one]) && !MpmBodyIsImported(search->bodies[other])) return;
  Domain(search, stretch, p, half[0]);
  Domain(search, stretch, q, half[1]);
  for (PetscInt a = 0; a < dim; a++) {
    const PetscReal distance = PetscAbsReal(search->points.x[p * dim + a] - search->points.x[q * dim + a]);

    for (PetscInt k = 0; k < 2; k++) in[k] = (PetscBool)(in[k] && distance < IN_DOMAIN * half[k][a]);
  }
  if (in[0] || in[1]) Found(search, one < other ? p : q, one < other ? other : one);
}

/* Points of one cell, where one is from a file. */
static PetscErrorCode SearchCells(Search *search, MpmStretch stretch)
{
  const PetscInt dim = search->grid->dim, n = search->points.count;
  PetscInt       cell[MPM_MAX_DIM], *key, *order;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc2(n, &key, n, &order));
  for (PetscInt p = 0; p < n; p++) { /* as in the lattice of nodes, modulo what an integer holds: a pair more or less */
    MpmGridFindCell(search->grid, &search->points.x[p * dim], cell);
    key[p] =
      (PetscInt)((((dim > 2 ? (PetscInt64)cell[2] : 0) * search->grid->cells[1] + cell[1]) * search->grid->cells[0] +
                  cell[0]) %
                 PETSC_INT_MAX);
    order[p] = p;
  }
  PetscCall(PetscSortIntWithArray(n, key, order));
  for (PetscInt i = 0; i < n; i++)
    for (PetscInt j = i + 1; j < n && key[j] == key[i]; j++) SearchPair(search, stretch, order[i], order[j]);
  PetscCall(PetscFree2(key, order));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Advice on two bodies that overlap. */
static const char *Hint(const MpmModel model, PetscInt one, PetscInt other)
{
  const MpmBody *at = model->scene.bodies->at;

  if (MpmBodyIsImported(at[one]) || MpmBodyIsImported(at[other])) return "";
  if (!MpmBodyHasPriority(at[one]) && !MpmBodyHasPriority(at[other])) return ", unless one of them has priority";
  return "; one that joins later finds no place but that of a body with priority that its stage removes";
}

/* Ends the run where there is an overlap, with equal text on all ranks. */
static PetscErrorCode Refuse(const MpmModel model, Search *search)
{
  const PetscInt dim = search->grid->dim;
  PetscInt64     key = search->key, pair;
  PetscInt       one, other;
  char           where[128];

  PetscFunctionBeginUser;
  PetscCall(MPIU_Allreduce(&search->key, &key, 1, MPIU_INT64, MPI_MIN, model->comm));
  if (key == INT64_MAX) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt a = 0; a < dim && key != search->key; a++) search->place[a] = PETSC_INFINITY;
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, search->place, (PetscMPIInt)dim, MPIU_REAL, MPIU_MIN, model->comm));
  pair  = key / search->ids;
  one   = (PetscInt)(pair / search->body_count);
  other = (PetscInt)(pair % search->body_count);
  PetscCall(PetscSNPrintf(where, sizeof(where), dim > 2 ? "(%g, %g, %g)" : "(%g, %g)", (double)search->place[0],
                          (double)search->place[1], (double)search->place[2]));
  MpmCheckInput(one != other, "-mpm_body_%s_file: two of its points stand at %s; each place must be there once",
                model->scene.bodies->names[one], where);
  MpmCheckInput(PETSC_FALSE,
                "-mpm_bodies: %s and %s overlap, for example at %s; bodies that are there at the same time must not%s",
                model->scene.bodies->names[one], model->scene.bodies->names[other], where, Hint(model, one, other));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmBodiesCheckOverlap(MpmModel model)
{
  const PetscInt n = model->scene.bodies->count;
  Search    search = {.grid = model->disc.grid, .bodies = model->scene.bodies->at, .body_count = n, .key = INT64_MAX};
  PetscInt  first, end;
  PetscBool any = PETSC_FALSE, files = PETSC_FALSE;

  PetscFunctionBeginUser;
  MpmBodyGetIds(model->scene.bodies->at[n - 1], &first, &end);
  search.ids = end;
  PetscCall(PetscCalloc1((n * n), &search.meet));
  for (PetscInt b = 0; b < n; b++) {
    for (PetscInt c = 0; c < n; c++) {
      search.meet[b * n + c] = b == c ? HasRows(model->scene.bodies->at[b]) : Meet(model, b, c);
      any                    = (PetscBool)(any || search.meet[b * n + c]);
      if (search.meet[b * n + c] && MpmBodyIsImported(model->scene.bodies->at[b])) files = PETSC_TRUE;
    }
  }
  if (any) {
    PetscCall(MpmParticlesGetArrays(model->state.particles, &search.points));
    PetscCall(PetscMalloc1(search.points.count, &search.body_of));
    MpmBodiesOfPoints(n, model->scene.bodies->at, &search.points, search.body_of);
    SearchRegions(&search);
    if (files) PetscCall(SearchCells(&search, model->scene.deformation.stretch));
    PetscCall(PetscFree(search.body_of));
    PetscCall(MpmParticlesRestoreArrays(model->state.particles, &search.points));
    PetscCall(Refuse(model, &search));
  }
  PetscCall(PetscFree(search.meet));
  PetscFunctionReturn(PETSC_SUCCESS);
}

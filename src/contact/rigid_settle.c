/*
  Place of rest of a free body on the present material.

  Newton's method on all unknowns needs contacts to start from: a body in the air, or one that leans on a single corner,
  has no stiffness against its load. With the material at rest the body alone has six unknowns at most, and its
  equilibrium is found by steps

    s = -sum_k v_k (v_k . g)/(|lambda_k| + mu) ,

  g being its residual, lambda_k and v_k the eigenvalues and vectors of its derivative, and mu the least number >= 0 for
  which s is not longer than a trusted length, a fraction of a cell at most. A step ends where the work done along it is
  least. The result is only a start for Newton's method; a body in contact that its first step hardly moves stays as it
  is.
*/
#include "base/outcome.h"
#include "grid/grid.h"
#include "space/sum.h"
#include "contact/rigid_body.h"

#include <petscblaslapack.h>

#define MOST       6
#define TRUSTED    0.25 /* cells */
#define NEGLIGIBLE 0.05 /* cells: of a first step */
#define SEARCH     1.   /* cells: how far contacts found at one place serve */
#define STRAY      2.   /* cells: contacts further away may be missing */
#define ITERATIONS 400
#define SEARCHES   40
#define FLAT       0.5
#define SETTLED    1e-7 /* cells */
#define SOFT       1e-7 /* of the largest eigenvalue: components below it are not moved */
#define FREE       1e-4 /* of the stiffness against other components of its motion: contact lets a body go */
#define UNHELD     0.01 /* of the forces in a component: it is not in balance, */
#define ROUNDING   1e-9 /* unless below this fraction of the forces in any */
#define IMBALANCE  0.1  /* residual, relative to the load, below which no settling step is taken */

/* The residual g and its derivative H of the n components of `values` that are solved for. */
typedef struct {
  const MpmGrid   *grid;
  const MpmSum    *sum;
  const PetscReal *u; /* of the material at the local nodes; NULL: none */
  PetscInt         n, component[MOST];
  PetscReal        g[MOST], H[MOST * MOST]; /* H: n x n, zeros behind */
  PetscReal        contact[MOST];           /* of g */
  PetscBool        touches;
} Balance;

/* All but these rotations. */
static void ListComponents(const MpmRigidBody *body, PetscInt spins, Balance *balance)
{
  const PetscInt free[2] = {body->free[0], body->free[1] & ~spins};

  balance->n = 0;
  for (PetscInt k = 0; k < MOST; k++)
    if (free[k / 3] >> k % 3 & 1) balance->component[balance->n++] = k;
}

/* Sums over the contacts of this rank, of MOST numbers g and MOST x MOST of H. */
static PetscErrorCode SumPatches(const MpmContacts *contacts, PetscInt b, const MpmRigidIncrement *q,
                                 const Balance *balance, PetscReal sums[])
{
  const PetscInt n = balance->n, *component = balance->component;
  MpmRigidWork   work;

  PetscFunctionBeginUser;
  PetscCall(MpmRigidWorkCreate(contacts, NULL, &work));
  for (PetscInt k = 0; k < contacts->patch_count; k++) {
    const MpmPatch *patch = &contacts->patch[k];

    if (patch->boundary != b) continue;
    for (PetscInt f = patch->begin; f < patch->end; f++) {
      for (PetscInt a = 0; a < MPM_MAX_DIM; a++) work.u[f - patch->begin][a] = 0.;
      if (balance->u) MpmPatchValue(contacts, balance->sum, patch, f, balance->u, work.u[f - patch->begin]);
    }
    MpmRigidPatch(contacts, patch, q, &work);
    if (!work.answer.any) continue;
    MpmRigidMean(contacts, patch, q, 0, &work);
    for (PetscInt i = 0; i < n; i++)
      for (PetscInt jm = 0; jm < 4 * n; jm++)
        sums[MOST + i * MOST + jm % n] +=
          work.left[jm / n * MOST + component[i]] * work.right[jm / n * MOST + component[jm % n]];
    for (PetscInt f = patch->begin; f < patch->end; f++) {
      MpmRigidAnswer coupled;

      MpmRigidFacet(contacts, patch, f, q, &work, PETSC_TRUE, &coupled);
      for (PetscInt i = 0; i < n; i++) {
        const PetscInt row = component[i];

        sums[i] += coupled.residual[1 + row / 3][row % 3];
        for (PetscInt c = 0; c < n; c++)
          sums[MOST + i * MOST + c] += coupled.derivative[1 + row / 3][row % 3][1 + component[c] / 3][component[c] % 3];
      }
    }
  }
  PetscCall(MpmRigidWorkDestroy(&work));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Collective. */
static PetscErrorCode Evaluate(const MpmContacts *contacts, PetscInt b, const PetscReal values[], Balance *balance)
{
  const MpmRigidBody *body = &contacts->facets.bodies[b];
  const PetscInt      n = balance->n, *component = balance->component;
  PetscReal           sums[MOST * (MOST + 1)] = {0.}, load[2][3], derivative[3][3];
  MpmRigidIncrement   q;

  PetscFunctionBeginUser;
  MpmRigidIncrementMake(body, values, &q);
  PetscCall(SumPatches(contacts, b, &q, balance, sums));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, sums, MOST * (MOST + 1), MPIU_REAL, MPIU_SUM, balance->grid->comm));
  MpmRigidLoad(body, &q, load, derivative);
  balance->touches = PETSC_FALSE;
  for (PetscInt k = MOST; k < MOST * (MOST + 1); k++) balance->touches |= (PetscBool)(sums[k] != 0.);
  for (PetscInt i = 0; i < n; i++) {
    balance->contact[i] = sums[i];
    balance->g[i]       = sums[i] + load[component[i] / 3][component[i] % 3];
    for (PetscInt j = 0; j < n; j++) {
      const PetscInt r = component[i] - 3, c = component[j] - 3;

      balance->H[i * n + j] = 0.5 * (sums[MOST + i * MOST + j] + sums[MOST + j * MOST + i]);
      if (r >= 0 && c >= 0) balance->H[i * n + j] += 0.5 * (derivative[r][c] + derivative[c][r]);
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The step of mu: its length, by the eigenvectors' parts of g. */
static PetscReal Length(PetscInt n, const PetscReal value[], const PetscReal part[], PetscReal mu)
{
  PetscReal square = 0.;

  for (PetscInt k = 0; k < n; k++)
    if (part[k] != 0.) square += PetscSqr(part[k] / (value[k] + mu));
  return PetscSqrtReal(square);
}

/* No longer than `most`. */
static PetscErrorCode Step(const Balance *balance, PetscReal most, PetscReal s[])
{
  const PetscInt n = balance->n;
  PetscReal      vectors[MOST * MOST], value[MOST], part[MOST] = {0.}, whole = 0., largest = 0., lower = 0., upper;
  PetscScalar    work[8 * MOST];
  PetscBLASInt   size, length = 8 * MOST, info;

  PetscFunctionBeginUser;
  PetscCall(PetscBLASIntCast(n, &size));
  PetscCall(PetscArraycpy(vectors, balance->H, n * n));
  PetscCallBLAS("LAPACKsyev", LAPACKsyev_("V", "U", &size, vectors, &size, value, work, &length, &info));
  PetscCheck(!info, PETSC_COMM_SELF, PETSC_ERR_LIB, "LAPACK syev failed with %d", (int)info);
  for (PetscInt k = 0; k < n; k++) largest = PetscMax(largest, PetscAbsReal(value[k]));
  for (PetscInt i = 0; i < n; i++) whole += PetscSqr(balance->g[i]);
  for (PetscInt k = 0; k < n; k++) {
    for (PetscInt i = 0; i < n; i++) part[k] += vectors[k * n + i] * balance->g[i];
    if (PetscSqr(part[k]) <= PetscSqr(SOFT) * whole) part[k] = 0.; /* rounding */
    value[k] = PetscMax(PetscAbsReal(value[k]), SOFT * largest);
  }
  upper = PetscSqrtReal(whole) / most; /* no step is longer with this one */
  if (!(Length(n, value, part, 0.) <= most)) {
    for (PetscInt k = 0; k < 100; k++) {
      const PetscReal mu = 0.5 * (lower + upper);

      if (Length(n, value, part, mu) > most) lower = mu;
      else upper = mu;
    }
  } else upper = 0.;
  for (PetscInt i = 0; i < n; i++) {
    s[i] = 0.;
    for (PetscInt k = 0; k < n; k++)
      if (part[k] != 0.) s[i] -= vectors[k * n + i] * part[k] / (value[k] + upper);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscReal Norm(PetscInt n, const PetscReal v[])
{
  PetscReal square = 0.;

  for (PetscInt k = 0; k < n; k++) square += v[k] * v[k];
  return PetscSqrtReal(square);
}

/* m: no body is on its way for longer than this. */
static PetscReal Diagonal(const MpmGrid *grid)
{
  PetscReal side[MPM_MAX_DIM];

  for (PetscInt a = 0; a < grid->dim; a++) side[a] = grid->upper[a] - grid->lower[a];
  return Norm(grid->dim, side);
}

static PetscReal Slope(const Balance *balance, const PetscReal s[])
{
  PetscReal slope = 0.;

  for (PetscInt i = 0; i < balance->n; i++) slope += balance->g[i] * s[i];
  return slope;
}

/*
  Goes along s, or less far where the work done would rise again: its slope is bracketed and halved until it is FLAT
  times the initial one. Leaves the balance at the place found; `part` is the fraction of s.
*/
static PetscErrorCode Search(const MpmContacts *contacts, PetscInt b, Balance *balance, const PetscReal s[],
                             PetscReal values[], PetscReal *part)
{
  const PetscReal start = PetscAbsReal(Slope(balance, s));
  PetscReal       from[MOST], slope, lower = 0., upper = 1.;

  PetscFunctionBeginUser;
  PetscCall(PetscArraycpy(from, values, MOST));
  *part = 1.;
  for (PetscInt it = 0; it < SEARCHES; it++) {
    for (PetscInt i = 0; i < balance->n; i++)
      values[balance->component[i]] = from[balance->component[i]] + *part * s[i];
    PetscCall(Evaluate(contacts, b, values, balance));
    slope = Slope(balance, s);
    if (PetscAbsReal(slope) <= FLAT * start || (it == 0 && slope < 0.)) break;
    if (slope < 0.) lower = *part;
    else upper = *part;
    *part = 0.5 * (lower + upper);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Brings one body to rest from `values`. `moved`: it has left the place about which its contacts were searched, and
  stops there. The body stays where its first step is shorter than `negligible` cells.
*/
static PetscErrorCode Rest(const MpmContacts *contacts, PetscInt b, Balance *balance, PetscReal negligible,
                           PetscReal values[], PetscBool *moved)
{
  const PetscReal cell    = contacts->facets.cell;
  PetscReal       trusted = TRUSTED * cell, from[MOST], gone[MOST], s[MOST], part;

  PetscFunctionBeginUser;
  *moved = PETSC_FALSE;
  ListComponents(&contacts->facets.bodies[b], contacts->facets.bodies[b].spins, balance);
  PetscCall(PetscArraycpy(from, values, MOST));
  PetscCall(Evaluate(contacts, b, values, balance));
  for (PetscInt it = 0; it < ITERATIONS && balance->n && !*moved; it++) { /* n: a hinge that spins has none left */
    PetscCall(Step(balance, trusted, s));
    if (Norm(balance->n, s) < (it ? SETTLED : negligible) * cell) break;
    PetscCall(Search(contacts, b, balance, s, values, &part));
    trusted = PetscMin(part < 1. ? 2. * part * Norm(balance->n, s) : 2. * trusted, TRUSTED * cell);
    for (PetscInt k = 0; k < MOST; k++) gone[k] = values[k] - from[k];
    *moved = (PetscBool)(Norm(MOST, gone) > SEARCH * cell);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  True for a body that turns on and on. Where it slides on small contacts with a material at rest, it may find support
  when it has sunk in. Such a body settles without these rotations, from the start.
*/
static PetscBool Spins(MpmRigidBody *body)
{
  const PetscReal *turn = &body->guess[3], way = Norm(3, body->guess), most = Norm(3, turn);
  const PetscInt   before = body->spins;

  for (PetscInt a = 0; a < 3 && most > way; a++)
    if (PetscAbsReal(turn[a]) > 0.5 * most) body->spins |= 1 << a;
  if (body->spins == before) return PETSC_FALSE;
  for (PetscInt k = 0; k < MOST; k++) body->guess[k] = 0.;
  return PETSC_TRUE;
}

/* Of a body that is adrift. */
static PetscErrorCode DescribeDrift(const MpmContacts *contacts, PetscInt b, size_t length, char text[])
{
  const MpmRigidBody *body = &contacts->facets.bodies[b];
  const char         *name = contacts->facets.boundaries[b].name;
  const PetscReal    *way  = body->guess;
  PetscInt            most = 0;

  PetscFunctionBeginUser;
  for (PetscInt a = 1; a < body->dim; a++)
    if (PetscAbsReal(way[a]) > PetscAbsReal(way[most])) most = a;
  if (way[most] != 0. && PetscAbsReal(way[most]) > 0.5 * Norm(MOST, way))
    PetscCall(PetscSNPrintf(
      text, length, "nothing holds boundary %s against its load along %c: it met no material on its way of %g m", name,
      "xyz"[most], (double)way[most]));
  else {
    PetscInt turns = body->spins ? body->spins : 1;

    most = 0;
    while (!(turns >> most & 1)) most++;
    PetscCall(PetscSNPrintf(text, length,
                            "nothing holds boundary %s against its moment about %c: it turns on and meets no material",
                            name, "xyz"[MpmRotationAxis(body->dim, most)]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmRigidRefuses(const void *ctx, MpmOutcome *outcome)
{
  const MpmContacts *contacts = (const MpmContacts *)ctx;
  char               text[MPM_OUTCOME_TEXT];

  PetscFunctionBeginUser;
  if (contacts->adrift < 0) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(DescribeDrift(contacts, contacts->adrift, sizeof(text), text));
  PetscCall(MpmOutcomeFail(outcome, MPM_OUTCOME_UNCONSTRAINED, "%s", text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmRigidSettle(MpmContacts *contacts, const MpmGrid *grid, PetscBool *moved)
{
  PetscFunctionBeginUser;
  *moved = PETSC_FALSE;
  for (PetscInt b = 0; b < contacts->facets.boundary_count; b++) {
    MpmRigidBody *body    = &contacts->facets.bodies[b];
    Balance       balance = {.grid = grid};
    PetscBool     further = PETSC_FALSE;

    if (!body->freedom || body->dt > 0.) continue;
    PetscCall(Rest(contacts, b, &balance, Norm(MOST, body->guess) > 0. ? SETTLED : NEGLIGIBLE, body->guess, &further));
    if (Norm(MOST, body->guess) > Diagonal(grid) && Spins(body)) further = PETSC_TRUE;
    else if (Norm(MOST, body->guess) > Diagonal(grid) || (body->spins && !further && !balance.touches))
      contacts->adrift = b;
    *moved = (PetscBool)(*moved || further);
  }
  if (contacts->adrift >= 0) *moved = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads a body's unknowns, on all ranks. */
static void Take(const MpmRigidBody *body, PetscInt block, const PetscReal u[], PetscReal values[])
{
  for (PetscInt k = 0; k < MOST; k++) values[k] = 0.;
  for (PetscInt a = 0; a < body->dim; a++) values[a] = u[body->node * block + a];
  for (PetscInt a = 0; a < MpmRotationCount(body->dim); a++) values[3 + a] = u[(body->node + 1) * block + a];
}

/* Load of a body, as a force. */
static PetscReal Push(const MpmRigidBody *body)
{
  return PetscMax(Norm(3, body->load), Norm(3, body->moment) / body->freedom->size);
}

PetscErrorCode MpmRigidRelax(const void *ctx, const MpmSum *sum, const PetscReal u[], PetscBool follows,
                             const PetscScalar last[], PetscScalar x[])
{
  const MpmContacts *contacts = (const MpmContacts *)ctx;
  const PetscInt     bs = sum->block, owner = sum->grid->size - 1;

  PetscFunctionBeginUser;
  for (PetscInt b = 0; b < contacts->facets.boundary_count; b++) {
    const MpmRigidBody *body    = &contacts->facets.bodies[b];
    Balance             balance = {.grid = sum->grid, .sum = sum, .u = u};
    PetscReal           values[MOST], step[MOST] = {0.}, far;
    PetscBool           moved = PETSC_FALSE;

    if (!body->freedom || body->dt > 0.) continue;
    Take(body, bs, u, values);
    if (follows && sum->grid->rank == owner) Take(body, bs, last, step);
    for (PetscInt k = 0; follows && k < MOST; k++) step[k] = values[k] - step[k];
    PetscCallMPI(MPI_Bcast(step, MOST, MPIU_REAL, owner, sum->grid->comm));
    far = Norm(MOST, step) / contacts->facets.cell;
    for (PetscInt k = 0; k < MOST && far > TRUSTED; k++) values[k] -= (1. - TRUSTED / far) * step[k];
    ListComponents(body, body->spins, &balance);
    PetscCall(Evaluate(contacts, b, values, &balance));
    if (follows ? Norm(MOST * MOST, balance.H) == 0. : Norm(balance.n, balance.g) > IMBALANCE * Push(body))
      PetscCall(Rest(contacts, b, &balance, SETTLED, values, &moved));
    if (sum->grid->rank < owner) continue;
    for (PetscInt a = 0; a < body->dim; a++) x[body->node * bs + a] = values[a];
    for (PetscInt a = 0; a < MpmRotationCount(body->dim); a++) x[(body->node + 1) * bs + a] = values[3 + a];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmRigidUnheld(const void *ctx, const MpmSum *sum, const PetscReal u[], MpmOutcome *outcome)
{
  const MpmContacts *contacts = (const MpmContacts *)ctx;
  PetscInt           unheld = -1, component = 0;
  PetscBool          held = PETSC_FALSE;

  PetscFunctionBeginUser;
  for (PetscInt b = 0; b < contacts->facets.boundary_count && unheld < 0; b++) {
    const MpmRigidBody *body    = &contacts->facets.bodies[b];
    Balance             balance = {.grid = sum->grid, .sum = sum, .u = u};
    PetscReal           values[MOST], stiffest = 0., worst = 0., most = 0.;

    if (!body->freedom || body->dt > 0.) continue;
    Take(body, sum->block, u, values);
    ListComponents(body, 0, &balance);
    PetscCall(Evaluate(contacts, b, values, &balance));
    for (PetscInt i = 0; i < balance.n; i++) {
      stiffest = PetscMax(stiffest, PetscAbsReal(balance.H[i * (balance.n + 1)]));
      most     = PetscMax(most, PetscMax(PetscAbsReal(balance.g[i]), PetscAbsReal(balance.contact[i])));
    }
    for (PetscInt i = 0; i < balance.n && balance.touches; i++) {
      const PetscReal off = PetscAbsReal(balance.g[i]), contact = PetscAbsReal(balance.contact[i]);
      const PetscReal load = PetscAbsReal(balance.g[i] - balance.contact[i]);

      if (PetscAbsReal(balance.H[i * (balance.n + 1)]) > FREE * stiffest || off <= UNHELD * PetscMax(load, contact) ||
          off <= ROUNDING * most || off <= worst)
        continue;
      worst     = off;
      unheld    = b;
      component = balance.component[i];
      held      = (PetscBool)(contact > FREE * load);
    }
  }
  if (unheld < 0) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmOutcomeFail(
    outcome, MPM_OUTCOME_UNCONSTRAINED, "its contacts do not hold boundary %s against %s %c (%s)",
    contacts->facets.boundaries[unheld].name, component < 3 ? "translation along" : "rotation about",
    "xyz"[component < 3 ? component : MpmRotationAxis(contacts->facets.boundaries[unheld].dim, component - 3)],
    outcome -> text));
  outcome->retryable = (PetscBool)(outcome->retryable && held);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscBool MpmRigidStray(const void *ctx, const MpmSum *sum, const PetscReal u[])
{
  const MpmContacts *contacts = (const MpmContacts *)ctx;

  for (PetscInt b = 0; b < contacts->facets.boundary_count; b++) {
    PetscReal values[MOST];

    if (!contacts->facets.bodies[b].freedom) continue;
    Take(&contacts->facets.bodies[b], sum->block, u, values);
    for (PetscInt k = 0; k < MOST; k++) values[k] -= contacts->facets.bodies[b].guess[k];
    if (Norm(MOST, values) > STRAY * contacts->facets.cell) return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

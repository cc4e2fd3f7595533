/*
  Initial states: deformation and history with a given stress, for any law.

  With a symmetric dF = I + H the law's Kirchhoff stress tau(H) is brought to its goal by Newton's method, with the
  law's own tangent from dual numbers: as many equations as H has components. A law whose state determines its stress
  (elastic strains as state variables) keeps F = I, so that volume and domain stay those of the body, and tau = sigma.
  Such a law is evaluated in 3D even in plane strain, so that the component across the plane is met too. Any other law
  keeps F = I + H, and tau = J sigma, in plane strain or else in 3D.

  A goal outside the yield surface has no solution: the law then gets the elastic trial strain, and its return moves it.

  A law that has its history from a stress (MpmLawInfo) provides it instead, and is then evaluated at rest.
*/
#include "point/material.h"
#include "point/registry.h"
#include "point/stress_inversion.h"

#define NEWTON_LIMIT 40
#define SYM_MAX      6

/* Rows and columns of the components of a symmetric tensor, in the order xx, yy, zz, xy, yz, xz; 2D: xx, yy, xy. */
static const PetscInt pairs_3d[SYM_MAX][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {1, 2}, {0, 2}};
static const PetscInt pairs_2d[3][2]       = {{0, 0}, {1, 1}, {0, 1}};
static const PetscInt (*const pairs[])[2]  = {[2] = pairs_2d, [3] = pairs_3d};
/* Their places in a stress, which has zz in 2D too */
static const PetscInt places[][SYM_MAX] = {[2] = {0, 1, 3}, [3] = {0, 1, 2, 3, 4, 5}};

/* One evaluation of the law at H: its answer, and its derivatives. */
typedef struct {
  PetscReal tau[SYM_MAX], goal[SYM_MAX];
  PetscReal slope[SYM_MAX][SYM_MAX]; /* d(tau - goal)_i / dH_j */
} Response;

static PetscInt Components(const MpmInitial *initial)
{
  return initial->dim * (initial->dim + 1) / 2;
}

static const PetscInt (*Pairs(const MpmInitial *initial))[2]
{
  return pairs[initial->dim];
}

static MpmKernelPoint Point(const MpmInitial *initial, const PetscReal identity[], const PetscReal state_n[])
{
  return (MpmKernelPoint){.material.parameter = initial->own ? initial->own : initial->material->parameter,
                          .state_n            = state_n,
                          .F_n                = identity,
                          .volume0            = 1.,
                          .dt                 = 1.,
                          .material.traits    = initial->material->info.traits,
                          .material.law       = initial->law,
                          .material.table     = initial->material->table};
}

static void Identity(PetscInt dim, PetscReal F[])
{
  for (PetscInt k = 0; k < dim * dim; k++) F[k] = k % (dim + 1) ? 0. : 1.;
}

/* Where component k of a point's F stands in the F that the law is asked with. */
static PetscInt Place(const MpmInitial *initial, PetscInt k)
{
  const PetscInt dim = initial->model_dim;

  return k == dim * dim ? initial->dim * initial->dim - 1 : k / dim * initial->dim + k % dim;
}

/* The displacement gradient H in full from its components. */
static void Gradient(const MpmInitial *initial, const PetscReal h[], PetscReal H[])
{
  for (PetscInt s = 0; s < Components(initial); s++) {
    const PetscInt *ab = Pairs(initial)[s];

    H[ab[0] * initial->dim + ab[1]] = H[ab[1] * initial->dim + ab[0]] = h[s];
  }
}

/*
  tau = P dF^T (small strain: P itself), goal = J sigma where F carries the stress, and their derivatives. Non-zero
  where the law has no answer.
*/
static int Evaluate(const MpmInitial *initial, const PetscReal state_n[], const PetscReal sigma[], const PetscReal h[],
                    Response *response)
{
  const PetscInt  n = initial->dim, N = n * n, count = Components(initial);
  const PetscBool small = (PetscBool)((initial->material->info.traits & MPM_LAW_SMALL_STRAIN) != 0);
  PetscReal       identity[9], H[9], dF[9] = {0.}, P[9], tangent[81], cofactor[9], J;
  MpmKernelPoint  point;

  Identity(n, identity);
  Gradient(initial, h, H);
  for (PetscInt k = 0; k < N; k++) dF[k] = identity[k] + H[k];
  J = MpmCofactors(N, dF, cofactor);
  if (!(J > 0.)) return 1;
  point = Point(initial, identity, state_n);
  if (initial->kernel.tangent(&point, H, P, tangent)) return 1;
  for (PetscInt s = 0; s < count; s++) {
    const PetscInt a = Pairs(initial)[s][0], b = Pairs(initial)[s][1];

    response->tau[s] = small ? P[a * n + b] : 0.;
    for (PetscInt c = 0; c < n && !small; c++) response->tau[s] += P[a * n + c] * dF[b * n + c];
    response->goal[s] = initial->stateful || small ? sigma[s] : J * sigma[s];
    for (PetscInt t = 0; t < count; t++) {
      const PetscInt k = Pairs(initial)[t][0], l = Pairs(initial)[t][1];
      PetscReal      slope = 0., dJ = 0.;

      for (PetscInt m = 0; m < (k == l ? 1 : 2); m++) { /* H_kl and H_lk grow together */
        const PetscInt i = m ? l : k, j = m ? k : l, column = i * n + j;

        if (small) slope += tangent[(a * n + b) * N + column];
        for (PetscInt c = 0; c < n && !small; c++) slope += tangent[(a * n + c) * N + column] * dF[b * n + c];
        if (!small && i == b) slope += P[a * n + j];
        dJ += cofactor[column];
      }
      response->slope[s][t] = slope - (initial->stateful || small ? 0. : dJ * sigma[s]);
    }
  }
  return 0;
}

/* x = A^-1 b by elimination with pivots; non-zero where A is singular. */
static int SolveSmall(PetscInt n, PetscReal A[SYM_MAX][SYM_MAX], const PetscReal b[], PetscReal x[])
{
  for (PetscInt i = 0; i < n; i++) x[i] = b[i];
  for (PetscInt k = 0; k < n; k++) {
    PetscInt pivot = k;

    for (PetscInt i = k + 1; i < n; i++)
      if (PetscAbsReal(A[i][k]) > PetscAbsReal(A[pivot][k])) pivot = i;
    if (!(PetscAbsReal(A[pivot][k]) > 0.)) return 1;
    for (PetscInt j = 0; j < n; j++) {
      const PetscReal swap = A[k][j];

      A[k][j]     = A[pivot][j];
      A[pivot][j] = swap;
    }
    {
      const PetscReal swap = x[k];

      x[k]     = x[pivot];
      x[pivot] = swap;
    }
    for (PetscInt i = k + 1; i < n; i++) {
      const PetscReal factor = A[i][k] / A[k][k];

      for (PetscInt j = k; j < n; j++) A[i][j] -= factor * A[k][j];
      x[i] -= factor * x[k];
    }
  }
  for (PetscInt i = n - 1; i >= 0; i--) {
    for (PetscInt j = i + 1; j < n; j++) x[i] -= A[i][j] * x[j];
    x[i] /= A[i][i];
  }
  return 0;
}

/*
  h with tau(h) at its goal. Returns 0; or 1 and the elastic trial, that of the initial tangent, where Newton's method
  does not converge.
*/
static int FindGradient(const MpmInitial *initial, const PetscReal state_n[], const PetscReal sigma[], PetscReal h[])
{
  const PetscInt n       = Components(initial);
  PetscReal      largest = 0., elastic[SYM_MAX] = {0.};
  Response       response;

  for (PetscInt s = 0; s < n; s++) {
    largest = PetscMax(largest, PetscAbsReal(sigma[s]));
    h[s]    = 0.;
  }
  for (PetscInt it = 0; it < NEWTON_LIMIT; it++) {
    PetscReal residual[SYM_MAX], step[SYM_MAX], error = 0., longest = 0.;

    if (Evaluate(initial, state_n, sigma, h, &response)) break;
    for (PetscInt s = 0; s < n; s++) {
      residual[s] = response.goal[s] - response.tau[s];
      error       = PetscMax(error, PetscAbsReal(residual[s]));
    }
    if (error <= 1e-13 * largest + 4. * PETSC_MACHINE_EPSILON * initial->material->moduli.stiffness) return 0;
    if (SolveSmall(n, response.slope, residual, step)) break;
    for (PetscInt s = 0; s < n; s++) longest = PetscMax(longest, PetscAbsReal(step[s]));
    for (PetscInt s = 0; s < n; s++) {
      h[s] += step[s] * (longest > 0.3 ? 0.3 / longest : 1.);
      if (!it) elastic[s] = h[s];
    }
    if (longest < 1e-15 && error <= 1e-9 * largest) return 0;
  }
  for (PetscInt s = 0; s < n; s++) h[s] = elastic[s];
  return 1;
}

/* Evaluates the law at h and takes its history, F and Cauchy stress. */
static int Take(const MpmInitial *initial, const PetscReal state_n[], const PetscReal h[], PetscReal state[],
                PetscReal F[], PetscReal sigma[])
{
  PetscReal      identity[9], H[9], flux[9];
  MpmKernelPoint point;

  Identity(initial->dim, identity);
  Gradient(initial, h, H);
  point            = Point(initial, identity, state_n);
  point.end.state  = initial->material->state_size ? state : NULL;
  point.end.F      = F;
  point.end.stress = sigma;
  return initial->kernel.residual(&point, H, flux);
}

/* Copies a history between the plane and space: symmetric tensors have 4 components there and 6 here. */
static void CopyState(const MpmMaterial *material, PetscInt from_dim, PetscInt to_dim, const PetscReal from[],
                      PetscReal to[])
{
  for (size_t v = 0; v < material->info.state_count; v++) {
    const PetscInt n = MpmStateComponents(&material->info.states[v], from_dim),
                   m = MpmStateComponents(&material->info.states[v], to_dim);

    for (PetscInt c = 0; c < m; c++) to[c] = c < n ? from[c] : 0.;
    from += n;
    to += m;
  }
}

/* The law's own history for the stress; non-zero where it has none. 1 in *moved: the yield surface has moved the
   stress. */
static int AskForHistory(const MpmInitial *initial, PetscReal before[], const PetscReal goal[], PetscReal after[],
                         PetscReal reached[], int *moved)
{
  const PetscReal rest[SYM_MAX] = {0.};
  PetscReal       F[9], largest = 0., off = 0.;

  if (initial->history(initial->own ? initial->own : initial->material->parameter, initial->material->table, goal,
                       before))
    return 1;
  if (Take(initial, before, rest, after, F, reached)) return 1;
  for (PetscInt s = 0; s < SYM_MAX; s++) {
    largest = PetscMax(largest, PetscAbsReal(goal[s]));
    off     = PetscMax(off, PetscAbsReal(reached[s] - goal[s]));
  }
  *moved = off > 1e-9 * largest + 64. * PETSC_MACHINE_EPSILON * initial->material->moduli.stiffness;
  return 0;
}

static PetscErrorCode UseDimension(PetscInt dim, MpmInitial *initial)
{
  MpmPhysics physics;
  MpmLawInfo info;
  PetscBool  found;

  PetscFunctionBeginUser;
  PetscCall(MpmPhysicsCreate("solid", &physics, &found));
  initial->dim    = dim;
  initial->kernel = physics.kernels[dim];
  found           = (PetscBool)(found && MpmLawFindAll(initial->material->info.name, dim, initial->law, &info));
  PetscCheck(found, PETSC_COMM_SELF, PETSC_ERR_PLIB, "law %s is not compiled for a solid",
             initial->material->info.name);
  initial->history = info.history;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Tests the law's memory: compressed a little and returned to F = I, a law without history has its first stress. */
static PetscErrorCode FindWhetherItRemembers(MpmInitial *initial)
{
  const PetscReal little = -1e-5, h[SYM_MAX] = {little, little, little, 0., 0., 0.}, rest[SYM_MAX] = {0.};
  PetscReal      *state, *after, *again, F[9], one[SYM_MAX], two[SYM_MAX], J;

  PetscFunctionBeginUser;
  initial->stateful = (PetscBool)(initial->history != NULL);
  if (initial->stateful || !initial->material->state_size) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc3((2 * initial->material->state_size), &state, (2 * initial->material->state_size), &after,
                         (2 * initial->material->state_size), &again));
  MpmMaterialStateAtRest(initial->material, initial->dim, state);
  if (!Take(initial, state, h, after, F, one) && !Take(initial, after, rest, again, F, two)) {
    J                 = (1. + little) * (1. + little) * (1. + little);
    initial->stateful = (PetscBool)(PetscAbsReal(two[0] - J * one[0]) <= 1e-9 * PetscAbsReal(one[0]));
  }
  PetscCall(PetscFree3(state, after, again));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmInitialCreate(const MpmMaterial *material, PetscInt dim, MpmInitial *initial)
{
  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(initial, sizeof(*initial)));
  initial->material  = material;
  initial->model_dim = dim;
  PetscCheck(2 * material->state_size <= MPM_INITIAL_STATE, PETSC_COMM_SELF, PETSC_ERR_SUP,
             "law %s has too many history values for an initial stress", material->info.name);
  PetscCall(UseDimension(3, initial));
  PetscCall(FindWhetherItRemembers(initial));
  if (!initial->stateful && material->kinematics == MPM_PLANE_STRAIN) PetscCall(UseDimension(2, initial));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The part of a stress across the plane that the law does not have by its F. */
static PetscReal Across(const MpmInitial *initial, const PetscReal F[], PetscReal wanted, PetscReal found)
{
  const PetscBool small = (PetscBool)((initial->material->info.traits & MPM_LAW_SMALL_STRAIN) != 0);

  if (initial->dim != 2) return 0.;
  return (wanted - found) * (small ? 1. : MpmDeterminant(4, F));
}

int MpmInitialAcross(const MpmInitial *initial, const PetscReal F[], const PetscReal state[], const PetscReal stress[],
                     PetscReal *across)
{
  const PetscReal still[9] = {0.};
  PetscReal       after[MPM_INITIAL_STATE], F_next[9], reached[SYM_MAX], flux[9];
  MpmKernelPoint  point = Point(initial, F, state);

  *across = 0.;
  if (initial->dim != 2) return 0;
  point.end.state  = initial->material->state_size ? after : NULL;
  point.end.F      = F_next;
  point.end.stress = reached;
  if (initial->kernel.residual(&point, still, flux)) return 1;
  *across = Across(initial, F, stress[2], reached[2]);
  return 0;
}

int MpmInitialReturn(const MpmInitial *initial, const PetscReal F[], const PetscReal state[], PetscReal stress[])
{
  const PetscInt  dim = initial->dim, model_dim = initial->model_dim;
  const PetscReal still[9] = {0.};
  PetscReal       before[MPM_INITIAL_STATE], after[MPM_INITIAL_STATE], full[9], F_next[9], reached[SYM_MAX], flux[9];
  MpmKernelPoint  point;

  for (PetscInt k = 0; k < dim * dim; k++) full[k] = 0.;
  for (PetscInt a = 0; a < dim; a++) full[a * (dim + 1)] = 1.;
  for (PetscInt k = 0; k < MpmKinematicsF(initial->material->kinematics); k++) full[Place(initial, k)] = F[k];
  CopyState(initial->material, model_dim, dim, state, before);
  point            = Point(initial, full, before);
  point.end.state  = initial->material->state_size ? after : NULL;
  point.end.F      = F_next;
  point.end.stress = reached;
  if (initial->kernel.residual(&point, still, flux)) return 1;
  for (PetscInt s = 0; s < MpmSymSize(model_dim); s++) stress[s] = reached[s];
  return 0;
}

int MpmInitialFind(const MpmInitial *initial, const PetscReal state_n[], PetscReal stress[], PetscReal F[],
                   PetscReal state[], PetscReal *across)
{
  const PetscInt dim = initial->model_dim, size = MpmSymSize(dim);
  PetscReal      before[MPM_INITIAL_STATE], after[MPM_INITIAL_STATE], full[9], h[SYM_MAX], goal[SYM_MAX] = {0.},
                                                                                      reached[SYM_MAX];
  int moved;

  for (PetscInt s = 0; s < PetscMin(size, Components(initial)); s++) goal[s] = stress[places[initial->dim][s]];
  CopyState(initial->material, dim, initial->dim, state_n, before);
  if (initial->history) {
    Identity(initial->dim, full);
    if (AskForHistory(initial, before, goal, after, reached, &moved)) return 2;
  } else {
    moved = FindGradient(initial, before, goal, h);
    if (Take(initial, before, h, after, full, reached)) return 2;
  }
  CopyState(initial->material, initial->dim, dim, after, state);
  if (across) {
    *across = Across(initial, full, stress[2], reached[2]);
    if (initial->dim == 2) reached[2] = stress[2];
  }
  for (PetscInt s = 0; s < size; s++)
    stress[s] = reached[s] * (initial->stateful ? MpmDeterminant(initial->dim * initial->dim, full) : 1.);
  for (PetscInt k = 0; k < MpmKinematicsF(initial->material->kinematics); k++) {
    const PetscInt place = Place(initial, k);

    F[k] = initial->stateful ? (place % (initial->dim + 1) ? 0. : 1.) : full[place];
  }
  return moved;
}

/* ---- derivatives ---- */

#define CHANGE 4e-2 /* of what a history is differenced by, relative; then half of it, a quarter, an eighth */
#define LEVELS 4

/* The length by which a direction is followed in differences: a part of the value that it changes the most. */
static PetscReal Length(const MpmInitial *initial, const PetscReal goal[], const MpmInitialDirection *direction)
{
  const MpmLawInfo *info      = &initial->material->info;
  const double     *parameter = initial->own ? initial->own : initial->material->parameter;
  PetscReal         most = 0., largest = 0., change = 0.;

  for (size_t k = 0; direction->parameter && k < info->parameter_count; k++) {
    const PetscReal size = parameter[k] != 0.            ? PetscAbsReal(parameter[k])
                           : info->parameters[k].typical ? PetscAbsReal(info->parameters[k].typical)
                                                         : 1.;

    most = PetscMax(most, PetscAbsReal(direction->parameter[k]) / size);
  }
  for (PetscInt s = 0; direction->stress && s < SYM_MAX; s++) {
    largest = PetscMax(largest, PetscAbsReal(goal[s]));
    if (s < MpmSymSize(initial->model_dim)) change = PetscMax(change, PetscAbsReal(direction->stress[s]));
  }
  if (change > 0. && largest > 0.) most = PetscMax(most, change / largest);
  return most > 0. ? CHANGE / most : 0.;
}

/* The history of parameters and stress moved along a direction by so much. */
static int MovedHistory(const MpmInitial *initial, const PetscReal before[], const PetscReal goal[],
                        const MpmInitialDirection *direction, PetscReal length, PetscReal state[])
{
  const MpmMaterial *material  = initial->material;
  const double      *parameter = initial->own ? initial->own : material->parameter;
  double             moved[MPM_INITIAL_STATE];
  PetscReal          stress[SYM_MAX];

  if (material->info.parameter_count > MPM_INITIAL_STATE) return 1;
  for (size_t k = 0; k < material->info.parameter_count; k++)
    moved[k] = parameter[k] + (direction->parameter ? length * direction->parameter[k] : 0.);
  for (PetscInt s = 0; s < SYM_MAX; s++) stress[s] = goal[s];
  for (PetscInt s = 0; direction->stress && s < MpmSymSize(initial->model_dim); s++)
    stress[s] += length * direction->stress[s];
  for (PetscInt k = 0; k < MPM_INITIAL_STATE; k++) state[k] = before[k];
  return initial->history(moved, material->table, stress, state);
}

/*
  The change of a law's own history: central differences at lengths L, L/2, L/4, L/8, of which Richardson's
  extrapolation leaves an error of the eighth order.
*/
static int HistoryAlong(const MpmInitial *initial, const PetscReal before[], const PetscReal goal[],
                        const MpmInitialDirection *direction, PetscReal change[])
{
  PetscReal table[LEVELS][MPM_INITIAL_STATE], above[MPM_INITIAL_STATE], below[MPM_INITIAL_STATE];
  PetscReal length = Length(initial, goal, direction);

  for (PetscInt k = 0; k < MPM_INITIAL_STATE; k++) change[k] = 0.;
  if (!(length > 0.)) return 0;
  for (PetscInt level = 0; level < LEVELS; level++, length *= 0.5) {
    if (MovedHistory(initial, before, goal, direction, length, above)) return 1;
    if (MovedHistory(initial, before, goal, direction, -length, below)) return 1;
    for (PetscInt k = 0; k < MPM_INITIAL_STATE; k++) table[level][k] = (above[k] - below[k]) / (2. * length);
  }
  for (PetscInt order = 1; order < LEVELS; order++) {
    const PetscReal power = PetscPowRealInt(4., (int)order);

    for (PetscInt level = LEVELS - 1; level >= order; level--)
      for (PetscInt k = 0; k < MPM_INITIAL_STATE; k++)
        table[level][k] = (power * table[level][k] - table[level - 1][k]) / (power - 1.);
  }
  for (PetscInt k = 0; k < MPM_INITIAL_STATE; k++) change[k] = table[LEVELS - 1][k];
  return 0;
}

/* The law's answer at h, and its change along parameters, the history at the start, and h. */
typedef struct {
  PetscReal F[2][9], state[2][MPM_INITIAL_STATE], sigma[2][SYM_MAX];
} Change;

static int TakeAlong(const MpmInitial *initial, const PetscReal before[], const PetscReal h[], const PetscReal dh[],
                     const MpmKernelDirection *along, Change *change)
{
  MpmKernelDirection direction = *along;
  MpmKernelEnd       derivative;
  MpmKernelPoint     point;
  PetscReal          identity[9], H[9], dH[9], flux[9], dflux[9];

  Identity(initial->dim, identity);
  Gradient(initial, h, H);
  Gradient(initial, dh, dH);
  direction.input  = dH;
  point            = Point(initial, identity, before);
  point.end        = (MpmKernelEnd){.F = change->F[0], .stress = change->sigma[0]};
  derivative       = (MpmKernelEnd){.F = change->F[1], .stress = change->sigma[1]};
  point.end.state  = initial->material->state_size ? change->state[0] : NULL;
  derivative.state = initial->material->state_size ? change->state[1] : NULL;
  return initial->kernel.sensitivity(&point, H, &direction, flux, dflux, &derivative);
}

/* dh that keeps the stress at its goal, given the changes of both at h; the law's answer then moves along it. */
static int Follow(const MpmInitial *initial, const PetscReal before[], const PetscReal goal[], const PetscReal dgoal[],
                  const PetscReal h[], const MpmKernelDirection *along, Change *change)
{
  const PetscBool small         = (PetscBool)((initial->material->info.traits & MPM_LAW_SMALL_STRAIN) != 0);
  const PetscReal none[SYM_MAX] = {0.};
  PetscReal       dh[SYM_MAX], rate[SYM_MAX], J;
  Response        response;

  if (TakeAlong(initial, before, h, none, along, change) || Evaluate(initial, before, goal, h, &response)) return 1;
  J = small ? 1. : MpmDeterminant(initial->dim * initial->dim, change->F[0]);
  for (PetscInt s = 0; s < Components(initial); s++)
    rate[s] = (initial->stateful ? 1. : J) * dgoal[s] - J * change->sigma[1][places[initial->dim][s]];
  if (SolveSmall(Components(initial), response.slope, rate, dh)) return 1;
  return TakeAlong(initial, before, h, dh, along, change);
}

int MpmInitialAlong(const MpmInitial *initial, const PetscReal state_n[], const PetscReal stress[],
                    const MpmInitialDirection *direction, PetscReal dF[], PetscReal dstate[], PetscReal dstress[])
{
  const PetscInt dim = initial->model_dim, size = MpmSymSize(dim), N = initial->dim * initial->dim;
  PetscReal      before[MPM_INITIAL_STATE] = {0.}, slope[MPM_INITIAL_STATE], h[SYM_MAX] = {0.}, goal[SYM_MAX] = {0.},
            dgoal[SYM_MAX] = {0.}, cofactor[9], J = 1., dJ = 0.;
  MpmKernelDirection along  = {.parameter = direction->parameter};
  Change             change = {0};

  for (PetscInt s = 0; s < PetscMin(size, Components(initial)); s++) {
    goal[s] = stress[places[initial->dim][s]];
    if (direction->stress) dgoal[s] = direction->stress[places[initial->dim][s]];
  }
  CopyState(initial->material, dim, initial->dim, state_n, before);
  if (initial->history) {
    if (HistoryAlong(initial, before, goal, direction, slope)) return 1;
    if (initial->history(initial->own ? initial->own : initial->material->parameter, initial->material->table, goal,
                         before))
      return 1;
    along.state_n = slope;
    if (TakeAlong(initial, before, h, h, &along, &change)) return 1;
  } else if (FindGradient(initial, before, goal, h) || Follow(initial, before, goal, dgoal, h, &along, &change))
    return 1;
  CopyState(initial->material, initial->dim, dim, change.state[1], dstate);
  if (initial->stateful) {
    J = MpmCofactors(N, change.F[0], cofactor);
    for (PetscInt k = 0; k < N; k++) dJ += cofactor[k] * change.F[1][k];
  }
  for (PetscInt s = 0; s < size; s++) dstress[s] = J * change.sigma[1][s] + dJ * change.sigma[0][s];
  for (PetscInt k = 0; k < MpmKinematicsF(initial->material->kinematics); k++)
    dF[k] = initial->stateful ? 0. : change.F[1][Place(initial, k)];
  return 0;
}

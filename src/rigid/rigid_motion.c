/*
  Motion of a rigid body, and the action of its contacts.

  A body's place is its prescribed motion P, followed by a placement x -> c + d + Q (x - c) about its reference point c.
  The step's unknowns are t, added to d, and Rodrigues' parameters r (w = 2 r L, L the body's size; |w| is about the
  angle times L), which multiply Q by

    R = I + s ([r] + [r]^2) ,  s = 2/(1 + r.r) ,   dR R^T = [dphi] ,  dphi = s (dr + r x dr)

  from the left: the quaternion (1, r) made of length 1, without a trigonometric function. [r] is the matrix of r x.

  In the body's frame, a contact is one with a boundary of prescribed motion. With Y the arm of its face from the
  reference point at the step's start, and v = u - dc - t its motion relative to that point (dc: the prescribed one's),

    u' = dc + Q^T (R^T v + (R^T - I) Y)

  is the displacement that the law of contact gets; its force f' and stiffness K' = -df'/du' turn back to f = R Q f' and
  K = R Q K' (R Q)^T. The force f acts on the material at the arm y = Y + v, and -f on the body, so that

    dxi = du - dt - dphi x y ,   df = dphi x f - K dxi ,
    residuals:  -f at the nodes,  f for t,  T^T (y x f) for w ,   T^T m = s (m - r x m)/(2 L) .

  Where one of three rotations is fixed, its moment would get into the rows of the other two by r x m: there, s m/(2 L)
  is balanced.
*/
#include "base/rows.h"
#include "rigid/rigid_motion.h"

static void Cross(const PetscReal a[3], const PetscReal b[3], PetscReal c[3])
{
  c[0] = a[1] * b[2] - a[2] * b[1];
  c[1] = a[2] * b[0] - a[0] * b[2];
  c[2] = a[0] * b[1] - a[1] * b[0];
}

static PetscReal Dot(const PetscReal a[3], const PetscReal b[3])
{
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* c = A b, or A^T b */
static void Times(PetscReal A[3][3], PetscBool transposed, const PetscReal b[3], PetscReal c[3])
{
  PetscReal result[3];

  for (PetscInt i = 0; i < 3; i++)
    result[i] = transposed ? A[0][i] * b[0] + A[1][i] * b[1] + A[2][i] * b[2] : Dot(A[i], b);
  for (PetscInt i = 0; i < 3; i++) c[i] = result[i];
}

void MpmRigidRotation(const PetscReal turn[4], PetscReal Q[3][3])
{
  const PetscReal w = turn[0], x = turn[1], y = turn[2], z = turn[3];

  Q[0][0] = 1. - 2. * (y * y + z * z);
  Q[1][1] = 1. - 2. * (x * x + z * z);
  Q[2][2] = 1. - 2. * (x * x + y * y);
  Q[0][1] = 2. * (x * y - w * z);
  Q[1][0] = 2. * (x * y + w * z);
  Q[0][2] = 2. * (x * z + w * y);
  Q[2][0] = 2. * (x * z - w * y);
  Q[1][2] = 2. * (y * z - w * x);
  Q[2][1] = 2. * (y * z + w * x);
}

/* ---- increments ---- */

void MpmRigidIncrementMake(const MpmRigidBody *body, const PetscReal values[6], MpmRigidIncrement *q)
{
  const PetscReal size = 2. * body->freedom->size;
  PetscReal       S[3][3], square;

  *q = (MpmRigidIncrement){.scale = 0.};
  for (PetscInt a = 0; a < body->dim; a++) q->shift[a] = values[a];
  for (PetscInt k = 0; k < MpmRotationCount(body->dim); k++) q->r[MpmRotationAxis(body->dim, k)] = values[3 + k] / size;
  square   = Dot(q->r, q->r);
  q->scale = 2. / (1. + square);
  S[0][0] = S[1][1] = S[2][2] = 0.;
  S[0][1]                     = -(S[1][0] = q->r[2]);
  S[2][0]                     = -(S[0][2] = q->r[1]);
  S[1][2]                     = -(S[2][1] = q->r[0]);
  for (PetscInt a = 0; a < 3; a++)
    for (PetscInt c = 0; c < 3; c++)
      q->R[a][c] = (a == c ? 1. - q->scale * square : 0.) + q->scale * (S[a][c] + q->r[a] * q->r[c]);
}

void MpmRigidIncrementAt(const MpmRigidBody *body, PetscInt block, const PetscReal u[], MpmRigidIncrement *q)
{
  const PetscReal *at        = &u[body->node * block];
  PetscReal        values[6] = {0.};

  for (PetscInt a = 0; a < body->dim; a++) values[a] = at[a];
  for (PetscInt a = 0; a < MpmRotationCount(body->dim); a++) values[3 + a] = at[block + a];
  MpmRigidIncrementMake(body, values, q);
}

void MpmRigidMove(const MpmRigidIncrement *q, MpmPlacement *placement)
{
  const PetscReal *p = placement->turn, *r = q->r;
  PetscReal        across[3], turn[4], norm = 0.;

  for (PetscInt a = 0; a < 3; a++) placement->shift[a] += q->shift[a];
  Cross(r, &p[1], across);
  turn[0] = p[0] - Dot(r, &p[1]);
  for (PetscInt a = 0; a < 3; a++) turn[1 + a] = p[1 + a] + p[0] * r[a] + across[a];
  for (PetscInt k = 0; k < 4; k++) norm += turn[k] * turn[k];
  for (PetscInt k = 0; k < 4; k++) placement->turn[k] = turn[k] / PetscSqrtReal(norm);
}

void MpmRigidCarry(const MpmBoundary *boundary, const MpmPose *pose, const MpmPlacement *placement, PetscReal x[])
{
  const MpmPose rest = {.turned = PETSC_FALSE};
  PetscReal     reference[MPM_MAX_DIM], arm[3] = {0., 0., 0.}, Q[3][3];

  MpmPoseCarry(boundary->dim, &rest, pose, x, x);
  if (!boundary->freedom) return;
  MpmBoundaryReference(boundary, pose, reference);
  MpmRigidRotation(placement->turn, Q);
  for (PetscInt a = 0; a < boundary->dim; a++) arm[a] = x[a] - reference[a];
  Times(Q, PETSC_FALSE, arm, arm);
  for (PetscInt a = 0; a < boundary->dim; a++) x[a] = reference[a] + placement->shift[a] + arm[a];
}

void MpmBoundaryMiddle(const MpmBoundary *boundary, const MpmPose *pose, const MpmPlacement *placement,
                       PetscReal place[])
{
  MpmSolidMiddle(&boundary->solid, place);
  MpmRigidCarry(boundary, pose, placement, place);
}

/* ---- between the axes and the body ---- */

void MpmRigidDistance(const MpmRigidBody *body, const MpmBoundary *boundary, const MpmPose *pose, const PetscReal x[],
                      MpmSurface *surface)
{
  PetscReal Q[3][3], from[3] = {0., 0., 0.}, second[3][3];

  for (PetscInt a = 0; a < 3; a++)
    for (PetscInt c = 0; c < 3; c++) Q[a][c] = body->Q[a][c];
  for (PetscInt a = 0; a < body->dim; a++) from[a] = x[a] - body->pivot[a] - body->placement->shift[a];
  Times(Q, PETSC_TRUE, from, from);
  for (PetscInt a = 0; a < 3; a++) from[a] += body->pivot[a];
  MpmBoundaryDistance(boundary, pose, from, surface);
  Times(Q, PETSC_FALSE, surface->normal, surface->normal);
  for (PetscInt a = 0; a < 3; a++) Times(Q, PETSC_FALSE, surface->second[a], second[a]); /* second Q^T */
  for (PetscInt c = 0; c < 3; c++) {
    PetscReal column[3] = {second[0][c], second[1][c], second[2][c]};

    Times(Q, PETSC_FALSE, column, column);
    for (PetscInt a = 0; a < 3; a++) surface->second[a][c] = column[a];
  }
}

void MpmRigidPull(const MpmRigidBody *body, MpmFacet *facet)
{
  PetscReal Q[3][3], arm[3] = {0., 0., 0.};

  for (PetscInt a = 0; a < 3; a++)
    for (PetscInt c = 0; c < 3; c++) Q[a][c] = body->Q[a][c];
  for (PetscInt a = 0; a < body->dim; a++) arm[a] = facet->place[a] - body->pivot[a] - body->placement->shift[a];
  Times(Q, PETSC_TRUE, arm, arm);
  for (PetscInt a = 0; a < body->dim; a++) facet->place[a] = body->pivot[a] + arm[a];
  Times(Q, PETSC_TRUE, facet->normal, facet->normal);
}

void MpmRigidArm(const MpmRigidBody *body, const MpmFacet *facet, PetscReal arm[3])
{
  PetscReal from[3] = {0., 0., 0.};

  for (PetscInt a = 0; a < body->dim; a++) from[a] = facet->place[a] - body->pivot[a];
  for (PetscInt a = 0; a < 3; a++) arm[a] = Dot(body->Q[a], from);
}

void MpmRigidPullVector(const MpmRigidBody *body, PetscReal vector[3])
{
  PetscReal from[3] = {vector[0], vector[1], body->dim > 2 ? vector[2] : 0.};

  for (PetscInt a = 0; a < body->dim; a++)
    vector[a] = body->Q[0][a] * from[0] + body->Q[1][a] * from[1] + body->Q[2][a] * from[2];
}

void MpmRigidPush(const MpmRigidBody *body, const MpmFacet *facet, PetscReal place[])
{
  PetscReal arm[3];

  MpmRigidArm(body, facet, arm);
  for (PetscInt a = 0; a < body->dim; a++) place[a] = body->pivot[a] + body->placement->shift[a] + arm[a];
}

void MpmRigidSee(const MpmRigidBody *body, const MpmFacet *facet, const MpmRigidIncrement *q, const PetscReal u[],
                 PetscReal seen[])
{
  PetscReal arm[3], motion[3] = {0., 0., 0.}, along, across[3], twice[3], turned[3];

  MpmRigidArm(body, facet, arm);
  for (PetscInt a = 0; a < body->dim; a++) motion[a] = u[a] - body->travel[a] - q->shift[a];
  Cross(q->r, arm, across);
  Cross(q->r, across, twice);
  for (PetscInt a = 0; a < 3; a++) {
    along = q->R[0][a] * motion[0] + q->R[1][a] * motion[1] + q->R[2][a] * motion[2];

    turned[a] = along + q->scale * (twice[a] - across[a]);
  }
  for (PetscInt a = 0; a < body->dim; a++)
    seen[a] = body->travel[a] + body->Q[0][a] * turned[0] + body->Q[1][a] * turned[1] + body->Q[2][a] * turned[2];
}

void MpmRigidAxes(const MpmRigidBody *body, const MpmRigidIncrement *q, PetscReal A[3][3])
{
  for (PetscInt a = 0; a < 3; a++)
    for (PetscInt c = 0; c < 3; c++)
      A[a][c] = q->R[a][0] * body->Q[0][c] + q->R[a][1] * body->Q[1][c] + q->R[a][2] * body->Q[2][c];
}

void MpmRigidTurn(const MpmRigidBody *body, const MpmRigidIncrement *q, MpmFacetLaw *answer)
{
  PetscReal A[3][3], half[3][3]; /* R Q */

  MpmRigidAxes(body, q, A);
  Times(A, PETSC_FALSE, answer->force, answer->force);
  for (PetscInt a = 0; a < 3; a++) Times(A, PETSC_FALSE, answer->stiffness[a], half[a]); /* K' A^T */
  for (PetscInt c = 0; c < 3; c++) {
    PetscReal column[3] = {half[0][c], half[1][c], half[2][c]};

    Times(A, PETSC_FALSE, column, column);
    for (PetscInt a = 0; a < 3; a++) answer->stiffness[a][c] = column[a];
  }
}

/* ---- forces ---- */

PetscBool MpmFreedomTurnsInPart(const MpmFreedom *freedom)
{
  PetscInt rotations = 0;

  for (PetscInt a = 0; a < 3; a++) rotations += freedom->free[1] >> a & 1;
  return (PetscBool)(rotations == 2);
}

/* T^T m; with `rows`, the balanced moment. */
static void Conjugate(const MpmRigidBody *body, const MpmRigidIncrement *q, const PetscReal m[3], PetscBool rows,
                      PetscReal result[3])
{
  PetscReal across[3] = {0., 0., 0.};

  if (!rows || !MpmFreedomTurnsInPart(body->freedom)) Cross(q->r, m, across);
  for (PetscInt a = 0; a < 3; a++) result[a] = q->scale * (m[a] - across[a]) / (2. * body->freedom->size);
}

/* d(T^T m) of the balanced moment, for dr and dm */
static void ConjugateChange(const MpmRigidBody *body, const MpmRigidIncrement *q, const PetscReal m[3],
                            const PetscReal dr[3], const PetscReal dm[3], PetscReal result[3])
{
  const PetscReal change    = -q->scale * Dot(q->r, dr); /* ds / s */
  PetscReal       across[3] = {0., 0., 0.};

  Conjugate(body, q, m, PETSC_TRUE, result);
  for (PetscInt a = 0; a < 3; a++) result[a] *= change;
  if (!MpmFreedomTurnsInPart(body->freedom)) Cross(dr, m, across);
  for (PetscInt a = 0; a < 3; a++) result[a] -= q->scale * across[a] / (2. * body->freedom->size);
  Conjugate(body, q, dm, PETSC_TRUE, across);
  for (PetscInt a = 0; a < 3; a++) result[a] += across[a];
}

/* Derivatives by unit directions: component c of the nodes, the translation or the rotation. */
static void Direction(const MpmRigidBody *body, const MpmRigidIncrement *q, const PetscReal y[3],
                      const MpmFacetLaw *answer, PetscInt by, PetscInt c, MpmRigidAnswer *coupled)
{
  PetscReal du[3] = {0., 0., 0.}, dr[3] = {0., 0., 0.}, dphi[3], xi[3], df[3], m[3], dm[3], more[3], dw[3];

  if (by == 0) du[c] = 1.;
  if (by == 1) du[c] = -1.; /* of u - t */
  if (by == 2) dr[MpmRotationAxis(body->dim, c)] = 0.5 / body->freedom->size;
  Cross(q->r, dr, dphi);
  for (PetscInt a = 0; a < 3; a++) dphi[a] = q->scale * (dr[a] + dphi[a]);
  Cross(dphi, y, xi);
  for (PetscInt a = 0; a < 3; a++) xi[a] = du[a] - xi[a];
  Cross(dphi, answer->force, df);
  for (PetscInt a = 0; a < 3; a++) df[a] -= Dot(answer->stiffness[a], xi);
  Cross(y, answer->force, m);
  Cross(du, answer->force, dm);
  Cross(y, df, more);
  for (PetscInt a = 0; a < 3; a++) dm[a] += more[a];
  ConjugateChange(body, q, m, dr, dm, dw);
  for (PetscInt a = 0; a < body->dim; a++) {
    coupled->derivative[0][a][by][c] = -df[a];
    coupled->derivative[1][a][by][c] = df[a];
  }
  for (PetscInt a = 0; a < MpmRotationCount(body->dim); a++)
    coupled->derivative[2][a][by][c] = dw[MpmRotationAxis(body->dim, a)];
}

void MpmRigidArmAfter(const MpmRigidBody *body, const MpmFacet *facet, const MpmRigidIncrement *q, const PetscReal u[],
                      PetscReal y[3])
{
  MpmRigidArm(body, facet, y);
  for (PetscInt a = 0; a < body->dim; a++) y[a] += u[a] - body->travel[a] - q->shift[a];
}

void MpmRigidCouple(const MpmRigidBody *body, const MpmFacet *facet, const MpmRigidIncrement *q, const PetscReal u[],
                    const MpmFacetLaw *answer, PetscBool derivative, MpmRigidAnswer *coupled)
{
  PetscReal y[3], m[3], w[3];

  MpmRigidArmAfter(body, facet, q, u, y);
  Cross(y, answer->force, m);
  Conjugate(body, q, m, PETSC_TRUE, w);
  for (PetscInt a = 0; a < 3; a++) {
    coupled->residual[0][a] = -answer->force[a];
    coupled->residual[1][a] = answer->force[a];
    coupled->residual[2][a] = a < MpmRotationCount(body->dim) ? w[MpmRotationAxis(body->dim, a)] : 0.;
  }
  for (PetscInt by = 0; by < 3 && derivative; by++)
    for (PetscInt c = 0; c < (by < 2 ? body->dim : MpmRotationCount(body->dim)); c++)
      Direction(body, q, y, answer, by, c, coupled);
}

void MpmRigidLoad(const MpmRigidBody *body, const MpmRigidIncrement *q, PetscReal residual[2][3],
                  PetscReal derivative[3][3])
{
  const PetscReal none[3] = {0., 0., 0.};
  PetscReal       w[3];

  Conjugate(body, q, body->moment, PETSC_TRUE, w);
  for (PetscInt a = 0; a < 3; a++) {
    residual[0][a] = -body->load[a];
    residual[1][a] = a < MpmRotationCount(body->dim) ? -w[MpmRotationAxis(body->dim, a)] : 0.;
  }
  for (PetscInt c = 0; c < MpmRotationCount(body->dim); c++) {
    PetscReal dr[3] = {0., 0., 0.};

    dr[MpmRotationAxis(body->dim, c)] = 0.5 / body->freedom->size;
    ConjugateChange(body, q, body->moment, dr, none, w);
    for (PetscInt a = 0; a < MpmRotationCount(body->dim); a++) derivative[a][c] = -w[MpmRotationAxis(body->dim, a)];
  }
}

void MpmRigidCovector(const MpmRigidBody *body, const MpmRigidIncrement *q, const PetscReal y[3], const PetscReal c[3],
                      PetscBool rows, PetscReal by[2][3])
{
  PetscReal across[3], w[3];

  Cross(y, c, across);
  Conjugate(body, q, across, rows, w);
  for (PetscInt a = 0; a < 3; a++) {
    by[0][a] = -c[a];
    by[1][a] = a < MpmRotationCount(body->dim) ? -w[MpmRotationAxis(body->dim, a)] : 0.;
  }
}

void MpmRigidMode(const MpmRigidBody *body, const PetscReal origin[], const PetscReal along[3], const PetscReal turn[3],
                  PetscReal mode[2][3])
{
  PetscReal arm[3] = {0., 0., 0.};

  for (PetscInt a = 0; a < body->dim; a++) arm[a] = body->pivot[a] + body->placement->shift[a] - origin[a];
  Cross(turn, arm, mode[0]);
  for (PetscInt a = 0; a < 3; a++) mode[0][a] += along[a];
  for (PetscInt a = 0; a < 3; a++)
    mode[1][a] = a < MpmRotationCount(body->dim) ? body->freedom->size * turn[MpmRotationAxis(body->dim, a)] : 0.;
}

PetscErrorCode MpmRigidAddRows(const MpmBoundaries *boundaries, MpmPlacement placements[], MpmRows *rows)
{
  PetscFunctionBeginUser;
  for (PetscInt b = 0; b < boundaries->count; b++) {
    MpmPlacement *place = &placements[b];
    const MpmRow  row[] = {
       {"", MPM_ROW_REAL, MPM_ROW_STATE, place->shift, 3, 0},
       {"", MPM_ROW_REAL, MPM_ROW_STATE, place->turn, 4, 3},
       {"", MPM_ROW_REAL, MPM_ROW_STATE, place->last, 6, 7},
       {"", MPM_ROW_REAL, MPM_ROW_STATE, place->velocity, 6, 13},
       {"", MPM_ROW_REAL, MPM_ROW_STATE, place->acceleration, 6, 19},
    };
    char *head = NULL;

    if (!boundaries->at[b].freedom) continue;
    PetscCall(MpmTextAppend(&head, "place_%s", boundaries->names[b]));
    PetscCall(MpmRowsAdd(rows, head, PETSC_STATIC_ARRAY_LENGTH(row), row));
    PetscCall(PetscFree(head));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

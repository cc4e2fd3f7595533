/*
  Derivatives of a point's basis functions.

  Weights are products of lines by axis, w_x w_y w_z, and gradients have one line of derivatives g in place of w. By the
  place on an axis its line w becomes dw/dx, and g the bend dg/dx; by the half-length both become their own derivatives.
  dw/dx = g unless, with axial symmetry, g along the radius is an average by volume (grid/shape_radial.c).

  The half-length on axis a is l_a U_aa/h_a, U = sqrt(F^T F), unless a wall, an edge of the grid or the longest domain
  clips it.
*/
#include "grid/grid.h"
#include "space/point_loop.h"
#include "space/point_slopes.h"

PetscErrorCode MpmPointSlopesCreate(const MpmSpace *space, MpmPointSlopes *slopes)
{
  const PetscInt size = space->dim * space->width;

  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(slopes, sizeof(*slopes)));
  slopes->space = space;
  slopes->width = space->width;
  PetscCall(PetscMalloc3(size, &slopes->bend, size, &slopes->weight, size, &slopes->gradient));
  PetscCall(PetscMalloc3(size, &slopes->by_place, size, &slopes->mean[0], size, &slopes->mean[1]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPointSlopesDestroy(MpmPointSlopes *slopes)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree3(slopes->bend, slopes->weight, slopes->gradient));
  PetscCall(PetscFree3(slopes->by_place, slopes->mean[0], slopes->mean[1]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* d U_aa / d F in the plane, where U = (C + J I)/t, t = tr U = sqrt(tr C + 2 J), J = det F */
static void PlaneSlopes(const PetscReal F[], const PetscReal cofactor[], PetscReal J, PetscReal by_F[][MPM_F_MAX])
{
  const PetscReal square = F[0] * F[0] + F[1] * F[1] + F[2] * F[2] + F[3] * F[3] + 2. * J, t = PetscSqrtReal(square);

  for (PetscInt a = 0; a < 2; a++) {
    const PetscReal U = (F[a] * F[a] + F[2 + a] * F[2 + a] + J) / t;

    for (PetscInt k = 0; k < 4; k++)
      by_F[a][k] = ((k % 2 == a ? 2. * F[k] : 0.) + cofactor[k]) / t - U * (F[k] + cofactor[k]) / square;
  }
}

/* The rotation R of F = R U by Newton's method X <- (X + X^{-T})/2. */
static void Rotation(const PetscReal F[], PetscReal R[])
{
  PetscReal change = 1.;

  for (PetscInt k = 0; k < 9; k++) R[k] = F[k];
  for (PetscInt iteration = 0; iteration < 50 && change > 4. * PETSC_MACHINE_EPSILON; iteration++) {
    PetscReal       cofactor[9];
    const PetscReal J = MpmCofactors(9, R, cofactor);

    change = 0.;
    for (PetscInt k = 0; k < 9; k++) {
      const PetscReal step = 0.5 * (cofactor[k] / J - R[k]);

      change = PetscMax(change, PetscAbsReal(step));
      R[k] += step;
    }
  }
}

/*
  d U_aa / d F in space. With R^T dF = A and R^T dR = [w]x, a skew matrix, dU = A - [w]x U is symmetric where

    (tr U I - U) w = alpha ,   alpha_i = -e_ijk A_jk .

  Then dU_aa = B : A, B_jk = delta_ja delta_ka - e_ijk y_i, with (tr U I - U) y = h, h_c = e_abc U_ab.
*/
static void SpaceSlopes(const PetscReal F[], PetscReal by_F[][MPM_F_MAX])
{
  PetscReal R[9], U[9], G[9], cofactor[9], J;

  Rotation(F, R);
  for (PetscInt k = 0; k < 9; k++)
    U[k] = R[k / 3] * F[k % 3] + R[3 + k / 3] * F[3 + k % 3] + R[6 + k / 3] * F[6 + k % 3];
  for (PetscInt k = 0; k < 9; k++) G[k] = (k % 4 ? 0. : U[0] + U[4] + U[8]) - U[k];
  J = MpmCofactors(9, G, cofactor);
  for (PetscInt a = 0; a < 3; a++) {
    const PetscInt b = (a + 1) % 3, c = (a + 2) % 3; /* e_abc = 1 */
    PetscReal      B[9] = {0.}, y[3];

    for (PetscInt i = 0; i < 3; i++)
      y[i] = (cofactor[3 * i + c] * U[3 * a + b] - cofactor[3 * i + b] * U[3 * a + c]) / J;
    B[4 * a] = 1.;
    for (PetscInt i = 0; i < 3; i++) {
      const PetscInt j = (i + 1) % 3, k = (i + 2) % 3;

      B[3 * j + k] -= y[i];
      B[3 * k + j] += y[i];
    }
    for (PetscInt k = 0; k < 9; k++) {
      const PetscInt m = k / 3, l = k % 3;

      by_F[a][k] = R[3 * m] * B[l] + R[3 * m + 1] * B[3 + l] + R[3 * m + 2] * B[6 + l];
    }
  }
}

/* by_F[a] = d U_aa / d F */
static PetscErrorCode StretchSlopes(PetscInt dim, const PetscReal F[], PetscReal by_F[][MPM_F_MAX])
{
  PetscReal       cofactor[MPM_F_MAX];
  const PetscReal J = MpmCofactors(dim * dim, F, cofactor);

  PetscFunctionBeginUser;
  PetscCheck(J > 0., PETSC_COMM_SELF, PETSC_ERR_FP, "a point has no stretch");
  for (PetscInt a = 0; a < dim; a++)
    for (PetscInt k = 0; k < MPM_F_MAX; k++) by_F[a][k] = 0.;
  if (dim == 2) PlaneSlopes(F, cofactor, J, by_F);
  else SpaceSlopes(F, by_F);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Derivatives of the half-lengths by F, before they are clipped. */
static PetscErrorCode StretchedSlopes(const MpmRules *rules, const MpmPoints *points, PetscInt p,
                                      MpmPointSlopes *slopes)
{
  const PetscInt dim = rules->grid->dim;

  PetscFunctionBeginUser;
  PetscCall(StretchSlopes(dim, MpmPointF(points, p), slopes->stretch_by_F));
  for (PetscInt a = 0; a < dim; a++) {
    slopes->stretched[a] = 0.;
    for (PetscInt k = 0; k < dim * dim; k++) {
      slopes->stretch_by_F[a][k] *= points->domain.half_length[p * dim + a] / rules->grid->h[a];
      slopes->stretched[a] += slopes->stretch_by_F[a][k] * MpmPointF(points, p)[k]; /* U(cF) = cU(F) */
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Derivatives of the half-lengths as they are. */
static void LengthSlopes(const MpmRules *rules, const MpmPoints *points, PetscInt p, const PetscInt lower[],
                         const PetscInt upper[], MpmPointSlopes *slopes)
{
  const MpmGrid   *grid = rules->grid;
  const PetscInt   dim  = grid->dim;
  const PetscReal *half = &slopes->space->shapes.half[p * dim];

  for (PetscInt a = 0; a < dim; a++) {
    const PetscReal xi    = (points->x[p * dim + a] - grid->lower[a]) / grid->h[a];
    const PetscReal below = xi - (PetscReal)lower[a], above = (PetscReal)upper[a] - xi;
    const PetscBool clipped = (PetscBool)(half[a] >= PetscMin(below, above));
    const PetscBool longest = (PetscBool)(rules->longest > 0. && half[a] >= rules->longest);

    slopes->length_by_place[a] = clipped ? (below < above ? 1. : -1.) / grid->h[a] : 0.;
    for (PetscInt k = 0; k < MPM_F_MAX; k++)
      slopes->length_by_F[a][k] = clipped || longest ? 0. : slopes->stretch_by_F[a][k];
    slopes->length_by_start[a] = clipped || longest ? 0. : slopes->stretched[a];
  }
}

/* A point on the axis itself keeps the radius that it is given. */
static void FindHoop(const MpmPoints *points, PetscInt p, MpmPointSlopes *slopes)
{
  const MpmSpace *space = slopes->space;
  const PetscReal hoop  = space->shapes.at[0].hoop ? space->shapes.at[0].hoop[p] : 0.;

  slopes->hoop[0] = hoop;
  slopes->hoop[1] = hoop * points->x[p * space->dim] < 0.5 ? 0. : -hoop * hoop;
}

PetscErrorCode MpmPointSlopesFind(const MpmRules *rules, const MpmPoints *points, const MpmGroup *group, PetscInt point,
                                  MpmPointSlopes *slopes)
{
  const MpmSpace *space = slopes->space;
  const MpmGrid  *grid  = rules->grid;
  const PetscInt  dim = space->dim, W = space->width;
  PetscInt        lower[MPM_MAX_DIM], upper[MPM_MAX_DIM], first[MPM_MAX_DIM];

  PetscFunctionBeginUser;
  slopes->point  = point;
  slopes->domain = (PetscBool)(space->shapes.half != NULL);
  FindHoop(points, point, slopes);
  MpmSpaceEdges(rules, &points->x[point * dim], lower, upper);
  MpmSpaceGroupAt(space, group, first);
  for (PetscInt a = 0; a < dim; a++) {
    const PetscInt     line = (point * dim + a) * W, to = a * W;
    PetscReal          gradient[MPM_MAX_WIDTH];
    const MpmShapeLine here = {
      .first = first[a], .count = group->count[a], .weight = &space->shapes.at[0].weight[line], .gradient = gradient};
    const MpmShapePlace  at = {(points->x[point * dim + a] - grid->lower[a]) / grid->h[a],
                              slopes->domain ? space->shapes.half[point * dim + a] : 0., lower[a], upper[a]};
    const MpmShapeSlopes by = {&slopes->bend[to], &slopes->weight[to], &slopes->gradient[to]};

    const MpmRadialPlace round  = {at.xi, at.half_length, points->x[point * dim + a] / grid->h[a], lower[a], upper[a]};
    const PetscBool      radial = (PetscBool)(grid->axial && !a);

    for (PetscInt i = 0; i < group->count[a]; i++) gradient[i] = space->shapes.at[0].gradient[line + i] * grid->h[a];
    if (radial) MpmShapeAverageByLength(rules->shape, rules->edge, &round, &here);
    MpmShapeDifferentiate(rules->shape, rules->edge, &at, &here, &by);
    if (radial) MpmShapeVolumeSlopes(rules->shape, rules->edge, &round, &here, &by);
    if (space->shapes.at[0].mean)
      MpmShapeMeanSlopes(rules->shape, rules->edge, &at, &here, &slopes->mean[0][to], &slopes->mean[1][to]);
    for (PetscInt i = 0; i < group->count[a]; i++) {
      slopes->by_place[to + i] = gradient[i] / grid->h[a];
      if (space->shapes.at[0].mean) slopes->mean[0][to + i] /= grid->h[a];
      by.bend[i] /= grid->h[a] * grid->h[a];
      by.gradient_by_length[i] /= grid->h[a];
    }
  }
  if (points->domain.half_length) PetscCall(StretchedSlopes(rules, points, point, slopes));
  if (slopes->domain) LengthSlopes(rules, points, point, lower, upper, slopes);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Derivatives of the weights over the radius, from those of the weights; 0 without axial symmetry. */
static void HoopSlopes(const MpmPointSlopes *slopes, const MpmGroup *group, MpmSlopeKind kind, PetscInt axis,
                       const MpmBasis *basis)
{
  const MpmSpace *space = slopes->space;
  const MpmLines  w     = MpmPointLines(space->dim, space, space->shapes.at[0].weight, slopes->point, &MpmLineOne);
  PetscReal      *hoop = basis->basis[MPM_HOOP_BASIS], by = kind == MPM_BY_PLACE && !axis ? slopes->hoop[1] : 0.;
  PetscInt        n = 0;

  for (PetscInt j = 0; j < group->count[1]; j++)
    for (PetscInt k = 0; k < group->count[0]; k++, n++)
      hoop[n] = slopes->hoop[0] * basis->basis[0][n] + by * w.along[0][k] * w.along[1][j];
}

void MpmPointSlopesMeans(const MpmPointSlopes *slopes, const MpmGroup *group, MpmSlopeKind kind, PetscInt axis,
                         PetscReal means[])
{
  const MpmSpace *space = slopes->space;
  MpmLines        m     = MpmPointLines(space->dim, space, space->shapes.at[0].mean, slopes->point, &MpmLineOne);

  m.along[axis] = &slopes->mean[kind][axis * slopes->width];
  for (PetscInt l = 0; l < group->count[2]; l++)
    for (PetscInt j = 0; j < group->count[1]; j++)
      for (PetscInt k = 0; k < group->count[0]; k++) *means++ = m.along[0][k] * m.along[1][j] * m.along[2][l];
}

void MpmPointSlopesBasis(const MpmPointSlopes *slopes, const MpmGroup *group, MpmSlopeKind kind, PetscInt axis,
                         const MpmBasis *basis)
{
  const MpmSpace *space = slopes->space;
  const PetscInt  dim = space->dim, W = slopes->width;
  MpmLines        w = MpmPointLines(dim, space, space->shapes.at[0].weight, slopes->point, &MpmLineOne);
  MpmLines        g = MpmPointLines(dim, space, space->shapes.at[0].gradient, slopes->point, &MpmLineZero);
  PetscInt        n = 0;

  w.along[axis] = kind == MPM_BY_PLACE ? &slopes->by_place[axis * W] : &slopes->weight[axis * W];
  g.along[axis] = kind == MPM_BY_PLACE ? &slopes->bend[axis * W] : &slopes->gradient[axis * W];
  for (PetscInt l = 0; l < group->count[2]; l++) {
    for (PetscInt j = 0; j < group->count[1]; j++) {
      for (PetscInt k = 0; k < group->count[0]; k++, n++) {
        const PetscReal *const *x = w.along, *const *d = g.along;

        basis->basis[0][n] = x[0][k] * x[1][j] * x[2][l];
        basis->basis[1][n] = d[0][k] * x[1][j] * x[2][l];
        basis->basis[2][n] = x[0][k] * d[1][j] * x[2][l];
        if (dim == MPM_MAX_DIM) basis->basis[3][n] = x[0][k] * x[1][j] * d[2][l];
      }
    }
  }
  if (dim < MPM_MAX_DIM) HoopSlopes(slopes, group, kind, axis, basis);
  if (!space->shapes.at[0].mean) return;
  MpmPointSlopesMeans(slopes, group, kind, axis, basis->basis[MPM_DEVIATION(dim)]);
  for (n = 0; n < group->node_count; n++)
    basis->basis[MPM_DEVIATION(dim)][n] = basis->basis[0][n] - basis->basis[MPM_DEVIATION(dim)][n];
}

/* The sum of HoopSlopes() times `sums`. */
static PetscReal SumHoop(const MpmPointSlopes *slopes, const MpmGroup *group, MpmSlopeKind kind, PetscInt axis,
                         const PetscReal sums[])
{
  const MpmSpace *space = slopes->space;
  const PetscInt  W     = slopes->width;
  const MpmLines  w     = MpmPointLines(space->dim, space, space->shapes.at[0].weight, slopes->point, &MpmLineOne);
  const PetscReal by = kind == MPM_BY_PLACE && !axis ? slopes->hoop[1] : 0., *const of = kind == MPM_BY_PLACE
                                                                                           ? slopes->by_place
                                                                                           : slopes->weight;
  PetscReal total = 0.;

  for (PetscInt j = 0; j < group->count[1]; j++) {
    for (PetscInt k = 0; k < group->count[0]; k++) {
      const PetscReal x = axis ? w.along[0][k] : of[k], y = axis ? of[W + j] : w.along[1][j];

      total += (slopes->hoop[0] * x * y + by * w.along[0][k] * w.along[1][j]) * *sums++;
    }
  }
  return total;
}

PetscReal MpmPointSlopesSum(const MpmPointSlopes *slopes, const MpmGroup *group, MpmSlopeKind kind, PetscInt axis,
                            PetscReal *const sums[])
{
  const MpmSpace *space = slopes->space;
  const PetscInt  dim = space->dim, W = slopes->width;
  MpmLines        w     = MpmPointLines(dim, space, space->shapes.at[0].weight, slopes->point, &MpmLineOne);
  MpmLines        g     = MpmPointLines(dim, space, space->shapes.at[0].gradient, slopes->point, &MpmLineZero);
  PetscReal       total = slopes->hoop[0] ? SumHoop(slopes, group, kind, axis, sums[MPM_HOOP_BASIS]) : 0.;
  PetscInt        n     = 0;

  w.along[axis] = kind == MPM_BY_PLACE ? &slopes->by_place[axis * W] : &slopes->weight[axis * W];
  g.along[axis] = kind == MPM_BY_PLACE ? &slopes->bend[axis * W] : &slopes->gradient[axis * W];
  for (PetscInt l = 0; l < group->count[2]; l++) {
    for (PetscInt j = 0; j < group->count[1]; j++) {
      const PetscReal yz = w.along[1][j] * w.along[2][l], dyz = g.along[1][j] * w.along[2][l],
                      ydz = w.along[1][j] * g.along[2][l];
      const PetscReal *x = w.along[0], *d = g.along[0];

      for (PetscInt k = 0; k < group->count[0]; k++, n++) {
        PetscReal across = yz * sums[0][n] + dyz * sums[2][n];

        if (dim == MPM_MAX_DIM) across += ydz * sums[3][n];
        total += x[k] * across + d[k] * yz * sums[1][n];
      }
    }
  }
  return total;
}

PetscReal MpmPointSlopesWeight(const MpmPointSlopes *slopes, PetscInt axis, PetscInt i, MpmSlopeKind kind)
{
  const PetscInt W = slopes->width;

  return kind == MPM_BY_PLACE ? slopes->by_place[axis * W + i] : slopes->weight[axis * W + i];
}

void MpmPointSlopesAlong(const MpmPointSlopes *slopes, PetscInt F_size, const PetscReal dx[], const PetscReal dF[],
                         const PetscReal start[], PetscReal half[])
{
  for (PetscInt a = 0; a < slopes->space->dim; a++) {
    half[a] = slopes->domain ? slopes->length_by_place[a] * dx[a] : 0.;
    if (slopes->domain && start) half[a] += slopes->length_by_start[a] * start[a];
    for (PetscInt k = 0; slopes->domain && k < F_size; k++) half[a] += slopes->length_by_F[a][k] * dF[k];
  }
}

void MpmPointSlopesPull(const MpmPointSlopes *slopes, PetscInt F_size, const PetscReal half[], PetscReal x[],
                        PetscReal F[], PetscReal start[])
{
  for (PetscInt a = 0; slopes->domain && a < slopes->space->dim; a++) {
    x[a] += slopes->length_by_place[a] * half[a];
    if (start) start[a] += slopes->length_by_start[a] * half[a];
    for (PetscInt k = 0; k < F_size; k++) F[k] += slopes->length_by_F[a][k] * half[a];
  }
}

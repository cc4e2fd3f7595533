/*
  Tractions and normal stresses on surfaces of bodies.

  A face with the area a at the step's start (surface_faces.c) has a' = cof(dF) a at its end, dF = I + sum_j u_j (x)
  grad w_j that of its point, so that the next step starts from the very area a'. With the ramp's factor f it exerts

    normal s:    f s a' ,        traction t:   f t |a'| ,      open water, at a drained face below its level:   -p a'

  on the nodes by the face's weights. Loads follow the material, so none has a potential in general and the tangent,

    -w_i d force/d dF : (. (x) grad w_j) ,    d cof(F)_ij/dF_kl = e_ikn e_jlq F_nq ,

  is not symmetric.
*/
#include "space/point_shape.h"
#include "space/space.h"
#include "space/sum.h"
#include "assembly/sparsity.h"
#include "assembly/terms.h"
#include "loads/body_surface.h"

/* The basis functions of a face's point, and the force on the face with its derivative by dF. */
typedef struct {
  MpmBasis  basis;
  PetscReal gradient[3][3];                 /* dF - I */
  PetscReal force[3], by_gradient[3][3][3]; /* d force[i]/d dF[k][l] */
} Force;

/*
  gradient[c][d] = sum_i u_i,c grad_d w_i at the face's point, whose basis functions are written to `work`; and with
  axial symmetry, in [2][2], the hoop strain of the face.
*/
static void Gradient(const MpmSurfaceFaces *faces, const MpmSurfaceFace *face, const MpmSum *sum, const PetscReal u[],
                     Force *work, PetscReal gradient[3][3])
{
  const MpmGroup *group = &sum->space->groups[face->group];
  const PetscInt *nodes = &sum->space->group_nodes[group->node_offset];

  MpmSpaceEvaluate(sum->space, group, face->point, &work->basis);
  MpmBasisGradient(&work->basis, group, sum, u, gradient);
  for (PetscInt i = 0; MpmSpaceIsAxial(sum->space) && i < group->node_count; i++)
    gradient[2][2] += faces->list.weight[face->weight + i] / face->place[0] * u[nodes[i] * sum->block];
}

/* e_ijk */
static inline PetscReal Permutation(PetscInt i, PetscInt j, PetscInt k)
{
  return 0.5 * (PetscReal)((i - j) * (j - k) * (k - i));
}

/* area[i] = cof(F)_ij a_j and its derivative by F; in plane strain F_33 = 1. */
static void Area(const PetscReal gradient[3][3], const PetscReal a[3], PetscReal area[3], PetscReal by[3][3][3])
{
  PetscReal F[3][3], along[3][3]; /* along[l][q] = e_jlq a_j */

  for (PetscInt l = 0; l < 3; l++) {
    for (PetscInt q = 0; q < 3; q++) {
      F[l][q]     = gradient[l][q] + (l == q ? 1. : 0.);
      along[l][q] = 0.;
      for (PetscInt j = 0; j < 3; j++) along[l][q] += Permutation(j, l, q) * a[j];
    }
  }
  for (PetscInt i = 0; i < 3; i++) {
    area[i] = 0.;
    for (PetscInt kl = 0; kl < 9; kl++) {
      const PetscInt k = kl / 3, l = kl % 3;

      by[i][k][l] = 0.;
      for (PetscInt nq = 0; nq < 9; nq++)
        by[i][k][l] += Permutation(i, k, nq / 3) * along[l][nq % 3] * F[nq / 3][nq % 3];
      area[i] += 0.5 * by[i][k][l] * F[k][l]; /* quadratic in F */
    }
  }
}

/* The stress along the face's outward normal. */
static PetscReal Normal(const MpmSurfaceFaces *faces, const MpmSurfaceFace *face)
{
  return faces->factor[face->surface] * faces->surfaces->at[face->surface].normal - face->water;
}

/* The force that acts on the face at the displacement u. */
static void Evaluate(const MpmSurfaceFaces *faces, const MpmSurfaceFace *face, const MpmSum *sum, const PetscReal u[],
                     Force *work)
{
  const MpmBodySurface *surface = &faces->surfaces->at[face->surface];
  const PetscReal       factor  = faces->factor[face->surface];
  const PetscReal       normal  = Normal(faces, face);
  PetscReal             area[3], by[3][3][3], size = 0.;

  Gradient(faces, face, sum, u, work, work->gradient);
  Area(work->gradient, face->area, area, by);
  for (PetscInt a = 0; a < 3; a++) size += PetscSqr(area[a]);
  size = PetscSqrtReal(size);
  for (PetscInt i = 0; i < 3; i++) {
    work->force[i] = normal * area[i] + factor * surface->traction[i] * size;
    for (PetscInt kl = 0; kl < 9; kl++) {
      const PetscInt k = kl / 3, l = kl % 3;
      PetscReal      value = normal * by[i][k][l];

      for (PetscInt m = 0; size > 0. && surface->traction[i] != 0. && m < 3; m++)
        value += factor * surface->traction[i] * area[m] / size * by[m][k][l];
      work->by_gradient[i][k][l] = value;
    }
  }
}

/* ---- inner areas of points at cut edges ---- */

static PetscBool HasInner(const MpmSurfaceFace *face)
{
  return (PetscBool)(face->inner >= 0);
}

/*
  The stress behind a face: s I of a normal stress s; of a traction t, with the normal n as the step starts,

    t (x) n + n (x) t - (t . n) n (x) n
*/
static void StressBehind(const MpmSurfaceFaces *faces, const MpmSurfaceFace *face, PetscInt dim, PetscReal stress[3][3])
{
  const PetscReal *t = faces->surfaces->at[face->surface].traction, factor = faces->factor[face->surface],
                  normal = Normal(faces, face);
  PetscReal n[3] = {0., 0., 0.}, square = 0., along = 0.;

  for (PetscInt a = 0; a < dim; a++) square += PetscSqr(face->area[a]);
  for (PetscInt a = 0; a < dim && square > 0.; a++) n[a] = face->area[a] / PetscSqrtReal(square);
  for (PetscInt a = 0; a < dim; a++) along += t[a] * n[a];
  for (PetscInt i = 0; i < 3; i++)
    for (PetscInt j = 0; j < 3; j++)
      stress[i][j] = (i == j ? normal : 0.) + factor * (t[i] * n[j] + n[i] * t[j] - along * n[i] * n[j]);
}

/* The force on node i, in work->force, behind Evaluate() of the face. */
static void EvaluateInner(const MpmSurfaceFaces *faces, const MpmSurfaceFace *face, PetscInt dim, PetscInt i,
                          Force *work)
{
  PetscReal stress[3][3], area[3], by[3][3][3], at[3] = {0., 0., 0.};

  StressBehind(faces, face, dim, stress);
  for (PetscInt a = 0; a < dim; a++) at[a] = faces->list.weight[face->inner + i * dim + a];
  Area(work->gradient, at, area, by);
  for (PetscInt c = 0; c < 3; c++) {
    work->force[c] = 0.;
    for (PetscInt d = 0; d < 3; d++) work->force[c] += stress[c][d] * area[d];
    for (PetscInt kl = 0; kl < 9; kl++) {
      PetscReal sum = 0.;

      for (PetscInt d = 0; d < 3; d++) sum += stress[c][d] * by[d][kl / 3][kl % 3];
      work->by_gradient[c][kl / 3][kl % 3] = sum;
    }
  }
}

/* The residual behind Evaluate(), or its change by a change of dF. */
static void AddInner(const MpmSurfaceFaces *faces, const MpmSurfaceFace *face, const MpmSum *sum,
                     const PetscReal change[3][3], Force *work, PetscReal y[])
{
  const MpmGroup *group = &sum->space->groups[face->group];
  const PetscInt *nodes = &sum->space->group_nodes[group->node_offset];

  for (PetscInt i = 0; i < group->node_count; i++) {
    EvaluateInner(faces, face, sum->space->dim, i, work);
    for (PetscInt c = 0; c < sum->space->dim; c++) {
      PetscReal force = change ? 0. : work->force[c];

      for (PetscInt kl = 0; change && kl < 9; kl++)
        force += work->by_gradient[c][kl / 3][kl % 3] * change[kl / 3][kl % 3];
      y[nodes[i] * sum->block + c] -= force;
    }
  }
}

/* ---- the term ---- */

/* True where the face has a load. */
static PetscBool IsLoaded(const MpmSurfaceFaces *faces, const MpmSurfaceFace *face)
{
  return (PetscBool)((faces->surfaces->at[face->surface].loaded && faces->factor[face->surface] != 0.) ||
                     face->water != 0.);
}

/* y_i += -w_i force */
static void AddForce(const MpmSurfaceFaces *faces, const MpmSurfaceFace *face, const MpmSum *sum,
                     const PetscReal force[], PetscReal y[])
{
  MpmWeightsAdd(&faces->list.weight[face->weight], &sum->space->groups[face->group], sum, -1., force, y);
}

static PetscErrorCode Residual(const void *ctx, const MpmSum *sum, const PetscReal u[], PetscReal residual[],
                               PetscInt *failed)
{
  const MpmSurfaceFaces *faces = (const MpmSurfaceFaces *)ctx;
  Force                  work;

  PetscFunctionBeginUser;
  (void)failed;
  if (!faces->list.count) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmBasisCreate(sum->space, &work.basis));
  for (PetscInt k = 0; k < faces->list.count; k++) {
    if (!IsLoaded(faces, &faces->list.at[k])) continue;
    Evaluate(faces, &faces->list.at[k], sum, u, &work);
    AddForce(faces, &faces->list.at[k], sum, work.force, residual);
    if (HasInner(&faces->list.at[k])) AddInner(faces, &faces->list.at[k], sum, NULL, &work, residual);
  }
  PetscCall(MpmBasisDestroy(&work.basis));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Apply(const void *ctx, const MpmSum *sum, const PetscReal u[], const PetscReal du[],
                            PetscReal y[])
{
  const MpmSurfaceFaces *faces = (const MpmSurfaceFaces *)ctx;
  Force                  work;

  PetscFunctionBeginUser;
  if (!faces->list.count) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmBasisCreate(sum->space, &work.basis));
  for (PetscInt f = 0; f < faces->list.count; f++) {
    PetscReal change[3][3], force[3];

    if (!IsLoaded(faces, &faces->list.at[f])) continue;
    Evaluate(faces, &faces->list.at[f], sum, u, &work);
    Gradient(faces, &faces->list.at[f], sum, du, &work, change);
    for (PetscInt i = 0; i < 3; i++) {
      force[i] = 0.;
      for (PetscInt kl = 0; kl < 9; kl++) force[i] += work.by_gradient[i][kl / 3][kl % 3] * change[kl / 3][kl % 3];
    }
    AddForce(faces, &faces->list.at[f], sum, force, y);
    if (HasInner(&faces->list.at[f])) AddInner(faces, &faces->list.at[f], sum, (const PetscReal(*)[3])change, &work, y);
  }
  PetscCall(MpmBasisDestroy(&work.basis));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The tangent's entry for a force c of the weight `own`, node j and displacement d. */
static PetscReal Entry(const MpmSurfaceFaces *faces, const MpmSurfaceFace *face, const MpmSum *sum, const Force *work,
                       PetscReal own, PetscInt cd, PetscInt j)
{
  const PetscInt   dim = sum->space->dim, c = cd / dim, d = cd % dim;
  const PetscReal *weight = &faces->list.weight[face->weight];
  PetscReal        value  = MpmBasisSlope(&work->basis, dim, j, work->by_gradient[c][d]);

  if (MpmSpaceIsAxial(sum->space) && !d) value += work->by_gradient[c][2][2] * weight[j] / face->place[0];
  return -own * value;
}

static PetscErrorCode Diagonal(const void *ctx, const MpmSum *sum, const PetscReal u[], PetscReal blocks[],
                               PetscInt *failed)
{
  const MpmSurfaceFaces *faces = (const MpmSurfaceFaces *)ctx;
  const PetscInt         dim = sum->space->dim, bs = sum->block;
  Force                  work;

  PetscFunctionBeginUser;
  (void)failed;
  if (!faces->list.count) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmBasisCreate(sum->space, &work.basis));
  for (PetscInt f = 0; f < faces->list.count; f++) {
    const MpmSurfaceFace *face  = &faces->list.at[f];
    const MpmGroup       *group = &sum->space->groups[face->group];
    const PetscInt       *nodes = &sum->space->group_nodes[group->node_offset];

    if (!IsLoaded(faces, face)) continue;
    Evaluate(faces, face, sum, u, &work);
    for (PetscInt i = 0; i < group->node_count; i++)
      for (PetscInt cd = 0; cd < dim * dim; cd++)
        blocks[(nodes[i] * bs + cd / dim) * bs + cd % dim] +=
          Entry(faces, face, sum, &work, faces->list.weight[face->weight + i], cd, i);
    for (PetscInt i = 0; i < group->node_count && HasInner(face); i++) {
      EvaluateInner(faces, face, dim, i, &work);
      for (PetscInt cd = 0; cd < dim * dim; cd++)
        blocks[(nodes[i] * bs + cd / dim) * bs + cd % dim] += Entry(faces, face, sum, &work, 1., cd, i);
    }
  }
  PetscCall(MpmBasisDestroy(&work.basis));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Tangent(const void *ctx, const MpmSum *sum, const PetscReal u[], MpmPattern *pattern,
                              PetscReal residual[], PetscInt *failed)
{
  const MpmSurfaceFaces *faces = (const MpmSurfaceFaces *)ctx;
  const PetscInt         dim = sum->space->dim, bs = sum->block, most = PetscPowInt(sum->space->width, dim);
  PetscReal             *element;
  Force                  work;

  PetscFunctionBeginUser;
  if (!faces->list.count) PetscFunctionReturn(PETSC_SUCCESS);
  if (residual) PetscCall(Residual(ctx, sum, u, residual, failed));
  PetscCall(MpmBasisCreate(sum->space, &work.basis));
  PetscCall(PetscMalloc1((most * most * bs * bs), &element));
  for (PetscInt f = 0; f < faces->list.count; f++) {
    const MpmSurfaceFace *face  = &faces->list.at[f];
    const MpmGroup       *group = &sum->space->groups[face->group];
    const PetscInt        n     = group->node_count;

    if (!IsLoaded(faces, face)) continue;
    Evaluate(faces, face, sum, u, &work);
    PetscCall(PetscArrayzero(element, n * n * bs * bs));
    for (PetscInt i = 0; i < n; i++)
      for (PetscInt cd = 0; cd < dim * dim; cd++)
        for (PetscInt j = 0; j < n; j++)
          element[((i * bs + cd / dim) * bs + cd % dim) * n + j] =
            Entry(faces, face, sum, &work, faces->list.weight[face->weight + i], cd, j);
    for (PetscInt i = 0; i < n && HasInner(face); i++) {
      EvaluateInner(faces, face, dim, i, &work);
      for (PetscInt cd = 0; cd < dim * dim; cd++)
        for (PetscInt j = 0; j < n; j++)
          element[((i * bs + cd / dim) * bs + cd % dim) * n + j] += Entry(faces, face, sum, &work, 1., cd, j);
    }
    MpmPatternAddBlock(pattern, sum->space, group, element);
  }
  PetscCall(PetscFree(element));
  PetscCall(MpmBasisDestroy(&work.basis));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* By the mean factor of the step, in u, of the forces at `at`. */
static PetscErrorCode Work(const void *ctx, const MpmSum *sum, const PetscReal at[], const PetscReal u[],
                           MpmTermWork *account)
{
  const PetscInt  dim = sum->space->dim, bs = sum->block, local = sum->space->local;
  MpmSurfaceFaces mean   = *(const MpmSurfaceFaces *)ctx;
  PetscInt        failed = 0;
  PetscReal      *force;

  PetscFunctionBeginUser;
  mean.factor = mean.mean;
  PetscCall(PetscCalloc1((local * bs), &force));
  PetscCall(Residual(&mean, sum, at, force, &failed));
  for (PetscInt k = 0; k < local * bs; k++)
    if (k % bs < dim) account->external -= force[k] * u[k];
  PetscCall(PetscFree(force));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscBool Idle(const void *ctx)
{
  return (PetscBool) !((const MpmSurfaceFaces *)ctx)->list.count;
}

const MpmTerm MpmTermSurfaces = {.name        = "surfaces of bodies",
                                 .energy.work = Work,
                                 .idle        = Idle,
                                 .boxes       = MpmSurfaceFacesFind,
                                 .residual    = Residual,
                                 .tangent     = Tangent,
                                 .apply       = Apply,
                                 .diagonal    = Diagonal};

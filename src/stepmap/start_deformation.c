/*
  Derivatives of a point of a solid by the deformation gradient at the step's start, in closed form.
*/
#include "particles/points.h"
#include "space/point_slopes.h"
#include "space/space.h"
#include "point/layout.h"
#include "point/material.h"
#include "stepmap/start_deformation.h"

/* A matrix of the plane or of space; with axial symmetry the hoop's component follows that of the plane. */
typedef struct {
  PetscInt dim, size;
} Kind;

static Kind KindOf(const MpmSum *sum)
{
  return (Kind){sum->space->dim, sum->points->F_size};
}

static PetscBool IsNormal(Kind kind, PetscInt k)
{
  return (PetscBool)(k >= kind.dim * kind.dim || k % (kind.dim + 1) == 0);
}

/* C = A^T B, or A B^T */
static void Multiply(Kind kind, PetscBool first, const PetscReal A[], const PetscReal B[], PetscReal C[])
{
  const PetscInt d = kind.dim;

  for (PetscInt i = 0; i < d; i++) {
    for (PetscInt j = 0; j < d; j++) {
      C[i * d + j] = 0.;
      for (PetscInt k = 0; k < d; k++)
        C[i * d + j] += first ? A[k * d + i] * B[k * d + j] : A[i * d + k] * B[j * d + k];
    }
  }
  for (PetscInt k = d * d; k < kind.size; k++) C[k] = A[k] * B[k];
}

static void Invert(Kind kind, const PetscReal F[], PetscReal inverse[])
{
  PetscReal       cofactor[MPM_F_MAX];
  const PetscReal J = MpmCofactors(kind.size, F, cofactor);
  const PetscInt  d = kind.dim;

  for (PetscInt i = 0; i < d; i++)
    for (PetscInt j = 0; j < d; j++) inverse[i * d + j] = cofactor[j * d + i] / J;
  for (PetscInt k = d * d; k < kind.size; k++) inverse[k] = cofactor[k] / J;
}

static PetscReal Dot(PetscInt count, const PetscReal a[], const PetscReal b[])
{
  PetscReal sum = 0.;

  for (PetscInt k = 0; k < count; k++) sum += a[k] * b[k];
  return sum;
}

MpmStartKind MpmStartKindOf(const MpmSum *sum, PetscInt material)
{
  const MpmMaterial *of     = &sum->materials[material];
  const MpmLayout   *layout = sum->layout;
  const unsigned     traits = of->info.traits;

  if (layout->rate.count || sum->kept.own || traits & MPM_LAW_SMALL_STRAIN) return MPM_START_COMPONENTS;
  if (layout->kernel->inputs != sum->points->F_size + (layout->means ? 1 : 0)) return MPM_START_COMPONENTS;
  if (traits & MPM_LAW_VOLUME) return MPM_START_VOLUME;
  return of->state_size || traits & MPM_LAW_VISCOUS || layout->means ? MPM_START_COMPONENTS : MPM_START_ELASTIC;
}

void MpmStartPullElastic(const MpmSum *sum, PetscInt p, const PetscReal input[], const PetscReal flux[],
                         const PetscReal by_input[], const PetscReal K[], PetscReal by_F[])
{
  const Kind kind          = KindOf(sum);
  PetscReal  dF[MPM_F_MAX] = {0.}, one[MPM_F_MAX], other[MPM_F_MAX], inverse[MPM_F_MAX];

  for (PetscInt k = 0; k < kind.size; k++) dF[k] = input[k] + (IsNormal(kind, k) ? 1. : 0.);
  Invert(kind, MpmPointF(sum->points, p), inverse);
  Multiply(kind, PETSC_TRUE, dF, by_input, one);
  Multiply(kind, PETSC_TRUE, K, flux, other);
  for (PetscInt k = 0; k < kind.size; k++) one[k] -= other[k];
  Multiply(kind, PETSC_FALSE, one, inverse, other);
  for (PetscInt k = 0; k < kind.size; k++) by_F[k] += other[k];
}

void MpmStartPullVolume(const MpmSum *sum, PetscInt p, PetscReal along, const PetscReal F[], const PetscReal bars[],
                        PetscReal by_F[])
{
  const Kind      kind = KindOf(sum);
  const PetscInt  n    = kind.size == 4 ? 2 : 3;
  const PetscReal c    = (along - Dot(kind.size, bars, F)) / (PetscReal)n;
  PetscReal       one[MPM_F_MAX], other[MPM_F_MAX], inverse[MPM_F_MAX];

  Invert(kind, MpmPointF(sum->points, p), inverse);
  Multiply(kind, PETSC_TRUE, F, bars, one);
  for (PetscInt k = 0; k < kind.size; k++)
    if (IsNormal(kind, k)) one[k] += c;
  Multiply(kind, PETSC_TRUE, inverse, one, other);
  for (PetscInt k = 0; k < kind.size; k++) by_F[k] += other[k];
}

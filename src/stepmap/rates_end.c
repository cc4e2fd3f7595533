/*
  The step's end of a field with a rate at a point.
*/
#include "point/layout.h"
#include "space/sum.h"
#include "talus/point/dense.h"
#include "stepmap/rates_end.h"

/* dF^{-T}, and g'. */
typedef struct {
  PetscReal inverse[MPM_MAX_DIM * MPM_MAX_DIM], gradient[MPM_MAX_DIM];
} End;

PetscInt MpmInputOf(const MpmLayout *layout, PetscInt component, PetscInt basis)
{
  const MpmComponentInputs *of = &layout->input.by_component;

  for (PetscInt k = of->first[component]; k < of->first[component + 1]; k++)
    if (layout->input.basis[of->input[k]] == basis) return of->input[k];
  return -1;
}

static End FindEnd(const MpmLayout *layout, const PetscReal input[])
{
  const PetscInt dim = layout->dim, c = layout->rate.component[0];
  PetscReal      dF[MPM_MAX_DIM * MPM_MAX_DIM], det;
  End            end;

  for (PetscInt k = 0; k < dim * dim; k++)
    dF[k] = (k / dim == k % dim ? 1. : 0.) + input[MpmInputOf(layout, k / dim, 1 + k % dim)];
  det = MpmCofactors(dim * dim, dF, end.inverse);
  for (PetscInt k = 0; k < dim * dim; k++) end.inverse[k] /= det;
  for (PetscInt i = 0; i < dim; i++) {
    end.gradient[i] = 0.;
    for (PetscInt j = 0; j < dim; j++)
      end.gradient[i] += end.inverse[i * dim + j] * input[MpmInputOf(layout, c, 1 + j)];
  }
  return end;
}

/* dg' = dF^{-T} (dG - dH^T g') */
void MpmRatesEndAlong(const MpmStepMap *map, PetscInt p, const PetscReal input[], const PetscReal dinput[],
                      MpmPointVector *end)
{
  const MpmLayout *layout = map->sum->layout;
  const PetscInt   dim = layout->dim, c = layout->rate.component[0];
  PetscReal       *gradient;
  End              at;

  if (!layout->rate.count) return;
  at                                         = FindEnd(layout, input);
  gradient                                   = MpmPointNumbers(end, MPM_VECTOR_GRADIENT, p);
  *MpmPointNumbers(end, MPM_VECTOR_VALUE, p) = dinput[MpmInputOf(layout, c, 0) * MPM_PACK];
  if (end->size[MPM_VECTOR_DEVIATION])
    *MpmPointNumbers(end, MPM_VECTOR_DEVIATION, p) = dinput[MpmInputOf(layout, c, MPM_DEVIATION(dim)) * MPM_PACK];
  for (PetscInt i = 0; i < dim; i++) gradient[i] = 0.;
  for (PetscInt j = 0; j < dim; j++) {
    PetscReal change = dinput[MpmInputOf(layout, c, 1 + j) * MPM_PACK];

    for (PetscInt m = 0; m < dim; m++) change -= dinput[MpmInputOf(layout, m, 1 + j) * MPM_PACK] * at.gradient[m];
    for (PetscInt i = 0; i < dim; i++) gradient[i] += at.inverse[i * dim + j] * change;
  }
}

void MpmRatesPullInputs(const MpmStepMap *map, PetscInt p, const PetscReal input[], const MpmPointVector *end,
                        PetscReal by_input[])
{
  const MpmLayout *layout = map->sum->layout;
  const PetscInt   dim = layout->dim, c = layout->rate.component[0];
  End              at;

  if (!layout->rate.count) return;
  at = FindEnd(layout, input);
  by_input[MpmInputOf(layout, c, 0)] += *MpmPointNumbers(end, MPM_VECTOR_VALUE, p);
  if (end->size[MPM_VECTOR_DEVIATION])
    by_input[MpmInputOf(layout, c, MPM_DEVIATION(dim))] += *MpmPointNumbers(end, MPM_VECTOR_DEVIATION, p);
  for (PetscInt j = 0; j < dim; j++) {
    PetscReal h = 0.;

    for (PetscInt i = 0; i < dim; i++) h += at.inverse[i * dim + j] * MpmPointNumbers(end, MPM_VECTOR_GRADIENT, p)[i];
    by_input[MpmInputOf(layout, c, 1 + j)] += h;
    for (PetscInt m = 0; m < dim; m++) by_input[MpmInputOf(layout, m, 1 + j)] -= h * at.gradient[m];
  }
}

PetscBool MpmRatesAreClosed(const MpmLayout *layout)
{
  const PetscInt c = layout->rate.component[0];

  if (!layout->rate.count) return PETSC_TRUE;
  return (PetscBool)(layout->rate.count == 1 && layout->deviation.count == 1 && layout->deviation.component[0] == c &&
                     layout->shape_count == 1 && MpmInputOf(layout, c, 0) >= 0 && MpmInputOf(layout, c, 1) >= 0);
}

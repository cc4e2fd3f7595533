/*
  Columns of a stress point's history, and their derivatives by the point's state.
*/
#include "point/material.h"
#include "laboratory/stress_point_slopes.h"
#include "query/point_vector.h"
#include "laboratory/laboratory_impl.h"

static const char *const component[] = {"xx", "yy", "zz", "xy", "yz", "xz"};

/* The test that a column is of. */
static const MpmLaboratoryTest *TestOf(const MpmColumn *column)
{
  return (const MpmLaboratoryTest *)column->ctx;
}

/* ---- values ---- */

static PetscErrorCode FillStrain(MpmModel model, const MpmColumn *column, PetscReal values[])
{
  (void)model;
  PetscFunctionBeginUser;
  PetscCall(PetscArraycpy(values, TestOf(column)->point.now.strain, column->count));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode FillStress(MpmModel model, const MpmColumn *column, PetscReal values[])
{
  (void)model;
  PetscFunctionBeginUser;
  PetscCall(PetscArraycpy(values, TestOf(column)->point.now.stress, column->count));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode FillInvariants(MpmModel model, const MpmColumn *column, PetscReal values[])
{
  const MpmLaboratoryTest *test = TestOf(column);
  const MpmPointState     *now  = &test->point.now;

  (void)model;
  PetscFunctionBeginUser;
  values[0] = (now->stress[0] + now->stress[1] + now->stress[2]) / 3.;
  values[1] = MpmDeviatorSize(now->stress);
  values[2] = MpmVolumeStrain(test->strain_measure, now->F);
  values[3] = 2. / 3. * MpmDeviatorSize(now->strain);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A history variable, from its place in the point's history on. */
static PetscErrorCode FillVariable(MpmModel model, const MpmColumn *column, PetscReal values[])
{
  (void)model;
  PetscFunctionBeginUser;
  PetscCall(
    PetscArraycpy(values, &TestOf(column)->point.now.history[column->index], column->count ? column->count : 1));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- derivatives ---- */

/* d sqrt(3/2 dev a : dev a)/da, times a factor; zeros where the deviator is 0, for there it has a kink. */
static void BySym(const PetscReal sym[MPM_SPACE_SYM], PetscReal factor, PetscReal by[MPM_SPACE_SYM])
{
  const PetscReal size = MpmDeviatorSize(sym), mean = (sym[0] + sym[1] + sym[2]) / 3.;

  for (PetscInt s = 0; s < MPM_SPACE_SYM && size > 0.; s++)
    by[s] = factor * (s < 3 ? 1.5 * (sym[s] - mean) : 3. * sym[s]) / size;
}

/* Those of p, q, eps_v and eps_q. */
static void ByInvariant(const MpmLaboratoryTest *test, PetscInt part, PetscReal by[])
{
  const MpmPointState *now = &test->point.now;
  PetscReal            J, cofactor[9];

  if (part == 0)
    for (PetscInt s = 0; s < 3; s++) by[MPM_CHANGE_STRESS + s] = 1. / 3.;
  else if (part == 1) BySym(now->stress, 1., &by[MPM_CHANGE_STRESS]);
  else if (part == 3) BySym(now->strain, 2. / 3., &by[MPM_CHANGE_STRAIN]);
  else {
    J = MpmCofactors(9, now->F, cofactor);
    for (PetscInt k = 0; k < 9; k++)
      by[MPM_CHANGE_F + k] = cofactor[k] / (test->strain_measure == MPM_STRAIN_LOG ? J : 1.);
  }
}

/* Derivatives of one of a row's values by a change of the point's state, which are zeros on entry. */
static void ByState(const MpmColumn *column, PetscInt part, PetscReal by[])
{
  if (column->fill == FillStrain) by[MPM_CHANGE_STRAIN + part] = 1.;
  else if (column->fill == FillStress) by[MPM_CHANGE_STRESS + part] = 1.;
  else if (column->fill == FillVariable) by[MPM_CHANGE_HISTORY + column->index + part] = 1.;
  else ByInvariant(TestOf(column), part, by);
}

static PetscErrorCode StateAlong(MpmModel model, const MpmColumn *column, const MpmPointVector *end,
                                 const PetscReal residual[], PetscReal values[])
{
  PetscReal *by;

  PetscFunctionBeginUser;
  (void)model;
  (void)residual;
  PetscCall(PetscMalloc1(end->state_size, &by));
  for (PetscInt k = 0; k < MpmColumnWidth(column); k++) {
    PetscCall(PetscArrayzero(by, end->state_size));
    ByState(column, k, &by[TestOf(column)->first]);
    values[k] = 0.;
    for (PetscInt i = 0; i < end->state_size; i++) values[k] += by[i] * end->state[i];
  }
  PetscCall(PetscFree(by));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode StatePull(MpmModel model, const MpmColumn *column, const PetscReal weight[], MpmPointVector *end,
                                PetscReal lam[])
{
  PetscReal *by;

  PetscFunctionBeginUser;
  (void)model;
  (void)lam;
  PetscCall(PetscMalloc1(end->state_size, &by));
  for (PetscInt k = 0; k < MpmColumnWidth(column); k++) {
    PetscCall(PetscArrayzero(by, end->state_size));
    ByState(column, k, &by[TestOf(column)->first]);
    for (PetscInt i = 0; i < end->state_size; i++) end->state[i] += weight[k] * by[i];
  }
  PetscCall(PetscFree(by));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the columns ---- */

static const MpmColumnMap by_state = {StateAlong, StatePull, PETSC_FALSE};

PetscErrorCode MpmLaboratoryTestAddColumns(const MpmLawInfo *info, PetscInt dim, MpmLaboratoryTest *test,
                                           MpmColumns *columns)
{
  static const char *const invariants[] = {"p", "q", "eps_v", "eps_q"};
  const MpmColumn          rows[]       = {
                   {"strain", "-", MPM_SPACE_SYM, component, FillStrain, test, 0},
                   {"stress", "Pa", MPM_SPACE_SYM, component, FillStress, test, 0},
                   {NULL, "Pa, strains -", PETSC_STATIC_ARRAY_LENGTH(invariants), invariants, FillInvariants, test, 0},
  };
  PetscInt first = 0;

  PetscFunctionBeginUser;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(rows); k++) {
    PetscCall(MpmColumnsAdd(columns, test->name, &rows[k]));
    MpmColumnsSetMap(columns, &by_state);
  }
  for (size_t v = 0; v < info->state_count; v++) {
    const PetscInt  size = MpmStateComponents(&info->states[v], dim);
    const MpmColumn row  = {
       info->states[v].name, info->states[v].unit, size > 1 ? size : 0, component, FillVariable, test, first};

    PetscCall(MpmColumnsAdd(columns, test->name, &row));
    MpmColumnsSetMap(columns, &by_state);
    first += size;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

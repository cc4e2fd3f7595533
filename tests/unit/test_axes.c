/*
  Directions at right angles to a given one.
*/
#include "base/axes.h"
#include "unit.h"

/* axis k times axis l */
static PetscReal Dot(PetscInt dim, const PetscReal one[], const PetscReal other[])
{
  PetscReal sum = 0.;

  for (PetscInt a = 0; a < dim; a++) sum += one[a] * other[a];
  return sum;
}

START_TEST(axes_are_orthonormal_and_right_handed)
{
  const PetscReal normals[][3] = {{1., 0., 0.},   {0., -2., 0.}, {0., 0., 3.},         {1., 1., 1.},
                                  {-0.3, 2., 1.}, {5., -5., 0.}, {1e-200, 0., 1e-200}, {1e150, -1e150, 3e150}};

  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(normals); k++) {
    for (PetscInt dim = 2; dim <= 3; dim++) {
      PetscReal axis[MPM_MAX_DIM][MPM_MAX_DIM] = {{0.}}, length;

      PetscReal way = 0.;

      for (PetscInt a = 0; a < dim; a++) {
        axis[0][a] = normals[k][a];
        way        = PetscMax(way, PetscAbsReal(normals[k][a]));
      }
      if (way == 0.) continue;
      ck_assert(MpmAxesComplete(dim, axis));
      for (PetscInt i = 0; i < dim; i++)
        for (PetscInt j = 0; j < dim; j++) ck_assert_double_eq_tol(Dot(dim, axis[i], axis[j]), i == j ? 1. : 0., 1e-14);
      length = Dot(dim, axis[0], normals[k]) / way;
      ck_assert_double_ge(length, 0.99);
      if (dim == 2) ck_assert_double_eq_tol(axis[0][0] * axis[1][1] - axis[0][1] * axis[1][0], 1., 1e-14);
      for (PetscInt a = 0; a < 3 && dim == 3; a++)
        ck_assert_double_eq_tol(
          axis[2][a], axis[0][(a + 1) % 3] * axis[1][(a + 2) % 3] - axis[0][(a + 2) % 3] * axis[1][(a + 1) % 3], 1e-14);
    }
  }
}
END_TEST

START_TEST(first_direction_across_is_the_next_axis)
{
  for (PetscInt a = 0; a < 3; a++) {
    PetscReal axis[MPM_MAX_DIM][MPM_MAX_DIM] = {{0.}};

    axis[0][a] = 2.;
    ck_assert(MpmAxesComplete(3, axis));
    for (PetscInt b = 0; b < 3; b++) {
      ck_assert_double_eq(axis[1][b], b == (a + 1) % 3 ? 1. : 0.);
      ck_assert_double_eq(axis[2][b], b == (a + 2) % 3 ? 1. : 0.);
    }
  }
}
END_TEST

START_TEST(no_direction_is_told)
{
  PetscReal axis[MPM_MAX_DIM][MPM_MAX_DIM] = {{0.}};

  ck_assert(!MpmAxesComplete(2, axis));
  ck_assert(!MpmAxesComplete(3, axis));
}
END_TEST

int main(int argc, char **argv)
{
  const TTest *const tests[] = {axes_are_orthonormal_and_right_handed, first_direction_across_is_the_next_axis,
                                no_direction_is_told};

  return UnitRun(&argc, &argv, "axes", sizeof(tests) / sizeof(tests[0]), tests);
}

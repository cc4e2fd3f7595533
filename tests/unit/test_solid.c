/*
  Shapes of rigid bodies: distances against an exhaustive search, and their derivatives against differences. Motions.
*/
#include "geometry/motion.h"
#include "geometry/solid.h"
#include "options/options.h"
#include "rigid/rigid.h"
#include "unit.h"

#include <math.h>
#include <stdio.h>
#include <unistd.h>

#define TRIALS 400

static PetscReal Random(PetscReal lower, PetscReal upper)
{
  return lower + (upper - lower) * ((PetscReal)rand() / RAND_MAX);
}

/* A shape from the options of a block, in a test of this dimension. */
static MpmSolid Make(PetscInt dim, const char text[])
{
  const MpmOptions options = {PETSC_COMM_WORLD, "mpm_a_", NULL};
  MpmSolid         solid   = {.dim = 0};

  UNIT_CALL(PetscOptionsClear(NULL));
  UNIT_CALL(PetscOptionsInsertString(NULL, text));
  UNIT_CALL(MpmSolidRead(&options, dim, &solid));
  UNIT_CALL(PetscOptionsClear(NULL));
  return solid;
}

static PetscReal DistanceOf(const MpmSolid *solid, const PetscReal x[])
{
  MpmSurface surface;

  MpmSolidDistance(solid, 0., x, &surface);
  return surface.distance;
}

/* The gradient is a unit vector and that of the distance, the second derivative that of the gradient. */
static void CheckDerivatives(const MpmSolid *solid, const PetscReal x[])
{
  const PetscInt  dim    = solid->dim;
  const PetscReal e      = 1e-5;
  PetscReal       square = 0.;
  PetscReal       on[3]  = {0., 0., 0.};
  MpmSurface      at;

  MpmSolidDistance(solid, 0., x, &at);
  for (PetscInt a = 0; a < dim; a++) square += PetscSqr(at.normal[a]);
  ck_assert_double_eq_tol(square, 1., 1e-13);
  for (PetscInt a = 0; a < dim; a++) {
    PetscReal  near[3] = {0., 0., 0.};
    MpmSurface side[2];

    for (PetscInt k = 0; k < 2; k++) {
      for (PetscInt b = 0; b < dim; b++) near[b] = x[b];
      near[a] += k ? e : -e;
      MpmSolidDistance(solid, 0., near, &side[k]);
    }
    ck_assert_double_eq_tol((side[1].distance - side[0].distance) / (2. * e), at.normal[a], 1e-7);
    for (PetscInt b = 0; b < dim; b++)
      ck_assert_double_eq_tol((side[1].normal[b] - side[0].normal[b]) / (2. * e), at.second[a][b], 1e-5);
  }
  for (PetscInt a = 0; a < dim; a++) on[a] = x[a] - at.distance * at.normal[a];
  ck_assert_double_eq_tol(DistanceOf(solid, on), 0., 1e-13); /* the way back leads to the surface */
}

/* True where the gradient jumps or bends so near the place that differences are meaningless. */
static PetscBool IsKink(const MpmSolid *solid, const PetscReal x[])
{
  const PetscReal e = 4e-5;
  MpmSurface      at, near;

  MpmSolidDistance(solid, 0., x, &at);
  for (PetscInt k = 0; k < 27; k++) {
    PetscReal change = 0., bend = 0., place[3] = {0., 0., 0.};

    for (PetscInt a = 0; a < solid->dim; a++)
      place[a] = x[a] + e * (PetscReal)(k / (a == 0 ? 1 : a == 1 ? 3 : 9) % 3 - 1);
    MpmSolidDistance(solid, 0., place, &near);
    for (PetscInt a = 0; a < solid->dim; a++) {
      change += PetscAbsReal(near.normal[a] - at.normal[a]);
      for (PetscInt b = 0; b < solid->dim; b++) bend += PetscAbsReal(near.second[a][b] - at.second[a][b]);
    }
    if (change > 0.02 || bend > 0.05) return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* At random places in a box round it, on both sides. */
static void CheckEverywhere(MpmSolid *solid, PetscReal reach)
{
  PetscInt tried = 0, inside = 0;

  for (PetscInt k = 0; k < TRIALS; k++) {
    const PetscReal x[3] = {Random(-reach, reach), Random(-reach, reach), Random(-reach, reach)};

    if (IsKink(solid, x)) continue;
    CheckDerivatives(solid, x);
    tried++;
    inside += DistanceOf(solid, x) < 0. ? 1 : 0;
  }
  ck_assert_msg(tried > TRIALS / 2, "%d places are smooth", (int)tried);
  ck_assert_msg(inside > TRIALS / 50 && inside < tried, "%d places are inside", (int)inside);
}

/* The least distance from places of the surface, of which there are many. */
typedef void (*Sample)(PetscReal u, PetscReal v, PetscInt face, PetscReal x[3]);

static void CheckSamples(MpmSolid *solid, PetscInt faces, PetscInt n, Sample sample, PetscReal reach)
{
  const PetscInt rows = solid->dim == 3 ? n : 0;

  for (PetscInt k = 0; k < 40; k++) {
    const PetscReal x[3] = {Random(-reach, reach), Random(-reach, reach), Random(-reach, reach)};
    PetscReal       best = PETSC_INFINITY, on[3] = {0., 0., 0.};

    for (PetscInt face = 0; face < faces; face++)
      for (PetscInt i = 0; i <= n; i++)
        for (PetscInt j = 0; j <= rows; j++) {
          PetscReal square = 0.;

          sample((PetscReal)i / (PetscReal)n, rows ? (PetscReal)j / (PetscReal)n : 0., face, on);
          if (!k) ck_assert_double_eq_tol(DistanceOf(solid, on), 0., 1e-13);
          for (PetscInt a = 0; a < solid->dim; a++) square += PetscSqr(x[a] - on[a]);
          best = PetscMin(best, PetscSqrtReal(square));
        }
    const PetscReal distance = PetscAbsReal(DistanceOf(solid, x));

    ck_assert_msg(distance <= best + 1e-13 && best - distance < 0.02, "%g against %g", (double)distance, (double)best);
  }
}

/* ---- plane, sphere, cylinder ---- */

START_TEST(round_and_flat)
{
  const PetscReal on_axis[3] = {0.1, 0.2, 0.3};
  MpmSolid        solid;
  MpmSurface      surface;
  PetscReal       dot = 0.;

  solid = Make(3, "-mpm_a_type plane -mpm_a_point 0.1,0.2,0.3 -mpm_a_normal 1,2,-1");
  CheckEverywhere(&solid, 2.);
  solid = Make(2, "-mpm_a_type sphere -mpm_a_center 0.1,0.2 -mpm_a_radius 0.7 -mpm_a_side inside");
  CheckEverywhere(&solid, 1.);
  solid = Make(3, "-mpm_a_type sphere -mpm_a_center 0.1,0.2,0.3 -mpm_a_radius 0.7");
  CheckEverywhere(&solid, 1.);
  MpmSolidDistance(&solid, 0.1, on_axis, &surface);
  ck_assert_double_eq_tol(surface.distance, -0.8, 1e-15);
  solid = Make(3, "-mpm_a_type cylinder -mpm_a_point 0.1,0.2,0.3 -mpm_a_axis 3,0.1,0.2 -mpm_a_radius 0.7");
  CheckEverywhere(&solid, 1.5);
  for (PetscInt k = 0; k < 20; k++) { /* on the axis: some direction across it */
    PetscReal x[3];

    for (PetscInt a = 0; a < 3; a++) x[a] = on_axis[a] + (PetscReal)k / 7. * solid.direction[a];
    MpmSolidDistance(&solid, 0., x, &surface);
    dot = 0.;
    for (PetscInt a = 0; a < 3; a++) dot += surface.normal[a] * solid.direction[a];
    ck_assert_double_eq_tol(surface.distance, -0.7, 1e-15);
    ck_assert_double_eq_tol(dot, 0., 1e-15);
    ck_assert(surface.second[0][0] == 0. && surface.second[1][2] == 0.);
  }
}
END_TEST

/* ---- box ---- */

static const PetscReal box_lower[3] = {-0.5, -0.3, -0.8}, box_upper[3] = {0.5, 0.9, 0.4};

static void OnBox(PetscReal u, PetscReal v, PetscInt face, PetscReal x[3])
{
  const PetscInt a = face / 2, b = (a + 1) % 3, c = (a + 2) % 3;

  x[a] = face % 2 ? box_upper[a] : box_lower[a];
  x[b] = box_lower[b] + u * (box_upper[b] - box_lower[b]);
  x[c] = box_lower[c] + v * (box_upper[c] - box_lower[c]);
}

static void OnRectangle(PetscReal u, PetscReal v, PetscInt face, PetscReal x[3])
{
  const PetscInt a = face / 2, b = 1 - a;

  (void)v;
  x[a] = face % 2 ? box_upper[a] : box_lower[a];
  x[b] = box_lower[b] + u * (box_upper[b] - box_lower[b]);
}

static void CheckSurface(const MpmSolid *solid, const PetscReal x[], PetscReal distance, const PetscReal normal[],
                         PetscReal trace)
{
  MpmSurface surface;
  PetscReal  sum = 0.;

  MpmSolidDistance(solid, 0., x, &surface);
  ck_assert_double_eq_tol(surface.distance, distance, 1e-14);
  for (PetscInt a = 0; a < solid->dim; a++) {
    ck_assert_double_eq_tol(surface.normal[a], normal[a], 1e-14);
    sum += surface.second[a][a];
  }
  ck_assert_double_eq_tol(sum, trace, 1e-12);
}

static void CheckUnit(const MpmSolid *solid, const PetscReal x[], PetscReal distance)
{
  MpmSurface surface;
  PetscReal  square = 0.;

  MpmSolidDistance(solid, 0., x, &surface);
  ck_assert_double_eq_tol(surface.distance, distance, 1e-14);
  for (PetscInt a = 0; a < solid->dim; a++) {
    square += PetscSqr(surface.normal[a]);
    for (PetscInt b = 0; b < solid->dim; b++) ck_assert(!PetscIsInfOrNanReal(surface.second[a][b]));
  }
  ck_assert_double_eq_tol(square, 1., 1e-14);
}

START_TEST(boxes)
{
  MpmSolid solid = Make(3, "-mpm_a_type box -mpm_a_lower -0.5,-0.3,-0.8 -mpm_a_upper 0.5,0.9,0.4");

  CheckEverywhere(&solid, 1.5);
  CheckSamples(&solid, 6, 60, OnBox, 1.5);
  CheckSurface(&solid, (const PetscReal[]){0.8, 0.3, 0.}, 0.3, (const PetscReal[]){1., 0., 0.}, 0.);
  CheckSurface(&solid, (const PetscReal[]){0.8, -0.7, 0.}, 0.5, (const PetscReal[]){0.6, -0.8, 0.}, 2.);
  CheckSurface(&solid, (const PetscReal[]){0.8, -0.7, 0.4}, 0.5, (const PetscReal[]){0.6, -0.8, 0.}, 2.);
  CheckSurface(&solid, (const PetscReal[]){0.7, 1.1, 0.5}, 0.3, (const PetscReal[]){2. / 3., 2. / 3., 1. / 3.},
               2. / 0.3);
  CheckUnit(&solid, (const PetscReal[]){0.5, 0.9, 0.4}, 0.);
  CheckUnit(&solid, (const PetscReal[]){0.5, 0.9, 0.1}, 0.);
  CheckUnit(&solid, (const PetscReal[]){0., 0.3, -0.2}, -0.5);
  solid = Make(2, "-mpm_a_type box -mpm_a_lower -0.5,-0.3 -mpm_a_upper 0.5,0.9 -mpm_a_side inside");
  CheckEverywhere(&solid, 1.5);
  CheckSamples(&solid, 4, 400, OnRectangle, 1.5);
  CheckSurface(&solid, (const PetscReal[]){0.8, -0.7}, -0.5, (const PetscReal[]){-0.6, 0.8}, -2.);
  CheckUnit(&solid, (const PetscReal[]){0.5, 0.9}, 0.);
}
END_TEST

/* ---- cone ---- */

/* The tip at the origin, up: flank to radius 0.6, then the shaft; by half angle 30 degrees. */
static void OnCone(PetscReal u, PetscReal v, PetscInt face, PetscReal x[3])
{
  const PetscReal R = 0.6, H = R * PetscSqrtReal(3.), rho = face ? R : u * R, s = face ? H + u * 2. : u * H;

  x[0] = rho * PetscCosReal(2. * PETSC_PI * v);
  x[1] = rho * PetscSinReal(2. * PETSC_PI * v);
  x[2] = s;
}

static void OnWedge(PetscReal u, PetscReal v, PetscInt face, PetscReal x[3])
{
  PetscReal place[3];

  (void)v;
  OnCone(u, 0.5 * (face % 2), face / 2, place);
  x[0] = place[0];
  x[1] = place[2];
}

/* Deep in a box that has retreated, the face that is named counts, not the nearest one; outside, its plane. */
START_TEST(flat_faces)
{
  const struct {
    PetscInt    dim;
    const char *options;
    PetscBool   flat;
  } cases[] = {{2, "-mpm_a_type box -mpm_a_lower 0,0 -mpm_a_upper 1,2", PETSC_TRUE},
               {2, "-mpm_a_type polygon -mpm_a_vertices 0,0,1,0,0,1", PETSC_TRUE},
               {2, "-mpm_a_type cone -mpm_a_tip 0,0 -mpm_a_radius 1", PETSC_TRUE},
               {3, "-mpm_a_type cone -mpm_a_tip 0,0,0 -mpm_a_radius 1", PETSC_FALSE},
               {2, "-mpm_a_type sphere -mpm_a_center 0,0 -mpm_a_radius 1", PETSC_FALSE}};

  for (size_t k = 0; k < sizeof(cases) / sizeof(cases[0]); k++) {
    MpmSolid solid = Make(cases[k].dim, cases[k].options);

    ck_assert_int_eq(MpmSolidHasFaces(&solid), cases[k].flat);
    UNIT_CALL(MpmSolidDestroy(&solid));
  }
}
END_TEST

START_TEST(cones)
{
  const PetscReal half  = 0.5 * PetscSqrtReal(3.);
  MpmSolid        solid = Make(3, "-mpm_a_type cone -mpm_a_tip 0,0,0 -mpm_a_radius 0.6");

  CheckEverywhere(&solid, 1.5);
  CheckSamples(&solid, 2, 200, OnCone, 1.5);
  CheckSurface(&solid, (const PetscReal[]){0., 0., -0.5}, 0.5, (const PetscReal[]){0., 0., -1.}, 4.);
  CheckSurface(&solid, (const PetscReal[]){0., 0., 0.}, 0., (const PetscReal[]){0., 0., -1.}, 0.);
  CheckSurface(&solid, (const PetscReal[]){0., -0.8, 1.5}, 0.2, (const PetscReal[]){0., -1., 0.}, 1. / 0.8);
  CheckSurface(&solid, (const PetscReal[]){0.3 + 0.1 * half, 0., 0.3 * PetscSqrtReal(3.) - 0.05}, 0.1,
               (const PetscReal[]){half, 0., -0.5}, half / (0.3 + 0.1 * half));
  CheckUnit(&solid, (const PetscReal[]){0., 0., 2.}, -0.6);
  CheckUnit(&solid, (const PetscReal[]){0., 0., 0.4}, -0.2);
  CheckUnit(&solid, (const PetscReal[]){0.6, 0., 0.6 * PetscSqrtReal(3.)}, 0.);
  solid = Make(3, "-mpm_a_type cone -mpm_a_tip 0.1,0.2,0.3 -mpm_a_axis 0.3,-1,0.2 -mpm_a_angle 100 -mpm_a_radius 0.4 "
                  "-mpm_a_side inside");
  CheckEverywhere(&solid, 1.2);
  for (PetscInt k = 1; k < 9; k++) { /* on the axis, which is not one of the coordinates': below the tip, and within */
    MpmSurface surface;
    PetscReal  x[3], trace;

    for (PetscInt a = 0; a < 3; a++) x[a] = solid.point[a] - (PetscReal)k / 7. * solid.direction[a];
    MpmSolidDistance(&solid, 0., x, &surface);
    trace = surface.second[0][0] + surface.second[1][1] + surface.second[2][2];
    ck_assert_double_eq_tol(surface.distance, -(PetscReal)k / 7., 1e-14);
    ck_assert_double_eq_tol(trace, -14. / (PetscReal)k, 1e-12);
    for (PetscInt a = 0; a < 3; a++) {
      ck_assert_double_eq_tol(surface.normal[a], solid.direction[a], 1e-14);
      x[a] = solid.point[a] + (1. + (PetscReal)k) * solid.direction[a];
    }
    CheckUnit(&solid, x, 0.4);
  }
  solid = Make(2, "-mpm_a_type cone -mpm_a_tip 0,0 -mpm_a_radius 0.6");
  CheckEverywhere(&solid, 1.5);
  CheckSamples(&solid, 4, 2000, OnWedge, 1.5);
  CheckUnit(&solid, (const PetscReal[]){0., 0.}, 0.);
  CheckUnit(&solid, (const PetscReal[]){0., 0.4}, -0.2);
}
END_TEST

/* ---- polygon ---- */

static const PetscReal ell[7][2] = {{-1., -1.}, {0., -1.}, {1., -1.}, {1., 0.}, {0., 0.}, {0., 1.}, {-1., 1.}};

static void OnEll(PetscReal u, PetscReal v, PetscInt face, PetscReal x[3])
{
  (void)v;
  for (PetscInt a = 0; a < 2; a++) x[a] = (1. - u) * ell[face][a] + u * ell[(face + 1) % 7][a];
}

START_TEST(polygons)
{
  MpmSolid  solid = Make(2, "-mpm_a_type polygon -mpm_a_vertices -1,1,0,1,0,0,1,0,1,-1,0,-1,-1,-1");
  PetscReal middle[3];

  CheckEverywhere(&solid, 1.5);
  CheckSamples(&solid, 7, 500, OnEll, 1.5);
  CheckSurface(&solid, (const PetscReal[]){0., -1.5}, 0.5, (const PetscReal[]){0., -1.}, 0.); /* a straight vertex */
  CheckSurface(&solid, (const PetscReal[]){0., -1.}, 0., (const PetscReal[]){0., -1.}, 0.);
  CheckSurface(&solid, (const PetscReal[]){1., -1.}, 0., (const PetscReal[]){PETSC_SQRT2 / 2., -PETSC_SQRT2 / 2.}, 0.);
  CheckSurface(&solid, (const PetscReal[]){0., 0.}, 0., (const PetscReal[]){PETSC_SQRT2 / 2., PETSC_SQRT2 / 2.}, 0.);
  CheckSurface(&solid, (const PetscReal[]){1.3, -1.4}, 0.5, (const PetscReal[]){0.6, -0.8}, 2.);
  MpmSolidMiddle(&solid, middle); /* squares at (-1/2, -1/2), (1/2, -1/2), (-1/2, 1/2) */
  ck_assert_double_eq_tol(middle[0], -1. / 6., 1e-15);
  ck_assert_double_eq_tol(middle[1], -1. / 6., 1e-15);
  UNIT_CALL(MpmSolidDestroy(&solid));
}
END_TEST

/* ---- poses ---- */

START_TEST(poses)
{
  const MpmPose   rest     = {.growth = 0.};
  const PetscReal pivot[3] = {0.3, -0.2, 0.5}, quarter[3] = {0., 0., PETSC_PI / 2.}, x[3] = {1., 2., 3.};
  MpmPose         turned = {.translation = {1., 0., -1.}}, moved = {.translation = {0.5, 0.25, 2.}};
  PetscReal       y[3], z[3];

  MpmPoseSetRotation(&moved, pivot, (const PetscReal[]){0., 0., 0.});
  ck_assert(!moved.turned);
  MpmPoseCarry(3, &rest, &moved, x, y);
  ck_assert(y[0] == 1.5 && y[1] == 2.25 && y[2] == 5.);
  MpmPoseSetRotation(&turned, pivot, quarter); /* (0.7, 2.2, 2.5) becomes (-2.2, 0.7, 2.5) */
  MpmPoseCarry(3, &rest, &turned, x, y);
  ck_assert_double_eq_tol(y[0], 0.3 - 2.2 + 1., 1e-15);
  ck_assert_double_eq_tol(y[1], -0.2 + 0.7, 1e-15);
  ck_assert_double_eq_tol(y[2], 2., 1e-15);
  MpmPoseCarry(2, &rest, &turned, x, z);
  ck_assert(z[0] == y[0] && z[1] == y[1]);
  MpmPoseCarry(3, &turned, &moved, y, z); /* by way of one place or straight */
  MpmPoseCarry(3, &rest, &moved, x, y);
  for (PetscInt a = 0; a < 3; a++) ck_assert_double_eq_tol(y[a], z[a], 1e-14);
  MpmPoseTurn(3, &rest, &turned, x, y);
  ck_assert_double_eq_tol(y[0], -2., 1e-15);
  ck_assert_double_eq_tol(y[1], 1., 1e-15);
  MpmPoseTurn(3, &turned, &rest, y, y);
  for (PetscInt a = 0; a < 3; a++) ck_assert_double_eq_tol(y[a], x[a], 1e-15);
}
END_TEST

/* Small and large turns about any axis: rotations, and together those of the sum of their angles. */
START_TEST(rotations)
{
  const PetscReal pivot[3] = {0., 0., 0.};

  for (PetscInt k = 0; k < TRIALS; k++) {
    const PetscReal size = PetscPowReal(10., Random(-9., 0.8));
    PetscReal       vector[3], twice[3], x[3], once[3], both[3], straight[3], length[2] = {0., 0.};
    const MpmPose   rest = {.growth = 0.};
    MpmPose         one = rest, two = rest;

    for (PetscInt a = 0; a < 3; a++) {
      vector[a] = size * Random(-1., 1.);
      twice[a]  = 2. * vector[a];
      x[a]      = Random(-1., 1.);
    }
    MpmPoseSetRotation(&one, pivot, vector);
    MpmPoseSetRotation(&two, pivot, twice);
    MpmPoseTurn(3, &rest, &one, x, once);
    MpmPoseTurn(3, &rest, &one, once, both);
    MpmPoseTurn(3, &rest, &two, x, straight);
    for (PetscInt a = 0; a < 3; a++) {
      length[0] += PetscSqr(x[a]);
      length[1] += PetscSqr(once[a]);
      ck_assert_double_eq_tol(both[a], straight[a], 4e-15);
    }
    ck_assert_double_eq_tol(length[0], length[1], 2e-15);
  }
}
END_TEST

/* A boundary that has turned and moved: its distances are those of the places that were carried along. */
START_TEST(turned_boundaries)
{
  static const char *const shapes[] = {
    "-mpm_a_type plane -mpm_a_point 0.1,0.2,0.3 -mpm_a_normal 1,2,-1",
    "-mpm_a_type box -mpm_a_lower -0.5,-0.3,-0.8 -mpm_a_upper 0.5,0.9,0.4",
    "-mpm_a_type cone -mpm_a_tip 0.1,0.2,0.3 -mpm_a_axis 0.3,-1,0.2 -mpm_a_radius 0.4",
    "-mpm_a_type cylinder -mpm_a_point 0.1,0.2,0.3 -mpm_a_axis 3,0.1,0.2 -mpm_a_radius 0.7 -mpm_a_side inside"};
  const PetscReal pivot[3] = {0.3, -0.2, 0.5}, vector[3] = {0.5, 1.1, -0.7}, e = 1e-5;
  const MpmPose   rest = {.growth = 0.};
  MpmPose         pose = {.translation = {0.1, 0.2, -0.3}};

  MpmPoseSetRotation(&pose, pivot, vector);
  for (size_t k = 0; k < sizeof(shapes) / sizeof(shapes[0]); k++) {
    const MpmBoundary boundary = {.dim = 3, .solid = Make(3, shapes[k])};

    for (PetscInt trial = 0; trial < 50; trial++) {
      const PetscReal x[3] = {Random(-1., 1.), Random(-1., 1.), Random(-1., 1.)};
      PetscReal       y[3], normal[3];
      MpmSurface      at, carried, side[2];

      MpmPoseCarry(3, &rest, &pose, x, y);
      MpmBoundaryDistance(&boundary, &rest, x, &at);
      MpmBoundaryDistance(&boundary, &pose, y, &carried);
      ck_assert_double_eq_tol(at.distance, carried.distance, 1e-14);
      MpmPoseTurn(3, &rest, &pose, at.normal, normal);
      for (PetscInt a = 0; a < 3; a++) ck_assert_double_eq_tol(normal[a], carried.normal[a], 1e-12);
      if (IsKink(&boundary.solid, x)) continue;
      for (PetscInt a = 0; a < 3; a++) {
        for (PetscInt s = 0; s < 2; s++) {
          PetscReal near[3] = {y[0], y[1], y[2]};

          near[a] += s ? e : -e;
          MpmBoundaryDistance(&boundary, &pose, near, &side[s]);
        }
        ck_assert_double_eq_tol((side[1].distance - side[0].distance) / (2. * e), carried.normal[a], 1e-7);
        for (PetscInt b = 0; b < 3; b++)
          ck_assert_double_eq_tol((side[1].normal[b] - side[0].normal[b]) / (2. * e), carried.second[a][b], 1e-5);
      }
    }
  }
}
END_TEST

/* ---- motions ---- */

static const char table_path[] = "test_solid.csv";

static PetscErrorCode ReadMotion(PetscInt dim, const char text[], MpmMotion *motion)
{
  const MpmOptions options = {PETSC_COMM_WORLD, "mpm_a_", NULL};

  PetscFunctionBeginUser;
  *motion = (MpmMotion){.pivot = {1., 2., 3.}};
  PetscCall(PetscOptionsClear(NULL));
  PetscCall(PetscOptionsInsertString(NULL, text));
  PetscCall(MpmMotionRead(&options, dim, motion));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void WriteTable(const char text[])
{
  FILE *file = fopen(table_path, "w");

  ck_assert_ptr_nonnull(file);
  ck_assert_int_ge(fputs(text, file), 0);
  ck_assert_int_eq(fclose(file), 0);
}

/* Where a place stands at a time. */
static void CheckPlace(const MpmMotion *motion, PetscReal time, const PetscReal x[3], const PetscReal expected[3])
{
  const MpmPose rest = {.growth = 0.}, pose = MpmMotionPose(motion, time);
  PetscReal     y[3];

  MpmPoseCarry(3, &rest, &pose, x, y);
  for (PetscInt a = 0; a < 3; a++) ck_assert_double_eq_tol(y[a], expected[a], 1e-14);
}

START_TEST(motions)
{
  const PetscReal x[3] = {2., 2., 3.};
  MpmMotion       motion;

  UNIT_CALL(ReadMotion(2, "-mpm_a_motion 0.5,1 -mpm_a_rotation 180 -mpm_a_ramp 0:0,2:1", &motion));
  CheckPlace(&motion, 1., x, (const PetscReal[]){1.25, 3.5, 3.});
  CheckPlace(&motion, 5., x, (const PetscReal[]){0.5, 3., 3.});
  ck_assert(!MpmMotionPose(&motion, 0.).turned);
  UNIT_CALL(MpmMotionDestroy(&motion));
  UNIT_CALL(ReadMotion(3, "-mpm_a_rotation 0,-90,0 -mpm_a_pivot 0,0,0", &motion));
  CheckPlace(&motion, 1., x, (const PetscReal[]){-3., 2., 2.});
  UNIT_CALL(MpmMotionDestroy(&motion));
  WriteTable("# a remark\ntime, rz, uy\n1,0,0\n2, 90,1\n4,90,-1\n");
  UNIT_CALL(ReadMotion(2, "-mpm_a_motion_table test_solid.csv", &motion));
  ck_assert(!MpmMotionPose(&motion, 0.5).turned);
  CheckPlace(&motion, 1.5, x, (const PetscReal[]){1. + PETSC_SQRT2 / 2., 2.5 + PETSC_SQRT2 / 2., 3.});
  CheckPlace(&motion, 2., x, (const PetscReal[]){1., 4., 3.});
  CheckPlace(&motion, 2.5, x, (const PetscReal[]){1., 3.5, 3.});
  CheckPlace(&motion, 9., x, (const PetscReal[]){1., 2., 3.});
  UNIT_CALL(MpmMotionDestroy(&motion));
  WriteTable("time,ux,uz,rx\n0,1,2,0\n");
  UNIT_CALL(ReadMotion(3, "-mpm_a_motion_table test_solid.csv", &motion));
  CheckPlace(&motion, 7., x, (const PetscReal[]){3., 2., 5.});
  UNIT_CALL(MpmMotionDestroy(&motion));
  ck_assert_int_eq(unlink(table_path), 0);
}
END_TEST

START_TEST(motions_refused)
{
  static const struct {
    PetscInt    dim;
    const char *more, *table, *message;
  } cases[] = {
    {2, "-mpm_a_ramp 0:0,1:1", "time,ux\n0,0\n",
     "-mpm_a_ramp: must not be given beside -mpm_a_motion_table, which has the motion by time"},
    {2, "-mpm_a_rotation 3", "time,ux\n0,0\n",
     "-mpm_a_rotation: must not be given beside -mpm_a_motion_table, which has the motion by time"},
    {2, "", "ux\n0\n", "-mpm_a_motion_table test_solid.csv: has no column time; there is ux"},
    {2, "", "time\n0\n", "-mpm_a_motion_table test_solid.csv: has no column that moves anything: ux, uy or rz"},
    {2, "", "time,ux\n", "-mpm_a_motion_table test_solid.csv: has no rows"},
    {2, "", "time,uz\n0,0\n", "-mpm_a_motion_table test_solid.csv: column uz is unknown: must be time, ux, uy or rz"},
    {3, "", "time,u\n0,0\n",
     "-mpm_a_motion_table test_solid.csv: column u is unknown: must be time, ux, uy, uz, rx, ry or rz"},
    {3, "", "time,ux,ux\n0,0,0\n", "-mpm_a_motion_table test_solid.csv: line 1 has column ux twice, as number 2 and 3"},
    {3, "", "time,ux\n0,0\n0,1\n",
     "-mpm_a_motion_table test_solid.csv: time must grow from row to row: 0 s of row 2 follows 0 s"},
    {3, "", "time,ux\n0,0\n1,inf\n", "-mpm_a_motion_table test_solid.csv: ux of row 2 is not a finite number"},
  };
  MpmMotion motion;

  for (size_t k = 0; k < sizeof(cases) / sizeof(cases[0]); k++) {
    char text[200];

    WriteTable(cases[k].table);
    snprintf(text, sizeof(text), "-mpm_a_motion_table %s %s", table_path, cases[k].more);
    UNIT_FAILS(ReadMotion(cases[k].dim, text, &motion), MPM_ERR_INPUT, cases[k].message);
  }
  ck_assert_int_eq(unlink(table_path), 0);
  UNIT_FAILS(ReadMotion(2, "-mpm_a_motion_table test_solid.csv", &motion), MPM_ERR_INPUT,
             "-mpm_a_motion_table test_solid.csv: cannot be read: No such file or directory");
  UNIT_FAILS(
    ReadMotion(2, "-mpm_a_rotation 1,2,3", &motion), MPM_ERR_INPUT,
    "-mpm_a_rotation 1,2,3: must have 1 value, has 3: rotation in total: about z in 2D, its axis times its angle in "
    "3D (degrees)");
}
END_TEST

/* Places on a diagonal, which rounding moves to either side: the same face counts on all of them. */
START_TEST(ties)
{
  static const char *const texts[] = {"-mpm_a_type box -mpm_a_lower -1,-1 -mpm_a_upper 1,1",
                                      "-mpm_a_type polygon -mpm_a_vertices -1,-1,1,-1,1,1,-1,1"};

  for (PetscInt k = 0; k < 2; k++) {
    const MpmSolid solid = Make(2, texts[k]);

    for (PetscInt corner = 0; corner < 4; corner++) {
      const PetscReal sign[2] = {corner % 2 ? -1. : 1., corner / 2 ? -1. : 1.};

      for (PetscInt depth = 0; depth < 2; depth++) {
        const PetscReal at = depth ? 0.75 : 1.; /* inside; on the corner itself, rounding is nothing */
        MpmSurface      one, other;

        if (!depth && k) continue; /* a polygon's vertices are round */
        MpmSolidDistance(&solid, 0., (PetscReal[]){sign[0] * at, sign[1] * (at + 1e-13), 0.}, &one);
        MpmSolidDistance(&solid, 0., (PetscReal[]){sign[0] * (at + 1e-13), sign[1] * at, 0.}, &other);
        for (PetscInt a = 0; a < 2; a++) ck_assert_double_eq(one.normal[a], other.normal[a]);
        ck_assert_double_eq_tol(one.distance, other.distance, 1e-12);
      }
    }
  }
}
END_TEST

int main(int argc, char **argv)
{
  const TTest *const tests[] = {round_and_flat,    boxes,   flat_faces,      cones, polygons, poses, rotations,
                                turned_boundaries, motions, motions_refused, ties};

  return UnitRun(&argc, &argv, "solid", sizeof(tests) / sizeof(tests[0]), tests);
}

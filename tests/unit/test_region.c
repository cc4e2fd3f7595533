/*
  Regions and ramps: what they hold, what they refuse.
*/
#include "geometry/geometry.h"
#include "geometry/region_part.h"
#include "options/options.h"
#include "unit.h"

#include <math.h>

static const PetscReal tolerance[3] = {1e-6, 2e-6, 4e-6};

static MpmOptions options;

/* Alternating names and values of the block's options, NULL at the end. */
static void Block(const char *const pairs[])
{
  char name[100];

  UNIT_CALL(PetscOptionsClear(NULL));
  options = (MpmOptions){PETSC_COMM_WORLD, "mpm_a_", NULL};
  for (; pairs[0]; pairs += 2) {
    snprintf(name, sizeof(name), "-mpm_a_%s", pairs[0]);
    UNIT_CALL(PetscOptionsSetValue(NULL, name, pairs[1]));
  }
}

#define BLOCK(...) Block((const char *const[]){__VA_ARGS__, NULL})

static MpmRegion Create(PetscInt dim)
{
  MpmRegion region;

  UNIT_CALL(MpmRegionCreate(&options, dim, tolerance, &region));
  return region;
}

static void Destroy(MpmRegion *region)
{
  UNIT_CALL(MpmRegionDestroy(region));
  ck_assert_ptr_null(*region);
  UNIT_CALL(PetscOptionsClear(NULL));
}

static void Refuse(PetscInt dim, const char message[])
{
  MpmRegion region;

  UNIT_FAILS(MpmRegionCreate(&options, dim, tolerance, &region), MPM_ERR_INPUT, message);
}

#define IN(...) \
  ck_assert_msg(MpmRegionContains(region, (const PetscReal[]){__VA_ARGS__}), "(" #__VA_ARGS__ ") is outside")
#define OUT(...) \
  ck_assert_msg(!MpmRegionContains(region, (const PetscReal[]){__VA_ARGS__}), "(" #__VA_ARGS__ ") is inside")

static void CheckBounds(MpmRegion region, PetscInt dim, const PetscReal lower[], const PetscReal upper[])
{
  PetscReal low[3] = {-100., -100., -100.}, high[3] = {100., 100., 100.};

  UNIT_CALL(MpmRegionGetBounds(region, low, high));
  for (PetscInt a = 0; a < dim; a++) {
    ck_assert_double_eq_tol(low[a], lower[a], 5e-6);
    ck_assert_double_eq_tol(high[a], upper[a], 5e-6);
    ck_assert(low[a] <= lower[a] && high[a] >= upper[a]);
  }
}

/* An octant of a sphere; what ends at the clipping and what at the surface itself. */
START_TEST(clipped)
{
  MpmRegion region;

  BLOCK("region", "sphere", "center", "1,1,1", "radius", "2", "clip_lower", "1,1,-1", "clip_upper", "3,3,1");
  region = Create(3);
  IN(1., 1., -1.);
  IN(2., 2., 1.);
  OUT(0.99, 1., 0.);
  OUT(2., 2., 1.01);
  OUT(2.5, 2.5, 0.);
  CheckBounds(region, 3, (const PetscReal[]){1., 1., -1.}, (const PetscReal[]){3., 3., 1.});
  ck_assert(MpmRegionClips(region, (const PetscReal[]){1.1, 1.1, 0.}, 0, 0));
  ck_assert(!MpmRegionClips(region, (const PetscReal[]){1.1, 1.1, -0.9}, 2, 0));
  Destroy(&region);
  BLOCK("region", "polygon", "vertices", "0,0,4,0,0,4", "clip_upper", "1,3");
  region = Create(2);
  IN(1., 2.9);
  OUT(1.1, 1.);
  Destroy(&region);
  BLOCK("region", "sphere", "center", "1,1", "radius", "2", "clip_lower", "1,1", "clip_upper", "2,0");
  Refuse(2, "-mpm_a_clip_upper 0. on axis y: must be >= -mpm_a_clip_lower, which is 1.");
}
END_TEST

START_TEST(everything)
{
  MpmRegion region;

  BLOCK(NULL);
  region = Create(2);
  ck_assert_int_eq(MpmRegionGetType(region), MPM_REGION_ALL);
  IN(1e9, -1e9);
  CheckBounds(region, 2, (const PetscReal[]){-100., -100.}, (const PetscReal[]){100., 100.});
  Destroy(&region);
  BLOCK("region", "file");
  region = Create(3);
  ck_assert_int_eq(MpmRegionGetType(region), MPM_REGION_FILE);
  Destroy(&region);
  BLOCK("lower", "0,0", "upper", "1,1"); /* a box that lost its name must not become everything */
  Refuse(2,
         "-mpm_a_region is missing, but -mpm_a_lower is given: one of box, sphere, cylinder, polygon, layers, outline");
}
END_TEST

START_TEST(box)
{
  MpmRegion region;

  BLOCK("region", "box", "lower", "0,9", "upper", "10, 10");
  region = Create(2);
  ck_assert_int_eq(MpmRegionGetType(region), MPM_REGION_BOX);
  IN(5., 9.5);
  IN(0., 9.);
  IN(10., 10.);
  IN(-0.9e-6, 10. + 1.9e-6); /* within the tolerance of either axis */
  OUT(-1.1e-6, 9.5);
  OUT(5., 10. + 2.1e-6);
  OUT(5., NAN);
  CheckBounds(region, 2, (const PetscReal[]){0., 9.}, (const PetscReal[]){10., 10.});
  Destroy(&region);
  BLOCK("region", "box", "lower", "0,1,0", "upper", "3,1,3"); /* a plane */
  region = Create(3);
  IN(2., 1., 3.);
  IN(2., 1. - 1.9e-6, 3.);
  OUT(2., 1.001, 3.);
  Destroy(&region);
}
END_TEST

START_TEST(box_refuses)
{
  BLOCK("region", "box", "upper", "10,10");
  Refuse(2, "-mpm_a_lower is missing: lower corner (m), 2 values");
  BLOCK("region", "box", "lower", "0,0,0", "upper", "10,10");
  Refuse(2, "-mpm_a_lower 0,0,0: must have 2 values, has 3: lower corner (m), 2 values");
  BLOCK("region", "box", "lower", "0,11", "upper", "10,10.5");
  Refuse(2, "-mpm_a_upper 10.5 on axis y: must be >= -mpm_a_lower, which is 11");
  BLOCK("region", "cube");
  Refuse(2, "-mpm_a_region cube: must be one of all, box, sphere, cylinder, polygon, layers, outline, raster, voxels, "
            "file, columns, depth, hydrograph");
}
END_TEST

START_TEST(sphere)
{
  MpmRegion region;

  BLOCK("region", "sphere", "center", "1,2", "radius", "0.5");
  region = Create(2);
  IN(1., 2.);
  IN(1.3, 2.4);
  IN(1.5 + 0.9e-6, 2.);
  OUT(1.5 + 1.1e-6, 2.);
  IN(1., 2.5 + 1.9e-6);
  OUT(1.4, 2.4);
  CheckBounds(region, 2, (const PetscReal[]){0.5, 1.5}, (const PetscReal[]){1.5, 2.5});
  Destroy(&region);
  BLOCK("region", "sphere", "center", "1,2,3", "radius", "0.5");
  region = Create(3);
  IN(1., 2., 3.5);
  OUT(1.3, 2.3, 3.3);
  Destroy(&region);
  BLOCK("region", "sphere", "center", "1,2", "radius", "0");
  Refuse(2, "-mpm_a_radius 0: must be > 0 m");
  BLOCK("region", "sphere", "radius", "1");
  Refuse(2, "-mpm_a_center is missing: centre (m), 2 values");
}
END_TEST

START_TEST(cylinder)
{
  MpmRegion region;

  BLOCK("region", "cylinder", "point", "1,1,1", "radius", "0.5");
  region = Create(3);
  IN(1.5, 1., -77.);
  OUT(1.4, 1.4, 0.);
  CheckBounds(region, 3, (const PetscReal[]){0.5, 0.5, -100.}, (const PetscReal[]){1.5, 1.5, 100.});
  Destroy(&region);
  BLOCK("region", "cylinder", "point", "0,0,0", "radius", "1", "axis", "-3,0,-4", "length", "10");
  region = Create(3);
  IN(-6., 0., -8.);
  IN(-6. - 0.78, 0., -8. + 0.585); /* the rim of the far end */
  OUT(-6.01, 0., -8.01);
  OUT(0.01, 0., 0.01);
  IN(0., 1., 0.);
  IN(0.78, 0., -0.585);
  CheckBounds(region, 3, (const PetscReal[]){-6.8, -1., -8.6}, (const PetscReal[]){0.8, 1., 0.6});
  Destroy(&region);
  BLOCK("region", "cylinder", "point", "1,1", "radius", "0.5");
  Refuse(2, "-mpm_a_region cylinder: exists in 3 dimensions only; in 2, a sphere is a disc");
  BLOCK("region", "cylinder", "point", "1,1,1", "radius", "0.5", "axis", "0,0,0");
  Refuse(3, "-mpm_a_axis: the direction has no length");
}
END_TEST

START_TEST(polygon)
{
  MpmRegion region;

  BLOCK("region", "polygon", "vertices", "0,0, 4,0, 4,3, 2,1, 0,3"); /* a notch from above, its tip at (2, 1) */
  region = Create(2);
  IN(1., 1.);
  IN(3., 1.); /* level with the notch's tip */
  IN(2., 1.); /* on a vertex */
  IN(2., 0.); /* on an edge */
  IN(0., 0.);
  IN(4., 3.);
  IN(0., 1.5);
  OUT(2., 1.001);
  OUT(2., 2.9);
  OUT(-1., 0.); /* in line with the bottom edge */
  OUT(5., 0.);
  OUT(-1., 1.); /* whose ray meets the tip */
  OUT(-1., 3.);
  OUT(2., 3.);
  IN(2., -1.9e-6);
  OUT(2., -2.1e-6);
  IN(4. + 0.9e-6, 1.);
  OUT(4. + 1.1e-6, 1.);
  CheckBounds(region, 2, (const PetscReal[]){0., 0.}, (const PetscReal[]){4., 3.});
  Destroy(&region);
  BLOCK("region", "polygon", "vertices", "0,0, 1,0, 1,1, 0,0", "lower_z", "2"); /* closed by hand; a prism */
  region = Create(3);
  IN(0.5, 0.2, 50.);
  OUT(0.5, 0.2, 1.9);
  OUT(0.2, 0.5, 50.);
  Destroy(&region);
}
END_TEST

/* Against the even-odd count along another direction, at places no edge comes near. */
START_TEST(polygon_random)
{
  const PetscReal v[] = {0., 0., 5., 1., 9., 0., 8., 4., 9.5, 9., 6., 6., 4., 9., 3., 5., -1., 7., 1., 3.};
  const PetscInt  n   = sizeof(v) / sizeof(v[0]) / 2;
  MpmRegion       region;

  BLOCK("region", "polygon", "vertices", "0,0,5,1,9,0,8,4,9.5,9,6,6,4,9,3,5,-1,7,1,3");
  region = Create(2);
  for (PetscInt k = 0; k < 20000; k++) {
    const PetscReal x[2]  = {-2. + 13. * rand() / RAND_MAX, -2. + 13. * rand() / RAND_MAX};
    PetscReal       turns = 0.;

    for (PetscInt i = 0; i < n; i++) { /* the winding number by angles */
      const PetscReal *a = v + 2 * i, *b = v + 2 * ((i + 1) % n);
      const PetscReal  p[2] = {a[0] - x[0], a[1] - x[1]}, q[2] = {b[0] - x[0], b[1] - x[1]};

      turns += atan2(p[0] * q[1] - p[1] * q[0], p[0] * q[0] + p[1] * q[1]);
    }
    ck_assert_int_eq(MpmRegionContains(region, x), fabs(turns) > 3.);
  }
  Destroy(&region);
}
END_TEST

START_TEST(polygon_refuses)
{
  static const struct {
    const char *vertices, *message;
  } cases[] = {
    {"0,0,1,0,1", "-mpm_a_vertices: has 5 numbers, must have two a vertex"},
    {"0,0,1,0", "-mpm_a_vertices: has 2 vertices, must have 3 at least"},
    {"0,0,1,0,0,0", "-mpm_a_vertices: has 2 vertices, must have 3 at least"},
    {"0,0,1,0,1,0,0,1", "-mpm_a_vertices: vertices 2 and 3 are the same"},
    {"0,0,1,1,2,2", "-mpm_a_vertices: the boundary turns back on itself at vertex 3"},
    {"0,0,2,0,1,0,1,1", "-mpm_a_vertices: the boundary turns back on itself at vertex 2"},
    {"0,0,1,1,1,0,0,1", "-mpm_a_vertices: the edges from vertex 1 and from vertex 3 cross or touch"},
    {"0,0,4,0,4,4,2,0,0,4", "-mpm_a_vertices: the edges from vertex 1 and from vertex 3 cross or touch"},
    {"2,0,0,4,0,0,4,0,4,4", "-mpm_a_vertices: the edges from vertex 1 and from vertex 3 cross or touch"},
    {"0,0,1,x,1,1",
     "-mpm_a_vertices 0,0,1,x,1,1: not a list of numbers: x1,y1,x2,y2,... round the boundary, 3 vertices at least (m)"},
  };

  for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); i++) {
    BLOCK("region", "polygon", "vertices", cases[i].vertices);
    Refuse(2, cases[i].message);
  }
  BLOCK("region", "polygon", "vertices", "0,0,1,0,1,1", "lower_z", "2", "upper_z", "1");
  Refuse(3, "-mpm_a_upper_z: must be >= -mpm_a_lower_z");
}
END_TEST

static PetscErrorCode Silent(MPI_Comm comm, const char format[], ...)
{
  (void)comm, (void)format;
  return PETSC_SUCCESS;
}

/* The surface that cut a lattice near x has this normal and depth. */
static void CheckCut(MpmRegion region, PetscInt dim, const PetscReal x[], const PetscReal normal[], PetscReal depth)
{
  const PetscReal half[3] = {0.05, 0.05, 0.05};
  PetscReal       n[3], d;

  ck_assert_msg(MpmRegionCut(region, x, half, n, &d), "(%g, %g): none", (double)x[0], (double)x[1]);
  for (PetscInt a = 0; a < dim; a++) ck_assert_double_eq_tol(n[a], normal[a], 1e-14);
  ck_assert_double_eq_tol(d, depth, 1e-12);
}

#define NO_CUT(...) \
  ck_assert_msg(!MpmRegionCut(region, (const PetscReal[]){__VA_ARGS__}, (const PetscReal[]){0.05, 0.05, 0.05}, \
                              (PetscReal[3]){0.}, &(PetscReal){0.}), \
                "(" #__VA_ARGS__ ") is at a cut")
#define AT(...) ((const PetscReal[]){__VA_ARGS__})

/* A surface with a step, an interface that it cuts into, and the layer beneath. */
START_TEST(layers)
{
  MpmRegion upper, region;

  BLOCK("region", "layers", "top", "0,10, 4,10, 8,2, 10,2, 10,5", "bottom", "6");
  region = Create(2);
  ck_assert_int_eq(MpmRegionGetType(region), MPM_REGION_LAYERS);
  ck_assert(MpmRegionIsBoundedBelow(region));
  IN(-50., 10.); /* level beyond its ends */
  IN(2., 6.);
  IN(5.9, 6.1);
  OUT(5.9, 6.3);
  OUT(2., 5.99);
  OUT(7., 5.); /* thinned out */
  OUT(20., 5.5);
  CheckBounds(region, 2, (const PetscReal[]){-100., 2.}, (const PetscReal[]){100., 10.});
  upper = region;
  BLOCK("region", "layers", "below", "upper", "bottom", "0");
  region = Create(2);
  UNIT_CALL(MpmRegionSetAbove(region, upper));
  IN(2., 6.);
  OUT(2., 6.01);
  IN(7., 3.99); /* begins at the surface */
  OUT(7., 4.01);
  IN(10. + 0.9e-6, 1.); /* at the step */
  OUT(10. - 1e-5, 4.);
  IN(10. - 0.9e-6, 4.);
  IN(20., 5.);
  OUT(20., -1e-5);
  CheckBounds(region, 2, (const PetscReal[]){-100., 0.}, (const PetscReal[]){100., 6.});
  Destroy(&upper);
  Destroy(&region);
  BLOCK("region", "layers", "top", "0,0, 4,4", "lower_z", "1", "clip_upper", "3,9,2");
  region = Create(3);
  ck_assert(!MpmRegionIsBoundedBelow(region));
  IN(2., -1e9, 1.5);
  OUT(2., 1., 0.9);
  OUT(2., 1., 2.1);
  OUT(3.1, 1., 1.5);
  OUT(2., 2.01, 1.5);
  Destroy(&region);
  BLOCK("region", "layers", "bottom", "1");
  Refuse(2, "-mpm_a_top: is missing, must be a line x0,y0,x1,y1,... or a level");
  BLOCK("region", "layers", "top", "0,1,2");
  Refuse(2, "-mpm_a_top: has 3 numbers, must have two a vertex, or one for a level");
  BLOCK("region", "layers", "top", "0,1,2,1", "bottom", "0,0,4,1,3,0");
  Refuse(2, "-mpm_a_bottom: x of vertex 3 must be >= 4., that of the vertex before");
  BLOCK("region", "layers", "top", "0,1,2,1,2,1");
  Refuse(2, "-mpm_a_top: vertices 2 and 3 are the same");
  BLOCK("region", "layers", "top", "3", "below", "x");
  Refuse(2, "-mpm_a_top: must be absent with -mpm_a_below, which gives the top");
}
END_TEST

START_TEST(cuts)
{
  const PetscReal r = sqrt(0.5);
  MpmRegion       region;

  BLOCK("region", "polygon", "vertices", "0,0, 0,1, 1,0"); /* clockwise */
  region = Create(2);
  CheckCut(region, 2, AT(0.45, 0.5), AT(r, r), 0.05 * r);
  CheckCut(region, 2, AT(0.5, 0.5), AT(r, r), 0.); /* on it */
  CheckCut(region, 2, AT(0.95, 0.01), AT(r, r), 0.04 * r);
  NO_CUT(0.4, 0.45);  /* the next box on either axis is inside as well */
  NO_CUT(0.02, 0.02); /* boxes end at straight edges */
  Destroy(&region);
  BLOCK("region", "layers", "top", "0,1, 1,0", "bottom", "0.2");
  region = Create(2);
  CheckCut(region, 2, AT(0.45, 0.5), AT(r, r), 0.05 * r);
  Destroy(&region);
  BLOCK("region", "polygon", "vertices", "0,0, 2,0, 2,2, 1,1, 0,2"); /* a notch */
  region = Create(2);
  CheckCut(region, 2, AT(0.9, 1.06), AT(r, r), 0.04 * r);
  CheckCut(region, 2, AT(1.1, 1.06), AT(-r, r), 0.04 * r);
  Destroy(&region);
  BLOCK("region", "sphere", "center", "1,1,1", "radius", "0.5");
  region = Create(3);
  CheckCut(region, 3, AT(1., 1., 1.46), AT(0., 0., 1.), 0.04); /* curved, so there are steps beside */
  CheckCut(region, 3, AT(1.42, 0.98, 1.), AT(0.42 / hypot(0.42, 0.02), -0.02 / hypot(0.42, 0.02), 0.),
           0.5 - hypot(0.42, 0.02));
  NO_CUT(1., 1., 1.);
  Destroy(&region);
  BLOCK("region", "cylinder", "point", "0,0,0", "axis", "1,1,0", "radius", "0.5", "length", "2");
  region = Create(3);
  CheckCut(region, 3, AT(0.7, 0.7, 0.45), AT(0., 0., 1.), 0.05);
  CheckCut(region, 3, AT(0.01, 0.01, 0.), AT(-r, -r, 0.), 0.02 * r);
  Destroy(&region);
  BLOCK("region", "box", "lower", "0,0", "upper", "1,1");
  region = Create(2);
  NO_CUT(0.01, 0.5);
  Destroy(&region);
}
END_TEST

/* Sum of the parts in the boxes of a lattice over [0, 4]^dim, and the worst first moment about a place. */
static void CheckParts(PetscInt dim, PetscReal volume, const PetscReal middle[], PetscReal error)
{
  const PetscInt  across = 7, total = dim == 2 ? across * across : across * across * across;
  const PetscReal h      = 4. / (PetscReal)across;
  MpmRegion       region = Create(dim);
  PetscReal       sum = 0., moment[3] = {0., 0., 0.};

  for (PetscInt k = 0; k < total; k++) {
    const PetscInt at[3] = {k % across, k / across % across, k / (across * across)};
    PetscReal      low[3], high[3], centroid[3], part;

    for (PetscInt a = 0; a < 3; a++) {
      low[a]  = h * (PetscReal)at[a];
      high[a] = low[a] + h;
    }
    part = MpmRegionPart(region, low, high, centroid);
    sum += part;
    for (PetscInt a = 0; a < dim && part > 0.; a++) {
      ck_assert(centroid[a] > low[a] - 1e-12 && centroid[a] < high[a] + 1e-12);
      moment[a] += part * centroid[a];
    }
  }
  ck_assert_double_eq_tol(sum, volume, error);
  for (PetscInt a = 0; a < dim; a++) ck_assert_double_eq_tol(moment[a] / sum, middle[a], error);
  Destroy(&region);
}

START_TEST(parts)
{
  BLOCK("region", "sphere", "center", "2.1,1.9", "radius", "1.7");
  CheckParts(2, PETSC_PI * 1.7 * 1.7, AT(2.1, 1.9), 1e-8);
  BLOCK("region", "sphere", "center", "2.1,1.9,2", "radius", "1.7");
  CheckParts(3, 4. / 3. * PETSC_PI * 1.7 * 1.7 * 1.7, AT(2.1, 1.9, 2.), 1e-5);
  BLOCK("region", "cylinder", "point", "0.5,2,1.9", "axis", "2,0,0", "radius", "1.3", "length", "3");
  CheckParts(3, 3. * PETSC_PI * 1.3 * 1.3, AT(2., 2., 1.9), 1e-5);
  BLOCK("region", "cylinder", "point", "1,1,2", "axis", "1,1,0", "radius", "0.9", "length", "2");
  CheckParts(3, 2. * PETSC_PI * 0.9 * 0.9, AT(1. + sqrt(0.5), 1. + sqrt(0.5), 2.), 6e-2);
  BLOCK("region", "polygon", "vertices", "0.3,0.2, 3.3,0.2, 3.3,2.2, 1.8,1.2, 0.3,2.2"); /* a notch: 6 - 1.5 */
  CheckParts(2, 4.5, AT(1.8, (6. * 1.2 - 1.5 * (2.2 - 1. / 3.)) / 4.5), 1e-12);
  BLOCK("region", "box", "lower", "0.3,0.4", "upper", "3.1,2.2", "clip_upper", "2.3,4");
  CheckParts(2, 2. * 1.8, AT(1.3, 1.3), 1e-12);
  BLOCK("region", "layers", "top", "0,3, 1,3, 3,1, 3,2, 4,2", "bottom", "1", "lower_z", "1", "upper_z", "2.5");
  CheckParts(3, 1.5 * (2. + 2. + 1.),
             AT((2. * 0.5 + 2. * (1. + 2. / 3.) + 3.5) / 5., (2. * 2. + 2. * (1. + 2. / 3.) + 1.5) / 5., 1.75), 1e-12);
}
END_TEST

/* With -help a block may be incomplete: the manual is printed to the end. */
START_TEST(incomplete_with_help)
{
  static const char *const types[]                           = {"all", "box", "sphere", "cylinder", "polygon", "file"};
  PetscErrorCode (*const print)(MPI_Comm, const char[], ...) = PetscHelpPrintf;

  PetscHelpPrintf = Silent;
  for (size_t i = 0; i < sizeof(types) / sizeof(types[0]); i++) {
    MpmRegion region;

    BLOCK("region", types[i], "lower", "1,1,1");
    UNIT_CALL(PetscOptionsInsertString(NULL, "-help"));
    if (i == 0) UNIT_CALL(PetscOptionsClearValue(NULL, "-mpm_a_lower"));
    region = Create(3);
    (void)MpmRegionContains(region, (const PetscReal[]){1., 1., 1.});
    UNIT_CALL(PetscOptionsClearValue(NULL, "-help"));
    Destroy(&region);
  }
  PetscHelpPrintf = print;
}
END_TEST

/* ------------------------------------------------------------------------------------------------------------ ramps */

static void CheckRamp(const char text[], PetscInt count, const PetscReal time[], const PetscReal factor[])
{
  MpmRamp ramp;

  BLOCK("ramp", text);
  UNIT_CALL(MpmRampCreate(&options, "ramp", "0:0,1:1", &ramp));
  for (PetscInt i = 0; i < count; i++) ck_assert_double_eq_tol(MpmRampEvaluate(ramp, time[i]), factor[i], 1e-15);
  UNIT_CALL(MpmRampDestroy(&ramp));
  ck_assert_ptr_null(ramp);
}

START_TEST(ramps)
{
  MpmRamp ramp;

  CheckRamp("0:0,1:1", 5, (const PetscReal[]){-1., 0., 0.25, 1., 2.}, (const PetscReal[]){0., 0., 0.25, 1., 1.});
  CheckRamp(" 1 : -2 , 3 : 2e0 ", 4, (const PetscReal[]){0., 1., 2., 9.}, (const PetscReal[]){-2., -2., 0., 2.});
  CheckRamp("5:7", 3, (const PetscReal[]){0., 5., 9.}, (const PetscReal[]){7., 7., 7.});
  /* a jump: the later value at the time itself */
  CheckRamp("0:0,1:0,1:1,2:3", 4, (const PetscReal[]){1. - 1e-9, 1., 1.5, 2.}, (const PetscReal[]){0., 1., 2., 3.});
  CheckRamp("0:0,0:1", 2, (const PetscReal[]){-1e-9, 0.}, (const PetscReal[]){0., 1.});
  BLOCK(NULL);
  UNIT_CALL(MpmRampCreate(&options, "ramp", "0:1", &ramp));
  ck_assert_double_eq(MpmRampEvaluate(ramp, 0.5), 1.);
  UNIT_CALL(MpmRampDestroy(&ramp));
}
END_TEST

/* Integrals from 0 on, slopes from the left; a factor that begins before 0, one with a jump, one that ends. */
START_TEST(ramps_integrated)
{
  MpmRamp ramp;

  BLOCK("ramp", "0:0,2:4,2:-1,3:-1,4:0");
  UNIT_CALL(MpmRampCreate(&options, "ramp", "0:1", &ramp));
  ck_assert_double_eq(MpmRampIntegral(ramp, 1., 0), 2.);
  ck_assert_double_eq_tol(MpmRampIntegral(ramp, 1., 1), 1., 1e-15);
  ck_assert_double_eq_tol(MpmRampIntegral(ramp, 2., 1), 4., 1e-15);
  ck_assert_double_eq_tol(MpmRampIntegral(ramp, 4., 1), 2.5, 1e-15);
  ck_assert_double_eq_tol(MpmRampIntegral(ramp, 9., 1), 2.5, 1e-15);
  ck_assert_double_eq_tol(MpmRampIntegral(ramp, 1., 2), 1. / 3., 1e-15);
  ck_assert_double_eq_tol(MpmRampIntegral(ramp, 2., 2), 8. / 3., 1e-15);
  ck_assert_double_eq_tol(MpmRampIntegral(ramp, 3., 2), 8. / 3. + 3.5, 1e-14);
  ck_assert_double_eq_tol(MpmRampIntegral(ramp, 4., 2), 8. / 3. + 3.5 + 3. - 1. / 3., 1e-14);
  ck_assert_double_eq_tol(MpmRampIntegral(ramp, 6., 2), 8. / 3. + 6.5 - 1. / 3. + 5., 1e-14);
  ck_assert_double_eq(MpmRampIntegral(ramp, 2., -1), 2.);
  ck_assert_double_eq(MpmRampIntegral(ramp, 2.5, -1), 0.);
  ck_assert_double_eq(MpmRampIntegral(ramp, 4., -1), 1.);
  ck_assert_double_eq(MpmRampIntegral(ramp, 0., -1), 0.);
  ck_assert_double_eq(MpmRampIntegral(ramp, 1., -2), 0.);
  UNIT_CALL(MpmRampDestroy(&ramp));
  BLOCK("ramp", "-2:1,2:3");
  UNIT_CALL(MpmRampCreate(&options, "ramp", "0:1", &ramp));
  ck_assert_double_eq_tol(MpmRampIntegral(ramp, 0., 1), 0., 1e-15);
  ck_assert_double_eq_tol(MpmRampIntegral(ramp, 2., 1), 5., 1e-14);
  ck_assert_double_eq_tol(MpmRampIntegral(ramp, 2., 2), 4. + 2. / 3., 1e-14);
  ck_assert_double_eq_tol(MpmRampIntegral(ramp, -1., 1), -1.75, 1e-14);
  UNIT_CALL(MpmRampDestroy(&ramp));
}
END_TEST

START_TEST(ramps_refused)
{
  static const struct {
    const char *text, *message;
  } cases[] = {
    {"1", "-mpm_a_ramp 1: must be time:factor pairs, separated by commas"},
    {"0:0,", "-mpm_a_ramp 0:0,: must be time:factor pairs, separated by commas"},
    {"0:x", "-mpm_a_ramp 0:x: must be time:factor pairs of numbers"},
    {"0:1:2", "-mpm_a_ramp 0:1:2: must be time:factor pairs of numbers"},
    {"0:0,2:1,1:0", "-mpm_a_ramp 0:0,2:1,1:0: times must not decrease"},
    {"0:inf", "-mpm_a_ramp 0:inf: must be time:factor pairs of numbers"},
  };
  MpmRamp ramp;

  for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); i++) {
    BLOCK("ramp", cases[i].text);
    UNIT_FAILS(MpmRampCreate(&options, "ramp", "0:1", &ramp), MPM_ERR_INPUT, cases[i].message);
    ck_assert_ptr_null(ramp);
  }
}
END_TEST

int main(int argc, char **argv)
{
  const TTest *const tests[] = {everything,
                                clipped,
                                box,
                                box_refuses,
                                sphere,
                                cylinder,
                                polygon,
                                polygon_random,
                                polygon_refuses,
                                layers,
                                cuts,
                                parts,
                                incomplete_with_help,
                                ramps,
                                ramps_integrated,
                                ramps_refused};

  return UnitRun(&argc, &argv, "region", sizeof(tests) / sizeof(tests[0]), tests);
}

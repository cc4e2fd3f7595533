/*
  Triangulated surfaces: distances against all triangles one by one, their sides against solid angles, and what is no
  closed surface.
*/
#include "geometry/solid.h"
#include "geometry/triangles.h"
#include "files/stl_file.h"
#include "options/options.h"
#include "unit.h"

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <unistd.h>

#define MOST 8192

/* Triangles, nine coordinates each. */
static struct {
  PetscInt  count;
  PetscReal x[9 * MOST];
} mesh;

static PetscReal Random(PetscReal lower, PetscReal upper)
{
  return lower + (upper - lower) * ((PetscReal)rand() / RAND_MAX);
}

static void Add(const PetscReal a[], const PetscReal b[], const PetscReal c[])
{
  ck_assert(mesh.count < MOST);
  for (PetscInt k = 0; k < 3; k++) {
    mesh.x[9 * mesh.count + k]     = a[k];
    mesh.x[9 * mesh.count + 3 + k] = b[k];
    mesh.x[9 * mesh.count + 6 + k] = c[k];
  }
  mesh.count++;
}

/* Faces of n x n squares of two triangles each; `turn` 1: outside out, -1: inside out. */
static void AddBox(const PetscReal lower[], const PetscReal upper[], PetscInt n, PetscInt turn)
{
  for (PetscInt face = 0; face < 6; face++) {
    const PetscInt a = face / 2, out = (face % 2 ? 1 : -1) * turn, b = out > 0 ? (a + 1) % 3 : (a + 2) % 3,
                   c = 3 - a - b;

    for (PetscInt k = 0; k < n * n; k++) {
      PetscReal corner[4][3];

      for (PetscInt v = 0; v < 4; v++) {
        const PetscInt i = k % n + (v == 1 || v == 2), j = k / n + (v > 1);

        corner[v][a] = face % 2 ? upper[a] : lower[a];
        corner[v][b] = i == n ? upper[b] : lower[b] + (upper[b] - lower[b]) * (PetscReal)i / (PetscReal)n;
        corner[v][c] = j == n ? upper[c] : lower[c] + (upper[c] - lower[c]) * (PetscReal)j / (PetscReal)n;
      }
      Add(corner[0], corner[1], corner[2]);
      Add(corner[0], corner[2], corner[3]);
    }
  }
}

static void TorusPoint(PetscInt i, PetscInt j, PetscInt n, PetscReal x[3])
{
  const PetscReal u = 2. * PETSC_PI * (PetscReal)(i % n) / (PetscReal)n,
                  v = 2. * PETSC_PI * (PetscReal)(j % n) / (PetscReal)n;

  x[0] = (0.7 + 0.25 * PetscCosReal(v)) * PetscCosReal(u);
  x[1] = (0.7 + 0.25 * PetscCosReal(v)) * PetscSinReal(u);
  x[2] = 0.25 * PetscSinReal(v) + 0.2 * PetscSinReal(3. * u);
}

static void MakeTorus(PetscInt n)
{
  mesh.count = 0;
  for (PetscInt i = 0; i < n; i++)
    for (PetscInt j = 0; j < n; j++) {
      PetscReal a[3], b[3], c[3], d[3];

      TorusPoint(i, j, n, a);
      TorusPoint(i + 1, j, n, b);
      TorusPoint(i + 1, j + 1, n, c);
      TorusPoint(i, j + 1, n, d);
      Add(a, b, c);
      Add(a, c, d);
    }
}

/* A prism of this polygon, which is not convex, cut into triangles by hand. */
static void MakeEll(void)
{
  static const PetscReal v[6][2]   = {{-1., -1.}, {1., -1.}, {1., 0.}, {0., 0.}, {0., 1.}, {-1., 1.}};
  static const PetscInt  cut[4][3] = {{0, 1, 2}, {0, 2, 3}, {0, 3, 5}, {3, 4, 5}};

  mesh.count = 0;
  for (PetscInt k = 0; k < 4; k++) {
    PetscReal x[2][3][3];

    for (PetscInt s = 0; s < 2; s++)
      for (PetscInt c = 0; c < 3; c++) {
        for (PetscInt a = 0; a < 2; a++) x[s][c][a] = v[cut[k][c]][a];
        x[s][c][2] = s ? 0.5 : -0.5;
      }
    Add(x[1][0], x[1][1], x[1][2]);
    Add(x[0][0], x[0][2], x[0][1]);
  }
  for (PetscInt k = 0; k < 6; k++) {
    const PetscReal *p = v[k], *q = v[(k + 1) % 6];
    const PetscReal  x[4][3] = {{p[0], p[1], -0.5}, {q[0], q[1], -0.5}, {q[0], q[1], 0.5}, {p[0], p[1], 0.5}};

    Add(x[0], x[1], x[2]);
    Add(x[0], x[2], x[3]);
  }
}

static MpmTriangles Create(void)
{
  char         message[MPM_TRIANGLES_MESSAGE] = "";
  MpmTriangles triangles;

  UNIT_CALL(MpmTrianglesCreate(mesh.count, mesh.x, &triangles, message));
  ck_assert_str_eq(message, "");
  ck_assert_ptr_nonnull(triangles);
  return triangles;
}

/* ---- one by one ---- */

static PetscReal Dot(const PetscReal a[], const PetscReal b[])
{
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Distance from a triangle: the least of f = |x - p - s e - t g|^2 over s, t >= 0, s + t <= 1. */
static PetscReal TriangleDistance(const PetscReal *v, const PetscReal x[])
{
  PetscReal e[3], g[3], r[3], best = PETSC_INFINITY;

  for (PetscInt a = 0; a < 3; a++) {
    e[a] = v[3 + a] - v[a];
    g[a] = v[6 + a] - v[a];
    r[a] = x[a] - v[a];
  }
  const PetscReal ee = Dot(e, e), eg = Dot(e, g), gg = Dot(g, g), re = Dot(r, e), rg = Dot(r, g),
                  det    = ee * gg - eg * eg;
  const PetscReal free_s = (re * gg - rg * eg) / det, free_t = (rg * ee - re * eg) / det;
  const PetscReal along       = PetscMin(1., PetscMax(0., (rg - re - eg + ee) / (ee - 2. * eg + gg)));
  const PetscReal trial[4][2] = {{PetscMin(1., PetscMax(0., re / ee)), 0.},
                                 {0., PetscMin(1., PetscMax(0., rg / gg))},
                                 {1. - along, along},
                                 {free_s, free_t}};

  for (PetscInt k = 0; k < (free_s > 0. && free_t > 0. && free_s + free_t < 1. ? 4 : 3); k++) {
    PetscReal square = 0.;

    for (PetscInt a = 0; a < 3; a++) square += PetscSqr(r[a] - trial[k][0] * e[a] - trial[k][1] * g[a]);
    best = PetscMin(best, square);
  }
  return PetscSqrtReal(best);
}

/* How often the surface winds about x. */
static PetscReal Winding(const PetscReal x[])
{
  PetscReal sum = 0.;

  for (PetscInt t = 0; t < mesh.count; t++) {
    PetscReal r[3][3], l[3];

    for (PetscInt k = 0; k < 3; k++) {
      for (PetscInt a = 0; a < 3; a++) r[k][a] = mesh.x[9 * t + 3 * k + a] - x[a];
      l[k] = PetscSqrtReal(Dot(r[k], r[k]));
    }
    const PetscReal det = r[0][0] * (r[1][1] * r[2][2] - r[1][2] * r[2][1]) -
                          r[0][1] * (r[1][0] * r[2][2] - r[1][2] * r[2][0]) +
                          r[0][2] * (r[1][0] * r[2][1] - r[1][1] * r[2][0]);

    sum +=
      2. * atan2(det, l[0] * l[1] * l[2] + Dot(r[0], r[1]) * l[2] + Dot(r[1], r[2]) * l[0] + Dot(r[2], r[0]) * l[1]);
  }
  return sum / (4. * PETSC_PI);
}

static void CheckBrute(MpmTriangles triangles, const PetscReal x[])
{
  PetscReal  best = PETSC_INFINITY, square = 0.;
  MpmSurface surface;

  for (PetscInt t = 0; t < mesh.count; t++) best = PetscMin(best, TriangleDistance(&mesh.x[9 * t], x));
  MpmTrianglesDistance(triangles, x, &surface);
  ck_assert_double_eq_tol(PetscAbsReal(surface.distance), best, 1e-14 * (1. + PetscAbsReal(x[0])));
  if (best > 1e-9) ck_assert_int_eq(surface.distance<0., Winding(x)> 0.5);
  for (PetscInt a = 0; a < 3; a++) {
    square += PetscSqr(surface.normal[a]);
    for (PetscInt b = 0; b < 3; b++)
      ck_assert(PetscAbsReal(surface.second[a][b] - surface.second[b][a]) * best <= 1e-14);
  }
  ck_assert_double_eq_tol(square, 1., 1e-13);
}

/* Everywhere, far away, and at hostile places: vertices, edges and faces, in planes and along normals through them. */
static void CheckDistances(PetscReal reach)
{
  MpmTriangles triangles = Create();
  PetscInt     inside    = 0;

  for (PetscInt k = 0; k < 600; k++) {
    const PetscReal size = k % 20 ? reach : 1e4 * reach;
    const PetscReal x[3] = {Random(-size, size), Random(-size, size), Random(-size, size)};
    MpmSurface      surface;

    CheckBrute(triangles, x);
    MpmTrianglesDistance(triangles, x, &surface);
    inside += surface.distance < 0. ? 1 : 0;
  }
  ck_assert_msg(inside > 10, "%d places are inside", (int)inside);
  for (PetscInt k = 0; k < 200; k++) {
    const PetscReal *v = &mesh.x[9 * (rand() % mesh.count)], s = Random(0., 1.), off = k % 2 ? Random(-0.3, 0.3) : 0.;
    PetscReal        x[3], y[3];

    CheckBrute(triangles, v);
    for (PetscInt a = 0; a < 3; a++) x[a] = 0.5 * (v[a] + v[3 + a]);
    CheckBrute(triangles, x);
    for (PetscInt a = 0; a < 3; a++) x[a] = (1. - s) * v[a] + s * v[3 + a];
    CheckBrute(triangles, x);
    for (PetscInt a = 0; a < 3; a++) x[a] = (v[a] + v[3 + a] + v[6 + a]) / 3.;
    CheckBrute(triangles, x);
    for (PetscInt b = 0; b < 3; b++) {
      for (PetscInt a = 0; a < 3; a++) y[a] = v[a] + (a == b ? off : 0.);
      CheckBrute(triangles, y);
      for (PetscInt a = 0; a < 3; a++) y[a] = 0.5 * (v[a] + v[3 + a]) + (a == b ? off : 0.);
      CheckBrute(triangles, y);
    }
  }
  UNIT_CALL(MpmTrianglesDestroy(&triangles));
  ck_assert_ptr_null(triangles);
}

START_TEST(against_all)
{
  const PetscReal lower[3] = {-0.5, -0.3, -0.8}, upper[3] = {0.5, 0.9, 0.4},
                  hole[2][3] = {{-0.2, 0., -0.5}, {0.3, 0.5, 0.2}};

  MakeTorus(40);
  CheckDistances(1.2);
  MakeEll();
  CheckDistances(1.5);
  mesh.count = 0;
  AddBox(lower, upper, 3, 1);
  AddBox(hole[0], hole[1], 2, -1); /* a cavity */
  CheckDistances(1.2);
}
END_TEST

/* Far from the origin single precision has no digits left. */
START_TEST(far_from_origin)
{
  const PetscReal lower[3] = {1e8, -1e8, 1.}, upper[3] = {1e8 + 1., -1e8 + 2., 2.};
  MpmTriangles    triangles;
  MpmSurface      surface;

  mesh.count = 0;
  AddBox(lower, upper, 4, 1);
  triangles = Create();
  for (PetscInt k = 0; k < 200; k++) {
    const PetscReal at[3] = {1e8 + Random(0.2, 0.8), -1e8 + Random(0.2, 1.8), 2. + Random(0., 0.01)};

    MpmTrianglesDistance(triangles, at, &surface);
    ck_assert_double_eq_tol(surface.distance, at[2] - 2., 1e-14);
    ck_assert(surface.normal[2] == 1. && surface.second[0][0] == 0.);
  }
  UNIT_CALL(MpmTrianglesDestroy(&triangles));
}
END_TEST

START_TEST(no_place)
{
  MpmTriangles triangles;
  MpmSurface   surface;

  MakeEll();
  triangles = Create();
  MpmTrianglesDistance(triangles, (const PetscReal[]){0., NAN, 0.}, &surface);
  ck_assert(PetscIsInfOrNanReal(surface.distance));
  MpmTrianglesDistance(triangles, (const PetscReal[]){INFINITY, 0., 0.}, &surface);
  ck_assert(PetscIsInfOrNanReal(surface.distance));
  UNIT_CALL(MpmTrianglesDestroy(&triangles));
}
END_TEST

/* ---- derivatives ---- */

/* A box of triangles, however they are cut, is a box: distance, gradient and second derivative. */
START_TEST(box_of_triangles)
{
  const MpmOptions options  = {PETSC_COMM_WORLD, "mpm_a_", NULL};
  const PetscReal  lower[3] = {-0.5, -0.25, -0.75}, upper[3] = {0.5, 1., 0.5};
  MpmSolid         box = {.dim = 0};
  MpmTriangles     triangles;

  UNIT_CALL(PetscOptionsClear(NULL));
  UNIT_CALL(PetscOptionsInsertString(NULL, "-mpm_a_type box -mpm_a_lower -0.5,-0.25,-0.75 -mpm_a_upper 0.5,1,0.5"));
  UNIT_CALL(MpmSolidRead(&options, 3, &box));
  UNIT_CALL(PetscOptionsClear(NULL));
  mesh.count = 0;
  AddBox(lower, upper, 4, 1);
  triangles = Create();
  for (PetscInt k = 0; k < 3000; k++) {
    const PetscBool lattice = (PetscBool)(k % 2); /* above vertices and edges of the cut */
    PetscReal       x[3];
    MpmSurface      one, other;

    for (PetscInt a = 0; a < 3; a++) x[a] = lattice ? (PetscReal)(rand() % 33 - 16) / 8. + 0.0625 : Random(-1.5, 1.5);
    if (lattice) x[k / 2 % 3] -= 0.0625;
    MpmSolidDistance(&box, 0., x, &one);
    MpmTrianglesDistance(triangles, x, &other);
    ck_assert_double_eq_tol(one.distance, other.distance, 1e-14);
    if (one.distance <= 0.) continue; /* inside, faces may be equally far */
    for (PetscInt a = 0; a < 3; a++) {
      ck_assert_double_eq_tol(one.normal[a], other.normal[a], 1e-12);
      for (PetscInt b = 0; b < 3; b++) ck_assert_double_eq_tol(one.second[a][b], other.second[a][b], 1e-10);
    }
  }
  UNIT_CALL(MpmTrianglesDestroy(&triangles));
}
END_TEST

static void CheckDifferences(MpmTriangles triangles, const PetscReal x[], PetscInt *smooth)
{
  const PetscReal e = 1e-6;
  MpmSurface      at, side[3][2];
  PetscReal       bend = 0.;

  MpmTrianglesDistance(triangles, x, &at);
  for (PetscInt k = 0; k < 6; k++) {
    PetscReal near[3] = {x[0], x[1], x[2]};

    near[k / 2] += k % 2 ? e : -e;
    MpmTrianglesDistance(triangles, near, &side[k / 2][k % 2]);
    for (PetscInt a = 0; a < 9; a++)
      bend += PetscAbsReal(side[k / 2][k % 2].second[a / 3][a % 3] - at.second[a / 3][a % 3]);
    for (PetscInt a = 0; a < 3; a++) bend += 100. * PetscAbsReal(side[k / 2][k % 2].normal[a] - at.normal[a]);
  }
  if (bend > 0.1) return; /* a kink */
  (*smooth)++;
  for (PetscInt a = 0; a < 3; a++) {
    ck_assert_double_eq_tol((side[a][1].distance - side[a][0].distance) / (2. * e), at.normal[a], 1e-8);
    for (PetscInt b = 0; b < 3; b++)
      ck_assert_double_eq_tol((side[a][1].normal[b] - side[a][0].normal[b]) / (2. * e), at.second[a][b], 1e-5);
  }
}

START_TEST(derivatives)
{
  MpmTriangles triangles;
  PetscInt     smooth = 0;

  MakeTorus(12);
  triangles = Create();
  for (PetscInt k = 0; k < 2000; k++)
    CheckDifferences(triangles, (const PetscReal[]){Random(-1.2, 1.2), Random(-1.2, 1.2), Random(-1.2, 1.2)}, &smooth);
  ck_assert_msg(smooth > 1900, "%d places are smooth", (int)smooth);
  UNIT_CALL(MpmTrianglesDestroy(&triangles));
}
END_TEST

START_TEST(centroids)
{
  PetscReal    middle[3];
  MpmTriangles triangles;

  MakeEll();
  triangles = Create();
  MpmTrianglesCentroid(triangles, middle);
  ck_assert_double_eq_tol(middle[0], -1. / 6., 1e-15);
  ck_assert_double_eq_tol(middle[1], -1. / 6., 1e-15);
  ck_assert_double_eq_tol(middle[2], 0., 1e-15);
  UNIT_CALL(MpmTrianglesDestroy(&triangles));
}
END_TEST

/* ---- refused ---- */

static void Refuse(const char expected[])
{
  char         message[MPM_TRIANGLES_MESSAGE] = "";
  MpmTriangles triangles;

  UNIT_CALL(MpmTrianglesCreate(mesh.count, mesh.x, &triangles, message));
  ck_assert_str_eq(message, expected);
  ck_assert_ptr_null(triangles);
}

static const PetscReal unit_lower[3] = {0., 0., 0.}, unit_upper[3] = {1., 1., 1.};

static void MakeUnit(void)
{
  mesh.count = 0;
  AddBox(unit_lower, unit_upper, 1, 1);
}

/* Its last triangle is (0, 0, 1), (1, 1, 1), (0, 1, 1). */
START_TEST(refusals)
{
  PetscReal corner[3];

  MakeUnit();
  mesh.count--;
  Refuse("the surface is open: the edge from (0, 0, 1) to (0, 1, 1) belongs to triangle 1 alone");
  MakeUnit();
  memcpy(corner, &mesh.x[9 * 11], sizeof(corner));
  memcpy(&mesh.x[9 * 11], &mesh.x[9 * 11 + 3], sizeof(corner));
  memcpy(&mesh.x[9 * 11 + 3], corner, sizeof(corner));
  Refuse("triangles 1 and 12 disagree about the outside: both pass the edge from (0, 0, 1) to (0, 1, 1) in the same "
         "direction, so one is inverted");
  MakeUnit();
  for (PetscInt a = 0; a < 3; a++) mesh.x[9 * 11 + 3 + a] = 0.5 * (mesh.x[9 * 11 + a] + mesh.x[9 * 11 + 6 + a]);
  Refuse("triangle 12, at (0, 0, 1), has no area");
  MakeUnit();
  AddBox(unit_upper, (const PetscReal[]){2., 2., 2.}, 1, 1);
  Refuse("two parts of the surface touch at the vertex (1, 1, 1), of triangle 3");
  MakeUnit();
  AddBox((const PetscReal[]){1., 1., 0.}, (const PetscReal[]){2., 2., 1.}, 1, 1);
  Refuse("the edge from (1, 1, 0) to (1, 1, 1) belongs to 4 triangles, 3 and 8 among them, where a surface has two");
}
END_TEST

START_TEST(inside_out)
{
  mesh.count = 0;
  AddBox(unit_lower, unit_upper, 2, -1);
  Refuse("the part with triangle 1, at (0, 0, 0), is inverted: its triangles look inwards");
  MakeUnit();
  AddBox((const PetscReal[]){0.2, 0.2, 0.2}, (const PetscReal[]){0.5, 0.5, 0.5}, 1, 1);
  Refuse("the part with triangle 13, at (0.2, 0.2, 0.2), lies within another part");
  MakeUnit();
  AddBox((const PetscReal[]){3., 0.2, 0.2}, (const PetscReal[]){4., 0.5, 0.5}, 1, -1);
  Refuse("the part with triangle 17, at (3, 0.2, 0.2), is inverted: its triangles look inwards");
}
END_TEST

/* ---- files ---- */

static const char path[] = "test_triangles.stl";

static void WriteBinary(const char header[], PetscInt told)
{
  char   start[80]  = "";
  FILE  *file       = fopen(path, "wb");
  float  number[12] = {0.f};
  size_t done;

  ck_assert_ptr_nonnull(file);
  snprintf(start, sizeof(start), "%s", header);
  done = fwrite(start, 1, 80, file);
  done += fwrite(&(uint32_t){(uint32_t)told}, 4, 1, file);
  for (PetscInt t = 0; t < mesh.count; t++) {
    for (PetscInt k = 0; k < 9; k++) number[3 + k] = (float)mesh.x[9 * t + k];
    done += fwrite(number, 4, 12, file);
    done += fwrite("\0", 1, 2, file);
  }
  ck_assert_uint_eq(done, 81 + 14 * (size_t)mesh.count);
  ck_assert_int_eq(fclose(file), 0);
}

static void WriteText(const char text[])
{
  FILE *file = fopen(path, "wb");

  ck_assert_ptr_nonnull(file);
  ck_assert_int_ge(fputs(text, file), 0);
  ck_assert_int_eq(fclose(file), 0);
}

static void WriteAscii(void)
{
  FILE *file = fopen(path, "wb");

  ck_assert_ptr_nonnull(file);
  fprintf(file, "solid a vertex of facets\r\n");
  for (PetscInt t = 0; t < mesh.count; t++) {
    fprintf(file, " facet normal 0 0 1\n  outer loop\r\n");
    for (PetscInt k = 0; k < 3; k++)
      fprintf(file, "\tVERTEX %.17g %.17g %.17g \n", (double)mesh.x[9 * t + 3 * k], (double)mesh.x[9 * t + 3 * k + 1],
              (double)mesh.x[9 * t + 3 * k + 2]);
    fprintf(file, "  endloop\n endfacet\n\n");
  }
  fprintf(file, "endsolid");
  ck_assert_int_eq(fclose(file), 0);
}

static void CheckFile(PetscReal tolerance)
{
  char       message[MPM_STL_MESSAGE] = "";
  PetscInt   count;
  PetscReal *corners;

  UNIT_CALL(MpmStlRead(path, &count, &corners, message));
  ck_assert_str_eq(message, "");
  ck_assert_int_eq(count, mesh.count);
  for (PetscInt k = 0; k < 9 * count; k++)
    ck_assert(PetscAbsReal(corners[k] - mesh.x[k]) <= tolerance * PetscAbsReal(mesh.x[k]));
  UNIT_CALL(PetscFree(corners));
}

static void RefuseFile(const char expected[])
{
  char       message[MPM_STL_MESSAGE] = "";
  PetscInt   count;
  PetscReal *corners;

  UNIT_CALL(MpmStlRead(path, &count, &corners, message));
  ck_assert_str_eq(message, expected);
  UNIT_CALL(PetscFree(corners));
}

START_TEST(files)
{
  MakeTorus(9);
  WriteBinary("a torus", mesh.count);
  CheckFile(1e-7);
  WriteBinary("solid, says this binary file", mesh.count);
  CheckFile(1e-7);
  WriteAscii();
  CheckFile(0.);
  WriteBinary("a torus", mesh.count + 1);
  RefuseFile(
    "is no STL file: it does not begin with 'solid', and its 8184 bytes are not the 8234 of a binary one with 163 "
    "triangles");
  WriteText("");
  RefuseFile("is no STL file: it does not begin with 'solid', and its 0 bytes are not the 84 of a binary one with 0 "
             "triangles");
  WriteText("solid nothing\nendsolid nothing\n");
  RefuseFile("has no triangles");
  mesh.count = 0;
  WriteBinary("nothing", 0);
  RefuseFile("has no triangles");
  WriteText("solid\nfacet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 1 0 zero\n");
  RefuseFile("line 5, 'vertex 1 0 zero', is not what an ASCII STL file has there");
  WriteText("solid\nfacet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nendloop\nendfacet\n");
  RefuseFile("line 7, 'endfacet', is not what an ASCII STL file has there");
  WriteText("solid\nfacet\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nvertex 0 0 1\n");
  RefuseFile("line 6, 'vertex 0 0 1', is not what an ASCII STL file has there");
  WriteText("solid\nfacet\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 inf\n");
  RefuseFile("line 5, 'vertex 0 1 inf', is not what an ASCII STL file has there");
  WriteText("solid\nfacet normal 0 0 0\nouter loop\nvertex 0 0 0");
  RefuseFile("ends within triangle 1");
  mesh.count = 1;
  for (PetscInt k = 0; k < 9; k++) mesh.x[k] = k == 4 ? NAN : (PetscReal)k;
  WriteBinary("not a number", 1);
  RefuseFile("a corner of triangle 1 is no finite number");
  ck_assert_int_eq(unlink(path), 0);
  RefuseFile("cannot be read: No such file or directory");
}
END_TEST

int main(int argc, char **argv)
{
  const TTest *const tests[]        = {refusals, inside_out,       files,       against_all, far_from_origin,
                                       no_place, box_of_triangles, derivatives, centroids};
  const size_t       without_search = 3, count = sizeof(tests) / sizeof(tests[0]);

  return UnitRun(&argc, &argv, "triangles", MpmTrianglesSupported() ? count : without_search, tests);
}

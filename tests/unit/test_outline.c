/*
  Outlines from GeoJSON: parts, holes, attributes, and texts that are none.
*/
#include "maps/map.h"
#include "maps/outline.h"
#include "unit.h"

#include <math.h>
#include <unistd.h>

static char path[] = "/tmp/test_outline_XXXXXX";

static void Write(const char *text)
{
  FILE *file = fopen(path, "w");

  ck_assert_ptr_nonnull(file);
  ck_assert_int_ge(fputs(text, file), 0);
  ck_assert_int_eq(fclose(file), 0);
}

static void Read(const char *text, MpmOutline *outline, char message[])
{
  *outline   = (MpmOutline){0};
  message[0] = '\0';
  Write(text);
  UNIT_CALL(MpmOutlineRead(path, &(MpmOutlineAsk){.origin = {100., 200.}}, outline, message));
}

START_TEST(features)
{
  MpmOutline outline;
  PetscReal  number, lower[2], upper[2];
  char       message[MPM_MAP_MESSAGE];

  Read(
    "{\"type\": \"FeatureCollection\", \"features\": [\n"
    "\t{\"type\": \"Feature\", \"properties\": {\"depth\": 2.5, \"name\": \"K\\u00e4s\\\"e\", \"none\": null},\n"
    "  \"geometry\": {\"type\": \"Polygon\", \"coordinates\": [[[100,200],[100,210],[110,210,5],[110,200],[100,200]],"
    " [[102,202],[104,202],[104,204],[102,204],[102,202]]]}},\n"
    " {\"type\": \"Feature\", \"properties\": null, \"geometry\": null},\n"
    " {\"type\": \"Feature\", \"properties\": {\"depth\": \"3\", \"id\": true}, \"geometry\": {\"type\": "
    "\"MultiPolygon\", \"coordinates\": [[[[120,200],[130,200],[125,205],[120,200]]], "
    "[[[120,220],[130,220],[125,225]]]]}},\n"
    " {\"type\": \"Feature\", \"properties\": {}, \"geometry\": {\"type\": \"LineString\", \"coordinates\": "
    "[[0,0],[1e2,5]]}}]}",
    &outline, message);
  ck_assert_str_eq(message, "");
  ck_assert_int_eq(outline.features, 3);
  ck_assert_int_eq(outline.paths, 5);
  ck_assert(MpmOutlineNumber(&outline, 0, "depth", &number) && number == 2.5);
  ck_assert(MpmOutlineNumber(&outline, 1, "depth", &number) && number == 3.);
  ck_assert(!MpmOutlineNumber(&outline, 2, "depth", &number) && !MpmOutlineNumber(&outline, 0, "name", &number));
  ck_assert_str_eq(MpmOutlineText(&outline, 0, "name"), "K\xc3\xa4s\"e");
  ck_assert_str_eq(MpmOutlineText(&outline, 1, "id"), "true");
  ck_assert_ptr_null(MpmOutlineText(&outline, 0, "none"));
  ck_assert(MpmOutlineHolds(&outline, -1, (PetscReal[]){1., 1.}) &&
            !MpmOutlineHolds(&outline, 1, (PetscReal[]){1., 1.}));
  ck_assert(!MpmOutlineHolds(&outline, -1, (PetscReal[]){3., 3.}));
  ck_assert(MpmOutlineHolds(&outline, 1, (PetscReal[]){25., 4.}) &&
            MpmOutlineHolds(&outline, 1, (PetscReal[]){25., 21.}));
  ck_assert(fabs(MpmOutlineDistance(&outline, (PetscReal[]){3., 2.5}) - 0.5) < 1e-15);
  ck_assert_int_eq(outline.feature[2].type, MPM_OUTLINE_LINE);
  ck_assert_int_eq(outline.start[5] - outline.start[4], 2);
  MpmOutlineBounds(&outline, lower, upper);
  ck_assert(lower[0] == -100. && lower[1] == -200. && upper[0] == 30. && upper[1] == 25.);
  for (PetscInt k = 0; k < 4; k++) { /* outer rings turn left, the hole right */
    const PetscReal *a    = &outline.at[2 * outline.start[k]];
    const PetscReal  turn = (a[2] - a[0]) * (a[5] - a[1]) - (a[3] - a[1]) * (a[4] - a[0]);

    ck_assert(k == 1 ? turn < 0. : turn > 0.);
  }
  UNIT_CALL(MpmOutlineDestroy(&outline));
}
END_TEST

#define RING(positions) "{\"type\": \"Polygon\", \"coordinates\": [[" positions "]]}"

START_TEST(refused)
{
  static const struct {
    const char *text, *message;
  } cases[] = {
    {RING("[0,0],[10,10],[10,0],[0,10]"), NULL},
    {RING("[0,0],[10,10]"), "has a polygon of 2 vertices"},
    {RING("[0,0],[10,10],[5]"), "is no GeoJSON: a position must be two numbers"},
    {RING("[0,0],[10,10],[5,1e999]"), "has a place that is no number"},
    {"{\"type\": \"Polygon\", \"coordinates\": [[[0,0],]]}", "is no JSON from byte 43 on"},
    {"{\"type\": \"Circle\", \"coordinates\": []}",
     "is no GeoJSON: a geometry must be a Point, LineString or Polygon, or several of one kind"},
    {"{\"type\": \"FeatureCollection\", \"features\": []}", "has no point, line or polygon"},
    {"{\"type\": \"Feature\"}", "is no GeoJSON: a feature has no geometry"},
    {"{\"a\": \"b", "is no JSON from byte 8 on"},
  };
  MpmOutline outline;
  char       message[MPM_MAP_MESSAGE];

  for (size_t k = 0; k < sizeof(cases) / sizeof(cases[0]); k++) {
    Read(cases[k].text, &outline, message);
    if (!cases[k].message) ck_assert_msg(strstr(message, "has edges that cross") != NULL, "%s", message);
    else ck_assert_str_eq(message, cases[k].message);
    UNIT_CALL(MpmOutlineDestroy(&outline));
  }
}
END_TEST

/* Rings that touch, share an edge, or have edges in line do not cross. */
START_TEST(touching)
{
  MpmOutline outline;
  char       message[MPM_MAP_MESSAGE];

  Read("{\"type\": \"MultiPolygon\", \"coordinates\": [[[[0,0],[10,0],[10,10],[0,10]]], "
       "[[[10,0],[20,0],[20,10],[10,10]]], "
       "[[[20,10],[30,10],[30,20],[20,20]]], [[[0,10],[5,10],[5,20],[0,20]]]]}",
       &outline, message);
  ck_assert_str_eq(message, "");
  UNIT_CALL(MpmOutlineDestroy(&outline));
}
END_TEST

int main(int argc, char **argv)
{
  const TTest *const tests[] = {features, refused, touching};
  const int          file    = mkstemp(path);
  int                status;

  if (file < 0) return EXIT_FAILURE;
  (void)close(file);
  status = UnitRun(&argc, &argv, "outline", sizeof(tests) / sizeof(tests[0]), tests);
  (void)unlink(path);
  return status;
}

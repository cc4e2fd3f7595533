/*
  Maps: written and read again, by GDAL where it is there and as ASCII grids; windows, and full discs.
*/
#include "maps/gdal.h"
#include "maps/map.h"
#include "unit.h"

#include <math.h>
#include <signal.h>
#include <sys/resource.h>
#include <unistd.h>

#define COLUMNS 7
#define ROWS    5

static const PetscReal west = 512345.5, south = 5212345.25;
static char            folder[] = "/tmp/test_map_XXXXXX";

static const char *PathOf(const char *name)
{
  static char path[PETSC_MAX_PATH_LEN];

  snprintf(path, sizeof(path), "%s/%s", folder, name);
  return path;
}

/* A map with two bands that any digit counts in, and a pixel without data. */
static void Fill(MpmMap *map, PetscReal values[2][COLUMNS * ROWS])
{
  *map    = (MpmMap){.columns = COLUMNS, .rows = ROWS, .cell = {5., 5.}, .none = -9999.};
  map->x0 = west - 5e5, map->y0 = south - 5e6;
  map->origin[0] = 5e5, map->origin[1] = 5e6;
  for (PetscInt k = 0; k < COLUMNS * ROWS; k++) {
    values[0][k] = 100. + (PetscReal)k / 8.;
    values[1][k] = (PetscReal)k * k;
  }
  values[1][3] = NAN;
}

static void CheckRead(const char *path, PetscInt band, const PetscReal expected[])
{
  MpmMap map                      = {0};
  char   message[MPM_MAP_MESSAGE] = "";

  UNIT_CALL(MpmMapRead(path, &(MpmMapAsk){.band = band}, &map, message));
  ck_assert_str_eq(message, "");
  ck_assert_int_eq(map.columns, COLUMNS);
  ck_assert_int_eq(map.rows, ROWS);
  ck_assert(map.x0 == west && map.y0 == south && map.cell[0] == 5. && map.cell[1] == 5. && map.none == -9999.);
  for (PetscInt k = 0; k < COLUMNS * ROWS; k++)
    ck_assert(map.value[k] == expected[k] || (isnan(map.value[k]) && isnan(expected[k])));
  UNIT_CALL(MpmMapDestroy(&map));
}

/* A window holds the pixels about the rectangle, with one more on each side. */
static void CheckWindow(const char *path, const PetscReal expected[])
{
  const PetscReal lower[] = {west + 10., south + 5.}, upper[] = {west + 15., south + 10.};
  MpmMap          map                      = {0};
  char            message[MPM_MAP_MESSAGE] = "";

  UNIT_CALL(MpmMapRead(path, &(MpmMapAsk){.lower = lower, .upper = upper}, &map, message));
  ck_assert_str_eq(message, "");
  ck_assert_int_eq(map.columns, 4);
  ck_assert_int_eq(map.rows, 4);
  ck_assert(map.x0 == west + 5. && map.y0 == south);
  for (PetscInt j = 0; j < 4; j++)
    for (PetscInt i = 0; i < 4; i++) ck_assert(map.value[4 * j + i] == expected[COLUMNS * j + i + 1]);
  ck_assert(fabs(MpmMapAt(&map, (PetscReal[]){west + 12.5, south + 5.}) - 0.5 * (expected[9] + expected[10])) < 1e-12);
  UNIT_CALL(MpmMapDestroy(&map));
}

static const char *const names[] = {"depth", "speed"};

START_TEST(ascii)
{
  PetscReal        values[2][COLUMNS * ROWS];
  const PetscReal *at[] = {values[0], values[1]};
  MpmMap           map;

  setenv("TALUS_GDAL", "none", 1);
  Fill(&map, values);
  UNIT_CALL(MpmMapWrite(PETSC_COMM_WORLD, PathOf("map"), &map, 2, names, at));
  CheckRead(PathOf("map_depth.asc"), 1, values[0]);
  CheckRead(PathOf("map_speed.asc"), 1, values[1]);
  CheckWindow(PathOf("map_depth.asc"), values[0]);
  unsetenv("TALUS_GDAL");
}
END_TEST

START_TEST(tiff)
{
  PetscReal        values[2][COLUMNS * ROWS];
  const PetscReal *at[] = {values[0], values[1]};
  MpmGdal          gdal;
  MpmMap           map;

  if (!MpmGdalOpen(&gdal)) return;
  Fill(&map, values);
  UNIT_CALL(MpmMapWrite(PETSC_COMM_WORLD, PathOf("map"), &map, 2, names, at));
  CheckRead(PathOf("map.tif"), 1, values[0]);
  CheckRead(PathOf("map.tif"), 2, values[1]);
  CheckWindow(PathOf("map.tif"), values[0]);
}
END_TEST

/* Where the disc is full nothing is left, and the file of before stays. */
START_TEST(full)
{
  PetscReal        values[2][COLUMNS * ROWS], *large;
  const PetscReal *at[] = {values[0], values[1]}, *more[1];
  struct rlimit    limit, small;
  UnitError        error;
  MpmMap           map;
  MpmGdal          gdal;

  Fill(&map, values);
  UNIT_CALL(MpmMapWrite(PETSC_COMM_WORLD, PathOf("map"), &map, 2, names, at));
  map.columns = map.rows = 500;
  UNIT_CALL(PetscMalloc1(250000, &large));
  for (PetscInt k = 0; k < 250000; k++) large[k] = rand();
  more[0] = large;
  getrlimit(RLIMIT_FSIZE, &limit);
  small          = limit;
  small.rlim_cur = 100000;
  signal(SIGXFSZ, SIG_IGN);
  for (PetscInt k = 0; k < 2; k++) {
    const char *name = k ? "map_depth.asc" : "map.tif";

    if (!k && !MpmGdalOpen(&gdal)) continue;
    setenv("TALUS_GDAL", k ? "none" : "", 1);
    setrlimit(RLIMIT_FSIZE, &small);
    UNIT_TRY(error, MpmMapWrite(PETSC_COMM_WORLD, PathOf("map"), &map, 1, names, more));
    setrlimit(RLIMIT_FSIZE, &limit);
    ck_assert_int_eq((int)error.code, PETSC_ERR_FILE_WRITE);
    ck_assert_msg(strstr(error.message, name) && !strchr(error.message, '\n'), "%s", error.message);
    ck_assert(access(PathOf(k ? "map_depth.asc.tmp" : "map.tif.tmp"), F_OK));
    CheckRead(PathOf(name), 1, values[0]);
  }
  unsetenv("TALUS_GDAL");
  UNIT_CALL(PetscFree(large));
}
END_TEST

int main(int argc, char **argv)
{
  const TTest *const tests[] = {ascii, tiff, full};
  const char *const  files[] = {"map.tif", "map_depth.asc", "map_speed.asc"};
  int                status;

  if (!mkdtemp(folder)) return EXIT_FAILURE;
  status = UnitRun(&argc, &argv, "map", sizeof(tests) / sizeof(tests[0]), tests);
  for (size_t k = 0; k < sizeof(files) / sizeof(files[0]); k++) (void)unlink(PathOf(files[k]));
  (void)rmdir(folder);
  return status;
}

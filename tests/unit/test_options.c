/*
  Options: what is accepted, what is refused and in which words, and that what is written can be run again.
*/
#include "options/options.h"
#include "unit.h"

#include <stdarg.h>
#include <stdio.h>

#define YAML_FILE "test_options.yaml"

static MpmOptions options;
static char       printed[20000];

static PetscErrorCode Capture(MPI_Comm comm, const char format[], ...)
{
  const size_t used = strlen(printed);
  va_list      arguments;

  (void)comm;
  va_start(arguments, format);
  vsnprintf(printed + used, sizeof(printed) - used, format, arguments);
  va_end(arguments);
  return PETSC_SUCCESS;
}

static void SetUp(void)
{
  UNIT_CALL(PetscOptionsClear(NULL));
  options.comm   = PETSC_COMM_WORLD;
  options.prefix = "mpm_a_";
  UNIT_CALL(MpmRecordCreate(&options.record));
  printed[0] = '\0';
}

static void TearDown(void)
{
  PetscMPIInt rank;

  UNIT_CALL(MpmRecordDestroy(&options.record));
  ck_assert_ptr_null(options.record);
  UNIT_CALL(PetscOptionsClear(NULL));
  UNIT_CALL(MPI_Comm_rank(PETSC_COMM_WORLD, &rank));
  if (rank == 0) remove(YAML_FILE); /* the one that writes and reads it; another could hit the next test's */
}

static void Give(const char name[], const char value[])
{
  UNIT_CALL(PetscOptionsSetValue(NULL, name, value));
}

/* -------------------------------------------------------------------------------------------------------- one value */

static const MpmRange poisson = {-1., 0.5, PETSC_TRUE};

static PetscErrorCode ReadNu(PetscReal *value, PetscBool *set)
{
  return MpmOptionsReal(&options, "nu", "-", "Poisson's ratio", poisson, MPM_OPTIONAL, value, set);
}

START_TEST(real_accepts)
{
  static const struct {
    const char *text;
    PetscReal   value;
  } cases[]       = {{"0.25", 0.25}, {"-1e-3", -1e-3}, {" .5e-1 ", 0.05}, {"0", 0.}, {"1e-400", 0.}, {"+0.125", 0.125}};
  PetscReal value = 0.3;
  PetscBool set   = PETSC_TRUE;

  SetUp();
  UNIT_CALL(ReadNu(&value, &set));
  ck_assert_double_eq(value, 0.3);
  ck_assert_int_eq(set, PETSC_FALSE);
  for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); i++) {
    Give("-mpm_a_nu", cases[i].text);
    UNIT_CALL(ReadNu(&value, &set));
    ck_assert_double_eq(value, cases[i].value);
    ck_assert_int_eq(set, PETSC_TRUE);
  }
  TearDown();
}
END_TEST

START_TEST(real_refuses)
{
  static const struct {
    const char *text, *message;
  } cases[] = {
    {"0.5", "-mpm_a_nu 0.5: must lie in (-1, 0.5)"},
    {"-1", "-mpm_a_nu -1: must lie in (-1, 0.5)"},
    {"0.1x", "-mpm_a_nu 0.1x: not a number: Poisson's ratio (-), in (-1, 0.5)"},
    {"x", "-mpm_a_nu x: not a number: Poisson's ratio (-), in (-1, 0.5)"},
    {"nan", "-mpm_a_nu nan: not a number: Poisson's ratio (-), in (-1, 0.5)"},
    {"inf", "-mpm_a_nu inf: not a number: Poisson's ratio (-), in (-1, 0.5)"},
    {"1e999", "-mpm_a_nu 1e999: not a number: Poisson's ratio (-), in (-1, 0.5)"},
    {"0.1,0.2", "-mpm_a_nu 0.1,0.2: must have 1 value, has 2: Poisson's ratio (-), in (-1, 0.5)"},
    {"0.1\n2", "-mpm_a_nu 0.1 2: not a number: Poisson's ratio (-), in (-1, 0.5)"},
    {" ", "-mpm_a_nu  : a value must follow"},
    {NULL, "-mpm_a_nu: a value must follow: Poisson's ratio (-), in (-1, 0.5)"},
  };
  PetscReal value = 0.3;

  SetUp();
  for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); i++) {
    Give("-mpm_a_nu", cases[i].text);
    UNIT_FAILS(ReadNu(&value, NULL), MPM_ERR_INPUT, cases[i].message);
  }
  ck_assert_double_eq(value, 0.3);
  TearDown();
}
END_TEST

/* One-sided and closed ranges, and a range that nothing infinite slips through. */
START_TEST(real_ranges)
{
  const MpmRange fraction = {0., 1., PETSC_FALSE}, at_most = {PETSC_NINFINITY, 2., PETSC_FALSE};
  PetscReal      value = 1.;

  SetUp();
  UNIT_FAILS(MpmOptionsReal(&options, "E", "Pa", "Young's modulus", MPM_RANGE_POSITIVE, MPM_REQUIRED, &value, NULL),
             MPM_ERR_INPUT, "-mpm_a_E is missing: Young's modulus (Pa), > 0");
  Give("-mpm_a_E", "0");
  UNIT_FAILS(MpmOptionsReal(&options, "E", "Pa", "Young's modulus", MPM_RANGE_POSITIVE, MPM_REQUIRED, &value, NULL),
             MPM_ERR_INPUT, "-mpm_a_E 0: must be > 0 Pa");
  UNIT_CALL(MpmOptionsReal(&options, "E", "Pa", "Young's modulus", MPM_RANGE_NON_NEGATIVE, MPM_REQUIRED, &value, NULL));
  Give("-mpm_a_E", "12e6");
  UNIT_CALL(MpmOptionsReal(&options, "E", "Pa", "Young's modulus", MPM_RANGE_POSITIVE, MPM_REQUIRED, &value, NULL));
  ck_assert_double_eq(value, 12e6);
  UNIT_FAILS(MpmOptionsReal(&options, "E", "Pa", "E", fraction, MPM_REQUIRED, &value, NULL), MPM_ERR_INPUT,
             "-mpm_a_E 12e6: must lie in [0, 1] Pa");
  UNIT_FAILS(MpmOptionsReal(&options, "E", "Pa", "E", at_most, MPM_REQUIRED, &value, NULL), MPM_ERR_INPUT,
             "-mpm_a_E 12e6: must be <= 2 Pa");
  Give("-mpm_a_E", "inf");
  UNIT_FAILS(MpmOptionsReal(&options, "E", "Pa", "E", MPM_RANGE_ANY, MPM_REQUIRED, &value, NULL), MPM_ERR_INPUT,
             "-mpm_a_E inf: not a number: E (Pa)");
  TearDown();
}
END_TEST

START_TEST(integers)
{
  static const char *const wrong[] = {"1.0", "1e3", "ten", "99999999999999999999", "0x10"};
  PetscInt                 value   = 7;
  char                     message[200];

  SetUp();
  UNIT_CALL(MpmOptionsInt(&options, "n", "number", 1, 100, MPM_OPTIONAL, &value, NULL));
  ck_assert_int_eq(value, 7);
  Give("-mpm_a_n", "42");
  UNIT_CALL(MpmOptionsInt(&options, "n", "number", 1, 100, MPM_OPTIONAL, &value, NULL));
  ck_assert_int_eq(value, 42);
  Give("-mpm_a_n", "0");
  UNIT_FAILS(MpmOptionsInt(&options, "n", "number", 1, 100, MPM_OPTIONAL, &value, NULL), MPM_ERR_INPUT,
             "-mpm_a_n 0: must lie in [1, 100]");
  UNIT_FAILS(MpmOptionsInt(&options, "n", "number", 1, PETSC_INT_MAX, MPM_OPTIONAL, &value, NULL), MPM_ERR_INPUT,
             "-mpm_a_n 0: must be >= 1");
  for (size_t i = 0; i < sizeof(wrong) / sizeof(wrong[0]); i++) {
    Give("-mpm_a_n", wrong[i]);
    snprintf(message, sizeof(message), "-mpm_a_n %s: not a whole number: number (-), in [1, 100]", wrong[i]);
    UNIT_FAILS(MpmOptionsInt(&options, "n", "number", 1, 100, MPM_OPTIONAL, &value, NULL), MPM_ERR_INPUT, message);
  }
  TearDown();
}
END_TEST

START_TEST(booleans)
{
  static const char *const words[] = {"true", "YES", "1", "on", "false", "No", "0", "off"};
  PetscBool                value, set;

  SetUp();
  for (size_t i = 0; i < 8; i++) {
    value = i < 4 ? PETSC_FALSE : PETSC_TRUE;
    Give("-mpm_a_flag", words[i]);
    UNIT_CALL(MpmOptionsBool(&options, "flag", "a flag", &value, &set));
    ck_assert_int_eq(value, i < 4);
    ck_assert_int_eq(set, PETSC_TRUE);
  }
  Give("-mpm_a_flag", NULL); /* a bare flag */
  UNIT_CALL(MpmOptionsBool(&options, "flag", "a flag", &value, NULL));
  ck_assert_int_eq(value, PETSC_TRUE);
  Give("-mpm_a_flag", "maybe");
  UNIT_FAILS(MpmOptionsBool(&options, "flag", "a flag", &value, NULL), MPM_ERR_INPUT,
             "-mpm_a_flag maybe: must be true or false");
  TearDown();
}
END_TEST

START_TEST(words_and_text)
{
  static const char *const shapes[] = {"linear", "gimp", NULL};
  PetscInt                 value    = 1;
  char                    *text;

  SetUp();
  UNIT_CALL(MpmOptionsWord(&options, "shape", "shape functions", shapes, MPM_OPTIONAL, &value, NULL));
  ck_assert_int_eq(value, 1);
  Give("-mpm_a_shape", "Linear");
  UNIT_CALL(MpmOptionsWord(&options, "shape", "shape functions", shapes, MPM_OPTIONAL, &value, NULL));
  ck_assert_int_eq(value, 0);
  Give("-mpm_a_shape", "lin");
  UNIT_FAILS(MpmOptionsWord(&options, "shape", "shape functions", shapes, MPM_OPTIONAL, &value, NULL), MPM_ERR_INPUT,
             "-mpm_a_shape lin: must be one of linear, gimp");
  UNIT_FAILS(MpmOptionsWord(&options, "type", "law", shapes, MPM_REQUIRED, &value, NULL), MPM_ERR_INPUT,
             "-mpm_a_type is missing: law, one of linear, gimp");
  UNIT_CALL(MpmOptionsText(&options, "title", "title", NULL, MPM_OPTIONAL, &text));
  ck_assert_ptr_null(text);
  UNIT_CALL(MpmOptionsText(&options, "title", "title", "none given", MPM_OPTIONAL, &text));
  ck_assert_str_eq(text, "none given");
  UNIT_CALL(PetscFree(text));
  Give("-mpm_a_title", "a: \"b\"");
  UNIT_CALL(MpmOptionsText(&options, "title", "title", NULL, MPM_OPTIONAL, &text));
  ck_assert_str_eq(text, "a: \"b\"");
  UNIT_CALL(PetscFree(text));
  TearDown();
}
END_TEST

/* ------------------------------------------------------------------------------------------------------------ lists */

START_TEST(lists)
{
  PetscReal values[2] = {3., 4.}, *list;
  PetscInt  ints[2]   = {5, 6}, count;
  PetscBool set;

  SetUp();
  UNIT_CALL(MpmOptionsReals(&options, "lower", "m", "corner", MPM_RANGE_ANY, MPM_OPTIONAL, 2, values, &set));
  ck_assert_int_eq(set, PETSC_FALSE);
  ck_assert_double_eq(values[1], 4.);
  Give("-mpm_a_lower", " 0 ,\t9.5 ");
  UNIT_CALL(MpmOptionsReals(&options, "lower", "m", "corner", MPM_RANGE_ANY, MPM_OPTIONAL, 2, values, &set));
  ck_assert_double_eq(values[0], 0.);
  ck_assert_double_eq(values[1], 9.5);
  UNIT_FAILS(MpmOptionsReals(&options, "lower", "m", "corner", MPM_RANGE_POSITIVE, MPM_OPTIONAL, 2, values, &set),
             MPM_ERR_INPUT, "-mpm_a_lower 0 , 9.5 : each must be > 0 m");
  Give("-mpm_a_lower", "1");
  UNIT_FAILS(MpmOptionsReals(&options, "lower", "m", "corner", MPM_RANGE_ANY, MPM_OPTIONAL, 2, values, &set),
             MPM_ERR_INPUT, "-mpm_a_lower 1: must have 2 values, has 1: corner (m), 2 values");
  Give("-mpm_a_lower", "1,");
  UNIT_FAILS(MpmOptionsReals(&options, "lower", "m", "corner", MPM_RANGE_ANY, MPM_OPTIONAL, 2, values, &set),
             MPM_ERR_INPUT, "-mpm_a_lower 1,: not a list of numbers: corner (m), 2 values");
  UNIT_FAILS(MpmOptionsInts(&options, "cells", "cells per axis", 1, PETSC_INT_MAX, MPM_REQUIRED, 2, ints, NULL),
             MPM_ERR_INPUT, "-mpm_a_cells is missing: cells per axis (-), 2 values, each >= 1");
  Give("-mpm_a_cells", "60,0");
  UNIT_FAILS(MpmOptionsInts(&options, "cells", "cells per axis", 1, PETSC_INT_MAX, MPM_REQUIRED, 2, ints, NULL),
             MPM_ERR_INPUT, "-mpm_a_cells 60,0: each must be >= 1");
  Give("-mpm_a_cells", "60, 61");
  UNIT_CALL(MpmOptionsInts(&options, "cells", "cells per axis", 1, PETSC_INT_MAX, MPM_REQUIRED, 2, ints, NULL));
  ck_assert_int_eq(ints[1], 61);
  UNIT_CALL(MpmOptionsRealList(&options, "list", "m", "a list", MPM_OPTIONAL, &count, &list));
  ck_assert_int_eq(count, 0);
  ck_assert_ptr_null(list);
  Give("-mpm_a_list", "1,-2,3e1");
  UNIT_CALL(MpmOptionsRealList(&options, "list", "m", "a list", MPM_OPTIONAL, &count, &list));
  ck_assert_int_eq(count, 3);
  ck_assert_double_eq(list[2], 30.);
  UNIT_CALL(PetscFree(list));
  TearDown();
}
END_TEST

START_TEST(block_names)
{
  PetscInt count;
  char   **list;

  SetUp();
  UNIT_CALL(MpmOptionsNames(&options, "bodies", "bodies", MPM_OPTIONAL, &count, &list));
  ck_assert_int_eq(count, 0);
  Give("-mpm_a_bodies", "beam, soil_1");
  UNIT_CALL(MpmOptionsNames(&options, "bodies", "bodies", MPM_REQUIRED, &count, &list));
  ck_assert_int_eq(count, 2);
  ck_assert_str_eq(list[0], "beam");
  ck_assert_str_eq(list[1], "soil_1");
  UNIT_CALL(MpmNamesDestroy(count, &list));
  ck_assert_ptr_null(list);
  Give("-mpm_a_bodies", "a b");
  UNIT_FAILS(MpmOptionsNames(&options, "bodies", "bodies", MPM_REQUIRED, &count, &list), MPM_ERR_INPUT,
             "-mpm_a_bodies a b: names consist of letters, digits and underscores");
  Give("-mpm_a_bodies", "a,,b");
  UNIT_FAILS(MpmOptionsNames(&options, "bodies", "bodies", MPM_REQUIRED, &count, &list), MPM_ERR_INPUT,
             "-mpm_a_bodies a,,b: a name is empty");
  Give("-mpm_a_bodies", "a,b,A");
  UNIT_FAILS(MpmOptionsNames(&options, "bodies", "bodies", MPM_REQUIRED, &count, &list), MPM_ERR_INPUT,
             "-mpm_a_bodies a,b,A: two names are alike (upper and lower case are not told apart)");
  TearDown();
}
END_TEST

/* --------------------------------------------------------------------------------------------------------- database */

/* PETSc would answer -mpm_body_1_E from -mpm_body_E. */
START_TEST(numbered_names_are_their_own)
{
  PetscReal value = 1.;
  PetscBool set, has;

  SetUp();
  options.prefix = "mpm_body_1_";
  Give("-mpm_body_E", "2");
  UNIT_CALL(MpmOptionsReal(&options, "E", "Pa", "modulus", MPM_RANGE_POSITIVE, MPM_OPTIONAL, &value, &set));
  ck_assert_int_eq(set, PETSC_FALSE);
  ck_assert_double_eq(value, 1.);
  UNIT_CALL(MpmOptionsHas(&options, "E", &has));
  ck_assert_int_eq(has, PETSC_FALSE);
  TearDown();
}
END_TEST

START_TEST(has_does_not_use)
{
  PetscBool has, used;
  char     *text, *warning;

  SetUp();
  Give("-mpm_a_at", "1,2");
  UNIT_CALL(MpmOptionsHas(&options, "at", &has));
  ck_assert_int_eq(has, PETSC_TRUE);
  UNIT_CALL(PetscOptionsUsed(NULL, "mpm_a_at", &used));
  ck_assert_int_eq(used, PETSC_FALSE);
  UNIT_FAILS(MpmOptionsCheckUnknown(&options, &warning), MPM_ERR_INPUT, "-mpm_a_at: unknown option");
  UNIT_CALL(MpmOptionsText(&options, "at", "place", NULL, MPM_OPTIONAL, &text));
  UNIT_CALL(PetscFree(text));
  UNIT_CALL(PetscOptionsUsed(NULL, "mpm_a_at", &used));
  ck_assert_int_eq(used, PETSC_TRUE);
  UNIT_CALL(MpmOptionsHas(&options, "at", &has));
  ck_assert_int_eq(has, PETSC_TRUE);
  UNIT_CALL(MpmOptionsCheckUnknown(&options, &warning));
  TearDown();
}
END_TEST

START_TEST(unknown_options)
{
  PetscInt  cells = 3, points = 2;
  PetscBool used;
  char     *warning;

  SetUp();
  Give("-snes_max_it", "7");
  Give("-mpm_a_cells", "4");
  UNIT_CALL(MpmOptionsInt(&options, "cells", "cells", 1, 9, MPM_OPTIONAL, &cells, NULL));
  UNIT_CALL(MpmOptionsInt(&options, "points_per_cell", "points", 1, 9, MPM_OPTIONAL, &points, NULL));
  UNIT_CALL(MpmOptionsCheckUnknown(&options, &warning));
  UNIT_CALL(PetscOptionsUsed(NULL, "snes_max_it", &used));
  ck_assert_int_eq(used, PETSC_FALSE);
  Give("-mpm_a_cels", "5");
  UNIT_FAILS(MpmOptionsCheckUnknown(&options, &warning), MPM_ERR_INPUT,
             "-mpm_a_cels: unknown option; did you mean -mpm_a_cells?");
  UNIT_CALL(PetscOptionsClearValue(NULL, "-mpm_a_cels"));
  UNIT_CALL(MpmOptionsInt(&options, "count", "count", 1, 9, MPM_OPTIONAL, &points, NULL));
  Give("-mpm_a_countdown", "5");
  UNIT_FAILS(MpmOptionsCheckUnknown(&options, &warning), MPM_ERR_INPUT, "-mpm_a_countdown: unknown option");
  UNIT_CALL(PetscOptionsClearValue(NULL, "-mpm_a_countdown"));
  Give("-MPM_a_points_by_cell", NULL);
  UNIT_FAILS(MpmOptionsCheckUnknown(&options, &warning), MPM_ERR_INPUT, "-MPM_a_points_by_cell: unknown option");
  /* used by somebody through PETSc itself, and still not ours */
  UNIT_CALL(PetscOptionsHasName(NULL, NULL, "-mpm_a_points_by_cell", &used));
  UNIT_FAILS(MpmOptionsCheckUnknown(&options, &warning), MPM_ERR_INPUT, "-MPM_a_points_by_cell: unknown option");
  TearDown();
}
END_TEST

/* ------------------------------------------------------------------------------------------------------------- help */

START_TEST(help)
{
  PetscErrorCode (*const print)(MPI_Comm, const char[], ...) = PetscHelpPrintf;
  static const char *const words[]                           = {"on", "off", NULL};
  PetscReal                E = -5., origin[2] = {0., 0.25};
  PetscInt                 cells[2] = {60, 60}, word = 1, count;
  char                    *text, **names;

  SetUp();
  PetscHelpPrintf = Capture;
  UNIT_CALL(MpmOptionsHeading(&options, "Quiet"));
  UNIT_CALL(PetscOptionsInsertString(NULL, "-help"));
  UNIT_CALL(MpmOptionsHeading(&options, "Block a"));
  UNIT_CALL(MpmOptionsInts(&options, "cells", "cells per axis", 1, PETSC_INT_MAX, MPM_OPTIONAL, 2, cells, NULL));
  UNIT_CALL(MpmOptionsInts(&options, "cells", "cells per axis", 1, PETSC_INT_MAX, MPM_OPTIONAL, 2, cells,
                           NULL)); /* once is enough */
  UNIT_CALL(MpmOptionsReals(&options, "origin", "m", "origin", MPM_RANGE_ANY, MPM_OPTIONAL, 2, origin, NULL));
  UNIT_CALL(MpmOptionsReal(&options, "E", "Pa", "modulus", MPM_RANGE_POSITIVE, MPM_REQUIRED, &E, NULL));
  UNIT_CALL(MpmOptionsWord(&options, "state", "a switch", words, MPM_OPTIONAL, &word, NULL));
  UNIT_CALL(MpmOptionsText(&options, "title", "title", NULL, MPM_REQUIRED, &text));
  UNIT_CALL(MpmOptionsNames(&options, "axes", "axes", MPM_OPTIONAL, &count, &names));
  PetscHelpPrintf = print;
  ck_assert_str_eq(printed,
                   "\nBlock a\n"
                   "  -mpm_a_cells                        cells per axis (2 values, each >= 1; default 60,60)\n"
                   "  -mpm_a_origin                       origin (m; 2 values; default 0,0.25)\n"
                   "  -mpm_a_E                            modulus (Pa; > 0; required)\n"
                   "  -mpm_a_state                        a switch (one of on, off; default off)\n"
                   "  -mpm_a_title                        title (text; required)\n"
                   "  -mpm_a_axes                         axes (names, comma-separated; optional)\n");
  ck_assert_double_eq(E, -5.); /* a missing value stays as on entry */
  ck_assert_ptr_null(text);
  ck_assert_int_eq(count, 0);
  TearDown();
  UNIT_CALL(PetscOptionsClearValue(NULL, "-help"));
}
END_TEST

/* ------------------------------------------------------------------------------------------------------------- YAML */

static void CheckText(const char name[], const char expected[])
{
  char      text[500] = "";
  PetscBool set;

  UNIT_CALL(PetscOptionsGetString(NULL, NULL, name, text, sizeof(text), &set));
  ck_assert_msg(set, "%s is not there", name);
  ck_assert_str_eq(text, expected);
}

static void CheckAbsent(const char name[])
{
  PetscBool set;

  UNIT_CALL(PetscOptionsHasName(NULL, NULL, name, &set));
  ck_assert_msg(!set, "%s is there", name);
}

/* Every value in the database again, after it was written, forgotten and read by PETSc. */
START_TEST(yaml_round_trip)
{
  static const char *const texts[] = {"Cantilever under a point load",
                                      "a: b",
                                      "\"quoted\" and 'single'",
                                      "# no comment",
                                      "back\\slash",
                                      "{a: 1}",
                                      "- item",
                                      "yes",
                                      "  blanks  ",
                                      "tab\tand\nline",
                                      "\xC3\xA9\xE2\x82\xAC\xF0\x9F\x98\x80",
                                      "x -snes_max_it 3",
                                      "100%",
                                      "&a *b !c",
                                      "\xE2\x80\xA8|\xC2\x85"};
  const size_t             count   = sizeof(texts) / sizeof(texts[0]);
  char                     name[50], *text;

  SetUp();
  for (size_t i = 0; i < count; i++) {
    snprintf(name, sizeof(name), "-mpm_a_text%d", (int)i);
    Give(name, texts[i]);
    UNIT_CALL(MpmOptionsText(&options, name + 7, "text", NULL, MPM_OPTIONAL, &text));
    UNIT_CALL(PetscFree(text));
    snprintf(name, sizeof(name), "-other_text%d", (int)i);
    Give(name, texts[i]);
  }
  Give("-other_latin", "caf\xE9");
  Give("-snes_monitor", NULL);
  Give("-snes_max_it", "7");
  Give("-options_file", "case.yaml");
  UNIT_CALL(PetscOptionsHasName(NULL, NULL, "-snes_max_it", NULL)); /* used and unused ones alike */
  UNIT_CALL(MpmOptionsWriteYAML(&options, YAML_FILE));
  UNIT_CALL(PetscOptionsClear(NULL));
  UNIT_CALL(PetscOptionsInsertFile(PETSC_COMM_WORLD, NULL, YAML_FILE, PETSC_TRUE));
  for (size_t i = 0; i < count; i++) {
    snprintf(name, sizeof(name), "-mpm_a_text%d", (int)i);
    CheckText(name, texts[i]);
    snprintf(name, sizeof(name), "-other_text%d", (int)i);
    CheckText(name, texts[i]);
  }
  CheckText("-other_latin", "caf\xC3\xA9"); /* not UTF-8 when it went in: the file stays readable */
  CheckText("-snes_monitor", "");
  CheckText("-snes_max_it", "7");
  CheckAbsent("-options_file");
  TearDown();
}
END_TEST

/* Defaults are keys, except those that would say more, or be refused, when read again. */
START_TEST(yaml_defaults)
{
  PetscReal nu = 0.3, end = PETSC_INFINITY, at[2] = {1., 2.}, step = 0.;
  PetscInt  n = 5;
  PetscBool set, has, bar = PETSC_TRUE;

  SetUp();
  Give("-mpm_a_n", "  6");
  UNIT_CALL(ReadNu(&nu, NULL));
  UNIT_CALL(MpmOptionsInt(&options, "n", "number", 1, 9, MPM_OPTIONAL, &n, &set));
  UNIT_CALL(MpmOptionsBool(&options, "bar", "bar", &bar, NULL));
  UNIT_CALL(MpmOptionsReal(&options, "end", "s", "end", MPM_RANGE_POSITIVE, MPM_OPTIONAL, &end, NULL));
  UNIT_CALL(MpmOptionsReal(&options, "step", "s", "step", MPM_RANGE_POSITIVE, MPM_OPTIONAL, &step, NULL));
  UNIT_CALL(MpmOptionsReals(&options, "at", "m", "place", MPM_RANGE_ANY, MPM_OPTIONAL, 2, at, &set));
  UNIT_CALL(MpmOptionsHas(&options, "nearest", &has));
  UNIT_CALL(MpmOptionsInt(&options, "nearest", "points", 1, 9, MPM_OPTIONAL, &n, NULL));
  UNIT_CALL(MpmOptionsWriteYAML(&options, YAML_FILE));
  UNIT_CALL(PetscOptionsClear(NULL));
  UNIT_CALL(PetscOptionsInsertFile(PETSC_COMM_WORLD, NULL, YAML_FILE, PETSC_TRUE));
  CheckText("-mpm_a_nu", "0.3");
  CheckText("-mpm_a_n", "  6");
  CheckText("-mpm_a_bar", "true");
  CheckAbsent("-mpm_a_end");
  CheckAbsent("-mpm_a_step");
  CheckAbsent("-mpm_a_at");
  CheckAbsent("-mpm_a_nearest");
  TearDown();
}
END_TEST

START_TEST(yaml_failure)
{
  SetUp();
  UNIT_FAILS(MpmOptionsWriteYAML(&options, "/nowhere/x.yaml"), PETSC_ERR_FILE_WRITE,
             "Cannot write the options in force to /nowhere/x.yaml");
  TearDown();
}
END_TEST

int main(int argc, char **argv)
{
  const TTest *const tests[] = {real_accepts,
                                real_refuses,
                                real_ranges,
                                integers,
                                booleans,
                                words_and_text,
                                lists,
                                block_names,
                                numbered_names_are_their_own,
                                has_does_not_use,
                                unknown_options,
                                help,
                                yaml_round_trip,
                                yaml_defaults,
                                yaml_failure};

  return UnitRun(&argc, &argv, "options", sizeof(tests) / sizeof(tests[0]), tests);
}

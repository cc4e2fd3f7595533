#pragma once
/*
  Shared by the unit tests: the runner, and a way to look at an error that PETSc would print.

  Tests run in this very process (no fork): MPI does not survive one, and the sanitizers see everything.
*/
#include "talus/compat.h"

#include "../checks.h"

#include <stdlib.h>
#include <string.h>

/* The sanitizers take four times as long, and so do ranks that wait for each other: these see some of the combinations,
   one rank of other builds all. */
#if defined(__SANITIZE_ADDRESS__)
#define UNIT_SANITIZED 1
#else
#define UNIT_SANITIZED 0
#endif

static inline int UnitFew(void)
{
  int size = 1;

  return UNIT_SANITIZED || (!MPI_Comm_size(PETSC_COMM_WORLD, &size) && size > 1);
}

static inline int UnitRun(int *argc, char ***argv, const char name[], size_t count, const TTest *const tests[])
{
  Suite   *suite  = suite_create(name);
  TCase   *tcase  = tcase_create(name);
  SRunner *runner = srunner_create(suite);
  int      failed;

  if (PetscInitialize(argc, argv, NULL, NULL)) return EXIT_FAILURE;
  srand(1);
  for (size_t i = 0; i < count; i++) tcase_add_test(tcase, tests[i]);
  suite_add_tcase(suite, tcase);
  srunner_set_fork_status(runner, CK_NOFORK);
  srunner_run_all(runner, CK_NORMAL);
  failed = srunner_ntests_failed(runner);
  srunner_free(runner);
  if (PetscFinalize()) return EXIT_FAILURE;
  return failed ? EXIT_FAILURE : EXIT_SUCCESS;
}

/* The first message and code of an error, instead of PETSc's traceback. */
typedef struct {
  PetscErrorCode code;
  char           message[2048];
} UnitError;

static inline PetscErrorCode UnitCatch(MPI_Comm comm, int line, const char *function, const char *file,
                                       PetscErrorCode code, PetscErrorType type, const char *message, void *context)
{
  UnitError *error = (UnitError *)context;

  (void)comm, (void)line, (void)function, (void)file;
  if (type != PETSC_ERROR_INITIAL) return code;
  error->code = code;
  strncpy(error->message, message ? message : "", sizeof(error->message) - 1);
  return code;
}

/* Runs a call that may fail. */
#define UNIT_TRY(error, call) \
  do { \
    memset(&(error), 0, sizeof(error)); \
    (void)PetscPushErrorHandler(UnitCatch, &(error)); \
    (void)(call); \
    (void)PetscPopErrorHandler(); \
  } while (0)

/* A call that must succeed. */
#define UNIT_CALL(call) \
  do { \
    UnitError unit_error; \
    UNIT_TRY(unit_error, call); \
    ck_assert_msg(unit_error.code == PETSC_SUCCESS, "%s", unit_error.message); \
  } while (0)

/* A call that must fail with this code and exactly this message. */
#define UNIT_FAILS(call, expected_code, expected_message) \
  do { \
    UnitError unit_error; \
    UNIT_TRY(unit_error, call); \
    ck_assert_int_eq((int)unit_error.code, (int)(expected_code)); \
    ck_assert_str_eq(unit_error.message, expected_message); \
  } while (0)

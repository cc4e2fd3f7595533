/*
  Conformance tests for a law of a plugin: installed with the library, below tests/ in a build.
*/
#include <stdio.h>
#include <string.h>
#include "run/law_check.h"
#include "run/script.h"
#include "talus/talus.h"

PetscBool MpmLawCheckNamed(int argc, char **argv)
{
  return (PetscBool)(argc > 1 && !strcmp(argv[1], "check-law"));
}

int MpmLawCheckRun(int argc, char **argv)
{
  static const char *const places[][2] = {{"libexec/talus/test_laws_2d", "tests/test_laws_2d"},
                                          {"libexec/talus/test_laws_3d", "tests/test_laws_3d"}};
  int                      status      = 0;

  if (argc != 4) {
    (void)fprintf(stderr,
                  "talus: error: check-law: a plugin and the name of its law must follow: check-law x.so NAME\n");
    return MPM_EXIT_INPUT;
  }
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(places) && !status; k++) {
    char        path[PETSC_MAX_PATH_LEN];
    char *const words[] = {path, argv[2], argv[3], NULL};

    MpmFileFindBeside(2, places[k], path);
    if (!path[0]) {
      (void)fprintf(stderr, "talus: error: check-law: no %s beside the program; it is installed with the library\n",
                    places[k][0]);
      return 1;
    }
    status = MpmCommandCall(words, PETSC_FALSE);
  }
  return status;
}

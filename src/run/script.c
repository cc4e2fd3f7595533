/*
  Commands that a script in Python carries out. The script is found from the program's own place: in an installed
  prefix, in a wheel, or in the tree that it was built in.
*/
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>
#include "run/script.h"

#define PARENTS 3 /* folders above the program in which a file is searched */

static const char *const needs = "import importlib.util as u; raise SystemExit(any(u.find_spec(m) is None for m in "
                                 "('numpy', 'h5py', 'matplotlib', 'PIL')))";

void MpmFileFindBeside(PetscInt count, const char *const places[], char path[PETSC_MAX_PATH_LEN])
{
  char          folder[PETSC_MAX_PATH_LEN];
  const ssize_t length = readlink("/proc/self/exe", folder, sizeof(folder) - 1);

  path[0] = '\0';
  if (length <= 0) return;
  folder[length] = '\0';
  for (int up = 0; up <= PARENTS; up++) {
    char *slash = strrchr(folder, '/');

    if (!slash) return;
    *slash = '\0';
    for (PetscInt k = 0; k < count; k++) {
      if (snprintf(path, PETSC_MAX_PATH_LEN, "%s/%s", folder, places[k]) < PETSC_MAX_PATH_LEN && !access(path, R_OK))
        return;
    }
  }
  path[0] = '\0';
}

/* Path of the script; empty where there is none. */
static void FindScript(char path[PETSC_MAX_PATH_LEN])
{
  static const char *const places[] = {"share/talus/scripts/plot.py", "tools/plot.py", "scripts/plot.py"};

  MpmFileFindBeside((PetscInt)PETSC_STATIC_ARRAY_LENGTH(places), places, path);
}

int MpmCommandCall(char *const words[], PetscBool silent)
{
  int         status = 0;
  const pid_t child  = fork();

  if (child < 0) return 127;
  if (!child) {
    const int nowhere = silent ? open("/dev/null", O_WRONLY) : -1;

    if (nowhere >= 0) {
      (void)dup2(nowhere, STDOUT_FILENO);
      (void)dup2(nowhere, STDERR_FILENO);
    }
    (void)execvp(words[0], words);
    _exit(127);
  }
  while (waitpid(child, &status, 0) < 0)
    if (errno != EINTR) return 127;
  return WIFEXITED(status) ? WEXITSTATUS(status) : 1;
}

/* A Python that has all packages; NULL where there is none. */
static const char *FindPython(void)
{
  const char *named        = getenv("TALUS_PYTHON");
  const char *candidates[] = {named && *named ? named : "python3", "/usr/bin/python3"};

  for (int k = 0; k < (named && *named ? 1 : 2); k++) {
    char *const words[] = {(char *)candidates[k], (char *)"-c", (char *)needs, NULL};

    if (!MpmCommandCall(words, PETSC_TRUE)) return candidates[k];
  }
  return NULL;
}

/* Script and Python for a command; 0, or the exit status after a line on stderr. */
static int Find(const char command[], char script[PETSC_MAX_PATH_LEN], const char **python)
{
  char text[32];

  FindScript(script);
  *python = script[0] ? FindPython() : NULL;
  if (!script[0]) (void)fprintf(stderr, "talus: error: %s: no script plot.py beside the program\n", command);
  else if (!*python) {
    (void)fprintf(stderr,
                  "talus: error: %s needs Python 3 with numpy, h5py, matplotlib and pillow; the environment variable "
                  "TALUS_PYTHON names one\n",
                  command);
  }
  (void)snprintf(text, sizeof(text), "talus %s", command);
  return *python && !setenv("TALUS_COMMAND", text, 1) ? 0 : 1;
}

PetscBool MpmScriptNamed(int argc, char **argv)
{
  return (PetscBool)(argc > 1 && (!strcmp(argv[1], "plot") || !strcmp(argv[1], "view")));
}

int MpmScriptRun(int argc, char **argv)
{
  char        script[PETSC_MAX_PATH_LEN];
  const char *python;
  char      **words = (char **)calloc((size_t)argc + 2, sizeof(char *));

  if (!words || Find(argv[1], script, &python)) {
    free(words);
    return 1;
  }
  words[0] = (char *)python;
  words[1] = script;
  for (int i = 2; i < argc; i++) words[i] = argv[i];
  (void)execvp(python, words);
  (void)fprintf(stderr, "talus: error: %s cannot be started: %s\n", python, strerror(errno));
  free(words);
  return 1;
}

int MpmScriptDraw(const char prefix[], const char picture[])
{
  char        script[PETSC_MAX_PATH_LEN];
  const char *python;

  if (Find("check --picture", script, &python)) return 1;
  char *const words[] = {(char *)python,  script, (char *)prefix, (char *)"--scene", (char *)"--output",
                         (char *)picture, NULL};
  return MpmCommandCall(words, PETSC_FALSE);
}

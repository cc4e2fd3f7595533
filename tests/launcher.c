/*
  Runs the program again and again in forked processes. Its libraries, over a hundred with PETSc, are loaded and
  relocated once instead of for each run, half of the time of a short run.

  A request on standard input is a number of words and the words, each of these ended by a zero byte: folder, file for
  the output, file for the errors, number of settings of the environment, the settings NAME=VALUE, command line. The
  answer is one line with the exit status, negative for a signal.
*/
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

int MpmProgram(int argc, char **argv); /* main() of the program */

static char *ReadWord(void)
{
  char  *word   = NULL;
  size_t length = 0;

  return getdelim(&word, &length, 0, stdin) > 0 ? word : NULL;
}

static void Redirect(const char path[], int to)
{
  const int file = open(path, O_WRONLY | O_CREAT | O_TRUNC, 0600);

  if (file < 0 || dup2(file, to) < 0) _exit(127);
  (void)close(file);
}

/* One run, in the process of its own. */
static int RunProgram(int count, char **words)
{
  const int settings = atoi(words[3]), nothing = open("/dev/null", O_RDONLY);
  char    **line = &words[4 + settings];

  (void)prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (chdir(words[0]) || nothing < 0 || dup2(nothing, STDIN_FILENO) < 0) _exit(127);
  Redirect(words[1], STDOUT_FILENO);
  Redirect(words[2], STDERR_FILENO);
  for (int k = 0; k < settings; k++) (void)putenv(words[4 + k]);
  return MpmProgram(count - 4 - settings, line);
}

int main(void)
{
  char *number;

  while ((number = ReadWord())) {
    const int count = atoi(number);
    char    **words = calloc((size_t)count + 1, sizeof(char *));
    int       status;
    pid_t     process;

    if (!words) return 1;
    for (int k = 0; k < count; k++) words[k] = ReadWord();
    process = fork();
    if (process < 0) return 1;
    if (!process) exit(RunProgram(count, words));
    (void)waitpid(process, &status, 0);
    (void)printf("%d\n", WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status));
    (void)fflush(stdout);
    for (int k = 0; k < count; k++) free(words[k]);
    free(words);
    free(number);
  }
  return 0;
}
